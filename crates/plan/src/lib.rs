//! [docs]: crate
#![doc = include_str!("../README.md")]

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
