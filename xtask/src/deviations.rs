//! `deviations`: deviations of the numbers of `gfmd estimate` from solved contacts.

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::{Args as ClapArgs, Parser};
use gfmd_cli::estimate::{Deviations, NAMES, numbers, of, shape};
use gfmd_cli::progress::Progress;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_input::source::SourceArgs;
use gfmd_problem::options::BodyArgs;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::finite;
use crate::solved::{contact, loads, number};

const HURST: [f64; 5] = [0.0, 0.3, 0.5, 0.8, 1.0];

/// Longest waves along the cell, 1/ε_f, points on the shortest wave, first wave of the power law (as a part of the
/// cell), and number of surfaces.
const LEVELS: [(usize, usize, usize, Option<f64>, u64); 4] =
    [(2, 8, 16, None, 8), (2, 32, 8, None, 4), (2, 128, 4, None, 2), (1, 64, 8, Some(0.25), 2)];

/// Reduced pressures p/(E* ḡ).
const REDUCED: [f64; 9] = [0.0001, 0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0];

/// Part of the contacts that deviate by at most the error.
const COVERED: f64 = 0.95;

/// Flags of `deviations`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  cargo xtask deviations
  cargo xtask deviations --first-seed 101 --out other.json")]
pub struct Args {
    /// Seed of the first surface of each kind
    #[arg(long, default_value_t = 1, value_name = "SEED")]
    first_seed: u64,
    /// Write the summary to this file
    #[arg(long, default_value = "data/results/estimate.json", value_name = "FILE.json")]
    out: PathBuf,
}

/// Deviations of all surfaces.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[expect(missing_docs, reason = "docs/estimate.md")]
pub struct Report {
    pub first_seed: u64,
    #[serde(flatten)]
    pub deviations: Deviations,
    pub kinds: Vec<SurfaceKind>,
}

/// Surfaces of one Hurst exponent and spectrum.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[expect(missing_docs, reason = "docs/estimate.md")]
pub struct SurfaceKind {
    pub hurst: f64,
    pub eps_t_inv: usize,
    pub eps_f_inv: usize,
    pub eps_c_inv: usize,
    pub roll_off: Option<f64>,
    pub surfaces: u64,
    /// By the name of a number, for each load: mean and rms of the estimate divided by the solution, minus one; `None`
    /// without an estimate.
    pub deviation: BTreeMap<String, Vec<Option<[f64; 2]>>>,
}

#[derive(Parser)]
struct Words {
    #[command(flatten)]
    source: SourceArgs,
    #[command(flatten)]
    body: BodyArgs,
}

/// Deviations of one surface for each load and number, with the Hurst exponent and 1/ε_f of its equivalent band, and
/// skewness and kurtosis of its heights, and the anisotropy of its slopes.
struct Found {
    ranges: [f64; 5],
    loads: Vec<[f64; 5]>,
}

/// Returns the numbers of a solved load, in the limit of an infinitely fine grid where it is known.
fn solved(load: &Value) -> Option<[f64; 5]> {
    let best = |name: &str| number(load, &format!("{name}_limit")).or_else(|| number(load, name));
    let rms = (best("pressure_moment_2")? / best("area_fraction")?).sqrt();
    Some([best("area_fraction")?, best("mean_gap")?, best("stiffness")?, rms, best("max_pressure")?])
}

/// Computes the deviations of a surface.
fn found(surface: &str) -> Result<Found, Failure> {
    let words = std::iter::once("estimate").chain(surface.split_whitespace());
    let words = Words::try_parse_from(words).map_err(|error| Failure::refused(error.to_string()))?;
    let made = words.source.surface(&Session::silent())?;
    let unknown = |what: &str| Failure::computation(format!("{surface}: no {what}"));
    let estimate = of(&made, &words.source, &words.body)?.0.ok_or_else(|| unknown("estimate"))?;
    let list = REDUCED.map(|load| load.to_string()).join(",");
    let report = contact(&format!("{surface} --statistics --p-star {list}"))?;
    let deviations = |load: &Value| {
        let p = number(load, "mean_pressure").ok_or_else(|| unknown("pressure"))?;
        let solved = solved(load).ok_or_else(|| unknown("number of a load"))?;
        let estimated = numbers(&estimate.at(p));
        let deviation = |which: usize| estimated[which].map_or(f64::NAN, |value| value / solved[which] - 1.0);
        Ok([0, 1, 2, 3, 4].map(deviation))
    };
    let band = estimate.band();
    let [ssk, sku, anisotropy] = shape(&made)?;
    let loads = loads(&report).iter().map(deviations).collect::<Result<_, Failure>>()?;
    Ok(Found { ranges: [band.hurst, band.eps_f_inv, ssk, sku, anisotropy], loads })
}

/// Returns the deviations of one number at one load; surfaces without an estimate are left out.
fn all(found: &[Found], load: usize, which: usize) -> Vec<f64> {
    found.iter().map(|found| found.loads[load][which]).filter(|deviation| deviation.is_finite()).collect()
}

/// Returns mean and rms of the deviations of one kind.
fn kind((hurst, level): (f64, (usize, usize, usize, Option<f64>, u64)), found: &[Found]) -> SurfaceKind {
    let (eps_t_inv, eps_f_inv, eps_c_inv, roll_off, surfaces) = level;
    let of = |which: usize, load: usize| {
        let all = all(found, load, which);
        let count = all.len() as f64;
        let mean = |sum: f64| sum / count;
        let square = all.iter().map(|deviation| deviation * deviation).sum();
        (!all.is_empty()).then(|| [mean(all.iter().sum()), mean(square).sqrt()])
    };
    let loads = |which: usize| (0..REDUCED.len()).map(|load| of(which, load)).collect();
    let deviation = NAMES.iter().enumerate().map(|(which, name)| ((*name).to_owned(), loads(which))).collect();
    SurfaceKind { hurst, eps_t_inv, eps_f_inv, eps_c_inv, roll_off, surfaces, deviation }
}

/// Returns the deviation that a part of the contacts do not exceed.
fn covering(mut deviations: Vec<f64>) -> f64 {
    deviations.iter_mut().for_each(|deviation| *deviation = deviation.abs());
    deviations.sort_by(f64::total_cmp);
    let place = (COVERED * deviations.len() as f64).ceil() as usize;
    deviations.get(place.saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

/// Returns the area fraction of percolation, the mean over the kinds of surfaces of `finite`, and its error, from the
/// scatter of the kinds and of the surfaces of a kind.
fn percolation(kinds: &[finite::SurfaceKind]) -> [f64; 2] {
    let count = kinds.len() as f64;
    let mean = kinds.iter().map(|kind| kind.percolation[1][0]).sum::<f64>() / count;
    let between = kinds.iter().map(|kind| (kind.percolation[1][0] - mean).powi(2)).sum::<f64>() / (count - 1.0);
    // The interval of a mean is 1.96 standard errors for many surfaces.
    let within = kinds.iter().map(|kind| (kind.percolation[1][1] / 1.96).powi(2) * kind.surfaces as f64);
    [mean, 1.96 * (between + within.sum::<f64>() / count).sqrt()]
}

/// Runs the command.
///
/// # Errors
/// A contact that could not be solved; a file that cannot be read or written.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let text = std::fs::read_to_string("data/results/finite.json")
        .map_err(|error| Failure::refused(format!("data/results/finite.json: {error}")))?;
    let of_finite: finite::Report =
        serde_json::from_str(&text).map_err(|error| Failure::refused(format!("data/results/finite.json: {error}")))?;
    let kinds = || HURST.into_iter().flat_map(|hurst| LEVELS.map(|level| (hurst, level)));
    let progress = Progress::new(session, "surfaces", kinds().map(|(_, level)| level.4 as f64).sum());
    let of_kind = |(hurst, level): (f64, (usize, usize, usize, Option<f64>, u64))| {
        let (eps_t_inv, eps_f_inv, points, roll_off, surfaces) = level;
        let n = points * eps_t_inv * eps_f_inv;
        let rolled = roll_off.map_or_else(String::new, |length| format!(" --roll-off {length}"));
        let of_seed = |seed: u64| {
            let found = found(&format!(
                "--n {n} --eps-t-inv {eps_t_inv} --eps-f-inv {eps_f_inv} --hurst {hurst} --seed {seed}{rolled}"
            ));
            progress.advance(1.0, &format!("H = {hurst}, 1/eps_f = {eps_f_inv}"));
            found
        };
        (args.first_seed..args.first_seed + surfaces).into_par_iter().map(of_seed).collect::<Result<Vec<_>, Failure>>()
    };
    let found = kinds().map(of_kind).collect::<Result<Vec<_>, Failure>>()?;
    progress.finish();
    let of_kinds = kinds().zip(&found).map(|(of, found)| kind(of, found)).collect();
    let every: Vec<Found> = found.into_iter().flatten().collect();
    let error = |which: usize| (0..REDUCED.len()).map(|load| covering(all(&every, load, which))).collect();
    let range = |which: usize| {
        let values = || every.iter().map(|found| found.ranges[which]);
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    };
    // Heights of either sign are equally probable.
    let skewest = every.iter().map(|found| found.ranges[2].abs()).fold(0.0, f64::max);
    let deviations = Deviations {
        p_star: REDUCED.to_vec(),
        error: NAMES.iter().enumerate().map(|(which, name)| ((*name).to_owned(), error(which))).collect(),
        contacts: every.len(),
        hurst: range(0),
        eps_f_inv: range(1),
        ssk: [-skewest, skewest],
        sku: range(3),
        anisotropy: range(4),
        percolation: percolation(&of_finite.kinds),
    };
    let report = Report { first_seed: args.first_seed, deviations, kinds: of_kinds };
    let text = serde_json::to_string_pretty(&report).map_err(|error| Failure::computation(error.to_string()))?;
    gfmd_files::replace(&args.out, |file| std::io::Write::write_all(file, (text + "\n").as_bytes()))?;
    Ok(report)
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "deviation in %, mean and rms, at p* = {REDUCED:?}")?;
        for SurfaceKind { hurst, eps_f_inv, roll_off, deviation, .. } in &self.kinds {
            writeln!(f, "H = {hurst}, 1/eps_f = {eps_f_inv}, roll-off {roll_off:?}")?;
            for (name, loads) in deviation {
                let cell = |[mean, rms]: [f64; 2]| format!("{:6.1} {:5.1}", 100.0 * mean, 100.0 * rms);
                let cells = loads.iter().map(|known| known.map_or_else(|| format!("{:>12}", "-"), cell));
                writeln!(f, "{name:>16} {}", cells.collect::<Vec<_>>().join("  "))?;
            }
        }
        let Deviations { error, contacts, hurst, eps_f_inv, percolation, .. } = &self.deviations;
        writeln!(f, "95 % of {contacts} surfaces")?;
        for (name, errors) in error {
            let cells = errors.iter().map(|error| format!("{:6.1}", 100.0 * error));
            writeln!(f, "{name:>16} {}", cells.collect::<Vec<_>>().join("  "))?;
        }
        let [area, spread] = percolation;
        writeln!(f, "H {hurst:?}, 1/eps_f {eps_f_inv:?}, percolation at {area:.4} ± {spread:.4}")
    }
}
