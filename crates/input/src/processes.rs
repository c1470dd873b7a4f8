//! Agreement between the processes that run a command together.

use gfmd_vector::Ranks;

use crate::failure::Failure;

/// Returns the common outcome of a step that may fail on some processes only: an error on all if one fails.
///
/// # Errors
/// Returns the first failure, in process order.
pub fn agree<T>(ranks: &dyn Ranks, outcome: Result<T, Failure>) -> Result<T, Failure> {
    let text = match &outcome {
        Ok(_) => String::new(),
        Err(failure) => format!("{}\n{failure}", failure.status()),
    };
    let all = texts(ranks, &text);
    let Some(first) = all.iter().find(|text| !text.is_empty()) else { return outcome };
    let (status, text) = first.split_once('\n').unwrap_or(("", first));
    let text = text.to_owned();
    Err(match status {
        "2" => Failure::refused(text),
        "130" => Failure::interrupted(text),
        _ => Failure::computation(text),
    })
}

/// Returns the numbers of the first process on all processes.
pub fn of_first<const N: usize>(ranks: &dyn Ranks, own: [u64; N]) -> [u64; N] {
    let mut all = own;
    replace_by_first(ranks, &mut all);
    all
}

/// Replaces the numbers of each process by the numbers of the first one.
pub fn replace_by_first(ranks: &dyn Ranks, numbers: &mut [u64]) {
    let lengths: Vec<usize> = (0..ranks.size()).map(|rank| if rank == 0 { numbers.len() } else { 0 }).collect();
    let own = if ranks.rank() == 0 { numbers.to_vec() } else { Vec::new() };
    ranks.gather(&own, numbers, &lengths);
}

/// Gathers the text of each process.
pub fn texts(ranks: &dyn Ranks, own: &str) -> Vec<String> {
    let mut lengths = vec![0; ranks.size()];
    ranks.gather(&[own.len() as u64], &mut lengths, &vec![1; ranks.size()]);
    let lengths: Vec<usize> = lengths.into_iter().map(|length| length as usize).collect();
    let bytes: Vec<u64> = own.bytes().map(u64::from).collect();
    let mut all = vec![0; lengths.iter().sum()];
    ranks.gather(&bytes, &mut all, &lengths);
    let mut rest = &all[..];
    let text = |length: usize| {
        let (own, after) = rest.split_at(length);
        rest = after;
        String::from_utf8_lossy(&own.iter().map(|byte| *byte as u8).collect::<Vec<u8>>()).into_owned()
    };
    lengths.into_iter().map(text).collect()
}

#[cfg(test)]
mod tests {
    use gfmd_vector::ThreadRanks;

    use super::*;

    #[test]
    fn the_first_failure_is_that_of_all() {
        let found = ThreadRanks::of(3, |ranks| {
            let own = match ranks.rank() {
                0 => Ok(7),
                rank => Err(Failure::refused(format!("of process {rank}"))),
            };
            agree(&*ranks, own).map_err(|failure| (failure.status(), failure.to_string()))
        });
        assert!(found.iter().all(|found| *found == Err((2, "of process 1".into()))), "{found:?}");
        let found = ThreadRanks::of(3, |ranks| agree(&*ranks, Ok(ranks.rank())).ok());
        assert_eq!(found, [Some(0), Some(1), Some(2)]);
        let numbers = ThreadRanks::of(3, |ranks| of_first(&*ranks, [7 + ranks.rank() as u64, 2]));
        assert_eq!(numbers, [[7, 2]; 3]);
        let words = ThreadRanks::of(2, |ranks| texts(&*ranks, ["", "κ"][ranks.rank()]));
        assert!(words.iter().all(|words| *words == ["", "κ"]));
    }
}
