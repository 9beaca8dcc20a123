//! What a running job tells its caller.

/// Receives news of a running job. All methods may be called from any thread.
pub trait Progress: Sync {
    /// A stage begins.
    fn stage(&self, name: &'static str);

    /// So many of all layers are written.
    fn layers(&self, _done: u64, _all: u64) {}
}

/// Says nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _name: &'static str) {}
}
