//! Synthesised surfaces: size, symmetry, refinement, independence of threads, bad input.

use approx::assert_relative_eq;
use gfmd_field::{Grid, Transform};
use gfmd_surface::{
    Amplitudes, Anisotropy, Direction, Normalisation, PowerSpectrum, RollOff, RollOffShape, Scaling, SelfAffine,
};
use ndarray::Array2;
use num_complex::Complex64;
use proptest::prelude::*;

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

fn spectrum_of(heights: &Array2<f64>, grid: &Grid) -> Vec<Complex64> {
    let transform = Transform::new(*grid);
    let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
    let flat = heights.as_slice().expect("generated heights are in storage order");
    transform.forward(flat, &mut spectrum, &mut transform.workspace()).unwrap();
    spectrum
}

/// Returns the moment Σ |h̃|² q^power over the full spectrum of the heights.
fn moment(heights: &Array2<f64>, grid: &Grid, power: i32) -> f64 {
    let spectrum = spectrum_of(heights, grid);
    grid.modes().zip(&spectrum).map(|(mode, h)| mode.weight * mode.wavenumber().powi(power) * h.norm_sqr()).sum()
}

#[test]
fn the_size_asked_for_is_the_size_made() {
    for grid in [Grid::square(48, 2.5).unwrap(), Grid::new([45, 64], [2.5, 3.5]).unwrap(), Grid::line(91, 2.5).unwrap()]
    {
        let gradient = self_affine(0.7, 2.0, 0.25, 0.03);
        assert_relative_eq!(moment(&gradient.heights(&grid, 5).unwrap(), &grid, 2).sqrt(), 0.03, max_relative = 1e-12);
        let height = SelfAffine { normalisation: Normalisation::RmsHeight(0.4), ..gradient };
        let heights = height.heights(&grid, 5).unwrap();
        assert_relative_eq!(moment(&heights, &grid, 0).sqrt(), 0.4, max_relative = 1e-12);
        assert_relative_eq!(heights.iter().map(|h| h * h).sum::<f64>() / grid.len() as f64, 0.16, max_relative = 1e-12);
        assert!(heights.mean().unwrap().abs() < 1e-15);
        for roll_off in [plateau(0.8), smooth(0.8)] {
            let rolled = SelfAffine { roll_off, ..height }.heights(&grid, 5).unwrap();
            assert_relative_eq!(moment(&rolled, &grid, 0).sqrt(), 0.4, max_relative = 1e-12);
        }
    }
}

#[test]
fn nothing_lies_outside_the_ring_and_its_edges_lie_inside() {
    let grid = Grid::square(64, 1.0).unwrap();
    // 1/5 and 1/13 are the lengths of (3, 4) and (5, 12): rings with points off the axes, inexact in binary.
    let surface = self_affine(0.3, 1.0 / 5.0, 1.0 / 13.0, 0.1);
    let spectrum = surface.spectrum(&grid, 3).unwrap();
    for (mode, value) in grid.modes().zip(&spectrum) {
        let [m, n] = mode.number;
        assert_eq!((25..=169).contains(&(m * m + n * n)), value.norm() > 0.0, "{:?}", mode.number);
    }
}

/// Lengths given as decimals, quotients and products: the same waves are in the band for any rounding of the lengths.
#[test]
fn waves_of_exactly_the_length_of_a_cut_off_are_in_the_band() {
    for length in [1.0, 0.1, 0.25, 3.7, 1e-7] {
        let grid = Grid::line(64, length).unwrap();
        let of = |longest: f64, shortest: f64, roll_off| {
            let surface = SelfAffine { roll_off, ..self_affine(0.7, longest, shortest, 0.1) };
            let spectrum = surface.spectrum(&grid, 3).unwrap();
            let waves = grid.modes().zip(&spectrum).filter(|(_, value)| value.norm() > 0.0);
            waves.map(|(mode, _)| mode.number[0].unsigned_abs()).collect::<Vec<_>>()
        };
        for most in 1..=30_u32 {
            for least in 1..=most {
                let [longest, shortest] = [least, most].map(|waves| length / f64::from(waves));
                let decimal = |waves: u32| length * (1.0 / f64::from(waves));
                let expected: Vec<u64> = (least..=most).map(u64::from).collect();
                for (longest, shortest) in
                    [(longest, shortest), (decimal(least), decimal(most)), (longest, decimal(most))]
                {
                    for roll_off in
                        [None, plateau(longest), smooth(decimal(least)), plateau(decimal(most)), smooth(shortest)]
                    {
                        assert_eq!(
                            of(longest, shortest, roll_off),
                            expected,
                            "{least} to {most} of {length}, {roll_off:?}"
                        );
                    }
                }
            }
        }
        // Waves that are longer or shorter by a billionth are excluded.
        let (wide, narrow) = (1.0 + 1e-9, 1.0 - 1e-9);
        assert_eq!(of(length / 4.0 * narrow, length / 10.0 * wide, None), [5, 6, 7, 8, 9]);
        assert_eq!(of(length / 4.0 * wide, length / 10.0 * narrow, None), [4, 5, 6, 7, 8, 9, 10]);
    }
}

#[test]
fn a_roll_off_at_a_cut_off_changes_nothing_or_flattens_all() {
    let grid = Grid::square(64, 1.0).unwrap();
    for (longest, shortest) in [(0.25, 0.1), (0.1, 0.05), (1.0, 0.1)] {
        let surface = SelfAffine { amplitudes: Amplitudes::Fixed, ..self_affine(0.8, longest, shortest, 0.1) };
        let rolled = |roll_off| SelfAffine { roll_off, ..surface }.heights(&grid, 5).unwrap();
        let plain = surface.heights(&grid, 5).unwrap();
        let size = plain.iter().fold(0.0_f64, |most, h| most.max(h.abs()));
        let apart = (&rolled(plateau(longest)) - &plain).iter().fold(0.0_f64, |most, h| most.max(h.abs()));
        assert!(apart < 1e-12 * size, "{longest} to {shortest}: {apart}");
        let powers = spectrum_of(&rolled(plateau(shortest)), &grid).into_iter().map(|value| value.norm());
        let band: Vec<f64> = powers.filter(|size| *size > 1e-12).collect();
        let [least, most] =
            band.iter().fold([f64::INFINITY, 0.0_f64], |[least, most], size| [least.min(*size), most.max(*size)]);
        assert!(band.len() > 10 && most / least - 1.0 < 1e-9, "{longest} to {shortest}: {least} to {most}");
    }
}

#[test]
fn the_same_surface_on_finer_grids() {
    let coarse_points = 48;
    for (line, hurst) in [(false, 0.0), (false, 0.8), (true, 0.5)] {
        let grid = |points| if line { Grid::line(points, 1.7) } else { Grid::square(points, 1.7) }.unwrap();
        let surface = SelfAffine { roll_off: plateau(0.4), ..self_affine(hurst, 1.7 / 1.5, 1.7 / 14.0, 0.1) };
        let coarse = surface.heights(&grid(coarse_points), 11).unwrap();
        for ratio in [2, 3, 5] {
            let fine = surface.heights(&grid(coarse_points * ratio), 11).unwrap();
            let largest = coarse.iter().fold(0.0_f64, |most, h| most.max(h.abs()));
            for ((i, j), h) in coarse.indexed_iter() {
                assert!((fine[[i * ratio, j * ratio]] - h).abs() < 1e-13 * largest, "ratio {ratio} at {i}, {j}");
            }
        }
    }
}

#[test]
fn phases_do_not_depend_on_the_spectrum() {
    let grid = Grid::square(32, 1.0).unwrap();
    let rough = self_affine(0.0, 0.5, 0.1, 0.1);
    let smooth = SelfAffine { amplitudes: Amplitudes::Fixed, ..self_affine(1.0, 1.0, 0.08, 3.0) };
    let [rough, smooth] = [rough, smooth].map(|surface| surface.spectrum(&grid, 9).unwrap());
    let mut shared = 0;
    for (a, b) in rough.iter().zip(&smooth).filter(|(a, _)| a.norm() > 0.0) {
        assert!(((a / b).arg()).abs() < 1e-14);
        shared += 1;
    }
    assert!(shared > 100);
}

#[test]
fn the_half_spectrum_is_that_of_real_heights() {
    for grid in [Grid::new([16, 16], [1.0, 1.0]), Grid::new([17, 18], [1.0, 1.1]), Grid::line(16, 1.0)] {
        let grid = grid.unwrap();
        let allowed = 2.0 * if grid.is_line() { grid.spacing()[0] } else { grid.spacing()[0].max(grid.spacing()[1]) };
        for amplitudes in [Amplitudes::Gaussian, Amplitudes::Fixed] {
            let surface = SelfAffine { amplitudes, ..self_affine(0.5, 1.0, allowed, 1.0) };
            let asked = surface.spectrum(&grid, 21).unwrap();
            let found = spectrum_of(&surface.heights(&grid, 21).unwrap(), &grid);
            let size = asked.iter().map(|h| h.norm()).fold(0.0, f64::max);
            for (mode, (a, b)) in grid.modes().zip(asked.iter().zip(&found)) {
                assert!((a - b).norm() < 1e-14 * size, "{:?}: {a} became {b}", mode.number);
            }
        }
    }
}

#[test]
fn seeds_make_different_surfaces_and_threads_make_the_same() {
    let grid = Grid::square(256, 1.0).unwrap();
    let surface = self_affine(0.8, 0.5, 1.0 / 64.0, 0.1);
    let on = |threads, seed| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| surface.heights(&grid, seed).unwrap())
    };
    let one = on(1, 1);
    for threads in [2, 3, 5] {
        assert!(one.iter().zip(&on(threads, 1)).all(|(a, b)| a.to_bits() == b.to_bits()));
    }
    let other = on(2, 2);
    let correlation = (&one * &other).sum() / (one.mapv(|h| h * h).sum() * other.mapv(|h| h * h).sum()).sqrt();
    assert!(correlation.abs() < 0.4, "seeds 1 and 2 are correlated: {correlation}");
}

/// The mean square over many seeds is the given one, the mean square of one realisation is not, and the amplitudes are
/// Gaussian: ⟨|h̃|⁴⟩ = 2⟨|h̃|²⟩² for a complex mode, 3⟨h̃²⟩² for a self-conjugate one.
#[test]
fn the_ensemble_has_the_size_asked_for_and_normal_amplitudes() {
    let grid = Grid::square(8, 1.0).unwrap();
    let base = self_affine(0.6, 1.0, 0.25, 0.2);
    let surface = SelfAffine { scaling: Scaling::Ensemble, ..base };
    let seeds = 20_000;
    let (mut squares, mut fourths) = (vec![0.0; grid.spectrum_len()], vec![0.0; grid.spectrum_len()]);
    let mut gradients = Vec::new();
    for seed in 0..seeds {
        let spectrum = surface.spectrum(&grid, seed).unwrap();
        let mut gradient = 0.0;
        for (k, (mode, h)) in grid.modes().zip(&spectrum).enumerate() {
            squares[k] += h.norm_sqr() / seeds as f64;
            fourths[k] += h.norm_sqr().powi(2) / seeds as f64;
            gradient += mode.weight * mode.wavenumber().powi(2) * h.norm_sqr();
        }
        gradients.push(gradient);
    }
    let mean = gradients.iter().sum::<f64>() / seeds as f64;
    assert_relative_eq!(mean, 0.04, max_relative = 0.01);
    assert!(gradients.iter().any(|g| (g / 0.04 - 1.0).abs() > 0.2));
    assert_relative_eq!(surface.expected_moments(&grid).unwrap().rms_gradient(), 0.2, max_relative = 1e-13);
    let fixed = SelfAffine { amplitudes: Amplitudes::Fixed, ..base }.spectrum(&grid, 1).unwrap();
    for (k, mode) in grid.modes().enumerate().filter(|(k, _)| squares[*k] > 0.0) {
        let normal = if mode.is_self_conjugate() { 3.0 } else { 2.0 };
        assert_relative_eq!(fourths[k] / squares[k].powi(2), normal, max_relative = 0.12);
        assert_relative_eq!(squares[k], fixed[k].norm_sqr(), max_relative = 0.06);
    }
}

#[test]
fn unusable_spectra_are_refused_with_what_is_allowed() {
    let grid = Grid::square(32, 1.0).unwrap();
    let base = self_affine(0.8, 0.5, 0.125, 0.1);
    let says = |surface: SelfAffine, grid: Grid, words: &str| {
        let message = surface.heights(&grid, 1).unwrap_err().to_string();
        assert!(message.contains(words), "{message:?} lacks {words:?}");
    };
    says(SelfAffine { hurst: 1.2, ..base }, grid, "the Hurst exponent is 1.2; it must be between 0 and 1");
    says(SelfAffine { hurst: f64::NAN, ..base }, grid, "the Hurst exponent is NaN");
    says(SelfAffine { shortest_wavelength: 0.6, ..base }, grid, "shortest wavelength is 0.6 and the longest 0.5");
    says(SelfAffine { shortest_wavelength: -0.1, ..base }, grid, "0 < shortest");
    says(SelfAffine { shortest_wavelength: f64::NAN, ..base }, grid, "0 < shortest");
    says(
        SelfAffine { longest_wavelength: 1.1, ..base },
        grid,
        "longest wavelength is 1.1; it must be at most the cell length 1",
    );
    says(
        SelfAffine { shortest_wavelength: 0.06, ..base },
        grid,
        "is 0.06; it must be at least 0.0625, two grid spacings",
    );
    says(SelfAffine { roll_off: plateau(0.6), ..base }, grid, "is 0.6; it must be between 0.125 and 0.5");
    says(SelfAffine { roll_off: smooth(f64::NAN), ..base }, grid, "roll-off wavelength is NaN");
    says(
        SelfAffine { normalisation: Normalisation::RmsGradient(0.0), ..base },
        grid,
        "rms gradient is 0; it must be positive",
    );
    says(
        SelfAffine { normalisation: Normalisation::RmsHeight(-1.0), ..base },
        grid,
        "rms height is -1; it must be positive",
    );
    says(SelfAffine { longest_wavelength: 0.71, shortest_wavelength: 0.708, ..base }, grid, "at least one wave vector");
    says(base, Grid::new([1, 32], [1.0, 1.0]).unwrap(), "the profile has [1, 32] points; it must lie along x");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_allowed_spectrum_makes_finite_heights_of_the_size_asked_for(
        hurst in 0.0..=1.0_f64, points in [8_usize..40, 8_usize..40], seed: u64, sides in [0.5..2.0_f64, 0.5..2.0_f64],
        gradient in 1e-6..1e3_f64, inside in 0.0..1.0_f64,
    ) {
        let grid = Grid::new(points, sides).unwrap();
        let nyquist = 2.0 * grid.spacing()[0].max(grid.spacing()[1]);
        let longest = sides[0].max(sides[1]);
        let roll_off = smooth(nyquist + inside * (longest - nyquist));
        let surface = SelfAffine { roll_off, ..self_affine(hurst, longest, nyquist, gradient) };
        let heights = surface.heights(&grid, seed).unwrap();
        let measured = moment(&heights, &grid, 2).sqrt();
        prop_assert!((measured / gradient - 1.0).abs() < 1e-11, "{} for {}", measured, gradient);
    }
}

/// Heights made by another program from the documented random numbers (its own `pcg64`, plain sums, its own transform).
#[test]
fn the_documentation_is_enough_to_make_the_same_surface_elsewhere() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../data/reference/surface_heights.json");
    let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let cases = json["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 3);
    for case in cases {
        let number = |key: &str| case[key].as_f64().unwrap();
        let [nx, ny] = [0, 1].map(|axis| case["points"][axis].as_u64().unwrap() as usize);
        let grid = Grid::new([nx, ny], [0, 1].map(|axis| case["lengths"][axis].as_f64().unwrap())).unwrap();
        let surface = self_affine(number("hurst"), number("longest"), number("shortest"), number("rms_gradient"));
        let heights = surface.heights(&grid, case["seed"].as_u64().unwrap()).unwrap();
        for ((i, j), height) in heights.indexed_iter() {
            let expected = case["heights"][i][j].as_f64().unwrap();
            assert!((height - expected).abs() < 1e-14, "{height} for {expected} at {i}, {j}");
        }
    }
}

/// Along the lay, mean square slopes are smaller by 1/r² than across it, for any direction of the lay.
#[test]
fn waves_are_longer_along_the_lay() {
    let grid = Grid::square(256, 1.0).unwrap();
    for (aspect, lay) in [(2.0, 30.0), (4.0, 135.0), (4.0, 0.0), (2.0, -90.0)] {
        let anisotropy = Some(Anisotropy { aspect, lay });
        let surface =
            SelfAffine { anisotropy, amplitudes: Amplitudes::Fixed, ..self_affine(0.8, 1.0 / 4.0, 1.0 / 32.0, 0.1) };
        let spectrum = surface.spectrum(&grid, 3).unwrap();
        let (sin, cos) = f64::to_radians(lay).sin_cos();
        let [mut along, mut across, mut longest, mut shortest] = [0.0, 0.0, f64::INFINITY, 0.0_f64];
        for (mode, value) in grid.modes().zip(&spectrum).filter(|(_, value)| value.norm() > 0.0) {
            let [x, y] = mode.number.map(|number| number as f64);
            let power = mode.weight * value.norm_sqr();
            along += power * (x * cos + y * sin).powi(2);
            across += power * (y * cos - x * sin).powi(2);
            longest = longest.min(x.hypot(y));
            shortest = shortest.max(x.hypot(y));
        }
        assert!((along / across * aspect.powi(2) - 1.0).abs() < 0.05, "{aspect} {lay}: {}", along / across);
        assert!((longest * aspect.sqrt() - 4.0).abs() < 1.0, "{longest}");
        assert!((shortest / aspect.sqrt() - 32.0).abs() < 0.6, "{shortest}");
        let heights = surface.heights(&grid, 3).unwrap();
        let found = PowerSpectrum::of(&heights, &grid).unwrap();
        assert!((found.moments().rms_gradient() - 0.1).abs() < 1e-12);
        let direction = Direction::of(&found, Some(0.2));
        let (steepest, anisotropy) = (direction.steepest.unwrap(), direction.anisotropy.unwrap());
        let square = aspect.powi(2);
        assert!((anisotropy - (square - 1.0) / (square + 1.0)).abs() < 0.02, "{aspect}: {anisotropy}");
        let off = (steepest - lay - 90.0).rem_euclid(180.0);
        assert!(off.min(180.0 - off) < 1.0, "{lay}: {steepest}");
    }
    let refused = |anisotropy, longest: f64, shortest: f64, grid: &Grid| {
        let surface = SelfAffine { anisotropy: Some(anisotropy), ..self_affine(0.8, longest, shortest, 0.1) };
        surface.heights(grid, 1).unwrap_err().to_string()
    };
    let twice = Anisotropy { aspect: 4.0, lay: 10.0 };
    assert!(refused(twice, 0.6, 0.1, &grid).starts_with("the longest wavelength is 1.2"));
    assert!(refused(twice, 0.5, 0.01, &grid).starts_with("the shortest wavelength is 0.005"));
    assert!(refused(twice, 0.5, 0.1, &Grid::line(256, 1.0).unwrap()).starts_with("the profile has a preferred"));
    let below = Anisotropy { aspect: 0.9, lay: 0.0 };
    assert!(refused(below, 0.5, 0.1, &grid).starts_with("the aspect ratio is 0.9"));
    let endless = Anisotropy { aspect: 2.0, lay: f64::NAN };
    assert!(refused(endless, 0.5, 0.1, &grid).starts_with("the aspect ratio is 2 and the lay is NaN"));
}
