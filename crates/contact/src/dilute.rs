//! The contact of few points: the pressure is sought on blocks of points where contact is possible, with compliance and stiffness
//! between these points only ([`Scattered`]); all others are checked by transforms of the whole surface (theory.md, section 7).

use std::borrow::Cow;
use std::ops::ControlFlow;

use gfmd_field::{Rows, Split};
use gfmd_relax::{Budget, Ending, Preconditioned, PreconditionedCg, Progress, RelaxError, Target, Visit, Watch, Why};
use gfmd_response::{Blocks, LANES, Scattered, ScatteredMemory};
use gfmd_vector::{Parcel, Share, pass_by};
use rayon::prelude::*;

use crate::attempt::{Attempt, Ended};
use crate::compliance::Compliance;
use crate::dual::MARGIN;
use crate::{Contact, Load};

/// The largest part of the points that may be in blocks.
const MOST: f64 = 0.06;

/// The largest number of pairs of blocks, for each point of the grid.
const PAIRS: f64 = 0.5;

/// The number of points that overlap a rigid plane at the start, for each that is expected to touch.
const OVERLAPPING: f64 = 3.0;

/// The least number of such points.
const LEAST: f64 = 32.0;

/// a_r g E*/p, about.
const KAPPA: f64 = 2.0;

/// The residual at which all points are checked for the first time, over the overlap.
const FIRST: f64 = 1e-2;

/// The factor by which the residual falls until they are checked again.
const STAGE: f64 = 1e-3;

/// The number of iterations in which it should do so.
const PATIENCE: u64 = 60;

/// The part of the deepest penetration below which a gap makes a point part of the search.
const NEARLY: f64 = 0.25;

/// The number of variables that are handed on together.
const STRETCH: usize = 32 * LANES;

/// The number of bins for the clearances below the mean.
const BINS: usize = 4096;

/// The search for the pressure on some blocks. Every process knows the pressure on all of them, and searches for itself; the
/// displacement of the whole surface is computed by all together, each for its own rows.
struct Dilute<'a> {
    contact: &'a Contact,
    compliance: Cow<'a, [f64]>,
    transforms: Compliance,
    scattered: Scattered,
    memory: ScatteredMemory,
    blocks: Blocks,
    /// The approach, as far as it is known.
    approach: f64,
    /// Clearance less approach.
    linear: Vec<f64>,
    /// The displacement downwards of the own rows, by the pressure that was transformed last.
    displacement: Vec<f64>,
    known: Known,
    /// The number of images between the points.
    images: u64,
    /// The displacement downwards of the points.
    lanes: Vec<f64>,
    pressure: Vec<f32>,
    image: Vec<f32>,
}

/// What is known of the displacement by the present pressure.
#[derive(Clone, Copy, PartialEq)]
enum Known {
    /// Nothing, and an image between the points will do.
    Roughly,
    /// Nothing.
    Nothing,
    /// That of the whole surface.
    Wholly,
    /// It was that of the whole surface when the checkpoint was written from which the search continues.
    Formerly,
}

impl Known {
    /// The number in a checkpoint.
    fn number(self) -> u32 {
        match self {
            Self::Roughly => 0,
            Self::Nothing => 1,
            Self::Wholly | Self::Formerly => 2,
        }
    }
}

/// Watches for all processes, which search for themselves: they stop together.
struct Together<'a, W> {
    share: &'a Share,
    watch: W,
}

impl<W: Watch> Watch for Together<'_, W> {
    fn see(&mut self, now: &Progress) -> ControlFlow<()> {
        let stop = self.watch.see(now).is_break();
        if self.share.any(stop) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn checkpoint(&mut self, variables: &mut dyn FnMut(&mut dyn Visit)) {
        self.watch.checkpoint(variables);
    }

    fn recall(&mut self) -> Option<&mut dyn Visit> {
        self.watch.recall()
    }
}

/// The checkpoint of a search on blocks, before that of the search for their pressure.
#[derive(Default)]
struct Kept {
    tolerance: f64,
    approach: f64,
    places: Vec<usize>,
}

impl Kept {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.numbers(&mut [&mut self.tolerance, &mut self.approach]);
        let mut number = self.places.len() as u64;
        visitor.count(&mut number);
        self.places.resize(number as usize, 0);
        for place in &mut self.places {
            let mut number = *place as u64;
            visitor.count(&mut number);
            *place = number as usize;
        }
    }
}

/// Finds the pressure if little touches. Without success the start of `attempt` is the pressure reached. `outer` visits what the
/// caller changes during the search; `continued` if a checkpoint of this search is to be recalled.
pub(crate) fn solve(
    attempt: &mut Attempt,
    mut outer: impl FnMut(&mut dyn Visit),
    continued: bool,
) -> Result<Option<Ended>, RelaxError> {
    let contact = attempt.contact;
    let mean = match attempt.load {
        Load::MeanPressure(mean) => Some(mean),
        Load::Approach(_) => None,
    };
    let mut kept = Kept::default();
    if let (true, Some(recalled)) = (continued, attempt.watch.recall()) {
        kept.visit(recalled);
    }
    let Some((mut problem, mut x, overlap)) = Dilute::begin(attempt, &kept) else { return Ok(None) };
    let scale = attempt.length_scale();
    let finest = MARGIN * attempt.budget.tolerance;
    if kept.places.is_empty() {
        kept.tolerance = finest.max(FIRST * overlap / scale);
    }
    loop {
        let left = attempt.budget_left();
        let budget = Budget { tolerance: kept.tolerance, max_iterations: left.max_iterations.min(PATIENCE) };
        let points = contact.share.total() as f64 / x.len() as f64;
        let target = Target { mean: mean.map(|mean| mean * points), gradient_scale: scale, budget };
        (kept.approach, kept.places) = (problem.approach, problem.blocks.places().to_vec());
        let minimum = {
            let watch = attempt.onlooker(false, |visitor: &mut dyn Visit| {
                outer(visitor);
                kept.visit(visitor);
            });
            PreconditionedCg.minimise(&mut problem, &mut x, &target, &mut Together { share: &contact.share, watch })?
        };
        attempt.effort.iterations += minimum.reached.iteration;
        if minimum.ending == Ending::Interrupted {
            return Ok(Some(problem.ended(attempt, &x, minimum.ending)));
        }
        if minimum.ending != Ending::Converged {
            break;
        }
        problem.lower(minimum.reached.multiplier);
        let (penetration, found) = problem.survey(&x, kept.tolerance * scale);
        if kept.tolerance == finest && penetration <= finest * scale {
            return Ok(Some(problem.ended(attempt, &x, minimum.ending)));
        }
        kept.tolerance = if STAGE * kept.tolerance < 10.0 * finest { finest } else { STAGE * kept.tolerance };
        if !found.is_empty() && !problem.widen(&found, &mut x) {
            break;
        }
    }
    let ended = problem.ended(attempt, &x, Ending::GaveUp(Why::Iterations));
    (attempt.start, attempt.effort) = (Some(ended.pressure), ended.effort);
    Ok(None)
}

impl<'a> Dilute<'a> {
    /// The problem on the blocks that were `kept`, else on those whose points overlap a rigid plane; its start; and the overlap.
    fn begin(attempt: &Attempt<'a>, kept: &Kept) -> Option<(Self, Vec<f64>, f64)> {
        let contact = attempt.contact;
        let Contact { response, scaled: surface, share, .. } = contact;
        if contact.free.is_some() || contact.hardness.is_some() || surface.mean_clearance() == 0.0 {
            return None;
        }
        let mut compliance = Cow::from(response.compliance());
        let mut uniform = 0.0;
        if let Load::Approach(_) = attempt.load {
            uniform = response.uniform_compliance();
            if response.has_uniform() {
                compliance.to_mut()[0] = uniform;
            }
        }
        let scattered = Scattered::of(response, uniform)?;
        let clearance = surface.clearance();
        let stiffness = response.contact_modulus() * rough_gradient(clearance, share, response.grid().spacing()[1]);
        let (approach, overlap) = match attempt.load {
            Load::MeanPressure(mean) => {
                let part = OVERLAPPING * KAPPA * mean / stiffness;
                (0.0, overlap(clearance, share, surface.mean_clearance(), part)?)
            }
            Load::Approach(approach) => (approach, approach),
        };
        let first = share.own().start / LANES;
        let start = attempt.start.as_deref();
        let touches = |block: &usize| {
            let points = block * LANES..(block + 1) * LANES;
            let starts = |start: &[f64]| start[points.clone()].iter().any(|p| *p > 0.0);
            clearance[points.clone()].iter().any(|c| *c < overlap) || start.is_some_and(starts)
        };
        let places = if kept.places.is_empty() {
            let own = (0..clearance.len() / LANES).into_par_iter().filter(touches).map(|block| first + block);
            gathered(share, &own.collect::<Vec<_>>())
        } else {
            kept.places.clone()
        };
        let blocks = Blocks::new(&scattered, response.grid(), places);
        if blocks.is_empty() || !is_dilute(&blocks, share.total()) {
            return None;
        }
        let mut problem = Self {
            contact,
            compliance,
            transforms: Compliance::of(contact),
            memory: scattered.memory(),
            scattered,
            blocks,
            approach: if kept.places.is_empty() { approach } else { kept.approach },
            linear: Vec::new(),
            displacement: vec![0.0; clearance.len()],
            known: Known::Roughly,
            images: 0,
            lanes: Vec::new(),
            pressure: Vec::new(),
            image: Vec::new(),
        };
        problem.allocate();
        let overlapping = |c: &f64| stiffness * ((overlap - (c + problem.approach)) / overlap).max(0.0);
        let mut x = match start {
            Some(start) => problem.at_points(start),
            None => problem.linear.iter().map(overlapping).collect(),
        };
        x.resize(problem.linear.len(), 0.0);
        Some((problem, x, overlap))
    }

    /// The values at the points of the blocks, of which `own` are those of the own rows.
    fn at_points(&self, own: &[f64]) -> Vec<f64> {
        let share = &self.contact.share;
        let start = share.own().start;
        let places = self.blocks.places().iter().map(|place| place * LANES);
        let here = places.filter(|first| share.own().contains(first)).map(|first| &own[first - start..][..LANES]);
        gathered(share, &here.flatten().copied().collect::<Vec<_>>())
    }

    /// Allocates the vectors for the present blocks.
    fn allocate(&mut self) {
        self.lower(0.0);
        let variables = self.linear.len();
        self.lanes = vec![0.0; variables];
        self.pressure = vec![0.0; variables];
        self.image = vec![0.0; variables];
    }

    /// Lowers the surface. Behind the points of the blocks come some, up to a whole stretch, that are far from contact.
    fn lower(&mut self, by: f64) {
        self.approach += by;
        self.linear = self.at_points(self.contact.scaled.clearance());
        let far = 2.0 * self.linear.iter().fold(self.contact.scaled.mean_clearance(), |far, c| c.max(far));
        self.linear.resize(self.linear.len().next_multiple_of(STRETCH), far);
        self.linear.iter_mut().for_each(|c| *c -= self.approach);
    }

    /// Computes the displacement of the whole surface, if it is not known.
    fn displace(&mut self, x: &[f64]) {
        if self.known == Known::Wholly {
            return;
        }
        let counted = *self.transforms.counter();
        let Self { compliance, transforms, blocks, displacement, contact, .. } = self;
        let (columns, before) = (contact.share.columns(), contact.share.rows().start);
        let copy = |_: usize, row: &mut [f64], Rows(out, _): Rows<&mut [f64]>| out.copy_from_slice(row);
        let source = |i: usize, (): (), row: &mut [f64]| {
            row.fill(0.0);
            for block in blocks.in_row(before + i) {
                let first = blocks.places()[block] * LANES % columns;
                row[first..first + LANES].copy_from_slice(&x[block * LANES..(block + 1) * LANES]);
            }
        };
        transforms.apply_rows(compliance, ((), source), (Rows(&mut displacement[..], columns), copy));
        if self.known == Known::Formerly {
            *self.transforms.counter() = counted;
        }
        self.known = Known::Wholly;
    }

    /// Computes the displacement of the points of the blocks.
    fn displace_points(&mut self, x: &[f64]) {
        if self.known == Known::Roughly {
            let unit = x.iter().fold(0.0, |largest: f64, x| x.max(largest));
            self.pressure.iter_mut().zip(x).for_each(|(p, x)| *p = (x / unit) as f32);
            self.respond();
            let unit = unit * self.scattered.unit();
            self.lanes.iter_mut().zip(&self.image).for_each(|(u, image)| *u = f64::from(*image) * unit);
        } else {
            self.displace(x);
            let points = self.at_points(&self.displacement);
            self.lanes[..points.len()].copy_from_slice(&points);
        }
    }

    /// Computes the image of the pressure at the points of the blocks.
    fn respond(&mut self) {
        self.images += 1;
        let Self { scattered, blocks, memory, pressure, image, .. } = self;
        scattered.compliance(blocks, pressure, memory, image);
    }

    /// The deepest penetration outside of the blocks, and the blocks there whose gaps are below the `margin` or a part of it.
    fn survey(&mut self, x: &[f64], margin: f64) -> (f64, Vec<usize>) {
        self.displace(x);
        let Self { contact, approach, blocks, displacement, .. } = self;
        let Contact { scaled, share, .. } = contact;
        let clearance = scaled.clearance();
        let (width, before) = (share.columns() / LANES, share.own().start / LANES);
        let lowest = |place: usize| {
            let points = (place - before) * LANES..(place - before + 1) * LANES;
            let gaps = clearance[points.clone()].iter().zip(&displacement[points]).map(|(c, u)| c + u - *approach);
            gaps.fold(f64::INFINITY, f64::min)
        };
        let others = |row: usize| {
            let mut own = blocks.places()[blocks.in_row(row)].iter().peekable();
            (row * width..(row + 1) * width).filter(move |place| own.next_if_eq(&place).is_none())
        };
        let rows = share.rows().into_par_iter();
        let gaps = rows.clone().map(|row| others(row).map(lowest).fold(f64::INFINITY, f64::min));
        let least = share.each(gaps.reduce(|| f64::INFINITY, f64::min)).into_iter().fold(f64::INFINITY, f64::min);
        let margin = margin.max(-NEARLY * least);
        let found = rows.flat_map_iter(|row| others(row).filter(|place| lowest(*place) < margin));
        (-least, gathered(share, &found.collect::<Vec<_>>()))
    }

    /// Adds blocks; false if they become too many.
    fn widen(&mut self, found: &[usize], x: &mut Vec<f64>) -> bool {
        let old: Vec<(usize, [f64; LANES])> =
            self.blocks.places().iter().copied().zip(x.as_chunks().0.iter().copied()).collect();
        let new = found.iter().map(|place| (*place, [0.0; LANES]));
        let mut all: Vec<(usize, [f64; LANES])> = old.into_iter().chain(new).collect();
        all.sort_unstable_by_key(|(place, _)| *place);
        let (places, values): (Vec<_>, Vec<_>) = all.into_iter().unzip();
        self.blocks = Blocks::new(&self.scattered, self.contact.response.grid(), places);
        self.allocate();
        *x = values.concat();
        x.resize(self.linear.len(), 0.0);
        is_dilute(&self.blocks, self.contact.share.total())
    }

    fn ended(&self, attempt: &Attempt, x: &[f64], ending: Ending) -> Ended {
        let own = self.contact.share.own();
        let mut pressure = vec![0.0; own.len()];
        for (place, x) in self.blocks.places().iter().zip(x.as_chunks::<LANES>().0) {
            if own.contains(&(place * LANES)) {
                pressure[place * LANES - own.start..][..LANES].copy_from_slice(x);
            }
        }
        let mut effort = attempt.effort;
        effort.transform_pairs += self.transforms.pairs() + self.images as f64 * self.scattered.effort();
        Ended { pressure, effort, ending }
    }
}

/// True if sums over pairs of points take less time than transforms of the whole surface.
fn is_dilute(blocks: &Blocks, points: usize) -> bool {
    (blocks.len() * LANES) as f64 <= MOST * points as f64 && blocks.pairs_near() as f64 <= PAIRS * points as f64
}

/// The values of all processes, of which `own` are the own ones.
fn gathered<T: Copy + Parcel>(share: &Share, own: &[T]) -> Vec<T> {
    if share.is_whole() { own.to_vec() } else { share.collect(own, &share.each(own.len())) }
}

impl Preconditioned for Dilute<'_> {
    fn length(&self) -> usize {
        self.linear.len()
    }

    fn stretch(&self) -> usize {
        STRETCH
    }

    fn unit(&self) -> f64 {
        self.scattered.unit()
    }

    fn gradient<O: Split, R: Send>(
        &mut self,
        x: &[f64],
        output: O,
        sink: impl Fn(&[f64], O) -> R + Sync,
        sums: &mut [R],
    ) {
        self.displace_points(x);
        let rows = (Rows(output, STRETCH), sums, Rows(&self.lanes[..], STRETCH), Rows(&self.linear[..], STRETCH));
        pass_by(
            1,
            rows,
            &|_, (Rows(output, _), sum, Rows(lanes, _), Rows(linear, _))| {
                let mut row = [0.0; STRETCH];
                row.iter_mut().zip(lanes.iter().zip(linear)).for_each(|(g, (u, c))| *g = u + c);
                sum[0] = sink(&row, output);
            },
            &|(), ()| (),
        );
    }

    fn image<I: Split>(&mut self, input: I, source: impl Fn(I, &mut [f32]) + Sync) {
        let rows = (Rows(input, STRETCH), Rows(&mut self.pressure[..], STRETCH));
        pass_by(1, rows, &|_, (Rows(input, _), Rows(row, _))| source(input, row), &|(), ()| ());
        self.respond();
        self.known = Known::Nothing;
    }

    fn collect<O: Split, R: Send>(&mut self, output: O, sink: impl Fn(&[f32], O) -> R + Sync, sums: &mut [R]) {
        let rows = (Rows(output, STRETCH), sums, Rows(&self.image[..], STRETCH));
        pass_by(1, rows, &|_, (Rows(output, _), sum, Rows(row, _))| sum[0] = sink(row, output), &|(), ()| ());
    }

    fn curvature(&mut self, direction: &[f32]) -> f64 {
        self.pressure.copy_from_slice(direction);
        self.respond();
        gfmd_vector::dot(&self.pressure, &self.image)
    }

    fn precondition(&mut self, x: &[f64], gradient: &[f32], level: f32, out: &mut [f32]) {
        let free = |x: f64, g: f32| x > 0.0 || g < level;
        let gap = |x: f64, g: f32| if free(x, g) { g - level } else { 0.0 };
        self.pressure.iter_mut().zip(x.iter().zip(gradient)).for_each(|(r, (x, g))| *r = gap(*x, *g));
        self.scattered.stiffness(&self.blocks, &self.pressure, out);
        self.pressure
            .iter_mut()
            .zip(x.iter().zip(gradient))
            .for_each(|(r, (x, g))| *r = f32::from(u8::from(free(*x, *g))));
        self.scattered.stiffness(&self.blocks, &self.pressure, &mut self.image);
        let masked = |out: &[f32]| gfmd_vector::dot(out, &self.pressure);
        let level = (masked(out) / masked(&self.image)) as f32;
        for ((out, image), free) in out.iter_mut().zip(&self.image).zip(&self.pressure) {
            *out = if *free > 0.0 { *out - level * image } else { 0.0 };
        }
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
        visitor.count(&mut self.images);
        let before = self.known.number();
        let mut number = before;
        visitor.small(&mut number);
        if number != before {
            self.known = [Known::Roughly, Known::Nothing, Known::Formerly][number.min(2) as usize];
        }
    }
}

/// The rms gradient along the rows of a sixteenth of them, times √2.
fn rough_gradient(clearance: &[f64], share: &Share, spacing: f64) -> f64 {
    let columns = share.columns();
    let row = |row: &[f64]| row.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>();
    let own = share.rows().zip(clearance.chunks_exact(columns)).filter(|(number, _)| number.is_multiple_of(16));
    let squares = gathered(share, &own.map(|(_, values)| row(values)).collect::<Vec<_>>());
    let count = (squares.len() * (columns - 1)) as f64;
    (2.0 * squares.iter().sum::<f64>() / count).sqrt() / spacing
}

/// The clearance below which lies this part of the points, or a few of them; `None` if it is too large a part.
fn overlap(clearance: &[f64], share: &Share, mean: f64, part: f64) -> Option<f64> {
    let asked = (part * share.total() as f64).max(LEAST);
    // Blocks have more points than those that overlap, twice as many at least.
    let possible = asked <= 0.5 * MOST * share.total() as f64;
    if !possible {
        return None;
    }
    let scale = BINS as f64 / mean;
    let counts = clearance.par_chunks(1 << 16).map(|clearance| {
        let mut counts = vec![0_u64; BINS];
        for c in clearance {
            if let Some(count) = counts.get_mut((c * scale) as usize) {
                *count += 1;
            }
        }
        counts
    });
    let add = |mut a: Vec<u64>, b: Vec<u64>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    let counts = gathered(share, &counts.reduce(|| vec![0; BINS], add));
    let mut below = 0;
    let bin = (0..BINS).find(|bin| {
        below += counts[*bin..].iter().step_by(BINS).sum::<u64>();
        below as f64 >= asked
    })?;
    Some((bin + 1) as f64 / scale)
}
