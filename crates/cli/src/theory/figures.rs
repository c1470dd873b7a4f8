//! Figures of the theories of a surface.

use std::path::{Path, PathBuf};

use gfmd_measure::theory::AsperityTheory;
use gfmd_plot::{Axis, Chart, Mark, Panel, Series};

use super::Theories;
use gfmd_input::failure::Failure;
use gfmd_report::figures::{area_chart, length, named};

/// Draws the area and the mean gap over the loads of interest, and the distribution of pressure at each load.
pub(super) fn draw(stem: &Path, theories: &Theories, p_star: &[f64], unit: &str) -> Result<Vec<PathBuf>, Failure> {
    let low = p_star.iter().copied().fold(1e-3, f64::min);
    let high = p_star.iter().copied().fold(2.0, f64::max);
    let loads = |steps: u32| (0..=steps).map(move |i| low * (high / low).powf(f64::from(i) / f64::from(steps)));
    let mut series = vec![Series::line("Persson", 5, loads(80).map(|p| (p, theories.area(p))))];
    let names = [
        (AsperityTheory::BushGibsonThomas, "Bush–Gibson–Thomas", 6),
        (AsperityTheory::GreenwoodWilliamson, "Greenwood–Williamson", 2),
    ];
    for (theory, name, hue) in names {
        let points = loads(30).filter_map(|p| Some((p, theories.asperity(theory, p).ok()?.area_fraction)));
        let points: Vec<(f64, f64)> = points.collect();
        if !points.is_empty() {
            series.push(Series { mark: Mark::Dashes, ..Series::line(name, hue, points) });
        }
    }
    if let Ok(area) = theories.self_affine {
        series.push(Series::line("formula, endless spectrum", 0, loads(80).map(|p| (p, area.at(p)))));
    }
    let mut files = area_chart(series).save(&named(stem, "area"))?.to_vec();
    let gaps: Vec<(f64, f64)> = loads(80).map(|p| (p, theories.mean_gap(p))).filter(|(_, gap)| *gap > 0.0).collect();
    let read = length(unit, gaps.iter().map(|(_, gap)| *gap).fold(0.0, f64::max));
    let gap = gaps.into_iter().map(|(p, gap)| (p, gap * read.factor));
    let panel = Panel {
        x: Axis::log("reduced pressure *p*\\* = *p*/(*E*\\**g*)"),
        y: Axis::log(&format!("mean gap / {}, Persson", read.name)),
        series: vec![Series::line("", 5, gap)],
        ..Panel::default()
    };
    files.extend(Chart::new(vec![panel]).save(&named(stem, "gap"))?);
    let deviation = theories.persson.variance(f64::INFINITY).sqrt();
    let highest = p_star.iter().map(|p| theories.pressure(*p)).fold(0.0, f64::max) + 4.0 * deviation;
    // E* g, the unit of reduced pressures.
    let scale = theories.pressure(1.0);
    let distribution = |(hue, load): (usize, &f64)| {
        let mean = theories.pressure(*load);
        let points = (0..=300).map(|i| highest * f64::from(i) / 300.0);
        let area = theories.area(*load);
        let density = |p: f64| theories.persson.pressure_density(mean, f64::INFINITY, p) / area;
        let points = points.map(|p| (p / scale, density(p) * scale));
        let load: f64 = format!("{load:.3e}").parse().unwrap_or(*load);
        Series::line(&format!("*p*\\* = {load}"), hue, points)
    };
    let panel = Panel {
        x: Axis::linear("pressure *p*/(*E*\\**g*)"),
        y: Axis::linear("density × *E*\\**g*, Persson"),
        series: p_star.iter().take(MOST_CURVES).enumerate().map(distribution).collect(),
        ..Panel::default()
    };
    files.extend(Chart::new(vec![panel]).save(&named(stem, "pressure"))?);
    Ok(files)
}

/// Largest number of distinguishable curves.
const MOST_CURVES: usize = 6;
