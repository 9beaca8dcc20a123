//! Random stacks: everything again by flood fill, for every layer from the plate up to it.

use super::*;
use crate::span::tests::Random;
use std::collections::BTreeSet;

type Voxel = [i32; 3];

/// A void as both sides tell it: fate, first and last layer, greatest area in pixels and its layer,
/// pixels, bounds.
type Told = (Fate, i32, i32, u64, i32, u64, [[i32; 2]; 2]);

struct Oracle<'a> {
    stack: &'a Stack,
    threshold: u8,
}

impl Oracle<'_> {
    fn size(&self) -> [i32; 2] {
        [self.stack.panel.width as i32, self.stack.panel.height as i32]
    }

    fn is_solid(&self, [x, y, z]: Voxel) -> bool {
        let [w, h] = self.size();
        x >= 0
            && y >= 0
            && x < w
            && y < h
            && self.stack.layers[z as usize][(y * w + x) as usize] >= self.threshold
    }

    fn plane(&self, z: i32) -> impl Iterator<Item = Voxel> {
        let [w, h] = self.size();
        (0..h).flat_map(move |y| (0..w).map(move |x| [x, y, z]))
    }

    fn flood(&self, from: Voxel, near: impl Fn(Voxel) -> Vec<Voxel>, solid: bool) -> BTreeSet<Voxel> {
        let [w, h] = self.size();
        let (mut found, mut open) = (BTreeSet::from([from]), vec![from]);
        while let Some(at) = open.pop() {
            for v in near(at) {
                let inside = v[0] >= 0 && v[1] >= 0 && v[0] < w && v[1] < h;
                if inside && self.is_solid(v) == solid && found.insert(v) {
                    open.push(v);
                }
            }
        }
        found
    }

    /// The sealed voids of layers 0..=top that have a part in layer `top`.
    fn sealed(&self, top: i32) -> BTreeSet<BTreeSet<Voxel>> {
        let near = |[x, y, z]: Voxel| {
            let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| [x + dx, y + dy, z]));
            around.chain([z - 1, z + 1].map(|z| [x, y, z])).filter(|v| v[2] >= 0 && v[2] <= top).collect()
        };
        let [w, h] = self.size();
        let mut found = BTreeSet::new();
        for at in self.plane(top).filter(|&v| !self.is_solid(v)) {
            let void = self.flood(at, near, false);
            if !void.iter().any(|v| v[0] == 0 || v[1] == 0 || v[0] == w - 1 || v[1] == h - 1) {
                found.insert(void);
            }
        }
        found
    }

    fn voids(&self) -> Vec<Told> {
        let tops: Vec<_> = (0..self.stack.layers.len() as i32).map(|top| self.sealed(top)).collect();
        let mut told = Vec::new();
        for (top, voids) in (0..).zip(&tops) {
            for void in voids {
                // What the same void is one layer on.
                let fate = match tops.get(top as usize + 1) {
                    None => Fate::Top,
                    Some(next) if next.iter().any(|v| v.is_superset(void)) => continue,
                    Some(_) => {
                        let goes_on =
                            void.iter().any(|&[x, y, z]| z == top && !self.is_solid([x, y, top + 1]));
                        if goes_on { Fate::Opened } else { Fate::Closed }
                    }
                };
                let first = void.iter().map(|v| v[2]).min().unwrap();
                let (mut greatest, mut greatest_at) = (0, 0);
                for (j, parts) in (0..=top).zip(&tops) {
                    for part in parts.iter().filter(|p| void.is_superset(p)) {
                        let area = part.iter().filter(|v| v[2] == j).count() as u64;
                        if area > greatest {
                            (greatest, greatest_at) = (area, j);
                        }
                    }
                }
                let mut bounds = [[i32::MAX; 2], [i32::MIN; 2]];
                for v in void {
                    for axis in 0..2 {
                        bounds[0][axis] = bounds[0][axis].min(v[axis]);
                        bounds[1][axis] = bounds[1][axis].max(v[axis] + 1);
                    }
                }
                told.push((fate, first, top, greatest, greatest_at, void.len() as u64, bounds));
            }
        }
        told.sort_unstable();
        told
    }

    /// Per layer: parts, most pixels in one, unsupported pixels, islands as sorted pixel counts, and
    /// pixels of sealed voids.
    fn layer(&self, z: i32, reach: i64) -> (u32, usize, usize, Vec<u64>, usize) {
        let near = |[x, y, z]: Voxel| vec![[x + 1, y, z], [x - 1, y, z], [x, y + 1, z], [x, y - 1, z]];
        let supported = |v: Voxel| {
            z == 0
                || self.plane(z - 1).any(|u| {
                    let dx = i64::from(u[0] - v[0]) * self.stack.panel.pitch_x;
                    let dy = i64::from(u[1] - v[1]) * self.stack.panel.pitch_y;
                    self.is_solid(u) && dx * dx + dy * dy <= reach * reach
                })
        };
        let solid: Vec<Voxel> = self.plane(z).filter(|&v| self.is_solid(v)).collect();
        let parts: BTreeSet<BTreeSet<Voxel>> = solid.iter().map(|&v| self.flood(v, near, true)).collect();
        let islands = parts.iter().filter(|p| !p.iter().any(|&v| supported(v)));
        let mut islands: Vec<u64> = islands.map(|p| p.len() as u64).collect();
        islands.sort_unstable();
        let sealed = self.sealed(z).iter().flatten().filter(|v| v[2] == z).count();
        let most = parts.iter().map(BTreeSet::len).max().unwrap_or(0);
        (parts.len() as u32, most, solid.iter().filter(|&&v| !supported(v)).count(), islands, sealed)
    }
}

fn told(findings: &Findings, panel: &Panel) -> Vec<Told> {
    let count = |mm2: f64| (mm2 / panel.pixel_mm2()).round() as u64;
    let mut told: Vec<Told> = (findings.cups.listed.iter().chain(&findings.trapped.listed))
        .map(|v| {
            let pixels = count(v.volume_ml * 1e3 / HEIGHT);
            let [x0, y0, x1, y1] = v.bounds_mm;
            let [_, up] = panel.image_nm().map(|nm| nm as f64 * 1e-6);
            let x = [x0, x1].map(|x| (x / (panel.pitch_x as f64 * 1e-6)).round() as i32);
            let y = [up - y1, up - y0].map(|y| (y / (panel.pitch_y as f64 * 1e-6)).round() as i32);
            let layers = (v.first_layer as i32, v.last_layer as i32);
            assert!((v.z_mm[0] - f64::from(v.first_layer) * HEIGHT).abs() < 1e-9);
            assert!((v.z_mm[1] - f64::from(v.last_layer + 1) * HEIGHT).abs() < 1e-9);
            let bounds = [[x[0], y[0]], [x[1], y[1]]];
            let greatest = (count(v.greatest_area_mm2), v.greatest_layer as i32);
            (v.fate, layers.0, layers.1, greatest.0, greatest.1, pixels, bounds)
        })
        .collect();
    told.sort_unstable();
    told
}

/// Panics where the checker and the search disagree.
fn compare(seed: u64, searched: &Stack, checked: &Stack, batch: usize, settings: CheckSettings) {
    let findings = checked.check(settings, batch);
    let panel = &checked.panel;
    let oracle = Oracle { stack: searched, threshold: settings.threshold };
    assert_eq!(told(&findings, panel), oracle.voids(), "voids, seed {seed}");
    let reach = (settings.reach_mm * 1e6).round() as i64;
    let count = |mm2: f64| (mm2 / panel.pixel_mm2()).round() as usize;
    for (z, figures) in findings.layers.iter().enumerate() {
        let of_layer = findings.islands.listed.iter().filter(|i| i.layer as usize == z);
        let mut islands: Vec<u64> = of_layer.map(|i| i.pixels).collect();
        islands.sort_unstable();
        assert_eq!(figures.islands as usize, islands.len());
        let told = (
            figures.parts,
            count(figures.largest_part_mm2),
            count(figures.overhang_mm2),
            islands,
            count(figures.sealed_mm2),
        );
        assert_eq!(told, oracle.layer(z as i32, reach), "seed {seed}, layer {z}");
        let solid = checked.layers[z].iter().filter(|&&g| g >= settings.threshold).count();
        assert_eq!(count(figures.peel_mm2), solid + told.4, "seed {seed}, layer {z}");
    }
}

/// Random blobs: each layer mostly like the one before, some equal to it.
fn random_stack(random: &mut Random) -> Stack {
    let (w, h) = (random.within(3, 11) as u32, random.within(3, 9) as u32);
    let layers = random.within(1, 10) as u32;
    let (dense, change) = (random.within(55, 99) as u64, random.within(3, 35) as u64);
    let mut stack = Stack { panel: panel(w, h), layers: Vec::new() };
    for z in 0..layers as usize {
        let keep = z > 0 && random.below(5) == 0;
        let image = (0..(w * h) as usize).map(|i| {
            if z > 0 && (keep || random.below(100) >= change) {
                return stack.layers[z - 1][i];
            }
            if random.below(100) < dense { random.within(60, 256) as u8 } else { 0 }
        });
        let image = image.collect();
        stack.layers.push(image);
    }
    stack
}

#[test]
fn random_stacks_equal_a_search_by_flood_fill() {
    let mut seen = [0usize; 4];
    for seed in 0..250 {
        let mut random = Random(seed * 104_729 + 1);
        let stack = random_stack(&mut random);
        let reach_mm = [0.0, 0.03, 0.05, 0.06, 0.11][random.below(5) as usize];
        let settings = CheckSettings { threshold: random.within(1, 200) as u8, reach_mm, listed: 1000 };
        compare(seed, &stack, &stack, 1 + random.below(4) as usize, settings);
        let findings = stack.check(settings, 3);
        for void in findings.cups.listed.iter().chain(&findings.trapped.listed) {
            seen[void.fate as usize] += 1;
            let parts =
                LayerParts::of(&stack.mask(void.greatest_layer as usize), &stack.panel, settings.threshold);
            let pixels = |wanted: &dyn Fn(u32) -> bool| {
                let sealed = void.marks.sealed.iter().filter(|(_, number)| wanted(*number));
                sealed.map(|(hole, _)| parts.holes[*hole as usize].pixels as f64).sum::<f64>()
            };
            // Marks hold all sealed holes of the layer, and know which are to be trapped.
            let area = findings.layers[void.greatest_layer as usize].sealed_mm2;
            assert!((pixels(&|_| true) * stack.panel.pixel_mm2() - area).abs() < 1e-9, "seed {seed}");
            let trapped = void.fate == Fate::Closed;
            let alike = pixels(&|n| findings.fates.is_trapped(n) == trapped);
            assert!(alike * stack.panel.pixel_mm2() > void.greatest_area_mm2 - 1e-9, "seed {seed}");
        }
        seen[3] += findings.islands.count as usize;
    }
    assert!(seen.iter().all(|&n| n >= 10), "{seen:?} voids of each fate and islands are too few");
}

#[test]
#[should_panic(expected = "seed 1")]
fn the_comparison_can_fail() {
    let grey = |x, y, z| if [x, y, z] == [3, 3, 1] { 0 } else { 255 };
    let hollow = Stack::new(panel(7, 7), 3, grey);
    let full = Stack::new(panel(7, 7), 3, |_, _, _| 255);
    compare(1, &hollow, &full, 2, CheckSettings::default());
}
