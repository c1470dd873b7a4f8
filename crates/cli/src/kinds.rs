//! The kinds of the numbers of all options.

use std::sync::OnceLock;

use gfmd_problem::options::{KindsByKey, add_kinds};

use crate::{body, contact, green, law, path, punch, slide, surface, theory, wear};

/// Returns the kinds of the numbers of all options, by key. Options of one key have the same kinds in all commands.
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
        add_kinds::<wear::Args>(&mut all);
        add_kinds::<law::Args>(&mut all);
        add_kinds::<theory::Args>(&mut all);
        all
    })
}
