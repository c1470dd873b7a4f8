//! Relations between the fields inside every body: equilibrium, Hooke's law, the base, energy, limits.

use approx::assert_relative_eq;
use gfmd_body::{Interior, InteriorError, State};
use gfmd_field::{Grid, Transform};
use gfmd_green::{Base, Body, Complex64, Height, Material};
use gfmd_response::FullResponse;
use proptest::prelude::*;

const I: Complex64 = Complex64::I;

fn noise(n: usize, seed: usize) -> Vec<f64> {
    (0..n).map(|i| ((i as f64 + 1.0) * (0.618_033 + 1e-3 * seed as f64)).fract() - 0.5).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

fn slab(poisson: f64, height: f64) -> Body {
    Body::slab(Material::from_young(3.0, poisson).unwrap(), height).unwrap()
}

/// Computes the derivative ∂f/∂x or ∂f/∂y of a field on a grid without Nyquist modes.
fn derivative(transform: &Transform, field: &[f64], axis: usize) -> Vec<f64> {
    let grid = transform.grid();
    let mut spectrum = vec![Complex64::ZERO; grid.spectrum_len()];
    let (mut out, mut ws) = (vec![0.0; grid.len()], transform.workspace());
    transform.forward(field, &mut spectrum, &mut ws).unwrap();
    for (amplitude, mode) in spectrum.iter_mut().zip(grid.modes()) {
        *amplitude *= I * mode.wavevector[axis];
    }
    transform.inverse(&spectrum, &mut out, &mut ws).unwrap();
    out
}

/// Displacements along x, y, z (zero along y on a line) and states at one depth.
type Plane = ([Vec<f64>; 3], Vec<State>);

fn inside(interior: &Interior, depth: f64) -> Plane {
    let mut ws = interior.workspace();
    let points = interior.grid().len();
    let mut displacement = [const { Vec::new() }; 3].map(|_: Vec<f64>| vec![0.0; points]);
    let found = interior.displacement(depth, &mut ws).unwrap();
    for (&axis, component) in interior.components().axes().iter().zip(found.chunks_exact(points)) {
        displacement[axis].copy_from_slice(component);
    }
    let deformation = interior.deformation(depth, &mut ws).unwrap();
    (displacement, (0..deformation.len()).map(|i| deformation.at(i)).collect())
}

fn component(states: &[State], pick: impl Fn(&State) -> f64) -> Vec<f64> {
    states.iter().map(pick).collect()
}

#[derive(Clone, Debug)]
struct Case {
    body: Body,
    grid: Grid,
    surface: Vec<f64>,
}

fn poisson() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -0.9..0.5, 1 => Just(0.5), 1 => 0.499..0.5]
}

/// A body about as high as its cell is wide, a grid without Nyquist modes, and a rough displacement. Its mean u_z is
/// zero; on a coating, all means are zero.
fn case() -> impl Strategy<Value = Case> {
    let points = prop_oneof![Just([5, 7]), Just([7, 3]), Just([9, 1])];
    (poisson(), poisson(), 0.3..1.5, 0..5, points, 0..1000usize).prop_map(
        |(upper, lower, height, kind, points, seed)| {
            let upper = slab(upper, height);
            let body = match kind {
                0 => Body::half_space(*upper.material()),
                1 if seed % 3 == 0 => upper.on(Base::FREE).unwrap(),
                1 => upper,
                2 => upper.on(Base::SLIDING).unwrap(),
                3 => upper.bonded_to(slab(lower, 0.4)).unwrap(),
                _ => upper.bonded_to(Body::half_space(*slab(lower, 1.0).material())).unwrap(),
            };
            let grid = Grid::new(points, [1.0, 1.2]).unwrap();
            let components = if grid.is_line() { 2 } else { 3 };
            let mut surface = noise(components * grid.len(), seed);
            // The uniform shear of a coating continues without end in the half-space, and gives no displacement.
            let first = if kind == 4 { 0 } else { components - 1 };
            for component in surface[first * grid.len()..].chunks_exact_mut(grid.len()) {
                let mean = component.iter().sum::<f64>() / grid.len() as f64;
                component.iter_mut().for_each(|u| *u -= mean);
            }
            Case { body, grid, surface }
        },
    )
}

/// Points and weights of Gauss quadrature on (−1, 1).
const GAUSS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];

proptest! {
    /// Equilibrium ∂σ_ij/∂x_j = 0; strains are derivatives of the displacement; stresses follow from strains by Hooke's
    /// law.
    #[test]
    fn forces_balance_and_strains_are_compatible(case in case(), place in 0.05..0.25) {
        let Case { body, grid, surface } = case;
        let interior = Interior::new(&body, grid, &surface).unwrap();
        let transform = Transform::new(grid);
        let stiffest = grid.modes().map(|mode| mode.wavenumber()).fold(0.0, f64::max);
        let step = 2e-3 / stiffest;
        let planes = [2.0, 1.0, 0.0, -1.0, -2.0].map(|steps| inside(&interior, place - steps * step));
        let rise = |pick: &dyn Fn(&Plane) -> Vec<f64>| -> Vec<f64> {
            let [far_up, up, _, down, far_down] = planes.each_ref().map(pick);
            (0..grid.len())
                .map(|i| (8.0 * (up[i] - down[i]) - (far_up[i] - far_down[i])) / (12.0 * step))
                .collect()
        };
        let (u, states) = &planes[2];
        let stress = |k: usize| component(states, |state| state.stress[k]);
        let (scale, strain_scale) = (0..6).fold((0.0, 0.0), |(a, b): (f64, f64), k| {
            (a.max(largest(&stress(k))), b.max(largest(&component(states, |state| state.strain[k]))))
        });
        // Rows of the tensor: xx xy xz, xy yy yz, xz yz zz.
        for [x, y, z] in [[0, 5, 4], [5, 1, 3], [4, 3, 2]] {
            let along = [derivative(&transform, &stress(x), 0), derivative(&transform, &stress(y), 1)];
            let up = rise(&|plane| component(&plane.1, |state| state.stress[z]));
            for i in 0..grid.len() {
                prop_assert!((along[0][i] + along[1][i] + up[i]).abs() < 1e-9 * stiffest * scale);
            }
        }
        let d = |field: usize, axis: usize| derivative(&transform, &u[field], axis);
        let up = |field: usize| rise(&|plane| plane.0[field].clone());
        let sum = |a: Vec<f64>, b: Vec<f64>| a.iter().zip(b).map(|(a, b)| a + b).collect::<Vec<_>>();
        let strains =
            [d(0, 0), d(1, 1), up(2), sum(d(2, 1), up(1)), sum(d(2, 0), up(0)), sum(d(0, 1), d(1, 0))];
        let shear = body.material().shear_modulus();
        // Differences along z have the rounding errors of the displacement, which may be nearly uniform: their weights
        // add up to 18/12, and each displacement is a sum over waves, rounded by some 3 epsilon.
        let most = (0..3).map(|field| largest(&u[field])).fold(0.0, f64::max);
        let rounding = 1.5 * 3.0 * f64::EPSILON * most / step;
        for (k, expected) in strains.iter().enumerate() {
            for (state, expected) in states.iter().zip(expected) {
                prop_assert!((state.strain[k] - expected).abs() < 1e-9 * strain_scale + rounding, "{k}");
            }
        }
        for state in states {
            // Hooke's law for the deviators, which also holds at ν = 1/2, and for the volume.
            let [xx, yy, zz, ..] = state.stress;
            let (pressure, dilation) = ((xx + yy + zz) / 3.0, state.strain[..3].iter().sum::<f64>());
            for k in 0..3 {
                let deviator = 2.0 * shear * (state.strain[k] - dilation / 3.0);
                prop_assert!((state.stress[k] - pressure - deviator).abs() < 1e-12 * scale.max(shear * strain_scale));
                prop_assert!((state.stress[k + 3] - shear * state.strain[k + 3]).abs() < 1e-14 * scale);
            }
            let bulk_compliance = 3.0 * (1.0 - 2.0 * body.material().poisson()) / body.material().young();
            let least = 1e-12 * strain_scale.max(scale * bulk_compliance);
            prop_assert!((dilation - pressure * bulk_compliance).abs() < least);
            let squares: f64 = state.stress.iter().enumerate()
                .map(|(k, s)| if k < 3 { (s - pressure).powi(2) } else { 2.0 * s * s })
                .sum();
            prop_assert!((state.von_mises() - (1.5 * squares).sqrt()).abs() < 1e-11 * scale);
            prop_assert!(state.energy_density() >= -1e-14 * scale * strain_scale);
        }
    }

    /// At depth zero, the fields are the given displacement and the traction K u.
    #[test]
    fn the_surface_is_met_at_depth_zero(case in case()) {
        let Case { body, grid, surface } = case;
        let interior = Interior::new(&body, grid, &surface).unwrap();
        let (displacement, states) = inside(&interior, 0.0);
        let response = FullResponse::new(grid, &body);
        let mut traction = surface.clone();
        response.stiffness().apply(&surface, &mut traction, &mut response.workspace()).unwrap();
        for (k, &axis) in interior.components().axes().iter().enumerate() {
            let part = k * grid.len()..(k + 1) * grid.len();
            for (found, expected) in displacement[axis].iter().zip(&surface[part.clone()]) {
                prop_assert!((found - expected).abs() < 1e-12);
            }
            let row = [4, 3, 2][axis];
            let scale = largest(&traction);
            for (state, expected) in states.iter().zip(&traction[part]) {
                prop_assert!((state.stress[row] - expected).abs() < 1e-11 * scale);
            }
        }
    }

    /// The energy inside equals the work of the traction, ∫ ½ σ:ε dV = ½ ∫ t·u dA, integrated layer by layer.
    #[test]
    fn the_work_of_the_surface_is_the_energy_inside(case in case()) {
        let Case { body, grid, surface } = case;
        let interior = Interior::new(&body, grid, &surface).unwrap();
        let response = FullResponse::new(grid, &body);
        let work = 0.5 * response.stiffness().quadratic_form(&surface, &mut response.workspace()).unwrap();
        let mut faces = vec![0.0];
        let mut layer = Some(&body);
        while let Some(body) = layer {
            // A half-space is cut where its longest wave has decayed, 2 q·depth = 60.
            let (thickness, below) = match (body.height(), body.base()) {
                (Height::Infinite, _) => (6.0, None),
                (Height::Finite(thickness), Base::Elastic(below)) => (thickness, Some(&**below)),
                (Height::Finite(thickness), _) => (thickness, None),
            };
            faces.push(faces[faces.len() - 1] + thickness);
            layer = below;
        }
        let mut ws = interior.workspace();
        let mut energy = 0.0;
        for layer in faces.windows(2) {
            // Points are denser near the surface, where short waves decay.
            let edge = |k: usize| layer[0] + (layer[1] - layer[0]) * (k as f64 / 24.0).powi(3);
            for panel in 0..24 {
                let (middle, half) = (0.5 * (edge(panel) + edge(panel + 1)), 0.5 * (edge(panel + 1) - edge(panel)));
                for (place, weight) in GAUSS {
                    let deformation = interior.deformation(middle + half * place, &mut ws).unwrap();
                    let sum: f64 = (0..deformation.len()).map(|i| deformation.at(i).energy_density()).sum();
                    energy += weight * half * sum / grid.len() as f64;
                }
            }
        }
        prop_assert!((energy - work).abs() < 1e-8 * work, "{energy} {work}");
    }

    #[test]
    fn a_bonded_base_does_not_move(poisson in poisson(), height in 0.05..2.0, seed in 0..100usize) {
        let (body, grid) = (slab(poisson, height), Grid::new([6, 8], [1.0, 1.2]).unwrap());
        let mut surface = noise(144, seed);
        let mean = surface[96..].iter().sum::<f64>() / 48.0;
        surface[96..].iter_mut().for_each(|u| *u -= mean);
        let interior = Interior::new(&body, grid, &surface).unwrap();
        prop_assert!(interior.displacement(height, &mut interior.workspace()).unwrap().iter().all(|u| *u == 0.0));
    }
}

#[test]
fn a_thick_slab_has_the_fields_of_the_half_space() {
    let material = Material::from_young(2.0, 0.4).unwrap();
    let (half_space, thick) = (Body::half_space(material), Body::slab(material, 8.0).unwrap());
    let grid = Grid::new([8, 6], [1.0, 1.2]).unwrap();
    let mut surface = noise(3 * grid.len(), 4);
    for component in surface.chunks_exact_mut(grid.len()) {
        let mean = component.iter().sum::<f64>() / grid.len() as f64;
        component.iter_mut().for_each(|u| *u -= mean);
    }
    let [a, b] = [&half_space, &thick].map(|body| Interior::new(body, grid, &surface).unwrap());
    for depth in [0.0, 0.1, 0.5, 1.5] {
        let ((ua, sa), (ub, sb)) = (inside(&a, depth), inside(&b, depth));
        for (a, b) in ua.iter().flatten().zip(ub.iter().flatten()) {
            assert_relative_eq!(a, b, epsilon = 1e-12);
        }
        for (a, b) in sa.iter().zip(&sb) {
            for k in 0..6 {
                assert_relative_eq!(a.stress[k], b.stress[k], epsilon = 1e-10);
            }
        }
    }
}

#[test]
fn a_line_is_a_plane_of_equal_rows() {
    let body = slab(0.3, 0.7);
    let (line, plane) = (Grid::line(8, 1.0).unwrap(), Grid::new([8, 3], [1.0, 0.6]).unwrap());
    let profile = noise(16, 2);
    let mut surface = vec![0.0; 72];
    for i in 0..8 {
        surface[3 * i..][..3].fill(profile[i]);
        surface[48 + 3 * i..][..3].fill(profile[8 + i]);
    }
    let (two, three) = (Interior::new(&body, line, &profile).unwrap(), Interior::new(&body, plane, &surface).unwrap());
    for depth in [0.0, 0.3, 0.7] {
        let ((u, states), (v, all)) = (inside(&two, depth), inside(&three, depth));
        for i in 0..8 {
            for axis in 0..3 {
                assert_relative_eq!(u[axis][i], v[axis][3 * i + 1], epsilon = 1e-14);
            }
            for k in 0..6 {
                assert_relative_eq!(states[i].stress[k], all[3 * i + 1].stress[k], epsilon = 1e-12);
                assert_relative_eq!(states[i].strain[k], all[3 * i + 1].strain[k], epsilon = 1e-12);
            }
            let [xx, yy, zz, ..] = states[i].stress;
            assert_relative_eq!(yy, 0.3 * (xx + zz), epsilon = 1e-12); // plane strain
        }
    }
}

#[test]
fn without_friction_the_surface_bears_no_shear_and_the_pressure_its_compliance_says() {
    for body in [Body::half_space(Material::from_young(1.0, 0.3).unwrap()), slab(0.5, 0.2)] {
        for grid in [Grid::new([7, 9], [1.0, 1.3]).unwrap(), Grid::line(11, 1.0).unwrap()] {
            let mut normal = noise(grid.len(), 7);
            let mean = normal.iter().sum::<f64>() / grid.len() as f64;
            normal.iter_mut().for_each(|u| *u -= mean);
            let interior = Interior::frictionless(&body, grid, &normal).unwrap();
            let (u, states) = inside(&interior, 0.0);
            let scale = largest(&component(&states, |state| state.stress[2]));
            for (i, state) in states.iter().enumerate() {
                assert_relative_eq!(u[2][i], normal[i], epsilon = 1e-13);
                assert!(state.stress[3].abs() < 1e-12 * scale && state.stress[4].abs() < 1e-12 * scale);
            }
            let stiffness: Vec<f64> = gfmd_green::normal_stiffness_table(&body, &grid, 0.0);
            let (transform, mut traction) = (Transform::new(grid), vec![0.0; grid.len()]);
            transform.convolve(&stiffness, &normal, &mut traction, &mut transform.workspace()).unwrap();
            for (state, traction) in states.iter().zip(&traction) {
                assert_relative_eq!(state.stress[2], *traction, epsilon = 1e-12 * scale);
            }
        }
    }
}

#[test]
fn same_bits_for_any_thread_count() {
    let (body, grid) = (slab(0.3, 0.5), Grid::new([96, 80], [1.0, 1.0]).unwrap());
    let surface = noise(3 * grid.len(), 5);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let all = inside(&Interior::new(&body, grid, &surface).unwrap(), 0.05);
            (all, inside(&Interior::frictionless(&body, grid, &surface[..grid.len()]).unwrap(), 0.05))
        })
    };
    assert!(on(1) == on(3));
}

#[test]
fn what_cannot_be_is_refused_in_words() {
    let grid = Grid::square(4, 1.0).unwrap();
    let (plain, rubber) = (slab(0.3, 0.5), slab(0.5, 0.5));
    let error = |result: Result<Interior, InteriorError>| result.unwrap_err().to_string();
    assert_eq!(
        error(Interior::new(&plain, grid, &[0.0; 16])),
        "the displacement has 16 values; it must have 48 on this grid"
    );
    let mut surface = [0.0; 48];
    surface[20] = f64::NAN;
    assert_eq!(error(Interior::new(&plain, grid, &surface)), "the value is NaN at index 20; it must be finite");
    surface[20] = 0.0;
    surface[32..].fill(-0.25);
    let volume = "the mean of u_z is -0.25; it must be zero on incompressible layers";
    assert_eq!(error(Interior::new(&rubber, grid, &surface)), volume);
    assert_eq!(error(Interior::frictionless(&rubber, grid, &surface[32..])), volume);
    let interior = Interior::new(&plain, grid, &surface).unwrap();
    let outside = interior.displacement(0.6, &mut interior.workspace()).unwrap_err().to_string();
    assert_eq!(outside, "the depth below the surface is 0.6; it must be between 0 and 0.5");
    let other = Interior::new(&plain, Grid::square(5, 1.0).unwrap(), &[0.0; 75]).unwrap();
    assert!(matches!(interior.deformation(0.1, &mut other.workspace()), Err(InteriorError::Shape(_))));
}

/// The mean pressure passes through all layers and strains each; nothing below them moves.
#[test]
fn a_mean_pressure_strains_every_layer_on_every_base() {
    let material = |young, poisson| Material::from_young(young, poisson).unwrap();
    let grid = Grid::new([4, 6], [1.0, 1.2]).unwrap();
    let (upper, lower) = (material(2.0, 0.3), material(0.5, 0.4));
    let layers = [(upper, 0.2), (lower, 0.3)];
    for base in [Base::BONDED, Base::SLIDING, Base::FREE, Base::Elastic(Body::half_space(upper).into())] {
        let body = Body::stack(&layers, base).unwrap();
        let [_, compliance] = body.level_compliance();
        let mut surface = vec![0.0; 3 * grid.len()];
        surface[2 * grid.len()..].fill(-0.1 * compliance);
        let interior = Interior::new(&body, grid, &surface).unwrap();
        let mut ws = interior.workspace();
        for (depth, moved) in [(0.0, 1.0), (0.1, 0.5), (0.2, 0.0)] {
            let wanted = -0.1 * (moved * 0.2 * upper.p_wave_compliance() + 0.3 * lower.p_wave_compliance());
            let u = interior.displacement(depth, &mut ws).unwrap()[2 * grid.len()];
            assert!((u - wanted).abs() < 1e-15, "{depth}: {u} {wanted}");
        }
        assert!(interior.displacement(0.5, &mut ws).unwrap()[2 * grid.len()].abs() < 1e-16);
        for (material, state) in [
            (upper, interior.deformation(0.2, &mut ws).unwrap().at(3)),
            (lower, interior.deformation_below(0.2, &mut ws).unwrap().at(3)),
            (lower, interior.deformation_below(0.3, &mut ws).unwrap().at(3)),
        ] {
            let nu = material.poisson();
            for (found, wanted) in [(state.stress[2], -0.1), (state.stress[0], -0.1 * nu / (1.0 - nu))] {
                assert!((found - wanted).abs() < 1e-14, "{found} {wanted}");
            }
        }
    }
}

/// The first of two bodies is displaced according to its own compliance under the common traction.
#[test]
fn the_first_of_two_bodies_takes_its_part() {
    let material = |young, poisson| Material::from_young(young, poisson).unwrap();
    let first = slab(0.4, 0.3);
    let pair = first.clone().against(Body::slab(material(0.3, 0.2), 0.5).unwrap());
    let grid = Grid::new([6, 5], [1.0, 1.2]).unwrap();
    let traction = noise(3 * grid.len(), 2);
    let under = |body: &Body| {
        let response = FullResponse::new(grid, body);
        let mut u = vec![0.0; traction.len()];
        response.compliance().apply(&traction, &mut u, &mut response.workspace()).unwrap();
        u
    };
    let (both, alone) = (under(&pair), under(&first));
    let interior = Interior::new(&pair, grid, &both).unwrap();
    let found = interior.displacement(0.0, &mut interior.workspace()).unwrap().to_vec();
    let largest = both.iter().fold(0.0, |largest: f64, u| largest.max(u.abs()));
    for (found, alone) in found.iter().zip(&alone) {
        assert!((found - alone).abs() < 1e-13 * largest, "{found} {alone}");
    }
    assert_eq!(interior.body(), &first);
}
