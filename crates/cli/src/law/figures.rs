//! Figure of a law.

use std::path::{Path, PathBuf};

use gfmd_law::Law;
use gfmd_plot::{Axis, Chart, Panel, Series};

use gfmd_input::failure::Failure;
use gfmd_unit::Units;

/// Draws T_n over the range of `normal` for each value of `tangential`, and T_t over the range of `tangential` for each
/// value of `normal`.
pub(super) fn draw(
    stem: &Path,
    law: &dyn Law,
    (normal, tangential): (&[f64], &[f64]),
    units: &Units,
) -> Result<Vec<PathBuf>, Failure> {
    const STEPS: u32 = 200;
    let curves = |span: &[f64], others: &[f64], name: &str, of: &dyn Fn(f64, f64) -> f64| -> Vec<Series> {
        let low = span.iter().copied().fold(f64::INFINITY, f64::min);
        let high = span.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut others = others.to_vec();
        others.sort_by(f64::total_cmp);
        others.dedup();
        let along = |other: f64| {
            (0..=STEPS)
                .map(move |i| low + (high - low) * f64::from(i) / f64::from(STEPS))
                .map(move |x| (x, of(x, other)))
        };
        let named = |(hue, other): (usize, &f64)| {
            let value = format!("{other}").replace('-', "−");
            let unit = units.length().map(|unit| format!(" {unit}")).unwrap_or_default();
            Series::line(&format!("{name} = {value}{unit}"), hue, along(*other))
        };
        others.iter().enumerate().map(named).collect()
    };
    let opening = curves(normal, tangential, "Δ_t", &|n, t| law.response(n, t).traction[0]);
    let sliding = curves(tangential, normal, "Δ_n", &|t, n| law.response(n, t).traction[1]);
    let (length, stress) = (units.name("length"), units.name("stress"));
    let mut panels = vec![Panel {
        x: Axis::linear(&format!("Δ_n / {length}")),
        y: Axis::linear(&format!("*T*_n / {stress}")),
        series: opening,
        ..Panel::default()
    }];
    if law.mixed_mode().is_some() {
        panels.push(Panel {
            x: Axis::linear(&format!("Δ_t / {length}")),
            y: Axis::linear(&format!("*T*_t / {stress}")),
            series: sliding,
            ..Panel::default()
        });
    } else {
        panels[0].series.truncate(1);
        panels[0].series[0].label.clear();
    }
    Ok(Chart { share_y: false, ..Chart::new(panels) }.save(stem)?.into())
}
