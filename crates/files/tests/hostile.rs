//! Some thousand damaged files of each format. `cargo run -p gfmd-files --example hostile` reads as many as wanted.

#[path = "harness/mod.rs"]
mod harness;

use std::time::Duration;

/// Inputs of a format.
const INPUTS: u64 = 2000;

#[test]
fn damaged_files_are_read_or_refused_in_bounded_time_and_memory() {
    harness::guard(Duration::from_secs(60));
    let folder = tempfile::tempdir().unwrap().keep();
    // The HDF5 library can crash on hostile files, or run without end.
    let ours = |(format, _): &(&str, Vec<harness::Seed>)| !harness::BY_LIBRARY.contains(format);
    for (format, seeds) in harness::seeds(&folder).into_iter().filter(ours) {
        for seed in &seeds {
            let read = harness::check(format, &seed.bytes(), &mut harness::Count::default());
            assert_eq!(read, Ok(true), "the valid file of {format} is not read");
        }
        let count = harness::attack(format, &seeds, 0, INPUTS, &folder).unwrap_or_else(|reason| panic!("{reason}"));
        assert!(count.inputs == INPUTS && count.read > 0, "{format}: {count:?}");
    }
    std::fs::remove_dir_all(folder).unwrap();
}
