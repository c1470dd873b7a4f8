//! The memory of a body: its displacement, and the elongations of the springs of all branches.

use gfmd_relax::Visit;
use gfmd_vector::{add, for_each, pass, reduce};
use num_complex::Complex64;

use crate::Branch;
use crate::spectrum::Waves;
use crate::step::{Decay, stiffening};

/// The memory of a body at one time. The displacement is the indentation d = −u_z.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum History {
    /// History of a body whose waves all relax alike, point by point.
    Points {
        /// d, then the elongation x of each branch.
        lengths: Vec<Vec<f64>>,
        /// Long-term stiffness times each of them, in stress.
        stresses: Vec<Vec<f64>>,
    },
    /// History of a body each of whose waves has its own branches, mode by mode: d, then x of each branch.
    Waves(Vec<Vec<Complex64>>),
}

/// The energies of a step, per area.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Energies {
    /// Stored in all springs at its end.
    pub(crate) stored: f64,
    /// Lost in the dashpots.
    pub(crate) lost: f64,
}

impl History {
    /// A body at rest, undeformed.
    pub(crate) fn at_rest(points: usize, branches: usize) -> Self {
        let fields = vec![vec![0.0; points]; 1 + branches];
        Self::Points { stresses: fields.clone(), lengths: fields }
    }

    /// As [`at_rest`](Self::at_rest), of waves.
    pub(crate) fn of_waves(modes: usize, branches: usize) -> Self {
        Self::Waves(vec![vec![Complex64::ZERO; modes]; 1 + branches])
    }

    /// Visits all values.
    pub(crate) fn visit(&mut self, visitor: &mut dyn Visit) {
        match self {
            Self::Points { lengths, stresses } => {
                lengths.iter_mut().chain(stresses).for_each(|field| visitor.field(field));
            }
            Self::Waves(fields) => {
                for field in fields {
                    let mut parts: Vec<f64> = field.iter().flat_map(|mode| [mode.re, mode.im]).collect();
                    visitor.field(&mut parts);
                    field.iter_mut().zip(parts.chunks_exact(2)).for_each(|(mode, part)| {
                        *mode = Complex64::new(part[0], part[1]);
                    });
                }
            }
        }
    }
}

/// The numbers of a step of points: those of all branches.
pub(crate) struct PointStep {
    decays: Vec<Decay>,
    /// The stiffness that acts over the long-term one.
    pub(crate) stiffening: f64,
}

impl PointStep {
    pub(crate) fn new(branches: &[Branch], duration: f64) -> Self {
        let decays: Vec<Decay> = branches.iter().map(|branch| Decay::new(*branch, duration)).collect();
        Self { stiffening: stiffening(decays.iter().copied()), decays }
    }

    /// H of a point i: (1/m) Σ c (γ d − e x), of lengths or of stresses.
    fn hollow(&self, fields: &[Vec<f64>], i: usize) -> f64 {
        let Some((first, others)) = fields.split_first() else { return 0.0 };
        let terms = self.decays.iter().zip(others);
        let sum: f64 = terms.map(|(decay, x)| decay.weight * (decay.taken * first[i] - decay.left * x[i])).sum();
        sum / self.stiffening
    }

    /// Fills `hollow` with H, by which the surface would stay indented without a pressure.
    pub(crate) fn fill(&self, lengths: &[Vec<f64>], hollow: &mut [f64]) {
        for_each([hollow], &|start, [hollow]| {
            hollow.iter_mut().enumerate().for_each(|(k, hollow)| *hollow = self.hollow(lengths, start + k));
        });
    }

    /// The memory at the end of the step, in which the `indentation` is reached by a `pressure` over the stiffening,
    /// with its energies.
    pub(crate) fn advance(
        &self,
        (lengths, stresses): (&[Vec<f64>], &[Vec<f64>]),
        (indentation, pressure): (Vec<f64>, &[f64]),
    ) -> (History, Energies) {
        let points = pressure.len();
        let mut stress = vec![0.0; points];
        for_each([&mut stress[..]], &|start, [stress]| {
            for (k, stress) in stress.iter_mut().enumerate() {
                *stress = self.hollow(stresses, start + k) + pressure[start + k];
            }
        });
        let half = |a: &[f64], b: &[f64]| 0.5 * gfmd_vector::dot(a, b);
        let moved = |i: usize| [indentation[i] - lengths[0][i], stress[i] - stresses[0][i]];
        let moving = reduce(
            points,
            &|mut range| range.try_fold(0.0, |sum, i| Some(sum + moved(i).iter().product::<f64>())).unwrap_or(f64::NAN),
            &|a, b| a + b,
        );
        let (mut stored, mut lost) = (half(&indentation, &stress), 0.0);
        let (mut new_lengths, mut new_stresses) = (Vec::new(), Vec::new());
        for (decay, (x, s)) in self.decays.iter().zip(lengths[1..].iter().zip(&stresses[1..])) {
            let (mut new_x, mut new_s) = (vec![0.0; points], vec![0.0; points]);
            let [square, mixed, after] = pass(
                (&mut new_x[..], &mut new_s[..]),
                &|start, (new_x, new_s)| {
                    let mut sums = [0.0; 3];
                    for (k, (new_x, new_s)) in new_x.iter_mut().zip(new_s).enumerate() {
                        let i = start + k;
                        let [d, stress] = moved(i);
                        *new_x = decay.left * x[i] + decay.taken * d;
                        *new_s = decay.left * s[i] + decay.taken * stress;
                        sums = add(sums, [x[i] * s[i], s[i] * d, *new_x * *new_s]);
                    }
                    sums
                },
                &add,
            );
            stored += 0.5 * decay.weight * after;
            let [a, b, c] = decay.loss;
            lost += decay.weight * (a * square + b * mixed + c * moving);
            new_lengths.push(new_x);
            new_stresses.push(new_s);
        }
        new_lengths.insert(0, indentation);
        new_stresses.insert(0, stress);
        let area = points as f64;
        let energies = Energies { stored: stored / area, lost: lost / area };
        (History::Points { lengths: new_lengths, stresses: new_stresses }, energies)
    }
}

impl Waves {
    /// The stiffening of each mode over a step, and the spectrum of H.
    pub(crate) fn hollow(&self, fields: &[Vec<Complex64>], duration: f64) -> (Vec<f64>, Vec<Complex64>) {
        let of_mode = |mode: usize| {
            let decays = || self.of(mode).map(|branch| Decay::new(branch, duration));
            let stiffening = stiffening(decays());
            let terms = decays()
                .zip(&fields[1..])
                .map(|(decay, x)| decay.weight * (decay.taken * fields[0][mode] - decay.left * x[mode]));
            (stiffening, terms.sum::<Complex64>() / stiffening)
        };
        let mut out = (vec![0.0; self.stiffness.len()], vec![Complex64::ZERO; self.stiffness.len()]);
        for_each((&mut out.0[..], &mut out.1[..]), &|start, (factors, hollow)| {
            for (k, (factor, hollow)) in factors.iter_mut().zip(hollow).enumerate() {
                (*factor, *hollow) = of_mode(start + k);
            }
        });
        out
    }

    /// The memory at the end of a step that reaches this `indentation`, with its energies; `weight` is that of a mode.
    pub(crate) fn advance(
        &self,
        fields: &[Vec<Complex64>],
        indentation: Vec<Complex64>,
        duration: f64,
        weight: impl Fn(usize) -> f64 + Sync,
    ) -> (History, Energies) {
        let modes = indentation.len();
        let mut new: Vec<Vec<Complex64>> = vec![Vec::new(); 1 + self.count];
        let product = |a: Complex64, b: Complex64| a.re * b.re + a.im * b.im;
        let of_range = |range: std::ops::Range<usize>| {
            range.fold([0.0; 2], |sums, mode| {
                let scale = weight(mode) * self.stiffness[mode];
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
        let [stored, lost] = reduce(modes, &of_range, &add);
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
        (History::Waves(new), Energies { stored, lost })
    }
}
