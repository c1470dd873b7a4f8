//! The check of the file of a punch.

use std::path::PathBuf;

use gfmd_mixed::MixedError;
use gfmd_record::{Column, Origin, Punch};
use ndarray::Array3;

use super::{Args, Prepared, by_point};
use crate::checking::{Checked, Checking};
use gfmd_check::result::Comparison;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;

impl Checked for Args {
    /// Recomputes displacement, residual and scalars from the stored traction.
    fn check(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
        let Checking { reader, session, .. } = checking;
        // The file holds the coarsest grid.
        let args = problem(checking, &["refine".into()])?;
        let prepared = Prepared::new(&args, session)?;
        let grid = &prepared.grids[0];
        let problem = prepared.problem(&args, grid)?;
        let [nx, ny] = grid.points();
        let values: Vec<f64> = reader.values("/fields/traction")?;
        let components = values.len() / grid.len();
        let traction = Array3::from_shape_vec((nx, ny, components), values);
        let traction = traction.map_err(|error| Failure::input("/fields/traction", error))?.permuted_axes([2, 0, 1]);
        let refuse = |error: MixedError| Failure::input("/fields/traction", error);
        let solution = problem.certify(&traction.as_standard_layout().into_owned()).map_err(refuse)?;
        let displacement: Vec<f64> = reader.values("/fields/displacement")?;
        comparison.values("/fields/displacement", &displacement, &by_point(&solution.displacement), 0.0);
        let points = prepared.points(grid);
        let under: Vec<f64> = points.iter().map(|under| f64::from(u8::from(*under))).collect();
        comparison.values("/fields/under_punch", &reader.values::<f64>("/fields/under_punch")?, &under, 0.0);
        let report = prepared.measure(&args, grid, &points, &solution, f64::NAN);
        let is_checked = |column: &Column<Punch>| !matches!(column.origin, Origin::Way | Origin::Clock);
        let facts = prepared.facts();
        for (column, cell) in
            report.numbers.cells().filter(|(column, _)| is_checked(column) && (column.in_file)(&facts))
        {
            let path = format!("/punch/{}", column.name);
            let stored = reader.values::<f64>(&path)?.first().copied().unwrap_or(f64::NAN);
            let floor = if column.origin == Origin::Residual { 1e-3 } else { 0.0 };
            comparison.number(&path, stored, cell.number(), floor);
            if column.name == "converged" && stored == 1.0 {
                comparison.at_most("residual", report.numbers.number("residual"), args.search.tolerance);
            }
        }
        checking.layout(comparison, |output| prepared.write(output, &args, session, &report, &solution))
    }

    fn repeated(checking: Checking) -> Result<Option<Self>, Failure> {
        problem(checking, &[]).map(Some)
    }

    fn write(self, out: PathBuf, session: &Session) -> Result<(), Failure> {
        super::run(&Self { out: Some(out), ..self }, session).map(|_| ())
    }
}

/// The problem without some keys. The points under the punch and the traction beside it are taken from the file, where
/// they stand as they were used.
fn problem(Checking { reader, config, .. }: Checking, except: &[String]) -> Result<Args, Failure> {
    let stored = [("mask", "/fields/under_punch"), ("traction", "/fields/traction")];
    let named = stored.into_iter().filter(|(key, _)| config.has(key));
    let named = named.map(|(key, path)| (key.into(), format!("{}:{path}", reader.path().display()).into()));
    config.problem(except, named.collect())
}
