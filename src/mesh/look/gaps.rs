//! Gaps between edges of cloth that run along each other, as along a seam that was not joined.
//!
//! A gap is narrow against the cloth and its own edges, and the cloth goes on at its other side. So no gap is what
//! two layers leave between them, a slot that is as wide as its edges are long, a notch or the end of a slit, whose
//! sides lead apart, or a strip of cloth, which has the cloth inside.

use super::rim::{Rim, RimEdge};
use super::{COINCIDENT, Cloth, GAP, LOOKS};
use crate::box_tree::{Bounds, BoxTree};
use crate::hanging::HangingNode;
use nalgebra::Vector3;
use std::collections::HashSet;

/// [-] Widest gap over the length of its edges.
const OF_EDGE: f64 = 0.3;
/// [-] The same between parts that nothing connects.
const OF_EDGE_APART: f64 = 0.9;
/// [-] Least cosine between edges that run along each other.
const PARALLEL: f64 = 0.7;
/// [-] Largest cosine between the ways into the cloth at both sides. It is -1 across a flat seam, 1 between layers.
const SAME_SIDE: f64 = 0.5;
/// [rad] Least angle of a notch.
const NOTCH: f64 = 0.03;
/// [rad] Angle at which both sides lead away from a corner that only comes near.
const CORNER: f64 = 0.3;
/// [-] Farthest node of the other side over the widest gap: both sides may also be shifted along each other.
const ASKEW: f64 = 1.5;
/// [-] Distance over the length of an edge within which a node lies on it.
const ON_EDGE: f64 = 1e-4;

/// What lies beside what.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// nodes of both sides that face each other
    pub pairs: Vec<[u32; 2]>,
    /// nodes that face an edge between its ends
    pub beside: Vec<Beside>,
}

/// A node that faces an edge between its ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Beside {
    pub node: u32,
    pub edge: [u32; 2],
    /// [m] distance
    pub away: f64,
}

/// The nearest other edge of a node of the rim.
#[derive(Clone, Copy)]
struct Nearest {
    edge: usize,
    away: f64,
    /// [m] widest gap there
    most: f64,
}

/// Finds all gaps.
pub(super) fn find(cloth: &Cloth<'_>, rim: &Rim) -> Found {
    let widest = GAP * cloth.extent;
    let mesh = cloth.mesh;
    let around = |edge: &RimEdge| Bounds::of(edge.ends.map(|node| &mesh.nodes[node as usize]));
    let tree = BoxTree::new(&rim.edges.iter().map(around).collect::<Vec<_>>());
    let lines: HashSet<[u32; 2]> = cloth.lines().map(|(_, [a, b])| [a.min(b), a.max(b)]).collect();
    let tied = |a: u32, b: u32| lines.contains(&[a.min(b), a.max(b)]);
    let mut looks = LOOKS * rim.edges.len() as u64;
    let mut nearest = |start: usize| -> Option<Nearest> {
        let node = rim.edges[start].ends[0];
        let size = rim.at_start(start).map(|edge| rim.size(edge)).fold(0.0, f64::max);
        // Twice as far as a gap is wide, to see how it goes on.
        let reach = 2.0 * widest.min(OF_EDGE_APART * size);
        let mut best: Option<Nearest> = None;
        tree.within(&Bounds::of([&mesh.nodes[node as usize]]).grown(reach), &mut looks, |edge| {
            let (edge, other) = (edge as usize, &rim.edges[edge as usize]);
            if other.ends.contains(&node) || mesh.triangles[other.triangle as usize].contains(&node) {
                return;
            }
            let foot = foot(cloth, node, other);
            let away = foot.norm();
            let share = if rim.are_apart(node, other.ends[0]) { OF_EDGE_APART } else { OF_EDGE };
            let most = widest.min(share * size.min(rim.size(edge)));
            let better = away <= 2.0 * most && best.is_none_or(|best| (away, edge) < (best.away, best.edge));
            if better && faces(rim, start, edge, foot) && !other.ends.iter().any(|end| tied(node, *end)) {
                best = Some(Nearest { edge, away, most });
            }
        });
        best
    };
    let all: Vec<Option<Nearest>> = (0..rim.edges.len()).map(&mut nearest).collect();
    let (mut found, mut askew) = (Found::default(), Vec::new());
    for (start, near) in all.iter().enumerate() {
        let Some(near) = near.filter(|near| near.away <= near.most && !leads_apart(rim, &all, start, near)) else {
            continue;
        };
        let (node, edge) = (rim.edges[start].ends[0], rim.edges[near.edge]);
        let away = |end: u32| (mesh.point(end) - mesh.point(node)).norm();
        let [a, b] = edge.ends;
        let end = if away(b) < away(a) { b } else { a };
        if away(end) <= ASKEW * near.most {
            found.pairs.push([node, end]);
            askew.push((Beside { node, edge: edge.ends, away: near.away }, away(end) > 2.0 * near.away));
        } else if near.away > ON_EDGE * edge.length {
            // Nodes on the edge itself are hanging nodes.
            found.beside.push(Beside { node, edge: edge.ends, away: near.away });
        }
    }
    // Where most nodes face edges, those that are farther from a node than from its edge were not made for it either.
    if found.beside.len() > found.pairs.len() {
        let coincident = COINCIDENT * cloth.extent;
        let not_meant = |beside: &Beside, far: bool| far && beside.away > coincident;
        let mut kept = askew.iter().map(|(beside, far)| !not_meant(beside, *far));
        found.pairs.retain(|_| kept.next().unwrap_or(true));
        found.beside.extend(askew.iter().filter(|(beside, far)| not_meant(beside, *far)).map(|(beside, _)| *beside));
    }
    let paired: HashSet<u32> = found.pairs.as_flattened().iter().copied().collect();
    found.beside.retain(|beside| !paired.contains(&beside.node));
    found.beside.sort_unstable_by_key(|beside| beside.node);
    found.beside.dedup_by_key(|beside| beside.node);
    found
}

/// From a node to the nearest point of an edge.
fn foot(cloth: &Cloth<'_>, node: u32, edge: &RimEdge) -> Vector3<f64> {
    let from = cloth.mesh.point(edge.ends[0]) - cloth.mesh.point(node);
    from + edge.along * (-from.dot(&edge.along)).clamp(0.0, edge.length)
}

/// Whether the rim at the first end of an edge runs along another edge, with cloth on the far side of both.
fn faces(rim: &Rim, start: usize, edge: usize, foot: Vector3<f64>) -> bool {
    let other = &rim.edges[edge];
    let cosine = |own: usize| rim.edges[own].along.dot(&other.along).abs();
    let Some(own) = rim.at_start(start).max_by(|a, b| cosine(*a).total_cmp(&cosine(*b))) else { return false };
    if cosine(own) < PARALLEL || rim.edges[own].inward.dot(&other.inward) > SAME_SIDE {
        return false;
    }
    let (one, away) = (&rim.edges[own], foot.norm());
    // Around a corner of the same sheet the way along the rim is hardly longer than that across.
    if one.of_loop == other.of_loop && rim.way(start, edge) < 4.0 * away {
        return false;
    }
    // Into the cloth: sides that overlap a little, or those of a strip of cloth.
    foot.dot(&one.inward) <= 0.0 || away <= OF_EDGE * one.height.min(other.height)
}

/// Whether the sides lead apart like those of a notch, or on both sides of a corner.
fn leads_apart(rim: &Rim, all: &[Option<Nearest>], start: usize, near: &Nearest) -> bool {
    let other = &rim.edges[near.edge];
    let beside = other.beside.iter().flatten().flat_map(|edge| rim.edges[*edge].ends);
    let far_side: Vec<u32> = beside.chain(other.ends).collect();
    // [m/m] growth towards a neighbour, whose distance is that of the edge that starts there.
    let growth = |neighbour: Option<(u32, f64, Option<usize>)>| {
        neighbour.map_or(f64::INFINITY, |(node, length, its)| {
            let away = if far_side.contains(&node) {
                0.0
            } else {
                its.and_then(|edge| all[edge]).map_or(f64::INFINITY, |near| near.away)
            };
            (away - near.away) / length
        })
    };
    let edge = &rim.edges[start];
    let before = edge.beside[0].map(|edge| (rim.edges[edge].ends[0], rim.edges[edge].length, Some(edge)));
    let [back, on] = [growth(before), growth(Some((edge.ends[1], edge.length, edge.beside[1])))];
    let notch = back.min(on) < -NOTCH && back.max(on) > NOTCH;
    notch || back.min(on) > CORNER
}

/// The end of its edge that a hanging node lies beside, if that is as near as across a gap.
pub(super) fn end_beside(cloth: &Cloth<'_>, hanging: &HangingNode) -> Option<u32> {
    let [a, b] = hanging.edge.map(|end| cloth.mesh.point(end));
    let x = cloth.mesh.point(hanging.node);
    let most = (GAP * cloth.extent).min(0.1 * (a - b).norm());
    let (end, away) = if (x - a).norm() <= (x - b).norm() { (0, (x - a).norm()) } else { (1, (x - b).norm()) };
    (away <= most).then_some(hanging.edge[end])
}
