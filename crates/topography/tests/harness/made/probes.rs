//! Files of probe microscopes.

use super::{Bytes, POINTS, UNDEFINED, height, joined, lines_upwards};

/// WSxM: 2.5 by 1 µm, heights in nm, of 0.125 nm for an integer.
pub(crate) fn wsxm(is_integer: bool) -> Vec<u8> {
    let kind = if is_integer { "short" } else { "double" };
    let head = [
        "WSxM file copyright UAM",
        "SxM Image file",
        "Image header size: 9",
        "[Control]",
        "    X Amplitude: 2.5 \u{b5}m",
        "    Y Amplitude: 1 \u{b5}m",
        "[General Info]",
        "    Acquisition channel: Topography",
        &format!("    Image Data Type: {kind}"),
        "    Number of columns: 5",
        "    Number of rows: 4",
        "    Z Amplitude: 128 nm",
        "[Miscellaneous]",
        "    Maximum: 1000",
        "    Minimum: -24",
        "[Palette]",
        "    Maximum: 9",
        "    Minimum: 0",
        "[Header end]",
        "",
    ];
    let mut bytes: Vec<u8> = head.join("\r\n").chars().map(|character| character as u8).collect();
    let [nx, ny] = POINTS;
    let turned = (0..ny).rev().flat_map(|y| (0..nx).rev().map(move |x| height(x, y)));
    match is_integer {
        true => bytes.extend(joined(turned.map(i16::to_le_bytes))),
        false => bytes.extend(joined(turned.map(|height| (0.125 * f64::from(height)).to_le_bytes()))),
    }
    bytes
}

/// Nanonis: 2.5 by 1 m, heights in m, both ways.
pub(crate) fn sxm(is_down: bool) -> Vec<u8> {
    let direction = if is_down { "down" } else { "up" };
    let head = [
        ":NANONIS_VERSION:",
        "2",
        ":SCANIT_TYPE:",
        "  FLOAT  MSBFIRST",
        ":REC_DATE:",
        " 29.02.2024",
        ":SCAN_PIXELS:",
        "  5  4",
        ":SCAN_RANGE:",
        "  2.5E+0  1.0E+0",
        ":SCAN_DIR:",
        direction,
        ":DATA_INFO:",
        "\tChannel\tName\tUnit\tDirection\tCalibration\tOffset",
        "\t0\tCurrent\tA\tforward\t1E-9\t0",
        "\t14\tZ\tm\tboth\t9E-9\t0",
        "",
        ":SCANIT_END:",
        "",
        "",
        "\x1a\x04",
    ]
    .join("\n");
    let [nx, ny] = POINTS;
    let heights = |is_backward: bool| -> Vec<u8> {
        let points = (0..ny).flat_map(|y| (0..nx).map(move |x| (x, y)));
        joined(points.map(|(x, y)| {
            let [x, y] = [if is_backward { nx - 1 - x } else { x }, if is_down { y } else { ny - 1 - y }];
            let number = if [x, y] == UNDEFINED { f32::from_bits(0x7fff_ffff) } else { f32::from(height(x, y)) };
            number.to_be_bytes()
        }))
    };
    [head.into_bytes(), vec![0; 4 * nx * ny], heights(false), heights(true)].concat()
}

/// NT-MDT: a text, a scan of a deflection, and a scan with pixels of 0.5 and 0.25 µm and heights of 0.125 nm per count.
pub(crate) fn mdt() -> Vec<u8> {
    let [nx, ny] = POINTS.map(|n| n as i16);
    let frame = |kind: i16, variables: &[u8], body: &[u8]| {
        let length = (22 + variables.len() + body.len()) as i32;
        let head = Bytes::default().ints(&[length]).shorts(&[kind, 0, 2024, 2, 29, 12, 34, 56, variables.len() as i16]);
        head.add(variables).add(body).0
    };
    let scan = |signal: u8, unit: i16| {
        let axis = |bytes: Bytes, step: f32, unit: i16| bytes.floats(&[0.0, step]).shorts(&[unit]);
        let axes = axis(axis(axis(Bytes::default(), 0.5, -2), -0.25, -2), 0.125, unit);
        let variables = axes.add([signal, 1]).shorts(&[nx, ny]).zeros(9).0;
        let counts: Vec<i16> = lines_upwards().collect();
        let body = Bytes::default().shorts(&[0, nx, ny, 1]).zeros(30).shorts(&counts).ints(&[5]).add("\u{48}eigh").0;
        frame(0, &variables, &body)
    };
    let frames = [frame(3, &[], b"note"), scan(1, 3), scan(0, -1)].concat();
    Bytes::default().add(b"\x01\xb0\x93\xff").ints(&[frames.len() as i32, 0]).shorts(&[2]).zeros(19).add(frames).0
}

/// NT-MDT: a map as a frame with two dimensions, with pixels of 0.5 and 0.25 µm and heights of 0.125 µm per count.
pub(crate) fn mda() -> Vec<u8> {
    let calibration = |name: &str, scale: f64, last: i32, kind: i32| {
        let sizes = Bytes::default().ints(&[name.len() as i32, 0, 2, 0, 0]).zeros(16).doubles(&[0.0, scale]);
        let body = sizes.ints(&[0, 0, last, 0, kind, 0]).zeros(8).0;
        let total = 8 + body.len() + name.len() + 2;
        Bytes::default().ints(&[total as i32, body.len() as i32]).add(body).add(name).add(b"\xb5m").0
    };
    let [nx, ny] = POINTS.map(|n| n as i32);
    let axes = [calibration("X", 0.5, nx - 1, -4), calibration("Y", 0.25, ny - 1, -4), calibration("Z", 0.125, 0, -2)];
    let variables = Bytes::default().ints(&[0, 20, nx * ny, 0, 2, 2, 1]).add(axes.concat()).0;
    let counts: Vec<i16> = lines_upwards().collect();
    let data = 33 + 22 + 76 + 6 + variables.len();
    let sizes = [6, 0, 0, 0, 0, variables.len() as i32, data as i32, 2 * nx * ny];
    let body = Bytes::default().ints(&[76, 0]).zeros(36).ints(&sizes).add("Height").add(variables).shorts(&counts).0;
    let frame = Bytes::default().ints(&[22 + body.len() as i32]).shorts(&[106]).zeros(16).add(body).0;
    Bytes::default().add(b"\x01\xb0\x93\xff").ints(&[frame.len() as i32, 0]).zeros(21).add(frame).0
}
