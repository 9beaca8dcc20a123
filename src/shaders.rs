//! The registry of compute kernels: WGSL text, entry point, bindings, and the layout of the sizes that
//! each is given.
//!
//! Plain data without a driver, so that every build, also one without wgpu, can validate every shader.

use bytemuck::{Pod, Zeroable};

/// Invocations per workgroup of every kernel; 256 is what every WebGPU device offers.
pub const GROUP_SIZE: u32 = 256;

/// Values per workgroup of [`SCAN_BLOCK`], also keys of [`SORT_COUNT`] and [`SORT_SCATTER`].
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

/// Uniform of the welding kernels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct WeldSizes {
    /// Items of the dispatch: coordinates, corners or facets.
    pub items: u32,
    /// First corner of the part that is bound.
    pub corner: u32,
    /// Places in the table.
    pub capacity: u32,
    /// World position of the lattice's zero along x \[nm\], modulo 2^32.
    pub origin_x: u32,
    /// Along y.
    pub origin_y: u32,
    /// Along z.
    pub origin_z: u32,
    /// Zero.
    pub padding: [u32; 2],
}

/// Uniform of the sorting kernels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct SortSizes {
    /// Keys.
    pub length: u32,
    /// Lowest bit of the digit.
    pub shift: u32,
    /// Blocks of [`SCAN_BLOCK_LEN`] keys.
    pub blocks: u32,
    /// Zero.
    pub padding: u32,
}

/// Uniform of the kernels that pair half-edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct EdgeSizes {
    /// Half-edges.
    pub half_edges: u32,
    /// Zero.
    pub padding: [u32; 3],
}

/// Uniform of the kernels that turn segments into spans: a run of planes on a window of rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct SpanSizes {
    /// Direction of the rows: `s = a x + b y`, `t = a y - b x`.
    pub a: i32,
    /// See `a`.
    pub b: i32,
    /// Position of the first line \[units\].
    pub base: i32,
    /// Distance of lines \[units\].
    pub pitch: u32,
    /// Lines of a plane.
    pub lines: u32,
    /// Rows of a line.
    pub sub_rows: u32,
    /// Rows of a plane: `lines * sub_rows`.
    pub rows: u32,
    /// Planes in the run.
    pub planes: u32,
    /// Triangles of the mesh.
    pub triangles: u32,
    /// Segments of the run.
    pub segments: u32,
    /// Crossings of the run; not known to [`SPAN_COUNT`].
    pub crossings: u32,
    /// Zero.
    pub padding: u32,
    /// Where the rows of a line lie, from the line \[units\]; ascending, below the pitch.
    pub offsets: [u32; 16],
}

/// Uniform of the kernels that keep what is out of reach.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct BeyondSizes {
    /// Rows of all areas.
    pub rows: u32,
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

/// Floats to lattice points. Bindings: sizes, raw floats, x, y, z.
pub const WELD_CORNERS: Kernel = Kernel {
    name: "weld_corners",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/wide.wgsl"),
        include_str!("../shaders/shared/weld.wgsl"),
        include_str!("../shaders/weld_corners.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Write, Binding::Write, Binding::Write],
};

/// First corner of every place, in a table. Bindings: sizes, x, y, z, table.
pub const WELD_INSERT: Kernel = Kernel {
    name: "weld_insert",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/wide.wgsl"),
        include_str!("../shaders/shared/weld.wgsl"),
        include_str!("../shaders/shared/corners.wgsl"),
        include_str!("../shaders/weld_insert.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Read, Binding::Read, Binding::Write],
};

/// First corner at each corner's place. Bindings: sizes, x, y, z, table, first corners, whether new.
pub const WELD_FIND: Kernel = Kernel {
    name: "weld_find",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/wide.wgsl"),
        include_str!("../shaders/shared/weld.wgsl"),
        include_str!("../shaders/shared/corners.wgsl"),
        include_str!("../shaders/weld_find.wgsl")
    ),
    bindings: &[
        Binding::Uniform,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Write,
        Binding::Write,
    ],
};

/// Vertex ids of each facet. Bindings: sizes, first corners, numbers, ids, whether kept.
pub const WELD_FACETS: Kernel = Kernel {
    name: "weld_facets",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/weld.wgsl"),
        include_str!("../shaders/weld_facets.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Read, Binding::Write, Binding::Write],
};

/// Unique vertices. Bindings: sizes, x, y, z, numbers, vertices.
pub const WELD_VERTICES: Kernel = Kernel {
    name: "weld_vertices",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/wide.wgsl"),
        include_str!("../shaders/shared/weld.wgsl"),
        include_str!("../shaders/shared/corners.wgsl"),
        include_str!("../shaders/weld_vertices.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Read, Binding::Read, Binding::Read, Binding::Write],
};

/// Triangles that have not collapsed. Bindings: sizes, ids, places, triangles.
pub const WELD_TRIANGLES: Kernel = Kernel {
    name: "weld_triangles",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/weld.wgsl"),
        include_str!("../shaders/weld_triangles.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Read, Binding::Write],
};

/// Digits of each block of keys. Bindings: sizes, keys, counts.
pub const SORT_COUNT: Kernel = Kernel {
    name: "sort_count",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/sort.wgsl"),
        include_str!("../shaders/sort_count.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Write],
};

/// One pass of a radix sort. Bindings: sizes, keys, values, places, sorted keys, sorted values.
pub const SORT_SCATTER: Kernel = Kernel {
    name: "sort_scatter",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/sort.wgsl"),
        include_str!("../shaders/sort_scatter.wgsl")
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

/// Higher vertex and direction of each half-edge. Bindings: sizes, triangles, keys, values.
pub const EDGE_KEYS: Kernel = Kernel {
    name: "edge_keys",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/edges.wgsl"),
        include_str!("../shaders/edge_keys.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Write, Binding::Write],
};

/// Lower vertex of each half-edge. Bindings: sizes, triangles, values, keys.
pub const EDGE_LOWER_KEYS: Kernel = Kernel {
    name: "edge_lower_keys",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/edges.wgsl"),
        include_str!("../shaders/edge_lower_keys.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Read, Binding::Write],
};

/// Opposite of each half-edge. Bindings: sizes, triangles, sorted half-edges, twin.
pub const EDGE_PAIRS: Kernel = Kernel {
    name: "edge_pairs",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/edges.wgsl"),
        include_str!("../shaders/edge_pairs.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Read, Binding::Write],
};

/// Rows that each segment crosses. Bindings: sizes, start, next, first, offset, count, bucket, steps,
/// totals.
pub const SPAN_COUNT: Kernel = Kernel {
    name: "span_count",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/span.wgsl"),
        include_str!("../shaders/shared/segment.wgsl"),
        include_str!("../shaders/shared/owner.wgsl"),
        include_str!("../shaders/span_count.wgsl")
    ),
    bindings: &[
        Binding::Uniform,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Write,
        Binding::Write,
        Binding::Write,
        Binding::Write,
    ],
};

/// Crossings in their buckets. Bindings: sizes, start, next, offset, bucket, row offset, expected, keys.
pub const SPAN_FILL: Kernel = Kernel {
    name: "span_fill",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/wide.wgsl"),
        include_str!("../shaders/shared/span.wgsl"),
        include_str!("../shaders/shared/segment.wgsl"),
        include_str!("../shaders/shared/owner.wgsl"),
        include_str!("../shaders/span_fill.wgsl")
    ),
    bindings: &[
        Binding::Uniform,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Write,
        Binding::Write,
    ],
};

/// Spans in the place of each row's keys. Bindings: sizes, row offset, keys, count.
pub const SPAN_SORT: Kernel = Kernel {
    name: "span_sort",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/span.wgsl"),
        include_str!("../shaders/span_sort.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Write, Binding::Write],
};

/// Spans of all rows, densely. Bindings: sizes, row offset, keys, span offset, spans.
pub const SPAN_COMPACT: Kernel = Kernel {
    name: "span_compact",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/span.wgsl"),
        include_str!("../shaders/span_compact.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Read, Binding::Read, Binding::Write],
};

/// How many spans of each row are out of reach. Bindings: sizes, offset, spans, places, cover offset, cover,
/// widths, count.
pub const BEYOND_COUNT: Kernel = Kernel {
    name: "beyond_count",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/beyond.wgsl"),
        include_str!("../shaders/beyond_count.wgsl")
    ),
    bindings: &[
        Binding::Uniform,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Write,
    ],
};

/// The spans that are out of reach. Bindings: those of [`BEYOND_COUNT`] up to the widths, offset of what is
/// left, left.
pub const BEYOND_FILL: Kernel = Kernel {
    name: "beyond_fill",
    wgsl: concat!(
        include_str!("../shaders/shared/grid.wgsl"),
        include_str!("../shaders/shared/beyond.wgsl"),
        include_str!("../shaders/beyond_fill.wgsl")
    ),
    bindings: &[
        Binding::Uniform,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Read,
        Binding::Write,
    ],
};

/// Every kernel of the crate.
pub const fn sources() -> &'static [Kernel] {
    &[
        SCAN_BLOCK,
        SCAN_ADD,
        SORT_COUNT,
        SORT_SCATTER,
        WELD_CORNERS,
        WELD_INSERT,
        WELD_FIND,
        WELD_FACETS,
        WELD_VERTICES,
        WELD_TRIANGLES,
        EDGE_KEYS,
        EDGE_LOWER_KEYS,
        EDGE_PAIRS,
        SLICE_COUNT,
        SLICE_EMIT,
        SLICE_EMIT_EVEN,
        SPAN_COUNT,
        SPAN_FILL,
        SPAN_SORT,
        SPAN_COMPACT,
        BEYOND_COUNT,
        BEYOND_FILL,
    ]
}
