//! Pools of threads for requests that want a number of their own.

use super::Failure;
use crate::job::FailureKind;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Arc, Mutex, PoisonError};

/// Idle pools that are kept.
const KEPT: usize = 8;

/// Stack of a thread \[bytes\]: as much as a main thread has.
const STACK: usize = 8 << 20;

/// Pools that are lent, each to one request at a time, so that requests side by side do not wait for each
/// other's pieces of work.
#[derive(Debug, Default)]
pub struct Pools {
    /// Most recently used last.
    idle: Mutex<Vec<Arc<ThreadPool>>>,
}

impl Pools {
    /// A pool of so many threads.
    ///
    /// # Errors
    /// [`FailureKind::Settings`] where there are none, else [`Failure::transient`]: the system gives no more
    /// threads.
    pub fn take(&self, threads: u16) -> Result<Arc<ThreadPool>, Failure> {
        if threads == 0 || threads > 1024 {
            let message = format!("threads: {threads} is out of range; allowed: 1 to 1024");
            return Err(Failure::new(FailureKind::Settings, message));
        }
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(at) = idle.iter().rposition(|pool| pool.current_num_threads() == usize::from(threads)) {
            return Ok(idle.remove(at));
        }
        drop(idle);
        let made = ThreadPoolBuilder::new().num_threads(threads.into()).stack_size(STACK).build();
        made.map(Arc::new).map_err(|e| Failure {
            transient: true,
            ..Failure::new(
                FailureKind::Defect,
                format!("threads: cannot start {threads}: {e}; ask for fewer"),
            )
        })
    }

    /// Takes a pool back for the next request.
    pub fn give_back(&self, pool: Arc<ThreadPool>) {
        let mut idle = self.idle.lock().unwrap_or_else(PoisonError::into_inner);
        if idle.len() >= KEPT {
            idle.remove(0);
        }
        idle.push(pool);
    }
}
