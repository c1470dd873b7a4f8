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
        let mut line = |[name, young, poisson, stress]: [&str; 4], source: &str| {
            let values = format!("{name:<14} {young:>8} {poisson:>6} {stress:>13}  ");
            let width = f.width().map_or(usize::MAX, |width| width.saturating_sub(BEFORE));
            for (line, words) in wrapped(source, width).into_iter().enumerate() {
                let before = if line == 0 { &values } else { "" };
                writeln!(f, "{before:<BEFORE$}{words}")?;
            }
            Ok(())
        };
        line(["name", "E", "nu", "yield stress"], "source")?;
        for (name, Material { young, poisson, yield_stress, source }) in self.materials {
            line([name, young, &poisson.to_string(), yield_stress.as_deref().unwrap_or("-")], source)?;
        }
        Ok(())
    }
}
