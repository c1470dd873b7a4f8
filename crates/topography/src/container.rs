//! Containers of contact.engineering: zip archives with `meta.yml` and the data files of several measurements.
//!
//! Every topography is a channel under its name. Its data file, preferably the original and else the NetCDF file, is
//! read in its own format. Sizes, unit and height factor are taken from `meta.yml` where the data file has none.
//! Filters named there (detrending, filling) are not applied.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::bytes::{MOST_CHANNELS, clip};
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::zipped::{MOST_TEXT, Zip};

pub(crate) const FORMAT: Format = Format {
    name: "contact.engineering container",
    sniff: |file| Zip::has(file, &["meta.yml"]),
    open,
    first_line: FirstLine::Bottom,
};

#[derive(Deserialize)]
struct Meta {
    surfaces: Vec<Surface>,
}

#[derive(Deserialize)]
struct Surface {
    name: Option<String>,
    topographies: Vec<Measurement>,
}

#[derive(Clone, Deserialize)]
struct Measurement {
    name: Option<String>,
    datafile: BTreeMap<String, String>,
    #[serde(default)]
    size: Vec<f64>,
    unit: Option<String>,
    height_scale: Option<f64>,
    data_source: Option<usize>,
    is_periodic: Option<bool>,
    measurement_date: Option<String>,
    description: Option<String>,
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let mut zip = Zip::open(file)?;
    let text = String::from_utf8(zip.read("meta.yml", MOST_TEXT)?).map_err(|_| "meta.yml is not text in UTF-8")?;
    let meta: Meta = serde_saphyr::from_str(&text)
        .map_err(|error| format!("meta.yml is damaged: {}", clip(&error.to_string().replace('\n', " "))))?;
    let mut channels = Vec::new();
    for surface in &meta.surfaces {
        for measurement in &surface.topographies {
            if channels.len() == MOST_CHANNELS {
                return Err(format!(
                    "the container has more than {MOST_CHANNELS} measurements; it must have at most so many"
                ));
            }
            let mut channel = measurement.channel(file, &mut zip)?;
            if let (Some(surface), true) = (&surface.name, meta.surfaces.len() > 1) {
                channel.name = format!("{surface}/{}", channel.name);
            }
            channels.push(channel);
        }
    }
    if channels.is_empty() {
        return Err("the container has no topography; it must have one".into());
    }
    let default = channels.iter().position(|channel| channel.points != [0, 0]).or(Some(0));
    Ok(Contents { default, ..channels.into() })
}

/// Opens a data file, which must not be a container.
fn open_inner(file: &File) -> Result<(&'static Format, Contents<'_>), String> {
    if (FORMAT.sniff)(file) {
        return Err("the data file is a container; it must not be one".into());
    }
    super::open(file)
}

impl Measurement {
    /// Lists a measurement as a channel. Its data file is read to list the points, and again to decode them.
    fn channel<'a>(&self, file: &'a File, zip: &mut Zip) -> Result<Channel<'a>, String> {
        let preferred = ["original", "squeezed-netcdf"].iter().find_map(|key| self.datafile.get(*key));
        let entry = preferred.ok_or_else(|| {
            let keys: Vec<&str> = self.datafile.keys().map(String::as_str).collect();
            format!("a topography has the data files {}; it must have original or squeezed-netcdf", keys.join(", "))
        })?;
        let name = self.name.clone().unwrap_or_else(|| entry.clone());
        let listed = zip.whole(entry).and_then(|data| {
            let inner = File::from_bytes(data);
            let (_, contents) = open_inner(&inner)?;
            let channel = &contents.channels[self.choose(&contents, entry)?];
            Ok((channel.points, channel.unit.clone()))
        });
        let (whole, entry) = (self.clone(), entry.clone());
        Ok(match listed {
            Ok((points, unit)) => {
                let unit = unit.or_else(|| self.unit.clone());
                Channel { name, unit, points, read: Box::new(move || whole.read(file, &entry)) }
            }
            // A measurement in an unknown format is listed too, so that the other measurements keep their numbers.
            Err(error) => Channel {
                name,
                unit: self.unit.clone(),
                points: [0, 0],
                read: Box::new(move || Err(format!("{entry}: {error}"))),
            },
        })
    }

    /// Returns the number of the channel in the data file.
    fn choose(&self, contents: &Contents, entry: &str) -> Result<usize, String> {
        let number = self.data_source.or(contents.default).unwrap_or(0);
        match number < contents.channels.len() {
            true => Ok(number),
            false => Err(format!("{entry} has {} channels; the data source is {number}", contents.channels.len())),
        }
    }

    fn read(self, file: &File, entry: &str) -> Result<Map, String> {
        let inner = File::from_bytes(Zip::open(file)?.whole(entry)?);
        let (format, contents) = open_inner(&inner)?;
        let number = self.choose(&contents, entry)?;
        let Some(channel) = contents.channels.into_iter().nth(number) else {
            return Err(format!("{entry} has no channels"));
        };
        let mut map = (channel.read)().map_err(|error| format!("{entry}: {error}"))?;
        format.upright(&mut map);
        map.warnings.extend(contents.warnings);
        map.notes.insert(0, format!("the data file {entry} has the format {}", format.name));
        let (scaled, has_unit) = (map.height_unit.is_some(), map.length_unit.is_some());
        if let Some(factor) = self.height_scale.filter(|factor| *factor != 1.0 && !scaled) {
            map.heights.mapv_inplace(|height| height * factor);
            map.notes.push(format!("heights were multiplied by the height_scale of meta.yml, {factor}"));
        }
        if map.lengths.is_none() {
            map.lengths = match self.size[..] {
                [x] => Some([x, 1.0]),
                [x, y, ..] => Some([x, y]),
                [] => None,
            };
            // The size in meta.yml has its own unit, independent of the unit of the heights in the data file.
            map.length_unit = map.lengths.and(self.unit.clone());
        }
        if !has_unit && !scaled {
            map.length_unit.clone_from(&self.unit);
            map.height_unit.clone_from(&self.unit);
        }
        for (key, value) in [("measurement_date", self.measurement_date), ("description", self.description)] {
            map.details.extend(value.map(|value| (key.to_owned(), value)));
        }
        if self.is_periodic == Some(true) {
            map.details.push(("periodic".into(), "yes".into()));
        }
        Ok(map)
    }
}
