//! Interval algebra against bitmaps.

use super::Random;
use crate::span::algebra::{and, close_rows, dilate, erode, or, sub};
use crate::span::{Rows, RowsBuilder, components};

const WIDTH: i64 = 40;
const HEIGHT: i64 = 12;

type Bitmap = Vec<Vec<bool>>;

fn random_rows(random: &mut Random) -> Rows {
    let first = random.within(0, HEIGHT);
    let mut out = RowsBuilder::new(first as i32);
    for _ in first..random.within(first, HEIGHT + 1) {
        let mut x = 0;
        while x < WIDTH {
            let start = x + random.within(0, 9);
            let end = (start + random.within(0, 9)).min(WIDTH);
            out.push(start as i32, end as i32);
            x = end.max(start) + random.within(0, 3);
        }
        out.end_row();
    }
    out.finish()
}

fn bit(rows: &Rows, y: i64, x: i64) -> bool {
    rows.row(y as i32).iter().any(|s| i64::from(s.start) <= x && x < i64::from(s.end))
}

/// Cells -9..WIDTH + 9 of the rows -4..HEIGHT + 4.
fn bitmap(f: impl Fn(i64, i64) -> bool) -> Bitmap {
    (-4..HEIGHT + 4).map(|y| (-9..WIDTH + 9).map(|x| f(y, x)).collect()).collect()
}

fn check(rows: &Rows, expected: impl Fn(i64, i64) -> bool, what: &str, seed: u64) {
    assert_eq!(bitmap(|y, x| bit(rows, y, x)), bitmap(expected), "{what}, seed {seed}");
    for (_, row) in rows.iter() {
        assert!(row.iter().all(|s| s.start < s.end), "{what}, seed {seed}: {row:?}");
        assert!(row.windows(2).all(|w| w[0].end < w[1].start), "{what}, seed {seed}: {row:?}");
    }
}

#[test]
fn sets_are_those_of_bitmaps() {
    for seed in 1..200 {
        let mut random = Random(seed);
        let (a, b) = (random_rows(&mut random), random_rows(&mut random));
        let (in_a, in_b) = (|y, x| bit(&a, y, x), |y, x| bit(&b, y, x));
        check(&and(&a, &b), |y, x| in_a(y, x) && in_b(y, x), "and", seed);
        check(&or(&a, &b), |y, x| in_a(y, x) || in_b(y, x), "or", seed);
        check(&sub(&a, &b), |y, x| in_a(y, x) && !in_b(y, x), "sub", seed);
        let (across, along) = (random.below(3) as u32, random.below(4) as i32);
        let (k, d) = (i64::from(across), i64::from(along));
        let near = |y: i64, x: i64| (y - k..=y + k).flat_map(move |v| (x - d..=x + d).map(move |u| (v, u)));
        check(&dilate(&a, across, along), |y, x| near(y, x).any(|(v, u)| in_a(v, u)), "dilate", seed);
        check(&erode(&a, across, along), |y, x| near(y, x).all(|(v, u)| in_a(v, u)), "erode", seed);
        let both = |y: i64, x: i64| in_a(y - 1, x) && in_a(y + 1, x);
        check(&close_rows(&a), |y, x| in_a(y, x) || both(y, x), "close_rows", seed);
        let cells = bitmap(in_a).iter().flatten().filter(|&&c| c).count();
        assert_eq!(a.length(), cells as i64);
    }
}

#[test]
fn parts_are_those_of_a_flood() {
    for seed in 1..200 {
        let a = random_rows(&mut Random(seed));
        let part = components::label(&a);
        // Flood from cell to cell, 4 neighbours.
        let mut seen = vec![vec![0u32; WIDTH as usize]; HEIGHT as usize];
        let mut parts = 0;
        for k in a.first()..a.end() {
            for i in a.range(k) {
                let (x, y) = (i64::from(a.spans()[i].start), i64::from(k));
                if seen[y as usize][x as usize] == 0 {
                    parts += 1;
                    let mut stack = vec![(y, x)];
                    while let Some((y, x)) = stack.pop() {
                        if bit(&a, y, x) && seen[y as usize][x as usize] == 0 {
                            seen[y as usize][x as usize] = parts;
                            stack.extend([(y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)]);
                        }
                    }
                }
                assert_eq!(part[i] + 1, seen[y as usize][x as usize], "seed {seed}");
            }
        }
        let size = |p: u32| seen.iter().flatten().filter(|&&s| s == p).count() as i64;
        let at = |y: i64, x: i64| seen.get(y as usize).and_then(|r| r.get(x as usize)).copied().unwrap_or(0);
        check(&components::smaller_than(&a, 9), |y, x| at(y, x) > 0 && size(at(y, x)) < 9, "smaller", seed);
    }
}
