use gfmd_field::{Grid, Mode, ShapeError, Transform};
use gfmd_green::{Body, Complex64, Condition, Ground, Matrix3};
use gfmd_response::Components;

use crate::InteriorError;
use crate::interior::check_finite;

/// Displacement or traction prescribed on the base of a body, as fields on the grid of its surface: x, y, z, or x, z on
/// a line, component after component.
#[derive(Clone, Debug, PartialEq)]
pub enum BaseField {
    /// Displacement (length) of a base that fixes u_z: bonded, or sliding with zero lateral components.
    Displacement(Vec<f64>),
    /// Traction (stress) on the lower face of a plate. Its mean must be zero, since the mean traction balances the load
    /// (theory.md, section 4.2).
    Traction(Vec<f64>),
}

impl BaseField {
    /// Computes the displacement (length) of the traction-free surface of `body` caused by this base, component after
    /// component. Add it to the displacement under a load with the base at rest.
    ///
    /// By reciprocity, w = (Σ G)† u_b, where Σ G is the traction σ_xz, σ_yz, σ_zz on the base at rest per surface
    /// traction, and w = (T G)† t_b, where T G is the displacement of the lower face (theory.md, section 4.2). For a
    /// [pair](Body::against) of bodies it is the base of the first body.
    ///
    /// # Errors
    /// Returns an error if the body has no such base, or if the field has the wrong length, is not finite, has a mean
    /// traction, or moves a sliding base laterally.
    pub fn surface_displacement(&self, body: &Body, grid: Grid) -> Result<Vec<f64>, InteriorError> {
        self.displacement_of(body, grid, |_, found| found)
    }

    /// Computes the displacement (length) of a surface of `body` without normal traction that is held sideways, as
    /// [`surface_displacement`](Self::surface_displacement): its lateral components are zero.
    ///
    /// The shear traction that moves the free surface back changes u_z by K_zz⁻¹ K_zt u_t, with the stiffness K of the
    /// wave.
    ///
    /// # Errors
    /// Returns an error as [`surface_displacement`](Self::surface_displacement).
    pub fn held_displacement(&self, body: &Body, grid: Grid) -> Result<Vec<f64>, InteriorError> {
        let alone = body.alone();
        self.displacement_of(body, grid, |mode, [x, y, z]| {
            if mode.is_uniform() {
                return [Complex64::ZERO, Complex64::ZERO, z];
            }
            let [.., [zx, zy, zz]] = alone.stiffness_of(mode);
            [Complex64::ZERO, Complex64::ZERO, z + (zx * x + zy * y) / zz]
        })
    }

    /// Computes the displacement of the surface, wave by wave, as `of_wave` makes it from the displacement of the
    /// traction-free surface.
    fn displacement_of(
        &self,
        body: &Body,
        grid: Grid,
        of_wave: impl Fn(&Mode, [Complex64; 3]) -> [Complex64; 3],
    ) -> Result<Vec<f64>, InteriorError> {
        let body = body.alone();
        let (field, ground) = self.check(&body, &grid)?;
        let (components, points) = (Components::of(&grid), grid.len());
        let transform = Transform::new(grid);
        let mut memory = transform.workspace();
        let mut spectra = [const { Vec::new() }; 3];
        for (&axis, component) in components.axes().iter().zip(field.chunks_exact(points)) {
            spectra[axis] = vec![Complex64::ZERO; grid.spectrum_len()];
            transform.forward(component, &mut spectra[axis], &mut memory)?;
        }
        let base = body.at_depth(body.total_height())?;
        for index in 0..grid.spectrum_len() {
            let mode = grid.mode_at(index);
            // A line has no component along y.
            let at = |axis: usize| spectra[axis].get(index).copied().unwrap_or_default();
            let given = [at(0), at(1), at(2)];
            let found = if mode.is_uniform() {
                // A uniform displacement of the base moves the whole body.
                match self {
                    Self::Displacement(_) => given,
                    Self::Traction(_) => [Complex64::ZERO; 3],
                }
            } else {
                let below: Matrix3 = match self {
                    Self::Displacement(_) => {
                        let [.., zz, yz, xz] = base.continuous_transfer_of(&mode);
                        match ground.lateral {
                            Condition::Fixed => [xz, yz, zz],
                            Condition::Free => [[Complex64::ZERO; 3], [Complex64::ZERO; 3], zz],
                        }
                    }
                    Self::Traction(_) => base.displacement_transfer_of(&mode),
                };
                reversed(&below, &body.compliance_of(&mode), given)
            };
            let found = of_wave(&mode, found);
            for &axis in components.axes() {
                spectra[axis][index] = found[axis];
            }
        }
        let mut lifted = vec![0.0; field.len()];
        for (&axis, component) in components.axes().iter().zip(lifted.chunks_exact_mut(points)) {
            transform.inverse(&spectra[axis], component, &mut memory)?;
        }
        Ok(lifted)
    }

    fn check(&self, body: &Body, grid: &Grid) -> Result<(&[f64], Ground), InteriorError> {
        let (field, ground) = match (self, body.ground()) {
            (Self::Displacement(field), Some(ground)) if ground.normal == Condition::Fixed => (field, ground),
            (Self::Displacement(_), _) => {
                return Err(InteriorError::Base {
                    given: "displacement",
                    allowed: "layers on a bonded or sliding base",
                });
            }
            (Self::Traction(field), Some(Ground::NONE)) => (field, Ground::NONE),
            (Self::Traction(_), _) => {
                return Err(InteriorError::Base { given: "traction", allowed: "a plate, whose base is free" });
            }
        };
        let (points, expected) = (grid.len(), Components::of(grid).len() * grid.len());
        if field.len() != expected {
            return Err(ShapeError { what: "field of the base", found: field.len(), expected }.into());
        }
        check_finite(field)?;
        let largest = field.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        if matches!(self, Self::Traction(_)) {
            for component in field.chunks_exact(points) {
                let mean = component.iter().sum::<f64>() / points as f64;
                if mean.abs() > 1e-12 * largest {
                    return Err(InteriorError::MeanTraction { found: mean });
                }
            }
        }
        if matches!(self, Self::Displacement(_))
            && ground.lateral == Condition::Free
            && let Some(index) = field[..expected - points].iter().position(|value| *value != 0.0)
        {
            return Err(InteriorError::Sideways { found: field[index], index });
        }
        Ok((field, ground))
    }
}

/// Computes (A G)† v.
fn reversed(a: &Matrix3, g: &Matrix3, v: [Complex64; 3]) -> [Complex64; 3] {
    let inner: [Complex64; 3] = std::array::from_fn(|k| (0..3).map(|row| a[row][k].conj() * v[row]).sum());
    std::array::from_fn(|k| (0..3).map(|row| g[row][k].conj() * inner[row]).sum())
}
