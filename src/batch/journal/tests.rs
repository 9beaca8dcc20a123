#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::*;
use crate::batch::event::Status;
use crate::job::FailureKind;
use crate::slicer::{Failure, Outcome};
use crate::span::tests::Random;
use std::fs;
use tempfile::TempDir;

const ONE: Shard = Shard { index: 1, count: 1 };

fn key(text: &str) -> Key {
    Key(text.to_owned())
}

/// A row as a run would write it; done ones with their output in place.
fn row(folder: &Path, name: &str, key_text: &str, status: Status) -> Row {
    let content = format!("; {name} {key_text}\n");
    if status == Status::Done {
        fs::write(folder.join(name), &content).unwrap();
    }
    Row {
        name: name.to_owned(),
        model: format!("/models/{name}.stl"),
        status,
        key: key(key_text),
        sha256: "5e".repeat(32),
        copies: 1,
        attempts: 1,
        outcome: (status == Status::Done).then(|| Outcome {
            bytes: content.len() as u64,
            crc32: crc32fast::hash(content.as_bytes()),
            warnings: vec!["a line\nfeed".to_owned()],
            seconds: 0.1 + 0.2,
            ..Outcome::default()
        }),
        failure: (status != Status::Done).then(|| Failure::new(FailureKind::Model, "no facets".to_owned())),
        request: crate::slicer::Request::default(),
    }
}

fn open(folder: &Path) -> (Journal, Past) {
    Journal::open(folder, ONE, true, false).unwrap()
}

fn file(folder: &Path) -> PathBuf {
    folder.join(STATE_FOLDER).join("journal-1-of-1.jsonl")
}

/// As if the process were killed: nothing is written any more.
fn kill(journal: Journal) {
    let Journal { file, .. } = &journal;
    let file = file.try_clone().unwrap();
    let length = file.metadata().unwrap().len();
    drop(journal);
    file.set_len(length).unwrap();
}

/// A batch killed on the way: `a` done and on the disk, `b` failed, `c` done after the checkpoint, `d` in hand.
fn killed() -> TempDir {
    let dir = tempfile::tempdir().unwrap();
    let (mut journal, past) = open(dir.path());
    assert_eq!(past.names().count(), 0);
    for (name, status) in [("a", Status::Done), ("b", Status::Failed), ("c", Status::Done)] {
        journal.started(name, &key("1"), 1).unwrap();
        journal.ended(&row(dir.path(), name, "1", status)).unwrap();
        if name == "b" {
            journal.checkpoint().unwrap();
            journal.checkpoint().unwrap();
        }
    }
    journal.started("d", &key("1"), 1).unwrap();
    kill(journal);
    dir
}

#[test]
fn a_later_run_finds_what_was_done_and_what_was_in_hand() {
    let dir = killed();
    let text = fs::read_to_string(file(dir.path())).unwrap();
    assert_eq!(text.lines().count(), 1 + 6 + 1 + 1, "a checkpoint without news writes nothing:\n{text}");
    let (_journal, past) = open(dir.path());
    assert_eq!(past.names().collect::<Vec<_>>(), ["a", "b", "c"]);
    assert_eq!(
        past.row("a").unwrap(),
        row(dir.path(), "a", "1", Status::Done),
        "rows come back as they were"
    );
    assert_eq!(past.unsynced.iter().collect::<Vec<_>>(), ["c"]);
    assert_eq!(past.died.iter().collect::<Vec<_>>(), [(&("d".to_owned(), key("1")), &1)]);
    for name in ["a", "b", "c"] {
        assert!(past.standing(name, &key("1"), dir.path()).is_some(), "{name}");
        assert!(past.standing(name, &key("2"), dir.path()).is_none(), "{name}: another key is another job");
    }
    assert!(past.standing("d", &key("1"), dir.path()).is_none());
    let read: Vec<_> = read(dir.path()).unwrap().into_iter().map(|row| row.name).collect();
    assert_eq!(read, ["a", "b", "c"]);
    assert!(super::read(&dir.path().join("none")).is_err_and(|e| matches!(e, BatchError::Input { .. })));
}

#[test]
fn deaths_add_up_until_the_job_ends_and_orderly_ends_are_none() {
    let dir = killed();
    let job = ("d".to_owned(), key("1"));
    for times in 1..4 {
        let (mut journal, past) = open(dir.path());
        assert_eq!(past.died.get(&job), Some(&times));
        // Tries after the loss of a worker are one death, if the process dies in the last of them.
        journal.started("d", &key("1"), times).unwrap();
        journal.started("d", &key("1"), times + 1).unwrap();
        journal.started("e", &key("1"), 1).unwrap();
        if times == 1 {
            journal.ended(&row(dir.path(), "e", "1", Status::Done)).unwrap();
        }
        kill(journal);
    }
    let (mut journal, past) = open(dir.path());
    assert_eq!((past.died[&job], past.died[&("e".to_owned(), key("1"))]), (4, 2));
    journal.started("d", &key("1"), 9).unwrap();
    drop(journal);
    let (mut journal, past) = open(dir.path());
    assert_eq!(past.died[&job], 4, "what an orderly end gives up has not died");
    journal.ended(&row(dir.path(), "d", "1", Status::Quarantined)).unwrap();
    kill(journal);
    let (_journal, past) = open(dir.path());
    assert_eq!(past.died.get(&job), None);
    assert!(past.standing("d", &key("1"), dir.path()).is_some_and(|r| r.status == Status::Quarantined));
}

#[test]
fn a_tail_torn_at_any_byte_is_cut_and_the_rest_kept() {
    let dir = killed();
    let path = file(dir.path());
    let whole = fs::read(&path).unwrap();
    let after_checkpoint = {
        let mark = b"{\"checkpoint\":{}}\n";
        whole.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len()
    };
    let head = whole.iter().position(|b| *b == b'\n').unwrap();
    let mut random = Random(7);
    // To begin a journal takes a few syncs, which are slow on some disks.
    for length in (0..head).step_by(16).chain(head..=whole.len()) {
        let sound = whole[..length].iter().rposition(|b| *b == b'\n').map_or(0, |at| at + 1);
        let ended = |name: &str| {
            let mark = format!("{{\"ended\":{{\"name\":\"{name}\"");
            String::from_utf8_lossy(&whole[..sound]).contains(&mark)
        };
        // A write that did not come to its end, zeros of a block that was never written, and old blocks.
        let mut tails = vec![Vec::new()];
        if length >= after_checkpoint && length % 5 == 0 {
            tails.push(vec![0; 40]);
            tails.push((0..40).map(|_| u8::try_from(random.below(256)).unwrap()).collect());
            tails.push(b"garbage\n{\"closed\":{}}\n".to_vec());
        }
        for tail in tails {
            fs::write(&path, [&whole[..length], &tail].concat()).unwrap();
            let (mut journal, past) =
                Journal::open(dir.path(), ONE, true, false).unwrap_or_else(|e| panic!("{length}: {e}"));
            for name in ["a", "b", "c"] {
                assert_eq!(past.row(name).is_some(), ended(name), "{name} at {length}");
            }
            journal.ended(&row(dir.path(), "z", "1", Status::Done)).unwrap();
            kill(journal);
            let text = fs::read_to_string(&path).unwrap();
            assert_eq!(text.as_bytes()[..sound], whole[..sound]);
            assert_eq!(text[sound..].lines().count(), 2, "a head and a row follow what was sound:\n{text}");
            assert!(open(dir.path()).1.row("z").is_some());
        }
    }
}

#[test]
fn damage_before_a_checkpoint_is_an_error_with_its_line() {
    let dir = killed();
    let path = file(dir.path());
    let text = fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    let with = |at: usize, line: &str| {
        let mut lines = lines.clone();
        lines[at] = line;
        fs::write(&path, lines.join("\n") + "\n").unwrap();
        Journal::open(dir.path(), ONE, true, false)
    };
    for (at, line) in
        [(1, "x"), (2, "{\"ended\":{}}"), (4, &lines[4][..40]), (3, "{\"other\":{}}"), (0, "a,b")]
    {
        let error = with(at, line).unwrap_err();
        assert!(matches!(&error, BatchError::Journal { line, .. } if *line == at as u64 + 1), "{error}");
        assert!(error.to_string().contains("journal-1-of-1.jsonl:"), "{error}");
    }
    // The same after it is cut off.
    assert!(with(6, "x").is_ok_and(|(_, past)| past.row("c").is_none()));
    // Another format is never cut off, nor is a file that is no journal.
    let other = lines[0].replace("{\"journal\":1,", "{\"journal\":2,");
    let error = with(0, &other).unwrap_err().to_string();
    assert!(error.contains("format 2"), "{error}");
    fs::write(&path, format!("{text}{other}\n")).unwrap();
    assert!(Journal::open(dir.path(), ONE, true, false).is_err());
    fs::write(&path, "{\"checkpoint\":{}}\n").unwrap();
    assert!(Journal::open(dir.path(), ONE, true, false).is_err());
    assert_eq!(fs::read(&path).unwrap(), b"{\"checkpoint\":{}}\n", "what is refused is left alone");
    // A row of which only what tells which is sound is no job that stands, and missed in no report.
    let odd = lines[2].replace("\"copies\":1", "\"copies\":-1");
    fs::write(&path, text.replace(lines[2], &odd)).unwrap();
    assert!(open(dir.path()).1.standing("a", &key("1"), dir.path()).is_none());
    assert!(matches!(read(dir.path()), Err(BatchError::Journal { line: 3, .. })));
    // --restart puts anything aside.
    assert!(Journal::open(dir.path(), ONE, false, true).is_ok());
}

#[test]
fn outputs_must_be_as_they_were_written() {
    let dir = killed();
    let folder = dir.path();
    let (_journal, past) = open(folder);
    let stands = |name: &str| past.standing(name, &key("1"), folder).is_some();
    let change = |name: &str| {
        let mut bytes = fs::read(folder.join(name)).unwrap();
        bytes[3] ^= 1;
        fs::write(folder.join(name), bytes).unwrap();
    };
    change("c");
    assert!(!stands("c"), "one byte is wrong after the last checkpoint");
    change("c");
    assert!(stands("c"));
    change("a");
    assert!(stands("a"), "what has reached the disk is not read again");
    for name in ["a", "c"] {
        fs::write(folder.join(name), "short").unwrap();
        assert!(!stands(name));
        fs::remove_file(folder.join(name)).unwrap();
        assert!(!stands(name));
    }
    assert!(stands("b"), "failures have no output");
}

#[test]
fn folders_of_layers_and_estimates() {
    let dir = tempfile::tempdir().unwrap();
    let folder = dir.path();
    fs::create_dir(folder.join("stack")).unwrap();
    for (name, text) in [("2.png", "two"), ("10.png", "ten"), ("manifest.json", "{}")] {
        fs::write(folder.join("stack").join(name), text).unwrap();
    }
    let mut stack = row(folder, "x", "1", Status::Done);
    stack.name = "stack".to_owned();
    let outcome = stack.outcome.as_mut().unwrap();
    (outcome.bytes, outcome.crc32) = (8, crc32fast::hash(b"tentwo{}"));
    let mut estimate = row(folder, "y", "1", Status::Done);
    estimate.name = "estimate".to_owned();
    estimate.request.estimate = true;
    let (mut journal, _) = open(folder);
    for row in [&stack, &estimate] {
        journal.ended(row).unwrap();
    }
    kill(journal);
    let (mut journal, past) = open(folder);
    assert!(past.standing("stack", &key("1"), folder).is_some());
    assert!(past.standing("estimate", &key("1"), folder).is_some());
    fs::write(folder.join("stack/2.png"), "twu").unwrap();
    assert!(past.standing("stack", &key("1"), folder).is_none());
    journal.ended(&stack).unwrap();
    journal.checkpoint().unwrap();
    kill(journal);
    assert!(open(folder).1.standing("stack", &key("1"), folder).is_some());
}

#[test]
fn one_process_at_a_time_and_no_start_over_what_was_begun() {
    let dir = tempfile::tempdir().unwrap();
    let fresh = |index, count| Journal::open(dir.path(), Shard { index, count }, false, false);
    let (mut journal, _) = fresh(1, 1).unwrap();
    assert!(journal.warning().is_none());
    for (resume, restart) in [(false, false), (true, false), (false, true)] {
        let error = Journal::open(dir.path(), ONE, resume, restart).unwrap_err();
        assert!(matches!(error, BatchError::Locked { .. }), "{error}");
    }
    fresh(1, 2).expect("another shard");
    kill(std::mem::replace(&mut journal, fresh(2, 2).unwrap().0));
    let (mut journal, _) = fresh(1, 1).expect("nothing was begun");
    journal.started("a", &key("1"), 1).unwrap();
    kill(journal);
    assert!(matches!(fresh(1, 1).unwrap_err(), BatchError::NotFresh { .. }));
    fresh(3, 4).expect("the journal of another shard is no obstacle");
}

#[test]
fn restart_puts_the_journal_aside_and_knows_nothing() {
    let dir = killed();
    let state = dir.path().join(STATE_FOLDER);
    let old = fs::read(file(dir.path())).unwrap();
    let (mut other, _) = Journal::open(dir.path(), Shard { index: 2, count: 2 }, false, false).unwrap();
    other.ended(&row(dir.path(), "o", "1", Status::Done)).unwrap();
    let (journal, past) = Journal::open(dir.path(), ONE, false, true).unwrap();
    assert!(past.names().count() == 0 && past.died.is_empty());
    kill(journal);
    assert_eq!(fs::read(state.join("journal-1-of-1.jsonl.old")).unwrap(), old);
    assert_eq!(open(dir.path()).1.names().collect::<Vec<_>>(), ["o"], "other shards are untouched");
    drop(Journal::open(dir.path(), ONE, false, true).unwrap());
    assert_eq!(fs::read_dir(&state).unwrap().count(), 3, "one old journal is kept");
}

#[test]
fn the_latest_run_has_the_last_word_whatever_the_shard() {
    let dir = tempfile::tempdir().unwrap();
    let say = |index, count, key_text: &str, status| {
        let (mut journal, _) = Journal::open(dir.path(), Shard { index, count }, true, false).unwrap();
        journal.started("a", &key(key_text), 1).unwrap();
        journal.ended(&row(dir.path(), "a", key_text, status)).unwrap();
        kill(journal);
    };
    say(2, 2, "1", Status::Done);
    say(1, 1, "2", Status::Failed);
    let past = open(dir.path()).1;
    let last = past.row("a").unwrap();
    assert_eq!((last.status, last.key), (Status::Failed, key("2")));
    say(2, 2, "3", Status::Done);
    let past = open(dir.path()).1;
    assert_eq!(past.row("a").unwrap().key, key("3"));
    assert!(past.unsynced.contains("a") && past.died.is_empty());

    // Two shards at work at the same time, whose runs have the same number.
    let dir = tempfile::tempdir().unwrap();
    let mut both = [1, 2].map(|index| {
        let (journal, _) = Journal::open(dir.path(), Shard { index, count: 2 }, true, false).unwrap();
        let text = fs::read_to_string(&journal.path).unwrap();
        let at = text.find("\"run\":").unwrap() + 6;
        fs::write(&journal.path, text[..at].to_owned() + "7" + &text[at + 13..]).unwrap();
        journal
    });
    both[1].ended(&row(dir.path(), "a", "1", Status::Failed)).unwrap();
    both[0].ended(&row(dir.path(), "a", "1", Status::Done)).unwrap();
    both[0].checkpoint().unwrap();
    both[0].started("b", &key("1"), 1).unwrap();
    both.into_iter().for_each(kill);
    let past = open(dir.path()).1;
    assert_eq!(past.row("a").unwrap().status, Status::Done);
    assert!(past.unsynced.is_empty() && past.died.len() == 1);
    // The whole batch, done later, clears what a shard left in hand.
    let (mut journal, _) = open(dir.path());
    journal.ended(&row(dir.path(), "b", "1", Status::Done)).unwrap();
    kill(journal);
    assert!(open(dir.path()).1.died.is_empty());
}

#[test]
fn what_killed_processes_left_goes_when_the_job_is_taken_up_again() {
    let dir = killed();
    let pictures = dir.path().join(STATE_FOLDER).join("pictures");
    fs::create_dir_all(&pictures).unwrap();
    let left = [dir.path().join(".d.17.part"), pictures.join(".d.png.17.part"), dir.path().join(".a.x.part")];
    left.iter().for_each(|path| fs::write(path, "whole, but for the rename").unwrap());
    let others = dir.path().join(".other.x.part");
    fs::write(&others, "of another shard at work").unwrap();
    let (mut journal, _) = open(dir.path());
    // Its own, made after that.
    fs::write(dir.path().join(".a.18.part"), "").unwrap();
    let exist = |journal: &Journal| left.each_ref().map(|path| journal.path.exists() && path.exists());
    assert_eq!(exist(&journal), [true; 3]);
    journal.started("d", &key("1"), 1).unwrap();
    assert_eq!(exist(&journal), [false, false, true]);
    journal.ended(&row(dir.path(), "a", "2", Status::Done)).unwrap();
    assert_eq!(exist(&journal), [false; 3]);
    assert!(others.exists() && dir.path().join(".a.18.part").exists());
}

#[test]
#[cfg(target_os = "linux")]
fn a_journal_that_cannot_be_written_stops_the_batch_and_stays_sound() {
    let dir = killed();
    let (mut journal, _) = open(dir.path());
    let sound = journal.length;
    // As on a full disk: what was there of the line is taken back where that is possible.
    let real = std::mem::replace(&mut journal.file, File::options().append(true).open("/dev/full").unwrap());
    let error = journal.ended(&row(dir.path(), "x", "1", Status::Done)).unwrap_err();
    assert!(matches!(&error, BatchError::Write { .. }) && error.exit_code() == 6, "{error}");
    assert!(error.to_string().contains("--resume"), "{error}");
    assert!(journal.torn, "a device cannot be cut");
    journal.file = real;
    assert!(journal.started("x", &key("1"), 1).is_err(), "nothing follows a line that is torn");
    kill(journal);
    assert_eq!(fs::metadata(file(dir.path())).unwrap().len(), sound);
    assert!(open(dir.path()).1.standing("a", &key("1"), dir.path()).is_some());
}
