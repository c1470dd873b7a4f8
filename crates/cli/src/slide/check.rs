//! The check of the file of steady sliding.

use std::path::PathBuf;

use gfmd_check::result::Comparison;
use gfmd_contact::{Boundary, Load};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_record::Origin;
use gfmd_relax::worst;

use super::file::{StatesFile, fields};
use super::{Args, SlideInput};
use crate::checking::{Checked, Checking};

impl Checked for Args {
    /// Recomputes all states from their pressures.
    fn check(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
        let Checking { reader, session, .. } = checking;
        let args: Self = checking.problem(|_: &Self| Boundary::Periodic, comparison)?;
        let mut input = SlideInput::new(&args, session)?;
        input.prepared.take_units(reader);
        let (input, count) = (&input, input.states().count());
        checking.layout(comparison, |output| {
            let provenance = session.provenance(String::new());
            StatesFile::new(output, &provenance, &input.prepared, input.facts(), count)?.finish(&[], count)
        })?;
        let height = input.sliding.contact().surface().rms_height();
        for (index, at) in input.states().enumerate() {
            let slab =
                |name: &str| -> Result<Vec<f64>, Failure> { Ok(reader.slab(&format!("/fields/{name}"), index)?) };
            let pressure = slab("pressure")?;
            if pressure.iter().any(|p| !p.is_finite()) {
                continue;
            }
            let is_shared = input.heat.is_some_and(|heat| heat.is_shared());
            let reached = input.certify(at, pressure, is_shared.then(|| slab("heat_flux")).transpose()?)?;
            for name in fields(input.facts()).map(|field| field.name) {
                // The gap of full contact is what rounding leaves.
                let floor = if name == "gap" { height } else { 0.0 };
                comparison.values(&format!("/fields/{name}"), &slab(name)?, &reached.field(name), floor);
            }
            let record = input.record(at, &reached, args.search.tolerance, f64::NAN, Vec::new());
            for (column, cell) in record.cells().filter(|(column, _)| (column.in_file)(&input.facts())) {
                if matches!(column.origin, Origin::Way | Origin::Clock | Origin::Grid) {
                    continue;
                }
                let floor = match (column.origin, column.name) {
                    (Origin::Residual, _) => 1e-3,
                    (_, "mean_gap") => height,
                    _ => 0.0,
                };
                let path = format!("/states/{}", column.name);
                let stored: Vec<f64> = reader.values(&path)?;
                comparison.number(&path, stored.get(index).copied().unwrap_or(f64::NAN), cell.number(), floor);
            }
            if record.is("converged") {
                let heat = record.value("heat_residual").unwrap_or(0.0);
                comparison.at_most(
                    &format!("residual of state {index}"),
                    worst([record.worst(), heat]),
                    args.search.tolerance,
                );
            }
            // The load is met to the tolerance.
            if let Load::MeanPressure(asked) = at.0 {
                let apart = (reached.state.solution.mean_pressure - asked).abs() / asked;
                comparison.at_most(&format!("load of state {index}"), apart, args.search.tolerance);
            }
        }
        Ok(())
    }

    fn write(self, out: PathBuf, session: &Session) -> Result<(), Failure> {
        super::run(&Self { out: Some(out), ..self }, session).map(|_| ())
    }
}
