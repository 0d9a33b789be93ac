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

/// The part of a scene with the largest sum of loads along an axis in which nothing holds it.
pub(super) fn loose(scene: &dyn Scene, at: &Point) -> Option<Loose> {
    let mut loads = vec![0.0; scene.n_dof()];
    scene.load(at.state.as_ref(), &mut loads);
    let parts = Parts::of(scene, at, &loads)?;
    let (&(part, axis), sum) = parts.moves().max_by(|a, b| a.1.load.abs().total_cmp(&b.1.load.abs()))?;
    Some(parts.loose(scene, part, axis, sum))
}

/// Sums of loads by part of a scene and axis.
struct Parts {
    /// part of every node
    part: Vec<u32>,
    sums: BTreeMap<(u32, &'static str), Sum>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    /// [N]
    load: f64,
    /// [N] sum of the sizes of what acts
    size: f64,
    /// whether a node is held
    held: bool,
}

impl Parts {
    fn of(scene: &dyn Scene, at: &Point, loads: &[f64]) -> Option<Self> {
        let n = scene.reference().len();
        if scene.n_dof() != 3 * n {
            return None;
        }
        let springs = scene.springs().map_or_else(Vec::new, |springs| springs.spring_edges());
        let edges = springs.iter().filter_map(|&edge| scene.edges().get(edge as usize).copied());
        let sides = scene.triangles().iter().flat_map(|&[a, b, c]| [[a, b], [b, c]]);
        let part = components(n, edges.chain(sides));
        let tensions = scene.tension_sums(at.state.as_ref());
        let mut sums: BTreeMap<(u32, &'static str), Sum> = BTreeMap::new();
        for (dof, (load, inverse)) in loads.iter().zip(scene.inverse_mass()).enumerate() {
            let (node, axis) = scene.name_of(dof);
            let sum = sums.entry((part[node as usize], axis)).or_default();
            sum.load += load;
            sum.size += load.abs() + tensions[node as usize];
            sum.held |= *inverse == 0.0;
        }
        Some(Parts { part, sums })
    }

    /// Those that nothing holds.
    fn moves(&self) -> impl Iterator<Item = (&(u32, &'static str), &Sum)> {
        self.sums.iter().filter(|(_, sum)| !sum.held && sum.load.abs() > ROUNDING * sum.size)
    }

    /// Those that nothing holds along any axis, nor a wind. Air pushes what is at rest with the wind or not at all, so
    /// it balances only loads that act against the wind.
    fn falls(&self, winds: &[[f64; 3]]) -> impl Iterator<Item = (&(u32, &'static str), &Sum)> {
        let of = |part: u32| ["x", "y", "z"].map(|axis| self.sums.get(&(part, axis)).copied().unwrap_or_default());
        self.moves().filter(move |((part, _), _)| {
            let sums = of(*part);
            let against = |wind: &[f64; 3]| (0..3).map(|c| wind[c] * sums[c].load).sum::<f64>() < 0.0;
            sums.iter().all(|sum| !sum.held) && !winds.iter().any(against)
        })
    }

    fn loose(&self, scene: &dyn Scene, of: u32, axis: &'static str, sum: &Sum) -> Loose {
        let nodes: Vec<u32> = (0..).zip(&self.part).filter(|(_, part)| **part == of).map(|(node, _)| node).collect();
        let groups = groups_of(scene, &nodes);
        Loose { axis, whole: nodes.len() == self.part.len(), groups, nodes, resultant: sum.load }
    }
}

/// [-] Share of the scene's size by which nodes are moved to see whether a force acts at rest.
const MOVED: f64 = 0.1;

/// The failure of a scene with loads that nothing holds: no support, no pressure, no wind.
pub(super) fn unsupported(scene: &dyn Scene, at: &Point, size: f64) -> Option<StaticFailure> {
    if scene.controls().is_some_and(|controls| controls.external().is_some())
        || scene.n_dof() != 3 * scene.reference().len()
    {
        return None;
    }
    let mut moved = at.state.clone();
    moved.x.iter_mut().enumerate().for_each(|(i, x)| *x += MOVED * size * pseudo_random(i));
    let (mut loads, mut force) = (vec![0.0; scene.n_dof()], vec![0.0; scene.n_dof()]);
    scene.load(at.state.as_ref(), &mut loads);
    let mut blows = false;
    for (term, info) in scene.terms().iter().enumerate().filter(|(_, info)| info.role == Role::External) {
        if !info.velocity_dependent && !info.follower {
            continue;
        }
        scene.term_alone(term, moved.as_ref(), &mut force)?;
        // Air that does not move pushes nothing that is at rest, whatever its shape.
        if force.iter().all(|force| *force == 0.0) {
            continue;
        }
        if !info.velocity_dependent {
            return None;
        }
        blows = true;
        scene.term_alone(term, at.state.as_ref(), &mut force)?;
        let free = scene.inverse_mass().iter().map(|inverse| *inverse > 0.0);
        loads.iter_mut().zip(&force).zip(free).filter(|(_, free)| *free).for_each(|((load, f), _)| *load -= f);
    }
    let winds = scene.air().filter(|_| blows).map_or_else(Vec::new, |air| air.winds(at.state.t));
    if blows && !along_one_line(&winds) {
        return None;
    }
    let parts = Parts::of(scene, at, &loads)?;
    let largest = |a: &(_, &Sum), b: &(_, &Sum)| a.1.load.abs().total_cmp(&b.1.load.abs());
    let (&(part, axis), sum) = if blows { parts.falls(&winds).max_by(largest) } else { parts.moves().max_by(largest) }?;
    Some(StaticFailure::NoSupport { loose: parts.loose(scene, part, axis, sum) })
}

/// Whether there are winds, all of one direction. Where they differ, a body could lean on one against another.
fn along_one_line(winds: &[[f64; 3]]) -> bool {
    let dot = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
    let Some(strongest) = winds.iter().max_by(|a, b| dot(a, a).total_cmp(&dot(b, b))) else { return false };
    if dot(strongest, strongest) == 0.0 {
        return false;
    }
    winds.iter().all(|wind| {
        let along = dot(wind, strongest);
        along >= 0.0 && along * along >= (1.0 - ROUNDING) * dot(wind, wind) * dot(strongest, strongest)
    })
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
