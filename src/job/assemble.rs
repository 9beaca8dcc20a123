//! What belongs to a layer, brought together.

use super::adhesion;
use super::supports::Supports;
use crate::contour::Ring;
use crate::infill::FillPath;
use crate::path::{PrintIsland, PrintLayer};
use crate::region::Island;
use crate::settings::Settings;
use crate::slice::planes::LayerZ;
use crate::support::{Strand, SupportLayer};

/// The layers of a print, lowest first: those of the part, and between them those of supports and raft. What
/// ends at one height is one layer.
pub fn assemble(
    z: Vec<LayerZ>,
    islands: Vec<Vec<Island>>,
    fills: Vec<Vec<Vec<FillPath>>>,
    supports: Supports,
    skirt: &[Ring],
    settings: &Settings,
) -> Vec<PrintLayer> {
    let raft = settings.adhesion.raft_layers > 0;
    let raft_layers = (settings.adhesion.raft_layers as usize).min(supports.layers.len());
    let raft_top = supports.layers[..raft_layers].last().map_or(0, |l| l.print_z);
    let mut part =
        z.into_iter().zip(islands.into_iter().zip(fills)).enumerate().map(|(i, (z, own))| PrintLayer {
            z,
            islands: own
                .0
                .into_iter()
                .zip(own.1)
                .map(|(island, fills)| PrintIsland { walls: island.walls, beads: island.beads, fills })
                .collect(),
            on_raft: raft && i == 0,
            ..PrintLayer::default()
        });
    let beside = supports.layers.iter().zip(supports.strands).filter(|(_, strands)| !strands.is_empty());
    let mut layers = Vec::with_capacity(part.len());
    let mut next = part.next();
    for (layer, strands) in beside {
        while let Some(own) = next.take_if(|own| own.z.print_z < layer.print_z) {
            layers.push(own);
            next = part.next();
        }
        match next.take_if(|own| own.z.print_z == layer.print_z) {
            Some(own) => {
                layers.push(PrintLayer { supports: strands, support_height: layer.height, ..own });
                next = part.next();
            }
            None => layers.push(alone(layer, strands)),
        }
    }
    layers.extend(next);
    layers.extend(part);
    adhesion::lay_skirt(&mut layers, skirt, raft_top, settings);
    if let Some(first) = layers.first_mut() {
        first.brim = supports.brim;
    }
    layers
}

/// A layer of nothing but supports.
fn alone(layer: &SupportLayer, strands: Vec<Strand>) -> PrintLayer {
    PrintLayer {
        z: LayerZ { slice_z: 0, print_z: layer.print_z, height: layer.height },
        supports: strands,
        support_height: layer.height,
        ..PrintLayer::default()
    }
}
