//! Measured surfaces from end to end: contents of their files, preparation, and record.

use std::path::Path;

use crate::common::{gfmd, json};
use gfmd_files::{Reader, Topography};

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

/// Creates a folder with files of other programs (crates/topography/tests/data/make.py) and a scan with two channels
/// and a hole.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../topography/tests/data");
    for name in ["two.gwy", "holes.nc", "int16.x3p", "small.mat"] {
        std::fs::copy(data.join(name), folder.path().join(name)).unwrap();
    }
    let rows = (0..8).map(|j| {
        let height =
            |i: i32| if (i, j) == (3, 5) { "NaN".into() } else { format!("{}", ((5 * i + 3 * j) % 7) * 4 + i) };
        (0..10).map(height).collect::<Vec<String>>().join(" ")
    });
    let header = "# Channel: Height\n# Width: 10 µm\n# Height: 8 µm\n# Value units: nm\n";
    std::fs::write(folder.path().join("scan.txt"), header.to_owned() + &rows.collect::<Vec<_>>().join("\n")).unwrap();
    folder
}

#[test]
fn channels_are_listed_without_reading_them() {
    let folder = folder();
    let list = json(folder.path(), &words("surface --surface small.mat --list --json"));
    assert_eq!((&list["format"], list["channels"].as_array().unwrap().len()), (&"MATLAB 5".into(), 3));
    let channel = &list["channels"][1];
    assert_eq!(
        (&channel["name"], &channel["n"], &channel["default"]),
        (&"single".into(), &vec![5, 4].into(), &false.into())
    );
    let text = String::from_utf8(gfmd(folder.path(), &words("surface --surface two.gwy --list")).stdout).unwrap();
    assert!(text.contains("two.gwy: Gwyddion\n"), "{text}");
    assert!(text.contains("   0  Topography"), "{text}");
    assert!(text.contains("m      5 x 4"), "{text}");
}

#[test]
fn undefined_points_are_refused_with_their_number_and_the_flag() {
    let folder = folder();
    for command in
        ["surface", "contact --p-star 0.1", "path --p-star 0.1,0.2 --law exponential --param gamma=1,range=1"]
    {
        let output = gfmd(folder.path(), &words(&format!("{command} --surface scan.txt")));
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{command}: {message}");
        assert_eq!(
            message,
            "error: scan.txt, channel Height: 1 of 80 points are undefined, the first at [x, y] = [3, 5]; every point \
             must have a height: --fill harmonic or --fill nearest gives them heights, and gfmd.read_heights of Python \
             reads them as NaN, to cut the good part out\n",
            "{command}"
        );
    }
    let output = gfmd(folder.path(), &words("surface --surface scan.txt --fill linear"));
    assert!(String::from_utf8(output.stderr).unwrap().contains("harmonic"));
    let output = gfmd(folder.path(), &words("surface --fill nearest"));
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn what_was_done_stands_in_every_output() {
    let folder = folder();
    let flags = "--surface scan.txt --channel Height --detrend plane --fill harmonic --periodise mirror";
    let done = "least-squares plane removed, 1 undefined points filled harmonically, mirrored to a periodic cell of \
                twice the size";
    let surface = json(folder.path(), &words(&format!("surface {flags} --window hann --out h.h5 --plots h --json")));
    assert!(surface["source"].as_str().unwrap().contains(done), "{}", surface["source"]);
    assert_eq!((&surface["window"], &surface["n"]), (&"hann".into(), &vec![20, 16].into()));
    let scan = &surface["scan"];
    assert_eq!(scan["notes"][0], "lengths converted from µm to nm, 1 µm = 1000 nm");
    assert_eq!((&scan["undefined"], &scan["fill"], &scan["n"]), (&1.into(), &"harmonic".into(), &vec![10, 8].into()));
    assert_eq!(
        (&scan["unit"], scan["resolves"][0].as_f64(), scan["resolves"][1].as_f64()),
        (&"nm".into(), Some(8000.0), Some(2000.0))
    );
    assert!(scan["defined"]["rms_height"].as_f64().unwrap() > 0.0);
    for name in ["map", "profile", "spectrum"] {
        assert!(folder.path().join(format!("h-{name}.png")).exists());
    }
    let contact = json(folder.path(), &words(&format!("contact {flags} --e-star 1 --p-star 0.1 --out c.h5 --json")));
    assert_eq!((&contact["surface"], &contact["scan"]), (&surface["source"], scan));
    let path = json(
        folder.path(),
        &words(&format!(
            "path {flags} --e-star 1 --p-star 0.01,0.02 --steps 1 --friction 0.3 --lateral 0,1 --out p.h5 --json"
        )),
    );
    assert_eq!((&path["surface"], &path["scan"]), (&surface["source"], scan));
    for (file, attribute) in [("h.h5", "source"), ("c.h5", "description"), ("p.h5", "description")] {
        let file = Reader::open(folder.path().join(file)).unwrap();
        assert!(file.text("/surface", attribute).unwrap().contains(done));
        assert_eq!(file.text("/surface", "fill").unwrap(), "harmonic");
        assert_eq!(file.text("/surface", "format").unwrap(), "text");
        assert_eq!(file.number("/surface", "undefined_points").unwrap(), 1.0);
        let config = file.text("/", "config").unwrap();
        for line in ["channel = \"Height\"", "fill = \"harmonic\"", "detrend = \"plane\"", "periodise = \"mirror\""] {
            assert!(config.contains(line), "{config}");
        }
    }
    let body = json(folder.path(), &words("body --surface c.h5 --depths 0 --out b.h5 --json"));
    assert!(body["surface"].as_str().unwrap().contains(done), "{}", body["surface"]);
    assert!(Reader::open(folder.path().join("b.h5")).unwrap().text("/", "config").unwrap().contains(done));
}

#[test]
fn units_and_sizes_that_are_unknown_are_said_to_be() {
    let folder = folder();
    let notes =
        |flags: &str| json(folder.path(), &words(&format!("surface {flags} --json")))["scan"]["notes"].to_string();
    let found = notes("--surface small.mat");
    assert!(
        found.contains("the file has no size; the cell is taken to be 1 long")
            && found.contains("the file has no unit")
    );
    let found = notes("--surface int16.x3p --fill nearest --size 2");
    assert!(found.contains("the given size replaces the one in the file"), "{found}");
}

#[test]
fn surfaces_are_written_as_x3p() {
    let folder = folder();
    let flags = "surface --surface int16.x3p --fill nearest --out out.x3p --json";
    let scan = json(folder.path(), &words(flags));
    let read = |name: &str| Topography::read(folder.path().join(name).to_str().unwrap(), None).unwrap();
    let (before, after) = (read("int16.x3p"), read("out.x3p"));
    assert_eq!((after.undefined, after.lengths, &after.unit), (0, before.lengths, &before.unit));
    assert!(before.heights.iter().zip(&after.heights).all(|(before, after)| before.is_nan() || before == after));
    assert!(after.details.iter().any(|(key, value)| key == "Comment" && value.contains("2 undefined points filled")));
    assert_eq!(scan["out"], "out.x3p");
    json(folder.path(), &words("surface --n 16 --eps-f-inv 2 --out made.x3p --json"));
    json(folder.path(), &words("surface --n 16 --eps-f-inv 2 --out made.npy --json"));
    assert_eq!(read("made.x3p").heights, read("made.npy").heights);
    let comment = read("made.x3p").details.into_iter().find(|(key, _)| key == "Comment").unwrap().1;
    assert!(comment.ends_with("; the unit is unknown; the numbers were written as metres"), "{comment}");
}
