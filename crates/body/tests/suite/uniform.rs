//! Mean traction inside every body, and fields below tractions, compared with an independent sum of waves on a
//! half-space.

use gfmd_body::{BaseField, Interior, InteriorError, State};
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Complex64, Material};

const I: Complex64 = Complex64::I;

fn noise(n: usize, seed: usize) -> Vec<f64> {
    (0..n).map(|i| ((i as f64 + 1.0) * (0.618_033 + 1e-3 * seed as f64)).fract() - 0.4).collect()
}

fn material(young: f64, poisson: f64) -> Material {
    Material::from_young(young, poisson).unwrap()
}

fn mean(values: impl ExactSizeIterator<Item = f64>) -> f64 {
    let count = values.len() as f64;
    values.sum::<f64>() / count
}

fn states(interior: &Interior, depth: f64) -> Vec<State> {
    let mut ws = interior.workspace();
    let deformation = interior.deformation(depth, &mut ws).unwrap();
    (0..deformation.len()).map(|i| deformation.at(i)).collect()
}

/// Returns the wave numbers of `n` points with their weights. For even `n`, the shortest wave is split into halves of
/// either sign.
fn numbers(n: usize) -> Vec<(i64, f64)> {
    let half = n as i64 / 2;
    let weight = |m: i64| if n > 1 && n.is_multiple_of(2) && m.abs() == half { 0.5 } else { 1.0 };
    (-half..=half).map(|m| (m, weight(m))).collect()
}

/// Computes the stresses xx, yy, zz, yz, xz, xy at one depth of a half-space under surface tractions (xz, yz, zz) as a
/// sum over waves (Boussinesq, Cerruti): Airy functions (c + c' q depth) e^(-q depth) in the plane of wave and normal,
/// and an antiplane wave. The mean of the tractions gives the uniform state without lateral strain.
fn half_space(poisson: f64, grid: &Grid, traction: [&[f64]; 3], depth: f64) -> Vec<[f64; 6]> {
    let ([nx, ny], [lx, ly]) = (grid.points(), grid.lengths());
    let turn = |m: i64, k: i64, i: usize, j: usize| {
        std::f64::consts::TAU * (m as f64 * i as f64 / nx as f64 + k as f64 * j as f64 / ny as f64)
    };
    let mut stress = vec![[0.0; 6]; nx * ny];
    for (m, wm) in numbers(nx) {
        for (k, wk) in numbers(ny) {
            let [tx, ty, tz] = traction.map(|field| {
                let terms = field.iter().enumerate().map(|(p, t)| (-I * turn(m, k, p / ny, p % ny)).exp() * *t);
                terms.sum::<Complex64>() / (nx * ny) as f64
            });
            let q = [std::f64::consts::TAU * m as f64 / lx, std::f64::consts::TAU * k as f64 / ly];
            let length = q[0].hypot(q[1]);
            let amplitude = if (m, k) == (0, 0) {
                let lateral = tz * (poisson / (1.0 - poisson));
                [lateral, lateral, tz, ty, tx, Complex64::ZERO]
            } else {
                let [nx, ny] = q.map(|q| q / length);
                let (b, decay) = (length * depth, (-length * depth).exp());
                let (along, across) = (tx * nx + ty * ny, ty * nx - tx * ny);
                let ll = (tz * (1.0 - b) + I * along * (2.0 - b)) * decay;
                let zz = (tz * (1.0 + b) + I * along * b) * decay;
                let lz = (I * tz * b + along * (1.0 - b)) * decay;
                let tt = (ll + zz) * poisson;
                let (tz, lt) = (across * decay, I * across * decay);
                [
                    ll * nx * nx + tt * ny * ny - lt * 2.0 * nx * ny,
                    ll * ny * ny + tt * nx * nx + lt * 2.0 * nx * ny,
                    zz,
                    lz * ny + tz * nx,
                    lz * nx - tz * ny,
                    (ll - tt) * nx * ny + lt * (nx * nx - ny * ny),
                ]
            };
            for (p, stress) in stress.iter_mut().enumerate() {
                let wave = (I * turn(m, k, p / ny, p % ny)).exp() * (wm * wk);
                stress.iter_mut().zip(amplitude).for_each(|(sum, amplitude)| *sum += (amplitude * wave).re);
            }
        }
    }
    stress
}

/// Computes u_z of a half-space under a pressure: 2 p/(E* q) for each wave, with zero mean.
fn sunk(material: &Material, grid: &Grid, pressure: &[f64]) -> Vec<f64> {
    let table = gfmd_green::normal_stiffness_table(&Body::half_space(*material), grid, 0.0);
    let compliance: Vec<f64> = table.iter().map(|k| if *k > 0.0 { -1.0 / k } else { 0.0 }).collect();
    let (transform, mut u) = (gfmd_field::Transform::new(*grid), vec![0.0; grid.len()]);
    transform.convolve(&compliance, pressure, &mut u, &mut transform.workspace()).unwrap();
    u
}

fn near(found: &[State], wanted: &[[f64; 6]], what: &str) {
    let scale = wanted.iter().flatten().fold(0.0, |most: f64, value| most.max(value.abs()));
    for (found, wanted) in found.iter().zip(wanted) {
        for k in 0..6 {
            assert!((found.stress[k] - wanted[k]).abs() < 1e-12 * scale, "{what}: {:?} {wanted:?}", found.stress);
        }
    }
}

/// All stresses below a pressure on some points equal the sum of waves, and open points bear no stress, also on even
/// grids.
#[test]
fn below_a_pressure_the_stresses_are_those_of_the_sum_of_waves() {
    for poisson in [-0.5, 0.3, 0.5] {
        let material = material(2.0, poisson);
        for grid in [
            Grid::new([7, 9], [1.0, 1.3]).unwrap(),
            Grid::new([8, 6], [1.0, 1.2]).unwrap(),
            Grid::new([8, 5], [1.0, 1.2]).unwrap(),
            Grid::line(11, 1.0).unwrap(),
            Grid::line(8, 1.0).unwrap(),
        ] {
            let pressure: Vec<f64> = noise(grid.len(), 3).into_iter().map(|p| p.max(0.0)).collect();
            let mean = mean(pressure.iter().copied());
            let interior =
                Interior::frictionless(&Body::half_space(material), grid, &sunk(&material, &grid, &pressure))
                    .and_then(|interior| interior.with_mean_traction([0.0, 0.0, -mean]))
                    .unwrap();
            let traction: Vec<f64> = pressure.iter().map(|p| -p).collect();
            let zero = vec![0.0; grid.len()];
            for depth in [0.0, 0.07, 0.5, 4.0] {
                let wanted = half_space(poisson, &grid, [&zero, &zero, &traction], depth);
                near(&states(&interior, depth), &wanted, &format!("{poisson} {:?} {depth}", grid.points()));
            }
            for (state, pressure) in states(&interior, 0.0).iter().zip(&pressure) {
                assert!((state.stress[2] + pressure).abs() < 1e-12, "{} {pressure}", state.stress[2]);
            }
            // Far below, the strain is uniform, and the points rise by it relative to the surface.
            let strain = (1.0 + poisson) * (1.0 - 2.0 * poisson) / (2.0 * (1.0 - poisson)) * -mean;
            let far = &states(&interior, 9.0)[0];
            assert!((far.strain[2] - strain).abs() < 1e-12 && far.strain[0].abs() < 1e-12, "{far:?}");
            let mut ws = interior.workspace();
            let u = *interior.displacement(9.0, &mut ws).unwrap().last().unwrap();
            assert!((u + 9.0 * strain).abs() < 1e-12, "{u} {strain}");
            // The uniform strain has the energy density of a confined column.
            assert!((far.energy_density() + 0.5 * mean * strain).abs() < 1e-12);
            let mises = mean * (1.0 - 2.0 * poisson) / (1.0 - poisson);
            assert!((far.von_mises() - mises).abs() < 1e-12, "{} {mises}", far.von_mises());
        }
    }
}

#[test]
fn below_shear_tractions_the_stresses_are_those_of_the_sum_of_waves() {
    for poisson in [0.0, 0.3, 0.5] {
        let body = Body::half_space(material(2.0, poisson));
        let grid = Grid::new([7, 9], [1.0, 1.3]).unwrap();
        let fields: [Vec<f64>; 3] = [1, 2, 3].map(|seed| noise(grid.len(), seed));
        let interior = Interior::of_traction(&body, grid, &fields.concat()).unwrap();
        for depth in [0.0, 0.1, 0.6] {
            let wanted = half_space(poisson, &grid, fields.each_ref().map(Vec::as_slice), depth);
            near(&states(&interior, depth), &wanted, &format!("{poisson} {depth}"));
        }
        let line = Grid::line(9, 1.0).unwrap();
        let [x, z] = [4, 5].map(|seed| noise(9, seed));
        let interior = Interior::of_traction(&body, line, &[x.clone(), z.clone()].concat()).unwrap();
        for depth in [0.0, 0.2] {
            near(&states(&interior, depth), &half_space(poisson, &line, [&x, &[0.0; 9], &z], depth), "line");
        }
    }
}

fn bodies() -> Vec<Body> {
    let (soft, hard, rubber) = (material(1.0, 0.3), material(7.0, 0.2), material(2.0, 0.5));
    let half_space = || Base::Elastic(Body::half_space(hard).into());
    vec![
        Body::half_space(soft),
        Body::half_space(rubber),
        Body::slab(soft, 0.4).unwrap(),
        Body::slab(material(2.0, 0.499_999_9), 0.4).unwrap(),
        Body::slab(rubber, 0.4).unwrap(),
        Body::slab(rubber, 0.4).unwrap().on(Base::SLIDING).unwrap(),
        Body::slab(rubber, 0.4).unwrap().on(Base::FREE).unwrap(),
        Body::slab(soft, 0.4).unwrap().on(Base::FREE).unwrap(),
        Body::stack(&[(soft, 0.2), (rubber, 0.3)], Base::BONDED).unwrap(),
        Body::stack(&[(rubber, 0.2), (rubber, 0.3)], half_space()).unwrap(),
        Body::stack(&[(soft, 0.2), (rubber, 0.3)], half_space()).unwrap(),
        Body::half_space(soft).against(Body::slab(hard, 0.3).unwrap()),
        Body::half_space(soft).against(Body::half_space(rubber)),
        Body::slab(rubber, 0.4).unwrap().against(Body::half_space(soft)),
        Body::slab(soft, 0.4).unwrap().against(Body::half_space(rubber)),
    ]
}

/// Fields below a pressure equal the fields of the traction (0, 0, −p) on grids without Nyquist modes, and on any grid
/// the fields of the resulting normal displacement.
#[test]
fn below_a_pressure_the_fields_are_those_of_its_traction() {
    for (number, body) in bodies().iter().enumerate() {
        for n in [[7, 9], [6, 8]] {
            let grid = Grid::new(n, [1.0, 1.3]).unwrap();
            let pressure = noise(grid.len(), 7);
            let interior = Interior::of_pressure(body, grid, &pressure).unwrap();
            let mean = pressure.iter().sum::<f64>() / grid.len() as f64;
            assert!((interior.mean_traction()[2] + mean).abs() < 1e-14 && interior.mean_traction()[0] == 0.0);
            let depths = [0.0, 0.1, 0.25];
            let stresses = |interior: &Interior, depth: f64| {
                states(interior, depth).iter().map(|state| state.stress).collect::<Vec<[f64; 6]>>()
            };
            if n[0] % 2 == 1 {
                let traction = [vec![0.0; 2 * grid.len()], pressure.iter().map(|p| -p).collect()].concat();
                let wanted = Interior::of_traction(body, grid, &traction).unwrap();
                for depth in depths {
                    near(&states(&interior, depth), &stresses(&wanted, depth), &format!("{number} {depth}"));
                }
            }
            for (state, pressure) in states(&interior, 0.0).iter().zip(&pressure) {
                assert!((state.stress[2] + pressure).abs() < 1e-12, "{number}: {} {pressure}", state.stress[2]);
            }
            let mut ws = interior.workspace();
            let displacement = interior.displacement(0.0, &mut ws).unwrap()[2 * grid.len()..].to_vec();
            let again = Interior::frictionless(&body.alone(), grid, &displacement).unwrap();
            let again = again.with_mean_traction(interior.mean_traction()).unwrap();
            for depth in depths {
                near(&states(&again, depth), &stresses(&interior, depth), &format!("{number} {depth} displaced"));
            }
        }
    }
}

/// σ_xz, σ_yz, σ_zz have the mean of the surface at every depth of every body. All other mean stresses and strains
/// equal those in a laterally confined column; displacements are the integral of the strains.
#[test]
fn the_mean_traction_is_the_same_at_every_depth() {
    let traction = [0.03, -0.02, -0.1];
    for body in bodies() {
        let grid = Grid::new([6, 5], [1.0, 1.2]).unwrap();
        // The mean surface displacement is the compression of all layers of both bodies; a half-space adds nothing.
        let thickness = |body: &Body| body.total_height().min(1e9);
        let column = |body: &Body, axis: usize| -> f64 {
            let mut edges = body.interfaces();
            edges.insert(0, 0.0);
            if thickness(body) < 1e9 {
                edges.push(thickness(body));
            }
            let compliance = |material: &Material| {
                let (young, nu) = (material.young(), material.poisson());
                match axis {
                    2 => (1.0 + nu) * (1.0 - 2.0 * nu) / (young * (1.0 - nu)),
                    _ => 2.0 * (1.0 + nu) / young,
                }
            };
            let of = |pair: &[f64]| {
                let middle = body.at_depth(0.5 * (pair[0] + pair[1])).unwrap();
                (pair[1] - pair[0]) * compliance(middle.material())
            };
            edges.windows(2).map(of).sum()
        };
        let alone = body.alone();
        let second = body.second().map(|second| [0, 1, 2].map(|axis| column(second, axis)));
        let mut surface = noise(3 * grid.len(), 2);
        for (axis, component) in surface.chunks_exact_mut(grid.len()).enumerate() {
            let total = column(&alone, axis) + second.map_or(0.0, |second| second[axis]);
            let shift = total * traction[axis] - mean(component.iter().copied());
            component.iter_mut().for_each(|u| *u += shift);
        }
        let interior = Interior::new(&body, grid, &surface).unwrap().with_mean_traction(traction).unwrap();
        let deepest = alone.total_height().min(2.0);
        let mut before: Option<(f64, [f64; 3], State)> = None;
        for step in 0..=20 {
            let depth = deepest * step as f64 / 20.0;
            let all = states(&interior, depth);
            let scale = all.iter().flat_map(|state| state.stress).fold(0.0, |most: f64, s| most.max(s.abs()));
            let average = |k: usize| mean(all.iter().map(|state| state.stress[k]));
            let nu = alone.at_depth(depth).unwrap().material().poisson();
            let lateral = nu / (1.0 - nu) * traction[2];
            for (k, wanted) in [lateral, lateral, traction[2], traction[1], traction[0], 0.0].into_iter().enumerate() {
                assert!((average(k) - wanted).abs() < 1e-13 * scale, "{body:?}, {depth}: {k} {} {wanted}", average(k));
            }
            let u = interior.displacement(depth, &mut interior.workspace()).unwrap().to_vec();
            let u: [f64; 3] = std::array::from_fn(|axis| mean(u[axis * grid.len()..][..grid.len()].iter().copied()));
            let strain = [4, 3, 2].map(|k| mean(all.iter().map(|state| state.strain[k])));
            if let Some((above, was, state)) = before
                && alone.interfaces().iter().all(|edge| *edge >= depth || *edge <= above)
            {
                let _ = state;
                for axis in 0..3 {
                    let slope = (was[axis] - u[axis]) / (depth - above);
                    assert!((slope - strain[axis]).abs() < 1e-12, "{body:?} {depth}: {axis} {slope} {strain:?}");
                }
            }
            before = Some((depth, u, all[0]));
        }
        if alone.total_height().is_finite() {
            let u = interior.displacement(deepest, &mut interior.workspace()).unwrap().to_vec();
            let lowest: f64 = mean(u[2 * grid.len()..].iter().copied());
            assert!(lowest.abs() < 1e-12, "{body:?} {lowest}");
        }
    }
}

/// An incompressible slab on a moving base bears exactly its load.
#[test]
fn an_incompressible_slab_on_a_base_that_moves_bears_the_mean_pressure() {
    let body = Body::slab(material(2.0, 0.5), 0.4).unwrap();
    let grid = Grid::new([5, 7], [1.0, 1.3]).unwrap();
    let base = noise(3 * grid.len(), 6);
    let mut pressed = noise(grid.len(), 8);
    let shift = mean(pressed.iter().copied());
    pressed.iter_mut().for_each(|u| *u -= shift);
    let interior = Interior::frictionless(&body, grid, &pressed)
        .and_then(|interior| interior.with_mean_traction([0.0, 0.0, -0.2]))
        .and_then(|interior| interior.over_base(&base))
        .unwrap();
    let lift = BaseField::Displacement(base.clone()).surface_displacement(&body, grid).unwrap();
    for depth in [0.0, 0.1, 0.4] {
        let all = states(&interior, depth);
        let average = mean(all.iter().map(|state| state.stress[2]));
        let scale = all.iter().fold(0.0, |most: f64, state| most.max(state.stress[2].abs()));
        assert!((average + 0.2).abs() < 1e-13 * scale, "{depth}: {average}");
    }
    let top = interior.displacement(0.0, &mut interior.workspace()).unwrap().to_vec();
    for (i, u) in top[2 * grid.len()..].iter().enumerate() {
        assert!((u - pressed[i] - lift[2 * grid.len() + i]).abs() < 1e-13);
    }
}

#[test]
fn a_mean_traction_that_the_displacement_contradicts_is_refused() {
    let grid = Grid::new([6, 5], [1.0, 1.2]).unwrap();
    let body = Body::slab(material(1.0, 0.25), 0.5).unwrap();
    let mut surface = vec![0.0; 3 * grid.len()];
    surface[2 * grid.len()..].fill(-0.005);
    let interior = || Interior::new(&body, grid, &surface).unwrap();
    assert!((interior().mean_traction()[2] + 0.012).abs() < 1e-16);
    assert!(interior().with_mean_traction([0.0, 0.0, -0.0121]).is_ok());
    let refused = interior().with_mean_traction([0.0, 0.0, 0.012]).unwrap_err();
    assert!(matches!(refused, InteriorError::Contradiction { axis: 'z', .. }), "{refused}");
    assert!(refused.to_string().starts_with("the mean traction along z is 0.012; it must be -0.012"), "{refused}");
    let refused = interior().with_mean_traction([0.1, 0.0, -0.012]).unwrap_err();
    assert!(matches!(refused, InteriorError::Contradiction { axis: 'x', .. }), "{refused}");
    let refused = interior().with_mean_traction([0.0, f64::NAN, 0.0]).unwrap_err();
    assert!(matches!(refused, InteriorError::NotFinite { index: 1, .. }), "{refused}");
}
