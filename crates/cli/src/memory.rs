//! Memory: the need of each problem, and the use of this process.

use crate::failure::Failure;

/// The number of fields, of one double per point, that a problem holds in memory at its peak, with a margin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Held(u64);

impl Held {
    /// The synthesis of a surface: heights, half spectrum, workspace of the transform.
    pub const SURFACE: Self = Self(5);
    /// A contact with a hard wall.
    pub const HARD_WALL: Self = Self(13);
    /// A contact with a law that acts across the gap.
    pub const LAW: Self = Self(27);
    /// A path of u_z alone, with the states before and after a jump.
    pub const PATH: Self = Self(36);
    /// A path that moves all components.
    pub const ALL_COMPONENTS: Self = Self(92);
    /// A punch.
    pub const PUNCH: Self = Self(48);
    /// Fields below a surface: spectra of the surface and of a plane, fields of the plane, and the values written.
    pub const BODY: Self = Self(36);
    /// The relaxation of a free surface.
    pub const DAMPING: Self = Self(40);

    /// The number of bytes on a grid of `points`; `u64::MAX` if it is larger.
    pub fn bytes(self, points: [usize; 2]) -> u64 {
        points.iter().fold(8 * self.0, |bytes, &points| bytes.saturating_mul(points as u64))
    }

    /// Refuses a grid that does not fit into memory; the message begins with `name`, its flag or file.
    ///
    /// # Errors
    /// A need of more memory than is available.
    pub fn check(self, name: &str, points: [usize; 2]) -> Result<(), Failure> {
        let needed = self.bytes(points);
        let Some(available) = available_bytes().filter(|available| needed > *available) else { return Ok(()) };
        let [nx, ny] = points;
        let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        let reason = format!("{nx} x {ny} points need {:.1} GiB; {:.1} GiB are available", gib(needed), gib(available));
        Err(Failure::input(name, reason))
    }
}

/// The memory that a computation may use, in bytes; `None` if the system does not report it.
fn available_bytes() -> Option<u64> {
    if !cfg!(target_os = "linux") {
        return None;
    }
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|line| line.starts_with("MemAvailable:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

/// The largest resident memory of this process so far, in bytes; 0 if the system does not report it.
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
