//! Central differences of order four, which tell whether a law switches within them.
//!
//! ```text
//! f'(p)  = (f(p - 2h) - 8 f(p - h) + 8 f(p + h) - f(p + 2h))/(12 h) + O(h^4)
//! f'(p-) = (3 f(p) - 4 f(p - h) + f(p - 2h))/(2 h) + O(h^2),     f'(p+) = (4 f(p + h) - 3 f(p) - f(p + 2h))/(2 h) + O(h^2)
//! ```

/// [-] The places of the values, in steps from the middle.
pub const PLACES: [f64; 4] = [-2.0, -1.0, 1.0, 2.0];
/// [-] Step as a share of the value: h^4 is then as small as rounding over h.
pub const RELATIVE: f64 = 1e-3;
/// [-] Share of a difference by which those of one and of two steps disagree at most where f is smooth; that is h^2.
const SMOOTH: f64 = 1e-4;
/// [-] Share of a value that counts as no difference: over a step it is 1e-6 of the value over the parameter.
const NOTHING: f64 = 1e-9;

/// A derivative, and what the differences say of it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Slope {
    /// df/dp
    pub value: f64,
    /// whether f is not smooth within the differences
    pub switches: bool,
    /// the derivative below and above, where it is not smooth in the middle; else twice the derivative
    pub sides: [f64; 2],
}

impl Slope {
    /// A derivative that is the same on both sides.
    pub fn smooth(value: f64) -> Self {
        Slope { value, switches: false, sides: [value; 2] }
    }
}

/// [1] df/dp from four values and a step.
pub fn derivative([a, b, c, d]: [f64; 4], h: f64) -> f64 {
    ((a - d) + 8.0 * (c - b)) / (12.0 * h)
}

/// The derivative of a number from its values at the [places](PLACES) and in their middle.
pub fn slope(values: [f64; 4], middle: f64, h: f64) -> Slope {
    let mut size = Sizes::default();
    size.add(values, middle);
    let value = derivative(values, h);
    if !size.switches() {
        return Slope::smooth(value);
    }
    let [a, b, c, d] = values;
    let below = (3.0 * middle - 4.0 * b + a) / (2.0 * h);
    let above = (4.0 * c - 3.0 * middle - d) / (2.0 * h);
    Slope { value, switches: true, sides: [below, above] }
}

/// Sums of squares of differences, over the numbers of a vector. Where f is smooth, f(p + h) - f(p - h) is half of
/// that of two steps, and f(p + h) - 2 f(p) + f(p - h) a quarter.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sizes {
    slope: f64,
    curvature: f64,
    disagreement: f64,
    values: f64,
}

impl Sizes {
    /// Adds a number by its values at the [places](PLACES) and in their middle.
    pub fn add(&mut self, [a, b, c, d]: [f64; 4], middle: f64) {
        let slopes = [0.5 * (c - b), 0.25 * (d - a)];
        let curvatures = [0.5 * (b + c) - middle, 0.125 * (a + d) - 0.25 * middle];
        self.slope += slopes[0].powi(2);
        self.curvature += curvatures[0].powi(2);
        self.disagreement += (slopes[0] - slopes[1]).powi(2) + (curvatures[0] - curvatures[1]).powi(2);
        self.values += middle * middle;
    }

    /// Whether the vector is not smooth within the differences.
    pub fn switches(&self) -> bool {
        let Sizes { slope, curvature, disagreement, values } = *self;
        disagreement.sqrt() > SMOOTH * (slope + curvature).sqrt() + NOTHING * values.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(f: impl Fn(f64) -> f64, p: f64, h: f64) -> Slope {
        slope(PLACES.map(|place| f(p + place * h)), f(p), h)
    }

    /// Polynomials of degree four have no error but rounding; smooth functions one of h^4/30 f'''''.
    #[test]
    fn smooth_functions_have_their_derivatives() {
        let quartic = of(|p| 3.0 * p.powi(4) - p, 0.7, 1e-2);
        assert!((quartic.value - (12.0 * 0.7_f64.powi(3) - 1.0)).abs() < 1e-12, "{quartic:?}");
        let exp = of(f64::exp, 1.0, 1e-2);
        assert!((exp.value / 1.0_f64.exp() - 1.0 + 1e-8 / 30.0).abs() < 1e-12 && !exp.switches, "{exp:?}");
        assert_eq!(of(|_| 2.0, 1.0, 1e-3), Slope::smooth(0.0));
    }

    /// At a kink the derivative of each side is known.
    #[test]
    fn a_kink_has_two_derivatives() {
        let found = of(|p| (p - 1.0).max(0.0) * 3.0 + p * p, 1.0, 1e-3);
        let [below, above] = found.sides;
        assert!((below - 2.0).abs() < 1e-9 && (above - 5.0).abs() < 1e-9, "{found:?}");
        assert!((found.value - 3.5).abs() < 1e-9 && found.switches);
    }

    /// A kink is seen in the middle, beside it, and not beyond the differences.
    #[test]
    fn kinks_are_seen() {
        for (place, seen) in [(0.0, true), (0.5e-3, true), (1.5e-3, true), (-1.9e-3, true), (2.1e-3, false)] {
            let found = of(|p| (p - 1.0 - place).max(0.0) + p, 1.0, 1e-3);
            assert_eq!(found.switches, seen, "{place}: {found:?}");
        }
    }
}
