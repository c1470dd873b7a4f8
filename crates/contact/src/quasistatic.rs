//! Contacts that can be followed along a path of drives.

use gfmd_relax::{Budget, Watch};

use crate::{Drive, Equilibrium, Fields, Load, SolveError, Solver, SqueezedContact, SteepContact};

/// A contact that can be followed along a path of equilibrium states.
pub trait Quasistatic: Equilibrium {
    /// Returns the values of a state for the energy balance of a path. By default it has no shear and an unknown loss.
    fn reading(&self, state: &Self::State) -> Reading {
        Reading::of(state)
    }

    /// Returns true if the state `end` may depend, by a [`change`](Self::change) above `tolerance`, on the number of
    /// increments from `start`, or from the undeformed surface. No solve is made.
    fn depends_on_division(&self, _start: Option<&Self::State>, _end: &Self::State, _tolerance: f64) -> bool {
        false
    }

    /// Returns the change between two states under the same drive, both reached from `start`, or from the undeformed
    /// surface, in different numbers of increments: the energy of their difference divided by the energy of the forces
    /// that depend on the path from `start`.
    fn change(&self, _start: Option<&Self::State>, _from: &Self::State, _to: &Self::State) -> f64 {
        0.0
    }

    /// Returns true if surfaces slip, so that states depend on the division of steps.
    fn slips(&self) -> bool {
        false
    }

    /// Brings the contact to rest as [`equilibrate`](Equilibrium::equilibrate), from the state `near` under the same
    /// drive, found from the same `start` to a lower accuracy.
    ///
    /// # Errors
    /// Returns the errors of [`equilibrate`](Equilibrium::equilibrate).
    fn polish(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        (start, _near): (Option<&Self::State>, &Self::State),
        watch: &mut dyn Watch,
    ) -> Result<Self::State, SolveError<Self::State>> {
        self.equilibrate(drive, solver, budget, start, watch)
    }

    /// Returns the change of the sticking fraction between two states under the same drive. Points slip in the last
    /// increment at the end, so that this fraction depends on its length even where the tractions hardly do.
    fn change_of_stick(&self, _from: &Self::State, _to: &Self::State) -> f64 {
        0.0
    }
}

/// Values of an equilibrium state for the energy balance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Mean pressure, stress.
    pub mean_pressure: f64,
    /// Rigid approach, length.
    pub approach: f64,
    /// Mean lateral traction along x and y, stress.
    pub mean_shear: [f64; 2],
    /// Lateral displacement of the rigid surface, length.
    pub lateral: [f64; 2],
    /// Time, if the state has one.
    pub time: f64,
    /// Sliding distance, if the state has one, length.
    pub distance: f64,
    /// Energies lost in the increment to this state by cause, as far as the solver knows them.
    pub losses: Losses,
    /// Source of the energy lost in the step to this state.
    pub loss: Loss,
    /// Mean depth worn off so far at the upper and the lower face of a slab, length. The second is 0 for one surface.
    pub worn: [f64; 2],
}

/// Source of the energy lost in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loss {
    /// No loss: the energy of an elastic contact with a hard wall is conserved.
    Conserved,
    /// Balance of work and energy, from this stored energy per area. Energy is lost only in jumps.
    Balance(f64),
    /// Loss of an increment per area, from the solver. Its error is the error of the increment.
    Known(f64),
    /// Loss of an increment per area and imbalance of its work and energy, from the solver.
    Certified {
        /// Energy lost.
        lost: f64,
        /// Magnitude of the trapezoidal work of the rigid surface minus the energies gained and lost.
        imbalance: f64,
        /// Stored energy per area, if energy may also be lost in jumps. In an instantaneous step only jumps lose
        /// energy, and the balance of work and energy gives the loss.
        stored: Option<f64>,
        /// True if energy may also be lost in no time and no distance, by slip or yield.
        flows: bool,
    },
    /// Unknown loss, because the tractions have no energy.
    Unknown,
}

/// Energies lost in an increment by cause, per area, stress × length.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// In the dashpots of a body that relaxes.
    pub relaxation: f64,
    /// By slip: the slip of each point times the mean of its limits at the start and the end.
    pub friction: f64,
    /// Work of the pressure on the depth worn off.
    pub wear: f64,
    /// Work of the pressure on the depth pressed in.
    pub plastic: f64,
    /// In jumps of surfaces that attract each other, where other losses leave the balance of energy to tell them.
    pub jumps: f64,
}

impl Losses {
    /// Returns the sum of all losses.
    pub fn total(&self) -> f64 {
        self.relaxation + self.friction + self.wear + self.plastic + self.jumps
    }

    /// Returns the sums of both, cause by cause.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            relaxation: self.relaxation + other.relaxation,
            friction: self.friction + other.friction,
            wear: self.wear + other.wear,
            plastic: self.plastic + other.plastic,
            jumps: self.jumps + other.jumps,
        }
    }

    /// Returns the differences of both, cause by cause.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        self.and(other.times(-1.0))
    }

    /// Returns the losses in another unit.
    #[must_use]
    pub fn times(self, unit: f64) -> Self {
        Self {
            relaxation: self.relaxation * unit,
            friction: self.friction * unit,
            wear: self.wear * unit,
            plastic: self.plastic * unit,
            jumps: self.jumps * unit,
        }
    }
}

impl Reading {
    /// Surfaces before the first step.
    pub const UNLOADED: Self = Self {
        mean_pressure: 0.0,
        approach: 0.0,
        mean_shear: [0.0; 2],
        lateral: [0.0; 2],
        time: 0.0,
        distance: 0.0,
        losses: Losses { relaxation: 0.0, friction: 0.0, wear: 0.0, plastic: 0.0, jumps: 0.0 },
        loss: Loss::Known(0.0),
        worn: [0.0; 2],
    };

    /// Returns the values of a state that is pressed without shear and has an unknown loss.
    pub fn of(state: &impl Fields) -> Self {
        let (mean_pressure, approach) = (state.mean_pressure(), state.approach());
        Self { mean_pressure, approach, loss: Loss::Unknown, ..Self::UNLOADED }
    }

    /// Returns the imbalance of the increment, 0 if its loss is not certified.
    pub fn imbalance(&self) -> f64 {
        if let Loss::Certified { imbalance, .. } = self.loss { imbalance } else { 0.0 }
    }

    /// Returns true if the step from `begin` takes no time and no distance.
    pub fn is_at_once(&self, begin: &Self) -> bool {
        self.time == begin.time && self.distance == begin.distance
    }

    /// Returns the drive at the fraction `share` of the path from this state to `drive`.
    pub fn towards(&self, drive: Drive, share: f64) -> Drive {
        if share == 1.0 {
            return drive;
        }
        let at = |from: f64, to: f64| from + share * (to - from);
        Drive {
            load: match drive.load {
                Load::MeanPressure(to) => Load::MeanPressure(at(self.mean_pressure, to)),
                Load::Approach(to) => Load::Approach(at(self.approach, to)),
            },
            lateral: std::array::from_fn(|c| at(self.lateral[c], drive.lateral[c])),
            time: at(self.time, drive.time),
            distance: at(self.distance, drive.distance),
        }
    }
}

impl Quasistatic for SteepContact {}

impl Quasistatic for SqueezedContact {}

impl<Q: Quasistatic + ?Sized> Quasistatic for Box<Q> {
    fn reading(&self, state: &Self::State) -> Reading {
        (**self).reading(state)
    }

    fn depends_on_division(&self, start: Option<&Self::State>, end: &Self::State, tolerance: f64) -> bool {
        (**self).depends_on_division(start, end, tolerance)
    }

    fn change(&self, start: Option<&Self::State>, from: &Self::State, to: &Self::State) -> f64 {
        (**self).change(start, from, to)
    }

    fn slips(&self) -> bool {
        (**self).slips()
    }

    fn polish(
        &self,
        drive: Drive,
        solver: Solver,
        budget: &Budget,
        from: (Option<&Self::State>, &Self::State),
        watch: &mut dyn Watch,
    ) -> Result<Self::State, SolveError<Self::State>> {
        (**self).polish(drive, solver, budget, from, watch)
    }

    fn change_of_stick(&self, from: &Self::State, to: &Self::State) -> f64 {
        (**self).change_of_stick(from, to)
    }
}
