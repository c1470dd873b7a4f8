//! Cells of a pack of wave vectors as a chain of springs: finite elements with the strain at mid-depth, coupled by the
//! displacements of the nodes between them.
//!
//! In the frame of a wave vector (long, across, z) the matrices are real for U = −i u_long, T = u_across, V = u_z and
//! the tractions alike. Amplitudes are complex, so that real and imaginary parts are two independent problems. With the
//! means m and half differences d of top and bottom of a cell of thickness h, its strain is ε_LL = −q m_U,
//! ε_zz = 2 d_V/h, −i γ_Lz = 2 d_U/h + q m_V, γ_Tz = 2 d_T/h and −i γ_LT = q m_T.
//!
//! Strains and plastic strains are deviatoric, in the orthonormal basis (√(3/2) ε_zz, (ε_xx − ε_yy)/√2, √2 ε_xy,
//! √2 ε_xz, √2 ε_yz).

use multiversion::multiversion;

use crate::cells::Cell;
use crate::pack::Pack;

/// Components of a deviatoric strain, each with its real and its imaginary part.
pub(crate) type Strain = [[Pack; 2]; 5];

/// Wave vectors of a pack: lengths and directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Waves {
    pub(crate) wavenumber: Pack,
    pub(crate) direction: [Pack; 2],
}

/// Stiffness of what lies below a node: entries LL, Lz (real form), zz and TT.
pub(crate) type Support = [Pack; 4];

/// Memory of one pack: one entry per cell.
#[derive(Clone, Debug)]
pub(crate) struct Memory {
    /// Plastic strain.
    pub(crate) plastic: Vec<Strain>,
    /// Strain.
    pub(crate) strain: Vec<Strain>,
    /// Displacement of the bottom of a cell at rest of its top, and the inverse that gives it.
    chain: Vec<Link>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Link {
    /// Real and imaginary parts of U, V, T.
    rest: [[Pack; 3]; 2],
    inverse: [Pack; 4],
}

/// Factors of the deviatoric basis.
const HALF: f64 = std::f64::consts::FRAC_1_SQRT_2;
const ZZ: f64 = 0.816_496_580_927_726;
const LL: f64 = 0.408_248_290_463_863;

impl Memory {
    pub(crate) fn new(cells: usize) -> Self {
        let zero = [[Pack::ZERO; 2]; 5];
        Self { plastic: vec![zero; cells], strain: vec![zero; cells], chain: vec![Link::default(); cells] }
    }
}

/// Stiffness of a cell between its two nodes.
#[derive(Clone, Copy)]
struct Element {
    /// Entries of the top node; the bottom node has the other sign of `mixed`.
    long: Pack,
    mixed: Pack,
    normal: Pack,
    across: Pack,
    /// Entries between top and bottom: LL, Lz = −zL, zz, TT.
    through: [Pack; 4],
}

impl Element {
    #[inline(always)]
    fn new(cell: &Cell, q: Pack) -> Self {
        let (shear, wave, h) = (cell.shear_modulus, cell.p_wave_modulus, cell.thickness);
        let lame = wave - 2.0 * shear;
        let squares = q * q * (0.25 * h);
        let (stretch, bend) = (squares * wave, squares * shear);
        let (slide, press) = (Pack::all(shear / h), Pack::all(wave / h));
        Self {
            long: stretch + slide,
            mixed: q * (0.5 * (shear - lame)),
            normal: press + bend,
            across: slide + bend,
            through: [stretch - slide, q * (0.5 * (shear + lame)), bend - press, bend - slide],
        }
    }

    /// Returns the inverse of the stiffness of the bottom node, with the support below it.
    #[inline(always)]
    fn inverse(&self, support: &Support) -> Support {
        let [ll, lz, zz] = [self.long + support[0], support[1] - self.mixed, self.normal + support[2]];
        let factor = (ll * zz - lz * lz).inverse();
        [zz * factor, -(lz * factor), ll * factor, (self.across + support[3]).inverse()]
    }

    /// Returns the stiffness at the top node, with the support below the bottom node.
    #[inline(always)]
    fn reduce(&self, [ll, lz, zz, tt]: &Support) -> Support {
        let [p, x, z, t] = self.through;
        let (a, b) = (p * *ll + x * *lz, p * *lz + x * *zz);
        let (c, d) = (z * *lz - x * *ll, z * *zz - x * *lz);
        [
            self.long - (a * p + b * x),
            self.mixed - (b * z - a * x),
            self.normal - (d * z - c * x),
            self.across - t * *tt * t,
        ]
    }
}

/// Returns the stiffness at the surface of cells on a support, without plastic strain.
#[multiversion(targets = "simd")]
pub(crate) fn stiffness(cells: &[Cell], wavenumber: Pack, support: &Support) -> Support {
    let mut support = *support;
    for cell in cells.iter().rev() {
        let element = Element::new(cell, wavenumber);
        support = element.reduce(&element.inverse(&support));
    }
    support
}

/// Solves the chain from below, and keeps what [`down`] needs. Returns the nodal force on the surface, real and
/// imaginary part, and the stiffness of the surface.
#[multiversion(targets = "simd")]
pub(crate) fn up(cells: &[Cell], waves: &Waves, support: &Support, memory: &mut Memory) -> ([[Pack; 3]; 2], Support) {
    let Waves { wavenumber: q, direction: [nx, ny] } = *waves;
    let (double, twice) = (nx * nx - ny * ny, nx * ny * 2.0);
    let mut support = *support;
    let mut force = [[Pack::ZERO; 3]; 2];
    let all = cells.iter().zip(&memory.plastic).zip(&mut memory.chain);
    for ((cell, plastic), link) in all.rev() {
        let element = Element::new(cell, q);
        let inverse = element.inverse(&support);
        // Eigenstress 2μ ε^p in the frame of the wave vector, in the real form: −i τ is (Im τ, −Re τ).
        let stress = 2.0 * cell.shear_modulus;
        let turned = plastic.map(|[re, im]| [re * stress, im * stress]);
        let half = q * (0.5 * cell.thickness);
        for part in 0..2 {
            let [zz, b2, b3, b4, b5] = turned.map(|component| component[part]);
            let other = |component: usize| {
                let value = turned[component][1 - part];
                if part == 0 { value } else { -value }
            };
            let long = (double * b2 + twice * b3) * HALF - zz * LL;
            let normal = zz * ZZ;
            let across_z = (nx * b5 - ny * b4) * HALF;
            let long_z = (nx * other(3) + ny * other(4)) * HALF;
            let long_across = (double * other(2) - twice * other(1)) * HALF;
            let pulls = [half * long_z, half * long_across];
            let top = [long_z - half * long, normal + pulls[0], across_z + pulls[1]];
            let bottom = [-long_z - half * long, pulls[0] - normal, pulls[1] - across_z];
            let [u, v, t] = [0, 1, 2].map(|k| force[part][k] + bottom[k]);
            let rest = [inverse[0] * u + inverse[1] * v, inverse[1] * u + inverse[2] * v, inverse[3] * t];
            let [p, x, z, s] = element.through;
            force[part] =
                [top[0] - (p * rest[0] + x * rest[1]), top[1] - (z * rest[1] - x * rest[0]), top[2] - s * rest[2]];
            link.rest[part] = rest;
        }
        link.inverse = inverse;
        support = element.reduce(&inverse);
    }
    (force, support)
}

/// Returns the displacement (U, V, T) of the surface under nodal forces and a normal traction.
#[inline(always)]
fn surface(force: &[Pack; 3], traction: Pack, support: &Support) -> [Pack; 3] {
    let [ll, lz, zz, tt] = *support;
    let factor = (ll * zz - lz * lz).inverse();
    let (u, v) = (force[0], force[1] + traction);
    [(zz * u - lz * v) * factor, (ll * v - lz * u) * factor, force[2] * tt.inverse()]
}

/// Returns the normal displacement of the surface under the forces of [`up`], without traction: real and imaginary
/// part.
#[inline(always)]
pub(crate) fn normal_displacement(force: &[[Pack; 3]; 2], support: &Support) -> [Pack; 2] {
    [0, 1].map(|part| surface(&force[part], Pack::ZERO, support)[1])
}

/// Solves the chain from above, under a normal traction on the surface: adds `share` times the deviatoric strain of
/// each cell to the strain in the memory, and returns the displacement (U, V, T) of the lowest node. `forces` come from
/// [`up`].
#[multiversion(targets = "simd")]
pub(crate) fn down(
    cells: &[Cell],
    waves: &Waves,
    forces: &([[Pack; 3]; 2], Support),
    traction: &[Pack; 2],
    share: &Pack,
    memory: &mut Memory,
) -> [[Pack; 3]; 2] {
    let Waves { wavenumber: q, direction: [nx, ny] } = *waves;
    let (double, twice) = (nx * nx - ny * ny, nx * ny * 2.0);
    let (force, support) = forces;
    let mut tops = [0, 1].map(|part| surface(&force[part], traction[part], support));
    for ((cell, link), strain) in cells.iter().zip(&memory.chain).zip(&mut memory.strain) {
        let [p, x, z, s] = Element::new(cell, q).through;
        let over = 1.0 / cell.thickness;
        let mut frame = [[Pack::ZERO; 5]; 2];
        for part in 0..2 {
            let top = tops[part];
            let (fu, fv, ft) = (p * top[0] - x * top[1], x * top[0] + z * top[1], s * top[2]);
            let [i0, i1, i2, i3] = link.inverse;
            let bottom = [
                link.rest[part][0] - (i0 * fu + i1 * fv),
                link.rest[part][1] - (i1 * fu + i2 * fv),
                link.rest[part][2] - i3 * ft,
            ];
            let mean = [0, 1, 2].map(|k| (top[k] + bottom[k]) * 0.5);
            let slope = [0, 1, 2].map(|k| (top[k] - bottom[k]) * over);
            // ε_LL, ε_zz, γ_Tz, and −i γ_Lz, −i γ_LT.
            frame[part] = [-(q * mean[0]), slope[1], slope[2], slope[0] + q * mean[1], q * mean[2]];
            tops[part] = bottom;
        }
        for part in 0..2 {
            let [long, normal, across_z, ..] = frame[part];
            // γ = i (−i γ).
            let turned = |k: usize| if part == 0 { -frame[1][k] } else { frame[0][k] };
            let (long_z, long_across) = (turned(3) * HALF, turned(4) * HALF);
            let (e2, across_z) = (long * HALF, across_z * HALF);
            let components = [
                normal * ZZ - long * LL,
                double * e2 - twice * long_across,
                twice * e2 + double * long_across,
                nx * long_z - ny * across_z,
                ny * long_z + nx * across_z,
            ];
            for (strain, component) in strain.iter_mut().zip(components) {
                strain[part] += component * *share;
            }
        }
    }
    tops
}

/// Returns the sums of the squares of the unbalanced forces on the nodes and of all forces on them, each from the cell
/// above, the cell below, the traction on the surface and the support. The forces follow from the strain and the
/// plastic strain in the memory, not from the chain. `weights` are factors on the squares; `lowest` is the displacement
/// of the lowest node.
#[multiversion(targets = "simd")]
pub(crate) fn balance(
    cells: &[Cell],
    waves: &Waves,
    support: &Support,
    traction: &[Pack; 2],
    lowest: &[[Pack; 3]; 2],
    weights: &Pack,
    memory: &Memory,
) -> [f64; 2] {
    let Waves { wavenumber: q, direction: [nx, ny] } = *waves;
    let (double, twice) = (nx * nx - ny * ny, nx * ny * 2.0);
    let mut sums = [Pack::ZERO; 2];
    let mut add = |left: Pack, right: Pack| {
        let rest = left + right;
        sums[0] += rest * rest;
        sums[1] += left * left + right * right;
    };
    for part in 0..2 {
        // Force on the node between two cells, from the cell above it.
        let mut above = [Pack::ZERO, -traction[part], Pack::ZERO];
        for ((cell, plastic), strain) in cells.iter().zip(&memory.plastic).zip(&memory.strain) {
            // In the frame of the wave vector, where the strain across it vanishes.
            let frame = |of: &Strain| {
                let [zz, b2, b3, ..] = of.map(|component| component[part]);
                let other = |k: usize| if part == 0 { of[k][1] } else { -of[k][0] };
                let long = (double * b2 + twice * b3) * HALF;
                let across_z = (nx * of[4][part] - ny * of[3][part]) * HALF;
                let long_z = (nx * other(3) + ny * other(4)) * HALF;
                let long_across = (double * other(2) - twice * other(1)) * HALF;
                [zz, long, across_z, long_z, long_across]
            };
            let (total, plastic) = (frame(strain), frame(plastic));
            // ε_LL is √2 e₂ = 2 (e₂/√2); ε_zz follows from it and the first component.
            let long = total[1] * 2.0;
            let normal = (total[0] + long * LL) * (1.0 / ZZ);
            let [shear, lame] = [cell.shear_modulus, cell.p_wave_modulus - 2.0 * cell.shear_modulus];
            let volume = (long + normal) * lame;
            let stress_ll = volume + (long - (plastic[1] - plastic[0] * LL)) * (2.0 * shear);
            let stress_zz = volume + (normal - plastic[0] * ZZ) * (2.0 * shear);
            let [across_z, long_z, long_across] = [2, 3, 4].map(|k| (total[k] - plastic[k]) * (2.0 * shear));
            let half = q * (0.5 * cell.thickness);
            let pulls = [half * long_z, half * long_across];
            let top = [long_z - half * stress_ll, stress_zz + pulls[0], across_z + pulls[1]];
            above.iter().zip(top).for_each(|(above, top)| add(*above, top));
            above = [-long_z - half * stress_ll, pulls[0] - stress_zz, pulls[1] - across_z];
        }
        let [ll, lz, zz, tt] = *support;
        let [u, v, t] = lowest[part];
        let below = [ll * u + lz * v, lz * u + zz * v, tt * t];
        above.iter().zip(below).for_each(|(above, below)| add(*above, below));
    }
    sums.map(|sum| (sum * *weights).0.iter().sum())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_balance_and_a_changed_strain_unbalances_them() {
        let cell = |thickness: f64| Cell {
            depth: 0.0,
            thickness,
            coarsening: 1,
            shear_modulus: 1.0,
            p_wave_modulus: 3.0,
            hardening: None,
        };
        let cells = [cell(0.1), cell(0.2), cell(0.15)];
        let pack = |seed: f64| Pack(std::array::from_fn(|k| (seed * (k + 1) as f64).sin()));
        let direction = [Pack(pack(1.0).0.map(f64::cos)), Pack(pack(1.0).0.map(f64::sin))];
        let waves = Waves { wavenumber: Pack(std::array::from_fn(|k| 1.0 + k as f64)), direction };
        let support = [1.7, 0.3, 2.0, 0.9].map(Pack::all);
        let mut memory = Memory::new(cells.len());
        for (number, plastic) in memory.plastic.iter_mut().enumerate() {
            for (component, value) in plastic.iter_mut().enumerate() {
                *value = [0, 1].map(|part| pack((1 + part + 2 * component + 10 * number) as f64));
            }
        }
        let traction = [pack(0.3), pack(0.7)];
        let forces = up(&cells, &waves, &support, &mut memory);
        let lowest = down(&cells, &waves, &forces, &traction, &Pack::all(1.0), &mut memory);
        let unbalanced = |memory: &Memory, traction: &[Pack; 2]| {
            let [rest, all] = balance(&cells, &waves, &support, traction, &lowest, &Pack::all(1.0), memory);
            (rest / all).sqrt()
        };
        let found = unbalanced(&memory, &traction);
        assert!(found < 1e-14, "{found}");
        let found = unbalanced(&memory, &[pack(0.3), pack(0.7) * 1.001]);
        assert!((1e-5..1e-2).contains(&found), "{found}");
        for cell in 0..cells.len() {
            for component in 0..5 {
                let mut changed = memory.clone();
                changed.strain[cell][component][0] += Pack::all(1e-3);
                let found = unbalanced(&changed, &traction);
                assert!((1e-5..1e-2).contains(&found), "{cell} {component} {found}");
            }
        }
    }
}
