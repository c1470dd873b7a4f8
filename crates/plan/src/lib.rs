//! Plans of fast Fourier transforms, compiled once.
//!
//! The planners of RustFFT, `realfft` and `rustdct` are generic and take a minute to compile. The functions here are
//! not generic, so the planners are compiled once instead of with every crate and test that uses transforms.
//!
//! ```
//! use gfmd_plan::Plans;
//!
//! let (ahead, back) = f64::real(4);
//! let (mut row, mut spectrum) = (vec![1.0, 2.0, 3.0, 4.0], ahead.make_output_vec());
//! ahead.process(&mut row, &mut spectrum)?;
//! assert_eq!(spectrum[0].re, 10.0);
//! back.process(&mut spectrum, &mut row)?;
//! assert_eq!(row, [4.0, 8.0, 12.0, 16.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::sync::Arc;

use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustdct::{DctPlanner, TransformType2And3};
use rustfft::{Fft, FftPlanner};

/// Plans of forward and inverse transforms, in single and in double precision.
pub trait Plans: Sized {
    /// Plans transforms of real rows of `points` points to half spectra and back, without normalisation.
    fn real(points: usize) -> (Arc<dyn RealToComplex<Self>>, Arc<dyn ComplexToReal<Self>>);

    /// Plans transforms of complex rows of `points` points and back, without normalisation.
    fn complex(points: usize) -> (Arc<dyn Fft<Self>>, Arc<dyn Fft<Self>>);

    /// Plans cosine transforms (types 2 and 3) for rows of each of two lengths.
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
