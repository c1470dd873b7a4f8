//! `prony`: Prony series fitted to storage and loss moduli.

mod figures;
mod table;

use std::fmt;
use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_medium::{DynamicModulus, FitError, PronyFit, RelaxationTimes, Wlf};
use gfmd_problem::{key, words};
use serde::{Deserialize, Serialize};

use gfmd_files::input;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_input::source::stress_unit;
use gfmd_problem::options::Options;
use gfmd_report::figures::parse_prefix;
use gfmd_unit::Units;

/// Code of the warnings about moduli that no measurement supports.
const EXTRAPOLATED: &str = "extrapolated";

/// Flags of `prony`.
#[derive(ClapArgs, Options, Clone, Debug, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd prony --dma dma.csv
  gfmd prony --dma dma.csv --branches 8 --plots rubber
  gfmd prony --dma master.csv --times 1e-6,1e-4,1e-2,1 --long-term 2.1 --json
  gfmd prony --dma sweep.csv --wlf 17.44,51.6,-60")]
pub struct Args {
    /// Table with the columns frequency, storage and loss, and temperature or log_a_t for several temperatures; heads
    /// may have units, as in `frequency (Hz), storage (MPa), loss (MPa)`. Without a unit the frequency is in Hz
    #[arg(long, required = true, value_name = "FILE", help_heading = "Measurement")]
    dma: String,
    /// Shift the frequencies of several temperatures by the Williams-Landel-Ferry equation: C1, C2 and the reference
    /// temperature T0, in the unit of the temperature column
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "C1,C2,T0",
        allow_negative_numbers = true,
        help_heading = "Measurement"
    )]
    wlf: Vec<f64>,
    /// Unit of storage and loss modulus if the heads have none
    #[arg(long, value_name = "UNIT", value_parser = stress_unit, help_heading = "Measurement")]
    stress_unit: Option<String>,
    /// Number of relaxation times, in geometric steps across the frequencies; branches of zero modulus are dropped
    /// [default: the fewest branches within 1.1 times the smallest misfit, or 1 %]
    #[arg(long, value_name = "N", conflicts_with = "times", help_heading = "Series")]
    branches: Option<usize>,
    /// Relaxation times, s
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "T1,T2,..",
        allow_negative_numbers = true,
        help_heading = "Series"
    )]
    times: Vec<f64>,
    /// Long-term modulus from another test, in the unit of the storage modulus [default: fitted]
    #[arg(long, value_name = "E", allow_negative_numbers = true, help_heading = "Series")]
    long_term: Option<f64>,
    /// Draw measured and fitted moduli, and branch moduli: PREFIX-moduli.svg, PREFIX-branches.svg, and .png
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix, help_heading = "Output")]
    plots: Option<PathBuf>,
}

/// Printed result.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name of the table.
    pub dma: String,
    /// Unit of stresses, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress_unit: Option<String>,
    /// Reference temperature of the shift, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reference_temperature: Option<f64>,
    /// Young's modulus when all has relaxed, stress.
    pub young_long_term: f64,
    /// Its standard error, stress; `null` if it was given, or without spare data.
    pub young_long_term_error: Option<f64>,
    /// Instantaneous Young's modulus, stress.
    pub young_instantaneous: f64,
    /// Pairs of relaxation time, s, and fraction of the instantaneous modulus.
    pub prony: Vec<(f64, f64)>,
    /// Branches by increasing relaxation time.
    pub branches: Vec<Branch>,
    /// Rms relative misfit of the storage modulus.
    pub storage_misfit: f64,
    /// Rms relative misfit of the loss modulus.
    pub loss_misfit: f64,
    /// Options of `path` and `slide` for a body with this series.
    pub options: String,
    /// Series that were tried.
    pub tried: Vec<Tried>,
    /// Measured points, in the order of the table.
    pub points: Vec<Measured>,
    /// Figure files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub plots: Vec<PathBuf>,
}

/// Branch of the series.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Branch {
    /// Relaxation time, s.
    pub time: f64,
    /// Modulus, stress.
    pub modulus: f64,
    /// Standard error of the modulus, stress.
    pub modulus_error: Option<f64>,
    /// Fraction of the instantaneous modulus.
    pub fraction: f64,
}

/// Series that was tried.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Tried {
    /// Number of branches.
    pub branches: usize,
    /// Rms relative misfit of both moduli.
    pub misfit: f64,
}

/// Measured point and the series there.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Measured {
    /// Temperature, as in the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub temperature: Option<f64>,
    /// Decimal logarithm of the shift factor; 0 without a shift.
    pub log_a_t: f64,
    /// Frequency times the shift factor, Hz.
    pub frequency: f64,
    /// Storage modulus, stress.
    pub storage: f64,
    /// Loss modulus, stress.
    pub loss: f64,
    /// Storage modulus of the series.
    pub fitted_storage: f64,
    /// Loss modulus of the series.
    pub fitted_loss: f64,
}

/// Runs the command.
///
/// # Errors
/// Returns an error for a table or a flag that cannot be used, and if a figure cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let refuse = |reason: String| Failure::input(key("dma"), format!("{}: {reason}", args.dma));
    let text = input::text(&args.dma).map_err(|error| refuse(error.to_string()))?;
    let table = table::read(&text).map_err(refuse)?;
    // A table of Python is not parsed as words are.
    if let Some(Err(error)) = args.stress_unit.as_deref().map(stress_unit) {
        return Err(Failure::input(key("stress_unit"), error));
    }
    if let (Some(found), Some(given)) = (&table.stress_unit, &args.stress_unit)
        && found != given
    {
        return Err(Failure::value(key("stress_unit"), given, format!("{found}, as the table has, or left out")));
    }
    let unit = table.stress_unit.clone().or_else(|| args.stress_unit.clone());
    let wlf = wlf(&args.wlf)?;
    let shifts = shifts(args, &table.rows, wlf.as_ref())?;
    let mut points = Vec::with_capacity(shifts.len());
    for (row, shift) in table.rows.iter().zip(&shifts) {
        let frequency = row.frequency * 10_f64.powf(*shift);
        if !(frequency > 0.0 && frequency.is_finite()) {
            let reason = format!("line {} has log_a_t {shift}; the shifted frequency must be positive", row.line);
            return Err(refuse(format!("{reason} and finite")));
        }
        points.push(DynamicModulus { frequency, storage: row.storage, loss: row.loss });
    }
    let times = match (args.branches, args.times.is_empty()) {
        (Some(count), _) => RelaxationTimes::Count(count),
        (None, true) => RelaxationTimes::Automatic,
        (None, false) => RelaxationTimes::Given(args.times.clone()),
    };
    let fit = PronyFit::new(&points, &times, args.long_term).map_err(|error| match error {
        FitError::Count(_) => Failure::input(key(if args.times.is_empty() { "branches" } else { "times" }), error),
        FitError::TooFew { .. } if args.branches.is_some() => Failure::input(key("branches"), error),
        FitError::TooFew { .. } | FitError::Time(_) => Failure::input(key("times"), error),
        FitError::LongTerm { .. } => Failure::input(key("long_term"), error),
        FitError::NoLongTerm => Failure::refused(words![
            key("dma"),
            format!(": {}: the best fit has no long-term modulus, and a body must have one; measure lower ", args.dma),
            "frequencies, or take the modulus of a slow test with ",
            key("long_term")
        ]),
        FitError::Point { .. } => refuse(error.to_string()),
    })?;
    fit.series().map_err(|error| refuse(error.to_string()))?;
    let units = match &unit {
        Some(unit) => Units::new(Some("m"), Some(unit)),
        None => Units::default(),
    };
    warn(session, &fit, &points, args, &units);
    let fractions = fit.fractions();
    let measured = |((row, shift), point): ((&table::Row, &f64), &DynamicModulus)| {
        let modulus = fit.modulus(point.frequency);
        Measured {
            temperature: row.temperature,
            log_a_t: *shift,
            frequency: point.frequency,
            storage: row.storage,
            loss: row.loss,
            fitted_storage: modulus.re,
            fitted_loss: modulus.im,
        }
    };
    let points: Vec<Measured> = table.rows.iter().zip(&shifts).zip(&points).map(measured).collect();
    let plots = match &args.plots {
        Some(stem) => figures::draw(stem, &points, &fit, &units)?,
        None => Vec::new(),
    };
    let branch = |(branch, (_, fraction)): (&gfmd_medium::FittedBranch, &(f64, f64))| Branch {
        time: branch.time,
        modulus: branch.modulus,
        modulus_error: branch.modulus_error,
        fraction: *fraction,
    };
    Ok(Report {
        dma: args.dma.clone(),
        reference_temperature: wlf.map(|wlf| wlf.reference()),
        young_long_term: fit.long_term,
        young_long_term_error: fit.long_term_error,
        young_instantaneous: fit.instantaneous(),
        branches: fit.branches.iter().zip(&fractions).map(branch).collect(),
        storage_misfit: fit.storage_misfit,
        loss_misfit: fit.loss_misfit,
        options: options(&fit, unit.as_deref().unwrap_or_default()),
        tried: fit.tried.iter().map(|(branches, misfit)| Tried { branches: *branches, misfit: *misfit }).collect(),
        prony: fractions,
        stress_unit: unit,
        points,
        plots,
    })
}

/// Returns the equation given as C1, C2 and T0.
fn wlf(given: &[f64]) -> Result<Option<Wlf>, Failure> {
    match given {
        [] => Ok(None),
        [c1, c2, reference] => {
            Wlf::new(*c1, *c2, *reference).map(Some).map_err(|error| Failure::input(key("wlf"), error))
        }
        _ => Err(Failure::value(key("wlf"), format!("{} numbers", given.len()), "three numbers, C1, C2 and T0")),
    }
}

/// Returns log₁₀ a_T of each row.
fn shifts(args: &Args, rows: &[table::Row], wlf: Option<&Wlf>) -> Result<Vec<f64>, Failure> {
    let refuse = |reason: String| Failure::input(key("dma"), format!("{}: {reason}", args.dma));
    let has_shifts = rows.iter().any(|row| row.log_a_t.is_some());
    let Some(wlf) = wlf else {
        let other = rows.iter().find(|row| row.temperature != rows[0].temperature);
        return match other {
            Some(row) if !has_shifts => Err(Failure::missing(
                "wlf",
                format!(
                    "the temperature of {}, line {}, differs from line {}; the shift of several temperatures is \
                     needed, or a column log_a_t",
                    args.dma, row.line, rows[0].line
                ),
            )),
            _ => Ok(rows.iter().map(|row| row.log_a_t.unwrap_or(0.0)).collect()),
        };
    };
    if has_shifts {
        let found = args.wlf.iter().map(f64::to_string).collect::<Vec<_>>().join(",");
        return Err(Failure::value(key("wlf"), found, "left out with a table that has a column log_a_t"));
    }
    let shift = |row: &table::Row| match row.temperature {
        None => Err(Failure::refused(words![
            key("dma"),
            format!(": {} has no column temperature; it must have one with ", args.dma),
            key("wlf")
        ])),
        Some(temperature) => wlf.log_shift(temperature).map_err(|error| refuse(format!("line {}: {error}", row.line))),
    };
    rows.iter().map(shift).collect()
}

/// Warns of moduli that no plateau of the data supports.
fn warn(session: &Session, fit: &PronyFit, points: &[DynamicModulus], args: &Args, units: &Units) {
    let stress = |value: f64| units.words(value, "stress");
    if args.long_term.is_none() && fit.extrapolates_slow_end(points) {
        let text = words![
            format!(
                "the storage modulus still falls at the lowest frequency, {}: the long-term modulus, {}, is an \
                 extrapolation; measure more slowly, or take the modulus of a slow test with ",
                hertz(points.iter().map(|point| point.frequency).fold(f64::INFINITY, f64::min)),
                stress(fit.long_term)
            ),
            key("long_term")
        ];
        session.warn(EXTRAPOLATED, text);
    }
    if fit.extrapolates_fast_end(points) {
        let text = format!(
            "the storage modulus still rises at the highest frequency, {}: the instantaneous modulus, {}, is an \
             extrapolation",
            hertz(points.iter().map(|point| point.frequency).fold(0.0, f64::max)),
            stress(fit.instantaneous())
        );
        session.warn(EXTRAPOLATED, text);
    }
}

/// Returns a frequency in words.
fn hertz(frequency: f64) -> String {
    format!("{} Hz", short(frequency, 4))
}

/// Formats a number with this many significant digits, very small and large ones with an exponent.
fn short(value: f64, digits: usize) -> String {
    let value = rounded(value, digits);
    if (1e-3..1e6).contains(&value) { value.to_string() } else { format!("{value:e}") }
}

/// Returns a number with this many significant digits.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits.saturating_sub(1)).parse().unwrap_or(value)
}

/// Returns the options of `path` and `slide`. Fractions have the digits that keep six digits of the long-term modulus.
fn options(fit: &PronyFit, unit: &str) -> String {
    let ratio = (fit.instantaneous() / fit.long_term).log10().ceil();
    let digits = 6 + if ratio > 0.0 { ratio as usize } else { 0 };
    let branch = |(time, fraction): (f64, f64)| format!("{}:{}", short(time, 6), short(fraction, digits.min(17)));
    let series = fit.fractions().into_iter().map(branch).collect::<Vec<_>>().join(",");
    format!("--prony {series} --moduli long-term --young {}{unit}", short(fit.long_term, 6))
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let frequencies = || self.points.iter().map(|point| point.frequency);
        let [low, high] = [frequencies().fold(f64::INFINITY, f64::min), frequencies().fold(0.0, f64::max)];
        let shifted = match self.reference_temperature {
            Some(temperature) => format!(", shifted to the temperature {temperature}"),
            None if self.points.iter().any(|point| point.log_a_t != 0.0) => ", shifted by log_a_t".into(),
            None => String::new(),
        };
        let count = self.points.len();
        let noun = if count == 1 { "point" } else { "points" };
        writeln!(f, "{}: {count} {noun}, {} Hz to {}{shifted}", self.dma, short(low, 4), hertz(high))?;
        let unit = self.stress_unit.as_deref().unwrap_or("stress");
        let [modulus, error] = ["E_i", "error"].map(|name| format!("{name} / {unit}"));
        writeln!(f, "{:>14}{modulus:>16}{error:>16}{:>12}", "tau / s", "g_i")?;
        let number = |value: Option<f64>| value.map_or_else(|| "none".into(), |value| format!("{value:.4e}"));
        for branch in &self.branches {
            let (modulus, error) = (number(Some(branch.modulus)), number(branch.modulus_error));
            writeln!(f, "{:>14}{modulus:>16}{error:>16}{:>12.6}", format!("{:.5e}", branch.time), branch.fraction)?;
        }
        let (modulus, error) = (number(Some(self.young_long_term)), number(self.young_long_term_error));
        let fraction = self.young_long_term / self.young_instantaneous;
        writeln!(f, "{:>14}{modulus:>16}{error:>16}{fraction:>12.6}", "long-term")?;
        writeln!(f, "{:>14}{:>16}", "instantaneous", number(Some(self.young_instantaneous)))?;
        let [storage, loss] = [self.storage_misfit, self.loss_misfit].map(|misfit| rounded(100.0 * misfit, 2));
        writeln!(f, "rms misfit: {storage} % of the storage modulus, {loss} % of the loss modulus")?;
        writeln!(f, "for gfmd path and gfmd slide:")?;
        writeln!(f, "{}", self.options)?;
        self.plots.iter().try_for_each(|file| writeln!(f, "wrote {}", file.display()))
    }
}
