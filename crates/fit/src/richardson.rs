//! Richardson extrapolation: the power law through three levels of one axis (theory.md, section 11).

use crate::datum::same_level;
use crate::{Axis, Datum};

/// Three data that differ in one eps only, with a constant ratio of levels, and their extrapolation.
#[derive(Clone, Debug, PartialEq)]
pub struct Richardson {
    /// Axis with different levels.
    pub axis: Axis,
    /// Indices of the data, coarse to fine.
    pub data: [usize; 3],
    /// rho = (k1 - k2) / (k2 - k3). A power law through the three data exists only if rho > 1.
    pub ratio: f64,
    /// Limit and exponent of the power law, if it exists.
    pub limit: Option<RichardsonLimit>,
}

/// Power law through three levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RichardsonLimit {
    /// kappa for eps -> 0 along this axis only; it still contains the terms of the other axes.
    pub kappa: f64,
    /// Exponent ln rho / ln r, with r the ratio of levels.
    pub exponent: f64,
    /// Standard error of `kappa`, from the scatter of the realisations common to all three levels (at least two).
    pub standard_error: Option<f64>,
}

/// Returns all triples along `axis`, in the order of the data.
pub(crate) fn triples(data: &[Datum], axis: Axis) -> Vec<Richardson> {
    let mut found = Vec::new();
    let others = |a: &Datum, b: &Datum| Axis::ALL.iter().all(|&o| o == axis || same_level(a.eps(o), b.eps(o)));
    for (first, coarse) in data.iter().enumerate() {
        for (second, middle) in data.iter().enumerate() {
            let ratio = coarse.eps(axis) / middle.eps(axis);
            if ratio <= 1.0 + 1e-6 || !others(coarse, middle) {
                continue;
            }
            let third = data
                .iter()
                .position(|fine| same_level(middle.eps(axis) / fine.eps(axis), ratio) && others(coarse, fine));
            // Only neighbouring levels are used: 1, 1/2, 1/4 but not 1, 1/4, 1/16.
            let skips = data.iter().any(|between| {
                others(coarse, between)
                    && between.eps(axis) < coarse.eps(axis) * (1.0 - 1e-9)
                    && between.eps(axis) > middle.eps(axis) * (1.0 + 1e-9)
            });
            if let (Some(third), false) = (third, skips) {
                found.push(extrapolate(data, axis, [first, second, third], ratio));
            }
        }
    }
    found
}

fn extrapolate(data: &[Datum], axis: Axis, indices: [usize; 3], levels: f64) -> Richardson {
    let [coarse, middle, fine] = indices.map(|i| &data[i]);
    let [k1, k2, k3] = [coarse.mean(), middle.mean(), fine.mean()];
    let ratio = (k1 - k2) / (k2 - k3);
    let limit = (ratio > 1.0 && ratio.is_finite()).then(|| {
        let scale = 1.0 / ((ratio - 1.0) * (ratio - 1.0));
        let weights = [scale, -2.0 * ratio * scale, ratio * ratio * scale];
        let paired: Vec<f64> = coarse
            .kappa
            .iter()
            .filter_map(|(seed, a)| {
                let (b, c) = (middle.kappa.get(seed)?, fine.kappa.get(seed)?);
                Some(weights[0] * a + weights[1] * b + weights[2] * c)
            })
            .collect();
        let n = paired.len() as f64;
        let mean = paired.iter().sum::<f64>() / n;
        let variance = paired.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
        RichardsonLimit {
            kappa: k3 - (k2 - k3) / (ratio - 1.0),
            exponent: ratio.ln() / levels.ln(),
            standard_error: (paired.len() > 1).then(|| (variance / n).sqrt()),
        }
    });
    Richardson { axis, data: indices, ratio, limit }
}
