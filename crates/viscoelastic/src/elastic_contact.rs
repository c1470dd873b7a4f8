//! Elastic contacts solved in each viscoelastic time step.

use gfmd_contact::{
    Boundary, Contact, Effort, Load, Refusal, Resumable, RigidSurface, Solution, Variables as _, Visit,
};
use gfmd_interface::{Interface, State};
use gfmd_vector::{for_each, with_contiguous};
use ndarray::{Array2, Axis};

/// An elastic contact with a hard wall or a law across the gap. A viscoelastic step is solved as an elastic contact
/// with larger moduli and another clearance.
pub trait ElasticContact: Resumable + Clone {
    /// True if the undeformed surfaces are in equilibrium at first touch without load.
    const RESTS_AT_FIRST_TOUCH: bool;

    /// Returns the rigid surface.
    fn surface(&self) -> &RigidSurface;

    /// Returns the boundary of the surface.
    fn boundary(&self) -> Boundary;

    /// Checks that the body of this contact may relax.
    ///
    /// # Errors
    /// Returns an error for a hardness or for all displacement components.
    fn check_relaxing(&self) -> Result<(), Refusal>;

    /// Returns the elastic contact of a step, with `depth` added to the clearance.
    ///
    /// # Errors
    /// Returns an error if the depth is not finite or its shape differs from the heights.
    fn of_step(&self, stiffening: &Stiffening, depth: &Array2<f64>) -> Result<Self, Refusal>;

    /// Converts an equilibrium state to the step contact, to start its search; `None` if it does not help.
    fn to_step_frame(state: &Self::State, frame: &StepFrame) -> Option<Self::State>;

    /// Converts a state of the step contact back from the step frame. The elastic energy is not set.
    fn from_step_frame(state: Self::State, frame: &StepFrame) -> Self::State;

    /// Returns the state at `approach` if the surfaces are so far apart that no solve is needed. `approach` exceeds
    /// first touch by no more than rounding.
    fn separated_state(&self, approach: f64) -> Option<Result<Self::State, Refusal>>;

    /// Returns a state without forces, to be filled in.
    ///
    /// # Errors
    /// Returns no error for a valid contact.
    fn empty_state(&self) -> Result<Self::State, Refusal>;

    /// Visits all variables of a state.
    fn visit(state: &mut Self::State, visitor: &mut dyn Visit);

    /// Returns mutable references to the approach and the effort of a state.
    fn approach_and_effort(state: &mut Self::State) -> (&mut f64, &mut Effort);

    /// Returns the energy of the law per area, stress × length.
    fn interface_energy(state: &Self::State) -> f64;

    /// Returns true if a jump may have occurred between the start and the state.
    fn may_have_jumped(state: &Self::State) -> bool;
}

/// Moduli of a step divided by the long-term moduli.
#[derive(Clone, Debug)]
pub enum Stiffening {
    /// Common factor of all waves.
    All(f64),
    /// One factor per wave, laid out as the [modes](gfmd_field::Grid::modes) of the grid.
    Waves(Vec<f64>),
}

/// Conversion between a state and the elastic contact of a step.
#[derive(Clone, Debug)]
pub struct StepFrame {
    /// Residual indentation H at zero pressure, `[x, y]`, length.
    pub residual_indentation: Array2<f64>,
    /// First touch of the surface indented by H: the origin of the approach in the step contact.
    pub touch: f64,
    /// Pressure divided by the pressure in the step contact.
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

    /// Ignores a common factor: a wall has no scale, so that the factor scales only the pressures.
    fn of_step(&self, stiffening: &Stiffening, depth: &Array2<f64>) -> Result<Self, Refusal> {
        match stiffening {
            Stiffening::All(_) => self.with_indentation(depth),
            Stiffening::Waves(factors) => self.stiffened(factors).with_indentation(depth),
        }
    }

    fn to_step_frame(state: &Solution, frame: &StepFrame) -> Option<Solution> {
        (state.mean_pressure > 0.0).then(|| {
            let mut state = state.clone();
            state.pressure.mapv_inplace(|p| p / frame.factor);
            state
        })
    }

    fn from_step_frame(mut state: Solution, StepFrame { residual_indentation, touch, factor }: &StepFrame) -> Solution {
        state.displacement -= residual_indentation;
        if *factor != 1.0 {
            with_contiguous(&mut state.pressure, |pressure| {
                for_each([pressure], &|_, [pressure]| pressure.iter_mut().for_each(|p| *p *= factor));
            });
            state.mean_pressure *= factor;
        }
        state.approach += touch;
        state
    }

    fn separated_state(&self, approach: f64) -> Option<Result<Solution, Refusal>> {
        let none = Array2::zeros(self.surface().grid().points());
        Some(self.certify(&none, Load::Approach(approach.min(0.0))))
    }

    fn empty_state(&self) -> Result<Solution, Refusal> {
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
    /// False: the law attracts surfaces that touch.
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
        .with_indentation(depth)
    }

    fn to_step_frame(state: &State, StepFrame { residual_indentation, touch, factor }: &StepFrame) -> Option<State> {
        let mut state = state.clone().times(1.0, 1.0 / factor);
        let mut displacement = state.displacement.index_axis_mut(Axis(0), 0);
        displacement += residual_indentation;
        state.approach -= touch;
        Some(state)
    }

    fn from_step_frame(state: State, StepFrame { residual_indentation, touch, factor }: &StepFrame) -> State {
        let mut state = state.times(1.0, *factor);
        let mut displacement = state.displacement.index_axis_mut(Axis(0), 0);
        displacement -= residual_indentation;
        state.approach += touch;
        state
    }

    /// Returns `None`: the law acts at all distances.
    fn separated_state(&self, _: f64) -> Option<Result<State, Refusal>> {
        None
    }

    fn empty_state(&self) -> Result<State, Refusal> {
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
