//! Partial fractions of 1/(ψ(s) + k), where ψ is the Carson transform of a relaxation function.

use crate::Branch;

/// Computes the poles s = −ρ of 1/f(s), f(s) = 1 + k + Σ c_i s/(s + 1/τ_i), as pairs [ρ, 1/f'(−ρ)], in the order of the
/// branches. Each ρ lies below the 1/τ of its branch and above all smaller 1/τ (theory.md, section 7.7). `offset` is k,
/// above −1.
pub(crate) fn poles(branches: &[Branch], offset: f64) -> Vec<[f64; 2]> {
    let rates: Vec<f64> = branches.iter().map(|branch| 1.0 / branch.time).collect();
    let pole = |own: usize| {
        let below = rates.iter().copied().filter(|rate| *rate < rates[own]).fold(0.0, f64::max);
        // The unknown is the distance u below the rate, because the pole may lie very close to the rate.
        let rates = &rates;
        let apart = |index: usize, u: f64| if index == own { -u } else { (rates[own] - rates[index]) - u };
        let sum = |u: f64, term: &dyn Fn(f64, f64, f64) -> f64| {
            let terms = branches.iter().zip(rates).enumerate();
            terms
                .map(|(index, (branch, rate))| branch.weight * term(*rate, rates[own] - u, apart(index, u)))
                .sum::<f64>()
        };
        let f = |u: f64| 1.0 + offset + sum(u, &|_, pole, apart| pole / apart);
        // f falls from +∞ at the next lower rate (1 + k at 0) to −∞ at the branch's own rate.
        let (mut low, mut high) = (0.0, rates[own] - below);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            *if f(middle) > 0.0 { &mut high } else { &mut low } = middle;
        }
        let slope = sum(high, &|rate, _, apart| rate / (apart * apart));
        [rates[own] - high, 1.0 / slope]
    };
    (0..branches.len()).map(pole).collect()
}

#[cfg(test)]
mod tests {
    use approx::{assert_abs_diff_eq, assert_relative_eq};

    use super::*;

    #[test]
    fn retardation_has_known_values() {
        let branches = [(0.05, 1.2), (0.7, 1.0), (6.0, 0.8)].map(|(time, weight)| Branch { time, weight });
        let found = poles(&branches, 0.0);
        let known = [[14.17698411, 1.39416153], [0.93828181, 0.16043975], [0.08949599, 0.04301778]];
        for (found, known) in found.iter().zip(known) {
            (0..2).for_each(|k| assert_abs_diff_eq!(found[k], known[k], epsilon = 6e-9));
        }
    }

    #[test]
    fn partial_fractions_add_up() {
        let branches =
            [(1e-6, 0.5), (1e-3, 1e-9), (1.0, 2.0), (1e3, 0.5)].map(|(time, weight)| Branch { time, weight });
        for offset in [-0.5, 0.0, 3.0] {
            for s in [1e-5, 1e-2, 1.0, 1e4, 1e8] {
                let of = |branch: &Branch| branch.weight * s / (s + 1.0 / branch.time);
                let f = 1.0 + offset + branches.iter().map(of).sum::<f64>();
                let infinite = 1.0 + offset + branches.iter().map(|branch| branch.weight).sum::<f64>();
                let sum: f64 = poles(&branches, offset).iter().map(|[rate, residue]| residue / (s + rate)).sum();
                assert_relative_eq!(1.0 / infinite + sum, 1.0 / f, max_relative = 1e-12);
            }
        }
    }
}
