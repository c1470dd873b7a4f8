//! Problem on blocks of candidate points.

use std::array;
use std::mem::take;

use gfmd_field::{Rows, Split};
use gfmd_relax::{Ending, Preconditioned, Visit};
use gfmd_response::{BlockRows, LANES, Scattered};
use gfmd_vector::{for_each, lower, pass_by, total};
use multiversion::multiversion;
use rayon::prelude::*;

use super::constants::{JOIN_GAP_PER_PENETRATION, MAX_BLOCK_FRACTION, PRECONDITIONER_FACTOR};
use super::overlap::Overlap;
use super::points::{Gaps, Points, are_few, at_points, gathered, of_points, own_blocks};
use crate::attempt::{Attempt, FoundPressure, SolverResult};
use crate::compliance::Compliance;
use crate::{Clearance, Contact, Load};

/// Number of variables that are passed on together.
const STRETCH: usize = 32 * LANES;

/// Results of a check of all points.
pub(super) struct Survey {
    /// Deepest penetration outside the blocks.
    pub(super) penetration: f64,
    /// Deepest penetration of all points.
    pub(super) deepest: f64,
    /// Gap below which a block joins the search.
    margin: f64,
    /// Places of the blocks outside with gaps below the margin.
    found: Vec<usize>,
}

/// Search for the pressure on some blocks. Every process knows the pressure on all blocks and takes the same steps; all
/// together compute the products of the steps and the displacement of the whole surface.
pub(super) struct Candidates<'a> {
    contact: &'a Contact,
    transforms: Compliance,
    points: Points,
    /// Approach, as far as it is known.
    approach: f64,
    /// Clearance minus approach.
    linear: Vec<f64>,
    /// Downward displacement of the own rows under the pressure transformed last, and the least one of each row.
    displacement: Vec<f64>,
    least: Vec<f64>,
    known: Known,
    /// True if the displacement is by exactly the present pressure: the mean was not adjusted since.
    is_exact: bool,
    /// Compliance of the uniform mode, if it takes part in the search, and its displacement.
    level: f64,
    sinking: f64,
    load: Load,
    /// True for a search to the finest tolerance.
    is_finest: bool,
    /// Downward displacement of the points.
    lanes: Vec<f64>,
    pressure: Vec<f32>,
    image: Vec<f32>,
}

/// Known part of the displacement under the present pressure.
#[derive(Clone, Copy, PartialEq)]
enum Known {
    /// Nothing; an image between the points is sufficient.
    Roughly,
    /// Nothing.
    Nothing,
    /// The displacement of the whole surface.
    Wholly,
    /// The displacement of the whole surface was known when the checkpoint to continue from was written.
    Formerly,
}

impl Known {
    /// Returns the number in a checkpoint.
    fn number(self) -> u32 {
        match self {
            Self::Roughly => 0,
            Self::Nothing => 1,
            Self::Wholly | Self::Formerly => 2,
        }
    }
}

impl<'a> Candidates<'a> {
    /// Makes the problem on the blocks at these `places`, with the approach so far. Also returns the start for the
    /// points of the blocks, from the start of the own rows.
    pub(super) fn new(
        attempt: &Attempt<'a>,
        scattered: Scattered,
        (places, approach): (Vec<usize>, f64),
        overlap: Overlap,
    ) -> (Self, Vec<f64>) {
        let contact = attempt.contact;
        let floating = matches!(attempt.load, Load::MeanPressure(_));
        let points = Points::new(contact, scattered, floating, places);
        let mut problem = Self {
            contact,
            level: contact.level_under(attempt.load).map_or(0.0, |[compliance, _]| compliance),
            sinking: 0.0,
            transforms: Compliance::of(contact),
            points,
            approach,
            linear: Vec::new(),
            displacement: Vec::new(),
            least: Vec::new(),
            load: attempt.load,
            is_finest: false,
            known: Known::Roughly,
            is_exact: false,
            lanes: Vec::new(),
            pressure: Vec::new(),
            image: Vec::new(),
        };
        problem.allocate();
        let mut x = match &attempt.start {
            Some(start) => problem.at_points(start),
            None => problem.linear.iter().map(|c| overlap.pressure(c + approach)).collect(),
        };
        x.resize(problem.linear.len(), 0.0);
        (problem, x)
    }

    /// Returns the places of the blocks with points that overlap, or touch at the start.
    pub(super) fn places(attempt: &Attempt, overlap: Overlap) -> Vec<usize> {
        let Contact { scaled, share, .. } = attempt.contact;
        let (clearance, start) = (scaled.clearance(), attempt.start.as_deref());
        let touches = |block: &usize| {
            let points = block * LANES..(block + 1) * LANES;
            let starts = |start: &[f64]| start[points.clone()].iter().any(|p| *p > 0.0);
            clearance.part(points.clone()).iter().any(|c| c < overlap.depth) || start.is_some_and(starts)
        };
        let first = share.own().start / LANES;
        let own = (0..clearance.len() / LANES).into_par_iter().filter(touches).map(|block| first + block);
        gathered(share, own.collect::<Vec<_>>())
    }

    /// Returns the places of the blocks, and the approach so far.
    pub(super) fn state(&self) -> (Vec<usize>, f64) {
        (self.points.blocks().places().to_vec(), self.approach)
    }

    /// Gathers the values at the points of the blocks from the `own` rows.
    fn at_points(&self, own: &[f64]) -> Vec<f64> {
        at_points(self.points.blocks(), &self.contact.share, own)
    }

    /// Allocates the vectors for the present blocks.
    fn allocate(&mut self) {
        self.measure();
        self.release();
        self.reserve();
    }

    /// Frees the vectors that are only needed within an iteration.
    fn release(&mut self) {
        (self.lanes, self.pressure, self.image) = Default::default();
    }

    /// Allocates the vectors that are only needed within an iteration.
    fn reserve(&mut self) {
        let variables = self.linear.len();
        self.lanes = vec![0.0; variables];
        (self.pressure, self.image) = (vec![0.0; variables], vec![0.0; variables]);
    }

    /// Measures the clearance from the approach so far. The points of the blocks are followed by points far from
    /// contact, up to a whole stretch.
    fn measure(&mut self) {
        let Self { contact, approach, .. } = *self;
        let far = 2.0 * (contact.scaled.mean_clearance() + approach.abs());
        self.linear = Vec::new();
        let clearance = contact.scaled.clearance().after(approach);
        let of_block = |block: usize| array::from_fn(|lane| clearance.at(block * LANES + lane));
        let mut linear = of_points(self.points.blocks(), &contact.share, of_block);
        linear.resize(linear.len().next_multiple_of(STRETCH), far - approach);
        self.linear = linear;
    }

    /// Begins a search, to the `finest` tolerance or not.
    pub(super) fn begin(&mut self, finest: bool) {
        (self.is_finest, self.is_exact) = (finest, false);
    }

    /// Computes the displacement of the whole surface, if it is not known.
    fn displace(&mut self, x: &[f64]) {
        if self.known == Known::Wholly {
            return;
        }
        self.displacement.resize(self.contact.share.own().len(), 0.0);
        self.least.resize(self.contact.share.rows().len(), 0.0);
        let counted = *self.transforms.counter();
        let Self { transforms, points, displacement, least, contact, .. } = self;
        let blocks = points.blocks();
        let (columns, rows) = (contact.share.columns(), contact.share.rows());
        let copy = |_: usize, row: &mut [f64], (Rows(out, _), least): (Rows<&mut [f64]>, &mut [f64])| {
            out.copy_from_slice(row);
            least[0] = lowest(row);
        };
        let pressure = blocks.split_rows(&rows, &x[blocks.values_in(&rows)]);
        let source = |i: usize, BlockRows { values, .. }: BlockRows<&[f64]>, row: &mut [f64]| {
            blocks.write_row(rows.start + i, values, row);
        };
        transforms.apply_rows(
            contact.response.compliance(),
            (pressure, source),
            ((Rows(&mut displacement[..], columns), &mut least[..]), copy),
        );
        // Other vectors need the memory.
        transforms.release();
        self.sinking = self.level * total(x) / self.contact.share.total() as f64;
        if self.known == Known::Formerly {
            *self.transforms.counter() = counted;
        } else {
            self.is_exact = true;
        }
        self.known = Known::Wholly;
    }

    /// Computes the displacement of the points of the blocks.
    fn displace_points(&mut self, x: &[f64]) {
        if self.known == Known::Roughly {
            let unit = x.iter().fold(0.0, |largest: f64, x| x.max(largest));
            self.pressure.iter_mut().zip(x).for_each(|(p, x)| *p = (x / unit) as f32);
            self.points.displace(&self.pressure, &mut self.image);
            let unit = unit * self.points.unit();
            self.lanes.iter_mut().zip(&self.image).for_each(|(u, image)| *u = f64::from(*image) * unit);
            return;
        }
        self.displace_exactly(x);
    }

    /// Computes the displacement of the points of the blocks from the displacement of the whole surface.
    fn displace_exactly(&mut self, x: &[f64]) {
        self.displace(x);
        let points = self.at_points(&self.displacement);
        self.lanes.iter_mut().zip(&points).for_each(|(lane, u)| *lane = u + self.sinking);
    }

    /// Lowers the surface until the mean gap of points in contact is zero, unless the approach is prescribed.
    pub(super) fn settle(&mut self, x: &[f64]) {
        self.displace_exactly(x);
        if let Load::MeanPressure(_) = self.load {
            let gaps = self.lanes.iter().zip(&self.linear).map(|(u, c)| u + c);
            let touching = gaps.zip(x).filter(|(_, x)| **x > 0.0);
            let (sum, number) = touching.fold((0.0, 0.0), |(sum, number), (gap, _)| (sum + gap, number + 1.0));
            let lower = sum / number;
            self.approach += lower;
            self.linear.iter_mut().for_each(|c| *c -= lower);
        }
    }

    /// Checks all points. Blocks with gaps below `margin`, or below a fraction of the deepest penetration, join the
    /// search.
    pub(super) fn survey(&self, mut margin: f64) -> Survey {
        let Self { contact, points, displacement, least, .. } = self;
        let approach = self.approach - self.sinking;
        let blocks = points.blocks();
        let Contact { scaled, share, .. } = contact;
        let clearance = scaled.clearance();
        let (width, before) = (share.columns() / LANES, share.own().start / LANES);
        // Lowest gap of a block, or infinity if the clearance and the least displacement of the row alone show that all
        // gaps are above the margin.
        let lowest_gap = |place: usize, margin: f64| {
            let row = (place - before) / width;
            let points = (place - before) * LANES..(place - before + 1) * LANES;
            let clearance = clearance.part(points.clone());
            if lowest_clearance(clearance) + least[row] - approach > margin {
                return f64::INFINITY;
            }
            let gaps = clearance.iter().zip(&displacement[points]).map(|(c, u)| c + u - approach);
            gaps.fold(f64::INFINITY, lower)
        };
        let others = |row: usize| {
            let mut own = blocks.places()[blocks.in_row(row)].iter().peekable();
            (row * width..(row + 1) * width).filter(move |place| own.next_if_eq(&place).is_none())
        };
        // The lowest gap below the margin, and the blocks with gaps below the margin.
        let survey = |margin: f64| {
            let of_row = |row: usize| {
                let mut found = Vec::new();
                let least = others(row).fold(f64::INFINITY, |least, place| {
                    let gap = lowest_gap(place, margin);
                    if gap < margin {
                        found.push(place);
                    }
                    lower(least, gap)
                });
                (least, found)
            };
            let rows: Vec<(f64, Vec<usize>)> = share.rows().into_par_iter().map(of_row).collect();
            let least = rows.iter().map(|(least, _)| *least).fold(f64::INFINITY, lower);
            (least, rows.into_iter().flat_map(|(_, found)| found).collect::<Vec<_>>())
        };
        let (least, mut found) = survey(margin);
        let least = share.each(least).into_iter().fold(f64::INFINITY, lower);
        if -JOIN_GAP_PER_PENETRATION * least > margin {
            margin = -JOIN_GAP_PER_PENETRATION * least;
            found = survey(margin).1;
        }
        let inside = self.lanes.iter().zip(&self.linear).map(|(u, c)| u + c).fold(f64::INFINITY, lower);
        Survey { penetration: -least, deepest: -lower(least, inside), margin, found: gathered(share, found) }
    }

    /// Adds the blocks found. If the set `may_shrink`, removes the blocks without pressure that have gaps above the
    /// margin. Returns false if there are too many blocks.
    pub(super) fn revise(&mut self, survey: &Survey, may_shrink: bool, x: &mut Vec<f64>) -> bool {
        let gaps: Vec<f64> = self.lanes.iter().zip(&self.linear).map(|(u, c)| u + c).collect();
        let places = self.points.blocks().places();
        let values = x.as_chunks::<LANES>().0.iter().zip(gaps.as_chunks::<LANES>().0);
        let is_idle = |(x, gaps): (&[f64; LANES], &[f64; LANES])| {
            may_shrink && x.iter().all(|x| *x == 0.0) && gaps.iter().all(|gap| *gap >= survey.margin)
        };
        let stay = places.iter().zip(values).filter(|(_, values)| !is_idle(*values));
        let mut blocks: Vec<(usize, [f64; LANES])> = stay.map(|(place, (x, _))| (*place, *x)).collect();
        if survey.found.is_empty() && blocks.len() == places.len() {
            self.measure();
            return true;
        }
        // The vectors for the new blocks need the memory.
        self.release();
        self.points.release();
        blocks.extend(survey.found.iter().map(|place| (*place, [0.0; LANES])));
        blocks.sort_unstable_by_key(|(place, _)| *place);
        let (places, values): (Vec<_>, Vec<_>) = blocks.into_iter().unzip();
        if !are_few(&places, MAX_BLOCK_FRACTION, self.contact.share.total()) {
            return false;
        }
        self.points.move_to(self.contact, places);
        self.allocate();
        *x = values.concat();
        x.resize(self.linear.len(), 0.0);
        true
    }

    /// Returns the pressure of the own rows.
    fn whole(&self, x: &[f64]) -> Vec<f64> {
        let share = &self.contact.share;
        let mut pressure = vec![0.0; share.own().len()];
        for (values, row) in own_blocks(self.points.blocks(), share) {
            pressure[row].copy_from_slice(&x[values]);
        }
        pressure
    }

    /// Ends the search at the pressure `x`.
    pub(super) fn ended(mut self, attempt: &Attempt, x: &[f64], ending: Ending) -> SolverResult {
        let mut effort = attempt.effort;
        effort.transform_pairs += self.transforms.pairs() + self.points.pairs();
        let displacement = (self.known == Known::Wholly && self.is_exact).then(|| {
            let mut upwards = take(&mut self.displacement);
            for_each([&mut upwards[..]], &|_, [u]| u.iter_mut().for_each(|u| *u = -*u));
            upwards
        });
        // The fields of the solution need the memory.
        self.release();
        self.points.release();
        (self.linear, self.least) = Default::default();
        SolverResult { reached: FoundPressure { pressure: self.whole(x), displacement }, effort, ending }
    }
}

/// Computes [`gfmd_vector::lowest`] with vector instructions.
#[multiversion(targets = "simd")]
fn lowest(values: &[f64]) -> f64 {
    gfmd_vector::lowest(values)
}

/// Computes the lowest clearance of a block, with vector instructions.
#[multiversion(targets = "simd")]
fn lowest_clearance(block: Clearance) -> f64 {
    let mut values = [f64::INFINITY; LANES];
    values.iter_mut().zip(block.iter()).for_each(|(value, clearance)| *value = clearance);
    gfmd_vector::lowest(&values)
}

impl Preconditioned for Candidates<'_> {
    fn length(&self) -> usize {
        self.linear.len()
    }

    fn stretch(&self) -> usize {
        STRETCH
    }

    fn unit(&self) -> f64 {
        self.points.unit()
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
        self.points.displace(&self.pressure, &mut self.image);
        self.known = Known::Nothing;
    }

    fn collect<O: Split, R: Send>(&mut self, output: O, sink: impl Fn(&[f32], O) -> R + Sync, sums: &mut [R]) {
        let rows = (Rows(output, STRETCH), sums, Rows(&self.image[..], STRETCH));
        pass_by(1, rows, &|_, (Rows(output, _), sum, Rows(row, _))| sum[0] = sink(row, output), &|(), ()| ());
    }

    fn curvature(&mut self, direction: &[f32]) -> f64 {
        self.pressure.copy_from_slice(direction);
        self.points.displace(&self.pressure, &mut self.image);
        gfmd_vector::dot(&self.pressure, &self.image)
    }

    fn precondition(&mut self, x: &[f64], gradient: &[f32], level: f32, out: &mut [f32]) {
        let (x, gradient) = (x.as_chunks::<LANES>().0, gradient.as_chunks::<LANES>().0);
        let gaps = |block: usize| Gaps {
            touches: x[block].map(|x| x > 0.0),
            gap: gradient[block].map(|g| PRECONDITIONER_FACTOR * (g - level)),
        };
        self.points.press(gaps, out);
    }

    fn trusts_images(&self) -> bool {
        !self.is_finest
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
        visitor.count(self.points.counter());
        let before = self.known.number();
        let mut number = before;
        visitor.small(&mut number);
        visitor.flag(&mut self.is_exact);
        if number != before {
            self.known = [Known::Roughly, Known::Nothing, Known::Formerly][number.min(2) as usize];
        }
    }
}
