//! `punch` from end to end: flags in, JSON, HDF5 and figures out.

use crate::common::{gfmd, json};
use approx::assert_relative_eq;
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
    let report = json(folder.path(), &words("punch --tolerance 1e-10 --json --out p.h5 --plots p"));
    assert_eq!((&report["n"], &report["contact_nodes"]), (&serde_json::json!([128, 128]), &961.into()));
    // Independent solution of the same discrete problem.
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
    assert!(traction[[64, 64, 2]] < 0.0);
    assert!(traction[[48, 64, 2]] == 0.0);
    assert!(traction[[49, 64, 2]] < 0.0);
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
            let flags = format!("punch --n 24 --tolerance 1e-10 --json {body} --solver {solver}");
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
    let flags = "punch --dim 2 --height inf --contact frictionless --nodes inclusive --size 1 --young 1 --poisson 0 \
                 --n 64 --refine 4 --tolerance 1e-11 --json";
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
fn punches_of_any_shape_with_shift_and_traction_are_those_of_dense_solutions() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/reference/masked_punches.json");
    let reference: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let under: Vec<u8> = numbers(&reference["under"]).iter().map(|x| *x as u8).collect();
    let mask = ndarray::Array2::from_shape_vec((15, 15), under).unwrap();
    ndarray_npy::write_npy(folder.path().join("mask.npy"), &mask).unwrap();
    let given = Array3::from_shape_vec((15, 15, 3), numbers(&reference["given"])).unwrap();
    ndarray_npy::write_npy(folder.path().join("given.npy"), &given).unwrap();
    for case in reference["cases"].as_array().unwrap() {
        let body = match case["body"].as_str().unwrap() {
            "slab" => "--young 1 --poisson 0.3 --height 0.4",
            _ => "--young 3 --poisson 0.2 --height 0.1 --layer 1,0.4,0.3",
        };
        let how = if case["sticking"] == true { "--shift 0.004,-0.007" } else { "--contact frictionless" };
        let flags = format!(
            "punch --size 1 {body} --depth 0.01 --mask mask.npy --traction given.npy {how} --tolerance 1e-12 --out \
             m.h5 --json"
        );
        let report = json(folder.path(), &words(&flags));
        assert_eq!(
            (&report["n"], &report["contact_nodes"]),
            (&serde_json::json!([15, 15]), &under_count(&mask).into())
        );
        assert!(report["punch_width"].is_null() && report["mask"] == "mask.npy");
        let file = Reader::open(folder.path().join("m.h5")).unwrap();
        for name in ["traction", "displacement"] {
            let found: Vec<f64> = file.values(&format!("/fields/{name}")).unwrap();
            let expected = numbers(&case[name]);
            let largest = expected.iter().fold(0.0, |largest: f64, x| largest.max(x.abs()));
            let error = found.iter().zip(&expected).fold(0.0, |worst: f64, (a, b)| worst.max((a - b).abs()));
            assert!(error < 1e-9 * largest, "{name} {error:e}");
        }
        std::fs::rename(folder.path().join("mask.npy"), folder.path().join("gone.npy")).unwrap();
        // The file has everything that its check needs.
        for check in ["check m.h5 --json", "check m.h5 --rerun --json"] {
            assert_eq!(json(folder.path(), &words(check))["differing"], 0, "{check}");
        }
        std::fs::rename(folder.path().join("gone.npy"), folder.path().join("mask.npy")).unwrap();
    }
}

fn under_count(mask: &ndarray::Array2<u8>) -> usize {
    mask.iter().filter(|under| **under != 0).count()
}

#[test]
fn a_strip_that_is_shifted_on_rubber_bears_the_shear_that_is_its_pressure_when_pressed() {
    // G_xx = G_zz and G_xz = 0 on an incompressible half-space in plane strain, so that each load is the other one
    // turned.
    let folder = tempfile::tempdir().unwrap();
    let strip = "punch --dim 2 --height inf --poisson 0.5 --n 64 --tolerance 1e-11 --json --depth 0.003";
    let pressed = json(folder.path(), &words(strip));
    let shifted = json(folder.path(), &words(&format!("{strip} --shift 0.006")));
    assert_relative_eq!(number(&shifted, "mean_pressure"), number(&pressed, "mean_pressure"), max_relative = 1e-9);
    let shear = numbers(&shifted["mean_traction"])[0];
    assert_relative_eq!(shear, 2.0 * number(&pressed, "mean_pressure"), max_relative = 1e-9);
    // A mask of the punch gives the same punch.
    let mask = ndarray::Array1::from_shape_fn(64, |i| f64::from(u8::from(24 < i && i < 40)));
    ndarray_npy::write_npy(folder.path().join("strip.npy"), &mask).unwrap();
    let masked = json(folder.path(), &words(&format!("{} --mask strip.npy", strip.replace("--n 64", ""))));
    assert_eq!(masked["mean_pressure"], pressed["mean_pressure"]);
}

#[test]
fn all_dampings_find_the_state_and_the_history_has_every_step() {
    let folder = tempfile::tempdir().unwrap();
    let run = |flags: &str| json(folder.path(), &words(&format!("punch --n 24 --tolerance 1e-9 --json {flags}")));
    let expected = number(&run(""), "mean_pressure");
    let of_source = run("--solver verlet-critical");
    for flags in [
        "--solver verlet-critical --dt 0.25 --damping 1",
        "--solver verlet-critical --dt 0.5 --damping 2",
        "--solver verlet-critical --dt 0.4 --damping 1,1,0.8",
        "--solver verlet-modes",
        "--solver verlet-modes --dt 0.5",
    ] {
        let report = run(flags);
        assert_relative_eq!(number(&report, "mean_pressure"), expected, max_relative = 1e-8);
        if flags.contains("--damping 1 ") || flags.ends_with("0.25 --damping 1") {
            assert_eq!(report["iterations"], of_source["iterations"]);
        }
    }
    let history = "--history --history-mode 1,0,x --history-mode 0,0,z --history-point 0.635,0.635,z";
    let report = run(&format!("--solver verlet-critical {history} --out h.h5"));
    let steps = number(&report, "iterations") as usize;
    let trace = &report["history"];
    assert_eq!(numbers(&trace["iteration"]), (0..=steps).map(|step| step as f64).collect::<Vec<_>>());
    let energy = numbers(&trace["energy"]);
    assert_relative_eq!(energy[steps], number(&report, "elastic_energy"), max_relative = 1e-8);
    assert!(energy[0] > energy[steps]);
    assert!(numbers(&trace["points"][0]["u"]).iter().all(|u| *u == -0.005));
    let [wave, mean] = [0, 1].map(|mode| trace["modes"][mode].clone());
    // u_x is odd about the middle, at half a turn: the amplitude of its first wave is imaginary.
    let [re, im] = ["re", "im"].map(|part| numbers(&wave[part])[steps]);
    assert!(im.abs() > 1e-5 && re.abs() < 1e-6 * im.abs(), "{re} {im}");
    let file = Reader::open(folder.path().join("h.h5")).unwrap();
    assert_eq!(file.shape("/history/mode_re").unwrap(), [2, steps + 1]);
    assert_eq!(file.texts("/history/mode").unwrap(), ["1,0,x", "0,0,z"]);
    let displacement: Vec<f64> = file.values("/fields/displacement").unwrap();
    let u: f64 = displacement.iter().skip(2).step_by(3).sum::<f64>() / 576.0;
    assert_relative_eq!(numbers(&mean["re"])[steps], u, max_relative = 1e-6);
    assert_eq!(json(folder.path(), &words("check h.h5 --rerun --json"))["differing"], 0);
    // Conjugate gradients move no displacement.
    let report = run("--history");
    assert!(report["history"]["energy"][0].is_null() && numbers(&report["history"]["residual"])[0] == 1.0);
}

#[test]
fn unusable_masks_tractions_shifts_and_dampings_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, array: ndarray::ArrayD<f64>| {
        ndarray_npy::write_npy(folder.path().join(name), &array).unwrap();
    };
    write("none.npy", ndarray::ArrayD::zeros(vec![8, 8]));
    write("flat.npy", ndarray::ArrayD::ones(vec![8, 6]));
    write("t.npy", ndarray::ArrayD::ones(vec![8, 8]));
    for (flags, named) in [
        ("--mask none.npy", ["--mask", "no point"]),
        ("--mask flat.npy", ["--mask", "[8, 6]"]),
        ("--mask t.npy --n 16", ["--n", "8, as --mask has"]),
        ("--mask t.npy --punch-fraction 0.5", ["--mask", "--punch-fraction"]),
        ("--n 8 --traction t.npy", ["--traction", "[8, 8, 3]"]),
        ("--n 8 --shift 0.1 --contact frictionless", ["--shift", "frictionless"]),
        ("--n 8 --dim 2 --shift 0.1,0.1", ["--shift", "--dim 2"]),
        ("--n 8 --shift nan,0", ["--shift", "from -1e140 to 1e140"]),
        ("--n 8 --dt 0.5", ["--dt", "verlet-critical"]),
        ("--n 8 --solver verlet-modes --damping 2", ["--damping", "verlet-critical"]),
        ("--n 8 --solver verlet-critical --damping 1,1", ["--damping", "three"]),
        ("--n 8 --solver verlet-critical --damping 1e3", ["--damping", "divided by the critical damping is 1e3"]),
        ("--n 8 --solver verlet-critical --dt 1", ["--dt", "below 1"]),
        ("--n 8 --solver verlet-modes --height inf", ["verlet-modes", "slab"]),
        ("--n 8 --solver verlet-critical --damping 1,1,1 --height inf", ["--damping", "slab"]),
        ("--n 8 --history-mode 1,0,x", ["--history", "required"]),
        ("--n 8 --dim 2 --history --history-point 0,0,y", ["--history-point", "x, z"]),
    ] {
        let output = gfmd(folder.path(), &words(&format!("punch {flags}")));
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!((output.status.code(), text.trim_end().lines().count()), (Some(2), 1), "{flags}: {text}");
        assert!(named.iter().all(|word| text.contains(word)), "{flags}: {text}");
    }
}

#[test]
fn a_deep_punch_is_pressed_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let output = gfmd(folder.path(), &words("punch --n 16 --depth 0.1 --json"));
    let text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("--depth"), "{text}");
    assert!(text.contains("width of the punch"), "{text}");
    let output = gfmd(folder.path(), &words("punch --n 16 --depth 0.01 --height 0.05 --json"));
    assert!(String::from_utf8_lossy(&output.stderr).contains("height of the slab"));
    let output = gfmd(folder.path(), &words("punch --n 16 --json"));
    assert!(output.status.success() && output.stderr.is_empty());
}

#[test]
fn not_converged_is_an_error_that_keeps_what_was_reached() {
    let folder = tempfile::tempdir().unwrap();
    for solver in ["cg", "verlet"] {
        let flags = format!("punch --n 32 --solver {solver} --max-iterations 2 --json --out p.h5");
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
