//! The threads that a job works with.
//!
//! Stages use rayon, whose work runs on the pool of the thread that asks for it, else on the one of all the
//! process. A job that is to have threads of its own says so once, and stages that begin on another thread
//! carry it there.

use rayon::ThreadPool;
use std::cell::RefCell;
use std::sync::Arc;

thread_local! {
    static OWN: RefCell<Option<Arc<ThreadPool>>> = const { RefCell::new(None) };
}

/// Does a job on this thread whose stages work on a pool; [`on_pool`] brings them there.
pub fn with_pool<T>(pool: Arc<ThreadPool>, job: impl FnOnce() -> T) -> T {
    /// Takes the pool away again, in a panic too.
    struct Reset(Option<Arc<ThreadPool>>);
    impl Drop for Reset {
        fn drop(&mut self) {
            OWN.set(self.0.take());
        }
    }
    let _reset = Reset(OWN.replace(Some(pool)));
    job()
}

/// The pool of the job in hand on this thread; `None` where it has none of its own.
pub fn pool() -> Option<Arc<ThreadPool>> {
    OWN.with_borrow(Clone::clone)
}

/// Works on the pool of the job in hand, and on this thread where that has none.
pub fn on_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    on(pool().as_deref(), work)
}

/// Works on a pool, and on this thread where there is none.
pub fn on<T: Send>(pool: Option<&ThreadPool>, work: impl FnOnce() -> T + Send) -> T {
    match pool {
        Some(pool) => pool.install(work),
        None => work(),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::panic::{AssertUnwindSafe, catch_unwind};

    #[test]
    fn a_pool_lasts_as_long_as_its_job() {
        let make = |n| Arc::new(rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap());
        let threads = || on_pool(rayon::current_num_threads);
        let outside = threads();
        with_pool(make(3), || {
            assert_eq!(threads(), 3);
            assert_eq!(with_pool(make(2), threads), 2);
            assert_eq!(threads(), 3);
        });
        let panicked =
            catch_unwind(AssertUnwindSafe(|| with_pool(make(5), || std::panic::resume_unwind(Box::new(1)))));
        assert!(panicked.is_err() && pool().is_none());
        assert_eq!(threads(), outside);
    }
}
