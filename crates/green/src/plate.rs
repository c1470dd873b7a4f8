use crate::{Base, Blocks, Body, GreenError, Ground, Height, Material, sagittal::product, slab::LayerMode};

/// Slab or stack of layers pressed on both faces without friction. A base is ignored: the pressures alone hold the
/// plate (theory.md, section 4.3).
#[derive(Clone, Debug, PartialEq)]
pub struct Plate {
    /// Layers from the top down, with a free base.
    body: Body,
    /// Layers from the bottom up, with a free base.
    turned: Body,
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
    /// Compliance to opposite pressures on the two faces. It grows as q⁻⁴ for long waves and is infinite at q = 0.
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

    /// Returns the plate upside down.
    #[must_use]
    pub fn turned(&self) -> Self {
        Self { body: self.turned.clone(), turned: self.body.clone() }
    }

    /// Converts the plate to other units of stress and length, given in the current units.
    #[must_use]
    pub fn in_units(&self, stress: f64, length: f64) -> Self {
        Self { body: self.body.in_units(stress, length), turned: self.turned.in_units(stress, length) }
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
            let [squeezing, bending] =
                [Ground::SLIDING, Ground::GUIDED].map(|ground| half.normal_compliance_over(ground));
            return PlateCompliance { squeezing, bending, mixed: 0.0 };
        }
        let [upper, lower] = [&self.body, &self.turned].map(|body| body.normal_compliance(q));
        let (mean, through) = (0.5 * (upper + lower), self.through(q));
        PlateCompliance { squeezing: mean - through, bending: mean + through, mixed: 0.5 * (upper - lower) }
    }

    /// Returns the normal displacement of the lower face per normal traction on the upper face.
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
