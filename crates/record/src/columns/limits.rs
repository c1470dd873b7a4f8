//! Limits of numbers on infinitely fine grids, and their grid errors.

use std::borrow::Cow;

use gfmd_contact::Boundary;
use gfmd_measure::{GridLimit, GridLimits, NoLimit, Refined};
use gfmd_problem::{Facts, GridError, Support, Unknown};

use super::undefined::lost;
use super::{Column, measured::MEASURED};
use crate::column::{LIMIT, Origin};
use crate::when::{
    any, approach_given, conducts, flow, friction, gas, hardness, law, leak, load_given, loads, of_a_law, path,
    relaxing, sheared, statistics, steep, wears, yields,
};
use crate::{Cell, StateContext};

/// Returns true for one half-space, or for two, which deform as one with their contact modulus.
fn is_half_space(facts: &Facts) -> bool {
    facts.support == Support::HalfSpace && matches!(facts.second, None | Some(Support::HalfSpace))
}

/// Returns the reason why one solution does not give the grid error of a problem; `None` if it does.
pub fn not_calibrated(facts: &Facts) -> Option<&'static str> {
    macro_rules! with {
        ($what:literal) => {
            concat!(
                "the grid error is known from one solution for a hard wall on half-spaces, not with ",
                $what,
                " (--grid-error refine)"
            )
        };
    }
    let reasons = [
        (law(facts), with!("a law")),
        (hardness(facts), with!("a hardness")),
        (yields(facts), with!("a body that yields")),
        (friction(facts), with!("friction")),
        (facts.lateral, with!("a lateral motion")),
        (relaxing(facts), with!("a body that relaxes")),
        (wears(facts), with!("surfaces that wear")),
        (facts.unknown == Unknown::Held, with!("a surface held sideways")),
        (steep(facts), with!("finite slopes")),
        (facts.lower.is_some(), with!("a lower surface")),
        (facts.moved_base.is_some(), with!("a base that moves")),
        (facts.line, with!("a profile")),
        (!is_half_space(facts), with!("a body that is no half-space")),
    ];
    reasons.into_iter().find(|(is_so, _)| *is_so).map(|(_, reason)| reason)
}

/// Returns the reason why the grid error of a problem is unknown.
fn not_measured(facts: &Facts) -> Option<&'static str> {
    if facts.grid_error == GridError::Refine { None } else { not_calibrated(facts) }
}

/// Largest share of the mean square gradient in waves shorter than four points on a grid that resolves a surface.
pub const UNRESOLVED: f64 = 0.01;

/// Fewest waves of a surface with contact edges at random places on the grid. With fewer waves, as on textures and
/// single spheres, contact edges lie alike and their errors add up.
pub const FEWEST_WAVES: f64 = 8.0;

/// Columns that hardly depend on waves shorter than four points of a random surface.
const ROBUST: [&str; 5] = ["mean_gap", "elastic_energy", "stiffness", "conductance", "contact_conductance"];

/// Columns with a known error only where errors average out.
const AVERAGES: [&str; 5] = ["boundary_links", "flow_xx", "flow_yy", "leak_x", "leak_y"];

/// Columns of a patch that depend on the gap outside the contacts, or on a gradient by differences.
const LEVELS: [&str; 7] = ["approach", "mean_gap", "kappa", "flow_xx", "flow_yy", "leak_x", "leak_y"];

/// Columns of a patch with errors from its compliance between points, which differs from the compliance of waves.
const COMPLIANT: [&str; 4] = ["max_pressure", "pressure_deviation_in_contact", "pressure_moment_2", "elastic_energy"];

/// Columns that the singular pressure at the rim of a patch decides.
const SINGULAR: [&str; 3] = ["max_pressure", "pressure_deviation_in_contact", "pressure_moment_2"];

/// Largest ratio of the rms slopes along x and y.
const STEEPEST: f64 = 2.0;

/// Columns without a formula; their error comes from the difference of two grids.
const BY_DIFFERENCE: [&str; 6] =
    ["mean_pressure", "mean_shear_x", "mean_shear_y", "interface_energy", "dissipated", "gas_conductance"];

/// Columns whose value on one grid does not predict the value on another.
const OF_PATCHES: [&str; 2] = ["patches", "largest_patch_fraction"];

/// Columns over the points in contact, with a counted edge; two-grid differences are small by chance more often.
const OVER_CONTACT: [&str; 4] =
    ["mean_pressure_in_contact", "pressure_deviation_in_contact", "stiffness", "conductance"];

/// Columns of a profile whose differences between two grids are small by chance more often: it has few contact edges.
const OVER_PROFILE: [&str; 2] = ["area_fraction", "max_pressure"];

/// Columns that are proportional to the contact area, or to its inverse.
const BY_AREA: [&str; 3] = ["area_fraction", "mean_pressure_in_contact", "kappa"];

/// Least process zone, relative to the zone that resolves a law. In narrower zones, the contact edge catches on grid
/// points, and two grids agree by chance.
const LEAST_ZONE: f64 = 0.0625;

/// Largest ratio of the grid spacings along x and y.
const LONGEST_CELL: f64 = 1.1;

/// Returns the estimator of a column's limit for the contact on its grid, or the reason why the limit is unknown.
fn grid_limits<'a>(at: &'a StateContext, name: &str) -> Result<GridLimits<'a>, Cow<'static, str>> {
    let [dx, dy] = at.spacing;
    let is_alike = is_alike(at);
    if !is_resolved(at) && (is_alike || !ROBUST.contains(&name)) {
        return Err(format!(
            "waves shorter than four points have {:.0} % of the mean square gradient: what lies between the points \
             decides",
            100.0 * at.short_waves
        )
        .into());
    }
    if is_alike && (at.waves.is_nan() || AVERAGES.contains(&name)) {
        return Err(format!(
            "the surface has {:.1} waves; its error by the grid is known of random ones, whose edges lie anywhere on \
             the grid, with at least {FEWEST_WAVES}",
            at.waves
        )
        .into());
    }
    if at.facts.boundary == Boundary::Free {
        if LEVELS.contains(&name) {
            return Err("its error by the grid was not measured with free boundaries".into());
        } else if !is_alike && COMPLIANT.contains(&name) {
            return Err(
                "with free boundaries its error by the grid is known of contacts that are alike, as those of spheres"
                    .into(),
            );
        } else if at.reaches_rim() != Some(false) {
            return Err(
                "contacts reach the rim of the patch, where the pressure is singular and grids do not agree".into()
            );
        }
    }
    let [x, y] = at.slopes;
    let steeper = x.max(y) / x.min(y);
    if steeper.is_nan() || steeper > STEEPEST {
        return Err(format!(
            "the rms slopes along the axes are {x:.1e} and {y:.1e}; edges of contacts that lie along an axis cut the \
             grid alike, and the grid error is known of slopes that differ by a factor of at most {STEEPEST}"
        )
        .into());
    }
    if has_long_cells(at) {
        return Err("the grid error was measured with points as far apart along x as along y".into());
    }
    let limits = GridLimits::of(&at.summary, at.points, dx.max(dy), &at.scales);
    let limits = limits.map(|limits| if is_alike { limits.alike() } else { limits });
    let limits = limits.map(|limits| if at.facts.boundary == Boundary::Free { limits.on_patch() } else { limits });
    limits.map_err(|reason| reason.to_string().into())
}

/// Returns true for a surface with hardly any waves shorter than four points; false if they are unknown.
fn is_resolved(at: &StateContext) -> bool {
    at.short_waves <= UNRESOLVED
}

/// Returns true for a surface of few waves, with contact edges that lie alike on the grid.
fn is_alike(at: &StateContext) -> bool {
    at.waves.is_nan() || at.waves < FEWEST_WAVES
}

/// Returns true for a surface of few waves, or a shape, that is too sharp for its grid, such as a flat punch or a cone.
fn has_edges(at: &StateContext) -> bool {
    is_alike(at) && !is_resolved(at)
}

/// Returns true if the grid spacings along x and y differ.
fn has_long_cells(at: &StateContext) -> bool {
    let [dx, dy] = at.spacing;
    dx.max(dy) > LONGEST_CELL * dx.min(dy)
}

/// Returns true if only two grids tell the limit of a number, not the formulas of one grid: under a law, for profiles,
/// unequal grid spacings, a slab between two surfaces, shapes with edges, and for numbers of a patch that depend on its
/// gap, its rim, or its compliance.
fn needs_two_grids(at: &StateContext, name: &str) -> bool {
    let of_patch = || {
        // The flow through the gap of a patch was not compared with finer grids.
        !(name.starts_with("flow_") || name.starts_with("leak_"))
            && (LEVELS.contains(&name) || !is_alike(at) && COMPLIANT.contains(&name) || at.reaches_rim() != Some(false))
    };
    law(at.facts)
        || BY_DIFFERENCE.contains(&name)
        || at.facts.line
        || at.facts.lower.is_some()
        || has_long_cells(at)
        || has_edges(at) && !AVERAGES.contains(&name)
        || at.facts.boundary == Boundary::Free && of_patch()
}

/// Largest error of the counted width of one contact of a profile, divided by the spacing, in 95 % of the loads of a
/// cylinder: each end lies anywhere between two points, the two may err alike, and the count is a third of a spacing
/// too large on average.
const OF_ONE_CONTACT: f64 = 1.25;

/// Largest error of the counted area of a disc, in squares of the spacing, divided by the root of its boundary links on
/// a grid with twice the spacing, for 95 % of the radii; the centre is a point, as in shapes.
const OF_A_DISC: f64 = 1.55;

/// Returns the least error of the contact area on a grid with half the spacing, divided by the area: two grids may
/// count alike. The contacts of a profile, or of stripes along an axis, err independently of each other.
fn error_of_counting(at: &StateContext) -> f64 {
    let ([x, y], area) = (at.slopes, at.summary.area_fraction);
    let part = |axis: usize| 0.5 * at.spacing[axis] / at.lengths[axis];
    let links = at.summary.boundary_links as f64;
    let counted = match usize::from(!at.facts.line && y > x) {
        across if at.facts.line || x.max(y) > STEEPEST * x.min(y) => {
            OF_ONE_CONTACT * part(across) * (links * part(1 - across)).sqrt()
        }
        _ => OF_A_DISC * part(0) * part(1) * links.sqrt(),
    };
    if area > 0.0 { counted / area } else { 0.0 }
}

/// Returns a number of a column's limit on infinitely fine grids, or the reason why it is unknown.
fn limit(
    at: &StateContext,
    name: &str,
    found: fn(&GridLimits, &StateContext, f64) -> Result<GridLimit, NoLimit>,
    of: fn(&GridLimit, f64) -> f64,
) -> Cell {
    let column = MEASURED.iter().copied().flatten().find(|column| column.name == name);
    let value = column.map_or(f64::NAN, |column| column.cell(at.facts, at).number());
    if value.is_nan() {
        return Cell::undefined("the number itself has no value");
    }
    let own =
        grid_limits(at, name).and_then(|limits| found(&limits, at, value).map_err(|reason| reason.to_string().into()));
    let found = if at.finer.is_empty() { own } else { refined(at, name, value, own) };
    found.map(|found| of(&found, value)).into()
}

/// Returns the limit of a number from its record on a finer grid as well, or from two such records.
fn refined(
    at: &StateContext,
    name: &str,
    value: f64,
    own: Result<GridLimit, Cow<'static, str>>,
) -> Result<GridLimit, Cow<'static, str>> {
    if OF_PATCHES.contains(&name) {
        return Err(NoLimit::Patches.to_string().into());
    } else if let Some(zone) = at.process_zone.filter(|zone| !(LEAST_ZONE..).contains(zone)) {
        return Err(format!(
            "the process zone at the edge of a contact is {zone:.3} of the one that resolves this law; below \
             {LEAST_ZONE} the edge catches on the points of the grid, and two grids agree by chance"
        )
        .into());
    }
    // Boundary links are counted in steps of their own grid; the ends of the contacts of a profile have no length.
    let unit = if name == "boundary_links" && !at.facts.line { 0.5 } else { 1.0 };
    let limits = at.finer.iter().map(|finer| {
        let finer = finer.as_ref().map_err(|reason| Cow::from(reason.clone()))?;
        let number = |end: &str| match finer.record.get(&format!("{name}{end}")) {
            Some(Cell::Undefined(reason)) => Err(reason.clone()),
            cell => Ok(unit * cell.map_or(f64::NAN, Cell::number)),
        };
        let fine = number("")?;
        if fine.is_nan() {
            return Err("the number has no value on the finer grid".into());
        }
        let counting = if BY_AREA.contains(&name) { fine.abs() * error_of_counting(at) } else { 0.0 };
        if needs_two_grids(at, name) {
            if law(at.facts) && name == "boundary_links" {
                return Err(NoLimit::Counted.to_string().into());
            } else if SINGULAR.contains(&name) && at.facts.boundary == Boundary::Free && at.reaches_rim() != Some(false)
            {
                return Err("contacts reach the rim of the patch, where the pressure has no largest value".into());
            } else if SINGULAR.contains(&name) && has_edges(at) {
                return Err("the surface has edges, where the pressure may have no largest value".into());
            }
            // An approach counts from the top of the surface, above the highest points of both grids.
            let rises = if name == "approach" { at.rise.zip(finer.rise) } else { None };
            let [value, fine] = rises.map_or([value, fine], |(rise, other)| [value + rise, fine + other]);
            let found = GridLimit::of_two_grids(value, fine);
            // Two searches agree at best to their tolerance, and two losses to their own errors.
            let loss = if name == "dissipated" { lost(at, true).number() } else { 0.0 };
            let least = loss.max(at.tolerance.min(1e-6) * fine.abs()).max(counting);
            let is_counted = OVER_CONTACT.contains(&name)
                || at.facts.line && OVER_PROFILE.contains(&name)
                || has_edges(at) && BY_AREA.contains(&name);
            let wider = if is_counted || name == "kappa" { 1.6 } else { 1.0 };
            return Ok(GridLimit { half_width: (wider * found.half_width).max(least), ..found });
        }
        if name == "max_pressure" && hardness(at.facts) && (fine - value).abs() <= 1e-6 * value {
            return Ok(GridLimit { limit: value, half_width: 0.0 });
        }
        let (limit, half_width) = (number(LIMIT)?, number("_limit_error")?);
        let refined = Refined { value, own: own.as_ref().ok().copied(), fine, limit: GridLimit { limit, half_width } };
        let found = match () {
            () if name.starts_with("flow_") => refined.flow(),
            () if name.starts_with("leak_") => refined.by_difference(),
            () if not_calibrated(at.facts).is_none() && !at.facts.approach => refined.calibrated(),
            () => refined.by_difference(),
        };
        let least = if is_alike(at) { counting } else { 0.0 };
        Ok(GridLimit { half_width: found.half_width.max(least), ..found })
    });
    let limits: Vec<GridLimit> = limits.collect::<Result<_, Cow<'static, str>>>()?;
    Ok(GridLimit::between(&limits))
}

fn limit_value(found: &GridLimit, _: f64) -> f64 {
    found.limit
}

fn limit_error(found: &GridLimit, _: f64) -> f64 {
    found.half_width
}

fn grid_error(found: &GridLimit, value: f64) -> f64 {
    found.error_of(value)
}

/// Columns for the limit of a number on infinitely fine grids, the error of that limit, and the grid error of the
/// number. Arguments: name, place in JSON around the suffix, unit, problems that have the number, order of the limit's
/// error in the grid spacing (from its formula in [`GridLimits`]), limit.
macro_rules! limits {
    ($name:literal, $unit:literal, $order:expr, $limit:expr) => {
        limits!($name, [$name, ""], $unit, any, $order, $limit)
    };
    ($name:literal, $place:tt, $unit:literal, $present:expr, $order:expr, $limit:expr) => {
        limits!(
            $name,
            $place,
            $unit,
            $present,
            $order,
            $limit,
            concat!("estimate of ", $name, " on an infinitely fine grid under the same mean pressure")
        )
    };
    (
        $name:literal,
        [$json:literal, $place:literal],
        $unit:literal,
        $present:expr,
        $order:expr,
        $limit:expr,
        $meaning:expr
    ) => {
        [
            Column::new(concat!($name, "_limit"), $unit, &[(any, $meaning)], |at| {
                limit(at, $name, $limit, limit_value)
            })
            .at(concat!($json, "_limit", $place))
            .of_order($order)
            .with(|facts| $present(facts) && facts.grid_error != GridError::None)
            .unless(not_measured)
            .by(Origin::Grid),
            Column::new(
                concat!($name, "_limit_error"),
                $unit,
                &[(any, concat!("error bound (95 %) of ", $name, "_limit"))],
                |at| limit(at, $name, $limit, limit_error),
            )
            .at(concat!($json, "_limit_error", $place))
            .with(|facts| $present(facts) && facts.grid_error != GridError::None)
            .unless(not_measured)
            .by(Origin::Grid),
            Column::new(
                concat!($name, "_grid_error"),
                $unit,
                &[(any, concat!("grid error of ", $name, ": |", $name, " - limit| + limit_error"))],
                |at| limit(at, $name, $limit, grid_error),
            )
            .at(concat!($json, "_grid_error", $place))
            .with(|facts| $present(facts) && facts.grid_error != GridError::None)
            .unless(not_measured)
            .by(Origin::Grid),
        ]
    };
}

/// Returns the limit of a leak along an axis, which is proportional to the conductivity and to the cube of the mean
/// gap; their relative errors add up.
fn leaked(limits: &GridLimits, at: &StateContext, value: f64, axis: usize) -> Result<GridLimit, NoLimit> {
    let conductivity = at.measured.flow.map_or(f64::NAN, |flow| flow.conductivity[axis][axis]);
    let (flow, gap) = (limits.flow(conductivity)?, limits.mean_gap());
    let limit = value * flow.limit / conductivity * (gap.limit / at.summary.mean_gap).powi(3);
    Ok(GridLimit { limit, half_width: limit * (flow.half_width / flow.limit + 3.0 * gap.half_width / gap.limit) })
}

/// Refuses a limit from a single solution.
fn two_grids(_: &GridLimits, _: &StateContext, _: f64) -> Result<GridLimit, NoLimit> {
    Err(NoLimit::OneGrid)
}

/// Returns the limit of the mean pressure at a prescribed approach. The approach counts from the highest grid point;
/// the top of the surface lies higher.
fn pressure_of_approach(limits: &GridLimits, at: &StateContext, value: f64) -> Result<GridLimit, NoLimit> {
    let known = at.stiffness.as_ref().ok().map(|stiffness| stiffness.value).filter(|stiffness| stiffness.is_finite());
    let stiffness = known.ok_or(NoLimit::OneGrid)?;
    let GridLimit { limit, half_width } = limits.approach(0.0, at.rise.ok_or(NoLimit::OneGrid)?);
    Ok(GridLimit { limit: value - stiffness * limit, half_width: stiffness * half_width })
}

/// Limits of contact numbers on infinitely fine grids.
pub(super) const LIMITS: &[[Column; 3]] = &[
    limits!(
        "mean_pressure",
        ["mean_pressure", ""],
        "stress",
        approach_given,
        None,
        pressure_of_approach,
        "estimate of mean_pressure on an infinitely fine grid at the same approach"
    ),
    limits!("mean_shear_x", ["mean_shear", ".0"], "stress", sheared, None, two_grids),
    limits!("mean_shear_y", ["mean_shear", ".1"], "stress", sheared, None, two_grids),
    limits!("approach", ["approach", ""], "length", load_given, Some(2.7), |limits, at, value| {
        at.rise.map(|rise| limits.approach(value, rise)).ok_or(NoLimit::OneGrid)
    }),
    limits!("area_fraction", "1", Some(1.6), |limits, _, _| Ok(limits.area_fraction())),
    limits!("kappa", ["kappa", ""], "1", loads, Some(1.6), |limits, _, _| Ok(limits.kappa())),
    limits!(
        "boundary_links",
        ["boundary_links", ""],
        "1",
        loads,
        Some(1.0),
        |limits, _, _| Ok(limits.boundary_links()),
        "estimate of the boundary length on an infinitely fine grid, in steps of this grid"
    ),
    limits!("mean_gap", "length", Some(2.7), |limits, _, _| Ok(limits.mean_gap())),
    limits!("max_pressure", ["max_pressure", ""], "stress", loads, Some(3.0), |limits, at, _| {
        at.peak().map(|peak| limits.max_pressure(&peak)).ok_or(NoLimit::OneGrid)
    }),
    limits!(
        "mean_pressure_in_contact",
        ["mean_pressure_in_contact", ""],
        "stress",
        loads,
        Some(1.6),
        |limits, _, _| Ok(limits.mean_pressure_in_contact())
    ),
    limits!(
        "pressure_deviation_in_contact",
        ["pressure_deviation_in_contact", ""],
        "stress",
        loads,
        Some(1.6),
        |limits, _, _| Ok(limits.pressure_deviation_in_contact())
    ),
    limits!("pressure_moment_2", ["pressure_moment_2", ""], "stress^2", loads, Some(2.3), |limits, _, _| Ok(
        limits.pressure_moment_2()
    )),
    limits!("elastic_energy", "stress*length", Some(2.8), |limits, _, _| Ok(limits.elastic_energy())),
    limits!("interface_energy", ["interface_energy", ""], "stress*length", of_a_law, None, two_grids),
    limits!("dissipated", ["dissipated", ""], "stress*length", path, None, two_grids),
    limits!("stiffness", ["stiffness", ""], "stress/length", any, Some(1.4), |limits, _, value| Ok(
        limits.stiffness(value)
    )),
    limits!("patches", ["patches.count", ""], "1", statistics, None, |_, _, _| Err(NoLimit::Patches)),
    limits!("largest_patch_fraction", ["patches.largest_fraction", ""], "1", statistics, None, |_, _, _| {
        Err(NoLimit::Patches)
    }),
    limits!("conductance", ["conductance", ""], "1/length", statistics, Some(1.4), |limits, at, value| {
        if at.measured.electrodes { Err(NoLimit::Electrodes) } else { Ok(limits.stiffness(value)) }
    }),
    limits!(
        "contact_conductance",
        ["contact_conductance", ""],
        "stress*length/time/temperature",
        conducts,
        Some(1.4),
        |limits, at, value| if at.measured.electrodes { Err(NoLimit::Electrodes) } else { Ok(limits.stiffness(value)) }
    ),
    limits!("gas_conductance", ["gas_conductance", ""], "stress*length/time/temperature", gas, None, two_grids),
    limits!("flow_xx", ["flow.conductivity", ".0.0"], "1", flow, Some(1.3), |limits, _, value| limits.flow(value)),
    limits!("flow_yy", ["flow.conductivity", ".1.1"], "1", flow, Some(1.3), |limits, _, value| limits.flow(value)),
    limits!("leak_x", ["leak", ".0"], "length^3/time", leak, Some(1.3), |limits, at, value| leaked(
        limits, at, value, 0
    )),
    limits!("leak_y", ["leak", ".1"], "length^3/time", leak, Some(1.3), |limits, at, value| leaked(
        limits, at, value, 1
    )),
];
