//! The blocks of variables that a step moves: few of them if the contact is small.

use std::ops::Range;

use gfmd_vector::{LEAF, Split, pass_by};
use multiversion::multiversion;

use crate::preconditioned::BLOCK;

/// The active blocks: those with a variable or a direction that is not zero.
pub(super) struct Active {
    flags: Vec<bool>,
    /// True if stretches consist of whole blocks.
    aligned: bool,
}

impl Active {
    /// All blocks of `variables` variables, which are passed in stretches of `stretch`.
    pub(super) fn all(variables: usize, stretch: usize) -> Self {
        Self { flags: vec![true; variables.div_ceil(BLOCK)], aligned: stretch.is_multiple_of(BLOCK) }
    }

    /// The flags, for a problem that marks the active blocks itself.
    pub(super) fn flags_mut(&mut self) -> &mut [bool] {
        &mut self.flags
    }

    /// Finds the active blocks. Variables of idle blocks were and are zero.
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

    /// The active blocks of the range, which begins with a block.
    pub(super) fn blocks(&self, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
        let blocks = range.clone().step_by(BLOCK).map(move |start| start..range.end.min(start + BLOCK));
        blocks.filter(|block| self.flags[block.start / BLOCK])
    }

    /// The flags of the blocks in a form that can be divided into stretches.
    pub(super) fn flags(&self) -> Flags<'_> {
        if self.aligned { Flags::Known(&self.flags) } else { Flags::Unknown }
    }
}

/// The active blocks of a stretch, if they are known.
#[derive(Clone, Copy)]
pub(super) enum Flags<'a> {
    Unknown,
    Known(&'a [bool]),
}

impl Flags<'_> {
    /// True if a block is known to be idle.
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

/// Sets the flag of each block with a variable or a direction that is not zero.
#[multiversion(targets = "simd")]
fn find_active(x: &[f64], direction: &[f32], flags: &mut [bool]) {
    for (active, (x, z)) in flags.iter_mut().zip(x.chunks(BLOCK).zip(direction.chunks(BLOCK))) {
        *active = if *active { !is_idle(x, z) } else { moves(z) };
    }
}

/// True if all variables of a block are zero, and have no direction.
#[inline(always)]
pub(super) fn is_idle(x: &[f64], z: &[f32]) -> bool {
    !x.iter().fold(false, |any, x| any | (*x != 0.0)) & !moves(z)
}

/// True if a variable has a direction.
#[inline(always)]
fn moves(z: &[f32]) -> bool {
    z.iter().fold(false, |any, z| any | (*z != 0.0))
}
