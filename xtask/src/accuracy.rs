//! `accuracy`: the estimates of the error of the grid, compared with solutions on grids 8 times finer, of new surfaces.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::{Args as ClapArgs, Parser};
use gfmd_cli::contact;
use gfmd_cli::progress::Progress;
use gfmd_field::Grid;
use gfmd_record::{COLUMNS, Column};
use gfmd_run::failure::Failure;
use gfmd_run::session::Session;
use gfmd_surface::SelfAffine;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The Hurst exponents, of which the surfaces have one after the other.
const HURST: [f64; 3] = [0.0, 0.3, 0.8];

/// The points on the shortest wave, of which the surfaces have one after the other.
const POINTS_PER_WAVE: [usize; 2] = [4, 8];

/// The reduced pressures.
const LOADS: [f64; 4] = [0.01, 0.05, 0.2, 0.5];

/// The shortest waves over the length of the cell.
const WAVES: usize = 16;

/// The mean pressures over E* on rough spheres with free boundaries, whose contacts stay inside of the patch. Reduced pressures would
/// depend on the grid: the gradient of a patch is one of differences.
const LOADS_OF_A_PATCH: [f64; 4] = [0.0007, 0.0015, 0.003, 0.007];

/// The shortest waves over the length of a patch.
const WAVES_OF_A_PATCH: usize = 8;

/// The seed of the first patch over that of the first surface.
const PATCHES: u64 = 1_000_000;

/// The height of the sphere of a patch over the middle of its sides, in lengths of the patch.
const SPHERE: f64 = 0.05;

/// The grid that has the exact value is finer by this factor.
const FINER: usize = 8;

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
    /// Seed of the first surface; the others follow, patches a million later
    #[arg(long, default_value_t = 20_270_101, value_name = "SEED")]
    first_seed: u64,
    /// Write the summary to this file
    #[arg(long, default_value = "data/results/accuracy.json", value_name = "FILE.json")]
    out: PathBuf,
    /// Write each comparison as a line of JSON to this file: what constants are fitted to
    #[arg(long, value_name = "FILE.jsonl")]
    rows: Option<PathBuf>,
}

/// The comparison of all numbers.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[expect(missing_docs, reason = "docs/accuracy.md")]
pub struct Report {
    pub seeds: u64,
    pub patches: u64,
    pub first_seed: u64,
    /// By the mode of `--grid-error`, or `free`, then by the name of the number, then by the surfaces and loads: `all`,
    /// `H = 0.3`, `4 points a wave`, `p* = 0.01`.
    pub modes: BTreeMap<String, BTreeMap<String, BTreeMap<String, Coverage>>>,
}

/// The errors of a number in some contacts.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[expect(missing_docs, reason = "docs/accuracy.md")]
pub struct Coverage {
    /// Contacts with an estimate, and without one.
    pub told: usize,
    pub untold: usize,
    /// Those whose limit is within its error of the exact value.
    pub covered: usize,
    /// Those whose number is within its error by the grid of the exact value.
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

/// A number, its limit, the errors that are told, and the exact value.
#[derive(Serialize)]
struct Compared {
    number: f64,
    limit: f64,
    error: f64,
    bound: f64,
    exact: f64,
}

#[derive(Parser)]
struct Command {
    #[command(flatten)]
    contact: contact::Args,
}

/// The mode, the name of a number, the load, and the comparison; `None` where the error is not told.
type Row = (&'static str, &'static str, f64, Option<Compared>);

/// A surface, and the way in which its contact is solved.
#[derive(Serialize)]
struct Case {
    is_free: bool,
    seed: u64,
    hurst: f64,
    points_per_wave: usize,
}

impl Case {
    /// The surface of this index, periodic ones first.
    fn new(args: &Args, index: u64) -> Self {
        let patch = index.checked_sub(args.seeds);
        let place = patch.unwrap_or(index) as usize;
        Self {
            is_free: patch.is_some(),
            seed: args.first_seed + patch.map_or(index, |patch| PATCHES + patch),
            hurst: HURST[place % HURST.len()],
            points_per_wave: POINTS_PER_WAVE[place / HURST.len() % POINTS_PER_WAVE.len()],
        }
    }

    /// The loads, and the flag that gives them.
    fn drives(&self) -> (&'static str, [f64; 4]) {
        if self.is_free { ("pressure", LOADS_OF_A_PATCH) } else { ("p-star", LOADS) }
    }

    /// The flags of the surface on a grid that is finer by this factor; a rough sphere is written to `folder`.
    fn flags(&self, finer: usize, folder: &Path) -> Result<String, Failure> {
        let Self { is_free, seed, hurst, points_per_wave } = *self;
        if !is_free {
            let (n, shortest) = (WAVES * points_per_wave * finer, WAVES / 2);
            return Ok(format!("--n {n} --eps-t-inv 2 --eps-f-inv {shortest} --hurst {hurst} --seed {seed} --flow"));
        }
        let failed = |error: &dyn std::fmt::Display| Failure::Computation(error.to_string());
        let n = WAVES_OF_A_PATCH * points_per_wave * finer;
        let grid = Grid::square(n, 1.0).map_err(|error| failed(&error))?;
        let rough = SelfAffine {
            hurst,
            longest_wavelength: 0.5,
            shortest_wavelength: 1.0 / WAVES_OF_A_PATCH as f64,
            ..SelfAffine::with_rms_gradient(0.1)
        };
        let mut heights = rough.heights(&grid, seed).map_err(|error| failed(&error))?;
        for ((i, j), height) in heights.indexed_iter_mut() {
            let [x, y] = [i, j].map(|index| index as f64 / n as f64 - 0.5);
            *height -= 4.0 * SPHERE * (x * x + y * y);
        }
        let path = folder.join(format!("{seed}-{n}.npy"));
        ndarray_npy::write_npy(&path, &heights).map_err(|error| failed(&error))?;
        Ok(format!("--surface {} --length 1 --boundary free", path.display()))
    }

    /// The loads of the contact on a grid that is finer by this factor, as the program prints them.
    fn loads(&self, finer: usize, mode: &str, folder: &Path) -> Result<Vec<Value>, Failure> {
        let (flag, loads) = self.drives();
        let loads = loads.map(|load| load.to_string()).join(",");
        let surface = self.flags(finer, folder)?;
        let flags = format!("contact {surface} --{flag} {loads} --statistics --grid-error {mode}");
        let command = Command::try_parse_from(flags.split(' ')).map_err(|error| Failure::Input(error.to_string()))?;
        let run = || contact::run(&command.contact, &Session::silent());
        let outcome = tracing::subscriber::with_default(tracing::subscriber::NoSubscriber::new(), run)?;
        if let Some(failure) = outcome.failure {
            return Err(failure);
        }
        let report = serde_json::to_value(&outcome.report).map_err(|error| Failure::Computation(error.to_string()))?;
        Ok(report["loads"].as_array().cloned().unwrap_or_default())
    }

    /// The numbers of all loads compared with those of the finest grid.
    fn compared(&self, folder: &Path) -> Result<Vec<Row>, Failure> {
        let fine = self.loads(FINER, "estimate", folder)?;
        let mut found = Vec::new();
        // A patch has no finer grid.
        let modes: &[_] =
            if self.is_free { &[("free", "estimate")] } else { &[("estimate", "estimate"), ("refine", "refine")] };
        for (name, mode) in modes {
            for ((coarse, fine), load) in self.loads(1, mode, folder)?.iter().zip(&fine).zip(self.drives().1) {
                found.extend(names().map(|number| (*name, number, load, compared(coarse, fine, number))));
            }
        }
        Ok(found)
    }
}

/// The numbers that have a limit.
fn names() -> impl Iterator<Item = &'static str> {
    COLUMNS.iter().filter_map(Column::limit_of)
}

/// A number of a load; `None` if it has no value.
fn number(load: &Value, name: &str) -> Option<f64> {
    let column = COLUMNS.iter().find(|column| column.name == name)?;
    load.pointer(&format!("/{}", column.json.replace('.', "/")))?.as_f64()
}

fn compared(coarse: &Value, fine: &Value, name: &str) -> Option<Compared> {
    let [number, limit, error, bound] =
        ["", "_limit", "_limit_error", "_grid_error"].map(|end| number(coarse, &format!("{name}{end}")));
    let exact = self::number(fine, &format!("{name}_limit"))?;
    // Boundary links are counted in the spacing of their grid.
    let exact = if name == "boundary_links" { exact / FINER as f64 } else { exact };
    Some(Compared { number: number?, limit: limit?, error: error?, bound: bound?, exact })
}

/// Runs the command.
///
/// # Errors
/// A contact that was not solved; a file that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let count = args.seeds + args.patches;
    let progress = Progress::new(session.quiet, "surfaces", count as f64);
    let folder = tempfile::tempdir().map_err(|error| Failure::Computation(error.to_string()))?;
    let of_surface = |index: u64| {
        let case = Case::new(args, index);
        let found = case.compared(folder.path())?;
        progress.advance(1.0, &format!("seed {}", case.seed));
        Ok((case, found))
    };
    let surfaces: Vec<_> = (0..count).into_par_iter().map(of_surface).collect::<Result<_, Failure>>()?;
    progress.finish();
    if let Some(path) = &args.rows {
        let rows = surfaces.iter().flat_map(|(case, found)| found.iter().map(move |row| (case, row)));
        let line = |row: (&Case, &Row)| serde_json::to_string(&row).map(|line| line + "\n");
        let lines = rows.map(line).collect::<Result<String, _>>();
        let lines = lines.map_err(|error| Failure::Computation(error.to_string()))?;
        gfmd_files::replace(path, |file| std::io::Write::write_all(file, lines.as_bytes()))?;
    }
    let mut modes: BTreeMap<String, BTreeMap<String, BTreeMap<String, Coverage>>> = BTreeMap::new();
    for (Case { is_free, hurst, points_per_wave, .. }, found) in surfaces {
        for (mode, name, load, compared) in found {
            let numbers = modes.entry(mode.to_owned()).or_default().entry(name.to_owned()).or_default();
            let groups = [
                "all".to_owned(),
                format!("H = {hurst}"),
                format!("{points_per_wave} points a wave"),
                format!("{} = {load}", if is_free { "p/E*" } else { "p*" }),
            ];
            groups.into_iter().for_each(|group| numbers.entry(group).or_default().add(compared.as_ref()));
        }
    }
    let all = modes.values_mut().flat_map(BTreeMap::values_mut).flat_map(BTreeMap::values_mut);
    all.for_each(Coverage::finish);
    let report = Report { seeds: args.seeds, patches: args.patches, first_seed: args.first_seed, modes };
    let text = serde_json::to_string_pretty(&report).map_err(|error| Failure::Computation(error.to_string()))?;
    gfmd_files::replace(&args.out, |file| std::io::Write::write_all(file, (text + "\n").as_bytes()))?;
    Ok(report)
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { seeds, patches, first_seed, .. } = self;
        writeln!(f, "{seeds} surfaces and {patches} rough spheres with free boundaries, from seed {first_seed}")?;
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
