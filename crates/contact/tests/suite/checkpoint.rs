//! Checkpoints of contacts: a solve that continues from one ends with the same bits, as does a series of loads.

use std::ops::ControlFlow;

use gfmd_contact::{
    Budget, Contact, Equilibrium, Load, MemoryCheckpoint, Progress, Resumable, Solution, Solver, Visit, Watch,
};
use gfmd_field::Grid;
use gfmd_green::{Body, Height, Material};
use gfmd_surface::{Discretisation, SelfAffine};

/// Watcher that keeps a checkpoint at one of its calls, or continues from it.
#[derive(Default)]
struct Keeper {
    at: Option<usize>,
    calls: usize,
    kept: MemoryCheckpoint,
    resumes: bool,
    first: Option<u64>,
}

impl Watch for Keeper {
    fn see(&mut self, now: &Progress) -> ControlFlow<()> {
        self.first.get_or_insert(now.iteration);
        ControlFlow::Continue(())
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        if self.at == Some(self.calls) {
            variables(&mut self.kept);
        }
        self.calls += 1;
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        (self.resumes && !self.kept.is_at_end()).then_some(&mut self.kept)
    }
}

fn contact(n: usize, height: Height) -> Contact {
    let grid = Grid::square(n, 1.0).unwrap();
    let numbers = Discretisation { eps_t_inv: 1.0, eps_f_inv: n as f64 / 4.0, eps_c_inv: 4.0 };
    let heights = numbers
        .self_affine(1.0, SelfAffine { hurst: 0.7, ..SelfAffine::with_rms_gradient(0.1) })
        .heights(&grid, 4)
        .unwrap();
    let body = Body::new(Material::from_contact_modulus(1.0, 0.3).unwrap(), height).unwrap();
    Contact::new(&body, &grid, &heights).unwrap()
}

fn same(a: &Solution, b: &Solution) -> bool {
    // Compares every field, the residuals and the effort.
    a == b && a.pressure.iter().zip(&b.pressure).all(|(a, b)| a.to_bits() == b.to_bits())
}

#[test]
fn every_solver_continues_bit_for_bit() {
    for (height, load) in [
        (Height::Infinite, Load::MeanPressure(0.01)),
        (Height::Finite(0.3), Load::Approach(0.01)),
        // The dynamics search for the load of this approach.
        (Height::Infinite, Load::Approach(0.008)),
    ] {
        let contact = contact(24, height);
        for solver in Contact::SOLVERS {
            let solve = |keeper: &mut Keeper| {
                let budget = Budget { tolerance: 1e-9, max_iterations: 1_000_000 };
                contact.equilibrate(load.into(), solver, &budget, None, keeper).unwrap()
            };
            let mut whole = Keeper::default();
            let expected = solve(&mut whole);
            assert!(whole.calls > 3, "{solver}: {} iterations", whole.calls);
            for part in 0..6 {
                let at = part * (whole.calls - 1) / 5;
                let mut first = Keeper { at: Some(at), ..Keeper::default() };
                solve(&mut first);
                first.kept.rewind();
                let mut second = Keeper { kept: first.kept, resumes: true, ..Keeper::default() };
                let resumed = solve(&mut second);
                assert!(second.kept.is_at_end() && second.calls == whole.calls - at, "{solver}, {load:?}, {at}");
                assert!(same(&resumed, &expected), "{solver}, {load:?}, checkpoint {at} of {}", whole.calls);
            }
        }
    }
}

#[test]
fn the_automatic_solver_continues_after_its_change_of_method() {
    // The preconditioned method uses up the iterations, and the next method judges its state.
    let contact = contact(96, Height::Infinite);
    let solve = |keeper: &mut Keeper| {
        let budget = Budget { tolerance: 1e-12, max_iterations: 8 };
        let reached = contact.equilibrate(Load::MeanPressure(0.02).into(), Solver::Auto, &budget, None, keeper);
        reached.unwrap_or_else(|error| error.into_state().unwrap())
    };
    let mut whole = Keeper::default();
    let expected = solve(&mut whole);
    assert_eq!(whole.calls, 9 + 1, "iterations 0 to 8 of the first method, and one look of the second");
    for at in [0, 4, 8, 9] {
        let mut first = Keeper { at: Some(at), ..Keeper::default() };
        solve(&mut first);
        first.kept.rewind();
        let mut second = Keeper { kept: first.kept, resumes: true, ..Keeper::default() };
        assert!(same(&solve(&mut second), &expected), "checkpoint {at}");
        assert_eq!(second.first, Some(at.min(8) as u64), "the iterations before the checkpoint are counted");
        assert_eq!(second.calls, 10 - at);
    }
}

#[test]
fn a_search_on_few_points_continues_bit_for_bit() {
    let contact = contact(256, Height::Infinite);
    for load in [Load::MeanPressure(1e-4), Load::Approach(0.2 * contact.surface().mean_clearance())] {
        let solve = |keeper: &mut Keeper| {
            let budget = Budget { tolerance: 1e-9, max_iterations: 1_000_000 };
            contact.equilibrate(load.into(), Solver::Auto, &budget, None, keeper).unwrap()
        };
        let mut whole = Keeper::default();
        let expected = solve(&mut whole);
        assert!(expected.effort.transform_pairs < 15.0, "{load:?}: {:?}", expected.effort);
        for at in 0..whole.calls {
            let mut first = Keeper { at: Some(at), ..Keeper::default() };
            solve(&mut first);
            first.kept.rewind();
            let mut second = Keeper { kept: first.kept, resumes: true, ..Keeper::default() };
            let resumed = solve(&mut second);
            assert_eq!(resumed.effort, expected.effort, "{load:?}, checkpoint {at}");
            assert!(same(&resumed, &expected), "{load:?}, checkpoint {at}");
            assert!(second.kept.is_at_end() && second.calls == whole.calls - at, "{load:?}, {at}");
        }
    }
}

#[test]
fn all_components_continue_bit_for_bit() {
    let grid = Grid::square(15, 1.0).unwrap();
    let heights = contact(24, Height::Infinite).surface().clearance().part(0..225).to_vec();
    let heights = ndarray::Array2::from_shape_vec((15, 15), heights).unwrap();
    let body = Body::slab(Material::from_contact_modulus(1.0, 0.3).unwrap(), 0.5).unwrap();
    let contact = Contact::in_all_components(&body, &grid, &heights).unwrap();
    let load = Load::MeanPressure(0.01);
    for &solver in contact.solvers() {
        let solve = |keeper: &mut Keeper| {
            let budget = Budget { tolerance: 1e-9, max_iterations: 1_000_000 };
            contact.equilibrate(load.into(), solver, &budget, None, keeper).unwrap()
        };
        let mut whole = Keeper::default();
        let mut expected = solve(&mut whole);
        for at in [0, whole.calls / 2, whole.calls - 1] {
            let mut first = Keeper { at: Some(at), ..Keeper::default() };
            solve(&mut first);
            first.kept.rewind();
            let mut second = Keeper { kept: first.kept, resumes: true, ..Keeper::default() };
            let resumed = solve(&mut second);
            assert!(second.kept.is_at_end() && second.calls == whole.calls - at, "{solver}, {at}");
            assert!(resumed == expected, "{solver}, checkpoint {at} of {}", whole.calls);
        }
        let mut checkpoint = MemoryCheckpoint::default();
        contact.keep(&mut expected, &mut checkpoint);
        checkpoint.rewind();
        assert!(contact.restore(load.into(), &mut checkpoint).unwrap() == expected && checkpoint.is_at_end());
    }
}

#[test]
fn a_state_that_is_kept_is_the_state_of_the_next_load() {
    let contact = contact(24, Height::Infinite);
    let budget = Budget::default();
    let load = Load::MeanPressure(0.01);
    let mut first = contact.press(load).solve().unwrap();
    let mut checkpoint = MemoryCheckpoint::default();
    contact.keep(&mut first, &mut checkpoint);
    checkpoint.rewind();
    let restored = contact.restore(load.into(), &mut checkpoint).unwrap();
    assert!(same(&restored, &first) && checkpoint.is_at_end());
    let next = |start: &Solution| {
        contact.equilibrate(Load::MeanPressure(0.03).into(), Solver::Auto, &budget, Some(start), &mut ()).unwrap()
    };
    assert!(same(&next(&restored), &next(&first)));
    assert!(contact.restore(Load::MeanPressure(-1.0).into(), &mut MemoryCheckpoint::default()).is_err());
}

#[test]
fn a_state_of_another_layout_is_kept_as_it_is() {
    let contact = contact(24, Height::Infinite);
    let load = Load::MeanPressure(0.01);
    let solved = contact.press(load).solve().unwrap();
    let mut turned = solved.clone();
    turned.pressure = solved.pressure.t().as_standard_layout().into_owned().reversed_axes();
    assert!(turned.pressure.as_slice().is_none());
    let mut checkpoint = MemoryCheckpoint::default();
    contact.keep(&mut turned, &mut checkpoint);
    checkpoint.rewind();
    let restored = contact.restore(load.into(), &mut checkpoint).unwrap();
    assert!(checkpoint.is_at_end() && same(&restored, &solved));
}
