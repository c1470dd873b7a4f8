//! Grid on which all numbers of a contact have the requested accuracy.

use gfmd_contact::Boundary;
use gfmd_problem::{Accuracy, Words, key, setting, words};
use gfmd_record::{COLUMNS, Cell, FEWEST_WAVES, Record, not_calibrated};
use serde::Serialize;

use crate::series::Prepared;
use gfmd_input::failure::Failure;

/// Returns the least whole number, a power of two or three times one, that is not below `times`.
fn round(times: f64) -> u64 {
    let double = (times.min(1e9).ceil() as u64).next_power_of_two();
    let three = double / 4 * 3;
    if three as f64 >= times { three } else { double }
}

/// Number of a contact that is farthest from an accuracy.
#[derive(Clone, Debug, Serialize)]
pub struct Worst {
    /// Name of the number.
    #[serde(rename = "worst")]
    pub number: &'static str,
    /// Relative error of its limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<f64>,
    /// Reason why the error is unknown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
    /// Refinement factor of each side that the number needs; 1 if it is accurate enough.
    #[serde(skip)]
    pub times: u64,
}

/// Returns the number that needs the most points for an accuracy. Boundary links are ignored, since they count points
/// of one grid. So are numbers without a limit on any grid, which have no value, or are near closing or full contact.
pub fn worst(records: &[Record], accuracy: Accuracy) -> Option<Worst> {
    let names = || {
        let names = COLUMNS.iter().filter_map(|column| Some((column.limit_of()?, column.order)));
        names.filter(|(name, _)| *name != "boundary_links")
    };
    let each = records.iter().flat_map(|record| names().map(move |name| (record, name)));
    let all = each.filter_map(|(record, (number, order))| match record.get(&format!("{number}_limit"))? {
        Cell::Undefined(reason) if reason.contains("boundary links") => {
            Some(Worst { number, error: None, reason: Some(reason.to_string()), times: 2 })
        }
        Cell::Undefined(_) => None,
        limit => {
            let error = record.number(&format!("{number}_limit_error")) / limit.number().abs();
            let over = error / accuracy.relative();
            let times = if over <= 1.0 { 1 } else { round(over.powf(1.0 / order.unwrap_or(1.0))).max(2) };
            Some(Worst { number, error: Some(error), reason: None, times })
        }
    });
    let key = |worst: &Worst| (worst.times, worst.error.unwrap_or(f64::INFINITY));
    all.max_by(|a, b| key(a).0.cmp(&key(b).0).then(key(a).1.total_cmp(&key(b).1)))
}

/// Checks that an accuracy can be requested: the grid errors are known, and a finer grid reduces them.
///
/// # Errors
/// Returns an error if one solution does not give the grid error, or if the surface is unknown between its points.
pub fn check(accuracy: Accuracy, prepared: &Prepared, approach: bool) -> Result<(), Failure> {
    let refuse = |reason: Words| Failure::value(key("accuracy"), accuracy.relative(), words!["left out: ", reason]);
    if let Some(reason) = not_calibrated(&prepared.facts) {
        return Err(refuse(reason.into()));
    }
    if prepared.facts.boundary == Boundary::Free {
        return Err(refuse("the rim of a patch moves with the grid".into()));
    }
    if approach {
        let why = "the approach counts from the highest point, which depends on the grid (give ";
        return Err(refuse(words![why, key("p_star"), " or ", key("pressure"), ")"]));
    }
    if prepared.waves().is_nan() || prepared.waves() < FEWEST_WAVES {
        return Err(refuse(
            format!(
                "the surface has {:.1} waves, and the grid error is known of random ones with at least \
             {FEWEST_WAVES}",
                prepared.waves()
            )
            .into(),
        ));
    }
    if prepared.short_waves() > gfmd_record::UNRESOLVED {
        let found = format!(
            "waves shorter than four points have {:.0} % of the mean square gradient, and the heights between the \
             points are unknown; ",
            100.0 * prepared.short_waves()
        );
        return Err(refuse(words![found, setting("grid_error", "refine"), " tells what it may be"]));
    }
    Ok(())
}

/// Boundary links per point in contact above which contacts are less than two points wide.
const NARROW: f64 = 1.5;

/// Returns the remark on a load with too coarse a grid, and its area error if known; `None` if the grid is fine enough.
pub fn too_coarse(record: &Record) -> Option<Words> {
    let narrow = record.number("boundary_links") / record.number("contact_nodes");
    let width = 100.0 * record.number("area_fraction_grid_error") / record.number("area_fraction");
    (narrow > NARROW && record.has("area_fraction_limit")).then(|| {
        let error = if width.is_nan() { String::new() } else { format!("; the area is {width:.0} % off") };
        let found = format!("contacts are {:.1} points wide{error}: a finer grid, or ", 2.0 / narrow);
        words![found, key("accuracy"), ", resolves them"]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_small_factors() {
        assert_eq!([1.1, 2.0, 2.5, 3.1, 5.0, 6.5, 13.0].map(round), [2, 2, 3, 4, 6, 8, 16]);
    }
}
