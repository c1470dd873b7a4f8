//! The record of one equilibrated load: the scalars of the JSON output, of `/loads` and of `/runs`.

use gfmd_contact::{Boundary, Effort, Fields as _, Residual, Solution, Stiffness};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_measure::{Scales, Summary};
use gfmd_problem::Rest;
use serde::{Deserialize, Serialize};

use crate::failure::Failure;

mod columns;
mod recorded;
mod undefined;

pub use columns::{
    FLOW, FORCE, LATERAL_TRACTION, LAW_SCALARS, LOWER, PLASTIC_SCALARS, Recording, SCALARS, SECONDS, SLOPE_SCALARS,
    STATISTICS, STIFFNESS, columns,
};
pub use undefined::Undefined;

/// The scalars of one load. Units: those of the input (stress, length).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
    /// NaN with a reason where there is none.
    #[serde(default = "unknown")]
    pub stiffness: f64,
    #[serde(default = "unknown")]
    pub stiffness_error: f64,
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
    /// With finite slopes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_shear: Option<[f64; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub projected_area_fraction: Option<f64>,
    /// With statistics.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub patches: Option<PatchRecord>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conductance: Option<f64>,
    /// With the flow through the gap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flow: Option<FlowRecord>,
    /// The numbers of the lower face of a slab between two surfaces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<LowerRecord>,
    /// The reasons why columns have no value.
    #[serde(default, skip_serializing_if = "Undefined::is_empty")]
    pub undefined: Undefined,
    #[serde(flatten)]
    pub law: Option<LawRecord>,
}

/// The contact of the lower face of a slab between two surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "`LOWER` has the meanings, once for code and files")]
pub struct LowerRecord {
    pub mean_pressure: f64,
    pub displacement: f64,
    pub area_fraction: f64,
    pub area_fraction_corrected: f64,
    pub contact_nodes: u64,
    pub boundary_links: u64,
    pub mean_gap: f64,
    pub max_pressure: f64,
    pub mean_pressure_in_contact: f64,
    pub residual: ResidualRecord,
}

impl From<&Solution> for LowerRecord {
    fn from(state: &Solution) -> Self {
        let summary = state.summary();
        Self {
            mean_pressure: summary.mean_pressure,
            displacement: state.approach,
            area_fraction: summary.area_fraction,
            area_fraction_corrected: summary.area_fraction_corrected,
            contact_nodes: summary.contact_nodes,
            boundary_links: summary.boundary_links,
            mean_gap: summary.mean_gap,
            max_pressure: summary.max_pressure,
            mean_pressure_in_contact: summary.mean_pressure_in_contact,
            residual: state.residual.into(),
        }
    }
}

/// The patches of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "`STATISTICS` has the meanings, once for code and files")]
pub struct PatchRecord {
    pub count: u64,
    pub largest_fraction: f64,
    pub percolates: [bool; 2],
}

/// The flow through the gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "`FLOW` has the meanings, once for code and files")]
pub struct FlowRecord {
    pub conductivity: [[f64; 2]; 2],
    /// NaN off the diagonal, here and below.
    pub conductivity_limit: [[f64; 2]; 2],
    pub conductivity_limit_error: [[f64; 2]; 2],
    pub conductivity_grid_error: [[f64; 2]; 2],
    pub percolates: [bool; 2],
    pub residual: f64,
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

/// The residuals of a contact: four, and those that a hardness, all components or finite slopes add (docs/interface.md).
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
    /// With all components.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_traction: Option<f64>,
    /// With finite slopes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lateral_displacement: Option<f64>,
}

impl ResidualRecord {
    /// The largest of the residuals; NaN if any is NaN.
    pub fn worst(&self) -> f64 {
        let Self { complementarity, penetration, negative_pressure, load, .. } = *self;
        let others =
            [self.saturation, self.lateral_traction, self.lateral_displacement].map(|found| found.unwrap_or(0.0));
        gfmd_relax::worst([complementarity, penetration, negative_pressure, load].into_iter().chain(others))
    }
}

impl From<Residual> for ResidualRecord {
    fn from(residual: Residual) -> Self {
        let Residual { complementarity, penetration, negative_pressure, load } = residual;
        let [saturation, lateral_traction, lateral_displacement] = [None; 3];
        Self {
            complementarity,
            penetration,
            negative_pressure,
            load,
            saturation,
            lateral_traction,
            lateral_displacement,
        }
    }
}

/// The reason why a load that is not solved has no stiffness.
pub const UNSOLVED: &str = "the load is not solved";

/// The columns of a load, and of a step, that depend on the level of the displacement.
pub(crate) const WITHOUT_LEVEL: [&str; 2] = ["displacement", "elastic_energy"];

/// The reason why they have no value.
pub(crate) const NO_LEVEL: &str = "a profile with free boundaries on a half-space is displaced by a logarithm of the distance: its \
                                   displacement is known up to a constant, as are the approach, the elastic energy and the stiffness";

/// True if the displacement of a surface on `grid` has a level: that of points far away, or that of its mean.
pub(crate) fn has_level(boundary: Boundary, grid: &Grid, body: &Body) -> bool {
    boundary == Boundary::Periodic || gfmd_green::has_level(body, grid)
}

fn unknown() -> f64 {
    f64::NAN
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
    pub fn measure(state: &Rest, scales: &Scales, tolerance: f64, seconds: f64) -> Self {
        let summary = state.summary_in(scales);
        let converged = state.worst() <= tolerance;
        let residual = ResidualRecord::of(state);
        let wall = Self::of(&summary, state.approach(), state.effort(), residual, converged, seconds);
        let plastic_fraction = state.plastic().map(|plastic| plastic.fraction);
        let plastic_volume = state.plastic().map(|plastic| plastic.volume);
        let mean_shear = state.steep().map(|steep| steep.mean_shear);
        let projected_area_fraction = state.steep().and_then(|steep| steep.projected_area().ok());
        let (law, lower) = (LawRecord::of(state), state.lower().map(LowerRecord::from));
        let mut record =
            Self { law, plastic_fraction, plastic_volume, mean_shear, projected_area_fraction, lower, ..wall };
        let Some(law) = law else { return record };
        for (column, _) in [("kappa", record.kappa), ("kappa_corrected", record.kappa_corrected)]
            .into_iter()
            .filter(|(_, value)| value.is_nan())
        {
            record.undefined.insert(column, "attraction carries the load, to which the area has no ratio");
        }
        if !law.lowest_curvature.is_finite() {
            record.undefined.insert(
                "lowest_curvature",
                "no curvature was computed: by dynamics, or where the search ended before its first step",
            );
        }
        record
    }

    /// The record with the force, if the surface on `grid` does not repeat, and without the numbers that depend on the level of
    /// the displacement, if this surface of `body` has none.
    pub fn bounded(mut self, boundary: Boundary, grid: &Grid, body: &Body) -> Self {
        let [x, y] = grid.lengths();
        self.force = (boundary == Boundary::Free).then_some(self.mean_pressure * x * y);
        if !has_level(boundary, grid, body) {
            (self.displacement, self.elastic_energy) = (f64::NAN, f64::NAN);
            WITHOUT_LEVEL.iter().for_each(|name| self.undefined.insert(name, NO_LEVEL));
        }
        self
    }

    /// The record with the stiffness of a contact, or with the reason why it has none.
    pub fn stiff(mut self, stiffness: Result<Stiffness, &str>) -> Self {
        let found = match stiffness {
            Ok(found) if found.value.is_finite() => Ok(found),
            // The only contact without a level that gives a stiffness.
            Ok(found) if found.value.is_nan() => Err(NO_LEVEL),
            Ok(_) => {
                Err("infinite: in full contact the surface moves as a whole, and the mean level of this body is fixed")
            }
            Err(reason) => Err(reason),
        };
        (self.stiffness, self.stiffness_error) = found.map_or((f64::NAN, f64::NAN), |found| (found.value, found.error));
        if let Err(reason) = found {
            ["stiffness", "stiffness_error"].iter().for_each(|name| self.undefined.insert(name, reason));
        }
        self
    }

    /// Refuses units in which a number of load `index` is not finite. With a law κ may be undefined.
    ///
    /// # Errors
    /// The name and the value of such a number.
    pub fn check(&self, index: usize) -> Result<(), Failure> {
        let undefined = |name: &str| self.law.is_some() && name.starts_with("kappa") || self.undefined.has(name);
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
            stiffness: f64::NAN,
            stiffness_error: f64::NAN,
            iterations: effort.iterations,
            transform_pairs: effort.transform_pairs,
            converged,
            residual,
            seconds,
            force: None,
            plastic_fraction: None,
            plastic_volume: None,
            mean_shear: None,
            projected_area_fraction: None,
            patches: None,
            conductance: None,
            flow: None,
            lower: None,
            undefined: Undefined::default(),
            law: None,
        }
    }
}
