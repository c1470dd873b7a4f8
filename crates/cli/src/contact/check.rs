//! The check of the file of a contact.

use std::path::Path;

use gfmd_contact::{Boundary, Contact, Load};
use gfmd_files::Reader;
use gfmd_interface::Interface;
use gfmd_law::Kind;
use gfmd_measure::{Column, Scales};
use gfmd_response::NormalResponse;
use ndarray::Array2;

use super::{Args, Prepared};
use crate::check::{Comparison, flags_again, parsed, stored_surface, words};
use crate::failure::Failure;
use crate::load::{LoadRecord, Recorded, columns};
use crate::session::Session;
use crate::source::{SourceArgs, Surface};

/// The scalars that the fields do not determine: the effort, and the way to the state.
const OF_THE_SOLVE: [&str; 5] = ["iterations", "transform_pairs", "seconds", "passed_instability", "lowest_curvature"];

/// Recomputes every load of a file from its surface, body and pressure, or gap: fields, residuals, area, energy.
pub(crate) fn check(
    reader: &Reader,
    config: &str,
    comparison: &mut Comparison,
    session: &Session,
) -> Result<(), Failure> {
    let mut flags = stored_surface(reader, comparison)?;
    flags.extend(words(config, &SourceArgs::names())?);
    let args: Args = parsed(&flags)?;
    let prepared = Prepared::new(&args, session)?;
    let Prepared { surface, body, law, controls, .. } = &prepared;
    let refuse = |error: gfmd_contact::Refusal| Failure::input("/surface/height", error);
    let scales = Scales { contact_modulus: body.contact_modulus(), rms_gradient: surface.rms_gradient() };
    let field = |name: &str, index: usize| -> Result<Array2<f64>, Failure> {
        let values = reader.slab(&format!("/fields/{name}"), index)?;
        let [nx, ny] = surface.grid.points();
        Array2::from_shape_vec((nx, ny), values).map_err(|error| Failure::input("/fields", error))
    };
    let solved = |field: &Array2<f64>| field.iter().all(|value| value.is_finite());
    let count = reader.shape("/loads/mean_pressure")?.first().copied().unwrap_or(0);
    if count != controls.len() {
        comparison
            .differ("/loads/mean_pressure", format!("it has {count} loads; the configuration has {}", controls.len()));
    }
    let needed = if args.law.law == Kind::HardWall { "/fields/pressure" } else { "/fields/gap" };
    if args.fields.is_some() && !reader.contains(needed) {
        session.warn(
            "fields-missing",
            format!("the file has no {needed}, from which loads are recomputed; --rerun solves them"),
        );
        return Ok(());
    }
    let tolerance = args.solver.tol;
    if args.law.law == Kind::HardWall {
        let contact = match surface.boundary {
            Boundary::Periodic => Contact::on(NormalResponse::new(surface.grid, body), &surface.heights),
            Boundary::Free => Contact::bounded(Boundary::Free, body, &surface.grid, &surface.heights),
        };
        let contact = match args.hardness {
            Some(hardness) => contact.and_then(|contact| contact.with_hardness(hardness)),
            None => contact,
        };
        let contact = contact.map_err(refuse)?;
        for (index, load) in controls.iter().enumerate().take(count) {
            let pressure = field("pressure", index)?;
            if solved(&pressure) {
                let state = contact.certify(&pressure, *load).map_err(refuse)?;
                compare(reader, index, *load, &state, &scales, tolerance, surface, false, comparison)?;
            }
        }
        return Ok(());
    }
    let response = NormalResponse::new(surface.grid, body);
    let interface = Interface::on(response, &surface.heights, std::sync::Arc::clone(law)).map_err(refuse)?;
    for (index, load) in controls.iter().enumerate().take(count) {
        let gap = field("gap", index)?;
        if solved(&gap) {
            let state = interface.certify(&gap, (*load).into()).map_err(refuse)?;
            compare(reader, index, *load, &state, &scales, tolerance, surface, true, comparison)?;
        }
    }
    Ok(())
}

#[expect(clippy::too_many_arguments, reason = "one call for each kind of contact")]
fn compare<S: Recorded>(
    reader: &Reader,
    index: usize,
    load: Load,
    state: &S,
    scales: &Scales,
    tolerance: f64,
    surface: &Surface,
    with_law: bool,
    comparison: &mut Comparison,
) -> Result<(), Failure> {
    let fields = [
        ("/fields/pressure", state.pressure().iter().copied().collect::<Vec<f64>>()),
        ("/fields/displacement_z", state.displacement_z().iter().copied().collect()),
        ("/fields/gap", state.gap().iter().copied().collect()),
    ];
    let depth = state.plastic().map(|plastic| ("/fields/plastic_depth", plastic.depth.iter().copied().collect()));
    for (path, values) in fields.iter().chain(&depth).filter(|(path, _)| reader.contains(path)) {
        comparison.values(path, &reader.slab::<f64>(path, index)?, values, 0.0);
    }
    let record = LoadRecord::measure(state, scales, tolerance, f64::NAN).bounded(surface.boundary, &surface.grid);
    for Column { name, value, .. } in columns(with_law, surface.boundary, depth.is_some())
        .iter()
        .filter(|column| !OF_THE_SOLVE.contains(&column.name))
    {
        let path = format!("/loads/{name}");
        let stored: Vec<f64> = reader.values(&path)?;
        // Residuals are small beside 1, and rounding makes them.
        let floor = if name.starts_with("residual_") { 1e-3 } else { 0.0 };
        let stored = stored.get(index).copied().unwrap_or(f64::NAN);
        comparison.number(&path, stored, value(&record), floor);
        if *name == "converged" && stored == 1.0 {
            comparison.at_most(&format!("residual of load {index}"), state.worst(), tolerance);
        }
    }
    if let Load::Approach(asked) = load {
        comparison.number("/loads/displacement", asked, record.displacement, 0.0);
    }
    Ok(())
}

/// Runs the configuration of a file again, with the output `out`.
pub(crate) fn again(reader: &Reader, config: &str, out: &Path, session: &Session) -> Result<bool, Failure> {
    let words = flags_again(reader, config, out)?;
    super::run(&parsed::<Args>(&words)?, session)?;
    Ok(true)
}
