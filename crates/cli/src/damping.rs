//! `damping`: the effect of damping on the relaxation of a free surface, predicted and measured.

mod experiment;
mod figures;

use std::fmt;
use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_field::Grid;
use gfmd_files::{Archive, Dimension, Output, Variable};
use gfmd_green::Height;
use serde::Serialize;

use crate::progress::Progress;
use crate::session::list_files;
use gfmd_problem::options::{BodyArgs, OtherArgs};
use gfmd_report::figures::parse_prefix;
use gfmd_run::failure::Failure;
use gfmd_run::memory;
use gfmd_run::session::Session;

use experiment::{Experiment, FEWEST_STEPS, MOST_STEPS, Unusable};
pub use experiment::{Optimal, Regime, Run};

/// Flags of `damping`.
#[derive(ClapArgs, Clone, Debug, Serialize)]
#[command(after_help = "One point of a free surface is displaced in all components and released from rest.
Factor 1 damps the slowest mode critically.

Examples:
  gfmd damping --plots figure
  gfmd damping --dim 2 --n 128 --height 0.5 --poisson 0.45 --factors 0.5,1,2 --dt 0.5 --json --out damping.h5")]
pub struct Args {
    /// 3: a surface, components x, y, z; 2: a line in plane strain, components x, z
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u8).range(2..=3), value_name = "2|3")]
    dim: u8,
    /// Points along an edge of the cell, whose length is 1
    #[arg(long, default_value_t = 32, value_name = "N")]
    n: usize,
    /// Height of the slab, or of the top layer; the cell has the length 1
    #[arg(long, default_value_t = 1.0, value_name = "ZM", allow_negative_numbers = true)]
    height: f64,
    /// Young's modulus, stress
    #[arg(long, default_value_t = 1.0, value_name = "E", allow_negative_numbers = true)]
    young: f64,
    /// Poisson's ratio, above -1 and up to 0.5
    #[arg(long, default_value_t = 0.33, value_name = "NU", allow_negative_numbers = true)]
    poisson: f64,
    #[command(flatten)]
    #[serde(flatten)]
    others: OtherArgs,
    /// Damping over the critical damping of the slowest mode
    #[arg(
        long,
        value_delimiter = ',',
        default_values_t = [0.2, 0.5, 1.0, 2.0, 5.0],
        value_name = "F1,F2,..",
        allow_negative_numbers = true
    )]
    factors: Vec<f64>,
    /// Time step over the stability limit without damping, 2/sqrt(k_max)
    #[arg(long, default_value_t = 0.25, value_name = "DT", allow_negative_numbers = true)]
    dt: f64,
    /// Number of time steps; default: enough for the asymptotic rates
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(FEWEST_STEPS as i64..))]
    steps: Option<u32>,
    /// Write histories and rates to this HDF5 file
    #[arg(long, value_name = "FILE.h5")]
    #[serde(skip)]
    out: Option<PathBuf>,
    /// Draw the histories: PREFIX-damping.svg, .png
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix)]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Points of the grid.
    pub n: [usize; 2],
    /// The number of components: 3 for x, y, z, 2 for x, z.
    pub components: usize,
    /// Stiffness of the slowest mode and of the fastest, in stress/length.
    pub stiffness: [f64; 2],
    /// Wave numbers (m, n) of the slowest mode.
    pub slowest_mode: [i64; 2],
    /// Time step at unit mass per area.
    pub dt: f64,
    /// The η that damps the slowest mode critically at this time step, in 1/time².
    pub critical_eta: f64,
    /// The best single damping, with its own time step: theory.md, section 6.2.
    pub optimal: Optimal,
    /// The number of time steps of a run.
    pub steps: u32,
    /// One run for each factor.
    pub runs: Vec<Run>,
    /// The HDF5 file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    /// The figures.
    pub plots: Vec<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// A flag whose value cannot be used; files that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let experiment = experiment(args)?;
    let output = args.out.as_ref().map(Output::claim).transpose().map_err(|error| Failure::input("--out", error))?;
    let mut report = Report::new(&experiment, measure(&experiment, session)?);
    if let Some(output) = &output {
        report.out = Some(write(output, &report, args, session)?);
    }
    if let Some(prefix) = &args.plots {
        report.plots = figures::draw(prefix, &report)?;
    }
    Ok(report)
}

/// The bytes of a step with one factor: three numbers, in vectors that grow to twice their length, and in the file.
const HISTORY_BYTES: u64 = 3 * 8 * 3;

/// Prepares the experiment that the flags describe.
fn experiment(args: &Args) -> Result<Experiment, Failure> {
    let Args { young, poisson, others, .. } = args.clone();
    let height = Height::Finite(args.height);
    let body = BodyArgs { young: Some(young), poisson, height, others, ..BodyArgs::default() }.body()?;
    args.others.check_heights(height, &[1.0])?;
    let points = if args.dim == 2 { [args.n, 1] } else { [args.n; 2] };
    memory::fits(memory::DAMPING, "--n", points)?;
    if let Some(steps) = args.steps {
        let histories = (args.factors.len() as u64).saturating_mul(u64::from(steps));
        memory::check_count("--steps", "steps of all factors", histories, HISTORY_BYTES)?;
    }
    let grid = Grid::new(points, [1.0; 2]).map_err(|error| Failure::input("--n", error))?;
    if args.n < 2 {
        return Err(unusable(args, Unusable::Points));
    }
    Experiment::new(&body, grid, args.dt, &args.factors, args.steps).map_err(|error| unusable(args, error))
}

fn unusable(args: &Args, error: Unusable) -> Failure {
    match error {
        Unusable::Points => Failure::value("--n", args.n, "at least 2"),
        Unusable::TimeStep(found) => Failure::value("--dt", found, "at least 1e-9 and below 1"),
        Unusable::Factor { found, least, largest } => {
            Failure::value("--factors", found, format!("at least {least:.1e} and below {largest} at this time step"))
        }
        Unusable::Steps(enough) => Failure::Input(format!(
            "--steps is missing; it is needed because the rates take {enough:.0} steps, more than {MOST_STEPS:.0}"
        )),
        Unusable::Method(error) => Failure::Computation(error.to_string()),
    }
}

/// Computes one run for each factor.
fn measure(experiment: &Experiment, session: &Session) -> Result<Vec<Run>, Failure> {
    let total = f64::from(experiment.steps) * experiment.verlets.len() as f64;
    let progress = Progress::new(session.quiet, "damping", total);
    let mut runs = Vec::new();
    for damped in &experiment.verlets {
        let (factor, mut reached) = (damped.0, 0);
        let note = format!("factor {factor}");
        let run = experiment.relax(damped, &mut |step| {
            reached = step;
            progress.advance(1.0, &note);
            if session.is_interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        let run = run.map_err(|error| Failure::Computation(error.to_string()))?;
        let stopped = || Failure::Interrupted(format!("interrupted at step {reached} with factor {factor}"));
        runs.push(run.ok_or_else(stopped)?);
    }
    progress.finish();
    Ok(runs)
}

impl Report {
    fn new(experiment: &Experiment, runs: Vec<Run>) -> Self {
        Self {
            n: experiment.response.grid().points(),
            components: experiment.response.components().len(),
            stiffness: [experiment.softest, experiment.response.stiffness_range()[1]],
            slowest_mode: experiment.slowest_mode.number,
            dt: experiment.dt,
            critical_eta: experiment.critical_eta(),
            optimal: experiment.optimal(),
            steps: experiment.steps,
            runs,
            out: None,
            plots: Vec::new(),
        }
    }
}

type History = fn(&Run) -> &[f64];
type Scalar = fn(&Run) -> f64;

fn write(output: &Output, report: &Report, args: &Args, session: &Session) -> Result<PathBuf, Failure> {
    let config = toml::to_string(args).map_err(|error| Failure::Computation(error.to_string()))?;
    let mut archive = Archive::create(output, &session.provenance(config))?;
    let factors = report.runs.iter().map(|run| run.factor).collect();
    let factor = Dimension::values("factor", factors, "1", "damping over the critical damping of the slowest mode");
    let step = Dimension::index("step", report.steps as usize + 1, "time step");
    let histories: [(&str, &str, History); 3] = [
        ("mode", "amplitude of the slowest mode over its start", |run| &run.mode),
        ("predicted", "predicted amplitude of the slowest mode over its start", |run| &run.predicted),
        ("point", "displacement of the pushed point over its start", |run| &run.point),
    ];
    for (name, long_name, history) in histories {
        let variable = Variable { dimensions: &[&factor, &step], units: "1", long_name };
        let values: Vec<f64> = report.runs.iter().flat_map(|run| history(run).iter().copied()).collect();
        archive.write(&format!("/history/{name}"), &variable, &values)?;
    }
    let scalars: [(&str, &str, &str, Scalar); 4] = [
        ("eta", "1/time^2", "damping coefficient of a displacement increment", |run| run.eta),
        ("predicted_rate", "1", "predicted factor per step of the slowest mode", |run| run.predicted_rate),
        ("mode_rate", "1", "measured factor per step of the slowest mode", |run| run.mode_rate),
        ("point_rate", "1", "measured factor per step of the pushed point", |run| run.point_rate),
    ];
    for (name, units, long_name, scalar) in scalars {
        let variable = Variable { dimensions: &[&factor], units, long_name };
        let values: Vec<f64> = report.runs.iter().map(scalar).collect();
        archive.write(&format!("/runs/{name}"), &variable, &values)?;
    }
    archive.attribute("/runs", "dt", report.dt)?;
    archive.attribute("/runs", "critical_eta", report.critical_eta)?;
    Ok(archive.finish()?)
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [nx, ny] = self.n;
        let ([softest, stiffest], [m, n]) = (self.stiffness, self.slowest_mode);
        writeln!(f, "{nx} x {ny} points, {} components; {} steps of {:.6e}", self.components, self.steps, self.dt)?;
        writeln!(
            f,
            "stiffness {softest:.6e} (mode {m}, {n}) to {stiffest:.6e} stress/length, ratio {:.1}",
            stiffest / softest
        )?;
        let Optimal { dt, eta, rate } = self.optimal;
        writeln!(
            f,
            "critical eta {:.6e}; optimal eta {eta:.6e} with steps of {dt:.6e}, rate {rate:.6}\n",
            self.critical_eta
        )?;
        writeln!(
            f,
            "{:>7} {:>12} {:>13} {:>12} {:>10} {:>10} {:>10} {:>9}",
            "factor", "eta", "slowest mode", "oscillating", "predicted", "mode", "point", "to 1e-8"
        )?;
        for run in &self.runs {
            writeln!(
                f,
                "{:>7} {:>12.5e} {:>13} {:>11.1}% {:>10.6} {:>10.6} {:>10.6} {:>9}",
                run.factor,
                run.eta,
                run.regime,
                100.0 * run.oscillating,
                run.predicted_rate,
                run.mode_rate,
                run.point_rate,
                run.steps_to_1e8.map_or_else(|| "never".into(), |steps| steps.to_string()),
            )?;
        }
        list_files(f, self.out.as_deref(), &self.plots)
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    fn evaluate(flags: &str) -> Result<Report, Failure> {
        let flags = std::iter::once("damping").chain(flags.split_whitespace());
        let command = Command::try_parse_from(flags).map_err(|error| Failure::Input(error.to_string()))?;
        run(&command.args, &Session::silent())
    }

    /// Slabs in plane strain and in space. The slowest mode of the last one is not uniform.
    #[test]
    fn measured_rates_agree_with_theory() {
        for flags in [
            "--n 8 --height 1",
            "--n 7 --height 0.3 --poisson -0.5 --dt 0.5 --factors 0.5,1,2",
            "--dim 2 --n 33 --height 0.2 --poisson 0.5",
            "--dim 2 --n 16 --height 0.1 --poisson -0.9 --factors 0.5,1,2",
        ] {
            let report = evaluate(flags).unwrap();
            assert_eq!(report.runs.len(), if flags.contains("factors") { 3 } else { 5 });
            for run in &report.runs {
                let predicted = run.predicted_rate.ln();
                for measured in [run.mode_rate, run.point_rate] {
                    assert!((measured.ln() / predicted - 1.0).abs() < 0.05, "{flags}, {}: {measured}", run.factor);
                }
                // The histories agree step by step, as long as their digits are significant.
                for (step, (found, expected)) in run.mode.iter().zip(&run.predicted).enumerate().take(400) {
                    assert!((found - expected).abs() < 1e-9, "{flags}, {}, {step}: {found} {expected}", run.factor);
                }
            }
            let fastest = report.runs.iter().min_by(|a, b| a.mode_rate.total_cmp(&b.mode_rate)).unwrap();
            assert_eq!((fastest.factor, fastest.regime), (1.0, Regime::Critical));
            assert!(report.optimal.rate < fastest.predicted_rate);
        }
        assert_ne!(evaluate("--dim 2 --n 16 --height 0.1 --poisson -0.9 --factors 1").unwrap().slowest_mode, [0, 0]);
    }

    #[test]
    fn unusable_flags_are_named_with_what_was_found_and_what_is_allowed() {
        for (flags, message) in [
            ("--factors 1,-1", "--factors is -1; it must be at least "),
            ("--factors 100", "--factors is 100; it must be at least "),
            ("--factors 1e-6", "--steps is missing; it is needed because the rates take 2321332963 steps"),
            ("--dt 1", "--dt is 1; it must be at least 1e-9 and below 1"),
            ("--height 0", "--height: "),
            ("--poisson 0.6", "--poisson: "),
            ("--young -1", "--young: "),
            ("--n 0", "--n: "),
            ("--n 1", "--n is 1; it must be at least 2"),
            ("--n 1000000", "--n: 1000000 x 1000000 points need "),
        ] {
            let error = evaluate(flags).unwrap_err().to_string();
            assert!(error.starts_with(message), "{flags}: {error}");
        }
        for flags in ["--steps 1", "--dim 4", "--factors half"] {
            assert!(evaluate(flags).is_err(), "{flags}");
        }
    }
}
