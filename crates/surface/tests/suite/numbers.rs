//! Parameters of ISO 25178 and ISO 21920: values of an independent implementation, `data/reference`.

use gfmd_surface::{Areal, Direction, Features, Grid, MotifEdges, PowerSpectrum, ProfileNumbers, Texture};
use ndarray::Array2;
use serde_json::Value;

/// Returns the k-th number of splitmix64 with this seed, from 0 to 1.
fn uniform(seed: u64, k: u64) -> f64 {
    let mut z = seed.wrapping_add((k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 * 2.0_f64.powi(-53)
}

/// Returns the sum of twelve uniform numbers less 6, for the p-th point.
fn noise(seed: u64, p: u64) -> f64 {
    (0..12).fold(0.0, |sum, q| sum + uniform(seed, 12 * p + q)) - 6.0
}

fn lists(value: &Value) -> Vec<Vec<f64>> {
    let numbers = |value: &Value| value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    value.as_array().map_or_else(Vec::new, |list| list.iter().map(numbers).collect())
}

/// Builds the heights of a case.
fn heights(input: &Value) -> (Array2<f64>, Grid) {
    let [nx, ny] = [0, 1].map(|axis| input["n"][axis].as_u64().unwrap() as usize);
    let length = |axis: usize, n: usize| match input["spacing"].as_f64() {
        Some(spacing) => spacing * n as f64,
        None => input["length"][axis].as_f64().unwrap(),
    };
    let grid = Grid::new([nx, ny], [length(0, nx), length(1, ny)]).unwrap();
    let (waves, powers) = (lists(&input["waves"]), lists(&input["polynomial"]));
    let seeded =
        input["noise"].as_object().map(|noise| (noise["seed"].as_u64().unwrap(), noise["amplitude"].as_f64().unwrap()));
    let made = Array2::from_shape_fn((nx, ny), |(i, j)| {
        let (u, v) = (i as f64 / nx as f64, j as f64 / ny as f64);
        let wave = |w: &Vec<f64>| w[0] * (std::f64::consts::TAU * (w[1] * u + w[2] * v) + w[3]).cos();
        let power = |c: &Vec<f64>| c[0] * u.powi(c[1] as i32) * v.powi(c[2] as i32);
        let random = seeded.map_or(0.0, |(seed, amplitude)| amplitude * noise(seed, (i * ny + j) as u64));
        let sum = waves.iter().map(wave).sum::<f64>() + powers.iter().map(power).sum::<f64>() + random;
        let grown = input["exp"].as_f64().map_or(sum, |factor| (factor * sum).exp());
        input["clip"].as_f64().map_or(grown, |most| grown.min(most))
    });
    (made, grid)
}

/// Compares numbers with the expected values, which have twelve digits, relative to `scale` or to larger values.
fn compare(case: &Value, found: &[(&str, f64)], scale: f64) {
    for (key, found) in found {
        let expected = case["expect"][*key].as_f64().unwrap_or_else(|| panic!("{key} in {case}"));
        assert!(
            (found - expected).abs() <= 2e-11 * scale.max(expected.abs()),
            "{} {key}: {found} for {expected}",
            case["name"]
        );
    }
}

fn cases(kind: &str) -> Vec<Value> {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/reference/surface_numbers.json");
    let json: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let cases = json["cases"].as_array().unwrap();
    cases.iter().filter(|case| case["name"].as_str().unwrap().starts_with(kind)).cloned().collect()
}

#[test]
fn bearing_curves_have_the_parameters_of_their_integrals() {
    let cases = cases("bearing");
    assert_eq!(cases.len(), 5);
    for case in cases {
        let (heights, grid) = heights(&case["input"]);
        let found = Areal::of(&heights, &grid).unwrap();
        let (core, volumes) = (found.core.unwrap(), found.volumes.unwrap());
        let numbers = [
            ("sk", core.sk),
            ("spk", core.spk),
            ("svk", core.svk),
            ("smr1", core.smr1),
            ("smr2", core.smr2),
            ("spkx", core.spkx),
            ("svkx", core.svkx),
            ("top_above_mean", core.top),
            ("vmp", volumes.vmp),
            ("vmc", volumes.vmc),
            ("vvc", volumes.vvc),
            ("vvv", volumes.vvv),
            ("sxp", volumes.sxp),
            ("sdc_10_80", volumes.sdc),
        ];
        compare(&case, &numbers, 10.0);
        let bearing = Texture::of(&heights, &grid, true).unwrap().bearing;
        assert_eq!(bearing.core, Some(core));
    }
}

#[test]
fn developed_area_is_the_mean_of_both_diagonals() {
    let [case] = &cases("area")[..] else { panic!() };
    let (heights, grid) = heights(&case["input"]);
    compare(case, &[("sdr_both_diagonals", Areal::of(&heights, &grid).unwrap().sdr)], 1.0);
}

#[test]
fn hills_and_dales_remain_by_wolf_pruning() {
    let cases = cases("features");
    assert_eq!(cases.len(), 6);
    for case in cases {
        let (heights, grid) = heights(&case["input"]);
        let edges = match case["operation"]["edge"].as_str().unwrap() {
            "all" => MotifEdges::All,
            "periodic" => MotifEdges::Periodic,
            _ => MotifEdges::LeaveOut,
        };
        let wolf = case["operation"]["wolf"].as_f64().unwrap();
        let found = Features::of(&heights, &grid, wolf, edges).unwrap().unwrap();
        let number = |value: Option<f64>| value.unwrap();
        let numbers = [
            ("np", found.hills.count as f64),
            ("nv", found.dales.count as f64),
            ("spd", found.hills.density),
            ("svd", found.dales.density),
            ("spc", number(found.hills.curvature)),
            ("svc", number(found.dales.curvature)),
            ("s5p", number(found.hills.five)),
            ("s5v", number(found.dales.five)),
            ("s10z", number(found.s10z())),
            ("sha", number(found.hills.area)),
            ("sda", number(found.dales.area)),
        ];
        compare(&case, &numbers, 10.0);
    }
}

#[test]
fn a_wave_has_its_direction() {
    let [case] = &cases("direction")[..] else { panic!() };
    let (heights, grid) = heights(&case["input"]);
    let spectrum = PowerSpectrum::of(&heights, &grid).unwrap();
    let found = Direction::of(&spectrum, Some(0.1));
    compare(case, &[("ssw", found.ssw.unwrap()), ("steepest_degrees", found.steepest.unwrap())], 10.0);
    let expected = case["expect"]["wave_vector_degrees"].as_f64().unwrap();
    assert!((found.wave.unwrap() - expected).abs() <= 1.0, "{found:?}");
    assert!((found.lay().unwrap() - expected - 90.0).abs() <= 1.0, "{found:?}");
    assert_eq!(Direction::of(&spectrum, Some(0.6)).lay(), None, "an isotropic surface has no direction");
    let upside =
        Direction::of(&PowerSpectrum::of(&heights.slice(ndarray::s![..;-1, ..]).to_owned(), &grid).unwrap(), Some(0.1));
    assert!((upside.wave.unwrap() - (180.0 - expected)).abs() <= 1.0, "{upside:?}");
    assert!((upside.steepest.unwrap() + found.steepest.unwrap()).abs() < 1e-9, "{upside:?}");
    let flat = Direction::of(&PowerSpectrum::of(&Array2::zeros((8, 8)), &Grid::square(8, 1.0).unwrap()).unwrap(), None);
    assert_eq!(flat, Direction { wave: None, steepest: None, anisotropy: None, ssw: None });
}

#[test]
fn a_profile_has_its_parameters() {
    let [case] = &cases("profile")[..] else { panic!() };
    let (heights, grid) = heights(&case["input"]);
    let section = grid.lengths()[0] / case["operation"]["sections"].as_f64().unwrap();
    let found = ProfileNumbers::of(&heights, &grid, section).unwrap();
    let core = found.core.unwrap();
    let numbers = [
        ("ra", found.ra),
        ("rq", found.rq),
        ("rsk", found.rsk.unwrap()),
        ("rku", found.rku.unwrap()),
        ("rt", found.rt),
        ("rz", found.rz),
        ("rzx", found.rzx),
        ("rp", found.rp),
        ("rv", found.rv),
        ("rdq_forward", found.rdq),
        ("rk", core.sk),
        ("rpk", core.spk),
        ("rvk", core.svk),
        ("rmr1", core.smr1),
        ("rmr2", core.smr2),
        ("rsm", found.rsm.unwrap()),
    ];
    compare(case, &numbers, 10.0);
    assert_eq!(found.sections, 5);
    let back = ProfileNumbers::of(&heights.slice(ndarray::s![..;-1, ..]).to_owned(), &grid, section).unwrap();
    assert!((back.rsm.unwrap() - found.rsm.unwrap()).abs() < 1e-12);
    let upside = ProfileNumbers::of(&heights.mapv(|height| -height), &grid, section).unwrap();
    assert!((upside.rp - found.rv).abs() < 1e-14, "{upside:?}");
    assert!((upside.rsm.unwrap() - found.rsm.unwrap()).abs() < 1e-12, "{upside:?}");
    let line = Grid::line(10, 10.0).unwrap();
    let flat = ProfileNumbers::of(&Array2::ones((10, 1)), &line, 5.0).unwrap();
    assert_eq!((flat.ra, flat.rsk, flat.core, flat.rsm, flat.sections), (0.0, None, None, None, 2));
    assert!(ProfileNumbers::of(&heights, &grid, 0.5).is_err());
    assert!(ProfileNumbers::of(&heights, &grid, f64::NAN).is_err());
    assert!(ProfileNumbers::of(&Array2::from_elem((10, 1), f64::NAN), &line, 5.0).is_err());
    assert!(ProfileNumbers::of(&Array2::zeros((4, 4)), &Grid::square(4, 1.0).unwrap(), 1.0).is_err());
}
