//! Study in pieces: kept, continued, interrupted, one run at a time; refused configurations.

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use gfmd_fit::Warning;
use gfmd_measure::theory::persson_area;
use gfmd_sweep::{
    Alpha, Analysis, Area, Config, Design, Example, FitConfig, Keep, LoadsConfig, Plan, PointsConfig, Pressed, Run,
    StatisticsConfig, Study, SweepError, run, run_one,
};

fn plan() -> Plan {
    let config = Config {
        points: PointsConfig {
            eps_t_inv: vec![1.0, 2.0],
            eps_f_inv: vec![4.0, 8.0],
            eps_c_inv: vec![4.0, 8.0],
            centre: [2.0, 4.0, 4.0],
            design: Design::Star,
            ..PointsConfig::default()
        },
        statistics: StatisticsConfig { realisations: 2, ..StatisticsConfig::default() },
        ..Config::default()
    };
    Plan::new(config).unwrap()
}

/// Store that keeps `room` runs and then fails.
#[derive(Default)]
struct Shelf {
    kept: Mutex<BTreeMap<(usize, u64), Vec<Pressed>>>,
    room: usize,
    recalled: AtomicUsize,
}

impl Keep for Shelf {
    fn recall(&self, run: &Run) -> Option<Vec<Pressed>> {
        let loads = self.kept.lock().unwrap().get(&(run.point, run.realisation)).cloned();
        self.recalled.fetch_add(usize::from(loads.is_some()), Ordering::Relaxed);
        loads
    }

    fn keep(&self, run: &Run, loads: &[Pressed]) -> Result<(), Box<dyn Error + Send + Sync>> {
        let mut kept = self.kept.lock().unwrap();
        if kept.len() >= self.room {
            return Err("the shelf is full".into());
        }
        assert!(kept.insert((run.point, run.realisation), loads.to_vec()).is_none(), "{run:?} was computed twice");
        Ok(())
    }
}

/// Store that asks the sweep to stop at once.
struct Stopped;

impl Keep for Stopped {
    fn is_interrupted(&self) -> bool {
        true
    }
}

#[test]
fn a_study_continued_from_kept_runs_is_the_study_in_one_piece() {
    let plan = plan();
    let whole = Study::new(plan.clone(), &()).unwrap();
    let mut shelf = Shelf { room: 3, ..Shelf::default() };
    assert!(matches!(run(&plan, &shelf), Err(SweepError::Keep(error)) if error.to_string().contains("full")));
    assert_eq!(shelf.kept.lock().unwrap().len(), 3);
    shelf.room = usize::MAX;
    let continued = Study::new(plan.clone(), &shelf).unwrap();
    assert_eq!(shelf.recalled.load(Ordering::Relaxed), 3);
    assert_eq!(continued.runs, whole.runs);
    assert_eq!(continued.analysis.result().fit, whole.analysis.result().fit);
    for number in [0, plan.runs.len() - 1] {
        assert_eq!(run_one(&plan, number, &()).unwrap(), whole.runs[number]);
    }
    let message = run_one(&plan, plan.runs.len(), &()).unwrap_err().to_string();
    assert!(message.starts_with(&format!("run is {}; it must be", plan.runs.len())), "{message}");
}

#[test]
fn an_interruption_ends_runs_and_the_example() {
    let plan = plan();
    for ended in [run(&plan, &Stopped).err(), run_one(&plan, 0, &Stopped).err(), Example::new(&plan, &Stopped).err()] {
        assert!(matches!(ended, Some(SweepError::Interrupted(_))), "{ended:?}");
    }
}

#[test]
fn unusable_fields_are_named_with_what_was_found_and_what_is_allowed() {
    let refused = |text: &str, words: &[&str]| {
        let message = match toml::from_str::<Config>(text) {
            Ok(config) => Plan::new(config).expect_err(text).to_string(),
            Err(error) => error.to_string(),
        };
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    };
    refused("surface.hurst = [0.5, 0.8, 0.5]", &["surface.hurst is [0.5, 0.8, 0.5]", "different"]);
    refused("surface.hurst = [nan]", &["surface.hurst", "NaN"]);
    refused("surface.rms_gradient = nan", &["surface.rms_gradient is NaN", "1e100"]);
    refused("loads.p_star = [0.02, nan]", &["loads.p_star", "NaN"]);
    refused("loads.p_star = [0.02, 0.02]", &["loads.p_star", "ascending"]);
    refused("points.eps_c_inv = [nan]", &["points", "eps_c", "NaN"]);
    refused("points.largest_n = 2", &["points is empty", "largest_n"]);
    refused("body.young = nan", &["body.young", "NaN"]);
    refused("body.height = \"high\"", &["\"high\"", "a number or \"inf\""]);
    refused("fit.alpha_t = 0.0", &["fit.alpha_t is 0.0", "\"free\"", "\"none\""]);
    refused("fit.alpha_f = nan", &["fit.alpha_f is NaN"]);
    refused("fit.alpha_c = \"loose\"", &["\"loose\"", "a number or \"free\" or \"none\""]);
    refused("fit.alpha_t = \"edge\"", &["fit.alpha_t is \"edge\"", "from 0.01 to 16"]);
    refused("surface.hurst = [0.5, 1.0]", &["fit.alpha_f is \"self-affine\"", "1 - H"]);
    refused("surface.dim = 2", &["fit.alpha_c is \"edge\"", "no perimeter"]);
    refused("fit.p_star = 0.3", &["fit.p_star is 0.3", "loads.p_star"]);
    refused("solver.tolerance = 1e-20", &["solver.tolerance is 1e-20", "between 1e-15 and 0.1"]);
    refused("solver.method = \"newton\"", &["solver.method is \"newton\"", "auto, cg"]);
    refused("solver.method = \"magic\"", &["magic", "auto, cg"]);
    // Smaller cells have more realisations; here their seeds would overlap with the seeds of the next group.
    refused("statistics.realisations = 600000", &["statistics.realisations is 600000", "1000000"]);
    refused("statistics.seed = 9223372036854775807", &["statistics.seed is 9223372036854775807", "at most"]);
}

/// Checks that Persson's area, which holds for any number of long waves, stays when composed and extrapolated.
#[test]
fn the_area_of_persson_is_its_own_limit() {
    let fit = FitConfig { alpha_c: Alpha::Without, ..FitConfig::default() };
    let plan = Plan::new(Config { fit, ..plan().config }).unwrap();
    let loads = plan.config.loads.p_star.clone();
    let mut runs = run(&plan, &()).unwrap();
    for (load, &p_star) in runs.iter_mut().flat_map(|run| run.iter_mut().zip(&loads)) {
        (load.summary.kappa, load.summary.kappa_corrected) =
            (persson_area(p_star) / p_star, persson_area(p_star) / p_star);
    }
    let analysis = Analysis::new(&plan, &runs).unwrap();
    assert_eq!(analysis.extrapolations.len(), 2 * loads.len());
    for extrapolation in &analysis.extrapolations {
        let expected = persson_area(extrapolation.p_star) / extrapolation.p_star;
        let found = extrapolation.fit.kappa_tfc.value;
        assert!(extrapolation.composed && (found / expected - 1.0).abs() < 1e-8, "{found} {expected}");
    }
}

/// Checks that long waves lower kappa, and that loads that end too early leave it as it is, with a warning.
#[test]
fn long_waves_are_composed_if_the_loads_allow_it() {
    let composed = Study::new(plan(), &()).unwrap();
    let config = plan().config;
    let low = LoadsConfig { p_star: vec![0.02, 0.05, 0.1, 0.2], ..LoadsConfig::default() };
    let power = Study::new(Plan::new(Config { loads: low, ..config }).unwrap(), &()).unwrap();
    let [with, without] = [&composed, &power].map(|study| study.analysis.result());
    assert!(with.composed && !without.composed);
    for (key, datum) in power.analysis.data.iter().filter(|(key, _)| key.load == 0 && key.area == Area::Raw) {
        let lower = composed.analysis.composed(key.point, 0, &composed.plan).unwrap();
        assert_eq!(composed.analysis.data[key].mean().to_bits(), datum.mean().to_bits());
        assert!(lower.mean() < datum.mean() && lower.kappa.keys().eq(datum.kappa.keys()));
    }
    assert!(power.analysis.composed(0, 0, &power.plan).is_none());
    assert!(without.fit.warnings.contains(&Warning::PowerOfEpsF) && !with.fit.warnings.contains(&Warning::PowerOfEpsF));
}

#[test]
fn surfaces_are_added_until_the_target_is_met_and_the_numbers_are_those_of_a_plan_that_has_them() {
    // Here the model holds. With fewer waves its misfit, which no number of surfaces lowers, widens the interval.
    let points = PointsConfig { eps_f_inv: vec![8.0, 16.0], centre: [2.0, 8.0, 4.0], ..plan().config.points };
    let config = |target: f64, surfaces: Vec<u64>| {
        let statistics = StatisticsConfig { realisations: 4, target, surfaces, ..StatisticsConfig::default() };
        Config { points: points.clone(), statistics, ..plan().config }
    };
    let half_width = |study: &Study| {
        let limit = &study.analysis.result().fit.kappa_tfc;
        let [low, high] = limit.ci95.unwrap();
        0.5 * (high - low) / limit.value
    };
    let first = Study::new(Plan::new(config(0.0, Vec::new())).unwrap(), &()).unwrap();
    let target = 0.6 * half_width(&first);
    let shelf = Shelf { room: usize::MAX, ..Shelf::default() };
    let study = Study::new(Plan::new(config(target, Vec::new())).unwrap(), &shelf).unwrap();
    assert!(half_width(&study) <= target, "{} {target}", half_width(&study));
    assert!(study.runs.len() > first.runs.len());
    // Each surface was computed once, including the surfaces of the first round.
    assert_eq!(shelf.kept.lock().unwrap().len(), study.runs.len());
    for (point, counts) in study.plan.config.statistics.surfaces.iter().enumerate() {
        assert!(*counts >= first.plan.runs_of(point).len() as u64);
        assert_eq!(*counts, study.plan.runs_of(point).len() as u64);
    }
    // The configuration of the result, and kept runs, lead to the same result.
    let again = Study::new(Plan::new(study.plan.config.clone()).unwrap(), &()).unwrap();
    assert_eq!((&again.runs, &again.analysis.result().fit), (&study.runs, &study.analysis.result().fit));
    let resumed = Study::new(Plan::new(config(target, Vec::new())).unwrap(), &shelf).unwrap();
    assert_eq!(resumed.runs, study.runs);
}

#[test]
fn a_target_or_numbers_of_surfaces_that_cannot_be_are_refused() {
    let with =
        |statistics: StatisticsConfig| Plan::new(Config { statistics, ..plan().config }).unwrap_err().to_string();
    let base = StatisticsConfig::default();
    for target in [-0.1, 1e-9, 2.0, f64::NAN] {
        let message = with(StatisticsConfig { target, ..base.clone() });
        assert!(message.contains("statistics.target"), "{message}");
    }
    for surfaces in [vec![4; 3], vec![0; 4]] {
        let message = with(StatisticsConfig { surfaces, ..base.clone() });
        assert!(message.contains("statistics.surfaces"), "{message}");
    }
    let message = with(StatisticsConfig { realisations: 2, target: 0.01, ..base });
    assert!(message.contains("statistics.realisations"), "{message}");
}
