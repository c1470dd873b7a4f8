//! Figure of kappa against the load of one surface on bodies that are elastic, yield, and have a hardness
//! (docs/plasticity.md). It reads the files of the commands of that page, and writes docs/images/plasticity-kappa.svg:
//! `cargo run --release -p gfmd-xtask --example yield_kappa -- elastic.h5 yielding.h5 hardness.h5`.

use std::f64::consts::{LN_2, PI};
use std::fs;
use std::path::Path;

use gfmd_files::Reader;
use gfmd_plot::{Axis, Chart, Level, Panel, Point, Series};

const NAMES: [&str; 3] = ["elastic", "yield stress *Y*", "hardness 2.8 *Y*"];

/// Returns the contact area of a square field of pressure, corrected as `area_fraction_corrected` is: less a part of a
/// point for each link between a point in contact and one outside.
fn corrected_area(pressure: &[f64]) -> f64 {
    let n = pressure.len().isqrt();
    let touches = |i: usize, j: usize| pressure[i % n * n + j % n] > 0.0;
    let (mut points, mut links) = (0, 0);
    for (i, j) in (0..n * n).map(|place| (place / n, place % n)) {
        points += usize::from(touches(i, j));
        links += [touches(i + 1, j), touches(i, j + 1)].into_iter().filter(|there| *there != touches(i, j)).count();
    }
    (points as f64 - (PI - 1.0 + LN_2) / 24.0 * links as f64) / pressure.len() as f64
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut series = Vec::new();
    for (hue, (name, file)) in NAMES.into_iter().zip(std::env::args().skip(1)).enumerate() {
        let reader = Reader::open(&file)?;
        let group = if reader.contains("/loads/p_star") { "/loads" } else { "/path" };
        let pressures = reader.values::<f64>(&format!("{group}/p_star"))?;
        let mut points = Vec::new();
        for (index, pressure) in pressures.into_iter().enumerate() {
            let field = reader.slab::<f64>("/fields/pressure", index)?;
            points.push(Point::new(pressure, corrected_area(&field) / pressure));
        }
        series.push(Series::line("", hue, points.iter().map(|point| (point.x, point.y))));
        series.push(Series::points(name, hue, points));
    }
    let chart = Chart::new(vec![Panel {
        x: Axis::log("*p*\\* = *p*/(*E*\\**g*)"),
        y: Axis::linear("*κ* = *a*_r/*p*\\*").over([0.0, 10.0]),
        levels: vec![Level::line((8.0 / PI).sqrt(), "Persson")],
        series,
        ..Panel::default()
    }]);
    fs::write(Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/images/plasticity-kappa.svg"), chart.svg()?)?;
    Ok(())
}
