//! Numbers of each load of a contact, compared with their definitions.

use gfmd_files::Reader;
use serde_json::Value;

use super::draw::{Body, Case, Components, Control, Law};
use super::elastic::{Base, Dense, Plane, Stack, Top, layered, love};
use super::found::{Found, number};
use super::numbers::{deviation, excess, flow, gradient, largest, links, mean, neighbours, patches, steepest};
use super::path::{Vectors, all_components};

/// Dense compliance of a case and its allowed error: the sums of layered patches are a quadrature.
pub(crate) struct Elastic {
    pub(crate) dense: Dense,
    pub(crate) tolerance: f64,
}

/// Returns the dense compliance for downward displacements by pressures.
pub(crate) fn elastic(case: &Case) -> Elastic {
    elastic_of(&case.body, case.plane, case.is_free, case.components == Components::Held)
}

/// Returns the dense compliance of a body, `held` sideways or not.
pub(crate) fn elastic_of(body: &Body, plane: Plane, is_free: bool, held: bool) -> Elastic {
    if !is_free {
        return Elastic { dense: Dense::periodic(plane, |q| body.compliance(q, held)), tolerance: 1e-8 };
    }
    let modulus = body.contact_modulus();
    if body.is_half_space() {
        return Elastic { dense: Dense::free(plane, love(plane, modulus)), tolerance: 1e-8 };
    }
    let stacks = [Some(&body.first), body.second.as_ref()];
    let least = stacks.iter().flatten().filter_map(|stack| stack.layers.first()).map(|layer| layer.height);
    let sum = stacks.iter().flatten().map(|stack| stack.height()).fold(0.0, f64::max);
    let heights = [least.fold(f64::INFINITY, f64::min), sum];
    let of_cell = layered(plane, modulus, heights, body.lowest(), |q| body.compliance(q, false));
    Elastic { dense: Dense::free(plane, of_cell), tolerance: 1e-6 }
}

/// Surface pressed on the body, and the lift by its base alone.
pub(crate) struct Rough {
    pub(crate) heights: Vec<f64>,
    pub(crate) lift: Vec<f64>,
    /// Clearance beyond first touch.
    pub(crate) clearance: Vec<f64>,
    pub(crate) gradient: f64,
    pub(crate) deviation: f64,
}

impl Rough {
    pub(crate) fn new(case: &Case, heights: Vec<f64>) -> Self {
        let lift = lift(case);
        let lifted: Vec<f64> = heights.iter().zip(&lift).map(|(h, w)| h + w).collect();
        let top = lifted.iter().fold(f64::NEG_INFINITY, |top, h| top.max(*h));
        let clearance = lifted.iter().map(|h| top - h).collect();
        let (gradient, deviation) = (gradient(case.plane, &lifted, case.is_free), deviation(&lifted));
        Self { heights, lift, clearance, gradient, deviation }
    }
}

/// Returns u_z of the unloaded surface over a moving base.
fn lift(case: &Case) -> Vec<f64> {
    let plane = case.plane;
    let Some((field, is_traction)) = &case.moved else { return vec![0.0; plane.len()] };
    let parts = [0, 1, 2].map(|c| plane.transform(&field.iter().map(|at| at[c]).collect::<Vec<f64>>()));
    let modes: Vec<[f64; 2]> = (0..plane.len())
        .map(|place| {
            let [x, y] = plane.wave(place);
            let q = x.hypot(y);
            if q == 0.0 {
                return if *is_traction { [0.0; 2] } else { parts[2][place] };
            }
            // A wave along the base, b = sin(q x), is -i in exponentials.
            let shortest = plane.is_shortest(place);
            let n = [0, 1].map(|axis| if shortest[axis] { 0.0 } else { [x, y][axis] / q });
            let along = [0, 1].map(|part| n[0] * parts[0][place][part] + n[1] * parts[1][place][part]);
            let surface = |top| case.body.first.solve(q, top).at(0.0, false);
            // A surface held sideways has the shear that takes it back.
            let uz = |top| match (surface(top), surface(Top::Sheared)) {
                (free, sheared) if case.components == Components::Held => free.uz - free.ux / sheared.ux * sheared.uz,
                (free, _) => free.uz,
            };
            let (up, sideways) = match is_traction {
                // An upward traction on the lower face is a pressure there, and a traction along the wave is -sxz.
                true => (uz(Top::PressedBelow), -uz(Top::ShearedBelow)),
                false if case.body.first.base == Base::Sliding => (uz(Top::BaseUp), 0.0),
                false => (uz(Top::BaseUp), uz(Top::BaseAlong)),
            };
            let [re, im] = parts[2][place];
            [up * re - sideways * along[1], up * im + sideways * along[0]]
        })
        .collect();
    plane.inverse(&modes)
}

/// Returns the displacements of both faces into the slab, for the pressures on both.
pub(crate) fn faces(stack: &Stack, plane: Plane, held: bool, pressures: [&[f64]; 2]) -> [Vec<f64>; 2] {
    let [upper, lower] =
        if held { [Top::HeldBetween, Top::HeldBetweenBelow] } else { [Top::Pressed, Top::PressedBelow] };
    let parts = pressures.map(|pressure| plane.transform(pressure));
    let mut both = [vec![[0.0; 2]; plane.len()], vec![[0.0; 2]; plane.len()]];
    for place in 0..plane.len() {
        let [x, y] = plane.wave(place);
        let q = x.hypot(y);
        let matrix = if q == 0.0 {
            let half = 0.5 * stack.compliance(0.0, false);
            [[half, 0.0], [0.0, half]]
        } else {
            let (above, below) = (stack.solve(q, upper), stack.solve(q, lower));
            let bottom = stack.height();
            [
                [-above.at(0.0, false).uz, -below.at(0.0, false).uz],
                [above.at(bottom, false).uz, below.at(bottom, false).uz],
            ]
        };
        for (face, row) in both.iter_mut().zip(matrix) {
            face[place] = [0, 1].map(|part| row[0] * parts[0][place][part] + row[1] * parts[1][place][part]);
        }
    }
    both.map(|modes| plane.inverse(&modes))
}

/// Returns the surely and the possibly repelled points, and the repulsive pressure. For a law with a wall this is the
/// wall pressure, which the file may hold.
pub(crate) fn repulsion(
    case: &Case,
    pressure: &[f64],
    gap: &[f64],
    wall: Option<Vec<f64>>,
) -> (Vec<bool>, Vec<bool>, Vec<f64>) {
    let touching = |pressure: &[f64]| pressure.iter().map(|p| *p > 0.0).collect::<Vec<bool>>();
    let Some(law) = &case.law else { return (touching(pressure), touching(pressure), pressure.to_vec()) };
    if let Some(wall) = wall {
        return (touching(&wall), touching(&wall), wall);
    }
    if !law.has_wall() {
        // Beyond the range of a law the pressure is the remaining imbalance, of either sign.
        let left = pressure.iter().zip(gap).map(|(p, g)| (p + law.tension(*g)).abs()).fold(0.0, f64::max);
        let allowed = 2.01 * left.max(case.tolerance * largest(pressure)) + 1e-13 * largest(pressure);
        let surely = pressure.iter().map(|p| *p > allowed).collect();
        let repels = |(p, g): (&f64, &f64)| *p > 1.99 * left || law.tension(*g) < 0.0;
        let possibly: Vec<bool> = pressure.iter().zip(gap).map(repels).collect();
        let repelled = pressure.iter().zip(&possibly).map(|(p, repels)| if *repels { p.max(0.0) } else { 0.0 });
        return (surely, possibly.clone(), repelled.collect());
    }
    let repelled: Vec<f64> = pressure
        .iter()
        .zip(gap)
        .map(|(p, g)| if *g > 1e-9 * largest(gap) { 0.0 } else { (p + law.tension(g.max(0.0))).max(0.0) })
        .collect();
    let scale = largest(&repelled).max(largest(pressure));
    let surely = repelled.iter().map(|p| *p > 1e-4 * scale).collect();
    (surely, touching(&repelled), repelled)
}

/// Returns the wall pressure that the file holds beside an attraction.
fn wall_pressure(file: &Reader, k: usize, face: &str) -> Option<Vec<f64>> {
    let name = format!("/fields/{face}repulsion");
    file.contains(&name).then(|| file.slab(&name, k).unwrap())
}

/// Checks that pressure, gap and repulsion obey the law at every point. Returns the mean and the largest energy of the
/// law, if it has one.
fn lawful(
    found: &mut Found,
    case: &Case,
    law: &Law,
    [pressure, gap, repulsion]: [&[f64]; 3],
    scale: f64,
) -> Option<[f64; 2]> {
    let traction = largest(pressure).max(largest(repulsion));
    for at in 0..pressure.len() {
        if law.jump().is_some_and(|jump| (gap[at] - jump).abs() < 1e-6 * jump) {
            continue;
        }
        let unbalanced = pressure[at] + law.tension(gap[at].max(if law.has_wall() { 0.0 } else { f64::NEG_INFINITY }));
        let error =
            if law.has_wall() { (unbalanced - repulsion[at]).abs().max(-repulsion[at]) } else { unbalanced.abs() };
        let allowed = 30.0 * case.tolerance * traction.max(softest(case) * scale) + 1e-9 * traction;
        found.must(error <= allowed, || format!("the law at point {at} leaves {error:e} of {traction:e}"));
    }
    let energies: Option<Vec<f64>> =
        gap.iter().map(|g| law.energy(if law.has_wall() { g.max(0.0) } else { *g })).collect();
    energies.map(|energies| [mean(&energies), largest(&energies)])
}

/// Checks the numbers of one face that count points and sum pressures.
pub(crate) fn counted(
    found: &mut Found,
    case: &Case,
    record: &Value,
    repelled: (&[bool], &[bool], &[f64]),
    gap: &[f64],
) {
    let (plane, (surely, possibly, repulsion)) = (case.plane, repelled);
    let points = plane.len() as f64;
    let count = |set: &[bool]| set.iter().filter(|belongs| **belongs).count() as f64;
    let (least, most) = (count(surely), count(possibly));
    let has = |key: &str| record.get(key).is_some();
    let area = number(record, "area_fraction") * points;
    found.must(least - 1e-6 <= area && area <= most + 1e-6, || {
        format!("area_fraction is {} points; {least} to {most} are repelled", area)
    });
    if has("contact_nodes") {
        found.near("contact_nodes", number(record, "contact_nodes"), area, 1e-6);
    }
    let reported = number(record, "mean_gap");
    // In full contact with a wall the gap is reported as zero, although the search leaves a gap within its tolerance.
    if reported == 0.0 && least == points {
        found.near("mean_gap in full contact", mean(gap), 0.0, case.tolerance.max(1e-9) * case.plane.length[0]);
    } else {
        found.near("mean_gap", reported, mean(gap), 1e-9 * largest(gap));
    }
    if has("max_pressure") {
        found.near("max_pressure", number(record, "max_pressure"), largest(repulsion), 1e-7 * largest(repulsion));
    }
    if least == most {
        let edges = links(plane, surely, case.is_free);
        if has("boundary_links") {
            found.near("boundary_links", number(record, "boundary_links"), edges as f64, 0.0);
            let corrected = if case.is_line {
                least / points
            } else {
                (least / points - excess() * edges as f64 / points).max(0.0)
            };
            found.near("area_fraction_corrected", number(record, "area_fraction_corrected"), corrected, 1e-12);
        }
        if has("mean_pressure_in_contact") && least > 0.0 {
            let inside = repulsion.iter().sum::<f64>() / least;
            found.is(record, "mean_pressure_in_contact", inside, 1e-7);
        }
        if has("pressure_moment_2") {
            let square = repulsion.iter().map(|p| p * p).sum::<f64>() / points;
            found.is(record, "pressure_moment_2", square, 1e-7);
            if least > 0.0 {
                let inside = repulsion.iter().sum::<f64>() / least;
                let about =
                    repulsion.iter().zip(surely).filter(|(_, belongs)| **belongs).map(|(p, _)| (p - inside).powi(2));
                let deviation = (about.sum::<f64>() / least).sqrt();
                let stored = number(record, "pressure_deviation_in_contact");
                found.near("pressure_deviation_in_contact", stored, deviation, 1e-7 * largest(repulsion));
            }
        }
    }
}

/// Checks the conditions of a wall: no tension, no penetration, pressure where the gap is closed. Returns
/// complementarity and penetration divided by the length scale.
pub(crate) fn wall(found: &mut Found, pressure: &[f64], gap: &[f64], scale: f64, tolerance: f64) -> [f64; 2] {
    let sum: f64 = pressure.iter().sum();
    let closed = pressure.iter().zip(gap).map(|(p, g)| p * g).sum::<f64>().abs() / (sum * scale);
    let below = gap.iter().fold(0.0_f64, |below, g| below.max(-g)) / scale;
    let pull = pressure.iter().fold(0.0_f64, |pull, p| pull.max(-p)) / (sum / pressure.len() as f64);
    for (name, value) in [("sum(p gap)", closed), ("penetration", below), ("tension", pull)] {
        found.must(value <= tolerance * 1.000_001 + 1e-13, || format!("{name} is {value:e}, above {tolerance:e}"));
    }
    [closed, below]
}

/// Checks the heights: equal to one file to the last bit, or the sum of two files.
pub(crate) fn given(found: &mut Found, case: &Case, heights: &[f64]) {
    let Some(given) = &case.heights else { return };
    if case.is_composite {
        let apart = given.iter().zip(heights).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        found.near("heights of the composite", apart, 0.0, 1e-12 * largest(given));
    } else {
        found.must(given == heights, || "the heights are not those of the file".into());
    }
}

/// Checks all loads.
pub(crate) fn check(found: &mut Found, case: &Case, report: &Value, file: &Reader) {
    let plane = case.plane;
    let heights = file.values::<f64>("/surface/height").unwrap();
    found.must(heights.len() == plane.len(), || format!("{} heights", heights.len()));
    given(found, case, &heights);
    let rough = Rough::new(case, heights);
    if let Some(asked) = case.asked_gradient {
        let made = gradient(plane, &rough.heights, false);
        found.near("rms gradient of the generator", made, asked, 1e-9 * asked);
    }
    let modulus = case.body.contact_modulus();
    found.near("e_star", number(report, "e_star"), modulus, 1e-12 * modulus);
    // With a moving base, the contact sees the surface displaced by the base alone.
    let displaced: Vec<f64> = rough.heights.iter().zip(&rough.lift).map(|(h, w)| h + w).collect();
    found.near("max_slope", number(report, "max_slope"), steepest(plane, &displaced), 1e-9);
    found.near("rms_gradient", number(report, "rms_gradient"), rough.gradient, 1e-9);
    found.near("rms_height", number(report, "rms_height"), rough.deviation, 1e-9 * rough.deviation);
    if case.moved.is_some() {
        let stored = file.values::<f64>("/base/lift").unwrap();
        let scale = largest(&rough.lift).max(rough.deviation);
        let apart = stored.iter().zip(&rough.lift).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        found.near("lift of the base", apart, 0.0, 1e-8 * scale);
    }
    let gradient_of_load = number(report, "rms_gradient");
    let elastic = elastic(case);
    let loads = report["loads"].as_array().unwrap();
    found.must(loads.len() == case.loads.len(), || format!("{} loads of {}", loads.len(), case.loads.len()));
    for (k, load) in loads.iter().enumerate() {
        let before = found.complaints.len();
        one(found, case, load, k, file, &rough, &elastic, gradient_of_load);
        found.complaints[before..].iter_mut().for_each(|text| *text = format!("load {k}: {text}"));
    }
    if case.threshold {
        threshold(found, case, report, file);
    }
    if case.statistics {
        arrays(found, case, loads, file);
    }
}

#[expect(clippy::too_many_arguments, reason = "all that a load is checked against")]
fn one(
    found: &mut Found,
    case: &Case,
    load: &Value,
    k: usize,
    file: &Reader,
    rough: &Rough,
    elastic: &Elastic,
    gradient: f64,
) {
    let plane = case.plane;
    let field = |name: &str| file.slab::<f64>(&format!("/fields/{name}"), k).unwrap();
    let (pressure, displacement, gap) = (field("pressure"), field("displacement_z"), field("gap"));
    found.must(load["converged"] == true, || "not converged, with status 0".into());
    found.nulls(load, &[]);
    for (name, values) in [("pressure", &pressure), ("displacement_z", &displacement), ("gap", &gap)] {
        found.must(values.iter().all(|value| value.is_finite()), || format!("{name} is not finite everywhere"));
    }
    let modulus = case.body.contact_modulus();
    let mean_pressure = mean(&pressure);
    let stress = largest(&pressure);
    // Loads. The pressure follows from the displacement, the mean pressure from the law; they may differ by the
    // tolerance.
    let unbalanced = if case.law.is_some() { 10.0 * case.tolerance } else { 1e-9 };
    found.near("mean_pressure", number(load, "mean_pressure"), mean_pressure, unbalanced * stress);
    let asked = case.loads[k];
    // The mean pressure of wall and law is the load up to the tolerance, relative to the stress scale of a law.
    let of_stress = match case.law.is_some() {
        true => 2.02 * case.tolerance * stress.max(softest(case) * rough.deviation),
        false => 1.01 * case.tolerance * stress,
    };
    let allowed = |asked: f64| (1.01 * case.tolerance * asked).max(of_stress);
    match case.control {
        Control::Pressure => found.near("load", mean_pressure, asked, allowed(asked)),
        Control::PStar => {
            let asked = asked * modulus * gradient;
            found.near("load", mean_pressure, asked, allowed(asked));
        }
        Control::Approach => found.near("approach", number(load, "approach"), asked, 1e-9 * asked),
    }
    found.is(load, "p_star", number(load, "mean_pressure") / (modulus * gradient), 1e-9);
    if !number(load, "kappa").is_nan() {
        let p_star = number(load, "p_star");
        found.is(load, "kappa", number(load, "area_fraction") / p_star, 1e-9);
        found.is(load, "kappa_corrected", number(load, "area_fraction_corrected") / p_star, 1e-9);
    }
    if case.is_free {
        let area = plane.length[0] * if case.is_line { 1.0 } else { plane.length[1] };
        found.is(load, "force", number(load, "mean_pressure") * area, 1e-9);
    }
    // Counts and sums.
    let (surely, possibly, repulsion) = repulsion(case, &pressure, &gap, wall_pressure(file, k, ""));
    counted(found, case, load, (&surely, &possibly, &repulsion), &gap);
    // Displacement by dense sums.
    let loaded: Vec<f64> = displacement.iter().zip(&rough.lift).map(|(u, w)| u - w).collect();
    let approach = number(load, "approach");
    let mut energy = None;
    let scale = rough.deviation;
    if case.has_lower {
        squeezed(found, case, load, k, file, rough, [&pressure, &displacement, &gap]);
    } else if !case.is_steep {
        let all = (case.components == Components::All && !case.is_free).then(|| {
            let zero = vec![0.0; plane.len()];
            let pressed = pressure.iter().map(|p| -p).collect();
            all_components(case, &Vectors([zero.clone(), zero, pressed]))
        });
        // The base moves the surface sideways, too.
        if let (Some(Vectors([x, y, _])), None) = (&all, &case.moved) {
            let most = largest(x).max(largest(y)).max(1e-3 * scale);
            for (name, expected) in
                [("displacement_x", x), ("displacement_y", y)].iter().take(2 - usize::from(case.is_line))
            {
                let apart = field(name).iter().zip(expected.iter()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                found.near(&format!("{name} less that of the pressure"), apart, 0.0, elastic.tolerance * most);
            }
        }
        let dense = match all {
            Some(Vectors([_, _, z])) if case.moves_all() => z.into_iter().map(|u| -u).collect(),
            _ => elastic.dense.displace(&pressure),
        };
        let most = largest(&dense).max(1e-3 * scale);
        let apart = dense.iter().zip(&loaded).map(|(d, u)| (d + u).abs()).fold(0.0, f64::max);
        // The mean displacement of a slab matches the mean pressure of the law up to the tolerance.
        let unbalanced = if case.law.is_some() { 10.0 * case.tolerance } else { 0.0 };
        found.near("displacement_z less that of the pressure", apart, 0.0, elastic.tolerance.max(unbalanced) * most);
        energy = Some(0.5 * pressure.iter().zip(&dense).map(|(p, d)| p * d).sum::<f64>() / plane.len() as f64);
        // The approach closes the gap and the displacement opens it.
        let open: Vec<f64> = rough.clearance.iter().zip(&loaded).map(|(c, u)| c - u).collect();
        let depth = case.hardness.as_ref().map(|_| field("plastic_depth"));
        let depth = depth.unwrap_or_else(|| vec![0.0; plane.len()]);
        let shift: Vec<f64> = (0..plane.len()).map(|at| open[at] + depth[at] - gap[at]).collect();
        let apart = shift.iter().map(|shift| (shift - approach).abs()).fold(0.0, f64::max);
        found.near(
            "gap less clearance - u_z - approach",
            apart,
            0.0,
            1e-8 * (largest(&rough.clearance) + approach.abs() + largest(&loaded)),
        );
        if let Some(hardness) = &case.hardness {
            plastic(found, load, [&pressure, &gap, &depth], hardness, (case.tolerance, scale));
        }
    }
    if let Some(energy) = energy {
        // The displacement outside a patch follows from the pressure of a law, up to the residual.
        let of_patch = if case.is_free && case.law.is_some() { case.tolerance } else { 0.0 };
        // A uniform pressure on a half-space displaces nothing, up to rounding.
        let rounding = 1e-13 * stress * scale;
        found.near(
            "elastic_energy",
            number(load, "elastic_energy"),
            energy,
            1e2 * elastic.tolerance.max(of_patch) * energy.abs() + rounding,
        );
    }
    // Interaction.
    if let Some(law) = &case.law {
        let mut energy = lawful(found, case, law, [&pressure, &gap, &repulsion], scale);
        if case.has_lower {
            let [pressure, gap] = ["lower_pressure", "lower_gap"].map(field);
            let (.., repulsion) = self::repulsion(case, &pressure, &gap, wall_pressure(file, k, "lower_"));
            let below = lawful(found, case, law, [&pressure, &gap, &repulsion], scale);
            energy = energy.zip(below).map(|([a, most], [b, other])| [a + b, most.max(other)]);
        }
        if let Some([sum, most]) = energy {
            found.near("interface_energy", number(load, "interface_energy"), sum, 1e-7 * most);
        }
    } else if !case.has_lower && case.hardness.is_none() {
        let [closed, below] = wall(found, &pressure, &gap, scale, case.tolerance);
        // The certificate of the program is at least as strict.
        for (key, own) in [("residual.complementarity", closed), ("residual.penetration", below)] {
            let stored = number(load, key);
            found.must(own <= 1.01 * stored + 1e-12, || format!("{key} is {stored:e}, of the fields {own:e}"));
        }
    }
    stiffness(found, case, load, &pressure, &surely, elastic);
    measured(found, case, load, &surely, &possibly, &gap);
}

/// Returns the stiffness of the softest wave, the scale of the stress that a law leaves.
pub(crate) fn softest(case: &Case) -> f64 {
    let plane = case.plane;
    let q = |axis: usize| 2.0 * std::f64::consts::PI / plane.length[axis];
    let waves = if case.is_line { vec![q(0)] } else { vec![q(0), q(1)] };
    let least = waves.into_iter().map(|q| 1.0 / case.body.compliance(q, false)).fold(f64::INFINITY, f64::min);
    let level = case.body.compliance(0.0, false);
    if level > 0.0 && !case.is_free { least.min(1.0 / level) } else { least }
}

fn plastic(
    found: &mut Found,
    load: &Value,
    [pressure, gap, depth]: [&[f64]; 3],
    hardness: &[f64],
    (tolerance, deviation): (f64, f64),
) {
    let hardest = largest(hardness);
    let mut yielding = 0;
    for at in 0..pressure.len() {
        let (p, most) = (pressure[at], hardness[at]);
        found.must(p >= -tolerance * hardest && p <= most * (1.0 + tolerance) + 1e-12, || {
            format!("pressure {p:e} of {most:e} at {at}")
        });
        yielding += usize::from(p >= most * (1.0 - 1e-12));
        let at_bound = p >= most * (1.0 - 1e-9);
        let fine = if at_bound { depth[at] >= 0.0 } else { depth[at] == 0.0 };
        found.must(fine, || format!("plastic depth {:e} under {p:e} of {most:e} at {at}", depth[at]));
    }
    found.is(load, "plastic_fraction", yielding as f64 / pressure.len() as f64, 1e-9);
    found.is(load, "plastic_volume", mean(depth), 1e-9);
    let closed = pressure.iter().zip(gap).map(|(p, g)| p * g.abs()).sum::<f64>() / pressure.iter().sum::<f64>();
    found.near("mean gap under pressure", closed, 0.0, 1e2 * tolerance * deviation);
}

fn squeezed(found: &mut Found, case: &Case, load: &Value, k: usize, file: &Reader, rough: &Rough, upper: [&[f64]; 3]) {
    let plane = case.plane;
    let field = |name: &str| file.slab::<f64>(&format!("/fields/lower_{name}"), k).unwrap();
    let (pressure, displacement, gap) = (field("pressure"), field("displacement_z"), field("gap"));
    let heights = file.values::<f64>("/lower/height").unwrap();
    found.must(case.lower.as_ref() == Some(&heights), || "the lower surface is not that of its file".into());
    let top = heights.iter().fold(f64::NEG_INFINITY, |top, h| top.max(*h));
    // Only the two surfaces hold the slab.
    let slab = Stack { layers: case.body.first.layers.clone(), base: Base::Free };
    let held = case.components == Components::Held;
    let [above, below] = faces(&slab, plane, held, [upper[0], &pressure]);
    let most = largest(&above).max(largest(&below));
    let lower = &load["lower"];
    let parts = [
        ("upper", upper, above, 1.0, &rough.clearance, number(load, "approach") - number(lower, "approach")),
        (
            "lower",
            [&pressure[..], &displacement, &gap],
            below,
            -1.0,
            &heights.iter().map(|h| top - h).collect::<Vec<f64>>(),
            number(lower, "approach"),
        ),
    ];
    let scale = rough.deviation.hypot(deviation(&heights));
    let depths = ["plastic_depth", "lower_plastic_depth"].map(|name| {
        let depth = || file.slab::<f64>(&format!("/fields/{name}"), k).unwrap();
        case.hardness.as_ref().map_or_else(|| vec![0.0; plane.len()], |_| depth())
    });
    let mut energy = 0.0;
    for ((name, [p, u, g], into, sign, clearance, approach), depth) in parts.into_iter().zip(&depths) {
        let apart = into.iter().zip(u).map(|(d, u)| (d + sign * u).abs()).fold(0.0, f64::max);
        // The mean displacement of the slab matches the mean pressure of a law up to the tolerance.
        let unbalanced = if case.law.is_some() { 10.0 * case.tolerance } else { 0.0 };
        found.near(&format!("displacement of the {name} face"), apart, 0.0, unbalanced.max(1e-7) * most);
        let apart = (0..plane.len())
            .map(|at| (clearance[at] - sign * u[at] - approach + depth[at] - g[at]).abs())
            .fold(0.0, f64::max);
        found.near(&format!("gap of the {name} face"), apart, 0.0, 1e-8 * (largest(clearance) + most));
        match &case.hardness {
            _ if case.law.is_some() => {}
            Some(hardness) => {
                let numbers = if name == "upper" { load } else { lower };
                plastic(found, numbers, [p, g, depth], hardness, (case.tolerance, scale));
            }
            None => {
                wall(found, p, g, scale, case.tolerance);
            }
        }
        energy += 0.5 * p.iter().zip(&into).map(|(p, d)| p * d).sum::<f64>() / plane.len() as f64;
    }
    found.near(
        "mean pressure of the lower face",
        mean(&pressure),
        mean(upper[0]),
        1e2 * case.tolerance * largest(&pressure),
    );
    let unbalanced = if case.law.is_some() { 1e2 * case.tolerance } else { 0.0 };
    found.is(load, "elastic_energy", energy, unbalanced.max(1e-6));
    let (surely, possibly, repulsion) = repulsion(case, &pressure, &gap, wall_pressure(file, k, "lower_"));
    counted(found, case, lower, (&surely, &possibly, &repulsion), &gap);
}

fn stiffness(found: &mut Found, case: &Case, load: &Value, pressure: &[f64], surely: &[bool], elastic: &Elastic) {
    tangent(found, case, load, pressure, elastic);
    if !case.statistics {
        return;
    }
    conductance(found, case, load, surely);
}

/// Returns the normal compliance of a periodic cell in all components, whose shortest waves differ.
fn normal_of_all(case: &Case) -> Dense {
    let zero = vec![0.0; case.plane.len()];
    let mut pressed = zero.clone();
    pressed[0] = -1.0;
    let Vectors([_, _, displacement]) = all_components(case, &Vectors([zero.clone(), zero, pressed]));
    Dense::of_displacement(case.plane, displacement.into_iter().map(|u| -u).collect())
}

/// Compares the stiffness of a state with the stiffness from a dense compliance.
pub(crate) fn tangent(found: &mut Found, case: &Case, load: &Value, pressure: &[f64], elastic: &Elastic) {
    let is_sheared = case.friction.is_some() || case.shear_strength.is_some();
    let has_stiffness = case.law.is_none() && !case.is_steep && !case.has_lower && !is_sheared;
    let free = |at: &usize| {
        pressure[*at] > 0.0 && case.hardness.as_ref().is_none_or(|h| pressure[*at] < h[*at] * (1.0 - 1e-12))
    };
    let points: Vec<usize> = (0..pressure.len()).filter(free).collect();
    let expected = has_stiffness.then(|| match case.moves_all() {
        true => normal_of_all(case).stiffness(&points),
        false => elastic.dense.stiffness(&points),
    });
    match expected {
        Some(expected) if expected.is_finite() && points.is_empty() => {
            found.near("stiffness", number(load, "stiffness"), 0.0, 0.0);
        }
        Some(expected) if expected.is_finite() => {
            let tolerance = 1e-6_f64.max(elastic.tolerance) + number(load, "stiffness_error");
            found.is(load, "stiffness", expected, tolerance);
        }
        // These stiffnesses are compared with differences of states in the tests of paths and of the crate of laws.
        _ if case.law.is_some() || case.has_lower || is_sheared || case.is_steep => {}
        _ => found.null(load, "stiffness"),
    }
}

pub(crate) fn conductance(found: &mut Found, case: &Case, load: &Value, surely: &[bool]) {
    // Current through all points in contact at uniform potential, into half-spaces of total unit resistivity, or into
    // layers of this resistivity on electrodes. A periodic surface leaves out the bulk.
    let potential = |q: f64| match case.conductor_height {
        Some(height) if q > 0.0 => (q * height).tanh() / q,
        Some(height) => height,
        None => 1.0 / q,
    };
    let conductors = match (case.is_free, case.conductor_height) {
        (false, _) => Dense::periodic(case.plane, |q| if q > 0.0 { potential(q) } else { 0.0 }),
        (true, None) => Dense::free(case.plane, love(case.plane, 2.0)),
        (true, Some(height)) => Dense::free(case.plane, layered(case.plane, 2.0, [height; 2], 0.0, potential)),
    };
    let touching: Vec<usize> = (0..surely.len()).filter(|at| surely[*at]).collect();
    let has_level = !(case.is_free && case.is_line && case.conductor_height.is_none());
    let expected = if has_level && !case.is_steep { conductors.stiffness(&touching) } else { f64::INFINITY };
    match expected.is_finite() {
        // Accuracy stated by the default, as for a stiffness: five digits.
        true => found.is(load, "conductance", expected, gfmd_contact::Stiffness::TOLERANCE),
        false => found.null(load, "conductance"),
    }
}

/// Checks patches and flow of a load.
pub(crate) fn measured(found: &mut Found, case: &Case, load: &Value, surely: &[bool], possibly: &[bool], gap: &[f64]) {
    let plane = case.plane;
    if case.statistics && surely == possibly {
        let all = patches(plane, surely, case.is_free);
        let most = all.iter().map(|patch| patch.points.len()).max().unwrap_or(0);
        found.near("patches.count", number(load, "patches.count"), all.len() as f64, 0.0);
        found.near(
            "patches.largest_fraction",
            number(load, "patches.largest_fraction"),
            most as f64 / plane.len() as f64,
            1e-12,
        );
        for axis in [0, 1] {
            let through = all.iter().any(|patch| patch.percolates[axis]);
            let reported = &load["patches"]["percolates"][axis];
            found.must(*reported == through, || {
                format!("patches.percolates[{axis}] is {reported}; filling says {through}")
            });
        }
    }
    if case.flow && surely == possibly {
        let height = if mean(gap) > 0.0 { mean(gap) } else { f64::NAN };
        let open: Vec<f64> = gap
            .iter()
            .zip(surely)
            .map(|(g, closed)| if *closed { 0.0 } else { (g / height).max(0.0).powi(3) })
            .collect();
        if height.is_nan() || surely.iter().all(|closed| *closed) {
            return found.null(load, "flow_xx");
        }
        let expected = flow(plane, &open, case.is_free);
        for (i, row) in expected.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                let reported = load["flow"]["conductivity"][i][j].as_f64().unwrap_or(f64::NAN);
                let scale = expected[0][0].abs().max(expected[1][1].abs()).max(1e-12);
                found.near(&format!("flow.conductivity[{i}][{j}]"), reported, *value, 1e-6 * scale);
            }
        }
        for axis in [0, 1] {
            let of = |kind: &str| load["flow"][format!("conductivity{kind}")][axis][axis].as_f64().unwrap_or(f64::NAN);
            if of("_limit").is_finite() {
                let error = (of("") - of("_limit")).abs() + of("_limit_error");
                found.near("flow.conductivity_grid_error", of("_grid_error"), error, 1e-12 + 1e-9 * error);
            }
        }
        let channels = patches(plane, &open.iter().map(|k| *k > 0.0).collect::<Vec<bool>>(), case.is_free);
        for axis in [0, 1] {
            let through = channels.iter().any(|patch| patch.percolates[axis]);
            let reported = &load["flow"]["percolates"][axis];
            found.must(*reported == through, || {
                format!("flow.percolates[{axis}] is {reported}; filling says {through}")
            });
        }
        found.must(number(load, "flow.residual") <= 1e-8, || {
            format!("the residual of the flow is {}", number(load, "flow.residual"))
        });
    }
}

/// Checks the loads at which the gap closes: a thousandth apart, between the lowest and the highest load, in order.
pub(crate) fn threshold(found: &mut Found, case: &Case, report: &Value, file: &Reader) {
    let keys = ["mean_pressure", "p_star", "approach", "area_fraction", "area_fraction_corrected", "mean_gap"];
    let loads = report["loads"].as_array().unwrap();
    let asked = match case.control {
        Control::Approach => "approach",
        _ => "mean_pressure",
    };
    let all: Vec<f64> = loads.iter().map(|load| number(load, asked)).collect();
    let (least, most) = (all.iter().fold(f64::INFINITY, |a, b| a.min(*b)), all.iter().fold(0.0_f64, |a, b| a.max(*b)));
    for axis in [0, 1] {
        let reported = &report["flow_threshold"][axis];
        let stored = |key: &str| file.values::<f64>(&format!("/flow_threshold/{key}")).unwrap_or_default();
        if reported.is_null() {
            // The gap is open or closed at all loads.
            let open = |load: f64| {
                let k = all.iter().position(|other| *other == load).unwrap();
                let field = |name: &str| file.slab::<f64>(&format!("/fields/{name}"), k).unwrap();
                let (pressure, gap) = (field("pressure"), field("gap"));
                let open: Vec<bool> = pressure.iter().zip(&gap).map(|(p, g)| *p <= 0.0 && *g > 0.0).collect();
                patches(case.plane, &open, case.is_free).iter().any(|patch| patch.percolates[axis])
            };
            found.must(open(least) == open(most), || format!("flow_threshold[{axis}] is null, and the gap closes"));
            continue;
        }
        let pair = |key: &str| [0, 1].map(|side| reported[key][side].as_f64().unwrap_or(f64::NAN));
        let [open, closed] = pair(asked);
        found.must(least * (1.0 - 1e-9) <= open && open < closed && closed <= most * (1.0 + 1e-9), || {
            format!("flow_threshold[{axis}] from {open} to {closed}, loads {least} to {most}")
        });
        found.must(closed / open <= 1.0011, || {
            format!("flow_threshold[{axis}]: {open} and {closed} are not a thousandth apart")
        });
        let [open, closed] = pair("area_fraction");
        found.must(open <= closed + 1e-12, || format!("flow_threshold[{axis}]: area {open} and {closed}"));
        for key in keys {
            let values = stored(key);
            found.must(values.get(2 * axis..2 * axis + 2) == Some(&pair(key)), || {
                format!("/flow_threshold/{key} is {values:?}, in JSON {:?}", pair(key))
            });
        }
    }
}

/// Checks the arrays that the statistics add to the file.
pub(crate) fn arrays(found: &mut Found, case: &Case, loads: &[Value], file: &Reader) {
    let plane = case.plane;
    let [dx, dy] = plane.spacing();
    let values = |name: &str| file.values::<f64>(name).unwrap_or_default();
    let number = if case.is_path { "waypoint" } else { "load" };
    let names = [number, "area", "perimeter", "force", "x", "y"].map(|name| values(&format!("/patches/{name}")));
    let mut first = 0;
    for k in 0..loads.len() {
        let field = |name: &str| file.slab::<f64>(&format!("/fields/{name}"), k).unwrap();
        let (pressure, gap) = (field("pressure"), field("gap"));
        let (surely, possibly, repulsion) = repulsion(case, &pressure, &gap, wall_pressure(file, k, ""));
        let all = patches(plane, &surely, case.is_free);
        let count = names[0].iter().filter(|load| **load == k as f64).count();
        if surely == possibly {
            found.must(count == all.len(), || {
                format!("load {k}: {count} patches in the file, {} by filling", all.len())
            });
            let cell = dx * dy;
            for (patch, row) in all.iter().zip(first..first + count) {
                let size = patch.points.len() as f64 * cell;
                found.near("/patches/area", names[1][row], size, 1e-9 * size);
                let perimeter: f64 = (patch.points.iter())
                    .flat_map(|at| neighbours(plane, *at, case.is_free))
                    .filter(|(there, ..)| !surely[*there])
                    .map(|(_, _, axis)| if axis == 0 { dy } else { dx })
                    .sum();
                found.near("/patches/perimeter", names[2][row], perimeter, 1e-9 * (perimeter + size));
                let force: f64 = patch.points.iter().map(|at| repulsion[*at]).sum::<f64>() * cell;
                found.near("/patches/force", names[3][row], force, 1e-7 * force);
                for (axis, spacing) in [dx, dy].into_iter().enumerate() {
                    let reported = names[4 + axis][row];
                    let winds = patch.percolates[axis] && !case.is_free;
                    found.must(reported.is_nan() == winds, || format!("/patches/{} is {reported}", ["x", "y"][axis]));
                    if case.is_free {
                        let index = |at: &usize| [at / plane.n[1], at % plane.n[1]][axis] as f64 * spacing;
                        let centre = patch.points.iter().map(index).sum::<f64>() / patch.points.len() as f64;
                        found.near("centre of a patch", reported, centre, 1e-9);
                    }
                }
            }
        }
        first += count;
        // Densities times the bin width add up to the fractions of the surface.
        let positive = |values: &[f64]| values.iter().filter(|value| **value > 0.0).count() as f64 / plane.len() as f64;
        let apart: Vec<f64> = gap.iter().zip(&repulsion).filter(|(_, p)| **p <= 0.0).map(|(g, _)| *g).collect();
        let opened = apart.iter().filter(|g| **g > 0.0).count() as f64 / plane.len() as f64;
        for (name, share, values) in [("pressure", positive(&repulsion), &repulsion), ("gap", opened, &apart)] {
            let density = file.slab::<f64>(&format!("/distributions/{name}"), k).unwrap_or_default();
            let middle = file.slab::<f64>(&format!("/distributions/{name}_at"), k).unwrap_or_default();
            if surely != possibly || density.is_empty() {
                continue;
            }
            let width = 2.0 * middle[0];
            found.near(&format!("share of /distributions/{name}"), density.iter().sum::<f64>() * width, share, 1e-9);
            let first: f64 = density.iter().zip(&middle).map(|(d, at)| d * at * width).sum();
            let exact = values.iter().filter(|value| **value > 0.0).sum::<f64>() / plane.len() as f64;
            found.near(&format!("mean of /distributions/{name}"), first, exact, 0.5001 * width * share);
        }
        if case.is_free {
            continue;
        }
        spectrum(found, plane, &repulsion, k, file);
        let middle = mean(&repulsion);
        for (axis, name) in ["x", "y"].into_iter().enumerate() {
            let reported = file.slab::<f64>(&format!("/spectra/autocorrelation_{name}"), k).unwrap_or_default();
            let lagged = |lag: usize| -> f64 {
                (0..plane.len())
                    .map(|at| {
                        let mut there = [at / plane.n[1], at % plane.n[1]];
                        there[axis] = (there[axis] + lag) % plane.n[axis];
                        (repulsion[at] - middle) * (repulsion[there[0] * plane.n[1] + there[1]] - middle)
                    })
                    .sum()
            };
            let variance = lagged(0);
            for (lag, value) in reported.iter().enumerate() {
                // A uniform pressure has no correlation.
                if variance <= 1e-26 * plane.len() as f64 * largest(&repulsion).powi(2) {
                    continue;
                }
                found.near(&format!("autocorrelation along {name}"), *value, lagged(lag) / variance, 1e-7);
            }
        }
    }
}

/// Checks the mean of |p(q)|² over rings as wide as the smallest wave number of the shorter side, times the density of
/// wave numbers, up to the smaller of the shortest waves along x and along y, without empty rings.
fn spectrum(found: &mut Found, plane: Plane, pressure: &[f64], k: usize, file: &Reader) {
    let axes = if plane.n[1] == 1 { 1 } else { 2 };
    let tau = 2.0 * std::f64::consts::PI;
    let of_axes = |value: &dyn Fn(usize) -> f64| (0..axes).map(value).fold(f64::INFINITY, f64::min);
    let smallest = tau / of_axes(&|axis| plane.length[axis]);
    let shortest = of_axes(&|axis| tau * plane.n[axis] as f64 / (2.0 * plane.length[axis]));
    let density: f64 = (0..axes).map(|axis| plane.length[axis] / tau).product();
    let parts = plane.transform(pressure);
    let (mut wavenumbers, mut powers) = (Vec::new(), Vec::new());
    for ring in 0..=(shortest / smallest * (1.0 + 1e-12)).floor() as usize {
        let inside = (0..plane.len()).filter_map(|place| {
            let [x, y] = plane.wave(place);
            let q = x.hypot(y);
            // Half-way between two rings, a wave belongs to the ring of shorter waves.
            let here = q > 0.0 && (q / smallest + 1e-9).round() as usize == ring;
            here.then(|| (q, parts[place][0].powi(2) + parts[place][1].powi(2)))
        });
        let inside: Vec<(f64, f64)> = inside.collect();
        if !inside.is_empty() {
            let count = inside.len() as f64;
            wavenumbers.push(inside.iter().map(|(q, _)| q).sum::<f64>() / count);
            powers.push(density * inside.iter().map(|(_, power)| power).sum::<f64>() / count);
        }
    }
    let reported = file.slab::<f64>("/spectra/pressure", k).unwrap_or_default();
    let at = file.values::<f64>("/spectra/wavenumber").unwrap_or_default();
    found.must(reported.len() == powers.len() && at.len() == powers.len(), || {
        format!("/spectra/pressure has {} rings, {} wave numbers; there are {}", reported.len(), at.len(), powers.len())
    });
    let most = largest(&powers);
    for ring in 0..powers.len().min(reported.len()).min(at.len()) {
        found.near("/spectra/wavenumber", at[ring], wavenumbers[ring], 1e-9 * wavenumbers[ring]);
        let rounding = 1e-26 * density * largest(pressure).powi(2);
        found.near("/spectra/pressure", reported[ring], powers[ring], 1e-9 * most + rounding);
    }
}
