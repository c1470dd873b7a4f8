//! `law`, `contact --law` and `path` from end to end.

use crate::common::{gfmd, json};
use gfmd_files::Reader;
use serde_json::Value;

fn run(folder: &std::path::Path, flags: &str) -> Value {
    json(folder, &flags.split_whitespace().chain(["--json", "-q"]).collect::<Vec<_>>())
}

fn number(value: &Value, key: &str) -> f64 {
    value[key].as_f64().unwrap_or_else(|| panic!("no number {key} in {value}"))
}

#[test]
fn law_prints_the_table_of_the_theory_note() {
    let folder = tempfile::tempdir().unwrap();
    let separation = "--param phi_n=1 --param phi_t=0.8 --param delta_n=0.2 --param delta_t=0.3";
    let at = |flags: &str| run(folder.path(), &format!("law {flags}"))["points"][0].clone();
    let near = |point: &Value, wanted: [f64; 6]| {
        let [t, j] = [&point["traction"], &point["jacobian"]];
        let found = [&t[0], &t[1], &j[0][0], &j[0][1], &j[1][0], &j[1][1]].map(|value| value.as_f64().unwrap());
        for (found, wanted) in found.into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 1e-8, "{found} {wanted}");
        }
    };
    // An xu-needleman law with q = 0.7 has φ_t = 0.7.
    let xn =
        at("--law xu-needleman --param phi_n=1,phi_t=0.7,delta_n=0.2,delta_t=0.3,r=0.2 --normal 0.1 --tangential 0.15");
    near(&xn, [1.256_383_692, 1.594_237_116, 6.785_033_861, -3.050_700_653, -3.050_700_653, 5.314_123_718]);
    assert!(xn["energy"].is_number());
    let npb = at(&format!("--law npb {separation} --normal=-0.1 --tangential 0.15"));
    near(&npb, [-4.121_803_177, 3.424_067_778, 61.827_047_65, 0.0, -17.120_338_89, 11.413_559_26]);
    assert!(npb["energy"].is_null());
    let report =
        run(folder.path(), &format!("law --law bsg {separation} --normal 0.1,0.2 --tangential 0.15,-0.1 --plot b"));
    assert_eq!(report["points"].as_array().unwrap().len(), 2);
    assert_eq!(report["mixed_mode"]["resists_sliding"], false);
    assert!(folder.path().join("b.svg").exists() && folder.path().join("b.png").exists());
}

#[test]
fn an_adhesive_contact_holds_under_tension_and_is_kept_in_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "contact --n 64 --eps-f-inv 8 --law exponential --param gamma=2e-5 --param range=1.2e-3 \
                 --pressure 0.005,0,-0.0001";
    let report = run(folder.path(), &format!("{flags} --out a.h5 --plots a"));
    let loads = report["loads"].as_array().unwrap();
    for (load, asked) in loads.iter().zip([0.005, 0.0, -0.0001]) {
        assert!((number(load, "mean_pressure") - asked).abs() < 1e-9);
        assert_eq!(load["converged"], true);
        assert!(number(load, "residual_equilibrium") <= 1e-8 && number(load, "lowest_curvature") > 0.0);
    }
    assert!(number(&loads[1], "area_fraction") > 0.0, "adhesion holds without a load");
    // Without adhesion the contact area is smaller.
    let wall = run(folder.path(), "contact --n 64 --eps-f-inv 8 --pressure 0.005");
    assert!(number(&wall["loads"][0], "area_fraction") < number(&loads[0], "area_fraction"));
    assert!(wall["loads"][0]["interface_energy"].is_null());
    let file = Reader::open(folder.path().join("a.h5")).unwrap();
    let pressure: Vec<f64> = file.slab("/fields/pressure", 1).unwrap();
    assert!(pressure.iter().any(|p| *p < 0.0) && pressure.iter().sum::<f64>().abs() < 1e-6);
    let energy: Vec<f64> = file.values("/loads/interface_energy").unwrap();
    assert_eq!(energy[0].to_bits(), number(&loads[0], "interface_energy").to_bits());
    assert!(folder.path().join("a-map.png").exists());
    // Dynamics reaches this state, too.
    let slow = run(folder.path(), &flags.replace(" --pressure 0.005,0,-0.0001", " --pressure 0.005 --solver fire"));
    let [a, b] = [&slow["loads"][0], &loads[0]].map(|load| number(load, "mean_gap"));
    assert!((a - b).abs() < 1e-7 * b, "{a} {b}");
}

/// Writes a table of the exponential law to a file.
fn write_table(folder: &std::path::Path, name: &str, heads: &str, [gap_unit, stress_unit]: [f64; 2]) {
    let (gamma, range) = (2e-5, 1.2e-3);
    let mut text = format!("{heads}\n");
    for k in 0..=200 {
        let x = f64::from(k) / 200.0;
        let gap = range * (25.0 * x * x * x + 2.0 * x);
        let traction = if k == 200 { 0.0 } else { gamma / range * (-gap / range).exp() };
        text += &format!("{:e},{:e}\n", gap / gap_unit, traction / stress_unit);
    }
    std::fs::write(folder.join(name), text).unwrap();
}

#[test]
fn a_law_from_a_table_is_kept_in_the_file_and_gives_the_numbers_of_the_law_it_is_of() {
    let folder = tempfile::tempdir().unwrap();
    write_table(folder.path(), "law.csv", "gap,traction", [1.0, 1.0]);
    let problem = "--n 64 --eps-f-inv 8";
    let law = "--law exponential --param gamma=2e-5,range=1.2e-3";
    let [wanted, found] = [law, "--law table --law-table law.csv"]
        .map(|law| run(folder.path(), &format!("contact {problem} {law} --pressure 0.005,-0.0001 --out a.h5")));
    for (found, wanted) in found["loads"].as_array().unwrap().iter().zip(wanted["loads"].as_array().unwrap()) {
        for name in ["approach", "mean_gap", "elastic_energy", "interface_energy", "max_pressure"] {
            let [found, wanted] = [found, wanted].map(|load| number(load, name));
            assert!((found / wanted - 1.0).abs() < 1e-4, "{name}: {found} {wanted}");
        }
        assert_eq!(found["area_fraction"], wanted["area_fraction"]);
    }
    for (name, wanted) in wanted["adhesion"].as_object().unwrap() {
        let (found, wanted) = (number(&found["adhesion"], name), wanted.as_f64().unwrap());
        assert!((found / wanted - 1.0).abs() < 1e-2, "{name}: {found} {wanted}");
    }
    // The file has the rows: the table is no longer needed.
    std::fs::remove_file(folder.path().join("law.csv")).unwrap();
    for command in ["check a.h5", "check a.h5 --rerun"] {
        assert_eq!(run(folder.path(), command)["differing"], 0);
    }
    let config: toml::Table =
        Reader::open(folder.path().join("a.h5")).unwrap().text("/", "config").unwrap().parse().unwrap();
    assert_eq!(config["law_table"].as_array().unwrap().len(), 201);
    assert!(gfmd(folder.path(), &["report", "a.h5", "-q"]).status.success());
    // Resumed path, and longer ranges first.
    write_table(folder.path(), "law.csv", "gap,traction", [1.0, 1.0]);
    let path = format!("path {problem} --law table --law-table law.csv --pressure 0.005,-0.0001 --steps 2");
    let whole = run(folder.path(), &format!("{path} --out p.h5"));
    assert_eq!(run(folder.path(), "check p.h5 --rerun")["differing"], 0);
    let again = run(folder.path(), &format!("{path} --out p.h5 --resume"));
    for (again, whole) in again["steps"].as_array().unwrap().iter().zip(whole["steps"].as_array().unwrap()) {
        assert_eq!((&again["approach"], &again["mean_gap"]), (&whole["approach"], &whole["mean_gap"]));
    }
    let walked = run(
        folder.path(),
        &format!("contact {problem} --law table --law-table law.csv --range-continuation --pressure 0.005"),
    );
    assert!((number(&walked["loads"][0], "approach") / number(&found["loads"][0], "approach") - 1.0).abs() < 1e-6);
}

#[test]
fn a_table_has_units_by_its_heads_and_is_refused_by_what_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    let problem = "contact --n 32 --eps-f-inv 4 --unit um --size 1um --young 1Pa --pressure 0.005Pa --law table";
    write_table(folder.path(), "bare.csv", "gap,traction", [1.0, 1.0]);
    write_table(folder.path(), "nano.csv", "gap [nm],traction [MPa]", [1e-3, 1e6]);
    let [bare, nano] = ["bare", "nano"].map(|name| run(folder.path(), &format!("{problem} --law-table {name}.csv")));
    for name in ["approach", "interface_energy"] {
        let [bare, nano] = [&bare, &nano].map(|report| number(&report["loads"][0], name));
        assert!((bare / nano - 1.0).abs() < 1e-9, "{name}: {bare} {nano}");
    }
    // A page folds the rows of a long table.
    run(folder.path(), &format!("{problem} --law-table bare.csv --out bare.h5"));
    run(folder.path(), "report bare.h5");
    let page = std::fs::read_to_string(folder.path().join("bare.html")).unwrap();
    assert_eq!(page.matches("<details><summary>Show all ").count(), 2);
    // `law` draws a table in its own units.
    let drawn = run(folder.path(), "law --law table --law-table nano.csv --normal 0,1.2 --plot t");
    assert!((drawn["points"][0]["traction"][0].as_f64().unwrap() / (2e-5 / 1.2e-3 / 1e6) - 1.0).abs() < 1e-12);
    assert_eq!(drawn["wall"], true);
    assert!(folder.path().join("t.svg").exists());
    assert_eq!([&drawn["unit"], &drawn["stress_unit"]].map(|unit| unit.as_str()), [Some("nm"), Some("MPa")]);
    let figure = std::fs::read_to_string(folder.path().join("t.svg")).unwrap();
    assert!(figure.contains("/ nm") && figure.contains("/ MPa"), "{figure}");
    // The same law in other units, and with a quantity.
    let other = run(folder.path(), "law --law table --law-table nano.csv --unit um --stress-unit Pa --normal 0,1.2nm");
    for (one, other) in [0, 1].map(|k| [&drawn, &other].map(|report| &report["points"][k])).map(|[a, b]| (a, b)) {
        let ratio =
            |one: &serde_json::Value, other: &serde_json::Value| other.as_f64().unwrap() / one.as_f64().unwrap();
        assert!((ratio(&one["traction"][0], &other["traction"][0]) / 1e6 - 1.0).abs() < 1e-9);
        assert!((ratio(&one["energy"], &other["energy"]) / 1e3 - 1.0).abs() < 1e-9);
    }
    let table = gfmd(folder.path(), &["law", "--law", "table", "--law-table", "nano.csv", "--normal", "0"]);
    let table = String::from_utf8(table.stdout).unwrap();
    assert!(table.contains("nm"), "{table}");
    assert!(table.contains("MPa/nm"), "{table}");
    assert!(table.contains("MPa*nm"), "{table}");
    for (name, text) in [
        ("order.csv", "0,1\n2,0.5\n1,0.2\n3,0\n"),
        ("end.csv", "0,1\n1,0.5\n2,0.2\n3,0.1\n"),
        ("words.csv", "0,1\n1,x\n"),
        ("kind.csv", "gap [nm],traction [nm]\n0,1\n1,0.5\n2,0.2\n3,0\n"),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    let before = std::fs::read_dir(folder.path()).unwrap().count();
    for (flags, words) in [
        ("--law table --law-table none.csv", &["--law-table", "none.csv"][..]),
        ("--law table --law-table order.csv", &["--law-table", "row 3 begins with 1", "above"]),
        ("--law table --law-table end.csv", &["--law-table", "largest gap", "1e-1", "it must be 0"]),
        ("--law table --law-table words.csv", &["--law-table", "line 2", "1,x"]),
        ("--law table --law-table 0:1,1:0.5,2:0", &["--law-table", "3 rows", "at least 4"]),
        ("--law table --law-table 0.5:1,1:0.5,2:0.2,3:0", &["--law-table", "smallest gap is 5e-1"]),
        ("--law table --law-table=-1:1,1:0.5,2:0.2,3:0", &["--law-table", "smallest gap", "a repulsion"]),
        ("--law table", &["--law-table", "needs its rows"]),
        ("--law table --param gamma=1 --law-table order.csv", &["--param", "gamma", "left out"]),
        ("--law-table end.csv", &["--law-table", "hard-wall", "--law table"]),
        ("--unit um --young 1Pa --law table --law-table kind.csv", &["--law-table", "a stress"]),
        ("--law table --law-table nano.csv", &["--law-table", "--unit"]),
    ] {
        let flags = format!("contact --n 16 --eps-f-inv 4 --p-star 0.1 {flags} -q");
        let output = gfmd(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{flags}: {text}");
        for word in words {
            assert!(text.contains(word), "{flags}: no {word:?} in {text}");
        }
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), before);
}

#[test]
fn surfaces_that_part_are_a_failure_of_the_computation() {
    let folder = tempfile::tempdir().unwrap();
    let flags =
        "contact --n 32 --eps-f-inv 4 --law exponential --param gamma=1e-5,range=3e-3 --pressure 0.001,-1 -q --json";
    let output = gfmd(folder.path(), &flags.split_whitespace().collect::<Vec<_>>());
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("load 1: the surfaces part"));
    let report: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(report["loads"][0]["converged"], true);
    let units = "contact --n 32 --eps-f-inv 4 --size 1um --young 1GPa --law exponential --pressure -1GPa \
                 --param gamma=0.01J/m^2,range=3nm -q";
    let output = gfmd(folder.path(), &units.split_whitespace().collect::<Vec<_>>());
    let error = String::from_utf8_lossy(&output.stderr);
    assert!(error.contains("load 0: the surfaces part under a mean pressure of -1 GPa:"), "{error}");
    // On a path, separation is not a failure but ends the path.
    let path = run(
        folder.path(),
        "path --n 32 --eps-f-inv 4 --law exponential --param gamma=1e-5,range=3e-3 --pressure 0.001,-1 --steps 4",
    );
    assert_eq!(path["parted_at"].as_u64().unwrap() as usize, path["steps"].as_array().unwrap().len());
}

#[test]
fn a_closed_adhesive_loop_loses_energy_by_its_jumps_alone() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "path --n 128 --dim 2 --eps-f-inv 8 --law exponential --param gamma=2e-4,range=2e-3 \
                 --approach=-0.006,0.002,-0.012";
    let report = run(folder.path(), &format!("{flags} --steps 8 --energy-solves 20 --out l.h5 --plots l"));
    let [lost, error] = ["dissipated", "dissipated_error"].map(|name| number(&report, name));
    assert!(lost > 20.0 * error && error > 0.0, "{lost:e} +- {error:e}");
    let steps = report["steps"].as_array().unwrap();
    for (total, name) in
        [(lost, "dissipated"), (error, "dissipated_error"), (number(&report, "extra_solves"), "extra_solves")]
    {
        let sum: f64 = steps.iter().map(|step| number(step, name)).sum();
        assert!((sum - total).abs() <= 1e-12 * total.abs(), "{name}");
    }
    for step in steps {
        assert!(number(step, "dissipated") >= -number(step, "dissipated_error"), "{step}");
        assert!(step["stick_fraction"].is_null());
        // Energy lost beyond the error is lost in a jump.
        if number(step, "dissipated") > number(step, "dissipated_error") {
            assert_eq!(step["passed_instability"], true, "{step}");
        }
    }
    assert!(steps.iter().any(|step| step["passed_instability"] == true));
    // The loss does not depend on the requested number of steps; the trapezoidal loss does.
    let finer = run(folder.path(), &format!("{flags} --steps 16 --energy-solves 20"));
    assert!((number(&finer, "dissipated") - lost).abs() <= error + number(&finer, "dissipated_error"));
    let bare = run(folder.path(), &format!("{flags} --steps 8 --energy-solves 0"));
    assert!((number(&bare, "dissipated") - lost).abs() > 10.0 * error && number(&bare, "extra_solves") == 0.0);

    let file = Reader::open(folder.path().join("l.h5")).unwrap();
    for name in ["dissipated", "dissipated_error"] {
        let stored: f64 = file.values::<f64>(&format!("/path/{name}")).unwrap().iter().sum();
        assert!((stored - number(&report, name)).abs() <= 1e-12 * lost);
    }
    // The map shows the largest contact, where the first leg ends, not the open surfaces at the end.
    let shorter = flags.replace(",-0.012", "");
    run(folder.path(), &format!("{shorter} --steps 8 --energy-solves 20 --plots s"));
    let [whole, first_leg] =
        ["l-map.svg", "s-map.svg"].map(|name| std::fs::read_to_string(folder.path().join(name)).unwrap());
    assert!(whole == first_leg && number(&steps[8], "area_fraction") > 0.1);
}

#[test]
fn the_table_of_a_path_has_the_columns_that_apply() {
    let folder = tempfile::tempdir().unwrap();
    let table = |flags: &str| {
        let output = gfmd(folder.path(), &flags.split_whitespace().chain(["-q", "--wide"]).collect::<Vec<_>>());
        assert!(output.status.success(), "{flags}");
        String::from_utf8(output.stdout).unwrap()
    };
    let columns = |text: &str| {
        let head = text.lines().find(|line| line.trim_start().starts_with("pressure")).unwrap();
        head.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let surface = "path --n 32 --dim 2 --eps-f-inv 4 --steps 1";
    let adhesive = table(&format!("{surface} --law exponential --param gamma=1e-5,range=3e-3 --approach 0.001,0.002"));
    assert_eq!(
        columns(&adhesive),
        "pressure p* approach area mean gap stiffness steps pairs elastic interface dissipated +- residual"
    );
    let slip = table(&format!("{surface} --p-star 0.05 --friction 0.3 --lateral 0,0.001"));
    assert_eq!(
        columns(&slip),
        "pressure p* approach lateral x shear x area stick mean gap stiffness increments steps pairs elastic \
         dissipated +- residual"
    );
    let cohesive = "--law npb --param phi_n=1e-4,phi_t=8e-5,delta_n=0.01,delta_t=0.01 --height 0.5 --approach 0.002";
    let cohesive = table(&format!("{surface} {cohesive} --lateral 0,0.001"));
    assert_eq!(
        columns(&cohesive),
        "pressure p* approach lateral x shear x area mean gap stiffness steps pairs elastic residual"
    );
    assert!(cohesive.contains("no dissipated energy"));
    for text in [adhesive, slip, cohesive] {
        assert!(!text.contains("NaN"), "{text}");
    }
}

#[test]
fn a_path_of_friction_sticks_slips_and_turns() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "path --n 128 --dim 2 --eps-f-inv 4 --poisson 0.5 --p-star 0.05 --friction 0.3 \
                 --lateral 0,0.004,-0.004 --steps 4";
    let report = run(folder.path(), &format!("{flags} --out p.h5 --plots p"));
    let steps = report["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 9);
    let shear: Vec<f64> = steps.iter().map(|step| step["mean_shear"][0].as_f64().unwrap()).collect();
    assert!(
        shear[..5].windows(2).all(|pair| pair[1] >= pair[0]) && shear[4..].windows(2).all(|pair| pair[1] <= pair[0])
    );
    let most = 0.3 * number(&steps[4], "mean_pressure");
    assert!(shear.iter().all(|shear| shear.abs() <= most * (1.0 + 1e-9)));
    let stick = |step: &Value| number(step, "stick_fraction");
    assert!(stick(&steps[4]) < stick(&steps[1]) && stick(&steps[5]) > stick(&steps[4]));
    assert!(number(&report, "dissipated") > 0.0);
    // The stiffness of a leg belongs to its first step; the second leg slides at its end.
    let sliding = report["sliding"].as_array().unwrap();
    assert_eq!([&sliding[0]["leg"], &sliding[1]["leg"]], [1, 2]);
    let first = shear[1] - shear[0];
    assert!((number(&sliding[0], "tangential_stiffness") - first / 0.001).abs() < 1e-9 * first / 0.001);
    assert!(number(&sliding[1], "tangential_stiffness") > 0.0);
    let coefficient = sliding.iter().map(|leg| number(leg, "friction_coefficient")).fold(0.0, f64::max);
    assert!(
        (shear[8].abs() / number(&steps[8], "mean_pressure") - coefficient).abs() < 1e-9 && coefficient <= 0.3 + 1e-9
    );
    for step in steps {
        assert_eq!(step["converged"], true);
        assert!(number(&step["residual"], "friction") <= 1e-8);
    }
    let file = Reader::open(folder.path().join("p.h5")).unwrap();
    let stored: Vec<f64> = file.values("/path/mean_shear_x").unwrap();
    assert_eq!(stored, shear);
    assert_eq!(file.shape("/fields/shear_x").unwrap(), [3, 128, 1]);
    assert!(folder.path().join("p-path.svg").exists() && folder.path().join("p-map.svg").exists());
}

#[test]
fn a_load_with_friction_is_divided_until_it_changes_nothing_or_the_path_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let flags =
        "path --n 64 --dim 2 --eps-f-inv 4 --poisson 0.2 --p-star 0.05 --friction 0.3 --lateral 0,0.004 --steps 2";
    let report = run(folder.path(), &format!("{flags} --out f.h5"));
    let first = &report["steps"][0];
    assert!(number(first, "increments") > 2.0 && number(first, "extra_solves") > number(first, "increments"));
    assert!(number(first, "dissipated_error") > 0.0 && first["passed_instability"].is_null());
    let stored: Vec<f64> = Reader::open(folder.path().join("f.h5")).unwrap().values("/path/increments").unwrap();
    assert_eq!(stored[0], number(first, "increments"));
    assert_eq!(run(folder.path(), "check f.h5 --rerun")["differing"], 0);
    let codes = |report: &Value| -> Vec<String> {
        report["warnings"]
            .as_array()
            .unwrap()
            .iter()
            .map(|reported| reported["code"].as_str().unwrap().into())
            .collect()
    };
    assert!(!codes(&report).contains(&"increments".into()), "{report}");
    // The load alone, in more steps, ends where the single step did; in one increment it does not.
    let finer = flags.replace("0.05", "0.01,0.05").replace(" --lateral 0,0.004", "");
    let finer = run(folder.path(), &finer.replace("--steps 2", "--steps 6"));
    let single = run(folder.path(), &format!("{flags} --energy-solves 0"));
    assert!(codes(&single).contains(&"increments".into()), "{single}");
    let stick = |step: &Value| number(step, "stick_fraction") / number(step, "area_fraction");
    let [divided, wanted, undivided] = [first, &finer["steps"][6], &single["steps"][0]].map(stick);
    assert!((divided - wanted).abs() < 0.3 * (undivided - wanted).abs(), "{divided} {wanted} {undivided}");
}

#[test]
fn a_path_and_a_contact_print_one_state_with_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    for flags in [
        "--n 40 --eps-f-inv 8 --boundary free --p-star 0.1",
        "--n 40 --eps-f-inv 8 --hardness 0.05 --p-star 0.1",
        "--n 40 --eps-f-inv 8 --law exponential --param gamma=1e-5,range=3e-3 --p-star 0.05",
    ] {
        let [contact, path] = ["contact", "path"].map(|command| run(folder.path(), &format!("{command} {flags}")));
        for name in ["rms_height", "rms_gradient", "e_star"] {
            assert_eq!(number(&contact, name).to_bits(), number(&path, name).to_bits(), "{flags}: {name}");
        }
        let (load, step) = (&contact["loads"][0], &path["steps"][0]);
        for name in ["mean_pressure", "p_star", "approach", "area_fraction", "mean_gap", "elastic_energy"] {
            assert_eq!(number(load, name).to_bits(), number(step, name).to_bits(), "{flags}: {name}");
        }
    }
}

#[test]
fn a_cohesive_path_moves_all_components() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "path --n 32 --dim 2 --eps-f-inv 4 --height 0.5 --law npb \
                 --param phi_n=1e-4,phi_t=8e-5,delta_n=0.01,delta_t=0.01 --approach 0.002 --lateral 0,0.01 \
                 --steps 2";
    let report = run(folder.path(), flags);
    for step in report["steps"].as_array().unwrap() {
        assert_eq!(step["converged"], true);
        // This law has no energy.
        assert!(step["interface_energy"].is_null());
        assert!(step["dissipated"].is_null() && step["dissipated_error"].is_null());
    }
    assert!(report["steps"][2]["mean_shear"][0].as_f64().unwrap() > 0.0);
}

#[test]
fn unusable_flags_are_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for (flags, words) in [
        ("law --law glue --normal 0", &["--law", "glue", "xu-needleman", "dugdale"][..]),
        ("law --law morse --param gamma=1 --normal 0", &["--param", "range", "positive"]),
        ("law --law morse --param gamma=1,rho=2 --normal 0", &["--param", "rho", "gamma", "range"]),
        ("law --law morse --param gamma=0,range=1 --normal 0", &["--param", "gamma is 0", "positive"]),
        ("law --law morse --param gamma --normal 0", &["--param", "NAME=VALUE", "gamma"]),
        ("law --law exponential --param gamma=1,range=1 --normal=-1", &["--normal", "-1", "at least 0"]),
        ("law --law hard-wall --normal 1,2 --tangential 1", &["--tangential", "1", "2"]),
        ("law --normal nan", &["--normal", "NaN", "finite"]),
        ("law", &["--normal"]),
        (
            "contact --n 16 --eps-f-inv 4 --law morse --param gamma=1,range=1 --p-star 1 --solver cg",
            &["--solver", "fire"],
        ),
        ("contact --n 16 --eps-f-inv 4 --law morse --param gamma=1 --p-star 1", &["--param", "range"]),
        ("contact --n 16 --eps-f-inv 4 --param gamma=1 --p-star 1", &["--param", "hard-wall", "gamma", "none"]),
        ("path --n 16 --eps-f-inv 4", &["--approach"]),
        ("path --n 16 --eps-f-inv 4 --p-star 1,2 --lateral 1,2,3", &["--p-star", "1 or 3", "2"]),
        ("path --n 16 --eps-f-inv 4 --p-star=-1", &["--p-star is -1", "not negative"]),
        ("path --n 16 --eps-f-inv 4 --p-star 1 --friction -0.1", &["--friction", "mu is -0.1"]),
        (
            "path --n 16 --eps-f-inv 4 --p-star 1 --friction 0.1 --law npc \
             --param phi_n=1e-4,phi_t=1e-4,delta_n=0.002,delta_t=0.002",
            &["--friction", "--law", "that shears"],
        ),
        ("path --n 16 --eps-f-inv 4 --p-star 1 --friction-of net", &["--friction-of is net", "--friction"]),
        ("path --n 16 --eps-f-inv 4 --p-star 1 --tolerance 1", &["--tolerance", "1"]),
        ("path --n 16 --eps-f-inv 4 --p-star 1 --steps 0", &["--steps", "0"]),
        ("path --n 16 --eps-f-inv 4 --p-star 1,2,1 --steps 4294967295", &["--steps", "8589934590", "1000000"]),
        (
            "path --n 16 --eps-f-inv 4 --p-star 1 --energy-tolerance 1e-20",
            &["--energy-tolerance", "1e-20", "1e-9", "0.1"],
        ),
        ("path --n 16 --eps-f-inv 4 --approach 1 --friction 0.1", &["--approach", "full contact"]),
    ] {
        let output = gfmd(folder.path(), &flags.split_whitespace().chain(["-q"]).collect::<Vec<_>>());
        let text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{flags}: {text}");
        assert_eq!(text.trim_end().lines().count(), 1, "{flags}: {text}");
        for word in words {
            assert!(text.contains(word), "{flags}: no {word:?} in {text}");
        }
        assert!(output.stdout.is_empty());
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn an_attraction_is_told_before_the_solve_and_refused_on_a_grid_that_is_much_too_coarse() {
    let folder = tempfile::tempdir().unwrap();
    // A wave A cos(2πx): rms gradient √2 π A, rms curvature √2 π² 2 A.
    let amplitude = 0.01;
    let wave =
        ndarray::Array1::from_shape_fn(64, |i| amplitude * (std::f64::consts::TAU * f64::from(i as u8) / 64.0).cos());
    ndarray_npy::write_npy(folder.path().join("wave.npy"), &wave).unwrap();
    let (gamma, range) = (1e-4, 4e-3);
    let flags =
        |range: f64| format!("--surface wave.npy --e-star 2 --law exponential --param gamma={gamma},range={range}");
    let report = run(folder.path(), &format!("contact {} --pressure 0.01", flags(range)));
    let found = &report["adhesion"];
    let pi = std::f64::consts::PI;
    let (gradient, curvature) = (2_f64.sqrt() * pi * amplitude, 2_f64.sqrt() * 2.0 * pi * pi * amplitude);
    let zone = 0.25 * pi * 2.0 * range * range / gamma;
    let length = gamma / 2.0;
    let sticky =
        gradient * range / (2.0 * length) * (gradient * (4.0 * gradient / curvature) / (4.0 * range)).powf(2.0 / 3.0);
    for (key, wanted) in [
        ("work", gamma),
        ("range", range),
        ("process_zone", zone),
        ("process_zone_points", 64.0 * zone),
        // √(6.25 / 64 / 2).
        ("wang_zhou_muser", 0.220_970_9),
        ("tabor", (gamma * gamma / curvature / 4.0 / range.powi(3)).cbrt()),
        ("pastewka_robbins", sticky / 1.029_2),
    ] {
        assert!((number(found, key) / wanted - 1.0).abs() < 1e-4, "{key}: {found} {wanted}");
    }
    assert!(run(folder.path(), "contact --surface wave.npy --pressure 0.01").get("adhesion").is_none());
    // A cap of radius R on a non-periodic patch has the curvature 1/R at every point; the jump at the seam does not
    // count, on any grid.
    for points in [16_usize, 32, 64] {
        let step = 1.0 / points as f64;
        let at = |k: usize| (k as f64 + 0.5) * step - 0.5;
        let cap = ndarray::Array2::from_shape_fn([points; 2], |(i, j)| -(at(i).powi(2) + at(j).powi(2)) / 2.0 / 3.0);
        ndarray_npy::write_npy(folder.path().join("cap.npy"), &cap).unwrap();
        let flags = format!("--surface cap.npy --e-star 2 --law exponential --param gamma={gamma},range={range}");
        let found = run(folder.path(), &format!("contact {flags} --approach 0.001 --boundary free"));
        let slopes = (0..points - 1).map(|k| ((at(k) + step / 2.0) / 3.0).powi(2)).sum::<f64>() / (points - 1) as f64;
        let gradient = (2.0 * slopes).sqrt();
        let sticky =
            gradient * range / (2.0 * length) * (gradient * (4.0 * gradient * 3.0) / (4.0 * range)).powf(2.0 / 3.0);
        for (key, wanted) in
            [("tabor", (3.0 * gamma * gamma / 4.0 / range.powi(3)).cbrt()), ("pastewka_robbins", sticky / 1.029_2)]
        {
            let ratio = number(&found["adhesion"], key) / wanted;
            assert!((ratio - 1.0).abs() < 1e-4, "{points}, {key}: {ratio}");
        }
    }
    let reported = gfmd(
        folder.path(),
        &format!("contact {} --pressure 0.01", flags(range)).split_whitespace().collect::<Vec<_>>(),
    );
    let reported = String::from_utf8(reported.stderr).unwrap();
    assert!(
        reported.contains("process zone of 16.08 grid steps (resolved)") && reported.contains("Tabor number"),
        "{reported}"
    );
    // A law with a jump of the traction needs more points than a smooth one; both commands say so.
    for (command, law, range, needed, is_told) in [
        ("contact", "exponential", 4e-3, 2.0, false),
        ("contact", "exponential", 1.3e-3, 2.0, true),
        ("contact", "dugdale", 4e-3, 32.0, true),
        ("path", "dugdale", 4e-3, 32.0, true),
        ("path", "dugdale", 6e-3, 32.0, false),
    ] {
        let flags = format!("--surface wave.npy --e-star 2 --law {law} --param gamma={gamma},range={range}");
        let report = run(folder.path(), &format!("{command} {flags} --pressure 0.01"));
        assert_eq!(number(&report["adhesion"], "process_zone_needed"), needed);
        let codes = report["warnings"].as_array().unwrap().iter().map(|reported| reported["code"].as_str().unwrap());
        assert_eq!(codes.filter(|code| *code == "process-zone").count(), usize::from(is_told), "{flags}");
    }
    assert!(reported.contains("Wang-Zhou-Müser 0.22 (below 0.5: resolved)"), "{reported}");
    for command in ["contact", "path"] {
        let coarse = format!("{command} {} --approach 0.002 -q", flags(1e-4));
        let output = gfmd(folder.path(), &coarse.split_whitespace().collect::<Vec<_>>());
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.starts_with("error: --law: the process zone") && message.contains("--coarse"), "{message}");
        let report = run(folder.path(), &format!("{command} {} --coarse --approach 0.002", flags(1e-4)));
        assert!(number(&report["adhesion"], "process_zone_points") < 0.1);
        assert_eq!(report["warnings"][0]["code"], "lattice-trapping");
    }
}

#[test]
fn a_search_that_starts_at_longer_ranges_ends_at_the_asked_one() {
    let folder = tempfile::tempdir().unwrap();
    let law = "--n 64 --dim 2 --eps-f-inv 8 --law exponential --param gamma=2e-4,range=1e-3 --approach=-0.0005,0.002";
    let plain = run(folder.path(), &format!("contact {law} --out plain.h5"));
    let walked = run(folder.path(), &format!("contact {law} --range-continuation --out walked.h5"));
    for load in walked["loads"].as_array().unwrap() {
        assert!(load["converged"] == true && number(load, "residual_equilibrium") <= 1e-8, "{load}");
    }
    // The long range pulled the surfaces together before the short one could.
    let area = |report: &Value| number(&report["loads"][0], "area_fraction");
    assert!(area(&walked) > area(&plain), "{} {}", area(&walked), area(&plain));
    assert_eq!(run(folder.path(), "check walked.h5 --rerun")["differing"], 0);
    let output = gfmd(
        folder.path(),
        &"contact --n 16 --law npb --param phi_n=1,phi_t=1,delta_n=1,delta_t=1 --p-star 0.1 --range-continuation"
            .split_whitespace()
            .collect::<Vec<_>>(),
    );
    assert_eq!(output.status.code(), Some(2));
    assert!(String::from_utf8(output.stderr).unwrap().contains("--range-continuation: the law npb has no range"));
}

/// At zero load, repulsion and attraction cancel: the remaining mean pressure is rounding of larger pressures.
#[test]
fn a_result_under_no_load_is_found_again() {
    let folder = tempfile::tempdir().unwrap();
    let law = "--law exponential --param gamma=2e-5,range=1.2e-3";
    let flags = format!("contact --n 64 --eps-f-inv 8 {law} --pressure 0.005,0 --out zero.h5 -q");
    for flags in [&flags, "check zero.h5"] {
        let found = gfmd(folder.path(), &flags.split(' ').collect::<Vec<_>>());
        assert!(found.status.success(), "{flags}: {}", String::from_utf8_lossy(&found.stdout));
    }
}

#[test]
fn a_step_with_friction_that_is_not_halved_has_no_error_and_says_why() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "path --n 32 --dim 2 --eps-f-inv 4 --poisson 0.2 --p-star 0.05 --friction 0.3 --lateral 0,0.01";
    let [few, many] = [8, 32].map(|steps| run(folder.path(), &format!("{flags} --steps {steps}")));
    assert_ne!(number(&few, "dissipated"), number(&many, "dissipated"));
    assert!(few["dissipated_error"].is_null());
    let reasons = few["steps"][4]["undefined"].as_object().unwrap();
    let of_error = |columns: &Value| columns.as_array().unwrap().iter().any(|column| column == "dissipated_error");
    let reason = reasons.iter().find(|(_, columns)| of_error(columns)).unwrap().0;
    assert!(reason.contains("was not halved") && reason.contains("--energy-tolerance"), "{reason}");
}
