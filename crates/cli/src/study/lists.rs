//! Lists of seeds and surfaces on the command line of one contact, which make a study of it.

use clap::{Args as ClapArgs, Parser};
use gfmd_input::failure::Failure;
use gfmd_input::units::{Word, of_words};
use gfmd_problem::{Written, flag, key, words};
use toml::{Table, Value};

use super::config::{REFUSED, STATES, seeds};
use super::solve::Command;
use crate::kinds::kinds;
use crate::line::one_line;
use crate::{contact, guess, inputs, path, slide};

/// Options of a study beside its configuration.
const OF_STUDY: [&str; 2] = ["out", "resume"];

/// Options of a command alone.
#[derive(Parser)]
struct Alone<A: ClapArgs> {
    #[command(flatten)]
    args: A,
}

fn parsed<A: ClapArgs>(words: &[Word]) -> Result<A, Failure> {
    let found = Alone::<A>::try_parse_from(words.iter().map(Word::text));
    found.map(|alone| alone.args).map_err(|error| Failure::refused(one_line(&error)))
}

impl Command {
    /// Returns the configuration of a command line of this command as a table.
    fn table(self, words: &[Word]) -> Result<Table, Failure> {
        let text = match self {
            Self::Contact => parsed::<contact::Args>(words)?.config()?,
            Self::Path => parsed::<path::Args>(words)?.config()?,
            Self::Slide => parsed::<slide::Args>(words)?.config()?,
        };
        text.parse().map_err(|error: toml::de::Error| Failure::computation(error.to_string()))
    }
}

/// Returns the key of the option to which a word belongs, as its flag or its value; `None` for other words.
fn option_of(word: &Word) -> Option<String> {
    let flag = || word.text().strip_prefix("--").map(|name| name.split('=').next().unwrap_or_default());
    word.given().map(|(key, _)| key.to_owned()).or_else(|| Some(flag()?.replace('-', "_")))
}

/// Returns the values of an option.
fn values<'a>(words: &'a [Word], option: &'a str) -> impl Iterator<Item = &'a str> {
    words.iter().filter_map(Word::given).filter(move |(key, _)| *key == option).map(|(_, value)| value)
}

/// Returns the words of the study that a command line of `contact`, `path` or `slide` with several seeds or surfaces
/// asks for, and its quantities as they were written; `None` without lists.
///
/// # Errors
/// Returns an error for options that a study does not have, and for words that cannot be read.
pub(crate) fn words_of_study(
    command: &clap::Command,
    given: &[String],
) -> Result<Option<(Vec<String>, Written)>, Failure> {
    let Some(sub) = given.iter().find_map(|word| command.find_subcommand(word)) else { return Ok(None) };
    let Some(of) = Command::of(sub.get_name()) else { return Ok(None) };
    let all = guess::understood(command, given)?;
    let listed: Vec<&str> = values(&all, "seed").flat_map(|value| value.split(',')).collect();
    let surfaces: Vec<&str> = values(&all, "surface").collect();
    if surfaces.len() < 2 && listed.len() < 2 && listed.iter().all(|seed| !seed.contains(':')) {
        return Ok(None);
    }
    inputs::stay(&all)?;
    if let Some((_, twice)) = surfaces.iter().enumerate().find(|(index, file)| surfaces[..*index].contains(file)) {
        return Err(Failure::contradicts(key("surface"), format!("{twice} twice"), "each must differ"));
    }
    let is_common = |key: &str| command.get_arguments().any(|common| common.get_id() == key);
    let refused = |key: &String| REFUSED.contains(&key.as_str()) && !OF_STUDY.contains(&key.as_str());
    if let Some(refused) = all.iter().filter_map(option_of).find(refused) {
        let lists = words![key("seed"), " or ", key("surface")];
        let why = words!["it must be left out with several of ", lists, ", which make a study"];
        return Err(Failure::contradicts(key(&refused), "given", why));
    }
    let (mut study, mut alone) = (vec![given[0].clone(), "study".to_owned()], vec![Word::plain(of.name())]);
    for word in all.iter().skip(1) {
        let short = word.text().starts_with('-') && !word.text().starts_with("--") && word.given().is_none();
        match option_of(word) {
            Some(option) if is_common(&option) || OF_STUDY.contains(&option.as_str()) => study.push(word.text().into()),
            Some(option) if option == "seed" || option == "surface" => {}
            None if short => study.push(word.text().into()),
            None if command.find_subcommand(word.text()).is_some() => {}
            _ => alone.push(word.clone()),
        }
    }
    // The options of each surface, in its units.
    let (mut tables, mut written) = (Vec::new(), Written::default());
    for surface in surfaces.iter().copied().map(Some).chain(surfaces.is_empty().then_some(None)) {
        let named = surface.map(|file| [Word::plain(flag("surface")), Word::value("surface", "", file)]);
        let one = alone.iter().cloned().chain(named.into_iter().flatten()).collect();
        let (one, _, as_written) = of_words(of.name(), one, kinds())?;
        let mut table = of.table(&one).map_err(|failure| failure.as_written(&as_written))?;
        table.remove("seed");
        tables.push(table);
        written = as_written;
    }
    let is_same = |key: &str, value: &Value| tables.iter().all(|table| table.get(key) == Some(value));
    let base: Table = tables[0].clone().into_iter().filter(|(key, value)| is_same(key, value)).collect();
    let mut lists = Table::new();
    if !listed.is_empty() {
        let entry = |seed: &str| seed.parse::<i64>().map_or_else(|_| Value::from(seed), Value::from);
        let entries = Value::Array(listed.into_iter().map(entry).collect());
        let seeds = seeds(&flag("seed"), &entries)?;
        lists.insert(
            "seed".into(),
            seeds.into_iter().map(|seed| Value::Integer(seed as i64)).collect::<Vec<_>>().into(),
        );
    }
    if surfaces.len() > 1 {
        let own = |(file, table): (&&str, &Table)| {
            let mut own: Table = table.clone().into_iter().filter(|(key, _)| !base.contains_key(key)).collect();
            if let Some(state) = own.keys().find(|key| STATES.contains(&key.as_str())) {
                let why =
                    words!["it must be the same on all surfaces: ", key("unit"), " gives them one unit of length"];
                return Err(Failure::contradicts(key(state), "not one number", why));
            }
            own.insert("name".into(), (*file).into());
            Ok(Value::Table(own))
        };
        lists.insert("surface".into(), Value::Array(surfaces.iter().zip(&tables).map(own).collect::<Result<_, _>>()?));
    }
    let mut table = Table::new();
    table.insert("command".into(), of.name().into());
    table.insert(of.name().into(), base.into());
    table.insert("study".into(), lists.into());
    study.push(toml::to_string(&table).map_err(|error| Failure::computation(error.to_string()))?);
    Ok(Some((study, written)))
}
