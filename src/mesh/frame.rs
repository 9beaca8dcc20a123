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
#[inline(always)]
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
    #[inline(always)]
    pub(super) fn point(&self, corner: [f32; 3]) -> Point3 {
        let [x, y, z] = corner;
        Point3::new(
            (nm_from_f32(x) - self.origin[0]) as i32,
            (nm_from_f32(y) - self.origin[1]) as i32,
            (nm_from_f32(z) - self.origin[2]) as i32,
        )
    }
}

/// False for NaN too.
#[inline(always)]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_is_to_nearest_halves_away_from_zero() {
        assert_eq!(nm_from_f32(0.2), 200_000);
        assert_eq!(nm_from_f32(-0.2), -200_000);
        // 2^-7 mm = 7812.5 nm.
        assert_eq!((nm_from_f32(0.007_812_5), nm_from_f32(-0.007_812_5)), (7813, -7813));
        assert_eq!(nm_from_f32(f32::MIN_POSITIVE), 0);
        assert_eq!(nm_from_f32(-0.0), 0);
        for bits in (0..0x4980_0000u32).step_by(99_991) {
            let v = f32::from_bits(bits);
            assert_eq!(nm_from_f32(v), (f64::from(v) * NM_PER_MM).round() as i64, "{v}");
            assert_eq!(nm_from_f32(-v), -nm_from_f32(v), "{v}");
        }
    }

    #[test]
    fn moving_the_input_moves_the_origin_alone() {
        let soup = vec![[[0.125, 0.25, 0.5], [3.75, -1.0, 2.0], [1.5, 7.625, -9.0]]];
        let at = measure(&soup).map(|f| (f, f.point(soup[0][0]), f.point(soup[0][2])));
        for shift in [0.125f32, -3.5, 1000.0, -20_000.875] {
            let moved: Vec<_> = soup.iter().map(|t| t.map(|c: [f32; 3]| c.map(|v| v + shift))).collect();
            let got = measure(&moved).map(|f| (f, f.point(moved[0][0]), f.point(moved[0][2])));
            let (Ok(at), Ok(got)) = (&at, &got) else { unreachable!("both are in range") };
            assert_eq!((at.1, at.2), (got.1, got.2), "{shift}");
            assert_eq!(at.0.origin.map(|o| o + nm_from_f32(shift)), got.0.origin, "{shift}");
        }
    }

    #[test]
    fn the_reach_of_the_lattice_is_checked() {
        let soup = |lo: f32, hi: f32| vec![[[lo, 0.0, 0.0], [hi, 0.0, 0.0], [0.0, 1.0, 0.0]]];
        assert!(measure(&soup(0.0, 2147.4836)).is_ok());
        let fault = measure(&soup(0.0, 2147.484));
        assert!(
            matches!(fault, Err(Fault { facet: 0, corner: 1, axis: 0, extent: Some(_), .. })),
            "{fault:?}"
        );
        assert!(matches!(measure(&soup(0.0, f32::NAN)), Err(Fault { corner: 1, extent: None, .. })));
        assert!(matches!(measure(&soup(-2e6, 0.0)), Err(Fault { corner: 0, extent: None, .. })));
    }
}
