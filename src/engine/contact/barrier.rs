//! The potential that keeps what may touch apart: the logarithmic barrier of a gap (Li et al. 2020, equation 6).
//!
//! ```text
//! s = g/g0,     V = kappa g0^2 b(s),     b = -(1 - s)^2 ln s     for 0 < s < 1,     V = 0 from s = 1 on
//! force  -V' = -kappa g0 b'(s)            b'  = 2 (1 - s) ln s - (1 - s)^2/s
//! slope   V'' = kappa b''(s)              b'' = -2 ln s + 4 (1 - s)/s + (1 - s)^2/s^2
//! ```
//! It has two continuous derivatives, and no load closes the gap. Explicit steps need a bound on its slope: below
//! s = 0.4, where b'' is 10.08, the force goes on linearly. A gap can then close; at g = 0 the force is 6.05 kappa g0.

/// [-] s below which the limited potential goes on with a constant slope.
const LIMIT: f64 = 0.4;

/// [-] Largest b'' of the limited potential: its slope over kappa.
pub const MOST_SLOPE: f64 = 10.082_581_463_748_308;

/// The potential of one pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// [N/m] kappa
    pub stiffness: f64,
    /// [m] g0, the gap from which on nothing acts
    pub gap: f64,
    /// whether the slope is limited
    pub limited: bool,
}

/// What a potential gives at a gap.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Push {
    /// [J] V
    pub energy: f64,
    /// [N] -V', which opens the gap
    pub force: f64,
    /// [N/m] V''
    pub slope: f64,
}

/// b and its two derivatives at s.
fn barrier(s: f64) -> [f64; 3] {
    let (log, left) = (s.ln(), 1.0 - s);
    let ratio = left / s;
    [-left * left * log, 2.0 * left * log - left * ratio, -2.0 * log + 4.0 * ratio + ratio * ratio]
}

impl Barrier {
    /// What acts at the gap `g` [m]; `None` where it is wide enough. A closed gap has infinite energy and force if the
    /// potential is not limited.
    pub fn at(&self, g: f64) -> Option<Push> {
        let &Barrier { stiffness, gap, limited } = self;
        let s = g / gap;
        if s >= 1.0 {
            return None;
        }
        if s <= 0.0 && !limited {
            return Some(Push { energy: f64::INFINITY, force: f64::INFINITY, slope: f64::INFINITY });
        }
        let at = if limited { s.max(LIMIT) } else { s };
        let ([b, slope, curvature], beyond) = (barrier(at), at - s);
        Some(Push {
            energy: stiffness * gap * gap * (b - slope * beyond + 0.5 * curvature * beyond * beyond),
            force: stiffness * gap * (curvature * beyond - slope),
            slope: stiffness * curvature,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Force and slope are the derivatives of the energy; two of them are continuous at both ends of the barrier.
    #[test]
    fn derivatives_belong_to_the_energy() {
        for limited in [false, true] {
            let barrier = Barrier { stiffness: 70.0, gap: 0.02, limited };
            let at = |s: f64| barrier.at(s * 0.02).unwrap_or_default();
            let first = if limited { -0.3 } else { 1e-3 };
            for i in 0..200 {
                let s = first + (1.0 - first) * f64::from(i) / 200.0;
                let step = 1e-5 * s.abs().clamp(1e-3, 1.0);
                let [below, above] = [at(s - step), at(s + step)];
                let (way, here) = (2.0 * step * 0.02, at(s));
                let [force, slope] = [(below.energy - above.energy) / way, (below.force - above.force) / way];
                // The third derivative jumps where the slope is limited.
                let kink = (s - LIMIT).abs() < 1e-4;
                assert!((force - here.force).abs() < 1e-6 * (here.force + 1.4), "{limited} {s}: {force}");
                assert!(kink || (slope - here.slope).abs() < 1e-5 * (here.slope + 70.0), "{limited} {s}: {slope}");
            }
            let end = at(1.0 - 1e-7);
            assert!(end.energy < 1e-18 && end.force < 1e-9 && end.slope < 1e-3, "{end:?}");
        }
    }

    /// No load closes the gap; limited, it closes at 6.05 kappa g0, and the slope stays below its bound.
    #[test]
    fn closed_gaps() {
        let free = Barrier { stiffness: 1.0, gap: 1.0, limited: false };
        let limited = Barrier { limited: true, ..free };
        assert_eq!(free.at(0.0).map(|push| push.force), Some(f64::INFINITY));
        assert!(free.at(1e-9).is_some_and(|push| push.force > 9e8));
        let closed = limited.at(0.0).unwrap_or_default();
        assert!((closed.force - 6.0326).abs() < 1e-3, "{}", closed.force);
        assert!((closed.slope - MOST_SLOPE).abs() < 1e-12, "{}", closed.slope);
        assert_eq!(free.at(1.0), None);
    }
}
