//! Python classes with the numbers and fields of states as attributes, generated from their tables.
//! `GFMD_DOCS=write cargo test -p gfmd-record` writes them.

use gfmd_problem::{Facts, Part, Task};
use gfmd_record::{ARRAYS, COLUMNS, Column, Number, STATISTICS};

use crate::classes::{Property, class, compare, quantity};
use crate::parts::all_facts;

const HEAD: &str = r#""""The numbers and fields of states, with their units and definitions.

Made from crates/record/src by `GFMD_DOCS=write cargo test -p gfmd-record`.
"""

# mypy: no-warn-return-any

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

import numpy.typing as npt

from ._check import Array
from ._record import Record

if TYPE_CHECKING:
    from ._load import Residual
"#;

/// Words for problems that no parts distinguish from the others.
const SOME: &str = "In some problems";

/// Describes the problems in which `holds` is true by their Python options; `None` if it is true in all of them.
fn condition(facts: &[Facts], holds: impl Fn(&Facts) -> bool) -> Option<String> {
    if facts.iter().all(&holds) {
        return None;
    }
    let alone = Part::ALL.iter().map(|part| vec![*part]).collect();
    let both = |(place, part): (usize, &Part)| Part::ALL[..place].iter().map(|other| vec![*other, *part]).collect();
    let pairs = Part::ALL.iter().enumerate().flat_map(|entry| -> Vec<Vec<Part>> { both(entry) }).collect();
    let words = [alone, pairs].into_iter().find_map(|choices: Vec<Vec<Part>>| widest(facts, &choices, &holds));
    Some(words.map_or_else(|| SOME.into(), |words| format!("With {words}")))
}

/// Returns the widest choices of parts that together select exactly the problems in which `holds` is true.
fn widest(facts: &[Facts], choices: &[Vec<Part>], holds: &dyn Fn(&Facts) -> bool) -> Option<String> {
    let has = |choice: &[Part], f: &Facts| choice.iter().all(|part| part.is_in(f));
    let within = |choice: &[Part], other: &dyn Fn(&Facts) -> bool| facts.iter().all(|f| !has(choice, f) || other(f));
    let met = choices.iter().filter(|choice| facts.iter().any(|f| has(choice, f)) && within(choice, holds));
    let met: Vec<&[Part]> = met.map(Vec::as_slice).collect();
    // Keeps the wider one of two nested choices, and the first of equal ones.
    let is_case = |(place, choice): &(usize, &&[Part])| {
        met.iter().enumerate().any(|(other, wider)| {
            other != *place
                && within(choice, &|f| has(wider, f))
                && (other < *place || !within(wider, &|f| has(choice, f)))
        })
    };
    let widest: Vec<&[Part]> =
        met.iter().enumerate().filter(|entry| !is_case(entry)).map(|(_, choice)| *choice).collect();
    let words = |choice: &&[Part]| choice.iter().map(|part| option(*part)).collect::<Vec<_>>().join(" and ");
    let is_all = facts.iter().all(|f| !holds(f) || widest.iter().any(|choice| has(choice, f)));
    is_all.then(|| widest.iter().map(words).collect::<Vec<_>>().join(" or "))
}

/// Returns the Python option of a part, with its value if it is one of several.
fn option(part: Part) -> String {
    let given = part.given().trim_start_matches('-').replace('-', "_");
    match given.split_once(' ') {
        Some((option, value)) => format!("`{option}=\"{value}\"`"),
        None if given == "displacement" => "`approach`".to_owned(),
        None => format!("`{given}`"),
    }
}

/// Returns the definitions that occur in some of the problems, the general one first, each with its problems.
fn definitions(facts: &[Facts], meanings: &[&str], of: impl Fn(&Facts) -> &'static str) -> String {
    let place = |f: &Facts| meanings.iter().position(|text| *text == of(f));
    let there = meanings.iter().enumerate().rev();
    let mut there = there.filter(|(place_of, _)| facts.iter().any(|f| place(f) == Some(*place_of)));
    let general = there.next().map_or_else(String::new, |(_, text)| (*text).to_owned());
    there.fold(general, |texts, (place_of, text)| {
        let own = condition(facts, |f| place(f) == Some(place_of)).filter(|words| words != SOME);
        // A definition that parts cannot separate from a more special one is described together with it.
        let words = own.or_else(|| condition(facts, |f| place(f) <= Some(place_of))).unwrap_or_default();
        format!("{texts}. {words}: {text}")
    })
}

/// Shape and number types for a single state, or for arrays over several states.
struct Shape {
    one: &'static str,
    two: &'static str,
    types: [&'static str; 4],
}

const OF_STATE: Shape = Shape { one: "", two: " along x and y", types: ["float", "int", "bool", "list[float]"] };
const OF_STEPS: Shape =
    Shape { one: " [step]", two: " [step, 2]", types: ["Array", "npt.NDArray[Any]", "npt.NDArray[Any]", "Array"] };

/// Returns properties for the columns that some of the problems have. `place` gives the key of a column in a record,
/// and its part inside that value. Type and definition of objects are in `parts`.
fn numbers(
    facts: &[Facts],
    shape: &Shape,
    place: impl Fn(&Column) -> Option<(String, Option<String>)>,
    parts: &[(&str, &'static str, &str)],
) -> Vec<Property> {
    let mut properties: Vec<Property> = Vec::new();
    for column in COLUMNS.iter().filter(|column| facts.iter().any(|f| (column.present)(f))) {
        let Some((key, part)) = place(column) else { continue };
        if properties.iter().any(|property| property.name == key) {
            continue;
        }
        let present: Vec<Facts> = facts.iter().copied().filter(|f| (column.present)(f)).collect();
        let only = condition(facts, column.present).map_or_else(String::new, |words| format!(". {words} only"));
        if let Some((_, of, text)) = parts.iter().find(|(name, ..)| *name == key) {
            properties.push(Property::of_record(key, of, format!("{text}{only}.")));
            continue;
        }
        let meanings: Vec<&str> = column.meanings.iter().map(|(_, meaning)| *meaning).collect();
        let text = definitions(&present, &meanings, |f| column.meaning(f));
        let (of, text) = match (column.number, part) {
            (_, Some(_)) => {
                let text = text.replace(" along x", "");
                (shape.types[3], format!("{}{}: {text}", quantity(column.unit), shape.two))
            }
            (Number::Real, None) => (shape.types[0], format!("{}{}: {text}", quantity(column.unit), shape.one)),
            (Number::Count, None) => (shape.types[1], format!("Count{}: {text}", shape.one)),
            (Number::Flag, None) => (shape.types[2], format!("Flag{}: {}", shape.one, text.replace("1 if", "true if"))),
        };
        properties.push(Property::of_record(key, of, format!("{text}{only}.")));
    }
    properties
}

/// Returns key and part of a place in a JSON record.
fn at(json: &str) -> Option<(String, Option<String>)> {
    let (key, part) = json.split_once('.').map_or((json, None), |(key, part)| (key, Some(part.to_owned())));
    (!key.is_empty()).then(|| (key.to_owned(), part))
}

/// Returns key and part inside a JSON object.
fn inside(object: &str, json: &str) -> Option<(String, Option<String>)> {
    json.strip_prefix(object)?.strip_prefix('.').and_then(at)
}

/// Returns the place of a number of steps. Numbers inside a JSON object use their name in a file.
fn of_step(column: &Column) -> Option<(String, Option<String>)> {
    let is_object = ["residual.", "flow."].iter().any(|object| column.json.starts_with(object));
    if is_object { Some((column.name.to_owned(), None)) } else { at(column.json) }
}

/// Returns the fields that some of the problems have.
fn fields(facts: &[Facts], dimension: &str, value: impl Fn(&str, bool) -> String) -> Vec<Property> {
    let there = ARRAYS.iter().filter(|array| facts.iter().any(|f| (array.present)(f)));
    let property = |array: &gfmd_record::Array| {
        let present: Vec<Facts> = facts.iter().copied().filter(|f| (array.present)(f)).collect();
        let meanings: Vec<&str> = array.meanings.iter().map(|(_, meaning)| *meaning).collect();
        let text = definitions(&present, &meanings, |f| array.meaning(f));
        let only = condition(facts, array.present);
        let value = value(array.name, only.is_some());
        let of = if value.contains(".get(") { "Optional[Array]" } else { "Array" };
        let otherwise = if of == "Array" { "" } else { ", otherwise None" };
        let only = only.map_or_else(String::new, |words| format!(". {words} only{otherwise}"));
        let text = format!("{} {dimension}: {text}{only}. Read-only.", quantity(array.unit));
        Property { name: array.name.to_owned(), of, text, value }
    };
    there.map(property).collect()
}

/// Returns the statistics arrays in a group of a file.
fn statistics(group: &str, shape: &str, name: impl Fn(&str) -> String) -> Vec<Property> {
    let there = STATISTICS.iter().filter_map(|array| Some((array.path.strip_prefix(group)?, array)));
    let property = |(path, array): (&str, &gfmd_record::Statistic)| {
        let text = format!("{} {shape}: {}.", quantity(array.unit.unwrap_or("length")), array.meaning);
        Property::of_record(name(path), "Array", text)
    };
    // The load number belongs to a file with several loads.
    there.filter(|(path, _)| *path != "load").map(property).collect()
}

#[test]
fn the_classes_of_python_have_the_columns() {
    let all: Vec<Facts> = all_facts()
        .flat_map(|facts| [facts, Facts { flow: facts.task == Task::Path, ..facts }])
        .filter(|facts| facts.check().is_ok())
        .collect();
    let of = |task: Task, wears: bool| -> Vec<Facts> {
        all.iter().copied().filter(|facts| facts.task == task && facts.wears == wears).collect()
    };
    let [loads, path, worn] = [of(Task::Loads, false), of(Task::Path, false), of(Task::Path, true)];
    let steps = [&path[..], &worn].concat();
    let parts = [
        ("residual", "Residual", "Residuals, recomputed from the final fields; `float(...)` is the largest"),
        ("lower", "LowerFace", "Numbers of the lower face"),
    ];
    let lent = |name: &str, may_lack: bool| match may_lack {
        true => format!("self._fields.get(\"{name}\")"),
        false => format!("self._fields[\"{name}\"]"),
    };
    let kept = |name: &str, _: bool| format!("self._value(\"{name}\")");
    let (points, waypoints) = ("[x, y]", "[waypoint, x, y]");
    let record = "(Record)";
    let classes = [
        class(
            "Residuals",
            record,
            "The residuals of a load.",
            &numbers(&loads, &OF_STATE, |c| inside("residual", c.json), &[]),
        ),
        class(
            "LowerFace",
            record,
            "The numbers of the lower face of a slab between two surfaces.",
            &numbers(&of_lower(&loads), &OF_STATE, |c| inside("lower", c.json), &parts),
        ),
        class("Numbers", record, "The numbers of a load.", &numbers(&loads, &OF_STATE, |c| at(c.json), &parts)),
        class("Fields", "", "The fields of a load.", &fields(&loads, points, lent)).replacen(
            "\n\n    @property",
            "\n\n    _fields: dict[str, Array]\n\n    @property",
            1,
        ),
        class("Steps", record, "The numbers of the steps of a path.", &numbers(&steps, &OF_STEPS, of_step, &[])),
        class("StepFields", record, "The fields of a path.", &fields(&path, waypoints, kept)),
        class("WearFields", record, "The fields of wear.", &fields(&worn, waypoints, kept)),
        class(
            "Patches",
            record,
            "The patches of points in contact, as `gfmd contact --statistics` measures them.",
            &statistics("/patches/", "[patch]", str::to_owned),
        ),
    ];
    let text = format!(
        "{HEAD}\n# The places of the numbers of a flow in its object, by their names.\nFLOW = {{\n{}}}\n{}",
        flow(),
        classes.concat()
    );
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../python/python/gfmd/_columns.py");
    compare(file, &text);
}

/// Returns the numbers of a flow by name, with their places in its object.
fn flow() -> String {
    let places = COLUMNS.iter().filter_map(|column| Some((column.name, column.json.strip_prefix("flow.")?)));
    places.map(|(name, place)| format!("    \"{name}\": \"{place}\",\n")).collect()
}

/// Returns the problems with a lower surface.
fn of_lower(facts: &[Facts]) -> Vec<Facts> {
    facts.iter().copied().filter(|facts| facts.lower.is_some()).collect()
}
