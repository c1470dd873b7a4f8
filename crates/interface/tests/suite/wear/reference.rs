//! Paths solved by dense matrices and active sets (`data/reference/viscoelastic/wear.json`).

use gfmd_contact::{Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use ndarray::Array2;
use serde_json::Value;

use super::{follow, wearing};
use crate::{legs, numbers};

#[test]
fn every_path_has_the_values_of_dense_solutions() {
    let text = include_str!("../../../../../data/reference/viscoelastic/wear.json");
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
        let material = Material::from_young(of("young"), of("poisson")).unwrap();
        let body = match problem["height"].as_f64() {
            Some(height) => Body::slab(material, height).unwrap(),
            None => Body::half_space(material),
        };
        assert_eq!(problem["control"], "pressure", "{name}");
        let (values, distances) = (numbers(&problem["waypoints"]), numbers(&problem["distance"]));
        let path = legs(&values, &distances, of("steps") as usize, Load::MeanPressure);
        let states = follow(&wearing(&body, &grid, &heights, of("coefficient")), &path, 1e-11);
        let results = problem["results"].as_array().unwrap();
        assert_eq!(states.len(), results.len(), "{name}");
        let energy = results.iter().map(|result| result["elastic_energy"].as_f64().unwrap()).fold(0.0, f64::max);
        for (step, (state, known)) in states.iter().zip(results).enumerate() {
            let summary = state.summary();
            let (volume, deepest) = state.wear_volume_and_depth().unwrap();
            let found = [
                ("distance", state.distance, 1.0),
                ("mean_pressure", state.mean_pressure(), 1e-3),
                ("approach", state.approach(), 1e-2),
                ("area_fraction", summary.area_fraction, 1.0),
                ("contact_nodes", summary.contact_nodes as f64, 1.0),
                ("mean_gap", summary.mean_gap, 1e-2),
                ("max_pressure", summary.max_pressure, 1e-1),
                ("elastic_energy", state.elastic_energy(), energy),
                ("wear_volume", volume, 1e-2),
                ("max_wear", deepest, 1e-2),
                ("dissipated", state.losses.total(), energy),
            ];
            for (key, found, floor) in found {
                let known = known[key].as_f64().unwrap();
                let apart = (found - known).abs() / known.abs().max(floor);
                assert!(apart <= 1e-8, "{name}, step {step}: {key} is {found:e}, not {known:e} ({apart:.1e})");
            }
        }
    }
}
