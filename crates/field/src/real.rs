use std::iter::Sum;

use gfmd_vector::Rows;
use num_complex::Complex;
use rustdct::DctNum;
use rustfft::num_traits::{ConstZero, NumAssign};

/// The numbers of a field: `f64`, or `f32` at half the memory and time, with seven digits.
pub trait Real: DctNum + ConstZero + NumAssign + Default + Sum + Wire + Plans {
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

pub(crate) use private::Plans;
use private::Wire;

mod private {
    use std::sync::Arc;

    use num_complex::Complex;
    use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
    use rustdct::{DctPlanner, TransformType2And3};
    use rustfft::{Fft, FftPlanner};

    /// Plans of transforms ahead and back. The planners are generic: called in functions that are not, they are compiled here only,
    /// and not in every crate that has a transform.
    pub trait Plans: Sized {
        /// Transforms of real rows.
        fn real(points: usize) -> (Arc<dyn RealToComplex<Self>>, Arc<dyn ComplexToReal<Self>>);

        /// Transforms of complex rows.
        fn complex(points: usize) -> (Arc<dyn Fft<Self>>, Arc<dyn Fft<Self>>);

        /// In cosines, of rows of either number of points.
        fn cosines(points: [usize; 2]) -> [Arc<dyn TransformType2And3<Self>>; 2];
    }

    macro_rules! plans {
        ($number:ty) => {
            impl Plans for $number {
                fn real(points: usize) -> (Arc<dyn RealToComplex<Self>>, Arc<dyn ComplexToReal<Self>>) {
                    let mut planner = RealFftPlanner::new();
                    (planner.plan_fft_forward(points), planner.plan_fft_inverse(points))
                }

                fn complex(points: usize) -> (Arc<dyn Fft<Self>>, Arc<dyn Fft<Self>>) {
                    let mut planner = FftPlanner::new();
                    (planner.plan_fft_forward(points), planner.plan_fft_inverse(points))
                }

                fn cosines(points: [usize; 2]) -> [Arc<dyn TransformType2And3<Self>>; 2] {
                    let mut planner = DctPlanner::new();
                    points.map(|points| planner.plan_dct2(points))
                }
            }
        };
    }

    plans!(f32);
    plans!(f64);

    /// Complex numbers as words that travel between processes. No other crate can name it, and thus make other numbers.
    pub trait Wire: Sized {
        /// The number of words of a complex number.
        const WORDS: usize;

        /// Writes its words.
        fn put(number: &Complex<Self>, words: &mut [u64]);

        /// The number of these words.
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

/// |z|².
pub(crate) fn square<T: Real>(z: &Complex<T>) -> f64 {
    let [re, im] = [z.re.widened(), z.im.widened()];
    re * re + im * im
}

/// A sink that copies a row of the result.
pub(crate) fn copy<T: Copy + Send>(_: usize, row: &mut [T], Rows(out, _): Rows<&mut [T]>) {
    out.copy_from_slice(row);
}
