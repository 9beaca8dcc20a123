//! What the normals stored in a file say about the winding of its facets.
//!
//! Only needed where a mesh's winding contradicts itself, so loading does not keep normals: they are
//! read again when they are wanted.

use super::detect::{Kind, detect};
use super::error::MeshError;
use super::frame::{Soup, nm_from_f32};
use super::load::utf8;
use super::stl::{ascii, binary};
use rayon::prelude::*;
use std::fs;
use std::path::Path;

/// For each triangle that [`super::load()`] keeps of this file, in its order: 1 where the stored normal
/// points to the side from which the corners run counter-clockwise, -1 where it points to the other,
/// 0 where there is no usable one (zero, not finite, or along the facet).
///
/// # Errors
/// [`MeshError`] when the file cannot be read any more.
pub fn facing(path: &Path) -> Result<Vec<i8>, MeshError> {
    let bytes = fs::read(path).map_err(|source| MeshError::Read { path: path.into(), source })?;
    Ok(facing_bytes(&bytes))
}

/// [`facing`] for bytes in memory. Bytes that are no STL file give an empty list.
pub fn facing_bytes(bytes: &[u8]) -> Vec<i8> {
    match detect(bytes) {
        Kind::Ascii => of_text(bytes),
        Kind::Utf16 { big_endian } => of_text(utf8(bytes, big_endian).as_bytes()),
        _ => match binary::parse(bytes) {
            Ok(soup) => signs(&soup, |i| soup.normal(i)),
            Err(_) => Vec::new(),
        },
    }
}

fn of_text(text: &[u8]) -> Vec<i8> {
    let text = text.strip_prefix(&[0xEF, 0xBB, 0xBF]).unwrap_or(text);
    let Ok(soup) = ascii::parse(text) else { return Vec::new() };
    let normals = ascii::normals(text);
    signs(&soup, |i| normals.get(i).copied().unwrap_or_default())
}

fn signs(soup: &impl Soup, normal: impl Fn(usize) -> [f32; 3] + Sync) -> Vec<i8> {
    (0..soup.len())
        .into_par_iter()
        .with_min_len(1 << 12)
        .filter_map(|i| {
            let corners = soup.facet(i).map(|c| c.map(nm_from_f32));
            let [a, b, c] = corners;
            // The facets that welding drops.
            (a != b && b != c && c != a).then(|| sign(corners, normal(i)))
        })
        .collect()
}

/// The side of (b - a) x (c - a) on which the normal lies.
fn sign([a, b, c]: [[i64; 3]; 3], normal: [f32; 3]) -> i8 {
    let minus = |p: [i64; 3], q: [i64; 3]| [0, 1, 2].map(|k| (p[k] - q[k]) as f64);
    let (u, v, n) = (minus(b, a), minus(c, a), normal.map(f64::from));
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    let dot = |p: [f64; 3], q: [f64; 3]| p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
    let along = dot(cross, n);
    // A normal within half a degree of the facet's plane says nothing; neither does one that is not
    // finite, of which every comparison is false.
    let clear = along * along > 1e-4 * dot(cross, cross) * dot(n, n);
    match (clear, along > 0.0) {
        (false, _) => 0,
        (true, true) => 1,
        (true, false) => -1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::load_bytes;

    const NORMALS: [[f32; 3]; 6] = [
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -0.5],
        [0.0, 0.0, 0.0],
        [f32::NAN, 0.0, 1.0],
        [0.0, f32::NEG_INFINITY, 0.0],
        [1.0, 1.0, 0.001],
    ];

    fn corners(i: usize) -> [[f32; 3]; 3] {
        let x = i as f32;
        // The third facet collapses.
        [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], if i == 2 { [x, 0.0, 0.0] } else { [x, 1.0, 0.0] }]
    }

    #[test]
    fn both_forms_of_a_file_say_the_same() {
        let mut bytes = vec![0; 80];
        bytes.extend(6u32.to_le_bytes());
        let mut text = String::from("solid normal facet\n");
        for (i, n) in NORMALS.iter().enumerate() {
            bytes.extend(n.iter().chain(corners(i).as_flattened()).flat_map(|c| c.to_le_bytes()));
            bytes.extend([0; 2]);
            let word = if i == 3 { "nan 0 -nan(ind)".into() } else { format!("{} {} {}", n[0], n[1], n[2]) };
            let [a, b, c] = corners(i).map(|c| format!("vertex {} {} {}", c[0], c[1], c[2]));
            text += &format!("facet normal {word}\nouter loop\n{a}\n{b}\n{c}\nendloop\nendfacet\n");
        }
        text += "endsolid\n";
        let expected = [1, -1, 0, 0, 0];
        assert_eq!(facing_bytes(&bytes), expected);
        assert_eq!(facing_bytes(text.as_bytes()), expected);
        for form in [bytes.as_slice(), text.as_bytes()] {
            let loaded = load_bytes(Path::new("a.stl"), form).map(|l| (l.mesh.triangles.len(), l.collapsed));
            assert_eq!(loaded.ok(), Some((5, 1)), "normals that are not finite are no error");
        }
        assert_eq!(facing_bytes(b"junk"), [0i8; 0]);
    }
}
