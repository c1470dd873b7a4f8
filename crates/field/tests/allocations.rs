//! Calls allocate nothing. The test has its own file, since it counts the allocations of the whole process.
#![allow(unsafe_code, reason = "an allocator that counts")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use gfmd_field::{Grid, Transform};
use num_complex::Complex64;

struct Counting;

static BYTES: AtomicUsize = AtomicUsize::new(0);

// SAFETY: every call goes to the system allocator; counting touches no memory of its callers.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        BYTES.fetch_add(layout.size(), Relaxed);
        // SAFETY: the caller keeps the contract of `alloc`.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller keeps the contract of `dealloc`.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Returns the smallest number of bytes allocated in one round of all calls, over several rounds after a first one.
/// With several threads, rayon sometimes allocates a queue; an allocation in this crate would occur in every round.
fn allocated(points: [usize; 2]) -> usize {
    let grid = Grid::new(points, [1.0, 1.0]).unwrap();
    let transform = Transform::new(grid);
    let mut ws = transform.workspace();
    let kernel = vec![1.0; grid.spectrum_len()];
    let field = vec![1.0; grid.len()];
    let mut out = vec![0.0; grid.len()];
    let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
    let mut round = || {
        transform.convolve(&kernel, &field, &mut out, &mut ws).unwrap();
        transform.forward(&field, &mut spectrum, &mut ws).unwrap();
        transform.inverse(&spectrum, &mut out, &mut ws).unwrap();
        transform.quadratic_form(&kernel, &field, &mut ws).unwrap();
    };
    round();
    let counted = (0..5).map(|_| {
        let before = BYTES.load(Relaxed);
        round();
        BYTES.load(Relaxed) - before
    });
    counted.min().unwrap()
}

#[test]
fn calls_allocate_nothing() {
    let grids = [[256, 256], [250, 243], [127, 128], [4096, 1], [1, 2187], [3, 3]];
    for threads in [1, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        for points in grids {
            assert_eq!(pool.install(|| allocated(points)), 0, "{points:?} on {threads}");
        }
    }
}
