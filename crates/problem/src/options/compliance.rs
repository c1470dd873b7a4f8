//! A body that is known by its compliance.

use clap::Args;
use gfmd_field::Grid;
use gfmd_green::{Body, GreenError, Height};
use serde::{Deserialize, Serialize};

use super::BodyArgs;
use super::law::LONGEST_TABLE;
use crate::options::{Kinds, Options};
use crate::{Facts, Support, Unusable, key, words};

/// Flags of a body that is known by its compliance.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Body")]
pub struct ComplianceArgs {
    /// Normal compliance of the body, in place of its moduli: FILE with the columns wavenumber (rad/length) and
    /// compliance (length/stress), or qx, qy and compliance for an anisotropic body; column heads may have units; or
    /// rows WAVENUMBER:COMPLIANCE,.. or QX:QY:COMPLIANCE,.. E* of --young or --e-star then only defines p*
    #[arg(long, value_parser = Row::parse, value_delimiter = ',', value_name = "FILE|ROWS", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::COMPLIANCE)]
    pub compliance: Vec<Row>,
    /// Compliance of the mean level with --compliance, length/stress; default: 0, a fixed mean level as on a half-space
    #[arg(long, value_name = "G0", requires = "compliance", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::list(&[&["length/stress"]]))]
    pub uniform_compliance: Option<f64>,
}

/// A row of a table of compliances.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Row {
    /// Wavenumber (rad/length) and compliance (length/stress).
    Wavenumber([f64; 2]),
    /// Both components of the wave vector, and the compliance.
    WaveVector([f64; 3]),
}

impl Row {
    /// Parses a row `A:B` or `A:B:C`.
    ///
    /// # Errors
    /// Returns an error for any other text.
    pub fn parse(text: &str) -> Result<Self, String> {
        let numbers: Result<Vec<f64>, _> = text.split(':').map(|number| number.trim().parse()).collect();
        match numbers.as_deref() {
            Ok(&[q, g]) => Ok(Self::Wavenumber([q, g])),
            Ok(&[x, y, g]) => Ok(Self::WaveVector([x, y, g])),
            _ => Err("it must be FILE, or rows Q:G, or rows QX:QY:G".into()),
        }
    }
}

/// The longest table by wave vector.
const LONGEST_BY_DIRECTION: usize = 20_000;

/// The key of the table.
const TABLE: &str = "compliance";

/// Rounding of wavenumbers at the ends of a table.
const ROUNDING: f64 = 1e-9;

impl ComplianceArgs {
    /// The keys of these flags in a configuration.
    pub const NAMES: [&'static str; 2] = ["compliance", "uniform_compliance"];

    /// Returns the body of the flags `args`, or of the table if one is given.
    ///
    /// # Errors
    /// Returns an error if a flag is out of range or meaningless beside a table, or the modulus for p* is missing.
    pub fn body(&self, args: &BodyArgs) -> Result<Body, Unusable> {
        let own = args.body()?;
        if self.compliance.is_empty() {
            let uniform = self.uniform_compliance.map(|found| {
                Unusable::value(
                    key("uniform_compliance"),
                    format!("{found:e}"),
                    words!["left out without ", key("compliance")],
                )
            });
            return uniform.map_or(Ok(own), Err);
        }
        let without = |option: &'static str, found: &dyn std::fmt::Display| {
            let allowed = words!["left out with ", key("compliance"), ", which describes the whole body"];
            Err(Unusable::value(key(option), found, allowed))
        };
        if let Height::Finite(height) = args.height {
            return without("height", &height);
        }
        if args.poisson != 0.0 {
            return without("poisson", &args.poisson);
        }
        if args.others.second_body.is_some() {
            return without("second_body", &"given");
        }
        if args.young.is_none() && args.e_star.is_none() {
            return Err(Unusable::of(words![
                key("young"),
                " or ",
                key("e_star"),
                " is missing; p* and kappa are divided by E*, which a table of compliances does not have",
            ]));
        }
        self.tabulated(own.contact_modulus())
    }

    fn tabulated(&self, contact_modulus: f64) -> Result<Body, Unusable> {
        let (mut by_wavenumber, mut by_direction) = (Vec::new(), Vec::new());
        for row in &self.compliance {
            match row {
                Row::Wavenumber(row) => by_wavenumber.push(*row),
                Row::WaveVector(row) => by_direction.push(*row),
            }
        }
        if !by_wavenumber.is_empty() && !by_direction.is_empty() {
            return Err(Unusable::input(
                key(TABLE),
                "some rows have two numbers and some three; all must have the same",
            ));
        }
        let uniform = self.uniform_compliance.unwrap_or(0.0);
        let (rows, most) = match by_direction.is_empty() {
            true => (by_wavenumber.len(), LONGEST_TABLE),
            false => (by_direction.len(), LONGEST_BY_DIRECTION),
        };
        if rows > most {
            return Err(Unusable::value(key(TABLE), format!("{rows} rows"), format!("at most {most}")));
        }
        let body = match by_direction.is_empty() {
            true => Body::tabulated(contact_modulus, &by_wavenumber, uniform),
            false => Body::tabulated_by_direction(contact_modulus, &by_direction, uniform),
        };
        body.map_err(|error| {
            let of_uniform = matches!(error, GreenError::UniformCompliance(_));
            Unusable::input(key(if of_uniform { "uniform_compliance" } else { TABLE }), error)
        })
    }

    /// Returns the facts of a problem with this body instead of its own.
    #[must_use]
    pub fn of(&self, facts: Facts) -> Facts {
        if self.compliance.is_empty() { facts } else { Facts { support: Support::Table, ..facts } }
    }
}

/// Checks that the table of a body covers the wavenumbers of a grid.
///
/// # Errors
/// Returns an error if wavenumbers lie outside the table.
pub fn check_wavenumbers(body: &Body, grid: &Grid) -> Result<(), Unusable> {
    let Some([low, high]) = body.tabulated_wavenumbers() else { return Ok(()) };
    let sides = if grid.is_line() { 1 } else { 2 };
    let lengths = &grid.lengths()[..sides];
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let shortest = grid.spacing()[..sides].iter().map(|step| (std::f64::consts::PI / step).powi(2)).sum::<f64>().sqrt();
    let wanted = [2.0 * std::f64::consts::PI / longest, shortest];
    let holds = low <= wanted[0] * (1.0 + ROUNDING) && wanted[1] <= high * (1.0 + ROUNDING);
    if holds {
        return Ok(());
    }
    let [from, to] = wanted;
    let found = format!("the table has the wavenumbers {low:.4e} to {high:.4e}");
    Err(Unusable::input(
        key(TABLE),
        format!("{found}; it must have the wavenumbers of the grid, {from:.4e} to {to:.4e}"),
    ))
}
