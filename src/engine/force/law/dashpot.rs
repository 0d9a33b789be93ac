//! The two kinds of dashpots between the ends of a spring.
//!
//! **Relative** dashpots act on the whole relative velocity (thesis Eq. 53 and 68; Kang 2000). They also damp rigid
//! rotation, so they are not a material; the thesis uses them with c = k dt.
//! ```text
//! force on a = c (vb - va), on b = -c (vb - va)      power = -c |vb - va|^2      -df/dv = c [[I, -I], [-I, I]]
//! ```
//! **Axial** dashpots act along the spring and are clamped together with it (thesis Eq. 4, whose c is divided by l0:
//! rule `per_strain`). Spring and dashpot are one element of tension `T = max(T(e) + c ldot, floor)`, so that a spring
//! going slack does not make the force jump and an implicit step has a solution. The dashpot's part is the difference
//! from the elastic tension:
//! ```text
//! T_d = max(T_taut(e - offset) + c ldot, floor) - T_elastic(e)      force on a = T_d n, on b = -T_d n
//! power = -T_d ldot,     ldot = n . (vb - va)
//! dT_d/dldot = c on the taut branch, else 0;      dT_d/dl = (slope of the sum) - (slope of the elastic part)
//! -df/dx = (T_d/l)(I - n n^T) + (dT_d/dl) n n^T + (c/l) n [(I - n n^T)(vb - va)]^T      (not symmetric)
//! -df/dv = c n n^T
//! ```

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
    let viscous = c * rate;
    match law.bounds(bar, e) {
        None => Damping { force: viscous, slope: c.all(0.0), c },
        Some((taut, [lower, upper])) => {
            let sum = taut.force + viscous;
            let inside = |number: R| number.where_not_negative(sum - lower).where_not_negative(upper - sum);
            Damping {
                force: sum.larger(lower).smaller(upper) - elastic.force,
                slope: inside(taut.slope) - elastic.slope,
                c: inside(c),
            }
        }
    }
}
