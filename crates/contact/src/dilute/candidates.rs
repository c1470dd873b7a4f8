//! The problem on blocks of candidate points.

use std::borrow::Cow;

use gfmd_field::{Rows, Split};
use gfmd_relax::{Ending, Preconditioned, Visit};
use gfmd_response::{Blocks, LANES, Scattered, ScatteredMemory};
use gfmd_vector::{lower, pass_by};
use rayon::prelude::*;

use super::overlap::Overlap;
use super::points::{at_points, few_blocks, gathered, own_blocks};
use crate::Contact;
use crate::attempt::{Attempt, Ended};
use crate::compliance::Compliance;

/// The part of the deepest penetration below which a gap makes a point part of the search.
const NEARLY: f64 = 0.25;

/// The number of variables that are handed on together.
const STRETCH: usize = 32 * LANES;

/// The search for the pressure on some blocks. Every process knows the pressure on all of them, and searches for itself; the
/// displacement of the whole surface is computed by all together, each for its own rows.
pub(super) struct Candidates<'a> {
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
    /// 1 for the points that were free in the last preconditioning, and its image by the stiffness.
    free: Vec<f32>,
    constant: Vec<f32>,
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

impl<'a> Candidates<'a> {
    /// The problem on the blocks at these `places`, with the approach so far, for a start of the own rows; also the start for the points
    /// of the blocks. `None` if it takes longer than that of the whole surface.
    pub(super) fn new(
        attempt: &Attempt<'a>,
        scattered: Scattered,
        (places, approach): (Vec<usize>, f64),
        overlap: Overlap,
    ) -> Option<(Self, Vec<f64>)> {
        let contact = attempt.contact;
        let blocks = few_blocks(&scattered, contact.response.grid(), places)?;
        let mut problem = Self {
            contact,
            compliance: contact.table(contact.level_under(attempt.load)),
            transforms: Compliance::of(contact),
            memory: scattered.memory(),
            scattered,
            blocks,
            approach,
            linear: Vec::new(),
            displacement: vec![0.0; contact.share.own().len()],
            known: Known::Roughly,
            images: 0,
            lanes: Vec::new(),
            pressure: Vec::new(),
            image: Vec::new(),
            free: Vec::new(),
            constant: Vec::new(),
        };
        problem.allocate();
        let mut x = match &attempt.start {
            Some(start) => problem.at_points(start),
            None => problem.linear.iter().map(|c| overlap.pressure(c + approach)).collect(),
        };
        x.resize(problem.linear.len(), 0.0);
        Some((problem, x))
    }

    /// The places of the blocks with points that overlap, or touch at the start.
    pub(super) fn places(attempt: &Attempt, overlap: Overlap) -> Vec<usize> {
        let Contact { scaled, share, .. } = attempt.contact;
        let (clearance, start) = (scaled.clearance(), attempt.start.as_deref());
        let touches = |block: &usize| {
            let points = block * LANES..(block + 1) * LANES;
            let starts = |start: &[f64]| start[points.clone()].iter().any(|p| *p > 0.0);
            clearance[points.clone()].iter().any(|c| *c < overlap.depth) || start.is_some_and(starts)
        };
        let first = share.own().start / LANES;
        let own = (0..clearance.len() / LANES).into_par_iter().filter(touches).map(|block| first + block);
        gathered(share, &own.collect::<Vec<_>>())
    }

    /// The places of the blocks, and the approach so far.
    pub(super) fn state(&self) -> (Vec<usize>, f64) {
        (self.blocks.places().to_vec(), self.approach)
    }

    /// The values at the points of the blocks, of which `own` are those of the own rows.
    fn at_points(&self, own: &[f64]) -> Vec<f64> {
        at_points(&self.blocks, &self.contact.share, own)
    }

    /// Allocates the vectors for the present blocks.
    fn allocate(&mut self) {
        self.lower(0.0);
        let variables = self.linear.len();
        self.lanes = vec![0.0; variables];
        for vector in [&mut self.pressure, &mut self.image, &mut self.free, &mut self.constant] {
            *vector = vec![0.0; variables];
        }
    }

    /// Lowers the surface. Behind the points of the blocks come some, up to a whole stretch, that are far from contact.
    pub(super) fn lower(&mut self, by: f64) {
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
    pub(super) fn survey(&mut self, x: &[f64], margin: f64) -> (f64, Vec<usize>) {
        self.displace(x);
        let Self { contact, approach, blocks, displacement, .. } = self;
        let Contact { scaled, share, .. } = contact;
        let clearance = scaled.clearance();
        let (width, before) = (share.columns() / LANES, share.own().start / LANES);
        let lowest = |place: usize| {
            let points = (place - before) * LANES..(place - before + 1) * LANES;
            let gaps = clearance[points.clone()].iter().zip(&displacement[points]).map(|(c, u)| c + u - *approach);
            gaps.fold(f64::INFINITY, lower)
        };
        let others = |row: usize| {
            let mut own = blocks.places()[blocks.in_row(row)].iter().peekable();
            (row * width..(row + 1) * width).filter(move |place| own.next_if_eq(&place).is_none())
        };
        let rows = share.rows().into_par_iter();
        let gaps = rows.clone().map(|row| others(row).map(lowest).fold(f64::INFINITY, lower));
        let least = share.each(gaps.reduce(|| f64::INFINITY, lower)).into_iter().fold(f64::INFINITY, lower);
        let margin = margin.max(-NEARLY * least);
        let found = rows.flat_map_iter(|row| others(row).filter(|place| lowest(*place) < margin));
        (-least, gathered(share, &found.collect::<Vec<_>>()))
    }

    /// Adds blocks, unless they become too many: then false.
    pub(super) fn widen(&mut self, found: &[usize], x: &mut Vec<f64>) -> bool {
        let old: Vec<(usize, [f64; LANES])> =
            self.blocks.places().iter().copied().zip(x.as_chunks().0.iter().copied()).collect();
        let new = found.iter().map(|place| (*place, [0.0; LANES]));
        let mut all: Vec<(usize, [f64; LANES])> = old.into_iter().chain(new).collect();
        all.sort_unstable_by_key(|(place, _)| *place);
        let (places, values): (Vec<_>, Vec<_>) = all.into_iter().unzip();
        let Some(blocks) = few_blocks(&self.scattered, self.contact.response.grid(), places) else { return false };
        self.blocks = blocks;
        self.allocate();
        *x = values.concat();
        x.resize(self.linear.len(), 0.0);
        true
    }

    pub(super) fn ended(&self, attempt: &Attempt, x: &[f64], ending: Ending) -> Ended {
        let share = &self.contact.share;
        let mut pressure = vec![0.0; share.own().len()];
        for (values, row) in own_blocks(&self.blocks, share) {
            pressure[row].copy_from_slice(&x[values]);
        }
        let mut effort = attempt.effort;
        effort.transform_pairs += self.transforms.pairs() + self.images as f64 * self.scattered.effort();
        Ended { pressure, effort, ending }
    }
}

impl Preconditioned for Candidates<'_> {
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
        let Self { scattered, blocks, pressure, free, constant, .. } = self;
        let fill = |values: &mut [f32], of: &dyn Fn(f32) -> f32| {
            for (value, (x, g)) in values.iter_mut().zip(x.iter().zip(gradient)) {
                *value = if (*x > 0.0) | (*g < level) { of(*g) } else { 0.0 };
            }
        };
        fill(pressure, &|g| g - level);
        scattered.stiffness(blocks, pressure, out);
        fill(pressure, &|_| 1.0);
        if pressure != free {
            free.copy_from_slice(pressure);
            scattered.stiffness(blocks, free, constant);
        }
        let sum = |values: &[f32]| gfmd_vector::dot(values, free);
        let level = (sum(out) / sum(constant)) as f32;
        for ((out, constant), free) in out.iter_mut().zip(&*constant).zip(&*free) {
            *out = if *free > 0.0 { *out - level * constant } else { 0.0 };
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
