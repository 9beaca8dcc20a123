//! Stopping a job from elsewhere.

use crate::job::progress::{Progress, Silent};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// A wish that a job should stop, shared by all its clones. It is heard between stages and between layers that
/// are written; the job then ends as cancelled and leaves nothing behind.
///
/// ```no_run
/// use microtome::slicer::{Cancel, Request, Slicer};
///
/// let cancel = Cancel::new();
/// let other = cancel.clone();
/// std::thread::spawn(move || {
///     std::thread::sleep(std::time::Duration::from_secs(10));
///     other.cancel();
/// });
/// let done = Slicer::default().slice(&Request::new("a.stl").output("a.gcode"), &cancel);
/// # drop(done);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

impl Cancel {
    /// Not cancelled.
    pub fn new() -> Self {
        Self::default()
    }

    /// From now on the job should stop.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether [`Self::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// A progress that passes news on and stops the job when this is cancelled, or when `progress` wants it.
    pub fn beside<'a>(&'a self, progress: &'a dyn Progress) -> impl Progress + 'a {
        Beside { cancel: self, progress }
    }
}

/// Says nothing, and stops the job when it is cancelled.
impl Progress for Cancel {
    fn stage(&self, name: &'static str) {
        Silent.stage(name);
    }

    fn cancelled(&self) -> bool {
        self.is_cancelled()
    }
}

struct Beside<'a> {
    cancel: &'a Cancel,
    progress: &'a dyn Progress,
}

impl Progress for Beside<'_> {
    fn stage(&self, name: &'static str) {
        self.progress.stage(name);
    }

    fn layers(&self, done: u64, all: u64) {
        self.progress.layers(done, all);
    }

    fn cancelled(&self) -> bool {
        self.cancel.is_cancelled() || self.progress.cancelled()
    }
}
