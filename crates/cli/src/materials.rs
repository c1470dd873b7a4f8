//! `materials`: names of `--material`, with their values and sources.

use std::collections::BTreeMap;
use std::fmt;

use clap::Args as ClapArgs;
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

/// Materials by name.
#[derive(Clone, Copy, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub materials: &'static BTreeMap<String, Material>,
}

/// Returns all materials.
pub fn run() -> Report {
    Report { materials: materials() }
}

/// Characters of a line before the source.
const BEFORE: usize = 46;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let line = |f: &mut fmt::Formatter<'_>, [name, young, poisson, stress]: [&str; 4], source: &str| {
            let values = format!("{name:<14} {young:>8} {poisson:>6} {stress:>13}  ");
            let width = f.width().map_or(usize::MAX, |width| width.saturating_sub(BEFORE));
            for (line, words) in wrapped(source, width).into_iter().enumerate() {
                let before = if line == 0 { &values } else { "" };
                writeln!(f, "{before:<BEFORE$}{words}")?;
            }
            Ok(())
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
        Ok(())
    }
}

/// Returns the values of a material that have no column.
fn further(material: &Material) -> Vec<String> {
    let Material { conductivity, prony, relaxes, .. } = material;
    let conductivity = conductivity.as_ref().map(|value| format!("conductivity {value}"));
    let branches: Vec<String> = prony.iter().map(|(time, fraction)| format!("{time}:{fraction}")).collect();
    let series = relaxes.as_ref().map(|relaxes| format!("--prony {} --relaxes {relaxes}", branches.join(",")));
    conductivity.into_iter().chain(series).collect()
}
