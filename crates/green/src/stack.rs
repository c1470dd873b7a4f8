//! Layer on its base: stiffness at the top, and state at the bottom.

use crate::{
    Base, Blocks, Condition, Ground,
    sagittal::{Real2, add, blocks, hermitian, inverse, product, real, scaled, times, transposed},
    slab::LayerMode,
};

/// Displacement and traction (σ_xz, σ_yz, σ_zz) on one plane of a body, per displacement of a plane above it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State {
    pub(crate) displacement: Blocks,
    /// In stress/length.
    pub(crate) traction: Blocks,
}

impl State {
    /// Returns the state per displacement of another plane, with the displacement `other` in the current units.
    fn per(&self, other: &Blocks) -> Self {
        let inverse = blocks(inverse(real(other)), 1.0 / other.transverse);
        Self { displacement: product(&self.displacement, &inverse), traction: product(&self.traction, &inverse) }
    }
}

/// Basis of the states at the top of a body that satisfy all conditions below it.
///
/// The stiffness is traction · displacement⁻¹, the compliance displacement · traction⁻¹. Dividing only at the end keeps
/// the digits of both if one is nearly singular, as for a thin, sliding, nearly incompressible layer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Basis {
    state: State,
    /// q·thickness of the thin layers since the last division. Propagation over larger distances makes states alike.
    reach: f64,
}

impl Basis {
    pub(crate) fn of_stiffness(stiffness: Blocks) -> Self {
        Self { state: State { displacement: Blocks::diagonal(1.0, 1.0), traction: stiffness }, reach: 0.0 }
    }

    pub(crate) fn stiffness(&self) -> Blocks {
        quotient(&self.state.traction, &self.state.displacement)
    }

    pub(crate) fn compliance(&self) -> Blocks {
        quotient(&self.state.displacement, &self.state.traction)
    }
}

/// Returns the quotient a b⁻¹, which must be Hermitian.
fn quotient(a: &Blocks, b: &Blocks) -> Blocks {
    hermitian(times(real(a), inverse(real(b))), a.transverse / b.transverse)
}

impl LayerMode<'_> {
    /// Returns the stiffness at the top of the layer on `base`.
    pub(crate) fn stiffness_on(&self, base: &Base) -> Blocks {
        match base {
            Base::Rigid(ground) => self.stiffness_over(*ground),
            Base::Elastic(below) if !self.is_thin() => self.thick_stiffness(&below.stiffness_blocks(self.q)),
            Base::Elastic(_) => self.basis_on(base).stiffness(),
        }
    }

    /// Returns the compliance at the top of the layer on `base`.
    pub(crate) fn compliance_on(&self, base: &Base) -> Blocks {
        match base {
            Base::Rigid(ground) => self.compliance_over(*ground),
            Base::Elastic(_) => self.basis_on(base).compliance(),
        }
    }

    /// Returns the basis at the top of the layer on `base`.
    pub(crate) fn basis_on(&self, base: &Base) -> Basis {
        if !self.is_thin() {
            return Basis::of_stiffness(self.stiffness_on(base));
        }
        let bottom = self.bottom_basis(base);
        Basis { state: self.propagated(&bottom.state), reach: bottom.reach + self.t.raw }
    }

    /// Returns the basis at the bottom of a thin layer.
    fn bottom_basis(&self, base: &Base) -> Basis {
        match base {
            Base::Rigid(ground) => {
                // One for the quantity left open by the ground: traction or displacement.
                let open = |condition: Condition, by: Condition| f64::from(u8::from(condition == by));
                let of = |by: Condition| Blocks::diagonal(open(ground.lateral, by), open(ground.normal, by));
                let displacement = of(Condition::Free);
                let traction = of(Condition::Fixed).map(|entry| self.shear_unit() * entry);
                Basis { state: State { displacement, traction }, reach: 0.0 }
            }
            Base::Elastic(below) => {
                let basis = below.basis(self.q);
                if basis.reach + self.t.raw < 1.0 { basis } else { Basis::of_stiffness(basis.stiffness()) }
            }
        }
    }

    /// Returns the displacement and the traction at the bottom of the layer on `base`, per displacement of the top.
    pub(crate) fn base_state(&self, base: &Base) -> State {
        match base {
            Base::Rigid(Ground::BONDED) => {
                let up = self.cross_stiffness();
                let traction = scaled(transposed(real(&up)), -1.0);
                State { displacement: Blocks::diagonal(0.0, 0.0), traction: blocks(traction, -up.transverse) }
            }
            _ if self.is_thin() => {
                let bottom = self.bottom_basis(base).state;
                bottom.per(&self.propagated(&bottom).displacement)
            }
            Base::Rigid(Ground::NONE) => {
                let nothing = Blocks::diagonal(0.0, 0.0);
                State { displacement: self.transfer_to(&nothing), traction: nothing }
            }
            Base::Rigid(ground) => self.thick_state(*ground),
            Base::Elastic(below) => {
                let support = below.stiffness_blocks(self.q);
                let displacement = self.transfer_to(&support);
                State { displacement, traction: product(&support, &displacement) }
            }
        }
    }

    /// Returns the state at the bottom of a thick layer on ground that fixes one of u_long and u_z. The other component
    /// has zero traction, which gives its displacement, and then the traction of the fixed component.
    fn thick_state(&self, ground: Ground) -> State {
        let cross = self.cross_stiffness();
        let bottom = real(&self.bonded_stiffness().mirrored());
        let down = transposed(real(&cross));
        let (free, fixed, transverse) = match ground.lateral {
            Condition::Free => (0, 1, [self.t.factor / self.t.cosh, 0.0]),
            Condition::Fixed => (1, 0, [0.0, -cross.transverse]),
        };
        let moved = down[free].map(|entry| -entry / bottom[free][free]);
        let (mut displacement, mut traction) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
        displacement[free] = moved;
        traction[fixed] = [0, 1].map(|column| -down[fixed][column] - bottom[fixed][free] * moved[column]);
        State { displacement: blocks(displacement, transverse[0]), traction: blocks(traction, transverse[1]) }
    }

    /// Returns the displacement of the bottom per displacement of the top, on a base with the stiffness `support`.
    pub(crate) fn transfer_to(&self, support: &Blocks) -> Blocks {
        if self.is_thin() {
            let bottom = Basis::of_stiffness(*support).state;
            bottom.per(&self.propagated(&bottom).displacement).displacement
        } else {
            self.thick_transfer(&self.bonded_stiffness(), &self.cross_stiffness(), support)
        }
    }

    /// Returns the displacement and the traction at the top of a thin layer, given the state at the bottom.
    pub(crate) fn propagated(&self, bottom: &State) -> State {
        let unit = self.shear_unit();
        let [uu, us, su, ss] = self.propagator();
        let (u, sigma) = (real(&bottom.displacement), scaled(real(&bottom.traction), 1.0 / unit));
        let (transverse, shear) = (bottom.displacement.transverse, bottom.traction.transverse / unit);
        let (sinh, cosh) = (self.t.sinh, self.t.cosh);
        State {
            displacement: blocks(add(times(uu, u), times(us, sigma)), cosh * transverse + sinh * shear),
            traction: blocks(
                scaled(add(times(su, u), times(ss, sigma)), unit),
                unit * (sinh * transverse + cosh * shear),
            ),
        }
    }

    /// Returns the stiffness K_top = L_tt − L_tb (L_bb + K_below)⁻¹ L_bt of a thick layer. The second term decays with
    /// h (theory.md, section 4).
    ///
    /// For thin layers, L grows as 1/h and the difference cancels; [`Self::propagated`] avoids this loss.
    fn thick_stiffness(&self, support: &Blocks) -> Blocks {
        let (face, cross) = (self.bonded_stiffness(), self.cross_stiffness());
        let through = product(&cross, &self.thick_transfer(&face, &cross, support));
        hermitian(add(real(&face), real(&through)), face.transverse + through.transverse)
    }

    /// Returns the transfer −(L_bb + K_below)⁻¹ L_bt of a thick layer, given L_tt and L_tb.
    fn thick_transfer(&self, face: &Blocks, cross: &Blocks, support: &Blocks) -> Blocks {
        let bottom = add(real(&face.mirrored()), real(support));
        let sagittal = scaled(times(inverse(bottom), transposed(real(cross))), -1.0);
        blocks(sagittal, -cross.transverse / (face.transverse + support.transverse))
    }

    /// Returns the matrix from (u, σ/(C44 q)) at the bottom of a thin layer to (u, σ/(C44 q)) at the top, with the
    /// sagittal part in real form: the blocks uu, us, su, ss.
    ///
    /// The equations of elasticity are d/d(qz) (a, w, σ, τ) = A (a, w, σ, τ), and B = A² − 1 satisfies B² = 0, so that
    /// exp(h A) = cosh h + A sinh h + B (h/2) sinh h + A B (h cosh h − sinh h)/2.
    fn propagator(&self) -> [Real2; 4] {
        let (h, s, k) = (self.t.raw, self.material.s(), self.material.one_minus_s());
        let (sinh, cosh) = (self.t.sinh, self.t.cosh);
        let half = (0.5 * h).sinh();
        let p = 0.5 * k * h * sinh;
        let g = 0.5 * k * (h * 2.0 * half * half - self.t.sinh_minus_h);
        let e = 1.0 - 2.0 * s;
        [
            [[cosh + 2.0 * p, -sinh - 2.0 * g], [e * sinh + 2.0 * g, cosh - 2.0 * p]],
            [[sinh + g, -p], [p, s * sinh - g]],
            [[4.0 * (k * sinh + g), -4.0 * p], [4.0 * p, -4.0 * g]],
            [[cosh + 2.0 * p, -e * sinh - 2.0 * g], [sinh + 2.0 * g, cosh - 2.0 * p]],
        ]
    }

    pub(crate) fn is_thin(&self) -> bool {
        self.t.raw < 1.0
    }
}
