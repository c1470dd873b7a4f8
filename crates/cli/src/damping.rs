//! `damping`: what damping does to the relaxation of a free surface, predicted and measured.

mod figures;

use std::f64::consts::TAU;
use std::fmt;
use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_field::{Grid, Mode};
use gfmd_files::{Archive, Dimension, Output, Variable};
use gfmd_green::{Body, GreenError, Material, stiffness_range};
use gfmd_relax::{Damping, Landscape, Method, Motion, RelaxError, Verlet};
use gfmd_response::{Components, FullResponse, Workspace};
use serde::Serialize;

use crate::failure::Failure;
use crate::figures::parse_prefix;
use crate::memory::Held;
use crate::progress::Progress;
use crate::session::{Session, list_files};

/// Flags of `damping`.
#[derive(ClapArgs, Clone, Debug, Serialize)]
#[command(
    after_help = "A push at one point of the surface, in all components, is released from rest; nothing touches it.
Factor 1 damps the slowest mode critically.

Examples:
  gfmd damping --plots figure
  gfmd damping --dim 2 --n 128 --height 0.5 --poisson 0.45 --factors 0.5,1,2 --dt 0.5 --json --out damping.h5"
)]
pub struct Args {
    /// 3: a surface, components x, y, z; 2: a line in plane strain, components x, z
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u8).range(2..=3), value_name = "2|3")]
    dim: u8,
    /// Points along an edge of the cell, whose length is 1
    #[arg(long, default_value_t = 32, value_name = "N")]
    n: usize,
    /// Height of the slab, bonded to a rigid base; the cell has the length 1
    #[arg(long, default_value_t = 1.0, value_name = "ZM", allow_negative_numbers = true)]
    height: f64,
    /// Young's modulus, stress
    #[arg(long, default_value_t = 1.0, value_name = "E", allow_negative_numbers = true)]
    young: f64,
    /// Poisson's ratio, above -1 and up to 0.5
    #[arg(long, default_value_t = 0.33, value_name = "NU", allow_negative_numbers = true)]
    poisson: f64,
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
    /// Time steps; enough to see the asymptotic rates if absent
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
    /// Components that move: x, y, z, or x, z.
    pub components: usize,
    /// Stiffness of the slowest mode and of the fastest, in stress/length.
    pub stiffness: [f64; 2],
    /// Wave numbers (m, n) of the slowest mode.
    pub slowest_mode: [i64; 2],
    /// Time step at unit mass per area.
    pub dt: f64,
    /// η that damps the slowest mode critically at this time step, in 1/time².
    pub critical_eta: f64,
    /// The best single damping, with its own time step: theory.md, section 6.2.
    pub optimal: Optimal,
    /// Time steps done.
    pub steps: u32,
    /// One for each factor.
    pub runs: Vec<Run>,
    /// The HDF5 file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    /// Figures drawn.
    pub plots: Vec<PathBuf>,
}

/// The best single damping of the band.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Optimal {
    /// Time step.
    pub dt: f64,
    /// η, in 1/time².
    pub eta: f64,
    /// Factor per step of the slowest error in the long run.
    pub rate: f64,
}

/// Relaxation with one damping. A rate is the factor per step by which an amplitude shrinks in the long run.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// η over the critical one.
    pub factor: f64,
    /// η, in 1/time².
    pub eta: f64,
    /// What the slowest mode does.
    pub regime: Regime,
    /// Modes that oscillate, part of all.
    pub oscillating: f64,
    /// Predicted rate of the slowest mode: the largest eigenvalue of its update matrix, in magnitude.
    pub predicted_rate: f64,
    /// Measured rate of the slowest mode.
    pub mode_rate: f64,
    /// Measured rate of the point that was pushed.
    pub point_rate: f64,
    /// Predicted steps until the slowest mode stays below 1e-8 of its start.
    pub steps_to_1e8: Option<u32>,
    /// Amplitude of the slowest mode over its start, step by step.
    #[serde(skip)]
    pub mode: Vec<f64>,
    /// The same, predicted.
    #[serde(skip)]
    pub predicted: Vec<f64>,
    /// Displacement of the point that was pushed over its start, in the component in which the slowest mode moves most.
    #[serde(skip)]
    pub point: Vec<f64>,
}

/// What a mode does on its way to rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Regime {
    /// It oscillates.
    UnderDamped,
    /// It decays fastest without oscillation.
    Critical,
    /// It creeps.
    OverDamped,
}

impl Regime {
    fn of(motion: Motion) -> Self {
        match motion {
            Motion::UnderDamped { .. } => Self::UnderDamped,
            Motion::Critical { .. } => Self::Critical,
            Motion::OverDamped { .. } => Self::OverDamped,
        }
    }
}

impl fmt::Display for Regime {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.pad(match self {
            Self::UnderDamped => "under-damped",
            Self::Critical => "critical",
            Self::OverDamped => "over-damped",
        })
    }
}

/// Runs the command.
///
/// # Errors
/// A flag whose value cannot be used; files that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let experiment = Experiment::new(args)?;
    let output = args.out.as_ref().map(Output::claim).transpose().map_err(|error| Failure::input("--out", error))?;
    let mut report = experiment.run(session)?;
    if let Some(output) = &output {
        report.out = Some(write(output, &report, args, session)?);
    }
    if let Some(prefix) = &args.plots {
        report.plots = figures::draw(prefix, &report)?;
    }
    Ok(report)
}

/// The surface of a body on which nothing acts.
struct Free<'a> {
    response: &'a FullResponse,
    workspace: Workspace,
}

impl Landscape for Free<'_> {
    fn len(&self) -> usize {
        self.response.components().len() * self.response.grid().len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        let fits = "u and force have the length of the problem";
        self.response.stiffness().apply(u, force, &mut self.workspace).expect(fits);
        force.iter_mut().for_each(|f| *f = -*f);
        -0.5 * gfmd_vector::dot(u, force)
    }

    fn residual(&self, u: &[f64], _: &[f64]) -> f64 {
        u.iter().fold(0.0, |largest, u| f64::max(largest, u.abs()))
    }
}

/// What is set up before the first step.
struct Experiment {
    response: FullResponse,
    dt: f64,
    steps: u32,
    verlets: Vec<(f64, Verlet)>,
    slowest: (f64, Mode),
    /// The shape of the slowest mode on the surface.
    pattern: Vec<f64>,
    /// Index of the pushed entry that is watched.
    watched: usize,
}

impl Experiment {
    fn new(args: &Args) -> Result<Self, Failure> {
        let material = Material::from_young(args.young, args.poisson);
        let body = material.and_then(|material| Body::slab(material, args.height)).map_err(|error| {
            let flag = match &error {
                GreenError::Young(_) => "--young",
                GreenError::Poisson(_) => "--poisson",
                _ => "--height",
            };
            Failure::input(flag, error)
        })?;
        let grid = match args.dim {
            2 => Grid::line(args.n, 1.0),
            _ => Grid::square(args.n, 1.0),
        };
        let grid = grid.map_err(|error| Failure::input("--n", error))?;
        let refuse = || Failure::input("--n", format!("found {}, allowed: 2 or more", args.n));
        if args.n < 2 {
            return Err(refuse());
        }
        Held::DAMPING.check("--n", grid.points())?;
        let range = stiffness_range(&body, &grid).ok_or_else(refuse)?;
        if !(args.dt > 0.0 && args.dt < 1.0) {
            return Err(Failure::input("--dt", format!("found {}, allowed: between 0 and 1", args.dt)));
        }
        let dt = args.dt * 2.0 / range.stiffest.sqrt();
        let critical = Damping::critical(range.softest, dt).eta();
        // theory.md, section 6.1: τ k_max < 2 (1 + β).
        let largest = (2.0 - 0.5 * range.stiffest * dt * dt) / (critical * dt * dt);
        if let Some(bad) = args.factors.iter().find(|factor| !(**factor > 0.0 && **factor < largest)) {
            let allowed = format!("found {bad}, allowed at this time step: above 0 and below {largest}");
            return Err(Failure::input("--factors", allowed));
        }
        let verlet = |&factor: &f64| {
            let damping = Damping { beta: 1.0 - factor * critical * dt * dt, tau: dt * dt };
            Verlet::new(damping, range.stiffest).map(|verlet| (factor, verlet))
        };
        let verlets = args.factors.iter().map(verlet).collect::<Result<Vec<_>, _>>().map_err(failed)?;
        let slowest = verlets.iter().map(|(_, v)| v.damping.spectral_radius(range.softest)).fold(0.0, f64::max);
        let enough = (DECAY / -slowest.ln()).ceil().max(f64::from(FEWEST_STEPS));
        let steps = match args.steps {
            Some(steps) => steps,
            None if enough <= MOST_STEPS => enough as u32,
            None => {
                let reason = format!("found none; {enough:.0} would show the rates, {MOST_STEPS:.0} are done unasked");
                return Err(Failure::input("--steps", reason));
            }
        };
        let (pattern, component) = pattern(&body, &grid, &range.softest_mode);
        let response = FullResponse::new(grid, &body);
        let watched = component * grid.len();
        Ok(Self { response, dt, steps, verlets, slowest: (range.softest, range.softest_mode), pattern, watched })
    }

    fn run(&self, session: &Session) -> Result<Report, Failure> {
        let [_, stiffest] = self.response.stiffness_range();
        let (softest, mode) = self.slowest;
        let progress = Progress::new(&session.common, "damping", f64::from(self.steps) * self.verlets.len() as f64);
        let mut runs = Vec::new();
        for (factor, verlet) in &self.verlets {
            runs.push(self.relax(*factor, verlet, &progress, session)?);
        }
        progress.finish();
        let optimal = Damping::optimal(softest, stiffest);
        let rate = optimal.spectral_radius(softest);
        Ok(Report {
            n: self.response.grid().points(),
            components: self.response.components().len(),
            stiffness: [softest, stiffest],
            slowest_mode: mode.number,
            dt: self.dt,
            critical_eta: Damping::critical(softest, self.dt).eta(),
            optimal: Optimal { dt: optimal.tau.sqrt(), eta: optimal.eta(), rate },
            steps: self.steps,
            runs,
            out: None,
            plots: Vec::new(),
        })
    }

    fn relax(&self, factor: f64, verlet: &Verlet, progress: &Progress, session: &Session) -> Result<Run, Failure> {
        let points = self.response.grid().len();
        let mut free = Free { response: &self.response, workspace: self.response.workspace() };
        let mut push = vec![0.0; free.len()];
        for (axis, component) in push.chunks_exact_mut(points).enumerate() {
            component[0] = 1.0;
            // The mean of an incompressible slab does not move.
            if self.response.uniform_compliance()[self.response.components().axes()[axis]] == 0.0 {
                component.iter_mut().for_each(|u| *u -= 1.0 / points as f64);
            }
        }
        let mut state = verlet.start(&mut free, push).map_err(failed)?;
        let start = gfmd_vector::dot(&self.pattern, &state.u);
        let (mut mode, mut point) = (Vec::new(), Vec::new());
        for step in 0..=self.steps {
            mode.push(gfmd_vector::dot(&self.pattern, &state.u) / start);
            point.push(state.u[self.watched]);
            if session.is_interrupted() {
                return Err(Failure::Interrupted(format!("interrupted at step {step} with factor {factor}")));
            }
            verlet.step(&mut free, &mut state).map_err(failed)?;
            progress.advance(1.0, &format!("factor {factor}"));
        }
        let (softest, damping) = (self.slowest.0, verlet.damping);
        Ok(Run {
            factor,
            eta: damping.eta(),
            regime: Regime::of(damping.motion(softest)),
            oscillating: self.oscillating(&damping),
            predicted_rate: damping.spectral_radius(softest),
            mode_rate: rate(&mode),
            point_rate: rate(&point),
            steps_to_1e8: damping.steps_to(softest, 1e-8),
            predicted: (0..=self.steps).map(|step| damping.amplitude(softest, step)).collect(),
            mode,
            point,
        })
    }

    /// Part of the modes, counted with their weight, that oscillate.
    fn oscillating(&self, damping: &Damping) -> f64 {
        let grid = self.response.grid();
        let line = self.response.components() == Components::Plane;
        let (mut oscillating, mut all) = (0.0, 0.0);
        for (mode, matrix) in grid.modes().zip(self.response.stiffness().matrices()) {
            for (k, [_, y, _]) in matrix.modes() {
                if line && y.abs() > 0.5 {
                    continue;
                }
                all += mode.weight;
                if matches!(damping.motion(k), Motion::UnderDamped { .. }) {
                    oscillating += mode.weight;
                }
            }
        }
        oscillating / all
    }
}

/// Powers of e by which the slowest run shrinks: rates then have settled to a few per cent.
const DECAY: f64 = 70.0;

/// Histories are kept in memory.
const MOST_STEPS: f64 = 1e6;

/// A rate needs two windows of some steps each.
const FEWEST_STEPS: u32 = 40;

fn failed(error: RelaxError) -> Failure {
    Failure::Computation(error.to_string())
}

/// The real field of the softest eigenvector of `mode`, and the component in which it is largest.
fn pattern(body: &Body, grid: &Grid, mode: &Mode) -> (Vec<f64>, usize) {
    let components = Components::of(grid);
    let matrix = gfmd_response::Hermitian::of(&body.stiffness_of(mode));
    let moves = |vector: &[f64; 3]| components == Components::Space || vector[1].abs() < 0.5;
    let modes = matrix.modes();
    let softest = modes.iter().map(|(_, vector)| vector).find(|vector| moves(vector)).unwrap_or(&modes[0].1);
    let [nx, ny] = grid.points();
    let mut pattern = Vec::with_capacity(components.len() * grid.len());
    for &axis in components.axes() {
        for (i, j) in (0..nx).flat_map(|i| (0..ny).map(move |j| (i, j))) {
            let turns = mode.number[0] as f64 * i as f64 / nx as f64 + mode.number[1] as f64 * j as f64 / ny as f64;
            // The component along z is imaginary.
            let wave = if axis == 2 { -(TAU * turns).sin() } else { (TAU * turns).cos() };
            let uniform = if axis == 2 && mode.is_self_conjugate() { (TAU * turns).cos() } else { wave };
            pattern.push(softest[axis] * uniform);
        }
    }
    let largest =
        |(_, a): &(usize, &usize), (_, b): &(usize, &usize)| softest[**a].abs().total_cmp(&softest[**b].abs());
    let component = components.axes().iter().enumerate().max_by(largest).map_or(0, |(index, _)| index);
    (pattern, component)
}

/// Factor per step by which an amplitude shrinks in the long run: windows as long as a quarter of the run, in the middle
/// and at the end, are compared by their largest amplitude.
fn rate(history: &[f64]) -> f64 {
    // What rounding leaves in motions that nothing brings to rest would show far below.
    let steps = history.iter().rposition(|x| x.abs() > 1e-30).unwrap_or(0) / 2;
    let window = steps / 2;
    let largest = |end: usize| history[end - window..end].iter().fold(0.0, |m, x| f64::max(m, x.abs()));
    (largest(2 * steps) / largest(steps)).powf(1.0 / steps as f64)
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
            "critical eta {:.6e}; best of all: eta {eta:.6e} with steps of {dt:.6e}, rate {rate:.6}\n",
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
    use crate::session::Common;

    #[derive(Parser)]
    struct Command {
        #[command(flatten)]
        args: Args,
    }

    fn evaluate(flags: &str) -> Result<Report, Failure> {
        let flags = std::iter::once("damping").chain(flags.split_whitespace());
        let command = Command::try_parse_from(flags).map_err(|error| Failure::Input(error.to_string()))?;
        let common = Common { json: false, threads: 0, quiet: true, verbose: 0 };
        run(&command.args, &Session::silent(common))
    }

    /// In the plane and in space, for slabs whose slowest mode is uniform and for one where it is not.
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
                // Step by step, as long as there are digits.
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
            ("--factors 1,-1", "--factors: found -1, allowed at this time step: above 0 and below "),
            ("--factors 100", "--factors: found 100, allowed at this time step: above 0 and below "),
            ("--factors 1e-6", "--steps: found none; 2321332963 would show"),
            ("--dt 1", "--dt: found 1, allowed: between 0 and 1"),
            ("--height 0", "--height: "),
            ("--poisson 0.6", "--poisson: "),
            ("--young -1", "--young: "),
            ("--n 0", "--n: "),
            ("--n 1", "--n: found 1, allowed: 2 or more"),
            ("--n 1000000", "the grid: 1000000 x 1000000 points need about "),
        ] {
            let error = evaluate(flags).unwrap_err().to_string();
            assert!(error.starts_with(message), "{flags}: {error}");
        }
        for flags in ["--steps 1", "--dim 4", "--factors half"] {
            assert!(evaluate(flags).is_err(), "{flags}");
        }
    }
}
