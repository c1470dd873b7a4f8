use std::fmt;

use crate::{
    BoschSchreursGeers, CoupledExponential, Dugdale, Exponential, HardWall, HarmonicCosine, Law, LawError, Morse, Npb,
    Npc, Separation, XuNeedleman,
};

/// List of all laws: names, parameters, constructors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LawKind {
    /// [`HardWall`].
    HardWall,
    /// [`XuNeedleman`].
    XuNeedleman,
    /// [`BoschSchreursGeers`].
    BoschSchreursGeers,
    /// [`CoupledExponential`].
    CoupledExponential,
    /// [`Npb`].
    Npb,
    /// [`Npc`].
    Npc,
    /// [`Morse`].
    Morse,
    /// [`Exponential`].
    Exponential,
    /// [`HarmonicCosine`].
    HarmonicCosine,
    /// [`Dugdale`].
    Dugdale,
    /// [`Tabulated`](crate::Tabulated), defined by rows instead of parameters.
    Table,
}

/// Parameter of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Name, as in theory.md, section 8.
    pub name: &'static str,
    /// Units, such as `stress*length`.
    pub units: &'static str,
    /// Allowed values.
    pub allowed: Allowed,
    /// Default value; `None` if the parameter is required.
    pub default: Option<f64>,
}

/// Allowed values of a parameter; they must also be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Allowed {
    /// Above zero.
    Positive,
    /// All except this value.
    Not(f64),
}

const fn positive(name: &'static str, units: &'static str) -> Parameter {
    Parameter { name, units, allowed: Allowed::Positive, default: None }
}

const SEPARATION: [Parameter; 4] = [
    positive("phi_n", "stress*length"),
    positive("phi_t", "stress*length"),
    positive("delta_n", "length"),
    positive("delta_t", "length"),
];
const R: Parameter = Parameter { name: "r", units: "1", allowed: Allowed::Not(1.0), default: Some(0.0) };
const XU_NEEDLEMAN: [Parameter; 5] = [SEPARATION[0], SEPARATION[1], SEPARATION[2], SEPARATION[3], R];
const RANGE: [Parameter; 2] = [positive("gamma", "stress*length"), positive("range", "length")];
const CURVATURE: [Parameter; 2] = [positive("gamma", "stress*length"), positive("curvature", "stress/length")];

impl LawKind {
    /// All laws.
    pub const ALL: [Self; 11] = [
        Self::HardWall,
        Self::XuNeedleman,
        Self::BoschSchreursGeers,
        Self::CoupledExponential,
        Self::Npb,
        Self::Npc,
        Self::Morse,
        Self::Exponential,
        Self::HarmonicCosine,
        Self::Dugdale,
        Self::Table,
    ];

    /// Returns the name used on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::HardWall => "hard-wall",
            Self::XuNeedleman => "xu-needleman",
            Self::BoschSchreursGeers => "bsg",
            Self::CoupledExponential => "c3d",
            Self::Npb => "npb",
            Self::Npc => "npc",
            Self::Morse => "morse",
            Self::Exponential => "exponential",
            Self::HarmonicCosine => "harmonic-cosine",
            Self::Dugdale => "dugdale",
            Self::Table => "table",
        }
    }

    /// Returns the parameters, in the order of [`LawKind::with`].
    pub fn parameters(self) -> &'static [Parameter] {
        match self {
            Self::HardWall | Self::Table => &[],
            Self::XuNeedleman => &XU_NEEDLEMAN,
            Self::BoschSchreursGeers | Self::CoupledExponential | Self::Npb | Self::Npc => &SEPARATION,
            Self::Morse | Self::Exponential | Self::Dugdale => &RANGE,
            Self::HarmonicCosine => &CURVATURE,
        }
    }

    /// Creates the law from parameters `given` by name.
    ///
    /// # Errors
    /// Returns an error if a name is unknown, or a parameter is given twice, missing or out of range; also for
    /// [`LawKind::Table`], which has rows instead of parameters.
    pub fn with(self, given: &[(impl AsRef<str>, f64)]) -> Result<Box<dyn Law>, LawError> {
        if let Some((found, _)) =
            given.iter().find(|(name, _)| self.parameters().iter().all(|p| p.name != name.as_ref()))
        {
            return Err(LawError::Unknown { kind: self, found: found.as_ref().into() });
        }
        let mut values = [0.0; XU_NEEDLEMAN.len()];
        for (value, &parameter) in values.iter_mut().zip(self.parameters()) {
            let mut named = given.iter().filter(|(name, _)| name.as_ref() == parameter.name).map(|(_, value)| *value);
            let found = named.next().or(parameter.default).ok_or(LawError::Missing { kind: self, parameter })?;
            if named.next().is_some() {
                return Err(LawError::Twice { name: parameter.name });
            }
            *value = found;
        }
        let [a, b, c, d, r] = values;
        let separation = Separation { normal_work: a, tangential_work: b, normal_length: c, tangential_length: d };
        Ok(match self {
            Self::HardWall => Box::new(HardWall),
            Self::XuNeedleman => Box::new(XuNeedleman::new(separation, r)?),
            Self::BoschSchreursGeers => Box::new(BoschSchreursGeers::new(separation)?),
            Self::CoupledExponential => Box::new(CoupledExponential::new(separation)?),
            Self::Npb => Box::new(Npb::new(separation)?),
            Self::Npc => Box::new(Npc::new(separation)?),
            Self::Morse => Box::new(Morse::new(a, b)?),
            Self::Exponential => Box::new(Exponential::new(a, b)?),
            Self::HarmonicCosine => Box::new(HarmonicCosine::new(a, b)?),
            Self::Dugdale => Box::new(Dugdale::new(a, b)?),
            Self::Table => return Err(LawError::NoTable),
        })
    }

    /// Returns true if the law may have a hard wall; a table has one if it begins at a gap of 0.
    pub fn may_have_wall(self) -> bool {
        matches!(self, Self::HardWall | Self::Exponential | Self::Dugdale | Self::Table)
    }

    /// Returns true if the law has a traction along the surface.
    pub fn shears(self) -> bool {
        matches!(self, Self::XuNeedleman | Self::BoschSchreursGeers | Self::CoupledExponential | Self::Npb | Self::Npc)
    }

    /// Returns the names of the laws selected by `wanted`, in the order of [`LawKind::ALL`], separated by commas.
    pub fn names(wanted: impl Fn(Self) -> bool) -> String {
        let names: Vec<&str> = Self::ALL.into_iter().filter(|kind| wanted(*kind)).map(Self::name).collect();
        names.join(", ")
    }

    /// Returns advice on the law to use for the common model `name` that is not a [`LawKind`]; empty for other names.
    pub(crate) fn instead_of(name: &str) -> &'static str {
        match name.to_lowercase().as_str() {
            "jkr" => {
                "; JKR is the limit of a short range: exponential with gamma and a range far below the peak heights"
            }
            "dmt" => "; DMT is the limit of a long range: exponential with gamma and a range above the peak heights",
            "maugis" | "maugis-dugdale" | "md" => "; Maugis' model is dugdale with gamma and range",
            "lennard-jones" | "lj" | "van-der-waals" | "vdw" => {
                "; morse has a similar well, and table takes gaps and tractions of any law"
            }
            "none" | "rigid" | "hertz" | "wall" | "hard_wall" | "hardwall" => "; contact without adhesion is hard-wall",
            _ => "",
        }
    }

    /// Returns true if the law has the parameter `name`.
    pub fn has(self, name: &str) -> bool {
        self.parameters().iter().any(|parameter| parameter.name == name)
    }
}

impl std::fmt::Display for LawKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

impl std::str::FromStr for LawKind {
    type Err = LawError;

    fn from_str(name: &str) -> Result<Self, LawError> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| LawError::Name { found: name.into() })
    }
}

impl Parameter {
    pub(crate) fn list(parameters: &[Self]) -> String {
        let texts: Vec<String> = parameters.iter().map(ToString::to_string).collect();
        if texts.is_empty() { "none".into() } else { texts.join(", ") }
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({}, {}", self.name, self.units, self.allowed)?;
        self.default.map_or(Ok(()), |value| write!(f, ", {value} if not given"))?;
        f.write_str(")")
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Positive => f.write_str("positive"),
            Self::Not(value) => write!(f, "not {value}"),
        }
    }
}
