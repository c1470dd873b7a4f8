//! Stiffness of a patch whose points in contact stick to each other: conjugate gradients for the traction that moves
//! them towards the body by one, without lateral motion (theory.md, section 7.3).

use gfmd_contact::{Effort, Stiffness};
use gfmd_field::Share;
use gfmd_relax::Why;
use gfmd_vector::for_each;

use super::response::Response;
use crate::numbers::dot;

/// Largest number of iterations; some 30 to 100 are usual.
const ITERATIONS: u64 = 2000;

/// Points of a patch that stick.
pub(super) struct Stuck<'a> {
    pub(super) response: &'a Response,
    pub(super) share: &'a Share,
    /// 1 for each component of each point that the rigid surface holds, 0 elsewhere; z last.
    pub(super) held: Vec<f64>,
}

impl Stuck<'_> {
    /// Computes the stiffness, force per point and displacement, to the relative error `tolerance`. The energy of the
    /// residual r is at most |r|² times the largest stiffness, and bounds the error.
    ///
    /// # Errors
    /// Returns the stiffness reached, if its error exceeds the tolerance, and the reason.
    pub(super) fn stiffness(&self, tolerance: f64) -> Result<Stiffness, (Stiffness, Why)> {
        let Self { response, share, held } = self;
        let (components, mut transforms) = (response.components(), response.transforms());
        let z = components.normal() * held.len() / components.len();
        let [_, stiffest] = response.stiffness_range();
        let points = if share.is_whole() { held.len() - z } else { share.total() } as f64;
        let mut traction = vec![0.0; held.len()];
        let mut residual: Vec<f64> = held.iter().enumerate().map(|(i, held)| if i < z { 0.0 } else { *held }).collect();
        let asked = residual.clone();
        let (mut direction, mut moved) = (residual.clone(), vec![0.0; held.len()]);
        let mut square = dot(share, &residual, &residual);
        let mut found = Stiffness { value: 0.0, error: 0.0, effort: Effort::default() };
        let mut why = Why::Iterations;
        while square > 0.0 && found.effort.iterations < ITERATIONS {
            transforms.compliance(&direction, &mut moved);
            for_each([&mut moved[..]], &|start, [moved]| {
                moved.iter_mut().zip(&held[start..]).for_each(|(moved, held)| *moved *= held);
            });
            let length = square / dot(share, &direction, &moved);
            // Rounding errors may leave no descent.
            if length <= 0.0 || length.is_nan() {
                why = Why::Rounding;
                break;
            }
            add_times(&mut traction, length, &direction);
            add_times(&mut residual, -length, &moved);
            let next = dot(share, &residual, &residual);
            let sum = dot(share, &asked, &traction);
            found = Stiffness {
                value: sum / points,
                error: stiffest * next / sum,
                effort: Effort { iterations: found.effort.iterations + 1, transform_pairs: transforms.pairs() },
            };
            if found.error <= tolerance {
                return Ok(found);
            }
            let ratio = next / square;
            for_each([&mut direction[..]], &|start, [direction]| {
                direction.iter_mut().zip(&residual[start..]).for_each(|(d, r)| *d = r + ratio * *d);
            });
            square = next;
        }
        if found.effort.iterations == 0 { Ok(found) } else { Err((found, why)) }
    }
}

/// Adds a multiple of a vector.
fn add_times(sum: &mut [f64], factor: f64, by: &[f64]) {
    for_each([sum], &|start, [sum]| sum.iter_mut().zip(&by[start..]).for_each(|(sum, by)| *sum += factor * by));
}
