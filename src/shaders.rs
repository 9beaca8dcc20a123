//! The registry of compute kernels: WGSL text, entry point, bindings, and the layout of the sizes that
//! each is given.
//!
//! Plain data without a driver, so that every build, also one without wgpu, can validate every shader.

use bytemuck::{Pod, Zeroable};

/// Invocations per workgroup of every kernel; 256 is what every WebGPU device offers.
pub const GROUP_SIZE: u32 = 256;

/// Values per workgroup of [`SCAN_BLOCK`].
pub const SCAN_BLOCK_LEN: u32 = 2048;

/// What a kernel sees behind a binding; the list's index is the binding's number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Binding {
    /// A uniform structure.
    Uniform,
    /// An array that the kernel reads.
    Read,
    /// An array that the kernel writes, and may read.
    Write,
}

/// One compute kernel.
#[derive(Clone, Copy, Debug)]
pub struct Kernel {
    /// The stem of its file in `shaders/`, also its name in errors and timings.
    pub name: &'static str,
    /// Its WGSL, shared parts included. The entry point is `main`.
    pub wgsl: &'static str,
    /// Its bindings in group 0.
    pub bindings: &'static [Binding],
}

/// Uniform of the slicing kernels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct SliceSizes {
    /// Triangles of the dispatch.
    pub triangles: u32,
    /// Planes in the run.
    pub planes: u32,
    /// Number, in the whole mesh, of the first triangle of the piece that is bound.
    pub piece: u32,
    /// The dispatch's first triangle, counted from the piece's first.
    pub begin: u32,
    /// Slot, in the whole run, of the dispatch's first segment.
    pub slot: u32,
    /// Segments of the dispatch.
    pub segments: u32,
    /// Zero; uniforms are padded to 16 bytes.
    pub padding: [u32; 2],
}

/// Uniform of [`SCAN_BLOCK`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct ScanSizes {
    /// Values to read; those beyond count as 0.
    pub input: u32,
    /// Sums to write.
    pub output: u32,
    /// Zero.
    pub padding: [u32; 2],
}

/// Uniform of [`SCAN_ADD`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct AddSizes {
    /// Sums to add to.
    pub sums: u32,
    /// Zero.
    pub padding: [u32; 3],
}

/// Exclusive prefix sums within blocks. Bindings: sizes, values, sums, block sums.
pub const SCAN_BLOCK: Kernel = Kernel {
    name: "scan_block",
    wgsl: concat!(include_str!("../shaders/shared/grid.wgsl"), include_str!("../shaders/scan_block.wgsl")),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Write, Binding::Write],
};

/// Adds what lies before each block. Bindings: sizes, sums before blocks, sums.
pub const SCAN_ADD: Kernel = Kernel {
    name: "scan_add",
    wgsl: concat!(include_str!("../shaders/shared/grid.wgsl"), include_str!("../shaders/scan_add.wgsl")),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Write],
};

/// Planes met by each triangle. Bindings: sizes, vertices, triangles, planes, first, count.
pub const SLICE_COUNT: Kernel = Kernel {
    name: "slice_count",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/slice.wgsl"),
        include_str!("../shaders/slice_count.wgsl")
    ),
    bindings: &[
        Binding::Uniform,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Write,
        Binding::Write,
    ],
};

/// Start and successor of each segment, an invocation per triangle. Bindings: sizes, vertices,
/// triangles, planes, twin, first, offset, start, next.
pub const SLICE_EMIT: Kernel = Kernel {
    name: "slice_emit",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/wide.wgsl"),
        include_str!("../shaders/shared/slice.wgsl"),
        include_str!("../shaders/shared/emit.wgsl"),
        include_str!("../shaders/slice_emit.wgsl")
    ),
    bindings: EMIT_BINDINGS,
};

/// The same as [`SLICE_EMIT`], an invocation per segment.
pub const SLICE_EMIT_EVEN: Kernel = Kernel {
    name: "slice_emit_even",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/wide.wgsl"),
        include_str!("../shaders/shared/slice.wgsl"),
        include_str!("../shaders/shared/emit.wgsl"),
        include_str!("../shaders/slice_emit_even.wgsl")
    ),
    bindings: EMIT_BINDINGS,
};

const EMIT_BINDINGS: &[Binding] = &[
    Binding::Uniform,
    Binding::Read,
    Binding::Read,
    Binding::Read,
    Binding::Read,
    Binding::Read,
    Binding::Read,
    Binding::Write,
    Binding::Write,
];

/// Every kernel of the crate.
pub const fn sources() -> &'static [Kernel] {
    &[SCAN_BLOCK, SCAN_ADD, SLICE_COUNT, SLICE_EMIT, SLICE_EMIT_EVEN]
}
