//! All columns, each once.

use std::borrow::Cow;

use gfmd_contact::{Boundary, Fields as _};
use gfmd_interface::Loss;
use gfmd_measure::{GridLimit, GridLimits, NoLimit, Refined};
use gfmd_problem::{Facts, GridError, Support, Task, Unknown};

use crate::column::{Column, Form, LIMIT, Origin, Table};
use crate::{At, Cell};

fn any(_: &Facts) -> bool {
    true
}

fn loads(facts: &Facts) -> bool {
    facts.task == Task::Loads
}

fn path(facts: &Facts) -> bool {
    facts.task == Task::Path
}

/// True if the approach is that of each step of a path.
fn prescribed(facts: &Facts) -> bool {
    path(facts) && facts.approach
}

/// True if a shear may act along a path.
fn sheared(facts: &Facts) -> bool {
    path(facts) && (facts.lateral || friction(facts))
}

fn law(facts: &Facts) -> bool {
    facts.has_law()
}

fn between(facts: &Facts) -> bool {
    facts.lower.is_some()
}

fn steep(facts: &Facts) -> bool {
    facts.finite_slope
}

fn hardness(facts: &Facts) -> bool {
    facts.hardness
}

fn relaxing(facts: &Facts) -> bool {
    facts.relaxes.is_some()
}

fn wears(facts: &Facts) -> bool {
    facts.wears
}

fn friction(facts: &Facts) -> bool {
    facts.friction.is_some()
}

fn free(facts: &Facts) -> bool {
    loads(facts) && facts.boundary == Boundary::Free
}

fn statistics(facts: &Facts) -> bool {
    facts.statistics
}

fn flow(facts: &Facts) -> bool {
    facts.flow
}

/// True if the states are those of a law: on a path, of a periodic hard wall, too.
fn of_a_law(facts: &Facts) -> bool {
    if path(facts) { !friction(facts) && !facts.is_wall_on_path() } else { law(facts) }
}

/// True if the path is that of a hard wall by the methods of one.
fn wall_on_path(facts: &Facts) -> bool {
    facts.is_wall_on_path()
}

/// The reason why the numbers that depend on the level of the displacement have no value.
fn level(facts: &Facts) -> Option<&'static str> {
    (!facts.has_level()).then_some(NO_LEVEL)
}

const NO_LEVEL: &str = "a profile with free boundaries on a half-space is displaced by a logarithm of the distance: its \
                        displacement is known up to a constant, as are the approach, the elastic energy and the stiffness";

fn without_law(facts: &Facts) -> Option<&'static str> {
    (!of_a_law(facts)).then_some("no law acts across the gap")
}

/// The ratio of area to load, or the reason why there is none.
fn ratio(at: &At, value: f64) -> Cell {
    if value.is_nan() && law(at.facts) {
        return Cell::undefined("attraction carries the load, to which the area has no ratio");
    }
    reduced(at, value)
}

/// A number in the unit of reduced pressures, or the reason why there is none.
fn reduced(at: &At, value: f64) -> Cell {
    if at.scales.rms_gradient == 0.0 {
        return Cell::undefined("the surface is flat: its rms gradient, by which a load is reduced, is zero");
    }
    value.into()
}

/// The stiffness, or its error, or the reason why there is none.
fn stiff(at: &At, of: fn(&gfmd_contact::Stiffness) -> f64) -> Cell {
    match &at.stiffness {
        Ok(found) if found.value.is_finite() => of(found).into(),
        // The only contact without a level that gives a stiffness.
        Ok(found) if found.value.is_nan() => Cell::undefined(NO_LEVEL),
        Ok(_) => Cell::undefined(
            "infinite: in full contact the surface moves as a whole, and the mean level of this body is fixed",
        ),
        Err(reason) => Cell::undefined(reason.clone()),
    }
}

fn flag(flags: Option<[bool; 2]>, axis: usize) -> Cell {
    flags.map_or(Cell::Real(f64::NAN), |flags| flags[axis].into())
}

/// The conductivity along `row` by a gradient along `column`.
fn conductivity(at: &At, [row, column]: [usize; 2]) -> Cell {
    let gap = at.summary.mean_gap;
    match at.measured.flow {
        Some(_) if gap == 0.0 => Cell::undefined(
            "the gap is closed everywhere; a conductivity is relative to a uniform gap of the mean height",
        ),
        Some(_) if gap < 0.0 => Cell::undefined(format!(
            "the mean gap is {gap:.3e}, since the surfaces overlap; a conductivity is relative to a uniform gap of that height"
        )),
        Some(flow) => flow.conductivity[row][column].into(),
        None => f64::NAN.into(),
    }
}

/// The reason why the error of the grid is not known from one solution of a problem; `None` if it is.
pub fn not_calibrated(facts: &Facts) -> Option<&'static str> {
    macro_rules! with {
        ($what:literal) => {
            concat!(
                "the error of the grid is known from one solution for a hard wall on half-spaces, not with ",
                $what,
                " (--grid-error refine)"
            )
        };
    }
    let reasons = [
        (law(facts), with!("a law")),
        (hardness(facts), with!("a hardness")),
        (friction(facts), with!("friction")),
        (facts.lateral, with!("a lateral motion")),
        (relaxing(facts), with!("a body that relaxes")),
        (wears(facts), with!("surfaces that wear")),
        (facts.unknown != Unknown::Normal, with!("further unknown components")),
        (steep(facts), "the error of the grid was not measured with finite slopes"),
        (facts.lower.is_some(), "the error of the grid was not measured with a lower surface"),
        (facts.moved_base.is_some(), "the error of the grid was not measured with a base that moves"),
        (facts.line, "the error of the grid was not measured of a profile"),
        (facts.support != Support::HalfSpace || facts.second.is_some(), with!("a body that is no half-space")),
    ];
    reasons.into_iter().find(|(is_so, _)| *is_so).map(|(_, reason)| reason)
}

/// The reason why the error of the grid is not known in a problem.
fn not_measured(facts: &Facts) -> Option<&'static str> {
    if facts.grid_error == GridError::Refine { None } else { not_calibrated(facts) }
}

/// The share of the mean square gradient in waves shorter than four points up to which the grid resolves a surface.
pub const UNRESOLVED: f64 = 0.01;

/// The least number of waves of a surface whose contacts have their edges anywhere on the grid. Of fewer, as of textures and single
/// spheres, edges of contacts lie alike, and their errors add up.
pub const FEWEST_WAVES: f64 = 8.0;

/// The numbers that hardly depend on waves shorter than four points.
const ROBUST: [&str; 4] = ["mean_gap", "elastic_energy", "stiffness", "conductance"];

/// The numbers whose errors are known only where they average out.
const AVERAGES: [&str; 3] = ["boundary_links", "flow_xx", "flow_yy"];

/// The numbers of a patch that depend on the gap outside of the contacts, or on a gradient by differences.
const LEVELS: [&str; 5] = ["displacement", "mean_gap", "kappa", "flow_xx", "flow_yy"];

/// The numbers of a patch whose errors are those of its compliance between points, which is not that of waves.
const COMPLIANT: [&str; 4] = ["max_pressure", "pressure_deviation_in_contact", "pressure_moment_2", "elastic_energy"];

/// The largest ratio of the rms slopes along x and y.
const STEEPEST: f64 = 2.0;

/// The numbers that no formula has, and whose error the difference of two grids tells.
const BY_DIFFERENCE: [&str; 5] = ["mean_pressure", "mean_shear_x", "mean_shear_y", "interface_energy", "dissipated"];

/// Numbers of which no grid tells that of another one.
const OF_PATCHES: [&str; 2] = ["patches", "largest_patch_fraction"];

/// Numbers over the points in contact, whose edge is counted: differences of two grids are small by chance more often.
const OVER_CONTACT: [&str; 4] =
    ["mean_pressure_in_contact", "pressure_deviation_in_contact", "stiffness", "conductance"];

/// The least process zone over the one that resolves a law: in narrower ones the edge of a contact catches on the points of the grid,
/// and two grids agree by chance.
const LEAST_ZONE: f64 = 0.0625;

/// The largest ratio of the distances between points along x and y.
const LONGEST_CELL: f64 = 1.1;

/// The contact on its grid, from which the limit of this number is estimated, or the reason why it is not known.
fn grid_limits<'a>(at: &'a At, name: &str) -> Result<GridLimits<'a>, Cow<'static, str>> {
    let [dx, dy] = at.spacing;
    let known = at.short_waves <= UNRESOLVED || ROBUST.contains(&name);
    if !known {
        return Err(format!(
            "waves shorter than four points have {:.0} % of the mean square gradient: what lies between the points decides",
            100.0 * at.short_waves
        )
        .into());
    }
    let is_alike = at.waves.is_nan() || at.waves < FEWEST_WAVES;
    if is_alike && (at.waves.is_nan() || AVERAGES.contains(&name)) {
        return Err(format!(
            "the surface has {:.1} waves; its error by the grid is known of random ones, whose edges lie anywhere on the grid, with \
             at least {FEWEST_WAVES}",
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
            "the rms slopes along the axes are {x:.1e} and {y:.1e}; edges of contacts that lie along an axis cut the grid alike, and \
             the error of the grid is known of slopes that differ by a factor of at most {STEEPEST}"
        )
        .into());
    }
    if dx.max(dy) > LONGEST_CELL * dx.min(dy) {
        return Err("the error of the grid was measured with points as far apart along x as along y".into());
    }
    let limits = GridLimits::of(&at.summary, at.points, dx.max(dy), &at.scales);
    let limits = limits.map(|limits| if is_alike { limits.alike() } else { limits });
    let limits = limits.map(|limits| if at.facts.boundary == Boundary::Free { limits.on_patch() } else { limits });
    limits.map_err(|reason| reason.to_string().into())
}

/// A number of the limit of a column on infinitely fine grids, or the reason why it is not known.
fn limit(
    at: &At,
    name: &str,
    found: fn(&GridLimits, &At, f64) -> Result<GridLimit, NoLimit>,
    of: fn(&GridLimit, f64) -> f64,
) -> Cell {
    let column = MEASURED.iter().find(|column| column.name == name);
    let value = column.map_or(f64::NAN, |column| column.cell(at).number());
    if value.is_nan() {
        return Cell::undefined("the number itself has no value");
    }
    let own =
        grid_limits(at, name).and_then(|limits| found(&limits, at, value).map_err(|reason| reason.to_string().into()));
    let found = if at.finer.is_empty() { own } else { refined(at, name, value, own) };
    found.map(|found| of(&found, value)).into()
}

/// The limit of a number from its record on a finer grid, too, or from two such records.
fn refined(
    at: &At,
    name: &str,
    value: f64,
    own: Result<GridLimit, Cow<'static, str>>,
) -> Result<GridLimit, Cow<'static, str>> {
    if OF_PATCHES.contains(&name) {
        return Err(NoLimit::Patches.to_string().into());
    } else if let Some(zone) = at.process_zone.filter(|zone| !(LEAST_ZONE..).contains(zone)) {
        return Err(format!(
            "the process zone at the edge of a contact is {zone:.3} of the one that resolves this law; below {LEAST_ZONE} the edge \
             catches on the points of the grid, and two grids agree by chance"
        )
        .into());
    }
    // Boundary links are counted in steps of their grid.
    let unit = if name == "boundary_links" { 0.5 } else { 1.0 };
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
        if law(at.facts) && name == "boundary_links" {
            return Err(NoLimit::Counted.to_string().into());
        } else if law(at.facts) || BY_DIFFERENCE.contains(&name) {
            // An approach counts from the top of the surface, above the highest points of both grids.
            let rises = if name == "displacement" { at.rise.zip(finer.rise) } else { None };
            let [value, fine] = rises.map_or([value, fine], |(rise, other)| [value + rise, fine + other]);
            let found = GridLimit::of_two_grids(value, fine);
            // Two searches agree to their tolerance at best, and two losses to their own errors.
            let loss = if name == "dissipated" { lost(at, true).number() } else { 0.0 };
            let least = loss.max(at.tolerance.min(1e-6) * fine.abs());
            let wider = if OVER_CONTACT.contains(&name) { 1.6 } else { 1.0 };
            return Ok(GridLimit { half_width: (wider * found.half_width).max(least), ..found });
        }
        if name == "max_pressure" && hardness(at.facts) && (fine - value).abs() <= 1e-6 * value {
            return Ok(GridLimit { limit: value, half_width: 0.0 });
        }
        let (limit, half_width) = (number(LIMIT)?, number("_limit_error")?);
        let refined = Refined { value, own: own.as_ref().ok().copied(), fine, limit: GridLimit { limit, half_width } };
        Ok(match () {
            () if name.starts_with("flow_") => refined.flow(),
            () if not_calibrated(at.facts).is_none() && !prescribed(at.facts) => refined.calibrated(),
            () => refined.by_difference(),
        })
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

/// The limit of a number on infinitely fine grids, its error, and the error of the number by the grid: the name, the place in JSON
/// around the suffix, the unit, the problems that have the number, the order of the error of the limit in the distance of the points
/// (that of its formula in [`GridLimits`]), the limit.
macro_rules! limits {
    ($name:literal, $unit:literal, $order:expr, $limit:expr) => {
        limits!($name, [$name, ""], $unit, any, $order, $limit)
    };
    ($name:literal, [$json:literal, $place:literal], $unit:literal, $present:expr, $order:expr, $limit:expr) => {
        [
            Column::new(
                concat!($name, "_limit"),
                $unit,
                &[(
                    any,
                    concat!(
                        "estimate of ",
                        $name,
                        " on an infinitely fine grid under the same load, or at the same approach"
                    ),
                )],
                |at| limit(at, $name, $limit, limit_value),
            )
            .at(concat!($json, "_limit", $place))
            .of_order($order)
            .with(|facts| $present(facts) && facts.grid_error != GridError::None),
            Column::new(
                concat!($name, "_limit_error"),
                $unit,
                &[(any, concat!("95 % of the errors of ", $name, "_limit are smaller"))],
                |at| limit(at, $name, $limit, limit_error),
            )
            .at(concat!($json, "_limit_error", $place))
            .with(|facts| $present(facts) && facts.grid_error != GridError::None),
            Column::new(
                concat!($name, "_grid_error"),
                $unit,
                &[(any, concat!("error of ", $name, " by the finite grid: |", $name, " - limit| + limit_error"))],
                |at| limit(at, $name, $limit, grid_error),
            )
            .at(concat!($json, "_grid_error", $place))
            .with(|facts| $present(facts) && facts.grid_error != GridError::None),
        ]
    };
}

/// The plastic points, and the plastic depth in the mean.
fn plastic(at: &At) -> Option<(f64, f64)> {
    let rest = at.rest?;
    match rest.on_path() {
        Some(state) => state.solution.plastic.as_ref().map(|_| (state.fraction, state.volume)),
        None => rest.plastic().map(|plastic| (plastic.fraction, plastic.volume)),
    }
}

/// The shear in the mean: along a path the traction on the body, with finite slopes that which holds the rigid surface.
fn shear(at: &At, axis: usize) -> Cell {
    let steep = at.rest.and_then(|rest| rest.steep()).map(|state| state.mean_shear);
    at.step.as_ref().map(|(_, reading)| reading.mean_shear).or(steep).map_or(f64::NAN, |shear| shear[axis]).into()
}

fn sideways(at: &At, axis: usize) -> Cell {
    at.step.as_ref().map_or(f64::NAN, |(_, reading)| reading.lateral[axis]).into()
}

/// The energy that a step loses, or its error, or the reason why it is not known.
fn lost(at: &At, error: bool) -> Cell {
    let Some((step, reading)) = &at.step else { return f64::NAN.into() };
    let found = if error { step.dissipated_error } else { step.dissipated };
    if let Some(found) = found {
        return found.into();
    }
    Cell::undefined(match reading.loss {
        Loss::Unknown => "the tractions have no energy",
        _ if step.dissipated.is_none() => "the step did not reach a state at rest",
        _ if step.change.is_some_and(f64::is_nan) => "--energy-solves did not suffice to halve the increment",
        _ => "the loss does not depend on the division of the step",
    })
}

/// A jump of a step, or the reason why it is not known.
fn jumped(at: &At) -> Cell {
    let Some((step, reading)) = &at.step else {
        return at.rest.and_then(|rest| rest.law()).map_or(Cell::Real(f64::NAN), |law| law.passed_instability.into());
    };
    let unknown = match reading.loss {
        Loss::Balance(_) => "--energy-solves did not suffice to tell a jump from a smooth change",
        Loss::Certified { .. } => "energy is lost by relaxation, which no balance tells from jumps",
        Loss::Known(_) => "energy is lost by slip or plastic flow, which no balance tells from jumps",
        Loss::Unknown => "the tractions have no energy, whose loss would tell a jump",
    };
    step.jumped.ok_or(unknown).into()
}

/// The scale of stress of a residual under a law.
macro_rules! per_stress {
    ($what:literal) => {
        concat!($what, " / the stress scale (the largest traction, or the softest stiffness times h_rms if more)")
    };
}

/// A column of the lower face of a slab between two surfaces.
macro_rules! lower {
    ($name:literal, $unit:literal, $meaning:literal, |$face:ident, $summary:ident| $value:expr) => {
        Column::new(concat!("lower_", $name), $unit, &[(any, $meaning)], |at| {
            at.rest.and_then(|rest| rest.lower()).map_or(Cell::Real(f64::NAN), |$face| {
                let $summary = $face.summary();
                let _ = &$summary;
                Cell::from($value)
            })
        })
        .at(concat!("lower.", $name))
        .with(between)
    };
}

/// A residual of the lower face.
macro_rules! lower_residual {
    ($name:ident, $meaning:literal) => {
        Column::new(concat!("lower_residual_", stringify!($name)), "1", &[(any, $meaning)], |at| {
            at.rest.and_then(|rest| rest.lower()).map_or(f64::NAN, |face| face.residual.$name).into()
        })
        .at(concat!("lower.residual.", stringify!($name)))
        .with(between)
        .by(Origin::Residual)
    };
}

/// A residual by the name of the state.
macro_rules! residual {
    ($name:literal, $meanings:expr) => {
        Column::new(concat!("residual_", $name), "1", $meanings, |at| at.residual($name).into())
            .at(concat!("residual.", $name))
            .in_file(loads)
            .by(Origin::Residual)
    };
}

/// All columns, in the order in which they are printed.
pub const COLUMNS: &[Column] = &ALL;

static ALL: [Column; MEASURED.len() + 3 * LIMITS.len()] = {
    let mut all = [MEASURED[0]; MEASURED.len() + 3 * LIMITS.len()];
    let mut index = 0;
    while index < all.len() {
        all[index] = match index.checked_sub(MEASURED.len()) {
            None => MEASURED[index],
            Some(limit) => LIMITS[limit / 3][limit % 3].by(Origin::Grid).unless(not_measured),
        };
        index += 1;
    }
    all
};

/// The limit of a number that one solution does not tell.
fn two_grids(_: &GridLimits, _: &At, _: f64) -> Result<GridLimit, NoLimit> {
    Err(NoLimit::OneGrid)
}

/// The limits on infinitely fine grids of numbers of a contact.
const LIMITS: &[[Column; 3]] =
    &[
        limits!("mean_pressure", ["mean_pressure", ""], "stress", prescribed, None, two_grids),
        limits!("mean_shear_x", ["mean_shear", ".0"], "stress", sheared, None, two_grids),
        limits!("mean_shear_y", ["mean_shear", ".1"], "stress", sheared, None, two_grids),
        limits!("displacement", "length", Some(2.7), |limits, at, value| {
            at.rise.map(|rise| limits.approach(value, rise)).ok_or(NoLimit::Shared)
        }),
        limits!("area_fraction", "1", Some(1.6), |limits, _, _| Ok(limits.area_fraction())),
        limits!("kappa", ["kappa", ""], "1", loads, Some(1.6), |limits, _, _| Ok(limits.kappa())),
        limits!("boundary_links", ["boundary_links", ""], "1", loads, Some(1.0), |limits, _, _| Ok(
            limits.boundary_links()
        )),
        limits!("mean_gap", "length", Some(2.7), |limits, _, _| Ok(limits.mean_gap())),
        limits!("max_pressure", ["max_pressure", ""], "stress", loads, Some(3.0), |limits, at, _| {
            at.peak().map(|peak| limits.max_pressure(&peak)).ok_or(NoLimit::Shared)
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
        limits!("stiffness", ["stiffness", ""], "stress/length", loads, Some(1.4), |limits, _, value| Ok(
            limits.stiffness(value)
        )),
        limits!("patches", ["patches.count", ""], "1", statistics, None, |_, _, _| Err(NoLimit::Patches)),
        limits!("largest_patch_fraction", ["patches.largest_fraction", ""], "1", statistics, None, |_, _, _| {
            Err(NoLimit::Patches)
        }),
        limits!("conductance", ["conductance", ""], "1/length", statistics, Some(1.4), |limits, at, value| {
            if at.measured.electrodes { Err(NoLimit::Electrodes) } else { Ok(limits.stiffness(value)) }
        }),
        limits!("flow_xx", ["flow.conductivity", ".0.0"], "1", flow, Some(1.3), |limits, _, value| limits.flow(value)),
        limits!("flow_yy", ["flow.conductivity", ".1.1"], "1", flow, Some(1.3), |limits, _, value| limits.flow(value)),
    ];

/// The columns that are measured.
const MEASURED: &[Column] = &[
    Column::new(
        "mean_pressure",
        "stress",
        &[
            (path, "mean pressure over the whole surface; negative if it is pulled"),
            (any, "mean pressure over the whole surface"),
        ],
        |at| at.summary.mean_pressure.into(),
    )
    .head("pressure", Form::Size),
    Column::new("p_star", "1", &[(any, "reduced pressure p/(E* g)")], |at| reduced(at, at.summary.p_star))
    .head("p*", Form::Size),
    Column::new(
        "displacement",
        "length",
        &[
            (
                between,
                "approach of the two rigid surfaces beyond the distance at which both touch the undeformed slab",
            ),
            (any, "rigid approach beyond first touch"),
        ],
        |at| at.approach.into(),
    )
    .unless(level)
    .head("approach", Form::Size),
    Column::new("time", "time", &[(any, "time since first touch, in the unit of the relaxation times")], |at| {
        at.step.as_ref().map_or(f64::NAN, |(_, reading)| reading.time).into()
    })
    .with(relaxing)
    .head("time", Form::Size),
    Column::new("distance", "length", &[(any, "sliding distance since first touch")], |at| {
        at.step.as_ref().map_or(f64::NAN, |(_, reading)| reading.distance).into()
    })
    .with(wears)
    .head("distance", Form::Size),
    Column::new("lateral_x", "length", &[(any, "lateral displacement of the rigid surface along x")], |at| {
        sideways(at, 0)
    })
    .at("lateral.0")
    .with(path)
    .head("lateral x", Form::SizeUnlessZero),
    Column::new("lateral_y", "length", &[(any, "lateral displacement of the rigid surface along y")], |at| {
        sideways(at, 1)
    })
    .at("lateral.1")
    .with(path)
    .head("lateral y", Form::SizeUnlessZero),
    Column::new(
        "mean_shear_x",
        "stress",
        &[
            (path, "mean shear traction on the elastic surface along x"),
            (any, "mean traction along x that holds the rigid surface in its place"),
        ],
        |at| shear(at, 0),
    )
    .at("mean_shear.0")
    .with(|facts| path(facts) || steep(facts))
    .head("shear x", Form::SizeUnlessZero),
    Column::new(
        "mean_shear_y",
        "stress",
        &[(path, "mean shear traction on the elastic surface along y"), (any, "the same along y")],
        |at| shear(at, 1),
    )
    .at("mean_shear.1")
    .with(|facts| path(facts) || steep(facts))
    .head("shear y", Form::SizeUnlessZero),
    Column::new(
        "area_fraction",
        "1",
        &[
            (path, "points that are repelled over all points"),
            (law, "contact area fraction, points that are repelled over all points"),
            (any, "contact area fraction, points in contact over all points"),
        ],
        // Along a path, where no point touches the wall, rounding errors of the traction would count in the summary.
        |at| match at.rest.and_then(|rest| rest.law()).filter(|_| path(at.facts)) {
            Some(law) => law.contact_fraction.into(),
            None => at.summary.area_fraction.into(),
        },
    )
    .head("area", Form::Share),
    Column::new(
        "stick_fraction",
        "1",
        &[(any, "points in contact whose shear is below its limit, over all points; NaN without friction")],
        |at| at.rest.and_then(|rest| rest.friction()).map_or(f64::NAN, |state| state.stick_fraction).into(),
    )
    .with(path)
    .unless(|facts| (!friction(facts)).then_some("without friction nothing sticks"))
    .head("stick", Form::Share),
    Column::new(
        "area_fraction_corrected",
        "1",
        &[(any, "contact area fraction less the excess of the pixels along the perimeter (Yastrebov et al. 2017)")],
        |at| at.summary.area_fraction_corrected.into(),
    )
    .with(loads),
    Column::new(
        "kappa",
        "1",
        &[(law, "area_fraction / p_star; NaN if attraction carries the load"), (any, "area_fraction / p_star")],
        |at| ratio(at, at.summary.kappa),
    )
    .with(loads)
    .head("kappa", Form::Ratio),
    Column::new(
        "kappa_corrected",
        "1",
        &[
            (law, "area_fraction_corrected / p_star; NaN if attraction carries the load"),
            (any, "area_fraction_corrected / p_star"),
        ],
        |at| ratio(at, at.summary.kappa_corrected),
    )
    .with(loads),
    Column::new(
        "contact_nodes",
        "1",
        &[(law, "number of points that are repelled"), (any, "number of points in contact")],
        |at| at.summary.contact_nodes.into(),
    )
    .count()
    .with(loads),
    Column::new(
        "boundary_links",
        "1",
        &[
            (law, "neighbouring pairs with one point repelled and one not"),
            (any, "neighbouring pairs with one point in contact and one not"),
        ],
        |at| at.summary.boundary_links.into(),
    )
    .count()
    .with(loads),
    Column::new("mean_gap", "length", &[(any, "mean distance between the surfaces")], |at| at.summary.mean_gap.into())
    .head("mean gap", Form::Size),
    Column::new(
        "max_pressure",
        "stress",
        &[(law, "largest repulsive pressure"), (any, "largest pressure")],
        |at| at.summary.max_pressure.into(),
    )
    .with(|facts| loads(facts) || relaxing(facts) || wears(facts))
    .head("peak p", Form::Size),
    Column::new(
        "wear_volume",
        "length",
        &[(any, "mean over the whole surface of the depth lost so far, the volume over the area")],
        |at| at.rest.and_then(|rest| rest.worn()).map_or(f64::NAN, |state| state.volume).into(),
    )
    .with(wears)
    .head("wear", Form::Size),
    Column::new("max_wear", "length", &[(any, "largest depth lost so far")], |at| {
        at.rest.and_then(|rest| rest.worn()).map_or(f64::NAN, |state| state.deepest).into()
    })
    .with(wears)
    .head("deepest", Form::Size),
    Column::new(
        "mean_pressure_in_contact",
        "stress",
        &[
            (law, "mean repulsive pressure over the points that are repelled"),
            (any, "mean pressure over the points in contact"),
        ],
        |at| at.summary.mean_pressure_in_contact.into(),
    )
    .with(loads),
    Column::new(
        "pressure_deviation_in_contact",
        "stress",
        &[
            (law, "standard deviation of the repulsive pressure over the points that are repelled"),
            (any, "standard deviation of the pressure over the points in contact"),
        ],
        |at| at.summary.pressure_deviation_in_contact.into(),
    )
    .with(loads),
    Column::new(
        "pressure_moment_2",
        "stress^2",
        &[
            (law, "mean square repulsive pressure over the whole surface"),
            (any, "mean square pressure over the whole surface"),
        ],
        |at| at.summary.pressure_moment_2.into(),
    )
    .with(loads),
    Column::new(
        "elastic_energy",
        "stress*length",
        &[
            (between, "elastic energy of the slab per area, by the pressures on both faces"),
            (relaxing, "energy stored in the springs of all branches, per area of the surface"),
            (any, "elastic energy per area of the surface"),
        ],
        |at| at.summary.elastic_energy.into(),
    )
    .unless(level)
    .on(Table::Energy, "elastic", Form::Size),
    Column::new(
        "interface_energy",
        "stress*length",
        &[
            (path, "energy of the law per area of the surface; NaN if it has none"),
            (any, "energy of the contact law per area of the surface"),
        ],
        |at| match at.rest.and_then(|rest| rest.law()).map(|law| law.interface_energy) {
            Some(energy) if energy.is_nan() => Cell::undefined("the tractions have no energy"),
            energy => energy.unwrap_or(f64::NAN).into(),
        },
    )
    .with(|facts| path(facts) || law(facts))
    .unless(without_law)
    .on(Table::Energy, "interface", Form::Size),
    Column::new(
        "dissipated",
        "stress*length",
        &[
            (relaxing, "energy lost in the dashpots in this step, per area"),
            (wears, "work of the pressure on the depth lost in this step, per area, without the work of friction"),
            (any, "energy lost in this step, per area; NaN if the law has no energy"),
        ],
        |at| lost(at, false),
    )
    .with(path)
    .by(Origin::Way)
    .on(Table::Energy, "dissipated", Form::Size),
    Column::new(
        "dissipated_error",
        "stress*length",
        &[
            (
                |facts| relaxing(facts) || wears(facts),
                "work of the rigid surface by the trapezoidal rule less the energies gained and lost, in magnitude",
            ),
            (
                any,
                "estimated error of dissipated; NaN if dissipated does not depend on the division of the step, or is unknown",
            ),
        ],
        |at| lost(at, true),
    )
    .with(path)
    .by(Origin::Way)
    .on(Table::Energy, "+-", Form::Rough),
    Column::new(
        "passed_instability",
        "1",
        &[
            (path, "1 if more energy was lost in a jump of this step than its error; NaN if no energy tells"),
            (any, "1 if directions of negative curvature were met on the way from the last load"),
        ],
        jumped,
    )
    .flag()
    .with(|facts| path(facts) || law(facts))
    .by(Origin::Way),
    Column::new(
        "lowest_curvature",
        "1",
        &[(any, "lowest curvature met in the last search for a step, over the elastic curvature")],
        |at| match at.rest.and_then(|rest| rest.law()).map(|law| law.lowest_curvature) {
            Some(curvature) if curvature.is_finite() => curvature.into(),
            _ => Cell::undefined(
                "no curvature was computed: by dynamics, or where the search ended before its first step",
            ),
        },
    )
    .with(|facts| path(facts) || law(facts))
    .unless(without_law)
    .by(Origin::Way),
    Column::new(
        "stiffness",
        "stress/length",
        &[(
            any,
            "d(mean pressure)/d(displacement) with the points in contact kept, those at the hardness with their pressure; NaN \
             where it is infinite (full contact with a fixed mean level) or not computed: the attribute undefined says why",
        )],
        |at| stiff(at, |found| found.value),
    )
    .with(loads)
    .head("stiffness", Form::Size),
    Column::new(
        "stiffness_error",
        "1",
        &[(any, "relative error of the stiffness, from the residual of its linear problem")],
        |at| stiff(at, |found| found.error),
    )
    .with(loads)
    .by(Origin::Residual),
    Column::new(
        "extra_solves",
        "1",
        &[(any, "further solves to find the energy lost in the step")],
        |at| at.step.as_ref().map_or(Cell::Real(f64::NAN), |(step, _)| step.extra_solves.into()),
    )
    .count()
    .with(path)
    .by(Origin::Way),
    Column::new(
        "increments",
        "1",
        &[(any, "equal increments in which the step was made until they changed nothing")],
        |at| at.step.as_ref().map_or(Cell::Real(f64::NAN), |(step, _)| step.increments.into()),
    )
    .count()
    .with(friction)
    .by(Origin::Way)
    .head("increments", Form::Whole),
    Column::new(
        "iterations",
        "1",
        &[(path, "steps of the solver, extra solves included"), (any, "iterations or time steps of the solver")],
        |at| at.step.as_ref().map_or(at.effort, |(step, _)| step.effort).iterations.into(),
    )
    .count()
    .by(Origin::Way)
    .head("steps", Form::Whole),
    Column::new(
        "transform_pairs",
        "1",
        &[
            (path, "forward and inverse transforms of one component, in pairs, extra solves included"),
            (any, "forward and inverse real transforms of the full grid, in pairs"),
        ],
        |at| match &at.step {
            Some((step, _)) => (step.effort.transform_pairs as u64).into(),
            None => at.effort.transform_pairs.into(),
        },
    )
    .by(Origin::Way)
    .head("pairs", Form::Whole),
    Column::new(
        "converged",
        "1",
        &[
            (path, "1 if all residuals are at most the tolerance"),
            (law, "1 if all five residuals are at most the tolerance"),
            (any, "1 if all residuals of this load are at most the tolerance"),
        ],
        |at| at.has_converged().into(),
    )
    .flag(),
    Column::new("residual", "1", &[(any, "largest residual, from the final fields")], |at| at.worst().into())
        .at("")
        .with(path)
        .by(Origin::Residual),
    Column::new(
        "residual_equilibrium",
        "1",
        &[(any, per_stress!("largest unbalanced force per area, from the final fields,"))],
        |at| at.residual("equilibrium").into(),
    )
    .at("residual.equilibrium")
    .with(|facts| path(facts) && of_a_law(facts))
    .in_file(loads)
    .by(Origin::Residual),
    residual!(
        "complementarity",
        &[
            (law, "sum(p gap) / (sum(p) h_rms) with p the pressure of the wall, from the final fields"),
            (between, "sum(p gap) / (sum(p) h_rms), from the final fields, the larger of the two faces"),
            (any, "sum(p gap) / (sum(p) h_rms), from the final fields"),
        ]
    )
    .with(|facts| loads(facts) || !of_a_law(facts)),
    residual!(
        "penetration",
        &[
            (between, "max(0, -min gap) / h_rms, from the final fields, the larger of the two faces"),
            (any, "max(0, -min gap) / h_rms, from the final fields"),
        ]
    ),
    Column::new(
        "residual_negative_pressure",
        "1",
        &[
            (law, per_stress!("largest tension that the wall would have to hold, from the final fields,")),
            (between, "max(0, -min p) / mean p, from the final fields, the larger of the two faces"),
            (any, "max(0, -min p) / mean p, from the final fields"),
        ],
        |at| at.residual(if law(at.facts) { "wall_tension" } else { "negative_pressure" }).into(),
    )
    .at("residual.negative_pressure")
    .in_file(loads)
    .with(|facts| loads(facts) || wall_on_path(facts))
    .by(Origin::Residual),
    residual!("wall_tension", &[(any, "largest tension that the wall would have to hold")])
        .with(|facts| path(facts) && of_a_law(facts)),
    residual!(
        "load",
        &[
            (law, per_stress!("|mean p - asked| from the final fields, 0 if the approach is prescribed,")),
            (
                between,
                "|mean p - asked| / asked, the larger of the two faces; if the approach is prescribed the difference of their \
                 mean pressures over its mean",
            ),
            (any, "|mean p - asked| / asked, from the final fields"),
        ]
    ),
    residual!("friction", &[(any, "largest distance of the shear from its law / the largest limit")])
        .with(friction),
    residual!("excess", &[(any, "largest excess of the shear over its limit / the largest limit")]).with(friction),
    residual!("saturation", &[(any, "largest gap / h_rms where the pressure is the hardness")]).with(hardness),
    residual!("lateral_traction", &[(any, "largest lateral traction that the dynamics left / largest pressure")])
        .with(|facts| facts.unknown == Unknown::All)
        .by(Origin::Way),
    residual!(
        "lateral_displacement",
        &[(any, "last change of the lateral displacement over h_rms, which is consistent with the pressure to that extent")]
    )
    .with(steep),
    Column::new(
        "seconds",
        "s",
        &[(any, "wall time of a load: solution and, of a contact, stiffness, statistics, flow; without finer grids")],
        |at| at.seconds.into(),
    )
    .by(Origin::Clock),
    Column::new(
        "force",
        "stress*length^2",
        &[(any, "force, of a line per length across it (stress*length)")],
        |at| (at.summary.mean_pressure * at.lengths[0] * at.lengths[1]).into(),
    )
    .with(free),
    Column::new(
        "plastic_fraction",
        "1",
        &[
            (path, "points whose pressure is the hardness, to its accuracy, over all points"),
            (any, "points whose pressure is the hardness over all points"),
        ],
        |at| plastic(at).map_or(f64::NAN, |(fraction, _)| fraction).into(),
    )
    .with(hardness)
    .head("plastic", Form::Share),
    Column::new(
        "plastic_volume",
        "length",
        &[(path, "mean plastic depth so far"), (any, "mean plastic depth over the whole surface")],
        |at| plastic(at).map_or(f64::NAN, |(_, volume)| volume).into(),
    )
    .with(hardness)
    .head("depth", Form::Size),
    Column::new(
        "projected_area_fraction",
        "1",
        &[(
            any,
            "contact area of the deformed surface, projected onto the plane of the rigid one, over the area of the cell",
        )],
        |at| {
            let found = at.rest.and_then(|rest| rest.steep()).map(|state| state.projected_area());
            found.map_or(Cell::Real(f64::NAN), |found| found.map_err(|error| error.to_string()).into())
        },
    )
    .with(steep),
    Column::new("patches", "1", &[(any, "number of connected patches of points in contact")], |at| {
        at.measured.patches.map_or(Cell::Real(f64::NAN), |found| (found.patches.len() as u64).into())
    })
    .count()
    .at("patches.count")
    .with(statistics)
    .on(Table::Patches, "patches", Form::Whole),
    Column::new("largest_patch_fraction", "1", &[(any, "points of the largest patch over all points")], |at| {
        at.measured.patches.map_or(f64::NAN, |found| found.largest() as f64 / at.points as f64).into()
    })
    .at("patches.largest_fraction")
    .with(statistics)
    .on(Table::Patches, "largest", Form::Share),
    Column::new(
        "percolates_x",
        "1",
        &[(any, "1 if a patch winds around the cell along x, with free boundaries if it spans the surface")],
        |at| flag(at.measured.patches.map(|found| found.percolate()), 0),
    )
    .flag()
    .at("patches.percolates.0")
    .with(statistics)
    .on(Table::Patches, "through x", Form::Flag),
    Column::new("percolates_y", "1", &[(any, "the same along y")], |at| {
        flag(at.measured.patches.map(|found| found.percolate()), 1)
    })
    .flag()
    .at("patches.percolates.1")
    .with(statistics)
    .on(Table::Patches, "through y", Form::Flag),
    Column::new(
        "conductance",
        "1/length",
        &[(
            any,
            "conductance per area of the points in contact between two conductors, times the sum of their resistivities: current \
             density over the potential difference less that of the bulk, with free boundaries over all of it; without a value if all \
             points of a periodic surface touch",
        )],
        |at| at.measured.conductance.clone().map_or(Cell::Real(f64::NAN), Into::into),
    )
    .with(statistics)
    .on(Table::Patches, "conductance", Form::Size),
    Column::new(
        "flow_xx",
        "1",
        &[(any, "mean flux along x by a mean pressure gradient along x, over that of a uniform gap equal to the mean gap")],
        |at| conductivity(at, [0, 0]),
    )
    .at("flow.conductivity.0.0")
    .with(flow)
    .on(Table::Flow, "flow xx", Form::Rough),
    Column::new("flow_xy", "1", &[(any, "the same along x by a gradient along y")], |at| conductivity(at, [0, 1]))
        .at("flow.conductivity.0.1")
        .with(flow)
    .on(Table::Flow, "flow xy", Form::Rough),
    Column::new("flow_yx", "1", &[(any, "the same along y by a gradient along x")], |at| conductivity(at, [1, 0]))
        .at("flow.conductivity.1.0")
        .with(flow),
    Column::new("flow_yy", "1", &[(any, "the same along y by a gradient along y")], |at| conductivity(at, [1, 1]))
        .at("flow.conductivity.1.1")
        .with(flow)
    .on(Table::Flow, "flow yy", Form::Rough),
    Column::new("flow_percolates_x", "1", &[(any, "1 if the gap lets a fluid through along x")], |at| {
        flag(at.measured.flow.map(|flow| flow.percolates), 0)
    })
    .flag()
    .at("flow.percolates.0")
    .with(flow)
    .on(Table::Flow, "through x", Form::Flag),
    Column::new("flow_percolates_y", "1", &[(any, "the same along y")], |at| {
        flag(at.measured.flow.map(|flow| flow.percolates), 1)
    })
    .flag()
    .at("flow.percolates.1")
    .with(flow)
    .on(Table::Flow, "through y", Form::Flag),
    Column::new(
        "flow_residual",
        "1",
        &[(any, "largest of what is missing in a cell and the deviations of sections and power, over the mean flow")],
        |at| at.measured.flow.map_or(f64::NAN, |flow| flow.residual).into(),
    )
    .at("flow.residual")
    .with(flow)
    .by(Origin::Residual),
    lower!("mean_pressure", "stress", "mean pressure over the whole lower surface", |face, summary| summary
        .mean_pressure),
    lower!("displacement", "length", "part of the approach at the lower face", |face, summary| face.approach)
    .on(Table::LowerFace, "approach", Form::Size),
    lower!("area_fraction", "1", "contact area fraction of the lower face", |face, summary| summary.area_fraction)
    .on(Table::LowerFace, "area", Form::Share),
    lower!("area_fraction_corrected", "1", "the same less the excess of the pixels along the perimeter", |face, summary| {
        summary.area_fraction_corrected
    })
    .on(Table::LowerFace, "corrected", Form::Share),
    lower!("contact_nodes", "1", "number of points in contact at the lower face", |face, summary| summary.contact_nodes).count(),
    lower!(
        "boundary_links",
        "1",
        "neighbouring pairs with one point in contact and one not, at the lower face",
        |face, summary| summary.boundary_links
    )
    .count(),
    lower!("mean_gap", "length", "mean distance between lower face and lower surface", |face, summary| summary.mean_gap)
    .on(Table::LowerFace, "mean gap", Form::Size),
    lower!("max_pressure", "stress", "largest pressure on the lower face", |face, summary| summary.max_pressure)
    .on(Table::LowerFace, "peak p", Form::Size),
    lower!(
        "mean_pressure_in_contact",
        "stress",
        "mean pressure over the points in contact at the lower face",
        |face, summary| summary.mean_pressure_in_contact
    ),
    lower_residual!(complementarity, "sum(p gap) / (sum(p) h_rms) of the lower face"),
    lower_residual!(penetration, "max(0, -min gap) / h_rms of the lower face"),
    lower_residual!(negative_pressure, "max(0, -min p) / mean p of the lower face"),
    lower_residual!(load, "|mean p - asked| / asked of the lower face, or as residual_load"),
    Column::new(
        "residual_equilibrium",
        "1",
        &[(any, per_stress!("largest unbalanced force per area, from the final fields,"))],
        |at| at.residual("equilibrium").into(),
    )
    .with(|facts| loads(facts) && law(facts))
    .by(Origin::Residual),
];

/// The columns of a problem.
pub fn columns(facts: &Facts) -> impl Iterator<Item = &'static Column> {
    COLUMNS.iter().filter(move |column| (column.present)(facts))
}

/// The columns as a table in Markdown: name in a file, place in JSON, unit, definitions.
pub fn page() -> String {
    let row = |column: &Column| {
        let mut meanings: Vec<&str> = column.meanings.iter().rev().map(|(_, meaning)| *meaning).collect();
        meanings.dedup();
        let order =
            column.order.map_or_else(String::new, |order| format!("; of order {order} in the distance of the points"));
        let json = if column.json.is_empty() { "-".into() } else { format!("`{}`", column.json) };
        let file = format!("`{}`", column.name);
        format!("| {file} | {json} | {} | {}{order} |\n", column.unit, meanings.join("; or: "))
    };
    let head = "| HDF5 | JSON | unit | definition |\n|---|---|---|---|\n";
    COLUMNS.iter().fold(head.to_owned(), |page, column| page + &row(column))
}
