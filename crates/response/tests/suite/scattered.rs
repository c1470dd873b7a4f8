//! Response between few points of a grid, compared with the response of the whole grid.

use std::f64::consts::TAU;

use gfmd_field::{Grid, Share, Transform};
use gfmd_green::{Body, Material};
use gfmd_response::{Blocks, LANES, NormalResponse, Scattered};
use gfmd_vector::ThreadRanks;

fn response(points: [usize; 2], lengths: [f64; 2], height: Option<f64>) -> NormalResponse {
    let material = Material::from_contact_modulus(2.0, 0.3).unwrap();
    let body = height.map_or_else(|| Body::half_space(material), |height| Body::slab(material, height).unwrap());
    NormalResponse::new(Grid::new(points, lengths).unwrap(), &body)
}

/// Every seventh block, and some neighbouring blocks, including blocks at the edges.
fn places(grid: &Grid) -> Vec<usize> {
    let all = grid.len() / LANES;
    (0..all).filter(|place| place % 7 == 0 || place % 97 < 9 || *place < 20 || place + 20 > all).collect()
}

#[test]
fn images_are_those_of_transforms_of_the_whole_surface() {
    for (points, lengths, height) in [
        ([128, 128], [1.0, 1.0], None),
        ([120, 232], [1.0, 2.0], None),
        ([256, 128], [2.2, 1.0], Some(0.1)),
        ([128, 128], [1.0, 1.0], Some(0.15)),
    ] {
        let response = response(points, lengths, height);
        let (grid, uniform) = (*response.grid(), response.uniform_compliance());
        let scattered = Scattered::of(&response, [uniform, 0.0]).unwrap();
        let blocks = Blocks::new(&grid, places(&grid));
        let noise = |i: usize| ((i as f64 + 1.0) * 0.618_034).fract();
        // Some values are zero.
        let values: Vec<f32> = (0..LANES * blocks.len()).map(|i| (noise(i) as f32 - 0.3).max(0.0)).collect();
        let mut pressure = vec![0.0; grid.len()];
        for (place, values) in blocks.places().iter().zip(values.chunks(LANES)) {
            for (p, value) in pressure[place * LANES..].iter_mut().zip(values) {
                *p = f64::from(*value);
            }
        }
        let mut kernel = response.compliance().to_vec();
        kernel[0] = uniform;
        let transform = Transform::new(grid);
        let mut exact = vec![0.0; grid.len()];
        transform.convolve(&kernel, &pressure, &mut exact, &mut transform.workspace()).unwrap();
        let largest = exact.iter().fold(0.0, |largest: f64, u| largest.max(u.abs()));
        let mut image = vec![f32::NAN; values.len()];
        scattered.compliance(&blocks, &values, &mut scattered.memory(), &mut image);
        for (place, image) in blocks.places().iter().zip(image.chunks(LANES)) {
            for (exact, image) in exact[place * LANES..].iter().zip(image) {
                let error = f64::from(*image) * scattered.unit() - exact;
                assert!(error.abs() < 5e-4 * largest, "{points:?} {height:?} {place}: {error} of {largest}");
            }
        }
    }
}

#[test]
fn the_stiffness_is_symmetric_and_positive() {
    let response = response([128, 128], [1.0, 1.0], None);
    let scattered = Scattered::of(&response, [0.0; 2]).unwrap();
    let blocks = Blocks::new(response.grid(), places(response.grid()));
    let field = |seed: f32| (0..LANES * blocks.len()).map(|i| (seed * i as f32).sin()).collect::<Vec<f32>>();
    let image = |field: &[f32]| {
        let mut out = vec![f32::NAN; field.len()];
        scattered.stiffness(&blocks, field, &mut scattered.memory(), &mut out);
        out
    };
    let dot = |a: &[f32], b: &[f32]| gfmd_vector::dot(a, b);
    for seed in [0.1, 0.7, 2.0] {
        let (a, b) = (field(seed), field(1.3 * seed));
        let (k_a, k_b) = (image(&a), image(&b));
        assert!((dot(&a, &k_b) - dot(&b, &k_a)).abs() < 1e-5 * dot(&a, &k_a));
        assert!(dot(&a, &k_a) > 0.0);
    }
}

#[test]
fn grids_without_whole_blocks_and_thin_layers_are_left_to_transforms() {
    for (points, lengths) in [
        ([64, 64], [1.0, 1.0]),
        ([1, 4096], [1.0, 1.0]),
        ([4096, 1], [1.0, 1.0]),
        ([130, 128], [1.0, 1.0]),
        ([128, 132], [1.0, 1.0]),
        ([128, 128], [1.0, 2.0]),
        ([251, 251], [1.0, 1.0]),
    ] {
        assert!(Scattered::of(&response(points, lengths, None), [0.0; 2]).is_none(), "{points:?}");
    }
    let thin = response([128, 128], [1.0, 1.0], Some(0.01));
    assert!(Scattered::of(&thin, [thin.uniform_compliance(), 0.0]).is_none());
}

#[test]
fn waves_on_the_coarse_grid_have_the_stiffness_of_the_body() {
    let response = response([128, 128], [1.0, 1.0], None);
    let grid = *response.grid();
    let scattered = Scattered::of(&response, [0.0; 2]).unwrap();
    let blocks = Blocks::new(&grid, (0..grid.len() / LANES).collect());
    let [rows, columns] = scattered.coarse().points();
    for number in [1_i64, 3, 6] {
        let wave =
            |i: usize| (TAU * (number * (i / columns + i % columns) as i64) as f64 / columns as f64).cos() as f32;
        let field: Vec<f32> = (0..rows * columns).map(wave).collect();
        let mut displacement = vec![f32::NAN; grid.len()];
        scattered.interpolate(&blocks, &field, &mut scattered.memory(), &mut displacement);
        let mut traction = field.clone();
        scattered.stiffen(&blocks, &mut traction, &mut vec![0.0; grid.len()], &mut scattered.memory());
        let stiffness = scattered.unit() / response.compliance()[grid.index_of([number; 2]).unwrap()];
        let expected = stiffness * gfmd_vector::dot(&displacement, &displacement);
        let energy = gfmd_vector::dot(&field, &traction);
        assert!((energy / expected - 1.0).abs() < 1e-4, "{number}: {energy} {expected}");
    }
}

/// Values of all blocks, of the own rows of the coarse grid, and of the own blocks.
type Parts = [Vec<f32>; 3];

/// Computes all products at these places, by the processes of the response.
fn products(response: &NormalResponse, places: &[usize]) -> (Parts, u64) {
    let scattered = Scattered::of(response, [0.3, 0.0]).unwrap();
    let blocks = Blocks::new(response.grid(), places.to_vec());
    let mut memory = scattered.memory();
    let noise = |i: usize| ((i as f32 + 1.0) * 0.618_034).fract();
    let values: Vec<f32> = (0..LANES * blocks.len()).map(|i| (noise(i) - 0.3).max(0.0)).collect();
    let own = |values: &[f32]| {
        let own = scattered.own(&blocks);
        values[own.start * LANES..own.end * LANES].to_vec()
    };
    let mut image = vec![f32::NAN; values.len()];
    scattered.compliance(&blocks, &values, &mut memory, &mut image);
    scattered.complete(&blocks, &mut image);
    let mut field: Vec<f32> = scattered.rows().own().map(noise).collect();
    let mut out = vec![f32::NAN; values.len()];
    scattered.interpolate(&blocks, &field, &mut memory, &mut out);
    let interpolated = own(&out);
    let coupled = scattered.coupled(&blocks);
    assert!(coupled.into_iter().all(|some| out[some.start * LANES..some.end * LANES].iter().all(|x| x.is_finite())));
    let gap: Vec<f32> = out.clone();
    scattered.stiffness(&blocks, &gap, &mut memory, &mut out);
    let rest = own(&out);
    scattered.stiffen(&blocks, &mut field, &mut out, &mut memory);
    let cells = scattered.cells(&blocks, &field);
    let rows = scattered.coarse().points()[0];
    let around = scattered.own(&blocks).flat_map(|block| cells.row((blocks.row(block) + 2) / 4 % rows));
    ([image, field.clone(), [interpolated, rest, around.copied().collect()].concat()], memory.computed())
}

#[test]
fn products_over_ranks_have_the_bits_of_one_process_and_a_part_of_its_work() {
    // Blocks everywhere, in a few rows, and in one row, so that some processes have none.
    let everywhere = |grid: &Grid| places(grid);
    let some_rows = |grid: &Grid| {
        let width = grid.points()[1] / LANES;
        (0..grid.len() / LANES).filter(|place| matches!(place / width, 3..9 | 40 | 120..)).collect()
    };
    let one_row = |grid: &Grid| (50..60).map(|place| 7 * grid.points()[1] / LANES + place % 16).collect();
    for ([rows, columns], lengths) in [([128, 128], [1.0, 1.0]), ([240, 192], [1.3, 1.0])] {
        let grid = Grid::new([rows, columns], lengths).unwrap();
        let body = Body::half_space(Material::from_contact_modulus(2.0, 0.3).unwrap());
        type Places = dyn Fn(&Grid) -> Vec<usize>;
        let kinds: [&Places; 3] = [&everywhere, &some_rows, &one_row];
        for (kind, places) in kinds.into_iter().enumerate() {
            let mut places = places(&grid);
            places.sort_unstable();
            places.dedup();
            let (alone, work) = products(&NormalResponse::new(grid, &body), &places);
            for size in 1..=4 {
                let each = ThreadRanks::of(size, |ranks| {
                    let share = Share::among(ranks, grid.points(), 1).unwrap();
                    products(&NormalResponse::distributed(grid, &body, &share), &places)
                });
                assert!(each.iter().all(|([image, ..], _)| bits(image).eq(bits(&alone[0]))), "{kind} {size}");
                let field = each.iter().flat_map(|([_, field, _], _)| bits(field));
                assert!(field.eq(bits(&alone[1])), "{kind} {size}");
                let total: usize = each.iter().map(|([_, _, own], _)| own.len()).sum();
                assert_eq!(total, alone[2].len());
                // All blocks are computed once, and interpolated again up to six rows away from the rows of a process.
                let all: u64 = each.iter().map(|(_, work)| work).sum();
                let most = each.iter().map(|(_, work)| *work).max().unwrap();
                assert!(all >= work && most <= work, "{kind} {size}: {most} of {work}");
                if kind == 0 {
                    let beside = 12 * work / 3 / grid.points()[0] as u64;
                    assert!(most <= work / size as u64 + 3 * beside, "{size}: {most} of {work}");
                }
            }
        }
    }
}

fn bits(values: &[f32]) -> impl Iterator<Item = u32> {
    values.iter().map(|value| value.to_bits())
}
