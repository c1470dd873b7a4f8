//! The record of one equilibrated load: the scalars of the JSON output, of `/loads` and of `/runs`.

use gfmd_contact::{Boundary, Effort, Fields, Plastic, Residual, Solution};
use gfmd_field::Grid;
use gfmd_interface::State;
use gfmd_measure::{Column, Scales, Summary};
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

/// The scalars of one load. Units: those of the input (stress, length).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "`SCALARS` has the meanings, once for code and files")]
pub struct LoadRecord {
    pub mean_pressure: f64,
    pub p_star: f64,
    pub displacement: f64,
    pub area_fraction: f64,
    pub area_fraction_corrected: f64,
    pub kappa: f64,
    pub kappa_corrected: f64,
    pub contact_nodes: u64,
    pub boundary_links: u64,
    pub mean_gap: f64,
    pub max_pressure: f64,
    pub mean_pressure_in_contact: f64,
    pub pressure_deviation_in_contact: f64,
    pub pressure_moment_2: f64,
    pub elastic_energy: f64,
    pub iterations: u64,
    pub transform_pairs: f64,
    pub converged: bool,
    pub residual: ResidualRecord,
    pub seconds: f64,
    /// With free boundaries.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force: Option<f64>,
    /// With a hardness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plastic_fraction: Option<f64>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub plastic_volume: Option<f64>,
    #[serde(flatten)]
    pub law: Option<LawRecord>,
}

/// The further scalars of a contact with a law that acts across the gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "`LAW_SCALARS` has the meanings, once for code and files")]
pub struct LawRecord {
    pub interface_energy: f64,
    pub passed_instability: bool,
    pub lowest_curvature: f64,
    pub residual_equilibrium: f64,
}

/// The four residuals (docs/interface.md).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "`SCALARS` has the meanings, once for code and files")]
pub struct ResidualRecord {
    pub complementarity: f64,
    pub penetration: f64,
    pub negative_pressure: f64,
    pub load: f64,
    /// With a hardness.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub saturation: Option<f64>,
}

impl ResidualRecord {
    /// The largest of the residuals; NaN if any is NaN.
    pub fn worst(&self) -> f64 {
        let Self { complementarity, penetration, negative_pressure, load, saturation } = *self;
        gfmd_relax::worst([complementarity, penetration, negative_pressure, load, saturation.unwrap_or(0.0)])
    }
}

impl From<Residual> for ResidualRecord {
    fn from(residual: Residual) -> Self {
        let Residual { complementarity, penetration, negative_pressure, load } = residual;
        Self { complementarity, penetration, negative_pressure, load, saturation: None }
    }
}

/// A state that can be recorded as a load.
pub trait Recorded: Fields {
    /// The residuals of the state.
    fn residual_record(&self) -> ResidualRecord;

    /// What gives way, if the contact has a hardness.
    fn plastic(&self) -> Option<&Plastic> {
        None
    }

    /// The scalars of the law, if one acts across the gap.
    fn law_record(&self) -> Option<LawRecord>;
}

impl Recorded for Solution {
    fn residual_record(&self) -> ResidualRecord {
        let saturation = self.plastic.as_ref().map(|plastic| plastic.saturation);
        ResidualRecord { saturation, ..self.residual.into() }
    }

    fn plastic(&self) -> Option<&Plastic> {
        self.plastic.as_ref()
    }

    fn law_record(&self) -> Option<LawRecord> {
        None
    }
}

impl Recorded for State {
    fn residual_record(&self) -> ResidualRecord {
        let gfmd_interface::Residual { complementarity, penetration, wall_tension, load, .. } = self.residual;
        ResidualRecord { complementarity, penetration, negative_pressure: wall_tension, load, saturation: None }
    }

    fn law_record(&self) -> Option<LawRecord> {
        Some(LawRecord {
            interface_energy: self.interface_energy,
            passed_instability: self.passed_instability,
            lowest_curvature: self.lowest_curvature,
            residual_equilibrium: self.residual.equilibrium,
        })
    }
}

impl LoadRecord {
    /// The record as TOML, which holds every number to the last bit, and NaN.
    ///
    /// # Errors
    /// None for numbers.
    pub fn to_toml(&self) -> Result<String, Failure> {
        let table = toml::Table::try_from(self);
        table.map(|table| table.to_string()).map_err(|error| Failure::Computation(error.to_string()))
    }

    /// Measures a state in units of `scales`.
    pub fn measure<S: Recorded>(state: &S, scales: &Scales, tolerance: f64, seconds: f64) -> Self {
        let summary = state.summary_in(scales);
        let converged = state.worst() <= tolerance;
        let residual = state.residual_record();
        let wall = Self::of(&summary, state.approach(), state.effort(), residual, converged, seconds);
        let plastic_fraction = state.plastic().map(|plastic| plastic.fraction);
        let plastic_volume = state.plastic().map(|plastic| plastic.volume);
        Self { law: state.law_record(), plastic_fraction, plastic_volume, ..wall }
    }

    /// The record with the force, if the surface on `grid` does not repeat.
    pub fn bounded(self, boundary: Boundary, grid: &Grid) -> Self {
        let [x, y] = grid.lengths();
        let force = (boundary == Boundary::Free).then_some(self.mean_pressure * x * y);
        Self { force, ..self }
    }

    /// Refuses units in which a number of load `index` is not finite. With a law κ may be undefined.
    ///
    /// # Errors
    /// The name and the value of such a number.
    pub fn check(&self, index: usize) -> Result<(), Failure> {
        let undefined = |name: &str| self.law.is_some() && name.starts_with("kappa");
        match SCALARS.iter().find(|column| !(column.value)(self).is_finite() && !undefined(column.name)) {
            Some(column) if self.converged => Err(Failure::Computation(format!(
                "load {index}: {} is {}; it must be finite, which other units of stress or length make it",
                column.name,
                (column.value)(self)
            ))),
            _ => Ok(()),
        }
    }

    /// Makes the record for a hard wall from its parts.
    pub fn of(
        summary: &Summary,
        approach: f64,
        effort: Effort,
        residual: ResidualRecord,
        converged: bool,
        seconds: f64,
    ) -> Self {
        Self {
            mean_pressure: summary.mean_pressure,
            p_star: summary.p_star,
            displacement: approach,
            area_fraction: summary.area_fraction,
            area_fraction_corrected: summary.area_fraction_corrected,
            kappa: summary.kappa,
            kappa_corrected: summary.kappa_corrected,
            contact_nodes: summary.contact_nodes,
            boundary_links: summary.boundary_links,
            mean_gap: summary.mean_gap,
            max_pressure: summary.max_pressure,
            mean_pressure_in_contact: summary.mean_pressure_in_contact,
            pressure_deviation_in_contact: summary.pressure_deviation_in_contact,
            pressure_moment_2: summary.pressure_moment_2,
            elastic_energy: summary.elastic_energy,
            iterations: effort.iterations,
            transform_pairs: effort.transform_pairs,
            converged,
            residual,
            seconds,
            force: None,
            plastic_fraction: None,
            plastic_volume: None,
            law: None,
        }
    }
}

/// Appends the scale of stress to the meaning of a residual that is a stress.
macro_rules! per_stress {
    ($what:literal) => {
        concat!($what, " / the stress scale (the largest traction, or the softest stiffness times h_rms if more)")
    };
}

/// All scalars, in the order of the files.
pub const SCALARS: &[Column<LoadRecord>] = &[
    Column::new("mean_pressure", "stress", "mean pressure over the whole surface", |r| r.mean_pressure),
    Column::new("p_star", "1", "reduced pressure p/(E* g)", |r| r.p_star),
    Column::new("displacement", "length", "rigid approach beyond first touch", |r| r.displacement),
    Column::new("area_fraction", "1", "contact area fraction, points in contact over all points", |r| r.area_fraction),
    Column::new(
        "area_fraction_corrected",
        "1",
        "contact area fraction less the excess of the pixels along the perimeter (Yastrebov et al. 2017)",
        |r| r.area_fraction_corrected,
    ),
    Column::new("kappa", "1", "area_fraction / p_star", |r| r.kappa),
    Column::new("kappa_corrected", "1", "area_fraction_corrected / p_star", |r| r.kappa_corrected),
    Column::new("contact_nodes", "1", "number of points in contact", |r| r.contact_nodes as f64),
    Column::new("boundary_links", "1", "neighbouring pairs with one point in contact and one not", |r| {
        r.boundary_links as f64
    }),
    Column::new("mean_gap", "length", "mean distance between the surfaces", |r| r.mean_gap),
    Column::new("max_pressure", "stress", "largest pressure", |r| r.max_pressure),
    Column::new("mean_pressure_in_contact", "stress", "mean pressure over the points in contact", |r| {
        r.mean_pressure_in_contact
    }),
    Column::new(
        "pressure_deviation_in_contact",
        "stress",
        "standard deviation of the pressure over the points in contact",
        |r| r.pressure_deviation_in_contact,
    ),
    Column::new("pressure_moment_2", "stress^2", "mean square pressure over the whole surface", |r| {
        r.pressure_moment_2
    }),
    Column::new("elastic_energy", "stress*length", "elastic energy per area of the surface", |r| r.elastic_energy),
    Column::new("iterations", "1", "iterations or time steps of the solver", |r| r.iterations as f64),
    Column::new("transform_pairs", "1", "forward and inverse real transforms of the full grid, in pairs", |r| {
        r.transform_pairs
    }),
    Column::new("converged", "1", "1 if all four residuals are at most the tolerance", |r| {
        f64::from(u8::from(r.converged))
    }),
    Column::new("residual_complementarity", "1", "sum(p gap) / (sum(p) h_rms), from the final fields", |r| {
        r.residual.complementarity
    }),
    Column::new("residual_penetration", "1", "max(0, -min gap) / h_rms, from the final fields", |r| {
        r.residual.penetration
    }),
    Column::new("residual_negative_pressure", "1", "max(0, -min p) / mean p, from the final fields", |r| {
        r.residual.negative_pressure
    }),
    Column::new("residual_load", "1", "|mean p - asked| / asked, from the final fields", |r| r.residual.load),
];

/// The force of a contact with free boundaries.
pub const FORCE: Column<LoadRecord> =
    Column::new("force", "stress*length^2", "force, of a line per length across it (stress*length)", |r| {
        r.force.unwrap_or(f64::NAN)
    });

/// The scalars of a contact with a hardness.
pub const PLASTIC_SCALARS: &[Column<LoadRecord>] = &[
    Column::new("plastic_fraction", "1", "points whose pressure is the hardness over all points", |r| {
        r.plastic_fraction.unwrap_or(f64::NAN)
    }),
    Column::new("plastic_volume", "length", "mean plastic depth over the whole surface", |r| {
        r.plastic_volume.unwrap_or(f64::NAN)
    }),
    Column::new("residual_saturation", "1", "largest gap / h_rms where the pressure is the hardness", |r| {
        r.residual.saturation.unwrap_or(f64::NAN)
    }),
];

/// The wall time of a load, which is not in [`SCALARS`] because it differs between identical runs.
pub const SECONDS: Column<LoadRecord> = Column::new("seconds", "s", "wall time of the solve", |r| r.seconds);

/// The scalars of [`LawRecord`]; NaN for a hard wall alone.
pub const LAW_SCALARS: &[Column<LoadRecord>] = &[
    Column::new("interface_energy", "stress*length", "energy of the contact law per area of the surface", |r| {
        r.law.map_or(f64::NAN, |law| law.interface_energy)
    }),
    Column::new(
        "passed_instability",
        "1",
        "1 if directions of negative curvature were met on the way from the last load",
        |r| r.law.map_or(f64::NAN, |law| f64::from(u8::from(law.passed_instability))),
    ),
    Column::new(
        "lowest_curvature",
        "1",
        "lowest curvature met in the last search for a step, over the elastic curvature",
        |r| r.law.map_or(f64::NAN, |law| law.lowest_curvature),
    ),
    Column::new(
        "residual_equilibrium",
        "1",
        per_stress!("largest unbalanced force per area, from the final fields,"),
        |r| r.law.map_or(f64::NAN, |law| law.residual_equilibrium),
    ),
];

/// The scalars whose meaning is different if a law acts across the gap. In contact are then the points that are repelled:
/// those under pressure of the wall, or all with a positive pressure if there is no wall.
const MEANINGS_WITH_LAW: &[(&str, &str)] = &[
    ("area_fraction", "contact area fraction, points that are repelled over all points"),
    ("kappa", "area_fraction / p_star; NaN if attraction carries the load"),
    ("kappa_corrected", "area_fraction_corrected / p_star; NaN if attraction carries the load"),
    ("contact_nodes", "number of points that are repelled"),
    ("boundary_links", "neighbouring pairs with one point repelled and one not"),
    ("max_pressure", "largest repulsive pressure"),
    ("mean_pressure_in_contact", "mean repulsive pressure over the points that are repelled"),
    ("pressure_deviation_in_contact", "standard deviation of the repulsive pressure over the points that are repelled"),
    ("pressure_moment_2", "mean square repulsive pressure over the whole surface"),
    ("converged", "1 if all five residuals are at most the tolerance"),
    ("residual_complementarity", "sum(p gap) / (sum(p) h_rms) with p the pressure of the wall, from the final fields"),
    (
        "residual_negative_pressure",
        per_stress!("largest tension that the wall would have to hold, from the final fields,"),
    ),
    ("residual_load", per_stress!("|mean p - asked| from the final fields, 0 if the approach is prescribed,")),
];

/// The scalars of a load in a file. Names and units are common to all contacts; the meanings depend on the interaction
/// between the surfaces.
pub fn columns(with_law: bool, boundary: Boundary, is_plastic: bool) -> Vec<Column<LoadRecord>> {
    let mut columns: Vec<Column<LoadRecord>> = SCALARS.iter().chain([&SECONDS]).copied().collect();
    if boundary == Boundary::Free {
        columns.push(FORCE);
    }
    if is_plastic {
        columns.extend_from_slice(PLASTIC_SCALARS);
    }
    if with_law {
        for column in &mut columns {
            if let Some((_, meaning)) = MEANINGS_WITH_LAW.iter().find(|(name, _)| *name == column.name) {
                column.long_name = meaning;
            }
        }
        columns.extend_from_slice(LAW_SCALARS);
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_has_the_same_names_with_meanings_of_its_own() {
        let (wall, law) = (columns(false, Boundary::Periodic, false), columns(true, Boundary::Periodic, false));
        let meaning = |columns: &[Column<LoadRecord>], name: &str| {
            columns.iter().find(|column| column.name == name).map(|column| column.long_name)
        };
        for (name, own) in MEANINGS_WITH_LAW {
            assert_eq!(meaning(&law, name), Some(*own));
            assert!(meaning(&wall, name).is_some_and(|of_wall| of_wall != *own), "{name}");
        }
        let names = wall.iter().zip(&law).all(|(a, b)| (a.name, a.units) == (b.name, b.units));
        assert!(names && law.len() == wall.len() + LAW_SCALARS.len());
    }
}
