//! The program as its users run it.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod bad_input;
mod batch_inputs;
mod batch_resume;
mod batch_report;
mod batch_run;
mod golden;
mod contours;
mod copies;
mod estimate;
mod below;
mod faults;
mod inspect;
mod mask;
mod output;
mod printers;
mod same_bytes;
mod settings;
mod supports;
mod worker;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A folder with models made by the crate itself, and a way to run the program in it.
struct Bench {
    dir: tempfile::TempDir,
}

impl Bench {
    fn new() -> Self {
        Self { dir: tempfile::tempdir().unwrap() }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    /// Writes a mesh as binary STL.
    fn stl(&self, name: &str, mesh: &microtome::mesh::Mesh) -> PathBuf {
        let mut bytes = Vec::new();
        microtome::mesh::stl_write::write_stl_binary(mesh, &mut bytes).unwrap();
        self.write(name, bytes)
    }

    fn run<S: AsRef<std::ffi::OsStr>>(&self, args: impl IntoIterator<Item = S>) -> Output {
        Command::new(env!("CARGO_BIN_EXE_microtome"))
            .args(args)
            .current_dir(self.dir.path())
            .env_remove("SOURCE_DATE_EPOCH")
            .output()
            .unwrap()
    }

    /// Runs `slice MODEL -o out.gcode` with more arguments and returns the file.
    fn slice(&self, model: &Path, more: &[&str]) -> Vec<u8> {
        let out = self.path("out.gcode");
        let mut args = vec!["slice", model.to_str().unwrap(), "-o", out.to_str().unwrap()];
        args.extend(more);
        let done = self.run(&args);
        assert!(done.status.success(), "{args:?}\n{}", stderr(&done));
        std::fs::read(out).unwrap()
    }

    /// Names of all files in the folder.
    fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.dir.path())
            .unwrap()
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}
