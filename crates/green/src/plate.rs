use crate::{Base, Blocks, Body, GreenError, Ground, Height, Material, sagittal::product, slab::LayerMode};

/// Slab or stack of layers pressed on both faces without friction, or [held sideways](Self::held_sideways) on both. A
/// base is ignored: the two faces alone hold the plate (theory.md, section 4.3).
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// Layers from the top down, with a free base, or one that moves only along z if both faces are held sideways.
    body: Body,
    /// Layers from the bottom up, with the same base.
    turned: Body,
    /// True if no point of the faces moves sideways.
    is_held: bool,
}

/// Compliance of a [`Plate`] at one wavenumber, in length/stress. It relates the indentations of the upper and the
/// lower face, both positive into the plate, to the pressures on them, with d₊ = (d_upper + d_lower)/2, d₋ = (d_upper −
/// d_lower)/2, and p₊, p₋ alike:
///
/// ```text
///   d₊ = squeezing p₊ + mixed p₋
///   d₋ = mixed p₊ + bending p₋
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateCompliance {
    /// Compliance to equal pressures on the two faces.
    pub squeezing: f64,
    /// Compliance to opposite pressures on the two faces. It grows as q⁻⁴ for long waves, as q⁻² if the faces are held
    /// sideways, and is infinite at q = 0.
    pub bending: f64,
    /// Half the difference between the compliances of the two faces; zero for a single layer and at q = 0.
    pub mixed: f64,
}

impl Plate {
    /// Creates a plate from the layers of `body`, without its base.
    ///
    /// # Errors
    /// Returns an error for a body with a half-space below and for a pair of bodies.
    pub fn of(body: &Body) -> Result<Self, GreenError> {
        Self::on(body, Base::FREE, false)
    }

    /// Creates a plate as [`of`](Self::of), with no lateral displacement on either face: the surfaces that press it
    /// hold all their points.
    ///
    /// # Errors
    /// Returns an error for a body with a half-space below and for a pair of bodies.
    pub fn held_sideways(body: &Body) -> Result<Self, GreenError> {
        Self::on(body, Base::Rigid(Ground::GUIDED), true)
    }

    fn on(body: &Body, base: Base, is_held: bool) -> Result<Self, GreenError> {
        if body.second().is_some() {
            return Err(GreenError::Plate("a pair of bodies"));
        }
        let mut layers: Vec<(Material, f64)> = Vec::new();
        let mut local = body;
        loop {
            let Height::Finite(height) = local.height() else { return Err(GreenError::Plate("a half-space")) };
            layers.push((*local.material(), height));
            let Base::Elastic(below) = local.base() else { break };
            local = below;
        }
        let plate = Body::stack(&layers, base.clone())?;
        layers.reverse();
        Ok(Self { body: plate, turned: Body::stack(&layers, base)?, is_held })
    }

    /// Returns the plate upside down.
    #[must_use]
    pub fn turned(&self) -> Self {
        Self { body: self.turned.clone(), turned: self.body.clone(), is_held: self.is_held }
    }

    /// Converts the plate to other units of stress and length, given in the current units.
    #[must_use]
    pub fn in_units(&self, stress: f64, length: f64) -> Self {
        let [body, turned] = [&self.body, &self.turned].map(|body| body.in_units(stress, length));
        Self { body, turned, is_held: self.is_held }
    }

    /// Returns the contact modulus E* of the material at the upper face, in stress.
    pub fn contact_modulus(&self) -> f64 {
        self.body.contact_modulus()
    }

    /// Returns the compliance at the wavenumber `q` (rad/length).
    ///
    /// At q = 0, the squeezing compliance is half of Σ height/C11, since each face takes half of the compression.
    pub fn compliance(&self, q: f64) -> PlateCompliance {
        let q = q.abs();
        if q == 0.0 {
            let [_, compression] = self.body.level_compliance();
            return PlateCompliance { squeezing: 0.5 * compression, bending: f64::INFINITY, mixed: 0.0 };
        }
        if let (Base::Rigid(_), Height::Finite(height)) = (self.body.base(), self.body.height()) {
            // By symmetry, each half is a slab on a base that slides, or that moves only along z.
            let half = LayerMode::new(self.body.material(), 0.5 * height, q);
            let [squeezing, bending] = [Ground::SLIDING, Ground::GUIDED].map(|ground| match self.is_held {
                false => half.normal_compliance_over(ground),
                true => 1.0 / half.stiffness_over(ground).normal,
            });
            return PlateCompliance { squeezing, bending, mixed: 0.0 };
        }
        let [upper, lower] = [&self.body, &self.turned].map(|body| match self.is_held {
            false => body.normal_compliance(q),
            true => 1.0 / body.restricted_normal_stiffness(q),
        });
        let top = if self.is_held { Blocks::diagonal(0.0, upper) } else { self.body.compliance_blocks(q) };
        let (mean, through) = (0.5 * (upper + lower), self.through(q, top));
        PlateCompliance { squeezing: mean - through, bending: mean + through, mixed: 0.5 * (upper - lower) }
    }

    /// Returns the normal displacement of the lower face per normal traction on the upper face, with the compliance
    /// `top` of the upper face.
    fn through(&self, q: f64, top: Blocks) -> f64 {
        let mut displacement = top;
        let mut local = &self.body;
        while let Height::Finite(height) = local.height() {
            let layer = LayerMode::new(local.material(), height, q);
            displacement = product(&layer.base_state(local.base()).displacement, &displacement);
            let Base::Elastic(below) = local.base() else { break };
            local = below;
        }
        displacement.normal
    }
}
