//! The lattice frame of a triangle soup: where its zero lies and how its floats become nanometres.

use crate::lattice::{LIMIT, NM_PER_MM, Point3};

/// Coordinates beyond this are refused \[mm\]: at 1 km a 32-bit float steps by 0.06 mm.
pub(super) const FAR: f32 = 1e6;

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

/// 10^6 and one unit in its last place. The product with it is the exact one or its neighbour away from
/// zero, so that no tie is left, and none but ties change their side of a half: 38 bits leave room for 15.
const NM_BEYOND_TIES: f64 = f64::from_bits(NM_PER_MM.to_bits() + 1);

/// 1.5 · 2^52: adding it leaves a number below 2^51 rounded to an integer, in two's complement in the
/// low bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// [`nm_from_f32`] modulo 2^32 for coordinates up to [`FAR`], without a jump or a call: as the reach of a
/// part is below 2^31 nm, a difference of two of these tells the whole.
#[inline(always)]
pub(super) fn nm_modulo(mm: f32) -> i32 {
    (f64::from(mm) * NM_BEYOND_TIES + ROUND).to_bits() as i32
}

/// Floats that [`Bounds::add`] takes at a time: corners without a rest, and whole vectors.
pub(super) const LANES: usize = 12;

/// Lowest and highest coordinates of corners, in lanes of which the i-th belongs to axis i modulo 3.
#[derive(Clone, Copy)]
pub(super) struct Bounds {
    lo: [f32; LANES],
    hi: [f32; LANES],
    /// Not zero where a coordinate was beyond [`FAR`] or no number.
    wild: [u32; LANES],
}

impl Bounds {
    pub(super) const NONE: Self = Self { lo: [f32::MAX; LANES], hi: [f32::MIN; LANES], wild: [0; LANES] };

    /// Takes corners in.
    #[inline(always)]
    pub(super) fn add(&mut self, floats: &[f32; LANES]) {
        const FAR_BITS: i32 = FAR.to_bits() as i32;
        for (lane, &v) in floats.iter().enumerate() {
            self.lo[lane] = if v < self.lo[lane] { v } else { self.lo[lane] };
            self.hi[lane] = if v > self.hi[lane] { v } else { self.hi[lane] };
            // Bits of positive numbers are in the order of the numbers, and of those that are none, above.
            self.wild[lane] |= u32::from(v.abs().to_bits() as i32 > FAR_BITS);
        }
    }

    /// The bounds of both.
    pub(super) fn join(mut self, other: Self) -> Self {
        self.add(&other.lo);
        self.add(&other.hi);
        for (wild, other) in self.wild.iter_mut().zip(other.wild) {
            *wild |= other;
        }
        self
    }

    /// Puts the lattice's zero into the middle of the bounds, rounded down to the lattice. Moving the
    /// input by whole nanometres thus moves the origin and leaves the vertices as they are.
    ///
    /// `soup` is what was measured; a fault is looked for there.
    pub(super) fn frame(&self, soup: &impl Soup) -> Result<Frame, Fault> {
        if self.wild.contains(&1) {
            return Err(find(soup, |v, _| !near(v), None));
        }
        let mut origin = [0; 3];
        for (axis, origin) in origin.iter_mut().enumerate() {
            let lanes = |all: &[f32; LANES], pick: fn(f32, f32) -> f32, none: f32| {
                all.iter().skip(axis).step_by(3).fold(none, |a, &b| pick(a, b))
            };
            let (lo, hi) = (lanes(&self.lo, f32::min, f32::MAX), lanes(&self.hi, f32::max, f32::MIN));
            let (low, high) = (nm_from_f32(lo), nm_from_f32(hi));
            *origin = low + (high - low) / 2;
            if high - *origin >= i64::from(LIMIT) || *origin - low >= i64::from(LIMIT) {
                let extreme = if hi > -lo { hi } else { lo };
                let extent = (high - low) as f64 / NM_PER_MM;
                return Err(find(soup, |v, a| a == axis && v == extreme, Some(extent)));
            }
        }
        Ok(Frame { origin })
    }
}

impl Frame {
    /// A point modulo 2^32 on the lattice; it must lie within the bounds that were measured.
    #[inline(always)]
    pub(super) fn point(&self, p: Point3) -> Point3 {
        let [x, y, z] = self.origin.map(|o| o as i32);
        Point3::new(p.x.wrapping_sub(x), p.y.wrapping_sub(y), p.z.wrapping_sub(z))
    }
}

/// False for NaN too.
#[inline(always)]
fn near(mm: f32) -> bool {
    mm.abs() <= FAR
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

    fn measure(soup: &Vec<[[f32; 3]; 3]>) -> Result<Frame, Fault> {
        let mut bounds = Bounds::NONE;
        for facet in soup {
            let mut floats = [0.0; LANES];
            for (f, v) in floats.iter_mut().zip(facet.as_flattened().iter().cycle()) {
                *f = *v;
            }
            let mut one = Bounds::NONE;
            one.add(&floats);
            bounds = bounds.join(one);
        }
        bounds.frame(soup)
    }

    fn point(frame: &Frame, [x, y, z]: [f32; 3]) -> Point3 {
        frame.point(Point3::new(nm_modulo(x), nm_modulo(y), nm_modulo(z)))
    }

    #[test]
    fn the_quick_rounding_agrees_modulo_its_range() {
        let check = |v: f32| {
            for v in [v, -v] {
                assert_eq!(nm_modulo(v), nm_from_f32(v) as i32, "{v}");
            }
        };
        // All ties are odd multiples of 2^-7 mm: of those and of their neighbours, all that end in a half.
        for k in
            (1..1 << 24).step_by(2).take_while(|&k: &i32| k < 1 << 20).chain((1 << 20..1 << 24).step_by(1023))
        {
            let tie = k as f32 / 128.0;
            check(tie.next_down());
            check(tie);
            check(tie.next_up());
        }
        for bits in (0..=FAR.to_bits()).step_by(4999) {
            check(f32::from_bits(bits));
        }
        check(FAR);
    }

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
        let at = measure(&soup).map(|f| (f, point(&f, soup[0][0]), point(&f, soup[0][2])));
        for shift in [0.125f32, -3.5, 1000.0, -20_000.875] {
            let moved: Vec<_> = soup.iter().map(|t| t.map(|c: [f32; 3]| c.map(|v| v + shift))).collect();
            let got = measure(&moved).map(|f| (f, point(&f, moved[0][0]), point(&f, moved[0][2])));
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
