//! Colours: a palette of seven for colour-blind readers, and perceptually uniform scales.

/// Red, green, blue.
pub(super) type Rgb = [u8; 3];

/// Colour of text and axes.
pub(super) const INK: Rgb = [0x22, 0x22, 0x22];

/// Colour of reference lines and their labels.
pub(super) const REFERENCE: Rgb = [0x6b, 0x6b, 0x6b];

/// Colour of uncoloured points on a map.
pub(super) const PALE: Rgb = [0xe9, 0xe9, 0xe6];

/// Okabe and Ito's colours (Color Universal Design, 2008) without yellow, which is too light for lines.
const HUES: [Rgb; 7] = [
    [0x00, 0x72, 0xb2],
    [0xd5, 0x5e, 0x00],
    [0x00, 0x9e, 0x73],
    [0xcc, 0x79, 0xa7],
    [0xe6, 0x9f, 0x00],
    [0x56, 0xb4, 0xe9],
    [0x22, 0x22, 0x22],
];

pub(super) fn hue(index: usize) -> Rgb {
    HUES[index % HUES.len()]
}

pub(super) fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Returns the colour of a sequential map at a fraction from 0 to 1: viridis, dark to light, perceptually uniform.
pub(super) fn sequential(fraction: f64) -> Rgb {
    colorous::VIRIDIS.eval_continuous(fraction.clamp(0.0, 1.0)).as_array()
}

/// Returns the colour of a diverging map at a fraction from 0 to 1: red, white in the middle, blue.
pub(super) fn diverging(fraction: f64) -> Rgb {
    colorous::RED_BLUE.eval_continuous(fraction.clamp(0.0, 1.0)).as_array()
}

/// Mixes `share` of `a` with 1 − `share` of `b`, linearly in light intensity.
pub(super) fn mix(a: Rgb, b: Rgb, share: f64) -> Rgb {
    let light = |c: u8| (f64::from(c) / 255.0).powf(2.2);
    let channel = |a, b| (255.0 * (share * light(a) + (1.0 - share) * light(b)).powf(1.0 / 2.2)).round() as u8;
    [channel(a[0], b[0]), channel(a[1], b[1]), channel(a[2], b[2])]
}
