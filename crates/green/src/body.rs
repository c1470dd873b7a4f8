use gfmd_field::Mode;
use num_complex::Complex64;

use crate::{
    Blocks, Condition, GreenError, Ground, Material, Matrix2, Matrix3,
    blocks::{VECTOR_ROWS, average_aliases, direction},
    half_space,
    slab::LayerMode,
    stack::Basis,
    tabulated::Table,
};

/// Extent of a body below its surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Height {
    /// Slab of this thickness (length).
    Finite(f64),
    /// Half-space.
    Infinite,
}

impl std::fmt::Display for Height {
    /// Writes the length, or `inf`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Finite(height) => height.fmt(f),
            Self::Infinite => f.write_str("inf"),
        }
    }
}

/// Boundary condition at the bottom of a slab.
#[derive(Clone, Debug, PartialEq)]
pub enum Base {
    /// Rigid ground, or none.
    Rigid(Ground),
    /// Bonded to another body: a coating on a half-space, or a stack of layers.
    Elastic(Box<Body>),
}

impl Base {
    /// Bonded to rigid ground: u = 0.
    pub const BONDED: Self = Self::Rigid(Ground::BONDED);
    /// On rigid ground without friction or gap: u_z = 0, no shear traction.
    pub const SLIDING: Self = Self::Rigid(Ground::SLIDING);
    /// No traction: a plate.
    pub const FREE: Self = Self::Rigid(Ground::NONE);
}

/// Elastic body with a plane surface that faces +z: a half-space, a slab on a [`Base`], or two such bodies with their
/// surfaces facing each other, see [`against`](Self::against).
///
/// Stiffness K and compliance G refer to one wave vector q (rad/length) of fields ~ e^(+i q·r): t = K u and u = G t,
/// with t the traction on the surface, positive along +z, and u the displacement of the surface (theory.md, section 0).
/// K is Hermitian and, for q ≠ 0, positive definite.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    material: Material,
    height: Height,
    base: Base,
    second: Option<Box<Body>>,
    table: Option<Table>,
}

/// Undefined properties of a body with a table of normal compliances.
const UNKNOWN: Blocks =
    Blocks { longitudinal: f64::NAN, normal: f64::NAN, coupling: [f64::NAN; 2], transverse: f64::NAN };

impl Body {
    /// Creates a half-space.
    pub fn half_space(material: Material) -> Self {
        Self { material, height: Height::Infinite, base: Base::BONDED, second: None, table: None }
    }

    /// Creates a body with a table of normal compliances; its rows are [wavenumber (rad/length), compliance
    /// (length/stress)]. Between rows, ln G is a [shape-preserving cubic](gfmd_curve::Curve) of ln q. `uniform` is the
    /// compliance of the mean level, 0 if it is fixed; `contact_modulus` (stress) is the unit of reduced pressures.
    /// Compliances and stiffnesses of other components, and states inside the body, are NaN.
    ///
    /// # Errors
    /// Returns an error if the modulus, a wavenumber or a compliance is not positive and finite, if there are fewer
    /// than four rows, or if the wavenumbers do not increase.
    pub fn tabulated(contact_modulus: f64, rows: &[[f64; 2]], uniform: f64) -> Result<Self, GreenError> {
        let material = Material::from_contact_modulus(contact_modulus, 0.0)?;
        Ok(Self { table: Some(Table::isotropic(rows, uniform)?), ..Self::half_space(material) })
    }

    /// Creates a body with a normal compliance that depends on the direction of the wave vector, such as a crystal or a
    /// composite. Table rows are [q_x, q_y (rad/length), compliance (length/stress)], in any order. Every wavenumber
    /// has the same directions, at multiples of π/M from the x axis in half a turn, M ≥ 4; −q is the same wave as q.
    /// Between rows, ln G is a trigonometric polynomial of the angle; its coefficients are cubics of ln q as in
    /// [`tabulated`](Self::tabulated) (theory.md, section 4.4).
    ///
    /// # Errors
    /// Returns the errors of `tabulated`, and an error for a wave vector that is zero or at another angle.
    pub fn tabulated_by_direction(contact_modulus: f64, rows: &[[f64; 3]], uniform: f64) -> Result<Self, GreenError> {
        let material = Material::from_contact_modulus(contact_modulus, 0.0)?;
        Ok(Self { table: Some(Table::anisotropic(rows, uniform)?), ..Self::half_space(material) })
    }

    /// Returns true if the normal compliance does not depend on the direction of the wave vector.
    pub fn is_isotropic(&self) -> bool {
        self.table.as_ref().is_none_or(Table::is_isotropic)
    }

    /// Returns the wavenumbers (rad/length) of the first and the last row of a [tabulated](Self::tabulated) body;
    /// `None` for other bodies.
    pub fn tabulated_wavenumbers(&self) -> Option<[f64; 2]> {
        self.table.as_ref().map(Table::wavenumbers)
    }

    /// Creates a slab of `height` (length) bonded to a rigid base.
    ///
    /// # Errors
    /// Returns an error if the height is not positive and finite.
    pub fn slab(material: Material, height: f64) -> Result<Self, GreenError> {
        Self::new(material, Height::Finite(height))
    }

    /// Creates a half-space, or a slab bonded to a rigid base.
    ///
    /// # Errors
    /// Returns an error if the height of a slab is not positive and finite.
    pub fn new(material: Material, height: Height) -> Result<Self, GreenError> {
        match height {
            Height::Finite(height) if !(height.is_finite() && height > 0.0) => Err(GreenError::Height(height)),
            _ => Ok(Self { material, height, base: Base::BONDED, second: None, table: None }),
        }
    }

    /// Returns this slab on another base.
    ///
    /// # Errors
    /// Returns an error for a half-space, which has no base, or if the base is a pair of bodies.
    pub fn on(self, base: Base) -> Result<Self, GreenError> {
        if let Base::Elastic(below) = &base
            && below.second.is_some()
        {
            return Err(GreenError::PairBelow);
        }
        match self.height {
            Height::Finite(_) => Ok(Self { base, ..self }),
            Height::Infinite => Err(GreenError::HalfSpaceBase),
        }
    }

    /// Returns this slab bonded to another body: a coating, or the next layer of a stack.
    ///
    /// # Errors
    /// Returns an error for a half-space, which has no base, or if the base is a pair of bodies.
    pub fn bonded_to(self, substrate: Body) -> Result<Self, GreenError> {
        self.on(Base::Elastic(Box::new(substrate)))
    }

    /// Returns this body with `second` above it, upside down, with the two surfaces facing each other. Stiffness and
    /// compliance then refer to the relative displacement u₁ − u₂ of the surfaces, and t is the traction on the first:
    /// G = G₁ + J G₂ J with J = diag(1, 1, −1) (theory.md, section 4.1). Positions inside refer to the first body.
    #[must_use]
    pub fn against(self, second: Body) -> Self {
        Self { second: Some(Box::new(second.alone())), ..self }
    }

    /// Returns the second body of a pair.
    pub fn second(&self) -> Option<&Body> {
        self.second.as_deref()
    }

    /// Returns the first body of a pair, or a single body unchanged.
    #[must_use]
    pub fn alone(&self) -> Self {
        Self { second: None, ..self.clone() }
    }

    /// Converts the body to other units of stress and length, given in the current units. Powers of two are exact.
    #[must_use]
    pub fn in_units(&self, stress: f64, length: f64) -> Self {
        let height = match self.height {
            Height::Finite(height) => Height::Finite(height / length),
            Height::Infinite => Height::Infinite,
        };
        let base = match &self.base {
            Base::Elastic(below) => Base::Elastic(below.in_units(stress, length).into()),
            Base::Rigid(ground) => Base::Rigid(*ground),
        };
        let second = self.second.as_ref().map(|second| second.in_units(stress, length).into());
        let table = self.table.as_ref().map(|table| table.in_units(stress, length));
        Self { material: self.material.in_units(stress), height, base, second, table }
    }

    /// Returns the material of the body, or of its top layer.
    pub fn material(&self) -> &Material {
        &self.material
    }

    /// Returns the contact modulus E* = E/(1 − ν²) of the body, or of its top layer, in stress. For a pair, 1/E* =
    /// 1/E₁* + 1/E₂*.
    pub fn contact_modulus(&self) -> f64 {
        let first = self.material.contact_modulus();
        match &self.second {
            None => first,
            Some(second) => {
                let second = second.contact_modulus();
                // The smaller modulus divided by a sum of order one; no product can overflow.
                let [small, large] = if first < second { [first, second] } else { [second, first] };
                small / (1.0 + small / large)
            }
        }
    }

    /// Returns the thickness of the body, or of its top layer.
    pub fn height(&self) -> Height {
        self.height
    }

    /// Returns the base of the slab; [`Base::BONDED`] for a half-space, which has none.
    pub fn base(&self) -> &Base {
        &self.base
    }

    /// Returns the rigid ground below all layers (of the first body in a pair); `None` if there is a half-space below.
    pub fn ground(&self) -> Option<Ground> {
        match (self.height, &self.base) {
            (Height::Infinite, _) => None,
            (Height::Finite(_), Base::Elastic(below)) => below.ground(),
            (Height::Finite(_), Base::Rigid(ground)) => Some(*ground),
        }
    }

    /// Returns the stiffness in the frame of a wave vector of length `q` (rad/length), in stress/length.
    ///
    /// At q = 0, it is the stiffness of the uniform mode (theory.md, section 3): normal entry C11/height, infinite if ν
    /// = 1/2, and zero in directions in which nothing holds the body.
    pub fn stiffness_blocks(&self, q: f64) -> Blocks {
        let q = q.abs();
        if q == 0.0 {
            return self.uniform_compliance().inverse_diagonal();
        }
        if self.table.is_some() {
            return UNKNOWN;
        }
        if self.second.is_some() {
            return self.compliance_blocks(q).inverse_hermitian();
        }
        let Height::Finite(height) = self.height else { return half_space::stiffness(&self.material, q) };
        LayerMode::new(&self.material, height, q).stiffness_on(&self.base)
    }

    /// Returns the compliance in the frame of a wave vector of length `q` (rad/length), in length/stress, the inverse
    /// of [`Self::stiffness_blocks`]. At q = 0, it is infinite in directions in which nothing holds the body.
    pub fn compliance_blocks(&self, q: f64) -> Blocks {
        let q = q.abs();
        if q == 0.0 {
            return self.uniform_compliance();
        }
        if self.table.is_some() {
            return UNKNOWN;
        }
        let first = match self.height {
            Height::Finite(height) => LayerMode::new(&self.material, height, q).compliance_on(&self.base),
            Height::Infinite => half_space::compliance(&self.material, q),
        };
        self.second.as_ref().map_or(first, |second| first.plus(&second.compliance_blocks(q).mirrored()))
    }

    /// Returns the basis of all states of the surface at q > 0.
    pub(crate) fn basis(&self, q: f64) -> Basis {
        match self.height {
            Height::Finite(height) => LayerMode::new(&self.material, height, q).basis_on(&self.base),
            Height::Infinite => Basis::of_stiffness(half_space::stiffness(&self.material, q)),
        }
    }

    fn uniform_compliance(&self) -> Blocks {
        let first = self.first_uniform_compliance();
        self.second.as_ref().map_or(first, |second| first.plus(&second.uniform_compliance()))
    }

    /// Returns the compliance at q = 0 of the first body of a pair.
    pub(crate) fn first_uniform_compliance(&self) -> Blocks {
        match self.height {
            Height::Finite(height) => uniform_compliance(&self.material, height, &self.base),
            Height::Infinite => Blocks::diagonal(f64::INFINITY, f64::INFINITY),
        }
    }

    /// Returns the compliance of the uniform mode relative to the reference level, in length/stress: lateral and normal
    /// (theory.md, section 4.1).
    ///
    /// It is the compliance of all slabs and layers in series, Σ h/C44 and Σ h/C11. The reference is the base, or the
    /// mean level of a half-space at the bottom, which adds nothing. On a base that does not hold the body, a uniform
    /// traction balances the mean traction. On a bonded base, the result is the compliance at q = 0.
    pub fn level_compliance(&self) -> [f64; 2] {
        let first = self.first_level_compliance();
        self.second.as_ref().map_or(first, |second| plus(first, second.level_compliance()))
    }

    /// Returns the [`level_compliance`](Self::level_compliance) of the first body of a pair.
    pub(crate) fn first_level_compliance(&self) -> [f64; 2] {
        if let Some(table) = &self.table {
            return [f64::NAN, table.uniform];
        }
        let Height::Finite(height) = self.height else { return [0.0; 2] };
        let layer = [height / self.material.shear_modulus(), height * self.material.p_wave_compliance()];
        if let Base::Elastic(below) = &self.base { plus(layer, below.level_compliance()) } else { layer }
    }

    /// Returns the stiffness K of the wave vector `q` (rad/length), in stress/length; see [`Self::stiffness_blocks`].
    pub fn stiffness(&self, q: [f64; 2]) -> Matrix3 {
        on_axes(q, |q| self.stiffness_blocks(q))
    }

    /// Returns the compliance G = K⁻¹ of the wave vector `q` (rad/length), in length/stress.
    pub fn compliance(&self, q: [f64; 2]) -> Matrix3 {
        on_axes(q, |q| self.compliance_blocks(q))
    }

    /// Returns the stiffness of a mode of a grid. Unlike in [`Self::stiffness`], entries odd in a Nyquist component are
    /// zero, so that real fields remain real (theory.md, section 0).
    pub fn stiffness_of(&self, mode: &Mode) -> Matrix3 {
        let mut matrix = self.stiffness(wavevector(mode));
        average_aliases(&mut matrix, &VECTOR_ROWS, mode.nyquist);
        matrix
    }

    /// Returns the compliance of a mode of a grid: the inverse of [`Self::stiffness_of`].
    pub fn compliance_of(&self, mode: &Mode) -> Matrix3 {
        match mode.nyquist {
            [false, false] => self.compliance(wavevector(mode)),
            nyquist => inverse_of_nyquist(self.stiffness_of(mode), nyquist),
        }
    }

    /// Returns the plane-strain stiffness on (x, z) of the wave vector `q` along x (either sign), in stress/length.
    pub fn plane_stiffness(&self, q: f64) -> Matrix2 {
        self.stiffness_blocks(q).plane(q.signum())
    }

    /// Returns the plane-strain compliance on (x, z) of the wave vector `q` along x (either sign), in length/stress.
    pub fn plane_compliance(&self, q: f64) -> Matrix2 {
        self.compliance_blocks(q).plane(q.signum())
    }

    /// Returns the frictionless normal compliance G_zz = u_z/t_z of the wavenumber `q` (rad/length), in length/stress,
    /// without shear traction on the surface (theory.md, section 3). It is 2/(E* q) for a half-space. At q = 0, it is
    /// height/C11 for a slab on a rigid base (0 if ν = 1/2), and infinite for a half-space or a free plate. It is NaN
    /// if it depends on the direction: [`normal_compliance_along`](Self::normal_compliance_along).
    #[inline]
    pub fn normal_compliance(&self, q: f64) -> f64 {
        let q = q.abs();
        if q == 0.0 {
            return self.uniform_compliance().normal;
        }
        if let Some(table) = &self.table {
            return if table.is_isotropic() { table.compliance([q, 0.0]) } else { f64::NAN };
        }
        let first = match self.height {
            Height::Infinite => half_space::normal_compliance(&self.material, q),
            Height::Finite(height) => {
                let layer = LayerMode::new(&self.material, height, q);
                match &self.base {
                    Base::Rigid(ground) => layer.normal_compliance_over(*ground),
                    Base::Elastic(_) => layer.compliance_on(&self.base).normal,
                }
            }
        };
        match &self.second {
            None => first,
            Some(second) => first + second.normal_compliance(q),
        }
    }

    /// Returns the frictionless normal stiffness 1/G_zz of the wavenumber `q` (rad/length), in stress/length; E* q/2
    /// for a half-space. At q = 0, it is C11/height for a slab on a rigid base (infinite if ν = 1/2), and 0 for a
    /// half-space or a free plate.
    #[inline]
    pub fn normal_stiffness(&self, q: f64) -> f64 {
        1.0 / self.normal_compliance(q)
    }

    /// Returns the [`normal_compliance`](Self::normal_compliance) of the wave vector `q` (rad/length).
    #[inline]
    pub fn normal_compliance_along(&self, q: [f64; 2]) -> f64 {
        match &self.table {
            Some(table) if !table.is_isotropic() && q != [0.0; 2] => table.compliance(q),
            _ => self.normal_compliance(q[0].hypot(q[1])),
        }
    }

    /// Returns the frictionless normal stiffness of a mode of a grid, in stress/length. It is the mean over the aliases
    /// of the mode, which differ if the body is not [isotropic](Self::is_isotropic), so that real fields remain real.
    pub fn normal_stiffness_of(&self, mode: &Mode) -> f64 {
        if mode.is_uniform() || self.is_isotropic() {
            return self.normal_stiffness(if mode.is_uniform() { 0.0 } else { mode.wavenumber() });
        }
        let (sum, count) = mode
            .aliases()
            .fold((0.0, 0.0), |(sum, count), q| (sum + 1.0 / self.normal_compliance_along(q), count + 1.0));
        sum / count
    }

    /// Returns the normal stiffness K_N of the wavenumber `q` (rad/length) of a surface without lateral displacement,
    /// in stress/length (theory.md, section 3).
    pub fn restricted_normal_stiffness(&self, q: f64) -> f64 {
        self.stiffness_blocks(q).normal
    }

    /// Returns the compliance G_TT of the wavenumber `q` (rad/length) to a shear traction across the wave vector
    /// (anti-plane shear), in length/stress: 1/(C44 q) for a half-space and tanh(q height)/(C44 q) for a bonded slab.
    /// At q = 0, it is height/C44, or infinite if the base does not hold the body laterally.
    pub fn transverse_compliance(&self, q: f64) -> f64 {
        self.compliance_blocks(q).transverse
    }

    /// Returns the dimensionless ratio ρ in u_long = −i ρ u_z of the wavenumber `q` (rad/length) without shear traction
    /// on the surface (theory.md, section 3): s for a half-space, 0 at q = 0.
    pub fn lateral_ratio(&self, q: f64) -> f64 {
        if q == 0.0 {
            return 0.0;
        }
        let stiffness = self.stiffness_blocks(q);
        stiffness.coupling[0] / stiffness.longitudinal
    }

    /// Returns the factors (f_x, f_y) = −i ρ q/|q| in (u_x, u_y) = (f_x, f_y) u_z of a mode of a grid, without shear
    /// traction on the surface. They are zero at q = 0 and along a Nyquist direction (theory.md, section 3).
    pub fn lateral_displacement(&self, mode: &Mode) -> [Complex64; 2] {
        let Some((direction, q)) = direction(wavevector(mode)) else { return [Complex64::ZERO; 2] };
        let ratio = self.lateral_ratio(q);
        [0, 1].map(|axis| {
            let factor = if mode.nyquist[axis] { 0.0 } else { -ratio * direction[axis] };
            Complex64::new(0.0, factor)
        })
    }
}

pub(crate) fn plus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

/// Returns the compliance of the uniform mode: layers in series (theory.md, section 3).
pub(crate) fn uniform_compliance(material: &Material, height: f64, base: &Base) -> Blocks {
    let (lateral, normal) = (height / material.shear_modulus(), height * material.p_wave_compliance());
    match base {
        Base::Rigid(ground) => {
            let over = |condition: Condition, compliance: f64| match condition {
                Condition::Fixed => compliance,
                Condition::Free => f64::INFINITY,
            };
            Blocks::diagonal(over(ground.lateral, lateral), over(ground.normal, normal))
        }
        Base::Elastic(below) => {
            let below = below.uniform_compliance();
            Blocks::diagonal(lateral + below.transverse, normal + below.normal)
        }
    }
}

/// Returns the wave vector of a mode, exactly zero for the uniform mode, which is identified by its indices.
pub(crate) fn wavevector(mode: &Mode) -> [f64; 2] {
    if mode.is_uniform() { [0.0; 2] } else { mode.wavevector }
}

/// Evaluates `blocks` at |q| and rotates the result to the axes x, y, z.
pub(crate) fn on_axes(q: [f64; 2], blocks: impl Fn(f64) -> Blocks) -> Matrix3 {
    match direction(q) {
        Some((direction, wavenumber)) => blocks(wavenumber).rotated(direction),
        None => {
            // The uniform mode has no direction, and rotating would multiply an infinite entry by zero.
            let uniform = blocks(0.0);
            let mut matrix = [[Complex64::ZERO; 3]; 3];
            for (axis, value) in [uniform.transverse, uniform.transverse, uniform.normal].into_iter().enumerate() {
                matrix[axis][axis] = Complex64::new(value, 0.0);
            }
            matrix
        }
    }
}

/// Returns the inverse of a Hermitian matrix with a decoupled Nyquist axis; the other lateral axis may couple to z.
fn inverse_of_nyquist(matrix: Matrix3, nyquist: [bool; 2]) -> Matrix3 {
    let (alone, other) = if nyquist[0] { (0, 1) } else { (1, 0) };
    let block =
        Blocks::hermitian(matrix[other][other].re, matrix[other][2].im, matrix[2][2].re, matrix[alone][alone].re)
            .inverse_hermitian();
    let mut inverse = [[Complex64::ZERO; 3]; 3];
    inverse[alone][alone] = Complex64::new(block.transverse, 0.0);
    inverse[other][other] = Complex64::new(block.longitudinal, 0.0);
    inverse[2][2] = Complex64::new(block.normal, 0.0);
    inverse[other][2] = Complex64::new(0.0, block.coupling[0]);
    inverse[2][other] = Complex64::new(0.0, block.coupling[1]);
    inverse
}
