//! Islands made by hand.

use crate::contour::{ExPolygon, Ring};
use crate::infill::FillLayer;
use crate::lattice::Point2;
use crate::region::Island;
use crate::settings::Settings;

/// Thickness of the tests' layers \[nm\].
pub const HEIGHT: i64 = 200_000;

/// Settings with layers of [`HEIGHT`], no line width of its own for the first layer and no growth of skins.
pub fn settings() -> Settings {
    let mut s = Settings::default();
    s.slicing.layer_height = HEIGHT as f64 * 1e-6;
    s.slicing.first_layer_height = crate::settings::FloatOrPercent::Percent(100.0);
    s.widths.first_layer_extrusion_width = crate::settings::FloatOrPercent::Float(0.0);
    s.widths.extrusion_width = crate::settings::FloatOrPercent::Float(0.45);
    s.infill.solid_infill_below_area = 0.0;
    s.infill.external_infill_margin = 0.0;
    s
}

/// A point \[mm\].
pub fn at(x: f64, y: f64) -> Point2 {
    Point2::new((x * 1e6).round() as i32, (y * 1e6).round() as i32)
}

/// A counter-clockwise square about (x, y) \[mm\].
pub fn square(x: f64, y: f64, side: f64) -> Ring {
    let h = side / 2.0;
    vec![at(x - h, y - h), at(x + h, y - h), at(x + h, y + h), at(x - h, y + h)]
}

/// A counter-clockwise regular polygon about (x, y) \[mm\].
pub fn circle(x: f64, y: f64, radius: f64, corners: usize) -> Ring {
    (0..corners)
        .map(|i| {
            let (s, c) = libm::sincos(i as f64 * std::f64::consts::TAU / corners as f64);
            at(x + radius * c, y + radius * s)
        })
        .collect()
}

/// An island without walls: its infill reaches its outline. Holes are given counter-clockwise.
pub fn island(contour: Ring, holes: Vec<Ring>) -> Island {
    let holes = holes.into_iter().map(|h| h.into_iter().rev().collect()).collect();
    let outline = ExPolygon { contour, holes };
    Island { infill: vec![outline.clone()], outline, ..Island::default() }
}

/// Layers of equal height.
pub fn stack(layers: &[Vec<Island>]) -> Vec<FillLayer<'_>> {
    (0i64..)
        .zip(layers)
        .map(|(i, islands)| FillLayer { islands, print_z: (i + 1) * HEIGHT, height: HEIGHT })
        .collect()
}
