//! Ctrl-C and its kin: the first one asks for an orderly end, the second one ends at once.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of a batch that was stopped on the way.
const STOPPED: i32 = 9;

/// Watches for SIGINT, SIGTERM and SIGHUP from now on; what it returns is set when one comes. What is ignored
/// already, as under `nohup` and in the background of a script, stays so. To be called once.
pub fn watch() -> Arc<AtomicBool> {
    let asked = Arc::new(AtomicBool::new(false));
    let ignored = Ignored::find();
    let setter = Arc::clone(&asked);
    // Fails where another handler is in the way, or a thread cannot be had: then signals end the process, after
    // which `--resume` goes on as well.
    drop(ctrlc::set_handler(move || {
        if setter.swap(true, Ordering::Relaxed) {
            std::process::exit(STOPPED);
        }
    }));
    ignored.keep();
    asked
}

/// Signals that are ignored.
struct Ignored {
    #[cfg(unix)]
    signals: Vec<libc::c_int>,
}

#[cfg(unix)]
impl Ignored {
    fn find() -> Self {
        // SAFETY: only sets signals to be ignored or to their default; `watch` installs a handler right after.
        let is_ignored = |signal: &libc::c_int| unsafe {
            let before = libc::signal(*signal, libc::SIG_IGN);
            if before != libc::SIG_IGN {
                libc::signal(*signal, before);
            }
            before == libc::SIG_IGN
        };
        Self { signals: [libc::SIGINT, libc::SIGHUP].into_iter().filter(is_ignored).collect() }
    }

    fn keep(&self) {
        for signal in &self.signals {
            // SAFETY: ignoring a signal runs no code of ours.
            unsafe { libc::signal(*signal, libc::SIG_IGN) };
        }
    }
}

#[cfg(not(unix))]
impl Ignored {
    const fn find() -> Self {
        Self {}
    }

    const fn keep(&self) {}
}
