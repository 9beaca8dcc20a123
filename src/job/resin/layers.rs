//! All layers of a plate, in batches: on the CPU or on a GPU, with the same bytes.

use super::make::{Line, Made, Maker};
use super::plate::Plate;
use super::stream::Sender;
use crate::contour::{self, LayerContours, TraceOptions};
use crate::job::JobError;
use crate::job::backend::{Backend, BackendOptions};
use crate::job::summary::BackendSummary;
use crate::lattice::Point2;
use crate::slice::section::Sections;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Layers that are at most made at once by a thread, and by all threads, so that memory grows neither with
/// the print nor with the machine.
const LAYERS_AT_ONCE: [usize; 2] = [64, 512];

/// Layers for each thread.
fn layers_at_once(threads: usize) -> usize {
    let [alone, together] = LAYERS_AT_ONCE;
    (together / threads.max(1)).clamp(1, alone)
}

/// What is to be made.
pub(super) struct Wanted<'a> {
    pub plate: &'a Plate,
    /// Cutting planes \[nm, mesh frame\], ascending.
    pub planes: &'a [i32],
    /// Number of the first plane's layer in the print.
    pub first: u32,
    pub maker: &'a Maker<'a>,
    pub backend: &'a BackendOptions,
    pub trace: &'a TraceOptions,
}

/// What is known when all layers have been made.
pub(super) struct Done {
    pub backend: BackendSummary,
    /// A device that failed and was replaced.
    pub warning: Option<String>,
    /// Per layer what became of open contours, without the contours; empty for closed meshes.
    pub contours: Vec<LayerContours>,
}

impl Wanted<'_> {
    /// Makes all layers and sends them in order. Stops early, without an error, when nobody listens.
    ///
    /// # Errors
    /// [`JobError::Device`] where a GPU was demanded, [`JobError::Section`], [`JobError::Trace`].
    pub(super) fn make(&self, sender: &Sender<Arc<Made>>) -> Result<Done, JobError> {
        if self.plate.open {
            let contours = self.open(sender)?;
            let reason = "the mesh is open: its contours are closed on the CPU";
            return Ok(Done { backend: cpu(reason), warning: self.no_gpu(reason), contours });
        }
        if self.backend.backend == Backend::Cpu {
            return self.on_cpu(0, sender, "--backend cpu");
        }
        #[cfg(not(feature = "gpu"))]
        return match self.backend.backend {
            Backend::Gpu => Err(JobError::NoGpuSupport),
            _ => self.on_cpu(0, sender, "built without GPU support"),
        };
        #[cfg(feature = "gpu")]
        self.on_gpu_or_cpu(sender)
    }

    /// Layer number of a plane.
    pub(super) fn layer(&self, plane: usize) -> u32 {
        self.first + plane as u32
    }

    /// The planes from number `from` on by the CPU.
    pub(super) fn on_cpu(
        &self,
        from: usize,
        sender: &Sender<Arc<Made>>,
        reason: &str,
    ) -> Result<Done, JobError> {
        let done = Done { backend: cpu(reason), warning: None, contours: Vec::new() };
        let planes = &self.planes[from..];
        let threads = rayon::current_num_threads();
        let runs = (2 * threads).max(planes.len().div_ceil(layers_at_once(threads)));
        let sections = Sections::new(&self.plate.mesh, planes, runs)?;
        let numbers: Vec<usize> = (0..sections.runs().len()).collect();
        for wave in numbers.chunks(threads) {
            let made: Vec<Vec<Arc<Made>>> = wave
                .par_iter()
                .with_max_len(1)
                .map(|&run| {
                    let mut sweep = sections.sweep(run);
                    let mut line = Line::new(self.maker);
                    let mut made = Vec::new();
                    while let Some(section) = sweep.next_section() {
                        let layer = self.layer(from + section.plane);
                        made.push(line.layer(layer, section.edges, section.unchanged));
                    }
                    made
                })
                .collect();
            if !sender.send(made.into_iter().flatten().collect()) {
                break;
            }
        }
        Ok(done)
    }

    /// Layers of a mesh with holes: contours are traced and closed, and filled by their edges.
    fn open(&self, sender: &Sender<Arc<Made>>) -> Result<Vec<LayerContours>, JobError> {
        let (mesh, adjacency) = (&self.plate.mesh, &self.plate.adjacency);
        let mut reports = Vec::with_capacity(self.planes.len());
        let threads = rayon::current_num_threads();
        let at_once = layers_at_once(threads) * threads;
        for from in (0..self.planes.len()).step_by(at_once) {
            let run: Range<usize> = from..(from + at_once).min(self.planes.len());
            let traced = contour::trace(mesh, adjacency, &self.planes[run.clone()], self.trace)?;
            let block = run.len().div_ceil(threads);
            let made: Vec<Vec<Arc<Made>>> = traced
                .par_chunks(block.max(1))
                .enumerate()
                .map(|(b, layers)| {
                    let mut line = Line::new(self.maker);
                    let mut edges = Vec::new();
                    let numbered = (self.layer(from + b * block)..).zip(layers);
                    numbered
                        .map(|(layer, contours)| {
                            rings_to_edges(contours, &mut edges);
                            line.layer(layer, &edges, false)
                        })
                        .collect()
                })
                .collect();
            reports.extend(traced.into_iter().map(|l| LayerContours { rings: Vec::new(), ..l }));
            if !sender.send(made.into_iter().flatten().collect()) {
                break;
            }
        }
        Ok(reports)
    }

    /// A word for those who asked for a GPU and did not get it.
    fn no_gpu(&self, reason: &str) -> Option<String> {
        let asked = self.backend.backend == Backend::Gpu || self.backend.adapter.is_some();
        asked.then(|| format!("no GPU was used: {reason}"))
    }
}

/// The summary of work done by the CPU.
pub(super) fn cpu(reason: &str) -> BackendSummary {
    BackendSummary {
        kind: "cpu",
        adapter: None,
        reason: reason.to_owned(),
        threads: rayon::current_num_threads(),
    }
}

/// The sides of closed rings.
pub(super) fn rings_to_edges(contours: &LayerContours, edges: &mut Vec<[Point2; 2]>) {
    edges.clear();
    for ring in &contours.rings {
        let next = ring.iter().cycle().skip(1);
        edges.extend(ring.iter().zip(next).map(|(&a, &b)| [a, b]));
    }
}

#[cfg(test)]
mod tests {
    use super::layers_at_once;

    #[test]
    fn large_machines_take_no_more_memory() {
        assert_eq!([1, 2, 8, 16, 64, 1024].map(layers_at_once), [64, 64, 64, 32, 8, 1]);
    }
}
