//! The check of the file of steady sliding.

use std::path::Path;

use gfmd_contact::{Boundary, Fields as _, Load};
use gfmd_files::{Reader, contiguous};
use gfmd_run::failure::Failure;
use gfmd_run::result::{
    Comparison, Configuration, Kind, compare_heights, layout, regenerated, repeated_problem, stored_problem,
};
use gfmd_run::session::Session;
use ndarray::Array2;

use super::file::{FIELDS, SCALARS, StatesFile};
use super::report::State;
use super::{Args, Way};

/// The scalars that the pressure does not determine.
const OF_THE_SEARCH: [&str; 3] = ["iterations", "transform_pairs", "seconds"];

/// Recomputes all states from their pressures.
pub(crate) fn check(
    reader: &Reader,
    config: &Configuration,
    comparison: &mut Comparison,
    session: &Session,
) -> Result<(), Failure> {
    compare_heights(reader, comparison)?;
    let args: Args = stored_problem(reader, config)?;
    regenerated(reader, config, Boundary::Periodic, comparison, session)?;
    let mut way = Way::new(&args, session)?;
    way.prepared.take_units(reader);
    let (way, count) = (&way, way.states().count());
    layout(Kind::Slide, reader, comparison, |output| {
        let provenance = session.provenance(args.config()?);
        StatesFile::new(output, &provenance, &way.prepared, count)?.finish(&[], count)
    })?;
    let columns = SCALARS.iter().map(|(name, ..)| Ok(reader.values::<f64>(&format!("/states/{name}"))?));
    let columns = columns.collect::<Result<Vec<_>, Failure>>()?;
    let height = way.sliding.contact().surface().rms_height();
    for (index, (load, velocity)) in way.states().enumerate() {
        let slab = |name: &str| -> Result<Vec<f64>, Failure> { Ok(reader.slab(&format!("/fields/{name}"), index)?) };
        let pressure = slab("pressure")?;
        if pressure.iter().any(|p| !p.is_finite()) {
            continue;
        }
        let pressure = Array2::from_shape_vec(way.prepared.surface.grid.points(), pressure);
        let pressure = pressure.map_err(|error| Failure::input("/fields/pressure", error))?;
        let state = way.sliding.certify(velocity, &pressure, load);
        let state = state.map_err(|refusal| Failure::input("/fields/pressure", refusal))?;
        let solution = &state.solution;
        for ((name, ..), field) in FIELDS.iter().zip([&solution.pressure, &solution.displacement, &solution.gap]) {
            // The gap of full contact is what rounding leaves.
            let floor = if *name == "gap" { height } else { 0.0 };
            comparison.values(&format!("/fields/{name}"), &slab(name)?, &contiguous(field), floor);
        }
        let persson = way.sliding.persson(velocity, solution.mean_pressure);
        let record = State::new(velocity, &state, persson, (&way.prepared.scales(), args.tol), f64::NAN);
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
        if record.converged {
            comparison.at_most(&format!("residual of state {index}"), state.worst(), args.tol);
        }
        // The load is met to the tolerance.
        if let Load::MeanPressure(asked) = load {
            let apart = (solution.mean_pressure - asked).abs() / asked;
            comparison.at_most(&format!("load of state {index}"), apart, args.tol);
        }
    }
    Ok(())
}

/// Runs the configuration of a file again, with the output `out`.
pub(crate) fn again(reader: &Reader, config: &Configuration, out: &Path, session: &Session) -> Result<bool, Failure> {
    let args: Args = repeated_problem(reader, config)?;
    super::run(&Args { out: Some(out.into()), ..args }, session)?;
    Ok(true)
}
