//! `materials`: names of `--material` and `--fluid`, with their values and sources.

use std::collections::BTreeMap;
use std::fmt;

use clap::Args as ClapArgs;
use gfmd_input::fluids::{Fluid, fluids};
use gfmd_input::materials::{Material, materials};
use serde::Serialize;

use crate::session::wrapped;

/// Flags of `materials`.
#[derive(ClapArgs, Clone, Copy, Debug)]
#[command(after_help = "Examples:
  gfmd materials
  gfmd contact --n 256 --size 100um --material aluminium --pressure 10MPa
  gfmd materials --json")]
pub struct Args {}

/// Materials and fluids by name.
#[derive(Clone, Copy, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub materials: &'static BTreeMap<String, Material>,
    pub fluids: &'static BTreeMap<String, Fluid>,
}

/// Returns all materials and fluids.
pub fn run() -> Report {
    Report { materials: materials(), fluids: fluids() }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = |f: &mut fmt::Formatter<'_>, [name, young, poisson, stress]: [&str; 4], source: &str| {
            print_beside(f, &format!("{name:<15} {young:>8} {poisson:>6} {stress:>13}  "), source)
        };
        line(f, ["name", "E", "nu", "yield stress"], "source")?;
        for (name, material) in self.materials {
            let Material { young, poisson, yield_stress, source, .. } = material;
            line(f, [name, young, &poisson.to_string(), yield_stress.as_deref().unwrap_or("-")], source)?;
            let width = f.width().map_or(usize::MAX, |width| width.saturating_sub(2));
            for words in further(material) {
                wrapped(&words, width).iter().try_for_each(|words| writeln!(f, "  {words}"))?;
            }
        }
        writeln!(f)?;
        let line = |f: &mut fmt::Formatter<'_>, [name, viscosity]: [&str; 2], source: &str| {
            print_beside(f, &format!("{name:<18} {viscosity:>12}  "), source)
        };
        line(f, ["fluid", "viscosity"], "source")?;
        self.fluids.iter().try_for_each(|(name, fluid)| line(f, [name, &fluid.viscosity], &fluid.source))
    }
}

/// Prints a text beside values, in lines of its own.
fn print_beside(f: &mut fmt::Formatter<'_>, values: &str, text: &str) -> fmt::Result {
    let before = values.chars().count();
    let width = f.width().map_or(usize::MAX, |width| width.saturating_sub(before));
    let lines = wrapped(text, width);
    lines
        .iter()
        .zip(std::iter::once(values).chain(std::iter::repeat("")))
        .try_for_each(|(line, values)| writeln!(f, "{values:<before$}{line}"))
}

/// Returns the values of a material that have no column.
fn further(material: &Material) -> Vec<String> {
    let Material { hardness, conductivity, prony, relaxes, .. } = material;
    let hardness = hardness.as_ref().map(|value| format!("--hardness {value}"));
    let conductivity = conductivity.as_ref().map(|value| format!("conductivity {value}"));
    let branches: Vec<String> = prony.iter().map(|(time, fraction)| format!("{time}:{fraction}")).collect();
    let series = relaxes.as_ref().map(|relaxes| format!("--prony {} --relaxes {relaxes}", branches.join(",")));
    hardness.into_iter().chain(conductivity).chain(series).collect()
}
