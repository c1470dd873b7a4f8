//! Numbers of each step of a path, compared with their definitions.

use std::cell::LazyCell;
use std::path::Path;

use gfmd_files::Reader;
use serde_json::Value;

use super::contact::{
    Elastic, Rough, arrays, conductance, counted, elastic, measured, repulsion, softest, tangent, wall,
};
use super::draw::{Body, Case, Control};
use super::elastic::{Complex, Plane, without_sines};
use super::found::{Found, number};
use super::numbers::{gradient, largest, mean};
use crate::common::gfmd;

/// Three components of each point.
pub(crate) struct Vectors(pub(crate) [Vec<f64>; 3]);

/// Returns the displacement by tractions on a periodic surface.
pub(crate) fn all_components(case: &Case, traction: &Vectors) -> Vectors {
    displaced(case.plane, &compliances(&case.body, case.plane), traction)
}

/// Returns the compliance of all components of each mode: displacement (row) per traction (column).
pub(crate) fn compliances(body: &Body, plane: Plane) -> Vec<[[Complex; 3]; 3]> {
    let of_mode = |place: usize| {
        let mut matrix = body.first.all_components(plane, place);
        if let Some(second) = &body.second {
            // The second body is turned over, so the coupling of pressure and shear has the opposite sign.
            let other = second.all_components(plane, place);
            for row in 0..3 {
                for column in 0..3 {
                    let sign = if (row == 2) == (column == 2) { 1.0 } else { -1.0 };
                    [0, 1].iter().for_each(|part| matrix[row][column][*part] += sign * other[row][column][*part]);
                }
            }
        }
        if plane.wave(place) == [0.0; 2] { matrix } else { without_sines(matrix, plane.is_shortest(place)) }
    };
    (0..plane.len()).map(of_mode).collect()
}

/// Returns the displacement by tractions, from the compliance of each mode.
pub(crate) fn displaced(plane: Plane, compliances: &[[[Complex; 3]; 3]], traction: &Vectors) -> Vectors {
    let parts: Vec<Vec<Complex>> = traction.0.iter().map(|field| plane.transform(field)).collect();
    let mut modes = [(); 3].map(|()| vec![[0.0; 2]; plane.len()]);
    for (place, matrix) in compliances.iter().enumerate() {
        for row in 0..3 {
            for column in 0..3 {
                let ([a, b], [c, d]) = (matrix[row][column], parts[column][place]);
                modes[row][place][0] += a * c - b * d;
                modes[row][place][1] += a * d + b * c;
            }
        }
    }
    Vectors(modes.map(|modes| plane.inverse(&modes)))
}

/// Returns the work of the mean tractions between two states by the trapezoidal rule, and half of the product of both
/// changes, the uncertainty if the tractions take any value between both states.
fn work(last: &Value, step: &Value) -> [f64; 2] {
    let [p, q] = [last, step].map(|step| number(step, "mean_pressure"));
    let approach = number(step, "approach") - number(last, "approach");
    let (mut work, mut open) = (0.5 * (p + q) * approach, 0.5 * ((q - p) * approach).abs());
    for axis in [0, 1] {
        let [s, t] = [last, step].map(|step| step["mean_shear"][axis].as_f64().unwrap_or(0.0));
        let [from, to] = [last, step].map(|step| step["lateral"][axis].as_f64().unwrap_or(0.0));
        work += 0.5 * (s + t) * (to - from);
        open += 0.5 * ((t - s) * (to - from)).abs();
    }
    [work, open]
}

/// Number of steps between two waypoints on the refined path used to find the work.
const FINE: usize = 64;

/// Returns the [`work`] from each waypoint to the next along the path of [`FINE`] steps; empty without such path.
fn fine_work(case: &Case, folder: &Path) -> Vec<[f64; 2]> {
    let mut words: Vec<&str> = case.words.iter().map(String::as_str).collect();
    let steps = words.iter().position(|word| *word == "--steps").unwrap() + 1;
    let fine = FINE.to_string();
    words[steps] = &fine;
    words.extend(["--energy-solves", "0", "--json", "-q", "--threads", "1"]);
    let output = gfmd(folder, &words);
    let Ok(report) = serde_json::from_slice::<Value>(&output.stdout) else { return Vec::new() };
    let steps = report["steps"].as_array().unwrap();
    let works: Vec<[f64; 2]> = steps.windows(2).map(|pair| work(&pair[0], &pair[1])).collect();
    works.chunks_exact(FINE).map(|chunk| chunk.iter().fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d])).collect()
}

pub(crate) fn check(found: &mut Found, case: &Case, folder: &Path, report: &Value, file: &Reader) {
    let plane = case.plane;
    let heights = file.values::<f64>("/surface/height").unwrap();
    super::contact::given(found, case, &heights);
    let rough = Rough::new(case, heights);
    if let Some(asked) = case.asked_gradient {
        found.near("rms gradient of the generator", gradient(plane, &rough.heights, false), asked, 1e-9 * asked);
    }
    let modulus = case.body.contact_modulus();
    found.near("e_star", number(report, "e_star"), modulus, 1e-12 * modulus);
    found.near("rms_gradient", number(report, "rms_gradient"), rough.gradient, 1e-10);
    found.near("rms_height", number(report, "rms_height"), rough.deviation, 1e-10 * rough.deviation);
    let steps = report["steps"].as_array().unwrap();
    let parted = report["parted_at"].as_u64();
    if parted.is_none() {
        found.must(steps.len() == case.loads.len(), || format!("{} steps of {}", steps.len(), case.loads.len()));
    }
    let elastic = elastic(case);
    let mut before: Option<State> = None;
    let fine = LazyCell::new(|| fine_work(case, folder));
    for (k, step) in steps.iter().enumerate() {
        if parted == Some(k as u64) {
            break;
        }
        let first = found.complaints.len();
        let state = one(found, case, step, k, file, &rough, &elastic);
        let divided = || k.checked_sub(1).and_then(|k| fine.get(k).copied());
        energy(found, case, step, &state, before.as_ref().zip(steps.get(k.wrapping_sub(1))), &divided);
        found.complaints[first..].iter_mut().for_each(|text| *text = format!("step {k}: {text}"));
        before = Some(state);
    }
    totals(found, report, steps);
    let reached = parted.map_or(steps.len(), |parted| steps.len().min(parted as usize));
    if case.statistics && (case.law.is_none() || case.lateral.is_empty()) {
        arrays(found, case, &steps[..reached], file);
    }
}

/// Part of a state needed by the next step.
struct State {
    pressure: Vec<f64>,
    depth: Option<Vec<f64>>,
    traction: Option<Vectors>,
    displacement: Option<Vectors>,
    lateral: [f64; 2],
}

fn one(
    found: &mut Found,
    case: &Case,
    step: &Value,
    k: usize,
    file: &Reader,
    rough: &Rough,
    elastic: &Elastic,
) -> State {
    let plane = case.plane;
    let field = |name: &str| file.slab::<f64>(&format!("/fields/{name}"), k).unwrap();
    let (pressure, gap) = (field("pressure"), field("gap"));
    let displacement: Vec<f64> = field("displacement_z").iter().zip(&rough.lift).map(|(u, lift)| u - lift).collect();
    found.must(step["converged"] == true, || "not converged, with status 0".into());
    found.nulls(step, &["stick_fraction", "interface_energy", "dissipated", "dissipated_error", "lowest_curvature"]);
    let modulus = case.body.contact_modulus();
    let stress = largest(&pressure);
    // The pressure follows from the displacement, the mean pressure from the wall or law; they may differ by the
    // tolerance.
    let unbalanced = 10.0 * case.tolerance;
    found.near("mean_pressure", number(step, "mean_pressure"), mean(&pressure), unbalanced * stress);
    let asked = case.loads[k];
    let reported = number(step, "mean_pressure");
    // Stress scale of a law.
    let least = if case.law.is_some() { stress.max(softest(case) * rough.deviation) } else { stress };
    match case.control {
        Control::Pressure => found.near("load", reported, asked, 1.01 * case.tolerance * asked.max(least)),
        Control::PStar => {
            let asked = asked * modulus * rough.gradient;
            found.near("load", reported, asked, 1.01 * case.tolerance * asked.max(least));
        }
        Control::Approach => found.near("approach", number(step, "approach"), asked, 1e-9 * asked),
    }
    found.is(step, "p_star", reported / (modulus * rough.gradient), 1e-9);
    let angle = case.direction.to_radians();
    let sideways = case.lateral.get(k).copied().unwrap_or(0.0);
    let lateral = [sideways * angle.cos(), sideways * angle.sin()];
    for axis in [0, 1] {
        let reported = step["lateral"][axis].as_f64().unwrap_or(f64::NAN);
        found.near("lateral", reported, lateral[axis], 1e-9 * sideways.abs() + 1e-300);
    }
    let attracting = file.contains("/fields/repulsion").then(|| field("repulsion"));
    let (surely, possibly, repulsion) = repulsion(case, &pressure, &gap, attracting);
    // Points repelled by the wall or a mixed law count, independent of sliding.
    if case.law.is_none() || case.lateral.is_empty() {
        counted(found, case, step, (&surely, &possibly, &repulsion), &gap);
        if case.statistics {
            measured(found, case, step, &surely, &possibly, &gap);
            if surely == possibly {
                conductance(found, case, step, &surely);
            }
        }
    }
    let has = |name: &str| file.contains(&format!("/fields/{name}"));
    let shear: Option<[Vec<f64>; 2]> = has("shear_x")
        .then(|| [field("shear_x"), if has("shear_y") { field("shear_y") } else { vec![0.0; plane.len()] }]);
    let depth = has("plastic_depth").then(|| field("plastic_depth"));
    let mut all = None;
    let mut traction = None;
    let uz: Option<Vec<f64>> = match &shear {
        None => Some(elastic.dense.displace(&pressure).into_iter().map(|d| -d).collect()),
        Some([x, y]) => {
            for (axis, field) in [x, y].into_iter().enumerate() {
                let reported = step["mean_shear"][axis].as_f64().unwrap_or(f64::NAN);
                found.near("mean_shear", reported, mean(field), 1e-9 * largest(field));
            }
            let vectors = Vectors([x.clone(), y.clone(), pressure.iter().map(|p| -p).collect()]);
            // Layers or patches with shear are not covered here.
            all = (!case.is_free).then(|| all_components(case, &vectors));
            traction = Some(vectors);
            all.as_ref().map(|all| all.0[2].clone())
        }
    };
    if let Some(uz) = &uz {
        let apart = uz.iter().zip(&displacement).map(|(a, b)| (b - a).abs()).fold(0.0, f64::max);
        let scale = largest(uz).max(1e-3 * rough.deviation);
        // The pressure of a wall balances the displacement up to the tolerance.
        let allowed = elastic.tolerance.max(100.0 * case.tolerance);
        found.near("displacement_z less that of the tractions", apart, 0.0, allowed * scale);
    }
    tangent(found, case, step, &pressure, elastic);
    let stored = depth.clone().unwrap_or_else(|| vec![0.0; plane.len()]);
    let approach = number(step, "approach");
    let shift: Vec<f64> =
        (0..plane.len()).map(|at| rough.clearance[at] + stored[at] - displacement[at] - gap[at]).collect();
    let known = if approach.is_nan() { mean(&shift) } else { approach };
    let apart = shift.iter().map(|shift| (shift - known).abs()).fold(0.0, f64::max);
    let size = largest(&rough.clearance) + known.abs() + largest(&displacement) + largest(&stored);
    found.near("gap less clearance - u_z - approach", apart, 0.0, 1e-8 * size);
    match (&case.law, &case.hardness) {
        (Some(law), _) if case.lateral.is_empty() => {
            let most = largest(&pressure).max(largest(&repulsion));
            for at in 0..plane.len() {
                if law.jump().is_some_and(|jump| (gap[at] - jump).abs() < 1e-6 * jump) {
                    continue;
                }
                let unbalanced = pressure[at] + law.tension(gap[at]);
                let wall = law.has_wall() && gap[at] <= 1e-9 * largest(&gap);
                let error = if wall { (-unbalanced).max(0.0) } else { unbalanced.abs() };
                found.must(error <= 1e-4 * most, || format!("the law at point {at} leaves {error:e} of {most:e}"));
            }
            let energies: Option<Vec<f64>> =
                gap.iter().map(|g| law.energy(if law.has_wall() { g.max(0.0) } else { *g })).collect();
            if let Some(energies) = energies {
                found.near(
                    "interface_energy",
                    number(step, "interface_energy"),
                    mean(&energies),
                    1e-7 * largest(&energies),
                );
            }
        }
        (Some(_), _) => {}
        (None, Some(hardness)) => {
            let (mut surely, mut possibly) = (0.0, 0.0);
            for at in 0..plane.len() {
                let (p, most) = (pressure[at], hardness[at]);
                found.must(p >= -case.tolerance * most && p <= most * (1.0 + case.tolerance), || {
                    format!("{p:e} of {most:e} at {at}")
                });
                found.must(stored[at] >= 0.0, || format!("plastic depth {:e} at {at}", stored[at]));
                surely += f64::from(u8::from(p >= most));
                possibly += f64::from(u8::from(p >= most * (1.0 - 1e-3)));
            }
            // Points count if they carry the hardness up to the accuracy of the pressure.
            let reported = number(step, "plastic_fraction") * plane.len() as f64;
            found.must(surely - 1e-6 <= reported && reported <= possibly + 1e-6, || {
                format!("plastic_fraction is {reported} points; {surely} to {possibly} carry the hardness")
            });
            found.is(step, "plastic_volume", mean(&stored), 1e-9);
            // Flattened surfaces may be apart.
            let pressed = pressure.iter().sum::<f64>().max(f64::MIN_POSITIVE);
            let closed = pressure.iter().zip(&gap).map(|(p, g)| p * g.abs()).sum::<f64>() / pressed;
            found.near("mean gap under pressure", closed, 0.0, 1e2 * case.tolerance * rough.deviation);
        }
        (None, None) => {
            wall(found, &pressure, &gap, rough.deviation, case.tolerance);
        }
    }
    if let Some(Vectors([x, y, _])) =
        traction.as_ref().filter(|_| case.friction.is_some() || case.shear_strength.is_some())
    {
        let (mut least, mut most) = (0.0, 0.0);
        let limit = |at: usize| match (case.friction, case.shear_strength) {
            (Some(mu), _) => mu * pressure[at].max(0.0),
            (_, Some(strength)) if pressure[at] > 0.0 => strength,
            _ => 0.0,
        };
        let strongest = (0..plane.len()).map(limit).fold(0.0, f64::max);
        for at in 0..plane.len() {
            let size = x[at].hypot(y[at]);
            found.must(size <= limit(at) + 2.0 * case.tolerance * strongest, || {
                format!("shear {size:e} of {:e} at {at}", limit(at))
            });
            if pressure[at] > 0.0 {
                least += f64::from(u8::from(size < limit(at) * (1.0 - 1e-4)));
                most += f64::from(u8::from(size < limit(at) * (1.0 - 1e-12)));
            }
        }
        let reported = number(step, "stick_fraction") * plane.len() as f64;
        found.must(least - 1e-6 <= reported && reported <= most + 1e-6, || {
            format!("stick_fraction is {reported} points; {least} to {most} are below their limit")
        });
    }
    State { pressure, depth, traction, displacement: all, lateral }
}

/// Checks the energy kept and lost.
fn energy(
    found: &mut Found,
    case: &Case,
    step: &Value,
    state: &State,
    before: Option<(&State, &Value)>,
    divided: &dyn Fn() -> Option<[f64; 2]>,
) {
    let points = state.pressure.len() as f64;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / points;
    if let (Some(traction), Some(displacement)) = (&state.traction, &state.displacement) {
        let stored: f64 = (0..3).map(|c| 0.5 * product(&traction.0[c], &displacement.0[c])).sum();
        found.is(step, "elastic_energy", stored, 1e-6_f64.max(10.0 * case.tolerance));
    }
    let lost = number(step, "dissipated");
    // Without an error, the loss closes the balance up to its imbalance.
    let errors = ["dissipated_error", "work_imbalance"].map(|key| number(step, key));
    let error = errors.into_iter().find(|error| error.is_finite()).unwrap_or(0.0);
    if lost.is_finite() {
        let scale = Some(number(step, "elastic_energy").abs()).filter(|energy| energy.is_finite()).unwrap_or(0.0);
        found.must(lost >= -error - 1e-6_f64.max(10.0 * case.tolerance) * scale, || {
            format!("dissipated is {lost:e}, {error:e}")
        });
    }
    let Some((before, last)) = before else { return };
    let [mut done, mut open] = work(last, step);
    // With friction the shear may have been anywhere within its limits.
    let [p, q] = [last, step].map(|step| number(step, "mean_pressure"));
    if let Some(strongest) = case.friction.map(|mu| mu * p.max(q)).or(case.shear_strength) {
        open = 0.5 * ((q - p) * (number(step, "approach") - number(last, "approach"))).abs();
        for axis in [0, 1] {
            let [s, t] = [last, step].map(|step| step["mean_shear"][axis].as_f64().unwrap_or(0.0));
            open += (strongest + 0.5 * (s + t).abs()) * (state.lateral[axis] - before.lateral[axis]).abs();
        }
    }
    let energy = |step: &Value| {
        let interface = number(step, "interface_energy");
        number(step, "elastic_energy") + if interface.is_nan() { 0.0 } else { interface }
    };
    let stored = energy(step) - energy(last);
    if lost.is_finite() && done.is_finite() && stored.is_finite() {
        let rounding = 1e-5 * (energy(step).abs() + energy(last).abs() + done.abs());
        let is_met = |done: f64, open: f64| (done - stored - lost).abs() <= 1.001 * open + error + rounding;
        // An attractive law may pull more strongly in between than at both ends.
        if case.law.is_some() && !is_met(done, open) {
            [done, open] = divided().unwrap_or([done, open]);
        }
        found.must(is_met(done, open), || {
            format!(
                "work {done:e}, to {open:.1e}, is not the energy {stored:e} stored and {lost:e} lost, to {error:.1e}"
            )
        });
    }
    if let (Some(depth), Some(shallow), Some(hardness)) = (&state.depth, &before.depth, &case.hardness) {
        let grown: Vec<f64> = depth.iter().zip(shallow).map(|(now, then)| now - then).collect();
        found.must(grown.iter().all(|grown| *grown >= -1e-12), || "a plastic depth has shrunk".into());
        let expected = product(&grown, hardness);
        // Small depth changes have the rounding error of the depths.
        let kept = 1e-9 * number(step, "elastic_energy").abs();
        let rounding = 1e-12 * product(depth, hardness);
        found.near("dissipated", lost, expected, 1e-6 * expected + kept + rounding);
    }
    let frictional = case.friction.is_some() || case.shear_strength.is_some();
    if let (true, Some(here), Some(there)) = (frictional, &state.displacement, &before.displacement) {
        // Slip of the elastic surface over the rigid one, against the mean of the limits at both ends, if the step is
        // not divided.
        if number(step, "increments") > 1.0 {
            return;
        }
        let slip = |axis: usize| -> Vec<f64> {
            let moved = state.lateral[axis] - before.lateral[axis];
            here.0[axis].iter().zip(&there.0[axis]).map(|(now, then)| now - then - moved).collect()
        };
        let (x, y) = (slip(0), slip(1));
        let limit = |pressure: f64| match (case.friction, case.shear_strength) {
            (Some(mu), _) => mu * pressure.max(0.0),
            (_, Some(strength)) if pressure > 0.0 => strength,
            _ => 0.0,
        };
        let lost_at = |at: usize| {
            // Points that leave or enter the contact slip freely.
            let [then, now] = [before.pressure[at], state.pressure[at]].map(limit);
            if now > 0.0 { 0.5 * (then + now) * x[at].hypot(y[at]) } else { 0.0 }
        };
        let expected = (0..x.len()).map(lost_at).sum::<f64>() / points;
        let scale = number(step, "elastic_energy").abs();
        found.near("dissipated", lost, expected, 1e-4 * scale);
    }
}

/// Checks the sums over all steps.
fn totals(found: &mut Found, report: &Value, steps: &[Value]) {
    for key in ["dissipated", "dissipated_error", "extra_solves"] {
        let parts: Vec<f64> = steps.iter().map(|step| number(step, key)).filter(|value| value.is_finite()).collect();
        let reported = number(report, key);
        // The error of a sum is known if all errors are.
        let lost = steps.iter().filter(|step| number(step, "dissipated").is_finite()).count();
        if parts.is_empty() || (key == "dissipated_error" && parts.len() < lost) {
            found.must(reported.is_nan(), || format!("{key} is {reported} without parts"));
        } else {
            let sum: f64 = parts.iter().sum();
            found.near(key, reported, sum, 1e-12 * sum.abs());
        }
    }
    let least = steps.iter().map(|step| number(step, "mean_pressure")).fold(f64::INFINITY, f64::min);
    found.near("lowest_mean_pressure", number(report, "lowest_mean_pressure"), least, 0.0);
}
