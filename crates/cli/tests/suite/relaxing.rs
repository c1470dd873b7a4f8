//! Viscoelastic bodies along a path in time, from end to end.

use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_files::Reader;
use ndarray::Array2;
use serde_json::Value;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

/// Returns the reason why a command is refused, one line with status 2.
fn refused(folder: &Path, flags: &str) -> String {
    let output = gfmd(folder, &words(flags));
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), text.lines().count()), (Some(2), 1), "{flags}: {text}");
    text
}

fn list(value: &Value) -> String {
    value.as_array().unwrap().iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
}

#[test]
fn the_program_has_the_values_of_dense_solutions() {
    let folder = tempfile::tempdir().unwrap();
    let all: Value = serde_json::from_str(include_str!("../../../../data/reference/viscoelastic/path.json")).unwrap();
    // One relaxing in shear only with instantaneous moduli, one that parts and touches again, a profile.
    for problem in [3, 5, 6].map(|index| &all["problems"][index]) {
        let rows = problem["heights"].as_array().unwrap();
        let [nx, ny] = [rows.len(), rows[0].as_array().unwrap().len()];
        let at = |(i, j): (usize, usize)| problem["heights"][i][j].as_f64().unwrap();
        ndarray_npy::write_npy(folder.path().join("heights.npy"), &Array2::from_shape_fn((nx, ny), at)).unwrap();
        let sides = if ny == 1 { problem["length"][0].to_string() } else { list(&problem["length"]) };
        let branches: Vec<String> =
            problem["prony"].as_array().unwrap().iter().map(|pair| format!("{}:{}", pair[0], pair[1])).collect();
        let word = |key: &str| problem[key].as_str().unwrap();
        let height = problem["height"].as_f64().map_or("inf".to_owned(), |height| height.to_string());
        let flags = format!(
            "path --surface heights.npy --size {sides} --young {} --poisson {} --height {height} --prony {} \
             --moduli {} --relaxes {} --{} {} --time {} --steps {} --tolerance 1e-11 --json",
            problem["young"],
            problem["poisson"],
            branches.join(","),
            word("moduli"),
            word("relaxes"),
            word("control"),
            list(&problem["waypoints"]),
            list(&problem["time"]),
            problem["steps"],
        );
        let report = json(folder.path(), &words(&flags));
        let (steps, results) = (report["steps"].as_array().unwrap(), problem["results"].as_array().unwrap());
        assert_eq!(steps.len(), results.len());
        let largest = results.iter().map(|step| step["elastic_energy"].as_f64().unwrap()).fold(0.0, f64::max);
        for (step, result) in steps.iter().zip(results) {
            let keys = [
                ("time", 1e-3),
                ("mean_pressure", 1e-3),
                ("approach", 1e-3),
                ("area_fraction", 1e-3),
                ("max_pressure", 1e-3),
                ("elastic_energy", largest),
                ("dissipated", largest),
                ("work_imbalance", largest),
            ];
            for (key, floor) in keys {
                let [found, known] = [step, result].map(|step| step[key].as_f64().unwrap());
                assert!((found - known).abs() <= 1e-8 * known.abs().max(floor), "{key}: {found:e}, {known:e}");
            }
        }
        let known = if word("moduli") == "instantaneous" { "young_instantaneous" } else { "young_long_term" };
        approx::assert_relative_eq!(
            report[known].as_f64().unwrap(),
            problem["young"].as_f64().unwrap(),
            max_relative = 1e-14
        );
    }
}

#[test]
fn a_path_in_time_is_written_checked_drawn_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let base = ndarray::Array3::from_shape_fn((24, 24, 3), |(i, j, c)| 0.002 * ((i + 2 * j + c) as f64 * 0.5).sin());
    ndarray_npy::write_npy(folder.path().join("base.npy"), &base).unwrap();
    for (name, flags) in [
        ("both", "--boundary free"),
        ("shear", "--height 0.3 --poisson 0.3 --relaxes shear"),
        ("sliding-shear", "--height 0.3 --poisson 0.3 --relaxes shear --base sliding"),
        ("plate-shear", "--height 0.3 --poisson 0.3 --relaxes shear --base free --moduli instantaneous"),
        ("layers", "--height 0.1 --layer 0.5,0.3,0.2 --moduli instantaneous"),
        ("law", "--law exponential --param gamma=1e-4,range=4e-3"),
        ("law-shear", "--law npc --param phi_n=1e-4,delta_n=4e-3,phi_t=1e-4,delta_t=4e-3 --height 0.3 --relaxes shear"),
        (
            "law-lateral",
            "--law npc --param phi_n=1e-4,delta_n=4e-3,phi_t=1e-4,delta_t=4e-3 --lateral 0.001,0.002,0.003 \
             --height 0.3 --base-displacement base.npy",
        ),
        ("law-free", "--law dugdale --param gamma=1e-4,range=4e-3 --boundary free --flow"),
    ] {
        // The page of each has the figures; two are also drawn in files.
        let is_drawn = ["both", "law-free"].contains(&name);
        let plots = if is_drawn { format!("--plots {name}") } else { String::new() };
        let run = format!(
            "path --n 24 --eps-f-inv 6 {flags} --prony 0.1:0.3,10:0.4 --pressure 0.02,0.005,0.005 --time 1,0,20 \
             --steps 3 --out {name}.h5 {plots} --json"
        );
        let report = json(folder.path(), &words(&run));
        assert_eq!(report["steps"].as_array().unwrap().len(), 7);
        let file = Reader::open(folder.path().join(format!("{name}.h5"))).unwrap();
        let times: Vec<f64> = file.values("/path/time").unwrap();
        assert_eq!((times[2], times[3], times[6]), (1.0, 1.0, 21.0));
        assert_eq!(file.shape("/fields/pressure").unwrap(), [3, 24, 24]);
        let branches = match name {
            "sliding-shear" | "plate-shear" => 4,
            "shear" | "law-shear" => 6,
            _ => 2,
        };
        assert_eq!(file.shape("/history/branch").unwrap(), [branches, 24, 24]);
        let below: Vec<f64> = file.values("/history/displacement").unwrap();
        let last: Vec<f64> = file.slab("/fields/displacement_z", 2).unwrap();
        let lift = if file.contains("/base/lift") { file.values("/base/lift").unwrap() } else { vec![0.0; last.len()] };
        assert!(below.iter().zip(&last).zip(&lift).all(|((d, u), lift)| (d + u - lift).abs() <= 1e-15), "{name}");
        let checked = json(folder.path(), &["check", &format!("{name}.h5"), "--rerun", "--json"]);
        assert_eq!(checked["differing"], 0, "{name}");
        assert_eq!(folder.path().join(format!("{name}-path.svg")).exists(), is_drawn, "{name}");
        assert!(gfmd(folder.path(), &["report", &format!("{name}.h5")]).status.success());
    }
}

/// A contact is pressed for a day, then sheared within seconds: each leg has steps of its own.
#[test]
fn each_leg_may_have_a_number_of_steps() {
    let folder = tempfile::tempdir().unwrap();
    let rest =
        "--n 16 --eps-f-inv 4 --poisson 0.5 --prony 1:0.4 --pressure 0.01 --friction 0.3 --tolerance 1e-9 --json";
    let run = |flags: &str| json(folder.path(), &words(&format!("path {rest} {flags}")));
    let report = run("--time 0,86400,10 --lateral 0,0,1e-3 --steps 7,2,3 --out seal.h5 --plots seal");
    let times: Vec<f64> =
        report["steps"].as_array().unwrap().iter().map(|step| step["time"].as_f64().unwrap()).collect();
    // The first leg takes no time: it is one step.
    assert_eq!(times[..3], [0.0, 43200.0, 86400.0]);
    assert_eq!((times.len(), times[5]), (6, 86410.0));
    assert_eq!((report["sliding"].as_array().unwrap().len(), &report["sliding"][0]["leg"]), (1, &3.into()));

    let file = Reader::open(folder.path().join("seal.h5")).unwrap();
    assert_eq!(file.shape("/fields/pressure").unwrap(), [3, 16, 16]);
    assert!(file.text("/", "config").unwrap().contains("\nsteps = [7, 2, 3]\n"));
    let checked = json(folder.path(), &["check", "seal.h5", "--rerun", "--json"]);
    assert_eq!(checked["differing"], 0);
    assert!(gfmd(folder.path(), &["report", "seal.h5"]).status.success());
    let page = std::fs::read_to_string(folder.path().join("seal.html")).unwrap();
    for text in ["<dd>7, 2, 3</dd>", "leg 3, rising", "Shear against the step (an axis of time"] {
        assert!(page.contains(text), "{text}");
    }

    let of_steps = |flags: &str| {
        let mut steps = run(flags)["steps"].take();
        steps.as_array_mut().unwrap().iter_mut().for_each(|step| step["seconds"] = Value::Null);
        steps
    };
    let legs = "--time 1,1 --lateral 0,1e-3";
    assert_eq!(of_steps(&format!("{legs} --steps 2,2")), of_steps(&format!("{legs} --steps 2")));
}

#[test]
fn more_solves_make_steps_shorter_until_the_energy_balance_closes() {
    let folder = tempfile::tempdir().unwrap();
    let run = |solves: u32| {
        let run = format!(
            "path --n 24 --eps-f-inv 6 --prony 1:0.8 --pressure 0.01 --time 0,10 --steps 2 --energy-solves {solves} \
             --json"
        );
        json(folder.path(), &words(&run))
    };
    let [long, short] = [0, 64].map(run);
    let error = |report: &Value| report["work_imbalance"].as_f64().unwrap();
    assert_eq!(long["extra_solves"], 0);
    assert!(short["extra_solves"].as_u64().unwrap() > 0 && error(&short) < 0.2 * error(&long));
}

#[test]
fn unusable_input_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = |flags: &str| refused(folder.path(), &format!("path --n 24 --eps-f-inv 4 --pressure 0.01 {flags}"));
    for (flags, words) in [
        ("--prony 1:0.5", "--time is missing; it is needed with --prony"),
        ("--time 1", "--time is given; it must be left out without --prony"),
        ("--prony 0:0.5 --time 1", "--prony: a relaxation time is 0; it must be positive and finite"),
        ("--prony 1:0 --time 1", "--prony: a fraction of the modulus is 0; it must be above 0 and below 1"),
        ("--prony 1:0.5,1:0.2 --time 1", "--prony: two branches have the relaxation time 1; their times must differ"),
        ("--prony 1:0.6,2:0.5 --time 1", "they must leave a long-term modulus, and add up to less than 1"),
        ("--prony 1 --time 1", "it must be TAU:G"),
        ("--prony 1:0.5 --time -1", "--time is -1; it must be finite and not negative"),
        ("--prony 1:0.5 --time inf", "--time is inf; it must be finite and not negative"),
        ("--moduli instantaneous", "--prony"),
        ("--relaxes shear", "--prony"),
        (
            "--prony 1:0.5 --time 1 --relaxes shear --e-star 1",
            "--e-star is 1; it must be left out with --relaxes shear",
        ),
        (
            "--prony 1:0.5 --time 1 --relaxes shear --height 0.2 --base sliding --boundary free",
            "it must be periodic with --relaxes shear",
        ),
        (
            "--prony 1:0.5 --time 1 --relaxes shear --friction 0.3",
            "--friction is given; it must be left out with --relaxes shear",
        ),
    ] {
        let found = path(flags);
        assert!(found.contains(words), "{flags}: {found}");
    }
    let two = "path --n 24 --pressure 0.01,0.02,0.03 --prony 1:0.5 --time 1,2";
    assert!(refused(folder.path(), two).contains("--time has 2 waypoints; it must have 1 or 3"));
    for (flags, found) in [
        ("--time 1 --steps 2,3", "--steps has 2 numbers; it must have 1 or 3, one for each leg"),
        ("--time 1 --steps 1,2,3,4", "--steps has 4 numbers; it must have 1 or 3, one for each leg"),
        ("--time 1 --steps 1,0,3", "0 is not in 1..="),
        ("--time 1 --steps 1,999999,1", "--steps is 1,999999,1, in all 1000001 for 3 waypoints; it must be at most"),
    ] {
        let text = refused(folder.path(), &format!("path --n 24 --pressure 0.01,0.02,0.03 --prony 1:0.5 {flags}"));
        assert!(text.contains(found), "{flags}: {text}");
    }
    let elastic = refused(folder.path(), "path --n 24 --pressure 0.01,0.02,0.03 --steps 1,2,3");
    assert!(elastic.contains("--steps has 3 numbers; it must have 1 or 2, one for each leg"), "{elastic}");
    let one = refused(folder.path(), "path --n 24 --pressure 0.01 --steps 1,2");
    assert!(one.contains("--steps has 2 numbers; it must have 1"), "{one}");
    refused(folder.path(), "contact --n 24 --pressure 0.01 --prony 1:0.5");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Initially the body is elastic with the instantaneous modulus, and after a long time with the long-term modulus.
#[test]
fn the_leak_along_a_path_is_that_of_the_contacts_it_goes_through() {
    let folder = tempfile::tempdir().unwrap();
    let of = |flags: &str| json(folder.path(), &words(&format!("{flags} --n 32 --eps-f-inv 6 --pressure 0.01 --json")));
    let creep = of("path --prony 1:0.5 --time 0,1e6 --steps 40 --flow --out f.h5");
    let steps = creep["steps"].as_array().unwrap();
    let [first, last] = [&steps[0], &steps[steps.len() - 1]].map(|step| &step["flow"]);
    for (found, modulus) in [(first, 2.0), (last, 1.0)] {
        let flow = &of(&format!("contact --e-star {modulus} --flow"))["loads"][0]["flow"];
        assert_eq!(found["percolates"], flow["percolates"]);
        for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let [found, known] = [found, flow].map(|flow| flow["conductivity"][row][column].as_f64().unwrap());
            assert!((found - known).abs() < 1e-5, "{modulus} {row}{column}: {found} {known}");
        }
    }
    assert!(first["conductivity"][0][0].as_f64() > last["conductivity"][0][0].as_f64());
    let worn = of("wear --coefficient 1 --distance 0,0.1 --steps 1 --flow --out w.h5");
    let known = &of("contact --e-star 1 --flow")["loads"][0]["flow"]["conductivity"][1][1];
    let found = &worn["steps"][0]["flow"]["conductivity"][1][1];
    assert!((found.as_f64().unwrap() - known.as_f64().unwrap()).abs() < 1e-5, "{found} {known}");
    let changed = |file: &str| json(folder.path(), &["check", file, "--json"])["differing"].clone();
    assert!(changed("f.h5") == 0 && changed("w.h5") == 0);
    let refused = refused(folder.path(), "path --dim 2 --n 32 --pressure 0.01 --flow");
    assert!(refused.contains("a profile has no flow"), "{refused}");
}

#[test]
fn times_with_units_are_seconds() {
    let folder = tempfile::tempdir().unwrap();
    let of = |times: &str| {
        let problem = "path --n 16 --eps-f-inv 4 --unit um --young 2MPa --poisson 0.5 --p-star 0.05 --steps 1 --json";
        let mut report = json(folder.path(), &words(&format!("{problem} {times}")));
        report["steps"].as_array_mut().unwrap().iter_mut().for_each(|step| step["seconds"] = 0.into());
        report["steps"].clone()
    };
    let bare = of("--prony 0.01:0.3,7200:0.4 --time 0,60,86400");
    assert_eq!(of("--prony 10ms:0.3,2h:0.4 --time 0,1min,1d"), bare);
    assert_eq!(bare[2]["time"], 86460.0);
    let refusal = refused(folder.path(), "path --n 16 --prony 10ms:0.3 --pressure 0.01 --time 1");
    assert!(refusal.contains("the lengths have none"), "{refusal}");
}

/// Returns the energy of a law per area at a gap, zero far away.
fn energy_of_law(law: &str, [gamma, range]: [f64; 2], gap: f64) -> f64 {
    let e = (-gap / range).exp();
    match law {
        "dugdale" => gamma * (gap / range - 1.0).min(0.0),
        "exponential" => -gamma * e,
        "morse" => gamma * e * (e - 2.0),
        "xu-needleman" => -gamma * (1.0 + gap / range) * e,
        other => panic!("{other}"),
    }
}

/// Returns the loss of a leg of zero time from the fields at its waypoints, and its largest error for forces that
/// change monotonically in each leg. The loss is the work of the load by the trapezoidal rule over many legs, minus the
/// work of the pressure on the body at fixed branch strains, minus the change of the energy of the law.
fn loss_of_legs(file: &Reader, report: &Value, first: usize, energy: &dyn Fn(f64) -> f64) -> [f64; 2] {
    let steps = report["steps"].as_array().unwrap();
    let number = |k: usize, name: &str| steps[k][name].as_f64().unwrap();
    let last = steps.len() - 1;
    let [mut work, mut spread] = [0.0; 2];
    for k in first..last {
        let moved = number(k + 1, "approach") - number(k, "approach");
        work += 0.5 * (number(k + 1, "mean_pressure") + number(k, "mean_pressure")) * moved;
        spread += 0.5 * ((number(k + 1, "mean_pressure") - number(k, "mean_pressure")) * moved).abs();
    }
    let field = |name: &str, k: usize| file.slab::<f64>(&format!("/fields/{name}"), k).unwrap();
    // Waypoints and steps coincide.
    let [p, q] = [first, last].map(|k| field("pressure", k));
    let [u, v] = [first, last].map(|k| field("displacement_z", k));
    let points = p.len() as f64;
    let stored: f64 = (0..p.len()).map(|i| 0.5 * (p[i] + q[i]) * (u[i] - v[i])).sum::<f64>() / points;
    let law = |k: usize| field("gap", k).into_iter().map(energy).sum::<f64>() / points;
    [work - stored - (law(last) - law(first)), spread]
}

/// Random legs of zero time, alone and after a leg in which the body relaxes, with laws that are smooth or have a jump
/// of the traction.
#[test]
fn a_leg_of_no_time_loses_the_energy_that_the_balance_of_work_and_energy_misses() {
    let folder = tempfile::tempdir().unwrap();
    let mut seed = 7_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (dugdale, smooth) = if crate::common::long() { (30, 30) } else { (4, 1) };
    let cases = ["dugdale", "exponential", "morse", "xu-needleman"];
    let mut wrong = Vec::new();
    let mut largest: f64 = 0.0;
    for law in cases {
        for case in 0..if law == "dugdale" { dugdale } else { smooth } {
            let range = 4e-3 + 8e-3 * random();
            let gamma = range * (0.02 + 0.06 * random());
            let [start, end] = if random() < 0.5 { [0.004 * random(), -0.03] } else { [-0.03, 0.004 * random()] };
            let relaxed = random() < 0.5;
            let parameters = match law {
                "xu-needleman" => format!("phi_n={gamma},phi_t={gamma},delta_n={range},delta_t={range}"),
                _ => format!("gamma={gamma},range={range}"),
            };
            let common = format!(
                "path --n 24 --dim 2 --eps-f-inv 4 --seed {case} --law {law} --param {parameters} --prony 1:0.4 \
                 --steps 1 --json"
            );
            let way = |legs: u32| -> String {
                let places = (1..=legs).map(|k| start + (end - start) * f64::from(k) / f64::from(legs));
                let places: Vec<String> = [start, start].into_iter().chain(places).map(|d| d.to_string()).collect();
                let times: Vec<&str> = (0..places.len()).map(|k| if k == 1 && relaxed { "3" } else { "0" }).collect();
                format!("--approach={} --time {}", places.join(","), times.join(","))
            };
            let many = json(folder.path(), &words(&format!("{common} {} --out many.h5", way(150))));
            let file = Reader::open(folder.path().join("many.h5")).unwrap();
            let [loss, spread] = loss_of_legs(&file, &many, 1, &|gap| energy_of_law(law, [gamma, range], gap));
            largest = largest.max(loss);
            for solves in [0, 40] {
                let one = json(folder.path(), &words(&format!("{common} {} --energy-solves {solves}", way(1))));
                let step = &one["steps"][2];
                let [lost, error] =
                    ["dissipated", "dissipated_error"].map(|key| step[key].as_f64().unwrap_or(f64::NAN));
                let is_right = (lost - loss).abs() <= error + spread;
                if !is_right {
                    wrong.push(format!("{law} {case}, {solves}: {lost:e} +- {error:e}, right {loss:e} +- {spread:e}"));
                }
            }
        }
    }
    assert!(largest > 1e-6, "{largest:e}");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Loss of a held leg with two numbers of steps, and with many steps.
#[test]
fn the_error_of_a_loss_is_that_of_the_loss_or_there_is_none() {
    let folder = tempfile::tempdir().unwrap();
    let run = |steps: u32, solves: u32| {
        let run = format!(
            "path --n 24 --dim 2 --eps-f-inv 6 --prony 0.1:0.3,1:0.5 --pressure 0.02,0.02,0.004 --time 0.5,2,0.7 \
             --steps {steps} --energy-solves {solves} --json"
        );
        json(folder.path(), &words(&run))
    };
    // Sum over a leg, from the first step on: the first leg begins without load.
    let leg = |report: &Value, key: &str, steps: usize, leg: usize| -> Option<f64> {
        let of_leg = &report["steps"].as_array().unwrap()[leg * steps..(leg + 1) * steps];
        of_leg.iter().map(|step| step[key].as_f64()).sum()
    };
    let reference = run(256, 0);
    assert!(reference["dissipated_error"].is_null() && reference["work_imbalance"].as_f64().unwrap() > 0.0);
    let reasons = reference["steps"][1]["undefined"].as_object().unwrap();
    let of_error = |columns: &Value| columns.as_array().unwrap().iter().any(|column| column == "dissipated_error");
    let reason = reasons.iter().find(|(_, columns)| of_error(columns)).unwrap().0;
    assert!(reason.contains("--energy-solves"), "{reason}");
    for steps in [1, 2, 5] {
        let report = run(steps, 4);
        for number in 0..3 {
            let right = leg(&reference, "dissipated", 256, number).unwrap();
            let of = |key: &str| leg(&report, key, steps as usize, number).unwrap();
            let [lost, error] = [of("dissipated"), of("dissipated_error")];
            assert!(
                (lost - right).abs() <= error,
                "{steps} steps, leg {number}: {lost:e} +- {error:e}, right {right:e}"
            );
            assert!(error < 0.3 * right, "{steps} steps, leg {number}: {error:e} of {right:e}");
        }
    }
    // Without further solves, or with too few, no path with half the increments is followed.
    assert!(run(2, 0)["steps"][1]["dissipated_error"].is_null());
}
