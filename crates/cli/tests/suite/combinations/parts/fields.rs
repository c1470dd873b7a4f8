//! Fields at the waypoints: geometry, laws of the surfaces, numbers and losses that follow from them.

use gfmd_files::Reader;
use serde_json::Value;

use super::super::found::{Found, number};
use super::super::numbers::{deviation, largest, mean};
use super::memory::{Memory, Reached};
use super::{Drive, Parts};
use crate::combinations::draw::Control;

/// Fields of a waypoint.
struct State {
    pressure: Vec<f64>,
    repulsion: Vec<f64>,
    gap: Vec<f64>,
    displacement: Vec<f64>,
    worn: Vec<f64>,
    pressed_in: Vec<f64>,
    /// Displacement by plastic strain below the surface.
    imprint: Vec<f64>,
    shear: Option<[Vec<f64>; 2]>,
    /// Lower face of a plate, seen from below.
    lower: Option<Box<State>>,
}

impl State {
    fn faces(&self) -> impl Iterator<Item = &State> {
        std::iter::once(self).chain(self.lower.as_deref())
    }

    /// Returns the points of all faces as one state.
    fn whole(&self) -> Self {
        let all = |of: fn(&Self) -> &Vec<f64>| self.faces().flat_map(of).copied().collect();
        Self {
            pressure: all(|face| &face.pressure),
            repulsion: all(|face| &face.repulsion),
            gap: all(|face| &face.gap),
            displacement: all(|face| &face.displacement),
            worn: all(|face| &face.worn),
            pressed_in: all(|face| &face.pressed_in),
            imprint: all(|face| &face.imprint),
            shear: self.shear.clone(),
            lower: None,
        }
    }
}

/// Sizes that set what is a rounding error.
struct Sizes {
    clearance: Vec<f64>,
    deviation: f64,
}

impl Sizes {
    fn of(heights: Vec<f64>) -> Self {
        let top = heights.iter().fold(f64::NEG_INFINITY, |top, h| top.max(*h));
        Self { clearance: heights.iter().map(|h| top - h).collect(), deviation: deviation(&heights) }
    }
}

/// Checks the waypoints at these steps.
pub(super) fn check(
    parts: &Parts,
    steps: &[Value],
    drives: &[Drive],
    places: &[usize],
    file: &Reader,
    found: &mut Found,
) {
    let heights: Vec<f64> = file.values("/surface/height").unwrap();
    found.must(heights == parts.heights, || "other heights in the file".into());
    let lower = file.contains("/lower/height").then(|| file.values("/lower/height").unwrap());
    found.must(lower == parts.lower, || "another lower surface in the file".into());
    let mut sizes: Vec<Sizes> = [Some(heights), lower].into_iter().flatten().map(Sizes::of).collect();
    // Both faces have the rounding errors of the rougher one.
    let roughest = sizes.iter().map(|sizes| sizes.deviation).fold(0.0, f64::max);
    sizes.iter_mut().for_each(|sizes| sizes.deviation = roughest);
    let is_sheared = file.contains("/fields/shear_x");
    // Between waypoints several steps apart, the fields are unknown.
    let is_followed = places.iter().enumerate().all(|(k, step)| k == *step) && parts.energy_solves == Some(0);
    // A law pulls from the first touch on, so that a path of some duration begins with a jump.
    let begins_at_rest = parts.law.is_none() || parts.relaxation.is_none() || parts.times.first() == Some(&0.0);
    let mut memory = if is_followed && begins_at_rest { Memory::new(parts, is_sheared) } else { None };
    let mut before: Option<(State, Option<Reached>)> = None;
    for (waypoint, step) in places.iter().copied().enumerate() {
        let first = found.complaints.len();
        let state = read(parts, file, waypoint);
        let z = |state: &State| state.pressure.iter().map(|p| -p).collect::<Vec<f64>>();
        let traction: Vec<Vec<f64>> = match (&state.lower, &state.shear) {
            (Some(lower), _) => {
                between(parts, &steps[step], drives[step], (&state, lower), &sizes, found);
                // Both faces are pressed into the plate.
                vec![state.pressure.clone(), lower.pressure.clone()]
            }
            (None, shear) => {
                one(parts, &steps[step], drives[step], &state, &sizes[0], found);
                energy(parts, &steps[step], &state, found);
                match shear.as_ref().filter(|_| memory.as_ref().is_some_and(Memory::has_shear)) {
                    Some([x, y]) => vec![x.clone(), y.clone(), z(&state)],
                    None => vec![z(&state)],
                }
            }
        };
        let sizes = &sizes[0];
        let start = step.checked_sub(1).map_or([0.0; 5], |before| drives[before]);
        let reached = memory.as_mut().map(|memory| memory.advance(traction, drives[step][3] - start[3]));
        if let Some(reached) = &reached {
            body(parts, &steps[step], &state, reached, sizes, found);
        }
        if is_followed {
            let last = before.as_ref().map(|(state, reached)| (state, reached.as_ref()));
            let moved = [drives[step], start];
            way(parts, &steps[step], last, (&state, reached.as_ref()), moved, sizes, found);
        }
        found.complaints[first..].iter_mut().for_each(|text| *text = format!("waypoint {waypoint}: {text}"));
        before = Some((state, reached));
    }
}

fn read(parts: &Parts, file: &Reader, waypoint: usize) -> State {
    let lower = parts.lower.is_some().then(|| {
        let mut state = read_face(parts, file, "lower_", waypoint);
        state.displacement.iter_mut().for_each(|u| *u = -*u);
        state.into()
    });
    State { lower, ..read_face(parts, file, "", waypoint) }
}

fn read_face(parts: &Parts, file: &Reader, face: &str, waypoint: usize) -> State {
    let points = parts.plane.len();
    let field = |name: &str| {
        let name = format!("/fields/{face}{name}");
        file.contains(&name).then(|| file.slab::<f64>(&name, waypoint).unwrap())
    };
    let [pressure, gap, displacement] = ["pressure", "gap", "displacement_z"].map(|name| field(name).unwrap());
    let [worn, pressed_in, imprint] = ["wear_depth", "plastic_depth", "plastic_displacement_z"]
        .map(|name| field(name).unwrap_or_else(|| vec![0.0; points]));
    let shear = field("shear_x").map(|x| [x, field("shear_y").unwrap_or_else(|| vec![0.0; points])]);
    let touches = |g: f64| g <= 1e-9 * largest(&gap);
    let repulsion = pressure.iter().zip(&gap).map(|(p, g)| match &parts.law {
        Some(law) if law.has_wall() => {
            if touches(*g) {
                (p + law.tension(0.0)).max(0.0)
            } else {
                0.0
            }
        }
        // Where a law without a wall vanishes, the sign of the pressure is a rounding error.
        Some(law) if law.tension(*g) >= 0.0 => 0.0,
        _ => p.max(0.0),
    });
    let repulsion = repulsion.collect();
    State { pressure, repulsion, gap, displacement, worn, pressed_in, imprint, shear, lower: None }
}

/// Checks the numbers and fields of both faces of a plate on their own; each face has its part of the approach.
fn between(
    parts: &Parts,
    step: &Value,
    drive: Drive,
    (upper, lower): (&State, &State),
    sizes: &[Sizes],
    found: &mut Found,
) {
    let below = &step["lower"];
    let mut above = step.clone();
    above["approach"] = (number(step, "approach") - number(below, "approach")).into();
    one(parts, &above, drive, upper, &sizes[0], found);
    let first = found.complaints.len();
    // The load acts on both faces, and the reduced load is a number of the plate.
    let on_lower = Parts { control: Control::Approach, ..parts.clone() };
    one(&on_lower, below, drive, lower, &sizes[1], found);
    found.complaints[first..].iter_mut().for_each(|text| *text = format!("lower face: {text}"));
    energy(parts, step, upper, found);
}

/// Checks the energy of the law, of both faces if there are two.
fn energy(parts: &Parts, step: &Value, state: &State, found: &mut Found) {
    let Some(law) = &parts.law else { return };
    let of = |g: &f64| law.energy(if law.has_wall() { g.max(0.0) } else { *g });
    let faces = state.faces().map(|face| face.gap.iter().map(of).collect::<Option<Vec<f64>>>());
    if let Some(faces) = faces.collect::<Option<Vec<Vec<f64>>>>() {
        let most = faces.iter().map(|energies| largest(energies)).fold(0.0, f64::max);
        let sum = faces.iter().map(|energies| mean(energies)).sum();
        found.near("interface_energy", number(step, "interface_energy"), sum, 1e-7 * most);
    }
}

/// Checks the numbers and fields of a waypoint on their own.
fn one(parts: &Parts, step: &Value, drive: Drive, state: &State, sizes: &Sizes, found: &mut Found) {
    let State { pressure, repulsion, gap, displacement, worn, pressed_in, .. } = state;
    let points = pressure.len();
    let tolerance = parts.tolerance;
    // Where little is left, the tolerance is relative to the stress of the heights.
    let stress = largest(pressure).max(largest(repulsion)).max(parts.body.contact_modulus() * sizes.deviation);
    let reported = number(step, "mean_pressure");
    found.near("mean_pressure", reported, mean(pressure), 10.0 * tolerance * stress);
    match parts.control {
        Control::Pressure => found.near("load", reported, drive[0], 10.0 * tolerance * stress.max(drive[0])),
        Control::PStar => {
            let unit = number(step, "mean_pressure") / number(step, "p_star");
            found.near("p_star", number(step, "p_star"), drive[0], 10.0 * tolerance * (stress / unit).max(drive[0]));
        }
        Control::Approach => {}
    }
    // Geometry.
    let approach = number(step, "approach");
    let shift: Vec<f64> =
        (0..points).map(|i| sizes.clearance[i] + worn[i] + pressed_in[i] - displacement[i] - gap[i]).collect();
    let known = if approach.is_nan() { mean(&shift) } else { approach };
    let apart = shift.iter().map(|shift| (shift - known).abs()).fold(0.0, f64::max);
    let size = largest(&sizes.clearance) + known.abs() + largest(displacement) + largest(worn) + largest(pressed_in);
    found.near("gap less clearance + depths - u_z - approach", apart, 0.0, 1e-8 * size);
    for (name, depth) in [("wear", worn), ("plastic", pressed_in)] {
        found.must(depth.iter().all(|depth| *depth >= 0.0), || format!("a negative {name} depth"));
    }
    // Interaction along the normal.
    let has_wall = parts.law.as_ref().is_none_or(|law| law.has_wall());
    if has_wall {
        let below = gap.iter().fold(0.0_f64, |below, g| below.max(-g));
        found.near("penetration", below, 0.0, 10.0 * tolerance * sizes.deviation.max(1e-3 * size));
    }
    if let Some(hardness) = &parts.hardness {
        for i in 0..points {
            let (p, most) = (pressure[i], hardness[i]);
            found.must(p <= most * (1.0 + 10.0 * tolerance) + 10.0 * tolerance * stress, || {
                format!("{p:e} of {most:e} at {i}")
            });
        }
    }
    match &parts.law {
        Some(law) => {
            let allowed = stress * (1e3 * tolerance).clamp(1e-6, 1e-4);
            for i in 0..points {
                if law.jump().is_some_and(|jump| (gap[i] - jump).abs() < 1e-6 * jump) {
                    continue;
                }
                let touches = law.has_wall() && gap[i] <= 1e-9 * largest(gap);
                let left = pressure[i] + law.tension(if touches { 0.0 } else { gap[i] });
                let error = if touches { (-left).max(0.0) } else { left.abs() };
                found.must(error <= allowed, || format!("the law at {i} leaves {error:e} of {stress:e}"));
            }
        }
        None => {
            found.must(pressure.iter().all(|p| *p >= -10.0 * tolerance * stress), || "tension at a wall".into());
            let pressed = pressure.iter().sum::<f64>().max(f64::MIN_POSITIVE);
            let open = pressure.iter().zip(gap).map(|(p, g)| p * g.abs()).sum::<f64>() / pressed;
            found.near("mean gap under pressure", open, 0.0, 1e2 * tolerance * sizes.deviation.max(1e-3 * size));
        }
    }
    numbers(parts, step, state, found);
    if let Some([x, y]) = state.shear.as_ref().filter(|_| parts.rubs()) {
        shear(parts, step, state, [x, y], found);
    }
}

/// Checks numbers that follow from the fields.
fn numbers(parts: &Parts, step: &Value, state: &State, found: &mut Found) {
    let State { pressure, repulsion, gap, worn, pressed_in, .. } = state;
    let points = pressure.len() as f64;
    let strongest = largest(repulsion);
    let stress = strongest.max(largest(pressure));
    let is_clear = |r: f64| r > 1e2 * parts.tolerance.max(1e-8) * stress;
    let (surely, possibly) = (
        repulsion.iter().filter(|r| is_clear(**r)).count() as f64,
        match &parts.law {
            Some(law) if law.has_wall() => gap.iter().filter(|g| **g <= 1e-9 * largest(gap)).count() as f64,
            _ => repulsion.iter().filter(|r| **r > 0.0).count() as f64,
        },
    );
    let area = number(step, "area_fraction") * points;
    found.must(surely - 1e-6 <= area && area <= possibly + 1e-6, || {
        format!("area_fraction is {area} points; {surely} to {possibly} are repelled")
    });
    if step.get("max_pressure").is_some() {
        // Beside a law, the depths pressed in and worn off determine the repulsion up to the residual.
        let is_given = parts.law.is_some() && (parts.hardness.is_some() || parts.wear.is_some());
        let allowed = if is_given { 1e2 * parts.tolerance } else { 1e-7 };
        found.near("max_pressure", number(step, "max_pressure"), strongest, allowed * stress);
    }
    if step.get("max_net_pressure").is_some() {
        let most = pressure.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        found.near("max_net_pressure", number(step, "max_net_pressure"), most, 1e-7 * stress);
    }
    let reported = number(step, "mean_gap");
    if !(reported == 0.0 && surely == points) {
        found.near("mean_gap", reported, mean(gap), 1e-9 * largest(gap));
    }
    let deepest = worn.iter().copied().fold(0.0, f64::max);
    for (key, value, size) in [
        ("wear_volume", mean(worn), deepest),
        ("max_wear", deepest, deepest),
        ("plastic_volume", mean(pressed_in), largest(pressed_in)),
    ] {
        let is_given = if key == "plastic_volume" { parts.hardness.is_some() } else { parts.wear.is_some() };
        found.must(step.get(key).is_some() == is_given, || format!("{key} is there: {}", !is_given));
        if is_given {
            found.near(key, number(step, key), value, 1e-12 * size);
        }
    }
    if let Some(hardness) = &parts.hardness {
        let count = |share: f64| pressure.iter().zip(hardness).filter(|(p, most)| **p >= share * **most).count() as f64;
        let reported = number(step, "plastic_fraction") * points;
        let (surely, possibly) = (count(1.0), count(1.0 - 1.001e-3));
        found.must(surely - 1e-6 <= reported && reported <= possibly + 1e-6, || {
            format!("plastic_fraction is {reported} points; {surely} to {possibly} carry the hardness")
        });
    }
}

/// Checks the shear and its limits.
fn shear(parts: &Parts, step: &Value, state: &State, [x, y]: [&[f64]; 2], found: &mut Found) {
    let State { pressure, repulsion, .. } = state;
    for (axis, field) in [x, y].into_iter().enumerate() {
        if let Some(reported) = step["mean_shear"][axis].as_f64() {
            found.near("mean_shear", reported, mean(field), 1e-9 * largest(field));
        }
    }
    let limits: Vec<f64> = repulsion.iter().zip(pressure).map(|(r, p)| parts.limit(*r, *p)).collect();
    let strongest = largest(&limits);
    let (mut least, mut most) = (0.0, 0.0);
    for i in 0..limits.len() {
        let size = x[i].hypot(y[i]);
        found.must(size <= limits[i] + 2.0 * parts.tolerance.max(1e-8) * strongest, || {
            format!("shear {size:e} of {:e} at {i}", limits[i])
        });
        if limits[i] > 0.0 {
            least += f64::from(u8::from(size < limits[i] * (1.0 - 1e-4) && limits[i] > 1e-6 * strongest));
            most += f64::from(u8::from(size < limits[i] * (1.0 - 1e-12) || limits[i] <= 1e-6 * strongest));
        }
    }
    let reported = number(step, "stick_fraction") * limits.len() as f64;
    found.must(least - 1e-6 <= reported && reported <= most + 1e-6, || {
        format!("stick_fraction is {reported} points; {least} to {most} are below their limit")
    });
}

/// Checks the displacement and the energy of the body.
fn body(parts: &Parts, step: &Value, state: &State, reached: &Reached, sizes: &Sizes, found: &mut Found) {
    // A plate has the indentations of both faces.
    let elastic: Vec<Vec<f64>> = match state.lower {
        Some(_) => reached.displacement.iter().map(|field| field.iter().map(|u| -u).collect()).collect(),
        None => vec![reached.displacement.last().unwrap().clone()],
    };
    let uz: Vec<Vec<f64>> = (elastic.iter().zip(state.faces()))
        .map(|(elastic, face)| elastic.iter().zip(&face.imprint).map(|(elastic, imprint)| elastic + imprint).collect())
        .collect();
    let mut levels: Vec<f64> = state.faces().zip(&uz).map(|(face, uz)| mean(&face.displacement) - mean(uz)).collect();
    match levels[..] {
        [_] => levels = vec![0.0],
        // Nothing holds the plate as a whole.
        [upper, lower] => levels = vec![0.5 * (upper - lower), 0.5 * (lower - upper)],
        _ => {}
    }
    let apart = state.faces().zip(&uz).zip(levels).map(|((face, uz), level)| {
        uz.iter().zip(&face.displacement).map(|(a, b)| (b - a - level).abs()).fold(0.0, f64::max)
    });
    let apart = apart.fold(0.0, f64::max);
    let size = uz.iter().map(|uz| largest(uz)).fold(1e-3 * sizes.deviation, f64::max);
    let allowed = reached.tolerance.max(100.0 * parts.tolerance);
    found.near("displacement_z less that of the tractions", apart, 0.0, allowed * size);
    let is_whole = state.shear.is_none() || reached.displacement.len() == 3;
    if is_whole {
        // A uniform pressure, such as the hardness everywhere, moves a half-space as a whole.
        let rounding = 1e-12 * largest(&state.pressure) * size;
        if parts.yielding.is_some() {
            // The energy of residual stress is not negative, and does no work on the load.
            let kept = number(step, "elastic_energy");
            found.must(kept >= reached.stored * (1.0 - allowed) - rounding, || {
                format!("elastic_energy is {kept:e}, less than {:e} of the pressure", reached.stored)
            });
            return;
        }
        found.near(
            "elastic_energy",
            number(step, "elastic_energy"),
            reached.stored,
            allowed * reached.stored + rounding,
        );
    }
}

/// Checks depths, slip and losses of a step between two waypoints.
fn way(
    parts: &Parts,
    step: &Value,
    before: Option<(&State, Option<&Reached>)>,
    (state, reached): (&State, Option<&Reached>),
    [now, then]: [Drive; 2],
    sizes: &Sizes,
    found: &mut Found,
) {
    let whole = before.map(|(state, reached)| (state.whole(), reached));
    let before = whole.as_ref().map(|(state, reached)| (state, *reached));
    let state = &state.whole();
    let points = state.pressure.len();
    let none = vec![0.0; points];
    let hardness = parts.hardness.as_ref().map(|of| of.repeat(points / of.len()));
    let grown = |of: fn(&State) -> &Vec<f64>| -> Vec<f64> {
        let start = before.map_or(&none, |(state, _)| of(state));
        of(state).iter().zip(start).map(|(now, then)| now - then).collect()
    };
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / parts.plane.len() as f64;
    let size = product(
        &state.pressure.iter().map(|p| p.abs()).collect::<Vec<f64>>(),
        &state.displacement.iter().map(|u| u.abs() + sizes.deviation).collect::<Vec<f64>>(),
    );
    let alone = |key: &str| if step.get(key).is_some() { number(step, key) } else { f64::NAN };
    let worn = grown(|state| &state.worn);
    let pressed_in = grown(|state| &state.pressed_in);
    found.must(pressed_in.iter().all(|grown| *grown >= -1e-12 * sizes.deviation), || {
        "a plastic depth has shrunk".into()
    });
    // The jump at first touch is an increment of its own.
    let is_drawn = before.is_none() && parts.law.is_some() && parts.relaxation.is_some() && now[3] > 0.0;
    let lost = alone("lost_wear");
    if parts.wear.is_some() && lost.is_finite() && !is_drawn {
        found.near("lost_wear", lost, product(&state.pressure, &worn), 1e-9 * size + 1e-9 * lost.abs());
    }
    if let (Some(hardness), lost) = (&hardness, alone("lost_plastic"))
        && lost.is_finite()
    {
        let [least, most] = [&state.pressure, hardness].map(|pressure| product(pressure, &pressed_in));
        if is_drawn {
            let allowed = parts.tolerance * size + 1e-9 * most;
            found.must(lost >= least - allowed && lost <= most + allowed, || {
                format!("lost_plastic is {lost:e}, not between {least:e} and {most:e}")
            });
        } else {
            found.near("lost_plastic", lost, least, 1e-9 * size + 1e-9 * lost.abs());
        }
    }
    if let Some(hardness) = hardness.as_ref().filter(|_| !is_drawn) {
        // Only points at the hardness are pressed in.
        for i in 0..points {
            let at = state.pressure[i] >= hardness[i] * (1.0 - 1e-3);
            found.must(at || pressed_in[i] <= 1e-9 * sizes.deviation, || {
                format!("pressed in by {:e} at {i}", pressed_in[i])
            });
        }
    }
    if let (Some(reached), true) = (reached, parts.relaxation.is_some()) {
        let lost =
            if step.get("lost_relaxation").is_some() { alone("lost_relaxation") } else { number(step, "dissipated") };
        if lost.is_finite() && (state.shear.is_none() || reached.displacement.len() == 3) {
            let allowed = reached.tolerance.max(100.0 * parts.tolerance) * (reached.stored.abs() + reached.lost);
            found.near("lost_relaxation", lost, reached.lost, allowed);
        }
    }
    // Slip, from the displacement by the tractions.
    let slip = reached.filter(|reached| reached.displacement.len() == 3).map(|reached| {
        let [sine, cosine] =
            if parts.direction == 0.0 { [0.0, 1.0] } else { parts.direction.to_radians().sin_cos().into() };
        let [along, across] = [now[1] - then[1], now[2] - then[2]];
        // Before the first waypoint the rigid surface was at its origin.
        let [along, across] = if before.is_none() { [now[1], now[2]] } else { [along, across] };
        let moved = [along * cosine - across * sine, along * sine + across * cosine];
        [0, 1].map(|axis| -> Vec<f64> {
            let start = before.and_then(|(_, reached)| reached).map_or(&none, |reached| &reached.displacement[axis]);
            reached.displacement[axis].iter().zip(start).map(|(now, then)| now - then - moved[axis]).collect()
        })
    });
    if let Some(wear) = &parts.wear {
        let rate: Option<Vec<f64>> = match (wear.by_slip, &slip) {
            (false, _) => Some(vec![wear.coefficient * (now[4] - then[4]); points]),
            (true, Some([x, y])) => Some(x.iter().zip(y).map(|(x, y)| wear.coefficient * x.hypot(*y)).collect()),
            (true, None) => None,
        };
        if let Some(rate) = rate.filter(|_| !is_drawn) {
            let strongest = largest(&state.repulsion).max(largest(&state.pressure));
            let fastest = largest(&rate);
            let deepest = largest(&state.worn);
            for i in 0..points {
                let expected = rate[i] * state.repulsion[i];
                let error = (worn[i] - expected).abs();
                // The slip has the error of the displacement.
                let noise = if wear.by_slip {
                    wear.coefficient * state.repulsion[i] * 1e2 * parts.tolerance.max(1e-8) * sizes.deviation
                } else {
                    0.0
                };
                let allowed = 1e3 * parts.tolerance.max(1e-8) * fastest * strongest + noise + 1e-12 * deepest;
                found.must(error <= allowed, || format!("worn by {:e} at {i}, not {expected:e}", worn[i]));
            }
        }
    }
    let (Some([sx, sy]), Some([tx, ty])) = (&slip, &state.shear) else { return };
    if !parts.rubs() {
        return;
    }
    let limits = |state: &State| -> Vec<f64> {
        state.repulsion.iter().zip(&state.pressure).map(|(r, p)| parts.limit(*r, *p)).collect()
    };
    let (start, end) = (before.map_or_else(|| none.clone(), |(state, _)| limits(state)), limits(state));
    let strongest = largest(&end);
    if strongest == 0.0 {
        return;
    }
    let length = sizes.deviation;
    let stiffness = strongest / length;
    let mut lost = 0.0;
    for i in 0..points {
        let moved = [tx[i] - stiffness * sx[i], ty[i] - stiffness * sy[i]];
        let reach = moved[0].hypot(moved[1]);
        let factor = if reach > end[i] { end[i] / reach } else { 1.0 };
        let off = (tx[i] - factor * moved[0]).hypot(ty[i] - factor * moved[1]);
        found.must(
            off <= 1e2 * parts.tolerance.max(1e-8) * strongest * (1.0 + largest(&state.displacement) / length),
            || format!("at {i} the shear misses its law by {off:e} of {strongest:e}"),
        );
        if end[i] > 1e-9 * strongest {
            lost += 0.5 * (start[i] + end[i]) / end[i] * -(tx[i] * sx[i] + ty[i] * sy[i]) / points as f64;
        }
    }
    let is_alone =
        parts.law.is_none() && parts.hardness.is_none() && parts.relaxation.is_none() && parts.wear.is_none();
    let reported = if is_alone { number(step, "dissipated") } else { alone("lost_friction") };
    if reported.is_finite() {
        let most = largest(sx).hypot(largest(sy)).max(1e-3 * length);
        let allowed = 1e3 * parts.tolerance.max(1e-8) * strongest.max(largest(&start)) * most;
        found.near("lost_friction", reported, lost, allowed + 1e-6 * lost.abs());
    }
}
