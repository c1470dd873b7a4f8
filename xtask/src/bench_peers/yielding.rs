//! Comparison with Tamaas of a sphere pressed on a body that yields, step by step.

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use gfmd_input::failure::Failure;
use gfmd_input::session::{GIT_COMMIT, Session, machine};
use ndarray::Array2;
use ndarray_npy::write_npy;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::process::ProgramFailure;
use super::python::{Environment, LONG, Script};
use super::table::{Table, areas_differ, fill};
use super::{Args, Peer};

/// Name of the table in docs/benchmarks.md.
pub(super) const PLACE: &str = "yielding";

/// Mean pressures divided by E, the last two on the way back.
const LOADS: [f64; 6] = [1.12e-3, 2.24e-3, 3.92e-3, 5.6e-3, 2.8e-3, 5.6e-6];
/// Largest number of points along a side for which all loads are followed, and number of loads beyond.
const ALL_LOADS: usize = 32;
const FEW_LOADS: usize = 2;
/// Radius of the sphere, yield stress and hardening, in units of the cell and of E.
const RADIUS: f64 = 2.0;
const YIELD_STRESS: f64 = 0.02;
const HARDENING: f64 = 0.02;
/// Largest number of cells of one grid step.
const MOST_CELLS: usize = 32;

/// Result of `bench-peers --yielding`.
#[derive(Clone, Debug, Serialize)]
pub struct Yielding {
    /// Date of the run.
    pub date: String,
    /// Processor, cores, operating system.
    pub machine: String,
    /// Commit of this program.
    pub commit: String,
    /// Version of Tamaas.
    pub tamaas: String,
    /// Tolerance of both programs.
    pub tolerance: f64,
    /// Time limit of Tamaas for all loads, s.
    pub patience: f64,
    /// One row per size.
    pub rows: Vec<Row>,
}

/// Loads on one grid.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Points along a side.
    pub n: usize,
    /// Cells of one grid step below the surface; nodes of Tamaas are one more.
    pub cells: usize,
    /// Number of loads.
    pub loads: usize,
    /// Course by this program.
    pub own: Course,
    /// Course by this program with its default cells.
    pub graded: Course,
    /// Course by Tamaas.
    pub theirs: Option<Course>,
    /// Reason why there is none.
    pub said: Option<String>,
}

/// Loads followed by one program, on one thread.
#[derive(Clone, Debug, Serialize)]
pub struct Course {
    /// Processor time, s.
    pub cpu: f64,
    /// Largest resident memory, bytes: of the process for this program, less what Python takes for Tamaas.
    pub peak: f64,
    /// Changes from plastic strain and pressure to strain.
    pub operators: u64,
    /// Contact area of each load.
    pub areas: Vec<f64>,
}

#[derive(Deserialize)]
struct Measured {
    cpu: f64,
    printed: String,
}

#[derive(Deserialize)]
struct Theirs {
    cpu: f64,
    peak: f64,
    steps: Vec<TheirStep>,
}

#[derive(Deserialize)]
struct TheirStep {
    evaluations: u64,
    area: f64,
}

/// Runs the comparison and writes the table into its page if requested.
///
/// # Errors
/// Tamaas is not installed; a failed run of this program; a file that cannot be written.
pub(super) fn run(args: &Args, environment: &Environment, session: &Session) -> Result<Yielding, Failure> {
    if !environment.has(Peer::Tamaas) {
        return Err(Failure::refused("--yielding needs Tamaas, which is not installed"));
    }
    let mut made = Yielding {
        date: jiff::Zoned::now().date().to_string(),
        machine: machine(),
        commit: GIT_COMMIT.into(),
        tamaas: environment.versions().remove(Peer::Tamaas.package()).unwrap_or_default(),
        tolerance: args.tolerance,
        patience: args.patience(),
        rows: Vec::new(),
    };
    for &n in &args.sizes {
        let row = Trial { args, environment, session, n, heights: sphere(n, environment.scratch())? }.row()?;
        tracing::info!("{n} points: {row:?}");
        made.rows.push(row);
    }
    if let Some(page) = args.page() {
        made.write(page)?;
    }
    Ok(made)
}

/// Writes the heights of the sphere, a paraboloid, and returns the file.
fn sphere(n: usize, folder: &Path) -> Result<PathBuf, Failure> {
    let distance = |i: usize| i.min(n - i) as f64 / n as f64;
    let heights = Array2::from_shape_fn((n, n), |(i, j)| -(distance(i).powi(2) + distance(j).powi(2)) / (2.0 * RADIUS));
    let file = folder.join(format!("sphere-{n}.npy"));
    write_npy(&file, &heights).map_err(|error| Failure::computation(format!("{}: {error}", file.display())))?;
    Ok(file)
}

/// Loads on one grid, for both programs.
struct Trial<'a> {
    args: &'a Args,
    environment: &'a Environment,
    session: &'a Session,
    n: usize,
    heights: PathBuf,
}

impl Trial<'_> {
    fn cells(&self) -> usize {
        (self.n / 2).min(MOST_CELLS)
    }

    fn depth(&self) -> f64 {
        self.cells() as f64 / self.n as f64
    }

    fn loads(&self) -> &'static [f64] {
        if self.n <= ALL_LOADS { &LOADS } else { &LOADS[..FEW_LOADS] }
    }

    fn row(&self) -> Result<Row, Failure> {
        let uniform = format!("uniform:{},{:?}", self.cells(), self.depth());
        let [own, graded] = [Some(&uniform[..]), None].map(|cells| self.own(cells));
        let (theirs, said) = match self.theirs() {
            Ok(course) => (Some(course), None),
            Err(ProgramFailure::Interrupted) => {
                return Err(ProgramFailure::Interrupted.failure("yielding by Tamaas"));
            }
            Err(ended) => (None, Some(ended.in_words())),
        };
        let (n, cells, loads) = (self.n, self.cells(), self.loads().len());
        Ok(Row { n, cells, loads, own: own?, graded: graded?, theirs, said })
    }

    fn own(&self, cells: Option<&str>) -> Result<Course, Failure> {
        let program = std::env::current_exe().map_err(|error| Failure::computation(error.to_string()))?;
        let list = self.loads().iter().map(|p| format!("{p:?}")).collect::<Vec<_>>().join(",");
        let [program, heights] = [&program, &self.heights].map(|path| path.to_string_lossy().into_owned());
        let (yield_stress, hardening) = (YIELD_STRESS.to_string(), HARDENING.to_string());
        let tolerance = format!("{:e}", self.args.tolerance);
        let mut line = vec![&program[..], "path", "--surface", &heights, "--poisson", "0.3", "--young", "1"];
        line.extend(["--yield-stress", &yield_stress, "--hardening", &hardening, "--pressure", &list]);
        line.extend(["--steps", "1", "--grid-error", "none", "--threads", "1", "--tolerance", &tolerance]);
        line.extend(["--json", "--quiet"]);
        line.extend(cells.iter().flat_map(|cells| ["--cells", cells]));
        let run = self.environment.run(Script::Yielding, &json!({ "program": line }), self.session);
        let Measured { cpu, printed } = run.map_err(|ended| ended.failure("yielding by gfmd"))?;
        let report: Value = serde_json::from_str(&printed).map_err(|error| Failure::computation(error.to_string()))?;
        let steps = report["steps"].as_array().map_or(&[][..], Vec::as_slice);
        Ok(Course {
            cpu,
            peak: report["peak_bytes"].as_f64().unwrap_or(f64::NAN),
            operators: steps.iter().filter_map(|step| step["operators"].as_u64()).sum(),
            areas: steps.iter().filter_map(|step| step["area_fraction"].as_f64()).collect(),
        })
    }

    fn theirs(&self) -> Result<Course, ProgramFailure> {
        let task = json!({
            "heights": self.heights,
            "pressures": self.loads(),
            "tolerance": self.args.tolerance,
            "depth": self.depth(),
            "nodes": self.cells() + 1,
            "yield": YIELD_STRESS,
            "hardening": HARDENING,
            "threads": 1,
        });
        let limit = Duration::from_secs_f64(self.args.patience()).min(LONG);
        let Theirs { cpu, peak, steps } = self.environment.run_within(Script::Yielding, &task, limit, self.session)?;
        Ok(Course {
            cpu,
            peak,
            operators: steps.iter().map(|step| step.evaluations).sum(),
            areas: steps.iter().map(|step| step.area).collect(),
        })
    }
}

impl Row {
    /// Returns the largest difference of the contact areas; NaN if a load has none.
    fn differs(&self) -> f64 {
        areas_differ(&self.own.areas, self.theirs.as_ref().map(|theirs| &theirs.areas[..]))
    }
}

impl Yielding {
    fn table(&self) -> Table {
        let head = [
            "n",
            "loads",
            "program",
            "cells or nodes",
            "CPU, s",
            "operators",
            "memory, MB",
            "CPU of Tamaas divided by it",
            "areas differ",
        ];
        let mut rows = Vec::new();
        for row in &self.rows {
            let line = |program: &str, cells: String, course: &Course| {
                let ratio = row.theirs.as_ref().map_or_else(|| "-".into(), |t| format!("{:.0}", t.cpu / course.cpu));
                vec![
                    row.n.to_string(),
                    row.loads.to_string(),
                    program.to_owned(),
                    cells,
                    format!("{:.2}", course.cpu),
                    course.operators.to_string(),
                    format!("{:.0}", course.peak / 1e6),
                    ratio,
                ]
            };
            let cells = format!("{} uniform", row.cells);
            let mut all = vec![line("gfmd", cells, &row.own), line("gfmd", "default".into(), &row.graded)];
            all[0].push(row.theirs.as_ref().map_or_else(|| "-".into(), |_| format!("{:.0e}", row.differs())));
            all[1].push("-".into());
            if let Some(theirs) = &row.theirs {
                let mut last = line("Tamaas", format!("{} nodes", row.cells + 1), theirs);
                last.push("-".into());
                all.push(last);
            }
            rows.extend(all);
        }
        Table { title: "A body that yields beside Tamaas".into(), head: head.map(str::to_owned).into(), rows }
    }

    fn write(&self, page: &Path) -> Result<(), Failure> {
        let Self { date, machine, commit, tamaas, tolerance, patience, .. } = self;
        let short = commit.get(..12).unwrap_or(commit);
        let late: Vec<String> = self
            .rows
            .iter()
            .filter_map(|row| Some(format!("Tamaas at {} points: {}.\n", row.n, row.said.as_ref()?)))
            .collect();
        let table = format!(
            "{}\n{date}. {machine}. Commit {short}. Tamaas {tamaas} (`EPICSolver.acceleratedSolve`, \
             `DFSANESolver`, its own FFTW), one thread.\n\
             A sphere of radius {RADIUS} cells on E = 1, ν = 0.3, Y = {YIELD_STRESS}, H = {HARDENING}; mean pressures \
             {LOADS:?},\nthe last two in unloading; beyond {ALL_LOADS} points the first {FEW_LOADS} only (limit of \
             Tamaas {patience} s). Tolerance {tolerance:e} in both programs.\nOperators map plastic strain and \
             pressure to strain. CPU of gfmd: the whole process; of Tamaas: the calls of its solver,\nmemory less \
             what Python took before.\n{}\
             `cargo xtask bench-peers --yielding --write-docs`.\n\n",
            self.table().markdown(),
            late.concat()
        );
        fill(page, PLACE, &table)
    }
}

impl fmt::Display for Yielding {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{}; Tamaas {}\n\n{}", self.machine, self.tamaas, self.table())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_tell_ratios_and_what_is_missing() {
        let course = |cpu, areas: &[f64]| Course { cpu, peak: 2e7, operators: 90, areas: areas.to_vec() };
        let row = Row {
            n: 64,
            cells: 32,
            loads: 2,
            own: course(2.0, &[0.1, 0.2]),
            graded: course(1.0, &[0.1, 0.2]),
            theirs: Some(course(100.0, &[0.1, 0.25])),
            said: None,
        };
        let late = Row { theirs: None, said: Some("it takes longer than 60 s".into()), ..row.clone() };
        let broken = Row { own: course(2.0, &[0.1]), ..row.clone() };
        assert!(broken.differs().is_nan() && late.differs().is_nan());
        let made = Yielding {
            date: "2026-01-02".into(),
            machine: "a processor".into(),
            commit: "0123456789abcdef".into(),
            tamaas: "2.9.0".into(),
            tolerance: 1e-8,
            patience: 60.0,
            rows: vec![row, late],
        };
        let cells = made.table().rows;
        assert_eq!(cells.len(), 5);
        assert_eq!(cells[0][2..], ["gfmd", "32 uniform", "2.00", "90", "20", "50", "5e-2"]);
        assert_eq!(cells[2][2..], ["Tamaas", "33 nodes", "100.00", "90", "20", "1", "-"]);
        assert_eq!(cells[3][7..], ["-", "-"]);
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("page.md");
        let place = super::super::rows::section(&page, PLACE);
        std::fs::write(&page, format!("{place}## Method\n")).unwrap();
        made.write(&page).unwrap();
        let text = std::fs::read_to_string(&page).unwrap();
        assert!(text.contains("Tamaas at 64 points: it takes longer than 60 s."), "{text}");
        assert!(text.ends_with("## Method\n"), "{text}");
    }

    #[test]
    fn the_sphere_touches_in_its_corner() {
        let folder = tempfile::tempdir().unwrap();
        let heights: Array2<f64> = ndarray_npy::read_npy(sphere(8, folder.path()).unwrap()).unwrap();
        assert_eq!((heights[[0, 0]], heights[[4, 4]]), (0.0, -0.125));
        assert_eq!(heights[[7, 0]], -1.0 / 256.0);
    }
}
