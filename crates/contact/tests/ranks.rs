//! A contact over ranks, which threads play, has the bits of one process.

use std::sync::Arc;

use gfmd_contact::{Contact, Equilibrium as _, Hardness, Load, Refusal, Solution, SolveError, Solver, Stiffness};
use gfmd_field::{Grid, Share};
use gfmd_green::{Body, Material};
use gfmd_relax::{Budget, Progress, Watch};
use gfmd_surface::SelfAffine;
use gfmd_vector::Rehearsal;
use ndarray::Array2;
use proptest::prelude::*;

fn half_space() -> Body {
    Body::half_space(Material::from_contact_modulus(1.0, 0.3).unwrap())
}

fn slab(height: f64) -> Body {
    Body::slab(Material::from_contact_modulus(1.0, 0.3).unwrap(), height).unwrap()
}

fn rough(grid: &Grid, seed: u64) -> Array2<f64> {
    let [dx, dy] = grid.spacing();
    let shortest = 4.0 * dx.max(dy);
    let longest = grid.lengths().into_iter().fold(0.0, f64::max) / 2.0;
    SelfAffine {
        hurst: 0.8,
        longest_wavelength: longest.max(shortest),
        shortest_wavelength: shortest,
        ..SelfAffine::with_rms_gradient(0.1)
    }
    .heights(grid, seed)
    .unwrap()
}

/// The bits of everything that a contact yields.
fn bits(state: &Solution, stiffness: &Stiffness) -> Vec<u64> {
    let fields = [&state.pressure, &state.displacement, &state.gap];
    let numbers = [state.mean_pressure, state.approach, stiffness.value, stiffness.error, state.residual.worst()];
    let depth = state.plastic.iter().flat_map(|plastic| plastic.depth.iter());
    let all = fields.into_iter().flatten().chain(&numbers).chain(depth).map(|x| x.to_bits());
    all.chain([state.effort.iterations, stiffness.effort.iterations]).collect()
}

fn solve(contact: &Contact, load: Load, solver: Solver) -> Vec<u64> {
    let state = contact.equilibrate(load.into(), solver, &Budget::default(), None, &mut ()).unwrap();
    let stiffness = contact.stiffness(&state).unwrap();
    // The second load starts from the first.
    let second = match load {
        Load::MeanPressure(mean) => Load::MeanPressure(1.5 * mean),
        Load::Approach(approach) => Load::Approach(1.2 * approach),
    };
    let next = contact.equilibrate(second.into(), solver, &Budget::default(), Some(&state), &mut ()).unwrap();
    let mut all = bits(&state, &stiffness);
    all.extend(bits(&next, &stiffness));
    all
}

fn compare(contact: &Contact, load: Load, solver: Solver, size: usize) {
    let alone = solve(contact, load, solver);
    let each = Rehearsal::of(size, |ranks| solve(&contact.clone().over(ranks).unwrap(), load, solver));
    assert!(each.iter().all(|found| *found == alone), "{load:?} {solver:?} on {size}");
}

#[test]
fn a_contact_over_ranks_has_the_bits_of_one_process() {
    for (points, lengths) in [([256, 256], [1.0, 1.0]), ([512, 1000], [1.0, 2.0]), ([1024, 512], [2.0, 1.0])] {
        let grid = Grid::new(points, lengths).unwrap();
        let heights = rough(&grid, 1);
        for body in [half_space(), slab(0.1)] {
            let contact = Contact::new(&body, &grid, &heights).unwrap();
            let approach = 0.5 * contact.surface().mean_clearance();
            for size in [2, 3, 4, 7].into_iter().filter(|size| *size <= Share::most(points, 1)) {
                compare(&contact, Load::MeanPressure(0.002), Solver::Auto, size);
                // So little touches that the pressure is sought on few points.
                compare(&contact, Load::MeanPressure(3e-5), Solver::Auto, size);
            }
            compare(&contact, Load::Approach(approach), Solver::Auto, 2);
        }
    }
}

#[test]
fn levels_that_are_shared_have_the_bits_of_one_process() {
    // Two levels with their own rows, the third gathered.
    let grid = Grid::square(2048, 1.0).unwrap();
    let contact = Contact::new(&half_space(), &grid, &rough(&grid, 3)).unwrap();
    let budget = Budget { max_iterations: 3, ..Budget::default() };
    let begin = |contact: &Contact| {
        let load = Load::MeanPressure(0.004).into();
        match contact.equilibrate(load, Solver::PreconditionedCg, &budget, None, &mut ()) {
            Err(SolveError::NotConverged { state, .. }) => {
                state.pressure.iter().map(|p| p.to_bits()).collect::<Vec<_>>()
            }
            other => panic!("{other:?}"),
        }
    };
    let alone = begin(&contact);
    assert!(
        Rehearsal::of(3, |ranks| begin(&contact.clone().over(ranks).unwrap()) == alone).into_iter().all(|same| same)
    );
}

#[test]
fn the_other_methods_and_a_hardness_have_the_bits_of_one_process() {
    let grid = Grid::square(128, 1.0).unwrap();
    let contact = Contact::new(&half_space(), &grid, &rough(&grid, 2)).unwrap();
    for solver in [Solver::PolonskyKeer, Solver::ProjectedCg, Solver::PreconditionedCg] {
        compare(&contact, Load::MeanPressure(0.005), solver, 3);
    }
    let field = Array2::from_shape_fn((128, 128), |(i, j)| 0.05 + 0.01 * ((i + 2 * j) % 5) as f64);
    for hardness in [Hardness::Uniform(0.05), Hardness::Field(field)] {
        let hard = contact.clone().with_hardness(hardness).unwrap();
        compare(&hard, Load::MeanPressure(0.01), Solver::Auto, 3);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(8))]

    #[test]
    fn contacts_over_ranks_have_the_bits_of_one_process_whatever_the_shape(
        rows in 16_usize..200, columns in 16_usize..200, size in 2_usize..=7, seed in 0_u64..100, thin in any::<bool>(),
    ) {
        let columns = columns.next_multiple_of(16);
        let grid = Grid::new([rows, columns], [1.0, columns as f64 / rows as f64]).unwrap();
        let body = if thin { slab(0.05) } else { half_space() };
        let contact = Contact::new(&body, &grid, &rough(&grid, seed)).unwrap();
        compare(&contact, Load::MeanPressure(0.005), Solver::Auto, size.min(Share::most([rows, columns], 1)));
    }
}

/// Stops after so many iterations.
struct Stop(u64);

impl Watch for Stop {
    fn see(&mut self, now: &Progress) -> std::ops::ControlFlow<()> {
        if now.iteration >= self.0 { std::ops::ControlFlow::Break(()) } else { std::ops::ControlFlow::Continue(()) }
    }
}

#[test]
fn a_process_that_is_interrupted_stops_all_at_the_same_iterate() {
    let grid = Grid::square(128, 1.0).unwrap();
    let contact = Contact::new(&half_space(), &grid, &rough(&grid, 2)).unwrap();
    let ends = Rehearsal::of(3, |ranks| {
        let mut watch = Stop(if ranks.rank() == 1 { 4 } else { u64::MAX });
        let load = Load::MeanPressure(0.005).into();
        let contact = contact.clone().over(ranks).unwrap();
        match contact.equilibrate(load, Solver::Auto, &Budget::default(), None, &mut watch) {
            Err(SolveError::Interrupted { state, .. }) => state.effort.iterations,
            other => panic!("{other:?}"),
        }
    });
    assert_eq!(ends, [4; 3]);
}

#[test]
fn what_cannot_be_shared_is_refused() {
    let grid = Grid::square(64, 1.0).unwrap();
    let heights = rough(&grid, 2);
    let over = |contact: &Contact, size| {
        let refused = Rehearsal::of(size, |ranks| contact.clone().over(ranks).err().map(|error| error.to_string()));
        refused.into_iter().next().flatten()
    };
    let contact = Contact::new(&half_space(), &grid, &heights).unwrap();
    assert_eq!(over(&contact, 2), None);
    assert!(over(&contact, 3).unwrap().contains("3 processes; it must be at most 2"));
    let patch = Contact::bounded(gfmd_contact::Boundary::Free, &half_space(), &grid, &heights).unwrap();
    assert!(over(&patch, 2).unwrap().contains("free boundaries"));
    Rehearsal::of(2, |ranks| {
        let contact = contact.clone().over(Arc::clone(&ranks)).unwrap();
        let load = Load::MeanPressure(0.005).into();
        let refused = contact.equilibrate(load, Solver::Verlet, &Budget::default(), None, &mut ());
        assert!(matches!(refused, Err(SolveError::Refused(Refusal::Solver { .. }))));
    });
}
