//! Points that may touch, from their heights alone.

use super::constants::{BINS, KAPPA, LEAST_OVERLAPPING, MOST_OVERLAPPING, OVERLAPPING};
use gfmd_vector::Share;
use rayon::prelude::*;

use super::points::gathered;
use crate::{Clearance, Contact, Load};

/// Overlap of the surface with a rigid plane below its highest point, at the start.
#[derive(Clone, Copy)]
pub(super) struct Overlap {
    /// Depth of the plane, in length.
    pub(super) depth: f64,
    /// About E* times the rms gradient: the pressure where the overlap is largest.
    stiffness: f64,
}

impl Overlap {
    /// Estimates the overlap. Returns `None` if too many points overlap.
    pub(super) fn of(contact: &Contact, load: Load) -> Option<Self> {
        let Contact { response, scaled: surface, share, .. } = contact;
        let clearance = surface.clearance();
        let stiffness = response.contact_modulus() * rough_gradient(clearance, share, response.grid().spacing()[1]);
        let depth = match load {
            Load::MeanPressure(mean) => {
                depth_of(clearance, share, surface.mean_clearance(), OVERLAPPING * KAPPA * mean / stiffness)?
            }
            Load::Approach(approach) => approach,
        };
        Some(Self { depth, stiffness })
    }

    /// Returns the pressure at a point with this clearance.
    pub(super) fn pressure(self, clearance: f64) -> f64 {
        self.stiffness * ((self.depth - clearance) / self.depth).max(0.0)
    }
}

/// Returns √2 times the rms gradient along the rows, from every sixteenth row.
fn rough_gradient(clearance: Clearance, share: &Share, spacing: f64) -> f64 {
    let columns = share.columns();
    let row = |row: Clearance| row.iter().zip(row.iter().skip(1)).map(|(a, b)| (b - a).powi(2)).sum::<f64>();
    let own = share.rows().enumerate().filter(|(_, number)| number.is_multiple_of(16));
    let own = own.map(|(i, _)| row(clearance.part(i * columns..(i + 1) * columns)));
    let squares = gathered(share, own.collect::<Vec<_>>());
    let count = (squares.len() * (columns - 1)) as f64;
    (2.0 * squares.iter().sum::<f64>() / count).sqrt() / spacing
}

/// Number of points that are counted at once.
const BATCH: usize = 1 << 16;

/// Returns the clearance below which a fraction `part` of the points, or a few, lie; `None` if these are too many.
fn depth_of(clearance: Clearance, share: &Share, mean: f64, part: f64) -> Option<f64> {
    let asked = (part * share.total() as f64).max(LEAST_OVERLAPPING);
    let possible = asked <= MOST_OVERLAPPING * share.total() as f64;
    if !possible {
        return None;
    }
    let scale = BINS as f64 / mean;
    let counts = (0..clearance.len()).into_par_iter().step_by(BATCH).map(|start| {
        let mut counts = vec![0_u64; BINS];
        for c in clearance.part(start..clearance.len().min(start + BATCH)).iter() {
            if let Some(count) = counts.get_mut((c * scale) as usize) {
                *count += 1;
            }
        }
        counts
    });
    let add = |mut a: Vec<u64>, b: Vec<u64>| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    };
    let counts = gathered(share, counts.reduce(|| vec![0; BINS], add));
    let counts = counts.chunks_exact(BINS).fold(vec![0; BINS], |all, counts| add(all, counts.to_vec()));
    let mut below = 0;
    let bin = counts.iter().position(|count| {
        below += count;
        below as f64 >= asked
    })?;
    Some((bin + 1) as f64 / scale)
}
