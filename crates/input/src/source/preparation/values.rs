//! Values of the options, each with its text.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use gfmd_prepare::{Edges, Filter, Kernel, Levelling, MOST_DEGREE, Scars, Spikes};

/// Reads and writes a value of an option by its text.
macro_rules! as_text {
    ($type:ty) => {
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }

        impl<'de> serde::Deserialize<'de> for $type {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let text = String::deserialize(deserializer)?;
                text.parse().map_err(serde::de::Error::custom)
            }
        }
    };
}
pub(super) use as_text;

/// Reads a finite number.
pub(super) fn number(text: &str) -> Result<f64, String> {
    let number: f64 = text.trim().parse().map_err(|_| format!("{text:?} is no number"))?;
    if number.is_finite() { Ok(number) } else { Err(format!("{text:?} must be finite")) }
}

/// Ranges of x and y, with ends that may be left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Box2([[Option<f64>; 2]; 2]);

impl Box2 {
    /// Returns the ranges in a surface with these sides.
    pub fn ranges(&self, lengths: [f64; 2]) -> [Range<f64>; 2] {
        [0, 1].map(|axis| {
            let [start, end] = self.0[axis];
            start.unwrap_or(0.0)..end.unwrap_or(lengths[axis])
        })
    }
}

impl FromStr for Box2 {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const FORM: &str = "it must be X0:X1,Y0:Y1, each end a length or left out";
        let mut ranges = [[None; 2]; 2];
        let parts: Vec<&str> = text.split(',').collect();
        if parts.len() > 2 {
            return Err(FORM.into());
        }
        for (range, part) in ranges.iter_mut().zip(parts) {
            if part.trim().is_empty() {
                continue;
            }
            let (start, end) = part.split_once(':').ok_or(FORM)?;
            for (place, text) in range.iter_mut().zip([start, end]) {
                *place = if text.trim().is_empty() { None } else { Some(number(text)?) };
            }
            if let [Some(start), Some(end)] = *range
                && start >= end
            {
                return Err(format!("{start} to {end} is no range; the first must be smaller"));
            }
        }
        Ok(Self(ranges))
    }
}

impl fmt::Display for Box2 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let end = |place: Option<f64>| place.map_or_else(String::new, |place| format!("{place:?}"));
        let [x, y] = self.0.map(|[start, stop]| format!("{}:{}", end(start), end(stop)));
        write!(f, "{x},{y}")
    }
}

as_text!(Box2);

/// Rule of `--despike`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpikeRule(pub Spikes);

impl FromStr for SpikeRule {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (threshold, window) = text.split_once(',').map_or((text, None), |(first, rest)| (first, Some(rest)));
        let whole = |text: &str| text.trim().parse().map_err(|_| format!("the window {text:?} is no number of points"));
        let window = window.map_or(Ok(Spikes::default().window), whole)?;
        Ok(Self(Spikes { threshold: number(threshold)?, window }))
    }
}

impl fmt::Display for SpikeRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?},{}", self.0.threshold, self.0.window)
    }
}

as_text!(SpikeRule);

/// Rule of `--descar`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScarRule(pub Scars);

impl FromStr for ScarRule {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts: Vec<&str> = text.split(',').collect();
        let [high, low, length, width] = parts[..] else {
            return Err("it must be HIGH,LOW,LENGTH,WIDTH".into());
        };
        let whole = |text: &str| text.trim().parse().map_err(|_| format!("{text:?} is no number of points"));
        Ok(Self(Scars { high: number(high)?, low: number(low)?, length: whole(length)?, width: whole(width)? }))
    }
}

impl fmt::Display for ScarRule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Scars { high, low, length, width } = self.0;
        write!(f, "{high:?},{low:?},{length},{width}")
    }
}

as_text!(ScarRule);

/// Lines that are levelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// Lines along x.
    Rows,
    /// Lines along y.
    Columns,
}

/// Value of `--level`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Lines that are levelled.
    pub rows: Rows,
    /// Way to level them.
    pub how: Levelling,
}

impl FromStr for Level {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        const FORM: &str =
            "it must be rows or columns, and mean, median, difference or polynomial:D, as in rows:median";
        let (lines, how) = text.split_once(':').ok_or(FORM)?;
        let rows = match lines {
            "rows" => Rows::Rows,
            "columns" => Rows::Columns,
            _ => return Err(FORM.into()),
        };
        let how = match how.split_once(':') {
            Some(("polynomial", of)) => Levelling::Polynomial(degree(of)?),
            None if how == "mean" => Levelling::Mean,
            None if how == "median" => Levelling::Median,
            None if how == "difference" => Levelling::Difference,
            _ => return Err(FORM.into()),
        };
        Ok(Self { rows, how })
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.rows == Rows::Rows { "rows:" } else { "columns:" })?;
        match self.how {
            Levelling::Mean => f.write_str("mean"),
            Levelling::Median => f.write_str("median"),
            Levelling::Difference => f.write_str("difference"),
            Levelling::Polynomial(degree) => write!(f, "polynomial:{degree}"),
        }
    }
}

as_text!(Level);

/// Reads the degree of a polynomial.
fn degree(text: &str) -> Result<usize, String> {
    let degree = text.trim().parse().ok().filter(|degree| *degree <= MOST_DEGREE);
    degree.ok_or_else(|| format!("the degree is {text:?}; it must be 0 to {MOST_DEGREE}"))
}

/// Trends that can be subtracted from measured heights.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Detrend {
    /// Nothing.
    #[default]
    None,
    /// The least-squares plane.
    Plane,
    /// The plane of the mean slope; without it opposite edges fit together on average.
    Slope,
    /// The least-squares paraboloid.
    Quadratic,
    /// The least-squares polynomial of this degree in x and y together.
    Polynomial(usize),
}

/// Degree of `cubic`.
const CUBIC: usize = 3;

impl Detrend {
    /// Returns the degree of the polynomial.
    pub(super) fn degree(self) -> usize {
        match self {
            Self::None => 0,
            Self::Plane | Self::Slope => 1,
            Self::Quadratic => 2,
            Self::Polynomial(degree) => degree,
        }
    }

    /// Says what was removed.
    pub(super) fn words(self) -> &'static str {
        const POLYNOMIALS: [&str; MOST_DEGREE + 1] = [
            "mean height removed",
            "least-squares polynomial of degree 1 removed",
            "least-squares polynomial of degree 2 removed",
            "least-squares polynomial of degree 3 removed",
            "least-squares polynomial of degree 4 removed",
            "least-squares polynomial of degree 5 removed",
            "least-squares polynomial of degree 6 removed",
            "least-squares polynomial of degree 7 removed",
            "least-squares polynomial of degree 8 removed",
        ];
        match self {
            Self::None => "",
            Self::Plane => "least-squares plane removed",
            Self::Slope => "mean slope removed",
            Self::Quadratic => "least-squares paraboloid removed",
            Self::Polynomial(degree) => POLYNOMIALS[degree.min(MOST_DEGREE)],
        }
    }
}

impl FromStr for Detrend {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        match text {
            "none" => Ok(Self::None),
            "plane" => Ok(Self::Plane),
            "slope" => Ok(Self::Slope),
            "quadratic" => Ok(Self::Quadratic),
            "cubic" => Ok(Self::Polynomial(CUBIC)),
            _ => match text.split_once(':') {
                Some(("polynomial", of)) => degree(of).map(Self::Polynomial),
                _ => Err("it must be none, plane, slope, quadratic, cubic or polynomial:D".into()),
            },
        }
    }
}

impl fmt::Display for Detrend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::None => f.write_str("none"),
            Self::Plane => f.write_str("plane"),
            Self::Slope => f.write_str("slope"),
            Self::Quadratic => f.write_str("quadratic"),
            Self::Polynomial(CUBIC) => f.write_str("cubic"),
            Self::Polynomial(degree) => write!(f, "polynomial:{degree}"),
        }
    }
}

as_text!(Detrend);

/// Value of `--filter`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bands {
    /// Nesting index of the S filter, length.
    pub short: Option<f64>,
    /// Nesting index of the L filter, length.
    pub long: Option<f64>,
    kernel: Kernel,
    edges: Option<Edges>,
    degree: Option<usize>,
}

impl Bands {
    /// Returns the indices with their names, the S filter first.
    pub(super) fn indices(&self) -> impl Iterator<Item = (&'static str, f64)> {
        [("s", self.short), ("l", self.long)].into_iter().filter_map(|(name, index)| Some((name, index?)))
    }

    /// Returns the filter; without given edges a surface that repeats has periodic ones, others have a regression.
    pub(super) fn filter(&self, is_periodic: bool) -> Filter {
        let natural = if is_periodic && self.kernel != Kernel::Robust { Edges::Periodic } else { Edges::Regression };
        // A robust filter of degree 0 loses the form.
        let degree = self.degree.unwrap_or(if self.kernel == Kernel::Robust { 2 } else { 1 });
        Filter { kernel: self.kernel, edges: self.edges.unwrap_or(natural), degree }
    }

    pub(super) fn kind(&self) -> &'static str {
        match self.kernel {
            Kernel::Gaussian => "gaussian",
            Kernel::Robust => "robust",
            Kernel::Spline { .. } => "spline",
        }
    }

    pub(super) fn edges_name(&self, is_periodic: bool) -> &'static str {
        name_of(self.filter(is_periodic).edges)
    }

    /// Returns the standard of the filter of a profile (one side) or of a surface.
    pub(super) fn standard(&self, sides: usize) -> &'static str {
        match (self.kernel, sides) {
            (Kernel::Gaussian, 1) => "ISO 16610-21",
            (Kernel::Gaussian, _) => "ISO 16610-61",
            (Kernel::Robust, 1) => "ISO 16610-31",
            (Kernel::Robust, _) => "ISO 16610-71",
            (Kernel::Spline { .. }, _) => "ISO 16610-22",
        }
    }
}

fn name_of(edges: Edges) -> &'static str {
    match edges {
        Edges::Periodic => "periodic",
        Edges::Reflect => "reflect",
        Edges::Regression => "regression",
    }
}

impl FromStr for Bands {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let (mut short, mut long, mut kernel, mut edges, mut degree) = (None, None, None, None, None);
        for part in text.split(',') {
            let twice = match part.split_once([':', '=']) {
                Some(("s", index)) => short.replace(number(index)?).is_some(),
                Some(("l", index)) => long.replace(number(index)?).is_some(),
                Some(("kind", name)) => kernel
                    .replace(match name {
                        "gaussian" => Kernel::Gaussian,
                        "robust" => Kernel::Robust,
                        "spline" => Kernel::Spline { tension: 1.0 },
                        _ => return Err(format!("kind is {name:?}; it must be gaussian, robust or spline")),
                    })
                    .is_some(),
                Some(("edges", name)) => edges
                    .replace(match name {
                        "periodic" => Edges::Periodic,
                        "reflect" => Edges::Reflect,
                        "regression" => Edges::Regression,
                        _ => return Err(format!("edges is {name:?}; it must be periodic, reflect or regression")),
                    })
                    .is_some(),
                Some(("degree", name)) => degree
                    .replace(match name {
                        "0" => 0,
                        "1" => 1,
                        "2" => 2,
                        _ => return Err(format!("degree is {name:?}; it must be 0, 1 or 2")),
                    })
                    .is_some(),
                _ => return Err(format!("{part:?} is no part of a filter; they are s:L, l:L, kind=, edges=, degree=")),
            };
            if twice {
                return Err(format!("{part:?} is given twice"));
            }
        }
        if let (Some(short), Some(long)) = (short, long)
            && short >= long
        {
            return Err(format!("s is {short} and l is {long}; s must be smaller"));
        }
        if short.is_none() && long.is_none() {
            return Err("it has no nesting index; it must have s:L, l:L or both".into());
        }
        Ok(Self { short, long, kernel: kernel.unwrap_or(Kernel::Gaussian), edges, degree })
    }
}

impl fmt::Display for Bands {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let indices: Vec<String> = self.indices().map(|(name, index)| format!("{name}:{index:?}")).collect();
        f.write_str(&indices.join(","))?;
        if self.kernel != Kernel::Gaussian {
            write!(f, ",kind={}", self.kind())?;
        }
        if let Some(edges) = self.edges {
            write!(f, ",edges={}", name_of(edges))?;
        }
        self.degree.map_or(Ok(()), |degree| write!(f, ",degree={degree}"))
    }
}

as_text!(Bands);
