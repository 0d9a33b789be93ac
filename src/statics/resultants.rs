//! Sums of the loads on the parts of a scene: what no support holds cannot rest.

use super::Residual;
use super::StaticFailure;
use super::continuation::Continuation;
use super::diagnosis::groups_of;
use crate::format_number::{figures, first_few};
use crate::mesh::components::components;
use crate::mesh::random::pseudo_random;
use crate::model::forces::Role;
use crate::model::point::Point;
use crate::scene::Scene;
use std::collections::BTreeMap;

/// A part of a scene that is free to move along an axis, with loads along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Loose {
    /// x, y or z
    pub axis: &'static str,
    /// its nodes, ascending
    pub nodes: Vec<u32>,
    /// groups that hold half of these nodes or more
    pub groups: Vec<String>,
    /// [N] sum of its loads along the axis
    pub resultant: f64,
    /// whether it is the whole scene
    pub whole: bool,
}

impl std::fmt::Display for Loose {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let axis = self.axis;
        match self.whole {
            true => write!(f, "no support holds the scene in {axis}")?,
            false => write!(f, "no support holds node{} in {axis}", listed(&self.nodes, &self.groups))?,
        }
        write!(f, ", and the loads add up to {} N there", figures(self.resultant, 4))
    }
}

/// " 3" or "s 3, 4 (group lines)".
pub(super) fn listed(nodes: &[u32], groups: &[String]) -> String {
    let of = match groups {
        [] => String::new(),
        [one] => format!(" (group {one})"),
        several => format!(" (groups {})", several.join(", ")),
    };
    format!("{} {}{of}", if nodes.len() == 1 { "" } else { "s" }, first_few(nodes))
}

/// [-] A sum of loads below this share of the forces that act is rounding.
const ROUNDING: f64 = 1e-9;

/// The part of a scene with the largest sum of forces along an axis in which nothing holds it.
pub(super) fn loose(scene: &dyn Scene, at: &Point) -> Option<Loose> {
    let n = scene.reference().len();
    if scene.n_dof() != 3 * n {
        return None;
    }
    let springs = scene.spring_edges();
    let edges = springs.iter().filter_map(|&edge| scene.edges().get(edge as usize).copied());
    let sides = scene.triangles().iter().flat_map(|&[a, b, c]| [[a, b], [b, c]]);
    let part = components(n, edges.chain(sides));
    let (mut loads, tensions) = (vec![0.0; scene.n_dof()], scene.tension_sums(at.state.as_ref()));
    scene.load(at.state.as_ref(), &mut loads);
    // By part and axis: the sum, the sum of sizes of what acts, and whether it is held.
    let mut sums: BTreeMap<(u32, &'static str), (f64, f64, bool)> = BTreeMap::new();
    for (dof, (f, inverse)) in loads.iter().zip(scene.inverse_mass()).enumerate() {
        let (node, axis) = scene.name_of(dof);
        let sum = sums.entry((part[node as usize], axis)).or_default();
        *sum = (sum.0 + f, sum.1 + f.abs() + tensions[node as usize], sum.2 || *inverse == 0.0);
    }
    let moves = sums.iter().filter(|(_, (sum, sizes, held))| !held && sum.abs() > ROUNDING * sizes);
    let (&(of, axis), &(resultant, ..)) = moves.max_by(|a, b| a.1.0.abs().total_cmp(&b.1.0.abs()))?;
    let nodes: Vec<u32> = (0..n as u32).filter(|&node| part[node as usize] == of).collect();
    let groups = groups_of(scene, &nodes);
    Some(Loose { axis, whole: nodes.len() == n, groups, nodes, resultant })
}

/// [-] Share of the scene's size by which nodes are moved to see whether a force acts at rest.
const MOVED: f64 = 0.1;

/// The failure of a scene whose loads do not depend on its shape and that nothing holds against them.
pub(super) fn unsupported(scene: &dyn Scene, at: &Point, size: f64) -> Option<StaticFailure> {
    if scene.external().is_some() {
        return None;
    }
    // Air at rest pushes nothing that is at rest, whatever its shape.
    let mut moved = at.state.clone();
    moved.x.iter_mut().enumerate().for_each(|(i, x)| *x += MOVED * size * pseudo_random(i));
    let mut force = vec![0.0; scene.n_dof()];
    let mut acts = |term: usize| {
        scene.term_alone(term, moved.as_ref(), &mut force).is_none() || force.iter().any(|force| *force != 0.0)
    };
    let mut follows = scene
        .terms()
        .iter()
        .enumerate()
        .filter(|(_, term)| term.role == Role::External && (term.velocity_dependent || term.follower));
    if follows.any(|(term, _)| acts(term)) {
        return None;
    }
    loose(scene, at).map(|loose| StaticFailure::NoSupport { loose })
}

impl Continuation<'_> {
    pub(super) fn not_finite(&self, left: Residual) -> StaticFailure {
        StaticFailure::NotFinite { place: self.scene.suspect(self.at.state.as_ref(), left.worst) }
    }

    pub(super) fn not_converged(&self, residual: Residual) -> StaticFailure {
        StaticFailure::NotConverged {
            residual,
            place: self.scene.suspect(self.at.state.as_ref(), residual.worst),
            iterations: self.iterations(),
            loose: loose(self.scene, &self.at).map(Box::new),
        }
    }

    /// The failure of a scene whose node has gone far away.
    pub(super) fn left(&self) -> StaticFailure {
        let moved = self.at.state.x.iter().zip(&self.start.state.x).map(|(x, start)| (x - start).abs());
        let farthest = moved.enumerate().max_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(dof, _)| dof);
        let place = self.scene.suspect(self.at.state.as_ref(), farthest);
        StaticFailure::Left { place, loose: loose(self.scene, &self.at).map(Box::new) }
    }
}
