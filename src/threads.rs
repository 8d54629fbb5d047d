//! Work on several threads. A system that has no more threads costs time, never the work.

use std::panic::resume_unwind;
use std::thread::{Builder, ScopedJoinHandle, scope};

/// Does `work` on this thread and on as many others that together there are `threads`, and returns what all of them return. `work`
/// takes its parts from a common queue, so that fewer threads do the same.
pub fn together<T: Send>(threads: usize, work: impl Fn() -> T + Sync) -> Vec<T> {
    scope(|scope| {
        let others: Vec<_> = (1..threads).map_while(|_| Builder::new().spawn_scoped(scope, &work).ok()).collect();
        std::iter::once(work()).chain(others.into_iter().map(joined)).collect()
    })
}

/// Does `aside` on another thread while this one does `here`, and returns what both return.
pub fn beside<A: Send, B>(aside: impl Fn() -> A + Sync, here: impl FnOnce() -> B) -> (A, B) {
    scope(|scope| {
        let other = Builder::new().spawn_scoped(scope, &aside);
        let here = here();
        (other.map_or_else(|_| aside(), joined), here)
    })
}

/// What a thread returns; if it panicked, so does this one.
fn joined<T>(thread: ScopedJoinHandle<'_, T>) -> T {
    thread.join().unwrap_or_else(|panic| resume_unwind(panic))
}
