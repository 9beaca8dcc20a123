//! Points to be found by where they are.

/// Points with a tag, in square cells no smaller than the greatest distance asked for.
pub struct Near {
    origin: [f64; 2],
    cell: f64,
    size: [usize; 2],
    /// Per cell its last point.
    head: Vec<u32>,
    points: Vec<Point>,
}

struct Point {
    at: [f64; 2],
    tag: u32,
    /// The point of the cell before it.
    next: u32,
}

const NONE: u32 = u32::MAX;

impl Near {
    /// For points in a box; those outside are put into the cells at its border.
    pub fn new(low: [f64; 2], high: [f64; 2], distance: f64) -> Self {
        let extent = [0, 1].map(|k| (high[k] - low[k]).max(0.0));
        // A bound on the number of cells, whatever the box.
        let cell = distance.max(extent[0].max(extent[1]) / 256.0).max(1.0);
        let size = extent.map(|e| (e / cell) as usize + 1);
        Self { origin: low, cell, size, head: vec![NONE; size[0] * size[1]], points: Vec::new() }
    }

    fn cell_of(&self, at: [f64; 2]) -> [usize; 2] {
        [0, 1].map(|k| (((at[k] - self.origin[k]) / self.cell).max(0.0) as usize).min(self.size[k] - 1))
    }

    /// Adds a point.
    pub fn push(&mut self, at: [f64; 2], tag: u32) {
        let [x, y] = self.cell_of(at);
        let head = &mut self.head[y * self.size[0] + x];
        let next = std::mem::replace(head, self.points.len() as u32);
        self.points.push(Point { at, tag, next });
    }

    /// Whether a point with the tag lies within `distance`, which is at most the one given first.
    pub fn any(&self, at: [f64; 2], tag: u32, distance: f64) -> bool {
        let mut found = false;
        self.around(at, |p, square| found |= p.tag == tag && square <= distance * distance);
        found
    }

    /// All points near another with the squares of their distances.
    fn around(&self, at: [f64; 2], mut each: impl FnMut(&Point, f64)) {
        let [x, y] = self.cell_of(at);
        for y in y.saturating_sub(1)..=(y + 1).min(self.size[1] - 1) {
            for x in x.saturating_sub(1)..=(x + 1).min(self.size[0] - 1) {
                let mut next = self.head[y * self.size[0] + x];
                while let Some(p) = self.points.get(next as usize) {
                    let (u, v) = (p.at[0] - at[0], p.at[1] - at[1]);
                    each(p, u * u + v * v);
                    next = p.next;
                }
            }
        }
    }
}
