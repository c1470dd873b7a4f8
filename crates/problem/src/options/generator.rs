//! Generated surfaces: heights from flags that describe a self-affine spectrum, and a seed.

use std::fmt;
use std::str::FromStr;

use clap::{Args, ValueEnum};
use gfmd_field::{Grid, Share};
use gfmd_surface::{
    Amplitudes, Anisotropy, Dimension, Discretisation, Displaced, Marginal, Normalisation, PowerSpectrum, RealSpace,
    RollOff, RollOffShape, SelfAffine, Shape, SurfaceError, centred,
};
use ndarray::{Array2, s};
use serde::{Deserialize, Serialize};

use super::choice::{named, parse_choice};
use super::text;
use super::values::within;
use crate::options::{Kinds, Options};
use crate::{Unusable, check_size, key, setting, words};

/// The largest seed: whole numbers of a configuration, which is TOML, have 63 bits.
pub const LARGEST_SEED: u64 = i64::MAX as u64;

/// The default number of points along one side.
const POINTS: usize = 256;

/// The default of 1/eps_t.
const EPS_T_INV: f64 = 2.0;

/// The default of 1/eps_f with --eps-c-inv and without --n.
const EPS_F_INV: f64 = 32.0;

/// The value of 1/eps_c to which the default of 1/eps_f leads.
const EPS_C_INV: f64 = 4.0;

/// The default Hurst exponent.
const HURST: f64 = 0.8;

/// The default rms gradient.
const RMS_GRADIENT: f64 = 0.1;

/// The default seed.
const SEED: u64 = 1;

/// Largest ratio of wavelengths: the points of the longest possible grid.
const MOST_POINTS: f64 = (1_u64 << 31) as f64;

/// Flags that describe a generated surface. The defaults are 256² points, ε_t = 1/2, ε_f = 1/32, H = 0.8, ḡ = 0.1.
#[derive(Args, Options, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Generated surface")]
pub struct GeneratorArgs {
    /// Points along each side, N or NX,NY; alternative to --eps-c-inv [default: 256]
    #[arg(long, value_delimiter = ',', value_name = "N")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub n: Vec<usize>,
    /// Analytic shape with its top at the cell centre: sphere:R=, paraboloid:R= (or Rx=,Ry=), ellipsoid:a=,b=,c=,
    /// cylinder:R= (,axis=y), cone:slope=, wedge:slope= (,axis=y), flat-punch:a=,R= (,depth=), wave:A= (,Lx=,Ly=).
    /// Smooth unless --hurst, --rms-gradient or --rms-height adds roughness
    #[arg(long, value_name = "KIND:KEY=VALUE,..", value_parser = Shape::from_str)]
    #[serde(with = "text", skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::SHAPE)]
    pub shape: Option<Shape>,
    /// Hurst exponent, 0 to 1 [default: 0.8]
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hurst: Option<f64>,
    /// Cell length divided by the longest wavelength, at least 1 [default: 2]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eps_t_inv: Option<f64>,
    /// Longest wavelength divided by the shortest, at least 1 [default: 4 points per shortest wavelength]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eps_f_inv: Option<f64>,
    /// Grid points per shortest wavelength, at least 2; alternative to --n [default: follows from --n]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub eps_c_inv: Option<f64>,
    /// Scale to this root-mean-square gradient (full gradient, spectral) [default: 0.1]
    #[arg(long, value_name = "G", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rms_gradient: Option<f64>,
    /// Scale to this root-mean-square height instead, length
    #[arg(long, value_name = "LENGTH", conflicts_with = "rms_gradient", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::LENGTH)]
    pub rms_height: Option<f64>,
    /// Random seed, below 2^63; seed and cell determine the surface on any grid
    #[arg(long, default_value_t = SEED, value_parser = clap::value_parser!(u64).range(..=LARGEST_SEED))]
    #[serde(deserialize_with = "within::<0, LARGEST_SEED, _, _>")]
    pub seed: u64,
    /// 3: surface; 2: profile, in plane strain
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u8).range(2..=3))]
    #[serde(deserialize_with = "within::<2, 3, _, _>")]
    pub dim: u8,
    /// Method: spectral (psd), or subdivision (sra, rmd), which is neither periodic nor isotropic and has no cut-offs
    #[arg(long, value_enum, default_value_t = Method::Psd)]
    pub method: Method,
    /// Roll-off wavelength, length; the spectrum is flat at longer wavelengths
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::LENGTH)]
    pub roll_off: Option<f64>,
    /// Transition from the power law to the flat part of the spectrum
    #[arg(
        long,
        value_parser = parse_choice::<RollOffShape>(),
        default_value_t = RollOffShape::Plateau,
        requires = "roll_off"
    )]
    #[serde(with = "named")]
    pub roll_off_shape: RollOffShape,
    /// Mode amplitudes: random, or the expected values with random phases
    #[arg(long, value_parser = parse_choice::<Amplitudes>(), default_value_t = Amplitudes::Gaussian)]
    #[serde(with = "named")]
    pub amplitudes: Amplitudes,
    /// Correlation length along the lay divided by the one across it, at least 1: waves along the lay are longer by its
    /// square root, waves across it shorter
    #[arg(long, value_name = "R", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub aspect: Option<f64>,
    /// Direction of the lay, degrees from x [default: 0]
    #[arg(long, value_name = "DEGREES", requires = "aspect", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lay: Option<f64>,
    /// Height distribution: lognormal:SIGMA or weibull:SHAPE, mirrored for a negative number; or a FILE with the
    /// columns height and fraction of the surface below it, or rows HEIGHT:PROBABILITY,... Mean and width do not
    /// matter; the spectrum is kept [default: normal]
    #[arg(
        long,
        value_name = "lognormal:SIGMA|weibull:SHAPE|FILE",
        value_parser = Marginal::from_str,
        allow_hyphen_values = true
    )]
    #[serde(with = "text", skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::MARGINAL)]
    pub marginal: Option<Marginal>,
}

/// The ways to make a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// Random phases with a given power spectral density
    #[default]
    Psd,
    /// Successive random addition
    Sra,
    /// Random midpoint displacement
    Rmd,
}

impl GeneratorArgs {
    /// Returns the flags with every default filled in, for the record of a run.
    ///
    /// # Errors
    /// Returns an error if the numbers do not make a grid.
    pub fn resolved(&self) -> Result<Self, Unusable> {
        let mut whole = self.clone();
        if self.is_rough() {
            whole.hurst = Some(self.hurst());
            whole.rms_gradient = Some(self.rms_gradient.unwrap_or(RMS_GRADIENT));
        }
        if self.method == Method::Psd && self.is_rough() {
            whole.eps_t_inv = Some(self.eps_t_inv.unwrap_or(EPS_T_INV));
            let [nx, ny] = self.points()?;
            whole.eps_f_inv = Some(self.eps_f_inv_on(if self.dim == 2 { nx } else { nx.min(ny) } as f64));
        }
        let [nx, ny] = self.points()?;
        (whole.n, whole.eps_c_inv) = (if self.dim == 2 || nx == ny { vec![nx] } else { vec![nx, ny] }, None);
        Ok(whole)
    }

    /// Builds the grid in a cell of `length`: Lx and Ly, or Lx (1 if empty) with equal spacings along x and y.
    ///
    /// # Errors
    /// Returns an error if the numbers do not make a grid, or the lengths do not make a cell.
    pub fn grid(&self, length: &[f64]) -> Result<Grid, Unusable> {
        let [nx, ny] = self.points()?;
        let along_x = length.first().copied().unwrap_or(1.0);
        let grid = match (self.dim, length) {
            (2, [] | [_]) => Grid::line(nx, along_x),
            (2, _) => return Err(Unusable::value(key("size"), format!("{length:?}"), "one length for a profile")),
            (_, [lx, ly]) => Grid::new([nx, ny], [*lx, *ly]),
            (_, [] | [_]) => Grid::new([nx, ny], [along_x, along_x * ny as f64 / nx as f64]),
            _ => return Err(Unusable::value(key("size"), format!("{length:?}"), "L or LX,LY")),
        };
        grid.map_err(|error| Unusable::input(key("size"), error))
    }

    /// Returns true for random heights, in place of a shape or added to it.
    pub fn is_rough(&self) -> bool {
        self.shape.is_none() || self.hurst.is_some() || self.rms_gradient.is_some() || self.rms_height.is_some()
    }

    /// Returns true if the heights are periodic: waves, without a shape that has kinks at the edges of the cell.
    pub fn is_periodic(&self) -> bool {
        self.shape.is_none_or(|shape| shape.is_wave()) && (self.method == Method::Psd || !self.is_rough())
    }

    /// Returns the Hurst exponent.
    pub fn hurst(&self) -> f64 {
        self.hurst.unwrap_or(HURST)
    }

    /// Checks that the grid resolves the shape, and that no option of roughness is given beside a smooth one.
    ///
    /// # Errors
    /// Returns an error that names the option.
    pub fn check_shape(&self, grid: &Grid, is_periodic: bool) -> Result<(), Unusable> {
        let Some(shape) = &self.shape else { return Ok(()) };
        shape.check_on(grid, is_periodic).map_err(|error| Unusable::input(key("shape"), error))?;
        let beside = [
            ("eps_t_inv", self.eps_t_inv.is_some()),
            ("eps_f_inv", self.eps_f_inv.is_some()),
            ("eps_c_inv", self.eps_c_inv.is_some()),
            ("seed", self.seed != SEED),
            ("method", self.method != Method::Psd),
            ("roll_off", self.roll_off.is_some()),
            ("amplitudes", self.amplitudes != Amplitudes::Gaussian),
            ("aspect", self.aspect.is_some()),
            ("marginal", self.marginal.is_some()),
        ];
        match beside.into_iter().find(|(_, is_given)| *is_given && !self.is_rough()) {
            Some((option, _)) => Err(Unusable::of(words![
                key(option),
                " describes roughness, and ",
                setting("shape", shape.kind()),
                " is smooth; ",
                key("hurst"),
                " adds roughness to it"
            ])),
            None => Ok(()),
        }
    }

    /// Generates the heights on a grid from [`GeneratorArgs::grid`]: `[x, y]`, length. Random heights have mean zero, a
    /// shape has its top at zero.
    ///
    /// # Errors
    /// Returns an error if a flag is out of range, or if flags cannot be combined.
    pub fn heights(&self, grid: &Grid) -> Result<Array2<f64>, Unusable> {
        self.with_shape(self.roughness(grid)?, grid, &grid.whole(), [0.0; 2])
    }

    /// Generates the heights at the cell centres of a patch, whose grid has `times` as many points as another one with
    /// points where the waves begin.
    ///
    /// # Errors
    /// Fails like [`heights`](Self::heights).
    pub fn heights_centred(&self, grid: &Grid, times: usize) -> Result<Array2<f64>, Unusable> {
        let rough = self.roughness(grid)?.map(|rough| centred(&rough, grid, times));
        let rough = rough.transpose().map_err(|error| of_option(&error))?;
        self.with_shape(rough, grid, &grid.whole(), [0.5 * (times as f64 - 1.0); 2])
    }

    /// Generates random heights; `None` for a smooth shape.
    fn roughness(&self, grid: &Grid) -> Result<Option<Array2<f64>>, Unusable> {
        if !self.is_rough() {
            return Ok(None);
        }
        self.check_normalisation()?;
        Ok(Some(match self.method {
            Method::Psd => match &self.marginal {
                Some(marginal) => {
                    marginal.heights(&self.spectrum(grid)?, grid, self.seed).map_err(|error| of_option(&error))?
                }
                None => self.rough_rows(grid, &grid.whole())?,
            },
            Method::Sra => self.subdivided(grid, Displaced::AllPoints)?,
            Method::Rmd => self.subdivided(grid, Displaced::Midpoints)?,
        }))
    }

    /// Returns true if several processes generate their own rows by [`heights_shared`](Self::heights_shared).
    pub fn is_shared(&self) -> bool {
        self.method == Method::Psd && self.marginal.is_none()
    }

    /// Returns true if the same surface can be generated on a finer grid.
    pub fn has_finer_grids(&self) -> bool {
        self.method == Method::Psd
    }

    /// Generates the rows of [shared](Self::is_shared) heights, or of a shape, in the `share` of this process.
    ///
    /// # Errors
    /// Fails like [`heights`](Self::heights), on all processes.
    pub fn heights_shared(&self, grid: &Grid, share: &Share) -> Result<Array2<f64>, Unusable> {
        let rough = if self.is_rough() { Some(self.rough_rows(grid, share)?) } else { None };
        self.with_shape(rough, grid, share, [0.0; 2])
    }

    fn rough_rows(&self, grid: &Grid, share: &Share) -> Result<Array2<f64>, Unusable> {
        self.check_normalisation()?;
        self.spectrum(grid)?.heights_over(grid, self.seed, share).map_err(|error| of_option(&error))
    }

    /// Adds the heights of the shape, displaced from the points by `steps` of the grid.
    fn with_shape(
        &self,
        rough: Option<Array2<f64>>,
        grid: &Grid,
        share: &Share,
        steps: [f64; 2],
    ) -> Result<Array2<f64>, Unusable> {
        // The values of a profile are one row of its share.
        let (own, [_, ny]) = (share.own(), grid.points());
        let rows = own.start / ny..own.end / ny;
        // Both follow from `is_rough`.
        match (self.shape.map(|shape| shape.heights(grid, rows, steps)), rough) {
            (Some(shape), Some(rough)) => Ok(shape + rough),
            (Some(heights), None) | (None, Some(heights)) => Ok(heights),
            (None, None) => Err(Unusable::missing("shape", "it is needed without roughness")),
        }
    }

    fn check_normalisation(&self) -> Result<(), Unusable> {
        let (option, size) = match self.normalisation() {
            Normalisation::RmsGradient(gradient) => ("rms_gradient", gradient),
            Normalisation::RmsHeight(height) => ("rms_height", height),
        };
        if size.is_finite() && size > 0.0 {
            check_size(option, size)?;
        }
        Ok(())
    }

    /// Returns the number of points along x and y.
    ///
    /// # Errors
    /// Returns an error if the numbers do not make a grid.
    pub fn points(&self) -> Result<[usize; 2], Unusable> {
        let allowed = || Unusable::value(key("n"), format!("{:?}", self.n), "N, or NX,NY for a surface");
        let [nx, ny] = match (&self.n[..], self.eps_c_inv) {
            (_, Some(_)) if self.method != Method::Psd => return Err(self.no_cut_offs("eps_c_inv")),
            ([_, ..], Some(_)) => {
                return Err(Unusable::of(words![
                    key("eps_c_inv"),
                    " follows from ",
                    key("n"),
                    "; give one of the two"
                ]));
            }
            ([], Some(eps_c_inv)) => {
                let eps_t_inv = self.eps_t_inv.unwrap_or(EPS_T_INV);
                let eps_f_inv = self.eps_f_inv.unwrap_or(EPS_F_INV);
                let points = Discretisation { eps_t_inv, eps_f_inv, eps_c_inv }.points();
                [points.map_err(|error| of_option(&error))?; 2]
            }
            ([], None) => [POINTS; 2],
            ([n], None) => [*n; 2],
            ([nx, ny], None) if self.dim == 3 => [*nx, *ny],
            _ => return Err(allowed()),
        };
        if nx < 2 || ny < 2 {
            return Err(Unusable::value(key("n"), nx.min(ny), "at least 2"));
        }
        Ok([nx, if self.dim == 2 { 1 } else { ny }])
    }

    /// Returns the spectrum of `--method psd`; the discretisation numbers refer to the shorter side of the cell.
    ///
    /// # Errors
    /// Returns an error if a number is out of range, or if the grid is too coarse for the shortest wavelength.
    pub fn spectrum(&self, grid: &Grid) -> Result<SelfAffine, Unusable> {
        let sides = if grid.is_line() { 1 } else { 2 };
        let smaller = |values: [f64; 2]| values[..sides].iter().copied().fold(f64::INFINITY, f64::min);
        let larger = |values: [f64; 2]| values[..sides].iter().copied().fold(0.0, f64::max);
        let eps_t_inv = self.eps_t_inv.unwrap_or(EPS_T_INV);
        let eps_f_inv = self.eps_f_inv_on(smaller(grid.lengths()) / larger(grid.spacing()));
        for (option, found) in [("eps_t_inv", eps_t_inv), ("eps_f_inv", eps_f_inv)] {
            if !(1.0..=MOST_POINTS).contains(&found) {
                return Err(Unusable::value(key(option), found, format!("between 1 and {MOST_POINTS}")));
            }
        }
        let longest = smaller(grid.lengths()) / eps_t_inv;
        let shortest = smaller(grid.lengths()) / (eps_t_inv * eps_f_inv);
        let anisotropy = self.anisotropy(grid)?;
        let stretch = anisotropy.map_or(1.0, |anisotropy| anisotropy.stretch());
        if longest * stretch > larger(grid.lengths()) * (1.0 + 1e-12) {
            let allowed = format!(
                "at most {}: waves along the lay must fit into the cell",
                (larger(grid.lengths()) / longest).powi(2)
            );
            return Err(Unusable::value(
                key("aspect"),
                anisotropy.map_or(1.0, |anisotropy| anisotropy.aspect),
                allowed,
            ));
        }
        let per_wave = shortest / stretch / larger(grid.spacing());
        if per_wave < 2.0 * (1.0 - 1e-12) {
            let n = self.n.iter().map(usize::to_string).collect::<Vec<_>>().join(",");
            let n = if n.is_empty() { POINTS.to_string() } else { n };
            return Err(Unusable::contradicts(
                key("n"),
                n,
                words![
                    "with ",
                    setting("eps_t_inv", eps_t_inv),
                    " and ",
                    setting("eps_f_inv", eps_f_inv),
                    format!(" the shortest wavelength has {per_wave} points, and it must have at least 2"),
                ],
            ));
        }
        let roll_off = self.roll_off.map(|wavelength| RollOff { wavelength, shape: self.roll_off_shape });
        Ok(SelfAffine {
            hurst: self.hurst(),
            longest_wavelength: longest,
            shortest_wavelength: shortest,
            roll_off,
            amplitudes: self.amplitudes,
            anisotropy,
            normalisation: self.normalisation(),
            ..SelfAffine::with_rms_gradient(self.rms_gradient.unwrap_or(RMS_GRADIENT))
        })
    }

    /// Returns the preferred direction.
    fn anisotropy(&self, grid: &Grid) -> Result<Option<Anisotropy>, Unusable> {
        let Some(aspect) = self.aspect else {
            return match self.lay {
                Some(lay) => Err(Unusable::value(key("lay"), lay, words!["left out without ", key("aspect")])),
                None => Ok(None),
            };
        };
        if !(aspect >= 1.0 && aspect.is_finite()) {
            return Err(Unusable::value(key("aspect"), aspect, "at least 1 and finite"));
        }
        if grid.is_line() {
            return Err(Unusable::value(key("aspect"), aspect, "left out for a profile"));
        }
        let lay = self.lay.unwrap_or(0.0);
        if !lay.is_finite() {
            return Err(Unusable::value(key("lay"), lay, "finite"));
        }
        Ok(Some(Anisotropy { aspect, lay }))
    }

    /// Returns 1/eps_f; the default gives four points per shortest wavelength on a side of `side` points.
    fn eps_f_inv_on(&self, side: f64) -> f64 {
        let stretch = self.aspect.map_or(1.0, f64::sqrt);
        let room = side / (self.eps_t_inv.unwrap_or(EPS_T_INV) * self.eps_c_inv.unwrap_or(EPS_C_INV) * stretch);
        self.eps_f_inv.unwrap_or_else(|| room.max(1.0))
    }

    /// Returns the property to which the heights are scaled.
    pub fn normalisation(&self) -> Normalisation {
        let gradient = self.rms_gradient.unwrap_or(RMS_GRADIENT);
        self.rms_height.map_or(Normalisation::RmsGradient(gradient), Normalisation::RmsHeight)
    }

    /// Generates heights by subdivision on at least as many points as the grid has, crops them to the grid, subtracts
    /// their mean and scales them.
    fn subdivided(&self, grid: &Grid, displaced: Displaced) -> Result<Array2<f64>, Unusable> {
        let options = [
            ("eps_t_inv", self.eps_t_inv),
            ("eps_f_inv", self.eps_f_inv),
            ("roll_off", self.roll_off),
            ("aspect", self.aspect),
        ];
        if let Some((option, _)) = options.into_iter().find(|(_, value)| value.is_some()) {
            return Err(self.no_cut_offs(option));
        }
        if self.amplitudes == Amplitudes::Fixed {
            let allowed = words!["gaussian with ", setting("method", self.method)];
            return Err(Unusable::value(key("amplitudes"), "fixed", allowed));
        }
        if let Some(marginal) = &self.marginal {
            let allowed = words!["left out with ", setting("method", self.method), ", which has no spectrum to keep"];
            return Err(Unusable::value(key("marginal"), marginal, allowed));
        }
        let [nx, ny] = grid.points();
        let subdivisions = nx.max(ny).next_power_of_two().ilog2().max(1);
        let generator = RealSpace { hurst: self.hurst(), subdivisions, rms_increment: 1.0, displaced };
        let made = match Dimension::of(grid) {
            Dimension::Profile => generator.profile(self.seed),
            Dimension::Surface => generator.surface(self.seed),
        };
        let mut heights = made.map_err(|error| of_option(&error))?.slice(s![..nx, ..ny]).to_owned();
        heights -= heights.mean().unwrap_or(0.0);
        let moments = PowerSpectrum::of(&heights, grid).map_err(|error| of_option(&error))?.moments();
        let (option, found, asked) = match self.normalisation() {
            Normalisation::RmsGradient(asked) => ("rms_gradient", moments.rms_gradient(), asked),
            Normalisation::RmsHeight(asked) => ("rms_height", moments.rms_height(), asked),
        };
        if !(asked.is_finite() && asked > 0.0) {
            return Err(Unusable::value(key(option), asked, "positive and finite"));
        }
        if found == 0.0 {
            return Err(Unusable::input(key("n"), format!("{nx} x {ny} points make a flat surface; more are needed")));
        }
        heights *= asked / found;
        Ok(heights)
    }

    fn no_cut_offs(&self, option: &'static str) -> Unusable {
        let why =
            words![setting("method", self.method), " has no cut-offs; only ", setting("method", "psd"), " has them"];
        Unusable::of(why).at(key(option))
    }
}

impl fmt::Display for GeneratorArgs {
    /// Writes the kind of surface in words.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let what = if self.dim == 2 { "profile" } else { "surface" };
        match &self.shape {
            Some(shape) if !self.is_rough() => return write!(f, "smooth {what}, {shape}"),
            Some(shape) => write!(f, "{shape} with roughness of a ")?,
            None => {}
        }
        write!(f, "generated {what}, method {}, Hurst exponent {}, seed {}", self.method, self.hurst(), self.seed)?;
        if let Some(aspect) = self.aspect {
            write!(f, ", aspect {aspect} along {}°", self.lay.unwrap_or(0.0))?;
        }
        match &self.marginal {
            Some(marginal) => write!(f, ", heights {}", marginal.name()),
            None => Ok(()),
        }
    }
}

impl fmt::Display for Method {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Psd => "psd",
            Self::Sra => "sra",
            Self::Rmd => "rmd",
        })
    }
}

/// Returns an error of the library under the name of its option.
fn of_option(error: &SurfaceError) -> Unusable {
    let option = match error {
        SurfaceError::Hurst(_) => "hurst",
        SurfaceError::NoRoomForPhases { .. } | SurfaceError::Marginal { .. } => "marginal",
        SurfaceError::RollOff { .. } => "roll_off",
        SurfaceError::NotPositive { what: "rms height", .. } => "rms_height",
        SurfaceError::NotPositive { .. } => "rms_gradient",
        SurfaceError::Discretisation { name: "1/eps_t", .. } | SurfaceError::LongerThanCell { .. } => "eps_t_inv",
        SurfaceError::Discretisation { name: "1/eps_f", .. } | SurfaceError::Wavelengths { .. } => "eps_f_inv",
        SurfaceError::NoModes { .. } => {
            return Unusable::input(words![key("eps_t_inv"), ", ", key("eps_f_inv")], error);
        }
        SurfaceError::Discretisation { .. } | SurfaceError::PointCount { .. } => "eps_c_inv",
        _ => "n",
    };
    Unusable::input(key(option), error)
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use gfmd_surface::Statistics;

    use super::*;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        generator: GeneratorArgs,
    }

    fn flags(line: &str) -> GeneratorArgs {
        Line::try_parse_from(std::iter::once("surface").chain(line.split_whitespace())).unwrap().generator
    }

    /// Generates the heights of a line of flags in a cell of length 1; returns them with their grid.
    fn made(line: &str) -> Result<(Array2<f64>, Grid), Unusable> {
        let generator = flags(line);
        let grid = generator.grid(&[])?;
        Ok((generator.heights(&grid)?, grid))
    }

    #[test]
    fn flags_left_out_have_their_defaults_and_resolve_to_them() {
        let (heights, grid) = made("").unwrap();
        assert_eq!((grid.points(), grid.lengths()), ([256, 256], [1.0, 1.0]));
        let spectrum = flags("").spectrum(&grid).unwrap();
        assert_eq!((spectrum.longest_wavelength, spectrum.shortest_wavelength), (0.5, 1.0 / 64.0));
        assert!((Statistics::of(&heights, &grid).unwrap().moments.rms_gradient() - 0.1).abs() < 1e-14);
        let resolved = flags("").resolved().unwrap();
        assert_eq!((&resolved.n[..], resolved.eps_t_inv, resolved.eps_f_inv), (&[256][..], Some(2.0), Some(32.0)));
        assert_eq!(resolved.heights(&grid).unwrap(), heights);
    }

    #[test]
    fn points_follow_from_the_discretisation_numbers() {
        let grid = |line: &str| flags(line).grid(&[3.0]).unwrap();
        assert_eq!(grid("--eps-t-inv 1.5 --eps-f-inv 24 --eps-c-inv 3").points(), [108, 108]);
        assert_eq!(flags("--eps-c-inv 8").resolved().unwrap().n, [512]);
        assert_eq!(grid("--n 64,96").lengths(), [3.0, 4.5]);
        assert!(grid("--n 64 --dim 2").is_line());
    }

    #[test]
    fn subdivisions_have_the_size_asked_for() {
        for line in ["--method rmd --n 100", "--method sra --n 48,33", "--method rmd --n 64 --dim 2"] {
            for (size, words) in [(0.3, "--rms-gradient 0.3"), (0.02, "--rms-height 0.02")] {
                let (heights, grid) = made(&format!("{line} {words}")).unwrap();
                let moments = Statistics::of(&heights, &grid).unwrap().moments;
                let found = if words.contains("height") { moments.rms_height() } else { moments.rms_gradient() };
                assert!((found / size - 1.0).abs() < 1e-12, "{line} {words}: {found}");
            }
        }
    }

    #[test]
    fn each_error_names_its_flag() {
        let says = |line: &str, words: &str| {
            let message = made(line).unwrap_err().to_string();
            assert!(message.starts_with(words), "{message:?} is not {words:?}");
        };
        says("--hurst 1.5", "--hurst: the Hurst exponent is 1.5; it must be between 0 and 1");
        says("--eps-t-inv 0.5", "--eps-t-inv is 0.5; it must be between 1 and 2147483648");
        says("--eps-f-inv nan", "--eps-f-inv is NaN; it must be between 1 and 2147483648");
        says(
            "--n 64 --eps-f-inv 32",
            "--n is 64; with --eps-t-inv 2 and --eps-f-inv 32 the shortest wavelength has 1 points, and it must have",
        );
        says("--eps-c-inv 1.9", "--eps-c-inv: 1/eps_c is 1.9; it must be at least 2 and finite");
        says("--eps-c-inv 2.51", "--eps-c-inv: 1/eps_t * 1/eps_f * 1/eps_c is 160.6");
        says("--n 512 --eps-c-inv 8", "--eps-c-inv follows from --n; give one of the two");
        says("--rms-gradient 0", "--rms-gradient: the rms gradient is 0; it must be positive and finite");
        says("--rms-height -1", "--rms-height: the rms height is -1; it must be positive and finite");
        says("--roll-off 0.7", "--roll-off: the roll-off wavelength is 0.7; it must be between 0.015625 and 0.5");
        says("--method rmd --rms-gradient -1", "--rms-gradient is -1; it must be positive and finite");
        says("--method rmd --eps-t-inv 4", "--eps-t-inv: --method rmd has no cut-offs");
        says("--method sra --eps-c-inv 4", "--eps-c-inv: --method sra has no cut-offs");
        says("--method sra --amplitudes fixed", "--amplitudes is fixed; it must be gaussian with --method sra");
        says("--aspect 0.5", "--aspect is 0.5; it must be at least 1 and finite");
        says("--aspect 5", "--aspect is 5; it must be at most 4: waves along the lay must fit");
        says("--aspect 2 --dim 2", "--aspect is 2; it must be left out for a profile");
        says("--aspect 2 --lay nan", "--lay is NaN; it must be finite");
        says("--aspect 2 --method rmd", "--aspect: --method rmd has no cut-offs");
        says("--aspect 4 --n 64 --eps-f-inv 16", "--n is 64; with --eps-t-inv 2 and --eps-f-inv 16 the shortest");
        says("--marginal weibull:2 --method sra", "--marginal is weibull:2; it must be left out with --method sra");
        says("--marginal weibull:2 --eps-c-inv 2", "--marginal: the shortest wavelength is");
        says("--n 1", "--n is 1; it must be at least 2");
        says("--n 64,64 --dim 2", "--n is [64, 64]; it must be N, or NX,NY for a surface");
        says("--eps-t-inv 1.4 --eps-f-inv 1 --n 64", "--eps-t-inv, --eps-f-inv: the wavelengths are limited to");
        let length = |length: &[f64]| flags("").grid(length).unwrap_err().to_string();
        assert!(length(&[-1.0]).starts_with("--size: the cell lengths are [-1.0, -1.0]; they must be positive"));
        assert!(length(&[1.0, 2.0, 3.0]).starts_with("--size is [1.0, 2.0, 3.0]; it must be L or LX,LY"));
    }
}
