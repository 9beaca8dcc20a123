#![allow(clippy::unwrap_used)]

use super::*;
use crate::job::backend::{Backend, BackendOptions};
use crate::mesh::{shapes, stl_write};
use std::io::Cursor;

const OPTIONS: ServeOptions = ServeOptions { jobs: 2, die_with_input: false };

fn slicer() -> Slicer {
    Slicer::new(BackendOptions::new(Backend::Cpu, None, None)).with_threads(Some(1))
}

fn answers(input: &str) -> Vec<Answer> {
    let mut out = Vec::new();
    serve(&slicer(), &OPTIONS, Cursor::new(input.to_owned()), &mut out).unwrap();
    let lines = out.strip_suffix(b"\n").unwrap().split(|b| *b == b'\n');
    lines.map(|line| serde_json::from_slice(line).unwrap()).collect()
}

#[test]
fn each_line_is_answered_and_quit_last() {
    let found = answers(
        "\n{\"id\": 1, \"ping\": null}\nnonsense\n{\"id\": [2], \"slice\": {\"model\": \"no.stl\", \"estimate\": true}}\n\
         {\"id\": 3, \"cancel\": 9}\n{\"id\": 4, \"quit\": null}\n{\"id\": 5, \"ping\": null}\n",
    );
    assert!(matches!(found[0].news, News::Ready { .. }) && found[0].id.is_null());
    let of = |id: &str| {
        found
            .iter()
            .filter(|a| a.id == serde_json::from_str::<Value>(id).unwrap())
            .map(|a| &a.news)
            .collect::<Vec<_>>()
    };
    assert!(matches!(of("1")[..], [News::Ok(())]));
    assert!(matches!(of("[2]")[..], [News::Failed(f)] if f.message.contains("no.stl: no such file")));
    assert!(matches!(of("3")[..], [News::Refused(why)] if why.contains("no request with the id 9")));
    assert!(matches!(of("null")[..], [_, News::Refused(_)]));
    assert!(of("5").is_empty(), "what comes after a quit is not read");
    assert_eq!((found.len(), found.last().unwrap().id.clone()), (6, 4.into()));
}

#[test]
fn very_long_lines_are_refused_and_the_next_one_is_read() {
    let long =
        format!("{{\"id\": 1, \"ping\": \"{}\"}}\n{{\"id\": 2, \"ping\": 0}}", "x".repeat(lines::LONGEST));
    let found = answers(&long);
    assert!(matches!(&found[1].news, News::Refused(why) if why == "a line of more than 16 MiB"));
    assert_eq!(found[2], Answer { id: 2.into(), news: News::Ok(()) });
}

/// Takes so many lines.
struct Short(usize);

impl Write for Short {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 = self.0.checked_sub(1).ok_or(io::ErrorKind::BrokenPipe)?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn when_nobody_listens_it_ends_though_the_input_is_open() {
    let dir = tempfile::tempdir().unwrap();
    let model = dir.path().join("m.stl");
    let block = shapes::cuboid([0.0; 3], [9.0, 9.0, 3.0]);
    stl_write::write_stl_binary(&block, &mut std::fs::File::create(&model).unwrap()).unwrap();
    for order in ["ping", "slice", "follow"] {
        for lines in 0..3 {
            let (input, mut asker) = io::pipe().unwrap();
            for id in 0..5 {
                let output = dir.path().join(format!("{id}.gcode"));
                let line = serde_json::json!({"id": id, order: {"model": model, "output": output}});
                writeln!(asker, "{line}").unwrap();
            }
            serve(&slicer(), &OPTIONS, io::BufReader::new(input), Short(lines)).unwrap();
        }
    }
}

#[test]
fn other_failures_of_the_output_are_told() {
    struct Full;
    impl Write for Full {
        fn write(&mut self, _bytes: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::StorageFull.into())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }
    let error = serve(&slicer(), &OPTIONS, Cursor::new(""), Full).unwrap_err();
    assert_eq!(error.kind(), io::ErrorKind::StorageFull);
}
