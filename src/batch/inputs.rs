//! Files, folders and patterns, as typed, to models and manifests.

use super::BatchError;
use glob::MatchOptions;
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Extensions of models, as [`crate::mesh::load()`] reads them.
pub const MODELS: [&str; 1] = ["stl"];
/// Extensions of manifests.
const MANIFESTS: [&str; 3] = ["jsonl", "ndjson", "csv"];
/// The input that means a manifest on standard input.
pub const STDIN: &str = "-";

/// Something to work on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// A model.
    Model(PathBuf),
    /// A list of jobs; [`STDIN`] for standard input.
    Manifest(PathBuf),
}

/// What the inputs name, in their order; what folders and patterns bring is sorted by name. A model that
/// several inputs name comes once.
///
/// Folders are searched to the bottom for models; hidden files and folders are left out, and so is `output`
/// where it lies in another input. A pattern brings what the shell would make of it, but of files only models
/// and those whose extension it spells out. An input that is there is never taken for a pattern.
///
/// # Errors
/// [`BatchError::Input`] where an input is not there or cannot be read, [`BatchError::Glob`] for a wrong
/// pattern, [`BatchError::NoModels`] for one that matches nothing.
pub fn find(inputs: &[String], output: &Path) -> Result<Vec<Found>, BatchError> {
    let mut search = Search { output: fs::canonicalize(output).ok(), ..Search::default() };
    for input in inputs {
        let path = Path::new(input);
        if input == STDIN {
            search.found.push(Found::Manifest(path.to_owned()));
        } else if fs::symlink_metadata(path).is_ok() || !has_pattern(input) {
            search.named(path)?;
        } else {
            search.pattern(input)?;
        }
    }
    Ok(search.found)
}

#[derive(Default)]
struct Search {
    /// The output folder as the system names it.
    output: Option<PathBuf>,
    found: Vec<Found>,
    /// Folders and files seen, as the system names them: overlaps, and links that lead back.
    folders: BTreeSet<PathBuf>,
    files: BTreeSet<PathBuf>,
}

impl Search {
    /// A file or folder that was named.
    fn named(&mut self, path: &Path) -> Result<(), BatchError> {
        let kind = fs::metadata(path).map_err(|e| unreadable(path, e))?;
        if kind.is_dir() {
            return self.folder(path);
        }
        if has_extension(path, &MANIFESTS) {
            self.found.push(Found::Manifest(path.to_owned()));
        } else {
            // What is no model after all fails as a job, with a message of its own.
            self.file(path)?;
        }
        Ok(())
    }

    fn file(&mut self, path: &Path) -> Result<(), BatchError> {
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = fs::canonicalize(folder).map_err(|e| unreadable(path, e))?;
        self.model(path.to_owned(), &folder);
        Ok(())
    }

    /// All models of a folder and of those in it.
    fn folder(&mut self, path: &Path) -> Result<(), BatchError> {
        let real = fs::canonicalize(path).map_err(|e| unreadable(path, e))?;
        // A stack of our own, as folders may be nested deeper than ours reaches; the next one is its last.
        let mut open = vec![(path.to_owned(), real, true)];
        while let Some((path, real, is_folder)) = open.pop() {
            if !is_folder {
                self.model(path, &real);
                continue;
            }
            if !self.folders.insert(real.clone()) {
                continue;
            }
            let mut entries = Vec::new();
            for entry in fs::read_dir(&path).map_err(|e| unreadable(&path, e))? {
                let entry = entry.map_err(|e| unreadable(&path, e))?;
                let name = entry.file_name();
                if name.as_encoded_bytes().starts_with(b".") {
                    continue;
                }
                let inner = path.join(&name);
                let kind = entry.file_type().map_err(|e| unreadable(&inner, e))?;
                // A link is what it leads to; one that leads nowhere may still have a model's name.
                let is_folder =
                    kind.is_dir() || (kind.is_symlink() && fs::metadata(&inner).is_ok_and(|m| m.is_dir()));
                if is_folder || has_extension(&inner, &MODELS) {
                    entries.push((name, inner, is_folder));
                }
            }
            entries.sort_unstable_by(|a, b| a.0.cmp(&b.0));
            for (_, inner, is_folder) in entries.into_iter().rev() {
                if !is_folder {
                    open.push((inner, real.clone(), false));
                    continue;
                }
                let real = fs::canonicalize(&inner).map_err(|e| unreadable(&inner, e))?;
                if self.output.as_ref() != Some(&real) {
                    open.push((inner, real, true));
                }
            }
        }
        Ok(())
    }

    fn pattern(&mut self, pattern: &str) -> Result<(), BatchError> {
        let options = MatchOptions {
            case_sensitive: true,
            require_literal_separator: true,
            require_literal_leading_dot: true,
        };
        let paths = glob::glob_with(pattern, options).map_err(|e| BatchError::Glob {
            pattern: pattern.to_owned(),
            problem: format!("{} (at character {})", e.msg, e.pos + 1),
        })?;
        let spelled = Path::new(pattern).extension().filter(|e| !has_pattern(&e.to_string_lossy()));
        let mut any = false;
        for path in paths {
            let path = path.map_err(|e| {
                let path = e.path().to_owned();
                unreadable(&path, e.into())
            })?;
            let is_spelled = spelled.is_some() && path.extension() == spelled;
            let is_model = has_extension(&path, &MODELS);
            if is_model && !path.exists() {
                // A link that leads nowhere; its job says so.
                self.file(&path)?;
            } else if is_model || is_spelled || path.is_dir() {
                self.named(&path)?;
            } else {
                continue;
            }
            any = true;
        }
        if any { Ok(()) } else { Err(BatchError::NoModels { input: pattern.to_owned() }) }
    }

    /// `folder`: where it lies, as the system names it.
    fn model(&mut self, path: PathBuf, folder: &Path) {
        let real = folder.join(path.file_name().unwrap_or_default());
        if self.files.insert(real) {
            self.found.push(Found::Model(path));
        }
    }
}

fn has_pattern(text: &str) -> bool {
    text.contains(['*', '?', '['])
}

fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let own = path.extension().and_then(OsStr::to_str);
    own.is_some_and(|own| extensions.iter().any(|e| own.eq_ignore_ascii_case(e)))
}

fn unreadable(path: &Path, source: io::Error) -> BatchError {
    BatchError::Input { path: path.to_owned(), source }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// A folder with empty files of these names.
    fn tree(names: &[&str]) -> tempfile::TempDir {
        let dir = tempfile::tempdir().unwrap();
        for name in names {
            let path = dir.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "").unwrap();
        }
        dir
    }

    /// What inputs in a folder bring, `*` before manifests, relative to it.
    fn found(dir: &Path, inputs: &[&str], output: &str) -> Result<Vec<String>, BatchError> {
        let typed = |i: &&str| if *i == STDIN { (*i).to_owned() } else { format!("{}/{i}", dir.display()) };
        let inputs: Vec<String> = inputs.iter().map(typed).collect();
        let short = |p: PathBuf| p.strip_prefix(dir).unwrap_or(&p).to_str().unwrap().to_owned();
        let name = |f| match f {
            Found::Model(p) => short(p),
            Found::Manifest(p) => format!("*{}", short(p)),
        };
        Ok(find(&inputs, &dir.join(output))?.into_iter().map(name).collect())
    }

    #[test]
    fn folders_are_searched_in_order() {
        let dir = tree(&[
            "in/b.stl",
            "in/a/z.STL",
            "in/a/.hidden.stl",
            "in/.git/x.stl",
            "in/c.txt",
            "in/B.stl",
            "in/out/made.stl",
            "in/jobs.csv",
        ]);
        let names = found(dir.path(), &["in"], "in/out").unwrap();
        assert_eq!(names, ["in/B.stl", "in/a/z.STL", "in/b.stl"], "manifests are only taken by name");
        let all = found(dir.path(), &["in"], "elsewhere").unwrap();
        assert_eq!(all, ["in/B.stl", "in/a/z.STL", "in/b.stl", "in/out/made.stl"]);
        assert_eq!(
            found(dir.path(), &["in/out"], "in/out").unwrap(),
            ["in/out/made.stl"],
            "asked for by name"
        );
        assert!(found(dir.path(), &["in/.git"], "o").unwrap().len() == 1);
    }

    #[test]
    fn overlaps_come_once() {
        let dir = tree(&["in/a.stl", "in/b.stl"]);
        let names = found(dir.path(), &["in/b.stl", "in/../in", "in/*.stl", "in/b.stl"], "out").unwrap();
        assert_eq!(names, ["in/b.stl", "in/../in/a.stl"]);
    }

    #[test]
    #[cfg(unix)]
    fn links_that_lead_back_do_no_harm() {
        use std::os::unix::fs::symlink;
        let dir = tree(&["in/deep/a.stl"]);
        symlink("..", dir.path().join("in/deep/up")).unwrap();
        symlink("nowhere", dir.path().join("in/lost.stl")).unwrap();
        symlink("deep/a.stl", dir.path().join("in/link.stl")).unwrap();
        let names = found(dir.path(), &["in"], "out").unwrap();
        assert_eq!(names, ["in/deep/a.stl", "in/link.stl", "in/lost.stl"]);
        let names = found(dir.path(), &["in/**/*.stl"], "out").unwrap();
        assert_eq!(names.len(), 3, "{names:?}");
    }

    #[test]
    fn patterns_take_models_and_what_they_spell_out() {
        let dir = tree(&[
            "p/a.stl",
            "p/q/b.stl",
            "p/c.obj",
            "p/d.csv",
            "p/noext",
            "p/.e.stl",
            "w[1].stl",
            "w1.stl",
        ]);
        let of = |pattern: &str| found(dir.path(), &[pattern], "out");
        assert_eq!(of("p/*").unwrap(), ["p/a.stl", "p/q/b.stl"]);
        assert_eq!(of("p/**/*.stl").unwrap(), ["p/a.stl", "p/q/b.stl"]);
        assert_eq!(of("p/*.obj").unwrap(), ["p/c.obj"]);
        assert_eq!(of("p/*.c?v").map(|v| v.len()).map_err(|e| e.exit_code()), Err(3));
        assert_eq!(of("p/*.csv").unwrap(), ["*p/d.csv"]);
        // What is there is meant as it stands.
        assert_eq!(of("w[1].stl").unwrap(), ["w[1].stl"]);
        assert_eq!(of("w[1-9].stl").unwrap(), ["w1.stl"]);
        assert!(matches!(of("none/*.stl"), Err(BatchError::NoModels { .. })));
        assert!(matches!(of("p/[.stl"), Err(BatchError::Glob { .. })));
        let missing = of("p/none.stl").unwrap_err();
        assert!(missing.to_string().contains("none.stl: cannot read") && missing.exit_code() == 3);
    }

    #[test]
    fn manifests_are_told_by_their_names() {
        let dir = tree(&["a.CSV", "b.jsonl", "c.ndjson", "d.json"]);
        let names = found(dir.path(), &["a.CSV", "b.jsonl", "c.ndjson", "d.json", "-"], "out").unwrap();
        assert_eq!(names, ["*a.CSV", "*b.jsonl", "*c.ndjson", "d.json", "*-"]);
    }
}
