//! The difference of two runs, at the times of the first.

use super::curve::Sample;
use crate::model::state::State;
use crate::output::hermite::interpolate;

/// [-] A time counts as within a run if it is this share of its length beyond its ends, which is rounding.
const ROUNDING: f64 = 1e-9;

/// The first quantity minus the second one, at the times of the first that both have. The second one is interpolated by
/// cubics. With its rates these leave an error of h^4 x''''/384. Where it has none, the rates are those of the parabola
/// through three values, whose error h^2 x'''/6 leaves one of 0.016 h^3 x'''.
pub(super) fn minus(first: Vec<Sample>, second: &[Sample]) -> Vec<Sample> {
    let (Some(start), Some(end)) = (second.first(), second.last()) else { return Vec::new() };
    let margin = ROUNDING * (end.t - start.t);
    let rates = rates(second);
    let state = |i: usize| {
        let (sample, rate) = (second.get(i)?, rates.get(i)?);
        Some(State { t: sample.t, x: vec![sample.value], v: vec![*rate] })
    };
    let mut out = State { t: 0.0, x: vec![0.0], v: vec![0.0] };
    let difference = |sample: Sample| {
        if sample.t < start.t - margin || sample.t > end.t + margin {
            return None;
        }
        let after = second.partition_point(|s| s.t < sample.t).min(second.len() - 1);
        let (from, to) = (state(after.saturating_sub(1))?, state(after)?);
        let share = if to.t > from.t { ((sample.t - from.t) / (to.t - from.t)).clamp(0.0, 1.0) } else { 0.0 };
        interpolate(from.as_ref(), to.as_ref(), share, &mut out);
        Some(Sample { value: sample.value - out.x[0], rate: sample.rate - out.v[0], ..sample })
    };
    first.into_iter().filter_map(difference).collect()
}

/// The rates of a quantity; those that are not known are of the parabola through a value and its neighbours.
fn rates(samples: &[Sample]) -> Vec<f64> {
    let slope = |i: usize| match (samples.get(i), samples.get(i + 1)) {
        (Some(a), Some(b)) => Some((b.t - a.t, (b.value - a.value) / (b.t - a.t))),
        _ => None,
    };
    let rate = |(i, sample): (usize, &Sample)| {
        let before = i.checked_sub(1).and_then(slope);
        match (before, slope(i)) {
            _ if !sample.rate.is_nan() => sample.rate,
            (Some((h, s)), Some((k, r))) => (k * s + h * r) / (h + k),
            (None, Some((h, s))) => slope(i + 1).map_or(s, |(k, r)| s + (s - r) * h / (h + k)),
            (Some((h, s)), None) => i.checked_sub(2).and_then(slope).map_or(s, |(k, r)| s + (s - r) * h / (h + k)),
            (None, None) => 0.0,
        }
    };
    samples.iter().enumerate().map(rate).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A parabola without rates, at uneven times, is interpolated exactly, at its ends too; times beyond are left out.
    #[test]
    fn parabolas_are_exact() {
        let f = |t: f64| 3.0 - 2.0 * t + 0.7 * t * t;
        let sample = |t: f64| Sample { t, value: f(t), rate: f64::NAN };
        let second: Vec<Sample> = [0.0, 0.1, 0.35, 0.5, 1.0].map(sample).to_vec();
        let first: Vec<Sample> = (0..30_u8).map(|i| Sample { value: 5.0, ..sample(f64::from(i) / 20.0) }).collect();
        let found = minus(first, &second);
        assert_eq!(found.len(), 21);
        for Sample { t, value, .. } in found {
            assert!((value - (5.0 - f(t))).abs() < 1e-14, "{value} at {t}");
        }
    }
}
