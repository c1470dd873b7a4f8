use ndarray::Array2;

/// Compliance of springs that act point by point between the surfaces, in length/stress, not negative: the distance by
/// which a pressure shortens the spring at its point, divided by the pressure.
#[derive(Clone, Debug, PartialEq)]
pub enum Springs {
    /// One value for the whole surface.
    Uniform(f64),
    /// One value for each point `[x, y]`, for example of a thin coating or of surfaces that wear differently.
    Field(Array2<f64>),
}

impl From<f64> for Springs {
    fn from(compliance: f64) -> Self {
        Self::Uniform(compliance)
    }
}

impl From<Array2<f64>> for Springs {
    fn from(field: Array2<f64>) -> Self {
        Self::Field(field)
    }
}
