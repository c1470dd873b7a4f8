//! Reads damaged files of every format and prints their number.
//!
//! ```text
//! cargo run -p gfmd-topography --example hostile -- --inputs 1000000 [--format NAME] [--first NUMBER] [--files FOLDER]
//! ```
//!
//! Without `--release`, overflows panic as well. `--files` adds the files of a folder of up to 64 KiB to the valid
//! files to damage; each counts for the format that reads it. The exit status is 1 at the first file that makes a
//! reader panic, take more memory than 4 times its size and its grid, or more than 20 seconds; the file is kept.
#![allow(clippy::print_stdout, reason = "the counts are the output")]

#[path = "../tests/harness/mod.rs"]
mod harness;

use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use gfmd_topography::Listing;
use harness::Seed;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(reason) => {
            println!("{reason}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), String> {
    let (mut inputs, mut only, mut first, mut files) = (10_000, None, 0, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(flag) = arguments.next() {
        let value = arguments.next().ok_or_else(|| format!("{flag} has no value; it must have one"))?;
        let number = || value.parse::<u64>().map_err(|_| format!("{flag} is {value}; it must be a whole number"));
        match flag.as_str() {
            "--inputs" => inputs = number()?,
            "--first" => first = number()?,
            "--format" => only = Some(value),
            "--files" => files = Some(value),
            _ => return Err(format!("the flag is {flag}; it must be --inputs, --first, --format or --files")),
        }
    }
    harness::guard(Duration::from_secs(20));
    std::panic::set_hook(Box::new(|_| ()));
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?.keep();
    let mut seeds = harness::seeds(&folder);
    if let Some(files) = files {
        add(&mut seeds, Path::new(&files))?;
    }
    println!("{:18} {:>6} {:>10} {:>10} {:>12} {:>12}", "format", "valid", "inputs", "read", "slowest, ms", "seconds");
    for (format, seeds) in seeds.iter().filter(|(format, _)| only.as_ref().is_none_or(|only| only == format)) {
        let started = Instant::now();
        let count = harness::attack(format, seeds, first, inputs, &folder)?;
        println!(
            "{format:18} {:>6} {:>10} {:>10} {:>12.1} {:>12.1}",
            seeds.len(),
            count.inputs,
            count.read,
            1e3 * count.time.as_secs_f64(),
            started.elapsed().as_secs_f64()
        );
    }
    Ok(())
}

/// Adds the small files of a folder to the valid files of their formats.
fn add(seeds: &mut [(&'static str, Vec<Seed>)], folder: &Path) -> Result<(), String> {
    for entry in std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))? {
        let path = entry.map_err(|error| error.to_string())?.path();
        let Ok(bytes) = std::fs::read(&path) else { continue };
        let Ok(listing) = Listing::from_bytes("file", bytes.clone()) else { continue };
        let found = seeds.iter_mut().find(|(format, _)| *format == listing.format);
        if let (Some((_, seeds)), true) = (found, bytes.len() <= 1 << 16) {
            seeds.push(Seed::Bytes(bytes));
        }
    }
    Ok(())
}
