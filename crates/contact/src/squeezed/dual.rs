//! Both contacts in terms of their pressures: minimise ½⟨p, C p⟩ + ⟨p, clearance⟩ over p ≥ 0 on both faces, at most
//! the hardness, with both means prescribed, or with equal means and the approach subtracted from the clearances.

use gfmd_field::{Rows, Share};
use gfmd_relax::{Budget, Ceiling, Ending, Paired, PreconditionedCg, RelaxError, Target, Upper, Visit, Watch};
use gfmd_response::PlateTransforms;
use gfmd_vector::for_each;

use super::SqueezedContact;
use crate::attempt::MARGIN;
use crate::contact::LEVEL;
use crate::pull_push::{Edges, Known, PullPush};
use crate::{Effort, Load};

/// Result of a search. Only the pressures are trusted.
pub(super) struct DualResult {
    pub(super) pressure: Vec<f64>,
    pub(super) effort: Effort,
    pub(super) ending: Ending,
}

pub(super) fn solve(
    contact: &SqueezedContact,
    load: Load,
    length_scale: f64,
    budget: &Budget,
    start: Option<Vec<f64>>,
    watch: &mut dyn Watch,
) -> Result<DualResult, RelaxError> {
    let mean = if let Load::MeanPressure(mean) = load { Some(mean) } else { None };
    let mut dual = Dual::new(contact, load, length_scale);
    let mut pressure = start.unwrap_or_else(|| vec![mean.unwrap_or(0.0); dual.linear.len()]);
    if dual.upper.ceiling().is_finite() {
        for_each((&mut pressure[..], dual.upper.ceiling()), &|_, (pressure, upper)| {
            pressure.iter_mut().enumerate().for_each(|(i, p)| *p = p.min(upper.at(i)));
        });
    }
    let within = Budget { tolerance: MARGIN * budget.tolerance, ..*budget };
    let target = Target { mean, gradient_scale: length_scale, budget: within };
    let minimum = PreconditionedCg.minimise_pair(&mut dual, &mut pressure, &target, watch)?;
    let effort = Effort { iterations: minimum.reached.iteration, transform_pairs: dual.transforms.pairs() };
    Ok(DualResult { pressure, effort, ending: minimum.ending })
}

/// Quadratic function minimised by the pressures.
struct Dual {
    /// Rows of this process, of both faces.
    share: Share,
    linear: Vec<f64>,
    /// Hardness of both faces, infinite without one.
    upper: Upper,
    /// Compliance and stiffness of the uniform mode.
    uniform: [f64; 2],
    /// Unit for the rounding of gradients.
    scale: f64,
    transforms: PlateTransforms,
    extension: Extension,
    indentation: Vec<f64>,
}

impl Dual {
    fn new(contact: &SqueezedContact, load: Load, length_scale: f64) -> Self {
        let SqueezedContact { plate, response, scaled, hardness, .. } = contact;
        let (lift, uniform) = match load {
            Load::MeanPressure(_) => (0.0, [0.0; 2]),
            Load::Approach(approach) => {
                let compliance = response.uniform_compliance();
                let softest = LEVEL * response.softest_squeezing();
                (0.5 * approach, [compliance, if compliance > 0.0 { 1.0 / compliance } else { softest }])
            }
        };
        let linear: Vec<f64> = scaled.iter().flat_map(|surface| surface.clearance().after(lift).iter()).collect();
        let grid = response.grid();
        let points = grid.points();
        let longer = grid.lengths()[usize::from(points[1] > points[0])];
        let wave = |periods: usize| std::f64::consts::TAU * periods as f64 / longer;
        let floating = matches!(load, Load::MeanPressure(_));
        let share = response.share();
        let squeezing = |n: usize| 1.0 / plate.compliance(wave(n)).squeezing;
        let bending = |n: usize| 1.0 / plate.compliance(wave(n)).bending;
        let face = || PullPush::new(points, floating, Edges::Joined, squeezing).distributed(share);
        let shared = PullPush::new(points, true, Edges::Joined, bending).bending().distributed(share);
        let indentation = vec![0.0; linear.len()];
        let upper = match hardness {
            None => Upper::All(f64::INFINITY),
            Some(Upper::All(hardness)) => Upper::All(*hardness),
            Some(Upper::Each(hardness)) => Upper::Each([&hardness[..]; 2].concat().into()),
        };
        let [_, row] = grid.rows();
        Self {
            share: share.of_faces(),
            upper,
            uniform,
            scale: length_scale,
            transforms: PlateTransforms::of(response),
            extension: Extension::new(share, [face(), face()], shared, linear.len(), row),
            indentation,
            linear,
        }
    }
}

impl Paired for Dual {
    fn linear(&self) -> &[f64] {
        &self.linear
    }

    fn upper(&self) -> Upper {
        self.upper.clone()
    }

    fn share(&self) -> Share {
        self.share.clone()
    }

    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        self.transforms.compliance(self.uniform[0], x, out);
    }

    /// Applies Eᵀ C⁻¹ E with E the extension from the contacts to both faces.
    fn precondition(&mut self, x: &[f64], gradient: &[f64], out: &mut [f64]) {
        let Self { uniform: [_, stiffness], scale, upper, transforms, extension, indentation, .. } = self;
        let between = (x, upper.ceiling());
        extension.extend(between, (gradient, *scale), transforms, indentation);
        transforms.stiffness(*stiffness, indentation, out);
        extension.transpose(between, (out, *scale), transforms);
    }

    fn visit(&mut self, visitor: &mut dyn Visit) {
        visitor.count(self.transforms.counter());
    }
}

/// Linear map E from indentations known on the contacts, where the pressures are below the hardness, to indentations of
/// both faces. Long waves are extended from both contacts together, since the plate bends; the rest of the known values
/// is extended on each face alone:
///
/// ```text
///   w = F W (r_upper, −r_lower)      W: shared extension, mean of both where both are known
///                                    F: waves that both faces follow
///   d_upper = w + E₁ (r_upper − w),  d_lower = −w + E₁ (r_lower + w)
/// ```
struct Extension {
    /// Rows of this process on each face.
    share: Share,
    faces: [PullPush; 2],
    shared: PullPush,
    row: usize,
    /// Sum of the pressures, and mean of the known values.
    joint_x: Vec<f64>,
    joint: Vec<f32>,
    /// Waves that the faces do not share.
    own: Vec<f32>,
    rows: Vec<f32>,
    wave: Vec<f64>,
    followed: Vec<f64>,
}

/// Gradient of a point out of contact that is not about to enter; of a point that stays at the hardness its negative.
const OUTSIDE: f32 = 1.0;

/// Pressures and their upper bounds.
type Between<'a> = (&'a [f64], Ceiling<'a>);

/// Returns true if a pressure lies between the bounds.
fn is_between(p: f64, upper: f64) -> bool {
    p > 0.0 && p < upper
}

impl Extension {
    fn new(share: &Share, faces: [PullPush; 2], shared: PullPush, variables: usize, row: usize) -> Self {
        let points = variables / 2;
        Self {
            share: share.clone(),
            faces,
            shared,
            row,
            joint_x: vec![0.0; points],
            joint: vec![0.0; points],
            own: vec![0.0; variables],
            rows: vec![0.0; variables],
            wave: vec![0.0; points],
            followed: vec![0.0; points],
        }
    }

    /// Computes `out` = E `gradient`.
    fn extend(
        &mut self,
        (x, upper): Between,
        (gradient, scale): (&[f64], f64),
        transforms: &mut PlateTransforms,
        out: &mut [f64],
    ) {
        let points = self.joint.len();
        let Self { joint_x, joint, own, rows, wave, followed, shared, .. } = self;
        let halves = |v: &[f64], k: usize| [v[k], v[points + k]];
        for_each((&mut joint_x[..], &mut joint[..]), &|start, (joint_x, joint)| {
            for (k, (joint_x, joint)) in (start..).zip(joint_x.iter_mut().zip(joint)) {
                let ([above, below], [g, h]) = (halves(x, k), halves(gradient, k));
                let known = [is_between(above, upper.at(k)), is_between(below, upper.at(points + k))];
                *joint_x = if known[0] { above } else { 0.0 } + if known[1] { below } else { 0.0 };
                *joint = match known.into() {
                    (true, true) => 0.5 * (g - h) / scale,
                    (true, false) => g / scale,
                    (false, true) => -h / scale,
                    (false, false) => 0.0,
                } as f32;
            }
        });
        let known = Known { x: joint_x, gradient: joint, level: 0.0, upper: Ceiling::All(f64::INFINITY) };
        spread(shared, known, self.row, &mut rows[..points]);
        for_each((&mut wave[..], &rows[..points]), &|_, (wave, row)| {
            wave.iter_mut().zip(row).for_each(|(wave, row)| *wave = f64::from(*row));
        });
        transforms.follow(wave, followed);
        for (face, sign) in [1.0, -1.0].into_iter().enumerate() {
            let range = face * points..(face + 1) * points;
            let (x, gradient, upper) = (&x[range.clone()], &gradient[range.clone()], upper.part(range.clone()));
            let fields = (&mut own[range.clone()], (x, gradient), &followed[..], upper);
            for_each(fields, &|_, (own, (x, gradient), wave, upper)| {
                for (k, ((own, wave), (x, g))) in own.iter_mut().zip(wave).zip(x.iter().zip(gradient)).enumerate() {
                    let is_full = *x >= upper.at(k);
                    let is_free = if is_full { *g > 0.0 } else { *x > 0.0 || *g < 0.0 };
                    let outside = if is_full { -OUTSIDE } else { OUTSIDE };
                    *own = if is_free { (g / scale - sign * wave) as f32 } else { outside };
                }
            });
            let known = Known { x, gradient: &own[range.clone()], level: 0.0, upper };
            spread(&mut self.faces[face], known, self.row, &mut rows[range.clone()]);
            for_each((&mut out[range.clone()], &rows[range], &followed[..]), &|_, (out, row, wave)| {
                let all = out.iter_mut().zip(row.iter().zip(wave));
                all.for_each(|(out, (row, wave))| *out = f64::from(*row) + sign * wave);
            });
        }
    }

    /// Replaces `out` by Eᵀ `out`, with the map E of the last call of [`extend`](Self::extend).
    fn transpose(&mut self, (x, upper): Between, (out, scale): (&mut [f64], f64), transforms: &mut PlateTransforms) {
        let points = self.joint.len();
        let Self { share, joint_x, joint, own, rows, wave, followed, shared, faces, .. } = self;
        // Pressures may be too small or too large for single precision.
        let largest =
            gfmd_vector::reduce(out.len(), &|range| out[range].iter().fold(0.0_f64, |a, b| a.max(b.abs())), &f64::max);
        let largest = share.each(largest).into_iter().fold(0.0, f64::max);
        let unit = if largest > 0.0 { largest } else { 1.0 };
        wave.fill(0.0);
        for (face, sign) in [1.0, -1.0].into_iter().enumerate() {
            let range = face * points..(face + 1) * points;
            for_each((&mut rows[range.clone()], &out[range.clone()]), &|_, (row, out)| {
                row.iter_mut().zip(out).for_each(|(row, out)| *row = (out / unit) as f32);
            });
            let known = Known {
                x: &x[range.clone()],
                gradient: &own[range.clone()],
                level: 0.0,
                upper: upper.part(range.clone()),
            };
            faces[face].transpose(known, &mut rows[range.clone()]);
            for_each((&mut wave[..], &out[range.clone()], &rows[range]), &|_, (wave, out, row)| {
                let all = wave.iter_mut().zip(out.iter().zip(row));
                all.for_each(|(wave, (out, row))| *wave += sign * (out / unit - f64::from(*row)));
            });
        }
        transforms.follow(wave, followed);
        for_each((&mut joint[..], &followed[..]), &|_, (joint, wave)| {
            joint.iter_mut().zip(wave).for_each(|(joint, wave)| *joint = *wave as f32);
        });
        // The bits of the points that keep their values come from the last extension.
        let mut image = std::mem::take(joint);
        let known = Known { x: joint_x, gradient: &[], level: 0.0, upper: Ceiling::All(f64::INFINITY) };
        shared.transpose(known, &mut image);
        *joint = image;
        let part = unit * scale;
        let (above, below) = out.split_at_mut(points);
        let (row_above, row_below) = rows.split_at(points);
        let joint = &joint[..];
        for_each((above, below, (row_above, row_below, joint)), &|start, (above, below, (first, second, joint))| {
            for (k, (above, below)) in above.iter_mut().zip(below).enumerate() {
                let touches = [start + k, points + start + k].map(|k| is_between(x[k], upper.at(k)));
                let share = f64::from(joint[k]) * if touches == [true; 2] { 0.5 } else { 1.0 };
                let of =
                    |touches: bool, row: f32, share: f64| part * (f64::from(row) + if touches { share } else { 0.0 });
                *above = of(touches[0], first[k], share);
                *below = of(touches[1], second[k], -share);
            }
        });
    }
}

/// Computes the rows of the extension of the known values.
fn spread(extension: &mut PullPush, known: Known, row: usize, out: &mut [f32]) {
    extension.prepare(known);
    let extension = &*extension;
    gfmd_vector::pass_by(1, Rows(out, row), &|i, Rows(out, _)| extension.row(known, i, out), &|(), ()| ());
}

#[cfg(test)]
mod tests {
    use gfmd_field::Grid;
    use gfmd_green::{Body, Material};
    use ndarray::Array2;

    use super::*;

    const N: usize = 32;

    /// Applies the preconditioner to fields on contacts on half of each face. Returns the contacts and the images.
    fn preconditioned(height: f64, load: Load, fields: &[Vec<f64>]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let grid = Grid::square(N, 1.0).unwrap();
        let body = Body::slab(Material::from_contact_modulus(1.0, 0.3).unwrap(), height).unwrap();
        let bumps = |k: usize| Array2::from_shape_fn((N, N), |(i, j)| 0.01 * ((k * i + 3 * j) % 11) as f64);
        let contact = SqueezedContact::new(&body, &grid, &bumps(1), &bumps(2)).unwrap();
        let x: Vec<f64> = (0..2 * N * N).map(|k| f64::from(u8::from((k / 5 + k / 70) % 2 == 0))).collect();
        let mut dual = Dual::new(&contact, load, contact.length_scale(load));
        let images = fields.iter().map(|field| {
            // No point is about to enter a contact.
            let gradient: Vec<f64> = field.iter().zip(&x).map(|(g, x)| if *x > 0.0 { *g } else { 1e3 }).collect();
            let mut image = vec![0.0; gradient.len()];
            dual.precondition(&x, &gradient, &mut image);
            image
        });
        let images = images.collect();
        (x, images)
    }

    #[test]
    fn the_preconditioner_is_symmetric_and_positive() {
        for height in [0.03, 0.2, 3.0] {
            for load in [Load::MeanPressure(0.1), Load::Approach(0.01)] {
                let wave = |k: f64| (0..2 * N * N).map(|i| (0.3 + k * i as f64).sin()).collect::<Vec<f64>>();
                let fields = [wave(0.1), wave(0.77), vec![1.0; 2 * N * N]];
                let (x, images) = preconditioned(height, load, &fields);
                let product = |a: usize, b: usize| {
                    let all = fields[a].iter().zip(&images[b]).zip(&x);
                    all.map(|((f, m), x)| f * m * x).sum::<f64>()
                };
                for (a, b) in [(0, 1), (0, 2), (1, 2)] {
                    let size = (product(a, a) * product(b, b)).abs().sqrt();
                    let skew = (product(a, b) - product(b, a)).abs();
                    assert!(skew < 1e-4 * size.max(product(0, 0)), "{height} {load:?}: {skew} of {size}");
                }
                assert!(product(0, 0) > 0.0 && product(1, 1) > 0.0);
                assert!(images.iter().flatten().zip(x.iter().cycle()).all(|(m, x)| *x > 0.0 || *m == 0.0));
            }
        }
    }
}
