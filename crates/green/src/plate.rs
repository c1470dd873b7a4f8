use crate::{Base, Blocks, Body, GreenError, Ground, Height, Material, sagittal::product, slab::LayerMode};

/// A slab or a stack of layers pressed on both faces without friction. A base is ignored: the plate is held by the
/// pressures alone (theory.md, section 4.3).
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// From the top down, with a free base.
    body: Body,
    /// From the bottom up, with a free base.
    turned: Body,
}

/// The compliance of a [`Plate`] at one wavenumber, in length/stress: the indentations of upper and lower face, both
/// into the plate, caused by the pressures on them, with d₊ = (d_upper + d_lower)/2, d₋ = (d_upper − d_lower)/2, and
/// p₊, p₋ alike:
///
/// ```text
///   d₊ = squeezing p₊ + mixed p₋
///   d₋ = mixed p₊ + bending p₋
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlateCompliance {
    /// Compliance to equal pressures on the two faces.
    pub squeezing: f64,
    /// Compliance to opposite pressures on the two faces. It grows as q⁻⁴ at long waves, and is infinite at q = 0.
    pub bending: f64,
    /// Half the difference of the compliances of the two faces; zero for a single layer, and at q = 0.
    pub mixed: f64,
}

impl Plate {
    /// The layers of `body`, from its top down to its base.
    ///
    /// # Errors
    /// A body with a half-space below, or a pair of bodies.
    pub fn of(body: &Body) -> Result<Self, GreenError> {
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
        let plate = Body::stack(&layers, Base::FREE)?;
        layers.reverse();
        Ok(Self { body: plate, turned: Body::stack(&layers, Base::FREE)? })
    }

    /// The plate upside down.
    #[must_use]
    pub fn turned(&self) -> Self {
        Self { body: self.turned.clone(), turned: self.body.clone() }
    }

    /// The plate in other units of stress and length, which are given in the present ones.
    #[must_use]
    pub fn in_units(&self, stress: f64, length: f64) -> Self {
        Self { body: self.body.in_units(stress, length), turned: self.turned.in_units(stress, length) }
    }

    /// The contact modulus E* of the material at the upper face, in stress.
    pub fn contact_modulus(&self) -> f64 {
        self.body.contact_modulus()
    }

    /// The compliance at the wavenumber `q` (rad/length).
    ///
    /// At q = 0 the squeezing is half of Σ height/C11, since each face takes half of the compression.
    pub fn compliance(&self, q: f64) -> PlateCompliance {
        let q = q.abs();
        if q == 0.0 {
            let [_, compression] = self.body.level_compliance();
            return PlateCompliance { squeezing: 0.5 * compression, bending: f64::INFINITY, mixed: 0.0 };
        }
        if let (Base::Rigid(_), Height::Finite(height)) = (self.body.base(), self.body.height()) {
            // Mirror images: each half is a slab on a base that slides, or that yields only normally.
            let half = LayerMode::new(self.body.material(), 0.5 * height, q);
            let [squeezing, bending] =
                [Ground::SLIDING, Ground::GUIDED].map(|ground| half.normal_compliance_over(ground));
            return PlateCompliance { squeezing, bending, mixed: 0.0 };
        }
        let [upper, lower] = [&self.body, &self.turned].map(|body| body.normal_compliance(q));
        let (mean, through) = (0.5 * (upper + lower), self.through(q));
        PlateCompliance { squeezing: mean - through, bending: mean + through, mixed: 0.5 * (upper - lower) }
    }

    /// The normal displacement of the lower face per normal traction on the upper one.
    fn through(&self, q: f64) -> f64 {
        let mut displacement: Blocks = self.body.compliance_blocks(q);
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
