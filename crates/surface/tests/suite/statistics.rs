//! Measured statistics against closed forms: single waves, the discretisation table, moments, slopes, cuts.

use std::f64::consts::{PI, TAU};

use approx::assert_relative_eq;
use gfmd_field::Grid;
use gfmd_surface::{
    Amplitudes, Dimension, Normalisation, PowerSpectrum, RollOff, RollOffShape, SelfAffine, Statistics, SurfaceError,
};
use ndarray::{Array2, ShapeBuilder};

/// Returns the ring of a cell of side 1 with `longest` and `shortest` as wave numbers, without noise.
fn self_affine(hurst: f64, longest: f64, shortest: f64, rms_gradient: f64) -> SelfAffine {
    SelfAffine {
        hurst,
        longest_wavelength: longest,
        shortest_wavelength: shortest,
        ..SelfAffine::with_rms_gradient(rms_gradient)
    }
}

fn plateau(wavelength: f64) -> Option<RollOff> {
    Some(RollOff { wavelength, shape: RollOffShape::Plateau })
}

fn smooth(wavelength: f64) -> Option<RollOff> {
    Some(RollOff { wavelength, shape: RollOffShape::Smooth })
}

fn quiet(hurst: f64, longest: f64, shortest: f64) -> SelfAffine {
    SelfAffine { amplitudes: Amplitudes::Fixed, ..self_affine(hurst, 1.0 / longest, 1.0 / shortest, 0.1) }
}

fn square(points: usize) -> Grid {
    Grid::square(points, 1.0).unwrap()
}

#[test]
fn one_oblique_wave_on_an_unequal_grid() {
    let (grid, amplitude, offset) = (Grid::new([24, 35], [2.0, 3.5]).unwrap(), 0.013, 4.0);
    let q = [TAU * 3.0 / 2.0, TAU * 2.0 / 3.5];
    let [a, b] = grid.spacing();
    let wave = |(i, j): (usize, usize)| offset + amplitude * (q[0] * i as f64 * a + q[1] * j as f64 * b + 0.4).cos();
    let heights = Array2::from_shape_fn((24, 35), wave);
    let found = Statistics::of(&heights, &grid).unwrap();
    let (rms, q2) = (amplitude / 2.0_f64.sqrt(), q[0] * q[0] + q[1] * q[1]);
    assert_relative_eq!(found.mean, offset, max_relative = 1e-14);
    assert_relative_eq!(found.moments.rms_height(), rms, max_relative = 1e-12);
    assert_relative_eq!(found.moments.rms_gradient(), rms * q2.sqrt(), max_relative = 1e-12);
    assert_relative_eq!(found.moments.rms_curvature(), 0.5 * rms * q2, max_relative = 1e-11);
    assert_relative_eq!(found.moments.nayak().unwrap(), 1.5, max_relative = 1e-11);
    let central = ((q[0] * a).sin() / a).hypot((q[1] * b).sin() / b);
    let forward = (2.0 * (0.5 * q[0] * a).sin() / a).hypot(2.0 * (0.5 * q[1] * b).sin() / b);
    assert_relative_eq!(found.rms_gradient_central, rms * central, max_relative = 1e-12);
    assert_relative_eq!(found.rms_gradient_forward, rms * forward, max_relative = 1e-12);
    assert!(found.peak_to_valley() <= 2.0 * amplitude && found.peak_to_valley() > 1.95 * amplitude);
    let column_major = Array2::from_shape_fn((24, 35).f(), wave);
    assert_eq!(Statistics::of(&column_major, &grid).unwrap(), found);
}

#[test]
fn a_profile_has_the_moments_of_its_own_derivatives() {
    let grid = Grid::line(50, 2.0).unwrap();
    let q = TAU * 4.0 / 2.0;
    let heights = Array2::from_shape_fn((50, 1), |(i, _)| 0.3 * (q * i as f64 * 0.04).sin());
    let moments = Statistics::of(&heights, &grid).unwrap().moments;
    assert_eq!(moments.dimension, Dimension::Profile);
    assert_relative_eq!(moments.rms_gradient(), 0.3 * q / 2.0_f64.sqrt(), max_relative = 1e-12);
    assert_relative_eq!(moments.rms_curvature(), 0.3 * q * q / 2.0_f64.sqrt(), max_relative = 1e-11);
    assert_relative_eq!(moments.nayak().unwrap(), 1.0, max_relative = 1e-11);
}

/// The table of theory.md, section 9: rms finite-difference gradient divided by the spectral one, at 1/ε_c = 2, 4, 8,
/// 16; for H = 0.8 it depends on λ_l/λ_s, which is 64 here.
#[test]
fn finite_differences_lose_what_the_table_says() {
    let table = [
        (0.0, [[0.597, 0.861], [0.861, 0.962], [0.962, 0.990], [0.990, 0.998]]),
        (0.8, [[0.837, 0.944], [0.944, 0.985], [0.985, 0.996], [0.996, 0.999]]),
    ];
    for (hurst, rows) in table {
        for (row, eps_c_inv) in rows.into_iter().zip([2, 4, 8, 16]) {
            let points = 128 * eps_c_inv;
            let heights = quiet(hurst, 2.0, 128.0).heights(&square(points), 1).unwrap();
            let found = Statistics::of(&heights, &square(points)).unwrap();
            let ratio =
                [found.rms_gradient_central, found.rms_gradient_forward].map(|g| g / found.moments.rms_gradient());
            for (ratio, expected) in ratio.into_iter().zip(row) {
                assert!((ratio - expected).abs() < 2e-3, "H = {hurst}, 1/eps_c = {eps_c_inv}: {ratio} for {expected}");
            }
        }
    }
}

#[test]
fn finite_difference_gradients_converge_with_the_second_power_of_the_spacing() {
    let error = |points| {
        let found =
            Statistics::of(&quiet(0.5, 2.0, 8.0).heights(&square(points), 3).unwrap(), &square(points)).unwrap();
        [found.rms_gradient_central, found.rms_gradient_forward].map(|g| found.moments.rms_gradient() - g)
    };
    let (coarse, fine) = (error(256), error(512));
    for (coarse, fine) in coarse.into_iter().zip(fine) {
        let order = (coarse / fine).log2();
        assert!((order - 2.0).abs() < 0.01, "observed order {order}");
    }
}

#[test]
fn discrete_sums_equal_the_reference() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/reference/spectrum_sums.json");
    let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let rows = json["rows"].as_array().unwrap();
    assert_eq!(rows.len(), 4);
    for row in rows {
        let row: Vec<f64> = row.as_array().unwrap().iter().map(|value| value.as_f64().unwrap()).collect();
        let [n, nl, ns, hurst, modes, s0, s2, s4, height, central, forward] = row[..] else {
            panic!("columns: {row:?}")
        };
        let grid = Grid::square(n as usize, TAU).unwrap(); // q = k
        let surface = SelfAffine {
            normalisation: Normalisation::RmsHeight(s0.sqrt()),
            amplitudes: Amplitudes::Fixed,
            ..self_affine(hurst, TAU / nl, TAU / ns, 1.0)
        };
        let spectrum = surface.spectrum(&grid, 1).unwrap();
        let count: f64 = grid.modes().zip(&spectrum).filter(|(_, h)| h.norm() > 0.0).map(|(mode, _)| mode.weight).sum();
        assert_eq!(count, modes);
        let expected = surface.expected_moments(&grid).unwrap();
        let found = Statistics::of(&surface.heights(&grid, 1).unwrap(), &grid).unwrap();
        for moments in [expected, found.moments] {
            assert_relative_eq!(moments.mean_square_height, s0, max_relative = 1e-12);
            assert_relative_eq!(moments.mean_square_gradient, s2, max_relative = 1e-12);
            assert_relative_eq!(moments.mean_square_laplacian, s4, max_relative = 1e-12);
            assert_relative_eq!(
                moments.rms_height() / moments.rms_gradient(),
                height * TAU / TAU,
                max_relative = 1e-12
            );
        }
        let gradient = found.moments.rms_gradient();
        assert_relative_eq!(found.rms_gradient_central / gradient, central, max_relative = 1e-12);
        assert_relative_eq!(found.rms_gradient_forward / gradient, forward, max_relative = 1e-12);
    }
}

/// Sums over the ring tend to the integrals of theory.md, section 9, as more modes fill it (1/ε_t grows).
#[test]
fn moments_tend_to_the_integrals_over_the_continuous_spectrum() {
    let integral = |low: f64, high: f64, power: f64| {
        // ∫ q^{power − 1} dq
        if power.abs() < 1e-12 { (high / low).ln() } else { (high.powf(power) - low.powf(power)) / power }
    };
    for hurst in [0.0, 0.3, 0.8, 1.0] {
        let mut errors = Vec::new();
        for (points, eps_t_inv) in [(256, 4.0), (1024, 16.0)] {
            let (low, high) = (TAU * eps_t_inv, TAU * eps_t_inv * 16.0);
            let [height, gradient, laplacian] = [0.0, 2.0, 4.0].map(|k| integral(low, high, k - 2.0 * hurst));
            let found = quiet(hurst, eps_t_inv, eps_t_inv * 16.0).expected_moments(&square(points)).unwrap();
            let nayak = 1.5 * height * laplacian / gradient.powi(2);
            errors.push([
                found.rms_height() / found.rms_gradient() / (height / gradient).sqrt() - 1.0,
                found.nayak().unwrap() / nayak - 1.0,
            ]);
        }
        for k in 0..2 {
            assert!(errors[0][k].abs() < 0.08 && errors[1][k].abs() < 0.01, "H = {hurst}: {errors:?}");
        }
    }
}

/// C1D(q) of straight cuts is the integral of C2D over the other component (theory.md, section 9). For H = 0, 1/2, 1 it
/// is elementary, for H = 0 with the finite ring: (2 C0/q) arctan(√(q_s² − q²)/q).
#[test]
fn a_cut_of_a_surface_has_the_spectrum_of_a_profile() {
    let (points, waves) = (768, 384.0);
    for hurst in [0.0, 0.5, 1.0] {
        let heights = quiet(hurst, 1.0, waves).heights(&square(points), 2).unwrap();
        let surface = PowerSpectrum::of(&heights, &square(points)).unwrap();
        let some = surface.radial()[20];
        let first = square(points).mode(0, 20);
        let c0 = surface.power()[20] / (TAU * TAU) * first.wavenumber().powf(2.0 + 2.0 * hurst);
        assert_relative_eq!(some.density, c0 * some.wavenumber.powf(-2.0 - 2.0 * hurst), max_relative = 0.01);
        let line = Grid::line(points, 1.0).unwrap();
        let mut cuts = vec![0.0; line.spectrum_len()];
        for column in heights.columns() {
            let cut = column.to_owned().into_shape_with_order((points, 1)).unwrap();
            let cut = PowerSpectrum::of(&cut, &line).unwrap();
            cuts.iter_mut().zip(cut.power()).for_each(|(sum, power)| *sum += power / points as f64);
        }
        for (number, cut) in cuts.iter().enumerate().take(16).skip(4) {
            let (q, high) = (TAU * number as f64, TAU * waves);
            let expected = match hurst {
                0.0 => 2.0 * c0 / q * ((high * high - q * q).sqrt() / q).atan(),
                0.5 => 2.0 * c0 * q.powi(-2),
                _ => 0.5 * PI * c0 * q.powi(-3),
            };
            assert_relative_eq!(cut / TAU, expected, max_relative = 2e-3);
        }
    }
}

#[test]
fn the_fit_finds_the_exponent_of_a_spectrum_without_noise() {
    for hurst in [0.0, 0.37, 1.0] {
        let lines = Grid::line(256, 1.0).unwrap();
        for grid in [square(128), Grid::new([128, 160], [1.0, 0.8]).unwrap(), lines] {
            let surface = SelfAffine { roll_off: plateau(1.0 / 8.0), ..quiet(hurst, 1.0, 60.0) };
            let spectrum = PowerSpectrum::of(&surface.heights(&grid, 6).unwrap(), &grid).unwrap();
            let steep = spectrum.fit_hurst(1.0 / 8.0, 1.0 / 60.0).unwrap().hurst;
            assert!((steep - hurst).abs() < 1e-9, "{steep} for {hurst}");
            let flat = spectrum.fit_hurst(1.0, 1.0 / 8.0).unwrap().hurst;
            let plateau = if grid.is_line() { -0.5 } else { -1.0 };
            assert!((flat - plateau).abs() < 1e-9, "{flat} for {plateau}");
        }
    }
}

/// The fit of noisy surfaces is unbiased and scatters by its stated standard error.
#[test]
fn the_fit_scatters_by_its_standard_error() {
    for (grid, waves) in [(square(64), 32.0), (Grid::line(512, 1.0).unwrap(), 200.0)] {
        let surface = SelfAffine { amplitudes: Amplitudes::Gaussian, ..quiet(0.6, 2.0, waves) };
        let seeds = 400;
        let scores: Vec<f64> = (0..seeds)
            .map(|seed| {
                let spectrum = PowerSpectrum::of(&surface.heights(&grid, seed).unwrap(), &grid).unwrap();
                let fit = spectrum.fit_hurst(1.0 / 2.0, 1.0 / waves).unwrap();
                (fit.hurst - 0.6) / fit.standard_error
            })
            .collect();
        let mean = scores.iter().sum::<f64>() / seeds as f64;
        let variance = scores.iter().map(|score| (score - mean).powi(2)).sum::<f64>() / seeds as f64;
        // Four standard errors of a mean and of a variance of 400 normal numbers, and the bias of small samples.
        assert!(mean.abs() < 0.25, "{mean}");
        assert!((variance - 1.0).abs() < 0.3, "{variance}");
    }
}

#[test]
fn a_smooth_roll_off_bends_the_spectrum_as_its_formula() {
    for grid in [square(64), Grid::line(64, 1.0).unwrap()] {
        let surface = SelfAffine { roll_off: smooth(1.0 / 6.0), ..quiet(0.7, 1.0, 30.0) };
        let found = PowerSpectrum::of(&surface.heights(&grid, 1).unwrap(), &grid).unwrap();
        let exponent = if grid.is_line() { 1.2 } else { 1.7 };
        let shape = |k: f64| (1.0 + (k / 6.0).powi(2)).powf(-exponent);
        for k in [1, 3, 6, 20, 29] {
            assert_relative_eq!(found.power()[k] / found.power()[2], shape(k as f64) / shape(2.0), max_relative = 1e-9);
        }
    }
}

/// Sides of 1 and 0.75: the waves (2, 0) and (6, 0) are half-way between two rings, in the upper one for every unit.
#[test]
fn a_wave_half_way_between_two_rings_is_in_the_upper_one() {
    for unit in [1.0, 0.1, 3.7, 1e-6, 0.986_041] {
        let grid = Grid::new([32, 24], [unit, 0.75 * unit]).unwrap();
        let heights =
            Array2::from_shape_fn((32, 24), |(i, j)| ((7 * i + 5 * j) % 11) as f64 + ((3 * i * j) % 7) as f64);
        let bins = PowerSpectrum::of(&heights, &grid).unwrap().radial();
        // The wave number divided by the wave number of the side 0.75 is √((3 m)² + (4 n)²)/4.
        let expected = (1..=12).map(|ring| {
            let waves = (-15..=16).flat_map(|m| (-11..=12).map(move |n| 9 * m * m + 16 * n * n));
            waves.filter(|square| (4 * ring - 2_i32).pow(2) <= *square && *square < (4 * ring + 2_i32).pow(2)).count()
        });
        let expected: Vec<f64> = expected.map(|count| count as f64).collect();
        assert_eq!(bins.iter().map(|bin| bin.modes).collect::<Vec<f64>>(), expected, "{unit}");
    }
}

#[test]
fn the_radial_spectrum_is_isotropic_and_keeps_the_variance() {
    let grid = Grid::new([96, 96], [1.0, 1.0]).unwrap();
    let heights = quiet(0.5, 2.0, 40.0).heights(&grid, 4).unwrap();
    let spectrum = PowerSpectrum::of(&heights, &grid).unwrap();
    let bins = spectrum.radial();
    let variance: f64 = bins.iter().map(|bin| bin.modes * bin.density * TAU * TAU).sum();
    assert_relative_eq!(variance, spectrum.moments().mean_square_height, max_relative = 1e-12);
    for (k, bin) in bins.iter().enumerate() {
        assert!((bin.wavenumber / TAU - (k + 1) as f64).abs() < 0.25, "ring {k}: {bin:?}");
    }
    // All directions have the same function of |q|.
    for (mode, power) in grid.modes().zip(spectrum.power()) {
        let k = mode.wavenumber() / TAU;
        if (2.5..39.5).contains(&k) {
            assert_relative_eq!(power * k.powi(3), spectrum.power()[3] * 27.0, max_relative = 1e-9);
        }
    }
}

/// With Gaussian amplitudes ⟨h_x²⟩ = ⟨h_y²⟩ and ⟨h_x h_y⟩ = 0 over many seeds, in a cell of unequal sides and spacings.
#[test]
fn gradients_have_no_preferred_direction() {
    let grid = Grid::new([96, 40], [1.5, 1.0]).unwrap();
    let surface = SelfAffine { amplitudes: Amplitudes::Gaussian, ..quiet(0.8, 8.0, 19.0) };
    let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
    for seed in 0..300 {
        for (mode, h) in grid.modes().zip(surface.spectrum(&grid, seed).unwrap()) {
            let ([x, y], square) = (mode.wavevector, mode.weight * h.norm_sqr());
            (xx, yy, xy) = (xx + x * x * square, yy + y * y * square, xy + x * y * square);
        }
    }
    assert_relative_eq!(xx / yy, 1.0, max_relative = 0.02);
    assert!((xy / xx).abs() < 0.01, "{}", xy / xx);
}

#[test]
fn realised_cut_offs_are_those_asked_for_even_in_single_precision() {
    for (grid, waves) in [(square(160), 70.0), (Grid::line(32768, 1.0).unwrap(), 15000.0)] {
        let heights = quiet(1.0, 2.0, waves).heights(&grid, 8).unwrap();
        for heights in [heights.clone(), heights.mapv(|h| f64::from(h as f32))] {
            let [longest, shortest] = PowerSpectrum::of(&heights, &grid).unwrap().cut_offs().unwrap();
            assert_relative_eq!(longest, 0.5, max_relative = 1e-12);
            assert_relative_eq!(shortest, 1.0 / waves, max_relative = 1e-12);
        }
    }
    let flat = Array2::from_elem((8, 8), 2.0);
    assert_eq!(PowerSpectrum::of(&flat, &square(8)).unwrap().cut_offs(), None);
    assert_eq!(Statistics::of(&flat, &square(8)).unwrap().moments.nayak(), None);
}

#[test]
fn a_seam_shows_where_opposite_edges_do_not_meet() {
    let grid = Grid::new([20, 30], [2.0, 3.0]).unwrap();
    let ramp = Array2::from_shape_fn((20, 30), |(i, _)| 0.5 * i as f64);
    let found = Statistics::of(&ramp, &grid).unwrap();
    assert_relative_eq!(found.seam.ratio()[0].unwrap(), 19.0, max_relative = 1e-13);
    assert_eq!(found.seam.ratio()[1], None);
    assert_relative_eq!(found.rms_gradient_inside, 5.0, max_relative = 1e-13);
    assert!(found.rms_gradient_forward > 20.0);
    assert!(found.mean_square_laplacian_inside.unwrap() < 1e-20 && found.moments.mean_square_laplacian > 1e3);
    let wave = self_affine(0.8, 1.0, 0.3, 0.1).heights(&grid, 3).unwrap();
    for ratio in Statistics::of(&wave, &grid).unwrap().seam.ratio() {
        assert!((0.5..2.0).contains(&ratio.unwrap()), "{ratio:?}");
    }
}

#[test]
fn a_cap_that_does_not_repeat_has_the_curvature_of_its_points_inside() {
    // z = -x²/2a - y²/2b: h_xx = -1/a, h_yy = -1/b at every point, regardless of the seam.
    let radii = [2.0, 5.0];
    for (points, lengths) in
        [([16, 16], [1.0, 1.0]), ([64, 40], [1.0, 3.0]), ([3, 3], [0.2, 0.1]), ([50, 1], [2.0, 1.0])]
    {
        let grid = if points[1] == 1 { Grid::line(points[0], lengths[0]) } else { Grid::new(points, lengths) }.unwrap();
        let at = |axis: usize, k: usize| (k as f64 - 0.4 * points[axis] as f64) * grid.spacing()[axis];
        let of_y = |j: usize| if grid.is_line() { 0.0 } else { at(1, j).powi(2) / 2.0 / radii[1] };
        let cap = Array2::from_shape_fn(points, |(i, j)| -at(0, i).powi(2) / 2.0 / radii[0] - of_y(j));
        let found = Statistics::of(&cap, &grid).unwrap();
        let inside = found.moments_inside();
        let laplacian = if grid.is_line() { 0.5 } else { 0.7 };
        assert_relative_eq!(inside.rms_laplacian(), laplacian, max_relative = 1e-10);
        assert_relative_eq!(inside.rms_curvature(), if grid.is_line() { 0.5 } else { 0.35 }, max_relative = 1e-10);
        assert_eq!(inside.rms_gradient(), found.rms_gradient_inside);
        let [m0, m2, m4] = inside.profile();
        assert_eq!(m0, found.moments.mean_square_height);
        assert_relative_eq!(inside.nayak().unwrap(), m0 * m4 / m2.powi(2), max_relative = 1e-14);
        // The seam enters the spectral Laplacian.
        assert!(points[0] == 3 || found.moments.rms_laplacian() > 1.5 * laplacian);
    }
    for points in [[2, 8], [8, 2]] {
        let grid = Grid::new(points, [1.0, 1.0]).unwrap();
        let few = Statistics::of(&Array2::from_shape_fn(points, |(i, j)| (i * j) as f64), &grid).unwrap();
        assert_eq!(few.mean_square_laplacian_inside, None);
    }
    // A wave: the second difference is the exact one times (2 sin(qa/2)/(qa))², up to the points excluded at the seam.
    let (grid, q) = (Grid::line(4000, 1.0).unwrap(), TAU * 20.0);
    let wave = Array2::from_shape_fn((4000, 1), |(i, _)| (q * i as f64 / 4000.0).sin());
    let found = Statistics::of(&wave, &grid).unwrap();
    let reduced = (2.0 * (0.5 * q / 4000.0).sin() * 4000.0 / q).powi(2);
    let ratio = found.moments_inside().rms_laplacian() / found.moments.rms_laplacian();
    assert_relative_eq!(ratio / reduced, 1.0, max_relative = 1e-3);
}

#[test]
fn unusable_heights_are_refused() {
    let mut heights = Array2::zeros((5, 4));
    heights[[3, 1]] = f64::NAN;
    heights[[4, 0]] = f64::INFINITY;
    let grid = Grid::new([5, 4], [1.0, 1.0]).unwrap();
    let message = Statistics::of(&heights, &grid).unwrap_err().to_string();
    assert_eq!(
        message,
        "2 of 20 heights are missing or not finite, the first is NaN at [x, y] = [3, 1]; all must be finite"
    );
    let found = SurfaceError::Shape { found: [5, 4], expected: [4, 5] };
    let turned = Grid::new([4, 5], [1.0, 1.0]).unwrap();
    assert_eq!(Statistics::of(&heights, &turned), Err(found));
    let spectrum = PowerSpectrum::of(&quiet(0.5, 1.0, 4.0).heights(&square(8), 1).unwrap(), &square(8)).unwrap();
    assert!(matches!(spectrum.fit_hurst(0.1, 0.2), Err(SurfaceError::Wavelengths { .. })));
    assert!(matches!(spectrum.fit_hurst(1.0, 0.9), Err(SurfaceError::Fit { found: 1, .. })));
    assert!(matches!(spectrum.fit_hurst(0.95, 0.9), Err(SurfaceError::Fit { found: 0, .. })));
}
