//! Files with one grid behind a short head, of probe microscopes, and of images, built by hand.

use gfmd_topography::{Listing, Reading, Topography};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use crate::instruments::{Expected, check, check_at, edited, read, refusal};
use crate::made::{self, grids, keyence, mnt, olympus, others, probes, tiff, xlsx};

const GRID: Expected =
    Expected { format: "", channel: "", lengths: [2.5, 1.0], unit: "µm", scale: 1.0, undefined: true };

/// Checks a map whose heights begin at `lowest`; heights of the other files begin at zero.
fn check_above(lowest: f64, bytes: Vec<u8>, expected: &Expected) {
    let mut map = read(bytes);
    map.heights.mapv_inplace(|height| height + lowest);
    check_at(&map, expected, |point| point);
}

#[test]
fn grids_of_profilometers_have_their_scale_size_and_missing_points() {
    for comment in ["a comment", ""] {
        check(grids::tmd(comment), &Expected { format: "TrueMap", unit: "mm", ..GRID });
    }
    for has_intensity in [true, false] {
        let expected = Expected { format: "NanoFocus", scale: 0.125, undefined: has_intensity, ..GRID };
        let map = check(grids::nms(has_intensity), &expected);
        assert_eq!(map.details, [("date".to_owned(), "2024-02-29".to_owned())]);
    }
    for has_date in [true, false] {
        check(grids::os3d(has_date), &Expected { format: "OmniSurf3D", ..GRID });
    }
    check_above(-18.75, grids::zmg(), &Expected { format: "Zeta", scale: 0.125, undefined: false, ..GRID });
    for has_images in [false, true] {
        let channel = if has_images { "Topography" } else { "" };
        let expected = Expected { format: "FRT MicroProf", channel, unit: "m", scale: 0.125, ..GRID };
        check(grids::frt(has_images), &expected);
    }
}

#[test]
fn bcr_has_integers_or_floats_behind_a_head_in_either_encoding() {
    for (is_integer, scale) in [(true, 0.125e-3), (false, 1e-3)] {
        for is_wide in [false, true] {
            let map = check(grids::bcr(is_integer, is_wide), &Expected { format: "BCR", scale, ..GRID });
            assert_eq!(map.notes[0], "the length along y converted from nm to µm, 1000 nm = 1 µm");
        }
    }
    // MountainsMap writes no mark of UTF-16.
    let marked = grids::bcr(false, true);
    let bare = [&marked[2..800], &[b' ', 0], &marked[800..]].concat();
    assert_eq!(read(bare).heights.len(), 20);
    let unit = refusal(edited(grids::bcr(true, false), "% a comment", "zunit = V  "));
    assert_eq!(unit, "the unit of the heights is V; it must be a unit of length: m, mm, µm, nm, ...");
    let scale = refusal(edited(grids::bcr(true, false), "bit2nm = 0.125", "bit2nm = 0.000"));
    assert_eq!(scale, "bit2nm is 0; it must be finite and not zero");
}

#[test]
fn grids_of_surfer_have_no_unit_and_begin_with_the_bottom_line() {
    for version in [6, 7] {
        let map = check_bare("Surfer", read(grids::surfer(version)), Some(GRID.lengths));
        assert_eq!((map.undefined, map.warnings.len()), (1, 0));
        let mut narrow = grids::surfer(version);
        let at = narrow.windows(8).position(|bytes| bytes == 271_f64.to_le_bytes()).unwrap();
        narrow[at..at + 8].copy_from_slice(&246_f64.to_le_bytes());
        let says =
            " of 20 heights are outside the range in the head, -150 to 246, the furthest at 271; head or heights";
        assert!(read(narrow).warnings[0].contains(says));
    }
}

#[test]
fn probe_microscopes_turn_their_lines_and_scale_their_heights() {
    for is_integer in [true, false] {
        let expected = Expected { format: "WSxM", channel: "Topography", scale: 0.125e-3, undefined: false, ..GRID };
        check(probes::wsxm(is_integer), &expected);
    }
    for is_down in [true, false] {
        let expected = Expected { format: "Nanonis SXM", channel: "Z forward", unit: "m", ..GRID };
        check(probes::sxm(is_down), &expected);
        let backward = Topography::from_bytes("scan", probes::sxm(is_down), Some("1")).unwrap();
        check_at(&backward, &Expected { channel: "Z backward", ..expected }, |point| point);
    }
    let expected = Expected { format: "NT-MDT", channel: "Height (Heigh)", scale: 0.125e-3, undefined: false, ..GRID };
    check(probes::mdt(), &expected);
    check(probes::mda(), &Expected { channel: "Height", scale: 0.125, ..expected });
}

#[test]
fn probe_microscopes_say_what_is_wrong() {
    let wsxm = |from: &str, to: &str| refusal(edited(probes::wsxm(true), from, to));
    assert_eq!(
        wsxm("Amplitude: 128 nm", "Amplitude: 128  V"),
        "Topography is in \"V\"; it must be in a unit of length"
    );
    assert_eq!(
        wsxm("um: 1000", "um:  -24"),
        "Minimum and Maximum are both -24; integers have heights only if they differ"
    );
    assert_eq!(
        wsxm("SxM Image", "SxM Curve"),
        "the second line is not \"SxM Image file\"; the file must hold an image"
    );
    let sxm = |from: &str, to: &str| refusal(edited(probes::sxm(true), from, to));
    assert_eq!(sxm("\tm\t", "\tV\t"), "the channels are Current in A, Z in V; one must be Z in a unit of length");
    assert_eq!(
        sxm("5  4", "5 44"),
        "a block of 880 bytes starts at byte 268; it must lie within the 508 bytes of the file"
    );
    let mut mdt = probes::mdt();
    let at = mdt.len() - 40 - 9 - 30 - 8 - 9 - 6 - 2;
    mdt[at..at + 2].copy_from_slice(&i16::MAX.to_le_bytes());
    let found = refusal(mdt);
    assert_eq!(
        found,
        "the frames are type 3, DFL without a unit of length, Height without a unit of length; one must be a \
         map in a unit of length"
    );
}

#[test]
fn a_file_that_ends_early_is_refused_with_both_numbers() {
    for (mut bytes, needed) in [
        (grids::tmd(""), "the heights of 5 by 4 points have 79 bytes; they must have 80"),
        (grids::zmg(), "the heights of 5 by 4 points have 39 bytes; they must have 40"),
        (grids::bcr(false, false), "the heights of 5 by 4 points have 79 bytes; they must have 80"),
        (grids::surfer(6), "the heights of 5 by 4 points have 79 bytes; they must have 80"),
        (grids::surfer(7), "the heights of 5 by 4 points have 159 bytes; they must have 160"),
        (probes::wsxm(true), "the heights of 5 by 4 points have 39 bytes; they must have 40"),
    ] {
        bytes.pop();
        assert_eq!(refusal(bytes), needed);
    }
    for mut bytes in [grids::nms(true), grids::nms(false), grids::frt(true), probes::sxm(true), probes::mda()] {
        bytes.pop();
        assert!(refusal(bytes).contains("it must lie within the"));
    }
}

#[test]
fn keyence_has_the_size_of_a_pixel_and_marks_points_not_measured() {
    let expected = Expected { format: "Keyence VK", channel: "Height 1", scale: 0.125, undefined: false, ..GRID };
    for bytes in [keyence::vk(3), keyence::vk(4), keyence::vk_archive(7)] {
        check_above(-18.75, bytes, &expected);
    }
    check_above(-18.75, keyence::vk_archive(6), &Expected { undefined: true, ..expected });
    let second = Topography::from_bytes("scan", keyence::vk(4), Some("Height 2")).unwrap();
    assert_eq!(second.heights[[4, 0]], 2.0 * 0.125 * 421.0);
    let zon = Expected { format: "Keyence ZON", lengths: [2.5, 2.0], unit: "m", scale: 0.125, ..GRID };
    for version in [0, 1] {
        let map = check(keyence::zon(version), &zon);
        assert_eq!(map.notes, ["1 points with other marks keep their heights; some programs leave them out"]);
    }
    let mut bytes = keyence::vk(4);
    bytes[12 + 4 * 18 + 4 * 44..][..4].fill(0);
    assert_eq!(refusal(bytes), "the height of a count is 0; it must be finite and not zero");
    let mut bytes = keyence::vk(4);
    bytes[12 + 4 * 18 + 180..][..4].fill(0x7f);
    assert_eq!(refusal(bytes), "the heights have 80 bytes; 2139062143 by 4 points need 34224994288");
    let no_frame = refusal(edited(keyence::zon(0), "KPK0", "KPK1"));
    assert!(no_frame.starts_with("the frame of Zstandard 686613b8-27b5-4a29-8ffc-438c2780873e is damaged: "));
    let frame = compress_to_vec(&vec![0; 4 << 20][..], CompressionLevel::Fastest);
    let archive = made::zipped(&[("686613b8-27b5-4a29-8ffc-438c2780873e", frame)], zip::CompressionMethod::Stored);
    assert!(
        refusal([b"KPK1".to_vec(), archive].concat()).ends_with(" has more than 1048576 bytes; it must have fewer")
    );
}

#[test]
fn jpk_and_park_scale_by_their_tags_and_begin_with_the_bottom_line() {
    for [is_big, is_reflected] in [[true, false], [false, false], [false, true]] {
        let bytes = tiff::jpk(is_big, is_reflected);
        let expected = Expected { format: "JPK", channel: "Height", unit: "m", scale: 0.125, undefined: false, ..GRID };
        let map = check(bytes.clone(), &expected);
        assert_eq!(
            (map.channels, map.notes.len()),
            (vec!["Height".into(), "Height (retrace)".into()], usize::from(is_reflected))
        );
        let retrace = Topography::from_bytes("scan", bytes, Some("1")).unwrap();
        check_at(&retrace, &Expected { channel: "Height (retrace)", scale: 0.25, ..expected }, |point| point);
    }
    for (is_second, unit, notes) in [(false, "um", 0), (true, "", 1)] {
        let expected = Expected { format: "Park", channel: "Topography", scale: 0.125, undefined: false, ..GRID };
        assert_eq!(check(tiff::park(is_second, unit), &expected).notes.len(), notes);
    }
    assert_eq!(refusal(tiff::park(false, "nN")), "Topography is in \"nN\"; it must be in a unit of length");
    let mut jpk = tiff::jpk(true, false);
    while let Some(at) = jpk.windows(6).position(|word| word == b"Linear") {
        jpk[at..at + 6].copy_from_slice(b"Square");
    }
    let scale = refusal(jpk);
    assert_eq!(scale, "the scale of calibrated is \"SquareScaling\"; it must be LinearScaling");
}

#[test]
fn lext_leaves_out_points_of_its_mask() {
    let expected = Expected { format: "Olympus LEXT", channel: "HEIGHT", scale: 0.125, ..GRID };
    check_above(-18.75, tiff::lext(), &expected);
}

/// Checks a map without a unit.
fn check_bare(format: &'static str, mut map: Topography, lengths: Option<[f64; 2]>) -> Topography {
    assert_eq!((map.unit.take(), map.lengths), (None, lengths));
    map.unit = Some(String::new());
    map.lengths = Some(GRID.lengths);
    let undefined = map.undefined > 0;
    check_at(&map, &Expected { format, unit: "", undefined, ..GRID }, |point| point);
    map
}

/// Checks an image without a unit.
fn check_plain(bytes: Vec<u8>, lengths: Option<[f64; 2]>) -> Topography {
    check_bare("TIFF", read(bytes), lengths)
}

#[test]
fn images_have_a_size_only_if_a_program_says_so() {
    assert!(check_plain(tiff::deflated_strips(), None).warnings.is_empty());
    check_plain(tiff::float_tiles(), None);
    for bytes in [tiff::imagej(false), tiff::ome()] {
        let warnings = check_plain(bytes, Some(GRID.lengths)).warnings;
        assert_eq!(warnings, ["the lengths are in µm, and the heights have no unit; both are given without one"]);
    }
    check(tiff::imagej(true), &Expected { format: "TIFF", scale: 0.125e-3, undefined: false, ..GRID });
    let map = check(tiff::ground(1), &Expected { format: "TIFF", unit: "m", scale: 0.125, ..GRID });
    assert_eq!(map.warnings, ["the file names no unit of the heights; the unit along the ground is assumed"]);
}

#[test]
fn a_matrix_of_coordinates_tells_spacing_and_order_of_the_lines_or_a_turn() {
    let expected = Expected { format: "TIFF", unit: "m", scale: 1.0, undefined: false, ..GRID };
    let north_first = check(tiff::ground_with_matrix([0.5, 0.0, -0.25]), &expected);
    let read = |matrix| Topography::from_bytes("scan", tiff::ground_with_matrix(matrix), None).unwrap();
    let south_first = read([0.5, 0.0, 0.25]);
    assert_eq!(south_first.lengths, north_first.lengths);
    assert_eq!(south_first.heights, north_first.heights.slice(ndarray::s![.., ..;-1]));
    let found = refusal(tiff::ground_with_matrix([0.5, 0.1, -0.25]));
    assert!(found.starts_with("the image is turned against the coordinates; "), "{found}");
    assert_eq!(
        refusal(tiff::ground_with_matrix([-0.5, 0.0, -0.25])),
        "the spacing along x is -0.5; it must be positive and finite"
    );
}

#[test]
fn images_of_8_bits_in_memory_and_in_archives_are_heights_if_the_caller_says_so() {
    for bytes in [others::png_of_8_bits(), others::gzipped(&others::png_of_8_bits())] {
        assert!(refusal(bytes.clone()).starts_with("the image has 8 bits a pixel, as pictures have; "));
        let reading = Reading { image_heights: true, ..Reading::default() };
        let map = Topography::from_bytes_as("scan", bytes.clone(), reading).unwrap();
        assert_eq!(map.heights, ndarray::arr2(&[[3.0, 1.0], [4.0, 2.0]]));
        assert_eq!(Listing::from_bytes("scan", bytes).unwrap().channels.len(), 1);
    }
}

#[test]
fn channels_are_found_by_names_as_programs_show_them() {
    let igor = || Topography::from_bytes("scan", made::ibw(true), Some("height trace"));
    assert_eq!(igor().unwrap().channel.as_deref(), Some("HeightTrace"));
    let second = Topography::from_bytes("scan", keyence::vk(4), Some("height_2")).unwrap();
    assert_eq!(second.channel.as_deref(), Some("Height 2"));
    let unknown = Topography::from_bytes("scan", keyence::vk(4), Some("--")).unwrap_err();
    assert_eq!(unknown.reason, "the channel is --; it must be one of 0 Height 1, 1 Height 2");
}

#[test]
fn pictures_and_degrees_are_no_heights() {
    let changed = |tag: u8, from: u8, to: u8| {
        let mut bytes = tiff::deflated_strips();
        let entry = [1, tag, 0, 3, 0, 0, 0, 1, 0, from];
        let at = bytes.windows(entry.len()).position(|found| found == entry).unwrap();
        bytes[at + 9] = to;
        bytes
    };
    for (bytes, says) in [
        (changed(2, 16, 8), "the image has 8 bits a pixel, as pictures have; if they are heights, say so by"),
        (changed(21, 1, 3), "the image has 3 numbers a pixel, as colours have; "),
        (changed(3, 8, 5), "the image is compressed by LZW, which is not read; "),
        (changed(3, 8, 7), "the compression has number 7; "),
        (tiff::ground(2), "the coordinates are degrees, which are no lengths; "),
    ] {
        let found = refusal(bytes);
        assert!(found.starts_with(says), "{found}");
    }
    let mut short = tiff::float_tiles();
    let at = short.windows(4).position(|tag| tag == [0x44, 1, 4, 0]).unwrap();
    short[at + 4] = 1;
    assert_eq!(refusal(short), "the image has 1 parts for 5 by 4 points; it must have more");
}

#[test]
fn meshes_on_a_lattice_are_maps_and_closed_bodies_are_not() {
    let meshes = ["ascii", "binary_little_endian", "binary_big_endian"].map(|format| ("PLY", others::ply(format)));
    for (format, bytes) in
        meshes.into_iter().chain([("STL", others::stl(true, false)), ("STL", others::stl(false, false))])
    {
        assert_eq!(check_bare(format, read(bytes), Some(GRID.lengths)).undefined, 1);
    }
    let closed = refusal(others::stl(true, true));
    assert!(closed.starts_with("the 60 vertices have two heights at one point, as a closed body has; "), "{closed}");
    let uneven = refusal(
        b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                           end_header\n0 0 1\n1 0 2\n3 1 4\n"
            .to_vec(),
    );
    assert!(uneven.starts_with("the 3 vertices have no lattice; "), "{uneven}");
}

#[test]
fn images_of_grey_with_16_bits_are_maps_and_gwyddion_gives_their_size() {
    let mut plain = read(others::png(false));
    plain.heights.mapv_inplace(|height| height - 150.0);
    check_bare("PNG", plain, None);
    let expected = Expected { format: "PNG", scale: 0.125e-3, undefined: false, ..GRID };
    let mut map = read(others::png(true));
    map.heights.mapv_inplace(|height| (8e3 * height).round() / 8e3 - 150.0 / 8e3);
    assert_eq!((map.unit.as_deref(), map.lengths, map.notes.len()), (Some("µm"), Some(expected.lengths), 1));
    let error = map
        .heights
        .indexed_iter()
        .map(|((x, y), height)| (height - expected.scale * f64::from(made::height(x, 3 - y))).abs());
    assert!(error.fold(0.0, f64::max) < 1e-15);
}

#[test]
fn softgauges_and_archives_are_read() {
    let profile = read(others::smd());
    assert_eq!((profile.format, profile.unit.as_deref()), ("ISO 5436-2", Some("mm")));
    assert_eq!((profile.lengths, profile.heights.dim()), (Some([2e-3, 1.0]), (4, 1)));
    assert_eq!(
        profile.heights.mapv(|height| (1e3 * height * 8.0).round() / 8.0).column(0).to_vec(),
        [1.0, -2.0, 3.0, 0.0]
    );
    assert_eq!(refusal(edited(others::smd(), "'PRF'", "'SUR'")), "the file holds no profile (PRF); it must hold one");
    let map = check(others::gzip(), &Expected { format: "gzip", lengths: [2500.0, 1000.0], unit: "nm", ..GRID });
    assert_eq!(map.notes[0], "the file inside has the format text");
    let nested = refusal(others::gzipped(&others::gzip()));
    assert_eq!(nested, "the file inside is an archive; unpack it and give the file inside");
}

#[test]
fn olympus_finds_its_heights_by_the_properties() {
    for bytes in [olympus::oir(), olympus::poir()] {
        let mut map = read(bytes);
        assert_eq!(map.notes, ["the channel INVALID is not applied, as no other program does"]);
        map.heights.mapv_inplace(|height| height - 18.75);
        check_at(
            &map,
            &Expected { format: "Olympus OIR", channel: "HEIGHT", scale: 0.125, undefined: false, ..GRID },
            |point| point,
        );
    }
    let none = refusal(edited(olympus::oir(), ">HEIGHT<", ">COLOUR<"));
    assert_eq!(none, "the file has no channel of the type HEIGHT; it must have one");
    let edits = (0..2).fold(olympus::oir(), |bytes, _| edited(bytes, "<z>um</z>", "<z>pc</z>"));
    let unit = refusal(edits);
    assert_eq!(unit, "the unit of z is \"pc\"; it must be a unit of length");
}

#[test]
fn mountains_map_has_measured_surfaces_in_blocks_of_any_order() {
    for undefined in [true, false] {
        let expected = Expected { format: "MountainsMap", channel: "Plate", scale: 0.125, undefined, ..GRID };
        assert_eq!(check(mnt::mnt(undefined), &expected).channels, ["Plate"]);
    }
    let mut none = mnt::mnt(true);
    let at = none.windows(4).position(|class| class == 9012_i32.to_le_bytes()).unwrap();
    none[at] = 0;
    assert_eq!(refusal(none), "the document has no measured surface; export the surface from MountainsMap as .sur");
    let mut other = mnt::mnt(true);
    let at = other.windows(6).position(|name| name == b"S\0c\0o\0").unwrap();
    other[at] = b's';
    assert!(refusal(other).starts_with("the format is OLE compound file (.xls, .oif), which is not read; "));
}

fn packed(entries: &[(&str, Vec<u8>)]) -> Vec<u8> {
    made::zipped(entries, zip::CompressionMethod::Deflated)
}

#[test]
fn sheets_are_read_as_text_is_and_empty_cells_are_missing_points() {
    let bytes = packed(&xlsx::xlsx());
    let map = read(bytes.clone());
    assert_eq!((map.format, map.channel.as_deref(), map.channels.len()), ("Excel", Some("Map"), 2));
    assert_eq!((map.undefined, map.lengths, map.unit), (1, None, None));
    for ((x, y), height) in map.heights.indexed_iter().filter(|(_, height)| height.is_finite()) {
        assert_eq!(*height, f64::from(made::height(x, 3 - y)).powi(2));
    }
    let list = Topography::from_bytes("scan", bytes, Some("List")).unwrap();
    check_at(&list, &Expected { format: "Excel", channel: "List", scale: 1e-3, ..GRID }, |at| at);
    let mut words = xlsx::xlsx();
    words[4].1 = edited(words[4].1.clone(), "<v>62500</v>", "<v>upper</v>");
    let [warning] = &read(packed(&words)).warnings[..] else { panic!("one sheet is left out") };
    assert!(warning.starts_with("the sheet Map is left out: ") && warning.contains("\"upper\""), "{warning}");
}

#[test]
fn workbooks_of_mitutoyo_hold_a_profile() {
    let profile = read(packed(&xlsx::mitutoyo()));
    assert_eq!((profile.heights.dim(), profile.unit.as_deref()), ((4, 1), Some("mm")));
    assert!((profile.lengths.unwrap()[0] / 2e-3 - 1.0).abs() < 1e-12);
    let micrometres: Vec<f64> = profile.heights.iter().map(|height| (8e3 * height).round() / 8.0).collect();
    assert_eq!(micrometres, [1, 2, 3, 4].map(|k| 0.125 * f64::from(made::height(k, 0))));
    assert_eq!(profile.details, [("date".to_owned(), "29-Feb-2024".to_owned())]);
    let mut uneven = xlsx::mitutoyo();
    uneven[4].1 = edited(uneven[4].1.clone(), "<v>0.001</v>", "<v>0.002</v>");
    assert!(refusal(packed(&uneven)).starts_with("a step of the coordinates in column E is "));
}
