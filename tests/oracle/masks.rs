//! Masks against every pixel × every edge of the contours.

use super::bodies::{self, Random};
use super::{Case, FLAT, RAW, clusters, manifolds};
use microtome::lattice::{LIMIT, Point2, area2};
use microtome::mask::{MaskLayer, Painter, Panel, Raster, Shading, layers};
use microtome::slice::section::Sections;
use microtome::span::{EdgeScan, scan};
use std::sync::Arc;

/// A panel a little larger than a body, with the body's frame somewhere on it.
fn around(case: &Case, seed: u64) -> (Panel, [i64; 2]) {
    let mut random = Random::new(seed);
    let [lo, hi] = case.mesh.bounds().unwrap_or_default();
    let (lo, hi) = ([lo.x, lo.y].map(i64::from), [hi.x, hi.y].map(i64::from));
    let portrait = random.below(2) == 1;
    let (along, across) = if portrait { (1, 0) } else { (0, 1) };
    let mut pitch = |axis: usize| {
        let cells = 9 + random.below(30) as i64;
        ((hi[axis] - lo[axis]) / cells).clamp(1000, 1 << 22) + random.below(2) as i64
    };
    let (pitch_x, pitch_y) = (pitch(along).min(1 << 22), pitch(across).min(1 << 22));
    let pixels = |axis: usize, pitch: i64| ((hi[axis] - lo[axis]) / pitch).clamp(0, 40) as u32 + 3;
    let panel = Panel {
        width: pixels(along, pitch_x),
        height: pixels(across, pitch_y),
        pitch_x,
        pitch_y,
        mirror_x: random.below(2) == 1,
        mirror_y: random.below(2) == 1,
        portrait,
    };
    let mut origin = [pitch_x, pitch_y];
    if portrait {
        origin.reverse();
    }
    for axis in 0..2 {
        origin[axis] -= lo[axis];
        // Sometimes such that borders pass through centres of pixels, or the body reaches over the edge.
        origin[axis] += [0, 1, 500, origin[axis] / 3][random.below(4) as usize];
    }
    (panel, origin)
}

/// A pixel's centre along and across its row, or a sub-row's position, as the documentation of the panel
/// has it, in the frame of the mesh.
struct Place {
    panel: Panel,
    origin: [i64; 2],
    sub_rows: i64,
}

impl Place {
    /// Middle of the pixel in a column of the image, s.
    fn left(&self, column: u32) -> i64 {
        let Panel { width, pitch_x, mirror_x, portrait, .. } = self.panel;
        let i = if mirror_x { width - 1 - column } else { column };
        i64::from(i) * pitch_x - self.origin[usize::from(portrait)]
    }

    /// A sub-row of a row of the image, t.
    fn across(&self, row: u32, sub: i64) -> i64 {
        let Panel { height, pitch_y, mirror_y, portrait, .. } = self.panel;
        let from_low = i64::from(if mirror_y { row } else { height - 1 - row });
        let middle = |steps: i64| (steps as f64 * pitch_y as f64 / (2 * self.sub_rows) as f64 + 0.5).floor();
        if portrait {
            // t = -x, so strips count down from the greatest x, and so do halves.
            let from_high = i64::from(height) - 1 - from_low;
            let x = i64::from(height) * pitch_y - from_high * pitch_y - middle(2 * sub + 1) as i64;
            -(x - self.origin[0])
        } else {
            from_low * pitch_y + middle(2 * sub + 1) as i64 - self.origin[1]
        }
    }

    fn st(&self, p: Point2) -> [i128; 2] {
        let (x, y) = (i128::from(p.x), i128::from(p.y));
        if self.panel.portrait { [y, -x] } else { [x, y] }
    }

    /// Crossings of a row: position rounded to nearest, halves up, and direction.
    fn crossings(&self, rings: &[Vec<Point2>], t: i64) -> Vec<(i64, i32)> {
        let t = i128::from(t);
        let edges = rings.iter().flat_map(|r| (0..r.len()).map(|i| (r[i], r[(i + 1) % r.len()])));
        edges
            .filter_map(|(a, b)| {
                let ([s0, t0], [s1, t1]) = (self.st(a), self.st(b));
                let up = t0 < t && t <= t1;
                let down = t1 < t && t <= t0;
                (up || down).then(|| {
                    let (num, den) = ((s1 - s0) * (t - t0), t1 - t0);
                    let (num, den) = if den < 0 { (-num, -den) } else { (num, den) };
                    ((s0 + (2 * num + den).div_euclid(2 * den)) as i64, if up { 1 } else { -1 })
                })
            })
            .collect()
    }

    /// The image, pixel by pixel.
    fn image(&self, rings: &[Vec<Point2>], shading: &Shading) -> Vec<u8> {
        let table = shading.table();
        let Panel { width, height, pitch_x, .. } = self.panel;
        let mut image = Vec::new();
        for row in 0..height {
            let subs: Vec<_> =
                (0..self.sub_rows).map(|j| self.crossings(rings, self.across(row, j))).collect();
            for column in 0..width {
                let left = self.left(column);
                let winding = |sub: &[(i64, i32)], s: i64| {
                    sub.iter().filter(|c| c.0 <= s).map(|c| c.1).sum::<i32>() != 0
                };
                if self.sub_rows == 1 {
                    let lit = winding(&subs[0], left + (pitch_x + 1) / 2);
                    image.push(if lit { 255 } else { 0 });
                    continue;
                }
                let mut covered = 0;
                for sub in &subs {
                    // Winding is constant between neighbouring cuts.
                    let mut cuts: Vec<i64> = sub.iter().map(|c| c.0.clamp(left, left + pitch_x)).collect();
                    cuts.extend([left, left + pitch_x]);
                    cuts.sort_unstable();
                    covered +=
                        cuts.windows(2).filter(|w| winding(sub, w[0])).map(|w| w[1] - w[0]).sum::<i64>();
                }
                let full = self.sub_rows * pitch_x;
                image.push(table[((510 * covered + full) / (2 * full)) as usize]);
            }
        }
        image
    }
}

fn pixels(mask: &MaskLayer, panel: &Panel) -> Vec<u8> {
    mask.lengths(panel.pixels()).flat_map(|(n, grey)| std::iter::repeat_n(grey, n as usize)).collect()
}

/// Planes enough to be quick.
fn thinned(mut case: Case, most: usize) -> Case {
    let step = case.planes.len().div_ceil(most).max(1);
    case.planes = case.planes.iter().copied().step_by(step).collect();
    case
}

fn bodies_to_draw() -> impl Iterator<Item = Case> {
    manifolds().into_iter().chain(clusters()).filter(|c| !c.mesh.triangles.is_empty()).map(|c| thinned(c, 9))
}

#[test]
fn masks_are_those_of_the_oracle() {
    let (mut lit, mut grey) = (0, 0);
    for (i, case) in bodies_to_draw().enumerate() {
        for sub_rows in [1, [2, 4, 8, 16][i % 4]] {
            let (panel, origin) = around(&case, i as u64);
            let shading = Shading { sub_rows, gamma: [1.0, 0.6, 0.0][i % 3], minimum_grey: [0, 40][i % 2] };
            let raster = Raster::new(panel, origin, &shading).unwrap();
            let place = Place { panel, origin, sub_rows: sub_rows.into() };
            let sections = Sections::new(&case.mesh, &case.planes, 1 + i % 3).unwrap();
            let drawn: Vec<_> =
                (0..sections.runs().len()).flat_map(|r| layers(&sections, r, &raster)).collect();
            let contours = case.trace(&RAW);
            assert_eq!(drawn.len(), contours.len());
            for (k, (mask, contours)) in drawn.iter().zip(&contours).enumerate() {
                let expected = place.image(&contours.rings, &shading);
                let (lit_here, image) = (mask.lit(), pixels(mask, &panel));
                assert!(image == expected, "{}, plane {k}: {panel:?} {origin:?} {shading:?}", case.name);
                assert_eq!(lit_here, expected.iter().filter(|&&v| v > 0).count() as u64);
                lit += lit_here;
                grey += expected.iter().filter(|&&v| v > 0 && v < 255).count();
                // The rings' spans give the same mask as the edges.
                let rows = scan(contours.rings.iter().map(|r| &r[..]), raster.frame());
                assert_eq!(raster.mask(&rows), **mask, "{}, plane {k}", case.name);
            }
        }
    }
    assert!(lit > 50_000 && grey > 5_000, "{lit} {grey}");
}

#[test]
fn a_moved_edge_or_a_lost_one_is_noticed() {
    let case = Case::new("torus", &bodies::torus(9e6, 3e6, 20), vec![1_234_567]);
    let (panel, origin) = around(&case, 3);
    let rings = case.trace(&RAW).remove(0).rings;
    for sub_rows in [1, 4] {
        let shading = Shading { sub_rows, ..Shading::default() };
        let raster = Raster::new(panel, origin, &shading).unwrap();
        let expected = Place { panel, origin, sub_rows: sub_rows.into() }.image(&rings, &shading);
        let sections = Sections::new(&case.mesh, &case.planes, 1).unwrap();
        let edges = sections.sweep(0).next_section().unwrap().edges.to_vec();
        let mut painter = Painter::new(&raster);
        let mut same = |edges: &[[Point2; 2]]| pixels(&painter.mask(edges), &panel) == expected;
        assert!(same(&edges));
        let lost = edges.iter().position(|e| e[0].y.abs_diff(e[1].y) > 500_000).unwrap();
        let mut broken = edges.clone();
        broken.remove(lost);
        assert!(!same(&broken));
        let moved: Vec<_> =
            edges.iter().map(|e| e.map(|p| Point2::new(p.x + panel.pitch_x as i32, p.y))).collect();
        assert!(!same(&moved));
        let lowered: Vec<_> =
            edges.iter().map(|e| e.map(|p| Point2::new(p.x, p.y - panel.pitch_y as i32))).collect();
        assert!(!same(&lowered));
    }
}

#[test]
fn grey_areas_are_those_of_the_contours() {
    for case in [
        Case::new("sphere", &bodies::sphere(7e6, 48), super::steps(-6_500_000, 6_500_000, 500_000)),
        Case::new("torus", &bodies::torus(9e6, 3e6, 40), super::steps(-2_800_000, 2_800_000, 400_000)),
    ] {
        for sub_rows in [4, 8, 16] {
            let panel = Panel {
                width: 1000,
                height: 1100,
                pitch_x: 28_501,
                pitch_y: 24_001,
                mirror_x: false,
                mirror_y: false,
                portrait: sub_rows == 8,
            };
            let [x, y] = panel.plate();
            let shading = Shading { sub_rows, ..Shading::default() };
            let raster = Raster::new(panel, [x / 2, y / 2], &shading).unwrap();
            let sections = Sections::new(&case.mesh, &case.planes, 2).unwrap();
            let masks = (0..sections.runs().len()).flat_map(|r| layers(&sections, r, &raster));
            for (k, (mask, contours)) in masks.zip(case.trace(&FLAT)).enumerate() {
                let exact = contours.rings.iter().map(|r| area2(r)).sum::<i128>() as f64 / 2e12;
                // The torus is inside out, which the non-zero rule does not mind.
                let exact = exact.abs();
                let error = (mask.area() * panel.pixel_mm2() / exact - 1.0).abs();
                assert!(error < 0.001, "{}, plane {k}, {sub_rows} sub-rows: {error}", case.name);
            }
        }
    }
}

#[test]
fn edges_in_any_runs_are_the_segments_of_the_oracle() {
    for case in manifolds().into_iter().chain(clusters()) {
        for runs in [1, 3, 100] {
            let sections = Sections::new(&case.mesh, &case.planes, runs).unwrap();
            assert!(sections.runs().iter().map(|r| r.len()).sum::<usize>() == case.planes.len());
            for r in 0..sections.runs().len() {
                let mut sweep = sections.sweep(r);
                while let Some(section) = sweep.next_section() {
                    if section.unchanged {
                        continue;
                    }
                    let z = case.planes[section.plane];
                    let mut edges: Vec<_> =
                        section.edges.iter().filter(|e| e[0] != e[1]).map(|e| (e[0], e[1])).collect();
                    edges.sort();
                    let expected = super::stupid::segments(&case.mesh, z);
                    assert!(edges == expected, "{}, plane {}, {runs} runs", case.name, section.plane);
                }
            }
        }
    }
}

#[test]
fn a_section_that_is_unchanged_covers_the_same_area() {
    let mut random = Random::new(5);
    let mut unchanged = 0;
    for case in 0..40 {
        let mut soup = Vec::new();
        for _ in 0..1 + random.below(6) {
            let mut p = || [0; 3].map(|_| 500_000 * random.within(10));
            let (a, b) = (p(), p());
            let corner = |i: usize| [a[i].min(b[i]), a[i].max(b[i]) + 1_234_567];
            let [[x0, x1], [y0, y1], [z0, z1]] = [corner(0), corner(1), corner(2)];
            let low = microtome::lattice::Point3::new(x0, y0, z0);
            soup.extend(bodies::cuboid(low, microtome::lattice::Point3::new(x1, y1, z1)));
        }
        if case % 4 == 3 {
            // A hole: its border moves from plane to plane.
            soup.remove(random.below(soup.len() as u64) as usize);
        }
        let case = Case::new(format!("boxes {case}"), &soup, super::steps(-5_900_000, 6_900_000, 100_000));
        let sections = Sections::new(&case.mesh, &case.planes, 1).unwrap();
        let mut sweep = sections.sweep(0);
        let mut scans = [microtome::span::Axis::X, microtome::span::Axis::Y]
            .map(|axis| EdgeScan::new(&microtome::span::RowFrame::strips(axis, 7, 300_000, 4)));
        while let Some(section) = sweep.next_section() {
            let edges: Vec<_> = super::stupid::segments(&case.mesh, case.planes[section.plane])
                .into_iter()
                .map(|(a, b)| [a, b])
                .collect();
            unchanged += i32::from(section.unchanged);
            for scan in &mut scans {
                let (got, expected) = (scan.scan(section.edges), scan.scan(&edges));
                assert_eq!(got, expected, "{}, plane {}", case.name, section.plane);
            }
        }
    }
    assert!(unchanged > 1000, "{unchanged}");
}

#[test]
fn equal_layers_are_shared_and_the_corners_of_the_lattice_are_safe() {
    let m = LIMIT - 1;
    let p = microtome::lattice::Point3::new;
    let case =
        Case::new("largest box", &bodies::cuboid(p(-m, -m, -m), p(m, m, m)), vec![-LIMIT, -m, 1 - m, 0, m]);
    let panel = Panel {
        width: 400,
        height: 300,
        pitch_x: 1 << 22,
        pitch_y: 1 << 22,
        mirror_x: false,
        mirror_y: false,
        portrait: false,
    };
    let raster = Raster::new(panel, [0, 0], &Shading::default()).unwrap();
    let sections = Sections::new(&case.mesh, &case.planes, 1).unwrap();
    let drawn: Vec<_> = layers(&sections, 0, &raster).collect();
    assert!(Arc::ptr_eq(&drawn[0], &drawn[1]) && drawn[0].runs.is_empty());
    assert!(Arc::ptr_eq(&drawn[2], &drawn[3]) && Arc::ptr_eq(&drawn[3], &drawn[4]));
    assert_eq!(drawn[2].lit(), 256 * 256);
}
