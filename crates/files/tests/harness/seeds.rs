//! The valid files from which the hostile ones are made.

use std::path::Path;

use super::Seed;
use super::made;

/// The formats with their valid files. `folder` takes files that a library must write to the disk.
pub(crate) fn seeds(folder: &Path) -> Vec<(&'static str, Vec<Seed>)> {
    let bytes = |files: Vec<Vec<u8>>| files.into_iter().map(Seed::Bytes).collect::<Vec<Seed>>();
    let zip = |entries: Vec<(&str, Vec<u8>)>| {
        vec![Seed::Zip(entries.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)).collect())]
    };
    let sur = vec![made::sur(16, 0, 0), made::sur(32, 0, 2), made::sur(32, 1, 0), made::sur(16, 3, 3)];
    let datx = folder.join("seed.datx");
    made::datx(&datx);
    let datx = std::fs::read(datx).unwrap();
    vec![
        ("Digital Surf", bytes(sur)),
        ("Nanoscope", bytes(vec![made::nanoscope(2), made::nanoscope(4)])),
        ("Wyko OPD", bytes(vec![made::opd(2), made::opd(4)])),
        ("Dektak OPDx", bytes(vec![made::opdx(true), made::opdx(false)])),
        ("Alicona AL3D", bytes(vec![made::al3d()])),
        ("Zygo MetroPro", bytes(vec![made::metropro(1, 0), made::metropro(2, 2), made::metropro(3, 0)])),
        ("Igor binary wave", bytes(vec![made::ibw(false), made::ibw(true), made::ibw_profile()])),
        ("Sensofar PLUX", zip(made::plux())),
        ("Zygo Mx", bytes(vec![datx])),
    ]
}
