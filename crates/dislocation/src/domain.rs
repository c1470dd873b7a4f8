use std::f64::consts::PI;
use std::sync::Arc;

use gfmd_field::{Grid, Transform};
use gfmd_green::{Base, Body, Height, Layer, Material, Matrix2};
use gfmd_mixed::{Method, MixedProblem, Prescribed};
use gfmd_relax::Budget;
use gfmd_response::FullResponse;
use ndarray::Array3;
use num_complex::Complex64;

use crate::array::Row;
use crate::{DislocationError, Edge, Stress};

/// Body in plane strain, periodic along x. A frictionless flat punch holds some points of its surface; the others are
/// free of traction.
///
/// The state with dislocations is the sum of their fields in an unbounded body and of an image field without
/// singularities, which restores the conditions at the surface and at the base (van der Giessen and Needleman 1995).
/// The image field is a boundary-value problem of the surface alone (theory.md, section 15.2).
#[derive(Clone, Debug)]
pub struct Domain {
    body: Body,
    below: Body,
    /// Layer of a slab; `None` for a half-space.
    layer: Option<Layer>,
    response: Arc<FullResponse>,
    held: Vec<bool>,
    pub(crate) row: Row,
    tolerance: f64,
}

/// Jump of the surface displacement where dislocations have left the body: `jump` (x, z; length) across `x`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Position on the surface.
    pub x: f64,
    /// Displacement on the right minus displacement on the left.
    pub jump: [f64; 2],
}

/// State of a [`Domain`]: surface and image field in equilibrium with the dislocations.
#[derive(Clone, Debug)]
pub struct State {
    domain: Domain,
    edges: Vec<Edge>,
    /// Image displacement (x, z) of the surface by wave number, from 0.
    surface: Vec<[Complex64; 2]>,
    /// Image displacement of the base.
    base: Vec<[Complex64; 2]>,
    /// Uniform part of σ_xx, without the contribution of the rows.
    uniform: f64,
    /// Mean pressure of the punch over the whole surface.
    mean_pressure: f64,
    pressure: Vec<f64>,
    displacement: Vec<f64>,
    energy: f64,
}

impl Domain {
    /// Makes a domain below the points of `grid` that are `held` by the punch. Without held points the surface is free.
    ///
    /// # Errors
    /// A body other than a half-space or one slab on a bonded base; a grid that is not a line or has an even number of
    /// points; a mask of another length.
    pub fn new(body: &Body, grid: &Grid, held: &[bool]) -> Result<Self, DislocationError> {
        if body.second().is_some() || *body.base() != Base::BONDED {
            return Err(DislocationError::Body);
        }
        let points = grid.len();
        if !grid.is_line() || points.is_multiple_of(2) || points < 3 {
            return Err(DislocationError::Points { found: points });
        }
        if held.len() != points {
            return Err(gfmd_field::ShapeError { what: "mask", found: held.len(), expected: points }.into());
        }
        let layer = match body.height() {
            Height::Finite(height) => Some(Layer::new(*body.material(), height)?),
            Height::Infinite => None,
        };
        Ok(Self {
            body: body.clone(),
            below: Body::half_space(*body.material()),
            layer,
            response: FullResponse::new(*grid, body).into(),
            held: held.to_vec(),
            row: Row::new(body.material(), grid.lengths()[0]),
            tolerance: 1e-10,
        })
    }

    /// Returns the grid of the surface.
    pub fn grid(&self) -> &Grid {
        self.response.grid()
    }

    /// Returns the material.
    pub fn material(&self) -> &Material {
        self.body.material()
    }

    /// Returns the height of a slab.
    pub fn height(&self) -> Option<f64> {
        match self.body.height() {
            Height::Finite(height) => Some(height),
            Height::Infinite => None,
        }
    }

    /// Computes the state with dislocations `edges`, `steps` on the surface, and the punch at `depth` (length).
    ///
    /// The Burgers vectors of edges and steps together must add up to zero on each slip plane, otherwise the
    /// displacement is not periodic; this is not checked. `rise` is the mean height (length) of the surface due to slip
    /// and the mean strain of the dislocations.
    ///
    /// # Errors
    /// A dislocation outside the body; a surface that does not reach equilibrium.
    pub fn state(&self, edges: &[Edge], steps: &[Step], rise: f64, depth: f64) -> Result<State, DislocationError> {
        let lowest = self.height().unwrap_or(f64::INFINITY);
        for edge in edges {
            self.body.at_depth(-edge.place[1])?;
            if !(edge.place[1] < 0.0 && -edge.place[1] < lowest) {
                return Err(DislocationError::Value {
                    what: "height of a dislocation against the surface",
                    found: edge.place[1],
                    allowed: "negative, and above the base",
                });
            }
        }
        if !(depth.is_finite() && rise.is_finite()) {
            return Err(DislocationError::Value { what: "depth of the punch", found: depth, allowed: "finite" });
        }
        let grid = *self.grid();
        let (points, length, spacing) = (grid.len(), grid.lengths()[0], grid.spacing()[0]);
        let transform = Transform::new(grid);
        let mut memory = transform.workspace();
        let waves = self.waves(edges);
        let mut synthesise = |of: &dyn Fn(&Wave) -> Complex64| -> Result<Vec<f64>, DislocationError> {
            let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
            for (amplitude, wave) in spectrum[1..].iter_mut().zip(&waves) {
                *amplitude = of(wave);
            }
            let mut field = vec![0.0; points];
            transform.inverse(&spectrum, &mut field, &mut memory)?;
            Ok(field)
        };
        let given = [0, 1].map(|axis| synthesise(&|wave| -(wave.top.traction[axis] + wave.from_base[axis])));
        let [shear, normal] = given;
        let (shear, normal) = (shear?, normal?);
        let mut offset = synthesise(&|wave| wave.top.displacement[1])?;
        for (i, offset) in offset.iter_mut().enumerate() {
            *offset += rise + steps.iter().map(|step| step.at(i as f64 * spacing, length)).sum::<f64>();
        }
        let (traction, displacement) = self.image(&shear, &normal, &|i| -depth - offset[i])?;
        let mut spectra = [const { Vec::new() }; 4];
        let fields = displacement.chunks_exact(points).chain(traction.chunks_exact(points));
        for (spectrum, field) in spectra.iter_mut().zip(fields) {
            *spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
            transform.forward(field, spectrum, &mut memory)?;
        }
        let [ux, uz, tx, tz] = spectra;
        let mean_pressure = -tz[0].re;
        let mut energy = self.rows_energy(edges);
        if let Some(height) = self.height() {
            energy += 0.5 * length * height * self.material().p_wave_compliance() * mean_pressure * mean_pressure;
        }
        for (index, wave) in waves.iter().enumerate() {
            let m = index + 1;
            energy += 2.0 * length * self.wave_energy(m, wave, [ux[m], uz[m]], [tx[m], tz[m]]);
        }
        let pressure = traction[points..].iter().zip(&normal).map(|(t, given)| given - t).collect();
        let displacement = displacement[points..].iter().zip(&offset).map(|(u, offset)| u + offset).collect();
        Ok(State {
            domain: self.clone(),
            edges: edges.to_vec(),
            surface: ux.into_iter().zip(uz).skip(1).map(|(x, z)| [x, z]).collect(),
            base: waves.iter().map(|wave| wave.base.displacement.map(|u| -u)).collect(),
            uniform: edges.iter().map(|edge| self.row.uniform_stress(edge.burgers)).sum(),
            mean_pressure,
            pressure,
            displacement,
            energy,
        })
    }

    fn wavenumber(&self, m: usize) -> f64 {
        2.0 * PI * m as f64 / self.grid().lengths()[0]
    }

    /// Returns the rows at the surface and at the base, wave by wave from the first.
    fn waves(&self, edges: &[Edge]) -> Vec<Wave> {
        let waves = 1..self.grid().spectrum_len();
        waves
            .map(|m| {
                let q = self.wavenumber(m);
                let compliance = self.below.plane_compliance(q);
                let at = |level: f64| {
                    let mut sum = [Complex64::ZERO; 2];
                    for edge in edges {
                        sum = add(sum, self.row.wave(edge, level, q));
                    }
                    sum
                };
                // Above the rows is an upside-down half-space, below them a half-space loaded on its surface.
                let traction = at(0.0);
                let [x, z] = times(&compliance, [-traction[0], traction[1]]);
                let top = Face { traction, displacement: [x, -z] };
                let Some((layer, height)) = self.layer.as_ref().zip(self.height()) else {
                    return Wave { top, ..Wave::default() };
                };
                let traction = at(-height);
                let base = Face { traction, displacement: times(&compliance, traction) };
                let matrix = layer.plane_matrix(q);
                let moved = base.displacement.map(|u| -u);
                let from_base = [0, 1].map(|row| matrix[row][2] * moved[0] + matrix[row][3] * moved[1]);
                Wave { top, base, from_base }
            })
            .collect()
    }

    /// Returns the energy of a wave per area, for either sign of the wave number, minus the energy of the rows in an
    /// unbounded body: half the surface integral of t·u + t_r·u − t·u_r, with r for the rows (theory.md, section 15.3).
    fn wave_energy(&self, m: usize, wave: &Wave, image: [Complex64; 2], added: [Complex64; 2]) -> f64 {
        let (top, base) = (&wave.top, &wave.base);
        let traction = add(add(added, wave.from_base), top.traction);
        let displacement = add(image, top.displacement);
        let mut twice = dot(traction, displacement) + dot(top.traction, displacement) - dot(traction, top.displacement);
        if let Some(layer) = &self.layer {
            let matrix = layer.plane_matrix(self.wavenumber(m));
            let moved = base.displacement.map(|u| -u);
            let held = [2, 3].map(|row| {
                let of = &matrix[row];
                of[0] * image[0] + of[1] * image[1] + of[2] * moved[0] + of[3] * moved[1] - base.traction[row - 2]
            });
            twice -= dot(held, base.displacement);
        }
        0.5 * twice
    }

    /// Returns the energy of the rows in an unbounded body and of the uniform strain that keeps the body far below
    /// unstrained, per length along the lines and per cell.
    fn rows_energy(&self, edges: &[Edge]) -> f64 {
        let mut energy = 0.0;
        for (i, edge) in edges.iter().enumerate() {
            energy += edges[..i].iter().map(|other| self.row.energy(other, edge)).sum::<f64>();
        }
        let jump: f64 = edges.iter().map(|edge| edge.burgers[0]).sum();
        let moment: f64 = edges.iter().map(|edge| edge.burgers[0] * edge.place[1]).sum();
        energy + 0.5 * self.material().contact_modulus() / self.grid().lengths()[0] * -(jump * moment)
    }

    /// Computes the image field of a body with its base at rest: traction and displacement of the surface, x then z,
    /// from the traction on free points and the height of held points.
    fn image(
        &self,
        shear: &[f64],
        normal: &[f64],
        height: &dyn Fn(usize) -> f64,
    ) -> Result<(Vec<f64>, Vec<f64>), DislocationError> {
        let points = self.held.len();
        let given: Vec<f64> = shear.iter().chain(normal).copied().collect();
        if !self.held.contains(&true) {
            let mut displacement = vec![0.0; 2 * points];
            self.response.compliance().apply(&given, &mut displacement, &mut self.response.workspace())?;
            return Ok((given, displacement));
        }
        let held = Array3::from_shape_fn((2, points, 1), |(axis, i, _)| axis == 1 && self.held[i]);
        let values = Array3::from_shape_fn((2, points, 1), |(axis, i, _)| {
            if axis == 1 && self.held[i] { height(i) } else { given[axis * points + i] }
        });
        let problem =
            MixedProblem::with_response(Arc::clone(&self.response), Prescribed::new(held.view(), values.view())?)?;
        let budget = Budget { tolerance: self.tolerance, ..Budget::default() };
        let solution = problem.solve(Method::default(), &budget, &mut ())?;
        Ok((solution.traction.into_iter().collect(), solution.displacement.into_iter().collect()))
    }
}

impl Step {
    /// Returns the height of a saw-tooth of mean zero with this jump.
    fn at(&self, x: f64, period: f64) -> f64 {
        let phase = (x - self.x).rem_euclid(period) / period;
        self.jump[1] * (0.5 - phase)
    }
}

impl State {
    /// Returns the dislocations.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// Returns the mean pressure over the whole surface, in stress.
    pub fn mean_pressure(&self) -> f64 {
        self.mean_pressure
    }

    /// Returns the pressure at each point of the surface, stress. It may be negative (tension), since the punch does
    /// not separate from the surface.
    pub fn pressure(&self) -> &[f64] {
        &self.pressure
    }

    /// Returns the displacement u_z of each point of the surface.
    pub fn displacement(&self) -> &[f64] {
        &self.displacement
    }

    /// Returns the elastic energy of a cell per length along the lines (force), up to the constant energy of each
    /// dislocation line. A half-space excludes the uniform compression below the punch, which has unbounded energy.
    pub fn energy(&self) -> f64 {
        self.energy
    }

    /// Returns the stress at `place` without the dislocations themselves: the image field.
    ///
    /// # Errors
    /// A place outside the body.
    pub fn image_stress(&self, place: [f64; 2]) -> Result<Stress, DislocationError> {
        let domain = &self.domain;
        let material = domain.material();
        let poisson = material.poisson();
        let depth = -place[1];
        let above = domain.body.at_depth(depth)?;
        // The same slab upside down: the effect of the base.
        let mirrored = domain.height().map(|height| domain.body.at_depth(height - depth)).transpose()?;
        let mut sum = [0.0; 3];
        let turn = Complex64::cis(2.0 * PI * place[0] / domain.grid().lengths()[0]);
        let mut phase = Complex64::ONE;
        for (index, (surface, base)) in self.surface.iter().zip(&self.base).enumerate() {
            let q = domain.wavenumber(index + 1);
            phase *= turn;
            if q * depth < FAR {
                for (sum, row) in sum.iter_mut().zip(above.plane_stress_transfer(q)) {
                    *sum += 2.0 * ((row[0] * surface[0] + row[1] * surface[1]) * phase).re;
                }
            }
            if let (Some(mirrored), Some(height)) = (&mirrored, domain.height())
                && q * (height - depth) < FAR
            {
                let signs = [1.0, 1.0, -1.0];
                for ((sum, row), sign) in sum.iter_mut().zip(mirrored.plane_stress_transfer(q)).zip(signs) {
                    *sum += sign * 2.0 * ((row[0] * base[0] - row[1] * base[1]) * phase).re;
                }
            }
        }
        let [xx, zz, xz] = sum;
        let lateral = self.uniform - poisson / (1.0 - poisson) * self.mean_pressure;
        Ok(Stress { xx: xx + lateral, zz: zz - self.mean_pressure, xz })
    }

    /// Returns the stress at `place`, without the singular field of the dislocation number `but`.
    ///
    /// # Errors
    /// A place outside the body.
    pub fn stress(&self, place: [f64; 2], but: Option<usize>) -> Result<Stress, DislocationError> {
        let others = self.edges.iter().enumerate().filter(|(index, _)| Some(*index) != but);
        let rows = others.map(|(_, edge)| self.domain.row.stress(edge, place));
        Ok(rows.fold(self.image_stress(place)?, Stress::plus))
    }

    /// Returns the Peach-Koehler force (x, z; force per length) on the dislocation number `index`.
    ///
    /// # Errors
    /// Never fails for a dislocation of this state.
    pub fn force(&self, index: usize) -> Result<[f64; 2], DislocationError> {
        let Edge { place, burgers: [bx, bz] } = self.edges[index];
        let stress = self.stress(place, Some(index))?;
        Ok([bx * stress.xz + bz * stress.zz, -(bx * stress.xx + bz * stress.xz)])
    }
}

/// Value of q·depth beyond which a wave has decayed: e^(−40) is below 1e-17.
const FAR: f64 = 40.0;

/// Traction (x, z) on a plane that faces +z, and displacement, of the rows in an unbounded body.
#[derive(Clone, Copy, Debug, Default)]
struct Face {
    traction: [Complex64; 2],
    displacement: [Complex64; 2],
}

/// Rows at the surface and at the base, and the traction on the held surface when the base is brought back to rest.
#[derive(Clone, Copy, Debug, Default)]
struct Wave {
    top: Face,
    base: Face,
    from_base: [Complex64; 2],
}

fn add(a: [Complex64; 2], b: [Complex64; 2]) -> [Complex64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

fn times(matrix: &Matrix2, v: [Complex64; 2]) -> [Complex64; 2] {
    matrix.map(|row| row[0] * v[0] + row[1] * v[1])
}

fn dot(a: [Complex64; 2], b: [Complex64; 2]) -> f64 {
    (a[0].conj() * b[0] + a[1].conj() * b[1]).re
}
