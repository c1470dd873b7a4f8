//! Arrays that statistics add to a load or a waypoint of a path, each declared once: patches, distributions, spectra.

use gfmd_contact::Boundary;
use gfmd_field::Grid;
use gfmd_measure::{Distribution, Patches, density_over_decades};
use gfmd_problem::Facts;
use gfmd_surface::PowerSpectrum;
use ndarray::ArrayView2;

use crate::when::{any, loads, path};

/// Number of bins of a distribution.
const BINS: usize = 100;

/// Decades of a logarithmic distribution below its largest value.
const DECADES: usize = 6;

/// Number of bins per decade.
const BINS_PER_DECADE: usize = 10;

/// Axis of the values of a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// Patches of points in contact, in the order of their first points.
    Patch,
    /// Bins of equal width between zero and the largest value of the state.
    Bin,
    /// Rings of wavevectors of similar length, for periodic fields only.
    Ring,
    /// Distances along x, from zero to half the cell, for periodic fields only.
    LagX,
    /// Distances along y, from zero to half the cell, for periodic fields only.
    LagY,
}

/// Array of a load or a waypoint.
#[derive(Clone, Copy, Debug)]
pub struct Statistic {
    /// Path in a file.
    pub path: &'static str,
    /// Axis of the values.
    pub along: Along,
    /// Unit; `None` for the length unit of the surface.
    pub unit: Option<&'static str>,
    /// Definition.
    pub meaning: &'static str,
    /// True if the states of a problem have the array.
    pub present: fn(&Facts) -> bool,
    /// Values of a state, by its number.
    pub values: fn(&Statistics, usize) -> Vec<f64>,
}

fn of_patches(found: &Statistics, number: usize) -> Vec<f64> {
    found.patches.iter().map(|patch| patch[number]).collect()
}

fn of_spectra(found: &Statistics, part: fn(&Spectra) -> Vec<f64>) -> Vec<f64> {
    found.spectra.as_ref().map(part).unwrap_or_default()
}

fn number_of_state(found: &Statistics, number: usize) -> Vec<f64> {
    vec![number as f64; found.patches.len()]
}

/// Returns the arrays of the states of a problem.
pub fn statistics_of(facts: &Facts) -> impl Iterator<Item = &'static Statistic> {
    STATISTICS.iter().filter(|statistic| (statistic.present)(facts))
}

/// All arrays, in file order.
pub const STATISTICS: &[Statistic] = &[
    Statistic {
        path: "/patches/load",
        along: Along::Patch,
        unit: Some("1"),
        meaning: "load step of the patch",
        present: loads,
        values: number_of_state,
    },
    Statistic {
        path: "/patches/waypoint",
        along: Along::Patch,
        unit: Some("1"),
        meaning: "waypoint of the patch",
        present: path,
        values: number_of_state,
    },
    Statistic {
        path: "/patches/area",
        along: Along::Patch,
        unit: Some("length^2"),
        meaning: "area: number of points times the pixel area",
        present: any,
        values: |found, _| of_patches(found, 0),
    },
    Statistic {
        path: "/patches/perimeter",
        along: Along::Patch,
        unit: Some("length"),
        meaning: "length of the edges between points in contact and points out of contact; excludes the rim of a \
                  surface with free boundaries",
        present: any,
        values: |found, _| of_patches(found, 1),
    },
    Statistic {
        path: "/patches/force",
        along: Along::Patch,
        unit: Some("stress*length^2"),
        meaning: "force on the patch",
        present: any,
        values: |found, _| of_patches(found, 2),
    },
    Statistic {
        path: "/patches/x",
        along: Along::Patch,
        unit: None,
        meaning: "x of the centre of area; NaN if the patch winds around the cell along x",
        present: any,
        values: |found, _| of_patches(found, 3),
    },
    Statistic {
        path: "/patches/y",
        along: Along::Patch,
        unit: None,
        meaning: "y of the centre of area; NaN if the patch winds around the cell along y",
        present: any,
        values: |found, _| of_patches(found, 4),
    },
    Statistic {
        path: "/distributions/pressure",
        along: Along::Bin,
        unit: Some("1/stress"),
        meaning: "probability density of positive pressures over the whole surface",
        present: any,
        values: |found, _| found.pressure.densities.clone(),
    },
    Statistic {
        path: "/distributions/pressure_at",
        along: Along::Bin,
        unit: Some("stress"),
        meaning: "pressure at the bin centre",
        present: any,
        values: |found, _| found.pressure.middles.clone(),
    },
    Statistic {
        path: "/distributions/gap",
        along: Along::Bin,
        unit: Some("1/length"),
        meaning: "probability density of the gap at points out of contact, over the whole surface",
        present: any,
        values: |found, _| found.gap.densities.clone(),
    },
    Statistic {
        path: "/distributions/gap_at",
        along: Along::Bin,
        unit: None,
        meaning: "gap at the bin centre",
        present: any,
        values: |found, _| found.gap.middles.clone(),
    },
    Statistic {
        path: "/spectra/pressure",
        along: Along::Ring,
        unit: Some("stress^2*length^2"),
        meaning: "radially averaged power spectral density of the pressure, defined as for heights",
        present: any,
        values: |found, _| of_spectra(found, |spectra| spectra.radial.iter().map(|bin| bin[1]).collect()),
    },
    Statistic {
        path: "/spectra/autocorrelation_x",
        along: Along::LagX,
        unit: Some("1"),
        meaning: "autocorrelation of the pressure less its mean, along x",
        present: any,
        values: |found, _| of_spectra(found, |spectra| spectra.correlation[0].clone()),
    },
    Statistic {
        path: "/spectra/autocorrelation_y",
        along: Along::LagY,
        unit: Some("1"),
        meaning: "autocorrelation of the pressure less its mean, along y",
        present: any,
        values: |found, _| of_spectra(found, |spectra| spectra.correlation[1].clone()),
    },
];

/// Returns the patches of repelled points.
pub fn patches(repulsion: ArrayView2<'_, f64>, boundary: Boundary) -> Patches {
    Patches::of(repulsion.mapv(|p| p > 0.0).view(), boundary)
}

/// Error: a field without statistics.
#[derive(Clone, Debug, thiserror::Error)]
#[error("the spectrum of the pressure: {0}")]
pub struct Unmeasured(String);

/// Patches, distributions and spectra of a state.
#[derive(Clone, Debug)]
pub struct Statistics {
    /// Area, perimeter, force and centre of each patch, in the order of their first points.
    patches: Vec<[f64; 5]>,
    /// Distribution of the pressure.
    pub pressure: Distribution,
    /// Distribution of the gap at points not in contact.
    pub gap: Distribution,
    /// Gaps and densities, in bins of equal width on a logarithmic scale.
    pub gap_decades: Vec<[f64; 2]>,
    /// Spectra, for periodic fields only.
    spectra: Option<Spectra>,
}

/// Spectrum of a pressure.
#[derive(Clone, Debug)]
struct Spectra {
    /// Wavenumbers and power spectral densities.
    radial: Vec<[f64; 2]>,
    /// Autocorrelation along x and along y.
    correlation: [Vec<f64>; 2],
}

impl Statistics {
    /// Measures the fields of a state, and its patches. `pressure` is the repulsive part only, which is zero out of
    /// contact.
    ///
    /// # Errors
    /// Returns an error if the fields do not fit the grid.
    pub fn of(
        grid: &Grid,
        boundary: Boundary,
        pressure: ArrayView2<'_, f64>,
        gap: ArrayView2<'_, f64>,
    ) -> Result<(Self, Patches), Unmeasured> {
        let found = patches(pressure, boundary);
        let [dx, dy] = grid.spacing();
        let points = grid.len();
        let forces = found.sums(pressure);
        let rows = found.patches.iter().zip(forces).map(|(patch, force)| {
            let perimeter = patch.links[0] as f64 * dy + patch.links[1] as f64 * dx;
            let [x, y] = patch.centre;
            [patch.points as f64 * dx * dy, perimeter, force * dx * dy, x * dx, y * dy]
        });
        let apart = || gap.iter().zip(pressure).filter(|(_, p)| **p <= 0.0).map(|(gap, _)| *gap);
        let measured = Self {
            patches: rows.collect(),
            pressure: Distribution::of(pressure.iter().copied(), points, BINS),
            gap: Distribution::of(apart(), points, BINS),
            gap_decades: density_over_decades(apart(), points, DECADES, BINS_PER_DECADE),
            spectra: (boundary == Boundary::Periodic).then(|| spectra(grid, pressure)).transpose()?,
        };
        Ok((measured, found))
    }

    /// Returns wavenumbers and densities of the pressure spectrum; `None` for fields that are not periodic.
    pub fn spectrum(&self) -> Option<&[[f64; 2]]> {
        self.spectra.as_ref().map(|spectra| &spectra.radial[..])
    }
}

/// Computes the radially averaged spectrum of the pressure, and its autocorrelation along x and y divided by the
/// variance, up to half the cell.
fn spectra(grid: &Grid, pressure: ArrayView2<'_, f64>) -> Result<Spectra, Unmeasured> {
    let unusable = |error: &dyn std::fmt::Display| Unmeasured(error.to_string());
    let spectrum = PowerSpectrum::of(&pressure.to_owned(), grid).map_err(|error| unusable(&error))?;
    let radial = spectrum.radial().into_iter().map(|bin| [bin.wavenumber, bin.density]).collect();
    let correlation = spectrum.correlation().map_err(|error| unusable(&error))?;
    let [nx, ny] = grid.points();
    let relative = |index: usize| if correlation[0] > 0.0 { correlation[index] / correlation[0] } else { f64::NAN };
    let along_x = (0..=nx / 2).map(|i| relative(i % nx * ny)).collect();
    Ok(Spectra { radial, correlation: [along_x, (0..=ny / 2).map(|j| relative(j % ny)).collect()] })
}

impl Statistics {
    /// Returns the points of an axis: wavenumbers, distances, or indices of patches and bins.
    pub fn axis(&self, along: Along, grid: &Grid) -> Vec<f64> {
        let [dx, dy] = grid.spacing();
        let lags = |axis: usize, spacing: f64| {
            let count = self.spectra.as_ref().map_or(0, |spectra| spectra.correlation[axis].len());
            (0..count).map(|k| k as f64 * spacing).collect()
        };
        match along {
            Along::Patch => (0..self.patches.len()).map(|k| k as f64).collect(),
            Along::Bin => (0..BINS).map(|k| k as f64).collect(),
            Along::Ring => of_spectra(self, |spectra| spectra.radial.iter().map(|bin| bin[0]).collect()),
            Along::LagX => lags(0, dx),
            Along::LagY => lags(1, dy),
        }
    }
}
