//! Checkpoints of interfaces and paths: a solve or path continued from one ends with the same bits.

use std::ops::ControlFlow;

use gfmd_contact::{
    Boundary, Budget, Drive, Equilibrium, Fields as _, Load, MemoryCheckpoint, Progress, Resumable, SolveError, Solver,
    Variables as _, Visit, Watch,
};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{Interface, Path, Quasistatic, Refinement, Step};
use gfmd_law::{Exponential, Limit};
use ndarray::Array2;

/// Watcher that saves a checkpoint at one of its calls, or continues from it.
#[derive(Default)]
struct Keeper {
    at: Option<usize>,
    calls: usize,
    kept: MemoryCheckpoint,
    resumes: bool,
}

impl Watch for Keeper {
    fn see(&mut self, _: &Progress) -> ControlFlow<()> {
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

fn surface() -> (Body, Grid, Array2<f64>) {
    let grid = Grid::square(24, 1.0).unwrap();
    let heights = Array2::from_shape_fn((24, 24), |(i, j)| {
        let [x, y] = [i, j].map(|k| std::f64::consts::TAU * k as f64 / 24.0);
        0.006 * (x.cos() + 0.6 * (2.0 * y + 0.3).cos() + 0.4 * (3.0 * x - 2.0 * y + 1.1).cos())
    });
    (Body::half_space(Material::from_contact_modulus(1.0, 0.2).unwrap()), grid, heights)
}

fn interface() -> Interface {
    let (body, grid, heights) = surface();
    Interface::new(&body, &grid, &heights, Exponential::new(1e-4, 3e-3).unwrap()).unwrap()
}

/// Returns the bits of all variables of a state.
fn checkpoint<E: Resumable>(contact: &E, mut state: E::State) -> MemoryCheckpoint {
    let mut checkpoint = MemoryCheckpoint::default();
    contact.keep(&mut state, &mut checkpoint);
    checkpoint
}

#[test]
fn a_law_continues_bit_for_bit() {
    let interface = interface();
    let start = interface.press(Load::MeanPressure(0.02)).solve().unwrap();
    for (solver, load, start) in [
        (Solver::Newton, Load::MeanPressure(0.01), None),
        (Solver::Newton, Load::MeanPressure(-0.001), Some(&start)),
        (Solver::Newton, Load::Approach(0.002), Some(&start)),
        (Solver::Fire2, Load::MeanPressure(0.01), Some(&start)),
    ] {
        let solve = |keeper: &mut Keeper| {
            let budget = Budget { tolerance: 1e-9, max_iterations: 1_000_000 };
            let reached = interface.equilibrate(load.into(), solver, &budget, start, keeper);
            checkpoint(&interface, reached.unwrap_or_else(|error| error.into_state().unwrap()))
        };
        let mut whole = Keeper::default();
        let expected = solve(&mut whole);
        assert!(whole.calls > 2, "{solver}: {} iterations", whole.calls);
        for part in 0..6 {
            let at = part * (whole.calls - 1) / 5;
            let mut first = Keeper { at: Some(at), ..Keeper::default() };
            solve(&mut first);
            first.kept.rewind();
            let mut second = Keeper { kept: first.kept, resumes: true, ..Keeper::default() };
            assert!(solve(&mut second) == expected, "{solver}, {load:?}, checkpoint {at} of {}", whole.calls);
            assert!(second.kept.is_at_end() && second.calls == whole.calls - at);
        }
    }
}

/// Watcher that stops a search at one of its calls, and keeps the last checkpoint before.
#[derive(Default)]
struct Stopper {
    at: Option<usize>,
    calls: usize,
    kept: MemoryCheckpoint,
    recalls: bool,
}

impl Watch for Stopper {
    fn see(&mut self, _: &Progress) -> ControlFlow<()> {
        self.calls += 1;
        if self.at == Some(self.calls) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        self.kept = MemoryCheckpoint::default();
        variables(&mut self.kept);
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        (self.recalls && !self.kept.is_at_end()).then_some(&mut self.kept)
    }
}

#[test]
fn a_law_stopped_anywhere_continues_bit_for_bit() {
    let interface = interface();
    let start = interface.press(Load::MeanPressure(0.02)).solve().unwrap();
    let load = Load::MeanPressure(0.005).into();
    let solve =
        |watch: &mut Stopper| interface.equilibrate(load, Solver::Newton, &Budget::default(), Some(&start), watch);
    let mut whole = Stopper::default();
    let expected = checkpoint(&interface, solve(&mut whole).unwrap());
    let mut without = 0;
    for at in 1..=whole.calls {
        let mut first = Stopper { at: Some(at), ..Stopper::default() };
        assert!(matches!(solve(&mut first), Err(SolveError::Interrupted { .. })), "{at} of {}", whole.calls);
        let mut kept = first.kept;
        without += usize::from(kept == MemoryCheckpoint::default());
        kept.rewind();
        let mut second = Stopper { recalls: kept != MemoryCheckpoint::default(), kept, ..Stopper::default() };
        assert!(checkpoint(&interface, solve(&mut second).unwrap()) == expected, "{at} of {}", whole.calls);
    }
    // The rounds before the search keep none.
    assert!(without > 2 && without < whole.calls, "{without} of {}", whole.calls);
}

#[test]
fn the_gap_determines_the_state() {
    let interface = interface();
    for load in [Load::MeanPressure(0.02), Load::Approach(0.002), Load::MeanPressure(-0.0005)] {
        let state = interface.press(load).solve().unwrap();
        let again = interface.certify(&state.gap, &state.pressure(), load.into()).unwrap();
        assert!(again.residual.worst() < 2e-8, "{load:?}: {:?} from {:?}", again.residual, state.residual);
        assert_eq!(again.contact_fraction, state.contact_fraction);
        assert!((again.approach - state.approach).abs() < 1e-12);
        let moved = &again.displacement - &state.displacement;
        assert!(moved.iter().all(|u| u.abs() < 1e-12));
    }
    assert!(interface.certify(&Array2::zeros((3, 3)), &Array2::zeros((3, 3)), Load::Approach(0.002).into()).is_err());
}

/// Follows a path, and follows it again from the state after each step.
fn continues<P: Quasistatic + Resumable>(problem: &P, drives: &[Drive]) {
    let new = || Path::new(problem, Budget::default(), Refinement::default());
    let follow = |path: &mut Path<P>, drives: &[Drive], kept: &mut Vec<(Step, MemoryCheckpoint)>| {
        for drive in drives {
            let step = path.step(*drive, &mut ()).unwrap();
            let mut checkpoint = MemoryCheckpoint::default();
            path.keep(&mut checkpoint);
            kept.push((step, checkpoint));
        }
    };
    let mut whole = Vec::new();
    follow(&mut new(), drives, &mut whole);
    for done in 1..drives.len() {
        let (_, mut checkpoint) = whole[done - 1].clone();
        checkpoint.rewind();
        let mut path = new();
        path.resume(drives[done - 1], &mut checkpoint).unwrap();
        assert!(checkpoint.is_at_end());
        let mut rest = Vec::new();
        follow(&mut path, &drives[done..], &mut rest);
        assert!(rest == whole[done..], "continued after step {done}");
    }
}

#[test]
fn paths_continue_bit_for_bit() {
    let drives = [0.002, 0.006, 0.003, -0.001, -0.003, 0.004].map(|approach| Load::Approach(approach).into());
    continues(&interface(), &drives);

    let (body, grid, heights) = surface();
    let slide = |x: f64| Drive { load: Load::MeanPressure(0.02), lateral: [x, 0.0], time: 0.0, distance: 0.0 };
    let friction = crate::rubbing(Boundary::Periodic, &body, &grid, &heights, Limit::Coulomb(0.3));
    continues(&friction, &[0.0, 0.0005, 0.002, 0.001, -0.001].map(slide));
    let law = Exponential::new(1e-4, 3e-3).unwrap();
    let all = Interface::in_all_components(&body, &grid, &heights, law).unwrap();
    continues(&all, &[0.0, 0.001, 0.0].map(slide));
}

#[test]
fn a_path_without_a_step_keeps_nothing() {
    let interface = interface();
    let mut checkpoint = MemoryCheckpoint::default();
    Path::new(&interface, Budget::default(), Refinement::default()).keep(&mut checkpoint);
    assert_eq!(checkpoint, MemoryCheckpoint::default());
    let mut effort = gfmd_contact::Effort { iterations: 3, transform_pairs: 0.5 };
    effort.visit(&mut checkpoint);
    assert_ne!(checkpoint, MemoryCheckpoint::default());
}
