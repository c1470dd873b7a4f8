//! `estimate` from end to end: against solved contacts, in its units, beyond its range.

use serde_json::Value;

use crate::common::{gfmd, json};

/// The measured deviations.
const MEASURED: &str = include_str!("../../../../data/results/estimate.json");

const NAMES: [&str; 4] = ["area_fraction", "mean_gap", "stiffness", "max_pressure"];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or(f64::NAN)
}

fn run(folder: &std::path::Path, flags: &str) -> Value {
    json(folder, &format!("{flags} --json --quiet").split_whitespace().collect::<Vec<_>>())
}

/// Surfaces with other seeds than the measured ones: no number deviates by more than twice its error.
#[test]
fn solved_contacts_deviate_by_no_more_than_the_errors_allow() {
    let folder = tempfile::tempdir().unwrap();
    for hurst in ["0.2", "0.8"] {
        let flags = format!("--n 256 --eps-f-inv 32 --eps-t-inv 2 --hurst {hurst} --seed 77 --p-star 0.01,0.1,0.3");
        let [estimated, solved] =
            ["estimate", "contact"].map(|command| run(folder.path(), &format!("{command} {flags}")));
        let mut inside = 0;
        for (estimate, contact) in
            estimated["loads"].as_array().unwrap().iter().zip(solved["loads"].as_array().unwrap())
        {
            for name in NAMES {
                let limit = number(&contact[format!("{name}_limit")]);
                let wanted = if limit.is_finite() { limit } else { number(&contact[name]) };
                let error = number(&estimate[format!("{name}_error")]);
                let deviation = (number(&estimate[name]) - wanted).abs() / error;
                assert!(deviation < 2.0, "{hurst} {name}: {estimate} {contact}");
                inside += usize::from(deviation < 1.0);
            }
        }
        assert!(inside >= 9, "{hurst}: {inside} of 12 within the error");
    }
}

/// The same surface in other units, by pressure, reduced pressure and force, has the same numbers.
#[test]
fn loads_and_units_change_no_number() {
    let folder = tempfile::tempdir().unwrap();
    let surface = "estimate --n 64 --eps-f-inv 8 --eps-t-inv 2 --hurst 0.5";
    let bare = run(folder.path(), &format!("{surface} --p-star 0.05"));
    let scaled = format!("{surface} --unit um --size 100um --young 70GPa --hardness 3GPa");
    let reduced = run(folder.path(), &format!("{scaled} --p-star 0.05"));
    let pressure = number(&reduced["loads"][0]["mean_pressure"]);
    let by_pressure = run(folder.path(), &format!("{scaled} --pressure {pressure:?}Pa"));
    let by_force = run(folder.path(), &format!("{scaled} --force {:?}N", pressure * 1e-8));
    let e_star_g = 70e9 * number(&reduced["rms_gradient"]);
    assert!((number(&reduced["plasticity_index"]) / (e_star_g / 3e9) - 1.0).abs() < 1e-12);
    let of_bare = &bare["loads"][0];
    for found in [&reduced, &by_pressure, &by_force] {
        let load = &found["loads"][0];
        for (name, unit) in [
            ("p_star", 1.0),
            ("area_fraction", 1.0),
            ("area_fraction_error", 1.0),
            ("mean_gap", 100.0),
            ("stiffness", 7e8),
            ("rms_pressure", 7e10),
            ("max_pressure", 7e10),
            ("max_pressure_error", 7e10),
            ("percolation_distance", 1.0),
        ] {
            let [wanted, value] = [of_bare, load].map(|load| number(&load[name]));
            assert!((value / (unit * wanted) - 1.0).abs() < 1e-6, "{name}: {value} {wanted}");
        }
    }
    let distance = number(&bare["percolation_area_fraction"]) - number(&of_bare["area_fraction"]);
    assert_eq!(number(&of_bare["percolation_distance"]), distance);
    // A file has the numbers of the generated surface.
    let made = "--n 64 --eps-f-inv 8 --eps-t-inv 2 --hurst 0.5 --out h.npy --json --quiet";
    json(folder.path(), &["surface"].into_iter().chain(made.split(' ')).collect::<Vec<_>>());
    let read = run(folder.path(), "estimate h.npy --size 1 --p-star 0.05");
    for name in NAMES {
        assert!((number(&read["loads"][0][name]) / number(&of_bare[name]) - 1.0).abs() < 1e-9, "{name}");
    }
}

/// Without a load there are the default ones; beyond the measured loads and spectra there is a reason.
#[test]
fn numbers_beyond_the_measured_ones_have_a_reason() {
    let folder = tempfile::tempdir().unwrap();
    let default = run(folder.path(), "estimate --n 128 --hurst 0.5");
    assert_eq!(default["loads"].as_array().unwrap().len(), 6);
    assert!(default["loads"].as_array().unwrap().iter().all(|load| load["undefined"].is_null()), "{default}");
    let report = run(folder.path(), "estimate --n 128 --hurst 0.5 --p-star 1e-5,0.1,3");
    let loads = report["loads"].as_array().unwrap();
    for (load, known) in loads.iter().zip([false, true, false]) {
        for name in NAMES.into_iter().chain(["rms_pressure", "percolation_distance"]) {
            assert_eq!(load[name].is_number(), known, "{name}: {load}");
            assert_eq!(load[format!("{name}_error")].is_number(), known, "{name}: {load}");
            let reasons = load["undefined"].as_object().into_iter().flatten();
            let count =
                reasons.filter(|(_, names)| names.as_array().unwrap().iter().any(|other| other == name)).count();
            assert_eq!(count, usize::from(!known), "{name}: {load}");
        }
    }
    // A spike makes heights that are far from Gaussian ones.
    let flags = "surface --n 128 --hurst 0.5 --out h.npy --json --quiet";
    json(folder.path(), &flags.split(' ').collect::<Vec<_>>());
    let mut heights: ndarray::Array2<f64> = ndarray_npy::read_npy(folder.path().join("h.npy")).unwrap();
    heights[[40, 50]] += 1.0;
    ndarray_npy::write_npy(folder.path().join("h.npy"), &heights).unwrap();
    let report = run(folder.path(), "estimate h.npy --size 1 --p-star 0.1");
    let text = report["loads"][0]["undefined"].to_string();
    assert!(report["loads"][0]["area_fraction"].is_null(), "{report}");
    assert!(["skewness", "kurtosis", "spectrum"].iter().any(|word| text.contains(word)), "{text}");
    // A wave has one wavenumber, and a sphere a spectrum of its own.
    for shape in ["wave:A=0.01,Lx=1,Ly=1", "sphere:R=1"] {
        let report = run(folder.path(), &format!("estimate --n 64 --shape {shape} --p-star 0.1"));
        let load = &report["loads"][0];
        assert!(load["area_fraction"].is_null() && load["undefined"].is_object(), "{shape}: {load}");
    }
}

#[test]
fn unusable_input_is_one_clear_line() {
    let folder = tempfile::tempdir().unwrap();
    ndarray_npy::write_npy(folder.path().join("flat.npy"), &ndarray::Array2::<f64>::zeros((16, 16))).unwrap();
    for (flags, part) in [
        ("--n 16 --p-star 0.1,0", "--p-star is 0; it must be positive"),
        ("--n 16 --pressure nan", "--pressure is NaN; it must be positive"),
        ("--n 16 --pressure 1 --p-star 0.1", "cannot be used with"),
        ("--n 16 --hardness -1", "--hardness is -1; it must be positive and finite"),
        ("--n 16 --dim 2", "is a profile; an estimate needs a surface"),
        ("--n 16 --height 0.1", "the body is not a half-space"),
        ("--n 16 --height 0.1 --base half-space --base-young 2 --base-poisson 0", "the body is not a half-space"),
        ("--n 16 --unit um --pressure 1MPa", "--young is missing"),
        ("--n 16 --pressure 1MPa", "it has a unit, and the lengths have none"),
        ("--surface flat.npy", "flat.npy is flat"),
        ("--surface no.npy", "no.npy"),
        ("--n 16 --approach 0.1", "--approach"),
    ] {
        let arguments: Vec<&str> = ["estimate"].into_iter().chain(flags.split(' ')).collect();
        let output = gfmd(folder.path(), &arguments);
        let message = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{flags}: {message}");
        assert!(message.contains(part) && message.trim_end().lines().count() == 1, "{flags}: {message}");
    }
}

/// The page has the measured errors at every fourth load. `GFMD_DOCS=write` writes them.
#[test]
fn the_page_has_the_measured_errors() {
    let measured: Value = serde_json::from_str(MEASURED).unwrap();
    let loads: Vec<f64> = measured["p_star"].as_array().unwrap().iter().step_by(4).map(number).collect();
    let mut table = String::new();
    for group in measured["groups"].as_array().unwrap() {
        table += &format!("\n{} {}:\n\n", group["contacts"], group["name"].as_str().unwrap());
        table += &format!(
            "| error, %, at p\\* | {} |\n|---|{}\n",
            loads.iter().map(f64::to_string).collect::<Vec<_>>().join(" | "),
            "---|".repeat(loads.len())
        );
        for (name, title) in [
            ("area_fraction", "contact area fraction"),
            ("mean_gap", "mean gap"),
            ("stiffness", "stiffness"),
            ("rms_pressure", "rms pressure"),
            ("max_pressure", "largest pressure"),
        ] {
            let errors = group["error"][name].as_array().unwrap().iter().step_by(4);
            let cells: Vec<String> = errors.map(|error| format!("{:.1}", 100.0 * number(error))).collect();
            table += &format!("| {title} | {} |\n", cells.join(" | "));
        }
    }
    let of_area = measured["percolation"].as_array().unwrap();
    let [area, spread] = [0, 1].map(|k| number(&of_area[k]));
    table += &format!("\nContacts percolate at the area fraction {area:.3} ± {spread:.3}.\n");
    let file = format!("{}/../../docs/estimate.md", env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(&file).unwrap();
    let (before, rest) = page.split_once("<!-- deviations -->\n").unwrap();
    let (_, after) = rest.split_once("<!-- end -->").unwrap();
    let wanted = format!("{before}<!-- deviations -->\n{table}<!-- end -->{after}");
    if std::env::var_os("GFMD_DOCS").is_some_and(|what| what == "write") {
        std::fs::write(&file, &wanted).unwrap();
    }
    assert_eq!(std::fs::read_to_string(&file).unwrap(), wanted);
}
