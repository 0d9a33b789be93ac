//! Taylor's shape of an inflated canopy: inextensible radials under uniform pressure, without stress across them
//! (G. I. Taylor, "On the shapes of parachutes", 1919, in his Scientific Papers, vol. III).
//!
//! ```text
//! x = r/R,  a = s/R:     sin(phi) = x^2,   dx/da = cos(phi),   d(depth)/da = R x^2,   so  x'' = -2 x^3
//! lines of length L at the skirt:   cos(phi) = -r/L              a reefed skirt:   r = given
//! ```
//! x(a) is the lemniscate sine. It holds for the vertices of n flat gores too.

/// [-] steps of the integration up to the skirt; the method is of fourth order, so the error is of the order of
/// rounding
const STEPS: usize = 4000;
/// [-] arc length from the apex to the largest radius, over R: half the lemniscate constant
const QUARTER: f64 = 1.311_028_777_146_06;

/// A meridian of length `length` from the apex to the skirt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meridian {
    /// [m] largest radius R of the curve
    pub radius: f64,
    /// [m] arc length from the apex to the skirt
    length: f64,
}

/// What holds the skirt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum SkirtHold {
    /// [m] straight lines of this length that meet on the axis
    Lines(f64),
    /// [m] a ring that holds the skirt's nodes at this distance from the axis
    Ring(f64),
}

impl Meridian {
    /// The meridian of an arc length [m]; `None` where no such shape exists, as with lines that are too short.
    pub(super) fn of(length: f64, hold: SkirtHold) -> Option<Self> {
        // Positive while the skirt is too wide, that is, the arc over R is too small.
        let excess = |arc: f64| {
            let [x, slope, _] = lemniscate(arc);
            match hold {
                SkirtHold::Lines(lines) => slope + x * length / (arc * lines),
                SkirtHold::Ring(radius) => x * length / arc - radius,
            }
        };
        let (mut low, mut high) = match hold {
            SkirtHold::Lines(_) => (QUARTER, 2.0 * QUARTER),
            SkirtHold::Ring(_) => (1e-6, 2.0 * QUARTER),
        };
        if !(excess(low) > 0.0 && excess(high) < 0.0) {
            return None;
        }
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            if excess(middle) > 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        Some(Self { radius: length / low, length })
    }

    /// [m] Distance from the axis and height above the skirt at an arc length [m] from the apex.
    pub(super) fn at(&self, s: f64) -> [f64; 2] {
        let depth = |s: f64| lemniscate(s / self.radius);
        let [x, _, z] = depth(s);
        [self.radius * x, self.radius * (depth(self.length)[2] - z)]
    }
}

/// x, dx/da and the integral of x^2 at `a`, from 0, 1 and 0 (Runge-Kutta of fourth order).
fn lemniscate(a: f64) -> [f64; 3] {
    let h = a / STEPS as f64;
    let rate = |[x, v, _]: [f64; 3]| [v, -2.0 * x * x * x, x * x];
    let moved = |y: [f64; 3], k: [f64; 3], h: f64| -> [f64; 3] { std::array::from_fn(|i| y[i] + h * k[i]) };
    let mut y = [0.0, 1.0, 0.0];
    for _ in 0..STEPS {
        let k1 = rate(y);
        let k2 = rate(moved(y, k1, 0.5 * h));
        let k3 = rate(moved(y, k2, 0.5 * h));
        let k4 = rate(moved(y, k3, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The ratios of canopies with lines of 0.8 to 2.0 nominal diameters, from the closed form with elliptic integrals.
    #[test]
    fn ratios_are_those_of_the_closed_form() {
        let table = [
            (0.8, 0.659242, 0.631880, 0.399632),
            (0.9, 0.668202, 0.645591, 0.390212),
            (1.0, 0.675720, 0.656719, 0.382394),
            (1.2, 0.687634, 0.673670, 0.370184),
            (1.5, 0.700401, 0.690923, 0.357372),
            (2.0, 0.714136, 0.708468, 0.343931),
        ];
        for (lines, largest, skirt, depth) in table {
            let meridian = Meridian::of(0.5, SkirtHold::Lines(lines)).expect("a shape");
            let [r, z] = meridian.at(0.0);
            assert!((2.0 * meridian.radius - largest).abs() < 1e-6, "{lines}");
            assert!((2.0 * meridian.at(0.5)[0] - skirt).abs() < 1e-6, "{lines}");
            assert!((z / (2.0 * meridian.radius) - depth).abs() < 1e-6 && r == 0.0, "{lines}");
        }
    }

    /// The ring sets the skirt's radius; at the radius that lines give, the shape is that of the lines.
    #[test]
    fn a_ring_holds_the_skirt() {
        let free = Meridian::of(1.0, SkirtHold::Lines(2.0)).expect("a shape");
        let ring = |radius| Meridian::of(1.0, SkirtHold::Ring(radius)).expect("a shape");
        assert!((ring(0.2).at(1.0)[0] - 0.2).abs() < 1e-12);
        assert!((ring(free.at(1.0)[0]).radius - free.radius).abs() < 1e-9);
    }
}
