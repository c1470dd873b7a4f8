//! Blocks of variables moved by a step; few if the contact is small.

use std::ops::Range;

use gfmd_vector::{LEAF, Split, pass_by};
use multiversion::multiversion;

use crate::preconditioned::BLOCK;

/// Active blocks: blocks with a non-zero variable or direction.
pub(super) struct Active {
    flags: Vec<bool>,
    /// True if stretches consist of whole blocks.
    aligned: bool,
}

impl Active {
    /// Marks all blocks of `variables` variables as active; `stretch` is the length of a stretch.
    pub(super) fn all(variables: usize, stretch: usize) -> Self {
        Self { flags: vec![true; variables.div_ceil(BLOCK)], aligned: stretch.is_multiple_of(BLOCK) }
    }

    /// Returns the flags for a problem that marks the active blocks itself.
    pub(super) fn flags_mut(&mut self) -> &mut [bool] {
        &mut self.flags
    }

    /// Finds the active blocks. Variables of idle blocks are zero before and after.
    pub(super) fn survey(&mut self, x: &[f64], direction: &[f32]) {
        pass_by(
            LEAF / BLOCK,
            &mut self.flags[..],
            &|start, flags| {
                let first = start * BLOCK;
                find_active(&x[first..], &direction[first..], flags);
            },
            &|(), ()| (),
        );
    }

    /// Returns the active blocks of the range, which begins at a block boundary.
    pub(super) fn blocks(&self, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let blocks = range.clone().step_by(BLOCK).map(move |start| start..range.end.min(start + BLOCK));
        blocks.filter(|block| self.flags[block.start / BLOCK])
    }

    /// Returns the block flags in a form that can be split into stretches.
    pub(super) fn flags(&self) -> Flags<'_> {
        if self.aligned { Flags::Known(&self.flags) } else { Flags::Unknown }
    }
}

/// Active blocks of a stretch, if known.
#[derive(Clone, Copy)]
pub(super) enum Flags<'a> {
    Unknown,
    Known(&'a [bool]),
}

impl Flags<'_> {
    /// Returns true if a block is known to be idle.
    #[inline(always)]
    pub(super) fn idle(self, block: usize) -> bool {
        match self {
            Self::Unknown => false,
            Self::Known(flags) => !flags[block],
        }
    }
}

impl Split for Flags<'_> {
    fn length(&self) -> usize {
        usize::MAX
    }

    fn fits(&self, length: usize) -> bool {
        match self {
            Self::Unknown => true,
            Self::Known(flags) => flags.len() == length.div_ceil(BLOCK),
        }
    }

    fn split(self, middle: usize) -> (Self, Self) {
        match self {
            Self::Known(flags) if middle.is_multiple_of(BLOCK) => {
                let (first, last) = flags.split_at(middle / BLOCK);
                (Self::Known(first), Self::Known(last))
            }
            _ => (Self::Unknown, Self::Unknown),
        }
    }
}

/// Sets the flag of each block with a non-zero variable or direction.
#[multiversion(targets = "simd")]
fn find_active(x: &[f64], direction: &[f32], flags: &mut [bool]) {
    for (active, (x, z)) in flags.iter_mut().zip(x.chunks(BLOCK).zip(direction.chunks(BLOCK))) {
        *active = if *active { !is_idle(x, z) } else { moves(z) };
    }
}

/// Returns true if all variables and directions of a block are zero.
#[inline(always)]
pub(super) fn is_idle(x: &[f64], z: &[f32]) -> bool {
    !x.iter().fold(false, |any, x| any | (*x != 0.0)) & !moves(z)
}

/// Returns true if any direction is not zero.
#[inline(always)]
fn moves(z: &[f32]) -> bool {
    z.iter().fold(false, |any, z| any | (*z != 0.0))
}
