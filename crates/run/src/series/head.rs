//! Problem of a series, as at the beginning of its report.

use std::collections::BTreeMap;
use std::fmt;

use gfmd_contact::{Boundary, RigidSurface};
use gfmd_law::Limit;
use gfmd_problem::{Facts, GridError, Sequence, Unknown};
use gfmd_record::{Record, State, columns};
use gfmd_unit::{Units, digits};
use serde::Serialize;

use super::Slopes;
use super::prepared::{Asked, Prepared};
use gfmd_input::base::BaseArgs;
use gfmd_input::hardness::GivenHardness;
use gfmd_input::lower;
use gfmd_input::session::Session;
use gfmd_input::source::scan::Scan;
use gfmd_input::source::{Second, Surface};
use gfmd_problem::Adhesion;
use gfmd_problem::options::named;
use gfmd_problem::options::{OtherArgs, Relaxation, Yielding};

/// Solved problem, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Head {
    pub n: [usize; 2],
    pub size: [f64; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress_unit: Option<String>,
    pub surface: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<Scan>,
    #[serde(flatten)]
    pub second: Option<Second>,
    pub rms_gradient: f64,
    /// Only for loads.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_slope: Option<f64>,
    pub rms_height: f64,
    pub e_star: f64,
    /// Name of the body's material, and the source of its values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Name of the second body's material, and the source of its values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_material: Option<String>,
    /// Body, unless it is a single half-space or slab on a bonded base.
    #[serde(flatten)]
    pub others: OtherArgs,
    #[serde(skip)]
    pub body: Option<String>,
    /// Relaxation of a viscoelastic body.
    #[serde(flatten)]
    pub relaxation: Option<Relaxation>,
    /// Yielding of a body below its surface.
    #[serde(flatten)]
    pub yielding: Option<Yielding>,
    #[serde(flatten)]
    pub base: BaseArgs,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lower: Option<Lower>,
    /// Only for a path.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub law: Option<String>,
    /// For a path only with free boundaries.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boundary: Option<&'static str>,
    #[serde(skip_serializing_if = "is_normal", with = "named")]
    pub components: Unknown,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardness: Option<GivenHardness>,
    /// Name of the fluid in the gap, and the source of its viscosity.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid: Option<String>,
    /// Only with an attraction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adhesion: Option<Adhesion>,
    /// Absent without a grid error estimate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid_error: Option<FoundBy>,
}

/// Method to find the grid error, as printed.
#[derive(Clone, Debug, Serialize)]
pub struct FoundBy {
    /// Mode of the method.
    #[serde(with = "named")]
    pub mode: GridError,
    /// Points of the finest grid.
    pub n: [usize; 2],
    /// Assumption about the heights between the points.
    pub assumes: &'static str,
    /// Order of the limit's error in the grid spacing, for each number that has one.
    pub orders: BTreeMap<&'static str, f64>,
}

impl FoundBy {
    fn new(prepared: &Prepared) -> Option<Self> {
        let Prepared { facts, surface, .. } = prepared;
        let [nx, ny] = surface.grid.points();
        let n = match facts.grid_error {
            GridError::Refine => [2 * nx, if surface.grid.is_line() { ny } else { 2 * ny }],
            _ => [nx, ny],
        };
        let assumes = match (surface.is_read(), surface.has_shape) {
            (true, _) => "nothing rougher than the pixels",
            (false, true) => "the shape between the points",
            (false, false) => "band-limited",
        };
        let orders = columns::<State>(facts).filter_map(|column| Some((column.limit_of()?, column.order?)));
        let mode = facts.grid_error;
        (mode != GridError::None).then(|| Self { mode, n, assumes, orders: orders.collect() })
    }
}

/// Surface below the slab, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Lower {
    pub surface: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<Scan>,
    pub rms_gradient: f64,
    pub rms_height: f64,
}

impl Head {
    /// Builds the head of a report about the states of a surface.
    pub fn new(asked: &Asked, prepared: &Prepared, surface: &RigidSurface) -> Self {
        let Prepared { facts, surface: Surface { grid, boundary, .. }, inelastic, .. } = prepared;
        let given = &prepared.surface;
        let is_path = facts.sequence == Sequence::Path;
        let friction = inelastic.shear.map(|shear| match shear.limit {
            Limit::Coulomb(_) => "coulomb",
            Limit::Tresca(_) => "tresca",
            Limit::Orowan { .. } => "orowan",
        });
        let law = match friction {
            Some(friction) if facts.has_law() => format!("{}+{friction}", asked.law.law.name()),
            Some(friction) => friction.to_owned(),
            None => asked.law.law.name().to_owned(),
        };
        Self {
            n: grid.points(),
            size: grid.lengths(),
            unit: given.unit.clone(),
            stress_unit: given.stress_unit.clone(),
            surface: given.description.clone(),
            scan: given.scan.clone(),
            second: given.second.clone(),
            rms_gradient: given.rms_gradient(),
            max_slope: (!is_path).then(|| given.max_slope()),
            rms_height: surface.rms_height(),
            e_star: prepared.body.contact_modulus(),
            material: asked.body.material.clone(),
            second_material: asked.body.second_material.clone(),
            others: asked.body.others.clone(),
            body: asked.body.words(asked.lower.given().map(|_| lower::BETWEEN), &given.units()),
            relaxation: None,
            yielding: None,
            base: asked.base.clone().into_owned(),
            lower: prepared.lower.as_ref().map(|lower| Lower {
                surface: lower.description.clone(),
                scan: lower.scan.clone(),
                rms_gradient: lower.rms_gradient(),
                rms_height: lower.statistics.moments.rms_height(),
            }),
            law: is_path.then_some(law),
            boundary: (!is_path || *boundary == Boundary::Free).then(|| boundary.name()),
            components: facts.unknown,
            hardness: asked.hardness.cloned(),
            fluid: None,
            adhesion: prepared.adhesion,
            grid_error: FoundBy::new(prepared),
        }
    }

    /// Returns the units of the numbers.
    pub fn units(&self) -> Units {
        Units::new(self.unit.as_deref(), self.stress_unit.as_deref())
    }

    /// Formats a number of a kind in a readable unit, or as it is with the word `unknown` if its unit is unknown.
    pub fn read(&self, value: f64, kind: &str, unknown: &str) -> String {
        match self.units().shown(kind, value) {
            Some(unit) => unit.text(value),
            None => format!("{}{unknown}", digits(value)),
        }
    }

    /// Warns about slopes and strains that are not small.
    pub fn warn_about_slopes(&self, records: &[Record], facts: &Facts, session: &Session) {
        let Self { rms_gradient, max_slope: Some(max_slope), e_star, .. } = self else { return };
        let Some(slopes) = Slopes::of(*rms_gradient, || *max_slope, facts) else { return };
        let strain = records.iter().map(|record| record.number("max_pressure") / e_star).fold(0.0, f64::max);
        session.warn(Slopes::CODE, slopes.message(strain));
    }
}

impl fmt::Display for Head {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { n: [nx, ny], size: [lx, ly], rms_gradient, rms_height, e_star, .. } = self;
        let unit = self.unit.as_deref().unwrap_or("length units");
        let length = |value: f64| self.read(value, "length", &format!(" {unit}"));
        writeln!(f, "{}", self.surface)?;
        if let Some(scan) = &self.scan {
            write!(f, "{scan}")?;
        }
        match self.units().shown("length", lx.max(*ly)) {
            Some(unit) => writeln!(f, "{nx} x {ny} points, cell {} x {}", unit.text(*lx), unit.text(*ly))?,
            None => writeln!(f, "{nx} x {ny} points, cell {} x {} {unit}", digits(*lx), digits(*ly))?,
        }
        let (kind, free) = if self.boundary == Some(Boundary::Free.name()) {
            ("differences", "; free boundaries: a patch on an unbounded body")
        } else {
            ("spectral", "")
        };
        let law = self.law.as_ref().map_or_else(String::new, |law| format!(", law {law}"));
        writeln!(
            f,
            "rms gradient {rms_gradient:.6} ({kind}), rms height {}, E* = {}{law}{free}{}\n",
            length(*rms_height),
            self.read(*e_star, "stress", ""),
            match self.components {
                Unknown::Normal => "",
                Unknown::All => "; u_x, u_y and u_z unknown, no lateral traction",
                Unknown::Held => "; u_x and u_y held at zero",
            }
        )?;
        if let Some(material) = &self.material {
            writeln!(f, "material: {material}\n")?;
        }
        if let Some(material) = &self.second_material {
            writeln!(f, "material of the second body: {material}\n")?;
        }
        if let Some(fluid) = &self.fluid {
            writeln!(f, "fluid: {fluid}\n")?;
        }
        if let Some(body) = &self.body {
            writeln!(f, "elastic body: {body}\n")?;
        }
        if let Some(relaxation) = &self.relaxation {
            let Relaxation { prony, relaxes, young_long_term, young_instantaneous, .. } = relaxation;
            let branches: Vec<String> = prony.iter().map(|(time, part)| format!("{time}:{part}")).collect();
            writeln!(
                f,
                "viscoelastic: E = {} at once, {} in the long term; branches {} \
                 (relaxation time, fraction), {}\n",
                self.read(*young_instantaneous, "stress", ""),
                self.read(*young_long_term, "stress", ""),
                branches.join(", "),
                relaxes.meaning()
            )?;
        }
        if let Some(Yielding { yield_stress, cells, .. }) = &self.yielding {
            let (count, depth) = (cells.len(), length(cells.iter().sum()));
            let stress = self.read(*yield_stress, "stress", "");
            writeln!(f, "yield stress {stress}, in {count} cells to a depth of {depth}\n")?;
        }
        if let Some(lower) = &self.lower {
            writeln!(f, "lower surface: {}", lower.surface)?;
            writeln!(
                f,
                "rms gradient {:.6} (spectral), rms height {}\n",
                lower.rms_gradient,
                length(lower.rms_height)
            )?;
        }
        Ok(())
    }
}

/// Returns true if only the normal displacement is unknown.
pub fn is_normal(components: &Unknown) -> bool {
    *components == Unknown::Normal
}
