//! Memory of a viscoelastic body in a path file, used to check the pressure of the last step.

use gfmd_check::result::Comparison;
use gfmd_contact::{Contact, Load, Refusal};
use gfmd_files::{Archive, Dimension, Reader, Variable, axes, contiguous};
use gfmd_input::failure::Failure;
use gfmd_input::source::Surface;
use gfmd_medium::{Medium as _, Relaxing};
use gfmd_run::series::{Prepared, StateFile};
use ndarray::Array2;

const DISPLACEMENT: &str = "/history/displacement";
const BRANCH: &str = "/history/branch";

/// Rounding error of a displacement recomputed from the pressure, relative to the largest displacement.
const ROUNDING_OF_DISPLACEMENT: f64 = 1e-9;

/// Writes the memory of the last state.
pub(super) fn write(file: &mut StateFile, surface: &Surface, memory: &[Array2<f64>]) -> Result<(), Failure> {
    let Some(archive) = file.archive() else { return Ok(()) };
    let Some((indentation, branches)) = memory.split_first() else { return Ok(()) };
    define(archive, surface, branches.len())?;
    archive.write_rows(DISPLACEMENT, None, 0, &contiguous(indentation))?;
    for (index, field) in branches.iter().enumerate() {
        archive.write_slab(BRANCH, index, &contiguous(field))?;
    }
    Ok(())
}

/// Defines the memory, without values.
pub(super) fn lay_out(file: &mut StateFile, prepared: &Prepared) -> Result<(), Failure> {
    let medium = medium_of(prepared)?;
    let Some((archive, medium)) = file.archive().zip(medium) else { return Ok(()) };
    define(archive, &prepared.surface, medium.branches())
}

fn define(archive: &mut Archive, surface: &Surface, branches: usize) -> Result<(), Failure> {
    let unit = surface.unit();
    let [x, y] = axes(&surface.grid, unit);
    let variable = Variable {
        dimensions: &[&x, &y],
        units: unit,
        long_name: "indentation of the surface at the last step, positive downwards",
    };
    archive.define_rows(DISPLACEMENT, &variable)?;
    // The variable itself is named `branch`, hence another name for the dimension.
    let branch = Dimension::index("index", branches, "number of the branch of the relaxation");
    let variable = Variable {
        dimensions: &[&branch, &x, &y],
        units: unit,
        long_name: "elongation of the spring of each branch at the last step",
    };
    Ok(archive.define(BRANCH, &variable)?)
}

/// Returns the medium of a body that relaxes; `None` for an elastic one.
fn medium_of(prepared: &Prepared) -> Result<Option<Relaxing>, Failure> {
    let Prepared { facts, surface, body, prony: Some(prony), .. } = prepared else { return Ok(None) };
    let relaxes = facts.relaxes.unwrap_or_default();
    let medium = Relaxing::new(body, &surface.grid, facts.boundary, 1, prony, relaxes);
    medium.map(Some).map_err(|refusal| Failure::input("/surface/height", refusal))
}

/// Returns the mismatch between `pressure` and the memory of a body, zero if they belong together: the largest
/// difference between the displacement by the pressure, with the long-term moduli, and the memory, divided by the
/// largest displacement or elongation.
fn mismatch(
    Prepared { facts, surface, body, .. }: &Prepared,
    medium: &Relaxing,
    pressure: &Array2<f64>,
    memory: &[Array2<f64>],
) -> Result<f64, Refusal> {
    let contact = Contact::with_boundary(facts.boundary, body, &surface.grid, &surface.heights)?;
    let elastic = contact.certify(pressure, Load::Approach(0.0))?;
    let expected: Vec<f64> = elastic.displacement.iter().map(|u| -u).collect();
    let total = medium.long_term_indentation(memory)?;
    let largest = |values: &mut dyn Iterator<Item = f64>| {
        values.fold(0.0, |most: f64, x| if x.abs() > most || x.is_nan() { x.abs() } else { most })
    };
    let apart = largest(&mut total.iter().zip(&expected).map(|(a, b)| a - b));
    // Without pressure the body may not have recovered yet.
    let scale = largest(&mut expected.iter().chain(memory.iter().flatten()).copied());
    Ok(if apart == 0.0 { 0.0 } else { apart / scale })
}

/// Recomputes the pressure of the last step and its elastic energy, given as `stored`, from the memory.
pub(super) fn check(
    reader: &Reader,
    prepared: &Prepared,
    (pressure, displacement, stored): (&Array2<f64>, &Array2<f64>, f64),
    tolerance: f64,
    comparison: &mut Comparison,
) -> Result<(), Failure> {
    let Some(medium) = medium_of(prepared)? else { return Ok(()) };
    let points = prepared.surface.grid.points();
    let field =
        |values: Vec<f64>| Array2::from_shape_vec(points, values).map_err(|error| Failure::input("/history", error));
    let indentation = field(reader.values(DISPLACEMENT)?)?;
    let below: Vec<f64> = displacement.iter().map(|u| -u).collect();
    comparison.values(DISPLACEMENT, &contiguous(&indentation), &below, 0.0);
    let mut memory = vec![indentation];
    for index in 0..medium.branches() {
        memory.push(field(reader.slab(BRANCH, index)?)?);
    }
    let apart = mismatch(prepared, &medium, pressure, &memory);
    let apart = apart.map_err(|refusal| Failure::input("/history", refusal))?;
    comparison.at_most(BRANCH, apart, tolerance.max(ROUNDING_OF_DISPLACEMENT));
    let energy = medium.elastic_energy(&prepared.body, &memory);
    if let Some(energy) = energy.map_err(|refusal| Failure::input("/history", refusal))? {
        let apart = (energy - stored).abs() / energy.max(stored);
        let apart = if energy == stored { 0.0 } else { apart };
        comparison.at_most("/path/elastic_energy (of the last step)", apart, tolerance.max(ROUNDING_OF_DISPLACEMENT));
    }
    Ok(())
}
