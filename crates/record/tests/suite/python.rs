//! Python classes with the numbers and fields of states as attributes, generated from their tables.
//! `GFMD_DOCS=write cargo test -p gfmd-record` writes them.

use gfmd_problem::{Facts, Part, Sequence};
use gfmd_record::{
    ARRAYS, COLUMNS, Column, Number, Punch, PunchFacts, SLIDING_FIELDS, STATISTICS, Sliding, SlidingFacts, State,
    Subject, Surface, SurfaceFacts,
};

use crate::classes::{Class, Property, compare, quantity};
use crate::parts::all_facts;

const HEAD: &str = r#""""The numbers and fields of results, with their units and definitions.

Made from crates/record/src by `GFMD_DOCS=write cargo test -p gfmd-record`.
"""

from typing import Any, Optional

import numpy.typing as npt

from ._check import Array
from ._load import Residual
from ._record import Record
"#;

/// Words for problems that no parts distinguish from the others.
const SOME: &str = "In some problems";

/// Describes the problems in which `holds` is true by their Python options; `None` if it is true in all of them.
fn condition(facts: &[Facts], holds: Holds<Facts>) -> Option<String> {
    if facts.iter().all(holds) {
        return None;
    }
    // Parts that are no option of Python: a path is a function, and the others are absent or wider ones.
    let no_options = [Part::Path, Part::WearBySlip, Part::Frictionless, Part::WearByDistance, Part::StillFriction];
    let parts: Vec<Part> = Part::ALL.iter().copied().filter(|part| !no_options.contains(part)).collect();
    let alone: Vec<Choice> = parts.iter().map(|part| (vec![*part], set(facts, &|f| part.is_in(f)))).collect();
    let both = |(place, (part, own)): (usize, &Choice)| -> Vec<Choice> {
        let with = |(other, set): &Choice| {
            let common = own.iter().zip(set).map(|(own, set)| own & set).collect();
            (vec![other[0], part[0]], common)
        };
        alone[..place].iter().map(with).collect()
    };
    let pairs: Vec<Choice> = alone.iter().enumerate().flat_map(both).collect();
    let held = set(facts, holds);
    let words = [alone, pairs].iter().find_map(|choices| widest(choices, &held));
    Some(words.map_or_else(|| SOME.into(), |words| format!("With {words}")))
}

/// Set of problems, one bit for each.
type Set = Vec<u64>;

/// Parts, and the problems that have all of them.
type Choice = (Vec<Part>, Set);

/// Returns the problems in which `holds` is true.
fn set(facts: &[Facts], holds: Holds<Facts>) -> Set {
    let bit = |(place, f): (usize, &Facts)| u64::from(holds(f)) << place;
    facts.chunks(64).map(|chunk| chunk.iter().enumerate().map(bit).sum()).collect()
}

fn is_within(set: &Set, wider: &Set) -> bool {
    set.iter().zip(wider).all(|(own, wider)| own & !wider == 0)
}

/// Returns the widest choices of parts that together select exactly the problems in which `held` is true.
fn widest(choices: &[Choice], held: &Set) -> Option<String> {
    let met = choices.iter().filter(|(_, set)| set.iter().any(|word| *word != 0) && is_within(set, held));
    let met: Vec<&Choice> = met.collect();
    // Keeps the wider one of two nested choices, and the first of equal ones.
    let is_case = |(place, (_, set)): &(usize, &&Choice)| {
        met.iter().enumerate().any(|(other, (_, wider))| {
            other != *place && is_within(set, wider) && (other < *place || !is_within(wider, set))
        })
    };
    let widest: Vec<&Choice> =
        met.iter().enumerate().filter(|entry| !is_case(entry)).map(|(_, choice)| *choice).collect();
    let words = |(parts, _): &&Choice| parts.iter().map(|part| option(*part)).collect::<Vec<_>>().join(" and ");
    let all = widest
        .iter()
        .fold(vec![0; held.len()], |all: Set, (_, set)| all.iter().zip(set).map(|(all, set)| all | set).collect());
    is_within(held, &all).then(|| widest.iter().map(words).collect::<Vec<_>>().join(" or "))
}

/// Returns the Python option of a part, with its value if it is one of several.
fn option(part: Part) -> String {
    let given = part.given().trim_start_matches('-').replace('-', "_");
    match given.split_once(' ') {
        Some(_) if part == Part::Path => "a path".to_owned(),
        Some((option, value)) => format!("`{option}=\"{value}\"`"),
        None if given == "coefficient" => "`wear`".to_owned(),
        None => format!("`{given}`"),
    }
}

/// Words for the problems that satisfy a predicate; `None` for all of them.
type Condition<'a, F> = &'a dyn Fn(&[F], Holds<F>) -> Option<String>;

/// Predicate of problems.
type Holds<'a, F> = &'a dyn Fn(&F) -> bool;

/// Returns the definitions that occur in some of the problems, the general one first, each with its problems.
fn definitions<F>(facts: &[F], meanings: &[&str], of: impl Fn(&F) -> &'static str, condition: Condition<F>) -> String {
    let place = |f: &F| meanings.iter().position(|text| *text == of(f));
    let there = meanings.iter().enumerate().rev();
    let mut there = there.filter(|(place_of, _)| facts.iter().any(|f| place(f) == Some(*place_of)));
    let general = there.next().map_or_else(String::new, |(_, text)| (*text).to_owned());
    there.fold(general, |texts, (place_of, text)| {
        let own = condition(facts, &|f| place(f) == Some(place_of)).filter(|words| words != SOME);
        // A definition that parts cannot separate from a more special one is described together with it.
        let words = own.or_else(|| condition(facts, &|f| place(f) <= Some(place_of))).unwrap_or_default();
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
fn numbers_of<S: Subject>(
    facts: &[S::Facts],
    (shape, condition): (&Shape, Condition<S::Facts>),
    place: impl Fn(&Column<S>) -> Option<(String, Option<String>)>,
    parts: &[(&str, &'static str, &str)],
) -> Vec<Property>
where
    S::Facts: Copy,
{
    let mut properties: Vec<Property> = Vec::new();
    for column in S::COLUMNS.iter().filter(|column| facts.iter().any(|f| (column.present)(f))) {
        let Some((key, part)) = place(column) else { continue };
        if properties.iter().any(|property| property.name == key) {
            continue;
        }
        let present: Vec<S::Facts> = facts.iter().copied().filter(|f| (column.present)(f)).collect();
        let only = condition(facts, &column.present).map_or_else(String::new, |words| format!(". {words} only"));
        if let Some((_, of, text)) = parts.iter().find(|(name, ..)| *name == key) {
            properties.push(Property { name: key, of, text: format!("{text}{only}.") });
            continue;
        }
        let meanings: Vec<&str> = column.meanings.iter().map(|(_, meaning)| *meaning).collect();
        let text = definitions(&present, &meanings, |f| column.meaning(f), condition);
        let (of, text) = match (column.number, part) {
            (_, Some(_)) => {
                let text = text.replace(" along x", "");
                (shape.types[3], format!("{}{}: {text}", quantity(column.unit), shape.two))
            }
            (Number::Real, None) => (shape.types[0], format!("{}{}: {text}", quantity(column.unit), shape.one)),
            (Number::Count, None) => (shape.types[1], format!("Count{}: {text}", shape.one)),
            (Number::Flag, None) => (shape.types[2], format!("Flag{}: {}", shape.one, text.replace("1 if", "true if"))),
        };
        properties.push(Property { name: key, of, text: format!("{text}{only}.") });
    }
    properties
}

/// Returns properties for the columns of states.
fn numbers(
    facts: &[Facts],
    shape: &Shape,
    place: impl Fn(&Column) -> Option<(String, Option<String>)>,
    parts: &[(&str, &'static str, &str)],
) -> Vec<Property> {
    numbers_of::<State>(facts, (shape, &condition), place, parts)
}

/// Returns the condition of a predicate that holds in some problems only because of one option.
fn only<F>(words: &str) -> impl Fn(&[F], Holds<F>) -> Option<String> {
    move |facts, holds| (!facts.iter().all(holds)).then(|| words.to_owned())
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
    let is_object = ["residual.", "flow.", "patches."].iter().any(|object| column.json.starts_with(object));
    if is_object { Some((column.name.to_owned(), None)) } else { at(column.json) }
}

/// Returns the fields that some of the problems have.
fn fields(facts: &[Facts], dimension: &str, is_optional: bool) -> Vec<Property> {
    let there = ARRAYS.iter().filter(|array| facts.iter().any(|f| (array.present)(f)));
    let property = |array: &gfmd_record::Array| {
        let present: Vec<Facts> = facts.iter().copied().filter(|f| (array.present)(f)).collect();
        let meanings: Vec<&str> = array.meanings.iter().map(|(_, meaning)| *meaning).collect();
        let text = definitions(&present, &meanings, |f| array.meaning(f), &condition);
        let only = condition(facts, &array.present);
        let of = if is_optional && only.is_some() { "Optional[Array]" } else { "Array" };
        let otherwise = if of == "Array" { "" } else { ", otherwise None" };
        let only = only.map_or_else(String::new, |words| format!(". {words} only{otherwise}"));
        let text = format!("{} {dimension}: {text}{only}. Read-only.", quantity(array.unit));
        Property { name: array.name.to_owned(), of, text }
    };
    there.map(property).collect()
}

/// Returns the statistics arrays in a group of a file.
fn statistics(group: &str, shape: &str, name: impl Fn(&str) -> String) -> Vec<Property> {
    let there = STATISTICS.iter().filter_map(|array| Some((array.path.strip_prefix(group)?, array)));
    let property = |(path, array): (&str, &gfmd_record::Statistic)| {
        let text = format!("{} {shape}: {}.", quantity(array.unit.unwrap_or("length")), array.meaning);
        Property { name: name(path), of: "Array", text }
    };
    // The number of the state belongs to a file with several.
    there.filter(|(path, _)| !["load", "waypoint"].contains(path)).map(property).collect()
}

#[test]
fn the_classes_of_python_have_the_columns() {
    let all: Vec<Facts> = all_facts()
        .flat_map(|facts| {
            let flow = facts.sequence == Sequence::Path;
            let measured = Facts { statistics: flow, ..facts };
            let flows = [Facts { flow, ..facts }, Facts { flow, leak: flow, ..facts }, Facts { gas: flow, ..facts }];
            [facts, measured, Facts { conducts: flow, ..measured }].into_iter().chain(flows)
        })
        .filter(|facts| facts.check().is_ok())
        .collect();
    let of =
        |sequence: Sequence| -> Vec<Facts> { all.iter().copied().filter(|facts| facts.sequence == sequence).collect() };
    let [loads, path] = [of(Sequence::Loads), of(Sequence::Path)];
    let parts = [
        ("residual", "Residual", "Residuals, recomputed from the final fields; `float(...)` is the largest"),
        ("lower", "LowerFace", "Numbers of the lower face"),
    ];
    let (points, waypoints) = ("[x, y]", "[waypoint, x, y]");
    let classes = [
        Class::record(
            "Residuals",
            "The residuals of a load.",
            numbers(&loads, &OF_STATE, |c| inside("residual", c.json), &[]),
        ),
        Class::record(
            "LowerFace",
            "The numbers of the lower face of a slab between two surfaces.",
            numbers(&of_lower(&loads), &OF_STATE, |c| inside("lower", c.json), &parts),
        ),
        Class::record("Numbers", "The numbers of a load.", numbers(&loads, &OF_STATE, |c| at(c.json), &parts)),
        Class {
            name: "Fields",
            text: "The fields of a load.",
            held_in: Some("_fields"),
            properties: fields(&loads, points, true),
        },
        Class::record("Steps", "The numbers of the steps of a path.", numbers(&path, &OF_STEPS, of_step, &[])),
        Class::record("StepFields", "The fields of a path.", fields(&path, waypoints, false)),
        Class::record(
            "Patches",
            "The patches of points in contact, as `gfmd contact --statistics` measures them.",
            statistics("/patches/", "[patch]", str::to_owned),
        ),
        Class::record("States", "The numbers of states that slide steadily.", states()),
        Class::record("StateFields", "The fields of states that slide steadily.", state_fields()),
        Class::record("PunchNumbers", "The numbers of a punch.", punch()),
        Class::record("SurfaceNumbers", "The statistics of a surface.", surface()),
    ];
    let stub = classes.iter().fold(HEAD.to_owned(), |text, class| text + &class.stub());
    assert!(stub.lines().all(|line| line.chars().count() <= 120));
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../python/python/gfmd");
    compare(&format!("{folder}/_columns.pyi"), &(stub + MEASURED));
    let definitions: serde_json::Map<_, _> =
        classes.iter().map(|class| (class.name.to_owned(), class.definitions())).collect();
    let data = serde_json::json!({"classes": definitions, "measured": measured()});
    compare(&format!("{folder}/_columns.json"), &(serde_json::to_string_pretty(&data).unwrap() + "\n"));
}

/// Places of the numbers of patches and flow in a record, by name.
const MEASURED: &str = "\nMEASURED: dict[str, str]\n";

/// Returns the numbers of sliding states. Python has their residuals one by one.
fn states() -> Vec<Property> {
    let none = SlidingFacts::default();
    let facts = [none, SlidingFacts { heat: true, shared: true, ..none }, SlidingFacts { hardness: true, ..none }];
    let facts = [facts[0], facts[1], facts[2], SlidingFacts { refined: true, ..none }];
    let place = |column: &Column<Sliding>| {
        let is_listed = !column.json.is_empty() && !column.json.starts_with("residual.");
        is_listed.then(|| (column.name.to_owned(), None))
    };
    let shape = Shape { one: " [state]", ..OF_STEPS };
    let words = |facts: &[SlidingFacts], present: Holds<SlidingFacts>| match facts.iter().all(present) {
        true => None,
        false if present(&none) => Some(String::new()),
        false if facts.iter().any(|facts| present(facts) && facts.hardness) => Some("With `hardness`".to_owned()),
        false if facts.iter().any(|facts| present(facts) && facts.refined) => {
            Some("With `grid_error=\"refine\"`".to_owned())
        }
        false => Some("With `heat`".to_owned()),
    };
    numbers_of::<Sliding>(&facts, (&shape, &words), place, &[])
}

fn state_fields() -> Vec<Property> {
    let none = SlidingFacts::default();
    let words = |present: fn(&SlidingFacts) -> bool| match () {
        () if present(&none) => "",
        () if present(&SlidingFacts { hardness: true, ..none }) => ". With `hardness` only",
        () if present(&SlidingFacts { heat: true, ..none }) => ". With `heat` only",
        () => ". With `heat` of both bodies only",
    };
    let property = |field: &gfmd_record::SlidingField| Property {
        name: field.name.to_owned(),
        of: "Array",
        text: format!("{} [state, x, y]: {}{}. Read-only.", quantity(field.unit), field.meaning, words(field.present)),
    };
    SLIDING_FIELDS.iter().map(property).collect()
}

fn punch() -> Vec<Property> {
    let facts = [PunchFacts::default(), PunchFacts { mask: true, line: false }];
    let shape = Shape { two: " by component", ..OF_STATE };
    numbers_of::<Punch>(&facts, (&shape, &only("Without `mask`")), |column| at(column.json), &[])
}

fn surface() -> Vec<Property> {
    let plain = SurfaceFacts::default();
    let facts = [plain, SurfaceFacts { line: true, ..plain }, SurfaceFacts { detailed: true, ..plain }];
    let words = |_: &[SurfaceFacts], holds: Holds<SurfaceFacts>| match () {
        () if holds(&plain) => None,
        () if holds(&SurfaceFacts { line: true, ..plain }) => Some("Of a profile".to_owned()),
        () if holds(&SurfaceFacts { line: true, detailed: true, ..plain }) => Some("With `features`".to_owned()),
        () => Some("Of a surface with `features`".to_owned()),
    };
    let range = ("hurst_range", "list[float]", "Length: longest and shortest wavelength of the fit of `hurst`");
    numbers_of::<Surface>(&facts, (&OF_STATE, &words), |column| at(column.json), &[range])
}

/// Returns the numbers of patches and flow by name, with their places in a record.
fn measured() -> serde_json::Map<String, serde_json::Value> {
    let is_measured = |column: &&Column| ["flow.", "patches."].iter().any(|object| column.json.starts_with(object));
    COLUMNS.iter().filter(is_measured).map(|column| (column.name.to_owned(), column.json.into())).collect()
}

/// Returns the problems with a lower surface.
fn of_lower(facts: &[Facts]) -> Vec<Facts> {
    facts.iter().copied().filter(|facts| facts.lower.is_some()).collect()
}
