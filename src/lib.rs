//! `microtome`: a GPU-compute slicer for 3D printing.
//!
//! A triangle mesh goes in, printable G-code comes out. The plane intersections run in WGSL compute
//! shaders on any Vulkan, Metal or DirectX 12 device; a complete CPU path gives the same bytes.
//!
//! Modules are listed from the cellar up; each uses only those above it in this list. See
//! `docs/ARCHITECTURE.md`.

pub mod lattice;
pub mod settings;
pub mod shaders;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod mesh;
pub mod slice;
pub mod span;
pub mod mask;
pub mod resin;
pub mod contour;
pub mod region;
pub mod infill;
pub mod support;
pub mod path;
pub mod gcode;
pub mod picture;
pub mod export;
pub mod job;
pub mod slicer;
pub mod batch;
pub mod bench;
pub mod cli;

pub use slicer::Slicer;
