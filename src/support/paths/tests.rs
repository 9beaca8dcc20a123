//! Outlines against their rows, lines against the areas they are laid in.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::outline::{TOLERANCE, outlines, outlines_within};
use super::*;
use crate::contour::ExPolygon;
use crate::lattice::{Point2, area2};
use crate::region::offset::inset;
use crate::settings::{InterfacePattern, Settings};
use crate::span::algebra::{and, or, sub};
use crate::span::components::label;
use crate::span::morph::dilate_disc;
use crate::span::tests::Random;
use crate::span::{RowFrame, Rows, RowsBuilder, Span, scan};
use crate::support::StrandKind;

fn plan() -> SupportPlan {
    SupportPlan::new(&Settings::default())
}

fn rows(first: i32, rows: &[&[(i32, i32)]]) -> Rows {
    let mut out = RowsBuilder::new(first);
    for row in rows {
        row.iter().for_each(|&(a, b)| out.push(a, b));
        out.end_row();
    }
    out.finish()
}

/// A rectangle of rows and a range \[units\] along them.
fn block(first: i32, end: i32, s: (i32, i32)) -> Rows {
    let mut out = RowsBuilder::new(first);
    for _ in first..end {
        out.push(s.0, s.1);
        out.end_row();
    }
    out.finish()
}

/// Spans that wander from row to row, part, grow together and touch at corners.
fn random_rows(random: &mut Random, frame: &RowFrame) -> Rows {
    let unit = frame.pitch() as i32 * (1 + random.below(4) as i32) / 2;
    let first = random.within(-40, 10) as i32;
    let mut out = RowsBuilder::new(first);
    for _ in 0..1 + random.below(30) {
        let mut s = random.within(-20, -5) as i32;
        for _ in 0..random.below(6) {
            let length = 1 + random.below(9) as i32;
            out.push(s * unit, (s + length) * unit);
            s += length + 1 + random.below(6) as i32;
        }
        out.end_row();
    }
    out.finish()
}

fn scanned(polygons: &[ExPolygon], frame: &RowFrame) -> Rows {
    scan(polygons.iter().flat_map(|p| p.rings()).map(|r| &r[..]), frame)
}

/// Distance of a point from a segment \[nm\].
fn distance(p: Point2, a: Point2, b: Point2) -> f64 {
    let ((ux, uy), (vx, vy)) = (b.minus(a), p.minus(a));
    let (ux, uy, vx, vy) = (ux as f64, uy as f64, vx as f64, vy as f64);
    let t = ((ux * vx + uy * vy) / (ux * ux + uy * uy).max(1.0)).clamp(0.0, 1.0);
    (vx - t * ux).hypot(vy - t * uy)
}

/// Greatest distance of a span's end \[nm\] from the border of a polygon.
fn stray(area: &Rows, polygons: &[ExPolygon], frame: &RowFrame) -> f64 {
    let edges: Vec<[Point2; 2]> = polygons
        .iter()
        .flat_map(|p| p.rings())
        .flat_map(|r| (0..r.len()).map(move |i| [r[i], r[(i + 1) % r.len()]]))
        .collect();
    let ends = area.iter().flat_map(|(k, row)| row.iter().flat_map(move |s| [(k, s.start), (k, s.end)]));
    ends.map(|(k, s)| {
        let p = frame.xy(s, frame.t(k));
        edges.iter().map(|[a, b]| distance(p, *a, *b)).fold(f64::INFINITY, f64::min)
    })
    .fold(0.0, f64::max)
}

fn frames() -> Vec<RowFrame> {
    [0.0, 90.0, 45.0, 30.0].map(|a| RowFrame::new(a, 0.0, 100_000.0)).to_vec()
}

/// Rows without empty ones at either end.
fn trimmed(area: &Rows) -> Vec<(i32, Vec<Span>)> {
    area.iter().filter(|r| !r.1.is_empty()).map(|(k, row)| (k, row.to_vec())).collect()
}

#[test]
fn outlines_scanned_again_are_the_area() {
    let (mut parts, mut holes) = (0, 0);
    for seed in 1..400 {
        let mut random = Random(seed);
        for (f, frame) in frames().iter().enumerate() {
            let area = random_rows(&mut random, frame);
            let polygons = outlines_within(0.0, &area, frame, 0.0);
            let again = scanned(&polygons, frame);
            // On the others the corners are rounded.
            if f < 2 {
                assert_eq!(trimmed(&again), trimmed(&area), "seed {seed}, {frame:?}");
            }
            let labels = label(&area);
            assert_eq!(polygons.len(), labels.iter().max().map_or(0, |&p| p as usize + 1), "seed {seed}");
            for polygon in &polygons {
                assert!(area2(&polygon.contour) > 0, "seed {seed}");
                assert!(polygon.holes.iter().all(|h| area2(h) < 0), "seed {seed}");
                holes += polygon.holes.len();
            }
            parts += polygons.len();
        }
    }
    assert!(parts > 3_000 && holes > 300, "{parts} {holes}");
}

#[test]
fn straightened_outlines_stay_within_the_tolerance() {
    let mut corners = [0, 0];
    for seed in 1..200 {
        let mut random = Random(seed);
        for frame in frames() {
            let area = random_rows(&mut random, &frame);
            let polygons = outlines(&area, &frame, 0.0);
            let off = stray(&area, &polygons, &frame);
            assert!(off <= TOLERANCE + 3.0, "seed {seed}: {off}");
            for (n, p) in corners.iter_mut().zip([&polygons, &outlines_within(0.0, &area, &frame, 0.0)]) {
                *n += p.iter().flat_map(|p| p.rings()).map(Vec::len).sum::<usize>();
            }
            // Every part keeps about its area.
            let mm2: f64 = polygons.iter().map(|p| p.area_mm2()).sum();
            let exact = area.length() as f64 * frame.mm2_per_unit();
            assert!((mm2 - exact).abs() < 0.3 * exact + 0.1, "seed {seed}: {mm2} for {exact}");
        }
    }
    assert!(corners[0] < corners[1], "{corners:?}");
}

#[test]
fn a_displaced_outline_is_noticed() {
    let frame = frames()[0];
    let area = block(0, 30, (0, 3_000_000));
    let polygons = outlines(&area, &frame, 0.0);
    assert!(stray(&area, &polygons, &frame) < 3.0);
    let wider = block(0, 30, (-40_000, 3_000_000));
    assert!(stray(&wider, &polygons, &frame) > TOLERANCE);
    let taller = block(-1, 30, (0, 3_000_000));
    assert!(stray(&taller, &polygons, &frame) > TOLERANCE);
}

#[test]
fn cells_are_clean_rectangles() {
    for frame in frames() {
        let u = |mm: f64| frame.units(mm * 1e6) as i32;
        let cell = outlines(&block(-29, 58, (u(-2.9), u(5.8))), &frame, 0.0);
        assert_eq!((cell.len(), cell[0].contour.len(), cell[0].holes.len()), (1, 4, 0), "{frame:?}");
        assert!((cell[0].area_mm2() - 8.7 * 8.7).abs() < 1e-3);
        // An L of three cells, and one with a cell missing inside.
        let (a, b) = (block(0, 29, (0, u(5.8))), block(29, 58, (0, u(2.9))));
        let l = outlines(&or(&a, &b), &frame, 0.0);
        assert_eq!((l.len(), l[0].contour.len()), (1, 6), "{frame:?}: {l:?}");
        let ring = sub(&block(0, 87, (0, u(8.7))), &block(29, 58, (u(2.9), u(5.8))));
        let ring = outlines(&ring, &frame, 0.0);
        assert_eq!((ring[0].contour.len(), ring[0].holes[0].len()), (4, 4), "{ring:?}");
        // Two that touch at a corner stay two.
        let two = outlines(&or(&a, &block(29, 58, (u(5.8), u(8.7)))), &frame, 0.0);
        assert_eq!(two.iter().map(|p| p.contour.len()).collect::<Vec<_>>(), [4, 4], "{two:?}");
    }
}

#[test]
fn slopes_are_straight_and_discs_round() {
    let frame = frames()[0];
    for slope in [1_000, 30_000, 250_000, 3_000_000] {
        let mut out = RowsBuilder::new(0);
        for k in 0..40 {
            out.push(k * slope, k * slope + 9_000_000);
            out.end_row();
        }
        let area = outlines(&out.finish(), &frame, 0.0);
        // Four corners, and half a row beyond at either end.
        assert!(area[0].contour.len() <= 8, "{slope}: {}", area[0].contour.len());
    }
    let spot = block(0, 1, (0, 1_000));
    let disc = outlines(&dilate_disc(&spot, 3_000_000, |k| frame.t(k)), &frame, 0.0);
    let n = disc[0].contour.len();
    assert!((12..40).contains(&n), "{n}");
    assert!((disc[0].area_mm2() / (std::f64::consts::PI * 9.0) - 1.0).abs() < 0.02);
    assert!(disc[0].contour.iter().all(|p| (p.distance(Point2::new(500, 0)) / 3e6 - 1.0).abs() < 0.03));
}

#[test]
fn crumbs_are_left_out() {
    let frame = frames()[0];
    let crumbs =
        rows(0, &[&[(0, 100_000), (500_000, 5_000_000)], &[(500_000, 1_000_000), (1_100_000, 5_000_000)]]);
    assert_eq!(outlines(&crumbs, &frame, 0.0).len(), 2);
    let polygons = outlines(&crumbs, &frame, 0.05);
    assert_eq!(polygons.len(), 1);
}

/// Length of strands \[mm\].
fn length(strands: &[Strand]) -> f64 {
    let way = |s: &Strand| {
        let back = if s.closed { s.points[s.points.len() - 1].distance(s.points[0]) } else { 0.0 };
        back + s.points.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>()
    };
    strands.iter().map(way).sum::<f64>() * 1e-6
}

/// Millimetres of line in areas of a layer, without links: those points that go along `degrees`.
fn along(strands: &[Strand], degrees: f64) -> f64 {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let edges = strands.iter().flat_map(|s| s.points.windows(2));
    edges
        .filter_map(|w| {
            let (dx, dy) = w[1].minus(w[0]);
            let (dx, dy) = (dx as f64 * 1e-6, dy as f64 * 1e-6);
            ((dx * sin - dy * cos).abs() < 1e-5).then(|| dx.hypot(dy))
        })
        .sum()
}

fn layer(kind: LayerKind, base: Rows, interface: Rows) -> SupportLayer {
    SupportLayer { print_z: 1_000_000, height: 300_000, kind, base, interface, ..SupportLayer::default() }
}

/// How far any point of the strands, and of the ways between them, lies outside the area, half a line taken off
/// \[nm\].
fn outside(strands: &[Strand], area: &Rows, plan: &SupportPlan) -> f64 {
    let polygons = outlines_within(0.0, area, &plan.frame, crumb(plan));
    let own = scanned(&polygons, &RowFrame::new(0.0, 0.0, 5_000.0));
    let rows = RowFrame::new(0.0, 0.0, 5_000.0);
    let edges: Vec<[Point2; 2]> = polygons
        .iter()
        .flat_map(|p| p.rings())
        .flat_map(|r| (0..r.len()).map(move |i| [r[i], r[(i + 1) % r.len()]]))
        .collect();
    let mut most = 0f64;
    for s in strands {
        let n = s.points.len();
        for i in 0..if s.closed { n } else { n - 1 } {
            let (a, b) = (s.points[i], s.points[(i + 1) % n]);
            for share in [0.0, 0.3, 0.5, 0.8] {
                let p = a.toward(b, share);
                let (x, t) = rows.st(p);
                let row = own.row(rows.nearest_row(t.into()));
                let inside = row.iter().any(|s| s.start <= x && x < s.end);
                let off = edges.iter().map(|[a, b]| distance(p, *a, *b)).fold(f64::INFINITY, f64::min);
                most = most.max(0.5 * plan.width + if inside { -off } else { off });
            }
        }
    }
    most
}

fn blobs(random: &mut Random, plan: &SupportPlan) -> Rows {
    let mut all = Rows::default();
    for _ in 0..1 + random.below(5) {
        let at = block(random.within(-90, 90) as i32, 0, (0, 0)).first();
        let s = random.within(-9_000_000, 9_000_000) as i32;
        let spot = block(at, at + 1, (s, s + 1_000));
        let radius = random.within(300_000, 5_000_000);
        all = or(&all, &dilate_disc(&spot, radius, |k| plan.frame.t(k)));
    }
    let (cut, s) = (random.within(-60, 60) as i32, random.within(-9_000_000, 9_000_000) as i32);
    sub(&all, &block(cut, cut + 40, (s, s + 3_000_000)))
}

#[test]
fn lines_stay_inside_and_every_part_has_some() {
    let mut settings = Settings::default();
    for seed in 1..30 {
        let mut random = Random(seed);
        let s = &mut settings.support;
        s.support_material_with_sheath = seed % 2 == 0;
        s.support_material_pattern =
            [SupportPattern::Rectilinear, SupportPattern::RectilinearGrid, SupportPattern::Honeycomb]
                [random.below(3) as usize];
        s.support_material_interface_pattern =
            [InterfacePattern::Auto, InterfacePattern::Rectilinear, InterfacePattern::Concentric]
                [random.below(3) as usize];
        s.support_material_style = [SupportStyle::Grid, SupportStyle::Snug][random.below(2) as usize];
        s.support_material_interface_contact_loops = random.below(2) == 0;
        s.support_material_angle = [0.0, 30.0, 45.0][random.below(3) as usize];
        let plan = SupportPlan::new(&settings);
        let area = blobs(&mut random, &plan);
        let has_room = |share: f64, part: &ExPolygon| {
            !inset(std::slice::from_ref(part), (share * plan.width) as i64).is_empty()
        };
        let half = and(&area, &block(-200, 200, (-90_000_000, 0)));
        let parts = [&area, &half, &sub(&area, &half)].map(|rows| outlines(rows, &plan.frame, 0.0)).concat();
        let thin = parts.iter().any(|part| !has_room(0.75, part));
        let kinds = [LayerKind::Columns, LayerKind::Branches, LayerKind::RaftBase, LayerKind::RaftInterface];
        for kind in kinds {
            for (base, interface) in [(area.clone(), Rows::default()), (Rows::default(), area.clone())] {
                let contact = and(&half, &interface);
                let layers = vec![SupportLayer { contact, ..layer(kind, base, interface) }; 3];
                for strands in strands(&layers, &plan) {
                    let off = outside(&strands, &area, &plan);
                    // Straightened outlines, and inset ones; where they are thin, in their middle.
                    let limit = if thin { 0.5 * plan.width } else { TOLERANCE + 30_000.0 };
                    assert!(off < limit, "seed {seed}, {kind:?}: {off}");
                    assert!(strands.iter().all(|s| s.points.len() > 1), "seed {seed}");
                    // Every part that has room for a line.
                    for part in outlines(&area, &plan.frame, 0.0) {
                        let own = scanned(std::slice::from_ref(&part), &plan.frame);
                        let is_in = |p: &Point2| {
                            let (s, t) = plan.frame.st(*p);
                            let k = plan.frame.nearest_row(t.into());
                            (k - 1..=k + 1).any(|k| own.row(k).iter().any(|x| x.start <= s && s < x.end))
                        };
                        let has = strands.iter().any(|s| s.points.iter().any(is_in));
                        assert!(has || !has_room(0.26, &part), "seed {seed}, {kind:?}: nothing in {part:?}");
                    }
                }
            }
        }
    }
}

/// A square of `side` \[mm\] about the middle.
fn square(side: f64, plan: &SupportPlan) -> Rows {
    let half = 0.5 * side * 1e6;
    let k = plan.frame.row_below(plan.frame.units(half));
    let s = plan.frame.units(half) as i32;
    block(-k, k + 1, (-s, s))
}

#[test]
fn lines_are_as_long_as_area_and_distance_say() {
    let mut settings = Settings::default();
    settings.support.support_material_interface_spacing = 0.2;
    for (angle, style) in [(0.0, SupportStyle::Grid), (30.0, SupportStyle::Grid), (0.0, SupportStyle::Snug)] {
        settings.support.support_material_angle = angle;
        settings.support.support_material_style = style;
        let plan = SupportPlan::new(&settings);
        let area = square(60.0, &plan);
        let mm2 = area.length() as f64 * plan.frame.mm2_per_unit();
        let close = |long: f64, pitch: f64, inside: f64| {
            // A line's ends are half its width inside, or beside the sheath.
            let wanted = (mm2.sqrt() - 2e-6 * inside).powi(2) / (pitch * 1e-6);
            assert!((long / wanted - 1.0).abs() < 0.02, "{long} for {wanted} at {angle}");
        };
        let base = vec![layer(LayerKind::Columns, area.clone(), Rows::default()); 2];
        let half = 0.5 * plan.width;
        let lines: Vec<Strand> = strands(&base, &plan).remove(1).into_iter().filter(|s| !s.closed).collect();
        close(along(&lines, angle), plan.cell, half + plan.spacing);
        assert!(along(&lines, angle + 90.0) < 0.1 * along(&lines, angle));
        let dense = vec![layer(LayerKind::Columns, Rows::default(), area.clone()); 2];
        let directions = match style {
            SupportStyle::Snug => [135.0, 45.0],
            _ => [angle + 90.0; 2],
        };
        for (strands, degrees) in strands(&dense, &plan).iter().zip(directions) {
            close(along(strands, degrees), plan.interface_pitch, half);
            assert!(strands.iter().all(|s| s.kind == StrandKind::Interface));
        }
        let first = SupportLayer { print_z: 200_000, height: 200_000, ..base[0].clone() };
        let first = strands(&[first], &plan).remove(0);
        assert_eq!(first.iter().filter(|s| s.closed).count(), 1);
        let lines: Vec<Strand> = first.into_iter().filter(|s| !s.closed).collect();
        close(
            along(&lines, angle + 90.0),
            plan.first_spacing / plan.first_density,
            0.5 * base::first_width(&plan) + plan.first_spacing,
        );
    }
}

#[test]
fn sheaths_are_closed_and_half_a_line_inside() {
    let mut settings = Settings::default();
    let area = square(20.0, &plan());
    let base = [layer(LayerKind::Columns, area, Rows::default())];
    let (with, side) = (strands(&base, &plan()).remove(0), length_of_side(&base[0].base));
    let sheaths: Vec<&Strand> = with.iter().filter(|s| s.closed).collect();
    assert_eq!((sheaths.len(), sheaths[0].points.len()), (1, 4));
    let wanted = 2.0 * (side[0] + side[1]) - 4.0 * plan().width * 1e-6;
    assert!((length(&with[1..]) - wanted).abs() < 1e-3, "{} for {wanted}", length(&with[1..]));
    settings.support.support_material_with_sheath = false;
    let without = strands(&base, &SupportPlan::new(&settings)).remove(0);
    assert!(without.iter().all(|s| !s.closed) && !without.is_empty());
}

/// Sides of a rectangle \[mm\]: along the rows, and across.
fn length_of_side(area: &Rows) -> [f64; 2] {
    let rows = f64::from(area.end() - area.first()) * plan().frame.pitch() as f64;
    [area.row(area.first())[0].length() as f64 * 1e-6, rows * 1e-6]
}

#[test]
fn branches_have_a_wall_and_thick_ones_two() {
    let plan = plan();
    let disc = |r: i64| dilate_disc(&block(0, 1, (0, 1_000)), r, |k| plan.frame.t(k));
    let round =
        |thick| SupportLayer { thick, ..layer(LayerKind::Branches, disc(3_000_000), Rows::default()) };
    let lengths = |l: SupportLayer| {
        strands(&[l], &plan).remove(0).iter().map(|s| length(std::slice::from_ref(s))).collect::<Vec<_>>()
    };
    let tau = std::f64::consts::TAU;
    let close = |long: &[f64], radii: &[f64]| {
        assert_eq!(long.len(), radii.len(), "{long:?}");
        for (l, r) in long.iter().zip(radii) {
            assert!((l / (tau * r) - 1.0).abs() < 0.03, "{l} for {}", tau * r);
        }
    };
    let first = 3.0 - 0.5e-6 * plan.width;
    close(&lengths(round(Rows::default())), &[first]);
    close(&lengths(round(disc(3_000_000))), &[first, first - 1e-6 * plan.spacing]);
    // A tip narrower than a line is a small loop.
    let tip = lengths(layer(LayerKind::Branches, disc(180_000), Rows::default()));
    assert!(tip.len() == 1 && tip[0] > 0.1, "{tip:?}");
}

#[test]
fn thin_strips_have_a_line_along_them() {
    let plan = plan();
    let strip = block(0, 3, (0, 9_000_000));
    for kind in [LayerKind::Columns, LayerKind::Branches, LayerKind::RaftInterface] {
        let strands = strands(&[layer(kind, strip.clone(), Rows::default())], &plan).remove(0);
        assert!(strands.len() == 1 && !strands[0].closed, "{strands:?}");
        let long = length(&strands);
        assert!((8.0..9.0).contains(&long), "{long}");
        assert!(outside(&strands, &strip, &plan) < 0.5 * plan.width);
    }
}

#[test]
fn equal_layers_share_their_lines_and_threads_do_not_matter() {
    let mut settings = Settings::default();
    let mut random = Random(77);
    for pattern in [SupportPattern::Rectilinear, SupportPattern::RectilinearGrid, SupportPattern::Honeycomb] {
        settings.support.support_material_pattern = pattern;
        settings.support.support_material_style = SupportStyle::Snug;
        let plan = SupportPlan::new(&settings);
        let [a, b] = [(); 2].map(|()| or(&blobs(&mut random, &plan), &square(6.0, &plan)));
        let layers: Vec<SupportLayer> = [&a, &a, &a, &a, &b, &a, &b, &a, &a]
            .iter()
            .map(|area| layer(LayerKind::Columns, (*area).clone(), and(area, &square(3.0, &plan))))
            .collect();
        let all = strands(&layers, &plan);
        // Each as if it were alone.
        for i in 0..layers.len() {
            let mut alone = vec![SupportLayer::default(); i];
            alone.push(layers[i].clone());
            assert_eq!(strands(&alone, &plan)[i], all[i], "layer {i}, {pattern:?}");
        }
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            assert_eq!(pool.install(|| strands(&layers, &plan)), all);
        }
        let turns = pattern != SupportPattern::Rectilinear;
        assert_eq!(all[1] != all[0], turns || settings.support.support_material_style == SupportStyle::Snug);
    }
}

#[test]
fn contact_loops_go_around_the_contact() {
    let mut settings = Settings::default();
    let area = square(12.0, &plan());
    let contact = and(&area, &block(-500, 500, (-90_000_000, 0)));
    let layers =
        [SupportLayer { contact: contact.clone(), ..layer(LayerKind::Columns, Rows::default(), area) }];
    assert!(strands(&layers, &plan()).remove(0).iter().all(|s| !s.closed));
    settings.support.support_material_interface_contact_loops = true;
    let looped = strands(&layers, &SupportPlan::new(&settings)).remove(0);
    let loops: Vec<Strand> = looped.iter().filter(|s| s.closed).cloned().collect();
    assert_eq!(loops.len(), 1);
    assert!(outside(&loops, &contact, &plan()) < 1_000.0);
}

#[test]
fn what_is_shrunk_on_rows_is_where_exact_insets_are() {
    let plan = plan();
    let (mut off, mut on_average, mut count) = (0f64, 0.0, 0.0);
    for seed in 1..40 {
        let mut random = Random(seed);
        for area in outlines(&blobs(&mut random, &plan), &plan.frame, 0.1) {
            let distance = random.within(100_000, 500_000);
            let exact = inset(std::slice::from_ref(&area), distance);
            let found = shrink::on_rows(&area, distance);
            let mm2 = |p: &[ExPolygon]| p.iter().map(ExPolygon::area_mm2).sum::<f64>();
            let around: f64 = exact
                .iter()
                .flat_map(|p| p.rings())
                .map(|r| length(&[Strand { points: r.clone(), closed: true, kind: StrandKind::Base }]))
                .sum();
            // Mean distance of the borders \[mm\]; corners are rounded where they were mitred.
            let by = (mm2(&found) - mm2(&exact)) / around.max(1.0);
            (off, on_average, count) = (off.max(by.abs()), on_average + by, count + 1.0);
        }
    }
    assert!(off < 0.03 && (on_average / count).abs() < 0.004, "{off}, {on_average} in {count}");
}

#[test]
fn strips_of_little_more_than_a_line_have_one() {
    let plan = plan();
    // 0.5 mm at lines of 0.4.
    let strip = block(0, 5, (0, 9_000_000));
    for kind in [LayerKind::Columns, LayerKind::Branches] {
        let strands = strands(&[layer(kind, strip.clone(), Rows::default())], &plan).remove(0);
        assert!(strands.len() == 1 && !strands[0].closed, "{strands:?}");
    }
    let wider = block(0, 8, (0, 9_000_000));
    let strands = strands(&[layer(LayerKind::Branches, wider, Rows::default())], &plan).remove(0);
    assert!(strands.len() == 1 && strands[0].closed, "{strands:?}");
}
