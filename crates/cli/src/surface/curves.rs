//! The functions that describe a surface, as arrays by name: for JSON, files and Python.

use gfmd_field::Grid;
use gfmd_files::{Archive, Dimension, Variable};
use gfmd_record::by_reason;
use gfmd_report::surface::Number;
use gfmd_surface::{Autocorrelation, Bearing, Density, Distributions, RadialBin, Scales, Texture};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

use gfmd_input::failure::Failure;
use gfmd_report::surface::unit_of;
use gfmd_unit::Units;

/// Curves and the numbers of their groups, in the order of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curves {
    curves: Vec<Curve>,
    numbers: Vec<Found>,
}

/// A number, with the group that it belongs to, and the reason if it has no value.
#[derive(Clone, Debug, PartialEq)]
struct Found {
    group: &'static str,
    number: Number,
    undefined: &'static str,
}

/// Arrays of one length; the first is the abscissa of the others.
#[derive(Clone, Debug, PartialEq)]
struct Curve {
    /// The place in JSON and in a file: a group, or two with a stroke between.
    path: &'static str,
    columns: Vec<Column>,
}

#[derive(Clone, Debug, PartialEq)]
struct Column {
    name: &'static str,
    /// The unit as a power of length.
    power: i32,
    meaning: &'static str,
    values: Vec<f64>,
}

fn column(name: &'static str, power: i32, meaning: &'static str, values: impl IntoIterator<Item = f64>) -> Column {
    Column { name, power, meaning, values: values.into_iter().collect() }
}

impl Curves {
    /// All of them.
    pub fn of(texture: &Texture, spectrum: &[RadialBin], grid: &Grid) -> Self {
        let parts = [
            Self::psd(spectrum, grid),
            Self::autocorrelation(&texture.autocorrelation, grid),
            Self::distributions(&texture.distributions, grid),
            Self::scale_dependence(&texture.scales),
            Self::bearing_curve(&texture.bearing),
        ];
        parts.into_iter().fold(Self::default(), |mut all, part| {
            all.curves.extend(part.curves);
            // Other numbers stand among the statistics.
            all.numbers.extend(part.numbers.into_iter().filter(|found| found.group.starts_with("distributions")));
            all
        })
    }

    /// The radially averaged power spectral density.
    pub fn psd(spectrum: &[RadialBin], grid: &Grid) -> Self {
        let power = if grid.is_line() { 3 } else { 4 };
        let columns = vec![
            column(
                "wavenumber",
                -1,
                "mean wavenumber of the ring, rad/length",
                spectrum.iter().map(|bin| bin.wavenumber),
            ),
            column(
                "density",
                power,
                "power spectral density, averaged over the ring",
                spectrum.iter().map(|bin| bin.density),
            ),
            column(
                "modes",
                0,
                "number of modes in the ring, of the full spectrum",
                spectrum.iter().map(|bin| bin.modes),
            ),
        ];
        Self { curves: vec![Curve { path: "psd", columns }], numbers: Vec::new() }
    }

    /// The autocorrelation and its lengths.
    pub fn autocorrelation(found: &Autocorrelation, grid: &Grid) -> Self {
        let curve = |path: &'static str, pairs: Vec<[f64; 2]>| Curve {
            path,
            columns: vec![
                column("distance", 1, "distance", pairs.iter().map(|pair| pair[0])),
                column("difference", 2, "half the mean square height difference", pairs.iter().map(|pair| pair[1])),
                column(
                    "autocorrelation",
                    0,
                    "1 minus the difference divided by the mean square height",
                    pairs.iter().map(|pair| found.relative(pair[1])),
                ),
            ],
        };
        let mut curves =
            vec![curve("autocorrelation/radial", found.radial()), curve("autocorrelation/x", found.along(0))];
        let lengths = found.lengths();
        let flat = found.mean_square() <= 0.0;
        let none = if flat {
            "the surface is flat"
        } else {
            "the autocorrelation does not fall to 0.2 within half of the cell"
        };
        let mut numbers = vec![Found {
            group: "autocorrelation",
            number: Number {
                name: "sal",
                value: lengths.sal,
                unit: "length",
                meaning: "Sal of ISO 25178: shortest distance at which the autocorrelation is 0.2",
            },
            undefined: none,
        }];
        if !grid.is_line() {
            curves.push(curve("autocorrelation/y", found.along(1)));
            let none = if flat {
                none
            } else {
                "in a direction the autocorrelation does not fall to 0.2 within half of the cell"
            };
            numbers.push(Found {
                group: "autocorrelation",
                number: Number {
                    name: "str",
                    value: lengths.aspect(),
                    unit: "1",
                    meaning: "Str of ISO 25178: shortest divided by longest distance at which the autocorrelation is \
                              0.2",
                },
                undefined: none,
            });
        }
        Self { curves, numbers }
    }

    /// The distributions of height, slope and curvature.
    pub fn distributions(found: &Distributions, grid: &Grid) -> Self {
        let mut made = Self::default();
        let is_line = grid.is_line();
        let parts = [
            ("distributions/height", &found.height, (1, "length"), "height above the mean, at the bin centre"),
            ("distributions/slope_x", &found.slope_x, (0, "1"), "slope along x, at the bin centre"),
            ("distributions/slope_y", &found.slope_y, (0, "1"), "slope along y, at the bin centre"),
            ("distributions/curvature", &found.curvature, (-1, "1/length"), "curvature, at the bin centre"),
        ];
        for (path, part, (power, unit), meaning) in
            parts.into_iter().filter(|(path, ..)| !(is_line && path.ends_with('y')))
        {
            let (values, densities, gaussian) = match part {
                Some(Density { middles, densities, .. }) => (middles.clone(), densities.clone(), Density::gaussian),
                None => continue,
            };
            let columns = vec![
                column("value", power, meaning, values),
                column("density", -power, "share of values in the bin, divided by its width", densities),
                column(
                    "gaussian",
                    -power,
                    "Gaussian of the same mean and standard deviation",
                    part.iter().flat_map(gaussian),
                ),
            ];
            made.curves.push(Curve { path, columns });
            let number = |name, value, unit, meaning| Found {
                group: path,
                number: Number { name, value, unit, meaning },
                undefined: "all values are equal",
            };
            made.numbers.extend(part.iter().flat_map(|part| {
                [
                    number("mean", Some(part.mean), unit, "mean value"),
                    number("deviation", Some(part.deviation), unit, "standard deviation"),
                    number("outside", Some(part.outside), "1", "share of values beyond the bins"),
                ]
            }));
        }
        made
    }

    /// Slope and curvature against distance.
    pub fn scale_dependence(found: &Scales) -> Self {
        let parts = [
            ("scale_dependence/slope_x", "slope", 0, "rms slope along x", &found.slope[0]),
            ("scale_dependence/slope_y", "slope", 0, "rms slope along y", &found.slope[1]),
            ("scale_dependence/curvature_x", "curvature", -1, "rms curvature along x", &found.curvature[0]),
            ("scale_dependence/curvature_y", "curvature", -1, "rms curvature along y", &found.curvature[1]),
        ];
        let curve = |(path, name, power, meaning, pairs): (_, _, _, _, &Vec<[f64; 2]>)| Curve {
            path,
            columns: vec![
                column(
                    "distance",
                    1,
                    "distance between the outer points of the difference",
                    pairs.iter().map(|pair| pair[0]),
                ),
                column(name, power, meaning, pairs.iter().map(|pair| pair[1])),
            ],
        };
        let some = parts.into_iter().filter(|(.., pairs)| !pairs.is_empty());
        Self { curves: some.map(curve).collect(), numbers: Vec::new() }
    }

    /// The bearing curve and its parameters.
    pub fn bearing_curve(found: &Bearing) -> Self {
        let columns = vec![
            column("ratio", 0, "material ratio: share of points at or above the height", found.ratio.clone()),
            column("height", 1, "height above the mean", found.height.clone()),
        ];
        let core = found.core;
        let numbers = [
            ("sk", core.map(|core| core.sk), "length", "Sk of ISO 25178: core height of the bearing curve"),
            ("spk", core.map(|core| core.spk), "length", "Spk of ISO 25178: reduced peak height above the core"),
            ("svk", core.map(|core| core.svk), "length", "Svk of ISO 25178: reduced valley depth below the core"),
            ("smr1", core.map(|core| core.smr1), "1", "Smr1 of ISO 25178: material ratio between peaks and core"),
            ("smr2", core.map(|core| core.smr2), "1", "Smr2 of ISO 25178: material ratio between core and valleys"),
        ];
        let number = |(name, value, unit, meaning)| Found {
            group: "bearing_curve",
            number: Number { name, value, unit, meaning },
            undefined: "the surface is flat",
        };
        Self {
            curves: vec![Curve { path: "bearing_curve", columns }],
            numbers: numbers.into_iter().map(number).collect(),
        }
    }

    /// Writes the curves, each as the arrays of a group, and their numbers; lengths are in this unit.
    pub(super) fn write(&self, archive: &mut Archive, unit: &str) -> Result<(), Failure> {
        for Curve { path, columns } in self.curves.iter().filter(|curve| curve.path != "psd") {
            let Some((first, others)) = columns.split_first() else { continue };
            let along = Dimension::values(first.name, first.values.clone(), &unit_of(unit, first.power), first.meaning);
            for Column { name, power, meaning, values } in others {
                let units = unit_of(unit, *power);
                let variable = Variable { dimensions: &[&along], units: &units, long_name: meaning };
                archive.write(&format!("/{path}/{name}"), &variable, values)?;
            }
        }
        let units = Units::new(Some(unit).filter(|unit| *unit != "length"), None);
        for Found { group, number: Number { name, value, unit, meaning }, .. } in &self.numbers {
            let units = units.name(unit);
            let variable = Variable { dimensions: &[], units: &units, long_name: meaning };
            archive.write(&format!("/{group}/{name}"), &variable, &[value.unwrap_or(f64::NAN)])?;
        }
        Ok(())
    }

    /// Returns the curves and numbers as nested JSON.
    fn json(&self) -> Map<String, Value> {
        let numbers_of = |path: &str| -> Map<String, Value> {
            let own = self.numbers.iter().filter(|found| found.group == path);
            own.map(|found| (found.number.name.to_owned(), found.number.value.into())).collect()
        };
        let mut all = Map::new();
        let parts = self.curves.iter().map(|curve| {
            let columns =
                curve.columns.iter().map(|column| (column.name.to_owned(), Value::from(column.values.clone())));
            let (group, part) = curve.path.split_once('/').unwrap_or((curve.path, ""));
            (group, part, columns.chain(numbers_of(curve.path)).collect::<Map<_, _>>())
        });
        for (group, part, content) in parts {
            let before = all.remove(group).unwrap_or_else(|| numbers_of(group).into());
            let Value::Object(mut inner) = before else { continue };
            match part {
                "" => inner.extend(content),
                _ => drop(inner.insert(part.into(), content.into())),
            }
            all.insert(group.into(), inner.into());
        }
        all
    }

    /// Returns the numbers without a value, each with its reason.
    pub(super) fn undefined(&self) -> impl Iterator<Item = (String, &'static str)> + '_ {
        let none = self.numbers.iter().filter(|found| found.number.value.is_none());
        none.map(|found| (format!("{}.{}", found.group, found.number.name), found.undefined))
    }
}

/// Serializes the curves of a report, which has the reasons of all its numbers in one place.
pub(super) fn numbers<S: Serializer>(curves: &Option<Curves>, serializer: S) -> Result<S::Ok, S::Error> {
    curves.as_ref().map(Curves::json).unwrap_or_default().serialize(serializer)
}

impl Serialize for Curves {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut all = self.json();
        let named: Vec<(String, &str)> = self.undefined().collect();
        let reasons = by_reason(named.iter().map(|(name, reason)| (&**name, *reason)));
        let undefined: Map<String, Value> =
            reasons.into_iter().map(|(reason, names)| (reason.to_owned(), names.into())).collect();
        if !undefined.is_empty() {
            all.insert("undefined".into(), undefined.into());
        }
        all.serialize(serializer)
    }
}
