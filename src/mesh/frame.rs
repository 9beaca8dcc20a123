//! The lattice frame of a triangle soup: where its zero lies and how its floats become nanometres.

use crate::lattice::{LIMIT, NM_PER_MM, Point3};
use rayon::prelude::*;

/// Coordinates beyond this are refused \[mm\]: at 1 km a 32-bit float steps by 0.06 mm.
pub(super) const FAR: f32 = 1e6;

/// Facets that one task measures; any value gives the same result.
const RUN: usize = 1 << 15;

/// Triangles as a file gives them, three corners in millimetres each.
pub(super) trait Soup: Sync {
    /// Number of facets.
    fn len(&self) -> usize;
    /// Corners of a facet below `len` \[mm\].
    fn facet(&self, index: usize) -> [[f32; 3]; 3];
}

/// World position of the lattice's zero \[nm\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Frame {
    pub(super) origin: [i64; 3],
}

/// A coordinate that has no place on the lattice; facet and corner counted from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Fault {
    pub(super) facet: usize,
    pub(super) corner: usize,
    pub(super) axis: usize,
    pub(super) value: f32,
    /// Length of the part along `axis` \[mm\] where that is what is wrong.
    pub(super) extent: Option<f64>,
}

/// Millimetres to nanometres, halves away from zero.
///
/// The product is exact (24 bits times the 14 odd bits of 10^6), and with at most 38 significant
/// bits adding a half cannot round up across an integer, so truncation gives the rounded value.
pub(super) fn nm_from_f32(mm: f32) -> i64 {
    let nm = f64::from(mm) * NM_PER_MM;
    (nm + 0.5f64.copysign(nm)) as i64
}

/// Puts the lattice's zero into the middle of the bounds, rounded down to the lattice. Moving the
/// input by whole nanometres thus moves the origin and leaves the vertices as they are.
pub(super) fn measure(soup: &impl Soup) -> Result<Frame, Fault> {
    let facets = soup.len();
    let (lo, hi, wild) = (0..facets.div_ceil(RUN))
        .into_par_iter()
        .map(|run| bounds(soup, run * RUN..facets.min((run + 1) * RUN)))
        .reduce(|| ([f32::MAX; 3], [f32::MIN; 3], false), join);
    if wild {
        return Err(find(soup, |v, _| !near(v), None));
    }
    let mut origin = [0; 3];
    for axis in 0..3 {
        let (low, high) = (nm_from_f32(lo[axis]), nm_from_f32(hi[axis]));
        origin[axis] = low + (high - low) / 2;
        if high - origin[axis] >= i64::from(LIMIT) || origin[axis] - low >= i64::from(LIMIT) {
            let extreme = if hi[axis] > -lo[axis] { hi[axis] } else { lo[axis] };
            let extent = (high - low) as f64 / NM_PER_MM;
            return Err(find(soup, |v, a| a == axis && v == extreme, Some(extent)));
        }
    }
    Ok(Frame { origin })
}

impl Frame {
    /// A corner on the lattice; it must lie within the bounds that were measured.
    pub(super) fn point(&self, corner: [f32; 3]) -> Point3 {
        let at = |axis: usize| (nm_from_f32(corner[axis]) - self.origin[axis]) as i32;
        Point3::new(at(0), at(1), at(2))
    }
}

/// False for NaN too.
fn near(mm: f32) -> bool {
    mm.abs() <= FAR
}

type Bounds = ([f32; 3], [f32; 3], bool);

fn bounds(soup: &impl Soup, facets: std::ops::Range<usize>) -> Bounds {
    let (mut lo, mut hi, mut wild) = ([f32::MAX; 3], [f32::MIN; 3], false);
    for facet in facets {
        for corner in soup.facet(facet) {
            for axis in 0..3 {
                let v = corner[axis];
                lo[axis] = if v < lo[axis] { v } else { lo[axis] };
                hi[axis] = if v > hi[axis] { v } else { hi[axis] };
                wild |= !near(v);
            }
        }
    }
    (lo, hi, wild)
}

fn join(a: Bounds, b: Bounds) -> Bounds {
    let pick = |f: fn(f32, f32) -> f32, a: [f32; 3], b: [f32; 3]| [0, 1, 2].map(|i| f(a[i], b[i]));
    (pick(f32::min, a.0, b.0), pick(f32::max, a.1, b.1), a.2 || b.2)
}

/// The first coordinate for which `is` holds. Only reached when there is one.
fn find(soup: &impl Soup, is: impl Fn(f32, usize) -> bool, extent: Option<f64>) -> Fault {
    for facet in 0..soup.len() {
        for (corner, position) in soup.facet(facet).into_iter().enumerate() {
            for (axis, value) in position.into_iter().enumerate() {
                if is(value, axis) {
                    return Fault { facet, corner, axis, value, extent };
                }
            }
        }
    }
    Fault { facet: 0, corner: 0, axis: 0, value: 0.0, extent }
}
