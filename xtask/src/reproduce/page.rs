//! Page about the figures.

use std::collections::BTreeMap;
use std::fmt::Write;

use gfmd_input::failure::Failure;
use serde_json::Value;

use super::catalogue::{ALONG_X, ALONG_Y, FIGURES, Figure, PLANE, PREPARATION, SPACE, SURFACE, Work};
use super::{Runs, dampings};

const HEAD: &str = "# The figures of the thesis\n\n\
Drawn by `cargo xtask reproduce`, with numbers to judge pictures of the thesis. [Coverage](coverage.md) lists all\n\
equations, tables and figures. Figures 2.1, 2.2, 3.1, 3.2, 3.9 and 4.2 are schematics. Finite elements are trilinear\n\
bricks on the surface nodes of the thesis, with the same held nodes\n\
([punch_elements.py](../../data/reference/punch_elements.py)).\n";

/// Remarks on the errata of docs/source/coverage.md.
const ERRATA: &str = "\n## Errata\n\n\
[E1 to E27](coverage.md#errata) are the errors of equations, captions and numbers.\n\n\
- **Δt = 0.25** (section 4.3; E24), in lattice units of Δx = 1, is 0.22 of the stability limit 2/√k_max with E* = 1, \
and 0.23 with E = 1; this program takes a quarter of the limit (docs/solvers.md).\n\
- **Section 5.2** (E26): the preset `thesis` takes p/(E* ḡ).\n";

/// Sentence on the location of the largest stress differences from finite elements.
const AT_THE_SURFACE: &str = "Differences are largest on the surface, where the stress of elements is a one-sided \
difference, and at the singular punch edge.";

/// Returns the text of the page.
pub(super) fn text(runs: &mut Runs) -> Result<String, Failure> {
    let mut text = String::from(HEAD);
    let _ = write!(text, "\nThe fields below the punch start from one run:\n\n```text\ngfmd {}\n```\n", PREPARATION[0]);
    let mut told = BTreeMap::new();
    for figure in &FIGURES {
        section(&mut text, figure, runs, &mut told)?;
    }
    text.push_str(ERRATA);
    Ok(text)
}

/// Adds the section of a figure. `told` has the figure at which each command stands.
fn section(
    text: &mut String,
    figure: &Figure,
    runs: &mut Runs,
    told: &mut BTreeMap<String, &'static str>,
) -> Result<(), Failure> {
    let Figure { number, source, here, erratum, work } = figure;
    let _ = write!(text, "\n## Figure {number}\n\n**The thesis**: {source}\n\n**Here**: {here}");
    if let Some(found) = found(number, runs)? {
        let _ = write!(text, " {found}");
    }
    text.push_str("\n\n");
    if !erratum.is_empty() {
        let _ = write!(text, "**Erratum**: {erratum}\n\n");
    }
    let (suffixes, commands): (Vec<&str>, Vec<String>) = match work {
        Work::Commands(pictures) => pictures.iter().map(|picture| (picture.suffix, picture.command.to_owned())).unzip(),
        Work::Dampings => (vec![""], vec![dampings::command("1")]),
    };
    for suffix in suffixes {
        let _ = writeln!(text, "![Figure {number}{suffix}]({})", figure.file(suffix));
    }
    let mut commands = commands;
    commands.dedup();
    if let (Work::Dampings, "4.1b") = (*work, *number) {
        commands[0] += " --history-point 0.3175,0.635,x";
    }
    let (again, fresh): (Vec<String>, Vec<String>) =
        commands.into_iter().partition(|command| told.contains_key(command));
    let mut elsewhere: Vec<&str> = again.iter().map(|command| told[command]).collect();
    elsewhere.dedup();
    if !elsewhere.is_empty() {
        let _ = writeln!(text, "\nCommand: figure {}.", elsewhere.join(" and "));
    }
    if !fresh.is_empty() {
        text.push_str("\n```text\n");
        for command in fresh {
            let _ = writeln!(text, "gfmd {command}");
            told.insert(command, *number);
        }
        text.push_str("```\n");
    }
    if let Work::Dampings = work {
        text.push_str("\n(and with the other factors");
        text.push_str(if *number == "4.1b" { " and points of the line)\n" } else { ")\n" });
    }
    Ok(())
}

/// Describes the results of a figure from the output of the runs.
fn found(number: &str, runs: &mut Runs) -> Result<Option<String>, Failure> {
    let compared = |command: &str, name: &str, unit: &str, runs: &mut Runs| -> Result<String, Failure> {
        let report = runs.run(command)?;
        let components = report["comparison"]["components"].as_array().map_or(&[][..], Vec::as_slice);
        let component = components.iter().find(|component| component["name"] == name).unwrap_or(&Value::Null);
        let value = |key: &str| component[key].as_f64().unwrap_or(f64::NAN);
        Ok(format!(
            "Difference: rms {:.2e}{unit}, at most {:.2e}{unit}, of {:.3e}{unit}.",
            value("rms_difference"),
            value("largest_difference"),
            value("largest_reference")
        ))
    };
    Ok(Some(match number {
        "3.10" => {
            let largest = |command: &str, runs: &mut Runs| -> Result<f64, Failure> {
                let levels = runs.run(command)?["levels"].clone();
                let sum = levels.as_array().map_or(f64::NAN, |levels| {
                    levels.iter().map(|level| level["max_displacement"].as_f64().unwrap_or(f64::NAN)).sum()
                });
                Ok(sum)
            };
            let (space, plane) = (largest(SPACE, runs)?, largest(PLANE, runs)?);
            let apart = (space - plane).abs() / plane;
            format!("Their largest displacements agree within {apart:.1e} ([validation](../validation.md)).")
        }
        "4.3" | "4.4" | "4.5" | "4.6" => {
            let report = runs.run(SURFACE)?;
            let component = match number {
                "4.4" => 1,
                "4.5" => 2,
                _ => 0,
            };
            let error = report["error"][component].as_f64().unwrap_or(f64::NAN);
            let name = ["x", "y", "z"][component];
            let mut words = format!("Eq. 4.13 of u_{name} is {error:.2e}");
            words += match number {
                "4.6" => {
                    "; with elements half as high 4.2e-4, twice as high 2.3e-3 \
                     (data/reference/punch3d_elements/summary.json). The thesis, without this height, lies between."
                }
                _ => ".",
            };
            words
        }
        "4.7" => compared(ALONG_X, "ux", " µm", runs)?,
        "4.8" => compared(ALONG_Y, "uy", " µm", runs)?,
        "4.9" => compared(ALONG_Y, "uz", " µm", runs)?,
        "4.10" => {
            let words = compared(ALONG_Y, "sxx", " GPa", runs)?;
            format!("{words} {AT_THE_SURFACE}")
        }
        "4.11" => {
            let on_x = runs.run(ALONG_Y)?["comparison"]["components"].clone();
            let zero = |name: &str| {
                let component = on_x.as_array().and_then(|all| all.iter().find(|component| component["name"] == name));
                component.and_then(|component| component["largest_reference"].as_f64()).unwrap_or(f64::NAN)
            };
            let words = compared(ALONG_X, "sxz", " GPa", runs)?;
            format!("{words} On x = L/2 the elements have {:.1e} GPa, rounding.", zero("sxz"))
        }
        _ => return Ok(None),
    }))
}
