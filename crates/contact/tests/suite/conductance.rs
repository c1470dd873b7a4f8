//! Conductance of the points in contact: dense solutions with kernels summed or integrated here, limits, units.

use std::f64::consts::{PI, TAU};

use approx::assert_relative_eq;
use gfmd_contact::{Boundary, Conductance, ConductanceError, Conductors, Contact, Equilibrium, Fields as _, Load};
use gfmd_field::Grid;
use gfmd_green::{Body, Height, Material};
use ndarray::Array2;

use super::long;

fn material(poisson: f64) -> Material {
    Material::from_contact_modulus(1.0, poisson).unwrap()
}

fn half_space() -> Body {
    Body::half_space(material(0.3))
}

/// Returns heights without a pattern.
fn rough([nx, ny]: [usize; 2]) -> Array2<f64> {
    let noise = |k: usize| ((k as f64 + 1.0) * 0.618_034).fract() + ((k as f64 + 1.0) * 0.754_878).fract();
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let wave = (TAU * i as f64 / nx as f64).cos() + (TAU * j as f64 / ny as f64 + 0.4).sin();
        0.01 * (wave + 0.5 * noise(i * ny + j))
    })
}

/// Computes the conductance per area of the points with positive pressure by Gaussian elimination: the mean of the
/// current densities that give all of them the potential 1. `resistance(i, j)` is the potential at the point i under a
/// unit density on the cell j.
fn dense(pressure: &Array2<f64>, resistance: impl Fn([usize; 2], [usize; 2]) -> f64) -> f64 {
    let inside: Vec<[usize; 2]> =
        pressure.indexed_iter().filter(|(_, p)| **p > 0.0).map(|((i, j), _)| [i, j]).collect();
    let m = inside.len();
    let mut rows: Vec<Vec<f64>> =
        inside.iter().map(|&a| inside.iter().map(|&b| resistance(a, b)).chain([1.0]).collect()).collect();
    for k in 0..m {
        // The matrix need not be positive definite if the uniform mode has no resistance.
        let pivot = (k..m).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs())).unwrap();
        rows.swap(k, pivot);
        let (above, below) = rows.split_at_mut(k + 1);
        for row in below {
            let factor = row[k] / above[k][k];
            row.iter_mut().zip(&above[k]).skip(k).for_each(|(a, b)| *a -= factor * b);
        }
    }
    let mut current = vec![0.0; m];
    for k in (0..m).rev() {
        let known: f64 = (k + 1..m).map(|j| rows[k][j] * current[j]).sum();
        current[k] = (rows[k][m] - known) / rows[k][k];
    }
    current.iter().sum::<f64>() / pressure.len() as f64
}

/// Returns tanh(q H)/q, or 1/q.
fn kernel(q: f64, height: Height) -> f64 {
    match height {
        Height::Finite(height) => (q * height).tanh() / q,
        Height::Infinite => 1.0 / q,
    }
}

/// Computes the dense conductance on a periodic grid, by a sum over all waves except the uniform one.
fn dense_periodic(pressure: &Array2<f64>, [lx, ly]: [f64; 2], height: Height) -> f64 {
    let (nx, ny) = pressure.dim();
    let number = |m: usize, n: usize| if 2 * m > n { m as f64 - n as f64 } else { m as f64 };
    let shift = Array2::from_shape_fn((nx, ny), |(i, j)| {
        let mut sum = 0.0;
        for (m, n) in (0..nx).flat_map(|m| (0..ny).map(move |n| (m, n))).skip(1) {
            let [x, y] = [number(m, nx), number(n, ny)];
            let q = TAU * (x / lx).hypot(y / ly);
            sum += kernel(q, height) * (TAU * (x * i as f64 / nx as f64 + y * j as f64 / ny as f64)).cos();
        }
        sum / (nx * ny) as f64
    });
    dense(pressure, |a, b| shift[[(a[0] + nx - b[0]) % nx, (a[1] + ny - b[1]) % ny]])
}

/// Returns ∫ dA/√(r² + z²) over a cell with these sides and its centre at `at`. At z = 0 it is the sum over the edges
/// of their distance times ∫ ds/r, elsewhere a quadrature.
fn cell(at: [f64; 2], [a, b]: [f64; 2], z: f64) -> f64 {
    if z == 0.0 {
        let edge = |d: f64, [from, to]: [f64; 2]| {
            if d == 0.0 { 0.0 } else { d * ((to / d.abs()).asinh() - (from / d.abs()).asinh()) }
        };
        let [left, right, below, above] = [at[0] - 0.5 * a, at[0] + 0.5 * a, at[1] - 0.5 * b, at[1] + 0.5 * b];
        return edge(right, [below, above]) - edge(left, [below, above]) + edge(above, [left, right])
            - edge(below, [left, right]);
    }
    integrate(|x| integrate(|y| 1.0 / (at[0] + a * x).hypot(at[1] + b * y).hypot(z))) * a * b
}

/// Returns ∫ f over −1/2 to 1/2, by Gauss's rule of four points on 16 pieces.
fn integrate(f: impl Fn(f64) -> f64) -> f64 {
    let nodes =
        [(0.339_981_043_584_856_3, 0.652_145_154_862_546_1), (0.861_136_311_594_052_6, 0.347_854_845_137_453_9)];
    let piece = |k: usize| {
        let middle = (k as f64 + 0.5) / 16.0 - 0.5;
        nodes.iter().map(|(x, w)| 0.5 * w * (f(middle + x / 32.0) + f(middle - x / 32.0))).sum::<f64>() / 16.0
    };
    (0..16).map(piece).sum()
}

/// Returns an alternating sum of slowly falling terms, by repeated averages of the partial sums.
fn alternating(term: impl Fn(usize) -> f64) -> f64 {
    let mut sum = 0.0;
    let mut sums: Vec<f64> = (0..60)
        .map(|k| {
            sum += if k % 2 == 0 { term(k) } else { -term(k) };
            sum
        })
        .skip(20)
        .collect();
    while sums.len() > 1 {
        sums = sums.windows(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect();
    }
    sums[0]
}

/// Returns the resistance of a patch between two cells at these distances, with the images of a current behind the
/// electrode and the surface.
fn free_table([nx, ny]: [usize; 2], lengths: [f64; 2], height: Height) -> Array2<f64> {
    let sides = [lengths[0] / nx as f64, lengths[1] / ny as f64];
    Array2::from_shape_fn((nx, ny), |(i, j)| {
        let at = [i as f64 * sides[0], j as f64 * sides[1]];
        let images = match height {
            Height::Finite(h) => -2.0 * alternating(|k| cell(at, sides, 2.0 * (k + 1) as f64 * h)),
            Height::Infinite => 0.0,
        };
        (cell(at, sides, 0.0) + images) / TAU
    })
}

fn found(boundary: Boundary, grid: &Grid, height: Height, pressure: &Array2<f64>) -> f64 {
    let conductance = Conductors::new(boundary, grid, height).unwrap().conductance(pressure).unwrap();
    assert!(conductance.error <= 1e-9, "{conductance:?}");
    conductance.value
}

const HEIGHTS: [Height; 4] = [Height::Infinite, Height::Finite(0.5), Height::Finite(0.1), Height::Finite(0.02)];

#[test]
fn any_elastic_body_and_hardness_has_the_conductance_of_a_dense_solution() {
    let lengths = [1.0, 0.8];
    let grid = Grid::new([16, 12], lengths).unwrap();
    let heights = rough([16, 12]);
    let slab = |poisson: f64, height: f64| Body::slab(material(poisson), height).unwrap();
    let stiff = Body::half_space(Material::from_young(20.0, 0.2).unwrap());
    let bodies = [
        half_space(),
        slab(0.3, 0.05),
        slab(0.5, 0.2),
        slab(0.1, 0.03).bonded_to(stiff.clone()).unwrap(),
        half_space().against(stiff),
    ];
    for body in &bodies {
        for hardness in [None, Some(0.08)] {
            let contact = Contact::new(body, &grid, &heights).unwrap();
            let contact = match hardness {
                Some(hardness) => contact.with_hardness(hardness).unwrap(),
                None => contact,
            };
            for mean in [0.002, 0.02, 0.05] {
                let state = contact.press(Load::MeanPressure(mean)).tolerance(1e-10).solve().unwrap();
                if let (Some(plastic), 0.05) = (&state.plastic, mean) {
                    assert!(plastic.fraction > 0.1, "{plastic:?}");
                }
                for height in HEIGHTS {
                    let exact = dense_periodic(&state.pressure, lengths, height);
                    assert_relative_eq!(
                        found(Boundary::Periodic, &grid, height, &state.pressure),
                        exact,
                        max_relative = 1e-9
                    );
                }
            }
        }
    }
}

#[test]
fn a_patch_has_the_conductance_of_a_dense_solution() {
    let lengths = [1.0, 0.7];
    let grid = Grid::new([12, 10], lengths).unwrap();
    let heights = rough([12, 10]);
    let electrodes = [Height::Infinite, Height::Finite(0.5), Height::Finite(0.1), Height::Finite(0.03)];
    let tables = electrodes.map(|height| (height, free_table([12, 10], lengths, height)));
    for (hardness, mean) in [(1e6, 0.002), (1e6, 0.02), (0.05, 0.02), (1e6, 5.0)] {
        let contact = Contact::with_boundary(Boundary::Free, &half_space(), &grid, &heights).unwrap();
        let contact = contact.with_hardness(hardness).unwrap();
        let state = contact.press(Load::MeanPressure(mean)).tolerance(1e-10).solve().unwrap();
        for (height, table) in &tables {
            let exact = dense(&state.pressure, |a, b| table[[a[0].abs_diff(b[0]), a[1].abs_diff(b[1])]]);
            assert_relative_eq!(found(Boundary::Free, &grid, *height, &state.pressure), exact, max_relative = 1e-9);
        }
    }
}

/// On a patch without a point apart the stiffness of a uniform displacement is only rounding, and no direction.
#[test]
fn full_contact_of_a_patch_has_the_conductance_of_a_dense_solution() {
    let grids = [([6, 8], [1.22151, 1.62868]), ([8, 8], [1.0, 1.0]), ([5, 9], [1.0, 1.3])];
    for (shape, (points, lengths)) in grids.into_iter().enumerate() {
        let grid = Grid::new(points, lengths).unwrap();
        let all = [0.1, 0.2, 0.3, 0.5].into_iter().enumerate();
        for (_, h) in all.filter(|(index, _)| long() || index % 3 == shape) {
            let (height, all) = (Height::Finite(h), Array2::ones(points));
            let table = free_table(points, lengths, height);
            let exact = dense(&all, |a, b| table[[a[0].abs_diff(b[0]), a[1].abs_diff(b[1])]]);
            assert_relative_eq!(found(Boundary::Free, &grid, height, &all), exact, max_relative = 1e-9);
        }
    }
}

#[test]
fn profiles_have_the_conductance_of_a_dense_solution() {
    let grid = Grid::line(40, 1.3).unwrap();
    let heights =
        Array2::from_shape_fn((40, 1), |(i, _)| 0.01 * (0.7 * i as f64).sin() + 0.008 * (TAU * i as f64 / 40.0).cos());
    let contact = Contact::new(&half_space(), &grid, &heights).unwrap();
    let free =
        Contact::with_boundary(Boundary::Free, &Body::slab(material(0.3), 0.2).unwrap(), &grid, &heights).unwrap();
    for mean in [0.003, 0.02] {
        let state = contact.press(Load::MeanPressure(mean)).tolerance(1e-10).solve().unwrap();
        for height in HEIGHTS {
            let exact = dense_periodic(&state.pressure, [1.3, 1.0], height);
            assert_relative_eq!(found(Boundary::Periodic, &grid, height, &state.pressure), exact, max_relative = 1e-9);
        }
        // The potential of a line of current on a slab is -ln tanh(π x/(4 H))/π. The singular part of the logarithm is
        // integrated in closed form.
        let state = free.press(Load::MeanPressure(mean)).tolerance(1e-10).solve().unwrap();
        let side = 1.3 / 40.0;
        for h in [0.05, 0.3, 2.0] {
            let rest = |x: f64| {
                let s = 0.25 * PI * x.abs() / h;
                if s < 1e-4 { -s * s / 3.0 } else { (s.tanh() / s).ln() }
            };
            let strip = |x: f64| {
                let primitive = |x: f64| if x == 0.0 { 0.0 } else { x * ((0.25 * PI * x.abs() / h).ln() - 1.0) };
                let logarithm = primitive(x + 0.5 * side) - primitive(x - 0.5 * side);
                -(logarithm + side * integrate(|s| rest(x + side * s))) / PI
            };
            let exact = dense(&state.pressure, |a, b| strip((a[0] as f64 - b[0] as f64) * side));
            let found = found(Boundary::Free, &grid, Height::Finite(h), &state.pressure);
            assert_relative_eq!(found, exact, max_relative = 1e-9);
        }
        let endless = Conductors::new(Boundary::Free, &grid, Height::Infinite).unwrap();
        assert!(endless.conductance(&state.pressure).unwrap().value.is_nan());
    }
}

/// Barber's analogy, where it holds.
#[test]
fn on_elastic_half_spaces_it_is_twice_the_stiffness_over_the_modulus() {
    let pair = half_space().against(Body::half_space(Material::from_young(3.0, 0.4).unwrap()));
    let grid = Grid::new([48, 64], [1.0, 1.5]).unwrap();
    for (boundary, body) in
        [(Boundary::Periodic, half_space()), (Boundary::Periodic, pair), (Boundary::Free, half_space())]
    {
        let contact = Contact::with_boundary(boundary, &body, &grid, &rough([48, 64])).unwrap();
        let conductors = Conductors::new(boundary, &grid, Height::Infinite).unwrap();
        for mean in [1e-4, 0.003, 0.05] {
            let state = contact.press(Load::MeanPressure(mean)).solve().unwrap();
            let stiffness = contact.stiffness(&state, 1e-9).unwrap().value;
            let Conductance { value, error, .. } = conductors.conductance(&state.repulsion().to_owned()).unwrap();
            assert!(error <= 1e-9);
            assert_relative_eq!(value, 2.0 * stiffness / body.contact_modulus(), max_relative = 2e-9);
        }
    }
}

#[test]
fn limits_have_their_values() {
    let grid = Grid::new([32, 24], [1.0, 0.75]).unwrap();
    let heights = rough([32, 24]);
    let touching = heights.mapv(|h| if h > 0.01 { 1.0 } else { 0.0 });
    let fraction = touching.sum() / touching.len() as f64;
    let at = |height: Height| found(Boundary::Periodic, &grid, height, &touching);
    // Deep electrodes are far away, and shallow ones take the current of each point straight down: H (1/area - 1) is
    // left beside the resistance H of the bulk.
    assert_relative_eq!(at(Height::Finite(20.0)), at(Height::Infinite), max_relative = 1e-9);
    let h = 1e-5;
    assert_relative_eq!(at(Height::Finite(h)) * h * (1.0 / fraction - 1.0), 1.0, max_relative = 1e-3);
    let falling = [1e-3, 0.01, 0.1, 1.0].map(|h| at(Height::Finite(h)));
    assert!(falling.is_sorted_by(|a, b| a > b), "{falling:?}");
    // All points touch, or none.
    let (all, none) = (Array2::ones((32, 24)), Array2::zeros((32, 24)));
    for height in HEIGHTS {
        assert_eq!(found(Boundary::Periodic, &grid, height, &all), f64::INFINITY);
        assert!(found(Boundary::Free, &grid, height, &all).is_finite());
        for boundary in Boundary::ALL {
            assert_eq!(found(boundary, &grid, height, &none), 0.0);
        }
    }
    // Lengths far from one.
    for boundary in Boundary::ALL {
        for height in [Height::Infinite, Height::Finite(0.2)] {
            let far = match height {
                Height::Finite(height) => Height::Finite(1e40 * height),
                Height::Infinite => height,
            };
            let large = Grid::new([32, 24], [1e40, 0.75e40]).unwrap();
            let [near, far] = [found(boundary, &grid, height, &touching), found(boundary, &large, far, &touching)];
            assert_relative_eq!(near, 1e40 * far, max_relative = 1e-9);
        }
    }
}

#[test]
fn what_cannot_be_had_is_refused() {
    let grid = Grid::square(32, 1.0).unwrap();
    let refused = |boundary, height| Conductors::new(boundary, &grid, Height::Finite(height)).unwrap_err().to_string();
    assert!(refused(Boundary::Periodic, -1.0).contains("is -1; it must be positive and finite"));
    assert!(refused(Boundary::Free, 1e-3).contains("must be at least"));
    let conductors = Conductors::new(Boundary::Periodic, &grid, Height::Infinite).unwrap();
    let error = conductors.conductance(&Array2::ones((32, 31))).unwrap_err();
    assert!(matches!(error, ConductanceError::Shape { found: [32, 31], expected: [32, 32] }));
}
