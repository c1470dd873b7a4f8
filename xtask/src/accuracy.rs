//! `accuracy`: compares estimated grid errors with closed forms and with solutions of new surfaces on grids 8 times
//! finer.

mod case;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args as ClapArgs;
use gfmd_cli::progress::Progress;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_record::{COLUMNS, Column};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::solved::{self, number};
use case::{Case, CaseKind, FINER};

/// Flags of `accuracy`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  cargo xtask accuracy --seeds 12 --out accuracy.json
  cargo xtask results")]
pub struct Args {
    /// Number of surfaces
    #[arg(long, default_value_t = 200, value_name = "N")]
    seeds: u64,
    /// Number of rough spheres with free boundaries
    #[arg(long, default_value_t = 100, value_name = "N")]
    patches: u64,
    /// Number of spheres with free boundaries (Hertz), of waves, and of summits with Dugdale's law (Maugis)
    #[arg(long, default_value_t = 60, value_name = "N")]
    alike: u64,
    /// Seed of the first surface; the others follow, the next kind of surface a million later
    #[arg(long, default_value_t = 20_280_101, value_name = "SEED")]
    first_seed: u64,
    /// Write the summary to this file
    #[arg(long, default_value = "data/results/accuracy.json", value_name = "FILE.json")]
    out: PathBuf,
    /// Write each comparison as a line of JSON to this file: what constants are fitted to
    #[arg(long, value_name = "FILE.jsonl")]
    rows: Option<PathBuf>,
}

/// Comparison of all quantities.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[expect(missing_docs, reason = "docs/accuracy.md")]
pub struct Report {
    pub seeds: u64,
    pub patches: u64,
    pub alike: u64,
    pub first_seed: u64,
    /// Results by mode of `--grid-error` or kind of surface, then by name of the quantity, then by surfaces and loads:
    /// `all`, `H = 0.3`, `4 points a wave`, `p* = 0.01`.
    pub modes: BTreeMap<String, BTreeMap<String, BTreeMap<String, Coverage>>>,
}

/// Errors of a quantity over several contacts.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "docs/accuracy.md")]
pub struct Coverage {
    /// Number of contacts with an estimate, and without one.
    pub told: usize,
    pub untold: usize,
    /// Number of contacts with a limit that is within its error of the exact value.
    pub covered: usize,
    /// Number of contacts with a value that is within its grid error of the exact value.
    pub bounded: usize,
    /// Medians: |number - exact| / exact, |limit - exact| / exact, limit error / |limit - exact|.
    pub number_error: f64,
    pub limit_error: f64,
    pub width: f64,
    #[serde(skip)]
    errors: Vec<[f64; 3]>,
}

impl Coverage {
    fn add(&mut self, compared: Option<&Compared>) {
        let Some(&Compared { number, limit, error, bound, exact }) = compared else { return self.untold += 1 };
        self.told += 1;
        self.covered += usize::from((limit - exact).abs() <= error);
        self.bounded += usize::from((number - exact).abs() <= bound);
        self.errors.push([(number / exact - 1.0).abs(), (limit / exact - 1.0).abs(), error / (limit - exact).abs()]);
    }

    fn finish(&mut self) {
        let median = |k: usize| {
            let mut sorted: Vec<f64> = self.errors.iter().map(|errors| errors[k]).collect();
            sorted.sort_by(f64::total_cmp);
            sorted.get(sorted.len() / 2).copied().unwrap_or_default()
        };
        (self.number_error, self.limit_error, self.width) = (median(0), median(1), median(2));
    }
}

/// Value of a quantity, its limit, the estimated errors, and the exact value.
#[derive(Serialize)]
struct Compared {
    number: f64,
    limit: f64,
    error: f64,
    bound: f64,
    exact: f64,
}

/// Mode, name of the quantity, index of the load, and comparison; `None` without an error estimate.
type Row = (&'static str, &'static str, usize, Option<Compared>);

/// Solves the contact of a case on a grid that is `finer` by this factor; returns the loads as the program prints them.
fn loads(case: &Case, finer: usize, mode: &str, folder: &Path) -> Result<Vec<Value>, Failure> {
    let (flag, loads) = case.drives();
    let loads = loads.map(|load| load.to_string()).join(",");
    let surface = case.flags(finer, folder)?;
    let flags = format!("{surface} --{flag}={loads} --statistics --grid-error {mode}");
    Ok(solved::loads(&solved::contact(&flags)?).to_vec())
}

/// Compares the quantities of all loads of a case with closed forms or with the finest grid.
fn rows(case: &Case, folder: &Path) -> Result<Vec<Row>, Failure> {
    let finest = match case.kind {
        CaseKind::Sphere => None,
        // A law has no formula for one grid.
        CaseKind::Adhesive => Some(loads(case, FINER, "none", folder)?),
        CaseKind::Rough | CaseKind::Patch | CaseKind::Waves => Some(loads(case, FINER, "estimate", folder)?),
    };
    let mut found = Vec::new();
    for (name, mode) in case.modes() {
        for (load, coarse) in loads(case, 1, mode, folder)?.iter().enumerate() {
            let exact = |name: &str| match &finest {
                Some(finest) => finest.get(load).and_then(|fine| exact(fine, name, case.kind)),
                None => case.closed_form(load, name),
            };
            found.extend(names().map(|number| (*name, number, load, compared(coarse, number, exact(number)))));
        }
    }
    Ok(found)
}

/// Returns the names of quantities that have a limit.
fn names() -> impl Iterator<Item = &'static str> {
    COLUMNS.iter().filter_map(Column::limit_of)
}

/// Returns the limit of a quantity on the finest grid. Under a law, without a limit, returns the quantity itself.
fn exact(fine: &Value, name: &str, kind: CaseKind) -> Option<f64> {
    let exact = number(fine, &format!("{name}{}", if kind == CaseKind::Adhesive { "" } else { "_limit" }))?;
    // Boundary links are counted in units of the grid spacing.
    Some(if name == "boundary_links" { exact / FINER as f64 } else { exact })
}

fn compared(coarse: &Value, name: &str, exact: Option<f64>) -> Option<Compared> {
    let [number, limit, error, bound] =
        ["", "_limit", "_limit_error", "_grid_error"].map(|end| number(coarse, &format!("{name}{end}")));
    Some(Compared { number: number?, limit: limit?, error: error?, bound: bound?, exact: exact? })
}

/// Runs the command.
///
/// # Errors
/// A contact that could not be solved; a file that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let kinds = [
        (CaseKind::Rough, args.seeds),
        (CaseKind::Patch, args.patches),
        (CaseKind::Sphere, args.alike),
        (CaseKind::Waves, args.alike),
        (CaseKind::Adhesive, args.alike),
    ];
    let cases = kinds.map(|(kind, count)| (0..count).map(move |number| Case::new(kind, number, args.first_seed)));
    let cases: Vec<Case> = cases.into_iter().flatten().collect();
    let progress = Progress::new(session, "surfaces", cases.len());
    let folder = tempfile::tempdir().map_err(|error| Failure::computation(error.to_string()))?;
    let of_surface = |case: Case| {
        let found = rows(&case, folder.path())?;
        progress.advance(1.0, &format!("seed {}", case.seed));
        Ok((case, found))
    };
    let surfaces: Vec<_> = cases.into_par_iter().map(of_surface).collect::<Result<_, Failure>>()?;
    progress.finish();
    if let Some(path) = &args.rows {
        let rows = surfaces.iter().flat_map(|(case, found)| found.iter().map(move |row| (case, row)));
        let line = |row: (&Case, &Row)| serde_json::to_string(&row).map(|line| line + "\n");
        let lines = rows.map(line).collect::<Result<String, _>>();
        let lines = lines.map_err(|error| Failure::computation(error.to_string()))?;
        gfmd_files::replace(path, |file| std::io::Write::write_all(file, lines.as_bytes()))?;
    }
    let mut modes: BTreeMap<String, BTreeMap<String, BTreeMap<String, Coverage>>> = BTreeMap::new();
    for (case, found) in surfaces {
        let (surface, loads) = (case.groups(), case.loads());
        for (mode, name, load, compared) in found {
            let numbers = modes.entry(mode.to_owned()).or_default().entry(name.to_owned()).or_default();
            let mut add = |group: &str| numbers.entry(group.to_owned()).or_default().add(compared.as_ref());
            add("all");
            surface.iter().for_each(|group| add(group));
            add(&loads[load]);
        }
    }
    let all = modes.values_mut().flat_map(BTreeMap::values_mut).flat_map(BTreeMap::values_mut);
    all.for_each(Coverage::finish);
    let &Args { seeds, patches, alike, first_seed, .. } = args;
    let report = Report { seeds, patches, alike, first_seed, modes };
    let text = serde_json::to_string_pretty(&report).map_err(|error| Failure::computation(error.to_string()))?;
    gfmd_files::replace(&args.out, |file| std::io::Write::write_all(file, (text + "\n").as_bytes()))?;
    Ok(report)
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { seeds, patches, alike, first_seed, .. } = self;
        writeln!(
            f,
            "{seeds} surfaces, {patches} rough spheres with free boundaries, {alike} spheres, waves and adhesive \
             summits each, from seed {first_seed}"
        )?;
        for (mode, numbers) in &self.modes {
            writeln!(f, "\n{mode}")?;
            writeln!(
                f,
                "{:32}{:>10}{:>12}{:>12}{:>10}{:>8}{:>8}",
                "number", "told", "error", "of limit", "covered", "bound", "width"
            )?;
            for (name, groups) in numbers {
                let Some(Coverage { told, untold, covered, bounded, number_error, limit_error, width, .. }) =
                    groups.get("all")
                else {
                    continue;
                };
                let part = |count: usize| count as f64 / *told as f64;
                writeln!(
                    f,
                    "{name:32}{told:>5}/{:<4}{number_error:>12.1e}{limit_error:>12.1e}{:>10.3}{:>8.3}{width:>8.2}",
                    told + untold,
                    part(*covered),
                    part(*bounded)
                )?;
            }
        }
        Ok(())
    }
}
