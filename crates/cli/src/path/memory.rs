//! Memory of a viscoelastic body in a path file, used to check the pressure of the last step.

use gfmd_check::result::Comparison;
use gfmd_contact::{Contact, Load, Refusal};
use gfmd_files::{Archive, Dimension, Reader, Variable, axes, contiguous};
use gfmd_green::Plate;
use gfmd_input::failure::Failure;
use gfmd_input::rows;
use gfmd_input::source::Surface;
use gfmd_interface::QuasistaticState;
use gfmd_medium::{Medium as _, Relaxing};
use gfmd_problem::{AnyState, Unknown};
use gfmd_response::{PlateResponse, PlateTransforms};
use gfmd_run::series::{Prepared, StateFile};
use ndarray::Array2;

/// Beginnings of the names of the faces of a body, the upper one first.
const FACES: [&str; 2] = ["", "lower_"];

fn displacement(face: &str) -> String {
    format!("/history/{face}displacement")
}

fn branch(face: &str) -> String {
    format!("/history/{face}branch")
}

/// Rounding error of a displacement recomputed from the pressure, relative to the largest displacement.
const ROUNDING_OF_DISPLACEMENT: f64 = 1e-9;

/// Writes the memory of the last state.
pub(super) fn write(file: &mut StateFile, surface: &Surface, state: &AnyState) -> Result<(), Failure> {
    let share = &surface.share;
    for (face, state) in FACES.into_iter().zip([state.of_parts(), state.lower_of_parts()]) {
        let Some(memory) = state.and_then(QuasistaticState::memory) else { continue };
        let Some((indentation, branches)) = memory.split_first() else { continue };
        let mut archive = file.archive();
        let mut written = archive.as_mut().map_or(Ok(()), |archive| define(archive, surface, face, branches.len()));
        let places = std::iter::once((displacement(face), None, indentation))
            .chain(branches.iter().enumerate().map(|(index, field)| (branch(face), Some(index), field)));
        for (path, index, field) in places {
            let archive = archive.as_mut().filter(|_| written.is_ok()).map(|archive| &mut **archive);
            let done = rows::write(share, field.view(), archive, (&path, index), |_| {});
            written = written.and(done);
        }
        written?;
    }
    Ok(())
}

/// Defines the memory, without values.
pub(super) fn lay_out(file: &mut StateFile, prepared: &Prepared) -> Result<(), Failure> {
    let medium = medium_of(prepared)?;
    let Some((archive, medium)) = file.archive().zip(medium) else { return Ok(()) };
    faces(prepared).iter().try_for_each(|face| define(archive, &prepared.surface, face, medium.branches()))
}

/// Returns the beginnings of the names of the faces of a problem.
fn faces(prepared: &Prepared) -> &'static [&'static str] {
    if prepared.lower.is_some() { &FACES } else { &FACES[..1] }
}

fn define(archive: &mut Archive, surface: &Surface, face: &str, branches: usize) -> Result<(), Failure> {
    let unit = surface.unit();
    let [x, y] = axes(&surface.grid, unit);
    let long_name = match face {
        "" => "indentation of the surface at the last step, positive downwards",
        _ => "indentation of the lower face at the last step, positive upwards",
    };
    archive.define_rows(&displacement(face), &Variable { dimensions: &[&x, &y], units: unit, long_name })?;
    // The variable itself is named `branch`, hence another name for the dimension.
    let index = Dimension::index("index", branches, "number of the relaxation branch");
    let long_name = "spring elongation of each branch at the last step";
    Ok(archive.define(&branch(face), &Variable { dimensions: &[&index, &x, &y], units: unit, long_name })?)
}

/// Returns the medium of a body that relaxes; `None` for an elastic one.
fn medium_of(prepared: &Prepared) -> Result<Option<Relaxing>, Failure> {
    let Prepared { facts, surface, body, inelastic, .. } = prepared;
    let Some((prony, relaxes)) = &inelastic.relaxation else { return Ok(None) };
    let medium = Relaxing::new(body, &surface.grid, facts.boundary, 1, prony, *relaxes);
    let is_held = facts.unknown == Unknown::Held;
    let medium = medium.and_then(|medium| if is_held { medium.held_sideways() } else { Ok(medium) });
    medium.map(Some).map_err(|refusal| Failure::input("/surface/height", refusal))
}

/// Response of a body with its long-term moduli to the pressures on its faces.
enum Elastic {
    OneFace(Contact),
    Plate(PlateTransforms),
}

impl Elastic {
    fn of(Prepared { facts, surface, lower, body, .. }: &Prepared) -> Result<Self, Refusal> {
        let is_held = facts.unknown == Unknown::Held;
        let plate = if is_held { Plate::held_sideways } else { Plate::of };
        Ok(match lower {
            None if is_held => Self::OneFace(Contact::held_sideways(body, &surface.grid, &surface.heights)?),
            None => Self::OneFace(Contact::with_boundary(facts.boundary, body, &surface.grid, &surface.heights)?),
            Some(_) => {
                let response = PlateResponse::new(surface.grid, &plate(body)?);
                Self::Plate(PlateTransforms::of(&response.into()))
            }
        })
    }

    /// Returns the indentation by pressures, face by face, up to the level of the body.
    fn indentation(&mut self, pressures: &[&Array2<f64>]) -> Result<Vec<f64>, Refusal> {
        match self {
            Self::OneFace(contact) => {
                let elastic = contact.certify(pressures[0], Load::Approach(0.0))?;
                Ok(elastic.displacement.iter().map(|u| -u).collect())
            }
            Self::Plate(transforms) => {
                let pressure: Vec<f64> = pressures.iter().copied().flatten().copied().collect();
                let mut indentation = vec![0.0; pressure.len()];
                transforms.compliance(transforms.response().uniform_compliance(), &pressure, &mut indentation);
                Ok(indentation)
            }
        }
    }
}

/// Returns the mismatch between `pressures` and the memory of each face, zero if they belong together: the largest
/// difference between the indentation by the pressures, with the long-term moduli, and the memory, divided by the
/// largest indentation or elongation.
fn mismatch(
    prepared: &Prepared,
    medium: &Relaxing,
    pressures: &[&Array2<f64>],
    memories: &[Vec<Array2<f64>>],
) -> Result<f64, Refusal> {
    let expected = Elastic::of(prepared)?.indentation(pressures)?;
    let mut total = Vec::new();
    for memory in memories {
        total.extend(medium.long_term_indentation(memory)?);
    }
    if memories.len() > 1 {
        // Nothing holds the plate as a whole.
        let points = prepared.surface.grid.len();
        let means = [0, 1].map(|face| {
            let range = face * points..(face + 1) * points;
            total[range.clone()].iter().zip(&expected[range]).map(|(a, b)| a - b).sum::<f64>() / points as f64
        });
        let level = 0.5 * (means[0] - means[1]);
        total.iter_mut().enumerate().for_each(|(i, d)| *d -= if i < points { level } else { -level });
    }
    let largest = |values: &mut dyn Iterator<Item = f64>| {
        values.fold(0.0, |most: f64, x| if x.abs() > most || x.is_nan() { x.abs() } else { most })
    };
    let apart = largest(&mut total.iter().zip(&expected).map(|(a, b)| a - b));
    // Without pressure the body may not have recovered yet.
    let scale = largest(&mut expected.iter().chain(memories.iter().flatten().flatten()).copied());
    Ok(if apart == 0.0 { 0.0 } else { apart / scale })
}

/// Recomputes the pressure of the last step and its elastic energy, given as `stored`, from the memory; `fields` are
/// pressure and displacement of each face.
pub(super) fn check(
    reader: &Reader,
    prepared: &Prepared,
    (fields, stored): (&[[&Array2<f64>; 2]], f64),
    tolerance: f64,
    comparison: &mut Comparison,
) -> Result<(), Failure> {
    let Some(medium) = medium_of(prepared)? else { return Ok(()) };
    let points = prepared.surface.grid.points();
    let field =
        |values: Vec<f64>| Array2::from_shape_vec(points, values).map_err(|error| Failure::input("/history", error));
    let mut memories = Vec::new();
    for (face, [_, of_face]) in faces(prepared).iter().zip(fields) {
        let indentation = field(reader.values(&displacement(face))?)?;
        let below: Vec<f64> = of_face.iter().map(|u| -u).collect();
        comparison.values(&displacement(face), &contiguous(&indentation), &below, 0.0);
        let mut memory = vec![indentation];
        for index in 0..medium.branches() {
            memory.push(field(reader.slab(&branch(face), index)?)?);
        }
        memories.push(memory);
    }
    let pressures: Vec<&Array2<f64>> = fields.iter().map(|[pressure, _]| *pressure).collect();
    let apart = mismatch(prepared, &medium, &pressures, &memories);
    let apart = apart.map_err(|refusal| Failure::input("/history", refusal))?;
    comparison.at_most(&branch(""), apart, tolerance.max(ROUNDING_OF_DISPLACEMENT));
    let energy = match &memories[..] {
        [memory] => medium.elastic_energy(&prepared.body, memory),
        [upper, lower] => medium.elastic_energy_of_plate(&prepared.body, [upper, lower]).map(Some),
        _ => Ok(None),
    };
    if let Some(energy) = energy.map_err(|refusal| Failure::input("/history", refusal))? {
        let apart = (energy - stored).abs() / energy.max(stored);
        let apart = if energy == stored { 0.0 } else { apart };
        comparison.at_most("/path/elastic_energy (of the last step)", apart, tolerance.max(ROUNDING_OF_DISPLACEMENT));
    }
    Ok(())
}
