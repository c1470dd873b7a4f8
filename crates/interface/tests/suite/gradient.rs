//! Derivatives along paths: difference quotients, identities, refusals.

use std::sync::Arc;

use gfmd_contact::{Boundary, Budget, Contact, Cotangents, Drive, Equilibrium as _, Fields as _, Hardness, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_interface::{
    Increment, Interface, LimitingPressure, Parts, Path, PathGradient, PathGradientError, QuasistaticContact,
    QuasistaticState, Refinement, Shear, Wear, follow,
};
use gfmd_law::{CoupledExponential, Exponential, Law, Limit, Morse, Separation};
use gfmd_medium::{Prony, Relaxes};
use ndarray::{Array2, Array3, Axis};

use crate::rough;

const TOLERANCE: f64 = 1e-12;

/// A path of a contact; the modulus is multiplied by a factor.
#[derive(Clone)]
struct Case {
    name: &'static str,
    boundary: Boundary,
    /// Height of a slab, Poisson's ratio.
    body: (Option<f64>, f64),
    law: Option<Arc<dyn Law>>,
    relaxation: Option<(Prony, Relaxes)>,
    /// Wear coefficients for distance and slip.
    wear: [f64; 2],
    hardness: Option<Hardness>,
    shear: Option<Shear>,
    drives: Vec<Drive>,
    heights: Array2<f64>,
    factor: f64,
    tolerance: f64,
}

fn grid() -> Grid {
    Grid::new([12, 10], [1.0, 0.8]).unwrap()
}

fn prony() -> Prony {
    Prony::from_fractions(&[(0.5, 0.3), (4.0, 0.3)]).unwrap()
}

/// Returns loads, each with its time and its sliding distance.
fn drives(load: fn(f64) -> Load, values: &[[f64; 3]]) -> Vec<Drive> {
    values.iter().map(|[value, time, distance]| Drive::from(load(*value)).at(*time).after(*distance)).collect()
}

impl Case {
    fn of(name: &'static str) -> Self {
        let pressures = [[0.02, 0.0, 0.0], [0.05, 0.4, 0.6], [0.05, 2.0, 1.0], [0.03, 3.0, 1.7]];
        Self {
            name,
            boundary: Boundary::Periodic,
            body: (None, 0.3),
            law: None,
            relaxation: None,
            wear: [0.0; 2],
            hardness: None,
            shear: None,
            drives: drives(Load::MeanPressure, &pressures),
            heights: rough(&grid(), 3),
            factor: 1.0,
            tolerance: TOLERANCE,
        }
    }

    fn driven(self) -> Self {
        let approaches = [[0.006, 0.0, 0.0], [0.01, 0.4, 0.6], [0.01, 2.0, 1.0], [0.008, 3.0, 1.7]];
        Self { drives: drives(Load::Approach, &approaches), ..self }
    }

    fn relaxing(self, relaxes: Relaxes) -> Self {
        Self { relaxation: Some((prony(), relaxes)), ..self }
    }

    fn wearing(self) -> Self {
        Self { wear: [0.05, 0.0], ..self }
    }

    fn with(self, law: impl Law + 'static) -> Self {
        Self { law: Some(law.into_shared()), ..self }
    }

    fn hard(self, hardness: impl Into<Hardness>) -> Self {
        Self { hardness: Some(hardness.into()), ..self }
    }

    /// Pushes the rigid surface along a curve, back and forth. The search for the shear reaches a larger residual.
    fn pushed(mut self, limit: Limit) -> Self {
        let places = [[0.0, 0.0], [1e-3, 4e-4], [2.5e-3, -3e-4], [1e-3, 6e-4]];
        for (drive, lateral) in self.drives.iter_mut().zip(places) {
            drive.lateral = lateral;
        }
        Self { shear: Some(limit.into()), tolerance: 1e-11, ..self }
    }

    fn wearing_by_slip(self) -> Self {
        Self { wear: [0.0, 0.4], ..self }
    }

    fn free(self) -> Self {
        Self { boundary: Boundary::Free, ..self }
    }

    fn slab(self, height: f64, poisson: f64) -> Self {
        Self { body: (Some(height), poisson), ..self }
    }

    fn contact(&self) -> QuasistaticContact {
        let (height, poisson) = self.body;
        let material = Material::from_young(2.0 * self.factor, poisson).unwrap();
        let body = height.map_or_else(|| Body::half_space(material), |height| Body::slab(material, height).unwrap());
        let relaxation = self.relaxation.as_ref().map(|(prony, relaxes)| (prony, *relaxes));
        let [by_distance, by_slip] = self.wear;
        let wear = (self.wear != [0.0; 2]).then_some(Wear { by_distance, by_slip });
        let (boundary, law, grid) = (self.boundary, self.law.clone(), grid());
        let (hardness, shear) = (self.hardness.clone(), self.shear);
        let plain = Parts::new(&body, &grid, &self.heights);
        let parts = Parts { boundary, law, hardness, shear, relaxation, wear, ..plain };
        QuasistaticContact::new(&parts).unwrap()
    }

    fn follow(&self) -> Vec<QuasistaticState> {
        let (contact, mut states) = (self.contact(), Vec::<QuasistaticState>::new());
        for drive in &self.drives {
            let press = contact.press(*drive).tolerance(self.tolerance).starting_from(states.last());
            states.push(press.solve().unwrap_or_else(|error| panic!("{}: {error}", self.name)));
        }
        states
    }

    fn gradient(&self, states: &[QuasistaticState], of: &[Cotangents]) -> PathGradient {
        let increments: Vec<Increment> = states
            .iter()
            .zip(&self.drives)
            .zip(of)
            .map(|((state, drive), of)| Increment { load: drive.load, state, of: Some(of) })
            .collect();
        self.contact().gradient_along(&increments).unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }

    fn with_height(&self, [i, j]: [usize; 2], change: f64) -> Self {
        let mut moved = self.clone();
        moved.heights[[i, j]] += change;
        moved
    }

    fn with_load(&self, step: usize, change: f64) -> Self {
        let mut moved = self.clone();
        moved.drives[step].load = match self.drives[step].load {
            Load::MeanPressure(load) => Load::MeanPressure(load + change),
            Load::Approach(load) => Load::Approach(load + change),
        };
        moved
    }
}

fn load_of(drive: &Drive) -> f64 {
    match drive.load {
        Load::MeanPressure(load) | Load::Approach(load) => load,
    }
}

/// Returns a smooth field without symmetries.
fn field(phase: f64) -> Array2<f64> {
    Array2::from_shape_fn(grid().points(), |(i, j)| {
        (1.3 * i as f64 + phase).sin() * (0.7 * j as f64 - phase).cos() + 0.3
    })
}

/// Returns derivatives of a number that depends on every part of every state.
fn cotangents(case: &Case) -> Vec<Cotangents> {
    let (is_hard, is_sheared) = (case.hardness.is_some(), case.shear.is_some());
    let of = |step: f64| Cotangents {
        plastic_depth: is_hard.then(|| 30.0 * field(0.7 + step)),
        shear: is_sheared.then(|| ndarray::stack![Axis(0), field(2.3 - step), field(0.2 + step)]),
        mean_shear: if is_sheared { [60.0 - 10.0 * step, 25.0] } else { [0.0; 2] },
        pressure: Some(field(0.4 + step)),
        gap: Some(20.0 * field(1.9 - step)),
        approach: 100.0 - 30.0 * step,
        mean_pressure: -40.0 + 7.0 * step,
        mean_gap: 90.0 * (step - 1.2),
        elastic_energy: 3e4 / (1.0 + step),
    };
    (0..case.drives.len()).map(|step| of(step as f64)).collect()
}

fn value(of: &[Cotangents], states: &[QuasistaticState]) -> f64 {
    let product = |a: &Option<Array2<f64>>, b: Array2<f64>| a.as_ref().map_or(0.0, |a| (a * &b).sum());
    let parts = of.iter().zip(states).map(|(of, state)| {
        product(&of.pressure, state.pressure().into_owned())
            + product(&of.gap, state.gap().to_owned())
            + of.approach * state.approach()
            + of.mean_pressure * state.mean_pressure()
            + of.mean_gap * state.gap().mean().unwrap()
            + of.elastic_energy * state.elastic_energy()
            + of.plastic_depth.as_ref().map_or(0.0, |by| (by * state.plastic_depth().unwrap()).sum())
            + of.shear.as_ref().map_or(0.0, |by| sheared(by, state))
            + of.mean_shear[0] * state.mean_shear[0]
            + of.mean_shear[1] * state.mean_shear[1]
    });
    parts.sum()
}

fn sheared(by: &Array3<f64>, state: &QuasistaticState) -> f64 {
    by.outer_iter().enumerate().map(|(axis, by)| (&by * &state.shear(axis).unwrap()).sum()).sum()
}

/// Returns which points of all states yield, stick and slip: the sets that a derivative keeps.
fn kinds(case: &Case, states: &[QuasistaticState]) -> Vec<u8> {
    let kind = |state: &QuasistaticState, (i, repulsion): (usize, &f64)| {
        let pressure = state.pressure();
        let hardness = match &case.hardness {
            None => f64::INFINITY,
            Some(Hardness::Uniform(hardness)) => *hardness,
            Some(Hardness::Field(field)) => field.iter().copied().nth(i).unwrap(),
        };
        let at = |field: ndarray::ArrayView2<f64>| field.iter().copied().nth(i).unwrap();
        let p = at(pressure.view());
        let yields = p >= hardness * (1.0 - 1e-9);
        let sticks = case.shear.is_some_and(|shear| {
            let size = [0, 1].map(|axis| at(state.shear(axis).unwrap()));
            let pressure = if shear.pressure == LimitingPressure::Net { p.max(0.0) } else { *repulsion };
            size[0].hypot(size[1]) < shear.limit.at(pressure) * (1.0 - 1e-7)
        });
        u8::from(yields) + 2 * u8::from(sticks)
    };
    states
        .iter()
        .flat_map(|state| state.repulsion().iter().enumerate().map(|at| kind(state, at)).collect::<Vec<u8>>())
        .collect()
}

/// Returns the points in contact of all states.
fn touching(states: &[QuasistaticState]) -> Vec<bool> {
    states
        .iter()
        .flat_map(|state| match (state.wall(), state.law()) {
            (_, Some(law)) => law.wall_pressure.iter().map(|p| *p > 0.0).collect::<Vec<bool>>(),
            _ => state.pressure().iter().map(|p| *p > 0.0).collect(),
        })
        .collect()
}

/// Returns the derivative from four states around the middle, to fourth order; `None` if points enter or leave contact.
fn quotient(of: &[Cotangents], step: f64, moved: impl Fn(f64) -> Case) -> Option<f64> {
    let cases = [-2.0, -1.0, 1.0, 2.0].map(|times| moved(times * step));
    let states = cases.each_ref().map(Case::follow);
    let sets = std::array::from_fn::<_, 4, _>(|k| (touching(&states[k]), kinds(&cases[k], &states[k])));
    if sets.iter().any(|set| *set != sets[0]) {
        return None;
    }
    let [far_down, down, up, far_up] = states.map(|states| value(of, &states));
    Some((8.0 * (up - down) - (far_up - far_down)) / (12.0 * step))
}

/// Compares all derivatives with difference quotients, heights relative to the largest of them.
fn check(case: &Case) {
    let states = case.follow();
    let of = cotangents(case);
    let found = case.gradient(&states, &of);
    let name = case.name;
    assert!(found.error <= 1e-9, "{name}: {}", found.error);
    let count = touching(&states).iter().filter(|touches| **touches).count();
    assert!(case.law.is_some() || count > 8 && count < touching(&states).len() - 8, "{name}: {count}");
    let most = found.heights.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
    let highest = case.heights.indexed_iter().max_by(|(_, a), (_, b)| a.total_cmp(b)).unwrap().0;
    let mut places = vec![highest.into()];
    places.extend((0..8).map(|index| [index * 7 % 12, (index * 3 + 1) % 10]));
    let mut checked = 0;
    for place in places {
        let Some(wanted) = quotient(&of, 2e-6, |change| case.with_height(place, change)) else { continue };
        checked += 1;
        let apart = (found.heights[place] - wanted).abs();
        assert!(apart <= 1e-6 * most, "{name} at {place:?}: {} {wanted} of {most}", found.heights[place]);
    }
    assert!(checked >= 6, "{name}: {checked}");
    for (step, by) in found.loads.iter().enumerate() {
        let size = 1e-4 * load_of(&case.drives[step]);
        let Some(wanted) = quotient(&of, size, |change| case.with_load(step, change)) else { continue };
        checked += 1;
        let most = found.loads.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
        assert!((by - wanted).abs() <= 1e-6 * most, "{name}, load {step}: {by} {wanted}");
    }
    assert!(checked >= 8, "{name}: {checked}");
    let wanted = quotient(&of, 2e-5, |change| Case { factor: 1.0 + change, ..case.clone() });
    // The modulus of the body is E*.
    let modulus = 2.0 / (1.0 - case.body.1.powi(2));
    let wanted = wanted.unwrap_or_else(|| panic!("{name}: the contact changes"));
    assert!((found.modulus * modulus - wanted).abs() <= 1e-6 * wanted.abs(), "{name}: {} {wanted}", found.modulus);
    check_parameters(case, &of, &found);
}

/// Compares the derivatives by lateral displacements, limit of the shear, hardness and wear.
fn check_parameters(case: &Case, of: &[Cotangents], found: &PathGradient) {
    let name = case.name;
    let number = value(of, &case.follow()).abs();
    // The rounding errors of the number limit the accuracy of a quotient near zero.
    let compare = |what: &str, by: f64, [at, size]: [f64; 2], moved: &dyn Fn(f64) -> Case| {
        let wanted = quotient(of, size, moved).unwrap_or_else(|| panic!("{name}, {what}: the contact changes"));
        let scale = wanted.abs().max(0.01 * number / at);
        assert!((by - wanted).abs() <= 2e-6 * scale, "{name}, {what}: {by} {wanted} of {number}");
    };
    if let Some(shear) = case.shear {
        for (step, by) in found.lateral.iter().enumerate() {
            for (axis, by) in by.iter().enumerate() {
                compare(&format!("place {step} {axis}"), *by, [1e-3, 1e-7], &|change| {
                    let mut moved = case.clone();
                    moved.drives[step].lateral[axis] += change;
                    moved
                });
            }
        }
        let limited = |limit: Limit| Case { shear: Some(Shear { limit, ..shear }), ..case.clone() };
        match shear.limit {
            Limit::Coulomb(mu) => {
                compare("friction", found.friction, [mu, 1e-5 * mu], &|change| limited(Limit::Coulomb(mu + change)));
                assert_eq!(found.shear_strength, 0.0);
            }
            Limit::Tresca(strength) => {
                let moved = |change| limited(Limit::Tresca(strength + change));
                compare("strength", found.shear_strength, [strength, 1e-5 * strength], &moved);
                assert_eq!(found.friction, 0.0);
            }
            Limit::Orowan { coefficient, strength } => {
                let moved = |change| limited(Limit::Orowan { coefficient: coefficient + change, strength });
                compare("friction", found.friction, [coefficient, 1e-5 * coefficient], &moved);
                let moved = |change| limited(Limit::Orowan { coefficient, strength: strength + change });
                compare("strength", found.shear_strength, [strength, 1e-5 * strength], &moved);
            }
        }
    }
    assert_eq!(found.hardness.is_some(), case.hardness.is_some(), "{name}");
    if let (Some(by), Some(hardness)) = (&found.hardness, &case.hardness) {
        assert!(by.iter().any(|by| *by != 0.0), "{name}: no point yields");
        let field = match hardness {
            Hardness::Uniform(hardness) => Array2::from_elem(grid().points(), *hardness),
            Hardness::Field(field) => field.clone(),
        };
        let moved = |change| case.clone().hard(&field * (1.0 + change));
        compare("hardness", (by * &field).sum(), [1.0, 1e-5], &moved);
    }
    for (kind, by) in [found.wear.by_distance, found.wear.by_slip].into_iter().enumerate() {
        if case.wear[kind] == 0.0 {
            continue;
        }
        compare(&format!("wear {kind}"), by, [case.wear[kind], 1e-4 * case.wear[kind]], &|change| {
            let mut moved = case.clone();
            moved.wear[kind] += change;
            moved
        });
    }
}

/// Surfaces that yield have a third kind of points, and keep their plastic depths.
#[test]
fn a_hardness_passes_derivatives_back() {
    let field = 0.25 + 0.03 * field(0.9);
    check(&Case::of("hardness").hard(0.25));
    check(&Case::of("hardness, driven").hard(0.25).driven());
    check(&Case::of("hardness, free").hard(0.25).free());
    check(&Case::of("hardness, slab").hard(field.clone()).slab(0.3, 0.4));
    check(&Case::of("hardness, wear").hard(0.25).wearing());
    check(&Case::of("hardness, memory").hard(0.25).relaxing(Relaxes::Both));
    check(&Case::of("hardness, memory of waves").hard(0.25).relaxing(Relaxes::Shear).slab(0.3, 0.4));
    let law = Exponential::new(1e-4, 4e-3).unwrap();
    check(&Case::of("hardness, law").hard(0.25).with(law));
    check(&Case::of("hardness, law, wear").hard(0.5 * field).with(law).wearing().driven());
    check(&Case::of("hardness, law, memory").hard(0.25).with(law).relaxing(Relaxes::Both));
}

#[test]
fn surfaces_that_stick_and_slip_pass_derivatives_back() {
    let coulomb = Limit::Coulomb(0.3);
    check(&Case::of("friction").pushed(coulomb));
    check(&Case::of("friction, driven").driven().pushed(coulomb));
    check(&Case::of("friction, incompressible").slab(0.4, 0.5).pushed(coulomb));
    check(&Case::of("friction, free").free().pushed(coulomb));
    check(&Case::of("strength").pushed(Limit::Tresca(0.05)));
    check(&Case::of("both limits").pushed(Limit::Orowan { coefficient: 0.4, strength: 0.06 }));
}

#[test]
fn friction_with_histories_passes_derivatives_back() {
    let coulomb = Limit::Coulomb(0.3);
    let law = Exponential::new(1e-4, 4e-3).unwrap();
    check(&Case::of("friction, memory").relaxing(Relaxes::Both).pushed(coulomb));
    check(&Case::of("friction, memory, free").relaxing(Relaxes::Both).free().pushed(coulomb));
    check(&Case::of("friction, wear").wearing().pushed(coulomb));
    check(&Case::of("friction, wear by slip").wearing_by_slip().pushed(coulomb));
    check(&Case::of("friction, hardness").hard(0.25).pushed(coulomb));
    check(&Case::of("friction, law").with(law).pushed(coulomb));
    let mut net = Case::of("friction of the net pressure").with(law).pushed(coulomb);
    net.shear = Some(Shear { limit: coulomb, pressure: LimitingPressure::Net });
    check(&net);
    check(&Case::of("friction, law, memory").with(law).relaxing(Relaxes::Both).pushed(coulomb));
    check(&Case::of("friction, law, wear by slip").with(law).wearing_by_slip().pushed(coulomb));
}

#[test]
fn a_wall_without_history_has_the_sum_over_its_states() {
    for case in [Case::of("wall"), Case::of("free wall").free(), Case::of("wall, driven").driven()] {
        check(&case);
        let states = case.follow();
        let of = cotangents(&case);
        let along = case.gradient(&states, &of);
        let (body, grid) = (Body::half_space(Material::from_young(2.0, 0.3).unwrap()), grid());
        let contact = Contact::with_boundary(case.boundary, &body, &grid, &case.heights).unwrap();
        let mut heights = Array2::<f64>::zeros(grid.points());
        for (step, state) in states.iter().enumerate() {
            let alone = contact.gradient(state.wall().unwrap(), case.drives[step].load, &of[step]).unwrap();
            approx::assert_relative_eq!(along.loads[step], alone.load, max_relative = 1e-9);
            heights += &alone.heights;
        }
        let most = heights.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
        assert!((&heights - &along.heights).iter().all(|apart| apart.abs() <= 1e-9 * most));
    }
}

#[test]
fn a_law_without_history_has_the_sum_over_its_states() {
    let law = Exponential::new(1e-4, 4e-3).unwrap();
    for case in
        [Case::of("law").with(law), Case::of("free law").with(law).free(), Case::of("law, driven").with(law).driven()]
    {
        check(&case);
        let states = case.follow();
        let of = cotangents(&case);
        let along = case.gradient(&states, &of);
        let (body, grid) = (Body::half_space(Material::from_young(2.0, 0.3).unwrap()), grid());
        let interface = Interface::with_boundary(case.boundary, &body, &grid, &case.heights, law).unwrap();
        let mut modulus = 0.0;
        for (step, state) in states.iter().enumerate() {
            let alone = interface.gradient(state.law().unwrap(), case.drives[step].load, &of[step]).unwrap();
            approx::assert_relative_eq!(along.loads[step], alone.load, max_relative = 1e-9);
            modulus += alone.modulus;
        }
        approx::assert_relative_eq!(along.modulus, modulus, max_relative = 1e-8);
    }
}

#[test]
fn a_body_that_relaxes_passes_derivatives_back() {
    check(&Case::of("memory").relaxing(Relaxes::Both));
    check(&Case::of("memory, driven").relaxing(Relaxes::Both).driven());
    check(&Case::of("memory, free").relaxing(Relaxes::Shear).free());
    check(&Case::of("memory, slab").relaxing(Relaxes::Both).slab(0.3, 0.4));
    check(&Case::of("memory of waves").relaxing(Relaxes::Shear).slab(0.3, 0.4));
    check(&Case::of("memory of waves, driven").relaxing(Relaxes::Shear).slab(0.3, 0.4).driven());
}

#[test]
fn a_body_that_relaxes_below_a_law_passes_derivatives_back() {
    let law = Exponential::new(1e-4, 4e-3).unwrap();
    check(&Case::of("law, memory").relaxing(Relaxes::Both).with(law));
    check(&Case::of("law, memory, driven").relaxing(Relaxes::Both).with(law).driven());
    check(&Case::of("law, memory, free").relaxing(Relaxes::Both).with(law).free());
    check(&Case::of("law, memory of waves").relaxing(Relaxes::Shear).slab(0.3, 0.4).with(law));
    let soft = Morse::new(2e-4, 6e-3).unwrap();
    check(&Case::of("Morse, memory").relaxing(Relaxes::Shear).with(soft));
}

#[test]
fn surfaces_that_wear_pass_derivatives_back() {
    check(&Case::of("wear").wearing());
    check(&Case::of("wear, driven").wearing().driven());
    check(&Case::of("wear, free").wearing().free());
    check(&Case::of("wear, slab").wearing().slab(0.3, 0.4));
    check(&Case::of("memory, wear").relaxing(Relaxes::Both).wearing());
    check(&Case::of("memory, wear, driven").relaxing(Relaxes::Both).wearing().driven());
    check(&Case::of("memory of waves, wear").relaxing(Relaxes::Shear).slab(0.3, 0.4).wearing());
}

#[test]
fn surfaces_that_wear_and_attract_pass_derivatives_back() {
    let law = Exponential::new(1e-4, 4e-3).unwrap();
    check(&Case::of("law, wear").with(law).wearing());
    check(&Case::of("law, wear, driven").with(law).wearing().driven());
    check(&Case::of("law, wear, free").with(law).wearing().free());
    check(&Case::of("law, memory, wear").relaxing(Relaxes::Both).with(law).wearing());
}

/// Without a law, all lengths and loads together scale the states, whatever was before.
#[test]
fn heights_and_loads_together_scale_the_number() {
    for case in [
        Case::of("wall"),
        Case::of("memory").relaxing(Relaxes::Both),
        Case::of("memory of waves").relaxing(Relaxes::Shear).slab(0.3, 0.4),
        Case::of("memory, wear, free").relaxing(Relaxes::Both).wearing().free(),
        Case::of("wear, driven").wearing().driven(),
    ] {
        let states = case.follow();
        for (of_energy, degree) in [(false, 1.0), (true, 2.0)] {
            let of: Vec<Cotangents> = cotangents(&case)
                .into_iter()
                .map(|of| match of_energy {
                    true => Cotangents { elastic_energy: of.elastic_energy, ..Cotangents::default() },
                    false => Cotangents { elastic_energy: 0.0, ..of },
                })
                .collect();
            let found = case.gradient(&states, &of);
            let scaled = (&found.heights * &case.heights).sum()
                + found.loads.iter().zip(&case.drives).map(|(by, drive)| by * load_of(drive)).sum::<f64>();
            let wanted = degree * value(&of, &states);
            assert!((scaled - wanted).abs() <= 1e-8 * wanted.abs(), "{}: {scaled} {wanted}", case.name);
            assert!(found.heights.sum().abs() <= 1e-8 * found.heights.mapv(f64::abs).sum(), "{}", case.name);
        }
    }
}

/// A number of the first states alone does not depend on later loads, but heights count for all states.
#[test]
fn the_first_states_know_nothing_of_the_last() {
    let case = Case::of("memory, wear").relaxing(Relaxes::Both).wearing();
    let states = case.follow();
    let mut of = cotangents(&case);
    of[2..].fill(Cotangents::default());
    let all = case.gradient(&states, &of);
    let first = Case { drives: case.drives[..2].to_vec(), ..case.clone() }.gradient(&states[..2], &of[..2]);
    assert_eq!(all.loads[2..], [0.0; 2]);
    assert_eq!((all.loads[..2].to_vec(), &all.heights), (first.loads, &first.heights));
    // Without derivatives there is no gradient, and without increments no load.
    let increments: Vec<Increment> =
        states.iter().map(|state| Increment { load: Load::MeanPressure(0.0), state, of: None }).collect();
    let none = case.contact().gradient_along(&increments).unwrap();
    assert!(none.loads.iter().all(|by| *by == 0.0) && none.heights.iter().all(|by| *by == 0.0));
    assert_eq!(case.contact().gradient_along(&[]).unwrap().loads, Vec::<f64>::new());
}

/// Steps in several increments have the derivatives of their increments, and their states.
#[test]
fn steps_are_made_of_increments() {
    let mut case = Case::of("memory, wear").relaxing(Relaxes::Both).wearing();
    case.drives.truncate(3);
    let steps: Vec<(Drive, u64)> = case.drives.iter().copied().zip([1, 3, 2]).collect();
    let increments = [1, 3, 2];
    let budget = Budget { tolerance: TOLERANCE, ..Budget::default() };
    let value_of = |case: &Case| {
        let steps: Vec<(Drive, u64)> = case.drives.iter().copied().zip(increments).collect();
        let states = follow(&case.contact(), &steps, &budget, &mut ()).unwrap();
        (value(&cotangents(case), &states), states)
    };
    let (_, states) = value_of(&case);
    let of = cotangents(&case);
    let all: Vec<Increment> = states
        .iter()
        .zip(&of)
        .map(|(state, of)| Increment { load: Load::MeanPressure(0.0), state, of: Some(of) })
        .collect();
    let found = case.contact().gradient_along(&all).unwrap().of_steps(&increments);
    for (step, by) in found.loads.iter().enumerate() {
        let size = 1e-4 * load_of(&case.drives[step]);
        let at = |times: f64| value_of(&case.with_load(step, times * size)).0;
        let wanted = (8.0 * (at(1.0) - at(-1.0)) - (at(2.0) - at(-2.0))) / (12.0 * size);
        assert!((by - wanted).abs() <= 1e-6 * wanted.abs(), "load {step}: {by} {wanted}");
    }
    let contact = case.contact();
    let refinement = Refinement { tolerance: 1e-9, solves_per_step: 3 };
    let mut path = Path::new(&contact, budget, refinement);
    let made: Vec<u64> = steps.iter().map(|(drive, _)| path.step(*drive, &mut ()).unwrap().increments).collect();
    assert!(made.iter().any(|count| *count > 1), "{made:?}");
    let steps: Vec<(Drive, u64)> = case.drives.iter().copied().zip(made).collect();
    let states = follow(&contact, &steps, &budget, &mut ()).unwrap();
    let (last, reached) = (states.last().unwrap(), path.state().unwrap());
    let most = last.pressure().iter().fold(0.0, |most: f64, p| most.max(*p));
    // Increments within a step are solved to a tenth of the tolerance of the path.
    let apart = (&last.pressure() - &reached.pressure()).iter().fold(0.0, |most: f64, by| most.max(by.abs()));
    assert!(apart <= refinement.tolerance * most, "{apart:e} of {most:e}");
}

#[test]
fn units_change_nothing() {
    let case = Case::of("memory, wear").relaxing(Relaxes::Both).wearing();
    let states = case.follow();
    let of = cotangents(&case);
    let plain = case.gradient(&states, &of);
    let factor = 2.0_f64.powi(-40);
    let scaled = Case {
        factor,
        wear: case.wear.map(|wear| wear / factor),
        drives: case
            .drives
            .iter()
            .map(|drive| Drive { load: Load::MeanPressure(load_of(drive) * factor), ..*drive })
            .collect(),
        ..case.clone()
    };
    let of: Vec<Cotangents> = of
        .into_iter()
        .map(|of| Cotangents {
            pressure: of.pressure.map(|by| by / factor),
            mean_pressure: of.mean_pressure / factor,
            elastic_energy: of.elastic_energy / factor,
            ..of
        })
        .collect();
    let found = scaled.gradient(&scaled.follow(), &of);
    let most = plain.heights.iter().fold(0.0, |most: f64, by| most.max(by.abs()));
    assert!((&plain.heights - &found.heights).iter().all(|apart| apart.abs() <= 1e-8 * most));
    for (plain, found) in plain.loads.iter().zip(&found.loads) {
        approx::assert_relative_eq!(*plain, found * factor, max_relative = 1e-7);
    }
    approx::assert_relative_eq!(plain.modulus, found.modulus * factor, max_relative = 1e-7);
}

#[test]
fn paths_without_derivatives_are_refused() {
    let case = Case::of("memory").relaxing(Relaxes::Both);
    let states = case.follow();
    let contact = case.contact();
    let at = |states: &[QuasistaticState], of: &Cotangents| -> PathGradientError {
        let load = Load::MeanPressure(0.0);
        let all: Vec<Increment> = states.iter().map(|state| Increment { load, state, of: Some(of) }).collect();
        contact.gradient_along(&all).unwrap_err()
    };
    let none = Cotangents::default();
    let wrong = Cotangents { gap: Some(Array2::zeros((3, 4))), ..none.clone() };
    let text = "increment 1: the shape of the derivative by the gap is [3, 4]; it must be [12, 10], the shape of the \
                contact";
    assert_eq!(at(&states, &wrong).to_string(), text);
    let wrong = Cotangents { plastic_depth: Some(Array2::zeros((12, 10))), ..none.clone() };
    let text =
        "increment 1: the derivative by the plastic depth is given; it must be left out, since the contact has none";
    assert_eq!(at(&states, &wrong).to_string(), text);
    for wrong in [
        Cotangents { mean_shear: [0.0, 1.0], ..none.clone() },
        Cotangents { shear: Some(Array3::zeros((2, 12, 10))), ..none.clone() },
    ] {
        let text = at(&states, &wrong).to_string();
        assert!(text.contains("shear traction is given; it must be left out, since the contact has none"), "{text}");
    }
    let wrong = Cotangents { approach: f64::NAN, ..none.clone() };
    assert!(at(&states, &wrong).to_string().contains("by the approach has NaN; it must be finite"));
    let reversed: Vec<QuasistaticState> = states.iter().rev().cloned().collect();
    assert!(matches!(at(&reversed, &none), PathGradientError::Refused(_)));
    let elastic = Case::of("wall").follow();
    assert!(matches!(at(&elastic, &none), PathGradientError::Refused(_)));
    let later = Case { drives: case.drives[1..].to_vec(), ..case.clone() }.with(Exponential::new(1e-4, 4e-3).unwrap());
    let states = later.follow();
    let increment = Increment { load: Load::MeanPressure(0.0), state: &states[0], of: None };
    let error = later.contact().gradient_along(&[increment]).unwrap_err();
    assert!(matches!(error, PathGradientError::Drawn { found } if found == 0.4), "{error}");

    let (body, grid, heights) = (Body::half_space(Material::from_young(2.0, 0.3).unwrap()), grid(), case.heights);
    let plain = Parts::new(&body, &grid, &heights);
    let refused = |parts: &Parts| {
        let contact = QuasistaticContact::new(parts).unwrap();
        contact.gradient_along(&[]).unwrap_err().to_string()
    };
    let separation =
        Separation { normal_work: 2e-3, tangential_work: 2e-3, normal_length: 0.03, tangential_length: 0.03 };
    let law = CoupledExponential::new(separation).unwrap().into_shared();
    let lateral = refused(&Parts { law: Some(law), all_components: true, ..plain });
    assert!(lateral.starts_with("all components of displacement are unknown"), "{lateral}");
}
