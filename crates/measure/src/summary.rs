use std::ops::Range;

use gfmd_vector::{Share, contiguous};
use ndarray::ArrayView2;

use crate::area::contact_area_over;
use crate::pressure::{InContact, elastic_energy_over};
use crate::{Boundary, kappa, reduced_pressure};

/// Scales of reduced quantities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scales {
    /// Contact modulus E* of the body, in stress.
    pub contact_modulus: f64,
    /// Root mean square of |∇h| over the whole rigid surface, dimensionless.
    pub rms_gradient: f64,
}

/// Measured quantities of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Summary {
    /// Mean pressure over the whole surface, in stress.
    pub mean_pressure: f64,
    /// Reduced pressure p̄/(E* ḡ).
    pub p_star: f64,
    /// Number of points in contact divided by the number of all points.
    pub area_fraction: f64,
    /// Area fraction without the excess of whole pixels along the perimeter (Yastrebov et al. 2017).
    pub area_fraction_corrected: f64,
    /// `area_fraction / p_star`.
    pub kappa: f64,
    /// `area_fraction_corrected / p_star`.
    pub kappa_corrected: f64,
    /// Number of points in contact.
    pub contact_nodes: u64,
    /// Neighbouring pairs with one point in contact and one not; none across the edge of a field that does not repeat.
    pub boundary_links: u64,
    /// Mean distance between the surfaces, in length.
    pub mean_gap: f64,
    /// Largest pressure, in stress.
    pub max_pressure: f64,
    /// Mean pressure over the points in contact, in stress.
    pub mean_pressure_in_contact: f64,
    /// Standard deviation of the pressure over the points in contact, in stress.
    pub pressure_deviation_in_contact: f64,
    /// Mean square pressure over the whole surface, in stress².
    pub pressure_moment_2: f64,
    /// Elastic energy per area of the surface, in stress × length.
    pub elastic_energy: f64,
}

impl Summary {
    /// Measures the fields of a contact. With an attraction, `pressure` is the repulsive part alone, which defines the
    /// points in contact, and `mean_pressure` contains all forces. A displacement that differs in size from the
    /// pressure gives a NaN elastic energy, a gap that differs in size a NaN mean gap.
    pub fn of(
        pressure: ArrayView2<f64>,
        displacement_z: ArrayView2<f64>,
        gap: ArrayView2<f64>,
        mean_pressure: f64,
        scales: &Scales,
        boundary: Boundary,
    ) -> Self {
        let (rows, columns) = pressure.dim();
        let fields = [pressure, displacement_z, gap];
        Self::distributed(&Share::whole(rows, columns), fields, mean_pressure, scales, boundary)
    }

    /// Measures the distributed `fields` (pressure, displacement, gap): each process passes the rows of its `share`.
    /// All processes get the summary that [`of`](Self::of) gives for the whole fields.
    pub fn distributed(
        share: &Share,
        fields: [ArrayView2<f64>; 3],
        mean_pressure: f64,
        scales: &Scales,
        boundary: Boundary,
    ) -> Self {
        let columns = fields[0].ncols();
        let fields = fields.each_ref().map(|field| contiguous(field));
        let [pressure, displacement_z, gap] = fields.each_ref().map(|field| &**field);
        let area = contact_area_over(share, columns, pressure, boundary);
        let contact = InContact::of(share, pressure);
        let alike = gap.len() == pressure.len();
        let gaps = |range: Range<usize>| gap.get(range).filter(|_| alike).map_or(f64::NAN, |gap| gap.iter().sum());
        let mean_gap = share.sum(&gaps) / share.total() as f64;
        let p_star = reduced_pressure(mean_pressure, scales.contact_modulus, scales.rms_gradient);
        Self {
            mean_pressure,
            p_star,
            area_fraction: area.fraction,
            area_fraction_corrected: area.corrected_fraction,
            kappa: kappa(area.fraction, p_star),
            kappa_corrected: kappa(area.corrected_fraction, p_star),
            contact_nodes: area.nodes as u64,
            boundary_links: area.boundary_links as u64,
            mean_gap,
            max_pressure: contact.max,
            mean_pressure_in_contact: contact.mean(),
            pressure_deviation_in_contact: contact.deviation(),
            pressure_moment_2: contact.powers[1] / share.total().max(1) as f64,
            elastic_energy: elastic_energy_over(share, pressure, displacement_z),
        }
    }

    /// Removes rounding errors behind a hard wall: sets the mean gap to zero if all points touch.
    #[must_use]
    pub fn at_wall(self) -> Self {
        let is_closed = self.area_fraction == 1.0 && self.mean_gap.is_finite();
        Self { mean_gap: if is_closed { 0.0 } else { self.mean_gap }, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ndarray::Array2;

    #[test]
    fn fields_of_another_size_give_no_numbers() {
        let scales = Scales { contact_modulus: 2.0, rms_gradient: 0.5 };
        let of = |displacement: [usize; 2], gap: [usize; 2]| {
            let pressure = Array2::from_elem((2, 3), 1.0);
            let [displacement, gap] = [displacement, gap].map(|shape| Array2::from_elem(shape, -0.5));
            Summary::of(pressure.view(), displacement.view(), gap.view(), 1.0, &scales, Boundary::Periodic)
        };
        let whole = of([2, 3], [2, 3]);
        assert_eq!((whole.elastic_energy, whole.mean_gap), (0.25, -0.5));
        assert_eq!((whole.at_wall().elastic_energy, whole.at_wall().mean_gap), (0.25, 0.0));
        assert!(of([2, 3], [2, 2]).at_wall().mean_gap.is_nan());
        let partly = Summary { area_fraction: 0.99, ..whole };
        assert_eq!(partly.at_wall(), partly);
        for other in [[2, 2], [2, 4], [0, 0]] {
            assert!(of(other, [2, 3]).elastic_energy.is_nan() && of([2, 3], other).mean_gap.is_nan(), "{other:?}");
        }
    }
}
