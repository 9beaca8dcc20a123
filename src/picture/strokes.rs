//! A layer from above: every bead as a round-ended stroke of its own width.

use super::{BACKGROUND, downsample};
use crate::lattice::Point2;
use crate::path::Role;
use image::{Rgb, RgbImage};

const SUPERSAMPLING: u32 = 3;

/// One extruded line as it is drawn.
#[derive(Clone, Debug)]
pub struct Stroke {
    /// Centre line \[nm\].
    pub points: Vec<Point2>,
    /// Full width \[nm\].
    pub width: f64,
    /// Colour.
    pub color: [u8; 3],
}

/// The colour of a role, near to what G-code viewers commonly show.
pub fn color(role: Role) -> [u8; 3] {
    match role {
        Role::ExternalPerimeter | Role::OverhangPerimeter => [255, 125, 56],
        Role::Perimeter | Role::GapFill => [255, 202, 88],
        Role::InternalInfill => [177, 48, 41],
        Role::SolidInfill | Role::BridgeInfill => [150, 84, 204],
        Role::TopSolidInfill | Role::Ironing => [240, 64, 64],
        Role::SupportMaterial => [0, 168, 0],
        Role::SupportInterface => [0, 96, 48],
        Role::Skirt | Role::WipeTower | Role::Custom => [0, 135, 150],
    }
}

/// Draws strokes in order, scaled to fill the picture but for a margin, y upwards.
pub fn render(strokes: &[Stroke], width: u32, height: u32) -> RgbImage {
    let (w, h) = (width * SUPERSAMPLING, height * SUPERSAMPLING);
    let mut image = RgbImage::from_pixel(w, h, BACKGROUND);
    let Some((lo, hi)) = bounds(strokes) else { return downsample(&image, SUPERSAMPLING) };
    let size = ((hi.0 - lo.0).max(1.0), (hi.1 - lo.1).max(1.0));
    let scale = 0.9 * (f64::from(w) / size.0).min(f64::from(h) / size.1);
    let to_pixel = |p: Point2| {
        (
            f64::from(w) / 2.0 + (f64::from(p.x) - (lo.0 + hi.0) / 2.0) * scale,
            f64::from(h) / 2.0 - (f64::from(p.y) - (lo.1 + hi.1) / 2.0) * scale,
        )
    };
    for stroke in strokes {
        // A little thinner than the bead, so that neighbours can be told apart.
        let radius = stroke.width * scale * 0.5 * 0.86;
        for pair in stroke.points.windows(2) {
            capsule(&mut image, to_pixel(pair[0]), to_pixel(pair[1]), radius, Rgb(stroke.color));
        }
    }
    downsample(&image, SUPERSAMPLING)
}

/// Fills all pixels whose centre lies within `r` of the line from `a` to `b`.
fn capsule(image: &mut RgbImage, a: (f64, f64), b: (f64, f64), r: f64, color: Rgb<u8>) {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let length2 = (dx * dx + dy * dy).max(1e-12);
    let clamp = |v: f64, max: u32| (v.max(0.0) as u32).min(max);
    for y in
        clamp((a.1.min(b.1) - r).floor(), image.height())..clamp((a.1.max(b.1) + r).ceil(), image.height())
    {
        for x in
            clamp((a.0.min(b.0) - r).floor(), image.width())..clamp((a.0.max(b.0) + r).ceil(), image.width())
        {
            let (px, py) = (f64::from(x) + 0.5 - a.0, f64::from(y) + 0.5 - a.1);
            let along = ((px * dx + py * dy) / length2).clamp(0.0, 1.0);
            let (ex, ey) = (px - along * dx, py - along * dy);
            if ex * ex + ey * ey <= r * r {
                image.put_pixel(x, y, color);
            }
        }
    }
}

fn bounds(strokes: &[Stroke]) -> Option<((f64, f64), (f64, f64))> {
    let mut points = strokes.iter().flat_map(|s| &s.points).map(|p| (f64::from(p.x), f64::from(p.y)));
    let first = points.next()?;
    Some(
        points.fold((first, first), |(lo, hi), p| {
            ((lo.0.min(p.0), lo.1.min(p.1)), (hi.0.max(p.0), hi.1.max(p.1)))
        }),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stroke_covers_its_own_area() {
        let line =
            Stroke { points: vec![Point2::new(0, 0), Point2::new(10_000, 0)], width: 2000.0, color: [0; 3] };
        let picture = render(&[line], 100, 100);
        let dark = picture.pixels().filter(|p| p.0[0] < 128).count() as f64;
        // 90 pixels long, 0.2 x 0.86 of that wide, with round ends that lie outside the bounds.
        let (length, radius) = (90.0, 90.0 * 0.2 * 0.86 / 2.0);
        let cut = 2.0 * length / 2.0 * 2.0 * radius + std::f64::consts::PI * radius * radius;
        assert!((dark - cut).abs() < 0.1 * cut, "{dark} pixels for {cut:.0}");
        assert!(render(&[], 8, 8).pixels().all(|p| *p == BACKGROUND));
    }
}
