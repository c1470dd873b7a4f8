//! What is recorded of one equilibrated load: the scalars of the JSON output, of `/loads` and of `/runs`.

use gfmd_contact::{Effort, Fields, Residual, Solution};
use gfmd_interface::State;
use gfmd_measure::{Scales, Summary};
use serde::{Deserialize, Serialize};

/// The scalars of one load. Units: those of the input (stress, length).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "`SCALARS` says what each is, once for code and files")]
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
    #[serde(flatten)]
    pub law: Option<LawRecord>,
}

/// What a contact with a law that reaches across the gap has besides.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "`LAW_SCALARS` says what each is, once for code and files")]
pub struct LawRecord {
    pub interface_energy: f64,
    pub passed_instability: bool,
    pub lowest_curvature: f64,
    pub residual_equilibrium: f64,
}

/// The four residuals (docs/interface.md).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "`SCALARS` says what each is, once for code and files")]
pub struct ResidualRecord {
    pub complementarity: f64,
    pub penetration: f64,
    pub negative_pressure: f64,
    pub load: f64,
}

impl From<Residual> for ResidualRecord {
    fn from(residual: Residual) -> Self {
        let Residual { complementarity, penetration, negative_pressure, load } = residual;
        Self { complementarity, penetration, negative_pressure, load }
    }
}

impl LoadRecord {
    /// Measures the state of a hard wall. `rms_gradient` is the spectral one of the whole surface.
    pub fn measure(solution: &Solution, contact_modulus: f64, rms_gradient: f64, tolerance: f64, seconds: f64) -> Self {
        let summary = solution.summary_in(&Scales { contact_modulus, rms_gradient });
        let converged = solution.worst() <= tolerance;
        Self::of(&summary, solution.approach, solution.effort, solution.residual.into(), converged, seconds)
    }

    /// The record of a hard wall from its parts.
    pub(crate) fn of(
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
            law: None,
        }
    }

    /// Measures the state of a law that reaches across the gap.
    pub fn of_state(state: &State, scales: &Scales, tolerance: f64, seconds: f64) -> Self {
        let residual = ResidualRecord {
            complementarity: state.residual.complementarity,
            penetration: state.residual.penetration,
            negative_pressure: state.residual.wall_tension,
            load: state.residual.load,
        };
        let converged = state.worst() <= tolerance;
        let law = LawRecord {
            interface_energy: state.interface_energy,
            passed_instability: state.passed_instability,
            lowest_curvature: state.lowest_curvature,
            residual_equilibrium: state.residual.equilibrium,
        };
        let summary = state.summary_in(scales);
        Self { law: Some(law), ..Self::of(&summary, state.approach, state.effort, residual, converged, seconds) }
    }
}

/// One scalar of [`LoadRecord`] as a variable of a file.
pub struct Scalar {
    /// Name of the variable.
    pub name: &'static str,
    /// Kind of quantity.
    pub units: &'static str,
    /// Meaning.
    pub long_name: &'static str,
    /// The value.
    pub value: fn(&LoadRecord) -> f64,
}

const fn scalar(
    name: &'static str,
    units: &'static str,
    long_name: &'static str,
    value: fn(&LoadRecord) -> f64,
) -> Scalar {
    Scalar { name, units, long_name, value }
}

/// All scalars, in the order of the files.
pub const SCALARS: &[Scalar] = &[
    scalar("mean_pressure", "stress", "mean pressure over the whole surface", |r| r.mean_pressure),
    scalar("p_star", "1", "reduced pressure p/(E* g)", |r| r.p_star),
    scalar("displacement", "length", "rigid approach beyond first touch", |r| r.displacement),
    scalar("area_fraction", "1", "contact area fraction, points in contact over all points", |r| r.area_fraction),
    scalar(
        "area_fraction_corrected",
        "1",
        "contact area fraction less the pixels' excess along the perimeter (Yastrebov et al. 2017)",
        |r| r.area_fraction_corrected,
    ),
    scalar("kappa", "1", "area_fraction / p_star", |r| r.kappa),
    scalar("kappa_corrected", "1", "area_fraction_corrected / p_star", |r| r.kappa_corrected),
    scalar("contact_nodes", "1", "number of points in contact", |r| r.contact_nodes as f64),
    scalar("boundary_links", "1", "neighbouring pairs with one point in contact and one not", |r| {
        r.boundary_links as f64
    }),
    scalar("mean_gap", "length", "mean distance between the surfaces", |r| r.mean_gap),
    scalar("max_pressure", "stress", "largest pressure", |r| r.max_pressure),
    scalar("mean_pressure_in_contact", "stress", "mean pressure over the points in contact", |r| {
        r.mean_pressure_in_contact
    }),
    scalar(
        "pressure_deviation_in_contact",
        "stress",
        "standard deviation of the pressure over the points in contact",
        |r| r.pressure_deviation_in_contact,
    ),
    scalar("pressure_moment_2", "stress^2", "mean square pressure over the whole surface", |r| r.pressure_moment_2),
    scalar("elastic_energy", "stress*length", "elastic energy per area of the surface", |r| r.elastic_energy),
    scalar("iterations", "1", "iterations or time steps of the solver", |r| r.iterations as f64),
    scalar("transform_pairs", "1", "forward and inverse real transforms of the full grid, in pairs", |r| {
        r.transform_pairs
    }),
    scalar("converged", "1", "1 if all four residuals are at most the tolerance", |r| f64::from(u8::from(r.converged))),
    scalar("residual_complementarity", "1", "sum(p gap) / (sum(p) h_rms), from the final fields", |r| {
        r.residual.complementarity
    }),
    scalar("residual_penetration", "1", "max(0, -min gap) / h_rms, from the final fields", |r| r.residual.penetration),
    scalar("residual_negative_pressure", "1", "max(0, -min p) / mean p, from the final fields", |r| {
        r.residual.negative_pressure
    }),
    scalar("residual_load", "1", "|mean p - asked| / asked, from the final fields", |r| r.residual.load),
];

/// Wall time of a load: recorded, but not among the numbers that repeat.
pub const SECONDS: Scalar = scalar("seconds", "s", "wall time of the solve", |r| r.seconds);

/// The scalars of [`LawRecord`]; NaN of a hard wall alone.
pub const LAW_SCALARS: &[Scalar] = &[
    scalar("interface_energy", "stress*length", "energy of the contact law per area of the surface", |r| {
        r.law.map_or(f64::NAN, |law| law.interface_energy)
    }),
    scalar(
        "passed_instability",
        "1",
        "1 if directions of negative curvature were met on the way from the last load",
        |r| r.law.map_or(f64::NAN, |law| f64::from(u8::from(law.passed_instability))),
    ),
    scalar(
        "lowest_curvature",
        "1",
        "lowest curvature that the last search for a step saw, over the elastic one",
        |r| r.law.map_or(f64::NAN, |law| law.lowest_curvature),
    ),
    scalar(
        "residual_equilibrium",
        "1",
        "largest force per area that nothing balances, over the largest traction",
        |r| r.law.map_or(f64::NAN, |law| law.residual_equilibrium),
    ),
];
