//! Bodies that yield below their surface from end to end: flags in, numbers out, recorded, checked, refused.

use std::f64::consts::TAU;

use crate::common::{gfmd, json, numbers};
use gfmd_files::Reader;
use ndarray::Array2;
use serde_json::Value;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn list(value: &Value) -> String {
    value.as_array().unwrap().iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
}

const METAL: &str = "path --n 24 --eps-f-inv 6 --poisson 0.3 --yield-stress 0.01 --hardening 0.02";

/// Every body and hardening; the deepest one has cells one by one.
const BODIES: [(&str, &str); 7] = [
    ("half-space", ""),
    ("slab", "--height 0.3 --base sliding --kinematic 0.02"),
    ("coating", "--height 0.1 --layer 0.5,0.3,0.2 --layer-yield 0.02"),
    ("curve", "--height 0.2 --base half-space --base-young 3 --base-poisson 0.2"),
    ("second", "--second-body 2,0.2 --cells uniform:10,0.3"),
    ("profile", "--dim 2 --cells graded:1,1.3,0"),
    ("cells", "--cells 0.05,0.05,0.1,0.2 --coarsening 1,1,2,2 --flow"),
];

#[test]
fn a_path_of_a_metal_is_written_checked_drawn_and_told() {
    let folder = tempfile::tempdir().unwrap();
    for (name, flags) in BODIES {
        // The page of each has the figures; one surface and one profile are also drawn in files.
        let plots = if ["cells", "profile"].contains(&name) { format!("--plots {name}") } else { String::new() };
        let run = format!("{METAL} {flags} --p-star 0.05,0.15,0.01,0.15 --steps 2 --out {name}.h5 {plots} --json");
        let report = json(folder.path(), &words(&run));
        let steps = report["steps"].as_array().unwrap();
        let number = |step: usize, key: &str| steps[step][key].as_f64().unwrap();
        assert_eq!((steps.len(), &report["yield"], &report["hardening"]), (7, &0.01.into(), &0.02.into()), "{name}");
        // Loading yields, unloading and loading again as far do not, but for the length of the steps.
        assert!(number(2, "dissipated") > 0.0 && number(2, "max_plastic_strain") > number(0, "max_plastic_strain"));
        assert!(number(4, "dissipated") < 0.05 * number(2, "dissipated"), "{name}");
        assert!(steps[2]["plastic_displacement"]["min"].as_f64().unwrap() < 0.0);
        let kept = [2, 6].map(|step| number(step, "approach"));
        approx::assert_relative_eq!(kept[0], kept[1], max_relative = 0.02);
        let file = Reader::open(folder.path().join(format!("{name}.h5"))).unwrap();
        let cells = report["cells"].as_array().unwrap().len();
        assert_eq!(file.shape("/cells/depth").unwrap(), [cells]);
        let coarse = report["coarsening"][cells - 1].as_u64().unwrap() as usize;
        let points = if name == "profile" { vec![24 / coarse, 1] } else { vec![24 / coarse; 2] };
        assert_eq!(file.shape(&format!("/plastic/equivalent_{}", cells - 1)).unwrap(), points);
        let imprint: Vec<f64> = file.slab("/fields/plastic_displacement_z", 2).unwrap();
        let lowest = imprint.iter().copied().fold(0.0, f64::min);
        assert_eq!(lowest, steps[4]["plastic_displacement"]["min"].as_f64().unwrap());
        let checked = json(folder.path(), &["check", &format!("{name}.h5"), "--rerun", "--json"]);
        assert_eq!(checked["differing"], 0, "{name}: {checked}");
        assert!(gfmd(folder.path(), &["report", &format!("{name}.h5")]).status.success());
    }
}

#[test]
fn the_scan_of_the_page_is_pressed_and_checked() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/plasticity.md")).unwrap();
    let section = page.split_once("## From a scan\n").unwrap().1;
    let block =
        |kind: &str| section.split_once(&format!("```{kind}\n")).unwrap().1.split_once("```").unwrap().0.to_owned();
    let folder = tempfile::tempdir().unwrap();
    let lines = block("sh").replace("\\\n", " ");
    let printed: Vec<String> = lines
        .lines()
        .map(|line| {
            let output = gfmd(folder.path(), &words(line.strip_prefix("gfmd ").unwrap()));
            assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
            String::from_utf8(output.stdout).unwrap()
        })
        .collect();
    let [_, path, check] = &printed[..] else { panic!("{lines}") };
    assert!(path.contains(&block("text")), "{path}");
    assert!(check.contains(": 0 differ"), "{check}");
    let file = Reader::open(folder.path().join("scan.h5")).unwrap();
    let last = |name: &str| *file.values::<f64>(&format!("/path/{name}")).unwrap().last().unwrap();
    let told = [("approach", 0.614), ("plastic_displacement_min", -0.620), ("yield_depth", 23.0)];
    for (name, value) in told {
        approx::assert_relative_eq!(last(name), value, max_relative = 5e-3);
    }
    approx::assert_relative_eq!(last("max_plastic_strain"), 0.12, max_relative = 0.04);
}

/// Returns the heights of a problem of the reference.
fn heights(problem: &Value) -> Array2<f64> {
    let [n, lengths] = ["n", "length"].map(|key| {
        let pair = problem[key].as_array().unwrap();
        [pair[0].as_f64().unwrap(), pair[1].as_f64().unwrap()]
    });
    let (kind, size) = (problem["surface"][0].as_str().unwrap(), problem["surface"][1].as_f64().unwrap());
    Array2::from_shape_fn((n[0] as usize, n[1] as usize), |(i, j)| {
        let place = [i as f64, j as f64];
        let [x, y] = [0, 1].map(|axis| TAU * place[axis] / n[axis]);
        let near = |axis: usize| place[axis].min(n[axis] - place[axis]) * lengths[axis] / n[axis];
        match kind {
            "sphere" => -near(0).hypot(near(1)).powi(2) / (2.0 * size),
            "wave" if n[1] == 1.0 => size * x.cos() / 2.0,
            "wave" => size * (x.cos() + y.cos()) / 2.0,
            _ => size * (x.cos() + 0.6 * (2.0 * x + y + 0.7).cos() + 0.4 * (x - 2.0 * y - 1.1).cos()),
        }
    })
}

/// Returns the flags of the body of a problem of the reference.
fn body(problem: &Value) -> String {
    let below = match problem["body"].as_str().unwrap() {
        "sliding" => "--base sliding".to_owned(),
        "layer" => {
            let [young, poisson] = ["base_young", "base_poisson"].map(|key| problem[key].to_string());
            format!("--base half-space --base-young {young} --base-poisson {poisson}")
        }
        "layers" | "two-yields" => format!("--layer {}", list(&problem["layer"])),
        _ => String::new(),
    };
    let one =
        |(key, flag): (&str, &str)| problem.get(key).map_or_else(String::new, |value| format!(" --{flag} {value}"));
    let several = |(key, flag): (&str, &str)| {
        problem.get(key).map_or_else(String::new, |values| format!(" --{flag} {}", list(values)))
    };
    let numbers = [
        ("young", "young"),
        ("poisson", "poisson"),
        ("height", "height"),
        ("yield", "yield-stress"),
        ("hardening", "hardening"),
        ("kinematic", "kinematic-hardening"),
        ("layer_yield", "layer-yield"),
    ];
    let lists = [("cells", "cells"), ("coarsening", "coarsening"), ("second_body", "second-body")];
    let curve = problem.get("hardening_curve").map_or_else(String::new, |rows| {
        let rows = rows.as_array().unwrap().iter().map(|row| format!("{}:{}", row[0], row[1]));
        format!(" --hardening-curve {}", rows.collect::<Vec<_>>().join(","))
    });
    let [numbers, lists]: [String; 2] = [numbers.map(one).concat(), lists.map(several).concat()];
    format!("{below}{numbers}{lists}{curve}")
}

#[test]
fn the_program_has_the_values_of_the_reference() {
    let folder = tempfile::tempdir().unwrap();
    let all: Value = serde_json::from_str(include_str!("../../../plasticity/tests/reference.json")).unwrap();
    for case in all["cases"].as_array().unwrap() {
        let problem = &case["problem"];
        ndarray_npy::write_npy(folder.path().join("heights.npy"), &heights(problem)).unwrap();
        let path = problem["path"].as_array().unwrap();
        let values: Vec<String> = path.iter().map(|step| step[1].to_string()).collect();
        let run = format!(
            "path --surface heights.npy --size {} --{} {} --steps 1 --tolerance 1e-11 --grid-error none --json {}",
            if problem["n"][1] == 1 { "1".to_owned() } else { list(&problem["length"]) },
            path[0][0].as_str().unwrap(),
            values.join(","),
            body(problem)
        );
        let report = json(folder.path(), &words(&run));
        for (step, known) in report["steps"].as_array().unwrap().iter().zip(case["steps"].as_array().unwrap()) {
            let energy = known["elastic_energy"].as_f64().unwrap();
            for (key, place, floor) in [
                ("displacement", "/approach", 0.0),
                ("area_fraction", "/area_fraction", 0.0),
                ("max_pressure", "/max_pressure", 0.0),
                ("elastic_energy", "/elastic_energy", 0.0),
                ("hardening_energy", "/hardening_energy", energy),
                ("dissipated", "/dissipated", energy),
                ("plastic_strain_integral", "/plastic_strain_integral", 0.0),
                ("max_plastic_strain", "/max_plastic_strain", 0.0),
                ("yield_depth", "/yield_depth", 0.0),
                ("plastic_displacement_rms", "/plastic_displacement/rms", 0.0),
                ("plastic_displacement_min", "/plastic_displacement/min", 0.0),
            ] {
                let [found, known] =
                    [step.pointer(place), known.get(key)].map(|value| value.unwrap().as_f64().unwrap());
                let error = (found - known).abs();
                assert!(error <= 1e-8 * known.abs().max(floor), "{}: {key}: {found:e}, {known:e}", problem["name"]);
            }
        }
    }
}

#[test]
fn a_load_of_zero_leaves_the_imprint() {
    let folder = tempfile::tempdir().unwrap();
    for (name, flags) in [("a", "--p-star 0.1,0,0.1"), ("b", "--pressure 0.01,0 --grid-error refine --flow")] {
        let report = json(folder.path(), &words(&format!("{METAL} {flags} --steps 2 --out {name}.h5 --json")));
        let step = &report["steps"][2];
        assert_eq!(step["converged"], true);
        assert_eq!((step["mean_pressure"].as_f64(), step["area_fraction"].as_f64()), (Some(0.0), Some(0.0)));
        assert!(
            step["plastic_displacement"]["min"].as_f64().unwrap() < 0.0 && step["approach"].as_f64().unwrap() > 0.0
        );
        assert_eq!(json(folder.path(), &["check", &format!("{name}.h5"), "--rerun", "--json"])["differing"], 0);
        assert!(gfmd(folder.path(), &["report", &format!("{name}.h5")]).status.success());
    }
    let refused = |flags: &str| {
        let output = gfmd(folder.path(), &words(&format!("{METAL} {flags}")));
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (status, text) = refused("--pressure 0.01,-0.001");
    assert!(status == Some(2) && text.contains("it must be"), "{text}");
    let lifted = json(folder.path(), &words(&format!("{METAL} --approach 0.001,-0.001 --steps 2 --out c.h5 --json")));
    let step = &lifted["steps"][2];
    assert_eq!((step["mean_pressure"].as_f64(), step["approach"].as_f64()), (Some(0.0), Some(-0.001)));
    assert_eq!(step["plastic_displacement"], lifted["steps"][1]["plastic_displacement"]);
    assert_eq!(json(folder.path(), &["check", "c.h5", "--rerun", "--json"])["differing"], 0);
}

#[test]
fn without_yield_a_path_is_the_elastic_contact() {
    let folder = tempfile::tempdir().unwrap();
    let load = "--p-star 0.001 --tolerance 1e-11 --json";
    let yielding = "path --n 32 --eps-f-inv 4 --poisson 0.3 --yield-stress 0.099";
    let path = json(folder.path(), &words(&format!("{yielding} {load}")));
    let contact = json(folder.path(), &words(&format!("contact --n 32 --eps-f-inv 4 --poisson 0.3 {load}")));
    let (step, load) = (&path["steps"][0], &contact["loads"][0]);
    assert_eq!(step["max_plastic_strain"], 0.0);
    for key in ["approach", "area_fraction", "mean_gap", "max_pressure", "elastic_energy"] {
        let [found, known] = [step, load].map(|of| of[key].as_f64().unwrap());
        approx::assert_relative_eq!(found, known, max_relative = 1e-10);
    }
}

#[test]
fn units_do_not_matter_and_refinement_gives_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let shape = "--n 24 --eps-f-inv 6 --rms-gradient 0.1 --poisson 0.3 --steps 1 --json";
    let plain = format!("path {shape} --yield-stress 0.01 --hardening 0.02 --pressure 0.005,0.001");
    let metres = format!(
        "path {shape} --size 100um --young 200GPa --yield 2GPa --hardening 4GPa --pressure 1GPa,200MPa --grid-error \
         refine"
    );
    let [plain, metres] = [plain, metres].map(|run| json(folder.path(), &words(&run)));
    let number = |report: &Value, step: usize, key: &str| report["steps"][step][key].as_f64().unwrap();
    for step in [0, 1] {
        let strain = "max_plastic_strain";
        approx::assert_relative_eq!(number(&plain, step, strain), number(&metres, step, strain), max_relative = 1e-7);
        let [own, other] = [&plain, &metres].map(|report| number(report, step, "approach"));
        approx::assert_relative_eq!(100.0 * own, other, max_relative = 1e-8);
        assert!(number(&metres, step, "area_fraction_grid_error") > 0.0);
        assert!(number(&metres, step, "approach_limit").is_finite());
    }
    assert!(plain["steps"][0]["area_fraction_limit"].is_null());
}

#[test]
fn the_fields_inside_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(gfmd(folder.path(), &words(&format!("{METAL} --p-star 0.05 --out p.h5"))).status.success());
    let output = gfmd(folder.path(), &words("body --surface p.h5 --out b.h5"));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("the body of this contact yields"), "{message}");
    assert!(!folder.path().join("b.h5").exists());
}

#[test]
fn a_changed_strain_is_found() {
    let folder = tempfile::tempdir().unwrap();
    assert!(gfmd(folder.path(), &words(&format!("{METAL} --p-star 0.05,0.1 --steps 1 --out p.h5"))).status.success());
    let file = hdf5::File::open_rw(folder.path().join("p.h5")).unwrap();
    let strain = file.dataset("/plastic/strain_1").unwrap();
    let values: Vec<f64> = strain.read_raw().unwrap();
    strain.write_raw(&values.iter().map(|value| 1.01 * value).collect::<Vec<_>>()).unwrap();
    drop((strain, file));
    let output = gfmd(folder.path(), &["check", "p.h5", "--json"]);
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    let names = list(&report["differences"].as_array().unwrap().iter().map(|found| found["name"].clone()).collect());
    assert!(names.contains("/fields/displacement_z") && names.contains("residual"), "{names}");
}

/// With coarser cells below, and with a waypoint before first yield.
const LOOP: &str = "--cells graded:0.5,1.3,3 --p-star 0.0001,0.05,0.1,0.01 --steps 2";

#[test]
fn the_strain_of_every_waypoint_is_kept_on_request() {
    let folder = tempfile::tempdir().unwrap();
    let steps = json(folder.path(), &words(&format!("{METAL} {LOOP} --kept-strain waypoints --out all.h5 --json")));
    assert_eq!(steps["kept_strain"], "waypoints");
    let last = json(folder.path(), &words(&format!("{METAL} {LOOP} --out last.h5 --json")));
    assert!(last.get("kept_strain").is_none());
    let [all, last] = ["all", "last"].map(|name| Reader::open(folder.path().join(format!("{name}.h5"))).unwrap());
    assert!(!last.contains("/plastic_at_waypoints/strain_0"));
    let cells = steps["cells"].as_array().unwrap().len();
    for cell in 0..cells {
        for name in ["strain", "equivalent"] {
            let [of_last, known] = [&all, &last].map(|file| file.values::<f64>(&format!("/plastic/{name}_{cell}")));
            let kept: Vec<f64> = all.slab(&format!("/plastic_at_waypoints/{name}_{cell}"), 3).unwrap();
            assert_eq!(kept, known.unwrap());
            assert_eq!(kept, of_last.unwrap());
        }
    }
    for (waypoint, step) in [0, 2, 4, 6].into_iter().enumerate() {
        let of_cell = |cell: usize| {
            let kept: Vec<f64> = all.slab(&format!("/plastic_at_waypoints/equivalent_{cell}"), waypoint).unwrap();
            kept.into_iter().fold(0.0, f64::max)
        };
        let largest = (0..cells).map(of_cell).fold(0.0, f64::max);
        assert_eq!(largest, steps["steps"][step]["max_plastic_strain"].as_f64().unwrap());
        assert_eq!(waypoint == 0, largest == 0.0);
    }
    let checked = json(folder.path(), &["check", "all.h5", "--rerun", "--json"]);
    assert_eq!(checked["differing"], 0, "{checked}");
    assert!(gfmd(folder.path(), &["report", "all.h5"]).status.success());
}

#[test]
fn a_changed_strain_of_a_waypoint_is_found() {
    let folder = tempfile::tempdir().unwrap();
    for (name, first) in [("strain_1", "residual of step 2, from its strain"), ("equivalent_0", "(fall)")] {
        assert!(
            gfmd(folder.path(), &words(&format!("{METAL} {LOOP} --kept-strain waypoints --out p.h5"))).status.success()
        );
        let file = hdf5::File::open_rw(folder.path().join("p.h5")).unwrap();
        let strain = file.dataset(&format!("/plastic_at_waypoints/{name}")).unwrap();
        let (shape, mut values) = (strain.shape(), strain.read_raw::<f64>().unwrap());
        let size = values.len() / shape[0];
        values[size..2 * size].iter_mut().for_each(|value| *value *= 2.0);
        strain.write_raw(&values).unwrap();
        drop((strain, file));
        let output = gfmd(folder.path(), &["check", "p.h5", "--json"]);
        assert_eq!(output.status.code(), Some(1));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let all = report["differences"].as_array().unwrap().iter().map(|found| found["name"].clone()).collect();
        let names = list(&all);
        let is_integrated = names.contains("/path/plastic_strain_integral");
        assert!(names.contains(first) && is_integrated == (name == "equivalent_0"), "{names}");
    }
}

/// A run that is killed somewhere and continued writes the same numbers.
#[test]
fn the_strain_of_the_waypoints_survives_a_kill() {
    let folder = tempfile::tempdir().unwrap();
    let run = format!("{METAL} {LOOP} --kept-strain waypoints --threads 1 -q");
    assert!(gfmd(folder.path(), &words(&format!("{run} --out whole.h5"))).status.success());
    let again = format!("{run} --resume --out again.h5");
    let state = folder.path().join("again.h5.state");
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_gfmd"));
    let mut killed = command.current_dir(folder.path()).args(words(&again)).spawn().unwrap();
    while !state.exists() && killed.try_wait().unwrap().is_none() {
        std::thread::yield_now();
    }
    killed.kill().unwrap();
    killed.wait().unwrap();
    assert!(gfmd(folder.path(), &words(&again)).status.success());
    assert!(numbers(&folder.path().join("again.h5")) == numbers(&folder.path().join("whole.h5")));
}

#[test]
fn what_makes_no_sense_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    for (flags, reported) in [
        ("path --yield 0", "--yield-stress: the yield stress is 0"),
        ("path --yield 0.1", "--yield-stress: the yield stress is 0.1; it must be less than 0.1"),
        ("path --hardening 0.1", "--hardening is given; it must be left out without --yield-stress"),
        ("path --cells uniform:4,0.1", "--cells is given; it must be left out without --yield-stress"),
        ("path --kept-strain waypoints", "--kept-strain is given; it must be left out without --yield-stress"),
        ("path --yield 0.01 --hardening=-1", "--hardening: the isotropic hardening is -1"),
        ("path --yield 0.01 --hardening-curve 0:0.01", "--hardening-curve: the hardening curve has 1 points"),
        ("path --yield 0.01 --hardening-curve 0:0.02,0.1:0.03", "--hardening-curve is 2e-2 at first"),
        ("path --yield 0.01 --layer-yield 0.02", "--layer-yield is 1 values; it must be 0 at most"),
        ("path --yield 0.01 --poisson 0.499", "--poisson: Poisson's ratio of a layer with cells is 0.499"),
        ("path --yield 0.01 --cells graded:0.5,3,3", "--cells: the growth of the cells is 3"),
        ("path --yield 0.01 --cells 0.1,0.2 --coarsening 1", "--coarsening: there are 1 coarsenings"),
        ("path --yield 0.01 --height 0.1 --cells uniform:4,0.2", "--cells: the cells end at a depth of 0.15"),
        ("path --yield 0.01 --hardness 0.1", "--hardness is given; it must be left out with --yield-stress"),
        ("path --yield 0.01 --friction 0.3 --lateral 0,0.1", "--friction is given; it must be left out with"),
        ("path --yield 0.01 --boundary free", "--boundary is free; it must be periodic with --yield-stress"),
        ("contact --yield 0.01", "unexpected argument '--yield' found; it is an option of gfmd path"),
        ("slide --yield 0.01", "unexpected argument '--yield' found; it is an option of gfmd path"),
    ] {
        let output = gfmd(folder.path(), &words(&format!("{flags} --n 16 --p-star 0.05 --out x.h5")));
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{flags}: {message}");
        assert!(message.contains(reported), "{flags}: {message}");
        assert!(!folder.path().join("x.h5").exists());
    }
    let beyond = gfmd(folder.path(), &words("path --n 16 --poisson 0.3 --yield 0.01 --pressure 0.01,0.02"));
    let message = String::from_utf8_lossy(&beyond.stderr).into_owned();
    assert!(message.contains("near which the whole half-space yields"), "{message}");
}

/// Cells made by the program that end within the plastic zone are a failure, with advice; the state is still written.
#[test]
fn strain_below_the_cells_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let wave = |i: usize| (TAU * i as f64 / 32.0).cos();
    let heights = Array2::from_shape_fn((32, 32), |(i, j)| 0.01 * (wave(i) + wave(j)));
    ndarray_npy::write_npy(folder.path().join("wave.npy"), &heights).unwrap();
    let line = "path --surface wave.npy --poisson 0.3 --yield 0.0024 --hardening 0.01 --pressure 0.0015 --steps 1";
    let output = gfmd(folder.path(), &words(&format!("{line} --out w.h5")));
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("the lowest cell yields, and the body below it cannot"), "{message}");
    assert!(message.contains("try --cells that reach deeper"), "{message}");
    let deeper = json(folder.path(), &words(&format!("{line} --cells uniform:24,1 --json")));
    assert_eq!(deeper["steps"][0]["residual"]["bottom"], 0.0);
}
