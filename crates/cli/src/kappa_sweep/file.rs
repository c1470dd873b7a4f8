//! The HDF5 file of a sweep (docs/interface.md).

use std::path::PathBuf;

use gfmd_files::{Archive, Dimension, Output, Provenance, Variable, axes};
use gfmd_fit::{Axis, Datum, Estimate, Parameters, Term};
use gfmd_measure::theory::{BUSH_GIBSON_THOMAS_KAPPA, PERSSON_KAPPA, persson_area};
use gfmd_problem::Facts;
use gfmd_record::Record;
use gfmd_sweep::{
    Analysis, Area, Config, Control, Example, Extrapolation, Form, Key, Plan, Point, Pressed, Run, Study,
};
use ndarray::Array2;

use super::protocol;
use gfmd_check::sweep::{columns, record};
use gfmd_input::failure::Failure;

/// Writes a study; the file appears under its name when it is complete.
///
/// The variables have no wall times, so that a resumed sweep has the same variables as an uninterrupted one. The time
/// of the last session is the root attribute `seconds`.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(output: &Output, study: &Study, provenance: &Provenance, seconds: f64) -> Result<PathBuf, Failure> {
    let mut archive = Archive::create(output, provenance)?;
    archive.attribute("/", "seconds", seconds)?;
    write_runs(&mut archive, &study.plan, &study.runs)?;
    write_points(&mut archive, &study.plan, &study.analysis)?;
    write_fits(&mut archive, &study.analysis)?;
    protocol::write(&mut archive, &study.analysis.protocols)?;
    write_theory(&mut archive, &study.plan.config)?;
    write_example(&mut archive, &study.plan.config, &study.example)?;
    Ok(archive.finish()?)
}

/// A dimensionless number of each `T`: its name, its meaning, its value.
type Column<'a, T> = (&'a str, &'a str, &'a dyn Fn(&T) -> f64);

fn write_columns<T>(
    archive: &mut Archive,
    group: &str,
    dimension: &Dimension,
    rows: &[T],
    columns: &[Column<T>],
) -> Result<(), Failure> {
    for (name, long_name, value) in columns {
        let variable = Variable { dimensions: &[dimension], units: "1", long_name };
        let values: Vec<f64> = rows.iter().map(value).collect();
        archive.write(&format!("{group}/{name}"), &variable, &values)?;
    }
    Ok(())
}

/// Writes the columns that identify the surface of each row.
fn write_surfaces(archive: &mut Archive, group: &str, dimension: &Dimension, points: &[&Point]) -> Result<(), Failure> {
    let columns: [Column<&Point>; 5] = [
        ("hurst", "Hurst exponent", &|point| point.hurst),
        ("eps_t_inv", "cell length / longest wavelength", &|point| point.discretisation.eps_t_inv),
        ("eps_f_inv", "longest / shortest wavelength", &|point| point.discretisation.eps_f_inv),
        ("eps_c_inv", "shortest wavelength / grid spacing", &|point| point.discretisation.eps_c_inv),
        ("n", "grid points along one axis", &|point| point.n() as f64),
    ];
    write_columns(archive, group, dimension, points, &columns)
}

fn write_runs(archive: &mut Archive, plan: &Plan, runs: &[Vec<Pressed>]) -> Result<(), Failure> {
    let loads = &plan.config.loads.p_star;
    let run = Dimension::index("run", plan.runs.len() * loads.len(), "one realisation of one point at one load");
    // Between the first and the last load no p* is asked for if the approach is prescribed.
    let asked = |load: usize| match plan.config.loads.control {
        Control::Approach if load > 0 && load + 1 < loads.len() => f64::NAN,
        _ => loads[load],
    };
    let rows: Vec<(&Run, f64)> =
        plan.runs.iter().flat_map(|run| (0..loads.len()).map(move |load| (run, asked(load)))).collect();
    let points: Vec<&Point> = rows.iter().map(|(run, _)| &plan.points[run.point]).collect();
    write_surfaces(archive, "/runs", &run, &points)?;
    let places: [Column<(&Run, f64)>; 3] = [
        ("point", "index of the point in /points at the first load", &|(run, _)| run.point as f64),
        ("realisation", "number of the realisation", &|(run, _)| run.realisation as f64),
        ("p_star_asked", "prescribed reduced pressure", &|(_, p_star)| *p_star),
    ];
    write_columns(archive, "/runs", &run, &rows, &places)?;
    let seed = Variable { dimensions: &[&run], units: "1", long_name: "random seed of the surface" };
    let seeds: Vec<i64> = rows.iter().map(|(run, _)| exact(run.seed)).collect();
    archive.write("/runs/seed", &seed, &seeds)?;
    let records: Vec<Record> = runs.iter().flatten().map(record).collect();
    let facts = Facts::default();
    for column in columns() {
        let values: Vec<f64> = records.iter().map(|record| record.number(column.name)).collect();
        let variable = Variable { dimensions: &[&run], units: column.unit, long_name: column.meaning(&facts) };
        archive.write(&format!("/runs/{}", column.name), &variable, &values)?;
    }
    Ok(())
}

/// A seed as a file stores it. Every seed of a plan fits an `i64`.
fn exact(seed: u64) -> i64 {
    seed as i64
}

fn write_points(archive: &mut Archive, plan: &Plan, analysis: &Analysis) -> Result<(), Failure> {
    let rows: Vec<Key> = analysis.data.keys().copied().filter(|key| key.area == Area::Raw).collect();
    let point = Dimension::index("point", rows.len(), "one discretisation at one load");
    let points: Vec<&Point> = rows.iter().map(|row| &plan.points[row.point]).collect();
    write_surfaces(archive, "/points", &point, &points)?;
    let datum = |row: &Key, area: Area| analysis.data.get(&Key { area, ..*row });
    let kappa = |row: &Key, area: Area| datum(row, area).map_or(f64::NAN, Datum::mean);
    let error = |row: &Key, area: Area| datum(row, area).and_then(Datum::standard_error).unwrap_or(f64::NAN);
    let edge = |row: &Key| datum(row, Area::Raw).map_or(f64::NAN, Datum::mean_edge);
    let composed = |row: &Key| analysis.composed(row.point, row.load, plan);
    let kappa_composed = |row: &Key| composed(row).map_or(f64::NAN, |datum| datum.mean());
    let composed_error = |row: &Key| composed(row).and_then(|datum| datum.standard_error()).unwrap_or(f64::NAN);
    let of_composed = "kappa less edge, with the long waves composed; NaN if they are not";
    let columns: [Column<Key>; 10] = [
        ("dim", "dimension of the body: 3, or 2 in plane strain", &|_| f64::from(plan.config.surface.dim)),
        ("p_star", "reduced pressure p/(E* g)", &|row| plan.config.loads.p_star[row.load]),
        ("realisations", "number of realisations", &|row| plan.runs_of(row.point).len() as f64),
        ("kappa", "area fraction / p_star, mean over realisations", &|row| kappa(row, Area::Raw)),
        ("kappa_sem", "standard error of the mean of kappa", &|row| error(row, Area::Raw)),
        ("kappa_corrected", "kappa of the perimeter-corrected area", &|row| kappa(row, Area::Corrected)),
        ("kappa_corrected_sem", "standard error of the mean of kappa_corrected", &|row| error(row, Area::Corrected)),
        ("edge", "part of kappa added by the grid, estimated from each contact, mean over realisations", &edge),
        ("kappa_composed", of_composed, &kappa_composed),
        ("kappa_composed_sem", "standard error of the mean of kappa_composed", &composed_error),
    ];
    write_columns(archive, "/points", &point, &rows, &columns)
}

/// A part of `T`, with its word in the names of variables.
type Named<T, V> = (&'static str, fn(&T) -> V);

/// The ends of a 95 % interval, NaN if there is none.
fn ends(estimate: &Estimate) -> [f64; 2] {
    estimate.ci95.unwrap_or([f64::NAN; 2])
}

fn write_fits(archive: &mut Archive, analysis: &Analysis) -> Result<(), Failure> {
    let all = &analysis.extrapolations;
    let fit = Dimension::index("fit", all.len(), "one Hurst exponent, load and area count; the result first");
    let limit = |e: &Extrapolation| e.fit.kappa_tfc;
    let total = |e: &Extrapolation| e.total_ci95().unwrap_or([f64::NAN; 2]);
    let columns: [Column<Extrapolation>; 12] = [
        ("hurst", "Hurst exponent", &|e| e.hurst),
        ("p_star", "reduced pressure p/(E* g)", &|e| e.p_star),
        ("kappa_tfc", "kappa in the thermodynamic, fractal and continuum limit", &|e| limit(e).value),
        ("kappa_tfc_standard_error", "standard error of kappa_tfc", &|e| limit(e).standard_error.unwrap_or(f64::NAN)),
        ("kappa_tfc_ci95_low", "lower end of the 95 % interval of kappa_tfc", &|e| ends(&limit(e))[0]),
        ("kappa_tfc_ci95_high", "upper end of the 95 % interval of kappa_tfc", &|e| ends(&limit(e))[1]),
        ("kappa_tfc_systematic", "error of the fit form: exponent, levels and closure in quadrature", &|e| {
            e.systematic()
        }),
        ("kappa_tfc_total_ci95_low", "lower end of kappa_tfc with the systematic error", &|e| total(e)[0]),
        ("kappa_tfc_total_ci95_high", "upper end of kappa_tfc with the systematic error", &|e| total(e)[1]),
        ("composed", "1 if the long waves are composed, 0 if not", &|e| f64::from(u8::from(e.composed))),
        ("chi_squared", "weighted sum of squared residuals", &|e| e.fit.chi_squared),
        ("degrees_of_freedom", "points minus parameters", &|e| e.fit.degrees_of_freedom as f64),
    ];
    write_columns(archive, "/fit", &fit, all, &columns)?;
    let long_name = "kappa = kappa_tfc + sum over axes of coefficient * eps^exponent (t: times eps_f^exponent_f if \
                     there is a term f); NaN: no such term or interval";
    let parts: [Named<Term, Estimate>; 2] =
        [("coefficient", |term| term.coefficient), ("exponent", |term| term.exponent)];
    let numbers: [Named<Estimate, f64>; 3] =
        [("", |e| e.value), ("_ci95_low", |e| ends(e)[0]), ("_ci95_high", |e| ends(e)[1])];
    for axis in Axis::ALL {
        for (part, estimate) in parts {
            for (suffix, number) in numbers {
                let name = format!("{part}_{axis}{suffix}");
                let value = |e: &Extrapolation| e.fit.term(axis).map_or(f64::NAN, |term| number(&estimate(term)));
                write_columns(archive, "/fit", &fit, all, &[(&name, long_name, &value)])?;
            }
        }
    }
    for (suffix, number) in numbers {
        let factor = |e: &Extrapolation| e.fit.edge.map_or(f64::NAN, |edge| number(&edge.factor));
        let coarse =
            |e: &Extrapolation| e.fit.edge.and_then(|edge| edge.coarse).map_or(f64::NAN, |coarse| number(&coarse));
        let columns: [Column<Extrapolation>; 2] = [
            (&format!("edge_factor{suffix}"), "factor of /points/edge in the kappa of counted points", &factor),
            (&format!("edge_coarse{suffix}"), "factor of (4 eps_c)^2 beside it", &coarse),
        ];
        write_columns(archive, "/fit", &fit, all, &columns)?;
    }
    let share = |e: &Extrapolation| e.fit.edge.and_then(|edge| edge.share).unwrap_or(f64::NAN);
    let long_name = "part of kappa_tfc_standard_error due to the errors of the edge factors";
    write_columns(archive, "/fit", &fit, all, &[("edge_share", long_name, &share)])?;
    let forms: Vec<Form> = all.iter().flat_map(|e| &e.alternatives).map(|other| other.form).collect();
    let forms: std::collections::BTreeSet<Form> = forms.into_iter().collect();
    for form in forms {
        let of =
            |e: &Extrapolation| e.alternatives.iter().find(|other| other.form == form).map(|other| other.kappa_tfc);
        let name = format!("kappa_tfc_{}", form.name().replace('-', "_"));
        let long_name = format!("kappa_tfc of another form: {}", form.meaning());
        write_columns(archive, "/fit", &fit, all, &[(&name, &long_name, &|e| of(e).unwrap_or(f64::NAN))])?;
    }
    let texts = |of: fn(&Extrapolation) -> String| all.iter().map(of).collect::<Vec<_>>();
    let warnings = |e: &Extrapolation| e.fit.warnings.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    for (name, long_name, texts) in [
        ("area", "area count: how points in contact give an area", texts(|e| e.area.name().into())),
        ("uncertainty", "source of the intervals", texts(|e| e.fit.uncertainty.to_string())),
        ("warnings", "remarks on the numbers", texts(warnings)),
    ] {
        let variable = Variable { dimensions: &[&fit], units: "1", long_name };
        archive.write_text(&format!("/fit/{name}"), &variable, &texts)?;
    }
    write_resamples(archive, &fit, all)
}

fn write_resamples(archive: &mut Archive, fit: &Dimension, all: &[Extrapolation]) -> Result<(), Failure> {
    fn samples(e: &Extrapolation) -> &[Parameters] {
        e.fit.bootstrap.as_ref().map_or(&[], |bootstrap| &bootstrap.samples)
    }
    let count = all.iter().map(|e| samples(e).len()).max().unwrap_or(0);
    if count == 0 {
        return Ok(());
    }
    let resample = Dimension::index("resample", count, "resample of the means from their errors");
    let row = |e: &Extrapolation| {
        let mut row: Vec<f64> = samples(e).iter().map(|sample| sample.kappa_tfc).collect();
        row.resize(count, f64::NAN);
        row
    };
    let values: Vec<f64> = all.iter().flat_map(row).collect();
    let long_name = "kappa_tfc refitted to resampled means, before stretching for few realisations";
    let variable = Variable { dimensions: &[fit, &resample], units: "1", long_name };
    Ok(archive.write("/fit/kappa_tfc_resampled", &variable, &values)?)
}

fn write_theory(archive: &mut Archive, config: &Config) -> Result<(), Failure> {
    let scalar = |long_name| Variable { dimensions: &[], units: "1", long_name };
    let persson = scalar("kappa at vanishing load in Persson's theory, sqrt(8/pi)");
    archive.write("/theory/persson_kappa", &persson, &[PERSSON_KAPPA])?;
    let bush = scalar("kappa at vanishing load by Bush, Gibson and Thomas, sqrt(2 pi)");
    archive.write("/theory/bush_gibson_thomas_kappa", &bush, &[BUSH_GIBSON_THOMAS_KAPPA])?;
    let loads = &config.loads.p_star;
    let p_star = Dimension::values("p_star", loads.clone(), "1", "reduced pressure p/(E* g)");
    let area: Vec<f64> = loads.iter().map(|p| persson_area(*p)).collect();
    let long_name = "contact area fraction from Persson's theory, erf(sqrt(2) p_star)";
    archive.write("/theory/persson_area", &Variable { dimensions: &[&p_star], units: "1", long_name }, &area)?;
    Ok(())
}

fn write_example(archive: &mut Archive, config: &Config, example: &Example) -> Result<(), Failure> {
    let [x, y] = axes(&example.point.grid, "length");
    let dimensions = [&x, &y];
    let field = |units, long_name| Variable { dimensions: &dimensions, units, long_name };
    let values = |field: &Array2<f64>| field.iter().copied().collect::<Vec<f64>>();
    let height = field("length", "height of the rigid surface, peaks towards the elastic body");
    archive.write("/example/height", &height, &values(&example.heights))?;
    let pressure = field("stress", "contact pressure, compression positive");
    archive.write("/example/pressure", &pressure, &values(&example.pressure))?;
    archive.attribute("/example", "p_star", config.fit.p_star)?;
    archive.attribute("/example", "seed", exact(example.seed))?;
    archive.attribute("/example", "hurst", example.point.hurst)?;
    Ok(())
}
