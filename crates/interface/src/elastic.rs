use gfmd_field::Grid;
use gfmd_response::{FullResponse, NormalResponse};

use crate::numbers::mean;

/// The elastic side: u_z alone, or all components.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Elastic<'a> {
    Normal(&'a NormalResponse),
    Full(&'a FullResponse),
}

impl<'a> Elastic<'a> {
    pub(crate) fn grid(&self) -> &'a Grid {
        match self {
            Self::Normal(response) => response.grid(),
            Self::Full(response) => response.grid(),
        }
    }

    /// Components of a field; z is the last.
    pub(crate) fn components(&self) -> usize {
        match self {
            Self::Normal(_) => 1,
            Self::Full(response) => response.components().len(),
        }
    }

    /// Compliance of the uniform mode, component by component; 0 where the mean does not answer to the mean traction.
    pub(crate) fn uniform_compliance(&self) -> Vec<f64> {
        match self {
            Self::Normal(response) => vec![response.uniform_compliance()],
            Self::Full(response) => {
                let all = response.uniform_compliance();
                response.components().axes().iter().map(|&axis| all[axis]).collect()
            }
        }
    }

    pub(crate) fn stiffness_range(&self) -> [f64; 2] {
        match self {
            Self::Normal(response) => response.stiffness_range(),
            Self::Full(response) => response.stiffness_range(),
        }
    }

    pub(crate) fn transforms(self) -> Transforms<'a> {
        let workspace = match self {
            Self::Normal(response) => Workspace::Normal(response.transform().workspace()),
            Self::Full(response) => Workspace::Full(response.workspace()),
        };
        Transforms { elastic: self, workspace, pairs: 0 }
    }
}

enum Workspace {
    Normal(gfmd_field::Workspace),
    Full(gfmd_response::Workspace),
}

/// Stiffness and compliance of all modes but the uniform one, which is the caller's, with the memory they need.
pub(crate) struct Transforms<'a> {
    elastic: Elastic<'a>,
    workspace: Workspace,
    /// Pairs of transforms of one component so far.
    pub(crate) pairs: u64,
}

/// The lengths are those of the grid, by construction: a transform cannot refuse them.
const FITS: &str = "every field of an interface has the size of its grid";

impl Transforms<'_> {
    /// `out` ← K `field`; the mean of a component becomes `uniform` times that of the field.
    pub(crate) fn stiffness(&mut self, field: &[f64], uniform: &[f64], out: &mut [f64]) {
        self.pairs += self.elastic.components() as u64;
        match (self.elastic, &mut self.workspace) {
            (Elastic::Normal(response), Workspace::Normal(ws)) => {
                response.transform().convolve(response.stiffness(), field, out, ws).expect(FITS);
            }
            (Elastic::Full(response), Workspace::Full(ws)) => response.stiffness().apply(field, out, ws).expect(FITS),
            _ => unreachable!("the workspace was made for this response"),
        }
        self.set_means(field, uniform, out);
    }

    /// `out` ← G `field`, likewise.
    pub(crate) fn compliance(&mut self, field: &[f64], uniform: &[f64], out: &mut [f64]) {
        self.pairs += self.elastic.components() as u64;
        match (self.elastic, &mut self.workspace) {
            (Elastic::Normal(response), Workspace::Normal(ws)) => {
                response.transform().convolve(response.compliance(), field, out, ws).expect(FITS);
            }
            (Elastic::Full(response), Workspace::Full(ws)) => response.compliance().apply(field, out, ws).expect(FITS),
            _ => unreachable!("the workspace was made for this response"),
        }
        self.set_means(field, uniform, out);
    }

    fn set_means(&self, field: &[f64], uniform: &[f64], out: &mut [f64]) {
        let points = self.elastic.grid().len();
        for ((field, out), uniform) in field.chunks_exact(points).zip(out.chunks_exact_mut(points)).zip(uniform) {
            let change = uniform * mean(field) - mean(out);
            gfmd_vector::for_each([out], &|_, [out]| out.iter_mut().for_each(|out| *out += change));
        }
    }
}
