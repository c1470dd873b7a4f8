//! The elastic body, from flags.

use clap::Args;
use gfmd_green::{Body, GreenError, Height, Material};
use serde::Serialize;

use crate::failure::Failure;

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
    /// The body.
    ///
    /// # Errors
    /// A flag out of its range.
    pub fn body(&self) -> Result<Body, Failure> {
        let material = match self.e_star {
            Some(modulus) => Material::from_contact_modulus(modulus, self.poisson),
            None => Material::from_young(self.young, self.poisson),
        };
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

/// A positive length, or `inf`.
///
/// # Errors
/// Text that is neither.
pub fn parse_height(text: &str) -> Result<Height, String> {
    if text == "inf" {
        return Ok(Height::Infinite);
    }
    text.parse().map(Height::Finite).map_err(|_| format!("a length or \"inf\" is allowed, found {text:?}"))
}

/// As TOML and JSON write it: a number, or the text `inf`.
///
/// # Errors
/// What the serialiser reports.
pub fn serialize_height<S: serde::Serializer>(height: &Height, serializer: S) -> Result<S::Ok, S::Error> {
    match height {
        Height::Finite(height) => serializer.serialize_f64(*height),
        Height::Infinite => serializer.serialize_str("inf"),
    }
}
