//! `punch` from end to end: flags in, JSON, HDF5 and figures out.

mod common;

use approx::assert_relative_eq;
use common::{gfmd, json};
use gfmd_files::Reader;
use ndarray::Array3;
use serde_json::Value;

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {value}"))
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

#[test]
fn the_case_of_the_source_in_json_and_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let report = json(folder.path(), &words("punch --tol 1e-10 --json --out p.h5 --plots p"));
    assert_eq!((&report["n"], &report["contact_nodes"]), (&serde_json::json!([128, 128]), &961.into()));
    // An independent solution of the same discrete problem.
    assert_relative_eq!(number(&report, "mean_pressure"), 0.099_962_220_138_224_98, max_relative = 1e-9);
    assert_relative_eq!(number(&report, "elastic_energy"), 0.000_249_905_550_345_564_9, max_relative = 1e-9);
    assert!(number(&report, "residual") <= 1e-10 && report["converged"] == true);
    assert!(number(&report, "transform_pairs") < 3.0 * 40.0 && number(&report, "iterations") < 20.0);
    assert_relative_eq!(number(&report, "effective_width"), (31.0 - 1.0 / 3.0) * 1.27 / 128.0, max_relative = 1e-15);

    let file = Reader::open(folder.path().join("p.h5")).unwrap();
    let field = |name: &str| {
        assert_eq!(file.shape(name).unwrap(), [128, 128, 3]);
        Array3::from_shape_vec((128, 128, 3), file.values::<f64>(name).unwrap()).unwrap()
    };
    let [displacement, traction] = ["/fields/displacement", "/fields/traction"].map(field);
    assert_relative_eq!(displacement[[64, 64, 2]], -0.005, max_relative = 1e-9);
    assert!(traction[[64, 64, 2]] < 0.0 && traction[[48, 64, 2]] == 0.0 && traction[[49, 64, 2]] < 0.0);
    let mean: f64 = traction.slice(ndarray::s![.., .., 2]).mean().unwrap();
    assert_relative_eq!(-mean, number(&report, "mean_pressure"), max_relative = 1e-12);
    assert_eq!(file.texts("/fields/component").unwrap(), ["x", "y", "z"]);
    assert_eq!(file.values::<u64>("/fields/under_punch").unwrap().iter().filter(|under| **under == 1).count(), 961);
    for name in ["mean_pressure", "max_pressure", "residual", "transform_pairs", "effective_width"] {
        assert_eq!(file.values::<f64>(&format!("/punch/{name}")).unwrap(), [number(&report, name)]);
    }
    assert_eq!(file.text("/fields/traction", "units").unwrap(), "stress");
    let config: toml::Table = file.text("/", "config").unwrap().parse().unwrap();
    assert_eq!(config["height"].as_float(), Some(1.27));
    assert_eq!((config["nodes"].as_str(), config["contact"].as_str()), (Some("strict"), Some("sticking")));

    let plots = report["plots"].as_array().unwrap();
    assert_eq!(plots.len(), 10);
    assert!(plots.iter().all(|plot| folder.path().join(plot.as_str().unwrap()).is_file()));
}

#[test]
fn a_run_compares_with_itself_and_with_coarser_and_finer_ones() {
    let folder = tempfile::tempdir().unwrap();
    for dim in [2, 3] {
        let run = |flags: &str| {
            let flags = format!("punch --dim {dim} --nodes inclusive --json {flags}");
            json(folder.path(), &words(&flags))
        };
        let common = |n: usize| if dim == 2 { serde_json::json!([n, 1]) } else { serde_json::json!([n, n]) };
        run("--n 48 --out a.h5");
        let same = run("--n 48 --compare a.h5:/fields/displacement");
        assert!(numbers(&same["error"]).iter().all(|error| *error == 0.0) && same["compared_points"] == common(48));
        let coarser = run("--n 24 --compare a.h5 --out b.h5");
        let finer = run("--n 48 --compare b.h5");
        assert_eq!((&coarser["compared_points"], &finer["compared_points"]), (&common(24), &common(24)));
        assert_eq!(coarser["error"], finer["error"]);
        assert!(numbers(&coarser["error"]).iter().all(|error| (1e-4..0.05).contains(error)));
        assert_eq!(numbers(&coarser["error"]).len(), dim);
    }
}

#[test]
fn the_error_is_that_of_the_interface() {
    let folder = tempfile::tempdir().unwrap();
    let reference = Array3::from_shape_fn((16, 16, 3), |(_, _, component)| if component == 2 { 0.1 } else { 0.0 });
    ndarray_npy::write_npy(folder.path().join("r.npy"), &reference).unwrap();
    let report = json(folder.path(), &words("punch --n 16 --depth 0.01 --compare r.npy --out p.h5 --json"));
    let stored: Vec<f64> = Reader::open(folder.path().join("p.h5")).unwrap().values("/fields/displacement").unwrap();
    for (component, error) in numbers(&report["error"]).into_iter().enumerate() {
        let shift = if component == 2 { 0.1 } else { 0.0 };
        let squares: f64 = stored.iter().skip(component).step_by(3).map(|u| (shift - u).powi(2)).sum();
        assert_relative_eq!(error, (squares / 256.0).sqrt() / 0.01, max_relative = 1e-12);
    }
}

#[test]
fn solvers_agree_on_a_half_space_and_on_rubber() {
    let folder = tempfile::tempdir().unwrap();
    for body in ["--height inf --contact frictionless", "--height 0.3 --poisson 0.5", "--dim 2 --contact frictionless"]
    {
        let pressure = |solver: &str| {
            let flags = format!("punch --n 24 --tol 1e-10 --json {body} --solver {solver}");
            number(&json(folder.path(), &words(&flags)), "mean_pressure")
        };
        let expected = pressure("auto");
        for solver in ["cg", "verlet", "verlet-critical", "fire"] {
            assert_relative_eq!(pressure(solver), expected, max_relative = 1e-8);
        }
    }
}

#[test]
fn refinement_extrapolates_to_the_closed_form() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "punch --dim 2 --height inf --contact frictionless --nodes inclusive --length 1 --young 1 --poisson 0 \
                 --n 64 --refine 4 --tol 1e-11 --json";
    let report = json(folder.path(), &words(flags));
    let refinement = &report["refinement"];
    assert_eq!(refinement["n"], serde_json::json!([64, 128, 256, 512]));
    assert_eq!(numbers(&refinement["mean_pressure"])[0], number(&report, "mean_pressure"));
    assert!((number(refinement, "order") - 1.0).abs() < 0.02);
    // Depth = -(2 p L / (pi E*)) ln sin(pi f / 2) (theory.md, section 10).
    let per_pressure = -2.0 / std::f64::consts::PI * (std::f64::consts::PI / 8.0).sin().ln();
    assert_relative_eq!(number(refinement, "extrapolated"), 0.005 / per_pressure, max_relative = 1e-6);
}

#[test]
fn a_deep_punch_is_pressed_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let output = gfmd(folder.path(), &words("punch --n 16 --depth 0.1 --json"));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && text.contains("--depth") && text.contains("width of the punch"), "{text}");
    let output = gfmd(folder.path(), &words("punch --n 16 --depth 0.01 --height 0.05 --json"));
    assert!(String::from_utf8_lossy(&output.stderr).contains("height of the slab"));
    let output = gfmd(folder.path(), &words("punch --n 16 --json"));
    assert!(output.status.success() && output.stderr.is_empty());
}

#[test]
fn not_converged_is_an_error_that_keeps_what_was_reached() {
    let folder = tempfile::tempdir().unwrap();
    for solver in ["cg", "verlet"] {
        let flags = format!("punch --n 32 --solver {solver} --max-iter 2 --json --out p.h5");
        let output = gfmd(folder.path(), &words(&flags));
        assert_eq!(output.status.code(), Some(1));
        let text = String::from_utf8_lossy(&output.stderr);
        assert!(text.contains("did not converge to 1e-8 in 2 iterations") && text.contains("p.h5"), "{text}");
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        assert!(report["converged"] == false && number(&report, "residual") > 1e-8);
        let file = Reader::open(folder.path().join("p.h5")).unwrap();
        assert_eq!(file.values::<f64>("/punch/converged").unwrap(), [0.0]);
    }
}
