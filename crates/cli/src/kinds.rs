//! The kinds of the numbers of all options.

use std::sync::OnceLock;

use gfmd_problem::options::{KindsByKey, add_kinds};

use crate::{body, contact, estimate, green, law, path, prony, punch, slide, surface, theory};

/// Returns the kinds of the numbers of all options, by key. Options with the same key have the same kinds in all
/// commands.
pub fn kinds() -> &'static KindsByKey {
    static ALL: OnceLock<KindsByKey> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut all = KindsByKey::new();
        add_kinds::<contact::Args>(&mut all);
        add_kinds::<punch::Args>(&mut all);
        add_kinds::<body::Args>(&mut all);
        add_kinds::<surface::Args>(&mut all);
        add_kinds::<green::Args>(&mut all);
        add_kinds::<path::Args>(&mut all);
        add_kinds::<slide::Args>(&mut all);
        add_kinds::<law::Args>(&mut all);
        add_kinds::<prony::Args>(&mut all);
        add_kinds::<theory::Args>(&mut all);
        add_kinds::<estimate::Args>(&mut all);
        all
    })
}

#[cfg(test)]
mod tests {
    use gfmd_problem::options::{Kinds, Options};

    use super::*;

    #[test]
    fn options_with_the_same_key_have_the_same_kinds() {
        let mut seen: Vec<(&str, Kinds)> = Vec::new();
        let mut see = |key, kinds| seen.push((key, kinds));
        contact::Args::kinds(&mut see);
        punch::Args::kinds(&mut see);
        body::Args::kinds(&mut see);
        surface::Args::kinds(&mut see);
        green::Args::kinds(&mut see);
        path::Args::kinds(&mut see);
        slide::Args::kinds(&mut see);
        law::Args::kinds(&mut see);
        prony::Args::kinds(&mut see);
        theory::Args::kinds(&mut see);
        estimate::Args::kinds(&mut see);
        assert!(seen.len() > kinds().len(), "commands share options");
        for (key, found) in seen {
            assert_eq!(kinds()[key], found, "{key}");
        }
    }
}
