//! Pictures against areas; the texts are read back by the command-line tests.
#![allow(clippy::unwrap_used)]

use super::png::{PictureError, Raster};
use super::*;
use crate::lattice::Point2;

fn ring(points: &[(i32, i32)]) -> Ring {
    points.iter().map(|&(x, y)| Point2::new(x, y)).collect()
}

fn drawing<'a>(rings: &'a [Ring], offset: [i64; 2]) -> Drawing<'a> {
    let frame = Frame { u: [1.0, 0.0, 0.0], v: [0.0, 1.0, 0.0], n: [0.0, 0.0, 1.0], origin: [0.0; 3] };
    let sheet = Sheet { z: 100_000, top: 200_000, height: 200_000, rings, open: OpenReport::default() };
    Drawing { model: "a<b>&\"c\"", sheets: vec![sheet], offset, frame }
}

/// White pixels, by counting centres inside the winding number of every ring, one pixel at a time.
fn inside(raster: &Raster, rings: &[Ring], offset: [i64; 2]) -> Vec<bool> {
    let [w, h] = raster.size.map(i64::from);
    let centre =
        |k: i64, axis: usize| 2 * ((raster.low[axis] + k) * raster.pixel - offset[axis]) + raster.pixel;
    let winding = |x: i64, y: i64| {
        let mut turns = 0;
        for ring in rings {
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let [ax, ay, bx, by] = [a.x, a.y, b.x, b.y].map(|c| 2 * i64::from(c));
                let side =
                    i128::from(bx - ax) * i128::from(y - ay) - i128::from(x - ax) * i128::from(by - ay);
                if ay <= y && by > y && side > 0 {
                    turns += 1;
                } else if ay > y && by <= y && side < 0 {
                    turns -= 1;
                }
            }
        }
        turns != 0
    };
    (0..h)
        .rev()
        .flat_map(|y| (0..w).map(move |x| (x, y)))
        .map(|(x, y)| winding(centre(x, 0), centre(y, 1)))
        .collect()
}

#[test]
fn pictures_have_the_pixels_whose_centres_are_inside() {
    let rings = [
        ring(&[
            (-3_100_000, -2_000_000),
            (4_000_017, -2_300_000),
            (3_000_000, 5_000_001),
            (-1_000_000, 700_000),
        ]),
        ring(&[(0, 0), (500_000, 1_500_000), (1_500_000, 200_000)]),
    ];
    for (offset, scale) in [([0, 0], 10.0), ([100_000_123, -7_654_321], 7.0), ([-1, 1], 3.0)] {
        let drawing = drawing(&rings, offset);
        let raster = Raster::new(&drawing, scale).unwrap();
        let image = raster.draw(&drawing.sheets[0], offset);
        let white: Vec<bool> = image.pixels().map(|p| p.0[0] == 255).collect();
        let expected = inside(&raster, &rings, offset);
        let differing = white.iter().zip(&expected).filter(|(a, b)| a != b).count();
        assert!(differing <= 2, "{differing} pixels differ; crossings are rounded to the nanometre");
        assert!(expected.iter().filter(|w| **w).count() > 100);
    }
}

#[test]
fn pictures_without_reason_are_refused() {
    let rings = [ring(&[(0, 0), (1_000_000_000, 0), (1_000_000_000, 1_000_000_000)])];
    let drawing = drawing(&rings, [0, 0]);
    assert!(matches!(Raster::new(&drawing, 100.0), Err(PictureError::TooLarge { width: 100_000, .. })));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e9] {
        assert!(matches!(Raster::new(&drawing, bad), Err(PictureError::Scale(_))));
    }
}

#[test]
fn names_cannot_break_a_file() {
    let drawing = drawing(&[], [0, 0]);
    let mut text = Vec::new();
    svg::write(&drawing, &mut text).unwrap();
    assert!(String::from_utf8(text).unwrap().contains("<title>a&lt;b&gt;&amp;\"c\"</title>"));
    let mut text = Vec::new();
    json::write(&drawing, &mut text).unwrap();
    let value: serde_json::Value = serde_json::from_slice(&text).unwrap();
    assert_eq!(value["model"], "a<b>&\"c\"");
    assert_eq!(value["layers"][0]["area"], 0.0);
}
