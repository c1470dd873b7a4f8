//! Conductance of a gas in the gap, from end to end.

use std::path::Path;

use gfmd_measure::{GapGas, Gas, theory};
use serde_json::Value;

use crate::common::{gfmd, json};

fn run(folder: &Path, flags: &str) -> Value {
    json(folder, &flags.split_whitespace().collect::<Vec<_>>())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Light contacts of surfaces with many long waves, whose heights are nearly Gaussian, against Yovanovich's integral
/// for the same mean gap and rms height. Few points touch, and the deformation changes the gap little beyond its mean.
/// The tolerance, 1 %, covers a sample of some hundred waves, which is Gaussian within its scatter, and the body that
/// gives way around the contacts; the ratios found are 1.001 to 1.004 for M from 0.16 to 16 times the rms height.
#[test]
fn light_contacts_conduct_as_between_gaussian_heights() {
    let folder = tempfile::tempdir().unwrap();
    let mut worst: f64 = 0.0;
    for seed in [1, 2] {
        for jump in [1e-4, 1e-3, 1e-2] {
            let flags = format!(
                "contact --n 192 --eps-t-inv 16 --eps-f-inv 3 --seed {seed} --p-star 0.001 --gas-conductivity 2 \
                 --gas-jump {jump} --json"
            );
            let found = run(folder.path(), &flags);
            let (load, deviation) = (&found["loads"][0], number(&found["rms_height"]));
            let gas = GapGas { conductivity: 2.0, jump };
            let wanted = theory::gaussian_gap_conductance(&gas, deviation, number(&load["mean_gap"]));
            let ratio = number(&load["gas_conductance"]) / wanted;
            assert!(number(&load["area_fraction"]) < 0.005);
            worst = worst.max((ratio - 1.0).abs());
        }
    }
    assert!(worst < 0.01, "{worst}");
}

/// A joint in air: the same numbers in other units, in a file that holds, and along a path; a gas so thin that M is
/// much larger than the gap conducts k/M where nothing touches.
#[test]
fn a_joint_in_air_conducts_watts_per_area_and_kelvin() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let surface = "--n 48,36 --size 4,3 --eps-f-inv 4 --young 10MPa --p-star 0.05";
    let small = run(folder, &format!("contact {surface} --unit um --gas air --grid-error refine --out um.h5 --json"));
    let small = &small["loads"][0];
    let found = number(&small["gas_conductance"]) * 1e-6;
    let air = Gas::Air.between(300.0, 101_325.0, [Gas::Air.accommodation(); 2]).unwrap();
    // The mean of 1/(g + M) over the open points is at least the inverse of the mean, and M alone is an upper bound.
    let open = 1.0 - number(&small["area_fraction"]);
    let least = air.conductivity * open.powi(2) / (number(&small["mean_gap"]) * 1e-6 + open * air.jump);
    assert!(found > least && found < open * air.conductivity / air.jump, "{found} {least}");
    for name in ["gas_conductance_limit", "gas_conductance_limit_error", "gas_conductance_grid_error"] {
        assert!(number(&small[name]) > 0.0, "{name}");
    }
    assert_eq!(run(folder, "check um.h5 --json")["differing"], 0);
    let large = run(folder, &format!("contact {surface} --unit mm --gas air --gas-pressure 101.325Pa --json"));
    // Lengths and mean free paths are a thousand times as large, and so are k/M and the units of length.
    let ratio = number(&large["loads"][0]["gas_conductance"]) / number(&small["gas_conductance"]);
    assert!((ratio / 1e-6 - 1.0).abs() < 1e-9, "{ratio}");
    let thin = run(folder, &format!("contact {surface} --unit um --gas helium --gas-pressure 1mPa --json"));
    let thin = &thin["loads"][0];
    let helium = Gas::Helium.between(300.0, 1e-3, [Gas::Helium.accommodation(); 2]).unwrap();
    let limit = helium.conductivity / helium.jump * (1.0 - number(&thin["area_fraction"]));
    assert!((number(&thin["gas_conductance"]) * 1e-6 / limit - 1.0).abs() < 1e-5);
    // Friction shears the surfaces, which moves the gap a little.
    for (parts, file, within) in [("", "path.h5", 1e-4), ("--friction 0.3 --lateral 0,1nm", "rubbed.h5", 0.05)] {
        let path = run(folder, &format!("path {surface} --unit um --gas air {parts} --steps 1 --out {file} --json"));
        let step = path["steps"].as_array().unwrap().last().unwrap().clone();
        assert!((number(&step["gas_conductance"]) * 1e-6 / found - 1.0).abs() < within, "{file}");
        assert_eq!(run(folder, &format!("check {file} --json"))["differing"], 0);
    }
}

/// The mean is one of the points of the patch, of the profile, and with a law of the points without repulsion.
#[test]
fn all_gaps_have_a_gas() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for parts in [
        "--boundary free",
        "--dim 2",
        "--law exponential --param gamma=1e-4 --param range=2e-3",
        "--hardness 0.05",
        "--height 0.5 --second-body 2,0.3",
    ] {
        let gas = "--gas-conductivity 3 --gas-jump 0.001";
        run(folder, &format!("contact --n 32 --p-star 0.05 {parts} {gas} --out a.h5 --json"));
        let file = gfmd_files::Reader::open(folder.join("a.h5")).unwrap();
        let pressure = if parts.contains("law") { "/fields/repulsion" } else { "/fields/pressure" };
        let [pressure, gap] = [pressure, "/fields/gap"].map(|name| file.values::<f64>(name).unwrap());
        let open = pressure.iter().zip(&gap).filter(|(p, _)| **p <= 0.0);
        let sum: f64 = open.map(|(_, gap)| 3.0 / (gap.max(0.0) + 1e-3)).sum();
        let found = file.values::<f64>("/loads/gas_conductance").unwrap()[0];
        assert!((found / (sum / gap.len() as f64) - 1.0).abs() < 1e-12, "{parts}: {found}");
        assert_eq!(run(folder, "check a.h5 --json")["differing"], 0, "{parts}");
    }
}

#[test]
fn leaks_and_conductances_stand_in_the_headline_of_pages() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let asked = "--n 32 --eps-f-inv 4 --size 100um --young 70GPa --pressure 100MPa --statistics --flow --gas air \
                 --conductivity 10W/(m*K),20W/(m*K) --viscosity 1mPa*s --pressure-drop 1bar --json";
    for (command, file) in [("contact", "c.h5"), ("path --steps 1", "p.h5")] {
        run(folder, &format!("{command} {asked} --out {file}"));
        assert_eq!(run(folder, &format!("check {file} --json"))["differing"], 0, "{command}");
        assert!(gfmd(folder, &["report", file, "--out", "page.html"]).status.success());
        let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
        for words in ["leaks along x", "conducted by the contacts", "conducted by the gas"] {
            assert_eq!(page.matches(words).count(), 1, "{command}: {words}");
        }
        assert!(page.contains("W/(m² K)") && page.contains("l/s"), "{command}");
    }
}

/// A groove along y leaks along y only; zero has the unit of the leak beside it, in the table and on the page.
#[test]
fn a_leak_of_zero_has_the_unit_of_the_other_one() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let asked = "contact --shape wave:A=1um,Lx=100um --n 16 --size 100um --young 70GPa --pressure 1MPa --flow \
                 --fluid water --pressure-drop 1bar --out g.h5";
    let output = gfmd(folder, &asked.split_whitespace().collect::<Vec<_>>());
    let table = String::from_utf8(output.stdout).unwrap();
    assert!(table.contains("leak x / (nl/s)") && table.contains("leak y / (nl/s)"), "{table}");
    assert!(gfmd(folder, &["report", "g.h5", "--out", "page.html"]).status.success());
    let page = std::fs::read_to_string(folder.join("page.html")).unwrap();
    assert!(page.contains("nl/s") && !page.contains(" l/s"), "{page}");
}

#[test]
fn a_gas_that_is_not_known_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let known = "--unit um --young 1GPa --gas air";
    for (flags, message) in [
        ("--gas air", "--gas is air; it must be given with units of length and stress (--unit um)"),
        ("--unit um --young 3 --gas air", "(--stress-unit Pa), or replaced by --gas-conductivity and --gas-jump"),
        ("--gas-jump 1", "--gas-conductivity is missing; it is needed with --gas-jump"),
        ("--gas-conductivity 1", "--gas-jump is missing; it is needed with --gas-conductivity"),
        ("--gas-conductivity 1 --gas-jump 0", "--gas-jump is 0; it must be positive and finite"),
        ("--gas-conductivity 1 --gas-jump 1 --gas-pressure 1", "--gas-pressure is given; it must be left out without"),
        ("--gas-accommodation 1", "--gas-accommodation is given; it must be left out without --gas"),
        (&format!("{known} --gas-jump 1"), "--gas is air; it must be left out with --gas-conductivity and --gas-jump"),
        (&format!("{known} --gas-temperature 20"), "the temperature is 20 K; it must be from 200 to 1000 K"),
        (&format!("{known} --gas-pressure 3MPa"), "the pressure is 3MPa = 3000000 Pa; it must be positive"),
        (&format!("{known} --gas-accommodation 1,2"), "an accommodation coefficient is 2; it must be above 0"),
        (&format!("{known} --gas-accommodation 1,1,1"), "it must be one or two numbers"),
        (&format!("{known} --finite-slope"), "the vertical gap is not their distance"),
        (&format!("{known} --height 1 --lower-seed 2"), "each face has a gap of its own"),
    ] {
        let words = format!("contact --n 16 --p-star 0.1 {flags}");
        let output = gfmd(folder.path(), &words.split_whitespace().collect::<Vec<_>>());
        let text = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(2) && text.contains(message), "{flags}: {text}");
    }
}
