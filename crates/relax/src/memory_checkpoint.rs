use crate::Visit;

/// Checkpoint in memory: a visitor that records variables and restores them later, bit for bit.
///
/// ```
/// use gfmd_relax::{MemoryCheckpoint, Visit};
///
/// let mut checkpoint = MemoryCheckpoint::default();
/// checkpoint.field(&mut [0.1, f64::NAN]);
/// checkpoint.rewind();
/// let mut back = [0.0; 2];
/// checkpoint.field(&mut back);
/// assert!(back[0] == 0.1 && back[1].is_nan() && checkpoint.is_at_end());
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MemoryCheckpoint {
    bits: Vec<u64>,
    /// Number of words read; `None` while the checkpoint records.
    read: Option<usize>,
}

impl MemoryCheckpoint {
    /// Switches to reading, from the beginning.
    pub fn rewind(&mut self) {
        self.read = Some(0);
    }

    /// Returns true if all recorded variables have been read; always false before [`rewind`](Self::rewind).
    pub fn is_at_end(&self) -> bool {
        self.read.is_some_and(|read| read >= self.bits.len())
    }

    /// Records or replaces one word. Beyond the end, it replaces nothing.
    fn word(&mut self, word: u64) -> u64 {
        let Some(read) = &mut self.read else {
            self.bits.push(word);
            return word;
        };
        *read += 1;
        self.bits.get(*read - 1).copied().unwrap_or(word)
    }
}

impl Visit for MemoryCheckpoint {
    fn number(&mut self, x: &mut f64) {
        *x = f64::from_bits(self.word(x.to_bits()));
    }

    fn count(&mut self, n: &mut u64) {
        *n = self.word(*n);
    }

    fn field(&mut self, x: &mut [f64]) {
        x.iter_mut().for_each(|x| self.number(x));
    }
}
