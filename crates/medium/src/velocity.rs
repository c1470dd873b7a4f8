/// Velocity of the rigid surface relative to the body, length per time unit of the relaxation times.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Velocity {
    speed: f64,
    direction: [f64; 2],
}

/// Error: an invalid velocity.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum VelocityError {
    /// Speed that is not positive and finite.
    #[error("the velocity is {0}; it must be positive and finite")]
    Speed(f64),
    /// Angle that is not finite.
    #[error("the direction is {0} degrees; it must be finite")]
    Direction(f64),
}

impl Velocity {
    /// Creates a velocity from its `speed` and its angle to x in degrees.
    ///
    /// # Errors
    /// Returns an error if the speed is not positive and finite, or if the angle is not finite.
    pub fn new(speed: f64, degrees: f64) -> Result<Self, VelocityError> {
        if !(speed.is_finite() && speed > 0.0) {
            return Err(VelocityError::Speed(speed));
        }
        if !degrees.is_finite() {
            return Err(VelocityError::Direction(degrees));
        }
        let angle = degrees.to_radians();
        // Directions along an axis are exact, without the rounding error of a sine.
        let direction = match degrees.rem_euclid(360.0) {
            0.0 => [1.0, 0.0],
            90.0 => [0.0, 1.0],
            180.0 => [-1.0, 0.0],
            270.0 => [0.0, -1.0],
            _ => [angle.cos(), angle.sin()],
        };
        Ok(Self { speed, direction })
    }

    /// Returns the speed.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Returns the unit vector along the velocity.
    pub fn direction(&self) -> [f64; 2] {
        self.direction
    }

    /// Returns the scalar product with a wave vector.
    pub(crate) fn along(&self, [x, y]: [f64; 2]) -> f64 {
        self.speed * (x * self.direction[0] + y * self.direction[1])
    }
}
