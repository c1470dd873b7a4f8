//! Flags of the surroundings and the steps of a path.

use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_contact::Boundary;
use gfmd_input::base::BaseArgs;
use gfmd_problem::options::values::{one_or_all_within, one_or_list};
use gfmd_problem::options::{named, parse_choice};
use gfmd_problem::{Facts, GridError, Sequence, Unknown};
use gfmd_run::resume::{CheckpointArgs, ResumeArgs};
use gfmd_run::series::is_normal;
use serde::{Deserialize, Serialize};

use gfmd_problem::options::Options;
use gfmd_problem::options::SearchArgs;

/// Flags of the surroundings of a path.
#[derive(ClapArgs, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct PathOptions {
    /// Boundary condition at the edges of the surface
    #[arg(
        long,
        value_parser = parse_choice::<Boundary>(),
        default_value_t = Boundary::Periodic,
        help_heading = "Contact"
    )]
    #[serde(with = "named", skip_serializing_if = "is_periodic")]
    pub(super) boundary: Boundary,
    /// Displacement components to solve for
    #[arg(long, value_parser = parse_choice::<Unknown>(), default_value_t = Unknown::Normal, help_heading = "Contact")]
    #[serde(skip_serializing_if = "is_normal", with = "named")]
    components: Unknown,
    #[command(flatten)]
    #[serde(flatten)]
    pub(super) base: BaseArgs,
    /// How to estimate the discretisation error; refine also follows the path on the finer grid
    #[arg(
        long,
        value_parser = parse_choice::<GridError>(),
        default_value_t = GridError::Estimate,
        help_heading = "Accuracy"
    )]
    #[serde(skip_serializing_if = "GridError::is_default", with = "named")]
    grid_error: GridError,
}

fn is_periodic(boundary: &Boundary) -> bool {
    *boundary == Boundary::Periodic
}

impl PathOptions {
    /// Returns the facts of a path; `resume` continues an earlier path.
    pub(super) fn series(&self, ResumeArgs { resume }: ResumeArgs) -> Facts {
        let Self { components: unknown, grid_error, .. } = *self;
        Facts { sequence: Sequence::Path, unknown, resume, grid_error, ..Facts::default() }
    }
}

/// Flags of the steps of a path, of the search for each, and of the file.
#[derive(ClapArgs, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub(super) struct StepArgs {
    /// Steps between waypoints; or several numbers, one for each leg
    #[arg(
        long,
        default_values_t = [20_u32],
        value_parser = clap::value_parser!(u32).range(1..),
        value_delimiter = ',',
        value_name = "N,..",
        help_heading = "Waypoints"
    )]
    #[serde(serialize_with = "one_or_list", deserialize_with = "one_or_all_within::<1, { u32::MAX as u64 }, _, _>")]
    pub(super) steps: Vec<u32>,
    #[command(flatten)]
    #[serde(flatten)]
    pub(super) search: SearchArgs,
    #[command(flatten)]
    #[serde(skip)]
    pub(super) resume: ResumeArgs,
    #[command(flatten)]
    #[serde(skip)]
    pub(super) checkpoint: CheckpointArgs,
    /// Write the path and the fields at its waypoints to this HDF5 file
    #[arg(long, value_name = "FILE.h5", help_heading = "Output")]
    #[serde(skip)]
    pub(super) out: Option<PathBuf>,
}
