//! What a path prints.

use std::fmt;
use std::path::PathBuf;

use serde::Serialize;

use super::StepRecord;
use crate::session::list_files;

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub n: [usize; 2],
    pub length: [f64; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    pub surface: String,
    pub rms_gradient: f64,
    pub rms_height: f64,
    pub e_star: f64,
    pub law: String,
    /// Unit vector of the lateral displacement, on which lateral numbers of the table and the plots are projected.
    pub direction: [f64; 2],
    pub steps: Vec<StepRecord>,
    /// One for each leg that moves sideways.
    pub sliding: Vec<Sliding>,
    /// Work done along the path that is not stored at its end, per area.
    pub dissipated: f64,
    pub lowest_mean_pressure: f64,
    /// The step at which the surfaces parted under their load, the last one.
    pub parted_at: Option<usize>,
    pub peak_bytes: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

/// What a leg says of friction.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Sliding {
    /// Number of the leg, from 1.
    pub leg: usize,
    /// Shear over lateral displacement in its first step, stress/length.
    pub tangential_stiffness: f64,
    /// Largest mean shear, in magnitude, over the mean pressure of the same step: at the end of a leg that was long
    /// enough to slide everywhere, the coefficient of static friction.
    pub friction_coefficient: f64,
}

impl Report {
    /// The part along the lateral displacement.
    pub fn along(&self, [x, y]: [f64; 2]) -> f64 {
        x * self.direction[0] + y * self.direction[1]
    }

    /// The legs of so many steps each that move sideways.
    pub(super) fn sliding(&self, steps_of_leg: usize) -> Vec<Sliding> {
        let last = self.steps.len().saturating_sub(1);
        let leg = |(number, start): (usize, usize)| {
            let leg = &self.steps[start..=(start + steps_of_leg).min(last)];
            let [moved, sheared] = [|step: &StepRecord| step.lateral, |step: &StepRecord| step.mean_shear]
                .map(|of| self.along(of(&leg[1])) - self.along(of(&leg[0])));
            let coefficient = |step: &StepRecord| (self.along(step.mean_shear) / step.mean_pressure).abs();
            (moved != 0.0).then(|| Sliding {
                leg: number + 1,
                tangential_stiffness: sheared / moved,
                friction_coefficient: leg[1..].iter().map(coefficient).fold(0.0, f64::max),
            })
        };
        (0..last).step_by(steps_of_leg).enumerate().filter_map(leg).collect()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [nx, ny] = self.n;
        let unit = self.unit.as_deref().unwrap_or("length units");
        writeln!(f, "{}", self.surface)?;
        writeln!(f, "{nx} x {ny} points, cell {:.6e} x {:.6e} {unit}", self.length[0], self.length[1])?;
        writeln!(
            f,
            "rms gradient {:.6} (spectral), rms height {:.6e} {unit}, E* = {:.6e}, law {}\n",
            self.rms_gradient, self.rms_height, self.e_star, self.law
        )?;
        let heads =
            ["pressure", "approach", "lateral", "shear", "area", "stick", "energy", "dissipated", "steps", "residual"];
        writeln!(f, "{:>5}{}", "", heads.map(|head| format!("{head:>12}")).concat())?;
        for (index, step) in self.steps.iter().enumerate() {
            let law = if step.interface_energy.is_nan() { 0.0 } else { step.interface_energy };
            writeln!(
                f,
                "{index:>5}{:>12.4e}{:>12.4e}{:>12.4e}{:>12.4e}{:>12.6}{:>12.6}{:>12.4e}{:>12.4e}{:>12}{:>12.1e}{}{}",
                step.mean_pressure,
                step.displacement,
                self.along(step.lateral),
                self.along(step.mean_shear),
                step.area_fraction,
                step.stick_fraction,
                step.elastic_energy + law,
                step.dissipated,
                step.iterations,
                step.residual.worst(),
                if step.passed_instability { "  passed an instability" } else { "" },
                if step.converged { "" } else { "  NOT CONVERGED" }
            )?;
        }
        if let Some(step) = self.parted_at {
            writeln!(f, "{step:>5}  the surfaces part")?;
        }
        for leg in &self.sliding {
            writeln!(
                f,
                "leg {}: tangential stiffness {:.4e} at first, friction coefficient up to {:.6}",
                leg.leg, leg.tangential_stiffness, leg.friction_coefficient
            )?;
        }
        writeln!(
            f,
            "\ndissipated {:.6e} per area, lowest mean pressure {:.6e}",
            self.dissipated, self.lowest_mean_pressure
        )?;
        list_files(f, self.out.as_deref(), &self.plots)
    }
}
