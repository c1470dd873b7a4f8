//! Tests of checkpoints: a search resumed from any checkpoint gives the same numbers.

use std::ops::ControlFlow;

use gfmd_vector::Split;

use crate::stretches::{hand_on, made};
use gfmd_relax::{
    AugmentedLagrangian, Bounds, Budget, Ending, Fire, Landscape, MemoryCheckpoint, Method, Nesterov, PolonskyKeer,
    Preconditioned, PreconditionedCg, Progress, ProjectedCg, Proximal, Quadratic, Target, Verlet, Visit, Watch,
    relax_until,
};

/// Watcher that keeps the checkpoint of one iteration, or resumes from it, and records all residuals.
#[derive(Default)]
struct Keeper {
    at: Option<usize>,
    kept: MemoryCheckpoint,
    resumes: bool,
    seen: Vec<(u64, u64)>,
    calls: usize,
}

impl Watch for Keeper {
    fn see(&mut self, now: &Progress) -> ControlFlow<()> {
        self.seen.push((now.iteration, now.residual.to_bits()));
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

/// Runs a whole search, then resumes it from several checkpoints. All numbers must be bitwise equal.
fn continues(name: &str, search: impl Fn(&mut dyn Watch) -> (Vec<f64>, u64, Ending)) {
    let mut whole = Keeper::default();
    let result = search(&mut whole);
    assert_eq!(result.2, Ending::Converged, "{name}");
    let count = whole.calls;
    assert!(count > 4, "{name}: {count} iterations test nothing");
    for at in (0..count).step_by(1 + count / 12) {
        let mut first = Keeper { at: Some(at), ..Keeper::default() };
        search(&mut first);
        first.kept.rewind();
        assert!(!first.kept.is_at_end(), "{name}");
        let mut second = Keeper { kept: first.kept, resumes: true, ..Keeper::default() };
        let resumed = search(&mut second);
        assert!(second.kept.is_at_end(), "{name}: variables are left over");
        assert_eq!(second.seen, whole.seen[at..], "{name}, checkpoint {at}");
        assert_eq!(bits(&resumed.0), bits(&result.0), "{name}, checkpoint {at}");
        assert_eq!(resumed.1, result.1, "{name}, checkpoint {at}: the effort");
    }
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|x| x.to_bits()).collect()
}

const N: usize = 60;

/// Matrix 1 + 2 (second differences) + ½ (second differences at distance 7) with a load that presses some entries to
/// zero, and a counter of images.
struct Springs {
    load: Vec<f64>,
    images: u64,
    image: Vec<f32>,
}

impl Springs {
    fn new() -> Self {
        Self {
            load: (0..N).map(|i| -(0.4 + (0.7 * i as f64).sin() + 0.2 * (2.9 * i as f64).cos())).collect(),
            images: 0,
            image: Vec::new(),
        }
    }

    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        self.images += 1;
        Self::product(x, out);
    }

    fn product(x: &[f64], out: &mut [f64]) {
        for i in 0..x.len() {
            let at = |k: Option<usize>| k.and_then(|k| x.get(k)).copied().unwrap_or(0.0);
            out[i] = 6.0 * x[i] - 2.0 * at(i.checked_sub(1)) - 2.0 * at(Some(i + 1)) - 0.5 * at(i.checked_sub(7));
            out[i] -= 0.5 * at(Some(i + 7));
        }
    }
}

impl Quadratic for Springs {
    fn variables(&self) -> usize {
        self.load.len()
    }

    fn gradient(&mut self, x: &[f64], out: &mut [f64]) {
        self.apply(x, out);
        out.iter_mut().zip(&self.load).for_each(|(out, b)| *out += b);
    }

    fn curvature(&mut self, direction: &[f64]) -> f64 {
        let mut image = vec![0.0; direction.len()];
        self.apply(direction, &mut image);
        image.iter().zip(direction).map(|(a, b)| a * b).sum()
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(&mut self.images);
    }
}

impl Preconditioned for Springs {
    fn length(&self) -> usize {
        N
    }

    fn stretch(&self) -> usize {
        N / 4
    }

    fn unit(&self) -> f64 {
        1.0
    }

    fn gradient<O: Split, R: Send>(
        &mut self,
        x: &[f64],
        output: O,
        sink: impl Fn(&[f64], O) -> R + Sync,
        sums: &mut [R],
    ) {
        let mut gradient = vec![0.0; N];
        self.apply(x, &mut gradient);
        gradient.iter_mut().zip(&self.load).for_each(|(g, b)| *g += b);
        hand_on(self.stretch(), &gradient, output, sink, sums);
    }

    fn image<I: Split>(&mut self, input: I, source: impl Fn(I, &mut [f32]) + Sync) {
        let vector = made(self.stretch(), N, input, source);
        let mut image = vec![0.0; N];
        self.apply(&vector, &mut image);
        self.image = image.into_iter().map(|y| y as f32).collect();
    }

    fn collect<O: Split, R: Send>(&mut self, output: O, sink: impl Fn(&[f32], O) -> R + Sync, sums: &mut [R]) {
        hand_on(self.stretch(), &self.image, output, sink, sums);
    }

    fn curvature(&mut self, direction: &[f32]) -> f64 {
        let direction: Vec<f64> = direction.iter().map(|d| f64::from(*d)).collect();
        Quadratic::curvature(self, &direction)
    }

    fn precondition(&mut self, x: &[f64], gradient: &[f32], level: f32, out: &mut [f32]) {
        for ((out, g), x) in out.iter_mut().zip(gradient).zip(x) {
            *out = if *x > 0.0 || *g < level { 0.4 * (g - level) } else { 0.0 };
        }
        let free = out.iter().filter(|z| **z != 0.0).count().max(1) as f32;
        let mean = out.iter().sum::<f32>() / free;
        out.iter_mut().filter(|z| **z != 0.0).for_each(|z| *z -= mean);
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(&mut self.images);
    }
}

#[test]
fn conjugate_gradients_continue_bit_for_bit() {
    let target =
        Target { mean: Some(0.3), gradient_scale: 1.0, budget: Budget { tolerance: 1e-12, max_iterations: 1000 } };
    type Minimise = fn(&mut Springs, &mut [f64], &Target, &mut dyn Watch) -> Ending;
    let methods: [(&str, Minimise); 3] = [
        ("Polonsky-Keer", |p, x, t, w| PolonskyKeer.minimise(p, x, t, w).unwrap().ending),
        ("projected", |p, x, t, w| ProjectedCg.minimise(p, x, t, w).unwrap().ending),
        ("preconditioned", |p, x, t, w| PreconditionedCg.minimise(p, x, t, w).unwrap().ending),
    ];
    for (name, minimise) in methods {
        continues(name, |watch| {
            let (mut springs, mut x) = (Springs::new(), vec![0.3; N]);
            let ending = minimise(&mut springs, &mut x, &target, watch);
            (x, springs.images, ending)
        });
    }
}

/// Springs below a wall.
struct Walled {
    springs: Springs,
    wall: Vec<f64>,
}

impl Walled {
    fn new() -> Self {
        Self { springs: Springs::new(), wall: vec![0.15; N] }
    }
}

impl Landscape for Walled {
    fn len(&self) -> usize {
        N
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        self.springs.apply(u, force);
        let mut energy = 0.0;
        for ((f, u), b) in force.iter_mut().zip(u).zip(&self.springs.load) {
            energy += u * (0.5 * *f + b);
            *f = -*f - b;
        }
        energy
    }

    fn bounds(&self) -> Bounds<'_> {
        Bounds::Upper(&self.wall)
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        Landscape::bounds(self).natural_residual(u, force, 1.0, 1.0)
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(&mut self.springs.images);
    }
}

impl Proximal for Walled {
    fn len(&self) -> usize {
        N
    }

    fn bounds(&self) -> Bounds<'_> {
        Bounds::Upper(&self.wall)
    }

    fn penalty(&self) -> f64 {
        4.0
    }

    /// Makes enough Gauss-Seidel sweeps to converge to the last bit.
    fn settle(&mut self, anchor: &[f64], u: &mut [f64]) {
        self.springs.images += 1;
        u.fill(0.0);
        let mut image = vec![0.0; N];
        for _ in 0..200 {
            Springs::product(u, &mut image);
            for i in 0..N {
                u[i] += (-self.springs.load[i] + 4.0 * anchor[i] - image[i] - 4.0 * u[i]) / 12.0;
            }
        }
    }

    fn residual(&self, mismatch: &[f64]) -> f64 {
        mismatch.iter().fold(0.0, |worst, x| worst.max(x.abs()))
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(&mut self.springs.images);
    }
}

/// Visitor that reads the counter of a problem.
struct Reader<'a>(&'a mut u64);

impl Visit for Reader<'_> {
    fn number(&mut self, _: &mut f64) {}

    fn count(&mut self, n: &mut u64) {
        *self.0 += *n;
    }

    fn field(&mut self, _: &mut [f64]) {}
}

/// Relaxes to a certified residual far below the residual of the method, so that the target is reduced during the run.
fn relax<L: Landscape, M: Method>(mut problem: L, method: &M, watch: &mut dyn Watch) -> (Vec<f64>, u64, Ending) {
    let mut state = method.start(&mut problem, vec![0.0; N]).unwrap();
    let budget = Budget { tolerance: 1e-9, max_iterations: 100_000 };
    let mut certify =
        |problem: &mut L, state: &gfmd_relax::State<M::Memory>| 30.0 * problem.residual(&state.u, &state.force);
    let ending = relax_until(&mut problem, method, &mut state, &budget, &mut certify, watch).unwrap();
    let mut images = 0;
    problem.visit(&mut Reader(&mut images));
    (state.u, state.evaluations + images, ending)
}

#[test]
fn dynamics_continue_bit_for_bit() {
    let [softest, stiffest] = [1.0, 12.0];
    continues("Verlet", |watch| relax(Walled::new(), &Verlet::optimal(softest, stiffest).unwrap(), watch));
    continues("FIRE", |watch| relax(Walled::new(), &Fire::bitzek(Fire::largest_dt(stiffest)), watch));
    continues("FIRE 2.0", |watch| relax(Walled::new(), &Fire::v2(Fire::largest_dt(stiffest)), watch));
    continues("Nesterov", |watch| relax(Walled::new(), &Nesterov::new(stiffest).unwrap(), watch));
    continues("augmented Lagrangian", |watch| {
        relax(AugmentedLagrangian::new(Walled::new()), &Nesterov { tau: 1.2 }, watch)
    });
}
