//! Reading journals, and joining them.

use super::past::Past;
use super::record::{FORMAT, Head, Line, Record, Wrong};
use crate::batch::event::{Row, Status};
use crate::batch::key::Key;
use crate::batch::{BatchError, STATE_FOLDER};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

/// What one journal says.
#[derive(Debug, Default)]
pub(super) struct Log {
    /// Number of its last run; 0 where it has none.
    pub run: u64,
    /// Length of its sound lines \[bytes\]; what follows is torn.
    pub length: u64,
    /// Whether a job was ever begun.
    pub begun: bool,
    /// Whether its last run has come to its end in order.
    pub closed: bool,
    /// The last word about each output, with the run that said it.
    rows: BTreeMap<String, (u64, Row)>,
    /// Names of rows after the last checkpoint.
    unsynced: BTreeSet<String>,
    /// Tries in hand at deaths: how many, and the run of the last.
    died: BTreeMap<(String, Key), (u32, u64)>,
    /// Tries in hand.
    hand: BTreeSet<(String, Key)>,
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
                (Ok(Line::Record(record)), Some((line, problem)))
                    if matches!(*record, Record::Checkpoint {}) =>
                {
                    return Err(at(*line, problem.clone()));
                }
                (_, Some(_)) => {}
                (Ok(line), None) => {
                    log.add(line);
                    log.length = offset;
                }
            }
        }
        log.end_run();
        Ok(log)
    }

    /// Names of outputs that were being made when a process died.
    pub(super) fn lost(&self) -> impl Iterator<Item = &str> {
        self.died.keys().map(|(name, _)| name.as_str())
    }

    fn add(&mut self, line: Line) {
        let record = match line {
            Line::Head(Head { run, .. }) => {
                self.end_run();
                self.run = run.max(self.run + 1);
                self.closed = false;
                return;
            }
            Line::Record(record) => *record,
        };
        match record {
            Record::Started(started) => {
                self.begun = true;
                self.hand.insert((started.name.into_owned(), started.key.into_owned()));
            }
            Record::Ended(row) => {
                self.begun = true;
                let row = row.into_owned();
                let job = (row.name.clone(), row.key.clone());
                self.hand.remove(&job);
                self.died.remove(&job);
                self.unsynced.insert(job.0.clone());
                self.rows.insert(job.0, (self.run, row));
            }
            Record::Checkpoint {} => self.unsynced.clear(),
            Record::Closed {} => {
                self.hand.clear();
                self.closed = true;
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
pub(super) fn join(logs: impl IntoIterator<Item = Log>) -> Past {
    let mut rows: BTreeMap<String, (u64, Row)> = BTreeMap::new();
    let mut died: BTreeMap<(String, Key), (u32, u64)> = BTreeMap::new();
    let mut past = Past::default();
    for log in logs {
        let mut unsynced = log.unsynced;
        for (name, (run, row)) in log.rows {
            let fresh = unsynced.remove(&name);
            let rank = |run: u64, row: &Row| (run, row.status == Status::Done);
            match rows.entry(name) {
                Entry::Occupied(old) if rank(old.get().0, &old.get().1) >= rank(run, &row) => continue,
                Entry::Occupied(mut old) => {
                    if fresh {
                        past.unsynced.insert(old.key().clone());
                    } else {
                        past.unsynced.remove(old.key());
                    }
                    old.insert((run, row));
                }
                Entry::Vacant(place) => {
                    if fresh {
                        past.unsynced.insert(place.key().clone());
                    }
                    place.insert((run, row));
                }
            }
        }
        for (job, (times, run)) in log.died {
            let (all, last) = died.entry(job).or_default();
            *all += times;
            *last = run.max(*last);
        }
    }
    for (job, (times, run)) in died {
        // Ended since, in another shard.
        if rows.get(&job.0).is_some_and(|(ended, row)| *ended > run && row.key == job.1) {
            continue;
        }
        past.died.insert(job, times);
    }
    past.rows = rows.into_iter().map(|(name, (_, row))| (name, row)).collect();
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
