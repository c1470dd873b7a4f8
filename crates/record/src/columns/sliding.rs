//! Numbers of a state that slides steadily.

use gfmd_contact::{Effort, Fields as _, Plastic};
use gfmd_heat::Heated;
use gfmd_measure::{GridLimit, Scales, Summary};
use gfmd_medium::{Persson, SlidingState};
use gfmd_relax::worst;

use crate::column::{Form, Origin, Subject, Table};
use crate::{Cell, Record};

/// States that slide steadily.
#[derive(Clone, Copy, Debug)]
pub struct Sliding;

/// Features of a problem of steady sliding.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SlidingFacts {
    /// True if friction heats the surfaces.
    pub heat: bool,
    /// True if both bodies share the heat.
    pub shared: bool,
    /// True if a hardness limits the pressure.
    pub hardness: bool,
    /// True if states on a finer grid give the grid error.
    pub refined: bool,
}

/// Field of a state that slides steadily.
#[derive(Clone, Copy, Debug)]
pub struct SlidingField {
    /// Name in a file.
    pub name: &'static str,
    /// Kind of quantity.
    pub unit: &'static str,
    /// Definition.
    pub meaning: &'static str,
    /// True if the states of a problem have the field.
    pub present: fn(&SlidingFacts) -> bool,
}

/// Fields of a state, in the order of a file.
pub const SLIDING_FIELDS: &[SlidingField] = &[
    SlidingField { name: "pressure", unit: "stress", meaning: "pressure on the surface of the body", present: any },
    SlidingField {
        name: "displacement_z",
        unit: "length",
        meaning: "normal displacement of the body surface, negative downwards",
        present: any,
    },
    SlidingField { name: "gap", unit: "length", meaning: "distance between the surfaces", present: any },
    SlidingField {
        name: "plastic_depth",
        unit: "length",
        meaning: "depth by which the surfaces are pressed into each other beyond touching",
        present: hardness,
    },
    SlidingField {
        name: "temperature",
        unit: "temperature",
        meaning: "surface temperature of the body, relative to its mean",
        present: heat,
    },
    SlidingField {
        name: "heat_flux",
        unit: "stress*length/time",
        meaning: "heat flux into the body",
        present: |facts| facts.shared,
    },
];

/// Input from which the columns of a sliding state are computed.
#[derive(Clone, Debug)]
pub struct SlidingContext<'a> {
    speed: f64,
    state: &'a SlidingState,
    heated: Option<&'a Heated>,
    persson: Persson,
    summary: Summary,
    tolerance: f64,
    seconds: f64,
    finer: Vec<Result<Record<Sliding>, String>>,
}

impl<'a> SlidingContext<'a> {
    /// Measures a state at a `speed`, with the temperature of its surface and its friction by Persson's theory.
    pub fn new(
        speed: f64,
        (state, heated): (&'a SlidingState, Option<&'a Heated>),
        persson: Persson,
        (scales, tolerance): (&Scales, f64),
        seconds: f64,
    ) -> Self {
        Self { speed, state, heated, persson, summary: state.summary_in(scales), tolerance, seconds, finer: Vec::new() }
    }

    /// Adds the numbers of the state on grids with twice as many points along each side, or why there are none.
    #[must_use]
    pub fn beside(self, finer: Vec<Result<Record<Sliding>, String>>) -> Self {
        Self { finer, ..self }
    }

    /// Returns a number of the limit of a column on infinitely fine grids.
    fn limit(&self, name: &str, of: fn(&GridLimit, f64) -> f64) -> Cell {
        let column = COLUMNS.iter().find(|column| column.name == name);
        let value = column.map_or(f64::NAN, |column| (column.value)(self).number());
        let limits = self.finer.iter().map(|finer| match finer {
            Ok(finer) => Ok(GridLimit::of_two_grids(value, finer.number(name))),
            Err(reason) => Err(reason.clone()),
        });
        match limits.collect::<Result<Vec<_>, String>>() {
            Ok(limits) => of(&GridLimit::between(&limits), value).into(),
            Err(reason) => Cell::Undefined(reason.into()),
        }
    }

    fn effort(&self) -> Effort {
        let Effort { iterations, transform_pairs } = self.state.effort();
        let [more, pairs] = self.heated.map_or([0.0; 2], |heated| [heated.iterations as f64, heated.transform_pairs]);
        Effort { iterations: iterations + more as u64, transform_pairs: transform_pairs + pairs }
    }

    fn residual(&self, name: &str) -> Cell {
        let found = self.state.residuals().into_iter().find(|(other, _)| *other == name);
        found.map_or(f64::NAN, |(_, residual)| residual).into()
    }

    fn worst(&self) -> f64 {
        worst(self.state.residuals().into_iter().map(|(_, residual)| residual))
    }

    fn has_converged(&self) -> bool {
        self.worst() <= self.tolerance && self.heated.is_none_or(|heated| heated.residual <= self.tolerance)
    }
}

impl Subject for Sliding {
    type Facts = SlidingFacts;
    type Context<'a> = SlidingContext<'a>;
    const COLUMNS: &'static [Column] = COLUMNS;
    const KEY: &'static str = "velocity";
}

type Column = crate::Column<Sliding>;

fn any(_: &SlidingFacts) -> bool {
    true
}

fn heat(facts: &SlidingFacts) -> bool {
    facts.heat
}

fn hardness(facts: &SlidingFacts) -> bool {
    facts.hardness
}

/// Returns a number of the plastic points.
fn of_plastic(at: &SlidingContext, of: fn(&Plastic) -> f64) -> Cell {
    at.state.solution.plastic.as_ref().map_or(f64::NAN, of).into()
}

/// A number of the flash temperature, or the reason why nothing is heated.
fn of_heat(at: &SlidingContext, of: fn(&Heated) -> f64) -> Cell {
    at.heated.map_or_else(|| Cell::undefined("the temperature was not found"), |heated| of(heated).into())
}

macro_rules! residual {
    ($name:literal, $meaning:literal) => {
        Column::new(concat!("residual_", $name), "1", &[(any, $meaning)], |at| at.residual($name))
            .at(concat!("residual.", $name))
            .in_file(|_| false)
            .by(Origin::Residual)
    };
}

/// Columns for the limit of a number on infinitely fine grids, its error, and the grid error of the number, like the
/// columns of [`State`](crate::State).
macro_rules! limits {
    ($name:literal, $unit:literal) => {
        [
            Column::new(
                concat!($name, "_limit"),
                $unit,
                &[(any, concat!("estimate of ", $name, " on an infinitely fine grid under the same load"))],
                |at| at.limit($name, |found, _| found.limit),
            )
            .with(refined)
            .by(Origin::Grid),
            Column::new(
                concat!($name, "_limit_error"),
                $unit,
                &[(any, concat!("error bound (95 %) of ", $name, "_limit"))],
                |at| at.limit($name, |found, _| found.half_width),
            )
            .with(refined)
            .by(Origin::Grid),
            Column::new(
                concat!($name, "_grid_error"),
                $unit,
                &[(any, concat!("grid error of ", $name, ": |", $name, " - limit| + limit_error"))],
                |at| at.limit($name, GridLimit::error_of),
            )
            .with(refined)
            .by(Origin::Grid),
        ]
    };
}

fn refined(facts: &SlidingFacts) -> bool {
    facts.refined
}

const FRICTION: [Column; 3] = limits!("friction", "1");
const HYSTERESIS: [Column; 3] = limits!("friction_hysteresis", "1");
const AREA: [Column; 3] = limits!("area_fraction", "1");

/// Numbers of a state, in the order in which they are printed.
const COLUMNS: &[Column] = &[
    Column::new("velocity", "length/time", &[(any, "velocity of the rigid surface relative to the body")], |at| {
        at.speed.into()
    })
    .head("velocity", Form::Size)
    .main(),
    Column::new("mean_pressure", "stress", &[(any, "mean pressure over the whole surface")], |at| {
        at.state.solution.mean_pressure.into()
    })
    .head("pressure", Form::Size)
    .main(),
    Column::new("p_star", "1", &[(any, "reduced pressure p/(E* g)")], |at| at.summary.p_star.into())
        .head("p*", Form::Size)
        .detail(),
    Column::new("approach", "length", &[(any, "rigid approach beyond first touch")], |at| {
        at.state.solution.approach.into()
    })
    .head("approach", Form::Size),
    Column::new("area_fraction", "1", &[(any, "contact area fraction: share of points with pressure")], |at| {
        at.summary.area_fraction.into()
    })
    .head("area", Form::Unsure)
    .main(),
    Column::new("mean_gap", "length", &[(any, "mean distance between the surfaces")], |at| at.summary.mean_gap.into()),
    Column::new("max_pressure", "stress", &[(any, "largest pressure")], |at| at.summary.max_pressure.into()),
    Column::new("plastic_fraction", "1", &[(any, "share of points at the hardness")], |at| {
        of_plastic(at, |plastic| plastic.fraction)
    })
    .with(hardness)
    .head("plastic", Form::Share),
    Column::new("plastic_volume", "length", &[(any, "mean plastic depth over the whole surface")], |at| {
        of_plastic(at, |plastic| plastic.volume)
    })
    .with(hardness)
    .head("depth", Form::Size)
    .detail(),
    Column::new(
        "friction",
        "1",
        &[(any, "friction coefficient, lateral force divided by load: friction_interface + friction_hysteresis")],
        |at| at.state.friction.into(),
    )
    .head("friction", Form::Unsure)
    .main(),
    Column::new(
        "friction_interface",
        "1",
        &[(any, "friction coefficient of the interface: mean shear divided by mean pressure")],
        |at| at.state.friction_interface.into(),
    ),
    Column::new(
        "friction_hysteresis",
        "1",
        &[(
            any,
            "friction coefficient from the pressure on the slopes of the deformed body: without interface friction, \
             the power lost in the body divided by velocity and mean pressure",
        )],
        |at| at.state.friction_hysteresis.into(),
    ),
    Column::new(
        "friction_slope",
        "1",
        &[(any, "friction coefficient from the pressure on the slopes of the rough surface")],
        |at| at.state.friction_slope.into(),
    )
    .head("by slopes", Form::Unsure),
    Column::new("dissipated_power", "stress*length/time", &[(any, "power lost in the body, per area")], |at| {
        at.state.dissipated_power.into()
    }),
    Column::new("persson_friction", "1", &[(any, "friction coefficient from Persson's theory")], |at| {
        at.persson.friction.into()
    })
    .at("persson.friction")
    .head("Persson", Form::Size),
    Column::new("persson_area_fraction", "1", &[(any, "contact area fraction from Persson's theory")], |at| {
        at.persson.area_fraction.into()
    })
    .at("persson.area_fraction"),
    Column::new("heat_mean_flux", "stress*length/time", &[(any, "mean frictional heat, per area and time")], |at| {
        of_heat(at, |heated| heated.mean_flux)
    })
    .at("heat.mean_flux")
    .with(heat)
    .on(Table::Heat, "heat", Form::Size)
    .detail(),
    Column::new("heat_fraction", "1", &[(any, "share of the heat that flows into the body")], |at| {
        of_heat(at, |heated| heated.fraction)
    })
    .at("heat.fraction")
    .with(heat)
    .on(Table::Heat, "into body", Form::Unsure),
    Column::new(
        "heat_max_rise",
        "temperature",
        &[(any, "largest temperature in contact, relative to the surface mean")],
        |at| of_heat(at, |heated| heated.max_rise),
    )
    .at("heat.max_rise")
    .with(heat)
    .on(Table::Heat, "max rise", Form::Unsure)
    .main(),
    Column::new(
        "heat_mean_rise",
        "temperature",
        &[(any, "mean temperature in contact, relative to the surface mean")],
        |at| of_heat(at, |heated| heated.mean_rise),
    )
    .at("heat.mean_rise")
    .with(heat)
    .on(Table::Heat, "mean rise", Form::Unsure),
    Column::new(
        "heat_residual",
        "1",
        &[(any, "largest temperature difference between both bodies, divided by the largest rise")],
        |at| of_heat(at, |heated| heated.residual),
    )
    .at("heat.residual")
    .with(heat)
    .by(Origin::Residual),
    Column::new("iterations", "1", &[(any, "solver iterations")], |at| at.effort().iterations.into())
        .count()
        .by(Origin::Way)
        .head("steps", Form::Whole)
        .effort(),
    Column::new("transform_pairs", "1", &[(any, "transform pairs of the solver")], |at| {
        at.effort().transform_pairs.into()
    })
    .by(Origin::Way)
    .head("pairs", Form::Whole)
    .effort(),
    Column::new("converged", "1", &[(any, "1 if the residual is at most the tolerance")], |at| {
        at.has_converged().into()
    })
    .flag(),
    Column::new("residual", "1", &[(any, "largest residual, recomputed from the pressure")], |at| at.worst().into())
        .at("")
        .by(Origin::Residual),
    residual!("complementarity", "sum(p gap) / (sum(p) h_rms), from the final fields"),
    residual!("load", "|mean p - prescribed| / prescribed, from the final fields"),
    residual!("negative_pressure", "max(0, -min p) / mean p, from the final fields"),
    residual!("penetration", "max(0, -min gap) / h_rms, from the final fields"),
    residual!("saturation", "largest gap / h_rms at points at the hardness").with(hardness),
    AREA[0],
    AREA[1],
    AREA[2],
    FRICTION[0],
    FRICTION[1],
    FRICTION[2],
    HYSTERESIS[0],
    HYSTERESIS[1],
    HYSTERESIS[2],
    Column::new("seconds", "s", &[(any, "wall time")], |at| at.seconds.into()).by(Origin::Clock),
];
