//! Smooth shapes: heights of spheres, cones, punches and waves from closed forms.

use std::f64::consts::TAU;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use gfmd_field::Grid;
use ndarray::{Array2, Axis};

/// Smooth shape of a rigid surface, with its top in the middle of the cell, `(Lx/2, Ly/2)`.
///
/// The top is at height 0, and heights decrease from there; a wave has its mean at 0. Beyond its outline a shape has a
/// floor, at the height where the outline is. All lengths are positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// √(R² − r²) − R, and −R beyond the equator.
    Sphere {
        /// Radius R.
        radius: f64,
    },
    /// −x²/(2 Rx) − y²/(2 Ry), the shape in Hertz's theory.
    Paraboloid {
        /// Radii of curvature at the top, in the planes of x and y.
        radii: [f64; 2],
    },
    /// c √(1 − x²/a² − y²/b²) − c, and −c beyond the equator.
    Ellipsoid {
        /// Semi-axes a, b, c along x, y, z.
        axes: [f64; 3],
    },
    /// Sphere of a plane: the same along an axis.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Axis of the cylinder.
        axis: Along,
    },
    /// −slope r.
    Cone {
        /// Tangent of the angle between its face and the undeformed surface of the body.
        slope: f64,
    },
    /// Cone of a plane: the same along an axis.
    Wedge {
        /// Tangent of the angle between its faces and the undeformed surface of the body.
        slope: f64,
        /// Direction of its edge.
        axis: Along,
    },
    /// 0 up to the radius a of the flat face, then a quarter of a circle of radius R, then a floor.
    FlatPunch {
        /// Radius of the flat face; half of its width in a profile.
        radius: f64,
        /// Radius of the rounded edge; 0 of a sharp one.
        edge: f64,
        /// Depth of the floor below the face, at least `edge`.
        depth: f64,
    },
    /// A cos(2π x/λx) cos(2π y/λy), where a direction without a wavelength has no wave.
    Wave {
        /// Amplitude A.
        amplitude: f64,
        /// Wavelengths along x and y; without both the wave is one cell long along x.
        wavelengths: [Option<f64>; 2],
    },
}

/// Direction in the plane of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// The direction x.
    X,
    /// The direction y.
    Y,
}

/// Reasons why a shape cannot be made. Each message states what was found and what is allowed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ShapeError {
    /// Name of no shape.
    #[error("the shape is {0:?}; it must be one of {names}", names = names())]
    Unknown(String),
    /// Text that is no list of numbers with names.
    #[error("{found:?} of {kind} must be KEY=VALUE with a key of {}", keys_of(kind))]
    Entry { kind: &'static str, found: String },
    /// Key that is given more than once.
    #[error("{key} of {kind} is given more than once")]
    Twice { kind: &'static str, key: &'static str },
    /// Key that is missing.
    #[error("{kind} has no {key}; it needs {}", keys_of(kind))]
    Missing { kind: &'static str, key: &'static str },
    /// Value that is no number in its range, or no direction.
    #[error("{key} of {kind} is {found}; it must be {allowed}")]
    Value { kind: &'static str, key: &'static str, found: String, allowed: String },
    /// Shape that is no profile.
    #[error("the shape is {0}; a profile has paraboloid, cylinder, wedge, flat-punch or wave, with the axis y")]
    NoProfile(&'static str),
}

/// Key of a shape.
#[derive(Clone, Copy, Debug)]
struct Key {
    name: &'static str,
    needed: bool,
    kind: Kind,
}

/// Kind of the value of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Length,
    Number,
    Direction,
}

const fn length(name: &'static str) -> Key {
    Key { name, needed: true, kind: Kind::Length }
}

const fn may(key: Key) -> Key {
    Key { needed: false, ..key }
}

const SLOPE: Key = Key { name: "slope", needed: true, kind: Kind::Number };
const AXIS: Key = Key { name: "axis", needed: false, kind: Kind::Direction };

/// Names of the shapes, with their keys.
const SHAPES: [(&str, &[Key]); 8] = [
    ("sphere", &[length("R")]),
    ("paraboloid", &[may(length("R")), may(length("Rx")), may(length("Ry"))]),
    ("ellipsoid", &[length("a"), length("b"), length("c")]),
    ("cylinder", &[length("R"), AXIS]),
    ("cone", &[SLOPE]),
    ("wedge", &[SLOPE, AXIS]),
    ("flat-punch", &[length("a"), may(length("R")), may(length("depth"))]),
    ("wave", &[length("A"), may(length("Lx")), may(length("Ly"))]),
];

fn names() -> String {
    SHAPES.map(|(name, _)| name).join(", ")
}

/// Returns the keys of a shape in words.
fn keys_of(kind: &str) -> String {
    let keys = SHAPES.iter().find(|(name, _)| *name == kind).map_or(&[][..], |(_, keys)| keys);
    let words = keys.iter().map(|key| if key.needed { key.name.to_owned() } else { format!("[{}]", key.name) });
    words.collect::<Vec<_>>().join(", ")
}

impl Along {
    const fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
        }
    }
}

/// Entries of a shape as they are read.
struct Entries {
    kind: &'static str,
    found: Vec<(&'static str, String)>,
}

impl Entries {
    fn text(&self, key: &str) -> Option<&str> {
        self.found.iter().find(|(name, _)| *name == key).map(|(_, text)| &**text)
    }

    fn refused(&self, key: &'static str, found: impl fmt::Display, allowed: impl Into<String>) -> ShapeError {
        ShapeError::Value { kind: self.kind, key, found: found.to_string(), allowed: allowed.into() }
    }

    /// Returns a number from `least` on; 0 alone may be allowed.
    fn maybe(&self, key: &'static str, is_zero_allowed: bool) -> Result<Option<f64>, ShapeError> {
        let Some(text) = self.text(key) else { return Ok(None) };
        let number: f64 = text.trim().parse().map_err(|_| self.refused(key, text, "a number"))?;
        if number.is_finite() && (number > 0.0 || is_zero_allowed && number == 0.0) {
            return Ok(Some(number));
        }
        let allowed = if is_zero_allowed { "at least 0 and finite" } else { "positive and finite" };
        Err(self.refused(key, number, allowed))
    }

    fn number(&self, key: &'static str) -> Result<f64, ShapeError> {
        self.maybe(key, false)?.ok_or(ShapeError::Missing { kind: self.kind, key })
    }

    fn axis(&self) -> Result<Along, ShapeError> {
        match self.text("axis").map(str::trim) {
            None | Some("y") => Ok(Along::Y),
            Some("x") => Ok(Along::X),
            Some(found) => Err(self.refused("axis", found, "x or y")),
        }
    }

    fn radii(&self) -> Result<[f64; 2], ShapeError> {
        let [both, x, y] = ["R", "Rx", "Ry"].map(|key| self.maybe(key, false));
        match (both?, x?, y?) {
            (Some(radius), None, None) => Ok([radius; 2]),
            (None, Some(x), Some(y)) => Ok([x, y]),
            (None, None, None) => Err(ShapeError::Missing { kind: self.kind, key: "R" }),
            (None, x, _) => Err(ShapeError::Missing { kind: self.kind, key: if x.is_none() { "Rx" } else { "Ry" } }),
            (Some(radius), ..) => Err(self.refused("R", radius, "left out with Rx and Ry")),
        }
    }

    fn punch(&self) -> Result<Shape, ShapeError> {
        let (radius, edge) = (self.number("a")?, self.maybe("R", true)?.unwrap_or(0.0));
        let depth = match self.maybe("depth", false)? {
            Some(depth) if depth < edge => return Err(self.refused("depth", depth, format!("at least R, {edge}"))),
            Some(depth) => depth,
            None if edge == 0.0 => return Err(self.refused("R", 0, "positive without a depth")),
            None => edge,
        };
        Ok(Shape::FlatPunch { radius, edge, depth })
    }
}

impl FromStr for Shape {
    type Err = ShapeError;

    /// Reads `KIND:KEY=VALUE,...`.
    fn from_str(text: &str) -> Result<Self, ShapeError> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        let shape = SHAPES.iter().find(|(kind, _)| *kind == name.trim());
        let (kind, keys) = *shape.ok_or_else(|| ShapeError::Unknown(name.trim().to_owned()))?;
        let mut entries = Entries { kind, found: Vec::new() };
        for entry in rest.split(',').filter(|_| !rest.trim().is_empty()) {
            let refused = || ShapeError::Entry { kind, found: entry.to_owned() };
            let (key, value) = entry.split_once('=').ok_or_else(refused)?;
            let key = keys.iter().find(|known| known.name == key.trim()).ok_or_else(refused)?.name;
            if entries.text(key).is_some() {
                return Err(ShapeError::Twice { kind, key });
            }
            entries.found.push((key, value.to_owned()));
        }
        Ok(match kind {
            "sphere" => Self::Sphere { radius: entries.number("R")? },
            "paraboloid" => Self::Paraboloid { radii: entries.radii()? },
            "ellipsoid" => Self::Ellipsoid { axes: [entries.number("a")?, entries.number("b")?, entries.number("c")?] },
            "cylinder" => Self::Cylinder { radius: entries.number("R")?, axis: entries.axis()? },
            "cone" => Self::Cone { slope: entries.number("slope")? },
            "wedge" => Self::Wedge { slope: entries.number("slope")?, axis: entries.axis()? },
            "flat-punch" => entries.punch()?,
            _ => Self::Wave {
                amplitude: entries.number("A")?,
                wavelengths: [entries.maybe("Lx", false)?, entries.maybe("Ly", false)?],
            },
        })
    }
}

impl fmt::Display for Shape {
    /// Writes `KIND:KEY=VALUE,...`, from which the same shape is read again.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = self.kind();
        match *self {
            Self::Sphere { radius } => write!(f, "{kind}:R={radius:?}"),
            Self::Paraboloid { radii: [x, y] } if x == y => write!(f, "{kind}:R={x:?}"),
            Self::Paraboloid { radii: [x, y] } => write!(f, "{kind}:Rx={x:?},Ry={y:?}"),
            Self::Ellipsoid { axes: [a, b, c] } => write!(f, "{kind}:a={a:?},b={b:?},c={c:?}"),
            Self::Cylinder { radius, axis } => write!(f, "{kind}:R={radius:?},axis={}", axis.name()),
            Self::Cone { slope } => write!(f, "{kind}:slope={slope:?}"),
            Self::Wedge { slope, axis } => write!(f, "{kind}:slope={slope:?},axis={}", axis.name()),
            Self::FlatPunch { radius, edge, depth } => write!(f, "{kind}:a={radius:?},R={edge:?},depth={depth:?}"),
            Self::Wave { amplitude, wavelengths: [x, y] } => {
                write!(f, "{kind}:A={amplitude:?}")?;
                x.map_or(Ok(()), |x| write!(f, ",Lx={x:?}"))?;
                y.map_or(Ok(()), |y| write!(f, ",Ly={y:?}"))
            }
        }
    }
}

impl Shape {
    /// Returns true if the value of this key is a length.
    pub fn is_length(key: &str) -> bool {
        SHAPES.iter().flat_map(|(_, keys)| *keys).any(|known| known.name == key && known.kind == Kind::Length)
    }

    /// Returns the name of the kind of shape.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Sphere { .. } => "sphere",
            Self::Paraboloid { .. } => "paraboloid",
            Self::Ellipsoid { .. } => "ellipsoid",
            Self::Cylinder { .. } => "cylinder",
            Self::Cone { .. } => "cone",
            Self::Wedge { .. } => "wedge",
            Self::FlatPunch { .. } => "flat-punch",
            Self::Wave { .. } => "wave",
        }
    }

    /// Returns true for a shape without a kink at the edges of a periodic cell.
    pub fn is_wave(&self) -> bool {
        matches!(self, Self::Wave { .. })
    }

    /// Checks that the grid resolves the shape, and that a wave fits into a periodic cell.
    ///
    /// # Errors
    /// Returns an error for radii below a grid spacing, waves of fewer than two points or with a fraction of a wave in
    /// a periodic cell, and shapes that are no profile on the grid of one.
    pub fn check_on(&self, grid: &Grid, is_periodic: bool) -> Result<(), ShapeError> {
        let kind = self.kind();
        if grid.is_line() {
            let has_y = match self {
                Self::Sphere { .. } | Self::Ellipsoid { .. } | Self::Cone { .. } => true,
                Self::Cylinder { axis, .. } | Self::Wedge { axis, .. } => *axis == Along::X,
                Self::Wave { wavelengths: [_, y], .. } => y.is_some(),
                Self::Paraboloid { .. } | Self::FlatPunch { .. } => false,
            };
            if has_y {
                return Err(ShapeError::NoProfile(kind));
            }
        }
        let [dx, dy] = grid.spacing();
        let step = if grid.is_line() { dx } else { dx.max(dy) };
        let resolved = |key, found: f64, least: f64| match found >= least {
            true => Ok(()),
            false => {
                let allowed = format!("at least {least}, the grid spacing");
                Err(ShapeError::Value { kind, key, found: found.to_string(), allowed })
            }
        };
        match *self {
            Self::Sphere { radius } => resolved("R", radius, step),
            Self::Cylinder { radius, axis: Along::Y } => resolved("R", radius, dx),
            Self::Cylinder { radius, axis: Along::X } => resolved("R", radius, dy),
            Self::Ellipsoid { axes: [a, b, _] } => resolved("a", a, dx).and_then(|()| resolved("b", b, dy)),
            Self::FlatPunch { radius, .. } => resolved("a", radius, step),
            Self::Wave { wavelengths, .. } => {
                let [x, y] = [("Lx", 0), ("Ly", 1)].map(|(key, side)| match wavelengths[side] {
                    Some(found) => {
                        wave_fits(kind, (key, found), [grid.lengths()[side], grid.spacing()[side]], is_periodic)
                    }
                    None => Ok(()),
                });
                x.and(y)
            }
            Self::Paraboloid { .. } | Self::Cone { .. } | Self::Wedge { .. } => Ok(()),
        }
    }

    /// Returns the heights at some rows of a grid, displaced from its points by these fractions of a grid step.
    pub fn heights(&self, grid: &Grid, rows: Range<usize>, [along_x, along_y]: [f64; 2]) -> Array2<f64> {
        let ([nx, ny], [dx, dy], [length, _]) = (grid.points(), grid.spacing(), grid.lengths());
        let first = rows.start;
        let mut heights = Array2::zeros([rows.len(), ny]);
        for (row, mut values) in heights.axis_iter_mut(Axis(0)).enumerate() {
            let x = ((first + row) as f64 + along_x - 0.5 * nx as f64) * dx;
            for (column, value) in values.iter_mut().enumerate() {
                let y = if grid.is_line() { 0.0 } else { (column as f64 + along_y - 0.5 * ny as f64) * dy };
                *value = self.height(x, y, length);
            }
        }
        heights
    }

    /// Returns the height at a point relative to the middle of a cell of this `length` along x.
    fn height(&self, x: f64, y: f64, length: f64) -> f64 {
        /// Height of the unit sphere at the square of a distance from its axis, −1 beyond the equator.
        fn cap(square: f64) -> f64 {
            if square < 1.0 { 0.0 - square / (1.0 + (1.0 - square).sqrt()) } else { -1.0 }
        }
        match *self {
            Self::Sphere { radius } => radius * cap((x / radius).powi(2) + (y / radius).powi(2)),
            Self::Paraboloid { radii: [rx, ry] } => 0.0 - 0.5 * (x * (x / rx) + y * (y / ry)),
            Self::Ellipsoid { axes: [a, b, c] } => c * cap((x / a).powi(2) + (y / b).powi(2)),
            Self::Cylinder { radius, axis } => radius * cap((across(axis, x, y) / radius).powi(2)),
            Self::Cone { slope } => 0.0 - slope * x.hypot(y),
            Self::Wedge { slope, axis } => 0.0 - slope * across(axis, x, y).abs(),
            Self::FlatPunch { radius, edge, depth } => {
                let beyond = x.hypot(y) - radius;
                // Distances of grid points round: the face includes its rim.
                if beyond <= 1e-12 * radius {
                    0.0
                } else if beyond < edge {
                    edge * cap((beyond / edge).powi(2))
                } else {
                    -depth
                }
            }
            Self::Wave { amplitude, wavelengths } => {
                let wavelengths = if wavelengths == [None; 2] { [Some(length), None] } else { wavelengths };
                let part = |at: f64, wave: Option<f64>| wave.map_or(1.0, |wave| (TAU * (at / wave)).cos());
                amplitude * part(x, wavelengths[0]) * part(y, wavelengths[1])
            }
        }
    }
}

/// Returns the distance from an axis.
fn across(axis: Along, x: f64, y: f64) -> f64 {
    match axis {
        Along::X => y,
        Along::Y => x,
    }
}

/// Relative difference up to which a side of the cell is a multiple of a wavelength.
const WHOLE: f64 = 1e-9;

fn wave_fits(
    kind: &'static str,
    (key, found): (&'static str, f64),
    [side, step]: [f64; 2],
    is_periodic: bool,
) -> Result<(), ShapeError> {
    let refused = |allowed| Err(ShapeError::Value { kind, key, found: found.to_string(), allowed });
    let count = side / found;
    let is_resolved = found >= 2.0 * step * (1.0 - WHOLE);
    if !is_resolved {
        return refused(format!("at least {}, two grid spacings", 2.0 * step));
    }
    if is_periodic && !(count > 0.5 && (count - count.round()).abs() <= WHOLE * count) {
        return refused(format!("the side {side} of the periodic cell divided by a whole number"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(text: &str) -> Shape {
        text.parse().unwrap()
    }

    #[test]
    fn a_text_comes_back_as_the_same_shape() {
        for text in [
            "sphere:R=2.5",
            "paraboloid:R=1e-3",
            "paraboloid:Rx=1,Ry=2",
            "ellipsoid:a=1,b=2,c=3",
            "cylinder:R=0.1",
            "cylinder:R=0.1,axis=x",
            "cone:slope=0.1",
            "wedge:slope=0.3333333333333333",
            "flat-punch:a=0.2,R=0.01",
            "flat-punch:a=0.2,depth=0.01",
            "wave:A=0.01",
            "wave:A=0.01,Lx=0.5,Ly=0.25",
        ] {
            let made = shape(text);
            assert_eq!(shape(&made.to_string()), made, "{text}");
        }
    }

    #[test]
    fn heights_are_the_closed_forms_with_their_floors() {
        let grid = Grid::new([8, 8], [4.0, 4.0]).unwrap();
        let at = |text: &str, i: usize, j: usize| shape(text).heights(&grid, 0..8, [0.0; 2])[[i, j]];
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-14, "{found} is not {expected}");
        for text in ["sphere:R=1", "paraboloid:R=1", "cone:slope=1", "wedge:slope=1", "flat-punch:a=1,R=1"] {
            close(at(text, 4, 4), 0.0);
        }
        close(at("sphere:R=1", 5, 4), 0.75_f64.sqrt() - 1.0);
        close(at("sphere:R=1", 6, 4), -1.0);
        close(at("sphere:R=1", 0, 0), -1.0);
        close(at("paraboloid:Rx=1,Ry=2", 6, 6), -0.5 - 0.25);
        close(at("ellipsoid:a=2,b=1,c=3", 6, 4), 3.0 * 0.75_f64.sqrt() - 3.0);
        close(at("ellipsoid:a=2,b=1,c=3", 4, 7), -3.0);
        close(at("cylinder:R=2", 6, 0), 3.0_f64.sqrt() - 2.0);
        close(at("cylinder:R=2,axis=x", 0, 6), 3.0_f64.sqrt() - 2.0);
        close(at("cone:slope=0.5", 6, 6), -0.5 * 2.0_f64.sqrt());
        close(at("wedge:slope=0.5", 6, 1), -0.5);
        close(at("flat-punch:a=1,R=1", 6, 4), 0.0);
        close(at("flat-punch:a=1,R=1", 7, 4), 0.75_f64.sqrt() - 1.0);
        close(at("flat-punch:a=1,depth=3", 7, 4), -3.0);
        close(at("wave:A=2", 5, 0), 2.0_f64.sqrt());
        close(at("wave:A=2,Lx=4,Ly=2", 5, 6), -(2.0_f64.sqrt()));
        let moved = shape("wave:A=2").heights(&grid, 3..5, [0.5, 0.5]);
        close(moved[[0, 0]], 2.0 * (TAU / 16.0).cos());
        assert!(shape("sphere:R=1e-3").heights(&grid, 0..8, [0.0; 2]).iter().all(|height| height.is_finite()));
    }

    #[test]
    fn a_sphere_is_flat_to_all_digits_near_its_top() {
        let found = shape("sphere:R=1e6").height(1e-3, 0.0, 1.0);
        assert!((found / -5e-13 - 1.0).abs() < 1e-12, "{found}");
    }

    #[test]
    fn errors_say_what_was_found_and_what_is_allowed() {
        let says = |text: &str, words: &str| {
            let message = text.parse::<Shape>().unwrap_err().to_string();
            assert_eq!(message, words);
        };
        says(
            "ball:R=1",
            "the shape is \"ball\"; it must be one of sphere, paraboloid, ellipsoid, cylinder, cone, wedge, \
             flat-punch, wave",
        );
        says("sphere", "sphere has no R; it needs R");
        says("sphere:", "sphere has no R; it needs R");
        says("sphere:r=1", "\"r=1\" of sphere must be KEY=VALUE with a key of R");
        says("sphere:1", "\"1\" of sphere must be KEY=VALUE with a key of R");
        says("sphere:R=1,R=2", "R of sphere is given more than once");
        says("sphere:R=-1", "R of sphere is -1; it must be positive and finite");
        says("sphere:R=nan", "R of sphere is NaN; it must be positive and finite");
        says("cone:slope=steep", "slope of cone is steep; it must be a number");
        says("cylinder:R=1,axis=z", "axis of cylinder is z; it must be x or y");
        says("paraboloid:Rx=1", "paraboloid has no Ry; it needs [R], [Rx], [Ry]");
        says("paraboloid:R=1,Ry=1", "R of paraboloid is 1; it must be left out with Rx and Ry");
        says("flat-punch:a=1", "R of flat-punch is 0; it must be positive without a depth");
        says("flat-punch:a=1,R=2,depth=1", "depth of flat-punch is 1; it must be at least R, 2");
        let on = |text: &str, periodic| {
            let grid = Grid::new([8, 8], [4.0, 4.0]).unwrap();
            shape(text).check_on(&grid, periodic).map_err(|error| error.to_string())
        };
        assert_eq!(on("wave:A=1,Lx=2", true), Ok(()));
        assert_eq!(on("wave:A=1,Lx=3", false), Ok(()));
        let periodic = "Lx of wave is 3; it must be the side 4 of the periodic cell divided by a whole number";
        assert_eq!(on("wave:A=1,Lx=3", true).unwrap_err(), periodic);
        let short = "Lx of wave is 0.5; it must be at least 1, two grid spacings";
        assert_eq!(on("wave:A=1,Lx=0.5", true).unwrap_err(), short);
        let small = "R of sphere is 0.4; it must be at least 0.5, the grid spacing";
        assert_eq!(on("sphere:R=0.4", false).unwrap_err(), small);
        let line = Grid::line(8, 4.0).unwrap();
        assert!(shape("cylinder:R=2").check_on(&line, false).is_ok());
        for text in ["sphere:R=2", "cylinder:R=2,axis=x", "cone:slope=1", "wave:A=1,Ly=1"] {
            assert!(matches!(shape(text).check_on(&line, false), Err(ShapeError::NoProfile(_))), "{text}");
        }
    }
}
