/// Returns the largest of non-negative residuals; NaN if any is NaN, while [`f64::max`] would ignore it.
///
/// ```
/// assert_eq!(gfmd_relax::worst([0.1, 0.3, 0.2]), 0.3);
/// assert!(gfmd_relax::worst([f64::NAN, 0.3, 0.0]).is_nan());
/// assert_eq!(gfmd_relax::worst([]), 0.0);
/// ```
pub fn worst(residuals: impl IntoIterator<Item = f64>) -> f64 {
    residuals.into_iter().fold(0.0, |worst, r| if r.is_nan() || r > worst { r } else { worst })
}

#[cfg(test)]
mod tests {
    use super::worst;

    #[test]
    fn a_nan_is_found_in_any_place() {
        for place in 0..4 {
            let mut residuals = [0.3, 0.0, f64::INFINITY, 0.1];
            residuals[place] = f64::NAN;
            assert!(worst(residuals).is_nan(), "{residuals:?}");
        }
    }
}
