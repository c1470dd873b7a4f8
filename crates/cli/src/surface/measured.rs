//! Measurement of a surface, shared by the command, pages and Python.

use gfmd_contact::Boundary;
use gfmd_field::Grid;
use gfmd_record::{Record, Surface, SurfaceContext, SurfaceDetail, SurfaceFacts};
use gfmd_surface::{
    Areal, Direction, Features, HurstFit, MotifEdges, PowerSpectrum, ProfileNumbers, Statistics, SurfaceError, Texture,
    window,
};
use ndarray::{Array2, ArrayRef2};

use super::Window;

/// Fraction of the height range below which hills and dales are pruned, as in ISO 25178-3.
pub const USUAL_WOLF: f64 = 0.05;

/// Choices of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Choices {
    /// Longest and shortest wavelength between which the Hurst exponent is fitted.
    pub fit_range: [f64; 2],
    /// True if a range without a fit is an error.
    pub must_fit: bool,
    /// Window on the heights before their spectrum is computed.
    pub window: Window,
    /// Boundary from which moments are computed.
    pub boundary: Boundary,
    /// Length of the sections of a profile.
    pub section: Option<f64>,
    /// Choices of the detailed measurement; `None` without one.
    pub detail: Option<Detail>,
}

/// Choices of a detailed measurement.
#[derive(Clone, Copy, Debug)]
pub struct Detail {
    /// Boundary of the functions that describe the surface.
    pub boundary: Boundary,
    /// Fraction of the height range below which hills and dales are pruned.
    pub wolf: f64,
    /// Motifs at the edges; by default they continue on a periodic surface and do not count on others.
    pub edges: Option<MotifEdges>,
}

impl Detail {
    /// Returns the usual choices for a surface with this boundary.
    pub fn usual(boundary: Boundary) -> Self {
        Self { boundary, wolf: USUAL_WOLF, edges: None }
    }

    /// Returns the treatment of motifs at the edges.
    pub fn edges(&self) -> MotifEdges {
        match (self.edges, self.boundary) {
            (Some(edges), _) => edges,
            (None, Boundary::Periodic) => MotifEdges::Periodic,
            (None, Boundary::Free) => MotifEdges::LeaveOut,
        }
    }

    /// Measures hills, dales and directions beside the functions of the surface.
    ///
    /// # Errors
    /// Heights or a fraction that cannot be used.
    pub fn measure(&self, heights: &ArrayRef2<f64>, grid: &Grid) -> Result<(Functions, SurfaceDetail), SurfaceError> {
        let texture = Texture::of(heights, grid, self.boundary == Boundary::Periodic)?;
        let lengths = texture.autocorrelation.lengths();
        let direction = Direction::of(&PowerSpectrum::of(heights, grid)?, lengths.largest_aspect());
        let found = Features::with_course_lines(heights, grid, self.wolf, self.edges())?;
        let (features, course_lines) = found.unzip();
        Ok((Functions { texture, course_lines }, SurfaceDetail { lengths, direction, features }))
    }
}

/// Functions of a detailed measurement.
pub struct Functions {
    /// Autocorrelation, distributions, slopes and curvatures against distance, bearing curve.
    pub texture: Texture,
    /// Points at the course lines between hills, `[nx, ny]`; `None` for a profile and a flat surface.
    pub course_lines: Option<Array2<bool>>,
}

/// Measured numbers and functions of a surface.
pub struct Measured {
    /// Spectrum, under the window.
    pub spectrum: PowerSpectrum,
    /// Numbers.
    pub numbers: Record<Surface>,
    /// Facts for which the numbers are printed.
    pub facts: SurfaceFacts,
    /// Functions, after a detailed measurement.
    pub functions: Option<Functions>,
}

impl Measured {
    /// Measures heights `[nx, ny]`. With free boundaries moments come from differences inside.
    ///
    /// # Errors
    /// Heights or choices that cannot be used.
    pub fn of(heights: &ArrayRef2<f64>, grid: &Grid, choices: &Choices) -> Result<Self, SurfaceError> {
        let statistics = Statistics::of(heights, grid)?;
        let spectrum = match choices.window {
            Window::None => PowerSpectrum::of(heights, grid)?,
            Window::Hann => PowerSpectrum::of(&window(heights, 1.0)?, grid)?,
        };
        let [longest, shortest] = choices.fit_range;
        let mut fit: Result<HurstFit, SurfaceError> = spectrum.fit_hurst(longest, shortest);
        if choices.must_fit {
            fit = Ok(fit?);
        }
        let areal = Areal::of(heights, grid)?;
        let section = choices.section.filter(|_| grid.is_line());
        let profile = section.map(|section| ProfileNumbers::of(heights, grid, section)).transpose()?;
        let (functions, detail) = choices.detail.map(|detail| detail.measure(heights, grid)).transpose()?.unzip();
        let free = choices.boundary == Boundary::Free;
        let facts = SurfaceFacts { free, line: grid.is_line(), detailed: detail.is_some() };
        let moments = if free { statistics.moments_inside() } else { statistics.moments };
        let at = SurfaceContext {
            statistics: &statistics,
            moments,
            areal: &areal,
            fit: &fit,
            fit_range: choices.fit_range,
            cut_offs: spectrum.cut_offs(),
            profile: profile.as_ref(),
            detail: detail.as_ref(),
        };
        let numbers = Record::compute(&facts, &at);
        Ok(Self { numbers, facts, functions, spectrum })
    }
}
