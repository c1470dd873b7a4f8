//! The contacts on an elastic body of which the steps of a viscoelastic one are made.

use gfmd_contact::{
    Boundary, Contact, Effort, Load, Refusal, Resumable, RigidSurface, Solution, Variables as _, Visit,
};
use gfmd_interface::{Interface, State};
use gfmd_vector::{for_each, with_contiguous};
use ndarray::{Array2, Axis};

/// A contact on an elastic body: a hard wall, or a law across the gap. A step of a viscoelastic body is such a contact
/// with larger moduli and another clearance.
pub trait ElasticContact: Resumable + Clone {
    /// True if the undeformed surfaces are at rest at first touch, without a load.
    const RESTS_AT_FIRST_TOUCH: bool;

    /// The rigid surface.
    fn surface(&self) -> &RigidSurface;

    /// The boundary of the surface.
    fn boundary(&self) -> Boundary;

    /// Checks that the body of this contact may relax.
    ///
    /// # Errors
    /// A hardness; all components of the displacement.
    fn check_relaxing(&self) -> Result<(), Refusal>;

    /// The contact of a step, with a `depth` added to the clearance.
    ///
    /// # Errors
    /// A depth of another shape than the heights, or not finite.
    fn of_step(&self, stiffening: &Stiffening, depth: &Array2<f64>) -> Result<Self, Refusal>;

    /// A state at rest of the contact of a step, as the start of its search; `None` if it is of no use.
    fn entered(state: &Self::State, frame: &StepFrame) -> Option<Self::State>;

    /// The state with the fields of the contact of a step at its end, from those in the frame of the step. The elastic
    /// energy is not set.
    fn left(state: Self::State, frame: &StepFrame) -> Self::State;

    /// The state of this approach, if the surfaces are so far apart that it is known without a solve: `approach` is at
    /// most rounding beyond the first touch.
    fn apart(&self, approach: f64) -> Option<Result<Self::State, Refusal>>;

    /// The state of surfaces without forces, to be filled.
    ///
    /// # Errors
    /// None, for a valid contact.
    fn unfilled(&self) -> Result<Self::State, Refusal>;

    /// Visits all numbers of a state.
    fn visit(state: &mut Self::State, visitor: &mut dyn Visit);

    /// The approach and the effort of a state, to be changed.
    fn approach_and_effort(state: &mut Self::State) -> (&mut f64, &mut Effort);

    /// The energy of the law per area, stress × length.
    fn interface_energy(state: &Self::State) -> f64;

    /// True if a jump may lie on the way from the start to the state.
    fn may_have_jumped(state: &Self::State) -> bool;
}

/// The moduli of a step over the long-term ones.
#[derive(Clone, Debug)]
pub enum Stiffening {
    /// One factor of all waves.
    All(f64),
    /// One factor of each wave, laid out as the [modes](gfmd_field::Grid::modes) of the grid.
    Waves(Vec<f64>),
}

/// The difference between a state and that of the contact of a step.
#[derive(Clone, Debug)]
pub struct StepFrame {
    /// H, by which the surface would stay indented without a pressure, `[x, y]`, length.
    pub hollow: Array2<f64>,
    /// The first touch of the surface that stays indented, from which the approach of the contact of the step counts.
    pub touch: f64,
    /// The pressure over that of the contact of the step.
    pub factor: f64,
}

impl ElasticContact for Contact {
    const RESTS_AT_FIRST_TOUCH: bool = true;

    fn surface(&self) -> &RigidSurface {
        self.surface()
    }

    fn boundary(&self) -> Boundary {
        self.boundary()
    }

    fn check_relaxing(&self) -> Result<(), Refusal> {
        if self.hardness().is_some() { Err(Refusal::ViscoelasticHardness) } else { Ok(()) }
    }

    /// A wall has no scale: on a body that is stiffer throughout, all pressures are larger by the same factor.
    fn of_step(&self, stiffening: &Stiffening, depth: &Array2<f64>) -> Result<Self, Refusal> {
        match stiffening {
            Stiffening::All(_) => self.indented(depth),
            Stiffening::Waves(factors) => self.stiffened(factors).indented(depth),
        }
    }

    fn entered(state: &Solution, frame: &StepFrame) -> Option<Solution> {
        (state.mean_pressure > 0.0).then(|| {
            let mut state = state.clone();
            state.pressure.mapv_inplace(|p| p / frame.factor);
            state
        })
    }

    fn left(mut state: Solution, StepFrame { hollow, touch, factor }: &StepFrame) -> Solution {
        state.displacement -= hollow;
        if *factor != 1.0 {
            with_contiguous(&mut state.pressure, |pressure| {
                for_each([pressure], &|_, [pressure]| pressure.iter_mut().for_each(|p| *p *= factor));
            });
            state.mean_pressure *= factor;
        }
        state.approach += touch;
        state
    }

    fn apart(&self, approach: f64) -> Option<Result<Solution, Refusal>> {
        let none = Array2::zeros(self.surface().grid().points());
        Some(self.certify(&none, Load::Approach(approach.min(0.0))))
    }

    fn unfilled(&self) -> Result<Solution, Refusal> {
        self.certify(&Array2::zeros(self.surface().grid().points()), Load::Approach(0.0))
    }

    fn visit(state: &mut Solution, visitor: &mut dyn Visit) {
        let Solution { pressure, displacement, gap, mean_pressure, approach, residual, effort, .. } = state;
        for field in [pressure, displacement, gap] {
            with_contiguous(field, |field| visitor.field(field));
        }
        let gfmd_contact::Residual { complementarity, penetration, negative_pressure, load } = residual;
        visitor.numbers(&mut [mean_pressure, approach, complementarity, penetration, negative_pressure, load]);
        effort.visit(visitor);
    }

    fn approach_and_effort(state: &mut Solution) -> (&mut f64, &mut Effort) {
        (&mut state.approach, &mut state.effort)
    }

    fn interface_energy(_: &Solution) -> f64 {
        0.0
    }

    fn may_have_jumped(_: &Solution) -> bool {
        false
    }
}

impl ElasticContact for Interface {
    /// The law attracts surfaces that touch.
    const RESTS_AT_FIRST_TOUCH: bool = false;

    fn surface(&self) -> &RigidSurface {
        self.surface()
    }

    fn boundary(&self) -> Boundary {
        self.boundary()
    }

    fn check_relaxing(&self) -> Result<(), Refusal> {
        if self.elastic().components() == 1 { Ok(()) } else { Err(Refusal::ViscoelasticComponents) }
    }

    fn of_step(&self, stiffening: &Stiffening, depth: &Array2<f64>) -> Result<Self, Refusal> {
        match stiffening {
            Stiffening::All(factor) => self.weakened(*factor),
            Stiffening::Waves(factors) => self.stiffened(factors)?,
        }
        .indented(depth)
    }

    fn entered(state: &State, StepFrame { hollow, touch, factor }: &StepFrame) -> Option<State> {
        let mut state = state.clone().times(1.0, 1.0 / factor);
        let mut displacement = state.displacement.index_axis_mut(Axis(0), 0);
        displacement += hollow;
        state.approach -= touch;
        Some(state)
    }

    fn left(state: State, StepFrame { hollow, touch, factor }: &StepFrame) -> State {
        let mut state = state.times(1.0, *factor);
        let mut displacement = state.displacement.index_axis_mut(Axis(0), 0);
        displacement -= hollow;
        state.approach += touch;
        state
    }

    /// The law acts at all distances.
    fn apart(&self, _: f64) -> Option<Result<State, Refusal>> {
        None
    }

    fn unfilled(&self) -> Result<State, Refusal> {
        let none = Array2::zeros(self.surface().grid().points());
        self.certify(&none, &none, Load::Approach(0.0).into())
    }

    fn visit(state: &mut State, visitor: &mut dyn Visit) {
        state.visit(visitor);
    }

    fn approach_and_effort(state: &mut State) -> (&mut f64, &mut Effort) {
        (&mut state.approach, &mut state.effort)
    }

    fn interface_energy(state: &State) -> f64 {
        state.interface_energy
    }

    fn may_have_jumped(state: &State) -> bool {
        state.passed_instability
    }
}
