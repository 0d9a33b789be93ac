//! What the tangent at an equilibrium says of it: whether it is stable, which nodes no force keeps in place, and which
//! motions meet no resistance.

use super::resultants::listed;
use super::unknowns::Dofs;
use crate::analysis::pencil::Pencil;
use crate::model::point::Point;
use crate::model::stop::Stop;
use crate::scene::Scene;
use std::collections::BTreeSet;

/// What small disturbances do.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Stability {
    /// the potential has a strict minimum, apart from parts without stiffness
    Stable,
    /// some motion meets no resistance
    Neutral,
    /// some motion grows by itself
    Unstable,
}

/// What kind of a finding it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FindingKind {
    /// nodes that no spring in tension holds: where they are is not determined
    Slack,
    /// a motion of taut parts that meets no resistance: the place along it is not determined
    Mechanism,
    /// a motion that grows: a small disturbance leads to another equilibrium
    Unstable,
}

/// Something to know of an equilibrium.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Finding {
    /// what kind
    pub kind: FindingKind,
    /// the nodes, ascending; of a motion those that move at least half as far as the one that moves most
    pub nodes: Vec<u32>,
    /// groups that hold half of these nodes or more
    pub groups: Vec<String>,
    /// in a sentence
    pub text: String,
}

/// Stability and findings.
#[derive(Debug, Default)]
pub(super) struct Judged {
    pub stability: Option<Stability>,
    pub findings: Vec<Finding>,
}

/// [-] A stiffness below this share of that of the springs at rest is none.
const NO_STIFFNESS: f64 = 1e-9;
/// [-] The same for a motion of many nodes, whose stiffness may be truly small.
const NO_RESISTANCE: f64 = 1e-12;
/// Motions that are looked for.
const MOTIONS: usize = 6;

/// Judges an equilibrium.
pub(super) fn judge(scene: &dyn Scene, dofs: &Dofs, at: &Point, stop: Stop<'_>) -> Judged {
    let Ok(mut pencil) = Pencil::of(scene, at.state.as_ref()) else { return Judged::default() };
    let slack = slack_unknowns(scene, dofs, &pencil);
    let mut findings: Vec<Finding> = slack_nodes(scene, &pencil, &slack).into_iter().collect();
    if !pencil.symmetric {
        return Judged { stability: None, findings };
    }
    // What has no stiffness at all is put on the ground, so that the rest is judged.
    let ground: Vec<f64> =
        slack.iter().zip(&pencil.stiffness).map(|(slack, k)| f64::from(*slack) * k.max(1.0)).collect();
    pencil.add_diagonal(ground.into_iter());
    let shift: Vec<f64> = pencil.stiffness.iter().map(|k| -NO_RESISTANCE * k).collect();
    pencil.add_diagonal(shift.iter().copied());
    let stable = pencil.is_definite();
    pencil.add_diagonal(shift.iter().map(|k| -k));
    if stable {
        return Judged { stability: Some(Stability::Stable), findings };
    }
    let zero = NO_RESISTANCE * pencil.fastest();
    let Ok(modes) = pencil.lowest(MOTIONS.min(pencil.unknowns()), stop) else {
        return Judged { stability: None, findings };
    };
    let shapes = |chosen: &dyn Fn(f64) -> bool| -> Vec<&[f64]> {
        modes.iter().filter(|mode| chosen(mode.omega_squared)).map(|mode| &*mode.shape).collect()
    };
    let (growing, free) = (shapes(&|square| square < -zero), shapes(&|square| square.abs() <= zero));
    findings.extend(motions(scene, &growing, FindingKind::Unstable));
    findings.extend(motions(scene, &free, FindingKind::Mechanism));
    let stability = if growing.is_empty() { Stability::Neutral } else { Stability::Unstable };
    Judged { stability: Some(stability), findings }
}

/// Whether every unknown belongs to a node without stiffness in any direction `[n]`.
fn slack_unknowns(scene: &dyn Scene, dofs: &Dofs, pencil: &Pencil) -> Vec<bool> {
    let (pattern, diagonal) = (&pencil.pattern, pencil.diagonal());
    let soft = |unknown: &usize| {
        let dof = pattern.dof[*unknown] as usize;
        diagonal[*unknown].abs() <= NO_STIFFNESS * dofs.stiffness[dof] && scene.inverse_mass()[dof] > 0.0
    };
    let soft: Vec<bool> = (0..pattern.n()).map(|unknown| soft(&unknown)).collect();
    let mut slack = vec![false; pattern.n()];
    for node in pattern.node_start.windows(2) {
        let unknowns = node[0] as usize..node[1] as usize;
        let all = soft[unknowns.clone()].iter().all(|soft| *soft);
        slack[unknowns].fill(all);
    }
    slack
}

fn slack_nodes(scene: &dyn Scene, pencil: &Pencil, slack: &[bool]) -> Option<Finding> {
    let of = pencil.pattern.dof.iter().zip(slack).filter(|(_, slack)| **slack);
    let nodes: BTreeSet<u32> = of.map(|(&dof, _)| scene.name_of(dof as usize).0).collect();
    let nodes: Vec<u32> = nodes.into_iter().collect();
    if nodes.is_empty() {
        return None;
    }
    let groups = groups_of(scene, &nodes);
    let text = format!(
        "no spring in tension holds node{}, and no force moves it: the position is not determined, and kept as it is",
        listed(&nodes, &groups)
    );
    Some(Finding { kind: FindingKind::Slack, nodes, groups, text })
}

/// What some motions of one kind are, by the nodes that move at least half as far as the one that moves most.
fn motions(scene: &dyn Scene, shapes: &[&[f64]], kind: FindingKind) -> Option<Finding> {
    let mut nodes = BTreeSet::new();
    for shape in shapes {
        let most = shape.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let moving = shape.iter().enumerate().filter(|(_, x)| x.abs() >= 0.5 * most);
        nodes.extend(moving.map(|(dof, _)| scene.name_of(dof).0));
    }
    let nodes: Vec<u32> = nodes.into_iter().collect();
    let groups = groups_of(scene, &nodes);
    let listed = listed(&nodes, &groups);
    let (count, one) = match shapes.len() {
        0 => return None,
        1 => ("a motion".to_owned(), true),
        n if n < MOTIONS => (format!("{n} motions"), false),
        n => (format!("at least {n} motions"), false),
    };
    let text = match (kind, one) {
        (FindingKind::Unstable, _) => format!(
            "the equilibrium is unstable: {count}, mostly of node{listed}, {} by {}; start from a disturbed state \
             (initial.displacement) to find a stable one",
            if one { "grows" } else { "grow" },
            if one { "itself" } else { "themselves" }
        ),
        _ => format!(
            "{count}, mostly of node{listed}, {} no resistance (a mechanism): the place along {} is not determined",
            if one { "meets" } else { "meet" },
            if one { "it" } else { "them" }
        ),
    };
    Some(Finding { kind, nodes, groups, text })
}

/// Names of the groups that hold at least half of some nodes (ascending), by themselves or as ends of edges and corners
/// of triangles.
pub(super) fn groups_of(scene: &dyn Scene, nodes: &[u32]) -> Vec<String> {
    let holds = |group: &crate::mesh::group::Group| {
        let edges = group.edges.iter().filter_map(|&edge| scene.edges().get(edge as usize)).flatten();
        let triangles = group.triangles.iter().filter_map(|&t| scene.triangles().get(t as usize)).flatten();
        let members: BTreeSet<u32> = group.nodes.iter().chain(edges).chain(triangles).copied().collect();
        2 * nodes.iter().filter(|node| members.contains(node)).count() >= nodes.len()
    };
    scene.groups().iter().filter(|(_, group)| holds(group)).map(|(name, _)| name.clone()).collect()
}
