// What the kernels share that turn segments into spans: their sizes.
//
// Buckets are numbered by plane and row: row r of plane p of the run is bucket 1 + p * rows + r. Bucket 0
// is always empty; it makes an exclusive prefix sum of differences the buckets' counts.

struct SpanSizes {
    // Direction of the rows: s = a x + b y, t = a y - b x.
    a: i32,
    b: i32,
    // Position of the first line [units].
    base: i32,
    // Distance of lines [units].
    pitch: u32,
    lines: u32,
    // Rows of a line.
    sub_rows: u32,
    // Rows of a plane: lines * sub_rows.
    rows: u32,
    planes: u32,
    triangles: u32,
    segments: u32,
    // Crossings of the whole run.
    crossings: u32,
    padding: u32,
    // Where the rows of a line lie, from the line [units]; ascending, below the pitch.
    offsets: array<vec4<u32>, 4>,
}

@group(0) @binding(0) var<uniform> sizes: SpanSizes;

fn row_offset_in_line(row: u32) -> u32 {
    return sizes.offsets[row >> 2u][row & 3u];
}
