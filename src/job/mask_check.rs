//! The report of the checks of masks.

use crate::mask::check::{CheckSettings, Findings, LayerFigures, Marks};
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

/// Voids of less than this in all are not warned of \[ml\]: holes of some pixels in a layer or two.
const LEAST_ML: f64 = 0.0005;

impl CheckReport {
    /// Sums up what was found with these settings.
    pub fn new(findings: Findings, settings: &CheckSettings) -> Self {
        let greatest = |area: fn(&LayerFigures) -> f64| {
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

    /// What a user must know: a line for each kind that was found, with the worst place and the remedy.
    /// Voids that are too small to matter together are in the report alone.
    pub fn warnings(&self) -> Vec<String> {
        let f = &self.findings;
        let place = |[x, y]: [f64; 2]| format!("at x {x:.2}, y {y:.2} mm");
        let mut lines = Vec::new();
        if let Some(i) = f.islands.listed.first() {
            lines.push(format!(
                "{} {}: the largest, {:.3} mm2, in layer {} (z {:.2} mm) {}; add supports or turn the part",
                f.islands.count,
                if f.islands.count == 1 { "island" } else { "islands" },
                i.area_mm2,
                i.layer,
                i.z_mm,
                place(i.centre_mm),
            ));
        }
        let kinds = [
            (&f.trapped, ["trapped void", "trapped voids"], "add drain holes"),
            (&f.cups, ["suction cup", "suction cups"], "add vents or turn the part"),
        ];
        for (list, [one, many], remedy) in kinds {
            if let Some(v) = list.listed.first().filter(|_| list.total >= LEAST_ML) {
                lines.push(format!(
                    "{} {}, {:.3} ml: the largest, {:.3} ml, in layers {} to {} (z {:.2} to {:.2} mm) {}; {remedy}",
                    list.count,
                    if list.count == 1 { one } else { many },
                    list.total,
                    v.volume_ml,
                    v.first_layer,
                    v.last_layer,
                    v.z_mm[0],
                    v.z_mm[1],
                    place(v.centre_mm),
                ));
            }
        }
        lines
    }

    /// Whether anything was found, and the greatest peel area, in a line.
    pub fn line(&self) -> String {
        let Extreme { layer, area_mm2 } = self.greatest_peel;
        let found =
            if self.is_clean() { "no islands, suction cups or trapped resin" } else { "see the warnings" };
        format!("checked: {found}; greatest peel area {area_mm2:.1} mm2, layer {layer}")
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::mask::check::{CheckLayer, Checker};
    use crate::mask::{MaskLayer, Panel};

    /// Layers of 0.05 mm on a panel of 40 x 30 pixels of 0.05 mm.
    fn check(layers: u32, is_solid: impl Fn(u32, u32, u32) -> bool) -> CheckReport {
        let panel = Panel {
            width: 40,
            height: 30,
            pitch_x: 50_000,
            pitch_y: 50_000,
            mirror_x: false,
            mirror_y: false,
            portrait: false,
        };
        let settings = CheckSettings::default();
        let mut checker = Checker::new(panel, settings);
        for z in 0..layers {
            let mut mask = MaskLayer::default();
            for at in (0..40 * 30).filter(|at| is_solid(at % 40, at / 40, z)) {
                mask.push(at, at + 1, 255);
            }
            checker.push(&[CheckLayer { mask: Arc::new(mask), z: f64::from(z + 1) * 0.05, height: 0.05 }]);
        }
        CheckReport::new(checker.finish(), &settings)
    }

    #[test]
    fn the_worst_layers_are_one_of_each_kind_first() {
        let report = check(9, |x, y, z| {
            let block = (2..20).contains(&x) && (2..20).contains(&y);
            let closed = (5..9).contains(&x) && (5..9).contains(&y) && (2..5).contains(&z);
            let open = (12..15).contains(&x) && (5..8).contains(&y) && z >= 3;
            let island = x > 31 && y > 21 && z == 4;
            block && !closed && !open || island
        });
        let f = &report.findings;
        assert_eq!((f.islands.count, f.cups.count, f.trapped.count), (1, 1, 1));
        assert!(!report.is_clean() && check(3, |x, y, _| x.max(y) < 9).is_clean());
        let worst: Vec<_> = report.worst_layers(9).iter().map(|w| (w.layer, w.reason)).collect();
        assert_eq!(worst, [(2, Reason::Trapped), (4, Reason::Island), (3, Reason::Cup)]);
        assert_eq!(report.worst_layers(2).len(), 2);
        assert_eq!((report.greatest_area.layer, report.greatest_sealed.layer), (4, 3));
        let island = "1 island: the largest, 0.160 mm2, in layer 4 (z 0.25 mm) at x 1.80, y 0.20 mm; add supports or turn the part";
        assert_eq!(report.warnings(), [island], "voids of a few pixels are no warning");
        let json = serde_json::to_value(&report).unwrap();
        assert_eq!(json["islands"]["listed"][0]["layer"], 4);
        assert_eq!(json["cups"]["listed"][0]["fate"], "top");
        assert_eq!(json["layers"].as_array().unwrap().len(), 9);
        assert!(json["trapped"]["listed"][0].get("marks").is_none());
    }
}
