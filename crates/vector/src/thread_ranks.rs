//! Threads that act as the ranks of a problem, for tests.

use std::collections::HashMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use crate::{Messages, Pending, Ranks};

/// Mock communicator: one of several threads of this process that act as ranks, for tests.
pub struct ThreadRanks {
    rank: usize,
    size: usize,
    /// Number of exchanges so far.
    number: AtomicU64,
    mailbox: Arc<Mailbox>,
}

/// Messages sent and not yet received.
#[derive(Default)]
struct Mailbox {
    /// Messages by exchange number, sender and receiver.
    messages: Mutex<Sent>,
    arrived: Condvar,
}

#[derive(Default)]
struct Sent {
    messages: HashMap<(u64, usize, usize), Vec<u64>>,
    /// True if a rank has panicked, so that the others must not wait for it.
    failed: bool,
}

impl ThreadRanks {
    /// Runs `play` on each of `size` ranks and returns the results.
    ///
    /// # Panics
    /// If a rank panics.
    pub fn of<R: Send>(size: usize, play: impl Fn(Arc<dyn Ranks>) -> R + Sync) -> Vec<R> {
        let mailbox = Arc::new(Mailbox::default());
        std::thread::scope(|scope| {
            let start = |rank| {
                let (mailbox, play) = (Arc::clone(&mailbox), &play);
                scope.spawn(move || {
                    let _guard = PanicGuard(Arc::clone(&mailbox));
                    play(Arc::new(Self { rank, size, number: AtomicU64::new(0), mailbox }))
                })
            };
            let threads: Vec<_> = (0..size).map(start).collect();
            threads.into_iter().map(|thread| thread.join().expect("no rank panics")).collect()
        })
    }

    fn send(&self, messages: &Messages) -> u64 {
        let number = self.number.fetch_add(1, Ordering::Relaxed);
        let mut sent = self.mailbox.messages.lock().unwrap_or_else(PoisonError::into_inner);
        let mut rest = &messages.out[..];
        for (to, length) in messages.out_lengths.iter().enumerate() {
            let (message, after) = rest.split_at(*length);
            sent.messages.insert((number, self.rank, to), message.to_vec());
            rest = after;
        }
        assert!(rest.is_empty(), "every word that is sent has a receiver");
        self.mailbox.arrived.notify_all();
        number
    }

    fn receive(&self, number: u64, messages: &mut Messages) {
        let Messages { into, into_lengths, .. } = messages;
        let mut rest = &mut into[..];
        for (from, length) in into_lengths.iter().enumerate() {
            let (place, after) = rest.split_at_mut(*length);
            let mut sent = self.mailbox.messages.lock().unwrap_or_else(PoisonError::into_inner);
            let message = loop {
                assert!(!sent.failed, "another rank has panicked");
                match sent.messages.remove(&(number, from, self.rank)) {
                    Some(message) => break message,
                    None => sent = self.mailbox.arrived.wait(sent).unwrap_or_else(PoisonError::into_inner),
                }
            };
            place.copy_from_slice(&message);
            rest = after;
        }
        assert!(rest.is_empty(), "every word that is received has a sender");
    }
}

impl Ranks for ThreadRanks {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.size
    }

    fn gather(&self, own: &[u64], all: &mut [u64], lengths: &[usize]) {
        assert_eq!(own.len(), lengths[self.rank], "the words of this rank");
        let mut messages = Messages {
            out: own.repeat(self.size),
            out_lengths: vec![own.len(); self.size],
            into: vec![0; all.len()],
            into_lengths: lengths.to_vec(),
        };
        let number = self.send(&messages);
        self.receive(number, &mut messages);
        all.copy_from_slice(&messages.into);
    }

    fn post(&self, messages: Messages) -> Box<dyn Pending + '_> {
        let number = self.send(&messages);
        Box::new(Sending { ranks: self, number, messages })
    }
}

struct Sending<'a> {
    ranks: &'a ThreadRanks,
    number: u64,
    messages: Messages,
}

impl Pending for Sending<'_> {
    fn wait(self: Box<Self>) -> Messages {
        let Self { ranks, number, mut messages } = *self;
        ranks.receive(number, &mut messages);
        messages
    }
}

/// Marks the exchange as failed if its thread panics.
struct PanicGuard(Arc<Mailbox>);

impl Drop for PanicGuard {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.messages.lock().unwrap_or_else(PoisonError::into_inner).failed = true;
            self.0.arrived.notify_all();
        }
    }
}
