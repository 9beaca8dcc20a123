//! The report of the checks of masks.

use crate::mask::check::{CheckSettings, Findings, Marks};
use serde::Serialize;
use std::sync::Arc;

/// What `mask --check` writes as JSON.
#[derive(Clone, Debug, Serialize)]
pub struct CheckReport {
    /// Least grey of a pixel that counts as solid.
    pub threshold: u8,
    /// How far beside what lies beneath it a pixel counts as supported \[mm\].
    pub reach_mm: f64,
    /// Number of layers.
    pub layer_count: u32,
    /// Volume of the lit area \[ml\].
    pub volume_ml: f64,
    /// Greatest lit area.
    pub greatest_area: Extreme,
    /// Greatest area that pulls when a layer is peeled: solid and sealed voids.
    pub greatest_peel: Extreme,
    /// Greatest area without support.
    pub greatest_overhang: Extreme,
    /// Most area of sealed voids.
    pub greatest_sealed: Extreme,
    /// All that was found, with the figures of every layer.
    #[serde(flatten)]
    pub findings: Findings,
}

/// The greatest area of a kind and the first layer that has it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Extreme {
    /// The layer, counted from 0.
    pub layer: u32,
    /// Its area \[mm²\].
    pub area_mm2: f64,
}

/// Why a layer is worth a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reason {
    /// It has one of the largest islands.
    Island,
    /// One of the largest cups has its greatest area there.
    Cup,
    /// One of the largest trapped voids has its greatest area there.
    Trapped,
    /// It has the greatest overhang.
    Overhang,
}

/// A layer to be drawn; it must be sliced again for that, and the one below too.
#[derive(Clone, Debug)]
pub struct WorstLayer {
    /// The layer, counted from 0.
    pub layer: u32,
    /// Why.
    pub reason: Reason,
    /// What to draw beside islands and overhangs.
    pub marks: Arc<Marks>,
}

impl CheckReport {
    /// Sums up what was found with these settings.
    pub fn new(findings: Findings, settings: &CheckSettings) -> Self {
        let greatest = |area: fn(&crate::mask::check::LayerFigures) -> f64| {
            let areas = (0u32..).zip(findings.layers.iter().map(area));
            areas.fold(Extreme::default(), |most, (layer, area_mm2)| {
                if area_mm2 > most.area_mm2 { Extreme { layer, area_mm2 } } else { most }
            })
        };
        Self {
            threshold: settings.threshold,
            reach_mm: settings.reach_mm,
            layer_count: findings.layers.len() as u32,
            volume_ml: findings.volume_ml,
            greatest_area: greatest(|l| l.area_mm2),
            greatest_peel: greatest(|l| l.peel_mm2),
            greatest_overhang: greatest(|l| l.overhang_mm2),
            greatest_sealed: greatest(|l| l.sealed_mm2),
            findings,
        }
    }

    /// True without islands, cups and trapped resin.
    pub fn is_clean(&self) -> bool {
        let f = &self.findings;
        f.islands.count == 0 && f.cups.count == 0 && f.trapped.count == 0
    }

    /// What was found, in a line.
    pub fn line(&self) -> String {
        let f = &self.findings;
        if self.is_clean() {
            return "checked: no islands, no suction cups, no trapped resin".to_owned();
        }
        format!(
            "checked: {} islands ({:.2} mm2), {} suction cups ({:.2} ml), {} trapped voids ({:.2} ml)",
            f.islands.count, f.islands.total, f.cups.count, f.cups.total, f.trapped.count, f.trapped.total
        )
    }

    /// What a user must know, one line each, with the worst place of each kind.
    pub fn warnings(&self) -> Vec<String> {
        let f = &self.findings;
        let at = |z: f64, [x, y]: [f64; 2]| format!("at x {x:.2}, y {y:.2}, z {z:.3} mm");
        let mut said = Vec::new();
        if let Some(worst) = f.islands.listed.first() {
            said.push(format!(
                "{} islands have nothing beneath them, the largest {:.3} mm2 on layer {} {}; add supports or turn the part",
                f.islands.count, worst.area_mm2, worst.layer, at(worst.z_mm, worst.centre_mm)
            ));
        }
        if let Some(worst) = f.trapped.listed.first() {
            said.push(format!(
                "{} voids trap resin, the largest {:.3} ml from layer {} to {} {}; add drain holes",
                f.trapped.count,
                worst.volume_ml,
                worst.first_layer,
                worst.last_layer,
                at(worst.z_mm[0], worst.centre_mm)
            ));
        }
        if let Some(worst) = f.cups.listed.first() {
            said.push(format!(
                "{} hollows seal against the film and pull like a suction cup, the largest {:.3} ml from layer {} to {} {}; add vents or turn the part",
                f.cups.count, worst.volume_ml, worst.first_layer, worst.last_layer, at(worst.z_mm[0], worst.centre_mm)
            ));
        }
        said
    }

    /// Up to `most` differing layers worth a picture: in turn those of the greatest trapped voids,
    /// islands and cups, then the one with the greatest overhang.
    pub fn worst_layers(&self, most: usize) -> Vec<WorstLayer> {
        let f = &self.findings;
        let trapped = f.trapped.listed.iter().map(|v| (Reason::Trapped, &v.marks));
        let islands = f.islands.listed.iter().map(|i| (Reason::Island, &i.marks));
        let cups = f.cups.listed.iter().map(|v| (Reason::Cup, &v.marks));
        let overhang =
            (self.greatest_overhang.area_mm2 > 0.0).then_some((Reason::Overhang, &f.overhang_marks));
        let mut lists: [Vec<_>; 4] =
            [trapped.collect(), islands.collect(), cups.collect(), overhang.into_iter().collect()];
        lists.iter_mut().for_each(|list| list.reverse());
        let mut out: Vec<WorstLayer> = Vec::new();
        while out.len() < most && lists.iter().any(|list| !list.is_empty()) {
            for list in &mut lists {
                let known = |m: &Marks, out: &[WorstLayer]| out.iter().any(|w| w.layer == m.layer);
                while let Some((reason, marks)) = list.pop() {
                    if !known(marks, &out) {
                        out.push(WorstLayer { layer: marks.layer, reason, marks: marks.clone() });
                        break;
                    }
                }
            }
        }
        out.truncate(most);
        out
    }
}
