//! Which walls of an island belong together, and cutting a loop open.

use super::seam::Seam;
use crate::lattice::Point2;
use crate::region::Wall;
use std::ops::Range;

/// Sorts the walls of an island into nests: an external wall with the inner walls that follow it.
///
/// Appends the indices of the walls to `order`, nest by nest and in each from the external wall
/// inwards, and the nests' ranges in `order` to `out`, in the order of the external walls. An inner
/// wall follows the wall of the next smaller depth, hole or not as it is itself, whose box is most
/// like its own. One that nothing precedes starts a nest. Empty rings are left out.
pub(super) fn nests(walls: &[Wall], order: &mut Vec<u32>, out: &mut Vec<Range<u32>>) {
    let first = order.len();
    let depth_of = |i: &u32| walls[*i as usize].depth;
    order.extend((0..walls.len() as u32).filter(|&i| !walls[i as usize].ring.is_empty()));
    if !order[first..].is_sorted_by_key(depth_of) {
        order[first..].sort_by_key(depth_of);
    }
    let Some(outermost) = order.get(first).map(depth_of) else { return };
    let alone = order.get(first + 1).is_none_or(|i| depth_of(i) > outermost);
    if alone && walls.iter().all(|w| !w.hole) {
        out.push(first as u32..order.len() as u32);
        return;
    }
    let boxes: Vec<_> = walls.iter().map(|w| sides(&w.ring)).collect();
    // Nest of each wall seen so far.
    let mut nest_of = vec![u32::MAX; walls.len()];
    let mut count = 0;
    // Walls of the depth above and of the current one.
    let (mut above, mut level): (Vec<u32>, Vec<u32>) = (Vec::new(), Vec::new());
    let mut depth = outermost;
    for &i in &order[first..] {
        let wall = &walls[i as usize];
        if wall.depth != depth {
            above = std::mem::take(&mut level);
            above.sort_unstable_by_key(|&j| (boxes[j as usize][0], j));
            if wall.depth != depth + 1 {
                above.clear();
            }
            depth = wall.depth;
        }
        nest_of[i as usize] = match parent(i, walls, &boxes, &above) {
            Some(j) => nest_of[j as usize],
            None => {
                count += 1;
                count - 1
            }
        };
        level.push(i);
    }
    order[first..].sort_by_key(|&i| nest_of[i as usize]);
    let mut start = first as u32;
    for nest in order[first..].chunk_by(|&a, &b| nest_of[a as usize] == nest_of[b as usize]) {
        out.push(start..start + nest.len() as u32);
        start += nest.len() as u32;
    }
}

/// The wall of `above`, which is sorted by the left side of the boxes, whose box is most like that
/// of wall `i`; the lowest of several.
fn parent(i: u32, walls: &[Wall], boxes: &[[i64; 4]], above: &[u32]) -> Option<u32> {
    let (own, hole) = (boxes[i as usize], walls[i as usize].hole);
    let middle = above.partition_point(|&j| boxes[j as usize][0] < own[0]);
    let mut best: Option<(i64, u32)> = None;
    // Outwards from the most similar left side, each way until that alone is worse than the best.
    let mut look = |j: u32| {
        let other = boxes[j as usize];
        if best.is_some_and(|b| (other[0] - own[0]).abs() > b.0) {
            return false;
        }
        if walls[j as usize].hole == hole {
            let unlike = own.iter().zip(other).map(|(a, b)| (a - b).abs()).sum();
            if best.is_none_or(|b| (unlike, j) < b) {
                best = Some((unlike, j));
            }
        }
        true
    };
    let _ = above[middle..].iter().all(|&j| look(j));
    let _ = above[..middle].iter().rev().all(|&j| look(j));
    best.map(|b| b.1)
}

/// The four sides of a ring's box.
fn sides(ring: &[Point2]) -> [i64; 4] {
    ring.iter().fold([i64::MAX, i64::MAX, i64::MIN, i64::MIN], |b, p| {
        let (x, y) = (i64::from(p.x), i64::from(p.y));
        [b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)]
    })
}

/// Appends the ring, cut open at the seam, to `points`; the last `gap` \[nm\] of the way round are
/// left out, so that the ends of the bead do not pile up. A loop shorter than four gaps is closed.
pub(super) fn cut_open(ring: &[Point2], seam: Seam, gap: f64, points: &mut Vec<Point2>) {
    let from = points.len();
    points.push(seam.at);
    let n = ring.len();
    let next = (seam.edge + 1).min(n);
    points.extend_from_slice(&ring[next..]);
    points.extend_from_slice(&ring[..next]);
    // At a vertex, the seam itself has just been repeated; within an edge it closes the loop.
    if points.last() != Some(&seam.at) {
        points.push(seam.at);
    }
    clip_end(points, from, gap);
}

/// Shortens the polyline `points[from..]` by `gap` \[nm\] at its end.
fn clip_end(points: &mut Vec<Point2>, from: usize, gap: f64) {
    if gap <= 0.0 || !is_longer(&points[from..], 4.0 * gap) {
        return;
    }
    let mut left = gap;
    while let [.., a, b] = points[from..] {
        let d = a.distance(b);
        points.pop();
        if d > left {
            let (dx, dy) = a.minus(b);
            let move_by = |from: i32, by: i64| (i64::from(from) + rounded(by as f64 * (left / d))) as i32;
            points.push(Point2::new(move_by(b.x, dx), move_by(b.y, dy)));
            return;
        }
        left -= d;
    }
}

/// `x.round()`, which is a call without SSE 4.1.
fn rounded(x: f64) -> i64 {
    if x < 0.0 { (x - 0.5) as i64 } else { (x + 0.5) as i64 }
}

/// True when the polyline is longer than `limit` \[nm\]; looks no further than that.
fn is_longer(points: &[Point2], limit: f64) -> bool {
    let mut sum = 0.0;
    points.windows(2).any(|w| {
        sum += w[0].distance(w[1]);
        sum > limit
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing::{circle, rectangle};
    use super::*;

    fn wall(ring: Vec<Point2>, depth: u32, hole: bool) -> Wall {
        Wall { ring, depth, hole, overhang: Vec::new() }
    }

    /// The nests of one island, behind something that is there already.
    fn nests_of(walls: &[Wall]) -> Vec<Vec<u32>> {
        let (mut order, mut out) = (vec![99], Vec::new());
        nests(walls, &mut order, &mut out);
        out.into_iter().map(|r| order[r.start as usize..r.end as usize].to_vec()).collect()
    }

    #[test]
    fn holes_and_contours_keep_their_own_inner_walls() {
        let mut walls = vec![wall(rectangle(0, 0, 100_000_000, 100_000_000), 0, false)];
        for i in 0..40 {
            walls.push(wall(
                circle(5_000_000 + i % 8 * 9_000_000, 9_000_000 + i / 8 * 9_000_000, 2_000_000, 20, 0.0),
                0,
                true,
            ));
        }
        walls.push(wall(rectangle(450_000, 450_000, 99_550_000, 99_550_000), 1, false));
        for i in (0..40).rev() {
            walls.push(wall(
                circle(5_000_000 + i % 8 * 9_000_000, 9_000_000 + i / 8 * 9_000_000, 2_450_000, 20, 0.3),
                1,
                true,
            ));
        }
        let found = nests_of(&walls);
        assert_eq!(found.len(), 41);
        assert_eq!(found[0], [0, 41]);
        for i in 0..40 {
            assert_eq!(found[i + 1], [i as u32 + 1, 81 - i as u32]);
        }
    }

    #[test]
    fn walls_without_a_parent_are_not_lost() {
        let walls = vec![
            wall(rectangle(0, 0, 10, 10), 2, false),
            wall(rectangle(0, 0, 30, 30), 0, false),
            wall(rectangle(3, 3, 5, 5), 0, true),
            wall(rectangle(2, 2, 6, 6), 1, true),
        ];
        assert_eq!(nests_of(&walls), [vec![1], vec![2, 3], vec![0]]);
        assert!(nests_of(&[]).is_empty());
    }

    #[test]
    fn a_loop_is_cut_at_its_seam_and_misses_the_gap() {
        let ring = rectangle(0, 0, 10_000, 10_000);
        let open = |seam, gap| {
            let mut points = vec![Point2::new(7, 7)];
            cut_open(&ring, seam, gap, &mut points);
            points.split_off(1)
        };
        let at = Point2::new;
        let corner = Seam { edge: 1, at: at(10_000, 0) };
        assert_eq!(
            open(corner, 600.0),
            [at(10_000, 0), at(10_000, 10_000), at(0, 10_000), at(0, 0), at(9_400, 0)]
        );
        let inside = Seam { edge: 3, at: at(0, 400) };
        assert_eq!(
            open(inside, 600.0),
            [at(0, 400), at(0, 0), at(10_000, 0), at(10_000, 10_000), at(0, 10_000), at(0, 1_000)]
        );
        // A gap that swallows the last edge.
        assert_eq!(open(Seam { edge: 3, at: at(0, 9_800) }, 600.0).last(), Some(&at(400, 10_000)));
        // Too small for a gap.
        assert_eq!(open(corner, 20_000.0).last(), Some(&corner.at));
    }
}
