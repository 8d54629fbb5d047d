//! How far a device is with the kernels of a render.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts the kernels that are ready. Some drivers compile a kernel when it is created, others when it is first dispatched: the count begins
/// anew with the dispatches.
#[derive(Debug, Default)]
pub struct CompileProgress {
    ready: AtomicUsize,
    all: AtomicUsize,
}

impl CompileProgress {
    /// Begins with so many kernels, of which none is ready.
    pub fn begin(&self, all: usize) {
        self.ready.store(0, Ordering::Relaxed);
        self.all.store(all, Ordering::Relaxed);
    }

    /// One more kernel is ready.
    pub fn advance(&self) {
        self.ready.fetch_add(1, Ordering::Relaxed);
    }

    /// The number of kernels that are ready, and of all; both 0 before anything begins.
    pub fn get(&self) -> (usize, usize) {
        (self.ready.load(Ordering::Relaxed), self.all.load(Ordering::Relaxed))
    }
}
