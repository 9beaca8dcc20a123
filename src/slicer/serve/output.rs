//! Where answers go.

use super::Event;
use crate::slicer::protocol::{Answer, News};
use serde_json::Value;
use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Mutex, PoisonError};

/// A stream of answers, to which whole lines are written at a time.
pub struct Output<W> {
    /// The stream, and what it failed with first; nothing more is written then.
    stream: Mutex<(W, Option<io::Error>)>,
    failed: AtomicBool,
    /// Who waits here is told of a failure.
    events: SyncSender<Event>,
}

impl<W: Write> Output<W> {
    /// An output that tells of its failure.
    pub fn new(stream: W, events: SyncSender<Event>) -> Self {
        Self { stream: Mutex::new((stream, None)), failed: AtomicBool::new(false), events }
    }

    /// Writes a line, so that it can be read at once.
    pub fn say(&self, id: Value, news: News) {
        let Ok(mut line) = serde_json::to_vec(&Answer { id, news }) else { return };
        line.push(b'\n');
        let mut guard = self.stream.lock().unwrap_or_else(PoisonError::into_inner);
        let (stream, failure) = &mut *guard;
        if failure.is_some() {
            return;
        }
        if let Err(e) = stream.write_all(&line).and_then(|()| stream.flush()) {
            *failure = Some(e);
            self.failed.store(true, Ordering::Relaxed);
            drop(guard);
            // Where something else lies ready for those who wait, they look here after it all the same.
            drop(self.events.try_send(Event::Unwritable));
        }
    }

    /// Whether nothing can be written any more.
    pub fn has_failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// What the stream failed with.
    pub fn failure(self) -> Option<io::Error> {
        self.stream.into_inner().unwrap_or_else(PoisonError::into_inner).1
    }
}
