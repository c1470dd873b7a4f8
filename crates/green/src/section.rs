use gfmd_field::Mode;
use num_complex::Complex64;

use crate::{
    Base, Blocks, Body, GreenError, Ground, Height, Material, Matrix2, Matrix3,
    blocks::{VECTOR_ROWS, average_aliases, direction},
    body::{on_axes, plus, uniform_compliance, wavevector},
    half_space,
    hyperbolic::{FARTHEST, cosh_minus, sinh_minus},
    sagittal::product,
    slab::LayerMode,
    stack::State,
};

/// Stresses of one wave vector per surface displacement: rows xx, yy, zz, yz, xz, xy, columns x, y, z.
pub type StressMatrix3 = [[Complex64; 3]; 6];

/// Plane-strain stresses of one wave vector per surface displacement: rows xx, zz, xz, columns x, z.
pub type StressMatrix2 = [[Complex64; 2]; 3];

/// Strains and stresses of one wave vector that are continuous across a plane, per surface displacement: rows ε_xx,
/// ε_yy, γ_xy (1/length), σ_zz, σ_yz, σ_xz (stress/length), columns x, y, z. Hooke's law gives the remaining strains
/// and stresses, starting with [`Material::normal_strain`].
pub type ContinuousMatrix = [[Complex64; 3]; 6];

/// Axes of each row of [`StressMatrix3`].
const STRESS_ROWS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [1, 2], [0, 2], [0, 1]];

/// Axes of each row of [`ContinuousMatrix`].
const CONTINUOUS_ROWS: [[usize; 2]; 6] = [[0, 0], [1, 1], [0, 1], [2, 2], [1, 2], [0, 2]];

/// Plane inside a body, parallel to the surface, with displacements and stresses per displacement of the surface
/// (theory.md, section 5).
#[derive(Clone, Debug)]
pub struct Section<'a> {
    surface: &'a Body,
    /// Layers above the plane, from the top.
    above: Vec<Above<'a>>,
    /// Layer or half-space that contains the plane.
    local: &'a Body,
    /// Depth below the top of `local`.
    depth: f64,
    /// Height above the base of `local`; infinite in a half-space.
    height: f64,
    /// True if the uniform mode is relative to the reference level of [`Body::level_compliance`].
    level: bool,
}

/// Layer on another body.
#[derive(Clone, Copy, Debug)]
struct Above<'a> {
    material: &'a Material,
    thickness: f64,
    base: &'a Base,
}

impl Body {
    /// Returns the plane at `height` (length) above the base of the body, or of the top layer in a stack.
    ///
    /// # Errors
    /// Returns an error if the height is outside the body, and for any height in a half-space.
    pub fn at_height(&self, height: f64) -> Result<Section<'_>, GreenError> {
        let Height::Finite(largest) = self.height() else { return Err(GreenError::HalfSpaceHeight(height)) };
        if !(0.0..=largest).contains(&height) {
            return Err(GreenError::Outside { what: "height above the base", found: height, largest });
        }
        Ok(Section { surface: self, above: Vec::new(), local: self, depth: largest - height, height, level: false })
    }

    /// Returns the plane at `depth` (length) below the surface. In a stack, it may lie in any layer.
    ///
    /// # Errors
    /// Returns an error if the depth is outside the body.
    pub fn at_depth(&self, depth: f64) -> Result<Section<'_>, GreenError> {
        let outside = |largest| GreenError::Outside { what: "depth below the surface", found: depth, largest };
        let (mut above, mut local, mut top) = (Vec::new(), self, 0.0);
        if !(depth.is_finite() && depth >= 0.0) {
            return Err(outside(self.total_height()));
        }
        loop {
            let Height::Finite(thickness) = local.height() else {
                let (depth, height) = (depth - top, f64::INFINITY);
                return Ok(Section { surface: self, above, local, depth, height, level: false });
            };
            let bottom = top + thickness;
            if depth <= bottom {
                let (depth, height) = (depth - top, bottom - depth);
                return Ok(Section { surface: self, above, local, depth, height, level: false });
            }
            let Base::Elastic(below) = local.base() else { return Err(outside(bottom)) };
            above.push(Above { material: local.material(), thickness, base: local.base() });
            (local, top) = (below, bottom);
        }
    }

    /// Returns the depths (length) of the interfaces between layers, and with a half-space below, from the top down.
    pub fn interfaces(&self) -> Vec<f64> {
        let (mut depths, mut local, mut top) = (Vec::new(), self, 0.0);
        while let (Height::Finite(thickness), Base::Elastic(below)) = (local.height(), local.base()) {
            top += thickness;
            depths.push(top);
            local = below;
        }
        depths
    }

    /// Returns the total height of all layers, without a half-space.
    fn layers(&self) -> f64 {
        match (self.height(), self.base()) {
            (Height::Infinite, _) => 0.0,
            (Height::Finite(thickness), Base::Elastic(below)) => thickness + below.layers(),
            (Height::Finite(thickness), _) => thickness,
        }
    }

    /// Returns the total height of all layers, which is the depth of the base; infinite with a half-space.
    pub fn total_height(&self) -> f64 {
        let (mut local, mut depth) = (self, 0.0);
        loop {
            let Height::Finite(thickness) = local.height() else { return f64::INFINITY };
            depth += thickness;
            let Base::Elastic(below) = local.base() else { return depth };
            local = below;
        }
    }
}

impl<'a> Section<'a> {
    /// Returns the lower side of this plane. Between two layers, the material is then the lower one; elsewhere nothing
    /// changes.
    #[must_use]
    pub fn from_below(mut self) -> Self {
        if let (true, Base::Elastic(below)) = (self.height == 0.0, self.local.base())
            && let Height::Finite(thickness) = self.local.height()
        {
            self.above.push(Above { material: self.local.material(), thickness, base: self.local.base() });
            (self.local, self.depth) = (below, 0.0);
            self.height = if let Height::Finite(height) = below.height() { height } else { f64::INFINITY };
        }
        self
    }

    /// Returns this plane with the uniform mode relative to the reference level of [`Body::level_compliance`].
    #[must_use]
    pub fn against_level(self) -> Self {
        Self { level: true, ..self }
    }

    /// Returns the depth of this plane below the top of its half-space, in length; `None` in a layer or a slab.
    pub fn depth_in_half_space(&self) -> Option<f64> {
        (self.local.height() == Height::Infinite).then_some(self.depth)
    }

    /// Returns the material at this plane; between two layers, the upper material.
    pub fn material(&self) -> &'a Material {
        self.local.material()
    }

    /// Returns the dimensionless displacement at this plane per displacement of the surface, for the wave vector `q`
    /// (rad/length).
    pub fn displacement_transfer(&self, q: [f64; 2]) -> Matrix3 {
        on_axes(q, |q| self.state(q).displacement)
    }

    /// Returns the lateral strains and tractions at this plane per displacement of the surface, for the wave vector `q`
    /// (rad/length).
    ///
    /// At q = 0, they are infinite where the stiffness is infinite: in an incompressible slab on a rigid base.
    pub fn continuous_transfer(&self, q: [f64; 2]) -> ContinuousMatrix {
        let state = self.state(q[0].hypot(q[1]));
        let [x, y, _] = on_axes(q, |_| state.displacement);
        let [xz, yz, zz] = on_axes(q, |_| state.traction);
        let along = |q: f64, row: [Complex64; 3]| row.map(|entry| i_times(q, entry));
        let (yx, xy) = (along(q[1], x), along(q[0], y));
        [along(q[0], x), along(q[1], y), [0, 1, 2].map(|column| yx[column] + xy[column]), zz, yz, xz]
    }

    /// Returns the stress at this plane per displacement of the surface, for the wave vector `q` (rad/length), in
    /// stress/length.
    ///
    /// At q = 0, it is infinite where the stiffness is infinite: in an incompressible slab on a rigid base.
    pub fn stress_transfer(&self, q: [f64; 2]) -> StressMatrix3 {
        let continuous = self.continuous_transfer(q);
        let mut stress = [[Complex64::ZERO; 3]; 6];
        for column in 0..3 {
            let [exx, eyy, gxy, zz, yz, xz] = continuous.map(|row| row[column]);
            let [xx, yy] = self.lateral_stress([exx, eyy], zz);
            let xy = self.material().shear_modulus() * gxy;
            for (row, value) in stress.iter_mut().zip([xx, yy, zz, yz, xz, xy]) {
                row[column] = value;
            }
        }
        stress
    }

    /// Returns the displacement transfer of a grid mode; entries odd in a Nyquist component are zero (theory.md,
    /// section 0).
    pub fn displacement_transfer_of(&self, mode: &Mode) -> Matrix3 {
        let mut matrix = self.displacement_transfer(wavevector(mode));
        average_aliases(&mut matrix, &VECTOR_ROWS, mode.nyquist);
        matrix
    }

    /// Returns the stress transfer of a grid mode; entries odd in a Nyquist component are zero (theory.md, section 0).
    pub fn stress_transfer_of(&self, mode: &Mode) -> StressMatrix3 {
        let mut matrix = self.stress_transfer(wavevector(mode));
        average_aliases(&mut matrix, &STRESS_ROWS, mode.nyquist);
        matrix
    }

    /// Returns the [`continuous_transfer`](Self::continuous_transfer) of a mode of a grid; entries odd in a Nyquist
    /// component are zero (theory.md, section 0).
    pub fn continuous_transfer_of(&self, mode: &Mode) -> ContinuousMatrix {
        let mut matrix = self.continuous_transfer(wavevector(mode));
        average_aliases(&mut matrix, &CONTINUOUS_ROWS, mode.nyquist);
        matrix
    }

    /// Returns the dimensionless displacement at this plane per u_z of a surface without shear traction, for a mode of
    /// a grid: rows x, y, z. [`Body::lateral_ratio`] gives the lateral displacement of the surface.
    ///
    /// A Nyquist mode is the average of its aliases ±q_N. Their lateral displacement is zero at the surface points, but
    /// not between them. The pressure on the surface is thus u_z divided by [`Body::normal_compliance`] for these
    /// modes, too (theory.md, section 5).
    pub fn frictionless_displacement_of(&self, mode: &Mode) -> [Complex64; 3] {
        self.without_shear(&self.displacement_transfer(wavevector(mode)), &VECTOR_ROWS, mode)
    }

    /// Returns the lateral strains and tractions at this plane per u_z of a surface without shear traction, for a mode
    /// of a grid: the rows of a [`ContinuousMatrix`]; Nyquist modes as in
    /// [`frictionless_displacement_of`](Self::frictionless_displacement_of).
    pub fn frictionless_continuous_of(&self, mode: &Mode) -> [Complex64; 6] {
        self.without_shear(&self.continuous_transfer(wavevector(mode)), &CONTINUOUS_ROWS, mode)
    }

    /// Returns the product of a transfer matrix and the displacement of a surface with u_z = 1 and no shear traction,
    /// averaged over the aliases of a Nyquist mode.
    fn without_shear<const ROWS: usize, const INDICES: usize>(
        &self,
        transfer: &[[Complex64; 3]; ROWS],
        rows: &[[usize; INDICES]; ROWS],
        mode: &Mode,
    ) -> [Complex64; ROWS] {
        let lateral = direction(wavevector(mode)).map_or([0.0; 2], |(direction, q)| {
            let ratio = self.surface.lateral_ratio(q);
            direction.map(|component| -ratio * component)
        });
        // In each component of q, a product is even or odd like the u_z entry of its row, since each lateral
        // displacement per u_z is odd in its own component.
        let mut products = transfer.map(|[x, y, z]| {
            let sum = if lateral == [0.0; 2] { z } else { i_times(lateral[0], x) + i_times(lateral[1], y) + z };
            [Complex64::ZERO, Complex64::ZERO, sum]
        });
        average_aliases(&mut products, rows, mode.nyquist);
        products.map(|[_, _, product]| product)
    }

    /// Returns the plane-strain displacement (x, z) at this plane per displacement of the surface, for the wave vector
    /// `q` along x.
    pub fn plane_displacement_transfer(&self, q: f64) -> Matrix2 {
        self.state(q.abs()).displacement.plane(q.signum())
    }

    /// Returns the plane-strain stress at this plane per displacement of the surface, for the wave vector `q` along x,
    /// in stress/length.
    pub fn plane_stress_transfer(&self, q: f64) -> StressMatrix2 {
        let state = self.state(q.abs());
        let (displacement, traction) = (state.displacement.plane(q.signum()), state.traction.plane(q.signum()));
        let mut stress = [[Complex64::ZERO; 2]; 3];
        for column in 0..2 {
            let [xz, zz] = [traction[0][column], traction[1][column]];
            let [xx, _] = self.lateral_stress([i_times(q, displacement[0][column]), Complex64::ZERO], zz);
            for (row, value) in stress.iter_mut().zip([xx, zz, xz]) {
                row[column] = value;
            }
        }
        stress
    }

    /// Returns the lateral stresses σ_xx and σ_yy from ε_xx, ε_yy and σ_zz; finite at ν = 1/2.
    fn lateral_stress(&self, strain: [Complex64; 2], normal: Complex64) -> [Complex64; 2] {
        let thickening = self.material().normal_strain(strain, normal);
        strain.map(|strain| normal + (strain - thickening) * (2.0 * self.material().shear_modulus()))
    }

    /// Returns the displacement and the traction at this plane per displacement of the surface, at |q| = `q`.
    fn state(&self, q: f64) -> State {
        if q == 0.0 {
            return self.uniform_state();
        }
        self.above.iter().rev().fold(self.local_state(q), |state, layer| {
            let transfer = LayerMode::new(layer.material, layer.thickness, q).base_state(layer.base).displacement;
            State {
                displacement: product(&state.displacement, &transfer),
                traction: product(&state.traction, &transfer),
            }
        })
    }

    /// Returns the displacement and the traction at this plane per displacement of the top of the local layer.
    fn local_state(&self, q: f64) -> State {
        let material = self.local.material();
        let thickness = match self.local.height() {
            Height::Finite(thickness) if q * self.height <= OUT_OF_REACH => thickness,
            // A half-space, or a base too far below to have an effect, as for most modes at most depths.
            _ => {
                let displacement = half_space::transfer(material, q * self.depth);
                return State { displacement, traction: product(&half_space::stiffness(material, q), &displacement) };
            }
        };
        let base = self.local.base();
        let is_bonded = matches!(base, Base::Rigid(Ground::BONDED));
        let below = LayerMode::new(material, self.height, q);
        let transfer = || bonded_transfer(material, q * self.height, q * self.depth);
        if below.is_thin() {
            let whole = LayerMode::new(material, thickness, q);
            let state = below.propagated(&whole.base_state(base));
            return if is_bonded { State { displacement: transfer(), ..state } } else { state };
        }
        // The part of the layer below the plane is a slab on the same base.
        let support = below.stiffness_on(base);
        let displacement =
            if is_bonded { transfer() } else { LayerMode::new(material, self.depth, q).transfer_to(&support) };
        State { displacement, traction: product(&support, &displacement) }
    }

    /// Returns the state at q = 0: all layers are strained uniformly and carry the same stress.
    fn uniform_state(&self) -> State {
        if self.level {
            return self.level_state();
        }
        let below = match self.local.height() {
            Height::Finite(_) => uniform_compliance(self.local.material(), self.height, self.local.base()),
            Height::Infinite => self.local.compliance_blocks(0.0),
        };
        let total = self.surface.first_uniform_compliance();
        let share = |below: f64, total: f64| match total {
            f64::INFINITY => 1.0,
            // Incompressible layers do not move along z; this is the limit ν → 1/2.
            0.0 => self.remaining_height() / self.surface.total_height(),
            _ => below / total,
        };
        let lateral = share(below.transverse, total.transverse);
        State {
            displacement: Blocks::diagonal(lateral, share(below.normal, total.normal)),
            traction: total.inverse_diagonal(),
        }
    }

    /// Returns the state at q = 0 relative to the reference level. A half-space moves with its surface, without stress.
    fn level_state(&self) -> State {
        let below = match self.local.height() {
            Height::Finite(_) => {
                let material = self.material();
                let rest = [self.height / material.shear_modulus(), self.height * material.p_wave_compliance()];
                if let Base::Elastic(below) = self.local.base() { plus(rest, below.level_compliance()) } else { rest }
            }
            Height::Infinite => [0.0; 2],
        };
        let total = self.surface.first_level_compliance();
        let layered = !self.above.is_empty() || self.local.height() != Height::Infinite;
        let share = |axis: usize| match (total[axis] > 0.0, layered) {
            (true, _) => below[axis] / total[axis],
            // Incompressible layers do not move along z; this is the limit ν → 1/2.
            (false, true) => (self.layers_below() / self.surface.layers()).max(0.0),
            (false, false) => 1.0,
        };
        let [lateral, normal] = total.map(|total| {
            if total > 0.0 {
                1.0 / total
            } else if layered {
                f64::INFINITY
            } else {
                0.0
            }
        });
        State { displacement: Blocks::diagonal(share(0), share(1)), traction: Blocks::diagonal(lateral, normal) }
    }

    /// Returns the height of the layers below the plane, without a half-space.
    fn layers_below(&self) -> f64 {
        match (self.local.height(), self.local.base()) {
            (Height::Infinite, _) => 0.0,
            (_, Base::Elastic(below)) => self.height + below.layers(),
            _ => self.height,
        }
    }

    fn remaining_height(&self) -> f64 {
        match self.local.base() {
            Base::Elastic(below) => self.height + below.total_height(),
            _ => self.height,
        }
    }
}

/// Returns the transfer from the top of a slab on a bonded base to the plane at Z = q·height above the base and b =
/// q·depth below the top (theory.md, section 5).
fn bonded_transfer(material: &Material, z: f64, b: f64) -> Blocks {
    let b = b.min(FARTHEST);
    let (r, h) = (material.r(), z + b);
    if h < 1.0 {
        let (m, mz, a) = (sinh_minus(h), sinh_minus(z), h + z);
        let (one_minus_r, one_plus_r) = (material.one_minus_r(), material.one_plus_r());
        let determinant = (one_minus_r * h + m) * (one_plus_r * h + m);
        let half = (0.5 * b).sinh();
        let mean = one_minus_r * one_plus_r * h * z + 0.5 * (cosh_minus(a) - cosh_minus(b))
            - 2.0 * r * r * h * z * half * half;
        let x = 0.5 * r * (a * sinh_minus(b) - b * sinh_minus(a));
        let y = b * (h * mz + z * m + m * mz);
        let w = r * h * z * sinh_minus(b);
        Blocks {
            longitudinal: (mean + x) / determinant,
            normal: (mean - x) / determinant,
            transverse: z.sinh() / h.sinh(),
            coupling: [
                r * (one_plus_r * b * h * z + y + w) / determinant,
                r * (one_minus_r * b * h * z + y - w) / determinant,
            ],
        }
    } else {
        let (ez, oz) = ((-2.0 * z).exp(), -(-2.0 * z).exp_m1());
        let (e, o) = ((-2.0 * h).exp(), -(-2.0 * h).exp_m1());
        let g = (-b).exp() / (o * o - 4.0 * r * r * h * h * e);
        let difference = -ez * (-2.0 * b).exp_m1();
        let product = oz * o;
        let x = z * (1.0 + ez) * o - h * oz * (1.0 + e);
        let w = 2.0 * r * h * z * difference;
        let mean = product - 2.0 * r * r * h * z * (ez + e);
        Blocks {
            longitudinal: g * (mean + r * x),
            normal: g * (mean - r * x),
            transverse: (-b).exp() * oz / o,
            coupling: [r * g * (b * product + w), r * g * (b * product - w)],
        }
    }
}

/// Value of Z = q·height beyond which the base has no effect: e^(−2 Z), even times Z² or 800 Z, is below 1e-30.
const OUT_OF_REACH: f64 = 40.0;

fn i_times(factor: f64, value: Complex64) -> Complex64 {
    Complex64::new(-factor * value.im, factor * value.re)
}
