//! The value of a number on an infinitely fine grid, and its error, from one solution.

use std::fmt;

/// The value that a number of a contact approaches on finer grids of the same surface, estimated from one solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridLimit {
    /// The estimate, in the unit of the number.
    pub limit: f64,
    /// Half of the width of its interval, which contained the value on a grid 8 times finer in 93 % of the contacts that the
    /// constants were not fitted to, in the unit of the number.
    pub half_width: f64,
}

/// Reasons why one solution does not tell the limit of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoLimit {
    /// Too few boundary links, the number of which is given: their errors do not average out.
    FewLinks(u64),
    /// Boundary links per point in contact: contacts are narrower than the grid resolves.
    Narrow(f64),
    /// The area fraction is too large.
    Area(f64),
    /// The conductivity is so small that its logarithm is what has an error.
    NearClosing(f64),
}

/// The least number of boundary links.
const LEAST_LINKS: u64 = 16;

/// The largest number of boundary links per point in contact: about 2 over the width of the contacts in points.
const MOST_LINKS: f64 = 2.6;

/// The largest area fraction.
const MOST_AREA: f64 = 0.8;

/// The least conductivity relative to a uniform gap.
const LEAST_CONDUCTIVITY: f64 = 0.01;

impl fmt::Display for NoLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FewLinks(found) => write!(
                f,
                "the contact has {found} boundary links; at least {LEAST_LINKS} are needed to tell the error of the grid"
            ),
            Self::Narrow(found) => write!(
                f,
                "the contact has {found:.2} boundary links a point; at most {MOST_LINKS} are resolved by the grid"
            ),
            Self::Area(found) => {
                write!(f, "the area fraction is {found:.2}; the error of the grid is known up to {MOST_AREA}")
            }
            Self::NearClosing(found) => write!(
                f,
                "the conductivity is {found:.1e}; below {LEAST_CONDUCTIVITY} the error of the grid is not known"
            ),
        }
    }
}

impl std::error::Error for NoLimit {}

impl GridLimit {
    /// The limit of the conductivity of the gap along an axis, relative to a uniform gap of the mean height: the points in
    /// contact are counted whole, so that their edges narrow the channels. With r the number of boundary links over the number
    /// of points that are not in contact, and L the number of links,
    ///
    /// limit = k (1 + 1.75 r^1.18 L^−0.18), half width = 2.0 r L^−0.28 limit.
    ///
    /// `contact_nodes` of the `points` of the grid are in contact, and have so many `boundary_links` ([`ContactArea`](crate::ContactArea)).
    /// The constants are those of the largest likelihood on 160 contacts of self-affine surfaces (H = 0, 0.3, 0.8; p* from
    /// 0.005 to 0.6; 4 to 16 points on the shortest wave) with a hard wall on a half-space, beside grids of 64 points a wave
    /// (theory.md, section 9.1).
    ///
    /// # Errors
    /// A contact for which the formula was not measured.
    pub fn of_flow(conductivity: f64, contact_nodes: u64, boundary_links: u64, points: usize) -> Result<Self, NoLimit> {
        let links = boundary_links as f64;
        let (narrow, area_fraction) = (links / contact_nodes as f64, contact_nodes as f64 / points as f64);
        if boundary_links < LEAST_LINKS {
            return Err(NoLimit::FewLinks(boundary_links));
        } else if narrow > MOST_LINKS {
            return Err(NoLimit::Narrow(narrow));
        } else if area_fraction > MOST_AREA {
            return Err(NoLimit::Area(area_fraction));
        } else if conductivity.is_nan() || conductivity < LEAST_CONDUCTIVITY {
            return Err(NoLimit::NearClosing(conductivity));
        }
        let open = links / (points as f64 - contact_nodes as f64);
        let limit = conductivity * (1.0 + 1.75 * open.powf(1.18) * links.powf(-0.18));
        Ok(Self { limit, half_width: 2.0 * open * links.powf(-0.28) * limit })
    }

    /// A bound of the error of the `value` that has this limit.
    pub fn error_of(&self, value: f64) -> f64 {
        (value - self.limit).abs() + self.half_width
    }
}
