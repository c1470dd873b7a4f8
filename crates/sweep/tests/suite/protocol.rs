//! Approach control, slopes, and refused protocols.

use gfmd_sweep::{
    Alpha, Analysis, Config, Control, Design, Estimator, FitConfig, LoadsConfig, Plan, PointsConfig, StatisticsConfig,
    run, run_one,
};

fn config() -> Config {
    Config {
        points: PointsConfig {
            design: Design::Grid,
            eps_t_inv: vec![1.0],
            eps_f_inv: vec![4.0, 8.0, 16.0],
            eps_c_inv: vec![2.0, 4.0, 8.0],
            ..PointsConfig::default()
        },
        loads: LoadsConfig { p_star: vec![0.01, 0.02, 0.03, 0.05], ..LoadsConfig::default() },
        statistics: StatisticsConfig {
            realisations: 3,
            nested: false,
            equal_area: false,
            ..StatisticsConfig::default()
        },
        fit: FitConfig {
            p_star: 0.05,
            alpha_t: Alpha::Without,
            alpha_f: Alpha::Fixed(1.0),
            alpha_c: Alpha::Fixed(1.0),
            estimator: Estimator::Slope,
            references: vec![[1.0, 8.0, 4.0], [1.0, 8.0, 8.0]],
            resamples: 20,
            ..FitConfig::default()
        },
        ..Config::default()
    }
}

#[test]
fn prescribed_approaches_sample_the_curve_of_prescribed_loads() {
    let by_load = Plan::new(config()).unwrap();
    let loads = LoadsConfig { control: Control::Approach, ..config().loads };
    let by_approach = Plan::new(Config { loads, ..config() }).unwrap();
    for index in [0, by_load.runs.len() - 1] {
        let [a, b] = [&by_load, &by_approach].map(|plan| run_one(plan, index, &()).unwrap());
        assert_eq!(a[0], b[0]);
        assert_eq!(a.len(), b.len());
        let step = (b[3].approach - b[0].approach) / 3.0;
        for (k, load) in b.iter().enumerate() {
            approx::assert_relative_eq!(load.approach, b[0].approach + k as f64 * step, max_relative = 1e-9);
        }
        assert!(b.windows(2).all(|pair| pair[0].summary.p_star < pair[1].summary.p_star));
        // The same loads, prescribed, give the same contact.
        let measured: Vec<f64> = b.iter().map(|load| load.summary.p_star).collect();
        let fit = FitConfig { p_star: measured[3], ..config().fit };
        let again = Config { loads: LoadsConfig { p_star: measured, control: Control::Load }, fit, ..config() };
        let again = run_one(&Plan::new(again).unwrap(), index, &()).unwrap();
        for (one, other) in again.iter().zip(&b) {
            approx::assert_relative_eq!(one.summary.mean_gap, other.summary.mean_gap, max_relative = 1e-6);
            let points = one.summary.contact_nodes.abs_diff(other.summary.contact_nodes);
            assert!(points <= 1, "{points} points differ");
        }
    }
}

#[test]
fn the_slope_lies_below_the_ratio_of_a_concave_curve_and_has_one_fit() {
    let plan = Plan::new(config()).unwrap();
    let runs = run(&plan, &()).unwrap();
    let slopes = Analysis::new(&plan, &runs).unwrap();
    let ratio = Config { fit: FitConfig { estimator: Estimator::Ratio, ..config().fit }, ..config() };
    let ratios = Analysis::new(&Plan::new(ratio).unwrap(), &runs).unwrap();
    assert_eq!(slopes.extrapolations.len(), 2, "raw and corrected");
    assert_eq!(ratios.extrapolations.len(), 8);
    for (key, datum) in &slopes.data {
        assert!(datum.mean() < ratios.data[key].mean(), "{key:?}");
    }
    assert_eq!(slopes.protocols.len(), 2);
    for protocol in &slopes.protocols {
        assert_eq!(protocol.arms.len(), 2);
        // The reference less its corrections, by hand.
        let correction = |arm: &gfmd_sweep::Arm| {
            let curve = arm.curve.unwrap();
            curve.coefficient.value * protocol.reference[arm.axis as usize].powf(-curve.exponent.value)
        };
        let by_hand = protocol.kappa_sim.value - protocol.arms.iter().map(correction).sum::<f64>();
        approx::assert_relative_eq!(protocol.kappa_tfc.value, by_hand, max_relative = 1e-12);
        assert!(protocol.kappa_tfc.ci95.is_some());
    }
}

#[test]
fn what_has_no_meaning_is_refused_by_name() {
    let refused = |config: Config, said: &str| {
        let message = match Plan::new(config.clone()) {
            Err(error) => error.to_string(),
            Ok(plan) => Analysis::new(&plan, &run(&plan, &()).unwrap()).map(|_| ()).unwrap_err().to_string(),
        };
        assert!(message.starts_with(said), "{message}");
    };
    let fit = |fit: FitConfig| Config { fit, ..config() };
    let base = || config().fit;
    refused(fit(FitConfig { alpha_c: Alpha::Edge, ..base() }), "fit.alpha_c is \"edge\"; it must be");
    refused(fit(FitConfig { references: vec![[1.0, 0.5, 4.0]], ..base() }), "fit.references is [[1.0, 0.5, 4.0]]");
    refused(fit(FitConfig { references: vec![[1.0, 8.0, 16.0]], ..base() }), "fit.references is [1.0, 8.0, 16.0]");
    let statistics = StatisticsConfig { nested: true, ..config().statistics };
    refused(Config { statistics, ..config() }, "statistics.nested is true");
    let loads = LoadsConfig { p_star: vec![0.05], control: Control::Load };
    refused(Config { loads, ..config() }, "fit.estimator is \"slope\"");
    let loads = LoadsConfig { control: Control::Approach, ..config().loads };
    let ratio = FitConfig { estimator: Estimator::Ratio, ..base() };
    refused(Config { loads, fit: ratio, ..config() }, "loads.control is \"approach\"");
}
