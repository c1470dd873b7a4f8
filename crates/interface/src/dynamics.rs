//! Damped dynamics: slow, but needs only the force and no energy. The time step follows from the stiffest mode of the
//! body and the stiffness of the law (theory.md, section 8).

use gfmd_relax::{
    Bounds, Budget, Ending, Fire, InnerWatch, Landscape, Method as _, RelaxError, Visit, Watch, Why, relax_until,
};
use gfmd_response::Transforms;
use gfmd_vector::{for_each, sum, total};

use crate::certify::certify;
use crate::frame::Frame;
use crate::numbers::mean;
use crate::search_result::{End, SearchResult};
use crate::{Interface, State};

/// Maximum number of runs. A run that diverges or goes uphill for too long is repeated with half its time step.
const ATTEMPTS: u64 = 8;

/// Relaxes by `engine`, which creates a version of FIRE from its largest time step.
pub(crate) fn relax_to_rest(
    interface: &Interface,
    frame: &Frame,
    engine: fn(f64) -> Fire,
    budget: &Budget,
    start: Option<&State>,
    watch: &mut dyn Watch,
) -> Result<SearchResult, RelaxError> {
    let mut position = frame.starting_position(&interface.elastic, start);
    let [softest, stiffest] = interface.elastic.stiffness_range();
    let lowest = (0..frame.points()).map(|i| frame.separation(&position, i).0).fold(0.0, f64::min);
    let bounds = interface.law.has_wall().then(|| {
        let open = frame.z() * frame.points();
        std::iter::repeat_n(f64::INFINITY, open).chain(frame.wall()).collect()
    });
    let scale = softest * interface.length_scale();
    let mut motion = Motion { interface, frame, transforms: interface.elastic.transforms(), bounds, scale };
    motion.hold_means(&mut position);
    let mut stiffness = stiffest + interface.law.stiffness_bound(lowest);
    let (mut iterations, mut ending) = (0, Ending::GaveUp(Why::Unsettled));
    let mut attempt = 0;
    if let Some(kept) = watch.recall() {
        kept.count(&mut attempt);
        kept.count(&mut iterations);
        kept.number(&mut stiffness);
    }
    while attempt < ATTEMPTS {
        let method = engine(Fire::largest_dt(stiffness));
        let mut state = method.start(&mut motion, position.clone())?;
        let left = Budget { max_iterations: budget.max_iterations.saturating_sub(iterations), ..*budget };
        let run = relax_until(
            &mut motion,
            &method,
            &mut state,
            &left,
            &mut |_, state| certify(interface, frame, &state.u, &[]).residual.worst(),
            &mut InnerWatch {
                before: iterations,
                outer: |visitor: &mut dyn Visit| {
                    visitor.count(&mut attempt);
                    visitor.count(&mut iterations);
                    visitor.number(&mut stiffness);
                },
                hides_layer: false,
                watch: &mut *watch,
            },
        )?;
        iterations += state.step;
        if let Ending::Converged | Ending::Interrupted | Ending::GaveUp(Why::Iterations | Why::Rounding) = run {
            (position, ending) = (state.u, run);
            break;
        }
        stiffness *= 4.0;
        attempt += 1;
    }
    Ok(SearchResult {
        position,
        inset: Vec::new(),
        iterations,
        transform_pairs: motion.transforms.pairs(),
        passed_instability: false,
        lowest_curvature: f64::NAN,
        end: End::Finished(ending),
    })
}

struct Motion<'a> {
    interface: &'a Interface,
    frame: &'a Frame<'a>,
    transforms: Transforms,
    bounds: Option<Vec<f64>>,
    /// Unit of force in the residual.
    scale: f64,
}

impl Motion<'_> {
    fn hold_means(&self, field: &mut [f64]) {
        let points = self.frame.points();
        for (field, _) in field.chunks_exact_mut(points).zip(&self.frame.held).filter(|(_, held)| **held) {
            let mean = mean(field);
            for_each([field], &|_, [field]| field.iter_mut().for_each(|f| *f -= mean));
        }
    }
}

impl Landscape for Motion<'_> {
    fn len(&self) -> usize {
        self.frame.components() * self.frame.points()
    }

    fn force(&mut self, u: &[f64], force: &mut [f64]) -> f64 {
        let Self { interface, frame, transforms, .. } = self;
        let (points, z) = (frame.points(), frame.z());
        transforms.stiffness(u, &frame.uniform_stiffness, force);
        let elastic = 0.5 * gfmd_vector::dot(u, force);
        for (c, force) in force.chunks_exact_mut(points).enumerate() {
            let (axis, push) = (if c == z { 2 } else { c }, frame.push_on(c));
            let net = |start: usize, [force]: [&mut [f64]; 1]| {
                for (k, f) in force.iter_mut().enumerate() {
                    let (normal, sliding) = frame.separation(u, start + k);
                    *f = interface.law.traction(normal, sliding)[axis] + push - *f;
                }
            };
            for_each([force], &net);
        }
        let law = sum(points, &|range| range.map(|i| interface.law.opening_energy(frame.separation(u, i).0)).sum());
        let work: f64 = frame.push * total(&u[z * points..][..points]);
        self.hold_means(force);
        // If the law has no potential, this is not an energy, only a monitor for divergence.
        elastic + law - work
    }

    fn bounds(&self) -> Bounds<'_> {
        self.bounds.as_deref().map_or(Bounds::Free, Bounds::Upper)
    }

    fn residual(&self, u: &[f64], force: &[f64]) -> f64 {
        self.bounds().natural_residual(u, force, self.scale, self.interface.length_scale())
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
    }
}
