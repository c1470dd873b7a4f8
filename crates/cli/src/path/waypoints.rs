//! The waypoints of a path, and the steps between them.

use clap::Args as ClapArgs;
use gfmd_contact::{Drive, Load};
use serde::{Deserialize, Serialize};

use gfmd_problem::options::flags::without_flags;
use gfmd_problem::options::values::{Entry, as_numbers, from_numbers, numbers};
use gfmd_run::failure::Failure;
use gfmd_run::memory;
use gfmd_run::series::Places;

/// The largest number of steps of a path.
const MOST_STEPS: u64 = 1_000_000;

/// The bytes of a step: its drive, its record, and its text.
const STEP_BYTES: u64 = 4096;

/// The flags of the waypoints. A single value holds for all of them; lists of several values have equal lengths.
#[derive(ClapArgs, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Waypoints")]
pub(super) struct WaypointArgs {
    /// Mean pressures, stress; a negative one pulls; A:B:N is N values from A to B in geometric steps
    #[arg(long, value_delimiter = ',', value_name = "P1|A:B:N,..", group = "drive", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    pressure: Vec<Entry>,
    /// Reduced pressures p/(E* g); a negative one pulls
    #[arg(long, value_delimiter = ',', value_name = "P1|A:B:N,..", group = "drive", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    p_star: Vec<Entry>,
    /// Rigid approaches beyond first touch, length; a negative one is a separation
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "D1|A:B:N,..",
        group = "drive",
        required_unless_present_any = ["pressure", "p_star"],
        allow_negative_numbers = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    displacement: Vec<Entry>,
    /// Lateral displacements of the rigid surface, length; with them all components of the surface move
    #[arg(long, value_delimiter = ',', value_name = "X1,X2,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(super) lateral: Vec<f64>,
    /// Times of the legs, each of which ends at a waypoint, of a viscoelastic body: the first one begins at first
    /// touch; a leg of no time is a jump
    #[arg(long, value_delimiter = ',', value_name = "T1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    pub(super) time: Vec<Entry>,
    /// Direction of the lateral displacement, degrees from x
    #[arg(long, default_value_t = 0.0, value_name = "DEG", allow_negative_numbers = true)]
    direction: f64,
}

impl Default for WaypointArgs {
    fn default() -> Self {
        without_flags()
    }
}

impl WaypointArgs {
    /// The drive of every step, and the steps that are waypoints.
    ///
    /// # Errors
    /// The flag that cannot be used.
    pub(super) fn drives(&self, steps: u32, unit_pressure: f64, hard: bool) -> Result<(Vec<Drive>, Places), Failure> {
        let flag = self.flag();
        let given = [&self.pressure, &self.p_star, &self.displacement];
        if given.into_iter().filter(|values| !values.is_empty()).count() > 1 {
            return Err(Failure::Input(format!(
                "{flag} is given beside another of --pressure, --p-star, --displacement"
            )));
        }
        let (values, under_load): (Vec<f64>, bool) = match flag {
            "--pressure" => (numbers(&self.pressure).collect(), true),
            "--p-star" => (numbers(&self.p_star).map(|p| p * unit_pressure).collect(), true),
            _ => (numbers(&self.displacement).collect(), false),
        };
        let allowed = if hard { "positive and finite" } else { "finite" };
        if let Some(bad) = values.iter().find(|value| !(value.is_finite() && (!hard || **value > 0.0))) {
            return Err(Failure::value(flag, bad, allowed));
        }
        let all = self.lateral.iter().map(|value| ("--lateral", value)).chain([("--direction", &self.direction)]);
        if let Some((flag, bad)) = all.into_iter().find(|(_, value)| !value.is_finite()) {
            return Err(Failure::value(flag, bad, "finite"));
        }
        let lateral = if self.lateral.is_empty() { vec![0.0] } else { self.lateral.clone() };
        let times: Vec<f64> = numbers(&self.time).collect();
        if let Some(bad) = times.iter().find(|time| !(time.is_finite() && **time >= 0.0)) {
            return Err(Failure::value("--time", bad, "finite and not negative"));
        }
        let count = values.len().max(lateral.len()).max(times.len());
        for (flag, length) in [(flag, values.len()), ("--lateral", lateral.len()), ("--time", times.len().max(1))] {
            if length != 1 && length != count {
                return Err(Failure::Input(format!("{flag} has {length} waypoints; it must have 1 or {count}")));
            }
        }
        // The first of the legs that have a time ends at the first waypoint.
        let made = (count as u64 - u64::from(times.is_empty())).saturating_mul(u64::from(steps));
        if made > MOST_STEPS {
            let found = format!("{steps}, in all {made} for {count} waypoints");
            return Err(Failure::value("--steps", found, format!("at most {MOST_STEPS} in all")));
        }
        memory::check_count("--steps", "steps", made + 1, STEP_BYTES)?;
        if !times.is_empty() {
            let times: Vec<f64> = (0..count).map(|leg| times[leg.min(times.len() - 1)]).collect();
            return Ok(in_time(&values, &times, steps, if under_load { Load::MeanPressure } else { Load::Approach }));
        }
        let along = self.along();
        let at = |list: &[f64], leg: usize, share: f64| match list {
            [only] => *only,
            list => list[leg] + share * (list[(leg + 1).min(list.len() - 1)] - list[leg]),
        };
        let drive = |leg: usize, share: f64| {
            let (value, sideways) = (at(&values, leg, share), at(&lateral, leg, share));
            let load = if under_load { Load::MeanPressure(value) } else { Load::Approach(value) };
            Drive { load, lateral: along.map(|c| c * sideways), time: 0.0, distance: 0.0 }
        };
        let inside = (0..count - 1).flat_map(|leg| (0..steps).map(move |i| (leg, f64::from(i) / f64::from(steps))));
        let drives = inside.map(|(leg, share)| drive(leg, share)).chain([drive(count - 1, 0.0)]).collect();
        Ok((drives, Places::Every(steps as usize)))
    }

    /// The flag of the loads or approaches.
    pub(super) fn flag(&self) -> &'static str {
        match (self.pressure.is_empty(), self.p_star.is_empty()) {
            (false, _) => "--pressure",
            (_, false) => "--p-star",
            _ => "--displacement",
        }
    }

    /// The unit vector of the lateral displacement.
    pub(super) fn along(&self) -> [f64; 2] {
        let angle = self.direction.to_radians();
        // The default is exactly along x, without the rounding error of a sine.
        if self.direction == 0.0 { [1.0, 0.0] } else { [angle.cos(), angle.sin()] }
    }
}

/// The steps of legs of these `times`, each of which ends at its value, or at the only one: the first begins with
/// nothing at time 0.
fn in_time(values: &[f64], times: &[f64], steps: u32, load: fn(f64) -> Load) -> (Vec<Drive>, Places) {
    let (mut drives, mut ends) = (Vec::new(), Vec::new());
    let (mut before, mut start) = (0.0, 0.0);
    for (leg, time) in times.iter().enumerate() {
        let (value, end) = (values[leg.min(values.len() - 1)], start + time);
        let count = if *time == 0.0 { 1 } else { steps };
        for step in 1..=count {
            let share = f64::from(step) / f64::from(count);
            let at = |from: f64, to: f64| if step == count { to } else { from + share * (to - from) };
            drives.push(Drive::from(load(at(before, value))).at(at(start, end)));
        }
        ends.push(drives.len() - 1);
        (before, start) = (value, end);
    }
    (drives, Places::At(ends))
}
