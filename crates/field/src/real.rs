use std::iter::Sum;

use gfmd_plan::Plans;
use gfmd_vector::{Rows, Word};
use num_complex::Complex;
use rustdct::DctNum;
use rustfft::num_traits::{ConstZero, NumAssign};

/// Number type of a field: `f64`, or `f32` at half the memory and time, with seven digits.
pub trait Real: DctNum + ConstZero + NumAssign + Default + Sum + Word + Wire + Plans {
    /// Returns the nearest number of this type.
    fn nearest(x: f64) -> Self;

    /// Converts the number to `f64`.
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

use private::Wire;

mod private {
    use num_complex::Complex;

    /// Complex numbers as words sent between processes. The trait is sealed: no other crate can implement it.
    pub trait Wire: Sized {
        /// Number of words of a complex number.
        const WORDS: usize;

        /// Writes the words of a number.
        fn put(number: &Complex<Self>, words: &mut [u64]);

        /// Reads a number from its words.
        fn get(words: &[u64]) -> Complex<Self>;
    }

    impl Wire for f32 {
        const WORDS: usize = 1;

        fn put(number: &Complex<Self>, words: &mut [u64]) {
            words[0] = u64::from(number.re.to_bits()) | u64::from(number.im.to_bits()) << 32;
        }

        fn get(words: &[u64]) -> Complex<Self> {
            Complex::new(Self::from_bits(words[0] as u32), Self::from_bits((words[0] >> 32) as u32))
        }
    }

    impl Wire for f64 {
        const WORDS: usize = 2;

        fn put(number: &Complex<Self>, words: &mut [u64]) {
            (words[0], words[1]) = (number.re.to_bits(), number.im.to_bits());
        }

        fn get(words: &[u64]) -> Complex<Self> {
            Complex::new(Self::from_bits(words[0]), Self::from_bits(words[1]))
        }
    }
}

/// Returns |z|².
pub(crate) fn square<T: Real>(z: &Complex<T>) -> f64 {
    let [re, im] = [z.re.widened(), z.im.widened()];
    re * re + im * im
}

/// Copies a row of the result to the output.
pub(crate) fn copy<T: Copy + Send>(_: usize, row: &mut [T], Rows(out, _): Rows<&mut [T]>) {
    out.copy_from_slice(row);
}
