//! Grid-converged values of contact quantities and their errors, estimated from one solution.

use std::fmt;

use crate::{Peak, Scales, Summary};

/// Value that a contact quantity approaches on finer grids of the same surface, estimated from one solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridLimit {
    /// Estimate, in the unit of the quantity.
    pub limit: f64,
    /// Half the width of the interval, in the unit of the quantity. The interval contained the value on a grid 8 times
    /// finer in 93 % of contacts to which the constants were not fitted.
    pub half_width: f64,
}

/// Reasons why one solution gives no limit of a quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum NoLimit {
    /// Too few boundary links (their number), so that errors do not average out.
    FewLinks(u64),
    /// Contacts narrower than the grid resolves (boundary links per point in contact).
    Narrow(f64),
    /// Area fraction too large.
    Area(f64),
    /// Conductivity so small that only an error of its logarithm is meaningful.
    NearClosing(f64),
    /// Conductance between electrodes at a finite depth.
    Electrodes,
    /// Patches, which join and separate from grid to grid.
    Patches,
    /// Quantity with an error estimate only from the difference of two grids.
    OneGrid,
    /// Count that two grids may share by chance.
    Counted,
}

/// Smallest number of boundary links.
const LEAST_LINKS: u64 = 16;

/// Largest number of boundary links per point in contact: about 2 divided by the width of the contacts in points.
const MOST_LINKS: f64 = 2.6;

/// Largest area fraction.
const MOST_AREA: f64 = 0.8;

/// Smallest conductivity relative to a uniform gap.
const LEAST_CONDUCTIVITY: f64 = 0.01;

/// Conductivity below which its error grows.
const NEAR_CLOSING: f64 = 0.1;

impl fmt::Display for NoLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FewLinks(found) => write!(
                f,
                "the contact has {found} boundary links; at least {LEAST_LINKS} are needed to estimate the grid \
                 error"
            ),
            Self::Narrow(found) => write!(
                f,
                "the contact has {found:.2} boundary links a point; at most {MOST_LINKS} are resolved by the grid"
            ),
            Self::Area(found) => {
                write!(f, "the area fraction is {found:.2}; the grid error is known up to {MOST_AREA}")
            }
            Self::Electrodes => {
                f.write_str("the grid error of a conductance was measured with electrodes infinitely far away")
            }
            Self::Patches => f.write_str(
                "patches that nearly touch join and separate from grid to grid, and small ones appear and \
                 vanish: no estimate holds for their number and size",
            ),
            Self::Counted => f.write_str("it is counted, and two grids agree by chance"),
            Self::OneGrid => f.write_str("it cannot be estimated from one solution (use --grid-error refine)"),
            Self::NearClosing(0.0) => f.write_str("nothing flows, and the grid error of zero is not known"),
            Self::NearClosing(found) => {
                write!(f, "the conductivity is {found:.1e}; below {LEAST_CONDUCTIVITY} the grid error is not known")
            }
        }
    }
}

impl std::error::Error for NoLimit {}

impl GridLimit {
    /// Returns a limit with a half width of `part` times the limit.
    fn within(limit: f64, part: f64) -> Self {
        Self { limit, half_width: part * limit.abs() }
    }

    /// Returns the limit from the values on a grid and on a grid with twice as many points along each side alone: the
    /// second value within 2.5 times their difference. The error of a first-order quantity there is the difference, the
    /// error of a second-order quantity a third of it, and differences may be small by chance.
    pub fn of_two_grids(value: f64, fine: f64) -> Self {
        Self { limit: fine, half_width: 2.5 * (fine - value).abs() }
    }

    /// Returns a limit that covers the limits of several surfaces, one of them the true one: the midpoint of the
    /// extremes, with half their difference plus the largest half width as half width. NaN without limits.
    pub fn between(limits: &[Self]) -> Self {
        let least = limits.iter().fold(f64::INFINITY, |least, found| least.min(found.limit));
        let most = limits.iter().fold(f64::NEG_INFINITY, |most, found| most.max(found.limit));
        let half_width = limits.iter().fold(0.0, |most: f64, found| most.max(found.half_width));
        Self { limit: 0.5 * (least + most), half_width: 0.5 * (most - least) + half_width }
    }

    /// Returns a bound of the error of `value` relative to this limit, in its unit.
    pub fn error_of(&self, value: f64) -> f64 {
        (value - self.limit).abs() + self.half_width
    }
}

/// Quantity of one surface under one load on two grids, the finer one with twice as many points along each side
/// (theory.md, section 9.2).
#[derive(Clone, Copy, Debug)]
pub struct Refined {
    /// Value on the coarser grid.
    pub value: f64,
    /// Limit from the coarser grid alone; `None` if that grid gives none.
    pub own: Option<GridLimit>,
    /// Value on the finer grid.
    pub fine: f64,
    /// Limit from the finer grid alone.
    pub limit: GridLimit,
}

impl Refined {
    /// Returns the limit in a problem for which the one-grid formulas were calibrated: the limit from the finer grid.
    /// If the two limits contradict each other, the half width is their difference.
    pub fn calibrated(&self) -> GridLimit {
        let Self { own, limit, .. } = *self;
        let apart = own.filter(|own| (own.limit - limit.limit).abs() > own.half_width + limit.half_width);
        apart.map_or(limit, |own| GridLimit { half_width: (own.limit - limit.limit).abs(), ..limit })
    }

    /// Returns the limit in any other problem. The half width is the larger of the half width of the formula and the
    /// difference of the limits.
    pub fn by_difference(&self) -> GridLimit {
        let Self { value, own, fine, limit } = *self;
        let apart = own.map_or(fine - value, |own| own.limit - limit.limit).abs();
        GridLimit { half_width: limit.half_width.max(apart), ..limit }
    }

    /// Returns the limit of a conductivity of the gap, a second-order quantity.
    pub fn flow(&self) -> GridLimit {
        let Self { value, fine, limit, .. } = *self;
        let apart = ((fine - value) / fine).abs();
        let half_width = (3.4 * apart.powf(1.65) * fine * near_closing(fine)).max(0.25 * limit.half_width);
        GridLimit { limit: fine + (fine - value) / 3.0, half_width }
    }
}

/// Contact on its grid, for estimates of grid-converged values (theory.md, section 9.2).
///
/// L is the number of boundary links, ρ = L / points in contact (about 2 divided by the width of the contacts in
/// points), A the area fraction and g = 1 − A. The constants have maximum likelihood (Student's t, 4 degrees) on 160
/// contacts of self-affine surfaces (H = 0, 0.3, 0.8; p* from 0.005 to 0.6; 4 to 16 points on the shortest wave) with a
/// hard wall on a half-space, compared with grids of 64 points per wave. The half widths were scaled on 800 contacts of
/// 200 other surfaces (p* from 0.01 to 0.5, grids 8 times finer), and the half widths of the peak on 768 contacts of 96
/// more, so that 95 % of the errors are smaller.
#[derive(Clone, Copy, Debug)]
pub struct GridLimits<'a> {
    summary: &'a Summary,
    points: f64,
    spacing: f64,
    contact_modulus: f64,
    links: f64,
    narrow: f64,
    apart: f64,
    is_alike: bool,
    is_patch: bool,
}

/// Largest ρ in the formulas; larger values are clipped to it.
const LARGEST_NARROW: f64 = 3.0;

/// Returns the excess of the counted area as a fraction of the strip of Yastrebov et al.
fn strip(narrow: f64) -> f64 {
    0.858 + 0.021 * narrow.min(LARGEST_NARROW).powi(2)
}

/// Returns the fraction of the mean square pressure that a grid misses.
fn lacking(narrow: f64) -> f64 {
    0.0071 * narrow.min(LARGEST_NARROW).powf(2.47)
}

impl Summary {
    /// Returns the number of boundary links per point in contact, zero without contact.
    fn narrow(&self) -> f64 {
        if self.boundary_links == 0 { 0.0 } else { self.boundary_links as f64 / self.contact_nodes as f64 }
    }

    /// Returns κ without the excess of whole points along the edge: the limit of [`GridLimits::kappa`], also for
    /// contacts outside the calibration of its interval.
    pub fn kappa_limit(&self) -> f64 {
        self.kappa - strip(self.narrow()) * (self.kappa - self.kappa_corrected)
    }

    /// Returns ⟨p²⟩/(E* ḡ)² on an infinitely fine grid: the limit of [`GridLimits::pressure_moment_2`] in reduced
    /// units, also for contacts outside the calibration of its interval.
    pub fn reduced_square_limit(&self) -> f64 {
        let unit = self.mean_pressure / self.p_star;
        self.pressure_moment_2 * (1.0 + lacking(self.narrow())) / (unit * unit)
    }
}

impl<'a> GridLimits<'a> {
    /// Takes a contact with this `summary` and these scales on a grid of `points` at distance `spacing` (length).
    ///
    /// # Errors
    /// A contact outside the calibration of the formulas.
    pub fn of(summary: &'a Summary, points: usize, spacing: f64, scales: &Scales) -> Result<Self, NoLimit> {
        let &Summary { boundary_links, contact_nodes, area_fraction, .. } = summary;
        let (links, points) = (boundary_links as f64, points as f64);
        let narrow = links / contact_nodes as f64;
        if boundary_links < LEAST_LINKS {
            return Err(NoLimit::FewLinks(boundary_links));
        } else if !(0.0..=MOST_LINKS).contains(&narrow) {
            return Err(NoLimit::Narrow(narrow));
        } else if !(0.0..=MOST_AREA).contains(&area_fraction) {
            return Err(NoLimit::Area(area_fraction));
        }
        let apart = (1.0 - area_fraction).max(1e-3);
        Ok(Self {
            summary,
            points,
            spacing,
            contact_modulus: scales.contact_modulus,
            links: links.min(3e4),
            narrow,
            apart,
            is_alike: false,
            is_patch: false,
        })
    }

    /// Adapts the limits to a surface of few waves with contacts that are alike: their edges cross the grid in the same
    /// way, and errors do not average out. The constants cover 95 % of the errors of 340 contacts of waves (products
    /// and sums of two, hexagons, two wavelengths; 8 to 32 points per wave, in phase with the grid and not), and also
    /// the errors of area, M₂ and stiffness of Hertz's contact.
    #[must_use]
    pub fn alike(self) -> Self {
        Self { is_alike: true, ..self }
    }

    /// Adapts the limits to a patch that does not repeat, since its compliance between points differs from periodic
    /// waves. Errors of area and links are 1.2 and 1.25 times as large, errors of stiffnesses 0.62 times (95 % of 100
    /// rough spheres under four loads).
    #[must_use]
    pub fn on_patch(self) -> Self {
        Self { is_patch: true, ..self }
    }

    /// Returns the relative error of a quantity: a factor times powers of ρ, L and g. For contacts that are alike the
    /// factor is `alike`, without a power of L.
    fn part(&self, [factor, narrow, links, apart]: [f64; 4], alike: f64) -> f64 {
        let (factor, links) = if self.is_alike { (alike, 1.0) } else { (factor, self.links.powf(links)) };
        factor * self.narrow.powf(narrow) * links * self.apart.powf(apart)
    }

    /// Returns the contact area fraction. Counting adds a strip along the edge, (0.858 + 0.021 ρ²) times the
    /// [correction](crate::ContactArea) by Yastrebov et al.; the position of the edge on each link is unknown.
    pub fn area_fraction(&self) -> GridLimit {
        let Summary { area_fraction, area_fraction_corrected, .. } = self.summary;
        let limit = area_fraction - strip(self.narrow) * (area_fraction - area_fraction_corrected);
        let narrow = if self.is_alike { 1.5 } else { 1.14 };
        let factor = if self.is_patch { 1.2 * 0.372 } else { 0.372 };
        let part = self.part([factor, narrow, -0.45, -0.15], 0.22);
        GridLimit::within(limit, part.max(0.0033 * self.narrow))
    }

    /// Returns the ratio of contact area fraction to reduced pressure.
    pub fn kappa(&self) -> GridLimit {
        let GridLimit { limit, half_width } = self.area_fraction();
        let p_star = self.summary.p_star;
        GridLimit { limit: limit / p_star, half_width: half_width / p_star.abs() }
    }

    /// Returns the mean pressure over the points in contact, in stress.
    pub fn mean_pressure_in_contact(&self) -> GridLimit {
        let area = self.area_fraction();
        GridLimit::within(self.summary.mean_pressure / area.limit, area.half_width / area.limit)
    }

    /// Returns the mean square pressure, in stress².
    pub fn pressure_moment_2(&self) -> GridLimit {
        let limit = self.summary.pressure_moment_2 * (1.0 + lacking(self.narrow));
        GridLimit::within(limit, self.part([0.0586, 1.91, -0.38, -0.92], 0.055))
    }

    /// Returns the standard deviation of the pressure over the points in contact, in stress.
    pub fn pressure_deviation_in_contact(&self) -> GridLimit {
        let (area, square, mean) = (self.area_fraction(), self.pressure_moment_2(), self.mean_pressure_in_contact());
        let limit = (square.limit / area.limit - mean.limit.powi(2)).max(0.0).sqrt();
        // M2/A − (p/A)².
        let of_area = (2.0 * mean.limit.powi(2) - square.limit / area.limit) * area.half_width / area.limit;
        let of_variance = of_area.hypot(square.half_width / area.limit);
        // The two errors are partly correlated. The half width stays finite for a variance that may be zero.
        let of_variance = of_variance * if self.is_alike { 1.0 } else { 0.92 };
        GridLimit { limit, half_width: of_variance / (limit + (limit.powi(2) + of_variance).sqrt()) }
    }

    /// Returns the mean gap, in length.
    pub fn mean_gap(&self) -> GridLimit {
        let Summary { mean_gap, mean_pressure, .. } = *self.summary;
        let load = mean_pressure / self.contact_modulus * (self.spacing / mean_gap);
        let load = if self.is_alike { 1.0 } else { load.powf(0.24) };
        GridLimit::within(mean_gap, load * self.part([0.0248, 2.06, -0.38, -2.29], 0.012))
    }

    /// Returns the rigid approach, in length. For a periodic half-space it is the top of the surface minus the mean
    /// gap, where the top is `rise` above the highest grid point.
    pub fn approach(&self, approach: f64, rise: f64) -> GridLimit {
        GridLimit { limit: approach + rise, ..self.mean_gap() }
    }

    /// Returns the number of boundary links on a grid of this spacing.
    pub fn boundary_links(&self) -> GridLimit {
        let factor = if self.is_patch { 1.25 * 0.108 } else { 0.108 };
        GridLimit::within(self.summary.boundary_links as f64, self.part([factor, 0.8, -0.16, -1.35], f64::NAN))
    }

    /// Returns the elastic energy per area, in stress × length.
    pub fn elastic_energy(&self) -> GridLimit {
        GridLimit::within(self.summary.elastic_energy, self.part([0.0245, 2.38, -0.39, -2.0], 0.030))
    }

    /// Returns the largest pressure, in stress, from its peak.
    pub fn max_pressure(&self, peak: &Peak) -> GridLimit {
        let sharpness = peak.sharpness.max(0.0);
        let alike = if self.is_alike { 0.08 * sharpness } else { 0.0 };
        // A peak without skewness on its grid may still be skewed between the points.
        let skewness = peak.skewness.hypot(0.15 * sharpness.powf(1.5));
        let part = alike + 0.112 * sharpness.powf(0.75) * skewness.sqrt() * self.apart.powf(0.3);
        GridLimit::within(peak.value, part)
    }

    /// Returns the limit of a contact stiffness or a conductance of this value.
    pub fn stiffness(&self, value: f64) -> GridLimit {
        let factor = if self.is_patch { 0.62 * 0.310 } else { 0.310 };
        GridLimit::within(value, self.part([factor, 0.93, -0.46, -1.26], 0.16))
    }

    /// Returns the conductivity of the gap along an axis, relative to a uniform gap of the mean height. Points in
    /// contact count as fully closed, so that their edges narrow the channels. With r the number of boundary links
    /// divided by the number of points out of contact, the limit is k (1 + 1.75 r^1.18 L^−0.18). Its relative half
    /// width is 1.44 r L^−0.28, times 0.1/k near closing (k < 0.1).
    ///
    /// # Errors
    /// A conductivity so small that only an error of its logarithm is meaningful.
    pub fn flow(&self, conductivity: f64) -> Result<GridLimit, NoLimit> {
        if conductivity.is_nan() || conductivity < LEAST_CONDUCTIVITY {
            return Err(NoLimit::NearClosing(conductivity));
        }
        let links = self.summary.boundary_links as f64;
        let open = links / (self.points - self.summary.contact_nodes as f64);
        let limit = conductivity * (1.0 + 1.75 * open.powf(1.18) * links.powf(-0.18));
        Ok(GridLimit::within(limit, 1.44 * open * links.powf(-0.28) * near_closing(conductivity)))
    }
}

/// Returns the growth factor of the error of a conductivity near closing, where single channels carry the flow.
fn near_closing(conductivity: f64) -> f64 {
    (NEAR_CLOSING / conductivity).max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Boundary;
    use ndarray::Array2;

    /// Places thirty discs of this radius (in points) at random, each in its cell of the grid. Returns their area as a
    /// fraction of the grid and the summary of a contact with their points.
    fn discs(radius: f64, random: &mut u64) -> (f64, Summary) {
        const SIDE: usize = 180;
        let mut uniform = || {
            *random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (*random >> 11) as f64 / (1_u64 << 53) as f64
        };
        let mut field = Array2::zeros((SIDE, SIDE));
        for cell in 0..30 {
            let centre = [(cell / 5) as f64 * 30.0 + 15.0, (cell % 5) as f64 * 36.0 + 18.0];
            let centre = centre.map(|middle| middle + 4.0 * uniform());
            let near = centre.map(|middle| middle as usize - 11..(middle as usize + 13).min(SIDE));
            for (i, j) in near[0].clone().flat_map(|i| near[1].clone().map(move |j| (i, j))) {
                let distance = (i as f64 - centre[0]).hypot(j as f64 - centre[1]);
                field[[i, j]] += f64::from(u8::from(distance < radius));
            }
        }
        let [pressure, displacement, gap] = [(); 3].map(|()| field.view());
        let summary = Summary {
            mean_gap: 0.1,
            pressure_deviation_in_contact: 0.1,
            pressure_moment_2: 0.01,
            elastic_energy: 1e-3,
            ..Summary::of(pressure, displacement, gap, 0.01, &SCALES, Boundary::Periodic)
        };
        (30.0 * std::f64::consts::PI * radius * radius / (SIDE * SIDE) as f64, summary)
    }

    const SCALES: Scales = Scales { contact_modulus: 1.0, rms_gradient: 0.1 };

    /// The positions where an edge cuts the links are unknown: on average, points inside discs give the disc area. The
    /// strip along the edge is absent, since it is a property of the pressures there.
    #[test]
    fn counting_the_points_of_discs_at_random_places_errs_by_the_half_width_of_the_area() {
        let mut random = 7;
        for radius in [1.6, 3.0, 6.0, 11.0] {
            let (mut within, mut ratios) = (0, Vec::new());
            for _ in 0..100 {
                let (exact, summary) = discs(radius, &mut random);
                let limits = GridLimits::of(&summary, 180 * 180, 1.0 / 180.0, &SCALES).unwrap();
                let GridLimit { limit, half_width } = limits.area_fraction();
                let error = (summary.area_fraction - exact).abs() / exact;
                within += u32::from(error <= half_width / limit);
                ratios.push(half_width / limit / error);
                assert!((limits.kappa().limit / (10.0 * limit) - 1.0).abs() < 1e-14);
                assert!((limits.mean_pressure_in_contact().limit * limit / 0.01 - 1.0).abs() < 1e-14);
            }
            ratios.sort_by(f64::total_cmp);
            assert!(within >= 90 && ratios[50] < 5.0, "{radius}: {within} within, width over error {}", ratios[50]);
        }
    }

    #[test]
    fn two_grids_widen_the_limit_where_they_contradict_each_other() {
        let limit = |limit: f64, half_width: f64| GridLimit { limit, half_width };
        let two = |own: Option<GridLimit>| Refined { value: 0.9, own, fine: 0.96, limit: limit(1.0, 0.01) };
        assert_eq!(two(Some(limit(0.98, 0.02))).calibrated(), limit(1.0, 0.01));
        assert_eq!(two(Some(limit(0.875, 0.02))).calibrated(), limit(1.0, 0.125));
        assert_eq!(two(None).calibrated(), limit(1.0, 0.01));
        assert_eq!(two(Some(limit(0.875, 0.2))).by_difference(), limit(1.0, 0.125));
        assert_eq!(two(Some(limit(0.999, 0.2))).by_difference(), limit(1.0, 0.01));
        let GridLimit { half_width, .. } = two(None).by_difference();
        assert!((half_width - 0.06).abs() < 1e-15, "without a limit of the first grid the numbers are compared");
        // k(h) = 1 − h², exact on both grids.
        let flow = Refined { value: 0.96, own: None, fine: 0.99, limit: limit(1.2, 0.004) }.flow();
        assert!((flow.limit - 1.0).abs() < 1e-15 && flow.half_width >= 0.001, "{flow:?}");
        let between = GridLimit::between(&[limit(1.0, 0.1), limit(2.0, 0.25)]);
        assert_eq!(between, limit(1.5, 0.75));
        assert_eq!(GridLimit::between(&[limit(2.0, 0.25)]), limit(2.0, 0.25));
    }

    #[test]
    fn contacts_for_which_nothing_was_measured_are_refused_with_the_reason() {
        let (_, summary) = discs(3.0, &mut 1);
        let of = |summary: &Summary| GridLimits::of(summary, 180 * 180, 1.0 / 180.0, &SCALES).map(|_| ());
        assert_eq!(of(&summary), Ok(()));
        for (wrong, wanted) in [
            (Summary { boundary_links: 15, ..summary }, "15 boundary links; at least 16"),
            (Summary { contact_nodes: 20, ..summary }, "boundary links a point; at most 2.6"),
            (Summary { contact_nodes: 0, boundary_links: 0, ..summary }, "0 boundary links"),
            (Summary { area_fraction: 0.81, ..summary }, "the area fraction is 0.81"),
            (Summary { area_fraction: f64::NAN, ..summary }, "the area fraction is NaN"),
        ] {
            let message = of(&wrong).unwrap_err().to_string();
            assert!(message.contains(wanted), "{message}");
        }
        let limits = GridLimits::of(&summary, 180 * 180, 1.0 / 180.0, &SCALES).unwrap();
        assert!(limits.flow(0.009).is_err());
        assert!(limits.flow(f64::NAN).is_err());
        assert!(limits.flow(0.02).is_ok());
    }
}
