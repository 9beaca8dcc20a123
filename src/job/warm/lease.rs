//! Borrowing a device for one job.

use super::{MOST_LOSSES, Opened, Place, Pool, Warm};
use crate::gpu::{self, GpuError};
use crate::job::backend::{Backend, BackendOptions};
use crate::mesh::{Adjacency, Mesh};
use crate::slice::gpu::{GpuMesh, GpuSlicer, START_UP, repays_startup, saving};
use crate::span::gpu::GpuSpans;
use std::sync::{Arc, PoisonError};
use std::time::Duration;

/// How long a thread of a pool waits for a device before it opens one more: where jobs share a pool, the one
/// that has the device may wait for this very thread.
const LONGEST_WAIT: Duration = Duration::from_secs(5);

/// Where a job is done.
pub(in crate::job) enum Taken {
    /// On this device.
    Device(Lease),
    /// On the CPU.
    Cpu {
        /// Why, for the summary.
        reason: &'static str,
        /// What the user must know about it.
        warning: Option<String>,
    },
}

/// A device, for one job.
pub(in crate::job) struct Lease {
    opened: Box<Opened>,
    home: Home,
    memory: Option<u64>,
}

/// Where a device is given back; nowhere for one that serves one job only. Dropped on the way, as by a panic,
/// it frees the place, and the device is opened anew.
struct Home(Option<(Arc<Pool>, usize)>);

/// Finds a device for a job of so many triangles and about so many segments.
///
/// [`Backend::Gpu`] waits for a device that is busy; [`Backend::Auto`] goes to the CPU then, and also where
/// the work does not repay a device.
///
/// # Errors
/// Where a device was demanded, what keeps it from being opened; [`GpuError::NoSuchAdapter`] always.
pub(in crate::job) fn take(wish: &BackendOptions, triangles: u64, segments: u64) -> Result<Taken, GpuError> {
    let cpu = |reason, warning| Ok(Taken::Cpu { reason, warning });
    let weighs = wish.backend == Backend::Auto && wish.adapter.is_none();
    let selection = wish.adapter.clone().map_or(gpu::Selection::Auto, gpu::Selection::Named);
    let pool = wish.warm.as_ref().map(|Warm(pool)| pool).filter(|pool| pool.selection == selection);
    let found = match pool {
        None if weighs && !repays_startup(triangles, segments, START_UP) => Found::NotWorth,
        None => Found::Cold,
        Some(pool) => pool.find(weighs.then(|| saving(triangles, segments)), wish.backend),
    };
    let (home, fault) = match found {
        Found::NotWorth => return cpu("the work does not repay a GPU's start-up", None),
        Found::Busy => return cpu("every GPU is busy with another job", None),
        Found::GivenUp => {
            let text = format!("the GPU failed {MOST_LOSSES} times and is used no more");
            return cpu(
                "the GPU failed too often",
                Some(format!("{text}; the CPU took over, with the same result")),
            );
        }
        Found::None(error) => return instead(wish, error),
        Found::Open(home, opened) => return Ok(Taken::Device(Lease { opened, home, memory: wish.memory })),
        Found::Closed(home, fault) => (home, fault),
        Found::Cold => (Home(None), wish.fault),
    };
    match Opened::open(&selection, home.number(), fault) {
        Ok(opened) => Ok(Taken::Device(Lease { opened: Box::new(opened), home, memory: wish.memory })),
        Err(error) => {
            home.give_back(None);
            instead(wish, error)
        }
    }
}

/// What is done where no device can be had.
fn instead(wish: &BackendOptions, error: GpuError) -> Result<Taken, GpuError> {
    if wish.backend == Backend::Gpu || matches!(error, GpuError::NoSuchAdapter { .. }) {
        return Err(error);
    }
    if matches!(error, GpuError::NoHardware { .. }) {
        return Ok(Taken::Cpu { reason: "no hardware GPU was found", warning: None });
    }
    let warning = Some(format!("{error}; the CPU took over, with the same result"));
    Ok(Taken::Cpu { reason: "the GPU failed", warning })
}

/// What a look for a device finds.
enum Found {
    /// The work is too little.
    NotWorth,
    /// All are in use.
    Busy,
    /// All have failed too often.
    GivenUp,
    /// There is none.
    None(GpuError),
    /// One that is open.
    Open(Home, Box<Opened>),
    /// A place where one can be opened, and the failure that it is to play.
    Closed(Home, Option<gpu::Fault>),
    /// One of the job's own.
    Cold,
}

impl Pool {
    /// Takes a free device, an open one first. `saving`: the CPU time that the job would save on an open one
    /// \[ns\]; `None` where that does not matter.
    fn find(self: &Arc<Self>, saving: Option<u64>, backend: Backend) -> Found {
        let mut state = self.lock();
        if let Some(saving) = saving {
            let is_open = state.places.iter().any(|p| p.device.is_some() || p.busy);
            if saving == 0 {
                return Found::NotWorth;
            }
            if !is_open {
                // Whether more such jobs will come is not known. A device is opened when those so far would
                // have repaid it: at worst that costs twice what knowing would have (the ski-rental rule).
                state.missed = state.missed.saturating_add(saving);
                if state.missed <= START_UP {
                    return Found::NotWorth;
                }
            }
        }
        state.look(&self.selection);
        if let Some(error) = &state.none {
            return Found::None(error.clone());
        }
        let demanded = backend == Backend::Gpu;
        loop {
            let free = |open: bool| {
                move |p: &Place| {
                    !p.busy && p.device.is_some() == open && (open || demanded || !p.is_given_up())
                }
            };
            let number = state.places.iter().position(free(true));
            if let Some(number) = number.or_else(|| state.places.iter().position(free(false))) {
                let place = &mut state.places[number];
                place.busy = true;
                let home = Home(Some((Arc::clone(self), number)));
                return match place.device.take() {
                    Some(opened) => Found::Open(home, opened),
                    None => {
                        state.opened += 1;
                        let fault = state.next_fault();
                        Found::Closed(home, fault)
                    }
                };
            }
            if !demanded {
                return if state.places.iter().any(|p| p.busy) { Found::Busy } else { Found::GivenUp };
            }
            if rayon::current_thread_index().is_none() {
                state = self.freed.wait(state).unwrap_or_else(PoisonError::into_inner);
                continue;
            }
            let waited = self.freed.wait_timeout(state, LONGEST_WAIT);
            let (left, waited) = waited.unwrap_or_else(PoisonError::into_inner);
            if waited.timed_out() {
                return Found::Cold;
            }
            state = left;
        }
    }
}

impl Home {
    /// Which of the fitting devices it is.
    fn number(&self) -> usize {
        self.0.as_ref().map_or(0, |(_, number)| *number)
    }

    /// Gives a device back, or says that it is lost.
    fn give_back(mut self, device: Option<Box<Opened>>) {
        if let Some((pool, number)) = self.0.take() {
            pool.free(number, |place| {
                if device.is_some() {
                    place.went_well()
                } else {
                    place.was_lost()
                }
                place.device = device;
            });
        }
    }
}

impl Drop for Home {
    fn drop(&mut self) {
        if let Some((pool, number)) = self.0.take() {
            pool.free(number, |_| ());
        }
    }
}

impl Pool {
    fn free(&self, number: usize, change: impl FnOnce(&mut Place)) {
        if let Some(place) = self.lock().places.get_mut(number) {
            place.busy = false;
            change(place);
        }
        self.freed.notify_all();
    }
}

impl Lease {
    /// The device's name, with its driver.
    pub(in crate::job) fn name(&self) -> String {
        let info = self.opened.device.info();
        format!("{} ({} {})", info.name, info.driver, info.driver_info)
    }

    /// Brings a mesh to the device and slices it there. `budget`: memory that this may take unless the wish
    /// says \[bytes\].
    ///
    /// # Errors
    /// What the device reports; it is dropped where it cannot be used any more.
    pub(in crate::job) fn slice(
        mut self,
        mesh: &Mesh,
        adjacency: &Adjacency,
        budget: u64,
        work: impl FnOnce(&mut GpuSlicer, &GpuMesh) -> Result<(), GpuError>,
    ) -> Result<(), GpuError> {
        let budget = self.budget(budget);
        let opened = &mut self.opened;
        let result = opened.with_mesh(mesh, adjacency, budget, |_, slicer, mesh| work(slicer, mesh));
        self.end(result.as_ref().err());
        result
    }

    /// Brings a mesh to the device and makes spans of it there, as [`Self::slice`]. `failure` tells the
    /// device's part of an error.
    ///
    /// # Errors
    /// What the device or the work reports.
    pub(in crate::job) fn scan<E: From<GpuError>>(
        mut self,
        mesh: &Mesh,
        adjacency: &Adjacency,
        budget: u64,
        work: impl FnOnce(&mut GpuSpans, &GpuMesh) -> Result<(), E>,
        failure: fn(&E) -> Option<&GpuError>,
    ) -> Result<(), E> {
        let budget = self.budget(budget);
        let result = self.opened.with_mesh(mesh, adjacency, budget, |opened, _, mesh| {
            let spans = opened.spans.take();
            let spans = spans.map_or_else(|| GpuSpans::new(Arc::clone(&opened.device)), Ok)?;
            let mut spans = spans.with_budget(budget);
            let result = work(&mut spans, mesh);
            opened.spans = Some(spans);
            result
        });
        self.end(result.as_ref().err().and_then(failure));
        result
    }

    fn budget(&self, default: u64) -> u64 {
        self.memory.unwrap_or_else(|| default.min(self.opened.device.default_budget()))
    }

    /// Gives the device back, if it is well.
    fn end(self, failure: Option<&GpuError>) {
        let Self { mut opened, home, .. } = self;
        match failure {
            // Said by us before anything was done.
            None | Some(GpuError::TooLarge { .. } | GpuError::Budget { .. }) => {
                opened.trim();
                home.give_back(Some(opened));
            }
            Some(GpuError::Timeout { .. }) => {
                // To free a hung device would be to wait for it.
                std::mem::forget(opened);
                home.give_back(None);
            }
            Some(_) => {
                drop(opened);
                home.give_back(None);
            }
        }
    }
}

impl Opened {
    /// Brings a mesh to the device, in the memory of the one before.
    fn with_mesh<E: From<GpuError>>(
        &mut self,
        mesh: &Mesh,
        adjacency: &Adjacency,
        budget: u64,
        work: impl FnOnce(&mut Self, &mut GpuSlicer, &GpuMesh) -> Result<(), E>,
    ) -> Result<(), E> {
        let slicer = self.slicer.take();
        let slicer = slicer.map_or_else(|| GpuSlicer::new(Arc::clone(&self.device)), Ok)?;
        let mut slicer = slicer.with_budget(budget);
        let resident = match self.mesh.take() {
            Some(mut last) => slicer.upload_into(&mut last, mesh, adjacency).map(|()| last),
            None => slicer.upload(mesh, adjacency),
        };
        let result = resident.map_err(E::from).and_then(|resident| {
            let result = work(self, &mut slicer, &resident);
            self.mesh = Some(resident);
            result
        });
        self.slicer = Some(slicer);
        result
    }
}
