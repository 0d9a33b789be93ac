//! The whole parachute as one mass with a drag area (`model`): a network of one node in place of the one that the case
//! describes.
//!
//! The node is the payload: it has the mass of all nodes, their momentum, and the drag areas of payload and canopies.
//! Cloth, lines and their drag have no place in it.

use std::collections::BTreeMap;

use nalgebra::Vector3;

use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::mesh::{Group, Mesh};
use crate::model::spec::{
    CanopyAir, CanopySpec, EventSpec, MotionSpec, NetworkSpec, NodalLoad, NodeDragSpec, ReleaseSpec, Watched,
};

/// The group of the payload.
const PAYLOAD: &str = "payload";

/// The network that a point stands for: what gauges and probes select in.
#[derive(Debug)]
pub(super) struct Whole {
    /// of every node, whether it is of the payload
    of_payload: Vec<bool>,
    /// [kg] mass of every node
    mass: Vec<f64>,
    /// what joins every node: the other one, and the edge if it is a spring
    joined: Vec<Vec<(u32, Option<u32>)>>,
    /// a node of every canopy
    apexes: Vec<u32>,
}

impl Whole {
    fn of(spec: &NetworkSpec) -> Self {
        let mesh = &spec.mesh;
        let payload = match mesh.groups.get(PAYLOAD) {
            Some(group) => group.select_nodes(mesh),
            None => spec.canopies.iter().flat_map(|canopy| canopy.confluence.iter().copied()).collect(),
        };
        let mut of_payload = vec![false; mesh.nodes.len()];
        payload.iter().for_each(|&node| of_payload[node as usize] = true);
        let mut joined = vec![Vec::new(); mesh.nodes.len()];
        let springs = spec.springs.iter().flat_map(|group| &group.edges);
        let springs = springs.filter_map(|&edge| Some((*mesh.edges.get(edge as usize)?, Some(edge))));
        let sides = mesh.triangles.iter().flat_map(|&[a, b, c]| [([a, b], None), ([b, c], None)]);
        for ([a, b], edge) in springs.chain(sides) {
            joined[a as usize].push((b, edge));
            joined[b as usize].push((a, edge));
        }
        let apexes = spec.canopies.iter().filter_map(|canopy| canopy.apex.first().copied()).collect();
        Whole { of_payload, mass: spec.mass.clone(), joined, apexes }
    }

    /// Whether nodes are the payload, a part of it, or all nodes: what a point can stand for.
    pub(super) fn is_point(&self, nodes: &[u32]) -> bool {
        nodes.len() == self.of_payload.len() || nodes.iter().all(|node| self.of_payload[*node as usize])
    }

    /// [kg] The mass that hangs above each of some edges; `None` unless each of them alone carries all canopies.
    pub(super) fn above(&self, edges: impl Iterator<Item = u32>) -> Option<Vec<f64>> {
        edges.map(|edge| self.mass_above(edge)).collect()
    }

    fn mass_above(&self, cut: u32) -> Option<f64> {
        let mut reached = self.of_payload.clone();
        let mut next: Vec<u32> = (0_u32..).zip(&reached).filter(|(_, of)| **of).map(|(node, _)| node).collect();
        while let Some(node) = next.pop() {
            for &(other, edge) in &self.joined[node as usize] {
                if edge != Some(cut) && !std::mem::replace(&mut reached[other as usize], true) {
                    next.push(other);
                }
            }
        }
        let apart = self.apexes.iter().all(|apex| !reached[*apex as usize]);
        let masses = self.mass.iter().zip(&reached).filter(|(_, reached)| !**reached);
        apart.then(|| masses.map(|(mass, _)| mass).sum())
    }

    /// [kg] That of payload nodes, and of all nodes.
    fn masses(&self) -> [f64; 2] {
        let payload = self.mass.iter().zip(&self.of_payload).filter(|(_, of)| **of).map(|(mass, _)| mass);
        [payload.sum(), self.mass.iter().sum()]
    }
}

/// The network of one node, and the one that it stands for.
pub(super) fn point(at: &Pointer, full: &NetworkSpec, faults: &mut Faults<'_>) -> Option<(NetworkSpec, Whole)> {
    let whole = Whole::of(full);
    let before = faults.count();
    refuse(at, full, &whole, faults);
    (faults.count() == before).then(|| (lumped(full, &whole), whole))
}

/// Adds the faults of what a point cannot have.
fn refuse(at: &Pointer, full: &NetworkSpec, whole: &Whole, faults: &mut Faults<'_>) {
    let mut not = |at: &Pointer, value: &str, allowed: &str| {
        let hint = "a point has a mass and a drag area, no shape and no parts: leave \"model\" out".to_owned();
        faults.add_value(at, value, allowed, Some(hint));
    };
    let aero = at.key("aero");
    if full.canopies.is_empty() {
        not(&aero.key("canopy"), "a point without a canopy", "a canopy with a schedule");
    }
    if full.canopies.iter().any(|canopy| !matches!(canopy.air, CanopyAir::Filling(_))) {
        not(&aero.key("canopy"), "a point whose drag area is not given", "canopies with a schedule");
    }
    let of_payload = |nodes: &[u32]| nodes.iter().all(|node| whole.of_payload[*node as usize]);
    if full.node_drag.iter().any(|drag| !of_payload(&drag.nodes)) {
        not(&aero.key("drag"), "a drag area of other nodes than the payload's", "drag areas of the payload");
    }
    if !full.gases.is_empty() {
        not(&at.key("gas"), "gas in a point", "no gas");
    }
    if !full.contacts.is_empty() {
        not(&at.key("contact"), "contact of a point", "no contact");
    }
    if !full.pressures.is_empty() || full.forces.iter().any(|load| !of_payload(&load.nodes)) {
        not(&at.key("loads"), "loads on a point", "forces on the payload");
    }
    let held: Vec<u32> =
        (0_u32..).zip(&full.fixed).filter(|(_, fixed)| fixed.contains(&true)).map(|(node, _)| node).collect();
    if !of_payload(&held) {
        not(&at.key("supports"), "supports of other nodes than the payload's", "supports of the payload");
    }
    let elsewhere = full.events.iter().find(|event| match &event.of {
        Watched::Nodes(shares) => {
            let all = shares.len() == whole.mass.iter().filter(|mass| **mass > 0.0).count();
            !all && shares.iter().any(|(node, _)| !whole.of_payload[*node as usize])
        }
        Watched::Springs { .. } => true,
    });
    if let Some(event) = elsewhere {
        let value = format!("the event \"{}\" of other parts than the payload", event.name);
        not(at, &value, "events by the motion of the payload");
    }
    if full.springs.iter().any(|group| !group.breaks.is_empty()) {
        not(&at.key("springs"), "lines that break", "no \"breaks\"");
    }
    if full.rayleigh.is_some_and(|rayleigh| rayleigh.mass != 0.0) {
        not(&at.key("damping"), "damping of a point by its mass", "no mass-proportional damping");
    }
    for (i, group) in full.springs.iter().enumerate().filter(|(_, group)| group.cut.is_some() || group.cut_by.is_some())
    {
        if group.edges.iter().any(|edge| whole.mass_above(*edge).is_some()) {
            not(&at.key("springs").index(i).key("cut"), "a riser that is cut", "no cut between payload and canopies");
        }
    }
}

/// The network of one node.
fn lumped(full: &NetworkSpec, whole: &Whole) -> NetworkSpec {
    let [payload, total] = whole.masses();
    let vector = |list: &[[f64; 3]], node: usize| list.get(node).map_or(Vector3::zeros(), |v| Vector3::from(*v));
    // Of a payload without mass all nodes count alike.
    let weight = |node: usize| match whole.of_payload[node] {
        true if payload > 0.0 => whole.mass[node] / payload,
        true => 1.0 / whole.of_payload.iter().filter(|of| **of).count() as f64,
        false => 0.0,
    };
    let nodes = || 0..full.mesh.nodes.len();
    let place = |of: &[[f64; 3]]| nodes().map(|node| weight(node) * vector(of, node)).sum::<Vector3<f64>>().into();
    let momentum: Vector3<f64> = nodes().map(|node| whole.mass[node] * vector(&full.velocity, node)).sum();
    let fixed = directions(full.fixed.iter().copied());
    let velocity = momentum / total;
    let velocity: [f64; 3] = std::array::from_fn(|axis| if fixed[axis] { 0.0 } else { velocity[axis] });
    let at_point = |list: &[(u32, [bool; 3])]| vec![(0, directions(list.iter().map(|(_, of)| *of)))];
    let count = |nodes: &[u32]| nodes.len() as f64;
    let node_drag = full.node_drag.iter().map(|drag| NodeDragSpec {
        nodes: vec![0],
        drag_area: drag.drag_area * count(&drag.nodes),
        glide: drag.glide.clone(),
    });
    let forces = full.forces.iter().map(|load| NodalLoad {
        nodes: vec![0],
        force: load.force.map(|f| f * count(&load.nodes)),
        factor: load.factor.clone(),
    });
    let known = full.mesh.groups.contains_key(PAYLOAD);
    let groups = known.then(|| (PAYLOAD.to_owned(), Group::of_nodes([0])));
    NetworkSpec {
        mesh: Mesh {
            nodes: vec![place(&full.mesh.nodes)],
            groups: groups.into_iter().collect::<BTreeMap<_, _>>(),
            ..Mesh::default()
        },
        mass: vec![total],
        fixed: vec![fixed],
        releases: full.releases.iter().map(|one| ReleaseSpec { nodes: at_point(&one.nodes), ..*one }).collect(),
        events: full.events.iter().map(event).collect(),
        // Supports move all nodes of a payload alike.
        motions: full.motions.iter().map(|one| MotionSpec { nodes: at_point(&one.nodes), ..one.clone() }).collect(),
        gravity: full.gravity,
        stream: full.stream.clone(),
        canopies: full.canopies.iter().map(canopy).collect(),
        node_drag: node_drag.collect(),
        forces: forces.collect(),
        displacement: if full.displacement.is_empty() { Vec::new() } else { vec![place(&full.displacement)] },
        velocity: vec![velocity],
        ..NetworkSpec::default()
    }
}

/// The directions that some of them have.
fn directions(all: impl Iterator<Item = [bool; 3]>) -> [bool; 3] {
    all.fold([false; 3], |some, of| std::array::from_fn(|axis| some[axis] || of[axis]))
}

fn event(full: &EventSpec) -> EventSpec {
    EventSpec { of: Watched::Nodes(vec![(0, 1.0)]), ..full.clone() }
}

fn canopy(full: &CanopySpec) -> CanopySpec {
    CanopySpec {
        triangles: Vec::new(),
        pressure_coefficient: Vec::new(),
        skirt: vec![0],
        apex: vec![0],
        confluence: vec![0],
        air: CanopyAir::Point(full.air.stages().to_vec()),
        apparent_mass: full.apparent_mass,
        inflow_loss: None,
        glide: full.glide.clone(),
        nominal_area: full.nominal_area,
    }
}
