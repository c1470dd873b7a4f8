//! Flows with closed forms, dense solutions, identities, and bad input.

use approx::assert_relative_eq;
use gfmd_field::Grid;
use gfmd_flow::{Boundary, Flow, FlowError, TOLERANCE, Wanted, flow};
use ndarray::Array2;

const BOTH: [Boundary; 2] = [Boundary::Periodic, Boundary::Free];

fn square(n: usize) -> Grid {
    Grid::square(n, 1.0).unwrap()
}

fn solved(k: &Array2<f64>, boundary: Boundary) -> Flow {
    let (nx, ny) = k.dim();
    let grid = Grid::new([nx, ny], [1.0, ny as f64 / nx as f64]).unwrap();
    let found = flow(&grid, k.view(), boundary, Wanted::Fields).unwrap();
    assert!(found.residual <= TOLERANCE);
    for path in found.paths.iter().flatten() {
        assert!(path.residual <= TOLERANCE);
    }
    found
}

/// Generates numbers between 0 and 1.
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[test]
fn layers_in_series_and_side_by_side_are_exact() {
    let k = |i: usize| [1.0, 3.0, 0.01, 7.0][i / 3 % 4];
    let mean = (1.0 + 3.0 + 0.01 + 7.0) / 4.0;
    let harmonic = 4.0 / (1.0 + 1.0 / 3.0 + 100.0 + 1.0 / 7.0);
    for boundary in BOTH {
        let along_y = solved(&Array2::from_shape_fn((24, 20), |(i, _)| k(i)), boundary);
        assert_relative_eq!(along_y.conductivity[0][0], harmonic, max_relative = 1e-8);
        assert_relative_eq!(along_y.conductivity[1][1], mean, max_relative = 1e-8);
        assert!(along_y.conductivity[0][1].abs() < 1e-8 && along_y.conductivity[1][0].abs() < 1e-8);
        let uniform = solved(&Array2::from_elem((5, 8), 3.0), boundary);
        assert_relative_eq!(uniform.conductivity[0][0], 3.0, max_relative = 1e-14);
        // The flux, with its unit, equals the mean everywhere.
        let path = uniform.paths[0].as_ref().unwrap();
        assert!(path.flux.iter().all(|flux| (flux - 3.0).abs() < 1e-13));
    }
}

#[test]
fn a_chequerboard_approaches_the_geometric_mean() {
    let contrast = 9.0_f64;
    let errors = [16, 64, 256].map(|n: usize| {
        let board =
            Array2::from_shape_fn(
                (n, n),
                |(i, j)| if (2 * i / n + 2 * j / n).is_multiple_of(2) { 1.0 } else { contrast },
            );
        let found = flow(&square(n), board.view(), Boundary::Periodic, Wanted::Conductivity).unwrap();
        found.conductivity[0][0] / contrast.sqrt() - 1.0
    });
    // The corners slow down convergence.
    assert!(errors[2].abs() < 0.0125, "{errors:?}");
    assert!(errors[0].abs() > errors[1].abs(), "{errors:?}");
    assert!(errors[1].abs() > errors[2].abs(), "{errors:?}");
}

#[test]
fn random_mixtures_have_the_conductivities_of_duality_and_of_effective_media() {
    // Grains of 8 x 8 cells.
    let n = 256;
    let mut number = random(7);
    let grains = Array2::from_shape_fn((n / 8, n / 8), |_| number());
    let field = Array2::from_shape_fn((n, n), |(i, j)| grains[[i / 8, j / 8]]);
    // Half of each: the geometric mean (Keller 1964, Dykhne 1970), in agreement with Bruggeman.
    let half = solved(&field.mapv(|x| if x < 0.5 { 1.0 } else { 4.0 }), Boundary::Periodic);
    assert_relative_eq!(half.conductivity[0][0], 2.0, max_relative = 0.06);
    // Bruggeman: Σ c (k − K)/(k + K) = 0; with a fraction c = 0.1 of holes, K = 1 − 2 c.
    let holes = solved(&field.mapv(|x| if x < 0.1 { 0.0 } else { 1.0 }), Boundary::Periodic);
    assert_relative_eq!(holes.conductivity[1][1], 0.8, max_relative = 0.06);
}

#[test]
fn what_does_not_percolate_conducts_exactly_nothing() {
    let ring = Array2::from_shape_fn((32, 32), |(i, j)| if (i == 5) | (j == 9) { 0.0 } else { 1.0 });
    for boundary in BOTH {
        let found = solved(&ring, boundary);
        assert_eq!((found.conductivity, found.percolates, found.residual), ([[0.0; 2]; 2], [false; 2], 0.0));
        assert!(found.paths.iter().all(Option::is_none));
        let dam = solved(&Array2::from_shape_fn((32, 32), |(i, _)| if i == 5 { 0.0 } else { 1.0 }), boundary);
        let [[xx, xy], [yx, _]] = dam.conductivity;
        assert_eq!((dam.percolates, xx, yx), ([false, true], 0.0, 0.0));
        assert!(xy.abs() < if boundary == Boundary::Free { 1e-16 } else { f64::MIN_POSITIVE });
        assert_relative_eq!(dam.conductivity[1][1], 31.0 / 32.0, max_relative = 1e-8);
    }
    // A diagonal channel percolates along both axes.
    let stairs = Array2::from_shape_fn((16, 16), |(i, j)| if (i + 16 - j) % 16 < 2 { 1.0 } else { 0.0 });
    let found = solved(&stairs, Boundary::Periodic);
    assert_eq!(found.percolates, [true; 2]);
    let [[xx, xy], [yx, yy]] = found.conductivity;
    assert_relative_eq!(xx, xy, max_relative = 1e-8);
    assert_relative_eq!(yx, yy, max_relative = 1e-8);
    let nothing = solved(&Array2::zeros((8, 8)), Boundary::Periodic);
    assert_eq!(nothing.conductivity, [[0.0; 2]; 2]);
}

/// Computes the mean flux along x and y due to a gradient along x by Gaussian elimination, with its own definition of
/// the faces.
fn dense(k: &Array2<f64>, boundary: Boundary) -> [f64; 2] {
    let (nx, ny) = k.dim();
    let (n, ends) = (nx * ny, boundary == Boundary::Free);
    let (dx, dy) = (1.0 / nx as f64, 1.0 / nx as f64);
    let face = |a: f64, b: f64| if a.min(b) > 0.0 { 2.0 / (1.0 / a + 1.0 / b) } else { 0.0 };
    let mut rows = vec![vec![0.0; n + 1]; n];
    let mut faces = vec![];
    for i in 0..nx {
        for j in 0..ny {
            if i + 1 < nx || !ends {
                faces.push((
                    (i * ny + j),
                    ((i + 1) % nx * ny + j),
                    face(k[[i, j]], k[[(i + 1) % nx, j]]) * dy / dx,
                    dx,
                ));
            }
            if j + 1 < ny || !ends {
                faces.push((
                    (i * ny + j),
                    (i * ny + (j + 1) % ny),
                    face(k[[i, j]], k[[i, (j + 1) % ny]]) * dx / dy,
                    0.0,
                ));
            }
        }
    }
    for &(a, b, t, drop) in &faces {
        rows[a][a] += t;
        rows[b][b] += t;
        rows[a][b] -= t;
        rows[b][a] -= t;
        rows[a][n] -= t * drop;
        rows[b][n] += t * drop;
    }
    for j in (0..ny).filter(|_| ends) {
        for (cell, sign) in [(j, 1.0), ((nx - 1) * ny + j, -1.0)] {
            let t = k.as_slice().unwrap()[cell] * dy / (0.5 * dx);
            rows[cell][cell] += t;
            rows[cell][n] += sign * t * 0.5 * dx;
        }
    }
    let scale = rows[0][0].max(1e-3);
    for p in 0..n {
        if rows[p][p] < 1e-11 * scale {
            // A part without a reservoir, or a closed cell: its level is arbitrary.
            rows[p].fill(0.0);
            rows[p][p] = 1.0;
        }
        let (above, below) = rows.split_at_mut(p + 1);
        for row in below {
            let factor = row[p] / above[p][p];
            row.iter_mut().zip(&above[p]).skip(p).for_each(|(a, b)| *a -= factor * b);
        }
    }
    let mut level = vec![0.0; n];
    for p in (0..n).rev() {
        let known: f64 = (p + 1..n).map(|q| rows[p][q] * level[q]).sum();
        level[p] = (rows[p][n] - known) / rows[p][p];
    }
    let flow = |&(a, b, t, drop): &(usize, usize, f64, f64)| t * (level[a] - level[b] + drop);
    // The flow through the section behind the first row of cells.
    let along = faces.iter().filter(|f| f.0 / ny == 0 && f.3 > 0.0).map(flow).sum::<f64>() / (ny as f64 * dy);
    let across = faces.iter().filter(|f| f.3 == 0.0).map(flow).sum::<f64>() * dy / (ny as f64 * dy);
    [along, across]
}

#[test]
fn dense_solutions_agree() {
    for (seed, closed) in [(1, 0.0), (2, 0.2), (3, 0.35)] {
        let mut number = random(seed);
        let k =
            Array2::from_shape_fn(
                (12, 9),
                |_| if number() < closed { 0.0 } else { 10.0_f64.powf(4.0 * number() - 3.0) },
            );
        for boundary in BOTH {
            let (found, [along, across]) = (solved(&k, boundary), dense(&k, boundary));
            let [[upper, _], [other, _]] = found.conductivity;
            let rounding = 1e-11 * along;
            assert!(upper >= along - rounding, "{upper} {along}");
            assert!(upper * (1.0 - found.residual) <= along + rounding, "{upper} {along} {}", found.residual);
            assert!(found.percolates[0] && along > 1e-5);
            // The mean flux across is as exact as the conductivity.
            assert!((other - across).abs() < 1e-8 * along, "{boundary:?}: {other} {across}");
        }
    }
}

/// Computes the conductivity along x of a potential: its dissipated power.
fn power(k: &Array2<f64>, potential: &Array2<f64>, boundary: Boundary) -> f64 {
    let (nx, ny) = k.dim();
    let step = 1.0 / nx as f64;
    let mut sum = 0.0;
    for ((i, j), &here) in k.indexed_iter().filter(|(_, k)| **k > 0.0) {
        let free = boundary == Boundary::Free;
        for (place, drop, ends) in [([(i + 1) % nx, j], step, i + 1 == nx), ([i, (j + 1) % ny], 0.0, j + 1 == ny)] {
            if !(free && ends) && k[place] > 0.0 {
                let fall = potential[[i, j]] - potential[place] + drop;
                sum += 2.0 / (1.0 / here + 1.0 / k[place]) * fall * fall;
            }
        }
        for (_, sign) in [(i == 0, -1.0), (i + 1 == nx, 1.0)].into_iter().filter(|(is_end, _)| free && *is_end) {
            sum += 2.0 * here * (potential[[i, j]] + sign * 0.5 * step).powi(2);
        }
    }
    sum / (ny as f64 * step)
}

/// The potential of the fields misses 1e-8 of the flow, and so its power exceeds the conductivity by less than 1e-12.
#[test]
fn the_bounds_enclose_the_conductivity() {
    let mut distances = Vec::new();
    for (seed, closed) in [(11, 0.0), (12, 0.2), (13, 0.3), (14, 0.38)] {
        let mut number = random(seed);
        let k = Array2::from_shape_fn((120, 96), |_| {
            let x = number();
            if x < closed { 0.0 } else { 10.0_f64.powf(6.0 * number() - 6.0) }
        });
        for boundary in BOTH {
            let found = solved(&k, boundary);
            assert!(found.percolates[0], "{seed}");
            let path = found.paths[0].as_ref().unwrap();
            // Without the patches through which nothing flows.
            let open = ndarray::Zip::from(&k).and(&path.flux).map_collect(|k, flux| if *flux > 0.0 { *k } else { 0.0 });
            let exact = power(&open, &path.potential, boundary);
            let distance = found.conductivity[0][0] / exact - 1.0;
            assert!(distance > -1e-12 && distance <= found.residual + 1e-12, "{distance:e} {:e}", found.residual);
            distances.push(distance);
        }
    }
    // The bounds are not far apart, and the search stops as soon as they are close.
    assert!(distances.iter().any(|distance| *distance > 1e-10), "{distances:?}");
}

#[test]
fn fields_change_no_bit_of_the_conductivity() {
    let mut number = random(21);
    let k = Array2::from_shape_fn((64, 50), |_| (number() - 0.25).max(0.0).powi(3));
    for boundary in BOTH {
        let with = solved(&k, boundary);
        let grid = Grid::new([64, 50], [1.0, 50.0 / 64.0]).unwrap();
        let without = flow(&grid, k.view(), boundary, Wanted::Conductivity).unwrap();
        assert_eq!(without.paths, [None, None]);
        assert_eq!((with.conductivity, with.residual), (without.conductivity, without.residual));
        assert!(without.iterations < with.iterations);
    }
}

#[test]
fn a_channel_along_one_axis_has_its_conductivity_alone() {
    // A meander of two cells, with a dead end and a basin beside it.
    let n = 40;
    let is_open = |i: usize, j: usize| {
        let meander = matches!((i, j), (0..20, 10..12) | (20..40, 24..26) | (18..20 | 38..40, 10..26));
        meander || matches!((i, j), (5, 12..20) | (30..36, 2..8))
    };
    let k = Array2::from_shape_fn((n, n), |(i, j)| if is_open(i, j) { 1.0 + (i * j % 7) as f64 } else { 0.0 });
    for boundary in BOTH {
        let (found, [along, across]) = (solved(&k, boundary), dense(&k, boundary));
        let [[xx, xy], [yx, yy]] = found.conductivity;
        assert_eq!(found.percolates, [true, false]);
        assert_eq!((xy, yy), (0.0, 0.0));
        assert!(xx >= along * (1.0 - 1e-11) && xx * (1.0 - found.residual) <= along * (1.0 + 1e-11));
        assert!((yx - across).abs() < 1e-8 * along, "{boundary:?} {yx} {across}");
        assert_eq!(yx == 0.0, boundary == Boundary::Periodic);
    }
}

#[test]
fn the_tensor_is_symmetric_and_turns_with_the_field() {
    let field = |i: usize, j: usize| {
        let [x, y] = [i, j].map(|k| std::f64::consts::TAU * k as f64 / 48.0);
        (2.0 * (x - 2.0 * y).sin() + (3.0 * x + y + 1.0).cos()).exp()
    };
    let found = solved(&Array2::from_shape_fn((48, 48), |(i, j)| field(i, j)), Boundary::Periodic).conductivity;
    assert!((found[0][1] - found[1][0]).abs() < 1e-10 * found[0][0], "{found:?}");
    assert!(found[0][1].abs() > 1e-2);
    let turned = solved(&Array2::from_shape_fn((48, 48), |(i, j)| field(j, i)), Boundary::Periodic).conductivity;
    assert_relative_eq!(turned[0][0], found[1][1], max_relative = 1e-7);
    // Wiener bounds: between the harmonic and the arithmetic mean.
    let (mean, inverse) = (0..48 * 48).map(|c| field(c / 48, c % 48)).fold((0.0, 0.0), |s, k| (s.0 + k, s.1 + 1.0 / k));
    assert!(found[0][0] < mean / 2304.0 && found[0][0] > 2304.0 / inverse);
}

#[test]
fn contrasts_of_many_orders_take_few_iterations_and_units_do_not_matter() {
    // Cubed gaps: narrow channels beside closed patches, with k over twenty orders of magnitude.
    for n in [64, 256] {
        let gap = Array2::from_shape_fn((n, n), |(i, j)| {
            let [x, y] = [i, j].map(|k| std::f64::consts::TAU * k as f64 / n as f64);
            let waves = (3.0 * x).cos()
                + (2.0 * y + 1.0).cos()
                + 0.7 * (5.0 * x - 4.0 * y).sin()
                + 0.4 * (9.0 * x + 8.0 * y).cos();
            (waves + 0.9).max(0.0)
        });
        let found = solved(&gap.mapv(|g| g.powi(3)), Boundary::Periodic);
        assert_eq!(found.percolates, [true; 2]);
        assert!(found.iterations <= 50, "{n}: {}", found.iterations);
        let alone = flow(&square(n), gap.mapv(|g| g.powi(3)).view(), Boundary::Periodic, Wanted::Conductivity).unwrap();
        assert!(alone.iterations <= 25, "{n}: {}", alone.iterations);
        let small = solved(&gap.mapv(|g| 1e-280 * g.powi(3)), Boundary::Periodic);
        assert_relative_eq!(small.conductivity[0][0], 1e-280 * found.conductivity[0][0], max_relative = 1e-12);
    }
}

#[test]
fn a_basin_behind_the_weakest_dams_harms_nothing() {
    // A channel, and beside it a basin of the largest conductivity in a ring of weak cells, which leaks into the
    // channel.
    let n = 96;
    let k = Array2::from_shape_fn((n, n), |(i, j)| match (i, j) {
        (_, 0..8) => 1e-4,
        (20..80, 20..80) if (24..76).contains(&i) && (24..76).contains(&j) => 1.0,
        (20..80, 20..80) => 1e-14,
        (40, 8..20) => 1e-12,
        _ => 0.0,
    });
    let found = solved(&k, Boundary::Periodic);
    assert_eq!(found.percolates, [true, false]);
    assert_relative_eq!(found.conductivity[0][0], 1e-4 * 8.0 / n as f64, max_relative = 1e-10);
}

/// In the pool the potential falls as the mean gradient rises, so that flows are differences of nearly equal numbers of
/// any size.
#[test]
fn a_gate_before_a_pool_conducts_in_proportion() {
    let n = 64;
    let through = |gate: f64| {
        let k = Array2::from_shape_fn((n, n), |(i, j)| match (i, j) {
            (5, 30) => gate,
            (5, _) => 0.0,
            _ => 1.0,
        });
        let found = solved(&k, Boundary::Periodic);
        assert!(found.iterations <= 60, "{}", found.iterations);
        found.conductivity[0][0] / gate
    };
    let [narrow, narrower] = [1e-10, 1e-15].map(through);
    assert_relative_eq!(narrow, narrower, max_relative = 1e-9);
}

#[test]
fn threads_change_no_bit() {
    let mut number = random(5);
    let k = Array2::from_shape_fn((100, 90), |_| (number() - 0.2).max(0.0).powi(3));
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| solved(&k, Boundary::Periodic))
    };
    assert_eq!(on(1), on(2));
}

/// The result is independent of the origin of the cell, with several blocks and with a seam in the chequerboard.
#[test]
fn the_origin_of_a_cell_does_not_matter() {
    for [nx, ny] in [[300, 210], [211, 300], [195, 203]] {
        let mut number = random(9);
        let k = Array2::from_shape_fn((nx, ny), |_| (number() - 0.3).max(0.0).powi(3));
        let moved = Array2::from_shape_fn((nx, ny), |(i, j)| k[[(i + 77) % nx, (j + 60) % ny]]);
        let [k, moved] = [k, moved].map(|k| solved(&k, Boundary::Periodic));
        assert_eq!(k.percolates, [true; 2]);
        for (a, b) in k.conductivity.iter().flatten().zip(moved.conductivity.iter().flatten()) {
            assert!((a - b).abs() < 1e-8 * k.conductivity[0][0], "{a} {b}");
        }
        assert!(k.iterations <= 50, "{}", k.iterations);
    }
}

#[test]
fn unusable_fields_are_refused() {
    let refused = |k: Array2<f64>| flow(&square(4), k.view(), Boundary::Periodic, Wanted::Conductivity).unwrap_err();
    assert!(matches!(refused(Array2::ones((4, 5))), FlowError::Shape { .. }));
    for value in [-1.0, f64::NAN, f64::INFINITY] {
        let mut k = Array2::ones((4, 4));
        k[[1, 2]] = value;
        assert!(matches!(refused(k), FlowError::Conductivity { index: [1, 2], .. }));
    }
    let line = Grid::line(4, 1.0).unwrap();
    let found = flow(&line, Array2::ones((4, 1)).view(), Boundary::Periodic, Wanted::Conductivity);
    assert!(matches!(found, Err(FlowError::Points([4, 1]))));
}
