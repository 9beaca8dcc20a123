//! Worker processes.
//!
//! Each slot holds one process. What befalls a process concerns the job in its hand only; another takes its
//! place at once.

mod child;
pub mod memory;

pub use child::{News, Post, PostBox, Said};

use super::options::BatchOptions;
use super::schedule::Claim;
use crate::job::backend::{Backend, BackendOptions};
use crate::slicer::Request;
use crate::slicer::protocol::{Message, Order};
use child::Child;
use std::collections::VecDeque;
use std::ffi::OsString;
use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// An idle process that still holds more than this has been left with much by a large job \[bytes\].
pub const RETIRE_BYTES: u64 = 256 << 20;

/// So many deaths in a row of processes that never said they were ready mean that none ever will.
const FALSE_STARTS: u32 = 8;

/// A process must be ready after this.
const START_LIMIT: Duration = Duration::from_secs(120);

/// Requests longer than this are not written to a worker that is still busy: a pipe holds 64 KiB.
const LONGEST_AHEAD: usize = 16 << 10;

/// A job in a worker's hand.
#[derive(Clone, Debug)]
pub struct Task {
    /// Which job.
    pub job: usize,
    /// Its threads.
    pub threads: usize,
    /// What it is taken to need.
    pub claim: Claim,
    /// When the worker began; for a job that waits behind another, when it was given.
    pub since: Instant,
    /// Whether the worker has been asked to leave it.
    pub cancelled: bool,
    ticket: u64,
}

/// Why we end a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sentence {
    /// Its job takes too long.
    Time,
    /// Its job takes too much memory.
    Memory,
    /// All jobs together take too much memory, and this one exceeds its claim most.
    Crowd,
}

/// A worker and what it has in hand: at most a job, and another behind it.
#[derive(Debug)]
pub struct Slot {
    child: Child,
    ready: bool,
    born: Instant,
    hand: VecDeque<Task>,
    sentence: Option<Sentence>,
    confused: bool,
    /// Memory at the last look \[bytes\].
    pub resident: u64,
    /// The most memory that any of its answers spoke of \[bytes\].
    pub highest: u64,
}

/// A worker's death.
#[derive(Debug)]
pub struct Death {
    /// What the system said of it, as part of a sentence.
    pub reason: String,
    /// Whether somebody else asked it to end, by a signal.
    pub asked: bool,
    /// Whether we ended it, and why.
    pub sentence: Option<Sentence>,
    /// What it had in hand; the first is what it worked on.
    pub hand: VecDeque<Task>,
    /// Its memory at the last look \[bytes\].
    pub resident: u64,
}

/// What news mean.
#[derive(Debug)]
pub enum Meaning {
    /// Nothing is to be done, but perhaps a worker is idle now.
    Nothing,
    /// The job in hand has ended.
    Ended(usize, Task, Said),
    /// A job that waited behind another is given back.
    Back(Task),
    /// A worker has died; another has taken its place.
    Died(usize, Death),
}

/// All worker processes.
#[derive(Debug)]
pub struct Pool {
    slots: Vec<Slot>,
    staff: Staff,
    tickets: u64,
    false_starts: u32,
}

/// How processes are started.
#[derive(Debug)]
struct Staff {
    program: PathBuf,
    backend: BackendOptions,
    device_workers: usize,
    post: Post,
    serial: u64,
}

impl Staff {
    fn hire(&mut self, slot: usize) -> io::Result<Slot> {
        self.serial += 1;
        let child = Child::start(&self.program, &self.arguments(slot), (slot, self.serial), &self.post)?;
        let (hand, born) = (VecDeque::new(), Instant::now());
        let (ready, sentence, confused) = (false, None, false);
        Ok(Slot { child, ready, born, hand, sentence, confused, resident: 0, highest: 0 })
    }

    fn arguments(&self, slot: usize) -> Vec<OsString> {
        let backend = match self.backend.backend {
            Backend::Cpu => "cpu",
            Backend::Gpu => "gpu",
            Backend::Auto if slot < self.device_workers => "auto",
            Backend::Auto => "cpu",
        };
        let mut all: Vec<OsString> =
            ["worker", "--jobs", "1", "--die-with-input", "--backend", backend].map(Into::into).into();
        if let Some(name) = self.backend.adapter.as_ref().filter(|_| backend != "cpu") {
            all.extend(["--adapter".into(), name.into()]);
        }
        if let Some(bytes) = self.backend.memory {
            all.extend(["--memory".into(), bytes.to_string().into()]);
        }
        all
    }
}

impl Pool {
    /// Starts so many processes, whose news go to `post` from threads of their own.
    ///
    /// # Errors
    /// Of the system, when a process cannot be started.
    pub fn start(options: &BatchOptions, count: usize, post: Post) -> io::Result<Self> {
        let mut staff = Staff {
            program: options.worker.clone(),
            backend: options.backend.clone(),
            device_workers: options.device_workers,
            post,
            serial: 0,
        };
        let slots = (0..count).map(|slot| staff.hire(slot)).collect::<io::Result<_>>()?;
        Ok(Self { slots, staff, tickets: 0, false_starts: 0 })
    }

    /// The workers.
    pub fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// The first worker that has nothing to do.
    pub fn idle(&self) -> Option<usize> {
        self.slots.iter().position(Slot::idle)
    }

    /// Hands a job to a worker, behind the one that it works on if there is one. If the worker is dead the
    /// job comes back with the news of that.
    ///
    /// # Errors
    /// When the request cannot be written as JSON; the job is not in hand then.
    pub fn give(
        &mut self,
        slot: usize,
        (job, threads, claim): (usize, usize, Claim),
        request: &Request,
    ) -> serde_json::Result<()> {
        self.tickets += 1;
        let (ticket, since) = (self.tickets, Instant::now());
        let order = Order::Slice(Box::new(request.clone()));
        let line = serde_json::to_string(&Message { id: ticket.into(), order })?;
        if let Some(slot) = self.slots.get_mut(slot) {
            slot.hand.push_back(Task { job, threads, claim, since, cancelled: false, ticket });
            slot.child.write(&line);
        }
        Ok(())
    }

    /// Asks a worker to leave the job that waits behind another.
    pub fn take_back(&mut self, slot: usize) {
        let Some(slot) = self.slots.get_mut(slot) else { return };
        if let Some(task) = slot.hand.get_mut(1).filter(|task| !task.cancelled) {
            task.cancelled = true;
            let order = Order::Cancel(task.ticket.into());
            if let Ok(line) = serde_json::to_string(&Message { id: serde_json::Value::Null, order }) {
                slot.child.write(&line);
            }
        }
    }

    /// Ends a process. News of its death follow.
    pub fn kill(&mut self, slot: usize, sentence: Sentence) {
        if let Some(slot) = self.slots.get_mut(slot) {
            slot.sentence.get_or_insert(sentence);
            slot.child.kill();
        }
    }

    /// Puts a fresh process in the place of an idle one.
    ///
    /// # Errors
    /// Of the system.
    pub fn retire(&mut self, slot: usize) -> io::Result<()> {
        let fresh = self.staff.hire(slot)?;
        if let Some(old) = self.slots.get_mut(slot) {
            *old = fresh;
        }
        Ok(())
    }

    /// What a worker's news mean; a worker that has died is replaced.
    ///
    /// # Errors
    /// When workers keep dying before they are ready, or cannot be started.
    pub fn hear(&mut self, news: News) -> io::Result<Meaning> {
        let News { place: (at, serial), said } = news;
        let Some(slot) = self.slots.get_mut(at).filter(|slot| slot.child.serial() == serial) else {
            return Ok(Meaning::Nothing);
        };
        match said {
            Said::Ready { version } if version == env!("CARGO_PKG_VERSION") => {
                (slot.ready, self.false_starts) = (true, 0);
                Ok(Meaning::Nothing)
            }
            Said::Ready { version } => Err(io::Error::other(format!(
                "{} is version {version} now, this is {}; start the batch again",
                self.staff.program.display(),
                env!("CARGO_PKG_VERSION")
            ))),
            Said::Nothing => Ok(Meaning::Nothing),
            Said::Nonsense => {
                slot.confused = true;
                slot.child.kill();
                Ok(Meaning::Nothing)
            }
            Said::Closed => self.bury(at),
            Said::Done { ticket, .. } | Said::Failed { ticket, .. } => {
                let Some(place) = slot.hand.iter().position(|task| task.ticket == ticket) else {
                    return Ok(Meaning::Nothing);
                };
                if let Said::Done { outcome, .. } = &said {
                    slot.highest = slot.highest.max(outcome.peak_bytes);
                }
                let Some(task) = slot.hand.remove(place) else { return Ok(Meaning::Nothing) };
                // What waited behind it is begun now.
                if let Some(next) = slot.hand.front_mut().filter(|_| place == 0) {
                    next.since = Instant::now();
                }
                Ok(if place == 0 { Meaning::Ended(at, task, said) } else { Meaning::Back(task) })
            }
        }
    }

    /// Looks at the memory of all processes.
    pub fn look(&mut self) {
        for slot in &mut self.slots {
            slot.look();
        }
    }

    /// Looks at the memory of one process.
    pub fn look_at(&mut self, slot: usize) {
        if let Some(slot) = self.slots.get_mut(slot) {
            slot.look();
        }
    }

    /// Ends processes that should have been ready long ago.
    pub fn wake(&mut self) {
        for slot in &mut self.slots {
            if !slot.ready && slot.born.elapsed() > START_LIMIT {
                slot.child.kill();
            }
        }
    }

    /// Ends all processes at once, in the middle of everything.
    pub fn kill_all(&mut self) {
        for slot in &mut self.slots {
            slot.child.kill();
        }
        for slot in &mut self.slots {
            slot.child.wait();
        }
    }

    fn bury(&mut self, at: usize) -> io::Result<Meaning> {
        let fresh = self.staff.hire(at)?;
        let Some(slot) = self.slots.get_mut(at) else { return Ok(Meaning::Nothing) };
        let mut old = std::mem::replace(slot, fresh);
        let (reason, asked) = match old.child.epitaph() {
            _ if old.confused => ("said what no worker says".to_owned(), false),
            known => known,
        };
        self.false_starts += u32::from(!old.ready);
        if self.false_starts >= FALSE_STARTS {
            return Err(io::Error::other(format!("{} {reason}", self.staff.program.display())));
        }
        let Slot { sentence, resident, .. } = old;
        Ok(Meaning::Died(at, Death { reason, asked, sentence, hand: old.hand, resident }))
    }
}

impl Slot {
    /// What it has in hand; the first is what it works on.
    pub fn hand(&self) -> &VecDeque<Task> {
        &self.hand
    }

    /// Whether it waits for a job.
    pub fn idle(&self) -> bool {
        self.ready && self.sentence.is_none() && self.hand.is_empty()
    }

    /// Whether another job may be handed to it behind the one it works on, as far as it is concerned.
    pub fn has_room_behind(&self, request: &Request) -> bool {
        let small = |request: &Request| {
            let settings: usize = request.settings.iter().map(|(k, v)| k.len() + v.len()).sum();
            settings < LONGEST_AHEAD
        };
        self.ready && self.sentence.is_none() && self.hand.len() == 1 && small(request)
    }

    /// The claim of what it works on and what waits behind that, whichever is larger, or the memory that it
    /// takes \[bytes\].
    pub fn bytes(&self) -> u64 {
        self.hand.iter().map(|task| task.claim.bytes).fold(self.resident, u64::max)
    }

    /// Whether we have ended it.
    pub fn condemned(&self) -> bool {
        self.sentence.is_some()
    }

    fn look(&mut self) {
        self.resident = memory::resident(self.child.pid()).unwrap_or(0);
    }
}
