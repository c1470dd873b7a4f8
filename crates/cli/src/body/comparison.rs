//! Comparison of the values on a section with those in a file.

use gfmd_field::Grid;
use gfmd_files::{Reader, npy};
use gfmd_problem::key;
use serde::Serialize;

use super::component::Component;
use super::pictures::{Compared, Pictures};
use super::quantity::Quantity;
use super::volume::archive_components;
use gfmd_input::failure::Failure;

/// Differences from another solution.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Comparison {
    pub reference: String,
    /// Points along the two axes of the section that both solutions have.
    pub compared_points: [usize; 2],
    pub components: Vec<Difference>,
}

/// Difference of one component.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Difference {
    pub name: &'static str,
    pub rms_difference: f64,
    pub largest_difference: f64,
    /// Largest absolute value of the reference.
    pub largest_reference: f64,
}

/// Values of one quantity in a file, level by level from above, point by point.
struct Stored {
    quantity: Quantity,
    /// Component indices in file order.
    components: Vec<usize>,
    levels: usize,
    /// Points of a row, or points along x and y of a level.
    points: Vec<usize>,
    /// Depths of the levels, if the file has them.
    depths: Option<Vec<f64>>,
    values: Vec<f64>,
}

/// Compares all components of `pictures` at `depths` that the file has.
pub(super) fn compare(
    name: &str,
    pictures: &Pictures,
    grid: &Grid,
    depths: &[f64],
) -> Result<(Comparison, Vec<Compared>), Failure> {
    let refuse = |reason: String| Failure::input(key("compare"), format!("{name}: {reason}"));
    let wanted: Vec<Component> = pictures.values().map(|(component, _)| component).collect();
    let stored = if name.to_ascii_lowercase().ends_with(".npy") {
        array(name, pictures, grid)
    } else {
        archive(name, &wanted, pictures, grid, depths)
    };
    let stored = stored.map_err(refuse)?;
    let mut compared = Vec::new();
    for (component, ours) in pictures.values() {
        let held = stored.iter().find_map(|stored| {
            let place = stored.components.iter().position(|index| *index == component.index)?;
            (stored.quantity == component.quantity).then_some((stored, place))
        });
        let Some((stored, place)) = held else { continue };
        compared.push(one(component, ours, stored, place, pictures, grid, depths).map_err(refuse)?);
    }
    let Some(first) = compared.first() else {
        let names: Vec<&str> = wanted.iter().map(|component| component.name).collect();
        return Err(refuse(format!("it has none of {}, which are drawn", names.join(", "))));
    };
    let comparison = Comparison {
        reference: name.into(),
        compared_points: first.common,
        components: compared.iter().map(Difference::of).collect(),
    };
    Ok((comparison, compared))
}

fn one(
    component: Component,
    ours: &[f64],
    stored: &Stored,
    place: usize,
    pictures: &Pictures,
    grid: &Grid,
    depths: &[f64],
) -> Result<Compared, String> {
    let count = stored.components.len();
    let is_level = pictures.rows.is_level();
    let at = |level: usize, point: usize| {
        let points: usize = stored.points.iter().product();
        stored.values[(level * points + point) * count + place]
    };
    let (shape, reference) = if is_level {
        let shape = [stored.points[0], stored.points.get(1).copied().unwrap_or(1)];
        (shape, (0..shape[0] * shape[1]).map(|point| at(0, point)).collect::<Vec<_>>())
    } else {
        let (points, levels) = (stored.points[0], stored.levels);
        let upwards = (0..points).flat_map(|point| (0..levels).rev().map(move |level| (level, point)));
        ([points, levels], upwards.map(|(level, point)| at(level, point)).collect())
    };
    if let Some(value) = reference.iter().find(|value| !value.is_finite()) {
        return Err(format!("a value is {value}; all values must be finite"));
    }
    let full = pictures.shape(grid);
    // Points are periodic; levels include both ends.
    let intervals = |axis: usize, count: usize| if axis == 1 && !is_level { count.saturating_sub(1) } else { count };
    let mut steps = [[1; 2]; 2];
    for axis in 0..2 {
        let [ours, theirs] = [full, shape].map(|shape| intervals(axis, shape[axis]));
        if theirs == 0 || !(ours.is_multiple_of(theirs) || theirs.is_multiple_of(ours)) {
            let what = if axis == 1 && !is_level { "intervals between levels" } else { "points" };
            return Err(format!("it has {theirs} {what}; it must have a divisor or a multiple of {ours}"));
        }
        steps[axis] = [ours.div_ceil(theirs).max(1), theirs.div_ceil(ours).max(1)];
    }
    let common = [0, 1].map(|axis| full[axis].div_ceil(steps[axis][0]));
    if let (false, Some(found)) = (is_level, &stored.depths) {
        for level in 0..common[1] {
            let [ours, theirs] = [depths[level * steps[1][0]], found[level * steps[1][1]]];
            if !is_near(ours, theirs, depths) {
                return Err(format!("it has a level at depth {theirs}; it must be at {ours}, as of this run"));
            }
        }
    }
    let entry = |values: &[f64], shape: [usize; 2], which: usize, [i, k]: [usize; 2]| {
        values[i * steps[0][which] * shape[1] + k * steps[1][which]]
    };
    let points = (0..common[0]).flat_map(|i| (0..common[1]).map(move |k| [i, k]));
    let difference = points.map(|at| entry(ours, full, 0, at) - entry(&reference, shape, 1, at)).collect();
    Ok(Compared { component, shape, reference, common, difference })
}

/// Returns true if two depths are equal up to rounding.
fn is_near(a: f64, b: f64, depths: &[f64]) -> bool {
    (a - b).abs() <= 1e-9 * depths.iter().copied().fold(0.0, f64::max)
}

impl Difference {
    fn of(compared: &Compared) -> Self {
        let largest = |values: &[f64]| values.iter().fold(0.0, |largest: f64, value| largest.max(value.abs()));
        let squares: f64 = compared.difference.iter().map(|difference| difference * difference).sum();
        Self {
            name: compared.component.name,
            rms_difference: (squares / compared.difference.len() as f64).sqrt(),
            largest_difference: largest(&compared.difference),
            largest_reference: largest(&compared.reference),
        }
    }
}

/// Reads the file of another run of this command.
fn archive(
    name: &str,
    wanted: &[Component],
    pictures: &Pictures,
    grid: &Grid,
    depths: &[f64],
) -> Result<Vec<Stored>, String> {
    let words = |error: gfmd_files::FileError| error.to_string();
    let reader = Reader::open(name).map_err(words)?;
    if !reader.contains("/fields/depth") {
        return Err("it is no result of body; it must be one, or FILE.npy".into());
    }
    let slice = reader.text("/fields", "slice").ok();
    let asked = pictures.rows.selected().map(|slice| slice.to_string()).filter(|_| !grid.is_line());
    if slice != asked {
        let word = |slice: Option<String>| slice.map_or("all points".into(), |slice| format!("the slice {slice}"));
        return Err(format!("it has {}; it must have {}", word(slice), word(asked)));
    }
    let found: Vec<f64> = reader.values("/fields/depth").map_err(words)?;
    // Keep the upper side of a plane between two layers; it comes first.
    let mut kept: Vec<usize> =
        (0..found.len()).filter(|&level| depths.iter().any(|depth| is_near(*depth, found[level], depths))).collect();
    kept.dedup_by(|a, b| found[*a] == found[*b]);
    if kept.is_empty() {
        return Err(format!("its depths are {found:?}; it must have the depths of this run"));
    }
    let levels: Vec<f64> = kept.iter().map(|level| found[*level]).collect();
    let mut all = Vec::new();
    for quantity in Quantity::ALL {
        let path = format!("/fields/{}", quantity.name());
        if !(wanted.iter().any(|component| component.quantity == quantity) && reader.contains(&path)) {
            continue;
        }
        let shape = reader.shape(&path).map_err(words)?;
        let all_values: Vec<f64> = reader.values(&path).map_err(words)?;
        let plane = all_values.len() / found.len();
        let values = kept.iter().flat_map(|level| all_values[level * plane..][..plane].iter().copied()).collect();
        let components = archive_components(quantity, grid.is_line()).to_vec();
        let last = if quantity.is_scalar() { shape.len() } else { shape.len() - 1 };
        let points = shape.get(1..last).unwrap_or_default().to_vec();
        let depths = Some(levels.clone());
        all.push(Stored { quantity, components, levels: levels.len(), points, depths, values });
    }
    Ok(all)
}

/// Reads `[level, point, component]`, or `[x, y, component]` of a level.
fn array(name: &str, pictures: &Pictures, grid: &Grid) -> Result<Vec<Stored>, String> {
    let found = npy::read(name)?;
    let vector = archive_components(Quantity::Displacement, grid.is_line());
    let tensor = archive_components(Quantity::Stress, grid.is_line());
    let (u, s) = (vector.len(), tensor.len());
    let shape = found.shape().to_vec();
    let is_level = pictures.rows.is_level();
    let split = match shape[..] {
        [n, c] if is_level && grid.is_line() => Some((1, vec![n], c)),
        [nx, ny, c] if is_level && !grid.is_line() => Some((1, vec![nx, ny], c)),
        [levels, n, c] if !is_level => Some((levels, vec![n], c)),
        _ => None,
    };
    let parts: Option<&[(Quantity, usize)]> = split.as_ref().and_then(|(_, _, components)| match *components {
        c if c == u => Some(&[(Quantity::Displacement, 0)][..]),
        c if c == s => Some(&[(Quantity::Stress, 0)][..]),
        c if c == u + s => Some(if u == 2 {
            &[(Quantity::Displacement, 0), (Quantity::Stress, 2)][..]
        } else {
            &[(Quantity::Displacement, 0), (Quantity::Stress, 3)][..]
        }),
        _ => None,
    });
    let (Some((levels, points, count)), Some(parts)) = (split, parts) else {
        let places = match (is_level, grid.is_line()) {
            (false, _) => "levels, points",
            (true, false) => "nx, ny",
            (true, true) => "n",
        };
        return Err(format!(
            "the shape is {shape:?}; it must be [{places}, c] with c = {u} (displacement), {s} (stress) or {} (both)",
            u + s
        ));
    };
    let values: Vec<f64> = found.into_iter().collect();
    let part = |&(quantity, first): &(Quantity, usize)| {
        let components = if quantity == Quantity::Displacement { vector } else { tensor };
        let values = values.chunks_exact(count).flat_map(|all| all[first..first + components.len()].iter().copied());
        let (values, points) = (values.collect(), points.clone());
        Stored { quantity, components: components.to_vec(), levels, points, depths: None, values }
    };
    Ok(parts.iter().map(part).collect())
}
