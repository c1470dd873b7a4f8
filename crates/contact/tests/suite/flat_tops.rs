//! Flat tops under small loads, with a displacement that is very small beside the roughness, and approaches to surfaces
//! with a hardness, against the active set of a dense compliance matrix.
//!
//! The matrix is made here: from the compliance of half-space and slab (theory.md, sections 2 and 3) by a sum over
//! waves, and with free boundaries from the displacement by a uniform pressure on a rectangle (Love 1929; Johnson 1985,
//! section 3.3).

use gfmd_contact::{
    Boundary, Contact, Equilibrium, Fields, Hardness, Load, Refusal, SolveError, Solver, SqueezedContact, SteepContact,
};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use ndarray::Array2;
use std::f64::consts::{PI, TAU};

use super::long;

const E_STAR: f64 = 1.0;
const NU: f64 = 0.3;

fn material() -> Material {
    Material::from_contact_modulus(E_STAR, NU).unwrap()
}

/// Returns the compliance u/p of a wave, on a half-space or on a slab of this height clamped at its base.
fn compliance(q: f64, height: Option<f64>) -> f64 {
    let half_space = 2.0 / (E_STAR * q);
    let Some(height) = height else { return half_space };
    let (h, k) = (q * height, 3.0 - 4.0 * NU);
    if h > 100.0 {
        return half_space;
    }
    let (sinh, cosh) = ((2.0 * h).sinh(), (2.0 * h).cosh());
    half_space * (k * sinh - 2.0 * h) / (k * cosh + 2.0 * h * h + 0.5 * (k * k + 1.0))
}

/// Returns the displacement at the points of a periodic cell under a unit pressure on point 0, without its mean.
fn periodic([nx, ny]: [usize; 2], [lx, ly]: [f64; 2], height: Option<f64>) -> Vec<f64> {
    let number = |k: usize, n: usize| if 2 * k > n { k as f64 - n as f64 } else { k as f64 };
    let mut columns = vec![0.0; nx * ny];
    for (k, l) in (0..nx).flat_map(|k| (0..ny).map(move |l| (k, l))).skip(1) {
        let g = compliance(TAU * (number(k, nx) / lx).hypot(number(l, ny) / ly), height) / (nx * ny) as f64;
        for (point, sum) in columns.iter_mut().enumerate() {
            let turns = (k * (point / ny)) as f64 / nx as f64 + (l * (point % ny)) as f64 / ny as f64;
            *sum += g * (TAU * turns).cos();
        }
    }
    columns
}

/// Returns the displacement of a half-space at (x, y) under a unit pressure on the rectangle |x'| ≤ a, |y'| ≤ b.
fn love([x, y]: [f64; 2], [a, b]: [f64; 2]) -> f64 {
    let term = |s: f64, t: f64, u: f64, v: f64| {
        let (over, under) = (s + s.hypot(t), u + u.hypot(v));
        t * (over / under).ln()
    };
    let sum = term(y + b, x + a, y - b, x + a)
        + term(x + a, y + b, x - a, y + b)
        + term(y - b, x - a, y + b, x - a)
        + term(x - a, y - b, x + a, y - b);
    sum / (PI * E_STAR)
}

/// Returns the compliance between all points.
fn matrix(boundary: Boundary, points: [usize; 2], lengths: [f64; 2], height: Option<f64>) -> Vec<Vec<f64>> {
    let [nx, ny] = points;
    let [dx, dy] = [lengths[0] / nx as f64, lengths[1] / ny as f64];
    let cell = periodic(points, lengths, height);
    let between = |i: usize, j: usize| match boundary {
        Boundary::Periodic => cell[((i / ny + nx - j / ny) % nx) * ny + (i % ny + ny - j % ny) % ny],
        Boundary::Free => {
            let apart = |a: usize, b: usize, step: f64| (a as f64 - b as f64) * step;
            love([apart(i / ny, j / ny, dx), apart(i % ny, j % ny, dy)], [0.5 * dx, 0.5 * dy])
        }
    };
    (0..nx * ny).map(|i| (0..nx * ny).map(|j| between(i, j)).collect()).collect()
}

/// Solves A x = b by elimination with pivots.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|i, j| a[*i][k].abs().total_cmp(&a[*j][k].abs())).unwrap();
        a.swap(k, pivot);
        b.swap(k, pivot);
        let (above, below) = a.split_at_mut(k + 1);
        for (i, row) in below.iter_mut().enumerate() {
            let factor = row[k] / above[k][k];
            row[k..].iter_mut().zip(&above[k][k..]).for_each(|(x, y)| *x -= factor * y);
            b[k + 1 + i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| a[k][j] * b[j]).sum();
        b[k] = (b[k] - known) / a[k][k];
    }
    b
}

/// Computes the exact state, pressures between 0 and `hardness` and the approach, by changes of the sets of points that
/// are free, at zero and at the hardness, until none is wrong.
fn exact(g: &[Vec<f64>], clearance: &[f64], hardness: &[f64], load: Load) -> (Vec<f64>, f64) {
    #[derive(Clone, Copy, PartialEq)]
    enum Set {
        Open,
        Free,
        Plastic,
    }
    let n = clearance.len();
    let mut sets: Vec<Set> = clearance.iter().map(|c| if *c == 0.0 { Set::Free } else { Set::Open }).collect();
    for _ in 0..200 {
        let free: Vec<usize> = (0..n).filter(|i| sets[*i] == Set::Free).collect();
        let plastic: Vec<usize> = (0..n).filter(|i| sets[*i] == Set::Plastic).collect();
        // Σ_free G p − δ = −c − Σ_plastic G H, and Σ_free p = N p̄ − Σ_plastic H or δ as given.
        let mut rows: Vec<Vec<f64>> =
            free.iter().map(|i| free.iter().map(|j| g[*i][*j]).chain([-1.0]).collect()).collect();
        let given = |i: usize| plastic.iter().map(|j| g[i][*j] * hardness[*j]).sum::<f64>();
        let mut right: Vec<f64> = free.iter().map(|i| -clearance[*i] - given(*i)).collect();
        match load {
            Load::MeanPressure(mean) => {
                rows.push(free.iter().map(|_| 1.0).chain([0.0]).collect());
                right.push(n as f64 * mean - plastic.iter().map(|j| hardness[*j]).sum::<f64>());
            }
            Load::Approach(approach) => {
                rows.push(free.iter().map(|_| 0.0).chain([1.0]).collect());
                right.push(approach);
            }
        }
        let x = solve(rows, right);
        let approach = x[free.len()];
        let mut pressure = vec![0.0; n];
        free.iter().zip(&x).for_each(|(i, p)| pressure[*i] = *p);
        plastic.iter().for_each(|i| pressure[*i] = hardness[*i]);
        let mut changed = false;
        for i in 0..n {
            let gap = || clearance[i] + (0..n).map(|j| g[i][j] * pressure[j]).sum::<f64>() - approach;
            let next = match sets[i] {
                Set::Free if pressure[i] < 0.0 => Set::Open,
                Set::Free if pressure[i] > hardness[i] => Set::Plastic,
                Set::Open if gap() < 0.0 => Set::Free,
                Set::Plastic if gap() > 0.0 => Set::Free,
                set => set,
            };
            changed |= next != sets[i];
            sets[i] = next;
        }
        if !changed {
            return (pressure, approach);
        }
    }
    panic!("the sets do not settle");
}

fn apart(found: &Array2<f64>, expected: &[f64]) -> f64 {
    let largest = expected.iter().fold(0.0_f64, |m, p| m.max(*p));
    found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / largest
}

/// Returns a disc of radius 0.3 that stands out by 0.1.
fn disc(n: usize) -> (Grid, Array2<f64>) {
    let at = |i: usize| i as f64 / n as f64 - 0.5;
    let heights = Array2::from_shape_fn((n, n), |(i, j)| if at(i).hypot(at(j)) <= 0.3 { 0.1 } else { 0.0 });
    (Grid::square(n, 1.0).unwrap(), heights)
}

const N: usize = 32;

#[test]
fn the_pressure_on_a_flat_top_is_the_load_times_a_fixed_field() {
    let (grid, heights) = disc(N);
    let clearance: Vec<f64> = heights.iter().map(|h| 0.1 - h).collect();
    for (boundary, height) in [
        (Boundary::Periodic, None),
        (Boundary::Free, None),
        (Boundary::Periodic, Some(0.2)),
        (Boundary::Periodic, Some(0.03)),
    ] {
        let body = height.map_or_else(|| Body::half_space(material()), |h| Body::slab(material(), h).unwrap());
        let g = matrix(boundary, [N; 2], [1.0; 2], height);
        let contact = Contact::with_boundary(boundary, &body, &grid, &heights).unwrap();
        for hardness in [f64::INFINITY, 5.0] {
            let (fixed, _) = exact(&g, &clearance, &vec![hardness * 1e-6; N * N], Load::MeanPressure(1e-6));
            let plastic = fixed.iter().filter(|p| **p == hardness * 1e-6).count();
            assert!(hardness.is_infinite() || height.is_some() || plastic > 8);
            for mean in [1e-5, 1e-7, 1e-8, 1e-9, 1e-10, 1e-12, 1e-20, 1e-60] {
                let contact = if hardness.is_infinite() {
                    contact.clone()
                } else {
                    contact.clone().with_hardness(hardness * mean).unwrap()
                };
                let expected: Vec<f64> = fixed.iter().map(|p| p / 1e-6 * mean).collect();
                for solver in [Solver::Auto, Solver::PolonskyKeer, Solver::ProjectedCg, Solver::PreconditionedCg] {
                    // In single precision the preconditioned method cannot start at the smallest loads, and reports it.
                    let single = solver == Solver::PreconditionedCg || hardness.is_finite();
                    if !contact.solvers().contains(&solver) || single && mean < 1e-12 {
                        continue;
                    }
                    let solution = contact.press(Load::MeanPressure(mean)).solver(solver).solve();
                    let solution =
                        solution.unwrap_or_else(|e| panic!("{boundary} {height:?} {hardness} {mean:e} {solver}: {e}"));
                    let error = apart(&solution.pressure, &expected);
                    assert!(error < 2e-4, "{boundary} {height:?} {hardness} {mean:e} {solver}: {error:e}");
                    if hardness.is_infinite() {
                        let touching = solution.pressure.iter().filter(|p| **p > 0.0).count();
                        assert_eq!(touching, expected.iter().filter(|p| **p > 0.0).count(), "{mean:e} {solver}");
                        // The same approach gives the same state.
                        let moved = contact.press(Load::Approach(solution.approach)).solver(solver).solve();
                        let moved = moved.unwrap_or_else(|e| panic!("{boundary} {height:?} {mean:e} {solver}: {e}"));
                        let error = apart(&moved.pressure, &expected);
                        assert!(error < 4e-4, "{boundary} {height:?} {mean:e} {solver}, approach: {error:e}");
                    }
                }
            }
        }
    }
}

#[test]
fn dynamics_finds_the_same_pressure_on_a_flat_top() {
    let (grid, heights) = disc(N);
    let clearance: Vec<f64> = heights.iter().map(|h| 0.1 - h).collect();
    let g = matrix(Boundary::Periodic, [N; 2], [1.0; 2], None);
    let body = Body::half_space(material());
    let (fixed, _) = exact(&g, &clearance, &vec![f64::INFINITY; N * N], Load::MeanPressure(1e-6));
    let contact = Contact::new(&body, &grid, &heights).unwrap();
    for mean in [1e-6, 1e-7, 1e-8] {
        let expected: Vec<f64> = fixed.iter().map(|p| p / 1e-6 * mean).collect();
        let mut solved = 0;
        for solver in [Solver::Verlet, Solver::VerletModes, Solver::Fire, Solver::Fire2, Solver::AugmentedLagrangian] {
            match contact.press(Load::MeanPressure(mean)).solver(solver).max_iterations(5000).solve() {
                Ok(solution) => {
                    let error = apart(&solution.pressure, &expected);
                    assert!(error < 2e-4, "{mean:e} {solver}: {error:e}");
                    solved += 1;
                }
                // Dynamics takes longer for smaller loads.
                Err(SolveError::NotConverged { .. }) => {}
                Err(error) => panic!("{mean:e} {solver}: {error}"),
            }
        }
        assert!(solved > 0, "{mean:e}");
    }
}

/// On odd grids the waves of both methods are the same.
#[test]
fn other_kinds_of_contacts_do_not_depend_on_the_size_of_a_small_load() {
    let (grid, heights) = disc(31);
    let body = Body::slab(material(), 0.4).unwrap();
    let other = heights.mapv(|h| 0.3 * h);
    let full = Contact::in_all_components(&body, &grid, &heights).unwrap();
    // The slopes at its edges are not larger than finite slopes may be.
    let steep = SteepContact::new(&body, &grid, &(0.02 * &heights)).unwrap();
    let squeezed = SqueezedContact::new(&body, &grid, &heights, &other).unwrap();
    let pressures = |mean: f64| {
        let load = Load::MeanPressure(mean);
        // Between two surfaces the search does not start under small loads on flat tops: an error, never a number.
        let squeezed = match squeezed.press(load).solve() {
            Err(SolveError::NotConverged { .. }) if mean < 1e-4 => None,
            solved => Some(solved.unwrap_or_else(|error| panic!("{mean:e}, squeezed: {error}")).upper.pressure),
        };
        let all = full.press(load).solve().unwrap_or_else(|error| panic!("{mean:e}, all: {error}"));
        let steep = steep.press(load).solve().unwrap_or_else(|error| panic!("{mean:e}, steep: {error}"));
        [Some(all.pressure), Some(steep.normal.pressure), squeezed]
    };
    let expected = pressures(1e-4);
    let means = if long() { &[1e-5, 1e-7][..] } else { &[1e-7] };
    for &mean in means {
        for (kind, (found, expected)) in pressures(mean).iter().zip(&expected).enumerate() {
            let (Some(found), Some(expected)) = (found, expected) else { continue };
            let expected: Vec<f64> = expected.iter().map(|p| p / 1e-4 * mean).collect();
            let error = apart(found, &expected);
            assert!(error < 1e-3, "kind {kind} at {mean:e}: {error:e}");
        }
    }
}

/// The tops of a computed surface differ by rounding errors, which decide the contact once the displacement is smaller.
#[test]
fn loads_below_the_rounding_of_the_heights_are_refused() {
    let (grid, mut heights) = disc(N);
    heights.indexed_iter_mut().for_each(|((i, j), h)| *h += 1e-17 * ((3 * i + 5 * j) % 4) as f64);
    let contact = Contact::new(&Body::half_space(material()), &grid, &heights).unwrap();
    assert!(contact.press(Load::MeanPressure(1e-9)).solve().is_ok());
    for load in [1e-14, 1e-20].map(Load::MeanPressure).into_iter().chain([1e-14, 1e-20].map(Load::Approach)) {
        match contact.press(load).solve() {
            Err(SolveError::Refused(Refusal::LoadBelowRoughnessRounding { found, least, .. })) => {
                assert!(found < least && least < 1e-9, "{found:e} {least:e}");
                let message = Refusal::LoadBelowRoughnessRounding { what: "mean pressure", found, least }.to_string();
                assert!(message.contains("must be at least") && !message.contains('\n'), "{message}");
            }
            other => panic!("{load:?}: {:?}", other.map(|solution| solution.residual)),
        }
    }
}

#[test]
fn an_approach_beyond_the_mean_clearance_is_plastic() {
    let points = [24, 20];
    let grid = Grid::new(points, [1.0, 0.8]).unwrap();
    let heights = Array2::from_shape_fn(points, |(i, j)| {
        let (x, y) = (TAU * i as f64 / 24.0, TAU * j as f64 / 20.0);
        0.012 * x.cos() * (y + 0.4).cos() + 0.003 * (3.0 * x + 1.0).sin() * (2.0 * y).cos()
    });
    let contact = Contact::new(&Body::half_space(material()), &grid, &heights).unwrap();
    let [g, clearance] =
        [matrix(Boundary::Periodic, points, [1.0, 0.8], None), vec![contact.surface().clearance().to_vec()]];
    let clearance = &clearance[0];
    let mean = contact.surface().mean_clearance();
    let grains = Array2::from_shape_fn(points, |(i, j)| 0.05 * [1.0, 0.3, 0.6][(i / 5 + j / 7) % 3]);
    for hardness in [Array2::from_elem(points, 0.02), grains] {
        let limits: Vec<f64> = hardness.iter().copied().collect();
        let contact = contact.clone().with_hardness(Hardness::Field(hardness.clone())).unwrap();
        // At twice the mean the deepest point only just touches, at the hardness but for rounding errors.
        for approach in [0.9, 1.0, 1.3, 1.9, 2.1, 10.0].map(|part| part * mean) {
            let solution = contact.press(Load::Approach(approach)).tolerance(1e-10).solve();
            let solution = solution.unwrap_or_else(|error| panic!("{approach}: {error}"));
            let (expected, _) = exact(&g, clearance, &limits, Load::Approach(approach));
            let error = apart(&solution.pressure, &expected);
            assert!(error < 1e-6, "{approach}: {error:e}");
            let plastic = expected.iter().zip(&limits).filter(|(p, h)| p == h).count() as f64 / 480.0;
            assert!(plastic > 0.2 && (solution.plastic.as_ref().unwrap().fraction - plastic).abs() < 1e-12);
            assert!(solution.worst() <= 1e-10);
        }
    }
    // Without a hardness there is no such state.
    let refused = contact.press(Load::Approach(1.01 * mean)).solve();
    assert!(matches!(refused, Err(SolveError::Refused(Refusal::Approach { limit: Some(_), .. }))));
}
