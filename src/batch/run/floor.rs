//! The shop floor: which worker does what, and what becomes of it.

use super::Message;
use super::book::{Book, End};
use super::intake::{self, Identity, Known};
use super::verdict::{Verdict, deadly, failure_of, verdict};
use super::watch::{Measure, measures};
use crate::batch::event::{Event, Observer, Row, Status, Totals};
use crate::batch::journal::Journal;
use crate::batch::options::BatchOptions;
use crate::batch::pool::{Death, Meaning, News, Pool, RETIRE_BYTES, Said, Sentence, Slot, Task, memory};
use crate::batch::schedule::{Claim, Estimator, Load, Schedule, Start, Turn};
use crate::batch::{BatchError, Item, STATE_FOLDER};
use crate::job::{FailureKind, output};
use crate::slicer::{Failure, Outcome, Request};
use std::collections::{BTreeMap, BTreeSet};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::thread;
use std::time::Duration;

/// A job that waits behind another so much longer than that was to take is given to somebody else \[s\].
const OVERDUE: f64 = 1.0;

/// A signal that one process has had reaches the next after this.
const GRACE: Duration = Duration::from_millis(100);

/// A job that is waiting or in hand.
struct Job {
    identity: Identity,
    claim: Claim,
    text: bool,
    turn: Turn,
    /// Tries begun that count.
    attempts: u32,
    /// Whether a worker ever had it.
    begun: bool,
}

/// The state of a running batch.
pub(super) struct Floor<'a> {
    items: &'a [Item],
    options: &'a BatchOptions,
    book: Book<'a>,
    schedule: Schedule,
    estimator: Estimator,
    jobs: BTreeMap<usize, Job>,
    pool: Option<Pool>,
    permits: Sender<()>,
    sender: Sender<Message>,
    unread: (usize, f64),
    folders: BTreeSet<PathBuf>,
    own: u64,
}

impl<'a> Floor<'a> {
    pub(super) fn new(
        items: &'a [Item],
        options: &'a BatchOptions,
        observer: &'a mut dyn Observer,
        journal: Journal,
        permits: Sender<()>,
        sender: Sender<Message>,
    ) -> Self {
        let estimator = Estimator::default();
        let seconds = items.iter().map(|item| estimator.claim(&item.request, item.size, false).seconds).sum();
        Self {
            items,
            options,
            book: Book::new(items, options, observer, journal),
            schedule: Schedule::new(options.threads, options.limits.memory),
            estimator,
            jobs: BTreeMap::new(),
            pool: None,
            permits,
            sender,
            unread: (items.len(), seconds),
            folders: BTreeSet::new(),
            own: memory::own(),
        }
    }

    pub(super) fn begin(&mut self) {
        let bytes = self.items.iter().map(|item| item.size).sum();
        let workers = self.options.threads.max(1).min(self.items.len());
        self.book.tell(&Event::Begun { jobs: self.items.len(), bytes, workers });
    }

    pub(super) fn finished(&self) -> bool {
        self.book.totals.stopped.is_some() || self.book.settled() >= self.items.len()
    }

    /// The intake has looked at a job.
    pub(super) fn learn_of(&mut self, number: usize, known: Known) -> Result<(), BatchError> {
        let Some(item) = self.items.get(number) else { return Ok(()) };
        let (jobs, seconds) = self.unread;
        let less = Estimator::default().claim(&item.request, item.size, false).seconds;
        self.unread = (jobs.saturating_sub(1), if jobs > 1 { (seconds - less).max(0.0) } else { 0.0 });
        let refused = |result, identity| End { number, identity, attempts: 0, result: Err(result) };
        match known {
            Known::Elsewhere => self.book.elsewhere(number),
            Known::Stands(row) => self.book.stands(number, *row),
            Known::Refused(failure) => {
                let status = if failure.transient { Status::Quarantined } else { Status::Failed };
                self.book.ended(refused((status, failure), None))?;
            }
            Known::Deadly { identity, deaths } => {
                let failure = deadly(&item.request.model, deaths);
                self.book.ended(refused((Status::Quarantined, failure), Some(&identity)))?;
            }
            Known::Ready { identity, deaths, text } => {
                let request = intake::request(item, self.options);
                let claim = self.estimator.claim(&request, item.size, text);
                // It may have killed the machine; others come first.
                let turn = if deaths > 0 { Turn::Suspect } else { Turn::Usual };
                self.schedule.add(number, claim, turn);
                let job = Job { identity, claim, text, turn, attempts: 0, begun: false };
                self.jobs.insert(number, job);
                return Ok(());
            }
        }
        self.permit();
        Ok(())
    }

    /// Hands out what can be handed out.
    pub(super) fn dispatch(&mut self) -> Result<(), BatchError> {
        // Other shards have their part of what nobody has looked at yet.
        let shards = self.options.shard.count.max(1);
        self.schedule.set_unread(self.unread.0.div_ceil(shards as usize), self.unread.1 / f64::from(shards));
        if self.pool.is_none() && !self.schedule.is_empty() {
            let most = self.schedule.len() + self.unread.0;
            let post = Arc::new(self.sender.clone());
            let pool = Pool::start(self.options, self.options.threads.max(1).min(most), post);
            self.pool = Some(pool.map_err(BatchError::Worker)?);
        }
        while let Some(worker) = self.pool.as_ref().and_then(Pool::idle) {
            let Some(start) = self.schedule.next(&self.load()) else { break };
            self.give(worker, &start)?;
        }
        self.dispatch_behind()
    }

    /// Gives workers with a short job in hand another, so that they need not wait for us in between.
    fn dispatch_behind(&mut self) -> Result<(), BatchError> {
        for worker in 0..self.slots().len() {
            let Some(slot) = self.slots().get(worker) else { continue };
            let Some(task) = slot.hand().front().filter(|task| task.threads == 1) else { continue };
            let alone = self.jobs.get(&task.job).is_none_or(|job| job.turn != Turn::Usual);
            let Some(item) = self.items.get(task.job) else { continue };
            if alone || slot.resident > RETIRE_BYTES || !slot.has_room_behind(&item.request) {
                continue;
            }
            let claim = task.claim;
            if let Some(start) = self.schedule.next_behind(&claim) {
                self.give(worker, &start)?;
            }
        }
        Ok(())
    }

    fn slots(&self) -> &[Slot] {
        self.pool.as_ref().map_or(&[], Pool::slots)
    }

    fn load(&self) -> Load {
        let mut load = Load { bytes: self.own, ..Load::default() };
        for slot in self.slots() {
            load.bytes = load.bytes.saturating_add(slot.bytes());
            if let Some(task) = slot.hand().front() {
                load.jobs += 1;
                load.threads += task.threads;
                let done = task.since.elapsed().as_secs_f64() * task.threads as f64;
                load.seconds += (task.claim.seconds - done).max(0.0);
                load.alone |= self.jobs.get(&task.job).is_some_and(|job| job.turn == Turn::Alone);
            }
        }
        load
    }

    fn give(&mut self, worker: usize, start: &Start) -> Result<(), BatchError> {
        let (number, waits) = (start.job, self.slots().get(worker).is_some_and(|slot| !slot.idle()));
        let Some(item) = self.items.get(number) else { return Ok(()) };
        let request = match self.request(item, start) {
            Ok(request) => request,
            Err(failure) => return self.failed(number, failure),
        };
        if !waits {
            self.started(number, worker)?;
        }
        let task = (number, start.threads, start.claim);
        let given = self.pool.as_mut().map(|pool| pool.give(worker, task, &request));
        match given {
            Some(Err(e)) => {
                let message = format!("{}: not a request: {e}", item.request.model.display());
                self.failed(number, Failure::new(FailureKind::Settings, message))
            }
            _ => Ok(()),
        }
    }

    /// A worker begins a job.
    fn started(&mut self, number: usize, worker: usize) -> Result<(), BatchError> {
        let Some(job) = self.jobs.get_mut(&number) else { return Ok(()) };
        job.attempts += 1;
        self.book.started(number, &job.identity.key, job.attempts, worker)?;
        if !std::mem::replace(&mut job.begun, true) {
            self.permit();
        }
        Ok(())
    }

    /// What a worker is asked for; makes the folders that it needs.
    fn request(&mut self, item: &Item, start: &Start) -> Result<Request, Failure> {
        let mut request = intake::request(item, self.options);
        request.picture = self.options.pictures.then(|| self.picture(item));
        request.threads = Some(u16::try_from(start.threads).unwrap_or(u16::MAX));
        request.expect = self.jobs.get(&start.job).map(|job| job.identity.content.stat);
        for path in [&request.output, &request.picture].into_iter().flatten() {
            if let Some(folder) = path.parent() {
                make_folder(folder, &mut self.folders)?;
            }
        }
        Ok(request)
    }

    fn picture(&self, item: &Item) -> PathBuf {
        self.options.folder.join(STATE_FOLDER).join("pictures").join(format!("{}.png", item.name))
    }

    /// A worker has something to say.
    pub(super) fn hear(&mut self, news: News) -> Result<(), BatchError> {
        let Some(pool) = &mut self.pool else { return Ok(()) };
        match pool.hear(news).map_err(BatchError::Worker)? {
            Meaning::Nothing => Ok(()),
            Meaning::Back(task) => {
                self.wait_again(task.job);
                Ok(())
            }
            Meaning::Ended(worker, task, said) => {
                self.answered(worker, &task, said)?;
                self.next_in_hand(worker)
            }
            Meaning::Died(worker, death) => self.buried(worker, &death),
        }
    }

    fn answered(&mut self, worker: usize, task: &Task, said: Said) -> Result<(), BatchError> {
        match said {
            Said::Done { outcome, .. } => self.done(worker, task, *outcome),
            Said::Failed { failure, .. } if task.cancelled && failure.kind == FailureKind::Cancelled => {
                self.uncount(task.job);
                self.wait_again(task.job);
                Ok(())
            }
            Said::Failed { failure, .. } => self.failed(task.job, failure),
            _ => Ok(()),
        }
    }

    fn done(&mut self, worker: usize, task: &Task, outcome: Outcome) -> Result<(), BatchError> {
        let Some(job) = self.jobs.remove(&task.job) else { return Ok(()) };
        if let (Some(item), Some(slot)) = (self.items.get(task.job), self.slots().get(worker)) {
            let highest = slot.highest == outcome.peak_bytes;
            let request = intake::request(item, self.options);
            self.estimator.learn(&request, item.size, job.text, &outcome, highest);
        }
        let (identity, attempts) = (Some(&job.identity), job.attempts);
        self.book.ended(End { number: task.job, identity, attempts, result: Ok(outcome) })
    }

    /// A worker may have begun what waited behind the job that has ended, or be left with much memory.
    fn next_in_hand(&mut self, worker: usize) -> Result<(), BatchError> {
        let Some(slot) = self.slots().get(worker) else { return Ok(()) };
        if let Some(task) = slot.hand().front() {
            let number = task.job;
            return self.started(number, worker);
        }
        let Some(pool) = &mut self.pool else { return Ok(()) };
        pool.look_at(worker);
        if pool.slots().get(worker).is_some_and(|slot| slot.resident > RETIRE_BYTES) {
            pool.retire(worker).map_err(BatchError::Worker)?;
        }
        Ok(())
    }

    fn buried(&mut self, worker: usize, death: &Death) -> Result<(), BatchError> {
        if death.asked {
            // Who ends a batch in order may ask all its processes at a time; our turn is next.
            thread::sleep(GRACE);
            self.heed();
            if self.finished() {
                return Ok(());
            }
        }
        self.book.totals.workers_lost += 1;
        self.book.tell(&Event::WorkerLost { worker, reason: &death.reason });
        // A worker that is killed may leave unfinished files; what waited may just have been begun.
        for item in death.hand.iter().filter_map(|task| self.items.get(task.job)) {
            output::sweep(&self.options.folder.join(&item.name));
            output::sweep(&self.picture(item));
        }
        // What waited was never begun.
        for task in death.hand.iter().skip(1) {
            self.wait_again(task.job);
        }
        let Some(task) = death.hand.front() else { return Ok(()) };
        let (Some(item), Some(job)) = (self.items.get(task.job), self.jobs.get_mut(&task.job)) else {
            return Ok(());
        };
        let limits = &self.options.limits;
        let bytes = limits.job_memory.min(limits.memory);
        let failure = failure_of(death, &item.request.model, limits.job_seconds, bytes);
        job.claim.bytes = job.claim.bytes.max(death.resident);
        // A second death may be due to the company.
        job.turn = if job.turn == Turn::Usual { Turn::Suspect } else { Turn::Alone };
        if death.sentence == Some(Sentence::Crowd) {
            // The others took part in it. Alone there is no crowd, so that this comes once.
            job.turn = Turn::Alone;
            let attempt = job.attempts;
            self.book.again(task.job, &failure, attempt);
            self.uncount(task.job);
            self.wait_again(task.job);
            return Ok(());
        }
        self.failed(task.job, failure)
    }

    /// A try failed.
    fn failed(&mut self, number: usize, failure: Failure) -> Result<(), BatchError> {
        let Some(attempts) = self.jobs.get(&number).map(|job| job.attempts) else { return Ok(()) };
        match verdict(&failure, attempts, self.options.limits.retries) {
            Verdict::Stop => {
                self.book.totals.stopped.get_or_insert(failure.message);
                Ok(())
            }
            Verdict::Again => {
                self.book.again(number, &failure, attempts);
                self.wait_again(number);
                Ok(())
            }
            Verdict::Final(status) => {
                let Some(job) = self.jobs.remove(&number) else { return Ok(()) };
                if !job.begun {
                    self.permit();
                }
                let identity = Some(&job.identity);
                self.book.ended(End { number, identity, attempts, result: Err((status, failure)) })
            }
        }
    }

    fn uncount(&mut self, number: usize) {
        if let Some(job) = self.jobs.get_mut(&number) {
            job.attempts = job.attempts.saturating_sub(1);
        }
    }

    fn wait_again(&mut self, number: usize) {
        if let Some(job) = self.jobs.get(&number) {
            self.schedule.add(number, job.claim, job.turn);
        }
    }

    /// Lets the intake look at another model.
    fn permit(&self) {
        // It may have looked at all.
        let _ = self.permits.send(());
    }

    /// Looks after limits of time and memory.
    pub(super) fn watch(&mut self) -> Result<(), BatchError> {
        let Some(pool) = &mut self.pool else { return Ok(()) };
        pool.look();
        pool.wake();
        self.own = memory::own();
        let sum = self.own + pool.slots().iter().map(|slot| slot.resident).sum::<u64>();
        self.book.totals.peak_bytes = self.book.totals.peak_bytes.max(sum);
        let watched: Vec<_> = pool.slots().iter().map(Into::into).collect();
        for (worker, measure) in measures(&watched, self.own, &self.options.limits) {
            match measure {
                Measure::Retire => pool.retire(worker).map_err(BatchError::Worker)?,
                Measure::Kill(sentence) => pool.kill(worker, sentence),
            }
        }
        for worker in 0..pool.slots().len() {
            let late = pool
                .slots()
                .get(worker)
                .and_then(|slot| slot.hand().front())
                .is_some_and(|task| task.since.elapsed().as_secs_f64() > task.claim.seconds + OVERDUE);
            if late {
                pool.take_back(worker);
            }
        }
        Ok(())
    }

    /// Between any two messages: records, news, and whether to go on.
    pub(super) fn breathe(&mut self) -> Result<(), BatchError> {
        self.book.checkpoint()?;
        self.book.tick();
        self.heed();
        Ok(())
    }

    fn heed(&mut self) {
        if self.book.wants_stop() {
            self.book.totals.stopped.get_or_insert_with(|| "stopped on request".to_owned());
        }
    }

    /// Ends all workers. What they had finished before is recorded; the rest is given up.
    pub(super) fn end(&mut self, mut news: impl FnMut() -> Option<News>) -> Result<(), BatchError> {
        if let Some(pool) = &mut self.pool {
            pool.kill_all();
        }
        let recorded = self.record_last(&mut news).and_then(|()| self.book.checkpoint_now());
        // On a full disk these cannot be recorded, which is told already; a later run does them again.
        if self.book.totals.stopped.is_some() { Ok(()) } else { recorded }
    }

    fn record_last(&mut self, news: &mut impl FnMut() -> Option<News>) -> Result<(), BatchError> {
        while let Some(news) = news() {
            let done = matches!(news.said, Said::Done { .. });
            let Some(pool) = self.pool.as_mut().filter(|_| done) else { continue };
            if let Ok(Meaning::Ended(worker, task, Said::Done { outcome, .. })) = pool.hear(news) {
                self.done(worker, &task, *outcome)?;
            }
        }
        Ok(())
    }

    pub(super) fn leave(self) -> (Vec<Row>, Totals) {
        self.book.close()
    }
}

/// Makes a folder, unless that was done before.
fn make_folder(folder: &Path, made: &mut BTreeSet<PathBuf>) -> Result<(), Failure> {
    if made.contains(folder) {
        return Ok(());
    }
    std::fs::create_dir_all(folder).map_err(|e| Failure {
        disk_full: matches!(e.kind(), io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded),
        ..Failure::new(
            FailureKind::Output,
            format!("{}: cannot make the folder: {e}; check the path and its permissions", folder.display()),
        )
    })?;
    made.insert(folder.to_owned());
    Ok(())
}
