//! A volume takes the memory of a few planes. The test has its own file, since it counts the memory of the whole
//! process.
#![allow(unsafe_code, reason = "an allocator that counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use gfmd_body::Interior;
use gfmd_field::Grid;
use gfmd_green::{Body, Material};

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

#[test]
fn a_volume_of_many_depths_holds_a_few_planes() {
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
