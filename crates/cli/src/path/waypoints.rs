//! Waypoints of a path, and the steps between them.

use clap::Args as ClapArgs;
use gfmd_contact::Drive;
use gfmd_problem::key;
use serde::{Deserialize, Serialize};

use gfmd_input::failure::Failure;
use gfmd_problem::options::values::{Entry, as_numbers, from_numbers};
use gfmd_run::series::{Places, Prepared};

use super::legs::{counted, legs, lengths, of_leg};
use crate::loads::{LoadArgs, Sign};
use gfmd_problem::options::{Kinds, Options};

/// The flags of the waypoints. A single value holds for all of them; lists of several values have equal lengths.
#[derive(ClapArgs, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Waypoints")]
pub(super) struct WaypointArgs {
    #[command(flatten)]
    #[serde(flatten)]
    loads: LoadArgs,
    /// Lateral displacements of the rigid surface along --direction, length; with friction, or with a law that shears
    #[arg(long, value_delimiter = ',', value_name = "X1,X2,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::LENGTH)]
    lateral: Vec<f64>,
    /// Lateral displacements perpendicular to --direction, length
    #[arg(long, value_delimiter = ',', value_name = "Y1,Y2,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::LENGTH)]
    lateral_y: Vec<f64>,
    /// Sliding distances of the legs, length, for surfaces that wear. Each leg ends at a waypoint; the first begins at
    /// first touch
    #[arg(long, value_delimiter = ',', value_name = "S1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::LENGTH)]
    pub(super) distance: Vec<Entry>,
    /// Durations of the legs on a viscoelastic body. Each leg ends at a waypoint; the first begins at first touch; a
    /// leg of zero duration is a jump
    #[arg(long, value_delimiter = ',', value_name = "T1|A:B:N,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty", serialize_with = "as_numbers", deserialize_with = "from_numbers")]
    #[option(kinds = Kinds::TIME)]
    pub(super) time: Vec<Entry>,
    /// Direction of the lateral displacement, degrees from x
    #[arg(long, default_value_t = 0.0, value_name = "DEG", allow_negative_numbers = true)]
    direction: f64,
}

impl WaypointArgs {
    /// Returns the drive of every step, and the steps that are waypoints.
    ///
    /// # Errors
    /// Returns an error naming a flag that cannot be used.
    pub(super) fn drives(
        &self,
        steps: &[u32],
        prepared: &Prepared,
        sign: Sign,
    ) -> Result<(Vec<Drive>, Places), Failure> {
        let option = self.given();
        self.loads.check(sign)?;
        let (values, load) = (self.loads.values(prepared)?, self.loads.kind());
        let all = self.lateral.iter().map(|value| ("lateral", value)).chain([("direction", &self.direction)]);
        let all = all.chain(self.lateral_y.iter().map(|value| ("lateral_y", value)));
        if let Some((option, bad)) = all.into_iter().find(|(_, value)| !value.is_finite()) {
            return Err(Failure::value(key(option), bad, "finite"));
        }
        let list = |values: &[f64]| if values.is_empty() { vec![0.0] } else { values.to_vec() };
        let [lateral, lateral_y] = [&self.lateral, &self.lateral_y].map(|values| list(values));
        let [times, distances] =
            [("time", &self.time), ("distance", &self.distance)].map(|(option, entries)| lengths(option, entries));
        let [times, distances] = [times?, distances?];
        let has_legs = !(times.is_empty() && distances.is_empty());
        let lists = [
            (option, values.len()),
            ("lateral", lateral.len()),
            ("lateral_y", lateral_y.len()),
            ("time", times.len().max(1)),
            ("distance", distances.len().max(1)),
        ];
        // With times or distances, the first leg ends at the first waypoint.
        let count = counted(&lists, steps, |count| count - usize::from(!has_legs))?;
        let [x, y] = self.along();
        let place = |along: f64, across: f64| [x * along - y * across, y * along + x * across];
        if has_legs {
            let (levels, lengths) = ([&values[..], &lateral, &lateral_y], [&list(&times)[..], &list(&distances)]);
            return Ok(legs(levels, lengths, count, steps, |[value, along, across], [time, distance]| Drive {
                load: load(value),
                lateral: place(along, across),
                time,
                distance,
            }));
        }
        let at = |list: &[f64], leg: usize, share: f64| match list {
            [only] => *only,
            list => list[leg] + share * (list[(leg + 1).min(list.len() - 1)] - list[leg]),
        };
        let drive = |leg: usize, share: f64| {
            let [value, along, across] = [&values, &lateral, &lateral_y].map(|list| at(list, leg, share));
            Drive { load: load(value), lateral: place(along, across), time: 0.0, distance: 0.0 }
        };
        let (mut drives, mut places) = (Vec::new(), Vec::new());
        for leg in 0..count - 1 {
            let steps = of_leg(steps, leg);
            places.push(drives.len());
            drives.extend((0..steps).map(|step| drive(leg, f64::from(step) / f64::from(steps))));
        }
        places.push(drives.len());
        drives.push(drive(count - 1, 0.0));
        Ok((drives, Places::At(places)))
    }

    /// Returns true if the rigid surface is moved sideways.
    pub(super) fn moves_sideways(&self) -> bool {
        !(self.lateral.is_empty() && self.lateral_y.is_empty())
    }

    /// Returns the flag of the loads or approaches.
    pub(super) fn given(&self) -> &'static str {
        self.loads.option()
    }

    /// Returns the unit vector of the lateral displacement.
    pub(super) fn along(&self) -> [f64; 2] {
        let angle = self.direction.to_radians();
        // The default is exactly along x, without the rounding error of a sine.
        if self.direction == 0.0 { [1.0, 0.0] } else { [angle.cos(), angle.sin()] }
    }
}
