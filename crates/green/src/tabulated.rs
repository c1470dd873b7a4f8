use std::sync::Arc;

use gfmd_curve::{Curve, CurveError};

use crate::GreenError;

/// Normal compliance of a body by wave vector: ln G = a₀ + Σ a_k cos 2kθ + b_k sin 2kθ, with curves of ln q as
/// coefficients and the angle θ of q to the x axis. Fields are real, so G(−q) = G(q), and there are no odd multiples of
/// θ.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Table {
    /// a₀ as a function of ln q, in the units of the table.
    mean: Arc<Curve>,
    /// a_k and b_k for k = 1, 2, ..., up to the last significant one; empty for an isotropic body.
    harmonics: Arc<[[Option<Curve>; 2]]>,
    /// Compliance of the mean level.
    pub(crate) uniform: f64,
    /// Factor from wavenumbers of the body to wavenumbers of the table.
    length: f64,
    /// Factor from compliances of the table to compliances of the body.
    compliance: f64,
}

/// Smallest number of directions in half a turn.
const LEAST_DIRECTIONS: usize = 4;

/// Largest deviation of wavenumbers (relative) and angles (rad) from a regular table, since files have few digits.
const ROUNDING_OF_TABLE: f64 = 1e-4;

/// Largest angular coefficient that counts as a rounding error of ln G.
const NOTHING: f64 = 1e-14;

/// Table by wave vector: the logarithms of its wavenumbers, and ln G `[wavenumber, direction]`.
struct Polar {
    logarithms: Vec<f64>,
    directions: usize,
    values: Vec<f64>,
}

impl Table {
    /// Creates a table from the rows [wavenumber, compliance].
    pub(crate) fn isotropic(rows: &[[f64; 2]], uniform: f64) -> Result<Self, GreenError> {
        positive(rows.iter().map(|row| &row[..]))?;
        let logarithms: Vec<[f64; 2]> = rows.iter().map(|row| row.map(f64::ln)).collect();
        // Report the numbers of the rows; a curve would report their logarithms.
        if let Some(row) = logarithms.windows(2).position(|pair| pair[1][0] <= pair[0][0]) {
            let [before, found] = [rows[row][0], rows[row + 1][0]];
            return Err(GreenError::Table(CurveError::Order { row: row + 2, found, before }));
        }
        Self::of(&logarithms, [].into(), uniform)
    }

    /// Creates a table from the rows [q_x, q_y, compliance].
    pub(crate) fn anisotropic(rows: &[[f64; 3]], uniform: f64) -> Result<Self, GreenError> {
        positive(rows.iter().map(|row| &row[2..]))?;
        let Polar { logarithms, directions, values } = Polar::of(rows)?;
        let curve = |angle: &dyn Fn(usize) -> f64| -> Result<(Vec<[f64; 2]>, f64), GreenError> {
            let mean = |values: &[f64]| {
                let sum: f64 = values.iter().enumerate().map(|(j, value)| value * angle(j)).sum();
                sum / directions as f64
            };
            let points: Vec<[f64; 2]> =
                logarithms.iter().zip(values.chunks(directions)).map(|(q, values)| [*q, mean(values)]).collect();
            let largest = points.iter().map(|point| point[1].abs()).fold(0.0, f64::max);
            Ok((points, largest))
        };
        let (mean, _) = curve(&|_| 1.0)?;
        let mut harmonics = Vec::new();
        for k in 1..=directions / 2 {
            // With an even number of directions, the highest angle has no sine, and its cosine counts once.
            let is_last = 2 * k == directions;
            let turn = |j: usize| 2.0 * std::f64::consts::PI * ((k * j) % directions) as f64 / directions as f64;
            let factor = if is_last { 1.0 } else { 2.0 };
            let part = |of: fn(f64) -> f64| -> Result<Option<Curve>, GreenError> {
                let (points, largest) = curve(&|j| factor * of(turn(j)))?;
                (largest > NOTHING).then(|| Curve::new(&points).map_err(GreenError::Table)).transpose()
            };
            harmonics.push([part(f64::cos)?, if is_last { None } else { part(f64::sin)? }]);
        }
        let kept = harmonics.iter().rposition(|parts| parts.iter().any(Option::is_some)).map_or(0, |last| last + 1);
        harmonics.truncate(kept);
        Self::of(&mean, harmonics.into(), uniform)
    }

    fn of(mean: &[[f64; 2]], harmonics: Arc<[[Option<Curve>; 2]]>, uniform: f64) -> Result<Self, GreenError> {
        if !(uniform.is_finite() && uniform >= 0.0) {
            return Err(GreenError::UniformCompliance(uniform));
        }
        let mean = Curve::new(mean).map_err(GreenError::Table)?.into();
        Ok(Self { mean, harmonics, uniform, length: 1.0, compliance: 1.0 })
    }

    /// Returns true if the compliance does not depend on the direction.
    pub(crate) fn is_isotropic(&self) -> bool {
        self.harmonics.is_empty()
    }

    /// Returns the compliance of a wave vector.
    pub(crate) fn compliance(&self, [x, y]: [f64; 2]) -> f64 {
        let q = x.hypot(y);
        let logarithm = (q * self.length).ln();
        let [mut sum, _] = self.mean.at(logarithm);
        // Cosine and sine of twice the angle and its multiples.
        let [a, b] = [x / q, y / q];
        let [c, s] = [(a - b) * (a + b), 2.0 * a * b];
        let mut angle = [c, s];
        for parts in self.harmonics.iter() {
            for (part, angle) in parts.iter().zip(angle) {
                sum += part.as_ref().map_or(0.0, |part| part.at(logarithm)[0] * angle);
            }
            angle = [angle[0] * c - angle[1] * s, angle[1] * c + angle[0] * s];
        }
        self.compliance * sum.exp()
    }

    /// Returns the first and the last wavenumber.
    pub(crate) fn wavenumbers(&self) -> [f64; 2] {
        self.mean.ends().map(|end| end.exp() / self.length)
    }

    /// Converts the table to other units, given in the current units.
    pub(crate) fn in_units(&self, stress: f64, length: f64) -> Self {
        Self {
            length: self.length / length,
            compliance: self.compliance * stress / length,
            uniform: self.uniform * stress / length,
            ..self.clone()
        }
    }
}

/// Checks that all values are positive and finite.
fn positive<'a>(rows: impl Iterator<Item = &'a [f64]>) -> Result<(), GreenError> {
    for (row, numbers) in (1..).zip(rows) {
        if let Some(&found) = numbers.iter().find(|number| !(number.is_finite() && **number > 0.0)) {
            return Err(GreenError::Compliance { row, found });
        }
    }
    Ok(())
}

impl Polar {
    /// Sorts rows by wavenumber and direction.
    fn of(rows: &[[f64; 3]]) -> Result<Self, GreenError> {
        struct Wave {
            row: usize,
            q: f64,
            angle: f64,
            value: f64,
        }
        let mut waves = Vec::with_capacity(rows.len());
        for (row, [x, y, value]) in (1..).zip(rows) {
            let q = x.hypot(*y);
            if !(q.is_finite() && q > 0.0) {
                return Err(GreenError::WaveVector { row, found: [*x, *y] });
            }
            // The wave −q is the wave q; an angle just below half a turn is 0.
            let angle = y.atan2(*x).rem_euclid(std::f64::consts::PI);
            let angle =
                if angle > std::f64::consts::PI - ROUNDING_OF_TABLE { angle - std::f64::consts::PI } else { angle };
            waves.push(Wave { row, q, angle, value: value.ln() });
        }
        waves.sort_by(|a, b| a.q.total_cmp(&b.q));
        // Number of waves with the same wavenumber.
        let directions = waves.iter().take_while(|wave| wave.q <= waves[0].q * (1.0 + ROUNDING_OF_TABLE)).count();
        if directions < LEAST_DIRECTIONS || !waves.len().is_multiple_of(directions) {
            return Err(GreenError::Directions { found: directions, rows: rows.len() });
        }
        let (mut logarithms, mut values) = (Vec::new(), Vec::with_capacity(waves.len()));
        for ring in waves.chunks_mut(directions) {
            let first = ring[0].q;
            ring.sort_by(|a, b| a.angle.total_cmp(&b.angle));
            for (j, wave) in ring.iter().enumerate() {
                let wanted = std::f64::consts::PI * j as f64 / directions as f64;
                let fits = (wave.q / first - 1.0).abs() <= ROUNDING_OF_TABLE
                    && (wave.angle - wanted).abs() <= ROUNDING_OF_TABLE;
                if !fits {
                    let (row, angle) = (wave.row, wave.angle.to_degrees());
                    return Err(GreenError::Direction { row, q: wave.q, angle, directions });
                }
            }
            logarithms.push(ring.iter().map(|wave| wave.q.ln()).sum::<f64>() / directions as f64);
            values.extend(ring.iter().map(|wave| wave.value));
        }
        let points = logarithms.len();
        if points < gfmd_curve::LEAST {
            return Err(GreenError::Table(CurveError::Few { found: points }));
        }
        Ok(Self { logarithms, directions, values })
    }
}
