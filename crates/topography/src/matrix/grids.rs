//! Text grids of other programs, recognised by their first line or keys: Esri, Surfer, Wyko, Zygo.

use ndarray::{Array2, Axis};

use super::number::{is_missing, last_digit, number};
use crate::MOST_POINTS;
use crate::bytes::{clip, lines, positive};
use crate::format::{Channel, Map};
use crate::sentinel;

/// Smallest number that Surfer uses for a blank point.
const BLANK: f64 = 1.701_41e38;

/// Largest number of lines searched for the keys of an Esri grid.
const LONGEST_HEAD: usize = 64;

/// Blocks of Wyko that hold heights.
const HEIGHTS: [&str; 5] = ["RAW_DATA", "RAW DATA", "Raw", "OPD", "SAMPLE_DATA"];

/// Returns the height maps of a grid of another program, or `None` for any other text.
///
/// # Errors
/// A grid that is incomplete.
pub(super) fn channels(text: &str) -> Result<Option<Vec<Channel<'static>>>, String> {
    let first = lines(text).map(str::trim).find(|line| !line.is_empty()).unwrap_or_default();
    let word = first.split_whitespace().next().unwrap_or_default().to_ascii_lowercase();
    let mut head =
        lines(text).map(key).take_while(|key| number(key, 0, 0).is_err() || key.is_empty()).take(LONGEST_HEAD);
    let is_esri = head.any(|key| matches!(&*key, "ncols" | "nrows"));
    let one = |name: &str, map: Map| {
        let (unit, points) = (map.height_unit.clone(), map.heights.dim().into());
        vec![Channel { name: name.into(), unit, points, read: Box::new(move || Ok(map)) }]
    };
    Ok(match word.as_str() {
        _ if is_esri => Some(one("", esri(text)?)),
        "dsaa" => Some(one("", surfer(text)?)),
        _ if first.starts_with("Wyko ASCII Data File Format") => Some(wyko(text)?),
        _ if first.starts_with("Zygo XYZ Data File") => Some(one("", zygo(text)?)),
        _ => None,
    })
}

/// Returns the first word of a line, in lower case and without a colon or equals sign at its end.
fn key(line: &str) -> String {
    line.split_whitespace().next().unwrap_or_default().trim_end_matches([':', '=']).to_ascii_lowercase()
}

/// Checks the number of points of a grid, which must not exceed the numbers that the text can hold.
fn points([nx, ny]: [f64; 2], text: &str) -> Result<[usize; 2], String> {
    let most = MOST_POINTS.min(text.len() / 2 + 1) as f64;
    if nx >= 1.0 && ny >= 1.0 && nx.fract() == 0.0 && ny.fract() == 0.0 && nx * ny <= most {
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "whole numbers up to the text's size"
        )]
        return Ok([nx as usize, ny as usize]);
    }
    Err(format!("the grid is {nx} x {ny} points; it must have as many as the file has numbers"))
}

/// Reads a grid of values, lines of constant y, starting at the first word.
fn grid<'a>(words: impl Iterator<Item = &'a str>, [nx, ny]: [usize; 2]) -> Result<Array2<f64>, String> {
    let mut values = Vec::with_capacity(nx * ny);
    for word in words {
        if values.len() == nx * ny {
            return Err(format!("there are more than the {nx} x {ny} heights of the head; as many must be there"));
        }
        values
            .push(number(word, 1 + values.len() / nx, 1 + values.len() % nx).map_err(|error| format!("grid {error}"))?);
    }
    let found = values.len();
    let lines = Array2::from_shape_vec([ny, nx], values);
    lines.map(Array2::reversed_axes).map_err(|_| format!("there are {found} heights; the head says {nx} x {ny}"))
}

/// Reads an Esri grid: keys in any order, then heights starting at the top line.
fn esri(text: &str) -> Result<Map, String> {
    let (mut n, mut cell, mut missing) = ([None; 2], [None; 2], -9999.0);
    let mut rest = text;
    loop {
        let line = lines(rest).next().unwrap_or_default();
        let key = key(line);
        if key.is_empty() && rest.is_empty() || !key.is_empty() && number(&key, 0, 0).is_ok() {
            break;
        }
        if key.is_empty() || key.starts_with(['#', '%', '!', '/', ';']) {
            rest = after(rest, line);
            continue;
        }
        let value = line.split_whitespace().nth(1).unwrap_or_default();
        let value = value.parse().or_else(|_| value.replacen(',', ".", 1).parse());
        let value: f64 = value.map_err(|_| format!("{} has no number in the head; it must have one", clip(&key)))?;
        match key.as_str() {
            "ncols" => n[0] = Some(value),
            "nrows" => n[1] = Some(value),
            "cellsize" => cell = [Some(value); 2],
            "dx" => cell[0] = Some(value),
            "dy" => cell[1] = Some(value),
            "nodata_value" => missing = value,
            "xllcorner" | "xllcenter" | "yllcorner" | "yllcenter" => {}
            _ => return Err(format!("the head of the grid of Esri has the key {:?}, which is not known", clip(&key))),
        }
        rest = after(rest, line);
    }
    let [Some(nx), Some(ny)] = n else {
        return Err("the grid of Esri has no ncols or nrows; it must have both".into());
    };
    let points = points([nx, ny], text)?;
    let [Some(dx), Some(dy)] = cell else { return Err("the grid of Esri has no cellsize; it must have one".into()) };
    let mut heights = grid(rest.split_whitespace(), points)?;
    heights.mapv_inplace(|height| if height == missing { f64::NAN } else { height });
    heights.invert_axis(Axis(1));
    let lengths = Some([positive("cellsize", dx)? * nx, positive("cellsize", dy)? * ny]);
    Ok(Map { heights, lengths, ..Map::default() })
}

/// Returns the text after its first line.
fn after<'a>(text: &'a str, line: &str) -> &'a str {
    let rest = &text[line.len()..];
    rest.strip_prefix("\r\n").or_else(|| rest.get(1..)).unwrap_or_default()
}

/// Reads a Surfer grid: the positions of the first and last points, then heights starting at the bottom line.
fn surfer(text: &str) -> Result<Map, String> {
    let mut words = text.split_whitespace().skip(1);
    let (mut head, mut digits) = ([0.0; 8], [0.0; 8]);
    for (value, digit) in head.iter_mut().zip(&mut digits) {
        let word = words.next().unwrap_or_default();
        *digit = last_digit(word);
        *value =
            word.parse().map_err(|_| format!("the head has {:?}; it must have 8 numbers below DSAA", clip(word)))?;
    }
    let points = points([head[0], head[1]], text)?;
    if points.contains(&1) {
        return Err(format!("the grid is {} x {} points; it must be at least 2 x 2", points[0], points[1]));
    }
    let mut heights = grid(words, points)?;
    heights.mapv_inplace(|height| if height >= BLANK { f64::NAN } else { height });
    let along = |axis: usize, name: &str| {
        let spacing = (head[3 + 2 * axis] - head[2 + 2 * axis]) / (head[axis] - 1.0);
        positive(name, spacing).map(|spacing| spacing * head[axis])
    };
    let lengths = Some([along(0, "the spacing along x")?, along(1, "the spacing along y")?]);
    let warnings = sentinel::outside(&heights, [head[6], head[7]], [digits[6], digits[7]]).into_iter().collect();
    Ok(Map { heights, lengths, warnings, ..Map::default() })
}

/// Reads the blocks of heights of a Wyko text, with lines along y.
fn wyko(text: &str) -> Result<Vec<Channel<'static>>, String> {
    let mut lines = lines(text).filter(|line| !line.trim().is_empty());
    let first = lines.next().unwrap_or_default();
    let in_nanometres = first.split_whitespace().rev().nth(1) == Some("1");
    let (mut size, mut blocks, mut data) = ([f64::NAN; 2], Vec::new(), Vec::new());
    while let Some(line) = lines.next() {
        let fields: Vec<&str> = line.split('\t').map(str::trim).collect();
        let value = |field: &str| {
            field.parse::<f64>().map_err(|_| format!("{} is {:?}; it must be a number", clip(fields[0]), clip(field)))
        };
        match fields[..] {
            ["X Size", n] => size[0] = value(n)?,
            ["Y Size", n] => size[1] = value(n)?,
            [_] | ["Block Name", ..] => {}
            [name, _, _] => {
                let [nx, ny] = points(size, text)?;
                let words = lines.by_ref().take(nx).flat_map(|line| line.split('\t')).map(str::trim);
                if HEIGHTS.contains(&name) {
                    // Lines run along y.
                    data.push((name, grid(words.filter(|word| !word.is_empty()), [ny, nx])?.reversed_axes()));
                } else {
                    words.for_each(drop);
                }
            }
            [name, _, _, number] => blocks.push((name, number)),
            _ => return Err(format!("the line {:?} is no block; it must be one", clip(line))),
        }
    }
    let block = |name: &str| -> Result<Option<f64>, String> {
        let found = blocks.iter().find(|(key, _)| *key == name);
        found
            .map(|(_, text)| text.parse().map_err(|_| format!("{name} is {:?}; it must be a number", clip(text))))
            .transpose()
    };
    let unit = match (in_nanometres, block("Wavelength")?) {
        (true, _) => 1.0,
        (false, Some(wavelength)) => {
            positive("Wavelength", wavelength)? / positive("Mult", block("Mult")?.unwrap_or(1.0))?
        }
        (false, None) => {
            return Err("the file has no block Wavelength, the unit of the heights; it must have it".into());
        }
    };
    let pixel = block("Pixel_size")?.map(|pixel| positive("Pixel_size", pixel)).transpose()?;
    let aspect = positive("Aspect", block("Aspect")?.unwrap_or(1.0))?;
    let channels: Vec<Channel> = data
        .into_iter()
        .map(|(name, mut heights)| {
            heights.mapv_inplace(|height| height * unit);
            let points: [usize; 2] = heights.dim().into();
            // The pixel size is in millimetres.
            let lengths = pixel.map(|pixel| [pixel * 1e3 * points[0] as f64, pixel * 1e3 * aspect * points[1] as f64]);
            let [height_unit, length_unit] = ["nm", "µm"].map(|unit| Some(unit.to_owned()));
            let map = Map { heights, lengths, length_unit, height_unit: height_unit.clone(), ..Map::default() };
            Channel { name: name.into(), unit: height_unit, points, read: Box::new(move || Ok(map)) }
        })
        .collect();
    match channels.is_empty() {
        true => Err(format!("the file has no block of heights; it must have one of {}", HEIGHTS.join(", "))),
        false => Ok(channels),
    }
}

/// Reads the points of a Zygo text: camera pixels from the top left, heights in micrometres.
fn zygo(text: &str) -> Result<Map, String> {
    let mut lines = lines(text);
    let head: Vec<&str> = lines.by_ref().take_while(|line| line.trim() != "#").collect();
    let entry = |line: usize, word: usize| {
        let found = head.get(line).and_then(|line| line.split_whitespace().nth(word)).unwrap_or_default();
        let says = || format!("line {}, word {} is {:?}; it must be a number", line + 1, word + 1, clip(found));
        found.parse::<f64>().map_err(|_| says())
    };
    let origin = [entry(3, 0)?, entry(3, 1)?];
    let [nx, ny] = points([entry(3, 2)?, entry(3, 3)?], text)?;
    let mut heights = Array2::from_elem((nx, ny), f64::NAN);
    let mut seen = Array2::from_elem((nx, ny), false);
    for line in lines.take_while(|line| line.trim() != "#").filter(|line| !line.trim().is_empty()) {
        let mut words = line.split_whitespace();
        let at = |word: Option<&str>, axis: usize| Some(word?.parse::<f64>().ok()? - origin[axis]);
        let place = at(words.next(), 0).zip(at(words.next(), 1));
        let inside = |(x, y): &(f64, f64)| {
            (0.0..nx as f64).contains(x) && (0.0..ny as f64).contains(y) && x.fract() == 0.0 && y.fract() == 0.0
        };
        let Some((x, y)) = place.filter(inside) else {
            return Err(format!("the line {:?} is no point of the {nx} x {ny} pixels; it must be one", clip(line)));
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a pixel of the grid")]
        let place = [x as usize, ny - 1 - y as usize];
        let word: Vec<&str> = words.collect();
        let word = word.join(" ");
        if std::mem::replace(&mut seen[place], true) {
            return Err(format!("the pixel of the line {:?} is there twice; it must be there once", clip(line)));
        }
        heights[place] = if is_missing(&word) {
            f64::NAN
        } else {
            number(&word, 0, 0)
                .map_err(|_| format!("the line {:?} has no height; it must have one, or \"No Data\"", clip(line)))?
        };
    }
    let resolution = entry(7, 6)?;
    // Metres per pixel; 0 if unknown.
    let lengths = (resolution > 0.0).then_some([resolution * 1e6 * nx as f64, resolution * 1e6 * ny as f64]);
    let unit = Some("µm".to_owned());
    Ok(Map { heights, lengths, length_unit: unit.clone(), height_unit: unit, ..Map::default() })
}
