//! Segments with successor links → contours: the finish of a slice made by the shaders or their twin.

use super::finish::Finish;
use super::trace::{LayerContours, TraceOptions};
use crate::lattice::Point2;
use crate::mesh::{Mesh, OPEN};
use crate::slice::{Segments, crossing};
use rayon::prelude::*;

/// The contours of a run of planes from its segments, one entry per plane.
///
/// `planes` \[nm\], mesh frame, are those of the run alone. The same bytes as
/// [`super::trace::trace`] gives for these planes. Links that lead nowhere (a faulty device) end a
/// contour as an open edge does.
pub fn contours_of(
    mesh: &Mesh,
    planes: &[i32],
    segments: &Segments,
    options: &TraceOptions,
) -> Vec<LayerContours> {
    let places = Places::new(planes.len(), segments);
    (0..planes.len())
        .into_par_iter()
        .map_init(
            || (Finish::new(options), Plane::default()),
            |(finish, plane), k| {
                plane.gather(&places, segments, k);
                plane.walk(finish, |slot| {
                    end_of(mesh, planes[k], segments, places.order[places.base[k] + slot])
                });
                finish.layer()
            },
        )
        .collect()
}

/// Closed successor cycles and open chains among the segments of a run of planes: the contours as they
/// are before segments without length are removed and gaps are closed.
///
/// Links that lead nowhere, or to a segment that has a predecessor already, count as open.
pub fn count_cycles(segments: &Segments) -> (u64, u64) {
    let count = segments.next.len();
    let mut entered = vec![false; count];
    let mut open = 0;
    for &next in &segments.next {
        match entered.get_mut(next as usize) {
            Some(entered) if !*entered => *entered = true,
            _ => open += 1,
        }
    }
    // Chains begin where nothing leads to; what they do not reach is cycles.
    let mut taken = vec![false; count];
    for head in (0..count).filter(|&i| !entered[i]) {
        follow_links(segments, head, &mut taken);
    }
    let mut closed = 0;
    for i in 0..count {
        if !taken[i] {
            closed += 1;
            follow_links(segments, i, &mut taken);
        }
    }
    (closed, open)
}

/// Marks a segment and its successors up to the first that is marked.
fn follow_links(segments: &Segments, from: usize, taken: &mut [bool]) {
    let mut at = from;
    while let Some(mark) = taken.get_mut(at).filter(|mark| !**mark) {
        *mark = true;
        at = segments.next[at] as usize;
    }
}

/// Where every segment goes when they are sorted by plane.
struct Places {
    /// Per plane its first place; length = planes + 1.
    base: Vec<usize>,
    /// Per place the segment's slot.
    order: Vec<u32>,
    /// Per slot the place within its plane.
    local: Vec<u32>,
}

impl Places {
    fn new(planes: usize, segments: &Segments) -> Self {
        let mut step = vec![0i64; planes + 1];
        let ranges = || {
            segments.first.iter().zip(segments.offset.windows(2)).map(|(&first, slots)| {
                let first = (first as usize).min(planes);
                let count = (slots[1].saturating_sub(slots[0]) as usize).min(planes - first);
                (first..first + count, slots[0])
            })
        };
        for (range, _) in ranges() {
            step[range.start] += 1;
            step[range.end] -= 1;
        }
        let mut base = vec![0usize; planes + 1];
        let mut now = 0;
        for k in 0..planes {
            now += step[k];
            base[k + 1] = base[k] + now as usize;
        }
        let mut order = vec![0; base[planes]];
        let mut local = vec![OPEN; segments.start.len()];
        let mut cursor = base.clone();
        for (range, slot) in ranges() {
            for (slot, k) in (slot..).zip(range) {
                order[cursor[k]] = slot;
                if let Some(local) = local.get_mut(slot as usize) {
                    *local = (cursor[k] - base[k]) as u32;
                }
                cursor[k] += 1;
            }
        }
        Self { base, order, local }
    }
}

/// The segments of one plane, small enough for the cache.
#[derive(Default)]
pub(super) struct Plane {
    start: Vec<Point2>,
    /// Place of the successor, or [`OPEN`].
    next: Vec<u32>,
    taken: Vec<bool>,
}

impl Plane {
    fn gather(&mut self, places: &Places, segments: &Segments, k: usize) {
        let slots = &places.order[places.base[k]..places.base[k + 1]];
        let start = |&slot: &u32| segments.start.get(slot as usize).copied().unwrap_or_default();
        let next = |&slot: &u32| {
            let next = segments.next.get(slot as usize).copied().unwrap_or(OPEN);
            places.local.get(next as usize).copied().unwrap_or(OPEN)
        };
        self.fill(slots.iter().map(start), slots.iter().map(next));
    }

    /// Takes segments; a successor beyond them counts as [`OPEN`].
    pub(super) fn fill(&mut self, start: impl Iterator<Item = Point2>, next: impl Iterator<Item = u32>) {
        self.start.clear();
        self.start.extend(start);
        let count = self.start.len();
        self.next.clear();
        self.next.extend(next.map(|place| if (place as usize) < count { place } else { OPEN }));
        self.taken.clear();
        self.taken.resize(count, false);
    }

    /// Hands all contours to `finish`; `end` computes where the segment at a place ends.
    pub(super) fn walk(&mut self, finish: &mut Finish<'_>, end: impl Fn(usize) -> Option<Point2>) {
        if self.next.contains(&OPEN) {
            let mut head = vec![true; self.next.len()];
            for &next in &self.next {
                if next != OPEN {
                    head[next as usize] = false;
                }
            }
            for (place, _) in head.iter().enumerate().filter(|(_, head)| **head) {
                self.follow(place, finish, &end);
            }
        }
        for place in 0..self.next.len() {
            if !self.taken[place] {
                self.follow(place, finish, &end);
            }
        }
    }

    fn follow(&mut self, from: usize, finish: &mut Finish<'_>, end: impl Fn(usize) -> Option<Point2>) {
        let mut place = from;
        loop {
            self.taken[place] = true;
            finish.point(self.start[place]);
            let next = self.next[place] as usize;
            if next == from {
                finish.close();
                return;
            }
            if self.taken.get(next).is_none_or(|&taken| taken) {
                if let Some(end) = end(place) {
                    finish.point(end);
                }
                return finish.leave_open(&[]);
            }
            place = next;
        }
    }
}

/// Where a segment ends: the crossing of the edge by which the contour leaves its triangle.
fn end_of(mesh: &Mesh, z: i32, segments: &Segments, slot: u32) -> Option<Point2> {
    let triangle = segments.offset.partition_point(|&offset| offset <= slot).checked_sub(1)?;
    let corner = mesh.triangles.get(triangle)?.map(|v| mesh.vertices[v as usize]);
    let (_, up) = crossing::down_up(corner.map(|c| c.z), z);
    Some(crossing::point(corner[up], corner[(up + 1) % 3], z))
}
