//! The figures of a punch.

use std::path::{Path, PathBuf};

use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_mixed::MixedSolution;
use gfmd_plot::{Map, Maps, Mark, Series};
use ndarray::{ArrayView3, Axis as Along};

use super::Report;
use super::comparison::Reference;
use gfmd_input::failure::Failure;
use gfmd_report::figures::{about_zero, draw_pressure, named};
use gfmd_report::punch::cut;

/// Draws the maps `PREFIX-u_x`, `-u_y`, `-u_z` and `-pressure`, and `PREFIX-cut` along x through the middle, with the
/// displacement of the reference, if there is one; the maps then have it and the difference beside ours. A strip has
/// only the cut.
pub(super) fn draw(
    prefix: &Path,
    report: &Report,
    grid: &Grid,
    body: &Body,
    solution: &MixedSolution,
    reference: Option<&Reference>,
) -> Result<Vec<PathBuf>, Failure> {
    let modulus = body.contact_modulus();
    let normal = report.components.len() - 1;
    let mut files = Vec::new();
    if !grid.is_line() {
        let (size, depth) = (grid.lengths(), report.numbers.number("depth"));
        let difference = reference.map(|reference| reference.difference(solution));
        for (index, (field, name)) in solution.displacement.outer_iter().zip(&report.components).enumerate() {
            let stem = named(prefix, &format!("u_{name}"));
            let label = format!("*u*_{name} / depth");
            let values: Vec<f64> = field.iter().map(|u| u / depth).collect();
            let map = Map::new(&values, grid.points(), size, &label);
            let (Some(reference), Some(difference)) = (reference, &difference) else {
                files.extend(map.save(&stem)?);
                continue;
            };
            let component = |field: &ndarray::Array3<f64>| -> (Vec<f64>, [usize; 2]) {
                let field = field.index_axis(Along(2), index);
                (field.iter().map(|u| u / depth).collect(), field.dim().into())
            };
            let (theirs, points) = component(&reference.displacement);
            let (less, common) = component(difference);
            let ends = |(least, most): (f64, f64), u: &f64| (least.min(*u), most.max(*u));
            let (least, most) = values.iter().chain(&theirs).fold((f64::INFINITY, f64::NEG_INFINITY), ends);
            let range = (most > least).then_some([least, most]);
            let labels = ["reference", "less the reference"].map(|what| format!("{label}, {what}"));
            let maps = vec![
                Map { range, ..map },
                Map { range, ..Map::new(&theirs, points, size, &labels[0]) },
                Map { range: about_zero(&less), ..Map::new(&less, common, size, &labels[1]) },
            ];
            files.extend(Maps(maps).save(&stem)?);
        }
        let pressure = solution.traction.index_axis(ndarray::Axis(0), normal).mapv(|t| -t);
        files.extend(draw_pressure(&named(prefix, "pressure"), grid, &pressure, modulus, "length")?);
    }
    // The cut runs through the middle, where the components along y vanish by symmetry.
    let along = |field: ArrayView3<f64>, component: usize, unit: f64| {
        let (n, rows, _) = field.dim();
        let spacing = grid.lengths()[0] / n as f64;
        (0..n).map(|i| (i as f64 * spacing, field[[i, rows / 2, component]] / unit)).collect::<Vec<_>>()
    };
    let [u, t] = [&solution.displacement, &solution.traction].map(|field| field.view().permuted_axes([1, 2, 0]));
    let mut displacement = Vec::new();
    let mut traction = Vec::new();
    for component in [0, normal] {
        let name = report.components[component];
        displacement.push(Series::line(
            &format!("*u*_{name}"),
            component,
            along(u, component, report.numbers.number("depth")),
        ));
        traction.push(Series::line(&format!("*t*_{name}"), component, along(t, component, modulus)));
        if let Some(reference) = reference {
            let line = Series::line(
                &format!("*u*_{name}, reference"),
                component + 3,
                along(reference.displacement.view(), component, report.numbers.number("depth")),
            );
            displacement.push(Series { mark: Mark::Dashes, ..line });
        }
    }
    files.extend(cut([displacement, traction], "*E*\\*").save(&named(prefix, "cut"))?);
    Ok(files)
}
