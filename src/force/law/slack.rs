//! The three slack kinds and the plain spring as tension laws T(e), e = l - l0 (thesis Eq. 3, both readings).

use crate::model::quad::Real;
use crate::model::spec::Slack;

/// A spring's elastic tension at one elongation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tension<R = f64> {
    /// [N] tension T
    pub force: R,
    /// [N/m] dT/dl; at the threshold, the slope of the taut branch
    pub slope: R,
    /// [J] stored energy, zero at rest
    pub energy: R,
}

/// A tension law, for one spring or several side by side. Monomorphised into the kernels, so that a plain spring needs
/// no branch.
pub trait TensionLaw: Copy + Send + Sync {
    /// Where the law clamps: T = k (max(e, threshold) - offset); `None` = nowhere.
    fn clamp(&self) -> Option<Clamped>;

    /// Tension, slope and energy at elongation `e` [m] with stiffness `k` [N/m].
    fn at<R: Real>(&self, k: R, e: R) -> Tension<R>;
}

/// T = k e.
#[derive(Clone, Copy, Debug)]
pub struct LinearLaw;

impl TensionLaw for LinearLaw {
    #[inline(always)]
    fn clamp(&self) -> Option<Clamped> {
        None
    }

    #[inline(always)]
    fn at<R: Real>(&self, k: R, e: R) -> Tension<R> {
        let force = k * e;
        Tension { force, slope: k, energy: k.all(0.5) * force * e }
    }
}

/// T = k (max(e, threshold) - offset): tension-only (0, 0), dead zone (eps, eps), compression limit (-eps, 0).
#[derive(Clone, Copy, Debug)]
pub struct Clamped {
    /// [m] elongation below which the tension is constant
    pub threshold: f64,
    /// [m] elongation of zero tension on the taut branch
    pub offset: f64,
}

impl TensionLaw for Clamped {
    #[inline(always)]
    fn clamp(&self) -> Option<Clamped> {
        Some(*self)
    }

    #[inline(always)]
    fn at<R: Real>(&self, k: R, e: R) -> Tension<R> {
        let threshold = k.all(self.threshold);
        let c = e.larger(threshold);
        let taut = c - k.all(self.offset);
        let force = k * taut;
        let slope = k.where_not_negative(e - threshold);
        // Below the threshold the force is constant, so its work is linear in the elongation.
        Tension { force, slope, energy: k.all(0.5) * force * taut + force * (e - c) }
    }
}

/// The clamped law of a slack kind, `None` for the plain spring.
pub fn clamped(slack: Slack) -> Option<Clamped> {
    match slack {
        Slack::None => None,
        Slack::TensionOnly => Some(Clamped { threshold: 0.0, offset: 0.0 }),
        Slack::DeadZone { eps } => Some(Clamped { threshold: eps, offset: eps }),
        // Not -eps: for eps = 0 it would be -0, which would change bits in the kernel for four springs.
        Slack::CompressionLimit { eps } => Some(Clamped { threshold: 0.0 - eps, offset: 0.0 }),
    }
}

/// Evaluates an expression with the law of a slack kind: the one place that knows which law a kind has.
macro_rules! with_law {
    ($slack:expr, $law:ident => $then:expr) => {
        match $crate::force::law::slack::clamped($slack) {
            None => {
                let $law = $crate::force::law::slack::LinearLaw;
                $then
            }
            Some($law) => $then,
        }
    };
}
pub(in crate::force) use with_law;

/// The law of any slack kind, when speed does not matter.
pub fn tension(slack: Slack, k: f64, e: f64) -> Tension {
    with_law!(slack, law => law.at(k, e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::quad::{Pass, Quad, VectorUnit, run};

    const K: f64 = 7.0;
    const EPS: f64 = 0.2;

    fn kinds() -> [Slack; 4] {
        [Slack::None, Slack::TensionOnly, Slack::DeadZone { eps: EPS }, Slack::CompressionLimit { eps: EPS }]
    }

    #[test]
    fn tension_follows_the_written_laws() {
        for i in -40..=40 {
            let e = 0.025 * f64::from(i);
            let expected = [K * e, K * e.max(0.0), K * (e - EPS).max(0.0), K * e.max(-EPS)]
                .map(|t| if t == 0.0 { 0.0 } else { t });
            for (slack, t) in kinds().into_iter().zip(expected) {
                assert!((tension(slack, K, e).force - t).abs() < 1e-14, "{slack:?} at e = {e}");
            }
        }
    }

    #[test]
    fn energy_is_the_integral_of_tension_and_zero_at_rest() {
        for slack in kinds() {
            assert_eq!(tension(slack, K, 0.0).energy, 0.0, "{slack:?} at rest");
            for i in -40..40 {
                // Midpoint rule is exact where the law is linear; the kinks lie on the grid.
                let (e0, e1) = (0.025 * f64::from(i), 0.025 * f64::from(i + 1));
                let work = tension(slack, K, 0.5 * (e0 + e1)).force * (e1 - e0);
                let gain = tension(slack, K, e1).energy - tension(slack, K, e0).energy;
                assert!((gain - work).abs() < 1e-14, "{slack:?} between {e0} and {e1}: {gain} against {work}");
            }
        }
    }

    #[test]
    fn the_threshold_itself_is_taut() {
        assert_eq!(tension(Slack::TensionOnly, K, 0.0).slope, K);
        assert_eq!(tension(Slack::DeadZone { eps: EPS }, K, EPS).slope, K);
        assert_eq!(tension(Slack::CompressionLimit { eps: EPS }, K, -EPS).slope, K);
        assert_eq!(tension(Slack::TensionOnly, K, -1e-9).slope, 0.0);
    }

    struct FourElongations<L>(L, [f64; 4]);

    impl<L: TensionLaw> Pass for FourElongations<L> {
        type Output = ([f64; 4], [f64; 4]);

        #[inline(always)]
        fn run<U: VectorUnit>(self, unit: U) -> Self::Output {
            let tension = self.0.at(unit.splat(K), unit.quad(self.1));
            (tension.force.numbers(), tension.energy.numbers())
        }
    }

    #[test]
    fn four_springs_side_by_side_have_the_bits_of_one() {
        for i in -40..=40 {
            let e = [0.0, 0.003, 0.01, 0.02].map(|d| 0.025 * f64::from(i) + d);
            for slack in kinds().into_iter().chain([Slack::CompressionLimit { eps: 0.0 }, Slack::DeadZone { eps: 0.0 }])
            {
                let (force, energy) = match clamped(slack) {
                    None => run(FourElongations(LinearLaw, e)),
                    Some(law) => run(FourElongations(law, e)),
                };
                let one = e.map(|e| tension(slack, K, e));
                assert_eq!(force.map(f64::to_bits), one.map(|t| t.force.to_bits()), "{slack:?} at {e:?}");
                assert_eq!(energy.map(f64::to_bits), one.map(|t| t.energy.to_bits()), "{slack:?} at {e:?}");
            }
        }
    }
}
