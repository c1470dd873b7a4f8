//! Communication between processes that share one problem.

/// Processes that share the rows of one problem. All processes call the same methods in the same order, each from one
/// thread at a time. Messages consist of 64-bit words, so that every number is sent exactly.
pub trait Ranks: Send + Sync {
    /// Returns the number of this process, counted from zero.
    fn rank(&self) -> usize;

    /// Returns the number of processes.
    fn size(&self) -> usize;

    /// Gathers the words `own` of each rank into `all`, in rank order; rank r sends `lengths[r]` words.
    fn gather(&self, own: &[u64], all: &mut [u64], lengths: &[usize]);

    /// Starts sending `messages.out` and receiving `messages.into`. Several exchanges may be pending at once.
    fn post(&self, messages: Messages) -> Box<dyn Pending + '_>;
}

/// Send and receive buffers of an exchange of all ranks with each other. A pending exchange owns its buffers, so that
/// they cannot be accessed; they are allocated once and reused.
#[derive(Clone, Debug, Default)]
pub struct Messages {
    /// Words to send, in the order of the receiving ranks.
    pub out: Vec<u64>,
    /// Number of words sent to each rank.
    pub out_lengths: Vec<usize>,
    /// Words received, in the order of the sending ranks.
    pub into: Vec<u64>,
    /// Number of words received from each rank.
    pub into_lengths: Vec<usize>,
}

/// Pending exchange.
pub trait Pending {
    /// Waits for the end of the exchange and returns its buffers.
    fn wait(self: Box<Self>) -> Messages;
}

/// Single process, the default of every problem.
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

    fn post(&self, mut messages: Messages) -> Box<dyn Pending + '_> {
        let Messages { out, into, .. } = &mut messages;
        into.copy_from_slice(out);
        Box::new(Arrived(messages))
    }
}

/// Finished exchange.
struct Arrived(Messages);

impl Pending for Arrived {
    fn wait(self: Box<Self>) -> Messages {
        self.0
    }
}
