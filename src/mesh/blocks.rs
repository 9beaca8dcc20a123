//! How many contiguous blocks a run over the facets is split into.

/// Facets below which a block is not worth a thread of its own.
const FACETS: usize = 1 << 17;

/// Every block is compared with the ones before it: more blocks than this cost more than they save.
const LIMIT: usize = 8;

/// Number of blocks, at least one, for the threads of the current rayon pool.
pub(super) fn blocks(facets: usize) -> usize {
    rayon::current_num_threads().min(facets / FACETS).clamp(1, LIMIT)
}
