//! What killed processes have left of outputs that they were making.

use crate::batch::STATE_FOLDER;
use crate::job::output;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Unfinished files and folders by the output that they were to become.
#[derive(Debug, Default)]
pub(super) struct Leftovers {
    found: BTreeMap<PathBuf, Vec<PathBuf>>,
}

impl Leftovers {
    /// Looks around outputs of these names and their pictures, before any of them is made again.
    pub(super) fn find<'a>(folder: &Path, names: impl Iterator<Item = &'a str>) -> Self {
        let parents: BTreeSet<&Path> = names.filter_map(|name| Path::new(name).parent()).collect();
        let mut found: BTreeMap<PathBuf, Vec<PathBuf>> = BTreeMap::new();
        for base in [folder.to_owned(), pictures(folder)] {
            for parent in &parents {
                for (target, leftover) in output::leftovers(&base.join(parent)) {
                    found.entry(target).or_default().push(leftover);
                }
            }
        }
        Self { found }
    }

    /// Removes those of an output and its picture. To be called while nobody makes that output; others may be
    /// in the making.
    pub(super) fn remove(&mut self, folder: &Path, name: &str) {
        if self.found.is_empty() {
            return;
        }
        for target in [folder.join(name), pictures(folder).join(format!("{name}.png"))] {
            self.found.remove(&target).iter().flatten().for_each(|leftover| output::remove(leftover));
        }
    }
}

fn pictures(folder: &Path) -> PathBuf {
    folder.join(STATE_FOLDER).join("pictures")
}
