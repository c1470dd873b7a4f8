use std::sync::Arc;

use gfmd_field::{Grid, Share, Split, Transform};

use crate::{FullResponse, NormalResponse, PlateResponse, PlateTransforms, Workspace};

/// Elastic side of a contact: a surface with u_z only or with all components of its displacement, or both faces of a
/// plate. The response is shared, so that clones are cheap.
#[derive(Clone, Debug)]
pub enum Elastic {
    /// Component u_z only.
    Normal(Arc<NormalResponse>),
    /// All components.
    Full(Arc<FullResponse>),
    /// Normal displacement of both faces of a plate, outwards, as one field with the upper face first. It has a single
    /// component and twice the points of the grid.
    Plate(Arc<PlateResponse>),
}

impl From<Arc<NormalResponse>> for Elastic {
    fn from(response: Arc<NormalResponse>) -> Self {
        Self::Normal(response)
    }
}

impl From<Arc<FullResponse>> for Elastic {
    fn from(response: Arc<FullResponse>) -> Self {
        Self::Full(response)
    }
}

impl From<NormalResponse> for Elastic {
    fn from(response: NormalResponse) -> Self {
        Self::Normal(response.into())
    }
}

impl From<PlateResponse> for Elastic {
    fn from(response: PlateResponse) -> Self {
        Self::Plate(response.into())
    }
}

impl From<Arc<PlateResponse>> for Elastic {
    fn from(response: Arc<PlateResponse>) -> Self {
        Self::Plate(response)
    }
}

impl From<FullResponse> for Elastic {
    fn from(response: FullResponse) -> Self {
        Self::Full(response.into())
    }
}

impl Elastic {
    /// Returns the grid of the surface, or of each face.
    pub fn grid(&self) -> &Grid {
        match self {
            Self::Normal(response) => response.grid(),
            Self::Full(response) => response.grid(),
            Self::Plate(response) => response.grid(),
        }
    }

    /// Returns the rows of this process, of both faces of a plate; a single process has all rows.
    pub fn share(&self) -> Share {
        match self {
            Self::Normal(response) => response.share().clone(),
            Self::Full(response) => response.share().clone(),
            Self::Plate(response) => response.share().of_faces(),
        }
    }

    /// Returns the number of components of a field; z is the last.
    pub fn components(&self) -> usize {
        match self {
            Self::Normal(_) | Self::Plate(_) => 1,
            Self::Full(response) => response.components().len(),
        }
    }

    /// Returns the number of faces: 2 for a plate.
    pub fn faces(&self) -> usize {
        if let Self::Plate(_) = self { 2 } else { 1 }
    }

    /// Returns the compliance of the uniform mode for each component, in length/stress; 0 if the mean displacement does
    /// not depend on the mean traction. On a plate the tractions on both faces are equal.
    pub fn uniform_compliance(&self) -> Vec<f64> {
        match self {
            Self::Normal(response) => vec![response.uniform_compliance()],
            Self::Plate(response) => vec![response.uniform_compliance()],
            Self::Full(response) => {
                let all = response.uniform_compliance();
                response.components().axes().iter().map(|&axis| all[axis]).collect()
            }
        }
    }

    /// Returns the smallest and largest stiffness of the modes q ≠ 0, in stress/length.
    pub fn stiffness_range(&self) -> [f64; 2] {
        match self {
            Self::Normal(response) => response.stiffness_range(),
            Self::Full(response) => response.stiffness_range(),
            Self::Plate(response) => response.stiffness_range(),
        }
    }

    /// Returns E* of the body, in stress.
    pub fn contact_modulus(&self) -> f64 {
        match self {
            Self::Normal(response) => response.contact_modulus(),
            Self::Full(response) => response.contact_modulus(),
            Self::Plate(response) => response.contact_modulus(),
        }
    }

    /// Creates the transforms of one solve, with their memory and a counter.
    pub fn transforms(&self) -> Transforms {
        match self {
            Self::Normal(response) => Transforms::Normal(NormalTransforms::of(response)),
            Self::Full(response) => Transforms::Full(FullTransforms::of(response)),
            Self::Plate(response) => Transforms::Plate(PlateTransforms::of(response)),
        }
    }
}

/// Stiffness and compliance of an [`Elastic`] surface, with the memory of the transforms and a counter.
///
/// # Panics
/// Every method panics if a field does not have the size of the grid times the number of components, or of faces.
#[derive(Debug)]
#[expect(missing_docs, reason = "each variant is described by its type")]
pub enum Transforms {
    Normal(NormalTransforms),
    Full(FullTransforms),
    Plate(PlateTransforms),
}

impl Transforms {
    /// Computes `out` = K `field`, except that the mean of each component is `uniform` times the mean of `field`; of a
    /// plate, half sum and half difference of the two means.
    pub fn stiffness(&mut self, field: &[f64], uniform: &[f64], out: &mut [f64]) {
        match self {
            Self::Normal(normal) => {
                let response = Arc::clone(&normal.response);
                normal.convolve(response.stiffness(), field, out);
                add_uniform(response.share(), field, uniform[0], out);
            }
            Self::Full(full) => {
                full.stiffness(field, out);
                set_means(full.response.share(), field, uniform, out);
            }
            Self::Plate(plate) => plate.stiffness_with([uniform[0], uniform[1]], field, out),
        }
    }

    /// Computes `out` = G `field`, with means as [`stiffness`](Self::stiffness).
    pub fn compliance(&mut self, field: &[f64], uniform: &[f64], out: &mut [f64]) {
        match self {
            Self::Normal(normal) => {
                let response = Arc::clone(&normal.response);
                normal.convolve(response.compliance(), field, out);
                add_uniform(response.share(), field, uniform[0], out);
            }
            Self::Full(full) => {
                full.compliance(field, out);
                set_means(full.response.share(), field, uniform, out);
            }
            Self::Plate(plate) => plate.compliance_with([uniform[0], uniform[1]], field, out),
        }
    }

    /// Returns the number of pairs of forward and inverse transforms of one component so far.
    pub fn pairs(&self) -> f64 {
        match self {
            Self::Normal(normal) => normal.pairs(),
            Self::Full(full) => full.pairs(),
            Self::Plate(plate) => plate.pairs(),
        }
    }

    /// Returns the counter of transforms, for a solve that continues an earlier one.
    pub fn counter(&mut self) -> &mut u64 {
        match self {
            Self::Normal(normal) => normal.counter(),
            Self::Full(full) => full.counter(),
            Self::Plate(plate) => plate.counter(),
        }
    }
}

/// Transforms of a [`NormalResponse`], with their memory and a counter. Each process has its own rows and modes.
///
/// # Panics
/// Every method panics if a field does not have the size of the grid, or a kernel not the number of its modes.
#[derive(Debug)]
pub struct NormalTransforms {
    response: Arc<NormalResponse>,
    /// Allocated by the first transform.
    workspace: Option<gfmd_field::Workspace>,
    /// Number of single transforms.
    singles: u64,
}

impl NormalTransforms {
    /// Creates transforms on the grid of `response`, with the counter at zero.
    pub fn of(response: &Arc<NormalResponse>) -> Self {
        Self { response: Arc::clone(response), workspace: None, singles: 0 }
    }

    /// Frees the memory until the next transform.
    pub fn release(&mut self) {
        self.workspace = None;
    }

    fn parts(&mut self) -> (&Transform, &mut gfmd_field::Workspace) {
        let transform = self.response.transform();
        (transform, self.workspace.get_or_insert_with(|| transform.workspace()))
    }

    /// Computes `out` = F⁻¹\[k F\[field\]\], with a real kernel k laid out as [`Grid::modes`].
    pub fn convolve(&mut self, kernel: &[f64], field: &[f64], out: &mut [f64]) {
        self.singles += 2;
        let (transform, workspace) = self.parts();
        fits(transform.convolve(kernel, field, out, workspace));
    }

    /// Applies [`convolve`](Self::convolve) row by row; see [`gfmd_field::Transform::convolve_rows`].
    pub fn convolve_rows<I: Split, O: Split>(
        &mut self,
        kernel: &[f64],
        input: I,
        source: impl Fn(usize, I, &mut [f64]) + Sync,
        output: O,
        sink: impl Fn(usize, &mut [f64], O) + Sync,
    ) {
        self.singles += 2;
        let (transform, workspace) = self.parts();
        fits(transform.convolve_rows(kernel, input, source, output, sink, workspace));
    }

    /// Returns the number of points of the grid, over all processes.
    pub fn points(&self) -> usize {
        self.response.grid().len()
    }

    /// Returns (1/N) Σ_r f (K f) over all rows, where K is the convolution with `kernel`, from one transform.
    pub fn quadratic_form(&mut self, kernel: &[f64], field: &[f64]) -> f64 {
        self.singles += 1;
        let (transform, workspace) = self.parts();
        fits(transform.quadratic_form(kernel, field, workspace))
    }

    /// Returns the number of pairs of forward and inverse transforms so far.
    pub fn pairs(&self) -> f64 {
        self.singles as f64 / 2.0
    }

    /// Returns the counter of single transforms, for a solve that continues an earlier one.
    pub fn counter(&mut self) -> &mut u64 {
        &mut self.singles
    }
}

/// Transforms of a [`FullResponse`], with their memory and a counter.
///
/// # Panics
/// Every method panics if a field does not have the size of the grid times the number of its components.
#[derive(Debug)]
pub struct FullTransforms {
    response: Arc<FullResponse>,
    workspace: Workspace,
    /// Number of transform pairs of one component.
    pairs: u64,
}

impl FullTransforms {
    /// Allocates memory for transforms on the grid of `response`, with the counter at zero.
    pub fn of(response: &Arc<FullResponse>) -> Self {
        Self { response: Arc::clone(response), workspace: response.workspace(), pairs: 0 }
    }

    /// Computes traction = K displacement.
    pub fn stiffness(&mut self, displacement: &[f64], traction: &mut [f64]) {
        self.pairs += self.response.components().len() as u64;
        fits(self.response.stiffness().apply(displacement, traction, &mut self.workspace));
    }

    /// Computes displacement = G traction.
    pub fn compliance(&mut self, traction: &[f64], displacement: &mut [f64]) {
        self.pairs += self.response.components().len() as u64;
        fits(self.response.compliance().apply(traction, displacement, &mut self.workspace));
    }

    /// Computes the lateral displacement caused by a lateral traction: u_x, u_y from t_x, t_y (x alone on a line).
    pub fn lateral_compliance(&mut self, traction: &[f64], displacement: &mut [f64]) {
        self.pairs += self.response.components().len() as u64 - 1;
        fits(self.response.compliance().apply_laterally(traction, displacement, &mut self.workspace));
    }

    /// Computes the lateral traction of a lateral displacement without u_z: t_x, t_y from u_x, u_y (x alone on a line).
    pub fn lateral_stiffness(&mut self, displacement: &[f64], traction: &mut [f64]) {
        self.pairs += self.response.components().len() as u64 - 1;
        fits(self.response.stiffness().apply_laterally(displacement, traction, &mut self.workspace));
    }

    /// Returns the number of pairs of forward and inverse transforms of one component so far.
    pub fn pairs(&self) -> f64 {
        self.pairs as f64
    }

    /// Returns the counter of pairs, for a solve that continues an earlier one.
    pub fn counter(&mut self) -> &mut u64 {
        &mut self.pairs
    }
}

/// Unwraps the result of an operation on fields with a size guaranteed by the caller.
pub(crate) fn fits<T>(outcome: Result<T, gfmd_field::ShapeError>) -> T {
    outcome.expect("every field has the size of the grid")
}

/// Adds the uniform mode to the result of a table without it, which has zero mean.
fn add_uniform(share: &Share, field: &[f64], uniform: f64, out: &mut [f64]) {
    if uniform != 0.0 {
        let change = uniform * mean(share, field);
        gfmd_vector::for_each([out], &|_, [out]| out.iter_mut().for_each(|out| *out += change));
    }
}

fn set_means(share: &Share, field: &[f64], uniform: &[f64], out: &mut [f64]) {
    let points = share.own().len();
    for ((field, out), uniform) in field.chunks_exact(points).zip(out.chunks_exact_mut(points)).zip(uniform) {
        let change = uniform * mean(share, field) - mean(share, out);
        gfmd_vector::for_each([out], &|_, [out]| out.iter_mut().for_each(|out| *out += change));
    }
}

/// Returns the mean of a field over all processes.
fn mean(share: &Share, field: &[f64]) -> f64 {
    share.total_of(field) / share.total() as f64
}
