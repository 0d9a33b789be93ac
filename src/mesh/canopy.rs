//! A canopy among the parts of a mesh: a sheet of triangles that turn the same way, the closed loop of its skirt, its
//! apex, its axis. Cases and `mesh inspect` find canopies here.

mod error;
mod sheet;

use super::components::components;
use super::{Group, Mesh};
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};

pub use error::{CanopyError, CanopyPart};
use sheet::Sheet;

/// [-] Distance from the apex to the confluence, over the root of the canopy's area, below which there is no axis.
const LEAST_AXIS: f64 = 1e-3;
/// [-] Largest part of the area of cloth, gaps and vent that the vent may take.
const MOST_VENT: f64 = 0.5;

/// The parts of a mesh that a canopy is made of.
#[derive(Clone, Copy, Debug, Default)]
pub struct CanopyParts<'a> {
    /// triangles of the canopy
    pub triangles: &'a [u32],
    /// all edges along the skirt; empty if it is not known by edges
    pub skirt_edges: &'a [u32],
    /// nodes that stand for the skirt, all of it or some; empty: those of its loop, which is the outer boundary if no
    /// edges are given
    pub skirt_nodes: &'a [u32],
    /// nodes where the lines meet; empty for a canopy without lines
    pub confluence: &'a [u32],
}

/// A canopy that has passed the checks.
#[derive(Clone, Debug, PartialEq)]
pub struct Canopy {
    /// nodes that stand for the skirt: those given, or its loop
    pub skirt: Vec<u32>,
    /// nodes around the vent, or the one that is farthest from the skirt
    pub apex: Vec<u32>,
    /// nodes where the lines meet
    pub confluence: Vec<u32>,
    /// [-] by node of the mesh: its arc length over the canopy, from 0 at the apex to 1 at the skirt
    pub place: Vec<f64>,
    /// [m^2] area of the triangles
    pub cloth_area: f64,
    /// [m^2] nominal area S0: cloth, gaps between its parts, and flat covers of its vents
    pub nominal_area: f64,
    /// [m] the longest side of a triangle
    pub longest_edge: f64,
}

/// The sizes of a canopy.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct CanopySizes {
    /// [m^2] nominal area S0: cloth, gaps and flat covers of vents
    pub nominal_area: f64,
    /// [m] nominal diameter D0 of a circle with this area
    pub nominal_diameter: f64,
    /// [m^2] area of the cloth
    pub cloth_area: f64,
    /// [m] the longest edge of the cloth
    pub longest_edge: f64,
}

impl std::fmt::Display for CanopySizes {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { nominal_area, nominal_diameter, cloth_area, longest_edge } = self;
        let (open, fineness) = (100.0 * (1.0 - cloth_area / nominal_area).max(0.0), longest_edge / nominal_diameter);
        write!(
            f,
            "S0 {nominal_area:.6} m^2, D0 {nominal_diameter:.6} m, cloth {cloth_area:.6} m^2, {open:.2} % of S0 open, \
             longest edge of the cloth {longest_edge:.6} m ({fineness:.4} D0)"
        )
    }
}

impl Canopy {
    /// Checks the parts of a canopy: triangles that turn the same way and hang together, one closed loop of their
    /// boundary as the skirt, more cloth than vent, and a confluence that is no part of it. Its axis depends on where
    /// it starts; see [`Canopy::axis`].
    ///
    /// # Errors
    /// The first of these that does not hold.
    pub fn of(mesh: &Mesh, parts: CanopyParts<'_>) -> Result<Self, CanopyError> {
        let sheet = Sheet::new(mesh, parts.triangles)?;
        let around = match (parts.skirt_edges, parts.skirt_nodes) {
            ([], []) => sheet.outer_boundary()?.to_vec(),
            ([], nodes) => sheet.loop_through(nodes)?.to_vec(),
            (edges, _) => closed_loop(mesh, edges, &sheet)?,
        };
        let skirt = if parts.skirt_nodes.is_empty() { around.clone() } else { parts.skirt_nodes.to_vec() };
        if let Some(&node) = parts.confluence.iter().find(|&&node| sheet.has(node)) {
            return Err(CanopyError::ConfluenceInCanopy { node });
        }
        let (apex, place) = sheet.arc_lengths(&skirt, &around)?;
        let (cloth_area, [gaps, vents]) = (sheet.cloth_area(), sheet.openings(&around));
        let nominal_area = cloth_area + gaps + vents;
        if vents > MOST_VENT * nominal_area {
            return Err(CanopyError::MoreVent { vent: vents, nominal: nominal_area });
        }
        let (confluence, longest_edge) = (parts.confluence.to_vec(), sheet.longest_edge());
        Ok(Self { skirt, apex, confluence, place, cloth_area, nominal_area, longest_edge })
    }

    /// [m] Nominal diameter D0, of a circle with the nominal area.
    pub fn nominal_diameter(&self) -> f64 {
        (4.0 * self.nominal_area / std::f64::consts::PI).sqrt()
    }

    /// Its sizes.
    pub fn sizes(&self) -> CanopySizes {
        let Self { nominal_area, cloth_area, longest_edge, .. } = *self;
        CanopySizes { nominal_area, nominal_diameter: self.nominal_diameter(), cloth_area, longest_edge }
    }

    /// [m] From the apex to the confluence, for nodes at `place` [m].
    ///
    /// # Errors
    /// Apex and confluence at one place.
    pub fn axis(&self, place: &dyn Fn(u32) -> Vector3<f64>) -> Result<Vector3<f64>, CanopyError> {
        let mean = |nodes: &[u32]| nodes.iter().map(|&node| place(node)).sum::<Vector3<f64>>() / nodes.len() as f64;
        axis([mean(&self.apex), mean(&self.confluence)], self.cloth_area)
    }

    /// The canopies among the groups of a mesh, with the names of their triangles' groups: `canopy`, or each of
    /// `canopy-1`, `canopy-2` and so on, with `skirt` and `confluence` of the same number, if there are such groups.
    /// With lines they have an axis as the mesh starts, and a group `payload` hangs on them.
    ///
    /// # Errors
    /// For each canopy, as [`Canopy::of`], [`Canopy::axis`] and [`loose_payload`].
    pub fn of_groups(mesh: &Mesh) -> BTreeMap<String, Result<Self, CanopyError>> {
        let numbered = (1..).map(|i| format!("-{i}"));
        let mut ends: Vec<String> =
            numbered.take_while(|end| mesh.groups.contains_key(&format!("canopy{end}"))).collect();
        if ends.is_empty() {
            ends.push(String::new());
        }
        let start = |node: u32| {
            let moved = mesh.displacement.get(node as usize).map_or(Vector3::zeros(), |u| Vector3::from(*u));
            mesh.point(node) + moved
        };
        let find = |canopy: &Group, end: &str| {
            let group = |name: &str| mesh.groups.get(&format!("{name}{end}")).or_else(|| mesh.groups.get(name));
            let confluence = group("confluence").map(|group| group.select_nodes(mesh)).unwrap_or_default();
            let skirt = SkirtGroup::of(mesh, group("skirt"), &canopy.triangles);
            let parts = CanopyParts { triangles: &canopy.triangles, confluence: &confluence, ..skirt.parts() };
            let found = Self::of(mesh, parts)?;
            if !confluence.is_empty() {
                found.axis(&start)?;
            }
            Ok(found)
        };
        let named = |end: &String| (format!("canopy{end}"), end.clone());
        let groups = ends.iter().map(named).filter_map(|(name, end)| Some((mesh.groups.get(&name)?, name, end)));
        let mut found: BTreeMap<String, Result<Self, CanopyError>> = groups
            .filter(|(group, ..)| !group.triangles.is_empty())
            .map(|(group, name, end)| (name, find(group, &end)))
            .collect();
        let with_lines = found.values().flatten().filter(|canopy| !canopy.confluence.is_empty());
        if let Err(loose) =
            loose_payload(mesh, mesh.edges.iter().copied(), with_lines.map(|canopy| canopy.skirt.as_slice()))
        {
            found.values_mut().for_each(|canopy| *canopy = canopy.clone().and(Err(loose.clone())));
        }
        found
    }
}

/// The skirt of a canopy as far as a group knows it.
#[derive(Clone, Debug, Default)]
pub struct SkirtGroup {
    edges: Vec<u32>,
    nodes: Vec<u32>,
}

impl SkirtGroup {
    /// What the group has of the canopy with these triangles.
    pub fn of(mesh: &Mesh, group: Option<&Group>, triangles: &[u32]) -> Self {
        let Some(group) = group else { return Self::default() };
        let corners = triangles.iter().filter_map(|&t| mesh.triangles.get(t as usize));
        let has: BTreeSet<u32> = corners.flatten().copied().collect();
        let inside = |edge: &&u32| mesh.edges.get(**edge as usize).is_some_and(|e| e.iter().all(|n| has.contains(n)));
        let edges = group.edges.iter().filter(inside).copied().collect();
        let nodes = group.select_nodes(mesh).into_iter().filter(|node| has.contains(node)).collect();
        Self { edges, nodes }
    }

    /// Its part of a canopy's parts.
    pub fn parts(&self) -> CanopyParts<'_> {
        CanopyParts { skirt_edges: &self.edges, skirt_nodes: &self.nodes, ..CanopyParts::default() }
    }
}

/// [m] From the apex to the confluence [m] of a canopy with an area [m^2].
///
/// # Errors
/// [`CanopyError::NoAxis`] if they are at one place.
pub fn axis([apex, confluence]: [Vector3<f64>; 2], area: f64) -> Result<Vector3<f64>, CanopyError> {
    let axis = confluence - apex;
    let distance = axis.norm();
    match distance > LEAST_AXIS * area.sqrt() {
        true => Ok(axis),
        false => Err(CanopyError::NoAxis { distance }),
    }
}

/// Checks that a group `payload`, if there is one, hangs on one of the canopies, if there are any; of these the nodes
/// of the skirts. Nodes hang together by triangles and by the `joined` pairs.
///
/// # Errors
/// [`CanopyError::LoosePayload`] with the first of its nodes that hangs on no skirt.
pub fn loose_payload<'a>(
    mesh: &Mesh,
    joined: impl Iterator<Item = [u32; 2]>,
    skirts: impl Iterator<Item = &'a [u32]>,
) -> Result<(), CanopyError> {
    let Some(payload) = mesh.groups.get("payload") else { return Ok(()) };
    let across = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
    let component = components(mesh.nodes.len(), joined.chain(across));
    let of = |node: u32| component.get(node as usize).copied();
    let hung: BTreeSet<_> = skirts.filter_map(|skirt| skirt.first().copied().map(of)).collect();
    match payload.select_nodes(mesh).into_iter().find(|node| !hung.contains(&of(*node))) {
        Some(node) if !hung.is_empty() => Err(CanopyError::LoosePayload { node }),
        _ => Ok(()),
    }
}

/// The nodes of the skirt one after the other, from its edges.
fn closed_loop(mesh: &Mesh, skirt: &[u32], sheet: &Sheet<'_>) -> Result<Vec<u32>, CanopyError> {
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for &[a, b] in skirt.iter().filter_map(|&edge| mesh.edges.get(edge as usize)) {
        let triangles = sheet.triangles_at([a, b]);
        if triangles != 1 {
            return Err(CanopyError::NoBoundary { a, b, triangles });
        }
        next.entry(a).or_default().push(b);
        next.entry(b).or_default().push(a);
    }
    if let Some((&node, ends)) = next.iter().find(|(_, ends)| ends.len() != 2) {
        return Err(CanopyError::OpenSkirt { node, edges: ends.len() });
    }
    let first = next.keys().next().copied().unwrap_or_default();
    let (mut nodes, mut before) = (vec![first], first);
    while let Some(&node) = nodes.last()
        && let Some(&to) = next.get(&node).and_then(|ends| ends.iter().find(|to| **to != before))
        && to != first
        && nodes.len() <= next.len()
    {
        before = node;
        nodes.push(to);
    }
    if nodes.len() != skirt.len() {
        return Err(CanopyError::SeveralLoops { node: first, found: nodes.len(), edges: skirt.len() });
    }
    Ok(nodes)
}
