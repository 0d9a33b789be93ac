//! The scale of an axis: the position of a number on it, and the numbers at its ticks.

use super::chart::Scale;

/// Share of the points' range left free at both ends of an axis that is fitted to them.
const MARGIN: f64 = 0.04;
/// [-] A range narrower than this share of its numbers is rounding, not motion; it is drawn as a constant.
const ROUNDING: f64 = 1e-12;
/// Letters of the longest label beside an axis; numbers that need more are counted from one of them.
const LONGEST: usize = 9;
/// Larger numbers count as not finite: a diverging run exceeds them within a step or two, and differences of smaller
/// numbers are finite.
const FARTHEST: f64 = 1e150;

/// An axis from 0 at its lower end to 1 at its upper end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AxisScale {
    scale: Scale,
    /// lower end, its logarithm on a logarithmic axis
    low: f64,
    /// upper end, likewise
    high: f64,
}

/// The ticks of an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ticks {
    /// the ticks
    pub ticks: Vec<Tick>,
    /// what is to be added to the numbers at the ticks; 0 but where they differ in their last digits only
    pub origin: f64,
}

/// A tick of an axis.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// between 0 and 1
    pub at: f64,
    /// label; empty for a line of the fine grid
    pub label: String,
}

/// A number as a length along an axis, or `None` if it cannot be shown there.
fn length(scale: Scale, value: f64) -> Option<f64> {
    let inside = value.abs() < FARTHEST;
    match scale {
        Scale::Linear => inside.then_some(value),
        Scale::Log => (inside && value > 0.0).then(|| value.log10()),
    }
}

impl AxisScale {
    /// An axis between two numbers; `None` if they are not a range.
    pub(super) fn between(scale: Scale, low: f64, high: f64) -> Option<Self> {
        let (low, high) = (length(scale, low)?, length(scale, high)?);
        (high - low > ROUNDING * low.abs().max(high.abs())).then_some(Self { scale, low, high })
    }

    /// An axis for some numbers, with a margin; `None` if none of them can be shown.
    pub(super) fn around(scale: Scale, values: impl Iterator<Item = f64>) -> Option<Self> {
        let ends = |ends: Option<(f64, f64)>, v: f64| Some(ends.map_or((v, v), |(l, h)| (l.min(v), h.max(v))));
        let (low, high) = values.filter_map(|v| length(scale, v)).fold(None, ends)?;
        let size = low.abs().max(high.abs());
        let margin = match high - low {
            span if span > ROUNDING * size => MARGIN * span,
            _ if size > 0.0 && scale == Scale::Linear => 0.1 * size,
            _ => 0.5,
        };
        Some(Self { scale, low: low - margin, high: high + margin })
    }

    /// Length of the axis in its own unit.
    pub(super) fn span(&self) -> f64 {
        self.high - self.low
    }

    /// An axis with the same middle and another length.
    pub(super) fn widened(&self, span: f64) -> Self {
        let middle = f64::midpoint(self.low, self.high);
        Self { low: middle - 0.5 * span, high: middle + 0.5 * span, ..*self }
    }

    /// The position of a number: below 0 and above 1 it is off the axis. `None` for a number that cannot be shown.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        Some((length(self.scale, value)? - self.low) / self.span()).filter(|p| p.is_finite())
    }

    /// At most about `most` labelled ticks, and the lines of the fine grid between them.
    pub(super) fn ticks(&self, most: usize) -> Ticks {
        match self.scale {
            Scale::Linear => self.even_ticks(self.low, self.high, most),
            // Less than a decade has too few powers of ten for readable labels.
            Scale::Log if self.span() < 1.0 => self.even_ticks(10f64.powf(self.low), 10f64.powf(self.high), most),
            Scale::Log => Ticks { ticks: self.decade_ticks(most), origin: 0.0 },
        }
    }

    /// Multiples of 1, 2 or 5 times a power of ten.
    fn even_ticks(&self, low: f64, high: f64, most: usize) -> Ticks {
        let rough = (high - low) / most.max(2) as f64;
        let power = 10f64.powf(rough.log10().floor());
        let steps = [0.5, 1.0, 2.0, 5.0, 10.0].map(|m| m * power);
        let ends = |step: f64| ((low / step - 1e-9).ceil(), (high / step + 1e-9).floor());
        let fits = (1..steps.len()).find(|i| steps[*i] >= rough).unwrap_or(steps.len() - 1);
        // Two numbers tell little of an axis that has room for more.
        let (first, last) = ends(steps[fits]);
        let step = steps[if most > 3 && last - first < 2.0 { fits - 1 } else { fits }];
        let (first, last) = ends(step);
        let count = (last - first).clamp(0.0, 100.0) as usize;
        let counted_from = |origin: f64| {
            let size = (low - origin).abs().max((high - origin).abs());
            // Whole steps from the origin, so that no digits are lost.
            let begin = first - (origin / step).round();
            let tick = |i: usize| {
                let label = number((begin + i as f64) * step, Digits { step, size });
                Some(Tick { at: self.place((first + i as f64) * step)?, label })
            };
            Ticks { ticks: (0..=count).filter_map(tick).collect(), origin }
        };
        let ticks = counted_from(0.0);
        let too_long = |tick: &Tick| tick.label.chars().count() > LONGEST;
        if ticks.ticks.iter().any(too_long) { counted_from(shortest(low, high, step)) } else { ticks }
    }

    /// Powers of ten; 2 … 9 times them as a fine grid while there is room, 2 and 5 with numbers on short axes.
    fn decade_ticks(&self, most: usize) -> Vec<Tick> {
        let stride = (self.span() / most.max(1) as f64).ceil().max(1.0) as i32;
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let mut ticks = Vec::new();
        for power in first..=last {
            for multiple in 1..=9_u8 {
                let whole = multiple == 1 && power.rem_euclid(stride) == 0;
                let written = whole || (matches!(multiple, 2 | 5) && self.span() < 2.0);
                let at = (f64::from(power) + f64::from(multiple).log10() - self.low) / self.span();
                if (-1e-9..=1.0 + 1e-9).contains(&at) && (written || stride == 1) {
                    let label = match (written, multiple) {
                        (false, _) => String::new(),
                        (true, 1) => format!("10{}", superscript(power)),
                        (true, _) => format!("{multiple}·10{}", superscript(power)),
                    };
                    ticks.push(Tick { at, label });
                }
            }
        }
        ticks
    }
}

/// The number between two others that has the fewest digits, and is a multiple of a step.
fn shortest(low: f64, high: f64, step: f64) -> f64 {
    let tenfold = std::iter::successors(Some(step), |unit| Some(unit * 10.0)).take(20);
    let inside = tenfold.map(|unit| (low / unit).ceil() * unit).take_while(|multiple| *multiple <= high);
    // Twelve digits: the products above are not exact.
    inside.last().and_then(|multiple| format!("{multiple:.11e}").parse().ok()).unwrap_or(0.0)
}

/// The data for the number of digits of a tick label.
#[derive(Clone, Copy, Debug)]
struct Digits {
    /// distance of two ticks
    step: f64,
    /// size of the largest number
    size: f64,
}

/// A number with as many digits as needed to distinguish neighbours; very large and small ones with a power of ten.
fn number(value: f64, Digits { step, size }: Digits) -> String {
    let power = |v: f64| (v.log10() + 1e-9).floor() as i32;
    if (1e-3..1e5).contains(&size) {
        let decimals = usize::try_from(-power(step)).unwrap_or(0);
        return without_minus_zero(format!("{value:.decimals$}"));
    }
    let power_of_size = power(size);
    let digits = usize::try_from(power_of_size - power(step)).unwrap_or(0);
    let mantissa = without_minus_zero(format!("{:.digits$}", value / 10f64.powi(power_of_size)));
    if value == 0.0 { "0".to_owned() } else { format!("{mantissa}·10{}", superscript(power_of_size)) }
}

fn without_minus_zero(text: String) -> String {
    let zero = text.strip_prefix('-').filter(|rest| rest.chars().all(|c| matches!(c, '0' | '.')));
    zero.map(str::to_owned).unwrap_or(text)
}

fn superscript(power: i32) -> String {
    let raised = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let raise = |c: char| c.to_digit(10).and_then(|d| raised.get(d as usize).copied()).unwrap_or('⁻');
    power.to_string().chars().map(raise).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: AxisScale, most: usize) -> Vec<String> {
        scale.ticks(most).ticks.into_iter().map(|t| t.label).filter(|l| !l.is_empty()).collect()
    }

    /// Round numbers with as many digits as they need, in everyday and in tiny units, and powers of ten on logarithmic
    /// axes.
    #[test]
    fn numbers_on_axes() {
        let linear = |low, high| AxisScale::between(Scale::Linear, low, high).expect("a range");
        let log = |low, high| AxisScale::between(Scale::Log, low, high).expect("a range");
        assert_eq!(labels(linear(-2.1, 2.1), 5), ["-2", "-1", "0", "1", "2"]);
        assert_eq!(labels(linear(0.0, 0.31), 4), ["0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(labels(linear(0.0, 3.5e-11), 4), ["0", "1·10⁻¹¹", "2·10⁻¹¹", "3·10⁻¹¹"]);
        assert_eq!(labels(linear(1e6, 1e6 + 2.0), 2), ["0", "1", "2"]);
        assert_eq!(linear(1e6, 1e6 + 2.0).ticks(2).origin, 1e6);
        assert_eq!(labels(linear(6.0 - 5e-10, 6.0 + 3e-11), 4), ["-4·10⁻¹⁰", "-2·10⁻¹⁰", "0"]);
        assert_eq!(linear(6.0 - 5e-10, 6.0 + 3e-11).ticks(4).origin, 6.0);
        assert_eq!(labels(linear(-8e4, 3e3), 4), ["-80000", "-60000", "-40000", "-20000", "0"]);
        assert_eq!(labels(log(1e-4, 1e-1), 8), ["10⁻⁴", "10⁻³", "10⁻²", "10⁻¹"]);
        assert_eq!(labels(log(0.9, 11.0), 8), ["10⁰", "2·10⁰", "5·10⁰", "10¹"]);
        assert_eq!(labels(log(1e-12, 1.0), 4), ["10⁻¹²", "10⁻⁹", "10⁻⁶", "10⁻³", "10⁰"]);
        assert_eq!(labels(log(2.0, 4.0), 4), ["2.0", "2.5", "3.0", "3.5", "4.0"]);
    }

    /// Numbers that cannot be shown on an axis, and invalid ranges, give `None`.
    #[test]
    fn places_and_ranges() {
        let log = AxisScale::between(Scale::Log, 1.0, 100.0).expect("a range");
        assert_eq!([log.place(10.0), log.place(0.0), log.place(f64::NAN)], [Some(0.5), None, None]);
        assert_eq!(AxisScale::between(Scale::Log, 0.0, 1.0), None);
        assert_eq!(AxisScale::between(Scale::Linear, 1.0, 1.0), None);
        assert_eq!(AxisScale::around(Scale::Linear, [f64::INFINITY, f64::NAN].into_iter()), None);
        let flat = AxisScale::around(Scale::Linear, [3.0, 3.0].into_iter()).expect("a value");
        assert!((flat.place(3.0).expect("a place") - 0.5).abs() < 1e-12);
    }
}
