//! The printed report of steady sliding, and its figures.

use std::fmt;
use std::path::{Path, PathBuf};

use gfmd_contact::Hardness;
use gfmd_files::contiguous;
use gfmd_input::failure::Failure;
use gfmd_input::hardness::GivenHardness;
use gfmd_input::source::Surface;
use gfmd_record::{ROUGH, Record, Sliding, SlidingFacts, Table, table_of};
use gfmd_report::figures::{Scene, SceneFields, named};
use gfmd_report::slide::{chart, rises, temperature};
use gfmd_run::series::Head;
use serde::Serialize;

use super::steady_state::SteadyState;
use crate::session::{list_files, print_note, print_sheet};

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    #[serde(flatten)]
    pub head: Head,
    /// Features that decide which numbers the states have.
    #[serde(skip)]
    pub facts: SlidingFacts,
    /// Unit vector of the velocity.
    pub direction: [f64; 2],
    /// Every load at every velocity, loads outer.
    pub states: Vec<Record<Sliding>>,
    pub peak_bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

impl Report {
    /// Draws the states, `velocities` for each load, against the velocity, and the fields of the last one.
    pub(super) fn draw(
        &self,
        prefix: &Path,
        (velocities, is_viscoelastic): (usize, bool),
        (surface, hardness, last): (&Surface, Option<&Hardness>, &SteadyState),
    ) -> Result<Vec<PathBuf>, Failure> {
        let (states, units) = (&self.states, &surface.units());
        let mut files = Vec::new();
        if is_viscoelastic {
            files.extend(chart(states, velocities, units).save(&named(prefix, "friction"))?);
        }
        if let Some(heated) = &last.heated {
            files.extend(rises(states, velocities, units).save(&named(prefix, "rise"))?);
            let values = contiguous(&heated.temperature);
            let map = temperature(&surface.grid, &values, surface.unit(), units);
            files.extend(map.save(&named(prefix, "temperature"))?);
        }
        let depth = last.state.solution.plastic.as_ref().map(|plastic| &plastic.depth);
        let shown = SceneFields::of(&last.state, None, depth);
        files.extend(Scene::upper(surface, &shown, self.head.e_star, hardness).draw(prefix)?);
        Ok(files)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.head)?;
        let units = self.head.units();
        if let Some(hardness) = &self.head.hardness {
            let hardness = match hardness {
                GivenHardness::Number(number) => self.head.read(*number, "stress", ""),
                GivenHardness::Field(given) => given.to_string(),
            };
            writeln!(f, "hardness {hardness}; plastic: points at the hardness, depth: mean plastic depth\n")?;
        }
        let remark = |line: usize| match line == 0 || self.states[line - 1].is("converged") {
            true => String::new(),
            false => "  NOT CONVERGED".into(),
        };
        let sheet = |width| table_of(&self.states, &[Table::State], &units, width);
        print_sheet(f, sheet, self.states.len(), |_| String::new(), remark)?;
        let heat = table_of(&self.states, &[Table::Heat], &units, f.width());
        if !heat.lines.is_empty() {
            writeln!(f)?;
            print_sheet(f, |_| heat, 0, |_| String::new(), |_| String::new())?;
        }
        print_note(f, &format!("{ROUGH}; compare with a grid of half the spacing"))?;
        list_files(f, self.out.as_deref(), &self.plots)
    }
}
