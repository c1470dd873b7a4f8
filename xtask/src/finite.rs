//! `finite`: properties of self-affine surfaces of finite spectra other than κ: mean gap, stiffness, pressure and its
//! distribution, and the load at which contacts percolate.

mod high;

use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_cli::progress::Progress;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::solved::{contact, loads, number};

pub use high::PRESSURES;

const HURST: [f64; 4] = [0.0, 0.3, 0.5, 0.8];

/// Values of 1/ε_f, points on the shortest wave, and number of surfaces.
const LEVELS: [(usize, usize, u64); 3] = [(8, 8, 64), (32, 8, 24), (128, 4, 8)];

/// Number of longest waves along the cell.
const EPS_T_INV: usize = 2;

/// Rms gradient of the generated surfaces.
const RMS_GRADIENT: f64 = 0.1;

/// Reduced pressures p/(E* ḡ).
const REDUCED: [f64; 6] = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5];

/// Loads p λ_l/(E* h_rms), which do not depend on the short waves.
const OF_LONG_WAVES: [f64; 4] = [0.1, 0.3, 1.0, 3.0];

/// Reduced pressures that bracket percolation: the first, the factor between neighbours, their number, and the number
/// of bisections of the interval with the first percolation.
const LIGHTEST: f64 = 0.12;
const FACTOR: f64 = 1.12;
const STEPS: i32 = 18;
const HALVINGS: usize = 4;

/// Every n-th surface is also solved with twice the points, for the grid error of the pressure distribution.
const FINER: u64 = 8;

/// Flags of `finite`.
#[derive(ClapArgs, Clone, Debug)]
#[command(after_help = "Examples:
  cargo xtask finite --share 0.1 --out finite.json
  cargo xtask results")]
pub struct Args {
    /// The part of the surfaces that are computed, at least two of each kind
    #[arg(long, default_value_t = 1.0, value_name = "PART")]
    share: f64,
    /// Seed of the first surface of each kind
    #[arg(long, default_value_t = 1, value_name = "SEED")]
    first_seed: u64,
    /// Write the summary to this file
    #[arg(long, default_value = "data/results/finite.json", value_name = "FILE.json")]
    out: PathBuf,
}

/// Mean of a quantity over surfaces, with half of its 95 % interval: scatter and grid error.
pub type Known = [f64; 2];

/// Results for all kinds of surfaces.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[expect(missing_docs, reason = "docs/results/finite.md")]
pub struct Report {
    pub first_seed: u64,
    pub kinds: Vec<SurfaceKind>,
}

/// Surfaces of one Hurst exponent and spectrum.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[expect(missing_docs, reason = "docs/results/finite.md")]
pub struct SurfaceKind {
    pub hurst: f64,
    pub eps_f_inv: usize,
    pub surfaces: u64,
    /// Height ratio h_rms/(λ_l ḡ).
    pub height: Known,
    /// Results under given reduced pressures, and under given loads of the long waves.
    pub reduced: Vec<Numbers>,
    /// Fraction of the surface above each of [`PRESSURES`] divided by p/(E* ḡ), under the given reduced pressures.
    pub above: Vec<Vec<Known>>,
    pub of_long_waves: Vec<Numbers>,
    /// Reduced pressure and area fraction at which contacts percolate along an axis and the gap closes across it.
    pub percolation: [Known; 2],
}

/// Results for one load.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Numbers {
    /// Load p/(E* ḡ), or p λ_l/(E* h_rms).
    pub load: f64,
    /// Coefficient κ. Like all of these, `None` if contacts are too narrow for the grid on some surface.
    pub kappa: Option<Known>,
    /// Mean gap divided by h_rms.
    pub gap: Option<Known>,
    /// Stiffness times h_rms divided by the pressure.
    pub stiffness: Option<Known>,
    /// Rms pressure over the points in contact, divided by E* ḡ.
    pub rms_pressure: Option<Known>,
}

/// Results for one surface: the height, four quantities with their errors for each load, the fractions with high
/// pressure for each reduced pressure, the load and area of percolation.
struct Found {
    height: f64,
    loads: Vec<Option<[Known; 4]>>,
    above: Vec<high::Parts>,
    percolation: [Known; 2],
}

/// Returns a mean and half of its 95 % interval: the scatter (Student's t to 2 % from four values on) and the mean of
/// the individual errors, which may be correlated.
fn mean(numbers: impl Iterator<Item = Known>) -> Known {
    let numbers: Vec<Known> = numbers.collect();
    let count = numbers.len() as f64;
    let [mean, own] = [0, 1].map(|k| numbers.iter().map(|number| number[k]).sum::<f64>() / count);
    let variance = numbers.iter().map(|number| (number[0] - mean).powi(2)).sum::<f64>() / (count - 1.0);
    let student = 1.96 + 2.4 / (count - 1.0).powf(1.15);
    [mean, (student * (variance / count).sqrt()).hypot(own)]
}

fn limit(load: &Value, name: &str) -> Option<Known> {
    let found = |end: &str| number(load, &format!("{name}{end}"));
    Some([found("_limit")?, found("_limit_error")?])
}

/// Returns the four quantities of a load.
fn numbers(load: &Value, height: f64) -> Option<[Known; 4]> {
    let pressure = number(load, "mean_pressure")?;
    let over = |known: Known, unit: f64| known.map(|part| part / unit);
    let (area, square) = (limit(load, "area_fraction")?, limit(load, "pressure_moment_2")?);
    let rms = (square[0] / area[0]).sqrt();
    let of_rms = 0.5 * rms * (square[1] / square[0]).hypot(area[1] / area[0]);
    Some([
        limit(load, "kappa")?,
        over(limit(load, "mean_gap")?, height),
        over(limit(load, "stiffness")?, pressure / height),
        over([rms, of_rms], RMS_GRADIENT),
    ])
}

/// Returns the load and the area at which contacts of a surface percolate, averaged over both axes, starting between
/// the loads of a ramp.
fn percolation(surface: &str, ramp: &[Value]) -> Result<[Known; 2], Failure> {
    let unknown = || Failure::computation("contacts do not begin to percolate between the loads of the ramp");
    let of_axis = |axis: usize| -> Result<[Known; 2], Failure> {
        let place = format!("/patches/percolates/{axis}");
        let percolates = |load: &Value| load.pointer(&place).and_then(Value::as_bool) == Some(true);
        let first = ramp.iter().position(percolates).filter(|first| *first > 0).ok_or_else(unknown)?;
        let [mut light, mut heavy] = [ramp[first - 1].clone(), ramp[first].clone()];
        let p_star = |load: &Value| number(load, "p_star").unwrap_or(f64::NAN);
        for _ in 0..HALVINGS {
            let between = (p_star(&light) * p_star(&heavy)).sqrt();
            let found = loads(&contact(&format!("{surface} --statistics --p-star {between}"))?)[0].clone();
            let end = if percolates(&found) { &mut heavy } else { &mut light };
            *end = found;
        }
        let [before, at] = [&light, &heavy].map(|load| limit(load, "area_fraction"));
        let (before, at) = before.zip(at).ok_or_else(unknown)?;
        let of_step = [0.5 * (p_star(&heavy) - p_star(&light)), at[1].hypot(0.5 * (at[0] - before[0]))];
        Ok([[(p_star(&light) * p_star(&heavy)).sqrt(), of_step[0]], [0.5 * (before[0] + at[0]), of_step[1]]])
    };
    let (x, y) = (of_axis(0)?, of_axis(1)?);
    Ok([0, 1].map(|which| [0, 1].map(|part| 0.5 * (x[which][part] + y[which][part]))))
}

/// Computes the results of a surface.
fn found(hurst: f64, (eps_f_inv, points_per_wave): (usize, usize), seed: u64) -> Result<Found, Failure> {
    let n = points_per_wave * EPS_T_INV * eps_f_inv;
    let surface = format!("--n {n} --eps-t-inv {EPS_T_INV} --eps-f-inv {eps_f_inv} --hurst {hurst} --seed {seed}");
    let list = |loads: &mut dyn Iterator<Item = f64>| loads.map(|load| load.to_string()).collect::<Vec<_>>().join(",");
    let reduced = contact(&format!("{surface} --statistics --p-star {}", list(&mut REDUCED.into_iter())))?;
    let height = reduced["rms_height"].as_f64().unwrap_or(f64::NAN);
    // E* = 1 and λ_l = 1/EPS_T_INV.
    let pressures = list(&mut OF_LONG_WAVES.into_iter().map(|load| load * height * EPS_T_INV as f64));
    let of_long_waves = contact(&format!("{surface} --statistics --pressure {pressures}"))?;
    let ramp = list(&mut (0..STEPS).map(|step| LIGHTEST * FACTOR.powi(step)));
    let ramp = contact(&format!("{surface} --statistics --p-star {ramp}"))?;
    let both = loads(&reduced).iter().chain(loads(&of_long_waves));
    Ok(Found {
        height: height * EPS_T_INV as f64 / RMS_GRADIENT,
        loads: both.map(|load| numbers(load, height)).collect(),
        above: high::parts(hurst, (eps_f_inv, points_per_wave), seed)?,
        percolation: percolation(&surface, loads(&ramp))?,
    })
}

/// Averages the results of the surfaces of one kind. `finer` has some of the surfaces with twice the points per side.
fn kind(hurst: f64, eps_f_inv: usize, found: &[Found], finer: &[Vec<high::Parts>]) -> SurfaceKind {
    let above = |load: usize, place: usize| {
        let [value, scatter] = mean(found.iter().map(|found| [found.above[load][place], 0.0]));
        let steps = found.iter().zip(finer).map(|(found, finer)| finer[load][place] - found.above[load][place]);
        // A first-order error is halved on the finer grid.
        [value, scatter.hypot(2.0 * steps.sum::<f64>() / finer.len() as f64)]
    };
    let over_loads = |first: usize, loads: &[f64]| {
        let of = |(index, load): (usize, &f64)| {
            let all = found.iter().map(|found| found.loads[first + index]).collect::<Option<Vec<_>>>();
            let over = |which: usize| all.as_ref().map(|all| mean(all.iter().map(|numbers| numbers[which])));
            Numbers { load: *load, kappa: over(0), gap: over(1), stiffness: over(2), rms_pressure: over(3) }
        };
        loads.iter().enumerate().map(of).collect()
    };
    SurfaceKind {
        hurst,
        eps_f_inv,
        surfaces: found.len() as u64,
        height: mean(found.iter().map(|found| [found.height, 0.0])),
        reduced: over_loads(0, &REDUCED),
        above: (0..REDUCED.len()).map(|load| (0..PRESSURES.len()).map(|place| above(load, place)).collect()).collect(),
        of_long_waves: over_loads(REDUCED.len(), &OF_LONG_WAVES),
        percolation: [0, 1].map(|which| mean(found.iter().map(|found| found.percolation[which]))),
    }
}

/// Runs the command.
///
/// # Errors
/// A contact that could not be solved or has unknown quantities; a file that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let kinds = HURST.into_iter().flat_map(|hurst| LEVELS.map(|level| (hurst, level)));
    let surfaces = |all: u64| ((args.share * all as f64).round() as u64).max(2);
    let count = LEVELS.iter().map(|level| surfaces(level.2)).sum::<u64>() * HURST.len() as u64;
    let progress = Progress::new(session, "surfaces", count as usize);
    let of_kind = |(hurst, (eps_f_inv, points, all)): (f64, (usize, usize, u64))| {
        let of_surface = |number: u64| {
            let found = found(hurst, (eps_f_inv, points), args.first_seed + number);
            progress.advance(1.0, &format!("H = {hurst}, 1/eps_f = {eps_f_inv}"));
            found
        };
        let found: Vec<Found> = (0..surfaces(all)).into_par_iter().map(of_surface).collect::<Result<_, Failure>>()?;
        let finer = (0..(surfaces(all) / FINER).max(2)).into_par_iter();
        let finer = finer.map(|number| high::parts(hurst, (eps_f_inv, 2 * points), args.first_seed + number));
        Ok(kind(hurst, eps_f_inv, &found, &finer.collect::<Result<Vec<_>, Failure>>()?))
    };
    let kinds = kinds.map(of_kind).collect::<Result<_, Failure>>()?;
    let report = Report { first_seed: args.first_seed, kinds };
    progress.finish();
    let text = serde_json::to_string_pretty(&report).map_err(|error| Failure::computation(error.to_string()))?;
    gfmd_files::replace(&args.out, |file| std::io::Write::write_all(file, (text + "\n").as_bytes()))?;
    Ok(report)
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        for SurfaceKind { hurst, eps_f_inv, surfaces, height, reduced, above, of_long_waves, percolation } in
            &self.kinds
        {
            writeln!(f, "H = {hurst}, 1/eps_f = {eps_f_inv}, {surfaces} surfaces, height {:.4}", height[0])?;
            for Numbers { load, kappa, gap, stiffness, rms_pressure } in reduced.iter().chain(of_long_waves) {
                let text = |[value, error]: Known| format!("{value:.4} ± {error:.4}");
                let known = [kappa, gap, stiffness, rms_pressure].map(|known| known.map_or_else(|| "–".into(), text));
                writeln!(f, "{load:8}  {}", known.join("  "))?;
            }
            for (load, above) in REDUCED.iter().zip(above) {
                let known: Vec<String> =
                    above.iter().map(|[value, error]| format!("{value:.4} ± {error:.4}")).collect();
                writeln!(f, "above {PRESSURES:?}, {load:8}  {}", known.join("  "))?;
            }
            let [[load, of_load], [area, of_area]] = percolation;
            writeln!(f, "percolation at p* = {load:.4} ± {of_load:.4}, area {area:.4} ± {of_area:.4}\n")?;
        }
        Ok(())
    }
}
