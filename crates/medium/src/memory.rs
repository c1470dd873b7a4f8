//! Memory of a body: its displacement and the spring elongations of all branches.

use std::ops::Range;

use gfmd_field::{Grid, ShapeError, Transform};
use gfmd_relax::Visit;
use gfmd_vector::{Share, add, for_each, reduce};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::Branch;
use crate::spectrum::Waves;
use crate::step::{Decay, stiffening};

/// Memory of a body at one time. The displacement is the indentation d = −u, of u_z alone or of all components.
#[derive(Clone, Debug, PartialEq)]
pub struct Memory(pub(crate) Fields);

/// Fields of a memory.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Fields {
    /// Body with the same relaxation for all waves, point by point. Vectors are stored component by component.
    Points {
        /// d, then the elongation x of each branch.
        lengths: Vec<Vec<f64>>,
        /// Long-term stiffness times each of `lengths`, in stress.
        stresses: Vec<Vec<f64>>,
    },
    /// Body with separate branches for each wave, mode by mode: d, then x of each branch.
    Waves(Vec<Vec<Complex64>>),
}

/// Energies of a step, per area.
#[derive(Clone, Copy, Debug, Default)]
pub struct Energies {
    /// Energy stored in all springs at the end.
    pub stored: f64,
    /// Energy lost in the dashpots.
    pub lost: f64,
}

impl Memory {
    /// Visits all values; points are rows of this process, divided by `share`.
    pub fn visit(&mut self, share: &Share, visitor: &mut dyn Visit) {
        self.0.visit(share, visitor);
    }

    /// Multiplies all lengths and stresses by the given factors.
    #[must_use]
    pub fn times(mut self, length: f64, stress: f64) -> Self {
        match &mut self.0 {
            Fields::Points { lengths, stresses } => {
                lengths.iter_mut().flatten().for_each(|x| *x *= length);
                stresses.iter_mut().flatten().for_each(|s| *s *= stress);
            }
            Fields::Waves(fields) => fields.iter_mut().flatten().for_each(|x| *x *= length),
        }
        self
    }

    /// Returns the memory of the values in a range, with another indentation there, in length; `None` for a body whose
    /// waves relax by branches of their own.
    pub fn part(&self, range: Range<usize>, indentation: Vec<f64>) -> Option<Self> {
        let Fields::Points { lengths, stresses } = &self.0 else { return None };
        let values = |fields: &[Vec<f64>]| fields.iter().map(|field| field[range.clone()].to_vec()).collect::<Vec<_>>();
        let mut lengths = values(lengths);
        lengths[0] = indentation;
        Some(Self(Fields::Points { lengths, stresses: values(stresses) }))
    }

    /// Returns the indentation −u_z and the spring elongation of each branch along z, row by row, in length; `grid` is
    /// the grid of the surface, with the rows of this process in a `share`.
    ///
    /// # Errors
    /// Returns an error if the memory belongs to a grid of another size.
    pub fn normal(&self, grid: &Grid, share: &Share) -> Result<Vec<Vec<f64>>, ShapeError> {
        let points = if share.is_whole() { grid.len() } else { share.own().len() };
        match &self.0 {
            // The normal component is the last.
            Fields::Points { lengths, .. } => {
                Ok(lengths.iter().map(|x| x[x.len().saturating_sub(points)..].to_vec()).collect())
            }
            Fields::Waves(spectra) => {
                let transform = Transform::distributed(*grid, share);
                let mut workspace = transform.workspace();
                let mut of = |spectrum: &[Complex64]| {
                    let mut values = vec![0.0; points];
                    transform.inverse(spectrum, &mut values, &mut workspace).map(|()| values)
                };
                spectra.iter().map(|spectrum| of(spectrum)).collect()
            }
        }
    }
}

impl Fields {
    /// Returns the memory of an undeformed body, point by point.
    pub(crate) fn at_rest(points: usize, branches: usize) -> Self {
        let fields = vec![vec![0.0; points]; 1 + branches];
        Self::Points { stresses: fields.clone(), lengths: fields }
    }

    /// Returns the memory of an undeformed body, mode by mode.
    pub(crate) fn of_waves(modes: usize, branches: usize) -> Self {
        Self::Waves(vec![vec![Complex64::ZERO; modes]; 1 + branches])
    }

    /// Visits all values.
    pub(crate) fn visit(&mut self, share: &Share, visitor: &mut dyn Visit) {
        match self {
            Self::Points { lengths, stresses } => {
                let own = share.own().len();
                let fields = lengths.iter_mut().chain(stresses);
                fields.flat_map(|field| field.chunks_exact_mut(own)).for_each(|rows| visitor.rows(share, rows));
            }
            Self::Waves(fields) => {
                let modes = share.of_lengths(fields[0].len(), 2);
                for field in fields {
                    let mut parts: Vec<f64> = field.iter().flat_map(|mode| [mode.re, mode.im]).collect();
                    visitor.rows(&modes, &mut parts);
                    field.iter_mut().zip(parts.chunks_exact(2)).for_each(|(mode, part)| {
                        *mode = Complex64::new(part[0], part[1]);
                    });
                }
            }
        }
    }
}

/// Coefficients of a step for all branches, point by point.
pub(crate) struct PointStep {
    decays: Vec<Decay>,
    /// Stiffness during the step divided by the long-term stiffness.
    pub(crate) stiffening: f64,
}

impl PointStep {
    pub(crate) fn new(branches: &[Branch], duration: f64) -> Self {
        let decays: Vec<Decay> = branches.iter().map(|branch| Decay::new(*branch, duration)).collect();
        Self { stiffening: stiffening(decays.iter().copied()), decays }
    }

    /// Returns H at point `i`: (1/m) Σ c (γ d − e x), from lengths or stresses.
    fn residual_indentation(&self, fields: &[Vec<f64>], i: usize) -> f64 {
        let Some((first, others)) = fields.split_first() else { return 0.0 };
        let terms = self.decays.iter().zip(others);
        let sum: f64 = terms.map(|(decay, x)| decay.weight * (decay.taken * first[i] - decay.left * x[i])).sum();
        sum / self.stiffening
    }

    /// Computes the residual indentation H at zero pressure.
    pub(crate) fn fill(&self, lengths: &[Vec<f64>], residual_indentation: &mut [f64]) {
        for_each([residual_indentation], &|start, [residual_indentation]| {
            residual_indentation.iter_mut().enumerate().for_each(|(k, residual_indentation)| {
                *residual_indentation = self.residual_indentation(lengths, start + k)
            });
        });
    }

    /// Computes the memory and energies at the end of a step that reaches `indentation`; `pressure` is the pressure
    /// divided by the stiffening. Fields have the values of this process, whose points `share` divides.
    pub(crate) fn advance(
        &self,
        share: &Share,
        (lengths, stresses): (&[Vec<f64>], &[Vec<f64>]),
        (indentation, pressure): (Vec<f64>, &[f64]),
    ) -> (Fields, Energies) {
        let points = pressure.len();
        let mut stress = vec![0.0; points];
        for_each([&mut stress[..]], &|start, [stress]| {
            for (k, stress) in stress.iter_mut().enumerate() {
                *stress = self.residual_indentation(stresses, start + k) + pressure[start + k];
            }
        });
        let own = share.own().len();
        let components = points / own;
        let sum = |of_range: &(dyn Fn(Range<usize>) -> f64 + Sync)| {
            share.reduce_components(components, &|range| of_range(range), &|a, b| a + b)
        };
        let half = |a: &[f64], b: &[f64]| 0.5 * sum(&|range| range.map(|i| a[i] * b[i]).sum());
        let moved = |i: usize| [indentation[i] - lengths[0][i], stress[i] - stresses[0][i]];
        let moving = sum(&|range| range.fold(0.0, |sum, i| sum + moved(i).iter().product::<f64>()));
        let (mut stored, mut lost) = (half(&indentation, &stress), 0.0);
        let (mut new_lengths, mut new_stresses) = (Vec::new(), Vec::new());
        for (decay, (x, s)) in self.decays.iter().zip(lengths[1..].iter().zip(&stresses[1..])) {
            let (mut new_x, mut new_s) = (vec![0.0; points], vec![0.0; points]);
            let of_component = |(c, parts): (usize, (&mut [f64], &mut [f64]))| {
                let leaf = |start: usize, (new_x, new_s): (&mut [f64], &mut [f64])| {
                    let mut sums = [0.0; 3];
                    for (k, (new_x, new_s)) in new_x.iter_mut().zip(new_s).enumerate() {
                        let i = c * own + start + k;
                        let [d, stress] = moved(i);
                        *new_x = decay.left * x[i] + decay.taken * d;
                        *new_s = decay.left * s[i] + decay.taken * stress;
                        sums = add(sums, [x[i] * s[i], s[i] * d, *new_x * *new_s]);
                    }
                    sums
                };
                share.pass(parts, &leaf, &add)
            };
            let parts = new_x.chunks_exact_mut(own).zip(new_s.chunks_exact_mut(own)).enumerate();
            let [square, mixed, after] = parts.map(of_component).fold([0.0; 3], add);
            stored += 0.5 * decay.weight * after;
            let [a, b, c] = decay.loss;
            lost += decay.weight * (a * square + b * mixed + c * moving);
            new_lengths.push(new_x);
            new_stresses.push(new_s);
        }
        new_lengths.insert(0, indentation);
        new_stresses.insert(0, stress);
        let area = (components * share.total()) as f64;
        let energies = Energies { stored: stored / area, lost: lost / area };
        (Fields::Points { lengths: new_lengths, stresses: new_stresses }, energies)
    }
}

impl Waves {
    /// Computes the stiffening of each mode in a step, and the spectrum of H.
    pub(crate) fn residual_indentation(&self, fields: &[Vec<Complex64>], duration: f64) -> (Vec<f64>, Vec<Complex64>) {
        let of_mode = |mode: usize| {
            let decays = || self.of(mode).map(|branch| Decay::new(branch, duration));
            let stiffening = stiffening(decays());
            let terms = decays()
                .zip(&fields[1..])
                .map(|(decay, x)| decay.weight * (decay.taken * fields[0][mode] - decay.left * x[mode]));
            (stiffening, terms.sum::<Complex64>() / stiffening)
        };
        let mut out = (vec![0.0; self.stiffness.len()], vec![Complex64::ZERO; self.stiffness.len()]);
        for_each((&mut out.0[..], &mut out.1[..]), &|start, (factors, residual_indentation)| {
            for (k, (factor, residual_indentation)) in factors.iter_mut().zip(residual_indentation).enumerate() {
                (*factor, *residual_indentation) = of_mode(start + k);
            }
        });
        out
    }

    /// Computes the memory and energies after a step that reaches `indentation`. The modes of all processes add to the
    /// energies, lane by lane.
    pub(crate) fn advance(
        &self,
        share: &Share,
        fields: &[Vec<Complex64>],
        indentation: Vec<Complex64>,
        duration: f64,
    ) -> (Fields, Energies) {
        let (modes, lane) = (self.modes.count, self.modes.lane);
        let mut new: Vec<Vec<Complex64>> = vec![Vec::new(); 1 + self.count];
        let product = |a: Complex64, b: Complex64| a.re * b.re + a.im * b.im;
        let of_range = |range: Range<usize>| {
            range.fold([0.0; 2], |sums, mode| {
                // A mean level that is fixed stores nothing.
                let stiffness = self.stiffness[mode];
                let scale = if stiffness.is_finite() { self.modes.at(mode).weight * stiffness } else { 0.0 };
                let (d, moved) = (indentation[mode], indentation[mode] - fields[0][mode]);
                let (mut stored, mut lost) = (0.5 * d.norm_sqr(), 0.0);
                for (branch, x) in self.of(mode).zip(&fields[1..]) {
                    let decay = Decay::new(branch, duration);
                    let (x, [a, b, c]) = (x[mode], decay.loss);
                    stored += 0.5 * decay.weight * (decay.left * x + decay.taken * moved).norm_sqr();
                    lost += decay.weight * (a * x.norm_sqr() + b * product(x, moved) + c * moved.norm_sqr());
                }
                add(sums, [scale * stored, scale * lost])
            })
        };
        let of_lane = |first: usize| reduce(lane, &|range| of_range(first + range.start..first + range.end), &add);
        let lanes: Vec<[f64; 2]> = (0..modes / lane).into_par_iter().map(|number| of_lane(number * lane)).collect();
        let lanes = share.collect(&lanes, &share.each(lanes.len()));
        let [stored, lost] = lanes.into_iter().fold([0.0; 2], add);
        for (index, new) in new.iter_mut().enumerate().skip(1) {
            *new = vec![Complex64::ZERO; modes];
            for_each([&mut new[..]], &|start, [new]| {
                for (k, new) in new.iter_mut().enumerate() {
                    let mode = start + k;
                    let Some(branch) = self.of(mode).nth(index - 1) else { continue };
                    let decay = Decay::new(branch, duration);
                    *new = decay.left * fields[index][mode] + decay.taken * (indentation[mode] - fields[0][mode]);
                }
            });
        }
        new[0] = indentation;
        (Fields::Waves(new), Energies { stored, lost })
    }
}

#[cfg(test)]
mod tests {
    use gfmd_field::Grid;
    use gfmd_green::{Body, Material};

    use super::*;
    use crate::spectrum::{Modes, Spectrum};
    use crate::{Prony, Relaxes};

    struct Numbers(u64);

    impl Numbers {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }

        fn field(&mut self, length: usize) -> Vec<f64> {
            (0..length).map(|_| self.next() - 0.5).collect()
        }

        fn modes(&mut self, length: usize) -> Vec<Complex64> {
            (0..length).map(|_| Complex64::new(self.next() - 0.5, self.next() - 0.5)).collect()
        }
    }

    /// Returns the work of the pressure in a step, ⟨Δd, S [(d + d')/2 + Σ c (τ/Δ)(x − x' + Δd)]⟩, since the integral of
    /// ẋ = ḋ − x/τ is τ (x − x' + Δd), and the energies stored before and after, for one point or mode of stiffness S.
    fn work(stiffness: f64, branches: &[Branch], duration: f64, [before, after]: [&[f64]; 2]) -> [f64; 3] {
        let moved = after[0] - before[0];
        let mut mean = 0.5 * (before[0] + after[0]);
        for (branch, (x, new)) in branches.iter().zip(before[1..].iter().zip(&after[1..])) {
            mean += branch.weight * branch.time / duration * (x - new + moved);
        }
        let stored = |at: &[f64]| {
            let springs = branches.iter().zip(&at[1..]).map(|(branch, x)| branch.weight * x * x);
            0.5 * stiffness * (at[0] * at[0] + springs.sum::<f64>())
        };
        [stiffness * moved * mean, stored(before), stored(after)]
    }

    #[test]
    fn the_work_of_the_pressure_is_stored_or_lost_in_300_random_steps() {
        let slab = Body::slab(Material::from_young(1.3, 0.3).unwrap(), 0.4).unwrap();
        let grid = Grid::new([6, 5], [1.0, 0.8]).unwrap();
        for case in 0..300 {
            let mut numbers = Numbers(case + 91);
            let count = 1 + (case % 3) as i32;
            let pairs: Vec<(f64, f64)> = (0..count)
                .map(|k| (10.0_f64.powf(f64::from(2 * k) - 2.0 + numbers.next()), 0.3 * numbers.next() + 1e-3))
                .collect();
            let prony = Prony::from_fractions(&pairs).unwrap();
            let duration = 10.0_f64.powf(5.0 * numbers.next() - 3.0);
            let (sums, energies) = if case % 2 == 0 {
                // Points of a body with a diagonal stiffness matrix.
                let n = 11;
                let stiffness: Vec<f64> = (0..n).map(|_| 0.1 + numbers.next()).collect();
                let lengths: Vec<Vec<f64>> = (0..=count).map(|_| numbers.field(n)).collect();
                let times = |field: &[f64]| field.iter().zip(&stiffness).map(|(x, s)| x * s).collect::<Vec<f64>>();
                let stresses: Vec<Vec<f64>> = lengths.iter().map(|field| times(field)).collect();
                let step = PointStep::new(prony.branches(), duration);
                let reached = numbers.field(n);
                let mut residual_indentation = vec![0.0; n];
                step.fill(&lengths, &mut residual_indentation);
                let pressure: Vec<f64> =
                    (0..n).map(|i| stiffness[i] * (reached[i] - residual_indentation[i])).collect();
                let (after, energies) = step.advance(&Share::whole(1, n), (&lengths, &stresses), (reached, &pressure));
                let Fields::Points { lengths: after, .. } = after else { unreachable!("points stay points") };
                let of = |i: usize| {
                    let at = |fields: &[Vec<f64>]| fields.iter().map(|field| field[i]).collect::<Vec<f64>>();
                    work(stiffness[i], prony.branches(), duration, [&at(&lengths), &at(&after)])
                };
                ((0..n).map(of).fold([0.0; 3], add).map(|sum| sum / n as f64), energies)
            } else {
                let spectrum = Spectrum::new(&slab, &Modes::all(&grid), false, &prony, Relaxes::Shear).unwrap();
                let Spectrum::Waves(waves) = spectrum else {
                    unreachable!("a slab has its own branches for each wave")
                };
                let modes = waves.stiffness.len();
                let fields: Vec<Vec<Complex64>> = (0..=waves.count).map(|_| numbers.modes(modes)).collect();
                let weight = |mode: usize| grid.mode_at(mode).weight;
                let (after, energies) = waves.advance(&grid.whole(), &fields, numbers.modes(modes), duration);
                let Fields::Waves(after) = after else { unreachable!("waves stay waves") };
                let of = |mode: usize| {
                    let branches: Vec<Branch> = waves.of(mode).collect();
                    [|z: &Complex64| z.re, |z: &Complex64| z.im].map(|part| {
                        let at = |fields: &[Vec<Complex64>]| {
                            fields[..=branches.len()].iter().map(|field| part(&field[mode])).collect::<Vec<f64>>()
                        };
                        let stiffness = weight(mode) * waves.stiffness[mode];
                        work(stiffness, &branches, duration, [&at(&fields), &at(&after)])
                    })
                };
                ((0..modes).flat_map(of).fold([0.0; 3], add), energies)
            };
            let [work, before, after] = sums;
            let scale = before.max(after);
            assert!((energies.stored - after).abs() <= 1e-13 * scale, "case {case}: {} {after}", energies.stored);
            assert!(energies.lost >= 0.0);
            // x − x' + Δd is a small difference in short steps.
            let apart = (work - (after - before) - energies.lost).abs();
            assert!(apart <= 1e-9 * scale, "case {case}: {apart:e} of {scale:e} is missing");
        }
    }
}
