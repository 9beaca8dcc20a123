//! A flat lid for contours: triangles whose border is exactly the contours' edges. The only file that
//! names the triangulation library.
//!
//! All points go into one constrained Delaunay triangulation with the edges as constraints, and each
//! face is taken as often as the contours wind about it. Where contours cross there is no such
//! triangulation without new points, which the walls under the lid would not have; they are then
//! covered one by one. In the end the border is compared edge by edge, and what is missing is filled
//! with fans, so the lid always fits.

use super::Ring;
use crate::lattice::{Point2, cross};
use spade::handles::FixedVertexHandle;
use spade::{ConstrainedDelaunayTriangulation, Triangulation};

/// A triangulated area.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Cap {
    /// The contours' points \[nm\], each once, sorted by (x, y).
    pub points: Vec<Point2>,
    /// Ids of points; counter-clockwise where the contours wind counter-clockwise, and as often as
    /// they do.
    pub triangles: Vec<[u32; 3]>,
}

/// Triangulates what rings enclose. Every edge of the rings is an edge of the result's border in the
/// same direction, and there are no others; areas sum up to those of the rings.
pub fn cap(rings: &[Ring]) -> Cap {
    let mut points: Vec<Point2> = rings.iter().flatten().copied().collect();
    points.sort_unstable();
    points.dedup();
    let ids: Vec<Vec<u32>> = rings
        .iter()
        .map(|ring| ring.iter().map(|p| points.partition_point(|q| q < p) as u32).collect())
        .collect();
    let all: Vec<&[u32]> = ids.iter().map(Vec::as_slice).collect();
    let mut triangles = Vec::new();
    cover(&points, &all, &mut triangles);
    fill(border(&all, &triangles), &mut triangles);
    Cap { points, triangles }
}

/// A directed edge of which the first id is lower, and how often it runs that way (less the reverse).
type Edge = ((u32, u32), i32);

fn sides(ring: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

/// Sums up directed edges; what runs both ways as often vanishes.
fn net(edges: impl Iterator<Item = ((u32, u32), i32)>) -> Vec<Edge> {
    let mut edges: Vec<Edge> = edges
        .filter(|((a, b), _)| a != b)
        .map(|((a, b), n)| if a < b { ((a, b), n) } else { ((b, a), -n) })
        .collect();
    edges.sort_unstable();
    let mut net: Vec<Edge> = Vec::with_capacity(edges.len());
    for same in edges.chunk_by(|a, b| a.0 == b.0) {
        let n = same.iter().map(|e| e.1).sum();
        if n != 0 {
            net.push((same[0].0, n));
        }
    }
    net
}

/// The rings' edges less the triangles' border.
fn border(rings: &[&[u32]], triangles: &[[u32; 3]]) -> Vec<Edge> {
    let wanted = rings.iter().flat_map(|ring| sides(ring)).map(|e| (e, 1));
    let found = triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]).map(|e| (e, -1));
    net(wanted.chain(found))
}

/// Triangulates rings together, or, where they cross, in groups.
fn cover(points: &[Point2], rings: &[&[u32]], triangles: &mut Vec<[u32; 3]>) {
    let edges = net(rings.iter().flat_map(|ring| sides(ring)).map(|e| (e, 1)));
    let crossing = match triangulate(points, &edges) {
        Ok(found) => return triangles.extend(found),
        Err(crossing) => crossing,
    };
    // A ring that crosses itself is left to the fans.
    if rings.len() > 1 {
        let crosses =
            |ring: &&[u32]| sides(ring).any(|(a, b)| crossing.binary_search(&(a.min(b), a.max(b))).is_ok());
        let (bad, good): (Vec<&[u32]>, Vec<&[u32]>) = rings.iter().copied().partition(crosses);
        if good.is_empty() {
            bad.iter().for_each(|ring| cover(points, &[ring], triangles));
        } else {
            cover(points, &good, triangles);
            cover(points, &bad, triangles);
        }
    }
}

/// The faces about which the edges wind, each as often as they do, or the edges that cross others.
fn triangulate(points: &[Point2], edges: &[Edge]) -> Result<Vec<[u32; 3]>, Vec<(u32, u32)>> {
    // Only the points of these edges.
    let mut used: Vec<u32> = edges.iter().flat_map(|e| [e.0.0, e.0.1]).collect();
    used.sort_unstable();
    used.dedup();
    if used.len() < 3 {
        return Ok(Vec::new());
    }
    let local = |id: u32| used.partition_point(|&u| u < id);
    let at = |vertex: usize| points[used[vertex] as usize];
    let sites = (0..used.len())
        .map(|v| spade::Point2::new(f64::from(at(v).x), f64::from(at(v).y)))
        .collect::<Vec<_>>();
    let all = || edges.iter().map(|e| e.0).collect::<Vec<_>>();
    // The order of vertices is kept. Fails only for coordinates that are no numbers.
    let mut mesh: ConstrainedDelaunayTriangulation<spade::Point2<f64>> =
        ConstrainedDelaunayTriangulation::bulk_load_cdt(sites, Vec::new()).map_err(|_| all())?;
    let vertex = FixedVertexHandle::from_index;
    for ((a, b), _) in edges {
        mesh.try_add_constraint(vertex(local(*a)), vertex(local(*b)));
    }

    // How often the rings run along each directed edge. A long edge may pass through other points.
    let mut runs = vec![0i32; mesh.num_directed_edges()];
    let mut crossing = Vec::new();
    for &((a, b), n) in edges {
        let (mut from, to) = (local(a), local(b));
        while from != to {
            let here = at(from);
            let next = mesh.vertex(vertex(from)).out_edges().find(|edge| {
                let p = at(edge.to().index());
                let ((ux, uy), (vx, vy)) = (p.minus(here), at(to).minus(here));
                edge.is_constraint_edge() && cross(here, p, at(to)) == 0 && ux * vx + uy * vy > 0
            });
            let Some(edge) = next else {
                crossing.push((a, b));
                break;
            };
            runs[edge.fix().index()] += n;
            runs[edge.fix().rev().index()] -= n;
            from = edge.to().index();
        }
    }
    if !crossing.is_empty() {
        return Err(crossing);
    }

    // From the outside in: a face differs from its neighbour by the runs along their edge.
    let mut winding: Vec<Option<i32>> = vec![None; mesh.num_all_faces()];
    let outer = mesh.outer_face().fix().index();
    winding[outer] = Some(0);
    let mut edges_out: Vec<_> = mesh.convex_hull().map(|edge| edge.fix()).collect();
    while let Some(edge) = edges_out.pop() {
        let edge = mesh.directed_edge(edge);
        let sides = [edge, edge.rev()];
        for [here, there] in [sides, [sides[1], sides[0]]] {
            let (from, to) = (here.face().fix().index(), there.face().fix().index());
            if let (Some(known), None) = (winding[from], winding[to]) {
                winding[to] = Some(known + runs[there.fix().index()]);
                edges_out.extend([there.next().fix(), there.prev().fix()]);
            }
        }
    }
    let mut triangles = Vec::new();
    for face in mesh.inner_faces() {
        let winding = winding[face.fix().index()].unwrap_or(0);
        let [a, b, c] = face.vertices().map(|v| used[v.index()]);
        let facing = if winding > 0 { [a, b, c] } else { [a, c, b] };
        triangles.extend(std::iter::repeat_n(facing, winding.unsigned_abs() as usize));
    }
    Ok(triangles)
}

/// Covers what is left of the border. As much of it arrives at every point as leaves it, so it falls
/// into closed walks; a fan over each has that walk as its border.
fn fill(left: Vec<Edge>, triangles: &mut Vec<[u32; 3]>) {
    let mut out: Vec<(u32, u32)> = left
        .into_iter()
        .flat_map(|((a, b), n)| {
            let edge = if n > 0 { (a, b) } else { (b, a) };
            std::iter::repeat_n(edge, n.unsigned_abs() as usize)
        })
        .collect();
    out.sort_unstable();
    let mut taken = vec![false; out.len()];
    // Per starting point the first edge that may still be free.
    let mut cursor: Vec<usize> = (0..out.len()).collect();
    let first = |point: u32| out.partition_point(|e| e.0 < point);
    for start in 0..out.len() {
        if taken[start] {
            continue;
        }
        let hub = out[start].0;
        let (mut walk, mut edge) = (Vec::new(), start);
        loop {
            taken[edge] = true;
            let to = out[edge].1;
            if to == hub {
                break;
            }
            walk.push(to);
            let at = first(to);
            let mut next = cursor.get(at).copied().unwrap_or(at);
            while taken.get(next) == Some(&true) {
                next += 1;
            }
            if out.get(next).is_none_or(|e| e.0 != to) {
                break;
            }
            cursor[at] = next;
            edge = next;
        }
        let fan = walk.windows(2).map(|w| [hub, w[0], w[1]]);
        triangles.extend(fan.filter(|t| t[1] != t[2]));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::area2;

    fn ring(points: &[(i32, i32)]) -> Ring {
        points.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    fn square(x: i32, y: i32, size: i32) -> Ring {
        ring(&[(x, y), (x + size, y), (x + size, y + size), (x, y + size)])
    }

    fn turned(mut ring: Ring) -> Ring {
        ring.reverse();
        ring
    }

    /// Checks border and area; returns the number of triangles, and of those that face down.
    fn check(rings: &[Ring]) -> (usize, usize) {
        let cap = cap(rings);
        let mut expected: Vec<Point2> = rings.iter().flatten().copied().collect();
        expected.sort_unstable();
        expected.dedup();
        assert_eq!(cap.points, expected, "no point is added");
        let id = |p: &Point2| cap.points.binary_search(p).map_or(u32::MAX, |i| i as u32);
        let ids: Vec<Vec<u32>> = rings.iter().map(|r| r.iter().map(id).collect()).collect();
        let all: Vec<&[u32]> = ids.iter().map(Vec::as_slice).collect();
        assert!(border(&all, &cap.triangles).is_empty());
        let corner = |t: &[u32; 3]| t.map(|v| cap.points[v as usize]);
        let area: i128 = cap.triangles.iter().map(|t| area2(&corner(t))).sum();
        assert_eq!(area, rings.iter().map(|r| area2(r)).sum::<i128>());
        let down = cap.triangles.iter().filter(|t| area2(&corner(t)) < 0).count();
        (cap.triangles.len(), down)
    }

    #[test]
    fn areas_with_holes_are_covered_once() {
        assert_eq!(check(&[]), (0, 0));
        assert_eq!(check(&[square(0, 0, 10)]), (2, 0));
        assert_eq!(check(&[square(0, 0, 10), turned(square(3, 3, 4))]), (8, 0));
        let nested = [square(0, 0, 10), turned(square(2, 2, 6)), square(4, 4, 2), square(20, 0, 5)];
        assert_eq!(check(&nested).1, 0);
        assert_eq!(check(&[square(0, 0, 10), square(3, 3, 4)]), (10 + 2, 0), "twice in the inner square");
        assert_eq!(check(&[turned(square(0, 0, 10))]), (2, 2));
    }

    #[test]
    fn points_on_straight_sides_stay() {
        let mut wall = ring(&[(0, 0)]);
        wall.extend((1..100).map(|i| Point2::new(i * 10, 0)));
        wall.extend((0..100).map(|i| Point2::new(1000 - i * 10, 1000)));
        assert_eq!(check(&[wall.clone()]), (wall.len() - 2, 0));
    }

    #[test]
    fn rings_that_touch_or_share_sides_are_no_trouble() {
        // A corner on a side, a shared side, half a shared side, a hole that touches the outline.
        check(&[square(0, 0, 10), ring(&[(10, 5), (15, 0), (15, 10)])]);
        check(&[square(0, 0, 10), square(10, 0, 10)]);
        check(&[square(0, 0, 10), square(10, 5, 10)]);
        assert_eq!(check(&[square(0, 0, 10), turned(square(0, 2, 4))]).1, 0);
        check(&[square(0, 0, 10), square(0, 0, 10)]);
        check(&[square(0, 0, 10), turned(square(0, 0, 10))]);
        // A ring that passes a point twice, and one with a spike.
        check(&[ring(&[(0, 0), (10, 0), (5, 5), (10, 10), (0, 10), (5, 5)])]);
        check(&[ring(&[(0, 0), (10, 0), (10, 10), (20, 20), (10, 10), (0, 10)])]);
        check(&[ring(&[(0, 0), (5, 0), (10, 0)])]);
    }

    #[test]
    fn crossing_rings_are_covered_all_the_same() {
        check(&[square(0, 0, 10), square(5, 5, 10)]);
        check(&[square(0, 0, 10), turned(square(5, 5, 10)), square(30, 0, 10), turned(square(32, 2, 3))]);
        check(&[ring(&[(0, 0), (10, 10), (10, 0), (0, 10)])]);
        let mut state = 7u64;
        for size in 3..60 {
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                (state >> 33) as i32 % 40
            };
            let rings: Vec<Ring> =
                (0..3).map(|_| (0..size).map(|_| Point2::new(next(), next())).collect()).collect();
            check(&rings);
        }
    }

    #[test]
    fn a_missing_triangle_is_seen() {
        let rings = [square(0, 0, 10)];
        let mut cap = cap(&rings);
        cap.triangles.pop();
        assert_eq!(border(&[&[0, 2, 3, 1]], &cap.triangles).len(), 3);
    }
}
