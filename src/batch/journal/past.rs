//! What earlier runs have left, and what of it still holds.

use super::content::content_crc32;
use super::read::Place;
use super::record::Ended;
use crate::batch::event::{Row, Status};
use crate::batch::key::Key;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// What earlier runs, of this or other shards, have left: an index of journals, from which rows are read when
/// they are asked for.
#[derive(Clone, Debug, Default)]
pub struct Past {
    /// Tries that were in hand when a process died, by name and key: how often since the job last ended.
    pub died: BTreeMap<(String, Key), u32>,
    pub(super) journals: Vec<PathBuf>,
    /// The last word about each output, by name.
    pub(super) rows: BTreeMap<String, Place>,
    /// Names of rows whose outputs may not have reached the disk: no checkpoint followed.
    pub(super) unsynced: BTreeSet<String>,
}

impl Past {
    /// Names of all outputs that there is a row of, sorted.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.rows.keys().map(String::as_str)
    }

    /// The last word about an output. None too where the journal cannot be read any more.
    pub fn row(&self, name: &str) -> Option<Row> {
        let place = self.rows.get(name)?;
        let mut file = File::open(self.journals.get(place.journal as usize)?).ok()?;
        file.seek(SeekFrom::Start(place.offset)).ok()?;
        let mut line = vec![0; place.length as usize];
        file.read_exact(&mut line).ok()?;
        let Ended { ended } = serde_json::from_slice(&line).ok()?;
        (ended.name == name).then_some(ended)
    }

    /// The row that still holds for a job: same name, same key, and, where it was done, the output as it was
    /// written (its size; its checksum too where it may not have reached the disk). Of a folder of layers that
    /// was followed by a checkpoint, that it is there.
    pub fn standing(&self, name: &str, key: &Key, folder: &Path) -> Option<Row> {
        self.row(name).filter(|row| row.key == *key && self.output_holds(row, folder))
    }

    fn output_holds(&self, row: &Row, folder: &Path) -> bool {
        if row.status != Status::Done || row.request.estimate {
            return true;
        }
        let Some(outcome) = &row.outcome else { return false };
        let path = folder.join(&row.name);
        let Ok(meta) = std::fs::metadata(&path) else { return false };
        if meta.is_file() && meta.len() != outcome.bytes {
            return false;
        }
        !self.unsynced.contains(&row.name) || content_crc32(&path).is_ok_and(|crc| crc == outcome.crc32)
    }
}
