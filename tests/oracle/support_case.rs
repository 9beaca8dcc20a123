//! Random bodies that need supports, random ways to support them, and what must be true of the result.

use super::bodies::Random;
use microtome::job::backend::{Backend, BackendOptions};
use microtome::job::filament::{self, FilamentJob, Planned};
use microtome::job::part::MeshOptions;
use microtome::job::progress::Silent;
use microtome::job::summary::Stopwatch;
use microtome::job::support_report::SupportWish;
use microtome::job::supports::Supports;
use microtome::lattice::{Point2, nm};
use microtome::mesh::{Loaded, Mesh, Placement, shapes};
use microtome::path::{LayerPlan, Planner, PrintLayer, Role};
use microtome::settings::{FloatOrPercent, InterfacePattern, Settings, SupportPattern, SupportStyle};
use microtome::span::Rows;
use microtome::span::algebra::{and, sub};
use microtome::support::SupportPlan;
use microtome::support::check::{Ground, InAir, Print, Rule, What, clashes, cramped, hanging, in_air};

/// Patches smaller than this are the rows' \[mm²\]: a line's width square.
const PATCH: f64 = 0.2;

/// So are stretches of line shorter than this \[mm\].
const STRETCH: f64 = 0.4;

/// A body and how to support it.
pub struct Case {
    pub name: String,
    pub mesh: Mesh,
    pub settings: Settings,
}

/// What is wrong with a print.
#[derive(Debug, Default)]
pub struct Faults {
    /// Area of the part in air \[mm²\], with its largest piece.
    pub part: [f64; 2],
    /// The same of supports.
    pub supports: [f64; 2],
    /// Length of lines of the part in air \[mm\], with its longest.
    pub part_lines: [f64; 2],
    /// The same of supports' lines.
    pub support_lines: [f64; 2],
    /// Supports too near to the part, or in it \[mm²\].
    pub clash: f64,
    /// Areas of supports that overlap \[mm²\].
    pub overlap: f64,
    /// The first fault in words.
    pub first: String,
    /// Layers of supports that were looked at.
    pub layers: usize,
}

impl Faults {
    pub fn any(&self) -> bool {
        self.part[1] > PATCH
            || self.supports[1] > PATCH
            || self.part_lines[1] > STRETCH
            || self.support_lines[1] > STRETCH
            || self.clash > PATCH
            || self.overlap > 1e-6
    }

    fn note(&mut self, text: impl FnOnce() -> String) {
        if self.first.is_empty() {
            self.first = text();
        }
    }
}

fn base() -> Settings {
    let mut s = Settings::default();
    s.slicing.layer_height = 0.3;
    s.slicing.first_layer_height = FloatOrPercent::Float(0.3);
    s.infill.fill_density = 15.0;
    s.perimeters.perimeters = 2;
    s.support.support_material = true;
    s.support.support_material_threshold = 45.0;
    s.support.dont_support_bridges = false;
    s
}

/// The style alone, everything else plain.
pub fn plain(style: SupportStyle) -> Settings {
    let mut s = base();
    s.support.support_material_style = style;
    s
}

impl Case {
    pub fn random(seed: u64) -> Self {
        let mut random = Random::new(seed);
        for _ in 0..9 {
            random.below(2);
        }
        let mut s = base();
        let pick = |random: &mut Random, values: &[f64]| values[random.below(values.len() as u64) as usize];
        let layer = pick(&mut random, &[0.2, 0.3, 0.3]);
        s.slicing.layer_height = layer;
        s.slicing.first_layer_height = FloatOrPercent::Float(pick(&mut random, &[0.2, 0.3]));
        let own = &mut s.support;
        own.support_material_style =
            [SupportStyle::Grid, SupportStyle::Snug, SupportStyle::Organic][seed as usize % 3];
        own.support_material_threshold = pick(&mut random, &[0.0, 30.0, 45.0, 50.0, 60.0]);
        own.support_material_contact_distance = pick(&mut random, &[0.0, 0.1, 0.2, 0.2]);
        own.support_material_bottom_contact_distance = pick(&mut random, &[0.0, 0.1, 0.3]);
        own.support_material_xy_spacing = match random.below(3) {
            0 => FloatOrPercent::Percent(50.0),
            1 => FloatOrPercent::Float(0.4),
            _ => FloatOrPercent::Float(0.8),
        };
        own.support_material_synchronize_layers = random.below(3) == 0;
        own.support_material_pattern =
            [SupportPattern::Rectilinear, SupportPattern::RectilinearGrid, SupportPattern::Honeycomb]
                [random.below(3) as usize];
        own.support_material_interface_pattern =
            [InterfacePattern::Auto, InterfacePattern::Rectilinear, InterfacePattern::Concentric]
                [random.below(3) as usize];
        own.support_material_interface_layers = random.below(4) as u32;
        own.support_material_angle = pick(&mut random, &[0.0, 0.0, 45.0, 90.0, 30.0]);
        own.support_material_spacing = pick(&mut random, &[1.0, 2.5]);
        own.support_material_with_sheath = random.below(2) == 0;
        own.dont_support_bridges = random.below(2) == 0;
        s.infill.thick_bridges = random.below(2) == 0;
        if random.below(5) == 0 {
            s.adhesion.raft_layers = 1 + random.below(3) as u32;
        }
        let mesh = body(&mut random);
        let own = &s.support;
        let name = format!(
            "seed {seed}: {:?}, layers {layer}, threshold {}, gaps {} {} {:?}, synchronized {}, {:?}, interface {} {:?}, angle {}, spacing {}, spare bridges {}, thick {}, raft {}",
            own.support_material_style,
            own.support_material_threshold,
            own.support_material_contact_distance,
            own.support_material_bottom_contact_distance,
            own.support_material_xy_spacing,
            own.support_material_synchronize_layers,
            own.support_material_pattern,
            own.support_material_interface_layers,
            own.support_material_interface_pattern,
            own.support_material_angle,
            own.support_material_spacing,
            own.dont_support_bridges,
            s.infill.thick_bridges,
            s.adhesion.raft_layers,
        );
        Self { name, mesh, settings: s }
    }

    /// Slices it as a job does, supports included.
    pub fn made(&self) -> (Planned, Supports) {
        let job = FilamentJob {
            settings: &self.settings,
            placement: Placement::DropAndCentre,
            mesh: MeshOptions::default(),
            backend: BackendOptions::new(Backend::Cpu, None, None),
            stem: "part".to_owned(),
            date: 0,
            modifiers: Default::default(),
            copies: 1,
        };
        let facets = self.mesh.triangles.len() as u64;
        let loaded = Loaded { mesh: self.mesh.clone(), facets, collapsed: 0, warnings: Vec::new() };
        let wish = SupportWish { areas: true, ..SupportWish::default() };
        let mut planned =
            filament::plan_mesh_with(loaded, "the part", &job, wish, &Silent, Stopwatch::default()).unwrap();
        let supports = std::mem::take(&mut planned.supports).areas.unwrap();
        (planned, supports)
    }
}

/// Overlapping shells: what they cover together is the body.
fn body(random: &mut Random) -> Mesh {
    let mut c = |from: f64, to: f64| from + (to - from) * random.below(1000) as f64 / 1000.0;
    let mut parts = Vec::new();
    // Something to stand on.
    let (w, d) = (c(3.0, 12.0), c(3.0, 12.0));
    parts.push(shapes::cuboid([0.0, 0.0, 0.0], [w, d, c(2.0, 14.0)]));
    for _ in 0..(c(1.0, 5.0) as usize) {
        let (x, y, z) = (c(-8.0, 12.0), c(-8.0, 12.0), c(0.0, 14.0));
        let (w, d, h) = (c(1.5, 14.0), c(1.5, 14.0), c(0.8, 6.0));
        let part = match c(0.0, 9.0) as u32 {
            0 | 1 => shapes::cuboid([x, y, z], [x + w, y + d, z + h]),
            2 => shapes::moved(shapes::sphere(0.5 * w.min(8.0), 24, 12), [x, y, z]),
            3 => shapes::moved(shapes::cone(0.6 * w, h, 20), [x, y, z]),
            4 => shapes::moved(shapes::cone_down(0.8, 0.6 * w, h, 20), [x, y, z]),
            5 => {
                let (lo, hi) = ([x, y], [x + w.max(4.0), y + d.max(4.0)]);
                let middle = [0.5 * (lo[0] + hi[0]), 0.5 * (lo[1] + hi[1])];
                shapes::holed_plate(lo, hi, middle, c(0.5, 1.8), 16, [z, z + h])
            }
            6 => {
                // A star.
                let corners = 5 + c(0.0, 7.0) as usize;
                let outline: Vec<[f64; 2]> = (0..corners)
                    .map(|i| {
                        let turn = i as f64 / corners as f64 * std::f64::consts::TAU;
                        let r = 0.5 * w * c(0.4, 1.0);
                        [x + r * turn.cos(), y + r * turn.sin()]
                    })
                    .collect();
                shapes::prism(&outline, z, z + h)
            }
            // Bars that lean over.
            _ => leaning(
                shapes::cuboid([x, y, z], [x + 2.0, y + 2.0, z + 2.0 * h]),
                [c(-1.8, 1.8), c(-1.8, 1.8)],
            ),
        };
        parts.push(part);
    }
    shapes::merge(&parts)
}

/// Moved sideways by so much for each mm of height above its own lowest point.
fn leaning(mut mesh: Mesh, by: [f64; 2]) -> Mesh {
    let low = mesh.vertices.iter().map(|v| v.z).min().unwrap_or(0);
    for v in &mut mesh.vertices {
        let rise = f64::from(v.z - low);
        (v.x, v.y) = (v.x + (rise * by[0]) as i32, v.y + (rise * by[1]) as i32);
    }
    mesh
}

/// What is wrong with supports: areas, distances, and, where layers are given, every line of them.
pub fn faults(layers: &[PrintLayer], supports: &Supports, settings: &Settings) -> Faults {
    let mut faults = Faults::default();
    let Some(rows) = &supports.rows else { return faults };
    let print = Print { part: rows.part(), overhangs: &supports.overhangs, supports: &supports.layers };
    let rule = Rule::new(settings, &SupportPlan::new(settings));
    for mut found in in_air(&print, &rule) {
        if let What::Part(i) = found.what {
            // Where the gaps that were asked for leave no room, nothing can be held.
            let area = sub(&found.area, &cramped(&print, i, &rule, &found.area));
            let mm2 = |area: &Rows| area.length() as f64 * rows.frame.mm2_per_unit();
            found.largest_mm2 = found.largest_mm2.min(mm2(&area));
            found.mm2 = mm2(&area);
        }
        let own = match found.what {
            What::Part(_) => &mut faults.part,
            What::Support(_) => &mut faults.supports,
        };
        *own = [own[0] + found.mm2, own[1].max(found.largest_mm2)];
        if found.largest_mm2 > PATCH {
            let InAir { what, mm2, largest_mm2, place, z, .. } = found;
            faults.note(|| {
                format!("{what:?} in air: {mm2:.2} mm2, {largest_mm2:.2} in one at {place:?}, z {z}")
            });
        }
    }
    for clash in clashes(&print, &rule) {
        faults.clash += clash.mm2;
        if faults.clash > PATCH {
            faults.note(|| {
                let (kind, side) = (supports.layers[clash.layer].kind, clash.side);
                format!(
                    "{kind:?} {} {side:?}: {:.2} mm2 at {:?}, z {}",
                    clash.layer, clash.mm2, clash.place, clash.z
                )
            });
        }
    }
    for (j, layer) in supports.layers.iter().enumerate() {
        faults.layers += 1;
        let areas = [&layer.base, &layer.interface, &layer.bottom_interface];
        for (a, b) in [(0, 1), (0, 2), (1, 2)] {
            let common = and(areas[a], areas[b]).length() as f64 * rows.frame.mm2_per_unit();
            faults.overlap += common;
            if common > 1e-6 {
                faults.note(|| format!("areas {a} and {b} of support layer {j} overlap by {common} mm2"));
            }
        }
        if layer.height <= 0 || j > 0 && supports.layers[j - 1].print_z > layer.print_z {
            faults.overlap += 1.0;
            faults.note(|| format!("support layer {j} is {} thick or out of order", layer.height));
        }
    }
    lines(layers, supports, &print, &rule, settings, &mut faults);
    faults
}

/// Every extruded line of the layers.
fn lines(
    layers: &[PrintLayer],
    supports: &Supports,
    print: &Print,
    rule: &Rule,
    settings: &Settings,
    faults: &mut Faults,
) {
    let mut planner = Planner::new(Point2::new(0, 0), settings);
    let mut plan = LayerPlan::default();
    let mut beside = supports.layers.iter().enumerate().zip(&supports.strands).filter(|(_, s)| !s.is_empty());
    for layer in layers {
        planner.layer(layer, &mut plan);
        let part = print.part.levels.iter().position(|l| l.top == i64::from(layer.z.print_z));
        let own = part.map(|i| {
            let mut ground = Ground::of_part(print, i, rule);
            ground.add(&cramped(print, i, rule, &print.part.outlines[i]));
            ground
        });
        let below = if layer.supports.is_empty() { None } else { beside.next() };
        let under = below.map(|((j, _), _)| Ground::of_support(print, j, rule));
        for (role, line) in joined(&plan) {
            let is_support = matches!(role, Role::SupportMaterial | Role::SupportInterface);
            // Skirt and brim lie on the bed, or on themselves.
            let Some(ground) = (match role {
                Role::Skirt => continue,
                _ if is_support => &under,
                _ => &own,
            }) else {
                panic!("{role:?} at {} belongs to no layer", layer.z.print_z);
            };
            for h in hanging(&line, ground, rule.straight) {
                let mm = h.length * 1e-6;
                let sum = if is_support { &mut faults.support_lines } else { &mut faults.part_lines };
                *sum = [sum[0] + mm, sum[1].max(mm)];
                if mm > STRETCH {
                    faults.note(|| format!("{role:?} in air at z {}: {h:?}", layer.z.print_z));
                }
            }
        }
    }
    assert!(beside.next().is_none(), "supports that are not in the print");
}

/// Extrusions that follow each other without a travel are one line.
fn joined(plan: &LayerPlan) -> Vec<(Role, Vec<Point2>)> {
    let is_support = |role| matches!(role, Role::SupportMaterial | Role::SupportInterface);
    let mut lines: Vec<(Role, Vec<Point2>)> = Vec::new();
    for e in &plan.extrusions {
        let path = plan.path(e);
        match lines.last_mut() {
            Some((role, line)) if line.last() == path.first() && is_support(*role) == is_support(e.role) => {
                line.extend_from_slice(&path[1..]);
            }
            _ => lines.push((e.role, path.to_vec())),
        }
    }
    lines
}

/// A length \[mm\] as the lattice has it.
pub fn length(mm: f64) -> i32 {
    nm(mm) as i32
}
