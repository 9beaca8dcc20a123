//! Adapter choice, limits, kernels, read-back, timing; knows nothing of slicing.
