use std::fmt;

use gfmd_field::{Grid, Mode, ShapeError, Transform};
use gfmd_green::{Base, Body, Complex64, GreenError, Height, Section};
use gfmd_response::Components;
use rayon::prelude::*;

use crate::{BaseField, Deformation};

/// Body with a displaced surface: the spectra that determine the fields at every depth.
pub struct Interior {
    body: Body,
    transform: Transform,
    components: Components,
    /// Surface modes ũ_x, ũ_y, ũ_z; ũ_y is zero on a line.
    surface: [Vec<Complex64>; 3],
    /// Nyquist modes ũ_z of a surface without shear traction, with their indices in the half spectrum, in ascending
    /// order. They are stored separately, since their lateral displacement vanishes only at the grid points.
    nyquist: Vec<(usize, Complex64)>,
    /// Mean of σ_xz, σ_yz, σ_zz, if it was given.
    mean_traction: Option<[f64; 3]>,
    /// Modes of the base displacement, laid out as for the surface; `None` if the base is at rest.
    base: Option<[Vec<Complex64>; 3]>,
}

/// Working memory of one caller, created by [`Interior::workspace`]: six fields, their spectra, and the workspace of a
/// transform. The calls themselves allocate nothing.
pub struct Workspace {
    transform: gfmd_field::Workspace,
    spectra: [Vec<Complex64>; 6],
    fields: Vec<f64>,
}

/// Error in the computation of interior fields.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum InteriorError {
    /// Field or workspace of another grid.
    #[error(transparent)]
    Shape(#[from] ShapeError),
    /// Depth outside the body.
    #[error(transparent)]
    Place(#[from] GreenError),
    /// Value that is NaN or infinite.
    #[error("the value is {found} at index {index}; it must be finite")]
    NotFinite {
        /// Given value.
        found: f64,
        /// Index of the first such value.
        index: usize,
    },
    /// Field that does not match the base of the body.
    #[error("the {given} of the base is given; the body must be {allowed}")]
    Base {
        /// Kind of the given field.
        given: &'static str,
        /// Bodies that accept such a field.
        allowed: &'static str,
    },
    /// Mean traction on the lower face of a plate.
    #[error(
        "the mean traction on the lower face is {found}; it must be zero, since the mean is borne against the load"
    )]
    MeanTraction {
        /// Mean of a component.
        found: f64,
    },
    /// Mean traction of the surface that contradicts its mean displacement.
    #[error(
        "the mean traction along {axis} is {found}; it must be {expected}, which the mean displacement of the surface \
         says"
    )]
    Contradiction {
        /// Component: x, y or z.
        axis: char,
        /// Given mean traction.
        found: f64,
        /// Mean traction that matches the mean displacement.
        expected: f64,
    },
    /// Lateral displacement of a frictionless base.
    #[error("the lateral displacement of the sliding base is {found} at index {index}; it must be zero")]
    Sideways {
        /// Given value.
        found: f64,
        /// Index of the first such value.
        index: usize,
    },
    /// Mean normal displacement of incompressible layers, which would change their volume.
    #[error("the mean of u_z is {found}; it must be zero on incompressible layers")]
    Volume {
        /// Mean of u_z.
        found: f64,
    },
}

impl Interior {
    /// Creates the interior below a surface displacement (length), given component after component: x, y, z, or x, z on
    /// a line. For a [pair](Body::against) of bodies it is the relative displacement, and the interior belongs to the
    /// first body under its part of the displacement.
    ///
    /// The mean displacement is measured relative to the reference level of [`Body::level_compliance`]: it strains
    /// slabs and layers, and a half-space moves with it.
    ///
    /// The mean traction follows from the mean displacement where the body has a uniform stiffness. Where it has none
    /// (on a half-space, and along z on incompressible layers) the mean traction is zero, unless
    /// [`with_mean_traction`](Self::with_mean_traction) sets it (theory.md, section 5). The mean of u_z must vanish if
    /// all layers are incompressible.
    ///
    /// # Errors
    /// Returns an error if the displacement has the wrong length or is not finite, or if it would change the volume of
    /// incompressible layers.
    pub fn new(body: &Body, grid: Grid, displacement: &[f64]) -> Result<Self, InteriorError> {
        let mut interior = Self::at_rest(body, grid);
        let (axes, points) = (interior.components.axes(), grid.len());
        interior.check("displacement", displacement, axes.len() * points)?;
        let mut ws = interior.transform.workspace();
        for (&axis, component) in axes.iter().zip(displacement.chunks_exact(points)) {
            interior.transform.forward(component, &mut interior.surface[axis], &mut ws)?;
        }
        interior.keep_volume(body, &displacement[interior.components.normal() * points..])?;
        if body.second().is_some() {
            let alone = interior.body.clone();
            interior.share(body, |mode, u| apply(&alone.compliance_of(mode), apply(&body.stiffness_of(mode), u)));
        }
        Ok(interior)
    }

    /// Creates the interior below the normal displacement (length) of a surface without shear traction. The lateral
    /// displacement follows from it (theory.md, section 3).
    ///
    /// # Errors
    /// Returns an error if the displacement has the wrong length or is not finite, or if it would change the volume of
    /// incompressible layers.
    pub fn frictionless(body: &Body, grid: Grid, normal: &[f64]) -> Result<Self, InteriorError> {
        let mut interior = Self::at_rest(body, grid);
        interior.check("displacement", normal, grid.len())?;
        {
            let Self { transform, surface: [_, _, z], .. } = &mut interior;
            transform.forward(normal, z, &mut transform.workspace())?;
        }
        interior.keep_volume(body, normal)?;
        if body.second().is_some() {
            let alone = interior.body.clone();
            let share = |q: f64| alone.normal_compliance(q) / body.normal_compliance(q);
            interior.share(body, |mode, [x, y, z]| [x, y, z * share(mode.wavenumber())]);
        }
        Ok(interior.without_shear())
    }

    /// Creates the interior below a pressure (stress, positive in compression) on a surface without shear traction. For
    /// a [pair](Body::against) of bodies, the interior belongs to the first body.
    ///
    /// The mean displacement follows from [`Body::level_compliance`].
    ///
    /// # Errors
    /// Returns an error if the pressure has the wrong length or is not finite.
    pub fn of_pressure(body: &Body, grid: Grid, pressure: &[f64]) -> Result<Self, InteriorError> {
        let mut interior = Self::at_rest(body, grid);
        interior.check("pressure", pressure, grid.len())?;
        let compliance = interior.uniform_compliance()[2];
        let Self { body, transform, surface: [_, _, z], .. } = &mut interior;
        transform.forward(pressure, z, &mut transform.workspace())?;
        let mean = z[0].re;
        z.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(index, z)| {
            let mode = grid.mode_at(index);
            *z *= -if mode.is_uniform() { compliance } else { body.normal_compliance(mode.wavenumber()) };
        });
        interior.mean_traction = Some([0.0, 0.0, -mean]);
        Ok(interior.without_shear())
    }

    /// Adds the lateral displacement of a surface without shear traction to its normal displacement.
    fn without_shear(mut self) -> Self {
        let grid = *self.grid();
        let Self { body, surface: [x, y, z], .. } = &mut self;
        let set_apart = (x, y, z).into_par_iter().enumerate().with_min_len(CHUNK).filter_map(|(index, (x, y, z))| {
            let mode = grid.mode_at(index);
            if mode.nyquist != [false; 2] {
                return Some((index, std::mem::take(z)));
            }
            [*x, *y] = body.lateral_displacement(&mode).map(|factor| factor * *z);
            None
        });
        self.nyquist = set_apart.collect();
        self
    }

    /// Creates the interior below a surface traction (stress), given component after component: σ_xz, σ_yz, σ_zz, or
    /// σ_xz, σ_zz on a line. For a [pair](Body::against) of bodies, both the traction and the interior belong to the
    /// first body.
    ///
    /// The mean displacement follows from [`Body::level_compliance`].
    ///
    /// # Errors
    /// Returns an error if the traction has the wrong length or is not finite.
    pub fn of_traction(body: &Body, grid: Grid, traction: &[f64]) -> Result<Self, InteriorError> {
        let mut interior = Self::at_rest(body, grid);
        let (axes, points) = (interior.components.axes(), grid.len());
        interior.check("traction", traction, axes.len() * points)?;
        let mut ws = interior.transform.workspace();
        for (&axis, component) in axes.iter().zip(traction.chunks_exact(points)) {
            interior.transform.forward(component, &mut interior.surface[axis], &mut ws)?;
        }
        let mean = interior.surface.each_ref().map(|spectrum| spectrum[0].re);
        let compliance = interior.uniform_compliance();
        let Self { body, surface: [x, y, z], .. } = &mut interior;
        (x, y, z).into_par_iter().enumerate().with_min_len(CHUNK).for_each(|(index, (x, y, z))| {
            let (mode, t) = (grid.mode_at(index), [*x, *y, *z]);
            [*x, *y, *z] = match mode.is_uniform() {
                true => [0, 1, 2].map(|axis| t[axis] * compliance[axis]),
                false => apply(&body.compliance_of(&mode), t),
            };
        });
        interior.mean_traction = Some(mean);
        Ok(interior)
    }

    /// Sets the mean surface traction σ_xz, σ_yz, σ_zz (stress; −p along z for a mean pressure p), for bodies in which
    /// the mean displacement does not determine it: half-spaces, and incompressible layers along z. These stresses have
    /// the same mean at every depth. Since the mean lateral strain is zero, the traction causes a uniform strain along
    /// z in every layer, and a displacement linear in depth in a half-space (theory.md, section 5).
    ///
    /// # Errors
    /// Returns an error if a value is not finite, or contradicts the mean displacement of layers by more than a tenth.
    pub fn with_mean_traction(mut self, traction: [f64; 3]) -> Result<Self, InteriorError> {
        check_finite(&traction)?;
        let compliance = self.uniform_compliance();
        let largest = |spectrum: &[Complex64]| spectrum.iter().fold(0.0, |most: f64, u| most.max(u.norm()));
        for &axis in self.components.axes() {
            let (found, expected) = (compliance[axis] * traction[axis], self.surface[axis][0].re);
            let scale = found.abs().max(expected.abs());
            let difference = (found - expected).abs();
            let differ = difference.is_nan() || difference > CONTRADICTION * scale;
            if compliance[axis] > 0.0 && differ && scale > UNCERTAIN * largest(&self.surface[axis]) {
                let (found, expected) = (traction[axis], expected / compliance[axis]);
                return Err(InteriorError::Contradiction { axis: ['x', 'y', 'z'][axis], found, expected });
            }
        }
        self.mean_traction = Some(traction);
        Ok(self)
    }

    /// Returns the mean of σ_xz, σ_yz, σ_zz, in stress, which is the same at every depth.
    pub fn mean_traction(&self) -> [f64; 3] {
        let compliance = self.uniform_compliance();
        self.mean_traction.unwrap_or_else(|| {
            std::array::from_fn(|axis| {
                let base = self.base.as_ref().map_or(0.0, |base| base[axis][0].re);
                let stretch = self.surface[axis][0].re - base;
                if compliance[axis] > 0.0 { stretch * (1.0 / compliance[axis]) } else { 0.0 }
            })
        })
    }

    /// Returns the compliance of the uniform mode along x, y, z, relative to the reference level.
    fn uniform_compliance(&self) -> [f64; 3] {
        let [lateral, normal] = self.body.level_compliance();
        [lateral, lateral, normal]
    }

    fn at_rest(body: &Body, grid: Grid) -> Self {
        let surface = std::array::from_fn(|_| vec![Complex64::ZERO; grid.spectrum_len()]);
        Self {
            body: body.alone(),
            transform: Transform::new(grid),
            components: Components::of(&grid),
            surface,
            nyquist: Vec::new(),
            mean_traction: None,
            base: None,
        }
    }

    /// Moves the base of one slab on a bonded base by `displacement` (length), component after component, while the
    /// surface keeps its displacement. The field is the sum of two fields: the slab with its base at rest, and the slab
    /// upside down with its surface at rest (theory.md, section 5).
    ///
    /// # Errors
    /// Returns an error for any other body, or if the displacement has the wrong length or is not finite.
    pub fn with_base(mut self, displacement: &[f64]) -> Result<Self, InteriorError> {
        if *self.body.base() != Base::BONDED || self.body.height() == Height::Infinite {
            return Err(InteriorError::Base { given: "displacement", allowed: "one slab on a bonded base" });
        }
        let points = self.grid().len();
        self.check("displacement", displacement, self.components.len() * points)?;
        let mut spectra: [Vec<Complex64>; 3] = std::array::from_fn(|_| vec![Complex64::ZERO; self.surface[0].len()]);
        let mut ws = self.transform.workspace();
        for (&axis, component) in self.components.axes().iter().zip(displacement.chunks_exact(points)) {
            self.transform.forward(component, &mut spectra[axis], &mut ws)?;
        }
        self.base = Some(spectra);
        Ok(self)
    }

    /// Adds the field of a base that moves by `displacement` (length) below a traction-free surface, which moves as
    /// well; for one slab on a bonded base (theory.md, section 4.2).
    ///
    /// # Errors
    /// Returns an error for any other body, or if the displacement has the wrong length or is not finite.
    pub fn over_base(mut self, displacement: &[f64]) -> Result<Self, InteriorError> {
        let grid = *self.grid();
        let lifted = BaseField::Displacement(displacement.to_vec()).surface_displacement(&self.body, grid)?;
        let mut ws = self.transform.workspace();
        let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
        for (&axis, component) in self.components.axes().iter().zip(lifted.chunks_exact(grid.len())) {
            self.transform.forward(component, &mut spectrum, &mut ws)?;
            self.surface[axis].iter_mut().zip(&spectrum).for_each(|(sum, added)| *sum += added);
        }
        self.with_base(displacement)
    }

    /// Returns the plane at `depth` of the body upside down; `None` if the base is at rest.
    fn upside_down(&self, depth: f64) -> Result<Option<Section<'_>>, InteriorError> {
        Ok(match &self.base {
            Some(_) => Some(self.body.at_depth(self.body.total_height() - depth)?.against_level()),
            None => None,
        })
    }

    /// Returns mode `index` of the base displacement, upside down.
    fn mirrored(&self, index: usize) -> [Complex64; 3] {
        self.base.as_ref().map_or([Complex64::ZERO; 3], |[x, y, z]| [x[index], y[index], -z[index]])
    }

    fn check(&self, what: &'static str, field: &[f64], expected: usize) -> Result<(), InteriorError> {
        if field.len() != expected {
            return Err(ShapeError { what, found: field.len(), expected }.into());
        }
        check_finite(field)
    }

    /// Replaces the relative displacement of a `pair` by the displacement of the first body: by the function `part` at
    /// q ≠ 0, and in proportion to the compliances for the uniform mode.
    fn share(&mut self, pair: &Body, part: impl Fn(&Mode, [Complex64; 3]) -> [Complex64; 3] + Sync) {
        let (own, all) = (self.body.level_compliance(), pair.level_compliance());
        let uniform = [0, 0, 1].map(|axis: usize| if all[axis] > 0.0 { own[axis] / all[axis] } else { 0.0 });
        let grid = *self.grid();
        let [x, y, z] = &mut self.surface;
        (x, y, z).into_par_iter().enumerate().with_min_len(CHUNK).for_each(|(index, (x, y, z))| {
            let (mode, u) = (grid.mode_at(index), [*x, *y, *z]);
            [*x, *y, *z] =
                if mode.is_uniform() { [0, 1, 2].map(|axis| u[axis] * uniform[axis]) } else { part(&mode, u) };
        });
    }

    /// Requires a zero mean of u_z if all layers of the `body` are incompressible, and removes its rounding error.
    fn keep_volume(&mut self, body: &Body, normal: &[f64]) -> Result<(), InteriorError> {
        let is_slab = |body: &Body| body.height() != Height::Infinite;
        if body.level_compliance()[1] > 0.0 || !(is_slab(body) || body.second().is_some_and(is_slab)) {
            return Ok(());
        }
        // The uniform mode is the first; a small wavenumber does not identify it.
        let found = std::mem::take(&mut self.surface[2][0]).re;
        let largest = normal.iter().fold(0.0, |largest: f64, u| largest.max(u.abs()));
        if found.abs() <= ROUNDING_OF_MEAN * largest { Ok(()) } else { Err(InteriorError::Volume { found }) }
    }

    /// Returns the body.
    pub fn body(&self) -> &Body {
        &self.body
    }

    /// Returns the grid of the surface and of every plane below it.
    pub fn grid(&self) -> &Grid {
        self.transform.grid()
    }

    /// Returns the components of displacements.
    pub fn components(&self) -> Components {
        self.components
    }

    /// Allocates memory for any number of depths and for the number of threads of the current rayon pool.
    pub fn workspace(&self) -> Workspace {
        let rows = if self.grid().is_line() { 3 } else { 6 };
        Workspace {
            transform: self.transform.workspace(),
            spectra: std::array::from_fn(|_| vec![Complex64::ZERO; self.grid().spectrum_len()]),
            fields: vec![0.0; rows * self.grid().len()],
        }
    }

    /// Computes the displacement (length) at `depth` (length) below the surface, component after component.
    ///
    /// # Errors
    /// Returns an error if the depth is outside the body, or if the workspace belongs to another grid.
    pub fn displacement<'w>(&self, depth: f64, ws: &'w mut Workspace) -> Result<&'w [f64], InteriorError> {
        self.check_workspace(ws)?;
        let section = self.body.at_depth(depth)?.against_level();
        let base = self.upside_down(depth)?;
        let (grid, amplitude) = (*self.grid(), self.amplitude());
        let linear = self.linear_displacement(&section);
        let [x, y, z, ..] = &mut ws.spectra;
        (x, y, z).into_par_iter().enumerate().with_min_len(CHUNK).for_each(|(index, (x, y, z))| {
            let mode = grid.mode_at(index);
            [*x, *y, *z] = apply(&section.displacement_transfer_of(&mode), amplitude(index));
            if let Some(u) = self.set_apart(index, &mode) {
                let [px, py, pz] = section.frictionless_displacement_of(&mode).map(|entry| entry * u);
                [*x, *y, *z] = [*x + px, *y + py, *z + pz];
            }
            if let Some(section) = &base {
                let [bx, by, bz] = apply(&section.displacement_transfer_of(&mode), self.mirrored(index));
                [*x, *y, *z] = [*x + bx, *y + by, *z - bz];
            }
            if mode.is_uniform() {
                [*x, *y, *z] = [*x + linear[0], *y + linear[1], *z + linear[2]];
            }
        });
        self.synthesise(self.components.axes(), ws)?;
        Ok(&ws.fields[..self.components.len() * self.grid().len()])
    }

    /// Computes strain and stress at `depth` (length) below the surface; at an interface, on its upper side.
    ///
    /// # Errors
    /// As [`Self::displacement`].
    pub fn deformation<'w>(&self, depth: f64, ws: &'w mut Workspace) -> Result<Deformation<'w>, InteriorError> {
        self.deformation_on(self.body.at_depth(depth)?, depth, ws)
    }

    /// Computes the [`deformation`](Self::deformation) at `depth`; at an interface, on its lower side. σ_xx, σ_yy, σ_xy
    /// and the strains along z jump there.
    ///
    /// # Errors
    /// As [`Self::displacement`].
    pub fn deformation_below<'w>(&self, depth: f64, ws: &'w mut Workspace) -> Result<Deformation<'w>, InteriorError> {
        self.deformation_on(self.body.at_depth(depth)?.from_below(), depth, ws)
    }

    fn deformation_on<'w>(
        &self,
        section: Section<'_>,
        depth: f64,
        ws: &'w mut Workspace,
    ) -> Result<Deformation<'w>, InteriorError> {
        self.check_workspace(ws)?;
        let section = section.against_level();
        let base = self.upside_down(depth)?;
        let (grid, amplitude) = (*self.grid(), self.amplitude());
        let mean_traction = self.mean_traction();
        let [a, b, c, d, e, f] = &mut ws.spectra;
        (a, b, c, d, e, f).into_par_iter().enumerate().with_min_len(CHUNK).for_each(|(index, (a, b, c, d, e, f))| {
            let mode = grid.mode_at(index);
            let mut rows = apply(&section.continuous_transfer_of(&mode), amplitude(index));
            if let Some(u) = self.set_apart(index, &mode) {
                let added = section.frictionless_continuous_of(&mode);
                rows.iter_mut().zip(added).for_each(|(row, entry)| *row += entry * u);
            }
            if let Some(section) = &base {
                let added = apply(&section.continuous_transfer_of(&mode), self.mirrored(index));
                // The shear stresses σ_yz and σ_xz change sign upside down.
                for (row, (added, sign)) in rows.iter_mut().zip(added.into_iter().zip([1.0, 1.0, 1.0, 1.0, -1.0, -1.0]))
                {
                    *row += sign * added;
                }
            }
            if mode.is_uniform() {
                // The lateral strain has zero mean.
                let [xz, yz, zz] = mean_traction.map(|mean| Complex64::new(mean, 0.0));
                rows[3..].copy_from_slice(&[zz, yz, xz]);
            }
            [*a, *b, *c, *d, *e, *f] = rows;
        });
        let rows: &[usize] = match self.components {
            Components::Plane => &[0, 3, 5],
            Components::Space => &[0, 1, 2, 3, 4, 5],
        };
        self.synthesise(rows, ws)?;
        let mut fields: [&[f64]; 6] = [&[]; 6];
        for (&row, field) in rows.iter().zip(ws.fields.chunks_exact(self.grid().len())) {
            fields[row] = field;
        }
        Ok(Deformation { material: *section.material(), fields })
    }

    fn check_workspace(&self, ws: &Workspace) -> Result<(), ShapeError> {
        let (found, expected) = (ws.spectra[0].len(), self.grid().spectrum_len());
        if found == expected { Ok(()) } else { Err(ShapeError { what: "workspace", found, expected }) }
    }

    /// Transforms the spectra with these indices into the fields of the workspace, one after the other.
    fn synthesise(&self, spectra: &[usize], ws: &mut Workspace) -> Result<(), ShapeError> {
        for (&index, field) in spectra.iter().zip(ws.fields.chunks_exact_mut(self.grid().len())) {
            self.transform.inverse(&ws.spectra[index], field, &mut ws.transform)?;
        }
        Ok(())
    }

    /// Returns the displacement due to the mean traction, relative to the top of the half-space that the plane cuts;
    /// zero in layers.
    fn linear_displacement(&self, section: &Section<'_>) -> [f64; 3] {
        let Some(depth) = section.depth_in_half_space() else { return [0.0; 3] };
        let material = section.material();
        let shear = 1.0 / material.shear_modulus();
        let compliance = [shear, shear, material.p_wave_compliance()];
        let mean = self.mean_traction();
        std::array::from_fn(|axis| -depth * compliance[axis] * mean[axis])
    }

    /// Returns ũ_z of a mode of a surface without shear traction, if it is stored separately.
    fn set_apart(&self, index: usize, mode: &Mode) -> Option<Complex64> {
        if self.nyquist.is_empty() || mode.nyquist == [false; 2] {
            return None;
        }
        let at = self.nyquist.binary_search_by_key(&index, |(index, _)| *index).ok()?;
        Some(self.nyquist[at].1)
    }

    /// Returns the surface displacement ũ as a function of the index in the half spectrum.
    fn amplitude(&self) -> impl Fn(usize) -> [Complex64; 3] + Sync + '_ {
        let [x, y, z] = &self.surface;
        move |index| [x[index], y[index], z[index]]
    }
}

pub(crate) fn check_finite(field: &[f64]) -> Result<(), InteriorError> {
    match field.iter().position(|value| !value.is_finite()) {
        Some(index) => Err(InteriorError::NotFinite { found: field[index], index }),
        None => Ok(()),
    }
}

/// Number of modes that one thread takes at a time.
const CHUNK: usize = 512;

/// Ratio of mean to largest value below which a mean counts as rounding error.
const ROUNDING_OF_MEAN: f64 = 1e-12;

/// Relative difference at which two mean tractions contradict each other, beyond the tolerance of any search.
const CONTRADICTION: f64 = 0.1;

/// Ratio of mean displacement to largest amplitude below which it does not determine the mean traction.
const UNCERTAIN: f64 = 1e-6;

/// Multiplies a matrix by an amplitude. Zero amplitudes give zero even where the matrix is infinite, as for u_z of an
/// incompressible slab at q = 0.
fn apply<const ROWS: usize>(matrix: &[[Complex64; 3]; ROWS], surface: [Complex64; 3]) -> [Complex64; ROWS] {
    let product = |entry: &Complex64, u: Complex64| if u == Complex64::ZERO { u } else { entry * u };
    matrix.map(|row| row.iter().zip(surface).map(|(entry, u)| product(entry, u)).sum())
}

impl fmt::Debug for Interior {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Interior").field("body", &self.body).field("grid", self.grid()).finish_non_exhaustive()
    }
}

impl fmt::Debug for Workspace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Workspace").finish_non_exhaustive()
    }
}
