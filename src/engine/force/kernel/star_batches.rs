//! Two-node elements in stars: a node with some of its elements, four such nodes side by side.
//!
//! ```text
//! d = x_b - x_a,  u = v_b - v_a         elastic force on a: s d, damping force on a: s' d, on b the opposite
//! ```
//! In a net of triangles nearly every node can have three elements that are no other node's (a planar graph has at most
//! 3 n - 6 edges). What a star's elements add to its own node is summed in a register; added in memory, and one after
//! the other, are three other ends and one sum in place of six ends. Elements that fill no star of three are stars of
//! one.
//!
//! Measuring, the law, and adding follow each other one group apart, so that none of them waits for another's roots or
//! stores.

use crate::force::kernel::coefficient::{Column, STAR, STARS};
use crate::force::kernel::incidence::Incidence;
use crate::force::kernel::local_buffer::{PaddedVec3, Records, record, set_record};
use crate::model::quad::{Pass, Quad, Real, VectorUnit};

/// `N` elements of each of four stars, with the star's node first: element `j` of star `q` at `[j][q]`.
pub(in crate::force) type Group<const N: usize> = [[[u16; 2]; STARS]; N];

/// How two-node elements pull: a pure function, for one element or four side by side.
pub(in crate::force) trait AxialLaw {
    /// whether there is an elastic force
    const ELASTIC: bool;
    /// whether there is a damping force
    const DAMPED: bool;
    /// whether there is a power to sum up
    const POWER: bool = Self::DAMPED;

    /// Elements by their three numbers; `#[inline(always)]`.
    fn axial_force<R: Real>(&self, numbers: [R; 3], measured: Measured<R>) -> AxialForce<R>;
}

/// What a law sees of an element.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct Measured<R> {
    /// [m^2] d^2
    pub square: R,
    /// [m^2/s] d . u; 0 where there is no damping force
    pub rate: R,
}

/// What an element does.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct AxialForce<R> {
    /// [N/m] s
    pub elastic: R,
    /// [J] elastic energy
    pub energy: R,
    /// [N/m] s'
    pub damping: R,
    /// [W] power of s' d, or what the law sums up in its place
    pub power: R,
}

/// An element at its place in a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::force) struct PlacedElement {
    /// its number among the block's
    pub element: usize,
    /// whether its second node is the star's
    pub turned: bool,
}

/// The order of a block's elements, by their ends: groups of stars of three first, of which there are so many, then all
/// others as they were. Node after node takes what elements are left, three by three.
pub(in crate::force) fn arrange(ends: &[[u16; 2]]) -> (Vec<PlacedElement>, usize) {
    let around = Incidence::new(ends);
    let (mut stars, mut taken): (Vec<[PlacedElement; STAR]>, _) = (Vec::new(), vec![false; ends.len()]);
    let mut free = Vec::new();
    for place in around.places() {
        let placed =
            around.at(place).iter().map(|&element| PlacedElement { element, turned: ends[element][0] != place });
        free.clear();
        free.extend(placed.filter(|placed| !taken[placed.element]));
        // One between a node and itself is there twice.
        free.dedup_by_key(|placed: &mut PlacedElement| placed.element);
        for star in free.as_chunks().0 {
            star.iter().for_each(|placed| taken[placed.element] = true);
            stars.push(*star);
        }
    }
    let (groups, left) = stars.as_chunks::<STARS>();
    left.as_flattened().iter().for_each(|placed| taken[placed.element] = false);
    let in_groups = groups.iter().flat_map(|group| (0..STAR).flat_map(|j| group.each_ref().map(|star| star[j])));
    let others =
        (0..ends.len()).filter(|&element| !taken[element]).map(|element| PlacedElement { element, turned: false });
    (in_groups.chain(others).collect(), groups.len())
}

/// A pass over groups of stars of `N` elements. Returns their elastic energy [J] and the power [W] of their damping.
pub(in crate::force) struct Stars<'a, L, const N: usize> {
    pub law: &'a L,
    pub groups: &'a [Group<N>],
    /// three numbers of every element
    pub numbers: [Column<'a>; 3],
    /// [m] positions
    pub x: &'a Records,
    /// [m/s] velocities
    pub v: &'a Records,
    /// [N] sums of elastic and of damping forces, each where the law has such forces
    pub sums: [Option<&'a mut Records>; 2],
}

/// What is kept of a group from one stage to the next.
#[derive(Clone, Copy)]
#[repr(align(32))]
struct GroupBuffer<const N: usize> {
    d: [[PaddedVec3; STARS]; N],
    /// d^2, then s
    elastic: [PaddedVec3; N],
    /// d . u, then s'
    damping: [PaddedVec3; N],
}

impl<const N: usize> GroupBuffer<N> {
    const EMPTY: Self = GroupBuffer { d: [[[0.0; 4]; STARS]; N], elastic: [[0.0; 4]; N], damping: [[0.0; 4]; N] };
}

impl<L: AxialLaw, const N: usize> Pass for Stars<'_, L, N> {
    type Output = [f64; 2];

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> [f64; 2] {
        let Stars { law, groups, numbers, x, v, sums: [mut elastic, mut damping] } = self;
        // One more than there are stages: a power of two is cheaper to count through.
        let mut kept = [GroupBuffer::<N>::EMPTY; 4];
        let (mut energy, mut power) = ([unit.splat(0.0); N], [unit.splat(0.0); N]);
        for i in 0..groups.len() + 2 {
            if let Some(nodes) = groups.get(i) {
                measure::<U, L, N>(unit, nodes, [x, v], &mut kept[i % 4]);
            }
            if (1..=groups.len()).contains(&i) {
                let kept = &mut kept[(i - 1) % 4];
                let [a, b] = [numbers[0].group::<N>(i - 1), numbers[1].group::<N>(i - 1)];
                for j in 0..N {
                    let mut damping = [unit.splat(0.0); 2];
                    if L::DAMPED {
                        let c = numbers[2].group::<N>(i - 1);
                        damping = [unit.quad(c[j]), unit.quad(kept.damping[j])];
                    }
                    let numbers = [unit.quad(a[j]), unit.quad(b[j]), damping[0]];
                    let measured = Measured { square: unit.quad(kept.elastic[j]), rate: damping[1] };
                    let axial_force = law.axial_force(numbers, measured);
                    kept.elastic[j] = axial_force.elastic.numbers();
                    energy[j] = energy[j] + axial_force.energy;
                    if L::DAMPED {
                        kept.damping[j] = axial_force.damping.numbers();
                    }
                    if L::POWER {
                        power[j] = power[j] + axial_force.power;
                    }
                }
            }
            if let Some(nodes) = groups.get(i.wrapping_sub(2)) {
                let kept = &kept[(i - 2) % 4];
                if L::ELASTIC
                    && let Some(f) = elastic.as_deref_mut()
                {
                    add::<U, N>(unit, nodes, (&kept.elastic, &kept.d), f);
                }
                if L::DAMPED
                    && let Some(f) = damping.as_deref_mut()
                {
                    add::<U, N>(unit, nodes, (&kept.damping, &kept.d), f);
                }
            }
        }
        let total = |sums: [U::Quad; N]| {
            let mut sum = sums[0];
            for other in &sums[1..] {
                sum = sum + *other;
            }
            let [a, b, c, d] = sum.numbers();
            (a + b) + (c + d)
        };
        [total(energy), total(power)]
    }
}

#[inline(always)]
fn measure<U: VectorUnit, L: AxialLaw, const N: usize>(
    unit: U,
    nodes: &Group<N>,
    [x, v]: [&Records; 2],
    kept: &mut GroupBuffer<N>,
) {
    let mut own = [[unit.splat(0.0); STARS]; 2];
    for (q, nodes) in nodes[0].iter().enumerate() {
        own[0][q] = unit.quad(record(x, nodes[0]));
        if L::DAMPED {
            own[1][q] = unit.quad(record(v, nodes[0]));
        }
    }
    for (j, nodes) in nodes.iter().enumerate() {
        let [mut d, mut u] = own;
        for (q, nodes) in nodes.iter().enumerate() {
            d[q] = unit.quad(record(x, nodes[1])) - d[q];
            kept.d[j][q] = d[q].numbers();
            if L::DAMPED {
                u[q] = unit.quad(record(v, nodes[1])) - u[q];
            }
        }
        let [x, y, z] = U::Quad::columns(d);
        kept.elastic[j] = (x * x + y * y + z * z).numbers();
        if L::DAMPED {
            let u = U::Quad::columns(u);
            kept.damping[j] = (x * u[0] + y * u[1] + z * u[2]).numbers();
        }
    }
}

/// Adds the forces scale * vector of a group.
#[inline(always)]
fn add<U: VectorUnit, const N: usize>(
    unit: U,
    nodes: &Group<N>,
    (scale, vectors): (&[PaddedVec3; N], &[[PaddedVec3; STARS]; N]),
    f: &mut Records,
) {
    for q in 0..STARS {
        let mut own = unit.splat(0.0);
        for j in 0..N {
            let force = unit.splat(scale[j][q]) * unit.quad(vectors[j][q]);
            own = if j == 0 { force } else { own + force };
            let other = nodes[j][q][1];
            set_record(f, other, (unit.quad(record(f, other)) - force).numbers());
        }
        set_record(f, nodes[0][q][0], (unit.quad(record(f, nodes[0][q][0])) + own).numbers());
    }
}

#[cfg(test)]
mod tests;
