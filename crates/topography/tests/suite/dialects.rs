//! Random grids written in every dialect of HDF5 and NetCDF that is read, and read back: types, scales, missing values,
//! limits, units, order of dimensions, direction and type of coordinates, chunks, compression. The expected values are
//! computed from the values written.

use std::str::FromStr;

use gfmd_topography::Topography;
use hdf5::types::VarLenUnicode;
use hdf5::{Dataset, Group, H5Type};

/// Random numbers (SplitMix64).
struct Random(u64);

impl Random {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % end as u64) as usize
    }

    fn pick<T: Copy>(&mut self, from: &[T]) -> T {
        from[self.below(from.len())]
    }

    fn coin(&mut self) -> bool {
        self.below(2) == 1
    }
}

/// Type of stored numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

const KINDS: [Kind; 10] =
    [Kind::I8, Kind::U8, Kind::I16, Kind::U16, Kind::I32, Kind::U32, Kind::I64, Kind::U64, Kind::F32, Kind::F64];

impl Kind {
    fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    fn is_signed(self) -> bool {
        !matches!(self, Self::U8 | Self::U16 | Self::U32 | Self::U64)
    }

    /// Returns the number of the type in NetCDF.
    fn code(self) -> u32 {
        [1, 7, 3, 8, 4, 9, 10, 11, 5, 6][KINDS.iter().position(|kind| *kind == self).unwrap()]
    }

    fn big_endian(self, number: f64) -> Vec<u8> {
        match self {
            Self::I8 => (number as i8).to_be_bytes().to_vec(),
            Self::U8 => (number as u8).to_be_bytes().to_vec(),
            Self::I16 => (number as i16).to_be_bytes().to_vec(),
            Self::U16 => (number as u16).to_be_bytes().to_vec(),
            Self::I32 => (number as i32).to_be_bytes().to_vec(),
            Self::U32 => (number as u32).to_be_bytes().to_vec(),
            Self::I64 => (number as i64).to_be_bytes().to_vec(),
            Self::U64 => (number as u64).to_be_bytes().to_vec(),
            Self::F32 => (number as f32).to_be_bytes().to_vec(),
            Self::F64 => number.to_be_bytes().to_vec(),
        }
    }
}

/// Attributes that mark points without a value.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Missing {
    None,
    Fill,
    Values,
    Range,
    Least,
    Most,
    /// Limits of the values, as floats beside integers.
    RangeOfValues,
}

/// Stored numbers marked by these attributes.
const HOLES: [f64; 2] = [120.0, 3.0];

/// Order of the dimensions, and the way in which the file gives the order y, x.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Order {
    XThenY,
    Labels,
    Nexus,
    Lengths,
}

#[derive(Clone, Debug)]
struct Case {
    points: [usize; 2],
    kind: Kind,
    factor: Option<f64>,
    offset: Option<f64>,
    missing: Missing,
    unit: &'static str,
    unit_of_coordinates: &'static str,
    steps: [f64; 2],
    single_coordinates: bool,
    order: Order,
    /// Stored numbers at `[x, y]`, with x and y in the direction of the file.
    numbers: Vec<f64>,
}

impl Case {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed);
        let kind = random.pick(&KINDS);
        let is_packed = !kind.is_float() || random.coin();
        let bare = !is_packed && random.coin();
        let whole = !is_packed;
        let points = [2 + random.below(9), 2 + random.below(9)];
        let missing = [
            Missing::None,
            Missing::Fill,
            Missing::Values,
            Missing::Range,
            Missing::Least,
            Missing::Most,
            Missing::RangeOfValues,
        ];
        let mut missing = random.pick(&missing);
        if missing == Missing::RangeOfValues && (kind.is_float() || whole) {
            missing = Missing::Range;
        }
        let orders = [Order::XThenY, Order::Labels, Order::Nexus, Order::Lengths];
        let mut order = random.pick(&orders);
        if order == Order::Lengths && points[0] == points[1] {
            order = Order::Nexus;
        }
        let step = |random: &mut Random| random.pick(&[0.5, 0.1, 2e-7]) * random.pick(&[1.0, -1.0]);
        let steps = [step(&mut random), step(&mut random)];
        let low = if kind.is_signed() { -100 } else { 10 };
        let mut number = || f64::from(low + random.below((100 - low) as usize) as i32);
        let mut numbers: Vec<f64> = (0..points[0] * points[1]).map(|_| number()).collect();
        // Only the number that is a hole in all dialects may be one.
        numbers.iter_mut().filter(|number| HOLES.contains(*number)).for_each(|number| *number += 1.0);
        if missing != Missing::None {
            let at = random.below(numbers.len());
            numbers[at] = if missing == Missing::Least { HOLES[1] } else { HOLES[0] };
            if missing == Missing::Least {
                // All others are larger.
                let least = HOLES[1] + 1.0;
                numbers.iter_mut().enumerate().for_each(|(k, z)| {
                    if k != at && *z < least {
                        *z = 50.0
                    }
                });
            }
        }
        let units = ["m", "µm", "nm", "Å"];
        // One of the two is enough to give the scale.
        let has_factor = is_packed && (random.coin() || random.coin());
        Self {
            points,
            kind,
            factor: has_factor.then(|| random.pick(&[2e-9, 0.25, -3.0])),
            offset: (is_packed && (!has_factor || random.coin())).then(|| random.pick(&[1e-6, -7.0])),
            missing,
            unit: if bare { "" } else { random.pick(&units) },
            unit_of_coordinates: if bare { "" } else { random.pick(&units) },
            steps,
            single_coordinates: random.coin(),
            order,
            numbers,
        }
    }

    fn value(&self, number: f64) -> f64 {
        if HOLES.contains(&number) {
            return f64::NAN;
        }
        number * self.factor.unwrap_or(1.0) + self.offset.unwrap_or(0.0)
    }

    /// Returns the attributes of the heights: name, numbers, and true if they are of the stored type.
    fn attributes(&self) -> Vec<(&'static str, Vec<f64>, bool)> {
        let mut found = Vec::new();
        found.extend(self.factor.map(|factor| ("scale_factor", vec![factor], false)));
        found.extend(self.offset.map(|offset| ("add_offset", vec![offset], false)));
        let limits = [-110.0, 110.0].map(|limit: f64| if self.kind.is_signed() { limit } else { limit.max(0.0) });
        match self.missing {
            Missing::None => {}
            Missing::Fill => found.push(("_FillValue", vec![HOLES[0]], true)),
            Missing::Values => found.push(("missing_value", HOLES.to_vec(), true)),
            Missing::Range => found.push(("valid_range", limits.to_vec(), true)),
            Missing::Least => found.push(("valid_min", vec![HOLES[1] + 1.0], true)),
            Missing::Most => found.push(("valid_max", vec![limits[1]], true)),
            Missing::RangeOfValues => {
                let unpack = |z: f64| z * self.factor.unwrap_or(1.0) + self.offset.unwrap_or(0.0);
                let mut limits = limits.map(unpack);
                limits.sort_by(f64::total_cmp);
                found.push(("valid_range", limits.to_vec(), false));
            }
        }
        found
    }

    fn is_transposed(&self) -> bool {
        self.order != Order::XThenY
    }

    /// Returns the numbers in file order, and the numbers of rows and columns.
    fn rows(&self) -> (Vec<f64>, [usize; 2]) {
        let [nx, ny] = self.points;
        if !self.is_transposed() {
            return (self.numbers.clone(), [nx, ny]);
        }
        let at = |row: usize, column: usize| self.numbers[column * ny + row];
        ((0..ny).flat_map(|row| (0..nx).map(move |column| at(row, column))).collect(), [ny, nx])
    }

    fn coordinates(&self, axis: usize) -> Vec<f64> {
        (0..self.points[axis]).map(|k| 3.0 * self.steps[axis].abs() + self.steps[axis] * k as f64).collect()
    }

    /// Compares a map with the values of the case.
    fn check(&self, what: &str, map: &Topography) {
        let [nx, ny] = self.points;
        assert_eq!(map.heights.dim(), (nx, ny), "{what}: {self:?}");
        let metres = |unit: &str| match unit {
            "m" => 1.0,
            "µm" => 1e-6,
            "nm" => 1e-9,
            "Å" => 1e-10,
            _ => f64::NAN,
        };
        let factor = if self.unit.is_empty() { 1.0 } else { metres(self.unit) / metres(self.unit_of_coordinates) };
        for ((i, j), &found) in map.heights.indexed_iter() {
            let i = if self.steps[0] < 0.0 { nx - 1 - i } else { i };
            let j = if self.steps[1] < 0.0 { ny - 1 - j } else { j };
            let expected = self.value(self.numbers[i * ny + j]) * factor;
            let is_same = (found - expected).abs() <= 4e-15 * expected.abs() || (found.is_nan() && expected.is_nan());
            assert!(is_same, "{what} at {i}, {j}: {found}, not {expected}: {self:?}");
        }
        let holes = self.numbers.iter().filter(|number| self.value(**number).is_nan()).count();
        assert_eq!(map.undefined, holes, "{what}: {self:?}");
        let lengths = map.lengths.unwrap_or_else(|| panic!("{what} has no size: {self:?}"));
        for axis in [0, 1] {
            let expected = self.points[axis] as f64 * self.steps[axis].abs();
            assert!((lengths[axis] / expected - 1.0).abs() < 1e-5, "{what}: {lengths:?}, {self:?}");
        }
        let unit = Some(self.unit_of_coordinates).filter(|unit| !unit.is_empty());
        assert_eq!(map.unit.as_deref(), unit, "{what}: {self:?}");
    }
}

fn text(text: &str) -> VarLenUnicode {
    VarLenUnicode::from_str(text).unwrap()
}

fn unit(dataset: &Dataset, unit: &str) {
    if !unit.is_empty() {
        dataset.new_attr::<VarLenUnicode>().create("units").unwrap().write_scalar(&text(unit)).unwrap();
    }
}

fn numbers<T: H5Type>(dataset: &Dataset, name: &str, values: &[T]) {
    match values {
        [one] => dataset.new_attr::<T>().create(name).unwrap().write_scalar(one).unwrap(),
        several => dataset.new_attr::<T>().shape(several.len()).create(name).unwrap().write_raw(several).unwrap(),
    }
}

/// Creates a dataset.
fn create<T: H5Type>(group: &Group, name: &str, shape: &[usize], values: &[T]) -> Dataset {
    let dataset = group.new_dataset::<T>().shape(shape.to_vec()).create(name).unwrap();
    dataset.write_raw(values).unwrap();
    dataset
}

/// Writes the heights with their attributes.
fn write<T: H5Type + Copy>(group: &Group, name: &str, case: &Case, storage: usize, cast: impl Fn(f64) -> T) -> Dataset {
    let (rows, shape) = case.rows();
    let rows: Vec<T> = rows.into_iter().map(&cast).collect();
    let builder = group.new_dataset::<T>().shape(shape);
    let builder = match storage {
        0 => builder,
        1 => builder.chunk((1, shape[1])),
        2 => builder.chunk((2, 2)).shuffle().deflate(4),
        _ => builder.chunk((shape[0], 1)).fletcher32(),
    };
    let dataset = builder.create(name).unwrap();
    dataset.write_raw(&rows).unwrap();
    for (name, values, is_stored) in case.attributes() {
        match is_stored {
            true => numbers(&dataset, name, &values.into_iter().map(&cast).collect::<Vec<T>>()),
            false => numbers(&dataset, name, &values),
        }
    }
    dataset
}

/// Writes the case as HDF5, with another dataset that is not a height.
fn hdf5(case: &Case, path: &std::path::Path, random: &mut Random) {
    let file = hdf5::File::create(path).unwrap();
    let (group, name) = match random.coin() {
        true => (file.create_group("entry").unwrap().create_group("data").unwrap(), "z"),
        false => (file.create_group("scan").unwrap(), "heights"),
    };
    let storage = random.below(4);
    macro_rules! of {
        ($($kind:ident $type:ty),*) => {
            match case.kind { $(Kind::$kind => write(&group, name, case, storage, |z| z as $type),)* }
        };
    }
    let dataset = of!(I8 i8, U8 u8, I16 i16, U16 u16, I32 i32, U32 u32, I64 i64, U64 u64, F32 f32, F64 f64);
    unit(&dataset, case.unit);
    for (axis, name) in ["x", "y"].into_iter().enumerate() {
        let values = case.coordinates(axis);
        let coordinate = if case.single_coordinates {
            let values: Vec<f32> = values.iter().map(|x| *x as f32).collect();
            create(&group, name, &[values.len()], &values)
        } else {
            create(&group, name, &[values.len()], &values)
        };
        unit(&coordinate, case.unit_of_coordinates);
    }
    let names = [text("y"), text("x")];
    match case.order {
        Order::Labels => numbers(&dataset, "DIMENSION_LABELS", &names),
        Order::Nexus => {
            group.new_attr::<VarLenUnicode>().shape(2).create("axes").unwrap().write_raw(&names).unwrap();
        }
        Order::XThenY | Order::Lengths => {}
    }
    if case.order == Order::XThenY && random.coin() {
        numbers(&dataset, "DIMENSION_LABELS", &[text("x"), text("y")]);
    }
    let phase = create(&group, "a phase", &[2, 2], &[1.0, 2.0, 3.0, 4.0]);
    unit(&phase, "deg");
}

/// Returns the case in the classic NetCDF format, with the dimensions y and x if the order is not x, y.
fn netcdf(case: &Case, version: u8) -> Vec<u8> {
    let count = |value: usize| match version {
        5 => (value as u64).to_be_bytes().to_vec(),
        _ => (value as u32).to_be_bytes().to_vec(),
    };
    let tag = |tag: u32| tag.to_be_bytes().to_vec();
    let padded = |mut bytes: Vec<u8>| {
        bytes.resize(bytes.len().next_multiple_of(4), 0);
        bytes
    };
    let name = |name: &str| [count(name.len()), padded(name.into())].concat();
    let attribute = |key: &str, kind: Kind, values: &[f64]| {
        let bytes = values.iter().flat_map(|value| kind.big_endian(*value)).collect();
        [name(key), tag(kind.code()), count(values.len()), padded(bytes)].concat()
    };
    let units = |unit: &str| [name("units"), tag(2), count(unit.len()), padded(unit.into())].concat();
    let axis = if case.single_coordinates { Kind::F32 } else { Kind::F64 };
    let (rows, shape) = case.rows();
    let heights: Vec<Vec<u8>> = case
        .attributes()
        .into_iter()
        .map(|(key, values, is_stored)| attribute(key, if is_stored { case.kind } else { Kind::F64 }, &values))
        .chain((!case.unit.is_empty()).then(|| units(case.unit)))
        .collect();
    let of_axis: Vec<Vec<u8>> =
        (!case.unit_of_coordinates.is_empty()).then(|| units(case.unit_of_coordinates)).into_iter().collect();
    let names = if case.is_transposed() { ["y", "x"] } else { ["x", "y"] };
    let index = |wanted: &str| usize::from(names[1] == wanted);
    let variables = [
        ("x", vec![index("x")], of_axis.clone(), axis, case.coordinates(0)),
        ("heights", vec![0, 1], heights, case.kind, rows),
        ("y", vec![index("y")], of_axis, axis, case.coordinates(1)),
    ];
    let list = |of: u32, entries: &[Vec<u8>]| match entries.len() {
        0 => [tag(0), count(0)].concat(),
        length => [tag(of), count(length), entries.concat()].concat(),
    };
    let header = |begins: [usize; 3]| {
        let dimensions: Vec<Vec<u8>> = (0..2).map(|k| [name(names[k]), count(shape[k])].concat()).collect();
        let begin = |begin: usize| match version {
            1 => (begin as u32).to_be_bytes().to_vec(),
            _ => (begin as u64).to_be_bytes().to_vec(),
        };
        let described: Vec<Vec<u8>> = variables
            .iter()
            .zip(begins)
            .map(|((own, dims, attributes, kind, values), at)| {
                let ids: Vec<u8> = dims.iter().flat_map(|id| count(*id)).collect();
                let size = (values.len() * kind.big_endian(0.0).len()).next_multiple_of(4);
                let list = list(12, attributes);
                [name(own), count(dims.len()), ids, list, tag(kind.code()), count(size), begin(at)].concat()
            })
            .collect();
        let start = vec![b'C', b'D', b'F', version];
        [start, count(0), list(10, &dimensions), list(12, &[]), list(11, &described)].concat()
    };
    let data: Vec<Vec<u8>> = variables
        .iter()
        .map(|(_, _, _, kind, values)| padded(values.iter().flat_map(|value| kind.big_endian(*value)).collect()))
        .collect();
    let start = header([0; 3]).len();
    let begins = [start, start + data[0].len(), start + data[0].len() + data[1].len()];
    [header(begins), data.concat()].concat()
}

/// Returns the number of random cases, which is larger if `GFMD_LONG` is set.
fn cases() -> u64 {
    if std::env::var_os("GFMD_LONG").is_some() { 5000 } else { 250 }
}

#[test]
fn random_grids_come_back_from_every_dialect_of_hdf5() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grid.h5");
    for seed in 0..cases() {
        let case = Case::new(seed);
        hdf5(&case, &path, &mut Random(!seed));
        let map = Topography::read(path.to_str().unwrap(), None);
        case.check(&format!("HDF5 {seed}"), &map.unwrap_or_else(|error| panic!("{seed}: {error}: {case:?}")));
    }
}

#[test]
fn random_grids_come_back_from_every_dialect_of_netcdf() {
    for seed in 0..cases() {
        let case = Case::new(seed);
        let is_classic = matches!(case.kind, Kind::I8 | Kind::I16 | Kind::I32 | Kind::F32 | Kind::F64);
        for version in [1, 2, 5] {
            if is_classic || version == 5 {
                let map = Topography::from_bytes("grid", netcdf(&case, version), None);
                let map = map.unwrap_or_else(|error| panic!("{seed}: {error}: {case:?}"));
                case.check(&format!("NetCDF-{version} {seed}"), &map);
            }
        }
    }
}

/// Writes a file with `fill` and reads one of its channels.
fn made(fill: impl FnOnce(&hdf5::File), channel: Option<&str>) -> Result<Topography, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("h.h5");
    fill(&hdf5::File::create(&path).unwrap());
    Topography::read(path.to_str().unwrap(), channel).map_err(|error| error.reason)
}

/// Creates a dataset of 2 x 3 integers in a unit.
fn counts(group: &Group, name: &str, in_unit: &str) -> Dataset {
    let dataset = create(group, name, &[2, 3], &[1_i32, 2, 3, 4, 5, 6]);
    unit(&dataset, in_unit);
    dataset
}

#[test]
fn integers_in_a_unit_of_length_need_a_scale() {
    let says = |fill: &dyn Fn(&hdf5::File), words: &str| {
        let found = made(fill, None).unwrap_err();
        assert!(found.contains(words), "{found}");
    };
    says(&|file| drop(counts(file, "z", "m")), "/z has integers in m without a scale that is known; give scale_factor");
    says(
        &|file| numbers(&counts(file, "z", ""), "base_calibration_min", &[1.0]),
        "/z has integers beside the attribute base_calibration_min, which has no meaning that is known",
    );
    says(
        &|file| {
            let group = file.create_group("scan").unwrap();
            counts(&group, "z", "");
            group.new_attr::<f64>().create("z multiplier").unwrap().write_scalar(&1e-9).unwrap();
        },
        "/scan/z has integers and the group /scan the attribute z multiplier: write the heights as floats",
    );
    says(
        &|file| {
            counts(&file.create_group("scan").unwrap(), "z", "");
            file.new_attr::<f64>().create("nm_per_count").unwrap().write_scalar(&0.1).unwrap();
        },
        "/scan/z has integers and the group / the attribute nm_per_count: write the heights as floats",
    );
    let plain = made(|file| drop(counts(file, "z", "")), None).unwrap();
    assert_eq!((plain.heights[[1, 2]], plain.unit), (6.0, None));
    let floats = |file: &hdf5::File| {
        let dataset = create(file, "z", &[2, 2], &[1.0, 2.0, 4.0, 5.0]);
        numbers(&dataset, "gain", &[3.0]);
    };
    assert_eq!(made(floats, None).unwrap().notes, ["the heights are taken as stored, not changed by gain"]);
}

/// Writes JPK channels: the points of a 3 x 2 grid in rows, with two frames.
fn jpk(file: &hdf5::File, multiplier: &str, unit_of_encoder: &str) {
    let measurement = file.create_group("Measurement_000").unwrap();
    for (name, value) in [("ilength", 3.0), ("jlength", 2.0), ("ulength", 3e-6), ("vlength", 4e-6)] {
        let name = format!("position-pattern.grid.{name}");
        measurement.new_attr::<f64>().create(&*name).unwrap().write_scalar(&value).unwrap();
    }
    let channel = measurement.create_group("Channel_000").unwrap();
    let rows: Vec<i32> = (1..7).flat_map(|k| [k, 10 * k]).collect();
    let dataset = create(&channel, "Height", &[6, 2], &rows);
    unit(&dataset, "V");
    for (name, value) in [("multiplier", 2e-9), ("offset", 1e-6)] {
        let name = format!("{multiplier}.scaling.{name}");
        channel.new_attr::<f64>().create(&*name).unwrap().write_scalar(&value).unwrap();
    }
    let name = format!("{multiplier}.scaling.unit.unit");
    channel.new_attr::<VarLenUnicode>().create(&*name).unwrap().write_scalar(&text(unit_of_encoder)).unwrap();
}

#[test]
fn channels_of_jpk_have_the_scale_and_the_grid_of_their_groups() {
    for encoder in ["encoder", "net-encoder"] {
        for (frame, factor) in [("0", 1.0), ("1", 10.0)] {
            let channel = format!("/Measurement_000/Channel_000/Height/{frame}");
            let map = made(|file| jpk(file, encoder, "m"), Some(&channel)).unwrap();
            assert_eq!((map.heights.dim(), map.lengths, map.unit.as_deref()), ((3, 2), Some([3e-6, 4e-6]), Some("m")));
            for ((i, j), found) in map.heights.indexed_iter() {
                let expected = 2e-9 * factor * (3 * j + i + 1) as f64 + 1e-6;
                assert!((found - expected).abs() < 1e-20, "{i} {j}: {found} {expected}");
            }
        }
    }
    let volts = made(|file| jpk(file, "encoder", "V"), None).unwrap_err();
    assert!(volts.starts_with("the unit of the heights is V; it must be a unit of length"), "{volts}");
}

#[test]
fn places_of_points_make_a_grid() {
    let write = |file: &hdf5::File, last: f64, in_unit: &str| {
        // The lines of the picture in their own order, 3 points along x, 2 along y.
        let places = [[2.0, 0.5], [3.0, 0.5], [4.0, 0.5], [4.0, 0.0], [3.0, 0.0], [last, 0.0]];
        let values = create(file, "Position_Values", &[6, 2], places.as_flattened());
        unit(&values, in_unit);
        let dataset = create(file, "Raw_Data", &[6, 1], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        unit(&dataset, "nm");
    };
    let map = made(|file| write(file, 2.0, "nm"), None).unwrap();
    assert_eq!(map.heights, ndarray::array![[6.0, 1.0], [5.0, 2.0], [4.0, 3.0]]);
    assert_eq!((map.lengths, map.unit.as_deref()), (Some([3.0, 1.0]), Some("nm")));
    let unknown = made(|file| write(file, 2.0, ""), None).unwrap();
    assert_eq!((unknown.lengths, unknown.unit.as_deref()), (None, Some("nm")));
    assert!(unknown.notes[0].starts_with("/Position_Values has no unit of length; the size is not read"));
    let twice = made(|file| write(file, 3.0, "nm"), None).unwrap_err();
    assert!(twice.starts_with("/Position_Values has the place [1, 0] twice"), "{twice}");
    let uneven = made(|file| write(file, 2.2, "nm"), None).unwrap_err();
    assert!(uneven.starts_with("/Position_Values has places that are on no lattice"), "{uneven}");
}

#[test]
fn one_of_many_channels_is_the_default() {
    let many = |file: &hdf5::File| {
        let entry = file.create_group("entry").unwrap();
        for k in 0..42 {
            let group = entry.create_group(&format!("channel {k:02}")).unwrap();
            let dataset = create(&group, "data", &[2, 2], &[f64::from(k), 1.0, 2.0, 3.0]);
            unit(&dataset, if k < 5 { "V" } else { "m" });
        }
    };
    let first = made(many, None).unwrap();
    assert_eq!((first.channel.as_deref(), first.heights[[0, 0]]), (Some("/entry/channel 05/data"), 5.0));
    let nexus = |file: &hdf5::File| {
        many(file);
        let say = |group: &Group, name: &str, value: &str| {
            group.new_attr::<VarLenUnicode>().create(name).unwrap().write_scalar(&text(value)).unwrap();
        };
        say(file, "default", "entry");
        let entry = file.group("entry").unwrap();
        say(&entry, "default", "channel 17");
        say(&entry.group("channel 17").unwrap(), "signal", "data");
    };
    assert_eq!(made(nexus, None).unwrap().heights[[0, 0]], 17.0);
    let volts = made(nexus, Some("/entry/channel 02/data")).unwrap_err();
    assert!(volts.starts_with("the unit of the heights is V; it must be a unit of length"), "{volts}");
}
