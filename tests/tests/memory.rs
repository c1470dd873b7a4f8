//! Computations hold a few fields. The tests have their own file, since they count the memory of the whole process.
#![allow(unsafe_code, reason = "an allocator that counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use gfmd_body::Interior;
use gfmd_contact::{Contact, Equilibrium, Load, Stiffness};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_surface::{Discretisation, SelfAffine};

struct Counting;

static HELD: AtomicUsize = AtomicUsize::new(0);
static PEAK: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system allocator; counting touches no memory of its callers.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        PEAK.fetch_max(HELD.fetch_add(layout.size(), Relaxed) + layout.size(), Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size(), Relaxed);
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Held by the test that runs: the tests share one count.
static ALONE: Mutex<()> = Mutex::new(());

#[test]
fn a_volume_of_many_depths_holds_a_few_planes() {
    let _alone = ALONE.lock();
    const POINTS: usize = 256;
    let field = POINTS * POINTS * size_of::<f64>();
    let body = Body::slab(Material::from_young(1.0, 0.3).unwrap(), 1.0).unwrap();
    let surface: Vec<f64> = (0..3 * POINTS * POINTS).map(|i| (i as f64 * 0.618).fract() - 0.5).collect();
    let before = HELD.load(Relaxed);
    PEAK.store(before, Relaxed);
    let interior = Interior::new(&body, Grid::square(POINTS, 1.0).unwrap(), &surface).unwrap();
    let mut ws = interior.workspace();
    let mut energy = 0.0;
    let mut plane = |depth: f64| {
        energy += interior.displacement(depth, &mut ws).unwrap()[0];
        let deformation = interior.deformation(depth, &mut ws).unwrap();
        energy += (0..deformation.len()).map(|i| deformation.at(i).energy_density()).sum::<f64>();
    };
    plane(0.0);
    let peak = PEAK.load(Relaxed) - before;
    assert!(peak < 20 * field, "{} fields", peak as f64 / field as f64);
    (1..12).for_each(|level| plane(f64::from(level) / 12.0));
    // Memory does not grow from depth to depth, except for a small queue that rayon sometimes allocates.
    assert!(PEAK.load(Relaxed) - before < peak + field / 16);
    assert!(energy > 0.0);
}

/// Runs a computation. Returns its result, and its peak of memory beyond `before` in fields of `points`² doubles.
fn peak_of<T>(points: usize, before: usize, computation: impl FnOnce() -> T) -> (T, f64) {
    PEAK.store(HELD.load(Relaxed), Relaxed);
    let result = computation();
    (result, (PEAK.load(Relaxed) - before) as f64 / (8 * points * points) as f64)
}

#[test]
fn a_solution_and_its_stiffness_hold_a_few_fields() {
    let _alone = ALONE.lock();
    const POINTS: usize = 512;
    let grid = Grid::square(POINTS, 1.0).unwrap();
    let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: POINTS as f64 / 8.0, eps_c_inv: 4.0 };
    let surface = SelfAffine { hurst: 0.0, ..SelfAffine::with_rms_gradient(0.1) };
    let before = HELD.load(Relaxed);
    let heights = numbers.self_affine(1.0, surface).heights(&grid, 1).unwrap().into_shared();
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
    // The heights and the compliance are held throughout.
    let contact = Contact::new(&body, &grid, &heights).unwrap();
    for (reduced_pressure, most) in [(1e-3, [4.7, 6.3]), (1e-2, [5.4, 6.8]), (0.2, [6.0, 8.0])] {
        let load = Load::MeanPressure(0.1 * reduced_pressure);
        let (solution, solving) = peak_of(POINTS, before, || contact.press(load).solve().unwrap());
        let (_, stiffening) = peak_of(POINTS, before, || contact.stiffness(&solution, Stiffness::TOLERANCE).unwrap());
        assert!(solving < most[0], "p* {reduced_pressure}: {solving} fields");
        assert!(stiffening < most[1], "p* {reduced_pressure}: {stiffening} fields with the stiffness");
    }
}
