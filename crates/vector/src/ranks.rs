//! Processes that share one problem, and what they send each other.

/// Processes that share the rows of one problem. All of them call the same methods in the same order, each from one thread at a
/// time. What travels are words of 64 bits, since every number fits whole words and none is rounded on its way.
pub trait Ranks: Send + Sync {
    /// The number of this process, from zero.
    fn rank(&self) -> usize;

    /// The number of processes.
    fn size(&self) -> usize;

    /// Fills `all` with what each rank gives as `own`, one after another; rank r gives `lengths[r]` words.
    fn gather(&self, own: &[u64], all: &mut [u64], lengths: &[usize]);

    /// Begins to send `letters.out` and to receive `letters.into`. More than one exchange may be under way.
    fn post(&self, letters: Letters) -> Box<dyn Pending + '_>;
}

/// The words that each rank gets of this one and this one gets of each, one after another. The exchange owns it while
/// it lasts, so that nobody can touch it; it is made once and used again.
#[derive(Clone, Debug, Default)]
pub struct Letters {
    /// The words that are sent, first to rank 0.
    pub out: Vec<u64>,
    /// The number of words for each rank.
    pub out_lengths: Vec<usize>,
    /// The words that are received, first from rank 0.
    pub into: Vec<u64>,
    /// The number of words from each rank.
    pub into_lengths: Vec<usize>,
}

/// An exchange under way.
pub trait Pending {
    /// Waits for its end.
    fn wait(self: Box<Self>) -> Letters;
}

/// One process, with which every problem starts.
#[derive(Clone, Copy, Debug, Default)]
pub struct Alone;

impl Ranks for Alone {
    fn rank(&self) -> usize {
        0
    }

    fn size(&self) -> usize {
        1
    }

    fn gather(&self, own: &[u64], all: &mut [u64], _: &[usize]) {
        all.copy_from_slice(own);
    }

    fn post(&self, mut letters: Letters) -> Box<dyn Pending + '_> {
        let Letters { out, into, .. } = &mut letters;
        into.copy_from_slice(out);
        Box::new(Arrived(letters))
    }
}

/// An exchange that is over.
struct Arrived(Letters);

impl Pending for Arrived {
    fn wait(self: Box<Self>) -> Letters {
        self.0
    }
}
