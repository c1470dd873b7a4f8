//! Files of Keyence.

use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use zip::CompressionMethod;

use super::{Bytes, POINTS, is_undefined, joined, lines, zipped};

/// VK3 and VK4: pixels of 0.5 and 0.25 µm, heights of 0.125 µm per count above 150; VK4 has another image of heights.
pub(crate) fn vk(version: u8) -> Vec<u8> {
    let entries = if version == 3 { 17 } else { 18 };
    let start = 12 + 4 * entries;
    let mut conditions = vec![0; 45];
    conditions[..4].copy_from_slice(&[180, 2024, 2, 29]);
    conditions[42..].copy_from_slice(&[500_000, 250_000, 125_000]);
    let image = |factor: i32, bits: i32| {
        let [nx, ny] = POINTS.map(|n| n as i32);
        let counts = lines().map(|height| factor * (i32::from(height) + 150));
        let data: Vec<u8> = counts.flat_map(|count| count.to_le_bytes().into_iter().take(bits as usize / 8)).collect();
        Bytes::default().ints(&[nx, ny, bits, 0, data.len() as i32, 0, 0]).zeros(768).add(data).0
    };
    let images = [image(1, if version == 3 { 16 } else { 32 }), image(2, 32)];
    let mut table = vec![0; entries];
    table[0] = start as i32;
    table[6] = start as i32 + 180;
    if version == 4 {
        table[7] = table[6] + images[0].len() as i32;
    }
    let head = Bytes::default().add(format!("VK{version}_")).zeros(8).ints(&table).ints(&conditions);
    head.add(images.concat()).0
}

/// VK6 and VK7: a picture and an archive with VK4; VK6 has a mark of a point that was not measured.
pub(crate) fn vk_archive(version: u8) -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i32);
    let marks: Vec<u8> = (0..20).map(|index| u8::from(is_undefined(index))).collect();
    let marks = Bytes::default().ints(&[nx, ny, 1, nx]).add(marks).0;
    let marks = zipped(&[("ErrorImageData", marks)], CompressionMethod::Stored);
    let mut members = vec![("Vk4File", vk(4))];
    if version == 6 {
        members.push(("Vk6ImageData", marks));
    }
    let picture = Bytes::default().add(format!("VK{version}")).ints(&[8]).add("BM").zeros(6);
    picture.add(zipped(&members, CompressionMethod::Deflated)).0
}

/// ZON of version 0 or 1, whose members are frames of Zstandard: pixels of 0.5 m, heights of 0.125 m, lines padded to
/// 24 bytes; a point was not measured, another has a mark.
pub(crate) fn zon(version: u8) -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i32);
    let calibration = "\u{feff}<Calibration><XYCalibration><MeterPerPixel>0.5</MeterPerPixel></XYCalibration>\
                       <ZCalibration><MeterPerUnit>0.125</MeterPerUnit></ZCalibration></Calibration>";
    let heights: Vec<i32> = lines().map(i32::from).collect();
    let heights = heights.chunks(5).flat_map(|line| [line, &[-590_000]].concat()).map(i32::to_le_bytes);
    let marks: Vec<u8> =
        (0..20).map(|index| if is_undefined(index) { 0x82 } else { u8::from(index == 0) * 0x40 }).collect();
    let marks = marks.chunks(5).flat_map(|line| [line, &[0]].concat()).collect::<Vec<u8>>();
    let members = [
        ("686613b8-27b5-4a29-8ffc-438c2780873e", calibration.as_bytes().to_vec()),
        ("4cdb0c75-5706-48cc-a9a1-adf395d609ae", Bytes::default().ints(&[nx, ny, 4, 24]).add(joined(heights)).0),
        ("9e7ca6dd-0e6a-4d7b-8986-f0a7b773c916", Bytes::default().ints(&[nx, ny, 1, 6]).add(marks).0),
    ];
    let members = members.map(|(name, bytes)| match version {
        0 => (name, bytes),
        _ => (name, compress_to_vec(&bytes[..], CompressionLevel::Fastest)),
    });
    let picture = Bytes::default().add(format!("KPK{version}")).ints(&[8]).add("BM").zeros(6);
    picture.add(zipped(&members, CompressionMethod::Stored)).0
}
