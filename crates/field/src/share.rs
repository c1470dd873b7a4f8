//! Work handed out to threads, each with memory of its own.

use std::sync::{Mutex, MutexGuard, PoisonError};

use rayon::prelude::*;

/// Does `work` on every item, on as many threads as there are `seats`; whoever is free takes the next item. Items own
/// what they write, so the result does not depend on who takes which. One seat: on the calling thread, in order.
pub(crate) fn share<I: Send, S: Send>(
    seats: &mut [S],
    items: impl Iterator<Item = I> + Send,
    work: impl Fn(I, &mut S) + Sync,
) {
    if let [seat] = seats {
        items.for_each(|item| work(item, seat));
        return;
    }
    let items = Mutex::new(items);
    let next = || lock(&items).next();
    seats.par_iter_mut().with_max_len(1).for_each(|seat| {
        while let Some(item) = next() {
            work(item, seat);
        }
    });
}

/// Locks, whatever became of those who held the lock before: numbers behind it cannot be left half-moved in a way that
/// matters, since every call writes all of them before it reads.
pub(crate) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_item_is_done_once_with_any_number_of_seats() {
        for seats in [1, 2, 3, 7] {
            let mut done = vec![0; 100];
            let mut counts = vec![0; seats];
            share(&mut counts, done.iter_mut().enumerate(), |(number, done), count| {
                *done += number;
                *count += 1;
            });
            assert!(done.iter().enumerate().all(|(number, done)| number == *done));
            assert_eq!(counts.iter().sum::<usize>(), 100);
        }
    }
}
