//! Records of all combinations of parts: every number or its reason is present, and JSON and journals restore it to the
//! last bit.

use crate::parts::{Parts, all_facts};
use gfmd_contact::{Drive, Equilibrium, Fields, Load};
use gfmd_interface::{Path, Quasistatic, Refinement, Step};
use gfmd_problem::{AnyState, Facts, Posed, Sequence};
use gfmd_record::{
    ARRAYS, Along, COLUMNS, Cell, Column, Origin, Punch, Record, Sliding, State, StateContext, Surface, arrays, page,
};
use gfmd_relax::Budget;

/// Checks the state of a problem under one load, or after one step of a path.
fn solved(problem: &Posed, facts: &Facts, check: impl FnOnce(&AnyState, Option<&Step>)) {
    let load = if facts.approach { Load::Approach(0.004) } else { Load::MeanPressure(0.01) };
    let drive = Drive { load, lateral: [if facts.lateral { 1e-4 } else { 0.0 }, 0.0], time: 0.0, distance: 0.0 };
    if facts.sequence == Sequence::Loads {
        return check(&problem.press(drive).tolerance(1e-6).solve().unwrap(), None);
    }
    let refinement = Refinement { solves_per_step: 0, ..Refinement::default() };
    let mut path = Path::new(problem, Budget { tolerance: 1e-6, ..Budget::default() }, refinement);
    let step = path.step(drive, &mut ()).unwrap();
    check(path.state().unwrap(), Some(&step));
}

fn same(a: &Cell, b: &Cell) -> bool {
    match (a, b) {
        (Cell::Real(a), Cell::Real(b)) => a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()),
        (a, b) => a == b,
    }
}

#[test]
fn every_number_is_there_or_has_its_reason_and_comes_back() {
    // Every problem in the long tests (`.ci/long`), else one of three; the parts are combined in twos.
    let step = if std::env::var_os("GFMD_LONG").is_some() { 1 } else { 3 };
    let mut count = 0;
    for facts in all_facts().filter(|facts| facts.check().is_ok()).step_by(step) {
        let parts = Parts::of(facts);
        let problem = parts.pose().unwrap();
        solved(&problem, &facts, |rest, step| check(&parts, &problem, rest, step));
        count += 1;
    }
    assert!(count > 400 / step, "{count}");
}

/// Checks the record of a state.
fn check(parts: &Parts, problem: &Posed, rest: &AnyState, step: Option<&Step>) {
    let facts = parts.facts;
    let at = StateContext::new(&facts, rest, problem, &parts.grid, 1e-6);
    let step = step.map(|step| (step, problem.reading(rest)));
    let record = Record::of(&StateContext { step, seconds: 1.0, ..at });
    assert!(record.is("converged"), "{facts:?}");
    for (column, cell) in record.cells() {
        let (name, unless) = (column.name, (column.undefined)(&facts));
        match cell {
            Cell::Undefined(reason) => assert!(!reason.is_empty() && unless.is_none_or(|why| why == reason)),
            cell => assert!(cell.number().is_finite() && unless.is_none(), "{name} {facts:?}"),
        }
        assert!(!column.meaning(&facts).is_empty(), "{name}");
    }
    let back: Record = Record::from_line(&facts, &record.to_line().unwrap()).unwrap();
    let printed = serde_json::to_value(&record).unwrap();
    let nested: Record = Record::from_json(&facts, &printed).unwrap();
    for (((column, cell), (_, line)), (_, json)) in record.cells().zip(back.cells()).zip(nested.cells()) {
        assert!(same(cell, line), "{} {cell:?} {line:?}", column.name);
        assert!(column.json.is_empty() || same(cell, json), "{} {cell:?} {json:?}", column.name);
    }
    let [nx, ny] = parts.grid.points();
    for array in arrays(&facts) {
        let field = (array.value)(rest, &facts).unwrap_or_else(|| panic!("{} {facts:?}", array.name));
        assert!(field.dim() == (nx, ny) && field.iter().all(|value| value.is_finite()), "{}", array.name);
        assert!(!array.meaning(&facts).is_empty(), "{}", array.name);
    }
}

/// Checks numbers of a hard wall under a load that are known without a record: force balance, kappa, points.
#[test]
fn numbers_are_those_of_the_state() {
    let facts = Facts { statistics: false, ..Facts::default() };
    let parts = Parts::of(facts);
    let problem = parts.pose().unwrap();
    let rest = problem.press(Load::MeanPressure(0.01)).solve().unwrap();
    let record = Record::of(&StateContext::new(&facts, &rest, &problem, &parts.grid, 1e-8));
    let pressure = rest.pressure();
    let touching = pressure.iter().filter(|p| **p > 0.0).count();
    assert_eq!(record.get("contact_nodes"), Some(&Cell::Count(touching as u64)));
    assert_eq!(record.number("max_pressure"), pressure.iter().copied().fold(0.0, f64::max));
    let area = touching as f64 / pressure.len() as f64;
    assert!((record.number("kappa") - area / record.number("p_star")).abs() < 1e-12);
    assert_eq!(record.number("approach"), rest.approach());
    assert_eq!(record.worst(), rest.worst());
    assert!(record.number("stiffness") > 0.0);
    assert!(record.number("force").is_nan());
    assert!(!record.has("force"));
    assert!(record.get("seconds").is_some_and(|seconds| seconds.number().is_nan()));
}

#[test]
fn columns_are_declared_once_and_in_full() {
    // Columns with the same name or place are never present together.
    let alike = |a: &Column, b: &Column| a.name == b.name || !a.json.is_empty() && a.json == b.json;
    let pairs = COLUMNS.iter().enumerate().flat_map(|(index, a)| COLUMNS[..index].iter().map(move |b| (a, b)));
    let pairs: Vec<(&Column, &Column)> = pairs.filter(|(a, b)| alike(a, b)).collect();
    assert!(!pairs.is_empty());
    for facts in all_facts() {
        let both = pairs.iter().find(|(a, b)| (a.present)(&facts) && (b.present)(&facts));
        assert!(both.is_none(), "{:?} {facts:?}", both.map(|(a, b)| [a.name, b.name]));
    }
    assert!(COLUMNS.iter().all(|column: &Column| !column.unit.is_empty() && !column.meanings.is_empty()));
    assert!(COLUMNS.iter().any(|column| column.origin == Origin::Clock));
    assert!(ARRAYS.iter().all(|array| !array.unit.is_empty() && !array.meanings.is_empty()));
    assert!(Record::<State>::from_json(&Facts::default(), &serde_json::json!({ "kappa": "two" })).is_err());
    assert!(Record::<State>::from_line(&Facts::default(), "kappa").is_err());
}

/// Compares the page of the columns. `GFMD_DOCS=write cargo test -p gfmd-record` writes it.
#[test]
fn the_page_has_the_columns() {
    let text = format!(
        "# The numbers and fields of a result\n\n\
         <!-- Made from crates/record/src by `GFMD_DOCS=write cargo test -p gfmd-record`. -->\n\n\
         Each load of `contact` and each step of `path` has the numbers below that apply to its problem: in HDF5 as\n\
         `/loads/<name>[load]` and `/path/<name>[step]`; in the JSON of a load or step under the same name, or at the \
         place\n\
         given (`.0`, `.1`: indices in a list); in Python as attributes. A number without a value is `null` (NaN in \
         HDF5 and\n\
         Python), and its reason is in `undefined`: an object of the load or step, an attribute of the dataset.\n\n\
         `X_limit` is the estimate of the number X on an infinitely fine grid. It comes with `X_limit_error`, larger \
         than 95 % of\n\
         its errors, and `X_grid_error` = |X − limit| + limit_error, in the same unit.\n\n{}\n\
         Fields are `/fields/<name>[load,x,y]`, of a path `[waypoint,x,y]`:\n\n{}\n\
         With `--statistics` the loads of a contact and the waypoints of a path, called states here, also have these\n\
         arrays. Patches follow each other state by state; all other arrays have one row per state.\n\n{}\n\
         ## States of `slide`\n\nIn HDF5 `/states/<name>[state]`; in JSON entries of `states`.\n\n{}\n\
         ## Punches\n\nIn HDF5 `/punch/<name>`; in JSON keys of the result.\n\n{}\n\
         ## Statistics of a surface\n\nIn HDF5 `/statistics/<name>`; in JSON keys of the result.\n\n{}",
        page::<State>(),
        fields(),
        statistics(),
        page::<Sliding>(),
        page::<Punch>(),
        page::<Surface>(),
    );
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/columns.md");
    if std::env::var_os("GFMD_DOCS").is_some_and(|what| what == "write") {
        std::fs::write(file, &text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(file).unwrap(), text);
}

/// Returns the patches, distributions and spectra as a Markdown table.
fn statistics() -> String {
    let row = |array: &gfmd_record::Statistic| {
        let along = match array.along {
            Along::Patch => "patch",
            Along::Bin => "state,bin",
            Along::Ring => "state,wavenumber",
            Along::LagX => "state,lag_x",
            Along::LagY => "state,lag_y",
        };
        format!("| `{}[{along}]` | {} | {} |\n", array.path, array.unit.unwrap_or("length"), array.meaning)
    };
    let head = "| array | unit | definition |\n|---|---|---|\n";
    gfmd_record::STATISTICS.iter().fold(head.to_owned(), |page, array| page + &row(array))
}

/// Returns the fields as a Markdown table.
fn fields() -> String {
    let row = |array: &gfmd_record::Array| {
        let meanings: Vec<&str> = array.meanings.iter().rev().map(|(_, meaning)| *meaning).collect();
        format!("| `{}` | {} | {} |\n", array.name, array.unit, meanings.join("; or: "))
    };
    ARRAYS.iter().fold("| field | unit | definition |\n|---|---|---|\n".to_owned(), |page, array| page + &row(array))
}
