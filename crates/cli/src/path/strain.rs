//! Plastic strain below the surface in a path file, used to check the last step.

use gfmd_check::result::Comparison;
use gfmd_check::series::Stored;
use gfmd_contact::{Drive, Fields as _};
use gfmd_files::{Archive, Dimension, FileError, Reader, Variable, axes};
use gfmd_input::failure::Failure;
use gfmd_input::source::Surface;
use gfmd_interface::{Quasistatic as _, Step};
use gfmd_plasticity::{Cell, PlasticState, PlasticStrain, YieldingContact};
use gfmd_problem::AnyState;
use gfmd_problem::options::Plasticity;
use gfmd_record::{Measured, Record, StateContext};
use gfmd_run::series::{Prepared, StateFile, StiffnessArgs};
use ndarray::{Array2, Array3};

use super::course::leak;

/// Components of a deviatoric strain; their squares add to ε:ε.
const COMPONENTS: [&str; 5] = ["sqrt(3/2) zz", "(xx - yy) / sqrt(2)", "sqrt(2) xy", "sqrt(2) xz", "sqrt(2) yz"];

/// Plastic strain at the end of the last step, and before it.
const ENDS: [(&str, &str); 2] = [("", "after the last step"), ("_before", "before the last increment")];

/// Writes the cells, and the plastic strain of the last state and of the state before it.
pub(super) fn write(file: &mut StateFile, surface: &Surface, state: &PlasticState) -> Result<(), Failure> {
    let Some(archive) = file.archive() else { return Ok(()) };
    write_cells(archive, surface, state.cells())?;
    for ((end, when), plastic) in ENDS.into_iter().zip([&state.plastic, &state.plastic_before]) {
        let of_cell = |number: usize| (state.strain_of(plastic, number), state.equivalent_of(plastic, number));
        write_strain(archive, surface, state.cells(), (end, when), of_cell)?;
    }
    Ok(())
}

/// Defines the cells and the plastic strain, without values that count.
pub(super) fn lay_out(file: &mut StateFile, prepared: &Prepared) -> Result<(), Failure> {
    let Prepared { plasticity: Some(plasticity), body, surface, .. } = prepared else { return Ok(()) };
    let Some(archive) = file.archive() else { return Ok(()) };
    let cells = plasticity.cells(body, &surface.grid)?;
    write_cells(archive, surface, &cells)?;
    for end in ENDS {
        let of_cell = |number: usize| {
            let [nx, ny] = cells[number].grid(&surface.grid).points();
            (Array3::zeros((COMPONENTS.len(), nx, ny)), Array2::zeros((nx, ny)))
        };
        write_strain(archive, surface, &cells, end, of_cell)?;
    }
    Ok(())
}

fn write_cells(archive: &mut Archive, surface: &Surface, cells: &[Cell]) -> Result<(), FileError> {
    let cell = Dimension::index("cell", cells.len(), "number of the cell below the surface");
    let unit = surface.unit();
    let [thicknesses, depths, coarsenings]: [Vec<f64>; 3] = [
        cells.iter().map(|cell| cell.thickness).collect(),
        cells.iter().map(|cell| cell.depth).collect(),
        cells.iter().map(|cell| cell.coarsening as f64).collect(),
    ];
    for (name, units, values, long_name) in [
        ("thickness", unit, thicknesses, "thickness of the cell"),
        ("depth", unit, depths, "depth of the bottom of the cell"),
        ("coarsening", "1", coarsenings, "grid step of the cell divided by the grid step of the surface"),
    ] {
        archive.write(&format!("/cells/{name}"), &Variable { dimensions: &[&cell], units, long_name }, &values)?;
    }
    Ok(())
}

/// Writes the plastic strain of all cells, each on its own grid.
fn write_strain(
    archive: &mut Archive,
    surface: &Surface,
    cells: &[Cell],
    (end, when): (&str, &str),
    of_cell: impl Fn(usize) -> (Array3<f64>, Array2<f64>),
) -> Result<(), FileError> {
    let component = Dimension::labels("component", &COMPONENTS, "component of a deviatoric strain");
    for (number, cell) in cells.iter().enumerate() {
        let [mut x, mut y] = axes(&cell.grid(&surface.grid), surface.unit());
        if cell.coarsening > 1 {
            [&mut x, &mut y].into_iter().for_each(|axis| axis.name = format!("{}_{}", axis.name, cell.coarsening));
        }
        let (strain, equivalent) = of_cell(number);
        let flat: Vec<f64> = strain.iter().copied().collect();
        let long_name = format!("plastic strain of cell {number} {when}");
        let variable = Variable { dimensions: &[&component, &x, &y], units: "1", long_name: &long_name };
        archive.write(&format!("/plastic/strain{end}_{number}"), &variable, &flat)?;
        let flat: Vec<f64> = equivalent.iter().copied().collect();
        let long_name = format!("equivalent plastic strain of cell {number} {when}");
        let variable = Variable { dimensions: &[&x, &y], units: "1", long_name: &long_name };
        archive.write(&format!("/plastic/equivalent{end}_{number}"), &variable, &flat)?;
    }
    Ok(())
}

/// Reads the plastic strain at one end of the last step.
fn read(reader: &Reader, contact: &YieldingContact, end: &str) -> Result<PlasticStrain, Failure> {
    let wrong = |error: &dyn std::fmt::Display| Failure::input("/plastic", error.to_string());
    let grid = *contact.surface().grid();
    let (mut strains, mut equivalents) = (Vec::new(), Vec::new());
    for (number, cell) in contact.cells().iter().enumerate() {
        let [nx, ny] = cell.grid(&grid).points();
        let values = |name: &str| reader.values::<f64>(&format!("/plastic/{name}{end}_{number}"));
        let strain = Array3::from_shape_vec((COMPONENTS.len(), nx, ny), values("strain")?);
        strains.push(strain.map_err(|error| wrong(&error))?);
        let equivalent = Array2::from_shape_vec((nx, ny), values("equivalent")?);
        equivalents.push(equivalent.map_err(|error| wrong(&error))?);
    }
    contact.plastic_strain(&strains, &equivalents).map_err(|error| wrong(&error))
}

/// Recomputes the last step from its pressure and its plastic strain.
pub(super) fn check(
    stored: &Stored,
    (step, place): (usize, usize),
    drive: Drive,
    stiffness: StiffnessArgs,
    comparison: &mut Comparison,
) -> Result<(), Failure> {
    let Prepared { plasticity: Some(Plasticity { hardening, cells }), body, surface, .. } = stored.prepared else {
        return Ok(());
    };
    let wrong = |error: &dyn std::fmt::Display| Failure::input("/surface/height", error.to_string());
    let contact = YieldingContact::new(body, &surface.grid, &surface.heights, hardening, cells);
    let contact = contact.map_err(|error| wrong(&error))?;
    let depths: Vec<f64> = contact.cells().iter().map(|cell| cell.depth).collect();
    comparison.values("/cells/depth", &stored.reader.values::<f64>("/cells/depth")?, &depths, 0.0);
    let mut before = contact.rest().map_err(|error| wrong(&error))?;
    before.plastic = read(stored.reader, &contact, ENDS[1].0)?;
    let plastic = read(stored.reader, &contact, ENDS[0].0)?;
    let pressure = stored.field("pressure", place)?;
    let state = contact.certify(&before, &pressure, &plastic, drive.load).map_err(|error| wrong(&error))?;
    if stored.number("extra_solves", step) == 0.0 {
        comparison.number("/path/dissipated", stored.number("dissipated", step), state.dissipated, 0.0);
    }
    let state = AnyState::new(state);
    stored.compare_fields(place, &state, comparison)?;
    let (reading, undivided) = (stored.contact.reading(&state), Step::default());
    let at = stored.at(step, &state);
    let flow = leak(stored.prepared, &state, &at, |_| {})?;
    let measured = Measured { flow: flow.as_ref(), ..Measured::default() };
    let stiffness = stiffness.of(stored.contact, &state, |_| {});
    let at = StateContext { approach: state.approach(), step: Some((&undivided, reading)), stiffness, measured, ..at };
    stored.compare_record(step, (&Record::of(&at), &state), comparison);
    Ok(())
}
