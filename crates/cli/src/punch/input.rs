//! The points under a punch, the traction beside it and its lateral displacement.

use gfmd_field::Grid;
use gfmd_response::Components;
use ndarray::{Array2, Array3, ArrayD};

use super::{Args, ContactName};
use gfmd_input::array::{self, Quantity};
use gfmd_input::failure::Failure;
use gfmd_problem::options::given::ArrayOption;
use gfmd_problem::{SIZES, key, setting, words};

fn read(option: &str, name: &ArrayOption, quantity: Quantity) -> Result<ArrayD<f64>, Failure> {
    let found =
        array::read(name, quantity).map_err(|reason| Failure::input(key(option), format!("{name}: {reason}")))?;
    match found.iter().find(|value| !value.is_finite()) {
        Some(value) => {
            Err(Failure::input(key(option), format!("{name}: a value is {value}; all values must be finite")))
        }
        None => Ok(found),
    }
}

/// Reads the points under the punch.
pub(super) fn mask(name: &ArrayOption, dim: u8) -> Result<Array2<bool>, Failure> {
    let found = read("mask", name, Quantity::Number)?;
    let shape = match (dim, found.shape()) {
        (2, &[n] | &[n, 1]) => Ok((n, 1)),
        (3, &[n, m]) if n == m => Ok((n, n)),
        (dim, shape) => {
            let allowed = if dim == 2 { "[n], for a line" } else { "[n, n]" };
            Err(Failure::input(key("mask"), format!("{name}: the shape is {shape:?}; it must be {allowed}")))
        }
    }?;
    let under: Vec<bool> = found.iter().map(|value| *value != 0.0).collect();
    if !under.contains(&true) {
        return Err(Failure::input(key("mask"), format!("{name}: no point is under the punch; at least one must be")));
    }
    Array2::from_shape_vec(shape, under).map_err(|error| Failure::input(key("mask"), error))
}

/// Returns the number of points along an axis; a given number must agree with the mask.
pub(super) fn points(given: Option<usize>, mask: Option<&Array2<bool>>) -> Result<usize, Failure> {
    match (given, mask.map(Array2::nrows)) {
        (Some(given), Some(n)) if given != n => {
            Err(Failure::value(key("n"), given, words![format!("{n}, as "), key("mask"), " has"]))
        }
        (given, of_mask) => Ok(of_mask.or(given).unwrap_or(DEFAULT)),
    }
}

/// Points along an axis, if nothing is said.
const DEFAULT: usize = 128;

/// Reads the traction where the punch does not hold, as `[component, x, y]`.
pub(super) fn traction(name: &ArrayOption, grid: &Grid) -> Result<Array3<f64>, Failure> {
    let found = read("traction", name, Quantity::Stress)?;
    let [nx, ny] = grid.points();
    let components = Components::of(grid).len();
    let fits = found.shape() == [nx, ny, components] || (ny == 1 && found.shape() == [nx, components]);
    if !fits {
        let allowed = if ny == 1 { format!("[{nx}, 2]") } else { format!("[{nx}, {ny}, 3]") };
        let found = found.shape();
        return Err(Failure::input(key("traction"), format!("{name}: the shape is {found:?}; it must be {allowed}")));
    }
    let points = Array3::from_shape_vec((nx, ny, components), found.into_iter().collect());
    let points = points.map_err(|error| Failure::input(key("traction"), error))?;
    Ok(points.permuted_axes([2, 0, 1]).as_standard_layout().into_owned())
}

/// Checks the lateral displacement.
pub(super) fn check_shift(args: &Args) -> Result<(), Failure> {
    let Some(first) = args.shift.first() else { return Ok(()) };
    if args.contact == ContactName::Frictionless {
        let frictionless = setting("contact", "frictionless");
        let allowed = words!["left out with ", frictionless, ", which leaves the lateral displacement free"];
        return Err(Failure::value(key("shift"), first, allowed));
    }
    if args.dim == 2 && args.shift.len() == 2 {
        return Err(Failure::value(
            key("shift"),
            format!("{:?}", args.shift),
            words!["X alone with ", setting("dim", 2)],
        ));
    }
    match args.shift.iter().find(|shift| !(0.0..=*SIZES.end()).contains(&shift.abs())) {
        Some(shift) => {
            Err(Failure::value(key("shift"), format!("{shift:e}"), format!("from -{0:e} to {0:e}", SIZES.end())))
        }
        None => Ok(()),
    }
}
