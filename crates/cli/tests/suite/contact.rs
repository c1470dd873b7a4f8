//! `contact` from end to end: files in, JSON and HDF5 out.

use std::f64::consts::TAU;

use crate::common::{gfmd, json};
use approx::assert_relative_eq;
use gfmd_files::Reader;
use ndarray::{Array1, Array2};
use serde_json::Value;

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {value}"))
}

/// Returns the surface of the cross-code table.
fn four_waves(n: usize) -> Array2<f64> {
    Array2::from_shape_fn((n, n), |(i, j)| {
        let [x, y] = [i, j].map(|k| TAU * k as f64 / n as f64);
        let waves = x.cos() + 0.5 * (2.0 * y + 0.3).cos() + 0.25 * (3.0 * x - 2.0 * y + 1.1).cos();
        0.01 * (waves + 0.125 * (5.0 * x + 4.0 * y + 2.0).cos())
    })
}

#[test]
fn a_surface_from_a_file_gives_the_published_numbers_in_json_and_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let heights = four_waves(64);
    ndarray_npy::write_npy(folder.path().join("h.npy"), &heights).unwrap();
    let flags =
        "contact --surface h.npy --size 1 --young 1 --poisson 0 --pressure 0.005,0.02,0.05 --tolerance 1e-12 --json";
    let mut arguments: Vec<&str> = flags.split_whitespace().collect();
    arguments.extend(["--out", "c.h5"]);
    let report = json(folder.path(), &arguments);

    assert_eq!(report["n"], serde_json::json!([64, 64]));
    let expected = [
        (570, 0.097_119_164_4, 0.007_581_884_52),
        (1742, 0.127_922_891_2, 0.002_135_958_89),
        (3344, 0.161_929_049_1, 0.000_247_824_448),
    ];
    for (load, (nodes, peak, gap)) in report["loads"].as_array().unwrap().iter().zip(expected) {
        assert_eq!(load["contact_nodes"], nodes);
        assert_relative_eq!(number(load, "max_pressure"), peak, max_relative = 1e-9);
        assert_relative_eq!(number(load, "mean_gap"), gap, max_relative = 5e-9);
        assert_eq!(load["converged"], true);
        assert_relative_eq!(
            number(load, "kappa"),
            number(load, "area_fraction") / number(load, "p_star"),
            max_relative = 1e-15
        );
    }

    let file = Reader::open(folder.path().join("c.h5")).unwrap();
    for key in ["mean_pressure", "p_star", "approach", "area_fraction", "kappa", "mean_gap", "elastic_energy"] {
        let stored: Vec<f64> = file.values(&format!("/loads/{key}")).unwrap();
        for (stored, load) in stored.iter().zip(report["loads"].as_array().unwrap()) {
            assert_eq!(stored.to_bits(), number(load, key).to_bits(), "{key}");
        }
    }
    assert_eq!(file.values::<f64>("/surface/height").unwrap(), heights.as_slice().unwrap());
    assert_eq!(file.shape("/fields/pressure").unwrap(), [3, 64, 64]);
    // Residuals hold for the stored fields, not only for the fields in memory.
    let pressure: Vec<f64> = file.slab("/fields/pressure", 1).unwrap();
    let gap: Vec<f64> = file.slab("/fields/gap", 1).unwrap();
    let mean = pressure.iter().sum::<f64>() / 4096.0;
    assert_relative_eq!(mean, 0.02, max_relative = 1e-12);
    let work: f64 = pressure.iter().zip(&gap).map(|(p, g)| p * g).sum();
    assert!(work.abs() < 1e-12 * 0.02 * 4096.0 * 0.01);
    assert!(gap.iter().all(|g| *g > -1e-13));
    assert!(file.text("/", "config").unwrap().contains("pressure = [0.005, 0.02, 0.05]"));
}

#[test]
fn a_list_of_loads_in_steps_and_the_stiffness_of_each() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "contact --n 32 --hurst 0.8 --p-star 0.01:0.16:5,3 --json --out c.h5";
    let report = json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    let loads = report["loads"].as_array().unwrap();
    let numbers = |key: &str| loads.iter().map(|load| load[key].as_f64()).collect::<Vec<_>>();
    for (found, asked) in numbers("p_star").into_iter().zip([0.01, 0.02, 0.04, 0.08, 0.16, 3.0]) {
        assert_relative_eq!(found.unwrap(), asked, max_relative = 1e-12);
    }
    let stiffness = numbers("stiffness");
    // Full contact of a half-space has no stiffness.
    assert!(stiffness[..5].windows(2).all(|pair| pair[0] < pair[1]) && stiffness[5].is_none(), "{stiffness:?}");
    assert!(numbers("stiffness_error")[..5].iter().all(|error| error.is_some_and(|error| error <= 5e-6)));
    let file = Reader::open(folder.path().join("c.h5")).unwrap();
    let stored: Vec<f64> = file.values("/loads/stiffness").unwrap();
    assert_eq!(stored[..5].iter().copied().map(Some).collect::<Vec<_>>(), stiffness[..5]);
    assert!(stored[5].is_nan() && file.text("/loads/stiffness", "undefined").unwrap().contains("full contact"));
    assert!(file.text("/", "config").unwrap().contains("p_star = [0.01, 0.02"));
    drop(file);
    for words in [&["check", "c.h5"][..], &["check", "c.h5", "--rerun"]] {
        let output = gfmd(folder.path(), words);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    }

    // A difference quotient along the curve, also with a law.
    for law in ["", " --law exponential --param gamma=1e-5,range=1e-3"] {
        let flags = format!("contact --n 32 --hurst 0.8 --approach 0.006,0.006003 --json{law}");
        let report = json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
        let [low, high] =
            [0, 1].map(|i| ["mean_pressure", "approach", "stiffness"].map(|key| number(&report["loads"][i], key)));
        assert_relative_eq!((high[0] - low[0]) / (high[1] - low[1]), 0.5 * (low[2] + high[2]), max_relative = 1e-3);
    }
}

#[test]
fn statistics_and_flow_agree_with_the_fields_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let words = "contact --n 64 --eps-f-inv 16 --hurst 0.8 --seed 4 --p-star 0.05:1.2:4 --statistics --flow --json";
    let mut words: Vec<&str> = words.split_whitespace().collect();
    words.extend(["--out", "c.h5", "--plots", "c"]);
    let report = json(folder.path(), &words);
    let file = Reader::open(folder.path().join("c.h5")).unwrap();
    let column = |path: &str| file.values::<f64>(path).unwrap();
    let of_patch = column("/patches/load");
    for (load, record) in report["loads"].as_array().unwrap().iter().enumerate() {
        let pressure: Vec<f64> = file.slab("/fields/pressure", load).unwrap();
        let gap: Vec<f64> = file.slab("/fields/gap", load).unwrap();
        let sum = |path: &str| -> f64 {
            column(path).iter().zip(&of_patch).filter(|(_, of)| **of == load as f64).map(|(value, _)| value).sum()
        };
        assert_eq!(
            of_patch.iter().filter(|of| **of == load as f64).count() as u64,
            record["patches"]["count"].as_u64().unwrap()
        );
        assert_relative_eq!(sum("/patches/area"), number(record, "area_fraction"), max_relative = 1e-12);
        assert_relative_eq!(sum("/patches/force"), number(record, "mean_pressure"), max_relative = 1e-12);
        assert_relative_eq!(sum("/patches/perimeter") * 64.0, number(record, "boundary_links"), max_relative = 1e-12);
        assert_relative_eq!(number(record, "conductance"), 2.0 * number(record, "stiffness"), max_relative = 1e-15);
        // Densities times the bin width are fractions of the points.
        let share = |name: &str| -> f64 {
            let densities: Vec<f64> = file.slab(&format!("/distributions/{name}"), load).unwrap();
            let middles: Vec<f64> = file.slab(&format!("/distributions/{name}_at"), load).unwrap();
            densities.iter().sum::<f64>() * 2.0 * middles[0]
        };
        assert_relative_eq!(share("pressure"), number(record, "area_fraction"), max_relative = 1e-12);
        let open = pressure.iter().zip(&gap).filter(|(p, g)| **p == 0.0 && **g > 0.0).count() as f64 / 4096.0;
        assert_relative_eq!(share("gap"), open, max_relative = 1e-12);
        // Autocorrelation with the neighbour, summed directly.
        let mean = pressure.iter().sum::<f64>() / 4096.0;
        let product = |step: usize| -> f64 {
            (0..4096).map(|i| (pressure[i] - mean) * (pressure[i / 64 * 64 + (i + step) % 64] - mean)).sum()
        };
        let found: Vec<f64> = file.slab("/spectra/autocorrelation_y", load).unwrap();
        assert_eq!((found.len(), found[0]), (33, 1.0));
        assert_relative_eq!(found[3], product(3) / product(0), max_relative = 1e-9);
        let flow = &record["flow"];
        let through = flow["percolates"][0].as_bool().unwrap();
        let along = flow["conductivity"][0][0].as_f64().unwrap();
        assert_eq!(through, along > 0.0);
        assert!(along < 1.0 && number(flow, "residual") <= 1e-8);
        assert_eq!(column("/loads/flow_xx")[load].to_bits(), along.to_bits());
    }
    let last = &report["loads"][3];
    // Three quarters in contact: the contact percolates, the gap does not.
    assert_eq!(
        (&last["patches"]["percolates"], &last["flow"]["percolates"]),
        (&serde_json::json!([true, true]), &serde_json::json!([false, false]))
    );
    let plots: Vec<&str> = report["plots"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    for name in ["c-patches.svg", "c-pressures.svg", "c-gaps.svg", "c-spectrum.svg"] {
        assert!(plots.contains(&name) && folder.path().join(name).is_file(), "{plots:?}");
    }
    drop(file);
    for words in [&["check", "c.h5"][..], &["check", "c.h5", "--rerun"]] {
        let output = gfmd(folder.path(), words);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    }
    let refused = gfmd(folder.path(), &["contact", "--dim", "2", "--n", "64", "--p-star", "0.1", "--flow"]);
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn the_flow_stops_between_the_loads_of_the_threshold() {
    let folder = tempfile::tempdir().unwrap();
    let run = |words: &str| json(folder.path(), &words.split_whitespace().collect::<Vec<_>>());
    let surface = "--n 64 --eps-f-inv 16 --hurst 0.8 --seed 4 --json";
    let found = run(&format!("contact {surface} --p-star 0.05,1.2 --flow-threshold --out c.h5"));
    for axis in 0..2 {
        let threshold = &found["flow_threshold"][axis];
        let sides = |key: &str| [0, 1].map(|side| threshold[key][side].as_f64().unwrap());
        let [open, closed] = sides("p_star");
        assert!(open < closed && closed < 1.0011 * open, "{threshold}");
        assert!(sides("area_fraction")[0] > 0.3 && sides("area_fraction")[1] < 0.6);
        let loads = run(&format!("contact {surface} --p-star {open:e},{closed:e} --flow"));
        let percolates = [0, 1].map(|load| loads["loads"][load]["flow"]["percolates"][axis].as_bool().unwrap());
        assert_eq!(percolates, [true, false]);
    }
    for words in [&["check", "c.h5"][..], &["check", "c.h5", "--rerun"]] {
        let output = gfmd(folder.path(), words);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stdout));
    }
    // A weak attraction hardly changes the threshold, a stronger one closes the gap earlier, and a strong one at once.
    let at = |gamma: &str, least: f64| {
        let law = format!("--law exponential --param gamma={gamma},range=8e-3");
        let report = run(&format!("contact {surface} {law} --p-star={least},1.2 --flow-threshold"));
        report["flow_threshold"][0]["p_star"][0].as_f64()
    };
    let wall = found["flow_threshold"][0]["p_star"][0].as_f64().unwrap();
    let [weak, middle] = [("1e-9", 0.0), ("2e-5", -1e-3)].map(|(gamma, least)| at(gamma, least).unwrap());
    assert!((weak / wall - 1.0).abs() < 2e-3 && middle < 0.9 * wall && middle > 0.0, "{wall} {weak} {middle}");
    assert_eq!(at("1e-2", 0.0), None);
    // Open at all loads; one load.
    let open = run(&format!("contact {surface} --p-star 0.01,0.02 --flow-threshold"));
    assert!(open["flow_threshold"][0].is_null() && open["flow_threshold"][1].is_null());
    let mut warnings = open["warnings"].as_array().unwrap().iter();
    assert!(warnings.any(|warning| warning["code"] == "flow-threshold"));
    let refused = gfmd(folder.path(), &["contact", "--n", "64", "--flow-threshold", "--p-star", "0.1,0.1"]);
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn solvers_agree_and_threads_do_not_matter() {
    let folder = tempfile::tempdir().unwrap();
    let run = |rest: &str| {
        let flags = format!(
            "contact --n 64 --eps-f-inv 16 --hurst 0.5 --seed 3 --p-star 0.05,0.2 --height 0.5 --poisson 0.4 {rest} \
             --json"
        );
        json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>())["loads"].clone()
    };
    let reference = run("--solver cg --tolerance 1e-11");
    for solver in ["auto", "projected-cg", "preconditioned-cg", "verlet", "verlet-critical", "verlet-modes", "fire"] {
        let loads = run(&format!("--solver {solver} --tolerance 1e-11"));
        for (a, b) in loads.as_array().unwrap().iter().zip(reference.as_array().unwrap()) {
            assert_eq!(a["contact_nodes"], b["contact_nodes"], "{solver}");
            assert_relative_eq!(number(a, "max_pressure"), number(b, "max_pressure"), max_relative = 1e-9);
            assert_relative_eq!(number(a, "approach"), number(b, "approach"), max_relative = 1e-9);
        }
    }
    let strip = |mut loads: Value| {
        loads.as_array_mut().unwrap().iter_mut().for_each(|load| drop(load.as_object_mut().unwrap().remove("seconds")));
        loads
    };
    assert_eq!(strip(run("--threads 1")), strip(run("--threads 3")));
}

#[test]
fn approach_and_pressure_are_two_views_of_one_contact() {
    let folder = tempfile::tempdir().unwrap();
    for height in ["inf", "0.4"] {
        let run = |control: &str| {
            let flags = format!(
                "contact --n 48 --eps-f-inv 8 {control} --height {height} --poisson 0.3 --tolerance 1e-12 --json"
            );
            json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>())["loads"][0].clone()
        };
        let pressed = run("--p-star 0.1");
        let moved = run(&format!("--approach {:.17e}", number(&pressed, "approach")));
        assert_relative_eq!(number(&moved, "mean_pressure"), number(&pressed, "mean_pressure"), max_relative = 1e-9);
        assert_eq!(moved["contact_nodes"], pressed["contact_nodes"]);
    }
}

#[test]
fn beyond_full_contact_the_solution_is_linear() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "contact --n 32 --eps-f-inv 8 --p-star 5,10 --json";
    let report = json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    let [a, b] = [0, 1].map(|i| report["loads"][i].clone());
    assert_eq!((number(&a, "area_fraction"), number(&b, "area_fraction")), (1.0, 1.0));
    let excess = |load: &Value| number(load, "max_pressure") - number(load, "mean_pressure");
    assert_relative_eq!(excess(&a), excess(&b), max_relative = 1e-7);
    assert_eq!((number(&a, "mean_gap"), number(&b, "mean_gap")), (0.0, 0.0));
}

#[test]
fn profiles_in_npy_and_hdf5_are_line_contacts() {
    let folder = tempfile::tempdir().unwrap();
    let n = 256;
    let wave = Array1::from_shape_fn(n, |i| 0.01 * (TAU * i as f64 / n as f64).cos());
    ndarray_npy::write_npy(folder.path().join("wave.npy"), &wave.mapv(|h| h as f32)).unwrap();
    let made = folder.path().join("made.h5");
    let file = hdf5::File::create(&made).unwrap();
    file.new_dataset_builder().with_data(&wave).create("profiles/wave").unwrap();
    file.close().unwrap();
    // A process started by another test may hold the lock of an open file; a copy has no lock.
    std::fs::copy(&made, folder.path().join("wave.h5")).unwrap();
    // Westergaard: a_r = (2/π) asin √(p̄/p_full), p_full = π E* A/λ.
    let pressure = 0.3 * std::f64::consts::PI * 0.01;
    for surface in ["wave.npy", "wave.h5:/profiles/wave"] {
        let flags = format!("contact --surface {surface} --pressure {pressure} --json");
        let report = json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
        assert_eq!(report["n"], serde_json::json!([n, 1]));
        assert_relative_eq!(number(&report["loads"][0], "area_fraction"), 0.369_010_119, epsilon = 2.0 / n as f64);
    }
}

#[test]
fn a_text_scan_brings_its_size_and_its_wrap_around_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    // A tilted ramp with waves: opposite edges do not match.
    let rows: Vec<String> = (0..24)
        .map(|j| {
            let height = |i: usize| 1e-9 * (5.0 * i as f64 + (0.9 * i as f64).sin() * (0.7 * j as f64).cos());
            (0..24).map(|i| format!("{:e}", height(i))).collect::<Vec<_>>().join("\t")
        })
        .collect();
    let text =
        format!("# Channel: Height\n# Width: 2.00 µm\n# Height: 2.00 µm\n# Value units: m\n{}\n", rows.join("\n"));
    std::fs::write(folder.path().join("scan.txt"), text).unwrap();
    let run = |rest: &str| {
        let flags = format!("contact --surface scan.txt --e-star 1e9 --p-star 0.1 {rest} --json");
        let output = gfmd(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        (report, String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (raw, warning) = run("");
    assert_relative_eq!(raw["size"][0].as_f64().unwrap(), 2e-6, max_relative = 1e-12);
    assert_eq!(raw["unit"], "m");
    assert!(warning.contains("seam") && warning.contains("--periodise"), "{warning}");
    let (mirrored, quiet) = run("--detrend plane --periodise mirror");
    assert_eq!(mirrored["n"], serde_json::json!([48, 48]));
    assert!(number(&mirrored, "rms_gradient") < 0.5 * number(&raw, "rms_gradient"));
    assert!(mirrored["surface"].as_str().unwrap().contains("mirrored") && !quiet.contains("seam"), "{quiet}");
}

#[test]
fn a_file_has_the_fields_that_were_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let run = |flags: &str| gfmd(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    let contact = "contact --n 32 --eps-f-inv 8 --p-star 0.05,0.1 --resume";
    let replacing = contact.replace(" --resume", "");
    assert!(run(&format!("{contact} --out all.h5")).status.success());
    let all = Reader::open(folder.path().join("all.h5")).unwrap();
    for (fields, names) in [
        ("none", &[][..]),
        ("gap", &["gap"]),
        ("gap,pressure", &["gap", "pressure"]),
        ("pressure,displacement_z,gap", &["displacement_z", "gap", "pressure"]),
    ] {
        let output = run(&format!("{replacing} --out some.h5 --fields {fields}"));
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let some = Reader::open(folder.path().join("some.h5")).unwrap();
        let found =
            some.names("/fields").into_iter().filter(|name| some.shape(&format!("/fields/{name}")).unwrap().len() == 3);
        assert!(found.eq(names.iter().copied()), "{fields}: {:?}", some.names("/fields"));
        for name in names.iter().map(|name| format!("/fields/{name}")) {
            assert_eq!(some.values::<f64>(&name).unwrap(), all.values::<f64>(&name).unwrap());
        }
        assert_eq!(some.values::<f64>("/loads/kappa").unwrap(), all.values::<f64>("/loads/kappa").unwrap());
        drop(some);
        let check = run("check some.h5");
        assert!(check.status.success(), "{fields}: {}", String::from_utf8_lossy(&check.stderr));
        let missing = String::from_utf8_lossy(&check.stderr).contains("no /fields/pressure");
        assert_eq!(missing, !fields.contains("pressure"), "{fields}");
        let rerun = run("check some.h5 --rerun --json");
        let report: Value = serde_json::from_slice(&rerun.stdout).unwrap();
        assert!(report["differing"] == 0 && report["compared"].as_u64().unwrap() > 60, "{fields}: {report}");
        assert!(run("report some.h5 --out some.html").status.success());
    }
    let below = run("body --surface all.h5 --levels 2 --deepest 0.1 --out below.vti");
    assert!(below.status.success());
    assert!(run(&format!("{contact} --out few.h5 --fields pressure")).status.success());
    let other = run(&format!("{contact} --out few.h5 --fields gap"));
    assert!(String::from_utf8_lossy(&other.stderr).contains("the finished result of another configuration"));
    let below = run("body --surface few.h5 --levels 2 --deepest 0.1 --out below.vti");
    let message = String::from_utf8_lossy(&below.stderr).into_owned();
    assert!(below.status.code() == Some(2), "{message}");
    assert!(message.contains("no /fields/displacement"), "{message}");
    assert!(message.contains("pressure"), "{message}");
    for (bad, words) in [
        ("heat", "some of pressure, displacement_z, gap"),
        ("gap,none", "none, or some"),
        ("plastic_depth", "--hardness"),
    ] {
        let refused = run(&format!("{contact} --out bad.h5 --fields {bad}"));
        let message = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && message.contains(words), "{message}");
    }
    assert!(
        run("contact --n 32 --eps-f-inv 8 --p-star 0.3 --hardness 0.05 --out p.h5 --fields plastic_depth")
            .status
            .success()
    );
    let file = Reader::open(folder.path().join("p.h5")).unwrap();
    assert!(file.contains("/fields/plastic_depth") && !file.contains("/fields/pressure"));
}

#[test]
fn finite_slopes_change_the_contact_and_are_certified() {
    let folder = tempfile::tempdir().unwrap();
    let words = "contact --n 32 --eps-f-inv 4 --young 1 --poisson 0 --p-star 0.05 --json -q";
    let run = |more: &str| {
        let arguments: Vec<&str> = words.split_whitespace().chain(more.split_whitespace()).collect();
        gfmd(folder.path(), &arguments)
    };
    let report = |more: &str| -> Value {
        let output = run(more);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let (flat, steep) = (report("--rms-gradient 0.25"), report("--rms-gradient 0.25 --finite-slope"));
    let load = |report: &Value, key: &str| report["loads"][0][key].as_f64().unwrap();
    // A compressible body loses area.
    let change = load(&steep, "area_fraction") / load(&flat, "area_fraction") - 1.0;
    assert!((-0.1..-0.005).contains(&change), "{change}");
    let residuals = steep["loads"][0]["residual"].as_object().unwrap();
    assert!(residuals.len() == 5 && residuals.values().all(|value| value.as_f64().unwrap() <= 1e-8), "{residuals:?}");
    assert!(steep["loads"][0]["mean_shear"][0].as_f64().unwrap() != 0.0 && flat["loads"][0]["mean_shear"].is_null());
    assert!(flat["max_slope"].as_f64().unwrap() > 0.5);
    let codes = |report: &Value| -> Vec<String> {
        let warnings = report["warnings"].as_array().unwrap().iter();
        warnings.filter_map(|warning| Some(warning["code"].as_str()?.to_owned())).collect()
    };
    for report in [&flat, &steep] {
        assert_eq!(codes(report), ["grid", "large-slope"]);
    }
    assert_eq!(codes(&report("--rms-gradient 0.05")), ["grid"]);
    // The fields below have the lateral displacement of the file.
    report("--rms-gradient 0.25 --finite-slope --out s.h5");
    json(
        folder.path(),
        &["body", "--surface", "s.h5", "--depths", "0", "--quantities", "displacement", "--out", "b.h5", "--json"],
    );
    let open = |name: &str| Reader::open(folder.path().join(name)).unwrap();
    let below: Vec<f64> = open("b.h5").values("/fields/displacement").unwrap();
    for (component, axis) in ["x", "y", "z"].iter().enumerate() {
        let field: Vec<f64> = open("s.h5").values(&format!("/fields/displacement_{axis}")).unwrap();
        let differ = field.iter().zip(below.iter().skip(component).step_by(3)).map(|(a, b)| (a - b).abs());
        assert!(field.iter().any(|u| u.abs() > 1e-4) && differ.fold(0.0, f64::max) < 1e-12, "{axis}");
    }
    for (more, flag) in [
        ("--boundary free", "--boundary"),
        ("--law morse --param gamma=1e-4,range=1e-2", "--law"),
        ("--second-body 1,0.3", "--second-body"),
        ("--solver fire", "fire"),
    ] {
        let output = run(&format!("--finite-slope {more}"));
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && message.contains(flag), "{more}: {message}");
    }
}
/// Without Nyquist modes, on an odd grid, three unknown components and one are the same problem (theory.md, section 3).
#[test]
fn all_components_are_those_that_follow_from_the_pressure() {
    let folder = tempfile::tempdir().unwrap();
    let run = |flags: &str| json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    for (body, dim) in [("--height 0.4 --poisson 0.3", 3), ("--poisson 0.2", 3), ("--height 0.3 --poisson 0.45", 2)] {
        let contact = format!(
            "contact --dim {dim} --n 45 --eps-t-inv 3 --eps-f-inv 5 {body} --p-star 0.05,0.1 --tolerance 1e-10 --json"
        );
        let normal = run(&format!("{contact} --out normal.h5"));
        // The dynamics move all components; else they follow from the pressure.
        let found = run(&format!("{contact} --components all --out found.h5"));
        let all = run(&format!("{contact} --components all --solver verlet --out all.h5"));
        assert!(all["components"] == "all" && normal["components"].is_null());
        for name in ["stiffness", "approach", "transform_pairs"] {
            assert_eq!(found["loads"][1][name], normal["loads"][1][name], "{body}: {name}");
        }
        for load in 0..2 {
            let [a, b] = [&all, &normal].map(|report| report["loads"][load].clone());
            assert_eq!(a["contact_nodes"], b["contact_nodes"], "{body}");
            assert!(number(&a["residual"], "lateral_traction") <= 1e-10, "{a}");
            for name in ["approach", "max_pressure", "mean_gap", "elastic_energy"] {
                assert_relative_eq!(number(&a, name), number(&b, name), max_relative = 1e-7);
            }
            // The stiffness has five certain digits.
            assert_relative_eq!(number(&a, "stiffness"), number(&b, "stiffness"), max_relative = 1e-5);
        }
        let below = "body --surface normal.h5 --load 1 --depths 0 --quantities displacement --out below.h5 --json";
        run(below);
        let open = |name: &str| Reader::open(folder.path().join(name)).unwrap();
        let (all, found, below) = (open("all.h5"), open("found.h5"), open("below.h5"));
        let expected: Vec<f64> = below.values("/fields/displacement").unwrap();
        let axes = if dim == 3 { &["x", "y", "z"][..] } else { &["x", "z"] };
        let largest = expected.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
        for (c, axis) in axes.iter().enumerate() {
            let name = format!("/fields/displacement_{axis}");
            let expected = || expected.iter().skip(c).step_by(axes.len());
            let worst = |field: &[f64]| field.iter().zip(expected()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let by_dynamics: Vec<f64> = all.slab(&name, 1).unwrap();
            assert!(worst(&by_dynamics) < 1e-7 * largest, "{axis}: {}", worst(&by_dynamics));
            let by_pressure: Vec<f64> = found.slab(&name, 1).unwrap();
            assert!(worst(&by_pressure) < 1e-12 * largest, "{axis}: {}", worst(&by_pressure));
            assert!(by_pressure.iter().any(|u| u.abs() > 1e-3 * largest), "{axis}");
        }
        assert_eq!(all.contains("/fields/displacement_y"), dim == 3);
    }
}

#[test]
fn a_surface_that_is_held_sideways_is_stiffer() {
    let folder = tempfile::tempdir().unwrap();
    let run = |flags: &str| json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    let contact = "contact --n 48 --eps-f-inv 8 --pressure 0.002 --tolerance 1e-11 --stiffness-tolerance 1e-9 --json";
    let held = run(&format!("{contact} --young 1 --poisson 0.33 --components held --statistics --out held.h5"));
    // K_N = (E* q/2)/(1 - s^2) on a half-space (theory.md, section 3).
    let s: f64 = (1.0 - 0.66) / (2.0 - 0.66);
    let stiffer = 1.0 / (1.0 - 0.33 * 0.33) / (1.0 - s * s);
    let expected = run(&format!("{contact} --e-star {stiffer:.17e}"));
    let [a, b] = [&held, &expected].map(|report| report["loads"][0].clone());
    assert_eq!((&a["contact_nodes"], &held["components"]), (&b["contact_nodes"], &"held".into()));
    for name in ["approach", "max_pressure", "elastic_energy", "stiffness"] {
        assert_relative_eq!(number(&a, name), number(&b, name), max_relative = 1e-8);
    }
    assert_relative_eq!(number(&held, "e_star"), 1.0 / (1.0 - 0.33 * 0.33), max_relative = 1e-15);
    // Equal contact points have equal conductance, and the stiffness of the laterally free body determines it.
    assert_relative_eq!(number(&a, "conductance"), 2.0 * number(&b, "stiffness") / stiffer, max_relative = 1e-8);
    assert!(a["patches"]["count"].as_u64() > Some(1));
    assert_eq!(run("check held.h5 --json")["differing"], 0);
    // Below the contact there is no lateral displacement at the surface.
    run("body --surface held.h5 --depths 0,0.1 --quantities displacement --out below.h5 --json");
    let below = Reader::open(folder.path().join("below.h5")).unwrap();
    let [top, deep] = [0, 1].map(|level| below.slab::<f64>("/fields/displacement", level).unwrap());
    let largest = |u: &[f64], axis: usize| u.iter().skip(axis).step_by(3).fold(0.0_f64, |m, u| m.max(u.abs()));
    assert!(largest(&top, 0) < 1e-12 * largest(&top, 2) && largest(&deep, 0) > 1e-3 * largest(&deep, 2));
}

/// A half-space held sideways answers as a stiffer one that is free, also to a law, in any units.
#[test]
fn a_surface_that_is_held_sideways_is_stiffer_below_a_law() {
    let folder = tempfile::tempdir().unwrap();
    let run = |flags: &str| json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    let s: f64 = (1.0 - 0.66) / (2.0 - 0.66);
    let stiffer = 1.0 / (1.0 - 0.33 * 0.33) / (1.0 - s * s);
    for unit in [1.0, 1e9] {
        let load = |load: f64| load * unit;
        let contact = format!(
            "contact --n 48 --eps-f-inv 8 --pressure={:e},{:e},{:e} --tolerance 1e-11 --json --law exponential --param \
             gamma={:e},range=3e-3",
            load(0.002),
            load(1e-4),
            load(-1e-4),
            load(2e-5)
        );
        let held =
            run(&format!("{contact} --young {unit:e} --poisson 0.33 --components held --statistics --out held.h5"));
        let free = run(&format!("{contact} --e-star {:.17e}", load(stiffer)));
        for (a, b) in held["loads"].as_array().unwrap().iter().zip(free["loads"].as_array().unwrap()) {
            assert_eq!(a["contact_nodes"], b["contact_nodes"]);
            for name in ["approach", "max_pressure", "elastic_energy", "interface_energy", "stiffness"] {
                assert_relative_eq!(number(a, name), number(b, name), max_relative = 1e-7);
            }
        }
        assert_eq!(run("check held.h5 --json")["differing"], 0);
    }
    // A slab, whose surface is stiffer if it is held, and as stiff as a free one under a uniform pressure.
    let slab = "contact --n 32 --eps-f-inv 4 --pressure 0.01 --height 0.2 --poisson 0.3 --tolerance 1e-10 --json --law \
                exponential --param gamma=2e-5,range=3e-3";
    let approach = |flags: &str| number(&run(&format!("{slab} {flags}"))["loads"][0], "approach");
    assert!(approach("--components held") < approach(""));
}

#[test]
fn the_history_of_a_contact_ends_at_its_state() {
    let folder = tempfile::tempdir().unwrap();
    let run = |flags: &str| json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    let numbers = |value: &Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap_or(f64::NAN)).collect()
    };
    let contact =
        "contact --n 27 --eps-f-inv 4 --height 0.5 --poisson 0.3 --p-star 0.05 --tolerance 1e-9 --history --json";
    let expected = number(&run(contact)["loads"][0], "approach");
    for how in [
        "--solver verlet-critical",
        "--solver verlet-critical --dt 0.5 --damping 1.5",
        "--solver verlet-modes",
        "--solver verlet-modes --dt 0.6 --components held",
        "--solver fire2",
        "--components all --solver verlet-modes",
        "--components all --solver verlet-critical --dt 0.5 --damping 1,1,1.2 --history-mode 1,0,x",
    ] {
        let traced = "--history-mode 1,0,z --history-mode 0,0,z --history-point 0.3333,0.6667,z --out h.h5";
        let report = run(&format!("{contact} {how} {traced}"));
        let (load, trace) = (&report["loads"][0], &report["history"]);
        let steps = number(load, "iterations") as usize;
        assert_eq!(numbers(&trace["iteration"]), (0..=steps).map(|step| step as f64).collect::<Vec<_>>(), "{how}");
        assert!(numbers(&trace["residual"])[steps] <= 1e-9 && numbers(&trace["energy"])[steps] < 0.0, "{how}");
        let file = Reader::open(folder.path().join("h.h5")).unwrap();
        let u: Vec<f64> = file.values("/fields/displacement_z").unwrap();
        let approach = number(load, "approach");
        if !how.contains("held") {
            assert_relative_eq!(approach, expected, max_relative = 1e-6);
        }
        // u_z is measured from the rigid surface at first touch.
        let point = numbers(&trace["points"][0]["u"])[steps];
        assert_relative_eq!(point, u[9 * 27 + 18] + approach, epsilon = 1e-6 * approach);
        let mean = numbers(&trace["modes"][trace["modes"].as_array().unwrap().len() - 1]["re"])[steps];
        assert_relative_eq!(mean, u.iter().sum::<f64>() / 729.0 + approach, epsilon = 1e-6 * approach);
        assert_eq!(file.shape("/history/point_u").unwrap(), [1, steps + 1]);
        assert_eq!(run("check h.h5 --rerun --json")["differing"], 0, "{how}");
    }
    // Methods that move no displacement; a law relaxed by dynamics.
    for how in ["--solver auto", "--solver augmented-lagrangian", "--boundary free --solver cg"] {
        let half_space = contact.replace("--height 0.5", "");
        let trace = run(&format!("{half_space} {how} --history-point 0,0,z"))["history"].clone();
        let residual = numbers(&trace["residual"]);
        assert!(residual.len() > 4 && residual[0] > residual[residual.len() - 1], "{how}");
        assert!(trace["energy"][0].is_null() && trace["points"][0]["u"][0].is_null(), "{how}");
    }
    let law = "--law morse --param gamma=1e-4,range=4e-3 --solver fire2 --history-point 0,0,z --out l.h5";
    let report = run(&format!("{contact} {law}"));
    let points = numbers(&report["history"]["points"][0]["u"]);
    let u: Vec<f64> = Reader::open(folder.path().join("l.h5")).unwrap().values("/fields/displacement_z").unwrap();
    let approach = number(&report["loads"][0], "approach");
    assert_relative_eq!(points[points.len() - 1], u[0] + approach, epsilon = 1e-6 * approach);
}

/// The memory of a contact, beyond a small one by the same program, is bounded by 9.75 fields at any load; a stiffness
/// needs no more.
#[cfg(target_os = "linux")]
#[test]
fn memory_is_bounded_at_small_loads_and_large_ones() {
    let folder = tempfile::tempdir().unwrap();
    let peak = |n: u32, load: &str| {
        let flags = format!("contact --n {n} --hurst 0.8 --p-star {load} --threads 2 --json --quiet");
        number(&json(folder.path(), &flags.split_whitespace().collect::<Vec<_>>()), "peak_bytes")
    };
    for load in ["1e-4", "0.001", "0.01", "0.05", "0.3"] {
        let [small, large] = [64, 1024].map(|n| peak(n, load));
        let fields = (large - small) / (8.0 * (1024.0 * 1024.0 - 64.0 * 64.0));
        assert!(fields < 9.75, "{large} bytes at {load}: {fields} fields beyond {small} bytes");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_peak_memory_is_not_that_of_the_process_that_started_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let large = std::hint::black_box(vec![1_u8; 200 << 20]);
    let report = json(folder.path(), &["contact", "--n", "64", "--p-star", "0.01", "--json", "--quiet"]);
    let peak = number(&report, "peak_bytes");
    assert!(peak < large.len() as f64 / 2.0, "{peak}");
}

/// Returns all residuals of a record by name: `residual`, lower face, and equilibrium with a law.
fn residuals(record: &Value) -> Vec<(String, f64)> {
    let of = |part: &str, object: &Value| {
        let entries = object["residual"].as_object().unwrap();
        entries.iter().map(|(name, value)| (format!("{part}{name}"), value.as_f64().unwrap_or(f64::NAN))).collect()
    };
    let mut all: Vec<(String, f64)> = of("", record);
    if record["lower"].is_object() {
        all.extend(of("lower ", &record["lower"]));
    }
    all.extend(record["residual_equilibrium"].as_f64().map(|found| ("equilibrium".to_owned(), found)));
    all
}

/// A load has `converged` if and only if all its residuals are at most the tolerance: in JSON and in the file, for
/// every kind of contact, for searches that succeed and for searches that are cut off.
#[test]
fn converged_means_that_all_residuals_of_the_record_are_at_most_the_tolerance() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let kinds = [
        ("--p-star 0.05", "complementarity"),
        ("--approach 0.002", "penetration"),
        ("--p-star 0.05 --components held", "load"),
        ("--p-star 0.1 --hardness 0.03", "saturation"),
        ("--p-star 0.05 --finite-slope", "lateral_displacement"),
        ("--p-star 0.05 --components all --solver verlet", "lateral_traction"),
        ("--p-star 0.05 --law exponential --param gamma=1e-4,range=3e-3", "equilibrium"),
        ("--p-star 0.05 --law morse --param gamma=1e-4,range=3e-2", "equilibrium"),
        ("--p-star 0.05 --law exponential --param gamma=1e-4,range=3e-3 --boundary free", "equilibrium"),
        ("--p-star 0.05 --boundary free", "negative_pressure"),
        ("--p-star 0.1 --boundary free --hardness 0.03", "saturation"),
        ("--p-star 0.05 --height 0.3 --lower-seed 5", "lower complementarity"),
        ("--p-star 0.05 --height 0.3 --lower-seed 5 --solver preconditioned-cg", "lower load"),
    ];
    for (flags, name) in kinds {
        let mut outcomes = [false; 2];
        for (tolerance, iterations) in [(1e-3, 100_000), (1e-8, 100_000), (1e-8, 1), (1e-8, 4), (1e-8, 12), (1e-10, 30)]
        {
            let line = format!(
                "contact --n 16 --eps-f-inv 4 {flags} --tolerance {tolerance:e} --max-iterations {iterations} --json \
                 --quiet --out c.h5"
            );
            let output = gfmd(folder, &line.split_whitespace().collect::<Vec<_>>());
            let message = String::from_utf8_lossy(&output.stderr);
            let report: Value = match serde_json::from_slice(&output.stdout) {
                Ok(report) => report,
                // A search that ends before it has a contact has no record.
                Err(_) if output.status.code() == Some(1) => continue,
                Err(error) => panic!("{line}: {error}: {message}"),
            };
            let Some(record) = report["loads"].get(0) else { continue };
            let all = residuals(record);
            assert!(all.iter().any(|(found, _)| found == name), "{line}: {all:?}");
            let all_met = all.iter().all(|(_, residual)| *residual <= tolerance);
            assert_eq!(record["converged"], all_met, "{line}: {all:?}");
            assert_eq!(output.status.success(), all_met, "{line}: {message}");
            let file = Reader::open(folder.join("c.h5")).unwrap();
            assert_eq!(file.values::<f64>("/loads/converged").unwrap(), [f64::from(u8::from(all_met))], "{line}");
            let stored = file.names("/loads").into_iter().filter(|column| column.contains("residual_"));
            let stored: Vec<f64> =
                stored.map(|column| file.values::<f64>(&format!("/loads/{column}")).unwrap()[0]).collect();
            assert!(stored.len() >= 4);
            assert_eq!(stored.iter().all(|residual| *residual <= tolerance), all_met, "{line}: {stored:?}");
            outcomes[usize::from(all_met)] = true;
        }
        assert_eq!(outcomes, [true, true], "{flags}: a search that succeeds and one that does not");
    }
}
