//! Files of Olympus.

use zip::CompressionMethod;

use super::{Bytes, joined, lines, zipped};

/// OIR: pixels of 0.5 and 0.25 µm, heights of 0.125 µm per count above 150.
pub(crate) fn oir() -> Vec<u8> {
    let channel = |id: &str, kind: &str| {
        [
            &format!("<p:channel id=\"{id}\">"),
            "<length><x>0.5</x><y>0.5</y><z>0.125</z></length>",
            "<pixelUnit><x>um</x><y>um</y><z>um</z></pixelUnit>",
            &format!("<imageDefinition><imageType>{kind}</imageType><depth>2</depth></imageDefinition></p:channel>"),
        ]
        .concat()
    };
    let channels = [channel("a-1", "INTENSITY"), channel("a-2", "HEIGHT"), channel("a-3", "INVALID")].concat();
    let properties = [
        "<?xml version=\"1.0\"?><p:imageProperties xmlns:p=\"u\">",
        "<general><creationDateTime>2024</creationDateTime></general><imageInfo><width>5</width><height>4</height>",
        &format!("<phase><group>{channels}</group></phase></imageInfo>"),
        "<acquisition><pixelCalibration><x>1</x><y>0.5</y></pixelCalibration></acquisition></p:imageProperties>",
    ]
    .concat();
    let block = Bytes::default().ints(&[2]).zeros(32).ints(&[properties.len() as i32]).add(&properties).0;
    let chunk = |kind: i32, content: &[u8]| Bytes::default().ints(&[content.len() as i32, kind]).add(content).0;
    let image = |id: &str, lowest: i16| {
        let counts = joined(lines().map(|height| (height + lowest).to_le_bytes()));
        let name = format!("t001_0_1_{id}_0");
        let head = Bytes::default().ints(&[0, 40, name.len() as i32]).add(name).0;
        Bytes::default().add(chunk(3, &head)).ints(&[40, 4]).add(counts).0
    };
    let images = [image("a-1", 200), image("a-2", 150), image("a-3", 151)].concat();
    let head = Bytes::default().add("OLYMPUSRAWFORMAT").zeros(80).add(chunk(2, b"BMP\0BM"));
    head.add(images).add(chunk(0, &block)).ints(&[-1, 96]).0
}

/// Archive with such a file, and another.
pub(crate) fn poir() -> Vec<u8> {
    zipped(&[("note.txt", b"made".to_vec()), ("LSM.oir", oir())], CompressionMethod::Deflated)
}
