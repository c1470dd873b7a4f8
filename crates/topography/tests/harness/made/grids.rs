//! Files with one grid of numbers behind a short head.

use super::{Bytes, POINTS, fixed, is_undefined, joined, lines, lines_upwards};

/// Returns the heights line by line, with `undefined` for the point without a height.
fn floats(undefined: f32) -> Vec<u8> {
    let number = |(index, height)| if is_undefined(index) { undefined } else { f32::from(height) };
    joined(lines().enumerate().map(number).map(f32::to_le_bytes))
}

/// TrueMap: 2.5 by 1 mm, heights in mm.
pub(crate) fn tmd(comment: &str) -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i32);
    let head = Bytes::default().add("Binary TrueMap Data File v2.0\r\n\0").add(comment).zeros(1).ints(&[nx, ny]);
    head.floats(&[2.5, 1.0, 0.0, 0.5]).add(floats(f32::NAN)).0
}

/// NanoFocus: pixels of 500 and 250 nm, heights of 0.125 µm per count from a count of 1000 on.
pub(crate) fn nms(has_intensity: bool) -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i32);
    let counts = lines().map(|height| height + 1000).collect::<Vec<i16>>();
    let mut head = Bytes::default().ints(&[2, 1, 0, 65536]).doubles(&[-125.0, 8067.0]).add("OM_MS_2.0").zeros(1035);
    head = head.add(fixed("2024-02-29", 292)).ints(&[nx, ny]).doubles(&[500.0, 250.0]).zeros(24);
    head = head.ints(&[i32::from(has_intensity)]).zeros(2048).shorts(&counts);
    let intensities: Vec<u8> = (0..counts.len()).map(|index| if is_undefined(index) { 0 } else { 90 }).collect();
    head.add(if has_intensity { intensities } else { vec![] }).0
}

/// OmniSurf3D: pixels of 0.5 and 0.25 µm, heights in µm.
pub(crate) fn os3d(has_date: bool) -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i32);
    let mut head = Bytes::default().add("OmniSurf3D").ints(&[1, i32::from(has_date), 4]).add("made");
    if has_date {
        head = head.ints(&[8]).add("20240229");
    }
    head.ints(&[nx, ny]).doubles(&[0.5, 0.25, 7.0, 8.0]).add(floats(f32::MIN)).zeros(1).0
}

/// Zeta: pixels of 0.5 and 0.25 µm, heights of 0.125 µm per count above 150.
pub(crate) fn zmg() -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i32);
    let head =
        Bytes::default().add("Zeta-Instruments").zeros(69).ints(&[nx, ny, 0]).floats(&[0.5, 0.25, 0.125]).zeros(8);
    let counts: Vec<i16> = lines().map(|height| height + 150).collect();
    head.ints(&[7]).zeros(84).add("comment").shorts(&counts).0
}

/// BCR: 2.5 by 1 µm, heights in nm, of 0.125 nm for an integer.
pub(crate) fn bcr(is_integer: bool, is_wide: bool) -> Vec<u8> {
    let kind = ["bcrf", "bcrstm"][usize::from(is_integer)].to_owned() + if is_wide { "_unicode" } else { "" };
    let head = format!(
        "fileformat = {kind}\r\nheadersize = 400\r\nxpixels = 5\r\nypixels = 4\r\nxlength = 2.5\r\nylength = 1000\r\n\
         xunit = \u{b5}m\r\nyunit = nm\r\nbit2nm = 0.125\r\n% a comment\r\n"
    );
    let characters = head.chars().chain(std::iter::repeat(' '));
    let head: Vec<u8> = match is_wide {
        true => joined(std::iter::once('\u{feff}').chain(characters).take(400).map(|c| (c as u16).to_le_bytes())),
        false => characters.take(400).map(|c| c as u8).collect(),
    };
    let counts = lines().enumerate().map(|(index, height)| if is_undefined(index) { i16::MAX } else { height });
    [head, if is_integer { joined(counts.map(i16::to_le_bytes)) } else { floats(f32::MAX) }].concat()
}

/// FRT: 2.5 by 1 m, heights of 0.125 m per count.
pub(crate) fn frt(has_images: bool) -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i32);
    let mut counts: Vec<i32> = lines_upwards().map(i32::from).collect();
    // The point without a height, in the order from the bottom.
    counts[2 * POINTS[0] + 2] = 1;
    let block = |number: i16, content: Vec<u8>| {
        let length = Bytes::default().shorts(&[number]).ints(&[content.len() as i32]);
        if has_images { length.ints(&[0]) } else { length }.add(content).0
    };
    let head = Bytes::default().ints(&[nx, ny, 32]).0;
    let data = Bytes::default().ints(&counts).0;
    let images = Bytes::default().zeros(8).ints(&[2]).add(&head).zeros(80).ints(&[4]).add(&head).add(&data).0;
    let last = if has_images { block(0x7d, images) } else { block(0x0b, data) };
    let head = [block(0x65, b"made".to_vec()), block(0x66, head)].concat();
    let size = block(0x67, Bytes::default().doubles(&[2.5, 1.0, 0.0]).0);
    let scale = block(0x6c, Bytes::default().ints(&[3]).doubles(&[0.125]).0);
    let version = ["1.00", "1.01"][usize::from(has_images)];
    Bytes::default().add("FRTM_GLIDERV").add(version).shorts(&[5]).add([head, size, scale, last].concat()).0
}

/// Surfer: spacings of 0.5 and 0.25 without a unit, in version 6 or 7.
pub(crate) fn surfer(version: i32) -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i32);
    let mut heights: Vec<f64> = lines_upwards().map(f64::from).collect();
    heights[2 * POINTS[0] + 2] = 1.70141e38;
    if version == 6 {
        let head = Bytes::default()
            .add("DSBB")
            .shorts(&[nx as i16, ny as i16])
            .doubles(&[10.0, 12.0, 20.0, 20.75, -150.0, 271.0]);
        return head.add(joined(heights.iter().map(|height| (*height as f32).to_le_bytes()))).0;
    }
    let head = Bytes::default().add("DSRB").ints(&[4, 1]).add("GRID").ints(&[72, ny, nx]);
    let head = head.doubles(&[10.0, 20.0, 0.5, 0.25, -150.0, 271.0, 0.0, 1.70141e38]);
    head.add("DATA").ints(&[8 * nx * ny]).doubles(&heights).0
}
