//! Closed bodies made by code, for tests, benchmarks and the demo part.
//!
//! All lengths are millimetres. Triangles face outwards. Every mesh comes with its lattice's zero in
//! the middle of its bounds.

use super::Mesh;
use crate::lattice::{NM_PER_MM, Point3, nm};
use std::f64::consts::TAU;

/// A mesh from points \[mm\] and triangles. Coordinates beyond the lattice saturate; the shapes here are
/// for parts of ordinary size.
pub fn from_points(points: &[[f64; 3]], triangles: Vec<[u32; 3]>) -> Mesh {
    let world: Vec<[i64; 3]> = points.iter().map(|p| p.map(nm)).collect();
    let mut origin = [0; 3];
    for (axis, zero) in origin.iter_mut().enumerate() {
        let lo = world.iter().map(|p| p[axis]).min().unwrap_or(0);
        let hi = world.iter().map(|p| p[axis]).max().unwrap_or(0);
        *zero = lo + (hi - lo) / 2;
    }
    let limit = i64::from(crate::lattice::LIMIT) - 1;
    let local = |p: &[i64; 3], axis: usize| (p[axis] - origin[axis]).clamp(-limit, limit) as i32;
    let vertices = world.iter().map(|p| Point3::new(local(p, 0), local(p, 1), local(p, 2))).collect();
    Mesh { vertices, triangles, origin }
}

/// Several meshes as shells of one, vertices not shared. The zero moves into the middle of them all.
pub fn merge(parts: &[Mesh]) -> Mesh {
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    for part in parts {
        let base = points.len() as u32;
        triangles.extend(part.triangles.iter().map(|t| t.map(|v| v + base)));
        points.extend(part.vertices.iter().map(|v| {
            let [x, y, z] = part.origin;
            [x + i64::from(v.x), y + i64::from(v.y), z + i64::from(v.z)].map(|c| c as f64 / NM_PER_MM)
        }));
    }
    from_points(&points, triangles)
}

/// An axis-parallel box between two corners; 12 triangles.
pub fn cuboid(min: [f64; 3], max: [f64; 3]) -> Mesh {
    prism(&[[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]], min[2], max[2])
}

/// A regular tetrahedron standing on z = 0, centred on x = y = 0.
pub fn tetrahedron(edge: f64) -> Mesh {
    let r = edge / 3f64.sqrt();
    let points = [
        [r, 0.0, 0.0],
        [-r / 2.0, edge / 2.0, 0.0],
        [-r / 2.0, -edge / 2.0, 0.0],
        [0.0, 0.0, edge * (2.0f64 / 3.0).sqrt()],
    ];
    from_points(&points, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
}

/// A sphere standing on z = 0: `around` × (`rings` - 1) × 2 triangles. At least 3 around and 2 rings.
pub fn sphere(radius: f64, around: usize, rings: usize) -> Mesh {
    let rings = rings.max(2);
    let profile: Vec<[f64; 2]> = (0..=rings)
        .map(|k| {
            let angle = TAU / 2.0 * k as f64 / rings as f64;
            [radius * libm::sin(angle), radius - radius * libm::cos(angle)]
        })
        .collect();
    revolve(&profile, around)
}

/// A cylinder standing on z = 0: 4 × `around` triangles, two hubs.
pub fn cylinder(radius: f64, height: f64, around: usize) -> Mesh {
    revolve(&[[0.0, 0.0], [radius, 0.0], [radius, height], [0.0, height]], around)
}

/// A cone standing on z = 0: 2 × `around` triangles, two hubs.
pub fn cone(radius: f64, height: f64, around: usize) -> Mesh {
    revolve(&[[0.0, 0.0], [radius, 0.0], [0.0, height]], around)
}

/// Two flat fans back to back, a lens of `triangles` / 2 spokes on either side: every triangle touches
/// one of two hubs.
pub fn fan(triangles: usize) -> Mesh {
    revolve(&[[0.0, 0.0], [50.0, 5.0], [0.0, 10.0]], triangles / 2)
}

/// A torus standing on z = 0: 2 × `around` × `across` triangles.
pub fn torus(radius: f64, tube: f64, around: usize, across: usize) -> Mesh {
    tube_along(around, across, tube, |s| {
        let angle = TAU * s;
        [radius * libm::cos(angle), radius * libm::sin(angle), tube]
    })
}

/// A trefoil knot of a round tube, about 6 × `scale` wide, of at least `triangles` triangles.
pub fn knot(scale: f64, tube: f64, triangles: usize) -> Mesh {
    let across = (((triangles / 2) as f64 / 12.0).sqrt() as usize).max(6);
    let along = (triangles / 2).div_ceil(across).max(24);
    tube_along(along, across, tube, |s| {
        let a = TAU * s;
        [
            scale * (libm::sin(a) + 2.0 * libm::sin(2.0 * a)),
            scale * (libm::cos(a) - 2.0 * libm::cos(2.0 * a)),
            scale * (1.0 - libm::sin(3.0 * a)) + tube,
        ]
    })
}

/// A profile of (distance from the z axis, height) turned about the axis, from the lower pole to the
/// upper one; first and last distance are 0, the others positive.
pub fn revolve(profile: &[[f64; 2]], around: usize) -> Mesh {
    let n = around.max(3);
    let [first, middle @ .., last] = profile else { return Mesh::default() };
    let mut points = vec![[0.0, 0.0, first[1]], [0.0, 0.0, last[1]]];
    for [r, z] in middle {
        points.extend((0..n).map(|i| {
            let angle = TAU * i as f64 / n as f64;
            [r * libm::cos(angle), r * libm::sin(angle), *z]
        }));
    }
    let at = |ring: usize, i: usize| (2 + ring * n + i % n) as u32;
    let mut triangles = Vec::new();
    let rings = middle.len();
    for i in 0..n {
        triangles.push([0, at(0, i + 1), at(0, i)]);
    }
    for ring in 1..rings {
        for i in 0..n {
            let (a, b, c, d) = (at(ring - 1, i), at(ring - 1, i + 1), at(ring, i + 1), at(ring, i));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    for i in 0..n {
        triangles.push([1, at(rings - 1, i), at(rings - 1, i + 1)]);
    }
    from_points(&points, triangles)
}

/// A simple polygon without holes, counter-clockwise, raised from `z0` to `z1`.
pub fn prism(polygon: &[[f64; 2]], z0: f64, z1: f64) -> Mesh {
    let n = polygon.len() as u32;
    let points: Vec<[f64; 3]> =
        [z0, z1].iter().flat_map(|&z| polygon.iter().map(move |p| [p[0], p[1], z])).collect();
    let mut triangles = Vec::new();
    for [a, b, c] in ears(polygon) {
        triangles.extend([[a, c, b], [a + n, b + n, c + n]]);
    }
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([[i, j, j + n], [i, j + n, i + n]]);
    }
    from_points(&points, triangles)
}

/// A rectangle with a round hole of `sides` sides, raised from `z0` to `z1`. `hole`: centre and radius,
/// inside the rectangle.
pub fn holed_plate(
    min: [f64; 2],
    max: [f64; 2],
    hole: [f64; 2],
    radius: f64,
    sides: usize,
    z: [f64; 2],
) -> Mesh {
    let mut directions: Vec<[f64; 2]> = (0..sides.max(8))
        .map(|i| TAU * (i as f64 + 0.5) / sides.max(8) as f64)
        .map(|angle| [libm::cos(angle), libm::sin(angle)])
        .collect();
    for corner in [[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]] {
        let (x, y) = (corner[0] - hole[0], corner[1] - hole[1]);
        let length = (x * x + y * y).sqrt();
        directions.push([x / length, y / length]);
    }
    directions.sort_by(|a, b| libm::atan2(a[1], a[0]).total_cmp(&libm::atan2(b[1], b[0])));
    directions.dedup();
    let n = directions.len() as u32;
    // From the hole's centre to the rectangle: the nearest of the four sides on the way.
    let reach = |d: f64, c: f64, lo: f64, hi: f64| match d {
        d if d > 0.0 => (hi - c) / d,
        d if d < 0.0 => (lo - c) / d,
        _ => f64::MAX,
    };
    let mut points = Vec::new();
    for height in z {
        for d in &directions {
            let r = reach(d[0], hole[0], min[0], max[0]).min(reach(d[1], hole[1], min[1], max[1]));
            points.push([hole[0] + r * d[0], hole[1] + r * d[1], height]);
        }
        points.extend(directions.iter().map(|d| [hole[0] + radius * d[0], hole[1] + radius * d[1], height]));
    }
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        let mut quad = |a: u32, b: u32, c: u32, d: u32| triangles.extend([[a, b, c], [a, c, d]]);
        let (outer, inner, up) = (0, n, 2 * n);
        quad(outer + i, outer + j, outer + j + up, outer + i + up);
        quad(inner + j, inner + i, inner + i + up, inner + j + up);
        quad(outer + i + up, outer + j + up, inner + j + up, inner + i + up);
        quad(outer + j, outer + i, inner + i, inner + j);
    }
    from_points(&points, triangles)
}

/// A T, standing: a stem of 10 mm and a bar of 50 mm on it, 20 mm deep and 26 mm high.
pub fn tee() -> Mesh {
    let outline = [
        [-5.0, 0.0],
        [5.0, 0.0],
        [5.0, 20.0],
        [25.0, 20.0],
        [25.0, 26.0],
        [-25.0, 26.0],
        [-25.0, 20.0],
        [-5.0, 20.0],
    ];
    standing(&outline, 20.0)
}

/// A round arch, standing: two feet of 6 mm, an opening of 40 mm, 26 mm high and 15 mm deep.
pub fn arch() -> Mesh {
    let steps = 48;
    let opening = (0..=steps).rev().map(|i| {
        let angle = TAU / 2.0 * f64::from(i) / f64::from(steps);
        [20.0 * libm::cos(angle), 20.0 * libm::sin(angle)]
    });
    let mut outline = vec![[-26.0, 26.0], [-26.0, 0.0]];
    outline.extend(opening);
    outline.extend([[26.0, 0.0], [26.0, 26.0]]);
    standing(&outline, 15.0)
}

/// A spiral stair: `steps` steps, each 3 mm higher than the one before, around a column of 10 mm.
/// Shells that overlap.
pub fn stair(steps: usize) -> Mesh {
    let mut parts = vec![cylinder(5.0, 3.0 * steps as f64 + 3.0, 64)];
    let turn = TAU / steps.max(1) as f64;
    for k in 0..steps {
        let from = turn * k as f64;
        let arc = |r: f64, i: usize| {
            let angle = from + 1.2 * turn * i as f64 / 6.0;
            [r * libm::cos(angle), r * libm::sin(angle)]
        };
        let outline: Vec<_> =
            (0..=6).map(|i| arc(20.0, i)).chain((0..=6).rev().map(|i| arc(4.5, i))).collect();
        let z = 3.0 * k as f64;
        parts.push(prism(&outline, z, z + 3.0));
    }
    merge(&parts)
}

/// A blunt cone on its tip: radius `tip` on the bed, `radius` at `height`.
pub fn cone_down(tip: f64, radius: f64, height: f64, around: usize) -> Mesh {
    revolve(&[[0.0, 0.0], [tip, 0.0], [radius, height], [0.0, height]], around)
}

/// An outline in x and z, counter-clockwise seen from the front (-y), from y = 0 to `depth`.
fn standing(outline: &[[f64; 2]], depth: f64) -> Mesh {
    moved(upright(&prism(outline, 0.0, depth)), [0.0, depth, 0.0])
}

/// Upright: x stays, height becomes depth (y), depth becomes height (z). A prism drawn in x, z and
/// extruded along y is drawn in x, y and then turned. Keeps the outside outside.
pub fn upright(mesh: &Mesh) -> Mesh {
    let turn = |c: [i64; 3]| [c[0], -c[2], c[1]];
    let vertices = mesh.vertices.iter().map(|v| Point3::new(v.x, -v.z, v.y)).collect();
    Mesh { vertices, triangles: mesh.triangles.clone(), origin: turn(mesh.origin) }
}

/// A mesh moved by a vector \[mm\]; only its origin changes.
pub fn moved(mut mesh: Mesh, by: [f64; 3]) -> Mesh {
    for (c, d) in mesh.origin.iter_mut().zip(by) {
        *c += nm(d);
    }
    mesh
}

/// A closed tube about a closed curve `centre`(0..1), its cross-section turned so that it meets itself.
fn tube_along(along: usize, across: usize, tube: f64, centre: impl Fn(f64) -> [f64; 3]) -> Mesh {
    let (along, across) = (along.max(3), across.max(3));
    let mut points = Vec::with_capacity(along * across);
    for i in 0..along {
        let s = i as f64 / along as f64;
        let (before, here, after) = (centre(s - 1e-4), centre(s), centre(s + 1e-4));
        let tangent = unit([0, 1, 2].map(|k| after[k] - before[k]));
        // Neither curve runs straight up, so this frame never degenerates and closes on itself.
        let side = unit(cross(tangent, [0.0, 0.0, 1.0]));
        let up = cross(side, tangent);
        for j in 0..across {
            let angle = TAU * j as f64 / across as f64;
            let (c, s) = (tube * libm::cos(angle), tube * libm::sin(angle));
            points.push([0, 1, 2].map(|k| here[k] + c * side[k] + s * up[k]));
        }
    }
    let at = |i: usize, j: usize| ((i % along) * across + j % across) as u32;
    let mut triangles = Vec::with_capacity(2 * along * across);
    for i in 0..along {
        for j in 0..across {
            let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    from_points(&points, triangles)
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
    a.map(|c| c / length)
}

/// Triangles of a simple counter-clockwise polygon by ear clipping (Meisters 1975). Quadratic and
/// worse; for drawings of a few dozen corners.
fn ears(polygon: &[[f64; 2]]) -> Vec<[u32; 3]> {
    let turn = |a: u32, b: u32, c: u32| {
        let [a, b, c] = [a, b, c].map(|i| polygon[i as usize]);
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let mut left: Vec<u32> = (0..polygon.len() as u32).collect();
    let mut triangles = Vec::new();
    while left.len() > 3 {
        let n = left.len();
        let ear = (0..n).find(|&i| {
            let (a, b, c) = (left[(i + n - 1) % n], left[i], left[(i + 1) % n]);
            let empty = left.iter().all(|&p| {
                [a, b, c].contains(&p) || turn(a, b, p) < 0.0 || turn(b, c, p) < 0.0 || turn(c, a, p) < 0.0
            });
            turn(a, b, c) > 0.0 && empty
        });
        // A polygon that is not simple has no ear: give up on the rest, the audit will tell.
        let Some(i) = ear else { return triangles };
        triangles.push([left[(i + n - 1) % n], left[i], left[(i + 1) % n]]);
        left.remove(i);
    }
    if let [a, b, c] = left[..] {
        triangles.push([a, b, c]);
    }
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{Adjacency, audit};

    #[test]
    fn every_shape_is_one_closed_shell_that_faces_outwards() {
        let shapes = [
            ("cuboid", cuboid([-1.0, 2.0, 3.0], [4.0, 5.0, 6.5]), 5.0 * 3.0 * 3.5),
            ("tetrahedron", tetrahedron(10.0), 1000.0 / (6.0 * 2f64.sqrt())),
            ("sphere", sphere(10.0, 200, 100), TAU / 1.5 * 1000.0),
            ("cylinder", cylinder(5.0, 7.0, 300), TAU / 2.0 * 25.0 * 7.0),
            ("cone", cone(5.0, 9.0, 300), TAU / 2.0 * 25.0 * 3.0),
            ("fan", fan(600), TAU / 2.0 * 2500.0 * 10.0 / 3.0),
            ("torus", torus(10.0, 2.0, 200, 100), TAU * 10.0 * TAU / 2.0 * 4.0),
            ("tee", tee(), 20.0 * (200.0 + 300.0)),
            ("arch", arch(), 15.0 * (52.0 * 26.0 - TAU / 4.0 * 400.0)),
            ("blunt cone", cone_down(3.0, 22.0, 15.0, 300), TAU / 2.0 * 5.0 * (9.0 + 66.0 + 484.0)),
            ("plate", holed_plate([0.0, 0.0], [9.0, 5.0], [3.0, 2.0], 1.0, 200, [0.0, 2.0]), 90.0 - TAU),
        ];
        for (name, mesh, volume) in shapes {
            let report = audit(&mesh, &Adjacency::build(&mesh));
            let clean = (report.open_edges, report.over_shared_edges, report.flipped_edges, report.shells);
            assert_eq!(clean, (0, 0, 0, 1), "{name}");
            assert_eq!(report.duplicate_triangles, 0, "{name}");
            assert!(
                (report.volume_mm3 / volume - 1.0).abs() < 2e-3,
                "{name}: {} {volume}",
                report.volume_mm3
            );
        }
        let body = knot(10.0, 2.0, 5000);
        let report = audit(&body, &Adjacency::build(&body));
        assert!(report.triangles >= 5000 && report.volume_mm3 > 0.0);
        assert_eq!((report.open_edges, report.over_shared_edges, report.shells), (0, 0, 1));
    }
}
