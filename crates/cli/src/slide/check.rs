//! The check of the file of steady sliding.

use std::path::PathBuf;

use gfmd_contact::{Boundary, Fields as _, Load};
use gfmd_relax::worst;
use gfmd_run::failure::Failure;
use gfmd_run::result::Comparison;
use gfmd_run::session::Session;

use super::file::{OF_HEAT, SCALARS, StatesFile, fields};
use super::report::State;
use super::{Args, Way};
use crate::checking::{Checked, Checking};

/// The scalars that the pressure does not determine.
const OF_THE_SEARCH: [&str; 3] = ["iterations", "transform_pairs", "seconds"];

impl Checked for Args {
    /// Recomputes all states from their pressures.
    fn check(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
        let Checking { reader, session, .. } = checking;
        let args: Self = checking.problem(|_: &Self| Boundary::Periodic, comparison)?;
        let mut way = Way::new(&args, session)?;
        way.prepared.take_units(reader);
        let (way, count) = (&way, way.states().count());
        checking.layout(comparison, |output| {
            let provenance = session.provenance(String::new());
            StatesFile::new(output, &provenance, &way.prepared, way.heat.as_ref(), count)?.finish(&[], count)
        })?;
        let column = |name: &str| Ok::<_, Failure>(reader.values::<f64>(&format!("/states/{name}"))?);
        let columns = SCALARS.iter().map(|(name, ..)| column(name)).collect::<Result<Vec<_>, Failure>>()?;
        let of_heat =
            OF_HEAT.iter().filter(|_| way.heat.is_some()).map(|(name, .., value)| Ok((name, column(name)?, value)));
        let of_heat = of_heat.collect::<Result<Vec<_>, Failure>>()?;
        let height = way.sliding.contact().surface().rms_height();
        let names = fields(way.heat.as_ref());
        for (index, at) in way.states().enumerate() {
            let slab =
                |name: &str| -> Result<Vec<f64>, Failure> { Ok(reader.slab(&format!("/fields/{name}"), index)?) };
            let pressure = slab("pressure")?;
            if pressure.iter().any(|p| !p.is_finite()) {
                continue;
            }
            let is_shared = way.heat.is_some_and(|heat| heat.is_shared());
            let reached = way.certify(at, pressure, is_shared.then(|| slab("heat_flux")).transpose()?)?;
            for (name, ..) in &names {
                // The gap of full contact is what rounding leaves.
                let floor = if *name == "gap" { height } else { 0.0 };
                comparison.values(&format!("/fields/{name}"), &slab(name)?, &reached.field(name), floor);
            }
            let (state, solution) = (&reached.state, &reached.state.solution);
            let persson = way.sliding.persson(at.1, solution.mean_pressure);
            let record = State::new(at.1, &reached, persson, (&way.prepared.scales(), args.search.tol), f64::NAN);
            for ((name, .., value), column) in SCALARS.iter().zip(&columns) {
                if OF_THE_SEARCH.contains(name) {
                    continue;
                }
                let floor = match *name {
                    "residual" => 1e-3,
                    "mean_gap" => height,
                    _ => 0.0,
                };
                let stored = column.get(index).copied().unwrap_or(f64::NAN);
                comparison.number(&format!("/states/{name}"), stored, value(&record), floor);
            }
            for (name, column, value) in &of_heat {
                let stored = column.get(index).copied().unwrap_or(f64::NAN);
                let floor = if **name == "heat_residual" { 1e-3 } else { 0.0 };
                comparison.number(
                    &format!("/states/{name}"),
                    stored,
                    record.heat.as_ref().map_or(f64::NAN, value),
                    floor,
                );
            }
            if record.converged {
                let heat = record.heat.map_or(0.0, |heat| heat.residual);
                comparison.at_most(
                    &format!("residual of state {index}"),
                    worst([state.worst(), heat]),
                    args.search.tol,
                );
            }
            // The load is met to the tolerance.
            if let Load::MeanPressure(asked) = at.0 {
                let apart = (solution.mean_pressure - asked).abs() / asked;
                comparison.at_most(&format!("load of state {index}"), apart, args.search.tol);
            }
        }
        Ok(())
    }

    fn write(self, out: PathBuf, session: &Session) -> Result<(), Failure> {
        super::run(&Self { out: Some(out), ..self }, session).map(|_| ())
    }
}
