//! What has become of the jobs: journal, rows, sums, news.

use super::intake::{self, Identity};
use crate::batch::event::{Event, Observer, Row, Status, Totals};
use crate::batch::journal::Journal;
use crate::batch::key::Key;
use crate::batch::options::BatchOptions;
use crate::batch::{BatchError, Item, report};
use crate::slicer::{Failure, Outcome};
use std::borrow::Cow;
use std::path::Path;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::thread;
use std::time::{Duration, Instant};

/// Time between checkpoints, at least.
const CHECKPOINT: Duration = Duration::from_millis(500);

/// A checkpoint keeps workers waiting; on a slow disk no more than one part in so many of the time.
const CHECKPOINT_SHARE: u32 = 20;

/// Sends what is written to the disk from a thread of its own, so that the checkpoint that follows finds little
/// left to wait for.
fn flush(folder: &Path) -> Receiver<()> {
    let (sender, done) = channel();
    let folder = folder.to_owned();
    let flush = move || {
        // A failure is for the checkpoint to tell.
        #[cfg(target_os = "linux")]
        drop(std::fs::File::open(&folder).map(rustix::fs::syncfs));
        #[cfg(not(target_os = "linux"))]
        drop(folder);
        // Nobody waits where the batch is over.
        let _ = sender.send(());
    };
    // Without the thread its sender is dropped, which says the same.
    drop(thread::Builder::new().name("flush".to_owned()).spawn(flush));
    done
}

/// Keeps the books of a batch.
pub(super) struct Book<'a> {
    items: &'a [Item],
    options: &'a BatchOptions,
    observer: &'a mut dyn Observer,
    journal: Journal,
    rows: Vec<Option<Row>>,
    pub totals: Totals,
    due: Option<Instant>,
    flushing: Option<Receiver<()>>,
    cost: Duration,
}

/// How a job ended.
pub(super) struct End<'e> {
    pub number: usize,
    /// `None` where the model could not be read.
    pub identity: Option<&'e Identity>,
    pub attempts: u32,
    pub result: Result<Outcome, (Status, Failure)>,
}

impl<'a> Book<'a> {
    pub(super) fn new(
        items: &'a [Item],
        options: &'a BatchOptions,
        observer: &'a mut dyn Observer,
        journal: Journal,
    ) -> Self {
        let (rows, totals) = (vec![None; items.len()], Totals::default());
        let (due, flushing, cost) = (None, None, Duration::ZERO);
        Self { items, options, observer, journal, rows, totals, due, flushing, cost }
    }

    pub(super) fn tell(&mut self, event: &Event<'_>) {
        self.observer.event(event);
    }

    pub(super) fn tick(&mut self) {
        self.observer.tick();
    }

    pub(super) fn wants_stop(&mut self) -> bool {
        self.observer.stop()
    }

    /// A worker is about to begin.
    pub(super) fn started(
        &mut self,
        number: usize,
        key: &Key,
        attempt: u32,
        worker: usize,
    ) -> Result<(), BatchError> {
        let Some(item) = self.items.get(number) else { return Ok(()) };
        self.journal.started(&item.name, key, attempt)?;
        self.observer.event(&Event::Started { name: &item.name, attempt, worker });
        Ok(())
    }

    /// A try failed, and there will be another.
    pub(super) fn again(&mut self, number: usize, failure: &Failure, attempt: u32) {
        self.totals.retries += 1;
        if let Some(Item { name, size, .. }) = self.items.get(number) {
            self.observer.event(&Event::Failed { name, size: *size, failure, attempt, again: true });
        }
    }

    /// A job has ended.
    pub(super) fn ended(&mut self, end: End<'_>) -> Result<(), BatchError> {
        let Some(item) = self.items.get(end.number) else { return Ok(()) };
        let status = end.result.as_ref().map_or_else(|(status, _)| *status, |_| Status::Done);
        let (outcome, failure) = match end.result {
            Ok(outcome) => (Some(outcome), None),
            Err((_, failure)) => (None, Some(failure)),
        };
        let mut row = Row {
            name: item.name.clone(),
            model: item.request.model.display().to_string(),
            status,
            key: end.identity.map(|identity| identity.key.clone()).unwrap_or_default(),
            sha256: end.identity.map(|identity| identity.content.sha256.clone()).unwrap_or_default(),
            copies: item.request.copies,
            attempts: end.attempts,
            outcome,
            failure,
            request: intake::request(item, self.options),
        };
        // The journal is JSON too.
        if let Some(writable) = owned(report::writable(&row)) {
            row = writable;
        }
        self.journal.ended(&row)?;
        self.due.get_or_insert_with(|| Instant::now() + CHECKPOINT.max(self.cost * CHECKPOINT_SHARE));
        match status {
            Status::Done => self.totals.done += 1,
            Status::Failed => self.totals.failed += 1,
            Status::Quarantined => self.totals.quarantined += 1,
        }
        let (name, size, attempt) = (&item.name, item.size, end.attempts);
        if let Some(outcome) = &row.outcome {
            self.observer.event(&Event::Done { name, size, outcome });
        }
        if let Some(failure) = &row.failure {
            self.observer.event(&Event::Failed { name, size, failure, attempt, again: false });
        }
        self.enter(end.number, row);
        Ok(())
    }

    /// A job belongs to another shard.
    pub(super) fn elsewhere(&mut self, number: usize) {
        self.totals.elsewhere += 1;
        if let Some(Item { name, size, .. }) = self.items.get(number) {
            self.observer.event(&Event::Elsewhere { name, size: *size });
        }
    }

    /// An earlier run has settled a job.
    pub(super) fn stands(&mut self, number: usize, row: Row) {
        match row.status {
            Status::Done => self.totals.skipped += 1,
            Status::Failed => self.totals.failed += 1,
            Status::Quarantined => self.totals.quarantined += 1,
        }
        if let Some(Item { name, size, .. }) = self.items.get(number) {
            let failed = row.status != Status::Done;
            self.observer.event(&Event::Skipped { name, size: *size, failed });
        }
        self.enter(number, row);
    }

    fn enter(&mut self, number: usize, row: Row) {
        if let Some(place) = self.rows.get_mut(number) {
            *place = Some(row);
        }
    }

    /// Makes all so far last, if it is time.
    pub(super) fn checkpoint(&mut self) -> Result<(), BatchError> {
        match &self.flushing {
            None if self.due.is_some_and(|due| Instant::now() >= due) => {
                self.flushing = Some(flush(&self.options.folder));
                Ok(())
            }
            Some(done) if done.try_recv() != Err(TryRecvError::Empty) => self.checkpoint_now(),
            _ => Ok(()),
        }
    }

    pub(super) fn checkpoint_now(&mut self) -> Result<(), BatchError> {
        let begun = Instant::now();
        self.journal.checkpoint()?;
        (self.due, self.flushing, self.cost) = (None, None, begun.elapsed());
        Ok(())
    }

    /// How many jobs are settled or belong to others.
    pub(super) fn settled(&self) -> usize {
        let t = &self.totals;
        t.done + t.skipped + t.failed + t.quarantined + t.elsewhere
    }

    /// Rows in the order of the items, and sums.
    pub(super) fn close(mut self) -> (Vec<Row>, Totals) {
        self.totals.left = self.items.len() - self.settled().min(self.items.len());
        (self.rows.into_iter().flatten().collect(), self.totals)
    }
}

fn owned<T: Clone>(maybe: Cow<'_, T>) -> Option<T> {
    match maybe {
        Cow::Owned(owned) => Some(owned),
        Cow::Borrowed(_) => None,
    }
}
