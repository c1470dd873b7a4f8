use gfmd_field::Grid;
use ndarray::ArrayRef2;

use super::ratio::{Core, MaterialRatio};
use crate::SurfaceError;
use crate::error::positive;
use crate::statistics::checked;

/// Height of a hill or depth of a dale that counts as an element, as a fraction of the highest or lowest height.
const ELEMENT: f64 = 0.1;

/// Parameters of a profile of ISO 21920-2 about its mean line, over the evaluation length unless stated, under the
/// names for a filtered roughness profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProfileNumbers {
    /// Number of whole sections in the evaluation length.
    pub sections: usize,
    /// Ra: mean distance from the mean line, length.
    pub ra: f64,
    /// Rq: root mean square distance from the mean line, length.
    pub rq: f64,
    /// Rsk: skewness; `None` for a flat profile.
    pub rsk: Option<f64>,
    /// Rku: kurtosis; `None` for a flat profile.
    pub rku: Option<f64>,
    /// Rt: highest minus lowest height, length.
    pub rt: f64,
    /// Rp: mean over the sections of the highest height, length.
    pub rp: f64,
    /// Rv: mean over the sections of the depth of the lowest height, length.
    pub rv: f64,
    /// Rz: mean over the sections of the highest minus the lowest height, length.
    pub rz: f64,
    /// Rzx: largest of the heights of the sections, length.
    pub rzx: f64,
    /// Rdq: root mean square slope by forward differences.
    pub rdq: f64,
    /// Rsm: mean width of the profile elements, length; `None` with fewer than two equal crossings of the mean line. An
    /// element is a hill above a tenth of the largest Rp of the sections and a dale below a tenth of the largest depth.
    pub rsm: Option<f64>,
    /// Rk, Rpk, Rvk, Rmr1, Rmr2: parameters of the bearing curve; `None` for a flat profile.
    pub core: Option<Core>,
}

impl ProfileNumbers {
    /// Computes the parameters of heights `[n, 1]` for sections of the length `section`. Points beyond the last whole
    /// section count in the evaluation length only.
    ///
    /// # Errors
    /// Heights that do not have the shape of the grid or are not finite; a surface; fewer than two points in a section.
    pub fn of(heights: &ArrayRef2<f64>, grid: &Grid, section: f64) -> Result<Self, SurfaceError> {
        let (heights, spacing) = (checked(heights, grid)?, grid.spacing()[0]);
        let (heights, count) = (&heights[..], heights.len());
        if !grid.is_line() {
            return Err(SurfaceError::ProfileAxis(grid.points()));
        }
        // A section that is a whole number of steps but for rounding.
        let points = positive("section length", section)? / spacing;
        let points = ((points * (1.0 + 1e-9)) as usize).min(count);
        if points < 2 {
            return Err(SurfaceError::TooFewPoints { what: "a section", least: 2, found: [points, 1] });
        }
        let mean_of =
            |value: &dyn Fn(f64) -> f64| heights.iter().map(|height| value(*height)).sum::<f64>() / count as f64;
        let mean = mean_of(&|height| height);
        let rq = mean_of(&|height| (height - mean).powi(2)).sqrt();
        let ratio = |power: i32| (rq > 0.0).then(|| mean_of(&|height| ((height - mean) / rq).powi(power)));
        let ends: Vec<[f64; 2]> = heights.chunks_exact(points).map(|part| ends(part, mean)).collect();
        let of_sections = |value: &dyn Fn(&[f64; 2]) -> f64| ends.iter().map(value).sum::<f64>() / ends.len() as f64;
        let [rp, rv] = [of_sections(&|[high, _]| *high), of_sections(&|[_, low]| -low)];
        let [highest, lowest] = self::ends(heights, mean);
        let slope = |pair: &[f64]| ((pair[1] - pair[0]) / spacing).powi(2);
        Ok(Self {
            sections: ends.len(),
            ra: mean_of(&|height| (height - mean).abs()),
            rq,
            rsk: ratio(3),
            rku: ratio(4),
            rt: highest - lowest,
            rp,
            rv,
            rz: rp + rv,
            rzx: ends.iter().map(|[high, low]| high - low).fold(0.0, f64::max),
            rdq: (heights.windows(2).map(slope).sum::<f64>() / (count - 1) as f64).sqrt(),
            rsm: element_width(heights, mean, [ELEMENT * highest, ELEMENT * lowest]).map(|width| width * spacing),
            core: MaterialRatio::of(heights).map(|curve| curve.core()),
        })
    }
}

/// Returns the highest and lowest heights above the mean.
fn ends(heights: &[f64], mean: f64) -> [f64; 2] {
    let ends = [f64::NEG_INFINITY, f64::INFINITY];
    heights.iter().fold(ends, |[high, low], height| [high.max(height - mean), low.min(height - mean)])
}

/// Returns the mean distance in steps between crossings of the mean line in the same direction, averaged over both
/// directions. A crossing counts if the profile goes from below `low` to above `high` or back; of several crossings in
/// between, the middle of the first and the last one counts.
fn element_width(heights: &[f64], mean: f64, [high, low]: [f64; 2]) -> Option<f64> {
    let mut counted: [Vec<f64>; 2] = Default::default();
    let (mut above, mut crossed) = (None, None::<[f64; 2]>);
    let mut before = f64::NAN;
    for (k, height) in heights.iter().map(|height| height - mean).enumerate() {
        if k > 0 && (before < 0.0) != (height < 0.0) {
            let at = (k - 1) as f64 + before / (before - height);
            crossed = Some([crossed.map_or(at, |[first, _]| first), at]);
        }
        let side = if height > high {
            Some(true)
        } else if height < low {
            Some(false)
        } else {
            None
        };
        if let Some(side) = side {
            if above == Some(!side)
                && let Some([first, last]) = crossed
            {
                counted[usize::from(side)].push(0.5 * (first + last));
            }
            (above, crossed) = (Some(side), None);
        }
        before = height;
    }
    let width = |at: &Vec<f64>| (at.len() > 1).then(|| (at[at.len() - 1] - at[0]) / (at.len() - 1) as f64);
    let widths: Vec<f64> = counted.iter().filter_map(width).collect();
    (!widths.is_empty()).then(|| widths.iter().sum::<f64>() / widths.len() as f64)
}
