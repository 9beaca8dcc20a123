//! Where the planes lie.

/// One layer of the print; heights above the bed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LayerZ {
    /// Height of the cutting plane, the layer's middle \[nm\].
    pub slice_z: i32,
    /// Height of the layer's top, where the nozzle runs \[nm\].
    pub print_z: i32,
    /// Thickness \[nm\].
    pub height: i32,
}
