//! A shaded view of a mesh: orthographic, flat facets, depth buffer.

use super::{BACKGROUND, downsample};
use crate::lattice::NM_PER_MM;
use crate::mesh::Mesh;
use glam::{DMat3, DVec3};
use image::{Rgb, RgbImage};

/// Pixels are drawn this much finer in each direction and then averaged.
const SUPERSAMPLING: u32 = 2;

/// Draws the mesh from the front right, a little above, filling the picture but for a margin.
///
/// Layers of `layer_height` \[mm\] show as fine bands when it is given.
pub fn render(mesh: &Mesh, width: u32, height: u32, layer_height: Option<f64>) -> RgbImage {
    let (w, h) = (width * SUPERSAMPLING, height * SUPERSAMPLING);
    let view = camera();
    let points: Vec<DVec3> =
        mesh.vertices.iter().map(|v| DVec3::new(v.x.into(), v.y.into(), v.z.into()) / NM_PER_MM).collect();
    let seen: Vec<DVec3> = points.iter().map(|p| view * *p).collect();
    let mut image = RgbImage::from_pixel(w, h, BACKGROUND);
    let Some((lo, hi)) = bounds(&seen) else { return downsample(&image, SUPERSAMPLING) };
    let size = (hi - lo).max(DVec3::splat(1e-9));
    let scale = 0.88 * (f64::from(w) / size.x).min(f64::from(h) / size.y);
    let middle = (lo + hi) / 2.0;
    let to_pixel = |p: DVec3| {
        let q = (p - middle) * scale;
        DVec3::new(f64::from(w) / 2.0 + q.x, f64::from(h) / 2.0 - q.y, q.z)
    };
    let mut depth = vec![f64::NEG_INFINITY; (w * h) as usize];
    for t in &mesh.triangles {
        let corner = t.map(|v| points[v as usize]);
        let normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]).normalize_or_zero();
        let facing = view * normal;
        if facing.z <= 0.0 {
            continue;
        }
        let shade = shade(normal);
        let pixel = t.map(|v| to_pixel(seen[v as usize]));
        raster(pixel, corner.map(|c| c.z), (w, h), |index, z_depth, z_mm| {
            if z_depth > depth[index] {
                depth[index] = z_depth;
                let band = layer_height.map_or(1.0, |lh| {
                    let share = (z_mm / lh).fract();
                    if share < 0.25 && normal.z.abs() < 0.99 { 0.93 } else { 1.0 }
                });
                let (x, y) = (index as u32 % w, index as u32 / w);
                image.put_pixel(x, y, Rgb(shade.map(|c| (c * band) as u8)));
            }
        });
    }
    downsample(&image, SUPERSAMPLING)
}

/// World to view: x right, y up, z towards the eye. Turned 35 degrees about z, raised 30 degrees;
/// the sines are written out so that no platform's trigonometry is involved.
fn camera() -> DMat3 {
    let (sin_turn, cos_turn) = (0.573_576_436_351_046, 0.819_152_044_288_992);
    let (sin_rise, cos_rise) = (0.5, 0.866_025_403_784_439);
    let right = DVec3::new(cos_turn, sin_turn, 0.0);
    let towards_eye = DVec3::new(sin_turn * cos_rise, -cos_turn * cos_rise, sin_rise);
    let up = towards_eye.cross(right);
    DMat3::from_cols(right, up, towards_eye).transpose()
}

/// Colour of a facet by its world normal: a warm orange under a light from the upper left front.
fn shade(normal: DVec3) -> [f64; 3] {
    let light = DVec3::new(-0.35, -0.6, 0.72).normalize();
    let lit = 0.42 + 0.58 * normal.dot(light).max(0.0);
    [255.0 * lit, 138.0 * lit, 46.0 * lit]
}

fn bounds(points: &[DVec3]) -> Option<(DVec3, DVec3)> {
    let first = *points.first()?;
    Some(points.iter().fold((first, first), |(lo, hi), p| (lo.min(*p), hi.max(*p))))
}

/// Calls `plot(pixel index, depth, world z)` for every pixel centre inside the triangle.
fn raster(p: [DVec3; 3], z_mm: [f64; 3], (w, h): (u32, u32), mut plot: impl FnMut(usize, f64, f64)) {
    let area = (p[1] - p[0]).cross(p[2] - p[0]).z;
    if area == 0.0 {
        return;
    }
    let lo = p[0].min(p[1]).min(p[2]).floor().max(DVec3::ZERO);
    let hi = p[0].max(p[1]).max(p[2]).ceil();
    for y in lo.y as u32..(hi.y.max(0.0) as u32).min(h) {
        for x in lo.x as u32..(hi.x.max(0.0) as u32).min(w) {
            let q = DVec3::new(f64::from(x) + 0.5, f64::from(y) + 0.5, 0.0);
            let weight = |a: usize, b: usize| (p[b] - p[a]).cross(q - p[a]).z / area;
            let (u, v, s) = (weight(1, 2), weight(2, 0), weight(0, 1));
            if u >= 0.0 && v >= 0.0 && s >= 0.0 {
                let mix = |a: [f64; 3]| u * a[0] + v * a[1] + s * a[2];
                plot((y * w + x) as usize, mix(p.map(|c| c.z)), mix(z_mm));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Point3;

    #[test]
    fn a_facet_that_faces_the_eye_is_drawn_and_one_that_does_not_is_not() {
        let vertices = [(0, 0), (20_000_000, 0), (0, 20_000_000)].map(|(x, y)| Point3::new(x, y, 0)).to_vec();
        let mut mesh = Mesh { vertices, triangles: vec![[0, 1, 2]], origin: [0; 3] };
        let drawn = |m: &Mesh| render(m, 64, 64, None).pixels().filter(|p| **p != BACKGROUND).count();
        assert!(drawn(&mesh) > 200);
        mesh.triangles = vec![[0, 2, 1]];
        assert_eq!(drawn(&mesh), 0);
        assert_eq!(drawn(&Mesh::default()), 0);
    }
}
