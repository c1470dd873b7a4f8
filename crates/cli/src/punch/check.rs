//! The check of the file of a punch.

use std::path::PathBuf;

use gfmd_mixed::MixedError;
use gfmd_record::{Column, Origin, Punch};

use super::stored::{self, problem};
use super::{Args, Prepared, Refinement, by_point};
use crate::checking::{Checked, Checking};
use gfmd_check::result::Comparison;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;

impl Checked for Args {
    /// Recomputes displacement, residual and scalars from the stored traction.
    fn check(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
        let Checking { reader, config, session, .. } = checking;
        // The file holds the coarsest grid.
        let args = problem(reader, config, &["refine".into()])?;
        let prepared = Prepared::new(&args, session)?;
        let grid = &prepared.grids[0];
        let problem = prepared.problem(&args, grid)?;
        let traction = stored::field(reader, "traction", grid)?;
        let refuse = |error: MixedError| Failure::input("/fields/traction", error);
        let solution = problem.certify(&traction).map_err(refuse)?;
        let displacement: Vec<f64> = reader.values("/fields/displacement")?;
        comparison.values("/fields/displacement", &displacement, &by_point(&solution.displacement), 0.0);
        let points = prepared.points(grid);
        let under: Vec<f64> = points.iter().map(|under| f64::from(u8::from(*under))).collect();
        comparison.values("/fields/under_punch", &reader.values::<f64>("/fields/under_punch")?, &under, 0.0);
        let mut report = prepared.measure(&args, grid, &points, &solution, f64::NAN);
        report.refinement = Refinement::read(reader)?;
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

    fn repeated(Checking { reader, config, .. }: Checking) -> Result<Option<Self>, Failure> {
        problem(reader, config, &[]).map(Some)
    }

    fn write(self, out: PathBuf, session: &Session) -> Result<(), Failure> {
        super::run(&Self { out: Some(out), ..self }, session).map(|_| ())
    }
}
