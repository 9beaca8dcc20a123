//! `microtome`: a GPU-compute slicer for 3D printing.
//!
//! A triangle mesh goes in, printable G-code comes out. The plane intersections run in WGSL compute
//! shaders on any Vulkan, Metal or DirectX 12 device; a complete CPU path gives the same bytes.
//!
//! Modules are listed from the cellar up; each uses only those above it in this list. See
//! `docs/ARCHITECTURE.md`.

pub mod cli;
pub mod contour;
pub mod gcode;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod infill;
pub mod job;
pub mod lattice;
pub mod mesh;
pub mod path;
pub mod region;
pub mod settings;
pub mod shaders;
pub mod slice;
pub mod span;
pub mod support;
