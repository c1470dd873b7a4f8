//! One step of loading: Newton's method on the strain, with conjugate gradients, and the contact solved inside every
//! evaluation.

use std::ops::ControlFlow;
use std::sync::Arc;

use gfmd_contact::{Budget, Effort, Load, Refusal, SolveError, Visit, Watch, judge};
use gfmd_relax::{Ending, Progress, Why};
use gfmd_vector::for_each;
use ndarray::Array2;
use num_complex::Complex;

use crate::checkpoint::Start;
use crate::division::Division;
use crate::frozen::FrozenContact;
use crate::lane::Selection;
use crate::operator::{CellFields, Operator};
use crate::plastic::{Yielded, scatter};
use crate::volume::COMPONENTS;
use crate::yielding::{Energies, Evaluation};
use crate::{PlasticState, PlasticStrain, YieldingContact};

/// Tolerance of the contact in an evaluation, relative to the tolerance of the step, to the residual before, and at
/// most. The energy decides between steps, and its error is the tolerance times the energy.
const CONTACT_OF_TOLERANCE: f64 = 0.1;
const CONTACT_OF_RESIDUAL: f64 = 1e-4;
const CONTACT_MOST: f64 = 1e-7;
const CONTACT_LEAST: f64 = 1e-14;

/// Residual divided by the residual before, above which a Newton step may be disturbed by the error of the contact, and
/// the factor on the tolerance of the contact after such a step. A gap counts relative to the rms height of the
/// surface, which may be many times the displacement of a small contact.
const DISTURBED: f64 = 0.5;
const TIGHTENING: f64 = 0.1;

/// Largest number of iterations of one contact.
const CONTACT_ITERATIONS: u64 = 100_000;

/// Relative size of a rise of the energy that may be rounding.
const ROUNDING_OF_ENERGY: f64 = 1e-12;

/// Largest number of times a step is shortened to a quarter.
const SHORTENED: u32 = 2;

/// Largest number of iterations of conjugate gradients in a Newton step, and range of their tolerance (forcing terms of
/// Eisenstat and Walker).
const INNER_ITERATIONS: u64 = 30;
const FORCING: [f64; 2] = [0.03, 0.3];

/// Point that flows in a trial, with the tangent of its flow.
#[derive(Clone, Copy, Debug)]
struct Tangent {
    point: u32,
    direction: [f32; COMPONENTS],
    /// Along the direction and across it.
    factors: [f32; 2],
}

/// Points that flow in a cell: tangent, weight in scalar products.
#[derive(Clone, Debug, Default)]
struct Flowing {
    tangents: Vec<Tangent>,
    weight: f64,
}

/// Vector of strains on the points that flow, cell after cell.
type Strains = Vec<[f32; COMPONENTS]>;

/// Search for the state at the end of a step.
struct Search<'a> {
    problem: &'a YieldingContact,
    before: &'a PlasticState,
    load: Load,
    budget: &'a Budget,
    operator: Operator<f64>,
    /// Made when the first point flows.
    linear: Option<Linear>,
    /// Volume operators and transform pairs of contacts so far.
    operators: u64,
    contact_pairs: f64,
    /// Change of the strain by the last Newton step, and the part of it that is taken.
    change: CellFields<f32>,
    part: f64,
    residual: f64,
    /// Factor on the tolerance of the contact.
    tightening: f64,
}

/// First evaluation of a step: its end if nothing flows, otherwise the first trial.
type First = ControlFlow<(Evaluation, PlasticStrain), (Start, (PlasticStrain, Vec<Flowing>))>;

/// Strain from which the plastic strain follows: the strain of the last evaluation, with a part of a Newton step.
struct Trial<'a> {
    problem: &'a YieldingContact,
    before: &'a PlasticStrain,
    strain: &'a CellFields<f64>,
    change: &'a CellFields<f32>,
    part: f64,
}

/// Linear response in single precision, with its memory.
struct Linear {
    operator: Operator<f32>,
    frozen: FrozenContact,
    displacement: Vec<f32>,
    pressure: Vec<f32>,
    /// Spectra of the change of the strain, in cells with points that flow. They and the spectra of the operator take
    /// memory during a Newton step only, in place of the spectra in double precision.
    change: Vec<Vec<Complex<f32>>>,
}

impl YieldingContact {
    /// Computes the state under a `load` that follows the state `before` in one step.
    ///
    /// The iterations of the budget count volume operators; a step takes some 20, and one without plastic flow a
    /// single one. The tolerance holds for all residuals: of the contact conditions as in
    /// [`Contact`](gfmd_contact::Contact), of yield condition and flow as in [`FlowResidual`](crate::FlowResidual).
    ///
    /// # Errors
    /// [`SolveError::Refused`] for an invalid load, a load of 0.95 of the pressure at which a whole half-space yields,
    /// and the state of another contact; otherwise an error that contains the state reached, also if its lowest graded
    /// cell yields ([`Why::LowestCell`]).
    pub fn step(
        &self,
        before: &PlasticState,
        load: Load,
        budget: &Budget,
        watch: &mut dyn Watch,
    ) -> Result<PlasticState, SolveError<PlasticState>> {
        budget.check().map_err(Refusal::from)?;
        self.check_step(before, load, budget.tolerance)?;
        let search = Search {
            problem: self,
            before,
            load,
            budget,
            operator: Operator::new(&self.volume),
            linear: None,
            operators: 0,
            contact_pairs: 0.0,
            change: Vec::new(),
            part: 0.0,
            residual: 1.0,
            tightening: 1.0,
        };
        let (state, ending) = search.run(watch)?;
        // Residuals of the search do not include the depth of the cells.
        let is_deeper = matches!(ending, Ending::Converged) && state.residual.bottom > 0.0;
        judge(state, if is_deeper { Ending::GaveUp(Why::LowestCell) } else { ending }, budget.tolerance)
    }
}

impl Search<'_> {
    fn run(mut self, watch: &mut dyn Watch) -> Result<(PlasticState, Ending), Refusal> {
        let recalled = watch.recall().map(|visitor| self.recall(visitor));
        let (mut start, (mut plastic, mut flowing)) = match recalled {
            Some(start) => {
                let trial = self.trial(&start.strain).map();
                (start, trial)
            }
            None => match self.first()? {
                First::Continue(first) => first,
                First::Break((at, plastic)) => return Ok(self.end(&at, plastic, Ending::Converged)),
            },
        };
        let (mut shortened, mut may_fall_back) = (0, start.residual.is_some());
        loop {
            let now = self.evaluate(&plastic, &start.pressure)?;
            let energy = self.energy(&now, &plastic);
            let noise = ROUNDING_OF_ENERGY * energy.abs() + start.noise + self.noise(&now);
            let falls = energy <= start.least + noise;
            if may_fall_back && !falls {
                // Shorter Newton steps, then the safe step to the strain of the last evaluation, which lowers the
                // energy.
                shortened += 1;
                may_fall_back = shortened <= SHORTENED;
                self.part = if may_fall_back { 0.25 * self.part } else { 0.0 };
                drop(now);
                if let Some(ending) = self.ends() {
                    // The plastic strain of the safe step, and the contact that belongs to it.
                    self.part = 0.0;
                    (plastic, _) = self.trial(&start.strain).map();
                    let at = self.evaluate(&plastic, &start.pressure)?;
                    return Ok(self.end(&at, plastic, ending));
                }
                (plastic, flowing) = self.trial(&start.strain).map();
                continue;
            }
            shortened = 0;
            self.residual = self.trial(&start.strain).residual(&now.strain, &flowing);
            let seen = watch.see(&Progress { iteration: self.operators, residual: self.residual });
            if self.division().surface.any(seen.is_break()) {
                return Ok(self.end(&now, plastic, Ending::Interrupted));
            }
            if self.residual <= self.budget.tolerance && now.solution.residual.worst() <= self.budget.tolerance {
                return Ok(self.end(&now, plastic, Ending::Converged));
            }
            if start.residual.is_some_and(|last| self.residual > DISTURBED * last) {
                self.tightening *= TIGHTENING;
            }
            if !self.residual.is_finite() {
                return Ok(self.end(&now, plastic, Ending::GaveUp(Why::NoDescent)));
            }
            if let Some(ending) = self.ends() {
                return Ok(self.end(&now, plastic, ending));
            }
            drop(plastic);
            self.newton(std::mem::take(&mut start.strain), &now, &flowing, start.residual)?;
            drop(flowing);
            start = Start { least: energy, residual: Some(self.residual), ..self.start(now) };
            (self.part, may_fall_back) = (1.0, true);
            watch.checkpoint(&mut |visitor| self.visit(&mut start, visitor));
            (plastic, flowing) = self.trial(&start.strain).map();
        }
    }

    /// Restores the variables of a search after a Newton step.
    fn recall(&mut self, visitor: &mut dyn Visit) -> Start {
        let mut start = Start::empty(&self.problem.volume.mesh);
        self.visit(&mut start, visitor);
        self.part = 1.0;
        start
    }

    /// Visits the variables of the search after a Newton step.
    fn visit(&mut self, start: &mut Start, visitor: &mut dyn Visit) {
        let floating = self.is_floating();
        let Self { problem, operator, linear, operators, contact_pairs, change, residual, tightening, .. } = self;
        let linear = linear.get_or_insert_with(|| Linear::new(problem, floating));
        visitor.count(operators);
        visitor.count(linear.frozen.counter());
        visitor.numbers(&mut [contact_pairs, &mut operator.singles, &mut linear.operator.singles]);
        visitor.numbers(&mut [residual, tightening]);
        start.visit(change, &problem.volume.mesh, visitor);
    }

    /// Evaluates the plastic strain before the step.
    fn first(&mut self) -> Result<First, Refusal> {
        let before = &self.before.plastic;
        let mut last = self.evaluate(before, &self.before.solution.pressure)?;
        let (mut plastic, mut flowing) = self.trial(&last.strain).map();
        if !self.flows(&flowing).contains(&true) {
            // Without flow the strain is the one at the end of the step, once the contact is as good as required.
            if last.solution.residual.worst() > self.contact_tolerance(0.0) {
                last = self.evaluate_to(0.0, before, &last.solution.pressure)?;
                (plastic, flowing) = self.trial(&last.strain).map();
            }
            if !self.flows(&flowing).contains(&true) {
                return Ok(First::Break((last, plastic)));
            }
        }
        Ok(First::Continue((self.start(last), (plastic, flowing))))
    }

    /// Returns the points of this process.
    fn division(&self) -> &Division {
        &self.problem.volume.mesh.division
    }

    /// Returns true for each cell with points that flow, of any process.
    fn flows(&self, flowing: &[Flowing]) -> Vec<bool> {
        self.division().any(&flowing.iter().map(|cell| !cell.tangents.is_empty()).collect::<Vec<bool>>())
    }

    /// Makes the start of the next trial.
    fn start(&self, at: Evaluation) -> Start {
        let noise = self.noise(&at);
        Start { strain: at.strain, pressure: at.solution.pressure, noise, least: f64::INFINITY, residual: None }
    }

    fn ends(&self) -> Option<Ending> {
        (self.operators >= self.budget.max_iterations).then_some(Ending::GaveUp(Why::Iterations))
    }

    fn end(mut self, at: &Evaluation, plastic: PlasticStrain, ending: Ending) -> (PlasticState, Ending) {
        let linear = self.linear.take().map_or(0.0, |linear| linear.operator.pairs() + linear.frozen.pairs());
        let transform_pairs = self.operator.pairs() + self.contact_pairs + linear;
        let effort = Effort { iterations: self.operators, transform_pairs };
        (self.problem.state(at, plastic, self.before, effort), ending)
    }

    /// Returns true if changes of the pressure have no mean. Without a load nothing touches, and nothing has a mean.
    fn is_floating(&self) -> bool {
        matches!(self.load, Load::MeanPressure(mean) if mean > 0.0)
    }

    fn contact_tolerance(&self, residual: f64) -> f64 {
        let least = CONTACT_OF_TOLERANCE * self.budget.tolerance;
        (self.tightening * (CONTACT_OF_RESIDUAL * residual).min(CONTACT_MOST).max(least)).max(CONTACT_LEAST)
    }

    fn evaluate(&mut self, plastic: &PlasticStrain, start: &Array2<f64>) -> Result<Evaluation, Refusal> {
        self.evaluate_to(self.residual, plastic, start)
    }

    fn evaluate_to(
        &mut self,
        residual: f64,
        plastic: &PlasticStrain,
        start: &Array2<f64>,
    ) -> Result<Evaluation, Refusal> {
        let budget = Budget { tolerance: self.contact_tolerance(residual), max_iterations: CONTACT_ITERATIONS };
        let found = self.problem.evaluate(&mut self.operator, plastic, self.load, start, &budget)?;
        self.operators += 1;
        self.contact_pairs += found.solution.effort.transform_pairs;
        Ok(found)
    }

    /// Returns the function that the step minimises: energy stored and dissipated, less the work of a prescribed load.
    fn energy(&self, at: &Evaluation, plastic: &PlasticStrain) -> f64 {
        let Energies { elastic, hardening, dissipated } = self.problem.energies(at, plastic, &self.before.plastic);
        let work = match self.load {
            Load::MeanPressure(mean) => mean * at.solution.approach,
            Load::Approach(_) => 0.0,
        };
        elastic + hardening + dissipated - work
    }

    /// Returns the error of the energy by the residuals of the contact.
    fn noise(&self, at: &Evaluation) -> f64 {
        at.solution.residual.worst() * at.solution.mean_pressure * at.solution.length_scale()
    }

    /// Returns the trial that adds the part taken of the change to a strain.
    fn trial<'b>(&'b self, strain: &'b CellFields<f64>) -> Trial<'b> {
        let Self { problem, before, change, part, .. } = self;
        Trial { problem, before: &before.plastic, strain, change, part: *part }
    }

    /// Solves (1 − Γ 2μ𝒟) x = ε̂ − ε by conjugate gradients on the points that flow, and sets the change of the strain
    /// from ε̂ to Γ 2μ𝒟 x. Frees the strain from which the trial of ε̂ started.
    fn newton(
        &mut self,
        start: CellFields<f64>,
        now: &Evaluation,
        flowing: &[Flowing],
        last: Option<f64>,
    ) -> Result<(), Refusal> {
        let cells = flowing.len();
        let active = self.flows(flowing);
        let mut starts = vec![0];
        for cell in flowing {
            starts.push(starts[starts.len() - 1] + cell.tangents.len());
        }
        let mut residual: Strains = Vec::with_capacity(starts[cells]);
        let trial = self.trial(&start);
        for (number, cell) in flowing.iter().enumerate() {
            let (trial, found) = (trial.of_cell(number), at_points(&now.strain[number]));
            residual.extend(cell.tangents.iter().map(|tangent| -> [f32; COMPONENTS] {
                let i = tangent.point as usize;
                let (trial, found) = (trial(i), found(i));
                std::array::from_fn(|c| (found[c] - trial[c]) as f32)
            }));
        }
        drop(start);
        self.change = Vec::new();
        let floating = self.is_floating();
        let Self { problem, operator, linear, budget, operators, change, .. } = self;
        operator.release();
        let linear = linear.get_or_insert_with(|| Linear::new(problem, floating));
        linear.frozen.freeze(&gfmd_vector::contiguous(&now.solution.pressure));
        linear.start(&active);
        let ratio = last.map_or(FORCING[1], |last| 0.9 * (self.residual / last).powf(1.6));
        let forcing = ratio.clamp(FORCING[0], FORCING[1]).max(0.3 * budget.tolerance / self.residual);
        let mut direction = residual.clone();
        let mut image = vec![[0.0; COMPONENTS]; residual.len()];
        let division = &problem.volume.mesh.division;
        let product = |a: &Strains, b: &Strains| energy_product(division, flowing, &starts, [a, b]);
        let start = product(&residual, &residual);
        let mut slope = start;
        for _ in 0..INNER_ITERATIONS {
            let moving = slope.is_finite() && slope > forcing * forcing * start;
            if !moving || *operators >= budget.max_iterations {
                break;
            }
            linear.respond(flowing, &starts, &direction, &mut image, &active);
            *operators += 1;
            // ⟨d, (1 − Γ2μ𝒟) d⟩.
            let own = product(&direction, &direction);
            let curvature = own - product(&direction, &image);
            let positive = curvature > 0.0;
            if !positive {
                break;
            }
            let step = (slope / curvature) as f32;
            linear.add(step, &active);
            for_each((&mut residual[..], &direction[..], &image[..]), &|_, (residual, direction, image)| {
                for (residual, (direction, image)) in residual.iter_mut().zip(direction.iter().zip(image)) {
                    for c in 0..COMPONENTS {
                        residual[c] -= step * (direction[c] - image[c]);
                    }
                }
            });
            let next = product(&residual, &residual);
            let beta = (next / slope) as f32;
            for_each((&mut direction[..], &residual[..]), &|_, (direction, residual)| {
                for (direction, residual) in direction.iter_mut().zip(residual) {
                    for c in 0..COMPONENTS {
                        direction[c] = residual[c] + beta * direction[c];
                    }
                }
            });
            slope = next;
        }
        *change = linear.finish(&active);
        Ok(())
    }
}

impl Trial<'_> {
    /// Returns a function for the deviatoric strain of the points of a cell.
    fn of_cell(&self, cell: usize) -> impl Fn(usize) -> [f64; COMPONENTS] + Sync + '_ {
        let strain = at_points(&self.strain[cell]);
        let change = self.change.get(cell).filter(|change| !change.is_empty()).map(|change| at_points(change));
        move |i| {
            let mut strain = strain(i);
            if let Some(change) = &change {
                let change = change(i);
                (0..COMPONENTS).for_each(|c| strain[c] += self.part * f64::from(change[c]));
            }
            strain
        }
    }

    /// Maps the strain of the trial to the plastic strain.
    fn map(&self) -> (PlasticStrain, Vec<Flowing>) {
        let mesh = &self.problem.volume.mesh;
        let of_cell = |(number, cell): (usize, &crate::Cell)| {
            let before = &self.before.cells[number];
            let Some(hardening) = &cell.hardening else { return (Arc::clone(before), Flowing::default()) };
            let (points, trial) = (self.strain[number].len() / COMPONENTS, self.of_cell(number));
            let stretches = YieldingContact::stretches(points, |range| {
                let mut place = before.points.partition_point(|point| (*point as usize) < range.start);
                let (mut yielded, mut tangents) = (Yielded::default(), Vec::new());
                for i in range {
                    let has = before.points.get(place).is_some_and(|point| *point as usize == i);
                    let (plastic, equivalent) =
                        if has { (before.strain[place], before.equivalent[place]) } else { ([0.0; COMPONENTS], 0.0) };
                    place += usize::from(has);
                    let strain = trial(i);
                    match hardening.flow(cell.shear_modulus, &strain, (&plastic, equivalent)) {
                        Some(flow) => {
                            yielded.push(i as u32, flow.strain, flow.equivalent);
                            tangents.push(Tangent {
                                point: i as u32,
                                direction: flow.direction.map(|n| n as f32),
                                factors: flow.tangent.map(|factor| factor as f32),
                            });
                        }
                        None if has => yielded.push(i as u32, plastic, equivalent),
                        None => {}
                    }
                }
                (yielded, tangents)
            });
            let mut all = Yielded::with_room(stretches.iter().map(|(yielded, _)| yielded.points.len()).sum());
            let weight = 2.0 * cell.shear_modulus * cell.thickness / cell.grid(&mesh.grid).len() as f64;
            let count = stretches.iter().map(|(_, tangents)| tangents.len()).sum();
            let mut flowing = Flowing { tangents: Vec::with_capacity(count), weight };
            for (yielded, mut tangents) in stretches {
                all.append(yielded);
                flowing.tangents.append(&mut tangents);
            }
            (Arc::new(all), flowing)
        };
        let (cells, flowing) = mesh.cells.iter().enumerate().map(of_cell).unzip();
        (PlasticStrain { cells }, flowing)
    }

    /// Returns the largest difference between a trial and the strain that follows from it, over the points that flow in
    /// either, as an equivalent stress divided by the yield stress.
    fn residual(&self, strain: &CellFields<f64>, flowing: &[Flowing]) -> f64 {
        let worse = |a: f64, b: f64| if b <= a { a } else { b };
        let of_cell = |(number, cell): (usize, &crate::Cell)| {
            let Some(hardening) = &cell.hardening else { return 0.0 };
            let before = &self.before.cells[number];
            let tangents = &flowing[number].tangents;
            let points = strain[number].len() / COMPONENTS;
            let (trial, found) = (self.of_cell(number), at_points(&strain[number]));
            let unit = 1.5_f64.sqrt() * 2.0 * cell.shear_modulus / hardening.yield_stress();
            let stretch = |range: std::ops::Range<usize>| {
                let mut place = before.points.partition_point(|point| (*point as usize) < range.start);
                let mut next = tangents.partition_point(|tangent| (tangent.point as usize) < range.start);
                let mut worst = 0.0;
                for i in range {
                    let has = before.points.get(place).is_some_and(|point| *point as usize == i);
                    let (plastic, equivalent) =
                        if has { (before.strain[place], before.equivalent[place]) } else { ([0.0; COMPONENTS], 0.0) };
                    place += usize::from(has);
                    let flows = tangents.get(next).is_some_and(|tangent| tangent.point as usize == i);
                    next += usize::from(flows);
                    let found = found(i);
                    let driving = hardening.driving_stress(cell.shear_modulus, &found, &plastic);
                    let stays = hardening.overstress(&driving, equivalent) <= 0.0;
                    if flows || !stays {
                        let trial = trial(i);
                        let difference: [f64; COMPONENTS] = std::array::from_fn(|c| found[c] - trial[c]);
                        worst = worse(worst, unit * crate::hardening::norm(&difference));
                    }
                }
                worst
            };
            gfmd_vector::reduce(points, &stretch, &worse)
        };
        let own = self.problem.cells().iter().enumerate().map(of_cell).fold(0.0, worse);
        let [worst] = self.problem.volume.mesh.division.worst([own], |[a], [b]| [worse(a, b)]);
        worst
    }
}

/// Returns a function for the components of a point in the fields of a cell.
fn at_points<T: Copy + Sync>(fields: &[T]) -> impl Fn(usize) -> [T; COMPONENTS] + Sync + '_ {
    let points = fields.len() / COMPONENTS;
    move |i| std::array::from_fn(|c| fields[c * points + i])
}

/// Applies the tangent of the flow of a point to a strain.
#[inline(always)]
fn tangent(of: &Tangent, strain: &[f32; COMPONENTS]) -> [f32; COMPONENTS] {
    let along: f32 = of.direction.iter().zip(strain).map(|(n, e)| n * e).sum();
    let [first, second] = of.factors;
    std::array::from_fn(|c| (first - second) * along * of.direction[c] + second * strain[c])
}

/// Returns Σ h 2μ ⟨a, 𝒟 b⟩ over the points that flow, of all processes.
fn energy_product(division: &Division, flowing: &[Flowing], starts: &[usize], [a, b]: [&Strains; 2]) -> f64 {
    let sums = division.sums(&|number, range| {
        let (first, tangents) = (starts[number], &flowing[number].tangents);
        let place = |limit: usize| tangents.partition_point(|tangent| (tangent.point as usize) < limit);
        let of_point = |k: usize| {
            let image = tangent(&tangents[k], &b[first + k]);
            a[first + k].iter().zip(image).map(|(a, b)| f64::from(*a) * f64::from(b)).sum::<f64>()
        };
        (place(range.start)..place(range.end)).map(of_point).sum()
    });
    flowing.iter().zip(sums).map(|(cell, sum)| cell.weight * sum).sum()
}

impl Linear {
    fn new(problem: &YieldingContact, floating: bool) -> Self {
        let n = problem.response.share().own().len();
        Self {
            operator: Operator::new(&problem.volume),
            frozen: FrozenContact::new(&problem.response, floating),
            displacement: vec![0.0; n],
            pressure: vec![0.0; n],
            change: vec![Vec::new(); problem.cells().len()],
        }
    }

    fn start(&mut self, active: &[bool]) {
        for (cell, _) in active.iter().enumerate().filter(|(_, active)| **active) {
            self.change[cell] = self.operator.zeros(cell);
        }
    }

    /// Computes the strain `image` on the points that flow, by plastic strain 𝒟 `direction`.
    fn respond(
        &mut self,
        flowing: &[Flowing],
        starts: &[usize],
        direction: &Strains,
        image: &mut Strains,
        active: &[bool],
    ) {
        let Self { operator, frozen, displacement, pressure, .. } = self;
        operator.analyse(active, |number, component, field| {
            let Flowing { tangents, .. } = &flowing[number];
            let strains = &direction[starts[number]..starts[number + 1]];
            let value = |k: usize| tangent(&tangents[k], &strains[k])[component];
            scatter(field, strains.len(), &|k| tangents[k].point, &value);
        });
        operator.surface_displacement(active, displacement);
        frozen.solve(displacement, pressure);
        operator.strain(pressure, &Selection { plastic: active.to_vec(), strain: active.to_vec() });
        let mut outputs = Vec::with_capacity(flowing.len());
        let mut rest = &mut image[..];
        for (number, Flowing { tangents, .. }) in flowing.iter().enumerate().filter(|(number, _)| active[*number]) {
            let (strains, next) = std::mem::take(&mut rest).split_at_mut(tangents.len());
            outputs.push((number, (strains, &tangents[..])));
            rest = next;
        }
        operator.synthesise(outputs, |(strains, tangents), component, field| {
            for_each((&mut **strains, *tangents), &|_, (strains, tangents)| {
                for (strain, of) in strains.iter_mut().zip(tangents) {
                    strain[component] = field[of.point as usize];
                }
            });
        });
    }

    /// Adds `step` times the strain of the last response to the change.
    fn add(&mut self, step: f32, active: &[bool]) {
        let spectra = self.operator.spectra.iter().zip(&mut self.change).zip(active);
        for ((spectrum, change), _) in spectra.filter(|(_, active)| **active) {
            for_each((&mut change[..], &spectrum[..]), &|_, (change, spectrum)| {
                change.iter_mut().zip(spectrum).for_each(|(change, strain)| *change += *strain * step);
            });
        }
    }

    /// Transforms the change back, in the cells with points that flow, and frees the spectra.
    fn finish(&mut self, active: &[bool]) -> CellFields<f32> {
        self.operator.release();
        std::mem::swap(&mut self.operator.spectra, &mut self.change);
        self.operator.fields(active)
    }
}
