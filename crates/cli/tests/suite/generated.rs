//! Heights of a given distribution, and heights from a picture, from end to end.

use crate::common::{gfmd, json};
use std::path::Path;

fn words(flags: &str) -> Vec<&str> {
    flags.split_whitespace().collect()
}

fn refused(folder: &Path, flags: &str, said: &str) {
    let output = gfmd(folder, &words(flags));
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), message.lines().count()), (Some(2), 1), "{flags}: {message}");
    assert!(message.contains(said), "{flags}: {message}");
}

#[test]
fn a_distribution_is_named_or_stands_in_a_table() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("ratio.csv"), "height [um], probability\n-1, 0\n1, 1\n").unwrap();
    let surface = "surface --n 128 --eps-t-inv 4 --eps-f-inv 8 --json";
    let number = |flags: &str, key: &str| {
        let found = json(folder.path(), &words(&format!("{surface} {flags}")));
        found[key].as_f64().unwrap_or_else(|| panic!("{key} in {found}"))
    };
    assert!((number("--marginal weibull:-1.5", "ssk") + 1.072).abs() < 0.02);
    assert!((number("--marginal lognormal:0.3", "ssk") - 0.9495).abs() < 0.02);
    let [of_rows, of_file] = ["--marginal=-1:0,1:1", "--size 10um --marginal ratio.csv"]
        .map(|flags| [number(flags, "sku"), number(flags, "rms_gradient")]);
    assert!((of_rows[0] - 1.8).abs() < 0.05 && (of_rows[1] - 0.1).abs() < 1e-12, "{of_rows:?}");
    assert!((of_rows[0] - of_file[0]).abs() < 1e-9, "{of_rows:?} {of_file:?}");
    refused(folder.path(), "surface --marginal none.csv", "none.csv");
    refused(folder.path(), "surface --marginal weibull:0", "the shape is 0; it must be between 0.5 and 100");
    refused(folder.path(), "surface --marginal lognormal:1 --n 64", "away from the distribution");
    refused(folder.path(), "surface --marginal weibull:2 --method rmd", "--marginal is weibull:2; it must be left out");
    refused(folder.path(), "surface --shape sphere:R=1 --marginal weibull:2", "--marginal describes roughness");
    refused(folder.path(), "surface --surface a.sur --marginal weibull:2", "--marginal");
}

#[test]
fn a_contact_of_such_heights_is_checked_and_repeated() {
    let folder = tempfile::tempdir().unwrap();
    let contact = "contact --n 32 --eps-t-inv 2 --eps-f-inv 4 --marginal weibull:-2 --p-star 0.05 --out c.h5 --json -q";
    for flags in ["", "--grid-error refine --boundary free", "--lower-seed 2 --height 0.2 --young 1 --poisson 0.3"] {
        let report = json(folder.path(), &words(&format!("{contact} {flags}")));
        assert_eq!(report["loads"][0]["converged"], true, "{flags}");
        for check in ["check c.h5", "check c.h5 --rerun"] {
            let output = gfmd(folder.path(), &words(check));
            assert!(output.status.success(), "{flags} {check}: {}", String::from_utf8_lossy(&output.stderr));
        }
        std::fs::remove_file(folder.path().join("c.h5")).unwrap();
    }
}

/// Returns a PNG of 16 × 12 grey numbers of 8 bits.
fn picture() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 16, 12);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    let data: Vec<u8> = (0..16 * 12).map(|k: u32| (k * k * 7 % 251) as u8).collect();
    encoder.write_header().unwrap().write_image_data(&data).unwrap();
    bytes
}

#[test]
fn a_picture_is_a_surface_only_if_the_user_says_so() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("grey.png"), picture()).unwrap();
    refused(folder.path(), "surface --surface grey.png", "if they are heights, say so by --image-heights");
    refused(folder.path(), "surface --image-heights --n 16", "--image-heights");
    let list = json(folder.path(), &words("surface --surface grey.png --list --json"));
    assert_eq!(list["format"], "PNG");
    let found = json(folder.path(), &words("surface --surface grey.png --image-heights --json"));
    assert_eq!((&found["n"][0], &found["n"][1]), (&16.into(), &12.into()));
    let contact = "contact --surface grey.png --image-heights --size 2um --unit um --young 1GPa --poisson 0.3 --p-star \
                   0.1 --out c.h5 --json -q";
    assert_eq!(json(folder.path(), &words(contact))["loads"][0]["converged"], true);
    for check in ["check c.h5", "check c.h5 --rerun"] {
        let output = gfmd(folder.path(), &words(check));
        assert!(output.status.success(), "{check}: {}", String::from_utf8_lossy(&output.stderr));
    }
}
