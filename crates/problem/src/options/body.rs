//! The elastic body, from flags.

use std::fmt;
use std::ops::RangeInclusive;

use clap::Args;
use gfmd_field::Grid;
use gfmd_green::{BaseKind, Body, GreenError, Height, Material};
use gfmd_unit::{Units, is_length};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};

use super::choice::{named, named_if, parse_choice};
use crate::options::{Kinds, Options};
use crate::{Facts, SIZES, Support, Unusable, Words, check_size, key, setting, words};

/// Flags that describe the elastic body.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Body")]
pub struct BodyArgs {
    /// Young's modulus, stress [default: 1; needed if the lengths have a unit]
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    #[serde(serialize_with = "or_one")]
    #[option(kinds = Kinds::STRESS)]
    pub young: Option<f64>,
    /// Poisson's ratio, above -1 and at most 0.5
    #[arg(long, default_value_t = 0.0, value_name = "NU", allow_negative_numbers = true)]
    pub poisson: f64,
    /// Material that sets Young's modulus and Poisson's ratio, in place of --young and --poisson; lengths need a unit.
    /// gfmd materials lists the names with their sources
    #[arg(long, value_name = "NAME")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Material of the second body, a half-space, in place of --second-body
    #[arg(long, value_name = "NAME")]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub second_material: Option<String>,
    /// Contact modulus E* = E/(1 - NU^2), in place of --young
    #[arg(long, value_name = "E*", conflicts_with = "young", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::STRESS)]
    pub e_star: Option<f64>,
    /// Height of the slab or top layer; "inf" for a half-space
    #[arg(
        long,
        default_value_t = Height::Infinite,
        value_name = "ZM",
        value_parser = parse_height,
        allow_negative_numbers = true
    )]
    #[serde(with = "height")]
    #[option(kinds = Kinds::LENGTH)]
    pub height: Height,
    /// The parts below the top layer, and the second body.
    #[command(flatten)]
    #[serde(flatten)]
    pub others: OtherArgs,
}

/// Flags of what lies below the top layer of a body, and of the second body.
#[derive(Args, Options, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Body")]
pub struct OtherArgs {
    /// Support of the lowest layer
    #[arg(long, value_parser = parse_choice::<BaseKind>(), default_value_t = BaseKind::Bonded)]
    #[serde(with = "named", skip_serializing_if = "is_bonded")]
    pub base: BaseKind,
    /// Young's modulus of the base, with --base half-space
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::STRESS)]
    pub base_young: Option<f64>,
    /// Poisson's ratio of the base, with --base half-space
    #[arg(long, value_name = "NU", allow_negative_numbers = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    pub base_poisson: Option<f64>,
    /// Further layer below the top one: Young's modulus, Poisson's ratio, height; repeatable, from the top down
    #[arg(long, value_parser = parse_layer, value_name = "E,NU,H", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::LAYER)]
    pub layer: Vec<Layer>,
    /// Elastic body of the rough surface: a half-space, or a slab of height H bonded at its back
    #[arg(long, value_parser = parse_second, value_name = "E,NU[,H]", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Option::is_none")]
    #[option(kinds = Kinds::LAYER)]
    pub second_body: Option<Layer>,
}

/// Young's modulus, Poisson's ratio, and the height of a layer or slab.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    young: f64,
    poisson: f64,
    height: Height,
}

/// Young's modulus of bodies for which none is given.
const YOUNG: f64 = 1.0;

/// Writes the modulus that is used.
fn or_one<S: serde::Serializer>(young: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(young.unwrap_or(YOUNG))
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for a reference")]
fn is_bonded(base: &BaseKind) -> bool {
    *base == BaseKind::Bonded
}

fn parse_layer(text: &str) -> Result<Layer, String> {
    match numbers(text)[..] {
        [Some(young), Some(poisson), Some(height)] => Ok(Layer { young, poisson, height: Height::Finite(height) }),
        _ => Err("it must be E,NU,H: Young's modulus, Poisson's ratio, height".into()),
    }
}

fn parse_second(text: &str) -> Result<Layer, String> {
    match numbers(text)[..] {
        [Some(young), Some(poisson)] => Ok(Layer { young, poisson, height: Height::Infinite }),
        [Some(young), Some(poisson), Some(height)] => Ok(Layer { young, poisson, height: Height::Finite(height) }),
        _ => Err("it must be E,NU or E,NU,H: Young's modulus, Poisson's ratio, height".into()),
    }
}

fn numbers(text: &str) -> Vec<Option<f64>> {
    text.split(',').map(|number| number.trim().parse().ok()).collect()
}

impl Serialize for Layer {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Self { young, poisson, height } = *self;
        match height {
            Height::Finite(height) => [young, poisson, height].serialize(serializer),
            Height::Infinite => [young, poisson].serialize(serializer),
        }
    }
}

/// Reads a layer of two or three numbers.
impl<'de> Deserialize<'de> for Layer {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let wrong = || D::Error::custom("it must be E, NU or E, NU, H: Young's modulus, Poisson's ratio, height");
        Self::of(&Vec::<f64>::deserialize(deserializer)?).ok_or_else(wrong)
    }
}

impl fmt::Display for Layer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { young, poisson, height } = *self;
        write!(f, "{young},{poisson}")?;
        if let Height::Finite(height) = height { write!(f, ",{height}") } else { Ok(()) }
    }
}

impl Layer {
    /// Returns the layer of two or three numbers; `None` for any other count.
    pub fn of(numbers: &[f64]) -> Option<Self> {
        match *numbers {
            [young, poisson] => Some(Self { young, poisson, height: Height::Infinite }),
            [young, poisson, height] => Some(Self { young, poisson, height: Height::Finite(height) }),
            _ => None,
        }
    }

    fn material(&self, option: &'static str) -> Result<Material, Unusable> {
        material([option, option], self.young, self.poisson)
    }

    fn body(&self, option: &'static str) -> Result<Body, Unusable> {
        Body::new(self.material(option)?, self.height).map_err(|error| Unusable::input(key(option), error))
    }

    /// Describes the material in words.
    fn words(&self, units: &Units) -> String {
        format!("E = {}, nu = {}", units.words(self.young, "stress"), self.poisson)
    }
}

/// Builds a material. Errors name the options `[young, poisson]` of its modulus and Poisson's ratio.
fn material([young_option, poisson_option]: [&'static str; 2], young: f64, poisson: f64) -> Result<Material, Unusable> {
    if young.is_finite() && young > 0.0 {
        check_size(young_option, young)?;
    }
    Material::from_young(young, poisson).map_err(|error| {
        let option = if matches!(error, GreenError::Young(_)) { young_option } else { poisson_option };
        Unusable::input(key(option), error)
    })
}

impl BodyArgs {
    /// Builds the body.
    ///
    /// # Errors
    /// Returns an error if a flag is out of range, or if flags cannot be combined.
    pub fn body(&self) -> Result<Body, Unusable> {
        // The values of a material are options, too, once it is looked up.
        if let (Some(name), None) = (&self.material, self.young) {
            return Err(Unusable::value(key("material"), name, words!["given with ", key("young"), ", its modulus"]));
        }
        if let (Some(name), None) = (&self.second_material, self.others.second_body) {
            let allowed = words!["given with ", key("second_body"), ", its modulus and Poisson's ratio"];
            return Err(Unusable::value(key("second_material"), name, allowed));
        }
        let material = match self.e_star {
            Some(modulus) => {
                if modulus.is_finite() && modulus > 0.0 {
                    check_size("e_star", modulus)?;
                }
                Material::from_contact_modulus(modulus, self.poisson).map_err(|error| {
                    let of_modulus = matches!(error, GreenError::ContactModulus(_));
                    Unusable::input(key(if of_modulus { "e_star" } else { "poisson" }), error)
                })?
            }
            None => self::material(["young", "poisson"], self.young(), self.poisson)?,
        };
        self.others.below(material, self.height)
    }

    /// Returns Young's modulus, 1 by default.
    pub fn young(&self) -> f64 {
        self.young.unwrap_or(YOUNG)
    }

    /// Checks that a modulus is given for lengths in a `unit`: with a unit of length, no material has a modulus of 1.
    ///
    /// # Errors
    /// Returns an error if lengths have a known unit and no modulus is given.
    pub fn check_modulus(&self, unit: Option<&str>) -> Result<(), Unusable> {
        match unit.filter(|unit| is_length(unit)) {
            Some(unit) if self.young.is_none() && self.e_star.is_none() => Err(Unusable::missing(
                "young",
                words![
                    format!("lengths are in {unit}, and pressures need a modulus, such as "),
                    setting("young", "70GPa"),
                    ", or ",
                    setting("e_star", 1),
                    " for pressures divided by the contact modulus",
                ],
            )),
            _ => Ok(()),
        }
    }

    /// Returns the facts of a problem with this body.
    #[must_use]
    pub fn of(&self, facts: Facts) -> Facts {
        let OtherArgs { base, layer, second_body, .. } = &self.others;
        Facts {
            support: Support::of(self.height, *base),
            layers: !layer.is_empty(),
            second: second_body.map(|second| Support::of(second.height, BaseKind::Bonded)),
            ..facts
        }
    }

    /// Describes the body in words, unless it is a single half-space or slab on a bonded base. The words `below`
    /// replace the words for the base.
    pub fn words(&self, below: Option<&str>, units: &Units) -> Option<String> {
        if self.others.are_none() && below.is_none() {
            return None;
        }
        let top = match self.height {
            Height::Finite(height) => format!("slab of height {}", units.words(height, "length")),
            Height::Infinite => "half-space".to_owned(),
        };
        let (symbol, modulus) = self.e_star.map_or_else(|| ("E", self.young()), |e_star| ("E*", e_star));
        let modulus = format!("{symbol} = {}", units.words(modulus, "stress"));
        Some(format!("{top} ({modulus}, nu = {}), {}", self.poisson, self.others.words(below, units)))
    }

    /// Checks the body against a surface on `grid`: the heights of slabs and layers divided by the sides of the cell,
    /// and the `unit` of pressures, E* times the rms gradient.
    ///
    /// # Errors
    /// Returns an error if a slab is so thin or so high, or the unit so small or so large, that digits are lost.
    pub fn check_on(&self, grid: &Grid, unit: f64) -> Result<(), Unusable> {
        self.others.check_heights(self.height, &sides(grid))?;
        let option = if self.e_star.is_some() { "e_star" } else { "young" };
        // A flat surface is checked where it is used.
        if SIZES.contains(&unit) || unit == 0.0 {
            return Ok(());
        }
        let reason = format!("E* times the rms gradient is {unit:e}; it must be between 1e-140 and 1e140");
        Err(Unusable::input(key(option), reason + ", which another unit of stress makes it"))
    }
}

impl OtherArgs {
    /// Builds the body with a top layer of this `material` and `height`.
    ///
    /// # Errors
    /// Returns an error if a flag is out of range, or if flags cannot be combined.
    pub fn below(&self, material: Material, height: Height) -> Result<Body, Unusable> {
        let top = Body::new(material, height).map_err(|error| Unusable::input(key("height"), error))?;
        let Self { base, base_young, base_poisson, layer, second_body } = self;
        if *base != BaseKind::HalfSpace {
            for (option, value) in [("base_young", base_young), ("base_poisson", base_poisson)] {
                if let Some(value) = value {
                    return Err(Unusable::value(
                        key(option),
                        value,
                        words!["left out without ", setting("base", "half-space")],
                    ));
                }
            }
        }
        let body = match height {
            Height::Infinite => {
                if let Some(layer) = layer.first() {
                    return Err(Unusable::value(
                        key("layer"),
                        layer,
                        words!["left out with ", setting("height", "inf"), ": nothing lies below"],
                    ));
                }
                if *base != BaseKind::Bonded {
                    return Err(Unusable::value(
                        key("base"),
                        base,
                        words!["bonded with ", setting("height", "inf"), ": a half-space has no base"],
                    ));
                }
                top
            }
            Height::Finite(height) => {
                let mut layers = vec![(material, height)];
                for layer in layer {
                    layer.body("layer")?;
                    let Height::Finite(height) = layer.height else {
                        return Err(Unusable::value(key("layer"), layer, "E,NU,H with a height"));
                    };
                    layers.push((layer.material("layer")?, height));
                }
                let below = match base {
                    BaseKind::HalfSpace => {
                        let missing = |option| {
                            Unusable::missing(option, words!["it is needed with ", setting("base", "half-space")])
                        };
                        let young = base_young.ok_or_else(|| missing("base_young"))?;
                        let poisson = base_poisson.ok_or_else(|| missing("base_poisson"))?;
                        Some(self::material(["base_young", "base_poisson"], young, poisson)?)
                    }
                    _ => None,
                };
                let stack = base.with(below).and_then(|base| Body::stack(&layers, base));
                stack.map_err(|error| Unusable::input(key("layer"), error))?
            }
        };
        match second_body {
            Some(second) => Ok(body.against(second.body("second_body")?)),
            None => Ok(body),
        }
    }

    /// Checks the heights of all slabs and layers divided by the `sides` of the cell. The top one has the flag
    /// --height.
    ///
    /// # Errors
    /// Returns an error if a slab is so thin or so high that digits are lost.
    pub fn check_heights(&self, height: Height, sides: &[f64]) -> Result<(), Unusable> {
        let others = self.layer.iter().map(|layer| ("layer", layer.height));
        let second = self.second_body.iter().map(|layer| ("second_body", layer.height));
        for (option, height) in std::iter::once(("height", height)).chain(others).chain(second) {
            let Height::Finite(height) = height else { continue };
            if let Some(side) = sides.iter().find(|side| !HEIGHTS.contains(&(height / **side))) {
                let or = if option == "layer" { "" } else { ", or inf" };
                let allowed = format!("between 1e-12 and 1e12 times the cell length {side:e}{or}");
                let name = if option == "height" { Words::default() } else { "the height of ".into() }.and(key(option));
                return Err(Unusable::value(name, format!("{height:e}"), allowed));
            }
        }
        Ok(())
    }

    /// Returns options with mapped moduli (E, ν) of each layer and of the half-space below.
    #[must_use]
    pub fn map_moduli(&self, other: impl Fn(f64, f64) -> (f64, f64)) -> Self {
        let layer = |layer: &Layer| {
            let (young, poisson) = other(layer.young, layer.poisson);
            Layer { young, poisson, ..*layer }
        };
        let mut mapped = Self { layer: self.layer.iter().map(layer).collect(), ..self.clone() };
        if let (Some(young), Some(poisson)) = (self.base_young, self.base_poisson) {
            let (young, poisson) = other(young, poisson);
            (mapped.base_young, mapped.base_poisson) = (Some(young), Some(poisson));
        }
        mapped
    }

    /// Returns true if the body is a single half-space or slab on a bonded base.
    pub fn are_none(&self) -> bool {
        *self == Self::default()
    }

    /// Returns the words that these flags add to the description of a slab, such as "on a layer of height 0.2 (E = 3,
    /// nu = 0.3), on a half-space". The words `below` replace the words for the base.
    pub fn words(&self, below: Option<&str>, units: &Units) -> String {
        let Self { base, base_young, base_poisson, layer, second_body } = self;
        let mut parts: Vec<String> = Vec::new();
        for lower in layer {
            let Height::Finite(height) = lower.height else { continue };
            let height = units.words(height, "length");
            parts.push(format!("on a layer of height {height} ({})", lower.words(units)));
        }
        match base {
            _ if below.is_some() => parts.extend(below.map(str::to_owned)),
            BaseKind::Bonded if layer.is_empty() => {}
            BaseKind::Free => parts.push("free below".into()),
            BaseKind::HalfSpace => {
                let [young, poisson] = [base_young, base_poisson].map(|value| value.unwrap_or(f64::NAN));
                parts.push(format!("on a half-space (E = {}, nu = {poisson})", units.words(young, "stress")));
            }
            rigid => parts.push(rigid.meaning().into()),
        }
        if let Some(second) = second_body {
            let kind = match second.height {
                Height::Infinite => "half-space".to_owned(),
                Height::Finite(height) => format!("slab of height {}", units.words(height, "length")),
            };
            parts.push(format!("against a {kind} ({}) above", second.words(units)));
        }
        parts.join(", ")
    }
}

/// Returns the sides of the cell: two, or one for a profile.
pub fn sides(grid: &Grid) -> Vec<f64> {
    grid.lengths()[..if grid.is_line() { 1 } else { 2 }].to_vec()
}

/// The heights of a slab over the sides of the cell whose stiffnesses are computed without loss of digits.
pub const HEIGHTS: RangeInclusive<f64> = 1e-12..=1e12;

/// Flags that describe the elastic body of an input file. A property without a flag is taken from the configuration
/// that the file records.
#[derive(Args, Options, Clone, Debug, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Body")]
pub struct RecordedBodyArgs {
    /// Young's modulus, stress; default here and below: the value recorded in the input
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    #[option(kinds = Kinds::STRESS)]
    young: Option<f64>,
    /// Poisson's ratio, above -1 and at most 0.5
    #[arg(long, value_name = "NU", allow_negative_numbers = true)]
    poisson: Option<f64>,
    /// Material that sets Young's modulus and Poisson's ratio, in place of --young and --poisson
    #[arg(long, value_name = "NAME")]
    #[serde(skip_serializing_if = "Option::is_none")]
    material: Option<String>,
    /// Material of the second body, a half-space, in place of --second-body
    #[arg(long, value_name = "NAME")]
    #[serde(skip_serializing_if = "Option::is_none")]
    second_material: Option<String>,
    /// Contact modulus E* = E/(1 - NU^2), in place of --young
    #[arg(long, value_name = "E*", conflicts_with = "young", allow_negative_numbers = true)]
    #[option(kinds = Kinds::STRESS)]
    e_star: Option<f64>,
    /// Height of the slab or top layer; "inf" for a half-space
    #[arg(long, value_name = "ZM", value_parser = parse_height, allow_negative_numbers = true)]
    #[serde(with = "height_if")]
    #[option(kinds = Kinds::LENGTH)]
    height: Option<Height>,
    /// Support of the lowest layer
    #[arg(long, value_parser = parse_choice::<BaseKind>())]
    #[serde(with = "named_if")]
    base: Option<BaseKind>,
    /// Young's modulus of the base, with --base half-space
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    #[option(kinds = Kinds::STRESS)]
    base_young: Option<f64>,
    /// Poisson's ratio of the base, with --base half-space
    #[arg(long, value_name = "NU", allow_negative_numbers = true)]
    base_poisson: Option<f64>,
    /// Further layer below the top one; repeatable, from the top down
    #[arg(long, value_parser = parse_layer, value_name = "E,NU,H", allow_hyphen_values = true)]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::LAYER)]
    layer: Vec<Layer>,
    /// Elastic body of the rough surface, which takes part of the displacement
    #[arg(long, value_parser = parse_second, value_name = "E,NU[,H]", allow_hyphen_values = true)]
    #[option(kinds = Kinds::LAYER)]
    second_body: Option<Layer>,
}

impl RecordedBodyArgs {
    /// Takes each property from its flag, or else from `record`, the configuration of a run.
    ///
    /// # Errors
    /// Returns an error if neither has a property, or if `record` is not the record of a run.
    pub fn over(&self, record: &toml::Table) -> Result<BodyArgs, Unusable> {
        let unusable = |error: &dyn fmt::Display| Unusable::input("the config that the input records", error);
        let mut table = record.clone();
        let given = toml::Table::try_from(self).map_err(|error| unusable(&error))?;
        // A given modulus replaces the recorded one, and a given base the recorded half-space.
        if self.young.is_some() {
            table.remove("e_star");
        }
        // A recorded material has the recorded values.
        if self.young.is_some() || self.e_star.is_some() || self.poisson.is_some() {
            table.remove("material");
        }
        if self.second_body.is_some() {
            table.remove("second_material");
        }
        if self.base.is_some_and(|base| base != BaseKind::HalfSpace) {
            for key in ["base_young", "base_poisson"] {
                table.remove(key);
            }
        }
        table.extend(given);
        let has = |key: &str| table.contains_key(key);
        let needed = [("young", has("young") || has("e_star")), ("poisson", has("poisson")), ("height", has("height"))];
        match needed.into_iter().find(|(_, has)| !has) {
            Some((option, _)) => Err(Unusable::missing(option, "it is needed because the input does not record it")),
            None => BodyArgs::deserialize(table).map_err(|error| unusable(&error.message())),
        }
    }
}

/// Parses a height: a length, or `inf`.
///
/// # Errors
/// Returns an error for any other text.
pub fn parse_height(text: &str) -> Result<Height, String> {
    if text == "inf" {
        return Ok(Height::Infinite);
    }
    text.parse().map(Height::Finite).map_err(|_| "it must be a length or \"inf\"".into())
}

/// A height in TOML or JSON: a number, or the text `inf`.
pub mod height {
    use gfmd_green::Height;
    use serde::{Deserialize, Deserializer, Serializer, de::Error};

    #[derive(Deserialize)]
    #[serde(untagged)]
    enum Given {
        Number(f64),
        Text(String),
    }

    /// Writes a height.
    ///
    /// # Errors
    /// Returns an error of the serialiser.
    pub fn serialize<S: Serializer>(height: &Height, serializer: S) -> Result<S::Ok, S::Error> {
        match height {
            Height::Finite(height) => serializer.serialize_f64(*height),
            Height::Infinite => serializer.serialize_str("inf"),
        }
    }

    /// Reads a height.
    ///
    /// # Errors
    /// Returns an error if the value is neither a number nor `inf`.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Height, D::Error> {
        match Given::deserialize(deserializer) {
            // The number inf of TOML, without quotes.
            Ok(Given::Number(height)) if height == f64::INFINITY => Ok(Height::Infinite),
            Ok(Given::Number(height)) => Ok(Height::Finite(height)),
            Ok(Given::Text(text)) if text == "inf" => Ok(Height::Infinite),
            _ => Err(D::Error::custom("it must be a number, or \"inf\"")),
        }
    }
}

/// A height that may be absent, as [`height`].
pub mod height_if {
    use gfmd_green::Height;
    use serde::{Deserializer, Serializer};

    /// Writes a height.
    ///
    /// # Errors
    /// Returns an error of the serialiser.
    pub fn serialize<S: Serializer>(height: &Option<Height>, serializer: S) -> Result<S::Ok, S::Error> {
        match height {
            Some(height) => super::height::serialize(height, serializer),
            None => serializer.serialize_none(),
        }
    }

    /// Reads a height that is present.
    ///
    /// # Errors
    /// Returns an error if the value is neither a number nor `inf`.
    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<Height>, D::Error> {
        super::height::deserialize(deserializer).map(Some)
    }
}
