//! Steady sliding, from end to end.

use crate::common::{gfmd, json};
use gfmd_contact::{Body, Budget, Contact, Equilibrium as _, Grid, Load, Material};
use gfmd_files::Reader;
use gfmd_heat::{Flash, Thermal};
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
        assert!(text.contains("two digits and ~: the grid error of the number is not known"), "{text}");
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

/// The reference contacts have no lift: half-spaces are made incompressible, with the same contact modulus.
#[test]
fn flash_temperatures_have_the_values_of_dense_solutions() {
    let folder = tempfile::tempdir().unwrap();
    let all: Value = serde_json::from_str(include_str!("../../../../data/reference/viscoelastic/heat.json")).unwrap();
    for problem in all["problems"].as_array().unwrap().iter().filter(|problem| problem["height"].is_null()) {
        let rows = problem["heights"].as_array().unwrap();
        let shape = (rows.len(), rows[0].as_array().unwrap().len());
        let at = |(i, j): (usize, usize)| problem["heights"][i][j].as_f64().unwrap();
        ndarray_npy::write_npy(folder.path().join("heights.npy"), &Array2::from_shape_fn(shape, at)).unwrap();
        let results = problem["results"].as_array().unwrap();
        let speeds: Vec<String> = results.iter().map(|state| state["velocity"].to_string()).collect();
        let [young, poisson, friction] = ["young", "poisson", "friction"].map(|key| problem[key].as_f64().unwrap());
        let length = if shape.1 == 1 { problem["length"][0].to_string() } else { list(&problem["length"]) };
        let flags = format!(
            "slide --surface heights.npy --size {length} --e-star {} --poisson 0.5 --pressure {} --friction {friction} \
             --heat {} --velocity {} --direction {} --tolerance 1e-11 --json",
            young / (1.0 - poisson * poisson),
            problem["value"],
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
            assert!(state["friction"] == friction && heat["residual"].as_f64().unwrap() <= 1e-11);
        }
    }
}

#[test]
fn flash_temperatures_of_a_slab_have_the_values_of_dense_solutions() {
    let all: Value = serde_json::from_str(include_str!("../../../../data/reference/viscoelastic/heat.json")).unwrap();
    for problem in all["problems"].as_array().unwrap().iter().filter(|problem| problem["height"].is_number()) {
        let numbers = |key: &str| -> Vec<f64> {
            problem[key].as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect()
        };
        let of = |key: &str| problem[key].as_f64().unwrap();
        let rows = problem["heights"].as_array().unwrap();
        let shape = (rows.len(), rows[0].as_array().unwrap().len());
        let heights = Array2::from_shape_fn(shape, |(i, j)| problem["heights"][i][j].as_f64().unwrap());
        let grid = Grid::new([shape.0, shape.1], [numbers("length")[0], numbers("length")[1]]).unwrap();
        let body = Body::slab(Material::from_young(of("young"), of("poisson")).unwrap(), of("height")).unwrap();
        let contact = Contact::new(&body, &grid, &heights).unwrap();
        let contact = contact.press(Load::MeanPressure(of("value"))).tolerance(1e-11).solve().unwrap();
        let heat = numbers("heat");
        let [below, above] = [0, 2].map(|first| Thermal::new(heat[first], heat[first + 1]).unwrap());
        let angle = of("direction").to_radians();
        for result in problem["results"].as_array().unwrap() {
            let speed = result["velocity"].as_f64().unwrap();
            let velocity = [angle.cos(), angle.sin()].map(|part| speed * part);
            let flash = Flash::new(grid, velocity, below, Some(above)).unwrap();
            let flux = contact.pressure.mapv(|p| of("friction") * speed * p);
            let budget = Budget { tolerance: 1e-11, ..Budget::default() };
            let heated = flash.heat(&flux, &budget, &mut ()).unwrap();
            for (found, key) in [
                (heated.mean_flux, "mean_flux"),
                (heated.fraction, "fraction"),
                (heated.max_rise, "max_rise"),
                (heated.mean_rise, "mean_rise"),
            ] {
                approx::assert_relative_eq!(found, result[key].as_f64().unwrap(), max_relative = 1e-8);
            }
        }
    }
}

/// Surfaces that are moved sideways until all points slip have the pressure of steady sliding.
#[test]
fn friction_lifts_as_on_a_path_where_all_points_slip() {
    let folder = tempfile::tempdir().unwrap();
    // Odd numbers of points have no Nyquist waves.
    let rough = "--n 25 --eps-f-inv 6 --p-star 0.05 --friction 0.4 --tolerance 1e-10 --json";
    for body in ["--poisson 0.2", "--poisson 0.4 --height 0.1", "--poisson 0.5", "--poisson 0.3 --second-body 2,0.1"] {
        let path = format!("path {rough} {body} --direction 30 --lateral 0,0.5 --steps 4 --energy-solves 0 --out p.h5");
        let stuck = json(folder.path(), &words(&path))["steps"].as_array().unwrap().last().unwrap().clone();
        assert_eq!(stuck["stick_fraction"], 0.0, "{body}");
        let slide = format!("slide {rough} {body} --direction 30 --velocity 1 --out s.h5");
        let state = json(folder.path(), &words(&slide))["states"][0].clone();
        for key in ["mean_pressure", "approach", "area_fraction", "mean_gap"] {
            let [found, known] = [&state, &stuck].map(|state| state[key].as_f64().unwrap());
            approx::assert_relative_eq!(found, known, max_relative = 1e-7);
        }
        let field = |name: &str| {
            let file = Reader::open(folder.path().join(name)).unwrap();
            let states = file.shape("/fields/pressure").unwrap()[0];
            file.slab::<f64>("/fields/pressure", states - 1).unwrap()
        };
        let most = state["max_pressure"].as_f64().unwrap();
        let apart = field("p.h5").iter().zip(field("s.h5")).fold(0.0_f64, |worst, (p, q)| worst.max((p - q).abs()));
        assert!(apart <= 1e-7 * most, "{body}: {apart:e} of {most:e}");
        let [friction, interface, rest] =
            ["friction", "friction_interface", "friction_hysteresis"].map(|key| state[key].as_f64().unwrap());
        assert!(interface == 0.4 && friction == interface + rest, "{body}");
        assert_eq!(rest == 0.0, body == "--poisson 0.5", "{body}: {rest:e}");
    }
}

/// On an incompressible half-space the shear does not lift: friction adds its coefficient, and nothing else.
#[test]
fn friction_adds_to_the_hysteresis_of_an_incompressible_half_space() {
    let folder = tempfile::tempdir().unwrap();
    let run = "slide --n 24 --eps-f-inv 6 --prony 0.1:0.3,10:0.4 --poisson 0.5 --p-star 0.05 --velocity 0.1,1 --json";
    let [without, with] = ["", " --friction 0.3"].map(|more| json(folder.path(), &words(&format!("{run}{more}"))));
    for (without, with) in without["states"].as_array().unwrap().iter().zip(with["states"].as_array().unwrap()) {
        for key in ["approach", "area_fraction", "mean_gap", "max_pressure", "persson", "iterations", "residual"] {
            assert_eq!(with[key], without[key], "{key}");
        }
        assert_eq!((&with["friction_hysteresis"], &with["friction_interface"]), (&without["friction"], &0.3.into()));
        assert_eq!(with["friction"].as_f64().unwrap(), 0.3 + without["friction"].as_f64().unwrap());
        assert_eq!(
            (&without["friction_hysteresis"], &without["friction_interface"]),
            (&without["friction"], &0.0.into())
        );
    }
}

/// Checks that the state on the finer grid has the numbers of a run on this grid.
#[test]
fn grid_errors_follow_from_a_finer_grid() {
    let folder = tempfile::tempdir().unwrap();
    let prony = "--prony 0.1:0.3,10:0.4 --poisson 0.4 --friction 0.3 --velocity 0.1,1";
    let of = |flags: &str| json(folder.path(), &words(&format!("slide --eps-f-inv 6 {prony} {flags} --json")));
    let coarse = of("--n 24 --p-star 0.05 --grid-error refine --out r.h5");
    assert_eq!(coarse["grid_error"]["mode"], "refine");
    let load = &coarse["states"][0]["mean_pressure"];
    let fine = of(&format!("--n 48 --pressure {load}"));
    for (state, finer) in coarse["states"].as_array().unwrap().iter().zip(fine["states"].as_array().unwrap()) {
        for name in ["friction", "friction_hysteresis", "area_fraction"] {
            let number = |end: &str| state[format!("{name}{end}")].as_f64().unwrap();
            approx::assert_relative_eq!(number("_limit"), finer[name].as_f64().unwrap(), max_relative = 1e-6);
            let apart = (number("") - number("_limit")).abs();
            approx::assert_relative_eq!(number("_limit_error"), 2.5 * apart, max_relative = 1e-12);
            approx::assert_relative_eq!(number("_grid_error"), 3.5 * apart, max_relative = 1e-12);
        }
    }
    assert_eq!(json(folder.path(), &["check", "r.h5", "--rerun", "--json"])["differing"], 0);
    // One solution does not give it.
    let refused = gfmd(folder.path(), &words(&format!("slide --n 24 {prony} --p-star 0.05 --grid-error estimate")));
    let text = String::from_utf8(refused.stderr).unwrap();
    assert!(!refused.status.success() && text.trim().lines().count() == 1, "{text}");
    assert!(text.contains("it must be none or refine (") && text.contains("leading and trailing edges"), "{text}");
    // At an approach, the finer grid has other highest points.
    let held = of("--n 24 --approach 0.01 --grid-error refine");
    assert!(held["states"][0]["friction_grid_error"].as_f64().unwrap() < 0.1);
    let printed =
        gfmd(folder.path(), &words(&format!("slide --n 24 --eps-f-inv 6 {prony} --p-star 0.05 --grid-error refine")));
    let text = String::from_utf8(printed.stdout).unwrap();
    assert!(text.contains("0.3") && text.contains('('), "{text}");
}

#[test]
fn a_hardness_is_written_checked_and_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let problem = "--n 24 --eps-f-inv 6 --poisson 0.4 --p-star 0.1 --tolerance 1e-10 --json";
    let run = format!(
        "slide {problem} --prony 0.1:0.3,10:0.4 --hardness 0.05 --friction 0.3 --velocity 0.01,1 --direction 20 \
         --heat 1,0.01,0.3,0.1 --out s.h5 --plots s"
    );
    let report = json(folder.path(), &words(&run));
    let state = &report["states"][1];
    assert_eq!((&report["hardness"], &state["max_pressure"]), (&0.05.into(), &0.05.into()));
    assert!(state["plastic_fraction"].as_f64().unwrap() > 0.01 && state["residual"]["saturation"].is_number());
    let file = Reader::open(folder.path().join("s.h5")).unwrap();
    let depth = file.slab::<f64>("/fields/plastic_depth", 1).unwrap();
    approx::assert_relative_eq!(
        depth.iter().sum::<f64>() / depth.len() as f64,
        state["plastic_volume"].as_f64().unwrap(),
        max_relative = 1e-12
    );
    assert_eq!(json(folder.path(), &["check", "s.h5", "--rerun", "--json"])["differing"], 0);
    json(folder.path(), &["report", "s.h5", "--json"]);
    let page = std::fs::read_to_string(folder.path().join("s.html")).unwrap();
    assert!(page.contains("hard wall, friction, hardness") && page.contains("the pressure is the hardness"));
    assert!(folder.path().join("s-map.png").exists());
    // The hardness of each point, from a file, is kept in the result.
    let each = Array2::from_elem((24, 24), 0.05);
    ndarray_npy::write_npy(folder.path().join("hard.npy"), &each).unwrap();
    let of_each = run.replace("0.05 --friction", "hard.npy --friction").replace("s.h5 --plots s", "e.h5");
    let found = json(folder.path(), &words(&of_each));
    assert_eq!(found["states"][1]["plastic_volume"], state["plastic_volume"]);
    std::fs::remove_file(folder.path().join("hard.npy")).unwrap();
    assert_eq!(json(folder.path(), &["check", "e.h5", "--rerun", "--json"])["differing"], 0);
    // Far above all pressures it has no effect, and without friction fast and slow sliding are contacts.
    let slide = |more: &str| json(folder.path(), &words(&format!("slide {problem} {more}")))["states"][0].clone();
    let [wall, hard] =
        ["", "--hardness 1e5"].map(|more| slide(&format!("--prony 0.1:0.3,10:0.4 --velocity 0.1 {more}")));
    for key in ["approach", "area_fraction", "max_pressure", "friction", "friction_slope"] {
        let [wall, hard] = [&wall, &hard].map(|state| state[key].as_f64().unwrap());
        approx::assert_relative_eq!(wall, hard, max_relative = 1e-7);
    }
    let contact = |young: f64, p_star: f64| {
        let words = format!(
            "contact --n 24 --eps-f-inv 6 --poisson 0.4 --tolerance 1e-10 --json --hardness 0.05 \
             --young {young} --p-star {p_star} --grid-error none"
        );
        json(folder.path(), &self::words(&words))["loads"][0].clone()
    };
    // E0/E = 1/(1 − 0.7).
    for (velocity, factor) in [(1e-9, 1.0), (1e9, 1.0 / 0.3)] {
        let found = slide(&format!("--prony 0.1:0.3,10:0.4 --hardness 0.05 --direction 20 --velocity {velocity}"));
        let known = contact(factor, 0.1 / factor);
        for key in ["mean_pressure", "approach", "area_fraction", "plastic_fraction", "plastic_volume"] {
            let [found, known] = [&found, &known].map(|state| state[key].as_f64().unwrap());
            approx::assert_relative_eq!(found, known, max_relative = 1e-5);
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
        ("--velocity 1 --pressure 0.01", "--prony and --friction are missing; one of them is needed to slide"),
        ("--prony 1:0.5 --velocity 0 --pressure 0.01", "--velocity is 0; it must be positive and finite"),
        ("--prony 1:0.5 --velocity -1 --pressure 0.01", "--velocity is -1; it must be positive and finite"),
        ("--prony 1:0.5 --velocity nan --pressure 0.01", "--velocity is NaN; it must be positive and finite"),
        ("--prony 1:0.5 --velocity 1 --direction inf --pressure 0.01", "--direction is inf; it must be finite"),
        ("--prony 1:0.5 --velocity 1 --pressure 0", "--pressure is 0; it must be positive and finite"),
        (
            "--prony 1:0.5 --velocity 1 --pressure 0.01 --second-body 1,0.3 --friction 0.2",
            "--friction: one body of a pair relaxes; the second body must be left out with friction",
        ),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --boundary free", "--boundary"),
        ("--velocity 1 --pressure 0.01 --heat 1,1", "--friction is missing; it is needed with --heat"),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --friction -1", "--friction is -1; it must be at least 0 and at"),
        (
            "--prony 1:0.5 --velocity 1 --pressure 0.01 --friction 1 --relaxes shear --height 0.3",
            "--friction: the shear modulus alone relaxes",
        ),
        (
            "--prony 1:0.99 --velocity 0.01 --pressure 0.01 --friction 3 --poisson 0.5 --height 0.02",
            "--friction: the pressure of a wave leads its displacement by",
        ),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01,0.2 --hardness 0.2", "--pressure: the mean pressure is 0.2"),
        (
            "--prony 1:0.5 --velocity 1 --pressure 0.01 --grid-error estimate",
            "--grid-error is estimate; it must be none or refine",
        ),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --hardness 0", "--hardness is 0; it must be positive and finite"),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --hardness nan", "--hardness is NaN; it must be positive"),
        ("--prony 1:0.5 --velocity 1 --pressure 0.01 --hardness none.npy", "--hardness: none.npy"),
        ("--velocity 1 --pressure 0.01 --heat 1,1,2 --friction 1", "--heat has 3 numbers; it must have two, or four"),
        ("--velocity 1 --pressure 0.01 --heat 1 --friction 1", "--heat has 1 numbers; it must have two, or four"),
        ("--velocity 1 --pressure 0.01 --heat 0,1 --friction 1", "--heat: the conductivity is 0; it must be positive"),
        ("--velocity 1 --pressure 0.01 --heat 1,-1 --friction 1", "--heat: the diffusivity is -1; it must be positive"),
        ("--velocity 1 --pressure 0.01 --heat 1,1,nan,1 --friction 1", "--heat: the conductivity is NaN; it must be"),
        ("--velocity 1 --pressure 0.01 --heat 1,1,1,inf --friction 1", "--heat: the diffusivity is inf; it must be"),
        ("--velocity 1 --pressure 0.01 --heat 1,1 --friction 0", "--friction is 0; it must be positive with --heat"),
        (
            "--velocity 1 --pressure 0.01 --heat 1,1 --friction nan",
            "--friction is NaN; it must be at least 0 and at most",
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
