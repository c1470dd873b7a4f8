//! The kinds of the numbers of all options.

use std::sync::OnceLock;

use gfmd_problem::options::{Kinds, KindsByKey, Options};

use crate::{body, contact, estimate, green, law, path, prony, punch, slide, surface, theory};

/// Calls `see` with the key and the kinds of each option of each command.
fn see_all(see: &mut dyn FnMut(&'static str, Kinds)) {
    contact::Args::kinds(see);
    punch::Args::kinds(see);
    body::Args::kinds(see);
    surface::Args::kinds(see);
    green::Args::kinds(see);
    path::Args::kinds(see);
    slide::Args::kinds(see);
    law::Args::kinds(see);
    prony::Args::kinds(see);
    theory::Args::kinds(see);
    estimate::Args::kinds(see);
}

/// Returns the kinds of the numbers of all options, by key. Options with the same key have the same kinds in all
/// commands.
pub fn kinds() -> &'static KindsByKey {
    static ALL: OnceLock<KindsByKey> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut all = KindsByKey::new();
        see_all(&mut |key, kinds| {
            all.insert(key, kinds);
        });
        all
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_with_the_same_key_have_the_same_kinds() {
        let mut seen = 0;
        see_all(&mut |key, found| {
            seen += 1;
            assert_eq!(kinds()[key], found, "{key}");
        });
        assert!(seen > kinds().len(), "commands share options");
    }
}
