use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use gfmd_contact::{Boundary, Refusal};
use gfmd_field::{Grid, Transform, Workspace};
use gfmd_green::{Body, Plate};
use gfmd_response::{PlateResponse, PlateTransforms};
use gfmd_vector::{Share, contiguous, dot};
use ndarray::Array2;
use num_complex::Complex64;

use crate::derivatives::{Decays, Lengths};
use crate::memory::{Fields, PointStep};
use crate::spectrum::{Modes, Spectrum, stiffness};
use crate::{Affine, Energies, Medium, Memory, MemoryDerivatives, Prony, Relaxes, Stiffening};

/// Body that relaxes by a Prony series (theory.md, section 7.7). Each step is exact for a displacement linear in time,
/// whatever its duration; a step of zero duration is a jump.
#[derive(Clone)]
pub struct Relaxing {
    grid: Grid,
    boundary: Boundary,
    components: usize,
    /// True if the surface has no lateral displacement.
    held: bool,
    spectrum: Arc<Spectrum>,
    /// Points of this process.
    share: Share,
    /// Transforms, if each wave of the body has its own branches.
    transform: Option<Arc<(Transform, Mutex<Workspace>)>>,
}

impl Relaxing {
    /// Creates the medium of `body`, which has its long-term moduli, below a surface on `grid`. The second body of a
    /// pair is elastic. With one of the `components` its memory holds u_z alone, else all components.
    ///
    /// # Errors
    /// Returns an error if only the shear modulus relaxes, and this relaxation is not known for the body, the boundary
    /// or all components; and for a pair of bodies in all components, or with a slab on a patch.
    pub fn new(
        body: &Body,
        grid: &Grid,
        boundary: Boundary,
        components: usize,
        prony: &Prony,
        relaxes: Relaxes,
    ) -> Result<Self, Refusal> {
        Self::distributed(&grid.whole(), body, grid, boundary, components, prony, relaxes)
    }

    /// Creates the medium as [`new`](Self::new), with the points of this process, one of several that make the same
    /// calls, and with its waves.
    ///
    /// # Errors
    /// Returns an error as [`new`](Self::new), on all processes.
    pub fn distributed(
        share: &Share,
        body: &Body,
        grid: &Grid,
        boundary: Boundary,
        components: usize,
        prony: &Prony,
        relaxes: Relaxes,
    ) -> Result<Self, Refusal> {
        let transform = Transform::distributed(*grid, share);
        let modes = Modes::of(grid, transform.lanes());
        let spectrum = Spectrum::new(body, &modes, boundary == Boundary::Free, prony, relaxes)?;
        let alike = relaxes == Relaxes::Both || body.material().poisson() == 0.5;
        if components > 1 && !alike {
            return Err(Refusal::ShearAlone { with: "shear at the surface" });
        }
        if components > 1 && body.second().is_some() {
            return Err(Refusal::RelaxingPair { with: "shear at the surface" });
        }
        let transform = match &spectrum {
            Spectrum::Common(_) => None,
            Spectrum::Waves(_) => {
                let workspace = Mutex::new(transform.workspace());
                Some(Arc::new((transform, workspace)))
            }
        };
        let (grid, share, spectrum) = (*grid, share.clone(), spectrum.into());
        Ok(Self { grid, boundary, components, held: false, spectrum, share, transform })
    }

    /// Returns the number of values of this process.
    fn values(&self) -> usize {
        self.components * self.share.own().len()
    }

    /// Returns the medium below a surface without lateral displacement.
    ///
    /// # Errors
    /// Returns an error if only the shear modulus relaxes, each wave by branches of its own.
    pub fn held_sideways(self) -> Result<Self, Refusal> {
        match &*self.spectrum {
            Spectrum::Common(_) => Ok(Self { held: true, ..self }),
            Spectrum::Waves(_) => Err(Refusal::ShearAlone { with: "a surface held sideways" }),
        }
    }

    /// Returns d + Σ c x of the [memory](Memory::normal) along z, row by row, in length: the indentation by the present
    /// pressure with the long-term moduli.
    ///
    /// # Errors
    /// Returns an error if the size of the fields or their number does not match the grid or the branches.
    pub fn long_term_indentation(&self, memory: &[Array2<f64>]) -> Result<Vec<f64>, Refusal> {
        self.check(memory)?;
        let memory: Vec<_> = memory.iter().map(|field| contiguous(field)).collect();
        Ok(match &*self.spectrum {
            Spectrum::Common(branches) => (0..self.grid.len())
                .map(|i| memory[0][i] + branches.iter().zip(&memory[1..]).map(|(b, x)| b.weight * x[i]).sum::<f64>())
                .collect(),
            Spectrum::Waves(waves) => {
                let mut spectra: Vec<Vec<Complex64>> = memory.iter().map(|field| self.forward(field)).collect();
                let mut total = spectra.remove(0);
                for (mode, total) in total.iter_mut().enumerate() {
                    *total += waves.of(mode).zip(&spectra).map(|(b, x)| b.weight * x[mode]).sum::<Complex64>();
                }
                self.inverse(&total)
            }
        })
    }

    /// Computes the energy stored in all springs, per area, from the [memory](Memory::normal) along z; `body` is the
    /// body of the medium. `None` with free boundaries, where the pressure of each spring is needed.
    ///
    /// # Errors
    /// Returns an error if the size of the fields or their number does not match the grid or the branches.
    pub fn elastic_energy(&self, body: &Body, memory: &[Array2<f64>]) -> Result<Option<f64>, Refusal> {
        self.check(memory)?;
        if self.boundary == Boundary::Free {
            return Ok(None);
        }
        let grid = self.grid;
        let stiffness_of = if self.held { Body::restricted_normal_stiffness } else { Body::normal_stiffness };
        let (transform, stiffness) = (Transform::new(grid), stiffness(body, &Modes::all(&grid), stiffness_of));
        let mut workspace = transform.workspace();
        let mut spectra = Vec::new();
        for field in memory {
            let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
            transform.forward(&contiguous(field), &mut spectrum, &mut workspace)?;
            spectra.push(spectrum);
        }
        let weights = |mode: usize| -> Vec<f64> {
            match &*self.spectrum {
                Spectrum::Common(branches) => branches.iter().map(|branch| branch.weight).collect(),
                Spectrum::Waves(waves) => waves.of(mode).map(|branch| branch.weight).collect(),
            }
        };
        let of = |mode: usize| {
            let branches = weights(mode).into_iter().zip(&spectra[1..]).map(|(weight, x)| weight * x[mode].norm_sqr());
            0.5 * grid.mode_at(mode).weight * stiffness[mode] * (spectra[0][mode].norm_sqr() + branches.sum::<f64>())
        };
        // The mean level of a half-space does not move.
        let modes = (0..grid.spectrum_len()).filter(|mode| stiffness[*mode].is_finite());
        Ok(Some(modes.map(of).sum()))
    }

    /// Computes the energy stored in all springs as [`elastic_energy`](Self::elastic_energy), of a plate between two
    /// surfaces from the memories of both faces; `body` is its body without the base.
    ///
    /// # Errors
    /// Returns an error as [`elastic_energy`](Self::elastic_energy), for a body that is no plate, and for a body whose
    /// waves relax by branches of their own.
    pub fn elastic_energy_of_plate(&self, body: &Body, memories: [&[Array2<f64>]; 2]) -> Result<f64, Refusal> {
        memories.into_iter().try_for_each(|memory| self.check(memory))?;
        let Spectrum::Common(branches) = &*self.spectrum else {
            return Err(Refusal::ShearAlone { with: "a second surface" });
        };
        let plate = if self.held { Plate::held_sideways(body)? } else { Plate::of(body)? };
        let mut transforms = PlateTransforms::of(&PlateResponse::new(self.grid, &plate).into());
        // An incompressible plate is not squeezed as a whole, and its mean indentation is zero.
        let compliance = transforms.response().uniform_compliance();
        let uniform = if compliance > 0.0 { 1.0 / compliance } else { 0.0 };
        let weights = std::iter::once(1.0).chain(branches.iter().map(|branch| branch.weight));
        let [upper, lower] = memories;
        let energies = weights.zip(upper).zip(lower).map(|((weight, upper), lower)| {
            let lengths: Vec<f64> = upper.iter().chain(lower).copied().collect();
            let mut stresses = vec![0.0; lengths.len()];
            transforms.stiffness(uniform, &lengths, &mut stresses);
            0.5 * weight * dot(&lengths, &stresses) / upper.len() as f64
        });
        Ok(energies.sum())
    }

    fn check(&self, memory: &[Array2<f64>]) -> Result<(), Refusal> {
        let expected = 1 + self.branches();
        if memory.len() != expected {
            return Err(Refusal::Basis { found: memory.len(), expected });
        }
        let wrong = memory.iter().find(|field| field.len() != self.grid.len());
        wrong.map_or(Ok(()), |field| Err(Refusal::Start { found: field.len(), expected: self.grid.len() }))
    }

    /// Returns the coefficients of a step.
    fn decays(&self, duration: f64) -> Decays {
        match &*self.spectrum {
            Spectrum::Common(branches) => Decays::common(branches, duration),
            Spectrum::Waves(waves) => {
                let branches = (0..waves.stiffness.len()).flat_map(|mode| waves.of(mode));
                Decays::of_waves(branches, waves.count, duration)
            }
        }
    }

    /// Checks that derivatives belong to this body, with u_z alone.
    fn check_lengths(&self, of: &Lengths) -> Result<(), Refusal> {
        let (found, sizes, expected): (_, Vec<usize>, _) = match (of, &*self.spectrum) {
            (Lengths::Points(of), Spectrum::Common(_)) => {
                (of.len(), of.iter().map(Vec::len).collect(), self.components * self.grid.len())
            }
            (Lengths::Waves(of), Spectrum::Waves(waves)) => {
                (of.len(), of.iter().map(Vec::len).collect(), waves.modes.count)
            }
            _ => return Err(Refusal::OtherKind),
        };
        if found != 1 + self.branches() {
            return Err(Refusal::Basis { found, expected: 1 + self.branches() });
        }
        let wrong = sizes.into_iter().find(|size| *size != expected);
        wrong.map_or(Ok(()), |found| Err(Refusal::Start { found, expected }))
    }

    /// Transforms a field; only for a body with wave-dependent branches.
    fn forward(&self, field: &[f64]) -> Vec<Complex64> {
        let Some((transform, workspace)) = self.transform.as_deref() else { return Vec::new() };
        let positions = transform.grid().spectrum_shape()[1];
        let mut spectrum = vec![Complex64::ZERO; transform.lanes().len() * positions];
        let workspace = &mut *workspace.lock().unwrap_or_else(PoisonError::into_inner);
        transform.forward(field, &mut spectrum, workspace).expect("the field has the size of the grid");
        spectrum
    }

    /// Transforms a spectrum back; only for a body with wave-dependent branches.
    pub(crate) fn inverse(&self, spectrum: &[Complex64]) -> Vec<f64> {
        let Some((transform, workspace)) = self.transform.as_deref() else { return Vec::new() };
        let mut field = vec![0.0; self.share.own().len()];
        let workspace = &mut *workspace.lock().unwrap_or_else(PoisonError::into_inner);
        transform.inverse(spectrum, &mut field, workspace).expect("the spectrum has the size of the grid");
        field
    }
}

impl Medium for Relaxing {
    fn rest(&self) -> Memory {
        Memory(match &*self.spectrum {
            Spectrum::Common(branches) => Fields::at_rest(self.values(), branches.len()),
            Spectrum::Waves(waves) => Fields::of_waves(waves.stiffness.len(), waves.count),
        })
    }

    fn begin(&self, memory: &Memory, duration: f64) -> Result<Affine, Refusal> {
        let (stiffening, residual_indentation) = match (&memory.0, &*self.spectrum) {
            (Fields::Points { lengths, .. }, Spectrum::Common(branches)) => {
                let step = PointStep::new(branches, duration);
                let mut residual_indentation = vec![0.0; self.values()];
                step.fill(lengths, &mut residual_indentation);
                (Stiffening::All(step.stiffening), residual_indentation)
            }
            (Fields::Waves(fields), Spectrum::Waves(waves)) => {
                let (factors, spectrum) = waves.residual_indentation(fields, duration);
                (Stiffening::Waves(factors), self.inverse(&spectrum))
            }
            _ => return Err(Refusal::OtherKind),
        };
        Ok(Affine { residual_indentation, stiffening, duration })
    }

    fn end(
        &self,
        memory: &Memory,
        step: &Affine,
        indentation: Vec<f64>,
        pressure: &[f64],
    ) -> Result<(Memory, Energies), Refusal> {
        let (fields, energies) = match (&memory.0, &*self.spectrum) {
            (Fields::Points { lengths, stresses }, Spectrum::Common(branches)) => {
                let point_step = PointStep::new(branches, step.duration);
                let (fields, energies) = point_step.advance(&self.share, (lengths, stresses), (indentation, pressure));
                // The means are over all values.
                let components = self.components as f64;
                (fields, Energies { stored: components * energies.stored, lost: components * energies.lost })
            }
            (Fields::Waves(fields), Spectrum::Waves(waves)) => {
                waves.advance(&self.share, fields, self.forward(&indentation), step.duration)
            }
            _ => return Err(Refusal::OtherKind),
        };
        Ok((Memory(fields), energies))
    }

    fn energy_derivatives(&self, memory: &Memory, factor: f64) -> Result<MemoryDerivatives, Refusal> {
        let share = factor / self.grid.len() as f64;
        match (&memory.0, &*self.spectrum) {
            (Fields::Points { stresses, .. }, Spectrum::Common(branches)) => {
                let weights = std::iter::once(1.0).chain(branches.iter().map(|branch| branch.weight));
                let of = |(weight, field): (f64, &Vec<f64>)| field.iter().map(|s| share * weight * s).collect();
                Ok(MemoryDerivatives(Lengths::Points(weights.zip(stresses).map(of).collect())))
            }
            (Fields::Waves(fields), Spectrum::Waves(waves)) => {
                let mut all = fields.clone();
                for (mode, stiffness) in waves.stiffness.iter().enumerate() {
                    // The mean level of a body may be fixed.
                    let stiffness = if stiffness.is_finite() { share * stiffness } else { 0.0 };
                    let weights = std::iter::once(1.0).chain(waves.of(mode).map(|branch| branch.weight));
                    all.iter_mut().zip(weights).for_each(|(field, weight)| field[mode] *= stiffness * weight);
                }
                Ok(MemoryDerivatives(Lengths::Waves(all)))
            }
            _ => Err(Refusal::OtherKind),
        }
    }

    fn end_transposed(&self, of: &MemoryDerivatives, duration: f64) -> Result<(Vec<f64>, MemoryDerivatives), Refusal> {
        let decays = self.decays(duration);
        self.check_lengths(&of.0)?;
        Ok(match &of.0 {
            Lengths::Points(of) => {
                let (by_indentation, start) = decays.end(of);
                (by_indentation, MemoryDerivatives(Lengths::Points(start)))
            }
            Lengths::Waves(of) => {
                let (by_indentation, start) = decays.end(of);
                (self.inverse(&by_indentation), MemoryDerivatives(Lengths::Waves(start)))
            }
        })
    }

    fn begin_transposed(
        &self,
        by_residual_indentation: &[f64],
        duration: f64,
        of: &mut MemoryDerivatives,
    ) -> Result<(), Refusal> {
        let expected = self.components * self.grid.len();
        if by_residual_indentation.len() != expected {
            return Err(Refusal::Start { found: by_residual_indentation.len(), expected });
        }
        let decays = self.decays(duration);
        self.check_lengths(&of.0)?;
        match &mut of.0 {
            Lengths::Points(of) => decays.begin(by_residual_indentation, of),
            Lengths::Waves(of) => decays.begin(&self.forward(by_residual_indentation), of),
        }
        Ok(())
    }

    fn branches(&self) -> usize {
        match &*self.spectrum {
            Spectrum::Common(branches) => branches.len(),
            Spectrum::Waves(waves) => waves.count,
        }
    }
}

impl fmt::Debug for Relaxing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Relaxing").field("branches", &self.branches()).finish_non_exhaustive()
    }
}
