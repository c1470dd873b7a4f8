//! Against closed forms evaluated elsewhere (data/reference).

use approx::assert_relative_eq;
use gfmd_law::{Friction, Kind, Limit, Rate};
use serde_json::Value;

fn read(name: &str) -> Value {
    let path = format!("{}/../../data/reference/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn rows(table: &Value) -> Vec<Vec<Value>> {
    table["rows"].as_array().unwrap().iter().map(|row| row.as_array().unwrap().clone()).collect()
}

#[track_caller]
fn near(found: f64, wanted: &Value) {
    // Rounding of the reference's own terms where they cancel.
    assert_relative_eq!(found, wanted.as_f64().unwrap(), max_relative = 1e-12, epsilon = 1e-13);
}

#[test]
fn cohesive_laws() {
    let rows = rows(&read("cohesive_laws"));
    assert!(rows.len() > 30);
    for row in &rows {
        let number = |i: usize| row[i].as_f64().unwrap();
        let kind = match row[0].as_str().unwrap() {
            "XN" => Kind::XuNeedleman,
            "BSG" => Kind::BoschSchreursGeers,
            "C3D" => Kind::CoupledExponential,
            "NPB" => Kind::Npb,
            "NPC" => Kind::Npc,
            other => panic!("an unknown law {other}"),
        };
        let mut given =
            vec![("phi_n", number(3)), ("phi_t", number(4)), ("delta_n", number(5)), ("delta_t", number(6))];
        given.extend(row[8].as_f64().map(|r| ("r", r)));
        let law = kind.with(&given).unwrap();
        let response = law.response(number(1), number(2));
        let found = [response.traction, response.jacobian[0], response.jacobian[1]].concat();
        found.iter().zip(&row[9..15]).for_each(|(found, wanted)| near(*found, wanted));
        match row[15].as_f64() {
            Some(_) => near(law.energy(number(1), number(2)).unwrap(), &row[15]),
            None => assert_eq!(law.energy(number(1), number(2)), None),
        }
    }
}

#[test]
fn normal_laws() {
    let rows = rows(&read("normal_potentials"));
    assert!(rows.len() > 10);
    for row in &rows {
        let number = |i: usize| row[i].as_f64().unwrap();
        let (kind, name) = match row[0].as_str().unwrap() {
            "morse" => (Kind::Morse, "range"),
            "exp_adhesion" => (Kind::Exponential, "range"),
            "harmonic_cosine" => (Kind::HarmonicCosine, "curvature"),
            other => panic!("an unknown law {other}"),
        };
        let law = kind.with(&[("gamma", number(2)), (name, number(3))]).unwrap();
        near(law.energy(number(1), 0.0).unwrap(), &row[4]);
        near(law.response(number(1), 0.0).traction[0], &row[5]);
        near(law.response(number(1), 0.0).jacobian[0][0], &row[6]);
    }
}

#[test]
fn friction() {
    let rows = rows(&read("friction_laws"));
    assert!(rows.len() >= 5);
    for row in &rows {
        let number = |i: usize| row[i].as_f64().unwrap();
        let [slip, foot, stiffness, coefficient, pressure] = [0, 1, 2, 3, 4].map(number);
        for (limit, column) in [(Limit::Coulomb(coefficient), 5), (Limit::Tresca(0.5), 8)] {
            let friction = Friction::new(limit, stiffness).unwrap();
            // Along a direction that is no axis.
            let along = [0.6, -0.8];
            let found = friction.slide(along.map(|c| c * slip), along.map(|c| c * foot), pressure);
            near(0.6 * found.traction[0] - 0.8 * found.traction[1], &row[column]);
            near(0.6 * found.foot[0] - 0.8 * found.foot[1], &row[column + 1]);
            assert_eq!(found.sticks, row[column + 2].as_bool().unwrap());
        }
        near(Rate::Arctangent { velocity: 0.01 }.traction(coefficient * pressure, [slip, 0.0])[0], &row[11]);
        near(Rate::Root { velocity: 0.01 }.traction(coefficient * pressure, [0.0, slip])[1], &row[12]);
    }
}
