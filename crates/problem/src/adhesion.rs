//! Numbers of an attraction on a surface and a grid, reported before the solve (theory.md, section 8).

use std::f64::consts::PI;
use std::fmt;

use gfmd_field::Grid;
use gfmd_law::Law;
use gfmd_surface::Moments;
use serde::Serialize;

use crate::options::LawArgs;
use crate::{Unusable, key, words};

/// Numbers of an attraction on a surface and a grid.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Adhesion {
    /// Work of separation w, stress × length.
    pub work: f64,
    /// Range ϱ = √(w / steepness), length: the range of an exponential attraction of this work and steepness.
    pub range: f64,
    /// Width of the process zone at the edge of a contact, (π/4) E* ϱ²/w, length.
    pub process_zone: f64,
    /// Process zone divided by the grid step.
    pub process_zone_points: f64,
    /// Grid steps in the process zone that this law needs to give the pull-off load of a sphere to 2.5 %.
    pub process_zone_needed: f64,
    /// Wang-Zhou-Müser criterion √(steepness × grid step / E*); below 0.5 the grid resolves the attraction.
    pub wang_zhou_muser: f64,
    /// Tabor number (R w²/(E*² ϱ³))^⅓ with 1/R the rms curvature of the surface; `None` for a flat surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tabor: Option<f64>,
    /// Pastewka-Robbins criterion; below 1 the surfaces stick. `None` for a flat surface.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pastewka_robbins: Option<f64>,
}

/// Least width of the process zone, in grid steps, that is solved without `--coarse`.
pub(crate) const LEAST_POINTS: f64 = 0.1;

/// Wang-Zhou-Müser criterion (Lubricants 9, 17 (2021), eq. 9 and fig. 8); below it the grid resolves the attraction.
const WANG_ZHOU_MUSER: f64 = 0.5;

impl Adhesion {
    /// Computes the numbers of a law on a surface with these `moments` on `grid`, and a body of this contact modulus.
    /// `None` without an attraction, or if one of its numbers is too large or too small.
    pub fn of(args: &LawArgs, law: &dyn Law, grid: &Grid, moments: &Moments, contact_modulus: f64) -> Option<Self> {
        let work = args.work()?;
        let steepness = law.steepness();
        let range = (work / steepness).sqrt();
        let process_zone = 0.25 * PI * contact_modulus / steepness;
        let sides = if grid.is_line() { 1 } else { 2 };
        let spacing = grid.spacing()[..sides].iter().copied().fold(0.0, f64::max);
        let (gradient, curvature) = (moments.rms_gradient(), moments.rms_curvature());
        let finite = |value: f64| Some(value).filter(|value| value.is_finite());
        let length = work / contact_modulus;
        // κ_rep = 2, diameter of a contact 4 h′/h″.
        let slope = gradient * range / (2.0 * length);
        let squeezed = (gradient * gradient / (curvature * range)).powf(2.0 / 3.0);
        let found = Self {
            work,
            range,
            process_zone,
            process_zone_points: process_zone / spacing,
            process_zone_needed: law.resolving_points(),
            wang_zhou_muser: (steepness * spacing / contact_modulus).sqrt(),
            tabor: finite(((length / range).powi(2) / (curvature * range)).cbrt()),
            pastewka_robbins: finite(slope * squeezed / (PI * (3.0_f64 / 16.0).powf(2.0 / 3.0))),
        };
        let sizes = [range, process_zone, found.process_zone_points];
        sizes.iter().all(|size| *size > 0.0 && size.is_finite()).then_some(found)
    }

    /// Refuses a grid that is much too coarse, unless `coarse`.
    ///
    /// # Errors
    /// Returns an error if the process zone is below a tenth of a grid step.
    pub fn check(&self, coarse: bool) -> Result<(), Unusable> {
        let points = self.process_zone_points;
        if points < LEAST_POINTS && !coarse {
            let why = words![
                format!(
                    "the process zone at the edge of a contact is {points:.1e} grid steps wide; it must be at least "
                ),
                format!("{LEAST_POINTS}: refine the grid, take a longer range, or give "),
                key("coarse"),
                " for a contact of single points",
            ];
            return Err(Unusable::of(why).at(key("law")));
        }
        Ok(())
    }

    /// Returns a warning if the process zone has fewer grid steps than the law needs.
    pub fn unresolved(&self) -> Option<String> {
        let Self { process_zone_points: points, process_zone_needed: needed, .. } = *self;
        (points < needed).then(|| {
            format!(
                "the process zone at the edge of a contact is {points:.2} grid steps wide; with this law {needed} or \
                 more give a pull-off load to 2.5 %, fewer give a larger error: refine the grid or increase the range"
            )
        })
    }
}

impl fmt::Display for Adhesion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { range, wang_zhou_muser, tabor, pastewka_robbins, .. } = *self;
        let Self { process_zone_points: points, process_zone_needed: needed, .. } = *self;
        let is_resolved = points >= needed;
        let resolved = if is_resolved { "resolved".into() } else { format!("not resolved: {needed} or more are") };
        write!(f, "adhesion: range {range:.3e}; process zone of {points:.2} grid steps ({resolved})")?;
        // The criterion holds for a smooth law; it does not resolve a law that needs more grid steps.
        let words = match wang_zhou_muser < WANG_ZHOU_MUSER {
            true if is_resolved => "below 0.5: resolved",
            true => "below 0.5, enough for a smooth law",
            false => "not resolved: below 0.5 is",
        };
        write!(f, "; Wang-Zhou-Müser {wang_zhou_muser:.2} ({words})")?;
        if let Some(tabor) = tabor {
            let limit = match tabor {
                ..0.1 => "long range, as DMT",
                5.0.. => "short range, as JKR",
                _ => "between DMT and JKR",
            };
            write!(f, "; Tabor number {tabor:.2} ({limit})")?;
        }
        if let Some(found) = pastewka_robbins {
            let words = if found < 1.0 { "below 1: the surfaces stick" } else { "above 1: they do not stick" };
            write!(f, "; Pastewka-Robbins {found:.2} ({words})")?;
        }
        Ok(())
    }
}
