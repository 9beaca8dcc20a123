//! The loop that keeps workers busy.
//!
//! One thread decides everything; it sleeps until a worker, or the thread that reads models ahead, has
//! something to say. A job is recorded before it is handed to a worker, and its end before anything else
//! happens.

mod book;
mod floor;
mod intake;
mod verdict;
mod watch;

use super::event::{Event, Observer, Totals};
use super::journal::{Journal, Past};
use super::pool::{News, PostBox};
use super::{BatchError, BatchOptions, Item, report};
use floor::Floor;
use intake::Known;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

/// How often limits are looked at and the observer is called, at least.
const BEAT: Duration = Duration::from_millis(200);

/// Models read ahead for each thread, and at least.
const AHEAD: (usize, usize) = (8, 32);

/// What wakes the loop.
#[derive(Debug)]
enum Message {
    /// A model has been read.
    Known(usize, Known),
    /// From a worker.
    Worker(News),
}

impl PostBox for Sender<Message> {
    fn post(&self, news: News) {
        // Where nobody listens any more the batch is over.
        drop(self.send(Message::Worker(news)));
    }
}

/// Does all jobs of the shard and writes journal and reports. The order of results is that of `items`.
///
/// # Errors
/// [`BatchError`] when the folder cannot be used, the journal cannot be written or workers cannot be started.
/// Failures of jobs are no errors here.
pub fn run(
    items: &[Item],
    options: &BatchOptions,
    observer: &mut dyn Observer,
) -> Result<Totals, BatchError> {
    let begun = Instant::now();
    let (journal, past) = Journal::open(&options.folder, options.shard, options.resume, options.restart)?;
    if let Some(message) = journal.warning() {
        observer.event(&Event::Warning { message });
    }
    let (rows, mut totals) = thread::scope(|scope| {
        let (sender, messages) = channel();
        let (permits, taken) = channel();
        let reader = sender.clone();
        let past: &Past = &past;
        // It ends when the floor, which holds the permits, is no more.
        scope.spawn(move || {
            intake::read_ahead(items, options, past, &taken, |number, known| {
                reader.send(Message::Known(number, known)).is_ok()
            });
        });
        for _ in 0..(AHEAD.0 * options.threads).max(AHEAD.1) {
            let _ = permits.send(());
        }
        let mut floor = Floor::new(items, options, observer, journal, permits, sender);
        work(&mut floor, &messages).map(|()| floor.leave())
    })?;
    totals.seconds = begun.elapsed().as_secs_f64();
    let written = report::write(&options.folder, options.shard, &rows, &totals);
    observer.event(&Event::Ended(&totals));
    // On a full disk there is no room for a report either, and the reason is told already.
    if totals.stopped.is_none() {
        written?;
    }
    Ok(totals)
}

/// Works until all is done or the batch is to stop.
fn work(floor: &mut Floor<'_>, messages: &Receiver<Message>) -> Result<(), BatchError> {
    floor.begin();
    let mut beat = Instant::now();
    while !floor.finished() {
        floor.dispatch()?;
        let first = match messages.recv_timeout(BEAT.saturating_sub(beat.elapsed())) {
            Ok(message) => Some(message),
            Err(RecvTimeoutError::Timeout) => None,
            // We hold a sender ourselves.
            Err(RecvTimeoutError::Disconnected) => break,
        };
        for message in first.into_iter().chain(messages.try_iter()) {
            match message {
                Message::Known(number, known) => floor.learn_of(number, known)?,
                Message::Worker(news) => floor.hear(news)?,
            }
        }
        if beat.elapsed() >= BEAT {
            beat = Instant::now();
            floor.watch()?;
        }
        floor.breathe()?;
    }
    floor.end(|| {
        messages.try_iter().find_map(|message| match message {
            Message::Worker(news) => Some(news),
            Message::Known(..) => None,
        })
    })
}

#[cfg(all(test, unix))]
mod tests;
