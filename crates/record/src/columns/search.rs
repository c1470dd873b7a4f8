//! Effort and residuals of a search.

use gfmd_problem::Unknown;

use super::Column;
use crate::Cell;
use crate::column::{Form, Origin};
use crate::when::{any, between, friction, hardness, law, loads, of_a_law, path, steep, wall_on_path, yields};

/// Definition of a residual under a law, with its stress scale.
macro_rules! per_stress {
    ($what:literal) => {
        concat!(
            $what,
            ", divided by the stress scale (larger of the largest traction and the softest stiffness times \
                        h_rms)"
        )
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
    Column::new("extra_solves", "1", &[(any, "additional solves for the energy lost in the step")], |at| {
        at.step.as_ref().map_or(Cell::Real(f64::NAN), |(step, _)| step.extra_solves.into())
    })
    .count()
    .with(path)
    .by(Origin::Way),
    Column::new(
        "increments",
        "1",
        &[(any, "number of equal increments of the step, raised until the result did not change")],
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
        &[(any, "number of volume operators (plastic strain and pressure to strain), including extra solves")],
        |at| at.step.as_ref().map_or(at.effort, |(step, _)| step.effort).iterations.into(),
    )
    .count()
    .with(yields)
    .by(Origin::Way),
    Column::new(
        "iterations",
        "1",
        &[
            (yields, "number of volume operators, as in operators"),
            (path, "solver steps, including extra solves"),
            (any, "solver iterations or time steps"),
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
            (path, "pairs of forward and inverse transforms of one component, including extra solves"),
            (any, "pairs of forward and inverse real transforms of the full grid"),
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
            (
                yields,
                "rms unbalanced force on nodes below the surface, divided by the rms force on them, from the \
                      final strain",
            ),
            (any, per_stress!("largest unbalanced force per area, from the final fields")),
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
            (law, "sum(p gap) / (sum(p) h_rms) with the wall pressure p, from the final fields"),
            (between, "sum(p gap) / (sum(p) h_rms), from the final fields; larger of the two faces"),
            (any, "sum(p gap) / (sum(p) h_rms), from the final fields"),
        ]
    )
    .with(|facts| loads(facts) || !of_a_law(facts)),
    residual!(
        "penetration",
        &[
            (between, "max(0, -min gap) / h_rms, from the final fields; larger of the two faces"),
            (any, "max(0, -min gap) / h_rms, from the final fields"),
        ]
    ),
    Column::new(
        "residual_negative_pressure",
        "1",
        &[
            (law, per_stress!("largest tension that the wall would have to carry, from the final fields")),
            (between, "max(0, -min p) / mean p, from the final fields; larger of the two faces"),
            (any, "max(0, -min p) / mean p, from the final fields"),
        ],
        |at| at.residual(if law(at.facts) { "wall_tension" } else { "negative_pressure" }).into(),
    )
    .at("residual.negative_pressure")
    .in_file(loads)
    .with(|facts| loads(facts) || wall_on_path(facts))
    .by(Origin::Residual),
    residual!("wall_tension", &[(any, "largest tension that the wall would have to carry")])
        .with(|facts| path(facts) && of_a_law(facts)),
    residual!(
        "load",
        &[
            (law, per_stress!("|mean p - prescribed|, from the final fields (0 if the approach is prescribed)")),
            (
                between,
                "|mean p - prescribed| / prescribed, larger of the two faces; under a prescribed approach, the \
                 difference between the mean pressures on both faces divided by their mean",
            ),
            (any, "|mean p - prescribed| / prescribed, from the final fields"),
        ]
    ),
    residual!("friction", &[(any, "largest deviation of the shear from its law, divided by the largest limit")])
        .with(friction),
    residual!("excess", &[(any, "largest excess of the shear over its limit, divided by the largest limit")])
        .with(friction),
    residual!(
        "saturation",
        &[
            (between, "largest gap / h_rms at points at the hardness; larger of the two faces"),
            (any, "largest gap / h_rms at points at the hardness"),
        ]
    )
    .with(hardness),
    residual!(
        "yield",
        &[(
            any,
            "largest excess of the equivalent stress over the yield stress, divided by the initial \
                                yield stress"
        )]
    )
    .with(yields),
    residual!(
        "flow",
        &[(any, "largest error of a plastic strain increment, divided by the largest equivalent strain")]
    )
    .with(yields),
    residual!(
        "flow_complementarity",
        &[(
            any,
            "largest product of strain increment and stress below yield, divided by the largest strain and yield \
                 stress"
        )]
    )
    .with(yields),
    residual!("bottom", &[(any, "1 if the lowest cell yields although its layer continues below it, else 0")])
        .with(yields),
    residual!(
        "lateral_traction",
        &[(
            any,
            "largest lateral traction left by the dynamics, divided by the largest \
                                           pressure"
        )]
    )
    .with(|facts| facts.unknown == Unknown::All)
    .by(Origin::Way),
    residual!(
        "lateral_displacement",
        &[(any, "last change of the lateral displacement / h_rms: its consistency with the pressure")]
    )
    .with(steep),
    Column::new(
        "seconds",
        "s",
        &[(
            any,
            "wall time of a load: solution and, for a contact, stiffness, statistics and flow; excludes finer \
                 grids",
        )],
        |at| at.seconds.into(),
    )
    .by(Origin::Clock),
];

/// Residual of the force balance of a law under a load.
pub(super) const BALANCE: &[Column] = &[Column::new(
    "residual_equilibrium",
    "1",
    &[(any, per_stress!("largest unbalanced force per area, from the final fields"))],
    |at| at.residual("equilibrium").into(),
)
.with(|facts| loads(facts) && law(facts))
.by(Origin::Residual)];
