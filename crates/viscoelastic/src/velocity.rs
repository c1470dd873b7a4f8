/// The velocity of the rigid surface relative to the body, in length over the unit of the relaxation times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Velocity {
    speed: f64,
    direction: [f64; 2],
}

/// Error: a velocity without a size or a direction.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum VelocityError {
    /// A speed that is not positive.
    #[error("the velocity is {0}; it must be positive and finite")]
    Speed(f64),
    /// An angle that is not finite.
    #[error("the direction is {0} degrees; it must be finite")]
    Direction(f64),
}

impl Velocity {
    /// A velocity of this size, in a direction of so many degrees from x.
    ///
    /// # Errors
    /// A size that is not positive and finite; an angle that is not finite.
    pub fn new(speed: f64, degrees: f64) -> Result<Self, VelocityError> {
        if !(speed.is_finite() && speed > 0.0) {
            return Err(VelocityError::Speed(speed));
        }
        if !degrees.is_finite() {
            return Err(VelocityError::Direction(degrees));
        }
        let angle = degrees.to_radians();
        // Along an axis it is exactly so, without the rounding error of a sine.
        let direction = match degrees.rem_euclid(360.0) {
            0.0 => [1.0, 0.0],
            90.0 => [0.0, 1.0],
            180.0 => [-1.0, 0.0],
            270.0 => [0.0, -1.0],
            _ => [angle.cos(), angle.sin()],
        };
        Ok(Self { speed, direction })
    }

    /// The size.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// The unit vector along it.
    pub fn direction(&self) -> [f64; 2] {
        self.direction
    }

    /// The scalar product with a wave vector.
    pub(crate) fn along(&self, [x, y]: [f64; 2]) -> f64 {
        self.speed * (x * self.direction[0] + y * self.direction[1])
    }
}
