//! FFTW 3 for comparison, loaded at run time if it is installed and never linked.
#![allow(unsafe_code, reason = "calls of a C library")]

use std::ffi::{c_int, c_uint, c_void};
use std::sync::OnceLock;

use libloading::Library;
use num_complex::Complex64;

type Plan = *mut c_void;

/// Measured out-of-place plans for fields of nx rows of ny points, and their arrays.
pub(crate) struct Pair {
    plans: [Plan; 2],
    field: *mut f64,
    half: *mut Complex64,
    execute: unsafe extern "C" fn(Plan),
    destroy: unsafe extern "C" fn(Plan),
    free: unsafe extern "C" fn(*mut c_void),
}

impl Pair {
    /// Returns `None` if FFTW or its thread library is missing.
    pub(crate) fn new([nx, ny]: [usize; 2], threads: usize) -> Option<Self> {
        let sizes = [c_int::try_from(nx).ok()?, c_int::try_from(ny).ok()?];
        const MEASURE: c_uint = 0;
        // SAFETY: names and signatures follow the FFTW manual, section "API Reference"; the arrays have the sizes
        // required in "Real-data DFTs", and no plan is made before threads are set up.
        unsafe {
            let [plain, threaded] = libraries()?;
            function::<unsafe extern "C" fn() -> c_int>(threaded, b"fftw_init_threads")?();
            function::<unsafe extern "C" fn(c_int)>(threaded, b"fftw_plan_with_nthreads")?(threads as c_int);
            let malloc: unsafe extern "C" fn(usize) -> *mut c_void = function(plain, b"fftw_malloc")?;
            let ahead: unsafe extern "C" fn(c_int, c_int, *mut f64, *mut Complex64, c_uint) -> Plan =
                function(plain, b"fftw_plan_dft_r2c_2d")?;
            let back: unsafe extern "C" fn(c_int, c_int, *mut Complex64, *mut f64, c_uint) -> Plan =
                function(plain, b"fftw_plan_dft_c2r_2d")?;
            let execute = function(plain, b"fftw_execute")?;
            let destroy = function(plain, b"fftw_destroy_plan")?;
            let free = function(plain, b"fftw_free")?;

            let field = malloc(nx * ny * size_of::<f64>()).cast::<f64>();
            let half = malloc(nx * (ny / 2 + 1) * size_of::<Complex64>()).cast::<Complex64>();
            let plans =
                [ahead(sizes[0], sizes[1], field, half, MEASURE), back(sizes[0], sizes[1], half, field, MEASURE)];
            assert!(plans.iter().all(|plan| !plan.is_null()), "FFTW plans any size");
            field.write_bytes(0, nx * ny);
            Some(Self { plans, field, half, execute, destroy, free })
        }
    }

    /// Runs an unnormalised forward and inverse transform. The field is zero, since any other would grow without bound.
    pub(crate) fn run(&mut self) {
        for plan in self.plans {
            // SAFETY: the plan and its arrays live as long as `self`.
            unsafe { (self.execute)(plan) }
        }
    }
}

impl Drop for Pair {
    fn drop(&mut self) {
        // SAFETY: FFTW made the plans and arrays; each is freed once and not used again.
        unsafe {
            self.plans.into_iter().for_each(|plan| (self.destroy)(plan));
            (self.free)(self.field.cast());
            (self.free)(self.half.cast());
        }
    }
}

/// Returns the plain library, with its names visible to the thread library, and the thread library. They are never
/// closed, since FFTW threads inside wait for more work.
fn libraries() -> Option<&'static [Library; 2]> {
    static LIBRARIES: OnceLock<Option<[Library; 2]>> = OnceLock::new();
    LIBRARIES.get_or_init(open).as_ref()
}

#[cfg(unix)]
fn open() -> Option<[Library; 2]> {
    use libloading::os::unix::{self, RTLD_GLOBAL, RTLD_NOW};
    // SAFETY: the FFTW libraries run no code when loaded.
    let plain = unsafe { unix::Library::open(Some("libfftw3.so.3"), RTLD_NOW | RTLD_GLOBAL) }.ok()?;
    // SAFETY: as above.
    let threaded = unsafe { Library::new("libfftw3_threads.so.3") }.ok()?;
    Some([plain.into(), threaded])
}

#[cfg(not(unix))]
fn open() -> Option<[Library; 2]> {
    None
}

/// Looks up the function with this name.
///
/// # Safety
/// `F` must be the type of the function.
unsafe fn function<F: Copy>(library: &Library, name: &[u8]) -> Option<F> {
    // SAFETY: promised by the caller.
    unsafe { library.get::<F>(name).ok().map(|symbol| *symbol) }
}
