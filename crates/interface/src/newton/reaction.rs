use gfmd_law::{Law, Opening};
use gfmd_vector::for_each;

use crate::frame::Frame;

/// Traction of the law and its Jacobian J = −∂T/∂w at every point. J is symmetric if there is an energy, so that only
/// its upper triangle is stored.
pub(crate) struct Reaction {
    components: usize,
    points: usize,
    /// Traction component by component, then J column by column: xx; xy, yy; xz, yz, zz.
    tables: Vec<f64>,
}

impl Reaction {
    pub(crate) fn new(components: usize, points: usize) -> Self {
        let tables = components + components * (components + 1) / 2;
        Self { components, points, tables: vec![0.0; tables * points] }
    }

    /// Computes the traction, the Jacobian and the energy of `law` at `position`.
    pub(crate) fn update(&mut self, law: &dyn Law, frame: &Frame, position: &[f64], energy: &mut [f64]) {
        let both = |i: usize| {
            let (normal, sliding) = frame.separation(position, i);
            let energy = law.energy(normal, sliding[0].hypot(sliding[1])).unwrap_or(f64::NAN);
            (law.traction(normal, sliding), law.jacobian(normal, sliding), energy)
        };
        match self.components {
            1 => self.fill(energy, |i| {
                let Opening { energy, traction, slope } = law.opening(frame.separation(position, i).0);
                (energy, [traction, slope])
            }),
            2 => self.fill(energy, |i| {
                let ([x, _, z], j, energy) = both(i);
                (energy, [x, z, j.tt[0][0], j.nt[0], j.nn])
            }),
            _ => self.fill(energy, |i| {
                let ([x, y, z], j, energy) = both(i);
                (energy, [x, y, z, j.tt[0][0], j.tt[0][1], j.tt[1][1], j.nt[0], j.nt[1], j.nn])
            }),
        }
    }

    /// Fills traction, Jacobian and energy of the single component with the values `of` each point.
    pub(crate) fn update_normal(&mut self, energy: &mut [f64], of: impl Fn(usize) -> Opening + Sync) {
        self.fill(energy, |i| {
            let Opening { energy, traction, slope } = of(i);
            (energy, [traction, slope])
        });
    }

    /// Sets the entry zz of J to the slope `of` each point, of a law without shear; leaves the rest as it is.
    pub(crate) fn set_normal_slope(&mut self, of: impl Fn(usize) -> f64 + Sync) {
        for_each([self.normal_slope_mut()], &|start, [slopes]| {
            slopes.iter_mut().enumerate().for_each(|(k, slope)| *slope = of(start + k));
        });
    }

    /// Returns the entry zz of J, to be changed.
    pub(crate) fn normal_slope_mut(&mut self) -> &mut [f64] {
        let last = self.tables.len() - self.points;
        &mut self.tables[last..]
    }

    /// Returns traction and Jacobian of the single component, to be changed.
    pub(crate) fn normal_mut(&mut self) -> [&mut [f64]; 2] {
        split(&mut self.tables, self.points)
    }

    fn fill<const TABLES: usize>(
        &mut self,
        energies: &mut [f64],
        values: impl Fn(usize) -> (f64, [f64; TABLES]) + Sync,
    ) {
        let leaf = |start: usize, (energies, mut tables): (&mut [f64], [&mut [f64]; TABLES])| {
            for (k, energy) in energies.iter_mut().enumerate() {
                let (found, row) = values(start + k);
                *energy = found;
                tables.iter_mut().zip(row).for_each(|(table, value)| table[k] = value);
            }
        };
        for_each((energies, split(&mut self.tables, self.points)), &leaf);
    }

    /// Returns the tractions component by component.
    pub(crate) fn tractions(&self) -> &[f64] {
        &self.tables[..self.components * self.points]
    }

    /// Returns the traction along component `c`.
    pub(crate) fn traction(&self, c: usize) -> &[f64] {
        &self.tables[c * self.points..][..self.points]
    }

    /// Returns the diagonal entry of J for component `c`.
    pub(crate) fn diagonal(&self, c: usize) -> &[f64] {
        self.entry(c, c)
    }

    fn entry(&self, a: usize, b: usize) -> &[f64] {
        let (row, column) = (a.min(b), a.max(b));
        self.traction(self.components + column * (column + 1) / 2 + row)
    }

    /// Computes `out` ← `out` + J `vector`.
    pub(crate) fn add_product(&self, vector: &[f64], out: &mut [f64]) {
        match self.components {
            1 => self.add_product_of::<1>(vector, out),
            2 => self.add_product_of::<2>(vector, out),
            _ => self.add_product_of::<3>(vector, out),
        }
    }

    fn add_product_of<const N: usize>(&self, vector: &[f64], out: &mut [f64]) {
        let leaf = |start: usize, out: [&mut [f64]; N]| {
            let stretch = start..start + out[0].len();
            let v: [&[f64]; N] = std::array::from_fn(|b| &vector[b * self.points..][stretch.clone()]);
            for (a, out) in out.into_iter().enumerate() {
                let j: [&[f64]; N] = std::array::from_fn(|b| &self.entry(a, b)[stretch.clone()]);
                for (k, out) in out.iter_mut().enumerate() {
                    let products: [f64; N] = std::array::from_fn(|b| j[b][k] * v[b][k]);
                    *out += products[1..].iter().fold(products[0], |sum, product| sum + product);
                }
            }
        };
        for_each(split(out, self.points), &leaf);
    }
}

/// Splits a vector into its `M` fields.
fn split<const M: usize>(vector: &mut [f64], points: usize) -> [&mut [f64]; M] {
    let mut fields = vector.chunks_exact_mut(points);
    std::array::from_fn(|_| fields.next().expect("a vector of M fields"))
}
