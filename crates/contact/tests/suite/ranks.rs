//! A contact over ranks, played by threads, has the bits of one process.

use std::sync::Arc;

use gfmd_contact::{
    Boundary, Contact, Equilibrium as _, Fields as _, Hardness, Load, MemoryCheckpoint, Refusal, Resumable as _,
    Solution, SolveError, Solver, SqueezedContact, SteepContact, SteepSolution, Stiffness,
};
use gfmd_field::{Grid, Share};
use gfmd_green::{Body, Material};
use gfmd_relax::{Budget, Progress, Watch};
use gfmd_surface::SelfAffine;
use gfmd_vector::{Ranks, ThreadRanks};
use ndarray::{Array2, s};
use proptest::prelude::*;

use super::long;

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

/// Contact to be made by one process, or by one of several from its rows of the heights.
#[derive(Clone)]
struct Case {
    grid: Grid,
    body: Body,
    heights: Array2<f64>,
    hardness: Option<Hardness>,
    boundary: Boundary,
}

impl Case {
    fn new(grid: Grid, body: &Body, seed: u64) -> Self {
        let (heights, boundary) = (rough(&grid, seed), Boundary::Periodic);
        Self { grid, body: body.clone(), heights, hardness: None, boundary }
    }

    fn free(self) -> Self {
        Self { boundary: Boundary::Free, ..self }
    }

    fn alone(&self) -> Contact {
        self.of(&Share::whole(self.grid.points()[0], self.grid.points()[1]))
    }

    fn over(&self, ranks: Arc<dyn Ranks>) -> Contact {
        self.of(&Contact::share(ranks, &self.grid).unwrap())
    }

    fn of(&self, share: &Share) -> Contact {
        let own = |field: &Array2<f64>| field.slice(s![share.rows(), ..]).to_owned();
        let contact =
            Contact::with_boundary_over(share, self.boundary, &self.body, &self.grid, &own(&self.heights)).unwrap();
        match &self.hardness {
            Some(Hardness::Field(field)) => contact.with_hardness(own(field)).unwrap(),
            Some(hardness) => contact.with_hardness(hardness.clone()).unwrap(),
            None => contact,
        }
    }
}

/// Bits of all results of a contact: numbers, and the own rows of fields.
type Bits = (Vec<u64>, Vec<Vec<u64>>);

fn bits(state: &Solution, stiffness: &Stiffness) -> Bits {
    let summary = state.summary();
    let numbers = [
        state.mean_pressure,
        state.approach,
        state.residual.worst(),
        stiffness.value,
        stiffness.error,
        summary.area_fraction_corrected,
        summary.kappa_corrected,
        summary.mean_gap,
        summary.max_pressure,
        summary.mean_pressure_in_contact,
        summary.pressure_deviation_in_contact,
        summary.pressure_moment_2,
        summary.elastic_energy,
    ];
    let plastic = state.plastic.iter().flat_map(|plastic| [plastic.fraction, plastic.volume, plastic.saturation]);
    let numbers = numbers.into_iter().chain(plastic).map(f64::to_bits);
    let counts = [state.effort.iterations, stiffness.effort.iterations, summary.contact_nodes, summary.boundary_links];
    let fields = [&state.pressure, &state.displacement, &state.gap];
    let all = fields.into_iter().chain(state.plastic.iter().map(|plastic| &plastic.depth));
    let of_field = |field: &Array2<f64>| field.iter().map(|x| x.to_bits()).collect();
    (numbers.chain(counts).collect(), all.map(of_field).collect())
}

fn solve(contact: &Contact, load: Load, solver: Solver) -> [Bits; 2] {
    let state = contact.equilibrate(load.into(), solver, &Budget::default(), None, &mut ()).unwrap();
    let stiffness = contact.stiffness(&state, 1e-9).unwrap();
    // The second load starts from the first.
    let second = match load {
        Load::MeanPressure(mean) => Load::MeanPressure(1.5 * mean),
        Load::Approach(approach) => Load::Approach(1.2 * approach),
    };
    let next = contact.equilibrate(second.into(), solver, &Budget::default(), Some(&state), &mut ()).unwrap();
    [bits(&state, &stiffness), bits(&next, &stiffness)]
}

fn compare(case: &Case, load: Load, solver: Solver, size: usize) {
    let alone = solve(&case.alone(), load, solver);
    let each = ThreadRanks::of(size, |ranks| solve(&case.over(ranks), load, solver));
    for (step, (numbers, fields)) in alone.iter().enumerate() {
        assert!(each.iter().all(|found| found[step].0 == *numbers), "{load:?} {solver:?} on {size}");
        for (place, field) in fields.iter().enumerate() {
            let rows = each.iter().flat_map(|found| &found[step].1[place]);
            assert!(rows.eq(field), "field {place}, {load:?} {solver:?} on {size}");
        }
    }
}

#[test]
fn a_slab_between_two_surfaces_over_ranks_has_the_bits_of_one_process() {
    let grid = Grid::new([128, 64], [1.0, 0.6]).unwrap();
    let (upper, lower) = (rough(&grid, 3), rough(&grid, 4) * 0.5);
    let field = Array2::from_shape_fn((128, 64), |(i, j)| 0.1 + 0.02 * ((i + 2 * j) % 5) as f64);
    let cases = [
        (Load::MeanPressure(0.01), None, false, 4),
        (Load::Approach(0.01), None, true, 2),
        (Load::MeanPressure(0.02), Some(Hardness::Field(field)), false, 3),
    ];
    for (load, hardness, is_held, size) in cases {
        let solve = |share: &Share| {
            let own = |field: &Array2<f64>| field.slice(s![share.rows(), ..]).to_owned();
            let make = if is_held { SqueezedContact::held_sideways_over } else { SqueezedContact::distributed };
            let contact = make(share, &slab(0.1), &grid, &own(&upper), &own(&lower)).unwrap();
            let contact = match &hardness {
                Some(Hardness::Field(field)) => contact.with_hardness(own(field)).unwrap(),
                _ => contact,
            };
            let mut state = contact.equilibrate(load.into(), Solver::Auto, &Budget::default(), None, &mut ()).unwrap();
            let mut kept = MemoryCheckpoint::default();
            contact.keep(&mut state, &mut kept);
            kept.rewind();
            let restored = contact.restore(load.into(), &mut kept).unwrap();
            let next = match load {
                Load::MeanPressure(mean) => Load::MeanPressure(1.5 * mean),
                Load::Approach(approach) => Load::Approach(1.2 * approach),
            };
            let then = contact.equilibrate(next.into(), Solver::Auto, &Budget::default(), Some(&restored), &mut ());
            let none = Stiffness { value: 0.0, error: 0.0, effort: Default::default() };
            [state, then.unwrap()].map(|state| {
                let faces = [&state.upper, &state.lower].map(|face| bits(face, &none));
                let numbers = [state.approach, state.effort.transform_pairs, state.worst()].map(f64::to_bits);
                let [upper, lower] = faces;
                (
                    upper.0.into_iter().chain(lower.0).chain(numbers).chain([state.effort.iterations]).collect(),
                    upper.1.into_iter().chain(lower.1).collect(),
                )
            })
        };
        let alone: [Bits; 2] = solve(&grid.whole());
        let each = ThreadRanks::of(size, |ranks| solve(&Contact::share(ranks, &grid).unwrap()));
        for (step, (numbers, fields)) in alone.iter().enumerate() {
            let different = |found: &[Bits; 2]| (0..numbers.len()).find(|k| found[step].0[*k] != numbers[*k]);
            assert_eq!(each.iter().find_map(different), None, "number that differs: {load:?} on {size}");
            for (place, field) in fields.iter().enumerate() {
                let rows = each.iter().flat_map(|found| &found[step].1[place]);
                assert!(rows.eq(field), "field {place}, {load:?} on {size}");
            }
        }
    }
}

/// Bits of a contact with finite slopes.
fn steep_bits(state: &SteepSolution) -> Bits {
    let summary = state.summary();
    let numbers = [
        state.mean_pressure(),
        state.approach(),
        state.mean_shear[0],
        state.mean_shear[1],
        state.lateral_residual,
        state.projected_area().unwrap(),
        summary.elastic_energy,
        summary.area_fraction_corrected,
        state.effort().transform_pairs,
    ];
    let residuals = state.residuals().into_iter().map(|(_, residual)| residual);
    let (pressure, normal) = (state.pressure(), [state.displacement_z(), state.gap()]);
    let fields = std::iter::once(pressure.view()).chain(normal).chain(state.lateral.iter().map(|u| u.view()));
    let of_field = |field: ndarray::ArrayView2<f64>| field.iter().map(|x| x.to_bits()).collect();
    (numbers.into_iter().chain(residuals).map(f64::to_bits).collect(), fields.map(of_field).collect())
}

#[test]
fn finite_slopes_over_ranks_have_the_bits_of_one_process() {
    let field = |[nx, ny]: [usize; 2]| Array2::from_shape_fn((nx, ny), |(i, j)| 0.1 + 0.02 * ((i + 2 * j) % 5) as f64);
    let grid = |points| Grid::new(points, [1.0, 0.6]).unwrap();
    let cases = [
        (Case::new(grid([128, 64]), &half_space(), 3), Load::MeanPressure(0.01), 4),
        (Case::new(grid([96, 64]), &slab(0.2), 4), Load::Approach(0.01), 2),
        (
            Case { hardness: Some(Hardness::Field(field([128, 64]))), ..Case::new(grid([128, 64]), &half_space(), 5) },
            Load::MeanPressure(0.02),
            3,
        ),
    ];
    for (case, load, size) in cases {
        let Case { grid, body, hardness, .. } = &case;
        // Slopes of up to about one, and points that move to rows of other processes.
        let heights = &case.heights * 3.0;
        let solve = |share: &Share| {
            let own = |field: &Array2<f64>| field.slice(s![share.rows(), ..]).to_owned();
            let contact = SteepContact::distributed(share, body, grid, &own(&heights)).unwrap();
            let contact = match hardness {
                Some(Hardness::Field(field)) => contact.with_hardness(own(field)).unwrap(),
                _ => contact,
            };
            let mut state = contact.equilibrate(load.into(), Solver::Auto, &Budget::default(), None, &mut ()).unwrap();
            let mut kept = MemoryCheckpoint::default();
            contact.keep(&mut state, &mut kept);
            kept.rewind();
            let restored = contact.restore(load.into(), &mut kept).unwrap();
            assert_eq!(steep_bits(&restored).1, steep_bits(&state).1);
            let next = match load {
                Load::MeanPressure(mean) => Load::MeanPressure(1.5 * mean),
                Load::Approach(approach) => Load::Approach(1.2 * approach),
            };
            let then = contact.equilibrate(next.into(), Solver::Auto, &Budget::default(), Some(&restored), &mut ());
            let mut found = steep_bits(&state);
            found.0.push(contact.stiffness(&state, 1e-8).unwrap().value.to_bits());
            [found, steep_bits(&then.unwrap())]
        };
        let alone = solve(&grid.whole());
        let each = ThreadRanks::of(size, |ranks| solve(&Contact::share(ranks, grid).unwrap()));
        for (step, (numbers, fields)) in alone.iter().enumerate() {
            let different = |found: &[Bits; 2]| (0..numbers.len()).find(|k| found[step].0[*k] != numbers[*k]);
            assert_eq!(each.iter().find_map(different), None, "number that differs: {load:?} on {size}");
            for (place, field) in fields.iter().enumerate() {
                let rows = each.iter().flat_map(|found| &found[step].1[place]);
                assert!(rows.eq(field), "field {place}, {load:?} on {size}");
            }
        }
    }
}

#[test]
fn a_contact_over_ranks_has_the_bits_of_one_process() {
    let (sizes, shapes) = if long() { (&[2, 3, 4, 7][..], 3) } else { (&[3][..], 1) };
    let all = [([256, 256], [1.0, 1.0]), ([512, 1000], [1.0, 2.0]), ([1024, 512], [2.0, 1.0])];
    for (points, lengths) in all.into_iter().take(shapes) {
        let grid = Grid::new(points, lengths).unwrap();
        for body in [half_space(), slab(0.1)] {
            let contact = Case::new(grid, &body, 1);
            let approach = 0.5 * contact.alone().surface().mean_clearance();
            for size in sizes.iter().copied().filter(|size| *size <= Share::most(points, 1)) {
                compare(&contact, Load::MeanPressure(0.002), Solver::Auto, size);
                // Few enough points touch for the search on few points.
                compare(&contact, Load::MeanPressure(3e-5), Solver::Auto, size);
            }
            compare(&contact, Load::Approach(approach), Solver::Auto, 2);
        }
    }
}

#[test]
fn a_contact_of_few_points_over_ranks_has_the_bits_of_one_process() {
    let case = Case::new(Grid::square(512, 1.0).unwrap(), &half_space(), 5);
    let mean = Load::MeanPressure(0.001);
    let approach = case.alone().equilibrate(mean.into(), Solver::Auto, &Budget::default(), None, &mut ()).unwrap();
    assert!(approach.effort.transform_pairs < 10.0, "the search is for few points");
    for size in [2, 3, 4] {
        compare(&case, mean, Solver::Auto, size);
    }
    compare(&case, Load::Approach(approach.approach), Solver::Auto, 3);
}

#[test]
fn a_patch_over_ranks_has_the_bits_of_one_process() {
    let (sizes, shapes) = if long() { (&[2, 3, 4][..], 3) } else { (&[2, 3, 4][..], 1) };
    // Seven units of rows, and uneven rows beside a padded length with a factor of 5.
    let all = [([112, 128], [1.0, 1.2]), ([300, 176], [2.0, 1.0]), ([512, 1000], [1.0, 2.0])];
    for (points, lengths) in all.into_iter().take(shapes) {
        let grid = Grid::new(points, lengths).unwrap();
        for body in [half_space(), slab(0.1)] {
            let case = Case::new(grid, &body, 1).free();
            let approach = 0.5 * case.alone().surface().mean_clearance();
            for size in sizes.iter().copied().filter(|size| *size <= Share::most(points, 1)) {
                compare(&case, Load::MeanPressure(0.002), Solver::Auto, size);
            }
            compare(&case, Load::Approach(approach), Solver::Auto, 2);
        }
    }
    let case = Case::new(Grid::square(128, 1e-6).unwrap(), &half_space(), 2).free();
    for solver in [Solver::PolonskyKeer, Solver::ProjectedCg, Solver::PreconditionedCg] {
        compare(&case, Load::MeanPressure(0.005), solver, 3);
    }
    let hardness = Array2::from_shape_fn((128, 128), |(i, j)| 0.05 + 0.01 * ((i + 2 * j) % 5) as f64);
    let hardness = Some(Hardness::Field(hardness));
    compare(&Case { hardness, ..case }, Load::MeanPressure(0.01), Solver::Auto, 3);
}

#[test]
fn levels_that_are_shared_have_the_bits_of_one_process() {
    // Two levels with their own rows, the third gathered.
    let grid = Grid::square(2048, 1.0).unwrap();
    let case = Case::new(grid, &half_space(), 3);
    levels_have_the_bits_of_one_process(&case);
    levels_have_the_bits_of_one_process(&case.free());
}

fn levels_have_the_bits_of_one_process(case: &Case) {
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
    let alone = begin(&case.alone());
    assert!(ThreadRanks::of(3, |ranks| begin(&case.over(ranks))).concat() == alone);
}

#[test]
fn the_other_methods_and_a_hardness_have_the_bits_of_one_process() {
    let grid = Grid::square(128, 1.0).unwrap();
    let case = Case::new(grid, &half_space(), 2);
    for solver in [Solver::PolonskyKeer, Solver::ProjectedCg, Solver::PreconditionedCg] {
        compare(&case, Load::MeanPressure(0.005), solver, 3);
    }
    let field = Array2::from_shape_fn((128, 128), |(i, j)| 0.05 + 0.01 * ((i + 2 * j) % 5) as f64);
    for hardness in [Hardness::Uniform(0.05), Hardness::Field(field)] {
        compare(&Case { hardness: Some(hardness), ..case.clone() }, Load::MeanPressure(0.01), Solver::Auto, 3);
    }
}

#[test]
fn very_small_units_have_the_bits_of_one_process() {
    let grid = Grid::square(128, 1e-6).unwrap();
    let body = Body::half_space(Material::from_contact_modulus(1e11, 0.3).unwrap());
    compare(&Case::new(grid, &body, 4), Load::MeanPressure(2e8), Solver::Auto, 3);
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
        let size = size.min(Share::most([rows, columns], 1));
        compare(&Case::new(grid, &body, seed), Load::MeanPressure(0.005), Solver::Auto, size);
    }
}

/// Stops after a number of iterations.
struct Stop(u64);

impl Watch for Stop {
    fn see(&mut self, now: &Progress) -> std::ops::ControlFlow<()> {
        if now.iteration >= self.0 { std::ops::ControlFlow::Break(()) } else { std::ops::ControlFlow::Continue(()) }
    }
}

#[test]
fn a_process_that_is_interrupted_stops_all_at_the_same_iterate() {
    let grid = Grid::square(128, 1.0).unwrap();
    let case = Case::new(grid, &half_space(), 2);
    let ends = ThreadRanks::of(3, |ranks| {
        let mut watch = Stop(if ranks.rank() == 1 { 4 } else { u64::MAX });
        let load = Load::MeanPressure(0.005).into();
        match case.over(ranks).equilibrate(load, Solver::Auto, &Budget::default(), None, &mut watch) {
            Err(SolveError::Interrupted { state, .. }) => state.effort.iterations,
            other => panic!("{other:?}"),
        }
    });
    assert_eq!(ends, [4; 3]);
}

#[test]
fn what_cannot_be_shared_is_refused_by_all() {
    let grid = Grid::square(64, 1.0).unwrap();
    let share = |size| ThreadRanks::of(size, |ranks| Contact::share(ranks, &grid).err().map(|error| error.to_string()));
    assert_eq!(share(2), [None, None]);
    assert!(share(3).iter().all(|error| error.as_ref().unwrap().contains("3 processes; it must be at most 2")));
    let case = Case::new(grid, &half_space(), 2);
    ThreadRanks::of(2, |ranks| {
        let load = Load::MeanPressure(0.005).into();
        let refused = case.over(ranks).equilibrate(load, Solver::Verlet, &Budget::default(), None, &mut ());
        assert!(matches!(refused, Err(SolveError::Refused(Refusal::Solver { .. }))));
    });
    // A refusal that only one process detects.
    let mut broken = case.clone();
    broken.heights[[40, 3]] = f64::NAN;
    let state = case.alone().press(Load::MeanPressure(0.005)).solve().unwrap();
    ThreadRanks::of(2, |ranks| {
        let share = Contact::share(ranks, &grid).unwrap();
        let own = |field: &Array2<f64>| field.slice(s![share.rows(), ..]).to_owned();
        let refused = Contact::distributed(&share, &case.body, &grid, &own(&broken.heights));
        assert!(matches!(refused, Err(Refusal::Height { index: [40, 3], .. })));
        let contact = Contact::distributed(&share, &case.body, &grid, &own(&case.heights)).unwrap();
        let rows = share.rows().len() - share.ranks().rank();
        let refused = Contact::distributed(&share, &case.body, &grid, &own(&case.heights).slice_move(s![..rows, ..]));
        assert!(matches!(refused, Err(Refusal::Shape { .. })));
        let mut hardness = Array2::from_elem((32, 64), 1.0);
        hardness[[5, 5]] = if share.ranks().rank() == 1 { -1.0 } else { 1.0 };
        let refused = contact.clone().with_hardness(hardness);
        assert!(matches!(refused, Err(Refusal::Hardness { found: -1.0 })));
        let mut start = contact.certify(&own(&state.pressure), Load::MeanPressure(0.005)).unwrap();
        start.pressure[[0, 0]] = if share.ranks().rank() == 1 { f64::NAN } else { 0.0 };
        let load = Load::MeanPressure(0.005).into();
        let refused = contact.equilibrate(load, Solver::Auto, &Budget::default(), Some(&start), &mut ());
        let index = [32, 0];
        assert!(
            matches!(refused, Err(SolveError::Refused(Refusal::StartPressure { index: found, .. })) if found == index)
        );
    });
}
