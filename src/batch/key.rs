//! What a job is, in one number: same key, same bytes.

use super::names;
use crate::job::FailureKind;
use crate::mesh::MeshError;
use crate::slicer::files::stat;
use crate::slicer::profiles::Profiles;
use crate::slicer::{Failure, Request, Technology};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Counts up when the text that is hashed changes its form.
const FORM: u32 = 1;
/// Bytes read at a time.
const BLOCK: usize = 1 << 18;
/// Hashes of files that many jobs share, enforcers and blockers, are kept up to this number.
const KEPT: usize = 4096;

/// SHA-256 over the model's content, the settings as resolved, what else decides the output, and the version
/// of the program; hexadecimal.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct Key(pub String);

/// SHA-256 of a file, hexadecimal, with its size \[bytes\] and time of modification \[ns since 1970\].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Content {
    /// The hash.
    pub sha256: String,
    /// Size and time of modification, as in [`Request::expect`].
    pub stat: [i64; 2],
}

/// Resolves settings and hashes; keeps what was resolved, as many jobs share it.
#[derive(Debug, Default)]
pub struct Keys {
    profiles: Profiles,
    /// Files that belong to several jobs.
    shared: Mutex<BTreeMap<PathBuf, Content>>,
    /// The model of the job before, as a manifest may name it many times in a row.
    last: Mutex<Option<(PathBuf, Content)>>,
}

impl Keys {
    /// The content of a request's model and the key of the job.
    ///
    /// # Errors
    /// [`Failure`] when a file cannot be read or a setting is wrong; settings are looked at first.
    pub fn of(&self, request: &Request) -> Result<(Content, Key), Failure> {
        let settings = self.profiles.resolve(request)?.settings;
        let content = self.content(&request.model)?;
        let mut text = String::with_capacity(16 << 10);
        // Debug output escapes line ends, so that no value can look like another line.
        let mut put = |name: &str, value: &str| {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "{name} {value:?}");
        };
        let technology = match request.technology {
            Technology::Filament => "filament",
            Technology::Resin => "resin",
        };
        let number = |value: Option<f64>| value.map_or(String::new(), |v| v.to_string());
        let output = request.output.as_ref().map(|o| o.to_string_lossy());
        put("form", &FORM.to_string());
        put("version", env!("CARGO_PKG_VERSION"));
        put("technology", technology);
        put("model", &content.sha256);
        put("stem", &request.model.file_stem().unwrap_or_default().to_string_lossy());
        put("extension", &output.and_then(|o| names::extension(&o)).unwrap_or_default());
        put("estimate", &request.estimate.to_string());
        put("date", &request.date.to_string());
        put("copies", &request.copies.max(1).to_string());
        put("orient", &request.orient);
        put("match_tolerance", &number(request.match_tolerance));
        put("snap_grid", &number(request.snap_grid));
        put("no_place", &request.no_place.to_string());
        match request.technology {
            Technology::Filament => {
                for (name, paths) in
                    [("enforcer", &request.support_enforcers), ("blocker", &request.support_blockers)]
                {
                    for path in paths {
                        put(name, &self.shared(path)?.sha256);
                    }
                }
            }
            Technology::Resin => {
                put("rotate", &request.rotate.to_string());
                put("check", &request.check.to_string());
            }
        }
        for (key, value) in settings.entries() {
            put(key, &value);
        }
        Ok((content, Key(sha256(text.as_bytes()))))
    }

    /// The content of a model alone, which tells its shard. [`Self::of`] for the same model reads it not again.
    ///
    /// # Errors
    /// [`Failure`] when the file cannot be read.
    pub fn content(&self, path: &Path) -> Result<Content, Failure> {
        let current = stat(path).ok();
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some((known, content)) if known == path && Some(content.stat) == current => Ok(content.clone()),
            _ => {
                *last = None;
                // The lock is held meanwhile: the disk serves one reader best.
                let content = content(path)?;
                *last = Some((path.to_owned(), content.clone()));
                Ok(content)
            }
        }
    }

    fn shared(&self, path: &Path) -> Result<Content, Failure> {
        let current = stat(path).ok();
        let mut shared = self.shared.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = shared.get(path).filter(|known| Some(known.stat) == current) {
            return Ok(known.clone());
        }
        let content = content(path)?;
        if shared.len() >= KEPT {
            shared.clear();
        }
        shared.insert(path.to_owned(), content.clone());
        Ok(content)
    }
}

/// SHA-256, hexadecimal.
pub fn sha256(bytes: &[u8]) -> String {
    hex(Sha256::new_with_prefix(bytes))
}

fn hex(hasher: Sha256) -> String {
    hasher.finalize().iter().fold(String::with_capacity(64), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}

/// Hashes a file. It is read in blocks and not mapped: a file that somebody shortens meanwhile would end the
/// process that runs the whole batch.
///
/// # Errors
/// As slicing would give for a file that cannot be read; one that changes while it is read may pass next time.
pub fn content(path: &Path) -> Result<Content, Failure> {
    let wrong = |e: MeshError| Failure::new(FailureKind::Model, e.to_string());
    let failed = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => wrong(MeshError::Missing { path: path.into() }),
        io::ErrorKind::PermissionDenied | io::ErrorKind::InvalidInput => {
            wrong(MeshError::Read { path: path.into(), source })
        }
        _ => Failure { transient: true, ..wrong(MeshError::Read { path: path.into(), source }) },
    };
    let meta = std::fs::metadata(path).map_err(failed)?;
    if meta.is_dir() {
        return Err(wrong(MeshError::Directory { path: path.into() }));
    }
    // To open a pipe would wait for its other end.
    if !meta.is_file() {
        return Err(wrong(MeshError::NotAFile { path: path.into() }));
    }
    let before = stat(path).map_err(failed)?;
    let mut file = File::open(path).map_err(failed)?;
    let mut hasher = Sha256::new();
    let mut block = vec![0; BLOCK];
    loop {
        match file.read(&mut block) {
            Ok(0) => break,
            Ok(count) => hasher.update(block.get(..count).unwrap_or_default()),
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(failed(e)),
        }
    }
    if stat(path).map_err(failed)? != before {
        let message = format!("{}: changed while it was read; is it still being written?", path.display());
        return Err(Failure { transient: true, ..Failure::new(FailureKind::Model, message) });
    }
    Ok(Content { sha256: hex(hasher), stat: before })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn request(dir: &Path) -> Request {
        Request { model: dir.join("a.stl"), output: Some(dir.join("out/a.gcode")), ..Request::default() }
    }

    fn folder() -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        for (name, text) in
            [("a.stl", "abc"), ("b.stl", "abd"), ("c.stl", "abc"), ("p.ini", "perimeters = 4\n")]
        {
            std::fs::write(dir.path().join(name), text).unwrap();
        }
        dir
    }

    #[test]
    fn files_are_hashed() {
        let dir = folder();
        let found = content(&dir.path().join("a.stl")).unwrap();
        // FIPS 180-2, B.1.
        assert_eq!(found.sha256, "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        assert_eq!(found.stat[0], 3);
        assert_eq!(sha256(b"abc"), found.sha256);
        let large = vec![7; 3 * BLOCK + 11];
        std::fs::write(dir.path().join("large"), &large).unwrap();
        assert_eq!(content(&dir.path().join("large")).unwrap().sha256, sha256(&large));
    }

    #[test]
    fn what_decides_the_bytes_decides_the_key() {
        let dir = folder();
        let at = |name: &str| dir.path().join(name);
        let keys = Keys::default();
        let of = |request: &Request| keys.of(request).unwrap().1;
        let base = request(dir.path());
        let own = of(&base);
        assert_eq!(own.0.len(), 64);
        let set = |key: &str, value: &str| BTreeMap::from([(key.to_owned(), value.to_owned())]);
        let others = [
            Request { model: at("b.stl"), ..base.clone() },
            // The name goes into templates.
            Request { model: at("c.stl"), ..base.clone() },
            Request { output: Some(at("a.gco")), ..base.clone() },
            Request { settings: set("perimeters", "4"), ..base.clone() },
            Request { settings: set("start_gcode", "G28"), ..base.clone() },
            Request { copies: 2, ..base.clone() },
            Request { orient: "repair".to_owned(), ..base.clone() },
            Request { match_tolerance: Some(0.1), ..base.clone() },
            Request { snap_grid: Some(0.1), ..base.clone() },
            Request { no_place: true, ..base.clone() },
            Request { support_enforcers: vec![at("c.stl")], ..base.clone() },
            Request { support_blockers: vec![at("c.stl")], ..base.clone() },
            Request { support_blockers: vec![at("b.stl")], ..base.clone() },
            Request { estimate: true, output: None, ..base.clone() },
            Request { date: 1, ..base.clone() },
        ];
        let mut all: Vec<Key> = others.iter().map(of).chain([own.clone()]).collect();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), others.len() + 1, "each differs from each");
        // A file of settings, or the same by key.
        assert_eq!(of(&Request { load: vec![at("p.ini")], ..base.clone() }), of(&others[3]));
        let same = [
            Request { threads: Some(3), expect: Some([1, 2]), picture: Some(at("x.png")), ..base.clone() },
            Request { output: Some(at("elsewhere/b.gcode")), ..base.clone() },
            // Nothing but the defaults, and what only the other technology has.
            Request { settings: set("perimeters", "3"), rotate: 5.0, check: true, ..base.clone() },
        ];
        for request in &same {
            assert_eq!(of(request), own, "{request:?}");
        }
        let resin = Request { technology: Technology::Resin, printer: Some("prusa-sl1s".to_owned()), ..base };
        let turned = Request { rotate: 5.0, ..resin.clone() };
        assert!(of(&resin) != own && of(&turned) != of(&resin));
    }

    #[test]
    fn changed_files_are_read_again() {
        let dir = folder();
        let keys = Keys::default();
        let request = Request {
            support_blockers: vec![dir.path().join("b.stl")],
            load: vec![dir.path().join("p.ini")],
            ..request(dir.path())
        };
        let mut seen = vec![keys.of(&request).unwrap().1];
        for (name, text) in [("a.stl", "abcd"), ("b.stl", "abcd"), ("p.ini", "perimeters = 5\nskirts = 2\n")]
        {
            std::fs::write(dir.path().join(name), text).unwrap();
            let key = keys.of(&request).unwrap().1;
            assert!(!seen.contains(&key), "{name}");
            seen.push(key);
        }
        assert_eq!(keys.of(&request).unwrap().1, seen[3]);
    }

    #[test]
    fn failures_say_what_they_are_about() {
        let dir = folder();
        let keys = Keys::default();
        let of = |request: Request| keys.of(&request).unwrap_err();
        let missing = of(Request { model: dir.path().join("none.stl"), ..request(dir.path()) });
        assert_eq!((missing.kind, missing.transient), (FailureKind::Model, false));
        assert!(missing.message.ends_with("none.stl: no such file; check the path"), "{missing:?}");
        let folder = of(Request { model: dir.path().to_owned(), ..request(dir.path()) });
        assert!(folder.message.contains("is a directory"), "{folder:?}");
        let wrong = BTreeMap::from([("perimeter".to_owned(), "1".to_owned())]);
        let wrong = of(Request { settings: wrong, ..request(dir.path()) });
        assert_eq!(wrong.kind, FailureKind::Settings);
        assert!(wrong.message.contains("did you mean perimeters?"), "{wrong:?}");
        let blocker = of(Request { support_blockers: vec!["none.stl".into()], ..request(dir.path()) });
        assert_eq!(blocker.kind, FailureKind::Model);
    }
}
