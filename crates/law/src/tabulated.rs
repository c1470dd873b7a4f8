use gfmd_curve::Curve;

use crate::{Law, LawError, Opening, Response};

/// A law of the gap from a table: the shape-preserving cubic [`Curve`] through its tractions. The energy is the exact
/// integral of the curve. The traction is zero beyond the largest gap.
///
/// A table that begins at gap 0 has a hard wall there. A table that begins at a negative gap must begin with a
/// repulsion, which is continued along its tangent.
#[derive(Clone, Debug, PartialEq)]
pub struct Tabulated {
    curve: Curve,
    has_wall: bool,
    /// Integral of the traction over the table.
    opened: f64,
    /// Largest magnitude of the slope.
    stiffest: f64,
    steepness: f64,
    work: f64,
}

impl Tabulated {
    /// Creates the law from rows [gap, traction]; attractions are positive.
    ///
    /// # Errors
    /// Returns an error for fewer than four rows; numbers that are not finite; gaps that do not increase; a smallest
    /// gap above 0 or a largest gap not above 0; a negative smallest gap without a repulsion that grows on approach; a
    /// traction other than 0 at the largest gap, or 0 everywhere; an energy that is not finite.
    pub fn new(rows: &[[f64; 2]]) -> Result<Self, LawError> {
        let refuse = |found: String, allowed: &'static str| Err(LawError::Table { found, allowed });
        let curve = Curve::new(rows)?;
        let ([first, strongest], [last, end]) = (rows[0], rows[rows.len() - 1]);
        if first > 0.0 {
            let allowed = "0, where a hard wall stands, or negative, with a repulsion";
            return refuse(format!("smallest gap is {first:e}"), allowed);
        }
        if last <= 0.0 {
            return refuse(format!("largest gap is {last:e}"), "positive");
        }
        if end != 0.0 {
            let allowed = "0, as it is from there on";
            return refuse(format!("traction at the largest gap is {end:e}"), allowed);
        }
        let has_wall = first == 0.0;
        let [_, slope] = curve.at(first);
        if !has_wall && strongest >= 0.0 {
            let allowed = "negative, a repulsion, since no wall stands at a negative gap";
            return refuse(format!("traction at the smallest gap is {strongest:e}"), allowed);
        }
        if !has_wall && slope <= 0.0 {
            let allowed = "positive, so that the repulsion grows as the surfaces approach";
            return refuse(format!("slope at the smallest gap is {slope:e}"), allowed);
        }
        if rows.iter().all(|[_, traction]| *traction == 0.0) {
            return refuse("tractions are 0".into(), "other than 0 somewhere (the law hard-wall has none)");
        }
        let [low, high] = curve.slopes(first);
        let [decay, _] = curve.slopes(0.0);
        let opened = curve.integral(last);
        // The energy is lowest where the traction crosses zero from below, or at the wall.
        let wall = has_wall.then_some([0.0, 0.0]);
        let roots = rows.windows(2).filter(|pair| pair[0][1] <= 0.0 && pair[1][1] > 0.0);
        let work = roots.map(|pair| root(&curve, [pair[0][0], pair[1][0]])).chain(wall.map(|[gap, _]| gap));
        let work = work.map(|gap| opened - curve.integral(gap)).fold(0.0, f64::max);
        Ok(Self { curve, has_wall, opened, stiffest: high.max(-low), steepness: (-decay).max(0.0), work })
    }

    /// Returns the work of separation: the depth of the energy minimum, per area; 0 for a purely repulsive law.
    pub fn work(&self) -> f64 {
        self.work
    }
}

/// Finds the gap between `low` and `high` at which the traction changes sign, by bisection.
fn root(curve: &Curve, [mut low, mut high]: [f64; 2]) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if curve.at(middle)[0] > 0.0 { &mut high } else { &mut low }) = middle;
    }
    low
}

impl Law for Tabulated {
    fn response(&self, normal: f64, _: f64) -> Response {
        let Opening { traction, slope, .. } = self.opening(normal);
        Response::normal(traction, slope)
    }

    fn energy(&self, normal: f64, _: f64) -> Option<f64> {
        Some(self.opening_energy(normal))
    }

    fn opening_energy(&self, normal: f64) -> f64 {
        let [_, last] = self.curve.ends();
        if normal < last { self.curve.integral(normal) - self.opened } else { 0.0 }
    }

    fn opening(&self, normal: f64) -> Opening {
        let [_, last] = self.curve.ends();
        if normal < last {
            let [traction, slope] = self.curve.at(normal);
            Opening { energy: self.opening_energy(normal), traction, slope }
        } else {
            Opening::default()
        }
    }

    fn has_wall(&self) -> bool {
        self.has_wall
    }

    fn stiffness_bound(&self, _: f64) -> f64 {
        self.stiffest
    }

    fn steepness(&self) -> f64 {
        self.steepness
    }
}
