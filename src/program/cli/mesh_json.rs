//! What `mesh inspect --json` prints: the same as the text, for programs.

use super::mesh_output::doubts;
use crate::mesh::box_tree::Bounds;
use crate::mesh::canopy::Canopy;
use crate::mesh::{EdgeKind, Mesh, Quality, Topology};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// JSON text that ends with a line break. Lengths are in metres, angles in degrees; null where a mesh has none.
pub(super) fn to_json(mesh: &Mesh, topology: &Topology, notes: &[String]) -> String {
    let quality = Quality::with_topology(mesh, topology);
    let count = |kind| (0..mesh.edges.len()).filter(|&e| topology.edge_kind(e) == kind).count();
    let loops = topology.loops().iter().map(|l| {
        json!({"outer": l.outer, "closed": l.closed, "nodes": l.nodes.len(), "length": l.length, "extent": l.extent})
    });
    let groups = mesh.groups.iter().map(|(name, group)| {
        let value = json!({
            "nodes": group.nodes.len(), "edges": group.edges.len(), "triangles": group.triangles.len(),
            "length": group.length(mesh), "area": group.area(mesh)
        });
        (name, value)
    });
    let Bounds { low, high } = Bounds::of(&mesh.nodes);
    let canopies: BTreeMap<String, Value> = Canopy::of_groups(mesh)
        .into_iter()
        .filter_map(|(name, canopy)| Some((name, json!(canopy.ok()?.sizes()))))
        .collect();
    let value = json!({
        "nodes": mesh.nodes.len(),
        "edges": {
            "all": mesh.edges.len(),
            "boundary": count(EdgeKind::Boundary),
            "interior": count(EdgeKind::Interior),
            "lines": count(EdgeKind::Line),
            "seams": mesh.seams.len(),
        },
        "triangles": mesh.triangles.len(),
        "components": quality.components,
        "euler_characteristic": quality.euler_characteristic,
        "box": {"low": low, "high": high},
        "loops": loops.collect::<Vec<_>>(),
        "edge_length": {"min": quality.min_edge, "max": quality.max_edge, "mean": quality.mean_edge},
        "angle": {"min": quality.min_angle, "max": quality.max_angle, "mean_smallest": quality.mean_min_angle},
        "angle_histogram": quality.angle_histogram,
        "radius_ratio": {"min": quality.min_radius_ratio, "mean": quality.mean_radius_ratio},
        "area": {"all": quality.total_area, "min": quality.min_area},
        "groups": groups.collect::<BTreeMap<_, _>>(),
        "canopies": canopies,
        "notes": doubts(mesh, topology, notes),
    });
    // Printing a value cannot fail.
    serde_json::to_string_pretty(&value).unwrap_or_else(|_| value.to_string()) + "\n"
}
