use gfmd_vector::Share;
use ndarray::ArrayView2;

/// The part of the surface in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactArea {
    /// The number of points with a pressure above zero.
    pub nodes: usize,
    /// The number of pairs of neighbours (along x and y, periodic) of which exactly one is in contact.
    pub boundary_links: usize,
    /// The fraction of points in contact.
    pub fraction: f64,
    /// The fraction without the excess that counting whole pixels adds along the perimeter.
    ///
    /// Yastrebov et al. (2017): A = A_pixels − (π − 1 + ln 2)/24 · S a, with S the length of the pixel edges between
    /// contact and non-contact and a the spacing; for rectangular pixels S a is the sum of the pixel areas over the
    /// boundary links. Never below zero. No correction is known for a line contact (one point along y), where it equals
    /// `fraction`.
    pub corrected_fraction: f64,
}

/// Counts the contact of a `[x, y]` pressure field.
pub fn contact_area(pressure: ArrayView2<f64>) -> ContactArea {
    let (rows, columns) = pressure.dim();
    let pressure = pressure.as_standard_layout();
    contact_area_over(&Share::whole(rows, columns), columns, pressure.as_slice().unwrap_or_default())
}

/// Counts the contact of a pressure field of which each process has its rows of so many `columns`.
pub(crate) fn contact_area_over(share: &Share, columns: usize, points: &[f64]) -> ContactArea {
    let rows = || points.chunks_exact(columns.max(1));
    let after = match (rows().next(), rows().last()) {
        (Some(first), Some(last)) => {
            let [_, after] = share.beside(first, last);
            after
        }
        _ => Vec::new(),
    };
    let (mut nodes, mut boundary_links) = (0, 0);
    for (row, next) in rows().zip(rows().skip(1).chain([&after[..]])) {
        nodes += row.iter().map(|p| u64::from(*p > 0.0)).sum::<u64>();
        boundary_links += links(row, next) + links(&row[1..], row) + links(&row[..1], &row[columns - 1..]);
    }
    let counts = share.each([nodes, boundary_links]);
    let [nodes, boundary_links] = [0, 1].map(|which| counts.iter().map(|counts| counts[which]).sum::<u64>());
    let all = share.total().max(1) as f64;
    let fraction = nodes as f64 / all;
    let excess = (std::f64::consts::PI - 1.0 + std::f64::consts::LN_2) / 24.0 * boundary_links as f64 / all;
    let corrected_fraction = if columns == 1 { fraction } else { (fraction - excess).max(0.0) };
    ContactArea { nodes: nodes as usize, boundary_links: boundary_links as usize, fraction, corrected_fraction }
}

/// The number of pairs of which exactly one is in contact, without branches.
fn links(here: &[f64], there: &[f64]) -> u64 {
    here.iter().zip(there).map(|(a, b)| u64::from((*a > 0.0) != (*b > 0.0))).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
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
        let area = contact_area(disc(n, 0.3).view());
        // The pixel perimeter of a disc is 8 r, not 2 π r.
        assert!((area.boundary_links as f64 / n as f64 - 8.0 * 0.3).abs() < 4.0 / n as f64);
        let ring = (std::f64::consts::PI - 1.0 + std::f64::consts::LN_2) / 24.0 / n as f64;
        approx::assert_relative_eq!(area.fraction - area.corrected_fraction, ring * 2.4, max_relative = 1e-2);
    }

    #[test]
    fn full_and_empty_contact_have_no_boundary() {
        for value in [0.0, 1.0] {
            let area = contact_area(Array2::from_elem((5, 7), value).view());
            assert_eq!((area.boundary_links, area.corrected_fraction, area.fraction), (0, value, value));
        }
    }

    #[test]
    fn a_transposed_field_has_the_same_contact() {
        let field = Array2::from_shape_fn((5, 7), |(i, j)| (0.9 * i as f64 + 0.4 * (j * j) as f64).sin());
        let copied = Array2::from_shape_fn((7, 5), |(j, i)| field[[i, j]]);
        assert_eq!(contact_area(field.t()), contact_area(copied.view()));
        assert_eq!(contact_area(field.t()).boundary_links, contact_area(field.view()).boundary_links);
        assert_eq!(
            contact_area(Array2::zeros((0, 3)).view()).nodes + contact_area(Array2::zeros((3, 0)).view()).nodes,
            0
        );
    }

    #[test]
    fn links_wrap_around() {
        let mut p = Array2::zeros((4, 6));
        p[[0, 0]] = 1.0;
        assert_eq!(contact_area(p.view()).boundary_links, 4);
        p[[3, 0]] = 1.0;
        assert_eq!(contact_area(p.view()).boundary_links, 6);
    }

    #[test]
    fn a_line_contact_is_not_corrected() {
        let mut p = Array2::zeros((8, 1));
        p[[2, 0]] = 1.0;
        let area = contact_area(p.view());
        assert_eq!((area.boundary_links, area.corrected_fraction), (2, 0.125));
    }
}
