//! Pairs of a forward and an inverse transform: this crate with a kernel in between, `ndrustfft` axis by axis, and FFTW
//! if it is installed.
//!
//! `cargo bench -p gfmd-field` prints times and points per second, then ratios of times measured in turn, which are
//! also reliable on a busy machine; below 1 this crate is faster. With `--no-default-features` the transform runs
//! without cache hints.
#![expect(clippy::print_stdout, reason = "the ratios are what it is for")]

#[path = "transform/fftw.rs"]
mod fftw;

use std::time::{Duration, Instant};

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use fftw::Pair;
use gfmd_field::{Grid, Real, Transform, Workspace};
use ndarray::Array2;
use ndrustfft::{Complex, FftHandler, R2cFftHandler, ndfft, ndfft_r2c, ndifft, ndifft_r2c};

const SIZES: [usize; 7] = [64, 128, 256, 512, 1024, 2048, 4096];

struct Ours<T> {
    transform: Transform<T>,
    kernel: Vec<T>,
    field: Vec<T>,
    out: Vec<T>,
    ws: Workspace<T>,
}

impl<T: Real> Ours<T> {
    /// Creates the benchmark. One thread works on the calling thread, several threads on a pool.
    fn new(n: usize, threads: usize) -> Self {
        let grid = Grid::square(n, 1.0).expect("sizes are positive");
        let transform = Transform::new(grid);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        let ws = pool.install(|| transform.workspace());
        let field = field(n).into_iter().map(T::nearest).collect();
        Self { transform, kernel: vec![T::nearest(1.0); grid.spectrum_len()], field, out: vec![T::ZERO; n * n], ws }
    }

    fn run(&mut self) {
        self.transform.convolve(&self.kernel, &self.field, &mut self.out, &mut self.ws).expect("shapes fit");
    }
}

struct AxisByAxis {
    along_x: FftHandler<f64>,
    along_y: R2cFftHandler<f64>,
    field: Array2<f64>,
    half: Array2<Complex<f64>>,
    full: Array2<Complex<f64>>,
}

impl AxisByAxis {
    fn new(n: usize) -> Self {
        let half = Array2::zeros((n, n / 2 + 1));
        Self {
            along_x: FftHandler::new(n),
            along_y: R2cFftHandler::new(n),
            field: Array2::from_shape_vec((n, n), field(n)).expect("n² values"),
            full: half.clone(),
            half,
        }
    }

    fn run(&mut self) {
        ndfft_r2c(&self.field, &mut self.half, &self.along_y, 1);
        ndfft(&self.half, &mut self.full, &self.along_x, 0);
        ndifft(&self.full, &mut self.half, &self.along_x, 0);
        ndifft_r2c(&self.half, &mut self.field, &self.along_y, 1);
    }
}

fn field(n: usize) -> Vec<f64> {
    (0..n * n).map(|i| (0.618_034 * i as f64).fract()).collect()
}

/// Returns the numbers of threads: one, and all.
fn threads() -> Vec<usize> {
    let all = std::thread::available_parallelism().map_or(1, usize::from);
    if all > 1 { vec![1, all] } else { vec![1] }
}

fn times(criterion: &mut Criterion) {
    for threads in threads() {
        let mut group = criterion.benchmark_group(format!("pair, {threads} threads"));
        group.sample_size(10).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1));
        for n in SIZES {
            group.throughput(Throughput::Elements((n * n) as u64));
            let mut ours = Ours::<f64>::new(n, threads);
            group.bench_function(BenchmarkId::new("ours", n), |bench| bench.iter(|| ours.run()));
            let mut single = Ours::<f32>::new(n, threads);
            group.bench_function(BenchmarkId::new("ours, f32", n), |bench| bench.iter(|| single.run()));
            if threads == 1 {
                let mut other = AxisByAxis::new(n);
                group.bench_function(BenchmarkId::new("ndrustfft", n), |bench| bench.iter(|| other.run()));
            }
            if let Some(mut other) = Pair::new([n, n], threads) {
                group.bench_function(BenchmarkId::new("fftw", n), |bench| bench.iter(|| other.run()));
            }
        }
    }
}

/// Returns the median time of each function in seconds; all functions run in turn.
fn in_turn<const K: usize>(n: usize, mut runs: [&mut dyn FnMut(); K]) -> [f64; K] {
    let repeats = ((1 << 21) / (n * n)).clamp(1, 200);
    let mut seconds = [const { Vec::new() }; K];
    for _ in 0..15 {
        for (run, seconds) in runs.iter_mut().zip(&mut seconds) {
            let start = Instant::now();
            (0..repeats).for_each(|_| run());
            seconds.push(start.elapsed().as_secs_f64() / repeats as f64);
        }
    }
    seconds.map(|mut seconds| {
        seconds.sort_by(f64::total_cmp);
        seconds[seconds.len() / 2]
    })
}

fn ratios(_: &mut Criterion) {
    println!("threads     n   ours, ms   ours/FFTW   ours/ndrustfft on one thread   f32/f64");
    for threads in threads() {
        for n in SIZES {
            let (mut ours, mut other, mut pair) =
                (Ours::<f64>::new(n, threads), AxisByAxis::new(n), Pair::new([n, n], threads));
            let mut single = Ours::<f32>::new(n, threads);
            let present = pair.is_some();
            let mut fftw = || pair.iter_mut().for_each(Pair::run);
            let [a, b, c, d] = in_turn(n, [&mut || ours.run(), &mut || other.run(), &mut fftw, &mut || single.run()]);
            let to_fftw = if present { format!("{:.2}", a / c) } else { "-".into() };
            println!("{threads:7} {n:5} {:10.3} {to_fftw:>11} {:16.2} {:23.2}", 1e3 * a, a / b, d / a);
        }
    }
}

criterion_group!(benches, times, ratios);
criterion_main!(benches);
