use std::ops::Range;

use gfmd_response::FullTransforms;
use gfmd_vector::{for_each, reduce};

use crate::{MixedProblem, Prescribed};

/// Surface during a solve: the traction, given on free entries, and its displacement.
pub(crate) struct Surface<'a> {
    pub(crate) problem: &'a MixedProblem,
    pub(crate) traction: Vec<f64>,
    /// Displacement G t at the last [`certify`](Self::certify).
    pub(crate) displacement: Vec<f64>,
    /// Prescribed minus computed displacement on held entries, zero on free ones, at the last certify.
    pub(crate) misfit: Vec<f64>,
    /// Largest misfit without traction on the held entries.
    pub(crate) scale: f64,
    pub(crate) transforms: FullTransforms,
}

impl<'a> Surface<'a> {
    pub(crate) fn new(problem: &'a MixedProblem) -> Self {
        let Prescribed { held, values, .. } = &problem.prescribed;
        let traction: Vec<f64> =
            held.iter().zip(values).map(|(held, value)| if *held { 0.0 } else { *value }).collect();
        let mut surface = Self {
            problem,
            displacement: vec![0.0; traction.len()],
            misfit: vec![0.0; traction.len()],
            traction,
            scale: 1.0,
            transforms: FullTransforms::of(&problem.response),
        };
        surface.certify();
        surface.scale = largest(&surface.misfit);
        surface
    }

    /// Recomputes displacement and misfit from the traction.
    pub(crate) fn certify(&mut self) {
        self.transforms.compliance(&self.traction, &mut self.displacement);
        let (displacement, Prescribed { held, values, .. }) = (&self.displacement, &self.problem.prescribed);
        for_each([&mut self.misfit[..]], &|start, [misfit]| {
            let known = held[start..].iter().zip(&values[start..]);
            for ((misfit, u), (held, value)) in misfit.iter_mut().zip(&displacement[start..]).zip(known) {
                *misfit = if *held { value - u } else { 0.0 };
            }
        });
    }

    /// Returns the [`MixedSolution::residual`] at the last certify.
    pub(crate) fn residual(&self) -> f64 {
        self.relative(largest(&self.misfit))
    }

    /// Returns `misfit` divided by the scale. If the scale is zero, all misfits are zero.
    pub(crate) fn relative(&self, misfit: f64) -> f64 {
        if misfit == 0.0 { 0.0 } else { misfit / self.scale }
    }
}

/// Returns the largest magnitude; NaN if any value is NaN.
pub(crate) fn largest(field: &[f64]) -> f64 {
    // The bit patterns of positive numbers have the order of the numbers, with NaN last.
    let leaf = |range: Range<usize>| field[range].iter().fold(0, |most, value| u64::max(most, value.abs().to_bits()));
    f64::from_bits(reduce(field.len(), &leaf, &u64::max))
}
