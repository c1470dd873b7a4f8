//! The yield stress and the hardening of a body, from flags.

use std::fmt;
use std::str::FromStr;

use clap::Args;
use gfmd_field::Grid;
use gfmd_green::{BaseKind, Body};
use gfmd_plasticity::{Cell, Cells, Hardening, PlasticityError};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::body::BodyArgs;
use super::law::LONGEST_TABLE;
use super::values::parse_row;
use crate::options::{Kinds, Options, named, parse_choice};
use crate::{KeptStrain, Unusable, key, words};

/// Flags of the yielding of the body.
#[derive(Args, Options, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Yielding body")]
pub struct PlasticityArgs {
    /// Yield stress (von Mises) of a body that yields below its surface, stress; with several layers, of the top one
    #[arg(long, visible_alias = "yield", value_name = "Y", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::STRESS)]
    pub yield_stress: Option<f64>,
    /// Isotropic hardening H, stress: slope of the yield stress against the equivalent plastic strain. With kinematic
    /// hardening C, the tangent modulus of a bar is E (H + C)/(E + H + C)
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::STRESS)]
    pub hardening: Option<f64>,
    /// Hardening curve, in place of --hardening: FILE with the columns equivalent plastic strain, from 0, and true
    /// yield stress, or rows STRAIN:STRESS,...; the stress is constant beyond the last row
    #[arg(
        long,
        value_parser = parse_row,
        value_delimiter = ',',
        value_name = "FILE|ROWS",
        allow_hyphen_values = true,
        conflicts_with = "hardening"
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::HARDENING_CURVE)]
    pub hardening_curve: Vec<[f64; 2]>,
    /// Kinematic hardening C, stress: back stress of a bar divided by its plastic strain
    #[arg(long, visible_alias = "kinematic", value_name = "C", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::STRESS)]
    pub kinematic_hardening: Option<f64>,
    /// Yield stress of each layer below the top one, stress, 0 for an elastic layer; they harden like the top layer
    /// [default: all are elastic]
    #[arg(long, value_delimiter = ',', value_name = "Y,..", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::STRESS)]
    pub layer_yield: Vec<f64>,
    /// Cells below the surface, in which the plastic strain is constant in depth: graded:THICKNESS,GROWTH,COARSEN
    /// (first thickness in grid steps, ratio of successive thicknesses, depth divided by the cell's grid step, 0 for no
    /// coarser grid), uniform:N,DEPTH, or the thickness of each cell, length
    #[arg(long, default_value_t = GivenCells::default(), value_name = "CELLS", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "is_default")]
    #[option(kinds = Kinds::LENGTH)]
    pub cells: GivenCells,
    /// Grid step of each cell divided by the surface grid step, a power of two, for cells given one by one [default: 1]
    #[arg(long, value_delimiter = ',', value_name = "S,..")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coarsening: Vec<usize>,
    /// States whose plastic strain is written to --out
    #[arg(
        long,
        value_parser = parse_choice::<KeptStrain>(),
        default_value_t = KeptStrain::Last,
        requires = "out",
        help_heading = "Output"
    )]
    #[serde(skip_serializing_if = "KeptStrain::is_default", with = "named")]
    pub kept_strain: KeptStrain,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Cells as an option gives them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenCells(Cells);

impl FromStr for GivenCells {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || "it must be graded:THICKNESS,GROWTH,COARSEN, uniform:N,DEPTH, or thicknesses T1,T2,..".to_owned();
        let numbers = |text: &str| -> Result<Vec<f64>, String> {
            text.split(',').map(|number| number.trim().parse().map_err(|_| wrong())).collect()
        };
        let cells = match text.split_once(':') {
            Some(("graded", values)) => match numbers(values)?[..] {
                [thickness, growth, coarsening] => Cells::Graded { thickness, growth, coarsening },
                _ => return Err(wrong()),
            },
            Some(("uniform", values)) => {
                let (count, depth) = values.split_once(',').ok_or_else(wrong)?;
                let count = count.trim().parse().map_err(|_| wrong())?;
                if !(1..=MOST_CELLS).contains(&count) {
                    return Err(format!("{count} cells; it must be 1 to {MOST_CELLS}"));
                }
                Cells::Uniform { count, depth: depth.trim().parse().map_err(|_| wrong())? }
            }
            Some(_) => return Err(wrong()),
            None => Cells::List { thicknesses: numbers(text)?, coarsenings: Vec::new() },
        };
        Ok(Self(cells))
    }
}

/// Largest number of cells.
const MOST_CELLS: usize = 1000;

impl fmt::Display for GivenCells {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.0 {
            Cells::Graded { thickness, growth, coarsening } => write!(f, "graded:{thickness},{growth},{coarsening}"),
            Cells::Uniform { count, depth } => write!(f, "uniform:{count},{depth}"),
            Cells::List { thicknesses, .. } => {
                let all: Vec<String> = thicknesses.iter().map(ToString::to_string).collect();
                f.write_str(&all.join(","))
            }
        }
    }
}

impl Serialize for GivenCells {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

/// Reads the text of the option, or a list of thicknesses.
impl<'de> Deserialize<'de> for GivenCells {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Form {
            Text(String),
            List(Vec<f64>),
        }
        match Form::deserialize(deserializer)? {
            Form::Text(text) => text.parse().map_err(D::Error::custom),
            Form::List(thicknesses) => Ok(Self(Cells::List { thicknesses, coarsenings: Vec::new() })),
        }
    }
}

/// The yielding of a body, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Yielding {
    #[serde(rename = "yield")]
    pub yield_stress: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hardening: Option<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub hardening_curve: Vec<[f64; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kinematic: Option<f64>,
    /// Thickness of each cell.
    pub cells: Vec<f64>,
    pub coarsening: Vec<usize>,
    #[serde(skip_serializing_if = "KeptStrain::is_default", with = "named")]
    pub kept_strain: KeptStrain,
}

/// Hardening of each layer of a body, from the top, and the cells in which it yields.
#[derive(Clone, Debug, PartialEq)]
pub struct Plasticity {
    /// Hardening of each layer; `None` for a layer that does not yield.
    pub hardening: Vec<Option<Hardening>>,
    /// Cells.
    pub cells: Cells,
    /// States whose plastic strain a file keeps.
    pub kept_strain: KeptStrain,
}

impl PlasticityArgs {
    /// Returns the yielding of a body; `None` if it does not yield.
    ///
    /// # Errors
    /// Returns an error for values out of range, and for options that need a yield stress.
    pub fn plasticity(&self, body: &BodyArgs) -> Result<Option<Plasticity>, Unusable> {
        let Some(yield_stress) = self.yield_stress else { return self.check_left_out().map(|()| None) };
        let wrong = |error: PlasticityError| unusable(&error);
        let mut material = Hardening::new(yield_stress).map_err(wrong)?;
        if !self.hardening_curve.is_empty() {
            let rows = self.hardening_curve.len();
            if rows > LONGEST_TABLE {
                let found = format!("{rows} rows");
                return Err(Unusable::value(key("hardening_curve"), found, format!("at most {LONGEST_TABLE}")));
            }
            material = Hardening::from_curve(&self.hardening_curve)
                .map_err(|error| Unusable::input(key("hardening_curve"), error))?;
            let first = material.yield_stress();
            if first != yield_stress {
                let allowed = words![format!("{yield_stress:e}, as "), key("yield_stress")];
                return Err(Unusable::value(key("hardening_curve"), format!("{first:e} at first"), allowed));
            }
        }
        if let Some(modulus) = self.hardening {
            material = material.isotropic(modulus).map_err(wrong)?;
        }
        if let Some(modulus) = self.kinematic_hardening {
            material = material.kinematic(modulus).map_err(wrong)?;
        }
        let below = body.others.layer.len() + usize::from(body.others.base == BaseKind::HalfSpace);
        let given = self.layer_yield.len();
        if given > below {
            let allowed = format!("{below} at most, one for each layer below the top one");
            return Err(Unusable::value(key("layer_yield"), format!("{given} values"), allowed));
        }
        let mut hardening = vec![Some(material.clone())];
        for found in self.layer_yield.iter().copied().chain(std::iter::repeat_n(0.0, below - given)) {
            let own = if found == 0.0 { Ok(None) } else { material.clone().with_yield_stress(found).map(Some) };
            hardening.push(own.map_err(|error| Unusable::input(key("layer_yield"), error))?);
        }
        let mut cells = self.cells.0.clone();
        match &mut cells {
            Cells::List { coarsenings, .. } => coarsenings.clone_from(&self.coarsening),
            _ if self.coarsening.is_empty() => {}
            _ => {
                let found = format!("{:?}", self.coarsening);
                let allowed = words!["left out unless ", key("cells"), " gives the thickness of each cell"];
                return Err(Unusable::value(key("coarsening"), found, allowed));
            }
        }
        Ok(Some(Plasticity { hardening, cells, kept_strain: self.kept_strain }))
    }

    /// Returns the options with the cells of the problem; `None` for a body that does not yield.
    pub fn yielding(&self, cells: &[Cell]) -> Option<Yielding> {
        Some(Yielding {
            yield_stress: self.yield_stress?,
            hardening: self.hardening,
            hardening_curve: self.hardening_curve.clone(),
            kinematic: self.kinematic_hardening,
            cells: cells.iter().map(|cell| cell.thickness).collect(),
            coarsening: cells.iter().map(|cell| cell.coarsening).collect(),
            kept_strain: self.kept_strain,
        })
    }

    /// Checks that no other option is given without a yield stress.
    fn check_left_out(&self) -> Result<(), Unusable> {
        let given = [
            ("hardening", self.hardening.is_some()),
            ("hardening_curve", !self.hardening_curve.is_empty()),
            ("kinematic_hardening", self.kinematic_hardening.is_some()),
            ("layer_yield", !self.layer_yield.is_empty()),
            ("cells", !is_default(&self.cells)),
            ("coarsening", !self.coarsening.is_empty()),
            ("kept_strain", !self.kept_strain.is_default()),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given) {
            Some((name, _)) => {
                Err(Unusable::value(key(name), "given", words!["left out without ", key("yield_stress")]))
            }
            None => Ok(()),
        }
    }
}

impl Plasticity {
    /// Returns the cells in a body below a surface on `grid`.
    ///
    /// # Errors
    /// Returns an error, with the option at fault, for materials that cannot yield and cells that do not fit.
    pub fn cells(&self, body: &Body, grid: &Grid) -> Result<Vec<Cell>, Unusable> {
        self.cells.in_body(body, grid, &self.hardening).map_err(|error| unusable(&error))
    }

    /// Returns cells of half the thickness for a grid with half the spacing, if they are not graded by the grid.
    #[must_use]
    pub fn finer(&self) -> Self {
        let cells = match &self.cells {
            graded @ Cells::Graded { .. } => graded.clone(),
            Cells::Uniform { count, depth } => Cells::Uniform { count: 2 * count, depth: *depth },
            Cells::List { thicknesses, coarsenings } => Cells::List {
                thicknesses: thicknesses.iter().flat_map(|thickness| [0.5 * thickness; 2]).collect(),
                coarsenings: coarsenings.iter().flat_map(|coarsening| [*coarsening; 2]).collect(),
            },
        };
        Self { hardening: self.hardening.clone(), cells, kept_strain: self.kept_strain }
    }
}

/// Names the option at fault.
fn unusable(error: &PlasticityError) -> Unusable {
    use PlasticityError as Error;
    let name = match error {
        Error::YieldStress { .. } | Error::YieldStrain { .. } | Error::NothingYields => "yield_stress",
        Error::Modulus { what: "isotropic", .. } => "hardening",
        Error::Modulus { .. } => "kinematic_hardening",
        Error::CurvePoints { .. }
        | Error::CurveStart { .. }
        | Error::CurveStrain { .. }
        | Error::CurveStress { .. } => "hardening_curve",
        Error::Poisson { .. } => "poisson",
        Error::Tabulated => "compliance",
        Error::Coarsenings { .. } | Error::Coarsening { .. } => "coarsening",
        _ => "cells",
    };
    Unusable::input(key(name), error)
}

#[cfg(test)]
mod tests {
    use gfmd_green::Height;

    use super::*;

    fn steel() -> PlasticityArgs {
        PlasticityArgs { yield_stress: Some(0.01), ..PlasticityArgs::default() }
    }

    #[test]
    fn cells_are_read_and_written_alike() {
        for text in ["graded:0.5,1.12,3", "uniform:16,0.25", "0.1,0.2,0.4"] {
            assert_eq!(text.parse::<GivenCells>().unwrap().to_string(), text);
        }
        for text in ["graded:0.5", "uniform:x,1", "deep", "1,,2", "cubes:3"] {
            assert!(text.parse::<GivenCells>().unwrap_err().starts_with("it must be graded:"), "{text}");
        }
        assert!("uniform:0,1".parse::<GivenCells>().unwrap_err().contains("1 to 1000"));
    }

    #[test]
    fn layers_below_harden_like_the_top_one() {
        let mut body = BodyArgs { height: Height::Finite(0.1), ..BodyArgs::default() };
        body.others.layer = vec![crate::options::Layer::of(&[2.0, 0.3, 0.2]).unwrap(); 2];
        let args = PlasticityArgs { hardening: Some(0.1), layer_yield: vec![0.02], ..steel() };
        let found = args.plasticity(&body).unwrap().unwrap().hardening;
        let resistance = |layer: usize| found[layer].as_ref().map(|material| material.resistance(0.1));
        for (layer, expected) in [(0, 0.02), (1, 0.03)] {
            approx::assert_relative_eq!(resistance(layer).unwrap(), expected, max_relative = 1e-15);
        }
        assert_eq!(resistance(2), None);
    }

    #[test]
    fn unusable_values_are_refused_with_their_option() {
        let body = BodyArgs::default();
        let says = |args: PlasticityArgs, words: &str| {
            let found = args.plasticity(&body).unwrap_err().to_string();
            assert!(found.starts_with(words), "{found}");
        };
        let none = PlasticityArgs::default();
        assert_eq!(none.plasticity(&body).unwrap(), None);
        says(PlasticityArgs { hardening: Some(1.0), ..none }, "--hardening is given; it must be left out without");
        says(PlasticityArgs { yield_stress: Some(-1.0), ..steel() }, "--yield-stress: the yield stress is -1");
        says(PlasticityArgs { hardening: Some(-1.0), ..steel() }, "--hardening: the isotropic hardening is -1");
        says(PlasticityArgs { kinematic_hardening: Some(-1.0), ..steel() }, "--kinematic-hardening: the kinematic");
        says(PlasticityArgs { layer_yield: vec![1.0], ..steel() }, "--layer-yield is 1 values; it must be 0 at most");
        says(PlasticityArgs { coarsening: vec![2], ..steel() }, "--coarsening is [2]; it must be left out unless");
        let curve = |rows: &[[f64; 2]]| PlasticityArgs { hardening_curve: rows.to_vec(), ..steel() };
        says(curve(&[[0.0, 0.02], [0.1, 0.03]]), "--hardening-curve is 2e-2 at first; it must be 1e-2");
        says(curve(&[[0.0, 0.01]]), "--hardening-curve: the hardening curve has 1 points");
        assert!(curve(&[[0.0, 0.01], [0.1, 0.03]]).plasticity(&body).is_ok());
    }

    #[test]
    fn cells_that_do_not_fit_are_refused_with_their_option() {
        let grid = Grid::square(16, 1.0).unwrap();
        let says = |body: BodyArgs, cells: &str, words: &str| {
            let args = PlasticityArgs { cells: cells.parse().unwrap(), ..steel() };
            let plasticity = args.plasticity(&body).unwrap().unwrap();
            let found = plasticity.cells(&body.body().unwrap(), &grid).unwrap_err().to_string();
            assert!(found.starts_with(words), "{found}");
        };
        let soft = BodyArgs { young: Some(0.05), ..BodyArgs::default() };
        says(soft, "graded:0.5,1.12,3", "--yield-stress: the yield stress is 0.01; it must be less than 0.005");
        let rubber = BodyArgs { poisson: 0.499, ..BodyArgs::default() };
        says(rubber, "graded:0.5,1.12,3", "--poisson: Poisson's ratio of a layer with cells is 0.499");
        says(BodyArgs::default(), "graded:0.5,3,3", "--cells: the growth of the cells is 3");
        let thin = BodyArgs { height: Height::Finite(0.1), ..BodyArgs::default() };
        says(thin, "uniform:4,0.2", "--cells: the cells end at a depth of");
    }
}
