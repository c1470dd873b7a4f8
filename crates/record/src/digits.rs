//! Formatting of numbers with their certain digits.

/// Formats a value by its limit on fine grids and the error of that limit: certain digits of the limit, as
/// `0.1014(12)`; two digits of the value and `~` if the limit is NaN; `-` without a value.
pub fn with_limit(value: f64, limit: f64, error: f64) -> String {
    match (value.is_nan(), limit.is_nan()) {
        (true, _) => "-".into(),
        (_, true) => roughly(value),
        _ => uncertain(limit, error),
    }
}

/// Formats a value with its error in units of the last digits, such as `0.1014(12)` or `2.512(4)e-9`. The error has one
/// digit, or two if it begins with 1; `-` without a value.
fn uncertain(value: f64, error: f64) -> String {
    if !(value.is_finite() && error.is_finite() && error > 0.0) {
        return if value.is_finite() && error == 0.0 { format!("{value}") } else { "-".into() };
    }
    // Errors of 0.95 to 1 of a decade round up to the next decade, with two digits.
    let decade = (error / 0.95).log10().floor() as i32;
    let leads_with_one = error / 10_f64.powi(decade) < 1.95;
    let power = power_of(value.abs().max(error));
    let (value, error) = (value / 10_f64.powi(power), error / 10_f64.powi(power));
    let decimals = i32::from(leads_with_one) - decade + power;
    let digits = (error * 10_f64.powi(decimals)).round();
    let text = if decimals >= 0 {
        format!("{value:.*}({digits:.0})", decimals as usize)
    } else {
        let unit = 10_f64.powi(-decimals);
        format!("{:.0}({:.0})", (value / unit).round() * unit, digits * unit)
    };
    text + &suffix(power)
}

/// Formats a value of unknown error: two digits and `~`, such as `0.10~` or `2.5e-9~`.
fn roughly(value: f64) -> String {
    let power = power_of(value.abs());
    let mantissa = value / 10_f64.powi(power);
    let decimals = if mantissa == 0.0 { 0 } else { (1 - mantissa.abs().log10().floor() as i32).max(0) };
    format!("{mantissa:.*}{}~", decimals as usize, suffix(power))
}

/// Returns the power of ten used to print a number of this size: zero from 0.001 to 100,000.
fn power_of(size: f64) -> i32 {
    let power = if size > 0.0 { size.log10().floor() as i32 } else { 0 };
    if (-3..5).contains(&power) { 0 } else { power }
}

fn suffix(power: i32) -> String {
    if power == 0 { String::new() } else { format!("e{power}") }
}

#[cfg(test)]
mod tests {
    use super::{roughly, uncertain};

    #[test]
    fn a_value_has_the_digits_that_its_error_leaves() {
        for (value, error, text) in [
            (0.101_41, 0.001_21, "0.1014(12)"),
            (0.746_812, 0.000_62, "0.7468(6)"),
            (0.5, 0.099, "0.50(10)"),
            (1234.5, 31.0, "1230(30)"),
            (1234.5, 2.2, "1234(2)"),
            (2.512_3e-9, 4.1e-12, "2.512(4)e-9"),
            (-7.31e6, 1.2e4, "-7.310(12)e6"),
            (1e-9, 3e-8, "0(3)e-8"),
            (12.0, 0.0, "12"),
            (f64::NAN, 0.1, "-"),
            (0.3, f64::NAN, "-"),
        ] {
            assert_eq!(uncertain(value, error), text);
        }
    }

    #[test]
    fn a_value_without_an_error_has_two_digits() {
        for (value, text) in [(0.101, "0.10~"), (2.51e-9, "2.5e-9~"), (123.4, "123~"), (0.0, "0~"), (-1.26, "-1.3~")] {
            assert_eq!(roughly(value), text);
        }
    }
}
