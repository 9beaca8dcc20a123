//! One report of several folders and shards, from their journals.

use super::{Job, Report, Sums, write_all};
use crate::batch::event::{Row, Totals};
use crate::batch::{BatchError, Shard, journal};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

/// What a joined report says in short.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Merged {
    /// Over all shards. What was skipped counts as done; `seconds` and `peak_bytes` are of the longest and
    /// the largest shard.
    pub totals: Totals,
    /// Over all jobs.
    pub sums: Sums,
    /// Shards of which there is no journal.
    pub missing: Vec<Shard>,
    /// Jobs that were begun and never ended.
    pub unfinished: Vec<String>,
    /// What is not as it should be, in words.
    pub notes: Vec<String>,
}

/// Joins the journals of folders into one report, `report.json`, `report.csv`, `report.html` and, where
/// something failed, `quarantine.jsonl`, in `output`. An output that several folders hold gets its folder
/// before its name.
///
/// # Errors
/// [`BatchError`]: a folder without a journal, a damaged one, a report that cannot be written.
pub fn merge(folders: &[PathBuf], output: &Path) -> Result<Merged, BatchError> {
    let mut merged = Merged::default();
    let mut rows: Vec<(usize, String, Row)> = Vec::new();
    let mut shards: BTreeMap<(u32, u32), usize> = BTreeMap::new();
    for (index, folder) in folders.iter().enumerate() {
        let known = rows.len();
        rows.extend(journal::read(folder)?.into_iter().map(|row| (index, row.name.clone(), row)));
        let ended: BTreeSet<&str> = rows[known..].iter().map(|(_, name, _)| name.as_str()).collect();
        for state in journal::shards(folder)? {
            let shard = state.shard;
            *shards.entry((shard.count, shard.index)).or_default() += 1;
            merged.add_shard(folder, shard, state.closed)?;
            // The folder may have been cut into other shards since.
            merged.unfinished.extend(state.in_hand.into_iter().filter(|name| !ended.contains(name.as_str())));
        }
    }
    name_apart(&mut rows, folders);
    merged.sums = Sums::of(rows.iter().map(|(.., row)| row));
    merged.totals.done = merged.sums.done;
    merged.totals.failed = merged.sums.failed;
    merged.totals.quarantined = merged.sums.quarantined;
    merged.miss(&shards);
    merged.conclude();

    let jobs = rows.iter().map(|(index, name, row)| Job { row, folder: &folders[*index], name }).collect();
    let names: Vec<String> = folders.iter().map(|folder| super::shown(folder)).collect();
    std::fs::create_dir_all(output)
        .map_err(|source| BatchError::Write { path: output.to_owned(), source })?;
    let report = Report {
        title: names.join(", "),
        folder: output,
        jobs,
        totals: &merged.totals,
        sums: merged.sums.clone(),
        notes: &merged.notes,
    };
    write_all(&report, "")?;
    Ok(merged)
}

/// Puts the folder before names that several folders hold.
fn name_apart(rows: &mut [(usize, String, Row)], folders: &[PathBuf]) {
    let mut holders: BTreeMap<&str, usize> = BTreeMap::new();
    for (_, name, _) in &*rows {
        *holders.entry(name).or_default() += 1;
    }
    let doubled: Vec<bool> = rows.iter().map(|(_, name, _)| holders[name.as_str()] > 1).collect();
    for ((index, name, row), _) in rows.iter_mut().zip(doubled).filter(|(_, doubled)| *doubled) {
        row.name = folders[*index].join(&*name).to_string_lossy().into_owned();
    }
}

impl Merged {
    /// What the last report of a shard knows beside its journal.
    fn add_shard(&mut self, folder: &Path, shard: Shard, closed: bool) -> Result<(), BatchError> {
        #[derive(Deserialize)]
        struct Written {
            totals: Totals,
        }
        let path = folder.join(format!("report{}.json", super::suffix(shard)));
        let what = if shard.count > 1 {
            format!("{}, shard {} of {}", folder.display(), shard.index, shard.count)
        } else {
            folder.display().to_string()
        };
        if !closed {
            self.notes.push(format!(
                "{what}: its process died, or is still at work; there may be jobs that nobody has begun; run it again with --resume"
            ));
        }
        let file = match File::open(&path) {
            Ok(file) => file,
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                if closed {
                    self.notes.push(format!("{what}: has written no report; run it again with --resume"));
                }
                return Ok(());
            }
            Err(source) => return Err(BatchError::Input { path, source }),
        };
        // A report of another version, or of something else, is replaced without being read.
        let Ok(Written { totals }) = serde_json::from_reader(BufReader::new(file)) else { return Ok(()) };
        let all = &mut self.totals;
        all.left += totals.left;
        all.retries += totals.retries;
        all.workers_lost += totals.workers_lost;
        all.seconds = all.seconds.max(totals.seconds);
        all.peak_bytes = all.peak_bytes.max(totals.peak_bytes);
        if totals.left > 0 {
            let why = totals.stopped.unwrap_or_else(|| "it was stopped".to_owned());
            self.notes.push(format!(
                "{what}: {} not reached ({why}); run it again with --resume",
                super::count(totals.left, "job", "jobs")
            ));
        }
        Ok(())
    }

    /// Shards that are missing. Several batches may be cut into as many parts each.
    fn miss(&mut self, shards: &BTreeMap<(u32, u32), usize>) {
        let mut batches: BTreeMap<u32, usize> = BTreeMap::new();
        for ((count, _), times) in shards {
            let all = batches.entry(*count).or_default();
            *all = (*all).max(*times);
        }
        for (count, times) in batches {
            let missing = |index: &u32| shards.get(&(count, *index)).is_none_or(|t| *t < times);
            let indices: Vec<u32> = (1..=count).filter(missing).collect();
            if indices.is_empty() {
                continue;
            }
            let list: Vec<String> = indices.iter().take(50).map(u32::to_string).collect();
            let more = if indices.len() > 50 { ", …" } else { "" };
            self.notes.push(format!(
                "{} of {count} missing: {}{more}",
                super::count(indices.len(), "shard", "shards"),
                list.join(", ")
            ));
            self.missing.extend(indices.into_iter().map(|index| Shard { index, count }));
        }
    }

    fn conclude(&mut self) {
        self.unfinished.sort();
        self.unfinished.dedup();
        if !self.unfinished.is_empty() {
            let list: Vec<String> = self.unfinished.iter().take(20).map(|name| super::plain(name)).collect();
            let more = if self.unfinished.len() > 20 { ", …" } else { "" };
            let what = super::count(
                self.unfinished.len(),
                "job was begun and never ended",
                "jobs were begun and never ended",
            );
            self.notes.push(format!("{what}: {}{more}", list.join(", ")));
        }
        self.totals.left = self.totals.left.max(self.unfinished.len());
        if !self.notes.is_empty() {
            self.totals.stopped = Some("not all shards have come to their end".to_owned());
        }
    }
}
