//! Hostile files: damaged copies of valid ones, many small parts, lying headers, bombs. `cargo run -p gfmd-files --example
//! hostile` reads as many damaged files as wanted.

#[path = "harness/mod.rs"]
mod harness;

use std::time::Duration;

use harness::made;
use zip::CompressionMethod;

/// Damaged files of each format.
const INPUTS: u64 = 2000;

/// The memory of the whole process is counted, so that the parts of this test follow each other.
#[test]
fn hostile_files_are_read_or_refused_in_bounded_time_and_memory() {
    harness::guard(Duration::from_secs(60));
    let folder = tempfile::tempdir().unwrap().keep();
    damaged(&folder);
    many_small_parts();
    truncated(&folder);
    std::fs::remove_dir_all(folder).unwrap();
}

fn damaged(folder: &std::path::Path) {
    // The HDF5 library can crash on hostile files, or run without end.
    let ours = |(format, _): &(&str, Vec<harness::Seed>)| !harness::BY_LIBRARY.contains(format);
    for (format, seeds) in harness::seeds(folder).into_iter().filter(ours) {
        for seed in &seeds {
            let read = harness::check(format, &seed.bytes(), &mut harness::Count::default());
            assert_eq!(read, Ok(true), "the valid file of {format} is not read");
        }
        let count = harness::attack(format, &seeds, 0, INPUTS, folder).unwrap_or_else(|reason| panic!("{reason}"));
        assert!(count.inputs == INPUTS && count.read > 0, "{format}: {count:?}");
    }
}

/// Checks that a file which is not valid is refused, and that without much memory.
fn refused(what: &str, bytes: &[u8]) {
    assert_eq!(harness::check(what, bytes, &mut harness::Count::default()), Ok(false), "{what}");
}

/// Files whose parts are as small as can be, so that what is kept of each part is large beside it.
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

    let names: Vec<String> = (0..20_000).map(|number| number.to_string()).collect();
    let entries: Vec<(&str, Vec<u8>)> = names.iter().map(|name| (name.as_str(), vec![])).collect();
    refused("entries of zip", &made::zipped(&entries, CompressionMethod::Stored));
    let elements = format!("<xml><GENERAL><IMAGE_SIZE_X>{}", "<a/>".repeat(200_000));
    refused(
        "elements of Sensofar",
        &made::zipped(&[("index.xml", elements.into_bytes())], CompressionMethod::Deflated),
    );
}

/// Every file cut at every byte is read or refused.
fn truncated(folder: &std::path::Path) {
    for (format, seeds) in harness::seeds(folder) {
        if harness::BY_LIBRARY.contains(&format) {
            continue;
        }
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
