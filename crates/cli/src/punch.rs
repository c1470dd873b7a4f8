//! `punch`: a flat rigid punch on an elastic body, all components of displacement and traction.

use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::{Args as ClapArgs, ValueEnum};
use gfmd_field::Grid;
use gfmd_files::{Archive, Dimension, Output, Variable, axes};
use gfmd_green::{Body, Height};
use gfmd_mixed::{Edge, FlatPunch, Method, MixedError, MixedProblem, MixedSolution, Prescribed};
use gfmd_response::Components;
use ndarray::{Array2, Array3};
use serde::{Deserialize, Serialize};

use crate::progress::Progress;
use gfmd_input::failure::{Failure, Outcome, or_none};
use gfmd_input::memory::{self, peak_bytes};
use gfmd_input::session::Session;
use gfmd_problem::options::flags::toml_of;
use gfmd_problem::options::given::ArrayOption;
use gfmd_problem::options::values::{up_to, within};
use gfmd_problem::options::{BodyArgs, OtherArgs, height_if, parse_height};
use gfmd_problem::options::{DampedBy, DynamicsArgs, SearchArgs};
use gfmd_problem::{check_size, key, setting, words};
use gfmd_record::{PunchContext, PunchFacts, Record};
use gfmd_report::figures::parse_prefix;
use gfmd_run::convergence::NotConverged;
use gfmd_run::series::Watching;
use gfmd_run::trace::{TraceArgs, Tracer};

mod check;
mod comparison;
mod figures;
mod input;
mod refinement;
mod report;
mod stored;

use comparison::Reference;
use gfmd_problem::options::{Kinds, Options};

pub use comparison::Comparison;
pub use refinement::Refinement;
pub use report::Report;
pub use stored::stored;

/// Flags of `punch`. The defaults are the case of the thesis (theory.md, section 0): lengths in micrometres, stress in
/// GPa.
#[derive(ClapArgs, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(
    after_help = "Points under the punch: point i of n lies at x = i L/n, the punch covers (1 - f)/2 < x/L < (1 + f)/2 \
along x and, with --dim 3, y. Points on its edge count with --nodes inclusive, not with strict. N points in a row act \
as a sharp-edged punch with a width of about N - 1/3 spacings (effective_width). With either choice the force \
error is of first order in the spacing; --refine extrapolates to zero spacing.

Examples:
  gfmd punch --nodes inclusive --out punch.h5 --plots punch
  gfmd punch --nodes inclusive --compare continuum_u_n128.npy
  gfmd punch --dim 2 --n 256 --nodes inclusive --refine 4
  gfmd punch --height inf --contact frictionless --poisson 0.5 --punch-fraction 0.5 --json
  gfmd punch --mask ring.npy --shift 0.001,0 --out ring.h5"
)]
pub struct Args {
    /// Side of the square cell, length
    #[arg(
        long,
        alias = "length",
        default_value_t = 1.27,
        value_name = "L",
        allow_negative_numbers = true,
        help_heading = "Punch"
    )]
    #[option(kinds = Kinds::LENGTH)]
    size: f64,
    /// Height of the slab or top layer; "inf" for a half-space; default: the cell length
    #[arg(long, value_name = "ZM", value_parser = parse_height, allow_negative_numbers = true, help_heading = "Body")]
    #[serde(with = "height_if")]
    #[option(kinds = Kinds::LENGTH)]
    height: Option<Height>,
    /// Young's modulus, stress
    #[arg(long, default_value_t = 70.0, value_name = "E", allow_negative_numbers = true, help_heading = "Body")]
    #[option(kinds = Kinds::STRESS)]
    young: f64,
    /// Poisson's ratio, above -1 and at most 0.5
    #[arg(long, default_value_t = 0.33, value_name = "NU", allow_negative_numbers = true, help_heading = "Body")]
    poisson: f64,
    #[command(flatten)]
    #[serde(flatten)]
    others: OtherArgs,
    /// 3: square punch; 2: strip, in plane strain
    #[arg(
        long,
        default_value_t = 3,
        value_parser = clap::value_parser!(u8).range(2..=3),
        value_name = "2|3",
        help_heading = "Punch"
    )]
    #[serde(deserialize_with = "within::<2, 3, _, _>")]
    dim: u8,
    /// Points along each axis; default: the points of --mask, or 128
    #[arg(long, value_name = "N", help_heading = "Punch")]
    #[serde(skip_serializing_if = "Option::is_none")]
    n: Option<usize>,
    /// Punch width divided by cell width
    #[arg(long, default_value_t = 0.25, value_name = "F", allow_negative_numbers = true, help_heading = "Punch")]
    punch_fraction: f64,
    /// Indentation depth, length; on a half-space, below the mean level of the surface
    #[arg(long, default_value_t = 0.005, value_name = "D", allow_negative_numbers = true, help_heading = "Punch")]
    #[option(kinds = Kinds::LENGTH)]
    depth: f64,
    /// Contact condition under the punch
    #[arg(long, value_enum, default_value_t = ContactName::Sticking, help_heading = "Punch")]
    contact: ContactName,
    /// Exclude or include points on the edge of the punch
    #[arg(long, value_enum, default_value_t = Nodes::Strict, help_heading = "Punch")]
    nodes: Nodes,
    /// Mask of a punch of any shape, in place of --punch-fraction: .npy of shape [N, N] ([N] with --dim 2), or
    /// FILE.h5:/dataset; nonzero points are under the punch
    #[arg(
        long,
        value_name = "FILE",
        conflicts_with_all = ["punch_fraction", "nodes", "refine"],
        help_heading = "Punch"
    )]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(array)]
    mask: Option<ArrayOption>,
    /// Traction on points and components not held by the punch: .npy of shape [N, N, 3] ([N, 2] with --dim 2), or
    /// FILE.h5:/dataset
    #[arg(long, value_name = "FILE", conflicts_with = "refine", help_heading = "Punch")]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(array)]
    traction: Option<ArrayOption>,
    /// Lateral displacement of a sticking punch, length
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "X,Y",
        num_args = 1..=2,
        allow_negative_numbers = true,
        help_heading = "Punch"
    )]
    #[serde(skip_serializing_if = "Vec::is_empty", deserialize_with = "up_to::<2, _, _>")]
    #[option(kinds = Kinds::LENGTH)]
    shift: Vec<f64>,
    /// Solution method (docs/solvers.md)
    #[arg(long, value_enum, default_value_t = SolverName::Auto, help_heading = "Solver")]
    solver: SolverName,
    #[command(flatten)]
    #[serde(flatten)]
    dynamics: DynamicsArgs,
    #[command(flatten)]
    #[serde(flatten)]
    trace: TraceArgs,
    #[command(flatten)]
    #[serde(flatten)]
    search: SearchArgs,
    /// Number of grids, each twice as fine as the one before, from which to extrapolate the mean pressure
    #[arg(
        long,
        default_value_t = 1,
        value_parser = clap::value_parser!(u8).range(1..=8),
        value_name = "GRIDS",
        help_heading = "Punch"
    )]
    #[serde(deserialize_with = "within::<1, 8, _, _>")]
    refine: u8,
    /// Compare the displacement with a file: .npy of shape [m, m, 3] ([m, 2] with --dim 2), or FILE.h5[:/dataset] of
    /// another run; if m differs from N, on the points common to both grids
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    #[serde(skip_serializing_if = "Option::is_none")]
    compare: Option<String>,
    /// Write fields and scalars to this HDF5 file
    #[arg(long, value_name = "FILE.h5", help_heading = "Output")]
    #[serde(skip)]
    out: Option<PathBuf>,
    /// Draw maps of displacement and pressure, and a section along x: PREFIX-u_x.svg, .png, ... -pressure, -cut
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix, help_heading = "Output")]
    #[serde(skip)]
    plots: Option<PathBuf>,
}

/// The conditions under the punch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ContactName {
    /// No slip: all components held
    Sticking,
    /// Only the normal displacement held, zero lateral traction
    Frictionless,
}

/// The choices of the points that belong to the punch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Nodes {
    /// Points inside, without the edge
    Strict,
    /// Points inside and on the edge
    Inclusive,
}

/// The names of the methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolverName {
    /// The fastest reliable method: cg
    Auto,
    /// Preconditioned conjugate gradients on the traction
    Cg,
    /// Position Verlet with the best scalar damping
    Verlet,
    /// Position Verlet with the softest mode critically damped
    VerletCritical,
    /// Position Verlet with every mode critically damped, on compressible slabs
    VerletModes,
    /// Fast inertial relaxation engine
    Fire,
}

impl Args {
    /// The method, with its time step and damping.
    fn method(&self) -> Result<Method, Failure> {
        self.dynamics.check(match self.solver {
            SolverName::VerletCritical => DampedBy::Numbers,
            SolverName::VerletModes => DampedBy::Modes,
            _ => DampedBy::Other,
        })?;
        let time_step = self.dynamics.time_step();
        Ok(match self.solver {
            SolverName::Auto | SolverName::Cg => Method::ConjugateGradients,
            SolverName::Verlet => Method::Verlet,
            SolverName::VerletModes => Method::VerletModes { time_step },
            SolverName::Fire => Method::Fire,
            SolverName::VerletCritical => {
                Method::Damped { time_step: time_step.unwrap_or(Method::TIME_STEP), damping: self.dynamics.factors()? }
            }
        })
    }
}

/// The ratio of the depth to the width of the punch, or to the height of the slab, above which strain is not small.
const LARGEST_SMALL_STRAIN: f64 = 0.1;

/// Runs the command.
///
/// # Errors
/// Unusable input; a file that could not be written.
pub fn run(args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
    Prepared::new(args, session)?.run(args, session)
}

/// The input of the command, checked before the first solve.
struct Prepared {
    body: Body,
    height: Height,
    punch: FlatPunch,
    /// The points under the punch, if they are given.
    mask: Option<Array2<bool>>,
    /// The traction where the punch does not hold, `[component, x, y]`.
    traction: Option<Array3<f64>>,
    grids: Vec<Grid>,
    reference: Option<Reference>,
    output: Option<Output>,
}

impl Prepared {
    fn new(args: &Args, session: &Session) -> Result<Self, Failure> {
        args.search.budget().check().map_err(|error| Failure::input(key("tolerance"), error))?;
        args.method()?;
        for (option, given) in [("mask", &args.mask), ("traction", &args.traction)] {
            if let (Some(name), true) = (given, args.refine > 1) {
                return Err(Failure::value(
                    key(option),
                    name,
                    words!["left out with ", key("refine"), ", which solves on several grids"],
                ));
            }
        }
        if !(args.depth.is_finite() && args.depth > 0.0) {
            return Err(Failure::value(key("depth"), args.depth, "positive and finite"));
        }
        for (option, size) in [("depth", args.depth), ("size", args.size)] {
            if size.is_finite() && size > 0.0 {
                check_size(option, size)?;
            }
        }
        let mask = args.mask.as_ref().map(|name| input::mask(name, args.dim)).transpose()?;
        let n = input::points(args.n, mask.as_ref())?;
        let finest = n.saturating_mul(1 << (args.refine - 1));
        for (option, n) in [("n", n), ("refine", finest)] {
            memory::fits(memory::PUNCH, key(option), [n, if args.dim == 2 { 1 } else { n }])?;
        }
        let grids =
            (0..args.refine).map(|level| grid(args, n.saturating_mul(1 << level))).collect::<Result<Vec<_>, _>>()?;
        let height = args.height.unwrap_or(Height::Finite(args.size));
        let Args { young, poisson, others, .. } = args.clone();
        let body = BodyArgs { young: Some(young), poisson, height, others, ..BodyArgs::default() }.body()?;
        args.others.check_heights(height, &[args.size])?;
        let edge = match args.nodes {
            Nodes::Strict => Edge::Strict,
            Nodes::Inclusive => Edge::Inclusive,
        };
        let punch =
            FlatPunch::new(args.punch_fraction, edge).map_err(|error| Failure::input(key("punch_fraction"), error))?;
        if mask.is_none() && punch.points_across(&grids[0]) == 0 {
            let reason = format!("no point of {n} across lies under a punch of {} of the cell", args.punch_fraction);
            return Err(Failure::input(key("punch_fraction"), reason + "; more points or a wider punch are needed"));
        }
        let components = Components::of(&grids[0]).len();
        let traction = args.traction.as_ref().map(|name| input::traction(name, &grids[0])).transpose()?;
        input::check_shift(args)?;
        let reference = args.compare.as_ref().map(|name| Reference::read(name, grids[0].points(), components));
        let reference = reference.transpose()?;
        let output = session.output(args.out.as_ref())?;
        Ok(Self { body, height, punch, mask, traction, grids, reference, output })
    }

    fn run(&self, args: &Args, session: &Session) -> Result<Outcome<Report>, Failure> {
        self.warn_about_large_strain(args, session);
        let progress = Progress::new(session, "grids", self.grids.len());
        let (mut report, solution, mut failure) = self.press(args, &self.grids[0], session, &progress)?;
        let reference = self.reference.as_ref();
        if let Some((reference, name)) = reference.zip(args.compare.as_ref()) {
            report.comparison = Some(reference.compare(name, &solution, args.depth));
        }
        let mut pressures = vec![report.numbers.number("mean_pressure")];
        for grid in &self.grids[1..] {
            if failure.is_none() {
                let (finer, _, stopped) = self.press(args, grid, session, &progress)?;
                pressures.push(finer.numbers.number("mean_pressure"));
                report.not_converged = finer.not_converged;
                failure = stopped;
            }
        }
        progress.finish();
        if self.grids.len() > 1 && failure.is_none() {
            let n = self.grids.iter().map(|grid| grid.points()[0]).collect();
            report.refinement = Some(Refinement::of(n, pressures));
        }
        report.peak_bytes = peak_bytes();
        if let Some(output) = &self.output {
            report.out = session.written(Some(self.write(output, args, session, &report, &solution)?));
        }
        if let (None, Some(prefix)) = (&failure, &args.plots) {
            let drawn = figures::draw(prefix, &report, &self.grids[0], &self.body, &solution, reference);
            report.plots = or_none(drawn, &mut failure);
        }
        let kept = report.out.as_deref().map_or_else(String::new, |out: &Path| format!("; kept in {}", out.display()));
        Ok(Outcome { report, failure: failure.map(|failure| failure.with(&kept)) })
    }

    fn warn_about_large_strain(&self, args: &Args, session: &Session) {
        let width = if self.mask.is_some() { f64::INFINITY } else { args.punch_fraction * args.size };
        let lengths = [("the width of the punch", width), ("the height of the slab", self.finite_height())];
        for (what, length) in lengths.into_iter().filter(|(_, length)| args.depth > LARGEST_SMALL_STRAIN * length) {
            let part = args.depth / length;
            let text = format!(": {} is {part:.2} of {what}; linear elasticity holds for small strain", args.depth);
            session.warn("large-strain", words![key("depth"), text]);
        }
    }

    fn finite_height(&self) -> f64 {
        match self.height {
            Height::Finite(height) => height,
            Height::Infinite => f64::INFINITY,
        }
    }

    fn press(
        &self,
        args: &Args,
        grid: &Grid,
        session: &Session,
        progress: &Progress,
    ) -> Result<(Report, MixedSolution, Option<Failure>), Failure> {
        let started = Instant::now();
        let problem = self.problem(args, grid)?;
        let n = grid.points()[0];
        let tracer = args.trace.tracer(grid, Components::of(grid).axes())?;
        let mut watch = Watching::new(format!("n = {n}"), progress, session).with(tracer, None);
        let mut not_converged = None;
        let solved = problem.solve(args.method()?, &args.search.budget(), &mut watch);
        let Watching { history, tracer, .. } = watch;
        let (solution, failure) = match solved {
            Ok(solution) => (solution, None),
            Err(MixedError::NotConverged { solution, asked, why }) => {
                let text = format!(
                    "n = {n} did not converge to {asked:e} in {} iterations ({why}): residual {:.1e}",
                    solution.iterations, solution.residual
                );
                let level = self.grids.iter().position(|other| other == grid).unwrap_or(0);
                let unmet = NotConverged::of(
                    level,
                    vec![("residual", solution.residual)],
                    asked,
                    &why,
                    history,
                    session.spelling(),
                );
                unmet.tell("grid");
                not_converged = Some(unmet);
                (*solution, Some(Failure::NotConverged(text.into())))
            }
            Err(MixedError::Interrupted { solution }) => {
                (*solution, Some(Failure::interrupted(format!("interrupted at n = {n}"))))
            }
            Err(MixedError::Search(error)) if args.dynamics.is_given() => {
                return Err(Failure::input(words![key("dt"), ", ", key("damping")], error));
            }
            Err(MixedError::Search(error)) if args.solver == SolverName::VerletModes => {
                return Err(Failure::input(setting("solver", "verlet-modes"), error));
            }
            Err(error) => return Err(Failure::computation(error.to_string())),
        };
        progress.advance(1.0, &format!("n = {n}, residual {:.1e}", solution.residual));
        let seconds = started.elapsed().as_secs_f64();
        let history = tracer.map(Tracer::trace);
        let report =
            Report { not_converged, history, ..self.measure(args, grid, &self.points(grid), &solution, seconds) };
        Ok((report, solution, failure))
    }

    /// The points under the punch.
    fn points(&self, grid: &Grid) -> Array2<bool> {
        self.mask.clone().unwrap_or_else(|| self.punch.points(grid))
    }

    /// The boundary conditions on a grid.
    fn problem(&self, args: &Args, grid: &Grid) -> Result<MixedProblem, Failure> {
        let points = self.points(grid);
        let [x, y] = [0, 1].map(|axis| args.shift.get(axis).copied().unwrap_or(0.0));
        let prescribed = match args.contact {
            ContactName::Sticking => Prescribed::sticking(grid, points.view(), [x, y, -args.depth]),
            ContactName::Frictionless => Prescribed::frictionless(grid, points.view(), -args.depth),
        };
        let prescribed = match &self.traction {
            Some(traction) => prescribed.and_then(|prescribed| prescribed.with_traction(traction.view())),
            None => prescribed,
        };
        let problem = prescribed.and_then(|prescribed| MixedProblem::new(&self.body, grid, prescribed));
        problem.map_err(|error| Failure::computation(error.to_string()))
    }

    /// Returns the features that decide which numbers the punch has.
    fn facts(&self) -> PunchFacts {
        PunchFacts { mask: self.mask.is_some(), line: self.grids[0].is_line() }
    }

    fn measure(
        &self,
        args: &Args,
        grid: &Grid,
        points: &Array2<bool>,
        solution: &MixedSolution,
        seconds: f64,
    ) -> Report {
        let components = Components::of(grid);
        let at = PunchContext {
            solution,
            components,
            widths: [args.punch_fraction * args.size, self.punch.effective_width(grid)],
            depth: args.depth,
            contact_nodes: points.iter().filter(|under| **under).count(),
            tolerance: args.search.tolerance,
            seconds,
        };
        Report {
            dim: args.dim,
            n: grid.points(),
            size: grid.lengths(),
            height: self.height,
            young: args.young,
            poisson: args.poisson,
            others: args.others.clone(),
            contact: args.contact,
            nodes: args.nodes,
            mask: args.mask.clone(),
            prescribed_traction: args.traction.clone(),
            shift: args.shift.clone(),
            components: names(components),
            numbers: Record::compute(&self.facts(), &at),
            comparison: None,
            refinement: None,
            not_converged: None,
            history: None,
            peak_bytes: 0,
            out: None,
            plots: Vec::new(),
        }
    }

    fn write(
        &self,
        output: &Output,
        args: &Args,
        session: &Session,
        report: &Report,
        solution: &MixedSolution,
    ) -> Result<PathBuf, Failure> {
        let n = Some(self.grids[0].points()[0]);
        let resolved = Args { height: Some(self.height), n, ..args.clone() };
        let config = toml_of(&resolved).map_err(|error| Failure::computation(error.to_string()))?;
        let mut archive = Archive::create(output, &session.provenance(config))?;
        let [x, y] = axes(&self.grids[0], "length");
        let component = Dimension::labels("component", &report.components, "component of the vector");
        let fields = [
            ("/fields/displacement", "length", "displacement of the surface", &solution.displacement),
            ("/fields/traction", "stress", "traction on the surface, negative t_z presses", &solution.traction),
        ];
        for (path, units, long_name, field) in fields {
            let variable = Variable { dimensions: &[&x, &y, &component], units, long_name };
            archive.write(path, &variable, &by_point(field))?;
        }
        let under: Vec<u8> = self.points(&self.grids[0]).iter().map(|under| u8::from(*under)).collect();
        let held = Variable { dimensions: &[&x, &y], units: "1", long_name: "1 where the punch holds the surface" };
        archive.write("/fields/under_punch", &held, &under)?;
        let facts = self.facts();
        for (column, cell) in report.numbers.cells().filter(|(column, _)| (column.in_file)(&facts)) {
            let variable = Variable { dimensions: &[], units: column.unit, long_name: column.meaning(&facts) };
            archive.write(&format!("/punch/{}", column.name), &variable, &[cell.number()])?;
        }
        report.not_converged.as_ref().map_or(Ok(()), |unmet| unmet.write(&mut archive))?;
        report.history.as_ref().map_or(Ok(()), |history| history.write(&mut archive, "length"))?;
        report.refinement.as_ref().map_or(Ok(()), |refinement| refinement.write(&mut archive))?;
        Ok(archive.finish()?)
    }
}

fn grid(args: &Args, n: usize) -> Result<Grid, Failure> {
    if n < 2 {
        return Err(Failure::value(key("n"), n, "at least 2"));
    }
    let grid = if args.dim == 2 { Grid::line(n, args.size) } else { Grid::square(n, args.size) };
    grid.map_err(|error| Failure::input(key("size"), error))
}

fn names(components: Components) -> Vec<&'static str> {
    components.axes().iter().map(|axis| ["x", "y", "z"][*axis]).collect()
}

/// Returns the values `[x, y, component]` in row-major order.
fn by_point(field: &Array3<f64>) -> Vec<f64> {
    field.view().permuted_axes([1, 2, 0]).iter().copied().collect()
}
