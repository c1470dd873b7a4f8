//! Comparison of creep tests with Tamaas's `MaxwellViscoelastic`, step by step.

use std::fmt;
use std::process::Command;
use std::time::Duration;

use gfmd_input::failure::Failure;
use gfmd_input::session::{Session, machine};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::contestant::Problem;
use super::process::output;
use super::python::{Environment, LONG, Script};
use super::table::{Table, in_words, median, write_beside};
use super::{Args, Peer, problems};

/// Relaxation times and fractions of the instantaneous modulus: one branch, and several.
const MATERIALS: [&[[f64; 2]]; 2] = [&[[1.0, 0.5]], &[[0.1, 0.3], [1.0, 0.3], [10.0, 0.2]]];
/// Length of a step, and number of steps.
const STEP: f64 = 0.1;
const STEPS: usize = 20;

/// Result of `bench-peers --creep`.
#[derive(Clone, Debug, Serialize)]
pub struct Creep {
    /// Date of the run.
    pub date: String,
    /// Processor, cores, operating system.
    pub machine: String,
    /// Commit of this program.
    pub commit: String,
    /// Version of Tamaas.
    pub tamaas: String,
    /// Tolerance of both solvers.
    pub tolerance: f64,
    /// One row per test.
    pub rows: Vec<Row>,
    /// Notes for readers of the results.
    pub notes: Vec<String>,
}

/// Result of one creep test.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Points along a side.
    pub n: usize,
    /// Number of branches.
    pub branches: usize,
    /// Reduced pressure.
    pub p_star: f64,
    /// Number of threads.
    pub threads: usize,
    /// Wall times of all steps, for this program and Tamaas: medians of the repeats.
    pub seconds: [f64; 2],
    /// Contact areas after the last step, for this program and Tamaas.
    pub area: [f64; 2],
    /// Transform pairs of this program.
    pub transform_pairs: f64,
    /// Pressure of a wave in full contact after the last step of Tamaas, relative to the long-term modulus.
    pub held: f64,
    /// The same ratio by backward Euler, the scheme named by Tamaas.
    pub euler: f64,
}

#[derive(Deserialize)]
struct Own {
    steps: Vec<OwnStep>,
}

#[derive(Deserialize)]
struct OwnStep {
    seconds: f64,
    area_fraction: f64,
    transform_pairs: f64,
    converged: bool,
}

#[derive(Deserialize)]
struct Theirs {
    seconds: Vec<f64>,
    areas: Vec<f64>,
    held: Vec<f64>,
}

/// Runs the comparison and writes the page if requested.
///
/// # Errors
/// Tamaas is not installed; a failed run of a program; a file that cannot be written.
pub(super) fn run(args: &Args, environment: &Environment, session: &Session) -> Result<Creep, Failure> {
    if !environment.has(Peer::Tamaas) {
        return Err(Failure::refused("--creep needs Tamaas, which is not installed"));
    }
    let mut creep = Creep {
        date: jiff::Zoned::now().date().to_string(),
        machine: machine(),
        commit: gfmd_input::session::GIT_COMMIT.into(),
        tamaas: environment.versions().remove(Peer::Tamaas.package()).unwrap_or_default(),
        tolerance: args.tolerance,
        rows: Vec::new(),
        notes: environment.notes.clone(),
    };
    for &points in &args.sizes {
        for problem in problems(args, points, args.hurst[0], environment.scratch())? {
            for branches in MATERIALS {
                for &threads in &args.thread_counts {
                    let row = Trial { args, environment, session, problem: &problem, branches, threads }.row()?;
                    tracing::info!(
                        "{points} points, {} branches, {threads} threads: {:?} s",
                        branches.len(),
                        row.seconds
                    );
                    creep.rows.push(row);
                }
            }
        }
    }
    if let Some(file) = args.page() {
        write_beside(file, &creep.page())?;
    }
    Ok(creep)
}

/// One creep test, for both programs.
struct Trial<'a> {
    args: &'a Args,
    environment: &'a Environment,
    session: &'a Session,
    problem: &'a Problem,
    branches: &'a [[f64; 2]],
    threads: usize,
}

impl Trial<'_> {
    fn row(&self) -> Result<Row, Failure> {
        let Self { args, problem, branches, threads, .. } = self;
        let (mut own, mut theirs) = (Vec::new(), Vec::new());
        let mut last = None;
        for _ in 0..args.repeats {
            let (ours, tamaas) = (self.own()?, self.theirs()?);
            own.push(ours.steps.iter().map(|step| step.seconds).sum());
            theirs.push(tamaas.seconds.iter().sum());
            last = Some((ours, tamaas));
        }
        let (ours, tamaas) = last.ok_or_else(|| Failure::refused("--repeats is 0; it must be at least 1"))?;
        let end = ours.steps.last().map_or(f64::NAN, |step| step.area_fraction);
        let spread = |[time, weight]: [f64; 2]| weight / (1.0 + STEP / time).powi(STEPS as i32);
        Ok(Row {
            n: problem.points,
            branches: branches.len(),
            p_star: problem.p_star,
            threads: *threads,
            seconds: [median(&own), median(&theirs)],
            area: [end, tamaas.areas.last().copied().unwrap_or(f64::NAN)],
            transform_pairs: ours.steps.iter().map(|step| step.transform_pairs).sum(),
            held: tamaas.held.last().copied().unwrap_or(f64::NAN),
            euler: 1.0 + self.weights().into_iter().map(spread).sum::<f64>(),
        })
    }

    /// Returns the moduli of the branches divided by the long-term modulus, with their times.
    fn weights(&self) -> Vec<[f64; 2]> {
        let left = 1.0 - self.branches.iter().map(|branch| branch[1]).sum::<f64>();
        self.branches.iter().map(|[time, fraction]| [*time, fraction / left]).collect()
    }

    fn own(&self) -> Result<Own, Failure> {
        let program = std::env::current_exe().map_err(|error| Failure::computation(error.to_string()))?;
        let branches: Vec<String> = self.branches.iter().map(|[time, fraction]| format!("{time}:{fraction}")).collect();
        let mut command = Command::new(program);
        command.args([
            "path",
            "--json",
            "--quiet",
            "--grid-error",
            "none",
            "--steps",
            "1",
            "--poisson",
            "0",
            "--surface",
        ]);
        command.arg(&self.problem.heights).args(["--prony", &branches.join(",")]);
        command.args(["--time", &vec![STEP.to_string(); STEPS].join(",")]);
        command.arg("--pressure").arg(format!("{:?}", self.problem.mean_pressure));
        command
            .arg("--tolerance")
            .arg(format!("{:e}", self.args.tolerance))
            .arg("--threads")
            .arg(self.threads.to_string());
        let printed =
            output(&mut command, LONG, self.session).map_err(|ended| ended.failure("a creep test of gfmd"))?;
        let own: Own = serde_json::from_str(&printed)
            .map_err(|error| Failure::computation(format!("the output of a creep test has {error}")))?;
        match own.steps.iter().position(|step| !step.converged) {
            Some(step) => Err(Failure::computation(format!("step {step} of a creep test did not converge"))),
            None => Ok(own),
        }
    }

    fn theirs(&self) -> Result<Theirs, Failure> {
        let task = json!({
            "heights": self.problem.heights,
            "mean_pressure": self.problem.mean_pressure,
            "tolerance": self.args.tolerance,
            "threads": self.threads,
            "step": STEP,
            "steps": STEPS,
            "branches": self.weights(),
            "fftw": self.environment.preloaded(),
            "out": self.environment.scratch().join("creep.npy"),
        });
        let limit = Duration::from_secs_f64(self.args.patience());
        let ran = self.environment.run_within(Script::Creep, &task, limit, self.session);
        ran.map_err(|ended| ended.failure("a creep test of Tamaas"))
    }
}

impl Creep {
    fn table(&self) -> Table {
        let head = [
            "n",
            "p*",
            "branches",
            "threads",
            "gfmd, s",
            "Tamaas, s",
            "ratio",
            "pairs of gfmd",
            "area, gfmd",
            "area, Tamaas",
            "held, Tamaas",
            "held, Euler",
        ];
        let row = |row: &Row| {
            let [own, theirs] = row.seconds;
            vec![
                row.n.to_string(),
                row.p_star.to_string(),
                row.branches.to_string(),
                row.threads.to_string(),
                format!("{own:.3}"),
                format!("{theirs:.3}"),
                format!("{:.1}", theirs / own),
                format!("{:.0}", row.transform_pairs),
                format!("{:.5}", row.area[0]),
                format!("{:.5}", row.area[1]),
                format!("{:.4}", row.held),
                format!("{:.4}", row.euler),
            ]
        };
        let title = format!("Creep in {STEPS} steps of {STEP}");
        Table { title, head: head.map(str::to_owned).into(), rows: self.rows.iter().map(row).collect() }
    }

    fn page(&self) -> String {
        let Self { date, machine, commit, tamaas, tolerance, .. } = self;
        let short = commit.get(..12).unwrap_or(commit);
        let mut page = format!(
            "<!-- Written by `cargo xtask bench-peers --creep --write-docs`; change xtask/src/bench_peers/creep.rs. \
             -->\n\
             # Creep beside Tamaas\n\n\
             Creep test of gfmd (`path --prony`) and of Tamaas's `MaxwellViscoelastic`: same surface, load, branches \
             and steps,\ntolerance {tolerance:e}.\n\n\
             {date}. {machine}. Commit {short}. Tamaas {tamaas}.\n\n\
             Half-space, self-affine surfaces with rms gradient 0.1; one branch with half of the instantaneous modulus \
             and\n\
             the relaxation time 1, or three with 30, 30 and 20 % and the times 0.1, 1 and 10.\n\n"
        );
        for note in &self.notes {
            page += &format!("> {note}\n\n");
        }
        page += &self.table().markdown();
        page += "\n`held` checks the steps alone: pressure after the last step of a wave in full contact, whose \
                 displacement is held,\ndivided by its value with the long-term modulus. The last column is backward \
                 Euler, the scheme of Tamaas. Where Tamaas\ndiffers, its contact areas are wrong for the material. The \
                 steps of gfmd are exact for a displacement linear in time\n([time](time.md)).\n";
        page
    }
}

impl fmt::Display for Creep {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let threads = self.rows.first().map_or(1, |row| row.threads);
        writeln!(
            f,
            "{}; Tamaas {}; first rows on {}\n\n{}",
            self.machine,
            self.tamaas,
            in_words(threads),
            self.table()
        )?;
        self.notes.iter().try_for_each(|note| writeln!(f, "note: {note}"))
    }
}
