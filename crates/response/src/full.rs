use gfmd_field::{Grid, Mode, Share};
use gfmd_green::{Body, GreenError, Matrix3, stiffness_range};
use gfmd_vector::add;

use crate::free_full::padded_compliance;
use crate::normal::LEAST_COMPLIANCE;
use crate::units::Scaled;
use crate::{Components, Hermitian, Operator, Workspace};

/// Response of a body on one grid for all components of its surface: planned transforms, and the stiffness and
/// compliance matrix of every mode. Built once and shared between problems and threads. Each process has the modes of
/// its own lanes ([`Transform::lanes`](gfmd_field::Transform::lanes)) and transforms its own rows.
///
/// The uniform mode q = 0 is relative to the reference level of [`Body::level_compliance`]. For a component without
/// compliance (half-space; u_z of an incompressible slab), the stiffness is set to zero as well: its mean displacement
/// does not depend on the mean traction.
#[derive(Debug)]
pub struct FullResponse {
    stiffness: Operator,
    compliance: Operator,
    uniform_compliance: [f64; 3],
    stiffness_range: [f64; 2],
    body: Body,
}

impl FullResponse {
    /// Tabulates the response of `body` on `grid`.
    pub fn new(grid: Grid, body: &Body) -> Self {
        Self::distributed(grid, body, &grid.whole())
    }

    /// Tabulates the response of `body` on `grid` for the `share` of rows of this process.
    pub fn distributed(grid: Grid, body: &Body, share: &Share) -> Self {
        let scaled = Scaled::new(body, &grid);
        let unit = scaled.stiffness;
        let [lateral, normal] = scaled.body.level_compliance();
        let uniform = Hermitian { xx: lateral, yy: lateral, zz: normal, xy: 0.0, xz: 0.0, yz: 0.0 };
        let of_mode = |mode: &Mode, uniform: Hermitian, matrix: fn(&Body, &Mode) -> Matrix3| {
            if mode.is_uniform() { uniform } else { Hermitian::of(&matrix(&scaled.body, &scaled.mode(mode))) }
        };
        let compliance =
            Operator::distributed(grid, share, |mode| of_mode(mode, uniform, Body::compliance_of).map(|g| g / unit));
        let resistance = uniform.map(|g| if g > 0.0 { 1.0 / g } else { 0.0 });
        let stiffness = compliance.beside(|mode| of_mode(mode, resistance, Body::stiffness_of).map(|k| k * unit));
        let Hermitian { xx, yy, zz, .. } = uniform.map(|g| g / unit);
        let range = stiffness_range(&scaled.body, &scaled.grid(&grid));
        Self {
            stiffness,
            compliance,
            uniform_compliance: [xx, yy, zz],
            stiffness_range: range.map_or([0.0; 2], |range| [range.softest * unit, range.stiffest * unit]),
            body: body.clone(),
        }
    }

    /// Returns the compliance of a mode other than the uniform one, with the bits of the table.
    pub(crate) fn compliance_of_mode(body: &Body, grid: &Grid, mode: &Mode) -> Hermitian {
        let scaled = Scaled::new(body, grid);
        Hermitian::of(&scaled.body.compliance_of(&scaled.mode(mode))).map(|g| g / scaled.stiffness)
    }

    /// Tabulates the response of a non-periodic patch (theory.md, section 3.1) on its [padded](Grid::padded) grid: if
    /// the traction vanishes outside the patch, the displacement inside is relative to a surface at rest far away. The
    /// compliance is the transform of the compliance between two cells, and positive definite for every mode, including
    /// the uniform one. For a Poisson's ratio well below 0 this takes a grid with three times the points of the patch.
    ///
    /// # Errors
    /// Returns an error for a profile, a plate or a body that slides on its base ([`gfmd_green::patch_matrix`]), if the
    /// patch cannot be padded, or if a mode is not positive definite.
    pub fn of_patch(patch: &Grid, body: &Body) -> Result<Self, GreenError> {
        Self::of_patch_over(&patch.whole(), patch, body)
    }

    /// Tabulates the response as [`of_patch`](Self::of_patch) for the processes of a `share`, which also share the rows
    /// of the padded grid.
    ///
    /// # Errors
    /// Returns an error as [`of_patch`](Self::of_patch), and if the processes cannot share the padded grid.
    pub fn of_patch_over(share: &Share, patch: &Grid, body: &Body) -> Result<Self, GreenError> {
        match Self::of_padded(2, share, patch, body) {
            Err(GreenError::PatchStiffness { .. }) => Self::of_padded(3, share, patch, body),
            found => found,
        }
    }

    fn of_padded(times: usize, share: &Share, patch: &Grid, body: &Body) -> Result<Self, GreenError> {
        let (transform, share, matrices) = padded_compliance(times, share, patch, body)?;
        let compliance = Operator::of_matrices(transform, &share, matrices).map(|mode, matrix| {
            let even = |is_odd: bool, entry: f64| if is_odd || mode.is_uniform() { 0.0 } else { entry };
            let ([x, y], Hermitian { xy, xz, yz, .. }) = (mode.nyquist, matrix);
            Hermitian { xy: even(x || y, xy), xz: even(x, xz), yz: even(y, yz), ..matrix }
        });
        let eigenvalues = compliance.matrices().iter().flat_map(|matrix| matrix.modes().map(|(value, _)| value));
        let wider = |[least, most]: [f64; 2], [low, high]: [f64; 2]| {
            [if low >= least { least } else { low }, f64::max(most, high)]
        };
        let none = [f64::INFINITY, 0.0];
        let own = eigenvalues.fold(none, |range, value| wider(range, [value; 2]));
        let [stiffest, softest] = share.each(own).into_iter().fold(none, wider);
        // A smaller eigenvalue would be a rounding error of the largest.
        let is_resolved = stiffest > LEAST_COMPLIANCE * softest;
        if !is_resolved {
            return Err(GreenError::PatchStiffness { least: stiffest, largest: softest });
        }
        // The uniform mode is identified by its index, the first, never by a small wavenumber.
        let uniform = match compliance.matrices().first() {
            Some(matrix) if compliance.first() == 0 => [matrix.xx, matrix.yy, matrix.zz],
            _ => [0.0; 3],
        };
        let uniform_compliance = share.each(uniform).into_iter().fold([0.0; 3], add);
        Ok(Self {
            stiffness: compliance.map(|_, matrix| matrix.inverse()),
            compliance,
            uniform_compliance,
            stiffness_range: [1.0 / softest, 1.0 / stiffest],
            body: body.clone(),
        })
    }

    /// Returns the body.
    pub(crate) fn body(&self) -> &Body {
        &self.body
    }

    /// Returns the grid of the surface.
    pub fn grid(&self) -> &Grid {
        self.stiffness.grid()
    }

    /// Returns the rows of this process; a single process has all rows.
    pub fn share(&self) -> &Share {
        self.compliance.share()
    }

    /// Returns the components of displacement and traction.
    pub fn components(&self) -> Components {
        self.stiffness.components()
    }

    /// Returns the stiffness K: traction (stress) from displacement (length).
    pub fn stiffness(&self) -> &Operator {
        &self.stiffness
    }

    /// Returns the compliance G: displacement (length) from traction (stress).
    pub fn compliance(&self) -> &Operator {
        &self.compliance
    }

    /// Allocates memory for the operators on this grid, for the number of threads of the current rayon pool.
    pub fn workspace(&self) -> Workspace {
        self.stiffness.workspace()
    }

    /// Returns G_xx(0), G_yy(0), G_zz(0) in length/stress; 0 where the mean displacement ignores the mean traction.
    pub fn uniform_compliance(&self) -> [f64; 3] {
        self.uniform_compliance
    }

    /// Returns 1/G_xx(0), 1/G_yy(0), 1/G_zz(0) in stress/length; infinite where the mean displacement does not depend
    /// on the mean traction.
    pub fn uniform_stiffness(&self) -> [f64; 3] {
        self.uniform_compliance.map(f64::recip)
    }

    /// Returns E* of the body, in stress; 1/(1/E₁* + 1/E₂*) for two bodies.
    pub fn contact_modulus(&self) -> f64 {
        self.body.contact_modulus()
    }

    /// Returns the smallest and largest stiffness eigenvalue over all modes, in stress/length, without zero and
    /// infinite eigenvalues; zeros if there are no others.
    pub fn stiffness_range(&self) -> [f64; 2] {
        self.stiffness_range
    }
}
