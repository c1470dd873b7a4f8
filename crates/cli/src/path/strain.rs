//! Plastic strain below the surface in a path file, used to check the last step, and the waypoints if they have theirs.

use gfmd_check::result::Comparison;
use gfmd_check::series::Stored;
use gfmd_contact::{Drive, Fields as _};
use gfmd_files::{Archive, Dimension, FileError, Reader, Variable, axes};
use gfmd_input::failure::Failure;
use gfmd_input::source::Surface;
use gfmd_interface::{Quasistatic as _, Step};
use gfmd_plasticity::{Cell, PlasticState, PlasticStrain, YieldingContact};
use gfmd_problem::options::Plasticity;
use gfmd_problem::{AnyState, KeptStrain};
use gfmd_record::{Record, StateContext};
use gfmd_run::resume::OwnRows;
use gfmd_run::series::{Prepared, StateFile, StiffnessArgs};
use ndarray::{Array2, Array3};

/// Components of a deviatoric strain; their squares add to ε:ε.
const COMPONENTS: [&str; 5] = ["sqrt(3/2) zz", "(xx - yy) / sqrt(2)", "sqrt(2) xy", "sqrt(2) xz", "sqrt(2) yz"];

/// Plastic strain at the end of the last step, and before it.
const ENDS: [(&str, &str); 2] = [("", "after the last step"), ("_before", "before the last increment")];

/// Group of the strain at the waypoints.
const WAYPOINTS: &str = "/plastic_at_waypoints";

/// Numbers of a step that follow from its pressure and its plastic strain alone.
const OF_STRAIN: [&str; 9] = [
    "elastic_energy",
    "hardening_energy",
    "max_plastic_strain",
    "plastic_strain_integral",
    "yielded_volume",
    "yield_depth",
    "plastic_displacement_mean",
    "plastic_displacement_rms",
    "plastic_displacement_min",
];

/// Writes the cells, and the plastic strain of the last state and of the state before it; its rows travel to the first
/// process, which has the file.
pub(super) fn write(file: &mut StateFile, surface: &Surface, state: &PlasticState) -> Result<(), Failure> {
    let mut archive = file.archive();
    let mut written = archive.as_mut().map_or(Ok(()), |archive| write_cells(archive, surface, state.cells()));
    for ((end, when), plastic) in ENDS.into_iter().zip([&state.plastic, &state.plastic_before]) {
        if surface.share.is_whole() {
            let of_cell = |number: usize| (state.strain_of(plastic, number), state.equivalent_of(plastic, number));
            if let Some(archive) = &mut archive {
                write_strain(archive, surface, state.cells(), (end, when), of_cell)?;
            }
            continue;
        }
        for (number, cell) in state.cells().iter().enumerate() {
            let names = [name_of("strain", end, number), name_of("equivalent", end, number)];
            let defined =
                archive.as_mut().map_or(Ok(()), |archive| define_strain(archive, surface, (cell, number), end, when));
            written = written.and(defined);
            for (component, rows) in rows_of(state, plastic, number).into_iter().enumerate() {
                let is_strain = component < COMPONENTS.len();
                let (name, index) = if is_strain { (&names[0], Some(component)) } else { (&names[1], None) };
                rows.to_first(|start, values| {
                    if let (Some(archive), Ok(())) = (&mut archive, &written) {
                        written = archive.write_rows(name, index, start / rows.share.columns(), values);
                    }
                });
            }
        }
    }
    Ok(written?)
}

/// Returns the name of the plastic strain or of κ of a cell at one end of the last step.
fn name_of(what: &str, end: &str, number: usize) -> String {
    format!("/plastic/{what}{end}_{number}")
}

/// Defines the plastic strain and κ of a cell at one end of the last step, to be written by rows.
fn define_strain(
    archive: &mut Archive,
    surface: &Surface,
    (cell, number): (&Cell, usize),
    end: &str,
    when: &str,
) -> Result<(), FileError> {
    let (component, [x, y]) = (component(), axes_of(cell, surface));
    let long_name = format!("plastic strain of cell {number} {when}");
    let variable = Variable { dimensions: &[&component, &x, &y], units: "1", long_name: &long_name };
    archive.define(&name_of("strain", end, number), &variable)?;
    let long_name = format!("equivalent plastic strain of cell {number} {when}");
    let variable = Variable { dimensions: &[&x, &y], units: "1", long_name: &long_name };
    archive.define_rows(&name_of("equivalent", end, number), &variable)
}

/// Returns the components of ε^p of a cell, then κ, of this process.
fn rows_of(state: &PlasticState, plastic: &PlasticStrain, number: usize) -> Vec<OwnRows> {
    let (strain, equivalent) = (state.strain_of(plastic, number), state.equivalent_of(plastic, number));
    let components = strain.outer_iter().map(|component| component.iter().copied().collect());
    let all = components.chain([equivalent.into_raw_vec_and_offset().0]);
    all.map(|values| OwnRows { share: state.rows(number).clone(), values }).collect()
}

/// Returns true if the file keeps the plastic strain at the waypoints.
fn keeps_waypoints(prepared: &Prepared) -> bool {
    prepared.inelastic.plasticity.as_ref().is_some_and(|plasticity| plasticity.kept_strain == KeptStrain::Waypoints)
}

/// Defines the plastic strain at this number of waypoints, if it is kept.
pub(super) fn define_waypoints(file: &mut StateFile, prepared: &Prepared, count: usize) -> Result<(), Failure> {
    let Prepared { inelastic, body, surface, .. } = prepared;
    let Some(plasticity) = &inelastic.plasticity else { return Ok(()) };
    let Some(archive) = file.archive().filter(|_| keeps_waypoints(prepared)) else { return Ok(()) };
    let waypoint = Dimension::index("waypoint", count, "number of the waypoint");
    let component = component();
    for (number, cell) in plasticity.cells(body, &surface.grid)?.iter().enumerate() {
        let [x, y] = axes_of(cell, surface);
        let long_name = format!("plastic strain of cell {number}");
        let dimensions = [&waypoint, &component, &x, &y];
        let variable = Variable { dimensions: &dimensions, units: "1", long_name: &long_name };
        archive.define(&format!("{WAYPOINTS}/strain_{number}"), &variable)?;
        let long_name = format!("equivalent plastic strain of cell {number}");
        let dimensions = [&waypoint, &x, &y];
        let variable = Variable { dimensions: &dimensions, units: "1", long_name: &long_name };
        archive.define(&format!("{WAYPOINTS}/equivalent_{number}"), &variable)?;
    }
    Ok(())
}

/// Returns the plastic strain of a state, cell by cell the components of ε^p and κ, if the file keeps it at the
/// waypoints.
pub(super) fn at_waypoint(prepared: &Prepared, state: &AnyState) -> Vec<OwnRows> {
    let Some(state) = state.yielding().filter(|_| keeps_waypoints(prepared)) else { return Vec::new() };
    (0..state.cells().len()).flat_map(|number| rows_of(state, &state.plastic, number)).collect()
}

/// Writes `values`, from value `start` on, of a field that [`at_waypoint`] returned with this `number`.
pub(super) fn write_waypoint(
    file: &mut StateFile,
    prepared: &Prepared,
    (place, number): (usize, usize),
    (start, values): (usize, &[f64]),
) -> Result<(), Failure> {
    let Prepared { inelastic, body, surface, .. } = prepared;
    let Some((archive, plasticity)) = file.archive().zip(inelastic.plasticity.as_ref()) else { return Ok(()) };
    let count = COMPONENTS.len() + 1;
    let (cell, component) = (number / count, number % count);
    let cells = plasticity.cells(body, &surface.grid)?;
    let [_, columns] = cells[cell].grid(&surface.grid).points();
    let (name, index) = match component < COMPONENTS.len() {
        true => ("strain", place * COMPONENTS.len() + component),
        false => ("equivalent", place),
    };
    Ok(archive.write_rows(&format!("{WAYPOINTS}/{name}_{cell}"), Some(index), start / columns, values)?)
}

/// Defines the cells and the plastic strain, without values that count.
pub(super) fn lay_out(file: &mut StateFile, prepared: &Prepared, waypoints: usize) -> Result<(), Failure> {
    define_waypoints(file, prepared, waypoints)?;
    let Prepared { inelastic, body, surface, .. } = prepared;
    let Some(plasticity) = &inelastic.plasticity else { return Ok(()) };
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
        ("depth", unit, depths, "bottom depth of the cell"),
        ("coarsening", "1", coarsenings, "grid step of the cell divided by the surface grid step"),
    ] {
        archive.write(&format!("/cells/{name}"), &Variable { dimensions: &[&cell], units, long_name }, &values)?;
    }
    Ok(())
}

/// Returns the dimension of the components.
fn component() -> Dimension {
    Dimension::labels("component", &COMPONENTS, "component of a deviatoric strain")
}

/// Returns the dimensions along x and y of a cell on its own grid.
fn axes_of(cell: &Cell, surface: &Surface) -> [Dimension; 2] {
    let mut found = axes(&cell.grid(&surface.grid), surface.unit());
    if cell.coarsening > 1 {
        found.iter_mut().for_each(|axis| axis.name = format!("{}_{}", axis.name, cell.coarsening));
    }
    found
}

/// Writes the plastic strain of all cells, each on its own grid.
fn write_strain(
    archive: &mut Archive,
    surface: &Surface,
    cells: &[Cell],
    (end, when): (&str, &str),
    of_cell: impl Fn(usize) -> (Array3<f64>, Array2<f64>),
) -> Result<(), FileError> {
    let component = component();
    for (number, cell) in cells.iter().enumerate() {
        let [x, y] = axes_of(cell, surface);
        let (strain, equivalent) = of_cell(number);
        let flat: Vec<f64> = strain.iter().copied().collect();
        let long_name = format!("plastic strain of cell {number} {when}");
        let variable = Variable { dimensions: &[&component, &x, &y], units: "1", long_name: &long_name };
        archive.write(&name_of("strain", end, number), &variable, &flat)?;
        let flat: Vec<f64> = equivalent.iter().copied().collect();
        let long_name = format!("equivalent plastic strain of cell {number} {when}");
        let variable = Variable { dimensions: &[&x, &y], units: "1", long_name: &long_name };
        archive.write(&name_of("equivalent", end, number), &variable, &flat)?;
    }
    Ok(())
}

/// Makes a plastic strain from its variables: `values` returns one, given its name and the number of its cell.
fn assembled(
    contact: &YieldingContact,
    values: impl Fn(&str, usize) -> Result<Vec<f64>, FileError>,
) -> Result<PlasticStrain, Failure> {
    let wrong = |error: &dyn std::fmt::Display| Failure::input("/plastic", error.to_string());
    let grid = *contact.surface().grid();
    let (mut strains, mut equivalents) = (Vec::new(), Vec::new());
    for (number, cell) in contact.cells().iter().enumerate() {
        let [nx, ny] = cell.grid(&grid).points();
        let strain = Array3::from_shape_vec((COMPONENTS.len(), nx, ny), values("strain", number)?);
        strains.push(strain.map_err(|error| wrong(&error))?);
        let equivalent = Array2::from_shape_vec((nx, ny), values("equivalent", number)?);
        equivalents.push(equivalent.map_err(|error| wrong(&error))?);
    }
    contact.plastic_strain(&strains, &equivalents).map_err(|error| wrong(&error))
}

/// Reads the plastic strain at one end of the last step.
fn read(reader: &Reader, contact: &YieldingContact, end: &str) -> Result<PlasticStrain, Failure> {
    assembled(contact, |name, number| reader.values(&format!("/plastic/{name}{end}_{number}")))
}

/// Returns the contact of a body that yields; `None` for another body.
fn yielding_contact(prepared: &Prepared) -> Result<Option<YieldingContact>, Failure> {
    let Prepared { inelastic, body, surface, .. } = prepared;
    let Some(Plasticity { hardening, cells, .. }) = &inelastic.plasticity else { return Ok(None) };
    let contact = YieldingContact::new(body, &surface.grid, &surface.heights, hardening, cells);
    contact.map(Some).map_err(|error| Failure::input("/surface/height", error))
}

/// Recomputes a step from its pressure and its plastic strain at a waypoint, if the file has it: contact, yield
/// condition, and what follows from them. κ does not fall from waypoint to waypoint.
pub(super) fn check_waypoint(
    stored: &Stored,
    (step, place): (usize, usize),
    drive: Drive,
    comparison: &mut Comparison,
) -> Result<(), Failure> {
    if !keeps_waypoints(stored.prepared) {
        return Ok(());
    }
    let Some(contact) = yielding_contact(stored.prepared)? else { return Ok(()) };
    let wrong = |error: &dyn std::fmt::Display| Failure::input(WAYPOINTS, error.to_string());
    let path = |name: &str, number: usize| format!("{WAYPOINTS}/{name}_{number}");
    let plastic = assembled(&contact, |name, number| stored.reader.slab(&path(name, number), place))?;
    let mut before = contact.rest().map_err(|error| wrong(&error))?;
    before.plastic = plastic;
    let pressure = stored.field("pressure", place)?;
    let state = contact.certify(&before, &pressure, &before.plastic, drive.load).map_err(|error| wrong(&error))?;
    let state = AnyState::new(state);
    stored.compare_fields(place, &state, comparison)?;
    let at = stored.at(step, &state);
    let record = Record::of(&StateContext { step: Some((&Step::default(), stored.contact.reading(&state))), ..at });
    for name in OF_STRAIN {
        comparison.number(&stored.path(name), stored.number(name, step), record.number(name), 0.0);
    }
    let what = format!("residual of step {step}, from its strain");
    comparison.at_most(&what, state.worst(), stored.allowed());
    for number in 0..contact.cells().len() {
        let name = path("equivalent", number);
        let now: Vec<f64> = stored.reader.slab(&name, place)?;
        if let Some(earlier) = place.checked_sub(1) {
            let earlier: Vec<f64> = stored.reader.slab(&name, earlier)?;
            let fall = earlier.iter().zip(&now).map(|(then, now)| then - now).fold(0.0, f64::max);
            comparison.at_most(&format!("{name} (fall)"), fall, 0.0);
        }
        // Only the last step has both.
        if step + 1 == stored.count() {
            comparison.values(
                &name,
                &now,
                &stored.reader.values::<f64>(&format!("/plastic/equivalent_{number}"))?,
                0.0,
            );
        }
    }
    Ok(())
}

/// Recomputes the last step from its pressure and its plastic strain. `record` makes the record of the state, given its
/// numbers so far.
pub(super) fn check(
    stored: &Stored,
    (step, place): (usize, usize),
    drive: Drive,
    stiffness: StiffnessArgs,
    record: impl FnOnce(&AnyState, StateContext<'_>) -> Result<Record, Failure>,
    comparison: &mut Comparison,
) -> Result<(), Failure> {
    let Some(contact) = yielding_contact(stored.prepared)? else { return Ok(()) };
    let wrong = |error: &dyn std::fmt::Display| Failure::input("/surface/height", error.to_string());
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
    let stiffness = stiffness.of(stored.contact, &state, |_| {});
    let at = StateContext { approach: state.approach(), step: Some((&undivided, reading)), stiffness, ..at };
    stored.compare_record(step, (&record(&state, at)?, &state), comparison);
    Ok(())
}
