//! Files that a member of a study reads.

use std::path::Path;

use gfmd_check::result::FILES;
use gfmd_input::source::file_of;
use toml::Table;

/// Returns the files that a member reads.
pub(super) fn files_of(table: &Table) -> Vec<String> {
    let named = FILES.iter().filter(|key| **key != "channel").filter_map(|key| table.get(*key)?.as_str());
    // A hardness may also be a number with a unit.
    let is_file = |text: &&str| !(gfmd_unit::Quantity::parse(text).is_ok_and(|found| found.is_some()));
    named.filter(is_file).map(|text| file_of(text).to_owned()).filter(|file| !Path::new(file).is_dir()).collect()
}
