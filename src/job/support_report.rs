//! What supports do and cost, in the style that was chosen and in the others.

use super::summary::FilamentSummary;
use super::support_picture;
use super::supports::Supports;
use crate::lattice::{Point2, mm};
use crate::path::{LayerPlan, Planner, PrintLayer, Role};
use crate::settings::{Settings, SupportStyle};
use crate::slice::planes::LayerZ;
use crate::support::check::{Clash, InAir, Print, Rule, What, clashes, in_air};
use crate::support::report::facts;
use crate::support::{SupportLayer, SupportPlan};
use image::RgbImage;
use serde::Serialize;
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// What is to be said about supports beside making them. It costs as much as making them several times.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SupportWish {
    /// Measure them, and what the other styles would cost.
    pub report: bool,
    /// Draw them.
    pub picture: bool,
    /// Keep their areas and what they were made from.
    pub areas: bool,
}

/// What was found out.
#[derive(Clone, Debug, Default)]
pub struct SupportRecord {
    /// The figures.
    pub report: Option<SupportReport>,
    /// The picture.
    pub picture: Option<RgbImage>,
    /// The areas.
    pub areas: Option<Supports>,
}

/// What supports do and cost.
#[derive(Clone, Debug, Default, Serialize)]
pub struct SupportReport {
    /// The input file.
    pub model: String,
    /// `grid`, `snug`, `organic`, or `none` where supports are off.
    pub style: &'static str,
    /// What hangs and needs support, summed over the layers \[mm²\].
    pub hanging_mm2: f64,
    /// What hangs and holds itself as a bridge \[mm²\].
    pub bridged_mm2: f64,
    /// What hangs and has support below \[mm²\].
    pub contact_mm2: f64,
    /// Where supports stand on the part \[mm²\].
    pub foot_mm2: f64,
    /// Columns or branches that begin on the bed, or on a raft.
    pub columns_on_bed: u64,
    /// Those that begin on the part.
    pub columns_on_part: u64,
    /// Layers of supports.
    pub layers: u64,
    /// Space that supports take, with the air between their lines \[mm³\].
    pub volume_mm3: f64,
    /// Space that the raft takes \[mm³\].
    pub raft_mm3: f64,
    /// What is printed in air.
    pub in_air: AirSummary,
    /// Where supports are nearer to the part than they may be.
    pub too_near: NearSummary,
    /// Filament of supports and raft.
    pub filament: Material,
    /// Their share of all filament, 0 to 1.
    pub share: f64,
    /// What each style would take, all other settings being the same.
    pub choices: Vec<Choice>,
}

/// Filament of supports and raft.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Material {
    /// Length \[mm\].
    pub mm: f64,
    /// Volume \[cm³\].
    pub cm3: f64,
    /// Mass \[g\]; absent where the filament's density is not set.
    pub g: Option<f64>,
    /// Price; absent where density or cost is not set.
    pub cost: Option<f64>,
    /// Length by what is printed \[mm\].
    pub mm_by_role: BTreeMap<String, f64>,
}

/// A style of supports and what it takes.
#[derive(Clone, Debug, Serialize)]
pub struct Choice {
    /// `grid`, `snug` or `organic`.
    pub style: &'static str,
    /// Filament of supports and raft.
    pub filament: Material,
    /// Columns or branches that begin on the bed, or on a raft.
    pub columns_on_bed: u64,
    /// Those that begin on the part.
    pub columns_on_part: u64,
    /// What would be printed in air \[mm²\].
    pub in_air_mm2: f64,
}

/// What is printed in air.
#[derive(Clone, Debug, Default, Serialize)]
pub struct AirSummary {
    /// How much of the part \[mm²\].
    pub part_mm2: f64,
    /// How much of the supports \[mm²\].
    pub supports_mm2: f64,
    /// How much of the part no support could hold that keeps its distances \[mm²\].
    pub cramped_mm2: f64,
    /// On how many layers of the part.
    pub layers: usize,
    /// The largest piece of the part.
    pub largest: Option<Piece>,
}

/// A connected area of one layer.
#[derive(Clone, Debug, Serialize)]
pub struct Piece {
    /// Its area \[mm²\].
    pub mm2: f64,
    /// The layer of the part, counted from 0.
    pub layer: usize,
    /// A point in it on the bed \[mm\], and the height of its lower side.
    pub x_mm: f64,
    /// As above.
    pub y_mm: f64,
    /// As above.
    pub z_mm: f64,
}

/// Where supports are nearer to the part than they may be.
#[derive(Clone, Debug, Default, Serialize)]
pub struct NearSummary {
    /// How much of them, summed over their layers \[mm²\].
    pub mm2: f64,
    /// The worst place on the bed (x, y, z) \[mm\].
    pub worst_mm: Option<[f64; 3]>,
}

/// The part and its place, as the report takes them.
pub struct Subject<'a> {
    /// The part's name in messages.
    pub name: &'a str,
    /// World position of the part's zero \[nm\].
    pub origin: [i64; 3],
    /// The settings of the job.
    pub settings: &'a Settings,
    /// Makes supports by other settings.
    pub make: &'a dyn Fn(&Settings) -> Supports,
}

/// Whether supports are on; a raft alone is none.
fn are_on(settings: &Settings) -> bool {
    settings.support.support_material || settings.support.support_material_enforce_layers > 0
}

/// The check of a job with supports: `None` where they are off.
pub fn check(supports: &Supports, subject: &Subject) -> Option<AirSummary> {
    if !are_on(subject.settings) {
        return None;
    }
    let (print, rule) = print(supports, &supports.layers, subject.settings)?;
    Some(air(&in_air(&print, &rule), subject.origin))
}

/// A warning about what is printed in air, unless it is too small to be seen: a square of the width of a line.
pub fn warning(air: &AirSummary, subject: &Subject) -> Option<String> {
    let largest = air.largest.as_ref()?;
    let s = &subject.settings.support;
    let line = mm((2.0 * SupportPlan::new(subject.settings).half_wall) as i64);
    if largest.mm2 < line * line {
        return None;
    }
    let remedy = if !s.support_material_auto {
        "support_material_auto is off: cover it with --support-enforcer"
    } else if s.support_material_buildplate_only {
        "support_material_buildplate_only keeps supports off the part: turn it off, or turn the part"
    } else if air.cramped_mm2 > 0.5 * air.part_mm2 {
        "the part is too near for supports: make support_material_xy_spacing or support_material_contact_distance smaller"
    } else {
        "turn the part or try another support_material_style"
    };
    Some(format!(
        "{}: {:.1} mm2 on {} layers are printed in air, {:.1} mm2 of it in one piece at z = {:.2}, x = {:.2}, y = {:.2} mm; {remedy}",
        subject.name, air.part_mm2, air.layers, largest.mm2, largest.z_mm, largest.x_mm, largest.y_mm,
    ))
}

/// Measures and draws supports as wished.
pub fn record(supports: &Supports, wish: SupportWish, subject: &Subject) -> SupportRecord {
    if wish == SupportWish::default() {
        return SupportRecord::default();
    }
    let areas = wish.areas.then(|| supports.clone());
    let on = are_on(subject.settings);
    let mut settings = subject.settings.clone();
    settings.support.support_material = true;
    // Without supports the rows and overhangs of the style that would be made.
    let would = (!on && (wish.report || wish.picture)).then(|| (subject.make)(&settings));
    let shown = would.as_ref().unwrap_or(supports);
    let Some((print, rule)) = print(shown, &supports.layers, subject.settings) else {
        return SupportRecord { areas, ..SupportRecord::default() };
    };
    let picture = wish.picture.then(|| support_picture::draw(&print));
    let report = wish.report.then(|| {
        let facts = facts(&print, &rule);
        let style = subject.settings.support.support_material_style;
        let of_style = |other: SupportStyle| {
            if other == style {
                return choice(shown, &settings);
            }
            let mut settings = settings.clone();
            settings.support.support_material_style = other;
            choice(&(subject.make)(&settings), &settings)
        };
        SupportReport {
            model: subject.name.to_owned(),
            style: if on { name(style) } else { "none" },
            hanging_mm2: facts.hanging_mm2,
            bridged_mm2: facts.bridged_mm2,
            contact_mm2: facts.contact_mm2,
            foot_mm2: facts.foot_mm2,
            columns_on_bed: facts.columns_on_bed,
            columns_on_part: facts.columns_on_part,
            layers: facts.layers,
            volume_mm3: facts.volume_mm3,
            raft_mm3: facts.raft_mm3,
            in_air: air(&in_air(&print, &rule), subject.origin),
            too_near: near(&clashes(&print, &rule), subject.origin),
            filament: material(supports, subject.settings),
            share: 0.0,
            choices: STYLES.into_iter().filter_map(of_style).collect(),
        }
    });
    SupportRecord { report, picture, areas }
}

impl SupportReport {
    /// Takes over how much filament the whole print needs.
    pub fn set_print(&mut self, print: &FilamentSummary) {
        self.share = if print.mm > 0.0 { self.filament.mm / print.mm } else { 0.0 };
    }
}

const STYLES: [SupportStyle; 3] = [SupportStyle::Grid, SupportStyle::Snug, SupportStyle::Organic];

const fn name(style: SupportStyle) -> &'static str {
    match style {
        SupportStyle::Grid => "grid",
        SupportStyle::Snug => "snug",
        SupportStyle::Organic => "organic",
    }
}

/// What the check looks at.
fn print<'a>(
    rows: &'a Supports,
    layers: &'a [SupportLayer],
    settings: &Settings,
) -> Option<(Print<'a>, Rule)> {
    let part = rows.rows.as_ref()?.part();
    let rule = Rule::new(settings, &SupportPlan::new(settings));
    Some((Print { part, overhangs: &rows.overhangs, supports: layers }, rule))
}

fn choice(supports: &Supports, settings: &Settings) -> Option<Choice> {
    let (print, rule) = print(supports, &supports.layers, settings)?;
    let facts = facts(&print, &rule);
    Some(Choice {
        style: name(settings.support.support_material_style),
        filament: material(supports, settings),
        columns_on_bed: facts.columns_on_bed,
        columns_on_part: facts.columns_on_part,
        in_air_mm2: in_air(&print, &rule)
            .iter()
            .filter(|a| is_part(a))
            .map(|a| a.mm2)
            .fold(0.0, |a, b| a + b),
    })
}

fn is_part(found: &InAir) -> bool {
    matches!(found.what, What::Part(_))
}

fn air(found: &[InAir], origin: [i64; 3]) -> AirSummary {
    // An empty `sum` would be -0.
    let sum =
        |of_part: bool| found.iter().filter(|a| is_part(a) == of_part).map(|a| a.mm2).fold(0.0, |a, b| a + b);
    let largest = found.iter().filter(|a| is_part(a)).max_by(|a, b| a.largest_mm2.total_cmp(&b.largest_mm2));
    AirSummary {
        part_mm2: sum(true),
        supports_mm2: sum(false),
        cramped_mm2: found.iter().map(|a| a.cramped_mm2).fold(0.0, |a, b| a + b),
        layers: found.iter().filter(|a| is_part(a)).count(),
        largest: largest.map(|a| {
            let (What::Part(layer) | What::Support(layer)) = a.what;
            Piece {
                mm2: a.largest_mm2,
                layer,
                x_mm: mm(i64::from(a.place.x) + origin[0]),
                y_mm: mm(i64::from(a.place.y) + origin[1]),
                z_mm: mm(a.z),
            }
        }),
    }
}

fn near(found: &[Clash], origin: [i64; 3]) -> NearSummary {
    let worst = found.iter().max_by(|a, b| a.mm2.total_cmp(&b.mm2));
    NearSummary {
        mm2: found.iter().map(|c| c.mm2).fold(0.0, |a, b| a + b),
        worst_mm: worst.map(|c| {
            let [x, y, _] = origin;
            [mm(i64::from(c.place.x) + x), mm(i64::from(c.place.y) + y), mm(c.z)]
        }),
    }
}

/// The filament of supports and raft as the path stage lays them.
fn material(supports: &Supports, settings: &Settings) -> Material {
    let filament = &settings.filament;
    let section = PI / 4.0 * filament.filament_diameter * filament.filament_diameter;
    let mut planner = Planner::new(Point2::new(0, 0), settings);
    let mut plan = LayerPlan::default();
    let mut mm3 = [0.0; Role::COUNT];
    for (layer, strands) in supports.layers.iter().zip(&supports.strands) {
        let alone = PrintLayer {
            z: LayerZ { slice_z: 0, print_z: layer.print_z, height: layer.height },
            supports: strands.clone(),
            support_height: layer.height,
            ..PrintLayer::default()
        };
        planner.layer(&alone, &mut plan);
        for e in &plan.extrusions {
            mm3[e.role.index()] += e.length * e.mm3_per_mm * filament.extrusion_multiplier;
        }
    }
    let all: f64 = mm3.iter().sum();
    let grams = all / 1000.0 * filament.filament_density;
    let known = |value: f64| Some(value).filter(|v| *v > 0.0);
    let by_role = Role::ALL.into_iter().map(|r| (r.name().to_owned(), mm3[r.index()] / section));
    Material {
        mm: all / section,
        cm3: all / 1000.0,
        g: known(filament.filament_density).map(|_| grams),
        cost: known(filament.filament_cost)
            .and(known(filament.filament_density))
            .map(|_| grams / 1000.0 * filament.filament_cost),
        mm_by_role: by_role.filter(|(_, mm)| *mm > 0.0).collect(),
    }
}
