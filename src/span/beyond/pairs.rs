//! Pairs of areas as the arrays that a device is given.

use super::super::{Rows, Span};
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// Ends of spans and half widths stay below this \[units\].
pub const REACH: i32 = 1 << 30;

/// Where a row meets the other area.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Place {
    /// The first of the other area's rows in reach, as an index into [`Pairs::cover_offset`].
    pub first: u32,
    /// Rows in reach to either side.
    pub reach: u32,
    /// Index of the half width for the row itself; those further away follow.
    pub width: u32,
    /// Zero.
    pub padding: u32,
}

/// Areas, and for each another one of which what it reaches is to be taken away.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pairs {
    /// Per row of the areas its first span. Length = rows + 1.
    pub offset: Vec<u32>,
    /// The areas' spans.
    pub spans: Vec<[i32; 2]>,
    /// Per row.
    pub places: Vec<Place>,
    /// Per row of the other areas, as far as they are in reach, its first span; an entry more for each area.
    pub cover_offset: Vec<u32>,
    /// The other areas' spans.
    pub cover: Vec<[i32; 2]>,
    /// Half widths \[units\].
    pub widths: Vec<i32>,
    /// Per pair its first row and its rows among all.
    areas: Vec<(i32, Range<usize>)>,
}

impl Pairs {
    /// Adds what [`super::beyond`] is given. False, and nothing is added, where coordinates or widths reach
    /// [`REACH`] or there is more than 32-bit indices hold.
    #[must_use]
    pub fn push(&mut self, a: &Rows, b: &Rows, widths: &[i32]) -> bool {
        let in_reach = |s: &Span| s.start > -REACH && s.end < REACH;
        let reach = widths.len().max(1) - 1;
        let rows = a.end() - a.first();
        let total = self.places.len() + self.cover_offset.len() + rows as usize + 2 * reach + 2;
        let spans = self.spans.len().max(self.cover.len()) + a.spans().len() + b.spans().len();
        let few = total + self.widths.len() < REACH as usize && spans < REACH as usize;
        let near = a.first().unsigned_abs().max(a.end().unsigned_abs()) < REACH as u32 && few;
        let narrow = widths.iter().all(|w| (0..REACH).contains(w));
        if !near || !narrow || !a.spans().iter().chain(b.spans()).all(in_reach) {
            return false;
        }
        if self.offset.is_empty() {
            self.offset.push(0);
        }
        let first = self.places.len();
        let (at, width) = (self.cover_offset.len() as u32, self.widths.len() as u32);
        for (i, (_, row)) in (0..).zip(a.iter()) {
            self.spans.extend(row.iter().map(|s| [s.start, s.end]));
            self.offset.push(self.spans.len() as u32);
            self.places.push(Place { first: at + i, reach: reach as u32, width, padding: 0 });
        }
        let reach = reach as i32;
        self.cover_offset.push(self.cover.len() as u32);
        for k in a.first() - reach..a.end() + reach {
            self.cover.extend(b.row(k).iter().map(|s| [s.start, s.end]));
            self.cover_offset.push(self.cover.len() as u32);
        }
        self.widths.extend(if widths.is_empty() { &[0] } else { widths });
        self.areas.push((a.first(), first..self.places.len()));
        true
    }

    /// What is left of each area, from where each row's spans begin and the spans. `None` where these do not
    /// fit the areas' rows.
    pub fn unpack(&self, offset: &[u32], spans: &[[i32; 2]]) -> Option<Vec<Rows>> {
        let area = |(first, rows): &(i32, Range<usize>)| {
            let offset = offset.get(rows.start..=rows.end)?;
            let range = *offset.first()? as usize..*offset.last()? as usize;
            let spans = spans.get(range)?.iter().map(|&[start, end]| Span { start, end }).collect();
            Rows::from_parts(*first, offset, spans)
        };
        self.areas.iter().map(area).collect()
    }
}
