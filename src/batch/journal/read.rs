//! Reading journals, and joining them.

use super::past::Past;
use super::record::{FORMAT, Head, Line, Record, Wrong};
use crate::batch::event::Status;
use crate::batch::key::Key;
use crate::batch::{BatchError, STATE_FOLDER};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

/// Where a row is, and how it ranks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// Number of the journal.
    pub journal: u32,
    /// Length of the line \[bytes\].
    pub length: u32,
    /// Where the line begins \[bytes\].
    pub offset: u64,
    run: u64,
    done: bool,
}

/// What one journal says.
#[derive(Debug, Default)]
pub(super) struct Log {
    /// Its last run; 0 where it has none.
    pub run: u64,
    /// Length of its sound lines \[bytes\]; what follows is torn.
    pub length: u64,
    /// Whether a job was ever begun.
    pub begun: bool,
    /// Whether its last run has come to its end in order.
    pub closed: bool,
    /// The last word about each output.
    rows: BTreeMap<String, Place>,
    /// Names of rows after the last checkpoint.
    unsynced: BTreeSet<String>,
    /// Tries in hand at deaths: how many, and the run of the last.
    died: BTreeMap<(String, Key), (u32, u64)>,
    /// Tries in hand.
    hand: BTreeSet<(String, Key)>,
    /// Names of outputs that were in hand at an orderly end.
    given_up: BTreeSet<String>,
}

/// No sound line is longer.
const LONGEST: u64 = 1 << 26;

impl Log {
    /// Reads a journal. Lines after the last checkpoint may be torn or garbled: the first of these and all
    /// after it are left out.
    ///
    /// # Errors
    /// [`BatchError::Journal`]: damage before the last checkpoint, or another format. [`BatchError::Input`].
    pub(super) fn read(path: &Path, file: &File) -> Result<Self, BatchError> {
        let mut log = Self::default();
        let mut reader = BufReader::with_capacity(1 << 17, file);
        let mut damage = None;
        let (mut offset, mut number) = (0, 0);
        let mut line = Vec::new();
        let unreadable = |source| BatchError::Input { path: path.to_owned(), source };
        while next(&mut reader, &mut line).map_err(unreadable)? {
            number += 1;
            offset += line.len() as u64;
            let parsed = match line.split_last() {
                Some((b'\n', text)) => Line::parse(text),
                _ => Err(Wrong::Damaged("it has no end".to_owned())),
            };
            let at = |line, problem| BatchError::Journal { path: path.to_owned(), line, problem };
            match (parsed, &damage) {
                (Err(Wrong::OtherFormat(format)), _) => {
                    let problem = format!("the journal has format {format}, this version reads {FORMAT}");
                    return Err(at(number, problem));
                }
                // A file that is no journal is not ours to cut.
                (Ok(Line::Record(_)), _) if log.run == 0 => {
                    return Err(at(number, "a journal begins with a line {\"journal\":1,…}".to_owned()));
                }
                (Err(Wrong::Damaged(problem)), _) if log.run == 0 && line.ends_with(b"\n") => {
                    return Err(at(number, problem));
                }
                (Err(Wrong::Damaged(problem)), None) => damage = Some((number, problem)),
                // What came before a checkpoint had reached the disk, so it was not a torn write.
                (Ok(Line::Record(Record::Checkpoint {})), Some((line, problem))) => {
                    return Err(at(*line, problem.clone()));
                }
                (_, Some(_)) => {}
                (Ok(line), None) => {
                    log.add(line, offset);
                    log.length = offset;
                }
            }
        }
        log.end_run();
        Ok(log)
    }

    /// Names of outputs that were being made when a process died, or still are.
    pub(super) fn lost(&self) -> impl Iterator<Item = &str> {
        self.died.keys().map(|(name, _)| name.as_str())
    }

    /// Names of outputs that this shard has begun.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        let begun = self.died.keys().map(|(name, _)| name);
        begun.chain(&self.given_up).chain(self.rows.keys()).map(String::as_str)
    }

    /// Takes in a line that ends at `end`.
    fn add(&mut self, line: Line<'_>, end: u64) {
        match line {
            Line::Head(Head { run, .. }) => {
                self.end_run();
                self.run = run.max(self.run + 1);
                self.closed = false;
            }
            Line::Record(Record::Started { name, key }) => {
                self.begun = true;
                self.hand.insert((name.into_owned(), key));
            }
            Line::Record(Record::Ended { name, key, status }) => {
                self.begun = true;
                let job = (name.into_owned(), key);
                self.hand.remove(&job);
                self.died.remove(&job);
                self.unsynced.insert(job.0.clone());
                let length = u32::try_from(end - self.length).unwrap_or(u32::MAX);
                let (run, done) = (self.run, status == Status::Done);
                self.rows.insert(job.0, Place { journal: 0, length, offset: self.length, run, done });
            }
            Line::Record(Record::Checkpoint {}) => self.unsynced.clear(),
            Line::Record(Record::Closed {}) => {
                self.closed = true;
                self.given_up.extend(std::mem::take(&mut self.hand).into_iter().map(|(name, _)| name));
            }
        }
    }

    /// What is still in hand where a run ends was in hand when its process died.
    fn end_run(&mut self) {
        for job in std::mem::take(&mut self.hand) {
            let (times, run) = self.died.entry(job).or_default();
            *times += 1;
            *run = self.run;
        }
    }
}

/// The next line with its line feed, if it has one; false at the end.
fn next(reader: &mut impl BufRead, line: &mut Vec<u8>) -> io::Result<bool> {
    line.clear();
    io::Read::take(&mut *reader, LONGEST).read_until(b'\n', line)?;
    Ok(!line.is_empty())
}

/// Joins what several journals say. The last word about an output is that of the latest run; where two runs of
/// different shards have the same number, done beats failed.
pub(super) fn join(logs: impl IntoIterator<Item = (PathBuf, Log)>) -> Past {
    let mut died: BTreeMap<(String, Key), (u32, u64)> = BTreeMap::new();
    let mut past = Past::default();
    for (number, (path, log)) in (0..).zip(logs) {
        past.journals.push(path);
        for (name, place) in log.rows {
            let rank = |place: &Place| (place.run, place.done);
            if past.rows.get(&name).is_some_and(|other| rank(other) >= rank(&place)) {
                continue;
            }
            if log.unsynced.contains(&name) {
                past.unsynced.insert(name.clone());
            } else {
                past.unsynced.remove(&name);
            }
            past.rows.insert(name, Place { journal: number, ..place });
        }
        for (job, (times, run)) in log.died {
            let (all, last) = died.entry(job).or_default();
            *all += times;
            *last = run.max(*last);
        }
    }
    for (job, (times, run)) in died {
        // Unless it has ended since, in another shard.
        if past.rows.get(&job.0).is_none_or(|row| row.run <= run) {
            past.died.insert(job, times);
        }
    }
    past
}

/// The journals in an output folder, by name.
///
/// # Errors
/// When the folder cannot be read; none where it is not there.
pub(super) fn journals(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match std::fs::read_dir(folder.join(STATE_FOLDER)) {
        Ok(entries) => entries,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(e),
    };
    let mut found = Vec::new();
    for entry in entries {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.starts_with("journal-") && name.ends_with(".jsonl") {
            found.push(entry.path());
        }
    }
    found.sort();
    Ok(found)
}
