//! `bench-solve`: one solve by this program, measured as the solves of peers.

use std::fmt;
use std::path::PathBuf;
use std::time::Instant;

use clap::Args as ClapArgs;
use gfmd_contact::{Boundary, Budget, Contact, Equilibrium, Load, Solver};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_input::failure::{Failure, reached};
use gfmd_input::memory::peak_bytes;
use gfmd_problem::options::parse_choice;
use ndarray::Array2;
use ndarray_npy::{read_npy, write_npy};
use serde::{Deserialize, Serialize};

use super::process::ProgramFailure;

/// Flags of `bench-solve`: a contact of a half-space, E* = 1, cell length 1.
#[derive(ClapArgs, Clone, Debug)]
pub struct Args {
    /// File with the heights, in .npy
    #[arg(long, value_name = "FILE.npy")]
    pub surface: PathBuf,
    /// Mean pressure
    #[arg(long)]
    pub pressure: f64,
    /// Tolerance of the residuals
    #[arg(long)]
    pub tolerance: f64,
    /// Solver
    #[arg(long, value_parser = parse_choice::<Solver>())]
    pub solver: Solver,
    /// The surroundings of the surface
    #[arg(long, value_parser = parse_choice::<Boundary>())]
    pub boundary: Boundary,
    /// Hardness
    #[arg(long)]
    pub hardness: Option<f64>,
    /// File for the pressure, in .npy
    #[arg(long, value_name = "FILE.npy")]
    pub out: Option<PathBuf>,
}

/// Measurements of one solve.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Solve {
    /// Wall time of the solve, without set-up and without later work such as the stiffness.
    pub seconds: f64,
    /// Iterations, if the program reports them.
    pub iterations: Option<u64>,
    /// Transform pairs, if the program reports them.
    pub transform_pairs: Option<f64>,
    /// Largest resident memory of the process.
    pub peak_bytes: u64,
    /// Resident memory before the surface was read.
    pub baseline_bytes: u64,
    /// Reason given by the program for not reaching its tolerance.
    #[serde(default)]
    pub failure: Option<String>,
}

impl Solve {
    /// Returns this solve, unless the program reports that it has not reached its tolerance.
    pub(super) fn converged(self) -> Result<Self, ProgramFailure> {
        match self.failure {
            Some(failure) => Err(ProgramFailure::Failed(failure)),
            None => Ok(self),
        }
    }
}

impl fmt::Display for Solve {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{:.4} s", self.seconds)
    }
}

/// Solves the contact and writes its pressure, even without convergence.
///
/// # Errors
/// Files that cannot be read or written; an invalid problem.
pub fn run(args: &Args) -> Result<Solve, Failure> {
    let baseline_bytes = peak_bytes();
    let heights: Array2<f64> =
        read_npy(&args.surface).map_err(|error| Failure::input(args.surface.display().to_string(), error))?;
    let (nx, ny) = heights.dim();
    let refused = |error: &dyn fmt::Display| Failure::input("--surface", error);
    let grid = Grid::new([nx, ny], [1.0, ny as f64 / nx as f64]).map_err(|error| refused(&error))?;
    let material = Material::from_contact_modulus(1.0, 0.0).map_err(|error| refused(&error))?;
    let mut contact =
        Contact::with_boundary(args.boundary, &Body::half_space(material), &grid, &heights.into_shared())?;
    if let Some(hardness) = args.hardness {
        contact = contact.with_hardness(hardness)?;
    }
    let budget = Budget { tolerance: args.tolerance, ..Budget::default() };
    let started = Instant::now();
    let solved = contact.press(Load::MeanPressure(args.pressure)).solver(args.solver).budget(budget).solve();
    let seconds = started.elapsed().as_secs_f64();
    let peak_bytes = peak_bytes();
    let (solution, failure) = reached(solved, &Default::default())?;
    if let Some(out) = &args.out {
        write_npy(out, &solution.pressure).map_err(|error| Failure::input("--out", error))?;
    }
    Ok(Solve {
        seconds,
        iterations: Some(solution.effort.iterations),
        transform_pairs: Some(solution.effort.transform_pairs),
        peak_bytes,
        baseline_bytes,
        failure: failure.map(|failure| failure.to_string()),
    })
}
