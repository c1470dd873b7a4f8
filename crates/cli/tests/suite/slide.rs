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
    // An oblique patch on a slab, a prescribed approach, the shear alone.
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
            "slide --surface heights.npy --length {} --young {} --poisson {} --height {height} --prony {} --relaxes {} \
             --{} {} --velocity {} --direction {} --tol 1e-11 --json",
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
            let keys = ["mean_pressure", "displacement", "area_fraction", "max_pressure", "friction", "friction_slope"];
            for key in keys {
                let [found, known] = [state, result].map(|state| state[key].as_f64().unwrap());
                assert!((found - known).abs() <= 1e-8 * known.abs().max(1e-3), "{key}: {found:e}, {known:e}");
            }
            let theory = state["persson"]["friction"].as_f64().unwrap();
            approx::assert_relative_eq!(theory, result["persson_friction"].as_f64().unwrap(), max_relative = 1e-9);
        }
    }
}

#[test]
fn loads_at_velocities_are_written_checked_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let run = "slide --n 24 --eps-f-inv 6 --prony 0.1:0.3,10:0.4 --p-star 0.02,0.1 --velocity 0.01:1:3 --out s.h5 --plots s --json";
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
fn unusable_input_is_refused_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    for (flags, words) in [
        ("--prony 1:0.5 --pressure 0.01", "--velocity"),
        ("--velocity 1 --pressure 0.01", "--prony is missing; it is needed to slide"),
        ("--prony 1:0.5 --velocity 0 --pressure 0.01", "--velocity is 0; it must be positive and finite"),
        ("--prony 1:0.5 --velocity -1 --pressure 0.01", "--velocity is -1; it must be positive and finite"),
        ("--prony 1:0.5 --velocity nan --pressure 0.01", "--velocity is NaN; it must be positive and finite"),
        ("--prony 1:0.5 --velocity 1 --direction inf --pressure 0.01", "--direction is inf; it must be finite"),
        ("--prony 1:0.5 --velocity 1 --pressure 0", "--pressure is 0; it must be positive and finite"),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --second-body 1,0.3", "--second-body is given"),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --boundary free", "--boundary"),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --heat 1,1", "--heat"),
    ] {
        let output = gfmd(folder.path(), &format!("slide --n 16 --eps-f-inv 4 {flags}").split(' ').collect::<Vec<_>>());
        let text = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), text.lines().count()), (Some(2), 1), "{flags}: {text}");
        assert!(text.contains(words), "{flags}: {text}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
