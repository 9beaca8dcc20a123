//! What earlier runs have left, and what of it still holds.

use super::content::content_crc32;
use super::read::Place;
use super::record::Ended;
use crate::batch::BatchError;
use crate::batch::event::{Row, Status};
use crate::batch::key::Key;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
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

    /// All rows, by name; journals are read from front to back.
    pub(super) fn all(&self) -> Result<Vec<Row>, BatchError> {
        let mut order: Vec<_> = self.rows.iter().collect();
        order.sort_unstable_by_key(|(_, place)| (place.journal, place.offset));
        let mut found = BTreeMap::new();
        for part in order.chunk_by(|a, b| a.1.journal == b.1.journal) {
            let journal = part.first().and_then(|(_, place)| self.journals.get(place.journal as usize));
            let Some(path) = journal else { continue };
            let unreadable = |source| BatchError::Input { path: path.clone(), source };
            let mut file = BufReader::with_capacity(1 << 17, File::open(path).map_err(unreadable)?);
            let (mut at, mut line) = (0, Vec::new());
            for (name, place) in part {
                file.seek_relative((place.offset - at).cast_signed()).map_err(unreadable)?;
                line.resize(place.length as usize, 0);
                file.read_exact(&mut line).map_err(unreadable)?;
                at = place.offset + u64::from(place.length);
                let Ended { ended } = serde_json::from_slice(&line).map_err(|e| BatchError::Journal {
                    path: path.clone(),
                    line: line_at(path, place.offset),
                    problem: e.to_string(),
                })?;
                found.insert(name.as_str(), ended);
            }
        }
        Ok(found.into_values().collect())
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

/// The number of the line that begins at so many bytes, from 1; 0 where that cannot be told.
fn line_at(path: &Path, offset: u64) -> u64 {
    let before = File::open(path).map(|file| BufReader::new(file.take(offset)).split(b'\n').count());
    before.map_or(0, |lines| lines as u64 + 1)
}
