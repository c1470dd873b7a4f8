//! Several wave vectors at once, for vector instructions.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

/// Number of wave vectors in a pack.
pub(crate) const WIDTH: usize = 8;

/// One number for each wave vector of a pack.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Pack(pub(crate) [f64; WIDTH]);

impl Pack {
    pub(crate) const ZERO: Self = Self([0.0; WIDTH]);

    #[inline(always)]
    pub(crate) fn all(value: f64) -> Self {
        Self([value; WIDTH])
    }

    #[inline(always)]
    pub(crate) fn inverse(mut self) -> Self {
        for x in &mut self.0 {
            *x = 1.0 / *x;
        }
        self
    }
}

macro_rules! each {
    ($operation:ident $name:ident $sign:tt) => {
        impl $operation for Pack {
            type Output = Self;

            #[inline(always)]
            fn $name(mut self, other: Self) -> Self {
                for k in 0..WIDTH {
                    self.0[k] $sign other.0[k];
                }
                self
            }
        }
    };
}

each!(Add add +=);
each!(Sub sub -=);
each!(Mul mul *=);

impl Mul<f64> for Pack {
    type Output = Self;

    #[inline(always)]
    fn mul(mut self, factor: f64) -> Self {
        for x in &mut self.0 {
            *x *= factor;
        }
        self
    }
}

impl Neg for Pack {
    type Output = Self;

    #[inline(always)]
    fn neg(mut self) -> Self {
        for x in &mut self.0 {
            *x = -*x;
        }
        self
    }
}

impl AddAssign for Pack {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
