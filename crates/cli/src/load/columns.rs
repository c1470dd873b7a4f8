//! The scalars of a load in a file: names, units and meanings.

use gfmd_contact::Boundary;
use gfmd_measure::Column;

use super::{FlowRecord, LoadRecord};

/// Appends the scale of stress to the meaning of a residual that is a stress.
macro_rules! per_stress {
    ($what:literal) => {
        concat!($what, " / the stress scale (the largest traction, or the softest stiffness times h_rms if more)")
    };
}

/// All scalars, in the order of the files.
pub const SCALARS: &[Column<LoadRecord>] = &[
    Column::new("mean_pressure", "stress", "mean pressure over the whole surface", |r| r.mean_pressure),
    Column::new("p_star", "1", "reduced pressure p/(E* g)", |r| r.p_star),
    Column::new("displacement", "length", "rigid approach beyond first touch", |r| r.displacement),
    Column::new("area_fraction", "1", "contact area fraction, points in contact over all points", |r| r.area_fraction),
    Column::new(
        "area_fraction_corrected",
        "1",
        "contact area fraction less the excess of the pixels along the perimeter (Yastrebov et al. 2017)",
        |r| r.area_fraction_corrected,
    ),
    Column::new("kappa", "1", "area_fraction / p_star", |r| r.kappa),
    Column::new("kappa_corrected", "1", "area_fraction_corrected / p_star", |r| r.kappa_corrected),
    Column::new("contact_nodes", "1", "number of points in contact", |r| r.contact_nodes as f64),
    Column::new("boundary_links", "1", "neighbouring pairs with one point in contact and one not", |r| {
        r.boundary_links as f64
    }),
    Column::new("mean_gap", "length", "mean distance between the surfaces", |r| r.mean_gap),
    Column::new("max_pressure", "stress", "largest pressure", |r| r.max_pressure),
    Column::new("mean_pressure_in_contact", "stress", "mean pressure over the points in contact", |r| {
        r.mean_pressure_in_contact
    }),
    Column::new(
        "pressure_deviation_in_contact",
        "stress",
        "standard deviation of the pressure over the points in contact",
        |r| r.pressure_deviation_in_contact,
    ),
    Column::new("pressure_moment_2", "stress^2", "mean square pressure over the whole surface", |r| {
        r.pressure_moment_2
    }),
    Column::new("elastic_energy", "stress*length", "elastic energy per area of the surface", |r| r.elastic_energy),
    Column::new("iterations", "1", "iterations or time steps of the solver", |r| r.iterations as f64),
    Column::new("transform_pairs", "1", "forward and inverse real transforms of the full grid, in pairs", |r| {
        r.transform_pairs
    }),
    Column::new("converged", "1", "1 if all residuals of this load are at most the tolerance", |r| {
        f64::from(u8::from(r.converged))
    }),
    Column::new("residual_complementarity", "1", "sum(p gap) / (sum(p) h_rms), from the final fields", |r| {
        r.residual.complementarity
    }),
    Column::new("residual_penetration", "1", "max(0, -min gap) / h_rms, from the final fields", |r| {
        r.residual.penetration
    }),
    Column::new("residual_negative_pressure", "1", "max(0, -min p) / mean p, from the final fields", |r| {
        r.residual.negative_pressure
    }),
    Column::new("residual_load", "1", "|mean p - asked| / asked, from the final fields", |r| r.residual.load),
];

/// The stiffness of a contact.
pub const STIFFNESS: &[Column<LoadRecord>] = &[
    Column::new(
        "stiffness",
        "stress/length",
        "d(mean pressure)/d(displacement) with the points in contact kept, those at the hardness with their pressure; NaN \
         where it is infinite (full contact with a fixed mean level) or not computed: the attribute undefined says why",
        |r| r.stiffness,
    ),
    Column::new(
        "stiffness_error",
        "1",
        "relative error of the stiffness, from the residual of its linear problem",
        |r| r.stiffness_error,
    ),
];

/// The force of a contact with free boundaries.
pub const FORCE: Column<LoadRecord> =
    Column::new("force", "stress*length^2", "force, of a line per length across it (stress*length)", |r| {
        r.force.unwrap_or(f64::NAN)
    });

fn flag(of: Option<[bool; 2]>, axis: usize) -> f64 {
    of.map_or(f64::NAN, |flags| f64::from(u8::from(flags[axis])))
}

/// The scalars of the statistics of a contact.
pub const STATISTICS: &[Column<LoadRecord>] = &[
    Column::new("patches", "1", "number of connected patches of points in contact", |r| {
        r.patches.map_or(f64::NAN, |patches| patches.count as f64)
    }),
    Column::new("largest_patch_fraction", "1", "points of the largest patch over all points", |r| {
        r.patches.map_or(f64::NAN, |patches| patches.largest_fraction)
    }),
    Column::new(
        "percolates_x",
        "1",
        "1 if a patch winds around the cell along x, with free boundaries if it spans the surface",
        |r| flag(r.patches.map(|patches| patches.percolates), 0),
    ),
    Column::new("percolates_y", "1", "the same along y", |r| flag(r.patches.map(|patches| patches.percolates), 1)),
    Column::new(
        "conductance",
        "1/length",
        "conductance per area of the points in contact between two conductors, times the sum of their resistivities: current \
         density over the potential difference less that of the bulk, with free boundaries over all of it; infinite if all points \
         of a periodic surface touch",
        |r| r.conductance.unwrap_or(f64::NAN),
    ),
];

/// A number of the flow along an axis.
fn along(load: &LoadRecord, axis: usize, of: fn(&FlowRecord) -> [[f64; 2]; 2]) -> f64 {
    load.flow.map_or(f64::NAN, |flow| of(&flow)[axis][axis])
}

/// The scalars of the flow through the gap.
pub const FLOW: &[Column<LoadRecord>] = &[
    Column::new(
        "flow_xx",
        "1",
        "mean flux along x by a mean pressure gradient along x, over that of a uniform gap equal to the mean gap",
        |r| r.flow.map_or(f64::NAN, |flow| flow.conductivity[0][0]),
    ),
    Column::new("flow_xy", "1", "the same along x by a gradient along y", |r| {
        r.flow.map_or(f64::NAN, |flow| flow.conductivity[0][1])
    }),
    Column::new("flow_yx", "1", "the same along y by a gradient along x", |r| {
        r.flow.map_or(f64::NAN, |flow| flow.conductivity[1][0])
    }),
    Column::new("flow_yy", "1", "the same along y by a gradient along y", |r| {
        r.flow.map_or(f64::NAN, |flow| flow.conductivity[1][1])
    }),
    Column::new(
        "flow_xx_limit",
        "1",
        "estimate of flow_xx on an infinitely fine grid (grids of the same surface; hard wall on half-spaces only)",
        |r| along(r, 0, |flow| flow.conductivity_limit),
    ),
    Column::new("flow_xx_limit_error", "1", "95 % of the errors of flow_xx_limit are smaller", |r| {
        along(r, 0, |flow| flow.conductivity_limit_error)
    }),
    Column::new(
        "flow_xx_grid_error",
        "1",
        "error of flow_xx by the finite grid: |flow_xx - limit| + limit_error",
        |r| along(r, 0, |flow| flow.conductivity_grid_error),
    ),
    Column::new("flow_yy_limit", "1", "as flow_xx_limit, along y", |r| along(r, 1, |flow| flow.conductivity_limit)),
    Column::new("flow_yy_limit_error", "1", "as flow_xx_limit_error, along y", |r| {
        along(r, 1, |flow| flow.conductivity_limit_error)
    }),
    Column::new("flow_yy_grid_error", "1", "as flow_xx_grid_error, along y", |r| {
        along(r, 1, |flow| flow.conductivity_grid_error)
    }),
    Column::new("flow_percolates_x", "1", "1 if the gap lets a fluid through along x", |r| {
        flag(r.flow.map(|flow| flow.percolates), 0)
    }),
    Column::new("flow_percolates_y", "1", "the same along y", |r| flag(r.flow.map(|flow| flow.percolates), 1)),
    Column::new(
        "flow_residual",
        "1",
        "largest of what is missing in a cell and the deviations of sections and power, over the mean flow",
        |r| r.flow.map_or(f64::NAN, |flow| flow.residual),
    ),
];

/// The scalars of a contact with a hardness.
pub const PLASTIC_SCALARS: &[Column<LoadRecord>] = &[
    Column::new("plastic_fraction", "1", "points whose pressure is the hardness over all points", |r| {
        r.plastic_fraction.unwrap_or(f64::NAN)
    }),
    Column::new("plastic_volume", "length", "mean plastic depth over the whole surface", |r| {
        r.plastic_volume.unwrap_or(f64::NAN)
    }),
    Column::new("residual_saturation", "1", "largest gap / h_rms where the pressure is the hardness", |r| {
        r.residual.saturation.unwrap_or(f64::NAN)
    }),
];

/// The scalars of a contact with finite slopes.
pub const SLOPE_SCALARS: &[Column<LoadRecord>] = &[
    Column::new("mean_shear_x", "stress", "mean traction along x that holds the rigid surface in its place", |r| {
        r.mean_shear.map_or(f64::NAN, |[x, _]| x)
    }),
    Column::new("mean_shear_y", "stress", "the same along y", |r| r.mean_shear.map_or(f64::NAN, |[_, y]| y)),
    Column::new(
        "projected_area_fraction",
        "1",
        "contact area of the deformed surface, projected onto the plane of the rigid one, over the area of the cell",
        |r| r.projected_area_fraction.unwrap_or(f64::NAN),
    ),
    Column::new(
        "residual_lateral_displacement",
        "1",
        "last change of the lateral displacement over h_rms, which is consistent with the pressure to that extent",
        |r| r.residual.lateral_displacement.unwrap_or(f64::NAN),
    ),
];
/// The residual of the lateral components, if they are unknown, too.
pub const LATERAL_TRACTION: Column<LoadRecord> = Column::new(
    "residual_lateral_traction",
    "1",
    "largest lateral traction that the dynamics left / largest pressure",
    |r| r.residual.lateral_traction.unwrap_or(f64::NAN),
);
/// A scalar of the lower face.
macro_rules! lower {
    ($name:literal, $units:literal, $meaning:literal, $value:expr) => {
        Column::new(concat!("lower_", $name), $units, $meaning, |r| r.lower.as_ref().map_or(f64::NAN, $value))
    };
}

/// The scalars of the lower face of a slab between two surfaces.
pub const LOWER: &[Column<LoadRecord>] = &[
    lower!("mean_pressure", "stress", "mean pressure over the whole lower surface", |r| r.mean_pressure),
    lower!("displacement", "length", "part of the approach at the lower face", |r| r.displacement),
    lower!("area_fraction", "1", "contact area fraction of the lower face", |r| r.area_fraction),
    lower!("area_fraction_corrected", "1", "the same less the excess of the pixels along the perimeter", |r| {
        r.area_fraction_corrected
    }),
    lower!("contact_nodes", "1", "number of points in contact at the lower face", |r| r.contact_nodes as f64),
    lower!("boundary_links", "1", "neighbouring pairs with one point in contact and one not, at the lower face", |r| {
        r.boundary_links as f64
    }),
    lower!("mean_gap", "length", "mean distance between lower face and lower surface", |r| r.mean_gap),
    lower!("max_pressure", "stress", "largest pressure on the lower face", |r| r.max_pressure),
    lower!("mean_pressure_in_contact", "stress", "mean pressure over the points in contact at the lower face", |r| {
        r.mean_pressure_in_contact
    }),
    lower!("residual_complementarity", "1", "sum(p gap) / (sum(p) h_rms) of the lower face", |r| {
        r.residual.complementarity
    }),
    lower!("residual_penetration", "1", "max(0, -min gap) / h_rms of the lower face", |r| r.residual.penetration),
    lower!("residual_negative_pressure", "1", "max(0, -min p) / mean p of the lower face", |r| {
        r.residual.negative_pressure
    }),
    lower!("residual_load", "1", "|mean p - asked| / asked of the lower face, or as residual_load", |r| r
        .residual
        .load),
];

/// The scalars whose meaning is different between two surfaces. All others are of the upper face.
const MEANINGS_WITH_LOWER: &[(&str, &str)] = &[
    ("displacement", "approach of the two rigid surfaces beyond the distance at which both touch the undeformed slab"),
    ("elastic_energy", "elastic energy of the slab per area, by the pressures on both faces"),
    ("residual_complementarity", "sum(p gap) / (sum(p) h_rms), from the final fields, the larger of the two faces"),
    ("residual_penetration", "max(0, -min gap) / h_rms, from the final fields, the larger of the two faces"),
    ("residual_negative_pressure", "max(0, -min p) / mean p, from the final fields, the larger of the two faces"),
    (
        "residual_load",
        "|mean p - asked| / asked, the larger of the two faces; if the approach is prescribed the difference of their \
         mean pressures over its mean",
    ),
    ("stiffness", "NaN"),
    ("stiffness_error", "NaN"),
];

/// The wall time of a load, which is not in [`SCALARS`] because it differs between identical runs.
pub const SECONDS: Column<LoadRecord> = Column::new("seconds", "s", "wall time of the solve", |r| r.seconds);

/// The scalars of [`LawRecord`](super::LawRecord); NaN for a hard wall alone.
pub const LAW_SCALARS: &[Column<LoadRecord>] = &[
    Column::new("interface_energy", "stress*length", "energy of the contact law per area of the surface", |r| {
        r.law.map_or(f64::NAN, |law| law.interface_energy)
    }),
    Column::new(
        "passed_instability",
        "1",
        "1 if directions of negative curvature were met on the way from the last load",
        |r| r.law.map_or(f64::NAN, |law| f64::from(u8::from(law.passed_instability))),
    ),
    Column::new(
        "lowest_curvature",
        "1",
        "lowest curvature met in the last search for a step, over the elastic curvature",
        |r| r.law.map_or(f64::NAN, |law| law.lowest_curvature),
    ),
    Column::new(
        "residual_equilibrium",
        "1",
        per_stress!("largest unbalanced force per area, from the final fields,"),
        |r| r.law.map_or(f64::NAN, |law| law.residual_equilibrium),
    ),
];

/// The scalars whose meaning is different if a law acts across the gap. In contact are then the points that are repelled:
/// those under pressure of the wall, or all with a positive pressure if there is no wall.
const MEANINGS_WITH_LAW: &[(&str, &str)] = &[
    ("area_fraction", "contact area fraction, points that are repelled over all points"),
    ("kappa", "area_fraction / p_star; NaN if attraction carries the load"),
    ("kappa_corrected", "area_fraction_corrected / p_star; NaN if attraction carries the load"),
    ("contact_nodes", "number of points that are repelled"),
    ("boundary_links", "neighbouring pairs with one point repelled and one not"),
    ("max_pressure", "largest repulsive pressure"),
    ("mean_pressure_in_contact", "mean repulsive pressure over the points that are repelled"),
    ("pressure_deviation_in_contact", "standard deviation of the repulsive pressure over the points that are repelled"),
    ("pressure_moment_2", "mean square repulsive pressure over the whole surface"),
    ("converged", "1 if all five residuals are at most the tolerance"),
    ("residual_complementarity", "sum(p gap) / (sum(p) h_rms) with p the pressure of the wall, from the final fields"),
    (
        "residual_negative_pressure",
        per_stress!("largest tension that the wall would have to hold, from the final fields,"),
    ),
    ("residual_load", per_stress!("|mean p - asked| from the final fields, 0 if the approach is prescribed,")),
];

/// The properties that decide which scalars and fields a load has.
#[derive(Clone, Copy, Debug)]
pub struct Recording {
    /// True if a law acts across the gap.
    pub with_law: bool,
    /// The surroundings of the surface.
    pub boundary: Boundary,
    /// True with a hardness.
    pub is_plastic: bool,
    /// True with finite slopes.
    pub is_steep: bool,
    /// True with patches and conductance.
    pub statistics: bool,
    /// True with the flow through the gap.
    pub flow: bool,
    /// Number of lateral components that are unknown, too.
    pub lateral: usize,
    /// True between two surfaces.
    pub is_squeezed: bool,
}

impl Recording {
    /// The loads of a contact without plastic depth, statistics and flow.
    pub fn plain(with_law: bool, boundary: Boundary) -> Self {
        Self {
            with_law,
            boundary,
            is_plastic: false,
            is_steep: false,
            statistics: false,
            flow: false,
            lateral: 0,
            is_squeezed: false,
        }
    }

    /// True if the pressure does not tell the points in contact: beside that of a wall it is an attraction, and where a law
    /// without a wall vanishes, its sign is that of rounding errors.
    pub fn keeps_repulsion(self) -> bool {
        self.with_law
    }
}

/// The scalars of a load in a file. Names and units are common to all contacts; the meanings depend on the interaction
/// between the surfaces.
pub fn columns(kind: Recording) -> Vec<Column<LoadRecord>> {
    let Recording { with_law, boundary, is_plastic, is_steep, statistics, flow, lateral, is_squeezed, .. } = kind;
    let mut columns: Vec<Column<LoadRecord>> = SCALARS.iter().chain(STIFFNESS).chain([&SECONDS]).copied().collect();
    if boundary == Boundary::Free {
        columns.push(FORCE);
    }
    if is_plastic {
        columns.extend_from_slice(PLASTIC_SCALARS);
    }
    if is_steep {
        columns.extend_from_slice(SLOPE_SCALARS);
    } else if lateral > 0 {
        columns.push(LATERAL_TRACTION);
    }
    if statistics {
        columns.extend_from_slice(STATISTICS);
    }
    if flow {
        columns.extend_from_slice(FLOW);
    }
    let meanings = match (with_law, is_squeezed) {
        (true, _) => MEANINGS_WITH_LAW,
        (_, true) => MEANINGS_WITH_LOWER,
        _ => &[],
    };
    for column in &mut columns {
        if let Some((_, meaning)) = meanings.iter().find(|(name, _)| *name == column.name) {
            column.long_name = meaning;
        }
    }
    if with_law {
        columns.extend_from_slice(LAW_SCALARS);
    }
    if is_squeezed {
        columns.extend_from_slice(LOWER);
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_law_has_the_same_names_with_meanings_of_its_own() {
        let [wall, law] = [false, true].map(|law| columns(Recording::plain(law, Boundary::Periodic)));
        let meaning = |columns: &[Column<LoadRecord>], name: &str| {
            columns.iter().find(|column| column.name == name).map(|column| column.long_name)
        };
        for (name, own) in MEANINGS_WITH_LAW {
            assert_eq!(meaning(&law, name), Some(*own));
            assert!(meaning(&wall, name).is_some_and(|of_wall| of_wall != *own), "{name}");
        }
        let names = wall.iter().zip(&law).all(|(a, b)| (a.name, a.units) == (b.name, b.units));
        assert!(names && law.len() == wall.len() + LAW_SCALARS.len());
    }
}
