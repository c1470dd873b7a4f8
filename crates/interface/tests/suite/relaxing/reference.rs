//! Paths solved by dense matrices and active sets (`data/reference/viscoelastic/path.json`).

use gfmd_contact::{Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_medium::{Prony, Relaxes};
use ndarray::Array2;
use serde_json::Value;

use super::{follow, relaxing};
use crate::{legs, numbers};

#[test]
fn every_path_has_the_values_of_dense_solutions() {
    let text = include_str!("../../../../../data/reference/viscoelastic/path.json");
    let all: Value = serde_json::from_str(text).unwrap();
    for problem in all["problems"].as_array().unwrap() {
        let name = problem["name"].as_str().unwrap();
        let of = |key: &str| problem[key].as_f64().unwrap();
        let (shape, lengths) = (numbers(&problem["shape"]), numbers(&problem["length"]));
        let [nx, ny] = [shape[0] as usize, shape[1] as usize];
        let grid = match ny {
            1 => Grid::line(nx, lengths[0]).unwrap(),
            _ => Grid::new([nx, ny], [lengths[0], lengths[1]]).unwrap(),
        };
        let rows: Vec<f64> = problem["heights"].as_array().unwrap().iter().flat_map(numbers).collect();
        let heights = Array2::from_shape_vec((nx, ny), rows).unwrap();
        let pairs: Vec<(f64, f64)> =
            problem["prony"].as_array().unwrap().iter().map(numbers).map(|pair| (pair[0], pair[1])).collect();
        let prony = Prony::from_fractions(&pairs).unwrap();
        let relaxes: Relaxes = problem["relaxes"].as_str().unwrap().parse().unwrap();
        let given = Material::from_young(of("young"), of("poisson")).unwrap();
        let material = match problem["moduli"].as_str().unwrap() {
            "instantaneous" => prony.long_term(&given, relaxes).unwrap(),
            _ => given,
        };
        let body = match problem["height"].as_f64() {
            Some(height) => Body::slab(material, height).unwrap(),
            None => Body::half_space(material),
        };
        let load = if problem["control"] == "pressure" { Load::MeanPressure } else { Load::Approach };
        let path = legs(&numbers(&problem["waypoints"]), &numbers(&problem["time"]), of("steps") as usize, load);
        let contact = relaxing(&body, &grid, &heights, &prony, relaxes);
        let states = follow(&contact, &path, 1e-11);
        let results = problem["results"].as_array().unwrap();
        assert_eq!(states.len(), results.len(), "{name}");
        for (step, (state, known)) in states.iter().zip(results).enumerate() {
            let summary = state.summary();
            let energy = results.iter().map(|result| result["elastic_energy"].as_f64().unwrap()).fold(0.0, f64::max);
            let found = [
                ("time", state.time, 1.0),
                ("mean_pressure", state.mean_pressure(), 1e-3),
                ("approach", state.approach(), 1e-2),
                ("area_fraction", summary.area_fraction, 1.0),
                ("mean_gap", summary.mean_gap, 1e-2),
                ("max_pressure", summary.max_pressure, 1e-1),
                ("elastic_energy", state.elastic_energy(), energy),
                ("dissipated", state.losses.total(), energy),
                ("work_imbalance", state.work_imbalance, energy),
            ];
            for (key, found, floor) in found {
                let known = known[key].as_f64().unwrap();
                let apart = (found - known).abs() / known.abs().max(floor);
                assert!(apart <= 1e-8, "{name}, step {step}: {key} is {found:e}, not {known:e} ({apart:.1e})");
            }
        }
    }
}
