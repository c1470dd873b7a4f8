use crate::{DislocationError, Domain, Edge, State, Step};

/// Slip system: parallel slip planes that meet the surface.
///
/// A position on a plane is the distance along the slip direction (cos, sin of the angle) from the surface; negative
/// inside the body.
#[derive(Clone, Debug, PartialEq)]
pub struct SlipSystem {
    /// Angle of the slip direction with the x axis, in radians: between 0 and π, both excluded.
    pub angle: f64,
    /// Length of the Burgers vector.
    pub burgers: f64,
    /// Coordinate x of each plane at the surface.
    pub planes: Vec<f64>,
    /// Drag: force per length of line divided by velocity (stress × time).
    pub drag: f64,
    /// Distance (length) at which dislocations of opposite sign annihilate and at which they leave through the surface.
    pub capture: f64,
}

/// Dislocation on a slip plane. With sign +1 it moves forward, towards the surface, under a positive resolved shear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dislocation {
    /// Index of its plane.
    pub plane: usize,
    /// Position on the plane, negative.
    pub place: f64,
    /// Sign, +1 or −1.
    pub sign: f64,
    /// Obstacle that holds the dislocation.
    pub obstacle: Option<usize>,
}

/// Frank-Read source: a point that emits a pair of dislocations of opposite signs after the resolved shear stress has
/// exceeded its strength for some time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Source {
    /// Index of its plane.
    pub plane: usize,
    /// Position on the plane.
    pub place: f64,
    /// Strength, a shear stress.
    pub strength: f64,
    /// Time for which the stress must exceed the strength.
    pub delay: f64,
}

/// Point that holds dislocations until the resolved shear stress on them exceeds its strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// Index of its plane.
    pub plane: usize,
    /// Position on the plane.
    pub place: f64,
    /// Strength, a shear stress.
    pub strength: f64,
}

/// Changes of the energy (per length along the lines) since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Work of the punch.
    pub work: f64,
    /// Energy lost to drag.
    pub dissipated: f64,
    /// Change of the energy in nucleations, annihilations and departures, which are jumps.
    pub jumps: f64,
    /// Energy now minus energy at the start.
    pub stored: f64,
}

impl Balance {
    /// Returns work and jumps minus dissipated and stored energy: the error of the time steps.
    pub fn error(&self) -> f64 {
        self.work + self.jumps - self.dissipated - self.stored
    }
}

/// Numbers of events since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Events {
    /// Number of pairs emitted by sources.
    pub nucleated: usize,
    /// Number of pairs that annihilated.
    pub annihilated: usize,
    /// Number of dislocations that left through the surface.
    pub departed: usize,
    /// Number of motions that were shortened to keep equal dislocations on one plane from passing each other; zero if
    /// the step is small enough.
    pub shortened: usize,
}

/// Time step that may still be refused.
struct Trial {
    moved: Vec<Dislocation>,
    depth: f64,
    state: State,
    dissipated: f64,
    shortened: usize,
    error: f64,
}

/// Shortest step of [`Crystal::advance_within`] divided by the total time.
const SHORTEST: f64 = 1e-4;

/// Dislocations on one slip system in a [`Domain`], which glide against a drag while a punch is pressed in.
#[derive(Clone, Debug)]
pub struct Crystal {
    domain: Domain,
    slip: SlipSystem,
    dislocations: Vec<Dislocation>,
    sources: Vec<(Source, f64)>,
    obstacles: Vec<Obstacle>,
    depth: f64,
    state: State,
    balance: Balance,
    events: Events,
}

impl Crystal {
    /// Makes a crystal with initial `dislocations` below a punch that touches without load. Their partners are assumed
    /// to have left through the surface, so that all Burgers vectors on a plane add up to zero.
    ///
    /// # Errors
    /// Values out of range; positions outside the body; planes that do not exist.
    pub fn new(
        domain: Domain,
        slip: SlipSystem,
        dislocations: &[Dislocation],
        sources: &[Source],
        obstacles: &[Obstacle],
    ) -> Result<Self, DislocationError> {
        let between = slip.angle > 0.0 && slip.angle < std::f64::consts::PI;
        let refuse = |what, found, allowed| Err(DislocationError::Value { what, found, allowed });
        if !between {
            return refuse("angle of the slip planes", slip.angle, "above 0 and below pi");
        }
        for (what, found) in [("Burgers vector", slip.burgers), ("drag", slip.drag), ("capture distance", slip.capture)]
        {
            if !(found > 0.0 && found.is_finite()) {
                return refuse(what, found, "positive and finite");
            }
        }
        if let Some(found) = slip.planes.iter().find(|x| !x.is_finite()) {
            return refuse("place of a slip plane", *found, "finite");
        }
        let lowest = domain.height().map_or(f64::NEG_INFINITY, |height| -height / slip.angle.sin());
        let places = dislocations.iter().map(|d| (d.plane, d.place));
        let places = places.chain(sources.iter().map(|s| (s.plane, s.place)));
        for (plane, found) in places.chain(obstacles.iter().map(|o| (o.plane, o.place))) {
            if plane >= slip.planes.len() {
                return Err(DislocationError::Plane { found: plane, planes: slip.planes.len() });
            }
            if !(found < 0.0 && found > lowest && found.is_finite()) {
                return Err(DislocationError::Place { plane, found, lowest });
            }
        }
        if let Some(found) = dislocations.iter().map(|d| d.sign).find(|sign| sign.abs() != 1.0) {
            return refuse("sign of a dislocation", found, "1 or -1");
        }
        let strengths = sources.iter().map(|s| s.strength).chain(obstacles.iter().map(|o| o.strength));
        if let Some(found) = strengths.into_iter().find(|strength| strength.is_nan() || *strength <= 0.0) {
            return refuse("strength of a source or obstacle", found, "positive");
        }
        if let Some(found) = sources.iter().map(|s| s.delay).find(|delay| delay.is_nan() || *delay < 0.0) {
            return refuse("delay of a source", found, "not negative");
        }
        let state = equilibrium(&domain, &slip, dislocations, 0.0)?;
        Ok(Self {
            domain,
            slip,
            dislocations: dislocations.to_vec(),
            sources: sources.iter().map(|source| (*source, 0.0)).collect(),
            obstacles: obstacles.to_vec(),
            depth: 0.0,
            state,
            balance: Balance::default(),
            events: Events::default(),
        })
    }

    /// Returns the dislocations.
    pub fn dislocations(&self) -> &[Dislocation] {
        &self.dislocations
    }

    /// Returns the depth of the punch.
    pub fn depth(&self) -> f64 {
        self.depth
    }

    /// Returns the current surface and fields.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the energy balance since the start.
    pub fn balance(&self) -> Balance {
        self.balance
    }

    /// Returns the events since the start.
    pub fn events(&self) -> Events {
        self.events
    }

    /// Advances by `time` in one step, while the punch moves down by `indent` (length): glide by Heun's rule, of second
    /// order in the step, then events.
    ///
    /// # Errors
    /// A step that is not positive and finite; a surface that does not reach equilibrium.
    pub fn advance(&mut self, time: f64, indent: f64) -> Result<(), DislocationError> {
        let trial = self.glide(time, indent)?;
        self.accept(trial, time, indent)
    }

    /// Advances like [`advance`](Self::advance) in as many steps as needed for an error of each dislocation of at most
    /// `accuracy` (length) per step: half the difference of its velocities at both ends, times the step. A step is at
    /// least 1e-4 of `time`.
    ///
    /// # Errors
    /// As [`advance`](Self::advance); an accuracy that is not positive.
    pub fn advance_within(&mut self, time: f64, indent: f64, accuracy: f64) -> Result<(), DislocationError> {
        if accuracy.is_nan() || accuracy <= 0.0 {
            return Err(DislocationError::Value { what: "accuracy", found: accuracy, allowed: "positive" });
        }
        let (mut left, mut part) = (1.0, 1.0);
        while left > 0.0 {
            let now = if part < 0.999 * left { part } else { left };
            let trial = self.glide(now * time, now * indent)?;
            if trial.error > accuracy && now > SHORTEST {
                part = 0.5 * now;
                continue;
            }
            part = if trial.error < 0.25 * accuracy { 2.0 * now } else { now };
            left = if now == left { 0.0 } else { left - now };
            self.accept(trial, now * time, now * indent)?;
        }
        Ok(())
    }

    /// Performs a step of Heun's rule, without events.
    fn glide(&self, time: f64, indent: f64) -> Result<Trial, DislocationError> {
        if !(time > 0.0 && time.is_finite()) {
            return Err(DislocationError::Value { what: "time step", found: time, allowed: "positive and finite" });
        }
        let depth = self.depth + indent;
        let before = self.forces(&self.state, &self.dislocations)?;
        let held = self.held(&before);
        let first = self.velocities(&before, &held);
        let (guess, _) = self.moved(&held, first.iter().map(|v| v * time));
        let guessed = equilibrium(&self.domain, &self.slip, &guess, depth)?;
        let after = self.forces(&guessed, &guess)?;
        let second = self.velocities(&after, &held);
        let error = first.iter().zip(&second).fold(0.0, |most: f64, (a, b)| most.max(0.5 * (a - b).abs() * time));
        let (moved, shortened) = self.moved(&held, first.iter().zip(&second).map(|(a, b)| 0.5 * (a + b) * time));
        let state = equilibrium(&self.domain, &self.slip, &moved, depth)?;
        let glides = moved.iter().zip(&self.dislocations).map(|(new, old)| new.place - old.place);
        let dissipated = glides.zip(before.iter().zip(&after)).map(|(glide, (a, b))| 0.5 * (a + b) * glide).sum();
        Ok(Trial { moved, depth, state, dissipated, shortened, error })
    }

    fn accept(&mut self, trial: Trial, time: f64, indent: f64) -> Result<(), DislocationError> {
        let length = self.domain.grid().lengths()[0];
        self.balance.work += 0.5 * length * (self.state.mean_pressure() + trial.state.mean_pressure()) * indent;
        self.balance.dissipated += trial.dissipated;
        self.balance.stored += trial.state.energy() - self.state.energy();
        self.events.shortened += trial.shortened;
        (self.dislocations, self.depth, self.state) = (trial.moved, trial.depth, trial.state);
        self.happen(time)
    }

    /// Returns the glide force on each dislocation, the force along the slip direction per length of line.
    fn forces(&self, state: &State, dislocations: &[Dislocation]) -> Result<Vec<f64>, DislocationError> {
        let along = self.slip.direction();
        (0..dislocations.len())
            .map(|index| {
                let stress = state.stress(state.edges()[index].place, Some(index))?;
                Ok(dislocations[index].sign * self.slip.burgers * stress.resolved(along))
            })
            .collect()
    }

    /// Returns the obstacle that still holds each dislocation.
    fn held(&self, forces: &[f64]) -> Vec<Option<usize>> {
        let strong = |obstacle: usize, force: f64| force.abs() <= self.obstacles[obstacle].strength * self.slip.burgers;
        let all = self.dislocations.iter().zip(forces);
        all.map(|(dislocation, force)| dislocation.obstacle.filter(|obstacle| strong(*obstacle, *force))).collect()
    }

    fn velocities(&self, forces: &[f64], held: &[Option<usize>]) -> Vec<f64> {
        held.iter().zip(forces).map(|(held, force)| if held.is_some() { 0.0 } else { force / self.slip.drag }).collect()
    }

    /// Returns the dislocations after `glides`, which end at obstacles, before other dislocations, at the surface and
    /// at the base, and the number of dislocations shortened by equal ones.
    fn moved(&self, held: &[Option<usize>], glides: impl Iterator<Item = f64>) -> (Vec<Dislocation>, usize) {
        let mut shortened = 0;
        let lowest = self.domain.height().map(|height| -height / self.slip.angle.sin());
        let glide = |(index, (old, glide)): (usize, (&Dislocation, f64))| {
            let mut place = old.place + glide;
            // Almost half-way to the next dislocation: opposite ones meet there, within reach of each other.
            let others =
                self.dislocations.iter().enumerate().filter(|(other, d)| *other != index && d.plane == old.plane);
            let next = others
                .filter(|(_, d)| (d.place - old.place) * glide > 0.0)
                .min_by(|(_, a), (_, b)| (a.place - old.place).abs().total_cmp(&(b.place - old.place).abs()));
            if let Some((_, next)) = next {
                let distance = next.place - old.place;
                let half = 0.5 * (distance - (0.5 * self.slip.capture).min(0.5 * distance.abs()).copysign(distance));
                if glide.abs() > half.abs() {
                    place = old.place + half;
                    shortened += usize::from(next.sign == old.sign);
                }
            }
            let mut obstacle = held[index];
            for (number, o) in self.obstacles.iter().enumerate().filter(|(_, o)| o.plane == old.plane) {
                let passed = (old.place < o.place && o.place <= place) || (place <= o.place && o.place < old.place);
                if passed {
                    (place, obstacle) = (o.place, Some(number));
                }
            }
            // Dislocations beyond the surface leave in the events of this step.
            place = place.min(-0.5 * self.slip.capture);
            if let Some(lowest) = lowest {
                place = place.max(lowest + self.slip.capture);
            }
            Dislocation { place, obstacle, ..*old }
        };
        let moved = self.dislocations.iter().zip(glides).enumerate().map(glide).collect();
        (moved, shortened)
    }

    /// Applies departures, annihilations and nucleations.
    fn happen(&mut self, time: f64) -> Result<(), DislocationError> {
        let before = self.dislocations.len();
        self.dislocations.retain(|dislocation| dislocation.place < -self.slip.capture);
        self.events.departed += before - self.dislocations.len();
        let mut changed = before != self.dislocations.len();
        while let Some([i, j]) = self.meeting() {
            self.dislocations.remove(j);
            self.dislocations.remove(i);
            self.events.annihilated += 1;
            changed = true;
        }
        changed |= self.nucleate(time)?;
        if changed {
            let state = equilibrium(&self.domain, &self.slip, &self.dislocations, self.depth)?;
            let jump = state.energy() - self.state.energy();
            self.balance.jumps += jump;
            self.balance.stored += jump;
            self.state = state;
        }
        Ok(())
    }

    /// Returns the first pair of dislocations of opposite signs on one plane that are within reach of each other.
    fn meeting(&self) -> Option<[usize; 2]> {
        for (i, one) in self.dislocations.iter().enumerate() {
            for (j, other) in self.dislocations.iter().enumerate().skip(i + 1) {
                let meets = one.plane == other.plane && one.sign != other.sign;
                if meets && (one.place - other.place).abs() <= self.slip.capture {
                    return Some([i, j]);
                }
            }
        }
        None
    }

    /// Emits pairs; returns true if there are any.
    fn nucleate(&mut self, time: f64) -> Result<bool, DislocationError> {
        let along = self.slip.direction();
        let [c, s] = along;
        let mut sent = Vec::new();
        for (source, clock) in &mut self.sources {
            let place = [self.slip.planes[source.plane] + source.place * c, source.place * s];
            let stress = self.state.stress(place, None)?.resolved(along);
            // A dislocation on the source itself screens it.
            *clock = if stress.abs() > source.strength { *clock + time } else { 0.0 };
            if *clock <= source.delay {
                continue;
            }
            *clock = 0.0;
            let reach = 0.5 * self.slip.separation(self.domain.material(), source.strength);
            let lowest = self.domain.height().map_or(f64::NEG_INFINITY, |height| -height / s) + self.slip.capture;
            if source.place + reach < -self.slip.capture && source.place - reach > lowest {
                sent.push((*source, stress.signum(), reach));
            }
        }
        for (source, sign, reach) in &sent {
            for ahead in [1.0, -1.0] {
                let place = source.place + ahead * reach;
                let sign = sign * ahead;
                self.dislocations.push(Dislocation { plane: source.plane, place, sign, obstacle: None });
            }
        }
        self.events.nucleated += sent.len();
        Ok(!sent.is_empty())
    }
}

impl SlipSystem {
    /// Returns the unit vector along the slip planes, towards the surface.
    pub fn direction(&self) -> [f64; 2] {
        [self.angle.cos(), self.angle.sin()]
    }

    /// Returns the distance of a new pair at which its attraction balances the strength τ of the source: μ b/(2π (1 −
    /// ν) τ), length.
    pub fn separation(&self, material: &gfmd_green::Material, strength: f64) -> f64 {
        material.shear_modulus() * self.burgers / (2.0 * std::f64::consts::PI * (1.0 - material.poisson()) * strength)
    }
}

/// Computes the state of a domain with `dislocations` on their planes and the steps left by their partners.
fn equilibrium(
    domain: &Domain,
    slip: &SlipSystem,
    dislocations: &[Dislocation],
    depth: f64,
) -> Result<State, DislocationError> {
    let [c, s] = slip.direction();
    let poisson = domain.material().poisson();
    let (mut edges, mut jumps, mut moment) = (Vec::new(), vec![0.0; slip.planes.len()], 0.0);
    for dislocation in dislocations {
        let (x, b) = (slip.planes[dislocation.plane], dislocation.sign * slip.burgers);
        let place = [x + dislocation.place * c, dislocation.place * s];
        edges.push(Edge { place, burgers: [b * c, b * s] });
        jumps[dislocation.plane] += b;
        moment += b * dislocation.place;
    }
    // Jump around all dislocations of a plane, from the left side of the step to the right one.
    let steps: Vec<Step> = jumps
        .iter()
        .zip(&slip.planes)
        .filter(|(jump, _)| **jump != 0.0)
        .map(|(jump, x)| Step { x: *x, jump: [jump * c, jump * s] })
        .collect();
    // Slip raises the mean level by b_z times its length along x. It also frees a strain along x, which narrows the
    // slab by Poisson's effect.
    let rise = moment * s * c * (1.0 - 2.0 * poisson) / ((1.0 - poisson) * domain.grid().lengths()[0]);
    domain.state(&edges, &steps, rise, depth)
}
