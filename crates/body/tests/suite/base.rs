//! Moving base: comparison with the matrix of a layer with two faces, and interior fields.

use gfmd_body::{BaseField, Interior, InteriorError};
use gfmd_field::Grid;
use gfmd_green::{Base, Body, Complex64, Layer, Material};
use gfmd_response::FullResponse;

const N: usize = 15;

fn noise(n: usize, seed: usize) -> Vec<f64> {
    (0..n).map(|i| ((i as f64 + 1.0) * (0.618_033 + 1e-3 * seed as f64)).fract() - 0.5).collect()
}

fn material() -> Material {
    Material::from_young(3.0, 0.3).unwrap()
}

fn grid() -> Grid {
    Grid::new([N, N], [1.0, 1.3]).unwrap()
}

fn without_mean(mut field: Vec<f64>) -> Vec<f64> {
    for component in field.chunks_exact_mut(N * N) {
        let mean = component.iter().sum::<f64>() / (N * N) as f64;
        component.iter_mut().for_each(|value| *value -= mean);
    }
    field
}

fn near(found: &[f64], wanted: &[f64], bound: f64) {
    let scale = wanted.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    for (found, wanted) in found.iter().zip(wanted) {
        assert!((found - wanted).abs() <= bound * scale, "{found} {wanted}");
    }
}

/// Computes the outward tractions on both faces of a layer from their displacements, mode by mode.
fn tractions(layer: &Layer, top: &[f64], bottom: &[f64]) -> [Vec<f64>; 2] {
    let grid = grid();
    let transform = gfmd_field::Transform::new(grid);
    let mut ws = transform.workspace();
    let mut spectrum = |field: &[f64]| {
        let mut out = vec![Complex64::ZERO; grid.spectrum_len()];
        transform.forward(field, &mut out, &mut ws).unwrap();
        out
    };
    let faces: Vec<Vec<Complex64>> =
        top.chunks_exact(N * N).chain(bottom.chunks_exact(N * N)).map(&mut spectrum).collect();
    let mut out = vec![vec![Complex64::ZERO; grid.spectrum_len()]; 6];
    for (index, mode) in grid.modes().enumerate() {
        let matrix = layer.matrix(if mode.is_uniform() { [0.0; 2] } else { mode.wavevector });
        for (row, out) in out.iter_mut().enumerate() {
            out[index] = (0..6).map(|column| matrix[row][column] * faces[column][index]).sum();
        }
    }
    let mut ws = transform.workspace();
    let mut fields = [Vec::new(), Vec::new()];
    for (row, spectrum) in out.iter().enumerate() {
        let mut field = vec![0.0; N * N];
        transform.inverse(spectrum, &mut field, &mut ws).unwrap();
        fields[row / 3].extend(field);
    }
    fields
}

#[test]
fn the_surface_of_a_slab_on_a_moving_base_is_free_of_traction() {
    let body = Body::slab(material(), 0.4).unwrap();
    let moved = noise(3 * N * N, 1);
    let lifted = BaseField::Displacement(moved.clone()).surface_displacement(&body, grid()).unwrap();
    let layer = Layer::new(material(), 0.4).unwrap();
    let [top, bottom] = tractions(&layer, &lifted, &moved);
    let scale = bottom.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
    assert!(top.iter().all(|value| value.abs() < 1e-12 * scale));
}

#[test]
fn the_faces_of_a_plate_bear_the_given_tractions() {
    let body = Body::slab(material(), 0.4).unwrap().on(Base::FREE).unwrap();
    let given = without_mean(noise(3 * N * N, 2));
    let lifted = BaseField::Traction(given.clone()).surface_displacement(&body, grid()).unwrap();
    // The displacement of the lower face, from the same plate upside down, loaded on its top.
    let mirror = |field: &[f64]| -> Vec<f64> {
        field.iter().enumerate().map(|(k, value)| if k < 2 * N * N { *value } else { -value }).collect()
    };
    let response = FullResponse::new(grid(), &body);
    let mut lower = vec![0.0; 3 * N * N];
    response.compliance().apply(&mirror(&given), &mut lower, &mut response.workspace()).unwrap();
    let [top, bottom] = tractions(&Layer::new(material(), 0.4).unwrap(), &lifted, &mirror(&lower));
    assert!(top.iter().all(|value| value.abs() < 1e-9), "{top:?}");
    near(&bottom, &given, 1e-9);
}

#[test]
fn layers_of_one_material_are_one_slab() {
    let one = Body::slab(material(), 0.4).unwrap();
    for base in [Base::BONDED, Base::SLIDING] {
        let mut moved = noise(3 * N * N, 3);
        if base == Base::SLIDING {
            moved[..2 * N * N].fill(0.0);
        }
        let one = one.clone().on(base.clone()).unwrap();
        let two = Body::stack(&[(material(), 0.15), (material(), 0.25)], base).unwrap();
        let [one, two] =
            [one, two].map(|body| BaseField::Displacement(moved.clone()).surface_displacement(&body, grid()).unwrap());
        near(&two, &one, 1e-12);
    }
}

#[test]
fn a_base_that_moves_as_a_whole_takes_the_body_with_it() {
    let body = Body::slab(material(), 0.4).unwrap();
    let moved: Vec<f64> = (0..3 * N * N).map(|k| [0.1, -0.2, 0.3][k / (N * N)]).collect();
    let lifted = BaseField::Displacement(moved.clone()).surface_displacement(&body, grid()).unwrap();
    near(&lifted, &moved, 1e-13);
    let interior = Interior::new(&body, grid(), &lifted).unwrap().with_base(&moved).unwrap();
    let mut ws = interior.workspace();
    near(interior.displacement(0.17, &mut ws).unwrap(), &moved, 1e-13);
    assert!(interior.deformation(0.17, &mut ws).unwrap().at(3).von_mises() < 1e-13);
}

#[test]
fn a_surface_held_sideways_over_a_moving_base_is_free_of_normal_traction() {
    let (body, moved) = (Body::slab(material(), 0.4).unwrap(), noise(3 * N * N, 8));
    let held = BaseField::Displacement(moved.clone()).held_displacement(&body, grid()).unwrap();
    assert!(held[..2 * N * N].iter().all(|u| *u == 0.0));
    let interior = Interior::new(&body, grid(), &held).unwrap().with_base(&moved).unwrap();
    let mut ws = interior.workspace();
    let deformation = interior.deformation(0.0, &mut ws).unwrap();
    let stresses: Vec<[f64; 6]> = (0..N * N).map(|i| deformation.at(i).stress).collect();
    let largest = |row: usize| stresses.iter().fold(0.0, |most: f64, stress| most.max(stress[row].abs()));
    assert!(largest(2) < 1e-10 * largest(4), "{:e} {:e}", largest(2), largest(4));
    // Layers of one material are one slab.
    let stack = Body::stack(&[(material(), 0.15), (material(), 0.25)], Base::BONDED).unwrap();
    near(&BaseField::Displacement(moved).held_displacement(&stack, grid()).unwrap(), &held, 1e-12);
}

#[test]
fn inside_the_field_meets_both_faces_and_their_tractions() {
    let body = Body::slab(material(), 0.4).unwrap();
    let (surface, moved) = (noise(3 * N * N, 4), noise(3 * N * N, 5));
    let interior = Interior::new(&body, grid(), &surface).unwrap().with_base(&moved).unwrap();
    let mut ws = interior.workspace();
    near(interior.displacement(0.0, &mut ws).unwrap(), &surface, 1e-12);
    near(interior.displacement(0.4, &mut ws).unwrap(), &moved, 1e-12);
    let [top, bottom] = tractions(&Layer::new(material(), 0.4).unwrap(), &surface, &moved);
    for (depth, wanted, sign) in [(0.0, top, 1.0), (0.4, bottom, -1.0)] {
        let deformation = interior.deformation(depth, &mut ws).unwrap();
        let found: Vec<f64> = [4, 3, 2]
            .iter()
            .flat_map(|row| (0..N * N).map(|i| sign * deformation.at(i).stress[*row]).collect::<Vec<_>>())
            .collect();
        near(&found, &wanted, 1e-10);
    }
}

#[test]
fn fields_that_no_base_has_are_refused() {
    let slab = Body::slab(material(), 0.4).unwrap();
    let plate = slab.clone().on(Base::FREE).unwrap();
    let sliding = slab.clone().on(Base::SLIDING).unwrap();
    let field = || noise(3 * N * N, 1);
    let try_it = |base: BaseField, body: &Body| base.surface_displacement(body, grid()).unwrap_err();
    for body in [&plate, &Body::half_space(material())] {
        assert!(matches!(try_it(BaseField::Displacement(field()), body), InteriorError::Base { .. }));
    }
    for body in [&slab, &sliding] {
        assert!(matches!(try_it(BaseField::Traction(field()), body), InteriorError::Base { .. }));
    }
    assert!(matches!(try_it(BaseField::Traction(vec![1.0; 3 * N * N]), &plate), InteriorError::MeanTraction { .. }));
    assert!(matches!(try_it(BaseField::Displacement(field()), &sliding), InteriorError::Sideways { .. }));
    assert!(matches!(try_it(BaseField::Displacement(vec![0.0; 7]), &slab), InteriorError::Shape(_)));
    let nan = BaseField::Displacement(vec![f64::NAN; 3 * N * N]);
    assert!(matches!(try_it(nan, &slab), InteriorError::NotFinite { index: 0, .. }));
    assert!(Interior::new(&plate, grid(), &field()).unwrap().with_base(&field()).is_err());
}
