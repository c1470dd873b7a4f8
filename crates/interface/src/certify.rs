use std::sync::Arc;

use gfmd_contact::{Drive, Effort, Load, Refusal};
use gfmd_vector::{add, contiguous, for_each};
use ndarray::{Array2, Array3, ArrayRef2};

use crate::frame::Frame;
use crate::kinks::Kinks;
use crate::numbers::{dot, higher, higher_each, lower, reduce, total};
use crate::{Interface, Residual, State};

/// Computes the state at `position`, the displacement in the frame of the drive, from new transforms and the law. At a
/// wall that gives way, `inset` has the insets of all points or is empty.
pub(crate) fn certify(interface: &Interface, frame: &Frame, position: &[f64], inset: &[f64]) -> State {
    certify_level(interface, frame, position, inset, None)
}

/// Computes the state as [`certify`]. Where no point tells the mean pressure, it is the possible one next to `level`.
pub(crate) fn certify_level(
    interface: &Interface,
    frame: &Frame,
    position: &[f64],
    inset: &[f64],
    level: Option<f64>,
) -> State {
    let (points, z) = (frame.points(), frame.z());
    let kinks = interface.kinks(frame);
    let kinks = kinks.as_ref();
    let mut transforms = interface.elastic.transforms();
    let mut traction = vec![0.0; position.len()];
    transforms.stiffness(position, &frame.uniform_stiffness, &mut traction);
    let (gap, wall_pressure) = (vec![0.0; points], vec![0.0; points]);
    let mut certificate = Certificate { interface, frame, position, kinks, inset, level, traction, gap, wall_pressure };
    let lowest = certificate.separations();
    let balances: Vec<Balance> = (0..=z).map(|component| certificate.balance(component)).collect();
    let (mean_pressure, load) = match frame.drive.load {
        // The mean pressure of wall and law; in equilibrium it equals the mean of the elastic traction.
        Load::MeanPressure(asked) => {
            let exerted = frame.mean(&certificate.wall_pressure) - balances[z].law_mean;
            (exerted, exerted - asked)
        }
        Load::Approach(_) => (-frame.mean(&certificate.traction[z * points..]), 0.0),
    };
    let worst = |part: fn(&Balance) -> f64| balances.iter().fold(0.0, |worst, balance| higher(worst, part(balance)));
    let scale = interface.stress_scale(frame.drive.load);
    let stress = higher(higher(worst(|balance| balance.largest), scale), f64::MIN_POSITIVE);
    let noise = 2.0 * balances[z].unbalanced + ROUNDING_OF_TRACTION * balances[z].largest;
    let interface_energy = certificate.interface_energy();
    let contact_fraction = certificate.contact_fraction();
    let (displacement, approach) = certificate.displacement_and_approach(mean_pressure);
    let elastic_energy = 0.5 * dot(frame.share, &certificate.traction, &displacement) / frame.all_inside() as f64;
    let [nx, ny] = interface.surface.shape();
    let vectors = |all: Vec<f64>| Array3::from_shape_vec((z + 1, nx, ny), frame.values_inside(all)).expect(FITS);
    let field = |all: Vec<f64>| Array2::from_shape_vec((nx, ny), frame.values_inside(all)).expect(FITS);
    let Certificate { traction, gap, wall_pressure, .. } = certificate;
    let traction = frame.values_inside(traction);
    let mut mean_shear = [0.0; 2];
    for (mean_shear, shear) in mean_shear.iter_mut().zip(traction.chunks_exact(nx * ny).take(z)) {
        *mean_shear = frame.mean_inside(shear);
    }
    let traction = Array3::from_shape_vec((z + 1, nx, ny), traction).expect(FITS);
    let depth = |kinks: &Kinks| (0..points).map(|i| kinks.pressed_in(i, depth_of(inset, i))).collect();
    let pressed_in = interface.hardness.as_ref().and(kinks).map(|kinks| field(depth(kinks)));
    let (gap, wall_pressure) = (field(gap), field(wall_pressure));
    let pressures = contiguous(&wall_pressure);
    let closed = dot(frame.share_inside(), &pressures, &contiguous(&gap));
    let pressed = total(frame.share_inside(), &pressures);
    let residual = Residual {
        complementarity: if pressed > 0.0 { (closed / (pressed * interface.length_scale())).abs() } else { 0.0 },
        equilibrium: worst(|balance| balance.unbalanced) / stress,
        penetration: if interface.law.has_wall() { higher(-lowest, 0.0) / interface.length_scale() } else { 0.0 },
        wall_tension: worst(|balance| balance.tension) / stress,
        load: load.abs() / stress,
        saturation: pressed_in.as_ref().map(|_| worst(|balance| balance.excess) / stress),
    };
    State {
        displacement: vectors(displacement),
        traction,
        gap,
        wall_pressure,
        pressed_in,
        mean_pressure,
        mean_shear,
        approach,
        lateral: frame.drive.lateral,
        elastic_energy,
        interface_energy,
        contact_fraction,
        residual,
        effort: Effort { iterations: 0, transform_pairs: transforms.pairs() },
        passed_instability: false,
        lowest_curvature: f64::NAN,
        is_pressed: pressed > 0.0,
        noise,
        surface: Arc::clone(&interface.given),
        contact_modulus: interface.contact_modulus,
    }
}

impl Interface {
    /// Computes the state and its residuals from the gap under `drive`, with new transforms. It applies to an interface
    /// in u_z alone, where the gap determines the displacement. With free boundaries, `pressure` determines the
    /// displacement outside the patch; with springs, it determines their displacement; otherwise it is not used.
    ///
    /// With a hardness, it is the state in which nothing is [pressed in](State::pressed_in); see
    /// [`certify_pressed_in`](Self::certify_pressed_in).
    ///
    /// # Errors
    /// Returns an error for an invalid drive, fields that do not match the grid, or an interface in all components.
    pub fn certify(&self, gap: &ArrayRef2<f64>, pressure: &ArrayRef2<f64>, drive: Drive) -> Result<State, Refusal> {
        self.certify_pressed_in(gap, pressure, None, drive)
    }

    /// Returns the names of the fields that [`certify_fields`](Self::certify_fields) needs for a state; empty for an
    /// interface in all components, whose fields do not determine its state.
    pub fn basis(&self) -> &'static [&'static str] {
        match (self.elastic.components(), self.hardness.is_some()) {
            (1, false) => &["gap", "pressure"],
            (1, true) => &["gap", "pressure", "plastic_depth"],
            _ => &[],
        }
    }

    /// Computes the state of the [`basis`](Self::basis) fields as [`certify_pressed_in`](Self::certify_pressed_in).
    ///
    /// # Errors
    /// Returns an error as [`certify`](Self::certify), and for another number of fields.
    pub fn certify_fields(&self, fields: &[&ArrayRef2<f64>], drive: Drive) -> Result<State, Refusal> {
        match (fields, self.basis().len()) {
            ([gap, pressure], 2) => self.certify(gap, pressure, drive),
            ([gap, pressure, depth], 3) => self.certify_pressed_in(gap, pressure, Some(depth), drive),
            (_, expected) => Err(Refusal::Basis { found: fields.len(), expected }),
        }
    }

    /// Computes the state as [`certify`](Self::certify), with the depth by which the surfaces are
    /// [pressed in](State::pressed_in). It counts where the gap is closed.
    ///
    /// # Errors
    /// Returns an error as [`certify`](Self::certify).
    pub fn certify_pressed_in(
        &self,
        gap: &ArrayRef2<f64>,
        pressure: &ArrayRef2<f64>,
        pressed_in: Option<&ArrayRef2<f64>>,
        drive: Drive,
    ) -> Result<State, Refusal> {
        let frame = self.frame(drive)?;
        let expected = frame.components() * frame.inside();
        let sizes = [Some(gap.len()), Some(pressure.len()), pressed_in.map(|depth| depth.len())];
        if let Some(found) = self.share.first(sizes.into_iter().flatten().find(|found| *found != expected)) {
            return Err(Refusal::Start { found, expected });
        }
        let wall: Vec<f64> = frame.values_inside(frame.wall().collect());
        let mut inside: Vec<f64> = wall.iter().zip(gap).map(|(wall, gap)| wall - gap).collect();
        let Some(kinks) = self.kinks(&frame) else {
            return Ok(certify(self, &frame, &frame.position(&self.elastic, inside, pressure), &[]));
        };
        let depth: Vec<f64> = pressed_in.map_or_else(|| vec![0.0; expected], |depth| depth.iter().copied().collect());
        let depth = frame.placed(depth.into_iter(), 0.0);
        let insets = kinks.insets(&frame, [pressure, gap], |at, pressure| {
            let pressure = if depth[at] > 0.0 { f64::INFINITY } else { pressure };
            [pressure, kinks.limit(at) + depth[at]]
        });
        let added = frame.values_inside(insets.clone());
        inside.iter_mut().zip(&added).for_each(|(w, inset)| *w += inset);
        let position = frame.position(&self.elastic, inside, pressure);
        let mut state = certify_level(self, &frame, &position, &insets, Some(self.mean_of(pressure)));
        // A point with an inset has a closed gap, whatever the given one is.
        let lowest = self.share.each(gap.iter().fold(0.0, |least, gap| lower(least, *gap)));
        let lowest = lowest.into_iter().fold(0.0, lower);
        state.residual.penetration = higher(state.residual.penetration, -lowest / self.length_scale());
        Ok(state)
    }
}

impl Interface {
    /// Returns the mean of a field over all processes.
    pub(crate) fn mean_of(&self, field: &ArrayRef2<f64>) -> f64 {
        let share = self.surface.share();
        let points = if share.is_whole() { field.len() } else { share.total() };
        total(share, &contiguous(field)) / points as f64
    }
}

/// Relative rounding error of tractions from transforms of large fields, with a margin.
const ROUNDING_OF_TRACTION: f64 = 100.0 * f64::EPSILON;

/// Reason why reshaping a field cannot fail.
const FITS: &str = "every field of an interface has the size of its grid";

/// Fields of a state during their computation.
struct Certificate<'a> {
    interface: &'a Interface,
    frame: &'a Frame<'a>,
    position: &'a [f64],
    kinks: Option<&'a Kinks>,
    inset: &'a [f64],
    /// Mean pressure where no point tells it.
    level: Option<f64>,
    /// K w at first; the traction on the elastic surface after [`balance`](Self::balance).
    traction: Vec<f64>,
    gap: Vec<f64>,
    wall_pressure: Vec<f64>,
}

/// Equilibrium of one component.
struct Balance {
    /// Largest traction that is not balanced by law or wall.
    unbalanced: f64,
    /// Largest tension required from the wall.
    tension: f64,
    /// Largest traction.
    largest: f64,
    /// Mean traction of the law.
    law_mean: f64,
    /// Largest excess of the repulsion over its largest possible value.
    excess: f64,
}

/// Returns the inset of point `i`; 0 without insets.
fn depth_of(inset: &[f64], i: usize) -> f64 {
    inset.get(i).copied().unwrap_or(0.0)
}

impl Certificate<'_> {
    /// Computes the gap; returns its lowest value, NaN if any value is NaN.
    fn separations(&mut self) -> f64 {
        let Self { frame, position, inset, gap, .. } = self;
        frame.share.pass(
            [&mut gap[..]],
            &|start, [gap]| {
                gap.iter_mut().enumerate().fold(f64::INFINITY, |least, (k, gap)| {
                    (*gap, _) = frame.separation(position, start + k);
                    if depth_of(inset, start + k) > 0.0 {
                        *gap = 0.0;
                    }
                    lower(least, *gap)
                })
            },
            &lower,
        )
    }

    /// Compares the elastic traction of a component with the traction of the law. At points that touch the wall, the
    /// wall balances the difference, by pressure only. If the mean of a component is held, its mean traction is
    /// unknown; it is chosen so that the mean force on the free points vanishes.
    fn balance(&mut self, component: usize) -> Balance {
        let Self { interface, frame, position, kinks, inset, level, traction, gap, wall_pressure } = self;
        let (kinks, inset) = (*kinks, *inset);
        let points = frame.points();
        let normal = component == frame.z();
        let axis = if normal { 2 } else { component };
        // At a wall that gives way, these are the points at kinks.
        let gives = |i: usize| kinks.is_some_and(|kinks| depth_of(inset, i) > 0.0 || kinks.spring(i) > 0.0);
        let touches = |i: usize| normal && interface.law.has_wall() && gap[i] <= 0.0 && !gives(i);
        // The repulsion that the inset determines.
        let repulsion = |i: usize| kinks.map_or(0.0, |kinks| kinks.repulsion(i, depth_of(inset, i)));
        let push = frame.push_on(component);
        let law = |i: usize| {
            let (normal, sliding) = frame.separation(position, i);
            let normal = if depth_of(inset, i) > 0.0 { 0.0 } else { normal };
            interface.law.traction(normal, sliding)[axis]
        };
        let traction = &mut traction[component * points..][..points];
        let [free, net, law_total] = reduce(
            frame.share,
            points,
            &|range| {
                range.fold([0.0; 3], |sums, i| {
                    let law = law(i);
                    let free = if touches(i) { 0.0 } else { 1.0 };
                    add(sums, [free, free * (law - repulsion(i) + push - traction[i]), law])
                })
            },
            &add,
        );
        let unknown = match kinks {
            _ if !frame.held[component] => 0.0,
            _ if free > 0.0 => net / free,
            None => 0.0,
            Some(kinks) => {
                let force: Vec<f64> = (0..points).map(|i| law(i) + push - traction[i]).collect();
                let wanted = level.map(|pressure| push - pressure - frame.mean(traction));
                kinks.level(&force, wanted)
            }
        };
        let most = |i: usize| kinks.map_or(f64::INFINITY, |kinks| kinks.most(i));
        let [unbalanced, tension, largest, excess] = frame.share.pass(
            [&mut *traction],
            &|start, [traction]| {
                traction.iter_mut().enumerate().fold([0.0; 4], |worst, (k, traction)| {
                    *traction += unknown - push;
                    let left = law(start + k) - repulsion(start + k) - *traction;
                    let [free, tension, excess] =
                        if touches(start + k) { [0.0, -left, left - most(start + k)] } else { [left.abs(), 0.0, 0.0] };
                    higher_each(worst, [free, tension, traction.abs(), excess])
                })
            },
            &higher_each,
        );
        if normal && interface.law.has_wall() {
            let press = |start: usize, [pressure]: [&mut [f64]; 1]| {
                for (k, pressure) in pressure.iter_mut().enumerate().filter(|(k, _)| touches(start + k)) {
                    *pressure = (law(start + k) - traction[start + k]).max(0.0).min(most(start + k));
                }
            };
            for_each([&mut wall_pressure[..]], &press);
            let press_in = |start: usize, [pressure]: [&mut [f64]; 1]| {
                for (k, pressure) in pressure.iter_mut().enumerate().filter(|(k, _)| gives(start + k)) {
                    *pressure = repulsion(start + k);
                }
            };
            if kinks.is_some() {
                for_each([&mut wall_pressure[..]], &press_in);
            }
        }
        Balance { unbalanced, tension, largest, law_mean: law_total / frame.all_inside() as f64, excess }
    }

    /// Returns the energy of the law per area.
    fn interface_energy(&self) -> f64 {
        let Self { interface, frame, position, inset, .. } = self;
        let of = |at: usize| {
            let (normal, sliding) = frame.separation(position, at);
            interface.energy((if depth_of(inset, at) > 0.0 { 0.0 } else { normal }, sliding))
        };
        frame.sum_inside(of) / frame.all_inside() as f64
    }

    /// Returns the fraction of points pressed by the wall; without a wall, the fraction of points repelled by the law.
    fn contact_fraction(&self) -> f64 {
        let Self { interface, frame, position, wall_pressure, .. } = self;
        let wall = interface.law.has_wall();
        let in_contact = |i: usize| {
            let (normal, sliding) = frame.separation(position, i);
            if wall { wall_pressure[i] > 0.0 } else { interface.law.traction(normal, sliding)[2] < 0.0 }
        };
        frame.sum_inside(|i| f64::from(in_contact(i))) / frame.all_inside() as f64
    }

    /// Returns the displacement of the elastic surface and the approach of the rigid one. In the frame of a load, the
    /// elastic surface moves instead of the rigid one.
    fn displacement_and_approach(&self, mean_pressure: f64) -> (Vec<f64>, f64) {
        let Self { interface, frame, position, .. } = self;
        let mut displacement = position.to_vec();
        let Load::MeanPressure(_) = frame.drive.load else { return (displacement, frame.approach) };
        let normal = &mut displacement[frame.z() * frame.points()..];
        let inside = frame.all_inside() as f64 / frame.all_points() as f64;
        let mean = total(frame.share, normal) / frame.all_points() as f64;
        let approach = mean + interface.elastic.uniform_compliance()[frame.z()] * mean_pressure * inside;
        normal.iter_mut().for_each(|u| *u -= approach);
        (displacement, approach)
    }
}
