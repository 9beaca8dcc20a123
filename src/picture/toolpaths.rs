//! A planned layer as strokes.

use super::strokes::{Stroke, color};
use crate::lattice::NM_PER_MM;
use crate::path::{LayerPlan, Role};

/// The extrusions of a layer, each as wide as its bead and in the colour of its role; infill lies beneath
/// the walls, so that these can be followed.
pub fn strokes(layer: &LayerPlan) -> Vec<Stroke> {
    let mut extrusions: Vec<_> = layer.extrusions.iter().collect();
    extrusions.sort_by_key(|e| match e.role {
        Role::InternalInfill => 0,
        Role::SolidInfill | Role::TopSolidInfill | Role::BridgeInfill | Role::Ironing => 1,
        Role::GapFill => 2,
        _ => 3,
    });
    let stroke =
        |e| Stroke { points: layer.path(e).to_vec(), width: e.width * NM_PER_MM, color: color(e.role) };
    extrusions.into_iter().map(stroke).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Point2;
    use crate::path::Extrusion;

    #[test]
    fn every_bead_is_drawn_in_its_width_and_colour() {
        let roles = [Role::ExternalPerimeter, Role::GapFill, Role::InternalInfill];
        let extrusion = |(i, role): (usize, Role)| Extrusion {
            role,
            points: 2 * i as u32..2 * i as u32 + 2,
            width: 0.3 + 0.1 * i as f64,
            height: 0.2,
            mm3_per_mm: 0.08,
            speed: 60.0,
            length: 1.0,
            retract: false,
            fan: None,
        };
        let layer = LayerPlan {
            extrusions: roles.into_iter().enumerate().map(extrusion).collect(),
            points: (0..6).map(|i| Point2::new(i * 1_000_000, 0)).collect(),
            ..LayerPlan::default()
        };
        let strokes = strokes(&layer);
        let widths: Vec<_> = strokes.iter().map(|s| s.width.round() as i64).collect();
        assert_eq!(widths, [500_000, 400_000, 300_000]);
        assert_eq!(strokes[2].color, color(Role::ExternalPerimeter));
        assert_eq!(strokes[2].points, [Point2::new(0, 0), Point2::new(1_000_000, 0)]);
    }
}
