//! Loads or approaches at the waypoints of a path, and the steps of the legs between them.

use gfmd_contact::Drive;
use gfmd_input::failure::Failure;
use gfmd_input::memory;
use gfmd_problem::options::values::{Entry, numbers};
use gfmd_problem::{key, words};
use gfmd_run::series::Places;

/// Largest number of steps of a path.
const MOST_STEPS: u64 = 1_000_000;

/// Bytes of a step: drive, record and text.
const STEP_BYTES: u64 = 4096;

/// Returns the lengths of legs, in time or in distance, given by the `option`.
///
/// # Errors
/// Returns an error if a length is negative or not finite.
pub(super) fn lengths(option: &str, entries: &[Entry]) -> Result<Vec<f64>, Failure> {
    let lengths: Vec<f64> = numbers(entries).collect();
    match lengths.iter().find(|length| !(length.is_finite() && **length >= 0.0)) {
        Some(bad) => Err(Failure::value(key(option), bad, "finite and not negative")),
        None => Ok(lengths),
    }
}

/// Returns the value of a leg in a list, whose single value holds for all legs.
pub(super) fn of_leg<T: Copy>(list: &[T], leg: usize) -> T {
    list[leg.min(list.len() - 1)]
}

/// Returns the number of waypoints of `lists` (key, length). `legs` gives the number of legs, with the `steps` of each,
/// for a number of waypoints.
///
/// # Errors
/// Returns an error if a list has another length, or if there are too many steps.
pub(super) fn counted(lists: &[(&str, usize)], steps: &[u32], legs: impl Fn(usize) -> usize) -> Result<usize, Failure> {
    let count = lists.iter().map(|(_, length)| *length).max().unwrap_or(0);
    if let Some((option, length)) = lists.iter().find(|(_, length)| *length != 1 && *length != count) {
        return Err(Failure::refused(words![
            key(option),
            format!(" has {length} waypoints; it must have 1 or {count}"),
        ]));
    }
    let legs = legs(count);
    if steps.len() != 1 && steps.len() != legs {
        let allowed = if legs > 1 { format!("1 or {legs}, one for each leg") } else { "1".into() };
        let found = format!(" has {} numbers; it must have {allowed}", steps.len());
        return Err(Failure::refused(words![key("steps"), found]));
    }
    let made: u64 = (0..legs).map(|leg| u64::from(of_leg(steps, leg))).sum();
    if made > MOST_STEPS {
        let steps: Vec<String> = steps.iter().map(ToString::to_string).collect();
        let found = format!("{}, in all {made} for {count} waypoints", steps.join(","));
        return Err(Failure::value(key("steps"), found, format!("at most {MOST_STEPS} in all")));
    }
    memory::check_count(key("steps"), "steps", made + 1, STEP_BYTES)?;
    Ok(count)
}

/// Returns the steps of `count` legs, starting from zero. A leg ends at its `levels`, after its `lengths`; a list of
/// one value holds for all legs, as does one number of `steps`. A leg of zero lengths is one step. `drive` maps the
/// levels and the lengths so far to a drive.
pub(super) fn legs<const L: usize, const M: usize>(
    levels: [&[f64]; L],
    lengths: [&[f64]; M],
    count: usize,
    steps: &[u32],
    drive: impl Fn([f64; L], [f64; M]) -> Drive,
) -> (Vec<Drive>, Places) {
    let (mut drives, mut ends) = (Vec::new(), Vec::new());
    let (mut before, mut start) = ([0.0; L], [0.0; M]);
    for leg in 0..count {
        let of = |list: &[f64]| of_leg(list, leg);
        let (level, length) = (levels.map(of), lengths.map(of));
        let end: [f64; M] = std::array::from_fn(|m| start[m] + length[m]);
        let count = if length.iter().all(|length| *length == 0.0) { 1 } else { of_leg(steps, leg) };
        for step in 1..=count {
            let share = f64::from(step) / f64::from(count);
            let at = |from: f64, to: f64| if step == count { to } else { from + share * (to - from) };
            drives.push(drive(
                std::array::from_fn(|l| at(before[l], level[l])),
                std::array::from_fn(|m| at(start[m], end[m])),
            ));
        }
        ends.push(drives.len() - 1);
        (before, start) = (level, end);
    }
    (drives, Places::At(ends))
}
