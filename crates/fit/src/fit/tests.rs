use std::collections::BTreeMap;

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use rayon::prelude::*;

use super::shapes;
use crate::projection::Search;
use crate::rows::Rows;
use crate::*;

const TRUTH: Parameters = Parameters {
    kappa_tfc: 2.07,
    coefficients: [-0.31, 0.83, 1.74],
    exponents: [1.37, 0.71, 1.13],
    crossed: false,
    edge: [0.0; 2],
};

const FREE: Settings = Settings {
    model: Model {
        t: Some(Exponent::FREE),
        f: Some(Exponent::FREE),
        c: Some(Exponent::FREE),
        crossed: false,
        edge: None,
    },
    weighting: Weighting::Shrunk { prior: 8.0 },
    resamples: 0,
    seed: 1,
    paired: true,
};

/// Returns a standard normal number by the Box–Muller transform.
fn normal(rng: &mut Pcg64) -> f64 {
    let (u, v): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Returns kappa of one datum with one realisation, without noise.
fn exact(truth: &Parameters, eps: [f64; 3]) -> Datum {
    Datum::new(eps, [(0, truth.predict(eps))].into())
}

/// Returns four levels per axis, one axis at a time from one corner, as in a sweep.
fn star() -> Vec<[f64; 3]> {
    let corner = [0.5, 0.25, 0.5];
    let mut all = vec![corner];
    for axis in 0..3 {
        for level in 1..4 {
            let mut eps = corner;
            eps[axis] *= 0.5_f64.powi(level);
            all.push(eps);
        }
    }
    all
}

/// Returns a sweep with noise: each surface (eps_t, eps_f, seed) has noise common to its data, and each datum its own.
fn noisy(truth: &Parameters, places: &[[f64; 3]], seeds: u64, common: f64, own: f64, rng: &mut Pcg64) -> Vec<Datum> {
    let mut surfaces: BTreeMap<(u64, u64, u64), f64> = BTreeMap::new();
    let mut numbers: BTreeMap<(u64, u64), u64> = BTreeMap::new();
    places
        .iter()
        .map(|&eps| {
            let surface = (eps[0].to_bits(), eps[1].to_bits());
            let next = numbers.len() as u64;
            let first = 1000 * *numbers.entry(surface).or_insert(next);
            let kappa = (0..seeds).map(|i| {
                let shift = *surfaces.entry((surface.0, surface.1, i)).or_insert_with(|| common * normal(rng));
                (first + i, truth.predict(eps) + shift + own * normal(rng))
            });
            Datum::new(eps, kappa.collect())
        })
        .collect()
}

#[test]
fn exact_data_are_recovered() {
    let data: Vec<Datum> = star().into_iter().map(|eps| exact(&TRUTH, eps)).collect();
    let found = fit(&data, &FREE).unwrap();
    assert!((found.kappa_tfc.value - TRUTH.kappa_tfc).abs() < 1e-8, "{:?}", found.kappa_tfc);
    for axis in 0..3 {
        assert!((found.parameters.coefficients[axis] - TRUTH.coefficients[axis]).abs() < 1e-7);
        assert!((found.parameters.exponents[axis] - TRUTH.exponents[axis]).abs() < 1e-7);
    }
    assert!(found.chi_squared < 1e-18 && found.degrees_of_freedom == 3 && !found.noise_known);
    for report in &found.data {
        assert!((report.fitted - report.mean).abs() < 1e-9);
        let without = report.kappa_tfc_without.unwrap();
        assert!((without - TRUTH.kappa_tfc).abs() < 1e-6, "{without}");
    }
}

#[test]
fn the_solution_does_not_hide_behind_a_local_minimum() {
    // Two free exponents far apart, with nearly cancelling coefficients.
    let truth = Parameters { kappa_tfc: 1.9, coefficients: [0.0, 1.2, -1.1], exponents: [1.0, 3.6, 0.31], ..TRUTH };
    let places = (0..5).flat_map(|i| (0..5).map(move |j| [0.5, 0.3 * 0.6_f64.powi(i), 0.4 * 0.5_f64.powi(j)]));
    let data: Vec<Datum> = places.map(|eps| exact(&truth, eps)).collect();
    let found = fit(&data, &FREE).unwrap();
    assert!((found.kappa_tfc.value - 1.9).abs() < 1e-8);
    assert_eq!(found.warnings[0], Warning::SingleLevel { axis: Axis::Thermodynamic, eps: 0.5 });
}

#[test]
fn noisy_data_are_recovered_within_the_interval() {
    let mut rng = Pcg64::seed_from_u64(11);
    let data = noisy(&TRUTH, &star(), 12, 0.004, 0.001, &mut rng);
    let found = fit(&data, &Settings { resamples: 400, ..FREE }).unwrap();
    let contains = |estimate: Estimate, truth: f64| {
        let [low, high] = estimate.ci95.unwrap();
        assert!(low < estimate.value && estimate.value < high);
        low <= truth && truth <= high
    };
    assert!(contains(found.kappa_tfc, TRUTH.kappa_tfc), "{:?}", found.kappa_tfc);
    for term in &found.terms {
        assert!(contains(term.coefficient, TRUTH.coefficients[term.axis as usize]), "{term:?}");
        assert!(contains(term.exponent, TRUTH.exponents[term.axis as usize]), "{term:?}");
    }
    assert_eq!(found.uncertainty, Uncertainty::Realisations);
    assert!(found.bootstrap.unwrap().failed == 0);
}

/// Returns the fraction of `experiments` intervals that contain the truth.
fn coverage(seeds: u64, settings: &Settings, experiments: u64) -> f64 {
    let truth = Parameters { exponents: [1.0, 1.0, 1.13], ..TRUTH };
    let hits = (0..experiments).into_par_iter().filter(|&experiment| {
        let mut rng = Pcg64::seed_from_u64(1000 + experiment);
        let data = noisy(&truth, &star(), seeds, 0.02, 0.004, &mut rng);
        let [low, high] = fit(&data, settings).unwrap().kappa_tfc.ci95.unwrap();
        low <= truth.kappa_tfc && truth.kappa_tfc <= high
    });
    hits.count() as f64 / experiments as f64
}

#[test]
fn intervals_contain_the_truth_as_often_as_they_say() {
    let model = Model { c: Some(Exponent::FREE), ..Model::default() };
    let settings = Settings { model, resamples: 200, ..FREE };
    for seeds in [3, 4, 16] {
        let rate = coverage(seeds, &settings, 200);
        assert!((0.90..=0.985).contains(&rate), "{seeds} realisations: {rate}");
    }
    // Without a bootstrap: linear propagation.
    let rate = coverage(6, &Settings { resamples: 0, ..settings }, 200);
    assert!((0.90..=0.985).contains(&rate), "linear: {rate}");
}

#[test]
fn misfit_stands_in_for_scatter_with_one_realisation() {
    let model = Model { c: Some(Exponent::FREE), ..Model::default() };
    let truth = Parameters { exponents: [1.0, 1.0, 1.13], ..TRUTH };
    let settings = Settings { model, ..FREE };
    let hits = (0..300).filter(|&experiment| {
        let mut rng = Pcg64::seed_from_u64(experiment);
        let data = noisy(&truth, &star(), 1, 0.0, 0.005, &mut rng);
        let found = fit(&data, &settings).unwrap();
        assert_eq!(found.uncertainty, Uncertainty::Misfit);
        let [low, high] = found.kappa_tfc.ci95.unwrap();
        low <= truth.kappa_tfc && truth.kappa_tfc <= high
    });
    let rate = hits.count() as f64 / 300.0;
    assert!((0.90..=0.985).contains(&rate), "{rate}");
}

#[test]
fn common_noise_cancels_only_if_cells_stay_paired() {
    // Levels in eps_c alone are computed on common surfaces, so that the common noise hardly affects the slope.
    let places: Vec<[f64; 3]> = (0..4).map(|i| [0.5, 0.1, 0.5_f64.powi(i + 1)]).collect();
    let data = noisy(&TRUTH, &places, 10, 0.02, 0.001, &mut Pcg64::seed_from_u64(5));
    let model = Model { c: Some(Exponent::Fixed(TRUTH.exponents[2])), ..Model::default() };
    let settings = Settings { model, resamples: 1000, ..FREE };
    let width = |settings: &Settings| {
        let found = fit(&data, settings).unwrap();
        let [low, high] = found.terms[0].coefficient.ci95.unwrap();
        high - low
    };
    let (paired, unpaired) = (width(&settings), width(&Settings { paired: false, ..settings }));
    assert!(paired < 0.2 * unpaired, "paired {paired}, unpaired {unpaired}");
}

#[test]
fn the_bootstrap_agrees_with_linear_propagation_where_the_model_is_linear() {
    let data = noisy(&TRUTH, &star(), 30, 0.01, 0.005, &mut Pcg64::seed_from_u64(9));
    let linear = fit(&data, &Settings { model: Model::default(), ..FREE }).unwrap();
    let resampled = fit(&data, &Settings { model: Model::default(), resamples: 4000, ..FREE }).unwrap();
    assert_eq!((linear.uncertainty, linear.kappa_tfc.value), (Uncertainty::Propagated, resampled.kappa_tfc.value));
    let pairs =
        [(linear.kappa_tfc, resampled.kappa_tfc), (linear.terms[2].coefficient, resampled.terms[2].coefficient)];
    for (a, b) in pairs {
        let width = |estimate: Estimate| estimate.ci95.map(|[low, high]| high - low).unwrap();
        approx::assert_relative_eq!(width(a), width(b), max_relative = 0.08);
    }
}

#[test]
fn sensitivities_are_derivatives_of_the_fit() {
    let mut rng = Pcg64::seed_from_u64(3);
    let mut data = noisy(&TRUTH, &star(), 1, 0.0, 1e-9, &mut rng);
    let means = Rows::new(&data, &Settings { weighting: Weighting::Equal, ..FREE }, None, [0.0; 2]).means;
    let (shapes, _) = shapes(&data, &FREE.model, &mut Vec::new());
    let minimum = means.minimise(&shapes, Search::Thorough, None).unwrap();
    let rows = means.sensitivities(&shapes, &minimum.parameters).unwrap();
    for datum in [0, 4, 9] {
        let step = 1e-5;
        let mut moved = |by: f64| {
            *data[datum].kappa.values_mut().next().unwrap() += by;
            let parameters = fit(&data, &FREE).unwrap().parameters;
            *data[datum].kappa.values_mut().next().unwrap() -= by;
            parameters
        };
        let (up, down) = (moved(step), moved(-step));
        let slope = |f: &dyn Fn(&Parameters) -> f64| (f(&up) - f(&down)) / (2.0 * step);
        approx::assert_relative_eq!(rows[0][datum], slope(&|p| p.kappa_tfc), max_relative = 1e-3, epsilon = 1e-6);
        approx::assert_relative_eq!(rows[3][datum], slope(&|p| p.coefficients[2]), max_relative = 1e-3, epsilon = 1e-5);
        approx::assert_relative_eq!(rows[6][datum], slope(&|p| p.exponents[2]), max_relative = 1e-3, epsilon = 1e-5);
    }
}

#[test]
fn profiles_have_their_minimum_at_the_fit() {
    let data = noisy(&TRUTH, &star(), 8, 0.005, 0.002, &mut Pcg64::seed_from_u64(21));
    let found = fit(&data, &FREE).unwrap();
    for term in &found.terms {
        assert!(term.profile.windows(2).all(|pair| pair[0].exponent < pair[1].exponent));
        let least = term.profile.iter().min_by(|a, b| a.chi_squared.total_cmp(&b.chi_squared)).unwrap();
        assert_eq!(least.exponent, term.exponent.value);
        approx::assert_relative_eq!(least.chi_squared, found.chi_squared, max_relative = 1e-9);
        approx::assert_relative_eq!(least.kappa_tfc, found.kappa_tfc.value, max_relative = 1e-7);
    }
    // A fixed exponent also has a profile, which shows the cost of the choice in chi^2.
    let fixed = fit(&data, &Settings { model: Model::default(), ..FREE }).unwrap();
    let point = fixed.terms[2].profile.iter().find(|point| point.exponent == 1.0).unwrap();
    approx::assert_relative_eq!(point.chi_squared, fixed.chi_squared, max_relative = 1e-9);
    assert!(fixed.terms[2].profile.iter().any(|point| point.chi_squared < fixed.chi_squared));
}

#[test]
fn as_many_parameters_as_cells_interpolate_and_more_are_refused() {
    let truth = Parameters { coefficients: [0.0, 0.0, 1.7], ..TRUTH };
    let data: Vec<Datum> = [0.5, 0.25, 0.125].iter().map(|&c| exact(&truth, [0.5, 0.1, c])).collect();
    let found = fit(&data, &FREE).unwrap();
    assert_eq!((found.degrees_of_freedom, found.uncertainty), (0, Uncertainty::None));
    assert!(found.warnings.contains(&Warning::Interpolation));
    assert_eq!(
        found.warnings[2].to_string(),
        "there are as many parameters as data: their misfit gives no uncertainty"
    );
    assert_eq!((found.kappa_tfc.ci95, found.kappa_tfc.standard_error), (None, None));
    assert!((found.kappa_tfc.value - truth.kappa_tfc).abs() < 1e-8);
    let error = fit(&[data[0].clone(), exact(&TRUTH, [0.25, 0.1, 0.25])], &FREE).unwrap_err();
    assert_eq!(error, FitError::TooFewData { parameters: 3, data: 2 });
}

#[test]
fn two_levels_hold_a_free_exponent_and_say_so() {
    let truth = Parameters { coefficients: [0.0, 0.5, 1.7], exponents: [1.0, 1.0, 1.3], ..TRUTH };
    let places = [0.2, 0.1].iter().flat_map(|&f| [0.5, 0.25, 0.125, 0.0625].map(|c| [0.5, f, c]));
    let data: Vec<Datum> = places.map(|eps| exact(&truth, eps)).collect();
    let found = fit(&data, &FREE).unwrap();
    assert!(found.warnings.contains(&Warning::ExponentHeld { axis: Axis::Fractal, alpha: 1.0 }));
    assert!(found.terms[0].held && !found.terms[0].free && found.terms[0].exponent.ci95.is_none());
    assert!((found.kappa_tfc.value - truth.kappa_tfc).abs() < 1e-8);
}

#[test]
fn exponents_stop_at_their_bounds_and_say_so() {
    let truth = Parameters { coefficients: [0.0, 0.0, 1.7], exponents: [1.0, 1.0, 2.5], ..TRUTH };
    let places: Vec<[f64; 3]> = (0..5).map(|i| [0.5, 0.1, 0.5_f64.powi(i)]).collect();
    let data = noisy(&truth, &places, 5, 0.0, 1e-4, &mut Pcg64::seed_from_u64(2));
    let model = Model { c: Some(Exponent::Free { min: 0.5, max: 2.0 }), ..Model::default() };
    let found = fit(&data, &Settings { model, resamples: 50, ..FREE }).unwrap();
    let term = &found.terms[0];
    assert!(term.at_bound && term.exponent.value == 2.0 && term.exponent.ci95.is_none());
    assert!(found.warnings.contains(&Warning::ExponentAtBound { axis: Axis::Continuum, alpha: 2.0 }));
    assert!(found.bootstrap.as_ref().unwrap().at_bound == [(Axis::Continuum, 50)]);
    let warned = |w: &Warning| matches!(w, Warning::Misfit { .. });
    assert!(found.degrees_of_freedom > 0 && found.warnings.iter().any(warned), "{:?}", found.warnings);
}

#[test]
fn terms_are_left_out_only_on_request() {
    let data = noisy(&TRUTH, &star(), 6, 0.01, 0.01, &mut Pcg64::seed_from_u64(8));
    let model = Model { t: None, ..Model::default() };
    let found = fit(&data, &Settings { model, ..FREE }).unwrap();
    assert_eq!(found.warnings[0], Warning::TermLeftOut { axis: Axis::Thermodynamic, levels: 4 });
    assert_eq!(found.terms.iter().map(|term| term.axis).collect::<Vec<_>>(), [Axis::Fractal, Axis::Continuum]);
    let none = Parameters { coefficients: [0.0; 3], ..TRUTH };
    let data = noisy(&none, &star(), 6, 0.01, 0.01, &mut Pcg64::seed_from_u64(8));
    let found = fit(&data, &Settings { model: Model::default(), resamples: 300, ..FREE }).unwrap();
    assert_eq!(found.terms.len(), 3);
    let weak = found.warnings.iter().filter(|w| matches!(w, Warning::NotSignificant { .. })).count();
    assert!(weak >= 2, "{:?}", found.warnings);
}

#[test]
fn weights_lie_between_the_pool_and_the_datum() {
    let mut rng = Pcg64::seed_from_u64(17);
    let mut data = noisy(&TRUTH, &star()[..2], 5, 0.0, 0.01, &mut rng);
    data[1].kappa = noisy(&TRUTH, &star()[1..2], 40, 0.0, 0.1, &mut rng).remove(0).kappa;
    let variance = |weighting, index: usize| {
        let rows = Rows::new(&data, &Settings { weighting, paired: false, ..FREE }, None, [0.0; 2]);
        assert!(rows.noise_known);
        data[index].kappa.len() as f64 / rows.means.root_weight[index].powi(2)
    };
    for (index, datum) in data.iter().enumerate() {
        let own = datum.variance().unwrap();
        let pooled = variance(Weighting::Pooled, index);
        let shrunk = variance(Weighting::Shrunk { prior: 8.0 }, index);
        assert!(own.min(pooled) < shrunk && shrunk < own.max(pooled));
        let own_weight = (datum.kappa.len() - 1) as f64;
        approx::assert_relative_eq!(
            shrunk,
            (8.0 * pooled + own_weight * own) / (8.0 + own_weight),
            max_relative = 1e-12
        );
    }
    approx::assert_relative_eq!(variance(Weighting::Pooled, 0), variance(Weighting::Pooled, 1), max_relative = 1e-12);
    assert!(!Rows::new(&data, &Settings { weighting: Weighting::Equal, ..FREE }, None, [0.0; 2]).noise_known);
}

#[test]
fn richardson_passes_through_three_levels() {
    let truth = Parameters { coefficients: [0.0, 0.0, 1.74], ..TRUTH };
    for (ratio, exponent) in [(2.0, 0.5), (2.0, 1.0), (2.0, 2.0), (3.0, 1.3)] {
        let truth = Parameters { exponents: [1.0, 1.0, exponent], ..truth };
        let data: Vec<Datum> = (0..3).map(|i| exact(&truth, [0.5, 0.1, 0.4 * f64::powi(ratio, -i)])).rev().collect();
        let found = richardson::triples(&data, Axis::Continuum);
        assert_eq!((found.len(), found[0].data), (1, [2, 1, 0]));
        let limit = found[0].limit.unwrap();
        approx::assert_relative_eq!(limit.kappa, truth.kappa_tfc, max_relative = 1e-12);
        approx::assert_relative_eq!(limit.exponent, exponent, max_relative = 1e-9);
        assert_eq!(limit.standard_error, None);
        assert_eq!(found[0].limit.is_some(), found[0].ratio > 1.0);
    }
    // Growing differences: no power law passes through the data.
    let mut data: Vec<Datum> = (0..3).map(|i| exact(&truth, [0.5, 0.1, 0.5_f64.powi(i)])).collect();
    data[2].kappa = [(0, truth.kappa_tfc - 5.0)].into();
    let found = richardson::triples(&data, Axis::Continuum);
    assert!(found[0].ratio < 1.0 && found[0].limit.is_none());
    // Four levels give two triples; axes with one level give none.
    let four: Vec<Datum> = star()[6..].iter().chain(&star()[..1]).map(|&eps| exact(&truth, eps)).collect();
    assert_eq!(richardson::triples(&four, Axis::Continuum).len(), 2);
    assert_eq!(richardson::triples(&four, Axis::Fractal).len(), 0);
}

#[test]
fn richardson_amplifies_noise_as_derived() {
    // Independent noise of equal size on three levels, by exponent (theory.md, section 11): 21, 5.7, 2.0.
    for (exponent, amplification) in [(0.5, 21.0), (1.0, 5.7), (2.0, 2.0)] {
        let truth = Parameters { coefficients: [0.0, 0.0, 1.0], exponents: [1.0, 1.0, exponent], ..TRUTH };
        let places: Vec<[f64; 3]> = (0..3).map(|i| [0.5, 0.1, 0.5_f64.powi(i + 1)]).collect();
        let data = noisy(&truth, &places, 4000, 0.0, 1e-4, &mut Pcg64::seed_from_u64(4));
        let limit = richardson::triples(&data, Axis::Continuum)[0].limit.unwrap();
        let found = limit.standard_error.unwrap() / (1e-4 / 4000_f64.sqrt());
        approx::assert_relative_eq!(found, amplification, max_relative = 0.06);
    }
}

#[test]
fn the_same_bits_come_out_of_any_number_of_threads() {
    let data = noisy(&TRUTH, &star(), 5, 0.01, 0.002, &mut Pcg64::seed_from_u64(6));
    let settings = Settings { resamples: 100, ..FREE };
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fit(&data, &settings).unwrap())
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one, three);
    let other = fit(&data, &Settings { seed: 2, ..settings }).unwrap();
    assert!(other.kappa_tfc.value == one.kappa_tfc.value && other.kappa_tfc.ci95 != one.kappa_tfc.ci95);
}

#[test]
fn missing_realisations_are_made_up_for() {
    let mut data = noisy(&TRUTH, &star(), 6, 0.01, 0.001, &mut Pcg64::seed_from_u64(6));
    let first = *data[8].kappa.keys().next().unwrap();
    data[8].kappa.remove(&first);
    let lone = *data[9].kappa.keys().next().unwrap();
    data[9].kappa.retain(|&seed, _| seed == lone);
    let found = fit(&data, &Settings { model: Model::default(), resamples: 200, ..FREE }).unwrap();
    assert_eq!(found.bootstrap.as_ref().unwrap().failed, 0);
    assert!(found.warnings.contains(&Warning::SingleRealisation { data: 1 }));
    assert!(found.kappa_tfc.ci95.is_some());
}

/// Returns a ladder of nested surfaces as a sweep computes them, with fewer surfaces on finer grids. The scatter of a
/// surface falls along eps_f but stays correlated; the edge of the contact adds 0.83 times its measure to kappa.
fn ladder(truth: &Parameters, seeds: u64, rng: &mut Pcg64) -> Vec<Datum> {
    let rungs = [(8.0, 4.0), (16.0, 4.0), (32.0, 4.0), (64.0, 4.0), (8.0, 8.0), (8.0, 16.0), (16.0, 8.0)];
    let surfaces: Vec<f64> = (0..8 * seeds).map(|_| normal(rng)).collect();
    let of_surface = |seeds: u64| surfaces[..seeds as usize].iter().enumerate();
    let rung = |&(f, c): &(f64, f64)| {
        let eps = [0.5, 1.0 / f, 1.0 / c];
        let count = ((8.0 * seeds as f64 * 32.0 / (f * c)) as u64).clamp(seeds, 8 * seeds);
        let scatter = 0.2 * (8.0 / f);
        let edges: Vec<f64> =
            of_surface(count).map(|(_, z)| (3.0 / (c * f.sqrt())) * (1.0 + 0.1 * z + 0.02 * normal(rng))).collect();
        let kappa = of_surface(count).zip(&edges).map(|((seed, z), edge)| {
            let noise = scatter * z + 0.1 * scatter * normal(rng);
            (seed as u64, truth.predict(eps) + truth.excess(eps[2], *edge) + noise)
        });
        let kappa = kappa.collect();
        let edge = edges.iter().enumerate().map(|(seed, edge)| (seed as u64, *edge)).collect();
        Datum { edge, ..Datum::new(eps, kappa) }
    };
    rungs.iter().map(rung).collect()
}

const LADDER: Parameters = Parameters {
    kappa_tfc: 1.75,
    coefficients: [0.0, 0.8, 0.0],
    exponents: [1.0, 0.2, 1.0],
    crossed: false,
    edge: [0.83, 0.0],
};

const ON_LADDER: Settings = Settings { model: ON_EDGE, resamples: 0, ..FREE };

const ON_EDGE: Model =
    Model { t: None, f: Some(Exponent::Fixed(0.2)), c: None, crossed: false, edge: Some(Edge::UNKNOWN) };

#[test]
fn exact_ladders_give_the_limit_and_the_factor_of_the_edge() {
    let mut data = ladder(&LADDER, 4, &mut Pcg64::seed_from_u64(1));
    for datum in &mut data {
        let eps = datum.all_eps();
        datum.kappa = datum.edge.iter().map(|(s, e)| (*s, LADDER.predict(eps) + LADDER.excess(eps[2], *e))).collect();
    }
    let found = fit(&data, &ON_LADDER).unwrap();
    approx::assert_relative_eq!(found.kappa_tfc.value, 1.75, max_relative = 1e-9);
    let edge = found.edge.unwrap();
    approx::assert_relative_eq!(edge.factor.value, 0.83, max_relative = 1e-8);
    for (datum, report) in data.iter().zip(&found.data) {
        approx::assert_relative_eq!(report.fitted, datum.mean(), max_relative = 1e-9);
        let on_term = found.kappa_tfc.value + 0.8 * datum.eps_f.powf(0.2);
        approx::assert_relative_eq!(found.isolate(datum, Axis::Fractal), on_term, max_relative = 1e-8);
    }
}

/// Returns the fraction of intervals that contain the truth, and their mean width, over `experiments` ladders.
fn ladder_coverage(settings: &Settings, seeds: u64, experiments: u64) -> (f64, f64) {
    let intervals: Vec<[f64; 2]> = (0..experiments)
        .into_par_iter()
        .map(|experiment| {
            let data = ladder(&LADDER, seeds, &mut Pcg64::seed_from_u64(experiment));
            fit(&data, settings).unwrap().kappa_tfc.ci95.unwrap()
        })
        .collect();
    let hits = intervals.iter().filter(|[low, high]| *low <= LADDER.kappa_tfc && LADDER.kappa_tfc <= *high).count();
    let width = intervals.iter().map(|[low, high]| high - low).sum::<f64>() / experiments as f64;
    (hits as f64 / experiments as f64, width)
}

#[test]
fn intervals_of_nested_surfaces_contain_the_truth_and_are_narrow() {
    for seeds in [4, 8, 16] {
        let (rate, width) = ladder_coverage(&ON_LADDER, seeds, 1000);
        // A chi^2 that exceeds its degrees of freedom by chance also widens an interval.
        assert!((0.93..=0.995).contains(&rate), "{seeds} realisations: {rate}");
        let (_, alone) = ladder_coverage(&Settings { paired: false, ..ON_LADDER }, seeds, 50);
        assert!(width < 0.5 * alone, "{seeds} realisations: {width} with surfaces compared, {alone} without");
    }
}

/// kappa = 1.9 + 0.6 eps_f^0.7 (1 + 1.5 eps_t^2), as a model with a fitted exponent.
#[test]
fn a_crossed_term_falls_with_the_power_of_eps_f() {
    let truth = Parameters {
        kappa_tfc: 1.9,
        coefficients: [0.9, 0.6, 0.0],
        exponents: [2.0, 0.7, 1.0],
        crossed: true,
        edge: [0.0; 2],
    };
    let places: Vec<[f64; 3]> =
        [1.0, 0.5].iter().flat_map(|&t| [16.0, 32.0, 64.0, 128.0].map(|f: f64| [t, f.recip(), 0.25])).collect();
    let model = Model {
        t: Some(Exponent::Fixed(2.0)),
        f: Some(Exponent::Free { min: 0.3, max: 1.2 }),
        c: None,
        crossed: true,
        edge: None,
    };
    let settings = Settings { model, resamples: 0, ..FREE };
    let data: Vec<Datum> = places.iter().map(|&eps| exact(&truth, eps)).collect();
    let found = fit(&data, &settings).unwrap();
    approx::assert_relative_eq!(found.kappa_tfc.value, 1.9, max_relative = 1e-8);
    approx::assert_relative_eq!(found.term(Axis::Fractal).unwrap().exponent.value, 0.7, max_relative = 1e-6);
    approx::assert_relative_eq!(found.term(Axis::Thermodynamic).unwrap().coefficient.value, 0.9, max_relative = 1e-6);
    for datum in &data {
        let power = found.parameters.power(Axis::Thermodynamic, datum.all_eps());
        approx::assert_relative_eq!(power, datum.eps_t.powi(2) * datum.eps_f.powf(0.7), max_relative = 1e-6);
        let isolated = found.isolate(datum, Axis::Thermodynamic);
        approx::assert_relative_eq!(isolated, 1.9 + 0.9 * power, max_relative = 1e-8);
    }
    // Tests the derivative with respect to an exponent that two terms share.
    let noisy = noisy(&truth, &places, 6, 0.0, 1e-5, &mut Pcg64::seed_from_u64(3));
    let noisy = fit(&noisy, &Settings { resamples: 400, ..settings }).unwrap();
    let [low, high] = noisy.kappa_tfc.ci95.unwrap();
    let linear = 1.96 * noisy.kappa_tfc.standard_error.unwrap();
    assert!(low < 1.9 && 1.9 < high && (0.5 * (high - low) / linear - 1.0).abs() < 0.25, "{low} {high} {linear}");
    // A constant in place of the crossed term misses these data, as chi^2 and the interval show.
    let additive = fit(&data, &Settings { model: Model { crossed: false, ..model }, ..settings }).unwrap();
    assert!((additive.kappa_tfc.value - 1.9).abs() > 1e-3);
}

#[test]
fn an_expected_factor_of_the_edge_is_one_more_observation() {
    let data = ladder(&LADDER, 8, &mut Pcg64::seed_from_u64(3));
    let with =
        |edge: Edge| fit(&data, &Settings { model: Model { edge: Some(edge), ..ON_EDGE }, ..ON_LADDER }).unwrap();
    let alone = with(Edge::UNKNOWN);
    let [own, expected] = [alone.edge.unwrap().factor, Estimate { value: 0.8, standard_error: Some(0.01), ci95: None }];
    let both = with(Edge { factor: 0.8, standard_error: 0.01, coarse: 0.0 });
    let error = own.standard_error.unwrap();
    let weight = |error: f64| error.powi(-2);
    let mean = (weight(error) * own.value + weight(0.01) * expected.value) / (weight(error) + weight(0.01));
    let found = both.edge.unwrap();
    approx::assert_relative_eq!(found.factor.value, mean, max_relative = 1e-2);
    assert!(found.factor.standard_error.unwrap() < 0.011 && found.share.unwrap() < alone.edge.unwrap().share.unwrap());
    assert!(found.share.unwrap() < both.kappa_tfc.standard_error.unwrap());
    assert_eq!(both.degrees_of_freedom, alone.degrees_of_freedom + 1);
    // A factor that grows with eps_c^2 is found as well.
    let coarse = Parameters { edge: [0.83, 0.1], ..LADDER };
    let grown = ladder(&coarse, 64, &mut Pcg64::seed_from_u64(3));
    let edge = Edge { factor: 0.8, standard_error: 0.5, coarse: 0.5 };
    let grown = fit(&grown, &Settings { model: Model { edge: Some(edge), ..ON_EDGE }, ..ON_LADDER }).unwrap();
    let found = [grown.edge.unwrap().factor, grown.edge.unwrap().coarse.unwrap()];
    for (found, truth) in found.iter().zip(coarse.edge) {
        let error = found.standard_error.unwrap();
        assert!((found.value - truth).abs() < 4.0 * error && error < 0.1, "{found:?} {truth}");
    }
    // On a single grid the expected factor applies.
    let one: Vec<Datum> = data.iter().filter(|datum| datum.eps_c == 0.25).cloned().collect();
    let settings = |edge| Settings { model: Model { edge: Some(edge), ..ON_EDGE }, ..ON_LADDER };
    let known = fit(&one, &settings(Edge { factor: 0.8, standard_error: 0.01, coarse: 0.0 })).unwrap();
    approx::assert_relative_eq!(known.edge.unwrap().factor.value, 0.8, max_relative = 5e-3);
    let unknown = fit(&one, &settings(Edge::UNKNOWN)).unwrap();
    assert!(unknown.edge.is_none() && unknown.warnings.iter().any(|w| matches!(w, Warning::SingleLevel { .. })));
}

#[test]
fn intervals_are_widened_where_chi_squared_is_too_large() {
    // A curve that no line fits: chi^2 is 100 times its degrees of freedom.
    let truth = Parameters { coefficients: [0.0, 0.0, 1.7], exponents: [1.0, 1.0, 2.5], ..TRUTH };
    let places: Vec<[f64; 3]> = (0..5).map(|i| [0.5, 0.1, 0.5_f64.powi(i)]).collect();
    let data = noisy(&truth, &places, 5, 0.0, 1e-3, &mut Pcg64::seed_from_u64(2));
    let settings = Settings { model: Model { t: None, f: None, ..Model::default() }, ..FREE };
    let found = fit(&data, &settings).unwrap();
    let ratio = (found.chi_squared / found.degrees_of_freedom as f64).sqrt();
    let scatter = Rows::new(&data, &settings, None, [0.0; 2]);
    let means = &scatter.means;
    let (shapes, _) = shapes(&data, &settings.model, &mut Vec::new());
    let sensitivities = means.sensitivities(&shapes, &found.parameters).unwrap();
    let plain = scatter.spread(&sensitivities[0]).unwrap().standard_error;
    assert!(ratio > 10.0);
    approx::assert_relative_eq!(found.kappa_tfc.standard_error.unwrap(), ratio * plain, max_relative = 1e-9);
}

#[test]
fn unusable_input_is_refused() {
    let good: Vec<Datum> = star().into_iter().map(|eps| exact(&TRUTH, eps)).collect();
    let with = |change: &dyn Fn(&mut Vec<Datum>)| {
        let mut data = good.clone();
        change(&mut data);
        fit(&data, &FREE).unwrap_err()
    };
    assert_eq!(with(&|data| data.clear()), FitError::NoData);
    assert_eq!(with(&|data| data[2].kappa.clear()), FitError::NoRealisations { datum: 2 });
    assert_eq!(
        with(&|data| assert!(data[1].kappa.insert(7, f64::INFINITY).is_none())),
        FitError::BadKappa { datum: 1, seed: 7, found: f64::INFINITY }
    );
    assert_eq!(with(&|data| data[3].eps_c = 0.0), FitError::BadEps { datum: 3, axis: Axis::Continuum, found: 0.0 });
    assert!(matches!(with(&|data| data[3].eps_t = f64::NAN), FitError::BadEps { datum: 3, .. }));
    assert_eq!(with(&|data| data.push(data[4].clone())), FitError::SameDatum { first: 4, second: 10 });
    let edge = |c, edge| {
        let model = Model { c, edge: Some(edge), ..Model::default() };
        fit(&good, &Settings { model, ..FREE }).unwrap_err()
    };
    assert_eq!(edge(Some(Exponent::FREE), Edge::UNKNOWN), FitError::TwoContinuumTerms);
    assert_eq!(edge(None, Edge::UNKNOWN), FitError::NoEdge { datum: 0 });
    let bad = FitError::BadEdge { factor: 1.0, standard_error: 0.0, coarse: 0.0 };
    assert_eq!(edge(None, Edge { factor: 1.0, standard_error: 0.0, coarse: 0.0 }), bad);
    let with = |model| fit(&good, &Settings { model, ..FREE }).unwrap_err();
    let bad = FitError::BadExponent { axis: Axis::Fractal, min: 0.0, max: 0.0 };
    assert_eq!(with(Model { f: Some(Exponent::Fixed(0.0)), ..Model::default() }), bad);
    let inverted = with(Model { t: Some(Exponent::Free { min: 2.0, max: 1.0 }), ..Model::default() });
    assert_eq!(inverted.to_string(), "the range of alpha_t is [2, 1]; it must be increasing, above 0 and at most 16");
    let error = fit(&good, &Settings { weighting: Weighting::Shrunk { prior: -1.0 }, ..FREE }).unwrap_err();
    assert_eq!(error, FitError::BadPrior { found: -1.0 });
    // eps_f and eps_c vary together: one column is a multiple of the other.
    let together = (0..6).map(|i| exact(&TRUTH, [0.5, 0.2 * 0.5_f64.powi(i), 0.4 * 0.5_f64.powi(i)]));
    let error = fit(&together.collect::<Vec<_>>(), &Settings { model: Model::default(), ..FREE }).unwrap_err();
    assert_eq!(error, FitError::Dependent);
}

#[test]
fn isolated_cells_lie_on_their_own_term() {
    let data: Vec<Datum> = star().into_iter().map(|eps| exact(&TRUTH, eps)).collect();
    let found = fit(&data, &FREE).unwrap();
    for datum in &data {
        let own = TRUTH.kappa_tfc + 1.74 * datum.eps_c.powf(1.13);
        approx::assert_relative_eq!(found.isolate(datum, Axis::Continuum), own, max_relative = 1e-8);
        approx::assert_relative_eq!(found.predict(datum.all_eps()), datum.mean(), max_relative = 1e-9);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(if std::env::var_os("GFMD_LONG").is_some() { 64 } else { 16 }))]

    /// The fit is equivariant under kappa -> scale kappa + shift.
    #[test]
    fn fits_follow_scale_and_shift(seed in 0_u64..1000, scale in 0.01_f64..100.0, shift in -3.0_f64..3.0) {
        let data = noisy(&TRUTH, &star(), 4, 0.003, 0.001, &mut Pcg64::seed_from_u64(seed));
        let model = Model { c: Some(Exponent::FREE), ..Model::default() };
        let settings = Settings { model, ..FREE };
        let before = fit(&data, &settings).unwrap();
        let moved: Vec<Datum> = data
            .iter()
            .map(|datum| {
                let kappa = datum.kappa.iter().map(|(seed, kappa)| (*seed, scale * kappa + shift)).collect();
                Datum { kappa, ..datum.clone() }
            })
            .collect();
        let after = fit(&moved, &settings).unwrap();
        let expected = scale * before.kappa_tfc.value + shift;
        approx::assert_relative_eq!(after.kappa_tfc.value, expected, max_relative = 1e-5, epsilon = 1e-6);
        approx::assert_relative_eq!(after.chi_squared, before.chi_squared, max_relative = 1e-6);
        approx::assert_relative_eq!(after.parameters.exponents[2], before.parameters.exponents[2], max_relative = 1e-5);
    }
}
