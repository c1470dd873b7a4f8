//! What goes together.

use gfmd_contact::{Boundary, Factors, Solver};
use gfmd_green::{BaseKind, Body, Height};
use gfmd_law::Kind;

use super::{Args, Unknown};
use crate::dynamics::DampedBy;
use crate::elastic::BodyArgs;
use crate::failure::Failure;
use crate::memory::Held;
use crate::values::numbers;

/// What a contact has, from flags or from the arguments of a call, of which not all goes together.
pub struct Together<'a> {
    /// The law across the gap.
    pub law: Kind,
    /// The surroundings of the surface.
    pub boundary: Boundary,
    /// The unknown components.
    pub components: Unknown,
    /// The hardness in words.
    pub hardness: Option<String>,
    /// The elastic body.
    pub body: &'a BodyArgs,
    /// True with finite slopes.
    pub finite_slope: bool,
    /// The flag of a surface below the slab.
    pub lower: Option<&'static str>,
}

/// A flag that is refused, what it is, and what it must be.
type Refused = (&'static str, String, &'static str);

impl Together<'_> {
    /// Refuses what does not go with finite slopes or with a surface below the slab, if there are.
    ///
    /// # Errors
    /// The name, the value found, and the values allowed.
    pub fn check(&self) -> Result<(), Failure> {
        let told = |refused: Option<Refused>, other: &str| match refused {
            Some((flag, found, allowed)) => Err(Failure::value(flag, found, format!("{allowed} with {other}"))),
            None => Ok(()),
        };
        if let Some(lower) = self.lower {
            told(self.beside_lower(), lower)?;
        }
        if self.finite_slope { told(self.beside_either(), FINITE_SLOPE) } else { Ok(()) }
    }

    /// The memory that the contact needs, which `only` one load without its statistics makes less.
    pub fn held(&self, only: bool) -> Held {
        match (self.law, self.boundary) {
            _ if self.finite_slope => Held::STEEP,
            _ if self.components == Unknown::All => Held::WALL_ALL_COMPONENTS,
            _ if self.lower.is_some() => Held::SQUEEZED,
            (Kind::HardWall, Boundary::Periodic) if self.hardness.is_none() => {
                if only {
                    Held::HARD_WALL_ONCE
                } else {
                    Held::HARD_WALL
                }
            }
            (Kind::HardWall, _) => Held::FREE,
            (_, Boundary::Periodic) => Held::LAW,
            (_, Boundary::Free) => Held::LAW_FREE,
        }
    }

    /// What goes neither with finite slopes nor with a surface below.
    fn beside_either(&self) -> Option<Refused> {
        let Self { law, boundary, components, hardness, body, .. } = self;
        let second_body = &body.others.second_body;
        match () {
            () if *law != Kind::HardWall => Some(("--law", law.name().into(), "hard-wall")),
            () if *boundary == Boundary::Free => Some(("--boundary", boundary.to_string(), "periodic")),
            () if *components != Unknown::Normal => Some(("--components", components.name().into(), "normal")),
            () => (second_body.map(|second| ("--second-body", second.to_string(), "left out")))
                .or_else(|| hardness.as_ref().map(|hardness| ("--hardness", hardness.clone(), "left out"))),
        }
    }

    fn beside_lower(&self) -> Option<Refused> {
        let Self { body, finite_slope, .. } = self;
        match () {
            () if body.height == Height::Infinite => Some(("--height", "inf".into(), "finite")),
            () if body.others.base != BaseKind::Bonded => {
                let allowed = "left out (nothing but the two surfaces holds the slab)";
                Some(("--base", body.others.base.to_string(), allowed))
            }
            () if *finite_slope => Some((FINITE_SLOPE, "given".into(), "left out")),
            () => self.beside_either(),
        }
    }
}

const FINITE_SLOPE: &str = "--finite-slope";

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

    /// Refuses a base that moves below a patch: its effect on the surface is that of a periodic cell.
    pub(super) fn check_base(&self) -> Result<(), Failure> {
        let moved = self.moved_base().into_iter().find(|(is_given, _)| *is_given);
        match (self.boundary, moved) {
            (Boundary::Free, Some((_, flag))) => {
                Err(Failure::value("--boundary", self.boundary, format!("periodic with {flag}")))
            }
            _ => Ok(()),
        }
    }

    /// The flags of a base that moves, and whether they are given.
    fn moved_base(&self) -> [(bool, &'static str); 2] {
        [
            (self.base.base_displacement.is_some(), "--base-displacement"),
            (self.base.base_traction.is_some(), "--base-traction"),
        ]
    }

    /// What goes together here.
    pub(super) fn together(&self) -> Together<'_> {
        Together {
            law: self.law.law,
            boundary: self.boundary,
            components: self.components,
            hardness: self.hardness.as_ref().map(ToString::to_string),
            body: &self.body,
            finite_slope: self.finite_slope,
            lower: self.lower.flag(),
        }
    }

    /// Refuses flags that do not go with finite slopes.
    pub(super) fn check_finite_slope(&self) -> Result<(), Failure> {
        Together { finite_slope: true, lower: None, ..self.together() }.check()?;
        self.given([(self.flow_threshold, "--flow-threshold")], FINITE_SLOPE)
    }

    /// Refuses flags that are given and do not go with `other`, beside a base that moves.
    fn given<const N: usize>(&self, flags: [(bool, &str); N], other: &str) -> Result<(), Failure> {
        match self.moved_base().into_iter().chain(flags).find(|(is_given, _)| *is_given) {
            Some((_, flag)) => Err(Failure::value(flag, "given", format!("left out with {other}"))),
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
        self.together().check()?;
        let flags =
            [(self.statistics, "--statistics"), (self.flow, "--flow"), (self.flow_threshold, "--flow-threshold")];
        self.given(flags, lower)
    }
}
