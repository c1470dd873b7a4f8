//! Fields below the surface: transfer matrices, real waves, the sticking punch, and identities.

use std::f64::consts::TAU;

use gfmd_body::{Interior, State};
use gfmd_field::Grid;
use gfmd_green::{Body, Complex64, Material};
use gfmd_response::FullResponse;
use ndarray::Array3;

use crate::check::{Worst, order};
use crate::{Check, Reference, ValidationError};

const DIGITS: &str = "boundary-value problems in 60-digit arithmetic";
const PUNCH: &str = "boundary-value problems solved numerically, mode by mode";

pub(crate) fn checks(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    let mut checks = vec![transfer(reference)?];
    checks.extend(waves(reference)?);
    checks.extend(punch(reference)?);
    checks.extend(finite_elements(reference)?);
    checks.extend(identities()?);
    checks.extend(single_modes()?);
    Ok(checks)
}

fn transfer(reference: &Reference) -> Result<Check, ValidationError> {
    let mut worst = Worst::new();
    for row in reference.table("body_transfer.json")? {
        let body = Body::slab(Material::from_young(1.0, row.get("nu"))?, row.get("zm"))?;
        let z = row.get("z");
        for section in [body.at_height(z)?, body.at_depth(row.get("zm") - z)?] {
            let t = section.displacement_transfer([0.0, row.get("q")]);
            for (name, found) in [
                ("Txx", t[1][1].re),
                ("ImTxz", t[1][2].im),
                ("ImTzx", t[2][1].im),
                ("Tzz", t[2][2].re),
                ("Ttt", t[0][0].re),
            ] {
                worst.compare(found, row.get(name));
            }
        }
    }
    Ok(worst.check("transfer into the body, per wave vector", DIGITS, 5e-14))
}

/// Displacements along x, y, z (zero along y on a line) and states at one depth.
type Plane = ([Vec<f64>; 3], Vec<State>);

fn plane(interior: &Interior, depth: f64) -> Result<Plane, ValidationError> {
    let mut ws = interior.workspace();
    let points = interior.grid().len();
    let mut displacement = [0; 3].map(|_| vec![0.0; points]);
    let found = interior.displacement(depth, &mut ws)?;
    for (&axis, component) in interior.components().axes().iter().zip(found.chunks_exact(points)) {
        displacement[axis].copy_from_slice(component);
    }
    let deformation = interior.deformation(depth, &mut ws)?;
    Ok((displacement, (0..points).map(|point| deformation.at(point)).collect()))
}

/// Checks each row of the table as a real wave on a grid with only this wave.
fn waves(reference: &Reference) -> Result<[Check; 3], ValidationError> {
    let mut worst = [Worst::new(); 3];
    for row in reference.table("body_fields.json")? {
        let (q, height) = ([row.get("qx"), row.get("qy")], row.get("zm"));
        let body = Body::slab(row.material()?, height)?;
        let lengths = q.map(|q| if q == 0.0 { 1.0 } else { TAU / q.abs() });
        let grid = Grid::new([5, 6], lengths)?;
        let [dx, dy] = grid.spacing();
        let phase = |point: usize| q[0] * (point / 6) as f64 * dx + q[1] * (point % 6) as f64 * dy;
        let wave: Vec<Complex64> = (0..grid.len()).map(|point| Complex64::cis(phase(point))).collect();
        let real = |amplitude: Complex64| wave.iter().map(move |wave| (amplitude * wave).re);
        let surface: Vec<f64> = ["us_x", "us_y", "us_z"].into_iter().flat_map(|name| real(row.complex(name))).collect();
        let (displacement, states) = plane(&Interior::new(&body, grid, &surface)?, height - row.get("z"))?;
        let mut compare = |kind: usize, names: &[&str], found: &dyn Fn(usize, usize) -> f64| {
            let scale = names.iter().map(|name| row.complex(name).norm()).fold(0.0, f64::max);
            for (k, name) in names.iter().enumerate() {
                for (point, wanted) in real(row.complex(name)).enumerate() {
                    worst[kind].compare_to(found(k, point), wanted, scale);
                }
            }
        };
        compare(0, &["ux", "uy", "uz"], &|k, point| displacement[k][point]);
        compare(1, &["exx", "eyy", "ezz", "gyz", "gxz", "gxy"], &|k, point| states[point].strain[k]);
        compare(2, &["sxx", "syy", "szz", "syz", "sxz", "sxy"], &|k, point| states[point].stress[k]);
    }
    let [displacement, strain, stress] = worst;
    Ok([
        displacement.check("displacement of a wave, as a field", DIGITS, 1e-11),
        strain.check("strain of a wave, as a field", DIGITS, 1e-11),
        stress.check("stress of a wave, as a field", DIGITS, 1e-11),
    ])
}

/// Punch of chapter 4 of the thesis: side of the cell, height of the slab, and depth.
const LENGTH: f64 = 1.27;
const DEPTH: f64 = 0.005;

fn punch_body() -> Result<Body, ValidationError> {
    Ok(Body::slab(Material::from_young(70.0, 0.33)?, LENGTH)?)
}

fn punch_field(reference: &Reference, name: &str) -> Result<Array3<f64>, ValidationError> {
    reference.array(&format!("punch3d_sticking_zm1_nu033/{name}.npy"))
}

/// Returns the array `[x, y, component]` in the order component after component.
fn components(field: Array3<f64>) -> Vec<f64> {
    field.permuted_axes([2, 0, 1]).iter().copied().collect()
}

/// Compares the plane y = Ly/2 at every eighth of 65 heights and every second point.
fn punch(reference: &Reference) -> Result<[Check; 2], ValidationError> {
    let read = |name: &str| punch_field(reference, name);
    let (body, grid) = (punch_body()?, Grid::square(128, LENGTH)?);
    let interior = Interior::new(&body, grid, &components(read("discrete_strict_u_n128")?))?;
    let (displacements, stresses) =
        (read("discrete_strict_slice_u_coarse")?, read("discrete_strict_slice_stress_coarse")?);
    let [mut displacement, mut stress] = [Worst::new(); 2];
    let largest = stresses.iter().fold(0.0, |largest: f64, s| largest.max(s.abs()));
    let middle = |i: usize| 2 * i * 128 + 64;
    for level in 0..9 {
        let (u, states) = plane(&interior, LENGTH * (1.0 - level as f64 / 8.0))?;
        for ((i, _, axis), wanted) in displacements.indexed_iter().filter(|((_, k, _), _)| *k == level) {
            displacement.compare_to(u[axis][middle(i)], *wanted, DEPTH);
        }
        // The surface is excluded: the file has derivatives along Nyquist directions there, unlike fields on a grid.
        for ((i, _, k), wanted) in stresses.indexed_iter().filter(|((_, k, _), _)| *k == level && level < 8) {
            stress.compare_to(states[middle(i)].stress[k], *wanted, largest);
        }
    }
    Ok([
        displacement.check("sticking punch: displacement on a slice, over the depth", PUNCH, 1e-8),
        stress.check("sticking punch: stress on a slice, over the largest", PUNCH, 2e-7),
    ])
}

/// Compares with finite elements of the continuum, below a punch with sharp edges, up to three quarters of the height.
/// The displacement of the surface is also from the elements, at the points of a grid, so that only the values between
/// the points near the edges differ.
fn finite_elements(reference: &Reference) -> Result<Vec<Check>, ValidationError> {
    const ELEMENTS: &str = "finite elements of high order, sharp edges";
    let coarse = below_sharp_punch(reference, 64)?;
    let fine = below_sharp_punch(reference, 128)?;
    let [u_order, s_order] = order(&[(64, coarse), (128, fine)]);
    let [u, s] = fine;
    Ok(vec![
        Check::error("sharp punch, 128 x 128: displacement below, over the depth", ELEMENTS, u, 1e-3),
        Check::error("sharp punch, 128 x 128: stress below, over the largest there", ELEMENTS, s, 3e-3),
        Check::at_least("sharp punch, 64 to 128 points: order of the displacement", ELEMENTS, u_order, 1.0),
        Check::at_least("sharp punch, 64 to 128 points: order of the stress", ELEMENTS, s_order, 1.0),
    ])
}

/// Returns the largest errors of displacement and stress on the plane y = Ly/2 of a grid with n x n points.
fn below_sharp_punch(reference: &Reference, n: usize) -> Result<[f64; 2], ValidationError> {
    let read = |name: &str| punch_field(reference, name);
    let (body, grid) = (punch_body()?, Grid::square(n, LENGTH)?);
    let interior = Interior::new(&body, grid, &components(read(&format!("continuum_u_n{n}"))?))?;
    let (displacements, stresses) = (read("continuum_slice_u_coarse")?, read("continuum_slice_stress_coarse")?);
    let [mut u_error, mut s_error, mut largest] = [0.0_f64; 3];
    for level in 0..=6 {
        let (u, states) = plane(&interior, LENGTH * (1.0 - level as f64 / 8.0))?;
        for i in 0..64 {
            let here = n / 64 * i * n + n / 2;
            for (axis, u) in u.iter().enumerate() {
                u_error = u_error.max((u[here] - displacements[[i, level, axis]]).abs());
            }
            for (k, stress) in states[here].stress.iter().enumerate() {
                let wanted = stresses[[i, level, k]];
                (s_error, largest) = (s_error.max((stress - wanted).abs()), largest.max(wanted.abs()));
            }
        }
    }
    Ok([u_error / DEPTH, s_error / largest])
}

/// Returns a rough displacement with zero mean.
fn rough(components: usize, grid: &Grid) -> Vec<f64> {
    let mut field: Vec<f64> = (1..=components * grid.len()).map(|i| (i as f64 * 0.618_033).fract()).collect();
    for component in field.chunks_exact_mut(grid.len()) {
        let mean = component.iter().sum::<f64>() / grid.len() as f64;
        component.iter_mut().for_each(|u| *u -= mean);
    }
    field
}

fn identities() -> Result<Vec<Check>, ValidationError> {
    let [mut base, mut traction, mut shear, mut work, mut far] = [Worst::new(); 5];
    for poisson in [-0.3, 0.33, 0.5] {
        let material = Material::from_young(3.0, poisson)?;
        let (slab, half_space) = (Body::slab(material, 0.5)?, Body::half_space(material));
        let grid = Grid::new([7, 9], [1.0, 1.2])?;
        let surface = rough(3, &grid);
        let interior = Interior::new(&slab, grid, &surface)?;
        for u in interior.displacement(0.5, &mut interior.workspace())? {
            base.compare_to(*u, 0.0, 1.0);
        }
        let response = FullResponse::new(grid, &slab);
        let (mut wanted, mut ws) = (surface.clone(), response.workspace());
        response.stiffness().apply(&surface, &mut wanted, &mut ws)?;
        let largest = wanted.iter().fold(0.0, |largest: f64, t| largest.max(t.abs()));
        let frictionless = Interior::frictionless(&slab, grid, &surface[2 * grid.len()..])?;
        let ((_, states), (_, smooth)) = (plane(&interior, 0.0)?, plane(&frictionless, 0.0)?);
        let normal = smooth.iter().fold(0.0, |largest: f64, state| largest.max(state.stress[2].abs()));
        for (point, (state, smooth)) in states.iter().zip(&smooth).enumerate() {
            for (k, row) in [4, 3, 2].into_iter().enumerate() {
                traction.compare_to(state.stress[row], wanted[k * grid.len() + point], largest);
            }
            for row in [3, 4] {
                shear.compare_to(smooth.stress[row], 0.0, normal);
            }
        }
        let outside = 0.5 * response.stiffness().quadratic_form(&surface, &mut ws)?;
        work.compare(energy_inside(&interior, 0.5)?, outside);
        let thick = Body::slab(material, 12.0)?;
        let [deep, endless] = [&thick, &half_space].map(|body| Interior::new(body, grid, &surface));
        let ((u, _), (v, _)) = (plane(&deep?, 0.3)?, plane(&endless?, 0.3)?);
        for (found, wanted) in u.iter().flatten().zip(v.iter().flatten()) {
            far.compare_to(*found, *wanted, 1.0);
        }
    }
    Ok(vec![
        base.check("a bonded base does not move", "identity", 0.0),
        traction.check("traction at the surface = K u", "identity", 1e-12),
        shear.check("frictionless: no shear traction", "identity", 1e-12),
        work.check("energy inside = work of the surface traction", "identity, Simpson's rule along z", 1e-8),
        far.check("a thick slab is a half-space near its surface", "limit", 1e-13),
    ])
}

/// Returns the energy ∫ ½ σ:ε dz, averaged over the plane, by Simpson's rule.
fn energy_inside(interior: &Interior, height: f64) -> Result<f64, ValidationError> {
    const STEPS: usize = 2000;
    let mut ws = interior.workspace();
    let mut sum = 0.0;
    for step in 0..=STEPS {
        let deformation = interior.deformation(height * step as f64 / STEPS as f64, &mut ws)?;
        let mean = (0..deformation.len()).map(|point| deformation.at(point).energy_density()).sum::<f64>();
        let weight = if step == 0 || step == STEPS { 1.0 } else { (2 + 2 * (step % 2)) as f64 };
        sum += weight * mean / deformation.len() as f64;
    }
    Ok(sum * height / (3 * STEPS) as f64)
}

/// Checks figures 3.9 to 3.11 of the thesis, cos(2πx) on a surface that is held sideways, in three and in two
/// dimensions, and figure 3.2, two waves that cross.
fn single_modes() -> Result<[Check; 2], ValidationError> {
    let body = Body::slab(Material::from_young(1.0, 0.33)?, 1.0)?;
    let (line, square) = (Grid::line(16, 1.0)?, Grid::square(16, 1.0)?);
    let wave = |i: usize| (TAU * i as f64 / 16.0).cos();
    let mut profile = vec![0.0; 32];
    let [mut field, mut crossed] = [0; 2].map(|_| vec![0.0; 3 * 256]);
    for i in 0..16 {
        profile[16 + i] = wave(i);
        for j in 0..16 {
            field[512 + 16 * i + j] = wave(i);
            // cos(2πx + 2πy) + cos(2πx − 2πy)
            crossed[512 + 16 * i + j] = 2.0 * wave(i) * wave(j);
        }
    }
    let (two, three) = (Interior::new(&body, line, &profile)?, Interior::new(&body, square, &field)?);
    let crossing = Interior::new(&body, square, &crossed)?;
    let [mut same, mut product] = [Worst::new(); 2];
    for depth in [0.0, 0.2, 0.5, 0.8] {
        let ((u, _), (v, _), (w, _)) = (plane(&two, depth)?, plane(&three, depth)?, plane(&crossing, depth)?);
        let section = body.at_depth(depth)?;
        let diagonal = section.displacement_transfer([TAU, TAU]);
        for i in 0..16 {
            for j in 0..16 {
                for axis in 0..3 {
                    same.compare_to(v[axis][16 * i + j], u[axis][i], 1.0);
                }
                product.compare_to(w[2][16 * i + j], diagonal[2][2].re * crossed[512 + 16 * i + j], 1.0);
            }
        }
    }
    Ok([
        same.check("figures 3.9-3.11: cos(2 pi x) in 3-D is that in 2-D", "identity", 1e-14),
        product.check("figure 3.2: two crossing waves, each with |q| = sqrt 2 times 2 pi", "identity", 1e-14),
    ])
}
