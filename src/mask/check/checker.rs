//! The checks over a stream of layers.

use super::findings::{Fate, Findings, Island, LayerFigures, Marks, Void, Worst};
use super::parts::{LayerParts, Region};
use super::support::{Reach, Unsupported};
use super::voids::{Place, Sealed, Voids};
use crate::lattice;
use crate::mask::{MaskLayer, Panel};
use rayon::prelude::*;
use std::sync::Arc;

/// What the checks are to go by.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CheckSettings {
    /// Least grey of a pixel that counts as solid. Resin under less light stays soft: it neither holds
    /// an overhang nor seals a void.
    pub threshold: u8,
    /// How far beside what lies beneath it a pixel still counts as supported, between centres of
    /// pixels \[mm\].
    pub reach_mm: f64,
    /// Length of the lists of islands, cups and trapped voids; all are counted.
    pub listed: usize,
}

impl Default for CheckSettings {
    /// Half lit; a reach of 0.1 mm, some pixels of any panel; 100 on a list.
    fn default() -> Self {
        Self { threshold: 128, reach_mm: 0.1, listed: 100 }
    }
}

/// A layer to check.
#[derive(Clone, Debug)]
pub struct CheckLayer {
    /// Its mask. Equal neighbours are nearly free, the more so when they share it.
    pub mask: Arc<MaskLayer>,
    /// Height of its upper side over the plate \[mm\].
    pub z: f64,
    /// Its thickness \[mm\].
    pub height: f64,
}

/// Checks layers in their order. Memory: the last layer, the voids open in it, bounded lists of findings
/// and a few figures a layer.
#[derive(Debug)]
pub struct Checker {
    panel: Panel,
    settings: CheckSettings,
    reach: Reach,
    layers: Vec<LayerFigures>,
    last: Option<(Arc<MaskLayer>, Arc<LayerParts>)>,
    voids: Voids,
    islands: Worst<Island>,
    cups: Worst<Void>,
    trapped: Worst<Void>,
    volume: f64,
    overhang: u64,
    overhang_marks: Arc<Marks>,
}

impl Checker {
    /// Begins with layer 0, which stands on the plate.
    pub fn new(panel: Panel, settings: CheckSettings) -> Self {
        let most = settings.listed;
        Self {
            panel,
            settings,
            reach: Reach::new(lattice::nm(settings.reach_mm), &panel),
            layers: Vec::new(),
            last: None,
            voids: Voids::default(),
            islands: Worst::new(most),
            cups: Worst::new(most),
            trapped: Worst::new(most),
            volume: 0.0,
            overhang: 0,
            overhang_marks: Arc::default(),
        }
    }

    /// Checks the next layers. They are taken apart and compared in parallel, then linked in order; how
    /// they are spread over calls does not matter.
    pub fn push(&mut self, layers: &[CheckLayer]) {
        let masks: Vec<&Arc<MaskLayer>> =
            self.last.iter().map(|(mask, _)| mask).chain(layers.iter().map(|l| &l.mask)).collect();
        let given = masks.len() - layers.len();
        let fresh: Vec<bool> = (given..masks.len())
            .into_par_iter()
            .map(|i| i == 0 || !Arc::ptr_eq(masks[i - 1], masks[i]) && masks[i - 1] != masks[i])
            .collect();
        let (panel, threshold) = (self.panel, self.settings.threshold);
        let apart: Vec<Option<LayerParts>> = layers
            .par_iter()
            .zip(&fresh)
            .map(|(layer, &fresh)| fresh.then(|| LayerParts::of(&layer.mask, &panel, threshold)))
            .collect();
        let mut parts: Vec<Option<Arc<LayerParts>>> = vec![self.last.as_ref().map(|(_, p)| p.clone())];
        for layer in apart {
            let same = parts.last().cloned().flatten();
            parts.push(layer.map(Arc::new).or(same));
        }
        let reach = &self.reach;
        let unsupported: Vec<Option<Unsupported>> = (0..layers.len())
            .into_par_iter()
            .map(|i| match (&parts[i], &parts[i + 1]) {
                (Some(below), Some(here)) if fresh[i] => Some(Unsupported::of(here, below, reach, false)),
                _ => None,
            })
            .collect();
        for (i, layer) in layers.iter().enumerate() {
            if let Some(here) = &parts[i + 1] {
                let below = parts[i].as_deref();
                self.link(layer, here, below, fresh[i], unsupported[i].as_ref());
            }
        }
        if let (Some(layer), Some(Some(here))) = (layers.last(), parts.pop()) {
            self.last = Some((layer.mask.clone(), here));
        }
    }

    /// Links a layer to the ones below.
    fn link(
        &mut self,
        layer: &CheckLayer,
        parts: &LayerParts,
        below: Option<&LayerParts>,
        fresh: bool,
        unsupported: Option<&Unsupported>,
    ) {
        let index = self.layers.len() as u32;
        let place = Place { layer: index, z: layer.z, height: layer.height };
        if fresh {
            let (panel, cups, trapped) = (&self.panel, &mut self.cups, &mut self.trapped);
            self.voids.push(parts, below, place, |void, fate| {
                let list = if fate == Fate::Closed { &mut *trapped } else { &mut *cups };
                report(list, void, fate, index - 1, panel);
            });
        } else {
            self.voids.push_equal(parts, place);
        }
        let mm2 = self.panel.pixel_mm2();
        let area = |pixels: u64| pixels as f64 * mm2;
        let sealed = self.voids.area();
        let islands = unsupported.map_or(0, |u| self.islands(u, parts, place));
        let overhang = unsupported.map_or(0, Unsupported::pixels);
        if overhang > self.overhang {
            self.overhang = overhang;
            self.overhang_marks = self.voids.marks(index);
        }
        self.volume += parts.lit * mm2 * layer.height;
        self.layers.push(LayerFigures {
            z_mm: layer.z,
            area_mm2: parts.lit * mm2,
            parts: parts.pixels.len() as u32,
            largest_part_mm2: area(parts.pixels.iter().copied().max().unwrap_or(0).into()),
            overhang_mm2: area(overhang),
            islands,
            sealed_mm2: area(sealed),
            peel_mm2: area(parts.solid() + sealed),
        });
    }

    /// Reports the islands of a layer and returns their number.
    fn islands(&mut self, unsupported: &Unsupported, parts: &LayerParts, place: Place) -> u32 {
        let islands: Vec<u32> = unsupported.islands(parts).collect();
        if islands.is_empty() {
            return 0;
        }
        let mut regions = vec![Region::default(); islands.len()];
        for k in parts.rows.first()..parts.rows.end() {
            for i in parts.rows.range(k) {
                if let Ok(n) = islands.binary_search(&parts.part[i]) {
                    let span = parts.rows.spans()[i];
                    regions[n].add(k, span.start, span.end);
                }
            }
        }
        let marks = self.voids.marks(place.layer);
        for region in &regions {
            let area_mm2 = region.pixels as f64 * self.panel.pixel_mm2();
            self.islands.add(area_mm2, || {
                let (centre_mm, bounds_mm) = region.on_plate(&self.panel);
                let (layer, z_mm, pixels) = (place.layer, place.z, region.pixels);
                Island { layer, z_mm, centre_mm, bounds_mm, area_mm2, pixels, marks: marks.clone() }
            });
        }
        islands.len() as u32
    }

    /// Ends the print behind the last layer.
    pub fn finish(mut self) -> Findings {
        let last = (self.layers.len() as u32).saturating_sub(1);
        for void in self.voids.finish() {
            report(&mut self.cups, void, Fate::Top, last, &self.panel);
        }
        Findings {
            layers: self.layers,
            islands: self.islands,
            cups: self.cups,
            trapped: self.trapped,
            volume_ml: self.volume * 1e-3,
            overhang_marks: self.overhang_marks,
            fates: self.voids.fates,
        }
    }
}

/// Puts a void on its list.
fn report(list: &mut Worst<Void>, void: Sealed, fate: Fate, last_layer: u32, panel: &Panel) {
    let volume_ml = void.volume * panel.pixel_mm2() * 1e-3;
    list.add(volume_ml, || {
        let (centre_mm, bounds_mm) = void.region.on_plate(panel);
        Void {
            fate,
            first_layer: void.first_layer,
            last_layer,
            z_mm: [void.bottom, void.top],
            centre_mm,
            bounds_mm,
            greatest_area_mm2: void.greatest as f64 * panel.pixel_mm2(),
            greatest_layer: void.marks.layer,
            volume_ml,
            marks: void.marks,
        }
    });
}
