//! Limits with known numbers: first yield below a sphere and a cylinder, limit load of a flat punch, full plasticity of
//! a sphere, by two fits.

use gfmd_contact::Equilibrium;
use gfmd_plasticity::ndarray::Array2;
use gfmd_plasticity::{
    Body, Budget, Cells, Fields, Grid, Hardening, Load, Material, PlasticState, PlasticStrain, YieldingContact,
};

const POISSON: f64 = 0.3;

fn material() -> Material {
    Material::from_young(1.0, POISSON).unwrap()
}

/// Returns the contact with a paraboloid, or a parabola on a line, of this radius.
fn paraboloid(grid: &Grid, radius: f64, steel: Hardening, cells: &Cells) -> YieldingContact {
    let [nx, ny] = grid.points();
    let near = |k: usize, n: usize| k.min(n - k) as f64 * grid.spacing()[0];
    let heights = Array2::from_shape_fn((nx, ny), |(i, j)| {
        let y = if ny > 1 { near(j, ny) } else { 0.0 };
        -(near(i, nx).powi(2) + y * y) / (2.0 * radius)
    });
    YieldingContact::new(&Body::half_space(material()), grid, &heights, &[Some(steel)], cells).unwrap()
}

/// Returns the largest equivalent stress below an elastic contact.
fn largest_stress(contact: &YieldingContact, load: Load) -> f64 {
    let yield_stress = contact.rest().unwrap();
    let elastic = contact.contact().press(load).tolerance(1e-9).solve().unwrap();
    let none: &PlasticStrain = &yield_stress.plastic;
    let state: PlasticState = contact.certify(&yield_stress, &elastic.pressure, none, load).unwrap();
    1e-6 * (1.0 + state.residual.yielding)
}

/// Yield stress so low that every contact exceeds it.
fn soft() -> Hardening {
    Hardening::new(1e-6).unwrap()
}

#[test]
fn a_sphere_yields_first_at_the_pressure_of_the_closed_form() {
    // Without periodic images p0/Y = 1.61 (Hertz, von Mises, a Poisson's ratio of 0.3).
    let e_star = material().contact_modulus();
    let found = [8, 12].map(|part| {
        let grid = Grid::square(12 * part, 1.0).unwrap();
        let (radius, a) = (1.0, 1.0 / part as f64);
        let contact = paraboloid(&grid, radius, soft(), &Cells::default());
        let stress = largest_stress(&contact, Load::MeanPressure(4.0 / 3.0 * e_star * a.powi(3) / radius));
        2.0 * e_star * a / (std::f64::consts::PI * radius) / stress
    });
    // The images act by the square of the radius divided by their distance.
    let [coarse, fine] = found;
    let alone = fine + (fine - coarse) / ((12.0_f64 / 8.0).powi(2) - 1.0);
    assert!((alone - 1.61).abs() < 0.015, "{found:?}, {alone}");
}

#[test]
fn a_cylinder_yields_first_at_the_pressure_of_the_closed_form() {
    // p0/Y = 1.79 in plane strain.
    let e_star = material().contact_modulus();
    let found = [16, 32].map(|part| {
        let grid = Grid::line(24 * part, 1.0).unwrap();
        let (radius, a) = (1.0, 1.0 / part as f64);
        let cells = Cells::Graded { thickness: 0.5, growth: 1.06, coarsening: 0.0 };
        let contact = paraboloid(&grid, radius, soft(), &cells);
        let load = std::f64::consts::PI * e_star * a * a / (4.0 * radius);
        e_star * a / (2.0 * radius) / largest_stress(&contact, Load::MeanPressure(load))
    });
    // The images act by the width divided by their distance.
    let alone = 2.0 * found[1] - found[0];
    assert!((alone - 1.79).abs() < 0.015, "{found:?}, {alone}");
}

#[test]
fn a_flat_punch_has_the_limit_load_of_prandtl() {
    let (n, width) = (128, 9);
    let grid = Grid::line(n, 1.0).unwrap();
    let heights = Array2::from_shape_fn((n, 1), |(i, _)| if i.min(n - i) <= width / 2 { 0.0 } else { -1.0 });
    // Graded to three widths.
    let (mut thicknesses, depth) = (vec![0.5 / n as f64], 3.0 * width as f64 / n as f64);
    while thicknesses.iter().sum::<f64>() < depth {
        thicknesses.push(1.06 * thicknesses[thicknesses.len() - 1]);
    }
    let cells = Cells::List { thicknesses, coarsenings: Vec::new() };
    let ideal = Hardening::new(1e-3).unwrap();
    let contact = YieldingContact::new(&Body::half_space(material()), &grid, &heights, &[Some(ideal)], &cells).unwrap();
    let budget = Budget { tolerance: 1e-5, max_iterations: 20_000 };
    let mut state = contact.rest().unwrap();
    let mut means = Vec::new();
    for approach in [1e-4, 2e-4, 3.5e-4, 5e-4, 7.5e-4, 1e-3, 1.5e-3, 2e-3] {
        state = contact.step(&state, Load::Approach(approach), &budget, &mut ()).unwrap();
        means.push(state.mean_pressure() * n as f64 / width as f64 / 1e-3);
    }
    // 2 + π in units of the shear strength, and (2 + π)/√3 of the yield stress. The punch approaches it from below.
    let prandtl = (2.0 + std::f64::consts::PI) / 3.0_f64.sqrt();
    let [.., before, last] = means[..] else { panic!("no steps") };
    assert!(last < prandtl && last > 0.985 * prandtl, "{means:?} {prandtl}");
    assert!(last - before < 0.005 * prandtl, "{means:?}");
}

#[test]
fn a_sphere_becomes_fully_plastic_as_the_fits_of_finite_elements_say() {
    // Kogut and Etsion (2002) for spheres of an ideally plastic material: load and area beyond 6 times the interference
    // at first yield, of exponents 1.263 and 1.146. Other fits differ from theirs by a tenth.
    let (yield_stress, radius) = (2e-3, 1.0);
    let e_star = material().contact_modulus();
    let hardness = 2.8 * yield_stress;
    let strength = 0.454 + 0.41 * POISSON;
    let first = (std::f64::consts::PI * strength * hardness / (2.0 * e_star)).powi(2) * radius;
    let load_at_first = 4.0 / 3.0 * e_star * (radius * first.powi(3)).sqrt();
    let interference = |times: f64| (times / 1.4_f64).powf(1.0 / 1.263);
    let area = |times: f64| std::f64::consts::PI * radius * first * 0.94 * interference(times).powf(1.146);
    let loads = [10.0, 25.0, 50.0, 100.0];
    let grid = Grid::square(64, 5.0 * (area(100.0) / std::f64::consts::PI).sqrt()).unwrap();
    let contact = paraboloid(&grid, radius, Hardening::new(yield_stress).unwrap(), &Cells::default());
    let cell = grid.lengths()[0].powi(2);
    let mut state = contact.rest().unwrap();
    let budget = Budget { tolerance: 1e-6, max_iterations: 5000 };
    for times in loads {
        let load = times * load_at_first;
        state = contact.step(&state, Load::MeanPressure(load / cell), &budget, &mut ()).unwrap();
        let found = state.mean_pressure() / state.summary().area_fraction / yield_stress;
        let fit = load / area(times) / yield_stress;
        assert!((found - fit).abs() < 0.1 * fit, "{times}: {found} {fit}");
        assert!(state.operators < 200, "{times}: {} operators", state.operators);
    }
}

/// Load on a sphere and its area at an interference, as fitted by Jackson and Green (2005) to finite elements of an
/// ideally plastic material: a hardness that falls as the contact grows beside the radius.
fn jackson_green(interference: f64, radius: f64, yield_stress: f64) -> [f64; 2] {
    let e_star = material().contact_modulus();
    let per_yield = 1.295 * (0.736 * POISSON).exp();
    let strain = yield_stress / e_star;
    let first = (std::f64::consts::PI * per_yield * strain / 2.0).powi(2) * radius;
    let load_at_first = 4.0 / 3.0 * e_star * (radius * first.powi(3)).sqrt();
    let times = interference / first;
    let growth = (times / 1.9).max(1.0).powf(0.14 * (23.0 * strain).exp());
    let a = (interference / radius * growth).sqrt();
    let hardness = 2.84 * (1.0 - (-0.82 * a.powf(-0.7)).exp());
    let elastic = (-0.25 * times.powf(5.0 / 12.0)).exp() * times.powf(1.5);
    let plastic = 4.0 * hardness / per_yield * (1.0 - (-times.powf(5.0 / 9.0) / 25.0).exp()) * times;
    [load_at_first * (elastic + plastic), std::f64::consts::PI * (a * radius).powi(2)]
}

#[test]
fn a_sphere_pressed_in_carries_the_load_of_jackson_and_green() {
    let (yield_stress, radius, length) = (4e-3, 1.0, 1.0);
    let e_star = material().contact_modulus();
    let grid = Grid::square(64, length).unwrap();
    let contact = paraboloid(&grid, radius, Hardening::new(yield_stress).unwrap(), &Cells::default());
    // Multiples of the load at first yield, as Kogut and Etsion define it.
    let strength = (0.454 + 0.41 * POISSON) * 2.8 * yield_stress;
    let first = (std::f64::consts::PI * strength / (2.0 * e_star)).powi(2) * radius;
    let load_at_first = 2.0 / 3.0 * std::f64::consts::PI * strength * first * radius;
    // The mean level of the surface lies below the level far from one sphere: the sum over the images of a point force
    // on a square lattice, less the mean, is −3.900 divided by the side.
    let level = 3.900_26 / (std::f64::consts::PI * e_star * length);
    let budget = Budget { tolerance: 1e-6, max_iterations: 5000 };
    let mut state = contact.rest().unwrap();
    for times in [25.0, 50.0, 100.0, 200.0, 350.0] {
        let load = times * load_at_first;
        state = contact.step(&state, Load::MeanPressure(load / length.powi(2)), &budget, &mut ()).unwrap();
        let [fit, area] = jackson_green(state.approach() + level * load, radius, yield_stress);
        let found = load / fit;
        assert!((0.9..0.98).contains(&found), "{times}: load {found} of the fit");
        // A contact at a smaller load has fewer than 40 points, many of them on its rim.
        let found = state.summary().area_fraction * length.powi(2) / area;
        assert!(times < 100.0 || (found - 1.0).abs() < 0.05, "{times}: area {found} of the fit");
    }
}
