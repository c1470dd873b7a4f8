//! The HDF5 file of steady sliding.

use std::path::PathBuf;

use gfmd_files::{Archive, Dimension, Output, Provenance, Variable, axes, contiguous};
use gfmd_run::failure::Failure;
use gfmd_run::series::Prepared;
use gfmd_viscoelastic::SlidingState;

use super::report::State;

/// The name of a scalar, its unit, its definition, and its value.
type Scalar = (&'static str, &'static str, &'static str, fn(&State) -> f64);

/// The scalars of a state.
pub(super) const SCALARS: &[Scalar] = &[
    ("velocity", "length/time", "velocity of the rigid surface relative to the body", |s| s.velocity),
    ("mean_pressure", "stress", "mean pressure over the whole surface", |s| s.mean_pressure),
    ("p_star", "1", "reduced pressure p/(E* g)", |s| s.p_star),
    ("displacement", "length", "rigid approach beyond first touch", |s| s.displacement),
    ("area_fraction", "1", "points with pressure over all points", |s| s.area_fraction),
    ("mean_gap", "length", "mean distance between the surfaces", |s| s.mean_gap),
    ("max_pressure", "stress", "largest pressure", |s| s.max_pressure),
    ("friction", "1", "coefficient of friction, by the power lost in the body", |s| s.friction),
    ("friction_slope", "1", "coefficient of friction, by the pressure on the slopes", |s| s.friction_slope),
    ("dissipated_power", "stress*length/time", "power lost in the body, per area", |s| s.dissipated_power),
    ("persson_friction", "1", "coefficient of friction by Persson's theory", |s| s.persson.friction),
    ("persson_area_fraction", "1", "contact area by Persson's theory", |s| s.persson.area_fraction),
    ("iterations", "1", "iterations of the search", |s| s.iterations as f64),
    ("transform_pairs", "1", "pairs of transforms of the search", |s| s.transform_pairs),
    ("converged", "1", "1 if the residual is at most the tolerance", |s| f64::from(u8::from(s.converged))),
    ("residual", "1", "largest residual, recomputed from the pressure", |s| s.worst()),
    ("seconds", "s", "wall time", |s| s.seconds),
];

/// The fields of a state, with their units and definitions.
pub(super) const FIELDS: [(&str, &str, &str); 3] = [
    ("pressure", "stress", "pressure on the surface of the body"),
    ("displacement_z", "length", "normal displacement of the surface of the body, negative downwards"),
    ("gap", "length", "distance between the surfaces"),
];

/// A file of states: the surface is written at once, the fields state by state, the scalars at the end.
pub(super) struct StatesFile<'a> {
    archive: Archive<'a>,
}

impl<'a> StatesFile<'a> {
    pub(super) fn new(
        output: &'a Output,
        provenance: &Provenance,
        prepared: &Prepared,
        states: usize,
    ) -> Result<Self, Failure> {
        let mut archive = Archive::create(output, provenance)?;
        let unit = prepared.surface.unit();
        let [x, y] = axes(&prepared.surface.grid, unit);
        prepared.surface.write(&mut archive, [&x, &y])?;
        let state = Dimension::index("state", states, "load and velocity");
        for (name, units, long_name) in FIELDS {
            let units = if units == "length" { unit } else { units };
            archive
                .define(&format!("/fields/{name}"), &Variable { dimensions: &[&state, &x, &y], units, long_name })?;
        }
        Ok(Self { archive })
    }

    pub(super) fn write(&mut self, index: usize, state: &SlidingState) -> Result<(), Failure> {
        let solution = &state.solution;
        for ((name, ..), field) in FIELDS.iter().zip([&solution.pressure, &solution.displacement, &solution.gap]) {
            self.archive.write_slab(&format!("/fields/{name}"), index, &contiguous(field))?;
        }
        Ok(())
    }

    /// Writes the scalars of `count` states, NaN beyond those there are, and gives the file its name.
    pub(super) fn finish(mut self, states: &[State], count: usize) -> Result<PathBuf, Failure> {
        let dimension = Dimension::index("state", count, "load and velocity");
        for (name, units, long_name, value) in SCALARS {
            let values: Vec<f64> = (0..count).map(|index| states.get(index).map_or(f64::NAN, value)).collect();
            let variable = Variable { dimensions: &[&dimension], units, long_name };
            self.archive.write(&format!("/states/{name}"), &variable, &values)?;
        }
        Ok(self.archive.finish()?)
    }
}
