//! Which of many places is nearest to the nozzle, with places struck off as they are visited.

use crate::lattice::Point2;

/// A set of numbered points from which the nearest is taken again and again.
///
/// Few points are scanned; more are kept in square buckets of about two points each, which are
/// rebuilt coarser whenever three quarters are gone, so that `n` removals cost O(n) look-ups in
/// expectation even when only stragglers are left. Equal distances go to the lower number.
#[derive(Clone, Debug, Default)]
pub(super) struct NearestSet {
    /// The points, those of one bucket together; struck-off ones behind the live ones.
    items: Vec<Item>,
    /// First item of each bucket.
    starts: Vec<u32>,
    /// One past the last live item of each bucket.
    ends: Vec<u32>,
    spare: Vec<Item>,
    low: Point2,
    high: Point2,
    /// Side of a bucket \[nm\].
    side: i64,
    columns: i64,
    rows: i64,
    live: usize,
    built: usize,
}

#[derive(Clone, Copy, Debug, Default)]
struct Item {
    point: Point2,
    number: u32,
}

/// Up to this many points a scan is faster than buckets.
const SCANNED: usize = 24;

impl NearestSet {
    /// Replaces the content by `points`, numbered from 0.
    pub fn fill(&mut self, points: impl IntoIterator<Item = Point2>) {
        self.spare.clear();
        self.spare.extend(points.into_iter().zip(0..).map(|(point, number)| Item { point, number }));
        self.rebuild();
    }

    /// Number and place of the point nearest to `from`, which is struck off.
    pub fn take(&mut self, from: Point2) -> Option<(u32, Point2)> {
        if self.live == 0 {
            return None;
        }
        let (bucket, slot) =
            if self.starts.len() == 1 { (0, self.scan(0, from)?.1) } else { self.search(from)? };
        let found = self.items[slot];
        self.strike(bucket, slot);
        Some((found.number, found.point))
    }

    /// Strikes off point `number` at `point`, if it is still there.
    pub fn remove(&mut self, number: u32, point: Point2) {
        if self.live == 0 {
            return;
        }
        let (column, row) = self.bucket_of(point);
        let bucket = (row * self.columns + column) as usize;
        let range = self.starts[bucket] as usize..self.ends[bucket] as usize;
        if let Some(slot) = range.into_iter().find(|&s| self.items[s].number == number) {
            self.strike(bucket, slot);
        }
    }

    fn strike(&mut self, bucket: usize, slot: usize) {
        let last = self.ends[bucket] as usize - 1;
        self.items.swap(slot, last);
        self.ends[bucket] -= 1;
        self.live -= 1;
        if self.starts.len() > 1 && self.live * 4 <= self.built {
            self.spare.clear();
            for (s, e) in self.starts.iter().zip(&self.ends) {
                self.spare.extend_from_slice(&self.items[*s as usize..*e as usize]);
            }
            self.rebuild();
        }
    }

    /// Puts the content of `spare` into buckets.
    fn rebuild(&mut self) {
        let n = self.spare.len();
        (self.live, self.built) = (n, n);
        self.starts.clear();
        self.ends.clear();
        if n <= SCANNED {
            std::mem::swap(&mut self.items, &mut self.spare);
            (self.low, self.high, self.side, self.columns, self.rows) =
                (Point2::default(), Point2::default(), 1, 1, 1);
            self.starts.push(0);
            self.ends.push(n as u32);
            return;
        }
        let (mut low, mut high) = (self.spare[0].point, self.spare[0].point);
        for p in self.spare.iter().map(|i| i.point) {
            low = Point2::new(low.x.min(p.x), low.y.min(p.y));
            high = Point2::new(high.x.max(p.x), high.y.max(p.y));
        }
        (self.low, self.high) = (low, high);
        let (width, height) = high.minus(low);
        let wanted = n as f64 / 2.0;
        // A square of this side holds two points on average; a row of points needs the second bound.
        let square = ((width as f64) * (height as f64) / wanted).sqrt();
        let line = (width.max(height) as f64) / wanted;
        self.side = square.max(line).max(1.0) as i64 + 1;
        self.columns = width / self.side + 1;
        self.rows = height / self.side + 1;
        self.ends.resize((self.columns * self.rows) as usize, 0);
        for item in &self.spare {
            let (column, row) = self.bucket_of(item.point);
            self.ends[(row * self.columns + column) as usize] += 1;
        }
        let mut sum = 0;
        for end in &mut self.ends {
            self.starts.push(sum);
            sum += std::mem::replace(end, sum);
        }
        self.items.clear();
        self.items.resize(n, Item::default());
        for item in &self.spare {
            let (column, row) = self.bucket_of(item.point);
            let end = &mut self.ends[(row * self.columns + column) as usize];
            self.items[*end as usize] = *item;
            *end += 1;
        }
    }

    /// Column and row of the bucket nearest to `point`.
    fn bucket_of(&self, point: Point2) -> (i64, i64) {
        let (dx, dy) = point.minus(self.low);
        ((dx / self.side).clamp(0, self.columns - 1), (dy / self.side).clamp(0, self.rows - 1))
    }

    /// Squared distance and slot of the bucket's point nearest to `from`.
    fn scan(&self, bucket: usize, from: Point2) -> Option<(i64, usize)> {
        let range = self.starts[bucket] as usize..self.ends[bucket] as usize;
        let mut best = None;
        let mut best_key = (i64::MAX, u32::MAX);
        for (item, slot) in self.items[range.clone()].iter().zip(range) {
            let key = (square(item.point, from), item.number);
            if key < best_key {
                best_key = key;
                best = Some((key.0, slot));
            }
        }
        best
    }

    /// Bucket and slot of the point nearest to `from`, by rings of buckets around it.
    fn search(&self, from: Point2) -> Option<(usize, usize)> {
        let (column, row) = self.bucket_of(from);
        let mut best: Option<(i64, u32, usize, usize)> = None;
        for ring in 0..self.columns.max(self.rows) {
            for r in (row - ring).max(0)..=(row + ring).min(self.rows - 1) {
                let edge = r == row - ring || r == row + ring;
                let step = if edge { 1 } else { (2 * ring).max(1) };
                let mut c = column - ring;
                while c <= column + ring {
                    if (0..self.columns).contains(&c) {
                        let bucket = (r * self.columns + c) as usize;
                        if let Some((d, slot)) = self.scan(bucket, from) {
                            let key = (d, self.items[slot].number);
                            if best.is_none_or(|b| key < (b.0, b.1)) {
                                best = Some((key.0, key.1, bucket, slot));
                            }
                        }
                    }
                    c += step;
                }
            }
            // What lies in the rings beyond is at least `ring` whole buckets away from the point of
            // the box nearest to `from`, and no nearer to `from` itself.
            let beyond = ring * self.side;
            if best.is_some_and(|b| b.0 < beyond * beyond) {
                break;
            }
        }
        best.map(|b| (b.2, b.3))
    }
}

/// Squared distance \[nm²\].
pub(super) fn square(a: Point2, b: Point2) -> i64 {
    let (dx, dy) = a.minus(b);
    dx * dx + dy * dy
}

#[cfg(test)]
mod tests {
    use super::super::testing::Random;
    use super::*;

    /// Takes all points in turn from the set and by a plain scan.
    fn agrees(points: &[Point2], start: Point2, random: &mut Random) {
        let mut set = NearestSet::default();
        set.fill(points.iter().copied());
        let mut left: Vec<_> = (0..points.len()).collect();
        let mut at = start;
        while !left.is_empty() {
            if random.below(5) == 0 {
                let i = left.swap_remove(random.below(left.len() as u64) as usize);
                set.remove(i as u32, points[i]);
                continue;
            }
            let Some(best) = left.iter().copied().min_by_key(|&i| (square(points[i], at), i)) else { return };
            assert_eq!(set.take(at), Some((best as u32, points[best])), "seed {}", random.seed);
            at = points[best];
            left.retain(|&i| i != best);
        }
        assert_eq!(set.take(at), None);
    }

    #[test]
    fn buckets_and_a_plain_scan_agree() {
        for seed in 0..60 {
            let mut random = Random::new(seed);
            let n = random.below(400) as usize;
            let (w, h) = (1 + random.below(2_000_000), 1 + random.below(30_000_000));
            let points: Vec<_> = (0..n)
                .map(|_| Point2::new(random.below(w) as i32 - 900_000, random.below(h) as i32))
                .collect();
            let start = Point2::new(-(random.below(1 << 29) as i32), random.below(1 << 29) as i32);
            agrees(&points, start, &mut random);
        }
        let same = vec![Point2::new(5, 5); 100];
        agrees(&same, Point2::default(), &mut Random::new(1));
        let row: Vec<_> = (0..100).map(|i| Point2::new(i * 1000, 7)).collect();
        agrees(&row, Point2::default(), &mut Random::new(2));
    }
}
