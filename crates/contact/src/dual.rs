//! The contact problem in terms of the pressure: minimise ½⟨p, G p⟩ + ⟨p, clearance − approach⟩ over p ≥ 0, or with
//! the mean of p prescribed and the approach as its multiplier (theory.md, section 7).

use std::borrow::Cow;
use std::sync::Arc;

use gfmd_field::{Rows, Share, Split};
use gfmd_relax::{Budget, Ending, PolonskyKeer, PreconditionedCg, ProjectedCg, RelaxError, Target};
use gfmd_relax::{Preconditioned, Quadratic, Upper, Variables, Visit};
use gfmd_vector::{for_each, pass_by};
use multiversion::multiversion;
use rayon::iter::repeat_n;
use rayon::prelude::*;

use crate::attempt::MARGIN;
use crate::attempt::{Attempt, SolverResult};
use crate::compliance::{Compliance, Rounded};
use crate::dilute;
use crate::pull_push::{Edges, Known, PullPush};
use crate::{Clearance, Contact, Load, springs};

/// Methods of conjugate gradients.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Gradients {
    /// Preconditioned, then projected if that takes too long.
    Auto,
    PolonskyKeer,
    Projected,
    Preconditioned,
}

/// Quadratic function minimised by the pressure.
pub(crate) struct Dual<'a> {
    /// Compliance of the periodic modes; unused with free boundaries.
    compliance: Cow<'a, [f64]>,
    /// Linear part of the function: the clearance after a prescribed approach.
    linear: Clearance<'a>,
    /// True if the approach is free, because the mean pressure is prescribed.
    floating: bool,
    /// Hardness, infinite without one.
    upper: Upper,
    /// Number of points in a row.
    row: usize,
    share: Share,
    /// Transforms in double precision. Either these or `rounded` hold memory, not both.
    transforms: Compliance,
    rounded: Rounded,
    extension: PullPush,
    /// Springs that differ between points. The preconditioner ignores them: it then overestimates the inverse.
    springs: Option<PointSprings>,
    /// True while x is a start without displacement.
    is_flat: bool,
}

/// Springs that differ between points, with the memory of their pressures.
struct PointSprings {
    /// Compliance of each point.
    compliance: Arc<[f64]>,
    /// Compliance of each point divided by the unit.
    rounded: Vec<f32>,
    /// Last pressure in double precision; empty before.
    pressure: Vec<f64>,
    /// Vector of the last image; empty before.
    step: Vec<f32>,
}

impl PointSprings {
    fn new(compliance: &Arc<[f64]>, unit: f64) -> Self {
        Self {
            compliance: Arc::clone(compliance),
            rounded: compliance.iter().map(|k| (k / unit) as f32).collect(),
            pressure: Vec::new(),
            step: Vec::new(),
        }
    }
}

/// Adds the shortening of springs in one row.
#[multiversion(targets = "simd")]
fn add_rounded(compliance: &[f32], pressure: &[f32], out: &mut [f32]) {
    out.iter_mut().zip(compliance.iter().zip(pressure)).for_each(|(out, (k, p))| *out += k * p);
}

/// Number of iterations after which [`Solver::Auto`] continues without the preconditioner. Some 30 are usually
/// sufficient (commit ff5ee0e); where the preconditioner is poor, as on incompressible layers thinner than the cell is
/// wide, the method without it is faster.
const PRECONDITIONED_ITERATIONS: u64 = 100;

/// Number of iterations without the preconditioner after which [`Solver::Auto`] returns to it. Chosen: on cells a
/// thousand times longer than wide the method without it may not converge at all.
const PLAIN_ITERATIONS: u64 = 5000;

/// Number of the search on few points in a checkpoint, in place of the number of a part.
const FEW: u32 = 3;

impl<'a> Dual<'a> {
    pub(crate) fn new(contact: &'a Contact, load: Load) -> Self {
        let Contact { response, scaled: surface, share, .. } = contact;
        let linear = match load {
            Load::MeanPressure(_) => surface.clearance(),
            Load::Approach(approach) => surface.clearance().after(approach),
        };
        let level = contact.level_under(load);
        let compliance = contact.table(level.map(|[uniform, _]| uniform));
        let points = response.grid().points();
        let floating = matches!(load, Load::MeanPressure(_));
        let edges = if contact.free.is_some() { Edges::Mirrored } else { Edges::Joined };
        let extension = PullPush::new(points, floating, edges, contact.stiffness_of_waves()).distributed(share);
        let upper = contact.upper();
        let (transforms, rounded) = (Compliance::of(contact), Rounded::of(contact, level));
        let springs = contact.springs.as_ref().map(|springs| PointSprings::new(springs, rounded.unit()));
        let (row, share) = (response.grid().rows()[1], share.clone());
        Self {
            compliance,
            linear,
            floating,
            upper,
            row,
            share,
            transforms,
            rounded,
            extension,
            springs,
            is_flat: false,
        }
    }

    /// Computes (G + D) p of the pressure p, with the compliance D of springs at the points, with rows that `source`
    /// makes from the rows of `input`. `sink` receives the rows of the displacement and of `output`, and its results
    /// are put into `sums`.
    pub(crate) fn displace<I: Split, O: Split, R: Send>(
        &mut self,
        (input, source): (I, impl Fn(I, &mut [f64]) + Sync),
        (output, sink): (O, impl Fn(&mut [f64], O) -> R + Sync),
        sums: &mut [R],
    ) {
        let Self { compliance, row, transforms, rounded, extension, springs, .. } = self;
        rounded.release();
        extension.release();
        let columns = *row;
        let Some(PointSprings { compliance: springs, pressure, .. }) = springs else {
            let input = (Rows(input, columns), |_: usize, Rows(input, _): Rows<I>, row: &mut [f64]| source(input, row));
            let sink =
                |_: usize, row: &mut [f64], (Rows(output, _), sum): (Rows<O>, &mut [R])| sum[0] = sink(row, output);
            transforms.apply_rows(compliance, input, ((Rows(output, columns), sums), sink));
            return transforms.release();
        };
        pressure.resize(springs.len(), 0.0);
        let rows = (Rows(input, columns), Rows(&mut pressure[..], columns));
        pass_by(1, rows, &|_, (Rows(input, _), Rows(row, _))| source(input, row), &|(), ()| ());
        let rows = |values| Rows(values, columns);
        let input = (rows(&pressure[..]), |_: usize, Rows(p, _): Rows<&[f64]>, row: &mut [f64]| row.copy_from_slice(p));
        type Parts<'a, O, R> = (Rows<O>, &'a mut [R], Rows<&'a [f64]>, Rows<&'a [f64]>);
        let sink = |_: usize, row: &mut [f64], (Rows(output, _), sum, Rows(springs, _), Rows(p, _)): Parts<O, R>| {
            springs::add_row(springs, p, row);
            sum[0] = sink(row, output);
        };
        let output = (Rows(output, columns), sums, rows(&springs[..]), rows(&pressure[..]));
        transforms.apply_rows(compliance, input, (output, sink));
        transforms.release();
    }

    /// Computes `out` = Eᵀ K E of the known values, with their extension E: about G⁻¹ of a displacement on the contact,
    /// times [`unit`](Preconditioned::unit), zero elsewhere.
    pub(crate) fn press(&mut self, known: Known, out: &mut [f32]) {
        let Self { floating, rounded, extension, transforms, .. } = self;
        transforms.release();
        extension.prepare(known);
        rounded.stiffness(*floating, |i, row| extension.row(known, i, row), out);
        extension.transpose(known, out);
    }

    /// Returns true if [`press`](Self::press) maps constants to zero, and its pressures have no sum.
    pub(crate) fn keeps_constants(&self) -> bool {
        self.extension.keeps_constants()
    }

    /// Returns the number of transforms so far, in pairs.
    pub(crate) fn pairs(&self) -> f64 {
        self.transforms.pairs() + self.rounded.pairs()
    }

    fn count(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
        visitor.count(self.rounded.counter());
    }
}

impl Quadratic for Dual<'_> {
    fn variables(&self) -> usize {
        self.linear.len()
    }

    fn gradient(&mut self, x: &[f64], out: &mut [f64]) {
        self.transforms.apply(&self.compliance, x, out);
        if let Some(PointSprings { compliance, .. }) = &self.springs {
            springs::add(compliance, x, out);
        }
        for_each((out, self.linear), &|_, (out, linear)| out.iter_mut().zip(linear.iter()).for_each(|(g, b)| *g += b));
    }

    fn share(&self) -> Share {
        self.share.clone()
    }

    fn curvature(&mut self, direction: &[f64]) -> f64 {
        let of_body = self.transforms.quadratic_form(&self.compliance, direction);
        let Some(PointSprings { compliance, .. }) = &self.springs else { return of_body };
        of_body + self.share.sum(&|range| range.map(|i| compliance[i] * direction[i] * direction[i]).sum())
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        self.count(visitor);
    }
}

impl Preconditioned for Dual<'_> {
    fn length(&self) -> usize {
        self.linear.len()
    }

    fn upper(&self) -> Upper {
        self.upper.clone()
    }

    fn share(&self) -> Share {
        self.share.clone()
    }

    fn stretch(&self) -> usize {
        self.row
    }

    fn unit(&self) -> f64 {
        self.rounded.unit()
    }

    fn gradient<O: Split, R: Send>(
        &mut self,
        x: &[f64],
        output: O,
        sink: impl Fn(&[f64], O) -> R + Sync,
        sums: &mut [R],
    ) {
        let linear = self.linear;
        if std::mem::take(&mut self.is_flat) {
            let rows = (Rows(output, self.row), sums, Rows(linear, self.row));
            pass_by(
                1,
                rows,
                &|_, (Rows(output, _), sum, Rows(row, _))| sum[0] = sink(&row.to_vec(), output),
                &|(), ()| (),
            );
        } else {
            let input = (x, |x: &[f64], row: &mut [f64]| row.copy_from_slice(x));
            let with_linear = |row: &mut [f64], (linear, output): (Clearance, O)| {
                row.iter_mut().zip(linear.iter()).for_each(|(g, b)| *g += b);
                sink(row, output)
            };
            self.displace(input, ((linear, output), with_linear), sums);
        }
    }

    fn image<I: Split>(&mut self, input: I, source: impl Fn(I, &mut [f32]) + Sync) {
        let Self { transforms, rounded, row, springs, .. } = self;
        transforms.release();
        match springs {
            None => rounded.compliance(Rows(input, *row), |_, Rows(input, _), row| source(input, row)),
            Some(PointSprings { rounded: springs, step, .. }) => {
                step.resize(springs.len(), 0.0);
                let input = (Rows(input, *row), Rows(&mut step[..], *row));
                rounded.compliance(input, |_, (Rows(input, _), Rows(step, _)), row| {
                    source(input, row);
                    step.copy_from_slice(row);
                });
            }
        }
    }

    fn collect<O: Split, R: Send>(&mut self, output: O, sink: impl Fn(&[f32], O) -> R + Sync, sums: &mut [R]) {
        let Self { rounded, row, springs, .. } = self;
        match springs {
            None => {
                rounded.rows((Rows(output, *row), sums), |_, row, (Rows(output, _), sum)| sum[0] = sink(row, output))
            }
            Some(PointSprings { rounded: springs, step, .. }) => {
                let output = (Rows(output, *row), sums, Rows(&springs[..], *row), Rows(&step[..], *row));
                rounded.rows(output, |_, row, (Rows(output, _), sum, Rows(springs, _), Rows(step, _))| {
                    add_rounded(springs, step, row);
                    sum[0] = sink(row, output);
                });
            }
        }
    }

    fn curvature(&mut self, direction: &[f32]) -> f64 {
        let of_body = self.rounded.quadratic_form(direction);
        let Some(PointSprings { rounded, .. }) = &self.springs else { return of_body };
        let of_point = |i: usize| f64::from(rounded[i]) * f64::from(direction[i]).powi(2);
        of_body + self.share.sum(&|range| range.map(of_point).sum())
    }

    /// Applies Eᵀ K E with E the extension from the contact to the whole surface. The quadratic form of (G on the
    /// contact)⁻¹ is the minimum of ⟨u, K u⟩ over all displacements u with given values on the contact, and E
    /// approximates the u of this minimum.
    fn precondition(&mut self, x: &[f64], gradient: &[f32], level: f32, out: &mut [f32]) {
        let upper = self.upper.clone();
        self.press(Known { x, gradient, level, upper: upper.ceiling() }, out);
    }

    fn mark(&self, blocks: &mut [bool]) -> bool {
        self.extension.mark(blocks)
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        self.count(visitor);
    }
}

pub(crate) fn solve(mut attempt: Attempt, gradients: Gradients) -> Result<SolverResult, RelaxError> {
    let contact = attempt.contact;
    // Part of the search of [`Gradients::Auto`]: preconditioned, without the preconditioner, and preconditioned again.
    // The search on few points comes before them.
    let mut part = 0;
    // Only one method supports a hardness.
    let in_parts = matches!(gradients, Gradients::Auto) && contact.hardness.is_none();
    if in_parts {
        let mut few = FEW;
        let continued = attempt.watch.recall().map(|kept| {
            attempt.effort.visit(kept);
            kept.small(&mut part);
        });
        if continued.is_none() || part == FEW {
            part = 0;
            let outer = |visitor: &mut dyn Visit| visitor.small(&mut few);
            if let Some(ended) = dilute::solve(&mut attempt, outer, continued.is_some())? {
                return Ok(ended);
            }
        }
    }
    let mut dual = Dual::new(contact, attempt.load);
    let mean = attempt.load.mean_pressure();
    let own = contact.share.own().len();
    // Without springs a uniform pressure on a periodic cell has no displacement; under a prescribed approach the
    // pressure starts at zero.
    let is_uniform = contact.free.is_none() && contact.springs.is_none() && matches!(dual.upper, Upper::All(_));
    dual.is_flat = attempt.start.is_none() && (is_uniform || mean.is_none());
    let mut pressure = attempt.start.take().unwrap_or_else(|| repeat_n(mean.unwrap_or(0.0), own).collect());
    let upper = dual.upper();
    if upper.ceiling().is_finite() {
        for_each((&mut pressure[..], upper.ceiling()), &|_, (pressure, upper)| {
            pressure.iter_mut().enumerate().for_each(|(i, p)| *p = p.min(upper.at(i)));
        });
    }
    let x = &mut pressure;
    let within = |budget: Budget| Budget { tolerance: MARGIN * budget.tolerance, ..budget };
    let target = Target { mean, gradient_scale: attempt.length_scale, budget: within(attempt.budget) };
    let minimum = match gradients {
        Gradients::PolonskyKeer => PolonskyKeer.minimise(&mut dual, x, &target, attempt.watch)?,
        Gradients::Projected => ProjectedCg.minimise(&mut dual, x, &target, attempt.watch)?,
        Gradients::Preconditioned => PreconditionedCg.minimise(&mut dual, x, &target, attempt.watch)?,
        Gradients::Auto if !in_parts => PreconditionedCg.minimise(&mut dual, x, &target, attempt.watch)?,
        Gradients::Auto => loop {
            let Budget { tolerance, max_iterations } = attempt.budget_left();
            let limit = [PRECONDITIONED_ITERATIONS, PLAIN_ITERATIONS].get(part as usize).copied().unwrap_or(u64::MAX);
            let budget = within(Budget { tolerance, max_iterations: max_iterations.min(limit) });
            let target = Target { budget, ..target };
            let plain = part == 1;
            let minimum = {
                let mut part_watch = attempt.part_watch(false, |visitor: &mut dyn Visit| visitor.small(&mut part));
                if plain {
                    ProjectedCg.minimise(&mut dual, x, &target, &mut part_watch)?
                } else {
                    PreconditionedCg.minimise(&mut dual, x, &target, &mut part_watch)?
                }
            };
            let is_over = part == 2 || plain && minimum.reached.iteration >= max_iterations;
            if is_over || !matches!(minimum.ending, Ending::GaveUp(_)) {
                break minimum;
            }
            attempt.effort.iterations += minimum.reached.iteration;
            part += 1;
        },
    };
    attempt.effort.iterations += minimum.reached.iteration;
    attempt.effort.transform_pairs += dual.pairs();
    Ok(SolverResult { reached: pressure.into(), effort: attempt.effort, ending: minimum.ending })
}

#[cfg(test)]
mod tests {
    use gfmd_field::Grid;
    use gfmd_green::{Body, Material};
    use gfmd_surface::{Discretisation, SelfAffine};

    use super::*;

    /// Returns the quotients ⟨r, M r⟩ / ⟨r, G⁻¹ r⟩ on the fraction `share` of the highest points of a rough surface,
    /// for pressures p = G⁻¹ r from noise to smooth.
    fn quotients(body: &Body, share: f64) -> Vec<f64> {
        let grid = Grid::square(64, 1.0).unwrap();
        let numbers = Discretisation { eps_t_inv: 2.0, eps_f_inv: 8.0, eps_c_inv: 4.0 };
        let heights = numbers
            .self_affine(1.0, SelfAffine { hurst: 0.3, ..SelfAffine::with_rms_gradient(0.1) })
            .heights(&grid, 1)
            .unwrap();
        let mut sorted: Vec<f64> = heights.iter().copied().collect();
        sorted.sort_by(f64::total_cmp);
        let cut = sorted[((1.0 - share) * sorted.len() as f64) as usize];
        let contact = Contact::new(body, &grid, &heights).unwrap();
        let mut dual = Dual::new(&contact, Load::MeanPressure(1.0));
        let x: Vec<f64> = heights.iter().map(|h| f64::from(*h > cut)).collect();
        let touching: f64 = x.iter().sum();
        (0..12)
            .map(|k| {
                let wave = |i: usize| (0.37 + 0.1 * (2.0_f64).powi(k) * i as f64).sin();
                let mut p: Vec<f64> = x.iter().enumerate().map(|(i, x)| x * wave(i)).collect();
                let mean = p.iter().sum::<f64>() / touching;
                p.iter_mut().zip(&x).for_each(|(p, x)| *p -= mean * x);
                let mut gradient = vec![0.0; x.len()];
                dual.transforms.apply(&dual.compliance, &p, &mut gradient);
                let exact: f64 = gradient.iter().zip(&p).map(|(g, p)| g * p).sum::<f64>() / dual.unit();
                // No point is about to enter the contact.
                gradient.iter_mut().zip(&x).filter(|(_, x)| **x == 0.0).for_each(|(g, _)| *g = 1e9);
                let gradient: Vec<f32> = gradient.iter().map(|g| (g / dual.unit()) as f32).collect();
                let mut z = vec![0.0; x.len()];
                dual.precondition(&x, &gradient, 0.0, &mut z);
                let z: Vec<f64> = z.into_iter().map(f64::from).collect();
                assert!(z.iter().sum::<f64>().abs() < 1e-5 * z.iter().map(|z| z.abs()).sum::<f64>(), "keeps the load");
                gradient.iter().zip(&z).map(|(g, z)| f64::from(*g) * z).sum::<f64>() / exact
            })
            .collect()
    }

    #[test]
    fn the_preconditioner_is_an_upper_bound_of_the_inverse_and_near_it() {
        let body = Body::half_space(Material::from_contact_modulus(1.0, 0.0).unwrap());
        for share in [0.02, 0.1, 0.4, 0.8, 0.99] {
            let quotients = quotients(&body, share);
            assert!(quotients.iter().all(|q| (1.0 - 1e-5..1.5).contains(q)), "{share}: {quotients:?}");
        }
    }
}
