//! Slices a large body made by code and prints time and peak memory of every stage: the check that the
//! cost grows with triangles and segments alone and stays within the machine.
//!
//! `cargo run --release --example large -- [knot|sphere] [TRIANGLES] [PLANES]`, by default a knot of
//! 20,000,000 triangles and 2,000 planes. `RAYON_NUM_THREADS` sets the number of threads. Peak memory is
//! that of the stage where the system tells (Linux: `VmHWM`, reset between stages), else 0.

use microtome::contour::{self, TraceOptions};
use microtome::mesh::{Adjacency, Mesh, shapes};
use microtome::slice::chunk;
use std::error::Error;
use std::fs;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let number = |at: usize, default: usize| {
        words.get(at).map_or(Ok(default), |word| word.replace(['_', ','], "").parse::<usize>())
    };
    let (triangles, count) = (number(1, 20_000_000)?, number(2, 2_000)?);
    println!("{} threads; stage, seconds, peak MB", rayon::current_num_threads());
    let mesh = stage("generate", || match words.first().map(String::as_str) {
        Some("sphere") => {
            let around = ((triangles / 2) as f64).sqrt() as usize;
            shapes::sphere(80.0, around, triangles / 2 / around.max(1) + 1)
        }
        _ => shapes::knot(25.0, 8.0, triangles),
    });
    let planes = planes(&mesh, count as i64);
    let adjacency = stage("adjacency", || Adjacency::build(&mesh));
    let per_plane = stage("count", || chunk::segments_per_plane(&mesh, &planes));
    let options = TraceOptions { simplify_tolerance: None, match_tolerance: 0, memory_budget: 256 << 20 };
    let layers = stage("trace", || contour::trace(&mesh, &adjacency, &planes, &options))?;
    let segments: u64 = per_plane.iter().sum();
    let rings: usize = layers.iter().map(|l| l.rings.len()).sum();
    let points: usize = layers.iter().flat_map(|l| &l.rings).map(Vec::len).sum();
    println!(
        "{} triangles, {} planes, {segments} segments, {rings} contours, {points} points",
        mesh.triangles.len(),
        planes.len()
    );
    Ok(())
}

/// Evenly spaced planes in the middles of `count` layers \[nm\].
fn planes(mesh: &Mesh, count: i64) -> Vec<i32> {
    let Some([lo, hi]) = mesh.bounds() else { return Vec::new() };
    let (low, extent) = (i64::from(lo.z), i64::from(hi.z) - i64::from(lo.z));
    (0..count).map(|i| (low + (2 * i + 1) * extent / (2 * count)) as i32).collect()
}

/// Runs a stage and prints what it took.
fn stage<T>(name: &str, run: impl FnOnce() -> T) -> T {
    // Resets the mark of the highest memory use; without the right to, the mark is that of all stages.
    let _ = fs::write("/proc/self/clear_refs", "5");
    let begin = Instant::now();
    let result = run();
    println!("{name:10} {:8.3} {:8}", begin.elapsed().as_secs_f64(), peak_mb());
    result
}

fn peak_mb() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    line.and_then(|l| l.trim().trim_end_matches(" kB").parse::<u64>().ok()).unwrap_or(0) / 1000
}
