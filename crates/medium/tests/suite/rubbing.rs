//! Steady sliding with friction of the interface, and with a hardness: dense solutions, limits, closed forms.

use approx::assert_relative_eq;
use gfmd_contact::{Budget, Contact, Equilibrium as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Material};
use gfmd_medium::{Prony, Relaxes, SlidingContact, SlidingError, SlidingState, Velocity};
use ndarray::Array2;
use num_complex::Complex64;

use crate::{material, one, rough, three};

const TIGHT: f64 = 1e-11;

fn solve(contact: &SlidingContact, velocity: &Velocity, load: Load) -> SlidingState {
    let budget = Budget { tolerance: TIGHT, ..Budget::default() };
    contact.slide(velocity, load, &budget, None, &mut ()).unwrap()
}

fn contact(body: &Body, grid: &Grid, prony: Option<&Prony>, hardness: Option<f64>) -> SlidingContact {
    let mut contact = Contact::new(body, grid, &rough(grid, 5)).unwrap();
    if let Some(hardness) = hardness {
        contact = contact.with_hardness(hardness).unwrap();
    }
    match prony {
        Some(prony) => SlidingContact::new(contact, body, prony, Relaxes::Both).unwrap(),
        None => SlidingContact::elastic(contact, body).unwrap(),
    }
}

/// Matrix of the indentation by a unit pressure at each point with the shear `coefficient` times the pressure along the
/// velocity, from the compliance matrices of all components, summed wave by wave.
fn dense(body: &Body, grid: &Grid, prony: Option<&Prony>, velocity: &Velocity, coefficient: f64) -> Vec<Vec<f64>> {
    let ([nx, ny], [lx, ly]) = (grid.points(), grid.lengths());
    let ([ex, ey], speed) = (velocity.direction(), velocity.speed());
    let points = nx * ny;
    let mut row = vec![0.0; points];
    for mode in grid.modes().skip(1) {
        let g = body.compliance_of(&mode);
        let modulus = prony.map_or(Complex64::ONE, |prony| {
            prony.modulus(-speed * (mode.wavevector[0] * ex + mode.wavevector[1] * ey))
        });
        // Traction (μ e, −1); the indentation is −u_z.
        let image = -(coefficient * (ex * g[2][0] + ey * g[2][1]) - g[2][2]) / modulus;
        for (i, value) in row.iter_mut().enumerate() {
            let [x, y] = [(i / ny) as f64 * lx / nx as f64, (i % ny) as f64 * ly / ny as f64];
            let phase = Complex64::cis(mode.wavevector[0] * x + mode.wavevector[1] * y);
            *value += mode.weight * (image * phase).re / points as f64;
        }
    }
    let [_, level] = body.level_compliance();
    row.iter_mut().for_each(|value| *value += level / points as f64);
    let between = |i: usize, j: usize| {
        let [dx, dy] = [(nx + i / ny - j / ny) % nx, (ny + i % ny - j % ny) % ny];
        row[dx * ny + dy]
    };
    (0..points).map(|i| (0..points).map(|j| between(i, j)).collect()).collect()
}

/// Returns −⟨p v·∇d⟩ and −⟨t v·∇u⟩, summed wave by wave with the compliance matrices of all components.
fn powers(
    body: &Body,
    grid: &Grid,
    prony: Option<&Prony>,
    velocity: &Velocity,
    coefficient: f64,
    pressure: &[f64],
) -> [f64; 2] {
    let ([nx, ny], [lx, ly], points) = (grid.points(), grid.lengths(), pressure.len() as f64);
    let ([ex, ey], speed) = (velocity.direction(), velocity.speed());
    grid.modes().skip(1).fold([0.0; 2], |[slopes, lost], mode| {
        let of_point = |(i, p): (usize, &f64)| {
            let [x, y] = [(i / ny) as f64 * lx / nx as f64, (i % ny) as f64 * ly / ny as f64];
            *p * Complex64::cis(-(mode.wavevector[0] * x + mode.wavevector[1] * y))
        };
        let p = pressure.iter().enumerate().map(of_point).sum::<Complex64>() / points;
        let rate = speed * (mode.wavevector[0] * ex + mode.wavevector[1] * ey);
        let modulus = prony.map_or(Complex64::ONE, |prony| prony.modulus(-rate));
        let traction = [coefficient * ex * p, coefficient * ey * p, -p];
        let g = body.compliance_of(&mode);
        let image = |row: usize| (0..3).map(|column| g[row][column] * traction[column]).sum::<Complex64>() / modulus;
        let gradient = |row: usize| Complex64::new(0.0, rate) * image(row);
        let of_traction: f64 = (0..3).map(|row| (traction[row].conj() * gradient(row)).re).sum();
        [slopes + mode.weight * (p.conj() * gradient(2)).re, lost - mode.weight * of_traction]
    })
}

/// Solves a small system by elimination with pivots.
fn eliminate(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs())).unwrap();
        rows.swap(k, pivot);
        for i in k + 1..n {
            let factor = rows[i][k] / rows[k][k];
            let (above, below) = rows.split_at_mut(i);
            below[0].iter_mut().zip(&above[k]).skip(k).for_each(|(value, other)| *value -= factor * other);
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        x[k] = (rows[k][n] - (k + 1..n).map(|j| rows[k][j] * x[j]).sum::<f64>()) / rows[k][k];
    }
    x
}

/// Solves the contact at a prescribed approach, with 0 ≤ p ≤ `hardness`, by active sets.
fn active_sets(matrix: &[Vec<f64>], clearance: &[f64], approach: f64, hardness: f64) -> Vec<f64> {
    let n = clearance.len();
    // 0: open, 1: free, 2: at the hardness.
    let mut sets: Vec<u8> = clearance.iter().map(|c| u8::from(*c < approach)).collect();
    for _ in 0..200 {
        let free: Vec<usize> = (0..n).filter(|i| sets[*i] == 1).collect();
        let full: Vec<usize> = (0..n).filter(|i| sets[*i] == 2).collect();
        let rows = free.iter().map(|i| {
            let known: f64 = full.iter().map(|j| matrix[*i][*j] * hardness).sum();
            free.iter().map(|j| matrix[*i][*j]).chain([approach - clearance[*i] - known]).collect()
        });
        let found = eliminate(rows.collect());
        let mut pressure = vec![0.0; n];
        free.iter().zip(&found).for_each(|(i, p)| pressure[*i] = *p);
        full.iter().for_each(|i| pressure[*i] = hardness);
        let gap = |i: usize| clearance[i] - approach + (0..n).map(|j| matrix[i][j] * pressure[j]).sum::<f64>();
        let next: Vec<u8> = (0..n)
            .map(|i| match sets[i] {
                1 if pressure[i] < 0.0 => 0,
                1 if pressure[i] > hardness => 2,
                0 if gap(i) < 0.0 => 1,
                2 if gap(i) > 0.0 => 1,
                same => same,
            })
            .collect();
        if next == sets {
            return pressure;
        }
        sets = next;
    }
    panic!("the active sets cycle");
}

#[test]
fn pressures_are_those_of_dense_matrices_of_all_components() {
    let grid = Grid::new([11, 9], [1.0, 0.8]).unwrap();
    let top = Material::from_young(3.0, 0.25).unwrap();
    let layers = Body::slab(top, 0.1).unwrap().bonded_to(Body::slab(material(0.45), 0.2).unwrap()).unwrap();
    let bodies = [
        Body::half_space(material(0.2)),
        Body::slab(material(0.35), 0.3).unwrap(),
        Body::slab(material(0.5), 0.3).unwrap(),
        layers,
        Body::slab(material(0.3), 0.3).unwrap().on(Base::SLIDING).unwrap(),
        Body::half_space(material(0.1)).against(Body::half_space(material(0.4))),
    ];
    let velocity = Velocity::new(0.4, 25.0).unwrap();
    for (index, body) in bodies.iter().enumerate() {
        let prony = three();
        // Two bodies do not relax alike.
        let prony = if index == 5 { None } else { Some(&prony) };
        let mut hardness = None;
        for coefficient in [0.0, 0.6, 0.6] {
            let sliding = contact(body, &grid, prony, hardness);
            let sliding = sliding.with_friction(body, coefficient, prony.map(|prony| (prony, Relaxes::Both))).unwrap();
            let load = Load::Approach(0.009);
            let state = solve(&sliding, &velocity, load);
            let matrix = dense(body, &grid, prony, &velocity, coefficient);
            let clearance = sliding.contact().surface().clearance();
            let known = active_sets(&matrix, &clearance.to_vec(), 0.009, hardness.unwrap_or(f64::INFINITY));
            let most = known.iter().copied().fold(0.0, f64::max);
            let found = state.solution.pressure.iter();
            let apart = found.zip(&known).fold(0.0_f64, |worst, (p, q)| worst.max((p - q).abs()));
            assert!(apart <= 1e-9 * most, "body {index}, {coefficient}, {hardness:?}: {apart:e} of {most:e}");
            let [slopes, lost] = powers(body, &grid, prony, &velocity, coefficient, &known);
            let hysteresis = slopes / (0.4 * state.solution.mean_pressure);
            assert!((state.friction_hysteresis - hysteresis).abs() <= 1e-9, "body {index}: {hysteresis:e}");
            assert!((state.dissipated_power - lost).abs() <= 1e-9 * most, "body {index}: {lost:e}");
            let is_plastic = state.solution.plastic.as_ref().is_some_and(|plastic| plastic.fraction > 0.0);
            assert_eq!(is_plastic, hardness.is_some(), "body {index}");
            // The next contact with friction has plastic points.
            hardness = (coefficient > 0.0).then_some(0.5 * most);
        }
    }
}

#[test]
fn friction_leaves_the_pressure_on_an_incompressible_half_space() {
    let grid = Grid::square(32, 1.0).unwrap();
    let body = Body::half_space(material(0.5));
    let (velocity, load) = (Velocity::new(0.3, 35.0).unwrap(), Load::MeanPressure(0.03));
    let still = contact(&body, &grid, Some(&three()), None);
    let without = solve(&still, &velocity, load);
    let rubbing = still.with_friction(&body, 0.7, None).unwrap();
    let with = solve(&rubbing, &velocity, load);
    assert_eq!(with.solution, without.solution);
    assert_eq!((with.friction_interface, with.friction_hysteresis), (0.7, without.friction));
    assert_eq!((with.friction, with.friction_slope), (0.7 + without.friction, 0.7 + without.friction_slope));
    // The shear moves the body, too, which loses more.
    assert!(with.dissipated_power > without.dissipated_power);
    assert_eq!(without.friction_interface, 0.0);
    assert_eq!(without.dissipated_power / (0.3 * without.solution.mean_pressure), without.friction);
}

/// With a constant bulk modulus Poisson's ratio depends on the frequency.
#[test]
fn slow_and_fast_shear_alone_have_the_lift_of_both_moduli() {
    let grid = Grid::new([15, 13], [1.0, 1.0]).unwrap();
    let body = Body::half_space(material(0.2));
    let prony = three();
    let contact = Contact::new(&body, &grid, &rough(&grid, 5)).unwrap();
    let sliding = SlidingContact::new(contact, &body, &prony, Relaxes::Shear).unwrap();
    let sliding = sliding.with_friction(&body, 0.8, Some((&prony, Relaxes::Shear))).unwrap();
    let load = Load::MeanPressure(0.02);
    let (shear, bulk) = (2.0 / 2.4, 2.0 / (3.0 * 0.6));
    for (speed, factor) in [(1e-8, 1.0), (1e8, 4.0)] {
        let (g, k) = (factor * shear, bulk);
        let fixed = Material::from_young(9.0 * k * g / (3.0 * k + g), (3.0 * k - 2.0 * g) / (6.0 * k + 2.0 * g));
        let fixed = Body::half_space(fixed.unwrap());
        let elastic = Contact::new(&fixed, &grid, &rough(&grid, 5)).unwrap();
        let elastic = SlidingContact::elastic(elastic, &fixed).unwrap().with_friction(&fixed, 0.8, None).unwrap();
        let velocity = Velocity::new(speed, 37.0).unwrap();
        let [found, known] = [&sliding, &elastic].map(|contact| solve(contact, &velocity, load));
        assert_relative_eq!(found.friction_hysteresis, known.friction_hysteresis, max_relative = 1e-4);
        assert_relative_eq!(found.solution.approach, known.solution.approach, max_relative = 1e-5);
        assert!(known.friction_hysteresis.abs() > 1e-4 && found.dissipated_power.abs() <= 1e-5 * speed);
    }
}

/// Of the work of the lateral force, v F = μ p̄ v + P, the body stores none.
#[test]
fn an_elastic_body_loses_no_power() {
    let grid = Grid::square(31, 1.0).unwrap();
    let body = Body::half_space(material(0.1));
    let velocity = Velocity::new(2.0, 10.0).unwrap();
    let sliding = contact(&body, &grid, None, None).with_friction(&body, 0.5, None).unwrap();
    let state = solve(&sliding, &velocity, Load::MeanPressure(0.02));
    assert_eq!(state.dissipated_power.abs(), 0.0);
    // The lift moves the contact backwards from the summits, where the pressure pushes forwards.
    assert!(state.friction_hysteresis < 0.0 && state.friction < 0.5, "{}", state.friction);
}

#[test]
fn without_a_coefficient_the_lift_is_zero() {
    let grid = Grid::square(24, 1.0).unwrap();
    let body = Body::slab(material(0.3), 0.4).unwrap();
    let (velocity, load) = (Velocity::new(0.3, 35.0).unwrap(), Load::MeanPressure(0.03));
    let plain = contact(&body, &grid, Some(&one()), None);
    let zero = plain.clone().with_friction(&body, 0.0, None).unwrap();
    assert_eq!(solve(&plain, &velocity, load).solution, solve(&zero, &velocity, load).solution);
}

#[test]
fn a_hardness_has_its_limits() {
    let grid = Grid::square(32, 1.0).unwrap();
    let half_space = |young: f64| Body::half_space(Material::from_young(young, 0.35).unwrap());
    let load = Load::MeanPressure(0.05);
    let apart =
        |a: &Array2<f64>, b: &Array2<f64>| a.iter().zip(b).fold(0.0_f64, |worst, (a, b)| worst.max((a - b).abs()));
    let hard = contact(&half_space(2.0), &grid, Some(&three()), Some(0.2));
    // The series has a fourth of its modulus in the long term. No wave is at a right angle to the velocity.
    for (speed, young) in [(1e-8, 2.0), (1e8, 8.0)] {
        let fixed = Contact::new(&half_space(young), &grid, &rough(&grid, 5)).unwrap().with_hardness(0.2).unwrap();
        let fixed = fixed.press(load).tolerance(TIGHT).solve().unwrap();
        let state = solve(&hard, &Velocity::new(speed, 37.0).unwrap(), load);
        let [found, known] = [&state.solution, &fixed].map(|state| state.plastic.as_ref().unwrap());
        assert!(known.fraction > 0.0);
        assert_eq!(found.fraction, known.fraction);
        assert!(apart(&state.solution.pressure, &fixed.pressure) <= 1e-5 * 0.2);
        assert_relative_eq!(found.volume, known.volume, max_relative = 1e-5);
        assert_relative_eq!(state.solution.approach, fixed.approach, max_relative = 1e-5);
    }
    let velocity = Velocity::new(0.5, 20.0).unwrap();
    let wall = solve(&contact(&half_space(2.0), &grid, Some(&three()), None), &velocity, load);
    let harder = solve(&contact(&half_space(2.0), &grid, Some(&three()), Some(1e6)), &velocity, load);
    assert!(apart(&wall.solution.pressure, &harder.solution.pressure) <= 1e-9);
    assert_relative_eq!(wall.friction, harder.friction, max_relative = 1e-9);
    assert_relative_eq!(wall.friction_slope, harder.friction_slope, max_relative = 1e-8);
    let refused = hard.slide(&velocity, Load::MeanPressure(0.2), &Budget::default(), None, &mut ());
    assert!(refused.unwrap_err().to_string().contains("hardness"));
}

/// Checks that both frictions agree, which needs the slopes of the flattened surface.
#[test]
fn slopes_are_those_of_the_flattened_surface() {
    let apart = |n: usize| {
        let grid = Grid::line(n, 1.0).unwrap();
        let body = Body::half_space(material(0.5));
        let heights = Array2::from_shape_fn((n, 1), |(i, _)| {
            let x = std::f64::consts::TAU * i as f64 / n as f64;
            0.02 * (x.cos() + 0.2 * (2.0 * x + 1.0).cos())
        });
        let contact = Contact::new(&body, &grid, &heights).unwrap().with_hardness(0.25).unwrap();
        let sliding = SlidingContact::new(contact, &body, &one(), Relaxes::Both).unwrap();
        let state = solve(&sliding, &Velocity::new(0.1, 0.0).unwrap(), Load::MeanPressure(0.1));
        assert!(state.solution.plastic.as_ref().unwrap().fraction > 0.05);
        (state.friction - state.friction_slope).abs() / state.friction
    };
    let [coarse, fine] = [128, 1024].map(apart);
    assert!(fine < 0.01 && fine < 0.5 * coarse, "{coarse:e} {fine:e}");
}

#[test]
fn unusable_friction_is_refused() {
    let grid = Grid::square(8, 1.0).unwrap();
    let body = Body::half_space(material(0.3));
    let sliding = || contact(&body, &grid, Some(&one()), None);
    for wrong in [-0.1, f64::NAN, f64::INFINITY] {
        let refused = sliding().with_friction(&body, wrong, None).unwrap_err();
        assert!(refused.to_string().ends_with("it must be at least 0 and finite"), "{refused}");
    }
    let slab = Body::slab(material(0.3), 0.2).unwrap();
    let refused = contact(&slab, &grid, Some(&one()), None).with_friction(&slab, 0.3, Some((&one(), Relaxes::Shear)));
    assert!(matches!(refused, Err(SlidingError::Lift)));
    // The second body of a pair is elastic, and both bodies lift differently.
    let both = Body::half_space(material(0.5)).against(Body::half_space(material(0.0)));
    let pair = contact(&both, &grid, Some(&one()), None).with_friction(&both, 0.3, Some((&one(), Relaxes::Both)));
    assert!(matches!(pair, Err(SlidingError::PairLift)));
    // The lift of a thin incompressible slab has the sign of the loss.
    let thin = Body::slab(material(0.5), 0.02).unwrap();
    let relaxing = Prony::from_fractions(&[(1.0, 0.999)]).unwrap();
    let sliding = contact(&thin, &grid, Some(&relaxing), None);
    let sliding = sliding.with_friction(&thin, 1e3, Some((&relaxing, Relaxes::Both))).unwrap();
    let refused = sliding.check(&Velocity::new(1e-3, 0.0).unwrap()).unwrap_err().to_string();
    assert!(refused.contains("it must lead by less than 90"), "{refused}");
}
