//! The record of a batch, from which a later run goes on.
//!
//! A journal is a file of JSON lines, `DIR/.microtome/journal-I-of-N.jsonl`, to which one process appends:
//!
//! - `{"journal":1,"run":1767225600000,"version":"0.1.0","shard":{"index":1,"count":1}}` begins a run; `journal` is the
//!   format, `run` tells the order of runs,
//! - `{"started":{"name":"a.gcode","key":"…","attempt":1}}` before a worker begins a try,
//! - `{"ended":{…}}` with a whole [`Row`] when a job is done, has failed, or is put into quarantine,
//! - `{"checkpoint":{}}` when all outputs and lines above have reached the disk,
//! - `{"closed":{}}` when the process ends in order; tries still in hand were given up, not lost.
//!
//! Each line is one `write`, so that it survives the death of the process as soon as the call returns. Loss of
//! power may take or garble lines after the last checkpoint: those are cut off when the journal is opened
//! again, and the outputs of rows after the last checkpoint count only if their checksum is right. Damage
//! before the last checkpoint is no accident of writing, and an error.

mod content;
mod disk;
mod leftovers;
mod past;
mod read;
mod record;
#[cfg(test)]
mod tests;

pub use content::content_crc32;
pub use past::Past;

use super::event::Row;
use super::key::Key;
use super::shard::Shard;
use super::{BatchError, STATE_FOLDER};
use disk::Lock;
use leftovers::Leftovers;
use read::Log;
use record::{Entry, FORMAT, Head};
use serde::Serialize;
use std::collections::BTreeSet;
use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// An open journal of one shard, to which only this process appends.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
    file: File,
    /// Length of what is sound \[bytes\].
    length: u64,
    /// A record is half written and could not be taken back: nothing may follow it.
    torn: bool,
    /// The folder of the outputs.
    folder: PathBuf,
    /// The same, open.
    #[cfg(target_os = "linux")]
    root: File,
    /// Outputs since the last checkpoint.
    #[cfg(not(target_os = "linux"))]
    outputs: Vec<PathBuf>,
    leftovers: Leftovers,
    /// Whether there are rows since the last checkpoint.
    unsynced: bool,
    warning: Option<String>,
}

impl Journal {
    /// Opens `folder/.microtome/journal-I-of-N.jsonl` for appending and locks it; makes the folders. With
    /// `resume` the past is what it says, and what journals of another number of shards say; those of the same
    /// number concern other jobs. With `restart` an earlier journal of the shard is renamed to `.old`.
    ///
    /// # Errors
    /// [`BatchError::NotFresh`] where the shard has begun already and neither `resume` nor `restart` is given,
    /// [`BatchError::Locked`], [`BatchError::Write`], [`BatchError::Journal`].
    pub fn open(
        folder: &Path,
        shard: Shard,
        resume: bool,
        restart: bool,
    ) -> Result<(Self, Past), BatchError> {
        let state = folder.join(STATE_FOLDER);
        let path = state.join(format!("journal-{}-of-{}.jsonl", shard.index, shard.count));
        let failed = |source| BatchError::Write { path: path.clone(), source };
        std::fs::create_dir_all(&state)
            .map_err(|source| BatchError::Write { path: state.clone(), source })?;
        let (mut file, warning) = locked(folder, &path)?;
        let mut names = BTreeSet::new();
        if restart && file.metadata().map_err(failed)?.len() > 0 {
            // However damaged it is, it is put aside.
            names.extend(Log::read(&path, &file).iter().flat_map(Log::names).map(str::to_owned));
            std::fs::rename(&path, path.with_extension("jsonl.old")).map_err(failed)?;
            // The old lock is held until the new one is, and the new one tells whether it came too late.
            file = locked(folder, &path)?.0;
        }

        let own = Log::read(&path, &file)?;
        if own.begun && !resume && !restart {
            return Err(BatchError::NotFresh { folder: folder.to_owned() });
        }
        let length = own.length;
        let mut logs = vec![(path.clone(), own)];
        let siblings = format!("-of-{}.jsonl", shard.count);
        for other in read::journals(folder).map_err(failed)?.into_iter().filter(|_| resume) {
            if !other.to_string_lossy().ends_with(&siblings) {
                let log = read_log(&other)?;
                logs.push((other, log));
            }
        }
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default().as_millis();
        let earlier = logs.iter().map(|(_, log)| log.run).max().unwrap_or_default();
        let run = u64::try_from(now).unwrap_or_default().max(earlier + 1);
        let names = names.iter().map(String::as_str);
        let leftovers = Leftovers::find(folder, names.chain(logs.iter().flat_map(|(_, log)| log.names())));
        let past = if resume { read::join(logs) } else { Past::default() };

        file.set_len(length).map_err(failed)?;
        let mut journal = Self {
            file,
            length,
            torn: false,
            folder: folder.to_owned(),
            #[cfg(target_os = "linux")]
            root: File::open(folder)
                .map_err(|source| BatchError::Write { path: folder.to_owned(), source })?,
            #[cfg(not(target_os = "linux"))]
            outputs: Vec::new(),
            leftovers,
            unsynced: false,
            warning,
            path,
        };
        let version = env!("CARGO_PKG_VERSION").to_owned();
        journal.append(&Head { journal: FORMAT, run, version, shard })?;
        if length == 0 {
            journal.file.sync_all().map_err(|e| journal.failed(e))?;
            for new in [Some(state.as_path()), Some(folder), folder.parent()].into_iter().flatten() {
                disk::sync_folder(new);
            }
        }
        Ok((journal, past))
    }

    /// What the user should know: nothing keeps another process from working in the same folder.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// A worker is about to begin a try. Survives the death of this process.
    ///
    /// # Errors
    /// [`BatchError::Write`].
    pub fn started(&mut self, name: &str, key: &Key, attempt: u32) -> Result<(), BatchError> {
        self.leftovers.remove(&self.folder, name);
        self.append(&Entry::Started { name, key, attempt })
    }

    /// A job has ended, well or badly. Survives the death of this process at once, and the loss of power after
    /// the next [`Self::checkpoint`].
    ///
    /// # Errors
    /// [`BatchError::Write`].
    pub fn ended(&mut self, row: &Row) -> Result<(), BatchError> {
        self.leftovers.remove(&self.folder, &row.name);
        self.append(&Entry::Ended(row))?;
        self.unsynced = true;
        #[cfg(not(target_os = "linux"))]
        if row.outcome.is_some() && !row.request.estimate {
            self.outputs.push(self.folder.join(&row.name));
        }
        Ok(())
    }

    /// Outputs and records so far reach the disk. Costs nothing where no job has ended since the last time.
    ///
    /// # Errors
    /// [`BatchError::Write`].
    pub fn checkpoint(&mut self) -> Result<(), BatchError> {
        if !self.unsynced {
            return Ok(());
        }
        self.sync_outputs().map_err(|e| self.failed(e))?;
        // The lines above too, before the line that says so.
        self.file.sync_data().map_err(|e| self.failed(e))?;
        self.append(&Entry::Checkpoint {})?;
        self.file.sync_data().map_err(|e| self.failed(e))?;
        self.unsynced = false;
        Ok(())
    }

    #[cfg(target_os = "linux")]
    fn sync_outputs(&self) -> io::Result<()> {
        disk::sync_file_system(&self.root)
    }

    #[cfg(not(target_os = "linux"))]
    fn sync_outputs(&mut self) -> io::Result<()> {
        let mut around = std::collections::BTreeSet::new();
        for output in self.outputs.drain(..) {
            // A folder of layers is synced with its files.
            if output.is_dir() {
                for entry in std::fs::read_dir(&output)? {
                    File::options().write(true).open(entry?.path())?.sync_all()?;
                }
                disk::sync_folder(&output);
            } else {
                File::options().write(true).open(&output)?.sync_all()?;
            }
            around.extend(output.parent().map(Path::to_owned));
        }
        around.iter().for_each(|folder| disk::sync_folder(folder));
        Ok(())
    }

    /// Writes a line in one call.
    fn append(&mut self, record: &impl Serialize) -> Result<(), BatchError> {
        let line = record::line(record).map_err(|e| self.failed(e.into()))?;
        if self.torn {
            return Err(self.failed(io::Error::other("an earlier line could not be completed")));
        }
        if let Err(e) = (&self.file).write_all(&line) {
            // What was written of it must not stand before later lines.
            self.torn = self.file.set_len(self.length).is_err();
            return Err(self.failed(e));
        }
        self.length += line.len() as u64;
        Ok(())
    }

    fn failed(&self, source: io::Error) -> BatchError {
        BatchError::Write { path: self.path.clone(), source }
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        if !std::thread::panicking() {
            // Without it the tries in hand count as lost with the process, which errs on the safe side.
            drop(self.append(&Entry::Closed {}));
        }
    }
}

/// The journal's file, locked, with a warning where locks are not to be had.
fn locked(folder: &Path, path: &Path) -> Result<(File, Option<String>), BatchError> {
    let failed = |source| BatchError::Write { path: path.to_owned(), source };
    loop {
        let file = File::options().read(true).append(true).create(true).open(path).map_err(failed)?;
        let warning = match disk::lock(&file) {
            Lock::Held => None,
            Lock::Taken => return Err(BatchError::Locked { folder: folder.to_owned() }),
            Lock::Unknown(e) => Some(format!(
                "{}: cannot be locked ({e}); see to it that no other batch works on the same shard there",
                path.display()
            )),
        };
        if disk::leads_to(path, &file).map_err(failed)? {
            return Ok((file, warning));
        }
    }
}

fn read_log(path: &Path) -> Result<Log, BatchError> {
    let file = File::open(path).map_err(|source| BatchError::Input { path: path.to_owned(), source })?;
    Log::read(path, &file)
}

/// All rows of the journals in a folder, the last word about each output, by name.
///
/// # Errors
/// [`BatchError::Input`] where there is no journal, [`BatchError::Journal`].
pub fn read(folder: &Path) -> Result<Vec<Row>, BatchError> {
    let missing = |source| BatchError::Input { path: folder.join(STATE_FOLDER), source };
    let found = read::journals(folder).map_err(missing)?;
    if found.is_empty() {
        return Err(missing(io::ErrorKind::NotFound.into()));
    }
    let read = |path: PathBuf| read_log(&path).map(|log| (path, log));
    read::join(found.into_iter().map(read).collect::<Result<Vec<_>, _>>()?).all()
}

/// A shard's journal in short.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ShardState {
    /// Whose it is.
    pub shard: Shard,
    /// Whether its last run has come to its end in order; otherwise it died or is at work.
    pub closed: bool,
    /// Outputs that were being made when a process died, or still are, and that have not ended since.
    pub in_hand: Vec<String>,
}

/// The shards whose journals are in a folder, by name.
///
/// # Errors
/// [`BatchError::Input`], [`BatchError::Journal`].
pub fn shards(folder: &Path) -> Result<Vec<ShardState>, BatchError> {
    let failed = |source| BatchError::Input { path: folder.join(STATE_FOLDER), source };
    let mut states = Vec::new();
    for path in read::journals(folder).map_err(failed)? {
        let shard = path.file_name().and_then(|name| name.to_str()).and_then(|name| {
            let (index, count) = name.strip_prefix("journal-")?.strip_suffix(".jsonl")?.split_once("-of-")?;
            Some(Shard { index: index.parse().ok()?, count: count.parse().ok()? })
        });
        let Some(shard) = shard else { continue };
        let log = read_log(&path)?;
        let in_hand = log.lost().map(str::to_owned).collect();
        states.push(ShardState { shard, closed: log.closed, in_hand });
    }
    states.sort_by_key(|state| (state.shard.count, state.shard.index));
    Ok(states)
}
