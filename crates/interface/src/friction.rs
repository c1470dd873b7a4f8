//! Friction behind a hard wall, solved in the tractions: the normal contact under the shear of the last round, then the
//! shear under the limits that its pressure sets (Panagiotopoulos 1975), until both fit.

use std::ops::ControlFlow;

use gfmd_law::{LawError, Limit};
use gfmd_relax::{Budget, Ending, Minimum, ProjectedCg, Quadratic, RelaxError, Target};
use gfmd_response::{FullResponse, Workspace};
use gfmd_vector::{add, for_each, reduce};
use ndarray::{Array2, Array3, ArrayView2};

use crate::certify::higher;
use crate::elastic::mean;
use crate::problem::{Progress, Settings, Watch, heights_to_clearance};
use crate::{Drive, InterfaceError, Normal};

/// A rigid rough surface pressed on an elastic one and moved sideways, with a hard wall and friction.
///
/// Friction remembers: a drive is one increment, from the state before it. Where |shear| is below its limit the surfaces
/// stick, that is, move together during the increment; where it is at the limit they may slip against it. A surface that
/// comes into contact counts its slip from where it was before.
///
/// With [`Limit::Tresca`] the limit jumps at the edge of the contact. On a body whose shear moves the surface up and down
/// (all but ν = ½) a point of the edge may then have no state at all: in contact, its shear lifts it off. That shows as
/// [`InterfaceError::FrictionNotConverged`].
pub struct FrictionalContact<'a> {
    response: &'a FullResponse,
    clearance: Vec<f64>,
    rms_height: f64,
    limit: Limit,
}

/// A frictional contact at rest. Fields are `[x, y]`, vectors `[component, x, y]` with z the last component.
#[derive(Clone, Debug, PartialEq)]
pub struct FrictionState {
    /// Displacement of the elastic surface, length.
    pub displacement: Array3<f64>,
    /// Traction on the elastic surface, stress; its z component is −pressure.
    pub traction: Array3<f64>,
    /// Distance between the surfaces, length.
    pub gap: Array2<f64>,
    /// How far the elastic surface slipped over the rigid one in this increment, length; x, or x and y.
    pub slip: Array3<f64>,
    /// Mean pressure over the whole surface, stress.
    pub mean_pressure: f64,
    /// Mean shear traction on the elastic surface along x and y, stress.
    pub mean_shear: [f64; 2],
    /// Rigid approach beyond first touch of the undeformed surfaces, length.
    pub approach: f64,
    /// Lateral displacement of the rigid surface, length.
    pub lateral: [f64; 2],
    /// Share of the points that are pressed.
    pub contact_fraction: f64,
    /// Share of the points that are pressed and stick.
    pub stick_fraction: f64,
    /// Elastic energy per area, stress × length.
    pub elastic_energy: f64,
    /// Work done against friction in this increment, per area.
    pub dissipated: f64,
    /// Distance from equilibrium, computed from the fields above.
    pub residual: FrictionResidual,
    /// Steps of both solvers.
    pub iterations: u64,
    /// Forward and inverse transforms of one component, in pairs.
    pub transform_pairs: u64,
}

/// How far a state is from satisfying the conditions of contact and friction; zero of the exact one. p is the pressure, τ
/// the shear on the elastic surface, s the slip of the increment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrictionResidual {
    /// Σ p g / (Σ p · h_rms), in magnitude.
    pub complementarity: f64,
    /// max(0, −min g) / h_rms.
    pub penetration: f64,
    /// |p̄ − asked| / asked; 0 where the approach is prescribed.
    pub load: f64,
    /// Largest |τ − P(τ − c s)| over the largest limit, P the projection on |τ| ≤ limit of the point and c the largest limit
    /// over h_rms: slip where the surfaces should stick, or not against the shear.
    pub friction: f64,
    /// Largest excess of |τ| over its limit, over the largest limit.
    pub excess: f64,
}

impl FrictionResidual {
    /// The largest; NaN if any is.
    pub fn worst(&self) -> f64 {
        let Self { complementarity, penetration, load, friction, excess } = *self;
        [complementarity, penetration, load, friction, excess].into_iter().fold(0.0, |a, b| higher([a], [b])[0])
    }
}

impl std::fmt::Display for FrictionResidual {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { complementarity, penetration, load, friction, excess } = self;
        write!(
            f,
            "complementarity {complementarity:.2e}, penetration {penetration:.2e}, load {load:.2e}, \
             friction {friction:.2e}, excess {excess:.2e}"
        )
    }
}

/// Rounds of normal and tangential problem.
const ROUNDS: usize = 150;
/// After so many rounds they may go in circles: each then answers to a part of what the other changed.
const WHOLE_ROUNDS: usize = 20;
const PART: f64 = 0.3;
/// Each part is solved this much better than asked, so that the whole can be.
const SHARE: f64 = 0.1;

impl<'a> FrictionalContact<'a> {
    /// `heights` is the rigid profile, peaks pointing at the body, length; only differences matter.
    ///
    /// # Errors
    /// Heights of another shape than the grid, not finite, or all equal; a negative limit.
    pub fn new(response: &'a FullResponse, heights: ArrayView2<f64>, limit: Limit) -> Result<Self, InterfaceError> {
        // The return map knows what a limit may be.
        gfmd_law::Friction::new(limit, 1.0)?;
        let (clearance, rms_height) = heights_to_clearance(heights, response.grid())?;
        if rms_height == 0.0 {
            return Err(InterfaceError::Flat);
        }
        Ok(Self { response, clearance, rms_height, limit })
    }

    /// Brings the contact to rest at the end of an increment that begins with `start`, or with the undeformed surface.
    ///
    /// # Errors
    /// Unusable drive, settings or start; or an error that carries the state reached.
    pub fn solve(
        &self,
        drive: Drive,
        settings: &Settings,
        start: Option<&FrictionState>,
        watch: Watch,
    ) -> Result<FrictionState, InterfaceError> {
        settings.check()?;
        self.check(drive)?;
        let expected = self.response.components().len() * self.clearance.len();
        if let Some(found) = start.map(|state| state.displacement.len()).filter(|found| *found != expected) {
            return Err(InterfaceError::Start { found, expected });
        }
        let mut increment = Increment::new(self, drive, start);
        let mut iterations = 0;
        let mut reason = "normal and tangential problem do not settle";
        for round in 0..ROUNDS {
            // The first rounds only have to be as good as the next one can use.
            let tolerance = SHARE * settings.tolerance.max(1e-2 * 0.1_f64.powi(2 * round as i32));
            let limit = settings.max_iterations.saturating_sub(iterations);
            let pressed = increment.press(tolerance, limit, &mut |now: &gfmd_relax::Progress| {
                watch(&Progress { iteration: iterations + now.iteration, residual: now.residual })
            });
            let interrupted = match pressed {
                Ok(Minimum { reached, ending: Ending::Converged }) => {
                    iterations += reached.iteration;
                    false
                }
                Ok(Minimum { ending: Ending::Interrupted, .. }) => true,
                Ok(Minimum { ending: Ending::GaveUp(_), .. }) | Err(_) => {
                    reason = "the normal problem does not converge";
                    break;
                }
            };
            let (steps, stopped) = increment.shear(tolerance, limit, &mut |steps, residual| {
                watch(&Progress { iteration: iterations + steps, residual })
            });
            increment.respond();
            increment.lift(if round < WHOLE_ROUNDS { 1.0 } else { PART });
            iterations += steps;
            let mut state = increment.certify();
            state.iterations = iterations;
            if interrupted || stopped {
                return Err(InterfaceError::FrictionInterrupted { state: Box::new(state) });
            }
            if state.residual.worst() <= settings.tolerance {
                return Ok(state);
            }
        }
        let mut state = Box::new(increment.certify());
        state.iterations = iterations;
        Err(InterfaceError::FrictionNotConverged { state, asked: settings.tolerance, reason })
    }

    /// Whether a drive can be posed.
    ///
    /// # Errors
    /// Numbers that are not finite, a drive without contact, or an approach beyond full contact.
    pub fn check(&self, drive: Drive) -> Result<(), InterfaceError> {
        drive.check()?;
        match drive.normal {
            Normal::MeanPressure(found) if found <= 0.0 => {
                return Err(InterfaceError::NotPressed { what: "mean pressure", found });
            }
            Normal::Approach(found) if found <= 0.0 => {
                return Err(InterfaceError::NotPressed { what: "approach", found });
            }
            Normal::Approach(found) => {
                let limit = mean(&self.clearance);
                if self.response.uniform_compliance()[2] == 0.0 && found >= limit {
                    return Err(InterfaceError::Approach { found, limit });
                }
            }
            Normal::MeanPressure(_) => {}
        }
        Ok(())
    }
}

/// One increment while it is solved.
struct Increment<'a> {
    contact: &'a FrictionalContact<'a>,
    drive: Drive,
    workspace: Workspace,
    normal_workspace: gfmd_field::Workspace,
    /// G_zz of every mode.
    normal_compliance: Vec<f64>,
    points: usize,
    /// Index of the z component.
    z: usize,
    /// What the lateral displacement of the elastic surface is if nothing slips.
    stuck: Vec<f64>,
    pressure: Vec<f64>,
    /// The traction on the elastic surface, all components; z is 0 but while it is certified.
    shear: Vec<f64>,
    /// G of the shear.
    sheared: Vec<f64>,
    /// Clearance less the u_z of the shear (and the approach, where it is prescribed).
    linear: Vec<f64>,
    pairs: u64,
}

/// The lengths are those of the grid, by construction: a transform cannot refuse them.
const FITS: &str = "every field of a contact has the size of its grid";

impl<'a> Increment<'a> {
    fn new(contact: &'a FrictionalContact<'a>, drive: Drive, start: Option<&FrictionState>) -> Self {
        let response = contact.response;
        let points = contact.clearance.len();
        let z = response.components().normal();
        let size = (z + 1) * points;
        let mut pressure = vec![0.0; points];
        let mut shear = vec![0.0; size];
        let mut stuck: Vec<f64> = (0..z * points).map(|k| drive.lateral[k / points]).collect();
        if let Some(state) = start {
            let values = || state.traction.iter().enumerate();
            values().filter(|(k, _)| k / points == z).for_each(|(k, t)| pressure[k % points] = (-t).max(0.0));
            values().filter(|(k, _)| k / points < z).for_each(|(k, t)| shear[k] = *t);
            for (k, (stuck, u)) in stuck.iter_mut().zip(&state.displacement).enumerate() {
                *stuck += u - state.lateral[k / points];
            }
        } else if let Normal::MeanPressure(mean) = drive.normal {
            pressure.fill(mean);
        }
        let mut increment = Self {
            contact,
            drive,
            workspace: response.workspace(),
            normal_workspace: response.compliance().transform().workspace(),
            normal_compliance: response.compliance().matrices().iter().map(|matrix| matrix.zz).collect(),
            points,
            z,
            stuck,
            pressure,
            sheared: vec![0.0; size],
            shear,
            linear: contact.clearance.clone(),
            pairs: 0,
        };
        increment.respond();
        increment.lift(1.0);
        increment
    }

    /// `sheared` ← G shear.
    fn respond(&mut self) {
        self.pairs += self.z as u64 + 1;
        self.contact.response.compliance().apply(&self.shear, &mut self.sheared, &mut self.workspace).expect(FITS);
    }

    /// Tells the normal problem what the shear does to it; `share` of the change only.
    fn lift(&mut self, share: f64) {
        let Self { contact, sheared, linear, points, z, drive, .. } = self;
        let approach = if let Normal::Approach(approach) = drive.normal { approach } else { 0.0 };
        let lifted = &sheared[*z * *points..];
        for ((linear, clearance), u) in linear.iter_mut().zip(&contact.clearance).zip(lifted) {
            *linear += share * (clearance - u - approach - *linear);
        }
    }

    /// The pressure under the present shear.
    fn press(&mut self, tolerance: f64, limit: u64, watch: &mut dyn gfmd_relax::Watch) -> Result<Minimum, RelaxError> {
        let target = Target {
            mean: if let Normal::MeanPressure(mean) = self.drive.normal { Some(mean) } else { None },
            gradient_scale: self.contact.rms_height,
            budget: Budget { tolerance, max_iterations: limit },
        };
        let mut pressure = std::mem::take(&mut self.pressure);
        let outcome = ProjectedCg.minimise(self, &mut pressure, &target, watch);
        self.pressure = pressure;
        outcome
    }

    fn largest_shear(&self, i: usize) -> f64 {
        if self.pressure[i] > 0.0 { self.contact.limit.at(self.pressure[i]) } else { 0.0 }
    }

    /// The shear under the present pressure: ½⟨τ, G τ⟩ + ⟨τ, s₀⟩ → min over |τ| ≤ limit, with s₀ the slip without shear.
    /// Projected gradients with the step lengths of Barzilai and Borwein, each ended at the lowest point of its segment.
    fn shear(&mut self, tolerance: f64, limit: u64, watch: &mut dyn FnMut(u64, f64) -> ControlFlow<()>) -> (u64, bool) {
        let (n, z) = (self.points, self.z);
        let size = self.shear.len();
        // u of the pressure alone.
        let mut pressed = vec![0.0; size];
        pressed[z * n..].iter_mut().zip(&self.pressure).for_each(|(t, p)| *t = -p);
        let mut slip = vec![0.0; size];
        self.pairs += z as u64 + 1;
        self.contact.response.compliance().apply(&pressed, &mut slip, &mut self.workspace).expect(FITS);
        slip[..z * n].iter_mut().zip(&self.stuck).for_each(|(s, stuck)| *s -= stuck);
        let limits: Vec<f64> = (0..n).map(|i| self.largest_shear(i)).collect();
        let strongest = limits.iter().copied().fold(0.0, f64::max);
        bring_within(&mut self.shear, &limits, n, z);
        self.respond();
        slip[..z * n].iter_mut().zip(&self.sheared).for_each(|(s, u)| *s += u);
        let mut direction = vec![0.0; size];
        let mut image = vec![0.0; size];
        // Stress over length: that of the shortest wave to begin with.
        let mut length = self.contact.response.stiffness_range()[1];
        let mut steps = 0;
        if strongest > 0.0 {
            loop {
                let residual =
                    mismatch(&self.shear[..z * n], &slip[..z * n], &limits, strongest, self.contact.rms_height);
                let stop = watch(steps, residual).is_break();
                if residual <= tolerance || steps == limit || stop {
                    return (steps, stop);
                }
                steps += 1;
                direction.copy_from_slice(&self.shear);
                let downhill = |start: usize, [d]: [&mut [f64]; 1]| {
                    d.iter_mut().zip(&slip[start..]).for_each(|(d, s)| *d -= length * s);
                };
                for_each([&mut direction[..z * n]], &downhill);
                bring_within(&mut direction, &limits, n, z);
                let back = |start: usize, [d]: [&mut [f64]; 1]| {
                    d.iter_mut().zip(&self.shear[start..]).for_each(|(d, t)| *d -= t);
                };
                for_each([&mut direction], &back);
                self.pairs += z as u64 + 1;
                self.contact.response.compliance().apply(&direction, &mut image, &mut self.workspace).expect(FITS);
                let [slope, curvature, square, images] = reduce(
                    z * n,
                    &|range| {
                        range.fold([0.0; 4], |sums, k| {
                            let (d, g) = (direction[k], if limits[k % n] > 0.0 { image[k] } else { 0.0 });
                            add(sums, [d * slip[k], d * g, d * d, g * g])
                        })
                    },
                    &add,
                );
                // Not even a direction is left: the shear is as good as numbers can tell.
                if slope >= 0.0 || curvature <= 0.0 {
                    return (steps, false);
                }
                let share = (-slope / curvature).min(1.0);
                let go = |start: usize, [t, s]: [&mut [f64]; 2]| {
                    let along = direction[start..].iter().zip(&image[start..]);
                    for ((t, s), (d, g)) in t.iter_mut().zip(s).zip(along) {
                        *t += share * d;
                        *s += share * g;
                    }
                };
                for_each([&mut self.shear[..z * n], &mut slip[..z * n]], &go);
                length = if steps % 2 == 0 { square / curvature } else { curvature / images };
            }
        }
        (steps, false)
    }

    /// Everything from fresh transforms of the tractions.
    fn certify(&mut self) -> FrictionState {
        let (n, z) = (self.points, self.z);
        let contact = self.contact;
        let mut traction = self.shear.clone();
        traction[z * n..].iter_mut().zip(&self.pressure).for_each(|(t, p)| *t = -p);
        let mut displacement = vec![0.0; traction.len()];
        self.pairs += z as u64 + 1;
        contact.response.compliance().apply(&traction, &mut displacement, &mut self.workspace).expect(FITS);
        let mean_pressure = mean(&self.pressure);
        let uz = &displacement[z * n..];
        let [touching, distance] = reduce(
            n,
            &|range| {
                range
                    .filter(|i| self.pressure[*i] > 0.0)
                    .fold([0.0; 2], |sums, i| add(sums, [1.0, contact.clearance[i] - uz[i]]))
            },
            &add,
        );
        let (approach, asked) = match self.drive.normal {
            Normal::MeanPressure(asked) => (distance / touching, Some(asked)),
            Normal::Approach(approach) => (approach, None),
        };
        let gap: Vec<f64> = contact.clearance.iter().zip(uz).map(|(c, u)| c - u - approach).collect();
        let slip: Vec<f64> = displacement.iter().zip(&self.stuck).map(|(u, stuck)| u - stuck).collect();
        let limits: Vec<f64> = (0..n).map(|i| self.largest_shear(i)).collect();
        let magnitude = |i: usize| (0..z).map(|c| traction[c * n + i].powi(2)).sum::<f64>().sqrt();
        let [sticking, dissipated, closed] = reduce(
            n,
            &|range| {
                range.fold([0.0; 3], |sums, i| {
                    let sticks = limits[i] > 0.0 && magnitude(i) < limits[i] * (1.0 - 1e-9);
                    let work: f64 = (0..z).map(|c| -traction[c * n + i] * slip[c * n + i]).sum();
                    add(sums, [f64::from(sticks), work, self.pressure[i] * gap[i]])
                })
            },
            &add,
        );
        let [below, excess] = reduce(
            n,
            &|range| range.fold([0.0; 2], |worst, i| higher(worst, [-gap[i], magnitude(i) - limits[i]])),
            &higher,
        );
        let strongest = limits.iter().copied().fold(0.0, f64::max);
        let residual = FrictionResidual {
            complementarity: if mean_pressure > 0.0 {
                (closed / (mean_pressure * n as f64 * contact.rms_height)).abs()
            } else {
                0.0
            },
            penetration: below / contact.rms_height,
            load: asked.map_or(0.0, |asked| (mean_pressure - asked).abs() / asked),
            friction: if strongest > 0.0 {
                mismatch(&traction[..z * n], &slip, &limits, strongest, contact.rms_height)
            } else {
                0.0
            },
            excess: if strongest > 0.0 { excess / strongest } else { 0.0 },
        };
        let means: Vec<f64> = traction.chunks_exact(n).map(mean).collect();
        let elastic_energy = 0.5 * gfmd_vector::dot(&traction, &displacement) / n as f64;
        let [nx, ny] = contact.response.grid().points();
        let vectors = |values: Vec<f64>| Array3::from_shape_vec((values.len() / n, nx, ny), values).expect(FITS);
        FrictionState {
            gap: Array2::from_shape_vec((nx, ny), gap).expect(FITS),
            slip: vectors(slip),
            displacement: vectors(displacement),
            traction: vectors(traction),
            mean_pressure,
            mean_shear: std::array::from_fn(|c| if c < z { means[c] } else { 0.0 }),
            approach,
            lateral: self.drive.lateral,
            contact_fraction: touching / n as f64,
            stick_fraction: sticking / n as f64,
            elastic_energy,
            dissipated: dissipated / n as f64,
            residual,
            iterations: 0,
            transform_pairs: self.pairs,
        }
    }
}

/// The normal problem: ½⟨p, G_zz p⟩ + ⟨p, linear⟩ over p ≥ 0.
impl Quadratic for Increment<'_> {
    fn linear(&self) -> &[f64] {
        &self.linear
    }

    fn apply(&mut self, x: &[f64], out: &mut [f64]) {
        self.pairs += 1;
        let transform = self.contact.response.compliance().transform();
        transform.convolve(&self.normal_compliance, x, out, &mut self.normal_workspace).expect(FITS);
    }

    fn curvature(&mut self, direction: &[f64]) -> f64 {
        self.pairs += 1;
        let transform = self.contact.response.compliance().transform();
        let mean = transform.quadratic_form(&self.normal_compliance, direction, &mut self.normal_workspace);
        mean.expect(FITS) * direction.len() as f64
    }

    fn precondition(&mut self, _: &[f64], gradient: &[f64], _: f64, out: &mut [f64]) {
        out.copy_from_slice(gradient);
    }
}

/// Largest |τ − P(τ − c s)| over the largest limit, with c the largest limit over `length`. (A sum of limit |s| + τ·s
/// would vanish with the square of the error in the direction.)
fn mismatch(shear: &[f64], slip: &[f64], limits: &[f64], strongest: f64, length: f64) -> f64 {
    let n = limits.len();
    let components = slip.len() / n;
    let stiffness = strongest / length;
    let of_point = |i: usize| {
        let mut moved = [0.0; 2];
        for c in 0..components {
            moved[c] = shear[c * n + i] - stiffness * slip[c * n + i];
        }
        let magnitude = moved[0].hypot(moved[1]);
        let factor = if magnitude > limits[i] { limits[i] / magnitude } else { 1.0 };
        let off: f64 = (0..components).map(|c| (shear[c * n + i] - factor * moved[c]).powi(2)).sum();
        off.sqrt()
    };
    let [worst] = reduce(n, &|range| range.fold([0.0], |worst, i| higher(worst, [of_point(i)])), &higher);
    worst / strongest
}

/// Shortens the lateral components to their limit, point by point.
fn bring_within(shear: &mut [f64], limits: &[f64], n: usize, z: usize) {
    let factor = |square: f64, limit: f64| {
        let magnitude = square.sqrt();
        if magnitude > limit { limit / magnitude } else { 1.0 }
    };
    let (x, rest) = shear.split_at_mut(n);
    if z == 1 {
        let leaf = |start: usize, [x]: [&mut [f64]; 1]| {
            x.iter_mut().zip(&limits[start..]).for_each(|(x, limit)| *x *= factor(*x * *x, *limit));
        };
        for_each([x], &leaf);
    } else {
        let leaf = |start: usize, [x, y]: [&mut [f64]; 2]| {
            for ((x, y), limit) in x.iter_mut().zip(y).zip(&limits[start..]) {
                let factor = factor(*x * *x + *y * *y, *limit);
                *x *= factor;
                *y *= factor;
            }
        };
        for_each([x, &mut rest[..n]], &leaf);
    }
}

impl From<LawError> for InterfaceError {
    fn from(error: LawError) -> Self {
        Self::Law(error)
    }
}
