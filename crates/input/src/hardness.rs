//! Hardness, from a flag: a number, or a field in a file.

use std::fmt;
use std::str::FromStr;

use clap::Args;
use gfmd_contact::Hardness;
use gfmd_field::{Grid, Share};
use gfmd_files::{Archive, Dimension, Reader, Variable, contiguous};
use gfmd_problem::key;
use gfmd_unit::Units;
use ndarray::{Array2, Ix2};
use serde::{Deserialize, Serialize};

use crate::array::{self, Quantity};
use crate::failure::Failure;
use crate::rows;
use gfmd_problem::options::given::ArrayOption;
use gfmd_problem::options::{Kinds, Options};

/// Option of the hardness of a contact.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
pub struct HardnessArgs {
    /// Hardness: largest pressure that the surfaces carry, stress, or FILE.npy or FILE.h5:/dataset with a value for
    /// each point; where it is reached the surfaces indent each other, permanently along a path
    #[arg(long, value_name = "P|FILE", allow_negative_numbers = true, help_heading = "Contact")]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::HARDNESS, array)]
    pub hardness: Option<GivenHardness>,
}

/// Hardness as given by its flag.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum GivenHardness {
    /// Stress.
    Number(f64),
    /// Hardness of each point.
    Field(ArrayOption),
}

impl From<ArrayOption> for GivenHardness {
    fn from(array: ArrayOption) -> Self {
        Self::Field(array)
    }
}

impl FromStr for GivenHardness {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(text.parse().map_or_else(|_| Self::Field(ArrayOption::File(text.into())), Self::Number))
    }
}

impl fmt::Display for GivenHardness {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number(hardness) => write!(f, "{hardness:.6e}"),
            Self::Field(given) => given.fmt(f),
        }
    }
}

const OPTION: &str = "hardness";

/// Dataset of the field in a result.
const STORED: &str = "/surface/hardness";

impl GivenHardness {
    /// Reads the hardness on the grid of the surface.
    ///
    /// # Errors
    /// Returns an error if a value is not positive and finite, or a file is unreadable, of another shape or in length.
    pub fn read(&self, grid: &Grid) -> Result<Hardness, Failure> {
        let name = match self {
            Self::Number(hardness) if hardness.is_finite() && *hardness > 0.0 => return Ok((*hardness).into()),
            Self::Number(hardness) => return Err(Failure::value(key(OPTION), hardness, "positive and finite")),
            Self::Field(given) => given,
        };
        let refuse = |reason: String| Failure::input(key(OPTION), format!("{name}: {reason}"));
        let found = array::read(name, Quantity::Stress).map_err(refuse)?;
        let points = grid.points();
        let (shape, line) = (found.shape().to_vec(), grid.is_line());
        if shape != points && !(line && shape == [points[0]]) {
            let allowed = if line { format!("[{}]", points[0]) } else { format!("{points:?}") };
            return Err(refuse(format!("the shape is {shape:?}; it must be {allowed}, the shape of the surface")));
        }
        if let Some(bad) = found.iter().find(|value| !(value.is_finite() && **value > 0.0)) {
            return Err(refuse(format!("a value is {bad}; all values must be positive and finite")));
        }
        let field = found.into_shape_with_order(points).map_err(|error| refuse(error.to_string()))?;
        let field = field.into_dimensionality::<Ix2>().map_err(|error| refuse(error.to_string()))?;
        Ok(field.into())
    }
}

/// Distributes the rows of the hardness of the first process; for a field the other processes give `None`.
pub fn handed_out(hardness: Option<Hardness>, grid: &Grid, share: &Share) -> Hardness {
    match share.first(
        hardness.as_ref().map(|hardness| if let Hardness::Uniform(value) = hardness { *value } else { f64::NAN }),
    ) {
        Some(uniform) if !uniform.is_nan() => uniform.into(),
        _ => {
            let whole = if let Some(Hardness::Field(field)) = &hardness { Some(field) } else { None };
            rows::handed_out(share, whole, grid.points()[1]).into()
        }
    }
}

/// Returns the words that identify a hardness field among the input of a run; empty for other hardnesses. With several
/// processes, only the first one gets them.
pub fn identity(hardness: Option<&Hardness>, share: &Share) -> String {
    match hardness {
        Some(Hardness::Field(field)) => format!("\nhardness {}", rows::checksum(share, &contiguous(field))),
        _ => String::new(),
    }
}

/// Writes a hardness field, with its rows on each process, beside the surface of a file.
///
/// # Errors
/// Returns an error if the file cannot be written.
pub fn write(
    hardness: Option<&Hardness>,
    archive: Option<&mut Archive>,
    share: &Share,
    axes: [&Dimension; 2],
    units: &Units,
) -> Result<(), Failure> {
    let Some(Hardness::Field(field)) = hardness else { return Ok(()) };
    let variable = Variable {
        dimensions: &axes,
        units: &units.name("stress"),
        long_name: "hardness: largest pressure that the surfaces carry",
    };
    rows::write_all(share, field.view(), archive, STORED, &variable)
}

/// Returns the hardness of a result on `grid`, from its configuration or its field; `None` if it has none, or one of
/// another shape.
pub fn of_result(reader: &Reader, config: &toml::Table, grid: &Grid) -> Option<Hardness> {
    match config.get("hardness")? {
        toml::Value::String(_) => {
            let values: Vec<f64> = reader.values(STORED).ok()?;
            Array2::from_shape_vec(grid.points(), values).ok().map(Into::into)
        }
        number => number.as_float().map(Into::into),
    }
}

/// Returns the key of the hardness field in a file, and the name to read it from there.
pub fn stored_hardness(reader: &Reader) -> Option<(&'static str, String)> {
    reader.contains(STORED).then(|| ("hardness", format!("{}:{STORED}", reader.path().display())))
}
