//! `estimate`: numbers of a rough contact from spectrum and highest points, without solving a contact, each with its
//! measured error.

mod deviations;

use std::collections::BTreeMap;
use std::fmt;

use clap::Args as ClapArgs;
use gfmd_measure::theory::{Estimate, Estimated, Persson, Summits, UnlikeSpectrum};
use gfmd_problem::{key, words};
use gfmd_record::{Importance, Printed, Sheet};
use gfmd_surface::{Areal, Direction, PowerSpectrum, SurfaceError};
use gfmd_unit::Units;
use serde::{Deserialize, Serialize};

use crate::loads::PressingArgs;
use crate::session::{print_note, print_sheet};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_input::source::{SourceArgs, Surface};
use gfmd_problem::options::BodyArgs;
use gfmd_problem::options::{Kinds, Options};

pub use deviations::{Deviations, Errors, Group};

/// Flags of `estimate`.
#[derive(ClapArgs, Options, Clone, Debug, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd estimate --surface scan.sur --detrend plane --periodise mirror --young 70GPa --pressure 10MPa
  gfmd estimate --n 512 --hurst 0.8 --unit um --size 100um --young 70GPa --poisson 0.33 --pressure 1MPa:1GPa:7
  gfmd estimate --n 256 --hurst 0.5 --p-star 0.02 --hardness 0.2 --json")]
pub struct Args {
    #[command(flatten)]
    #[serde(flatten)]
    source: SourceArgs,
    #[command(flatten)]
    #[serde(flatten)]
    body: BodyArgs,
    #[command(flatten)]
    #[serde(flatten)]
    loads: PressingArgs,
    /// Hardness: largest pressure that the surfaces carry, stress, for the plasticity index
    #[arg(long, value_name = "P", allow_negative_numbers = true, help_heading = "Contact")]
    #[option(kinds = Kinds::HARDNESS)]
    hardness: Option<f64>,
}

/// Printed result.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub n: [usize; 2],
    pub size: [f64; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress_unit: Option<String>,
    pub surface: String,
    pub rms_height: f64,
    pub rms_gradient: f64,
    pub e_star: f64,
    /// Name of the body's material, and the source of its values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Name of the second body's material, and the source of its values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_material: Option<String>,
    /// Equivalent band of the spectrum; `null` without one.
    pub hurst: Option<f64>,
    pub eps_f_inv: Option<f64>,
    /// E* times the rms gradient, divided by the hardness.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plasticity_index: Option<f64>,
    pub percolation_area_fraction: f64,
    pub percolation_area_fraction_error: f64,
    /// Measured surfaces from which the errors are known; absent if none are like this surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measured: Option<&'static str>,
    pub loads: Vec<Load>,
}

/// Numbers of one load, each with its error: 95 % of the solved contacts deviate by less.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Load {
    pub p_star: f64,
    pub mean_pressure: f64,
    pub area_fraction: Option<f64>,
    pub area_fraction_error: Option<f64>,
    pub mean_gap: Option<f64>,
    pub mean_gap_error: Option<f64>,
    pub stiffness: Option<f64>,
    pub stiffness_error: Option<f64>,
    pub rms_pressure: Option<f64>,
    pub rms_pressure_error: Option<f64>,
    pub max_pressure: Option<f64>,
    pub max_pressure_error: Option<f64>,
    /// Area fraction of percolation less the area fraction.
    pub percolation_distance: Option<f64>,
    pub percolation_distance_error: Option<f64>,
    /// Reasons for missing values, with the names of the numbers.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub undefined: BTreeMap<String, Vec<&'static str>>,
}

/// Names of the numbers with a measured error.
pub const NAMES: [&str; 5] = ["area_fraction", "mean_gap", "stiffness", "rms_pressure", "max_pressure"];

/// Returns the numbers of [`NAMES`].
pub fn numbers(estimated: &Estimated) -> [Option<f64>; 5] {
    let Estimated { area_fraction, mean_gap, stiffness, rms_pressure, max_pressure } = *estimated;
    [Some(area_fraction), Some(mean_gap), Some(stiffness), Some(rms_pressure), max_pressure]
}

/// Largest part of the mean square slope at the seam; half of it is the relative error of the area.
const SEAM: f64 = 0.05;

/// Reason for a missing peak.
const NO_PEAK: &str = "the cell has less than one patch of high pressure";

/// Runs the command.
///
/// # Errors
/// Returns an error for unusable input, a flat surface, a profile, and a body that is not a half-space.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    args.loads.given()?;
    if let Some(hardness) = args.hardness.filter(|hardness| !(*hardness > 0.0 && hardness.is_finite())) {
        return Err(Failure::value(key("hardness"), hardness, "positive and finite"));
    }
    let surface = args.source.surface(session)?;
    let (estimate, e_star) = of(&surface, &args.source, &args.body)?;
    let Some(measured) = Deviations::measured() else {
        return Err(Failure::computation("the measured deviations of the estimates cannot be read"));
    };
    let (rms_gradient, grid) = (surface.rms_gradient(), surface.grid);
    let loads = args.loads.reduced(e_star * rms_gradient, &grid)?;
    let [area, area_error] = measured.percolation;
    let band = estimate.as_ref().ok().map(Estimate::band);
    let known = known(estimate.as_ref(), &surface, measured)?;
    Ok(Report {
        measured: known.as_ref().ok().map(|(_, errors)| errors.group.name.as_str()),
        n: grid.points(),
        size: grid.lengths(),
        unit: surface.unit.clone(),
        stress_unit: surface.stress_unit.clone(),
        rms_height: surface.moments().rms_height(),
        surface: surface.description,
        rms_gradient,
        e_star,
        material: args.body.material.clone(),
        second_material: args.body.second_material.clone(),
        hurst: band.map(|band| band.hurst),
        eps_f_inv: band.map(|band| band.eps_f_inv),
        plasticity_index: args.hardness.map(|hardness| e_star * rms_gradient / hardness),
        percolation_area_fraction: area,
        percolation_area_fraction_error: area_error,
        loads: loads.iter().map(|p_star| at(&known, measured, *p_star, e_star * rms_gradient)).collect(),
    })
}

/// Returns the estimate of a surface on a body, or why its spectrum has none, and the contact modulus.
///
/// # Errors
/// Returns an error for a flat surface, a profile, and a body that is not a half-space.
pub fn of(
    surface: &Surface,
    source: &SourceArgs,
    body: &BodyArgs,
) -> Result<(Result<Estimate, UnlikeSpectrum>, f64), Failure> {
    body.check_modulus(surface.unit.as_deref())?;
    let (elastic, grid) = (body.body()?, surface.grid);
    let e_star = elastic.contact_modulus();
    body.check_on(&grid, e_star * surface.rms_gradient())?;
    if grid.is_line() {
        let reason = words![source.name(), " is a profile; an estimate needs a surface, [nx, ny]"];
        return Err(Failure::refused(reason));
    }
    let longest = std::f64::consts::TAU / grid.lengths().into_iter().fold(0.0, f64::max);
    if !(elastic.total_height().is_infinite()
        && (elastic.normal_stiffness(longest) / (0.5 * e_star * longest) - 1.0).abs() < 1e-9)
    {
        let reason = "the body is not a half-space; an estimate needs one, without slabs and layers (gfmd contact \
                      computes other bodies)";
        return Err(Failure::refused(reason));
    }
    let spectrum = PowerSpectrum::of(&surface.heights, &grid).map_err(|error| Failure::refused(error.to_string()))?;
    let waves = grid.modes().zip(spectrum.power()).filter(|(mode, _)| !mode.is_uniform());
    let waves = waves.map(|(mode, power)| (mode.wavenumber(), mode.weight * power));
    let flat = || Failure::refused(format!("{} is flat; it must be rough for an estimate", source.name()));
    let persson = Persson::new(waves, |q| elastic.normal_stiffness(q)).ok_or_else(flat)?;
    let summits = Summits::of(surface.heights.view(), grid.spacing()).ok_or_else(flat)?;
    let estimate = Estimate::new(persson, grid.lengths().iter().product());
    Ok((estimate.map(|estimate| estimate.with_summits(summits)), e_star))
}

/// Returns skewness and kurtosis of the heights, the anisotropy of their mean square slopes, and the kurtosis of the
/// slopes relative to Gaussian ones.
///
/// # Errors
/// Returns an error for heights that do not fit the grid.
pub fn shape(surface: &Surface) -> Result<[f64; 4], Failure> {
    let refused = |error: SurfaceError| Failure::refused(error.to_string());
    let found = Areal::of(&surface.heights, &surface.grid).map_err(refused)?;
    let spectrum = PowerSpectrum::of(&surface.heights, &surface.grid).map_err(refused)?;
    let direction = Direction::of(&spectrum, None);
    let summits = Summits::of(surface.heights.view(), surface.grid.spacing());
    let slopes = summits.map(|summits| summits.slope_kurtosis());
    Ok([found.ssk, found.sku, direction.anisotropy, slopes].map(|number| number.unwrap_or(f64::NAN)))
}

/// Returns the part of the mean square slope by which steps across the periodic seam exceed those inside.
fn seam_share(surface: &Surface) -> f64 {
    let (seam, points, spacing) = (surface.statistics.seam, surface.grid.points(), surface.grid.spacing());
    let of_axes = [0, 1].map(|axis| {
        let [across, inside] = [seam.across, seam.inside].map(|step| (step[axis] / spacing[axis]).powi(2));
        [(across - inside).max(0.0) / points[axis] as f64, inside]
    });
    let [excess, inside] = [0, 1].map(|which| of_axes.iter().map(|of| of[which]).sum::<f64>());
    excess / (excess + inside)
}

/// Returns the estimate of a surface that is like the measured ones with its errors, or the reason why it is not.
fn known<'a>(
    estimate: Result<&'a Estimate, &UnlikeSpectrum>,
    surface: &Surface,
    measured: &'static Deviations,
) -> Result<Result<(&'a Estimate, Errors<'static>), String>, Failure> {
    let (heights, seam) = (shape(surface)?, seam_share(surface));
    Ok(match estimate {
        Err(unlike) => Err(unlike.to_string()),
        Ok(_) if seam > SEAM => Err(format!(
            "{:.0} % of the mean square slope are steps across the periodic seam, and the errors are known for \
             surfaces that repeat",
            100.0 * seam
        )),
        Ok(estimate) => measured.like(estimate.band(), heights).map(|errors| (estimate, errors)),
    })
}

/// Returns the numbers of a load; `unit` is the unit of reduced pressures.
fn at(known: &Result<(&Estimate, Errors), String>, measured: &Deviations, p_star: f64, unit: f64) -> Load {
    let mean_pressure = p_star * unit;
    let known = known.clone().map(|(estimate, errors)| (numbers(&estimate.at(mean_pressure)), errors));
    let mut undefined: BTreeMap<String, Vec<_>> = BTreeMap::new();
    let mut number = |which: usize| {
        let found = known.clone().and_then(|(numbers, errors)| {
            let error = errors.of(NAMES[which], p_star)?;
            let value = numbers[which].ok_or(NO_PEAK)?;
            Ok([value, error * value])
        });
        match found {
            Ok([value, error]) => [Some(value), Some(error)],
            Err(reason) => {
                undefined.entry(reason).or_default().push(NAMES[which]);
                [None, None]
            }
        }
    };
    let [area, gap, stiffness, rms, most] = [0, 1, 2, 3, 4].map(&mut number);
    let [percolating, spread] = measured.percolation;
    let without_area = undefined.values_mut().find(|names| names.contains(&NAMES[0]));
    without_area.into_iter().for_each(|names| names.push("percolation_distance"));
    Load {
        p_star,
        mean_pressure,
        area_fraction: area[0],
        area_fraction_error: area[1],
        mean_gap: gap[0],
        mean_gap_error: gap[1],
        stiffness: stiffness[0],
        stiffness_error: stiffness[1],
        rms_pressure: rms[0],
        rms_pressure_error: rms[1],
        max_pressure: most[0],
        max_pressure_error: most[1],
        percolation_distance: area[0].map(|area| percolating - area),
        percolation_distance_error: area[1].map(|error| error.hypot(spread)),
        undefined,
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = Units::new(self.unit.as_deref(), self.stress_unit.as_deref());
        writeln!(f, "{}", self.surface)?;
        let [height, modulus] = [units.words(self.rms_height, "length"), units.words(self.e_star, "stress")];
        writeln!(f, "rms height {height}, rms gradient {:.4}, E* {modulus}", self.rms_gradient)?;
        if let Some(material) = &self.material {
            writeln!(f, "material: {material}")?;
        }
        if let Some(material) = &self.second_material {
            writeln!(f, "material of the second body: {material}")?;
        }
        if let (Some(hurst), Some(ratio)) = (self.hurst, self.eps_f_inv) {
            writeln!(f, "the spectrum is like a self-affine one with H = {hurst:.2} and 1/eps_f = {ratio:.1}")?;
        }
        if let Some(index) = self.plasticity_index {
            writeln!(f, "plasticity index E* g/hardness {index:.4}")?;
        }
        let [area, error] = [self.percolation_area_fraction, self.percolation_area_fraction_error];
        writeln!(f, "contacts percolate at the area fraction {area:.3} ± {error:.3}")?;
        writeln!(f)?;
        let relative = |value: Option<f64>, error: Option<f64>, text: &dyn Fn(f64) -> String| {
            value.zip(error).map_or_else(
                || "-".to_owned(),
                |(value, error)| format!("{} ± {:.2} %", text(value), 100.0 * error / value),
            )
        };
        let mut columns = Vec::new();
        let mut column = |word: &str, importance, cell: &dyn Fn(&Load) -> String| {
            let cells = std::iter::once(word.to_owned()).chain(self.loads.iter().map(cell)).collect();
            columns.push(Printed { word: word.to_owned(), cells, importance });
        };
        column("p*", Importance::Main, &|load| format!("{:.4}", load.p_star));
        column("mean pressure", Importance::Main, &|load| rounded(&units, load.mean_pressure, "stress"));
        column("area fraction", Importance::Main, &|load| {
            relative(load.area_fraction, load.area_fraction_error, &|value| format!("{value:.4}"))
        });
        column("mean gap", Importance::Usual, &|load| {
            relative(load.mean_gap, load.mean_gap_error, &|value| rounded(&units, value, "length"))
        });
        column("stiffness", Importance::Usual, &|load| {
            relative(load.stiffness, load.stiffness_error, &|value| rounded(&units, value, "stress/length"))
        });
        column("rms pressure", Importance::Detail, &|load| {
            relative(load.rms_pressure, load.rms_pressure_error, &|value| rounded(&units, value, "stress"))
        });
        column("max pressure", Importance::Usual, &|load| {
            relative(load.max_pressure, load.max_pressure_error, &|value| rounded(&units, value, "stress"))
        });
        column("to percolation", Importance::Detail, &|load| {
            load.percolation_distance
                .zip(load.percolation_distance_error)
                .map_or_else(|| "-".to_owned(), |(distance, error)| format!("{distance:.3} ± {error:.3}"))
        });
        print_sheet(f, |width| Sheet::of(columns, width), 0, |_| String::new(), |_| String::new())?;
        let reasons: BTreeMap<_, _> = self.loads.iter().flat_map(|load| &load.undefined).collect();
        for (reason, names) in reasons {
            print_note(f, &format!("no {}: {reason}", names.join(", ")))?;
        }
        if self.loads.iter().all(|load| load.area_fraction.is_none()) {
            return Ok(());
        }
        let like = self.measured.map_or_else(String::new, |name| format!(" of {name}"));
        print_note(
            f,
            &format!(
                "±: 95 % of solved contacts{like} deviate by less (docs/estimate.md); elastic contact, no friction or \
                 adhesion"
            ),
        )
    }
}

/// Formats a number with three digits and its unit.
fn rounded(units: &Units, value: f64, kind: &str) -> String {
    let value = format!("{value:.2e}").parse().unwrap_or(value);
    units.words(value, kind)
}
