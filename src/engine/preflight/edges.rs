//! Edges at which more than two triangles under pressure meet.

use std::fmt;

use crate::format_number::first_few;
use crate::mesh::Topology;
use crate::model::spec::{NetworkSpec, PressureKind};
use crate::warning::{Warning, WarningCode};

/// An edge of three or more triangles under pressure: the sheet has no two sides there.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BranchingEdges {
    /// nodes of the first such edge
    pub edge: [u32; 2],
    /// triangles there, ascending
    pub triangles: Vec<u32>,
    /// [-] number of such edges
    pub edges: usize,
}

/// Finds edges of three or more triangles on which the air or a pressure along their normals acts.
pub fn branching(spec: &NetworkSpec, topology: &Topology) -> Option<BranchingEdges> {
    let along_normals =
        spec.pressures.iter().filter(|load| !matches!(load.kind, PressureKind::Dead(Some(_)) | PressureKind::Plan(_)));
    let mut pressed = vec![spec.air.is_some(); spec.mesh.triangles.len()];
    let canopies = spec.canopies.iter().flat_map(|canopy| &canopy.triangles);
    let zones = spec.surface_pressures.iter().flat_map(|zone| &zone.triangles);
    // A wall between two gases is around both of them.
    for triangle in along_normals.flat_map(|load| &load.triangles).chain(canopies).chain(zones) {
        if let Some(flag) = pressed.get_mut(*triangle as usize) {
            *flag = true;
        }
    }
    let mut found = topology.branching_edges().filter_map(|(edge, triangles)| {
        let under = triangles.iter().copied().filter(|t| pressed.get(*t as usize) == Some(&true));
        let under: Vec<u32> = under.collect();
        (under.len() > 2).then_some((edge, under))
    });
    let (edge, triangles) = found.next()?;
    Some(BranchingEdges { edge, triangles, edges: 1 + found.count() })
}

impl fmt::Display for BranchingEdges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.edge;
        let more = if self.edges > 1 { format!(" (the first of {} such edges)", self.edges) } else { String::new() };
        write!(
            f,
            "triangles {} with pressure meet at the edge of nodes {a} and {b}{more}: the cloth has no two sides there, so their \
             pressures do not belong to one flow; cut the sheet there, or take the pressure off one of them",
            first_few(&self.triangles)
        )
    }
}

impl From<BranchingEdges> for Warning {
    fn from(found: BranchingEdges) -> Self {
        Warning::new(WarningCode::BranchingEdge, found.to_string())
    }
}
