//! Theories of independent asperities (theory.md, section 10).

use std::f64::consts::{FRAC_PI_2, PI};

use statrs::function::erf::erfc;

use super::quadrature::{gauss_legendre, scaled, unit_rule};

/// Summits of an isotropic Gaussian surface as independent elastic contacts, valid at light loads with distant summits.
#[derive(Clone, Debug, PartialEq)]
pub struct Asperities {
    m0: f64,
    m2: f64,
    m4: f64,
    /// Paraboloids by mean curvature t in units of √m4: t, contribution to the area, contribution to the load.
    paraboloids: Vec<[f64; 3]>,
    /// Quadrature rule for integrals over the interference, on [-1, 1].
    rule: Vec<(f64, f64)>,
}

/// Contact of all summits at one separation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AsperityContact {
    /// Distance of the plane from the mean plane of the surface before deformation, length.
    pub separation: f64,
    /// Contact area divided by nominal area.
    pub area_fraction: f64,
    /// Mean pressure divided by the contact modulus E*.
    pub relative_pressure: f64,
}

/// Theory of independent asperities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AsperityTheory {
    /// Paraboloids with the joint distribution of heights and principal curvatures of the summits of a Gaussian surface
    /// (Bush, Gibson and Thomas 1975).
    BushGibsonThomas,
    /// Equal spheres with normally distributed heights (Greenwood and Williamson 1966); density, radius and scatter
    /// follow from the moments (McCool 1986).
    GreenwoodWilliamson,
}

/// Smallest Nayak parameter of an isotropic Gaussian surface.
const LEAST_NAYAK: f64 = 1.5;

/// Largest mean curvature of the integration, in units of √m4, and the numbers of nodes for mean curvature, anisotropy
/// and interference.
const STEEPEST: f64 = 14.0;
const NODES: [usize; 3] = [80, 32, 24];

impl Asperities {
    /// Takes the spectral moments m0, m2, m4 of a straight cut, the mean squares of height (length²), slope and
    /// curvature (1/length²). Returns `None` unless all are positive and Nayak's parameter m0 m4/m2² is at least 3/2.
    pub fn new([m0, m2, m4]: [f64; 3]) -> Option<Self> {
        let positive = [m0, m2, m4].iter().all(|moment| *moment > 0.0 && moment.is_finite());
        if !(positive && (m0 / m2) * (m4 / m2) >= LEAST_NAYAK) {
            return None;
        }
        Some(Self { m0, m2, m4, paraboloids: paraboloids(), rule: unit_rule(NODES[2]).collect() })
    }

    /// Area fraction beyond which summits touch each other and the theories of independent summits end.
    pub const LARGEST_AREA: f64 = 0.5;

    /// Returns Nayak's parameter m0 m4/m2².
    pub fn nayak(&self) -> f64 {
        (self.m0 / self.m2) * (self.m4 / self.m2)
    }

    /// Returns the number of summits per area, m4/(6π√3 m2), 1/length² (Longuet-Higgins 1957).
    pub fn density(&self) -> f64 {
        self.m4 / (6.0 * PI * 3_f64.sqrt() * self.m2)
    }

    /// Returns the contact at a separation from the mean plane of the surface.
    pub fn at_separation(&self, theory: AsperityTheory, separation: f64) -> AsperityContact {
        let level = separation / self.m0.sqrt();
        let [area_fraction, relative_pressure] = match theory {
            AsperityTheory::BushGibsonThomas => self.paraboloids(level),
            AsperityTheory::GreenwoodWilliamson => self.spheres(level),
        };
        AsperityContact { separation, area_fraction, relative_pressure }
    }

    /// Returns the contact under a mean pressure divided by E*; `None` if its separation is not between −20 and 12
    /// h_rms, or if its area fraction is above [`LARGEST_AREA`](Self::LARGEST_AREA).
    pub fn at_pressure(&self, theory: AsperityTheory, relative_pressure: f64) -> Option<AsperityContact> {
        let unit = self.m0.sqrt();
        let pressure = |level: f64| self.at_separation(theory, level * unit).relative_pressure;
        // The pressure falls with the separation. Beyond 12 h_rms, at pressures below 1e-30 E*, the integrals end
        // early.
        let [mut near, mut far] = [-20.0, 12.0];
        if !(relative_pressure > pressure(far) && relative_pressure <= pressure(near)) {
            return None;
        }
        for _ in 0..60 {
            let middle = 0.5 * (near + far);
            if pressure(middle) > relative_pressure { near = middle } else { far = middle }
        }
        let found = self.at_separation(theory, 0.5 * (near + far) * unit);
        (found.area_fraction <= Self::LARGEST_AREA).then_some(found)
    }

    /// Returns area fraction and relative pressure of equal spheres at a separation in units of h_rms.
    fn spheres(&self, level: f64) -> [f64; 2] {
        let nayak = self.nayak();
        let scatter = (1.0 - 0.8968 / nayak).sqrt();
        let mean = 4.0 / (PI * nayak).sqrt();
        let radius = 0.375 * (PI / self.m4).sqrt();
        let unit = self.m0.sqrt();
        let [first, power] = self.interference(mean - level, scatter);
        let area = PI * radius * self.density() * unit * first;
        [area, 4.0 / 3.0 * radius.sqrt() * self.density() * unit.powf(1.5) * power]
    }

    /// Returns area fraction and relative pressure of paraboloids. The height of a summit of mean curvature t has the
    /// mean (3/2)(m2/m4) t and the variance m0 − (3/2) m2²/m4.
    fn paraboloids(&self, level: f64) -> [f64; 2] {
        let nayak = self.nayak();
        let scatter = (1.0 - LEAST_NAYAK / nayak).max(1e-12).sqrt();
        let [mut area, mut pressure] = [0.0; 2];
        for [t, of_area, of_load] in &self.paraboloids {
            let [first, power] = self.interference(LEAST_NAYAK * t / nayak.sqrt() - level, scatter);
            area += of_area * first;
            pressure += of_load * power;
        }
        let density = self.m4 / (2.0 * PI * self.m2);
        let [unit, curvature] = [self.m0.sqrt(), self.m4.sqrt()];
        [area * density * unit / curvature, pressure * density * unit.powf(1.5) / curvature.sqrt()]
    }

    /// Returns the means of w and w^{3/2} over w > 0 for a normally distributed w (`mean`, standard deviation
    /// `scatter`).
    fn interference(&self, mean: f64, scatter: f64) -> [f64; 2] {
        let level = mean / scatter;
        let low = (level - 9.0).max(0.0);
        let high = if level > 0.0 { level + 9.0 } else { level + (level * level + 81.0).sqrt() };
        let mut sums = [0.0; 2];
        for (root, weight) in scaled(&self.rule, [low.sqrt(), high.sqrt()]) {
            let w = root * root;
            let chance = weight * 2.0 * root * (-0.5 * (w - level).powi(2)).exp() / (2.0 * PI).sqrt();
            sums[0] += chance * w;
            sums[1] += chance * w * root;
        }
        // The closed form is exact where it does not cancel.
        if level > -3.0 {
            let normal = (-0.5 * level * level).exp() / (2.0 * PI).sqrt();
            sums[0] = level * 0.5 * erfc(-level / 2_f64.sqrt()) + normal;
        }
        [scatter * sums[0], scatter.powf(1.5) * sums[1]]
    }
}

/// Returns the contributions of summits of each mean curvature t, integrated over orientations and shapes: t, area,
/// load. A summit of principal curvatures t ± r has (t² − r²)/(2π m2) times the density of t, Gaussian with variance 2
/// m4/3, and of r, a Rayleigh distribution of scale √(m4/3).
fn paraboloids() -> Vec<[f64; 3]> {
    let ratios: Vec<(f64, f64, [f64; 2])> = gauss_legendre(NODES[1], [0.0, 1.0])
        .into_iter()
        .map(|(ratio, weight)| (ratio, weight, ellipse(ratio)))
        .collect();
    let of_curvature = |(t, weight): (f64, f64)| {
        let of_t = weight * (-0.75 * t * t).exp() / (4.0 * PI / 3.0).sqrt();
        let [mut area, mut load] = [0.0; 2];
        for &(ratio, weight, [of_area, of_load]) in &ratios {
            let r = ratio * t;
            let density = of_t * weight * t * (t * t - r * r) * 3.0 * r * (-1.5 * r * r).exp();
            area += density * of_area / t;
            load += density * of_load / t.sqrt();
        }
        [t, area, load]
    };
    gauss_legendre(NODES[0], [0.0, STEEPEST]).into_iter().map(of_curvature).collect()
}

/// Computes the Hertz contact of a paraboloid of mean curvature 1 and principal curvatures 1 ± `ratio`: area divided by
/// the interference w, and force divided by E* w^{3/2} (Johnson, Contact mechanics, 4.2).
fn ellipse(ratio: f64) -> [f64; 2] {
    let curvatures = (1.0 + ratio) / (1.0 - ratio);
    let of_axes = |axes: f64| {
        let (k, excess) = elliptic(axes);
        // [(a/b)² E − K]/(K − E), with E = K (1 − excess).
        (k, excess, ((1.0 - excess) / (axes * axes) - 1.0) / excess)
    };
    // The ratio of curvatures falls from infinity to one as the ratio of axes b/a rises from zero to one.
    let [mut thin, mut round] = [-40.0, -1e-9];
    for _ in 0..80 {
        let middle: f64 = 0.5 * (thin + round);
        if of_axes(middle.exp()).2 > curvatures { thin = middle } else { round = middle }
    }
    let axes = (0.5 * (thin + round)).exp();
    let (k, excess, _) = of_axes(axes);
    // a²/w, with the small principal curvature twice the coefficient of x².
    let square = 2.0 * excess / ((1.0 - axes * axes) * (1.0 - ratio));
    [PI * axes * square, 2.0 * PI / 3.0 * square.sqrt() / k]
}

/// Returns the complete elliptic integral K of modulus e = √(1 − b²/a²), and 1 − E/K, from b/a by the
/// arithmetic-geometric mean.
fn elliptic(axes: f64) -> (f64, f64) {
    let [mut a, mut b] = [1.0, axes];
    let [mut power, mut sum] = [0.5, 0.5 * (1.0 - axes * axes)];
    while (a - b) > 1e-15 * a {
        let c = 0.5 * (a - b);
        [a, b] = [0.5 * (a + b), (a * b).sqrt()];
        power *= 2.0;
        sum += power * c * c;
    }
    (FRAC_PI_2 / a, sum)
}
