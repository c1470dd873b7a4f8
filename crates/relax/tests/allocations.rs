//! Tests that steps do not allocate.
#![allow(unsafe_code, reason = "an allocator that counts")]

use std::{
    alloc::{GlobalAlloc, Layout, System},
    cell::Cell,
};

use gfmd_relax::{Bounds, Fire, Landscape, Method, ModeDamped, Nesterov, Verlet};

thread_local! {
    static ALLOCATIONS: Cell<u64> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: passes every call unchanged to the system allocator. The counter is a thread-local number without destructor
// or allocation.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller upholds the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the pointer comes from `alloc` above, hence from the system allocator.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Springs to the ground below a wall.
struct Springs {
    stiffness: Vec<f64>,
    wall: Vec<f64>,
}

impl Landscape for Springs {
    fn len(&self) -> usize {
        self.wall.len()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        let mut energy = 0.0;
        for ((f, u), k) in force.iter_mut().zip(u).zip(&self.stiffness) {
            *f = 1.0 - k * u;
            energy += 0.5 * k * u * u - u;
        }
        energy
    }

    fn bounds(&self) -> Bounds<'_> {
        Bounds::Upper(&self.wall)
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        self.bounds().natural_residual(u, force, 1.0, 1.0)
    }
}

fn allocations_per_thousand_steps(method: &(impl Method + Sync)) -> u64 {
    let n = 3 * gfmd_vector::LEAF + 5;
    let spread = |i: usize| (0.618_034 * i as f64).fract();
    let stiffness = (0..n).map(|i| 0.1 + 0.9 * spread(i)).collect();
    let wall = (0..n).map(|i| 2.0 + 3.0 * spread(7 * i)).collect();
    let mut problem = Springs { stiffness, wall };
    // All work is done on the one thread that counts allocations.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    pool.install(|| {
        let mut state = method.start(&mut problem, vec![0.0; n]).unwrap();
        let mut steps = |count| {
            for _ in 0..count {
                method.step(&mut problem, &mut state).unwrap();
                assert!(state.status(&problem).residual.is_finite());
            }
        };
        steps(10); // includes the initial allocations of the thread pool
        let before = ALLOCATIONS.get();
        steps(1000);
        ALLOCATIONS.get() - before
    })
}

#[test]
fn steps_do_not_allocate() {
    let before = ALLOCATIONS.get();
    drop(Box::new(1));
    assert!(ALLOCATIONS.get() > before, "the counter counts");
    assert_eq!(allocations_per_thousand_steps(&Verlet::optimal(0.1, 1.0).unwrap()), 0);
    assert_eq!(allocations_per_thousand_steps(&Verlet::critical(0.1, 1.0, 1.2).unwrap().guarded(1.0).unwrap()), 0);
    assert_eq!(allocations_per_thousand_steps(&Fire::bitzek(1.9)), 0);
    assert_eq!(allocations_per_thousand_steps(&Fire::v2(1.9)), 0);
    assert_eq!(allocations_per_thousand_steps(&Nesterov::new(1.0).unwrap()), 0);
    let retain = |motion: &mut [f64]| motion.iter_mut().for_each(|d| *d *= 0.8);
    assert_eq!(allocations_per_thousand_steps(&ModeDamped { tau: 1.0, stiffness_limit: 3.6, retain }), 0);
}
