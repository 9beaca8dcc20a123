//! What the checks find.

use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// A connected part of a layer that nothing supports. Lengths \[mm\] on the plate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Island {
    /// The layer, counted from 0.
    pub layer: u32,
    /// Height of the layer's upper side over the plate.
    pub z_mm: f64,
    /// Its centroid.
    pub centre_mm: [f64; 2],
    /// Smallest x and y, greatest x and y.
    pub bounds_mm: [f64; 4],
    /// Its area \[mm²\].
    pub area_mm2: f64,
    /// Number of pixels.
    pub pixels: u64,
    /// What to draw of its layer.
    #[serde(skip)]
    pub marks: Arc<Marks>,
}

/// What became of a sealed void.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Fate {
    /// It met the outside in the layer behind its last: a suction cup until then.
    Opened,
    /// It was closed by solid without having met the outside: trapped resin, and a suction cup until
    /// then.
    Closed,
    /// It is open at the top of the last layer: a suction cup until the end of the print.
    Top,
}

/// A void that was sealed by the part, the plate and the film. Lengths \[mm\] on the plate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Void {
    /// What became of it.
    pub fate: Fate,
    /// The lowest layer that has a part of it.
    pub first_layer: u32,
    /// The last layer in which it was sealed.
    pub last_layer: u32,
    /// Lower side of its first layer and upper side of its last.
    pub z_mm: [f64; 2],
    /// Centroid of its pixels.
    pub centre_mm: [f64; 2],
    /// Smallest x and y, greatest x and y.
    pub bounds_mm: [f64; 4],
    /// Greatest area in one layer \[mm²\].
    pub greatest_area_mm2: f64,
    /// The first layer where it has that area.
    pub greatest_layer: u32,
    /// Volume in the layers in which it was sealed.
    pub volume_ml: f64,
    /// What to draw of the layer with its greatest area.
    #[serde(skip)]
    pub marks: Arc<Marks>,
}

/// The sealed holes of one layer, for its picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Marks {
    /// The layer.
    pub layer: u32,
    /// Holes of the layer ([`super::LayerParts::holes`]), each with the number of the void it belongs to.
    pub sealed: Vec<(u32, u32)>,
}

/// Figures of one layer. Areas \[mm²\].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct LayerFigures {
    /// Height of its upper side over the plate \[mm\].
    pub z_mm: f64,
    /// Lit area, greys counted in part.
    pub area_mm2: f64,
    /// Connected parts.
    pub parts: u32,
    /// Area of the largest of them.
    pub largest_part_mm2: f64,
    /// Area beyond reach of the layer below, islands included.
    pub overhang_mm2: f64,
    /// Number of islands.
    pub islands: u32,
    /// Area of the voids that are sealed while this layer is peeled from the film.
    pub sealed_mm2: f64,
    /// What pulls when this layer is peeled: solid pixels and sealed voids.
    pub peel_mm2: f64,
}

/// A list of bounded length that keeps the greatest, and counts all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Worst<T> {
    /// How many there were.
    pub count: u64,
    /// Sum of their sizes: areas \[mm²\] of islands, volumes \[ml\] of voids.
    pub total: f64,
    /// The greatest of them, in descending order; equal ones in the order in which they came.
    pub listed: Vec<T>,
    #[serde(skip)]
    sizes: Vec<f64>,
    #[serde(skip)]
    most: usize,
}

impl<T> Worst<T> {
    /// Lists `most` at most.
    pub fn new(most: usize) -> Self {
        Self { count: 0, total: 0.0, listed: Vec::new(), sizes: Vec::new(), most }
    }

    /// Counts one; it is made only if it comes on the list.
    pub fn add(&mut self, size: f64, item: impl FnOnce() -> T) {
        self.count += 1;
        self.total += size;
        let at = self.sizes.partition_point(|&s| s >= size);
        if at < self.most {
            self.sizes.insert(at, size);
            self.listed.insert(at, item());
            self.sizes.truncate(self.most);
            self.listed.truncate(self.most);
        }
    }
}

/// All that the checks found.
#[derive(Clone, Debug, Serialize)]
pub struct Findings {
    /// Figures of every layer.
    pub layers: Vec<LayerFigures>,
    /// Parts without support, the largest first.
    pub islands: Worst<Island>,
    /// Suction cups that drain: sealed voids that opened later or stayed open at the top, the one of the
    /// greatest volume first.
    pub cups: Worst<Void>,
    /// Sealed voids that were closed by solid, the one of the greatest volume first.
    pub trapped: Worst<Void>,
    /// Volume of the lit area \[ml\].
    pub volume_ml: f64,
    /// The layer with the greatest overhang, for its picture.
    #[serde(skip)]
    pub overhang_marks: Arc<Marks>,
    /// What became of voids by their numbers.
    #[serde(skip)]
    pub fates: Fates,
}

/// Which voids were trapped, by the numbers used in [`Marks`].
#[derive(Clone, Debug, Default)]
pub struct Fates {
    /// Voids that have become part of another one.
    joined: BTreeMap<u32, u32>,
    trapped: BTreeSet<u32>,
}

impl Fates {
    /// Void `part` has become part of void `whole`.
    pub(super) fn join(&mut self, part: u32, whole: u32) {
        self.joined.insert(part, whole);
    }

    /// A void was closed by solid.
    pub(super) fn trap(&mut self, void: u32) {
        self.trapped.insert(void);
    }

    /// True where the void, or the one that it became part of, was closed by solid in the end.
    pub fn is_trapped(&self, mut void: u32) -> bool {
        // Each is part of one with a smaller number, so this ends.
        while let Some(&whole) = self.joined.get(&void) {
            void = whole;
        }
        self.trapped.contains(&void)
    }
}
