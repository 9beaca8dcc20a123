//! Names of outputs that collide with no other.
