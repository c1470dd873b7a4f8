use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use gfmd_field::{Grid, Mode, ShapeError, Share, Transform};
use num_complex::Complex64;
use rayon::prelude::*;

use crate::{Components, Hermitian};

/// Hermitian matrix per mode, applied to vector fields on a grid: a stiffness, a compliance, or a preconditioner.
///
/// Each process has the modes of its own lanes ([`Transform::lanes`]) and transforms its own rows.
pub struct Operator {
    transform: Arc<Transform>,
    share: Share,
    components: Components,
    matrices: Vec<Hermitian>,
}

/// Memory of one caller, created by [`Operator::workspace`]: a spectrum per component, and the memory of a transform.
/// It works with all operators on one grid, which then do not allocate.
pub struct Workspace {
    transform: gfmd_field::Workspace,
    spectra: [Vec<Complex64>; 3],
}

impl Operator {
    /// Tabulates `matrix` for every mode of `grid`. Rows and columns of y are ignored on a line.
    ///
    /// Entries odd in a Nyquist component must be zero, as in
    /// [`Body::stiffness_of`](gfmd_green::Body::stiffness_of) (theory.md, section 0).
    pub fn new(grid: Grid, matrix: impl Fn(&Mode) -> Hermitian + Sync) -> Self {
        Self::distributed(grid, &grid.whole(), matrix)
    }

    /// Tabulates `matrix` for the modes of this process, one of several that share the rows, as [`new`](Self::new).
    pub fn distributed(grid: Grid, share: &Share, matrix: impl Fn(&Mode) -> Hermitian + Sync) -> Self {
        Self::on(Arc::new(Transform::distributed(grid, share)), share, matrix)
    }

    /// Tabulates another operator on the same grid, with shared planned transforms.
    pub fn beside(&self, matrix: impl Fn(&Mode) -> Hermitian + Sync) -> Self {
        Self::on(Arc::clone(&self.transform), &self.share, matrix)
    }

    /// Creates the operator with the matrices `f(mode, matrix)` on the same grid.
    pub fn map(&self, f: impl Fn(&Mode, Hermitian) -> Hermitian + Sync) -> Self {
        let Self { transform, share, components, matrices } = self;
        let (grid, first) = (*transform.grid(), self.first());
        let matrices = matrices.par_iter().enumerate().with_min_len(CHUNK);
        let matrices = matrices.map(|(index, matrix)| f(&grid.mode_at(first + index), *matrix)).collect();
        Self { transform: Arc::clone(transform), share: share.clone(), components: *components, matrices }
    }

    /// Returns the function that replaces a field by F⁻¹\[M F\[field\]\], with its own memory. A field without the size
    /// of the grid is not changed.
    pub fn in_place(self) -> impl Fn(&mut [f64]) {
        let scratch = Mutex::new((self.workspace(), Vec::new()));
        move |field| {
            let (workspace, before) = &mut *scratch.lock().unwrap_or_else(PoisonError::into_inner);
            before.clear();
            before.extend_from_slice(field);
            // A field of another size is refused before anything is written.
            let _ = self.apply(before, field, workspace);
        }
    }

    /// Creates the operator with these matrices of the modes of this process, laid out as [`Grid::modes`]. Fields have
    /// the rows of `share`, as the transforms.
    pub(crate) fn of_matrices(transform: Transform, share: &Share, matrices: Vec<Hermitian>) -> Self {
        let components = Components::of(transform.grid());
        Self { share: share.clone(), components, transform: transform.into(), matrices }
    }

    fn on(transform: Arc<Transform>, share: &Share, matrix: impl Fn(&Mode) -> Hermitian + Sync) -> Self {
        let (grid, lanes) = (*transform.grid(), transform.lanes());
        let [_, positions] = grid.spectrum_shape();
        let matrices = (lanes.start * positions..lanes.end * positions)
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|index| matrix(&grid.mode_at(index)))
            .collect();
        Self { transform, share: share.clone(), components: Components::of(&grid), matrices }
    }

    /// Returns the index of the first mode of this process among all modes.
    pub(crate) fn first(&self) -> usize {
        let [_, positions] = self.grid().spectrum_shape();
        self.transform.lanes().start * positions
    }

    /// Returns the rows of this process; a single process has all rows.
    pub fn share(&self) -> &Share {
        &self.share
    }

    /// Returns the grid of the fields.
    pub fn grid(&self) -> &Grid {
        self.transform.grid()
    }

    /// Returns the components of the fields.
    pub fn components(&self) -> Components {
        self.components
    }

    /// Returns the planned transforms of one component.
    pub fn transform(&self) -> &Transform {
        &self.transform
    }

    /// Returns the planned transforms of one component, shared.
    pub(crate) fn shared_transform(&self) -> Arc<Transform> {
        Arc::clone(&self.transform)
    }

    /// Returns the matrices of the modes of this process, laid out as [`Grid::modes`].
    pub fn matrices(&self) -> &[Hermitian] {
        &self.matrices
    }

    /// Allocates memory for the operators on this grid, for the number of threads of the current rayon pool.
    pub fn workspace(&self) -> Workspace {
        let mut spectra = [const { Vec::new() }; 3];
        for &axis in self.components.axes() {
            spectra[axis] = vec![Complex64::ZERO; self.matrices.len()];
        }
        Workspace { transform: self.transform.workspace(), spectra }
    }

    /// Computes `out` = F⁻¹\[M F\[field\]\], both component after component. Costs one transform pair per component.
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not have the size of the grid.
    pub fn apply(&self, field: &[f64], out: &mut [f64], ws: &mut Workspace) -> Result<(), ShapeError> {
        let components = self.components.len();
        self.check("output", out, components)?;
        self.analyse(field, components, ws)?;
        let matrices = &self.matrices;
        let [x, y, z] = &mut ws.spectra;
        match self.components {
            Components::Plane => (x, z, matrices).into_par_iter().with_min_len(CHUNK).for_each(|(x, z, m)| {
                (*x, *z) = (*x * m.xx + (*z * m.xz).times_i(), *z * m.zz - (*x * m.xz).times_i());
            }),
            Components::Space => (x, y, z, matrices).into_par_iter().with_min_len(CHUNK).for_each(|(x, y, z, m)| {
                (*x, *y, *z) = (
                    *x * m.xx + *y * m.xy + (*z * m.xz).times_i(),
                    *x * m.xy + *y * m.yy + (*z * m.yz).times_i(),
                    *z * m.zz - (*x * m.xz + *y * m.yz).times_i(),
                );
            }),
        }
        self.synthesise(out, ws)
    }

    /// Computes the lateral part of [`apply`](Self::apply) for a lateral `field`: both are u_x, u_y (u_x on a line).
    /// Costs one transform pair per lateral component.
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not have the size of the grid.
    pub fn apply_laterally(&self, field: &[f64], out: &mut [f64], ws: &mut Workspace) -> Result<(), ShapeError> {
        let components = self.components.len() - 1;
        self.check("output", out, components)?;
        self.analyse(field, components, ws)?;
        let matrices = &self.matrices;
        let [x, y, _] = &mut ws.spectra;
        match self.components {
            Components::Plane => (x, matrices).into_par_iter().with_min_len(CHUNK).for_each(|(x, m)| *x *= m.xx),
            Components::Space => (x, y, matrices).into_par_iter().with_min_len(CHUNK).for_each(|(x, y, m)| {
                (*x, *y) = (*x * m.xx + *y * m.xy, *x * m.xy + *y * m.yy);
            }),
        }
        self.synthesise(out, ws)
    }

    /// Returns (1/N) Σ_r f·(M f), summed over all modes and components: twice the elastic energy per area if M is a
    /// stiffness and f a displacement (theory.md, section 0). Costs half of [`apply`](Self::apply).
    ///
    /// # Errors
    /// Returns an error if a slice or the workspace does not have the size of the grid.
    pub fn quadratic_form(&self, field: &[f64], ws: &mut Workspace) -> Result<f64, ShapeError> {
        self.analyse(field, self.components.len(), ws)?;
        let [x, y, z] = &ws.spectra;
        let of_mode = |index: usize| {
            let m = &self.matrices[index];
            // A line has no component along y.
            let (x, y, z) = (x[index], y.get(index).copied().unwrap_or_default(), z[index]);
            let coupled = (x.conj() * z).im * m.xz + (y.conj() * z).im * m.yz;
            let weight = self.grid().mode_at(self.first() + index).weight;
            let diagonal = m.xx * x.norm_sqr() + m.yy * y.norm_sqr() + m.zz * z.norm_sqr();
            weight * (diagonal + 2.0 * (m.xy * (x.conj() * y).re - coupled))
        };
        // Sums of lanes, added in order, give equal bits for any number of threads and processes.
        let [_, positions] = self.grid().spectrum_shape();
        let own = self.matrices.len() / positions;
        let of_lane = |lane: usize| (lane * positions..(lane + 1) * positions).map(of_mode).sum();
        let sums: Vec<f64> = (0..own).into_par_iter().map(of_lane).collect();
        Ok(self.share.collect(&sums, &self.share.each(own)).iter().sum())
    }

    fn analyse(&self, field: &[f64], components: usize, ws: &mut Workspace) -> Result<(), ShapeError> {
        self.check("field", field, components)?;
        for (&axis, component) in self.components.axes().iter().zip(field.chunks_exact(self.points())) {
            self.transform.forward(component, &mut ws.spectra[axis], &mut ws.transform)?;
        }
        Ok(())
    }

    fn synthesise(&self, out: &mut [f64], ws: &mut Workspace) -> Result<(), ShapeError> {
        for (&axis, component) in self.components.axes().iter().zip(out.chunks_exact_mut(self.points())) {
            self.transform.inverse(&ws.spectra[axis], component, &mut ws.transform)?;
        }
        Ok(())
    }

    /// Returns the number of points of this process.
    fn points(&self) -> usize {
        self.share.own().len()
    }

    fn check(&self, what: &'static str, field: &[f64], components: usize) -> Result<(), ShapeError> {
        let expected = components * self.points();
        if field.len() == expected { Ok(()) } else { Err(ShapeError { what, found: field.len(), expected }) }
    }
}

/// Number of modes in a task of one thread.
const CHUNK: usize = 4096;

trait TimesI {
    fn times_i(self) -> Self;
}

impl TimesI for Complex64 {
    fn times_i(self) -> Self {
        Self::new(-self.im, self.re)
    }
}

impl fmt::Debug for Operator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Operator").field("grid", self.grid()).finish_non_exhaustive()
    }
}

impl fmt::Debug for Workspace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Workspace").finish_non_exhaustive()
    }
}
