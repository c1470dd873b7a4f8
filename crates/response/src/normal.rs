use std::ops::Range;
use std::sync::{Arc, OnceLock};

use gfmd_field::{Grid, Mode, Share, Transform};
use gfmd_green::{Body, Conductor, GreenError, patch_compliance, table_of_lanes, table_of_modes};
use gfmd_vector::{once, pass};

use crate::FullResponse;
use crate::patch_table::{Parity, PatchTable};
use crate::rounded::Rounded;
use crate::scattered::Scattered;

/// Normal response of a body on one grid: planned transforms, and compliance and stiffness of every mode, for problems
/// with u_z and the pressure only. Built once and shared between problems and threads. Each process has the modes of
/// its own lanes ([`Transform::lanes`]) and transforms its own rows.
#[derive(Debug)]
pub struct NormalResponse {
    transform: Arc<Transform>,
    share: Share,
    compliance: Vec<f64>,
    /// Tabulated at first use, since contacts with a hard wall do not need it.
    stiffness: OnceLock<Vec<f64>>,
    waves: Waves,
    body: Body,
    uniform_compliance: f64,
    stiffness_range: [f64; 2],
    contact_modulus: f64,
    rounded: OnceLock<Rounded>,
    scattered: OnceLock<Option<Scattered>>,
    /// True if waves of equal length have equal stiffness: isotropic body, modes not changed individually.
    is_isotropic: bool,
    /// Compliances of springs that were added to each mode of the body, in this order.
    added: Vec<f64>,
    /// Compliances of the waves along x and along y of all processes, for modes that were changed individually.
    along: Option<Arc<[Vec<f64>; 2]>>,
}

/// Smallest allowed compliance of a patch, relative to the largest.
pub(crate) const LEAST_COMPLIANCE: f64 = 1e-12;

/// Largest relative difference between equal compliances that are computed in different ways.
const ROUNDING_OF_COMPLIANCE: f64 = 1e-12;

/// Compliances of all modes, laid out as [`Grid::modes`].
struct TabulatedModes {
    /// Zero for the uniform mode.
    compliance: Vec<f64>,
    uniform_compliance: f64,
    is_isotropic: bool,
}

/// Sets the entry of the uniform mode, identified by its index, the first, to zero.
fn without_uniform(mut table: Vec<f64>) -> Vec<f64> {
    table[0] = 0.0;
    table
}

/// Stiffness as a function of the wave vector.
type StiffnessOf = fn(&Body, [f64; 2]) -> f64;

/// Response of a body to a wave.
#[derive(Clone, Copy, Debug)]
enum Waves {
    /// Stiffness of each wave.
    Stiffness(StiffnessOf),
    /// Normal part of the matrices of all components.
    OfMatrices,
}

impl Waves {
    /// Returns the compliance of a mode other than the uniform one.
    fn compliance(self, body: &Body, grid: &Grid, mode: &Mode) -> f64 {
        match self {
            Self::Stiffness(of) => 1.0 / stiffness_of_mode(body, mode, of),
            Self::OfMatrices => FullResponse::compliance_of_mode(body, grid, mode).zz,
        }
    }

    /// Tabulates the stiffness of the modes in some lanes; 0 for the uniform mode.
    fn stiffness(self, body: &Body, grid: &Grid, lanes: Range<usize>) -> Vec<f64> {
        match self {
            Self::Stiffness(of) => stiffness_table(grid, lanes, body, of),
            Self::OfMatrices => table_of_modes(grid, lanes, 0.0, |mode| 1.0 / self.compliance(body, grid, mode)),
        }
    }
}

/// Returns the stiffness of a mode other than the uniform one: the mean over its aliases on the grid, which differ if
/// the body is anisotropic.
fn stiffness_of_mode(body: &Body, mode: &Mode, of: StiffnessOf) -> f64 {
    if body.is_isotropic() {
        return of(body, [mode.wavenumber(), 0.0]);
    }
    let (sum, count) = mode.aliases().fold((0.0, 0.0), |(sum, count), q| (sum + of(body, q), count + 1.0));
    sum / count
}

/// Tabulates the stiffness of the modes in some lanes.
fn stiffness_table(grid: &Grid, lanes: Range<usize>, body: &Body, of: StiffnessOf) -> Vec<f64> {
    match body.is_isotropic() {
        true => table_of_lanes(grid, lanes, 0.0, |q| of(body, [q, 0.0])),
        false => table_of_modes(grid, lanes, 0.0, |mode| stiffness_of_mode(body, mode, of)),
    }
}

/// Returns the stiffness 1/G_zz of a surface with free lateral displacement.
fn free(body: &Body, q: [f64; 2]) -> f64 {
    1.0 / body.normal_compliance_along(q)
}

/// Returns the stiffness K_N of a surface without lateral displacement.
fn held(body: &Body, [x, y]: [f64; 2]) -> f64 {
    body.restricted_normal_stiffness(x.hypot(y))
}

impl NormalResponse {
    /// Tabulates the response of `body` on `grid`, with free lateral displacement of the surface.
    pub fn new(grid: Grid, body: &Body) -> Self {
        Self::distributed(grid, body, &grid.whole())
    }

    /// Tabulates the response of `body` on `grid` for the `share` of rows of this process, with free lateral
    /// displacement.
    pub fn distributed(grid: Grid, body: &Body, share: &Share) -> Self {
        Self::tabulated(grid, body, share, free)
    }

    /// Tabulates the response of a surface without lateral displacement: the stiffness is K_N in place of 1/G_zz
    /// (theory.md, section 3, restricted lateral displacement).
    pub fn held_sideways(grid: Grid, body: &Body) -> Self {
        Self::held_sideways_over(grid, body, &grid.whole())
    }

    /// Tabulates [`held_sideways`](Self::held_sideways) for the `share` of rows of this process.
    pub fn held_sideways_over(grid: Grid, body: &Body, share: &Share) -> Self {
        Self::tabulated(grid, body, share, held)
    }

    /// Tabulates the response of a conductor, with potential as displacement and current density as pressure. The
    /// uniform mode has no resistance, since the bulk is not part of the contact resistance (theory.md, section 7.6).
    pub fn of_conductor(grid: Grid, conductor: &Conductor) -> Self {
        let conductance = |body: &Body, [x, y]: [f64; 2]| 1.0 / body.transverse_compliance(x.hypot(y));
        let response = Self::tabulated(grid, conductor.body(), &grid.whole(), conductance);
        Self { uniform_compliance: 0.0, ..response }
    }

    fn tabulated(grid: Grid, body: &Body, share: &Share, stiffness_of: StiffnessOf) -> Self {
        let transform = Transform::distributed(grid, share);
        let mut compliance = stiffness_table(&grid, transform.lanes(), body, stiffness_of);
        // The uniform mode is identified by its index, the first, never by a small wavenumber.
        let first = usize::from(transform.lanes().contains(&0));
        let none = [f64::INFINITY, 0.0];
        let wider = |[low, high]: [f64; 2], [a, b]: [f64; 2]| [a.min(low), b.max(high)];
        let invert = |stiffness: &mut [f64]| {
            stiffness.iter_mut().fold(none, |range, k| {
                let range = wider(range, [*k; 2]);
                *k = 1.0 / *k;
                range
            })
        };
        let range = pass([&mut compliance[first..]], &|_, [stiffness]| invert(stiffness), &wider);
        let range = share.each(range).into_iter().fold(none, wider);
        compliance[..first].fill(0.0);
        let [_, uniform] = body.level_compliance();
        Self {
            transform: transform.into(),
            share: share.clone(),
            compliance,
            stiffness: OnceLock::new(),
            waves: Waves::Stiffness(stiffness_of),
            body: body.clone(),
            uniform_compliance: uniform,
            stiffness_range: range,
            contact_modulus: body.contact_modulus(),
            rounded: OnceLock::new(),
            scattered: OnceLock::new(),
            is_isotropic: body.is_isotropic(),
            added: Vec::new(),
            along: None,
        }
    }

    /// Tabulates the response of a non-periodic patch (theory.md, section 3.1) on its [padded](Grid::padded) grid: if
    /// the traction vanishes outside the patch, the displacement inside is relative to a surface at rest far away. G_zz
    /// is the transform of the compliance between two cells, and positive for every mode, including the uniform one.
    ///
    /// # Errors
    /// Returns an error if the body has no level far away, the patch cannot be doubled, or an entry is not positive.
    pub fn of_patch(patch: &Grid, body: &Body) -> Result<Self, GreenError> {
        Self::of_patch_over(&patch.whole(), patch, body)
    }

    /// Tabulates the response as [`of_patch`](Self::of_patch) for the processes of a `share`, which also share the rows
    /// of the padded grid.
    ///
    /// # Errors
    /// Returns an error as [`of_patch`](Self::of_patch), and if the processes cannot share the padded grid.
    pub fn of_patch_over(share: &Share, patch: &Grid, body: &Body) -> Result<Self, GreenError> {
        let table = PatchTable::padded_to(2, patch, share, patch_compliance(body, patch)?)?;
        let share = table.share.clone();
        let spectrum = table.spectrum(|compliance| *compliance, [Parity::Even; 2]);
        let mut compliance: Vec<f64> = spectrum.iter().map(|mode| mode.re).collect();
        let own = [f64::max, f64::min].map(|pick| compliance.iter().copied().reduce(pick));
        let of_all = share.each([own[0].unwrap_or(0.0), own[1].unwrap_or(f64::INFINITY)]);
        let [softest, stiffest] =
            of_all.into_iter().fold([0.0, f64::INFINITY], |[softest, stiffest], [most, least]| {
                [f64::max(softest, most), f64::min(stiffest, least)]
            });
        // A smaller entry would be a rounding error of the largest.
        let is_resolved = stiffest > LEAST_COMPLIANCE * softest;
        if !is_resolved {
            return Err(GreenError::PatchStiffness { least: stiffest, largest: softest });
        }
        let stiffness: Vec<f64> = compliance.iter().map(|g| 1.0 / g).collect();
        let has_uniform = table.transform.lanes().contains(&0);
        let uniform = if has_uniform { std::mem::take(&mut compliance[0]) } else { 0.0 };
        let uniform_compliance = share.each(uniform).into_iter().sum();
        Ok(Self {
            share,
            transform: table.transform.into(),
            compliance,
            stiffness: OnceLock::from(if has_uniform { without_uniform(stiffness) } else { stiffness }),
            waves: Waves::Stiffness(free),
            body: body.clone(),
            uniform_compliance,
            stiffness_range: [1.0 / softest, 1.0 / stiffest],
            contact_modulus: body.contact_modulus(),
            rounded: OnceLock::new(),
            scattered: OnceLock::new(),
            is_isotropic: true,
            added: Vec::new(),
            along: None,
        })
    }

    /// Tabulates the normal part of a response of all components: u_z of a pressure without shear traction. It differs
    /// from [`new`](Self::new) in the Nyquist modes, in which [`FullResponse`] averages the stiffness matrix over the
    /// aliases and inverts the mean.
    pub fn of_all_components(response: &FullResponse) -> Self {
        let (body, grid, operator) = (response.body(), *response.grid(), response.compliance());
        let (first, share) = (operator.first(), response.share());
        // The uniform mode is identified by its index, the first, never by a small wavenumber.
        let compliance: Vec<f64> = operator.matrices().iter().map(|matrix| matrix.zz).collect();
        let has_uniform = operator.transform().lanes().contains(&0);
        let compliance = if has_uniform { without_uniform(compliance) } else { compliance };
        let [.., uniform_compliance] = response.uniform_compliance();
        let like_others = |(index, compliance): (usize, &f64)| {
            let mode = grid.mode_at(first + index);
            let other = || (compliance * stiffness_of_mode(body, &mode, free) - 1.0).abs() < ROUNDING_OF_COMPLIANCE;
            mode.is_uniform() || mode.nyquist == [false, false] || other()
        };
        let is_isotropic = body.is_isotropic() && !share.any(!compliance.iter().enumerate().all(like_others));
        let modes = TabulatedModes { compliance, uniform_compliance, is_isotropic };
        Self::of_modes(modes, (operator.shared_transform(), share.clone()), body, Waves::OfMatrices)
    }

    /// Multiplies the stiffness of each mode of this process by one of `factors`, laid out as [`Grid::modes`].
    #[must_use]
    pub fn stiffened(&self, factors: &[f64]) -> Self {
        let (share, [_, positions]) = (&self.share, self.grid().spectrum_shape());
        let mut compliance = self.compliance.clone();
        compliance.iter_mut().zip(factors).for_each(|(compliance, factor)| *compliance /= factor);
        let factor = factors.first().copied().filter(|_| self.has_uniform());
        let uniform = self.uniform_compliance / share.first(factor).unwrap_or(1.0);
        let along_x = if self.has_uniform() { &compliance[..positions.min(compliance.len())] } else { &[] };
        let along_y: Vec<f64> = compliance.iter().copied().step_by(positions).collect();
        let along = [along_x, &along_y].map(|own| share.collect(own, &share.each(own.len())));
        Self { along: Some(along.into()), ..self.changed(compliance, uniform, false) }
    }

    /// Returns the response of the body below point springs with this `compliance` in length/stress, which is added to
    /// the compliance of all modes, including the uniform one.
    #[must_use]
    pub fn softened(&self, compliance: f64) -> Self {
        // The table has no uniform mode, which is identified by its index, the first.
        let (waves, has_uniform) = (self.compliance.iter().enumerate(), self.has_uniform());
        let table =
            waves.map(|(index, wave)| if index == 0 && has_uniform { 0.0 } else { wave + compliance }).collect();
        let added = self.added.iter().copied().chain([compliance]).collect();
        let softer = |waves: &Vec<f64>| {
            waves.iter().enumerate().map(|(index, wave)| if index == 0 { 0.0 } else { wave + compliance }).collect()
        };
        let along = self.along.as_ref().map(|along| Arc::new([softer(&along[0]), softer(&along[1])]));
        Self { added, along, ..self.changed(table, self.uniform_compliance + compliance, self.is_isotropic) }
    }

    /// Returns the response with other compliances.
    fn changed(&self, compliance: Vec<f64>, uniform_compliance: f64, is_isotropic: bool) -> Self {
        let modes = TabulatedModes { compliance, uniform_compliance, is_isotropic };
        Self::of_modes(modes, (Arc::clone(&self.transform), self.share.clone()), &self.body, self.waves)
    }

    /// Returns the response with the compliances of all modes.
    fn of_modes(modes: TabulatedModes, (transform, share): (Arc<Transform>, Share), body: &Body, waves: Waves) -> Self {
        let TabulatedModes { compliance, uniform_compliance, is_isotropic } = modes;
        let has_uniform = transform.lanes().contains(&0);
        let stiffness: Vec<f64> = compliance.iter().map(|compliance| 1.0 / compliance).collect();
        let others = || compliance.iter().copied().skip(usize::from(has_uniform));
        let own = [others().fold(f64::INFINITY, f64::min), others().fold(0.0, f64::max)];
        let all = share.each(own).into_iter();
        let [least, most] =
            all.fold([f64::INFINITY, 0.0], |[least, most], [low, high]| [low.min(least), high.max(most)]);
        Self {
            transform,
            share,
            stiffness_range: [1.0 / most, 1.0 / least],
            uniform_compliance,
            stiffness: OnceLock::from(if has_uniform { without_uniform(stiffness) } else { stiffness }),
            waves,
            body: body.clone(),
            contact_modulus: body.contact_modulus(),
            rounded: OnceLock::new(),
            scattered: OnceLock::new(),
            is_isotropic,
            added: Vec::new(),
            along: None,
            compliance,
        }
    }

    /// Returns the grid of the surface.
    pub fn grid(&self) -> &Grid {
        self.transform.grid()
    }

    /// Returns true if this is the response of `body`.
    pub(crate) fn is_of(&self, body: &Body) -> bool {
        self.body == *body
    }

    /// Returns the planned transforms of the grid, used by [`NormalTransforms`](crate::NormalTransforms).
    pub(crate) fn transform(&self) -> &Transform {
        &self.transform
    }

    /// Returns the response in single precision, tabulated at first use.
    pub(crate) fn rounded(&self) -> &Rounded {
        let Self { transform, share, compliance, stiffness_range: [softest, _], rounded, is_isotropic, .. } = self;
        once(rounded, || Rounded::of(*transform.grid(), share, compliance, *softest, *is_isotropic))
    }

    /// Returns the response between few points, tabulated at first use; `None` as in [`Scattered::of`].
    pub(crate) fn scattered(&self) -> Option<&Scattered> {
        once(&self.scattered, || Scattered::tabulated(self)).as_ref()
    }

    /// Returns true if waves of equal length have equal stiffness.
    pub(crate) fn is_isotropic(&self) -> bool {
        self.is_isotropic
    }

    /// Returns true if the compliance is tabulated; it may then have any form at short waves.
    pub(crate) fn is_tabulated(&self) -> bool {
        self.body.tabulated_wavenumbers().is_some()
    }

    /// Returns the rows of this process; a single process has all rows.
    pub fn share(&self) -> &Share {
        &self.share
    }

    /// Returns true if this process has the uniform mode, which is then its first mode.
    pub fn has_uniform(&self) -> bool {
        self.transform.lanes().contains(&0)
    }

    /// Returns G_zz(q) in length/stress for the modes of this process, laid out as [`Grid::modes`]; 0 at q = 0, see
    /// [`uniform_compliance`](Self::uniform_compliance).
    pub fn compliance(&self) -> &[f64] {
        &self.compliance
    }

    /// Returns the compliance of mode `index` among all modes, in length/stress. It is computed if the mode belongs to
    /// another process; of modes that were [changed individually](Self::stiffened), other processes know only those
    /// along x or y, and NaN stands for the others.
    pub fn compliance_at(&self, index: usize) -> f64 {
        let [_, positions] = self.grid().spectrum_shape();
        let own = index.checked_sub(self.transform.lanes().start * positions);
        own.and_then(|own| self.compliance.get(own).copied()).unwrap_or_else(|| {
            let mode = self.grid().mode_at(index);
            let of_body = || self.waves.compliance(&self.body, self.grid(), &mode);
            if let Some([along_x, along_y]) = self.along.as_deref() {
                let is_along_y = index.is_multiple_of(positions);
                let known = if is_along_y { along_y.get(index / positions) } else { along_x.get(index) };
                return known.copied().unwrap_or(f64::NAN);
            }
            if mode.is_uniform() { 0.0 } else { self.added.iter().fold(of_body(), |wave, added| wave + added) }
        })
    }

    /// Returns 1/G_zz(q) in stress/length for the modes of this process, laid out as [`Grid::modes`]; 0 at q = 0.
    pub fn stiffness(&self) -> &[f64] {
        let Self { transform, waves, body, .. } = self;
        let table = || waves.stiffness(body, self.grid(), transform.lanes());
        once::<Vec<f64>>(&self.stiffness, table)
    }

    /// Returns E* of the body, in stress; 1/(1/E₁* + 1/E₂*) for two bodies.
    pub fn contact_modulus(&self) -> f64 {
        self.contact_modulus
    }

    /// Returns G_zz(0) in length/stress, relative to the reference level of [`Body::level_compliance`]: height divided
    /// by P-wave modulus, summed over slabs and layers; 0 for a half-space (with a fixed mean level, theory.md, section
    /// 7) and for an incompressible slab.
    pub fn uniform_compliance(&self) -> f64 {
        self.uniform_compliance
    }

    /// Returns the smallest and largest stiffness 1/G_zz of the modes q ≠ 0, in stress/length.
    pub fn stiffness_range(&self) -> [f64; 2] {
        self.stiffness_range
    }
}
