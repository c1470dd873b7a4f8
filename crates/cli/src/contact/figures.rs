//! The figures of a contact.

use std::path::{Path, PathBuf};

use gfmd_field::Grid;
use gfmd_plot::{Chart, Mark, Point, Series};
use ndarray::Array2;

use super::Report;
use crate::failure::Failure;
use crate::figures::{area_chart, draw_pressure, named, theories};

/// Draws `PREFIX-map` of the last load, and `PREFIX-area` if there are several loads of a hard wall.
pub(super) fn draw(
    prefix: &Path,
    report: &Report,
    grid: &Grid,
    pressure: &Array2<f64>,
) -> Result<Vec<PathBuf>, Failure> {
    let unit = report.unit.as_deref().unwrap_or("length");
    let mut files = draw_pressure(&named(prefix, "map"), grid, pressure, report.e_star, unit)?;
    if report.loads.len() > 1 && report.loads.iter().all(|load| load.law.is_none()) {
        let loads = report.loads.iter().map(|load| [load.p_star, load.area_fraction, load.area_fraction_corrected]);
        files.extend(area(&loads.collect::<Vec<_>>(), grid.is_line()).save(&named(prefix, "area"))?);
    }
    Ok(files)
}

/// The contact area, counted and corrected, against the reduced pressure of loads, which are given in this order: reduced
/// pressure, area, corrected area.
pub(super) fn area(loads: &[[f64; 3]], is_line: bool) -> Chart {
    let column = |k: usize| loads.iter().map(|load| Point::new(load[0], load[k])).collect();
    let mut series = vec![Series { mark: Mark::JoinedPoints, ..Series::points("counted points", 0, column(1)) }];
    if !is_line {
        let label = "perimeter corrected".into();
        series.push(Series { label, hue: 1, mark: Mark::HollowPoints, points: column(2) });
        let p_star = || loads.iter().map(|load| load[0]);
        series.extend(theories(p_star().fold(f64::INFINITY, f64::min), p_star().fold(0.0, f64::max)));
    }
    area_chart(series)
}
