//! A section → its mask → compressed bytes.

use crate::lattice::Point2;
use crate::mask::raster::{Painter, Raster};
use crate::mask::{MaskLayer, Panel};
use crate::resin::Container;
use crate::span::{EdgeScan, Rows, morph};
use std::sync::Arc;

/// A layer ready to be written. Equal neighbours share it.
#[derive(Debug)]
pub(super) struct Made {
    /// The mask, kept for checks only.
    pub mask: Option<Arc<MaskLayer>>,
    /// By [`Container::encode`]; empty where there is no container.
    pub encoded: Vec<u8>,
    /// Lit pixels.
    pub lit: u64,
    /// Lit area \[mm²\].
    pub area_mm2: f64,
}

/// What all layers of a print have in common on their way to bytes.
pub(super) struct Maker<'a> {
    pub raster: &'a Raster,
    /// `None` where layers are only measured.
    pub container: Option<&'a dyn Container>,
    /// How far outlines move outwards along the plate's x and y \[nm\], by the layer's number.
    pub offset: &'a (dyn Fn(u32) -> [i64; 2] + Sync),
    /// Whether masks are kept.
    pub keep_masks: bool,
}

impl Maker<'_> {
    /// The panel.
    pub(super) fn panel(&self) -> &Panel {
        self.raster.panel()
    }

    /// The mask of an area of layer `layer` on the rows of the raster's frame.
    pub(super) fn mask(&self, area: Rows, layer: u32) -> MaskLayer {
        match (self.offset)(layer) {
            [0, 0] => self.raster.mask(&area),
            offset => self.raster.mask(&self.moved(&area, offset)),
        }
    }

    /// An area with its outline moved outwards by the ellipse of two half axes, inwards where they are
    /// negative. Axes of different sign act one after the other, the growing one first.
    fn moved(&self, area: &Rows, [x, y]: [i64; 2]) -> Rows {
        let (along, across) = if self.panel().portrait { (y, x) } else { (x, y) };
        if along.signum() * across.signum() < 0 {
            let only = |positive: bool, r: i64| if (r > 0) == positive { r } else { 0 };
            let grown = self.ellipse(area, only(true, along), only(true, across));
            return self.ellipse(&grown, only(false, along), only(false, across));
        }
        self.ellipse(area, along, across)
    }

    /// By an ellipse: a disc on rows whose distances are stretched.
    fn ellipse(&self, area: &Rows, along: i64, across: i64) -> Rows {
        let frame = self.raster.frame();
        if across == 0 {
            // No row reaches its neighbours: only the ends of spans move.
            return morph::offset_disc(area, along, |k| i64::from(k) * (1 << 40));
        }
        if along == 0 {
            // Half a nanometre along the rows would do; one is the least that there is.
            return self.ellipse(area, across.signum(), across);
        }
        let stretched = |k: i32| (i128::from(frame.t(k)) * i128::from(along) / i128::from(across)) as i64;
        morph::offset_disc(area, along, stretched)
    }

    /// Measures a mask and compresses it.
    pub(super) fn made(&self, mask: &Arc<MaskLayer>) -> Arc<Made> {
        let encoded = self.container.map_or_else(Vec::new, |c| c.encode(mask, self.panel()));
        let (lit, area_mm2) = (mask.lit(), mask.area() * self.panel().pixel_mm2());
        Arc::new(Made { mask: self.keep_masks.then(|| Arc::clone(mask)), encoded, lit, area_mm2 })
    }
}

/// Makes the layers of a run one after the other; a layer that equals the one before is that one.
pub(super) struct Line<'a> {
    maker: &'a Maker<'a>,
    painter: Painter<'a>,
    scan: EdgeScan,
    last: Option<(Arc<MaskLayer>, [i64; 2], Arc<Made>)>,
}

impl<'a> Line<'a> {
    pub(super) fn new(maker: &'a Maker<'a>) -> Self {
        let scan = EdgeScan::new(maker.raster.frame());
        Self { maker, painter: Painter::new(maker.raster), scan, last: None }
    }

    /// Layer `layer` from the directed edges of its section \[nm, mesh frame\]; `unchanged` promises that
    /// they enclose the same area as those before.
    pub(super) fn layer(&mut self, layer: u32, edges: &[[Point2; 2]], unchanged: bool) -> Arc<Made> {
        let offset = (self.maker.offset)(layer);
        if let Some((_, before, made)) = &self.last
            && unchanged
            && *before == offset
        {
            return Arc::clone(made);
        }
        let mask = match offset {
            [0, 0] => self.painter.mask(edges),
            _ => self.maker.mask(self.scan.scan(edges), layer),
        };
        let (mask, made) = match self.last.take() {
            Some((same, _, made)) if *same == mask => (same, made),
            _ => {
                let mask = Arc::new(mask);
                let made = self.maker.made(&mask);
                (mask, made)
            }
        };
        self.last = Some((mask, offset, Arc::clone(&made)));
        made
    }
}
