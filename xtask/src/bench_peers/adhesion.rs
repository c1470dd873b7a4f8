//! Comparison with Tamaas under loads with an exponential adhesion, load by load.

use std::fmt;
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use gfmd_input::failure::Failure;
use gfmd_input::session::{GIT_COMMIT, Session, machine};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::contestant::Problem;
use super::process::{ProgramFailure, output};
use super::python::{Environment, LONG, Script};
use super::table::{Table, areas_differ, fill};
use super::{Args, Peer, RMS_GRADIENT, problems};

/// Name of the table in docs/benchmarks.md.
pub(super) const PLACE: &str = "adhesion";

/// Loads as reduced pressures; each starts from the previous one.
const LOADS: [f64; 9] = [0.002, 0.004, 0.006, 0.008, 0.01, 0.0075, 0.005, 0.0025, 0.0];
/// Largest attraction divided by E* times the rms gradient.
const STRENGTH: f64 = 0.2;
/// Slope of the law as a fraction of the stiffness of the shortest wave of a grid, π n/2 in units of E* and the cell.
const SLOPE: f64 = 0.3;
/// Tolerances of Tamaas divided by the residual bound, tried in turn until the residual is within the bound.
const TOLERANCES: [f64; 4] = [1e3, 1e2, 10.0, 3.0];
/// Largest number of iterations of Tamaas for a load.
const MAX_PEER_ITERATIONS: u64 = 100_000;

/// Result of `bench-peers --adhesion`.
#[derive(Clone, Debug, Serialize)]
pub struct Adhesion {
    /// Date of the run.
    pub date: String,
    /// Processor, cores, operating system.
    pub machine: String,
    /// Commit of this program.
    pub commit: String,
    /// Version of Tamaas.
    pub tamaas: String,
    /// Bound on the residuals.
    pub tolerance: f64,
    /// Time limit of Tamaas for all loads, s.
    pub patience: f64,
    /// One row per surface.
    pub rows: Vec<Row>,
}

/// Loads on one surface.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// Points along a side.
    pub n: usize,
    /// Hurst exponent.
    pub hurst: f64,
    /// Number of threads.
    pub threads: usize,
    /// Course by this program.
    pub own: Course,
    /// Course by Tamaas, to the smallest of its tolerances that it reached in time.
    pub theirs: Option<Course>,
    /// Reason why there is no smaller residual.
    pub said: Option<String>,
}

/// Loads solved by one program.
#[derive(Clone, Debug, Serialize)]
pub struct Course {
    /// Wall time of all loads, s.
    pub seconds: f64,
    /// Largest residual of all loads.
    pub residual: f64,
    /// Contact area of each load.
    pub areas: Vec<f64>,
}

#[derive(Deserialize)]
struct Theirs {
    loads: Vec<TheirLoad>,
}

#[derive(Deserialize)]
struct TheirLoad {
    seconds: f64,
    residual: Option<f64>,
    area: Option<f64>,
}

/// Runs the comparison and writes the table into its page if requested.
///
/// # Errors
/// Tamaas is not installed; a failed run of this program; a file that cannot be written.
pub(super) fn run(args: &Args, environment: &Environment, session: &Session) -> Result<Adhesion, Failure> {
    if !environment.has(Peer::Tamaas) {
        return Err(Failure::refused("--adhesion needs Tamaas, which is not installed"));
    }
    let mut made = Adhesion {
        date: jiff::Zoned::now().date().to_string(),
        machine: machine(),
        commit: GIT_COMMIT.into(),
        tamaas: environment.versions().remove(Peer::Tamaas.package()).unwrap_or_default(),
        tolerance: args.tolerance,
        patience: args.patience(),
        rows: Vec::new(),
    };
    for &points in &args.sizes {
        for &hurst in &args.hurst {
            let problems = problems(args, points, hurst, environment.scratch())?;
            for (problem, &threads) in problems.iter().take(1).zip(&args.thread_counts) {
                let row = Trial { args, environment, session, problem, threads }.row()?;
                tracing::info!("{points} points, H = {hurst}: {row:?}");
                made.rows.push(row);
            }
        }
    }
    if let Some(page) = args.page() {
        made.write(page)?;
    }
    Ok(made)
}

/// Loads on one surface, for both programs.
struct Trial<'a> {
    args: &'a Args,
    environment: &'a Environment,
    session: &'a Session,
    problem: &'a Problem,
    threads: usize,
}

impl Trial<'_> {
    /// Returns work of adhesion and range.
    fn law(&self) -> [f64; 2] {
        let attraction = STRENGTH * RMS_GRADIENT;
        let range = attraction / (SLOPE * std::f64::consts::FRAC_PI_2 * self.problem.points as f64);
        [attraction * range, range]
    }

    fn pressures(&self) -> [f64; 9] {
        LOADS.map(|p_star| p_star / self.problem.p_star * self.problem.mean_pressure)
    }

    fn row(&self) -> Result<Row, Failure> {
        let own = self.own()?;
        let (mut theirs, mut said) = (None, None);
        for over in TOLERANCES {
            let course = match self.theirs(over * self.args.tolerance) {
                Ok(course) => course,
                Err(ProgramFailure::Interrupted) => {
                    return Err(ProgramFailure::Interrupted.failure("adhesion by Tamaas"));
                }
                Err(ended) => {
                    said = Some(ended.in_words());
                    break;
                }
            };
            let is_enough = course.residual <= self.args.tolerance;
            theirs = Some(course);
            if is_enough {
                break;
            }
        }
        let Problem { points: n, hurst, .. } = *self.problem;
        Ok(Row { n, hurst, threads: self.threads, own, theirs, said })
    }

    fn own(&self) -> Result<Course, Failure> {
        let program = std::env::current_exe().map_err(|error| Failure::computation(error.to_string()))?;
        let [work, range] = self.law();
        let mut command = Command::new(program);
        command.args(["contact", "--json", "--quiet", "--grid-error", "none", "--surface"]).arg(&self.problem.heights);
        command.args(["--law", "exponential", "--param", &format!("gamma={work:?}"), "--param"]);
        command.arg(format!("range={range:?}")).arg("--pressure");
        command.arg(self.pressures().map(|p| format!("{p:?}")).join(","));
        command
            .arg("--tolerance")
            .arg(format!("{:e}", self.args.tolerance))
            .arg("--threads")
            .arg(self.threads.to_string());
        let printed = output(&mut command, LONG, self.session).map_err(|ended| ended.failure("adhesion by gfmd"))?;
        let report: Value = serde_json::from_str(&printed).map_err(|error| Failure::computation(error.to_string()))?;
        let loads = crate::solved::loads(&report);
        let residuals = loads.iter().flat_map(|load| load["residual"].as_object()).flat_map(|all| all.values());
        Ok(Course {
            seconds: loads.iter().filter_map(|load| load["seconds"].as_f64()).sum(),
            residual: gfmd_relax::worst(residuals.map(|value| value.as_f64().unwrap_or(f64::NAN))),
            areas: loads.iter().filter_map(|load| load["area_fraction"].as_f64()).collect(),
        })
    }

    fn theirs(&self, tolerance: f64) -> Result<Course, ProgramFailure> {
        let [work, range] = self.law();
        let task = json!({
            "heights": self.problem.heights,
            "pressures": self.pressures(),
            "tolerance": tolerance,
            "threads": self.threads,
            "gamma": work,
            "range": range,
            "most": MAX_PEER_ITERATIONS,
            "fftw": self.environment.preloaded(),
        });
        let limit = Duration::from_secs_f64(self.args.patience());
        let Theirs { loads } = self.environment.run_within(Script::Adhesion, &task, limit, self.session)?;
        Ok(Course {
            seconds: loads.iter().map(|load| load.seconds).sum(),
            residual: gfmd_relax::worst(loads.iter().map(|load| load.residual.unwrap_or(f64::NAN))),
            areas: loads.iter().filter_map(|load| load.area).collect(),
        })
    }
}

impl Row {
    /// Returns the largest difference of the contact areas; NaN if a load has none.
    fn differs(&self) -> f64 {
        areas_differ(&self.own.areas, self.theirs.as_ref().map(|theirs| &theirs.areas[..]))
    }
}

impl Adhesion {
    fn table(&self) -> Table {
        let head = [
            "n",
            "H",
            "threads",
            "gfmd, s",
            "residual",
            "Tamaas, s",
            "residual",
            "ratio",
            "areas differ",
            "Tamaas to the bound",
        ];
        let row = |row: &Row| {
            let Row { n, hurst, threads, own, theirs, said } = row;
            let of = |tell: &dyn Fn(&Course) -> String| theirs.as_ref().map_or_else(|| "-".into(), tell);
            let certified = theirs.as_ref().is_some_and(|theirs| theirs.residual <= self.tolerance);
            vec![
                n.to_string(),
                hurst.to_string(),
                threads.to_string(),
                format!("{:.3}", own.seconds),
                format!("{:.0e}", own.residual),
                of(&|theirs| format!("{:.3}", theirs.seconds)),
                of(&|theirs| format!("{:.0e}", theirs.residual)),
                of(&|theirs| format!("{:.1}", theirs.seconds / own.seconds)),
                of(&|_| format!("{:.0e}", row.differs())),
                if certified { "yes".into() } else { said.clone().unwrap_or_else(|| "no".into()) },
            ]
        };
        let rows = self.rows.iter().map(row).collect();
        Table { title: "Adhesion beside Tamaas".into(), head: head.map(str::to_owned).into(), rows }
    }

    fn write(&self, page: &Path) -> Result<(), Failure> {
        let Self { date, machine, commit, tamaas, tolerance, patience, .. } = self;
        let short = commit.get(..12).unwrap_or(commit);
        let table = format!(
            "{}\n{date}. {machine}. Commit {short}. Tamaas {tamaas} (`PolonskyKeerRey` on the gap, \
             `ExponentialAdhesionFunctional`).\n\
             Nine loads, p\\* 0.002 to 0.01 and back to 0, each from the last, with γ/ϱ = {STRENGTH} E\\* g and the \
             shortest range that\n\
             the grid resolves. The tolerance of Tamaas falls until its final pressures have residuals, recomputed as \
             for gfmd, of at\nmost {tolerance:e}, or until all loads take longer than {patience} s: the ratio then \
             refers to a less exact result.\nTamaas has no path with friction to compare.\n\
             `cargo xtask bench-peers --adhesion --write-docs`.\n\n",
            self.table().markdown()
        );
        fill(page, PLACE, &table)
    }
}

impl fmt::Display for Adhesion {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{}; Tamaas {}\n\n{}", self.machine, self.tamaas, self.table())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made() -> Adhesion {
        let course = |seconds, residual, last| Course { seconds, residual, areas: vec![0.1, last] };
        let row = Row {
            n: 128,
            hurst: 0.8,
            threads: 1,
            own: course(0.1, 1e-12, 0.2),
            theirs: Some(course(12.0, 2e-8, 0.25)),
            said: Some("it takes longer than 60 s".into()),
        };
        let late = Row { theirs: None, ..row.clone() };
        Adhesion {
            date: "2026-01-02".into(),
            machine: "a processor".into(),
            commit: "0123456789abcdef".into(),
            tamaas: "2.9.0".into(),
            tolerance: 1e-8,
            patience: 60.0,
            rows: vec![row, late],
        }
    }

    #[test]
    fn a_residual_above_the_bound_is_told() {
        let made = made();
        let cells = made.table().rows;
        assert_eq!(cells[0][3..], ["0.100", "1e-12", "12.000", "2e-8", "120.0", "5e-2", "it takes longer than 60 s"]);
        assert_eq!(cells[1][5..], ["-", "-", "-", "-", "it takes longer than 60 s"]);
        let certified = Adhesion { tolerance: 1e-7, ..made.clone() };
        assert_eq!(certified.table().rows[0][9], "yes");
        let [mut broken, lost] = [made.rows[0].clone(), made.rows[1].clone()];
        broken.own.areas.pop();
        assert!(broken.differs().is_nan() && lost.differs().is_nan());
    }

    #[test]
    fn the_table_has_its_place_beside_others() {
        let folder = tempfile::tempdir().unwrap();
        let page = folder.path().join("page.md");
        let places = [super::super::rows::PLACE, PLACE].map(|place| super::super::rows::section(&page, place));
        std::fs::write(&page, format!("{}## Method\n", places.concat())).unwrap();
        made().write(&page).unwrap();
        let text = std::fs::read_to_string(&page).unwrap();
        assert!(text.starts_with(&places[0]), "{text}");
        assert!(text.ends_with("## Method\n"), "{text}");
        assert!(text.contains("| 120.0 |"), "{text}");
    }
}
