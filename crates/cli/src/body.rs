//! `body`: displacement, strain and stress below a surface, plane by plane from the displacement of the surface.

mod check;
mod comparison;
mod component;
mod input;
mod pictures;
mod quantity;
mod rows;
mod stored;
mod volume;
mod wave;

use std::fmt;
use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_body::{Interior, InteriorError};
use gfmd_field::Grid;
use gfmd_green::Body;
use gfmd_problem::{key, setting, words};
use serde::{Deserialize, Serialize};

use crate::progress::Progress;
use crate::session::list_files;
use gfmd_input::base::{self, BaseArgs};
use gfmd_input::failure::Failure;
use gfmd_input::memory;
use gfmd_input::session::Session;
use gfmd_input::source::file_of;
use gfmd_problem::options::given::ArrayOption;
use gfmd_problem::options::values::up_to;
use gfmd_problem::options::{BodyArgs, RecordedBodyArgs};
use gfmd_problem::options::{Kinds, Options};
use gfmd_report::figures::parse_prefix;
use gfmd_unit::{Units, digits};

pub use comparison::{Comparison, Difference};
pub use component::Component;
pub use quantity::Quantity;
pub use rows::Slice;
pub use wave::Wave;

pub use pictures::draw_middle;
pub use stored::stored;

use input::{StoredField, Surface, relaxes};
use pictures::{Pictures, Place};
use quantity::{Family, Fields};
use rows::Rows;
use volume::{Planes, Volume};

/// Flags of `body`.
#[derive(ClapArgs, Options, Clone, Debug, Deserialize)]
#[serde(default)]
#[command(after_help = "Examples:
  gfmd body --surface punch.h5 --levels 65 --slice y=0.635 --out slice.h5 --plots punch
  gfmd body --surface contact.h5:/fields/displacement_z --load 1 --levels 64 --deepest 0.1 --out volume.vti
  gfmd body --surface u.npy --size 1.27 --young 70 --poisson 0.33 --height 1.27 --depths 0,0.1,0.5 --json
  gfmd body --wave 1,1,z,0.005 --wave 1,-1,z,0.005 --young 1 --poisson 0.33 --height 1 --levels 65 --slice x=0 \
--draw uy,uz,eyz --plots wave
  gfmd body --surface punch.h5 --levels 65 --slice y=0.635 --compare elements.npy --plots both")]
pub struct Args {
    /// Surface displacement: FILE.npy of shape [nx, ny, 3] (or [n, 2] of a line: x, z), or FILE.h5[:/dataset] of this
    /// shape; the frictionless lateral displacement is added to /fields/displacement_z of a contact
    #[arg(
        long,
        value_name = "FILE",
        required_unless_present = "wave",
        conflicts_with_all = ["wave", "n"],
        help_heading = "Surface"
    )]
    #[option(array)]
    surface: Option<ArrayOption>,
    /// In place of a file: displacement A cos 2pi(M x/Lx + N y/Ly) of component x, y or z; repeated waves add up, other
    /// components are zero
    #[arg(long, value_name = "M,N,COMPONENT,A", allow_hyphen_values = true, help_heading = "Surface")]
    #[option(kinds = Kinds::list(&[&["1", "1", "1", "length"]]))]
    wave: Vec<Wave>,
    /// Grid points of --wave: N or NX,NY; NY = 1 is a line in plane strain [default: 64]
    #[arg(long, value_delimiter = ',', value_name = "N", num_args = 1..=2, requires = "wave", help_heading = "Surface")]
    #[serde(deserialize_with = "up_to::<2, _, _>")]
    n: Vec<usize>,
    /// Load of a contact file, or waypoint of a path file, numbered from 0; default: the last
    #[arg(long, value_name = "K", help_heading = "Surface")]
    load: Option<usize>,
    /// Mean surface traction x, y, z (x, z of a line; z is negative under pressure) for an array whose mean
    /// displacement does not determine it: on a half-space, or on incompressible layers; default: 0
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "TX,TY,TZ",
        num_args = 1..=3,
        allow_hyphen_values = true,
        conflicts_with = "wave",
        help_heading = "Surface"
    )]
    #[serde(deserialize_with = "up_to::<3, _, _>")]
    #[option(kinds = Kinds::STRESS)]
    mean_traction: Vec<f64>,
    /// Cell size L or Lx,Ly; default: from the coordinates in the file, or 1
    #[arg(
        long,
        alias = "length",
        value_delimiter = ',',
        value_name = "L",
        num_args = 1..=2,
        allow_negative_numbers = true,
        help_heading = "Surface"
    )]
    #[serde(deserialize_with = "up_to::<2, _, _>")]
    #[option(kinds = Kinds::LENGTH)]
    size: Vec<f64>,
    #[command(flatten)]
    #[serde(flatten)]
    body: RecordedBodyArgs,
    #[command(flatten)]
    #[serde(flatten)]
    place: PlaceArgs,
    /// Depth of the lowest level; default: the height of the slab
    #[arg(long, value_name = "D", conflicts_with = "depths", allow_negative_numbers = true, help_heading = "Places")]
    #[option(kinds = Kinds::LENGTH)]
    deepest: Option<f64>,
    /// Compute only a slice: the row of points nearest to this position (y-z or x-z) or, in place of depths, the plane
    /// at this height above the base (half-space: above its surface)
    #[arg(long, value_name = "x=X|y=Y|z=Z", help_heading = "Places")]
    #[option(kinds = Kinds::LENGTH)]
    slice: Option<Slice>,
    /// Quantities to compute
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        value_name = "Q1,Q2,..",
        default_values_t = Quantity::ALL,
        help_heading = "Places"
    )]
    quantities: Vec<Quantity>,
    /// Write the fields to FILE.h5, or to FILE.vti for ParaView (with --levels)
    #[arg(long, value_name = "FILE.h5|FILE.vti", help_heading = "Output")]
    #[serde(skip)]
    out: Option<PathBuf>,
    /// Compare the drawn components with another run of this command, FILE.h5, or with FILE.npy: [level, point,
    /// component] from the surface down, or [x, y, component] of a plane, with the components of displacement, stress
    /// or both
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    #[serde(skip)]
    compare: Option<String>,
    /// Draw maps of the slice, or without --slice of the middle row: PREFIX-*.svg, .png (with --levels or --slice z=Z);
    /// with --compare also of the reference and the difference
    #[arg(long, value_name = "PREFIX", conflicts_with = "depths", value_parser = parse_prefix, help_heading = "Output")]
    #[serde(skip)]
    plots: Option<PathBuf>,
    /// Components to draw and compare; default: the components of --quantities in the plane of the slice
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "C1,C2,..",
        value_parser = Component::parser(),
        help_heading = "Output"
    )]
    #[serde(skip)]
    draw: Vec<Component>,
}

/// Flags of the depths. Exactly one is given, unless the slice is a plane.
#[derive(ClapArgs, Options, Clone, Debug, Deserialize)]
#[serde(default)]
#[group(multiple = false)]
#[command(next_help_heading = "Places")]
struct PlaceArgs {
    /// Depths below the surface
    #[arg(long, value_delimiter = ',', value_name = "D1,D2,..", allow_negative_numbers = true)]
    #[option(kinds = Kinds::LENGTH)]
    depths: Vec<f64>,
    /// Number of evenly spaced depths from the surface to the base (or to --deepest)
    #[arg(long, value_name = "N")]
    levels: Option<usize>,
}

/// Configuration with every default filled in, for the record of a run.
#[derive(Serialize)]
struct Config<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    surface: Option<&'a ArrayOption>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    wave: &'a [Wave],
    #[serde(skip_serializing_if = "Option::is_none")]
    n: Option<[usize; 2]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scan: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    load: Option<usize>,
    #[serde(skip_serializing_if = "<[_]>::is_empty")]
    mean_traction: &'a [f64],
    size: [f64; 2],
    #[serde(flatten)]
    body: &'a BodyArgs,
    depths: &'a [f64],
    #[serde(skip_serializing_if = "Option::is_none")]
    slice: Option<String>,
    quantities: &'a [Quantity],
}

/// Printed result.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub n: [usize; 2],
    pub size: [f64; 2],
    /// Units of lengths and stresses, if known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress_unit: Option<String>,
    pub surface: String,
    /// Mean traction on the surface by component, equal at every depth.
    pub mean_traction: Vec<f64>,
    /// Row of points, with `--slice`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slice: Option<Slice>,
    pub levels: Vec<Level>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub comparison: Option<Comparison>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub out: Option<PathBuf>,
    pub plots: Vec<PathBuf>,
}

/// Numbers over all points at one depth. A number that none of the quantities needs is NaN, and `null` in JSON.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Level {
    /// Depth below the surface.
    pub depth: f64,
    /// Layer above or below, for a plane between two layers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub side: Option<Side>,
    /// Largest length of a displacement.
    pub max_displacement: f64,
    /// Largest von Mises stress.
    pub max_von_mises: f64,
    /// Mean elastic energy per volume.
    pub mean_energy_density: f64,
}

/// Sides of a plane between two layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Side {
    /// Upper layer.
    Above,
    /// Lower layer.
    Below,
}

/// Plane below the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Plane {
    depth: f64,
    side: Option<Side>,
}

/// Runs the command.
///
/// # Errors
/// Returns an error for unusable input, a file that cannot be written, or an interruption.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let (surface, name) = match &args.surface {
        Some(given) => (Surface::read(given, args.load, &args.size)?, input::name(given)),
        None => (Surface::of_waves(&args.wave, &args.n, &args.size)?, "the wave"),
    };
    if let (None, Some(load)) = (&args.surface, args.load) {
        return Err(Failure::value(key("load"), load, words!["left out with ", key("wave")]));
    }
    let elastic = args.body.over(&surface.record)?;
    let body = elastic.body()?;
    let depths = depths(args, &body)?;
    let is_image =
        args.out.as_ref().and_then(|out| out.extension()).is_some_and(|name| name.eq_ignore_ascii_case("vti"));
    let planes_below = planes(&depths, &body, args.place.levels.is_some(), is_image);
    let unique = |planes: &[Plane]| {
        let mut depths: Vec<f64> = planes.iter().map(|plane| plane.depth).collect();
        depths.dedup();
        depths
    };
    let quantities = args.quantities(name, &surface, session)?;
    let rows = Rows::new(args.slice, &surface.grid)?;
    memory::fits(memory::BODY, name, surface.grid.points())?;
    let interior = args.interior(name, &surface, &body, session)?;
    let output = session.output(args.out.as_ref())?;
    let config = toml::to_string(&Config {
        surface: args.surface.as_ref(),
        wave: &args.wave,
        n: args.surface.is_none().then(|| surface.grid.points()),
        scan: surface.scan.as_deref(),
        load: surface.load,
        mean_traction: &args.mean_traction,
        size: surface.grid.lengths(),
        body: &elastic,
        depths: &unique(&planes_below),
        slice: rows.selected().map(|slice| slice.to_string()),
        quantities: &quantities,
    });
    let provenance = session.provenance(config.map_err(|error| Failure::computation(error.to_string()))?);
    let axes = interior.components().axes();
    let mean_traction: Vec<f64> = axes.iter().map(|&axis| interior.mean_traction()[axis]).collect();
    let units = surface.units();
    let planes = Planes {
        mean_traction: &mean_traction,
        grid: &surface.grid,
        rows: &rows,
        below: &planes_below,
        even: args.place.levels.is_some(),
        height: Some(body.total_height()).filter(|height| height.is_finite()),
        units: &units,
    };
    let origin = args.surface.as_ref().and_then(ArrayOption::file).zip(surface.checksum.clone());
    let origin = origin.map(|(file, checksum)| (file_of(file).to_owned(), checksum));
    let volume =
        output.as_ref().map(|output| Volume::create(output, &planes, &quantities, &provenance, origin.as_ref()));
    let mut volume = volume.transpose()?;
    let is_row = rows.axes.len() == 1 || rows.is_level();
    let section = if is_row { rows.clone() } else { Rows::middle(&surface.grid) };
    let components = args.components(&quantities, &section, &surface.grid)?;
    let is_drawn = args.plots.is_some() || args.compare.is_some();
    if is_drawn {
        // Memory of the maps and their copies while drawing.
        let values = (depths.len() as u64).saturating_mul(section.points.len() as u64);
        memory::check_count(key("levels"), "values of a figure", values, 8 * components.len() as u64 * 2)?;
    }
    let mut pictures = is_drawn.then(|| Pictures::new(&components, section, depths.len()));

    let progress = Progress::new(session, "depths", planes_below.len());
    let mut ws = interior.workspace();
    let mut levels = Vec::new();
    let mut drawn = 0;
    for (number, &plane) in planes_below.iter().enumerate() {
        let depth = plane.depth;
        // Maps have evenly spaced levels; a level between two layers shows the upper side.
        let row = (depths.get(drawn) == Some(&depth)).then_some(drawn);
        drawn += usize::from(row.is_some());
        if session.is_interrupted() {
            return Err(Failure::interrupted(format!("interrupted at depth {number}, nothing kept")));
        }
        let mut level = Level::at(plane);
        for family in [Family::Displacement, Family::Deformation] {
            let wanted = quantities.iter().enumerate().filter(|(_, quantity)| quantity.family() == family);
            let is_drawn = row.is_some() && pictures.as_ref().is_some_and(|pictures| pictures.wants(family));
            if wanted.clone().next().is_none() && !is_drawn {
                continue;
            }
            let fields = Fields::at(&interior, family, plane, &mut ws);
            let fields = fields.map_err(|error| Failure::computation(error.to_string()))?;
            level.note(&fields);
            level.check(family, name)?;
            if relaxes(&surface.record) {
                level.mean_energy_density = f64::NAN;
            }
            for (index, _) in wanted {
                if let Some(volume) = &mut volume {
                    volume.write(index, number, &fields)?;
                }
            }
            if let (Some(pictures), Some(row)) = (&mut pictures, row) {
                pictures.take(family, row, &fields);
            }
        }
        levels.push(level);
        progress.advance(1.0, &format!("depth {depth:.3e}"));
    }
    progress.finish();
    let compared = match (&pictures, &args.compare) {
        (Some(pictures), Some(file)) => Some(comparison::compare(file, pictures, &surface.grid, &depths)?),
        _ => None,
    };
    let (comparison, compared) = compared.unzip();
    let out = session.written(volume.map(|volume| volume.finish(&planes, &levels)).transpose()?);
    let plots = match (&pictures, &args.plots) {
        (Some(pictures), Some(prefix)) => {
            let place =
                Place { grid: &surface.grid, deepest: depths[depths.len() - 1], unit: &surface.unit, units: &units };
            pictures.draw(prefix, &place, &compared.unwrap_or_default())?
        }
        _ => Vec::new(),
    };
    let (n, size) = (surface.grid.points(), surface.grid.lengths());
    Ok(Report {
        n,
        size,
        unit: units.length().map(str::to_owned),
        stress_unit: units.stress().map(str::to_owned),
        surface: surface.description,
        mean_traction,
        slice: rows.slice,
        levels,
        comparison,
        out,
        plots,
    })
}

impl Args {
    /// Returns the fields inside the `body` below the `surface` of the file `name`.
    fn interior(&self, name: &str, surface: &Surface, body: &Body, session: &Session) -> Result<Interior, Failure> {
        let Surface { grid, kind, values, record, mean_traction, .. } = surface;
        let refuse = |error: InteriorError| Failure::input(name, error);
        let is_moved = BaseArgs::NAMES.iter().any(|key| record.contains_key(*key));
        let is_full = matches!(kind, StoredField::Full);
        let of_traction = || match kind {
            StoredField::Traction => Some(Interior::of_traction(body, *grid, values)),
            StoredField::Pressure => Some(Interior::of_pressure(body, *grid, values)),
            _ => None,
        };
        let over_base = |lift: &[f64]| {
            if let Some(interior) = of_traction() {
                return interior;
            }
            // Without a mean traction, the mean displacement determines it, unless the body is incompressible.
            let mean = mean_traction.filter(|_| !is_full || body.material().poisson() == 0.5);
            let interior = match is_full {
                true => Interior::new(body, *grid, values)?,
                false => {
                    let loaded: Vec<f64> = values.iter().zip(lift).map(|(u, lift)| u - lift).collect();
                    Interior::frictionless(body, *grid, &loaded)?
                }
            };
            if let Some(mean) = mean { interior.with_mean_traction(mean) } else { Ok(interior) }
        };
        if let Some(interior) = match is_moved {
            true => Some(base::inside(name, grid, is_full, over_base).map_err(|error| Failure::input(name, error))?),
            false => of_traction().transpose().map_err(refuse)?,
        } {
            return if self.mean_traction.is_empty() { Ok(interior) } else { Err(self.known_traction(name)) };
        }
        let of_displacement = || match kind {
            StoredField::Normal => Interior::frictionless(body, *grid, values),
            _ => Interior::new(body, *grid, values),
        };
        let interior = of_displacement().map_err(refuse)?;
        match (mean_traction, &self.mean_traction[..]) {
            (Some(mean), []) => match interior.with_mean_traction(*mean) {
                // Flags give another body than the file: keep the displacement and derive its traction.
                Err(InteriorError::Contradiction { .. }) => of_displacement().map_err(refuse),
                interior => interior.map_err(refuse),
            },
            (Some(_), _) => Err(self.known_traction(name)),
            (None, []) => {
                // Waves need no warning: they are prescribed.
                if self.surface.is_some() && interior.body().level_compliance().contains(&0.0) {
                    let text = "the displacement does not determine the mean traction on this body, which is taken as \
                                0 where undetermined; --mean-traction sets it";
                    session.warn("mean-traction", text);
                }
                Ok(interior)
            }
            (None, given) => {
                let mean = match *given {
                    [x, z] if grid.is_line() => [x, 0.0, z],
                    [x, y, z] if !grid.is_line() => [x, y, z],
                    _ => {
                        let allowed = if grid.is_line() { "2 numbers, x and z" } else { "3 numbers, x, y and z" };
                        return Err(Failure::value(key("mean_traction"), format!("{given:?}"), allowed));
                    }
                };
                interior.with_mean_traction(mean).map_err(|error| Failure::input(key("mean_traction"), error))
            }
        }
    }

    /// Returns the quantities to compute, in the order of [`Quantity::ALL`].
    fn quantities(&self, name: &str, surface: &Surface, session: &Session) -> Result<Vec<Quantity>, Failure> {
        let is_known = |quantity: &Quantity| !relaxes(&surface.record) || quantity.is_of_traction();
        let all = Quantity::ALL.into_iter().filter(|quantity| self.quantities.contains(quantity));
        let (known, unknown): (Vec<Quantity>, Vec<Quantity>) = all.partition(is_known);
        let drawn = self.draw.iter().find(|component| !is_known(&component.quantity));
        let reason = "the body relaxes, so that displacement, strain and energy depend on all earlier loads";
        let refuse = |option: &str, found: &str| {
            Failure::input(
                key(option),
                format!("{found} is not available in {name}: {reason}; stress and von-mises are"),
            )
        };
        match (unknown.first(), drawn) {
            (_, Some(component)) => Err(refuse("draw", component.name)),
            (Some(quantity), _) if self.quantities.len() < Quantity::ALL.len() => {
                Err(refuse("quantities", &quantity.name().replace('_', "-")))
            }
            (Some(_), _) => {
                session.warn("relaxes", format!("{reason}; stress and von-mises are computed"));
                Ok(known)
            }
            (None, _) => Ok(known),
        }
    }

    fn known_traction(&self, name: &str) -> Failure {
        Failure::value(key("mean_traction"), format!("{:?}", self.mean_traction), format!("left out: {name} has it"))
    }

    /// Returns the components to draw and compare on a section.
    fn components(&self, quantities: &[Quantity], section: &Rows, grid: &Grid) -> Result<Vec<Component>, Failure> {
        let absent = |component: &Component| grid.is_line() && component.is_out_of_plane();
        if self.draw.is_empty() {
            let mut components = Component::in_plane(quantities, section.slice);
            components.retain(|component| !absent(component));
            return Ok(components);
        }
        match self.draw.iter().find(|component| absent(component)) {
            Some(component) => Err(Failure::value(key("draw"), component.name, "a component in the plane of a line")),
            None => Ok(self.draw.clone()),
        }
    }
}

/// Returns the planes at `depths`. A plane between two layers occurs twice, once per side. Evenly spaced `levels` also
/// get the interfaces above the deepest level. An image has the planes at `depths` only.
fn planes(depths: &[f64], body: &Body, levels: bool, is_image: bool) -> Vec<Plane> {
    let at = |depth: f64| Plane { depth, side: None };
    if is_image {
        return depths.iter().copied().map(at).collect();
    }
    let interfaces = body.interfaces();
    let deepest = depths.iter().copied().fold(0.0, f64::max);
    let mut all = depths.to_vec();
    if levels {
        all.extend(interfaces.iter().filter(|depth| **depth < deepest));
        all.sort_by(f64::total_cmp);
    }
    all.dedup_by(|a, b| a == b && interfaces.contains(a));
    let sides = |depth: f64| match interfaces.contains(&depth) {
        true => vec![Plane { depth, side: Some(Side::Above) }, Plane { depth, side: Some(Side::Below) }],
        false => vec![at(depth)],
    };
    all.into_iter().flat_map(sides).collect()
}

/// Returns the depths inside the body; `--levels` counts from the surface downwards.
fn depths(args: &Args, body: &Body) -> Result<Vec<f64>, Failure> {
    let interfaces = body.interfaces();
    // A given depth and a sum of heights may differ by rounding.
    let snapped = |depth: f64| interfaces.iter().copied().find(|at| (depth - at).abs() <= 1e-12 * at).unwrap_or(depth);
    let inside = |option: &str, depth: f64| match body.at_depth(depth) {
        Ok(_) => Ok(snapped(depth)),
        Err(error) => Err(Failure::input(key(option), error)),
    };
    let is_given = args.place.levels.is_some() || !args.place.depths.is_empty();
    if let Some(height) = args.slice.and_then(Slice::height) {
        if is_given {
            return Err(Failure::because(
                key("slice"),
                words!["a plane z=Z takes the place of ", key("depths"), " and ", key("levels")],
            ));
        }
        let top = Some(body.total_height()).filter(|height| height.is_finite()).unwrap_or(0.0);
        return Ok(vec![inside("slice", top - height)?]);
    }
    if !is_given {
        return Err(Failure::refused(words![
            key("depths"),
            " or ",
            key("levels"),
            " is missing; one of them is needed, or ",
            setting("slice", "z=Z"),
        ]));
    }
    let Some(levels) = args.place.levels else {
        return args.place.depths.iter().map(|&depth| inside("depths", depth)).collect();
    };
    if levels < 2 {
        return Err(Failure::value(key("levels"), levels, "at least 2"));
    }
    memory::check_count(key("levels"), "levels", levels as u64, LEVEL_BYTES)?;
    let deepest = args.deepest.or_else(|| Some(body.total_height()).filter(|height| height.is_finite()));
    let missing = || Failure::missing("deepest", "it is needed because a half-space has no base");
    let deepest = deepest.ok_or_else(missing)?;
    if inside("deepest", deepest)? == 0.0 {
        return Err(Failure::value(key("deepest"), 0, "above 0"));
    }
    Ok(evenly_spaced(levels, deepest).map(snapped).collect())
}

/// Bytes of a level in the report and its text.
const LEVEL_BYTES: u64 = 512;

/// Returns depths from the surface to exactly `deepest`: a rounded depth could lie below the base.
fn evenly_spaced(levels: usize, deepest: f64) -> impl Iterator<Item = f64> {
    let last = levels - 1;
    (0..levels).map(move |k| if k == last { deepest } else { deepest * k as f64 / last as f64 })
}

/// Name, kind of the unit and meaning of a number at a depth, and the number.
type NumberOfLevel = (&'static str, &'static str, &'static str, fn(&Level) -> f64);

impl Level {
    /// Refuses units in which a number of the level is not finite.
    fn check(&self, family: Family, surface: &str) -> Result<(), Failure> {
        let numbers = match family {
            Family::Displacement => [("largest displacement", self.max_displacement); 2],
            Family::Deformation => {
                [("largest von Mises stress", self.max_von_mises), ("mean energy density", self.mean_energy_density)]
            }
        };
        let Some((what, found)) = numbers.into_iter().find(|(_, number)| !number.is_finite()) else { return Ok(()) };
        let reason = format!("the {what} at depth {:e} is {found}; it must be finite", self.depth);
        Err(Failure::input(surface, reason + "; choose other units of stress or length"))
    }

    /// Numbers at each depth.
    const NUMBERS: [NumberOfLevel; 3] = [
        ("max_displacement", "length", "largest length of the displacement at this depth", |of| of.max_displacement),
        ("max_von_mises", "stress", "largest von Mises stress at this depth", |of| of.max_von_mises),
        ("mean_energy_density", "stress", "mean elastic energy per volume at this depth", |of| of.mean_energy_density),
    ];

    fn at(Plane { depth, side }: Plane) -> Self {
        Self { depth, side, max_displacement: f64::NAN, max_von_mises: f64::NAN, mean_energy_density: f64::NAN }
    }

    fn note(&mut self, fields: &Fields) {
        match fields {
            Fields::Displacement(u) => {
                let square = |point: usize| u.at(point).iter().map(|u| u * u).sum::<f64>();
                self.max_displacement = gfmd_relax::worst((0..u.points()).map(square)).sqrt();
            }
            Fields::Deformation(deformation) => {
                let states = || (0..deformation.len()).map(|point| deformation.at(point));
                self.max_von_mises = gfmd_relax::worst(states().map(|state| state.von_mises()));
                let energy: f64 = states().map(|state| state.energy_density()).sum();
                self.mean_energy_density = energy / deformation.len() as f64;
            }
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([nx, ny], [lx, ly]) = (self.n, self.size);
        let units = Units::new(self.unit.as_deref(), self.stress_unit.as_deref());
        // Known unit, after a number or below a head.
        let unit = |kind: &str| Some(units.name(kind)).filter(|name| name != kind).unwrap_or_default();
        let [length, stress] = ["length", "stress"].map(unit);
        let after = |unit: &str| if unit.is_empty() { String::new() } else { format!(" {unit}") };
        writeln!(f, "{}\n{nx} x {ny} points, cell {} x {}{}", self.surface, digits(lx), digits(ly), after(&length))?;
        if let Some(slice) = self.slice {
            writeln!(f, "slice at {slice}")?;
        }
        let traction: Vec<String> = self.mean_traction.iter().map(|mean| digits(*mean)).collect();
        writeln!(f, "mean traction {}{}", traction.join(", "), after(&stress))?;
        writeln!(f, "\n{:>13} {:>13} {:>13} {:>13}", "depth", "max |u|", "max Mises", "mean energy")?;
        if !(length.is_empty() && stress.is_empty()) {
            writeln!(f, "{length:>13} {length:>13} {stress:>13} {stress:>13}")?;
        }
        for level in &self.levels {
            let Level { depth, side, max_displacement, max_von_mises, mean_energy_density } = level;
            write!(f, "{depth:>13.6e}")?;
            for value in [max_displacement, max_von_mises, mean_energy_density] {
                if value.is_nan() { write!(f, " {:>13}", "-")? } else { write!(f, " {value:>13.6e}")? }
            }
            match side {
                Some(Side::Above) => write!(f, "  in the layer above")?,
                Some(Side::Below) => write!(f, "  in the layer below")?,
                None => {}
            }
            writeln!(f)?;
        }
        if let Some(Comparison { reference, compared_points: [a, b], components }) = &self.comparison {
            writeln!(f, "\nagainst {reference} on {a} x {b} points of the section:")?;
            writeln!(f, "{:>8} {:>15} {:>18} {:>17}", "", "rms difference", "largest difference", "largest reference")?;
            for Difference { name, rms_difference, largest_difference, largest_reference } in components {
                writeln!(
                    f,
                    "{name:>8} {rms_difference:>15.6e} {largest_difference:>18.6e} {largest_reference:>17.6e}"
                )?;
            }
        }
        list_files(f, self.out.as_deref(), &self.plots)
    }
}
