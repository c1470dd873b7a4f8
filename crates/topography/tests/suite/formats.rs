//! Files of other programs: every height, size and unit is compared with `data/make.py`.

use std::path::Path;

use gfmd_files::{Output, X3p};
use gfmd_topography::Topography;
use ndarray::Array2;

const HOLES: [[usize; 2]; 2] = [[1, 2], [4, 0]];

/// Returns the heights of `make.py`.
fn heights() -> Array2<f64> {
    Array2::from_shape_fn((5, 4), |(i, j)| ((7 * i + 3 * j) % 16) as f64 - (i * j) as f64 / 8.0 + 0.25)
}

fn with_holes(mut heights: Array2<f64>) -> Array2<f64> {
    HOLES.iter().for_each(|&hole| heights[hole] = f64::NAN);
    heights
}

fn path(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name).to_str().unwrap().to_owned()
}

fn read(name: &str, channel: Option<&str>) -> Topography {
    Topography::read(&path(name), channel).unwrap()
}

/// Returns true if two maps have the same bits, and NaN at the same points.
fn same(found: &Array2<f64>, expected: &Array2<f64>) -> bool {
    found.dim() == expected.dim()
        && found.iter().zip(expected).all(|(a, b)| a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()))
}

fn names(name: &str) -> Vec<String> {
    Topography::list(&path(name)).unwrap().channels.into_iter().map(|channel| channel.name).collect()
}

#[test]
fn x3p_has_floats_and_scaled_integers_with_valid_points() {
    // The size is n times the increment stated in the file, 2.5 µm / 5.
    let lengths = Some([5.0 * (2.5e-6 / 5.0), 4.0 * (1e-6 / 4.0)]);
    let int16 = |h: f64| (h * 8.0 - 40.0) * 2_f64.powi(-23) + 2_f64.powi(-18);
    let cases = [
        ("double.x3p", heights().mapv(|h| h * 1e-6)),
        ("single.x3p", heights().mapv(|h| h * 2_f64.powi(-20))),
        ("int16.x3p", with_holes(heights().mapv(int16))),
        ("int32.x3p", with_holes(heights().mapv(|h| (h * 8.0 - 40.0) * 2_f64.powi(-23)))),
    ];
    for (name, expected) in cases {
        let found = read(name, None);
        assert!(same(&found.heights, &expected), "{name}: {}", found.heights);
        assert_eq!((found.lengths, found.unit.as_deref(), found.format), (lengths, Some("m"), "X3P"), "{name}");
        assert_eq!(found.undefined, expected.iter().filter(|h| h.is_nan()).count());
        let detail = |key: &str| found.details.iter().find(|(name, _)| name == key).map(|(_, value)| value.as_str());
        assert_eq!((detail("Date"), detail("Model")), (Some("2026-11-20T12:00:00"), Some("numpy")));
        assert!(found.notes.is_empty(), "{:?}", found.notes);
    }
}

#[test]
fn gwyddion_lists_heights_only_and_its_mask_hides_points() {
    assert_eq!(names("two.gwy"), ["Topography"]);
    let found = read("two.gwy", Some("Topography"));
    // The file begins with the top line of the picture; y points up.
    let mut expected = with_holes(heights().mapv(|h| h * 1e-6));
    expected.invert_axis(ndarray::Axis(1));
    assert!(same(&found.heights, &expected));
    assert_eq!((found.lengths, found.unit.as_deref()), (Some([2.5e-6, 1e-6]), Some("m")));
    assert_eq!(found.details, [("Instrument".to_owned(), "nothing".to_owned())]);
    assert_eq!(found.notes, ["points under the mask of the channel are undefined"]);
    assert!(found.source.ends_with("two.gwy, channel Topography"));
}

#[test]
fn matrices_of_matlab_are_found_by_name_and_number() {
    assert_eq!(names("small.mat"), ["heights", "single", "line"]);
    assert_eq!(names("compressed.mat"), ["heights", "whole"]);
    for (name, channel) in
        [("small.mat", "heights"), ("small.mat", "0"), ("small.mat", "single"), ("compressed.mat", "0")]
    {
        let found = read(name, Some(channel));
        assert!(same(&found.heights, &heights()), "{name} {channel}");
        assert_eq!((found.lengths, found.unit), (None, None));
    }
    assert!(same(&read("compressed.mat", Some("whole")).heights, &heights().mapv(|h| 8.0 * h)));
    let line = read("small.mat", Some("line")).heights;
    assert_eq!((line.dim(), line.column(0).to_vec()), ((5, 1), heights().column(0).to_vec()));
    let error = Topography::read(&path("small.mat"), Some("3")).unwrap_err().reason;
    assert_eq!(error, "the channel is 3; it must be one of 0 heights, 1 single, 2 line");
}

#[test]
fn archives_of_numpy_and_netcdf_and_hdf5() {
    assert_eq!(names("two.npz"), ["first", "second"]);
    for (name, channel) in
        [("two.npz", Some("first")), ("two.npz", Some("1")), ("compressed.npz", None), ("challenge.h5", None)]
    {
        assert!(same(&read(name, channel).heights, &heights()), "{name}");
    }
    assert_eq!(read("challenge.h5", None).channel.as_deref(), Some("/surface"));
    assert_eq!(read("challenge.h5", Some("SURFACE")).channel.as_deref(), Some("/surface"));
    for name in ["holes.nc", "four.nc"] {
        let found = read(name, None);
        assert!(same(&found.heights, &with_holes(heights())), "{name}");
        assert_eq!(
            (found.lengths, found.unit.as_deref(), found.undefined),
            (Some([2.5, 1.0]), Some("µm"), 2),
            "{name}"
        );
    }
}

#[test]
fn a_channel_is_found_by_the_end_of_its_path_but_a_number_is_a_number() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frames.h5");
    let file = hdf5::File::create(&path).unwrap();
    for (place, value) in ["/one/Height/0", "/one/Height/1", "/two/Depth/0"].into_iter().zip([1.0, 2.0, 3.0]) {
        let (group, name) = place.rsplit_once('/').unwrap();
        let group = file.group(group).or_else(|_| file.create_group(group)).unwrap();
        group.new_dataset_builder().with_data(&ndarray::arr2(&[[value, 0.0], [0.0, 0.0]])).create(name).unwrap();
    }
    drop(file);
    let height = |channel: &str| Topography::read(path.to_str().unwrap(), Some(channel)).map(|map| map.heights[[0, 0]]);
    for (channel, value) in [("height/1", 2.0), ("one/Height/0", 1.0), ("Depth/0", 3.0), ("1", 2.0), ("2", 3.0)] {
        assert_eq!(height(channel), Ok(value), "{channel}");
    }
    let error = height("3").unwrap_err().reason;
    assert!(error.starts_with("the channel is 3; it must be one of "), "{error}");
}

#[test]
fn containers_give_sizes_to_files_that_have_none() {
    assert_eq!(names("container.zip"), ["first", "second", "unknown"]);
    let first = read("container.zip", None);
    assert!(same(&first.heights, &heights().mapv(|h| 2.0 * h)));
    assert_eq!((first.lengths, first.unit.as_deref()), (Some([2.5, 1.0]), Some("µm")));
    assert_eq!(
        first.notes,
        ["the data file heights.txt has the format text", "heights were multiplied by the height_scale of meta.yml, 2"]
    );
    let second = read("container.zip", Some("second"));
    assert!(same(&second.heights, &heights()));
    assert_eq!((second.lengths, second.unit.as_deref()), (Some([2.5, 1.0]), Some("µm")));
    let error = Topography::read(&path("container.zip"), Some("unknown")).unwrap_err().reason;
    assert_eq!(error, "notes.txt: line 1, column 1 is \"nothing\"; it must be a number");
}

#[test]
fn points_without_a_height_are_refused_by_number_where_all_are_needed() {
    let error = read("holes.nc", None).check_complete().unwrap_err().reason;
    assert!(
        error.starts_with("2 of 20 points are undefined, the first at [x, y] = [1, 2]; every point must"),
        "{error}"
    );
    assert!(read("double.x3p", None).check_complete().is_ok());
}

#[test]
fn every_truncation_of_every_file_is_refused_or_read_without_a_panic() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let mut cases = 0;
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        // HDF5 files are left to the tests of their library.
        if bytes.starts_with(b"\x89HDF") || path.extension().is_some_and(|ending| ending == "py" || ending == "md") {
            continue;
        }
        for length in 0..bytes.len() {
            let _ = Topography::from_bytes("cut", bytes[..length].to_vec(), None);
            let mut changed = bytes.clone();
            changed[length] ^= 0xff;
            let _ = Topography::from_bytes("changed", changed, None);
            cases += 2;
        }
    }
    assert!(cases > 10_000, "{cases}");
}

#[test]
fn x3p_comes_back_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("h.x3p");
    let write = |heights: &Array2<f64>, lengths: [f64; 2], unit: Option<&str>| {
        let x3p = X3p { heights, lengths, unit, date: "2026-11-20T12:00:00Z", creator: "test", comment: "a < b & c" };
        let note = x3p.write(&Output::claim(&path).unwrap()).unwrap();
        (note, Topography::read(path.to_str().unwrap(), None).unwrap())
    };
    let profile = heights().column(1).to_owned().insert_axis(ndarray::Axis(1));
    for (heights, lengths) in [
        (heights().mapv(|h| h / 3e6), [2.5e-6, 1e-6]),
        (with_holes(heights().mapv(|h| h * 1e-7)), [0.1, 0.7]),
        (profile, [1e-3, 1.0]),
    ] {
        let (note, found) = write(&heights, lengths, Some("m"));
        assert!(note.is_none() && same(&found.heights, &heights));
        // Possibly no spacing reproduces a size that is itself rounded.
        let sizes = found.lengths.unwrap().into_iter().zip(lengths);
        assert!(sizes.into_iter().all(|(found, length)| (found / length - 1.0).abs() <= f64::EPSILON));
        assert_eq!(found.unit.as_deref(), Some("m"));
        assert!(found.notes.is_empty() && found.warnings.is_empty(), "{:?} {:?}", found.notes, found.warnings);
        assert!(found.details.contains(&("Comment".into(), "a < b & c".into())), "{:?}", found.details);
    }
    let (note, found) = write(&heights(), [5.0, 4.0], Some("µm"));
    assert_eq!(note.as_deref(), Some("heights and lengths converted from µm to m, 1000000 µm = 1 m"));
    assert!(same(&found.heights, &heights().mapv(|h| h / 1e6)));
    let (note, found) = write(&heights(), [5.0, 4.0], None);
    assert_eq!(note.as_deref(), Some("the unit is unknown; the numbers were written as metres"));
    assert!(same(&found.heights, &heights()));
}
