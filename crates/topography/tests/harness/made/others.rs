//! Meshes, pictures, softgauges, and archives of gzip.

use std::io::Write;

use flate2::write::GzEncoder;
use flate2::{Compression, Crc};

use super::{Bytes, POINTS, deflated, is_undefined, joined, lines, lines_upwards};

/// Returns the vertices with spacings of 0.5 and 0.25, without the point that has no height.
fn vertices() -> Vec<[f32; 3]> {
    let heights: Vec<f32> = lines_upwards().map(f32::from).collect();
    let vertex = |k: usize| [0.5 * (k % POINTS[0]) as f32, 0.25 * (k / POINTS[0]) as f32, heights[k]];
    (0..heights.len()).filter(|k| *k != 2 * POINTS[0] + 2).map(vertex).collect()
}

/// Triangles of all vertices, in any order; a closed body has another vertex below the first.
pub(crate) fn stl(is_text: bool, is_closed: bool) -> Vec<u8> {
    let mut vertices = vertices();
    if is_closed {
        vertices.push([0.0, 0.0, -999.0]);
    }
    let last = vertices.len() - 1;
    let triangles: Vec<[[f32; 3]; 3]> = (0..=last).map(|k| [k, last - k, k].map(|k| vertices[k])).collect();
    if is_text {
        let corner = |[x, y, z]: &[f32; 3]| format!("  vertex {x} {y} {z:e}\n");
        let facet = |corners: &[[f32; 3]; 3]| corners.iter().map(corner).collect::<String>();
        let facets = triangles.iter().map(|corners| format!("facet normal 0 0 1\n{}endfacet\n", facet(corners)));
        return format!("solid made\n{}endsolid\n", facets.collect::<String>()).into_bytes();
    }
    let head = Bytes::default().add("made").zeros(76).ints(&[triangles.len() as i32]);
    let triangle = |bytes: Bytes, corners: &[[f32; 3]; 3]| bytes.zeros(12).floats(corners.as_flattened()).zeros(2);
    triangles.iter().fold(head, triangle).0
}

/// Vertices as PLY, after another element with a list, as text or binary in either byte order.
pub(crate) fn ply(format: &str) -> Vec<u8> {
    let count = vertices().len();
    let head = format!(
        "ply\nformat {format} 1.0\nelement face 1\nproperty list uchar short of\nelement vertex {count}\n\
         property double z\nproperty uchar red\nproperty float x\nproperty float y\nend_header\n"
    );
    let vertex = |[x, y, z]: [f32; 3]| match format {
        "ascii" => format!("{z} 7 {x} {y}\n").into_bytes(),
        "binary_little_endian" => [&f64::from(z).to_le_bytes()[..], &[7], &x.to_le_bytes(), &y.to_le_bytes()].concat(),
        _ => [&f64::from(z).to_be_bytes()[..], &[7], &x.to_be_bytes(), &y.to_be_bytes()].concat(),
    };
    let face: &[u8] = if format == "ascii" { b"2 0 1\n" } else { &[2, 0, 0, 0, 1] };
    [head.into_bytes(), face.to_vec(), vertices().into_iter().flat_map(vertex).collect()].concat()
}

/// PNG: grey numbers of 16 bits above 150, with the texts of Gwyddion, 2.5 by 1 µm and 0.125 nm for a number, or none.
pub(crate) fn png(has_texts: bool) -> Vec<u8> {
    let texts =
        [("XReal", "2.5"), ("YReal", "1"), ("XYUnit", "um"), ("ZUnit", "nm"), ("ZMin", "0"), ("ZMax", "8191.875")];
    let texts = texts.iter().filter(|_| has_texts);
    let texts = texts.flat_map(|(key, value)| chunk(b"tEXt", format!("Gwy::{key}\0{value}").as_bytes()));
    let numbers: Vec<u16> = lines().map(|height| (height + 150) as u16).collect();
    let line = |line: &[u16]| [vec![0], joined(line.iter().map(|number| number.to_be_bytes()))].concat();
    image(POINTS, 16, texts.collect(), &numbers.chunks(POINTS[0]).flat_map(line).collect::<Vec<u8>>())
}

/// PNG: 2 by 2 grey numbers of 8 bits, 3 and 4 in the bottom line.
pub(crate) fn png_of_8_bits() -> Vec<u8> {
    image([2, 2], 8, vec![], &[0, 1, 2, 0, 3, 4])
}

/// PNG of grey numbers with these texts, and lines that begin with the number of their filter.
fn image(points: [usize; 2], bits: u8, texts: Vec<u8>, lines: &[u8]) -> Vec<u8> {
    let [nx, ny] = points.map(|n| (n as u32).to_be_bytes());
    let head = [&nx[..], &ny, &[bits, 0, 0, 0, 0]].concat();
    let start = [b"\x89PNG\r\n\x1a\n".to_vec(), chunk(b"IHDR", &head), texts].concat();
    [start, chunk(b"IDAT", &deflated(lines)), chunk(b"IEND", &[])].concat()
}

/// Chunk of PNG.
fn chunk(kind: &[u8], content: &[u8]) -> Vec<u8> {
    let mut sum = Crc::new();
    sum.update(kind);
    sum.update(content);
    [&(content.len() as u32).to_be_bytes(), kind, content, &sum.sum().to_be_bytes()].concat()
}

/// Softgauge: a profile of 4 points every 0.5 µm, heights of 0.125 µm per number.
pub(crate) fn smd() -> Vec<u8> {
    b"'ISO 5436 - 2000' 'made'\r\n'PRF' 0 0.0 'none'\r\n'CX' 'I' 4 'mm' 1.0e+000 'D' 5.0e-004\r\n\
      'CZ' 'A' 4 'um' 1.25e-001 'I'\r\n\x03\r\n'DATE' '29-FEB-2024'\r\n\x03\r\n8\r\n-16\r\n24\r\n0\r\n\x03\r\n1\r\n\x1a"
        .to_vec()
}

/// Text in an archive of gzip: 2.5 by 1 µm, heights in nm, the bottom line first.
pub(crate) fn gzip() -> Vec<u8> {
    let mut text = "# Width: 2.5 um\n# Height: 1 um\n# Value units: nm\n".to_owned();
    let heights: Vec<String> = lines()
        .enumerate()
        .map(|(k, height)| if is_undefined(k) { "nan".into() } else { height.to_string() })
        .collect();
    heights.chunks(POINTS[0]).rev().for_each(|line| text += &(line.join("\t") + "\n"));
    gzipped(text.as_bytes())
}

/// Compresses bytes by gzip.
pub(crate) fn gzipped(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(vec![], Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}
