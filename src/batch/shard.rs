//! One of several machines that share a batch.

use serde::{Deserialize, Serialize};

/// The part of a batch that one process does: `index` of `count`, from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shard {
    /// Which, from 1.
    pub index: u32,
    /// Of how many.
    pub count: u32,
}

impl Default for Shard {
    fn default() -> Self {
        Self { index: 1, count: 1 }
    }
}

impl Shard {
    /// Whether a model with this SHA-256 belongs to the shard. Does not depend on other models, names or folders.
    pub fn holds(&self, sha256: &str) -> bool {
        let head = u64::from_str_radix(sha256.get(..16).unwrap_or_default(), 16).unwrap_or_default();
        head % u64::from(self.count.max(1)) == u64::from(self.index.saturating_sub(1))
    }
}
