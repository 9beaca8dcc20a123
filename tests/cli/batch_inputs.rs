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

/// Names of the outputs, sorted; folders as `x/y`.
fn outputs(bench: &Bench) -> Vec<String> {
    let mut found = Vec::new();
    let mut open = vec![bench.path("out")];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.strip_prefix(bench.path("out")).unwrap().to_str().unwrap().to_owned();
            if path.is_dir() && name != ".microtome" {
                open.push(path);
            } else if !name.starts_with("report") && name != ".microtome" {
                found.push(name);
            }
        }
    }
    found.sort();
    found
}

/// A batch that ends with this code.
fn done(bench: &Bench, args: &[&str], code: i32) -> String {
    let done = batch(bench, args);
    let text = stderr(&done);
    assert_eq!(done.status.code(), Some(code), "{args:?}: {text}");
    text
}

#[test]
fn outputs_are_those_of_slice_and_mask() {
    let bench = bench();
    bench.write("fine.ini", "layer_height = 0.1\nfirst_layer_height = 0.2\n");
    let manifest = "model,profile,settings,output,copies,technology,printer\n\
                    a.stl,,,,,,\n\
                    a.stl,fine.ini,fill_density=30%;skirts=2,x/fine,,,\n\
                    in/b.stl,,layer_height=0.05,,2,resin,prusa-sl1\n";
    bench.write("jobs.csv", manifest);
    done(&bench, &["in", "in/*.stl", "jobs.csv", "--perimeters=2", "--exposure-time", "4"], 0);
    assert_eq!(outputs(&bench), ["a.gcode", "b.gcode", "b.sl1", "x/fine.gcode"]);
    let same = |name: &str, args: &[&str]| {
        let single = bench.run(args.iter().chain(&["-o", "single"]));
        assert!(single.status.success(), "{}", stderr(&single));
        let [ours, its] =
            [format!("out/{name}"), "single".to_owned()].map(|n| std::fs::read(bench.path(&n)).unwrap());
        assert!(ours == its, "{name}: other bytes than those of {args:?}");
    };
    same("a.gcode", &["slice", "a.stl", "--perimeters=2"]);
    same("b.gcode", &["slice", "in/b.stl", "--perimeters=2"]);
    let fine = ["slice", "a.stl", "--perimeters=2", "--load", "fine.ini", "--fill-density=30%", "--skirts=2"];
    same("x/fine.gcode", &fine);
    let printer = ["--printer", "prusa-sl1", "--exposure-time=4", "--layer-height=0.05", "-o", "b.sl1"];
    let single = bench.run(["mask", "in/b.stl", "in/b.stl"].iter().chain(&printer));
    assert!(single.status.success(), "{}", stderr(&single));
    assert!(std::fs::read(bench.path("b.sl1")).unwrap() == std::fs::read(bench.path("out/b.sl1")).unwrap());
}

#[test]
fn a_wrong_job_fails_alone_and_its_manifest_does_it_again() {
    let bench = bench();
    bench.write("broken.stl", "solid x\n");
    bench.write("jobs.jsonl", "{\"model\": \"a.stl\"}\n{\"model\": \"late.stl\"}\n{\"model\": \"a.stl\", \"settings\": {\"layer_hight\": 1}}\n");
    let text = done(&bench, &["in", "broken.stl", "jobs.jsonl", "--skirts=0"], 7);
    let error = text.lines().find(|l| l.starts_with("error:")).unwrap();
    assert!(error.starts_with("error: 3 of 5 jobs failed; see out"), "{error}");
    assert!(error.contains("report.html and out") && error.ends_with("quarantine.jsonl"), "{error}");
    for word in ["broken.stl: contains no triangles", "late.stl: no such file", "did you mean layer_height?"]
    {
        assert!(text.contains(word), "{word:?} is not in {text}");
    }
    assert_eq!(outputs(&bench), ["a.gcode", "b.gcode", "quarantine.jsonl"]);
    // Mended, they are done under the same names, with the same flags.
    std::fs::copy(bench.path("a.stl"), bench.path("late.stl")).unwrap();
    std::fs::copy(bench.path("a.stl"), bench.path("broken.stl")).unwrap();
    let text = done(&bench, &["out/quarantine.jsonl", "--resume", "--retry-failed"], 7);
    assert!(text.contains("1 of 3 jobs failed"), "{text}");
    assert_eq!(outputs(&bench), ["a.gcode", "b.gcode", "broken.gcode", "late.gcode", "quarantine.jsonl"]);
    let single = bench.slice(&bench.path("late.stl"), &["--skirts=0"]);
    assert_eq!(std::fs::read(bench.path("out/late.gcode")).unwrap(), single);
}

#[test]
fn nothing_done_is_another_code() {
    let bench = bench();
    bench.write("broken.stl", "solid x\n");
    let text = done(&bench, &["broken.stl"], 8);
    assert!(text.contains("error: none of 1 job succeeded; see out"), "{text}");
}

#[test]
fn warnings_of_flags_are_given_once() {
    let bench = bench();
    let text = done(&bench, &["in", "a.stl", "--exposure-time=3"], 0);
    let warnings: Vec<&str> = text.lines().filter(|l| l.contains("exposure_time")).collect();
    assert_eq!(
        warnings,
        [
            "warning: --exposure-time: exposure_time = 3: a setting of resin printers, so it has no effect here"
        ]
    );
}

#[test]
fn a_manifest_may_come_from_a_pipe() {
    use std::io::Write;
    use std::process::{Command, Stdio};
    let bench = bench();
    let mut child = Command::new(env!("CARGO_BIN_EXE_microtome"))
        .args(["batch", "-o", "out", "-", "--quiet"])
        .current_dir(bench.dir.path())
        .stdin(Stdio::piped())
        .spawn()
        .unwrap();
    let lines =
        b"{\"model\": \"a.stl\", \"output\": \"one\"}\n{\"model\": \"in/b.stl\", \"output\": \"two.g\"}\n";
    child.stdin.take().unwrap().write_all(lines).unwrap();
    assert!(child.wait().unwrap().success());
    assert_eq!(outputs(&bench), ["one.gcode", "two.g"]);
}

#[test]
fn shards_share_the_jobs_and_their_names() {
    let bench = bench();
    std::fs::create_dir(bench.path("more")).unwrap();
    for edge in 1..8 {
        bench.stl(&format!("more/{edge}.stl"), &shapes::tetrahedron(f64::from(5 + edge)));
        bench.stl(&format!("in/{edge}.stl"), &shapes::tetrahedron(f64::from(15 + edge)));
    }
    done(&bench, &["in", "more", "--shard", "1/3"], 0);
    let first = outputs(&bench);
    done(&bench, &["in", "more", "--shard", "2/3"], 0);
    done(&bench, &["in", "more", "--shard", "3/3"], 0);
    let all = outputs(&bench);
    let mut expected: Vec<String> =
        (1..8).flat_map(|n| [format!("{n}-2.gcode"), format!("{n}.gcode")]).collect();
    expected.push("b.gcode".to_owned());
    assert_eq!(all, expected);
    assert!(first.len() < all.len());
    // Alone they give the same.
    let whole = bench.run(["batch", "-o", "whole", "in", "more"]);
    assert!(whole.status.success(), "{}", stderr(&whole));
    for name in all {
        let [a, b] = ["out", "whole"].map(|f| std::fs::read(bench.path(f).join(&name)).unwrap());
        assert!(a == b, "{name}");
    }
}

#[test]
fn folders_of_pictures_are_outputs_too() {
    let bench = bench();
    let args = [
        "in",
        "--printer",
        "prusa-sl1",
        "--format",
        "folder",
        "--layer-height=1",
        "--set",
        "initial_layer_height=0.5",
    ];
    let text = stderr(&batch(&bench, &args));
    assert!(text.contains("layer_height = 1: thicker than light"), "{text}");
    let args = ["in", "--printer", "prusa-sl1", "--format", "folder", "--layer-height=0.5"];
    done(&bench, &args, 0);
    assert!(
        outputs(&bench).iter().any(|n| n.starts_with("b/") && n.ends_with(".png")),
        "{:?}",
        outputs(&bench)
    );
    let text = done(&bench, &[&args[..], &["--resume"]].concat(), 0);
    assert!(text.contains("1 skipped"), "{text}");
}

#[test]
fn a_stated_hash_assigns_a_shard_without_reading() {
    let bench = bench();
    let zeros = "0".repeat(64);
    bench.write("m.jsonl", format!("{{\"model\": \"in/b.stl\", \"sha256\": \"{zeros}\"}}\n"));
    // It falls to the first shard of two; the second one has nothing to do.
    let second = batch(&bench, &["m.jsonl", "--shard", "2/2"]);
    assert_eq!(second.status.code(), Some(0), "{}", stderr(&second));
    let first = batch(&bench, &["m.jsonl", "--shard", "1/2"]);
    assert_eq!(first.status.code(), Some(8), "{}", stderr(&first));
    assert!(stderr(&first).contains("its SHA-256 is"), "{}", stderr(&first));
    assert!(stderr(&first).contains(&format!("the manifest says {zeros}")));
    // The true one does it.
    let hash = microtome::batch::key::sha256(&std::fs::read(bench.path("in/b.stl")).unwrap());
    bench.write("n.jsonl", format!("{{\"model\": \"in/b.stl\", \"sha256\": \"{}\"}}\n", hash.to_uppercase()));
    let right = bench.run(["batch", "-o", "right", "n.jsonl"]);
    assert_eq!(right.status.code(), Some(0), "{}", stderr(&right));
}
