//! Two-node elements in stars: a node with three of its elements, four such nodes side by side.
//!
//! In a net of triangles nearly every node can have three elements that are no other node's (a planar graph has at most
//! 3 n - 6 edges). What a star's elements add to its own node is summed in a register; added in memory, and one after
//! the other, are three other ends and one sum in place of six ends. Elements that fill no star are left to
//! [`crate::force::kernel::axial_kernel`].
//!
//! Measuring, the law, and adding follow each other one group apart, so that none of them waits for another's roots or
//! stores.

use crate::force::kernel::axial_kernel::{AxialLaw, Pull};
use crate::force::kernel::coefficient::Column;
use crate::force::kernel::incidence::Incidence;
use crate::force::kernel::local_buffer::{PaddedVec3, Records, record, set_record};
use crate::model::quad::{self, Pass, Quad, VectorUnit};

/// Elements of a star, and stars side by side.
pub(in crate::force) const STAR: usize = 3;
pub(in crate::force) const STARS: usize = 4;

/// Elements of four stars, each with its star's node first: the three of star `q` at `q`, 4 + `q` and 8 + `q`.
pub(in crate::force) type Group = [[u16; 2]; GROUP];
pub(in crate::force) const GROUP: usize = STAR * STARS;

/// An element at its place in a block.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(in crate::force) struct Placed {
    /// its number among the block's
    pub element: usize,
    /// whether its second node is the star's
    pub turned: bool,
}

/// The order of a block's elements, by their ends: groups of stars first, of which there are so many, then all others
/// as they were. Node after node takes what elements are left, three by three.
pub(in crate::force) fn arrange(ends: &[[u16; 2]]) -> (Vec<Placed>, usize) {
    let around = Incidence::new(ends);
    let (mut stars, mut taken): (Vec<[Placed; STAR]>, _) = (Vec::new(), vec![false; ends.len()]);
    let mut free = Vec::new();
    for place in around.places() {
        let placed = around.at(place).iter().map(|&element| Placed { element, turned: ends[element][0] != place });
        free.clear();
        free.extend(placed.filter(|placed| !taken[placed.element]));
        // One between a node and itself is there twice.
        free.dedup_by_key(|placed: &mut Placed| placed.element);
        for fan in free.as_chunks().0 {
            fan.iter().for_each(|placed| taken[placed.element] = true);
            stars.push(*fan);
        }
    }
    let (groups, left) = stars.as_chunks::<STARS>();
    left.as_flattened().iter().for_each(|placed| taken[placed.element] = false);
    let in_groups = groups.iter().flat_map(|group| (0..STAR).flat_map(|j| group.each_ref().map(|fan| fan[j])));
    let others = (0..ends.len()).filter(|&element| !taken[element]).map(|element| Placed { element, turned: false });
    (in_groups.chain(others).collect(), groups.len())
}

/// Adds the forces [N] of stars to a local buffer, and returns their energy or power; `u` is the nodal vector of the
/// differences.
pub(in crate::force) fn add_stars<L: AxialLaw>(law: &L, stars: StarBatches<'_>, u: &Records, f: &mut Records) -> f64 {
    quad::run(Pulling { law, stars, u, f })
}

/// Groups of stars, with two numbers of every element.
pub(in crate::force) type StarBatches<'a> = (&'a [Group], [Column<'a>; 2]);

struct Pulling<'a, L> {
    law: &'a L,
    stars: StarBatches<'a>,
    u: &'a Records,
    f: &'a mut Records,
}

/// What is kept of a group from one stage to the next.
#[derive(Clone, Copy, Default)]
#[repr(align(32))]
struct Kept {
    d: [PaddedVec3; GROUP],
    /// squared differences, then forces by difference
    scale: [PaddedVec3; STAR],
}

impl<L: AxialLaw> Pass for Pulling<'_, L> {
    type Output = f64;

    #[inline(always)]
    fn run<U: VectorUnit>(self, unit: U) -> f64 {
        let Pulling { law, stars: (groups, numbers), u, f } = self;
        // One more than there are stages: a power of two is cheaper to count through.
        let mut kept = [Kept::default(); 4];
        let mut sums = [unit.splat(0.0); STAR];
        for i in 0..groups.len() + 2 {
            if let Some(nodes) = groups.get(i) {
                measure(unit, nodes, u, &mut kept[i % 4]);
            }
            if (1..=groups.len()).contains(&i) {
                let kept = &mut kept[(i - 1) % 4];
                let numbers = [numbers[0].stars(i - 1), numbers[1].stars(i - 1)];
                for (j, sum) in sums.iter_mut().enumerate() {
                    let numbers = [unit.quad(numbers[0][j]), unit.quad(numbers[1][j])];
                    let Pull { scale, amount } = law.pull(unit, numbers, unit.quad(kept.scale[j]));
                    kept.scale[j] = scale.numbers();
                    *sum = *sum + amount;
                }
            }
            if let Some(nodes) = groups.get(i.wrapping_sub(2)) {
                add(unit, nodes, &kept[(i - 2) % 4], f);
            }
        }
        let [a, b, c, d] = (sums[0] + sums[1] + sums[2]).numbers();
        (a + b) + (c + d)
    }
}

#[inline(always)]
fn measure<U: VectorUnit>(unit: U, nodes: &Group, u: &Records, kept: &mut Kept) {
    let mut own = [unit.splat(0.0); STARS];
    for (own, nodes) in own.iter_mut().zip(nodes) {
        *own = unit.quad(record(u, nodes[0]));
    }
    for j in 0..STAR {
        let mut d = own;
        for (q, d) in d.iter_mut().enumerate() {
            let at = STARS * j + q;
            *d = unit.quad(record(u, nodes[at][1])) - *d;
            kept.d[at] = d.numbers();
        }
        let [x, y, z] = U::Quad::columns(d);
        kept.scale[j] = (x * x + y * y + z * z).numbers();
    }
}

#[inline(always)]
fn add<U: VectorUnit>(unit: U, nodes: &Group, kept: &Kept, f: &mut Records) {
    for q in 0..STARS {
        let mut own = unit.splat(0.0);
        for j in 0..STAR {
            let at = STARS * j + q;
            let force = unit.splat(kept.scale[j][q]) * unit.quad(kept.d[at]);
            own = if j == 0 { force } else { own + force };
            let other = nodes[at][1];
            set_record(f, other, (unit.quad(record(f, other)) - force).numbers());
        }
        set_record(f, nodes[q][0], (unit.quad(record(f, nodes[q][0])) + own).numbers());
    }
}

#[cfg(test)]
mod tests;
