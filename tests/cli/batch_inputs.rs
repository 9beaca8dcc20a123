//! What `batch` makes of files, folders, patterns, manifests and flags before it begins.

use super::{Bench, stderr};
use microtome::mesh::shapes;
use std::process::Output;

/// A folder with two models, a.stl and in/b.stl.
fn bench() -> Bench {
    let bench = Bench::new();
    bench.stl("a.stl", &shapes::tetrahedron(10.0));
    std::fs::create_dir(bench.path("in")).unwrap();
    bench.stl("in/b.stl", &shapes::cuboid([0.0; 3], [5.0; 3]));
    bench
}

fn batch(bench: &Bench, args: &[&str]) -> Output {
    bench.run([&["batch", "-o", "out"], args].concat())
}

/// Runs a batch that cannot begin: this exit code, one line of error with these words, nothing written.
fn refused(bench: &Bench, args: &[&str], code: i32, words: &[&str]) {
    let done = batch(bench, args);
    let text = stderr(&done);
    assert_eq!(done.status.code(), Some(code), "{args:?}: {text}");
    let errors: Vec<&str> = text.lines().filter(|l| l.starts_with("error:")).collect();
    assert_eq!(errors.len(), 1, "{args:?}: {text}");
    for word in words {
        assert!(text.contains(word), "{args:?}: {word:?} is not in {text}");
    }
    assert!(done.stdout.is_empty() && !text.contains("panicked"), "{text}");
    assert!(!bench.path("out").exists(), "{args:?}: nothing is made");
}

#[test]
fn there_must_be_something_to_do() {
    let bench = bench();
    bench.write("empty.jsonl", "\n");
    std::fs::create_dir(bench.path("empty")).unwrap();
    refused(&bench, &["none.stl"], 3, &["none.stl: cannot read", "check the path"]);
    refused(&bench, &["empty"], 3, &["empty: no model in it"]);
    refused(&bench, &["empty.jsonl", "empty"], 3, &["empty.jsonl, empty: no model in it"]);
    refused(&bench, &["a.stl", "none/*.stl"], 3, &["none/*.stl: no model in it"]);
    refused(&bench, &["in/[b.stl"], 2, &["in/[b.stl", "close its brackets"]);
    refused(&bench, &[], 2, &["<INPUT>"]);
}

#[test]
fn manifests_are_refused_with_their_line() {
    let bench = bench();
    let cases = [
        (
            "m.jsonl",
            "{\"model\": \"a.stl\"}\n{\"model\": \"a.stl\", \"copys\": 2}\n",
            "m.jsonl:2: there is no column \"copys\"; did you mean copies?",
        ),
        ("m.ndjson", "{\"model\": \"a.stl\"\n", "m.ndjson:1: not JSON"),
        (
            "m.csv",
            "model,copies\na.stl,1\nin/b.stl,0\n",
            "m.csv:3: copies: \"0\" is not a whole number from 1 to 1000",
        ),
        ("o.csv", "model,output\na.stl,../a.gcode\n", "o.csv:2: output \"../a.gcode\""),
        (
            "two.csv",
            "model,output\na.stl,x.gcode\na.stl,x.gcode\n",
            "two.csv:3: output \"x.gcode\" cannot be beside that of two.csv:2",
        ),
    ];
    for (name, text, message) in cases {
        bench.write(name, text);
        refused(&bench, &["a.stl", name], 4, &[message]);
    }
}

#[test]
fn settings_of_the_command_line_are_looked_at_first() {
    let bench = bench();
    bench.write("sla.ini", "printer_technology = SLA\n");
    bench.write("bad.ini", "layer_height = thick\n");
    // In the words of `slice` and `mask`.
    for (args, code) in [
        (&["--layer-height", "abc"][..], 4),
        (&["--set", "layer_hight=0.2"], 4),
        (&["--set", "layer_height"], 4),
        (&["--load", "bad.ini"], 4),
        (&["--load", "none.ini"], 4),
        (&["--layer-height", "2"], 4),
        (&["--printer", "elegoo-satrun"], 4),
        (&["--printer", "elegoo-mars-3"], 4),
        (&["--printer", "prusa-sl1s", "--exposure-time", "x"], 4),
        (&["--orient", "up"], 2),
        (&["--snap-grid", "99"], 2),
        (&["--rotate", "north"], 2),
    ] {
        let resin = args.contains(&"--printer") || args.contains(&"--rotate");
        let single = bench.run([&[if resin { "mask" } else { "slice" }, "a.stl"], args].concat());
        let text = stderr(&single);
        let error = text.lines().find(|l| l.starts_with("error:")).unwrap();
        assert_eq!(single.status.code(), Some(code), "{text}");
        refused(&bench, &[&["a.stl"], args].concat(), code, &[error]);
    }
    refused(&bench, &["a.stl", "--load", "sla.ini"], 4, &["display_pixels_x = 0: the panel is unknown"]);
    refused(
        &bench,
        &["a.stl", "--technology", "filament", "--load", "sla.ini"],
        4,
        &["means a resin printer"],
    );
    // A value of the other technology is looked at too.
    refused(
        &bench,
        &["a.stl", "--exposure-time", "x"],
        4,
        &["--exposure-time: exposure_time = \"x\" is not"],
    );
    refused(&bench, &["a.stl", "--format", "stl"], 4, &["--format: no format has the extension \"stl\""]);
    refused(
        &bench,
        &["a.stl", "--format", "goo", "--technology", "filament"],
        4,
        &["--format goo: filament"],
    );
}

#[test]
fn flags_that_exclude_each_other() {
    let bench = bench();
    refused(&bench, &["a.stl", "--resume", "--restart"], 2, &["--restart"]);
    refused(&bench, &["a.stl", "--retry-failed"], 2, &["--resume"]);
    for shard in ["0/3", "4/3", "1", "a/b", "1/0"] {
        refused(&bench, &["a.stl", "--shard", shard], 2, &["is no shard; give I/N"]);
    }
    for flag in ["--job-time=0", "--job-time=nan", "--memory=1", "--threads=0", "--copies=0"] {
        refused(&bench, &["a.stl", flag], 2, &[]);
    }
    let done = bench.run(["batch", "a.stl"]);
    assert_eq!(done.status.code(), Some(2), "an output folder is needed: {}", stderr(&done));
}
