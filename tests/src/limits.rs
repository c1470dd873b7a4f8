//! Tables 3.1 to 3.3 of the source, as they should read: its matrix M is K/2 (theory.md, section 12).

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
            // Table 3.1, at q = 0 and near it: the entries approach the limit like q zm.
            for (worst, h) in [(&mut uniform, 0.0), (&mut long, 1e-7)] {
                let k = slab.stiffness([nx * h / HEIGHT, ny * h / HEIGHT]);
                for (i, row) in k.iter().enumerate() {
                    for (j, entry) in row.iter().enumerate() {
                        let wanted = if i == j { springs[i] } else { 0.0 };
                        worst.compare_to((entry - wanted).norm(), 0.0, springs[i.max(j)]);
                    }
                }
            }
            // Table 3.2: the difference from the limit falls like exp(−2 q zm).
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
    Ok(vec![
        uniform.check("table 3.1, q = 0: K = diag(C44, C44, C11)/zm", "table 3.1 x 2", 1e-15),
        long.check("table 3.1, q zm = 1e-7", "table 3.1 x 2", 1e-6),
        short.check("table 3.2, q zm = 40: half-space", "table 3.2 x 2", 1e-13),
        plane.check("table 3.3, qy = 0: closed form", "table 3.3 x 2, (r q zm)^2 for r^2 q zm^2", 1e-13),
        across.check("table 3.3, qy = 0: 3-D is 2-D", "identity", 1e-15),
    ])
}
