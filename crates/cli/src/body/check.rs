//! The check of a file of fields below a surface.

use std::path::Path;

use gfmd_files::Reader;

use super::Args;
use super::quantity::{TENSOR, TENSOR_OF_A_LINE};
use crate::check::{Comparison, parsed, words};
use crate::failure::Failure;
use crate::session::Session;

/// Compares the mean of σ_xz, σ_yz, σ_zz on every plane of a file with the mean traction on the surface.
///
/// # Errors
/// A file that cannot be read.
pub(crate) fn check(reader: &Reader, comparison: &mut Comparison) -> Result<(), Failure> {
    const MEAN: &str = "/fields/mean_traction";
    const STRESS: &str = "/fields/stress";
    // An older file has no mean traction; a row of points has another mean than its plane.
    if !reader.contains(MEAN) || !reader.contains(STRESS) || reader.text("/fields", "slice").is_ok() {
        return Ok(());
    }
    let wanted: Vec<f64> = reader.values(MEAN)?;
    let shape = reader.shape(STRESS)?;
    let (planes, components) = (shape.first().copied().unwrap_or(0), shape.last().copied().unwrap_or(0));
    let columns: Vec<&str> = match components {
        4 => TENSOR_OF_A_LINE.map(|component| TENSOR[component]).to_vec(),
        _ => TENSOR.to_vec(),
    };
    let names: &[&str] = if components == 4 { &["xz", "zz"] } else { &["xz", "yz", "zz"] };
    for plane in 0..planes {
        let stress: Vec<f64> = reader.slab(STRESS, plane)?;
        let scale = stress.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let mean = |name: &&str| {
            let column = columns.iter().position(|column| column == name).unwrap_or(0);
            let values = stress.iter().skip(column).step_by(components.max(1));
            values.sum::<f64>() / (stress.len() / components.max(1)) as f64
        };
        comparison.values("/fields/stress (mean)", &names.iter().map(mean).collect::<Vec<f64>>(), &wanted, scale);
    }
    Ok(())
}

/// Computes the fields of a file again, with the output `out`, if the displacement of the surface is at hand.
pub(crate) fn again(reader: &Reader, config: &str, out: &Path, session: &Session) -> Result<bool, Failure> {
    let input = reader.text("/input", "file").ok();
    // Waves have no file.
    if let Some(input) = input.filter(|input| !Path::new(input).exists()) {
        let text = format!("the input {input} is not there, so that the fields cannot be computed again");
        session.warn("input-missing", text);
        return Ok(false);
    }
    let mut words = words(config, &[])?;
    words.push(format!("--out={}", out.display()));
    super::run(&parsed::<Args>(&words)?, session)?;
    Ok(true)
}
