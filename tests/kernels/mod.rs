//! Kernels for tests alone, assembled as the crate assembles its own.

use microtome::shaders::{Binding, Kernel};

/// One rounded 64-bit fraction per item. Bindings: sizes, operands, results.
pub const DIVIDE: Kernel = Kernel {
    name: "divide",
    wgsl: concat!(
        include_str!("../../shaders/shared/grid.wgsl"),
        include_str!("../../shaders/shared/wide.wgsl"),
        include_str!("divide.wgsl")
    ),
    bindings: &[Binding::Uniform, Binding::Read, Binding::Write],
};

/// Adds a hash of its number to every item. Bindings: sizes, items.
pub const FOLD: Kernel = Kernel {
    name: "fold",
    wgsl: concat!(include_str!("../../shaders/shared/grid.wgsl"), include_str!("fold.wgsl")),
    bindings: &[Binding::Uniform, Binding::Write],
};
