//! House rules that the compiler does not check: floors, file lengths, licences, no second copy of a
//! heavy dependency.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// No source file is longer than this.
const LONGEST: usize = 600;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![root().join(folder)];
    while let Some(dir) = open.pop() {
        for entry in fs::read_dir(&dir).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == extension) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The modules of `src/lib.rs`, from the cellar up.
fn floors() -> Vec<String> {
    let lib = fs::read_to_string(root().join("src/lib.rs")).unwrap();
    lib.lines().filter_map(|l| Some(l.strip_prefix("pub mod ")?.strip_suffix(';')?.to_owned())).collect()
}

/// `(file, module used)` for every use of a module that does not lie below the file's own.
fn upward_uses(floors: &[String], sources: &[(String, String)]) -> Vec<(String, String)> {
    let height: BTreeMap<&str, usize> = floors.iter().enumerate().map(|(i, f)| (f.as_str(), i)).collect();
    let mut wrong = Vec::new();
    for (file, text) in sources {
        let own = file.trim_start_matches("src/").split(['/', '.']).next().unwrap();
        let Some(&own_height) = height.get(own) else { continue };
        for part in text.split("crate::").skip(1) {
            let used: String = part.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            if height.get(used.as_str()).is_some_and(|h| *h > own_height) {
                wrong.push((file.clone(), used));
            }
        }
    }
    wrong
}

#[test]
fn modules_use_only_floors_below_them() {
    let floors = floors();
    assert!(floors.len() > 10, "{floors:?}");
    let sources: Vec<(String, String)> = files("src", "rs")
        .into_iter()
        .map(|p| (p.strip_prefix(root()).unwrap().display().to_string(), fs::read_to_string(p).unwrap()))
        .collect();
    assert_eq!(
        upward_uses(&floors, &sources),
        vec![],
        "each module uses only those listed before it in lib.rs"
    );

    let planted = [("src/mesh/stl.rs".to_owned(), "use crate::gcode::writer;".to_owned())];
    assert_eq!(upward_uses(&floors, &planted).len(), 1, "the check sees a planted upward use");
}

#[test]
fn files_stay_readable() {
    for (folder, extension) in [("src", "rs"), ("tests", "rs"), ("shaders", "wgsl")] {
        for path in files(folder, extension) {
            let lines = fs::read_to_string(&path).unwrap().lines().count();
            assert!(lines <= LONGEST, "{} has {lines} lines; split it (at most {LONGEST})", path.display());
        }
    }
}

/// True when an SPDX expression can be met by allowed licences alone.
fn met(expression: &str, allowed: &BTreeSet<String>) -> bool {
    let plain = expression.replace(['(', ')'], "").replace('/', " OR ");
    plain.split(" AND ").all(|all| all.split(" OR ").any(|one| allowed.contains(one.trim())))
}

#[test]
fn dependencies_are_permissive_and_heavy_ones_come_once() {
    let deny: toml::Table = fs::read_to_string(root().join("deny.toml")).unwrap().parse().unwrap();
    let allowed: BTreeSet<String> = deny["licenses"]["allow"]
        .as_array()
        .unwrap()
        .iter()
        .map(|l| l.as_str().unwrap().to_owned())
        .collect();
    let single: BTreeSet<&str> =
        deny["bans"]["deny"].as_array().unwrap().iter().map(|d| d["crate"].as_str().unwrap()).collect();

    let output = std::process::Command::new(env!("CARGO"))
        .args(["metadata", "--format-version", "1", "--locked", "--offline", "--all-features"])
        .current_dir(root())
        .output()
        .unwrap();
    // The packages of other platforms may not be on this machine; then there is nothing to read offline.
    let text = if output.status.success() {
        output.stdout
    } else {
        let again = std::process::Command::new(env!("CARGO"))
            .args(["metadata", "--format-version", "1", "--locked", "--all-features"])
            .current_dir(root())
            .output()
            .unwrap();
        assert!(again.status.success(), "{}", String::from_utf8_lossy(&again.stderr));
        again.stdout
    };
    let metadata: serde_json::Value = serde_json::from_slice(&text).unwrap();
    let packages = metadata["packages"].as_array().unwrap();
    assert!(packages.len() > 50);
    let mut versions: BTreeMap<&str, u32> = BTreeMap::new();
    for package in packages {
        let name = package["name"].as_str().unwrap();
        let license = package["license"].as_str().unwrap_or("none");
        assert!(met(license, &allowed), "{name} is under {license}, which deny.toml does not allow");
        *versions.entry(name).or_default() += 1;
    }
    for name in single {
        assert!(versions.get(name).is_none_or(|n| *n == 1), "{name} comes in several versions");
    }
    assert!(!met("GPL-3.0-only", &allowed) && !met("MIT AND AGPL-3.0", &allowed), "the check sees copyleft");
    assert!(met("MIT/Apache-2.0", &allowed) && met("GPL-2.0 OR MIT", &allowed));
}
