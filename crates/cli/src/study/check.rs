//! Check of the file of a study.

use std::path::Path;

use gfmd_check::result::Comparison;
use gfmd_check::study::{Cube, GROUP, status};
use gfmd_files::Reader;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use toml::Table;

use super::config::StudyConfig;
use super::{member, solve};

/// Compares a study with its configuration; computes `sample` members again, spread evenly, or all, if asked to.
///
/// # Errors
/// Returns an error for a file that is not the result of its configuration, and for members with files to be computed
/// again: no file that a result names is opened.
pub(crate) fn check(
    reader: &Reader,
    config: &str,
    rerun: bool,
    sample: Option<u64>,
    comparison: &mut Comparison,
    session: &Session,
) -> Result<(), Failure> {
    const NAME: &str = "config of the file";
    let table: Table = config.parse().map_err(|error: toml::de::Error| Failure::input(NAME, error.message()))?;
    let config = StudyConfig::read(NAME, table)?;
    let cube = Cube::read(reader)?;
    let names =
        |choices: &[super::config::Choice]| choices.iter().map(|choice| choice.name.clone()).collect::<Vec<_>>();
    let mut same = |name: &str, is_same: bool| match is_same {
        true => comparison.count(),
        false => comparison.differ(name, "it differs from the configuration".into()),
    };
    same(&format!("{GROUP}@command"), cube.command == config.command.name());
    same(&format!("{GROUP}/surface"), cube.surfaces == names(&config.surfaces));
    same(&format!("{GROUP}/seed"), cube.seeds == config.seeds);
    same(&format!("{GROUP}/body"), cube.bodies == names(&config.bodies));
    let stored = reader.texts(&format!("{GROUP}/status"))?;
    let expected: Vec<&str> = cube.errors.iter().map(|error| status(error)).collect();
    same(&format!("{GROUP}/status"), stored == expected);
    if config.files().is_empty()
        && let Ok((problem, _)) = solve::Problem::of(config.command, config.table(0))
    {
        for (axis, values) in cube.axes.iter().zip(problem.coordinates()) {
            comparison.values(
                &format!("{GROUP}/{}", axis.name),
                axis.values.as_deref().unwrap_or_default(),
                &values,
                0.0,
            );
        }
    }
    if !rerun || cube.members() != config.members() {
        return Ok(());
    }
    if let Some(file) = config.files().first() {
        let why = format!(
            "the study reads {}, and check opens no file that a result names; gfmd study with this configuration \
             computes it again",
            Path::new(file).display()
        );
        return Err(Failure::refused(why));
    }
    again(&config, &cube, sample, comparison, session)
}

/// Computes `sample` members again, spread evenly, or all.
fn again(
    config: &StudyConfig,
    cube: &Cube,
    sample: Option<u64>,
    comparison: &mut Comparison,
    session: &Session,
) -> Result<(), Failure> {
    let all = config.members();
    let count = sample.map_or(all, |sample| (sample as usize).min(all));
    for index in (0..count).map(|k| k * all / count) {
        let found = solve::solve(config.command, config.table(index), session)?;
        if found.error != cube.errors[index] {
            comparison.differ(&format!("{GROUP}/error"), format!("the second run of member {index} has another"));
        }
        let alone = member::columns(&found, &cube.axes);
        for (name, values) in &alone {
            let states = cube.states();
            let stored = cube.number(name).map_or(&[][..], |number| &number.values[index * states..][..states]);
            let floor = if name.contains("residual") { 1e-3 } else { 0.0 };
            comparison.values(&format!("{GROUP}/{name} of member {index}"), stored, values, floor);
        }
        for number in cube.numbers.iter().filter(|number| !alone.contains_key(&number.name)) {
            let states = cube.states();
            if number.values[index * states..][..states].iter().any(|value| !value.is_nan()) {
                let name = format!("{GROUP}/{}", number.name);
                comparison.differ(&name, format!("the second run of member {index} has no such number"));
            }
        }
    }
    Ok(())
}
