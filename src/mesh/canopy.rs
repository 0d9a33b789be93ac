//! A canopy among the parts of a mesh: its triangles, the closed loop of its skirt, its axis.

use super::Mesh;
use super::components::components;
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashMap};

/// [-] length of the axis over the canopy's extent below which it has no direction
const LEAST_AXIS: f64 = 1e-6;

/// The parts of a mesh that a canopy is made of.
#[derive(Clone, Copy, Debug)]
pub struct CanopyParts<'a> {
    /// triangles of the canopy
    pub triangles: &'a [u32],
    /// edges along the skirt
    pub skirt: &'a [u32],
    /// nodes of the apex, or around the vent
    pub apex: &'a [u32],
    /// nodes where the lines meet
    pub confluence: &'a [u32],
}

/// A canopy that has passed the checks.
#[derive(Clone, Debug, PartialEq)]
pub struct Canopy {
    /// nodes of the skirt in the order of its loop, as the triangles turn
    pub skirt: Vec<u32>,
    /// unit vector from the confluence to the apex on the mesh as given
    pub axis: [f64; 3],
}

/// Why parts of a mesh are no canopy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CanopyError {
    /// Two neighbours turn opposite ways.
    #[error(
        "triangles {first} and {second} of the canopy share the edge {a}-{b} but turn opposite ways, so the pressure inside \
         has no side; turn all its triangles so that their normals point outwards"
    )]
    Orientation {
        /// first triangle
        first: u32,
        /// second triangle
        second: u32,
        /// nodes of the edge
        a: u32,
        /// nodes of the edge
        b: u32,
    },
    /// The skirt's edges are no single closed loop.
    #[error(
        "the skirt is no closed loop: {edges} of its edges meet at node {node}, where there must be two; list every edge \
         along the canopy's lower boundary once"
    )]
    OpenSkirt {
        /// the node
        node: u32,
        /// skirt edges there
        edges: usize,
    },
    /// The skirt's edges are several loops, or none.
    #[error("the skirt is no single loop: from node {node} {found} of its {edges} edges are reached")]
    SeveralLoops {
        /// where the search began
        node: u32,
        /// edges of the loop there
        found: usize,
        /// edges of the skirt
        edges: usize,
    },
    /// A skirt edge is not at the boundary of the canopy.
    #[error(
        "the skirt's edge {a}-{b} is a side of {triangles} triangles of the canopy; the skirt is its boundary, so it must be one"
    )]
    NoBoundary {
        /// nodes of the edge
        a: u32,
        /// nodes of the edge
        b: u32,
        /// triangles there
        triangles: usize,
    },
    /// The payload does not hang on the canopy.
    #[error("the payload has no line: no edges join its node {node} to the canopy; add lines from the skirt to it")]
    LoosePayload {
        /// a node of the payload
        node: u32,
    },
    /// Apex and confluence coincide.
    #[error(
        "the canopy has no axis: its apex and the confluence of its lines are {distance:.3e} m apart; the axis leads from \
         one to the other, so move the confluence below the canopy"
    )]
    NoAxis {
        /// [m] distance
        distance: f64,
    },
}

impl Canopy {
    /// Checks the parts of a canopy: triangles that turn the same way, one closed loop as its skirt, and an axis.
    ///
    /// # Errors
    /// The first of these that does not hold.
    pub fn of(mesh: &Mesh, parts: CanopyParts<'_>) -> Result<Self, CanopyError> {
        let sides = directed_sides(mesh, parts.triangles)?;
        let skirt = closed_loop(mesh, parts.skirt, &sides)?;
        let mean = |nodes: &[u32]| {
            let points = nodes.iter().filter(|node| (**node as usize) < mesh.nodes.len()).map(|node| mesh.point(*node));
            points.sum::<Vector3<f64>>() / nodes.len().max(1) as f64
        };
        let along = mean(parts.apex) - mean(parts.confluence);
        let extent = skirt.iter().map(|node| (mesh.point(*node) - mean(parts.apex)).norm()).fold(0.0, f64::max);
        let distance = along.norm();
        if distance <= LEAST_AXIS * extent || !distance.is_finite() {
            return Err(CanopyError::NoAxis { distance });
        }
        Ok(Self { skirt, axis: (along / distance).into() })
    }

    /// The canopy of a mesh with the groups `canopy`, `skirt`, `apex` or `vent`, and `confluence`; `None` if it lacks one.
    /// A group `payload` must hang on it.
    ///
    /// # Errors
    /// As [`Canopy::of`].
    pub fn of_groups(mesh: &Mesh) -> Option<Result<Self, CanopyError>> {
        let group = |name: &str| mesh.groups.get(name);
        let apex = group("apex").or_else(|| group("vent"))?.select_nodes(mesh);
        let confluence = group("confluence")?.select_nodes(mesh);
        let (canopy, skirt) = (group("canopy")?, group("skirt")?.select_edges(mesh));
        let parts = CanopyParts { triangles: &canopy.triangles, skirt: &skirt, apex: &apex, confluence: &confluence };
        let found = Self::of(mesh, parts);
        Some(found.and_then(|canopy| match loose_payload(mesh, canopy.skirt.first().copied()) {
            Some(node) => Err(CanopyError::LoosePayload { node }),
            None => Ok(canopy),
        }))
    }
}

/// A node of the group `payload` that nothing joins to the skirt.
fn loose_payload(mesh: &Mesh, skirt: Option<u32>) -> Option<u32> {
    let payload = mesh.groups.get("payload")?.select_nodes(mesh);
    let across = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
    let component = components(mesh.nodes.len(), mesh.edges.iter().copied().chain(across));
    let of = |node: u32| component.get(node as usize);
    payload.into_iter().find(|node| of(*node) != skirt.and_then(of))
}

/// The sides of the canopy's triangles, as each triangle goes along them, with the triangle.
type DirectedSides = HashMap<[u32; 2], u32>;

fn directed_sides(mesh: &Mesh, triangles: &[u32]) -> Result<DirectedSides, CanopyError> {
    let mut sides = DirectedSides::new();
    for &triangle in triangles {
        let Some(&[a, b, c]) = mesh.triangles.get(triangle as usize) else { continue };
        for side in [[a, b], [b, c], [c, a]] {
            if let Some(first) = sides.insert(side, triangle) {
                let [a, b] = [side[0].min(side[1]), side[0].max(side[1])];
                return Err(CanopyError::Orientation { first, second: triangle, a, b });
            }
        }
    }
    Ok(sides)
}

/// The nodes of the skirt one after the other, in the direction of the triangles.
fn closed_loop(mesh: &Mesh, skirt: &[u32], sides: &DirectedSides) -> Result<Vec<u32>, CanopyError> {
    let mut next: BTreeMap<u32, u32> = BTreeMap::new();
    let mut degree: BTreeMap<u32, usize> = BTreeMap::new();
    for &[a, b] in skirt.iter().filter_map(|&edge| mesh.edges.get(edge as usize)) {
        let (forward, backward) = (sides.contains_key(&[a, b]), sides.contains_key(&[b, a]));
        if forward == backward {
            return Err(CanopyError::NoBoundary { a, b, triangles: usize::from(forward) + usize::from(backward) });
        }
        let [from, to] = if forward { [a, b] } else { [b, a] };
        next.insert(from, to);
        [a, b].into_iter().for_each(|node| *degree.entry(node).or_default() += 1);
    }
    if let Some((&node, &edges)) = degree.iter().find(|(_, edges)| **edges != 2) {
        return Err(CanopyError::OpenSkirt { node, edges });
    }
    let first = next.keys().next().copied().unwrap_or_default();
    let mut nodes = vec![first];
    while let Some(&node) = nodes.last().and_then(|node| next.get(node)).filter(|node| **node != first) {
        nodes.push(node);
        if nodes.len() > next.len() {
            break;
        }
    }
    if nodes.len() != skirt.len() {
        return Err(CanopyError::SeveralLoops { node: first, found: nodes.len(), edges: skirt.len() });
    }
    Ok(nodes)
}
