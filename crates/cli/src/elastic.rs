//! The elastic body, from flags.

use std::ops::RangeInclusive;

use clap::Args;
use gfmd_field::Grid;
use gfmd_green::{Body, GreenError, Height, Material};
use serde::Serialize;

use crate::failure::{Failure, SIZES, check_size};

/// Flags that describe the elastic body.
#[derive(Args, Clone, Debug, Serialize)]
pub struct BodyArgs {
    /// Young's modulus, stress
    #[arg(long, default_value_t = 1.0, value_name = "E", allow_negative_numbers = true)]
    pub young: f64,
    /// Poisson's ratio, above -1 and up to 0.5
    #[arg(long, default_value_t = 0.0, value_name = "NU", allow_negative_numbers = true)]
    pub poisson: f64,
    /// Contact modulus E* = E/(1 - NU^2), in place of --young
    #[arg(long, value_name = "E*", conflicts_with = "young", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub e_star: Option<f64>,
    /// Height of the slab, bonded to a rigid base; "inf" for a half-space
    #[arg(long, default_value = "inf", value_name = "ZM", value_parser = parse_height, allow_negative_numbers = true)]
    #[serde(serialize_with = "serialize_height")]
    pub height: Height,
}

impl BodyArgs {
    /// Makes the body.
    ///
    /// # Errors
    /// A flag out of its range.
    pub fn body(&self) -> Result<Body, Failure> {
        let material = match self.e_star {
            Some(modulus) => Material::from_contact_modulus(modulus, self.poisson),
            None => Material::from_young(self.young, self.poisson),
        };
        let (flag, modulus) = self.e_star.map_or(("--young", self.young), |e_star| ("--e-star", e_star));
        if modulus.is_finite() && modulus > 0.0 {
            check_size(flag, modulus)?;
        }
        material.and_then(|material| Body::new(material, self.height)).map_err(|error| {
            let flag = match &error {
                GreenError::Young(_) => "--young",
                GreenError::ContactModulus(_) => "--e-star",
                GreenError::Poisson(_) => "--poisson",
                _ => "--height",
            };
            Failure::input(flag, error)
        })
    }
}

impl BodyArgs {
    /// Checks the body against a surface on `grid` that is pressed on it: the height of a slab over the sides of the
    /// cell, and the `unit` of pressures, E* times the rms gradient.
    ///
    /// # Errors
    /// A slab so thin or so high, or a unit so small or so large, that digits are lost.
    pub fn check_on(&self, grid: &Grid, unit: f64) -> Result<(), Failure> {
        if let Height::Finite(height) = self.height
            && let Some(side) = sides(grid).iter().find(|side| !HEIGHTS.contains(&(height / **side)))
        {
            let allowed = format!("between 1e-12 and 1e12 times the cell length {side:e}, or inf");
            return Err(Failure::value("--height", format!("{height:e}"), allowed));
        }
        let flag = if self.e_star.is_some() { "--e-star" } else { "--young" };
        // A flat surface is judged by what uses it.
        if SIZES.contains(&unit) || unit == 0.0 {
            return Ok(());
        }
        let reason = format!("E* times the rms gradient is {unit:e}; it must be between 1e-140 and 1e140");
        Err(Failure::input(flag, reason + ", which another unit of stress makes it"))
    }
}

/// The sides of the cell: two, or one of a profile.
pub fn sides(grid: &Grid) -> Vec<f64> {
    grid.lengths()[..if grid.is_line() { 1 } else { 2 }].to_vec()
}

/// The heights of a slab over the sides of the cell whose stiffnesses are computed without loss of digits.
pub const HEIGHTS: RangeInclusive<f64> = 1e-12..=1e12;

/// Flags that describe the elastic body of an input file. A property without a flag is taken from the configuration that
/// the file records.
#[derive(Args, Clone, Debug)]
pub struct RecordedBodyArgs {
    /// Young's modulus, stress; default, as of the flags below: the value that the input records
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    young: Option<f64>,
    /// Poisson's ratio, above -1 and up to 0.5
    #[arg(long, value_name = "NU", allow_negative_numbers = true)]
    poisson: Option<f64>,
    /// Contact modulus E* = E/(1 - NU^2), in place of --young
    #[arg(long, value_name = "E*", conflicts_with = "young", allow_negative_numbers = true)]
    e_star: Option<f64>,
    /// Height of the slab, bonded to a rigid base; "inf" for a half-space
    #[arg(long, value_name = "ZM", value_parser = parse_height, allow_negative_numbers = true)]
    height: Option<Height>,
}

impl RecordedBodyArgs {
    /// Takes each property from its flag or else from `record`, the configuration of a run.
    ///
    /// # Errors
    /// A property that neither has.
    pub fn over(&self, record: &toml::Table) -> Result<BodyArgs, Failure> {
        let recorded = |key: &str| record.get(key).and_then(|value| value.as_float());
        let needed = |flag: &str| {
            Failure::Input(format!("{flag} is missing; it is needed because the input does not record it"))
        };
        let height = match record.get("height").and_then(toml::Value::as_str) {
            Some("inf") => Some(Height::Infinite),
            _ => recorded("height").map(Height::Finite),
        };
        let e_star = self.e_star.or_else(|| if self.young.is_none() { recorded("e_star") } else { None });
        let young = match (self.young.or_else(|| recorded("young")), e_star) {
            (Some(young), _) => young,
            (None, Some(_)) => 1.0, // not used
            (None, None) => return Err(needed("--young")),
        };
        Ok(BodyArgs {
            young,
            poisson: self.poisson.or_else(|| recorded("poisson")).ok_or_else(|| needed("--poisson"))?,
            e_star,
            height: self.height.or(height).ok_or_else(|| needed("--height"))?,
        })
    }
}

/// Parses a height: a length, or `inf`.
///
/// # Errors
/// Text that is neither.
pub fn parse_height(text: &str) -> Result<Height, String> {
    if text == "inf" {
        return Ok(Height::Infinite);
    }
    text.parse().map(Height::Finite).map_err(|_| "it must be a length or \"inf\"".into())
}

/// Writes a height to TOML or JSON: a number, or the text `inf`.
///
/// # Errors
/// An error of the serialiser.
pub fn serialize_height<S: serde::Serializer>(height: &Height, serializer: S) -> Result<S::Ok, S::Error> {
    match height {
        Height::Finite(height) => serializer.serialize_f64(*height),
        Height::Infinite => serializer.serialize_str("inf"),
    }
}
