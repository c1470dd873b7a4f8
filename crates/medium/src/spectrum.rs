//! Relaxation of the stiffness of each wave, as Prony branches.

use std::ops::Range;

use gfmd_contact::Refusal;
use gfmd_field::{Grid, Mode};
use gfmd_green::{Base, Body, Ground, Height, Material};
use rayon::prelude::*;

use crate::bulk::bulk;
use crate::poles::poles;
use crate::{Branch, Prony, Relaxes};

/// Branches of the waves of a body; weights are relative to the long-term stiffness of the wave.
#[derive(Clone, Debug)]
pub(crate) enum Spectrum {
    /// Common branches of all waves.
    Common(Vec<Branch>),
    /// Separate branches of each wave.
    Waves(Waves),
}

/// Modes of a grid that belong to this process: whole lanes of the half spectrum.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Modes {
    grid: Grid,
    first: usize,
    /// Number of modes.
    pub(crate) count: usize,
    /// Number of modes in a lane.
    pub(crate) lane: usize,
}

impl Modes {
    /// Returns the modes of some lanes.
    pub(crate) fn of(grid: &Grid, lanes: Range<usize>) -> Self {
        let [_, lane] = grid.spectrum_shape();
        Self { grid: *grid, first: lanes.start * lane, count: lanes.len() * lane, lane }
    }

    /// Returns the modes of all lanes.
    pub(crate) fn all(grid: &Grid) -> Self {
        Self::of(grid, 0..grid.spectrum_shape()[0])
    }

    /// Returns a mode, counted from the first one of this process.
    pub(crate) fn at(&self, index: usize) -> Mode {
        self.grid.mode_at(self.first + index)
    }
}

/// Branches of waves that relax differently, `count` of them for each mode.
#[derive(Clone, Debug)]
pub(crate) struct Waves {
    pub(crate) modes: Modes,
    pub(crate) count: usize,
    /// Times common to all waves.
    times: Vec<f64>,
    /// Times specific to each wave, mode by mode.
    own: Vec<f64>,
    /// Weights, mode by mode.
    weights: Vec<f64>,
    /// Long-term stiffness of each mode, stress/length.
    pub(crate) stiffness: Vec<f64>,
}

impl Waves {
    /// Returns the branches of a mode.
    pub(crate) fn of(&self, mode: usize) -> impl Iterator<Item = Branch> + '_ {
        let own = self.count - self.times.len();
        let times = self.times.iter().chain(&self.own[mode * own..][..own]);
        times.zip(&self.weights[mode * self.count..]).map(|(time, weight)| Branch { time: *time, weight: *weight })
    }
}

/// Returns the long-term stiffness of each mode, stress/length; infinite for the uniform mode if the level is fixed.
/// `stiffness_of` returns the stiffness of a wavenumber.
pub(crate) fn stiffness(body: &Body, modes: &Modes, stiffness_of: fn(&Body, f64) -> f64) -> Vec<f64> {
    let [_, level] = body.level_compliance();
    let of = |index: usize| {
        let mode = modes.at(index);
        if mode.is_uniform() { 1.0 / level } else { stiffness_of(body, mode.wavenumber()) }
    };
    (0..modes.count).into_par_iter().map(of).collect()
}

impl Spectrum {
    /// Computes the spectrum of `body`, given by its long-term moduli, for some `modes` of a periodic grid or of a
    /// patch. The second body of a pair is elastic.
    ///
    /// # Errors
    /// Returns an error if only the shear modulus relaxes and the spectrum is not known for the body or boundary, and
    /// for a pair with a slab on a patch.
    pub(crate) fn new(
        body: &Body,
        modes: &Modes,
        is_free: bool,
        prony: &Prony,
        relaxes: Relaxes,
    ) -> Result<Self, Refusal> {
        let Some(second) = body.second() else { return Self::of_one(body, modes, is_free, prony, relaxes) };
        let first = body.alone();
        let alone = Self::of_one(&first, modes, is_free, prony, relaxes)?;
        match alone {
            Self::Common(branches) if [&first, second].iter().all(|body| body.height() == Height::Infinite) => {
                let ratio = second.contact_modulus() / first.contact_modulus();
                Ok(Self::Common(in_series(&branches, ratio)))
            }
            _ if is_free => Err(Refusal::RelaxingPair { with: "a slab with free boundaries" }),
            alone => Ok(Self::Waves(alone.in_series_with(&first, second, body, modes))),
        }
    }

    /// Computes the branches of each wave of a pair: the `first` body, with this spectrum, and an elastic second one.
    fn in_series_with(self, first: &Body, second: &Body, pair: &Body, modes: &Modes) -> Waves {
        let [of_first, of_second, stiffness] =
            [first, second, pair].map(|body| stiffness(body, modes, Body::normal_stiffness));
        let of_mode = |mode: usize| -> Vec<Branch> {
            let branches = match &self {
                Self::Common(branches) => branches.clone(),
                Self::Waves(waves) => waves.of(mode).collect(),
            };
            match (of_first[mode], of_second[mode]) {
                // A first body whose level is fixed leaves the relaxation of its level without effect.
                (first, _) if first.is_infinite() => {
                    branches.into_iter().map(|branch| Branch { weight: 0.0, ..branch }).collect()
                }
                (first, second) => in_series(&branches, second / first),
            }
        };
        let of_modes: Vec<Vec<Branch>> = (0..modes.count).into_par_iter().map(of_mode).collect();
        let all = || of_modes.iter().flatten();
        let count = match &self {
            Self::Common(branches) => branches.len(),
            Self::Waves(waves) => waves.count,
        };
        Waves {
            modes: *modes,
            count,
            times: Vec::new(),
            own: all().map(|branch| branch.time).collect(),
            weights: all().map(|branch| branch.weight).collect(),
            stiffness,
        }
    }

    /// Computes the spectrum of a single body as [`new`](Self::new).
    fn of_one(body: &Body, modes: &Modes, is_free: bool, prony: &Prony, relaxes: Relaxes) -> Result<Self, Refusal> {
        let material = body.material();
        // With a constant bulk modulus an incompressible body stays incompressible, so all of it relaxes alike.
        if relaxes == Relaxes::Both || material.poisson() == 0.5 && !matches!(body.base(), Base::Elastic(_)) {
            return Ok(Self::Common(prony.branches().to_vec()));
        }
        let refuse = |with: &'static str| Err(Refusal::ShearAlone { with });
        match (body.height(), body.base()) {
            (Height::Infinite, _) => Ok(Self::Common(of_half_space(material, prony))),
            (_, Base::Elastic(_)) => refuse("layers"),
            _ if is_free => refuse("a slab with free boundaries"),
            (Height::Finite(height), Base::Rigid(Ground::BONDED)) => {
                Ok(Self::Waves(of_slab(body, height, modes, prony)))
            }
            (_, Base::Rigid(_)) => Ok(Self::Waves(of_loose_slab(body, modes, prony))),
        }
    }
}

/// Returns the branches of a spring in series with a body of these `branches`; `ratio` is the stiffness of the spring
/// divided by the long-term stiffness of the body. With the relaxation m of the body, the pair has (1 + κ)(1 − κ/(m +
/// κ)), which has a branch for each pole (theory.md, section 7.7).
fn in_series(branches: &[Branch], ratio: f64) -> Vec<Branch> {
    if ratio.is_infinite() {
        return branches.to_vec();
    }
    let relaxing: Vec<Branch> = branches.iter().copied().filter(|branch| branch.weight > 0.0).collect();
    let factor = ratio * (1.0 + ratio);
    let mut found = poles(&relaxing, ratio).into_iter();
    let of_branch = |branch: &Branch| {
        let pole = if branch.weight > 0.0 { found.next() } else { None };
        pole.map_or(*branch, |[rate, residue]| Branch { time: 1.0 / rate, weight: factor * residue / rate })
    };
    branches.iter().map(of_branch).collect()
}

/// Returns the 2n branches of E* = G + 9K/4 − (27/4) K²/(4G + 3K) of a half-space.
fn of_half_space(material: &Material, prony: &Prony) -> Vec<Branch> {
    // All moduli relative to the shear modulus.
    let k = bulk(material);
    let modulus = material.contact_modulus() / material.shear_modulus();
    let direct = prony.branches().iter().map(|branch| Branch { weight: branch.weight / modulus, ..*branch });
    let delayed = poles(prony.branches(), 0.75 * k).into_iter();
    let of_bulk = delayed
        .map(|[rate, residue]| Branch { time: 1.0 / rate, weight: 27.0 / 16.0 * k * k * residue / (rate * modulus) });
    direct.chain(of_bulk).collect()
}

/// Computes the 2n branches per wave of a slab without shear at its base: waves have the branches of a half-space,
/// since their stiffness is E* times a function of height and wavenumber.
fn of_loose_slab(body: &Body, modes: &Modes, prony: &Prony) -> Waves {
    let branches = of_half_space(body.material(), prony);
    let uniform = of_uniform(body, prony).chain(std::iter::repeat(0.0)).take(branches.len());
    let weights = branches.iter().map(|branch| branch.weight).collect::<Vec<f64>>();
    let of_mode = |mode: usize| match modes.at(mode).is_uniform() {
        true => uniform.clone().collect::<Vec<f64>>(),
        false => weights.clone(),
    };
    Waves {
        modes: *modes,
        count: branches.len(),
        times: branches.iter().map(|branch| branch.time).collect(),
        own: Vec::new(),
        weights: (0..modes.count).flat_map(of_mode).collect(),
        stiffness: stiffness(body, modes, Body::normal_stiffness),
    }
}

/// Returns the weights of the uniform mode of a slab, one for each branch of the shear modulus: C11 = K + 4G/3.
fn of_uniform(body: &Body, prony: &Prony) -> impl Iterator<Item = f64> + Clone {
    let k = bulk(body.material());
    prony.branches().iter().map(move |branch| 4.0 / 3.0 * branch.weight / (k + 4.0 / 3.0))
}

/// Computes the 3n branches per wave of 1/G_zz = a + b G − A₁/(G + ¾K) − A₂/(G + βK) of a slab on a bonded base.
fn of_slab(body: &Body, height: f64, modes: &Modes, prony: &Prony) -> Waves {
    let (material, branches) = (body.material(), prony.branches());
    let (n, k) = (branches.len(), bulk(material));
    let common = poles(branches, 0.75 * k);
    let times: Vec<f64> =
        branches.iter().map(|branch| branch.time).chain(common.iter().map(|[rate, _]| 1.0 / rate)).collect();
    let [_, level] = body.level_compliance();
    let of_mode = |index: usize| {
        let mode = modes.at(index);
        if mode.is_uniform() {
            let weights = of_uniform(body, prony).chain(std::iter::repeat_n(0.0, 2 * n));
            return (weights.collect::<Vec<f64>>(), times[n..].to_vec(), 1.0 / level);
        }
        let q = mode.wavenumber();
        let stiffness = body.normal_stiffness(q);
        // All moduli relative to the shear modulus, stiffnesses relative to the shear modulus times q.
        let unit = material.shear_modulus() * q / stiffness;
        let [b, beta, first, second] = coefficients(2.0 * q * height, k);
        let own = poles(branches, beta * k);
        let direct = branches.iter().map(|branch| b * branch.weight);
        let of_first = common.iter().map(|[rate, residue]| first * residue / rate);
        let of_second = own.iter().map(|[rate, residue]| second * residue / rate);
        let weights = direct.chain(of_first).chain(of_second).map(|weight| weight * unit).collect();
        (weights, own.iter().map(|[rate, _]| 1.0 / rate).collect(), stiffness)
    };
    let of_modes: Vec<(Vec<f64>, Vec<f64>, f64)> = (0..modes.count).into_par_iter().map(of_mode).collect();
    let (own, weights, stiffness) = Default::default();
    let mut waves = Waves { modes: *modes, count: 3 * n, times, own, weights, stiffness };
    for (weights, own, stiffness) in of_modes {
        waves.weights.extend(weights);
        waves.own.extend(own);
        waves.stiffness.push(stiffness);
    }
    waves
}

/// Returns [b, β, A₁, A₂] of a slab with x = 2qh, moduli relative to the shear modulus and stiffnesses relative to the
/// shear modulus times q; `k` is the bulk modulus. Hyperbolic functions are scaled by e^{−x}.
fn coefficients(x: f64, k: f64) -> [f64; 4] {
    let one = (-x).exp();
    let (sinh, cosh) = (0.5 * (1.0 - one * one), 0.5 * (1.0 + one * one));
    // sinh x − x and cosh x − 1 − x²/2, by their series where the closed forms cancel.
    let (odd, even) = match x < 1.0 {
        true => (one * series(x, 3), one * series(x, 4)),
        false => (sinh - x * one, cosh - (1.0 + 0.5 * x * x) * one),
    };
    let den = 7.0 * sinh - x * one;
    let beta = 3.0 * odd / den;
    let b = 0.5 * (7.0 * cosh + (0.5 * x * x + 25.0) * one) / den;
    let first = 243.0 / 128.0 * k * k * even / (den * (0.75 - beta));
    let (u, v) = (3.0 - 7.0 * beta, 3.0 - beta);
    let bracket = u * v * cosh + ((0.5 * x * x + 0.5) * v * v + 0.5 * u * u) * one;
    [b, beta, first, beta * k * k * bracket / (2.0 * den * (0.75 - beta))]
}

/// Sums x^i/i! over i = first, first + 2, ...
fn series(x: f64, first: u32) -> f64 {
    let start = (1..=first).fold(1.0, |term, i| term * x / f64::from(i));
    let mut term = start;
    let mut sum = term;
    for i in (first + 2..first + 30).step_by(2) {
        term *= x * x / (f64::from(i - 1) * f64::from(i));
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    use super::*;

    fn three() -> Prony {
        Prony::from_fractions(&[(0.05, 0.3), (0.7, 0.25), (6.0, 0.2)]).unwrap()
    }

    #[test]
    fn the_spectrum_of_a_half_space_has_known_values() {
        let material = Material::from_young(1.0, 0.31).unwrap();
        let found = of_half_space(&material, &three());
        let weights = [0.414, 0.345, 0.276, 0.13594555, 0.18367705, 0.27213602];
        let times = [0.05, 0.7, 6.0, 0.06295618, 0.89482938, 7.83356709];
        for ((found, weight), time) in found.iter().zip(weights).zip(times) {
            assert_abs_diff_eq!(found.weight, weight, epsilon = 6e-9);
            assert_abs_diff_eq!(found.time, time, epsilon = 6e-9);
        }
    }

    #[test]
    fn the_spectrum_of_a_slab_has_known_values() {
        let grid = Grid::square(4, 1.0).unwrap();
        let body = Body::slab(Material::from_young(1.0, 0.31).unwrap(), 0.4).unwrap();
        let Ok(Spectrum::Waves(waves)) = Spectrum::new(&body, &Modes::all(&grid), false, &three(), Relaxes::Shear)
        else {
            panic!()
        };
        let uniform: Vec<Branch> = waves.of(0).collect();
        for (branch, known) in uniform.iter().zip([0.44057971, 0.36714976, 0.29371981]) {
            assert_abs_diff_eq!(branch.weight, known, epsilon = 6e-9);
        }
        let mode = grid.modes().position(|mode| mode.number == [1, 0]).unwrap();
        assert_relative_eq!(waves.stiffness[mode], 4.0065559057, max_relative = 1e-10);
        let known = [
            [
                0.38816284, 0.32346903, 0.25877522, 0.09084794, 0.12274533, 0.18185955, 0.02631154, 0.03899576,
                0.06969567,
            ],
            [0.05, 0.7, 6.0, 0.06295618, 0.89482938, 7.83356709, 0.06562082, 0.94890809, 8.61818051],
        ];
        for (index, branch) in waves.of(mode).enumerate() {
            assert_abs_diff_eq!(branch.weight, known[0][index], epsilon = 6e-9);
            assert_abs_diff_eq!(branch.time, known[1][index], epsilon = 6e-9);
        }
    }

    #[test]
    fn branches_add_up_to_the_stiffness_with_other_moduli() {
        // At the Laplace variable s the shear modulus is G(s) and the bulk modulus is unchanged.
        let prony = three();
        let of = |branches: &mut dyn Iterator<Item = Branch>, s: f64| {
            1.0 + branches.map(|branch| branch.weight * s / (s + 1.0 / branch.time)).sum::<f64>()
        };
        for nu in [-0.5, 0.0, 0.31, 0.49] {
            let material = Material::from_young(1.7, nu).unwrap();
            let (shear, bulk) = (material.shear_modulus(), bulk(&material) * material.shear_modulus());
            for s in [1e-3, 0.2, 3.0, 1e4] {
                let stiffer = shear * of(&mut prony.branches().iter().copied(), s);
                let young = 9.0 * bulk * stiffer / (3.0 * bulk + stiffer);
                let other = Material::from_young(young, 0.5 * young / stiffer - 1.0).unwrap();
                let ratio = other.contact_modulus() / material.contact_modulus();
                assert_relative_eq!(
                    of(&mut of_half_space(&material, &prony).into_iter(), s),
                    ratio,
                    max_relative = 1e-12
                );
                let heights = [1e-6, 1e-3, 0.1, 1.0, 300.0];
                for (height, base) in heights
                    .into_iter()
                    .zip([Base::BONDED, Base::SLIDING, Base::FREE].into_iter().cycle())
                    .chain(heights.map(|height| (height, Base::BONDED)))
                {
                    let grid = Grid::new([6, 4], [1.0, 0.8]).unwrap();
                    let slab = |material| Body::slab(material, height).unwrap().on(base.clone()).unwrap();
                    let found =
                        Spectrum::new(&slab(material), &Modes::all(&grid), false, &prony, Relaxes::Shear).unwrap();
                    let Spectrum::Waves(waves) = found else { panic!("each wave has its branches") };
                    for (index, mode) in grid.modes().enumerate() {
                        let of_body = |body: &Body| match mode.wavenumber() {
                            0.0 => 1.0 / body.level_compliance()[1],
                            q => body.normal_stiffness(q),
                        };
                        let ratio = of_body(&slab(other)) / of_body(&slab(material));
                        assert!(waves.of(index).all(|branch| branch.weight >= 0.0));
                        assert_relative_eq!(of(&mut waves.of(index), s), ratio, max_relative = 1e-11);
                    }
                }
            }
        }
    }

    /// A pair has the compliance of the relaxing body plus the compliance of the elastic one.
    #[test]
    fn a_second_body_is_in_series() {
        let (prony, grid) = (three(), Grid::new([6, 4], [1.0, 0.8]).unwrap());
        let material = |young, nu| Material::from_young(young, nu).unwrap();
        let slab = |young, height| Body::slab(material(young, 0.3), height).unwrap();
        let half_space = |young| Body::half_space(material(young, 0.2));
        let of = |branches: &mut dyn Iterator<Item = Branch>, s: f64| {
            1.0 + branches.map(|branch| branch.weight * s / (s + 1.0 / branch.time)).sum::<f64>()
        };
        let pairs = [
            (half_space(1.0), half_space(3.0)),
            (half_space(1.0), half_space(1e-9)),
            (half_space(1.0), half_space(1e9)),
            (slab(1.0, 0.2), half_space(2.0)),
            (slab(1.0, 0.2), slab(0.5, 0.1)),
            (half_space(1.0), slab(2.0, 0.1)),
        ];
        for ((first, second), relaxes) in pairs.iter().flat_map(|pair| Relaxes::ALL.map(|relaxes| (pair, relaxes))) {
            let branches_of = |body: &Body, mode: usize| -> Vec<Branch> {
                match Spectrum::new(body, &Modes::all(&grid), false, &prony, relaxes).unwrap() {
                    Spectrum::Common(branches) => branches,
                    Spectrum::Waves(waves) => waves.of(mode).collect(),
                }
            };
            let pair = first.clone().against(second.clone());
            for (index, mode) in grid.modes().enumerate() {
                let compliance = |body: &Body| match mode.wavenumber() {
                    0.0 => body.level_compliance()[1],
                    q => body.normal_compliance(q),
                };
                for s in [0.0, 1e-3, 0.2, 3.0, 1e4] {
                    let wanted =
                        compliance(first) / of(&mut branches_of(first, index).into_iter(), s) + compliance(second);
                    let found = compliance(&pair) / of(&mut branches_of(&pair, index).into_iter(), s);
                    assert!((found - wanted).abs() <= 1e-12 * wanted, "{first:?} {second:?} {s}: {found} {wanted}");
                }
            }
        }
        let common =
            Spectrum::new(&half_space(1.0).against(half_space(3.0)), &Modes::all(&grid), true, &prony, Relaxes::Both);
        assert!(matches!(common, Ok(Spectrum::Common(branches)) if branches.len() == 3));
    }

    #[test]
    fn bodies_without_a_known_spectrum_are_refused() {
        let grid = Grid::square(4, 1.0).unwrap();
        let material = |nu| Material::from_young(1.0, nu).unwrap();
        let slab = |nu| Body::slab(material(nu), 0.3).unwrap();
        let refused = |body: &Body, is_free| {
            Spectrum::new(body, &Modes::all(&grid), is_free, &three(), Relaxes::Shear).unwrap_err().to_string()
        };
        assert!(refused(&slab(0.3).bonded_to(slab(0.3)).unwrap(), false).ends_with("with layers"));
        let pair = refused(&slab(0.3).against(Body::half_space(material(0.3))), true);
        assert!(pair.ends_with("with a slab with free boundaries"), "{pair}");
        assert!(refused(&slab(0.3), true).ends_with("with a slab with free boundaries"));
        let common = Spectrum::new(&slab(0.5), &Modes::all(&grid), true, &three(), Relaxes::Shear);
        assert!(matches!(common, Ok(Spectrum::Common(branches)) if branches.len() == 3));
    }
}
