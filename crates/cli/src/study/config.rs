//! Configuration of a study: a command with its options, and the lists whose product are its members.

use std::collections::BTreeMap;
use std::fmt::Display;

use gfmd_input::failure::Failure;
use gfmd_input::source::file_of;
use gfmd_problem::options::GeneratorArgs;
use gfmd_problem::options::flags::{line, quoted};
use toml::{Table, Value};

use super::inputs::files_of;
use super::solve::{Command, Problem};

/// Options that are not of the problem, or whose output a study does not have.
pub(super) const REFUSED: [&str; 12] = [
    "out",
    "resume",
    "checkpoint",
    "plots",
    "vtk",
    "export_law",
    "export_law_format",
    "fields",
    "history",
    "history_mode",
    "history_point",
    "flow_threshold",
];

/// Options of the states, which are the same for all members.
pub(super) const STATES: [&str; 10] =
    ["pressure", "p_star", "force", "approach", "lateral", "lateral_y", "distance", "time", "velocity", "steps"];

/// Largest number of members of a study, so that its plan does not fill the memory.
const MOST_MEMBERS: usize = 1_000_000;

/// Largest seed: whole numbers that are coordinates of a file.
const LARGEST_SEED: i64 = 1 << 53;

/// Surface or body of a study: its name, and the options that it sets.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice {
    pub(super) name: String,
    keys: Table,
}

/// Configuration of a study.
#[derive(Clone, Debug)]
pub(super) struct StudyConfig {
    pub(super) command: Command,
    base: Table,
    pub(super) surfaces: Vec<Choice>,
    pub(super) seeds: Vec<u64>,
    pub(super) bodies: Vec<Choice>,
    /// True if the seeds were given as a list.
    has_seeds: bool,
}

impl StudyConfig {
    /// Reads a study from a table; `name` is its name in messages.
    ///
    /// # Errors
    /// Returns an error for an unknown key, an empty list, a value of another type, and members that are equal.
    pub(super) fn read(name: &str, mut table: Table) -> Result<Self, Failure> {
        let command = match table.remove("command") {
            Some(Value::String(word)) => Command::of(&word),
            _ => None,
        };
        let Some(command) = command else {
            return Err(Failure::refused(format!(
                "{name}: command is missing or unknown; it must be {}",
                Command::LISTED
            )));
        };
        let own = command.name();
        if let Some(key) = table.keys().find(|key| *key != own && *key != "study") {
            return Err(unknown(name, key, &["command", own, "study"]));
        }
        let mut group = |group: &str| match table.remove(group) {
            Some(Value::Table(table)) => Ok(table),
            None => Ok(Table::new()),
            Some(other) => Err(wrong(name, group, &other, "a table")),
        };
        let (base, mut lists) = (group(own)?, group("study")?);
        check_keys(&format!("{name}: [{own}]"), command, &base, &[])?;
        if let Some(key) = lists.keys().find(|key| !["surface", "seed", "body"].contains(&key.as_str())) {
            return Err(unknown(&format!("{name}: [study]"), key, &["surface", "seed", "body"]));
        }
        if let Some(key) =
            ["surface", "seed"].into_iter().find(|key| lists.contains_key(*key) && base.contains_key(*key))
        {
            return Err(Failure::refused(format!(
                "{name}: {key} is in [{own}] and in [study]; it must be in one of them"
            )));
        }
        let place = |key: &str| format!("{name}: [study] {key}");
        let has_seeds = lists.contains_key("seed");
        let seeds = match lists.remove("seed") {
            Some(list) => seeds(&place("seed"), &list)?,
            None => vec![match base.get("seed") {
                Some(seed) => one_seed(&format!("{name}: [{own}] seed"), seed)?,
                None => GeneratorArgs::default().seed,
            }],
        };
        let named = base.get("surface").or(base.get("shape")).and_then(Value::as_str).unwrap_or("generated").to_owned();
        let mut choices = |key: &str, default: String| match lists.remove(key) {
            Some(list) => choices(&place(key), key, command, list),
            None => Ok(vec![Choice { name: default, keys: Table::new() }]),
        };
        let (surfaces, bodies) = (choices("surface", named)?, choices("body", own.to_owned())?);
        for (surface, body) in surfaces.iter().flat_map(|surface| bodies.iter().map(move |body| (surface, body))) {
            if let Some(key) = surface.keys.keys().find(|key| body.keys.contains_key(*key)) {
                let found = format!("{key} is set by surface {:?} and by body {:?}", surface.name, body.name);
                return Err(Failure::refused(format!("{name}: {found}; it must be set by one of them")));
            }
        }
        let members = surfaces.len().saturating_mul(seeds.len()).saturating_mul(bodies.len());
        if members > MOST_MEMBERS {
            let reason = format!("the study has {members} members; it must have at most {MOST_MEMBERS}");
            return Err(Failure::input(name.to_owned(), reason));
        }
        Ok(Self { command, base, surfaces, seeds, bodies, has_seeds })
    }

    /// Refuses equal members, and members whose options cannot be read although their files are there.
    ///
    /// # Errors
    /// Returns an error that names the member.
    pub(super) fn check(&self, name: &str) -> Result<(), Failure> {
        let mut seen: BTreeMap<String, usize> = BTreeMap::new();
        for member in 0..self.members() {
            let mut table = self.table(member);
            self.command.leave_out_idle(&mut table);
            if let Some(other) = seen.insert(table.to_string(), member) {
                let [this, other] = [member, other].map(|member| self.place(member));
                let why = "each must differ (a surface in a file has no seed)";
                return Err(Failure::refused(format!("{name}: {this} is the same contact as {other}; {why}")));
            }
        }
        for member in (0..self.members()).filter(|member| self.at(*member)[1] == 0) {
            let table = self.table(member);
            let is_there = files_of(&table).iter().all(|file| std::fs::File::open(file).is_ok());
            match Problem::of(self.command, table) {
                Err(failure) if is_there => return Err(failure.at(format!("{name}: {}", self.place(member)))),
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns the number of members.
    pub(super) fn members(&self) -> usize {
        self.surfaces.len() * self.seeds.len() * self.bodies.len()
    }

    /// Returns the places of a member in the lists of surfaces, seeds and bodies.
    fn at(&self, member: usize) -> [usize; 3] {
        let (seeds, bodies) = (self.seeds.len(), self.bodies.len());
        [member / (seeds * bodies), member / bodies % seeds, member % bodies]
    }

    /// Returns a member in words.
    pub(super) fn place(&self, member: usize) -> String {
        let [surface, seed, body] = self.at(member);
        let (surface, seed, body) = (&self.surfaces[surface].name, self.seeds[seed], &self.bodies[body].name);
        line(&format!("surface {surface:?}, seed {seed}, body {body:?}"))
    }

    /// Returns the options of a member.
    pub(super) fn table(&self, member: usize) -> Table {
        let [surface, seed, body] = self.at(member);
        let mut table = self.base.clone();
        if self.has_seeds {
            table.insert("seed".into(), Value::Integer(self.seeds[seed] as i64));
        }
        table.extend(self.surfaces[surface].keys.clone());
        table.extend(self.bodies[body].keys.clone());
        table
    }

    /// Returns the names of the files that the members read.
    pub(super) fn files(&self) -> Vec<String> {
        let all = [&self.base].into_iter().chain(self.surfaces.iter().chain(&self.bodies).map(|choice| &choice.keys));
        all.flat_map(files_of).collect()
    }

    /// Returns the expected number of grid points of a member, as a measure of its work.
    pub(super) fn points(&self, member: usize) -> u64 {
        const BYTES_OF_A_POINT: u64 = 4;
        const DEFAULT: u64 = 256;
        let table = self.table(member);
        if let Some(surface) = table.get("surface").and_then(Value::as_str) {
            let length = std::fs::metadata(file_of(surface)).map_or(0, |about| about.len());
            return length / BYTES_OF_A_POINT;
        }
        let sides: Vec<u64> = match table.get("n") {
            Some(Value::Integer(n)) => vec![*n as u64],
            Some(Value::Array(sides)) => sides.iter().filter_map(|n| n.as_integer().map(|n| n as u64)).collect(),
            _ => vec![DEFAULT],
        };
        let is_line = table.get("dim").and_then(Value::as_integer) == Some(2);
        match sides[..] {
            [n] if is_line => n,
            [n] => n.saturating_mul(n),
            _ => sides.iter().fold(1, |product, n| product.saturating_mul(*n)),
        }
    }

    /// Returns the configuration as TOML, with all lists written out.
    ///
    /// # Errors
    /// Returns an error for a value that TOML does not have.
    pub(super) fn text(&self) -> Result<String, Failure> {
        let list = |choices: &[Choice]| -> Value {
            let table = |choice: &Choice| {
                let named = [("name".to_owned(), Value::from(choice.name.clone()))];
                Value::Table(named.into_iter().chain(choice.keys.clone()).collect())
            };
            choices.iter().map(table).collect::<Vec<_>>().into()
        };
        let mut lists = Table::new();
        let is_given = |choices: &[Choice]| choices.len() > 1 || choices.iter().any(|choice| !choice.keys.is_empty());
        if is_given(&self.surfaces) {
            lists.insert("surface".into(), list(&self.surfaces));
        }
        if self.has_seeds {
            let seeds: Vec<Value> = self.seeds.iter().map(|seed| Value::Integer(*seed as i64)).collect();
            lists.insert("seed".into(), seeds.into());
        }
        if is_given(&self.bodies) {
            lists.insert("body".into(), list(&self.bodies));
        }
        let mut all = Table::new();
        all.insert("command".into(), self.command.name().into());
        all.insert(self.command.name().into(), self.base.clone().into());
        all.insert("study".into(), lists.into());
        toml::to_string(&all).map_err(|error| Failure::computation(error.to_string()))
    }
}

fn unknown(place: &str, key: &str, allowed: &[&str]) -> Failure {
    Failure::refused(format!("{place}: {} is no key; it must be one of {}", quoted(key), allowed.join(", ")))
}

fn wrong(place: &str, key: &str, found: &Value, allowed: impl Display) -> Failure {
    Failure::refused(format!("{place}: {key} is {}; it must be {allowed}", line(&found.to_string())))
}

/// Checks the keys of a table of options; those in `without` are refused, too.
fn check_keys(place: &str, command: Command, table: &Table, without: &[&str]) -> Result<(), Failure> {
    let all = command.keys();
    let allowed: Vec<&str> =
        (all.iter().map(String::as_str)).filter(|key| !REFUSED.contains(key) && !without.contains(key)).collect();
    for key in table.keys() {
        if without.contains(&key.as_str()) && STATES.contains(&key.as_str()) {
            let reason = format!("it must be in [{}], since all members have the same", command.name());
            return Err(Failure::refused(format!("{place}: {key} is set here; {reason}")));
        }
        if !allowed.contains(&key.as_str()) {
            return Err(unknown(place, key, &allowed));
        }
    }
    Ok(())
}

fn one_seed(place: &str, value: &Value) -> Result<u64, Failure> {
    let found = value.as_integer().filter(|seed| (0..=LARGEST_SEED).contains(seed));
    let allowed = || format!("a whole number from 0 to {LARGEST_SEED}, or \"A:B\" for all from A to B");
    found
        .map(|seed| seed as u64)
        .ok_or_else(|| Failure::refused(format!("{place} is {}; it must be {}", line(&value.to_string()), allowed())))
}

/// Reads a list of seeds: whole numbers, and ranges "A:B" with both ends.
pub(super) fn seeds(place: &str, list: &Value) -> Result<Vec<u64>, Failure> {
    let entries = match list {
        Value::Array(entries) => &entries[..],
        single => std::slice::from_ref(single),
    };
    let mut all = Vec::new();
    for entry in entries {
        let range = entry.as_str().and_then(|text| text.split_once(':')).and_then(|(first, last)| {
            let ends = [first, last].map(|end| end.parse::<i64>().ok().filter(|end| (0..=LARGEST_SEED).contains(end)));
            let [Some(first), Some(last)] = ends else { return None };
            (first <= last && last - first < MOST_MEMBERS as i64).then_some(first as u64..=last as u64)
        });
        match range {
            Some(range) => all.extend(range),
            None => all.push(one_seed(place, entry)?),
        }
    }
    if all.is_empty() {
        return Err(Failure::refused(format!("{place} is empty; it must have at least one value")));
    }
    let mut sorted = all.clone();
    sorted.sort_unstable();
    if let Some(twice) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(Failure::refused(format!("{place} has {} twice; each must differ", twice[0])));
    }
    Ok(all)
}

/// Reads a list of surfaces or bodies: tables of options with a name; a surface may be the name of a file alone.
fn choices(place: &str, key: &str, command: Command, list: Value) -> Result<Vec<Choice>, Failure> {
    let allowed = match key {
        "surface" => "a list of files or of tables of options",
        _ => "a list of tables of options",
    };
    let refuse =
        |found: &Value| Failure::refused(format!("{place} is {}; it must be {allowed}", line(&found.to_string())));
    let Value::Array(entries) = list else { return Err(refuse(&list)) };
    let mut all: Vec<Choice> = Vec::new();
    for entry in entries {
        let choice = match entry {
            Value::String(file) if key == "surface" => {
                Choice { name: file.clone(), keys: [("surface".to_owned(), Value::from(file))].into_iter().collect() }
            }
            Value::Table(mut keys) => {
                let name = match keys.remove("name") {
                    Some(Value::String(name)) => name,
                    None => keys.iter().map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", "),
                    Some(other) => return Err(wrong(place, "name", &other, "a text")),
                };
                let without: Vec<&str> = STATES.into_iter().chain(["seed"]).collect();
                check_keys(&format!("{place} {name:?}"), command, &keys, &without)?;
                Choice { name, keys }
            }
            other => return Err(refuse(&other)),
        };
        if choice.name.is_empty() {
            return Err(Failure::refused(format!("{place} has an entry without a name and options; it must have one")));
        }
        if all.iter().any(|known| known.name == choice.name) {
            return Err(Failure::refused(format!("{place} has {:?} twice; each name must differ", choice.name)));
        }
        all.push(choice);
    }
    if all.is_empty() {
        return Err(Failure::refused(format!("{place} is empty; it must have at least one entry")));
    }
    Ok(all)
}
