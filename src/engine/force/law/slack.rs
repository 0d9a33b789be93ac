//! When springs are slack: their curve of tension ([`crate::force::law::curve`]) is clamped at one elongation (thesis
//! Eq. 3, both readings).

use crate::force::law::curve::{Bar, Curve, CurveKind, MeanTension, Tension};
use crate::model::quad::Real;
use crate::model::spec::Slack;

/// A tension law, for one spring or several side by side. Monomorphised into the kernels, so that a plain spring needs
/// no branch.
pub trait TensionLaw: Copy + Send + Sync {
    /// Tension, slope and energy at elongation `e` [m].
    fn at<R: Real>(&self, bar: Bar<R>, e: R) -> Tension<R>;

    /// As [`Curve::mean`].
    fn mean(&self, bar: Bar, between: [f64; 2]) -> MeanTension;

    /// The same with the dissipation chi [-] inside of elements ([`crate::force::MeanForce`]).
    fn mean_with(&self, bar: Bar, between: [f64; 2], chi: f64) -> MeanTension {
        let mean = self.mean(bar, between);
        if chi == 0.0 { mean } else { mean.dissipating(between, between.map(|e| self.at(bar, e)), chi) }
    }

    /// As [`Curve::pull`].
    fn pull<R: Real>(&self, bar: Bar<R>, e: R) -> R;

    /// The curve as if it were taut, and the least and largest tension [N] of the law; `None` if it is never slack.
    fn bounds<R: Real>(&self, bar: Bar<R>, e: R) -> Option<(Tension<R>, [R; 2])>;
}

/// A curve without slack.
#[derive(Clone, Copy, Debug)]
pub struct Plain<C>(pub C);

impl<C: Curve> TensionLaw for Plain<C> {
    #[inline(always)]
    fn at<R: Real>(&self, bar: Bar<R>, e: R) -> Tension<R> {
        self.0.at(bar, e)
    }

    fn mean(&self, bar: Bar, between: [f64; 2]) -> MeanTension {
        self.0.mean(bar, between)
    }

    #[inline(always)]
    fn pull<R: Real>(&self, bar: Bar<R>, e: R) -> R {
        self.0.pull(bar, e, self.0.at(bar, e))
    }

    #[inline(always)]
    fn bounds<R: Real>(&self, _: Bar<R>, _: R) -> Option<(Tension<R>, [R; 2])> {
        None
    }
}

/// Where a slack kind clamps: T = T(c - offset) with c = e kept between two elongations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clamp {
    /// [m] elongation below which the tension is constant; -inf = nowhere
    pub lower: f64,
    /// [m] elongation above which it is; inf = nowhere
    pub upper: f64,
    /// [m] elongation of zero tension on the taut branch
    pub offset: f64,
}

impl Clamp {
    /// Nowhere.
    const NONE: Clamp = Clamp { lower: f64::NEG_INFINITY, upper: f64::INFINITY, offset: 0.0 };

    /// Of a slack kind; `None` for a spring that is never slack.
    pub fn of(slack: Slack) -> Option<Clamp> {
        match slack {
            Slack::None => None,
            Slack::TensionOnly => Some(Clamp { lower: 0.0, ..Clamp::NONE }),
            Slack::DeadZone { eps } => Some(Clamp { lower: eps, offset: eps, ..Clamp::NONE }),
            // Not -eps: for eps = 0 it would be -0, which would change bits in the kernel for four springs.
            Slack::CompressionLimit { eps } => Some(Clamp { lower: 0.0 - eps, ..Clamp::NONE }),
            Slack::CompressionOnly => Some(Clamp { upper: 0.0, ..Clamp::NONE }),
        }
    }

    /// The same, with limits that are not reached where it is never slack.
    pub fn or_none(slack: Slack) -> Clamp {
        Clamp::of(slack).unwrap_or(Clamp::NONE)
    }

    /// [m] The elongation, or the nearest one at which the spring is taut.
    pub fn taut(self, e: f64) -> f64 {
        e.max(self.lower).min(self.upper)
    }

    /// Whether the spring is taut below its threshold, and not above it.
    pub fn pushes(&self) -> bool {
        self.upper.is_finite()
    }

    /// [m] The elongation at which the spring goes slack.
    pub fn threshold(&self) -> f64 {
        if self.pushes() { self.upper } else { self.lower }
    }
}

/// A curve that is clamped.
#[derive(Clone, Copy, Debug)]
pub struct Clamped<C> {
    /// of the taut branch
    pub curve: C,
    /// where
    pub clamp: Clamp,
}

impl<C: Curve> Clamped<C> {
    /// [m] Elongation of the taut branch.
    #[inline(always)]
    fn taut<R: Real>(&self, e: R) -> R {
        e - e.all(self.clamp.offset)
    }

    #[inline(always)]
    fn clamped<R: Real>(&self, e: R) -> R {
        e.larger(e.all(self.clamp.lower)).smaller(e.all(self.clamp.upper))
    }
}

impl<C: Curve> TensionLaw for Clamped<C> {
    #[inline(always)]
    fn at<R: Real>(&self, bar: Bar<R>, e: R) -> Tension<R> {
        let (c, Clamp { lower, upper, .. }) = (self.clamped(e), self.clamp);
        let Tension { force, slope, energy } = self.curve.at(bar, self.taut(c));
        let slope = slope.where_not_negative(e - e.all(lower)).where_not_negative(e.all(upper) - e);
        // Beyond a limit the force is constant, so its work is linear in the elongation.
        Tension { force, slope, energy: energy + force * (e - c) }
    }

    /// The share w of the way that is taut has the mean of the curve there, the rest the tension at the limit.
    fn mean(&self, bar: Bar, [e0, e1]: [f64; 2]) -> MeanTension {
        let [c0, c1] = [e0, e1].map(|e| self.clamped(e));
        let taut = self.curve.mean(bar, [self.taut(c0), self.taut(c1)]);
        if c0 == e0 && c1 == e1 {
            return taut;
        }
        // Each kind has one limit.
        let limit = if c0 == e0 { c1 } else { c0 };
        let (slack, way) = (self.curve.at(bar, self.taut(limit)).force, e1 - e0);
        if c0 == c1 {
            return MeanTension { force: slack, slope: 0.0 };
        }
        let w = (c1 - c0) / way;
        let slope = match c1 == e1 {
            true => (1.0 - w) / way * (taut.force - slack) + w * taut.slope,
            false => -w / way * (taut.force - slack),
        };
        MeanTension { force: w * taut.force + (1.0 - w) * slack, slope }
    }

    #[inline(always)]
    fn pull<R: Real>(&self, bar: Bar<R>, e: R) -> R {
        let taut = self.taut(self.clamped(e));
        self.curve.pull(bar, taut, self.curve.at(bar, taut))
    }

    #[inline(always)]
    fn bounds<R: Real>(&self, bar: Bar<R>, e: R) -> Option<(Tension<R>, [R; 2])> {
        let bound = |limit: f64| match limit.is_finite() {
            true => self.curve.at(bar, self.taut(e.all(limit))).force,
            false => e.all(limit),
        };
        Some((self.curve.at(bar, self.taut(e)), [bound(self.clamp.lower), bound(self.clamp.upper)]))
    }
}

/// Evaluates an expression with the law of springs with this curve and slack kind: the one place that knows which law
/// a kind has.
macro_rules! with_law {
    ($curve:expr, $slack:expr, $law:ident => $then:expr) => {{
        use $crate::force::law::curve::{CurveKind, Green, Linear, Tabled};
        use $crate::force::law::slack::{Clamp, Clamped, Plain};
        match ($curve, Clamp::of($slack)) {
            (CurveKind::Linear, None) => {
                let $law = Plain(Linear);
                $then
            }
            (CurveKind::Linear, Some(clamp)) => {
                let $law = Clamped { curve: Linear, clamp };
                $then
            }
            (CurveKind::Green, _) => {
                let $law = Clamped { curve: Green, clamp: Clamp::or_none($slack) };
                $then
            }
            (CurveKind::Table(kinks), _) => {
                let $law = Clamped { curve: Tabled(kinks), clamp: Clamp::or_none($slack) };
                $then
            }
        }
    }};
}
pub(in crate::force) use with_law;

/// The law of any springs, when speed does not matter.
pub fn tension(curve: &CurveKind, slack: Slack, bar: Bar, e: f64) -> Tension {
    with_law!(curve, slack, law => law.at(bar, e))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::law::curve::Linear;
    use crate::model::quad::{Pass, Quad, VectorUnit, run};

    const K: f64 = 7.0;
    const EPS: f64 = 0.2;
    const BAR: Bar = Bar { k: K, l0: 1.0 };

    /// Linear springs.
    fn tension(slack: Slack, k: f64, e: f64) -> Tension {
        super::tension(&CurveKind::Linear, slack, Bar { k, ..BAR }, e)
    }

    fn kinds() -> [Slack; 5] {
        let eps = EPS;
        let one_sided = [Slack::TensionOnly, Slack::DeadZone { eps }, Slack::CompressionLimit { eps }];
        [Slack::None, one_sided[0], one_sided[1], one_sided[2], Slack::CompressionOnly]
    }

    #[test]
    fn tension_follows_the_written_laws() {
        for i in -40..=40 {
            let e = 0.025 * f64::from(i);
            let expected = [K * e, K * e.max(0.0), K * (e - EPS).max(0.0), K * e.max(-EPS), K * e.min(0.0)]
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
        assert_eq!([0.0, 1e-9].map(|e| tension(Slack::CompressionOnly, K, e).slope), [K, 0.0]);
    }

    struct FourElongations<L>(L, [f64; 4]);

    impl<L: TensionLaw> Pass for FourElongations<L> {
        type Output = ([f64; 4], [f64; 4]);

        #[inline(always)]
        fn run<U: VectorUnit>(self, unit: U) -> Self::Output {
            let tension = self.0.at(Bar { k: unit.splat(K), l0: unit.splat(BAR.l0) }, unit.quad(self.1));
            (tension.force.numbers(), tension.energy.numbers())
        }
    }

    #[test]
    fn four_springs_side_by_side_have_the_bits_of_one() {
        for i in -40..=40 {
            let e = [0.0, 0.003, 0.01, 0.02].map(|d| 0.025 * f64::from(i) + d);
            for slack in kinds().into_iter().chain([Slack::CompressionLimit { eps: 0.0 }, Slack::DeadZone { eps: 0.0 }])
            {
                let (force, energy) = match Clamp::of(slack) {
                    None => run(FourElongations(Plain(Linear), e)),
                    Some(clamp) => run(FourElongations(Clamped { curve: Linear, clamp }, e)),
                };
                let one = e.map(|e| tension(slack, K, e));
                assert_eq!(force.map(f64::to_bits), one.map(|t| t.force.to_bits()), "{slack:?} at {e:?}");
                assert_eq!(energy.map(f64::to_bits), one.map(|t| t.energy.to_bits()), "{slack:?} at {e:?}");
            }
        }
    }
}
