//! Hostile files: damaged copies of valid ones, many small parts, false headers, decompression bombs. `cargo run -p
//! gfmd-topography --example hostile` reads any number of damaged files.

#[path = "harness/mod.rs"]
mod harness;

use std::time::Duration;

use harness::made;
use zip::CompressionMethod;

/// Number of damaged files per format.
const INPUTS: u64 = 2000;

/// The memory of the whole process is counted, so the parts of this test run one after the other.
#[test]
fn hostile_files_are_read_or_refused_in_bounded_time_and_memory() {
    harness::guard(Duration::from_secs(60));
    let folder = tempfile::tempdir().unwrap().keep();
    damaged(&folder);
    many_small_parts();
    truncated(&folder);
    lying_headers(&folder);
    std::fs::remove_dir_all(folder).unwrap();
}

fn damaged(folder: &std::path::Path) {
    for (format, seeds) in harness::seeds(folder) {
        for seed in &seeds {
            let read = harness::check(format, &seed.bytes(), &mut harness::Count::default());
            assert_eq!(read, Ok(true), "the valid file of {format} is not read");
        }
        let count = harness::attack(format, &seeds, 0, INPUTS, folder).unwrap_or_else(|reason| panic!("{reason}"));
        assert!(count.inputs == INPUTS && count.read > 0, "{format}: {count:?}");
    }
}

/// Checks that an invalid file is refused without much memory.
fn refused(what: &str, bytes: &[u8]) {
    assert_eq!(harness::check(what, bytes, &mut harness::Count::default()), Ok(false), "{what}");
}

/// Files with parts as small as possible, so that the memory per part is large in comparison.
fn many_small_parts() {
    let many = |part: &[u8], count: usize| part.repeat(count);
    refused("lines of Nanoscope", &[b"\\*File list\r\n".to_vec(), many(b"\\\n", 500_000)].concat());
    refused("sections of Nanoscope", &[b"\\*File list\r\n".to_vec(), many(b"\\*\n", 500_000)].concat());
    refused("images of Nanoscope", &[b"\\*File list\r\n".to_vec(), many(b"\\*Image list\n", 100_000)].concat());

    let opd = made::opd(2);
    let entry = &opd[26..50];
    let directory = [&opd[..20], &(24 * 50_001_i32).to_le_bytes(), &opd[24..26]].concat();
    let content = &opd[26 + 7 * 24..][..46];
    refused("blocks of Wyko", &[directory, many(entry, 50_000), many(content, 50_000)].concat());

    let magic = b"VCA DATA\x01\0\0\x55";
    refused("items of Dektak", &[magic.to_vec(), many(&[0, 0, 0, 0, 1, 0], 200_000)].concat());
    let set = [&[1, 0, 0, 0, b'a', 0x7d, 1, 7][..], &[1, 0, 0, 0, b'b', 1, 0]].concat();
    let sets = many(&set, 20_000);
    let group = [&[7, 0, 0, 0][..], b"2D_Data", &[0x7d, 4], &(sets.len() as u32).to_le_bytes()].concat();
    refused("sets of data of Dektak", &[magic.to_vec(), group, sets].concat());

    let mut tag = b"Cols".to_vec();
    tag.resize(50, b'0');
    tag.extend(b"\r\n");
    let mut tags = made::al3d();
    tags[17 + 52 + 20..][..6].copy_from_slice(b"999999");
    tags.splice(17 + 2 * 52.., many(&tag, 30_000));
    refused("tags of Alicona", &tags);

    let mut streams = made::sur(32, 1, 0);
    streams.truncate(527);
    streams.extend(200_000_u32.to_le_bytes());
    streams.extend(many(&[0; 8], 200_000));
    refused("streams of Digital Surf", &streams);

    // Pages of TIFF that lead to each other.
    let page = [&b"II*\0\x08\0\0\0\x01\0"[..], &[0; 12], b"\x08\0\0\0"].concat();
    refused("pages of TIFF", &[page, many(&[0; 12], 100_000)].concat());

    refused("zeros in gzip", &made::others::gzipped(&many(b"0 ", 4_000_000)));
    refused("closed STL", &made::others::stl(false, true));

    let names: Vec<String> = (0..20_000).map(|number| number.to_string()).collect();
    let entries: Vec<(&str, Vec<u8>)> = names.iter().map(|name| (name.as_str(), vec![])).collect();
    refused("entries of zip", &made::zipped(&entries, CompressionMethod::Stored));
    let elements = format!("<xml><GENERAL><IMAGE_SIZE_X>{}", "<a/>".repeat(200_000));
    refused(
        "elements of Sensofar",
        &made::zipped(&[("index.xml", elements.into_bytes())], CompressionMethod::Deflated),
    );
}

/// Every file truncated at any byte is read or refused.
fn truncated(folder: &std::path::Path) {
    for (format, seeds) in harness::seeds(folder) {
        for seed in seeds {
            let bytes = seed.bytes();
            let step = bytes.len().div_ceil(500).max(1);
            for end in (0..bytes.len()).step_by(step) {
                let read = harness::check(format, &bytes[..end], &mut harness::Count::default());
                assert!(read.is_ok(), "{format} cut at {end}: {read:?}");
            }
        }
    }
}

/// Headers that declare 2^40 points, or any typical damaged number.
fn lying_headers(folder: &std::path::Path) {
    let replaced = |bytes: &[u8], from: &str, to: &str| {
        let at = bytes.windows(from.len()).position(|window| window == from.as_bytes()).unwrap();
        [&bytes[..at], to.as_bytes(), &bytes[at + from.len()..]].concat()
    };
    let sizes = ["0", "-1", "1048576", "65536", "1099511627776", "18446744073709551615", "nan", "1e400", ""];
    for size in sizes {
        let texts = [
            ("Nanoscope", made::nanoscope(2), "Samps/line: 5"),
            ("Molecular Imaging", made::mi(16), "xPixels       5"),
            ("Nanosurf", made::nanosurf(), "Points=5"),
            ("Nanosurf", made::nanosurf(), "GroupCount=1"),
        ];
        for (format, bytes, line) in texts {
            let (key, _) = line.split_at(line.len() - 1);
            // Numbers of groups, including channels that were not recorded, do not matter.
            let read = harness::check(
                format,
                &replaced(&bytes, line, &format!("{key}{size}")),
                &mut harness::Count::default(),
            );
            assert!(
                read == Ok(false) || (line.starts_with("Group") && read == Ok(true)),
                "{format}, {line} with {size}: {read:?}"
            );
        }
        let mut entries = made::plux();
        entries[0].1 = replaced(&entries[0].1, "<IMAGE_SIZE_X>5", &format!("<IMAGE_SIZE_X>{size}"));
        refused("Sensofar PLUX", &made::zipped(&entries, CompressionMethod::Deflated));
    }
    // Binary numbers of points: their position and number of bytes.
    let binary: [(&str, Vec<u8>, usize, usize); 7] = [
        ("Digital Surf", made::sur(32, 0, 0), 108, 12),
        ("Digital Surf", made::sur(32, 1, 0), 108, 12),
        ("Zygo MetroPro", made::metropro(1, 0), 68, 4),
        ("Zygo MetroPro", made::metropro(1, 0), 52, 6),
        ("Igor binary wave", made::ibw(false), 64 + 68, 16),
        ("Igor binary wave", made::ibw(true), 64 + 68, 16),
        ("Sensofar PLu", made::plu(), 500, 8),
    ];
    for (format, bytes, at, count) in binary {
        for fill in [0, 0x7f, 0xff] {
            let mut bytes = bytes.clone();
            bytes[at..at + count].fill(fill);
            // Zero intensity points mean no intensities.
            let may_be_read = format == "Zygo MetroPro" && at == 52 && fill == 0;
            let read = harness::check(format, &bytes, &mut harness::Count::default());
            assert_eq!(read, Ok(may_be_read), "{format}, {count} bytes of {fill:#x} at {at}");
        }
    }
    // A spacing that is not a number.
    let mut bytes = made::sur(32, 0, 0);
    bytes[120..124].copy_from_slice(&f32::NAN.to_le_bytes());
    refused("Digital Surf", &bytes);

    // A dataset of 2^30 points without stored values.
    let path = folder.join("empty.h5");
    let file = hdf5::File::create(&path).unwrap();
    file.new_dataset::<f64>().shape([1 << 15, 1 << 15]).chunk([1 << 10, 1 << 10]).create("surface").unwrap();
    drop(file);
    refused("HDF5", &std::fs::read(&path).unwrap());
    let reason = gfmd_files::Topography::read(path.to_str().unwrap(), None).unwrap_err().reason;
    assert!(reason.contains("(8589934592 bytes) exceeds the 1444800 byte read limit"), "{reason}");
}
