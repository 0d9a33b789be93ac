//! The two kinds of dashpots between the ends of a spring.
//!
//! **Relative** dashpots act on the whole relative velocity (thesis Eq. 53 and 68; Kang 2000). They also damp rigid
//! rotation, so they are not a material; the thesis uses them with c = k dt.
//! ```text
//! force on a = c (vb - va), on b = -c (vb - va)      power = -c |vb - va|^2      -df/dv = c [[I, -I], [-I, I]]
//! ```
//! **Axial** dashpots act along the spring and are clamped together with it (thesis Eq. 4, whose c is divided by l0:
//! rule `per_strain`). Spring and dashpot are one element of tension `T = max(k e + c ldot, floor)`, so that a spring
//! going slack does not make the force jump and an implicit step has a solution. The dashpot's part is the difference
//! from the elastic tension:
//! ```text
//! T_d = max(k (e - offset) + c ldot, floor) - T_elastic(e)      force on a = T_d n, on b = -T_d n
//! power = -T_d ldot,     ldot = n . (vb - va)
//! dT_d/dldot = c on the taut branch, else 0;      dT_d/dl = (slope of the sum) - (slope of the elastic part)
//! -df/dx = (T_d/l)(I - n n^T) + (dT_d/dl) n n^T + (c/l) n [(I - n n^T)(vb - va)]^T      (not symmetric)
//! -df/dv = c n n^T
//! ```

use crate::force::law::slack::{Tension, TensionLaw};
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

/// The part of an axial dashpot, from the spring's law and `elastic` tension, stiffness `k` [N/m], coefficient `c`
/// [N s/m], elongation `e` [m] and its rate [m/s].
#[inline(always)]
pub fn axial<L: TensionLaw, R: Real>(law: &L, elastic: Tension<R>, [k, c]: [R; 2], [e, rate]: [R; 2]) -> Damping<R> {
    let viscous = c * rate;
    match law.clamp() {
        None => Damping { force: viscous, slope: k.all(0.0), c },
        Some(clamp) => {
            let floor = k * k.all(clamp.threshold - clamp.offset);
            let sum = k * (e - k.all(clamp.offset)) + viscous;
            let above = sum - floor;
            Damping {
                force: sum.larger(floor) - elastic.force,
                slope: k.where_not_negative(above) - elastic.slope,
                c: c.where_not_negative(above),
            }
        }
    }
}
