//! Laws in all components on a patch with free boundaries: a dense reference, limits, symmetries, checkpoints.

use std::sync::Arc;

use gfmd_contact::{
    Boundary, Cotangents, Drive, Equilibrium, Fields, Load, MemoryCheckpoint, Refusal, Resumable, SolveError, Solver,
};
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Material, PatchMatrix, patch_matrix};
use gfmd_interface::{Interface, Parts, Path, QuasistaticContact, Refinement, State};
use gfmd_law::{CoupledExponential, Exponential, HardWall, Law, Morse, Npc, Separation, XuNeedleman};
use gfmd_relax::Budget;
use ndarray::{Array2, s};

/// Law whose attraction these grids resolve.
const SOFT: Separation =
    Separation { normal_work: 2e-3, tangential_work: 2e-3, normal_length: 0.03, tangential_length: 0.03 };

fn half_space(poisson: f64) -> Body {
    Body::half_space(Material::from_young(1.0, poisson).unwrap())
}

/// Returns a rough surface that is not periodic.
fn rough([nx, ny]: [usize; 2]) -> Array2<f64> {
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let [x, y] = [i as f64 / nx as f64, j as f64 / ny as f64];
        0.02 * (5.3 * x + 1.0).sin() * (4.1 * y).cos() + 0.005 * (31.0 * x - 17.0 * y).sin() + 0.01 * x
    })
}

fn on_patch(body: &Body, grid: &Grid, heights: &Array2<f64>, law: impl Law + 'static) -> Interface {
    Interface::in_all_components_with_boundary(Boundary::Free, body, grid, heights, law).unwrap()
}

fn drive(load: Load, lateral: [f64; 2]) -> Drive {
    Drive { lateral, ..load.into() }
}

fn solve(interface: &Interface, drive: Drive, start: Option<&State>) -> State {
    interface.press(drive).starting_from(start).tolerance(1e-10).solve().unwrap()
}

/// Returns the largest difference of two fields.
fn apart<'a>(found: impl IntoIterator<Item = &'a f64>, wanted: impl IntoIterator<Item = &'a f64>) -> f64 {
    found.into_iter().zip(wanted).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
}

/// Solves a dense system by Gaussian elimination with partial pivoting.
fn eliminate(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Vec<f64> {
    let n = right.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| matrix[*a][k].abs().total_cmp(&matrix[*b][k].abs())).unwrap();
        matrix.swap(k, pivot);
        right.swap(k, pivot);
        let (upper, lower) = matrix.split_at_mut(k + 1);
        for (row, below) in lower.iter_mut().enumerate() {
            let factor = below[k] / upper[k][k];
            below[k..].iter_mut().zip(&upper[k][k..]).for_each(|(a, b)| *a -= factor * b);
            right[k + 1 + row] -= factor * right[k];
        }
    }
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|j| matrix[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / matrix[k][k];
    }
    right
}

/// Returns the compliance of all pairs of cells: displacement (row) per traction (column), component after component.
fn dense_compliance(body: &Body, grid: &Grid) -> Vec<Vec<f64>> {
    let ([_, ny], points) = (grid.points(), grid.len());
    let between = patch_matrix(body, grid).unwrap();
    let entry = |row: usize, column: usize| {
        let [at, from] = [row % points, column % points];
        let [i, j] = [(at / ny).abs_diff(from / ny), (at % ny).abs_diff(from % ny)];
        let x = if at / ny < from / ny { -1.0 } else { 1.0 };
        let y = if at % ny < from % ny { -1.0 } else { 1.0 };
        let PatchMatrix { xx, yy, zz, xy, xz, yz } = between([i, j]);
        match (row / points, column / points) {
            (0, 0) => xx,
            (1, 1) => yy,
            (2, 2) => zz,
            (0, 1) | (1, 0) => x * y * xy,
            (0, 2) => x * xz,
            (2, 0) => -x * xz,
            (1, 2) => y * yz,
            _ => -y * yz,
        }
    };
    (0..3 * points).map(|row| (0..3 * points).map(|column| entry(row, column)).collect()).collect()
}

/// Returns displacement and traction of all points by Newton's method for the traction t = T(Δ − G t).
fn dense(compliance: &[Vec<f64>], clearance: &[f64], law: &dyn Law, drive: Drive) -> [Vec<f64>; 2] {
    let (points, Load::Approach(approach)) = (clearance.len(), drive.load) else { panic!("a load") };
    let mut traction = vec![0.0; 3 * points];
    for _ in 0..60 {
        let moved: Vec<f64> =
            compliance.iter().map(|row| row.iter().zip(&traction).map(|(g, t)| g * t).sum()).collect();
        let separation = |i: usize| {
            let lateral = [0, 1].map(|c| drive.lateral[c] - moved[c * points + i]);
            (clearance[i] - approach - moved[2 * points + i], lateral)
        };
        let mut left = vec![0.0; 3 * points];
        let mut matrix = vec![vec![0.0; 3 * points]; 3 * points];
        for i in 0..points {
            let (normal, sliding) = separation(i);
            let (wanted, slope) = (law.traction(normal, sliding), law.jacobian(normal, sliding));
            let [tx, ty] = slope.tt;
            let rows = [[tx[0], tx[1], slope.tn[0]], [ty[0], ty[1], slope.tn[1]], [slope.nt[0], slope.nt[1], slope.nn]];
            for (c, row) in rows.iter().enumerate() {
                let k = c * points + i;
                left[k] = wanted[c] - traction[k];
                matrix[k][k] = 1.0;
                for (other, slope) in row.iter().enumerate() {
                    let of = &compliance[other * points + i];
                    matrix[k].iter_mut().zip(of).for_each(|(entry, g)| *entry += slope * g);
                }
            }
        }
        let worst = left.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
        let largest = traction.iter().fold(1e-300, |most: f64, t| most.max(t.abs()));
        if worst < 1e-13 * largest {
            return [moved, traction];
        }
        let step = eliminate(matrix, left);
        // Far from the solution a full step would leave the range of the law.
        let longest = step.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
        let share = (0.02 / longest).min(1.0);
        traction.iter_mut().zip(&step).for_each(|(t, step)| *t += share * step);
    }
    panic!("the dense method does not converge")
}

#[test]
fn states_are_those_of_a_dense_method() {
    let material = Material::from_young(1.0, 0.3).unwrap();
    let slab = Body::slab(material, 0.4).unwrap();
    let two = half_space(0.1).against(Body::half_space(Material::from_young(3.0, 0.45).unwrap()));
    let laws = [
        Npc::new(SOFT).unwrap().into_shared(),
        XuNeedleman::new(SOFT, 0.5).unwrap().into_shared(),
        CoupledExponential::new(Separation { tangential_work: 1e-3, ..SOFT }).unwrap().into_shared(),
    ];
    for (body, points) in [
        (half_space(0.3), [7, 6]),
        (slab, [5, 8]),
        (two, [6, 6]),
        // Its cell has three times the points.
        (half_space(-0.5), [4, 16]),
    ] {
        let grid = Grid::new(points, points.map(|n| 0.15 * n as f64)).unwrap();
        let heights = rough(points);
        let compliance = dense_compliance(&body, &grid);
        for law in &laws {
            let interface = on_patch(&body, &grid, &heights, Arc::clone(law));
            let clearance = interface.surface().clearance().to_vec();
            for (approach, lateral) in [(0.02, [0.01, -0.004]), (-0.01, [0.0, 0.015])] {
                let drive = drive(Load::Approach(approach), lateral);
                let found = solve(&interface, drive, None);
                let [moved, traction] = dense(&compliance, &clearance, law.as_ref(), drive);
                let largest = traction.iter().fold(0.0, |most: f64, t| most.max(t.abs()));
                assert!(apart(&found.traction, &traction) < 1e-7 * largest, "{body:?} {law:?} {drive:?}");
                assert!(apart(&found.displacement, &moved) < 1e-9, "{body:?} {law:?} {drive:?}");
                let work: f64 = traction.iter().zip(&moved).map(|(t, u)| 0.5 * t * u).sum();
                let energy = work / grid.len() as f64;
                assert!((found.elastic_energy / energy - 1.0).abs() < 1e-6, "{energy} {}", found.elastic_energy);
                for c in [0, 1] {
                    let mean = traction[c * grid.len()..][..grid.len()].iter().sum::<f64>() / grid.len() as f64;
                    assert!((found.mean_shear[c] - mean).abs() < 1e-7 * largest);
                }
            }
        }
    }
}

#[test]
fn load_approach_solvers_and_starts_agree() {
    let (points, body) = ([14, 11], half_space(0.25));
    let grid = Grid::new(points, [1.0, 0.8]).unwrap();
    for law in [Npc::new(SOFT).unwrap().into_shared(), XuNeedleman::new(SOFT, 0.5).unwrap().into_shared()] {
        let interface = on_patch(&body, &grid, &rough(points), law);
        assert_eq!((interface.boundary(), interface.trapping()), (Boundary::Free, None));
        let mean = 0.01;
        let pressed = solve(&interface, drive(Load::MeanPressure(mean), [0.012, 0.005]), None);
        assert!((pressed.mean_pressure / mean - 1.0).abs() < 1e-8 && pressed.mean_shear[0] > pressed.mean_shear[1]);
        let approach = drive(Load::Approach(pressed.approach), pressed.lateral);
        for solver in [Solver::Auto, Solver::Fire2] {
            let found = interface.press(approach).solver(solver).tolerance(1e-9).solve().unwrap();
            assert!(apart(&found.displacement, &pressed.displacement) < 1e-7, "{solver}");
            assert!((found.elastic_energy / pressed.elastic_energy - 1.0).abs() < 1e-6);
        }
        // The displacement outside the patch follows from the tractions, so that a state is its own solution.
        for load in [Load::MeanPressure(mean), Load::Approach(pressed.approach)] {
            let again = interface.press(drive(load, pressed.lateral)).starting_from(Some(&pressed));
            let again = again.tolerance(1e-8).solve().unwrap();
            assert_eq!(again.effort.iterations, 0, "{load:?}");
        }
    }
}

#[test]
fn without_shear_they_are_the_states_of_u_z_alone() {
    let points = [17, 12];
    let grid = Grid::new(points, [1.0, 0.7]).unwrap();
    let heights = rough(points);
    let none = Separation { normal_length: 0.05, tangential_length: 0.05, ..SOFT };
    let cases: [(f64, Arc<dyn Law>, [f64; 2]); 5] = [
        (0.3, HardWall.into_shared(), [0.01, 0.0]),
        (0.3, Exponential::new(2e-4, 8e-3).unwrap().into_shared(), [0.0, 0.01]),
        (-0.2, Morse::new(2e-4, 8e-3).unwrap().into_shared(), [0.0; 2]),
        // Pressure moves the surface of an incompressible half-space along z alone.
        (0.5, Npc::new(none).unwrap().into_shared(), [0.0; 2]),
        (0.5, XuNeedleman::new(none, 0.5).unwrap().into_shared(), [0.0; 2]),
    ];
    for (poisson, law, lateral) in cases {
        let body = half_space(poisson);
        let one = Interface::with_boundary(Boundary::Free, &body, &grid, &heights, law.clone()).unwrap();
        let all = on_patch(&body, &grid, &heights, law.clone());
        for load in [Load::MeanPressure(0.01), Load::Approach(0.006)] {
            let (wanted, found) = (solve(&one, load.into(), None), solve(&all, drive(load, lateral), None));
            let most = wanted.pressure().iter().fold(0.0, |most: f64, p| most.max(p.abs()));
            assert!(apart(&found.gap, &wanted.gap) < 1e-8, "{law:?} {load:?}");
            assert!(apart(&found.pressure(), &wanted.pressure()) < 1e-6 * most, "{law:?} {load:?}");
            assert!((found.elastic_energy / wanted.elastic_energy - 1.0).abs() < 1e-7, "{law:?} {load:?}");
            assert!((found.interface_energy - wanted.interface_energy).abs() < 1e-7 * wanted.elastic_energy);
            assert!(found.mean_shear.iter().all(|shear| shear.abs() < 1e-8 * most), "{:?}", found.mean_shear);
        }
    }
}

/// Mindlin (1949): a circular contact that sticks everywhere resists a lateral displacement with the stiffness
/// 8 a G/(2 − ν), exact without coupling of shear and pressure (ν = ½).
#[test]
fn a_disc_that_sticks_has_the_lateral_stiffness_of_mindlin() {
    let poisson = 0.5;
    let material = Material::from_young(1.0, poisson).unwrap();
    let (side, radius) = (1.0, 0.25);
    // A law much stiffer than the body below the disc, and out of reach beside it.
    let stiff = Separation { normal_work: 1e-2, tangential_work: 1e-2, normal_length: 1e-2, tangential_length: 1e-2 };
    let errors: Vec<f64> = [16, 32]
        .into_iter()
        .map(|n| {
            let at = |i: usize| side * ((i as f64 + 0.5) / n as f64 - 0.5);
            let disc = |i: usize, j: usize| if at(i).hypot(at(j)) < radius { 0.0 } else { -1.0 };
            let disc = Array2::from_shape_fn((n, n), |(i, j)| disc(i, j));
            let area = disc.iter().filter(|height| **height == 0.0).count() as f64 * (side / n as f64).powi(2);
            let law = Npc::new(stiff).unwrap();
            let interface = on_patch(&Body::half_space(material), &Grid::square(n, side).unwrap(), &disc, law);
            let moved = 1e-6;
            let state = solve(&interface, drive(Load::Approach(0.0), [0.0, moved]), None);
            let force = state.mean_shear[1] * side * side;
            let radius = (area / std::f64::consts::PI).sqrt();
            let wanted = 8.0 * radius * material.shear_modulus() / (2.0 - poisson) * moved;
            // The springs of the law act in series.
            let springs = area * stiff.tangential_work / stiff.tangential_length.powi(2) * moved;
            assert!(state.mean_shear[0].abs() < 1e-6 * state.mean_shear[1]);
            1.0 / (1.0 / force - 1.0 / springs) / wanted - 1.0
        })
        .collect();
    assert!(errors[1].abs() < 0.03 && errors[1].abs() < 0.7 * errors[0].abs(), "{errors:?}");
}

#[test]
fn a_mirrored_surface_moved_back_is_sheared_back() {
    let (points, body) = ([12, 9], half_space(0.2));
    let grid = Grid::new(points, [1.0, 0.75]).unwrap();
    let heights = rough(points);
    let mirrored = heights.slice(s![..;-1, ..]).to_owned();
    let law = || Npc::new(SOFT).unwrap();
    for load in [Load::MeanPressure(0.005), Load::Approach(0.01)] {
        let here = solve(&on_patch(&body, &grid, &heights, law()), drive(load, [0.01, 0.003]), None);
        let there = solve(&on_patch(&body, &grid, &mirrored, law()), drive(load, [-0.01, 0.003]), None);
        assert!(apart(&here.gap, there.gap.slice(s![..;-1, ..])) < 1e-9);
        let [[x, y], [other_x, other_y]] = [here.mean_shear, there.mean_shear];
        assert!((x + other_x).abs() < 1e-8 * x && (y - other_y).abs() < 1e-8 * x, "{x} {other_x} {y} {other_y}");
    }
}

/// Without a jump a law keeps all energy: the work of shear comes back, and so does the state.
#[test]
fn shear_to_both_sides_and_back_loses_nothing() {
    let (points, body) = ([12, 10], half_space(0.3));
    let (grid, heights) = (Grid::new(points, [1.0, 0.8]).unwrap(), rough(points));
    let parts = Parts {
        boundary: Boundary::Free,
        law: Some(Npc::new(SOFT).unwrap().into_shared()),
        all_components: true,
        ..Parts::new(&body, &grid, &heights)
    };
    let contact = QuasistaticContact::new(&parts).unwrap();
    assert_eq!(contact.boundary(), Boundary::Free);
    let mut path = Path::new(&contact, Budget { tolerance: 1e-10, ..Budget::default() }, Refinement::default());
    let mut shears = Vec::new();
    for lateral in [0.0, 0.006, 0.012, 0.0, -0.012, 0.0] {
        let step = path.step(drive(Load::MeanPressure(0.01), [lateral, 0.0]), &mut ()).unwrap();
        let state = path.state().unwrap();
        let kept = state.elastic_energy() + state.interface_energy().abs();
        assert_eq!(step.jumped, Some(false), "{lateral}");
        assert!(step.dissipated.unwrap().abs() < 1e-4 * kept, "{lateral}: {step:?} of {kept}");
        shears.push(state.mean_shear[0]);
    }
    assert!((shears[3] - shears[0]).abs() < 1e-8 * shears[2] && (shears[5] - shears[0]).abs() < 1e-8 * shears[2]);
    assert!(shears[1] > 0.0 && shears[2] > shears[1] && shears[4] < 0.0, "{shears:?}");
}

#[test]
fn a_wall_that_moves_sideways_does_not_jump() {
    let (points, body) = ([12, 10], half_space(0.3));
    let (grid, heights) = (Grid::new(points, [1.0, 0.8]).unwrap(), rough(points));
    for law in [HardWall.into_shared(), Exponential::new(2e-4, 8e-3).unwrap().into_shared()] {
        let interface = on_patch(&body, &grid, &heights, law);
        let mut path = Path::new(&interface, Budget::default(), Refinement::default());
        for lateral in [0.0, 0.004, 0.008] {
            let step = path.step(drive(Load::MeanPressure(0.01), [lateral, 0.0]), &mut ()).unwrap();
            assert_eq!(step.jumped, Some(false), "{step:?}");
        }
    }
}

#[test]
fn a_state_that_is_kept_leads_to_the_same_bits() {
    let (points, body) = ([10, 13], half_space(0.3));
    let interface = on_patch(&body, &Grid::new(points, [1.0, 1.3]).unwrap(), &rough(points), Npc::new(SOFT).unwrap());
    let first = drive(Load::MeanPressure(0.01), [0.005, 0.0]);
    for then in [Load::MeanPressure(0.004), Load::Approach(0.004)].map(|load| drive(load, [0.01, 0.002])) {
        let mut state = solve(&interface, first, None);
        let next = solve(&interface, then, Some(&state));
        let mut checkpoint = MemoryCheckpoint::default();
        interface.keep(&mut state, &mut checkpoint);
        checkpoint.rewind();
        let restored = interface.restore(first, &mut checkpoint).unwrap();
        assert_eq!(solve(&interface, then, Some(&restored)), next);
    }
}

#[test]
fn bodies_without_lateral_support_are_refused() {
    let law = || Npc::new(SOFT).unwrap();
    let of = |body: &Body, grid: &Grid, heights: &Array2<f64>| {
        Interface::in_all_components_with_boundary(Boundary::Free, body, grid, heights, law())
    };
    let refused = of(&half_space(0.3), &Grid::line(16, 1.0).unwrap(), &rough([16, 1])).unwrap_err();
    assert!(matches!(refused, Refusal::Body(_)), "{refused}");
    let slab = Body::slab(Material::from_young(1.0, 0.3).unwrap(), 0.4).unwrap();
    for base in [Base::SLIDING, Base::FREE] {
        let body = slab.clone().on(base).unwrap();
        let refused = of(&body, &Grid::square(8, 1.0).unwrap(), &rough([8, 8])).unwrap_err();
        assert!(matches!(refused, Refusal::Body(_)), "{refused}");
    }
    // The law moves all components, which have no gradient of u_z alone.
    let interface = of(&half_space(0.3), &Grid::square(8, 1.0).unwrap(), &rough([8, 8])).unwrap();
    let state = solve(&interface, drive(Load::Approach(0.01), [0.0; 2]), None);
    assert!(interface.gradient(&state, Load::Approach(0.01), &Cotangents::default()).is_err());
    assert!(interface.stiffness(&state, 1e-9).unwrap().value > 0.0);
    let other = interface.press(Load::Approach(0.01)).solver(Solver::Verlet).solve();
    assert!(matches!(other, Err(SolveError::Refused(Refusal::Solver { .. }))));
}
