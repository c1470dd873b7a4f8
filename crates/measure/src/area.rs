use ndarray::{ArrayView1, ArrayView2, s};

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
    let (nx, ny) = pressure.dim();
    let (mut nodes, mut boundary_links) = (0, 0);
    let rows = if ny == 0 { 0 } else { nx };
    for i in 0..rows {
        let (row, next) = (pressure.row(i), pressure.row((i + 1) % nx));
        nodes += row.iter().filter(|p| **p > 0.0).count();
        boundary_links += links(row, next) + links(row.slice(s![1..]), row.slice(s![..-1]));
        boundary_links += usize::from((row[0] > 0.0) != (row[ny - 1] > 0.0));
    }
    let all = pressure.len().max(1) as f64;
    let fraction = nodes as f64 / all;
    let excess = (std::f64::consts::PI - 1.0 + std::f64::consts::LN_2) / 24.0 * boundary_links as f64 / all;
    let corrected_fraction = if ny == 1 { fraction } else { (fraction - excess).max(0.0) };
    ContactArea { nodes, boundary_links, fraction, corrected_fraction }
}

/// The number of pairs of which exactly one is in contact.
fn links(here: ArrayView1<f64>, there: ArrayView1<f64>) -> usize {
    here.iter().zip(there).filter(|(a, b)| (**a > 0.0) != (**b > 0.0)).count()
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
