//! Surfaces that wear, from end to end.

use std::path::Path;

use crate::common::{gfmd, json, long, numbers};
use gfmd_files::Reader;
use ndarray::Array2;
use serde_json::Value;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn list(value: &Value) -> String {
    value.as_array().unwrap().iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
}

/// Returns the reason why a command is refused, one line with status 2.
fn refused(folder: &Path, flags: &str) -> String {
    let output = gfmd(folder, &words(flags));
    let text = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), text.lines().count()), (Some(2), 1), "{flags}: {text}");
    text
}

#[test]
fn the_program_has_the_values_of_dense_solutions() {
    let folder = tempfile::tempdir().unwrap();
    let all: Value = serde_json::from_str(include_str!("../../../../data/reference/viscoelastic/wear.json")).unwrap();
    for problem in all["problems"].as_array().unwrap() {
        let rows = problem["heights"].as_array().unwrap();
        let [nx, ny] = [rows.len(), rows[0].as_array().unwrap().len()];
        let at = |(i, j): (usize, usize)| problem["heights"][i][j].as_f64().unwrap();
        ndarray_npy::write_npy(folder.path().join("heights.npy"), &Array2::from_shape_fn((nx, ny), at)).unwrap();
        let sides = if ny == 1 { problem["length"][0].to_string() } else { list(&problem["length"]) };
        let height = problem["height"].as_f64().map_or("inf".to_owned(), |height| height.to_string());
        let flags = format!(
            "wear --surface heights.npy --size {sides} --young {} --poisson {} --height {height} --coefficient {} \
             --{} {} --distance {} --steps {} --tolerance 1e-11 --json",
            problem["young"],
            problem["poisson"],
            problem["coefficient"],
            problem["control"].as_str().unwrap(),
            list(&problem["waypoints"]),
            list(&problem["distance"]),
            problem["steps"],
        );
        let report = json(folder.path(), &words(&flags));
        let (steps, results) = (report["steps"].as_array().unwrap(), problem["results"].as_array().unwrap());
        assert_eq!(steps.len(), results.len());
        let largest = results.iter().map(|step| step["elastic_energy"].as_f64().unwrap()).fold(0.0, f64::max);
        for (step, result) in steps.iter().zip(results) {
            let keys = [
                ("distance", 1e-3),
                ("mean_pressure", 1e-3),
                ("approach", 1e-3),
                ("area_fraction", 1e-3),
                ("mean_gap", 1e-2),
                ("max_pressure", 1e-3),
                ("elastic_energy", largest),
                ("wear_volume", 1e-2),
                ("max_wear", 1e-2),
                ("dissipated", largest),
            ];
            for (key, floor) in keys {
                let [found, known] = [step, result].map(|step| step[key].as_f64().unwrap());
                assert!((found - known).abs() <= 1e-8 * known.abs().max(floor), "{key}: {found:e}, {known:e}");
            }
        }
        assert_eq!(report["coefficient"], problem["coefficient"]);
        assert_eq!(report["wear_volume"], steps.last().unwrap()["wear_volume"]);
    }
}

#[test]
fn wear_is_written_checked_drawn_and_told() {
    let folder = tempfile::tempdir().unwrap();
    for (name, flags, points) in [
        ("free", "--boundary free --pressure 0.02,0.005,0.005", 24),
        ("slab", "--height 0.3 --poisson 0.3 --approach 0.02,0.004,0.02", 24),
        ("layers", "--height 0.1 --layer 0.5,0.3,0.2 --p-star 0.1", 24),
        ("two", "--second-body 2,0.3 --pressure 0.02", 24),
        ("line", "--dim 2 --pressure 0.02,0.005,0.01", 1),
    ] {
        // The page of each has the figures; one surface and one profile are also drawn in files.
        let is_drawn = ["free", "line"].contains(&name);
        let plots = if is_drawn { format!("--plots {name}") } else { String::new() };
        let run = format!(
            "wear --n 24 --eps-f-inv 6 {flags} --coefficient 0.7 --distance 1,0,20 --steps 3 --out {name}.h5 {plots} \
             --json"
        );
        let report = json(folder.path(), &words(&run));
        let steps = report["steps"].as_array().unwrap();
        assert!(steps.len() == 7 && steps.iter().all(|step| step["converged"] == true), "{name}");
        let file = Reader::open(folder.path().join(format!("{name}.h5"))).unwrap();
        let distances: Vec<f64> = file.values("/path/distance").unwrap();
        assert_eq!((distances[2], distances[3], distances[6]), (1.0, 1.0, 21.0));
        assert_eq!(file.shape("/fields/wear_depth").unwrap(), [3, 24, points]);
        let volumes: Vec<f64> = file.values("/path/wear_volume").unwrap();
        let depth: Vec<f64> = file.slab("/fields/wear_depth", 2).unwrap();
        let mean = depth.iter().sum::<f64>() / depth.len() as f64;
        assert!((mean / volumes[6] - 1.0).abs() < 1e-12 && volumes[2] == volumes[3], "{name}");
        let checked = json(folder.path(), &["check", &format!("{name}.h5"), "--rerun", "--json"]);
        assert_eq!((&checked["kind"], &checked["differing"]), (&"path".into(), &0.into()), "{name}");
        let has = |figure: &str| folder.path().join(format!("{name}-{figure}.svg")).exists();
        for figure in ["wear", "profile", "section"] {
            assert_eq!(has(figure), is_drawn, "{name}: {figure}");
        }
        assert_eq!(has("depth"), is_drawn && points > 1, "{name}");
        assert!(gfmd(folder.path(), &["report", &format!("{name}.h5")]).status.success());
    }
}

/// Random numbers between 0 and 1.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn of<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[(self.next() * all.len() as f64) as usize]
    }

    /// Returns a random number spanning a few decades.
    fn wide(&mut self, decades: f64) -> f64 {
        10.0_f64.powf(decades * (self.next() - 0.5))
    }
}

#[test]
fn random_combinations_keep_volume_and_energy_and_are_what_their_files_say() {
    let folder = tempfile::tempdir().unwrap();
    let (mut solved, cases) = (0, if long() { 400 } else { 20 });
    for case in 0..cases {
        let mut dice = Numbers(case * 7919 + 5);
        let surface = format!("--n {} --eps-f-inv 4 --seed {case}", 16 + (12.0 * dice.next()) as usize);
        let dim = dice.of(&["", "", "--dim 2"]);
        let body = dice.of(&[
            "",
            "--height 0.2 --poisson 0.45",
            "--height 0.1 --poisson 0.5",
            "--height 0.3 --base sliding",
            "--height 0.1 --layer 0.3,0.2,0.2 --base half-space --base-young 2 --base-poisson 0.3",
            "--second-body 3,0.3",
            "--poisson 0.5 --young 3",
        ]);
        let boundary = dice.of(&["", "", "--boundary free"]);
        let coefficient = dice.wide(4.0);
        let loads = match dice.of(&["p", "p", "q", "d"]) {
            "p" => format!("--pressure {},{}", 0.02 * dice.wide(1.0), 0.02 * dice.wide(2.0)),
            "q" => format!("--p-star {}", 0.1 * dice.wide(2.0)),
            _ => format!("--approach {},{}", 2e-3 * dice.wide(1.0), 4e-3 * dice.wide(1.0)),
        };
        let distances = format!("{},{}", dice.of(&["0", "1e-3", "0.1"]), dice.wide(4.0));
        let run = format!(
            "wear {surface} {dim} {body} {boundary} {loads} --coefficient {coefficient} --distance {distances} \
             --steps 3 --out {case}.h5 --json"
        );
        let output = gfmd(folder.path(), &words(&run));
        if output.status.code() == Some(2) {
            let reported = String::from_utf8(output.stderr).unwrap();
            // A profile on a patch without a level, and a half-space pressed beyond its mean clearance before it wears.
            let known = ["a profile on a half-space", "less than the mean clearance"];
            assert!(known.iter().any(|words| reported.contains(words)), "{run}: {reported}");
            continue;
        }
        assert!(output.status.success(), "{run}: {}", String::from_utf8_lossy(&output.stderr));
        let report: Value = serde_json::from_slice(&output.stdout).unwrap();
        let [mut volume, mut before] = [0.0; 2];
        for step in report["steps"].as_array().unwrap() {
            let of = |key: &str| step[key].as_f64().unwrap();
            assert_eq!(step["converged"], true, "{run}");
            volume += coefficient * of("mean_pressure") * (of("distance") - before);
            before = of("distance");
            assert!((of("wear_volume") - volume).abs() <= 1e-12 * volume, "{run}");
            assert!(of("max_wear") >= volume * (1.0 - 1e-12) && of("dissipated") >= 0.0, "{run}");
        }
        let checked = json(folder.path(), &["check", &format!("{case}.h5"), "--json"]);
        assert_eq!(checked["differing"], 0, "{run}: {}", checked["differences"]);
        solved += 1;
    }
    assert!(4 * solved > 3 * cases, "{solved} of {cases}");
}

#[test]
fn a_rough_surface_runs_in_until_the_pressure_is_uniform() {
    let folder = tempfile::tempdir().unwrap();
    let run = "wear --n 64 --eps-f-inv 16 --p-star 0.05 --coefficient 1 --distance 0,1e-2:100:20 --steps 1 --json";
    let report = json(folder.path(), &words(run));
    let steps = report["steps"].as_array().unwrap();
    let number = |step: usize, key: &str| steps[step][key].as_f64().unwrap();
    assert!(number(0, "area_fraction") < 0.2 && number(0, "max_pressure") > 10.0 * number(0, "mean_pressure"));
    let last = steps.len() - 1;
    assert_eq!(number(last, "area_fraction"), 1.0);
    assert!((number(last, "max_pressure") / number(last, "mean_pressure") - 1.0).abs() < 1e-8);
    assert!((1..=last).all(|step| number(step, "area_fraction") >= number(step - 1, "area_fraction")));
}

#[test]
fn rounding_of_full_contact_is_neither_a_gap_nor_a_figure() {
    let folder = tempfile::tempdir().unwrap();
    // All roughness is worn off: a uniform pressure, a flat body, no gap.
    let run = "wear --n 32 --eps-f-inv 4 --p-star 0.5 --coefficient 1e-15/Pa --distance 0,1 --steps 12 --unit m \
               --size 1um --young 70GPa --plots w --out w.h5 --json";
    let report = json(folder.path(), &words(run));
    let steps = report["steps"].as_array().unwrap();
    let closed: Vec<&Value> = steps.iter().filter(|step| step["area_fraction"] == 1.0).collect();
    assert!(closed.len() > 4 && closed.iter().all(|step| step["mean_gap"] == 0.0), "{report}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let section = read("w-section.svg");
    assert!(section.contains("nm"));
    assert!(!section.contains("fm"));
    assert!(!folder.path().join("w-gap.svg").exists());
    assert_eq!(json(folder.path(), &words("check w.h5 --json"))["differing"], 0);
    // An open gap keeps its map and its size.
    let run = "wear --n 32 --eps-f-inv 4 --p-star 0.2 --coefficient 1e-15/Pa --distance 0,1e-4 --steps 1 --unit m \
               --size 1um --young 70GPa --plots v --json";
    let open = json(folder.path(), &words(run));
    assert!(open["steps"][1]["mean_gap"].as_f64().unwrap() > 1e-10 && read("v-gap.svg").contains("nm"));
}

#[test]
fn the_finer_grid_is_followed_too() {
    let folder = tempfile::tempdir().unwrap();
    let run =
        "wear --n 32 --eps-f-inv 4 --p-star 0.1 --coefficient 1 --distance 0,0.1 --steps 2 --grid-error refine --json";
    let report = json(folder.path(), &words(run));
    for step in report["steps"].as_array().unwrap() {
        let [found, limit] = ["approach", "approach_limit"].map(|key| step[key].as_f64().unwrap());
        assert!(limit > 0.0 && (found / limit - 1.0).abs() < 0.05, "{found} {limit}");
    }
}

/// The first step loads at once, and the work of a growing contact is no trapezium.
#[test]
fn the_imbalance_of_a_path_leaves_out_loading_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let fretting = "--n 16 --eps-f-inv 4 --friction 0.3 --p-star 0.1 --steps 2 --json --out w.h5";
    for (flags, first) in [
        ("--coefficient 1 --wear-by slip --lateral 0,0.002", 1),
        ("--coefficient 1 --lateral 0.001,0.002 --distance 0.1,0.1", 0),
    ] {
        let report = json(folder.path(), &words(&format!("path {fretting} {flags}")));
        let steps = report["steps"].as_array().unwrap();
        let imbalances: Vec<f64> = steps.iter().map(|step| step["work_imbalance"].as_f64().unwrap()).collect();
        let sum: f64 = imbalances[first..].iter().sum();
        assert_eq!(report["work_imbalance"].as_f64().unwrap(), sum, "{flags}");
        assert!(imbalances[0] > 0.0 && sum > 0.0, "{flags}: {imbalances:?}");
        assert!(gfmd(folder.path(), &["report", "w.h5"]).status.success());
        let page = std::fs::read_to_string(folder.path().join("w.html")).unwrap();
        let start = if first == 1 { "After the first step, work" } else { "Work" };
        assert!(page.contains(&format!("{start} and energies balance to ")), "{flags}");
    }
}

#[test]
fn a_file_has_the_warning_of_a_rough_wear_volume() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "wear --n 16 --eps-f-inv 4 --coefficient 5 --pressure 0.01 --distance 2 --energy-solves 3 --out";
    for (steps, warns) in [(1, true), (64, false)] {
        let report = json(folder.path(), &words(&format!("{flags} {steps}.h5 --steps {steps} --json")));
        let [volume, error] = ["wear_volume", "wear_volume_error"].map(|key| report[key].as_f64().unwrap());
        assert_eq!(error > 0.05 * volume, warns, "{volume} {error}");
        let warnings = Reader::open(folder.path().join(format!("{steps}.h5"))).unwrap().text("/", "warnings").unwrap();
        assert_eq!(warnings.contains("wear-error"), warns, "{warnings}");
    }
}

/// Short increments slip by less than the error of a rough search, so that all points stuck.
#[test]
fn wear_by_slip_does_not_depend_on_the_number_of_increments() {
    let folder = tempfile::tempdir().unwrap();
    let flags = "wear --n 32 --eps-f-inv 4 --seed 93 --coefficient 5 --poisson 0.3 --p-star 0.1 --friction 1 \
                 --wear-by slip --lateral 0,0.0005 --steps 4 --tolerance 1e-6 --json --energy-solves";
    for solves in [20, 200] {
        let report = json(folder.path(), &words(&format!("{flags} {solves}")));
        let volume = report["wear_volume"].as_f64().unwrap();
        // The volume of 256 steps solved to 1e-9.
        assert!((volume / 1.525e-7 - 1.0).abs() < 0.05, "{solves}: {volume}");
    }
}

#[test]
fn quantities_have_units() {
    let folder = tempfile::tempdir().unwrap();
    let wave = |i: usize| (std::f64::consts::TAU * i as f64 / 24.0).cos();
    let heights = Array2::from_shape_fn((24, 24), |(i, j)| 0.01 * (wave(i) * wave(j) + 0.3 * wave(3 * i + j)));
    ndarray_npy::write_npy(folder.path().join("h.npy"), &heights).unwrap();
    let problem = "wear --surface h.npy --size 10 --unit um --steps 2 --json -q";
    let bare = format!("{problem} --young 70e9 --pressure 1e7 --coefficient 2e-15 --distance 0,1e6 --out bare.h5");
    json(folder.path(), &words(&bare));
    for (name, coefficient) in [("a", "2e-15 1/Pa"), ("b", "2e-6/GPa"), ("c", "2e-6 mm^3/N/m")] {
        let with_units = format!("{problem} --young 70GPa --pressure 10MPa --distance 0,1m --out {name}.h5");
        let mut all = words(&with_units);
        all.extend(["--coefficient", coefficient]);
        let report = json(folder.path(), &all);
        assert_eq!(report["unit"], "µm");
        assert_eq!(numbers(&folder.path().join("bare.h5")), numbers(&folder.path().join(format!("{name}.h5"))));
    }
    let reported =
        refused(folder.path(), &format!("{problem} --young 70GPa --pressure 1e7 --coefficient 2GPa --distance 1"));
    assert!(reported.contains("--coefficient") && reported.contains("an inverse stress (such as 1/GPa)"), "{reported}");
}

#[test]
fn unusable_input_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let wear = |flags: &str| refused(folder.path(), &format!("wear --n 24 --eps-f-inv 4 {flags} --out w.h5"));
    let whole = "--pressure 0.01 --coefficient 1 --distance 1";
    for (flags, words) in [
        ("--pressure 0.01 --distance 1", "--coefficient"),
        ("--pressure 0.01 --coefficient 0 --distance 1", "--coefficient is 0; it must be positive and finite"),
        ("--pressure 0.01 --coefficient -1 --distance 1", "--coefficient is -1; it must be positive and finite"),
        ("--pressure 0.01 --coefficient nan --distance 1", "--coefficient is NaN; it must be positive and finite"),
        ("--pressure 0.01 --coefficient inf --distance 1", "--coefficient is inf; it must be positive and finite"),
        ("--pressure 0.01 --coefficient 1", "--distance"),
        ("--pressure 0.01 --coefficient 1 --distance -1", "--distance is -1; it must be finite and not negative"),
        ("--pressure 0.01 --coefficient 1 --distance 1,nan", "--distance is NaN; it must be finite and not negative"),
        ("--coefficient 1 --distance 1", "--approach"),
        ("--pressure=-0.01 --coefficient 1 --distance 1", "--pressure is -0.01; it must be finite and not negative"),
        ("--approach nan --coefficient 1 --distance 1", "--approach is NaN; it must be finite"),
        ("--pressure 0.01,0.02,0.03 --coefficient 1 --distance 1,2", "--distance has 2 waypoints; it must have 1 or 3"),
        ("--approach 1 --coefficient 1 --distance 0", "less than the mean clearance"),
        (&format!("{whole} --steps 0"), "--steps"),
        (&format!("{whole} --tolerance 0"), "--tolerance"),
        (&format!("{whole} --prony 1:0.5"), "--time"),
        (&format!("{whole} --law exponential"), "--param"),
        (&format!("{whole} --friction 0.3"), "--friction"),
        (&format!("{whole} --finite-slope"), "--finite-slope"),
        (
            "--pressure 0.01 --coefficient 1 --wear-by slip --lateral 0,0.001",
            "--wear-by slip is given; it must be distance with neither --friction nor --shear-strength",
        ),
        (&format!("{whole} --base-displacement x.npy"), "--base-displacement"),
    ] {
        let found = wear(flags);
        assert!(found.contains(words), "{flags}: {found}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
