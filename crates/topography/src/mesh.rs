//! Meshes as STL and PLY whose vertices lie on a lattice.
//!
//! Vertices have x and y at the points of an even lattice, each with one height; points of the lattice without a vertex
//! are undefined. Closed bodies, with two heights above each other, and other meshes are refused. The files have no
//! units.

use super::bytes::{Bytes, Order, Sample, clip, lines, text};
use super::coordinates::Lattice;
use super::file::File;
use super::format::{Channel, Contents, FirstLine, Format, Map, size};
use crate::MOST_POINTS;

pub(crate) const STL: Format = Format {
    name: "STL",
    sniff: |file| is_binary_stl(file) || is_text_stl(file.head()),
    open: |file| {
        if is_binary_stl(file) { binary_stl(file.bytes()?) } else { text_stl(file.bytes()?) }.and_then(lattice)
    },
    first_line: FirstLine::Bottom,
};

pub(crate) const PLY: Format = Format {
    name: "PLY",
    sniff: |file| file.starts_with(b"ply\n") || file.starts_with(b"ply\r"),
    open: |file| ply(file.bytes()?).and_then(lattice),
    first_line: FirstLine::Bottom,
};

/// Number of bytes before the triangles of STL, and of a triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;

/// Largest distance of the heights of one point, in their range.
const SAME: f64 = 1e-6;

/// Largest number of points of the lattice for each vertex.
const MOST_MISSING: usize = 8;

type Vertices = Vec<[f64; 3]>;

/// Returns true if the length of a file is the length of the number of triangles in it.
fn is_binary_stl(file: &File) -> bool {
    let count =
        file.head().get(80..HEAD).map_or(0, |count| u32::from_le_bytes([count[0], count[1], count[2], count[3]]));
    count > 0 && HEAD as u64 + TRIANGLE as u64 * u64::from(count) == file.length()
}

fn is_text_stl(head: &[u8]) -> bool {
    head.starts_with(b"solid") && head.windows(5).take(1 << 12).any(|word| word == b"facet")
}

fn binary_stl(all: &[u8]) -> Result<Vertices, String> {
    let number = |bytes: &[u8]| Sample::F32.decode(bytes, Order::Little);
    let corner = |bytes: &[u8]| [number(&bytes[..4]), number(&bytes[4..8]), number(&bytes[8..])];
    let triangles = all.get(HEAD..).unwrap_or_default().chunks_exact(TRIANGLE);
    // The normal comes first.
    Ok(triangles.flat_map(|triangle| triangle[12..48].chunks_exact(12)).map(corner).collect())
}

fn text_stl(all: &[u8]) -> Result<Vertices, String> {
    let mut vertices = Vec::new();
    for line in lines(&text(all)).map(str::trim) {
        if let Some(rest) = line.strip_prefix("vertex") {
            let mut words = rest.split_whitespace().map(|word| word.parse::<f64>().unwrap_or(f64::NAN));
            let mut next = || words.next().unwrap_or(f64::NAN);
            vertices.push([next(), next(), next()]);
        }
    }
    Ok(vertices)
}

/// Property of an element of PLY: a name, and the type of its number or else the types of a list.
struct Property<'a> {
    name: &'a str,
    kind: Result<Sample, [Sample; 2]>,
}

/// Element of PLY.
struct Element<'a> {
    name: &'a str,
    count: usize,
    properties: Vec<Property<'a>>,
}

/// Returns the type with a name of PLY.
fn sample(name: &str) -> Result<Sample, String> {
    Ok(match name {
        "char" | "int8" => Sample::I8,
        "uchar" | "uint8" => Sample::U8,
        "short" | "int16" => Sample::I16,
        "ushort" | "uint16" => Sample::U16,
        "int" | "int32" => Sample::I32,
        "uint" | "uint32" => Sample::U32,
        "float" | "float32" => Sample::F32,
        "double" | "float64" => Sample::F64,
        other => return Err(format!("a property has the type {:?}, which is not known", clip(other))),
    })
}

fn ply(all: &[u8]) -> Result<Vertices, String> {
    const END: &[u8] = b"end_header";
    let end = super::bytes::find(all, END).ok_or("the head has no line end_header; it must end with one")?;
    let head = text(&all[..end]);
    let (mut format, mut elements) = ("", Vec::<Element>::new());
    for line in lines(&head) {
        match (&line.split_whitespace().collect::<Vec<_>>()[..], elements.last_mut()) {
            (["format", found, ..], _) => format = found,
            (["element", name, count], _) => {
                let count = count.parse().map_err(|_| format!("the element {} has no number", clip(name)))?;
                elements.push(Element { name, count, properties: Vec::new() });
            }
            (["property", "list", count, kind, name], Some(element)) => {
                element.properties.push(Property { name, kind: Err([sample(count)?, sample(kind)?]) });
            }
            (["property", kind, name], Some(element)) => {
                element.properties.push(Property { name, kind: Ok(sample(kind)?) })
            }
            _ => {}
        }
    }
    let mut rest = &all[end + END.len()..];
    rest = &rest[rest.iter().position(|&byte| byte == b'\n').map_or(rest.len(), |at| at + 1)..];
    match format {
        "ascii" => vertices(&elements, rest.len(), &mut words(&text(rest))),
        "binary_little_endian" => vertices(&elements, rest.len(), &mut numbers(Bytes::new(rest, Order::Little))),
        "binary_big_endian" => vertices(&elements, rest.len(), &mut numbers(Bytes::new(rest, Order::Big))),
        other => Err(format!("the format is {:?}; it must be ascii or binary", clip(other))),
    }
}

/// Returns a function that reads the next number from words.
fn words(text: &str) -> impl FnMut(Sample) -> Result<f64, String> {
    let mut words = text.split_whitespace();
    move |_| {
        let word = words.next().ok_or("the file ends before its last vertex; all must be there")?;
        word.parse().map_err(|_| format!("a number is {:?}; it must be one", clip(word)))
    }
}

/// Returns a function that reads the next number from bytes.
fn numbers(mut bytes: Bytes) -> impl FnMut(Sample) -> Result<f64, String> {
    move |sample| {
        let order = bytes.order();
        Ok(sample.decode(bytes.take(sample.size())?, order))
    }
}

/// Reads the vertices, which must be the first element or follow others.
fn vertices(
    elements: &[Element],
    length: usize,
    next: &mut dyn FnMut(Sample) -> Result<f64, String>,
) -> Result<Vertices, String> {
    for element in elements {
        let places = ["x", "y", "z"].map(|axis| element.properties.iter().position(|property| property.name == axis));
        let is_vertex = element.name == "vertex";
        if element.properties.is_empty() || element.count > length {
            let count = element.count;
            return Err(format!(
                "there are {count} of {} in {length} bytes; each must have a number",
                clip(element.name)
            ));
        }
        let mut found = Vec::new();
        let mut row = vec![0.0; element.properties.len()];
        for _ in 0..element.count {
            for (property, value) in element.properties.iter().zip(&mut row) {
                match property.kind {
                    Ok(kind) => *value = next(kind)?,
                    Err([count, kind]) => {
                        let mut left = next(count)?;
                        while left >= 1.0 {
                            next(kind)?;
                            left -= 1.0;
                        }
                    }
                }
            }
            if let (true, [Some(x), Some(y), Some(z)]) = (is_vertex, places) {
                found.push([row[x], row[y], row[z]]);
            }
        }
        if is_vertex {
            return Ok(found);
        }
    }
    Err("the file has no element vertex; it must have one".into())
}

/// Places vertices on their lattice.
fn lattice(vertices: Vertices) -> Result<Contents<'static>, String> {
    let refused = |what: &str| {
        let count = vertices.len();
        Err(format!(
            "the {count} vertices {what}; they must have one height at each point of an even lattice of x and y"
        ))
    };
    if vertices.iter().flatten().any(|number| !number.is_finite()) {
        return refused("have numbers that are not finite");
    }
    let axis = |axis: usize| Lattice::of(vertices.iter().map(|vertex| vertex[axis]));
    let (Some(x), Some(y)) = (axis(0), axis(1)) else { return refused("have no lattice") };
    let [nx, ny] = [x.count, y.count];
    if nx.checked_mul(ny).is_none_or(|points| points > MOST_POINTS.min(vertices.len().saturating_mul(MOST_MISSING))) {
        return refused("are too few for their lattice");
    }
    let mut heights = ndarray::Array2::from_elem((nx, ny), f64::NAN);
    let low = vertices.iter().fold(f64::INFINITY, |low, vertex| low.min(vertex[2]));
    let high = vertices.iter().fold(f64::NEG_INFINITY, |high, vertex| high.max(vertex[2]));
    for vertex in &vertices {
        let height = &mut heights[[x.index(vertex[0]), y.index(vertex[1])]];
        if (*height - vertex[2]).abs() > SAME * (high - low) {
            return refused("have two heights at one point, as a closed body has");
        }
        *height = vertex[2];
    }
    let (points, lengths) = ([nx, ny], Some(size([nx, ny], [x.step, y.step])));
    let map = Map { heights, lengths, ..Map::default() };
    Ok(Channel { name: String::new(), unit: None, points, read: Box::new(move || Ok(map)) }.into())
}
