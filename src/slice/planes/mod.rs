//! Where the planes lie.

pub mod list;

use super::adaptive;
use crate::lattice::{LIMIT, mm, nm};
use crate::mesh::Mesh;
use crate::settings::{Settings, SlicingSettings};
use thiserror::Error;

/// One layer of the print; heights above the bed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LayerZ {
    /// Height of the cutting plane, the layer's middle \[nm\].
    pub slice_z: i32,
    /// Height of the layer's top, where the nozzle runs \[nm\].
    pub print_z: i32,
    /// Thickness \[nm\].
    pub height: i32,
}

/// More layers than this are refused: no printer makes them, and a slip in a unit does.
pub const MAX_LAYERS: u64 = 1 << 24;

/// Why a part has no usable list of layers.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlaneError {
    /// A layer height of zero, below a nanometre, negative or not a number.
    #[error("{key} is {height_mm} mm; layers need a positive thickness, for example 0.2")]
    Height {
        /// Setting at fault.
        key: &'static str,
        /// Its value in millimetres.
        height_mm: f64,
    },
    /// No plane meets the part.
    #[error(
        "the part reaches from {bottom_mm} to {top_mm} mm above the bed and no layer's middle lies in it \
         (first layer {first_mm} mm, layer_height {layer_mm} mm); use thinner layers or scale the part up"
    )]
    Thin {
        /// Lowest point above the bed \[mm\].
        bottom_mm: f64,
        /// Highest point above the bed \[mm\].
        top_mm: f64,
        /// Thickness of the first layer \[mm\].
        first_mm: f64,
        /// Thickness of the other layers \[mm\].
        layer_mm: f64,
    },
    /// More than [`MAX_LAYERS`].
    #[error(
        "{top_mm} mm in layers of {layer_mm} mm makes more than {MAX_LAYERS} layers; raise layer_height or \
         check the model's unit"
    )]
    TooMany {
        /// Highest point above the bed \[mm\].
        top_mm: f64,
        /// Thickness of the layers \[mm\].
        layer_mm: f64,
    },
    /// A list of planes that all miss the part.
    #[error(
        "the part reaches from {bottom_mm} to {top_mm} mm and none of the {planes} planes from {first_mm} to {last_mm} mm cuts it; \
         heights are in millimetres above the bed"
    )]
    Missed {
        /// Number of planes.
        planes: usize,
        /// Lowest plane \[mm\].
        first_mm: f64,
        /// Highest plane \[mm\].
        last_mm: f64,
        /// Lowest point of the part \[mm\].
        bottom_mm: f64,
        /// Highest point of the part \[mm\].
        top_mm: f64,
    },
    /// Heights beyond what the lattice holds.
    #[error("the part reaches {top_mm} mm above the bed, beyond the lattice's 2147 mm; put it on the bed")]
    TooHigh {
        /// Highest point above the bed \[mm\].
        top_mm: f64,
    },
}

/// The layers of a part that reaches from `z_min` to `z_max` \[nm\] above the bed.
///
/// Layers rest on each other from the bed up, and each is cut at its middle, while that middle lies
/// below `z_max`. The height of every plane and top is rounded once from its exact value, so rounding
/// does not add up. Under a part that floats (`z_min` > 0) the list still begins at the bed; such
/// layers have no contours.
///
/// # Errors
/// [`PlaneError`] when no plane meets the part, when there would be too many, or when a height in
/// the settings makes no sense.
pub fn layers(z_min: i64, z_max: i64, settings: &SlicingSettings) -> Result<Vec<LayerZ>, PlaneError> {
    let layer_mm = settings.layer_height;
    let first_mm = settings.first_layer_height.of(layer_mm);
    for (key, height_mm) in [("layer_height", layer_mm), ("first_layer_height", first_mm)] {
        if !height_mm.is_finite() || nm(height_mm) < 1 {
            return Err(PlaneError::Height { key, height_mm });
        }
    }
    let (bottom_mm, top_mm) = (mm(z_min), mm(z_max));
    // Estimated in floats before the loop, so that the loop is bounded.
    if (top_mm - 0.5 * first_mm) / layer_mm >= MAX_LAYERS as f64 {
        return Err(PlaneError::TooMany { top_mm, layer_mm });
    }
    let mut layers = Vec::new();
    let mut bottom = 0;
    for i in 0..=MAX_LAYERS as u32 {
        let above = f64::from(i);
        let slice_z = if i == 0 { nm(0.5 * first_mm) } else { nm(first_mm + (above - 0.5) * layer_mm) };
        if slice_z >= z_max {
            break;
        }
        let print_z = nm(first_mm + above * layer_mm);
        let fit = |z: i64| i32::try_from(z).map_err(|_| PlaneError::TooHigh { top_mm });
        layers.push(LayerZ {
            slice_z: fit(slice_z)?,
            print_z: fit(print_z)?,
            height: fit(print_z - bottom)?,
        });
        bottom = print_z;
    }
    match layers.last() {
        Some(top) if i64::from(top.slice_z) > z_min => Ok(layers),
        _ => Err(PlaneError::Thin { bottom_mm, top_mm, first_mm, layer_mm }),
    }
}

/// The layers of a mesh on the bed that the settings ask for, uniform or adaptive.
///
/// # Errors
/// [`PlaneError`]: see [`layers`].
pub fn of_mesh(mesh: &Mesh, settings: &Settings) -> Result<Vec<LayerZ>, PlaneError> {
    if settings.slicing.adaptive_layer_height {
        return adaptive::layers(mesh, &adaptive::AdaptivePlan::new(settings));
    }
    let [lo, hi] = mesh.world_bounds().unwrap_or_default();
    layers(lo[2], hi[2], &settings.slicing)
}

/// The layers' planes \[nm\] in the frame of a mesh whose lattice has its zero `mesh_origin_z` \[nm\]
/// above the bed; ascending, length = layers.
///
/// Planes beyond the lattice are moved to ±[`LIMIT`], where no vertex lies and no triangle meets them.
pub fn plane_zs(layers: &[LayerZ], mesh_origin_z: i64) -> Vec<i32> {
    let limit = i64::from(LIMIT);
    layers
        .iter()
        .map(|layer| i64::from(layer.slice_z).saturating_sub(mesh_origin_z).clamp(-limit, limit) as i32)
        .collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::settings::FloatOrPercent::{Float, Percent};

    fn settings(layer_height: f64, first: f64) -> SlicingSettings {
        SlicingSettings { layer_height, first_layer_height: Float(first), ..SlicingSettings::default() }
    }

    #[test]
    fn layers_are_cut_at_their_middles() {
        let list = layers(0, 1_000_000, &settings(0.3, 0.35)).unwrap();
        let planes: Vec<_> = list.iter().map(|l| l.slice_z).collect();
        assert_eq!(planes, [175_000, 500_000, 800_000]);
        assert_eq!(list.iter().map(|l| l.print_z).collect::<Vec<_>>(), [350_000, 650_000, 950_000]);
        assert_eq!(list.iter().map(|l| l.height).collect::<Vec<_>>(), [350_000, 300_000, 300_000]);
    }

    #[test]
    fn a_plane_at_the_very_top_is_left_out() {
        let half = settings(0.2, 0.2);
        assert_eq!(layers(0, 48_000_000, &half).unwrap().len(), 240);
        assert_eq!(layers(0, 500_000, &half).unwrap().len(), 2);
        assert_eq!(layers(0, 500_001, &half).unwrap().len(), 3);
    }

    #[test]
    fn rounding_does_not_add_up() {
        let list = layers(0, 100_000_000, &settings(1.0 / 3.0, 1.0 / 3.0)).unwrap();
        assert_eq!(list.len(), 300);
        assert_eq!(list[299].print_z, 100_000_000);
        assert_eq!(list.iter().map(|l| i64::from(l.height)).sum::<i64>(), 100_000_000);
        let percent = SlicingSettings { first_layer_height: Percent(150.0), ..settings(0.2, 0.0) };
        assert_eq!(layers(0, 1_000_000, &percent).unwrap()[0].print_z, 300_000);
    }

    #[test]
    fn what_cannot_be_layered_is_refused() {
        let fine = settings(0.2, 0.2);
        assert!(matches!(layers(0, 100_000, &fine), Err(PlaneError::Thin { .. })));
        assert!(matches!(layers(-5_000_000, -1_000_000, &fine), Err(PlaneError::Thin { .. })));
        assert!(matches!(layers(110_000, 290_000, &fine), Err(PlaneError::Thin { .. })));
        assert_eq!(layers(1_000_000, 1_200_000, &fine).unwrap().len(), 6);
        for bad in [0.0, -0.2, f64::NAN, f64::INFINITY, 1e-7] {
            assert!(matches!(layers(0, 1_000_000, &settings(bad, 0.2)), Err(PlaneError::Height { .. })));
            assert!(matches!(layers(0, 1_000_000, &settings(0.2, bad)), Err(PlaneError::Height { .. })));
        }
        assert!(matches!(layers(0, i64::MAX, &fine), Err(PlaneError::TooMany { .. })));
        assert!(matches!(layers(0, 1 << 30, &settings(1e-6, 1e-6)), Err(PlaneError::TooMany { .. })));
        assert!(matches!(layers(3_000_000_000, 4_000_000_000, &fine), Err(PlaneError::TooHigh { .. })));
        let error = layers(0, 100_000, &fine).unwrap_err().to_string();
        assert!(
            error.contains("0.1 mm") && error.contains("layer_height 0.2") && !error.contains('\n'),
            "{error}"
        );
    }

    #[test]
    fn planes_keep_their_index_in_the_mesh_frame() {
        let list = layers(0, 1_000_000, &settings(0.2, 0.2)).unwrap();
        assert_eq!(plane_zs(&list, 500_000), [-400_000, -200_000, 0, 200_000, 400_000]);
        assert_eq!(plane_zs(&list, i64::MAX), [-LIMIT; 5]);
        assert_eq!(plane_zs(&list, i64::MIN), [LIMIT; 5]);
    }
}
