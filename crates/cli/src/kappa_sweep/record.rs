//! The HDF5 file of a sweep (docs/interface.md).

use std::path::PathBuf;

use gfmd_files::{Archive, Dimension, Output, Variable};
use gfmd_fit::Axis;
use gfmd_measure::theory::{BUSH_GIBSON_THOMAS_KAPPA, PERSSON_KAPPA, persson_area};
use ndarray::Array2;

use super::config::Config;
use super::report::{Analysis, Area, Extrapolation, numbers, term};
use super::{Example, Plan};
use crate::failure::Failure;
use crate::load::{LoadRecord, SCALARS};
use crate::session::Session;
use gfmd_files::axes;

/// Writes everything; the file appears under its name when it is complete.
///
/// Wall times are left out of the variables, so that a resumed sweep ends with the same numbers as one in one piece; the
/// time of the last session is the root attribute `seconds`.
///
/// # Errors
/// A file that cannot be written.
#[expect(clippy::too_many_arguments, reason = "one caller, which has them all at hand")]
pub(super) fn write(
    output: &Output,
    config: &Config,
    plan: &Plan,
    records: &[Vec<LoadRecord>],
    analysis: &Analysis,
    example: &Example,
    session: &Session,
    seconds: f64,
) -> Result<PathBuf, Failure> {
    let mut archive = Archive::create(output, &session.provenance(config.to_toml()?))?;
    archive.attribute("/", "seconds", seconds)?;
    write_runs(&mut archive, config, plan, records)?;
    write_points(&mut archive, config, plan, analysis)?;
    write_fits(&mut archive, analysis)?;
    write_theory(&mut archive, config)?;
    write_example(&mut archive, config, plan, example)?;
    Ok(archive.finish()?)
}

/// Name, meaning and values of a dimensionless variable.
type Column = (&'static str, &'static str, Vec<f64>);

fn write_columns(
    archive: &mut Archive,
    group: &str,
    dimension: &Dimension,
    columns: Vec<Column>,
) -> Result<(), Failure> {
    for (name, long_name, values) in columns {
        let variable = Variable { dimensions: &[dimension], units: "1", long_name };
        archive.write(&format!("{group}/{name}"), &variable, &values)?;
    }
    Ok(())
}

fn write_runs(archive: &mut Archive, config: &Config, plan: &Plan, records: &[Vec<LoadRecord>]) -> Result<(), Failure> {
    let loads = &config.loads.p_star;
    let run = Dimension::index("run", plan.runs.len() * loads.len(), "one realisation of one point at one load");
    let each = |value: &dyn Fn(&super::Run, f64) -> f64| -> Vec<f64> {
        plan.runs.iter().flat_map(|run| loads.iter().map(|p| value(run, *p)).collect::<Vec<_>>()).collect()
    };
    let point = |run: &super::Run| plan.points[run.point];
    let columns: Vec<Column> = vec![
        ("hurst", "Hurst exponent", each(&|run, _| point(run).hurst)),
        ("eps_t_inv", "cell length / longest wavelength", each(&|run, _| point(run).discretisation.eps_t_inv)),
        ("eps_f_inv", "longest / shortest wavelength", each(&|run, _| point(run).discretisation.eps_f_inv)),
        ("eps_c_inv", "shortest wavelength / grid spacing", each(&|run, _| point(run).discretisation.eps_c_inv)),
        ("n", "grid points along one axis", each(&|run, _| point(run).n as f64)),
        ("point", "index of the point in /points at the first load", each(&|run, _| run.point as f64)),
        ("realisation", "number of the realisation", each(&|run, _| run.realisation as f64)),
        ("seed", "seed of the surface", each(&|run, _| run.seed as f64)),
        ("p_star_asked", "reduced pressure asked for", each(&|_, p| p)),
    ];
    write_columns(archive, "/runs", &run, columns)?;
    for scalar in SCALARS {
        let values: Vec<f64> = records.iter().flatten().map(scalar.value).collect();
        let variable = Variable { dimensions: &[&run], units: scalar.units, long_name: scalar.long_name };
        archive.write(&format!("/runs/{}", scalar.name), &variable, &values)?;
    }
    Ok(())
}

fn write_points(archive: &mut Archive, config: &Config, plan: &Plan, analysis: &Analysis) -> Result<(), Failure> {
    let measured = &analysis.measured;
    let dimension = Dimension::index("point", measured.len(), "one discretisation at one load");
    let point = |index: usize| plan.points[measured[index].point];
    let each = |value: &dyn Fn(usize) -> f64| (0..measured.len()).map(value).collect::<Vec<f64>>();
    let kappa = |way: usize, index: usize| measured[index].mean_and_error(way);
    let error = |way, index| kappa(way, index).1.unwrap_or(f64::NAN);
    let columns: Vec<Column> = vec![
        ("dim", "dimension of the body: 3, or 2 in plane strain", each(&|_| f64::from(config.surface.dim))),
        ("hurst", "Hurst exponent", each(&|i| point(i).hurst)),
        ("eps_t_inv", "cell length / longest wavelength", each(&|i| point(i).discretisation.eps_t_inv)),
        ("eps_f_inv", "longest / shortest wavelength", each(&|i| point(i).discretisation.eps_f_inv)),
        ("eps_c_inv", "shortest wavelength / grid spacing", each(&|i| point(i).discretisation.eps_c_inv)),
        ("n", "grid points along one axis", each(&|i| point(i).n as f64)),
        ("p_star", "reduced pressure p/(E* g)", each(&|i| config.loads.p_star[measured[i].load])),
        ("realisations", "number of realisations", each(&|i| measured[i].kappa[0].len() as f64)),
        ("kappa", "area fraction / p_star, mean over realisations", each(&|i| kappa(0, i).0)),
        ("kappa_sem", "standard error of the mean of kappa", each(&|i| error(0, i))),
        ("kappa_corrected", "kappa of the perimeter-corrected area", each(&|i| kappa(1, i).0)),
        ("kappa_corrected_sem", "standard error of the mean of kappa_corrected", each(&|i| error(1, i))),
    ];
    write_columns(archive, "/points", &dimension, columns)
}

fn write_fits(archive: &mut Archive, analysis: &Analysis) -> Result<(), Failure> {
    let all = &analysis.extrapolations;
    let fit = Dimension::index("fit", all.len(), "one Hurst exponent, load and way of counting area; the result first");
    let each = |value: &dyn Fn(&Extrapolation) -> f64| all.iter().map(value).collect::<Vec<f64>>();
    let mut columns: Vec<Column> = vec![
        ("hurst", "Hurst exponent", each(&|e| e.hurst)),
        ("p_star", "reduced pressure p/(E* g)", each(&|e| e.p_star)),
        ("kappa_tfc", "kappa in the thermodynamic, fractal and continuum limit", each(&|e| e.fit.kappa_tfc.value)),
        ("kappa_tfc_standard_error", "standard error of kappa_tfc", each(&|e| numbers(&e.fit.kappa_tfc)[1])),
        ("kappa_tfc_ci95_low", "lower end of the 95 % interval of kappa_tfc", each(&|e| numbers(&e.fit.kappa_tfc)[2])),
        ("kappa_tfc_ci95_high", "upper end of the 95 % interval of kappa_tfc", each(&|e| numbers(&e.fit.kappa_tfc)[3])),
        ("chi_squared", "weighted sum of squared residuals", each(&|e| e.fit.chi_squared)),
        ("degrees_of_freedom", "cells minus parameters", each(&|e| e.fit.degrees_of_freedom as f64)),
    ];
    let names: [[&'static str; 6]; 3] = [
        [
            "coefficient_t",
            "coefficient_t_ci95_low",
            "coefficient_t_ci95_high",
            "exponent_t",
            "exponent_t_ci95_low",
            "exponent_t_ci95_high",
        ],
        [
            "coefficient_f",
            "coefficient_f_ci95_low",
            "coefficient_f_ci95_high",
            "exponent_f",
            "exponent_f_ci95_low",
            "exponent_f_ci95_high",
        ],
        [
            "coefficient_c",
            "coefficient_c_ci95_low",
            "coefficient_c_ci95_high",
            "exponent_c",
            "exponent_c_ci95_low",
            "exponent_c_ci95_high",
        ],
    ];
    let long_name = "kappa = kappa_tfc + sum over axes of coefficient * eps^exponent; NaN: no such term or interval";
    for (axis, names) in Axis::ALL.into_iter().zip(names) {
        let part = |e: &Extrapolation, which: usize| {
            let Some((coefficient, exponent)) = term(&e.fit, axis) else { return f64::NAN };
            let estimate = if which < 3 { coefficient } else { exponent };
            numbers(estimate)[[0, 2, 3][which % 3]]
        };
        for (which, name) in names.into_iter().enumerate() {
            columns.push((name, long_name, each(&|e| part(e, which))));
        }
    }
    write_columns(archive, "/fit", &fit, columns)?;
    let areas: Vec<&str> = all.iter().map(|e| if e.area == Area::Raw { "raw" } else { "corrected" }).collect();
    let variable = Variable { dimensions: &[&fit], units: "1", long_name: "how contact area is counted" };
    archive.write_text("/fit/area", &variable, &areas)?;
    let sources: Vec<String> = all.iter().map(|e| e.fit.uncertainty.to_string()).collect();
    let variable = Variable { dimensions: &[&fit], units: "1", long_name: "where the intervals come from" };
    archive.write_text("/fit/uncertainty", &variable, &sources)?;
    let warnings: Vec<String> =
        all.iter().map(|e| e.fit.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")).collect();
    let variable = Variable { dimensions: &[&fit], units: "1", long_name: "what a reader of the numbers has to know" };
    archive.write_text("/fit/warnings", &variable, &warnings)?;

    let samples = |e: &Extrapolation| e.fit.bootstrap.as_ref().map_or(0, |b| b.samples.len());
    let count = all.iter().map(samples).max().unwrap_or(0);
    if count > 0 {
        let resample = Dimension::index("resample", count, "bootstrap resample of the realisations");
        let values: Vec<f64> = (all.iter())
            .flat_map(|e| {
                let samples = e.fit.bootstrap.as_ref().map_or(&[][..], |b| &b.samples);
                (0..count).map(|i| samples.get(i).map_or(f64::NAN, |s| s.kappa_tfc)).collect::<Vec<_>>()
            })
            .collect();
        let long_name = "kappa_tfc refitted to resampled realisations, before stretching for few realisations";
        let variable = Variable { dimensions: &[&fit, &resample], units: "1", long_name };
        archive.write("/fit/kappa_tfc_resampled", &variable, &values)?;
    }
    Ok(())
}

fn write_theory(archive: &mut Archive, config: &Config) -> Result<(), Failure> {
    let scalar = |long_name| Variable { dimensions: &[], units: "1", long_name };
    let persson = scalar("kappa of Persson's theory at vanishing load, sqrt(8/pi)");
    archive.write("/theory/persson_kappa", &persson, &[PERSSON_KAPPA])?;
    let bush = scalar("kappa of Bush, Gibson and Thomas at vanishing load, sqrt(2 pi)");
    archive.write("/theory/bush_gibson_thomas_kappa", &bush, &[BUSH_GIBSON_THOMAS_KAPPA])?;
    let loads = &config.loads.p_star;
    let p_star = Dimension::values("p_star", loads.clone(), "1", "reduced pressure p/(E* g)");
    let area: Vec<f64> = loads.iter().map(|p| persson_area(*p)).collect();
    let long_name = "contact area fraction of Persson's theory, erf(sqrt(2) p_star)";
    archive.write("/theory/persson_area", &Variable { dimensions: &[&p_star], units: "1", long_name }, &area)?;
    Ok(())
}

fn write_example(archive: &mut Archive, config: &Config, plan: &Plan, example: &Example) -> Result<(), Failure> {
    let grid = plan.grid(&example.point)?;
    let [x, y] = axes(&grid, "length");
    let dimensions = [&x, &y];
    let field = |units, long_name| Variable { dimensions: &dimensions, units, long_name };
    let values = |field: &Array2<f64>| field.iter().copied().collect::<Vec<f64>>();
    let height = field("length", "height of the rigid surface, peaks towards the elastic body");
    archive.write("/example/height", &height, &values(&example.heights))?;
    let pressure = field("stress", "contact pressure, compression positive");
    archive.write("/example/pressure", &pressure, &values(&example.pressure))?;
    archive.attribute("/example", "p_star", config.fit.p_star)?;
    archive.attribute("/example", "seed", example.seed as i64)?;
    archive.attribute("/example", "hurst", example.point.hurst)?;
    Ok(())
}
