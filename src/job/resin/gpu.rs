//! Layers by a device: it slices and scans, the host makes pixels and bytes of the spans.

use super::layers::{Done, Wanted};
use super::make::{Made, Maker};
use super::plate::Plate;
use super::stream::Sender;
use crate::gpu::GpuError;
use crate::job::JobError;
use crate::job::backend::Backend;
use crate::job::summary::BackendSummary;
use crate::job::warm::{self, Lease, Taken};
use crate::slice::chunk;
use crate::slice::gpu::GpuMesh;
use crate::span::gpu::GpuSpans;
use crate::span::{RowWindow, Rows, WindowError};
use rayon::prelude::*;
use std::sync::Arc;

/// Why a device has not made all layers.
enum Stop {
    Device(GpuError),
    /// Rows that no device takes.
    Window(WindowError),
    /// A plane with open contours, which are the host's.
    Open,
    /// Nobody listens any more.
    Gone,
}

impl From<GpuError> for Stop {
    fn from(error: GpuError) -> Self {
        Self::Device(error)
    }
}

impl Stop {
    fn device(&self) -> Option<&GpuError> {
        match self {
            Self::Device(error) => Some(error),
            _ => None,
        }
    }
}

impl Wanted<'_> {
    /// On the device wished for; where that is left to us, on the CPU if the work does not repay a device or
    /// the device fails, from the planes in hand on.
    pub(super) fn on_gpu_or_cpu(&self, sender: &Sender<Arc<Made>>) -> Result<Done, JobError> {
        let mesh = &self.plate.mesh;
        let per_plane = chunk::segments_per_plane(mesh, self.planes);
        let wish = self.backend;
        let lease = match warm::take(wish, mesh.triangles.len() as u64, per_plane.iter().sum())? {
            Taken::Device(lease) => lease,
            Taken::Cpu { reason, warning } => return Ok(Done { warning, ..self.on_cpu(0, sender, reason)? }),
        };
        let adapter = Some(lease.name());
        let mut sent = 0;
        let reason = if wish.adapter.is_some() { "named with --adapter" } else { "the best hardware GPU" };
        let failure = match self.on_gpu(lease, &per_plane, &mut sent, sender) {
            Ok(()) | Err(Stop::Gone) => {
                let backend = BackendSummary { kind: "gpu", adapter, ..super::layers::cpu(reason) };
                return Ok(Done { backend, warning: None, contours: Vec::new() });
            }
            Err(Stop::Device(failure)) => {
                if wish.backend == Backend::Gpu {
                    return Err(failure.into());
                }
                failure.to_string()
            }
            Err(Stop::Window(failure)) => failure.to_string(),
            Err(Stop::Open) => "a plane has open contours".to_owned(),
        };
        let warning = match sent {
            0 => format!("{failure}; the CPU took over, with the same result"),
            sent => format!(
                "{failure}; the CPU took over from layer {} of {}, with the same result",
                sent + 1,
                self.planes.len()
            ),
        };
        let done = self.on_cpu(sent, sender, "the GPU failed")?;
        let backend = match sent {
            0 => done.backend,
            _ => BackendSummary {
                kind: "gpu",
                adapter,
                ..super::layers::cpu("the GPU failed on the way; the CPU did the rest")
            },
        };
        Ok(Done { backend, warning: Some(warning), ..done })
    }

    fn on_gpu(
        &self,
        lease: Lease,
        per_plane: &[u64],
        sent: &mut usize,
        sender: &Sender<Arc<Made>>,
    ) -> Result<(), Stop> {
        let window = self.window().map_err(Stop::Window);
        let Plate { mesh, adjacency, .. } = self.plate;
        let work = |spans: &mut GpuSpans, resident: &GpuMesh| {
            spans.scan(resident, self.planes, per_plane, &window?, |run, rows| {
                let rows: Vec<Rows> = rows.into_iter().collect::<Option<_>>().ok_or(Stop::Open)?;
                let block = rows.len().div_ceil(rayon::current_num_threads()).max(1);
                let made: Vec<Vec<Arc<Made>>> = rows
                    .par_chunks(block)
                    .enumerate()
                    .map(|(b, rows)| make(self.maker, self.layer(run.start + b * block), rows))
                    .collect();
                if !sender.send(made.into_iter().flatten().collect()) {
                    return Err(Stop::Gone);
                }
                *sent = run.end;
                Ok(())
            })
        };
        lease.scan(mesh, adjacency, self.trace.memory_budget, work, Stop::device)
    }

    /// The rows of the raster that the part reaches.
    fn window(&self) -> Result<RowWindow, WindowError> {
        let raster = self.maker.raster;
        let frame = raster.frame();
        let lines = raster.rows().end / frame.sub_rows().max(1) as i32;
        let [lo, hi] = self.plate.mesh.bounds().unwrap_or_default();
        let (a, b) = (frame.st(lo.xy()).1, frame.st(hi.xy()).1);
        let line = |t: i32| (i64::from(t) - frame.base()).div_euclid(frame.pitch());
        let first = line(a.min(b)).clamp(0, lines.into()) as i32;
        let end = (line(a.max(b)) + 1).clamp(first.into(), lines.into()) as i32;
        let direction = frame.direction().unwrap_or_default().map(|c| c as i32);
        let base = frame.base() + i64::from(first) * frame.pitch();
        let number = first * frame.sub_rows() as i32;
        RowWindow::new(direction, number, base, frame.pitch(), frame.offsets(), (end - first) as u32)
    }
}

/// Makes consecutive layers of their spans; equal neighbours are one.
fn make(maker: &Maker<'_>, first: u32, rows: &[Rows]) -> Vec<Arc<Made>> {
    let mut made: Vec<Arc<Made>> = Vec::with_capacity(rows.len());
    for (i, area) in rows.iter().enumerate() {
        let layer = first + i as u32;
        let same =
            i > 0 && rows.get(i - 1) == Some(area) && (maker.offset)(layer) == (maker.offset)(layer - 1);
        let next = match made.last() {
            Some(last) if same => Arc::clone(last),
            _ => maker.made(&Arc::new(maker.mask(area.clone(), layer))),
        };
        made.push(next);
    }
    made
}
