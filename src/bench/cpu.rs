//! The CPU core, and the algorithms of the literature.

use super::case::Case;
use super::machine::{median, once, pool};
use super::report::{Sink, Stage, Verdict};
use super::{BenchError, Options, RAW};
use crate::contour::{self, LayerContours};
use crate::job::JobError;
use crate::lattice::area2;
use crate::mesh::Adjacency;
use crate::slice::classic::{self, Algorithm, Assembled};
use crate::slice::cpu as twin;
use sha2::{Digest, Sha256};

/// The CPU core's output, with which all others are compared.
pub(super) struct Reference {
    pub(super) sha256: String,
    pub(super) rings: u64,
    /// Per plane twice the enclosed area \[nm²\].
    areas: Vec<i128>,
}

impl Reference {
    fn new(layers: &[LayerContours]) -> Self {
        Self {
            sha256: digest(layers),
            rings: layers.iter().map(|l| l.rings.len() as u64).sum(),
            areas: layers.iter().map(|l| l.rings.iter().map(|r| area2(r)).sum()).collect(),
        }
    }

    /// Compares contours.
    pub(super) fn verdict(&self, layers: &[LayerContours]) -> Verdict {
        if digest(layers) == self.sha256 { Verdict::Equal } else { Verdict::Different }
    }

    fn verdict_of_areas(&self, planes: &[Assembled]) -> Verdict {
        let areas = planes.iter().map(|p| p.rings.iter().map(|r| area2(r)).sum::<i128>());
        if areas.eq(self.areas.iter().copied()) { Verdict::EqualArea } else { Verdict::Different }
    }
}

/// SHA-256 of numbers of rings, numbers of points, and points.
fn digest(layers: &[LayerContours]) -> String {
    let mut hash = Sha256::new();
    for layer in layers {
        hash.update((layer.rings.len() as u64).to_le_bytes());
        for ring in &layer.rings {
            hash.update((ring.len() as u64).to_le_bytes());
            hash.update(bytemuck::cast_slice::<_, u8>(ring));
        }
    }
    hash.finalize().iter().map(|b| format!("{b:02x}")).collect()
}

/// Adjacency and contours on the CPU core, at each number of threads if it is asked for.
pub(super) fn core(case: &Case, options: &Options, sink: &mut Sink<'_>) -> Result<Reference, BenchError> {
    let mut reference = None;
    let timed = options.algorithms.contains(&Algorithm::Main);
    for &threads in if timed { &options.threads[..] } else { &[1] } {
        let pool = pool(threads)?;
        let trace = || contour::trace(&case.mesh, &case.adjacency, &case.planes, &RAW);
        if !timed {
            reference = Some(Reference::new(&pool.install(trace).map_err(JobError::from)?));
            break;
        }
        let (time, _) = pool.install(|| median(options.runs, || Adjacency::build(&case.mesh)));
        let stage = Stage::new("cpu core", "adjacency", threads).bytes([36, 16, 0, 0], "36 T + 16 V");
        sink.row(stage, time, None);
        let (time, layers) = pool.install(|| median(options.runs, trace));
        let layers = layers.map_err(JobError::from)?;
        let verdict = match &reference {
            Some(reference) => reference.verdict(&layers),
            None => {
                reference = Some(Reference::new(&layers));
                Verdict::Equal
            }
        };
        let stage = Stage::new("cpu core", "trace", threads).bytes([36, 12, 0, 36], "36 T + 12 V + 36 S");
        sink.row(stage, time, Some(verdict));
    }
    Ok(reference.unwrap_or_else(|| Reference::new(&[])))
}

/// The reference twin and the algorithms of the literature, on one thread as they were published.
pub(super) fn classic(
    case: &Case,
    reference: &Reference,
    options: &Options,
    sink: &mut Sink<'_>,
) -> Result<(), BenchError> {
    let pool = pool(1)?;
    for &algorithm in &options.algorithms {
        // Segments twice, as lists and in the common buffers, and what the walk adds.
        let bytes = case.segments().saturating_mul(64);
        if bytes > options.memory_limit {
            let (need, limit) = (bytes >> 20, options.memory_limit >> 20);
            sink.skip(format!("{}: its segments take {need} MiB, the bound is {limit}", engine(algorithm)));
        } else if algorithm == Algorithm::Trivial && case.work() > options.work_limit {
            let (work, limit) = (case.work(), options.work_limit);
            sink.skip(format!("{algorithm}: {work} triangle-planes, the bound is {limit}"));
        } else {
            pool.install(|| one(algorithm, case, reference, options, sink));
        }
    }
    Ok(())
}

fn engine(algorithm: Algorithm) -> &'static str {
    match algorithm {
        Algorithm::Main => "reference twin",
        _ => algorithm.name(),
    }
}

fn one(algorithm: Algorithm, case: &Case, reference: &Reference, options: &Options, sink: &mut Sink<'_>) {
    let (mesh, links, planes) = (&case.mesh, &case.adjacency, &case.planes[..]);
    let stage = |name| Stage::new(engine(algorithm), name, 1);
    let segments = if algorithm == Algorithm::Main {
        let (time, segments) = median(options.runs, || twin::slice(mesh, links, planes));
        sink.row(stage("slice+link").bytes([72, 36, 0, 24], "72 T + 36 V + 24 S"), time, None);
        segments
    } else {
        let (time, layers) = median(options.runs, || classic::run(algorithm, mesh, planes));
        let (bytes, formula) = slicing_bytes(algorithm);
        sink.row(stage("slice").bytes(bytes, formula), time, None);
        let (time, assembled) = median(options.runs, || classic::assemble(&layers));
        // Chains of an open mesh are closed by rules of their own.
        let verdict = case.closed.then(|| reference.verdict_of_areas(&assembled));
        drop(assembled);
        sink.row(stage("assemble").bytes([0, 0, 0, 101], "101 S"), time, verdict);
        let (time, segments) = median(options.runs, || classic::link(mesh, links, planes, &layers));
        sink.row(stage("link").bytes([20, 0, 0, 92], "20 T + 92 S"), time, None);
        segments
    };
    let (time, layers) = once(|| contour::contours_of(mesh, planes, &segments, &RAW));
    let verdict = reference.verdict(&layers);
    sink.row(stage("walk").bytes([16, 0, 0, 56], "16 T + 56 S"), time, Some(verdict));
}

/// What slicing alone moves: ids (12 bytes a triangle) and coordinates (12 a corner), lists, and 20 bytes
/// for each segment written.
fn slicing_bytes(algorithm: Algorithm) -> ([u64; 4], &'static str) {
    match algorithm {
        Algorithm::Main | Algorithm::Trivial => ([0, 0, 48, 20], "48 T P + 20 S"),
        Algorithm::Sweep => ([77, 32, 0, 72], "77 T + 32 V + 72 S"),
        Algorithm::Grouping => ([72, 0, 0, 80], "72 T + 80 S"),
        Algorithm::Incremental => ([80, 0, 0, 84], "80 T + 84 S"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moved_point_is_seen() {
        let layers = |x| {
            let ring = [(0, 0), (x, 0), (0, 9)].map(|(x, y)| crate::lattice::Point2::new(x, y)).to_vec();
            vec![LayerContours { rings: vec![ring], ..LayerContours::default() }, LayerContours::default()]
        };
        let reference = Reference::new(&layers(7));
        assert_eq!(reference.verdict(&layers(7)), Verdict::Equal);
        assert_eq!(reference.verdict(&layers(8)), Verdict::Different);
        assert_eq!(reference.verdict(&layers(7)[..1]), Verdict::Different);
        let assembled = |x| layers(x).into_iter().map(|l| Assembled { rings: l.rings, chains: vec![] });
        assert_eq!(reference.verdict_of_areas(&assembled(7).collect::<Vec<_>>()), Verdict::EqualArea);
        assert_eq!(reference.verdict_of_areas(&assembled(8).collect::<Vec<_>>()), Verdict::Different);
    }
}
