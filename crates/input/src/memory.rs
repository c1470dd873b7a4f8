//! Memory: the need of each problem, and the use of this process.

use gfmd_files::Reader;
use gfmd_problem::{MemoryNeed, Words};

use crate::failure::Failure;

/// Synthesis of a surface: heights, half spectrum, workspace of the transform.
pub const SURFACE: MemoryNeed = MemoryNeed(5);

/// Fields of a filter: heights before and after it, three moments, and lines of both axes in turn.
pub const FILTER: MemoryNeed = MemoryNeed(12);

/// Fields of a robust filter, which has moments of its weights.
pub const ROBUST_FILTER: MemoryNeed = MemoryNeed(32);
/// Punch.
pub const PUNCH: MemoryNeed = MemoryNeed(48);
/// Fields below a surface: spectra of the surface and of a plane, fields of the plane, and the values written.
pub const BODY: MemoryNeed = MemoryNeed(36);

/// Number of fields in transit between processes, rounded up.
const LETTERS: u64 = 1;

/// Number of processes that share a grid, on this machine and in total.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Processes {
    /// Processes on this machine.
    pub here: usize,
    /// All processes.
    pub all: usize,
}

impl Processes {
    /// Single process.
    pub const ALONE: Self = Self { here: 1, all: 1 };
}

/// Refuses a grid of `points` that does not fit into memory; the message begins with `name`, its option or file.
///
/// # Errors
/// Returns an error if more memory is needed than available.
pub fn fits(need: MemoryNeed, name: impl Into<Words>, points: [usize; 2]) -> Result<(), Failure> {
    fits_with(0, need, name, points, Processes::ALONE)
}

/// Checks like [`fits`], for the memory of all processes on this machine.
///
/// # Errors
/// Returns an error if more memory is needed than available.
pub fn fits_shared(
    need: MemoryNeed,
    name: impl Into<Words>,
    points: [usize; 2],
    processes: Processes,
) -> Result<(), Failure> {
    fits_with(0, need, name, points, processes)
}

/// Returns the resident memory of these processes on this machine, in bytes: the rest of a problem, and freed memory
/// that the allocator keeps.
pub fn resident(processes: Processes) -> u64 {
    own_size(RESIDENT).unwrap_or(0).saturating_mul(processes.here as u64)
}

/// Checks like [`fits_shared`] if some bytes of the problem are already `there`.
///
/// # Errors
/// Returns an error if more memory is needed than available.
pub fn fits_with(
    there: u64,
    need: MemoryNeed,
    name: impl Into<Words>,
    points: [usize; 2],
    processes: Processes,
) -> Result<(), Failure> {
    let ([nx, ny], Processes { here, all }) = (points, processes);
    let (need, whose) = if all > 1 {
        (MemoryNeed(need.0 + LETTERS), format!(", shared by {all} processes, {here} of them on this machine,"))
    } else {
        (need, String::new())
    };
    let needed = u128::from(need.bytes(points)) * here as u128 / all.max(1) as u128;
    check(name, &format!("{nx} x {ny} points{whose}"), u64::try_from(needed).unwrap_or(u64::MAX), there)
}

/// Refuses numbers that do not fit into memory: `count` items, called `what`, of `each` bytes.
///
/// # Errors
/// Returns an error if more memory is needed than available.
pub fn check_count(name: impl Into<Words>, what: &str, count: u64, each: u64) -> Result<(), Failure> {
    check(name, &format!("{count} {what}"), count.saturating_mul(each), 0)
}

/// Refuses a file with a variable that does not fit into memory.
///
/// # Errors
/// Returns an error if more memory is needed than available.
pub fn check_file(reader: &Reader) -> Result<(), Failure> {
    let Some((variable, bytes)) = reader.largest() else { return Ok(()) };
    check(reader.path().display().to_string(), &format!("the values of {variable}"), bytes, 0)
}

/// Refuses a need that exceeds the available memory plus the memory already `held`.
fn check(name: impl Into<Words>, what: &str, needed: u64, held: u64) -> Result<(), Failure> {
    let available = available_bytes().map(|available| available.saturating_add(held));
    let Some(available) = available.filter(|available| needed > *available) else { return Ok(()) };
    let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
    let reason = format!("{what} need {:.1} GiB; {:.1} GiB are available", gib(needed), gib(available));
    Err(Failure::input(name, reason))
}

/// Returns the memory that a computation may use, in bytes: the memory of the machine, less if the process or its
/// control group has a limit; `None` if the system does not report it.
pub fn available_bytes() -> Option<u64> {
    [of_machine(), of_control_group(), of_process()].into_iter().flatten().min()
}

/// Returns the memory below the limit of the control group, such as a container. Cached files that have not been read
/// lately count as used, but can be dropped.
fn of_control_group() -> Option<u64> {
    let text = |name: &str| std::fs::read_to_string(format!("/sys/fs/cgroup/memory.{name}")).ok();
    let number = |name: &str| text(name)?.trim().parse::<u64>().ok();
    let limit = number("max")?;
    let files =
        text("stat").and_then(|all| all.lines().find_map(|line| line.strip_prefix("inactive_file ")?.parse().ok()));
    Some(limit.saturating_sub(number("current")?).saturating_add(files.unwrap_or(0)).min(limit))
}

/// Returns the address space below the limit of the process (`ulimit -v`).
fn of_process() -> Option<u64> {
    #[cfg(target_os = "linux")]
    {
        use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit};
        let (limit, _) = getrlimit(Resource::RLIMIT_AS).ok().filter(|(limit, _)| *limit != RLIM_INFINITY)?;
        Some(limit.saturating_sub(own_size(ADDRESSES)?))
    }
    #[cfg(not(target_os = "linux"))]
    None
}

/// Name of the address space size of a process in `/proc/self/status`.
#[cfg(target_os = "linux")]
const ADDRESSES: &str = "VmSize:";

/// Name of the resident size.
const RESIDENT: &str = "VmRSS:";

/// Returns a size of this process in bytes; `None` if the system does not report it. Linux reports kilobytes for any
/// page size.
fn own_size(name: &str) -> Option<u64> {
    bytes_of_linux("/proc/self/status", name)
}

fn of_machine() -> Option<u64> {
    bytes_of_linux("/proc/meminfo", "MemAvailable:")
}

/// Reads a kB entry of a /proc file, in bytes.
fn bytes_of_linux(file: &str, name: &str) -> Option<u64> {
    if !cfg!(target_os = "linux") {
        return None;
    }
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find(|line| line.starts_with(name))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

/// Returns the largest resident memory of this process so far, in bytes; 0 if the system does not report it.
pub fn peak_bytes() -> u64 {
    // On Linux, `getrusage` reports at least the memory of the process that started this one.
    if let Some(bytes) = bytes_of_linux("/proc/self/status", "VmHWM:") {
        return bytes;
    }
    #[cfg(unix)]
    {
        use nix::sys::resource::{UsageWho, getrusage};
        // macOS counts in bytes, other systems in kilobytes.
        let unit = if cfg!(target_vendor = "apple") { 1 } else { 1024 };
        getrusage(UsageWho::RUSAGE_SELF).map_or(0, |usage| usage.max_rss().unsigned_abs() * unit)
    }
    #[cfg(not(unix))]
    0
}

#[cfg(test)]
mod tests {
    use gfmd_problem::key;

    use super::*;

    #[test]
    fn a_grid_whose_bytes_no_integer_holds_is_refused() {
        let all = [SURFACE, MemoryNeed::HARD_WALL, MemoryNeed::LAW, MemoryNeed::ALL_COMPONENTS, PUNCH, BODY];
        for fields in all {
            for points in [[1 << 31; 2], [1 << 33, 1 << 28], [usize::MAX, 1]] {
                assert!(fields.bytes(points) > 1 << 60, "{fields:?} {points:?}");
                assert!(available_bytes().is_none() || fits(fields, key("n"), points).is_err());
            }
        }
        let shared = Processes { here: 2, all: 4 };
        let refused = fits_shared(MemoryNeed::HARD_WALL, "the grid", [1 << 20, 1 << 20], shared)
            .map_err(|error| error.to_string());
        let needed = "shared by 4 processes, 2 of them on this machine, need 57344.0 GiB";
        assert!(available_bytes().is_none() || refused.is_err_and(|error| error.contains(needed)));
        let held = fits_with(u64::MAX, MemoryNeed::HARD_WALL, "the grid", [1 << 20, 1 << 20], Processes::ALONE);
        assert!(held.is_ok(), "what is held already need not be available");
        for count in [1 << 40, u64::MAX] {
            assert!(available_bytes().is_none() || check_count(key("steps"), "steps", count, 64).is_err());
        }
        assert!(check_count(key("steps"), "steps", 1000, 64).is_ok());
        assert_eq!(MemoryNeed::HARD_WALL.bytes([512, 256]), 8 * 13 * 512 * 256);
    }

    /// Compares the size with the system's own table of this process's addresses, in bytes.
    #[cfg(target_os = "linux")]
    #[test]
    fn the_size_of_this_process_is_that_of_its_addresses_whatever_the_size_of_pages() {
        // Other tests of this binary allocate meanwhile: the table counts if the size is the same before and after
        // reading it.
        let settled = (0..10_000).find_map(|_| {
            let before = own_size(ADDRESSES);
            let maps = std::fs::read_to_string("/proc/self/maps").ok()?;
            (before == own_size(ADDRESSES)).then_some((before?, maps))
        });
        let Some((found, maps)) = settled else { return };
        let length = |line: &str| {
            let (from, to) = line.split_whitespace().next()?.split_once('-')?;
            Some(u64::from_str_radix(to, 16).ok()? - u64::from_str_radix(from, 16).ok()?)
        };
        let addresses: u64 = maps.lines().filter(|line| !line.ends_with("[vsyscall]")).filter_map(length).sum();
        assert!(found.abs_diff(addresses) < addresses / 5, "{found} {addresses}");
        let resident = own_size(RESIDENT).unwrap();
        assert!(resident > 1 << 20, "{resident}");
        assert!(resident < found, "{resident}");
        assert!(resident.is_multiple_of(1024), "{resident}");
    }
}
