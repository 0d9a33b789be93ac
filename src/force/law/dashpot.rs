//! The two kinds of dashpots between the ends of a spring.
//!
//! **Relative** dashpots act on the whole relative velocity (thesis Eq. 53 and 68; Kang 2000). They also damp rigid
//! rotation, so they are not a material; the thesis uses them with c = k dt.
//! ```text
//! force on a = c (vb - va), on b = -c (vb - va)      power = -c |vb - va|^2      -df/dv = c [[I, -I], [-I, I]]
//! ```
//! **Axial** dashpots act along the spring (thesis Eq. 4, whose c is divided by l0: rule `per_strain`). Beside a spring
//! that can be slack they act as far as the spring does: their force is at most the distance of its tension from the
//! bound, for a tension-only spring at most its tension, so the sum is between 0 and twice the tension.
//! ```text
//! room = T - floor (or ceiling - T)       T_d = c ldot, kept within -room and room
//! force on a = T_d n, on b = -T_d n       power = -T_d ldot <= 0,     ldot = n . (vb - va)
//! dT_d/dldot = c within the room, else 0;      dT_d/dl = 0 within the room, else plus or minus its slope
//! -df/dx = (T_d/l)(I - n n^T) + (dT_d/dl) n n^T + (c/l) n [(I - n n^T)(vb - va)]^T      (not symmetric)
//! -df/dv = c n n^T
//! ```
//! A dashpot that began with c ldot at once would make the force of a rope jump when it becomes taut. An implicit step
//! that ends close to that length would then have no solution. For the same reason models of contact let damping grow
//! with the force (Hunt and Crossley 1975). The limit acts within about the retardation time c/k of becoming taut.

use crate::force::law::curve::{Bar, Tension};
use crate::force::law::slack::TensionLaw;
use crate::model::quad::Real;

/// The force that a dashpot along a spring adds to its tension.
#[derive(Clone, Copy, Debug)]
pub struct Damping<R = f64> {
    /// [N] T_d
    pub force: R,
    /// [N/m] dT_d/dl
    pub slope: R,
    /// [N s/m] dT_d/dldot
    pub c: R,
}

/// The part of an axial dashpot with coefficient `c` [N s/m], from the spring's law and `elastic` tension, elongation
/// `e` [m] and its rate [m/s].
#[inline(always)]
pub fn axial<L: TensionLaw, R: Real>(
    law: &L,
    elastic: Tension<R>,
    (bar, c): (Bar<R>, R),
    [e, rate]: [R; 2],
) -> Damping<R> {
    let (viscous, zero) = (c * rate, c.all(0.0));
    let Some([lower, upper]) = law.bounds(bar, e).map(|(_, bounds)| bounds) else {
        return Damping { force: viscous, slope: zero, c };
    };
    let (above, below) = (elastic.force - lower, upper - elastic.force);
    let room = above.smaller(below).larger(zero);
    // The bound that limits it moves with the tension, up or down.
    let moving = elastic.slope.where_positive(viscous) - elastic.slope.where_positive(zero - viscous);
    let moving = moving.where_not_negative(below - above) - moving.where_positive(above - below);
    // A spring that begins to be taut has no room yet, but a slope.
    let taut = room.larger(elastic.slope);
    Damping {
        force: viscous.smaller(room).larger(zero - room),
        slope: moving.where_positive(viscous.abs() - room),
        c: c.where_not_negative(room - viscous.abs()).where_positive(taut),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::law::curve::CurveKind;
    use crate::force::law::slack::{tension, with_law};
    use crate::model::spec::Slack;

    const BAR: Bar = Bar { k: 100.0, l0: 1.0 };
    const C: f64 = 4.0;

    fn damping(slack: Slack, [e, rate]: [f64; 2]) -> Damping {
        let elastic = tension(&CurveKind::Linear, slack, BAR, e);
        with_law!(&CurveKind::Linear, slack, law => axial(&law, elastic, (BAR, C), [e, rate]))
    }

    fn kinds() -> [Slack; 5] {
        let eps = 0.1;
        let one_sided = [Slack::TensionOnly, Slack::DeadZone { eps }, Slack::CompressionLimit { eps }];
        [Slack::None, one_sided[0], one_sided[1], one_sided[2], Slack::CompressionOnly]
    }

    /// No force while slack, none that feeds energy in, none that jumps, and a rope never pushes.
    #[test]
    fn a_dashpot_acts_as_far_as_its_spring_does() {
        for slack in kinds() {
            let total = |e, rate| tension(&CurveKind::Linear, slack, BAR, e).force + damping(slack, [e, rate]).force;
            for (i, j) in (-30..=30).flat_map(|i| (-30..=30).map(move |j| (i, j))) {
                let (e, rate) = (0.01 * f64::from(i) + 0.005, 0.5 * f64::from(j));
                let (elastic, d) = (tension(&CurveKind::Linear, slack, BAR, e), damping(slack, [e, rate]));
                assert!(d.force * rate >= 0.0, "{slack:?} at {e} m, {rate} m/s");
                if elastic.slope == 0.0 {
                    assert_eq!((d.force, d.slope, d.c), (0.0, 0.0, 0.0), "{slack:?} at {e} m, {rate} m/s");
                }
                assert!((total(e + 1e-9, rate) - total(e, rate)).abs() < 3e-7, "{slack:?} jumps at {e} m");
                assert!(slack != Slack::TensionOnly || total(e, rate) >= 0.0, "pushes at {e} m, {rate} m/s");
            }
            assert!((total(1e-12, 5.0) - total(-1e-12, 5.0)).abs() < 1e-9 || slack == Slack::None, "{slack:?} jumps");
        }
    }

    /// The derivatives are those of the force, on both sides of every kink.
    #[test]
    fn its_derivatives_equal_differences() {
        for slack in kinds() {
            for (i, j) in (-20..=20).flat_map(|i| (-20..=20).map(move |j| (i, j))) {
                let (e, rate) = (0.017 * f64::from(i) + 0.003, 0.31 * f64::from(j) + 0.073);
                let (d, h) = (damping(slack, [e, rate]), 1e-7);
                let difference =
                    |at: [[f64; 2]; 2]| (damping(slack, at[1]).force - damping(slack, at[0]).force) / (2.0 * h);
                let slopes = [difference([[e - h, rate], [e + h, rate]]), difference([[e, rate - h], [e, rate + h]])];
                for (found, expected) in [d.slope, d.c].into_iter().zip(slopes) {
                    assert!((found - expected).abs() < 1e-4, "{slack:?} at {e} m, {rate} m/s: {found}, {expected}");
                }
            }
        }
    }
}
