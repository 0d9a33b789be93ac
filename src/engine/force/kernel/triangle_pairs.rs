//! Triangles that are pushed along their normal, in pairs: two that share a side, four such pairs side by side.
//!
//! ```text
//! S = 1/2 (x1 - x0) x (x2 - x0) = A N,      a vertex gets p S
//! ```
//! In a net nearly every triangle has another for itself. A pair has four nodes to be read and added to, where two
//! triangles have six. A triangle that is left over is a pair with one of no area.
//!
//! Measuring, the law, and adding follow each other one group apart, as in [`crate::force::kernel::star_batches`].

use crate::force::kernel::incidence::Incidence;
use crate::force::kernel::local_buffer::{PaddedVec3, Records, record, set_record};
use crate::model::quad::{Pass, Quad, Real, VectorUnit};

/// How triangles are pushed: a pure function, for one triangle or four side by side.
pub(in crate::force) trait PressureLaw {
    /// Whether a triangle's pressure is also multiplied by a factor of its own.
    const FACTORS: bool = false;

    /// Triangles by the components of S [m^2] and of the sums [m/s] of their vertices' velocities; `#[inline(always)]`.
    fn pressure_force<R: Real>(&self, s: [R; 3], v: [R; 3]) -> PressureForce<R>;
}

/// What happens to a triangle.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct PressureForce<R> {
    /// [Pa] a vertex's share of the pressure
    pub share: R,
    /// [W] power
    pub amount: R,
}

/// Pairs side by side.
const PAIRS: usize = 4;

/// Four pairs by their nodes a, b, c, d: the triangles (a, b, c) and (a, c, d).
pub(in crate::force) type Group = [[u16; 4]; PAIRS];

/// [-] Factors of the pressures on the first and on the second triangles of the pairs of a group.
pub(in crate::force) type GroupFactors = [PaddedVec3; 2];

/// Numbers of the two triangles of the pairs of a group; `None` for one of no area.
pub(in crate::force) type GroupNumbers = [[Option<u32>; 2]; PAIRS];

/// A block's triangles in groups of pairs, and their numbers. Triangle after triangle takes the first that is left and
/// has one of its sides the other way round.
pub(in crate::force) fn arrange(triangles: &[[u16; 3]]) -> (Vec<Group>, Vec<GroupNumbers>) {
    let around = Incidence::new(triangles);
    let (mut pairs, mut numbers, mut taken) = (Vec::new(), Vec::new(), vec![false; triangles.len()]);
    for (number, &[i, j, k]) in triangles.iter().enumerate() {
        if taken[number] {
            continue;
        }
        let found = [[i, j, k], [j, k, i], [k, i, j]].into_iter().find_map(|[a, b, c]| {
            let (other, d) =
                across(triangles, &around, [a, c]).find(|(other, _)| *other != number && !taken[*other])?;
            Some((other, [a, b, c, d]))
        });
        taken[number] = true;
        if let Some((other, _)) = found {
            taken[other] = true;
        }
        numbers.push([Some(number as u32), found.map(|(other, _)| other as u32)]);
        pairs.push(found.map_or([i, j, k, k], |(_, pair)| pair));
    }
    if let Some(&[a, ..]) = pairs.last() {
        pairs.resize(pairs.len().next_multiple_of(PAIRS), [a; 4]);
        numbers.resize(pairs.len(), [None; 2]);
    }
    (pairs.as_chunks().0.to_vec(), numbers.as_chunks().0.to_vec())
}

/// Those of `triangles` with the side from `a` to `c`, and their third node.
fn across<'a>(
    triangles: &'a [[u16; 3]],
    around: &'a Incidence,
    [a, c]: [u16; 2],
) -> impl Iterator<Item = (usize, u16)> {
    around.at(a).iter().filter_map(move |&number| {
        let [i, j, k] = triangles[number];
        let turned = [[i, j, k], [j, k, i], [k, i, j]];
        turned.into_iter().find_map(|[from, to, d]| ([from, to] == [a, c]).then_some((number, d)))
    })
}

/// A pass over groups of pairs; `x` and `v` are the positions [m] and velocities [m/s] of the nodes. Adds forces [N] to
/// `f` and returns their power [W].
pub(in crate::force) struct PressurePass<'a, L> {
    pub law: &'a L,
    pub groups: &'a [Group],
    /// of every group, if the law has factors
    pub factors: &'a [GroupFactors],
    pub x: &'a Records,
    pub v: &'a Records,
    pub f: &'a mut Records,
}

/// What is kept of a group from one stage to the next, of first and of second triangles, component by component.
#[derive(Clone, Copy, Default)]
#[repr(align(32))]
struct GroupBuffer {
    /// S, then a vertex's force
    s: [[PaddedVec3; 3]; 2],
    /// sums of the vertices' velocities
    v: [[PaddedVec3; 3]; 2],
}

impl<L: PressureLaw> Pass for PressurePass<'_, L> {
    type Output = f64;

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> f64 {
        let PressurePass { law, groups, factors, x, v, f } = self;
        // One more than there are stages: a power of two is cheaper to count through.
        let mut kept = [GroupBuffer::default(); 4];
        let mut sums = [unit.splat(0.0); 2];
        for i in 0..groups.len() + 2 {
            if let Some(nodes) = groups.get(i) {
                measure(unit, nodes, [x, v], &mut kept[i % 4]);
            }
            if (1..=groups.len()).contains(&i) {
                let GroupBuffer { s, v } = &mut kept[(i - 1) % 4];
                for (half, ((s, v), sum)) in s.iter_mut().zip(v).zip(&mut sums).enumerate() {
                    let [area, v] = [quads(unit, s), quads(unit, v)];
                    let PressureForce { mut share, mut amount } = law.pressure_force(area, v);
                    if L::FACTORS {
                        let factor = unit.quad(factors[i - 1][half]);
                        (share, amount) = (factor * share, factor * amount);
                    }
                    *s = numbers(scaled(share, area));
                    *sum = *sum + amount;
                }
            }
            if let Some(nodes) = groups.get(i.wrapping_sub(2)) {
                add(unit, nodes, &kept[(i - 2) % 4].s, f);
            }
        }
        let [a, b, c, d] = (sums[0] + sums[1]).numbers();
        (a + b) + (c + d)
    }
}

#[inline(always)]
fn measure<U: VectorUnit>(unit: U, nodes: &Group, [x, v]: [&Records; 2], kept: &mut GroupBuffer) {
    let mut sides = [[unit.splat(0.0); PAIRS]; 3];
    let mut speeds = [[unit.splat(0.0); PAIRS]; 2];
    for (q, &[a, b, c, d]) in nodes.iter().enumerate() {
        let from = unit.quad(record(x, a));
        sides[0][q] = unit.quad(record(x, b)) - from;
        sides[1][q] = unit.quad(record(x, c)) - from;
        sides[2][q] = unit.quad(record(x, d)) - from;
        let both = unit.quad(record(v, a)) + unit.quad(record(v, c));
        speeds[0][q] = both + unit.quad(record(v, b));
        speeds[1][q] = both + unit.quad(record(v, d));
    }
    let [b, c, d] = [U::Quad::columns(sides[0]), U::Quad::columns(sides[1]), U::Quad::columns(sides[2])];
    kept.s = [numbers(area(unit, b, c)), numbers(area(unit, c, d))];
    kept.v = [numbers(U::Quad::columns(speeds[0])), numbers(U::Quad::columns(speeds[1]))];
}

/// S = 1/2 a x b, of four triangles by two sides.
#[inline(always)]
fn area<U: VectorUnit>(unit: U, a: [U::Quad; 3], b: [U::Quad; 3]) -> [U::Quad; 3] {
    let half = unit.splat(0.5);
    [half * (a[1] * b[2] - a[2] * b[1]), half * (a[2] * b[0] - a[0] * b[2]), half * (a[0] * b[1] - a[1] * b[0])]
}

#[inline(always)]
fn add<U: VectorUnit>(unit: U, nodes: &Group, [one, two]: &[[PaddedVec3; 3]; 2], f: &mut Records) {
    let [one, two] = [U::Quad::rows(quads(unit, one)), U::Quad::rows(quads(unit, two))];
    for (q, &[a, b, c, d]) in nodes.iter().enumerate() {
        let both = one[q] + two[q];
        for (node, force) in [(a, both), (b, one[q]), (c, both), (d, two[q])] {
            set_record(f, node, (unit.quad(record(f, node)) + force).numbers());
        }
    }
}

// No `map` in these: its closure would be compiled for any machine, and every operation in it called.

#[inline(always)]
fn quads<U: VectorUnit>(unit: U, [x, y, z]: &[PaddedVec3; 3]) -> [U::Quad; 3] {
    [unit.quad(*x), unit.quad(*y), unit.quad(*z)]
}

#[inline(always)]
fn numbers<Q: Quad>([x, y, z]: [Q; 3]) -> [PaddedVec3; 3] {
    [x.numbers(), y.numbers(), z.numbers()]
}

#[inline(always)]
fn scaled<Q: Quad>(by: Q, [x, y, z]: [Q; 3]) -> [Q; 3] {
    [by * x, by * y, by * z]
}

#[cfg(test)]
mod tests;
