//! Slices models from a program of one's own, with progress and a time limit.
//!
//! cargo run --release --example library -- PROFILE.ini MODEL.stl ...
#![allow(clippy::print_stdout, missing_docs)]

use microtome::job::progress::Progress;
use microtome::slicer::{Cancel, Request, Slicer};
use std::path::Path;
use std::time::Duration;

/// Prints the stages.
struct Stages;

impl Progress for Stages {
    fn stage(&self, name: &'static str) {
        println!("  {name}");
    }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let Some(profile) = arguments.next() else { return println!("usage: library PROFILE.ini MODEL.stl ...") };
    // One slicer for all: it keeps the device open and reads the profile once.
    let slicer = Slicer::default();
    for model in arguments {
        println!("{model}");
        let request = Request::new(&model)
            .output(Path::new(&model).with_extension("gcode"))
            .load(&profile)
            .set("perimeters", "3");
        let cancel = Cancel::new();
        let clock = cancel.clone();
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_secs(60));
            clock.cancel();
        });
        match slicer.slice(&request, &cancel.beside(&Stages)) {
            Ok(done) => println!(
                "  {} layers, {:.2} m of filament, at least {:.0} s; {} bytes in {:.3} s",
                done.layers,
                done.material.mm / 1e3,
                done.time_lower_bound_s,
                done.bytes,
                done.seconds
            ),
            Err(failure) => println!("  {:?}: {}", failure.kind, failure.message),
        }
    }
}
