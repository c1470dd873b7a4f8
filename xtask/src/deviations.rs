//! `deviations`: deviations of the numbers of `gfmd estimate` from solved contacts.

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::Arc;

use clap::{Args as ClapArgs, Parser};
use gfmd_cli::estimate::{Deviations, Group, NAMES, numbers, of, shape};
use gfmd_cli::progress::Progress;
use gfmd_field::{Grid, Transform};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_input::source::SourceArgs;
use gfmd_problem::options::BodyArgs;
use gfmd_problem::options::given::ArrayOption;
use ndarray::Array2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::finite;
use crate::solved::{contact_of, loads, number};

const HURST: [f64; 5] = [0.0, 0.3, 0.5, 0.8, 1.0];

/// Hurst exponents with one of smooth scans.
const SMOOTH: [f64; 6] = [0.0, 0.3, 0.5, 0.8, 1.0, 1.4];

/// Spectrum of surfaces of one kind.
#[derive(Clone, Copy, Debug)]
#[expect(missing_docs, reason = "docs/estimate.md")]
pub struct Spectrum {
    pub eps_t_inv: usize,
    pub eps_f_inv: usize,
    /// Points on the shortest wave.
    pub eps_c_inv: usize,
    /// First wave of the power law, divided by the cell.
    pub roll_off: Option<f64>,
}

const SPECTRA: [Spectrum; 4] = [
    Spectrum { eps_t_inv: 2, eps_f_inv: 8, eps_c_inv: 16, roll_off: None },
    Spectrum { eps_t_inv: 2, eps_f_inv: 32, eps_c_inv: 8, roll_off: None },
    Spectrum { eps_t_inv: 2, eps_f_inv: 128, eps_c_inv: 4, roll_off: None },
    Spectrum { eps_t_inv: 1, eps_f_inv: 64, eps_c_inv: 8, roll_off: Some(0.25) },
];

/// Surfaces whose errors are measured together.
#[derive(Clone, Copy)]
struct Surfaces {
    name: &'static str,
    /// Number of surfaces of each spectrum, Hurst exponent, lay, distribution of heights and contrast of roughness.
    count: [u64; 4],
    /// Lengths of waves along the lay divided by their lengths across.
    aspects: &'static [f64],
    /// s of the heights (e^{s h/σ} − 1)/s, which makes their skewness; 0 for Gaussian ones.
    bends: &'static [f64],
    /// t of the lognormal factor e^{t g} of the short waves; 0 for surfaces that are equally rough everywhere.
    contrasts: &'static [f64],
    hursts: &'static [f64],
}

/// Surfaces that are equally rough everywhere.
const fn even(name: &'static str, count: [u64; 4], aspects: &'static [f64], bends: &'static [f64]) -> Surfaces {
    Surfaces { name, count, aspects, bends, contrasts: &[0.0], hursts: &HURST }
}

/// Surfaces with smooth and rough parts.
const fn uneven(name: &'static str, contrasts: &'static [f64]) -> Surfaces {
    Surfaces { name, count: [2, 1, 1, 1], aspects: &[1.0, 4.0], bends: &[-0.17, 0.17], contrasts, hursts: &SMOOTH }
}

/// Longest short wave, which the contrast makes uneven, divided by the longest wave; the factor has waves between the
/// longest wave and half of it.
const SHORT: f64 = 0.25;

const GROUPS: [Surfaces; 8] = [
    even("isotropic Gaussian surfaces", [8, 4, 2, 2], &[1.0], &[0.0]),
    even("surfaces with a lay", [4, 2, 1, 0], &[2.0, 4.0], &[0.0]),
    even("surfaces with valleys", [4, 2, 1, 1], &[1.0, 4.0], &[-0.17]),
    even("surfaces with peaks", [4, 2, 1, 1], &[1.0, 4.0], &[0.17]),
    even("surfaces with deep valleys", [2, 1, 1, 1], &[1.0, 4.0], &[-0.35]),
    even("surfaces with high peaks", [2, 1, 1, 1], &[1.0, 4.0], &[0.35]),
    uneven("surfaces of slightly uneven roughness", &[0.3]),
    uneven("surfaces of uneven roughness", &[0.5, 0.7]),
];

/// Reduced pressures p/(E* ḡ).
const REDUCED: [f64; 9] = [0.0001, 0.0003, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0];

/// Part of the contacts that deviate by at most the error.
const COVERED: f64 = 0.95;

/// Part of the surfaces of uneven roughness whose skewness and kurtoses the ranges contain: lognormal factors make a
/// few with far higher ones, which count in the errors alone.
const TYPICAL: f64 = 0.85;

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
    /// By kind of surface, for the printed tables.
    #[serde(skip)]
    pub kinds: Vec<SurfaceKind>,
}

/// Surfaces of one Hurst exponent, spectrum, lay, distribution of heights and contrast of roughness.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "docs/estimate.md")]
pub struct SurfaceKind {
    pub group: String,
    pub hurst: f64,
    pub spectrum: Spectrum,
    /// Length of waves along the lay divided by their length across.
    pub aspect: f64,
    /// s of the heights (e^{s h/σ} − 1)/s; 0 for Gaussian ones.
    pub bend: f64,
    /// t of the lognormal factor e^{t g} of the short waves; 0 for equally rough surfaces.
    pub contrast: f64,
    /// Number of surfaces with an estimate.
    pub surfaces: usize,
    pub deviations: Vec<DeviationOfNumber>,
}

/// Deviations of one number of the surfaces of a kind.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "docs/estimate.md")]
pub struct DeviationOfNumber {
    pub name: String,
    /// For each load mean and rms of the estimate divided by the solution, minus one; `None` without an estimate.
    pub loads: Vec<Option<[f64; 2]>>,
}

#[derive(Parser)]
struct Words {
    #[command(flatten)]
    source: SourceArgs,
    #[command(flatten)]
    body: BodyArgs,
}

/// Deviations of one surface for each load and number, with the Hurst exponent and 1/ε_f of its equivalent band, and
/// skewness and kurtosis of its heights, and the anisotropy and relative kurtosis of its slopes.
struct Found {
    ranges: [f64; 6],
    loads: Vec<[f64; 5]>,
}

/// Returns the numbers of a solved load, in the limit of an infinitely fine grid where it is known.
fn solved(load: &Value) -> Option<[f64; 5]> {
    let best = |name: &str| number(load, &format!("{name}_limit")).or_else(|| number(load, name));
    let rms = (best("pressure_moment_2")? / best("area_fraction")?).sqrt();
    Some([best("area_fraction")?, best("mean_gap")?, best("stiffness")?, rms, best("max_pressure")?])
}

/// Returns heights with another distribution: a lognormal one that reaches far up or, with a negative s, far down.
fn bent(heights: &Array2<f64>, s: f64) -> Array2<f64> {
    let deviation = heights.std(0.0);
    heights.mapv(|h| deviation * (s * h / deviation).exp_m1() / s)
}

/// Parses flags of a surface and a body.
fn parsed(surface: &str) -> Result<Words, Failure> {
    let words = std::iter::once("estimate").chain(surface.split_whitespace());
    Words::try_parse_from(words).map_err(|error| Failure::refused(error.to_string()))
}

/// Returns heights with each wave multiplied by a factor of its wavenumber, 1/length.
fn filtered(heights: &Array2<f64>, grid: &Grid, factor: impl Fn(f64) -> f64) -> Result<Array2<f64>, Failure> {
    let kernel: Vec<f64> = grid.modes().map(|mode| factor(mode.wavenumber())).collect();
    let (transform, field) = (Transform::new(*grid), heights.iter().copied().collect::<Vec<_>>());
    let (mut out, mut workspace) = (vec![0.0; field.len()], transform.workspace());
    let computed = |error: &dyn std::fmt::Display| Failure::computation(error.to_string());
    transform.convolve(&kernel, &field, &mut out, &mut workspace).map_err(|error| computed(&error))?;
    Array2::from_shape_vec(heights.raw_dim(), out).map_err(|error| computed(&error))
}

/// Computes the deviations of a surface; `None` if its spectrum is unlike all with an estimate.
fn found(surface: &str, heights: Option<Array2<f64>>) -> Result<Option<Found>, Failure> {
    let session = Session::silent();
    let Words { mut source, body } = parsed(surface)?;
    if let Some(heights) = heights {
        source = parsed("--size 1")?.source;
        source.surface = Some(ArrayOption::Array(Arc::new(heights.into_dyn())));
    }
    let made = source.surface(&session)?;
    let unknown = |what: &str| Failure::computation(format!("{surface}: no {what}"));
    let Ok(estimate) = of(&made, &source, &body)?.0 else { return Ok(None) };
    let list = REDUCED.map(|load| load.to_string()).join(",");
    let report = contact_of(source, &format!("--statistics --p-star {list}"))?;
    let deviations = |load: &Value| {
        let p = number(load, "mean_pressure").ok_or_else(|| unknown("pressure"))?;
        let solved = solved(load).ok_or_else(|| unknown("number of a load"))?;
        let estimated = numbers(&estimate.at(p));
        let deviation = |which: usize| estimated[which].map_or(f64::NAN, |value| value / solved[which] - 1.0);
        Ok([0, 1, 2, 3, 4].map(deviation))
    };
    let band = estimate.band();
    let [ssk, sku, anisotropy, slopes] = shape(&made)?;
    let loads = loads(&report).iter().map(deviations).collect::<Result<_, Failure>>()?;
    Ok(Some(Found { ranges: [band.hurst, band.eps_f_inv, ssk, sku, anisotropy, slopes], loads }))
}

/// Returns the deviations of one number at one load; surfaces without an estimate are left out.
fn all(found: &[Found], load: usize, which: usize) -> Vec<f64> {
    found.iter().map(|found| found.loads[load][which]).filter(|deviation| deviation.is_finite()).collect()
}

/// Kind of surfaces: group, Hurst exponent, spectrum with its number of surfaces, lay, distribution of heights and
/// contrast of roughness.
#[derive(Clone, Copy)]
struct Kind {
    group: &'static str,
    hurst: f64,
    spectrum: Spectrum,
    surfaces: u64,
    aspect: f64,
    bend: f64,
    contrast: f64,
    /// Place among all kinds.
    place: u64,
}

impl Kind {
    /// Returns all kinds.
    fn all() -> Vec<Self> {
        let mut kinds = Vec::new();
        for Surfaces { name: group, count, aspects, bends, contrasts, hursts } in GROUPS {
            let spectra = || SPECTRA.into_iter().zip(count);
            let shapes = || aspects.iter().flat_map(|aspect| bends.iter().map(move |bend| (*aspect, *bend)));
            let shapes = || shapes().flat_map(|of| contrasts.iter().map(move |contrast| (of, *contrast)));
            for (hurst, (spectrum, surfaces)) in hursts.iter().flat_map(|hurst| spectra().map(move |of| (*hurst, of))) {
                for ((aspect, bend), contrast) in shapes() {
                    // Waves along the lay must fit into the cell.
                    if aspect == 1.0 || spectrum.eps_t_inv > 1 {
                        let place = kinds.len() as u64;
                        kinds.push(Self { group, hurst, spectrum, surfaces, aspect, bend, contrast, place });
                    }
                }
            }
        }
        kinds
    }

    /// Returns the flags of waves between the longest one and the longest divided by a ratio.
    fn waves(&self, ratio: usize, hurst: f64, seed: u64) -> String {
        let Spectrum { eps_t_inv, eps_f_inv, eps_c_inv, .. } = self.spectrum;
        let n = eps_c_inv * eps_t_inv * eps_f_inv;
        format!("--n {n} --eps-t-inv {eps_t_inv} --eps-f-inv {ratio} --hurst {hurst} --seed {seed}")
    }

    /// Computes the deviations of a surface of this kind.
    fn found(&self, seed: u64) -> Result<Option<Found>, Failure> {
        let Self { hurst, spectrum, aspect, bend, contrast, .. } = *self;
        let Spectrum { eps_t_inv, eps_f_inv, roll_off, .. } = spectrum;
        let rolled = roll_off.map_or_else(String::new, |length| format!(" --roll-off {length}"));
        // The lay is not along an axis.
        let lay = if aspect == 1.0 { String::new() } else { format!(" --aspect {aspect} --lay 30") };
        let surface = format!("{}{rolled}{lay}", self.waves(eps_f_inv, hurst.min(1.0), seed));
        let is_plain = bend == 0.0 && contrast == 0.0 && hurst <= 1.0;
        if is_plain {
            return found(&surface, None);
        }
        let session = Session::silent();
        let made = parsed(&surface)?.source.surface(&session)?;
        let (grid, mut heights) = (made.grid, made.heights.into_owned());
        let longest = TAU * eps_t_inv as f64 / grid.lengths()[0];
        if hurst > 1.0 {
            heights = filtered(&heights, &grid, |q| if q > 0.0 { (q / longest).powf(1.0 - hurst) } else { 1.0 })?;
        }
        if contrast > 0.0 {
            // Surfaces of all kinds have smooth parts at other places.
            let factor = self.waves(2, 0.0, 1000 * (self.place + 1) + seed);
            let factor = parsed(&factor)?.source.surface(&session)?.heights;
            let deviation = factor.std(0.0);
            let long = filtered(&heights, &grid, |q| f64::from(u8::from(q * SHORT <= longest)))?;
            // The mean square of the factor is 1.
            let factor = factor.mapv(|g| (contrast * g / deviation - contrast * contrast).exp());
            heights = (heights - &long) * factor + long;
        }
        if bend != 0.0 {
            heights = bent(&heights, bend);
        }
        found(&surface, Some(heights))
    }

    /// Returns mean and rms of the deviations of the surfaces.
    fn summary(&self, found: &[Found]) -> SurfaceKind {
        let Self { group, hurst, spectrum, aspect, bend, contrast, .. } = *self;
        let of = |which: usize, load: usize| {
            let all = all(found, load, which);
            let count = all.len() as f64;
            let mean = |sum: f64| sum / count;
            let square = all.iter().map(|deviation| deviation * deviation).sum();
            (!all.is_empty()).then(|| [mean(all.iter().sum()), mean(square).sqrt()])
        };
        let loads = |which: usize| (0..REDUCED.len()).map(|load| of(which, load)).collect();
        let of_number = |(which, name): (usize, &&str)| DeviationOfNumber { name: (*name).into(), loads: loads(which) };
        let deviations = NAMES.iter().enumerate().map(of_number).collect();
        SurfaceKind { group: group.into(), hurst, spectrum, aspect, bend, contrast, surfaces: found.len(), deviations }
    }
}

/// Returns the errors of a group of surfaces, and the ranges that they span; of skewness and kurtoses, the ranges of
/// this part of the surfaces.
fn group(name: &str, every: &[&Found], part: f64) -> Group {
    let error = |which: usize| {
        let of_load = |load: usize| every.iter().map(move |found| found.loads[load][which]).filter(|x| x.is_finite());
        (0..REDUCED.len()).map(|load| covering(COVERED, of_load(load).collect())).collect()
    };
    let range = |which: usize| {
        let values = || every.iter().map(|found| found.ranges[which]);
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    };
    // Gaussian heights of either sign are equally probable, and the others lie on one side of them.
    let skewness = range(2);
    let up_to = |which: usize| covering(part, every.iter().map(|found| found.ranges[which]).collect());
    let largest = up_to(2);
    let ssk = match skewness.map(|end| end > 0.0) {
        [false, true] => [-largest, largest],
        [false, false] => [skewness[0], 0.0],
        _ => [0.0, skewness[1]],
    };
    Group {
        name: name.into(),
        error: NAMES.iter().enumerate().map(|(which, name)| ((*name).to_owned(), error(which))).collect(),
        contacts: every.len(),
        hurst: range(0),
        eps_f_inv: range(1),
        ssk,
        sku: [range(3)[0], up_to(3)],
        anisotropy: range(4),
        slope_kurtosis: [range(5)[0], up_to(5)],
    }
}

/// Returns the magnitude that this part of the deviations do not exceed.
fn covering(part: f64, mut deviations: Vec<f64>) -> f64 {
    deviations.iter_mut().for_each(|deviation| *deviation = deviation.abs());
    deviations.sort_by(f64::total_cmp);
    let place = (part * deviations.len() as f64).ceil() as usize;
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
    let kinds = Kind::all();
    let progress = Progress::new(session, "surfaces", kinds.iter().map(|kind| kind.surfaces as usize).sum());
    let of_kind = |kind: &Kind| {
        let of_seed = |seed: u64| {
            let found = kind.found(seed);
            progress.advance(1.0, &format!("H = {}, 1/eps_f = {}", kind.hurst, kind.spectrum.eps_f_inv));
            found
        };
        let seeds = args.first_seed..args.first_seed + kind.surfaces;
        seeds.into_par_iter().filter_map(|seed| of_seed(seed).transpose()).collect::<Result<Vec<_>, Failure>>()
    };
    let found = kinds.par_iter().map(of_kind).collect::<Result<Vec<_>, Failure>>()?;
    progress.finish();
    let of_group = |Surfaces { name, contrasts, .. }: &Surfaces| {
        let of_kinds = kinds.iter().zip(&found).filter(|(kind, _)| kind.group == *name);
        let part = if contrasts.iter().all(|contrast| *contrast == 0.0) { 1.0 } else { TYPICAL };
        group(name, &of_kinds.flat_map(|(_, found)| found).collect::<Vec<_>>(), part)
    };
    let deviations = Deviations {
        p_star: REDUCED.to_vec(),
        groups: GROUPS.iter().map(of_group).collect(),
        percolation: percolation(&of_finite.kinds),
    };
    let kinds = kinds.iter().zip(&found).map(|(kind, found)| kind.summary(found)).collect();
    let report = Report { first_seed: args.first_seed, deviations, kinds };
    let text = serde_json::to_string_pretty(&report).map_err(|error| Failure::computation(error.to_string()))?;
    gfmd_files::replace(&args.out, |file| std::io::Write::write_all(file, (text + "\n").as_bytes()))?;
    Ok(report)
}

impl std::fmt::Display for Report {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "deviation in %, mean and rms, at p* = {REDUCED:?}")?;
        for SurfaceKind { group, hurst, spectrum, aspect, bend, contrast, deviations, .. } in &self.kinds {
            let Spectrum { eps_f_inv, roll_off, .. } = spectrum;
            write!(f, "{group}: H = {hurst}, 1/eps_f = {eps_f_inv}, roll-off {roll_off:?}, {aspect}, {bend}, ")?;
            writeln!(f, "{contrast}")?;
            for DeviationOfNumber { name, loads } in deviations {
                let cell = |[mean, rms]: [f64; 2]| format!("{:6.1} {:5.1}", 100.0 * mean, 100.0 * rms);
                let cells = loads.iter().map(|known| known.map_or_else(|| format!("{:>12}", "-"), cell));
                writeln!(f, "{name:>16} {}", cells.collect::<Vec<_>>().join("  "))?;
            }
        }
        let Deviations { groups, percolation: [area, spread], .. } = &self.deviations;
        for Group { name, error, contacts, hurst, eps_f_inv, ssk, sku, anisotropy, slope_kurtosis } in groups {
            writeln!(f, "95 % of {contacts} {name}")?;
            for (name, errors) in error {
                let cells = errors.iter().map(|error| format!("{:6.1}", 100.0 * error));
                writeln!(f, "{name:>16} {}", cells.collect::<Vec<_>>().join("  "))?;
            }
            writeln!(f, "H {hurst:?}, 1/eps_f {eps_f_inv:?}, Ssk {ssk:?}, Sku {sku:?}")?;
            writeln!(f, "anisotropy {anisotropy:?}, relative kurtosis of slopes {slope_kurtosis:?}")?;
        }
        writeln!(f, "percolation at {area:.4} ± {spread:.4}")
    }
}
