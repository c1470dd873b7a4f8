//! Files of instruments, built by hand from the published descriptions, and the results of the readers.

use gfmd_files::{Archive, Dimension, Output, Provenance, Variable};
use gfmd_topography::Topography;
use zip::CompressionMethod;

use crate::made::{self, POINTS, UNDEFINED, height};

/// Content of a file besides the heights of [`height`] times a scale.
pub(crate) struct Expected {
    pub(crate) format: &'static str,
    pub(crate) channel: &'static str,
    pub(crate) lengths: [f64; 2],
    pub(crate) unit: &'static str,
    pub(crate) scale: f64,
    pub(crate) undefined: bool,
}

pub(crate) fn read(bytes: Vec<u8>) -> Topography {
    Topography::from_bytes("scan", bytes, None).unwrap()
}

pub(crate) fn refusal(bytes: Vec<u8>) -> String {
    Topography::from_bytes("scan", bytes, None).unwrap_err().reason
}

/// Checks a map at all points. `at` returns the point for a place in the picture, with lines counted from the top. In
/// the map, y points up.
pub(crate) fn check_at(map: &Topography, expected: &Expected, at: impl Fn([usize; 2]) -> [usize; 2]) {
    let &Expected { format, channel, lengths, unit, scale, undefined } = expected;
    assert_eq!((map.format, map.channel.as_deref().unwrap_or("")), (format, channel));
    assert_eq!(map.unit.as_deref(), Some(unit), "{format}");
    let found = map.lengths.unwrap();
    assert!((0..2).all(|axis| (found[axis] - lengths[axis]).abs() < 1e-15 * lengths[axis]), "{format}: {found:?}");
    assert_eq!(map.heights.dim(), (POINTS[0], POINTS[1]), "{format}");
    assert_eq!(map.undefined, usize::from(undefined), "{format}");
    for ((x, y), &found) in map.heights.indexed_iter() {
        let [x, y] = at([x, POINTS[1] - 1 - y]);
        if undefined && [x, y] == UNDEFINED {
            assert!(found.is_nan(), "{format}");
        } else {
            let expected = scale * f64::from(height(x, y));
            assert!(
                (found - expected).abs() <= 1e-15 * expected.abs(),
                "{format} at {x}, {y}: {found}, not {expected}"
            );
        }
    }
}

pub(crate) fn check(bytes: Vec<u8>, expected: &Expected) -> Topography {
    let map = read(bytes);
    check_at(&map, expected, |point| point);
    map
}

const SUR: Expected = Expected {
    format: "Digital Surf",
    channel: "Z",
    lengths: [2.5, 1.0],
    unit: "mm",
    scale: 0.125e-3,
    undefined: true,
};

#[test]
fn digital_surf_scales_by_the_units_of_the_spacings_and_marks_points_not_measured() {
    for bits in [16, 32] {
        for streams in [0, 1, 3] {
            let map = check(made::sur(bits, streams, 0), &SUR);
            assert_eq!(map.conversion.as_deref(), Some("heights converted from µm to mm, 1000 µm = 1 mm"));
            let detail = |name: &str| map.details.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str());
            assert_eq!(detail("object"), Some("plate"));
            assert_eq!(detail("date"), Some("2021-02-03 04:05:06"));
            assert_eq!(detail("comment"), Some("made by hand"));
            assert_eq!(detail("offset of the heights, not added"), Some("17.5 µm"));
        }
    }
}

#[test]
fn digital_surf_inversions_turn_the_surface_as_their_numbers_say() {
    let inverted = Expected { scale: -SUR.scale, ..SUR };
    let [nx, ny] = POINTS;
    check_at(&read(made::sur(32, 0, 1)), &inverted, |point| point);
    check_at(&read(made::sur(32, 0, 2)), &inverted, |[x, y]| [nx - 1 - x, y]);
    check_at(&read(made::sur(32, 2, 3)), &inverted, |[x, y]| [x, ny - 1 - y]);
}

#[test]
fn digital_surf_says_what_is_wrong() {
    let changed = |at: usize, value: &[u8]| {
        let mut bytes = made::sur(32, 0, 0);
        bytes[at..at + value.len()].copy_from_slice(value);
        refusal(bytes)
    };
    assert_eq!(changed(12, &[0, 1]), "the byte order has number 256; it must be 0, that of PCs");
    assert_eq!(changed(18, &[20, 0]), "the data have type 20; they must be a surface (2) or a profile (1)");
    assert_eq!(changed(98, &[8, 0]), "a height has 8 bits; it must have 16 or 32");
    assert_eq!(changed(108, &[0, 0]), "the number of points of a line is 0; it must be at least 1");
    assert_eq!(changed(116, &[21]), "the number of points is 21; it must be 5 times 4");
    let unit = changed(212, b"a.u.");
    assert!(unit.starts_with("object 0 is \"Z\" in \"a.u."), "{unit}");
    // The numbers of the header agree with each other, but not with the file.
    let mut lying = made::sur(32, 0, 0);
    lying[108..120].copy_from_slice(&[0, 0, 1, 0, 0, 64, 0, 0, 0, 0, 0, 64]);
    let lie = refusal(lying);
    assert!(lie.starts_with("a block of 4294967296 bytes starts at byte 527"), "{lie}");
    // So do the numbers in a compressed file, where the stream sizes agree as well.
    let mut bomb = made::sur(32, 1, 0);
    bomb[108..120].copy_from_slice(&[0, 0, 1, 0, 0, 16, 0, 0, 0, 0, 0, 16]);
    bomb[531..535].copy_from_slice(&[0, 0, 0, 64]);
    let bomb = refusal(bomb);
    assert!(bomb.starts_with("the grid has 65536 by 4096 points; "), "{bomb}");
}

#[test]
fn bytes_behind_the_heights_of_digital_surf_are_a_warning() {
    for (streams, at) in [(0, 537), (0, usize::MAX), (1, usize::MAX)] {
        let mut bytes = made::sur(16, streams, 0);
        assert!(read(bytes.clone()).warnings.is_empty());
        let end = bytes.len();
        bytes.insert(at.min(end), 0);
        let says = format!("the file has {} bytes, and its heights end at byte {end}; ", end + 1);
        let [warning] = &read(bytes).warnings[..] else { panic!("{streams}, {at}") };
        assert!(warning.starts_with(&says), "{warning}");
    }
}

#[test]
fn a_compressed_surface_must_have_as_many_heights_as_it_says() {
    let whole = made::sur(32, 1, 0);
    let start = whole.len() - made::deflated(&[]).len();
    let mut short = whole.clone();
    short.truncate(start);
    assert!(refusal(short).contains("it must lie within the"), "a stream that ends early");
    // A stream of more bytes than stated in the header.
    let mut long = whole[..527].to_vec();
    let stream = made::deflated(&[0; 4 * 20 + 1]);
    long.extend([1_u32, 80, stream.len() as u32].iter().flat_map(|value| value.to_le_bytes()));
    long.extend(stream);
    assert_eq!(refusal(long), "the compressed heights have more than 80 bytes; they must have 80");
}

#[test]
fn nanoscope_multiplies_by_the_sensitivity_and_turns_the_image() {
    for bytes in [2, 4] {
        let expected = Expected {
            format: "Nanoscope",
            channel: "Height",
            lengths: [10.0, 5.0],
            unit: "µm",
            scale: 2e-3,
            undefined: false,
        };
        let map = check(made::nanoscope(bytes), &expected);
        assert_eq!(map.conversion.as_deref(), Some("heights converted from nm to µm, 1000 nm = 1 µm"));
        assert!(map.details.contains(&("instrument".into(), "Test".into())), "{:?}", map.details);
    }
}

/// Returns the file with a text replaced by one of the same length.
pub(crate) fn edited(bytes: Vec<u8>, from: &str, to: &str) -> Vec<u8> {
    assert_eq!(from.len(), to.len());
    let at = bytes.windows(from.len()).position(|window| window == from.as_bytes()).unwrap();
    [&bytes[..at], to.as_bytes(), &bytes[at + to.len()..]].concat()
}

#[test]
fn nanoscope_says_what_is_wrong() {
    let refused = |from: &str, to: &str| refusal(edited(made::nanoscope(2), from, to));
    assert_eq!(refused("mode: Image", "mode: Force"), "the file holds force curves; it must hold images");
    assert_eq!(refused("nm/V", "nA/V"), "the file has only Height; it must have an image with a length per volt");
    assert_eq!(refused("0x05120130", "0x0512013z"), "the version is \"0x0512013z\"; it must be a hexadecimal number");
    assert!(refused("@2:Z scale", "@9:Z scale").contains("it must have one, as in versions after 4.2"));
    assert_eq!(refused("line: 5", "line: 9"), "the image of 9 by 4 points has 40 bytes; it must have 2 for each");
    assert_eq!(refused("offset: 1024", "offset: 9024"), "the image Height has 0 bytes; it must have 40");
    assert_eq!(refused("pixel: 2", "pixel: 3"), "a pixel has 3 bytes; it must have 2 or 4");
    assert_eq!(
        refused("\\*File list", "?*File list"),
        "the heights are stored as text; they must be stored as binary numbers"
    );
}

#[test]
fn wyko_multiplies_by_the_wavelength_and_stretches_along_y() {
    for bytes in [2, 4] {
        let expected = Expected {
            format: "Wyko OPD",
            channel: "RAW_DATA",
            lengths: [2.5, 4.0],
            unit: "mm",
            scale: 1e-4,
            undefined: true,
        };
        let map = check(made::opd(bytes), &expected);
        assert_eq!(map.details, [("title".to_owned(), "made by hand".to_owned())]);
    }
    let without = refusal(edited(made::opd(2), "Wavelength", "wavelength"));
    assert_eq!(without, "the file has no block Wavelength; it must have one");
    let without = refusal(edited(made::opd(2), "RAW_DATA", "INTENSIT"));
    assert!(
        without.starts_with("the file has no block of heights; it must have one of RAW DATA, RAW_DATA"),
        "{without}"
    );
}

#[test]
fn dektak_extents_reach_from_the_first_point_to_the_last() {
    let expected = Expected {
        format: "Dektak OPDx",
        channel: "Raw",
        lengths: [4.0 * 5.0 / 4.0, 3.0 * 4.0 / 3.0],
        unit: "mm",
        scale: 1.5e-3,
        undefined: true,
    };
    let map = check(made::opdx(true), &expected);
    assert_eq!(map.details, [("date".to_owned(), "2020-02-03".to_owned())]);

    let profile = read(made::opdx(false));
    assert_eq!(profile.heights.dim(), (5, 1));
    assert_eq!(profile.lengths, Some([5.0, 1.0]));
    assert!((profile.heights[[4, 0]] - 1.5e-3 * f64::from(height(4, 0))).abs() < 1e-15);
}

#[test]
fn containers_of_dektak_are_not_followed_without_end() {
    let magic = b"VCA DATA\x01\0\0\x55".to_vec();
    let nested = (0..100).fold(vec![], |inner: Vec<u8>, _| {
        let length = u32::try_from(inner.len()).unwrap().to_le_bytes();
        [&[0, 0, 0, 0, 0x7d, 4][..], &length, &inner].concat()
    });
    assert_eq!(refusal([magic, nested].concat()), "the containers are nested 33 deep; they must be at most 32");
}

#[test]
fn alicona_lines_are_padded_and_a_tag_names_the_height_of_undefined_points() {
    let expected = Expected {
        format: "Alicona AL3D",
        channel: "depth",
        lengths: [2.5, 1.0],
        unit: "m",
        scale: 1.0,
        undefined: true,
    };
    let map = check(made::al3d(), &expected);
    assert_eq!(map.details, [("software".to_owned(), "by hand".to_owned())]);
    let short = made::al3d();
    let short = refusal(short[..short.len() - 5].to_vec());
    assert_eq!(short, "a block of 96 bytes starts at byte 640; it must lie within the 731 bytes of the file");
}

#[test]
fn heights_that_are_larger_than_any_are_a_warning() {
    let mut bytes = made::al3d();
    let data = 640..bytes.len();
    for (k, height) in bytes[data].chunks_exact_mut(4).enumerate() {
        height.copy_from_slice(&(1e-6 * (k as f32).sin()).to_le_bytes());
    }
    assert!(read(bytes.clone()).warnings.is_empty());
    // A lost byte shifts all others.
    bytes.remove(641);
    bytes.push(0);
    let [warning] = &read(bytes).warnings[..] else { panic!() };
    assert!(warning.contains(" of 20 heights are larger than 10000 m, up to "), "{warning}");
}

#[test]
fn metropro_is_big_endian_and_scales_phases() {
    let scale = 0.5 * 2.0 / 32768.0;
    let expected =
        Expected { format: "Zygo MetroPro", channel: "phase", lengths: [2.5, 2.0], unit: "m", scale, undefined: true };
    for (version, intensities) in [(1, 0), (2, 2), (3, 1)] {
        check(made::metropro(version, intensities), &expected);
    }
    let mut unknown = made::metropro(1, 0);
    unknown[219] = 7;
    assert_eq!(refusal(unknown), "the resolution of the phase has number 7; it must be 0, 1 or 2");
}

#[test]
fn igor_waves_have_either_order_of_bytes_and_name_their_channels() {
    let expected = Expected {
        format: "Igor binary wave",
        channel: "HeightTrace",
        lengths: [2.5, 1.0],
        unit: "m",
        scale: 1.0,
        undefined: false,
    };
    for is_big in [false, true] {
        let map = check(made::ibw(is_big), &expected);
        assert_eq!(map.channels, ["HeightTrace"], "the phase is no height");
        assert!(map.notes.is_empty(), "{:?}", map.notes);
        let mut damaged = made::ibw(is_big);
        damaged[64 + 200] ^= 1;
        assert_eq!(read(damaged).warnings, ["the checksum of the header is wrong"]);
    }
    let profile = read(made::ibw_profile());
    assert_eq!((profile.heights.dim(), profile.lengths), ((5, 1), Some([2.5, 1.0])));
    assert_eq!(profile.heights[[3, 0]], f64::from(height(3, 0)));
}

#[test]
fn sensofar_layers_are_entries_of_a_zip_archive() {
    let expected = Expected {
        format: "Sensofar PLUX",
        channel: "LAYER_0",
        lengths: [2.5, 1.0],
        unit: "µm",
        scale: 1.0,
        undefined: true,
    };
    for method in [CompressionMethod::Stored, CompressionMethod::Deflated] {
        let map = check(made::zipped(&made::plux(), method), &expected);
        assert_eq!(map.details, [("date".into(), "2022-03-04".into()), ("device".to_owned(), "Test".to_owned())]);
    }
    // Decompression bomb: 100 MB of zeros for 20 heights.
    let [index, _] = &made::plux()[..] else { unreachable!() };
    let bomb = made::zipped(&[index.clone(), ("LAYER_0.raw", vec![0; 100_000_000])], CompressionMethod::Deflated);
    assert_eq!(refusal(bomb), "the compressed heights have more than 80 bytes; they must have 80");
}

#[test]
fn entries_of_a_zip_archive_cannot_be_larger_than_the_archive() {
    let mut entries = made::plux();
    for size in ["<IMAGE_SIZE_X>5", "<IMAGE_SIZE_Y>4"] {
        entries[0].1 =
            String::from_utf8(entries[0].1.clone()).unwrap().replace(size, &format!("{}16384", &size[..14])).into();
    }
    let mut bytes = made::zipped(&entries, CompressionMethod::Deflated);
    // Compressed size in the last entry of the directory.
    let entry = bytes.windows(4).rposition(|window| window == b"PK\x01\x02").unwrap();
    bytes[entry + 20..entry + 24].copy_from_slice(&[0xff; 4]);
    let lie = refusal(bytes);
    assert!(
        lie.starts_with("the grid has 16384 by 16384 points; ") || lie.starts_with("the zip archive is damaged"),
        "{lie}"
    );
}

#[test]
fn zygo_mx_leads_from_its_root_to_the_surface() {
    let expected = Expected {
        format: "Zygo Mx",
        channel: "Surface",
        lengths: [2.5, 1.0],
        unit: "m",
        scale: 1e-9,
        undefined: true,
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scan.datx");
    made::datx(&path);
    let map = check(std::fs::read(&path).unwrap(), &expected);
    assert_eq!(map.conversion.as_deref(), Some("heights converted from nm to m, 1000000000 nm = 1 m"));
}

#[test]
fn older_files_of_sensofar_have_an_image_behind_each_layer() {
    let expected = Expected {
        format: "Sensofar PLu",
        channel: "layer0",
        lengths: [2.5, 1.0],
        unit: "µm",
        scale: 1.0,
        undefined: true,
    };
    let map = check(made::plu(), &expected);
    assert_eq!(map.channels, ["layer0", "layer1"]);
    assert_eq!(map.details[0], ("date".into(), "Fri Mar 10 16:35:59 2023".into()));
    let second = Topography::from_bytes("scan", made::plu(), Some("1")).unwrap();
    check_at(&second, &Expected { channel: "layer1", ..expected }, |point| point);
}

#[test]
fn molecular_imaging_scales_by_the_range_of_the_channel() {
    for bits in [16, 32] {
        let expected = Expected {
            format: "Molecular Imaging",
            channel: "Topography",
            lengths: [1e-5, 5e-6],
            unit: "m",
            scale: 1e-6 / 1024.0,
            undefined: false,
        };
        let map = check(made::mi(bits), &expected);
        assert_eq!(map.channels, ["Topography"], "friction is no height");
    }
    let wrong = refusal(edited(made::mi(16), "BINARY", "ASCII_"));
    assert_eq!(wrong, "the data are \"ASCII_\"; they must be BINARY or BINARY_32");
    let shorter = |hand: &str, points: &str| format!("{hand}\nmode          Contact AFM\nxPixels       {points}\n");
    let wrong = refusal(edited(made::mi(16), &shorter("hand", "5"), &shorter("ha", "5.5")));
    assert_eq!(wrong, "xPixels is 5.5; it must be a whole number");
}

#[test]
fn nanosurf_covers_the_range_of_the_channel() {
    let expected = Expected {
        format: "Nanosurf",
        channel: "Scan forward (Z-Axis)",
        lengths: [1e-5, 5e-6],
        unit: "m",
        scale: 2_f64.powi(-20),
        undefined: false,
    };
    let map = check(made::nanosurf(), &expected);
    assert_eq!(map.channels, ["Scan forward (Z-Axis)"], "deflection is no height");
    // A range that is not centred at zero.
    let shifted = read(edited(
        made::nanosurf(),
        "Dim2Min=-0.03125\r\nSaveMode=Binary\r\nSaveBits=16\r\nSaveSign=Signed\r\nSaveOrder=Intel\r\n#!",
        "Dim2Min=+0.03125\r\nSaveMode=Binary\r\nSaveBits=16\r\nSaveSign=Signed\r\nSaveOrder=Intel\r\n#!",
    ));
    assert_eq!(shifted.heights, map.heights.mapv(|height| height + 0.0625));
}

/// Writes heights 0, 1, ... in HDF5 with coordinates of 3 x 4 points in units; an empty unit means no unit.
fn hdf5(units: [&str; 3]) -> Result<Topography, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("h.h5");
    let [ux, uy, uz] = units.map(|unit| if unit.is_empty() { "length" } else { unit });
    let output = Output::claim(&path).unwrap();
    let mut archive = Archive::create(&output, &Provenance::default()).unwrap();
    let x = Dimension::values("x", vec![0.0, 0.5, 1.0], ux, "position along x");
    let y = Dimension::values("y", vec![1.0, 3.0, 5.0, 7.0], uy, "position along y");
    let heights: Vec<f64> = (0..12).map(f64::from).collect();
    archive.write("/heights", &Variable { dimensions: &[&x, &y], units: uz, long_name: "height" }, &heights).unwrap();
    archive
        .write("/line/heights", &Variable { dimensions: &[&x], units: uz, long_name: "height" }, &heights[..3])
        .unwrap();
    archive.finish().unwrap();
    let line = Topography::read(path.to_str().unwrap(), Some("/line/heights")).map(|line| (line.lengths, line.heights));
    let map = Topography::read(path.to_str().unwrap(), Some("/heights")).map_err(|error| error.reason)?;
    // A profile has the units of x and of its heights.
    let (lengths, heights) = line.map_err(|error| error.reason)?;
    assert_eq!(lengths.map(|[x, _]| x), map.lengths.map(|[x, _]| x));
    assert_eq!(heights[[2, 0]], map.heights[[0, 2]]);
    Ok(map)
}

#[test]
fn heights_and_both_coordinates_of_hdf5_have_units_of_their_own() {
    // 1 nm is 1e-9 m and 1 µm is 1e-6 m.
    let map = hdf5(["m", "µm", "nm"]).unwrap();
    assert_eq!((map.lengths, map.unit.as_deref()), (Some([1.5, 8.0 / 1e6]), Some("m")));
    assert!(map.heights.iter().zip(0..).all(|(height, k)| *height == f64::from(k) / 1e9), "{}", map.heights);
    assert_eq!(map.conversion.as_deref(), Some("heights converted from nm to m, 1000000000 nm = 1 m"));
    assert_eq!(map.notes, ["the length along y converted from µm to m, 1000000 µm = 1 m"]);
    let plain = hdf5(["", "", ""]).unwrap();
    assert_eq!((plain.lengths, plain.unit, plain.conversion), (Some([1.5, 8.0]), None, None));
    for (units, says) in [
        (["m", "", "m"], "the unit of x is m but y has no unit"),
        (["", "m", "m"], "the unit of y is m but x has no unit"),
        (["m", "m", ""], "the unit of the lengths is m but the heights have no unit"),
        (["", "", "nm"], "the unit of the heights is nm but the lengths have no unit"),
        (["m", "V", "nm"], "the unit is \"V\"; it must be one of m"),
    ] {
        let found = hdf5(units).unwrap_err();
        assert!(found.starts_with(says), "{units:?}: {found}");
    }
}

/// Returns a file with the bytes at some places replaced.
fn patched(mut bytes: Vec<u8>, patches: &[(usize, &[u8])]) -> Vec<u8> {
    patches.iter().for_each(|(at, patch)| bytes[*at..at + patch.len()].copy_from_slice(patch));
    bytes
}

#[test]
fn axes_of_netcdf_and_igor_have_units_of_their_own() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/holes.nc");
    let netcdf = std::fs::read(path).unwrap();
    let units: Vec<usize> = (0..netcdf.len()).filter(|at| netcdf[*at..].starts_with(b"um\0\0")).collect();
    // The variables are heights, x, y.
    let &[z, x, y] = &units[..] else { panic!("{units:?}") };
    let whole = read(netcdf.clone());
    let other = read(patched(netcdf.clone(), &[(y, b"mm")]));
    let [[lx, ly], found] = [whole.lengths.unwrap(), other.lengths.unwrap()];
    assert_eq!((found, other.unit.as_deref()), ([lx, ly * 1e3], Some("µm")));
    assert_eq!(other.notes, ["the length along y converted from mm to µm, 1 mm = 1000 µm"]);
    let says = |places: &[usize]| {
        let patches: Vec<(usize, &[u8])> = places.iter().map(|at| (*at, &b"\0\0"[..])).collect();
        refusal(patched(netcdf.clone(), &patches))
    };
    assert!(says(&[z]).starts_with("the unit of the lengths is µm but the heights have no unit"), "{}", says(&[z]));
    assert!(
        says(&[x, y]).starts_with("the unit of the heights is µm but the lengths have no unit"),
        "{}",
        says(&[x, y])
    );
    assert!(says(&[x]).starts_with("the unit of y is um but x has no unit"), "{}", says(&[x]));
    assert!(says(&[y]).starts_with("the unit of x is um but y has no unit"), "{}", says(&[y]));

    const Y: usize = 64 + 148 + 8;
    let map = read(patched(made::ibw(false), &[(Y, b"mm")]));
    assert_eq!(map.lengths.unwrap(), [2.5, 1.0 / 1e3]);
    assert!(refusal(patched(made::ibw(false), &[(Y, b"\0")])).starts_with("the unit of x is m but y has no unit"));
    const DATA: usize = 16 + 34;
    let profile = |patches: &[(usize, &[u8])]| {
        Topography::from_bytes("scan", patched(made::ibw_profile(), patches), None).map_err(|error| error.reason)
    };
    let said = [DATA, DATA + 4].map(|at| profile(&[(at, b"\0")]).unwrap_err());
    assert!(said[0].starts_with("the unit of the lengths is m but the heights have no unit"), "{}", said[0]);
    assert!(said[1].starts_with("the unit of the heights is m but the lengths have no unit"), "{}", said[1]);
    // Igor writes a spacing of 1 without a unit if none was set.
    let unset = profile(&[(DATA + 4, b"\0"), (16 + 48, &1_f64.to_be_bytes())]).unwrap();
    assert_eq!((unset.lengths, unset.unit.as_deref()), (None, Some("m")));
}

#[test]
fn columns_of_points_have_units_of_their_own() {
    let list = |header: &str| {
        let points = (0..12).map(|k| (f64::from(k / 4) * 0.5, k % 4 * 2, k));
        let rows: String = points.map(|(x, y, z)| format!("{x};{y};{z}\n")).collect();
        Topography::from_bytes("scan", format!("{header}\n{rows}").into_bytes(), None).map_err(|error| error.reason)
    };
    let map = list("x in µm;y in nm;z in nm").unwrap();
    assert_eq!((map.lengths, map.unit.as_deref()), (Some([1.5, 8.0 / 1e3]), Some("µm")));
    assert_eq!(map.heights[[2, 3]], 11.0 / 1e3);
    for (header, says) in [
        ("x in µm;y;z in nm", "the unit of x is µm but y has no unit"),
        ("x;y;z in nm", "the unit of the heights is nm but the lengths have no unit"),
        ("x in m;y in m;z", "the unit of x is m but the title \"z\" of the heights has no unit of length"),
    ] {
        let found = list(header).unwrap_err();
        assert!(found.starts_with(says), "{header}: {found}");
    }
    assert_eq!(list("x;y;z").unwrap().unit, None);
    // Names of several words between blanks.
    let profile = b"Length (mm) Depth (um)\n0 1\n1 2\n2 3\n3 5\n".to_vec();
    let map = read(profile);
    assert_eq!((map.lengths, map.unit.as_deref()), (Some([4.0, 1.0]), Some("mm")));
    assert_eq!(map.heights[[3, 0]], 5.0 / 1e3);
}

#[test]
fn sizes_and_scales_that_are_not_there_are_not_made_up() {
    let x3p = |name: &str, change: &dyn Fn(String) -> String| {
        let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name);
        let mut archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
        let names: Vec<String> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
        let mut entries = vec![];
        for name in &names {
            let mut bytes = vec![];
            std::io::Read::read_to_end(&mut archive.by_name(name).unwrap(), &mut bytes).unwrap();
            if name == "main.xml" {
                bytes = change(String::from_utf8(bytes).unwrap()).into_bytes();
            }
            entries.push((name.as_str(), bytes));
        }
        let bytes = made::zipped(&entries, CompressionMethod::Deflated);
        Topography::from_bytes("scan", bytes, None).map_err(|error| error.reason)
    };
    let without = |axis: &'static str| {
        move |xml: String| {
            let start = xml.find(&format!("<{axis}>")).unwrap();
            let [from, to] = ["<Increment>", "</Increment>"].map(|tag| start + xml[start..].find(tag).unwrap());
            format!("{}{}", &xml[..from], &xml[to + "</Increment>".len()..])
        }
    };
    for axis in ["CX", "CY", "CZ"] {
        let says = format!("main.xml has no Record1/Axes/{axis}/Increment; it must have one");
        assert_eq!(x3p("int32.x3p", &without(axis)).unwrap_err(), says);
    }
    assert!(x3p("double.x3p", &|xml| xml).is_ok(), "floats are heights without an increment");

    // Both channels are listed; the first is not a height.
    let missing = (0..2).fold(made::nanosurf(), |bytes, _| edited(bytes, "Dim1Unit=m", "Dim1Unix=m"));
    assert!(refusal(missing).ends_with("has no Dim1Unit; it must have it"));
    let gsf = |sizes: &str| {
        let mut bytes = format!("Gwyddion Simple Field 1.0\nXRes = 2\nYRes = 2\n{sizes}").into_bytes();
        bytes.resize((bytes.len() / 4 + 1) * 4, 0);
        bytes.extend([0; 16]);
        Topography::from_bytes("scan", bytes, None).map_err(|error| error.reason)
    };
    assert_eq!(gsf("XReal = 3\nYReal = 4\n").unwrap().lengths, Some([3.0, 4.0]));
    assert_eq!(gsf("").unwrap().lengths, None);
    assert_eq!(gsf("XReal = 3\n").unwrap_err(), "only one of XReal and YReal is given; both or neither must be given");
    let opd = |size: usize, from: &str, to: &str| edited(made::opd(size), from, to);
    assert!(refusal(opd(2, "Mult\0", "Nult\0")).starts_with("the file has no block Mult"));
    let square = read(opd(2, "Aspect", "Bspect"));
    assert_eq!(square.notes, ["the file has no block Aspect; its pixels are taken to be square"]);
}

#[test]
fn numbers_of_fortran_and_typography_are_read_and_others_refused_by_name() {
    let text = |text: &str| Topography::from_bytes("scan", text.into(), None).map_err(|error| error.reason);
    let heights = |found: &str| text(found).unwrap().heights;
    // The first line is a line of numbers, not a header.
    assert_eq!(heights("1.0-105 2.0D+00\n3 4\n"), ndarray::array![[1e-105, 3.0], [2.0, 4.0]]);
    assert_eq!(heights("1.5d-3 -2.25+101\n3 4\n"), ndarray::array![[1.5e-3, 3.0], [-2.25e101, 4.0]]);
    assert_eq!(heights("\u{2212}1 2\n3 \u{2212}4.5\n"), ndarray::array![[-1.0, 3.0], [2.0, -4.5]]);
    assert_eq!(heights("\u{2212}1,5;2e\u{2212}3\n3;4\n"), ndarray::array![[-1.5, 3.0], [2e-3, 4.0]]);
    for (word, line) in
        [("1_0", "1_0 2"), ("1'000.5", "1'000.5 2"), ("１", "１ 2"), ("1.0Q+00", "1.0Q+00 2"), ("0.5*", "1 0.5*")]
    {
        let column = 1 + line.split(' ').position(|found| found == word).unwrap();
        let says = format!("line 1, column {column} is {word:?}; it must be a number");
        assert_eq!(text(&format!("{line}\n3 4\n")).unwrap_err(), says);
    }
    for header in
        ["a b", "20.05.2024 12:30:11", "20.05.2024 1", "2024-01-15 Smith", "256x256 8bit", "1.5.2 -", "a 1_0", "1_0"]
    {
        assert_eq!(heights(&format!("{header}\n1 2\n3 4\n")), ndarray::array![[1.0, 3.0], [2.0, 4.0]], "{header}");
    }
}

#[test]
fn lines_of_text_end_with_any_mark() {
    let text = |text: &str| Topography::from_bytes("scan", text.into(), None).map_err(|error| error.reason);
    let expected = ndarray::array![[1.0, 4.0], [2.0, 5.0], [3.0, 6.0]];
    for end in ["\n", "\r\n", "\r"] {
        for last in ["", end] {
            let found =
                text(&format!("# Width: 3 mm{end}# Height: 2 mm{end}# Value units: mm{end}1 2 3{end}4 5 6{last}"));
            let found = found.unwrap();
            assert_eq!((found.heights, found.lengths), (expected.clone(), Some([3.0, 2.0])), "{end:?}");
        }
        let says = text(&format!("1 2{end}{end}3 x{end}")).unwrap_err();
        assert_eq!(says, "line 3, column 2 is \"x\"; it must be a number", "{end:?}");
    }
}

#[test]
fn two_channels_of_one_name_are_told_apart_by_their_numbers() {
    let twice = patched(made::ibw(false), &[]);
    let twice = edited(twice, "PhaseTrace\0", "HeightTrace");
    let named = |channel| Topography::from_bytes("scan", twice.clone(), Some(channel));
    let says = "2 channels have the name HeightTrace; the channel must be one of the numbers 0, 1";
    assert_eq!(named("HeightTrace").unwrap_err().reason, says);
    for number in ["0", "1"] {
        assert_eq!(named(number).unwrap().channel.as_deref(), Some("HeightTrace"));
    }
}

#[test]
fn names_and_messages_do_not_steer_a_terminal() {
    let hostile = "HeightT\u{1b}[\n\u{7}";
    let bytes = edited(made::ibw(false), "HeightTrace", hostile);
    let shown = "HeightT\u{fffd}[ \u{fffd}";
    let map = read(bytes.clone());
    assert_eq!((map.channel.as_deref(), map.source.as_str()), (Some(shown), &*format!("scan, channel {shown}")));
    let listing = gfmd_files::Listing::from_bytes("scan", bytes.clone()).unwrap();
    assert_eq!(listing.channels[0].name, shown);
    for name in [shown, hostile] {
        assert_eq!(Topography::from_bytes("scan", bytes.clone(), Some(name)).unwrap().channel.as_deref(), Some(shown));
    }
    let message = Topography::from_bytes("scan", bytes.clone(), Some("x\u{202e}\ny")).unwrap_err().to_string();
    assert!(!message.contains(|c: char| c.is_control() || c == '\u{202e}'), "{message:?}");
    // No channel is a height: the message names all channels.
    let others = edited(edited(bytes, "HeightT", "NothinT"), "PhaseTrace", "P\nh\na\ns\ne\x1b");
    let message = Topography::from_bytes("scan", others, None).unwrap_err().to_string();
    assert!(message.contains("one must be a height") && !message.contains(char::is_control), "{message:?}");
}

/// Describes an X3P of 3 x 2 points with steps of 2 and 3 m, heights as `kind`, and `data` in Record3.
fn main_xml(kind: &str, scale: &str, data: &str) -> Vec<u8> {
    let axis = |name: &str, step: f64| format!("<{name}><AxisType>I</AxisType><Increment>{step}</Increment></{name}>");
    let (x, y) = (axis("CX", 2.0), axis("CY", 3.0));
    format!(
        "<p:ISO5436_2 xmlns:p='http://www.opengps.eu/2008/ISO5436_2'><Record1><FeatureType>SUR</FeatureType>\
         <Axes>{x}{y}<CZ><AxisType>A</AxisType><DataType>{kind}</DataType>{scale}</CZ></Axes></Record1><Record3>\
         <MatrixDimension><SizeX>3</SizeX><SizeY>2</SizeY><SizeZ>1</SizeZ></MatrixDimension>{data}</Record3>\
         </p:ISO5436_2>"
    )
    .into_bytes()
}

#[test]
fn entries_of_x3p_are_found_whatever_their_folder_case_and_slashes() {
    let heights: Vec<u8> = (1..7).flat_map(|z| f64::from(z).to_le_bytes()).collect();
    let link = |name: &str, valid: &str| {
        format!("<DataLink><PointDataLink>{name}</PointDataLink><ValidPointsLink>{valid}</ValidPointsLink></DataLink>")
    };
    let expected = ndarray::array![[1.0, 4.0], [2.0, 5.0], [3.0, 6.0]];
    for (main, data, valid, linked, linked_valid) in [
        ("main.xml", "bindata/data.bin", "bindata/valid.bin", "bindata/data.bin", "bindata/valid.bin"),
        ("scan/main.xml", "scan/bindata/data.bin", "scan/bindata/valid.bin", "bindata/data.bin", "bindata/valid.bin"),
        ("a/b/main.xml", "a/b/bindata/data.bin", "a/b/valid.bin", "./bindata/data.bin", "/valid.bin"),
        ("./main.xml", "./bindata/data.bin", "./bindata/valid.bin", "bindata/data.bin", "/bindata/valid.bin"),
        ("MAIN.XML", "BinData/Data.BIN", "BINDATA/VALID.BIN", "bindata/data.bin", "bindata/valid.bin"),
        ("main.xml", "bindata\\data.bin", "bindata\\valid.bin", "bindata/data.bin", "bindata/valid.bin"),
        ("main.xml", "bindata/data.bin", "bindata/valid.bin", "bindata\\data.bin", ".\\bindata\\valid.bin"),
        ("scan\\Main.xml", "scan\\bindata\\data.bin", "scan\\valid.bin", "bindata/data.bin", "valid.bin"),
        ("scan/main.xml", "bindata/data.bin", "bindata/valid.bin", "bindata/data.bin", "bindata/valid.bin"),
    ] {
        let xml = main_xml("D", "", &link(linked, linked_valid));
        // An archive made on another system has additional entries.
        let others = ("__MACOSX/._main.xml", vec![0]);
        let entries = [others, (main, xml), (data, heights.clone()), (valid, vec![0b0011_1111])];
        let map = read(made::zipped(&entries, CompressionMethod::Deflated));
        assert_eq!((&map.heights, map.lengths), (&expected, Some([6.0, 6.0])), "{main}, {data}");
    }
    let entries = [("main.xml", main_xml("D", "", &link("data.bin", "valid.bin"))), ("other.bin", heights.clone())];
    let missing = refusal(made::zipped(&entries, CompressionMethod::Stored));
    assert_eq!(missing, "the archive has no entry data.bin; main.xml names it");
    let two = [("a/main.xml", main_xml("D", "", "")), ("b/main.xml", main_xml("D", "", ""))];
    let two = refusal(made::zipped(&two, CompressionMethod::Stored));
    assert_eq!(two, "the archive has a/main.xml, b/main.xml; it must have one main.xml");
    let mut cut = made::zipped(&[("main.xml", main_xml("D", "", ""))], CompressionMethod::Stored);
    cut.truncate(cut.len() / 2);
    let cut = refusal(cut);
    assert!(cut.starts_with("the zip archive is damaged: ") && cut.ends_with("; copy the file again"), "{cut}");
}

#[test]
fn wrong_checksums_of_x3p_are_warnings() {
    let digest = |bytes: &[u8]| format!("{:x}", md5::compute(bytes));
    let heights: Vec<u8> = (1..7).flat_map(|z| f64::from(z).to_le_bytes()).collect();
    let main = |sum: &str| {
        let link = "<DataLink><PointDataLink>data.bin</PointDataLink><MD5ChecksumPointData>";
        main_xml("D", "", &format!("{link}{sum}</MD5ChecksumPointData></DataLink>"))
    };
    let (data, wrong) = (digest(&heights), "0".repeat(32));
    let of_main = |sum: &str| digest(&main(sum));
    for (sum, of_main, entries) in [
        (data.clone(), format!("{} *main.xml\n", of_main(&data)), vec![]),
        (data.to_uppercase(), format!("{}\r\n", of_main(&data.to_uppercase()).to_uppercase()), vec![]),
        (wrong.clone(), of_main(&wrong), vec!["data.bin"]),
        (data.clone(), of_main(&wrong), vec!["main.xml"]),
        (wrong.clone(), wrong, vec!["main.xml", "data.bin"]),
    ] {
        let sum_of_main = ("md5checksum.hex", of_main.into_bytes());
        let entries_of_zip = [("main.xml", main(&sum)), ("data.bin", heights.clone()), sum_of_main];
        let map = read(made::zipped(&entries_of_zip, CompressionMethod::Stored));
        assert_eq!(map.heights[[2, 1]], 6.0);
        let start = |entry: &&str| format!("the MD5 checksum of {entry} is ");
        assert_eq!(map.warnings.len(), entries.len(), "{:?}", map.warnings);
        for (warning, entry) in map.warnings.iter().zip(&entries) {
            assert!(warning.starts_with(&start(entry)) && warning.contains(", but "), "{warning}");
        }
    }
    let entries = [("main.xml", main(&data)), ("data.bin", heights), ("md5checksum.hex", b"none".to_vec())];
    let map = read(made::zipped(&entries, CompressionMethod::Stored));
    assert_eq!(map.warnings, ["md5checksum.hex begins with \"none\"; it must be the MD5 checksum of main.xml"]);
}

#[test]
fn x3p_may_list_its_heights_in_the_description() {
    let zip = |xml: Vec<u8>| made::zipped(&[("main.xml", xml)], CompressionMethod::Deflated);
    let listed =
        |kind: &str, scale: &str, data: &str| zip(main_xml(kind, scale, &format!("<DataList>{data}</DataList>")));
    let datum = |values: &[&str]| values.iter().map(|z| format!("<Datum>{z}</Datum>\n")).collect::<String>();
    let all = ["1", "-2.5e0", " 3 ", "4", "5", "6"];
    let map = read(listed("D", "", &datum(&all)));
    assert_eq!(map.heights, ndarray::array![[1.0, 4.0], [-2.5, 5.0], [3.0, 6.0]]);
    assert_eq!((map.lengths, map.unit.as_deref(), map.undefined), (Some([6.0, 6.0]), Some("m"), 0));
    let scale = "<Increment>0.5</Increment><Offset>10</Offset>";
    let scaled = read(listed("L", scale, &datum(&["2", "4", "6", "8", "10", "12"])));
    assert_eq!(scaled.heights, ndarray::array![[11.0, 14.0], [12.0, 15.0], [13.0, 16.0]]);
    for hole in ["<Datum/>", "<Datum />", "<Datum></Datum>", "<p:Datum> </p:Datum>"] {
        let holes = read(listed("D", "", &format!("{hole}{}", datum(&all[1..]))));
        assert!(holes.undefined == 1 && holes.heights[[0, 0]].is_nan(), "{hole}: {}", holes.heights);
    }
    for (data, says) in [
        (datum(&all[1..]), "main.xml lists 5 heights; it must list 3 by 2"),
        (datum(&["1"; 7]), "main.xml lists more than 3 by 2 heights; it must list so many"),
        (datum(&["1;2;3"; 6]), "a Datum of main.xml is \"1;2;3\"; it must be a number or empty"),
    ] {
        assert_eq!(refusal(listed("D", "", &data)), says);
    }
    let neither = refusal(zip(main_xml("D", "", "")));
    assert!(neither.starts_with("main.xml must have either Record3/DataLink/PointDataLink"), "{neither}");
    // A long list does not count as a long description.
    let [nx, ny] = [300_usize, 200];
    let many: String = (0..nx * ny).map(|k| format!("<Datum>{k}.0000000000</Datum>")).collect();
    let xml = String::from_utf8(main_xml("D", "", &format!("<DataList>{many}</DataList>"))).unwrap();
    let xml = xml.replace("<SizeX>3<", "<SizeX>300<").replace("<SizeY>2<", "<SizeY>200<");
    let long = read(zip(xml.into_bytes()));
    assert!(long.heights.indexed_iter().all(|((i, j), z)| *z == (j * nx + i) as f64) && long.heights.dim() == (nx, ny));
}

/// Returns two Nanoscope images: the file of [`made::nanoscope`] with another image section before its own.
fn nanoscope_with(section: &str, names: &str) -> Vec<u8> {
    let whole = made::nanoscope(2);
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    let end = whole.iter().position(|byte| *byte == 0x1a).unwrap();
    let header = text(&whole[..end]).replace("\\*Ciao image list", &format!("{section}\\*Ciao image list"));
    let mut header =
        header.replace("S [Height] \"Height\"", names).replace("offset: 1024", "offset: 2048").into_bytes();
    header.push(0x1a);
    header.resize(2048, 0);
    [header, whole[1024..].to_vec()].concat()
}

#[test]
fn channels_of_nanoscope_have_the_names_that_people_see() {
    let file = nanoscope_with("", "S [ZSensor] \"Height Sensor\"");
    let read = |channel: &str| Topography::from_bytes("scan", file.clone(), Some(channel));
    for name in ["ZSensor", "Height Sensor", "height sensor", "zsensor", "0"] {
        assert_eq!(read(name).unwrap().channel.as_deref(), Some("ZSensor"), "{name}");
    }
    let other = read("Phase").unwrap_err().reason;
    assert_eq!(other, "the channel is Phase; it must be one of 0 ZSensor (Height Sensor)");
}

#[test]
fn images_of_nanoscope_without_points_do_not_hide_the_others() {
    let whole = read(made::nanoscope(2));
    for (points, lines) in [("0 0", "0"), ("0", "0"), ("5", "0"), ("0", "4")] {
        let empty = format!(
            "\\*Ciao image list\r\n\\Data offset: 2048\r\n\\Data length: 4\r\n\\Samps/line: {points}\r\n\
             \\Number of lines: {lines}\r\n\\Scan size: 10 5 ~m\r\n\\@2:Image Data: S [Input2] \"Input2\"\r\n\
             \\@2:Z scale: V [Sens. Zsens] (0.125 V/LSB) 8192.0 V\r\n"
        );
        let map = read(nanoscope_with(&empty, "S [Height] \"Height\""));
        assert_eq!((&map.heights, map.channel.as_deref()), (&whole.heights, Some("Height")));
        assert_eq!(map.channels, ["Height"]);
    }
}
