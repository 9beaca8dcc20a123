//! Every plane × every triangle, in exact fractions, with no thought of speed.

use microtome::contour::trace::LayerContours;
use microtome::lattice::{Point2, Point3};
use microtome::mesh::Mesh;
use std::collections::BTreeMap;

/// A directed segment, solid on its left.
pub type Segment = (Point2, Point2);

/// The segments of one plane without those of zero length, sorted.
pub fn segments(mesh: &Mesh, z: i32) -> Vec<Segment> {
    let mut segments = Vec::new();
    for triangle in &mesh.triangles {
        let corners = triangle.map(|v| mesh.vertices[v as usize]);
        let (mut enter, mut leave) = (None, None);
        for (a, b) in [(0, 1), (1, 2), (2, 0)].map(|(i, j)| (corners[i], corners[j])) {
            // Down through the plane the contour comes in, up through it it goes out.
            match (a.z >= z, b.z >= z) {
                (true, false) => enter = Some(crossing(b, a, z)),
                (false, true) => leave = Some(crossing(a, b, z)),
                _ => {}
            }
        }
        if let (Some(enter), Some(leave)) = (enter, leave)
            && enter != leave
        {
            segments.push((enter, leave));
        }
    }
    segments.sort();
    segments
}

/// The crossing from the lower vertex, halves away from it: x_lo ± floor(|dx| rise / dz + 1/2).
fn crossing(low: Point3, high: Point3, z: i32) -> Point2 {
    let (dz, rise) = (i128::from(high.z) - i128::from(low.z), i128::from(z) - i128::from(low.z));
    let along = |from: i32, to: i32| {
        let run = i128::from(to) - i128::from(from);
        let step = (2 * run.abs() * rise + dz).div_euclid(2 * dz);
        (i128::from(from) + run.signum() * step) as i32
    };
    Point2::new(along(low.x, high.x), along(low.y, high.y))
}

/// Twice the area that closed segments enclose.
pub fn area2(segments: &[Segment]) -> i128 {
    segments.iter().map(|(a, b)| i128::from(a.x) * i128::from(b.y) - i128::from(b.x) * i128::from(a.y)).sum()
}

/// Segments joined by equality of end points, each ring from its smallest point, sorted; nothing where
/// a point has more than one segment in or out.
pub fn rings(segments: &[Segment]) -> Option<Vec<Vec<Point2>>> {
    let mut next: BTreeMap<Point2, Point2> = segments.iter().copied().collect();
    let ends: std::collections::BTreeSet<Point2> = segments.iter().map(|s| s.1).collect();
    if next.len() != segments.len() || ends.len() != segments.len() {
        return None;
    }
    let mut rings = Vec::new();
    while let Some((first, mut at)) = next.pop_first() {
        let mut ring = vec![first];
        while at != first {
            ring.push(at);
            at = next.remove(&at)?;
        }
        if ring.len() >= 3 {
            rings.push(ring);
        }
    }
    Some(rings)
}

/// Whether a layer's rings consist of these segments: the same number each way between any two
/// points, but for there-and-back pairs, of which rings of two points lose some.
pub fn same(layer: &LayerContours, segments: &[Segment]) -> Result<(), String> {
    let mut surplus: BTreeMap<Segment, i64> = BTreeMap::new();
    let mut add = |(a, b): Segment, n: i64| {
        let (key, n) = if a < b { ((a, b), n) } else { ((b, a), -n) };
        *surplus.entry(key).or_default() += n;
    };
    let mut count = 0;
    for ring in &layer.rings {
        for i in 0..ring.len() {
            add((ring[i], ring[(i + 1) % ring.len()]), 1);
        }
        count += ring.len();
    }
    for &segment in segments {
        add(segment, -1);
    }
    if let Some((segment, n)) = surplus.iter().find(|(_, n)| **n != 0) {
        return Err(format!("{n} segments too many at {segment:?}"));
    }
    if count > segments.len() {
        return Err(format!("{count} segments for {}", segments.len()));
    }
    let area: i128 = layer.rings.iter().map(|r| microtome::lattice::area2(r)).sum();
    if area != area2(segments) {
        return Err(format!("area {area} for {}", area2(segments)));
    }
    Ok(())
}
