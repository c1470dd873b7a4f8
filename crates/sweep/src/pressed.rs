//! The numbers that a sweep records of each contact.

use gfmd_contact::Solution;
use gfmd_measure::{contact_area, elastic_energy_density, kappa, pressure_statistics, reduced_pressure};
use serde::{Deserialize, Serialize};

/// The numbers of one equilibrated load of a run. The unit of length is the cell, that of stress as of Young's modulus.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pressed {
    /// Mean pressure over the whole surface.
    pub mean_pressure: f64,
    /// Reduced pressure p/(E* g).
    pub p_star: f64,
    /// Rigid approach beyond first touch.
    pub approach: f64,
    /// Contact area fraction, points in contact over all points.
    pub area_fraction: f64,
    /// Contact area fraction less the pixels' excess along the perimeter.
    pub area_fraction_corrected: f64,
    /// area_fraction / p_star.
    pub kappa: f64,
    /// area_fraction_corrected / p_star.
    pub kappa_corrected: f64,
    /// Number of points in contact.
    pub contact_nodes: u64,
    /// Number of neighbouring pairs with one point in contact and one not.
    pub boundary_links: u64,
    /// Mean distance between the surfaces.
    pub mean_gap: f64,
    /// Largest pressure.
    pub max_pressure: f64,
    /// Mean pressure over the points in contact.
    pub mean_pressure_in_contact: f64,
    /// Standard deviation of the pressure over the points in contact.
    pub pressure_deviation_in_contact: f64,
    /// Mean square pressure over the whole surface.
    pub pressure_moment_2: f64,
    /// Elastic energy per area of the surface.
    pub elastic_energy: f64,
    /// Iterations of the solver.
    pub iterations: u64,
    /// Transform pairs that the solver took.
    pub transform_pairs: f64,
    /// sum(p gap) / (sum(p) h_rms).
    pub residual_complementarity: f64,
    /// max(0, -min gap) / h_rms.
    pub residual_penetration: f64,
    /// max(0, -min p) / mean p.
    pub residual_negative_pressure: f64,
    /// |mean p - asked| / asked.
    pub residual_load: f64,
}

impl Pressed {
    /// Measures a solution. `rms_gradient` is the spectral one of the whole surface.
    pub(crate) fn measure(solution: &Solution, contact_modulus: f64, rms_gradient: f64) -> Self {
        let area = contact_area(solution.pressure.view());
        let pressure = pressure_statistics(solution.pressure.view());
        let p_star = reduced_pressure(solution.mean_pressure, contact_modulus, rms_gradient);
        Self {
            mean_pressure: solution.mean_pressure,
            p_star,
            approach: solution.approach,
            area_fraction: area.fraction,
            area_fraction_corrected: area.corrected_fraction,
            kappa: kappa(area.fraction, p_star),
            kappa_corrected: kappa(area.corrected_fraction, p_star),
            contact_nodes: area.nodes as u64,
            boundary_links: area.boundary_links as u64,
            mean_gap: solution.gap.mean().unwrap_or(f64::NAN),
            max_pressure: pressure.max,
            mean_pressure_in_contact: pressure.mean_in_contact,
            pressure_deviation_in_contact: pressure.deviation_in_contact,
            pressure_moment_2: pressure.moments[0],
            elastic_energy: elastic_energy_density(solution.pressure.view(), solution.displacement.view()),
            iterations: solution.iterations,
            transform_pairs: solution.transform_pairs,
            residual_complementarity: solution.residual.complementarity,
            residual_penetration: solution.residual.penetration,
            residual_negative_pressure: solution.residual.negative_pressure,
            residual_load: solution.residual.load,
        }
    }
}
