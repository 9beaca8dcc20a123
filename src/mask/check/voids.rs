//! Voids through the layers: which are sealed, since when, until when.
//!
//! The voids of layers 0..=k are components of the background: within a layer connected across edges
//! and corners, from layer to layer where pixels lie over each other. The plate closes layer 0 from
//! below and the film layer k from above, so a component is sealed as long as it does not reach the
//! border of the panel. Only those with a part in the last layer are remembered; what has ended, or has
//! met the outside, is reported and forgotten.

use super::findings::{Fate, Fates, Marks};
use super::label::Sets;
use super::parts::{LayerParts, Region};
use std::sync::Arc;

/// A sealed void with a part in the last layer.
#[derive(Clone, Debug)]
pub(super) struct Sealed {
    /// Voids are numbered as they come; joined ones go on under the smallest number.
    number: u32,
    pub(super) first_layer: u32,
    /// Lower side of the first layer \[mm\].
    pub(super) bottom: f64,
    /// Upper side of the last layer \[mm\].
    pub(super) top: f64,
    /// All its pixels.
    pub(super) region: Region,
    /// Pixels times height \[mm\].
    pub(super) volume: f64,
    /// Pixels in the last layer.
    now: u64,
    /// Most pixels in a layer, and what that layer looks like.
    pub(super) greatest: u64,
    pub(super) marks: Arc<Marks>,
}

/// Number, upper side \[mm\] and thickness \[mm\] of a layer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) layer: u32,
    pub(super) z: f64,
    pub(super) height: f64,
}

/// Follows voids from layer to layer.
#[derive(Debug, Default)]
pub(super) struct Voids {
    sealed: Vec<Sealed>,
    /// Per hole of the last layer its void in `sealed`, counted from 1; 0 where it is open.
    of_hole: Vec<u32>,
    born: u32,
    pub(super) fates: Fates,
    sets: Sets,
}

impl Voids {
    /// Adds a layer. `below` is the one added before, none for the first; `ended` is called with every
    /// void that has opened or closed since.
    pub(super) fn push(
        &mut self,
        parts: &LayerParts,
        below: Option<&LayerParts>,
        place: Place,
        mut ended: impl FnMut(Sealed, Fate),
    ) {
        let before = std::mem::take(&mut self.sealed);
        let old = before.len() as u32;
        // 0 is the outside, then the voids, then the holes of this layer.
        self.sets.reset(1 + old + parts.holes.len() as u32);
        if let Some(below) = below {
            self.link(parts, below, old);
        }
        let mut slot = vec![0u32; 1 + before.len() + parts.holes.len()];
        let mut slots = 0;
        let mut of_hole = Vec::with_capacity(parts.holes.len());
        for hole in 0..parts.holes.len() as u32 {
            let root = self.sets.root(1 + old + hole) as usize;
            if root != 0 && slot[root] == 0 {
                slots += 1;
                slot[root] = slots;
            }
            of_hole.push(slot[root]);
        }
        let mut now: Vec<Option<Sealed>> = vec![None; slots as usize];
        for (i, void) in (1u32..).zip(before) {
            let root = self.sets.root(i) as usize;
            if root == 0 {
                ended(void, Fate::Opened);
            } else if slot[root] == 0 {
                self.fates.trap(void.number);
                ended(void, Fate::Closed);
            } else {
                let into = &mut now[slot[root] as usize - 1];
                *into = Some(match into.take() {
                    None => void,
                    Some(other) => {
                        let (whole, part) = (other.number.min(void.number), other.number.max(void.number));
                        self.fates.join(part, whole);
                        other.join(void, whole)
                    }
                });
            }
        }
        let born = &mut self.born;
        self.sealed = now.into_iter().map(|v| v.unwrap_or_else(|| Sealed::new(born, place))).collect();
        self.of_hole = of_hole;
        self.grow(parts, place);
    }

    /// Adds a layer equal to the last.
    pub(super) fn push_equal(&mut self, parts: &LayerParts, place: Place) {
        self.grow(parts, place);
    }

    /// Pixels of sealed voids in the last layer.
    pub(super) fn area(&self) -> u64 {
        self.sealed.iter().map(|v| v.now).sum()
    }

    /// The voids still sealed, behind the last layer.
    pub(super) fn finish(&mut self) -> Vec<Sealed> {
        std::mem::take(&mut self.sealed)
    }

    /// The sealed holes of the last layer.
    pub(super) fn marks(&self, layer: u32) -> Arc<Marks> {
        let holes = (0u32..).zip(&self.of_hole).filter(|(_, void)| **void > 0);
        let sealed = holes.map(|(hole, &void)| (hole, self.sealed[void as usize - 1].number)).collect();
        Arc::new(Marks { layer, sealed })
    }

    /// Unites what lies over each other.
    fn link(&mut self, parts: &LayerParts, below: &LayerParts, old: u32) {
        let of_hole = &self.of_hole;
        let void = |hole_behind: u32| match hole_behind {
            0 => 0,
            h => of_hole.get(h as usize - 1).copied().unwrap_or(0),
        };
        let sets = &mut self.sets;
        over(parts, below, |hole, background| {
            sets.join(1 + old + hole, void(background));
        });
        // Holes over holes are done; what is left are those that the outside lies over.
        if old > 0 {
            over(below, parts, |hole, background| {
                let void = void(hole + 1);
                if background == 0 && void > 0 {
                    sets.join(void, 0);
                }
            });
        }
    }

    /// Adds the last layer's areas to its voids.
    fn grow(&mut self, parts: &LayerParts, place: Place) {
        self.sealed.iter_mut().for_each(|v| v.now = 0);
        for (hole, &void) in parts.holes.iter().zip(&self.of_hole) {
            if void > 0 {
                let void = &mut self.sealed[void as usize - 1];
                void.now += hole.pixels;
                void.region.join(hole);
            }
        }
        let mut marks = None;
        for i in 0..self.sealed.len() {
            if self.sealed[i].now > self.sealed[i].greatest {
                let marks = marks.get_or_insert_with(|| self.marks(place.layer)).clone();
                self.sealed[i].greatest = self.sealed[i].now;
                self.sealed[i].marks = marks;
            }
            self.sealed[i].top = place.z;
            self.sealed[i].volume += self.sealed[i].now as f64 * place.height;
        }
    }
}

/// Calls `pair` for pieces of holes of `a` over pieces of the background of `b`: the hole, and the one
/// of `b` counted from 1, 0 for the outside.
fn over(a: &LayerParts, b: &LayerParts, mut pair: impl FnMut(u32, u32)) {
    let mut last = None;
    let (mut row, mut range, mut from) = (i32::MIN, 0..0, 0);
    for gap in &a.gaps {
        if gap.row != row {
            row = gap.row;
            range = b.rows.range(row);
            from = range.start;
        }
        from = b.background(range.clone(), from, [gap.start, gap.end], |background| {
            if last != Some((gap.hole, background)) {
                last = Some((gap.hole, background));
                pair(gap.hole, background);
            }
        });
    }
}

impl Sealed {
    fn new(born: &mut u32, place: Place) -> Self {
        *born += 1;
        Self {
            number: *born - 1,
            first_layer: place.layer,
            bottom: place.z - place.height,
            top: place.z,
            region: Region::default(),
            volume: 0.0,
            now: 0,
            greatest: 0,
            marks: Arc::default(),
        }
    }

    fn join(self, other: Self, number: u32) -> Self {
        let mut region = self.region;
        region.join(&other.region);
        let (low, _) = if self.first_layer <= other.first_layer { (&self, &other) } else { (&other, &self) };
        let (first_layer, bottom) = (low.first_layer, low.bottom);
        let volume = self.volume + other.volume;
        // Of equal areas the lower layer's counts, as everywhere.
        let later = (self.greatest, other.marks.layer) < (other.greatest, self.marks.layer);
        let wide = if later { other } else { self };
        Self { number, first_layer, bottom, region, volume, ..wide }
    }
}
