//! `worker` as programs use it.

use super::{Bench, stderr, stdout};
use microtome::mesh::{demo_part, shapes};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Lines, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// A running worker.
struct Worker {
    process: Child,
    input: Option<ChildStdin>,
    answers: Lines<BufReader<ChildStdout>>,
}

impl Worker {
    fn start(bench: &Bench, args: &[&str]) -> Self {
        let mut process = Command::new(env!("CARGO_BIN_EXE_microtome"))
            .args(["worker", "--backend", "cpu"])
            .args(args)
            .current_dir(bench.dir.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let input = process.stdin.take();
        let mut answers = BufReader::new(process.stdout.take().unwrap()).lines();
        let ready: Value = serde_json::from_str(&answers.next().unwrap().unwrap()).unwrap();
        assert_eq!(ready["ready"]["version"], env!("CARGO_PKG_VERSION"));
        assert_eq!((&ready["id"], ready["ready"]["pid"].as_u64()), (&Value::Null, Some(process.id().into())));
        Self { process, input, answers }
    }

    fn say(&mut self, line: impl ToString) {
        let mut line = line.to_string();
        line.push('\n');
        self.input.as_mut().unwrap().write_all(line.as_bytes()).unwrap();
    }

    fn hear(&mut self) -> Value {
        serde_json::from_str(&self.answers.next().unwrap().unwrap()).unwrap()
    }

    /// Asks and waits for the next line.
    fn ask(&mut self, line: impl ToString) -> Value {
        self.say(line);
        self.hear()
    }

    /// Ends the input: what is still said, and the exit code.
    fn end(mut self) -> (Vec<Value>, Option<i32>) {
        drop(self.input.take());
        let rest = self.answers.map(|line| serde_json::from_str(&line.unwrap()).unwrap()).collect();
        let done = self.process.wait_with_output().unwrap();
        assert_eq!(stderr(&done), "");
        (rest, done.status.code())
    }
}

/// A settings file that can be read once somebody has written into it.
#[cfg(unix)]
fn gate(bench: &Bench) -> &'static str {
    assert!(Command::new("mkfifo").arg(bench.path("gate.ini")).status().unwrap().success());
    "gate.ini"
}

fn same(a: &Path, b: &Path) {
    if a.is_dir() {
        let names = |p: &Path| {
            let mut names: Vec<_> = std::fs::read_dir(p).unwrap().map(|e| e.unwrap().file_name()).collect();
            names.sort();
            names
        };
        assert_eq!(names(a), names(b));
        names(a).iter().for_each(|name| same(&a.join(name), &b.join(name)));
    } else {
        assert!(std::fs::read(a).unwrap() == std::fs::read(b).unwrap(), "{} differs", b.display());
    }
}

#[test]
fn it_writes_what_slice_writes() {
    let bench = Bench::new();
    let model = bench.stl("demo.stl", &demo_part());
    bench.write("a.ini", "layer_height = 0.3\nfill_density = 15%\nfilament_density = 1.24\n");
    let expected = bench.slice(&model, &["--load", "a.ini", "--set", "perimeters=3", "--support-material"]);
    let mut worker = Worker::start(&bench, &["--threads", "2"]);
    let request = json!({
        "model": "demo.stl", "output": "new/w.gcode", "load": ["a.ini"],
        "settings": {"perimeters": 3, "support_material": true}, "picture": "new/w.png",
    });
    for threads in [json!(null), json!(1), json!(2)] {
        let mut request = request.clone();
        request["threads"] = threads;
        let answer = worker.ask(json!({"id": "x", "slice": request}));
        let done = &answer["done"];
        assert_eq!(
            (&answer["id"], done["bytes"].as_u64()),
            (&json!("x"), Some(expected.len() as u64)),
            "{answer}"
        );
        assert_eq!(done["crc32"].as_u64(), Some(crc32fast::hash(&expected).into()));
        assert!(done["material"]["g"].as_f64().unwrap() > 1.0 && done["peak_bytes"].is_u64());
        assert_eq!(std::fs::read(bench.path("new/w.gcode")).unwrap(), expected);
        assert!(bench.path("new/w.png").is_file());
    }
    assert_eq!(worker.end(), (vec![], Some(0)));
}

#[test]
fn it_writes_what_mask_writes() {
    let bench = Bench::new();
    bench.stl("m.stl", &shapes::cone(4.0, 3.0, 40));
    let sizes = [
        ("display_pixels_x", "320"),
        ("display_pixels_y", "240"),
        ("display_width", "32"),
        ("display_height", "24"),
        ("max_print_height", "100"),
    ];
    let mut worker = Worker::start(&bench, &[]);
    for (output, copies) in [("a.goo", 1), ("a.zip", 2), ("a.ctb", 1), ("layers/", 1)] {
        let mut args = vec!["mask".to_owned(), "--rotate=30".into(), "--check".into(), "-o".into()];
        args.push(format!("one_{output}"));
        args.extend(vec!["m.stl".to_owned(); copies]);
        args.extend(sizes.map(|(key, value)| format!("--{}={value}", key.replace('_', "-"))));
        let done = bench.run(&args);
        assert!(done.status.success(), "{}", stderr(&done));
        let answer = worker.ask(json!({"id": output, "slice": {
            "model": "m.stl", "output": format!("two_{output}"), "technology": "resin", "rotate": 30, "check": true,
            "settings": sizes.into_iter().collect::<std::collections::BTreeMap<_, _>>(), "copies": copies,
        }}));
        assert!(answer["done"]["layers"].as_u64().unwrap() > 10, "{answer}");
        same(&bench.path(&format!("one_{output}")), &bench.path(&format!("two_{output}")));
    }
    let unknown = worker.ask(json!({"id": 0, "slice": {
        "model": "m.stl", "output": "a.goo", "technology": "resin", "printer": "elegoo-satrun",
    }}));
    assert_eq!(unknown["failed"]["kind"], "settings");
    assert!(
        unknown["failed"]["message"].as_str().unwrap().contains("did you mean elegoo-saturn?"),
        "{unknown}"
    );
    assert_eq!(worker.end(), (vec![], Some(0)));
}

#[test]
fn failures_are_of_kinds_and_bad_lines_are_refused() {
    let bench = Bench::new();
    bench.stl("m.stl", &shapes::cuboid([0.0; 3], [9.0, 9.0, 2.0]));
    bench.write("bad.stl", "solid\nfacet\n");
    let mut worker = Worker::start(&bench, &["--jobs", "3"]);
    for (request, kind) in [
        (json!({"model": "bad.stl", "output": "o.gcode"}), "model"),
        (json!({"model": "m.stl", "output": "o.gcode", "settings": {"layer_height": 99}}), "settings"),
        (json!({"model": "m.stl", "output": "."}), "output"),
    ] {
        let answer = worker.ask(json!({"id": kind, "slice": request}));
        assert_eq!((&answer["id"], &answer["failed"]["kind"]), (&json!(kind), &json!(kind)), "{answer}");
    }
    for (line, id) in [
        ("{\"id\": 7, \"slice\": {\"modle\": \"m.stl\"}}", json!(7)),
        ("{\"id\": 8, \"slize\": {}}", json!(8)),
        ("{", Value::Null),
        ("[]", Value::Null),
    ] {
        let answer = worker.ask(line);
        assert!(answer["refused"].is_string() && answer["id"] == id, "{line}: {answer}");
    }
    worker.input.as_mut().unwrap().write_all(b"\n  \r\n\xff\xfe\n").unwrap();
    assert!(worker.hear()["refused"].is_string());
    assert_eq!(worker.ask(json!({"id": {"a": 1}, "ping": null})), json!({"id": {"a": 1}, "ok": null}));
    assert_eq!(worker.ask(json!({"id": 9, "quit": null})), json!({"id": 9, "ok": null}));
    assert_eq!(worker.end(), (vec![], Some(0)));
    assert_eq!(bench.names(), ["bad.stl", "m.stl"]);
}

#[cfg(unix)]
#[test]
fn answers_come_in_the_order_in_which_work_ends() {
    let bench = Bench::new();
    bench.stl("m.stl", &shapes::cuboid([0.0; 3], [9.0, 9.0, 2.0]));
    let gate = gate(&bench);
    let mut worker = Worker::start(&bench, &["--jobs", "2", "--threads", "1"]);
    worker.say(json!({"id": 1, "slice": {"model": "m.stl", "output": "1.gcode", "load": [gate]}}));
    for id in [2, 3] {
        let output = format!("{id}.gcode");
        worker.say(json!({"id": id, "slice": {"model": "m.stl", "output": output}}));
        assert_eq!(worker.hear()["id"], id);
    }
    let again = worker.ask(json!({"id": 1, "slice": {"model": "m.stl", "estimate": true}}));
    assert!(again["refused"].as_str().unwrap().contains("in hand already"), "{again}");
    // The input ends; what is in hand is finished all the same.
    drop(worker.input.take());
    bench.write(gate, "layer_height = 0.25\n");
    assert_eq!(worker.hear()["done"]["layers"], 8);
    assert_eq!(worker.end(), (vec![], Some(0)));
    let same =
        |a: &str, b: &str| std::fs::read(bench.path(a)).unwrap() == std::fs::read(bench.path(b)).unwrap();
    assert!(same("2.gcode", "3.gcode") && !same("1.gcode", "2.gcode"));
}

#[cfg(unix)]
#[test]
fn requests_are_followed_and_cancelled() {
    let bench = Bench::new();
    bench.stl("m.stl", &shapes::cuboid([0.0; 3], [9.0, 9.0, 2.0]));
    let gate = gate(&bench);
    let mut worker = Worker::start(&bench, &[]);
    worker.say(json!({"id": 1, "follow": {"model": "m.stl", "output": "1.gcode", "load": [gate]}}));
    assert_eq!(worker.hear(), json!({"id": 1, "started": null}));
    worker.say(json!({"id": 2, "slice": {"model": "m.stl", "output": "2.gcode"}}));
    // One that waits is answered at once, one that is worked on when it notices.
    worker.say(json!({"id": 3, "cancel": 2}));
    let cancelled =
        json!({"kind": "cancelled", "message": "cancelled", "transient": false, "disk_full": false});
    assert_eq!(worker.hear(), json!({"id": 2, "failed": cancelled}));
    assert_eq!(worker.hear(), json!({"id": 3, "ok": null}));
    assert_eq!(worker.ask(json!({"id": 4, "cancel": 1})), json!({"id": 4, "ok": null}));
    bench.write(gate, "layer_height = 0.25\n");
    let mut last = worker.hear();
    while last["stage"].is_string() {
        last = worker.hear();
    }
    assert_eq!(last, json!({"id": 1, "failed": cancelled}));
    let none = worker.ask(json!({"id": 5, "cancel": 1}));
    assert!(none["refused"].as_str().unwrap().contains("no request with the id 1 is in hand"), "{none}");

    worker.say(json!({"id": 1, "follow": {"model": "m.stl", "output": "1.gcode"}}));
    let mut stages = vec![];
    let done = loop {
        let answer = worker.hear();
        match answer["stage"].as_str() {
            Some(stage) => stages.push(stage.to_owned()),
            None if answer.get("started").is_some() => assert!(stages.is_empty()),
            None => break answer,
        }
    };
    assert!(done["done"].is_object() && stages[0] == "reading" && stages.contains(&"walls".to_owned()));
    assert_eq!(worker.end(), (vec![], Some(0)));
    assert_eq!(bench.names(), ["1.gcode", "gate.ini", "m.stl"]);
}

#[cfg(unix)]
#[test]
fn it_dies_with_its_input_where_that_is_asked_for() {
    let bench = Bench::new();
    bench.stl("m.stl", &shapes::cuboid([0.0; 3], [9.0, 9.0, 2.0]));
    let gate = gate(&bench);
    for (quit, works) in [(false, true), (true, false)] {
        let mut worker = Worker::start(&bench, &["--die-with-input"]);
        if works {
            worker.say(json!({"id": 1, "follow": {"model": "m.stl", "output": "1.gcode", "load": [gate]}}));
            assert_eq!(worker.hear()["id"], 1);
        }
        if quit {
            assert_eq!(worker.ask(json!({"id": 2, "quit": null}))["id"], 2);
        }
        let (rest, code) = worker.end();
        assert!(rest.is_empty());
        assert_eq!(code == Some(0), quit, "{code:?}");
    }
    assert_eq!(bench.names(), ["gate.ini", "m.stl"]);
}

#[test]
fn it_ends_when_nobody_listens() {
    let bench = Bench::new();
    let Worker { mut process, input, answers } = Worker::start(&bench, &[]);
    drop(answers);
    let mut input = input.unwrap();
    input.write_all(b"{\"id\": 1, \"ping\": null}\n").unwrap();
    // The input stays open until it has ended.
    assert_eq!(process.wait().unwrap().code(), Some(0));
    drop(input);
}

#[test]
fn the_help_shows_the_protocol() {
    let bench = Bench::new();
    let help = bench.run(["worker", "--help"]);
    let text = stdout(&help);
    assert!(help.status.success() && !text.contains("die-with-input"));
    let orders = ["\"slice\":", "\"follow\":", "\"cancel\":", "\"ping\":", "\"quit\":", "\"refused\":"];
    assert!(orders.iter().all(|order| text.contains(order)), "{text}");
    // Every field of a request is named.
    let request = serde_json::to_value(microtome::slicer::Request::default()).unwrap();
    let missing: Vec<&String> = request.as_object().unwrap().keys().filter(|k| !text.contains(*k)).collect();
    assert!(missing.is_empty(), "{missing:?}");
}
