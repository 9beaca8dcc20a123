//! Flags for faulty meshes, shared by all commands that slice.

use crate::job::part::MeshOptions;
use crate::lattice::nm;
use crate::mesh::orient::Orient;
use clap::{Args, ValueEnum};

/// Where the outside of a mesh is taken from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum OrientArg {
    /// The winding where it is consistent; else the stored normals or the neighbouring facets
    #[default]
    Auto,
    /// The order of each facet's corners, as it is
    Winding,
    /// The normals stored in the file
    Normals,
    /// Neighbouring facets and nesting: consistent, outwards, cavities inwards
    Repair,
}

/// How to deal with faulty meshes, as typed.
#[derive(Clone, Debug, Default, Args)]
pub struct MeshArgs {
    /// Which way facets face
    #[arg(long, value_enum, default_value = "auto")]
    pub orient: OrientArg,
    /// Close gaps in open contours up to this width wherever they are [default: twice slice_closing_radius]
    #[arg(long, value_name = "MM", value_parser = tolerance)]
    pub match_tolerance: Option<f64>,
    /// Round vertices to a grid of this width before joining them, for example 0.01 [default: off]
    #[arg(long, value_name = "MM", value_parser = grid)]
    pub snap_grid: Option<f64>,
}

impl MeshArgs {
    /// The options as meant.
    pub fn options(&self) -> MeshOptions {
        MeshOptions {
            orient: match self.orient {
                OrientArg::Auto => Orient::Auto,
                OrientArg::Winding => Orient::Winding,
                OrientArg::Normals => Orient::Normals,
                OrientArg::Repair => Orient::Repair,
            },
            match_tolerance: self.match_tolerance.map(nm),
            snap_grid: self.snap_grid.map(nm),
        }
    }
}

fn tolerance(text: &str) -> Result<f64, String> {
    length(text, 0.0, 1000.0)
}

fn grid(text: &str) -> Result<f64, String> {
    length(text, 0.0, 10.0)
}

/// A length in millimetres within bounds.
pub(super) fn length(text: &str, lowest: f64, highest: f64) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    // False for NaN too.
    if (lowest..=highest).contains(&value) {
        Ok(value)
    } else {
        Err(format!("{value} mm is not between {lowest} and {highest} mm"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_checked() {
        assert_eq!(grid("0.01"), Ok(0.01));
        assert!(grid("10.5").is_err() && grid("-1").is_err() && grid("nan").is_err() && grid("x").is_err());
        let args = MeshArgs { snap_grid: Some(0.01), ..MeshArgs::default() };
        assert_eq!(args.options(), MeshOptions { snap_grid: Some(10_000), ..MeshOptions::default() });
    }
}
