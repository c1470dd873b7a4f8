//! Formats that are recognised but not read, each with advice on conversion.

use crate::file::File;
#[cfg(feature = "zip")]
use crate::zipped::Zip;

/// Advice on conversion.
const AS_SURFACE: &str = "export the heights from the program that wrote it as X3P, text or .sur";
const AS_ARRAY: &str = "write the heights with numpy.save as .npy, or as text";
const UNPACK: &str = "unpack it and give the file inside";

/// First bytes of a file, name of the format, and advice.
const FIRST_BYTES: [(&[u8], &str, &str); 25] = [
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "OLE compound file (.xls, .oif)", AS_SURFACE),
    (b"II+\0", "BigTIFF", AS_SURFACE),
    (b"MM\0+", "BigTIFF", AS_SURFACE),
    (b"\xff\xd8\xff", "JPEG image", AS_ARRAY),
    (b"GIF8", "GIF image", AS_ARRAY),
    (b"STiMage", "RHK SM4", "export the heights from Gwyddion as .gsf or text"),
    (b"ONTMATRX", "Omicron MATRIX", "export the heights from Gwyddion as .gsf or text"),
    (b"Zygo ASCII Data File", "Zygo ASCII", "export it from MetroPro as .dat, or as Zygo XYZ"),
    (b"OFF\n", "OFF mesh", "write its vertices as text, the columns x y z"),
    (b"OFF\r", "OFF mesh", "write its vertices as text, the columns x y z"),
    (b"# vtk DataFile", "VTK", "write the points as text, the columns x y z"),
    (b"$MeshFormat", "Gmsh mesh", "write its nodes as text, the columns x y z"),
    (b"BZh", "bzip2 archive", UNPACK),
    (b"\xfd7zXZ\0", "xz archive", UNPACK),
    (b"\x28\xb5\x2f\xfd", "Zstandard archive", UNPACK),
    (b"7z\xbc\xaf\x27\x1c", "7-Zip archive", UNPACK),
    (b"Rar!", "RAR archive", UNPACK),
    (b"%PDF", "PDF document", AS_ARRAY),
    (b"\x80\x04\x95", "pickle of Python", AS_ARRAY),
    (b"PAR1", "Parquet table", AS_ARRAY),
    (b"ARROW1", "Arrow table", AS_ARRAY),
    (b"SIMPLE  =", "FITS image", AS_ARRAY),
    (b"\x0e\x03\x13\x01", "HDF4 file", AS_ARRAY),
    (b"SQLite format 3\0", "SQLite database", AS_ARRAY),
    (b"\x7fELF", "program", AS_ARRAY),
];

/// Beginning or end of a member's name in a zip archive, name of the format, and advice.
#[cfg(feature = "zip")]
const MEMBERS: [(&str, &str, &str); 6] = [
    ("content.xml", "OpenDocument table (.ods)", "save the sheet of the heights as CSV"),
    ("word/", "Word document", AS_ARRAY),
    (
        "header.properties",
        "JPK force map (.jpk-force-map, .jpk-qi-data)",
        "export the heights as text from its program",
    ),
    (".vk4", "Keyence CAG", "export the heights as CSV from its program"),
    (".vk6", "Keyence CAG", "export the heights as CSV from its program"),
    (".lext", "Olympus LEXT", AS_SURFACE),
];

/// Returns the error message for a file in a format that is recognised but not read, or `None` for any other file.
pub(crate) fn refusal(file: &File) -> Option<String> {
    let head = file.head();
    #[cfg(feature = "zip")]
    if let (b"PK\x03\x04", Err(damaged)) = (head.get(..4).unwrap_or_default(), Zip::open(file)) {
        return Some(format!("{damaged}; copy the file again"));
    }
    let (name, way) = first_bytes(head)
        .or_else(|| deeper(head, file.length()))
        .or_else(|| archive(file))
        .or_else(|| written(head).map(|name| (name, AS_ARRAY)))?;
    Some(format!("the format is {name}, which is not read; {way}"))
}

fn first_bytes(head: &[u8]) -> Option<(&'static str, &'static str)> {
    let bare = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    FIRST_BYTES.iter().find(|(magic, ..)| bare.starts_with(magic)).map(|(_, name, way)| (*name, *way))
}

/// Recognises formats with a mark that is not at the beginning.
fn deeper(head: &[u8], length: u64) -> Option<(&'static str, &'static str)> {
    let at = |from: usize, mark: &[u8]| head.get(from..from + mark.len()) == Some(mark);
    let number = |from: usize| Some(u32::from_le_bytes(head.get(from..from + 4)?.try_into().ok()?));
    if at(128, b"DICM") {
        return Some(("DICOM image", AS_ARRAY));
    }
    if at(0, b"BM") && number(2).is_some_and(|size| u64::from(size) == length) {
        return Some(("BMP image", AS_ARRAY));
    }
    // RHK has its mark in 16-bit characters after a size.
    at(2, b"S\0T\0i\0M\0a\0g\0e\0").then_some(("RHK SM4", "export the heights from Gwyddion as .gsf or text"))
}

#[cfg(feature = "zip")]
fn archive(file: &File) -> Option<(&'static str, &'static str)> {
    let names = file.starts_with(b"PK").then(|| Zip::open(file).ok())??.names();
    let known =
        MEMBERS.iter().find(|(mark, ..)| names.iter().any(|name| name.starts_with(mark) || name.ends_with(mark)));
    let other = ("zip archive in which no format is known", UNPACK);
    Some(known.map_or(other, |(_, name, way)| (*name, *way)))
}

#[cfg(not(feature = "zip"))]
fn archive(_file: &File) -> Option<(&'static str, &'static str)> {
    None
}

/// Recognises texts with numbers in the notation of a language.
fn written(head: &[u8]) -> Option<&'static str> {
    let text = String::from_utf8_lossy(head);
    let text = text.trim_start_matches('\u{feff}').trim_start();
    let number =
        |text: &str| text.trim_start().starts_with(|c: char| c.is_ascii_digit() || matches!(c, '[' | '-' | '.'));
    let start: String = text.chars().take(16).collect::<String>().to_lowercase();
    if let Some(inside) = text.strip_prefix('[') {
        return number(inside).then_some("list of JSON or printed array of Python");
    }
    if text.strip_prefix('{').is_some_and(|inside| inside.trim_start().starts_with('"')) {
        return Some("file of JSON");
    }
    if start.starts_with("array([") {
        return Some("printed array of Python");
    }
    let assigned = text.lines().next().and_then(|line| line.split_once('=')).map(|(_, value)| value);
    if assigned.is_some_and(|value| value.trim_start().strip_prefix('[').is_some_and(number)) {
        return Some("script or configuration that assigns an array");
    }
    if start.starts_with("<?xml") || start.starts_with("<html") || start.starts_with("<!doctype") {
        return Some("file of XML or HTML");
    }
    (start.starts_with("%yaml") || start.starts_with("---\n") && text.contains(": ")).then_some("file of YAML")
}
