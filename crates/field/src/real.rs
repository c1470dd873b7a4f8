use std::iter::Sum;

use gfmd_vector::Rows;
use num_complex::Complex;
use rustdct::DctNum;
use rustfft::num_traits::{ConstZero, NumAssign};

/// The numbers of a field: `f64`, or `f32` at half the memory and time, with seven digits.
pub trait Real: DctNum + ConstZero + NumAssign + Default + Sum + private::Sealed {
    /// The nearest number of this kind.
    fn nearest(x: f64) -> Self;

    /// The same number.
    fn widened(self) -> f64;
}

impl Real for f64 {
    fn nearest(x: f64) -> Self {
        x
    }

    fn widened(self) -> f64 {
        self
    }
}

impl Real for f32 {
    fn nearest(x: f64) -> Self {
        x as Self
    }

    fn widened(self) -> f64 {
        self.into()
    }
}

mod private {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// |z|².
pub(crate) fn square<T: Real>(z: &Complex<T>) -> f64 {
    let [re, im] = [z.re.widened(), z.im.widened()];
    re * re + im * im
}

/// A sink that copies a row of the result.
pub(crate) fn copy<T: Copy + Send>(_: usize, row: &mut [T], Rows(out, _): Rows<&mut [T]>) {
    out.copy_from_slice(row);
}
