//! Options of one contact, and the contact that they pose.

use std::borrow::Cow;

use clap::Args;
use gfmd_contact::{Boundary, Drive, Dynamics, Equilibrium as _, Factors, Press, Solver, Watch};
use gfmd_problem::options::{
    BodyArgs, ComplianceArgs, DampedBy, DynamicsArgs, LawArgs, SolverArgs, named, parse_choice,
};
use gfmd_problem::{Accuracy, AnyState, Facts, GridError, Posed, Unknown, key, setting, words};
use serde::{Deserialize, Serialize};

use super::head::is_normal;
use super::prepared::{Asked, Prepared};
use super::stiffness::StiffnessArgs;
use gfmd_input::base::BaseArgs;
use gfmd_input::failure::{Failure, reached};
use gfmd_input::hardness::HardnessArgs;
use gfmd_input::lower::LowerArgs;
use gfmd_input::session::Session;
use gfmd_input::source::SourceArgs;
use gfmd_problem::options::Options;

/// The options of a contact, whatever its loads: what is pressed on what, and how it is solved. The program and Python
/// pose by them.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub struct ContactArgs {
    /// Surface.
    #[command(flatten)]
    #[serde(flatten)]
    pub source: SourceArgs,
    /// Elastic body.
    #[command(flatten)]
    #[serde(flatten)]
    pub body: BodyArgs,
    /// Table of its compliance.
    #[command(flatten)]
    #[serde(flatten)]
    pub compliance: ComplianceArgs,
    /// Displacement or traction of its base.
    #[command(flatten)]
    #[serde(flatten)]
    pub base: BaseArgs,
    /// Surface below it.
    #[command(flatten)]
    #[serde(flatten)]
    pub lower: LowerArgs,
    /// Boundary condition at the edges of the surface
    #[arg(
        long,
        value_parser = parse_choice::<Boundary>(),
        default_value_t = Boundary::Periodic,
        help_heading = "Contact"
    )]
    #[serde(with = "named")]
    pub boundary: Boundary,
    /// Displacement components to solve for
    #[arg(long, value_parser = parse_choice::<Unknown>(), default_value_t = Unknown::Normal, help_heading = "Contact")]
    #[serde(skip_serializing_if = "is_normal", with = "named")]
    pub components: Unknown,
    /// Largest pressure.
    #[command(flatten)]
    #[serde(flatten)]
    pub hardness: HardnessArgs,
    /// Allow finite slopes: points of the body touch the rigid surface at their laterally displaced position, and
    /// pressures act along its normal
    #[arg(long, help_heading = "Contact")]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub finite_slope: bool,
    /// Method.
    #[command(flatten)]
    #[serde(flatten)]
    pub solver: SolverArgs,
    /// Accuracy of the stiffness.
    #[command(flatten)]
    #[serde(flatten)]
    pub stiffness: StiffnessArgs,
    /// Time step and damping.
    #[command(flatten)]
    #[serde(flatten)]
    pub dynamics: DynamicsArgs,
    /// Interaction.
    #[command(flatten)]
    #[serde(flatten)]
    pub law: LawArgs,
    /// How to estimate the discretisation error
    #[arg(
        long,
        value_parser = parse_choice::<GridError>(),
        default_value_t = GridError::Estimate,
        help_heading = "Accuracy"
    )]
    #[serde(skip_serializing_if = "GridError::is_default", with = "named")]
    pub grid_error: GridError,
    /// Target relative discretisation error (95 %), such as 0.01 or 1%: the grid is refined until every number meets it
    #[arg(long, value_name = "E", conflicts_with = "grid_error", help_heading = "Accuracy")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// Solve the first load with 8, 4 and 2 times the range of the law and the same work, in turn, before the law
    /// itself
    #[arg(long, help_heading = "Solver")]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub range_continuation: bool,
}

/// Ranges of `--range-continuation`, divided by the requested one.
const RANGES: [f64; 3] = [8.0, 4.0, 2.0];

impl ContactArgs {
    /// Returns the facts of a series of contacts, without their [parts](Asked::facts).
    pub fn series(&self) -> Facts {
        Facts {
            unknown: self.components,
            finite_slope: self.finite_slope,
            grid_error: self.grid_error,
            ..Facts::default()
        }
    }

    /// Returns the parts that the options request, for one state at a time.
    ///
    /// # Errors
    /// Returns an error for two damping numbers.
    pub fn asked(&self) -> Result<Asked<'_>, Failure> {
        Ok(Asked {
            compliance: Cow::Borrowed(&self.compliance),
            base: Cow::Borrowed(&self.base),
            lower: Cow::Borrowed(&self.lower),
            law: Cow::Borrowed(&self.law),
            hardness: self.hardness.hardness.as_ref(),
            boundary: self.boundary,
            dynamics: Dynamics { time_step: self.dynamics.time_step(), damping: self.dynamics.factors()? },
            solver: self.solver.solver,
            once: true,
            ..Asked::new(&self.source, Cow::Borrowed(&self.body), self.solver.search.budget())
        })
    }

    /// Checks options that need neither files nor arrays: range of the law, time step and damping of the dynamics.
    ///
    /// # Errors
    /// Returns an error if an option does not fit the law, the method or the components.
    pub fn check(&self) -> Result<(), Failure> {
        if self.range_continuation && self.law.with_range(1.0)?.is_none() {
            let with_range = gfmd_law::LawKind::names(|kind| kind.has("range") || kind == gfmd_law::LawKind::Table);
            let why = format!("the law {} has no range; it must be one of {with_range}", self.law.law.name());
            return Err(Failure::input(key("range_continuation"), why));
        }
        self.stiffness.check()?;
        self.dynamics.check(match self.solver.solver {
            Solver::VerletCritical => DampedBy::Numbers,
            Solver::VerletModes => DampedBy::Modes,
            _ => DampedBy::Other,
        })?;
        let moves_all = self.asked()?.facts(self.series(), false).moves_all_by(self.solver.solver);
        if let (Factors::Components(factors), false) = (self.dynamics.factors()?, moves_all) {
            let allowed =
                words!["one number unless a hard wall moves all components (", setting("components", "all"), ")"];
            return Err(Failure::value(key("damping"), format!("{factors:?}"), allowed));
        }
        Ok(())
    }

    /// Returns the options with every default of the generator filled in, for the record of a run.
    ///
    /// # Errors
    /// Returns an error if the numbers do not make a grid.
    pub fn resolved(&self) -> Result<Self, Failure> {
        Ok(Self { source: self.source.resolved()?, ..self.clone() })
    }

    /// Reads and poses the contact, and warns about doubtful input.
    ///
    /// # Errors
    /// Returns an error if options cannot be used or combined, or if surface and body cannot be in contact.
    pub fn pose(&self, session: &Session) -> Result<(Prepared, Posed), Failure> {
        self.check()?;
        let asked = self.asked()?;
        let prepared = Prepared::new(&asked, self.series(), session)?;
        let posed = prepared.pose_with_warnings(&asked, session)?;
        Ok((prepared, posed))
    }

    /// Solves for the state under the first drive with longer ranges of the law, one after the other, as a start;
    /// `None` if that is not requested.
    ///
    /// # Errors
    /// Returns an error that names the range if a search was interrupted, or did not converge.
    pub fn after_longer_ranges(
        &self,
        prepared: &Prepared,
        drive: Drive,
        watch: &mut dyn Watch,
    ) -> Result<Option<AnyState>, Failure> {
        let (units, mut last) = (prepared.surface.units(), None::<AnyState>);
        for factor in RANGES.into_iter().filter(|_| self.range_continuation) {
            let Some(law) = self.law.with_range(factor)? else { break };
            let longer = prepared.pose(&self.source, &law.into())?;
            let (state, failure) =
                reached(self.press(&longer, drive).starting_from(last.as_ref()).watch(watch).solve(), &units)?;
            if let Some(failure) = failure {
                return Err(failure.at(format!("range times {factor}")));
            }
            last = Some(state);
        }
        Ok(last)
    }

    /// Returns a solve of the contact under a drive, by the requested method.
    pub fn press<'a>(&self, contact: &'a Posed, drive: Drive) -> Press<'a, Posed> {
        contact.press(drive).solver(self.solver.solver).budget(self.solver.search.budget())
    }
}
