//! A mesh listed node by node in the case.

use super::source::{FaultSink, MAX_NODES};
use super::{Groups, Mesh, MeshError, topology};
use serde::{Deserialize, Serialize};

/// Number of faults reported per list; one line gives the number of the rest.
const MOST_REPORTED: usize = 20;

/// Nodes, springs and triangles as lists.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ExplicitMesh {
    /// [m] positions
    pub nodes: Vec<[f64; 3]>,
    /// pairs of nodes, counted from 0; these are the edges, in this order. Absent: the edges of the triangles
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub springs: Option<Vec<[u32; 2]>>,
    /// triples of nodes, counted from 0, counter-clockwise seen from the side the normal points to
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub triangles: Vec<[u32; 3]>,
    /// named parts of the mesh, which `{"group": name}` selects; numbers ascend
    #[serde(default, skip_serializing_if = "Groups::is_empty")]
    pub groups: Groups,
}

impl ExplicitMesh {
    /// Reports every value out of range; `at` is the JSON pointer of this section.
    pub fn check(&self, at: &str, faults: FaultSink<'_>) {
        if self.nodes.is_empty() || self.nodes.len() > MAX_NODES {
            let (value, allowed) = (format!("{} nodes", self.nodes.len()), format!("1 to {MAX_NODES} nodes"));
            faults(&format!("{at}/nodes"), value, allowed, "list the positions of the nodes".into());
        }
        let finite =
            |p: &[f64; 3]| if p.iter().all(|c| c.is_finite()) { None } else { Some("finite numbers".to_owned()) };
        report(&format!("{at}/nodes"), &self.nodes, finite, faults);
        report(&format!("{at}/springs"), self.springs.as_deref().unwrap_or_default(), |s| self.fault_of(s), faults);
        report(&format!("{at}/triangles"), &self.triangles, |t| self.fault_of(t), faults);
    }

    /// What is wrong with the nodes of a spring or triangle.
    fn fault_of(&self, corners: &[u32]) -> Option<String> {
        let n = self.nodes.len();
        if corners.iter().any(|&c| c as usize >= n) {
            return Some(format!("nodes 0 to {}", n.saturating_sub(1)));
        }
        let repeated = (1..corners.len()).any(|i| corners[..i].contains(&corners[i]));
        repeated.then(|| "different nodes".to_owned())
    }

    /// Makes the mesh.
    ///
    /// # Errors
    /// Whatever [`Mesh::check`] finds: numbers out of range, repeated nodes, the same edge or triangle twice.
    pub fn build(&self) -> Result<Mesh, MeshError> {
        let edges = self.springs.clone().unwrap_or_else(|| topology::unique_edges(&self.triangles));
        let (nodes, triangles, groups) = (self.nodes.clone(), self.triangles.clone(), self.groups.clone());
        let mesh = Mesh { nodes, edges, triangles, groups, ..Mesh::default() };
        mesh.check()?;
        Ok(mesh)
    }
}

/// Reports the faulty items of a list, and how many more there are.
fn report<T: std::fmt::Debug>(at: &str, items: &[T], fault: impl Fn(&T) -> Option<String>, faults: FaultSink<'_>) {
    let mut found = 0_usize;
    for (i, item) in items.iter().enumerate() {
        if let Some(allowed) = fault(item) {
            found += 1;
            if found <= MOST_REPORTED {
                faults(&format!("{at}/{i}"), format!("{item:?}"), allowed, "correct this entry".into());
            }
        }
    }
    if found > MOST_REPORTED {
        let value = format!("{} more entries", found - MOST_REPORTED);
        faults(at, value, "as above".into(), "correct those first, the rest may have the same cause".into());
    }
}
