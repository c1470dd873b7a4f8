//! `law`: tractions, Jacobian and energy of a contact law.

mod figures;

use std::fmt;
use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_law::MixedMode;
use gfmd_problem::options::LawArgs;
use gfmd_problem::{key, words};
use serde::Serialize;

use gfmd_input::failure::Failure;
use gfmd_input::source::{length_unit, stress_unit};
use gfmd_problem::options::{Kinds, Options};
use gfmd_report::figures::parse_prefix;
use gfmd_unit::Units;

/// Flags of `law`.
#[derive(ClapArgs, Options, Clone, Debug)]
#[command(after_help = "Examples:
  gfmd law --law morse --param gamma=1 --param range=0.2 --normal 0,0.1,0.4
  gfmd law --law npb --param phi_n=1 --param phi_t=0.8 --param delta_n=0.2 --param delta_t=0.3 \\
    --normal=-0.1,0.1 --tangential 0.15,0.15 --json
  gfmd law --law exponential --param gamma=1,range=0.1 --normal 0,0.5 --plot exponential
  gfmd law --law morse --unit nm --param gamma=0.05J/m^2,range=2nm --normal 0,1,5
  gfmd law --law table --law-table law.csv --normal 0,0.5 --plot table")]
pub struct Args {
    #[command(flatten)]
    law: LawArgs,
    /// Normal separations, positive for an open gap, length
    #[arg(
        long,
        required = true,
        value_delimiter = ',',
        value_name = "D1,D2,..",
        allow_negative_numbers = true,
        help_heading = "Places"
    )]
    #[option(kinds = Kinds::LENGTH)]
    normal: Vec<f64>,
    /// Tangential separations along one direction, one for each normal separation, length; default: 0
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "D1,D2,..",
        allow_negative_numbers = true,
        help_heading = "Places"
    )]
    #[option(kinds = Kinds::LENGTH)]
    tangential: Vec<f64>,
    /// Unit of lengths without one, such as nm [default: the unit of the table]
    #[arg(long, value_name = "UNIT", value_parser = length_unit, help_heading = "Interface law")]
    unit: Option<String>,
    /// Unit of stresses without one [default: the unit of the table, or Pa if a stress has a unit]
    #[arg(long, value_name = "UNIT", value_parser = stress_unit, help_heading = "Interface law")]
    stress_unit: Option<String>,
    /// Draw T_n against normal separation, one curve for each value of --tangential, and T_t against tangential
    /// separation, one curve for each value of --normal: PREFIX.svg, .png
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix, help_heading = "Output")]
    plot: Option<PathBuf>,
}

/// Printed result.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Name of the law.
    pub law: &'static str,
    /// Unit of lengths, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Unit of stresses, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress_unit: Option<String>,
    /// True if penetration is forbidden.
    pub wall: bool,
    /// Requirements R1 to R6 of docs/theory.md, section 8; `null` for a law without tangential traction.
    pub mixed_mode: Option<MixedModeRecord>,
    /// One point for each separation.
    pub points: Vec<Point>,
    /// Figure files.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub plots: Vec<PathBuf>,
}

/// Printed form of [`MixedMode`].
#[derive(Clone, Copy, Debug, Serialize)]
#[expect(missing_docs, reason = "the names are those of `MixedMode`")]
pub struct MixedModeRecord {
    pub independent_works: bool,
    pub resists_sliding: bool,
    pub keeps_repulsion: bool,
    pub holds_under_pressure: bool,
    pub vanishes: bool,
    pub continuous: bool,
}

impl From<MixedMode> for MixedModeRecord {
    fn from(properties: MixedMode) -> Self {
        let MixedMode {
            independent_works,
            resists_sliding,
            keeps_repulsion,
            holds_under_pressure,
            vanishes,
            continuous,
        } = properties;
        Self { independent_works, resists_sliding, keeps_repulsion, holds_under_pressure, vanishes, continuous }
    }
}

/// Law at one separation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// Normal separation, open > 0.
    pub normal: f64,
    /// Tangential separation.
    pub tangential: f64,
    /// T_n, T_t: attraction and drag on the elastic surface.
    pub traction: [f64; 2],
    /// Derivatives of T_n, T_t (rows) by the normal and tangential separation (columns).
    pub jacobian: [[f64; 2]; 2],
    /// Energy per area, if the law has a potential.
    pub energy: Option<f64>,
}

/// Evaluates the flags.
///
/// # Errors
/// Returns an error if a flag is out of range or a figure cannot be written.
pub fn run(args: &Args) -> Result<Report, Failure> {
    let law = args.law.build()?;
    let zeros = vec![0.0; args.normal.len()];
    let tangential = if args.tangential.is_empty() { &zeros } else { &args.tangential };
    if tangential.len() != args.normal.len() {
        let (found, wanted) = (tangential.len(), args.normal.len());
        let (has, wanted) = (format!(" has {found} values; it must have as many as "), format!(", {wanted}"));
        return Err(Failure::refused(words![key("tangential"), has, key("normal"), wanted]));
    }
    for (option, values) in [("normal", &args.normal), ("tangential", tangential)] {
        if let Some(bad) = values.iter().find(|value| !value.is_finite()) {
            return Err(Failure::value(key(option), bad, "finite"));
        }
    }
    if let Some(bad) = args.normal.iter().find(|normal| law.has_wall() && **normal < 0.0) {
        let name = args.law.law.name();
        return Err(Failure::value(key("normal"), bad, format!("at least 0, since {name} has a hard wall")));
    }
    let points = args.normal.iter().zip(tangential).map(|(&normal, &tangential)| {
        let response = law.response(normal, tangential);
        let energy = law.energy(normal, tangential);
        let numbers = response.traction.iter().chain(response.jacobian.iter().flatten()).chain(&energy);
        if let Some(bad) = numbers.into_iter().find(|number| !number.is_finite()) {
            let values = words![key("normal"), format!(" is {normal:e} and "), key("tangential")];
            let why = "traction, Jacobian and energy must be finite there, and one of them is";
            return Err(Failure::refused(words![values, format!(" {tangential:e}; {why} {bad}")]));
        }
        Ok(Point { normal, tangential, traction: response.traction, jacobian: response.jacobian, energy })
    });
    let mut report = Report {
        law: args.law.law.name(),
        unit: args.unit.clone(),
        stress_unit: args.stress_unit.clone(),
        wall: law.has_wall(),
        mixed_mode: law.mixed_mode().map(Into::into),
        points: points.collect::<Result<_, _>>()?,
        plots: Vec::new(),
    };
    if let Some(stem) = &args.plot {
        report.plots = figures::draw(stem, law.as_ref(), (&args.normal, tangential), &report.units())?;
    }
    Ok(report)
}

impl Report {
    fn units(&self) -> Units {
        Units::new(self.unit.as_deref(), self.stress_unit.as_deref())
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{}{}", self.law, if self.wall { ", with a hard wall" } else { "" })?;
        if let Some(properties) = self.mixed_mode {
            let MixedModeRecord {
                independent_works: r1,
                resists_sliding: r2,
                keeps_repulsion: r3,
                holds_under_pressure: r4,
                vanishes: r5,
                continuous: r6,
            } = properties;
            let [r1, r2, r3, r4, r5, r6] = [r1, r2, r3, r4, r5, r6].map(|holds| if holds { "yes" } else { "no" });
            writeln!(f, "R1 independent works: {r1}; R2 resists sliding: {r2}; R3 keeps repulsion: {r3};")?;
            writeln!(f, "R4 holds under pressure: {r4}; R5 vanishes: {r5}; R6 continuous: {r6}")?;
        }
        let heads =
            ["normal", "tangential", "T_n", "T_t", "dT_n/dD_n", "dT_n/dD_t", "dT_t/dD_n", "dT_t/dD_t", "energy"];
        writeln!(f, "{}", heads.map(|head| format!("{head:>13}")).concat())?;
        if self.unit.is_some() || self.stress_unit.is_some() {
            let units = self.units();
            let [length, stress, slope, energy] =
                ["length", "stress", "stress/length", "stress*length"].map(|kind| units.name(kind));
            let row = [&length, &length, &stress, &stress, &slope, &slope, &slope, &slope, &energy];
            writeln!(f, "{}", row.map(|unit| format!("{unit:>13}")).concat())?;
        }
        for Point { normal, tangential, traction: [tn, tt], jacobian: [[nn, nt], [tn_n, tt_t]], energy } in &self.points
        {
            let numbers = [normal, tangential, tn, tt, nn, nt, tn_n, tt_t].map(|number| format!("{number:>13.5e}"));
            let energy = energy.map_or_else(|| "none".into(), |energy| format!("{energy:.5e}"));
            writeln!(f, "{}{energy:>13}", numbers.concat())?;
        }
        self.plots.iter().try_for_each(|file| writeln!(f, "wrote {}", file.display()))
    }
}
