//! A mesh as STL, for tests and examples.

use super::Mesh;
use crate::lattice::NM_PER_MM;
use std::io::{self, Write};

/// Writes binary STL in world coordinates \[mm\], zero normals.
///
/// # Errors
/// Those of the writer.
pub fn write_stl_binary(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    out.write_all(&[b' '; 80])?;
    out.write_all(&(mesh.triangles.len() as u32).to_le_bytes())?;
    for t in &mesh.triangles {
        let mut facet = [0u8; 50];
        for (k, c) in corners(mesh, t).as_flattened().iter().enumerate() {
            facet[12 + 4 * k..16 + 4 * k].copy_from_slice(&c.to_le_bytes());
        }
        out.write_all(&facet)?;
    }
    Ok(())
}

/// Writes ASCII STL in world coordinates \[mm\], zero normals, the shortest digits that read back as
/// the same 32-bit floats as the binary form holds.
///
/// # Errors
/// Those of the writer.
pub fn write_stl_ascii(mesh: &Mesh, out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "solid microtome")?;
    for t in &mesh.triangles {
        writeln!(out, "  facet normal 0 0 0\n    outer loop")?;
        for [x, y, z] in corners(mesh, t) {
            writeln!(out, "      vertex {x} {y} {z}")?;
        }
        writeln!(out, "    endloop\n  endfacet")?;
    }
    writeln!(out, "endsolid microtome")
}

fn corners(mesh: &Mesh, triangle: &[u32; 3]) -> [[f32; 3]; 3] {
    triangle.map(|v| {
        let p = mesh.vertices[v as usize];
        let [x, y, z] = mesh.origin;
        [x + i64::from(p.x), y + i64::from(p.y), z + i64::from(p.z)].map(|c| (c as f64 / NM_PER_MM) as f32)
    })
}
