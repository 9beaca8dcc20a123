//! Which shells lie inside which.
//!
//! A shell is asked about by its outermost vertices (up to six: lowest and highest along each axis). A
//! ray from each goes up; an odd number of crossings with another shell puts the vertex inside it. The
//! ray passes edges and vertices by the rule of the slicing planes (at or above is above), and heights
//! are compared exactly, so there is no epsilon.

use super::Mesh;
use crate::lattice::{Point2, Point3, cross};

/// How the outermost vertices of a shell lie to another one whose bounds contain the shell's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Lies {
    /// The shell asked about.
    pub(super) shell: u32,
    /// The other one.
    pub(super) other: u32,
    /// Vertices strictly inside it, as far as rays can tell.
    pub(super) inside: u32,
    /// Vertices outside it. Those on its surface are counted as neither.
    pub(super) outside: u32,
}

/// For each shell in `ask` how it lies to every other shell around it, sorted by shell, then other.
///
/// `of`: per triangle its shell, below `shells`. Time grows with the triangles, and with the vertices
/// asked about in the shadow of each triangle.
pub(super) fn lies(mesh: &Mesh, of: &[u32], shells: usize, ask: &[u32]) -> Vec<Lies> {
    let bounds = bounds(mesh, of, shells);
    let queries = Queries::new(mesh, of, &bounds, ask);
    // (Query, shell, whether the crossing is on the vertex itself), one entry per crossing.
    let mut hits: Vec<(u32, u32, bool)> = Vec::new();
    for (triangle, &other) in mesh.triangles.iter().zip(of) {
        let corners = triangle.map(|v| mesh.vertices[v as usize]);
        queries.under(corners, |q| {
            let query = &queries.all[q as usize];
            if query.shell != other && bounds[other as usize].contain(&bounds[query.shell as usize]) {
                match height(corners, query.at) {
                    Some(std::cmp::Ordering::Greater) => hits.push((q, other, false)),
                    Some(std::cmp::Ordering::Equal) => hits.push((q, other, true)),
                    _ => {}
                }
            }
        });
    }
    hits.sort_unstable();
    let mut votes: Vec<(u32, u32, i32)> = hits
        .chunk_by(|a, b| (a.0, a.1) == (b.0, b.1))
        .map(|hits| {
            let touches = hits.iter().any(|h| h.2);
            let inside = hits.len() % 2 == 1;
            let shell = queries.all[hits[0].0 as usize].shell;
            (shell, hits[0].1, if touches { -1 } else { i32::from(inside) })
        })
        .collect();
    votes.sort_unstable();
    let mut found = Vec::new();
    for votes in votes.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (shell, other, _) = votes[0];
        let count = |of: i32| votes.iter().filter(|v| v.2 == of).count() as u32;
        // Vertices without any crossing have no vote and are outside.
        let asked = queries.per_shell(shell);
        let inside = count(1);
        found.push(Lies { shell, other, inside, outside: asked - inside - count(-1) });
    }
    found
}

/// Bounds and outermost vertices of a shell.
#[derive(Clone, Copy)]
struct Bounds {
    lo: Point3,
    hi: Point3,
    outermost: [u32; 6],
}

impl Bounds {
    fn contain(&self, inner: &Self) -> bool {
        let (a, b) = (self, inner);
        a.lo.x <= b.lo.x
            && a.lo.y <= b.lo.y
            && a.lo.z <= b.lo.z
            && a.hi.x >= b.hi.x
            && a.hi.y >= b.hi.y
            && a.hi.z >= b.hi.z
    }
}

fn bounds(mesh: &Mesh, of: &[u32], shells: usize) -> Vec<Bounds> {
    let (most, least) =
        (Point3::new(i32::MAX, i32::MAX, i32::MAX), Point3::new(i32::MIN, i32::MIN, i32::MIN));
    let mut bounds = vec![Bounds { lo: most, hi: least, outermost: [0; 6] }; shells];
    for (triangle, &shell) in mesh.triangles.iter().zip(of) {
        let b = &mut bounds[shell as usize];
        for &id in triangle {
            let v = mesh.vertices[id as usize];
            let low = [(v.x, &mut b.lo.x), (v.y, &mut b.lo.y), (v.z, &mut b.lo.z)];
            for (k, (c, lo)) in low.into_iter().enumerate() {
                if c < *lo {
                    (*lo, b.outermost[k]) = (c, id);
                }
            }
            let high = [(v.x, &mut b.hi.x), (v.y, &mut b.hi.y), (v.z, &mut b.hi.z)];
            for (k, (c, hi)) in high.into_iter().enumerate() {
                if c > *hi {
                    (*hi, b.outermost[3 + k]) = (c, id);
                }
            }
        }
    }
    bounds
}

struct Query {
    shell: u32,
    at: Point3,
}

/// The vertices asked about, in a grid over the ground plan.
struct Queries {
    all: Vec<Query>,
    lo: Point2,
    shift: u32,
    /// Cells along x and y.
    size: [usize; 2],
    /// Per cell its first place in `order`; one more entry than cells.
    start: Vec<u32>,
    order: Vec<u32>,
}

impl Queries {
    fn new(mesh: &Mesh, of: &[u32], bounds: &[Bounds], ask: &[u32]) -> Self {
        let mut ask: Vec<u32> = ask.iter().copied().filter(|&s| (s as usize) < bounds.len()).collect();
        ask.sort_unstable();
        ask.dedup();
        let mut all = Vec::with_capacity(6 * ask.len());
        if !of.is_empty() {
            for shell in ask {
                let mut ids = bounds[shell as usize].outermost;
                ids.sort_unstable();
                let mut before = None;
                for id in ids {
                    if before != Some(id) {
                        all.push(Query { shell, at: mesh.vertices[id as usize] });
                    }
                    before = Some(id);
                }
            }
        }
        let first = all.first().map_or(Point2::default(), |q| q.at.xy());
        let (mut lo, mut hi) = (first, first);
        for p in all.iter().map(|q| q.at.xy()) {
            (lo, hi) = (Point2::new(lo.x.min(p.x), lo.y.min(p.y)), Point2::new(hi.x.max(p.x), hi.y.max(p.y)));
        }
        let (width, depth) = hi.minus(lo);
        let fits = |s: &u32| ((width >> s) + 1) * ((depth >> s) + 1) <= all.len().max(1) as i64;
        let shift = (0..32).find(fits).unwrap_or(31);
        let size = [(width >> shift) as usize + 1, (depth >> shift) as usize + 1];
        let mut queries = Self { all, lo, shift, size, start: vec![0; size[0] * size[1] + 1], order: vec![] };
        let cells: Vec<usize> = queries.all.iter().map(|q| queries.cell(q.at.xy())).collect();
        for &cell in &cells {
            queries.start[cell + 1] += 1;
        }
        for cell in 1..queries.start.len() {
            queries.start[cell] += queries.start[cell - 1];
        }
        let mut cursor = queries.start.clone();
        queries.order = vec![0; cells.len()];
        for (q, &cell) in cells.iter().enumerate() {
            queries.order[cursor[cell] as usize] = q as u32;
            cursor[cell] += 1;
        }
        queries
    }

    fn cell(&self, p: Point2) -> usize {
        let (x, y) = p.minus(self.lo);
        (y >> self.shift) as usize * self.size[0] + (x >> self.shift) as usize
    }

    fn per_shell(&self, shell: u32) -> u32 {
        let from = self.all.partition_point(|q| q.shell < shell);
        let to = self.all.partition_point(|q| q.shell <= shell);
        (to - from) as u32
    }

    /// Calls `found` with every query in the bounds of a triangle's ground plan.
    fn under(&self, corners: [Point3; 3], mut found: impl FnMut(u32)) {
        let [a, b, c] = corners;
        let (lo, hi) = (
            Point2::new(a.x.min(b.x).min(c.x), a.y.min(b.y).min(c.y)),
            Point2::new(a.x.max(b.x).max(c.x), a.y.max(b.y).max(c.y)),
        );
        let along = |low: i64, high: i64, size: usize| {
            let (low, high) = (low >> self.shift, high >> self.shift);
            (low.max(0), high.min(size as i64 - 1))
        };
        let ((x0, y0), (x1, y1)) = (lo.minus(self.lo), hi.minus(self.lo));
        let (x0, x1) = along(x0, x1, self.size[0]);
        let (y0, y1) = along(y0, y1, self.size[1]);
        if x0 > x1 {
            return;
        }
        for y in y0..=y1 {
            let row = y as usize * self.size[0];
            let (from, to) = (self.start[row + x0 as usize], self.start[row + x1 as usize + 1]);
            for &q in &self.order[from as usize..to as usize] {
                let p = self.all[q as usize].at;
                if (lo.x..=hi.x).contains(&p.x) && (lo.y..=hi.y).contains(&p.y) {
                    found(q);
                }
            }
        }
    }
}

/// How the triangle lies over a point: above, below or through it; `None` beside it.
fn height(corners: [Point3; 3], p: Point3) -> Option<std::cmp::Ordering> {
    let at = p.xy();
    let mut inside = false;
    for k in 0..3 {
        let (a, b) = (corners[k].xy(), corners[(k + 1) % 3].xy());
        if (a.y >= at.y) != (b.y >= at.y) {
            let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
            // The edge, from its lower end up, has the point on its left or passes through it.
            inside ^= cross(low, high, at) >= 0;
        }
    }
    if !inside {
        return None;
    }
    let [u, v, w] = corners.map(|c| {
        let (x, y) = c.xy().minus(at);
        [x, y, i64::from(c.z) - i64::from(p.z)].map(i128::from)
    });
    let x = u[1] * v[2] - u[2] * v[1];
    let y = u[2] * v[0] - u[0] * v[2];
    let z = u[0] * v[1] - u[1] * v[0];
    let volume = x * w[0] + y * w[1] + z * w[2];
    let turn = cross(corners[0].xy(), corners[1].xy(), corners[2].xy());
    Some((volume * i128::from(turn.signum())).cmp(&0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{self, cuboid, merge, moved};

    /// About the origin.
    fn sphere(radius: f64, around: usize, rings: usize) -> Mesh {
        moved(shapes::sphere(radius, around, rings), [0.0, 0.0, -radius])
    }

    fn torus(radius: f64, tube: f64, around: usize, across: usize) -> Mesh {
        moved(shapes::torus(radius, tube, around, across), [0.0, 0.0, -tube])
    }

    /// Merged shells, numbered in order.
    fn nest(parts: &[Mesh]) -> (Mesh, Vec<u32>) {
        let of = parts.iter().zip(0..).flat_map(|(p, n)| vec![n; p.triangles.len()]).collect();
        (merge(parts), of)
    }

    fn inside(parts: &[Mesh]) -> Vec<(u32, u32)> {
        let (mesh, of) = nest(parts);
        let ask: Vec<u32> = (0..parts.len() as u32).collect();
        let found = lies(&mesh, &of, parts.len(), &ask);
        found.iter().filter(|l| l.inside > 0 && l.outside == 0).map(|l| (l.shell, l.other)).collect()
    }

    #[test]
    fn containment_is_found_whatever_the_orientation() {
        let mut ball = sphere(2.0, 30, 15);
        ball.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        let parts = [
            cuboid([-9.0; 3], [9.0; 3]),
            ball,
            cuboid([-0.5; 3], [0.5; 3]),
            moved(sphere(2.0, 30, 15), [30.0, 0.0, 0.0]),
            moved(cuboid([0.0; 3], [1.0; 3]), [29.5, -0.5, -0.5]),
        ];
        assert_eq!(inside(&parts), [(1, 0), (2, 0), (2, 1), (4, 3)]);
    }

    #[test]
    fn the_hole_of_a_ring_is_outside_it() {
        let parts = [torus(10.0, 2.0, 60, 30), sphere(1.0, 20, 10)];
        assert!(inside(&parts).is_empty());
        let in_tube = moved(sphere(1.0, 20, 10), [10.0, 0.0, 0.0]);
        assert_eq!(inside(&[torus(10.0, 2.0, 60, 30), in_tube]), [(1, 0)]);
    }

    #[test]
    fn rays_through_edges_and_corners_count_once() {
        // Vertices of the inner box right under the corners, edges and diagonals of the outer one's facets.
        let outer = sphere(8.0, 4, 4);
        for x in [-1.0, 0.0, 1.0] {
            for y in [-1.0, 0.0, 1.0] {
                let inner = cuboid([x - 1.0, y - 1.0, -1.0], [x + 1.0, y + 1.0, 1.0]);
                assert_eq!(inside(&[outer.clone(), inner]), [(1, 0)], "{x} {y}");
            }
        }
    }

    #[test]
    fn overlapping_and_equal_bodies_are_not_inside() {
        assert!(inside(&[cuboid([0.0; 3], [2.0; 3]), cuboid([1.0; 3], [3.0; 3])]).is_empty());
        assert!(inside(&[cuboid([0.0; 3], [2.0; 3]), cuboid([0.0; 3], [2.0; 3])]).is_empty());
    }
}
