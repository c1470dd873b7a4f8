/// The functions of h = q·thickness that the kernels of a layer are made of, free of overflow and of cancellation.
///
/// Numerators and denominators of a kernel are quadratic in them, so a common factor drops out. Thin layers (h < 1) are
/// taken as they are, with Taylor series for the differences; thick ones are multiplied by 2 e^(−h), all quadratic
/// quantities by 4 e^(−2h) (theory.md, section 1).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Thickness {
    /// h as it is, up to the h beyond which nothing changes.
    pub(crate) raw: f64,
    /// h, linear.
    pub(crate) h: f64,
    /// sinh h, linear.
    pub(crate) sinh: f64,
    /// cosh h, linear.
    pub(crate) cosh: f64,
    /// sinh h − h, linear.
    pub(crate) sinh_minus_h: f64,
    /// 1, linear: 2 e^(−h) where scaled.
    pub(crate) one: f64,
    /// h, quadratic.
    pub(crate) h_quadratic: f64,
    /// sinh h cosh h − h, quadratic.
    pub(crate) sc_minus_h: f64,
}

/// Beyond this h, e^(−h) is zero: the far face is out of reach.
pub(crate) const FARTHEST: f64 = 800.0;

impl Thickness {
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
                one: 1.0,
                h_quadratic: h,
                sc_minus_h: 0.5 * sinh_minus(2.0 * h),
            }
        } else {
            let raw = h.min(FARTHEST);
            let one = 2.0 * (-raw).exp();
            let e = 0.25 * one * one;
            let sinh = -(-2.0 * raw).exp_m1();
            Self {
                raw,
                h: one * raw,
                sinh,
                cosh: 1.0 + e,
                sinh_minus_h: sinh - one * raw,
                one,
                h_quadratic: 4.0 * e * raw,
                sc_minus_h: sinh * (1.0 + e) - 4.0 * e * raw,
            }
        }
    }

    /// coth h, as it is.
    pub(crate) fn coth(&self) -> f64 {
        self.cosh / self.sinh
    }

    /// tanh h, as it is.
    pub(crate) fn tanh(&self) -> f64 {
        self.sinh / self.cosh
    }

    /// 1/sinh h, as it is.
    pub(crate) fn csch(&self) -> f64 {
        self.one / self.sinh
    }
}

/// sinh x − x, by its series for |x| < 2.5.
pub(crate) fn sinh_minus(x: f64) -> f64 {
    if x.abs() < 2.5 { x * x * x / 6.0 * tail(x, 3.0) } else { x.sinh() - x }
}

/// cosh x − 1 − x²/2, by its series for |x| < 2.5.
pub(crate) fn cosh_minus(x: f64) -> f64 {
    if x.abs() < 2.5 {
        let square = x * x;
        square * square / 24.0 * tail(x, 4.0)
    } else {
        x.cosh() - 1.0 - 0.5 * x * x
    }
}

/// 1 + x²/((n+1)(n+2)) (1 + x²/((n+3)(n+4)) (1 + …)): the rest of the series that begins at xⁿ/n!.
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
        let (thin, thick) = (Thickness::new(1.0f64.next_down()), Thickness::new(1.0));
        let (linear, quadratic) = (thick.one, thick.one * thick.one);
        let same = |a: f64, b: f64| approx::assert_relative_eq!(a, b, max_relative = 4e-15);
        same(thin.h * linear, thick.h);
        same(thin.sinh * linear, thick.sinh);
        same(thin.cosh * linear, thick.cosh);
        same(thin.sinh_minus_h * linear, thick.sinh_minus_h);
        same(thin.h_quadratic * quadratic, thick.h_quadratic);
        same(thin.sc_minus_h * quadratic, thick.sc_minus_h);
    }

    #[test]
    fn no_thickness_overflows() {
        for h in [1.0, 700.0, 745.0, 800.0, 1e6, 1e300, f64::INFINITY] {
            let t = Thickness::new(h);
            for value in [t.h, t.sinh, t.cosh, t.sinh_minus_h, t.h_quadratic, t.sc_minus_h, t.coth()] {
                assert!(value.is_finite(), "{h}: {t:?}");
            }
        }
        assert_eq!(Thickness::new(1e6).csch(), 0.0);
    }
}
