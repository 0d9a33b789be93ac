//! What happens to the nodes of a strip where one step of several ends and the next begins.
//!
//! Work is summed in halves: what the forces at the step's end do on its way, when it ends; what they do on the way of
//! the next, when that begins.

use super::around::Moving;
use super::room::Part;
use super::sweep::by_node;
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::stride::{Kicks, NodeSums, Nodes, Work};
use crate::model::system::Onward;
use bytemuck::{cast_slice, cast_slice_mut};
use glam::DVec3;

/// What is to be done where one step of several ends.
#[derive(Clone, Copy)]
pub struct Between<'a> {
    /// the scheme, which moves nodes to where the first step finds them
    pub scheme: &'a dyn Onward,
    /// [kg] one a node
    pub mass: &'a [f64],
    /// [1/kg] by degree of freedom, 0 at fixed ones
    pub inverse_mass: &'a [f64],
}

impl Between<'_> {
    /// Ends a step in a strip, and begins the next.
    pub(super) fn end(&self, kicks: Kicks, level: usize, part: Part<'_>, Moving { first, x, v, .. }: Moving<'_>) {
        let Part { out: [total, out @ ..], nodes: sums, aside: [before, kicked], levels, .. } = part;
        let (dofs, passes) = (3 * first..3 * first + x.len(), kicks.passes());
        let another = level + 1 < levels;
        let forces = out.each_ref().map(|sum| cast_slice::<DVec3, f64>(sum));
        let works = forces.iter().any(|sum| !sum.is_empty());
        let mut work = Work::default();
        if works {
            let (begun, from) = if level + 1 > passes {
                (sums[level + 1 - passes].work, cast_slice(before))
            } else {
                let Point { state, forces: Forces { external, dissipative, .. } } = self.scheme.from();
                let from = &state.x[dofs.clone()];
                let forces = [external, dissipative].map(|sum| sum.get(dofs.clone()).unwrap_or_default());
                (Work::of::<3>(forces, from, x), from)
            };
            work = begun.and(Work::of::<3>(forces, from, x)).halved();
            if another {
                before.copy_from_slice(by_node(x));
            }
        }
        let nodes = Nodes::<3> {
            mass: &self.mass[dofs.start / 3..dofs.end / 3],
            inverse_mass: &self.inverse_mass[dofs],
            x: &mut *x,
            v,
            kicked: cast_slice_mut(kicked),
            f: cast_slice_mut(total),
        };
        sums[level] = NodeSums { work, ..kicks.end(nodes, another) };
        if works && another {
            // The first half of the next step's, kept where that step's first pass is; its second half makes it whole.
            sums[level + 1].work = Work::of::<3>(forces, cast_slice(before), x);
        }
    }
}
