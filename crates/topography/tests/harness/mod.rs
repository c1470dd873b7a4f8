//! Hostile files: damaged copies of valid ones. Readers must find heights or an error in bounded time and memory.

pub(crate) mod made;
mod memory;
mod mutate;
mod seeds;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

use gfmd_topography::{Listing, Reading, Topography};
use mutate::Random;
pub(crate) use mutate::Seed;
pub(crate) use seeds::seeds;

/// Exit status of the guard.
pub(crate) const ENDLESS: i32 = 3;

/// Memory beyond four times the file and the grid of the height map, in bytes: an entry that describes others has up to
/// 1 MiB and 20000 nodes, whatever its compressed size.
const CONSTANT: usize = 4 << 20;

/// The same for HDF5: an object header declares up to 65535 messages, and the reader allocates room for all, 10 MB.
const CONSTANT_HDF5: usize = 14 << 20;

/// Bytes per grid point: a height and a mark.
const POINT: usize = 9;

/// Findings of a run.
#[derive(Debug, Default)]
pub(crate) struct Count {
    pub(crate) inputs: u64,
    /// Files that were read.
    pub(crate) read: u64,
    /// Largest memory of a file beyond its grid, in multiples of the file size, and largest time.
    pub(crate) memory: f64,
    pub(crate) time: Duration,
}

/// Input being read, for the guard against endless reading.
static READING: Mutex<Option<(Instant, String, Vec<u8>)>> = Mutex::new(None);

/// Starts a guard that ends the process if a file takes longer than `limit`.
pub(crate) fn guard(limit: Duration) {
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(limit / 4);
            let Ok(reading) = READING.lock() else { continue };
            if let Some((since, what, bytes)) = &*reading
                && since.elapsed() > limit
            {
                let path = std::env::temp_dir().join(what.replace(' ', "-"));
                let saved = std::fs::write(&path, bytes).is_ok();
                #[allow(clippy::print_stderr, reason = "the process ends here")]
                let () =
                    eprintln!("{what} takes longer than {limit:?}; the file is {}, written: {saved}", path.display());
                std::process::exit(ENDLESS);
            }
        }
    });
}

/// Reads `inputs` damaged files of a format; equal numbers from `first` on give equal files.
///
/// # Errors
/// The number of the first input that panics, takes too much memory or gives an invalid height map, and the reason. The
/// input is written to `folder`.
pub(crate) fn attack(format: &str, seeds: &[Seed], first: u64, inputs: u64, folder: &Path) -> Result<Count, String> {
    let mut count = Count::default();
    for number in first..first + inputs {
        let bytes =
            mutate::damaged(seeds, &mut Random(number.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ format.len() as u64));
        check(&format!("{format} {number}"), &bytes, &mut count).map_err(|reason| {
            let path = folder.join(format!("{}-{number}", format.replace(' ', "-")));
            let saved =
                std::fs::write(&path, &bytes).map_or_else(|error| error.to_string(), |()| path.display().to_string());
            format!("{format}, input {number}: {reason}; the file is {saved}")
        })?;
    }
    Ok(count)
}

/// Reads a file that may be damaged. Returns true if it has a valid height map.
pub(crate) fn check(name: &str, bytes: &[u8], count: &mut Count) -> Result<bool, String> {
    *READING.lock().map_err(|error| error.to_string())? = Some((Instant::now(), name.to_owned(), bytes.to_vec()));
    let started = Instant::now();
    let copy = bytes.to_vec();
    let before = memory::start();
    // The copy of the file is part of the memory.
    let reading = Reading { image_heights: true, ..Reading::default() };
    let map = caught(|| Topography::from_bytes_as("file", copy, reading))?;
    let (peak, time) = (memory::peak(before) + bytes.len(), started.elapsed());
    let grid = match &map {
        Ok(map) => map.heights.len(),
        // The header counts, even if the heights are missing.
        Err(_) => caught(|| declared(bytes))?,
    };
    *READING.lock().map_err(|error| error.to_string())? = None;
    let constant = if bytes.starts_with(b"\x89HDF") { CONSTANT_HDF5 } else { CONSTANT };
    let allowed = 4 * bytes.len() + POINT * grid + constant;
    if peak > allowed {
        return Err(format!(
            "{peak} bytes of memory for a file of {} and {grid} points; allowed are {allowed}",
            bytes.len()
        ));
    }
    let beyond = peak.saturating_sub(POINT * grid) as f64 / bytes.len().max(1) as f64;
    if bytes.len() > CONSTANT / 16 {
        count.memory = count.memory.max(beyond);
    }
    count.inputs += 1;
    count.time = count.time.max(time);
    let Ok(map) = map else { return Ok(false) };
    count.read += 1;
    let undefined = map.heights.iter().filter(|height| height.is_nan()).count();
    if undefined != map.undefined || map.heights.iter().any(|height| height.is_infinite()) || map.heights.is_empty() {
        return Err(format!("{undefined} heights are NaN, the map says {}; none may be infinite", map.undefined));
    }
    if map.lengths.is_some_and(|lengths| !lengths.iter().all(|length| *length > 0.0 && length.is_finite())) {
        return Err(format!("the lengths are {:?}; they must be positive and finite", map.lengths));
    }
    Ok(true)
}

/// Calls `read` and converts a panic to an error.
fn caught<T>(read: impl FnOnce() -> T) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(read)).map_err(|panic| {
        let text = panic.downcast_ref::<String>().cloned();
        format!("panic: {}", text.or(panic.downcast_ref::<&str>().map(|text| (*text).into())).unwrap_or_default())
    })
}

/// Returns the largest number of points that a file declares for a height map.
fn declared(bytes: &[u8]) -> usize {
    let listing = Listing::from_bytes("file", bytes.to_vec());
    let points = listing.iter().flat_map(|listing| &listing.channels).map(|channel| channel.points);
    points.map(|[nx, ny]| nx.saturating_mul(ny)).filter(|&points| points <= 1 << 30).max().unwrap_or(0)
}
