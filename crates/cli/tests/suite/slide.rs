//! Steady sliding, from end to end.

use crate::common::{gfmd, json};
use gfmd_files::Reader;
use ndarray::Array2;
use serde_json::Value;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn list(value: &Value) -> String {
    value.as_array().unwrap().iter().map(ToString::to_string).collect::<Vec<_>>().join(",")
}

#[test]
fn the_program_has_the_values_of_dense_solutions() {
    let folder = tempfile::tempdir().unwrap();
    let all: Value = serde_json::from_str(include_str!("../../../../data/reference/viscoelastic/slide.json")).unwrap();
    // An oblique patch on a slab, a prescribed approach, relaxation in shear only.
    for problem in [3, 4, 5].map(|index| &all["problems"][index]) {
        let rows = problem["heights"].as_array().unwrap();
        let shape = (rows.len(), rows[0].as_array().unwrap().len());
        let at = |(i, j): (usize, usize)| problem["heights"][i][j].as_f64().unwrap();
        ndarray_npy::write_npy(folder.path().join("heights.npy"), &Array2::from_shape_fn(shape, at)).unwrap();
        let branches: Vec<String> =
            problem["prony"].as_array().unwrap().iter().map(|pair| format!("{}:{}", pair[0], pair[1])).collect();
        let results = problem["results"].as_array().unwrap();
        let speeds: Vec<String> = results.iter().map(|state| state["velocity"].to_string()).collect();
        let height = problem["height"].as_f64().map_or("inf".to_owned(), |height| height.to_string());
        let word = |key: &str| problem[key].as_str().unwrap();
        let flags = format!(
            "slide --surface heights.npy --size {} --young {} --poisson {} --height {height} --prony {} --relaxes {} \
             --{} {} --velocity {} --direction {} --tolerance 1e-11 --json",
            list(&problem["length"]),
            problem["young"],
            problem["poisson"],
            branches.join(","),
            word("relaxes"),
            word("control"),
            problem["value"],
            speeds.join(","),
            problem["direction"],
        );
        let report = json(folder.path(), &words(&flags));
        let states = report["states"].as_array().unwrap();
        assert_eq!(states.len(), results.len());
        for (state, result) in states.iter().zip(results) {
            let keys = ["mean_pressure", "approach", "area_fraction", "max_pressure", "friction", "friction_slope"];
            for key in keys {
                let [found, known] = [state, result].map(|state| state[key].as_f64().unwrap());
                assert!((found - known).abs() <= 1e-8 * known.abs().max(1e-3), "{key}: {found:e}, {known:e}");
            }
            let theory = state["persson"]["friction"].as_f64().unwrap();
            approx::assert_relative_eq!(theory, result["persson_friction"].as_f64().unwrap(), max_relative = 1e-9);
        }
    }
}

/// The grid error of sliding is unknown: two digits and `~`, and a line that explains them.
#[test]
fn numbers_with_an_unknown_grid_error_have_two_digits() {
    let folder = tempfile::tempdir().unwrap();
    let run = "slide --n 24 --eps-f-inv 6 --prony 0.1:0.3,10:0.4 --p-star 0.02 --velocity 0.1";
    let warm = "slide --n 24 --eps-f-inv 6 --heat 1,0.1,0.3,0.2 --friction 0.3 --p-star 0.05 --velocity 1";
    for (line, least) in [(run, 3), (warm, 4)] {
        let output = gfmd(folder.path(), &words(line));
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let rough: Vec<&str> = text.split_whitespace().filter_map(|word| word.strip_suffix('~')).collect();
        let digits = |word: &str| word.trim_start_matches(['-', '0', '.']).chars().filter(char::is_ascii_digit).count();
        assert!(rough.len() >= least, "{text}");
        assert!(rough.iter().filter(|word| !word.contains('e')).all(|word| digits(word) <= 3), "{rough:?}");
        assert!(text.contains("two digits and ~: the error of the number by the grid is not known"), "{text}");
    }
}

#[test]
fn loads_at_velocities_are_written_checked_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let run = "slide --n 24 --eps-f-inv 6 --prony 0.1:0.3,10:0.4 --p-star 0.02,0.1 --velocity 0.01:1:3 --out s.h5 \
               --plots s --json";
    let report = json(folder.path(), &words(run));
    let states = report["states"].as_array().unwrap();
    let number = |state: usize, key: &str| states[state][key].as_f64().unwrap();
    assert_eq!((states.len(), number(3, "velocity")), (6, 0.01));
    assert!(number(0, "p_star") < number(3, "p_star") && (0..6).all(|state| number(state, "friction") > 0.0));
    let file = Reader::open(folder.path().join("s.h5")).unwrap();
    assert_eq!(file.shape("/fields/pressure").unwrap(), [6, 24, 24]);
    assert_eq!(file.values::<f64>("/states/friction").unwrap()[4], number(4, "friction"));
    let checked = json(folder.path(), &["check", "s.h5", "--rerun", "--json"]);
    assert_eq!((&checked["kind"], &checked["differing"]), (&"slide".into(), &0.into()));
    assert!(folder.path().join("s-friction.svg").exists());
}

#[test]
fn flash_temperatures_have_the_values_of_dense_solutions() {
    let folder = tempfile::tempdir().unwrap();
    let all: Value = serde_json::from_str(include_str!("../../../../data/reference/viscoelastic/heat.json")).unwrap();
    for problem in all["problems"].as_array().unwrap() {
        let rows = problem["heights"].as_array().unwrap();
        let shape = (rows.len(), rows[0].as_array().unwrap().len());
        let at = |(i, j): (usize, usize)| problem["heights"][i][j].as_f64().unwrap();
        ndarray_npy::write_npy(folder.path().join("heights.npy"), &Array2::from_shape_fn(shape, at)).unwrap();
        let results = problem["results"].as_array().unwrap();
        let speeds: Vec<String> = results.iter().map(|state| state["velocity"].to_string()).collect();
        let length = if shape.1 == 1 { problem["length"][0].to_string() } else { list(&problem["length"]) };
        let flags = format!(
            "slide --surface heights.npy --size {length} --young {} --poisson {} --height {} --pressure {} \
             --friction {} --heat {} --velocity {} --direction {} --tolerance 1e-11 --json",
            problem["young"],
            problem["poisson"],
            problem["height"].as_f64().map_or("inf".to_owned(), |height| height.to_string()),
            problem["value"],
            problem["friction"],
            list(&problem["heat"]),
            speeds.join(","),
            problem["direction"],
        );
        let report = json(folder.path(), &words(&flags));
        let states = report["states"].as_array().unwrap();
        assert_eq!(states.len(), results.len());
        for (state, result) in states.iter().zip(results) {
            let heat = &state["heat"];
            for (found, key) in [
                (&state["mean_pressure"], "mean_pressure"),
                (&state["approach"], "approach"),
                (&heat["mean_flux"], "mean_flux"),
                (&heat["fraction"], "fraction"),
                (&heat["max_rise"], "max_rise"),
                (&heat["mean_rise"], "mean_rise"),
            ] {
                let [found, known] = [found, &result[key]].map(|value| value.as_f64().unwrap());
                approx::assert_relative_eq!(found, known, max_relative = 1e-8);
            }
            let points = (state["area_fraction"].as_f64().unwrap() * (shape.0 * shape.1) as f64).round();
            assert_eq!(points, result["contact_nodes"].as_f64().unwrap());
            assert!(state["friction"] == 0.0 && heat["residual"].as_f64().unwrap() <= 1e-11);
        }
    }
}

#[test]
fn temperatures_are_written_checked_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let run = "slide --n 24 --eps-f-inv 6 --p-star 0.02 --heat 1,0.01,0.3,0.1 --friction 0.3 --velocity 0.1,10 \
               --prony 0.1:0.5 --out s.h5 --plots s --json";
    let report = json(folder.path(), &words(run));
    let heat = |state: usize, key: &str| report["states"][state]["heat"][key].as_f64().unwrap();
    assert!(heat(0, "fraction") < heat(1, "fraction") && heat(0, "max_rise") < heat(1, "max_rise"));
    let file = Reader::open(folder.path().join("s.h5")).unwrap();
    assert_eq!(file.shape("/fields/temperature").unwrap(), [2, 24, 24]);
    let (pressure, temperature) =
        (file.slab::<f64>("/fields/pressure", 1).unwrap(), file.slab::<f64>("/fields/temperature", 1).unwrap());
    let touching = pressure.iter().zip(&temperature).filter(|(p, _)| **p > 0.0).map(|(_, t)| *t);
    assert_eq!(touching.fold(f64::NEG_INFINITY, f64::max), heat(1, "max_rise"));
    assert_eq!(file.values::<f64>("/states/heat_fraction").unwrap()[1], heat(1, "fraction"));
    assert_eq!(json(folder.path(), &["check", "s.h5", "--rerun", "--json"])["differing"], 0);
    for figure in ["friction", "rise", "temperature", "map", "section"] {
        assert!(folder.path().join(format!("s-{figure}.png")).exists(), "{figure}");
    }
}

#[test]
fn units_of_heat_lead_to_kelvin() {
    let folder = tempfile::tempdir().unwrap();
    // One problem as numbers in µm, Pa and s, and with units.
    let problem = "slide --n 24 --eps-f-inv 6 --size 50 --unit um --p-star 0.02 --friction 0.5 --json";
    let of = |flags: &str| json(folder.path(), &words(&format!("{problem} {flags}")));
    let plain = of("--young 1e7 --heat 2e11,1e5,1e12,1e6 --velocity 1e6");
    // A space within a number would end a word here.
    let given = of("--young 10MPa --heat 0.2W/m/K,0.1mm^2/s,1W/(m*K),1mm^2/s --velocity 1m/s --out u.h5");
    assert_eq!(plain["states"][0]["heat"], given["states"][0]["heat"]);
    let file = Reader::open(folder.path().join("u.h5")).unwrap();
    for (variable, unit) in [
        ("/fields/temperature", "K"),
        ("/fields/heat_flux", "Pa*µm/s"),
        ("/states/velocity", "µm/s"),
        ("/states/heat_max_rise", "K"),
        ("/states/mean_pressure", "Pa"),
        ("/states/mean_gap", "µm"),
    ] {
        assert_eq!(file.text(variable, "units").unwrap(), unit);
    }
    assert_eq!(json(folder.path(), &["check", "u.h5", "--json"])["differing"], 0);
}

#[test]
fn full_contact_of_two_bodies_leaves_their_shares_open() {
    let folder = tempfile::tempdir().unwrap();
    let run =
        "slide --n 16 --eps-f-inv 4 --p-star 20 --heat 1,0.01,0.3,0.1 --friction 0.3 --velocity 1 --out s.h5 --json";
    let report = json(folder.path(), &words(run));
    let state = &report["states"][0];
    assert!(state["area_fraction"] == 1.0);
    assert!(state["heat"]["fraction"].is_null());
    assert!(state["converged"] == true);
    assert_eq!(json(folder.path(), &["check", "s.h5", "--rerun", "--json"])["differing"], 0);
}

#[test]
fn unusable_input_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for (flags, words) in [
        ("--prony 1:0.5 --pressure 0.01", "--velocity"),
        ("--velocity 1 --pressure 0.01", "--prony and --heat are missing; one of them is needed to slide"),
        ("--prony 1:0.5 --velocity 0 --pressure 0.01", "--velocity is 0; it must be positive and finite"),
        ("--prony 1:0.5 --velocity -1 --pressure 0.01", "--velocity is -1; it must be positive and finite"),
        ("--prony 1:0.5 --velocity nan --pressure 0.01", "--velocity is NaN; it must be positive and finite"),
        ("--prony 1:0.5 --velocity 1 --direction inf --pressure 0.01", "--direction is inf; it must be finite"),
        ("--prony 1:0.5 --velocity 1 --pressure 0", "--pressure is 0; it must be positive and finite"),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --second-body 1,0.3", "--second-body is given"),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --boundary free", "--boundary"),
        ("--velocity 1 --pressure 0.01 --heat 1,1", "--friction is missing; it is needed with --heat"),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --friction 1", "--friction is given; it must be left out without"),
        ("--velocity 1 --pressure 0.01 --heat 1,1,2 --friction 1", "--heat has 3 numbers; it must have two, or four"),
        ("--velocity 1 --pressure 0.01 --heat 1 --friction 1", "--heat has 1 numbers; it must have two, or four"),
        ("--velocity 1 --pressure 0.01 --heat 0,1 --friction 1", "--heat: the conductivity is 0; it must be positive"),
        ("--velocity 1 --pressure 0.01 --heat 1,-1 --friction 1", "--heat: the diffusivity is -1; it must be positive"),
        ("--velocity 1 --pressure 0.01 --heat 1,1,nan,1 --friction 1", "--heat: the conductivity is NaN; it must be"),
        ("--velocity 1 --pressure 0.01 --heat 1,1,1,inf --friction 1", "--heat: the diffusivity is inf; it must be"),
        ("--velocity 1 --pressure 0.01 --heat 1,1 --friction 0", "--friction is 0; it must be positive and at most"),
        (
            "--velocity 1 --pressure 0.01 --heat 1,1 --friction nan",
            "--friction is NaN; it must be positive and at most",
        ),
        ("--velocity 1 --pressure 0.01 --heat 1W/(m*K),1 --friction 1", "--unit gives them one"),
        ("--velocity 1 --pressure 0.01 --heat 1,1Pa --friction 1", "it must be a diffusivity (such as m^2/s)"),
    ] {
        let output = gfmd(folder.path(), &format!("slide --n 16 --eps-f-inv 4 {flags}").split(' ').collect::<Vec<_>>());
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), text.lines().count()), (Some(2), 1), "{flags}: {text}");
        assert!(text.contains(words), "{flags}: {text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
