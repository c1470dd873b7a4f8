//! Effort and residuals of a search.

use gfmd_problem::Unknown;

use super::Column;
use crate::Cell;
use crate::column::{Form, Origin};
use crate::when::{any, between, friction, hardness, law, loads, of_a_law, path, steep, wall_on_path, yields};

/// Definition of a residual under a law, with its stress scale.
macro_rules! per_stress {
    ($what:literal) => {
        concat!($what, " / the stress scale (the largest traction, or the softest stiffness times h_rms if more)")
    };
}

/// Residual by its name in the state.
macro_rules! residual {
    ($name:literal, $meanings:expr) => {
        Column::new(concat!("residual_", $name), "1", $meanings, |at| at.residual($name).into())
            .at(concat!("residual.", $name))
            .in_file(loads)
            .by(Origin::Residual)
    };
}

/// Columns of effort, residuals and time of a search.
pub(super) const COLUMNS: &[Column] = &[
    Column::new("extra_solves", "1", &[(any, "further solves to find the energy lost in the step")], |at| {
        at.step.as_ref().map_or(Cell::Real(f64::NAN), |(step, _)| step.extra_solves.into())
    })
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
    .head("increments", Form::Whole)
    .effort(),
    Column::new(
        "operators",
        "1",
        &[(any, "volume operators, from plastic strain and pressure to strain, extra solves included")],
        |at| at.step.as_ref().map_or(at.effort, |(step, _)| step.effort).iterations.into(),
    )
    .count()
    .with(yields)
    .by(Origin::Way),
    Column::new(
        "iterations",
        "1",
        &[
            (yields, "volume operators, as in operators"),
            (path, "steps of the solver, extra solves included"),
            (any, "iterations or time steps of the solver"),
        ],
        |at| at.step.as_ref().map_or(at.effort, |(step, _)| step.effort).iterations.into(),
    )
    .count()
    .by(Origin::Way)
    .head("steps", Form::Whole)
    .effort(),
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
    .head("pairs", Form::Whole)
    .effort(),
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
        &[
            (yields, "rms unbalanced force on nodes below the surface / rms force on them, from the final strain"),
            (any, per_stress!("largest unbalanced force per area, from the final fields,")),
        ],
        |at| at.residual("equilibrium").into(),
    )
    .at("residual.equilibrium")
    .with(|facts| path(facts) && (of_a_law(facts) || yields(facts)))
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
                "|mean p - asked| / asked, the larger of the two faces; if the approach is prescribed the difference \
                 of their mean pressures over its mean",
            ),
            (any, "|mean p - asked| / asked, from the final fields"),
        ]
    ),
    residual!("friction", &[(any, "largest distance of the shear from its law / the largest limit")]).with(friction),
    residual!("excess", &[(any, "largest excess of the shear over its limit / the largest limit")]).with(friction),
    residual!(
        "saturation",
        &[
            (between, "largest gap / h_rms where the pressure is the hardness, the larger of the two faces"),
            (any, "largest gap / h_rms where the pressure is the hardness"),
        ]
    )
    .with(hardness),
    residual!("yield", &[(any, "largest excess of the equivalent stress over the yield stress / the initial one")])
        .with(yields),
    residual!("flow", &[(any, "largest error of an increment of plastic strain / the largest equivalent strain")])
        .with(yields),
    residual!(
        "flow_complementarity",
        &[(any, "largest increment of strain times the stress missing to yield / the largest strain and yield stress")]
    )
    .with(yields),
    residual!("bottom", &[(any, "1 if the lowest cell yields although its layer goes on below it, else 0")])
        .with(yields),
    residual!("lateral_traction", &[(any, "largest lateral traction that the dynamics left / largest pressure")])
        .with(|facts| facts.unknown == Unknown::All)
        .by(Origin::Way),
    residual!(
        "lateral_displacement",
        &[(
            any,
            "last change of the lateral displacement over h_rms, which is consistent with the pressure to that extent"
        )]
    )
    .with(steep),
    Column::new(
        "seconds",
        "s",
        &[(any, "wall time of a load: solution and, of a contact, stiffness, statistics, flow; without finer grids")],
        |at| at.seconds.into(),
    )
    .by(Origin::Clock),
];

/// Residual of the force balance of a law under a load.
pub(super) const BALANCE: &[Column] = &[Column::new(
    "residual_equilibrium",
    "1",
    &[(any, per_stress!("largest unbalanced force per area, from the final fields,"))],
    |at| at.residual("equilibrium").into(),
)
.with(|facts| loads(facts) && law(facts))
.by(Origin::Residual)];
