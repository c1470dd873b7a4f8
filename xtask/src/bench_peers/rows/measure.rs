//! Measurements of each row.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use gfmd_contact::{Boundary, Contact, Equilibrium as _, Load, Solution, Solver, Stiffness};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_problem::MemoryNeed;
use ndarray::{Array2, Array3, Axis};
use ndarray_npy::write_npy;
use rayon::ThreadPoolBuilder;
use serde_json::{Value, json};
use tempfile::TempDir;

use super::super::contestant::{Contestant, Place, Problem, own};
use super::super::judge::{Verdict, judge};
use super::super::process::ProgramFailure;
use super::super::python::{Environment, LONG};
use super::super::solve::Solve;
use super::super::tolerance::{MARGIN, loosest};
use super::super::{Args as PeerArgs, Peer, problems, rough, work_folder};
use super::{Args, Case, Row};

/// Reduced pressures of the loads.
const LOADS: [f64; 3] = [0.001, 0.01, 0.2];
/// Reduced pressure of rows with one load.
const USUAL: f64 = 0.01;
/// Loads of the ramp: first, last, number.
const RAMP: (f64, f64, usize) = (0.001, 0.5, 20);
/// Tolerance of a solution, the default of the program.
const TOLERANCE: f64 = 1e-8;
/// Number of processes with one thread each.
const RANKS: usize = 4;
/// Hurst exponents of the surfaces for Tamaas.
const HURST: [f64; 2] = [0.0, 0.8];
/// Points along a side for the memory prediction.
const HUGE: usize = 16384;
/// Points along a side of small contacts, and divisor of their number.
const SMALL_SIDES: [(usize, usize); 2] = [(128, 1), (256, 3)];
const MANY: (&str, &str) = ("many.py", include_str!("../../../peers/many.py"));

/// Settings of the measurements.
pub(super) struct Trial<'a> {
    args: &'a Args,
    session: &'a Session,
    program: PathBuf,
    cores: usize,
    scratch: TempDir,
}

fn failed(error: impl std::fmt::Display) -> Failure {
    Failure::computation(error.to_string())
}

/// Surface to measure.
struct Rough {
    heights: Array2<f64>,
    rms_gradient: f64,
    file: PathBuf,
}

/// Returns a row with the measured cases, or the reason why there are none.
fn row(what: &str, bar: impl Into<Option<f64>>, cases: Result<Vec<Case>, String>) -> Row {
    let (cases, left_out) = match cases {
        Ok(cases) => (cases, None),
        Err(reason) => (Vec::new(), Some(reason)),
    };
    Row { what: what.into(), bar: bar.into(), at_least: false, cases, left_out }
}

impl<'a> Trial<'a> {
    pub(super) fn new(args: &'a Args, session: &'a Session) -> Result<Self, Failure> {
        let scratch = tempfile::tempdir_in(work_folder()?).map_err(failed)?;
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        Ok(Self { args, session, program: std::env::current_exe().map_err(failed)?, cores, scratch })
    }

    /// Refuses to go on after an interruption.
    fn go_on(&self) -> Result<(), Failure> {
        if self.session.is_interrupted() {
            return Err(Failure::interrupted("interrupted: bench-rows"));
        }
        Ok(())
    }

    fn rough(&self, points: usize) -> Result<Rough, Failure> {
        let (heights, rms_gradient) = rough(points, self.args.hurst, 1)?;
        let file = self.scratch.path().join(format!("h-{points}.npy"));
        write_npy(&file, &heights).map_err(failed)?;
        Ok(Rough { heights, rms_gradient, file })
    }

    fn case(&self, points: usize, p_star: f64, threads: usize) -> Case {
        Case { of: format!("{points}², p* = {p_star}"), threads, found: Vec::new(), over: Vec::new() }
    }

    /// Solves alone, in a separate process.
    fn alone(&self, rough: &Rough, p_star: f64, threads: usize) -> Result<Solve, Failure> {
        self.go_on()?;
        let problem = Problem {
            points: rough.heights.nrows(),
            hurst: self.args.hurst,
            p_star,
            mean_pressure: p_star * rough.rms_gradient,
            heights: rough.file.clone(),
            boundary: Boundary::Periodic,
            hardness: None,
            most_iterations: None,
            answer: PathBuf::new(),
        };
        let solve = own(Solver::Auto, &problem, TOLERANCE, threads, None, self.session);
        solve.and_then(Solve::converged).map_err(|ended| ended.failure("a solution"))
    }

    /// Runs the process `contact --surface`; returns its wall time and its report.
    fn contact(
        &self,
        (starter, more): (&[&str], &[&str]),
        rough: &Rough,
        p_star: f64,
        threads: usize,
    ) -> Result<(f64, Value), Failure> {
        self.go_on()?;
        let mut words: Vec<&str> = starter.to_vec();
        let program = self.program.to_string_lossy();
        words.push(&program);
        let mut command = Command::new(words[0]);
        command.args(&words[1..]).args(["contact", "--json", "--quiet", "--surface"]).arg(&rough.file).args(more);
        command.args(["--pressure", &format!("{:?}", p_star * rough.rms_gradient), "--threads", &threads.to_string()]);
        let started = Instant::now();
        let output = command.output().map_err(|error| failed(format!("{}: {error}", words[0])))?;
        let seconds = started.elapsed().as_secs_f64();
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            let said = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("no message").trim().to_owned();
            return Err(failed(format!("{}: {}: {said}", words[0], output.status)));
        }
        Ok((seconds, serde_json::from_slice(&output.stdout).map_err(failed)?))
    }

    /// Returns the time of the usual load, as reported by the program.
    fn reported(&self, rough: &Rough, more: (&[&str], &[&str]), threads: usize) -> Result<f64, Failure> {
        self.reported_time_at(USUAL, rough, more, threads)
    }

    /// Returns the time of a load, as reported by the program.
    fn reported_time_at(
        &self,
        p_star: f64,
        rough: &Rough,
        more: (&[&str], &[&str]),
        threads: usize,
    ) -> Result<f64, Failure> {
        let (_, report) = self.contact(more, rough, p_star, threads)?;
        report["loads"][0]["seconds"].as_f64().ok_or_else(|| failed("the report of contact has no seconds"))
    }

    /// Compares the process and the stiffness with the solution alone.
    pub(super) fn processes(&self) -> Result<Vec<Row>, Failure> {
        let n = self.args.n;
        let rough = self.rough(n)?;
        let contact = posed(&rough.heights)?;
        let one = pool()?;
        let mut cases = [Vec::new(), Vec::new()];
        for p_star in LOADS {
            let [mut process, mut stiffness] = [self.case(n, p_star, 1), self.case(n, p_star, 1)];
            for _ in 0..self.args.repeats {
                process.over.push(self.alone(&rough, p_star, 1)?.seconds);
                process.found.push(self.contact((&[], &[]), &rough, p_star, 1)?.0);
                let (over, found) = one.install(|| -> Result<_, Failure> {
                    let (seconds, solution) = solved(&contact, p_star, None)?;
                    let started = Instant::now();
                    let found = contact.stiffness(&solution, Stiffness::TOLERANCE);
                    found.map_err(|(_, why)| failed(format!("the stiffness: {why:?}")))?;
                    Ok((seconds, started.elapsed().as_secs_f64()))
                })?;
                stiffness.over.push(over);
                stiffness.found.push(found);
            }
            cases[0].push(process);
            cases[1].push(stiffness);
        }
        let [process, stiffness] = cases;
        Ok(vec![
            row("process `contact --surface` over its solution", 1.9, Ok(process)),
            row("stiffness over the solution", 0.15, Ok(stiffness)),
        ])
    }

    /// Measures the time of `report` of a contact with half as many points along a side.
    pub(super) fn report(&self) -> Result<Vec<Row>, Failure> {
        let n = self.args.n / 2;
        let [result, page] = ["report.h5", "report.html"].map(|name| self.scratch.path().join(name));
        let out = result.to_string_lossy();
        self.contact((&[], &["--out", &out]), &self.rough(n)?, USUAL, self.cores)?;
        let mut case = self.case(n, USUAL, self.cores);
        for _ in 0..self.args.repeats {
            self.go_on()?;
            let started = Instant::now();
            let output = Command::new(&self.program).arg("report").arg(&result).arg("--out").arg(&page).output();
            let seconds = started.elapsed().as_secs_f64();
            let output = output.map_err(failed)?;
            if !output.status.success() {
                return Err(failed(format!("report: {}", String::from_utf8_lossy(&output.stderr).trim())));
            }
            case.found.push(seconds);
            case.over.push(1.0);
        }
        Ok(vec![row("`report` of a result over a second", 0.25, Ok(vec![case]))])
    }

    /// Compares the solution by Tamaas with the time of the load in `contact`, to the same certified residual.
    pub(super) fn tamaas(&self) -> Result<Vec<Row>, Failure> {
        let what = "solution by Tamaas over `seconds` of `contact`";
        let cases = if self.args.tamaas { self.beside_tamaas()? } else { Err("not asked for by --tamaas".into()) };
        Ok(vec![Row { at_least: true, ..row(what, 20.0, cases) }])
    }

    /// Returns the cases with Tamaas, or the reason why it does not run here.
    fn beside_tamaas(&self) -> Result<Result<Vec<Case>, String>, Failure> {
        let (n, session) = (self.args.n, self.session);
        let peers = PeerArgs { p_star: LOADS.into(), ..PeerArgs::default() }.resolved();
        let environment = Environment::prepare(&peers, &work_folder()?, session)?;
        if !environment.has(Peer::Tamaas) {
            return Ok(Err("Tamaas is not installed".into()));
        }
        let place = Place { environment: &environment, session, limit: LONG };
        let tamaas = Contestant::Peer(Peer::Tamaas);
        let (name, out) = (tamaas.to_string(), tamaas.pressure_file(environment.scratch(), 1));
        let fields = BTreeMap::from([(name.clone(), out.clone())]);
        let failure = |ended: ProgramFailure| ended.failure("a solution by Tamaas");
        let mut cases = Vec::new();
        for hurst in HURST {
            for problem in problems(&peers, n, hurst, environment.scratch())? {
                let solve = |tolerance: f64| {
                    let solve = tamaas.solve(&problem, tolerance, 1, Some(&out), place)?.converged()?;
                    let verdicts = judge(&problem, &fields, &name, &environment, session)?;
                    Ok((verdicts.get(&name).map_or(f64::NAN, Verdict::worst), solve))
                };
                let found = loosest(MARGIN * TOLERANCE, TOLERANCE, solve).map_err(failure)?;
                let found = found.ok_or_else(|| failed("Tamaas does not reach the residual"))?;
                let p_star = problem.p_star;
                let rough = Rough {
                    heights: Array2::zeros([0, 0]),
                    rms_gradient: problem.mean_pressure / p_star,
                    file: problem.heights.clone(),
                };
                let mut case = self.case(n, p_star, 1);
                case.of = format!("{n}², H = {hurst}, p* = {p_star}");
                for _ in 0..self.args.repeats {
                    case.over.push(self.reported_time_at(p_star, &rough, (&[], &[]), 1)?);
                    case.found.push(solve(found.tolerance).map_err(failure)?.1.seconds);
                }
                cases.push(case);
            }
        }
        Ok(Ok(cases))
    }

    /// Compares a ramp, with each load started from the last one, with the same loads without a start.
    pub(super) fn ramp(&self) -> Result<Vec<Row>, Failure> {
        let n = self.args.n;
        let contact = posed(&self.rough(n)?.heights)?;
        let (first, last, count) = RAMP;
        let step = (last / first).powf(1.0 / (count - 1) as f64);
        let mut case = self.case(n, first, 1);
        case.of = format!("{n}², {count} loads, p* = {first} to {last}");
        let one = pool()?;
        for _ in 0..self.args.repeats {
            let (mut found, mut over, mut state) = (0.0, 0.0, None);
            for load in 0..count {
                self.go_on()?;
                let p_star = first * step.powi(load as i32);
                over += one.install(|| solved(&contact, p_star, None))?.0;
                let (seconds, solution) = one.install(|| solved(&contact, p_star, state.as_ref()))?;
                found += seconds;
                state = Some(solution);
            }
            case.found.push(found);
            case.over.push(over);
        }
        Ok(vec![row("ramp, each load from the last, over cold loads", 0.9, Ok(vec![case]))])
    }

    /// Compares the flow along x and y with the contact, and with both.
    pub(super) fn flow(&self) -> Result<Vec<Row>, Failure> {
        let n = self.args.large;
        let rough = self.rough(n)?;
        let [mut over_contact, mut over_both] = [self.case(n, USUAL, self.cores), self.case(n, USUAL, self.cores)];
        for _ in 0..self.args.repeats {
            let contact = self.reported(&rough, (&[], &[]), self.cores)?;
            let both = self.reported(&rough, (&[], &["--flow"]), self.cores)?;
            over_contact.found.push(both - contact);
            over_contact.over.push(contact);
            over_both.found.push(both - contact);
            over_both.over.push(both);
        }
        let share = row("flow, both directions, over contact with flow", None, Ok(vec![over_both]));
        Ok(vec![row("flow, both directions, over contact", 4.5, Ok(vec![over_contact])), share])
    }

    /// Compares many contacts from Python with their solutions alone, on all cores.
    pub(super) fn many(&self) -> Result<Vec<Row>, Failure> {
        let what = "contacts by `gfmd.many` over their solutions";
        let python = &self.args.python;
        let import = Command::new(python).args(["-c", "import gfmd"]).output();
        let is_there = import.is_ok_and(|output| output.status.success());
        if !is_there {
            return Ok(vec![row(what, 1.6, Err(format!("{} has no gfmd", python.display())))]);
        }
        let script = self.scratch.path().join(MANY.0);
        std::fs::write(&script, MANY.1).map_err(failed)?;
        let mut cases = Vec::new();
        for (n, part) in SMALL_SIDES {
            let count = self.args.many / part;
            let mut stack = Array3::zeros((count, n, n));
            for (seed, mut heights) in stack.axis_iter_mut(Axis(0)).enumerate() {
                heights.assign(&rough(n, self.args.hurst, 1 + seed as u64)?.0);
            }
            let file = self.scratch.path().join(format!("many-{n}.npy"));
            write_npy(&file, &stack).map_err(failed)?;
            let mut case = self.case(n, USUAL, self.cores);
            case.of = format!("{count} of {n}², p* = {USUAL}");
            for _ in 0..self.args.repeats {
                case.over.push(self.solutions(&stack)?);
                case.found.push(self.by_python(&script, &file)?);
            }
            cases.push(case);
        }
        Ok(vec![row(what, 1.6, Ok(cases))])
    }

    /// Returns the wall time of `gfmd.many`.
    fn by_python(&self, script: &Path, file: &Path) -> Result<f64, Failure> {
        self.go_on()?;
        let task = json!({ "heights": file, "p_star": USUAL }).to_string();
        let output = Command::new(&self.args.python).arg(script).arg(task).output().map_err(failed)?;
        if !output.status.success() {
            return Err(failed(format!("{}: {}", MANY.0, String::from_utf8_lossy(&output.stderr).trim())));
        }
        let printed: Value = serde_json::from_slice(&output.stdout).map_err(failed)?;
        printed["seconds"].as_f64().ok_or_else(|| failed(format!("{} printed no seconds", MANY.0)))
    }

    /// Returns the time of the solutions of a stack on one thread each, side by side: total time divided by the cores.
    fn solutions(&self, stack: &Array3<f64>) -> Result<f64, Failure> {
        let (next, total) = (AtomicUsize::new(0), Mutex::new(0.0));
        std::thread::scope(|scope| -> Result<(), Failure> {
            let work = || -> Result<(), Failure> {
                let one = pool()?;
                let mut seconds = 0.0;
                loop {
                    self.go_on()?;
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= stack.len_of(Axis(0)) {
                        break;
                    }
                    let contact = posed(&stack.index_axis(Axis(0), index).to_owned())?;
                    seconds += one.install(|| solved(&contact, USUAL, None))?.0;
                }
                *total.lock().map_err(failed)? += seconds;
                Ok(())
            };
            let workers: Vec<_> = (0..self.cores).map(|_| scope.spawn(work)).collect();
            workers.into_iter().try_for_each(|worker| worker.join().map_err(|_| failed("a worker ended early"))?)
        })?;
        Ok(total.into_inner().map_err(failed)? / self.cores as f64)
    }

    /// Measures the memory of a solution in units of a field, and predicts it for larger grids.
    pub(super) fn memory(&self) -> Result<Vec<Row>, Failure> {
        let [mut cases, mut processes] = [Vec::new(), Vec::new()];
        let field = |n: usize| (8 * n * n) as f64;
        for n in [self.args.large, 2 * self.args.large] {
            let rough = self.rough(n)?;
            for p_star in LOADS {
                let solve = self.alone(&rough, p_star, self.cores)?;
                let mut case = self.case(n, p_star, self.cores);
                case.over.push(field(n));
                case.found.push(solve.peak_bytes.saturating_sub(solve.baseline_bytes) as f64);
                cases.push(case);
            }
            let mut process = self.case(n, USUAL, self.cores);
            process.over.push(field(n));
            let (_, report) = self.contact((&[], &[]), &rough, USUAL, self.cores)?;
            process.found.extend(report["peak_bytes"].as_f64());
            processes.push(process);
        }
        let ahead = |of: String, fields: f64| {
            let found = vec![fields * field(HUGE)];
            Case { of, threads: self.cores, found, over: vec![field(HUGE)] }
        };
        let largest = cases.iter().skip(LOADS.len()).map(Case::ratio).fold(0.0, f64::max);
        let demanded = MemoryNeed::HARD_WALL_ONCE.bytes([HUGE; 2]) as f64 / field(HUGE);
        let predicted = vec![
            ahead(format!("{HUGE}², not run, by the fields at {}²", 2 * self.args.large), largest),
            ahead(format!("{HUGE}², not run, that the program asks for"), demanded),
        ];
        Ok(vec![
            row("memory of a solution over a field", 6.0, Ok(cases)),
            row("memory of the process `contact --surface` over a field", None, Ok(processes)),
            row("memory of a solution over a field, predicted", 6.5, Ok(predicted)),
        ])
    }

    /// Compares one thread with two, and one process with several processes of one thread each.
    pub(super) fn threads(&self) -> Result<Vec<Row>, Failure> {
        let n = self.args.large;
        let rough = self.rough(n)?;
        let mut threads = Vec::new();
        for p_star in [LOADS[1], LOADS[2]] {
            let mut case = self.case(n, p_star, 2);
            for _ in 0..self.args.repeats {
                case.found.push(self.alone(&rough, p_star, 1)?.seconds);
                case.over.push(self.alone(&rough, p_star, 2)?.seconds);
            }
            threads.push(case);
        }
        let threads = if self.cores < 2 { Err("the machine has one core".into()) } else { Ok(threads) };
        let ranks = self.ranks(&rough);
        let rows = [
            row("solution on one thread over that on two", 1.8, threads),
            row("`contact` in one process over several of one thread", 1.8, ranks),
        ];
        Ok(rows.map(|row| Row { at_least: true, ..row }).into())
    }

    /// Returns the case of several processes, or the reason why they do not run here.
    fn ranks(&self, rough: &Rough) -> Result<Vec<Case>, String> {
        if self.cores < RANKS {
            return Err(format!("{RANKS} processes need as many cores; the machine has {}", self.cores));
        }
        let count = RANKS.to_string();
        let starter: Vec<&str> = self.args.mpirun.split_whitespace().chain(["-n", &count]).collect();
        let mut case = self.case(rough.heights.nrows(), USUAL, 1);
        case.of = format!("{}, {RANKS} processes", case.of);
        for _ in 0..self.args.repeats {
            case.found.push(self.reported(rough, (&[], &[]), 1).map_err(|failure| failure.to_string())?);
            case.over.push(self.reported(rough, (&starter, &[]), 1).map_err(|failure| failure.to_string())?);
        }
        Ok(vec![case])
    }
}

/// Makes a pool of one thread.
fn pool() -> Result<rayon::ThreadPool, Failure> {
    ThreadPoolBuilder::new().num_threads(1).build().map_err(failed)
}

/// Makes the contact of heights in a cell of length 1 with a half-space of E* = 1.
fn posed(heights: &Array2<f64>) -> Result<Contact, Failure> {
    let (nx, ny) = heights.dim();
    let grid = Grid::new([nx, ny], [1.0, 1.0]).map_err(failed)?;
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).map_err(failed)?);
    Ok(Contact::new(&body, &grid, heights)?)
}

/// Returns a solution and its time.
fn solved(contact: &Contact, p_star: f64, start: Option<&Solution>) -> Result<(f64, Solution), Failure> {
    let load = Load::MeanPressure(p_star * contact.reduced_pressure_unit());
    let started = Instant::now();
    let solution = contact.press(load).starting_from(start).tolerance(TOLERANCE).solve().map_err(failed)?;
    Ok((started.elapsed().as_secs_f64(), solution))
}
