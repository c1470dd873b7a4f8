//! Displacements, energies and losses of a body that relaxes, from its tractions alone. Each branch is a spring of the
//! body's shape in series with a dashpot; everything is kept as the traction that would cause it with the long-term
//! moduli.

use super::super::contact::{Elastic, elastic_of, faces};
use super::super::elastic::{Base, Complex, Stack};
use super::super::path::{Vectors, compliances, displaced};
use super::Parts;

/// Compliance of the long-term body.
enum Compliance {
    /// Pressures alone.
    Normal(Elastic),
    /// Pressures on both faces of a plate.
    Plate(Stack),
    /// All components of a periodic surface, by mode.
    Full(Vec<[[Complex; 3]; 3]>),
}

/// Body with its memory.
pub(super) struct Memory<'a> {
    parts: &'a Parts,
    compliance: Compliance,
    /// Long-term compliance divided by the compliance of the given moduli.
    factor: f64,
    /// Relaxation time and stiffness of each branch, relative to the long-term stiffness.
    branches: Vec<[f64; 2]>,
    /// Displacement, and elongation of the spring of each branch.
    moved: Field,
    springs: Vec<Field>,
}

/// Traction components of all points.
type Field = Vec<Vec<f64>>;

/// State of the body at the end of a step.
pub(super) struct Reached {
    /// Displacement, component by component; z alone without shear; out of both faces of a plate.
    pub(super) displacement: Field,
    pub(super) stored: f64,
    pub(super) lost: f64,
    /// Relative error of the compliance.
    pub(super) tolerance: f64,
}

fn combine(fields: &[(f64, &Field)]) -> Field {
    let (_, first) = fields[0];
    (0..first.len())
        .map(|c| (0..first[c].len()).map(|i| fields.iter().map(|(factor, field)| factor * field[c][i]).sum()).collect())
        .collect()
}

impl<'a> Memory<'a> {
    /// Returns a body at rest; `None` where its compliance is not covered here.
    pub(super) fn new(parts: &'a Parts, is_sheared: bool) -> Option<Self> {
        let Parts { body, plane, is_free, relaxation, .. } = parts;
        if relaxation.as_ref().is_some_and(|of| of.of_shear) {
            return None;
        }
        let compliance = match is_sheared {
            _ if parts.lower.is_some() => {
                Compliance::Plate(Stack { layers: body.first.layers.clone(), base: Base::Free })
            }
            true if !is_free => Compliance::Full(compliances(body, *plane)),
            true if !parts.is_uncoupled() => return None,
            _ => Compliance::Normal(elastic_of(body, *plane, *is_free, false)),
        };
        let stiffening = relaxation.as_ref().map_or(1.0, super::Relaxation::stiffening);
        let is_instantaneous = relaxation.as_ref().is_some_and(|of| of.instantaneous);
        let branches: Vec<[f64; 2]> = relaxation
            .iter()
            .flat_map(|of| &of.branches)
            .map(|[time, fraction]| [*time, fraction * stiffening])
            .collect();
        let count = match compliance {
            Compliance::Normal(_) => 1,
            Compliance::Plate(_) => 2,
            Compliance::Full(_) => 3,
        };
        let none: Field = vec![vec![0.0; plane.len()]; count];
        let springs = vec![none.clone(); branches.len()];
        let factor = if is_instantaneous { stiffening } else { 1.0 };
        Some(Self { parts, compliance, factor, branches, moved: none, springs })
    }

    /// Returns true if the body moves in all components.
    pub(super) fn has_shear(&self) -> bool {
        matches!(self.compliance, Compliance::Full(_))
    }

    fn displace(&self, traction: &Field) -> Field {
        let mut found = match (&self.compliance, &traction[..]) {
            (Compliance::Normal(elastic), [z]) => vec![elastic.dense.displace(z)],
            (Compliance::Plate(stack), [upper, lower]) => faces(stack, self.parts.plane, false, [upper, lower]).into(),
            (Compliance::Full(matrices), [x, y, z]) => {
                displaced(self.parts.plane, matrices, &Vectors([x.clone(), y.clone(), z.clone()])).0.to_vec()
            }
            _ => unreachable!("as many fields as the compliance has"),
        };
        found.iter_mut().flatten().for_each(|u| *u *= self.factor);
        found
    }

    /// Returns the work of one traction on the displacement by another one, per area.
    fn product(&self, a: &Field, b: &Field) -> f64 {
        let moved = self.displace(b);
        a.iter().flatten().zip(moved.iter().flatten()).map(|(t, u)| t * u).sum::<f64>() / self.parts.plane.len() as f64
    }

    /// Moves on to a traction after a duration, at a constant velocity of the surface. The traction has the components
    /// of the compliance.
    pub(super) fn advance(&mut self, traction: Field, duration: f64) -> Reached {
        let (mut stiffness, mut rest) = (1.0, traction);
        // Decay of an elongation, and elongation per displacement in the step.
        let factors: Vec<[f64; 3]> = self
            .branches
            .iter()
            .map(|[time, c]| {
                let x = duration / time;
                [(-x).exp(), if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }, *c]
            })
            .collect();
        for ([decay, share, c], spring) in factors.iter().zip(&self.springs) {
            stiffness += c * share;
            rest = combine(&[(1.0, &rest), (-c * decay, spring), (c * share, &self.moved)]);
        }
        let moved = combine(&[(1.0 / stiffness, &rest)]);
        let way = combine(&[(1.0, &moved), (-1.0, &self.moved)]);
        let mut lost = 0.0;
        for (k, [decay, share, c]) in factors.iter().enumerate() {
            let x = duration / self.branches[k][0];
            if x > 0.0 {
                // Elongation A + B exp(-t / tau).
                let a = combine(&[(1.0 / x, &way)]);
                let b = combine(&[(1.0, &self.springs[k]), (-1.0, &a)]);
                lost += c
                    * (x * self.product(&a, &a)
                        + 2.0 * (1.0 - decay) * self.product(&a, &b)
                        + 0.5 * (1.0 - decay * decay) * self.product(&b, &b));
            }
            self.springs[k] = combine(&[(*decay, &self.springs[k]), (*share, &way)]);
        }
        self.moved = moved;
        let of_branches: f64 =
            factors.iter().zip(&self.springs).map(|([_, _, c], spring)| c * self.product(spring, spring)).sum();
        let tolerance = if let Compliance::Normal(elastic) = &self.compliance { elastic.tolerance } else { 1e-8 };
        Reached {
            displacement: self.displace(&self.moved),
            stored: 0.5 * (self.product(&self.moved, &self.moved) + of_branches),
            lost,
            tolerance,
        }
    }
}
