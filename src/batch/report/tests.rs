#![allow(clippy::unwrap_used)]

use super::*;
use crate::batch::event::Status;
use crate::job::FailureKind;
use crate::slicer::{Failure, Material, Outcome, Request, Technology};
use std::collections::BTreeMap;
use std::fs::read_to_string;

fn done(name: &str) -> Row {
    let material = Material { mm: 1000.5, cm3: 2.4, g: Some(3.0), cost: None, mm_by_role: BTreeMap::new() };
    let outcome = Outcome {
        bytes: 10,
        layers: 7,
        print_z_mm: 1.4,
        triangles: 12,
        material,
        time_lower_bound_s: 90.0,
        warnings: vec!["thin <wall>, \"here\"".into(), "second".into()],
        backend: "cpu".into(),
        seconds: 0.25,
        cpu_seconds: 0.2,
        peak_bytes: 1 << 20,
        ..Outcome::default()
    };
    Row {
        name: name.to_owned(),
        model: format!("/models/{name}.stl"),
        status: Status::Done,
        key: crate::batch::Key("k".into()),
        sha256: "s".into(),
        copies: 1,
        attempts: 1,
        outcome: Some(outcome),
        failure: None,
        request: Request { model: format!("/models/{name}.stl").into(), ..Request::default() },
    }
}

fn failed(name: &str, status: Status, message: &str) -> Row {
    let kind = if status == Status::Failed { FailureKind::Model } else { FailureKind::TimeLimit };
    let failure = Some(Failure::new(kind, message.to_owned()));
    Row { status, outcome: None, failure, attempts: 3, ..done(name) }
}

fn totals(rows: &[Row]) -> Totals {
    let count = |status| rows.iter().filter(|row| row.status == status).count();
    Totals {
        done: count(Status::Done),
        failed: count(Status::Failed),
        quarantined: count(Status::Quarantined),
        seconds: 30.0,
        ..Totals::default()
    }
}

/// Writes a report into a folder of its own.
fn written(rows: &[Row]) -> tempfile::TempDir {
    let dir = tempfile::tempdir().unwrap();
    write(dir.path(), Shard::default(), rows, &totals(rows)).unwrap();
    dir
}

const NASTY: &str = "<script>alert(\"1\")</script>' onload='x' &amp; \u{202e}\u{0}\n.gcode";

fn nasty() -> Vec<Row> {
    let mut odd = done(NASTY);
    odd.outcome.as_mut().unwrap().warnings.push(NASTY.into());
    vec![odd, failed("b", Status::Quarantined, NASTY), failed(NASTY, Status::Failed, "comma, \"quote\"")]
}

#[test]
fn the_table_reads_back() {
    let rows = nasty();
    let dir = written(&rows);
    let mut table = ::csv::Reader::from_path(dir.path().join("report.csv")).unwrap();
    let header = table.headers().unwrap().clone();
    let read: Vec<_> = table.records().map(Result::unwrap).collect();
    assert_eq!(read.len(), 3);
    let cell = |row: usize, name: &str| &read[row][header.iter().position(|h| h == name).unwrap()];
    assert_eq!(cell(0, "name"), NASTY);
    assert_eq!((cell(0, "filament_mm"), cell(0, "mass_g"), cell(0, "cost")), ("1000.5", "3", ""));
    assert_eq!((cell(0, "warnings"), cell(0, "first_warning")), ("3", "thin <wall>, \"here\""));
    assert_eq!(
        (cell(1, "status"), cell(1, "error_kind"), cell(1, "error")),
        ("quarantined", "time_limit", NASTY)
    );
    assert_eq!((cell(2, "layers"), cell(2, "error")), ("", "comma, \"quote\""));
}

#[test]
fn json_has_sums_and_all_rows() {
    let rows = nasty();
    let dir = written(&rows);
    let text = read_to_string(dir.path().join("report.json")).unwrap();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["sums"]["jobs"], 3);
    assert_eq!((&value["sums"]["filament_mm"], &value["sums"]["cost"]), (&1000.5.into(), &().into()));
    assert_eq!(value["totals"]["seconds"], 30.0);
    let read: Vec<Row> = serde_json::from_value(value["jobs"].clone()).unwrap();
    assert_eq!(read, rows);
    assert_eq!(text.lines().filter(|line| line.contains("\"sha256\"")).count(), 3, "a job a line");

    let empty = written(&[]);
    let text = read_to_string(empty.path().join("report.json")).unwrap();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["jobs"], serde_json::json!([]));
}

/// Tags of a page by name. Fails where one is closed that is not open, and where a name holds what none does.
fn tags(page: &str) -> Result<BTreeMap<String, usize>, String> {
    let (mut open, mut count) = (Vec::new(), BTreeMap::new());
    let mut rest = page;
    while let Some(at) = rest.find('<') {
        let end = rest[at..].find('>').ok_or("an open tag")? + at;
        let tag = &rest[at + 1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            let last = open.pop();
            if last != Some(name) {
                return Err(format!("</{name}> closes {last:?}"));
            }
            continue;
        }
        let name = tag.split([' ', '\n']).next().unwrap_or_default();
        if !tag.matches('"').count().is_multiple_of(2) {
            return Err(format!("quotes of {tag}"));
        }
        *count.entry(name.to_owned()).or_default() += 1;
        if !["!DOCTYPE", "meta", "img", "input"].contains(&name) {
            open.push(name);
        }
        // What these hold is no HTML.
        if ["script", "style"].contains(&name) {
            rest = &rest[rest.find(&format!("</{name}>")).ok_or("no end")?..];
        }
    }
    if open.is_empty() { Ok(count) } else { Err(format!("still open: {open:?}")) }
}

#[test]
fn the_page_is_whole_and_nothing_gets_out_of_its_place() {
    let dir = written(&nasty());
    let page = read_to_string(dir.path().join("report.html")).unwrap();
    let found = tags(&page).unwrap();
    assert_eq!(found["script"], 1, "that of the page");
    assert!(!page.contains("onload='"));
    assert!(!page.contains(['\u{0}', '\u{202e}']));
    assert!(page.contains("&lt;script&gt;alert(&quot;1&quot;)"));
    assert!(page.find("Not done").unwrap() < page.find("<table>").unwrap(), "failures come first");
    for outside in ["http:", "https:", "src=\"/", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    // The check sees what it is there for.
    assert_ne!(tags(&page.replace("&lt;script&gt;", "<script>")), Ok(found));
    assert!(tags(&page.replacen("</td>", "", 1)).is_err());
}

#[test]
fn a_large_batch_gives_a_page_that_opens() {
    let mut rows: Vec<Row> = (0..html::MOST_ROWS + 1).map(|i| done(&format!("{i:05}.gcode"))).collect();
    rows.extend((0..html::MOST_FAILURES + 2).map(|i| failed(&format!("f{i:05}"), Status::Failed, "no")));
    let dir = tempfile::tempdir().unwrap();
    let pictures = dir.path().join(".microtome/pictures");
    std::fs::create_dir_all(&pictures).unwrap();
    let png = [&b"\x89PNG\r\n\x1a\n"[..], &[0; 50_000]].concat();
    for row in &rows[..200] {
        std::fs::write(pictures.join(format!("{}.png", row.name)), &png).unwrap();
    }
    write(dir.path(), Shard::default(), &rows, &totals(&rows)).unwrap();
    let page = read_to_string(dir.path().join("report.html")).unwrap();
    let found = tags(&page).unwrap();
    assert_eq!(found["tr"], html::MOST_ROWS + 1);
    assert_eq!(found["img"], (html::MOST_PICTURES.1 / png.len() as u64) as usize);
    assert!(page.contains("href=\"./.microtome/pictures/00199.gcode.png\""));
    assert!(page.contains("the other 1 are in report.csv") && page.contains("the other 2 are in report.csv"));
    assert!(page.len() < 25 << 20, "{}", page.len());
    let table = read_to_string(dir.path().join("report.csv")).unwrap();
    assert_eq!(table.lines().count(), rows.len() + 1);
}

#[test]
fn the_same_rows_give_the_same_files() {
    let rows = nasty();
    let (one, two) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    for dir in [&one, &two] {
        write(dir.path(), Shard { index: 2, count: 3 }, &rows, &totals(&rows)).unwrap();
    }
    for name in ["report-2-of-3.csv", "quarantine-2-of-3.jsonl"] {
        let read = |dir: &tempfile::TempDir| read_to_string(dir.path().join(name)).unwrap();
        assert_eq!(read(&one), read(&two), "{name}");
    }
    // The page and the JSON name their folder.
    for name in ["report-2-of-3.json", "report-2-of-3.html"] {
        let read = |dir: &tempfile::TempDir| {
            read_to_string(dir.path().join(name)).unwrap().replace(dir.path().to_str().unwrap(), "DIR")
        };
        assert_eq!(read(&one), read(&two), "{name}");
    }
    assert_eq!(std::fs::read_dir(one.path()).unwrap().count(), 4, "nothing beside");
}

#[test]
fn what_failed_can_be_asked_for_again() {
    let mut rows = nasty();
    rows[1].request = Request {
        model: "a.stl".into(),
        technology: Technology::Resin,
        load: vec!["p.ini".into()],
        settings: [("layer_height".to_owned(), "0.1".to_owned())].into(),
        copies: 2,
        ..Request::default()
    };
    let dir = written(&rows);
    let path = dir.path().join("quarantine.jsonl");
    let text = read_to_string(&path).unwrap();
    let lines: Vec<serde_json::Value> = text.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let absolute = |name: &str| std::path::absolute(name).unwrap().to_str().unwrap().to_owned();
    assert_eq!(lines.len(), 2);
    assert_eq!(
        lines[0],
        serde_json::json!({
            "model": absolute("a.stl"), "output": "b", "technology": "resin", "profile": [absolute("p.ini")],
            "settings": {"layer_height": "0.1"}, "copies": 2
        })
    );
    write(dir.path(), Shard::default(), &rows[..1], &totals(&rows[..1])).unwrap();
    assert!(!path.exists(), "an old one does not stay");
}

#[cfg(unix)]
#[test]
fn paths_that_are_no_text_are_no_obstacle() {
    use std::os::unix::ffi::OsStrExt;
    let mut row = failed("a", Status::Failed, "no");
    row.request.model = std::ffi::OsStr::from_bytes(b"/m/\xff.stl").into();
    let dir = written(&[row]);
    for name in ["report.json", "quarantine.jsonl"] {
        assert!(read_to_string(dir.path().join(name)).unwrap().contains("/m/\u{fffd}.stl"), "{name}");
    }
}

#[test]
fn a_folder_that_is_not_there_is_named() {
    let error =
        write(Path::new("/no/such"), Shard::default(), &[], &Totals::default()).unwrap_err().to_string();
    assert!(error.contains("/no/such/report.json"), "{error}");
}

/// A folder with the journal of a shard, ended in order.
fn run(folder: &Path, shard: Shard, rows: &[Row]) {
    let (mut journal, _) = crate::batch::journal::Journal::open(folder, shard, true, false).unwrap();
    for row in rows {
        journal.started(&row.name, &row.key, 1).unwrap();
        journal.ended(row).unwrap();
    }
    let sums = Totals { retries: 1, seconds: 10.0 * f64::from(shard.index), ..totals(rows) };
    write(folder, shard, rows, &sums).unwrap();
}

#[test]
fn shards_of_one_folder_give_one_report() {
    let dir = tempfile::tempdir().unwrap();
    let (one, two) = (Shard { index: 1, count: 3 }, Shard { index: 3, count: 3 });
    run(dir.path(), one, &[done("b"), failed("c", Status::Failed, "no")]);
    run(dir.path(), two, &[done("a")]);
    let folders = [dir.path().to_owned()];
    let merged = merge(&folders, dir.path()).unwrap();
    assert_eq!(merged.missing, [Shard { index: 2, count: 3 }]);
    assert_eq!((merged.sums.done, merged.sums.failed, merged.totals.retries), (2, 1, 2));
    assert_eq!((merged.totals.seconds, merged.totals.exit_code()), (30.0, 9));
    assert!(merged.notes[0].contains("1 shard of 3 missing: 2"), "{:?}", merged.notes);

    run(dir.path(), Shard { index: 2, count: 3 }, &[]);
    let merged = merge(&folders, dir.path()).unwrap();
    assert_eq!((merged.notes.len(), merged.totals.exit_code()), (0, 7), "{:?}", merged.notes);
    let text = read_to_string(dir.path().join("report.json")).unwrap();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let names: Vec<&str> =
        value["jobs"].as_array().unwrap().iter().map(|j| j["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["a", "b", "c"]);
    // Once more, over its own report.
    assert_eq!(merge(&folders, dir.path()).unwrap(), merged);
}

#[test]
fn equal_names_of_two_folders_stay_apart() {
    let (one, two, out) =
        (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    run(one.path(), Shard::default(), &[done("a"), done("b")]);
    run(two.path(), Shard::default(), &[done("a")]);
    let pictures = one.path().join(".microtome/pictures");
    std::fs::create_dir_all(&pictures).unwrap();
    std::fs::write(pictures.join("a.png"), b"\x89PNG\r\n\x1a\n").unwrap();
    let folders = [one.path().to_owned(), two.path().to_owned()];
    let merged = merge(&folders, &out.path().join("new")).unwrap();
    assert_eq!((merged.sums.done, merged.totals.exit_code()), (3, 0), "{:?}", merged.notes);
    let table = read_to_string(out.path().join("new/report.csv")).unwrap();
    let names: Vec<&str> = table.lines().skip(1).map(|line| line.split(',').next().unwrap()).collect();
    let of = |dir: &tempfile::TempDir| dir.path().join("a").to_str().unwrap().to_owned();
    assert_eq!(names, [of(&one).as_str(), "b", of(&two).as_str()]);
    let page = read_to_string(out.path().join("new/report.html")).unwrap();
    assert_eq!(tags(&page).unwrap()["img"], 1, "the picture is found by the name in its folder");
}

#[test]
fn a_shard_that_was_killed_is_told() {
    let dir = tempfile::tempdir().unwrap();
    run(dir.path(), Shard::default(), &[done("a")]);
    let path = dir.path().join(".microtome/journal-1-of-1.jsonl");
    let whole = read_to_string(&path).unwrap();
    let folders = [dir.path().to_owned()];
    // As it stood while `a` was in hand.
    let end = whole.find("{\"ended\"").unwrap();
    std::fs::write(&path, &whole[..end]).unwrap();
    let merged = merge(&folders, dir.path()).unwrap();
    assert_eq!(merged.unfinished, ["a"]);
    assert_eq!((merged.sums.jobs, merged.totals.exit_code()), (0, 9));
    assert!(merged.notes.iter().any(|n| n.contains("died")), "{:?}", merged.notes);
    assert!(
        merged.notes.iter().any(|n| n.contains("1 job was begun and never ended: a")),
        "{:?}",
        merged.notes
    );

    std::fs::write(&path, &whole).unwrap();
    let rows = [done("a")];
    write(dir.path(), Shard::default(), &rows, &totals(&rows)).unwrap();
    assert_eq!(merge(&folders, dir.path()).unwrap().totals.exit_code(), 0);
    let error = merge(&[dir.path().join("no")], dir.path()).unwrap_err();
    assert_eq!(error.exit_code(), 3, "{error}");
}
