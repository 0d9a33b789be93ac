//! A network for output, in the user's numbering.

use super::build_surface::MembraneBatch;
use super::network::{Network, by_node, node_state};
use crate::force::law::damped_springs::axial_force;
use crate::force::law::membrane::MembraneState;
use crate::force::law::tension::SpringOutput;
use crate::mesh::Groups;
use crate::model::abilities::{Air, SpringDamping, SpringPlace, Springs};
use crate::model::forces::{Forces, Role};
use crate::model::gauge::{CANOPY_QUANTITIES, GAS_QUANTITIES, NodeQuantity};
use crate::model::motion::motion;
use crate::model::observables::{MembranePicture, Observables};
use crate::model::point::Point;
use crate::model::state::StateRef;
use crate::model::step_block::strain_of;
use crate::model::system::System;

impl Observables for Network {
    fn reference(&self) -> &[[f64; 3]] {
        &self.mesh.nodes
    }

    fn triangles(&self) -> &[[u32; 3]] {
        &self.mesh.triangles
    }

    fn edges(&self) -> &[[u32; 2]] {
        &self.mesh.edges
    }

    fn groups(&self) -> &Groups {
        &self.mesh.groups
    }

    fn springs(&self) -> Option<&dyn Springs> {
        (!self.acting.springs.is_empty()).then_some(self)
    }

    fn air(&self) -> Option<&dyn Air> {
        (self.acting.stream.is_some() || !self.acting.gases.is_empty()).then_some(self)
    }

    fn triangle_membranes(&self, at: StateRef<'_>, out: &mut [MembranePicture]) {
        out.fill(MembranePicture::default());
        for MembraneBatch { data, triangles, thickness } in &self.built.membranes {
            for (i, &triangle) in triangles.iter().enumerate() {
                let MembraneState { tension, strain, wrinkling, warp } = data.state(i, by_node(at.x));
                let (stress, wrinkling) = (tension.map(|t| t / thickness), f64::from(wrinkling as u8));
                out[triangle as usize] =
                    MembranePicture { stress, strain, wrinkling, warp: warp.into(), area: data.shapes[i].area };
            }
        }
    }

    fn trace(&self, at: StateRef<'_>, positions: &mut [[f64; 3]], velocities: &mut [[f64; 3]]) {
        self.built.numbering.to_user(by_node(at.x), positions);
        self.built.numbering.to_user(by_node(at.v), velocities);
    }

    fn node_forces(&self, _at: StateRef<'_>, forces: &Forces, out: &mut [[f64; 3]]) {
        self.built.numbering.to_user(by_node(&forces.total), out);
    }

    fn node_reactions(&self, forces: &Forces, out: &mut [[f64; 3]]) {
        out.fill([0.0; 3]);
        for (&dof, &reaction) in self.built.fixed_dofs.iter().zip(&forces.reactions) {
            let dof = dof as usize;
            out[self.built.numbering.user[dof / 3] as usize][dof % 3] = reaction;
        }
    }

    fn edge_tension(&self, at: StateRef<'_>, tension: &mut [f64], strain: &mut [f64]) {
        tension.fill(f64::NAN);
        strain.fill(f64::NAN);
        for batch in self.acting.springs.iter().filter(|batch| batch.cut.some()) {
            let cut = batch.edges.iter().enumerate().filter(|(i, _)| batch.cut.is_cut(*i));
            cut.for_each(|(_, &edge)| tension[edge as usize] = 0.0);
        }
        if self.built.shared_edges {
            return self.edge_sums(at, tension, strain);
        }
        for batch in self.carrying() {
            let (places, tension, strain) = (&batch.edges[..], &mut *tension, &mut *strain);
            batch.data.carried(batch.data.at(at.t, by_node(at.x)), SpringOutput { places, tension, strain });
        }
    }

    fn max_strain(&self, at: StateRef<'_>) -> f64 {
        let x = by_node(at.x);
        let springs = self.carrying().map(|b| b.data.largest_stretch(b.data.at(at.t, x)));
        let membranes = self.built.membranes.iter().map(|batch| batch.data.largest_stretch_of_all(x));
        strain_of(springs.chain(membranes).fold(f64::NEG_INFINITY, f64::max))
    }

    fn max_speed(&self, at: StateRef<'_>) -> f64 {
        motion(at.v, &self.built.mass).largest_square.sqrt()
    }

    fn node_value(&self, quantity: NodeQuantity, at: &Point, node: u32) -> [f64; 3] {
        let internal = self.built.numbering.internal[node as usize] as usize;
        let of = |dofs: &[f64]| by_node(dofs)[internal];
        match quantity {
            NodeQuantity::Position => of(&at.state.x).into(),
            NodeQuantity::Displacement => {
                let reference = self.mesh.nodes[node as usize];
                let x = of(&at.state.x);
                std::array::from_fn(|i| x[i] - reference[i])
            }
            NodeQuantity::Velocity => of(&at.state.v).into(),
            NodeQuantity::Acceleration => of(&at.forces.total).component_mul(&of(&self.phase().inverse_mass)).into(),
            NodeQuantity::Force => of(&at.forces.total).into(),
            NodeQuantity::Reaction => std::array::from_fn(|i| self.reaction(&at.forces, (3 * internal + i) as u32)),
        }
    }
}

impl Springs for Network {
    fn spring_edges(&self) -> Vec<u32> {
        let mut edges: Vec<u32> = self.acting.springs.iter().flat_map(|batch| batch.edges.iter().copied()).collect();
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    fn whole_edges(&self) -> Vec<u32> {
        self.carrying().flat_map(|batch| batch.edges.to_vec()).collect()
    }

    fn springs_on(&self, edges: &[u32], rule: Option<usize>) -> Vec<SpringPlace> {
        let batches =
            self.acting.springs.iter().zip(0_u32..).filter(|(batch, _)| rule.is_none_or(|r| r == batch.group as usize));
        let places = batches.flat_map(|(springs, batch)| {
            let chosen = springs.edges.iter().zip(0_u32..).filter(|(edge, _)| edges.binary_search(edge).is_ok());
            chosen.map(move |(_, number)| SpringPlace { batch, number })
        });
        places.collect()
    }

    fn edge_of(&self, SpringPlace { batch, number }: SpringPlace) -> Option<u32> {
        self.acting.springs.get(batch as usize)?.edges.get(number as usize).copied()
    }

    fn spring_tension(&self, at: StateRef<'_>, SpringPlace { batch, number }: SpringPlace) -> f64 {
        self.acting.springs.get(batch as usize).map_or(f64::NAN, |batch| batch.tension(at, number as usize))
    }

    fn add_axial_damping(&self, at: StateRef<'_>, tension: &mut [f64]) {
        for batch in self.carrying().filter(|batch| batch.axial) {
            for (i, &edge) in batch.edges.iter().enumerate() {
                tension[edge as usize] += axial_force(&batch.data, node_state(at), i, batch.dashpot.at(i));
            }
        }
    }

    fn rest_lengths(&self, t: f64, out: &mut [f64]) {
        out.fill(f64::NAN);
        for batch in &self.acting.springs {
            let scale = batch.data.rest_scale_at(t);
            for (rest, &edge) in batch.data.rest_length.iter().zip(batch.edges.iter()) {
                // NaN stands for "no spring yet", which min ignores.
                out[edge as usize] = out[edge as usize].min(scale * rest);
            }
        }
    }

    fn fastest_spring(&self, dof: usize) -> Option<u32> {
        let node = (dof / 3) as u32;
        let mut fastest: Option<(f64, u32)> = None;
        for batch in self.carrying() {
            let here =
                batch.data.nodes.iter().zip(batch.edges.iter()).enumerate().filter(|(_, (n, _))| n.contains(&node));
            for (i, (nodes, edge)) in here {
                let inverse = |node: u32| by_node(&self.phase().inverse_mass)[node as usize].max();
                let square = batch.data.stiffness.at(i) * nodes.map(inverse).iter().sum::<f64>();
                if fastest.is_none_or(|(most, _)| square > most) {
                    fastest = Some((square, *edge));
                }
            }
        }
        fastest.map(|(_, edge)| edge)
    }

    fn take_slack_as_taut(&self, taut: bool) {
        self.acting.springs.iter().for_each(|batch| batch.cut.set_slack_is_taut(taut));
    }

    fn has_branches(&self) -> bool {
        self.goes_slack()
    }

    fn damping(&self) -> SpringDamping {
        let dissipative = self.terms().iter().filter(|term| term.role == Role::Dissipative && !term.on_triangles);
        let kind = |constant| if constant { SpringDamping::Constant } else { SpringDamping::Axial };
        dissipative.map(|term| kind(term.constant_damping)).max().unwrap_or(SpringDamping::None)
    }

    fn branch_changes(&self, step: [StateRef<'_>; 2], impulse: &mut [f64]) -> Option<f64> {
        self.branch_changes_of(step, impulse)
    }
}

impl Air for Network {
    fn hold_wind(&self, wind: Option<[f64; 3]>) {
        self.acting.stream.iter().for_each(|stream| stream.hold(wind));
    }

    fn winds(&self, t: f64) -> Vec<[f64; 3]> {
        self.acting.stream.iter().flat_map(|stream| stream.winds(t)).map(Into::into).collect()
    }

    fn presses(&self) -> bool {
        !self.acting.pressures.is_empty()
    }

    fn triangle_pressure(&self, at: StateRef<'_>, out: &mut [f64]) {
        out.fill(0.0);
        self.acting.pressures.iter().for_each(|pressure| pressure.add(node_state(at), out));
    }

    fn canopies(&self) -> usize {
        self.acting.canopies.len()
    }

    fn canopy_values(&self, canopy: usize, at: StateRef<'_>) -> [f64; CANOPY_QUANTITIES.len()] {
        self.shape_of_canopy(canopy, at)
    }

    fn gases(&self) -> usize {
        self.acting.gases.len()
    }

    fn gas_values(&self, gas: usize, at: StateRef<'_>) -> [f64; GAS_QUANTITIES.len()] {
        self.acting.gases.get(gas).map_or([f64::NAN; 2], |(_, data)| data.pressure_and_volume(node_state(at)))
    }

    fn pull_of_points(&self, mass: f64, at: &Point) -> f64 {
        self.pull(mass, at)
    }
}

impl Network {
    /// The same where several springs are on one edge: their tensions add up, and the largest strain counts.
    fn edge_sums(&self, at: StateRef<'_>, tension: &mut [f64], strain: &mut [f64]) {
        for batch in self.carrying() {
            let springs = batch.data.at(at.t, by_node(at.x));
            for (i, &edge) in batch.edges.iter().enumerate() {
                let (of_edge, largest) = (&mut tension[edge as usize], &mut strain[edge as usize]);
                let own = batch.data.tension(springs, i);
                *of_edge = if of_edge.is_nan() { own } else { *of_edge + own };
                // NaN stands for "no spring yet", which max ignores.
                *largest = largest.max(batch.data.strain(springs, i));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force::schedule::threads::Threads;
    use crate::mesh::Mesh;
    use crate::model::spec::{DashpotKind, DashpotSpec, NetworkSpec, Slack, SpringGroup};
    use crate::model::system::System;
    use crate::scene::build::build_network;

    /// [N] Tension of a line with k = 100 N/m, c = 4 N s/m and l0 = 1 m from the origin to (l, 0, 0), whose far end
    /// moves at (ldot, 5, 0).
    fn tension(slack: Slack, kind: Option<DashpotKind>, [l, ldot]: [f64; 2]) -> f64 {
        let mesh = Mesh { nodes: vec![[0.0; 3], [l, 0.0, 0.0]], edges: vec![[0, 1]], ..Mesh::default() };
        let dashpot = kind.map(|kind| DashpotSpec { kind, coefficient: 4.0.into(), from_step: false });
        let line = SpringGroup {
            edges: vec![0],
            stiffness: 100.0.into(),
            rest_length: vec![1.0],
            slack,
            dashpot,
            ..SpringGroup::default()
        };
        let spec = NetworkSpec {
            mesh,
            mass: vec![1.0; 2],
            fixed: vec![[true; 3], [false; 3]],
            springs: vec![line],
            velocity: vec![[0.0; 3], [ldot, 5.0, 0.0]],
            ..NetworkSpec::default()
        };
        let network = build_network(spec, Threads::one()).expect("a line");
        let state = network.initial_state();
        let (mut tension, mut strain) = ([0.0], [0.0]);
        network.edge_tension(state.as_ref(), &mut tension, &mut strain);
        network.add_axial_damping(state.as_ref(), &mut tension);
        tension[0]
    }

    /// k (l - l0) + c ldot, clamped as one where the line goes slack; a relative dashpot pulls sideways too and is no
    /// tension.
    #[test]
    fn tension_has_the_axial_dashpot() {
        let (axial, relative) = (Some(DashpotKind::Axial), Some(DashpotKind::Relative));
        for (slack, kind, at, expected) in [
            (Slack::None, axial, [1.25, 3.0], 37.0),
            (Slack::None, axial, [1.25, -10.0], -15.0),
            (Slack::None, relative, [1.25, 3.0], 25.0),
            (Slack::None, None, [1.25, 3.0], 25.0),
            (Slack::TensionOnly, axial, [1.25, 3.0], 37.0),
            (Slack::TensionOnly, axial, [1.25, -10.0], 0.0),
            (Slack::TensionOnly, axial, [0.75, 10.0], 15.0),
            (Slack::TensionOnly, axial, [0.75, 3.0], 0.0),
            (Slack::DeadZone { eps: 0.125 }, axial, [1.25, 3.0], 24.5),
            (Slack::CompressionLimit { eps: 0.125 }, axial, [0.75, 3.0], -12.5),
        ] {
            assert_eq!(tension(slack, kind, at), expected, "{slack:?} {kind:?} {at:?}");
        }
    }
}
