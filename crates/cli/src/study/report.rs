//! Result and plan of a study, as JSON and as a table.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use gfmd_check::study::{Cube, CubeNumber, MeanOver, StateAxis, status};
use gfmd_record::{Importance, Printed, Sheet};
use gfmd_report::study::{Shown, coordinates, shown, with_warnings, words};
use gfmd_sweep::Shard;
use serde::Serialize;

use super::config::StudyConfig;
use crate::session::{list_files, print_note, print_sheet};

/// Printed result.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub command: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress_unit: Option<String>,
    pub surface: Vec<String>,
    pub seed: Vec<u64>,
    pub body: Vec<String>,
    /// Axes of the states.
    pub axes: Vec<StateAxis>,
    /// Values of all members, [surface, seed, body, states].
    pub numbers: BTreeMap<String, CubeNumber>,
    /// Status of each member, [surface, seed, body].
    pub status: Vec<&'static str>,
    /// Reasons of the members that failed; empty for the others.
    pub error: Vec<String>,
    /// Warnings of the members.
    pub member_warnings: Vec<String>,
    /// Means over the seeds.
    pub means: Vec<Means>,
    pub out: PathBuf,
    pub seconds: f64,
    pub peak_bytes: u64,
    #[serde(skip)]
    cube: Cube,
}

/// Means over the seeds at one surface, body and state, as printed.
#[derive(Clone, Debug, Serialize)]
pub struct Means {
    surface: String,
    body: String,
    #[serde(flatten)]
    coordinates: BTreeMap<String, f64>,
    numbers: BTreeMap<String, MeanOver>,
}

impl Report {
    /// Collects the report of a study with its file.
    pub(super) fn new(cube: &Cube, out: PathBuf, seconds: f64, peak_bytes: u64) -> Self {
        let mut means = Vec::new();
        for (surface, name) in cube.surfaces.iter().enumerate() {
            for (body, of) in cube.bodies.iter().enumerate() {
                for state in 0..cube.states() {
                    let number =
                        |number: &CubeNumber| Some((number.name.clone(), cube.mean(number, surface, body, state)?));
                    let axes = cube.axes.iter().map(|axis| axis.name.clone());
                    means.push(Means {
                        surface: name.clone(),
                        body: of.clone(),
                        coordinates: axes.zip(cube.coordinates(state)).collect(),
                        numbers: cube.numbers.iter().filter_map(number).collect(),
                    });
                }
            }
        }
        let [unit, stress_unit] = cube.units.clone();
        Self {
            command: cube.command.clone(),
            unit,
            stress_unit,
            surface: cube.surfaces.clone(),
            seed: cube.seeds.clone(),
            body: cube.bodies.clone(),
            axes: cube.axes.clone(),
            numbers: cube.numbers.iter().map(|number| (number.name.clone(), number.clone())).collect(),
            status: cube.errors.iter().map(|error| status(error)).collect(),
            error: cube.errors.clone(),
            member_warnings: cube.warnings.clone(),
            means,
            out,
            seconds,
            peak_bytes,
            cube: cube.clone(),
        }
    }
}

/// Largest number of failed members that a table lists.
const LISTED: usize = 10;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let cube = &self.cube;
        let failed: Vec<usize> = (0..cube.members()).filter(|member| !cube.errors[*member].is_empty()).collect();
        let seeds = cube.seeds.len();
        let [extent, members] = words(cube);
        let over = if seeds == 1 { "one seed".into() } else { format!("means over {seeds} seeds") };
        writeln!(f, "{extent}\n{members}, {} failed; {over}\n", failed.len())?;
        let mut columns: Vec<Printed> = Vec::new();
        let rows: Vec<[usize; 3]> = (0..cube.surfaces.len())
            .flat_map(|surface| (0..cube.bodies.len()).map(move |body| (surface, body)))
            .flat_map(|(surface, body)| (0..cube.states()).map(move |state| [surface, body, state]))
            .collect();
        let mut text = |[word, head]: [&str; 2], importance: Importance, of: &dyn Fn(&[usize; 3]) -> String| {
            let cells = std::iter::once(head.to_owned()).chain(rows.iter().map(of)).collect();
            columns.push(Printed { word: word.to_owned(), cells, importance });
        };
        if cube.surfaces.len() > 1 {
            text(["surface"; 2], Importance::Main, &|row| cube.surfaces[row[0]].clone());
        }
        if cube.bodies.len() > 1 {
            text(["body"; 2], Importance::Main, &|row| cube.bodies[row[1]].clone());
        }
        for ((head, values), axis) in coordinates(cube).iter().zip(&cube.axes) {
            text([&axis.name, head], Importance::Main, &|row| values[row[2]].clone());
        }
        for Shown { word, head, importance, number, factor } in shown(cube) {
            text([word, &head], importance, &|[surface, body, state]| {
                gfmd_report::study::cell(cube.mean(number, *surface, *body, *state), factor)
            });
        }
        print_sheet(f, |width| Sheet::of(columns, width), 0, |_| String::new(), |_| String::new())?;
        if seeds > 1 {
            print_note(f, "digits in brackets: the standard error in units of the last digit")?;
        }
        for member in failed.iter().take(LISTED) {
            let [surface, seed, body] = cube.place(*member);
            let place =
                format!("surface {}, seed {}, body {}", cube.surfaces[surface], cube.seeds[seed], cube.bodies[body]);
            writeln!(f, "FAILED: {place}: {}", cube.errors[*member])?;
        }
        if failed.len() > LISTED {
            writeln!(f, "FAILED: {} more, in /study/error", failed.len() - LISTED)?;
        }
        let warned = cube.warnings.iter().filter(|warnings| !warnings.is_empty()).count();
        if warned > 0 {
            writeln!(f, "{}, in /study/warnings", with_warnings(warned))?;
        }
        list_files(f, Some(&self.out), &[])
    }
}

/// Output of `--dry-run`.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct PlanReport {
    pub command: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub shard: Option<String>,
    pub surface: Vec<String>,
    pub seed: Vec<u64>,
    pub body: Vec<String>,
    /// Numbers of the members that would be computed.
    pub members: Vec<usize>,
    pub all_members: usize,
}

impl PlanReport {
    /// Lists these members of a study.
    pub(super) fn new(config: &StudyConfig, members: &[usize], shard: Option<Shard>) -> Self {
        let names = |choices: &[super::config::Choice]| choices.iter().map(|choice| choice.name.clone()).collect();
        Self {
            command: config.command.name(),
            shard: shard.map(|shard| shard.to_string()),
            surface: names(&config.surfaces),
            seed: config.seeds.clone(),
            body: names(&config.bodies),
            members: members.to_vec(),
            all_members: config.members(),
        }
    }
}

impl fmt::Display for PlanReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { command, shard, surface, seed, body, members, all_members } = self;
        let (surfaces, seeds, bodies) = (surface.len(), seed.len(), body.len());
        writeln!(
            f,
            "study of {command}: {surfaces} surfaces x {seeds} seeds x {bodies} bodies, {all_members} members"
        )?;
        let of_shard = shard.as_ref().map_or_else(String::new, |shard| format!(" of shard {shard}"));
        writeln!(f, "{} members{of_shard} would be computed", members.len())
    }
}
