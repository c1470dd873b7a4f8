//! Arrays in files.

use gfmd_files::legible::line;
use gfmd_files::{CONSISTENT_UNITS, FileError, Reader, convert_lengths, is_length_unit, npy, split_dataset};
use ndarray::ArrayD;

use gfmd_problem::options::given::ArrayOption;

/// Kind of quantity that an array must hold. An HDF5 dataset may give its unit in the attribute `units` or `unit`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity<'a> {
    /// Lengths, in the unit of the surface if it has one.
    Length(Option<&'a str>),
    /// Stresses, in the unit of the elastic moduli, which has no name.
    Stress,
    /// Numbers without a unit.
    Number,
}

impl Quantity<'_> {
    /// Converts values from the `unit` of a file to the unit of the problem.
    ///
    /// # Errors
    /// Returns an error for a unit of another quantity, for a unit of length if the surface has no known unit, and for
    /// other unknown units.
    fn convert(self, values: &mut [f64], unit: &str) -> Result<(), String> {
        let wrong = |allowed: &str| Err(format!("the unit is {}; it must be {allowed}", line(unit)));
        match self {
            Self::Length(_) if CONSISTENT_UNITS.contains(&unit) => Ok(()),
            Self::Length(Some(of_surface)) => convert_lengths(values, unit, of_surface)
                .or_else(|_| wrong(&format!("a unit of length, since the heights are in {}", line(of_surface)))),
            Self::Length(None) => wrong("length, or left out, as the surface has no unit"),
            Self::Stress if unit == "length" || is_length_unit(unit) => wrong("that of a stress"),
            Self::Stress => Ok(()),
            Self::Number if unit.is_empty() || unit == "1" => Ok(()),
            Self::Number => wrong("1, or left out"),
        }
    }
}

/// Reads the array in FILE.npy or FILE.h5:/dataset, or in memory, in the unit of the problem.
///
/// # Errors
/// Returns an error if the file cannot be read or has no such dataset, or if its unit contradicts the quantity.
pub fn read(given: &ArrayOption, quantity: Quantity) -> Result<ArrayD<f64>, String> {
    let name = match given {
        ArrayOption::File(name) => name,
        ArrayOption::Array(array) => return Ok(ArrayD::clone(array)),
        ArrayOption::Load(_) => return Err("it must be an array".into()),
    };
    let Some((path, dataset)) = split_dataset(name) else { return npy::read(name) };
    let words = |error: FileError| error.to_string();
    let reader = Reader::open(path).map_err(words)?;
    if dataset.is_empty() {
        return Err("it must be FILE.npy or FILE.h5:/dataset".into());
    }
    let shape = reader.shape(dataset).map_err(words)?;
    let mut values = reader.physical(dataset).map_err(words)?;
    let unit = reader.text(dataset, "units").or_else(|_| reader.text(dataset, "unit")).unwrap_or_default();
    quantity.convert(&mut values, unit.trim())?;
    ArrayD::from_shape_vec(shape, values).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_converted_and_contradictions_refused() {
        let convert = |quantity: Quantity, unit: &str| {
            let mut values = [3.0, -0.5];
            quantity.convert(&mut values, unit).map(|()| values)
        };
        let in_micrometres = Quantity::Length(Some("µm"));
        assert_eq!(convert(in_micrometres, "nm"), Ok([3e-3, -0.5e-3]));
        assert_eq!(convert(in_micrometres, "mm"), Ok([3e3, -0.5e3]));
        for unit in ["µm", "um", "length", "1", ""] {
            assert_eq!(convert(in_micrometres, unit), Ok([3.0, -0.5]), "{unit}");
        }
        // An unknown unit must be the unit of the surface, since it cannot be converted.
        assert_eq!(convert(Quantity::Length(Some("sigma")), "sigma"), Ok([3.0, -0.5]));
        for (quantity, unit) in [
            (Quantity::Length(Some("sigma")), "nm"),
            (in_micrometres, "sigma"),
            (in_micrometres, "stress"),
            (in_micrometres, "Pa"),
            (Quantity::Length(None), "nm"),
            (Quantity::Length(None), "stress"),
            (Quantity::Stress, "nm"),
            (Quantity::Stress, "length"),
            (Quantity::Number, "length"),
            (Quantity::Number, "stress"),
            (Quantity::Number, "nm"),
        ] {
            let refused = convert(quantity, unit).unwrap_err();
            assert!(refused.starts_with(&format!("the unit is {unit}; it must be ")), "{refused}");
        }
        for (quantity, unit) in [
            (Quantity::Length(None), "length"),
            (Quantity::Stress, "stress"),
            (Quantity::Stress, "Pa"),
            (Quantity::Stress, ""),
            (Quantity::Number, "1"),
            (Quantity::Number, ""),
        ] {
            assert_eq!(convert(quantity, unit), Ok([3.0, -0.5]), "{unit}");
        }
    }
}
