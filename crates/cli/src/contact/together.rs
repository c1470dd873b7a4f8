//! Which flags go together.

use gfmd_contact::{Boundary, Factors, Solver};
use gfmd_green::{BaseKind, Body, Height};
use gfmd_law::Kind;

use super::{Args, Unknown};
use crate::dynamics::DampedBy;
use crate::failure::Failure;
use crate::values::numbers;

impl Args {
    /// Checks that the contact can have the unknown components.
    pub(super) fn check_components(&self, body: &Body) -> Result<(), Failure> {
        let Self { components, boundary, law, hardness, base, control, .. } = self;
        let is_moved = base.base_displacement.is_some() || base.base_traction.is_some();
        let clash = components.clash(law.law, *boundary, hardness.is_some(), body).or(match components {
            Unknown::All | Unknown::Held if is_moved => Some("a base that moves"),
            Unknown::All if !control.displacement.is_empty() => Some("--displacement"),
            _ => None,
        });
        match clash {
            Some(other) => Err(Failure::value("--components", components.name(), format!("normal with {other}"))),
            None => Ok(()),
        }
    }

    /// Refuses flags that do not go with finite slopes.
    pub(super) fn check_finite_slope(&self) -> Result<(), Failure> {
        let Self { components, boundary, law, hardness, base, body, flow_threshold, .. } = self;
        let second_body = &body.others.second_body;
        let refused: [(bool, &str, String, &str); 6] = [
            (law.law != Kind::HardWall, "--law", law.law.name().into(), "hard-wall"),
            (*boundary == Boundary::Free, "--boundary", boundary.to_string(), "periodic"),
            (*components != Unknown::Normal, "--components", components.name().into(), "normal"),
            (
                hardness.is_some(),
                "--hardness",
                hardness.as_ref().map_or_else(String::new, ToString::to_string),
                "left out",
            ),
            (
                second_body.is_some(),
                "--second-body",
                second_body.map_or_else(String::new, |second| second.to_string()),
                "left out",
            ),
            (*flow_threshold, "--flow-threshold", "given".into(), "left out"),
        ];
        let moved = [("--base-displacement", &base.base_displacement), ("--base-traction", &base.base_traction)];
        let moved = moved
            .into_iter()
            .filter(|(_, file)| file.is_some())
            .map(|(flag, _)| (true, flag, "given".into(), "left out"));
        match refused.into_iter().chain(moved).find(|(clashes, ..)| *clashes) {
            Some((_, flag, found, allowed)) => {
                Err(Failure::value(flag, found, format!("{allowed} with --finite-slope")))
            }
            None => Ok(()),
        }
    }

    /// Checks time step, damping and record of the dynamics.
    pub(super) fn check_dynamics(&self) -> Result<(), Failure> {
        self.dynamics.check(match self.solver.solver {
            Solver::VerletCritical => DampedBy::Numbers,
            Solver::VerletModes => DampedBy::Modes,
            _ => DampedBy::Other,
        })?;
        if let (Factors::Components(factors), true) = (self.dynamics.factors()?, self.components != Unknown::All) {
            return Err(Failure::value("--damping", format!("{factors:?}"), "one number without --components all"));
        }
        let control = &self.control;
        let given = [&control.pressure, &control.p_star, &control.displacement];
        let loads: usize = given.into_iter().map(|values| numbers(values).count()).sum();
        match self.trace.is_wanted() {
            true if loads > 1 => {
                Err(Failure::Input(format!("--history: {loads} loads; it records the search for one load")))
            }
            true if self.resume.resume => {
                Err(Failure::Input("--history: with --resume; it records a search from its beginning".into()))
            }
            _ => Ok(()),
        }
    }

    /// Refuses flags that do not go with a surface below the slab.
    pub(super) fn check_lower(&self) -> Result<(), Failure> {
        let Some(lower) = self.lower.flag() else { return Ok(()) };
        let refuse = |flag: &str, found: String, allowed: &str| {
            Err(Failure::value(flag, found, format!("{allowed} with {lower}")))
        };
        let others = &self.body.others;
        match () {
            () if self.body.height == Height::Infinite => refuse("--height", "inf".into(), "finite"),
            () if others.base != BaseKind::Bonded => {
                refuse("--base", others.base.to_string(), "left out (nothing but the two surfaces holds the slab)")
            }
            () if self.base.base_displacement.is_some() => refuse("--base-displacement", "given".into(), "left out"),
            () if self.base.base_traction.is_some() => refuse("--base-traction", "given".into(), "left out"),
            () if self.law.law != Kind::HardWall => refuse("--law", self.law.law.name().into(), "hard-wall"),
            () if self.boundary == Boundary::Free => refuse("--boundary", self.boundary.to_string(), "periodic"),
            () if self.components != Unknown::Normal => refuse("--components", self.components.name().into(), "normal"),
            () if self.finite_slope => refuse("--finite-slope", "given".into(), "left out"),
            () if self.statistics => refuse("--statistics", "given".into(), "left out"),
            () if self.flow => refuse("--flow", "given".into(), "left out"),
            () if self.flow_threshold => refuse("--flow-threshold", "given".into(), "left out"),
            () => match (&others.second_body, &self.hardness) {
                (Some(second), _) => refuse("--second-body", second.to_string(), "left out"),
                (_, Some(hardness)) => refuse("--hardness", hardness.to_string(), "left out"),
                _ => Ok(()),
            },
        }
    }
}
