//! Tests on temporary files in the formats of instruments and other programs.

use std::path::PathBuf;

use ndarray::{Array1, Array2, ShapeBuilder};
use ndarray_npy::write_npy;
use tempfile::TempDir;

use super::file::File;
use super::{Topography, TopographyError};
use crate::Checksum;
use gfmd_files::{Archive, Dimension, Output, Provenance, Variable};

/// Creates a temporary folder with one file; returns the folder and the file name.
fn file(name: &str, bytes: &[u8]) -> (TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    let name = path.to_str().unwrap().to_owned();
    (folder, name)
}

fn read_text(text: &str) -> Result<Topography, String> {
    let (_folder, name) = file("scan.txt", text.as_bytes());
    complete(&name).map_err(|error| error.to_string().replace(&name, "FILE"))
}

/// Reads the height map in a file, which must have no undefined points.
fn complete(name: &str) -> Result<Topography, TopographyError> {
    let found = Topography::read(name, None)?;
    found.check_complete().map(|()| found)
}

/// Returns the error message for a text file.
fn refusal(text: &str) -> String {
    read_text(text).unwrap_err()
}

const SCAN: &str = "# Channel: ZSensor\n# Width: 6.00 µm\n# Height: 3.00 µm\n# Value units: nm\n\
                    1e-003\t2.5\t-3\n4\t5\t6e+000\n";

#[test]
fn a_scan_of_an_instrument_has_x_along_its_lines_and_one_unit() {
    let scan = read_text(SCAN).unwrap();
    assert_eq!(scan.heights, ndarray::array![[1e-3, 4.0], [2.5, 5.0], [-3.0, 6.0]]);
    assert!(scan.heights.is_standard_layout());
    assert_eq!(scan.lengths, Some([6000.0, 3000.0]));
    let metres = read_text(&SCAN.replace("units: nm", "units: m")).unwrap();
    assert_eq!(metres.lengths, Some([6e-6, 3e-6]));
    assert_eq!(scan.unit.as_deref(), Some("nm"));
    assert!(scan.source.ends_with("scan.txt, channel ZSensor"), "{}", scan.source);
}

#[test]
fn encodings_and_spellings_of_a_unit_do_not_matter() {
    let expected = read_text(SCAN).unwrap();
    let latin: Vec<u8> = SCAN.chars().map(|c| u8::try_from(c as u32).unwrap()).collect();
    assert!(String::from_utf8(latin.clone()).is_err());
    let mut marked = vec![0xef, 0xbb, 0xbf];
    marked.extend_from_slice(SCAN.replace('\n', "\r\n").as_bytes());
    for bytes in [latin, marked, SCAN.replace("µm", "um").into(), SCAN.replace('µ', "\u{3bc}").into()] {
        let (_folder, name) = file("scan.txt", &bytes);
        let found = Topography::read(&name, None).unwrap();
        assert_eq!((found.heights, found.lengths), (expected.heights.clone(), expected.lengths));
    }
}

#[test]
fn plain_matrices_have_no_size() {
    for text in [
        "1 2 3\n4 5 6\n",
        "  1\t2\t3\t\n4\t5\t6\t\n",
        "1,2,3\n4,5,6",
        "1; 2; 3;\n4; 5; 6;\n",
        "% note\n1  2 3\n\n4 5 6\n",
    ] {
        let found = read_text(text).unwrap();
        assert_eq!(found.heights, ndarray::array![[1.0, 4.0], [2.0, 5.0], [3.0, 6.0]], "{text:?}");
        assert_eq!((found.lengths, found.unit), (None, None));
    }
    for profile in ["1\n2\n3\n", "1 2 3\n"] {
        assert_eq!(read_text(profile).unwrap().heights, ndarray::array![[1.0], [2.0], [3.0]]);
    }
    let profile = read_text("# Width: 2 mm\n# Value units: µm\n1 2 3 4\n").unwrap();
    assert_eq!(profile.lengths, Some([2000.0, 1.0]));
    assert_eq!(read_text("# Width: 2\n# Height: 5\n1 2\n3 4\n").unwrap().lengths, Some([2.0, 5.0]));
}

#[test]
fn points_without_a_height_are_named_and_counted() {
    let expected = "FILE: 2 of 6 points are undefined, the first at [x, y] = [1, 1]; every point must have a height";
    assert_eq!(refusal("1 2 3\n4 NaN nan\n"), expected);
    for text in ["1,2,3\n4,,\n", "1,2,3,\n4,,,\n", "1;2;3\n4; BAD; -\n", "1 2 3\n4 -- na\n"] {
        assert_eq!(refusal(text), expected, "{text:?}");
    }
    assert!(refusal("1 inf\n2 3\n").contains("1 of 4 points are undefined, the first at [x, y] = [1, 0]"));
}

#[test]
fn text_that_is_no_matrix_is_refused_by_line_and_column() {
    let says = |text: &str, words: &str| {
        let message = refusal(text);
        assert!(message.starts_with("FILE: ") && message.contains(words), "{message:?} lacks {words:?}");
        assert!(!message.contains('\n'));
    };
    says("1 2 3\n4 5\n", "line 2 has 2 numbers; it must have 3 as the lines before");
    says("1 2\n3 high\n", "line 2, column 2 is \"high\"; it must be a number");
    says("1,5.0;2,5\n", "line 1, column 1 is \"1,5.0\"; it must be a number");
    says("", "it must have at least one point");
    says("no numbers\nat all\n", "line 1, column 1 is \"no\"; it must be a number");
    says("# Width: wide\n1 2\n3 4\n", "the length in line 1 is \"wide\"; it must have the form 10.00 µm");
    says("# Width: 1 µm\n1 2\n3 4\n", "both or neither must be given");
    says("# Width: 1 µm\n# Height: 1 µm\n1 2\n3 4\n", "the heights have no unit");
    says("# Width: 1\n# Height: 1\n# Value units: m\n1 2\n3 4\n", "Width has no unit");
    says("# Width: 1 V\n# Height: 1 V\n# Value units: m\n1 2\n3 4\n", "the unit is \"V\"");
    says(
        "# Width: 0 m\n# Height: 1 m\n# Value units: m\n1 2\n3 4\n",
        "the size is 0 by 1; it must be positive and finite",
    );
    let (_folder, name) = file("scan.al3d", b"Alicona\0\x01\x02");
    assert!(complete(&name).unwrap_err().reason.starts_with("the format is unknown; docs/formats.md lists "));
    assert!(complete("no/such/file.txt").unwrap_err().to_string().starts_with("no/such/file.txt: No such file"));
}

#[test]
fn arrays_of_numpy_in_any_precision_and_order() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| -> PathBuf { folder.path().join(name) };
    let read = |name: &str| complete(path(name).to_str().unwrap());
    let heights = Array2::from_shape_fn((3, 4), |(i, j)| i as f64 - 0.25 * j as f64);
    let column_major = Array2::from_shape_fn((3, 4).f(), |(i, j)| i as f64 - 0.25 * j as f64);
    write_npy(path("c.npy"), &heights).unwrap();
    write_npy(path("f.npy"), &column_major).unwrap();
    write_npy(path("single.npy"), &heights.mapv(|h| h as f32)).unwrap();
    for name in ["c.npy", "f.npy", "single.npy"] {
        let found = read(name).unwrap();
        assert_eq!(found.heights, heights, "{name}");
        assert!(found.heights.is_standard_layout());
    }
    write_npy(path("line.npy"), &Array1::from(vec![1.0, 2.0])).unwrap();
    assert_eq!(read("line.npy").unwrap().heights, ndarray::array![[1.0], [2.0]]);

    let says = |name: &str, words: &str| {
        let message = read(name).unwrap_err().to_string();
        assert!(message.contains(words), "{message:?} lacks {words:?}");
    };
    write_npy(path("whole.npy"), &heights.mapv(|h| (4.0 * h) as i64)).unwrap();
    assert_eq!(read("whole.npy").unwrap().heights, heights.mapv(|h| 4.0 * h));
    let big_endian: &[u8] = b"\x93NUMPY\x01\x00\x40\x00{'descr': '>i2', 'fortran_order': False, 'shape': (2, 2), }    \
                              \n\
                              \0\x01\xff\xff\x80\0\x01\0";
    std::fs::write(path("big.npy"), big_endian).unwrap();
    assert_eq!(read("big.npy").unwrap().heights, ndarray::array![[1.0, -1.0], [-32768.0, 256.0]]);
    for (from, to, words) in [
        ("'>i2'", "'<c8'", "the entries have the type '<c8'; they must be real numbers"),
        ("(2, 2)", "(2, 9)", "the heights of 2 by 9 points have 8 bytes; they must have 36"),
        ("(2, 2)", "(2, 1)", "the file has 82 bytes; it must have 78 for the shape [2, 1], so it was changed or"),
        ("(2, 2)", "(-2,2)", "the header of the NumPy array is damaged"),
    ] {
        let position = big_endian.windows(from.len()).position(|part| part == from.as_bytes()).unwrap();
        let mut bytes = big_endian.to_vec();
        bytes.splice(position..position + from.len(), to.bytes());
        std::fs::write(path("lies.npy"), bytes).unwrap();
        says("lies.npy", words);
    }
    write_npy(path("cube.npy"), &ndarray::Array3::<f64>::zeros((2, 2, 2))).unwrap();
    says("cube.npy", "the shape of the array is [2, 2, 2]; it must have 1 or 2 dimensions");
    write_npy(path("row.npy"), &Array2::<f64>::zeros((1, 5))).unwrap();
    says("row.npy", "the shape of the array is [1, 5]; a profile must have the shape [5] or [5, 1]");
    write_npy(path("empty.npy"), &Array2::<f64>::zeros((0, 5))).unwrap();
    says("empty.npy", "it must have at least one point");
    let mut holes = heights.clone();
    holes[[2, 1]] = f64::NAN;
    write_npy(path("holes.npy"), &holes).unwrap();
    says("holes.npy", "1 of 12 points are undefined, the first at [x, y] = [2, 1]");
    let bytes = std::fs::read(path("c.npy")).unwrap();
    std::fs::write(path("short.npy"), &bytes[..bytes.len() - 8]).unwrap();
    says("short.npy", "the heights of 3 by 4 points have 88 bytes; they must have 96");
    // The content determines the format, not the name.
    std::fs::write(path("text.npy"), "1 2 3\n4 5 6\n").unwrap();
    assert_eq!(read("text.npy").unwrap().format, "text");
}

#[test]
fn datasets_bring_the_spacing_of_their_coordinates() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("h.h5");
    let heights = Array2::from_shape_fn((3, 4), |(i, j)| (i * j) as f64);
    {
        let output = Output::claim(&path).unwrap();
        let mut archive = Archive::create(&output, &Provenance::default()).unwrap();
        let x = Dimension::values("x", vec![0.0, 0.5, 1.0], "µm", "position along x");
        let y = Dimension::values("y", vec![1.0, 3.0, 5.0, 7.0], "µm", "position along y");
        let height = Variable { dimensions: &[&x, &y], units: "µm", long_name: "height" };
        archive.write("/surface/height", &height, heights.as_slice().unwrap()).unwrap();
        let uneven = Dimension::values("x", vec![0.0, 0.5, 2.0], "length", "position along x");
        let line = Variable { dimensions: &[&uneven], units: "length", long_name: "height" };
        archive.write("/uneven/height", &line, &[1.0, 2.0, 3.0]).unwrap();
        let bare = Variable { dimensions: &[&Dimension::index("k", 3, "point")], units: "length", long_name: "height" };
        archive.write("/bare/height", &bare, &[1_f32, 2.0, 3.0]).unwrap();
        archive.finish().unwrap();
    }
    let read = |dataset: &str| complete(&format!("{}{dataset}", path.display()));
    let found = read(":/surface/height").unwrap();
    assert_eq!((found.heights, found.lengths, found.unit.as_deref()), (heights, Some([1.5, 8.0]), Some("µm")));
    let bare = read(":/bare/height").unwrap();
    assert_eq!((bare.heights.dim(), bare.lengths, bare.unit), ((3, 1), None, None));
    let says = |dataset: &str, words: &str| {
        let message = read(dataset).unwrap_err().to_string();
        assert!(message.contains(words), "{message:?} lacks {words:?}");
    };
    says(
        ":/uneven/height",
        "a step of the coordinates /uneven/x is 0.5; it must be 1, since they must be evenly spaced",
    );
    says(":/surface/depth", "the channel is /surface/depth; it must be one of 0 /bare/height, 1 /surface/height, 2");
    let only = read("").unwrap();
    assert_eq!((only.channel.as_deref(), only.channels.len()), (Some("/surface/height"), 3));
    assert!(only.source.ends_with("h.h5, channel /surface/height"));
    assert!(read(":/surface/height").unwrap().source.ends_with("h.h5:/surface/height"));
    assert!(complete("no/such.h5:/a").unwrap_err().reason.contains("No such file"));
}

/// The checksum is of the bytes of the heights, even if the name leads elsewhere by then; a rewritten file is refused.
#[test]
fn the_checksum_is_of_the_bytes_that_were_read() {
    let text = |k: usize| format!("{k} 2\n3 4\n");
    let (folder, name) = file("scan.txt", text(1).as_bytes());
    let found = Topography::read(&name, None).unwrap();
    assert_eq!(found.sha256, Checksum::of_file(name.as_ref()).unwrap());
    let h5 = folder.path().join("h.h5");
    let write = |path: &std::path::Path, first: f64| {
        let output = Output::claim(path).unwrap();
        let mut archive = Archive::create(&output, &Provenance::default()).unwrap();
        let [x, y] = ["x", "y"].map(|axis| Dimension::index(axis, 2, "point"));
        let heights = Variable { dimensions: &[&x, &y], units: "length", long_name: "height" };
        archive.write("/heights", &heights, &[first, 2.0, 3.0, 4.0]).unwrap();
        archive.finish().unwrap();
    };
    write(&h5, 1.0);
    let h5 = h5.to_str().unwrap();
    for name in [&*name, h5] {
        let whole = std::fs::read(name).unwrap();
        // Another file takes the name between opening and reading.
        let open = File::open(name).unwrap();
        if name == h5 {
            write(name.as_ref(), 7.0);
        } else {
            let new = folder.path().join("new");
            std::fs::write(&new, text(7)).unwrap();
            std::fs::rename(&new, name).unwrap();
        }
        let read = Topography::decode(&open, name, None).unwrap();
        assert_eq!((read.heights[[0, 0]], &read.sha256), (1.0, &Checksum::of_bytes(&whole)), "{name}");
        assert_eq!(Topography::read(name, None).unwrap().heights[[0, 0]], 7.0);
        // The file is overwritten between opening and reading.
        let open = File::open(name).unwrap();
        std::fs::write(name, &whole).unwrap();
        let refused = Topography::decode(&open, name, None).unwrap_err();
        assert!(refused.starts_with("it changed while it was read"), "{name}: {refused}");
    }
}
