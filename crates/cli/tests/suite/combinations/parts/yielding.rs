//! Bodies that yield below their surface, drawn with dice of their own, so that other paths stay as they are. Their
//! numbers follow from the plastic strain at the waypoints.

use std::fmt::Write as _;

use gfmd_files::Reader;
use serde_json::Value;

use super::super::draw::{Body, Control, Dice, short};
use super::super::elastic::{Base, Layer};
use super::super::found::{Found, number};
use super::super::numbers::{gradient, largest, mean};
use super::Parts;

/// Largest Poisson's ratio of layers with cells.
const POISSON: f64 = 0.495;

/// Yielding of the first body.
#[derive(Clone, Debug)]
pub(crate) struct Yielding {
    /// Yield stress of each layer from the top, and of a half-space below them; 0 for an elastic one.
    stresses: Vec<f64>,
    /// Isotropic hardening, and kinematic hardening.
    hardening: [f64; 2],
    /// Plastic strain and yield stress of a curve, in place of the isotropic hardening; none if empty.
    curve: Vec<[f64; 2]>,
    /// Flags of the cells.
    cells: String,
}

/// Returns the materials from the top down, with the depths of their bottoms.
fn materials(body: &Body) -> Vec<(Layer, f64)> {
    let mut depth = 0.0;
    let mut all: Vec<(Layer, f64)> = Vec::new();
    for layer in &body.first.layers {
        depth += layer.height;
        all.push((*layer, depth));
    }
    if let Base::HalfSpace(young, poisson) = body.first.base {
        all.push((Layer { young, poisson, height: f64::INFINITY }, f64::INFINITY));
    }
    all
}

impl Yielding {
    /// Draws the yielding of a path without other parts; `None` for a path that has none.
    pub(super) fn draw(parts: &mut Parts) -> Option<Self> {
        let dice = &mut Dice::new(parts.index + 0x91e1d);
        let materials = materials(&parts.body);
        // A few are refused: for their ratio, or for another part.
        let is_wild = dice.chance(0.05);
        let is_soft = materials.iter().all(|(layer, _)| layer.poisson <= POISSON);
        if !(dice.chance(0.4) && (is_soft || is_wild)) {
            return None;
        }
        if !(is_wild && dice.chance(0.5)) {
            (parts.law, parts.friction, parts.shear_strength, parts.of_net) = (None, None, None, false);
            (parts.hardness, parts.relaxation, parts.wear, parts.is_free) = (None, None, None, false);
            (parts.lateral, parts.lateral_y, parts.direction) = (Vec::new(), Vec::new(), 0.0);
            (parts.times, parts.distances) = (Vec::new(), Vec::new());
        }
        let modulus = parts.body.contact_modulus();
        let steep = gradient(parts.plane, &parts.heights, false);
        let stress = short((modulus * steep * dice.scale(0.02, 0.3)).min(0.08 * materials[0].0.young));
        let of_layer = |dice: &mut Dice, layer: &Layer| match dice.chance(0.5) {
            true => short((stress * dice.scale(0.5, 2.0)).min(0.08 * layer.young)),
            false => 0.0,
        };
        let below: Vec<f64> = materials[1..].iter().map(|(layer, _)| of_layer(dice, layer)).collect();
        let hardens = dice.chance(0.8);
        let isotropic = if hardens { short(stress * dice.scale(0.2, 10.0)) } else { 0.0 };
        let kinematic = if dice.chance(0.4) { short(stress * dice.scale(0.2, 10.0)) } else { 0.0 };
        // Cells end at the interfaces, and are not deeper than the body.
        let deepest = 0.9 * materials[0].1.min(0.6);
        let is_even = parts.plane.n.iter().all(|n| n % 2 == 0 || *n == 1);
        let cells = match dice.count(0, 5) {
            0 => format!(" --cells graded:{},{},{}", dice.of(&[0.5, 1.0]), dice.of(&[1.0, 1.3]), dice.of(&[0, 3])),
            1 => format!(" --cells uniform:{},{}", dice.count(3, 12), short(deepest)),
            2 => {
                let parts: Vec<f64> = [0.1, 0.2, 0.3, 0.4].map(|share| short(share * deepest)).into();
                let list: Vec<String> = parts.iter().map(f64::to_string).collect();
                let coarse = if is_even && dice.chance(0.7) { " --coarsening 1,1,2,2" } else { "" };
                format!(" --cells {}{coarse}", list.join(","))
            }
            _ => String::new(),
        };
        // Loads of the asperities, below the load at which the body yields as a whole.
        let most = 0.5 * stress;
        for load in &mut parts.loads {
            let pressure = most * dice.scale(0.05, 1.0);
            *load = short(match parts.control {
                Control::Pressure => pressure,
                Control::PStar => pressure / (modulus * steep),
                Control::Approach => parts.plane.length[0] * steep * dice.scale(0.01, 0.15),
            });
        }
        parts.steps = parts.steps.min(2);
        // More dice, so that other paths stay as they are.
        let dice = &mut Dice::new(parts.index + 0xc0de);
        let is_alone = below.iter().all(|stress| *stress == 0.0);
        let curve = if is_alone && dice.chance(0.3) {
            let mut last = stress;
            let rows = [0.0, 1e-3, 0.01, 0.1].map(|strain| {
                let row = [strain, last];
                last = short(last * dice.between(1.0, 1.5));
                row
            });
            rows.to_vec()
        } else {
            Vec::new()
        };
        if parts.control != Control::Approach && parts.loads.len() > 1 && dice.chance(0.4) {
            let last = parts.loads.len() - 1;
            parts.loads[last] = 0.0;
        }
        Some(Self { stresses: [vec![stress], below].concat(), hardening: [isotropic, kinematic], curve, cells })
    }

    /// Returns the energy that isotropic hardening stores up to an equivalent plastic strain, per volume.
    fn stored(&self, equivalent: f64) -> f64 {
        let Self { stresses, hardening: [isotropic, _], curve, .. } = self;
        if curve.is_empty() {
            return 0.5 * isotropic * equivalent * equivalent;
        }
        let (mut energy, above) = (0.0, |stress: f64| stress - stresses[0]);
        for rows in curve.windows(2) {
            let [[begin, first], [end, last]] = [rows[0], rows[1]];
            let reached = equivalent.clamp(begin, end);
            let there = first + (last - first) * (reached - begin) / (end - begin);
            energy += 0.5 * (above(first) + above(there)) * (reached - begin);
        }
        let [end, last] = curve[curve.len() - 1];
        energy + above(last) * (equivalent - end).max(0.0)
    }

    /// Returns the flags.
    pub(super) fn words(&self) -> String {
        let Self { stresses, hardening: [isotropic, kinematic], curve, cells } = self;
        let mut text = format!(" --yield-stress {}", stresses[0]);
        if !curve.is_empty() {
            let rows: Vec<String> = curve.iter().map(|[strain, stress]| format!("{strain}:{stress}")).collect();
            let _ = write!(text, " --hardening-curve {}", rows.join(","));
        }
        for (flag, value) in [("hardening", isotropic), ("kinematic-hardening", kinematic)] {
            if *value > 0.0 && (curve.is_empty() || flag != "hardening") {
                let _ = write!(text, " --{flag} {value}");
            }
        }
        if stresses[1..].iter().any(|stress| *stress > 0.0) {
            let all: Vec<String> = stresses[1..].iter().map(f64::to_string).collect();
            let _ = write!(text, " --layer-yield {}", all.join(","));
        }
        text + cells
    }

    /// Returns the yielding of a body that hardly yields: loads are far below.
    pub(super) fn hard(&self, body: &Body) -> Self {
        let least = materials(body).iter().map(|(layer, _)| layer.young).fold(f64::INFINITY, f64::min);
        let stresses = self.stresses.iter().map(|stress| if *stress > 0.0 { 0.099 * least } else { 0.0 }).collect();
        Self { stresses, curve: Vec::new(), ..self.clone() }
    }
}

/// Strain of a cell.
struct Strained {
    thickness: f64,
    depth: f64,
    /// Material and yield stress.
    material: Layer,
    stress: f64,
    /// ε^p component by component, and κ.
    strain: Vec<Vec<f64>>,
    equivalent: Vec<f64>,
}

fn read(parts: &Parts, yielding: &Yielding, file: &Reader, waypoint: usize) -> Vec<Strained> {
    let materials = materials(&parts.body);
    let [thicknesses, depths]: [Vec<f64>; 2] =
        ["thickness", "depth"].map(|name| file.values(&format!("/cells/{name}")).unwrap());
    let of_cell = |cell: usize| {
        let slab = |name: &str| file.slab(&format!("/plastic_at_waypoints/{name}_{cell}"), waypoint).unwrap();
        let (strain, equivalent): (Vec<f64>, Vec<f64>) = (slab("strain"), slab("equivalent"));
        let middle = depths[cell] - 0.5 * thicknesses[cell];
        let layer = materials.iter().position(|(_, bottom)| middle < *bottom).unwrap();
        Strained {
            thickness: thicknesses[cell],
            depth: depths[cell],
            material: materials[layer].0,
            stress: yielding.stresses[layer],
            strain: strain.chunks_exact(equivalent.len()).map(<[f64]>::to_vec).collect(),
            equivalent,
        }
    };
    (0..depths.len()).map(of_cell).collect()
}

/// Checks the plastic strain at the waypoints, reached at these steps, and the numbers that follow from it.
pub(super) fn check(parts: &Parts, steps: &[Value], places: &[usize], file: &Reader, found: &mut Found) {
    let Some(yielding) = &parts.yielding else { return };
    let mut before: Option<Vec<Strained>> = None;
    for (waypoint, step) in places.iter().copied().enumerate() {
        let first = found.complaints.len();
        let cells = read(parts, yielding, file, waypoint);
        one(parts, yielding, &steps[step], (&cells, file, waypoint), found);
        // A waypoint one step after the last one.
        let is_next = step == if waypoint == 0 { 0 } else { places[waypoint - 1] + 1 };
        if is_next && parts.energy_solves == Some(0) {
            let none = |cell: &Strained| vec![0.0; cell.equivalent.len()];
            let lost = cells.iter().enumerate().map(|(number, cell)| {
                let then = before.as_ref().map_or_else(|| none(cell), |before| before[number].equivalent.clone());
                let grown: Vec<f64> = cell.equivalent.iter().zip(&then).map(|(now, then)| now - then).collect();
                found.must(grown.iter().all(|grown| *grown >= 0.0), || format!("κ of cell {number} has fallen"));
                cell.thickness * cell.stress * mean(&grown)
            });
            let lost: f64 = lost.sum();
            let rounding = 1e-12 * number(&steps[step], "elastic_energy").abs();
            found.near("dissipated", number(&steps[step], "dissipated"), lost, 1e-9 * lost.abs() + rounding);
        }
        found.complaints[first..].iter_mut().for_each(|text| *text = format!("waypoint {waypoint}: {text}"));
        before = Some(cells);
    }
    let yielded = before.is_some_and(|cells| cells.iter().any(|cell| largest(&cell.equivalent) > 0.0));
    found.note(if yielded { "yielded" } else { "did not yield" }.into());
}

/// Checks the strain of one waypoint.
fn one(
    parts: &Parts,
    yielding: &Yielding,
    step: &Value,
    (cells, file, waypoint): (&[Strained], &Reader, usize),
    found: &mut Found,
) {
    let [_, kinematic] = yielding.hardening;
    let (mut most, mut integral, mut volume, mut depth) = (0.0_f64, 0.0, 0.0, 0.0);
    let (mut hardening, mut sink, mut size) = (0.0, 0.0, 0.0);
    for (number, cell) in cells.iter().enumerate() {
        let Strained { thickness, material, strain, equivalent, .. } = cell;
        let squares: Vec<f64> =
            (0..equivalent.len()).map(|i| strain.iter().map(|component| component[i].powi(2)).sum()).collect();
        for (square, equivalent) in squares.iter().zip(equivalent) {
            // κ is the length of the path of the strain.
            let reach = 1.5_f64.sqrt() * equivalent;
            found.must(square.sqrt() <= reach * (1.0 + 1e-9), || {
                format!("a strain of {:e} with κ of {equivalent:e} in cell {number}", square.sqrt())
            });
        }
        found.must(cell.stress > 0.0 || largest(equivalent) == 0.0, || format!("the elastic cell {number} yields"));
        most = most.max(largest(equivalent));
        integral += thickness * mean(equivalent);
        volume += thickness * equivalent.iter().filter(|k| **k > 0.0).count() as f64 / equivalent.len() as f64;
        if largest(equivalent) > 0.0 {
            depth = cell.depth;
        }
        let own: Vec<f64> =
            equivalent.iter().zip(&squares).map(|(k, square)| yielding.stored(*k) + kinematic / 3.0 * square).collect();
        hardening += thickness * mean(&own);
        // The mean stress on horizontal planes is the load alone: τ_zz of the mean strain is balanced by a mean strain.
        let compliance = (1.0 - 2.0 * material.poisson) / (1.0 - material.poisson);
        sink += thickness * compliance * mean(&strain[0]) / 1.5_f64.sqrt();
        size += thickness * largest(&strain[0]);
    }
    found.near("max_plastic_strain", number(step, "max_plastic_strain"), most, 1e-12 * most);
    found.near("plastic_strain_integral", number(step, "plastic_strain_integral"), integral, 1e-12 * integral);
    found.near("yielded_volume", number(step, "yielded_volume"), volume, 1e-12 * volume);
    found.near("yield_depth", number(step, "yield_depth"), depth, 1e-12 * depth);
    let kept = number(step, "hardening_energy");
    found.near("hardening_energy", kept, hardening, 1e-9 * hardening + 1e-300);
    let imprint: Vec<f64> = file.slab("/fields/plastic_displacement_z", waypoint).unwrap();
    found.near("mean plastic displacement", mean(&imprint), sink, 1e-9 * size);
    let told = &step["plastic_displacement"];
    let lowest = imprint.iter().copied().fold(f64::INFINITY, f64::min);
    found.near("plastic_displacement.mean", number(told, "mean"), mean(&imprint), 1e-12 * largest(&imprint));
    found.near("plastic_displacement.min", number(told, "min"), lowest, 1e-12 * lowest.abs());
    let residual = &step["residual"];
    for key in ["yield", "flow", "flow_complementarity", "equilibrium", "complementarity", "penetration"] {
        let left = number(residual, key);
        found.must(left <= parts.tolerance, || format!("the residual {key} is {left:e}"));
    }
    let lost = number(step, "dissipated");
    found.must(lost >= 0.0, || format!("dissipated is {lost:e}"));
}
