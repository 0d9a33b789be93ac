//! Springs with a slack law in Kang's filter, which does not contain them while they are slack.
//!
//! A spring is in the filter of a step of h if it is taut at the step's start, or taut at x + h v, where the nodes
//! would be with their present velocities. A spring that is slack at the start but not at x + h v gets the tension of
//! its taut branch, as if it were taut already, with the elongation e at x. Together with the filter's h k (v_j - v_i)
//! this is the tension at the end of the step. A mass that flies into its rope is then caught as by backward Euler, and
//! the step makes no energy, at any h^2 k/m. Without the second rule the step would pass the threshold without
//! braking and make 1/2 k (h v)^2.

use crate::force::NodeState;
use crate::force::kernel::neighbours::Links;
use crate::force::kernel::neighbours::{Neighbours, WeightSlot};
use crate::force::law::curve::Bar;
use crate::force::law::slack::{Clamp, TensionLaw, with_law};
use crate::force::law::spring::SpringData;
use nalgebra::Vector3;
use std::ops::Range;

/// [-] Relative rounding error of a squared length.
const TAUT: f64 = 8.0 * f64::EPSILON;

/// [N] What a slack spring's tension lacks of its taut branch.
fn untaut(data: &SpringData, bar: Bar, e: f64) -> f64 {
    with_law!(&data.curve, data.slack, law => match law.bounds(bar, e) {
        None => 0.0,
        Some((taut, _)) => taut.force - law.at(bar, e).force,
    })
}

/// All springs of a scene, some of which leave the filter while they are slack.
#[derive(Debug)]
pub struct OneSided {
    /// the springs that may leave the filter, with their laws
    batches: Vec<(SpringData, Clamp)>,
    /// slots of their weights, batch by batch
    slots: Vec<[WeightSlot; 2]>,
    /// whether they are in the filter
    inside: Vec<bool>,
    /// all springs with their stiffness, or 0 where a spring is not in the filter
    neighbours: Neighbours,
    /// [N] difference of their forces from those of the force pass
    correction: Vec<Vector3<f64>>,
    /// the nodes that have a correction
    corrected: Vec<u32>,
}

/// Springs of one law, and whether they may leave the filter.
pub type Member<'a> = (&'a SpringData, bool);

impl OneSided {
    /// For `n` nodes; `None` if no spring can leave the filter.
    pub fn new<'a>(n: usize, members: impl Iterator<Item = Member<'a>> + Clone) -> Option<Self> {
        let law = |(data, may): Member<'a>| Clamp::of(data.slack).filter(|_| may);
        if !members.clone().any(|member| law(member).is_some()) {
            return None;
        }
        fn links(data: &SpringData) -> Links<'_> {
            Links { nodes: &data.nodes, weights: &data.stiffness }
        }
        let (neighbours, mut all) = Neighbours::with_slots(n, members.clone().map(|(data, _)| links(data)));
        let (mut batches, mut slots) = (Vec::new(), Vec::new());
        for member @ (data, _) in members {
            let rest = all.split_off(data.nodes.len());
            if let Some(law) = law(member) {
                batches.push((data.clone(), law));
                slots.append(&mut all);
            }
            all = rest;
        }
        let inside = vec![true; slots.len()];
        let corrected = Vec::with_capacity(2 * slots.len());
        Some(OneSided { batches, slots, inside, neighbours, correction: vec![Vector3::zeros(); n], corrected })
    }

    /// Finds the springs that are in the filter of a step of `h` [s] from a state, and the difference of their forces
    /// from those of a force pass there. Returns whether the springs in the filter have changed.
    pub fn select(&mut self, NodeState { t, x, v }: NodeState<'_>, h: f64) -> bool {
        let Self { batches, slots, inside, neighbours, correction, corrected } = self;
        corrected.drain(..).for_each(|node| correction[node as usize] = Vector3::zeros());
        let mut changed = false;
        let mut springs = slots.iter().zip(inside);
        for (data, law) in batches {
            let at = data.at(t, x);
            for ((i, &[a, b]), (slots, inside)) in data.nodes.iter().enumerate().zip(springs.by_ref()) {
                let along = |of: &[Vector3<f64>]| of[b as usize] - of[a as usize];
                let (d, limit) = (along(x), data.rest_length_at(at, i) + law.threshold());
                let square = limit.max(0.0).powi(2);
                // A spring that is taut by rounding only carries no force.
                let margin = square * TAUT;
                let beyond =
                    |now: f64, margin: f64| if law.pushes() { now < square - margin } else { now > square + margin };
                let taut = beyond(d.norm_squared(), margin);
                let caught = !taut && beyond((d + h * along(v)).norm_squared(), 0.0);
                if (taut || caught) != *inside {
                    *inside = taut || caught;
                    changed = true;
                    let k = if *inside { data.stiffness.at(i) } else { 0.0 };
                    slots.iter().for_each(|slot| neighbours.set(*slot, k));
                }
                if caught {
                    let stretch = data.stretch(at, i);
                    let axial_force = stretch.n * untaut(data, data.bar(at, i), stretch.elongation);
                    correction[a as usize] += axial_force;
                    correction[b as usize] -= axial_force;
                    corrected.extend([a, b]);
                }
            }
        }
        changed
    }

    /// [N/m] `sum_j k_ij` over the springs in the filter, for every node `[n_nodes]`.
    pub fn stiffness_sums(&self, out: &mut [f64]) {
        out.iter_mut().zip(self.neighbours.weights()).for_each(|(out, sum)| *out = sum);
    }

    /// `sum_j k_ij u_j`, as [`Neighbours::sums`].
    pub fn sums(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]) {
        self.neighbours.sums(u, dofs, out);
    }

    /// `sum_j k_ij (u_j - u_i)`, as [`Neighbours::differences`].
    pub fn differences(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]) {
        self.neighbours.differences(u, dofs, out);
    }

    /// [N] Correction of the forces of a pass; `None` if there is none.
    pub fn correction(&self) -> Option<&[f64]> {
        (!self.corrected.is_empty()).then(|| bytemuck::cast_slice(&self.correction))
    }
}
