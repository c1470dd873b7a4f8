//! Memory: the need of each problem, which is refused if it does not fit, and the use of this process.

use crate::failure::Failure;

/// Held of doubles, one component each, that a problem holds at its peak, with some room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Held(u64);

impl Held {
    /// The synthesis of a surface: heights, half spectrum, work of the transform.
    pub const SURFACE: Self = Self(5);
    /// A contact with a hard wall.
    pub const HARD_WALL: Self = Self(13);
    /// A contact with a law that reaches across the gap.
    pub const LAW: Self = Self(27);
    /// A path of u_z alone, with the states on either side of a jump.
    pub const PATH: Self = Self(36);
    /// A path that moves all components.
    pub const ALL_COMPONENTS: Self = Self(92);
    /// A punch.
    pub const PUNCH: Self = Self(48);
    /// Held below a surface: spectra of the surface and of a plane, its fields, and the values written.
    pub const BODY: Self = Self(36);
    /// The relaxation of a free surface.
    pub const DAMPING: Self = Self(40);

    /// Bytes on a grid of so many points; the largest number there is if there is no such number.
    pub fn bytes(self, points: [usize; 2]) -> u64 {
        points.iter().fold(8 * self.0, |bytes, &points| bytes.saturating_mul(points as u64))
    }

    /// Refuses a grid that does not fit into memory, under the name of its flag or source.
    ///
    /// # Errors
    /// More memory needed than available.
    pub fn check(self, name: &str, points: [usize; 2]) -> Result<(), Failure> {
        let needed = self.bytes(points);
        let Some(available) = available_bytes().filter(|available| needed > *available) else { return Ok(()) };
        let [nx, ny] = points;
        let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        let reason = format!("{nx} x {ny} points need {:.1} GiB; {:.1} GiB are available", gib(needed), gib(available));
        Err(Failure::input(name, reason))
    }
}

/// Memory that a computation may use, in bytes, as the system reports it; `None` where it does not.
fn available_bytes() -> Option<u64> {
    if !cfg!(target_os = "linux") {
        return None;
    }
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

/// Largest resident memory of this process so far, in bytes; 0 where the system does not report it.
pub fn peak_bytes() -> u64 {
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
    use super::*;

    #[test]
    fn a_grid_whose_bytes_no_integer_holds_is_refused() {
        let all =
            [Held::SURFACE, Held::HARD_WALL, Held::LAW, Held::ALL_COMPONENTS, Held::PUNCH, Held::BODY, Held::DAMPING];
        for fields in all {
            for points in [[1 << 31; 2], [1 << 33, 1 << 28], [usize::MAX, 1]] {
                assert!(fields.bytes(points) > 1 << 60, "{fields:?} {points:?}");
                assert!(available_bytes().is_none() || fields.check("--n", points).is_err());
            }
        }
        assert_eq!(Held::HARD_WALL.bytes([512, 256]), 8 * 13 * 512 * 256);
    }
}
