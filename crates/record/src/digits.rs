//! Numbers with the digits that are certain.

/// A value with its error in units of its last digits, such as `0.1014(12)`: one digit of the error, two if it begins with 1;
/// `-` without a value.
pub fn uncertain(value: f64, error: f64) -> String {
    if !(value.is_finite() && error.is_finite() && error > 0.0) {
        return if value.is_finite() && error == 0.0 { format!("{value}") } else { "-".into() };
    }
    // Errors of 0.95 to 1 of a decade are rounded up to the next one, with two digits.
    let decade = (error / 0.95).log10().floor() as i32;
    let leads_with_one = error / 10_f64.powi(decade) < 1.95;
    let decimals = i32::from(leads_with_one) - decade;
    let digits = (error * 10_f64.powi(decimals)).round();
    if decimals >= 0 {
        format!("{value:.*}({digits:.0})", decimals as usize)
    } else {
        let unit = 10_f64.powi(-decimals);
        format!("{:.0}({:.0})", (value / unit).round() * unit, digits * unit)
    }
}

#[cfg(test)]
mod tests {
    use super::uncertain;

    #[test]
    fn a_value_has_the_digits_that_its_error_leaves() {
        for (value, error, text) in [
            (0.101_41, 0.001_21, "0.1014(12)"),
            (0.746_812, 0.000_62, "0.7468(6)"),
            (0.5, 0.099, "0.50(10)"),
            (1234.5, 31.0, "1230(30)"),
            (1234.5, 2.2, "1234(2)"),
            (12.0, 0.0, "12"),
            (f64::NAN, 0.1, "-"),
            (0.3, f64::NAN, "-"),
        ] {
            assert_eq!(uncertain(value, error), text);
        }
    }
}
