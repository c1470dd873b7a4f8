//! [docs]: crate
#![doc = include_str!("../README.md")]
//!
//! Heights are returned as `[x, y]`, a 1-D array as `[n, 1]`: x to the right, y up, heights up, in the unit of the
//! lengths.
//!
//! Formats that need other crates are features, all enabled by default: `hdf5` for HDF5, NetCDF-4 and datx (read in
//! Rust), `zip` for X3P, plux, containers, NumPy archives, Keyence, Olympus OIR and Excel, `zlib` for MATLAB, Digital
//! Surf, MountainsMap, PNG and gzip, both of them for TIFF, JPK, Park and LEXT. Files of disabled formats are not
//! recognised.
//!
//! A format is a file in this folder with a constant `FORMAT`, and a line in `FORMATS`.

#![cfg_attr(not(test), warn(clippy::cast_possible_truncation, clippy::cast_sign_loss))]
#![cfg_attr(
    not(all(feature = "hdf5", feature = "zip", feature = "zlib")),
    allow(dead_code, reason = "parts that only some formats need")
)]

mod al3d;
#[cfg(feature = "hdf5")]
mod archived;
mod array;
#[cfg(feature = "zip")]
mod arrays;
mod bcr;
mod bytes;
mod checksum;
#[cfg(feature = "zip")]
mod container;
mod coordinates;
#[cfg(feature = "hdf5")]
mod datx;
mod file;
mod foreign;
mod format;
mod frt;
mod gwyddion;
#[cfg(feature = "zlib")]
mod gzip;
mod ibw;
pub mod input;
pub mod legible;
#[cfg(feature = "zlib")]
mod matlab;
mod matrix;
mod mdt;
mod mesh;
mod metropro;
mod mi;
#[cfg(feature = "zlib")]
mod mnt;
mod nanoscope;
mod nanosurf;
mod netcdf;
mod nms;
pub mod npy;
#[cfg(feature = "zip")]
mod oir;
mod opd;
mod opdx;
mod os3d;
mod packing;
mod plu;
#[cfg(feature = "zip")]
mod plux;
#[cfg(feature = "zlib")]
mod png;
#[cfg(feature = "hdf5")]
mod records;
mod sdf;
mod sentinel;
mod smd;
#[cfg(feature = "hdf5")]
#[doc(hidden)]
pub mod stored;
#[cfg(feature = "zlib")]
mod sur;
mod surfer;
mod sxm;
#[cfg(all(feature = "zip", feature = "zlib"))]
mod tiff;
mod tmd;
pub mod unit;
#[cfg(feature = "zip")]
mod vk;
mod wsxm;
#[cfg(feature = "zip")]
mod x3p;
#[cfg(feature = "zip")]
mod xlsx;
#[cfg(feature = "zip")]
mod zipped;
mod zmg;
#[cfg(feature = "zip")]
mod zon;

#[cfg(all(test, feature = "hdf5", feature = "zip", feature = "zlib"))]
mod tests;

use ndarray::{Array2, ArrayViewD};

use crate::legible::line;
use file::File;
use format::{Channel, Contents, Format, Map};
use unit::Conversion;

pub use checksum::Checksum;
pub use coordinates::{CONSISTENT as CONSISTENT_UNITS, lengths as cell_lengths, split as split_dataset};
pub use input::Input;
#[cfg(feature = "hdf5")]
pub use stored::Number;

/// Formats in the order in which they are tried. Text comes last, since any text may be a matrix.
static FORMATS: &[Format] = &[
    array::FORMAT,
    #[cfg(feature = "zip")]
    arrays::FORMAT,
    #[cfg(feature = "zip")]
    x3p::FORMAT,
    #[cfg(feature = "zip")]
    plux::FORMAT,
    #[cfg(feature = "zip")]
    container::FORMAT,
    #[cfg(feature = "hdf5")]
    datx::FORMAT,
    #[cfg(feature = "hdf5")]
    archived::FORMAT,
    netcdf::FORMAT,
    #[cfg(feature = "zlib")]
    matlab::FORMAT,
    gwyddion::GWY,
    gwyddion::GSF,
    #[cfg(feature = "zlib")]
    sur::FORMAT,
    nanoscope::FORMAT,
    opd::FORMAT,
    opdx::FORMAT,
    al3d::FORMAT,
    metropro::FORMAT,
    nanosurf::FORMAT,
    mi::FORMAT,
    plu::FORMAT,
    ibw::FORMAT,
    sdf::FORMAT,
    #[cfg(all(feature = "zip", feature = "zlib"))]
    tiff::park::FORMAT,
    #[cfg(all(feature = "zip", feature = "zlib"))]
    tiff::jpk::FORMAT,
    #[cfg(all(feature = "zip", feature = "zlib"))]
    tiff::lext::FORMAT,
    #[cfg(all(feature = "zip", feature = "zlib"))]
    tiff::plain::FORMAT,
    #[cfg(feature = "zip")]
    vk::FORMAT,
    #[cfg(feature = "zip")]
    zon::FORMAT,
    #[cfg(feature = "zlib")]
    gzip::FORMAT,
    #[cfg(feature = "zlib")]
    png::FORMAT,
    mesh::STL,
    mesh::PLY,
    smd::FORMAT,
    #[cfg(feature = "zip")]
    oir::FORMAT,
    #[cfg(feature = "zlib")]
    mnt::FORMAT,
    #[cfg(feature = "zip")]
    xlsx::FORMAT,
    tmd::FORMAT,
    nms::FORMAT,
    os3d::FORMAT,
    zmg::FORMAT,
    bcr::FORMAT,
    frt::FORMAT,
    wsxm::FORMAT,
    sxm::FORMAT,
    mdt::FORMAT,
    surfer::FORMAT,
    matrix::FORMAT,
];

/// Largest number of points of a height map, 8 GiB of heights. A header with more is damaged.
const MOST_POINTS: usize = 1 << 30;

/// Number of channels listed in a message.
const LISTED: usize = 20;

/// Height map with the information in its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Topography {
    /// Heights `[x, y]` in `unit`, row-major; NaN at undefined points.
    pub heights: Array2<f64>,
    /// Number of points without a height.
    pub undefined: usize,
    /// Size of the scanned field along x and y in `unit`, n times the spacing, if given in the file. The second size of
    /// a profile is 1 and has no meaning.
    pub lengths: Option<[f64; 2]>,
    /// Unit of heights and lengths, if given in the file.
    pub unit: Option<String>,
    /// Name of the format.
    pub format: &'static str,
    /// Name of the channel, if given in the file. Names, units and notes are sanitised to one legible line.
    pub channel: Option<String>,
    /// Names of all height maps in the file, or their numbers where they have no names.
    pub channels: Vec<String>,
    /// Conversion of the heights to the unit of the lengths, with its factor, if the units in the file differ.
    pub conversion: Option<String>,
    /// Details of the instrument and measurement: key and value.
    pub details: Vec<(String, String)>,
    /// Notes on this file.
    pub notes: Vec<String>,
    /// Warnings about the file: header lines that are not used, wrong checksums, heights that may denote missing
    /// points or be damaged.
    pub warnings: Vec<String>,
    /// Description of file and channel.
    pub source: String,
    /// SHA-256 of the bytes that were read for the heights.
    pub sha256: String,
}

/// Height maps in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Listing {
    /// Name of the format.
    pub format: &'static str,
    /// Height maps in file order.
    pub channels: Vec<ListedChannel>,
    /// Channel read if none is named, if any.
    pub default: Option<usize>,
}

/// Height map in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ListedChannel {
    /// Name, or the number of the channel if it has none.
    pub name: String,
    /// Unit of the heights.
    pub unit: Option<String>,
    /// Number of points along x and y.
    pub points: [usize; 2],
}

/// Error of reading a topography: one line that starts with the file name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}", line(&format!("{file}: {reason}")))]
pub struct TopographyError {
    /// Name of the file as given by the caller.
    pub file: String,
    /// Description of the error, with the value found and the allowed values.
    pub reason: String,
}

/// Choices of a reader.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading<'a> {
    /// Name of the channel, or its number from 0; `None` for the default of the file.
    pub channel: Option<&'a str>,
    /// True if grey numbers of 8 bits in an image are heights, which are otherwise refused: most such images are
    /// pictures.
    pub image_heights: bool,
}

impl Topography {
    /// Reads a channel of the file `name`, in one of the formats in `docs/formats.md`.
    ///
    /// A channel is given by its name or its number from 0; without one, the default of the file is read.
    /// `FILE.h5:/dataset` names file and channel.
    ///
    /// # Errors
    /// A file that cannot be read or has another format; a channel that does not exist.
    pub fn read(name: &str, channel: Option<&str>) -> Result<Self, TopographyError> {
        Self::read_as(name, Reading { channel, ..Reading::default() })
    }

    /// Reads a channel of the file `name` as [`read`](Self::read) does, with other choices.
    ///
    /// # Errors
    /// The errors of [`read`](Self::read).
    pub fn read_as(name: &str, Reading { channel, image_heights }: Reading) -> Result<Self, TopographyError> {
        let fail = |reason| TopographyError { file: name.into(), reason };
        let (path, dataset) = coordinates::split(name).unwrap_or((name, ""));
        let channel = match (dataset, channel) {
            ("", channel) => channel,
            (dataset, None) => Some(dataset),
            (dataset, Some(channel)) => {
                return Err(fail(format!("both {dataset} and the channel {channel} are named; only one must be")));
            }
        };
        let decode = |file: File| Self::decode(&file, name, channel).map_err(|reason| file.cause(reason));
        let file = File::open(path).map(|file| file.with_image_heights(image_heights));
        file.and_then(decode).map_err(fail)
    }

    /// Reads a channel of a file from its bytes in memory; `name` is used in messages.
    ///
    /// # Errors
    /// The errors of [`Topography::read`].
    pub fn from_bytes(name: &str, bytes: Vec<u8>, channel: Option<&str>) -> Result<Self, TopographyError> {
        Self::from_bytes_as(name, bytes, Reading { channel, ..Reading::default() })
    }

    /// Reads a channel of a file from its bytes in memory as [`from_bytes`](Self::from_bytes) does, with other choices.
    ///
    /// # Errors
    /// The errors of [`Topography::read`].
    pub fn from_bytes_as(
        name: &str,
        bytes: Vec<u8>,
        Reading { channel, image_heights }: Reading,
    ) -> Result<Self, TopographyError> {
        let fail = |reason| TopographyError { file: name.into(), reason };
        Self::decode(&File::from_bytes(bytes).with_image_heights(image_heights), name, channel).map_err(fail)
    }

    /// Creates a topography from an array in memory, `[x, y]`, or `[x]` for a profile, undefined where heights are not
    /// finite. `name` is used in messages; the SHA-256 is computed from the numbers.
    ///
    /// # Errors
    /// An array of another shape.
    pub fn of_array(name: &str, array: &ArrayViewD<f64>) -> Result<Self, TopographyError> {
        let heights = two_dimensional(array.shape()).and_then(|points| shaped(points, array.iter().copied().collect()));
        let heights = heights.map_err(|reason| TopographyError { file: name.into(), reason })?;
        let sha256 = Checksum::of_numbers(heights.iter().copied());
        let mut map = Map { heights, ..Map::default() };
        Ok(Self {
            undefined: map.undefine(),
            warnings: sentinel::warning(&map.heights, None).into_iter().collect(),
            heights: map.heights,
            lengths: None,
            unit: None,
            format: "array",
            channel: None,
            channels: Vec::new(),
            conversion: None,
            details: Vec::new(),
            notes: Vec::new(),
            source: "array".into(),
            sha256,
        })
    }

    /// Lists the height maps of a file without decoding them.
    ///
    /// # Errors
    /// A file that cannot be read or has an unknown format.
    pub fn list(name: &str) -> Result<Listing, TopographyError> {
        let fail = |reason| TopographyError { file: name.into(), reason };
        let (path, _) = coordinates::split(name).unwrap_or((name, ""));
        File::open(path).and_then(|file| Listing::of(&file.with_image_heights(true))).map_err(fail)
    }

    /// Returns an error with the number of undefined points and the first of them, if any.
    ///
    /// # Errors
    /// Undefined points.
    pub fn check_complete(&self) -> Result<(), TopographyError> {
        let mut missing = self.heights.indexed_iter().filter(|(_, h)| !h.is_finite());
        let Some(((i, j), _)) = missing.next() else { return Ok(()) };
        let [count, points] = [1 + missing.count(), self.heights.len()];
        let reason = format!(
            "{count} of {points} points are undefined, the first at [x, y] = [{i}, {j}]; every point must have a height"
        );
        Err(TopographyError { file: self.source.clone(), reason })
    }

    fn decode(file: &File, name: &str, asked: Option<&str>) -> Result<Self, String> {
        let (format, contents) = open(file)?;
        let names = names(&contents.channels);
        let number = choose(&contents, &names, asked)?;
        let mut warnings: Vec<String> = contents.warnings.iter().map(|warning| line(warning)).collect();
        let Some(channel) = contents.channels.into_iter().nth(number) else {
            return Err("the file holds no height map".into());
        };
        let [nx, ny] = channel.points;
        if nx.checked_mul(ny).is_none_or(|points| points > MOST_POINTS) {
            return Err(format!("the grid is {nx} x {ny} points; it must have at most {MOST_POINTS}"));
        }
        let named = Some(line(&channel.name)).filter(|name| !name.is_empty());
        let mut map = (channel.read)()?;
        format.upright(&mut map);
        if map.heights.is_empty() {
            return Err(format!("the grid is {nx} x {ny} points; it must have at least one point"));
        }
        warnings.extend(map.warnings.iter().map(|warning| line(warning)));
        warnings.extend(sentinel::warning(&map.heights, map.height_unit.as_deref()));
        let conversion = map.convert()?;
        if let Some([x, y]) = map.lengths.filter(|lengths| !lengths.iter().all(|l| l.is_finite() && *l > 0.0)) {
            return Err(format!("the size is {x} by {y}; it must be positive and finite"));
        }
        let undefined = map.undefine();
        let source = match &named {
            Some(channel) if !name.ends_with(&format!(":{channel}")) => format!("{name}, channel {channel}"),
            _ => name.into(),
        };
        Ok(Self {
            heights: map.heights.as_standard_layout().into_owned(),
            undefined,
            lengths: map.lengths,
            unit: map.height_unit,
            format: format.name,
            channel: named,
            channels: names,
            conversion,
            details: map.details,
            notes: map.notes.iter().map(|note| line(note)).collect(),
            warnings,
            source,
            sha256: file.checksum()?,
        })
    }
}

impl Listing {
    /// Lists the height maps of a file from its bytes in memory; `name` is used in messages.
    ///
    /// # Errors
    /// An unknown format.
    pub fn from_bytes(name: &str, bytes: Vec<u8>) -> Result<Self, TopographyError> {
        let file = File::from_bytes(bytes).with_image_heights(true);
        Self::of(&file).map_err(|reason| TopographyError { file: name.into(), reason })
    }

    fn of(file: &File) -> Result<Self, String> {
        let (format, contents) = open(file)?;
        let names = names(&contents.channels);
        let listed = |(channel, name): (&Channel, String)| ListedChannel {
            name,
            unit: channel.unit.as_deref().map(|unit| line(unit::canonical(unit))),
            points: channel.points,
        };
        let channels = contents.channels.iter().zip(names).map(listed).collect();
        Ok(Self { format: format.name, channels, default: contents.default })
    }
}

impl Map {
    /// Converts the heights to the unit of the lengths. Returns the conversion in words, if any.
    fn convert(&mut self) -> Result<Option<String>, String> {
        let canonical = |unit: &mut Option<String>| {
            *unit = unit.take().map(|unit| line(unit::canonical(&unit))).filter(|unit| !unit.is_empty());
        };
        canonical(&mut self.length_unit);
        canonical(&mut self.height_unit);
        for (what, unit) in [("heights", &self.height_unit), ("lengths", &self.length_unit)] {
            if let Some(unit) = unit.as_ref().filter(|unit| !unit::is_length(unit)) {
                return Err(format!(
                    "the unit of the {what} is {unit}; it must be a unit of length: m, mm, µm, nm, ..."
                ));
            }
        }
        match (&self.height_unit, &self.length_unit) {
            (Some(heights), Some(lengths)) => {
                let Some(conversion) = Conversion::between(heights, lengths)? else { return Ok(None) };
                self.heights.mapv_inplace(|height| conversion.apply(height));
                self.height_unit.clone_from(&self.length_unit);
                Ok(Some(format!("heights converted {conversion}")))
            }
            (None, Some(lengths)) if self.lengths.is_some() => Err(format!(
                "the unit of the lengths is {lengths} but the heights have no unit; both or neither must have one"
            )),
            (Some(heights), None) if self.lengths.is_some() => Err(format!(
                "the unit of the heights is {heights} but the lengths have no unit; both or neither must have one"
            )),
            _ => Ok(None),
        }
    }

    /// Sets heights that are not finite to NaN. Returns their number.
    fn undefine(&mut self) -> usize {
        let mut count = 0;
        for height in self.heights.iter_mut().filter(|height| !height.is_finite()) {
            *height = f64::NAN;
            count += 1;
        }
        count
    }
}

/// Finds the format of a file and its channels.
fn open(file: &File) -> Result<(&'static Format, Contents<'_>), String> {
    if file.head().is_empty() {
        return Err("the file is empty; it must have at least one point".into());
    }
    match FORMATS.iter().find(|format| (format.sniff)(file)) {
        Some(format) if format.name != matrix::FORMAT.name => Ok((format, (format.open)(file)?)),
        found => match (foreign::refusal(file), found) {
            (Some(refusal), _) => Err(refusal),
            (None, Some(format)) => Ok((format, (format.open)(file)?)),
            (None, None) => {
                Err("the format is unknown; docs/formats.md lists those that are read; text, X3P or .npy is a \
                                 way from any program"
                    .into())
            }
        },
    }
}

/// Returns the names of channels, or their numbers where they have none.
fn names(channels: &[Channel]) -> Vec<String> {
    let name = |(number, channel): (usize, &Channel)| match channel.name.as_str() {
        "" => number.to_string(),
        name => line(name),
    };
    channels.iter().enumerate().map(name).collect()
}

/// Returns the number of the channel with the name or number `asked`. A name takes precedence over a number.
fn choose(contents: &Contents, names: &[String], asked: Option<&str>) -> Result<usize, String> {
    let listed = || {
        let numbered = |(number, name): (usize, &String)| {
            let listed = if *name == number.to_string() { name.clone() } else { format!("{number} {name}") };
            let alias = contents.aliases.iter().find(|(of, _)| *of == number);
            alias.map_or(listed.clone(), |(_, alias)| format!("{listed} ({})", line(alias)))
        };
        let first: Vec<String> = names.iter().enumerate().take(LISTED).map(numbered).collect();
        let rest = names.len().saturating_sub(LISTED);
        first.join(", ") + &if rest > 0 { format!(" and {rest} more") } else { String::new() }
    };
    let Some(asked) = asked else {
        return contents.default.ok_or_else(|| format!("no channel is named; it must be one of {}", listed()));
    };
    let asked = &line(asked);
    let same = |name: &String| name.trim_start_matches('/') == asked.trim_start_matches('/');
    let with = |has: &dyn Fn(&String) -> bool| -> Vec<usize> { (0..names.len()).filter(|k| has(&names[*k])).collect() };
    let mut by_name = with(&|name| name == asked);
    if by_name.is_empty() {
        by_name = with(&same);
    }
    if by_name.is_empty() {
        let same = |alias: &String| line(alias).eq_ignore_ascii_case(asked);
        by_name = contents.aliases.iter().filter(|(_, alias)| same(alias)).map(|(number, _)| *number).collect();
    }
    if by_name.is_empty() {
        by_name = with(&|name| name.eq_ignore_ascii_case(asked));
    }
    let by_number = asked.parse().ok().filter(|&number: &usize| number < names.len());
    if by_name.is_empty() && by_number.is_none() {
        // The last parts of a path.
        let end = format!("/{}", asked.trim_start_matches('/')).to_lowercase();
        by_name = with(&|name| name.to_lowercase().ends_with(&end));
    }
    if by_name.is_empty() && by_number.is_none() {
        // Programs show `HeightRetrace` as "Height Retrace", and `Z_fwd` as "Z fwd".
        let wanted = letters(asked);
        let same = |name: &str| !wanted.is_empty() && letters(name) == wanted;
        let aliases = contents.aliases.iter().filter(|(_, alias)| same(alias)).map(|(number, _)| *number);
        by_name = aliases.chain(with(&|name| same(name))).collect();
        by_name.sort_unstable();
        by_name.dedup();
    }
    if let [_, _, ..] = by_name[..] {
        let numbers: Vec<String> = by_name.iter().take(LISTED).map(usize::to_string).collect();
        let (numbers, count) = (numbers.join(", "), by_name.len());
        return Err(format!(
            "{count} channels have the name {asked}; the channel must be one of the numbers {numbers}"
        ));
    }
    by_name
        .first()
        .copied()
        .or(by_number)
        .ok_or_else(|| format!("the channel is {asked}; it must be one of {}", listed()))
}

/// Returns the letters and digits of a name in lower case.
fn letters(name: &str) -> String {
    name.chars().filter(|letter| letter.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

/// Returns the number of points along x and y of an array of one or two dimensions.
fn two_dimensional(shape: &[usize]) -> Result<[usize; 2], String> {
    match *shape {
        [n] => Ok([n, 1]),
        [1, n] if n > 1 => {
            Err(format!("the shape of the array is [1, {n}]; a profile must have the shape [{n}] or [{n}, 1]"))
        }
        [nx, ny] => Ok([nx, ny]),
        _ => Err(format!("the shape of the array is {shape:?}; it must have 1 or 2 dimensions")),
    }
}

/// Returns the heights of an array `[x, y]`.
fn shaped([nx, ny]: [usize; 2], values: Vec<f64>) -> Result<Array2<f64>, String> {
    let count = values.len();
    Array2::from_shape_vec((nx, ny), values)
        .map_err(|_| format!("the array has {count} values for the shape [{nx}, {ny}]"))
}
