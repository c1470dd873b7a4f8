//! The relaxation of a viscoelastic body, from flags.

use clap::Args;
use gfmd_green::Material;
use gfmd_medium::{Prony, Relaxes};
use serde::{Deserialize, Serialize};

use super::body::BodyArgs;
use super::choice::{named, parse_choice};
use crate::options::{Kinds, Options};
use crate::{Moduli, Unusable, key, setting, words};

/// Flags of the relaxation of the body.
#[derive(Args, Options, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[command(next_help_heading = "Viscoelastic body")]
pub struct PronyArgs {
    /// Prony series of a viscoelastic body: each branch's relaxation time (10ms, 2h if lengths have a unit) and
    /// fraction of the instantaneous modulus
    #[arg(
        long,
        value_delimiter = ',',
        value_parser = parse_branch,
        value_name = "TAU:G,..",
        allow_hyphen_values = true
    )]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    #[option(kinds = Kinds::PRONY)]
    pub prony: Vec<(f64, f64)>,
    /// Given moduli of the viscoelastic body
    #[arg(long, value_parser = parse_choice::<Moduli>(), default_value_t = Moduli::LongTerm, requires = "prony")]
    #[serde(skip_serializing_if = "is_default", with = "named")]
    pub moduli: Moduli,
    /// Moduli that relax
    #[arg(long, value_parser = parse_choice::<Relaxes>(), default_value_t = Relaxes::Both, requires = "prony")]
    #[serde(skip_serializing_if = "is_default", with = "named")]
    pub relaxes: Relaxes,
}

/// The relaxation of a body, as printed.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "docs/interface.md")]
pub struct Relaxation {
    pub prony: Vec<(f64, f64)>,
    #[serde(with = "named")]
    pub moduli: Moduli,
    #[serde(with = "named")]
    pub relaxes: Relaxes,
    pub young_long_term: f64,
    pub young_instantaneous: f64,
}

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

fn parse_branch(text: &str) -> Result<(f64, f64), String> {
    let wrong = || "it must be TAU:G, a relaxation time and a fraction of the instantaneous modulus".to_owned();
    let (time, fraction) = text.split_once(':').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse().map_err(|_| wrong());
    Ok((number(time)?, number(fraction)?))
}

impl PronyArgs {
    /// Returns the moduli that relax, if the body is viscoelastic.
    pub fn relaxing(&self) -> Option<Relaxes> {
        (!self.prony.is_empty()).then_some(self.relaxes)
    }

    /// Returns the Prony series and the moduli that relax; `None` for an elastic body.
    ///
    /// # Errors
    /// Returns an error for a series that no material has, and for flags that need a series.
    pub fn series(&self) -> Result<Option<(Prony, Relaxes)>, Unusable> {
        if !self.prony.is_empty() {
            let series = Prony::from_fractions(&self.prony);
            return series
                .map(|prony| Some((prony, self.relaxes)))
                .map_err(|error| Unusable::input(key("prony"), error));
        }
        if self.moduli != Moduli::LongTerm {
            return Err(Unusable::value(key("moduli"), self.moduli, words!["left out without ", key("prony")]));
        }
        if self.relaxes != Relaxes::Both {
            return Err(Unusable::value(key("relaxes"), self.relaxes, words!["left out without ", key("prony")]));
        }
        Ok(None)
    }

    /// Returns the options of the body with long-term moduli, whichever moduli `given` has. A missing modulus has its
    /// default value.
    ///
    /// # Errors
    /// Fails like [`series`](Self::series); also for a contact modulus if only the shear modulus relaxes.
    pub fn long_term(&self, given: &BodyArgs) -> Result<BodyArgs, Unusable> {
        let Some((prony, _)) = self.series()? else { return Ok(given.clone()) };
        if let (Relaxes::Shear, Some(modulus)) = (self.relaxes, given.e_star) {
            return Err(Unusable::value(
                key("e_star"),
                modulus,
                words![
                    "left out with ",
                    setting("relaxes", "shear"),
                    ", which needs ",
                    key("young"),
                    " and ",
                    key("poisson")
                ],
            ));
        }
        if self.moduli == Moduli::LongTerm {
            return Ok(given.clone());
        }
        let relaxed = |young: f64, poisson: f64| {
            let made = Material::from_young(young, poisson).and_then(|made| prony.long_term(&made, self.relaxes));
            // A refused modulus is reported where the body is built.
            made.map_or((young, poisson), |made| (made.young(), made.poisson()))
        };
        let mut body = given.clone();
        let (young, poisson) = relaxed(given.young(), given.poisson);
        (body.young, body.poisson) = (given.e_star.is_none().then_some(young), poisson);
        body.e_star = given.e_star.map(|modulus| modulus / prony.instantaneous());
        body.others = given.others.map_moduli(relaxed);
        Ok(body)
    }

    /// Returns the relaxation in words and numbers; `None` for an elastic body.
    ///
    /// # Errors
    /// Fails like [`long_term`](Self::long_term); also if the body cannot be built.
    pub fn relaxation(&self, given: &BodyArgs) -> Result<Option<Relaxation>, Unusable> {
        let Some((series, _)) = self.series()? else { return Ok(None) };
        let soft = *self.long_term(given)?.body()?.material();
        let stiff = series.at_once(&soft, self.relaxes).map_err(|error| Unusable::input(key("prony"), error))?;
        Ok(Some(Relaxation {
            prony: self.prony.clone(),
            moduli: self.moduli,
            relaxes: self.relaxes,
            young_long_term: soft.young(),
            young_instantaneous: stiff.young(),
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(prony: &[(f64, f64)]) -> PronyArgs {
        PronyArgs { prony: prony.to_vec(), ..PronyArgs::default() }
    }

    #[test]
    fn branches_are_pairs() {
        assert_eq!(parse_branch("1e-3:0.25"), Ok((1e-3, 0.25)));
        for text in ["1", "1:", ":0.2", "a:b", "1:2:3"] {
            assert!(parse_branch(text).is_err_and(|error| error.starts_with("it must be TAU:G")), "{text}");
        }
    }

    #[test]
    fn moduli_are_those_of_the_long_term() {
        let body = BodyArgs { young: Some(10.0), poisson: 0.3, ..BodyArgs::default() };
        let long = given(&[(1.0, 0.75)]);
        let relaxation = |args: &PronyArgs| args.relaxation(&body).unwrap().unwrap();
        assert_eq!([relaxation(&long).young_long_term, relaxation(&long).young_instantaneous], [10.0, 40.0]);
        let at_once = PronyArgs { moduli: Moduli::Instantaneous, ..long.clone() };
        assert_eq!([relaxation(&at_once).young_long_term, relaxation(&at_once).young_instantaneous], [2.5, 10.0]);
        let stars = BodyArgs { e_star: Some(8.0), ..body.clone() };
        assert_eq!(at_once.long_term(&stars).unwrap().e_star, Some(2.0));
        let shear = PronyArgs { relaxes: Relaxes::Shear, ..at_once };
        let soft = shear.long_term(&body).unwrap();
        assert!(soft.poisson > 0.3, "{soft:?}");
        assert!(soft.young() > 2.5, "{soft:?}");
        assert!(soft.young() < 3.0, "{soft:?}");
        assert!(shear.long_term(&stars).unwrap_err().to_string().starts_with("--e-star is 8; it must be left out"));
    }

    #[test]
    fn flags_without_a_series_are_refused() {
        let says = |args: PronyArgs, words: &str| assert_eq!(args.series().unwrap_err().to_string(), words);
        let none = PronyArgs::default();
        assert_eq!(none.series().unwrap(), None);
        says(
            PronyArgs { moduli: Moduli::Instantaneous, ..none.clone() },
            "--moduli is instantaneous; it must be left out without --prony",
        );
        says(PronyArgs { relaxes: Relaxes::Shear, ..none }, "--relaxes is shear; it must be left out without --prony");
        says(given(&[(0.0, 0.5)]), "--prony: a relaxation time is 0; it must be positive and finite");
    }
}
