use gfmd_vector::{Share, contiguous};
use ndarray::ArrayView2;

use crate::Boundary;

/// Contact area of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactArea {
    /// Number of points with a pressure above zero.
    pub nodes: usize,
    /// Number of pairs of neighbours (along x and y) with exactly one point in contact. Points at opposite edges are
    /// neighbours only in a periodic field.
    pub boundary_links: usize,
    /// Fraction of points in contact.
    pub fraction: f64,
    /// Contact fraction corrected for the excess of whole pixels along the perimeter.
    ///
    /// Yastrebov et al. (2017): A = A_pixels − (π − 1 + ln 2)/24 · S a, with S the length of the pixel edges between
    /// contact and non-contact and a the spacing; for rectangular pixels S a is the sum of the pixel areas over the
    /// boundary links. The edge of a field that does not repeat is not part of S: a contact that reaches it ends there
    /// exactly. Never below zero. No correction is known for a line contact (one point along y), which has the value
    /// `fraction`.
    pub corrected_fraction: f64,
}

/// Measures the contact of a `[x, y]` pressure field (stress) with this boundary condition. Points with a pressure
/// above zero are in contact.
pub fn contact_area(pressure: ArrayView2<f64>, boundary: Boundary) -> ContactArea {
    let (rows, columns) = pressure.dim();
    contact_area_over(&Share::whole(rows, columns), columns, &contiguous(&pressure), boundary)
}

/// Measures the contact of a distributed pressure field: each process passes its rows of `columns` values.
pub(crate) fn contact_area_over(share: &Share, columns: usize, points: &[f64], boundary: Boundary) -> ContactArea {
    let rows = || points.chunks_exact(columns.max(1));
    let is_last = share.rows().end == share.all_rows().iter().map(|rows| rows.end).max().unwrap_or(0);
    let after = match (rows().next(), rows().last()) {
        (Some(first), Some(last)) => {
            let [_, after] = share.beside(first, last);
            // A row is not linked to itself.
            if is_last && boundary == Boundary::Free { last.to_vec() } else { after }
        }
        _ => Vec::new(),
    };
    let around = |row: &[f64]| match boundary {
        Boundary::Periodic => links(&row[..1], &row[columns - 1..]),
        Boundary::Free => 0,
    };
    let (mut nodes, mut boundary_links) = (0, 0);
    for (row, next) in rows().zip(rows().skip(1).chain([&after[..]])) {
        nodes += row.iter().map(|p| u64::from(*p > 0.0)).sum::<u64>();
        boundary_links += links(row, next) + links(&row[1..], row) + around(row);
    }
    let counts = share.each([nodes, boundary_links]);
    let [nodes, boundary_links] = [0, 1].map(|which| counts.iter().map(|counts| counts[which]).sum::<u64>());
    let all = share.total().max(1) as f64;
    let fraction = nodes as f64 / all;
    let excess = (std::f64::consts::PI - 1.0 + std::f64::consts::LN_2) / 24.0 * boundary_links as f64 / all;
    let corrected_fraction = if columns == 1 { fraction } else { (fraction - excess).max(0.0) };
    ContactArea { nodes: nodes as usize, boundary_links: boundary_links as usize, fraction, corrected_fraction }
}

/// Returns the number of pairs with exactly one point in contact, without branches.
fn links(here: &[f64], there: &[f64]) -> u64 {
    here.iter().zip(there).map(|(a, b)| u64::from((*a > 0.0) != (*b > 0.0))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Patches;
    use Boundary::{Free, Periodic};
    use ndarray::Array2;

    #[test]
    fn correction_of_a_disc_is_its_pixel_perimeter_times_the_stated_part_of_a_pixel() {
        let disc = |n: usize, radius: f64| {
            Array2::from_shape_fn((n, n), |(i, j)| {
                let [x, y] = [i, j].map(|k| (k as f64 + 0.5) / n as f64 - 0.5);
                f64::from(x.hypot(y) < radius)
            })
        };
        let n = 512;
        let area = contact_area(disc(n, 0.3).view(), Periodic);
        // The pixel perimeter of a disc is 8 r, not 2 π r.
        assert!((area.boundary_links as f64 / n as f64 - 8.0 * 0.3).abs() < 4.0 / n as f64);
        let ring = (std::f64::consts::PI - 1.0 + std::f64::consts::LN_2) / 24.0 / n as f64;
        approx::assert_relative_eq!(area.fraction - area.corrected_fraction, ring * 2.4, max_relative = 1e-2);
    }

    #[test]
    fn full_and_empty_contact_have_no_boundary() {
        for value in [0.0, 1.0] {
            let area = contact_area(Array2::from_elem((5, 7), value).view(), Periodic);
            assert_eq!((area.boundary_links, area.corrected_fraction, area.fraction), (0, value, value));
        }
    }

    #[test]
    fn a_transposed_field_has_the_same_contact() {
        let field = Array2::from_shape_fn((5, 7), |(i, j)| (0.9 * i as f64 + 0.4 * (j * j) as f64).sin());
        let copied = Array2::from_shape_fn((7, 5), |(j, i)| field[[i, j]]);
        assert_eq!(contact_area(field.t(), Periodic), contact_area(copied.view(), Periodic));
        assert_eq!(
            contact_area(field.t(), Periodic).boundary_links,
            contact_area(field.view(), Periodic).boundary_links
        );
        assert_eq!(
            contact_area(Array2::zeros((0, 3)).view(), Periodic).nodes
                + contact_area(Array2::zeros((3, 0)).view(), Periodic).nodes,
            0
        );
    }

    #[test]
    fn links_wrap_around() {
        let mut p = Array2::zeros((4, 6));
        p[[0, 0]] = 1.0;
        assert_eq!(contact_area(p.view(), Periodic).boundary_links, 4);
        p[[3, 0]] = 1.0;
        assert_eq!(contact_area(p.view(), Periodic).boundary_links, 6);
    }

    #[test]
    fn no_link_crosses_the_seam_of_a_field_that_ends_and_patches_have_the_same_links() {
        let mut random = 1_u64;
        for (rows, columns) in [(7, 9), (1, 6), (6, 1), (2, 2), (12, 5)] {
            let p = Array2::from_shape_fn((rows, columns), |_| {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                f64::from(random >> 62 != 0)
            });
            let differ = |a: [usize; 2], b: [usize; 2]| u64::from((p[a] > 0.0) != (p[b] > 0.0));
            let (mut inside, mut seam) = (0, 0);
            for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
                for ([a, b], ends) in [([i + 1, j], i + 1 == rows), ([i, j + 1], j + 1 == columns)] {
                    let links = differ([i, j], [a % rows, b % columns]);
                    if ends { seam += links } else { inside += links }
                }
            }
            let links = |boundary| contact_area(p.view(), boundary).boundary_links as u64;
            assert_eq!((links(Free), links(Periodic)), (inside, inside + seam));
            for boundary in [Free, Periodic] {
                let patches = Patches::of(p.mapv(|p| p > 0.0).view(), boundary).patches;
                let of_patches = patches.iter().map(|patch| patch.links.iter().sum::<u64>()).sum::<u64>();
                // On a periodic axis of two points, the two neighbours are linked twice.
                assert_eq!(of_patches, links(boundary), "{rows} x {columns}, {boundary:?}");
            }
        }
    }

    #[test]
    fn a_line_contact_is_not_corrected() {
        let mut p = Array2::zeros((8, 1));
        p[[2, 0]] = 1.0;
        let area = contact_area(p.view(), Periodic);
        assert_eq!((area.boundary_links, area.corrected_fraction), (2, 0.125));
    }
}
