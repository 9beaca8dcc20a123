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

/// Heights this near to each other are one \[nm\]: G-code states them in micrometres.
const SAME_HEIGHT: i32 = 1_000;

/// The layers of a print, lowest first: those of the part, and between them those of supports and raft. What
/// ends at one height is one layer, the part's.
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
        while let Some(own) = next.take_if(|own| own.z.print_z < layer.print_z - SAME_HEIGHT) {
            layers.push(own);
            next = part.next();
        }
        match next.take_if(|own| own.z.print_z <= layer.print_z + SAME_HEIGHT) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Point2;
    use crate::support::StrandKind;

    fn strand(x: i32) -> Vec<Strand> {
        let points = vec![Point2::new(x, 0), Point2::new(x, 9_000_000)];
        vec![Strand { points, closed: false, kind: StrandKind::Base }]
    }

    #[test]
    fn what_ends_at_one_height_is_one_layer() {
        let z: Vec<LayerZ> = (0..4)
            .map(|k| LayerZ { slice_z: k * 200_000 + 100_000, print_z: (k + 1) * 200_000, height: 200_000 })
            .collect();
        let layer = |print_z, height| SupportLayer { print_z, height, ..SupportLayer::default() };
        // One has no lines; two are a rounding off the part's; the last stands above the part.
        let heights = [
            (200_001, 200_000),
            (300_000, 99_999),
            (498_000, 297_999),
            (799_999, 301_999),
            (1_000_000, 200_001),
        ];
        let mut supports = Supports {
            layers: heights.map(|(z, h)| layer(z, h)).to_vec(),
            strands: (0..5).map(strand).collect(),
            brim: strand(77),
            ..Supports::default()
        };
        supports.strands[1].clear();
        let mut settings = Settings::default();
        settings.adhesion.skirt_height = 1;
        let skirt = [vec![Point2::new(0, 0); 3]];
        let empty = (vec![Vec::new(); 4], vec![Vec::new(); 4]);
        let layers = assemble(z, empty.0, empty.1, supports, &skirt, &settings);
        let heights: Vec<(i32, i32)> = layers.iter().map(|l| (l.z.print_z, l.support_height)).collect();
        assert_eq!(
            heights,
            [
                (200_000, 200_000),
                (400_000, 0),
                (498_000, 297_999),
                (600_000, 0),
                (800_000, 301_999),
                (1_000_000, 200_001)
            ]
        );
        let beside: Vec<bool> = layers.iter().map(PrintLayer::is_beside).collect();
        assert_eq!(beside, [false, false, true, false, false, true]);
        assert_eq!(layers[2].z.height, 297_999);
        assert_eq!((layers[0].brim.clone(), layers[1].brim.len()), (strand(77), 0));
        assert_eq!(layers.iter().map(|l| l.skirt.len()).collect::<Vec<_>>(), [1, 0, 0, 0, 0, 0]);
        assert_eq!(layers[4].supports, strand(3));
    }
}
