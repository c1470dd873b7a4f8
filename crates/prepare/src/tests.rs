//! Values of an independent implementation, `tests/reference.json`, and properties of each step.

use ndarray::{Array2, s};
use serde_json::Value;

use crate::filter::robust_passes;
use crate::*;

/// Returns the k-th number of splitmix64 with this seed, from 0 to 1.
fn uniform(seed: u64, k: u64) -> f64 {
    let mut z = seed.wrapping_add((k + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 * 2.0_f64.powi(-53)
}

/// Returns the sum of twelve uniform numbers less 6, for the p-th point.
fn noise(seed: u64, p: u64) -> f64 {
    (0..12).fold(0.0, |sum, q| sum + uniform(seed, 12 * p + q)) - 6.0
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().map_or_else(Vec::new, |list| list.iter().map(|x| x.as_f64().unwrap()).collect())
}

fn lists(value: &Value) -> Vec<Vec<f64>> {
    value.as_array().map_or_else(Vec::new, |list| list.iter().map(numbers).collect())
}

fn box_of(range: &[f64]) -> [std::ops::Range<usize>; 2] {
    [range[0] as usize..range[1] as usize, range[2] as usize..range[3] as usize]
}

/// Builds the heights of a case.
fn heights(input: &Value) -> (Array2<f64>, [f64; 2]) {
    let [nx, ny] = [0, 1].map(|axis| input["n"][axis].as_u64().unwrap() as usize);
    let spacing = match input["spacing"].as_f64() {
        Some(spacing) => [spacing; 2],
        None => [input["length"][0].as_f64().unwrap() / nx as f64, input["length"][1].as_f64().unwrap() / ny as f64],
    };
    let (waves, powers) = (lists(&input["waves"]), lists(&input["polynomial"]));
    let seeded =
        input["noise"].as_object().map(|noise| (noise["seed"].as_u64().unwrap(), noise["amplitude"].as_f64().unwrap()));
    let step = input["step_at"].as_u64().map(|at| at as usize);
    let mut made = Array2::from_shape_fn((nx, ny), |(i, j)| {
        let (u, v) = (i as f64 / nx as f64, j as f64 / ny as f64);
        let wave = |w: &Vec<f64>| w[0] * (std::f64::consts::TAU * (w[1] * u + w[2] * v) + w[3]).cos();
        let power = |c: &Vec<f64>| c[0] * u.powi(c[1] as i32) * v.powi(c[2] as i32);
        let random = seeded.map_or(0.0, |(seed, amplitude)| amplitude * noise(seed, (i * ny + j) as u64));
        let stepped = step.map_or(0.0, |at| f64::from(u8::from(i >= at)));
        waves.iter().map(wave).sum::<f64>() + powers.iter().map(power).sum::<f64>() + random + stepped
    });
    for part in lists(&input["add"]) {
        let [x, y] = box_of(&part);
        made.slice_mut(s![x, y]).mapv_inplace(|height| height + part[4]);
    }
    for part in lists(&input["undefined"]) {
        let [x, y] = box_of(&part);
        made.slice_mut(s![x, y]).fill(f64::NAN);
    }
    (made, spacing)
}

/// Returns the points that a case leaves out of a fit.
fn excluded(input: &Value, shape: (usize, usize)) -> Array2<bool> {
    let mut excluded = Array2::from_elem(shape, false);
    for part in lists(&input["excluded_from_fit"]) {
        let [x, y] = box_of(&part);
        excluded.slice_mut(s![x, y]).fill(true);
    }
    excluded
}

fn reference() -> Vec<Value> {
    let text = include_str!("../tests/reference.json");
    serde_json::from_str::<Value>(text).unwrap()["cases"].as_array().unwrap().clone()
}

/// Compares heights with the expected values, relative to their range.
fn compare(name: &str, found: &Array2<f64>, expect: &Value, tolerance: f64) {
    let defined = || found.iter().filter(|height| !height.is_nan());
    let (low, high) = defined().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(*h), high.max(*h)));
    let close = |what: &str, found: f64, value: &Value| {
        if let Some(value) = value.as_f64() {
            let error = (found - value).abs() / (high - low);
            assert!(error <= tolerance, "{name}, {what}: {found} instead of {value}");
        }
    };
    for point in lists(&expect["values"]) {
        let at = if point.len() == 3 { [point[0] as usize, point[1] as usize] } else { [point[0] as usize, 0] };
        close(&format!("{at:?}"), found[at], &point[point.len() - 1].into());
    }
    close("lowest", low, &expect["lowest"]);
    close("highest", high, &expect["highest"]);
    let count = defined().count() as f64;
    let mean = defined().sum::<f64>() / count;
    close("mean", mean, &expect["mean"]);
    close("rms", (defined().map(|h| (h - mean).powi(2)).sum::<f64>() / count).sqrt(), &expect["rms_about_mean"]);
    if let Some(undefined) = expect["undefined"].as_u64() {
        assert_eq!((found.len() as f64 - count) as u64, undefined, "{name}");
    }
}

fn degree(operation: &Value) -> usize {
    operation["degree"].as_u64().map_or(1, |degree| degree as usize)
}

fn levelling(text: &str) -> Levelling {
    match text.split(':').collect::<Vec<_>>()[..] {
        ["rows", "mean"] => Levelling::Mean,
        ["rows", "median"] => Levelling::Median,
        ["rows", "difference"] => Levelling::Difference,
        ["rows", "polynomial", degree] => Levelling::Polynomial(degree.parse().unwrap()),
        _ => panic!("{text}"),
    }
}

#[test]
fn all_reference_values_are_met() {
    let mut checked = 0;
    for case in reference() {
        let (name, input, operation, expect) =
            (case["name"].as_str().unwrap(), &case["input"], &case["operation"], &case["expect"]);
        if matches!(name, "equivalent-cut-off" | "uneven-profile") {
            continue;
        }
        let (made, spacing) = heights(input);
        let index = operation["index"].as_f64().unwrap_or_default();
        let edges = match operation["boundary"].as_str() {
            Some("periodic") => Edges::Periodic,
            Some("reflect") => Edges::Reflect,
            _ => Edges::Regression,
        };
        let gaussian = Filter { edges, degree: degree(operation), ..Filter::default() };
        let passes = operation["iterations"].as_u64().or(operation["passes"].as_u64());
        match (operation["filter"].as_str(), operation["level"].as_str()) {
            (Some("s then l"), _) => {
                let [s, l] = ["s", "l"].map(|key| operation[key].as_f64().unwrap());
                let smoothed = smooth(&made, spacing, s, gaussian).unwrap().heights;
                let waviness = smooth(&smoothed, spacing, l, gaussian).unwrap().heights;
                compare(name, &(smoothed - waviness), expect, 1e-9);
            }
            (Some("s"), _) if name == "gaussian-transmission" => {
                let smoothed = smooth(&made, spacing, index, gaussian).unwrap().heights;
                let part = (&smoothed * &made).sum() / (&made * &made).sum();
                assert!((part - expect["amplitude"].as_f64().unwrap()).abs() < 1e-12, "{case}");
            }
            (Some("s"), _) => {
                compare(name, &smooth(&made, spacing, index, gaussian).unwrap().heights, expect, 1e-9);
            }
            (Some("spline"), _) => {
                let kernel = Kernel::Spline { tension: operation["tension"].as_f64().unwrap() };
                let found = smooth(&made, spacing, index, Filter { kernel, ..gaussian }).unwrap();
                compare(name, &found.heights, expect, 1e-9);
            }
            (Some("robust"), _) => {
                let is_guarded = operation["guard"].is_number();
                let found =
                    robust_passes(&made, (spacing, index, degree(operation)), passes.unwrap() as usize, is_guarded);
                compare(name, &found.heights, expect, 1e-9);
                if let Some(rejected) = expect["points_of_weight_0"].as_u64() {
                    assert_eq!(found.rejected as u64, rejected, "{name}");
                }
            }
            (None, Some("polynomial")) => {
                let excluded = excluded(input, made.dim());
                compare(name, &remove_polynomial(&made, degree(operation), Some(&excluded)).unwrap(), expect, 1e-9);
            }
            (None, Some(how)) => {
                let found = level_rows(&made, levelling(how), None).unwrap();
                compare(name, &found.heights, expect, 1e-9);
                for (shift, value) in found.shifts.iter().zip(numbers(&expect["shifts"])) {
                    assert!((shift - value).abs() < 1e-11, "{name}: {shift} instead of {value}");
                }
            }
            _ if name == "crop" => {
                let found = crop(&made, spacing, [7.0..31.0, 9.0..48.0]).unwrap();
                compare(name, &found.heights, expect, 1e-9);
                assert_eq!((found.origin, found.heights.dim()), ([7, 6], (24, 26)));
            }
            _ => {
                let (cleaned, count) = despike(&made, Spikes::default()).unwrap();
                assert_eq!(count as u64, expect["count"].as_u64().unwrap());
                for point in lists(&expect["points"]) {
                    assert!(cleaned[[point[0] as usize, point[1] as usize]].is_nan(), "{point:?}");
                }
            }
        }
        checked += 1;
    }
    assert_eq!(checked, CASES);
}

/// Number of cases with heights.
const CASES: usize = 44;

#[test]
fn cut_offs_of_the_same_gradient_and_curvature_are_those_of_a_quadrature() {
    for case in reference().iter().filter(|case| case["name"] == "equivalent-cut-off") {
        let found = equivalent_cut_off(case["input"]["hurst"].as_f64().unwrap());
        for (found, key) in found.into_iter().zip(["gradient", "curvature"]) {
            let wanted = case["expect"][key].as_f64().unwrap();
            assert!((found / wanted - 1.0).abs() < 1e-9, "{case}: {found}");
        }
    }
}

#[test]
fn an_uneven_profile_becomes_even() {
    let case = reference().into_iter().find(|case| case["name"] == "uneven-profile").unwrap();
    let mut x = vec![0.0];
    (1..60).for_each(|k| x.push(x[k - 1] + 0.5 + uniform(113, k as u64 - 1)));
    let mut pairs: Vec<(f64, f64)> = x.iter().map(|x| (*x, (0.7 * x).sin() + 0.1 * x)).collect();
    pairs.swap(3, 40);
    let (x, z): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
    let (found, spacing) = even(&x, &z, Some(90)).unwrap();
    assert!((spacing - case["expect"]["spacing"].as_f64().unwrap()).abs() < 1e-9);
    for value in lists(&case["expect"]["values"]) {
        assert!((found[value[0] as usize] - value[1]).abs() < 1e-10, "{value:?}");
    }
    for (x, z) in [(vec![0.0, 0.0, 1.0], vec![0.0; 3]), (vec![0.0], vec![0.0]), (vec![0.0, f64::NAN], vec![0.0; 2])] {
        assert!(even(&x, &z, None).is_err());
    }
    assert!(even(&[0.0, 1.0, 2.0, 3.0, 40.0], &[0.0; 5], None).is_err());
}

/// Returns a rough surface of these points.
fn rough(nx: usize, ny: usize) -> Array2<f64> {
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let (x, y) = (i as f64, j as f64);
        (0.31 * x + 0.2 * y).sin() + 0.3 * (0.9 * x - 0.5 * y).cos() + 0.05 * noise(3, (i * ny + j) as u64)
    })
}

fn worst(a: &Array2<f64>, b: &Array2<f64>) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn a_regression_keeps_the_polynomials_of_its_degree_up_to_the_edges() {
    for (nx, ny) in [(40, 30), (60, 1)] {
        let plane = Array2::from_shape_fn((nx, ny), |(i, j)| 1.0 + 0.3 * i as f64 - 0.2 * j as f64);
        let bowl = Array2::from_shape_fn((nx, ny), |(i, j)| {
            let (x, y) = (i as f64 - 10.0, j as f64);
            0.02 * x * x - 0.01 * y * y + 0.03 * x * y
        });
        let filter = |degree| Filter { degree, ..Filter::default() };
        let smoothed =
            |heights: &Array2<f64>, degree| smooth(heights, [1.0, 1.5], 9.0, filter(degree)).unwrap().heights;
        assert!(worst(&smoothed(&plane, 1), &plane) < 1e-11);
        assert!(worst(&smoothed(&(&plane + &bowl), 2), &(&plane + &bowl)) < 1e-10);
        assert!(worst(&smoothed(&plane, 0), &plane) > 0.1, "the normalised kernel moves a plane at the edges");
        let mut holed = plane.clone();
        holed.slice_mut(s![5..9, ..]).fill(f64::NAN);
        assert!(worst(&smoothed(&holed, 1), &plane) < 1e-11, "values between defined points");
    }
}

#[test]
fn long_kernels_give_what_short_ones_give() {
    let heights = rough(230, 7);
    let found = smooth(&heights, [1.0, 40.0], 80.0, Filter::default()).unwrap().heights;
    let turned = heights.t().as_standard_layout().into_owned();
    let other = smooth(&turned, [40.0, 1.0], 80.0, Filter::default()).unwrap().heights;
    assert!(worst(&found, &other.t().to_owned()) < 1e-12);
    let line = rough(700, 1);
    let by_transform = smooth(&line, [1.0, 1.0], 50.0, Filter { degree: 0, ..Filter::default() }).unwrap().heights;
    let width = (std::f64::consts::LN_2 / std::f64::consts::PI).sqrt() * 50.0;
    let weight = |d: f64| (-std::f64::consts::PI * (d / width).powi(2)).exp();
    for i in [0, 20, 350, 699] {
        let (sum, whole) = line.iter().enumerate().fold((0.0, 0.0), |(sum, whole), (k, z)| {
            let weight = weight(k as f64 - i as f64);
            (sum + weight * z, whole + weight)
        });
        assert!((by_transform[[i, 0]] - sum / whole).abs() < 1e-13, "{i}");
    }
}

#[test]
fn reflected_edges_are_those_of_the_mirrored_surface() {
    let heights = rough(21, 16);
    let mirrored = Array2::from_shape_fn((42, 32), |(i, j)| heights[[i.min(41 - i), j.min(31 - j)]]);
    let edges = |edges| Filter { edges, ..Filter::default() };
    let reflected = smooth(&heights, [1.0, 1.0], 7.0, edges(Edges::Reflect)).unwrap().heights;
    let periodic = smooth(&mirrored, [1.0, 1.0], 7.0, edges(Edges::Periodic)).unwrap().heights;
    assert!(worst(&reflected, &periodic.slice(s![..21, ..16]).to_owned()) < 1e-13);
}

#[test]
fn a_spline_of_tension_one_keeps_lines_and_crosses_holes() {
    let line = Array2::from_shape_fn((80, 1), |(i, _)| 2.0 - 0.3 * i as f64);
    let mut holed = line.clone();
    holed.slice_mut(s![30..37, ..]).fill(f64::NAN);
    let filter = Filter { kernel: Kernel::Spline { tension: 1.0 }, ..Filter::default() };
    assert!(worst(&smooth(&holed, [0.5, 1.0], 9.0, filter).unwrap().heights, &line) < 1e-9);
    // Half of the amplitude stays at the nesting index.
    let wave = Array2::from_shape_fn((96, 1), |(i, _)| (std::f64::consts::TAU * i as f64 / 16.0).cos());
    for tension in [0.0, 0.625242, 1.0] {
        let filter = Filter { kernel: Kernel::Spline { tension }, edges: Edges::Periodic, degree: 1 };
        let found = smooth(&wave, [1.0, 1.0], 16.0, filter).unwrap().heights;
        assert!(worst(&found, &(&wave * 0.5)) < 1e-13, "{tension}");
    }
}

#[test]
fn a_robust_filter_ignores_spikes_and_settles() {
    let smooth_part = Array2::from_shape_fn((48, 40), |(i, j)| (0.13 * i as f64 + 0.15 * j as f64).cos());
    let mut heights = &smooth_part + &Array2::from_shape_fn((48, 40), |(i, j)| 0.02 * noise(9, (i * 40 + j) as u64));
    for (i, j) in [(10, 10), (30, 20), (31, 20), (45, 3)] {
        heights[[i, j]] += 4.0;
    }
    let filter = Filter { kernel: Kernel::Robust, degree: 2, ..Filter::default() };
    let found = smooth(&heights, [1.0, 1.0], 10.0, filter).unwrap();
    assert!(found.is_settled, "{} passes", found.passes);
    assert!((4..20).contains(&found.rejected), "{} rejected", found.rejected);
    assert!(worst(&found.heights, &smooth_part) < 0.1);
    let plain = smooth(&heights, [1.0, 1.0], 10.0, Filter { degree: 2, ..Filter::default() }).unwrap();
    assert!(worst(&plain.heights, &smooth_part) > 0.2);
    // A flat surface has no residuals.
    let flat = smooth(&Array2::zeros((20, 20)), [1.0, 1.0], 6.0, filter).unwrap();
    assert!(flat.heights.iter().all(|height| height.abs() < 1e-15));
}

#[test]
fn scars_are_found_and_the_surface_stays() {
    let clean = Array2::from_shape_fn((64, 48), |(i, j)| 0.2 * (0.2 * i as f64).sin() + 0.1 * (0.25 * j as f64).cos());
    assert_eq!(descar(&clean, Scars::default()).unwrap(), (clean.clone(), 0));
    let mut scarred = clean.clone();
    scarred.slice_mut(s![12..42, 20]).mapv_inplace(|height| height + 2.0);
    scarred.slice_mut(s![30..50, 33..35]).mapv_inplace(|height| height - 2.0);
    scarred.slice_mut(s![5..9, 40]).mapv_inplace(|height| height + 2.0);
    let (cleaned, count) = descar(&scarred, Scars::default()).unwrap();
    assert_eq!(count, 30 + 40, "the short one stays");
    assert!(cleaned.slice(s![12..42, 20]).iter().all(|height| height.is_nan()));
    assert!(!cleaned[[6, 40]].is_nan());
}

#[test]
fn fewer_points_keep_long_waves_and_lose_short_ones() {
    let size = 96.0;
    let at = |n: usize, centred: f64, waves: f64| {
        Array2::from_shape_fn((n, n), |(i, j)| {
            let x = |i: usize| (i as f64 + centred) / n as f64 * std::f64::consts::TAU * waves;
            x(i).sin() * x(j).cos()
        })
    };
    for (edges, centred) in [(Edges::Periodic, 0.0), (Edges::Regression, 0.5)] {
        let filter = Filter { edges, ..Filter::default() };
        let found = resample(&at(96, centred, 1.0), [size / 96.0; 2], [48, 32], filter).unwrap();
        assert_eq!((found.heights.dim(), found.index), ((48, 32), 12.0));
        let wanted = Array2::from_shape_fn((48, 32), |(i, j)| {
            let place = |i: usize, n: f64| (i as f64 + centred) / n * std::f64::consts::TAU;
            place(i, 48.0).sin() * place(j, 32.0).cos()
        });
        assert!(worst(&found.heights, &wanted) < 0.07, "{edges:?}");
        // A wave that the new grid cannot show would fold into a long one.
        let folded = resample(&at(96, 0.0, 30.0), [size / 96.0; 2], [32, 32], filter).unwrap().heights;
        let middle = folded.slice(s![4..28, 4..28]);
        assert!(middle.iter().all(|height| height.abs() < 1e-3), "{edges:?}");
    }
    assert!(resample(&at(20, 0.0, 1.0), [1.0; 2], [21, 20], Filter::default()).is_err());
}

#[test]
fn columns_are_rows_of_the_turned_surface() {
    let heights = rough(30, 22);
    for how in [Levelling::Mean, Levelling::Median, Levelling::Difference, Levelling::Polynomial(2)] {
        let columns = level_columns(&heights, how, None).unwrap().heights;
        let rows = level_rows(&heights.t().to_owned(), how, None).unwrap().heights;
        assert!(worst(&columns, &rows.t().to_owned()) == 0.0);
    }
}

#[test]
fn excluded_points_do_not_change_a_fit() {
    let plane = Array2::from_shape_fn((30, 20), |(i, j)| 0.1 * i as f64 - 0.3 * j as f64);
    let mut bumped = plane.clone();
    bumped.slice_mut(s![4..12, 5..15]).mapv_inplace(|height| height + 3.0);
    let mut excluded = Array2::from_elem((30, 20), false);
    excluded.slice_mut(s![4..12, 5..15]).fill(true);
    let rest = remove_polynomial(&bumped, 1, Some(&excluded)).unwrap();
    assert!((rest[[5, 6]] - 3.0).abs() < 1e-12);
    assert!(rest[[20, 3]].abs() < 1e-12);
    let levelled = level_rows(&bumped, Levelling::Polynomial(1), Some(&excluded)).unwrap().heights;
    assert!((levelled[[5, 6]] - 3.0).abs() < 1e-12);
    let all = Array2::from_elem((30, 20), true);
    assert!(remove_polynomial(&bumped, 1, Some(&all)).is_err());
    assert!(level_rows(&bumped, Levelling::Mean, Some(&all)).is_err());
}

#[test]
fn what_cannot_be_prepared_is_refused() {
    let heights = rough(40, 30);
    let line = rough(40, 1);
    let filtered = |heights: &Array2<f64>, index, filter| smooth(heights, [1.0, 1.0], index, filter).is_err();
    let with = |kernel, edges, degree| Filter { kernel, edges, degree };
    for index in [1.9, 30.1, 0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(filtered(&heights, index, Filter::default()), "{index}");
    }
    let spline = Kernel::Spline { tension: 1.0 };
    for (heights, filter) in [
        (&heights, with(Kernel::Gaussian, Edges::Regression, 3)),
        (&heights, with(Kernel::Gaussian, Edges::Periodic, 2)),
        (&heights, with(Kernel::Robust, Edges::Periodic, 1)),
        (&heights, with(spline, Edges::Regression, 1)),
        (&line, with(spline, Edges::Reflect, 1)),
        (&line, with(Kernel::Spline { tension: 1.1 }, Edges::Regression, 1)),
    ] {
        assert!(filtered(heights, 8.0, filter), "{filter:?}");
    }
    let mut holed = heights.clone();
    holed[[3, 3]] = f64::NAN;
    assert!(filtered(&holed, 8.0, with(Kernel::Gaussian, Edges::Reflect, 1)));
    for range in [3.0..2.0, -1.0..5.0, 3.0..41.0, 3.0..4.0, f64::NAN..5.0, 3.0..f64::NAN] {
        assert!(crop(&heights, [1.0, 1.0], [range.clone(), 0.0..30.0]).is_err(), "{range:?}");
    }
    for spikes in [(0.0, 5), (f64::NAN, 5), (5.0, 4), (5.0, 1), (5.0, 101)] {
        assert!(despike(&heights, Spikes { threshold: spikes.0, window: spikes.1 }).is_err(), "{spikes:?}");
    }
    assert!(matches!(despike(&heights, Spikes { threshold: 0.3, window: 5 }), Err(PrepareError::TooManySpikes { .. })));
    for scars in [
        Scars { low: 0.0, ..Scars::default() },
        Scars { high: 0.1, ..Scars::default() },
        Scars { length: 0, ..Scars::default() },
        Scars { width: 0, ..Scars::default() },
    ] {
        assert!(descar(&heights, scars).is_err(), "{scars:?}");
    }
    assert!(descar(&line, Scars::default()).is_err());
    assert!(level_rows(&line, Levelling::Mean, None).is_err());
    assert!(level_columns(&line, Levelling::Mean, None).is_err());
    assert!(level_rows(&heights, Levelling::Polynomial(9), None).is_err());
    assert!(remove_polynomial(&heights, 9, None).is_err());
    assert!(remove_polynomial(&rough(4, 3), 4, None).is_err());
    assert!(remove_polynomial(&Array2::from_elem((9, 9), f64::NAN), 1, None).is_err());
}
