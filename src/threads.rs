//! Work on several threads. A system that has no more threads costs time, never the work.

use std::panic::resume_unwind;
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, ScopedJoinHandle, available_parallelism, scope};

/// The number of threads that run at the same time on this machine; 1 if the system does not report it.
pub fn cores() -> usize {
    available_parallelism().map_or(1, usize::from)
}

/// Does the work on each item and returns the results in the items' order. `threads` of them, this one included, take the next item whenever
/// they have finished one, so that fewer threads do the same.
pub fn each<I: Send, T: Send>(
    threads: usize,
    items: impl IntoIterator<Item = I, IntoIter: Send>,
    work: impl Fn(I) -> T + Sync,
) -> Vec<T> {
    let queue = Mutex::new(items.into_iter().enumerate());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    let take = || std::iter::from_fn(next).map(|(number, item)| (number, work(item))).collect::<Vec<_>>();
    let mut done = scope(|scope| {
        let others: Vec<_> = (1..threads).map_while(|_| Builder::new().spawn_scoped(scope, take).ok()).collect();
        std::iter::once(take()).chain(others.into_iter().map(joined)).flatten().collect::<Vec<_>>()
    });
    done.sort_by_key(|(number, _)| *number);
    done.into_iter().map(|(_, result)| result).collect()
}

/// Does `aside` on another thread while this one does `here`, and returns what both return.
pub fn join<A: Send, B>(aside: impl Fn() -> A + Sync, here: impl FnOnce() -> B) -> (A, B) {
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
