//! Threads that play the ranks of a problem, for tests.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use crate::{Letters, Pending, Ranks};

/// One of several threads of this process that play the ranks, for tests.
pub struct Rehearsal {
    rank: usize,
    size: usize,
    /// The number of exchanges so far.
    number: AtomicU64,
    post: Arc<Post>,
}

/// The words that are under way between the threads.
#[derive(Default)]
struct Post {
    /// By the number of the exchange, sender and receiver.
    letters: Mutex<Sent>,
    arrived: Condvar,
}

#[derive(Default)]
struct Sent {
    letters: HashMap<(u64, usize, usize), Vec<u64>>,
    /// A rank has panicked, and the others would wait for it.
    failed: bool,
}

impl Rehearsal {
    /// The results of `play` on each of `size` ranks.
    ///
    /// # Panics
    /// If a rank panics.
    pub fn of<R: Send>(size: usize, play: impl Fn(Arc<dyn Ranks>) -> R + Sync) -> Vec<R> {
        let post = Arc::new(Post::default());
        std::thread::scope(|scope| {
            let start = |rank| {
                let (post, play) = (Arc::clone(&post), &play);
                scope.spawn(move || {
                    let _witness = Witness(Arc::clone(&post));
                    play(Arc::new(Self { rank, size, number: AtomicU64::new(0), post }))
                })
            };
            let threads: Vec<_> = (0..size).map(start).collect();
            threads.into_iter().map(|thread| thread.join().expect("no rank panics")).collect()
        })
    }

    fn send(&self, letters: &Letters) -> u64 {
        let number = self.number.fetch_add(1, Ordering::Relaxed);
        let mut sent = self.post.letters.lock().unwrap_or_else(PoisonError::into_inner);
        let mut rest = &letters.out[..];
        for (to, length) in letters.out_lengths.iter().enumerate() {
            let (letter, after) = rest.split_at(*length);
            sent.letters.insert((number, self.rank, to), letter.to_vec());
            rest = after;
        }
        assert!(rest.is_empty(), "every word that is sent has a receiver");
        self.post.arrived.notify_all();
        number
    }

    fn receive(&self, number: u64, letters: &mut Letters) {
        let Letters { into, into_lengths, .. } = letters;
        let mut rest = &mut into[..];
        for (from, length) in into_lengths.iter().enumerate() {
            let (place, after) = rest.split_at_mut(*length);
            let mut sent = self.post.letters.lock().unwrap_or_else(PoisonError::into_inner);
            let letter = loop {
                assert!(!sent.failed, "another rank has panicked");
                match sent.letters.remove(&(number, from, self.rank)) {
                    Some(letter) => break letter,
                    None => sent = self.post.arrived.wait(sent).unwrap_or_else(PoisonError::into_inner),
                }
            };
            place.copy_from_slice(&letter);
            rest = after;
        }
        assert!(rest.is_empty(), "every word that is received has a sender");
    }
}

impl Ranks for Rehearsal {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn gather(&self, own: &[u64], all: &mut [u64], lengths: &[usize]) {
        assert_eq!(own.len(), lengths[self.rank], "the words of this rank");
        let mut letters = Letters {
            out: own.repeat(self.size),
            out_lengths: vec![own.len(); self.size],
            into: vec![0; all.len()],
            into_lengths: lengths.to_vec(),
        };
        let number = self.send(&letters);
        self.receive(number, &mut letters);
        all.copy_from_slice(&letters.into);
    }

    fn post(&self, letters: Letters) -> Box<dyn Pending + '_> {
        let number = self.send(&letters);
        Box::new(Sending { ranks: self, number, letters })
    }
}

struct Sending<'a> {
    ranks: &'a Rehearsal,
    number: u64,
    letters: Letters,
}

impl Pending for Sending<'_> {
    fn wait(self: Box<Self>) -> Letters {
        let Self { ranks, number, mut letters } = *self;
        ranks.receive(number, &mut letters);
        letters
    }
}

/// Tells the others if its thread panics.
struct Witness(Arc<Post>);

impl Drop for Witness {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.letters.lock().unwrap_or_else(PoisonError::into_inner).failed = true;
            self.0.arrived.notify_all();
        }
    }
}
