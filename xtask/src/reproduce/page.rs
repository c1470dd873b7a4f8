//! Page about the figures.

use std::fmt::Write;

use gfmd_input::failure::Failure;
use serde_json::Value;

use super::catalogue::{ALONG_X, ALONG_Y, FIGURES, Figure, PLANE, PREPARATION, SPACE, SURFACE, Work};
use super::{Runs, dampings};

const HEAD: &str = "# The figures of the thesis\n\n\
Written by `cargo xtask reproduce`, which runs the commands below and draws the pictures; numbers stand in for what \
the thesis shows as a picture, so that either can be judged.\n\
The thesis is the one from which this program starts; \
[coverage.md](coverage.md) goes through all its equations, tables and figures.\n\n\
Figures 2.1, 2.2, 3.1, 3.2, 3.9 and 4.2 are schematics. The finite elements are trilinear bricks on the nodes of the \
surface grid of the thesis, with the same held nodes, made by\n\
[punch_elements.py](../../data/reference/punch_elements.py) without a Green's function. Paths are relative to the \
repository; `cargo xtask` and `gfmd` run the same commands.\n";

/// Errors in the captions and numbers of these chapters, beyond the equations of theory.md, section 12.
const ERRATA: &str = "\n## Errata of figures and text\n\n\
(Those of equations are E1 to E27 of [theory.md](../theory.md), section 12.)\n\n\
- **Figures 4.7, 4.8, 4.11** name planes on which the field is zero: u_x on x/L = 0.5, u_y on y/L = 0.5, σ_xz on \
x/L = 0.5. All three are odd about the middle of the punch.\n\
- **Figure 4.1a** names ũ_x(0, 0), which is zero at every step of the punch for the same reason (the punch has as many \
nodes on either side of x = L/2).\n\
- **Captions of figures 4.3 to 4.5** say \"calculated by GFMD a) calculated by FEM\" for (a) GFMD, (b) FEM.\n\
- **Equations 3.8, 3.16 and 4.11** sum over q and list the combinations of signs as well: they hold if q runs over the \
positive quadrant alone, and then modes on the axes count twice.\n\
- **Δt = 0.25** (section 4.3) has no unit. In lattice units of Δx = 1 it is 0.22 of the stability limit 2/√k_max with \
E* = 1, and 0.23 with E = 1; this program takes a quarter of the limit (docs/solvers.md).\n\
- **Section 5.2**: the range \"p from 0.001 to 0.01\" has no unit. p/E* would be p* = 0.1 to 1 at ḡ = 0.01, where the \
area is not proportional to the load; p/(E* ḡ) is meant by eq. 5.2, and is what the preset `thesis` takes.\n";

/// Sentence on the location of the largest stress differences from finite elements.
const AT_THE_SURFACE: &str = "Largest are the differences on the surface, where the stress of elements at a node is a \
one-sided difference, and at the edge of the punch, where it is singular.";

/// Returns the text of the page.
pub(super) fn text(runs: &mut Runs) -> Result<String, Failure> {
    let mut text = String::from(HEAD);
    let _ = write!(text, "\nThe fields below the punch start from one run:\n\n```text\ngfmd {}\n```\n", PREPARATION[0]);
    for figure in &FIGURES {
        section(&mut text, figure, runs)?;
    }
    text.push_str(ERRATA);
    Ok(text)
}

fn section(text: &mut String, figure: &Figure, runs: &mut Runs) -> Result<(), Failure> {
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
    text.push_str("\n```text\n");
    for command in commands {
        let _ = writeln!(text, "gfmd {command}");
    }
    text.push_str("```\n");
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
            "The rms difference is {:.2e}{unit}, the largest {:.2e}{unit}, of {:.3e}{unit}.",
            value("rms_difference"),
            value("largest_difference"),
            value("largest_reference")
        ))
    };
    Ok(Some(match number {
        "3.10" | "3.11" => {
            let largest = |command: &str, runs: &mut Runs| -> Result<f64, Failure> {
                let levels = runs.run(command)?["levels"].clone();
                let sum = levels.as_array().map_or(f64::NAN, |levels| {
                    levels.iter().map(|level| level["max_displacement"].as_f64().unwrap_or(f64::NAN)).sum()
                });
                Ok(sum)
            };
            let (space, plane) = (largest(SPACE, runs)?, largest(PLANE, runs)?);
            format!(
                "The largest displacements of all levels add up to the same number within {:.1e} (docs/validation.md \
                 has the fields point by point).",
                (space - plane).abs() / plane
            )
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
                    "; with elements half as high it is 4.2e-4, with those twice as high 2.3e-3 \
                     (data/reference/punch3d_elements/summary.json). The 0.00196 of the thesis lies in this range; it \
                     does not give the height of its elements."
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
            format!("{words} {AT_THE_SURFACE} On x = L/2 the elements have {:.1e} GPa, rounding.", zero("sxz"))
        }
        _ => return Ok(None),
    }))
}
