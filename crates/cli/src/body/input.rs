//! Displacement of a surface, from a file or from memory.

use gfmd_field::Grid;
use gfmd_files::input::MOST_BYTES;
use gfmd_files::legible::line;
use gfmd_files::{Checksum, Input, Reader, cell_lengths, npy, split_dataset};
use gfmd_problem::{Words, key, words};

use super::wave::{self, Wave};
use gfmd_input::base::BaseArgs;
use gfmd_input::failure::Failure;
use gfmd_input::lower::{LowerArgs, is_stored};
use gfmd_input::memory;
use gfmd_problem::options::given::{ArrayOption, StoredLoad};
use gfmd_unit::Units;

/// Field stored in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum StoredField {
    /// Displacement x, y, z, or x, z on a line.
    Full,
    /// Displacement z alone, of a frictionless surface.
    Normal,
    /// Traction xz, yz, zz, or xz, zz on a line.
    Traction,
    /// Pressure on the surface, without shear traction, of a relaxing body: it determines the stress, while
    /// displacement, strain and energy depend on all earlier loads.
    Pressure,
}

/// Displacement of a surface, or traction on it, with the configuration of its run.
#[derive(Debug)]
pub(super) struct Surface {
    pub(super) grid: Grid,
    pub(super) kind: StoredField,
    /// Values, component after component.
    pub(super) values: Vec<f64>,
    /// Mean traction xz, yz, zz, if the file has it.
    pub(super) mean_traction: Option<[f64; 3]>,
    /// Configuration of the run; empty if there is none.
    pub(super) record: toml::Table,
    pub(super) load: Option<usize>,
    pub(super) unit: String,
    pub(super) description: String,
    /// Scan pressed on the body and its preparation, if the heights came from a file.
    pub(super) scan: Option<String>,
    /// SHA-256 of the input file, if there is one.
    pub(super) checksum: Option<String>,
}

impl Surface {
    /// Returns the units of lengths and stresses, as far as they are known.
    pub(super) fn units(&self) -> Units {
        let length = Some(self.unit.as_str()).filter(|unit| *unit != "length");
        Units::new(length, text_of(&self.record, "stress_unit").as_deref())
    }
}

/// Returns a text of a configuration.
fn text_of(record: &toml::Table, key: &str) -> Option<String> {
    record.get(key).and_then(toml::Value::as_str).map(str::to_owned)
}

/// Datasets in files of gfmd, in order of preference.
const FULL: &str = "/fields/displacement";
const NORMAL: &str = "/fields/displacement_z";

/// Array of a file with its description, before its shape is checked.
struct Found {
    shape: Vec<usize>,
    values: Vec<f64>,
    kind: StoredField,
    mean_traction: Option<[f64; 3]>,
    lengths: Option<[f64; 2]>,
    unit: Option<String>,
    record: toml::Table,
    load: Option<usize>,
    scan: Option<String>,
    /// SHA-256 of the file.
    checksum: Option<String>,
}

/// Returns the name of the input in messages.
pub(super) fn name(given: &ArrayOption) -> &str {
    given.file().unwrap_or("surface")
}

impl Surface {
    /// Reads `FILE.npy` or `FILE.h5[:/dataset]`, or takes the input in memory.
    pub(super) fn read(given: &ArrayOption, load: Option<usize>, length: &[f64]) -> Result<Self, Failure> {
        let name = name(given);
        let refuse = |reason: Words| Failure::because(name, reason);
        let found = match (given, split_dataset(name)) {
            (ArrayOption::Array(array), _) => Ok(Found::array(array.shape(), array.iter().copied().collect(), None)),
            (ArrayOption::Load(load), _) => in_memory(load).map_err(Words::from),
            (ArrayOption::File(_), Some((path, dataset))) => archive(path, dataset, load),
            (ArrayOption::File(_), None) => array(name).map_err(Words::from),
        };
        let found = found.map_err(refuse)?;
        if let (Some(_), None) = (load, found.load) {
            return Err(Failure::input(key("load"), format!("{name} has no loads")));
        }
        let allowed = "it must be [nx, ny, 3], or [n, 2] for a line";
        let (points, components) = match (found.kind, &found.shape[..]) {
            (StoredField::Normal | StoredField::Pressure, &[nx, ny]) => ([nx, ny], 1),
            (StoredField::Full | StoredField::Traction, &[n, 2] | &[n, 1, 2]) => ([n, 1], 2),
            (StoredField::Full | StoredField::Traction, &[nx, ny, 3]) if ny > 1 => ([nx, ny], 3),
            (_, shape) => return Err(refuse(format!("the shape is {shape:?}; {allowed}").into())),
        };
        let lengths = cell(length, found.lengths, points);
        let grid = Grid::new(points, lengths);
        let grid =
            grid.map_err(|error| Failure::input(if length.is_empty() { name.into() } else { key("size") }, error))?;
        let values = (0..components).flat_map(|c| found.values.iter().skip(c).step_by(components).copied()).collect();
        let description = match (found.load, found.kind) {
            (Some(load), StoredField::Normal) => {
                format!("{name}, load {load}, with the lateral displacement of a frictionless surface")
            }
            (Some(load), StoredField::Full) => format!("{name}, load {load}, with its own lateral displacement"),
            (Some(load), StoredField::Pressure) => format!("{name}, load {load}, below its pressure"),
            (Some(load), StoredField::Traction) => {
                format!("{name}, waypoint {load}, below its pressure and shear traction")
            }
            (None, StoredField::Normal) => format!("{name}, with the lateral displacement of a frictionless surface"),
            (None, StoredField::Full | StoredField::Traction | StoredField::Pressure) => name.into(),
        };
        let description = match &found.scan {
            Some(scan) => format!("{description}; pressed by {scan}"),
            None => description,
        };
        Ok(Self {
            grid,
            kind: found.kind,
            values,
            mean_traction: found.mean_traction,
            unit: found.unit.or_else(|| text_of(&found.record, "unit")).unwrap_or_else(|| "length".into()),
            record: found.record,
            load: found.load,
            description,
            scan: found.scan,
            checksum: found.checksum,
        })
    }
}

impl Surface {
    /// Creates the displacement by waves on a grid of `n` points, [nx] or [nx, ny]; a line if ny is 1.
    pub(super) fn of_waves(waves: &[Wave], n: &[usize], length: &[f64]) -> Result<Self, Failure> {
        let points = match n {
            [] => [POINTS; 2],
            [n] => [*n; 2],
            [nx, ny, ..] => [*nx, *ny],
        };
        if points[0] < 2 || points[1] == 0 {
            return Err(Failure::value(key("n"), format!("{points:?}"), "at least 2 along x, and at least 1 along y"));
        }
        memory::fits(memory::BODY, key("n"), points)?;
        let grid = Grid::new(points, cell(length, None, points)).map_err(|error| Failure::input(key("size"), error))?;
        let words: Vec<String> = waves.iter().map(Wave::to_string).collect();
        Ok(Self {
            grid,
            kind: StoredField::Full,
            values: wave::displacement(waves, &grid)?,
            mean_traction: None,
            record: toml::Table::new(),
            load: None,
            unit: "length".into(),
            description: format!("waves {}", words.join(" + ")),
            scan: None,
            checksum: None,
        })
    }
}

/// Default number of points along each axis.
const POINTS: usize = 64;

/// Returns the sides of the cell: the given ones, else the stored ones, else 1 along x and equal spacings.
fn cell(length: &[f64], of_file: Option<[f64; 2]>, [nx, ny]: [usize; 2]) -> [f64; 2] {
    match length {
        [] => of_file.unwrap_or([1.0, if ny == 1 { 1.0 } else { ny as f64 / nx as f64 }]),
        // A single length is the length along x; both axes have the same spacing.
        [x] => [*x, if ny == 1 { 1.0 } else { x * ny as f64 / nx as f64 }],
        [x, y, ..] => [*x, *y],
    }
}

fn array(path: &str) -> Result<Found, String> {
    let words = |error: std::io::Error| error.to_string();
    let bytes = Input::settled(path).and_then(|input| input.bytes(MOST_BYTES)).map_err(words)?;
    let array = npy::parse(&bytes)?;
    let shape = array.shape().to_vec();
    Ok(Found::array(&shape, array.into_iter().collect(), Some(Checksum::of_bytes(&bytes))))
}

impl Found {
    /// Wraps an array as a displacement.
    fn array(shape: &[usize], values: Vec<f64>, checksum: Option<String>) -> Self {
        Self {
            shape: shape.to_vec(),
            values,
            kind: StoredField::Full,
            mean_traction: None,
            lengths: None,
            unit: None,
            record: toml::Table::new(),
            load: None,
            scan: None,
            checksum,
        }
    }

    /// Completes the normal displacement of a contact with the other stored `field`s of its surface and `number`s of
    /// its load.
    fn beside(
        self,
        [nx, ny]: [usize; 2],
        field: impl Fn(&str) -> Result<Option<Vec<f64>>, String>,
        number: impl Fn(&str) -> Result<Option<f64>, String>,
    ) -> Result<Self, String> {
        let axes = if ny == 1 { 1 } else { 2 };
        let lateral = |names: [&str; 2]| names[..axes].iter().map(|name| field(name)).collect::<Result<_, String>>();
        let pressure = field("pressure")?;
        let components = self.record.get("components").and_then(toml::Value::as_str);
        // All components follow from the pressure; the solver decides which shortest waves they have.
        if relaxes(&self.record) || components == Some("all") {
            let values = pressure.ok_or("pressure is missing; the file must have it")?;
            let mean_traction = Some([0.0, 0.0, -mean(&values)]);
            return Ok(Self { kind: StoredField::Pressure, mean_traction, values, ..self });
        }
        let shears: Option<Vec<Vec<f64>>> = lateral(["shear_x", "shear_y"])?;
        if let (None, Some(friction)) = (&shears, FRICTION.iter().find(|key| self.record.contains_key(**key))) {
            return Err(format!("the {} {NO_SHEAR}", friction.replace('_', " ")));
        }
        let lateral = match components == Some("held") {
            // Held surfaces have no lateral displacement; other surfaces use the stored one, if any.
            true => Some(vec![vec![0.0; self.values.len()]; axes]),
            false => lateral(["displacement_x", "displacement_y"])?,
        };
        let mean_traction = match &pressure {
            Some(pressure) => {
                let [x, y] = match &shears {
                    Some(shears) => [0, 1].map(|axis| shears.get(axis).map(|shear| mean(shear))),
                    None => [number("mean_shear_x")?, number("mean_shear_y")?],
                };
                Some([x.unwrap_or(0.0), y.unwrap_or(0.0), -mean(pressure)])
            }
            None => None,
        };
        let (columns, kind) = match (shears, pressure, lateral) {
            (Some(shears), Some(pressure), _) => {
                ([shears, vec![pressure.iter().map(|p| -p).collect()]].concat(), StoredField::Traction)
            }
            (_, _, Some(lateral)) => ([lateral, vec![self.values]].concat(), StoredField::Full),
            _ => return Ok(Self { kind: StoredField::Normal, mean_traction, ..self }),
        };
        let values = (0..columns[0].len()).flat_map(|i| columns.iter().map(move |column| column[i])).collect();
        Ok(Self { shape: vec![nx, ny, columns.len()], values, kind, mean_traction, ..self })
    }
}

/// Configuration keys of contacts with a shear traction.
const FRICTION: [&str; 2] = ["friction", "shear_strength"];

/// Reason for refusing stresses without the shear traction.
const NO_SHEAR: &str =
    "of this contact causes a shear traction, which the result does not have; the stress inside is not available";

/// Returns true if the body of a run relaxes.
pub(super) fn relaxes(record: &toml::Table) -> bool {
    record.contains_key("prony")
}

/// Returns the displacement of a contact in memory.
fn in_memory(load: &StoredLoad) -> Result<Found, String> {
    check_inside(&load.config, LowerArgs::NAMES.iter().any(|key| load.config.contains_key(*key)))?;
    if BaseArgs::NAMES.iter().any(|key| load.config.contains_key(*key)) {
        return Err("the base of this contact moves; the fields inside are those of its file".into());
    }
    let displacement = load.values.get("displacement_z").ok_or("displacement_z is missing; the file must have it")?;
    let points = <[usize; 2]>::try_from(displacement.shape()).map_err(|_| "displacement_z must be [nx, ny]")?;
    let record = load.config.clone();
    let values = displacement.iter().copied().collect();
    let found = Found { record, ..Found::array(&points, values, None) };
    let field = |name: &str| Ok(load.values.get(name).map(|field| field.iter().copied().collect()));
    found.beside(points, field, |name| Ok(load.values.get(name).and_then(|number| number.first().copied())))
}

/// Refuses a contact without fields below its surface.
fn check_inside(record: &toml::Table, between: bool) -> Result<(), String> {
    let boundary = record.get("boundary").and_then(toml::Value::as_str).unwrap_or("periodic");
    if boundary != "periodic" {
        return Err(format!("the boundary of this contact is {boundary}; it must be periodic for the fields below it"));
    }
    if record.contains_key("compliance") {
        return Err("the body of this contact is a table of compliances; the fields inside are not known".into());
    }
    if record.contains_key("yield_stress") {
        let text = "the body of this contact yields; the fields inside include residual stress by plastic strain, and \
                    are not available";
        return Err(text.into());
    }
    if relaxes(record) {
        // At a constant Poisson's ratio, the stress for a given traction does not depend on the moduli.
        if let Some(moduli) = text_of(record, "relaxes").filter(|moduli| moduli != "both") {
            let text = "of this contact relaxes, so that Poisson's ratio depends on time; the stress inside is not \
                        available";
            return Err(format!("the {} modulus {text}", line(&moduli)));
        }
        if let Some(key) = BaseArgs::NAMES.iter().find(|key| record.contains_key(**key)) {
            let text = "of this contact moves and its body relaxes; the stress inside is not available";
            return Err(format!("the {} {text}", key.replace('_', " ")));
        }
        // The shear traction of the friction is not part of the result.
        if let Some(key) = FRICTION.iter().find(|key| record.contains_key(**key)) {
            let text =
                "of this contact causes a shear traction on a body that relaxes; the stress inside is not available";
            return Err(format!("the {} {text}", key.replace('_', " ")));
        }
    }
    if between {
        return Err("the slab of this contact lies between two surfaces; the fields inside are not available".into());
    }
    Ok(())
}

/// Refuses a displacement in another unit than its coordinates: strains would be wrong by the ratio.
fn check_units(reader: &Reader, dataset: &str, has_y: bool) -> Result<(), String> {
    let group = dataset.rsplit_once('/').map_or("", |(group, _)| group);
    let unit = |path: &str| {
        let found = reader.text(path, "units").or_else(|_| reader.text(path, "unit")).unwrap_or_default();
        let is_any = ["", "1", "length"].contains(&found.as_str());
        if is_any { "none".into() } else { line(&found) }
    };
    let found = unit(dataset);
    let axes = if has_y { &["x", "y"][..] } else { &["x"][..] };
    match axes.iter().map(|axis| (axis, unit(&format!("{group}/{axis}")))).find(|(_, along)| *along != found) {
        Some((axis, along)) => {
            Err(format!("the units of {dataset} and {axis} are {found} and {along}; they must be the same"))
        }
        None => Ok(()),
    }
}

fn archive(path: &str, dataset: &str, load: Option<usize>) -> Result<Found, Words> {
    let words = |error: gfmd_files::FileError| error.to_string();
    let reader = Reader::open(path).map_err(words)?;
    let dataset = match dataset {
        "" if reader.contains(FULL) || !reader.contains(NORMAL) => FULL,
        "" => NORMAL,
        given => given,
    };
    let mut shape = reader.shape(dataset).map_err(words)?;
    let unit = reader.text(dataset, "units").ok().map(|unit| line(&unit));
    let record: toml::Table = reader.text("/", "config").ok().and_then(|text| text.parse().ok()).unwrap_or_default();
    let normal = dataset.ends_with("displacement_z");
    check_inside(&record, is_stored(&reader))?;
    let (values, load): (Vec<f64>, _) = match (normal, shape.len()) {
        (true, 3) => {
            let loads = shape.remove(0);
            let load = load.unwrap_or(loads.saturating_sub(1));
            if load >= loads {
                let rest = format!(" is {load}; it must be below {loads}, the number of loads");
                return Err(words![key("load"), rest]);
            }
            (reader.slab(dataset, load).map_err(words)?, Some(load))
        }
        _ => (reader.physical(dataset).map_err(words)?, None),
    };
    let points = [shape.first().copied().unwrap_or(0), if shape.len() > 1 { shape[1] } else { 1 }];
    let points = if !normal && shape.len() == 2 { [points[0], 1] } else { points };
    let coordinate = |name: &str| reader.contains(name).then(|| reader.values(name).map_err(words));
    let lengths = cell_lengths(coordinate, dataset, points)?;
    if lengths.is_some() {
        check_units(&reader, dataset, points[1] > 1)?;
    }
    // Only heights from a file have a format.
    let scan = reader.text("/surface", "format").and_then(|_| reader.text("/surface", "description"));
    let scan = scan.ok().map(|scan| line(&scan));
    let checksum = reader.checksum().map_err(words)?;
    let found = Found { shape, lengths, unit, record, load, scan, ..Found::array(&[], values, Some(checksum)) };
    let group = dataset.rsplit_once('/').map_or("", |(group, _)| group);
    let beside = Beside { reader: &reader, group, load, points };
    if normal {
        Ok(found.beside(points, |name| beside.field(name), |name| beside.number(name))?)
    } else {
        let mean_traction = beside.traction(found.values.len())?;
        Ok(Found { mean_traction, ..found })
    }
}

/// Fields stored beside the displacement of a surface, in its group and for its load.
struct Beside<'a> {
    reader: &'a Reader,
    group: &'a str,
    load: Option<usize>,
    points: [usize; 2],
}

impl Beside<'_> {
    /// Reads a field of all points, if the file has it.
    fn field(&self, name: &str) -> Result<Option<Vec<f64>>, String> {
        let path = format!("{}/{name}", self.group);
        let [nx, ny] = self.points;
        if !self.reader.contains(&path) {
            return Ok(None);
        }
        let values = match self.load {
            Some(load) => self.reader.slab(&path, load),
            None => self.reader.values(&path),
        };
        let values: Vec<f64> = values.map_err(|error| error.to_string())?;
        match values.len() {
            found if found == nx * ny => Ok(Some(values)),
            found => Err(format!("{path} has {found} points; it must have {nx} x {ny}, as the displacement")),
        }
    }

    /// Reads a number of the load, if the file has it.
    fn number(&self, name: &str) -> Result<Option<f64>, String> {
        let path = format!("/loads/{name}");
        let Some(load) = self.load.filter(|_| self.reader.contains(&path)) else { return Ok(None) };
        let of_loads: Vec<f64> = self.reader.values(&path).map_err(|error| error.to_string())?;
        Ok(Some(of_loads.get(load).copied().unwrap_or(f64::NAN)))
    }

    /// Reads the mean of the tractions beside a displacement of `count` values, if the file has them.
    fn traction(&self, count: usize) -> Result<Option<[f64; 3]>, String> {
        let path = format!("{}/traction", self.group);
        let components = count / (self.points[0] * self.points[1]).max(1);
        if !self.reader.contains(&path) || !(2..=3).contains(&components) {
            return Ok(None);
        }
        let values: Vec<f64> = self.reader.values(&path).map_err(|error| error.to_string())?;
        if values.len() != count {
            return Err(format!("{path} has {} values; it must have {count}, as the displacement", values.len()));
        }
        let mean = |c: usize| mean(&values.iter().skip(c).step_by(components).copied().collect::<Vec<f64>>());
        Ok(Some(if components == 2 { [mean(0), 0.0, mean(1)] } else { [mean(0), mean(1), mean(2)] }))
    }
}

fn mean(field: &[f64]) -> f64 {
    field.iter().sum::<f64>() / field.len() as f64
}
