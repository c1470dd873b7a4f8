//! Sums over ranks, played by threads, have the same bits as with one process.

use gfmd_vector::{LEAF, Share, ThreadRanks, TooManyRanks, add, pass, reduce};
use proptest::prelude::*;

/// Scattered numbers with a sum that depends on the order.
fn noise(n: usize) -> Vec<f64> {
    (0..n).map(|i| ((i as f64 + 1.0) * 0.618_033_988_7).fract() - 0.5).collect()
}

/// Compares passes, reductions and gathered fields of several ranks with the results of one.
fn assert_bits_of_one(points: [usize; 2], size: usize, levels: u32) {
    let [rows, columns] = points;
    let field = noise(rows * columns);
    let leaf = |_: usize, [x]: [&mut [f64]; 1]| {
        let mut sums = [0.0; 2];
        for x in x {
            *x *= 3.0;
            sums = add(sums, [*x, *x * *x]);
        }
        sums
    };
    let mut changed = field.clone();
    let sums = pass([&mut changed[..]], &leaf, &add);
    let lowest =
        |values: &[f64]| values.iter().copied().fold((0.0, f64::INFINITY), |(sum, low), x| (sum + x, low.min(x)));
    let merge = |a: (f64, f64), b: (f64, f64)| (a.0 + b.0, a.1.min(b.1));
    let reduced = reduce(field.len(), &|range| lowest(&field[range]), &merge);
    ThreadRanks::of(size, |ranks| {
        let share = Share::among(ranks, points, levels).unwrap();
        assert!(!share.rows().is_empty());
        assert_eq!(share.total(), rows * columns);
        let mut own = field[share.own()].to_vec();
        let found = share.reduce(&|range| lowest(&own[range]), &merge);
        assert_eq!([found.0, found.1].map(f64::to_bits), [reduced.0, reduced.1].map(f64::to_bits));
        assert_eq!(share.total_of(&own).to_bits(), gfmd_vector::total(&field).to_bits());
        let found = share.pass([&mut own[..]], &leaf, &add);
        assert_eq!(found.map(f64::to_bits), sums.map(f64::to_bits));
        assert_eq!(share.gather(&own, columns), changed);
        let single: Vec<f32> = own.iter().map(|x| *x as f32).collect();
        assert!(share.gather(&single, columns).iter().zip(&changed).all(|(a, b)| *a == *b as f32));
        // The neighbouring rows of other ranks, around the cell.
        let row = |i: usize| changed[i % rows * columns..][..columns].to_vec();
        let (first, last) = (&own[..columns], &own[own.len() - columns..]);
        let [before, after] = share.beside(first, last);
        assert_eq!(before, row(share.rows().start + rows - 1));
        assert_eq!(after, row(share.rows().end));
        assert!(share.any(share.rows().start == 0));
        assert!(!share.any(false));
        // All rows to the first rank and back, in blocks that do not match the partition.
        for height in [1, 7, rows] {
            let mut whole = Vec::new();
            share.to_first(&own, columns, height, |block, values| {
                assert_eq!((block.start * columns, block.len() * columns), (whole.len(), values.len()));
                whole.extend_from_slice(values);
            });
            let is_first = share.ranks().rank() == 0;
            assert_eq!(whole, if is_first { &changed[..] } else { &[] });
            let mut back = vec![0.0; own.len()];
            share.from_first(&mut back, columns, height, |block, values| {
                values.copy_from_slice(&whole[block.start * columns..block.end * columns]);
            });
            assert_eq!(back, own);
        }
        let rank = share.ranks().rank();
        assert_eq!(share.first((rank > 0).then_some([rank, 7])), (size > 1).then_some([1, 7]));
    });
}

#[test]
fn sums_over_ranks_have_the_bits_of_one_process() {
    for points in [[512, 512], [1000, 1000], [300, 4096], [4096, 96], [100, 2048], [33, 2048]] {
        for size in 1..=Share::most(points, 1).min(7) {
            assert_bits_of_one(points, size, 1);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn sums_over_ranks_have_the_bits_of_one_process_whatever_the_shape(
        rows in 1_usize..400, columns in 1_usize..700, exponent in 0_u32..9, size in 1_usize..=7, levels in 0_u32..4,
    ) {
        // An odd number of columns allows one or two ranks, an even number more.
        let columns = (columns >> exponent).max(1) << exponent;
        assert_bits_of_one([rows, columns], size.min(Share::most([rows, columns], levels)), levels);
    }
}

#[test]
fn more_ranks_than_leaves_are_refused_with_the_largest_number() {
    let refused = |points, levels| ThreadRanks::of(5, |ranks| Share::among(ranks, points, levels).err())[0];
    assert_eq!(refused([512, 1000], 0), Some(TooManyRanks { ranks: 5, most: 2, unit: 256 }));
    assert_eq!(refused([1, 1 << 20], 0), Some(TooManyRanks { ranks: 5, most: 1, unit: 1 }));
    assert_eq!(refused([64, LEAF], 4), Some(TooManyRanks { ranks: 5, most: 4, unit: 16 }));
    assert_eq!(refused([4096, 33], 0), Some(TooManyRanks { ranks: 5, most: 2, unit: LEAF }));
    assert_eq!(refused([256, 256], 1), None);
}
