//! Valid files that are damaged to make hostile ones.

use std::io::{Cursor, Read};
use std::path::Path;

use gfmd_topography::Listing;
use zip::ZipArchive;

use super::Seed;
use super::made::{self, grids, keyence, mnt, olympus, others, probes, tiff, xlsx};

/// Returns the formats with their valid files. `folder` takes files that a library must write to the disk.
pub(crate) fn seeds(folder: &Path) -> Vec<(&'static str, Vec<Seed>)> {
    let bytes = |files: Vec<Vec<u8>>| files.into_iter().map(Seed::Bytes).collect::<Vec<Seed>>();
    let zip = |entries: Vec<(&str, Vec<u8>)>| {
        vec![Seed::Zip(entries.into_iter().map(|(name, bytes)| (name.to_owned(), bytes)).collect())]
    };
    let sur = vec![made::sur(16, 0, 0), made::sur(32, 0, 2), made::sur(32, 1, 0), made::sur(16, 3, 3)];
    let datx = folder.join("seed.datx");
    made::datx(&datx);
    let datx = std::fs::read(datx).unwrap();
    let mut seeds = vec![
        ("Digital Surf", bytes(sur)),
        ("Nanoscope", bytes(vec![made::nanoscope(2), made::nanoscope(4)])),
        ("Wyko OPD", bytes(vec![made::opd(2), made::opd(4)])),
        ("Dektak OPDx", bytes(vec![made::opdx(true), made::opdx(false)])),
        ("Alicona AL3D", bytes(vec![made::al3d()])),
        ("Zygo MetroPro", bytes(vec![made::metropro(1, 0), made::metropro(2, 2), made::metropro(3, 0)])),
        ("Igor binary wave", bytes(vec![made::ibw(false), made::ibw(true), made::ibw_profile()])),
        ("Sensofar PLUX", zip(made::plux())),
        ("Zygo Mx", bytes(vec![datx])),
        ("Sensofar PLu", bytes(vec![made::plu()])),
        ("Molecular Imaging", bytes(vec![made::mi(16), made::mi(32)])),
        ("Nanosurf", bytes(vec![made::nanosurf()])),
        ("TrueMap", bytes(vec![grids::tmd("a comment"), grids::tmd("")])),
        ("NanoFocus", bytes(vec![grids::nms(true), grids::nms(false)])),
        ("OmniSurf3D", bytes(vec![grids::os3d(true), grids::os3d(false)])),
        ("Zeta", bytes(vec![grids::zmg()])),
        ("BCR", bytes(vec![grids::bcr(true, false), grids::bcr(false, true)])),
        ("FRT MicroProf", bytes(vec![grids::frt(true), grids::frt(false)])),
        ("Surfer", bytes(vec![grids::surfer(6), grids::surfer(7)])),
        ("WSxM", bytes(vec![probes::wsxm(true), probes::wsxm(false)])),
        ("Nanonis SXM", bytes(vec![probes::sxm(true), probes::sxm(false)])),
        ("JPK", bytes(vec![tiff::jpk(true, false), tiff::jpk(false, true)])),
        ("Park", bytes(vec![tiff::park(false, "um"), tiff::park(true, "")])),
        ("Olympus LEXT", bytes(vec![tiff::lext()])),
        (
            "TIFF",
            bytes(vec![
                tiff::deflated_strips(),
                tiff::float_tiles(),
                tiff::imagej(true),
                tiff::ome(),
                tiff::ground(1),
                tiff::ground_with_matrix([0.5, 0.0, 0.25]),
            ]),
        ),
        ("Keyence VK", bytes(vec![keyence::vk(3), keyence::vk(4), keyence::vk_archive(6), keyence::vk_archive(7)])),
        ("Keyence ZON", bytes(vec![keyence::zon(0), keyence::zon(1)])),
        ("Olympus OIR", bytes(vec![olympus::oir(), olympus::poir()])),
        ("MountainsMap", bytes(vec![mnt::mnt(true), mnt::mnt(false)])),
        ("Excel", [zip(xlsx::xlsx()), zip(xlsx::mitutoyo())].into_iter().flatten().collect()),
        ("STL", bytes(vec![others::stl(true, false), others::stl(false, false)])),
        ("PLY", bytes(["ascii", "binary_little_endian", "binary_big_endian"].map(others::ply).to_vec())),
        ("PNG", bytes(vec![others::png(true), others::png(false), others::png_of_8_bits()])),
        ("ISO 5436-2", bytes(vec![others::smd()])),
        ("gzip", bytes(vec![others::gzip()])),
        ("NT-MDT", bytes(vec![probes::mdt(), probes::mda()])),
    ];
    let data = std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data")).unwrap();
    let mut written: Vec<Vec<u8>> = data.filter_map(|entry| std::fs::read(entry.unwrap().path()).ok()).collect();
    // The order of files in a folder is not fixed.
    written.sort();
    for bytes in written.into_iter().chain(texts()) {
        // The folder also has a program and a text.
        let Ok(listing) = Listing::from_bytes("file", bytes.clone()) else { continue };
        let seed = entries(&bytes).map_or(Seed::Bytes(bytes), Seed::Zip);
        match seeds.iter_mut().find(|(format, _)| *format == listing.format) {
            Some((_, files)) => files.push(seed),
            None => seeds.push((listing.format, vec![seed])),
        }
    }
    seeds
}

/// Decompresses the entries of a zip archive.
fn entries(bytes: &[u8]) -> Option<Vec<(String, Vec<u8>)>> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).ok()?;
    let count = archive.len();
    let entry = |index: usize| {
        let mut entry = archive.by_index(index).ok()?;
        let mut bytes = vec![];
        entry.read_to_end(&mut bytes).ok()?;
        Some((entry.name().ok()?.into_owned(), bytes))
    };
    (0..count).map(entry).collect()
}

/// Returns text files, and files with a text header.
fn texts() -> Vec<Vec<u8>> {
    let mut npy = b"\x93NUMPY\x01\0\x46\0{'descr': '>i2', 'fortran_order': False, 'shape': (2, 3), }".to_vec();
    npy.resize(79, b' ');
    npy.extend(b"\n\0\x01\xff\xff\x80\0\x01\0\0\x02\0\x03");
    let mut gsf =
        b"Gwyddion Simple Field 1.0\nXRes = 3\nYRes = 2\nXReal = 3e-6\nYReal = 2e-6\nXYUnits = m\nZUnits = m\n"
            .to_vec();
    gsf.resize((gsf.len() + 1).next_multiple_of(4), 0);
    gsf.extend((0..6_i16).flat_map(|height| f32::from(height).to_le_bytes()));
    let mut sdf = b"bISO-1.0by hand   010220200304010220200304".to_vec();
    sdf.extend([3_u16, 2].iter().flat_map(|value| value.to_le_bytes()));
    sdf.extend([1e-6_f64, 2e-6, 1e-9, 1e-9].iter().flat_map(|value| value.to_le_bytes()));
    sdf.extend([0, 5, 0]);
    sdf.extend((0..6_i16).flat_map(i16::to_le_bytes));
    vec![
        npy,
        gsf,
        sdf,
        b"aISO-1.0\nManufacID = by hand\nCreateDate = 010220200304\nModDate = 010220200304\nNumPoints = 3\n\
          NumProfiles = 2\n\
          Xscale = 1e-6\nYscale = 2e-6\nZscale = 1e-9\nZresolution = 1e-9\nCompression = 0\nDataType = 5\n\
          CheckType = 0\n*\n\
          0 1 2\n3 BAD 5\n*\n"
            .to_vec(),
        b"# Channel: Height\n# Width: 10 \xc2\xb5m\n# Height: 5 \xc2\xb5m\n# Value units: nm\n1.5e-003\t2\t-3\n\
          4\t5\tnan\n"
            .to_vec(),
        b"1,5;2;3\n4;5,25;6\n".to_vec(),
        b"1 2 3\n4 5 6\n7 8 9\n1e3 nan -2.5\n".to_vec(),
        b"0 0 1\n1 0 2\n2 0 3\n0 1 4\n1 1 5\n2 1 6\n".to_vec(),
        b"1.0D+00 2 3\r\xe2\x88\x924 5.0-105 6\r7,5 8 9\r".to_vec(),
        b"x in \xc2\xb5m;y in nm;z in nm\r\n0;0;1\r\n1;0;2\r\n0;9;4\r\n1;9;5\r\n".to_vec(),
    ]
}
