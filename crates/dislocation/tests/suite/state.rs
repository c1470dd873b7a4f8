//! States against Head's closed form, a boundary-value problem of a slab, and their own energy.

use gfmd_dislocation::{DislocationError, Domain, Edge, State, Step};
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Material};
use serde_json::Value;

fn reference() -> Value {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/reference/dislocation_images.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect()
}

fn rows(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().unwrap().iter().map(numbers).collect()
}

fn material() -> Material {
    Material::from_young(2.6, 0.3).unwrap()
}

fn compare(state: &State, file: &Value, wanted: &Value, bound: f64) {
    let scale = rows(&wanted["forces"]).concat().iter().fold(0.0, |most: f64, f| most.max(f.abs()));
    for (i, wanted) in rows(&wanted["forces"]).iter().enumerate() {
        let found = state.force(i).unwrap();
        for axis in 0..2 {
            assert!((found[axis] - wanted[axis]).abs() < bound * scale, "force {i}: {found:?} {wanted:?}");
        }
    }
    let scale = rows(&wanted["stresses"]).concat().iter().fold(0.0, |most: f64, f| most.max(f.abs()));
    for (place, wanted) in rows(&file["places"]).iter().zip(rows(&wanted["stresses"])) {
        let found = state.stress([place[0], place[1]], None).unwrap();
        for (found, wanted) in [found.xx, found.zz, found.xz].iter().zip(&wanted) {
            assert!((found - wanted).abs() < bound * scale, "stress at {place:?}: {found} {wanted}");
        }
    }
}

fn edges_of(file: &Value) -> Vec<Edge> {
    rows(&file["edges"]).iter().map(|e| Edge { place: [e[0], e[1]], burgers: [e[2], e[3]] }).collect()
}

#[test]
fn forces_and_stresses_are_those_of_head_and_of_a_boundary_value_problem() {
    let file = reference();
    let grid = Grid::line(255, 1.0).unwrap();
    let edges = edges_of(&file);
    for (body, key) in [(Body::half_space(material()), "half_space"), (Body::slab(material(), 0.35).unwrap(), "slab")] {
        let domain = Domain::new(&body, &grid, &[false; 255]).unwrap();
        let state = domain.state(&edges, &[], 0.0, 0.0).unwrap();
        compare(&state, &file, &file[key], 1e-9);
        // A free surface without any pressure.
        assert!(state.mean_pressure().abs() < 1e-15);
        for i in 0..7 {
            let stress = state.stress([0.1 * f64::from(i) + 0.03, 0.0], None).unwrap();
            assert!(stress.zz.abs() + stress.xz.abs() < 1e-9, "{stress:?}");
        }
    }
}

/// Three dislocations on two planes at 60 degrees below a punch, with the steps of departed ones: one coordinate along
/// each plane, and the depth.
struct Case {
    domain: Domain,
    angle: f64,
}

const SIGNS: [f64; 3] = [1.0, -1.0, 1.0];
const PLANES: [f64; 3] = [0.4, 0.4, 0.61];

impl Case {
    fn state(&self, along: [f64; 3], depth: f64) -> State {
        let (c, s) = (self.angle.cos(), self.angle.sin());
        let b = 0.003;
        let edges: Vec<Edge> = (0..3)
            .map(|i| Edge {
                place: [PLANES[i] + along[i] * c, along[i] * s],
                burgers: [SIGNS[i] * b * c, SIGNS[i] * b * s],
            })
            .collect();
        // The partner of the third dislocation has left on its plane.
        let step = Step { x: 0.61, jump: [b * c, b * s] };
        let nu = self.domain.material().poisson();
        let rise: f64 = (0..3).map(|i| SIGNS[i] * b * s * c * along[i]).sum::<f64>() * (1.0 - 2.0 * nu) / (1.0 - nu);
        self.domain.state(&edges, &[step], rise, depth).unwrap()
    }
}

#[test]
fn forces_are_the_slopes_of_the_energy() {
    let grid = Grid::line(127, 1.0).unwrap();
    let held: Vec<bool> = (0..127).map(|i| (50..77).contains(&i)).collect();
    for (body, held, angle) in [
        (Body::slab(material(), 0.5).unwrap(), held.clone(), 1.0471975511965976_f64),
        (Body::half_space(material()), held, 2.2),
        (Body::slab(material(), 0.5).unwrap(), vec![false; 127], 0.9),
    ] {
        let case = Case { domain: Domain::new(&body, &grid, &held).unwrap(), angle };
        let (along, depth) = ([-0.15, -0.31, -0.22], 0.004);
        let state = case.state(along, depth);
        let step = 1e-5;
        let slope = |move_by: [f64; 4]| {
            let at = |sign: f64| {
                let along = std::array::from_fn(|i| along[i] + sign * move_by[i]);
                case.state(along, depth + sign * move_by[3]).energy()
            };
            (at(1.0) - at(-1.0)) / (2.0 * step)
        };
        let (c, s) = (angle.cos(), angle.sin());
        let forces: [f64; 3] = std::array::from_fn(|i| {
            let [x, z] = state.force(i).unwrap();
            x * c + z * s
        });
        let scale = forces.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
        for i in 0..3 {
            let mut by = [0.0; 4];
            by[i] = step;
            let found = -slope(by);
            assert!((found - forces[i]).abs() < 1e-6 * scale, "{i}: {found} {}", forces[i]);
        }
        let load = slope([0.0, 0.0, 0.0, step]);
        assert!(
            (load - state.mean_pressure()).abs() < 1e-6 * state.mean_pressure().abs().max(1e-3),
            "{load} {}",
            state.mean_pressure()
        );
    }
}

#[test]
fn what_makes_no_domain_is_refused() {
    let grid = Grid::line(31, 1.0).unwrap();
    let slab = Body::slab(material(), 0.5).unwrap();
    assert!(matches!(
        Domain::new(&slab.clone().on(Base::FREE).unwrap(), &grid, &[false; 31]),
        Err(DislocationError::Body)
    ));
    let even = Grid::line(32, 1.0).unwrap();
    assert!(matches!(Domain::new(&slab, &even, &[false; 32]), Err(DislocationError::Points { found: 32 })));
    assert!(matches!(Domain::new(&slab, &grid, &[false; 30]), Err(DislocationError::Shape(_))));
    let domain = Domain::new(&slab, &grid, &[false; 31]).unwrap();
    for z in [0.0, -0.5, 0.1, -0.6, f64::NAN] {
        let edge = Edge { place: [0.0, z], burgers: [0.1, 0.0] };
        assert!(domain.state(&[edge], &[], 0.0, 0.0).is_err(), "{z}");
    }
    assert!(domain.state(&[], &[], 0.0, f64::NAN).is_err());
}
