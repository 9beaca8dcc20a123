//! Looks for anything printed in air, and for supports too near to the part, on random bodies.
//!
//! cargo run --release --example support_oracle -- FIRST [LAST [STYLE]]
//!
//! Slices the bodies of the seeds from FIRST to LAST (one only without LAST) as a job does, with supports by
//! random settings, and holds every area and every line to the rule. STYLE (grid, snug, organic) replaces that
//! of the seed. Prints what is wrong and the seeds, and ends with code 1 if anything is.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    dead_code,
    unreachable_pub,
    missing_docs
)]

#[path = "../tests/oracle/bodies.rs"]
mod bodies;
#[path = "../tests/oracle/support_case.rs"]
mod support_case;

use microtome::settings::SupportStyle;
use rayon::prelude::*;
use support_case::{Case, faults};

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize| args.get(i).and_then(|a| a.parse::<u64>().ok());
    let Some(first) = number(0) else {
        println!("usage: support_oracle FIRST [LAST [grid|snug|organic]]");
        return;
    };
    let style = args.get(2).map(|name| match name.as_str() {
        "grid" => SupportStyle::Grid,
        "snug" => SupportStyle::Snug,
        _ => SupportStyle::Organic,
    });
    let last = number(1).unwrap_or(first);
    let run = |seed: u64| {
        let mut case = Case::random(seed);
        if let Some(style) = style {
            case.settings.support.support_material_style = style;
        }
        let (planned, supports) = case.made();
        let found = faults(&planned.layers, &supports, &case.settings);
        found.any().then(|| {
            let path = std::env::temp_dir().join(format!("support_oracle_{seed}.stl"));
            if first == last {
                let mut file = std::fs::File::create(&path).unwrap();
                microtome::mesh::stl_write::write_stl_binary(&case.mesh, &mut file).unwrap();
                println!("the body: {}", path.display());
            }
            format!("{}\n  {found:?}", case.name)
        })
    };
    let wrong: Vec<String> = (first..=last).into_par_iter().filter_map(run).collect();
    wrong.iter().for_each(|w| println!("{w}"));
    println!("{} of {} bodies have faults", wrong.len(), last - first + 1);
    if !wrong.is_empty() {
        std::process::exit(1);
    }
}
