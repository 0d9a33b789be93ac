//! Parts that are closer to each other at the start than their contact lets them be.

mod distance;

use std::collections::BTreeMap;
use std::fmt;

use nalgebra::Vector3;

use crate::format_number::{counted, figures};
use crate::mesh::box_tree::{Bounds, BoxTree};
use crate::model::spec::{ContactParts, ContactSide, ContactSpec, NetworkSpec};
use crate::warning::{Warning, WarningCode};
use distance::between;

/// [-] Pairs of boxes that a search may compare, for each triangle, line and lone node.
const LOOKS: u64 = 1_000;
/// [-] Pairs that a search may compare in any case.
const LEAST_LOOKS: u64 = 10_000_000;
/// [-] What the distance of a pair takes of them.
const LOOKS_OF_DISTANCE: u64 = 20;

/// Pairs of triangles, lines and lone nodes of a contact that are closer at the start than its gap. Such pairs share no
/// node, and not all of their nodes are held for ever.
#[derive(Clone, Debug, PartialEq)]
pub struct CloseAtStart {
    /// [-] which contact of the specification
    pub contact: usize,
    /// [m] its gap
    pub gap: f64,
    /// [-] number of pairs
    pub pairs: usize,
    /// whether all pairs were looked at; parts that are crumpled beyond all measure have too many
    pub complete: bool,
    /// the nodes of the closest pair: three of a triangle, two of a line, or one
    pub closest: [Vec<u32>; 2],
    /// [m] distance of these two; 0 where they meet or cross
    pub distance: f64,
}

/// Finds the pairs of every contact of parts with parts, with a bound on its work.
pub fn at_start(spec: &NetworkSpec) -> Vec<CloseAtStart> {
    let place = |node: usize| {
        let of = |list: &[[f64; 3]]| list.get(node).map_or(Vector3::zeros(), |x| Vector3::from(*x));
        of(&spec.mesh.nodes) + of(&spec.displacement)
    };
    if spec.contacts.is_empty() {
        return Vec::new();
    }
    let nodes: Vec<Vector3<f64>> = (0..spec.mesh.nodes.len()).map(place).collect();
    let moves = movable(spec);
    let found = |(i, contact): (usize, &ContactSpec)| pairs_of(i, contact, spec, (&nodes, &moves));
    spec.contacts.iter().enumerate().filter_map(found).collect()
}

/// Which nodes move at any time.
fn movable(spec: &NetworkSpec) -> Vec<bool> {
    let mut moves: Vec<bool> = spec.fixed.iter().map(|fixed| fixed.contains(&false)).collect();
    let released = spec.releases.iter().flat_map(|release| &release.nodes);
    let moved = spec.motions.iter().flat_map(|motion| &motion.nodes);
    for (node, _) in released.chain(moved) {
        if let Some(moves) = moves.get_mut(*node as usize) {
            *moves = true;
        }
    }
    moves
}

/// A triangle, a line or a lone node.
struct Element {
    nodes: Vec<u32>,
    /// whether it is of the first side, and of the second
    of: [bool; 2],
}

/// The elements of both sides, each once: triangles, then lines, then nodes.
fn elements(contact: &ContactSpec, spec: &NetworkSpec) -> Vec<Element> {
    let sides = match &contact.other {
        ContactSide::Itself => [&contact.parts, &contact.parts],
        ContactSide::Parts(other) => [&contact.parts, other],
        ContactSide::Obstacle(_) => return Vec::new(),
    };
    let mut found: BTreeMap<(u8, u32), Element> = BTreeMap::new();
    let mesh = &spec.mesh;
    for (side, ContactParts { triangles, edges, nodes }) in sides.into_iter().enumerate() {
        let corners = triangles.iter().filter_map(|t| Some(((0, *t), mesh.triangles.get(*t as usize)?.to_vec())));
        let ends = edges.iter().filter_map(|e| Some(((1, *e), mesh.edges.get(*e as usize)?.to_vec())));
        let lone = nodes.iter().filter(|node| (**node as usize) < mesh.nodes.len()).map(|n| ((2, *n), vec![*n]));
        for (key, nodes) in corners.chain(ends).chain(lone) {
            found.entry(key).or_insert(Element { nodes, of: [false; 2] }).of[side] = true;
        }
    }
    found.into_values().collect()
}

fn pairs_of(
    number: usize,
    contact: &ContactSpec,
    spec: &NetworkSpec,
    (nodes, moves): (&[Vector3<f64>], &[bool]),
) -> Option<CloseAtStart> {
    let elements = elements(contact, spec);
    let at = |element: &Element| element.nodes.iter().map(|n| nodes[*n as usize]).collect::<Vec<_>>();
    let places: Vec<Vec<Vector3<f64>>> = elements.iter().map(at).collect();
    let around = |corners: &Vec<Vector3<f64>>| {
        let corners: Vec<[f64; 3]> = corners.iter().map(|x| (*x).into()).collect();
        Bounds::of(&corners).grown(0.5 * contact.gap)
    };
    let boxes: Vec<Bounds> = places.iter().map(around).collect();
    let mut looks = LOOKS.saturating_mul(elements.len() as u64).max(LEAST_LOOKS);
    let (mut pairs, mut closest): (usize, Option<(f64, [u32; 2])>) = (0, None);
    BoxTree::new(&boxes).pairs(&mut looks, |a, b, looks| {
        let pair = [a.min(b), a.max(b)];
        let [one, two] = pair.map(|element| &elements[element as usize]);
        let sides = one.of[0] && two.of[1] || one.of[1] && two.of[0];
        let held = one.nodes.iter().chain(&two.nodes).all(|node| moves.get(*node as usize) == Some(&false));
        if !sides || held || one.nodes.iter().any(|node| two.nodes.contains(node)) {
            return;
        }
        *looks = looks.saturating_sub(LOOKS_OF_DISTANCE);
        let distance = between(pair.map(|element| &places[element as usize][..]));
        if distance < contact.gap {
            pairs += 1;
            let nearer = closest.is_none_or(|(least, first)| distance < least || distance == least && pair < first);
            closest = if nearer { Some((distance, pair)) } else { closest };
        }
    });
    let (distance, pair) = closest?;
    let closest = pair.map(|element| elements[element as usize].nodes.clone());
    Some(CloseAtStart { contact: number, gap: contact.gap, pairs, complete: looks > 0, closest, distance })
}

impl fmt::Display for CloseAtStart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let CloseAtStart { contact, gap, pairs, complete, closest, distance } = self;
        let [one, two] = closest.each_ref().map(|nodes| match nodes[..] {
            [a, b, c] => format!("the triangle of nodes {a}, {b} and {c}"),
            [a, b] => format!("the line of nodes {a} and {b}"),
            _ => format!("node {}", nodes.first().copied().unwrap_or_default()),
        });
        let apart = match distance {
            0.0 => "which meet or pass through each other".to_owned(),
            distance => format!("{} m apart", figures(*distance, 3)),
        };
        let least = if *complete { "" } else { "at least " };
        write!(
            f,
            "contact {contact}: {least}{} closer at the start than the gap of {} m, so that they push each other apart \
             at once; the closest are {one} and {two}, {apart}: place them apart, or make the gap smaller",
            counted(*pairs as u64, "pair of its parts is", "pairs of its parts are"),
            figures(*gap, 3)
        )
    }
}

impl From<CloseAtStart> for Warning {
    fn from(found: CloseAtStart) -> Self {
        Warning::new(WarningCode::ContactAtStart, found.to_string())
    }
}

/// Parts in words: "2 triangles, 1 line".
pub fn counted_parts(parts: &ContactParts) -> String {
    let counts = [
        (parts.triangles.len(), "triangle", "triangles"),
        (parts.edges.len(), "line", "lines"),
        (parts.nodes.len(), "node", "nodes"),
    ];
    let some = counts.into_iter().filter(|(count, ..)| *count > 0);
    let some: Vec<String> = some.map(|(count, one, many)| counted(count as u64, one, many)).collect();
    if some.is_empty() { "nothing".to_owned() } else { some.join(", ") }
}
