//! All components of a non-periodic patch.

use std::sync::Arc;

use gfmd_field::Grid;
use gfmd_green::{Body, GreenError, Material};
use gfmd_response::{FreeFullCompliance, FreeFullTransforms, FullResponse, FullTransforms};

/// Far from the ends of a wide cell, the surroundings of the patch do not matter if the tractions have neither force
/// nor moment. A periodic surface has bands of waves in place of cells, which differ little for smooth tractions.
#[test]
fn smooth_tractions_without_force_move_a_patch_as_a_wide_periodic_surface() {
    let (n, wide) = (40, 240);
    let material = Material::from_young(1.0, 0.1).unwrap();
    for body in [
        Body::half_space(material),
        Body::half_space(material).against(Body::half_space(Material::from_young(3.0, 0.45).unwrap())),
    ] {
        let [patch, cell] = [n, wide].map(|n| Grid::new([n, n], [n as f64, 1.2 * n as f64]).unwrap());
        let mut free = FreeFullTransforms::of(&FreeFullCompliance::new(patch, &body).unwrap().into());
        let mut periodic = FullTransforms::of(&FullResponse::new(cell, &body).into());
        // The fourth difference of a bump along x, and the second along y.
        let bump = |i: f64, j: f64| (-(i * i + j * j) / 16.0).exp();
        let traction = |i: f64, j: f64| {
            let along = |j: f64| bump(i - 6.0, j) - 2.0 * bump(i, j) + bump(i + 6.0, j);
            along(j - 6.0) - 2.0 * along(j) + along(j + 6.0)
        };
        for loaded in 0..3 {
            let field = |n: usize| {
                let middle = |i: usize| i as f64 - n as f64 / 2.0;
                let mut all = vec![0.0; 3 * n * n];
                for (at, value) in all[loaded * n * n..][..n * n].iter_mut().enumerate() {
                    *value = traction(middle(at / n), middle(at % n));
                }
                all
            };
            let (mut found, mut wanted) = (vec![0.0; 3 * n * n], vec![0.0; 3 * wide * wide]);
            free.compliance(&field(n), &mut found);
            periodic.compliance(&field(wide), &mut wanted);
            let largest = wanted.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
            for component in 0..3 {
                for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                    let [i_wide, j_wide] = [i, j].map(|k| k + wide / 2 - n / 2);
                    let u = found[(component * n + i) * n + j];
                    let v = wanted[(component * wide + i_wide) * wide + j_wide];
                    assert!((u - v).abs() < 0.02 * largest, "{loaded} {component} {i} {j}: {u} {v}");
                }
            }
        }
    }
}

#[test]
fn the_matrix_is_symmetric_and_a_line_is_refused() {
    let material = Material::from_young(2.0, 0.2).unwrap();
    let body = Body::half_space(material);
    let grid = Grid::new([5, 4], [1.0, 0.7]).unwrap();
    let response = Arc::new(FreeFullCompliance::new(grid, &body).unwrap());
    let size = 3 * grid.len();
    let matrix: Vec<Vec<f64>> = (0..size).map(|k| column_of(&response, k)).collect();
    for (i, j) in (0..size).flat_map(|i| (0..i).map(move |j| (i, j))) {
        assert!((matrix[i][j] - matrix[j][i]).abs() < 1e-14, "{i} {j}");
    }
    let traction: Vec<f64> = (0..2 * grid.len()).map(|i| (0.7 * i as f64).sin()).collect();
    let (mut lateral, mut all) = (vec![0.0; 2 * grid.len()], vec![0.0; size]);
    let mut transforms = FreeFullTransforms::of(&response);
    transforms.lateral_compliance(&traction, &mut lateral);
    transforms.compliance(&[&traction[..], &vec![0.0; grid.len()]].concat(), &mut all);
    assert_eq!(lateral, all[..2 * grid.len()]);
    // At the centre of a square cell, G_xx is (1 − ν/2)/(1 − ν) times G_zz.
    let square = FreeFullCompliance::new(Grid::square(3, 1.0).unwrap(), &body).unwrap().into();
    let [xx, zz] = [4, 2 * 9 + 4].map(|k| column_of(&square, k)[k]);
    assert!((xx / zz - 0.9 / 0.8).abs() < 1e-14);
    let line = Grid::line(8, 1.0).unwrap();
    assert_eq!(FreeFullCompliance::new(line, &body).err(), Some(GreenError::LineShear));
}

fn column_of(response: &Arc<FreeFullCompliance>, k: usize) -> Vec<f64> {
    let size = 3 * response.grid().len();
    let (mut unit, mut out) = (vec![0.0; size], vec![0.0; size]);
    unit[k] = 1.0;
    FreeFullTransforms::of(response).compliance(&unit, &mut out);
    out
}

/// A cell with a stiffness has the compliance of the patch between the points of the patch, whatever its size.
#[test]
fn a_cell_around_a_patch_displaces_it_alike_and_has_a_stiffness() {
    let material = |poisson: f64| Material::from_young(2.0, poisson).unwrap();
    let slab = Body::slab(material(0.3), 0.3).unwrap();
    let two = Body::half_space(material(0.1)).against(slab.clone());
    // The two last bodies need three times the points.
    for (body, points, times) in [
        (Body::half_space(material(0.5)), [6, 5], 2),
        (Body::half_space(material(0.0)), [16, 4], 2),
        (slab, [7, 5], 2),
        (two, [5, 7], 2),
        (Body::half_space(material(-0.5)), [4, 16], 3),
        (Body::half_space(material(-0.95)), [16, 16], 3),
    ] {
        let patch = Grid::new(points, points.map(|n| 0.1 * n as f64)).unwrap();
        let response = Arc::new(FullResponse::of_patch(&patch, &body).unwrap());
        let cell = *response.grid();
        assert_eq!(cell.points(), patch.padded_to(times).unwrap().points(), "{body:?}");
        let place = |k: usize| {
            let (c, i) = (k / patch.len(), k % patch.len());
            c * cell.len() + i / points[1] * cell.points()[1] + i % points[1]
        };
        let direct = Arc::new(FreeFullCompliance::new(patch, &body).unwrap());
        for k in [0, patch.len() / 2, patch.len() + 1, 3 * patch.len() - 1] {
            let (mut traction, mut around) = (vec![0.0; 3 * cell.len()], vec![0.0; 3 * cell.len()]);
            traction[place(k)] = 1.0;
            let mut transforms = FullTransforms::of(&response);
            transforms.compliance(&traction, &mut around);
            let wanted = column_of(&direct, k);
            let largest = wanted.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
            for (at, wanted) in wanted.iter().enumerate() {
                assert!((around[place(at)] - wanted).abs() < 1e-13 * largest, "{body:?} {k} {at}");
            }
            let mut back = vec![0.0; traction.len()];
            transforms.stiffness(&around, &mut back);
            let apart = back.iter().zip(&traction).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            assert!(apart < 1e-10, "{body:?} {k}: {apart}");
        }
        let [softest, stiffest] = response.stiffness_range();
        assert!(softest > 0.0 && softest < stiffest && stiffest < 100.0 * body.contact_modulus());
    }
    let narrow = Grid::new([64, 8], [8.0, 1.0]).unwrap();
    let refused = FullResponse::of_patch(&narrow, &Body::half_space(material(-0.95))).unwrap_err();
    assert!(matches!(refused, GreenError::PatchStiffness { least, .. } if least < 0.0), "{refused}");
    let line = Grid::line(8, 1.0).unwrap();
    assert_eq!(FullResponse::of_patch(&line, &Body::half_space(material(0.3))).err(), Some(GreenError::LineShear));
}
