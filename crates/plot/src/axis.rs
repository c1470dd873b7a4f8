//! Range and ticks of an axis, with round numbers, superscripts for powers of ten and true minus signs.

use super::{PlotError, Scale};

/// Largest absolute value of an axis end.
const LARGEST: f64 = 1e307;

/// Minimum length of a linear axis, and minimum lower end of a logarithmic one.
const SMALLEST: f64 = 1e-304;

/// Minimum length of a linear axis relative to its ends, so that its ticks still differ.
const NARROWEST: f64 = 1e-13;

/// Axis with its range and ticks.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ticks {
    scale: Scale,
    range: [f64; 2],
    /// Positions and labels.
    pub(super) major: Vec<(f64, String)>,
    pub(super) minor: Vec<f64>,
    /// Common power of ten of linear labels as markup; may be empty.
    pub(super) factor: String,
}

impl Ticks {
    /// Chooses the ticks; `about` is the number of labels that fit.
    pub(super) fn new(scale: Scale, range: [f64; 2], about: f64) -> Result<Self, PlotError> {
        let [low, high] = range;
        // Beyond these sizes, steps, powers of ten and distances can no longer be represented.
        let largest = low.abs().max(high.abs());
        let is_drawable = largest <= LARGEST && high - low >= SMALLEST && high - low > NARROWEST * largest;
        if !(low.is_finite() && high.is_finite() && low < high && is_drawable) {
            return Err(PlotError::BadRange { range });
        }
        match scale {
            Scale::Linear => Ok(Self::linear(range, about)),
            Scale::Log if low >= SMALLEST => Ok(Self::log(range, about)),
            Scale::Log => Err(PlotError::BadRange { range }),
        }
    }

    /// Returns the relative position of a value along the axis: 0 at the lower end, 1 at the upper end.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        match self.scale {
            Scale::Linear => (value - low) / (high - low),
            Scale::Log => (value / low).ln() / (high / low).ln(),
        }
    }

    fn linear(range: [f64; 2], about: f64) -> Self {
        let [low, high] = range;
        let rough = (high - low) / about.max(1.0);
        let decade = 10_f64.powf(rough.log10().floor());
        let (multiple, parts) = [(1.0, 5), (2.0, 4), (5.0, 5), (10.0, 5)]
            .into_iter()
            .find(|(m, _)| m * decade >= rough * 0.999)
            .unwrap_or((10.0, 5));
        let step = multiple * decade;
        let largest = low.abs().max(high.abs());
        // Numbers from 0.001 to 99999 are written in full. Others share a power of ten, with an exponent divisible by
        // three, that leaves 0.1 to 99.
        let power = if (1e-3..1e5).contains(&largest) { 0 } else { 3 * ((largest.log10() + 1.0) / 3.0).floor() as i32 };
        let unit = 10_f64.powi(power);
        let decimals = (-(step / unit * 1.000_001).log10().floor()).max(0.0) as usize;
        let positions = |step: f64| {
            let (first, last) = ((low / step - 1e-9).ceil() as i64, (high / step + 1e-9).floor() as i64);
            (first..=last).map(move |i| i as f64 * step)
        };
        let label = |value: f64| minus(&format!("{:.decimals$}", value / unit + 0.0));
        let major: Vec<(f64, String)> = positions(step).map(|value| (value, label(value))).collect();
        let minor = positions(step / f64::from(parts))
            .filter(|value| major.iter().all(|(position, _)| (position - value).abs() > 1e-6 * step))
            .collect();
        let factor = if power == 0 { String::new() } else { format!("×10^{{{}}}", minus(&power.to_string())) };
        Self { scale: Scale::Linear, range, major, minor, factor }
    }

    fn log(range: [f64; 2], about: f64) -> Self {
        let [low, high] = range;
        let (first, last) = ((low * (1.0 - 1e-9)).log10().ceil() as i32, (high * (1.0 + 1e-9)).log10().floor() as i32);
        let inside = |value: &f64| *value >= low * (1.0 - 1e-9) && *value <= high * (1.0 + 1e-9);
        let between = |digits: &[i32]| -> Vec<f64> {
            (first - 1..=last)
                .flat_map(|power| digits.iter().map(move |&digit| f64::from(digit) * 10_f64.powi(power)))
                .filter(inside)
                .collect()
        };
        let decades: Vec<f64> = (first..=last).map(|power| 10_f64.powi(power)).collect();
        let (positions, minor) = if decades.len() >= 3 || decades.len() as f64 > about {
            let every = (decades.len() as f64 / about.max(1.0)).ceil() as i32;
            let major = (first..=last).filter(|power| power.rem_euclid(every) == 0).map(|power| 10_f64.powi(power));
            let minor = if every == 1 { between(&[2, 3, 4, 5, 6, 7, 8, 9]) } else { decades };
            (major.collect(), minor)
        } else {
            // Fewer than three decades get labels within a decade: the sparsest choice with at least three labels.
            let all = || between(&[1, 2, 3, 4, 5, 6, 7, 8, 9]);
            let choices: [&[i32]; 4] = [&[1], &[1, 3], &[1, 2, 5], &[1, 2, 3, 5, 7]];
            let enough = choices.iter().map(|digits| between(digits)).find(|positions| positions.len() >= 3);
            (enough.unwrap_or_else(all), all())
        };
        let plain = positions.iter().all(|&value| (0.000_99..10_001.0).contains(&value)) && last - first < 4;
        let major: Vec<(f64, String)> = positions.into_iter().map(|v| (v, log_label(v, plain))).collect();
        if major.len() < 2 {
            // A range within one decimal digit gets linear labels on the logarithmic axis.
            let linear = Self::linear(range, about);
            return Self { scale: Scale::Log, ..linear };
        }
        let minor = minor.into_iter().filter(|m| major.iter().all(|(v, _)| (v / m - 1.0).abs() > 1e-6)).collect();
        Self { scale: Scale::Log, range, major, minor, factor: String::new() }
    }
}

fn log_label(value: f64, plain: bool) -> String {
    let power = (value.log10() + 1e-9).floor() as i32;
    if plain {
        let decimals = (-power).max(0) as usize;
        return minus(&format!("{value:.decimals$}"));
    }
    let digit = (value / 10_f64.powi(power)).round();
    let power = minus(&power.to_string());
    if digit == 1.0 { format!("10^{{{power}}}") } else { format!("{digit}×10^{{{power}}}") }
}

/// Formats a number with four significant digits, as markup without trailing zeros.
pub(super) fn short(value: f64) -> String {
    let trim = |digits: &str| {
        let is_fraction = digits.contains('.');
        minus(if is_fraction { digits.trim_end_matches('0').trim_end_matches('.') } else { digits })
    };
    let rounded = format!("{value:.3e}");
    let Some((digits, power)) = rounded.split_once('e') else { return rounded };
    match power.parse::<i32>() {
        Ok(power @ -3..=4) => {
            let decimals = usize::try_from(3 - power).unwrap_or(0);
            trim(&format!("{value:.decimals$}"))
        }
        _ => format!("{}×10^{{{}}}", trim(digits), minus(power)),
    }
}

/// Replaces the hyphen of a number by a minus sign, and drops the sign of zero.
pub(super) fn minus(number: &str) -> String {
    match number.strip_prefix('-') {
        Some(digits) if digits.chars().all(|c| "0.".contains(c)) => digits.to_owned(),
        Some(digits) => format!("−{digits}"),
        None => number.to_owned(),
    }
}

/// Returns the range of an axis that shows the values, with a margin at both ends, or `None` without values.
pub(super) fn padded(scale: Scale, values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return None;
    }
    Some(match scale {
        Scale::Linear => {
            let margin = if high > low { 0.06 * (high - low) } else { 0.1 * low.abs().max(1e-300) };
            let largest = low.abs().max(high.abs());
            let margin = if margin > 0.0 && margin > 1e-12 * largest { margin } else { (0.1 * largest).max(1.0) };
            [low - margin, high + margin]
        }
        Scale::Log => {
            let factor = if high > low { (high / low).powf(0.06).max(1.02) } else { 1.5 };
            [low / factor, high * factor]
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, range: [f64; 2]) -> Vec<String> {
        Ticks::new(scale, range, 5.0).unwrap().major.into_iter().map(|(_, label)| label).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        assert_eq!(labels(Scale::Linear, [-0.03, 0.53]), ["0.0", "0.2", "0.4"]);
        assert_eq!(labels(Scale::Linear, [1.55, 3.02]), ["2.0", "2.5", "3.0"]);
        assert_eq!(labels(Scale::Linear, [-11.0, 9.0]), ["−10", "−5", "0", "5"]);
        assert_eq!(labels(Scale::Linear, [0.0, 2e-5]), ["0", "5", "10", "15", "20"]);
        assert_eq!(Ticks::new(Scale::Linear, [0.0, 2e-5], 5.0).unwrap().factor, "×10^{−6}");
        assert_eq!(labels(Scale::Linear, [0.0, 9.9e-4]), ["0.0", "0.2", "0.4", "0.6", "0.8"]);
        assert_eq!(Ticks::new(Scale::Linear, [0.0, 9.9e-4], 5.0).unwrap().factor, "×10^{−3}");
        assert_eq!(Ticks::new(Scale::Linear, [0.0, 2e6], 5.0).unwrap().factor, "×10^{6}");
        assert_eq!(labels(Scale::Linear, [0.0, 1.0]), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
    }

    #[test]
    fn log_ticks_are_powers_or_digits() {
        assert_eq!(labels(Scale::Log, [1e-9, 2.0]), ["10^{−8}", "10^{−6}", "10^{−4}", "10^{−2}", "10^{0}"]);
        assert_eq!(labels(Scale::Log, [0.02, 0.6]), ["0.03", "0.1", "0.3"]);
        assert_eq!(labels(Scale::Log, [0.005, 2.0]), ["0.01", "0.1", "1"]);
        assert_eq!(labels(Scale::Log, [0.065, 0.36]), ["0.07", "0.1", "0.2", "0.3"]);
        assert_eq!(labels(Scale::Log, [2.1e-7, 4.4e-7]), ["3×10^{−7}", "4×10^{−7}"]);
        assert_eq!(labels(Scale::Log, [1.61, 1.68]), ["1.62", "1.64", "1.66", "1.68"]);
    }

    #[test]
    fn ticks_lie_inside_and_minor_ticks_between() {
        for scale in [Scale::Linear, Scale::Log] {
            for i in 0..200 {
                let low = 10_f64.powf((f64::from(i) * 0.618).fract() * 12.0 - 6.0);
                let high = low * (1.0 + 10_f64.powf((f64::from(i) * 0.414).fract() * 8.0 - 2.0));
                let ticks = Ticks::new(scale, [low, high], 5.0).unwrap();
                assert!(ticks.major.len() >= 2 && ticks.major.len() <= 10, "{low} {high} {:?}", ticks.major);
                for value in ticks.major.iter().map(|(v, _)| v).chain(&ticks.minor) {
                    assert!((-1e-6..1.0 + 1e-6).contains(&ticks.fraction(*value)), "{low} {high} {value}");
                }
                let mut labels: Vec<_> = ticks.major.iter().map(|(_, label)| label).collect();
                labels.dedup();
                assert_eq!(labels.len(), ticks.major.len(), "{labels:?}");
            }
        }
        assert!(Ticks::new(Scale::Log, [0.0, 1.0], 5.0).is_err());
        assert!(Ticks::new(Scale::Linear, [1.0, 1.0], 5.0).is_err());
        assert!(Ticks::new(Scale::Linear, [f64::NAN, 1.0], 5.0).is_err());
    }

    #[test]
    fn short_numbers_have_four_digits() {
        let expected = [(2.506_63, "2.507"), (-0.2, "−0.2"), (0.0, "0"), (12_345.6, "12346"), (1.5e-4, "1.5×10^{−4}")];
        for (value, text) in expected {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn ranges_have_room() {
        let range = padded(Scale::Linear, [1.0, 2.0].into_iter()).unwrap();
        assert!(range[0] < 1.0 && range[1] > 2.0);
        for (scale, value) in [(Scale::Linear, 0.0), (Scale::Linear, -3.0), (Scale::Log, 1e-20), (Scale::Linear, 1e300)]
        {
            let [low, high] = padded(scale, std::iter::once(value)).unwrap();
            assert!(low < value && value < high, "{low} {value} {high}");
        }
        assert_eq!(padded(Scale::Linear, std::iter::empty()), None);
    }
}
