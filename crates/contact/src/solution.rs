use std::sync::Arc;

use gfmd_field::Grid;
use gfmd_measure::{Scales, Summary};
use gfmd_relax::{Ceiling, Upper, Variables, Visit};
use gfmd_vector::{Share, add, for_each, lower, with_contiguous};
use ndarray::{Array2, ArrayView2, CowArray, Ix2};

use crate::refine::Refined;
use crate::{Effort, Fields, Load, RigidSurface, Units};

/// Equilibrated contact. Fields are `[x, y]`; the displacement of the surface is negative downwards. Each of several
/// processes has its rows of the fields; the numbers describe the whole contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Contact pressure, ≥ 0, in stress; exactly 0 out of contact.
    pub pressure: Array2<f64>,
    /// Normal displacement u_z of the elastic surface, in length.
    pub displacement: Array2<f64>,
    /// Distance between the surfaces, in length; in contact it vanishes to within the residuals.
    pub gap: Array2<f64>,
    /// Mean pressure over the whole surface.
    pub mean_pressure: f64,
    /// Rigid approach beyond first touch of the undeformed surfaces.
    pub approach: f64,
    /// Distance from the exact solution, computed from the fields above.
    pub residual: Residual,
    /// Effort of the solve, including the transforms for the final fields.
    pub effort: Effort,
    /// Plastic part, if the contact has a hardness.
    pub plastic: Option<Plastic>,
    /// Lateral part of a contact [in all components](crate::Contact::in_all_components).
    pub lateral: Option<Lateral>,
    /// Length scale of the residuals.
    pub(crate) length_scale: f64,
    surface: Arc<RigidSurface>,
    contact_modulus: f64,
}

/// Plastic part of a contact with a hardness.
#[derive(Clone, Debug, PartialEq)]
pub struct Plastic {
    /// Depth by which the surfaces are pressed into each other beyond touching, −(clearance − u_z − approach) ≥ 0 where
    /// the pressure is the hardness, and zero elsewhere, in length.
    pub depth: Array2<f64>,
    /// Number of points at the hardness divided by the number of all points.
    pub fraction: f64,
    /// Mean of the depth over the whole surface, in length.
    pub volume: f64,
    /// Largest error at the points that reach the hardness: gap divided by the length scale, or excess of the pressure
    /// divided by the hardness, whichever is larger; zero for the exact solution.
    pub saturation: f64,
}

/// Lateral part of a contact in all components.
#[derive(Clone, Debug, PartialEq)]
pub struct Lateral {
    /// u_x and u_y, or u_x on a line, by the pressure, in length.
    pub displacement: Vec<Array2<f64>>,
    /// Largest lateral traction left by the dynamics, relative to the largest pressure; zero for the exact solution.
    pub traction: f64,
}

/// Residuals of the contact conditions; zero for the exact solution. They are computed from the final pressure with
/// fresh transforms, not taken from the solver. h_rms is the rms height of the rigid surface, or the length scale
/// [under a very small approach](RigidSurface::length_scale) or [of a very small
/// displacement](RigidSurface::finer_scale).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Residual {
    /// Σ p g / (Σ p · h_rms), in magnitude; 1 if a prescribed approach is positive and there is no pressure.
    pub complementarity: f64,
    /// max(0, −min g) / h_rms.
    pub penetration: f64,
    /// max(0, −min p) / p̄.
    pub negative_pressure: f64,
    /// |p̄ − asked| / asked; 0 if the approach is prescribed.
    pub load: f64,
}

/// Data that determine a solution, besides its pressure and its displacement.
#[derive(Clone, Copy)]
pub(crate) struct Conditions<'a> {
    /// Uniform downward displacement of the body, which the displacement does not contain.
    pub(crate) sinking: f64,
    pub(crate) load: Load,
    /// Length scale of the residuals, unless the displacement is very small.
    pub(crate) length_scale: f64,
    /// Extent of another length, for comparison with the displacement of the own surface: the displacement of the other
    /// face, or a worn depth. The larger extent counts.
    pub(crate) extent: f64,
    /// Largest pressure that the surfaces carry.
    pub(crate) hardness: Option<&'a Upper>,
}

impl Residual {
    /// Returns the four residuals with their names.
    pub fn parts(&self) -> [(&'static str, f64); 4] {
        [
            ("complementarity", self.complementarity),
            ("penetration", self.penetration),
            ("negative_pressure", self.negative_pressure),
            ("load", self.load),
        ]
    }

    /// Returns the largest of the four; NaN if any is NaN.
    pub fn worst(&self) -> f64 {
        gfmd_relax::worst(self.parts().map(|(_, residual)| residual))
    }
}

impl Solution {
    /// Returns the rows of this process, all of them if it is alone.
    pub fn share(&self) -> &Share {
        self.surface.share()
    }
}

impl Fields for Solution {
    fn pressure(&self) -> CowArray<'_, f64, Ix2> {
        self.pressure.view().into()
    }

    fn displacement_z(&self) -> ArrayView2<'_, f64> {
        self.displacement.view()
    }

    fn gap(&self) -> ArrayView2<'_, f64> {
        self.gap.view()
    }

    fn mean_pressure(&self) -> f64 {
        self.mean_pressure
    }

    fn approach(&self) -> f64 {
        self.approach
    }

    fn effort(&self) -> Effort {
        self.effort
    }

    fn residuals(&self) -> Vec<(&'static str, f64)> {
        let saturation = self.plastic.iter().map(|plastic| ("saturation", plastic.saturation));
        let lateral = self.lateral.iter().map(|lateral| ("lateral_traction", lateral.traction));
        self.residual.parts().into_iter().chain(saturation).chain(lateral).collect()
    }

    fn scales(&self) -> Scales {
        Scales { contact_modulus: self.contact_modulus, rms_gradient: self.surface.rms_gradient() }
    }

    fn summary_in(&self, scales: &Scales) -> Summary {
        let Self { pressure, displacement, gap, mean_pressure, surface, .. } = self;
        let fields = [pressure, displacement, gap].map(|field| field.view());
        Summary::distributed(surface.share(), fields, *mean_pressure, scales, surface.boundary()).at_wall()
    }
}

impl Variables for Solution {
    fn visit(&mut self, visitor: &mut dyn Visit) {
        let Self {
            pressure,
            displacement,
            gap,
            mean_pressure,
            approach,
            residual,
            effort,
            plastic,
            lateral,
            length_scale,
            surface,
            ..
        } = self;
        let share = surface.share();
        for field in [pressure, displacement, gap] {
            with_contiguous(field, |field| visitor.rows(share, field));
        }
        let Residual { complementarity, penetration, negative_pressure, load } = residual;
        visitor.numbers(&mut [mean_pressure, approach, complementarity, penetration, negative_pressure, load]);
        effort.visit(visitor);
        if let Some(Plastic { depth, fraction, volume, saturation }) = plastic {
            with_contiguous(depth, |depth| visitor.rows(share, depth));
            visitor.numbers(&mut [fraction, volume, saturation]);
        }
        if let Some(Lateral { displacement, traction }) = lateral {
            displacement.iter_mut().for_each(|u| with_contiguous(u, |u| visitor.rows(share, u)));
            visitor.number(traction);
        }
        visitor.number(length_scale);
    }
}

impl Refined for Solution {
    fn length_scale(&self) -> f64 {
        self.length_scale
    }

    fn start(&self) -> Vec<f64> {
        self.pressure.iter().copied().collect()
    }

    fn effort_mut(&mut self) -> &mut Effort {
        &mut self.effort
    }
}

impl Solution {
    pub(crate) fn grid(&self) -> &Grid {
        self.surface.grid()
    }

    /// Converts the solution of a contact in `units` to the units of the input, in which `surface` and E* are given.
    pub(crate) fn out_of(self, units: &Units, surface: &Arc<RigidSurface>, contact_modulus: f64) -> Self {
        self.times(units.length(), units.stress(), surface, contact_modulus)
    }

    /// Multiplies all lengths and stresses by the given factors; `surface` and E* are in the new units.
    #[must_use]
    pub fn times(mut self, length: f64, stress: f64, surface: &Arc<RigidSurface>, contact_modulus: f64) -> Self {
        self.pressure.mapv_inplace(|p| p * stress);
        self.displacement.mapv_inplace(|u| u * length);
        self.gap.mapv_inplace(|g| g * length);
        self.lateral.iter_mut().flat_map(|lateral| &mut lateral.displacement).for_each(|field| *field *= length);
        if let Some(plastic) = &mut self.plastic {
            plastic.depth.mapv_inplace(|depth| depth * length);
            plastic.volume *= length;
        }
        Self {
            mean_pressure: self.mean_pressure * stress,
            approach: self.approach * length,
            length_scale: self.length_scale * length,
            surface: Arc::clone(surface),
            contact_modulus,
            ..self
        }
    }

    /// Returns the length scale of the residuals.
    pub fn length_scale(&self) -> f64 {
        self.length_scale
    }

    /// Computes the state of `pressure` and of the displacement u_z that follows from it, with the residuals. Both have
    /// the rows of this process.
    pub(crate) fn of(
        surface: &Arc<RigidSurface>,
        contact_modulus: f64,
        pressure: Vec<f64>,
        mut displacement: Vec<f64>,
        conditions: Conditions,
    ) -> Self {
        let Conditions { sinking, load, length_scale, extent, hardness } = conditions;
        let upper = hardness.map_or(Ceiling::All(f64::INFINITY), Upper::ceiling);
        let (clearance, share) = (surface.clearance(), surface.share());
        let n = share.total();
        // Sums: the pressure, the points in contact, and their room between the surfaces without an approach. Lowest
        // values: the displacement, minus the displacement, and minus the pressure.
        let room = |i: usize| clearance.at(i) - displacement[i];
        let ends = [f64::INFINITY; 3];
        let ([sum, touching, free], [lowest, highest, strongest]) = share.reduce(
            &|range| {
                range.fold(([0.0; 3], ends), |(sums, ends), i| {
                    let (p, u) = (pressure[i], displacement[i]);
                    let touches = (p > 0.0) & (p < upper.at(i));
                    let sums = add(sums, if touches { [p, 1.0, room(i)] } else { [p, 0.0, 0.0] });
                    (sums, lower_each(ends, [u, -u, -p]))
                })
            },
            &|a, b| (add(a.0, b.0), lower_each(a.1, b.1)),
        );
        let mean_pressure = sum / n as f64;
        let [lx, ly] = surface.grid().lengths();
        // A uniform pressure, such as the hardness at all points, leaves only the rounding errors of the transforms.
        let rounding = ROUNDING_OF_DISPLACEMENT * -strongest * lx.max(ly) / contact_modulus;
        let own = Some(-highest - lowest).filter(|own| *own > rounding).unwrap_or(0.0);
        let length_scale = RigidSurface::finer_scale(length_scale, extent.max(own));
        let sink = |u: &mut [f64]| {
            if sinking != 0.0 {
                for_each([u], &|_, [u]| u.iter_mut().for_each(|u| *u -= sinking));
            }
        };
        // Under a prescribed load the rigid surface sinks with the body. The gap does not depend on it, and is computed
        // without it: on a soft or high slab the sinking is much larger than the roughness.
        let above = match load {
            // The approach is the mean of clearance − u_z over the contact; without a pressure it is first touch.
            Load::MeanPressure(_) => {
                if touching > 0.0 {
                    free / touching
                } else {
                    between(share, &pressure, upper, room)
                }
            }
            Load::Approach(approach) => {
                sink(&mut displacement);
                approach
            }
        };
        let mut gap = vec![0.0; pressure.len()];
        let mut sums = share.pass(
            [&mut gap[..]],
            &|start, [gap]| {
                let mut sums = (0.0, f64::INFINITY, f64::INFINITY);
                let clearance = clearance.part(start..start + gap.len());
                let others = clearance.iter().zip(&displacement[start..]).zip(&pressure[start..]);
                for (gap, ((c, u), p)) in gap.iter_mut().zip(others) {
                    *gap = c - u - above;
                    sums = (sums.0 + p * *gap, lower(sums.1, *gap), lower(sums.2, *p));
                }
                sums
            },
            &|a, b| (a.0 + b.0, lower(a.1, b.1), lower(a.2, b.2)),
        );
        let plastic = hardness.map(|hardness| {
            let (plastic, elastic) = Plastic::of(surface, &pressure, &mut gap, hardness.ceiling(), length_scale);
            sums = (elastic.0, elastic.1, sums.2);
            plastic
        });
        let residual = Residual {
            complementarity: match load {
                // An approach beyond first touch needs a pressure, however small.
                Load::Approach(approach) if sum == 0.0 => f64::from(approach > 0.0),
                _ if sum == 0.0 => 0.0,
                _ => (sums.0 / (sum * length_scale)).abs(),
            },
            penetration: positive(-sums.1) / length_scale,
            negative_pressure: if sum == 0.0 { 0.0 } else { positive(-sums.2) / mean_pressure },
            load: match load {
                Load::MeanPressure(0.0) if mean_pressure == 0.0 => 0.0,
                Load::MeanPressure(asked) => (mean_pressure - asked).abs() / asked,
                Load::Approach(_) => 0.0,
            },
        };
        let approach = match load {
            Load::MeanPressure(_) => {
                sink(&mut displacement);
                above + sinking
            }
            Load::Approach(approach) => approach,
        };
        Self {
            pressure: field(surface, pressure),
            displacement: field(surface, displacement),
            gap: field(surface, gap),
            mean_pressure,
            approach,
            residual,
            effort: Effort::default(),
            plastic,
            lateral: None,
            length_scale,
            surface: Arc::clone(surface),
            contact_modulus,
        }
    }
}

impl Plastic {
    /// Moves the negative gap of the points at the `hardness` to the plastic depth. Also returns Σ p g over the other
    /// points, and their lowest gap.
    fn of(
        surface: &RigidSurface,
        pressure: &[f64],
        gap: &mut [f64],
        hardness: Ceiling,
        length_scale: f64,
    ) -> (Self, (f64, f64)) {
        let n = surface.share().total();
        let mut depth = vec![0.0; gap.len()];
        let (count, sum, saturation, p_gap, lowest) = surface.share().pass(
            (gap, &mut depth[..], pressure, hardness),
            &|_, (gap, depth, pressure, hardness)| {
                let mut sums = (0.0, 0.0, 0.0, 0.0, f64::INFINITY);
                for (i, ((gap, depth), p)) in gap.iter_mut().zip(depth).zip(pressure).enumerate() {
                    let hardness = hardness.at(i);
                    if *p < hardness {
                        sums.3 += p * *gap;
                        sums.4 = lower(sums.4, *gap);
                    } else {
                        let wrong = higher(*gap / length_scale, (p - hardness) / hardness);
                        *depth = positive(-*gap);
                        *gap = positive(*gap);
                        sums = (sums.0 + 1.0, sums.1 + *depth, higher(sums.2, wrong), sums.3, sums.4);
                    }
                }
                sums
            },
            &|a, b| (a.0 + b.0, a.1 + b.1, higher(a.2, b.2), a.3 + b.3, lower(a.4, b.4)),
        );
        let plastic =
            Self { depth: field(surface, depth), fraction: count / n as f64, volume: sum / n as f64, saturation };
        (plastic, (p_gap, lowest))
    }
}

/// Rounding error of a displacement relative to one number; transforms add up a little more than one rounding error.
const ROUNDING_OF_DISPLACEMENT: f64 = 16.0 * f64::EPSILON;

/// Returns the middle between the largest room of the points at the hardness and the smallest room of the others. It is
/// the approach if no pressure lies between the bounds.
pub(crate) fn between(share: &Share, pressure: &[f64], upper: Ceiling, room: impl Fn(usize) -> f64) -> f64 {
    let none = [f64::NEG_INFINITY, f64::INFINITY];
    let own = pressure.iter().enumerate().fold(none, |[below, above], (i, p)| {
        if *p >= upper.at(i) { [below.max(room(i)), above] } else { [below, above.min(room(i))] }
    });
    let all = share.each(own).into_iter();
    let [below, above] = all.fold(none, |[below, above], [low, high]| [below.max(low), above.min(high)]);
    match (below.is_finite(), above.is_finite()) {
        (true, true) => 0.5 * (below + above),
        (true, false) => below,
        _ => above,
    }
}

/// Converts values, row by row, to a field on the rows of this process.
pub(crate) fn field(surface: &RigidSurface, values: Vec<f64>) -> Array2<f64> {
    Array2::from_shape_vec(surface.shape(), values).expect("every field has the rows of this process")
}

/// Returns the larger of two numbers; NaN if either is NaN.
fn higher(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// Returns the lower of each pair of numbers; NaN if either is NaN.
fn lower_each(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [lower(a[0], b[0]), lower(a[1], b[1]), lower(a[2], b[2])]
}

/// Returns the positive part of a number; NaN stays NaN.
fn positive(a: f64) -> f64 {
    if a <= 0.0 { 0.0 } else { a }
}
