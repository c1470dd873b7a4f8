//! Nine problems, each solved by two algorithms that agree to 1e-10 (`reference.json`).

use std::f64::consts::TAU;

use gfmd_plasticity::ndarray::Array2;
use gfmd_plasticity::{Body, Budget, Cells, Fields, Grid, Hardening, Load, Material, PlasticState, YieldingContact};
use serde_json::Value;

/// Problems of the reference.
pub(crate) fn cases() -> Vec<Value> {
    let text = include_str!("../reference.json");
    let reference: Value = serde_json::from_str(text).unwrap();
    reference["cases"].as_array().unwrap().clone()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(number).collect()
}

fn heights(grid: &Grid, kind: &str, size: f64) -> Array2<f64> {
    let [nx, ny] = grid.points();
    let lengths = grid.lengths();
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let [x, y] = [TAU * i as f64 / nx as f64, TAU * j as f64 / ny as f64];
        match kind {
            "sphere" => {
                let near = |k: usize, n: usize, length: f64| k.min(n - k) as f64 * length / n as f64;
                let [dx, dy] = [near(i, nx, lengths[0]), near(j, ny, lengths[1])];
                -(dx * dx + dy * dy) / (2.0 * size)
            }
            "wave" if ny == 1 => size * x.cos() / 2.0,
            "wave" => size * (x.cos() + y.cos()) / 2.0,
            "waves" => size * (x.cos() + 0.6 * (2.0 * x + y + 0.7).cos() + 0.4 * (x - 2.0 * y - 1.1).cos()),
            other => panic!("unknown surface {other}"),
        }
    })
}

/// Makes the contact of a problem.
pub(crate) fn contact(problem: &Value) -> YieldingContact {
    let n = numbers(&problem["n"]);
    let points = [n[0] as usize, n[1] as usize];
    let length = numbers(&problem["length"]);
    let grid =
        if points[1] == 1 { Grid::line(points[0], length[0]) } else { Grid::new(points, [length[0], length[1]]) };
    let grid = grid.unwrap();
    let material = |young: &Value, poisson: &Value| Material::from_young(number(young), number(poisson)).unwrap();
    let top = material(&problem["young"], &problem["poisson"]);
    let slab = || Body::slab(top, number(&problem["height"])).unwrap();
    let layer = || {
        let layer = problem["layer"].as_array().unwrap();
        Body::slab(material(&layer[0], &layer[1]), number(&layer[2])).unwrap()
    };
    let mut hardening = match problem.get("hardening_curve") {
        Some(curve) => {
            let points: Vec<[f64; 2]> =
                curve.as_array().unwrap().iter().map(|row| [number(&row[0]), number(&row[1])]).collect();
            Hardening::from_curve(&points).unwrap()
        }
        None => Hardening::new(number(&problem["yield"])).unwrap(),
    };
    if let Some(modulus) = problem.get("hardening") {
        hardening = hardening.isotropic(number(modulus)).unwrap();
    }
    if let Some(modulus) = problem.get("kinematic") {
        hardening = hardening.kinematic(number(modulus)).unwrap();
    }
    let mut all = vec![Some(hardening.clone())];
    let mut body = match problem["body"].as_str().unwrap() {
        "half-space" => Body::half_space(top),
        "slab" => slab(),
        "sliding" => slab().on(gfmd_green::Base::SLIDING).unwrap(),
        "layer" => {
            all.push(None);
            slab().bonded_to(Body::half_space(material(&problem["base_young"], &problem["base_poisson"]))).unwrap()
        }
        "layers" => {
            all.push(None);
            slab().bonded_to(layer()).unwrap()
        }
        "two-yields" => {
            all.push(Some(hardening.with_yield_stress(number(&problem["layer_yield"])).unwrap()));
            slab().bonded_to(layer()).unwrap()
        }
        other => panic!("unknown body {other}"),
    };
    if let Some(second) = problem.get("second_body") {
        body = body.against(Body::half_space(material(&second[0], &second[1])));
    }
    let coarsenings = problem.get("coarsening").map(|all| numbers(all).into_iter().map(|s| s as usize).collect());
    let cells = Cells::List { thicknesses: numbers(&problem["cells"]), coarsenings: coarsenings.unwrap_or_default() };
    let (kind, size) = (problem["surface"][0].as_str().unwrap(), number(&problem["surface"][1]));
    YieldingContact::new(&body, &grid, &heights(&grid, kind, size), &all, &cells).unwrap()
}

/// Returns the load of a step.
pub(crate) fn load(step: &Value) -> Load {
    match step[0].as_str().unwrap() {
        "pressure" => Load::MeanPressure(number(&step[1])),
        _ => Load::Approach(number(&step[1])),
    }
}

/// Returns the numbers of a state, by their names in the reference, with the unit in which they are compared.
pub(crate) fn measures(state: &PlasticState, work: f64) -> Vec<(&'static str, f64, Option<f64>)> {
    let summary = state.summary();
    let displacement = state.plastic_displacement_measures();
    let energy = Some(state.elastic_energy);
    vec![
        ("displacement", state.approach(), None),
        ("mean_pressure", state.mean_pressure(), None),
        ("area_fraction", summary.area_fraction, None),
        ("max_pressure", summary.max_pressure, None),
        ("elastic_energy", state.elastic_energy, None),
        ("hardening_energy", state.hardening_energy, energy),
        ("dissipated", state.dissipated, energy),
        ("work_imbalance", state.work_imbalance, Some(work)),
        ("plastic_strain_integral", state.plastic_strain_integral(), None),
        ("max_plastic_strain", state.max_plastic_strain(), None),
        ("yielded_volume", state.yielded_volume(), None),
        ("yield_depth", state.yield_depth(), None),
        ("plastic_displacement_mean", displacement.mean, None),
        ("plastic_displacement_rms", displacement.rms, None),
        ("plastic_displacement_min", displacement.min, None),
    ]
}

#[expect(clippy::print_stdout, reason = "`--nocapture` shows the worst difference and the effort")]
fn meets(name: &str) {
    let cases = cases();
    let case = cases.iter().find(|case| case["problem"]["name"] == name).unwrap();
    let contact = contact(&case["problem"]);
    let budget = Budget { tolerance: 1e-11, max_iterations: 2000 };
    let mut state = contact.rest().unwrap();
    let mut worst = (0.0, String::new());
    let mut costs = Vec::new();
    let steps = case["problem"]["path"].as_array().unwrap().iter().zip(case["steps"].as_array().unwrap());
    for (number_of_step, (step, reference)) in steps.enumerate() {
        let next = contact.step(&state, load(step), &budget, &mut ()).unwrap();
        let work = 0.5 * (next.mean_pressure() + state.mean_pressure()) * (next.approach() - state.approach()).abs();
        costs.push((next.operators, next.effort().transform_pairs.round()));
        for (key, found, unit) in measures(&next, work) {
            let wanted = number(&reference[key]);
            let unit = unit.unwrap_or(wanted.abs()).max(f64::MIN_POSITIVE);
            let error = if found == wanted { 0.0 } else { (found - wanted).abs() / unit };
            if error.is_nan() || error > worst.0 {
                worst = (error, format!("step {number_of_step}: {key} is {found:e}, not {wanted:e}"));
            }
        }
        state = next;
    }
    println!("{name}: worst {:.1e} ({}); operators, pairs {costs:?}", worst.0, worst.1);
    assert!(worst.0 <= 1e-8, "{name}: {:e}, {}", worst.0, worst.1);
}

macro_rules! problems {
    ($($test:ident $name:literal)*) => {
        $(
            #[test]
            fn $test() {
                meets($name);
            }
        )*

        #[test]
        fn no_problem_is_left_out() {
            let names = [$($name),*];
            assert!(cases().iter().all(|case| names.contains(&case["problem"]["name"].as_str().unwrap())));
        }
    };
}

problems! {
    a_sphere_on_a_half_space "sphere-half-space"
    a_wave_on_an_ideally_plastic_slab "wave-slab-perfect"
    kinematic_hardening_of_a_layer "waves-layer-kinematic"
    a_profile_on_two_layers "profile-two-layers"
    an_odd_grid_with_an_elastic_start "odd-grid-elastic-start"
    coarser_grids_below "coarser-below"
    a_hardening_curve_below_a_second_body "curve-second-body"
    a_sliding_base "sliding-base"
    two_yield_stresses "two-yields"
}
