//! Zygo Mx (`.datx`): interferometers of Zygo. The container is HDF5.
//!
//! `/MetaData` is a list of (source, link, destination). The links `Root`, `Measurement`, `Surface`, `Path` lead to the
//! name of the dataset of heights, with rows along x. Its attribute `Unit` is the unit of the heights, `No Data` the
//! value of undefined points, and the second parameter of `X Converter` and `Y Converter` the spacing in metres.

use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map};
use super::records::{Field, records};
use super::shaped;
use crate::stored::Hdf5;

pub(crate) const FORMAT: Format = Format { name: "Zygo Mx", sniff, open, first_line: FirstLine::Top };

/// Names of units in these files.
const UNITS: [(&str, &str); 4] = [("NanoMeters", "nm"), ("MicroMeters", "µm"), ("MilliMeters", "mm"), ("Meters", "m")];

fn sniff(file: &File) -> bool {
    file.is_hdf5() && file.hdf5().is_ok_and(|reader| reader.contains("/MetaData"))
}

fn open(file: &File) -> Result<Contents<'_>, String> {
    let reader = file.hdf5()?;
    let links = records(&reader, "/MetaData", None)?;
    let mut path = "Root".to_owned();
    for link in ["Measurement", "Surface", "Path"] {
        path = follow(&links, &path, link)?;
    }
    let shape = reader.shape(&path)?;
    let [rows, columns] = shape[..] else {
        return Err(format!("the shape of {path} is {shape:?}; it must have 2 dimensions"));
    };
    let points = [columns, rows];
    let unit = unit(&reader.text(&path, "Unit")?);
    let name = path.rsplit('/').nth(1).unwrap_or_default().to_owned();
    let height_unit = unit.clone();
    let read = move || read(&file.hdf5()?, &path, points, height_unit);
    Ok(Channel { name, unit: Some(unit), points, read: Box::new(read) }.into())
}

/// Returns the destination of a link.
fn follow(links: &[Vec<Field>], from: &str, name: &str) -> Result<String, String> {
    let text = |field: &Field, wanted: &str| matches!(field, Field::Text(text) if text == wanted);
    let found = links.iter().rev().find_map(|link| match &link[..] {
        [source, link, Field::Text(destination)] if text(source, from) && text(link, name) => Some(destination.clone()),
        _ => None,
    });
    found.ok_or_else(|| format!("/MetaData has no link {name}; it must lead from Root to a surface"))
}

fn unit(name: &str) -> String {
    UNITS.iter().find(|(known, _)| *known == name).map_or(name, |(_, unit)| unit).to_owned()
}

fn read(reader: &Hdf5, path: &str, points: [usize; 2], unit: String) -> Result<Map, String> {
    let dx = spacing(reader, path, "X Converter")?;
    let dy = spacing(reader, path, "Y Converter")?;
    let converter = converter(reader, path, "Z Converter")?;
    if self::unit(&converter.1) != unit || converter.0 != "HeightCat" {
        return Err(format!(
            "the heights are {} in {} and {unit}; they must be HeightCat in one unit",
            converter.0, converter.1
        ));
    }
    let undefined = reader.number_if_any(path, "No Data")?.unwrap_or(f64::NAN);
    let values = reader.values(path)?;
    let [nx, ny] = points;
    let rows = shaped([ny, nx], values)?;
    let mut heights = rows.reversed_axes();
    heights.mapv_inplace(|height| if height == undefined { f64::NAN } else { height });
    Ok(Map {
        heights,
        lengths: Some([dx * nx as f64, if ny == 1 { 1.0 } else { dy * ny as f64 }]),
        length_unit: Some("m".into()),
        height_unit: Some(unit),
        ..Map::default()
    })
}

/// Reads the category, unit and parameters of a converter.
fn converter(reader: &Hdf5, path: &str, name: &str) -> Result<(String, String, Vec<f64>), String> {
    let records = records(reader, path, Some(name))?;
    match records.into_iter().next().as_deref() {
        Some([Field::Text(category), Field::Text(unit), .., Field::Numbers(parameters)]) => {
            Ok((category.clone(), unit.clone(), parameters.clone()))
        }
        found => Err(format!("{name} is {found:?}; it must have a category, a unit and parameters")),
    }
}

/// Returns the spacing of the points in metres.
fn spacing(reader: &Hdf5, path: &str, name: &str) -> Result<f64, String> {
    match converter(reader, path, name)? {
        (category, unit, parameters) if category == "LateralCat" && unit == "Pixels" && parameters.len() > 1 => {
            Ok(parameters[1])
        }
        other => Err(format!("{name} is {other:?}; it must be LateralCat in Pixels with a spacing")),
    }
}
