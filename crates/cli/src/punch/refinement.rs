//! The limit of the mean pressure of a punch on finer and finer grids.

use gfmd_files::{Archive, Dimension, FileError, Reader, Variable};
use serde::Serialize;

/// The mean pressure on grids that are each twice as fine as the one before.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Refinement {
    pub n: Vec<usize>,
    pub mean_pressure: Vec<f64>,
    /// log₂ of the ratio of the last two changes: 1 if the error is proportional to the spacing. `None` for fewer than
    /// three grids.
    pub order: Option<f64>,
    /// The limit, if the error is a power series of the spacing (Richardson's extrapolation over all grids).
    pub extrapolated: f64,
    /// The change of the limit if the coarsest grid is left out; `None` for fewer than three grids.
    pub uncertainty: Option<f64>,
}

impl Refinement {
    /// Extrapolates the pressures of at least one grid.
    pub(super) fn of(n: Vec<usize>, mean_pressure: Vec<f64>) -> Self {
        let order = match mean_pressure[..] {
            [.., a, b, c] => Some(((b - a) / (c - b)).log2()),
            _ => None,
        };
        let extrapolated = extrapolate(&mean_pressure);
        let uncertainty = order.map(|_| (extrapolated - extrapolate(&mean_pressure[1..])).abs());
        Self { n, mean_pressure, order, extrapolated, uncertainty }
    }

    /// Writes the group `/refinement`.
    pub(super) fn write(&self, archive: &mut Archive) -> Result<(), FileError> {
        let n = self.n.iter().map(|n| *n as f64).collect();
        let n = Dimension::values("n", n, "1", "points along each axis");
        let long_name = "mean pressure over the whole surface on this grid";
        let variable = Variable { dimensions: &[&n], units: "stress", long_name };
        archive.write("/refinement/mean_pressure", &variable, &self.mean_pressure)
    }

    /// Reads the group `/refinement`; `None` if the file has none.
    pub(super) fn read(reader: &Reader) -> Result<Option<Self>, FileError> {
        if !reader.contains("/refinement/mean_pressure") {
            return Ok(None);
        }
        let n = reader.values::<f64>("/refinement/n")?.into_iter().map(|n| n as usize).collect();
        Ok(Some(Self::of(n, reader.values("/refinement/mean_pressure")?)))
    }
}

/// Extrapolates to zero spacing by Neville's scheme: each column removes one power of the spacing.
fn extrapolate(values: &[f64]) -> f64 {
    let mut column = values.to_vec();
    let mut factor = 1.0;
    while column.len() > 1 {
        factor *= 2.0;
        column = column.windows(2).map(|pair| (factor * pair[1] - pair[0]) / (factor - 1.0)).collect();
    }
    column.first().copied().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;

    #[test]
    fn powers_of_the_spacing_are_removed() {
        let value = |h: f64| 3.0 + 0.5 * h - 0.2 * h * h + 0.1 * h.powi(3);
        let [a, b, c, d] = [0.4, 0.2, 0.1, 0.05].map(value);
        let refinement = Refinement::of(vec![8, 16, 32, 64], vec![a, b, c, d]);
        assert_relative_eq!(refinement.extrapolated, 3.0, max_relative = 1e-14);
        assert!((refinement.order.unwrap() - 1.0).abs() < 0.1);
        assert!(refinement.uncertainty.unwrap() > 1e-6);
        let one = Refinement::of(vec![8], vec![a]);
        assert_eq!((one.order, one.extrapolated, one.uncertainty), (None, a, None));
    }
}
