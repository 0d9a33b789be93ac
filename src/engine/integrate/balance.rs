//! The loops of an implicit step's equations over all degrees of freedom. Slices are `[n_dof]`. Fixed degrees of
//! freedom have z = 0, or h v where a support moves them, and their results are not used.

use super::stage::StageMap;
use crate::model::lanes::{LANES, Lanes};
use crate::model::workers::Workers;
use multiversion::multiversion;
use std::ops::Range;

/// State at the step's start.
#[derive(Clone, Copy)]
pub(super) struct Start<'a> {
    /// [m]
    pub x: &'a [f64],
    /// [m/s]
    pub v: &'a [f64],
    /// [m/s^2]
    pub a: &'a [f64],
}

impl<'a> Start<'a> {
    fn of(self, r: Range<usize>) -> Self {
        Start { x: &self.x[r.clone()], v: &self.v[r.clone()], a: &self.a[r] }
    }
}

/// x = x_n + z,   v = cv z + vv v_n + va a_n
pub(super) fn displace(workers: &Workers, map: StageMap, z: &[f64], n: Start<'_>, x: &mut [f64], v: &mut [f64]) {
    workers.both(x, v, |r, x, v| displace_some(map, &z[r.clone()], n.of(r), x, v));
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn displace_some(map: StageMap, z: &[f64], n: Start<'_>, x: &mut [f64], v: &mut [f64]) {
    let start = z.iter().zip(n.x).zip(n.v).zip(n.a);
    for ((((z, x_n), v_n), a_n), (x, v)) in start.zip(x.iter_mut().zip(v)) {
        *x = x_n + z;
        *v = map.cv * z + map.vv * v_n + map.va * a_n;
    }
}

/// [N] forces at both ends of a step, and the masses.
#[derive(Clone, Copy)]
pub(super) struct Forces<'a> {
    pub f_n: &'a [f64],
    pub f: &'a [f64],
    /// [kg] diagonal of M
    pub mass: &'a [f64],
}

impl<'a> Forces<'a> {
    fn of(self, r: Range<usize>) -> Self {
        Forces { f_n: &self.f_n[r.clone()], f: &self.f[r.clone()], mass: &self.mass[r] }
    }
}

/// a = ca z + av v_n + aa a_n,   r = M ((1 - am) a + am a_n) - (1 - af) f - af f_n [N], which overwrites z.
pub(super) fn unbalanced(
    workers: &Workers,
    map: StageMap,
    n: Start<'_>,
    forces: Forces<'_>,
    a: &mut [f64],
    z_to_r: &mut [f64],
) {
    workers.both(a, z_to_r, |r, a, z_to_r| unbalanced_some(map, n.of(r.clone()), forces.of(r), a, z_to_r));
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn unbalanced_some(map: StageMap, n: Start<'_>, forces: Forces<'_>, a: &mut [f64], z_to_r: &mut [f64]) {
    let forces = forces.mass.iter().zip(forces.f_n).zip(forces.f);
    for ((((mass, f_n), f), (v_n, a_n)), (a, r)) in forces.zip(n.v.iter().zip(n.a)).zip(a.iter_mut().zip(z_to_r)) {
        *a = map.ca * *r + map.av * v_n + map.aa * a_n;
        *r = mass * ((1.0 - map.am) * *a + map.am * a_n) - ((1.0 - map.af) * f + map.af * f_n);
    }
}

/// What rounding errors are proportional to, besides the forces.
#[derive(Clone, Copy)]
pub(super) struct Sizes<'a> {
    /// [N/m] by degree of freedom
    pub stiffness: &'a [f64],
    /// [m] Largest coordinate in `x` `[n_dof]`.
    pub largest: f64,
    /// [m/s^2] accelerations at the end
    pub a: &'a [f64],
}

/// [N] Rounding error of every residual: positions are rounded to eps |x|, which springs turn into force; inertia is a
/// difference of terms as large as M v/(beta h).
pub(super) fn rounding(
    workers: &Workers,
    map: StageMap,
    n: Start<'_>,
    forces: Forces<'_>,
    sizes: Sizes<'_>,
    floor: &mut [f64],
) {
    workers.set(floor, |r, floor| {
        let sizes = Sizes { stiffness: &sizes.stiffness[r.clone()], a: &sizes.a[r.clone()], ..sizes };
        rounding_some(map, n.of(r.clone()), forces.of(r), sizes, floor);
    });
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn rounding_some(map: StageMap, n: Start<'_>, forces: Forces<'_>, sizes: Sizes<'_>, floor: &mut [f64]) {
    let moved = map.av.abs();
    let forces = forces.mass.iter().zip(forces.f_n).zip(forces.f);
    let terms = forces.zip(n.v.iter().zip(n.a)).zip(sizes.stiffness.iter().zip(sizes.a));
    for (((((mass, f_n), f), (v_n, a_n)), (stiffness, a)), floor) in terms.zip(floor) {
        let force = ((1.0 - map.af) * f + map.af * f_n).abs();
        let inertia = mass * (((1.0 - map.am) * a + map.am * a_n).abs() + moved * v_n.abs());
        *floor = 4.0 * f64::EPSILON * (stiffness * sizes.largest + force + inertia);
    }
}

/// a + s (a - a_b) [m/s^2]: linear extrapolation from the accelerations a_b before the last step.
pub(super) fn go_on(workers: &Workers, s: f64, before: &[f64], a: &[f64], out: &mut [f64]) {
    workers.set(out, |r, out| {
        for ((out, before), a) in out.iter_mut().zip(&before[r.clone()]).zip(&a[r]) {
            *out = a + s * (a - before);
        }
    });
}

/// Whether the accelerations `a` are nearer to the expected ones than to those at the start, in the mean square.
pub(super) fn is_nearer_to_expected(workers: &Workers, expected: &[f64], a_n: &[f64], a: &[f64]) -> bool {
    workers.sum(a.len(), |r| gained(&expected[r.clone()], &a_n[r.clone()], &a[r])) > 0.0
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn gained(expected: &[f64], a_n: &[f64], a: &[f64]) -> f64 {
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
    gained.total() + last
}
