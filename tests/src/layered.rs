//! Layered bodies on every base, and pairs of bodies: dense solutions of small problems, stresses on either side of
//! interfaces, and closed forms of thin layers.

use gfmd_body::Interior;
use gfmd_contact::{Contact, Equilibrium, Load, Solver};
use gfmd_field::Grid;
use gfmd_green::{Base, BaseKind, Body, Height, Material};
use gfmd_mixed::{Edge, FlatPunch, Method, MixedProblem, Prescribed};
use gfmd_relax::Budget;
use ndarray::{Array2, Axis};
use serde_json::Value;

use crate::check::{Worst, order};
use crate::{Check, Reference, ValidationError};

const DENSE: &str = "dense active sets, waves by boundary-value problems with 40 digits";
const WAVES: &str = "boundary-value problems with 40 digits";

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let file = File(reference.json("layered_bodies.json")?);
    let mut checks = file.contacts()?;
    checks.push(file.dynamics()?);
    checks.extend(file.punches()?);
    checks.push(file.waves()?);
    checks.extend(thin_layers()?);
    checks.extend(strip()?);
    checks.push(pair()?);
    Ok(checks)
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().into_iter().flatten().map(|number| number.as_f64().unwrap_or(f64::NAN)).collect()
}

pub(crate) struct File(pub(crate) Value);

impl File {
    pub(crate) fn rows(&self, key: &str) -> impl Iterator<Item = &Value> {
        self.0[key].as_array().into_iter().flatten()
    }

    pub(crate) fn one(&self, name: &str) -> Result<Body, ValidationError> {
        let body = &self.0["bodies"][name];
        let mut layers = Vec::new();
        let mut base =
            body["base"].as_str().and_then(|name| name.parse::<BaseKind>().ok()).unwrap_or_default().with(None)?;
        for row in body["layers"].as_array().into_iter().flatten() {
            let [young, poisson, height] = [0, 1, 2].map(|k| row[k].as_f64());
            let material = Material::from_young(young.unwrap_or(f64::NAN), poisson.unwrap_or(f64::NAN))?;
            match height {
                Some(height) => layers.push((material, height)),
                None if layers.is_empty() => return Ok(Body::half_space(material)),
                None => base = Base::Elastic(Body::half_space(material).into()),
            }
        }
        Ok(Body::stack(&layers, base)?)
    }

    /// Returns the body of a problem and its name.
    fn body(&self, problem: &Value) -> Result<(Body, String), ValidationError> {
        let name = problem["body"].as_str().unwrap_or_default();
        let body = self.one(name)?;
        match problem["second"].as_str() {
            Some(second) => Ok((body.against(self.one(second)?), format!("{name} against a {second}"))),
            None => Ok((body, name.to_owned())),
        }
    }

    fn surface(&self) -> Result<(Grid, Array2<f64>), ValidationError> {
        let surface = &self.0["surface"];
        let (points, lengths) = (numbers(&surface["points"]), numbers(&surface["lengths"]));
        let grid = Grid::new([points[0] as usize, points[1] as usize], [lengths[0], lengths[1]])?;
        let heights = numbers(&surface["heights"]);
        Ok((grid, Array2::from_shape_fn(grid.points(), |(i, j)| heights[i * grid.points()[1] + j])))
    }

    fn compare(
        &self,
        problem: &Value,
        solver: Solver,
        tolerance: f64,
        worst: &mut Worst,
    ) -> Result<(), ValidationError> {
        let (grid, heights) = self.surface()?;
        let (body, _) = self.body(problem)?;
        let get = |key: &str| problem[key].as_f64().unwrap_or(f64::NAN);
        let load = match problem["control"].as_str() {
            Some("approach") => Load::Approach(get("approach")),
            _ => Load::MeanPressure(get("mean_pressure")),
        };
        let pressure = numbers(&problem["pressure"]);
        let peak = pressure.iter().copied().fold(0.0, f64::max);
        let contact = Contact::new(&body, &grid, &heights)?;
        let solution = contact.press(load).solver(solver).tolerance(tolerance).solve()?;
        solution.pressure.iter().zip(&pressure).for_each(|(found, exact)| worst.compare_to(*found, *exact, peak));
        worst.compare(solution.approach, get("approach"));
        worst.compare(solution.mean_pressure, get("mean_pressure"));
        worst.compare(solution.pressure.iter().filter(|p| **p > 0.0).count() as f64, get("contact_nodes"));
        Ok(())
    }

    /// Solves every problem by every method of conjugate gradients.
    fn contacts(&self) -> Result<Vec<Check>, ValidationError> {
        let mut checks: Vec<(String, Worst)> = Vec::new();
        for problem in self.rows("contacts") {
            let (_, name) = self.body(problem)?;
            if checks.last().is_none_or(|(last, _)| *last != name) {
                checks.push((name, Worst::new()));
            }
            for solver in [Solver::PreconditionedCg, Solver::ProjectedCg, Solver::PolonskyKeer] {
                if let Some((_, worst)) = checks.last_mut() {
                    self.compare(problem, solver, 1e-12, worst)?;
                }
            }
        }
        let check = |(name, worst): (String, Worst)| worst.check(format!("contact, {name}"), DENSE, 1e-8);
        Ok(checks.into_iter().map(check).collect())
    }

    /// Solves the first problem of some bodies by the dynamics.
    fn dynamics(&self) -> Result<Check, ValidationError> {
        let mut worst = Worst::new();
        for name in ["sliding", "plate", "coated"] {
            let named = self.rows("contacts").filter(|problem| problem["body"] == name && problem["second"].is_null());
            for problem in named.skip(1) {
                for solver in [Solver::Verlet, Solver::Fire2, Solver::AugmentedLagrangian] {
                    self.compare(problem, solver, 1e-10, &mut worst)?;
                }
            }
        }
        Ok(worst.check("contact by dynamics: sliding base, plate, coating", DENSE, 1e-8))
    }

    /// Checks sticking punches.
    fn punches(&self) -> Result<Vec<Check>, ValidationError> {
        let geometry = &self.0["punch"];
        let (points, lengths) = (numbers(&geometry["points"]), numbers(&geometry["lengths"]));
        let grid = Grid::new([points[0] as usize, points[1] as usize], [lengths[0], lengths[1]])?;
        let depth = geometry["depth"].as_f64().unwrap_or(f64::NAN);
        let under: Vec<[usize; 2]> = self
            .rows("under")
            .map(|at| [0, 1].map(|axis| at[axis].as_u64().map_or(usize::MAX, |index| index as usize)))
            .collect();
        let mut mask = Array2::from_elem(grid.points(), false);
        under.iter().for_each(|at| mask[*at] = true);
        let mut checks = Vec::new();
        for problem in self.rows("punches") {
            let (body, name) = self.body(problem)?;
            let exact = numbers(&problem["traction"]);
            let peak = exact.iter().fold(0.0, |peak: f64, t| peak.max(t.abs()));
            let mut worst = Worst::new();
            for method in [Method::ConjugateGradients, Method::Verlet] {
                let held = Prescribed::sticking(&grid, mask.view(), [0.0, 0.0, -depth])?;
                let budget = Budget { tolerance: 1e-11, ..Budget::default() };
                let solution = MixedProblem::new(&body, &grid, held)?.solve(method, &budget, &mut ())?;
                let found = (0..3).flat_map(|c| under.iter().map(move |[i, j]| [c, *i, *j]));
                found.zip(&exact).for_each(|(at, exact)| worst.compare_to(solution.traction[at], *exact, peak));
            }
            checks.push(worst.check(format!("sticking punch, {name}"), "dense solution, 40-digit waves", 1e-8));
        }
        Ok(checks)
    }

    /// Checks displacement and stress below a wave of pressure, on both sides of every interface.
    fn waves(&self) -> Result<Check, ValidationError> {
        let mut worst = Worst::new();
        for row in self.rows("waves") {
            let (body, _) = self.body(row)?;
            let (q, n) = (row["q"].as_f64().unwrap_or(f64::NAN), 16);
            let grid = Grid::line(n, 2.0 * std::f64::consts::TAU / q)?;
            // Two waves on the grid: exp(i q x) is a cosine for z, and i exp(i q x) a negative sine for x.
            let wave = |i: usize| (2.0 * std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
            let surface: Vec<f64> = (0..n).map(|i| body.normal_compliance(q) * wave(i).1).collect();
            let interior = Interior::frictionless(&body, grid, &surface)?;
            let mut ws = interior.workspace();
            let mut last = f64::NAN;
            for state in row["states"].as_array().into_iter().flatten() {
                let get = |key: &str| state[key].as_f64().unwrap_or(f64::NAN);
                let asked = get("depth");
                let planes = body.interfaces();
                let depth = planes.into_iter().find(|depth| (depth - asked).abs() < 1e-12).unwrap_or(asked);
                let depth = if (depth - body.total_height()).abs() < 1e-12 { body.total_height() } else { depth };
                let [a, w, tau, zz, xx] = ["a", "w", "tau", "zz", "xx"].map(get);
                let size = body.normal_compliance(q);
                let u = interior.displacement(depth, &mut ws)?.to_vec();
                // The second state at a depth belongs to the lower layer.
                let below = depth == last;
                let state = if below {
                    interior.deformation_below(depth, &mut ws)?
                } else {
                    interior.deformation(depth, &mut ws)?
                };
                last = depth;
                for i in 0..n {
                    let (sine, cosine) = wave(i);
                    worst.compare_to(u[i], -a * sine, size);
                    worst.compare_to(u[n + i], w * cosine, size);
                    let [found_xx, _, found_zz, _, found_xz, _] = state.at(i).stress;
                    for (found, wanted) in [(found_xx, xx * cosine), (found_zz, zz * cosine), (found_xz, -tau * sine)] {
                        worst.compare_to(found, wanted, 1.0);
                    }
                }
            }
        }
        Ok(worst.check("displacement and stress on both sides of interfaces", WAVES, 1e-11))
    }
}

/// Checks a cylinder on a thin layer. The layer deforms point by point, with the modulus C11 on a bonded base and E* on
/// a sliding one, where in addition the lateral stress of the confined layer is uniform (theory.md, section 4.1). The
/// error falls with h/a.
fn thin_layers() -> Result<Vec<Check>, ValidationError> {
    let material = Material::from_young(1.0, 0.25)?;
    let (n, a, radius) = (4096_u16, 0.2_f64, 1.0);
    let grid = Grid::line(usize::from(n), 1.0)?;
    let heights =
        Array2::from_shape_fn((grid.len(), 1), |(i, _)| -0.5 * (i as f64 / f64::from(n) - 0.5).powi(2) / radius);
    let approach = 0.5 * a * a / radius;
    let mut checks = Vec::new();
    let push = (material.poisson() / (1.0 - material.poisson())).powi(2);
    let moduli = [("bonded", 1.0 / material.p_wave_compliance(), 0.0), ("sliding", material.contact_modulus(), push)];
    for (base, modulus, push) in moduli {
        let mut errors = Vec::new();
        for thinner in [1_u16, 2, 4] {
            let height = 0.04 / f64::from(thinner);
            let kind: BaseKind = base.parse().unwrap_or_default();
            let body = Body::slab(material, height)?.on(kind.with(None)?)?;
            let contact = Contact::new(&body, &grid, &heights)?;
            let solution = contact.press(Load::Approach(approach)).tolerance(1e-9).solve()?;
            let mut expected = 0.0;
            for _ in 0..100 {
                // Half width of the contact including the bulge around it.
                let half = (2.0 * radius * (approach + push * expected * height / modulus)).sqrt();
                expected = 2.0 / 3.0 * half.powi(3) / radius * modulus / height;
            }
            errors.push((usize::from(thinner), [(solution.mean_pressure / expected - 1.0).abs()]));
        }
        let last = errors.last().map_or(f64::NAN, |(_, error)| error[0]);
        let name = format!("cylinder on a thin layer, {base} base");
        checks.push(Check::error(format!("{name}: load, height a/20"), "Johnson 1985, section 5.8", last, 0.06));
        checks.push(Check::at_least(
            format!("{name}: order in the height"),
            "Johnson 1985, section 5.8",
            order(&errors)[0],
            0.9,
        ));
    }
    Ok(checks)
}

/// Checks a rigid strip without friction on a thin bonded layer. Below it the layer is compressed uniformly, with the
/// modulus C11; the edges add a contribution that falls with h/a.
fn strip() -> Result<[Check; 2], ValidationError> {
    let material = Material::from_young(1.0, 0.25)?;
    let (grid, punch) = (Grid::line(4096, 1.0)?, FlatPunch::new(0.25, Edge::Inclusive)?);
    let (depth, width) = (1e-3, punch.effective_width(&grid));
    let mut errors = Vec::new();
    for thinner in [1_u16, 2, 4] {
        let height = 0.04 / f64::from(thinner);
        let held = Prescribed::frictionless(&grid, punch.points(&grid).view(), -depth)?;
        let budget = Budget { tolerance: 1e-9, ..Budget::default() };
        let problem = MixedProblem::new(&Body::slab(material, height)?, &grid, held)?;
        let solution = problem.solve(Method::ConjugateGradients, &budget, &mut ())?;
        let force = -solution.traction.index_axis(Axis(0), 1).sum() / grid.len() as f64;
        let expected = depth / height / material.p_wave_compliance() * width;
        errors.push((usize::from(thinner), [(force / expected - 1.0).abs()]));
    }
    let last = errors.last().map_or(f64::NAN, |(_, error)| error[0]);
    let name = "rigid strip on a thin layer, bonded base";
    let origin = "Johnson 1985, section 5.8";
    Ok([
        Check::error(format!("{name}: force, height a/12"), origin, last, 0.06),
        Check::at_least(format!("{name}: order in the height"), origin, order(&errors)[0], 0.9),
    ])
}

/// Checks that two half-spaces have pressure and approach of one half-space with the composite modulus.
fn pair() -> Result<Check, ValidationError> {
    let (first, second) = (Material::from_young(1.0, 0.3)?, Material::from_young(5.0, 0.45)?);
    let pair = Body::half_space(first).against(Body::new(second, Height::Infinite)?);
    let one = Body::half_space(Material::from_contact_modulus(pair.contact_modulus(), 0.0)?);
    let grid = Grid::square(64, 1.0)?;
    let wave = |i: usize, turns: f64| (std::f64::consts::TAU * turns * i as f64 / 64.0).cos();
    let heights = Array2::from_shape_fn((64, 64), |(i, j)| 0.01 * (wave(i, 1.0) + wave(j, 2.0) * wave(i, 3.0)));
    let [a, b] = [pair, one].map(|body| -> Result<_, ValidationError> {
        let contact = Contact::new(&body, &grid, &heights)?;
        Ok(contact.press(Load::MeanPressure(0.01)).tolerance(1e-12).solve()?)
    });
    let (a, b) = (a?, b?);
    let mut worst = Worst::new();
    let peak = b.pressure.iter().copied().fold(0.0, f64::max);
    a.pressure.iter().zip(&b.pressure).for_each(|(found, wanted)| worst.compare_to(*found, *wanted, peak));
    worst.compare(a.approach, b.approach);
    Ok(worst.check("two half-spaces: pressure, approach", "the half-space of the composite modulus", 1e-9))
}
