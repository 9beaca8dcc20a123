//! Reads and hashes models ahead of the workers, on a thread of its own.
//!
//! That also brings the next models into the system's cache of files, so that workers need not wait for the
//! disk.

use crate::batch::Item;
use crate::batch::event::Row;
use crate::batch::journal::Past;
use crate::batch::key::{Content, Key, Keys, sha256};
use crate::batch::options::BatchOptions;
use crate::job::FailureKind;
use crate::slicer::{Failure, Request};
use std::cmp::Reverse;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::mpsc::Receiver;
use std::thread;
use std::time::Duration;

/// What is known of a job before it is begun.
#[derive(Debug)]
pub(super) enum Known {
    /// It belongs to another shard.
    Elsewhere,
    /// An earlier run has settled it.
    Stands(Box<Row>),
    /// It cannot be begun.
    Refused(Failure),
    /// It was in hand too often when a supervisor died.
    Deadly {
        /// The job.
        identity: Identity,
        /// How often.
        deaths: u32,
    },
    /// It is to be done.
    Ready {
        /// The job.
        identity: Identity,
        /// How often it was in hand when a supervisor died.
        deaths: u32,
        /// Whether the model is a text.
        text: bool,
    },
}

/// What a job is.
#[derive(Debug)]
pub(super) struct Identity {
    /// Its key.
    pub key: Key,
    /// Its model's content.
    pub content: Content,
}

/// Pause before a file is read again that could not be read \[ms\].
const PAUSE_MS: u64 = 50;

/// Numbers of items, largest first, equals in their order.
pub(super) fn order(items: &[Item]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..items.len()).collect();
    order.sort_by_key(|&number| (Reverse(items.get(number).map_or(0, |item| item.size)), number));
    order
}

/// The request of an item as it is recorded: where its output goes, and whether there is one.
pub(super) fn request(item: &Item, options: &BatchOptions) -> Request {
    let output = (!options.estimate).then(|| options.folder.join(&item.name));
    Request { output, estimate: options.estimate, ..item.request.clone() }
}

/// Looks at one item after the other for each permit, until there are no more, or nobody listens.
pub(super) fn read_ahead(
    items: &[Item],
    options: &BatchOptions,
    past: &Past,
    permits: &Receiver<()>,
    mut post: impl FnMut(usize, Known) -> bool,
) {
    let keys = Keys::default();
    for number in order(items) {
        let Some(item) = items.get(number) else { continue };
        if permits.recv().is_err() || !post(number, known(item, &keys, options, past)) {
            return;
        }
    }
}

fn known(item: &Item, keys: &Keys, options: &BatchOptions, past: &Past) -> Known {
    let stated = item.sha256.as_deref();
    if stated.is_some_and(|stated| !options.shard.holds(stated)) {
        return Known::Elsewhere;
    }
    let request = request(item, options);
    let found = match &item.refused {
        Some(failure) => Err(failure.clone()),
        None => patiently(options.limits.retries, || keys.of(&request)),
    };
    let (content, key) = match found {
        Ok(found) => found,
        // What cannot be read has no hash; its name assigns it.
        Err(_) if stated.is_none() && !options.shard.holds(&sha256(item.name.as_bytes())) => {
            return Known::Elsewhere;
        }
        Err(failure) => return Known::Refused(failure),
    };
    if let Some(stated) = stated.filter(|stated| *stated != content.sha256) {
        return Known::Refused(Failure::new(
            FailureKind::Model,
            format!(
                "{}: its SHA-256 is {}, the manifest says {stated}; copy the model again or mend the manifest",
                request.model.display(),
                content.sha256
            ),
        ));
    }
    if !options.shard.holds(&content.sha256) {
        return Known::Elsewhere;
    }
    match past.standing(&item.name, &key, &options.folder) {
        Some(row) if row.outcome.is_some() || !options.retry_failed => {
            return Known::Stands(Box::new(row));
        }
        _ => {}
    }
    let deaths = past.died.get(&(item.name.clone(), key.clone())).copied();
    let deaths = deaths.filter(|_| !options.retry_failed).unwrap_or(0);
    let identity = Identity { key, content };
    if deaths > options.limits.retries {
        return Known::Deadly { identity, deaths };
    }
    Known::Ready { identity, deaths, text: is_text(&request.model, item.size) }
}

/// Tries again what may pass.
fn patiently<T>(retries: u32, mut what: impl FnMut() -> Result<T, Failure>) -> Result<T, Failure> {
    let mut tries = 0;
    loop {
        match what() {
            Err(failure) if failure.transient && tries < retries => tries += 1,
            result => return result,
        }
        thread::sleep(Duration::from_millis(PAUSE_MS));
    }
}

/// Whether a file of STL is not binary: its length is not what its number of facets asks for.
fn is_text(model: &Path, size: u64) -> bool {
    let mut head = [0; 84];
    let read = File::open(model).and_then(|mut file| file.read_exact(&mut head));
    let [.., a, b, c, d] = head;
    read.is_ok() && size != 84 + 50 * u64::from(u32::from_le_bytes([a, b, c, d]))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn large_models_come_first_and_equals_in_order() {
        let item = |size| Item {
            request: Request::default(),
            name: String::new(),
            size,
            place: None,
            refused: None,
            sha256: None,
        };
        assert_eq!(order(&[5, 9, 5, 0, 9].map(item)), [1, 4, 0, 2, 3]);
    }

    #[test]
    fn texts_are_told_from_binary_files() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.stl");
        let mut binary = vec![0; 84 + 100];
        binary[80] = 2;
        std::fs::write(&path, &binary).unwrap();
        assert!(!is_text(&path, 184));
        std::fs::write(&path, "solid a\n".repeat(20)).unwrap();
        assert!(is_text(&path, 160));
    }

    #[test]
    fn only_what_may_pass_is_tried_again() {
        let mut calls = 0;
        let wrong = Failure::new(FailureKind::Model, String::new());
        let found = patiently(5, || {
            calls += 1;
            Err::<(), _>(wrong.clone())
        });
        assert!(found.is_err() && calls == 1);
        let mut calls = 0;
        let found = patiently(5, || {
            calls += 1;
            if calls < 3 { Err(Failure { transient: true, ..wrong.clone() }) } else { Ok(calls) }
        });
        assert_eq!(found.unwrap(), 3);
    }
}
