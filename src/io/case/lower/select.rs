//! Selections of nodes, edges and triangles: from words to ascending numbers. An empty selection is a fault.

use nalgebra::Vector3;

use super::geometry::Geometry;
use super::point::Whole;
use crate::case::diagnostics::{Faults, did_you_mean, one_of};
use crate::case::pointer::Pointer;
use crate::case::schema::{EdgeSelection, NodeSelection};
use crate::mesh::{EdgeKind, Group};

/// The nodes that a probe may name.
#[derive(Clone, Copy, Debug)]
pub(super) enum NodeSet<'a> {
    /// of a network
    Mesh(&'a Geometry),
    /// of the network that a point stands for
    Point(&'a Geometry, &'a Whole),
    /// the bob of a pendulum
    Bob,
    /// unknown, because the mesh is faulty
    Unknown,
}

impl NodeSet<'_> {
    /// The selected nodes, ascending; `None` with a fault if there are none, and without a fault if the mesh is
    /// unknown.
    pub(super) fn select(self, at: &Pointer, selection: &NodeSelection, faults: &mut Faults<'_>) -> Option<Vec<u32>> {
        match self {
            Self::Mesh(geometry) => nodes(at, selection, geometry, faults),
            Self::Point(geometry, whole) => {
                let found = nodes(at, selection, geometry, faults)?;
                if !whole.is_point(&found) {
                    faults.add_hint(at, "the payload, or all nodes", "a point has no other nodes");
                    return None;
                }
                Some(vec![0])
            }
            Self::Unknown => None,
            Self::Bob => match selection {
                NodeSelection::All => Some(vec![0]),
                NodeSelection::Ids(list) => ids(&at.key("ids"), list, Range { what: "node", count: 1 }, faults),
                _ => {
                    faults.add(at, "\"all\" or {\"ids\": [0]}: a pendulum has one node, its bob");
                    None
                }
            },
        }
    }
}

/// The selected nodes of a mesh, ascending.
pub(super) fn nodes(
    at: &Pointer,
    selection: &NodeSelection,
    geometry: &Geometry,
    faults: &mut Faults<'_>,
) -> Option<Vec<u32>> {
    let topology = &geometry.topology;
    let inside = |test: &dyn Fn(Vector3<f64>) -> bool| {
        let hits = geometry.mesh.nodes.iter().zip(0_u32..).filter(|(p, _)| test(Vector3::from(**p)));
        hits.map(|(_, i)| i).collect::<Vec<_>>()
    };
    let found = match selection {
        NodeSelection::Ids(list) => {
            return ids(&at.key("ids"), list, Range { what: "node", count: geometry.nodes() }, faults);
        }
        NodeSelection::Group(name) => {
            return group(&at.key("group"), name, geometry, faults).map(|group| group.select_nodes(&geometry.mesh));
        }
        NodeSelection::Except(both) => {
            let of = nodes(&at.key("of"), &both.of, geometry, faults);
            let except = nodes(&at.key("except"), &both.except, geometry, faults);
            return without(at, "node", (of?, except?), faults);
        }
        NodeSelection::All => inside(&|_| true),
        NodeSelection::Boundary => topology.boundary_nodes().to_vec(),
        NodeSelection::Outer => topology.outer_nodes().to_vec(),
        NodeSelection::Inner => topology.inner_nodes().to_vec(),
        NodeSelection::Box([low, high]) => {
            let (low, high) = (Vector3::from(*low), Vector3::from(*high));
            let rises = low <= high;
            if !rises {
                faults.add(&at.key("box"), "the lowest corner first, then the highest");
                return None;
            }
            inside(&|p| low <= p && p <= high)
        }
        NodeSelection::Sphere(ball) => {
            if faults.unread(&at.key("sphere").key("radius")) {
                return None;
            }
            let center = Vector3::from(ball.center);
            inside(&|p| (p - center).norm() <= ball.radius)
        }
    };
    if found.is_empty() {
        let counts = format!(
            "this mesh has {} nodes, {} of them \"boundary\", {} \"outer\", {} \"inner\"{}",
            geometry.nodes(),
            topology.boundary_nodes().len(),
            topology.outer_nodes().len(),
            topology.inner_nodes().len(),
            extent(&geometry.mesh.nodes)
        );
        faults.add_hint(at, "a selection of at least one node", counts);
        return None;
    }
    Some(found)
}

/// The group with this name; a name that no group has is a fault.
fn group<'a>(at: &Pointer, name: &str, geometry: &'a Geometry, faults: &mut Faults<'_>) -> Option<&'a Group> {
    let groups = &geometry.mesh.groups;
    let found = groups.get(name);
    if found.is_none() {
        let names: Vec<&str> = groups.keys().map(String::as_str).collect();
        let allowed = match names.as_slice() {
            [] => "another selection: this mesh has no groups".to_owned(),
            _ => one_of("groups of this mesh", &names),
        };
        let hint = did_you_mean(name, names).unwrap_or_default();
        faults.add_hint(at, allowed, hint);
    }
    found
}

/// Adds the fault of a group that has no members of the kind that is needed.
fn refuse_group(at: &Pointer, group: &Group, what: &str, faults: &mut Faults<'_>) {
    let hint = format!("it has {}", group.describe());
    faults.add_hint(at, format!("a group with {what}"), hint);
}

/// The extent of the nodes, for a box or sphere that contains none.
fn extent(nodes: &[[f64; 3]]) -> String {
    let Some(first) = nodes.first().map(|p| Vector3::from(*p)) else { return String::new() };
    let (low, high) = nodes.iter().map(|p| Vector3::from(*p)).fold((first, first), |(l, h), p| (l.inf(&p), h.sup(&p)));
    format!("; they lie between {:?} and {:?}", low.as_slice(), high.as_slice())
}

/// What is left of ascending numbers without others. Nothing that is taken away, and nothing that is left, is a fault.
fn without(at: &Pointer, what: &str, (of, except): (Vec<u32>, Vec<u32>), faults: &mut Faults<'_>) -> Option<Vec<u32>> {
    let left: Vec<u32> = of.iter().copied().filter(|one| except.binary_search(one).is_err()).collect();
    match left.len() {
        0 => {
            let value = format!("\"except\" has all {} {what}s of \"of\"", of.len());
            faults.add_value(at, value, format!("a selection of at least one {what}"), None);
            None
        }
        n if n == of.len() => {
            let hint = format!("leave \"except\" out, or name {what}s that are in \"of\"");
            let value = format!("\"except\" has no {what} of \"of\"");
            faults.add_value(&at.key("except"), value, format!("some of the {n} {what}s of \"of\""), Some(hint));
            None
        }
        _ => Some(left),
    }
}

/// Which edges a rule selects, `[n_edges]`.
pub(super) fn edges(
    at: &Pointer,
    selection: &EdgeSelection,
    geometry: &Geometry,
    faults: &mut Faults<'_>,
) -> Option<Vec<bool>> {
    let count = geometry.mesh.edges.len();
    let of_kind = |kind: EdgeKind| (0..count).map(|i| geometry.topology.edge_kind(i) == kind).collect::<Vec<_>>();
    let flagged = |list: &[u32]| {
        let mut flags = vec![false; count];
        for &i in list {
            if let Some(flag) = flags.get_mut(i as usize) {
                *flag = true;
            }
        }
        flags
    };
    let found = match selection {
        EdgeSelection::All => vec![true; count],
        EdgeSelection::Boundary => of_kind(EdgeKind::Boundary),
        EdgeSelection::Interior => of_kind(EdgeKind::Interior),
        EdgeSelection::Lines => of_kind(EdgeKind::Line),
        EdgeSelection::Seams => flagged(&geometry.mesh.seams),
        EdgeSelection::Ids(list) => flagged(&ids(&at.key("ids"), list, Range { what: "edge", count }, faults)?),
        EdgeSelection::Group(name) => {
            let group = group(&at.key("group"), name, geometry, faults)?;
            let edges = group.select_edges(&geometry.mesh);
            if edges.is_empty() {
                refuse_group(&at.key("group"), group, "edges or triangles", faults);
                return None;
            }
            flagged(&edges)
        }
        EdgeSelection::Except(both) => {
            let of = edges(&at.key("of"), &both.of, geometry, faults);
            let except = edges(&at.key("except"), &both.except, geometry, faults);
            let listed = |flags: Vec<bool>| (0_u32..).zip(flags).filter(|(_, on)| *on).map(|(edge, _)| edge).collect();
            flagged(&without(at, "edge", (listed(of?), listed(except?)), faults)?)
        }
    };
    if !found.contains(&true) {
        let number = |kind: EdgeKind| of_kind(kind).iter().filter(|hit| **hit).count();
        let counts = format!(
            "this mesh has {count} edges, {} of them \"boundary\", {} \"interior\", {} \"lines\", {} \"seams\"",
            number(EdgeKind::Boundary),
            number(EdgeKind::Interior),
            number(EdgeKind::Line),
            geometry.mesh.seams.len()
        );
        faults.add_hint(at, "a selection of at least one edge", counts);
        return None;
    }
    Some(found)
}

/// The triangles of a pressure, ascending.
pub(super) fn triangles(
    at: &Pointer,
    selection: &NodeSelection,
    geometry: &Geometry,
    faults: &mut Faults<'_>,
) -> Option<Vec<u32>> {
    let count = geometry.mesh.triangles.len();
    match selection {
        NodeSelection::All => Some((0_u32..).take(count).collect()),
        NodeSelection::Ids(list) => ids(&at.key("ids"), list, Range { what: "triangle", count }, faults),
        NodeSelection::Group(name) => triangles_of_group(&at.key("group"), name, geometry, faults),
        NodeSelection::Except(both) => {
            let of = triangles(&at.key("of"), &both.of, geometry, faults);
            let except = triangles(&at.key("except"), &both.except, geometry, faults);
            without(at, "triangle", (of?, except?), faults)
        }
        other => {
            let word = other.keyword();
            faults.add_hint(
                at,
                "\"all\", {\"ids\": [...]} or {\"group\": ...}: a pressure acts on triangles",
                format!("\"{word}\" selects nodes, as only a force can"),
            );
            None
        }
    }
}

/// The triangles of a group that is named at `at`, ascending.
pub(super) fn triangles_of_group(
    at: &Pointer,
    name: &str,
    geometry: &Geometry,
    faults: &mut Faults<'_>,
) -> Option<Vec<u32>> {
    let group = group(at, name, geometry, faults)?;
    if group.triangles.is_empty() {
        refuse_group(at, group, "triangles", faults);
        return None;
    }
    Some(group.triangles.clone())
}

/// The kind of object that ids number.
#[derive(Clone, Copy)]
struct Range {
    what: &'static str,
    count: usize,
}

/// Checks a list of ids: in range, sorted, each once.
fn ids(at: &Pointer, list: &[u32], range: Range, faults: &mut Faults<'_>) -> Option<Vec<u32>> {
    let Range { what, count } = range;
    if list.is_empty() {
        faults.add(at, format!("at least one {what}"));
        return None;
    }
    let before = faults.count();
    let allowed = match count.checked_sub(1) {
        Some(last) => format!("{what} numbers from 0 to {last}"),
        None => format!("nothing: the mesh has no {what}s"),
    };
    for (i, _) in list.iter().enumerate().filter(|(_, id)| **id as usize >= count) {
        faults.add(&at.index(i), allowed.clone());
    }
    let mut sorted = list.to_vec();
    sorted.sort_unstable();
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        faults.add_value(at, format!("{what} {} twice", pair[0]), format!("every {what} once"), None);
    }
    (faults.count() == before).then_some(sorted)
}
