//! Nothing is printed in air, and supports keep clear of the part.

use super::support_case::{Case, faults, plain};
use microtome::job::supports::Supports;
use microtome::mesh::{Mesh, demo_part, shapes};
use microtome::settings::SupportStyle;
use microtome::span::algebra::{and, or, sub};
use microtome::span::{Rows, RowsBuilder};
use rayon::prelude::*;

const STYLES: [SupportStyle; 3] = [SupportStyle::Grid, SupportStyle::Snug, SupportStyle::Organic];

/// Random bodies that are looked at.
const SEEDS: u64 = 40;

#[test]
fn nothing_of_random_bodies_is_printed_in_air() {
    let wrong: Vec<String> = (0..SEEDS)
        .into_par_iter()
        .filter_map(|seed| {
            let case = Case::random(seed);
            let (planned, supports) = case.made();
            let found = faults(&planned.layers, &supports, &case.settings);
            found.any().then(|| format!("{}\n  {found:?}", case.name))
        })
        .collect();
    assert!(wrong.is_empty(), "{} of {SEEDS}:\n{}", wrong.len(), wrong.join("\n"));
}

fn known() -> Vec<(&'static str, Mesh)> {
    vec![
        ("tee", shapes::tee()),
        ("arch", shapes::arch()),
        ("stair", shapes::stair(8)),
        ("blunt cone", shapes::cone_down(3.0, 12.0, 8.0, 60)),
        ("demo", demo_part()),
        ("ball", shapes::sphere(8.0, 60, 40)),
    ]
}

#[test]
fn nothing_of_known_bodies_is_printed_in_air() {
    let cases: Vec<_> = known().into_iter().flat_map(|b| STYLES.map(|style| (b.clone(), style))).collect();
    let wrong: Vec<String> = cases
        .into_par_iter()
        .filter_map(|((name, mesh), style)| {
            let case = Case { name: format!("{name}, {style:?}"), mesh, settings: plain(style) };
            let (planned, supports) = case.made();
            let found = faults(&planned.layers, &supports, &case.settings);
            assert!(!supports.layers.is_empty(), "{}: no supports", case.name);
            found.any().then(|| format!("{}\n  {found:?}", case.name))
        })
        .collect();
    assert!(wrong.is_empty(), "{}:\n{}", wrong.len(), wrong.join("\n"));
}

/// The same change to all areas of all layers.
fn changed(supports: &Supports, change: impl Fn(&Rows) -> Rows) -> Supports {
    let mut other = supports.clone();
    for layer in &mut other.layers {
        for rows in [&mut layer.base, &mut layer.interface, &mut layer.bottom_interface] {
            *rows = change(rows);
        }
    }
    other
}

/// The spans of an area that begin left of `s`.
fn left_of(area: &Rows, s: i32) -> Rows {
    spans(area, |a| (a.start < s).then_some((a.start, a.end.min(s))))
}

fn spans(area: &Rows, map: impl Fn(&microtome::span::Span) -> Option<(i32, i32)>) -> Rows {
    let mut out = RowsBuilder::new(area.first());
    for (_, row) in area.iter() {
        row.iter().filter_map(&map).for_each(|(a, b)| out.push(a, b));
        out.end_row();
    }
    out.finish()
}

#[test]
fn planted_faults_are_seen() {
    for style in STYLES {
        let case = Case { name: String::new(), mesh: shapes::tee(), settings: plain(style) };
        let (planned, good) = case.made();
        let look = |supports: &Supports| faults(&planned.layers, supports, &case.settings);
        // The part's zero is in its middle: one arm to each side.
        let middle = good.rows.as_ref().unwrap().frame.st(microtome::lattice::Point2::new(0, 0)).0;
        let lost = look(&changed(&good, |rows| left_of(rows, middle)));
        assert!(lost.part[1] > 50.0 && lost.part_lines[0] > 50.0, "{style:?}: {lost:?}");
        // A metre of supports moved by 3 mm along the rows: into the stem.
        let by = super::support_case::length(3.0);
        let moved = look(&changed(&good, |rows| spans(rows, |a| Some((a.start + by, a.end + by)))));
        assert!(moved.clash > 10.0, "{style:?}: {moved:?}");
        // One layer in the middle is missing.
        let mut gone = good.clone();
        gone.layers[good.layers.len() / 2].base = Rows::default();
        let gone = look(&gone);
        assert!(gone.supports[1] > 1.0, "{style:?}: {gone:?}");
        // Areas that overlap.
        let mut twice = good;
        for layer in &mut twice.layers {
            layer.bottom_interface = or(&layer.bottom_interface, &layer.interface);
        }
        assert!(look(&twice).overlap > 1.0, "{style:?}");
    }
}

#[test]
fn nothing_stands_under_what_stands_on_the_part() {
    // Two blunt cones, base to base, with a disc on a neck: what holds the disc stands on the upper cone, and the
    // lower one is too steep to need any.
    let profile = [
        [0.0, 0.0],
        [4.0, 0.0],
        [10.0, 14.0],
        [4.0, 26.0],
        [2.0, 26.0],
        [2.0, 34.0],
        [6.0, 34.0],
        [6.0, 36.0],
        [0.0, 36.0],
    ];
    for style in [SupportStyle::Grid, SupportStyle::Snug] {
        let mesh = shapes::revolve(&profile, 60);
        let case = Case { name: String::new(), mesh, settings: plain(style) };
        let (_, supports) = case.made();
        let length = |layer: &microtome::support::SupportLayer| {
            [&layer.base, &layer.interface, &layer.bottom_interface].map(Rows::length).iter().sum::<i64>()
        };
        let (under, above): (Vec<_>, Vec<_>) = supports.layers.iter().partition(|l| l.print_z < 14_000_000);
        let sums = [under, above].map(|layers| layers.into_iter().map(length).sum::<i64>());
        assert!(sums[0] == 0 && sums[1] > 0, "{style:?}: {sums:?}");
    }
}

#[test]
fn supports_do_not_depend_on_the_number_of_threads() {
    for seed in [3, 4, 5] {
        let case = Case::random(seed);
        let with = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| {
                let (planned, supports) = case.made();
                (planned.layers, supports.layers, supports.overhangs)
            })
        };
        let one = with(1);
        assert!(one == with(3), "{}", case.name);
        // The comparison sees a change.
        let mut other = one.clone();
        let some = other.2.iter_mut().find(|o| !o.area.is_empty()).unwrap();
        some.area = sub(&some.area, &left_of(&some.area, some.area.spans()[0].start + 1));
        assert!(one != other && and(&some_area(&one.2), &some_area(&other.2)).length() > 0);
    }
}

fn some_area(all: &[microtome::support::overhang::Overhang]) -> Rows {
    all.iter().fold(Rows::default(), |sum, o| or(&sum, &o.area))
}
