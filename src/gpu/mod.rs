//! Adapter choice, limits, kernels, read-back, timing; knows nothing of slicing.
//!
//! Everything that can fail does so with a [`GpuError`]: a missing driver, a refused allocation, a
//! lost device and a hung kernel are results, never panics.

pub mod adapter;
pub mod buffer;
pub mod device;
pub mod dispatch;
pub mod error;
pub mod kernel;
pub mod scan;
pub mod sort;
pub mod timing;

pub use adapter::{AdapterInfo, Selection, adapters, choose};
pub use buffer::Buffer;
pub use device::{Device, Fault, FaultKind, Options};
pub use error::GpuError;
