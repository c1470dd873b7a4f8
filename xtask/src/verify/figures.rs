//! Figures of docs/validation.md, modelled on the figures of the thesis.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use gfmd_body::Interior;
use gfmd_cli::body::{Quantity, draw_middle};
use gfmd_field::Grid;
use gfmd_green::{Body, Material};
use gfmd_input::failure::Failure;
use gfmd_plot::{Axis, Chart, Mark, Panel, Series};
use gfmd_tests::Reference;
use ndarray::Ix3;

/// Names and captions of the figures.
pub(super) const CAPTIONS: [(&str, &str); 10] = [
    (
        "stiffness",
        "Stiffness of a bonded slab (ν = 0.33) against the wavenumber; broken: limits of tables 3.1 and 3.2.",
    ),
    (
        "decay",
        "Displacement below a cosine wave without lateral surface displacement, against height, three wavelengths.",
    ),
    ("wave-uz", "Figure 3.10: u_z below cos(2πx/L) on a slab of height L, without lateral surface displacement."),
    ("wave-ux", "Figure 3.11: u_x below this wave."),
    (
        "punch-ux",
        "u_x below a sticking punch a quarter of the cell wide, on the plane y = L/2, as in all figures below.",
    ),
    ("punch-uz", "u_z below the punch."),
    ("punch-sxx", "σ_xx below the punch, GPa (figure 4.10 is captioned x = L/2: docs/source/README.md)."),
    ("punch-szz", "σ_zz below the punch, GPa."),
    ("punch-sxz", "σ_xz below the punch, GPa (it vanishes on x = L/2, the plane in the caption of figure 4.11)."),
    ("punch-mises", "Von Mises stress below the punch, GPa."),
];

/// Writes `PREFIX-name.svg` and `PREFIX-name.png` of each figure.
pub(super) fn draw(prefix: &Path, reference: &Reference) -> Result<Vec<PathBuf>, Failure> {
    let failed = |error: &dyn ToString| Failure::computation(error.to_string());
    let named = |what: &str| prefix.with_file_name(format!("validation-{what}"));
    let material = Material::from_young(70.0, 0.33).map_err(|error| failed(&error))?;
    let slab = |height: f64| Body::slab(material, height).map_err(|error| failed(&error));
    let unit_slab = slab(1.0)?;
    let mut files = Vec::new();
    for (name, chart) in [("stiffness", stiffness(&unit_slab)), ("decay", decay(&unit_slab)?)] {
        files.extend(chart.save(&named(name)).map_err(|error| failed(&error))?);
    }

    let line = Grid::line(128, 1.0).map_err(|error| failed(&error))?;
    let mut wave = vec![0.0; 256];
    (0..128).for_each(|i| wave[128 + i] = (TAU * i as f64 / 128.0).cos());
    let interior = Interior::new(&unit_slab, line, &wave).map_err(|error| failed(&error))?;
    files.extend(draw_middle(&interior, &[Quantity::Displacement], (129, 1.0), &named("wave"), "*L*")?);

    let height = 1.27;
    let surface = reference.array::<Ix3>("punch3d_sticking_zm1_nu033/discrete_strict_u_n128.npy");
    let surface = surface.map_err(|error| failed(&error))?.permuted_axes([2, 0, 1]);
    let (body, grid) = (slab(height)?, Grid::square(128, height).map_err(|error| failed(&error))?);
    let surface: Vec<f64> = surface.iter().copied().collect();
    let interior = Interior::new(&body, grid, &surface).map_err(|error| failed(&error))?;
    let drawn = [Quantity::Displacement, Quantity::Stress, Quantity::VonMises];
    files.extend(draw_middle(&interior, &drawn, (129, height), &named("punch"), "µm")?);
    Ok(files)
}

/// Draws the entries of K in units of C44/zm, and their limits.
fn stiffness(slab: &Body) -> Chart {
    let material = *slab.material();
    let (shear, s) = (material.shear_modulus(), material.s());
    let numbers = || (0..=120).map(|i| 10f64.powf(-2.0 + f64::from(i) / 30.0));
    let curve =
        |label, hue, value: &dyn Fn(f64) -> f64| Series::line(label, hue, numbers().map(|q| (q, value(q) / shear)));
    let limit = |hue, values: [(f64, f64); 2]| Series { mark: Mark::Dashes, ..Series::line("", hue, values) };
    let series = vec![
        curve("*K*_N", 0, &|q| slab.stiffness_blocks(q).normal),
        curve("*K*_L", 1, &|q| slab.stiffness_blocks(q).longitudinal),
        curve("*K*_T", 2, &|q| slab.stiffness_blocks(q).transverse),
        curve("1/*G*_{zz}", 3, &|q| slab.normal_stiffness(q)),
        limit(0, [(0.01, 1.0 / s), (100.0, 1.0 / s)]),
        limit(1, [(0.01, 1.0), (100.0, 1.0)]),
        limit(0, [0.5, 100.0].map(|q| (q, 2.0 * q / (1.0 + s)))),
        limit(2, [0.5, 100.0].map(|q| (q, q))),
        limit(3, [0.5, 100.0].map(|q| (q, 2.0 * (1.0 - s) * q))),
    ];
    Chart::new(vec![Panel {
        x: Axis::log("wavenumber *q z*_m"),
        y: Axis::log("stiffness / (*C*_{44}/*z*_m)"),
        series,
        ..Panel::default()
    }])
}

/// Draws the amplitudes of u_z and u_x at all heights, relative to u_z at the surface.
fn decay(slab: &Body) -> Result<Chart, Failure> {
    let mut panels = [("*u*_z", 2), ("*u*_x", 0)].map(|(label, _)| Panel {
        x: Axis::linear("height *z*/*z*_m"),
        y: Axis::linear(&format!("{label} / *u*_z at the surface")),
        ..Panel::default()
    });
    for (hue, (number, label)) in [(1.0, "*q z*_m = 1"), (3.0, "3"), (TAU, "2π")].into_iter().enumerate() {
        let mut curves = [Vec::new(), Vec::new()];
        for i in 0..=100 {
            let z = f64::from(i) / 100.0;
            let section = slab.at_height(z).map_err(|error| Failure::computation(error.to_string()))?;
            let transfer = section.plane_displacement_transfer(number);
            curves[0].push((z, transfer[1][1].re));
            curves[1].push((z, transfer[0][1].im));
        }
        for (panel, curve) in panels.iter_mut().zip(curves) {
            panel.series.push(Series::line(label, hue, curve));
        }
    }
    Ok(Chart { share_y: false, ..Chart::new(panels.into()) })
}
