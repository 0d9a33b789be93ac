//! The loops of an implicit step's equations over all degrees of freedom; fixed ones have z = 0, and what comes out for them is not looked at.

use super::stage::StageMap;
use crate::model::lanes::{LANES, Lanes};
use multiversion::multiversion;

/// A step's start.
#[derive(Clone, Copy)]
pub(super) struct Start<'a> {
    /// [m]
    pub x: &'a [f64],
    /// [m/s]
    pub v: &'a [f64],
    /// [m/s^2]
    pub a: &'a [f64],
}

/// Its end.
pub(super) struct End<'a> {
    /// [m]
    pub x: &'a mut [f64],
    /// [m/s]
    pub v: &'a mut [f64],
    /// [m/s^2]
    pub a: &'a mut [f64],
}

/// x = x_n + z,   v = cv z + vv v_n + va a_n,   a = ca z + av v_n + aa a_n
#[multiversion(targets("x86_64+avx+avx2"))]
pub(super) fn displace(map: StageMap, z: &[f64], n: Start<'_>, to: End<'_>) {
    let start = z.iter().zip(n.x).zip(n.v).zip(n.a);
    let end = to.x.iter_mut().zip(to.v).zip(to.a);
    for ((((z, x_n), v_n), a_n), ((x, v), a)) in start.zip(end) {
        *x = x_n + z;
        *v = map.cv * z + map.vv * v_n + map.va * a_n;
        *a = map.ca * z + map.av * v_n + map.aa * a_n;
    }
}

/// What the forces of inertia are made of.
#[derive(Clone, Copy)]
pub(super) struct Inertial<'a> {
    /// [kg] diagonal of M
    pub mass: &'a [f64],
    /// [m/s^2] at the start
    pub a_n: &'a [f64],
    /// [m/s^2] at the end
    pub a: &'a [f64],
}

/// [N] forces at both ends.
#[derive(Clone, Copy)]
pub(super) struct Ends<'a> {
    pub f_n: &'a [f64],
    pub f: &'a [f64],
}

/// r = M ((1 - am) a + am a_n) - (1 - af) f - af f_n [N]
#[multiversion(targets("x86_64+avx+avx2"))]
pub(super) fn unbalanced(map: StageMap, inertia: Inertial<'_>, forces: Ends<'_>, r: &mut [f64]) {
    let accelerations = inertia.mass.iter().zip(inertia.a_n).zip(inertia.a);
    for ((((mass, a_n), a), (f_n, f)), r) in accelerations.zip(forces.f_n.iter().zip(forces.f)).zip(r) {
        *r = mass * ((1.0 - map.am) * a + map.am * a_n) - ((1.0 - map.af) * f + map.af * f_n);
    }
}

/// What rounding is proportional to, besides the residual.
#[derive(Clone, Copy)]
pub(super) struct Sizes<'a> {
    /// [N/m] by degree of freedom
    pub stiffness: &'a [f64],
    /// [m] largest coordinate
    pub largest: f64,
    /// [m/s]
    pub v_n: &'a [f64],
}

/// [N] The rounding of every residual: positions are rounded to eps |x|, which springs turn into force; inertia is a difference of terms as large as
/// M v/(beta h).
#[multiversion(targets("x86_64+avx+avx2"))]
pub(super) fn rounding(map: StageMap, inertia: Inertial<'_>, forces: Ends<'_>, sizes: Sizes<'_>, floor: &mut [f64]) {
    let moved = map.av.abs();
    let accelerations = inertia.mass.iter().zip(inertia.a_n).zip(inertia.a);
    let terms = accelerations.zip(forces.f_n.iter().zip(forces.f)).zip(sizes.stiffness.iter().zip(sizes.v_n));
    for (((((mass, a_n), a), (f_n, f)), (stiffness, v_n)), floor) in terms.zip(floor) {
        let force = ((1.0 - map.af) * f + map.af * f_n).abs();
        let inertia = mass * (((1.0 - map.am) * a + map.am * a_n).abs() + moved * v_n.abs());
        *floor = 4.0 * f64::EPSILON * (stiffness * sizes.largest + force + inertia);
    }
}

/// a + s (a - a_b) [m/s^2]: on along a straight line from the accelerations a_b before the last step
#[multiversion(targets("x86_64+avx+avx2"))]
pub(super) fn go_on(s: f64, before: &[f64], a: &[f64], out: &mut [f64]) {
    for ((out, before), a) in out.iter_mut().zip(before).zip(a) {
        *out = a + s * (a - before);
    }
}

/// Whether accelerations came out nearer to what was expected than to those at the start, in the mean square.
#[multiversion(targets("x86_64+avx+avx2"))]
pub(super) fn came_as(expected: &[f64], a_n: &[f64], a: &[f64]) -> bool {
    let (mut gained, mut last) = (Lanes::default(), 0.0);
    let ((expected, others), (a_n, starts), (a, ends)) =
        (expected.as_chunks::<LANES>(), a_n.as_chunks::<LANES>(), a.as_chunks::<LANES>());
    for ((expected, a_n), a) in expected.iter().zip(a_n).zip(a) {
        let mut gain = [0.0; LANES];
        for j in 0..LANES {
            gain[j] = (a[j] - a_n[j]).powi(2) - (a[j] - expected[j]).powi(2);
        }
        gained.add(&gain);
    }
    for ((expected, a_n), a) in others.iter().zip(starts).zip(ends) {
        last += (a - a_n).powi(2) - (a - expected).powi(2);
    }
    gained.total() + last > 0.0
}
