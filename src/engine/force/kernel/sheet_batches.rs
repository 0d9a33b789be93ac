//! Triangles of a sheet with a rest shape, four side by side.
//!
//! ```text
//! F = [x1 - x0, x2 - x0] R,   E = 1/2 (F^T F - X^2),   f1, f2 = -A0 (F S) R^T by columns,   f0 = -f1 - f2
//! ```
//! R is the inverse of the rest shape in the axes of the material times X = diag(x_1, x_2), which scale them
//! ([`crate::force::law::tension_field`]).

use crate::force::kernel::local_buffer::{Records, record, set_record};
use crate::model::quad::{Pass, Quad, Real, VectorUnit};

/// Triangles side by side.
pub(in crate::force) const SIDE_BY_SIDE: usize = 4;

/// Four triangles by where the records of their nodes begin.
pub(in crate::force) type Group = [[u16; 3]; SIDE_BY_SIDE];

/// The rest shapes of four triangles: R row by row, and A0 [m^2].
pub(in crate::force) type GroupShapes = [[f64; SIDE_BY_SIDE]; 5];

/// What a sheet does to its strain: a pure function, for one triangle or four side by side.
pub(in crate::force) trait SheetLaw {
    /// whether there is an elastic force
    const ELASTIC: bool;
    /// whether there is a damping force
    const DAMPED: bool;

    /// Stresses of triangles by their strains (11, 22, 2 * 12) and the rates of these; `#[inline(always)]`.
    fn stress<R: Real>(&self, strain: [R; 3], rate: [R; 3]) -> SheetStress<R>;
}

/// Stresses (11, 22, 12) of a triangle.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct SheetStress<R> {
    /// elastic
    pub elastic: [R; 3],
    /// that of damping alone
    pub damping: [R; 3],
}

/// A pass over groups of triangles. Returns their elastic energy [J] and the power [W] of their damping.
pub(in crate::force) struct SheetPass<'a, L> {
    pub law: &'a L,
    /// x_1^2 and x_2^2
    pub scale: [f64; 2],
    pub groups: &'a [Group],
    pub shapes: &'a [GroupShapes],
    /// [m] positions
    pub x: &'a Records,
    /// [m/s] velocities
    pub v: &'a Records,
    /// [N] sums of elastic and of damping forces, each where the law has such forces
    pub sums: [Option<&'a mut Records>; 2],
}

/// The columns of F, or of its rate.
type Columns<Q> = [[Q; 3]; 2];

impl<L: SheetLaw> Pass for SheetPass<'_, L> {
    type Output = [f64; 2];

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> [f64; 2] {
        let SheetPass { law, scale, groups, shapes, x, v, sums: [mut elastic, mut damping] } = self;
        let (zero, half) = (unit.splat(0.0), unit.splat(0.5));
        let mut totals = [zero; 2];
        for (nodes, shape) in groups.iter().zip(shapes) {
            let r = [unit.quad(shape[0]), unit.quad(shape[1]), unit.quad(shape[2]), unit.quad(shape[3])];
            let area = unit.quad(shape[4]);
            let f = columns(unit, nodes, x, r);
            let square = dot(f[0], f[0]);
            let strain = [
                half * (square - unit.splat(scale[0])),
                half * (dot(f[1], f[1]) - unit.splat(scale[1])),
                dot(f[0], f[1]),
            ];
            let mut rate = [zero; 3];
            if L::DAMPED {
                let g = columns(unit, nodes, v, r);
                rate = [dot(f[0], g[0]), dot(f[1], g[1]), dot(f[0], g[1]) + dot(g[0], f[1])];
            }
            let stress = law.stress(strain, rate);
            if L::ELASTIC
                && let Some(sum) = elastic.as_deref_mut()
            {
                totals[0] = totals[0] + half * area * dot(stress.elastic, strain);
                add(unit, nodes, forces(f, r, scaled(area, stress.elastic)), sum);
            }
            if L::DAMPED
                && let Some(sum) = damping.as_deref_mut()
            {
                totals[1] = totals[1] - area * dot(stress.damping, rate);
                add(unit, nodes, forces(f, r, scaled(area, stress.damping)), sum);
            }
        }
        let total = |quad: U::Quad| {
            let [a, b, c, d] = quad.numbers();
            (a + b) + (c + d)
        };
        [total(totals[0]), total(totals[1])]
    }
}

/// [x1 - x0, x2 - x0] R, or the same of velocities.
#[inline(always)]
fn columns<U: VectorUnit>(unit: U, nodes: &Group, x: &Records, r: [U::Quad; 4]) -> Columns<U::Quad> {
    let mut sides = [[unit.splat(0.0); SIDE_BY_SIDE]; 2];
    for (q, &[a, b, c]) in nodes.iter().enumerate() {
        let from = unit.quad(record(x, a));
        sides[0][q] = unit.quad(record(x, b)) - from;
        sides[1][q] = unit.quad(record(x, c)) - from;
    }
    let [p, q] = [U::Quad::columns(sides[0]), U::Quad::columns(sides[1])];
    [sum(r[0], p, r[2], q), sum(r[1], p, r[3], q)]
}

/// -F S R^T for S times A0: the forces on the second and the third node.
#[inline(always)]
fn forces<R: Real>(f: Columns<R>, r: [R; 4], s: [R; 3]) -> Columns<R> {
    let p = [sum(s[0], f[0], s[2], f[1]), sum(s[2], f[0], s[1], f[1])];
    [sum(r[0], p[0], r[1], p[1]), sum(r[2], p[0], r[3], p[1])]
}

/// Subtracts forces from the second and the third nodes, and adds their sum to the first ones.
#[inline(always)]
fn add<U: VectorUnit>(unit: U, nodes: &Group, forces: Columns<U::Quad>, sums: &mut Records) {
    let [second, third] = [U::Quad::rows(forces[0]), U::Quad::rows(forces[1])];
    for (q, &[a, b, c]) in nodes.iter().enumerate() {
        set_record(sums, a, (unit.quad(record(sums, a)) + (second[q] + third[q])).numbers());
        set_record(sums, b, (unit.quad(record(sums, b)) - second[q]).numbers());
        set_record(sums, c, (unit.quad(record(sums, c)) - third[q]).numbers());
    }
}

// No `map` in these: its closure would be compiled for any machine, and every operation in it called.

#[inline(always)]
fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
fn scaled<R: Real>(by: R, [x, y, z]: [R; 3]) -> [R; 3] {
    [by * x, by * y, by * z]
}

/// k a + l b
#[inline(always)]
fn sum<R: Real>(k: R, a: [R; 3], l: R, b: [R; 3]) -> [R; 3] {
    [k * a[0] + l * b[0], k * a[1] + l * b[1], k * a[2] + l * b[2]]
}
