//! Where an axis starts and ends, and how its numbers are written.

use super::Scale;

/// A logarithmic axis reaches no further below its largest value than this factor.
const LOG_REACH: f64 = 1e12;

/// The span of an axis, the distance of its ticks (linear axes), and how they are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    pub low: f64,
    pub high: f64,
    pub step: f64,
    pub log: bool,
    pub style: TickStyle,
}

/// How the numbers beside an axis are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum TickStyle {
    /// With so many decimals.
    Decimals(usize),
    /// As "5×10⁴".
    Powers,
    /// As short as it goes: 0.05, 20, 1000.
    Short,
}

impl Axis {
    /// The x axis: the span of the data with a little room, ticks at round numbers within it.
    pub fn horizontal(values: impl Iterator<Item = f64>, scale: Scale, log: bool) -> Self {
        let (low, high) = span(values);
        if log {
            return Self::log(low, high, 1.0);
        }
        if scale == Scale::ScatteringAngle {
            return Self { low: 0.0, high: 180.0, step: 30.0, log: false, style: TickStyle::Decimals(0) };
        }
        let (low, high) = over(low, high, scale);
        let (low, high) = opened(low, high, 0.02);
        let step = round_step((high - low) / 6.0);
        Self { low, high, step, log: false, style: linear_style(low, high, step) }
    }

    /// The y axis: from a round number to a round number around the data.
    pub fn vertical(values: impl Iterator<Item = f64>, scale: Scale, log: bool) -> Self {
        let (low, high) = span(values);
        if log {
            return Self::log(low, high, 1.1);
        }
        let (asked_low, asked_high) = over(low, high, scale);
        let (low, high) = match scale {
            Scale::LinearOver(..) if asked_low < asked_high => (asked_low, asked_high),
            // Data that start at zero do not reach below it.
            _ if low >= 0.0 && high > low && low < 0.05 * (high - low) => (0.0, high + 0.05 * (high - low)),
            _ => opened(low, high, 0.05),
        };
        let step = round_step((high - low) / 5.0);
        let low = (low / step + 1e-6).floor() * step;
        let high = (high / step - 1e-6).ceil() * step;
        Self { low, high, step, log: false, style: linear_style(low, high, step) }
    }

    /// From a tick to a tick, with so much room beyond the data: kuva marks 1, 2 and 5 of every decade over up to three decades, else whole decades.
    fn log(low: f64, high: f64, room: f64) -> Self {
        // Keeps clear of what a double cannot hold, above and below.
        let high = high.clamp(1e-280, 1e280);
        let low = low.max(high / LOG_REACH);
        let room = if high / low < 2.0 { 1.5 } else { room };
        let (mut low, mut high) = (tick_below(low / room), tick_above(high * room));
        if high / low > 900.0 {
            low = 10f64.powf((low.log10() + 1e-9).floor());
            high = 10f64.powf((high.log10() - 1e-9).ceil());
        }
        let plain = low > 0.9e-3 && high < 1.1e4;
        Self { low, high, step: 1.0, log: true, style: if plain { TickStyle::Short } else { TickStyle::Powers } }
    }

    /// How far along the axis a value is: 0 at its start, 1 at its end.
    pub fn fraction(&self, value: f64) -> f64 {
        if self.log {
            return (value / self.low).ln() / (self.high / self.low).ln();
        }
        (value - self.low) / (self.high - self.low)
    }

    /// The value so far along the axis: the inverse of [`Axis::fraction`].
    pub fn value(&self, fraction: f64) -> f64 {
        if self.log {
            return self.low * (fraction * (self.high / self.low).ln()).exp();
        }
        self.low + fraction * (self.high - self.low)
    }
}

impl TickStyle {
    /// The text of a tick.
    pub fn format(self, value: f64) -> String {
        match self {
            Self::Decimals(decimals) => {
                let text = format!("{value:.decimals$}");
                // A rounded-off negative is zero.
                if text.starts_with('-') && !text.contains(|c: char| c.is_ascii_digit() && c != '0') {
                    return text[1..].replace('-', "");
                }
                text.replace('-', "\u{2212}")
            }
            Self::Powers => powers(value),
            Self::Short => crate::quantity::significant(value, 6),
        }
    }
}

/// "10⁴", "5×10⁻³".
fn powers(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let text = format!("{value:.2e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.').replace('-', "\u{2212}");
    let raised: String = exponent
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            '4' => '⁴',
            '5' => '⁵',
            '6' => '⁶',
            '7' => '⁷',
            '8' => '⁸',
            '9' => '⁹',
            _ => '⁰',
        })
        .collect();
    if mantissa == "1" { format!("10{raised}") } else { format!("{mantissa}×10{raised}") }
}

fn span(values: impl Iterator<Item = f64>) -> (f64, f64) {
    // Kept clear of the ends of what a double can hold, so that room can be added.
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        let v = v.clamp(-1e300, 1e300);
        (low.min(v), high.max(v))
    })
}

fn over(low: f64, high: f64, scale: Scale) -> (f64, f64) {
    match scale {
        Scale::LinearOver(at_least_low, at_least_high) => (low.min(at_least_low), high.max(at_least_high)),
        _ => (low, high),
    }
}

/// The span with room at both ends, and some width where it has none that shows.
fn opened(low: f64, high: f64, room: f64) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    let width = high - low;
    if width > 1e-6 * size && width > 1e-290 {
        return (low - room * width, high + room * width);
    }
    let half = if size > 1e-280 { 0.02 * size } else { 1.0 };
    (low - half, high + half)
}

/// 1, 2 or 5 times a power of ten, near `rough`.
fn round_step(rough: f64) -> f64 {
    let power = 10f64.powf(rough.log10().floor());
    let factor = [1.0, 2.0, 5.0, 10.0].into_iter().find(|f| f * power >= 0.999 * rough).unwrap_or(10.0);
    factor * power
}

fn linear_style(low: f64, high: f64, step: f64) -> TickStyle {
    let size = low.abs().max(high.abs());
    if !(1e-3..1e6).contains(&size) {
        return TickStyle::Powers;
    }
    TickStyle::Decimals((-step.log10() - 1e-9).ceil().clamp(0.0, 9.0) as usize)
}

/// The largest of 1, 2, 5 times a power of ten that is not above `value`.
fn tick_below(value: f64) -> f64 {
    let power = 10f64.powf((value.log10() + 1e-9).floor());
    [5.0, 2.0].into_iter().map(|f| f * power).find(|t| *t <= value * (1.0 + 1e-9)).unwrap_or(power)
}

/// The smallest of 1, 2, 5 times a power of ten that is not below `value`.
fn tick_above(value: f64) -> f64 {
    let power = 10f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0].into_iter().map(|f| f * power).find(|t| *t >= value * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_at_round_numbers() {
        let axis = Axis::vertical([0.62, 0.97].into_iter(), Scale::LinearOver(0.0, 1.0), false);
        assert_eq!((axis.low, axis.high, axis.step), (0.0, 1.0, 0.2));
        assert_eq!(axis.style.format(0.2), "0.2");
        let axis = Axis::vertical([1.33, 1.343].into_iter(), Scale::Linear, false);
        assert!(axis.low > 1.32 && axis.high < 1.35 && axis.style == TickStyle::Decimals(3), "{axis:?}");
        let axis = Axis::vertical([51e3, 54e3].into_iter(), Scale::Log, true);
        assert!((axis.low / 2e4 - 1.0).abs() < 1e-9 && (axis.high / 1e5 - 1.0).abs() < 1e-9, "{axis:?}");
        let axis = Axis::vertical([1e-30, 7.0].into_iter(), Scale::Log, true);
        assert!(axis.low > 1e-13 && axis.high > 7.0, "{axis:?}");
    }

    #[test]
    fn one_value_gets_room_around_it() {
        for value in [0.0, 550.0, -3.0, 1e-300, 1e300] {
            for axis in [
                Axis::horizontal([value].into_iter(), Scale::Linear, false),
                Axis::vertical([value].into_iter(), Scale::Linear, false),
            ] {
                assert!(axis.low <= value && axis.high >= value && axis.high > axis.low, "{value}: {axis:?}");
                assert!(axis.step > 0.0 && axis.step.is_finite(), "{value}: {axis:?}");
            }
        }
    }

    #[test]
    fn ticks_read_well() {
        assert_eq!(TickStyle::Powers.format(1e4), "10⁴");
        assert_eq!(TickStyle::Powers.format(5e-13), "5×10⁻¹³");
        assert_eq!(TickStyle::Short.format(0.05), "0.05");
        assert_eq!(TickStyle::Short.format(1000.0), "1000");
        assert_eq!(TickStyle::Decimals(1).format(-0.01), "0.0");
        assert_eq!(TickStyle::Decimals(1).format(-0.5), "\u{2212}0.5");
    }
}
