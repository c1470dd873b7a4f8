//! Tables 3.1 to 3.3 of the thesis, corrected, and eq. 3.18 as printed: its matrix M is K/2 (docs/source/coverage.md).

use gfmd_green::{Body, Material};

use crate::check::Worst;
use crate::{Check, Reference, ValidationError};

const HEIGHT: f64 = 0.7;

/// Directions of wave vectors.
const DIRECTIONS: [[f64; 2]; 4] = [[1.0, 0.0], [0.0, 1.0], [0.6, 0.8], [-0.8, 0.6]];

pub(crate) fn checks(_: &Reference) -> Result<Vec<Check>, ValidationError> {
    let materials = [-0.3, 0.0, 0.25, 0.33, 0.45].map(|poisson| Material::from_young(70.0, poisson));
    let [mut uniform, mut long, mut short, mut plane, mut across] = [Worst::new(); 5];
    for material in materials {
        let material = material?;
        let slab = Body::slab(material, HEIGHT)?;
        let (shear, s, r) = (material.shear_modulus(), material.s(), material.r());
        let springs = [shear, shear, shear / s].map(|modulus| modulus / HEIGHT);
        for [nx, ny] in DIRECTIONS {
            // Table 3.1, at q = 0 and near it: the entries approach the limit as q zm.
            for (worst, h) in [(&mut uniform, 0.0), (&mut long, 1e-7)] {
                let k = slab.stiffness([nx * h / HEIGHT, ny * h / HEIGHT]);
                for (i, row) in k.iter().enumerate() {
                    for (j, entry) in row.iter().enumerate() {
                        let wanted = if i == j { springs[i] } else { 0.0 };
                        worst.compare_to((entry - wanted).norm(), 0.0, springs[i.max(j)]);
                    }
                }
            }
            // Table 3.2: the difference from the limit falls as exp(−2 q zm).
            let q = 40.0 / HEIGHT;
            let (k, unit) = (slab.stiffness([nx * q, ny * q]), shear * q / (1.0 + s));
            for (found, wanted) in [
                (k[0][0].re, ny * ny * (1.0 + s) + 2.0 * nx * nx),
                (k[0][1].re, nx * ny * (1.0 - s)),
                (k[0][2].im, 2.0 * s * nx),
                (k[1][1].re, nx * nx * (1.0 + s) + 2.0 * ny * ny),
                (k[1][2].im, 2.0 * s * ny),
                (k[2][2].re, 2.0),
            ] {
                short.compare_to(found, unit * wanted, unit);
            }
        }
        // Table 3.3: one wave vector component is zero.
        for h in [1.0, 2.0, 4.0_f64] {
            let (q, sinh, cosh) = (h / HEIGHT, h.sinh(), h.cosh());
            let (k, alone) = (slab.stiffness([q, 0.0]), slab.plane_stiffness(q));
            let unit = shear / s * q * (1.0 - r) / (cosh * cosh - 1.0 - (r * h).powi(2));
            let coupling = ((1.0 - r) * sinh * sinh - 2.0 * (r * h).powi(2)) / (1.0 + r);
            let wanted = [unit * (sinh * cosh - r * h), unit * coupling, unit * (sinh * cosh + r * h)];
            for (found, wanted) in [k[0][0].re, k[0][2].im, k[2][2].re].into_iter().zip(wanted) {
                plane.compare_to(found, wanted, unit * sinh * cosh);
            }
            plane.compare(k[1][1].re, shear * q * cosh / sinh);
            for (found, wanted) in [(k[0][0], alone[0][0]), (k[0][2], alone[0][1]), (k[2][2], alone[1][1])] {
                across.compare_to((found - wanted).norm(), 0.0, wanted.norm());
            }
            for zero in [k[0][1], k[1][2]] {
                across.compare_to(zero.norm(), 0.0, unit);
            }
        }
    }
    let [diagonal, others, coupling, repaired] = printed_matrix()?;
    Ok(vec![
        diagonal.check("eq. 3.18 as printed, Mxx and Myy: 4 K, which is 8 M", "E7", 1e-12),
        others.check("eq. 3.18 as printed, Mxy and Mzz: K/2", "closed form", 1e-12),
        coupling.check("eq. 3.18, Mxz and Myz, its factor -2iq on both fractions: K/2", "E8", 1e-12),
        repaired.check("eq. 3.18 multiplied out for K", "closed form of theory.md, section 2", 1e-12),
        uniform.check("table 3.1, q = 0: K = diag(C44, C44, C11)/zm", "table 3.1 x 2", 1e-15),
        long.check("table 3.1, q zm = 1e-7", "table 3.1 x 2", 1e-6),
        short.check("table 3.2, q zm = 40: half-space", "table 3.2 x 2", 1e-13),
        plane.check("table 3.3, qy = 0: closed form", "table 3.3 x 2, (r q zm)^2 for r^2 q zm^2", 1e-13),
        across.check("table 3.3, qy = 0: 3-D is 2-D", "identity", 1e-15),
    ])
}

/// Compares the formulas of eq. 3.18 as printed, in the variables of the thesis, with K times the factors by which they
/// differ, and the formulas of theory.md, section 2, with K.
fn printed_matrix() -> Result<[Worst; 4], ValidationError> {
    let [mut diagonal, mut others, mut coupling, mut repaired] = [Worst::new(); 4];
    for poisson in [-0.3, 0.0, 0.25, 0.33, 0.45] {
        let material = Material::from_young(70.0, poisson)?;
        let slab = Body::slab(material, HEIGHT)?;
        let (c44, s) = (material.shear_modulus(), material.s());
        let (c11, zm) = (c44 / s, HEIGHT);
        let c12 = c11 - 2.0 * c44;
        for [nx, ny] in DIRECTIONS.into_iter().chain([[0.28, -0.96]]) {
            for h in [0.5, 1.0, 2.0, 5.0_f64] {
                let qr = h / zm;
                let (qx, qy) = (nx * qr, ny * qr);
                let (sinh, sinh_2, coth) = (h.sinh(), (2.0 * h).sinh(), 1.0 / h.tanh());
                let d = (s + 1.0).powi(2) * sinh.powi(2) - (qr * (s - 1.0) * zm).powi(2);
                let slope = qr * (s - 1.0) * zm * coth;
                let in_plane = (qx * qx + qy * qy) * d;
                let bracket = 2.0 * (s + 1.0).powi(2) * sinh.powi(2) - 2.0 * (qy * (s - 1.0) * zm).powi(2);
                let m_xx = 2.0 * c44 * (4.0 * qx.powi(4) * (s - 1.0) * zm + qr * qy * qy * coth * bracket) / in_plane
                    + 4.0 * c44 * qx * qx * (qr * (s + 1.0) * sinh_2 - qy * qy * (s - 1.0) * zm * (slope - 2.0))
                        / in_plane;
                let m_xy = 2.0 * c44 * qx * qy * (1.0 - s) * (2.0 * qr * zm * (slope + 2.0) - (s + 1.0) * sinh_2)
                    / (8.0 * qr * -d);
                let first = (c11 - c12 + 2.0 * c44) * (qr * (s - 1.0) * zm).powi(2) / (8.0 * d);
                let second = (s + 1.0) * (c11 * (s - 1.0) + c12 * (s + 1.0) - 2.0 * c44 * s) * sinh.powi(2) / (8.0 * d);
                let inner = 2.0 * qy * qy * (s - 1.0) * zm + qr * (s + 1.0) * sinh_2;
                let m_yy =
                    -2.0 * c44 * (2.0 * qx.powi(4) * qr * ((s - 1.0) * zm).powi(2) * coth - 2.0 * qy * qy * inner)
                        / in_plane
                        - 2.0
                            * c44
                            * qx
                            * qx
                            * (2.0 * qy * qy * (s - 1.0) * zm * (slope - 2.0) - qr * (s + 1.0).powi(2) * sinh_2)
                            / in_plane;
                let m_zz = -c11 * (8.0 * qr * qr * (s - 1.0) * s * zm - 4.0 * qr * s * (s + 1.0) * sinh_2) / (8.0 * d);
                let k = slab.stiffness([qx, qy]);
                let scale = k[2][2].re;
                diagonal.compare_to(m_xx / 4.0, k[0][0].re, scale);
                diagonal.compare_to(m_yy / 4.0, k[1][1].re, scale);
                others.compare_to(2.0 * m_xy, k[0][1].re, scale);
                others.compare_to(2.0 * m_zz, k[2][2].re, scale);
                coupling.compare_to(-4.0 * qx * (first + second), k[0][2].im, scale);
                coupling.compare_to(-4.0 * qy * (first + second), k[1][2].im, scale);

                let along = qr * ((1.0 + s) * sinh_2 + 2.0 * (s - 1.0) * h) / d;
                let (across, unit) = (qr * coth, c44 / (qr * qr));
                let cross = (1.0 + s) * sinh_2 - 4.0 * h + 2.0 * (1.0 - s) * h * h * coth;
                let normal = c44 * qr * ((1.0 + s) * sinh_2 - 2.0 * (s - 1.0) * h) / d;
                let half = c44 * (s * (1.0 + s) * sinh.powi(2) - (1.0 - s).powi(2) * h * h) / d;
                repaired.compare_to(unit * (qx * qx * along + qy * qy * across), k[0][0].re, scale);
                repaired.compare_to(unit * (qy * qy * along + qx * qx * across), k[1][1].re, scale);
                repaired.compare_to(c44 * qx * qy * (1.0 - s) * cross / (2.0 * qr * d), k[0][1].re, scale);
                repaired.compare_to(normal, k[2][2].re, scale);
                repaired.compare_to(2.0 * qx * half, k[0][2].im, scale);
                repaired.compare_to(2.0 * qy * half, k[1][2].im, scale);
            }
        }
    }
    Ok([diagonal, others, coupling, repaired])
}
