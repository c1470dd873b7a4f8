//! Distribution of work over threads, each with its own memory.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

/// Applies `work` to every item on one thread per worker; a free thread takes the next item. Each item owns the memory
/// that it writes, so the result does not depend on the assignment. A single worker (a small field, or a single thread)
/// runs on the calling thread.
pub fn distribute<I: Send, S: Send>(
    workers: &mut [S],
    items: impl Iterator<Item = I> + Send,
    work: impl Fn(I, &mut S) + Sync,
) {
    let items = Mutex::new(items);
    let next = || lock(&items).next();
    let serve = |worker: &mut S| {
        while let Some(item) = next() {
            work(item, worker);
        }
    };
    match workers {
        [worker] => serve(worker),
        workers => workers.par_iter_mut().with_max_len(1).for_each(serve),
    }
}

/// Locks `mutex` and ignores poisoning: a panic in an earlier call leaves no relevant state, since every call writes
/// all numbers before it reads them.
pub fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}
