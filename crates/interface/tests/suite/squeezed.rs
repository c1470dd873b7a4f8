//! Laws at both faces of a plate: limits that are contacts of one surface or of hard walls, a dense reference, jumps.

use gfmd_contact::{
    Boundary, Drive, Equilibrium, Fields, Load, MemoryCheckpoint, Refusal, Resumable, SolveError, Solver,
    SqueezedContact,
};
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Plate};
use gfmd_interface::{
    Interface, Parts, Path, QuasistaticContact, QuasistaticState, Refinement, Sequence, Squeezed, SqueezedState, State,
    StoredFields, Wear,
};
use gfmd_law::{Exponential, HardWall, Law, Morse};
use gfmd_medium::{Prony, Relaxes, Relaxing};
use gfmd_relax::Budget;
use ndarray::Array2;

use crate::{material, rough};

const N: usize = 16;

fn grid() -> Grid {
    Grid::square(N, 1.0).unwrap()
}

fn slab(poisson: f64, height: f64) -> Body {
    Body::slab(material(poisson), height).unwrap()
}

fn exponential() -> Exponential {
    Exponential::new(4e-4, 0.01).unwrap()
}

fn morse() -> Morse {
    Morse::new(4e-4, 0.01).unwrap()
}

fn solve<E: Equilibrium>(contact: &E, load: Load, start: Option<&E::State>) -> E::State {
    let solved = contact.press(load).tolerance(1e-10).max_iterations(500).starting_from(start).solve();
    solved.unwrap_or_else(|error| panic!("{load:?}: {error}"))
}

/// Returns the largest difference of two fields divided by the largest value of the second.
fn apart<'a>(found: impl IntoIterator<Item = &'a f64>, wanted: impl IntoIterator<Item = &'a f64>) -> f64 {
    let (mut error, mut scale) = (0.0_f64, 0.0_f64);
    for (a, b) in found.into_iter().zip(wanted) {
        error = error.max((a - b).abs());
        scale = scale.max(b.abs());
    }
    error / scale
}

fn assert_near(found: f64, wanted: f64, tolerance: f64) {
    assert!((found - wanted).abs() <= tolerance * wanted.abs(), "{found} {wanted}");
}

/// Creates the contact of a law at both faces, under loads.
fn both_faces(
    (body, held): (&Body, bool),
    grid: &Grid,
    [upper, lower]: [&Array2<f64>; 2],
    law: impl Law + 'static,
) -> Result<Squeezed, Refusal> {
    let (sequence, law) = (Sequence::Loads, Some(law.into_shared()));
    Squeezed::new(&Parts { sequence, held, law, lower: Some(lower.into()), ..Parts::new(body, grid, upper) })
}

fn between(body: &Body, grid: &Grid, faces: [&Array2<f64>; 2], law: impl Law + 'static) -> Squeezed {
    both_faces((body, false), grid, faces, law).unwrap()
}

/// Returns the state of the law at a face.
fn of_law(face: &QuasistaticState) -> &State {
    face.law().unwrap()
}

fn assert_face(found: &State, wanted: &State, tolerance: f64) {
    for (found, wanted) in [(found.pressure(), wanted.pressure()), (found.repulsion(), wanted.repulsion())] {
        let error = apart(&found, &wanted);
        assert!(error < tolerance, "{error}");
    }
    assert!(apart(&found.gap, &wanted.gap) < tolerance);
    let error = apart(&found.displacement, &wanted.displacement);
    assert!(error < tolerance, "{error}");
    assert_near(found.approach, wanted.approach, tolerance);
    assert_near(found.contact_fraction, wanted.contact_fraction, 0.0);
}

/// The mid-plane is a mirror: it does not move and bears no shear.
#[test]
fn mirror_images_are_one_surface_on_a_sliding_base_of_half_the_height() {
    let surface = rough(&grid(), 1);
    for (poisson, height) in [(0.3, 0.4), (0.5, 0.5)] {
        let body = slab(poisson, 0.5 * height).on(Base::SLIDING).unwrap();
        for law in [Exponential::new(5e-5, 0.01).unwrap().into_shared(), Morse::new(5e-5, 0.01).unwrap().into_shared()]
        {
            let both = between(&slab(poisson, height), &grid(), [&surface, &surface], law.clone());
            let one = Interface::new(&body, &grid(), &surface, law.clone()).unwrap();
            for load in [0.1, 0.3] {
                let load = Load::MeanPressure(load);
                let (found, wanted) = (solve(&both, load, None), solve(&one, load, None));
                for face in [&found.upper, &found.lower] {
                    assert_face(of_law(face), &wanted, 1e-7);
                    assert_near(face.mean_pressure(), wanted.mean_pressure, 1e-8);
                }
                assert_near(found.approach, 2.0 * wanted.approach, 1e-8);
                assert_near(found.upper.elastic_energy(), 2.0 * wanted.elastic_energy, 1e-7);
                assert_near(found.upper.interface_energy(), 2.0 * wanted.interface_energy, 1e-7);
                let again = solve(&both, Load::Approach(found.approach), Some(&found));
                assert_face(of_law(&again.upper), &wanted, 1e-6);
                let stiffness = both.stiffness(&found, 1e-9).unwrap().value;
                assert_near(stiffness, 0.5 * one.stiffness(&wanted, 1e-9).unwrap().value, 1e-5);
            }
        }
    }
}

/// A thin plate bends towards one of two surfaces that attract it: the mirror image of a face is no stable state, and
/// the search finds a state of lower energy.
#[test]
fn a_thin_plate_breaks_the_mirror_symmetry() {
    let surface = rough(&grid(), 1);
    let both = between(&slab(0.3, 0.03), &grid(), [&surface, &surface], exponential());
    let body = slab(0.3, 0.015).on(Base::SLIDING).unwrap();
    let one = Interface::new(&body, &grid(), &surface, exponential()).unwrap();
    let (found, mirrored) = (solve(&both, Load::Approach(0.01), None), solve(&one, Load::Approach(0.005), None));
    let [upper, lower] = [of_law(&found.upper), of_law(&found.lower)];
    assert!(apart(&upper.gap, &lower.gap) > 0.1);
    let energy = |state: &State| state.elastic_energy + state.interface_energy;
    assert!(energy(upper) < 2.0 * energy(&mirrored) - 1e-5, "{} {}", energy(upper), energy(&mirrored));
    assert!(upper.lowest_curvature > 0.0, "{} {}", upper.lowest_curvature, found.worst());
}

/// Faces without lateral displacement have the same symmetry.
#[test]
fn held_mirror_images_are_one_held_surface_on_a_sliding_base_of_half_the_height() {
    let surface = rough(&grid(), 1);
    let both = both_faces((&slab(0.3, 0.1), true), &grid(), [&surface, &surface], exponential()).unwrap();
    let body = slab(0.3, 0.05).on(Base::SLIDING).unwrap();
    let one = Interface::held_sideways(&body, &grid(), &surface, exponential()).unwrap();
    let load = Load::MeanPressure(0.05);
    let (found, wanted) = (solve(&both, load, None), solve(&one, load, None));
    assert_face(of_law(&found.upper), &wanted, 1e-7);
    assert_face(of_law(&found.lower), &wanted, 1e-7);
}

/// A wall alone is the hard wall, solved for the pressures; also with a hardness, and with a law without strength.
#[test]
fn a_law_without_strength_is_a_hard_wall() {
    let (upper, lower, grid) = (rough(&grid(), 1), rough(&grid(), 2), grid());
    for (poisson, height) in [(0.3, 0.05), (0.5, 0.2), (0.2, 3.0)] {
        let body = slab(poisson, height);
        let wall = SqueezedContact::new(&body, &grid, &upper, &lower).unwrap();
        let law = between(&body, &grid, [&upper, &lower], HardWall);
        let weak = between(&body, &grid, [&upper, &lower], Exponential::new(1e-14, 0.01).unwrap());
        for load in [Load::MeanPressure(0.02), Load::MeanPressure(0.2), Load::Approach(0.02)] {
            let wanted = wall.press(load).tolerance(1e-11).solve().unwrap();
            for contact in [&law, &weak] {
                let found = solve(contact, load, None);
                for (face, wanted) in [(&found.upper, &wanted.upper), (&found.lower, &wanted.lower)] {
                    let error = apart(&face.pressure(), &wanted.pressure);
                    assert!(error < 1e-6, "{poisson} {height} {load:?}: {error}");
                    assert!(apart(face.gap(), &wanted.gap) < 1e-6);
                    assert_near(face.approach(), wanted.approach, 1e-6);
                }
                assert_near(found.approach, wanted.approach, 1e-7);
            }
        }
        let load = Load::MeanPressure(0.1);
        let peak = wall.press(load).solve().unwrap().lower.pressure.iter().fold(0.0, |most: f64, p| most.max(*p));
        let hardness = 0.1_f64.mul_add(1.2, 0.3 * peak).min(0.9 * peak);
        let wanted = wall.with_hardness(hardness).unwrap().press(load).tolerance(1e-11).solve().unwrap();
        let (sequence, hardness) = (Sequence::Loads, Some(hardness.into()));
        let parts = Parts { sequence, hardness, lower: Some((&lower).into()), ..Parts::new(&body, &grid, &upper) };
        let found = solve(&Squeezed::new(&parts).unwrap(), load, None);
        for (face, wanted) in [(&found.upper, &wanted.upper), (&found.lower, &wanted.lower)] {
            assert!(apart(&face.pressure(), &wanted.pressure) < 1e-6);
            let depth = &wanted.plastic.as_ref().unwrap().depth;
            assert!(depth.iter().any(|depth| *depth > 0.0));
            assert!(apart(face.plastic_depth().unwrap(), depth) < 1e-4);
        }
    }
}

/// The faces of a thick plate do not feel the waves of each other.
#[test]
fn faces_of_a_thick_plate_are_half_spaces() {
    let surfaces = [rough(&grid(), 1), rough(&grid(), 2)];
    let both = between(&slab(0.3, 6.0), &grid(), [&surfaces[0], &surfaces[1]], exponential());
    let load = Load::MeanPressure(0.05);
    let found = solve(&both, load, None);
    for (face, surface) in [(&found.upper, &surfaces[0]), (&found.lower, &surfaces[1])] {
        let one = Interface::new(&Body::half_space(material(0.3)), &grid(), surface, exponential()).unwrap();
        let wanted = solve(&one, load, None);
        let error = apart(&face.pressure(), &wanted.pressure());
        assert!(error < 1e-7, "{error}");
        assert!(apart(face.gap(), &wanted.gap) < 1e-7);
    }
}

/// Solves a dense linear problem by Gaussian elimination with pivots.
fn eliminate(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| matrix[*a][k].abs().total_cmp(&matrix[*b][k].abs())).unwrap();
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        let (top, below) = matrix.split_at_mut(k + 1);
        for (row, i) in below.iter_mut().zip(k + 1..) {
            let factor = row[k] / top[k][k];
            row[k..].iter_mut().zip(&top[k][k..]).for_each(|(a, b)| *a -= factor * b);
            right[i] -= factor * right[k];
        }
    }
    for k in (0..n).rev() {
        let sum: f64 = (k + 1..n).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - sum) / matrix[k][k];
    }
    right
}

/// Returns the stiffness matrix of both faces of a plate at a fixed approach, from its compliance wave by wave.
fn dense(plate: &Plate, n: usize) -> Vec<Vec<f64>> {
    let points = n * n;
    let mut kernel = [vec![0.0; points], vec![0.0; points], vec![0.0; points]];
    for (m, k) in (0..n).flat_map(|m| (0..n).map(move |k| (m, k))) {
        let number = |m: usize| if 2 * m >= n { m as f64 - n as f64 } else { m as f64 };
        let [x, y] = [m, k].map(|m| std::f64::consts::TAU * number(m));
        let c = plate.compliance(x.hypot(y));
        let [own_above, own_below, across] = if m + k == 0 {
            [0.5 / c.squeezing; 3]
        } else {
            let [above, below] = [1.0, -1.0].map(|sign| 0.5 * (c.squeezing + c.bending) + sign * c.mixed);
            let (through, both) = (0.5 * (c.squeezing - c.bending), above * below);
            let determinant = both - through * through;
            [below / determinant, above / determinant, -through / determinant]
        };
        for i in 0..points {
            let phase = std::f64::consts::TAU * (m * (i / n) + k * (i % n)) as f64 / n as f64;
            for (kernel, value) in kernel.iter_mut().zip([own_above, own_below, across]) {
                kernel[i] += value * phase.cos() / points as f64;
            }
        }
    }
    let entry = |a: usize, b: usize| {
        let ([i, j], [k, l]) = ([a % points / n, a % points % n], [b % points / n, b % points % n]);
        let place = (i + n - k) % n * n + (j + n - l) % n;
        match (a < points, b < points) {
            (true, true) => kernel[0][place],
            (false, false) => kernel[1][place],
            _ => kernel[2][place],
        }
    };
    (0..2 * points).map(|a| (0..2 * points).map(|b| entry(a, b)).collect()).collect()
}

/// A dense Newton method for all points of both faces finds the state from a perturbed one, on layers that differ.
#[test]
fn a_dense_newton_method_finds_the_same_state() {
    let n = 8;
    let grid = Grid::square(n, 1.0).unwrap();
    let (upper, lower) = (rough(&grid, 3), rough(&grid, 4));
    let layers = Body::stack(&[(material(0.3), 0.05), (material(0.1), 0.1)], Base::BONDED).unwrap();
    for body in [layers, slab(0.4, 0.2)] {
        let contact = between(&body, &grid, [&upper, &lower], morse());
        let stiffness = dense(&Plate::of(&body).unwrap(), n);
        for approach in [0.01, 0.03] {
            let found = solve(&contact, Load::Approach(approach), None);
            let fields = [(&found.upper, &upper), (&found.lower, &lower)];
            let clearance: Vec<f64> = fields
                .iter()
                .flat_map(|(_, heights)| {
                    let top = heights.iter().fold(f64::NEG_INFINITY, |top, h| h.max(top));
                    heights.iter().map(move |h| top - h - 0.5 * approach)
                })
                .collect();
            let gap: Vec<f64> = fields.iter().flat_map(|(face, _)| face.gap().to_owned()).collect();
            let mut w: Vec<f64> = clearance.iter().zip(&gap).map(|(c, gap)| c - gap).collect();
            w.iter_mut().enumerate().for_each(|(k, w)| *w += 2e-4 * (k as f64 * 1.7).sin());
            let law = |w: &[f64], i: usize| morse().opening(clearance[i] - w[i]);
            for _ in 0..12 {
                let force: Vec<f64> = (0..w.len())
                    .map(|i| {
                        let elastic: f64 = stiffness[i].iter().zip(&w).map(|(k, w)| k * w).sum();
                        law(&w, i).traction - elastic
                    })
                    .collect();
                let mut matrix = stiffness.clone();
                matrix.iter_mut().enumerate().for_each(|(i, row)| row[i] += law(&w, i).slope);
                let step = eliminate(matrix, force);
                w.iter_mut().zip(step).for_each(|(w, step)| *w += step);
            }
            let exact: Vec<f64> = clearance.iter().zip(&w).map(|(c, w)| c - w).collect();
            let error = apart(&gap, &exact);
            assert!(error < 1e-8, "{error}");
            let pressure: Vec<f64> = (0..w.len()).map(|i| -law(&w, i).traction).collect();
            let mean = pressure.iter().sum::<f64>() / pressure.len() as f64;
            assert_near(found.mean_pressure(), mean, 1e-7);
            let pressures: Vec<f64> =
                fields.iter().flat_map(|(face, _)| face.pressure().into_owned().into_iter()).collect();
            assert!(apart(&pressures, &pressure) < 1e-7);
        }
    }
}

/// Certified numbers agree between a load and its approach, with each other, and with finite differences.
#[test]
fn numbers_of_both_faces_agree() {
    let (upper, lower) = (rough(&grid(), 1), rough(&grid(), 2));
    for law in [exponential().into_shared(), morse().into_shared()] {
        let contact = between(&slab(0.3, 0.2), &grid(), [&upper, &lower], law);
        let load = Load::MeanPressure(0.05);
        let state = solve(&contact, load, None);
        assert!(state.worst() <= 1e-10);
        assert_near(state.mean_pressure(), 0.05, 1e-8);
        let [upper_law, lower_law] = [of_law(&state.upper), of_law(&state.lower)];
        assert_near(lower_law.mean_pressure, upper_law.mean_pressure, 1e-9);
        assert_near(upper_law.approach + lower_law.approach, state.approach, 1e-12);
        let [above, below] = [upper_law, lower_law].map(|face| face.displacement.mean().unwrap());
        assert!((above - below).abs() < 1e-12, "{above} {below}");
        for (face, heights) in [(upper_law, &upper), (lower_law, &lower)] {
            let top = heights.iter().fold(f64::NEG_INFINITY, |top, h| h.max(top));
            for ((h, gap), u) in heights.iter().zip(&face.gap).zip(&face.displacement) {
                assert!((top - h - face.approach - u - gap).abs() < 1e-12);
            }
        }
        let fields = [upper_law, lower_law].map(|face| (face.gap.clone(), face.pressure().into_owned()));
        let [(gap, pressure), (lower_gap, lower_pressure)] = &fields;
        for load in [load, Load::Approach(state.approach)] {
            let again = contact.certify(&[gap, pressure, lower_gap, lower_pressure], load.into()).unwrap();
            assert!(again.worst() < 1e-9, "{}", again.worst());
            assert_near(again.approach, state.approach, 1e-10);
            assert_near(again.mean_pressure(), state.mean_pressure(), 1e-7);
            let wrong = gap * 1.01;
            let judged = contact.certify(&[&wrong, pressure, lower_gap, lower_pressure], load.into()).unwrap();
            assert!(judged.worst() > 1e-4);
        }
        let stored = |face: &State, approach: f64| {
            let field = face.displacement_z().to_owned();
            (face.pressure().into_owned(), field, face.gap.clone(), approach)
        };
        let [(p, u, g, a), (q, v, h, _)] = [stored(upper_law, state.approach), stored(lower_law, f64::NAN)];
        let recalled = contact
            .recall(
                StoredFields { pressure: &p, displacement_z: &u, gap: &g, approach: a },
                StoredFields { pressure: &q, displacement_z: &v, gap: &h, approach: f64::NAN },
            )
            .unwrap();
        let from = solve(&contact, load, Some(&recalled));
        assert!(apart(from.lower.gap(), state.lower.gap()) < 1e-8);
        let mut checkpoint = MemoryCheckpoint::default();
        contact.keep(&mut state.clone(), &mut checkpoint);
        checkpoint.rewind();
        let restored = contact.restore(load.into(), &mut checkpoint).unwrap();
        assert_eq!([of_law(&restored.upper), of_law(&restored.lower)], [upper_law, lower_law]);
        // Energies: the work of a small approach.
        let step = 1e-5;
        let stored = |s: &SqueezedState| s.upper.elastic_energy() + s.upper.interface_energy();
        let [before, after] =
            [-step, step].map(|step| solve(&contact, Load::Approach(state.approach + step), Some(&state)));
        assert_near((stored(&after) - stored(&before)) / (2.0 * step), state.mean_pressure(), 1e-4);
        let slope = (after.mean_pressure() - before.mean_pressure()) / (2.0 * step);
        assert_near(contact.stiffness(&state, 1e-9).unwrap().value, slope, 1e-2);
    }
}

/// Surfaces that come together jump into contact and out of it; the balance of work and energy tells the loss, which is
/// the loss of one surface on a base if the other surface is flat and does not part.
#[test]
fn jumps_of_a_path_lose_energy() {
    let wave = |i: usize| 0.01 * (std::f64::consts::TAU * i as f64 / N as f64).cos();
    let (upper, flat) = (Array2::from_shape_fn((N, N), |(i, _)| wave(i)), Array2::zeros((N, N)));
    let (body, grid) = (slab(0.3, 1.0), grid());
    let law = Exponential::new(2e-4, 2e-3).unwrap().into_shared();
    let parts = Parts { law: Some(law), ..Parts::new(&body, &grid, &upper) };
    let contact = Squeezed::new(&Parts { lower: Some((&flat).into()), ..parts.clone() }).unwrap();
    let refinement = Refinement { solves_per_step: 12, ..Refinement::default() };
    let base = body.clone().on(Base::SLIDING).unwrap();
    let one = QuasistaticContact::new(&Parts { body: &base, ..parts.clone() }).unwrap();
    let mut path = Path::new(&contact, Budget::default(), refinement);
    let mut alone = Path::new(&one, Budget::default(), refinement);
    let mut lost = |waypoints: &[f64]| {
        let mut expected = [0.0; 2];
        let found = waypoints.iter().fold([0.0; 3], |[lost, error, jumps], approach| {
            let step = path.step(Load::Approach(*approach).into(), &mut ()).unwrap();
            let jumped = f64::from(u8::from(step.jumped == Some(true)));
            let other = alone.step(Load::Approach(*approach).into(), &mut ()).unwrap();
            expected[0] += other.dissipated.unwrap();
            expected[1] += other.dissipated_error.unwrap();
            [lost + step.dissipated.unwrap(), error + step.dissipated_error.unwrap(), jumps + jumped]
        });
        assert!((found[0] - expected[0]).abs() <= found[1] + expected[1] + 1e-10, "{found:?} {expected:?}");
        found
    };
    let [whole, error, jumps] = lost(&[-0.012, -0.006, 0.0, 0.003, 0.0, -0.006, -0.012]);
    assert!(whole > 20.0 * error && jumps >= 1.0, "{whole} {error} {jumps}");
    lost(&[0.0, 0.003]);
    let [smooth, error, jumps] = lost(&[0.004, 0.005, 0.004, 0.003]);
    assert!(smooth.abs() <= error && error < 1e-2 * whole && jumps == 0.0, "{smooth} {error} {whole}");
}

/// Both surfaces keep the depth pressed in: unloaded and reloaded to the largest load, the contact is the same.
#[test]
fn a_path_remembers_the_hardness_of_both_faces() {
    let (upper, lower) = (rough(&grid(), 1), rough(&grid(), 2));
    let (body, grid) = (slab(0.3, 0.2), grid());
    let field = Array2::from_shape_fn((N, N), |(i, j)| 0.4 + 0.1 * ((i + 2 * j) % 3) as f64);
    for law in [None, Some(exponential().into_shared())] {
        let (lower, hardness) = (Some((&lower).into()), Some(field.clone().into()));
        let parts = Parts { law, hardness, lower, ..Parts::new(&body, &grid, &upper) };
        let contact = Squeezed::new(&parts).unwrap();
        let first = solve(&contact, Load::MeanPressure(0.15), None);
        let away = solve(&contact, Load::MeanPressure(0.05), Some(&first));
        let again = solve(&contact, Load::MeanPressure(0.15), Some(&away));
        for (face, [first, away]) in
            [(&again.upper, [&first.upper, &away.upper]), (&again.lower, [&first.lower, &away.lower])]
        {
            let depth = face.plastic_depth().unwrap();
            assert!(depth.iter().any(|depth| *depth > 0.0));
            assert!(apart(depth, first.plastic_depth().unwrap()) < 1e-6);
            assert_eq!(away.plastic_depth(), first.plastic_depth());
            assert!(apart(&face.pressure(), &first.pressure()) < 1e-6);
            assert!(face.plastic_fraction > 0.0 && away.plastic_fraction < face.plastic_fraction);
        }
        assert!(first.upper.losses.plastic > 0.0 && away.upper.losses.plastic == 0.0);
        let fields: Vec<_> = [&first.upper, &first.lower]
            .iter()
            .flat_map(|face| {
                [face.gap().to_owned(), face.pressure().into_owned(), face.plastic_depth().unwrap().clone()]
            })
            .collect();
        assert_eq!(contact.basis().len(), fields.len());
        let fields: Vec<_> = fields.iter().map(|field| &**field).collect();
        let certified = contact.certify(&fields, Load::MeanPressure(0.15).into()).unwrap();
        assert!(certified.worst() < 1e-8, "{}", certified.worst());
        assert_near(certified.approach, first.approach, 1e-9);
    }
}

/// Loads, holds and unloads, while both surfaces slide on.
fn drives(scale: f64) -> [Drive; 5] {
    [(0.1, 0.0), (0.2, 0.5), (0.2, 3.0), (0.05, 3.5), (0.15, 10.0)]
        .map(|(mean, time)| Drive::from(Load::MeanPressure(scale * mean)).at(time).after(0.1 * time))
}

fn follow<E: Equilibrium>(contact: &E, drives: &[Drive]) -> Vec<E::State> {
    let mut states: Vec<E::State> = Vec::new();
    for drive in drives {
        let solved = contact.press(*drive).tolerance(1e-10).max_iterations(500).starting_from(states.last()).solve();
        states.push(solved.unwrap_or_else(|error| panic!("{drive:?}: {error}")));
    }
    states
}

/// Relaxation, wear, hardness and a law at once: mirror images are one surface on a sliding base of half the height.
#[test]
fn histories_of_mirror_images_are_those_of_one_surface() {
    let (surface, grid, prony) = (rough(&grid(), 1), grid(), Prony::from_fractions(&[(1.3, 0.6)]).unwrap());
    let (body, half) = (slab(0.3, 0.4), slab(0.3, 0.2).on(Base::SLIDING).unwrap());
    let law = || Some(Exponential::new(5e-5, 0.01).unwrap().into_shared());
    let relaxation = Some((&prony, Relaxes::Both));
    let wear = Some(Wear { by_distance: 0.03, by_slip: 0.0 });
    let plain = Parts::new(&body, &grid, &surface);
    for parts in [
        Parts { relaxation, ..plain.clone() },
        Parts { relaxation, law: law(), ..plain.clone() },
        Parts { wear, ..plain.clone() },
        Parts { wear, law: law(), ..plain.clone() },
        Parts { relaxation, wear, hardness: Some(0.5.into()), law: law(), ..plain.clone() },
    ] {
        let both =
            follow(&Squeezed::new(&Parts { lower: Some((&surface).into()), ..parts.clone() }).unwrap(), &drives(1.0));
        let one = follow(&QuasistaticContact::new(&Parts { body: &half, ..parts.clone() }).unwrap(), &drives(1.0));
        for (found, wanted) in both.iter().zip(&one) {
            for face in [&found.upper, &found.lower] {
                let error = apart(&face.pressure(), &wanted.pressure());
                assert!(error < 1e-6, "{error}");
                let depths = face.wear_depth().zip(wanted.wear_depth());
                assert!(depths.is_none_or(|(found, wanted)| wanted.sum() == 0.0 || apart(found, wanted) < 1e-6));
                assert_near(face.elastic_energy(), 2.0 * wanted.elastic_energy(), 1e-6);
                let (lost, expected) = (face.losses, wanted.losses);
                for (lost, expected) in [
                    (lost.relaxation, expected.relaxation),
                    (lost.wear, expected.wear),
                    (lost.plastic, expected.plastic),
                ] {
                    assert!((lost - 2.0 * expected).abs() < 1e-6 * wanted.elastic_energy(), "{lost} {expected}");
                }
            }
            assert_near(found.approach, 2.0 * wanted.approach(), 1e-6);
        }
    }
}

/// Two surfaces that differ: a jump and a long hold are elastic contacts with the short- and the long-term moduli, and
/// each face wears in proportion to load and distance.
#[test]
fn histories_of_two_surfaces_have_their_limits() {
    let (upper, lower) = (rough(&grid(), 1), rough(&grid(), 2));
    let (body, grid, prony) = (slab(0.3, 0.2), grid(), Prony::from_fractions(&[(1.3, 0.6)]).unwrap());
    let plain = Parts { lower: Some((&lower).into()), ..Parts::new(&body, &grid, &upper) };
    let relaxing = Parts { relaxation: Some((&prony, Relaxes::Both)), ..plain.clone() };
    let contact = Squeezed::new(&relaxing).unwrap();
    let load = Load::MeanPressure(0.15);
    assert!(contact.basis().is_empty());
    let states = follow(&contact, &[0.0, 100.0, 200.0, 300.0, 400.0].map(|time| Drive::from(load).at(time)));
    let elastic = SqueezedContact::new(&body, &grid, &upper, &lower).unwrap();
    let stiffening = 1.0 / (1.0 - 0.6);
    let jump = solve(&elastic, Load::MeanPressure(0.15 / stiffening), None);
    let held = solve(&elastic, load, None);
    for (state, wanted, factor) in [(&states[0], &jump, stiffening), (&states[4], &held, 1.0)] {
        for (face, wanted) in [(&state.upper, &wanted.upper), (&state.lower, &wanted.lower)] {
            let error = apart(&face.pressure(), &(factor * &wanted.pressure));
            assert!(error < 1e-5, "{error}");
        }
        assert_near(state.approach, wanted.approach, 1e-6);
        assert_near(state.upper.elastic_energy(), factor * wanted.summary_in(&wanted.scales()).elastic_energy, 1e-5);
    }
    let medium = Relaxing::new(&body, &grid, Boundary::Periodic, 1, &prony, Relaxes::Both).unwrap();
    for state in &states {
        let faces = [&state.upper, &state.lower];
        let memory = faces.map(|face| face.memory().unwrap());
        for (face, memory) in faces.iter().zip(&memory) {
            assert_eq!(memory.len(), 2);
            assert!(memory[0].iter().zip(face.displacement_z()).all(|(d, u)| *d == -u));
        }
        // The springs have all of the energy.
        let [upper, lower] = &memory;
        let energy = medium.elastic_energy_of_plate(&body, [upper, lower]).unwrap();
        assert_near(energy, state.upper.elastic_energy(), 1e-9);
    }
    let wear = Parts { wear: Some(Wear { by_distance: 0.03, by_slip: 0.0 }), ..plain };
    let (mut volume, mut distance) = (0.0, 0.0);
    let contact = Squeezed::new(&wear).unwrap();
    for (state, drive) in follow(&contact, &drives(1.0)).iter().zip(drives(1.0)) {
        let Load::MeanPressure(mean) = drive.load else { panic!() };
        volume += 0.03 * mean * (drive.distance - distance);
        distance = drive.distance;
        for face in [&state.upper, &state.lower] {
            let (found, _) = face.wear_volume_and_depth().unwrap();
            assert!((found - volume).abs() <= 1e-8 * volume, "{found} {volume}");
        }
        let fields: Vec<_> = [&state.upper, &state.lower]
            .iter()
            .flat_map(|face| [face.gap().to_owned(), face.pressure().into_owned(), face.wear_depth().unwrap().clone()])
            .collect();
        assert_eq!(contact.basis().len(), fields.len());
        let fields: Vec<_> = fields.iter().map(|field| &**field).collect();
        let certified = contact.certify(&fields, drive).unwrap();
        assert!(certified.worst() < 1e-8, "{}", certified.worst());
        assert_near(certified.approach, state.approach, 1e-8);
    }
}

/// A pull that one face cannot bear parts the surfaces, whatever the other face bears.
#[test]
fn a_pull_parts_the_weaker_face() {
    let (rough_side, flat) = (rough(&grid(), 1), 0.05 * rough(&grid(), 2));
    let contact = between(&slab(0.3, 0.5), &grid(), [&rough_side, &flat], exponential());
    let pressed = solve(&contact, Load::MeanPressure(0.05), None);
    let pulled = contact.press(Load::MeanPressure(-0.03)).starting_from(Some(&pressed)).solve();
    assert!(matches!(pulled, Err(SolveError::Detached { .. })), "{:?}", pulled.map(|state| state.approach));
    let held = solve(&contact, Load::MeanPressure(-0.0005), Some(&pressed));
    assert!(held.worst() <= 1e-10 && held.mean_pressure() < 0.0);
}

/// Numbers scale with units of any size, and the bits do not depend on the number of threads.
#[test]
fn states_scale_with_the_units_and_have_the_same_bits_on_all_threads() {
    let (upper, lower) = (rough(&grid(), 1), rough(&grid(), 2));
    let contact = between(&slab(0.3, 0.2), &grid(), [&upper, &lower], morse());
    let load = Load::MeanPressure(0.05);
    let state = solve(&contact, load, None);
    let (length, stress) = (2.0_f64.powi(-60), 2.0_f64.powi(80));
    let body = Body::slab(gfmd_green::Material::from_young(2.0 * stress, 0.3).unwrap(), 0.2 * length).unwrap();
    let cell = Grid::square(N, length).unwrap();
    let glue = Morse::new(4e-4 * stress * length, 0.01 * length).unwrap();
    let (tall, deep) = (&upper * length, &lower * length);
    let small = between(&body, &cell, [&tall, &deep], glue);
    let parts = Parts { law: Some(glue.into_shared()), lower: Some((&deep).into()), ..Parts::new(&body, &cell, &tall) };
    let on_path = Squeezed::new(&parts).unwrap();
    let load_there = Load::MeanPressure(0.05 * stress);
    let (scaled, step) = (solve(&small, load_there, None), solve(&on_path, load_there, None));
    for (found, wanted) in [(&scaled.upper, &state.upper), (&scaled.lower, &state.lower)] {
        assert!(apart(&(&found.gap() / length), wanted.gap()) < 1e-9);
        assert!(apart(&(found.pressure().mapv(|p| p / stress)), &wanted.pressure()) < 1e-9);
        assert_near(of_law(found).contact_fraction, of_law(wanted).contact_fraction, 0.0);
    }
    assert_near(of_law(&step.upper).contact_fraction, of_law(&state.upper).contact_fraction, 0.0);
    assert_near(scaled.approach / length, state.approach, 1e-9);
    assert_near(step.approach / length, state.approach, 1e-9);
    let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let single = alone.install(|| solve(&contact, load, None));
    assert_eq!([of_law(&single.upper), of_law(&single.lower)], [of_law(&state.upper), of_law(&state.lower)]);
}

#[test]
fn impossible_problems_are_refused() {
    let (surface, grid) = (rough(&grid(), 1), grid());
    let half_space = Body::half_space(material(0.3));
    assert!(both_faces((&half_space, false), &grid, [&surface, &surface], morse()).is_err());
    let body = slab(0.5, 0.2);
    let small = Array2::zeros((4, 4));
    let refused = both_faces((&body, false), &grid, [&surface, &small], morse());
    assert!(matches!(refused, Err(Refusal::Shape { .. })));
    let wear = Some(Wear { by_distance: 0.0, by_slip: 1.0 });
    let both = Parts { lower: Some((&surface).into()), ..Parts::new(&body, &grid, &surface) };
    assert!(matches!(Squeezed::new(&Parts { wear, ..both.clone() }), Err(Refusal::WearBySlip)));
    let one_face = Squeezed::new(&Parts { lower: None, ..both.clone() });
    assert!(matches!(one_face, Err(Refusal::Faces { found: 1, expected: 2 })));
    assert!(matches!(QuasistaticContact::new(&both), Err(Refusal::Faces { found: 2, expected: 1 })));
    let prony = Prony::from_fractions(&[(1.3, 0.6)]).unwrap();
    let parts = Parts { relaxation: Some((&prony, Relaxes::Shear)), ..both.clone() };
    assert!(matches!(Squeezed::new(&parts), Err(Refusal::ShearAlone { .. })));
    let contact = between(&body, &grid, [&surface, &surface], exponential());
    let refused = Squeezed::new(&Parts { hardness: Some(small.into()), ..both });
    assert!(matches!(refused, Err(Refusal::HardnessShape { expected: [N, N], .. })));
    // An incompressible slab cannot be pressed beyond full contact, and its limit counts both surfaces.
    let limit = contact.surfaces().iter().map(|surface| surface.mean_clearance()).sum::<f64>();
    match contact.check(Load::Approach(1.1 * limit).into()) {
        Err(Refusal::Approach { found, limit: Some(most) }) => {
            assert_near(found, 1.1 * limit, 1e-12);
            assert_near(most, limit, 1e-12);
        }
        other => panic!("{other:?}"),
    }
    let dynamics = contact.press(Load::MeanPressure(0.1)).solver(Solver::Fire2).solve();
    assert!(matches!(dynamics, Err(SolveError::Refused(Refusal::Solver { .. }))));
}

/// No part is ignored: what does not act under loads, or not beside another part, is refused by name.
#[test]
fn loads_refuse_parts_that_do_not_act() {
    let (surface, grid, body) = (rough(&grid(), 1), grid(), slab(0.3, 0.2));
    let loads = Parts { sequence: Sequence::Loads, ..Parts::new(&body, &grid, &surface) };
    let refused = |parts: &Parts| QuasistaticContact::new(parts).unwrap_err();
    let wear = Some(Wear { by_distance: 1.0, by_slip: 0.0 });
    assert_eq!(
        refused(&Parts { wear, ..loads.clone() }).to_string(),
        "a coefficient of wear is given; it must be left out with loads"
    );
    let squeezed = Squeezed::new(&Parts { wear, lower: Some((&surface).into()), ..loads.clone() });
    assert!(matches!(squeezed, Err(Refusal::NoWall { .. })));
    let boundary = Boundary::Free;
    assert!(matches!(refused(&Parts { held: true, boundary, ..loads.clone() }), Refusal::Held { .. }));
    let moving = Parts { all_components: true, ..loads };
    assert!(matches!(refused(&Parts { boundary, ..moving.clone() }), Refusal::NotNormal { with: "free boundaries" }));
    assert!(matches!(refused(&Parts { held: true, ..moving.clone() }), Refusal::Held { .. }));
    let on_path = Parts { sequence: Sequence::Path, ..moving.clone() };
    assert!(matches!(refused(&on_path), Refusal::NotNormal { with: "a hard wall along a path" }));
    assert!(QuasistaticContact::new(&moving).is_ok());
}
