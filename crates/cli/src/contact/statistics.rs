//! The parts of a load that `--statistics` and `--flow` add: patches, distributions, spectra, flow through the gap.

use gfmd_contact::Boundary;
use gfmd_field::{Grid, Transform};
use gfmd_files::{Archive, Dimension, Variable};
use gfmd_flow::{Flow, FlowError, flow};
use gfmd_green::Height;
use gfmd_law::Kind;
use gfmd_measure::{Distribution, Patches, density_over_decades};
use gfmd_problem::Unknown;
use gfmd_record::At;
use gfmd_surface::PowerSpectrum;
use ndarray::{Array2, ArrayView2, Zip};

use super::{Args, Loads};
use gfmd_problem::options::BodyArgs;
use gfmd_run::failure::Failure;
use gfmd_run::source::Surface;

/// Number of bins of a distribution.
const BINS: usize = 100;

/// Decades of a distribution on a logarithmic scale, below the largest value.
const DECADES: usize = 6;

/// Its number of bins in a decade.
const BINS_PER_DECADE: usize = 10;

/// The results of the loads of one contact beside their scalars.
#[derive(Default)]
pub(super) struct Gathered {
    pub(super) loads: Vec<Measured>,
    /// The state of the last load.
    pub(super) flow: Option<Flow>,
}

/// The arrays of one load.
pub(super) struct Measured {
    /// Area, perimeter, force and centre of each patch, in the order of their first points.
    patches: Vec<[f64; 5]>,
    pub(super) pressure: Distribution,
    pub(super) gap: Distribution,
    /// Gaps and densities, in bins of equal width on a logarithmic scale.
    pub(super) gap_decades: Vec<[f64; 2]>,
    /// Periodic fields alone have them.
    spectra: Option<Spectra>,
}

/// The spectrum of a pressure.
struct Spectra {
    /// Wavenumbers and power spectral densities.
    radial: Vec<[f64; 2]>,
    /// Autocorrelation along x and along y.
    correlation: [Vec<f64>; 2],
}

/// The patches of the points that are repelled.
pub(super) fn patches(surface: &Surface, repulsion: ArrayView2<f64>) -> Patches {
    Patches::of(repulsion.mapv(|p| p > 0.0).view(), surface.boundary.surroundings())
}

impl Measured {
    /// Measures the fields of a load, and its patches. The `pressure` is the repulsive part alone, which is zero out of contact.
    ///
    /// # Errors
    /// Fields that do not fit the grid.
    pub(super) fn of(
        surface: &Surface,
        pressure: ArrayView2<f64>,
        gap: ArrayView2<f64>,
    ) -> Result<(Self, Patches), Failure> {
        let (grid, found) = (&surface.grid, patches(surface, pressure));
        let [dx, dy] = grid.spacing();
        let points = grid.len();
        let forces = found.sums(pressure);
        let rows = found.patches.iter().zip(forces).map(|(patch, force)| {
            let perimeter = patch.links[0] as f64 * dy + patch.links[1] as f64 * dx;
            let [x, y] = patch.centre;
            [patch.points as f64 * dx * dy, perimeter, force * dx * dy, x * dx, y * dy]
        });
        let apart = || gap.iter().zip(pressure).filter(|(_, p)| **p <= 0.0).map(|(gap, _)| *gap);
        let measured = Self {
            patches: rows.collect(),
            pressure: Distribution::of(pressure.iter().copied(), points, BINS),
            gap: Distribution::of(apart(), points, BINS),
            gap_decades: density_over_decades(apart(), points, DECADES, BINS_PER_DECADE),
            spectra: (surface.boundary == Boundary::Periodic).then(|| spectra(grid, pressure)).transpose()?,
        };
        Ok((measured, found))
    }

    /// The wavenumbers and densities of the spectrum of the pressure.
    pub(super) fn spectrum(&self) -> Option<&[[f64; 2]]> {
        self.spectra.as_ref().map(|spectra| &spectra.radial[..])
    }
}

/// The radially averaged spectrum of the pressure, and its autocorrelation along x and y over the variance, up to half of the
/// cell.
fn spectra(grid: &Grid, pressure: ArrayView2<f64>) -> Result<Spectra, Failure> {
    let unusable =
        |error: &dyn std::fmt::Display| Failure::Computation(format!("the spectrum of the pressure: {error}"));
    let spectrum = PowerSpectrum::of(&pressure.to_owned(), grid).map_err(|error| unusable(&error))?;
    let radial = spectrum.radial().into_iter().map(|bin| [bin.wavenumber, bin.density]).collect();
    let mut power = spectrum.power().to_vec();
    // The mean has no part in it.
    power[0] = 0.0;
    // The transform of the power is its convolution with a unit at the origin.
    let transform = Transform::new(*grid);
    let (mut unit, mut correlation) = (vec![0.0; grid.len()], vec![0.0; grid.len()]);
    unit[0] = 1.0;
    let made = transform.convolve(&power, &unit, &mut correlation, &mut transform.workspace());
    made.map_err(|error| unusable(&error))?;
    let [nx, ny] = grid.points();
    let relative = |index: usize| if correlation[0] > 0.0 { correlation[index] / correlation[0] } else { f64::NAN };
    let along_x = (0..=nx / 2).map(|i| relative(i % nx * ny)).collect();
    Ok(Spectra { radial, correlation: [along_x, (0..=ny / 2).map(|j| relative(j % ny)).collect()] })
}

/// The flow through the gap, relative to a uniform gap equal to the mean gap; `repulsion` is the pressure that is zero out of
/// contact. Soft surfaces may overlap so far that their mean gap is not positive: the flow is then relative to a uniform gap
/// equal to the largest one, and has no meaning but that of the paths that it takes.
///
/// # Errors
/// A flow that cannot be computed.
fn through(
    surface: &Surface,
    repulsion: ArrayView2<f64>,
    gap: ArrayView2<f64>,
    mean_gap: f64,
) -> Result<Flow, FlowError> {
    let scale = if mean_gap > 0.0 { mean_gap } else { gap.fold(f64::MIN_POSITIVE, |largest, gap| largest.max(*gap)) };
    let mut cubes = Array2::zeros(gap.dim());
    Zip::from(&mut cubes).and(gap).and(repulsion).for_each(|cube, gap, p| {
        *cube = if *p > 0.0 || *gap <= 0.0 { 0.0 } else { (gap / scale).powi(3) };
    });
    flow(&surface.grid, cubes.view(), surface.boundary.surroundings())
}

/// The share of the mean square gradient in waves shorter than four points up to which the grid resolves a surface.
const UNRESOLVED: f64 = 0.01;

/// The reason why the error of the grid is not known for this kind of contact; `None` if it is.
fn not_calibrated(args: &Args, surface: &Surface) -> Option<String> {
    let BodyArgs { height, others, .. } = &args.problem.body;
    let is_half_space = *height == Height::Infinite && others.layer.is_empty() && others.second_body.is_none();
    let other = [
        ("a law", args.problem.law.law != Kind::HardWall),
        ("a hardness", args.problem.hardness.is_some()),
        ("free boundaries", surface.boundary == Boundary::Free),
        ("further unknown components", args.problem.components != Unknown::Normal),
        ("finite slopes", args.problem.finite_slope),
        ("a body that is no half-space", !is_half_space),
    ];
    if let Some((name, _)) = other.into_iter().find(|(_, is_so)| *is_so) {
        return Some(format!("the error of the grid was measured for a hard wall on half-spaces, not with {name}"));
    }
    let spectrum = PowerSpectrum::of(&surface.heights, &surface.grid).ok()?;
    let short = spectrum.short_waves();
    (short > UNRESOLVED).then(|| {
        format!(
            "waves shorter than four points have {:.0} % of the mean square gradient: what lies between the points decides",
            100.0 * short
        )
    })
}

/// All that is measured of one load if it is asked for.
#[derive(Default)]
pub(super) struct Findings {
    pub(super) arrays: Option<Measured>,
    pub(super) flow: Option<Flow>,
    patches: Option<Patches>,
    conductance: Option<Result<f64, &'static str>>,
    not_calibrated: Option<String>,
}

impl Findings {
    /// Measures a load by its repulsive pressure and its gap; `at` has its summary, its residuals and its stiffness, and `warn`
    /// takes the code and the words of numbers that are less exact than they should be.
    ///
    /// # Errors
    /// Fields that do not fit the grid, a flow or a conductance that cannot be computed.
    pub(super) fn of(
        (args, loads): (&Args, &Loads),
        [repulsion, gap]: [ArrayView2<f64>; 2],
        at: &At,
        mut warn: impl FnMut(&'static str, String),
    ) -> Result<Self, Failure> {
        let (surface, conducting) = (&loads.prepared.surface, &loads.conducting);
        let mut found = Self::default();
        if args.statistics {
            let stiffness = at.stiffness.as_ref().ok().map(|found| found.value);
            let (conductance, warning) = conducting.measure(&repulsion, at.has_converged(), stiffness)?;
            found.conductance = Some(conductance);
            if let Some(warning) = warning {
                warn("conductance", warning);
            }
        }
        if args.statistics || args.flow {
            // In contact are the points that are repelled.
            let repulsion = repulsion.mapv(|p| p.max(0.0));
            if args.statistics {
                let (arrays, patches) = Measured::of(surface, repulsion.view(), gap)?;
                (found.arrays, found.patches) = (Some(arrays), Some(patches));
            }
            if args.flow {
                let flow = match through(surface, repulsion.view(), gap, at.summary.mean_gap) {
                    Err(FlowError::NotConverged { state, .. }) => {
                        warn("flow", format!("the residual of the flow is {:.1e}", state.residual));
                        *state
                    }
                    flow => flow.map_err(|error| Failure::Computation(error.to_string()))?,
                };
                found.flow = Some(flow);
                found.not_calibrated = not_calibrated(args, surface);
            }
        }
        Ok(found)
    }

    /// The findings as columns take them.
    pub(super) fn borrowed(&self) -> gfmd_record::Measured<'_> {
        gfmd_record::Measured {
            patches: self.patches.as_ref(),
            conductance: self.conductance.map(|found| found.map_err(Into::into)),
            flow: self.flow.as_ref(),
            not_calibrated: self.not_calibrated.clone(),
        }
    }
}

/// A variable of all loads: its path and its values.
pub(super) struct Stored {
    pub(super) path: &'static str,
    pub(super) values: Vec<f64>,
}

/// The arrays of a file, from those of all loads.
pub(super) fn arrays(loads: &[Measured]) -> Vec<Stored> {
    let per_patch = |k: usize| loads.iter().flat_map(|load| load.patches.iter().map(move |patch| patch[k])).collect();
    let joined = |of: &dyn Fn(&Measured) -> Vec<f64>| loads.iter().flat_map(of).collect::<Vec<f64>>();
    let mut stored = vec![
        Stored {
            path: "/patches/load",
            values: loads.iter().enumerate().flat_map(|(k, load)| vec![k as f64; load.patches.len()]).collect(),
        },
        Stored { path: "/patches/area", values: per_patch(0) },
        Stored { path: "/patches/perimeter", values: per_patch(1) },
        Stored { path: "/patches/force", values: per_patch(2) },
        Stored { path: "/patches/x", values: per_patch(3) },
        Stored { path: "/patches/y", values: per_patch(4) },
        Stored { path: "/distributions/pressure", values: joined(&|load| load.pressure.densities.clone()) },
        Stored { path: "/distributions/pressure_at", values: joined(&|load| load.pressure.middles.clone()) },
        Stored { path: "/distributions/gap", values: joined(&|load| load.gap.densities.clone()) },
        Stored { path: "/distributions/gap_at", values: joined(&|load| load.gap.middles.clone()) },
    ];
    if loads.iter().all(|load| load.spectra.is_some()) {
        let part = |of: &dyn Fn(&Spectra) -> Vec<f64>| {
            loads.iter().filter_map(|load| load.spectra.as_ref()).flat_map(of).collect::<Vec<f64>>()
        };
        stored.extend([
            Stored { path: "/spectra/pressure", values: part(&|s| s.radial.iter().map(|bin| bin[1]).collect()) },
            Stored { path: "/spectra/autocorrelation_x", values: part(&|s| s.correlation[0].clone()) },
            Stored { path: "/spectra/autocorrelation_y", values: part(&|s| s.correlation[1].clone()) },
        ]);
    }
    stored
}

/// Writes the arrays of the loads that were solved.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(archive: &mut Archive, surface: &Surface, loads: &[Measured]) -> Result<(), Failure> {
    if loads.is_empty() {
        return Ok(());
    }
    let unit = surface.unit();
    let load = Dimension::index("load", loads.len(), "load step");
    let patch = Dimension::index("patch", loads.iter().map(|load| load.patches.len()).sum(), "patch of any load");
    let bin = Dimension::index("bin", BINS, "bin between zero and the largest value of the load");
    let [dx, dy] = surface.grid.spacing();
    let lag = |name: &str, spacing: f64, along: usize| {
        let count = loads[0].spectra.as_ref().map_or(0, |spectra| spectra.correlation[along].len());
        Dimension::values(name, (0..count).map(|k| k as f64 * spacing).collect(), unit, "distance")
    };
    let (lag_x, lag_y) = (lag("lag_x", dx, 0), lag("lag_y", dy, 1));
    let wavenumbers = loads[0].spectra.iter().flat_map(|spectra| spectra.radial.iter().map(|bin| bin[0])).collect();
    let wavenumber = Dimension::values("wavenumber", wavenumbers, "rad/length", "mean wavenumber of a ring");
    let (per_patch, per_bin) = ([&patch], [&load, &bin]);
    let (rings, along_x, along_y) = ([&load, &wavenumber], [&load, &lag_x], [&load, &lag_y]);
    for Stored { path, values } in arrays(loads) {
        let (dimensions, units, long_name): (&[&Dimension], _, _) = match path {
            "/patches/load" => (&per_patch, "1", "load step to which the patch belongs"),
            "/patches/area" => (&per_patch, "length^2", "area: number of points times that of a cell"),
            "/patches/perimeter" => (
                &per_patch,
                "length",
                "length of the edges between points in contact and points not in contact; the edge of a patch with free boundaries has no part in it",
            ),
            "/patches/force" => (&per_patch, "stress*length^2", "force on the patch"),
            "/patches/x" => {
                (&per_patch, unit, "x of the centre of area; NaN if the patch winds around the cell along x")
            }
            "/patches/y" => {
                (&per_patch, unit, "y of the centre of area; NaN if the patch winds around the cell along y")
            }
            "/distributions/pressure" => {
                (&per_bin, "1/stress", "density of the positive pressures over the whole surface")
            }
            "/distributions/pressure_at" => (&per_bin, "stress", "pressure in the middle of the bin"),
            "/distributions/gap" => {
                (&per_bin, "1/length", "density of the gap of points not in contact over the whole surface")
            }
            "/distributions/gap_at" => (&per_bin, unit, "gap in the middle of the bin"),
            "/spectra/pressure" => {
                (&rings, "stress^2*length^2", "radially averaged power spectral density of the pressure, as of heights")
            }
            "/spectra/autocorrelation_x" => (&along_x, "1", "autocorrelation of the pressure less its mean, along x"),
            _ => (&along_y, "1", "autocorrelation of the pressure less its mean, along y"),
        };
        if dimensions.iter().all(|dimension| !dimension.is_empty()) {
            archive.write(path, &Variable { dimensions, units, long_name }, &values)?;
        }
    }
    Ok(())
}
