//! Validation of configurations.

use std::fmt::Debug;
use std::ops::RangeInclusive;

use gfmd_contact::{Budget, Contact, Solver};

use super::{Alpha, Config, Control, Estimator, Method, SurfaceConfig};
use crate::SweepError;

/// Gradients with squares that, multiplied by a squared modulus, neither overflow nor vanish.
const GRADIENTS: RangeInclusive<f64> = 1e-100..=1e100;

/// Returns the error of a field with the value `found`.
pub(crate) fn refusal(field: &'static str, found: &impl Debug, allowed: impl Into<String>) -> SweepError {
    SweepError::Field { field, found: format!("{found:?}"), allowed: allowed.into() }
}

impl Config {
    /// Checks that every value can be used.
    ///
    /// # Errors
    /// Returns the first field that cannot be used, its value, and the allowed values.
    pub fn check(&self) -> Result<(), SweepError> {
        let check = |good: bool, field, found: &dyn Debug, allowed: &str| match good {
            true => Ok(()),
            false => Err(refusal(field, &found, allowed)),
        };
        let positive = |x: f64| x > 0.0 && x.is_finite();
        let Self { surface, loads, statistics, solver, fit, .. } = self;
        check([2, 3].contains(&surface.dim), "surface.dim", &surface.dim, "2 or 3")?;
        let hurst = &surface.hurst;
        let good = !hurst.is_empty() && hurst.iter().all(|h| (0.0..=1.0).contains(h)) && all_differ(hurst);
        check(good, "surface.hurst", hurst, "a list of different numbers from 0 to 1")?;
        let p_star = &loads.p_star;
        let ascending = p_star.windows(2).all(|pair| pair[0] < pair[1]);
        let good = !p_star.is_empty() && ascending && p_star.iter().all(|p| positive(*p));
        check(good, "loads.p_star", p_star, "an ascending list of positive numbers")?;
        let realisations = statistics.realisations;
        check((1..=1_000_000).contains(&realisations), "statistics.realisations", &realisations, "from 1 to 1000000")?;
        let target = statistics.target;
        check(
            target == 0.0 || (1e-5..=1.0).contains(&target),
            "statistics.target",
            &target,
            "from 1e-5 to 1, or 0 for none",
        )?;
        check(target == 0.0 || fit.references.is_empty(), "statistics.target", &target, "0 with fit.references")?;
        check(
            target == 0.0 || realisations >= 4,
            "statistics.realisations",
            &realisations,
            "at least 4 with statistics.target",
        )?;
        let tolerances = Budget::TOLERANCES;
        let allowed = format!("between {:e} and {}", tolerances.start(), tolerances.end());
        check(tolerances.contains(&solver.tolerance), "solver.tolerance", &solver.tolerance, &allowed)?;
        let names = Contact::SOLVERS.map(Solver::name).join(", ");
        let method = solver.method;
        check(Contact::SOLVERS.contains(&method), "solver.method", &method.name(), &format!("one of {names}"))?;
        check(solver.max_iterations > 0, "solver.max_iterations", &solver.max_iterations, "1 or more")?;
        check(p_star.contains(&fit.p_star), "fit.p_star", &fit.p_star, &format!("one of loads.p_star, {p_star:?}"))?;
        for (field, alpha, word) in [
            ("fit.alpha_t", fit.alpha_t, None),
            ("fit.alpha_f", fit.alpha_f, Some((Alpha::SelfAffine, "self-affine"))),
            ("fit.alpha_c", fit.alpha_c, Some((Alpha::Edge, "edge"))),
        ] {
            let words = word.map_or_else(String::new, |(_, word)| format!("{word:?}, "));
            let allowed = format!("from 0.01 to 16, {words}\"free\" or \"none\"");
            match alpha {
                Alpha::Fixed(found) => check((0.01..=16.0).contains(&found), field, &found, &allowed)?,
                Alpha::SelfAffine | Alpha::Edge => {
                    check(word.is_some_and(|(own, _)| own == alpha), field, &alpha.word(), &allowed)?;
                }
                Alpha::Free | Alpha::Without => {}
            }
        }
        let allowed = "a number, \"free\" or \"none\" where surface.hurst is above 0.99, whose 1 - H is no exponent";
        let good = fit.alpha_f != Alpha::SelfAffine || hurst.iter().all(|h| 1.0 - h >= 0.01);
        check(good, "fit.alpha_f", &fit.alpha_f.word(), allowed)?;
        let allowed = "a number, \"free\" or \"none\" where surface.dim is 2: line contacts have no perimeter";
        check(fit.alpha_c != Alpha::Edge || surface.dim == 3, "fit.alpha_c", &fit.alpha_c.word(), allowed)?;
        self.check_method()?;
        self.check_protocol()?;
        let has_percentiles = fit.resamples == 0 || (20..=1_000_000).contains(&fit.resamples);
        check(has_percentiles, "fit.resamples", &fit.resamples, "0 for none, or from 20 to 1000000")?;
        self.body()?;
        check(
            GRADIENTS.contains(&surface.rms_gradient),
            "surface.rms_gradient",
            &surface.rms_gradient,
            "from 1e-100 to 1e100",
        )
    }

    /// Checks the preferred direction of the surfaces.
    fn check_lay(&self) -> Result<(), SweepError> {
        let SurfaceConfig { dim, method, aspect, lay, .. } = &self.surface;
        if !(*aspect >= 1.0 && aspect.is_finite()) {
            return Err(refusal("surface.aspect", aspect, "at least 1 and finite"));
        }
        if !lay.is_finite() {
            return Err(refusal("surface.lay", lay, "finite"));
        }
        if *aspect > 1.0 && *dim == 2 {
            return Err(refusal("surface.aspect", aspect, "1 with profiles"));
        }
        if *aspect > 1.0 && matches!(method, Method::Sra | Method::Rmd) {
            return Err(refusal(
                "surface.aspect",
                aspect,
                "1 with the methods sra and rmd, which have no spectrum to change",
            ));
        }
        if *aspect == 1.0 && *lay != 0.0 {
            return Err(refusal("surface.lay", lay, "0 with surface.aspect = 1"));
        }
        Ok(())
    }

    /// Checks the method that generates heights.
    fn check_method(&self) -> Result<(), SweepError> {
        let SurfaceConfig { method, roll_off, hurst, .. } = &self.surface;
        if !(*roll_off > 0.0 && *roll_off <= 1.0) {
            return Err(refusal("surface.roll_off", roll_off, "above 0 and at most 1"));
        }
        if *roll_off < 1.0 && matches!(method, Method::Sra | Method::Rmd) {
            return Err(refusal(
                "surface.roll_off",
                roll_off,
                "1 with the methods sra and rmd, which have no spectrum to change",
            ));
        }
        if let Some(marginal) = &self.surface.marginal
            && matches!(method, Method::Sra | Method::Rmd)
        {
            let allowed = "left out with the methods sra and rmd, which have no spectrum to keep";
            return Err(refusal("surface.marginal", &marginal.to_string(), allowed));
        }
        self.check_lay()?;
        if *method == Method::Printed && hurst[..] != [0.0] {
            return Err(refusal(
                "surface.hurst",
                hurst,
                "[0.0] with the method printed, which makes surfaces of 1 + 2H",
            ));
        }
        if *method == Method::Printed && self.fit.alpha_f == Alpha::SelfAffine {
            let allowed =
                "a number, \"free\" or \"none\" with the method printed, whose surfaces have another exponent";
            return Err(refusal("fit.alpha_f", &self.fit.alpha_f.word(), allowed));
        }
        Ok(())
    }

    /// Checks slopes, approach control, and reference cells.
    fn check_protocol(&self) -> Result<(), SweepError> {
        let Self { loads, statistics, fit, .. } = self;
        let count = loads.p_star.len();
        if fit.estimator == Estimator::Slope && count < 2 {
            return Err(refusal("fit.estimator", &"slope", "\"ratio\" with a single load; a slope needs two or more"));
        }
        if loads.control == Control::Approach && fit.estimator == Estimator::Ratio {
            let allowed =
                "load with fit.estimator \"ratio\": loads between the first and the last have no p* of their own";
            return Err(refusal("loads.control", &"approach", allowed));
        }
        if fit.references.is_empty() {
            return Ok(());
        }
        if fit.references.iter().flatten().any(|inverse| !(inverse.is_finite() && *inverse >= 1.0)) {
            return Err(refusal(
                "fit.references",
                &fit.references,
                "a list of [eps_t_inv, eps_f_inv, eps_c_inv], each 1 or more",
            ));
        }
        if fit.alpha_c == Alpha::Edge {
            return Err(refusal(
                "fit.alpha_c",
                &fit.alpha_c.word(),
                "a number, \"free\" or \"none\" with fit.references",
            ));
        }
        if statistics.nested || (statistics.equal_area && self.points.eps_t_inv.len() > 1) {
            let allowed =
                "false, and statistics.equal_area too, with fit.references: its cells need equally many surfaces";
            return Err(refusal("statistics.nested", &statistics.nested, allowed));
        }
        Ok(())
    }
}

fn all_differ(numbers: &[f64]) -> bool {
    numbers.iter().enumerate().all(|(i, number)| !numbers[..i].contains(number))
}
