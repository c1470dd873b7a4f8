//! Check of a wear file.

use std::path::PathBuf;

use gfmd_check::result::Comparison;
use gfmd_check::series::Stored;
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_problem::AnyState;
use gfmd_record::StateContext;
use gfmd_run::series::Chosen;

use super::Args;
use crate::checking::{Checked, Checking};
use crate::course::{StepArgs, leak};

impl Checked for Args {
    /// Recomputes the states at the waypoints from pressure and lost depth; for all steps also the drive, the volume,
    /// and the balance of work and energy.
    fn check(checking: Checking, comparison: &mut Comparison) -> Result<(), Failure> {
        let Checking { reader, session, .. } = checking;
        let args: Self = checking.problem(|args: &Self| args.around.boundary, comparison)?;
        let coefficient = args.coefficient()?;
        let mut input = super::path_input(&args, session)?;
        input.prepared.take_units(reader);
        let prepared = &input.prepared;
        let waypoints = input.places.count(input.drives.len());
        checking.layout_of_states((prepared, waypoints, Chosen::All), comparison, |file| {
            file.finish(&[], input.drives.len(), None)
        })?;
        let contact = prepared.pose(&args.source, &prepared.law)?;
        let stored = Stored::new(reader, prepared, &contact, args.steps.search.tolerance)?;
        let (mut volume, mut before) = (0.0, [0.0; 4]);
        for (index, drive) in input.drives.iter().enumerate() {
            let number = |name: &str| stored.number(name, index);
            if !stored.compare_step(index, *drive, comparison) {
                continue;
            }
            let [pressure, approach, energy] = ["mean_pressure", "approach", "elastic_energy"].map(number);
            comparison.number("/wear/distance", number("distance"), drive.distance, 0.0);
            let [pressure_before, approach_before, energy_before, distance_before] = before;
            let moved = drive.distance - distance_before;
            volume += coefficient * pressure * moved;
            comparison.number("/wear/wear_volume", number("wear_volume"), volume, 0.0);
            let lost = number("dissipated");
            let work = 0.5 * (pressure + pressure_before) * (approach - approach_before);
            let missing = if moved == 0.0 { 0.0 } else { (work - (energy - energy_before) - lost).abs() };
            let scale = (pressure * approach).abs().max(pressure_before * approach_before).max(energy).max(lost);
            // Without a level, the approach and the energy are unknown.
            if prepared.facts.has_level() {
                comparison.number("/wear/work_imbalance", number("work_imbalance"), missing, scale);
            }
            if moved == 0.0 {
                comparison.number("/wear/dissipated_error", number("dissipated_error"), 0.0, scale);
            }
            before = [pressure, approach, energy, drive.distance];
            let Some(waypoint) = input.places.of(index) else { continue };
            let flow = |state: &AnyState, at: &StateContext| leak(prepared, state, at, |_| {});
            if stored.compare_waypoint((index, waypoint), *drive, flow, comparison)?.is_some() {
                let field = stored.field("pressure", waypoint)?;
                let squares = field.iter().map(|p| p * p).sum::<f64>() / field.len() as f64;
                comparison.number("/wear/dissipated", lost, coefficient * moved * squares, 0.0);
            }
        }
        Ok(())
    }

    fn write(self, out: PathBuf, session: &Session) -> Result<(), Failure> {
        let steps = StepArgs { out: Some(out), ..self.steps };
        super::run(&Self { steps, ..self }, session).map(|_| ())
    }
}
