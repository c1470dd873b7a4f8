//! Contacts for the comparison of errors.

use std::f64::consts::{PI, TAU};
use std::path::Path;

use gfmd_field::Grid;
use gfmd_input::failure::Failure;
use gfmd_surface::SelfAffine;
use ndarray::Array2;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use serde::Serialize;

/// Refinement factor of the grid with the exact value.
pub(super) const FINER: usize = 8;

/// Hurst exponents, assigned to the rough surfaces in turn.
const HURST: [f64; 3] = [0.0, 0.3, 0.8];

/// Numbers of points on the shortest wave, assigned to the rough surfaces in turn.
const POINTS_PER_WAVE: [usize; 2] = [4, 8];

/// Reduced pressures.
const LOADS: [f64; 4] = [0.01, 0.05, 0.2, 0.5];

/// Number of shortest waves along the cell.
const WAVES: usize = 16;

/// Mean pressures divided by E* on rough spheres with free boundaries, for contacts that stay inside the patch. Reduced
/// pressures would depend on the grid, since the gradient of a patch is computed by differences.
const LOADS_OF_A_PATCH: [f64; 4] = [0.0007, 0.0015, 0.003, 0.007];

/// Number of shortest waves along a patch.
const WAVES_OF_A_PATCH: usize = 8;

/// Height of the sphere of a patch above the middle of its sides, divided by the length of the patch.
const SPHERE: f64 = 0.05;

/// Offset between the seeds of successive kinds of surfaces.
const APART: u64 = 1_000_000;

/// Kind of surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum CaseKind {
    /// Periodic self-affine surface.
    Rough,
    /// Rough sphere with free boundaries.
    Patch,
    /// Sphere with free boundaries (Hertz 1882).
    Sphere,
    /// Product, sum, or three directions of waves.
    Waves,
    /// Summit of a wave under adhesion, with Dugdale's law (Maugis 1992) or an exponential law.
    Adhesive,
}

/// Surface and method of solution of its contact.
#[derive(Serialize)]
pub(super) struct Case {
    pub kind: CaseKind,
    pub seed: u64,
    /// Hurst exponent; NaN for a surface that is not rough.
    pub hurst: f64,
    /// Points along a side.
    pub n: usize,
    /// Number of points on the shortest wave; 0 for a surface that is not rough.
    pub points_per_wave: usize,
    /// Random place, in lengths of the cell, and further random numbers from 0 to 1.
    random: [f64; 5],
}

impl Case {
    /// Makes surface `number` of this kind.
    pub(super) fn new(kind: CaseKind, number: u64, first_seed: u64) -> Self {
        let seed = first_seed + APART * kind as u64 + number;
        let mut source = Pcg64::seed_from_u64(seed);
        let random = std::array::from_fn(|_| source.random());
        let place = number as usize;
        let points_per_wave = POINTS_PER_WAVE[place / HURST.len() % POINTS_PER_WAVE.len()];
        let (hurst, points_per_wave, n) = match kind {
            CaseKind::Rough => (HURST[place % HURST.len()], points_per_wave, WAVES * points_per_wave),
            CaseKind::Patch => (HURST[place % HURST.len()], points_per_wave, WAVES_OF_A_PATCH * points_per_wave),
            CaseKind::Sphere => (f64::NAN, 0, [32, 64][place % 2]),
            CaseKind::Waves => (f64::NAN, 0, [32, 48, 64][place % 3]),
            CaseKind::Adhesive => (f64::NAN, 0, 64 + 32 * (place / 2 % 2)),
        };
        Self { kind, seed, hurst, n, points_per_wave, random }
    }

    /// Returns the groups of the surface in words, without its load.
    pub(super) fn groups(&self) -> Vec<String> {
        match self.kind {
            CaseKind::Rough | CaseKind::Patch => {
                vec![format!("H = {}", self.hurst), format!("{} points a wave", self.points_per_wave)]
            }
            CaseKind::Sphere | CaseKind::Waves => vec![format!("{} points", self.n)],
            CaseKind::Adhesive => vec![self.law().to_owned()],
        }
    }

    /// Returns the compared modes of `--grid-error` with their names.
    pub(super) fn modes(&self) -> &'static [(&'static str, &'static str)] {
        match self.kind {
            CaseKind::Rough => &[("estimate", "estimate"), ("refine", "refine")],
            // A patch has no finer grid.
            CaseKind::Patch => &[("free", "estimate")],
            CaseKind::Sphere => &[("Hertz", "estimate")],
            CaseKind::Waves => &[("waves", "estimate"), ("waves refine", "refine")],
            CaseKind::Adhesive => &[("adhesion refine", "refine")],
        }
    }

    /// Returns the loads and the flag for them.
    pub(super) fn drives(&self) -> (&'static str, [f64; 4]) {
        match self.kind {
            CaseKind::Rough | CaseKind::Waves => ("p-star", LOADS),
            CaseKind::Patch => ("pressure", LOADS_OF_A_PATCH),
            CaseKind::Sphere => ("pressure", self.radii().map(|radius| 4.0 * radius.powi(3) / 3.0)),
            CaseKind::Adhesive => {
                let Adhesive { pull_off, .. } = self.adhesive();
                ("pressure", [4.0, 1.0, 0.0, -0.5].map(|part| part * pull_off))
            }
        }
    }

    /// Returns the loads in words, equal for all surfaces of a kind.
    pub(super) fn loads(&self) -> [String; 4] {
        match self.kind {
            CaseKind::Rough | CaseKind::Waves => LOADS.map(|load| format!("p* = {load}")),
            CaseKind::Patch => LOADS_OF_A_PATCH.map(|load| format!("p/E* = {load}")),
            CaseKind::Sphere => ["first", "second", "third", "fourth"].map(|nth| format!("{nth} load")),
            CaseKind::Adhesive => [4.0, 1.0, 0.0, -0.5].map(|part| format!("{part} pull-off forces")),
        }
    }

    /// Returns the contact radii of a sphere of radius 1 on a patch of length 1, from two points to near the rim.
    fn radii(&self) -> [f64; 4] {
        let least = 2.0 / self.n as f64;
        let most = least + self.random[2] * (0.4 - least);
        [0.4, 0.6, 0.8, 1.0].map(|part| least + part * (most - least))
    }

    /// Returns the closed form of a contact quantity by its name; `None` without one.
    pub(super) fn closed_form(&self, load: usize, name: &str) -> Option<f64> {
        let radius = (self.kind == CaseKind::Sphere).then(|| self.radii()[load])?;
        let (force, area, most) = (4.0 * radius.powi(3) / 3.0, PI * radius * radius, 2.0 * radius / PI);
        let square = 0.5 * area * most * most;
        match name {
            "area_fraction" => Some(area),
            "mean_pressure_in_contact" => Some(force / area),
            "max_pressure" => Some(most),
            "elastic_energy" => Some(0.4 * force * radius * radius),
            "stiffness" => Some(2.0 * radius),
            "pressure_moment_2" => Some(square),
            "pressure_deviation_in_contact" => Some((square / area - (force / area).powi(2)).sqrt()),
            _ => None,
        }
    }

    /// Returns the law of an adhesive summit.
    fn law(&self) -> &'static str {
        if self.seed.is_multiple_of(2) { "dugdale" } else { "exponential" }
    }

    /// Returns the law at the summit of a wave. The contact of Johnson, Kendall and Roberts has a radius of 4 to 16
    /// points without a load, and Tabor's parameter is 0.25 to 2.
    fn adhesive(&self) -> Adhesive {
        const AMPLITUDE: f64 = 0.02;
        let curvature = 1.0 / (TAU * TAU * AMPLITUDE);
        let radius = (4.0 + 12.0 * self.random[2]) / self.n as f64;
        let energy = 2.0 * radius.powi(3) / (9.0 * PI * curvature.powi(2));
        let tabor = 0.25 + 1.75 * self.random[3];
        // μ³ = R γ²/(E*² z₀³), and Dugdale's stress is γ/range with range = 0.97 z₀, the largest Lennard-Jones stress.
        let range = 0.97 * (curvature * energy * energy).cbrt() / tabor;
        Adhesive { amplitude: AMPLITUDE, energy, range, pull_off: 1.5 * PI * energy * curvature }
    }

    /// Returns the flags of the surface on a grid that is `finer` by this factor. Heights that the program does not
    /// generate are written to `folder`.
    pub(super) fn flags(&self, finer: usize, folder: &Path) -> Result<String, Failure> {
        let n = finer * self.n;
        let written = |heights: Array2<f64>| {
            let path = folder.join(format!("{}-{n}.npy", self.seed));
            let written = ndarray_npy::write_npy(&path, &heights);
            written.map_err(|error| Failure::computation(error.to_string()))?;
            Ok::<_, Failure>(format!("--surface {} --size 1", path.display()))
        };
        let at = |i: usize, axis: usize| i as f64 / n as f64 - self.random[axis];
        match self.kind {
            CaseKind::Rough => {
                let Self { hurst, seed, .. } = self;
                let shortest = WAVES / 2;
                Ok(format!("--n {n} --eps-t-inv 2 --eps-f-inv {shortest} --hurst {hurst} --seed {seed} --flow"))
            }
            CaseKind::Patch => Ok(format!("{} --boundary free", written(self.rough_sphere(n)?)?)),
            CaseKind::Sphere => {
                // The centre lies within two points of the middle, anywhere between the points.
                let from_centre =
                    |i: usize, axis: usize| i as f64 / n as f64 - 0.5 - 4.0 * (self.random[axis] - 0.5) / self.n as f64;
                let heights = Array2::from_shape_fn((n, n), |(i, j)| {
                    -0.5 * (from_centre(i, 0).powi(2) + from_centre(j, 1).powi(2))
                });
                Ok(format!("{} --boundary free --young 1 --poisson 0", written(heights)?))
            }
            CaseKind::Waves => {
                let wave = |x: f64| (TAU * x).cos();
                let k = [2.0_f64, 3.0, 4.0][(3.0 * self.random[2]) as usize % 3];
                let kind = (3.0 * self.random[3]) as usize;
                let heights = Array2::from_shape_fn((n, n), |(i, j)| {
                    let [x, y] = [at(i, 0), at(j, 1)];
                    // Three directions, as close to a hexagon as a square cell allows.
                    let half = (0.5 * k).floor();
                    0.01 * match kind {
                        0 => wave(k * x) * wave(k * y),
                        1 => wave(k * x) + wave(k * y),
                        _ => wave(2.0 * half * x) + wave(half * (x + 2.0 * y)) + wave(half * (x - 2.0 * y)),
                    }
                });
                written(heights)
            }
            CaseKind::Adhesive => {
                let Adhesive { amplitude, energy, range, .. } = self.adhesive();
                let wave = |x: f64| amplitude * (TAU * x).cos();
                let heights = Array2::from_shape_fn((n, n), |(i, j)| wave(at(i, 0)) + wave(at(j, 1)));
                let law = format!("--law {} --param gamma={energy},range={range}", self.law());
                Ok(format!("{} --young 1 --poisson 0 {law}", written(heights)?))
            }
        }
    }

    /// Returns a rough sphere on a grid of n × n points.
    fn rough_sphere(&self, n: usize) -> Result<Array2<f64>, Failure> {
        let failed = |error: &dyn std::fmt::Display| Failure::computation(error.to_string());
        let grid = Grid::square(n, 1.0).map_err(|error| failed(&error))?;
        let rough = SelfAffine {
            hurst: self.hurst,
            longest_wavelength: 0.5,
            shortest_wavelength: 1.0 / WAVES_OF_A_PATCH as f64,
            ..SelfAffine::with_rms_gradient(0.1)
        };
        let mut heights = rough.heights(&grid, self.seed).map_err(|error| failed(&error))?;
        for ((i, j), height) in heights.indexed_iter_mut() {
            let [x, y] = [i, j].map(|index| index as f64 / n as f64 - 0.5);
            *height -= 4.0 * SPHERE * (x * x + y * y);
        }
        Ok(heights)
    }
}

/// Summit of a wave with Dugdale's law, E* = 1, in a cell of length 1.
struct Adhesive {
    amplitude: f64,
    energy: f64,
    range: f64,
    /// Pull-off force of Johnson, Kendall and Roberts.
    pull_off: f64,
}
