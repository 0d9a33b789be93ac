//! How the tension of a spring grows with its elongation e, before any slack: T = k l0 phi(e/l0).
//!
//! ```text
//! linear   T = k e                                   energy = k e^2/2
//! green    T = k e (1 + r)(1 + r/2),  r = e/l0       energy = k e^2/2 (1 + r/2)^2
//! table    T = k l0 phi(r)                           phi linear between the rows of a table
//! ```
//! The second is the St. Venant-Kirchhoff bar, T = EA lambda (lambda^2 - 1)/2 with k = EA/l0 and lambda = l/l0: the
//! second Piola-Kirchhoff stress is E times the Green strain (Bonet and Wood 2008). It is the truss of most
//! finite-element codes. Its compression grows weaker below lambda = 1/sqrt(3), and is 0 at lambda = 0.

use crate::model::quad::Real;
use crate::model::spec::ElasticLaw;
use std::sync::Arc;

/// A spring's elastic tension at one elongation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tension<R = f64> {
    /// [N] tension T
    pub force: R,
    /// [N/m] dT/dl; at a kink, the slope on the side of the longer spring
    pub slope: R,
    /// [J] stored energy, zero at rest
    pub energy: R,
}

/// A spring's mean tension between two elongations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MeanTension {
    /// [N]
    pub force: f64,
    /// [N/m] its derivative by the second elongation
    pub slope: f64,
}

impl MeanTension {
    /// With chi/2 of the change of the tension added, unless it falls while the spring becomes longer.
    pub fn dissipating(self, [e0, e1]: [f64; 2], [t0, t1]: [Tension; 2], chi: f64) -> Self {
        let change = t1.force - t0.force;
        if change * (e1 - e0) <= 0.0 {
            return self;
        }
        MeanTension { force: self.force + 0.5 * chi * change, slope: self.slope + 0.5 * chi * t1.slope }
    }
}

/// What a spring brings to its law.
#[derive(Clone, Copy, Debug)]
pub struct Bar<R = f64> {
    /// [N/m] stiffness k
    pub k: R,
    /// [m] rest length l0
    pub l0: R,
}

/// A curve of tension over elongation, for one spring or several side by side.
pub trait Curve: Copy + Send + Sync {
    /// Tension, slope and energy at elongation `e` [m].
    fn at<R: Real>(&self, bar: Bar<R>, e: R) -> Tension<R>;

    /// The mean tension between two elongations [m], (E_1 - E_0)/(e_1 - e_0), without the cancellation of this
    /// quotient.
    fn mean(&self, bar: Bar, between: [f64; 2]) -> MeanTension;

    /// [N] -dE/dl0 at a fixed length and stiffness: the work of reeling in. `tension` is that at elongation `e` [m].
    fn pull<R: Real>(&self, bar: Bar<R>, e: R, tension: Tension<R>) -> R {
        // E = k l0^2 Phi(e/l0), with e = l - l0.
        let two = e.all(2.0);
        tension.force + ((tension.force * e - two * tension.energy) / bar.l0).where_positive(bar.l0)
    }
}

/// T = k e.
#[derive(Clone, Copy, Debug)]
pub struct Linear;

impl Curve for Linear {
    #[inline(always)]
    fn at<R: Real>(&self, Bar { k, .. }: Bar<R>, e: R) -> Tension<R> {
        let force = k * e;
        Tension { force, slope: k, energy: k.all(0.5) * force * e }
    }

    fn mean(&self, Bar { k, .. }: Bar, [e0, e1]: [f64; 2]) -> MeanTension {
        MeanTension { force: 0.5 * k * (e0 + e1), slope: 0.5 * k }
    }

    #[inline(always)]
    fn pull<R: Real>(&self, _: Bar<R>, _: R, tension: Tension<R>) -> R {
        tension.force
    }
}

/// T = k e (1 + e/l0)(1 + e/(2 l0)).
#[derive(Clone, Copy, Debug)]
pub struct Green;

impl Curve for Green {
    #[inline(always)]
    fn at<R: Real>(&self, Bar { k, l0 }: Bar<R>, e: R) -> Tension<R> {
        let (one, half) = (e.all(1.0), e.all(0.5));
        // Kernels fill their groups with bars of no length.
        let r = (e / l0).where_positive(l0);
        let (stretch, mean) = (one + r, one + half * r);
        let linear = k * e;
        let slope = k * (e.all(1.5) * stretch * stretch - half);
        Tension { force: linear * stretch * mean, slope, energy: half * linear * e * (mean * mean) }
    }

    /// With the Green strains E = r (1 + r/2): k l0 (E_0 + E_1)/2 (1 + (r_0 + r_1)/2).
    fn mean(&self, Bar { k, l0 }: Bar, [e0, e1]: [f64; 2]) -> MeanTension {
        let [r0, r1] = [e0, e1].map(|e| if l0 > 0.0 { e / l0 } else { 0.0 });
        let (green, stretch) = (e0 * (1.0 + 0.5 * r0) + e1 * (1.0 + 0.5 * r1), 1.0 + 0.5 * (r0 + r1));
        let strain = r0 * (1.0 + 0.5 * r0) + r1 * (1.0 + 0.5 * r1);
        MeanTension { force: 0.5 * k * green * stretch, slope: 0.5 * k * ((1.0 + r1) * stretch + 0.5 * strain) }
    }
}

/// A kink of a piecewise linear curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kink {
    /// [-] strain
    pub at: f64,
    /// [-] change of the slope with growing strain
    pub change: f64,
    /// [-] 1 for a kink at a strain of 0 or above, -1 for one below
    pub side: f64,
}

impl Kink {
    /// Its share (p_1^2 - p_0^2)/(2 (r_1 - r_0)) in the mean of phi between two strains, and the derivative by r_1. p
    /// is how far a strain is beyond it.
    fn mean(&self, [r0, r1]: [f64; 2]) -> [f64; 2] {
        let [p0, p1] = [r0, r1].map(|r| ((r - self.at) * self.side).max(0.0));
        let share = |p: f64| p / (r1 - r0).abs();
        let [mean, slope] = match [p0 > 0.0, p1 > 0.0] {
            [false, false] => [0.0; 2],
            [true, true] => [0.5 * (p0 + p1), 0.5],
            [false, true] => [0.5 * p1 * share(p1), share(p1) - 0.5 * share(p1).powi(2)],
            [true, false] => [0.5 * p0 * share(p0), 0.5 * share(p0).powi(2)],
        };
        [self.change * mean, self.change * self.side * slope]
    }
}

/// phi of a table: its slope just below the strain 0, and its kinks.
#[derive(Clone, Debug, PartialEq)]
pub struct Kinks {
    slope: f64,
    kinks: Vec<Kink>,
}

impl Kinks {
    /// From rows of strain and of force over the steepest slope; the curve goes on beyond both ends. `None` with fewer
    /// than two rows.
    fn of(rows: &[[f64; 2]]) -> Option<Self> {
        let slopes: Vec<f64> =
            rows.windows(2).map(|pair| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).collect();
        let steepest = slopes.iter().copied().fold(0.0, f64::max);
        let below_zero = rows[1..].iter().position(|row| row[0] >= 0.0).unwrap_or(slopes.len() - 1);
        let slope = slopes.get(below_zero)? / steepest;
        let between = rows.get(1..rows.len() - 1)?.iter().zip(slopes.windows(2));
        let kinks = between.map(|(&[at, _], pair)| Kink {
            at,
            change: (pair[1] - pair[0]) / steepest,
            side: if at < 0.0 { -1.0 } else { 1.0 },
        });
        Some(Kinks { slope, kinks: kinks.collect() })
    }
}

/// T = k l0 phi(e/l0) with the phi of a table.
#[derive(Clone, Copy, Debug)]
pub struct Tabled<'a>(pub &'a Kinks);

impl Curve for Tabled<'_> {
    #[inline(always)]
    fn at<R: Real>(&self, Bar { k, l0 }: Bar<R>, e: R) -> Tension<R> {
        let r = (e / l0).where_positive(l0);
        let mut slope = r.all(self.0.slope);
        let mut force = slope * r;
        let mut energy = force * r;
        for Kink { at, change, side } in &self.0.kinks {
            let beyond = (r - r.all(*at)) * r.all(*side);
            let (past, change) = (beyond.larger(r.all(0.0)), r.all(*change));
            let side = r.all(*side);
            force = force + change * past;
            energy = energy + side * change * (past * past);
            slope = slope + side * change.where_not_negative(beyond);
        }
        let size = k * l0;
        Tension { force: size * force, slope: k * slope, energy: r.all(0.5) * size * l0 * energy }
    }

    fn mean(&self, Bar { k, l0 }: Bar, between: [f64; 2]) -> MeanTension {
        let r = between.map(|e| if l0 > 0.0 { e / l0 } else { 0.0 });
        let mut found = [0.5 * self.0.slope * (r[0] + r[1]), 0.5 * self.0.slope];
        for kink in &self.0.kinks {
            found.iter_mut().zip(kink.mean(r)).for_each(|(found, share)| *found += share);
        }
        MeanTension { force: k * l0 * found[0], slope: k * found[1] }
    }
}

/// The curve of a batch of springs.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum CurveKind {
    /// [`Linear`]
    #[default]
    Linear,
    /// [`Green`]
    Green,
    /// [`Tabled`]
    Table(Arc<Kinks>),
}

impl From<&ElasticLaw> for CurveKind {
    fn from(law: &ElasticLaw) -> Self {
        match law {
            ElasticLaw::Linear => CurveKind::Linear,
            ElasticLaw::Green => CurveKind::Green,
            ElasticLaw::Table(rows) => {
                Kinks::of(rows).map_or(CurveKind::Linear, |kinks| CurveKind::Table(Arc::new(kinks)))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BAR: Bar = Bar { k: 7.0, l0: 1.3 };

    fn kinks() -> Kinks {
        Kinks::of(&[[-0.4, -3.0], [-0.1, -2.0], [0.0, 0.0], [0.1, 0.5], [0.2, 4.5], [0.5, 5.0]]).expect("six rows")
    }

    /// The rows of a table are on its curve, which goes on beyond them with its first and last slopes.
    #[test]
    fn a_table_goes_through_its_rows() {
        let steepest = 40.0;
        let kinks = kinks();
        for [strain, force] in
            [[-0.7, -4.0], [-0.4, -3.0], [-0.25, -2.5], [0.0, 0.0], [0.05, 0.25], [0.1, 0.5], [0.15, 2.5], [0.8, 5.5]]
        {
            let found = Tabled(&kinks).at(BAR, strain * BAR.l0).force * steepest / (BAR.k * BAR.l0);
            assert!((found - force).abs() < 1e-12, "{found} and not {force} at {strain}");
        }
    }

    /// T = EA lambda (lambda^2 - 1)/2.
    #[test]
    fn green_bars_are_those_of_finite_elements() {
        for lambda in [0.2_f64, 0.9, 1.0, 1.27, 2.5] {
            let force = Green.at(BAR, (lambda - 1.0) * BAR.l0).force;
            let expected = BAR.k * BAR.l0 * lambda * (lambda * lambda - 1.0) / 2.0;
            assert!((force - expected).abs() < 1e-13, "{force} and not {expected} at {lambda}");
        }
    }

    /// Slope, tension and pull are derivatives of the energy.
    fn derivatives_agree(curve: impl Curve) {
        for i in -30..60 {
            // No kink of the table is this near.
            let (e, d) = (0.013 * f64::from(i) + 0.0011, 1e-6);
            let energy = |e: f64| curve.at(BAR, e).energy;
            let t = curve.at(BAR, e);
            let force = (energy(e + d) - energy(e - d)) / (2.0 * d);
            let slope = (curve.at(BAR, e + d).force - curve.at(BAR, e - d).force) / (2.0 * d);
            let reeled = |d: f64| curve.at(Bar { l0: BAR.l0 + d, ..BAR }, e - d).energy;
            let pull = (reeled(-d) - reeled(d)) / (2.0 * d);
            for (found, expected) in [(t.force, force), (t.slope, slope), (curve.pull(BAR, e, t), pull)] {
                assert!((found - expected).abs() < 1e-8 * expected.abs().max(1.0), "{found} and not {expected} at {e}");
            }
        }
    }

    #[test]
    fn energies_belong_to_tensions() {
        derivatives_agree(Linear);
        derivatives_agree(Green);
        derivatives_agree(Tabled(&kinks()));
    }
}
