//! What earlier runs have left, and what of it still holds.

use super::content::content_crc32;
use crate::batch::event::{Row, Status};
use crate::batch::key::Key;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// What earlier runs, of this or other shards, have left.
#[derive(Clone, Debug, Default)]
pub struct Past {
    /// The last word about each output, by name.
    pub rows: BTreeMap<String, Row>,
    /// Names of rows whose outputs may not have reached the disk: no checkpoint followed.
    pub unsynced: BTreeSet<String>,
    /// Tries that were in hand when a process died, by name and key: how often since the job last ended.
    pub died: BTreeMap<(String, Key), u32>,
}

impl Past {
    /// The row that still holds for a job: same name, same key, and, where it was done, the output as it was
    /// written (its size; its checksum too where it may not have reached the disk). Of a folder of layers that
    /// was followed by a checkpoint, that it is there.
    pub fn standing(&self, name: &str, key: &Key, folder: &Path) -> Option<&Row> {
        self.rows.get(name).filter(|row| row.key == *key && self.output_holds(row, folder))
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
