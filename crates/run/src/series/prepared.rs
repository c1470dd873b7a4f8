//! Input of a series, read and checked before the first solve.

use std::array::from_fn;
use std::borrow::Cow;
use std::sync::Arc;

use gfmd_contact::{Boundary, Budget, Drive, Dynamics, Equilibrium as _, Fields as _, Hardness, Load, Refusal, Solver};
use gfmd_field::{Grid, Share};
use gfmd_files::Reader;
use gfmd_flow::Fluid;
use gfmd_green::Body;
use gfmd_interface::Parts;
use gfmd_law::Law;
use gfmd_measure::{GapGas, Scales, top_inside_of_shared, top_of_shared};
use gfmd_plasticity::Cell;
use gfmd_problem::{
    AnyState, Facts, Inelastic, KeptStrain, MemoryNeed, Posed, Unknown, Words, key, pose, setting, words,
};
use gfmd_record::StateContext;
use gfmd_surface::{Moments, Statistics, SurfaceError, row_mean, window, window_rows};
use gfmd_unit::Units;
use ndarray::{Array2, ArrayRef2};

use super::layout::SeriesLayout;
use crate::gas::GivenGas;
use gfmd_input::base::{BaseArgs, MovedBase};
use gfmd_input::failure::Failure;
use gfmd_input::hardness::{self, GivenHardness};
use gfmd_input::lower::LowerArgs;
use gfmd_input::processes::of_first;
use gfmd_input::session::Session;
use gfmd_input::source::{SourceArgs, Surface, highest, stored_unit};
use gfmd_input::{memory, rows};
use gfmd_problem::Adhesion;
use gfmd_problem::options::{BodyArgs, ComplianceArgs, LawArgs, PlasticityArgs, Yielding, check_wavenumbers};

/// Requested parts of a problem, for a series of any kind; [`Asked::new`] returns those that need no flag.
#[derive(Clone)]
pub struct Asked<'a> {
    /// Surface.
    pub source: &'a SourceArgs,
    /// Elastic body; with its long-term moduli if it relaxes.
    pub body: Cow<'a, BodyArgs>,
    /// Compliance table of the body, if it has one.
    pub compliance: Cow<'a, ComplianceArgs>,
    /// Displacement or traction of the base.
    pub base: Cow<'a, BaseArgs>,
    /// Surface below the slab.
    pub lower: Cow<'a, LowerArgs>,
    /// Interaction.
    pub law: Cow<'a, LawArgs>,
    /// Hardness.
    pub hardness: Option<&'a GivenHardness>,
    /// Yielding, friction, relaxation and wear.
    pub inelastic: Inelastic,
    /// Boundary of the cell.
    pub boundary: Boundary,
    /// Options of the damped dynamics.
    pub dynamics: Dynamics,
    /// Method.
    pub solver: Solver,
    /// Tolerance and largest number of iterations.
    pub budget: Budget,
    /// Fluid whose leak is computed, if there is one.
    pub fluid: Option<Fluid>,
    /// Conductivity of both conductors in series, if it is given.
    pub conductivity: Option<f64>,
    /// Gas in the gap, if its conductance is computed.
    pub gas: Option<GivenGas>,
    /// True if only one state at a time is in memory, and nothing is measured.
    pub once: bool,
}

/// Input of a series.
pub struct Prepared {
    /// Facts that decide which parts can be combined.
    pub facts: Facts,
    /// Surface as given.
    pub surface: Surface,
    /// Elastic body.
    pub body: Body,
    /// Base, if it is moved.
    pub base: Option<MovedBase>,
    /// Surface below the slab.
    pub lower: Option<Surface>,
    /// Interaction.
    pub law: Arc<dyn Law>,
    /// Hardness, if there is one.
    pub hardness: Option<Hardness>,
    /// Yielding, friction, relaxation and wear.
    pub inelastic: Inelastic,
    /// Fluid whose leak is computed, if there is one.
    pub(crate) fluid: Option<Fluid>,
    /// Conductivity of both conductors in series, if it is given.
    pub(crate) conductivity: Option<f64>,
    /// Gas in the gap, if its conductance is computed.
    pub(crate) gas: Option<GapGas>,
    dynamics: Dynamics,
    /// True if a dynamic solver moves all components.
    moves_all: bool,
    /// Height of the surface's top above the highest grid point, length.
    pub rise: f64,
    /// Numbers of the attraction, if there is one.
    pub adhesion: Option<Adhesion>,
    /// Spectral moments of the surface; under a window for a patch, which is not periodic.
    moments: Moments,
}

impl Prepared {
    /// Reads the parts of a problem; `series` has the [facts](Asked::facts) of the series.
    ///
    /// # Errors
    /// Returns an error if parts cannot be combined, cannot be read, or do not fit into memory.
    pub fn new(asked: &Asked, series: Facts, session: &Session) -> Result<Self, Failure> {
        let body = asked.compliance.body(&asked.body)?;
        asked.budget.check().map_err(|error| Failure::input(key("tolerance"), error))?;
        let series = Facts { processes: session.processes().all, ..series };
        asked.facts(series, false).check()?;
        let law = asked.law.build()?.into_shared();
        let surface = asked.source.bounded(asked.boundary, session)?;
        session.agree(asked.body.check_modulus(surface.unit.as_deref()).map_err(Failure::from))?;
        let facts = asked.facts(series, surface.grid.is_line());
        facts.check()?;
        let lower = asked.lower.read(asked.source, &surface, session)?;
        if lower.is_some() && is_flat(&surface) {
            return Err(Failure::input(
                asked.source.name(),
                "the heights are all equal; only the lower surface may be flat",
            ));
        }
        let is_shared = session.processes().all > 1;
        // The first of several processes measures whole fields.
        let shared = if is_shared { Facts { flow: false, ..facts } } else { facts };
        let elastic = shared.memory_need(asked.solver, asked.once);
        let faces = 1 + usize::from(facts.lower.is_some());
        let components = if facts.friction.is_some() || facts.lateral { 3 } else { faces };
        let inelastic = asked.inelastic_on();
        let need = match &inelastic.relaxation {
            Some((prony, _)) => elastic.relaxing(prony.branches().len(), components),
            None => elastic,
        };
        let need = match &inelastic.plasticity {
            Some(plasticity) => {
                let points = points_per_point(&plasticity.cells(&body, &surface.grid)?, &surface.grid, is_shared);
                match plasticity.kept_strain {
                    KeptStrain::Last => need.yielding(points),
                    KeptStrain::Waypoints => need.yielding(points).keeping_strain(points),
                }
            }
            None => need,
        };
        session.fits(need, &surface.grid, &surface.heights)?;
        if is_shared && (facts.flow || facts.statistics) {
            let (measurement, whole) = match facts.flow {
                true => ("flow", MemoryNeed::FLOW_ALONE),
                false => ("statistics", MemoryNeed::HARD_WALL),
            };
            session.agree(memory::fits(whole, key(measurement), surface.grid.points()))?;
        }
        if is_shared && facts.finite_slope {
            let of_all = MemoryNeed(session.processes().here as u64 * MemoryNeed::STEEP_OF_EACH.0);
            session.agree(memory::fits(of_all, key("finite_slope"), surface.grid.points()))?;
        }
        let is_held = facts.unknown == Unknown::Held;
        let (base, hardness) = asked.fields((&body, is_held), &surface, session)?;
        let surface = match &base {
            // The contact sees the surface as displaced by the base.
            Some(base) => surface.displaced(&base.lift).map_err(|error| Failure::input(asked.source.name(), error))?,
            None => surface,
        };
        check_wavenumbers(&body, &surface.grid)?;
        asked.body.check_on(&surface.grid, body.contact_modulus() * surface.rms_gradient())?;
        let heights = MovedBase::under(base.as_ref(), &surface.heights);
        let rise = rise_of(&surface.share, &heights, surface.boundary)
            + lower.as_ref().map_or(0.0, |lower| rise_of(&lower.share, &lower.heights, lower.boundary));
        let moments = match surface.boundary {
            Boundary::Free => {
                let windowed = windowed(&surface);
                let statistics =
                    windowed.and_then(|heights| Statistics::distributed(&heights, &surface.grid, &surface.share));
                statistics.map_err(|error| Failure::input(asked.source.name(), error))?.moments
            }
            Boundary::Periodic => surface.statistics.moments,
        };
        let gas = asked.gas.map(|gas| gas.in_units(&surface.units())).transpose()?;
        let adhesion = Adhesion::of(&asked.law, &law, &surface.grid, &surface.moments(), body.contact_modulus());
        Ok(Self {
            facts,
            surface,
            body,
            base,
            lower,
            law,
            hardness,
            inelastic,
            fluid: asked.fluid,
            conductivity: asked.conductivity,
            gas,
            dynamics: asked.dynamics,
            moves_all: facts.moves_all_by(asked.solver),
            rise,
            adhesion,
            moments,
        })
    }

    /// Takes the units of lengths as a file spells them.
    pub fn take_units(&mut self, reader: &Reader) {
        self.surface.unit = stored_unit(reader, "/surface");
        if let Some(lower) = &mut self.lower {
            lower.unit = stored_unit(reader, "/lower");
        }
    }

    /// Returns the yielding of the body in numbers, given by options; `None` if it does not yield.
    ///
    /// # Errors
    /// Returns an error for cells that do not fit.
    pub fn yielding(&self, given: &PlasticityArgs) -> Result<Option<Yielding>, Failure> {
        let Some(plasticity) = &self.inelastic.plasticity else { return Ok(None) };
        Ok(given.yielding(&plasticity.cells(&self.body, &self.surface.grid)?))
    }

    /// Returns the scales of reduced quantities.
    pub fn scales(&self) -> Scales {
        Scales { contact_modulus: self.body.contact_modulus(), rms_gradient: self.surface.rms_gradient() }
    }

    /// Returns the unit of reduced pressures, E* times the rms gradient.
    pub fn unit_pressure(&self) -> f64 {
        self.body.contact_modulus() * self.surface.rms_gradient()
    }

    /// Returns the load or approach of the value 1 of the option `control`: the factor from a reduced pressure or a
    /// force to the mean pressure, 1 for a pressure and an approach.
    ///
    /// # Errors
    /// Returns an error for a force on a profile.
    pub fn unit_of_load(&self, control: &str) -> Result<f64, Failure> {
        unit_of_load(control, &self.surface.grid, self.unit_pressure())
    }

    /// Returns the lift that a moved base adds to the displacement.
    pub fn lift(&self) -> Option<&Array2<f64>> {
        self.base.as_ref().map(|base| &base.lift)
    }

    /// Describes a state of the contact for its columns, without a stiffness.
    pub fn at<'a>(&'a self, state: &'a AnyState, tolerance: f64) -> StateContext<'a> {
        let at = StateContext::in_scales(&self.facts, state, &self.scales(), &self.surface.grid, tolerance);
        let (inside, spacing) = (self.surface.statistics.seam.inside, self.surface.grid.spacing());
        let slopes = from_fn(|axis| inside[axis] / spacing[axis]);
        StateContext {
            short_waves: self.short_waves(),
            waves: self.waves(),
            slopes,
            rise: Some(self.rise),
            share: Some(self.surface.share.clone()),
            fluid: self.fluid,
            conductivity: self.conductivity,
            gas: self.gas,
            process_zone: self.adhesion.map(|found| found.process_zone_points / found.process_zone_needed),
            ..at
        }
    }

    /// Returns the height of the highest grid point, length, from which approaches count: with the lift of a base that
    /// moves, and with the highest point of a lower surface.
    pub fn highest(&self) -> f64 {
        let heights = MovedBase::under(self.base.as_ref(), &self.surface.heights);
        let upper = highest(&self.surface.share, &heights);
        upper + self.lower.as_ref().map_or(0.0, Surface::highest)
    }

    /// Returns the share of the mean square gradient of the surface in waves shorter than four points.
    pub fn short_waves(&self) -> f64 {
        self.moments.short_waves()
    }

    /// Returns the number of waves that share the mean square gradient of the surface: at most 1 for a shape alone,
    /// whose contact edges lie alike on the grid even if it has edges, and thus many waves.
    pub fn waves(&self) -> f64 {
        let waves = self.moments.waves;
        if waves > 1.0 && self.surface.is_shape_alone && self.lower.is_none() { 1.0 } else { waves }
    }

    /// Poses the contact with this law.
    ///
    /// # Errors
    /// Returns an error if the parts do not make a contact.
    pub fn pose(&self, source: &SourceArgs, law: &Arc<dyn Law>) -> Result<Posed, Failure> {
        let heights = MovedBase::under(self.base.as_ref(), &self.surface.heights);
        let Inelastic { plasticity, shear, relaxation, wear } = &self.inelastic;
        let parts = Parts {
            share: Some(&self.surface.share),
            lower: self.lower.as_ref().map(|lower| (&lower.heights).into()),
            law: Some(Arc::clone(law)),
            all_components: self.moves_all,
            hardness: self.hardness.clone(),
            shear: *shear,
            relaxation: relaxation.as_ref().map(|(prony, relaxes)| (prony, *relaxes)),
            wear: *wear,
            sideways: self.base.as_ref().map_or(&[], |base| &base.sideways),
            dynamics: self.dynamics,
            ..Parts::new(&self.body, &self.surface.grid, &heights)
        };
        pose(&self.facts, &parts, plasticity.as_ref()).map_err(|refusal| Failure::posing(refusal, source.name()))
    }

    /// Poses the contact, and warns if the grid is too coarse for its law.
    ///
    /// # Errors
    /// Fails like [`pose`](Self::pose); also if the method does not solve the contact, and if the law has no meaning on
    /// the grid, unless that is requested.
    pub fn pose_with_warnings(&self, asked: &Asked, session: &Session) -> Result<Posed, Failure> {
        let contact = self.pose(asked.source, &self.law)?;
        let (found, allowed) = (asked.solver, contact.solvers());
        if !allowed.contains(&found) {
            return Err(Refusal::Solver { found, allowed }.into());
        }
        self.unit_warnings(self.adhesion.as_ref()).into_iter().for_each(|warning| session.warn(UNITS, warning));
        if let Some(adhesion) = &self.adhesion {
            adhesion.check(asked.law.coarse)?;
            tracing::info!("{adhesion}");
        }
        if let Some(trapping) = contact.trapping() {
            session.warn("lattice-trapping", trapping.to_string());
        } else if let Some(unresolved) = self.adhesion.as_ref().and_then(Adhesion::unresolved) {
            session.warn("process-zone", unresolved);
        }
        Ok(contact)
    }

    /// Returns a warning if the contact reaches the edge of a patch; `None` if it does not, or for a periodic surface.
    pub fn edge_warning(&self, state: &AnyState) -> Option<String> {
        let Surface { grid, share, boundary: Boundary::Free, .. } = &self.surface else { return None };
        let ([nx, ny], first) = (grid.points(), share.rows().start);
        let is_edge = |i: usize, j: usize| i == 0 || i + 1 == nx || (!grid.is_line() && (j == 0 || j + 1 == ny));
        let all = (if grid.is_line() { 2 } else { 2 * (nx + ny).saturating_sub(2) }).min(nx * ny);
        let repulsion = state.repulsion();
        let own = repulsion.indexed_iter().filter(|((i, j), p)| **p > 0.0 && is_edge(first + i, *j)).count();
        let pressed: usize = share.each(own).into_iter().sum();
        (pressed > 0).then(|| {
            format!(
                "the contact reaches the edge of the patch, at {pressed} of its {all} points: beyond it nothing \
                 presses the body, and the pressure at the edge is as at a sharp rim; a contact that extends further \
                 needs a larger patch"
            )
        })
    }

    /// Describes numbers of the problem that no material has, as signs of mixed-up units.
    pub fn unit_warnings(&self, adhesion: Option<&Adhesion>) -> Vec<Words> {
        let units = self.surface.units();
        let modulus = self.body.contact_modulus();
        let Some(metres) = units.metres() else { return Vec::new() };
        let mut warnings = Vec::new();
        // Without a unit of stress, a large modulus must be in Pa.
        let pascals = units.pascals().or_else(|| (modulus >= SOFTEST).then_some(1.0));
        if let Some(pascals) = pascals
            && modulus * pascals < SOFTEST
        {
            let found = format!(
                "the contact modulus is {:.3e} Pa, softer than any gel: a stress without a unit is in {}; ",
                modulus * pascals,
                units.stress().unwrap_or_default()
            );
            warnings.push(words![found, setting("young", "70GPa"), " has its own"]);
        }
        if let (Some(pascals), Some(adhesion)) = (pascals, adhesion) {
            let work = adhesion.work * pascals * metres;
            if work < WEAKEST {
                let found = format!(
                    "the work of adhesion is {work:.1e} J/m^2, weaker than any attraction of solids (0.001 to 10): \
                     one without a unit is in {}; ",
                    Units::new(units.length(), Some(units.stress().unwrap_or(Units::PASCAL))).name("stress*length")
                );
                warnings.push(words![found, setting("param", "gamma=0.05J/m^2"), " has its own"]);
            }
        }
        let conductivity = self.conductivity.into_iter().chain(self.gas.map(|gas| gas.conductivity));
        let least = conductivity.fold(f64::INFINITY, f64::min);
        if let Some(pascals) = pascals
            && least * pascals * metres * metres < LEAST_CONDUCTIVITY
        {
            let found = format!(
                "a conductivity is {:.1e} W/(m K), less than the one of any gas: one without a unit is in {}; ",
                least * pascals * metres * metres,
                Units::new(units.length(), Some(units.stress().unwrap_or(Units::PASCAL)))
                    .name("stress*length^2/time/temperature")
            );
            warnings.push(words![found, setting("conductivity", "16W/(m*K)"), " has its own"]);
        }
        warnings
    }

    /// Warns about drives, given by the `option`, far beyond full contact: their units are mixed up.
    pub fn warn_about_drives(&self, drives: &[Drive], option: &str, session: &Session) {
        let reduced = drives.iter().filter_map(|drive| match drive.load {
            Load::MeanPressure(pressure) => Some(pressure / self.unit_pressure()),
            Load::Approach(_) => None,
        });
        if let Some(warning) = self.load_warning(reduced.fold(0.0, f64::max), option) {
            session.warn(UNITS, warning);
        }
    }

    /// Warns about approaches with strain that is not small.
    pub fn warn_about_strain(&self, approaches: impl IntoIterator<Item = f64>, session: &Session) {
        let approach = approaches.into_iter().fold(0.0, f64::max);
        if let Some(warning) = self.strain_warning(approach) {
            session.warn("large-strain", warning);
        }
    }

    /// Returns a warning if strain is not small at the largest approach, length; `None` if it is small.
    pub fn strain_warning(&self, approach: f64) -> Option<String> {
        let part = approach / self.body.total_height();
        let said = self.surface.units().words(approach, "length");
        let warning = || {
            format!(
                "the approach of {said} is {part:.2} of the height of the slab; \
                 linear elasticity holds for small strain"
            )
        };
        (part > STRAINED).then(warning)
    }

    /// Returns a warning if the largest reduced pressure, given by the `option`, is far beyond full contact.
    pub fn load_warning(&self, p_star: f64, option: &str) -> Option<Words> {
        let units = self.surface.units();
        let said = units.words(self.unit_pressure(), "stress");
        let hint = match units.stress() {
            Some(unit) => format!("a stress without a unit is in {unit}").into(),
            None => words![
                "pressure and modulus may be in different units, as ",
                setting("pressure", "1MPa"),
                " and ",
                setting("young", "70GPa"),
                " are not",
            ],
        };
        let warning = || {
            let times = if p_star < 1e5 { format!("{p_star:.1}") } else { format!("{p_star:.1e}") };
            let found = format!(" is {times} times E* g = {said}, far beyond full contact (some 2): ");
            words![key(option), found, hint]
        };
        (p_star > HIGHEST).then(warning)
    }

    /// Checks that a contact can be solved under each of the drives, given by the `option`.
    ///
    /// # Errors
    /// Returns an error for the first drive without a solution.
    pub fn check_drives(&self, contact: &Posed, drives: &[Drive], option: &str, tolerance: f64) -> Result<(), Failure> {
        let part = SeriesLayout::of(&self.facts).name;
        for (index, drive) in drives.iter().enumerate() {
            check_drive(contact, *drive, words![key(option), format!(", {part} {index}")], tolerance)?;
        }
        Ok(())
    }

    /// Returns the text that identifies the run of a configuration with this input; with several processes, only the
    /// first one gets it.
    pub fn identity(&self, config: &str, session: &Session) -> String {
        let share = &self.surface.share;
        let base = self.base.as_ref().map_or_else(String::new, |base| format!("\nbase {}", base.checksum()));
        let lower = self.lower.as_ref().map_or_else(String::new, |lower| format!("\nlower {}", lower.checksum()));
        session.identity(config, &self.surface.checksum())
            + &base
            + &lower
            + &hardness::identity(self.hardness.as_ref(), share)
    }
}

/// Returns the load or approach of the value 1 of the option `control` on a surface on `grid`; `unit` is the unit of
/// reduced pressures ([`Prepared::unit_of_load`]).
///
/// # Errors
/// Returns an error for a force on a profile.
pub fn unit_of_load(control: &str, grid: &Grid, unit: f64) -> Result<f64, Failure> {
    match control {
        "p_star" => Ok(unit),
        "force" if grid.is_line() => {
            let allowed = words![
                "left out of a profile, which has a force per length: ",
                key("pressure"),
                " is this divided by the length of the profile"
            ];
            Err(Failure::value(key("force"), "given", allowed))
        }
        "force" => Ok(grid.lengths().iter().product::<f64>().recip()),
        _ => Ok(1.0),
    }
}

/// Returns the rows of this process of a patch below a window that falls to zero at its rim.
///
/// # Errors
/// Returns an error for heights that are not finite.
fn windowed(Surface { heights, share, .. }: &Surface) -> Result<Array2<f64>, SurfaceError> {
    if share.is_whole() {
        return window(heights, 1.0);
    }
    // Only the sum over whole heights has the bits of one process.
    let whole = rows::gathered(share, heights.view());
    let [mean] = of_first(share.ranks(), [whole.as_ref().map_or(0.0, |whole| row_mean(whole)).to_bits()]);
    Ok(window_rows(share, heights, (1.0, f64::from_bits(mean))))
}

/// Returns the height of a surface's top above its highest grid point, length.
fn rise_of(share: &Share, heights: &ArrayRef2<f64>, boundary: Boundary) -> f64 {
    let top = match boundary {
        Boundary::Periodic => top_of_shared(share, heights.view()),
        Boundary::Free => top_inside_of_shared(share, heights.view()),
    };
    top - highest(share, heights)
}

/// Returns true if the heights of all processes are equal.
fn is_flat(Surface { heights, share, .. }: &Surface) -> bool {
    let none = [f64::INFINITY, f64::NEG_INFINITY];
    let wider = |[low, high]: [f64; 2], [a, b]: [f64; 2]| [low.min(a), high.max(b)];
    let own = heights.iter().fold(none, |ends, height| wider(ends, [*height; 2]));
    let [lowest, highest] = share.each(own).into_iter().fold(none, wider);
    lowest == highest
}

/// Returns the number of points of all cells per point of the surface. If several processes share them, the first one
/// has the long waves of all coarser cells, and each cell counts with its points along one axis.
fn points_per_point(cells: &[Cell], grid: &Grid, is_shared: bool) -> f64 {
    let of_cell = |cell: &Cell| {
        let part = cell.grid(grid).len() as f64 / grid.len() as f64;
        if is_shared { part * cell.coarsening as f64 } else { part }
    };
    cells.iter().map(of_cell).sum()
}

/// Code of warnings about mixed-up units.
const UNITS: &str = "units";

/// Least contact modulus of a material, Pa; gels have some 10 kPa.
const SOFTEST: f64 = 1e4;

/// Least work of adhesion, J/m²: a hundredth of the weakest attraction between solids.
const WEAKEST: f64 = 1e-5;

/// Least thermal conductivity, W/(m K); heavy gases have some 0.005.
const LEAST_CONDUCTIVITY: f64 = 1e-3;

/// Largest reduced pressure of a rough contact; at 2 nearly all of the surface is in contact.
const HIGHEST: f64 = 10.0;

/// Ratio of the approach to the slab height above which strain is not small, as below a punch.
const STRAINED: f64 = 0.1;

/// Checks that a contact can be solved under a drive, given by `name`.
///
/// # Errors
/// Returns an error if it cannot be solved under the drive.
pub fn check_drive(contact: &Posed, drive: Drive, name: impl Into<Words>, tolerance: f64) -> Result<(), Failure> {
    let checked = contact.check(drive).and_then(|()| contact.check_resolution(drive, tolerance));
    checked.map_err(|refusal| Failure::input(name, refusal))
}

impl<'a> Asked<'a> {
    /// Returns the parts of a surface pressed on a body, with a hard wall, by the best suited method.
    pub fn new(source: &'a SourceArgs, body: Cow<'a, BodyArgs>, budget: Budget) -> Self {
        Self {
            source,
            body,
            compliance: Cow::default(),
            base: Cow::default(),
            lower: Cow::default(),
            law: Cow::default(),
            hardness: None,
            inelastic: Inelastic::default(),
            boundary: Boundary::Periodic,
            dynamics: Dynamics::default(),
            solver: Solver::Auto,
            budget,
            fluid: None,
            conductivity: None,
            gas: None,
            once: false,
        }
    }

    /// Returns the facts of a `series` of states with the parts of this problem; `line` is true for a profile.
    pub fn facts(&self, series: Facts, line: bool) -> Facts {
        let facts = Facts {
            law: self.law.law,
            hardness: self.hardness.is_some(),
            lower: self.lower.fact(),
            moved_base: self.base.fact(),
            boundary: self.boundary,
            line,
            ..series
        };
        self.inelastic.of(self.compliance.of(self.body.of(facts)))
    }

    /// Returns the inelastic parts; on a finer grid, cells that are not graded are halved.
    fn inelastic_on(&self) -> Inelastic {
        let mut given = self.inelastic.clone();
        if self.source.finer.is_some_and(|times| times > 1) {
            given.plasticity = given.plasticity.map(|plasticity| plasticity.finer());
        }
        given
    }

    /// Reads the moved base and the hardness, rows of this process. With several processes, the first one reads the
    /// files.
    fn fields(
        &self,
        (body, is_held): (&Body, bool),
        surface: &Surface,
        session: &Session,
    ) -> Result<(Option<MovedBase>, Option<Hardness>), Failure> {
        let Surface { grid, share, unit, .. } = surface;
        let read = || {
            let times = self.source.finer.map_or(1, |times| times as usize);
            let base = self.base.read(body, grid, times, unit.as_deref(), is_held)?;
            Ok((base, self.hardness.map(|hardness| hardness.read(grid)).transpose()?))
        };
        if share.is_whole() {
            return read();
        }
        let (base, hardness) = session.agree(if session.is_first() { read() } else { Ok((None, None)) })?;
        let base = self.base.is_given().then(|| MovedBase::handed_out(base, grid, share));
        let hardness = self.hardness.is_some().then(|| hardness::handed_out(hardness, grid, share));
        Ok((base, hardness))
    }
}
