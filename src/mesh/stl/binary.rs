//! Binary STL: little-endian facets of 50 bytes behind an 84-byte header, read in place.

use crate::mesh::detect::{FACET, HEADER, claimed};
use crate::mesh::frame::Soup;

/// The facets of a binary file. Normals and attribute bytes are not read: a facet's corners say which
/// way it faces.
pub(in crate::mesh) struct Binary<'a> {
    facets: &'a [[u8; FACET]],
    /// Bytes behind the promised facets.
    pub(in crate::mesh) trailing: u64,
}

/// A header that promises more facets than the file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::mesh) struct Truncated {
    pub(in crate::mesh) claimed: u64,
    pub(in crate::mesh) held: u64,
}

/// Checks the count against the length; allocates nothing.
pub(in crate::mesh) fn parse(bytes: &[u8]) -> Result<Binary<'_>, Truncated> {
    let claimed = claimed(bytes).unwrap_or(0);
    let body = bytes.get(HEADER..).unwrap_or_default();
    let (facets, _) = body.as_chunks::<FACET>();
    let held = facets.len() as u64;
    if claimed > held {
        return Err(Truncated { claimed, held });
    }
    let facets = &facets[..claimed as usize];
    Ok(Binary { facets, trailing: (body.len() - facets.len() * FACET) as u64 })
}

impl Binary<'_> {
    /// The stored normal of a facet, whatever it is.
    pub(in crate::mesh) fn normal(&self, index: usize) -> [f32; 3] {
        let bytes = &self.facets[index];
        [0, 4, 8].map(|at| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]))
    }
}

impl Soup for Binary<'_> {
    fn len(&self) -> usize {
        self.facets.len()
    }

    #[inline(always)]
    fn facet(&self, index: usize) -> [[f32; 3]; 3] {
        let bytes = &self.facets[index];
        let mut corners = [[0.0; 3]; 3];
        for (k, c) in corners.as_flattened_mut().iter_mut().enumerate() {
            let at = 12 + 4 * k;
            *c = f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
        }
        corners
    }
}
