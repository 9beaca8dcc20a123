//! Devices that stay open from job to job.
//!
//! Opening a driver and compiling kernels costs more than slicing most models does. A [`Warm`] pool, which
//! clones of [`BackendOptions`] share, opens each fitting device once; a job borrows a free one and gives it
//! back. A device that fails is dropped, and opened anew for a later job.

mod fault;
mod lease;

pub use fault::FaultPlan;
pub(super) use lease::{Lease, Taken, take};

use super::backend::BackendOptions;
use crate::gpu::{self, Device, GpuError};
use crate::slice::gpu::{GpuMesh, GpuSlicer};
use crate::span::gpu::GpuSpans;
use std::fmt;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// So often may a device fail before jobs that are free to choose use it no more.
const MOST_LOSSES: u32 = 3;

/// After so many jobs without a failure earlier ones are forgotten.
const FORGIVEN_AFTER: u32 = 64;

/// Device memory that is kept between jobs \[bytes\]; what a larger job took is given back after it.
const KEPT: u64 = 256 << 20;

/// A pool of open devices, shared by its clones and equal to them only.
#[derive(Clone)]
pub struct Warm(Arc<Pool>);

struct Pool {
    selection: gpu::Selection,
    state: Mutex<State>,
    /// A device has been given back.
    freed: Condvar,
}

#[derive(Default)]
struct State {
    /// One for each fitting device; empty until somebody looked for them.
    places: Vec<Place>,
    /// Why there is none.
    none: Option<GpuError>,
    /// CPU time that jobs would have saved had a device been open \[ns\].
    missed: u64,
    faults: Option<FaultPlan>,
    /// Devices opened so far.
    opened: u32,
}

/// Where a device is, or may be opened.
#[derive(Default)]
struct Place {
    busy: bool,
    device: Option<Box<Opened>>,
    losses: u32,
    /// Jobs since the last loss.
    well: u32,
}

/// A device with compiled kernels, and the memory that jobs on it reuse.
struct Opened {
    device: Arc<Device>,
    slicer: Option<GpuSlicer>,
    spans: Option<GpuSpans>,
    mesh: Option<GpuMesh>,
}

impl Warm {
    /// A pool of the devices that a wish means; none is opened yet.
    pub fn new(wish: &BackendOptions) -> Self {
        let selection = wish.adapter.clone().map_or(gpu::Selection::Auto, gpu::Selection::Named);
        let faults = wish.fault.map(|fault| FaultPlan { fault, devices: 1 });
        let state = State { faults, ..State::default() };
        Self(Arc::new(Pool { selection, state: Mutex::new(state), freed: Condvar::new() }))
    }

    /// Devices opened so far, those lost since among them.
    pub fn opened(&self) -> u32 {
        self.0.lock().opened
    }

    /// Has the devices that are opened from now on fail as planned.
    pub(super) fn play(&self, faults: FaultPlan) {
        self.0.lock().faults = Some(faults);
    }
}

impl PartialEq for Warm {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl Eq for Warm {}

impl fmt::Debug for Warm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Warm({:?}, {} opened)", self.0.selection, self.opened())
    }
}

impl Pool {
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl State {
    /// Looks for devices, unless that was done before.
    fn look(&mut self, selection: &gpu::Selection) {
        if self.places.is_empty() && self.none.is_none() {
            match gpu::adapter::choose_all(selection) {
                Ok(found) => self.places.resize_with(found.len(), Place::default),
                Err(error) => self.none = Some(error),
            }
        }
    }

    /// The failure that the next device to be opened plays.
    fn next_fault(&mut self) -> Option<gpu::Fault> {
        let plan = self.faults.as_mut().filter(|plan| plan.devices > 0)?;
        plan.devices -= 1;
        Some(plan.fault)
    }
}

impl Place {
    fn is_given_up(&self) -> bool {
        self.losses >= MOST_LOSSES
    }

    fn went_well(&mut self) {
        self.well += 1;
        if self.well >= FORGIVEN_AFTER {
            (self.well, self.losses) = (0, 0);
        }
    }

    fn was_lost(&mut self) {
        (self.well, self.losses) = (0, self.losses + 1);
    }
}

impl Opened {
    /// Opens the fitting device of a number.
    fn open(selection: &gpu::Selection, number: usize, fault: Option<gpu::Fault>) -> Result<Self, GpuError> {
        let mut fitting = gpu::adapter::choose_all(selection)?;
        // One of several may have been unplugged.
        let adapter = fitting.swap_remove(number.min(fitting.len() - 1));
        let options = gpu::Options { fault, ..gpu::Options::default() };
        let device = Arc::new(Device::with_options(&adapter, options)?);
        Ok(Self { device, slicer: None, spans: None, mesh: None })
    }

    /// Gives back what a large job took.
    fn trim(&mut self) {
        let held = self.slicer.as_ref().map_or(0, GpuSlicer::held)
            + self.spans.as_ref().map_or(0, GpuSpans::held)
            + self.mesh.as_ref().map_or(0, GpuMesh::bytes);
        if held > KEPT {
            // The kernels stay with the device.
            (self.slicer, self.spans, self.mesh) = (None, None, None);
        }
    }
}
