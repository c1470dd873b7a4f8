/// Functions of h = q·thickness in the kernels of a layer, without overflow or cancellation.
///
/// Numerator and denominator of a kernel are both quadratic in these functions, so a common factor f cancels. For thin
/// layers (h < 1), f = 1 and the differences are Taylor series; for thick layers, f = 2 e^(−h) keeps all functions
/// finite. Functions that are linear in sinh h and cosh h carry f, quadratic ones f² (theory.md, section 1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hyperbolic {
    /// h, unscaled, at most [`FARTHEST`].
    pub(crate) raw: f64,
    /// Common factor f of the linear functions: 1, or 2 e^(−h) for a thick layer.
    pub(crate) factor: f64,
    /// f h.
    pub(crate) h: f64,
    /// f sinh h.
    pub(crate) sinh: f64,
    /// f cosh h.
    pub(crate) cosh: f64,
    /// f (sinh h − h).
    pub(crate) sinh_minus_h: f64,
    /// f² h.
    pub(crate) h_twice_scaled: f64,
    /// f² (sinh h cosh h − h).
    pub(crate) sinh_cosh_minus_h: f64,
}

/// Value of h above which e^(−h) is zero and the two faces of a layer are uncoupled.
pub(crate) const FARTHEST: f64 = 800.0;

impl Hyperbolic {
    #[inline]
    pub(crate) fn new(h: f64) -> Self {
        if h < 1.0 {
            let sinh_minus_h = sinh_minus(h);
            Self {
                raw: h,
                h,
                sinh: h + sinh_minus_h,
                cosh: h.cosh(),
                sinh_minus_h,
                factor: 1.0,
                h_twice_scaled: h,
                sinh_cosh_minus_h: 0.5 * sinh_minus(2.0 * h),
            }
        } else {
            let raw = h.min(FARTHEST);
            let factor = 2.0 * (-raw).exp();
            let e = 0.25 * factor * factor;
            let sinh = -(-2.0 * raw).exp_m1();
            Self {
                raw,
                h: factor * raw,
                sinh,
                cosh: 1.0 + e,
                sinh_minus_h: sinh - factor * raw,
                factor,
                h_twice_scaled: 4.0 * e * raw,
                sinh_cosh_minus_h: sinh * (1.0 + e) - 4.0 * e * raw,
            }
        }
    }

    /// Returns f² (sinh h cosh h + h).
    #[inline]
    pub(crate) fn sinh_cosh_plus_h(&self) -> f64 {
        self.sinh_cosh_minus_h + 2.0 * self.h_twice_scaled
    }

    /// Returns coth h, unscaled.
    pub(crate) fn coth(&self) -> f64 {
        self.cosh / self.sinh
    }

    /// Returns tanh h, unscaled.
    pub(crate) fn tanh(&self) -> f64 {
        self.sinh / self.cosh
    }

    /// Returns 1/sinh h, unscaled.
    pub(crate) fn csch(&self) -> f64 {
        self.factor / self.sinh
    }
}

/// Returns sinh x − x, from its series for |x| < 2.5.
pub(crate) fn sinh_minus(x: f64) -> f64 {
    if x.abs() < 2.5 { x * x * x / 6.0 * tail(x, 3.0) } else { x.sinh() - x }
}

/// Returns cosh x − 1 − x²/2, from its series for |x| < 2.5.
pub(crate) fn cosh_minus(x: f64) -> f64 {
    if x.abs() < 2.5 {
        let square = x * x;
        square * square / 24.0 * tail(x, 4.0)
    } else {
        x.cosh() - 1.0 - 0.5 * x * x
    }
}

/// Returns the series from xⁿ/n! on, divided by this term: 1 + x²/((n+1)(n+2)) (1 + x²/((n+3)(n+4)) (1 + …)).
fn tail(x: f64, n: f64) -> f64 {
    let square = x * x;
    (0..13).rev().fold(1.0, |sum, k| {
        let first = n + f64::from(2 * k + 1);
        1.0 + sum * square / (first * (first + 1.0))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_series_meet_the_closed_forms_where_both_are_exact() {
        for i in 0..300 {
            let x = 1.5 + f64::from(i) / 300.0;
            approx::assert_relative_eq!(sinh_minus(x), x.sinh() - x, max_relative = 4e-15);
            approx::assert_relative_eq!(cosh_minus(x), x.cosh() - 1.0 - 0.5 * x * x, max_relative = 2e-14);
        }
        assert_eq!(sinh_minus(-0.3), -sinh_minus(0.3));
        approx::assert_relative_eq!(sinh_minus(1e-8), 1e-24 / 6.0, max_relative = 1e-15);
        approx::assert_relative_eq!(cosh_minus(1e-8), 1e-32 / 24.0, max_relative = 1e-15);
    }

    #[test]
    fn both_branches_agree_up_to_the_common_factor() {
        let (thin, thick) = (Hyperbolic::new(1.0f64.next_down()), Hyperbolic::new(1.0));
        let (linear, quadratic) = (thick.factor, thick.factor * thick.factor);
        let same = |a: f64, b: f64| approx::assert_relative_eq!(a, b, max_relative = 4e-15);
        same(thin.h * linear, thick.h);
        same(thin.sinh * linear, thick.sinh);
        same(thin.cosh * linear, thick.cosh);
        same(thin.sinh_minus_h * linear, thick.sinh_minus_h);
        same(thin.h_twice_scaled * quadratic, thick.h_twice_scaled);
        same(thin.sinh_cosh_minus_h * quadratic, thick.sinh_cosh_minus_h);
    }

    #[test]
    fn no_thickness_overflows() {
        for h in [1.0, 700.0, 745.0, 800.0, 1e6, 1e300, f64::INFINITY] {
            let t = Hyperbolic::new(h);
            for value in [t.h, t.sinh, t.cosh, t.sinh_minus_h, t.h_twice_scaled, t.sinh_cosh_minus_h, t.coth()] {
                assert!(value.is_finite(), "{h}: {t:?}");
            }
        }
        assert_eq!(Hyperbolic::new(1e6).csch(), 0.0);
    }
}
