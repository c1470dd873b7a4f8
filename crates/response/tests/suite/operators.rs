//! Comparison of the operators with the matrices of single modes, and with each other.

use std::sync::Arc;

use approx::assert_relative_eq;
use gfmd_field::{Grid, Rows, Share, Transform};
use gfmd_green::{Base, Body, Material};
use gfmd_response::{
    Components, FullResponse, FullTransforms, Hermitian, NormalResponse, NormalTransforms, RoundedTransforms, Scattered,
};
use gfmd_vector::ThreadRanks;
use proptest::prelude::*;
use rayon::prelude::*;

fn noise(n: usize, seed: u64) -> Vec<f64> {
    (0..n).map(|i| ((i as f64 + 1.0) * (0.618_033 + 1e-3 * seed as f64)).fract() - 0.5).collect()
}

fn bodies() -> [Body; 8] {
    let material = |poisson| Material::from_young(3.0, poisson).unwrap();
    [
        Body::half_space(material(0.3)),
        Body::slab(material(0.45), 0.3).unwrap(),
        Body::slab(material(0.5), 0.05).unwrap(),
        Body::slab(material(-0.4), 2.0).unwrap(),
        Body::slab(material(0.3), 0.2).unwrap().on(Base::SLIDING).unwrap(),
        Body::slab(material(0.3), 0.4).unwrap().on(Base::FREE).unwrap(),
        Body::slab(material(0.5), 0.1).unwrap().bonded_to(Body::half_space(material(0.2))).unwrap(),
        Body::slab(material(0.1), 0.1).unwrap().against(Body::slab(material(0.4), 0.3).unwrap()),
    ]
}

fn grids() -> [Grid; 5] {
    [
        Grid::new([12, 10], [1.0, 1.3]).unwrap(),
        Grid::new([9, 8], [1.0, 1.3]).unwrap(),
        Grid::new([7, 5], [2.0, 1.0]).unwrap(),
        Grid::line(16, 1.0).unwrap(),
        Grid::line(9, 1.0).unwrap(),
    ]
}

#[test]
fn lateral_tractions_have_the_lateral_displacement_of_all_components() {
    for grid in grids() {
        for body in bodies() {
            let response = Arc::new(FullResponse::new(grid, &body));
            let lateral = (response.components().len() - 1) * grid.len();
            let mut traction = noise(lateral + grid.len(), 1);
            traction[lateral..].fill(0.0);
            let mut transforms = FullTransforms::of(&response);
            let (mut all, mut found) = (traction.clone(), vec![0.0; lateral]);
            transforms.compliance(&traction, &mut all);
            let pairs = transforms.pairs();
            transforms.lateral_compliance(&traction[..lateral], &mut found);
            assert_eq!(found, all[..lateral], "{grid:?} {body:?}");
            assert_eq!(transforms.pairs() - pairs, pairs - 1.0);
        }
    }
}

fn without_means(field: &mut [f64], points: usize) {
    for component in field.chunks_exact_mut(points) {
        let mean = component.iter().sum::<f64>() / points as f64;
        component.iter_mut().for_each(|value| *value -= mean);
    }
}

#[test]
fn compliance_undoes_stiffness_on_every_grid_and_body() {
    for grid in grids() {
        for body in bodies() {
            let response = FullResponse::new(grid, &body);
            let mut ws = response.workspace();
            let mut displacement = noise(response.components().len() * grid.len(), 0);
            without_means(&mut displacement, grid.len());
            let (mut traction, mut back) = (displacement.clone(), displacement.clone());
            response.stiffness().apply(&displacement, &mut traction, &mut ws).unwrap();
            response.compliance().apply(&traction, &mut back, &mut ws).unwrap();
            for (back, u) in back.iter().zip(&displacement) {
                assert_relative_eq!(back, u, epsilon = 1e-11);
            }
            // U = ½⟨u, K u⟩ from modes and from points.
            let by_modes = response.stiffness().quadratic_form(&displacement, &mut ws).unwrap();
            let by_points = displacement.iter().zip(&traction).map(|(u, t)| u * t).sum::<f64>() / grid.len() as f64;
            assert_relative_eq!(by_modes, by_points, max_relative = 1e-12);
            assert!(by_modes > 0.0);
        }
    }
}

#[test]
fn frictionless_pressure_moves_the_surface_as_the_normal_response_says() {
    // With odd numbers of points there are no Nyquist modes, and both agree in every mode (theory.md, section 0).
    let grid = Grid::new([9, 7], [1.0, 1.1]).unwrap();
    for body in bodies() {
        let (full, normal) = (FullResponse::new(grid, &body), Arc::new(NormalResponse::new(grid, &body)));
        let mut pressure = noise(grid.len(), 3);
        without_means(&mut pressure, grid.len());
        let mut traction = vec![0.0; 3 * grid.len()];
        traction[2 * grid.len()..].copy_from_slice(&pressure);
        let (mut displacement, mut normal_displacement) = (vec![0.0; 3 * grid.len()], vec![0.0; grid.len()]);
        full.compliance().apply(&traction, &mut displacement, &mut full.workspace()).unwrap();
        let mut transforms = NormalTransforms::of(&normal);
        transforms.convolve(normal.compliance(), &pressure, &mut normal_displacement);
        assert_eq!(transforms.pairs(), 1.0);
        for (full, normal) in displacement[2 * grid.len()..].iter().zip(&normal_displacement) {
            assert_relative_eq!(full, normal, epsilon = 1e-13);
        }
    }
}

#[test]
fn a_line_is_a_plane_with_one_row() {
    let body = &bodies()[1];
    let (line, plane) = (Grid::line(12, 1.0).unwrap(), Grid::new([12, 3], [1.0, 0.7]).unwrap());
    let (two, three) = (FullResponse::new(line, body), FullResponse::new(plane, body));
    assert_eq!((two.components(), three.components()), (Components::Plane, Components::Space));
    let profile = noise(24, 1);
    let mut traction = vec![0.0; 24];
    two.stiffness().apply(&profile, &mut traction, &mut two.workspace()).unwrap();
    let mut field = vec![0.0; 3 * 36];
    for (component, values) in [0, 2].into_iter().zip(profile.chunks_exact(12)) {
        for (i, value) in values.iter().enumerate() {
            field[component * 36 + 3 * i..][..3].fill(*value);
        }
    }
    let mut out = vec![0.0; 3 * 36];
    three.stiffness().apply(&field, &mut out, &mut three.workspace()).unwrap();
    for (component, values) in [0, 2].into_iter().zip(traction.chunks_exact(12)) {
        for (i, value) in values.iter().enumerate() {
            assert_relative_eq!(out[component * 36 + 3 * i], *value, epsilon = 1e-12);
        }
    }
    assert!(out[36..72].iter().all(|t| t.abs() < 1e-12));
}

#[test]
fn same_bits_for_any_thread_count() {
    let grid = Grid::new([128, 96], [1.0, 1.0]).unwrap();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let response = FullResponse::new(grid, &bodies()[0]);
            let mut ws = response.workspace();
            let field = noise(3 * grid.len(), 2);
            let mut out = vec![0.0; field.len()];
            response.stiffness().apply(&field, &mut out, &mut ws).unwrap();
            (out, response.stiffness().quadratic_form(&field, &mut ws).unwrap())
        })
    };
    assert!(on(1) == on(3));
}

#[test]
fn means_that_do_not_answer_are_told() {
    let [half_space, slab, rubber, _, sliding, plate, coated, _] = bodies();
    let grid = Grid::square(4, 1.0).unwrap();
    assert_eq!(FullResponse::new(grid, &half_space).uniform_compliance(), [0.0; 3]);
    assert!(FullResponse::new(grid, &slab).uniform_compliance().iter().all(|g| *g > 0.0));
    let [x, _, z] = FullResponse::new(grid, &rubber).uniform_compliance();
    assert!(x > 0.0 && z == 0.0);
    // A base that does not hold a body is the reference of its layers.
    for body in [sliding, plate] {
        let bonded = Body::new(*body.material(), body.height()).unwrap();
        let [found, wanted] = [&body, &bonded].map(|body| FullResponse::new(grid, body).uniform_compliance());
        assert_eq!(found, wanted);
        assert_eq!(NormalResponse::new(grid, &body).uniform_compliance(), wanted[2]);
    }
    let [x, _, z] = FullResponse::new(grid, &coated).uniform_compliance();
    assert!(x > 0.0 && z == 0.0);
}

#[test]
fn a_field_of_the_wrong_length_is_refused() {
    let response = FullResponse::new(Grid::square(4, 1.0).unwrap(), &bodies()[0]);
    let error = response.stiffness().apply(&[0.0; 16], &mut [0.0; 48], &mut response.workspace()).unwrap_err();
    assert_eq!(error.to_string(), "the field has 16 values; it must have 48 on this grid");
}

proptest! {
    #[test]
    fn the_inverse_of_a_matrix_is_its_inverse(entries in prop::array::uniform6(-1.0..1.0_f64), shift in 2.5..5.0_f64) {
        let [xx, yy, zz, xy, xz, yz] = entries;
        let m = Hermitian { xx: xx + shift, yy: yy + shift, zz: zz + shift, xy, xz, yz };
        // With u_z = i w the matrices are real and symmetric.
        let real = |m: Hermitian| [[m.xx, m.xy, -m.xz], [m.xy, m.yy, -m.yz], [-m.xz, -m.yz, m.zz]];
        let (a, b) = (real(m), real(m.inverse()));
        for (i, row) in a.iter().enumerate() {
            // The rows of a symmetric matrix are its columns.
            for (j, column) in b.iter().enumerate() {
                let product: f64 = row.iter().zip(column).map(|(a, b)| a * b).sum();
                prop_assert!((product - f64::from(u8::from(i == j))).abs() < 1e-12, "{:?}", m);
            }
        }
    }
}

#[test]
fn the_modes_of_a_matrix_are_its_eigenvectors() {
    let spread = |i: u32| (0.618_034 * f64::from(i)).fract() - 0.5;
    for i in 0..200 {
        let [xx, yy, zz, xy, xz, yz] = [0, 1, 2, 3, 4, 5].map(|k| spread(6 * i + k));
        let matrix = Hermitian { xx, yy, zz, xy, xz, yz };
        let modes = matrix.modes();
        assert!(modes.is_sorted_by(|a, b| a.0 <= b.0));
        for (k, [a, b, c]) in modes {
            // K (a, b, i c), with the factor i of the last row taken out.
            let image = [xx * a + xy * b - xz * c, xy * a + yy * b - yz * c, zz * c - xz * a - yz * b];
            assert!(image.iter().zip([a, b, c]).all(|(x, u)| (x - k * u).abs() < 1e-14), "{matrix:?} {k}");
            assert!((a * a + b * b + c * c - 1.0).abs() < 1e-14);
        }
        assert!((modes.iter().map(|m| m.0).sum::<f64>() - (xx + yy + zz)).abs() < 1e-14);
        let same = matrix.function(|k| k);
        let difference = same + matrix.map(|entry| -entry);
        let Hermitian { xx, yy, zz, xy, xz, yz } = difference;
        assert!([xx, yy, zz, xy, xz, yz].iter().all(|entry| entry.abs() < 1e-14), "{difference:?}");
    }
}

/// A table is built in parallel at first use. A thread that waits for parts of the table may start a task that needs
/// the same table; it must not wait for itself.
#[test]
fn tasks_that_ask_for_a_table_at_once_do_not_wait_for_one_another() {
    let grid = Grid::square(96, 1.0).unwrap();
    let body = Body::half_space(Material::from_contact_modulus(1.0, 0.3).unwrap());
    let pool = rayon::ThreadPoolBuilder::new().num_threads(8).build().unwrap();
    let (done, ended) = std::sync::mpsc::channel();
    std::thread::spawn(move || {
        for _ in 0..1000 {
            let response = Arc::new(NormalResponse::new(grid, &body));
            let last = response.stiffness_range()[1];
            pool.install(|| {
                (0..64).into_par_iter().for_each(|_| {
                    let largest = response.stiffness().iter().copied().fold(0.0, f64::max);
                    assert!((largest / last - 1.0).abs() < 1e-12);
                    drop(RoundedTransforms::of(&response, None));
                });
            });
        }
        done.send(()).unwrap();
    });
    ended.recv_timeout(std::time::Duration::from_secs(60)).expect("the tasks end");
}

#[test]
fn the_normal_part_of_all_components_displaces_as_they_do() {
    for grid in grids() {
        for body in bodies() {
            let full = Arc::new(FullResponse::new(grid, &body));
            let normal = Arc::new(NormalResponse::of_all_components(&full));
            let (n, components) = (grid.len(), full.components().len());
            let pressure = noise(n, 4);
            let traction: Vec<f64> = [vec![0.0; (components - 1) * n], pressure.clone()].concat();
            let (mut all, mut found) = (vec![0.0; components * n], vec![0.0; n]);
            FullTransforms::of(&full).compliance(&traction, &mut all);
            let mut transforms = NormalTransforms::of(&normal);
            transforms.convolve(normal.compliance(), &pressure, &mut found);
            let sunk = normal.uniform_compliance() * pressure.iter().sum::<f64>() / n as f64;
            let largest = found.iter().fold(sunk.abs(), |most: f64, u| most.max(u.abs()));
            for (found, all) in found.iter().zip(&all[(components - 1) * n..]) {
                assert_relative_eq!(found + sunk, *all, epsilon = 1e-13 * largest);
            }

            // The other tables follow from the compliance.
            let waves = || normal.compliance().iter().zip(normal.stiffness()).enumerate().skip(1);
            for (index, (compliance, stiffness)) in waves() {
                assert_relative_eq!(compliance * stiffness, 1.0, max_relative = 1e-14);
                assert!(normal.compliance_at(index) == *compliance);
            }
            assert!(normal.compliance()[0] == 0.0 && normal.stiffness()[0] == 0.0);
            let [softest, stiffest] = normal.stiffness_range();
            assert!(waves().all(|(_, (_, k))| (softest * (1.0 - 1e-14)..=stiffest * (1.0 + 1e-14)).contains(k)));
            assert_eq!(normal.contact_modulus(), full.contact_modulus());
            let mut rounded = RoundedTransforms::of(&normal, None);
            let unit = rounded.unit();
            let mut image = vec![0.0_f32; n];
            rounded.compliance(Rows(&pressure[..], grid.rows()[1]), |_, Rows(p, _), row: &mut [f32]| {
                row.iter_mut().zip(p).for_each(|(row, p)| *row = *p as f32);
            });
            rounded.rows(Rows(&mut image[..], grid.rows()[1]), |_, row, Rows(image, _): Rows<&mut [f32]>| {
                image.copy_from_slice(row);
            });
            for (image, found) in image.iter().zip(&found) {
                assert_relative_eq!(f64::from(*image) * unit, *found, epsilon = 1e-5 * largest);
            }

            // Only Nyquist modes differ from the response of u_z alone, and only for bodies that couple it with shear.
            let alone = NormalResponse::new(grid, &body);
            for (index, (compliance, other)) in normal.compliance().iter().zip(alone.compliance()).enumerate() {
                if grid.mode_at(index).nyquist == [false, false] {
                    assert_relative_eq!(*compliance, *other, max_relative = 1e-11);
                }
            }
        }
    }
}

#[test]
fn operators_over_ranks_have_the_bits_of_one_process() {
    let grid = Grid::new([128, 64], [1.0, 0.6]).unwrap();
    let n = grid.len();
    let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<u64>>();
    for body in bodies() {
        let field = noise(3 * n, 6);
        // All components of the rows of a share: traction, energy, and the normal compliance of all modes.
        let found = |share: &Share| {
            let own: Vec<f64> = field.chunks_exact(n).flat_map(|component| &component[share.own()]).copied().collect();
            let full = FullResponse::distributed(grid, &body, share);
            let (mut out, mut ws) = (vec![0.0; own.len()], full.workspace());
            full.stiffness().apply(&own, &mut out, &mut ws).unwrap();
            let energy = full.stiffness().quadratic_form(&own, &mut ws).unwrap();
            let normal = NormalResponse::of_all_components(&full);
            let mut compliances: Vec<f64> = (0..grid.spectrum_len()).map(|index| normal.compliance_at(index)).collect();
            // Modes that are changed one by one are known to all processes along x and along y.
            let [lanes, positions] = grid.spectrum_shape();
            let modes = normal.compliance().len();
            let first = Transform::<f64>::distributed(grid, share).lanes().start * positions;
            let factors: Vec<f64> = (first..first + modes).map(|index| 1.0 + 0.01 * (index % 7) as f64).collect();
            let changed = normal.stiffened(&factors).softened(0.3);
            compliances.push(changed.uniform_compliance());
            compliances.extend((0..positions).map(|index| changed.compliance_at(index)));
            compliances.extend((0..lanes).map(|lane| changed.compliance_at(lane * positions)));
            let numbers = [energy, normal.stiffness_range()[0], normal.stiffness_range()[1]];
            let rows = share.own().len();
            (out.chunks_exact(rows).map(bits).collect::<Vec<_>>(), bits(&numbers), bits(&compliances))
        };
        let (fields, numbers, compliances) = found(&grid.whole());
        let each = ThreadRanks::of(3, |ranks| found(&Share::among(ranks, grid.rows(), 0).unwrap()));
        for (component, field) in fields.iter().enumerate() {
            assert!(each.iter().flat_map(|(own, ..)| &own[component]).eq(field), "component {component}");
        }
        assert!(each.iter().all(|(_, other, all)| *other == numbers && *all == compliances));
    }
}

#[test]
fn few_points_use_the_normal_part_of_all_components_only_if_it_is_isotropic() {
    let grid = Grid::square(256, 1.0).unwrap();
    for (poisson, is_isotropic) in [(0.5, true), (0.3, false)] {
        let body = Body::half_space(Material::from_young(3.0, poisson).unwrap());
        let normal = NormalResponse::of_all_components(&FullResponse::new(grid, &body));
        assert_eq!(Scattered::of(&normal, [0.0; 2]).is_some(), is_isotropic, "{poisson}");
        assert!(Scattered::of(&NormalResponse::new(grid, &body), [0.0; 2]).is_some());
    }
}
