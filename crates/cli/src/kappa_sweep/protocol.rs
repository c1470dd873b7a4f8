//! The extrapolation of one axis at a time about reference cells, in the table, the JSON and the file of a sweep.

use std::fmt;

use gfmd_files::{Archive, Dimension, Variable};
use gfmd_fit::Axis as Limit;
use gfmd_sweep::{Arm, Curve, Estimated, Protocol};
use serde::Serialize;

use gfmd_input::failure::Failure;

/// The extrapolation about one cell, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct ProtocolReport {
    pub hurst: f64,
    pub p_star: f64,
    /// 1/eps_t, 1/eps_f, 1/eps_c of the reference cell.
    pub reference: [f64; 3],
    pub kappa_sim: Number,
    pub kappa_tfc: Option<Number>,
    pub arms: Vec<ArmReport>,
}

/// A number with its interval.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Number {
    pub value: f64,
    pub ci95: Option<[f64; 2]>,
}

/// kappa along one axis, as printed.
#[derive(Clone, Debug, Serialize)]
pub struct ArmReport {
    pub axis: char,
    pub eps_inv: Vec<f64>,
    pub kappa: Vec<Number>,
    pub limit: Option<Number>,
    pub coefficient: Option<Number>,
    pub exponent: Option<Number>,
    /// kappa of the finest level, from the others.
    pub predicted: Option<Number>,
}

impl From<Estimated> for Number {
    fn from(Estimated { value, ci95 }: Estimated) -> Self {
        Self { value, ci95 }
    }
}

impl From<&Protocol> for ProtocolReport {
    fn from(protocol: &Protocol) -> Self {
        let arm = |arm: &Arm| ArmReport {
            axis: arm.axis.letter(),
            eps_inv: arm.inverse.clone(),
            kappa: arm.kappa.iter().map(|kappa| (*kappa).into()).collect(),
            limit: arm.curve.map(|curve| curve.limit.into()),
            coefficient: arm.curve.map(|curve| curve.coefficient.into()),
            exponent: arm.curve.map(|curve| curve.exponent.into()),
            predicted: arm.predicted.map(Into::into),
        };
        let Protocol { hurst, p_star, reference, kappa_sim, arms, kappa_tfc } = protocol;
        Self {
            hurst: *hurst,
            p_star: *p_star,
            reference: *reference,
            kappa_sim: (*kappa_sim).into(),
            kappa_tfc: kappa_tfc.value.is_finite().then_some((*kappa_tfc).into()),
            arms: arms.iter().map(arm).collect(),
        }
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.ci95 {
            Some([low, high]) => write!(f, "{:.4} [{low:.4}, {high:.4}]", self.value),
            None => write!(f, "{:.4}", self.value),
        }
    }
}

impl fmt::Display for ProtocolReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { hurst, reference: [t, reference_f, c], kappa_sim, kappa_tfc, arms, .. } = self;
        writeln!(
            f,
            "\nH = {hurst}, one axis at a time about 1/eps = ({t}, {reference_f}, {c}): kappa_sim = {kappa_sim}"
        )?;
        for arm in arms {
            let ArmReport { axis, eps_inv, limit, coefficient, exponent, predicted, .. } = arm;
            let levels = eps_inv.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
            match (limit, coefficient, exponent) {
                (Some(limit), Some(coefficient), Some(exponent)) => writeln!(
                    f,
                    "  1/eps_{axis} = {levels}: C_{axis} = {coefficient}, alpha_{axis} = {exponent}, limit {limit}"
                )?,
                _ => writeln!(f, "  1/eps_{axis} = {levels}: no power law goes through these")?,
            }
            if let (Some(predicted), Some(finest), Some(kappa)) = (predicted, eps_inv.last(), arm.kappa.last()) {
                writeln!(f, "    1/eps_{axis} = {finest}: kappa = {kappa}, from the others {predicted}")?;
            }
        }
        match kappa_tfc {
            Some(kappa_tfc) => writeln!(f, "  kappa_TFC = {kappa_tfc}"),
            None => writeln!(f, "  no kappa_TFC: an axis has no power law"),
        }
    }
}

/// A number of a curve, with its word in the names of variables and its meaning.
type Named = (&'static str, &'static str, fn(&Curve) -> Estimated);

/// Writes `/protocol`, if the sweep has reference cells.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(archive: &mut Archive, protocols: &[Protocol]) -> Result<(), Failure> {
    if protocols.is_empty() {
        return Ok(());
    }
    let row = Dimension::index("protocol", protocols.len(), "one Hurst exponent, load and reference cell");
    let mut put = |name: &str, long_name: &str, value: &dyn Fn(&Protocol) -> f64| -> Result<(), Failure> {
        let values: Vec<f64> = protocols.iter().map(value).collect();
        let variable = Variable { dimensions: &[&row], units: "1", long_name };
        Ok(archive.write(&format!("/protocol/{name}"), &variable, &values)?)
    };
    put("hurst", "Hurst exponent", &|protocol| protocol.hurst)?;
    put("p_star", "reduced pressure p/(E* g)", &|protocol| protocol.p_star)?;
    for axis in Limit::ALL {
        let long_name = "inverse discretisation of the reference cell";
        put(&format!("eps_{axis}_inv"), long_name, &|protocol| protocol.reference[axis as usize])?;
    }
    let missing = Estimated { value: f64::NAN, ci95: None };
    let mut estimated = |name: &str, long_name: &str, of: &dyn Fn(&Protocol) -> Option<Estimated>| {
        put(name, long_name, &|protocol| of(protocol).unwrap_or(missing).value)?;
        for (end, suffix) in ["_ci95_low", "_ci95_high"].into_iter().enumerate() {
            let long_name = format!("end of the 95 % interval of {name}, from leaving out surfaces");
            let value = |protocol: &Protocol| of(protocol).and_then(|e| e.ci95).map_or(f64::NAN, |ends| ends[end]);
            put(&format!("{name}{suffix}"), &long_name, &value)?;
        }
        Ok::<(), Failure>(())
    };
    estimated("kappa_sim", "kappa of the reference cell", &|protocol| Some(protocol.kappa_sim))?;
    estimated("kappa_tfc", "kappa_sim minus the corrections of all axes", &|protocol| Some(protocol.kappa_tfc))?;
    let parts: [Named; 3] = [
        ("limit", "kappa at eps = 0 of this axis alone", |curve| curve.limit),
        ("coefficient", "coefficient C of the correction C eps^alpha", |curve| curve.coefficient),
        ("exponent", "exponent alpha of the correction C eps^alpha", |curve| curve.exponent),
    ];
    let arm = |protocol: &Protocol, axis: Limit| protocol.arms.iter().find(|arm| arm.axis == axis).cloned();
    for axis in Limit::ALL {
        for (name, long_name, part) in parts {
            estimated(&format!("{name}_{axis}"), long_name, &|protocol| {
                arm(protocol, axis).and_then(|arm| arm.curve).map(|curve| part(&curve))
            })?;
        }
        let long_name = "kappa of the finest level of this axis, predicted from the others";
        estimated(&format!("predicted_{axis}"), long_name, &|protocol| arm(protocol, axis)?.predicted)?;
    }
    Ok(())
}
