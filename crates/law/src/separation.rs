use crate::{LawKind, Parameter};

/// Works and lengths of separation of a cohesive law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Separation {
    /// Work φ_n of opening at Δ_t = 0, per area.
    pub normal_work: f64,
    /// Work φ_t of sliding at Δ_n = 0, per area.
    pub tangential_work: f64,
    /// Length δ_n of opening.
    pub normal_length: f64,
    /// Length δ_t of sliding.
    pub tangential_length: f64,
}

impl Separation {
    pub(crate) fn check(self) -> Result<Self, LawError> {
        let Self { normal_work, tangential_work, normal_length, tangential_length } = self;
        positive("phi_n", normal_work)?;
        positive("phi_t", tangential_work)?;
        positive("delta_n", normal_length)?;
        positive("delta_t", tangential_length)?;
        finite("phi_t/phi_n", tangential_work / normal_work)?;
        finite("phi_n/phi_t", normal_work / tangential_work)?;
        finite("phi_n/delta_n^2", normal_work / normal_length / normal_length)?;
        finite("phi_n/(delta_n delta_t)", normal_work / normal_length / tangential_length)?;
        finite("phi_t/(delta_n delta_t)", tangential_work / normal_length / tangential_length)?;
        finite("phi_t/delta_t^2", tangential_work / tangential_length / tangential_length)?;
        Ok(self)
    }

    /// Returns the reduced separations Δ_n/δ_n and Δ_t/δ_t, limited to [`FAR`].
    pub(crate) fn reduce(&self, normal: f64, sliding: f64) -> [f64; 2] {
        let x = normal / self.normal_length;
        [if x > FAR { FAR } else { x }, (sliding / self.tangential_length).clamp(-FAR, FAR)]
    }

    /// Returns the opening energy −φ_n (1 + x) e^{−x} of all cohesive laws here, zero at infinite separation.
    pub(crate) fn opening_energy(&self, normal: f64) -> f64 {
        let [x, _] = self.reduce(normal, 0.0);
        -self.normal_work * (1.0 + x) * (-x).exp()
    }

    /// Converts tractions and derivatives in units of φ_n/δ_n, φ_t/δ_t and the lengths to a response.
    pub(crate) fn scale(&self, [n, t]: [f64; 2], [[nn, nt], [tn, tt]]: [[f64; 2]; 2], secant: f64) -> crate::Response {
        let Self { normal_work, tangential_work, normal_length, tangential_length } = *self;
        let (strength, shear_strength) = (normal_work / normal_length, tangential_work / tangential_length);
        crate::Response {
            traction: [strength * n, shear_strength * t],
            jacobian: [
                [strength / normal_length * nn, strength / tangential_length * nt],
                [shear_strength / normal_length * tn, shear_strength / tangential_length * tt],
            ],
            secant: shear_strength / tangential_length * secant,
        }
    }

    /// Returns the largest row sum of the [scaled](Self::scale) bounds of the entries, which bounds the eigenvalues.
    pub(crate) fn bound(&self, jacobian: [[f64; 2]; 2]) -> f64 {
        let [[nn, nt], [tn, tt]] = self.scale([0.0; 2], jacobian, 0.0).jacobian;
        (nn + nt).max(tn + tt)
    }
}

/// Largest reduced separation. Larger separations are replaced by it: the tractions there are zero, while the product
/// of a larger separation and a vanishing exponential may be NaN.
const FAR: f64 = 1e6;

/// Error in the name, the parameters or the table of a law.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LawError {
    /// Value out of range.
    #[error("{name} is {found}; it must be {allowed}")]
    Range {
        /// Parameter name.
        name: &'static str,
        /// Its value.
        found: f64,
        /// Allowed values, completing "it must be".
        allowed: &'static str,
    },
    /// Unknown law.
    #[error("the law is {found:?}; it must be one of {}{}", LawKind::names(|_| true), LawKind::instead_of(found))]
    Name {
        /// Requested name.
        found: String,
    },
    /// Parameter that the law does not have.
    #[error("the law {} has no parameter {found:?}; it takes {}", kind.name(), Parameter::list(kind.parameters()))]
    Unknown {
        /// Law.
        kind: LawKind,
        /// Name of the parameter.
        found: String,
    },
    /// Parameter without a value.
    #[error("the law {} needs the parameter {parameter}", kind.name())]
    Missing {
        /// Law.
        kind: LawKind,
        /// Missing parameter.
        parameter: Parameter,
    },
    /// Table with points that cannot be interpolated.
    #[error("the table: {0}")]
    Curve(#[from] gfmd_curve::CurveError),
    /// Table that is not a valid law.
    #[error("the {found}; it must be {allowed}")]
    Table {
        /// Part of the table and its value.
        found: String,
        /// Allowed values, completing "it must be".
        allowed: &'static str,
    },
    /// [`LawKind::Table`] without a table.
    #[error("the law table needs its rows: gaps and tractions")]
    NoTable,
    /// Parameter given more than once.
    #[error("the parameter {name} is given more than once")]
    Twice {
        /// Parameter name.
        name: &'static str,
    },
}

/// Returns a ratio of parameters, or an error if it is not finite.
pub(crate) fn finite(name: &'static str, found: f64) -> Result<f64, LawError> {
    if found.is_finite() { Ok(found) } else { Err(LawError::Range { name, found, allowed: "finite" }) }
}

pub(crate) fn positive(name: &'static str, found: f64) -> Result<f64, LawError> {
    if found > 0.0 && found.is_finite() {
        Ok(found)
    } else {
        Err(LawError::Range { name, found, allowed: "a positive, finite number" })
    }
}
