//! The figures of a contact.

use std::path::{Path, PathBuf};

use gfmd_field::Grid;
use gfmd_plot::{Mark, Point, Series};
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
        let measured = report.loads.iter().map(|load| Point::new(load.p_star, load.area_fraction)).collect();
        let corrected = report.loads.iter().map(|load| Point::new(load.p_star, load.area_fraction_corrected)).collect();
        let mut series = vec![Series { mark: Mark::JoinedPoints, ..Series::points("counted points", 0, measured) }];
        if !grid.is_line() {
            series.push(Series {
                label: "perimeter corrected".into(),
                hue: 1,
                mark: Mark::HollowPoints,
                points: corrected,
            });
        }
        let loads = report.loads.iter().map(|load| load.p_star);
        series.extend(theories(loads.clone().fold(f64::INFINITY, f64::min), loads.fold(0.0, f64::max)));
        files.extend(area_chart(series).save(&named(prefix, "area"))?);
    }
    Ok(files)
}
