//! Figures.
use crate::failure::Failure;
use std::path::{Path, PathBuf};
/// x
pub fn contact(
    _: &Path,
    _: &crate::contact::Report,
    _: &gfmd_field::Grid,
    _: &ndarray::Array2<f64>,
) -> Result<Vec<PathBuf>, Failure> {
    Ok(vec![])
}
/// x
pub fn sweep(
    _: &Path,
    _: &crate::kappa_sweep::Config,
    _: &crate::kappa_sweep::Plan,
    _: &[Vec<crate::load::LoadRecord>],
    _: &crate::kappa_sweep::Analysis,
    _: &crate::kappa_sweep::Example,
) -> Result<Vec<PathBuf>, Failure> {
    Ok(vec![])
}
