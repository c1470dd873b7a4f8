//! The options of all commands as a page (docs/options.md) and as types, defaults and meanings of Python (_options.py,
//! _options.json), from the flags of the program. `GFMD_DOCS=write cargo test -p gfmd-cli -- options` writes all.

use std::any::TypeId;
use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{Arg, ArgAction, Command};
use gfmd_cli::program;
use gfmd_input::hardness::GivenHardness;
use gfmd_input::source::SourceArgs;
use gfmd_problem::argument;
use gfmd_problem::options::flags::keys;
use gfmd_problem::options::{BodyArgs, ComplianceArgs, GeneratorArgs, PronyArgs};
use gfmd_run::series::ContactArgs;
use serde_json::{Value, json};

/// Compares a file of the repository with a text; writes it first if `GFMD_DOCS=write`.
fn compare(file: &str, text: &str) {
    let file = format!("{}/../../{file}", env!("CARGO_MANIFEST_DIR"));
    if std::env::var_os("GFMD_DOCS").is_some_and(|what| what == "write") {
        std::fs::write(&file, text).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap_or_default(), text, "{file}");
}

/// Returns the kinds of the numbers of an option; empty if they have no unit.
fn kinds(key: &str) -> Vec<&'static str> {
    gfmd_cli::kinds::kinds().get(key).map_or_else(Vec::new, |kinds| kinds.in_turn().to_vec())
}

fn key(arg: &Arg) -> &str {
    arg.get_id().as_str()
}

/// Returns the flags of a command, without its file names that have no flag.
fn flags(command: &Command) -> impl Iterator<Item = &Arg> {
    command.get_arguments().filter(|arg| arg.get_long().is_some())
}

/// Returns the names that an option may have as its value.
fn choices(arg: &Arg) -> Vec<String> {
    if !takes_value(arg) {
        return Vec::new();
    }
    let listed = arg.get_possible_values().into_iter().filter(|value| !value.is_hide_set());
    listed.map(|value| value.get_name().to_owned()).collect()
}

fn takes_value(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::Set | ArgAction::Append)
}

/// Returns the flag with the name of its value, or with its choices.
fn flag(arg: &Arg) -> String {
    let long = format!("--{}", arg.get_long().unwrap());
    if !takes_value(arg) {
        return long;
    }
    let name = arg.get_value_names().unwrap_or_default().join(" ");
    let choices = choices(arg);
    let value = if choices.is_empty() || arg.get_value_delimiter().is_some() { name } else { choices.join("|") };
    format!("{long} {value}")
}

/// Returns meaning and default of an option. A default that depends on others is the end of its help.
fn meaning_and_default(arg: &Arg) -> (String, String) {
    let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
    let (meaning, said) = match help.strip_suffix(']').and_then(|text| text.rsplit_once(" [default: ")) {
        Some((meaning, default)) => (meaning.to_owned(), default.to_owned()),
        None => (help, String::new()),
    };
    let given: Vec<_> = arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    let default = match () {
        () if !takes_value(arg) => String::new(),
        () if arg.is_required_set() => "required".into(),
        () if given.is_empty() => said,
        () => given.iter().map(|value| number(value)).collect::<Vec<_>>().join(","),
    };
    let choices = choices(arg);
    let list = arg.get_value_delimiter().is_some() && !choices.is_empty() && choices.join(",") != default;
    (if list { format!("{meaning}: {}", choices.join(", ")) } else { meaning }, default)
}

/// Returns a small number with an exponent, and any other text as it is.
fn number(text: &str) -> String {
    match text.parse::<f64>() {
        Ok(value) if value != 0.0 && value.abs() < 1e-3 => format!("{value:e}"),
        _ => text.to_owned(),
    }
}

/// Returns a text of the help in Markdown: flags as code, asterisks as they are.
fn marked(text: &str) -> String {
    let word = |word: &str| {
        let Some(start) = word.find("--") else { return word.replace('*', "\\*") };
        let is_end = |letter: char| !letter.is_ascii_alphanumeric() && letter != '-';
        let end = word[start..].find(is_end).map_or(word.len(), |length| start + length);
        format!("{}`{}`{}", &word[..start], &word[start..end], &word[end..])
    };
    text.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// Row of the page: an option of one or more commands that describe it alike.
#[derive(PartialEq)]
struct Row {
    heading: Option<String>,
    key: String,
    cells: [String; 5],
    commands: Vec<String>,
}

impl Row {
    fn of(command: &str, arg: &Arg) -> Self {
        let name = key(arg);
        let (meaning, default) = meaning_and_default(arg);
        let names = match argument(name) {
            same if same == name && arg.get_long().is_some_and(|long| long.replace('-', "_") == name) => String::new(),
            same if same == name => format!("`{name}`"),
            other => format!("`{other}`, `{name}`"),
        };
        let texts = [kinds(name).join(", "), default, meaning].map(|text| marked(&text));
        let [kinds, default, meaning] = texts;
        let cells = [format!("`{}`", flag(arg)), names, kinds, default, meaning];
        let cells = cells.map(|cell| cell.replace('|', "\\|"));
        let heading = arg.get_help_heading().map(str::to_owned);
        Self { heading, key: name.to_owned(), cells, commands: vec![command.to_owned()] }
    }

    /// Returns the row, with its commands if they are not the commands of the group.
    fn line(&self, group: &[String]) -> String {
        let [flag, names, kinds, default, meaning] = &self.cells;
        let commands = if self.commands == group { String::new() } else { format!("{}: ", self.commands.join(", ")) };
        let row = [flag, names, kinds, default, &format!("{commands}{meaning}")];
        row.iter()
            .fold("|".to_owned(), |line, cell| if cell.is_empty() { line + " |" } else { format!("{line} {cell} |") })
    }
}

/// Returns the rows of all commands; options that commands describe alike share a row.
fn rows(program: &Command) -> Vec<Row> {
    let of = |command: &str, arg: &Arg| Row::of(command, arg);
    let own = program.get_subcommands().flat_map(|command| flags(command).map(|arg| of(command.get_name(), arg)));
    let mut rows: Vec<Row> = Vec::new();
    for row in own.chain(flags(program).map(|arg| of("all", arg))) {
        match rows.iter_mut().find(|other| (&other.heading, &other.cells) == (&row.heading, &row.cells)) {
            Some(other) => other.commands.extend(row.commands),
            None => rows.push(row),
        }
    }
    rows
}

/// Returns values in the order in which they first occur.
fn in_order<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    values.fold(Vec::new(), |mut found, value| {
        if !found.contains(&value) {
            found.push(value);
        }
        found
    })
}

const HEAD: &str = "# Options

<!-- Made from the flags of crates/cli/src by `GFMD_DOCS=write cargo test -p gfmd-cli -- options`. -->

All options of all commands, in the groups of `--help`. The key of an option in configurations, files and messages, and
its argument in Python, are the flag without the leading hyphens, with `_` in place of `-`; the second column has the
exceptions, the argument first. The third is the kind of the numbers that may have a unit ([units](units.md)), in turn
for a list; 1 is a number without one. A meaning begins with the commands if they are not the commands of the group.
[Interface](interface.md) explains the commands, and [together](together.md) says which options exclude each other.
";

#[test]
fn the_page_of_options_has_every_option() {
    let rows = rows(&program::command());
    let mut page = HEAD.to_owned();
    let mut headings = in_order(rows.iter().map(|row| &row.heading));
    // The options without a group come last.
    headings.sort_by_key(|heading| heading.is_none());
    for heading in headings {
        let title = heading.as_deref().unwrap_or("Further options");
        let head = "| flag | argument, key | kind | default | meaning |\n|---|---|---|---|---|";
        let there: Vec<&Row> = rows.iter().filter(|row| &row.heading == heading).collect();
        let count = |commands: &[String]| there.iter().filter(|row| row.commands == commands).count();
        let group = there.iter().rev().max_by_key(|row| count(&row.commands)).map_or(&[][..], |row| &row.commands);
        let _ = writeln!(page, "\n## {title}\n\nOf {}.\n\n{head}", group.join(", "));
        for key in in_order(there.iter().map(|row| &row.key)) {
            for row in there.iter().filter(|row| &row.key == key) {
                page += &row.line(group);
                page.push('\n');
            }
        }
    }
    compare("docs/options.md", &page);
}

/// Each flag stands in a group of its own choice, not in the group of a flag before it.
#[test]
fn options_of_commands_with_groups_have_one() {
    for command in program::command().get_subcommands() {
        let groups: BTreeSet<_> = flags(command).map(Arg::get_help_heading).collect();
        assert!(groups.len() <= 1 || !groups.contains(&None), "{}: {groups:?}", command.get_name());
    }
}

/// Types of arguments that Python takes in a form of its own.
const TYPES: [(&str, &str); 16] = [
    ("accuracy", "float | str"),
    ("cells", "str | Sequence[Quantity]"),
    ("damping", "float | Sequence[float]"),
    ("distance", "Quantity | npt.ArrayLike"),
    ("heat", "Sequence[Quantity]"),
    ("history_mode", "Sequence[tuple[int, int, str]]"),
    ("history_point", "Sequence[tuple[float, float, str]]"),
    ("law", "Law | str"),
    ("lower_surface", "Surface | npt.ArrayLike"),
    ("shape", "str"),
    ("shift", "Sequence[float]"),
    ("slice", "str"),
    ("steps", "int | Sequence[int]"),
    ("time", "Quantity | npt.ArrayLike"),
    ("times", "npt.ArrayLike"),
    ("wlf", "tuple[float, float, float]"),
];

/// Returns the type of the Python argument of an option.
fn type_of(arg: &Arg, has_units: bool) -> String {
    if let Some((_, of)) = TYPES.iter().find(|(other, _)| *other == key(arg)) {
        return (*of).to_owned();
    }
    let parser = arg.get_value_parser().type_id();
    let is_any = |types: &[TypeId]| types.iter().any(|of| parser == *of);
    let choices = choices(arg);
    let integers = [TypeId::of::<u8>(), TypeId::of::<u32>(), TypeId::of::<u64>(), TypeId::of::<usize>()];
    let one = match () {
        () if !takes_value(arg) => "bool".to_owned(),
        () if !choices.is_empty() => {
            let names: Vec<String> = choices.iter().map(|name| format!("\"{name}\"")).collect();
            format!("Literal[{}]", names.join(", "))
        }
        () if is_any(&[TypeId::of::<GivenHardness>()]) => "Quantity | npt.ArrayLike".into(),
        () if has_units && !kinds(key(arg)).is_empty() => "Quantity".into(),
        () if is_any(&[TypeId::of::<f64>()]) => "float".into(),
        () if is_any(&integers) => "int".into(),
        () if is_any(&[TypeId::of::<PathBuf>()]) => "str | os.PathLike[str]".into(),
        () if is_any(&[TypeId::of::<gfmd_problem::options::given::ArrayOption>()]) => "npt.ArrayLike".into(),
        () => "str".into(),
    };
    if matches!(arg.get_action(), ArgAction::Append) { format!("Sequence[{one}]") } else { one }
}

/// Returns the default of the Python argument of an option; null if it depends on others.
fn default_of(arg: &Arg, of: &str) -> Value {
    if !takes_value(arg) {
        return false.into();
    }
    let given: Vec<_> = arg.get_default_values().iter().map(|value| value.to_string_lossy()).collect();
    let first = of.split(" | ").next().unwrap_or(of);
    let one = |text: &str| match first.trim_start_matches("Sequence[").trim_end_matches(']') {
        "float" | "Quantity" => text.parse::<f64>().map_or_else(|_| text.into(), Value::from),
        "int" => text.parse::<u64>().map_or_else(|_| text.into(), Value::from),
        _ => Value::from(text),
    };
    match &given[..] {
        // A law of Python has parameters, and a hard wall is no law; nothing is written by default.
        _ if ["law", "out"].contains(&key(arg)) => Value::Null,
        [] if of.starts_with("Sequence[") => Value::Array(Vec::new()),
        [] => Value::Null,
        all if of.starts_with("Sequence[") => all.iter().map(|text| one(text)).collect(),
        [text, ..] => one(text),
    }
}

/// Returns the meaning of an option with the names of Python's arguments in place of flags.
fn meaning(arg: &Arg) -> String {
    let (text, _) = meaning_and_default(arg);
    let word = |word: &str| {
        let Some((before, flag)) = word.split_once("--") else { return word.to_owned() };
        let end = flag.find(|letter: char| !letter.is_ascii_alphanumeric() && letter != '-').unwrap_or(flag.len());
        format!("{before}`{}`{}", argument(&flag[..end].replace('-', "_")), &flag[end..])
    };
    text.split(' ').map(word).collect::<Vec<_>>().join(" ")
}

/// Line of a typed dictionary, as `black` breaks it.
fn line(name: &str, of: &str, is_optional: bool) -> String {
    let [open, close] = if is_optional { ["Optional[", "]"] } else { ["", ""] };
    let whole = format!("    {name}: {open}{of}{close}\n");
    let names = of.strip_prefix("Literal[").and_then(|rest| rest.strip_suffix(']'));
    match names {
        Some(names) if is_optional && whole.chars().count() > 121 => {
            let names = names.replace(", ", ",\n            ");
            format!("    {name}: Optional[\n        Literal[\n            {names},\n        ]\n    ]\n")
        }
        _ => whole,
    }
}

/// Typed dictionary of the options that a function takes beside arguments of its own.
struct Class {
    name: &'static str,
    text: &'static str,
    command: &'static str,
    /// Options of the command, or of all commands, that the function takes.
    keys: Vec<String>,
    /// Names, types and meanings of arguments without a flag.
    further: &'static [[&'static str; 3]],
}

impl Class {
    /// Returns the options of the class.
    fn args<'a>(&'a self, program: &'a Command) -> impl Iterator<Item = &'a Arg> {
        let command = program.find_subcommand(self.command).unwrap();
        flags(command).chain(flags(program)).filter(|arg| self.keys.iter().any(|other| other == key(arg)))
    }

    fn type_of(&self, arg: &Arg) -> String {
        type_of(arg, !["punch", "green", "prony"].contains(&self.command))
    }

    /// Returns the class as Python.
    fn text(&self, program: &Command) -> String {
        let own = self.args(program).map(|arg| line(argument(key(arg)), &self.type_of(arg), takes_value(arg)));
        let further = self.further.iter().map(|[name, of, _]| line(name, of, true));
        let lines: String = own.chain(further).collect();
        format!("\n\nclass {}(TypedDict, total=False):\n    \"\"\"{}\"\"\"\n\n{lines}", self.name, self.text)
    }

    /// Returns type, default and meaning of each option by its argument.
    fn table(&self, program: &Command) -> Value {
        let row = |of: &str, default: Value, meaning: &str| json!({"type": of, "default": default, "meaning": meaning});
        let own = self.args(program).map(|arg| {
            let of = self.type_of(arg);
            (argument(key(arg)).to_owned(), row(&of, default_of(arg, &of), &meaning(arg)))
        });
        let further =
            self.further.iter().map(|[name, of, meaning]| ((*name).to_owned(), row(of, Value::Null, meaning)));
        Value::Object(own.chain(further).collect())
    }
}

/// Returns the keys that Python has as options: not in other groups, and not in `further`.
fn without(keys: Vec<String>, elsewhere: &[Vec<String>], further: &[&str]) -> Vec<String> {
    let is_elsewhere = |key: &String| elsewhere.iter().flatten().any(|other| other == key);
    keys.into_iter().filter(|key| !is_elsewhere(key) && !further.contains(&&**key)).collect()
}

/// Returns the head of a file of types that imports these names.
fn head_of_types(typing: &str, imports: &str) -> String {
    format!(
        r#""""Types of the options that functions take as keyword arguments; None is the default.

Made from the flags of crates/cli/src by `GFMD_DOCS=write cargo test -p gfmd-cli -- options`.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import {typing}

{imports}"#
    )
}

/// Imports of the options of a contact; a contact imports its results, whose options are apart.
const OF_CONTACTS: &str = "import numpy.typing as npt

from ._check import Quantity

if TYPE_CHECKING:
    from ._body import Law
    from ._contact import Contact
    from ._surface import Surface
";

#[test]
fn python_has_the_types_of_the_options() {
    let program = program::command();
    let all = |command: &str| flags(program.find_subcommand(command).unwrap()).map(|arg| key(arg).to_owned()).collect();
    let body = [keys::<SourceArgs>(), keys::<BodyArgs>(), keys::<ComplianceArgs>(), keys::<PronyArgs>()];
    let elastic = [keys::<BodyArgs>()];
    let with = |mut keys: Vec<String>, further: &[&str]| {
        keys.extend(further.iter().map(|key| (*key).to_owned()));
        keys
    };
    // Arguments of the functions, of `Law` and `Wear`, and of the program alone.
    let loads = [
        "pressure",
        "p_star",
        "force",
        "approach",
        "param",
        "law_table",
        "lower_seed",
        "plots",
        "resume",
        "checkpoint",
        "compare",
    ];
    let parts = ["lateral", "lateral_y", "friction", "shear_strength", "coefficient", "wear_by", "distance"];
    let of_body = ["yield_stress", "hardening", "hardening_curve", "kinematic_hardening", "layer_yield"];
    let path = without(all("path"), &body, &[&loads[..], &parts, &of_body].concat());
    let slide = without(all("slide"), &body, &[&loads[..], &["velocity"]].concat());
    let places = ["levels", "deepest", "slice", "quantities", "out", "threads"];
    const START: [&str; 3] = ["start", "Contact", "a contact of the same surface to start from"];
    let classes = [
        Class {
            name: "ContactOptions",
            text: "Arguments of `contact` beside the load.",
            command: "contact",
            keys: with(without(keys::<ContactArgs>(), &body, &loads), &["stress_unit", "threads"]),
            further: &[START],
        },
        Class {
            name: "PathOptions",
            text: "Arguments of `path` beside those of `friction` and `wear`.",
            command: "path",
            keys: with(path, &["stress_unit", "threads"]),
            further: &[],
        },
        Class {
            name: "SlideOptions",
            text: "Arguments of `slide` beside load and velocity.",
            command: "slide",
            keys: with(slide, &["stress_unit", "threads"]),
            further: &[],
        },
        Class {
            name: "InteriorOptions",
            text: "Arguments of `interior` beside the depths.",
            command: "body",
            keys: with(Vec::new(), &places),
            further: &[],
        },
        Class {
            name: "PunchOptions",
            text: "Arguments of `punch` beside the body.",
            command: "punch",
            keys: with(without(all("punch"), &elastic, &loads), &["threads"]),
            further: &[],
        },
        Class {
            name: "GreenOptions",
            text: "Arguments of `green` beside the body and the wave vector along x.",
            command: "green",
            keys: without(all("green"), &elastic, &["qx"]),
            further: &[],
        },
        Class {
            name: "EstimateOptions",
            text: "Arguments of `estimate` beside the load.",
            command: "estimate",
            keys: with(Vec::new(), &["hardness", "stress_unit"]),
            further: &[],
        },
        Class {
            name: "PronyOptions",
            text: "Arguments of `prony` beside the measured moduli.",
            command: "prony",
            keys: with(Vec::new(), &["wlf", "stress_unit", "branches", "times", "long_term"]),
            further: &[],
        },
        Class {
            name: "SweepOptions",
            text: "Arguments of `kappa_sweep` beside the configuration.",
            command: "kappa-sweep",
            keys: with(Vec::new(), &["out", "resume", "threads"]),
            further: &[],
        },
        Class {
            name: "StudyOptions",
            text: "Arguments of `study` beside the configuration.",
            command: "study",
            keys: with(Vec::new(), &["out", "resume", "threads"]),
            further: &[],
        },
    ];
    let text = |classes: &[Class]| classes.iter().map(|class| class.text(&program)).collect::<String>();
    let (of_contacts, inside) = classes.split_at(3);
    let head = head_of_types("TYPE_CHECKING, Literal, Optional, TypedDict", OF_CONTACTS);
    compare("crates/python/python/gfmd/_options.py", &(head + &text(of_contacts)));
    let imports = "import numpy.typing as npt\n\nfrom ._check import Quantity\n";
    let head = head_of_types("Literal, Optional, TypedDict", imports);
    compare("crates/python/python/gfmd/_options_inside.py", &(head + &text(inside)));
    // Objects with the options of a group, whose arguments have forms of their own.
    let of = |name, command, keys| Class { name, text: "", command, keys, further: &[] };
    let own: Vec<String> = of_body.iter().map(|key| (*key).to_owned()).collect();
    let groups = [
        of("Body", "path", [&body[1..], &[own]].concat().concat()),
        of("Wear", "path", with(Vec::new(), &["coefficient", "wear_by"])),
        of("self_affine", "surface", with(keys::<GeneratorArgs>(), &["size", "unit"])),
    ];
    let tables = classes.iter().chain(&groups).map(|class| (class.name.to_owned(), class.table(&program))).collect();
    let tables = serde_json::to_string_pretty(&Value::Object(tables)).unwrap() + "\n";
    compare("crates/python/python/gfmd/_options.json", &tables);
}
