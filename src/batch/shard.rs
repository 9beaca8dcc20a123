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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::key::sha256;

    #[test]
    fn each_model_is_in_one_shard() {
        for count in [1, 2, 3, 7, 100] {
            let mut held = vec![0u32; count as usize];
            for model in 0..2000u32 {
                let hash = sha256(&model.to_le_bytes());
                let holders: Vec<u32> =
                    (1..=count).filter(|&index| Shard { index, count }.holds(&hash)).collect();
                assert_eq!(holders.len(), 1, "model {model} of {count} shards");
                held[holders[0] as usize - 1] += 1;
            }
            let mean = 2000 / count;
            let fair = |n: &u32| *n > mean / 3 && *n < 3 * mean;
            assert!(held.iter().all(fair), "{held:?}");
        }
    }

    #[test]
    fn the_shard_of_a_model_is_that_of_its_content_alone() {
        let hash = sha256(b"abc");
        // ba7816bf8f01cfea
        let head = 0xba78_16bf_8f01_cfea_u64;
        for count in 1..50 {
            let index = u32::try_from(head % u64::from(count)).unwrap_or_default() + 1;
            assert!(Shard { index, count }.holds(&hash), "{index} of {count}");
        }
        assert!(Shard::default().holds("") && Shard::default().holds("no hash"));
    }
}
