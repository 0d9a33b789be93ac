//! One node for those that meet on seams, and what the pieces are as they are cut.

use super::place::Placed;
use super::{Cut, Seam, Stitch};
use crate::components::components;
use crate::{Group, Groups, Mesh};
use nalgebra::Vector3;
use std::collections::HashMap;

/// For each node of the flat pieces its number afterwards.
pub(super) struct Joined {
    pub node: Vec<u32>,
}

/// Joins the nodes that meet, at the mean of their places.
pub(super) fn join(mesh: &mut Mesh, seams: &[Seam], stitches: &[Stitch], placed: &Placed) -> Joined {
    let drawn: Vec<[[f64; 3]; 3]> = mesh.triangles.iter().map(|t| t.map(|node| mesh.nodes[node as usize])).collect();
    let flat: Vec<f64> = mesh.edges.iter().map(|&[a, b]| (mesh.point(a) - mesh.point(b)).norm()).collect();
    let joined = number(mesh.nodes.len(), stitches);
    let places = mean_places(&joined, placed);
    let of = |node: u32| joined.node[node as usize];
    let edges = Edges::of(mesh.edges.iter().zip(&flat).map(|(edge, length)| (edge.map(of), *length)));
    let on_seams = |rule: Option<usize>| {
        let chosen = stitches.iter().filter(move |stitch| rule.is_none_or(|rule| stitch.rule == rule));
        let pairs = chosen.flat_map(|stitch| stitch.sides[0].nodes.windows(2));
        Group::of_edges(pairs.filter_map(|pair| edges.find([of(pair[0]), of(pair[1])])))
    };
    let seams_of: Vec<(String, Group)> = (0..seams.len())
        .filter_map(|rule| {
            let seam = &seams[rule];
            let name = seam.name.clone().or(seam.gores.as_ref().map(|_| "radials".to_owned()))?;
            Some((name, on_seams(Some(rule))))
        })
        .collect();
    let all = on_seams(None).edges;
    let renumber = |numbers: &[u32], of: &dyn Fn(u32) -> u32| Group::of_nodes(numbers.iter().map(|i| of(*i))).nodes;
    let mut groups: Groups = std::mem::take(&mut mesh.groups);
    for group in groups.values_mut() {
        group.nodes = renumber(&group.nodes, &of);
        group.edges = renumber(&group.edges, &|edge| edges.of_old[edge as usize]);
    }
    for (name, seam) in seams_of {
        let group: &mut Group = groups.entry(name).or_default();
        group.edges = renumber(&[&group.edges[..], &seam.edges].concat(), &|edge| edge);
    }
    let mut triangles = drawn;
    for (corners, cut) in mesh.triangles.iter_mut().zip(&mut triangles) {
        if placed.turned[corners[0] as usize] {
            corners.swap(1, 2);
            cut.swap(1, 2);
        }
        *corners = corners.map(of);
    }
    mesh.nodes = places;
    mesh.seams = renumber(
        &[&mesh.seams.iter().map(|e| edges.of_old[*e as usize]).collect::<Vec<_>>()[..], &all].concat(),
        &|e| e,
    );
    mesh.edges = edges.pairs;
    mesh.groups = groups;
    mesh.displacement.clear();
    mesh.cut = Some(Cut { triangles, lengths: edges.lengths });
    joined
}

/// Numbers the nodes anew; those that meet have the place of the first of them.
fn number(nodes: usize, stitches: &[Stitch]) -> Joined {
    let same = components(nodes, stitches.iter().flat_map(Stitch::pairs));
    let mut count = 0;
    let mut node = vec![0; nodes];
    for (i, &first) in same.iter().enumerate() {
        node[i] = if first as usize == i { count } else { node[first as usize] };
        count += u32::from(first as usize == i);
    }
    Joined { node }
}

fn mean_places(joined: &Joined, placed: &Placed) -> Vec<[f64; 3]> {
    let count = joined.node.iter().max().map_or(0, |last| *last as usize + 1);
    let mut sums = vec![(Vector3::zeros(), 0.0); count];
    for (place, node) in placed.at.iter().zip(&joined.node) {
        let (sum, number) = &mut sums[*node as usize];
        *sum += place;
        *number += 1.0;
    }
    sums.into_iter().map(|(sum, number)| (sum / number).into()).collect()
}

/// Edges after joining, each once, with the mean length of those that became one.
struct Edges {
    pairs: Vec<[u32; 2]>,
    lengths: Vec<f64>,
    /// for each edge before, its number
    of_old: Vec<u32>,
    known: HashMap<[u32; 2], u32>,
}

impl Edges {
    fn of(all: impl Iterator<Item = ([u32; 2], f64)>) -> Self {
        let mut edges = Edges { pairs: Vec::new(), lengths: Vec::new(), of_old: Vec::new(), known: HashMap::new() };
        let mut members = Vec::new();
        for (pair, length) in all {
            let next = edges.pairs.len() as u32;
            let number = *edges.known.entry(key(pair)).or_insert(next);
            if number == next {
                edges.pairs.push(pair);
                edges.lengths.push(0.0);
                members.push(0.0);
            }
            edges.lengths[number as usize] += length;
            members[number as usize] += 1.0;
            edges.of_old.push(number);
        }
        edges.lengths.iter_mut().zip(members).for_each(|(length, count)| *length /= count);
        edges
    }

    fn find(&self, pair: [u32; 2]) -> Option<u32> {
        self.known.get(&key(pair)).copied()
    }
}

fn key([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}
