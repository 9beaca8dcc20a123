//! STL, the two forms of it. Format: 3D Systems, "StereoLithography Interface Specification", 1988.

pub(super) mod ascii;
pub(super) mod binary;
