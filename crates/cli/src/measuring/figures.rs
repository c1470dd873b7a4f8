//! Maps of the measurements of one state.

use std::path::{Path, PathBuf};

use gfmd_files::contiguous;
use gfmd_flow::Flow;
use gfmd_input::failure::Failure;
use gfmd_input::source::Surface;
use gfmd_plot::{Below, Scale};
use gfmd_record::patches;
use gfmd_report::figures::{Drawn, field, named};
use ndarray::ArrayView2;

/// Smallest flux drawn, relative to the largest.
const LEAST_FLUX: f64 = 1e-8;

/// Draws the patches of the points with a `repulsion` as `PREFIX-patches`; a profile has no map.
///
/// # Errors
/// Returns an error if the files cannot be written.
pub(crate) fn draw_patches(
    prefix: &Path,
    surface: &Surface,
    repulsion: ArrayView2<f64>,
) -> Result<Vec<PathBuf>, Failure> {
    if surface.grid.is_line() {
        return Ok(Vec::new());
    }
    let found = patches(repulsion, surface.boundary);
    // Patches with successive numbers get distant colours, in steps of the golden section.
    let colour =
        |label: &u32| if *label == 0 { 0.0 } else { 0.05 + 0.95 * (f64::from(*label) * 0.618_033_988_75).fract() };
    let values: Vec<f64> = found.labels.iter().map(colour).collect();
    let title = format!("{} patches, told apart by colour", found.patches.len());
    let mut drawn = field(&surface.grid, &values, &title, surface.unit());
    if let Drawn::Map(map) = &mut drawn {
        map.below = Some(Below::pale(0.0, "no contact"));
        (map.range, map.bar) = (Some([0.0, 1.0]), false);
    }
    drawn.save(&named(prefix, "patches"))
}

/// Draws the flux of a `flow` as `PREFIX-flow` on a logarithmic scale: along x, or along y if it is the only one.
///
/// # Errors
/// Returns an error if the files cannot be written.
pub(crate) fn draw_flow(prefix: &Path, surface: &Surface, flow: &Flow) -> Result<Vec<PathBuf>, Failure> {
    let Some(path) = flow.paths.iter().flatten().next() else { return Ok(Vec::new()) };
    let axis = if flow.paths[0].is_some() { "x" } else { "y" };
    let values = contiguous(&path.flux);
    let highest = values.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
    let least = (LEAST_FLUX * highest).max(f64::MIN_POSITIVE);
    let mut drawn = field(&surface.grid, &values, &format!("flux along *{axis}*"), surface.unit());
    if let Drawn::Map(map) = &mut drawn {
        map.below = Some(Below::pale(least, "none"));
        (map.scale, map.range) = (Scale::Log, Some([least, highest.max(2.0 * least)]));
    }
    drawn.save(&named(prefix, "flow"))
}
