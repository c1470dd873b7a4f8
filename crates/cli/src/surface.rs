//! `surface`: make a surface or measure one.

mod curves;
mod file;
mod listing;
mod measured;

use std::collections::BTreeMap;
use std::fmt;
use std::io::Write as _;
use std::path::PathBuf;

use clap::{Args as ClapArgs, ValueEnum};
use gfmd_contact::Boundary;
use gfmd_field::Grid;
use gfmd_files::{Output, Provenance};
use gfmd_problem::key;
use gfmd_record::{Cell, Record, SurfaceFacts, by_reason, size_for_unit};
use gfmd_report::surface::{About, Number, Subject, unit_of};
use gfmd_surface::{
    MotifEdges, Normalisation, Periodisation, RadialBin, RollOff, RollOffShape, SelfAffine, SurfaceError,
};
use gfmd_unit::Units;
use ndarray::{Array2, ArrayRef2};
use serde::Serialize;

use crate::session::{list_files, wrapped};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_input::source::scan::Scan;
use gfmd_input::source::{Second, SourceArgs};
use gfmd_problem::options::Method;
use gfmd_problem::options::flags::toml_of;
use gfmd_problem::options::given::ArrayOption;
use gfmd_problem::options::parse_choice;
use gfmd_problem::options::{Kinds, Options};
use gfmd_report::check_replaceable;
use gfmd_report::figures::parse_prefix;

pub use curves::Curves;
use file::Target;
pub(crate) use listing::Listing;
pub use measured::{Choices, Detail, Functions, Measured, USUAL_WOLF};

/// Flags of `surface`.
#[derive(ClapArgs, Options, Clone, Debug, Serialize)]
#[command(after_help = "Examples:
  gfmd surface --n 512 --hurst 0.8 --eps-t-inv 2 --eps-f-inv 64 --rms-gradient 0.1 --seed 7 --out h.npy
  gfmd surface --dim 2 --n 4096 --hurst 0.5 --eps-f-inv 256 --json
  gfmd surface --method rmd --n 1024 --hurst 0.3 --out h.h5
  gfmd surface --shape sphere:R=2mm --size 0.1mm --hurst 0.8 --rms-height 20nm --out h.h5
  gfmd surface --surface scan.txt --detrend plane --periodise mirror --out h.h5
  gfmd surface --surface scan.sur --list
  gfmd surface --surface scan.sur --channel 1 --detrend plane --fill harmonic --window hann --plots scan
  gfmd surface --surface scan.opd --fill nearest --out scan.x3p
  gfmd surface --surface afm.spm --despike --descar --level rows:median --detrend quadratic --fill harmonic
  gfmd surface --surface scan.sur --crop 10um:,:0.5mm --detrend cubic --filter s:2.5um,l:0.25mm --out h.h5
  gfmd surface --surface scan.opd --fill harmonic --detrend plane --unit um --report scan.html")]
pub struct Args {
    #[command(flatten)]
    #[serde(flatten)]
    source: SourceArgs,
    /// Wavelength range of the Hurst exponent fit, length [default: the cut-offs of a generated surface; for a file,
    /// half of the cell and 4 grid spacings]
    #[arg(
        long,
        value_delimiter = ',',
        value_name = "LONGEST,SHORTEST",
        allow_negative_numbers = true,
        help_heading = "Measurements"
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::LENGTH)]
    fit_range: Vec<f64>,
    /// Window applied to the heights for the spectrum of the fit, file and figure; heights and statistics do not change
    #[arg(long, value_enum, default_value_t = Window::None, help_heading = "Measurements")]
    #[serde(skip_serializing_if = "Window::is_none")]
    window: Window,
    /// List the channels of the file with units and points; do nothing else
    #[arg(
        long,
        requires = "surface",
        conflicts_with_all = ["out", "plots", "channel", "statistics", "report"],
        help_heading = "Output"
    )]
    #[serde(skip)]
    list: bool,
    /// Write the heights to this file, .npy, .x3p or .h5; a .h5 file also has the statistics and the radially averaged
    /// spectrum
    #[arg(long, value_name = "FILE", help_heading = "Output")]
    #[serde(skip)]
    out: Option<PathBuf>,
    /// Draw the heights, a profile through them and the spectrum: PREFIX-map, -profile, -spectrum (.svg, .png); with
    /// --statistics also -hills, -autocorrelation, -correlation-map, -distributions, -slopes, -curvatures and -bearing
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix, help_heading = "Output")]
    #[serde(skip)]
    plots: Option<PathBuf>,
    /// Add correlation lengths, direction, hills and dales (ISO 25178) to the numbers; and spectrum, autocorrelation,
    /// distributions of height, slope and curvature, slope and curvature against distance, and bearing curve to JSON,
    /// .h5 file and figures
    #[arg(long, help_heading = "Measurements")]
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    statistics: bool,
    /// Boundary condition for --statistics: periodic, or free, with differences inside the surface only, from which rms
    /// gradient, rms curvature, m2, m4 and Nayak's parameter then also follow [default for --statistics: periodic for a
    /// surface of method psd, a wave and a mirrored surface, else free]
    #[arg(long, value_parser = parse_choice::<Boundary>(), help_heading = "Measurements")]
    #[serde(skip)]
    boundary: Option<Boundary>,
    /// Wolf pruning threshold, a fraction of the height range: hills less high above their saddle, and dales less deep,
    /// join their neighbour
    #[arg(
        long,
        default_value_t = USUAL_WOLF,
        requires = "statistics",
        value_name = "FRACTION",
        help_heading = "Measurements"
    )]
    #[serde(skip_serializing_if = "is_usual_wolf")]
    wolf: f64,
    /// Treatment of hills and dales at the edge [default: periodic for a periodic boundary, else leave-out]
    #[arg(long, value_parser = parse_choice::<MotifEdges>(), requires = "statistics", help_heading = "Measurements")]
    #[serde(skip)]
    motif_edges: Option<MotifEdges>,
    /// Write an HTML page about the surface: its numbers, all figures of --statistics, and their definitions
    #[arg(long, value_name = "FILE.html", help_heading = "Output")]
    #[serde(skip)]
    report: Option<PathBuf>,
}

/// The windows that make the spectrum of a scan that is not periodic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Window {
    /// No window, for periodic heights
    None,
    /// Cosine over the whole side, zero at the edges, divided by its rms value
    Hann,
}

/// Fewest points of a bearing curve without a warning.
const FEWEST_POINTS: usize = 100;

fn is_usual_wolf(wolf: &f64) -> bool {
    *wolf == USUAL_WOLF
}

impl Window {
    fn is_none(&self) -> bool {
        *self == Self::None
    }
}

/// The result, as printed.
#[derive(Clone, Debug, Serialize)]
#[serde(untagged)]
pub enum Printed {
    /// The statistics of a surface.
    Measured(Box<Report>),
    /// The channels of a file.
    Listed(Listing),
}

impl fmt::Display for Printed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Measured(report) => report.fmt(f),
            Self::Listed(listing) => listing.fmt(f),
        }
    }
}

/// The statistics of a surface, as printed. Lengths are in the unit of the heights.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub source: String,
    pub n: [usize; 2],
    pub size: [f64; 2],
    pub unit: Option<String>,
    /// Statistics of the heights.
    #[serde(flatten, serialize_with = "Record::serialize_numbers")]
    pub numbers: Record<gfmd_record::Surface>,
    #[serde(skip)]
    facts: SurfaceFacts,
    #[serde(skip_serializing_if = "Window::is_none")]
    pub window: Window,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub scan: Option<Scan>,
    #[serde(flatten)]
    pub second: Option<Second>,
    pub asked: Option<RequestedStatistics>,
    /// Reasons why numbers have no value, each with their names.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub undefined: BTreeMap<String, Vec<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub boundary: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wolf: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motif_edges: Option<&'static str>,
    #[serde(flatten, serialize_with = "curves::numbers")]
    pub curves: Option<Curves>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub report: Option<PathBuf>,
    pub out: Option<PathBuf>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub plots: Vec<PathBuf>,
}

/// The numbers that were asked of a generated surface; the report has the measured numbers under equal names.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct RequestedStatistics {
    pub seed: u64,
    pub hurst: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_gradient: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_height: Option<f64>,
    pub longest_wavelength: Option<f64>,
    pub shortest_wavelength: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roll_off: Option<f64>,
}

/// Makes or reads the surface, measures it, and writes and draws it if asked to; or lists the channels of a file.
///
/// # Errors
/// Flags or a file that cannot be used; an output that cannot be written.
pub fn run(args: &Args, session: &Session) -> Result<Printed, Failure> {
    match (&args.source.surface, args.list) {
        (Some(ArrayOption::File(file)), true) => Listing::of(file).map(Printed::Listed),
        _ => measured(args, session).map(|(report, _)| Printed::Measured(Box::new(report))),
    }
}

/// Makes or reads the surface, and measures, writes and draws it. Returns its numbers and its heights.
///
/// # Errors
/// Fails like [`run`].
pub(crate) fn measured(args: &Args, session: &Session) -> Result<(Report, Array2<f64>), Failure> {
    let out = args.out.as_deref().map(Target::claim).transpose()?;
    let page = args.report.as_deref().map(claim_page).transpose()?;
    let is_patch = args.source.surface.is_some() && args.source.periodise == Periodisation::AsIs;
    let surface = match (&args.source.generator.shape, args.boundary) {
        // A wave need not fit into a patch.
        (Some(_), Some(boundary)) => args.source.bounded(boundary, session)?,
        // A patch has no seam.
        (_, Some(Boundary::Free)) if is_patch => args.source.bounded(Boundary::Free, session)?,
        _ => args.source.surface(session)?,
    };
    let name = args.source.name();
    let grid = surface.grid;
    let refused = |error| Failure::input(&name, error);
    let (asked, range) = match (&args.source.surface, &surface.second) {
        (None, None) if args.source.generator.shape.is_none() => args.asked(&grid)?,
        _ => (None, whole_band(&grid)),
    };
    let range = match args.fit_range[..] {
        [] => range,
        [longest, shortest] => [longest, shortest],
        ref found => {
            return Err(Failure::value(key("fit_range"), format!("{found:?}"), "LONGEST,SHORTEST"));
        }
    };
    let boundary = args.boundary.unwrap_or_else(|| args.source_boundary());
    let detail = Detail { wolf: args.wolf, edges: args.motif_edges, ..Detail::usual(boundary) };
    let choices = Choices {
        fit_range: range,
        must_fit: !args.fit_range.is_empty(),
        window: args.window,
        boundary: args.boundary.unwrap_or(Boundary::Periodic),
        section: section_of(args, surface.scan.as_ref()),
        detail: (args.statistics || page.is_some()).then_some(detail),
    };
    let measured = Measured::of(&surface.heights, &grid, &choices).map_err(|error| match error {
        SurfaceError::Fit { .. } | SurfaceError::Wavelengths { .. } => Failure::input(key("fit_range"), error),
        SurfaceError::Fraction { .. } => Failure::input(key("wolf"), error),
        error => refused(error),
    })?;
    let mut report = Report::new(&measured, &grid);
    (report.source, report.unit) = (surface.description, surface.unit);
    (report.scan, report.second) = (surface.scan, surface.second);
    (report.asked, report.window) = (asked, args.window);
    let points = surface.heights.len();
    if args.statistics && points < FEWEST_POINTS {
        let text = format!(
            "the surface has {points} points: parameters of the bearing curve, hills and dales need at least \
             {FEWEST_POINTS}"
        );
        session.warn("few-points", text);
    }
    let radial = measured.spectrum.radial();
    let functions = measured.functions;
    if let Some(Functions { texture, .. }) = &functions {
        report.boundary = Some(boundary.name());
        report.wolf = Some(detail.wolf);
        report.motif_edges = Some(detail.edges().name());
        report.curves = Some(Curves::of(texture, &radial, &grid));
    }
    // A page has the functions without being asked for them; JSON and file do not.
    let of_page = report.curves.take_if(|_| !args.statistics);
    report.collect_reasons();
    let resolved = Args { source: args.source.resolved()?, ..args.clone() };
    let config = toml_of(&resolved)
        .map_err(|error| Failure::computation(format!("the configuration cannot be written: {error}")))?;
    let provenance = session.provenance(config);
    if let Some(target) = out {
        target.write(&surface.heights, &grid, &radial, &report, &provenance)?;
        report.out.clone_from(&args.out);
    }
    let (mut plots, shown) = (Vec::new(), functions.as_ref().filter(|_| args.statistics));
    if let Some(prefix) = &args.plots {
        plots = report.subject(&surface.heights, &grid, &radial, shown).draw(prefix)?;
    }
    if let Some(page) = page {
        let origin = surface.origin.as_ref().map(|(file, sum)| (file.as_str(), sum.as_str()));
        let warnings = provenance.warnings.list().into_iter().map(|warning| warning.text).collect();
        let of_page = of_page.or_else(|| report.curves.clone());
        let report = Report { curves: of_page, ..report.clone() };
        let subject = report.subject(&surface.heights, &grid, &radial, functions.as_ref());
        report.write_page(&page, &subject, (&*name, origin, Some(again()), warnings), &provenance)?;
    }
    report.plots = plots;
    report.report.clone_from(&args.report);
    Ok((report, surface.heights.into_owned()))
}

/// Returns the length of the sections of a profile: the index of its L filter.
fn section_of(args: &Args, scan: Option<&Scan>) -> Option<f64> {
    match scan {
        Some(scan) => scan.band.as_ref()?.get("l")?.as_f64(),
        None => args.source.preparation.filter?.long,
    }
}

/// The page to write, claimed before the heights are made.
fn claim_page(path: &std::path::Path) -> Result<Output, Failure> {
    let output = Output::claim(path).map_err(|error| Failure::input(key("report"), error))?;
    check_replaceable("report", output.path())?;
    Ok(output)
}

/// Writes the page about heights in memory, which come from a `source` in words.
///
/// # Errors
/// Heights without numbers; a page that cannot be written.
pub fn write_report(
    heights: &ArrayRef2<f64>,
    grid: &Grid,
    (unit, source): (Option<String>, String),
    boundary: Boundary,
    path: &std::path::Path,
    session: &Session,
) -> Result<(), Failure> {
    let page = claim_page(path)?;
    let choices = Choices {
        fit_range: whole_band(grid),
        must_fit: false,
        window: Window::None,
        boundary: Boundary::Periodic,
        section: None,
        detail: Some(Detail::usual(boundary)),
    };
    let measured = Measured::of(heights, grid, &choices).map_err(|error| Failure::input("surface", error))?;
    let radial = measured.spectrum.radial();
    let report = Report {
        source,
        unit,
        boundary: Some(boundary.name()),
        curves: measured.functions.as_ref().map(|functions| Curves::of(&functions.texture, &radial, grid)),
        ..Report::new(&measured, grid)
    };
    let subject = report.subject(heights, grid, &radial, measured.functions.as_ref());
    report.write_page(&page, &subject, ("array", None, None, Vec::new()), &session.provenance(String::new()))
}

/// The command line of the program, as a shell reads it.
fn again() -> String {
    let words: Vec<String> = std::env::args().skip(1).map(|word| gfmd_report::quoted(&word)).collect();
    format!("gfmd {}", words.join(" "))
}

/// The name of a page's subject, the file that was read with its SHA-256, the command that makes the page, warnings.
type PageSource<'a> = (&'a str, Option<(&'a str, &'a str)>, Option<String>, Vec<String>);

impl Args {
    /// Returns the numbers asked of the generator, and the wavelengths between which its spectrum is a power law.
    fn asked(&self, grid: &Grid) -> Result<(Option<RequestedStatistics>, [f64; 2]), Failure> {
        let generator = &self.source.generator;
        let spectrum = match generator.method {
            Method::Psd => Some(generator.spectrum(grid)?),
            Method::Sra | Method::Rmd => None,
        };
        let (rms_gradient, rms_height) = match generator.normalisation() {
            Normalisation::RmsGradient(gradient) => (Some(gradient), None),
            Normalisation::RmsHeight(height) => (None, Some(height)),
        };
        let stretch = |spectrum: &SelfAffine| spectrum.anisotropy.map_or(1.0, |anisotropy| anisotropy.stretch());
        let asked = RequestedStatistics {
            seed: generator.seed,
            hurst: generator.hurst(),
            rms_gradient,
            rms_height,
            longest_wavelength: spectrum.map(|spectrum| spectrum.longest_wavelength * stretch(&spectrum)),
            shortest_wavelength: spectrum.map(|spectrum| spectrum.shortest_wavelength / stretch(&spectrum)),
            roll_off: generator.roll_off,
        };
        // Between these wavelengths the spectrum is a power law in all directions.
        let range = spectrum.map_or_else(
            || whole_band(grid),
            |spectrum| {
                let longest = match spectrum.roll_off {
                    Some(RollOff { wavelength, shape: RollOffShape::Plateau }) => wavelength,
                    _ => spectrum.longest_wavelength,
                };
                [longest / stretch(&spectrum), spectrum.shortest_wavelength * stretch(&spectrum)]
            },
        );
        Ok((Some(asked), range))
    }
}

impl Args {
    /// The boundary of the surface as far as its origin tells it.
    fn source_boundary(&self) -> Boundary {
        let source = &self.source;
        let made = source.surface.is_none() && source.generator.is_periodic();
        let mirrored = source.periodise == Periodisation::Mirror;
        if (made && source.second_surface.is_none()) || mirrored { Boundary::Periodic } else { Boundary::Free }
    }
}

/// The wavelengths from half of the (shorter) side to four (larger) grid spacings, away from both limits of the grid.
pub fn whole_band(grid: &Grid) -> [f64; 2] {
    let sides = if grid.is_line() { 1 } else { 2 };
    let (lengths, spacing) = (grid.lengths(), grid.spacing());
    let side = lengths[..sides].iter().copied().fold(f64::INFINITY, f64::min);
    let step = spacing[..sides].iter().copied().fold(0.0, f64::max);
    [0.5 * side, (4.0 * step).min(0.5 * side)]
}

impl Report {
    /// Returns the report of measured numbers.
    pub fn new(measured: &Measured, grid: &Grid) -> Self {
        let mut report = Self {
            source: String::new(),
            n: grid.points(),
            size: grid.lengths(),
            unit: None,
            numbers: measured.numbers.clone(),
            facts: measured.facts,
            window: Window::None,
            scan: None,
            second: None,
            asked: None,
            undefined: BTreeMap::new(),
            boundary: None,
            wolf: None,
            motif_edges: None,
            curves: None,
            report: None,
            out: None,
            plots: Vec::new(),
        };
        report.collect_reasons();
        report
    }

    /// Collects the reasons why numbers have no value.
    fn collect_reasons(&mut self) {
        let curves = self.curves.iter().flat_map(Curves::undefined).collect::<Vec<_>>();
        let of_curves = curves.iter().map(|(name, reason)| (&**name, *reason));
        let reasons = by_reason(self.numbers.undefined().map(|(name, reason)| (name as &str, reason)).chain(of_curves));
        let owned = |(reason, names): (&str, Vec<&str>)| (reason.into(), names.into_iter().map(Into::into).collect());
        self.undefined = reasons.into_iter().map(owned).collect();
    }

    /// The surface for figures and pages.
    pub fn subject<'a>(
        &'a self,
        heights: &'a ArrayRef2<f64>,
        grid: &'a Grid,
        spectrum: &'a [RadialBin],
        functions: Option<&'a Functions>,
    ) -> Subject<'a> {
        Subject {
            heights,
            grid,
            unit: self.unit.as_deref(),
            spectrum,
            window: (!self.window.is_none()).then_some("Hann"),
            resolved: self.scan.as_ref().map(|scan| scan.resolves),
            is_filtered: self.scan.as_ref().is_some_and(|scan| scan.band.is_some()),
            hurst: self.numbers.value("hurst").map(|hurst| {
                (hurst, ["hurst_range_longest", "hurst_range_shortest"].map(|name| self.numbers.number(name)))
            }),
            texture: functions.map(|functions| &functions.texture),
            course_lines: functions.and_then(|functions| functions.course_lines.as_ref()),
        }
    }

    /// Writes the page about the surface.
    ///
    /// # Errors
    /// A page that cannot be written.
    pub fn write_page(
        &self,
        output: &Output,
        subject: &Subject,
        (name, file, again, remarks): PageSource,
        provenance: &Provenance,
    ) -> Result<(), Failure> {
        let numbers = self.listed();
        let mut facts = Vec::new();
        let mut remarks = remarks;
        if let Some(scan) = &self.scan {
            facts.push(("format", scan.format.to_owned()));
            facts.extend(scan.channel.iter().map(|channel| ("channel", channel.clone())));
            if scan.undefined > 0 {
                let (undefined, points, fill) = (scan.undefined, scan.points, scan.fill.unwrap_or("none"));
                let share = 100.0 * undefined as f64 / points as f64;
                let text = format!("{undefined} of {points} ({share:.2} %), filled: {fill}; all numbers count them");
                facts.push(("points without a height", text));
            }
            facts.extend(scan.conversion.iter().map(|text| ("conversion", text.clone())));
            facts.extend(
                scan.details.iter().take(DETAILS).map(|(key, value)| ("instrument", format!("{key}: {value}"))),
            );
            remarks.extend(scan.notes.iter().cloned());
        }
        if let Some(asked) = &self.asked {
            facts.push(("seed", asked.seed.to_string()));
        }
        let repeats = self.boundary == Some(Boundary::Periodic.name());
        let about =
            About { name, source: &self.source, facts: &facts, repeats, numbers: &numbers, again, file, remarks };
        let (text, _) = subject.page(&about, provenance);
        Ok(output.write(|file| file.write_all(text.as_bytes()))?)
    }

    /// Returns all numbers except the numbers of distributions.
    fn listed(&self) -> Vec<Number> {
        self.numbers.cells().map(|(column, cell)| Number::of(column, cell, column.meaning(&self.facts))).collect()
    }

    /// Returns the numbers that have a value as texts: name, number with its unit apart, definition. A number without
    /// the periodic seam has the unit of the number with it, unless it is less than a thousandth of this unit.
    fn readable(&self) -> impl Iterator<Item = (&'static str, (String, String), &'static str)> + '_ {
        let units = Units::new(self.unit.as_deref(), None);
        self.numbers.cells().filter_map(move |(column, cell)| {
            let Number { name, value, unit, meaning } = Number::of(column, cell, column.meaning(&self.facts));
            let value = value?;
            // Zeros of lengths have the unit of the rms height.
            let beside = (unit == "length").then(|| self.numbers.value("rms_height")).flatten();
            let own = units.shown(unit, size_for_unit(value.abs(), || beside.into_iter()));
            let with_seam = name.strip_suffix("_inside").and_then(|whole| self.numbers.value(whole));
            let common = with_seam.and_then(|whole| units.shown(unit, whole.abs()));
            let text = match common.filter(|shown| value == 0.0 || (value * shown.factor).abs() >= 1e-3).or(own) {
                _ if matches!(cell, Cell::Count(_)) => (value.to_string(), String::new()),
                Some(shown) => (format!("{:.6}", value * shown.factor), shown.name),
                None => (format!("{value:.6e}"), units.name(unit)),
            };
            Some((name, text, meaning))
        })
    }

    /// Returns the numbers that have a value, as texts with units, with their definitions.
    pub(crate) fn shown(&self) -> impl Iterator<Item = (&'static str, String, &'static str)> + '_ {
        let bare = |unit: &str| unit.is_empty() || unit == "1";
        self.readable().map(move |(name, (number, unit), meaning)| {
            (name, if bare(&unit) { number } else { format!("{number} {unit}") }, meaning)
        })
    }

    /// The unit of a quantity that is a power of length.
    fn unit_of(&self, power: i32) -> String {
        unit_of(self.unit.as_deref().unwrap_or("length"), power)
    }
}

/// The number of details of an instrument that a page shows.
const DETAILS: usize = 12;

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let ([nx, ny], [lx, ly]) = (self.n, self.size);
        writeln!(f, "{}", self.source)?;
        if let Some(scan) = &self.scan {
            write!(f, "{scan}")?;
        }
        let units = Units::new(self.unit.as_deref(), None);
        let text = |length: f64| match units.shown("length", length) {
            Some(shown) => shown.text(length),
            None => format!("{length:?} {}", self.unit_of(1)),
        };
        match ny {
            1 => writeln!(f, "{nx} points on a length of {}", text(lx))?,
            _ => writeln!(f, "{nx} x {ny} points on {} x {}", text(lx), text(ly))?,
        }
        let asked = |name: &str| {
            let asked = self.asked.as_ref()?;
            match name {
                "rms_height" => asked.rms_height,
                "rms_gradient" => asked.rms_gradient,
                "hurst" => Some(asked.hurst),
                "longest_wavelength" => asked.longest_wavelength,
                "shortest_wavelength" => asked.shortest_wavelength,
                _ => None,
            }
        };
        let said = |name: &str, asked: f64| {
            let is_length = !matches!(name, "rms_gradient" | "hurst");
            match units.shown("length", asked).filter(|_| is_length) {
                Some(shown) => shown.text(asked),
                None => format!("{asked:.6e}"),
            }
        };
        for (name, (number, unit), meaning) in self.readable() {
            let meaning = match asked(name) {
                Some(asked) => format!("{meaning}; asked {}", said(name, asked)),
                None => meaning.to_owned(),
            };
            let number = format!("{name:<22} {number:>13} {unit:<10}");
            let width = f.width().map_or(usize::MAX, |width| width.saturating_sub(number.chars().count() + 1));
            for (line, words) in wrapped(&meaning, width).into_iter().enumerate() {
                let before = if line == 0 { &number } else { "" };
                writeln!(f, "{before:<47} {words}")?;
            }
        }
        if !self.window.is_none() {
            writeln!(f, "spectrum and fit under a Hann window")?;
        }
        list_files(f, self.out.as_deref(), &self.plots)?;
        self.report.iter().try_for_each(|page| writeln!(f, "page:    {}", page.display()))
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        args: Args,
    }

    fn run_line(line: &str) -> Result<Report, Failure> {
        let args = Line::try_parse_from(std::iter::once("surface").chain(line.split_whitespace())).unwrap().args;
        measured(&args, &Session::silent()).map(|(report, _)| report)
    }

    fn close(found: f64, expected: f64) -> bool {
        (found / expected - 1.0).abs() < 1e-12
    }

    #[test]
    fn a_generated_surface_is_what_it_was_asked_to_be() {
        let report = run_line("--n 128 --eps-f-inv 16 --hurst 0.6 --rms-gradient 0.3 --seed 4 --size 2").unwrap();
        let asked = report.asked.clone().unwrap();
        assert!(close(report.numbers.number("rms_gradient"), 0.3) && asked.rms_gradient == Some(0.3));
        assert!(close(report.numbers.number("longest_wavelength"), 1.0) && asked.longest_wavelength == Some(1.0));
        assert!(close(report.numbers.number("shortest_wavelength"), 1.0 / 16.0));
        assert!((report.numbers.number("hurst") - asked.hurst).abs() < 4.0 * report.numbers.number("hurst_error"));
        assert_eq!((report.n, report.size), ([128, 128], [2.0, 2.0]));
        assert!(report.to_string().contains("asked 3.000000e-1"), "{report}");
    }

    #[test]
    fn numbers_with_and_without_the_seam_have_one_unit() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("tilted.txt");
        let row = |i: usize| (0..16).map(|j| format!("{} ", j as f64 + 0.1 * (i % 2) as f64)).collect::<String>();
        std::fs::write(&file, (0..16).map(row).collect::<Vec<_>>().join("\n")).unwrap();
        let report = run_line(&format!("--surface {} --size 16 --unit um", file.display())).unwrap();
        let shown: Vec<(String, String)> =
            report.readable().filter(|(name, ..)| name.starts_with("m4")).map(|(_, number, _)| number).collect();
        let [(with, unit), (without, same)] = &shown[..] else { panic!("{shown:?}") };
        let [with, without] = [with, without].map(|number| number.parse::<f64>().unwrap());
        assert!(unit == same && without > 0.0 && with > 1e3 * without, "{shown:?}");
        assert!(report.to_string().contains("16 x 16 points on 16 µm x 16 µm\n"), "{report}");
    }

    #[test]
    fn written_heights_come_back_the_same() {
        let folder = tempfile::tempdir().unwrap();
        for (kind, name) in [("--n 64,96 --size 1.3 --eps-f-inv 8", "h.npy"), ("--n 64 --dim 2 --eps-f-inv 8", "h.h5")]
        {
            let out = folder.path().join(name);
            let made = run_line(&format!("{kind} --out {}", out.display())).unwrap();
            assert_eq!(made.out.as_deref(), Some(out.as_path()));
            let dataset = if name.ends_with("h5") { ":/surface/height" } else { "" };
            let length = if name.ends_with("h5") { "" } else { "--size 1.3" };
            let read = run_line(&format!("--surface {}{dataset} {length}", out.display())).unwrap();
            assert_eq!(
                (read.n, read.numbers.number("rms_height"), read.numbers.number("highest")),
                (made.n, made.numbers.number("rms_height"), made.numbers.number("highest"))
            );
            assert!(
                close(read.numbers.number("rms_gradient"), made.numbers.number("rms_gradient"))
                    && close(read.size[0], made.size[0])
            );
        }
        let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(names.len(), 2, "{names:?}");
        let archive = gfmd_files::Reader::open(folder.path().join("h.h5")).unwrap();
        assert!(archive.text("/", "config").unwrap().contains("eps_t_inv = 2.0"));
        assert_eq!(archive.shape("/spectrum/density").unwrap(), [32]);
    }

    #[test]
    fn curvatures_of_a_surface_that_does_not_repeat_leave_the_seam_out() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("cap.npy");
        let at = |k: usize| (k as f64 + 0.5) / 32.0 - 0.5;
        let cap = Array2::from_shape_fn((32, 32), |(i, j)| -(at(i).powi(2) + at(j).powi(2)) / 2.0 / 3.0);
        ndarray_npy::write_npy(&file, &cap).unwrap();
        let run = |flags: &str| run_line(&format!("--surface {} {flags}", file.display())).unwrap();
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 1e-9;
        let slopes = (1..32).map(|k| ((at(k) - 0.5 / 32.0) / 3.0).powi(2)).sum::<f64>() / 31.0;
        let mean = cap.sum() / 1024.0;
        let m0 = cap.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / 1024.0;
        let m4 = 0.375 * 4.0 / 9.0;
        let free = run("--boundary free");
        for report in [&free, &run(""), &run("--boundary periodic --statistics")] {
            assert!(
                near(report.numbers.number("rms_curvature_inside"), 1.0 / 3.0)
                    && near(report.numbers.number("m4_inside"), m4),
                "{report}"
            );
            assert!(near(report.numbers.number("nayak_inside"), m0 * m4 / slopes.powi(2)), "{report}");
        }
        assert!(near(free.numbers.number("rms_curvature"), 1.0 / 3.0));
        assert!(near(free.numbers.number("rms_laplacian"), 2.0 / 3.0));
        assert!(near(free.numbers.number("m4"), m4));
        assert!(
            near(free.numbers.number("nayak"), m0 * m4 / slopes.powi(2)) && near(free.numbers.number("m2"), slopes),
            "{free}"
        );
        assert_eq!(free.numbers.number("rms_gradient"), free.numbers.number("rms_gradient_inside"));
        assert!(run("").numbers.number("rms_curvature") > 0.5);
        ndarray_npy::write_npy(&file, &cap.slice(ndarray::s![..2, ..]).to_owned()).unwrap();
        let few = run("--boundary free");
        assert!(
            few.numbers.value("rms_curvature").is_none()
                && few.undefined.contains_key("an axis has fewer than three points")
        );
    }

    #[test]
    fn unusable_flags_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let says = |line: &str, words: &str| {
            let failure = run_line(line).unwrap_err();
            assert!(matches!(failure, Failure::Input(_)) && failure.to_string().contains(words), "{failure}");
        };
        says("--out h.txt", "--out is h.txt; it must be NAME.npy, NAME.x3p or NAME.h5");
        says("--out no/such/folder/h.npy", "--out: ");
        says("--n 128 --fit-range 0.1", "--fit-range is [0.1]; it must be LONGEST,SHORTEST");
        says("--n 128 --fit-range 0.1,0.2", "--fit-range: the shortest wavelength is 0.2 and the longest 0.1");
        let out = folder.path().join("h.npy");
        says(&format!("--hurst 3 --out {}", out.display()), "--hurst: ");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
