//! The built-in models: what is hard for a slicer, each in its own way.

use crate::mesh::{Mesh, shapes};
use std::f64::consts::TAU;

/// How a model is cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Planes {
    /// At this distance \[mm\].
    Height(f64),
    /// By so many planes at even distances.
    Count(u32),
}

/// A model made by code.
pub struct Model {
    /// Its name.
    pub name: &'static str,
    /// What it is hard on.
    pub about: &'static str,
    planes: Planes,
    /// The planes of the small variant.
    quick_planes: Planes,
    /// Builds it; the argument divides its numbers of facets around and along.
    make: fn(usize) -> Mesh,
}

impl Model {
    /// The mesh and how it is cut; `quick` makes a small one.
    pub fn build(&self, quick: bool) -> (Mesh, Planes) {
        if quick { ((self.make)(10), self.quick_planes) } else { ((self.make)(1), self.planes) }
    }
}

const PRINT: Planes = Planes::Height(0.2);
const COARSE: Planes = Planes::Height(1.0);

/// All of them.
pub const ALL: &[Model] = &[
    Model {
        name: "knot",
        about: "a million small facets, few planes each",
        planes: PRINT,
        quick_planes: COARSE,
        make: knot,
    },
    Model {
        name: "sphere",
        about: "a million facets in even rings",
        planes: PRINT,
        quick_planes: COARSE,
        make: |by| shapes::sphere(40.0, 1000 / by, 501 / by),
    },
    Model {
        name: "pins",
        about: "1,600 contours on every plane",
        planes: PRINT,
        quick_planes: COARSE,
        make: |by| pins(40 / by),
    },
    Model {
        name: "tall-cylinder",
        about: "50,000 facets through every plane",
        planes: PRINT,
        quick_planes: COARSE,
        make: |by| shapes::cylinder(20.0, 200.0, 25_000 / by),
    },
    Model {
        name: "comb",
        about: "overlapping boxes, facets on planes",
        planes: PRINT,
        quick_planes: COARSE,
        make: |_| comb(),
    },
    Model {
        name: "organic",
        about: "38 k facets under 6,242 planes: many planes each",
        planes: Planes::Count(6242),
        quick_planes: Planes::Count(320),
        make: organic,
    },
    Model {
        name: "tilted-torus",
        about: "a million facets, many of them steep, under 2,349 planes",
        planes: Planes::Count(2349),
        quick_planes: Planes::Count(240),
        make: tilted_torus,
    },
];

/// A (2, 3) torus knot with a rippled surface.
fn knot(by: usize) -> Mesh {
    let (around, across) = (2500 / by, 200 / by);
    let centre = |t: f64| {
        let r = 30.0 + 12.0 * libm::cos(3.0 * t);
        [r * libm::cos(2.0 * t), r * libm::sin(2.0 * t), -19.2 * libm::sin(3.0 * t)]
    };
    grid(around, across, |u, v| {
        let (t, a) = (TAU * u, -TAU * v);
        let (c, ahead) = (centre(t), centre(t + 1e-5));
        let tangent = unit([0, 1, 2].map(|k| ahead[k] - c[k]));
        let outwards = unit([c[0], c[1], 0.0]);
        let along = dot(outwards, tangent);
        let normal = unit([0, 1, 2].map(|k| outwards[k] - along * tangent[k]));
        let binormal = cross(tangent, normal);
        let r = 6.0 * (1.0 + 0.03 * libm::sin(12.0 * a) * libm::sin(200.0 * t));
        let (cos, sin) = (r * libm::cos(a), r * libm::sin(a));
        [0, 1, 2].map(|k| c[k] + cos * normal[k] + sin * binormal[k])
    })
}

/// A square of `side` × `side` thin pillars.
fn pins(side: usize) -> Mesh {
    let pin = |i: usize| {
        let (x, y) = (3.0 * (i % side) as f64, 3.0 * (i / side) as f64);
        shapes::cuboid([x, y, 0.0], [x + 0.9, y + 0.9, 60.0])
    };
    shapes::merge(&(0..side * side).map(pin).collect::<Vec<_>>())
}

/// A base, thin walls, a bridge, a narrow slot and steps that overhang, overlapping by half a
/// millimetre.
fn comb() -> Mesh {
    let mut boxes = vec![shapes::cuboid([0.0; 3], [80.0, 40.0, 3.0])];
    for (k, width) in [0.4, 0.45, 0.6, 0.8, 0.9, 1.0, 1.2].into_iter().enumerate() {
        let x = 4.0 + 6.0 * k as f64;
        boxes.push(shapes::cuboid([x, 4.0, 2.5], [x + width, 20.0, 15.0]));
    }
    for (min, max) in [
        ([4.0, 26.0, 2.5], [10.0, 36.0, 15.0]),
        ([40.0, 26.0, 2.5], [46.0, 36.0, 15.0]),
        ([4.0, 26.0, 14.5], [46.0, 36.0, 17.0]),
        ([52.0, 4.0, 2.5], [57.85, 36.0, 12.0]),
        ([58.15, 4.0, 2.5], [64.0, 36.0, 12.0]),
    ] {
        boxes.push(shapes::cuboid(min, max));
    }
    for k in 0..5 {
        let step = f64::from(k);
        boxes
            .push(shapes::cuboid([66.0, 4.0, 2.5 + 4.0 * step], [70.0 + 2.0 * step, 36.0, 7.0 + 4.0 * step]));
    }
    shapes::merge(&boxes)
}

/// A lobed body without flat or straight places, its poles lying on their side.
fn organic(by: usize) -> Mesh {
    let (around, rings) = (139 / by, 139 / by);
    globe(around, rings, |theta, phi| {
        let belt = libm::sin(phi) * libm::sin(phi);
        let r = 80.0
            * (1.0
                + 0.22 * belt * libm::sin(5.0 * theta)
                + 0.12 * belt * libm::sin(3.0 * theta + 6.0 * phi)
                + 0.08 * libm::cos(7.0 * phi));
        let flat = r * libm::sin(phi);
        [-1.3 * r * libm::cos(phi), flat * libm::cos(theta), flat * libm::sin(theta)]
    })
}

/// A torus leaning by 45 degrees.
fn tilted_torus(by: usize) -> Mesh {
    let tilt = TAU / 8.0;
    let (c, s) = (libm::cos(tilt), libm::sin(tilt));
    grid(1000 / by, 500 / by, |u, v| {
        let r = 39.0 + 10.0 * libm::cos(TAU * v);
        let (x, y, z) = (r * libm::cos(TAU * u), r * libm::sin(TAU * u), 10.0 * libm::sin(TAU * v));
        [x, y * c - z * s, y * s + z * c]
    })
}

/// A closed surface over a torus grid; `point` takes both parameters from 0 to 1 and turns outwards as
/// they do.
fn grid(around: usize, across: usize, point: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let points: Vec<[f64; 3]> = (0..around * across)
        .map(|i| point((i / across) as f64 / around as f64, (i % across) as f64 / across as f64))
        .collect();
    let at = |i: usize, j: usize| ((i % around) * across + j % across) as u32;
    let mut triangles = Vec::with_capacity(2 * around * across);
    for i in 0..around {
        for j in 0..across {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    shapes::from_points(&points, triangles)
}

/// A closed surface over a globe: `point` takes longitude and the angle from the first pole.
fn globe(around: usize, rings: usize, point: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let mut points = vec![point(0.0, 0.0), point(0.0, TAU / 2.0)];
    for ring in 1..rings {
        let phi = TAU / 2.0 * ring as f64 / rings as f64;
        points.extend((0..around).map(|i| point(TAU * i as f64 / around as f64, phi)));
    }
    let at = |ring: usize, i: usize| (2 + (ring - 1) * around + i % around) as u32;
    let mut triangles = Vec::with_capacity(2 * around * (rings - 1));
    for i in 0..around {
        triangles.push([0, at(1, i + 1), at(1, i)]);
        triangles.push([1, at(rings - 1, i), at(rings - 1, i + 1)]);
    }
    for ring in 1..rings - 1 {
        for i in 0..around {
            let (a, b, c, d) = (at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    shapes::from_points(&points, triangles)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = dot(a, a).sqrt();
    a.map(|c| c / length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Adjacency, audit};

    #[test]
    fn every_model_is_closed_and_faces_outwards() {
        for model in ALL {
            let (mesh, _) = model.build(true);
            let report = audit(&mesh, &Adjacency::build(&mesh));
            let faults = (report.open_edges, report.over_shared_edges, report.flipped_edges);
            assert_eq!(faults, (0, 0, 0), "{}", model.name);
            assert!(report.volume_mm3 > 100.0, "{}: {}", model.name, report.volume_mm3);
        }
    }

    #[test]
    fn the_large_ones_have_the_size_they_claim() {
        let size = |name: &str| {
            let model = ALL.iter().find(|m| m.name == name);
            model.map_or(0, |m| m.build(false).0.triangles.len())
        };
        assert_eq!(size("pins"), 19_200);
        assert_eq!(size("comb"), 216);
        assert_eq!(size("tall-cylinder"), 100_000);
        assert!((38_000..39_000).contains(&size("organic")));
    }
}
