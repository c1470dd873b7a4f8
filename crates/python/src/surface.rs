//! Generation, reading, preparation and statistics of surfaces.

use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

use gfmd_cli::surface::{Choices, Curves, Detail, Measured, Report, Window, whole_band, write_report};
use gfmd_contact::Boundary;
use gfmd_field::Grid;
use gfmd_files::{Reading, Topography, TopographyError};
use gfmd_input::failure::Failure;
use gfmd_input::json;
use gfmd_input::memory;
use gfmd_input::session::Session;
use gfmd_input::source::composed;
use gfmd_input::source::preparation::prepare_heights;
use gfmd_problem::Spelling;
use gfmd_problem::options::quantities::text_in_units;
use gfmd_problem::options::{GeneratorArgs, Kinds, Method};
use gfmd_surface::{
    Autocorrelation, Bearing, Distributions, Fill, Interpolation, PowerSpectrum, Scales, finer as finer_heights,
};
use gfmd_unit::Units;
use ndarray::Array2;
use numpy::{IntoPyArray, PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;

use crate::failure::{failed, refused, unusable};
use crate::worker::quick;

pub(crate) type Array<'py> = Bound<'py, PyArray2<f64>>;

/// Generates a self-affine surface: heights, cell lengths, description. Arguments are the flags of `gfmd surface`.
#[pyfunction]
#[pyo3(signature = (*, n, size, shape, unit, hurst, eps_t_inv, eps_f_inv, eps_c_inv, rms_gradient, rms_height, seed,
    dim, method, roll_off, roll_off_shape, amplitudes, aspect, lay, marginal))]
#[expect(clippy::too_many_arguments, reason = "keywords")]
pub(crate) fn self_affine<'py>(
    py: Python<'py>,
    n: Vec<usize>,
    size: Vec<f64>,
    shape: Option<&str>,
    unit: Option<&str>,
    hurst: Option<f64>,
    eps_t_inv: Option<f64>,
    eps_f_inv: Option<f64>,
    eps_c_inv: Option<f64>,
    rms_gradient: Option<f64>,
    rms_height: Option<f64>,
    seed: u64,
    dim: u8,
    method: &str,
    roll_off: Option<f64>,
    roll_off_shape: &str,
    amplitudes: &str,
    aspect: Option<f64>,
    lay: Option<f64>,
    marginal: Option<&str>,
) -> PyResult<(Array<'py>, [f64; 2], String, bool)> {
    let method = match method {
        "psd" => Method::Psd,
        "sra" => Method::Sra,
        "rmd" => Method::Rmd,
        _ => return Err(refused(py, &format!("method is {method:?}; it must be one of psd, sra, rmd"))),
    };
    if !(2..=3).contains(&dim) {
        return Err(refused(py, &format!("dim is {dim}; it must be 2 (a profile) or 3")));
    }
    let of_shape = |text| with_units(("shape", Kinds::SHAPE), text, unit);
    let of_marginal = |text| with_units(("marginal", Kinds::MARGINAL), text, unit);
    let args = GeneratorArgs {
        n,
        shape: shape.map(of_shape).transpose().map_err(|error| refused(py, &error))?,
        hurst,
        eps_t_inv,
        eps_f_inv,
        eps_c_inv,
        rms_gradient,
        rms_height,
        seed,
        dim,
        method,
        roll_off,
        roll_off_shape: roll_off_shape.parse().map_err(|error| refused(py, &error))?,
        amplitudes: amplitudes.parse().map_err(|error| refused(py, &error))?,
        aspect,
        lay,
        marginal: marginal.map(of_marginal).transpose().map_err(|error| refused(py, &error))?,
    };
    let made = quick(py, || {
        let grid = gfmd_input::source::grid_of(&args, &size)?;
        args.check_shape(&grid, true)?;
        Ok((args.heights(&grid)?, grid.lengths()))
    })?;
    let (heights, lengths) = made.map_err(|failure| failed(py, failure))?;
    Ok((heights.into_pyarray(py), lengths, args.to_string(), args.is_periodic()))
}

/// Reads a shape or a distribution, whose lengths may have units if the lengths of the surface have one.
fn with_units<T: FromStr<Err: Display>>(
    (key, kinds): (&str, Kinds),
    text: &str,
    unit: Option<&str>,
) -> Result<T, String> {
    let units = Units::new(unit, None);
    let bare = text_in_units((key, kinds), text, &units);
    let bare = bare.map_err(|error| error.spelled(Spelling::Argument))?;
    bare.as_deref().unwrap_or(text).parse().map_err(|error| format!("{key}: {error}"))
}

/// Heights (NaN where undefined), lengths of the cell, unit, description, and the file's other entries as JSON.
type HeightMap<'py> = (Array<'py>, Option<[f64; 2]>, Option<String>, String, String);

/// Reads a height map from a file.
#[pyfunction]
#[pyo3(signature = (name, channel=None, image_heights=false))]
pub(crate) fn read<'py>(
    py: Python<'py>,
    name: &str,
    channel: Option<&str>,
    image_heights: bool,
) -> PyResult<HeightMap<'py>> {
    let read = || {
        let found = Topography::read_as(name, Reading { channel, image_heights })?;
        found.warnings.iter().for_each(|text| tracing::warn!("{name}: {text}"));
        Ok::<_, TopographyError>(found)
    };
    let topography = quick(py, read)?.map_err(|error| refused(py, &error))?;
    let Topography {
        heights,
        undefined,
        lengths,
        unit,
        format,
        channel,
        channels,
        conversion,
        details,
        notes,
        source,
        ..
    } = topography;
    let details: serde_json::Map<_, _> = details.into_iter().map(|(key, value)| (key, value.into())).collect();
    let reported = serde_json::json!({
        "format": format, "channel": channel, "channels": channels, "undefined": undefined, "conversion": conversion,
        "details": details, "notes": notes,
    });
    Ok((heights.into_pyarray(py), lengths, unit, source, reported.to_string()))
}

/// Fills undefined points (NaN).
#[pyfunction]
pub(crate) fn fill<'py>(
    py: Python<'py>,
    heights: PyReadonlyArray2<'py, f64>,
    lengths: [f64; 2],
    how: &str,
) -> PyResult<Array<'py>> {
    let how: Fill = how.parse().map_err(|error| refused(py, &error))?;
    let heights = heights.as_array().to_owned();
    let grid = grid(py, heights.dim().into(), lengths)?;
    let whole =
        quick(py, || gfmd_surface::fill(&heights, grid.spacing(), how))?.map_err(|error| refused(py, &error))?;
    Ok(whole.into_pyarray(py))
}

/// Removes a trend from heights.
#[pyfunction]
pub(crate) fn detrend<'py>(py: Python<'py>, heights: PyReadonlyArray2<'py, f64>, trend: &str) -> PyResult<Array<'py>> {
    let trend = trend.parse().map_err(|error| refused(py, &error))?;
    let heights = heights.as_array().to_owned();
    let rest = quick(py, || gfmd_surface::remove(&heights, trend))?.map_err(|error| refused(py, &error))?;
    Ok(rest.into_pyarray(py))
}

/// Returns heights at even spacing from heights at uneven places, and the spacing.
#[pyfunction]
pub(crate) fn even<'py>(
    py: Python<'py>,
    places: Vec<f64>,
    heights: Vec<f64>,
    points: Option<usize>,
) -> PyResult<(Array<'py>, f64)> {
    let made = quick(py, || gfmd_prepare::even(&places, &heights, points))?;
    let (heights, spacing) = made.map_err(|error| refused(py, &error))?;
    let rows = Array2::from_shape_vec((heights.len(), 1), heights).map_err(|error| refused(py, &error))?;
    Ok((rows.into_pyarray(py), spacing))
}

/// Heights, lengths, words and record of a step of the preparation.
type Step<'py> = (Array<'py>, [f64; 2], String, String);

/// Applies one step of the preparation; `given` is the unit of the heights, the option and its text, and whether the
/// surface repeats.
#[pyfunction]
#[pyo3(signature = (heights, lengths, given, excluded=None))]
pub(crate) fn prepared<'py>(
    py: Python<'py>,
    heights: PyReadonlyArray2<'py, f64>,
    lengths: [f64; 2],
    given: (Option<String>, String, String, bool),
    excluded: Option<PyReadonlyArray2<'py, bool>>,
) -> PyResult<Step<'py>> {
    const OPTIONS: [&str; 9] =
        ["crop", "invalid", "despike", "descar", "level", "detrend", "filter", "resample", "resample_spacing"];
    let (unit, option, text, is_periodic) = given;
    let option = OPTIONS.into_iter().find(|known| *known == option);
    let option = option.ok_or_else(|| refused(py, &"the step is unknown"))?;
    let heights = heights.as_array().to_owned();
    let excluded = excluded.map(|excluded| excluded.as_array().to_owned());
    let grid = grid(py, heights.dim().into(), lengths)?;
    let step = || prepare_heights((heights, grid, unit.as_deref()), (option, &text), excluded, is_periodic);
    let found = quick(py, step)?.map_err(|failure| failed(py, failure))?;
    found.warnings.iter().for_each(|text| tracing::warn!("{text}"));
    Ok((found.heights.into_pyarray(py), found.grid.lengths(), found.words, found.record))
}

/// Makes heights one period of a cell; returns them and its lengths.
#[pyfunction]
pub(crate) fn periodise<'py>(
    py: Python<'py>,
    heights: PyReadonlyArray2<'py, f64>,
    lengths: [f64; 2],
    way: &str,
) -> PyResult<(Array<'py>, [f64; 2])> {
    let way = way.parse().map_err(|error| refused(py, &error))?;
    let heights = heights.as_array().to_owned();
    let grid = grid(py, heights.dim().into(), lengths)?;
    let made = quick(py, || gfmd_surface::periodise(&heights, &grid, way))?;
    let (heights, grid) = made.map_err(|error| refused(py, &error))?;
    Ok((heights.into_pyarray(py), grid.lengths()))
}

/// Returns the composite heights of two surfaces, the second shifted by `shift`, and the lengths of their cell. For
/// surfaces that are not periodic, it is the overlap.
#[pyfunction]
pub(crate) fn composite<'py>(
    py: Python<'py>,
    first: PyReadonlyArray2<'py, f64>,
    second: PyReadonlyArray2<'py, f64>,
    lengths: [f64; 2],
    shift: [f64; 2],
    boundary: &str,
) -> PyResult<(Array<'py>, [f64; 2])> {
    let boundary: Boundary = boundary.parse().map_err(|error| refused(py, &error))?;
    let [first, second] = [first, second].map(|heights| heights.as_array().to_owned());
    let grid = grid(py, first.dim().into(), lengths)?;
    let made = quick(py, || composed(&first, &second, &grid, (shift, boundary)))?;
    let (heights, grid) = made.map_err(|error| refused(py, &format!("shift: {error}")))?;
    Ok((heights.into_pyarray(py), grid.lengths()))
}

/// Refines a periodic surface to `times` as many points along each side.
#[pyfunction]
pub(crate) fn finer<'py>(
    py: Python<'py>,
    heights: PyReadonlyArray2<'py, f64>,
    lengths: [f64; 2],
    times: usize,
) -> PyResult<Array<'py>> {
    let heights = heights.as_array().to_owned();
    let grid = grid(py, heights.dim().into(), lengths)?;
    let made = quick(py, || {
        let [nx, ny] = grid.points().map(|points| points.saturating_mul(times));
        memory::fits(memory::SURFACE, "times", [nx, if grid.is_line() { 1 } else { ny }])?;
        finer_heights(&heights, &grid, times, Interpolation::Waves).map_err(|error| Failure::input("times", error))
    })?;
    let (heights, _) = made.map_err(|failure| unusable(py, failure))?;
    Ok(heights.into_pyarray(py))
}

/// Returns the statistics of heights as JSON, as `gfmd surface` prints them; `section` is the length of the sections of
/// a profile, `features` are boundary, fraction of Wolf pruning and treatment of motifs at the edges.
#[pyfunction]
#[pyo3(signature = (heights, lengths, fit_range=None, section=None, features=None))]
pub(crate) fn statistics(
    py: Python<'_>,
    heights: PyReadonlyArray2<'_, f64>,
    lengths: [f64; 2],
    fit_range: Option<[f64; 2]>,
    section: Option<f64>,
    features: Option<(String, f64, Option<String>)>,
) -> PyResult<String> {
    let heights = heights.as_array().to_owned();
    let grid = grid(py, heights.dim().into(), lengths)?;
    let detail = match features {
        None => None,
        Some((boundary, wolf, edges)) => Some(Detail {
            boundary: boundary.parse().map_err(|error| refused(py, &error))?,
            wolf,
            edges: edges.map(|edges| edges.parse()).transpose().map_err(|error| refused(py, &error))?,
        }),
    };
    let choices = Choices {
        fit_range: fit_range.unwrap_or_else(|| whole_band(&grid)),
        must_fit: fit_range.is_some(),
        window: Window::None,
        boundary: Boundary::Periodic,
        section,
        detail,
    };
    let found = quick(py, || {
        let measured = Measured::of(&heights, &grid, &choices)?;
        Ok::<_, gfmd_surface::SurfaceError>(Report::new(&measured, &grid))
    })?;
    let report = found.map_err(|error| refused(py, &error))?;
    json::to_string(&report).map_err(|error| refused(py, &error))
}

/// Returns wavenumbers and the radially averaged power spectral density of heights, with a Hann window if requested.
#[pyfunction]
pub(crate) fn psd(
    py: Python<'_>,
    heights: PyReadonlyArray2<'_, f64>,
    lengths: [f64; 2],
    window: &str,
) -> PyResult<(Vec<f64>, Vec<f64>)> {
    let heights = heights.as_array().to_owned();
    let grid = grid(py, heights.dim().into(), lengths)?;
    let found = quick(py, || match window {
        "hann" => gfmd_surface::window(&heights, 1.0).and_then(|heights| PowerSpectrum::of(&heights, &grid)),
        _ => PowerSpectrum::of(&heights, &grid),
    })?;
    let spectrum = found.map_err(|error| refused(py, &error))?;
    Ok(spectrum.radial().into_iter().map(|bin| (bin.wavenumber, bin.density)).unzip())
}

/// Returns a named function of heights as JSON, as `gfmd surface --statistics` prints it; for the autocorrelation also
/// the map of height differences.
#[pyfunction]
pub(crate) fn texture<'py>(
    py: Python<'py>,
    heights: PyReadonlyArray2<'py, f64>,
    lengths: [f64; 2],
    part: &str,
    repeats: bool,
) -> PyResult<(String, Option<Array<'py>>)> {
    let heights = heights.as_array().to_owned();
    let grid = grid(py, heights.dim().into(), lengths)?;
    let found = quick(py, || {
        Ok::<_, gfmd_surface::SurfaceError>(match part {
            "autocorrelation" => {
                let found = Autocorrelation::of(&heights, &grid, repeats)?;
                (Curves::autocorrelation(&found, &grid), Some(found.map()))
            }
            "distributions" => (Curves::distributions(&Distributions::of(&heights, &grid, repeats)?, &grid), None),
            "scale_dependence" => (Curves::scale_dependence(&Scales::of(&heights, &grid, repeats)?), None),
            _ => (Curves::bearing_curve(&Bearing::of(&heights, &grid)?), None),
        })
    })?;
    let (curves, map) = found.map_err(|error| refused(py, &error))?;
    let text = json::to_string(&curves).map_err(|error| refused(py, &error))?;
    Ok((text, map.map(|map| map.into_pyarray(py))))
}

/// Writes the report page of a surface; `words` are its unit and description.
#[pyfunction]
pub(crate) fn surface_report(
    py: Python<'_>,
    heights: PyReadonlyArray2<'_, f64>,
    lengths: [f64; 2],
    words: (Option<String>, String),
    boundary: &str,
    path: &str,
) -> PyResult<()> {
    let boundary: Boundary = boundary.parse().map_err(|error| refused(py, &error))?;
    let heights = heights.as_array().to_owned();
    let grid = grid(py, heights.dim().into(), lengths)?;
    let done = quick(py, || write_report(&heights, &grid, words, boundary, Path::new(path), &Session::embedded()))?;
    done.map_err(|failure| failed(py, failure))
}

/// Builds the grid of an array in a cell.
pub(crate) fn grid(py: Python<'_>, points: [usize; 2], lengths: [f64; 2]) -> PyResult<Grid> {
    Grid::new(points, lengths).map_err(|error| refused(py, &format!("size: {error}")))
}
