//! Newton's method within a trust region, on the points not held by the wall.
//!
//! The energy ½⟨w, K w⟩ + Σ Φ(Δ(w)) − push Σ w_z is minimised over w_z ≤ bound. A step solves (K + J) d = f on the free
//! points by conjugate gradients that stop at the edge of the region or at a negative curvature (Steihaug 1983). The
//! preconditioner is the compliance, with a smaller weight at points where the law is stiff. The step is then projected
//! on the wall and shortened until the energy falls. No step raises the energy, so that a jump ends in a stable state
//! of lower energy. The search for a step in u_z alone uses single precision ([`one_component`]); positions, forces and
//! energies use double precision.
//!
//! At a wall that gives way ([`pieces`]) each point stays on one smooth piece of its potential during a step, and stops
//! where the piece ends. At the ends the force decides on which piece the next step begins.

mod adjoint;
mod all_components;
mod descent;
mod one_component;
mod pieces;
mod reaction;
mod release;
mod stability;
mod trust_region;
mod wall;

use gfmd_relax::{Budget, Ending, Progress, Variables as _, Visit, Watch, Why};
use gfmd_response::Elastic;

use crate::frame::Frame;
use crate::search_result::{End, SearchResult};
use crate::{Interface, State};
pub(crate) use adjoint::{Adjoint, Bond, Energy, Linear, Sides};
use all_components::AllComponents;
use descent::Descent;
use one_component::OneComponent;
use trust_region::Model;

/// Fraction of the tolerance at which the solver stops.
const SHARE_OF_TOLERANCE: f64 = 0.1;

/// Descends from `start`, or from the undeformed surface. `before` has the number of transform pairs spent on `start`,
/// and whether the way to it passed an instability.
pub(crate) fn descend(
    interface: &Interface,
    frame: &Frame,
    budget: &Budget,
    start: Option<&State>,
    (before, crossed): (f64, bool),
    watch: &mut dyn Watch,
) -> SearchResult {
    let elastic = &interface.elastic;
    let uniform = uniform_compliance(interface, frame);
    let mut transforms = elastic.transforms();
    *transforms.counter() += match elastic {
        // The counter counts single transforms.
        Elastic::Normal(_) | Elastic::Plate(_) => (2.0 * before) as u64,
        Elastic::Full(_) => before as u64,
    };
    match elastic {
        Elastic::Normal(response) => {
            let model = OneComponent::new(response, transforms, frame, uniform[0]);
            descend_with(Descent::new(interface, frame, model, (start, crossed)), budget, start.is_some(), watch)
        }
        Elastic::Full(_) | Elastic::Plate(_) => {
            let model = AllComponents::new(transforms, frame, uniform);
            descend_with(Descent::new(interface, frame, model, (start, crossed)), budget, start.is_some(), watch)
        }
    }
}

/// Returns the compliance of the uniform mode in a preconditioner; it resists uniform motion if nothing else does.
fn uniform_compliance(interface: &Interface, frame: &Frame) -> Vec<f64> {
    let [softest, _] = interface.elastic.stiffness_range();
    let mut least = vec![softest; frame.uniform_stiffness.len()];
    if let Elastic::Plate(response) = &interface.elastic {
        // A plate bends far more easily than it is squeezed.
        least[0] = response.softest_squeezing();
    }
    let resists = |(stiffness, least): (&f64, f64)| 1.0 / if *stiffness > 0.0 { *stiffness } else { least };
    frame.uniform_stiffness.iter().zip(least).map(resists).collect()
}

/// Least stiffness of a point in a preconditioner, divided by the stiffness without a law: one about to jump has none.
const SOFTEST: f64 = 0.2;

/// Returns the weight of a free point in a preconditioner for the `slope` of the law. `stiffness` are the least and the
/// largest stiffness of a wave; a single point has about half of the largest one.
fn weight_of(slope: f64, [softest, stiffest]: [f64; 2]) -> f64 {
    let relative = if slope > 0.0 {
        1.0 + slope / (softest * stiffest).sqrt()
    } else {
        (1.0 + 2.0 * slope / stiffest).max(SOFTEST)
    };
    relative.sqrt().recip()
}

fn descend_with<M: Model>(
    mut descent: Descent<M>,
    budget: &Budget,
    // True if a jump between the start and the state counts as an instability.
    mut has_start: bool,
    watch: &mut dyn Watch,
) -> SearchResult {
    let mut iterations = 0;
    macro_rules! visit_all {
        ($visitor:expr) => {{
            let visitor: &mut dyn Visit = $visitor;
            visitor.count(&mut iterations);
            visitor.flag(&mut has_start);
            descent.visit(visitor);
        }};
    }
    if let Some(kept) = watch.recall() {
        visit_all!(kept);
        descent.restored();
    }
    let end = loop {
        watch.checkpoint(&mut |visitor| visit_all!(visitor));
        let residual = if descent.pieces.is_some() { descent.release_pieces() } else { descent.release() };
        let stop = watch.see(&Progress { iteration: iterations, residual }).is_break();
        if descent.frame.share.any(stop) {
            break End::Finished(Ending::Interrupted);
        }
        if descent.is_apart() {
            break End::Detached;
        }
        let at_rest = residual <= SHARE_OF_TOLERANCE * budget.tolerance;
        if at_rest && !(descent.is_unstable() && descent.leave()) {
            break End::Finished(Ending::Converged);
        }
        if iterations == budget.max_iterations {
            break End::Finished(Ending::GaveUp(Why::Iterations));
        }
        iterations += 1;
        if at_rest {
            continue;
        }
        descent.seek((SHARE_OF_TOLERANCE * budget.tolerance / residual).max(residual.sqrt().min(0.1)));
        if !descent.advance() && !descent.slide_downhill() {
            break if residual <= budget.tolerance {
                End::Finished(Ending::Converged)
            } else {
                End::Finished(Ending::GaveUp(Why::NoDescent))
            };
        }
    };
    let (passed_instability, lowest_curvature) = (descent.met_negative && has_start, descent.lowest);
    let (position, inset, transform_pairs) = descent.into_position_and_pairs();
    SearchResult { position, inset, iterations, transform_pairs, passed_instability, lowest_curvature, end }
}
