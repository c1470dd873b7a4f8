//! Units that are powers of two.

use gfmd_response::unit_of;

#[test]
fn units_are_powers_of_two_of_the_size_of_the_number() {
    for exponent in (-308..=308).step_by(7) {
        let number = 3.7 * 10.0_f64.powi(exponent.min(307));
        let unit = unit_of(number);
        assert_eq!(unit.to_bits() & ((1 << 52) - 1), 0, "{number:e}: {unit:e} is no power of two");
        if exponent.abs() < 30 {
            assert_eq!(unit, 1.0);
        } else if exponent.abs() > 30 {
            assert!((1.0..2.0).contains(&(number / unit)), "{number:e}: {unit:e}");
        }
    }
    assert_eq!([0.0, f64::INFINITY, 5e-324].map(unit_of), [1.0, 1.0, f64::MIN_POSITIVE]);
}
