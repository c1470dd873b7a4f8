use std::process::{Command, Stdio};

use super::*;

fn provenance() -> Provenance {
    Provenance {
        program: "gfmd".into(),
        version: "0.1.0".into(),
        git_commit: "unknown".into(),
        command: "gfmd contact --n 8".into(),
        created: "2026-01-02T03:04:05Z".into(),
        config: "n = 8\n[body]\nyoung = 1.0\n".into(),
        machine: "two cores".into(),
        threads: 2,
        warnings: crate::Warnings::default(),
    }
}

/// Writes a file with all kinds of data: scalars, strings, fields by slabs, several groups with equal names.
fn write_all(path: &std::path::Path) {
    put_all(&Output::claim(path).unwrap());
}

fn put_all(output: &Output) {
    let mut archive = Archive::create(output, &provenance()).unwrap();
    let load = Dimension::index("load", 2, "load step");
    let x = Dimension::values("x", (0..40).map(|i| 0.025 * f64::from(i)).collect(), "length", "position along x");
    let y = Dimension::values("y", (0..30).map(|i| 0.05 * f64::from(i)).collect(), "length", "position along y");
    let component = Dimension::labels("component", &["x", "y", "z"], "direction");
    let height: Vec<f64> = (0..1200).map(|i| f64::from(i).sin()).collect();

    let surface = Variable { dimensions: &[&x, &y], units: "length", long_name: "height, peaks towards the body" };
    archive.write("/surface/height", &surface, &height).unwrap();
    let scalar = Variable { dimensions: &[&load], units: "1", long_name: "contact area fraction" };
    archive.write("/loads/area_fraction", &scalar, &[0.25, 0.5]).unwrap();
    let count = Variable { dimensions: &[&load], units: "1", long_name: "iterations" };
    archive.write("/loads/iterations", &count, &[17_u64, u64::MAX]).unwrap();
    archive.write("/loads/converged", &Variable { long_name: "1 if converged", ..count }, &[1_u8, 0]).unwrap();
    let words = Variable { dimensions: &[&load], units: "1", long_name: "method" };
    archive.write_text("/loads/solver", &words, &["cg", "größer"]).unwrap();
    let field =
        Variable { dimensions: &[&load, &x, &y], units: "stress", long_name: "normal traction, compression positive" };
    archive.define("/fields/pressure", &field).unwrap();
    archive.write_slab("/fields/pressure", 1, &height).unwrap();
    let vector = Variable { dimensions: &[&x, &y, &component], units: "length", long_name: "displacement" };
    archive.write("/fields/displacement", &vector, &vec![1.5; 3600]).unwrap();
    let single = Variable { dimensions: &[], units: "1", long_name: "kappa in the limit" };
    archive.write("/fit/kappa_tfc", &single, &[2.1]).unwrap();
    archive.attribute("/fit", "resamples", 2000_i64).unwrap();
    archive.attribute("/fit", "seed", u64::MAX).unwrap();
    archive.attribute("/fit/kappa_tfc", "note", "three axes").unwrap();
    archive.attribute("/fit", "p_star", 0.02).unwrap();
    archive.finish().unwrap();
}

/// A draft writes the same bytes as a direct write, and writes no file for an unfinished result.
#[test]
fn a_draft_makes_the_same_file() {
    let folder = tempfile::tempdir().unwrap();
    let [at_once, later, other] = ["at_once.h5", "later.h5", "other.h5"].map(|name| folder.path().join(name));
    write_all(&at_once);
    let memory = Memory::default();
    put_all(&Output::memory(&memory));
    let (fields, draft) = memory.take("/fields/");
    assert_eq!(fields.keys().collect::<Vec<_>>(), ["/fields/displacement", "/fields/pressure"]);
    let mut draft = draft.unwrap();
    assert_eq!(draft.write(&Output::claim(&later).unwrap(), &fields).unwrap(), later);
    assert!(fs::read(&at_once).unwrap() == fs::read(&later).unwrap());
    // Missing fields, or fields of another shape, give no file.
    let cut = fields
        .iter()
        .map(|(path, values)| (path.clone(), values.slice(ndarray::s![.., .., ..1]).to_owned().into_dyn()));
    for wrong in [BTreeMap::new(), cut.collect()] {
        let refused = draft.write(&Output::claim(&other).unwrap(), &wrong);
        assert!(matches!(refused, Err(FileError::Length { .. })), "{refused:?}");
    }
    assert!(!other.exists());
    draft.replace("/fit/kappa_tfc", "note", "other words");
    draft.write(&Output::claim(&other).unwrap(), &fields).unwrap();
    let reader = Reader::open(&other).unwrap();
    assert_eq!(reader.text("/fit/kappa_tfc", "note").unwrap(), "other words");
    assert_eq!(reader.is_intact().unwrap(), Some(true));
    assert_eq!(reader.is_intact_keeping(&|path| path.starts_with("/fields/")).unwrap(), Some(true));
    for (path, values) in &fields {
        // Kept values, kept values taken, and values read again are the same.
        for found in [reader.values::<f64>(path), reader.take(path), reader.take(path)] {
            assert!(found.unwrap().iter().map(|value| value.to_bits()).eq(values.iter().map(|value| value.to_bits())));
        }
    }

    let output = Output::memory(&memory);
    let mut archive = Archive::create(&output, &provenance()).unwrap();
    archive.attribute("/fit", "p_star", 0.02).unwrap();
    drop(archive);
    assert!(memory.take("/fields/").1.is_none());
}

fn variable<'a>(dimensions: &'a [&'a Dimension]) -> Variable<'a> {
    Variable { dimensions, units: "1", long_name: "something" }
}

#[test]
fn what_is_written_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("all.h5");
    write_all(&path);
    let file = read(&path);
    assert_eq!(file.names("/"), ["fields", "fit", "loads", "surface"]);
    assert_eq!(file.names("/loads"), ["area_fraction", "converged", "iterations", "load", "solver"]);
    assert_eq!(file.shape("/fields/pressure").unwrap(), [2, 40, 30]);
    assert_eq!(file.values::<u64>("/loads/iterations").unwrap(), [17, u64::MAX]);
    assert_eq!(file.values::<f64>("/loads/converged").unwrap(), [1.0, 0.0]);
    assert_eq!(file.texts("/loads/solver").unwrap(), ["cg", "größer"]);
    assert_eq!(file.texts("/fields/component").unwrap(), ["x", "y", "z"]);
    let height = file.values::<f64>("/surface/height").unwrap();
    assert_eq!(file.slab::<f64>("/fields/pressure", 1).unwrap(), height);
    assert!(file.slab::<f64>("/fields/pressure", 0).unwrap().iter().all(|p| p.is_nan()), "unwritten entries are NaN");
    assert_eq!(file.values::<f64>("/fit/kappa_tfc").unwrap(), [2.1]);
    assert_eq!(file.shape("/fit/kappa_tfc").unwrap(), [0; 0]);
    assert_eq!(file.text("/", "config").unwrap(), provenance().config);
    assert_eq!(file.text("/fields/pressure", "units").unwrap(), "stress");
    assert_eq!(file.text("/fit/kappa_tfc", "note").unwrap(), "three axes");
    assert_eq!(file.number("/", "threads").unwrap(), 2.0);
    let seed = File::open(&path).unwrap().group("/fit").unwrap().attr("seed").unwrap();
    assert_eq!(seed.read_scalar::<u64>().unwrap(), u64::MAX, "to the last digit");
    assert_eq!(file.number("/fit", "p_star").unwrap(), 0.02);
    assert!(file.contains("/fields/pressure") && !file.contains("/fields/gap") && !file.contains("/fields"));
}

#[test]
fn warnings_stand_in_the_root_even_those_made_while_the_file_was_open() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    let output = Output::claim(&path).unwrap();
    let provenance = provenance();
    let archive = Archive::create(&output, &provenance).unwrap();
    provenance.warnings.add(crate::Warning { code: "rough-seam".into(), text: "steps across the seam".into() });
    archive.finish().unwrap();
    assert_eq!(read(&path).text("/", "warnings").unwrap(), "rough-seam: steps across the seam\n");
    write_all(&folder.path().join("b.h5"));
    assert_eq!(read(&folder.path().join("b.h5")).text("/", "warnings").unwrap(), "");
}

#[test]
fn a_changed_value_shape_or_attribute_is_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    let changes: [fn(&File) -> hdf5::Result<()>; 6] = [
        |file| file.dataset("/loads/area_fraction")?.write_raw(&[0.25, 0.500_000_000_000_000_1]),
        |file| file.dataset("/loads/iterations")?.write_raw(&[17_u64, u64::MAX - 1]),
        |file| file.dataset("/fields/pressure")?.write_slice(ndarray::arr3(&[[[1.0]]]).view(), (0..1, 3..4, 3..4)),
        |file| file.attr("config")?.write_scalar(&"n = 9".parse::<VarLenUnicode>().unwrap()),
        |file| file.group("/fit")?.attr("seed")?.write_scalar(&3_u64),
        |file| file.unlink("/fit/kappa_tfc"),
    ];
    write_all(&path);
    // A process started by another test may hold the lock of a file that was open then; a copy has no lock.
    let copy = |from: &std::path::Path, name: &str| {
        let to = folder.path().join(name);
        fs::copy(from, &to).unwrap();
        to
    };
    assert_eq!(read(&path).is_intact().unwrap(), Some(true));
    for (number, change) in changes.into_iter().enumerate() {
        let written = copy(&path, &format!("{number}.h5"));
        let file = File::open_rw(&written).unwrap();
        change(&file).unwrap();
        file.close().unwrap();
        let found = read(&written).is_intact().unwrap();
        assert_eq!(found, Some(false), "change {number}");
    }
    let empty = folder.path().join("empty.h5");
    File::create(&empty).unwrap().close().unwrap();
    assert_eq!(read(&empty).is_intact().unwrap(), None);
}

/// A damaged or truncated file gives an error or a wrong checksum, or has unchanged content.
#[test]
fn a_damaged_file_neither_ends_the_process_nor_goes_unnoticed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    write_all(&path);
    let good = fs::read(&path).unwrap();
    let content = |file: &Reader| -> Result<Vec<u64>, crate::FileError> {
        let mut bits = Vec::new();
        for group in ["/loads", "/surface", "/fields", "/fit"] {
            for name in file.names(group) {
                let name = format!("{group}/{name}");
                match file.values::<f64>(&name) {
                    Ok(values) => bits.extend(values.into_iter().map(f64::to_bits)),
                    Err(_) => bits.extend(file.texts(&name)?.into_iter().flat_map(String::into_bytes).map(u64::from)),
                }
            }
        }
        Ok(bits)
    };
    let expected = content(&Reader::open(&path).unwrap()).unwrap();
    let (mut state, mut noticed) = (1_u64, 0);
    let mut random = |below: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % below
    };
    const CASES: usize = 800;
    for case in 0..CASES {
        let mut bad = good.clone();
        match case % 10 {
            0 => bad.truncate(random(good.len())),
            _ => {
                let (place, flip) = (random(good.len()), 1 + random(255) as u8);
                let length = 1 + random(16);
                bad[place..].iter_mut().take(length).for_each(|byte| *byte ^= flip);
            }
        }
        fs::write(&path, &bad).unwrap();
        let found = Reader::open(&path).and_then(|file| Ok((file.is_intact()?, content(&file)?)));
        match found {
            Ok((Some(true), found)) => assert!(found == expected, "case {case}"),
            _ => noticed += 1,
        }
    }
    assert!(noticed > CASES / 2, "{noticed}");
}

#[test]
fn equal_content_gives_equal_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let paths = [folder.path().join("a.h5"), folder.path().join("b.h5")];
    for path in &paths {
        write_all(path);
        std::thread::sleep(std::time::Duration::from_millis(1100)); // HDF5 time stamps count seconds.
    }
    assert!(fs::read(&paths[0]).unwrap() == fs::read(&paths[1]).unwrap());
}

#[test]
fn fields_are_chunked_by_load_and_compressed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    write_all(&path);
    let file = File::open(&path).unwrap();
    let pressure = file.dataset("/fields/pressure").unwrap();
    assert_eq!(pressure.chunk().unwrap(), [1, 40, 30]);
    assert_eq!(pressure.filters().len(), 2);
    assert!(!file.dataset("/loads/area_fraction").unwrap().is_chunked());
    assert_eq!(chunk(&[3, 4096, 4096], 8), [1, 64, 4096]);
    assert_eq!(chunk(&[3, 7, 1 << 40], 8), [1, 1, 1 << 18]);
    assert_eq!(chunk(&[100_000], 8), [100_000]);
    assert_eq!(chunk(&[1 << 30], 8), [1 << 18]);
    assert_eq!(chunk(&[4096, 4096], 8), [64, 4096]);
}

#[test]
fn a_file_being_written_leaves_the_good_one_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    write_all(&path);
    let good = fs::read(&path).unwrap();
    let output = Output::claim(&path).unwrap();
    let mut archive = Archive::create(&output, &provenance()).unwrap();
    archive.write("/x", &variable(&[]), &[1.0]).unwrap();
    assert!(output.part().exists());
    assert_eq!(fs::read(&path).unwrap(), good);
    drop(archive); // unfinished
    assert!(!output.part().exists());
    assert_eq!(fs::read(&path).unwrap(), good);

    fs::write(output.part(), b"left by a process that was killed").unwrap();
    let mut archive = Archive::create(&output, &provenance()).unwrap();
    archive.write("/x", &variable(&[]), &[1.0]).unwrap();
    assert_eq!(archive.finish().unwrap(), path);
    drop(output);
    assert_eq!(read(&path).names("/"), ["x"]);
    let left: Vec<_> = fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["a.h5"], "neither part nor lock is left");
}

#[test]
fn a_second_claim_is_refused_until_the_first_ends() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    let first = Output::claim(&path).unwrap();
    let error = Output::claim(&path).unwrap_err();
    assert!(matches!(error, FileError::Busy { .. }));
    let line = error.to_string();
    assert!(line.contains("a.h5 is being written by another process"), "{line}");
    Output::claim(folder.path().join("b.h5")).unwrap();
    drop(first);
    Output::claim(&path).unwrap();
}

/// Opens a copy of a file: a process started by another test may hold the lock of a file that was open then.
fn read(path: &std::path::Path) -> Reader {
    let folder = tempfile::tempdir().unwrap();
    let copy = folder.path().join("copy.h5");
    fs::copy(path, &copy).unwrap();
    Reader::open(&copy).unwrap()
}

/// Returns a command that runs the named test in another process, with the path of its file in the environment.
fn again(test: &str, path: &std::path::Path, limit: &str) -> Command {
    let mut command = Command::new("sh");
    command.arg("-c").arg(format!("{limit} exec \"$0\" --exact archive::tests::{test}"));
    command.arg(std::env::current_exe().unwrap()).env("ARCHIVE_TEST_FILE", path);
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command
}

#[cfg(unix)]
#[test]
fn the_claim_ends_with_a_killed_process() {
    if let Some(path) = std::env::var_os("ARCHIVE_TEST_FILE").map(PathBuf::from) {
        let output = Output::claim(path).unwrap();
        fs::write(output.beside(".ready"), b"").unwrap();
        std::thread::sleep(std::time::Duration::from_secs(60));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    let mut child = again("the_claim_ends_with_a_killed_process", &path, "").spawn().unwrap();
    for _ in 0..600 {
        if folder.path().join("a.h5.ready").exists() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    assert!(matches!(Output::claim(&path), Err(FileError::Busy { .. })));
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(folder.path().join("a.h5.lock").exists(), "a killed process leaves its lock file");
    Output::claim(&path).unwrap();
}

#[cfg(unix)]
#[test]
fn a_full_disk_is_one_clear_line_and_the_good_file_stays() {
    if let Some(path) = std::env::var_os("ARCHIVE_TEST_FILE").map(PathBuf::from) {
        let output = Output::claim(path).unwrap();
        let mut archive = Archive::create(&output, &provenance()).unwrap();
        let x = Dimension::index("x", 1 << 20, "position");
        let noise: Vec<f64> = (0..1 << 20).map(|i| (1e5 * f64::from(i).sin()).fract()).collect();
        let written = archive.write("/noise", &variable(&[&x]), &noise);
        let error = written.and_then(|()| archive.finish().map(drop)).unwrap_err();
        fs::write(output.beside(".message"), error.to_string()).unwrap();
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.h5");
    fs::write(&path, b"good").unwrap();
    // Limit in blocks of 512 bytes; with SIGXFSZ ignored, a write beyond it fails as on a full disk.
    let limit = "trap '' XFSZ; ulimit -f 2048;";
    let status = again("a_full_disk_is_one_clear_line_and_the_good_file_stays", &path, limit).status().unwrap();
    assert!(status.success());
    let line = fs::read_to_string(folder.path().join("a.h5.message")).unwrap();
    assert!(line.starts_with("cannot write /noise to ") && line.ends_with("a.h5.part: File too large"), "{line}");
    assert_eq!(fs::read(&path).unwrap(), b"good");
    assert!(!folder.path().join("a.h5.part").exists());
}

#[test]
fn impossible_targets_are_refused_with_their_name() {
    let folder = tempfile::tempdir().unwrap();
    let line = Output::claim(folder.path()).unwrap_err().to_string();
    assert!(line.ends_with("it is a folder; it must be a file name"), "{line}");
    let line = Output::claim(folder.path().join("no/a.h5")).unwrap_err().to_string();
    assert!(line.contains("no/a.h5: there is no folder ") && !line.contains('\n'), "{line}");
    let file = folder.path().join("file");
    fs::write(&file, b"").unwrap();
    assert!(matches!(Output::claim(file.join("a.h5")), Err(FileError::Target { .. })));
}

#[test]
fn what_does_not_fit_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = Output::claim(folder.path().join("a.h5")).unwrap();
    let mut archive = Archive::create(&output, &provenance()).unwrap();
    let (x, longer) = (Dimension::index("x", 3, "position"), Dimension::index("x", 4, "position"));
    let line = archive.write("/a", &variable(&[&x]), &[1.0, 2.0]).unwrap_err().to_string();
    assert_eq!(line, "/a has 2 values for the shape [3]");
    archive.write("/a", &variable(&[&x]), &[1.0, 2.0, 3.0]).unwrap();
    let error = archive.write("/b", &variable(&[&longer]), &[0.0; 4]).unwrap_err();
    assert!(matches!(error, FileError::Dimension { .. }), "{error}");
    archive.write("/other/b", &variable(&[&longer]), &[0.0; 4]).unwrap();
    assert!(matches!(archive.write("/a", &variable(&[&x]), &[0.0; 3]), Err(FileError::Write { .. })), "twice");
    let error = archive.write_text("/t", &variable(&[]), &["a\0b"]).unwrap_err();
    assert!(matches!(error, FileError::Text { .. }), "{error}");
    archive.define("/s", &variable(&[&x])).unwrap();
    assert!(matches!(archive.write_slab("/s", 3, &[1.0]), Err(FileError::Slab { .. })));
    assert!(matches!(archive.write_slab("/s", 0, &[1.0, 2.0]), Err(FileError::Slab { .. })));
    archive.finish().unwrap();
}

#[test]
fn what_cannot_be_read_says_what_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("all.h5");
    assert!(matches!(Reader::open(&path), Err(FileError::Io { .. })));
    fs::write(&path, b"text").unwrap();
    let line = Reader::open(&path).unwrap_err().to_string();
    assert!(line.contains("as HDF5") && !line.contains('\n'), "{line}");
    write_all(&path);
    let file = read(&path);
    let line = file.values::<f64>("/surface/heigth").unwrap_err().to_string();
    assert!(line.ends_with("has no /surface/heigth; its group has: height, x, y"), "{line}");
    assert!(file.text("/", "nothing").is_err());
    assert!(file.slab::<f64>("/fields/pressure", 2).is_err());
    assert!(file.values::<f64>("/loads/solver").is_err(), "strings are not numbers");
}

#[test]
fn rows_in_blocks_of_chunks_make_the_file_of_whole_fields() {
    let folder = tempfile::tempdir().unwrap();
    let (rows, columns) = (700, 1000);
    let x = Dimension::index("x", rows, "row");
    let y = Dimension::index("y", columns, "column");
    let load = Dimension::index("load", 2, "load step");
    let height: Vec<f64> = (0..rows * columns).map(|i| (i as f64).sin()).collect();
    let file = |name: &str, block: Option<usize>| {
        let path = folder.path().join(name);
        let output = Output::claim(&path).unwrap();
        let mut archive = Archive::create(&output, &provenance()).unwrap();
        let dimensions = [&load, &x, &y];
        let [field, surface] = [&dimensions[..], &dimensions[1..]].map(variable);
        match block {
            None => {
                archive.write("/height", &surface, &height).unwrap();
                archive.define("/pressure", &field).unwrap();
                archive.write_slab("/pressure", 1, &height).unwrap();
            }
            Some(block) => {
                archive.define_rows("/height", &surface).unwrap();
                for (place, values) in height.chunks(block * columns).enumerate() {
                    archive.write_rows("/height", None, place * block, values).unwrap();
                }
                archive.define("/pressure", &field).unwrap();
                for (place, values) in height.chunks(block * columns).enumerate() {
                    archive.write_rows("/pressure", Some(1), place * block, values).unwrap();
                }
                let row = &height[..columns];
                for (path, index, first, values) in [
                    ("/height", Some(0), 0, row),
                    ("/height", None, rows, row),
                    ("/height", None, 0, &row[1..]),
                    ("/pressure", None, 0, row),
                    ("/pressure", Some(2), 0, row),
                ] {
                    let refused = archive.write_rows(path, index, first, values);
                    assert!(matches!(refused, Err(FileError::Slab { .. })), "{path} {index:?} {first}");
                }
            }
        }
        archive.finish().unwrap();
        fs::read(path).unwrap()
    };
    let whole = file("whole.h5", None);
    for chunks in [1, 2, 16] {
        assert!(file(&format!("{chunks}.h5"), Some(chunks * rows_of_chunk(columns))) == whole, "{chunks}");
    }
}

/// The library undoes filters that were applied outside it, also for chunks that extend beyond the edge.
#[test]
fn chunks_of_any_shape_are_read_by_the_library() {
    let folder = tempfile::tempdir().unwrap();
    for (place, shape) in [&[300_001][..], &[3, 270_000], &[5, 600], &[700, 1001], &[2, 300, 1001]].iter().enumerate() {
        let lengths: Vec<Dimension> = shape
            .iter()
            .enumerate()
            .map(|(axis, length)| Dimension::index(&format!("axis{axis}"), *length, ""))
            .collect();
        let dimensions: Vec<&Dimension> = lengths.iter().collect();
        let count = shape.iter().product::<usize>();
        let reals: Vec<f64> = (0..count).map(|i| (i as f64).sin()).collect();
        let integers: Vec<u32> = (0..count as u32).map(|i| i.wrapping_mul(2_654_435_761)).collect();
        let file = |threads: usize| {
            let path = folder.path().join(format!("{place}-{threads}.h5"));
            let output = Output::claim(&path).unwrap();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                let mut archive = Archive::create(&output, &provenance()).unwrap();
                archive.write("/reals", &variable(&dimensions), &reals).unwrap();
                archive.write("/integers", &variable(&dimensions), &integers).unwrap();
                archive.finish().unwrap();
            });
            path
        };
        let [one, three] = [1, 3].map(file);
        assert!(fs::read(&one).unwrap() == fs::read(three).unwrap(), "{shape:?}");
        let file = File::open(&one).unwrap();
        assert!(file.dataset("reals").unwrap().is_chunked());
        assert!(file.dataset("reals").unwrap().read_raw::<f64>().unwrap() == reals, "{shape:?}");
        assert!(file.dataset("integers").unwrap().read_raw::<u32>().unwrap() == integers, "{shape:?}");
    }
}
