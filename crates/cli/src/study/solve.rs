//! One member of a study, solved by its command.

use std::collections::BTreeMap;
use std::path::Path;

use clap::Args as ClapArgs;
use gfmd_check::study::StateAxis;
use gfmd_files::Checksum;
use gfmd_input::failure::{Failure, Outcome};
use gfmd_input::session::Session;
use gfmd_input::units::of_table;
use gfmd_problem::Written;
use gfmd_problem::options::flags::{keys, leave_out_idle, of_keys};
use gfmd_problem::options::given::Arrays;
use gfmd_problem::options::values::{Entry, numbers};
use gfmd_problem::options::{Kinds, Options};
use gfmd_record::{Origin, Record, Subject, columns, reasons};
use gfmd_unit::Units;
use serde::de::DeserializeOwned;
use toml::{Table, Value};

use super::inputs::files_of;
use super::member::{Member, MemberColumn};
use crate::kinds::kinds;
use crate::{contact, path, slide};

/// Command of the members of a study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    Contact,
    Path,
    Slide,
}

impl Command {
    /// Names of all commands, as in a message.
    pub(super) const LISTED: &str = "\"contact\", \"path\" or \"slide\"";

    pub(super) fn of(name: &str) -> Option<Self> {
        [Self::Contact, Self::Path, Self::Slide].into_iter().find(|command| command.name() == name)
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Path => "path",
            Self::Slide => "slide",
        }
    }

    /// Returns the keys of the options of the command.
    pub(super) fn keys(self) -> Vec<String> {
        match self {
            Self::Contact => keys::<contact::Args>(),
            Self::Path => keys::<path::Args>(),
            Self::Slide => keys::<slide::Args>(),
        }
    }

    /// Removes options that do nothing beside the others.
    pub(super) fn leave_out_idle(self, table: &mut Table) {
        match self {
            Self::Contact => leave_out_idle::<contact::Args>(table),
            Self::Path => leave_out_idle::<path::Args>(table),
            Self::Slide => leave_out_idle::<slide::Args>(table),
        }
    }
}

/// Problem of a member.
pub(super) enum Problem {
    Contact(Box<contact::Args>),
    Path(Box<path::Args>),
    Slide(Box<slide::Args>),
}

/// Reads the options of a command from a table, and the quantities as they were written. A single value stands for a
/// list of one.
fn options<A: ClapArgs + Options + DeserializeOwned>(command: &str, mut table: Table) -> Result<(A, Written), Failure> {
    let flags = A::augment_args(clap::Command::new("gfmd"));
    leave_out_idle::<A>(&mut table);
    for flag in flags.get_arguments().filter(|flag| flag.get_value_delimiter().is_some()) {
        if let Some(value) = table.get_mut(flag.get_id().as_str())
            && matches!(value, Value::Integer(_) | Value::Float(_) | Value::String(_))
        {
            *value = Value::Array(vec![value.clone()]);
        }
    }
    let written = of_table(command, &mut table, &Arrays::new(), kinds())?;
    for key in RANGES {
        write_out(key, &mut table)?;
    }
    Ok((of_keys(table, Arrays::new())?, written))
}

/// Options whose values may be ranges "A:B:N".
const RANGES: [&str; 7] = ["pressure", "p_star", "force", "approach", "distance", "time", "velocity"];

/// Puts the values of ranges "A:B:N" of an option in their place.
fn write_out(key: &'static str, table: &mut Table) -> Result<(), Failure> {
    let Some(Value::Array(entries)) = table.get_mut(key) else { return Ok(()) };
    for entry in std::mem::take(entries) {
        let Some(text) = entry.as_str().filter(|text| text.contains(':')) else {
            entries.push(entry);
            continue;
        };
        let made = text.parse::<Entry>();
        let made = made.map_err(|reason| Failure::input(gfmd_problem::key(key), format!("{entry}: {reason}")))?;
        entries.extend(numbers(&[made]).map(Value::from));
    }
    Ok(())
}

impl Problem {
    /// Reads the problem of a member from its options, and the quantities as they were written.
    ///
    /// # Errors
    /// Returns an error for options that cannot be read, and for units of a file that cannot.
    pub(super) fn of(command: Command, table: Table) -> Result<(Self, Written), Failure> {
        fn boxed<A>((args, written): (A, Written), make: fn(Box<A>) -> Problem) -> (Problem, Written) {
            (make(Box::new(args)), written)
        }
        let name = command.name();
        Ok(match command {
            Command::Contact => boxed(options(name, table)?, Self::Contact),
            Command::Path => boxed(options(name, table)?, Self::Path),
            Command::Slide => boxed(options(name, table)?, Self::Slide),
        })
    }

    /// Returns the loads, and the velocities of steady sliding; nothing for a path.
    pub(super) fn coordinates(&self) -> Vec<Vec<f64>> {
        match self {
            Self::Contact(args) => vec![args.loads().1],
            Self::Path(_) => Vec::new(),
            Self::Slide(args) => {
                let (_, loads, velocities) = args.loads();
                vec![loads, velocities]
            }
        }
    }

    fn config(&self) -> Result<String, Failure> {
        match self {
            Self::Contact(args) => args.config(),
            Self::Path(args) => args.config(),
            Self::Slide(args) => args.config(),
        }
    }

    /// Solves the problem.
    fn run(&self, session: &Session, member: &mut Member) -> Result<Option<Failure>, Failure> {
        match self {
            Self::Contact(args) => {
                let Outcome { report, failure } = contact::run(args, session)?;
                let (option, values) = args.loads();
                let units = report.head.units();
                member.axes = vec![loads(option, values, &units)];
                member.numbers(&report.facts, &units, &report.loads, ["load", "loads"]);
                member.units = [report.head.unit, report.head.stress_unit];
                Ok(failure)
            }
            Self::Path(args) => {
                let Outcome { report, failure } = path::run(args, session)?;
                let (units, length) = (report.head.units(), report.steps.len());
                let long_name = "step of the path".to_owned();
                member.axes =
                    vec![StateAxis { name: "step".into(), values: None, length, units: "1".into(), long_name }];
                member.numbers(&report.facts, &units, &report.steps, ["step", "steps"]);
                member.units = [report.head.unit, report.head.stress_unit];
                Ok(failure)
            }
            Self::Slide(args) => {
                let Outcome { report, failure } = slide::run(args, session)?;
                let (option, values, velocities) = args.loads();
                let units = report.head.units();
                let velocity = StateAxis {
                    name: "velocity".into(),
                    length: velocities.len(),
                    values: Some(velocities),
                    units: units.name("length/time"),
                    long_name: "velocity of the rigid surface relative to the body".into(),
                };
                member.axes = vec![loads(option, values, &units), velocity];
                member.numbers(&report.facts, &units, &report.states, ["state", "states"]);
                member.units = [report.head.unit, report.head.stress_unit];
                Ok(failure)
            }
        }
    }
}

/// Returns the axis of the loads that an option gives.
fn loads(option: &str, values: Vec<f64>, units: &Units) -> StateAxis {
    let long_name = match option {
        "pressure" => "mean pressure",
        "p_star" => "reduced pressure p/(E* g)",
        "force" => "force on the whole surface",
        _ => "rigid approach beyond first touch",
    };
    let length = values.len();
    let units = units.name(Kinds::of(option, kinds()).in_turn()[0]);
    StateAxis { name: "load".into(), values: Some(values), length, units, long_name: long_name.into() }
}

impl Member {
    /// Takes the numbers of the states. A state that did not converge has none.
    fn numbers<S: Subject>(&mut self, facts: &S::Facts, units: &Units, records: &[Record<S>], name: [&str; 2]) {
        if let Some((number, value)) = records.iter().find_map(Record::overflow) {
            self.error = format!("{number} is {value}; it must be finite, and other units may make it so");
        }
        let present = columns::<S>(facts).filter(|column| (column.in_file)(facts) && column.origin != Origin::Clock);
        self.columns = present
            .map(|column| {
                let of = |record: &Record<S>| {
                    Some(record.number(column.name)).filter(|value| record.is("converged") && value.is_finite())
                };
                MemberColumn {
                    name: column.name.into(),
                    units: units.name(column.unit),
                    long_name: column.meaning(facts).into(),
                    undefined: reasons(records, column.name, name).unwrap_or_default(),
                    values: records.iter().map(of).collect(),
                }
            })
            .collect();
    }
}

/// Solves a member in a session `within` the study. A member that fails has its error, and the numbers of the states
/// before.
///
/// # Errors
/// Returns an error after an interruption.
pub(super) fn solve(command: Command, table: Table, within: &Session) -> Result<Member, Failure> {
    let mut member = Member { files: checksums(&table), ..Member::default() };
    // The warnings of the members are in the file, not on the terminal.
    let silent = tracing::subscriber::NoSubscriber::default();
    let solved = tracing::subscriber::with_default(silent, || {
        let (problem, written) = Problem::of(command, table)?;
        member.config = problem.config()?;
        problem.run(within, &mut member).map_err(|failure| failure.as_written(&written))
    });
    let failure = match solved {
        Ok(failure) => failure,
        Err(failure) => {
            member.is_refused = matches!(failure, Failure::Input(_));
            Some(failure)
        }
    };
    if let Some(failure) = failure {
        if matches!(failure, Failure::Interrupted(_)) {
            return Err(failure);
        }
        member.error = failure.to_string();
    }
    let warnings = within.warnings().into_iter().map(|warning| format!("{}: {}", warning.code, warning.text));
    member.warnings = warnings.collect::<Vec<_>>().join("\n");
    Ok(member)
}

/// Returns the checksums of the files of a member that can be read.
fn checksums(table: &Table) -> BTreeMap<String, String> {
    let sum = |file: String| Some((file.clone(), Checksum::of_file(Path::new(&file)).ok()?));
    files_of(table).into_iter().filter_map(sum).collect()
}
