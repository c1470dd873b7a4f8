//! `theory`: theories of rough contact for a surface on a body, without solving a contact.

mod figures;

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use clap::Args as ClapArgs;
use gfmd_measure::SelfAffineArea;
use gfmd_measure::theory::{Asperities, AsperityTheory, ENERGY_FACTOR, Persson};
use gfmd_problem::key;
use gfmd_record::{Importance, Printed, Sheet, largest, significant};
use gfmd_surface::PowerSpectrum;
use gfmd_unit::Units;
use serde::Serialize;

use crate::loads::PressingArgs;
use crate::session::{list_files, print_note, print_sheet};
use gfmd_input::failure::Failure;
use gfmd_input::session::Session;
use gfmd_input::source::SourceArgs;
use gfmd_problem::options::BodyArgs;
use gfmd_problem::options::Method;
use gfmd_problem::options::{Kinds, Options};
use gfmd_report::figures::parse_prefix;

/// Flags of `theory`.
#[derive(ClapArgs, Options, Clone, Debug)]
#[command(after_help = "Examples:
  gfmd theory --n 512 --hurst 0.8 --p-star 0.001,0.01,0.1
  gfmd theory --n 512 --height 0.05 --poisson 0.49 --p-star 0.02 --plots theory
  gfmd theory --n 512 --unit um --size 100um --young 70GPa --pressure 1MPa,10MPa
  gfmd theory --surface scan.txt --detrend plane --e-star 1e9 --p-star 0.02 --wavelength 1e-4,1e-5,1e-6 --json")]
pub struct Args {
    #[command(flatten)]
    source: SourceArgs,
    #[command(flatten)]
    body: BodyArgs,
    #[command(flatten)]
    loads: PressingArgs,
    /// Wavelengths below which roughness is left out, for the area at a magnification
    #[arg(long, value_delimiter = ',', value_name = "L1,L2,..", allow_negative_numbers = true, help_heading = "Load")]
    #[option(kinds = Kinds::LENGTH)]
    wavelength: Vec<f64>,
    /// Draw area, mean gap and pressure distribution: PREFIX-area.svg, PREFIX-gap.svg, PREFIX-pressure.svg, and .png
    #[arg(long, value_name = "PREFIX", value_parser = parse_prefix, help_heading = "Output")]
    plots: Option<PathBuf>,
}

/// Printed result.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Report {
    pub n: [usize; 2],
    pub size: [f64; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stress_unit: Option<String>,
    pub surface: String,
    pub rms_height: f64,
    pub rms_gradient: f64,
    pub nayak: Option<f64>,
    pub summit_density: Option<f64>,
    pub e_star: f64,
    pub full_contact_deviation: f64,
    pub hurst: Option<f64>,
    pub loads: Vec<Load>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub plots: Vec<PathBuf>,
}

/// Theories at one load.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Load {
    pub p_star: f64,
    pub mean_pressure: f64,
    pub persson: PerssonRecord,
    /// `null` for profiles, bodies other than a half-space, and beyond the range of the theory.
    pub bush_gibson_thomas: Option<AsperityRecord>,
    pub greenwood_williamson: Option<AsperityRecord>,
    /// `null` for surfaces not generated from a spectrum with a Hurst exponent, with a roll-off, profiles, and bodies
    /// other than a half-space.
    pub self_affine: Option<AreaRecord>,
    /// Reasons for missing values, with the names of the numbers.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub undefined: BTreeMap<&'static str, Vec<&'static str>>,
}

/// Persson's theory at one load.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct PerssonRecord {
    pub area_fraction: f64,
    pub mean_gap: f64,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub at_wavelength: Vec<Magnified>,
}

/// Contact area without waves shorter than the wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Magnified {
    pub wavelength: f64,
    pub area_fraction: f64,
}

/// Theory of asperities at one load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct AsperityRecord {
    pub area_fraction: f64,
    pub separation: f64,
}

/// Fitted area in the limit at one load.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct AreaRecord {
    pub area_fraction: f64,
    pub standard_error: f64,
    /// Area for a spectrum with a cut-off, as in the generator.
    pub of_band: f64,
    /// Area counted on the grid; `null` beyond the loads of its fit.
    pub counted: Option<f64>,
}

/// Theories of one surface on one body.
struct Theories {
    persson: Persson,
    asperities: Result<Asperities, &'static str>,
    self_affine: Result<SelfAffineArea, &'static str>,
    /// eps_f and eps_c of the generator.
    eps: [f64; 2],
    e_star: f64,
    rms_gradient: f64,
}

/// Reason for a body without a theory.
const NO_HALF_SPACE: &str = "the body is not a half-space";
/// Reason of the theories of isotropic surfaces.
const ISOTROPIC: &str = "the surface has a lay, and the theory is for isotropic ones";

/// Reason for loads beyond the theories of asperities.
const NO_SUCH_LOAD: &str =
    "summits are independent only up to half of the surface in contact, and no load is known beyond 12 rms heights";

/// Reason for loads with unknown counted area.
const NOT_COUNTED: &str = "it is fitted up to p* = 1.2, and up to full contact";

/// Runs the command.
///
/// # Errors
/// Returns an error for a surface or body that cannot be used, a flat surface, or a load that is not positive.
pub fn run(args: &Args, session: &Session) -> Result<Report, Failure> {
    let positive =
        |option: &str, values: &[f64]| match values.iter().find(|value| !(**value > 0.0 && value.is_finite())) {
            Some(found) => Err(Failure::value(key(option), found, "positive")),
            None => Ok(()),
        };
    args.loads.given()?;
    positive("wavelength", &args.wavelength)?;
    let surface = args.source.surface(session)?;
    args.body.check_modulus(surface.unit.as_deref())?;
    let body = args.body.body()?;
    let grid = surface.grid;
    let e_star = body.contact_modulus();
    let rms_gradient = surface.rms_gradient();
    args.body.check_on(&grid, e_star * rms_gradient)?;
    let loads = args.loads.reduced(e_star * rms_gradient, &grid)?;
    let spectrum = PowerSpectrum::of(&surface.heights, &grid).map_err(|error| Failure::refused(error.to_string()))?;
    let waves = grid.modes().zip(spectrum.power()).filter(|(mode, _)| !mode.is_uniform());
    let waves = waves.map(|(mode, power)| (mode.wavenumber(), mode.weight * power));
    let flat =
        || Failure::refused(format!("{} is flat; it must be rough for a theory of rough contact", args.source.name()));
    let persson = Persson::new(waves, |q| body.normal_stiffness(q)).ok_or_else(flat)?;
    let moments = spectrum.moments();
    let generator = &args.source.generator;
    let made = args.source.surface.is_none() && generator.shape.is_none();
    let made = made && generator.method == Method::Psd && !grid.is_line();
    let hurst = made.then(|| generator.hurst());
    let eps = match made {
        true => {
            let spectrum = generator.spectrum(&grid)?;
            let shortest = spectrum.shortest_wavelength;
            [shortest / spectrum.longest_wavelength, grid.spacing()[0] / shortest]
        }
        false => [0.0; 2],
    };
    // The other theories hold for half-spaces only.
    let longest = std::f64::consts::TAU / grid.lengths()[0];
    let is_half_space = (body.normal_stiffness(longest) / (0.5 * e_star * longest) - 1.0).abs() < 1e-9;
    let has_lay = made && generator.aspect.is_some_and(|aspect| aspect > 1.0);
    let theories = Theories {
        persson,
        asperities: match (grid.is_line(), is_half_space) {
            (true, _) => Err("the surface is a profile"),
            _ if has_lay => Err(ISOTROPIC),
            (_, false) => Err(NO_HALF_SPACE),
            _ => Asperities::new(moments.profile()).ok_or("a surface with these moments has no Gaussian summits"),
        },
        self_affine: match (hurst, is_half_space) {
            (None, _) => Err("the surface is not generated in three dimensions by psd"),
            _ if generator.roll_off.is_some() => Err("the formula is for spectra without a roll-off"),
            _ if has_lay => Err(ISOTROPIC),
            (_, false) => Err(NO_HALF_SPACE),
            (Some(hurst), _) => SelfAffineArea::new(hurst).ok_or("the formula is for Hurst exponents from 0 to 1"),
        },
        eps,
        e_star,
        rms_gradient,
    };
    let plots = match &args.plots {
        Some(prefix) => figures::draw(prefix, &theories, &loads, surface.unit())?,
        None => Vec::new(),
    };
    Ok(Report {
        n: grid.points(),
        size: grid.lengths(),
        unit: surface.unit.clone(),
        stress_unit: surface.stress_unit.clone(),
        surface: surface.description,
        rms_height: moments.rms_height(),
        rms_gradient,
        nayak: moments.nayak(),
        summit_density: theories.asperities.as_ref().ok().map(Asperities::density),
        e_star,
        full_contact_deviation: theories.persson.variance(f64::INFINITY).sqrt(),
        hurst,
        loads: loads.iter().map(|p_star| theories.at(*p_star, &args.wavelength)).collect(),
        plots,
    })
}

impl Theories {
    fn pressure(&self, p_star: f64) -> f64 {
        p_star * self.e_star * self.rms_gradient
    }

    fn area(&self, p_star: f64) -> f64 {
        self.persson.area(self.pressure(p_star), f64::INFINITY)
    }

    fn mean_gap(&self, p_star: f64) -> f64 {
        self.persson.mean_gap(self.pressure(p_star), ENERGY_FACTOR)
    }

    fn asperity(&self, theory: AsperityTheory, p_star: f64) -> Result<AsperityRecord, &'static str> {
        let asperities = self.asperities.as_ref().map_err(|reason| *reason)?;
        let found = asperities.at_pressure(theory, p_star * self.rms_gradient).ok_or(NO_SUCH_LOAD)?;
        Ok(AsperityRecord { area_fraction: found.area_fraction, separation: found.separation })
    }

    fn at(&self, p_star: f64, wavelengths: &[f64]) -> Load {
        let mean_pressure = self.pressure(p_star);
        let magnified = |wavelength: &f64| Magnified {
            wavelength: *wavelength,
            area_fraction: self.persson.area(mean_pressure, std::f64::consts::TAU / wavelength),
        };
        let limit = |area: SelfAffineArea| AreaRecord {
            area_fraction: area.at(p_star),
            standard_error: area.standard_error(p_star),
            of_band: area.of_band(self.eps[0], p_star),
            counted: area.counted(self.eps[0], self.eps[1], p_star),
        };
        let bush = self.asperity(AsperityTheory::BushGibsonThomas, p_star);
        let greenwood = self.asperity(AsperityTheory::GreenwoodWilliamson, p_star);
        let self_affine = self.self_affine.map(limit);
        let counted = self_affine.ok().filter(|area| area.counted.is_none()).map(|_| NOT_COUNTED);
        let mut undefined: BTreeMap<_, Vec<_>> = BTreeMap::new();
        for (name, reason) in [
            ("bush_gibson_thomas", bush.err()),
            ("greenwood_williamson", greenwood.err()),
            ("self_affine", self_affine.err()),
            ("self_affine.counted", counted),
        ] {
            reason.into_iter().for_each(|reason| undefined.entry(reason).or_default().push(name));
        }
        Load {
            p_star,
            mean_pressure,
            persson: PerssonRecord {
                area_fraction: self.area(p_star),
                mean_gap: self.mean_gap(p_star),
                at_wavelength: wavelengths.iter().map(magnified).collect(),
            },
            bush_gibson_thomas: bush.ok(),
            greenwood_williamson: greenwood.ok(),
            self_affine: self_affine.ok(),
            undefined,
        }
    }
}

impl Report {
    /// Returns a column of numbers, with the readable unit of their kind.
    fn column(&self, word: &str, kind: &str, importance: Importance, of: &dyn Fn(&Load) -> Option<f64>) -> Printed {
        let values: Vec<Option<f64>> = self.loads.iter().map(of).collect();
        let unit = self.units().shown(kind, largest(values.iter().copied().flatten()));
        let head = unit.as_ref().map_or_else(|| word.to_owned(), |unit| format!("{word} / {}", unit.divisor()));
        let number = |value: f64| match &unit {
            Some(unit) => significant(value * unit.factor),
            None => format!("{value:.3e}"),
        };
        let cells = values.into_iter().map(|value| value.map_or_else(|| "-".to_owned(), number));
        Printed { word: word.to_owned(), cells: std::iter::once(head).chain(cells).collect(), importance }
    }

    /// Returns the table of the areas at the wavelengths; empty without one.
    fn magnified(&self) -> Vec<Printed> {
        let mut seen: Vec<(f64, Magnified)> = Vec::new();
        for load in &self.loads {
            seen.extend(load.persson.at_wavelength.iter().map(|seen| (load.p_star, *seen)));
        }
        if seen.is_empty() {
            return Vec::new();
        }
        let unit = self.units().shown("length", largest(seen.iter().map(|(_, seen)| seen.wavelength)));
        let (factor, name) = unit.map_or((1.0, String::new()), |unit| (unit.factor, format!(" / {}", unit.name)));
        let column = |head: String, cells: Vec<String>| {
            let cells = std::iter::once(head.clone()).chain(cells).collect();
            Printed { word: head, cells, importance: Importance::Main }
        };
        vec![
            column("p*".into(), seen.iter().map(|(p_star, _)| format!("{p_star:.3e}")).collect()),
            column(
                format!("wavelength{name}"),
                seen.iter().map(|(_, seen)| significant(seen.wavelength * factor)).collect(),
            ),
            column("Persson".into(), seen.iter().map(|(_, seen)| format!("{:.3e}", seen.area_fraction)).collect()),
        ]
    }

    fn units(&self) -> Units {
        Units::new(self.unit.as_deref(), self.stress_unit.as_deref())
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let units = self.units();
        writeln!(f, "{}", self.surface)?;
        let [height, modulus] = [units.words(self.rms_height, "length"), units.words(self.e_star, "stress")];
        writeln!(f, "rms height {height}, rms gradient {:.4e}, E* {modulus}", self.rms_gradient)?;
        if let (Some(nayak), Some(density)) = (self.nayak, self.summit_density) {
            let unit = self.unit.as_deref().unwrap_or("length");
            writeln!(f, "Nayak's parameter {nayak:.4}, {density:.4e} summits for each {unit}^2")?;
        }
        let deviation = units.words(self.full_contact_deviation, "stress");
        writeln!(f, "pressure in full contact: standard deviation {deviation}\n")?;
        let column = |word, importance, of: &dyn Fn(&Load) -> Option<f64>| self.column(word, "1", importance, of);
        let columns = vec![
            column("p*", Importance::Main, &|load| Some(load.p_star)),
            self.column("pressure", "stress", Importance::Usual, &|load| Some(load.mean_pressure)),
            column("Persson", Importance::Main, &|load| Some(load.persson.area_fraction)),
            column("BGT", Importance::Usual, &|load| load.bush_gibson_thomas.map(|found| found.area_fraction)),
            column("GW", Importance::Detail, &|load| load.greenwood_williamson.map(|found| found.area_fraction)),
            column("formula", Importance::Usual, &|load| load.self_affine.map(|area| area.area_fraction)),
            column("counted", Importance::Detail, &|load| load.self_affine.and_then(|area| area.counted)),
            self.column("mean gap", "length", Importance::Main, &|load| Some(load.persson.mean_gap)),
        ];
        print_sheet(f, |width| Sheet::of(columns, width), 0, |_| String::new(), |_| String::new())?;
        print_note(
            f,
            "area fractions of Persson's theory, of Bush, Gibson and Thomas (BGT), and of Greenwood and Williamson \
             (GW); mean gap of Persson's theory",
        )?;
        let reasons: BTreeMap<_, _> = self.loads.iter().flat_map(|load| &load.undefined).collect();
        for (reason, names) in reasons {
            print_note(f, &format!("no {}: {reason}", names.join(", ")))?;
        }
        if self.loads.iter().any(|load| load.self_affine.is_some()) {
            print_note(
                f,
                "formula: area fraction fitted to computed contacts in the limit of endless spectra; counted: on this \
                 band and grid (docs/results.md)",
            )?;
        }
        let seen = self.magnified();
        if !seen.is_empty() {
            writeln!(f)?;
            print_sheet(f, |width| Sheet::of(seen, width), 0, |_| String::new(), |_| String::new())?;
            print_note(f, "area fraction of Persson's theory, seen without waves shorter than the wavelength")?;
        }
        list_files(f, None, &self.plots)
    }
}
