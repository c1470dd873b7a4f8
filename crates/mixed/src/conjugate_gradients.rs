//! Conjugate gradients for the traction on the held entries: R G Rᵀ t = u − R G t_given, with R the restriction to
//! these entries. R G Rᵀ is symmetric and positive definite. The preconditioner R K Rᵀ is close to its inverse, the
//! Schur complement R K Rᵀ − K_hf K_ff⁻¹ K_fh (docs/solvers.md).

use gfmd_relax::{Budget, Ending, Progress, Watch, Why};
use gfmd_vector::{dot, for_each};

use crate::surface::{Surface, largest};

/// Solves for the traction. Returns the number of iterations and the reason why they ended.
pub(crate) fn solve(surface: &mut Surface, budget: &Budget, watch: &mut dyn Watch) -> (u64, Ending) {
    let held = &surface.problem.prescribed.held;
    let mut residual = surface.misfit.clone();
    let mut direction = vec![0.0; residual.len()];
    // First the preconditioned residual, then the displacement of the direction.
    let mut image = vec![0.0; residual.len()];
    let mut slope = f64::INFINITY;
    let mut confirmed = f64::INFINITY;
    let mut iterations = 0;
    let ending = loop {
        let now = Progress { iteration: iterations, residual: surface.relative(largest(&residual)) };
        let stopped = watch.see(&now).is_break();
        // A residual of NaN also ends the iterations.
        let descending = now.residual > budget.tolerance;
        if !descending || stopped || iterations >= budget.max_iterations {
            surface.certify();
            let found = surface.residual();
            if found <= budget.tolerance {
                break Ending::Converged;
            } else if stopped {
                break Ending::Interrupted;
            } else if iterations >= budget.max_iterations {
                break Ending::GaveUp(Why::Iterations);
            } else if found.is_nan() || found > 0.5 * confirmed {
                break Ending::GaveUp(Why::Rounding);
            }
            // The recursive residual has drifted from the recomputed one, so the iterations are restarted.
            confirmed = found;
            residual.copy_from_slice(&surface.misfit);
            slope = f64::INFINITY;
        }
        surface.transforms.stiffness(&residual, &mut image);
        restrict(held, &mut image);
        let last = std::mem::replace(&mut slope, dot(&residual, &image));
        let beta = slope / last;
        for_each([&mut direction[..]], &|start, [direction]| {
            for (d, z) in direction.iter_mut().zip(&image[start..]) {
                *d = z + beta * *d;
            }
        });
        surface.transforms.compliance(&direction, &mut image);
        restrict(held, &mut image);
        let step = slope / dot(&direction, &image);
        for_each([&mut surface.traction[..], &mut residual[..]], &|start, [traction, residual]| {
            let along = direction[start..].iter().zip(&image[start..]);
            for ((t, r), (d, g)) in traction.iter_mut().zip(residual).zip(along) {
                *t += step * d;
                *r -= step * g;
            }
        });
        iterations += 1;
    };
    (iterations, ending)
}

/// Sets free entries to zero.
fn restrict(held: &[bool], field: &mut [f64]) {
    for_each([field], &|start, [field]| {
        for (value, held) in field.iter_mut().zip(&held[start..]) {
            if !held {
                *value = 0.0;
            }
        }
    });
}
