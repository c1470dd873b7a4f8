//! Report of the punch in a file.

use gfmd_check::result::{Configuration, ResultKind};
use gfmd_field::Grid;
use gfmd_files::{FileError, Reader};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_mixed::MixedSolution;
use gfmd_run::convergence::NotConverged;
use gfmd_run::trace::Trace;
use ndarray::Array3;

use super::{Args, Prepared, Refinement, Report};

/// Reads the report of the punch in a file. Nothing is solved: all numbers come from the file or follow from its
/// fields.
///
/// # Errors
/// Returns an error if the file is not a result of a punch, or if its problem cannot be read from it.
pub fn stored(reader: &Reader, session: &Session) -> Result<Report, Failure> {
    let refuse = |error: FileError| Failure::refused(error.to_string());
    let text = reader.text("/", "config").map_err(refuse)?;
    let config = Configuration::read::<Args>(ResultKind::Punch, &text)?;
    let args = problem(reader, &config, &[])?;
    let prepared = Prepared::new(&args, session)?;
    let grid = &prepared.grids[0];
    let number = |name: &str| -> Result<f64, Failure> {
        let values = reader.values::<f64>(&format!("/punch/{name}")).map_err(refuse)?;
        Ok(values.first().copied().unwrap_or(f64::NAN))
    };
    let solution = MixedSolution {
        displacement: field(reader, "displacement", grid)?,
        traction: field(reader, "traction", grid)?,
        residual: number("residual")?,
        iterations: number("iterations")? as u64,
        transform_pairs: number("transform_pairs")?,
    };
    let report = prepared.measure(&args, grid, &prepared.points(grid), &solution, number("seconds")?);
    Ok(Report {
        refinement: Refinement::read(reader).map_err(refuse)?,
        not_converged: NotConverged::read(reader),
        history: Trace::read(reader).map_err(refuse)?,
        ..report
    })
}

/// Reads the problem without some keys. The points under the punch and the traction beside it are taken from the file,
/// where they stand as they were used.
pub(super) fn problem(reader: &Reader, config: &Configuration, except: &[String]) -> Result<Args, Failure> {
    let stored = [("mask", "/fields/under_punch"), ("traction", "/fields/traction")];
    let named = stored.into_iter().filter(|(key, _)| config.has(key));
    let named = named.map(|(key, path)| (key.into(), format!("{}:{path}", reader.path().display()).into()));
    config.problem(except, named.collect())
}

/// Reads a field of a surface as `[component, x, y]`.
pub(super) fn field(reader: &Reader, name: &str, grid: &Grid) -> Result<Array3<f64>, Failure> {
    let path = format!("/fields/{name}");
    let values: Vec<f64> = reader.values(&path).map_err(|error| Failure::refused(error.to_string()))?;
    let ([nx, ny], components) = (grid.points(), values.len() / grid.len());
    let field = Array3::from_shape_vec((nx, ny, components), values).map_err(|error| Failure::input(path, error))?;
    Ok(field.permuted_axes([2, 0, 1]).as_standard_layout().into_owned())
}
