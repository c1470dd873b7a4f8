//! Figures of a path.

use std::path::{Path, PathBuf};

use gfmd_field::Share;
use gfmd_files::contiguous;
use gfmd_input::rows;
use gfmd_input::source::Surface;
use gfmd_plasticity::PlasticState;
use gfmd_plot::Chart;
use gfmd_run::series::Places;
use ndarray::{Array2, ArrayView2};

use super::Report;
use gfmd_input::failure::Failure;
use gfmd_report::figures::{Scene, named};
use gfmd_report::path::{Course, Drawing};
use gfmd_report::strain::{imprint_of, section_of};
use gfmd_report::wear::{depth_of, profile};

/// Whole fields of a body that yields.
pub(super) struct Strained {
    displacement: Array2<f64>,
    depths: Vec<f64>,
    /// κ of each cell.
    strains: Vec<Array2<f64>>,
}

impl Strained {
    /// Gathers the fields of a state at the first process; `None` at the others.
    pub(super) fn of(surface: &Surface, state: &PlasticState) -> Option<Self> {
        let gather = |share: &Share, own: ArrayView2<f64>| match share.is_whole() {
            true => Some(own.to_owned()),
            false => rows::gathered(share, own),
        };
        let displacement = gather(&surface.share, state.plastic_displacement.view());
        let cells = 0..state.cells().len();
        let strains: Vec<Option<Array2<f64>>> =
            cells.map(|cell| gather(state.rows(cell), state.equivalent_plastic_strain(cell).view())).collect();
        let depths = state.cells().iter().map(|cell| cell.depth).collect();
        Some(Self { displacement: displacement?, depths, strains: strains.into_iter().collect::<Option<_>>()? })
    }
}

/// Draws the parts of the path, the step with the largest contact, and of its last step the lost `depth`, or the strain
/// of a body that yields.
pub(super) fn draw(
    prefix: &Path,
    report: &Report,
    places: &Places,
    scene: &Scene,
    (surface, depth, strained): (&Surface, Option<ArrayView2<f64>>, Option<&Strained>),
) -> Result<Vec<PathBuf>, Failure> {
    let unit = surface.unit();
    let mut files = scene.draw(prefix)?;
    let column = |name: &str| report.steps.iter().map(|step| step.value(name).unwrap_or(f64::NAN)).collect();
    let units = report.head.units();
    let course = Course {
        column: &column,
        direction: report.direction,
        waypoints: (0..report.steps.len()).filter(|step| places.of(*step).is_some()).collect(),
        relaxes: report.head.relaxation.is_some(),
        modulus: report.head.e_star,
        unit_pressure: report.head.e_star * report.head.rms_gradient,
        unit,
        units: &units,
    };
    for Drawing { name, panels, .. } in course.drawings() {
        let panels = panels.into_iter().map(|(panel, _)| panel).collect();
        let chart = Chart { share_y: false, ..Chart::new(panels) };
        files.extend(chart.save(&named(prefix, name))?);
    }
    if let Some(Strained { displacement, depths, strains }) = strained {
        imprint_of(&surface.grid, &contiguous(displacement), unit, |drawn| {
            files.extend(drawn.save(&named(prefix, "imprint"))?);
            Ok::<_, Failure>(())
        })?;
        let drawn = section_of(&surface.grid, depths, strains, unit, |drawn| drawn.save(&named(prefix, "strain")));
        files.extend(drawn.transpose()?.into_iter().flatten());
    }
    let Some(depth) = depth else { return Ok(files) };
    let (heights, depth) = (contiguous(&surface.heights), contiguous(&depth));
    if let Some(chart) = profile(&surface.grid, [&heights, &depth], unit) {
        files.extend(chart.save(&named(prefix, "profile"))?);
    }
    if !surface.grid.is_line() {
        depth_of(&surface.grid, &depth, unit, |drawn| {
            files.extend(drawn.save(&named(prefix, "depth"))?);
            Ok::<_, Failure>(())
        })?;
    }
    Ok(files)
}
