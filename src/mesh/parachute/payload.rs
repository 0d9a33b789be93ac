//! What hangs at the end of the riser: a rigid payload, and several canopies that share it.

use super::{ClusterParameters, ParachuteParameters, PayloadParameters};
use crate::source::{FaultSink, check_length};
use crate::{Group, Groups, Mesh, MeshError};
use nalgebra::{Rotation3, Unit, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// [-] angle between canopies of a cluster over the one at which they touch
const APART: f64 = 1.05;
/// [rad] largest angle of a canopy's axis from the vertical
const MOST_TILT: f64 = 1.4;

impl PayloadParameters {
    pub(super) fn check(&self, at: &str, faults: FaultSink<'_>) {
        let positive = |v: &[f64; 3]| v.iter().all(|c| c.is_finite() && *c > 0.0);
        match (self.sides, self.radii_of_gyration) {
            (Some(sides), None) if !positive(&sides) => {
                faults(
                    &format!("{at}/box"),
                    format!("{sides:?}"),
                    "three lengths above 0".into(),
                    "give metres".into(),
                );
            }
            (None, Some(radii)) if !positive(&radii) || self.half_axes().is_none() => {
                let allowed =
                    "three lengths above 0, the square of each below the sum of the other two squares".to_owned();
                let hint = "no body has other moments of inertia".to_owned();
                faults(&format!("{at}/radii_of_gyration"), format!("{radii:?}"), allowed, hint);
            }
            (Some(_), None) | (None, Some(_)) => {}
            _ => {
                let hint = "keep or add one".to_owned();
                faults(at, "its size".into(), "exactly one of box and radii_of_gyration".into(), hint);
            }
        }
        check_length(at, "below_riser", self.below_riser, faults);
        if let Some([_, _, height]) =
            self.half_axes().filter(|axes| self.below_riser > 0.0 && axes[2] >= self.below_riser)
        {
            let allowed = format!("above {height:.6}, the half height of the particles");
            let hint = "lower the payload: its slings must pull upwards".to_owned();
            faults(&format!("{at}/below_riser"), self.below_riser.to_string(), allowed, hint);
        }
    }

    /// [m] Distances of the particles from the centre along x, y and z: a_x^2 = (k_y^2 + k_z^2 - k_x^2)/2 of the radii
    /// of gyration k, and cyclic; `None` if no body has these.
    pub(crate) fn half_axes(&self) -> Option<[f64; 3]> {
        let squares = match (self.sides, self.radii_of_gyration) {
            (Some(sides), _) => sides.map(|side| side * side / 12.0),
            (None, Some(radii)) => {
                let [x, y, z] = radii.map(|k| k * k);
                [y + z - x, z + x - y, x + y - z].map(|sum| 0.5 * sum)
            }
            (None, None) => return None,
        };
        squares.iter().all(|s| *s > 0.0).then(|| squares.map(f64::sqrt))
    }
}

/// The node at the end of the riser.
fn end_of(mesh: &Mesh) -> Option<u32> {
    mesh.groups.get("payload").and_then(|group| group.nodes.first()).copied()
}

/// Puts a rigid payload in the place of the point at the end of the riser.
pub(super) fn hang(mesh: &mut Mesh, payload: &PayloadParameters) {
    let (Some(end), Some(axes)) = (end_of(mesh), payload.half_axes()) else { return };
    let centre = mesh.point(end) - Vector3::z() * payload.below_riser;
    let signs = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let first = mesh.nodes.len() as u32;
    for signs in signs {
        mesh.nodes.push((centre + Vector3::from(signs).component_mul(&Vector3::from(axes))).into());
        if !mesh.displacement.is_empty() {
            mesh.displacement.push([0.0; 3]);
        }
    }
    let mut add = |name: &str, pairs: &[[u32; 2]]| {
        let edges = mesh.edges.len() as u32..(mesh.edges.len() + pairs.len()) as u32;
        mesh.edges.extend_from_slice(pairs);
        mesh.groups.insert(name.to_owned(), Group::of_edges(edges));
    };
    add("slings", &[0, 1, 2, 3].map(|i| [end, first + i]));
    add("payload-bars", &[[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]].map(|pair| pair.map(|i: u32| first + i)));
    mesh.groups.insert("payload".to_owned(), Group::of_nodes(first..first + 4));
}

/// Several copies of a parachute that share the end of its riser, evenly around the vertical, each tilted so far that
/// their starts do not touch.
///
/// # Errors
/// Canopies that have no room around the payload.
pub(super) fn cluster(p: &ParachuteParameters, one: &Mesh, cluster: ClusterParameters) -> Result<Mesh, MeshError> {
    let Some(end) = end_of(one) else { return Ok(one.clone()) };
    let origin = one.point(end);
    let moved = |node: usize| one.displacement.get(node).map_or(Vector3::zeros(), |u| Vector3::from(*u));
    // Half the angle that a canopy takes, seen from the end of the riser.
    let seen = |(node, place): (usize, &[f64; 3])| {
        let from_end = Vector3::from(*place) + moved(node) - origin;
        from_end.xy().norm().atan2(from_end.z)
    };
    let half = one.nodes.iter().enumerate().filter(|(node, _)| *node as u32 != end).map(seen).fold(0.0, f64::max);
    let share = (PI / cluster.canopies as f64).sin();
    let tilt = ((APART * half).min(0.5 * PI).sin() / share).asin();
    // The arc sine of a number above 1 is not a number.
    if tilt.is_nan() || tilt > MOST_TILT {
        return Err(MeshError::Parameter {
            pointer: "/parachute/cluster/canopies".to_owned(),
            value: cluster.canopies.to_string(),
            allowed: format!(
                "canopies with room beside each other: each takes {:.1} degrees around the end of the riser",
                2.0 * half.to_degrees()
            ),
            hint: if p.riser.is_some() { "lengthen the riser" } else { "give each a riser" }.to_owned()
                + ", or take fewer",
        });
    }
    let mut all = Mesh::default();
    for number in 0..cluster.canopies {
        let azimuth = TAU * number as f64 / cluster.canopies as f64;
        // About a horizontal axis: the canopy leans towards the azimuth.
        let axis = Unit::new_normalize(Vector3::new(-azimuth.sin(), azimuth.cos(), 0.0));
        let turn = Rotation3::from_axis_angle(&axis, tilt) * Rotation3::from_axis_angle(&Vector3::z_axis(), azimuth);
        add_copy(&mut all, one, end, number, &|v| turn * v);
    }
    add_spacers(&mut all, cluster.canopies);
    Ok(all)
}

/// Adds edges between the apexes of neighbouring canopies, each from a node there or around the vent to its copy.
fn add_spacers(all: &mut Mesh, canopies: usize) {
    let nodes_of = |name: &str, i: usize| all.groups.get(&format!("{name}-{}", i + 1)).map(|group| &group.nodes);
    let apex = |i: usize| nodes_of("apex", i).or_else(|| nodes_of("vent", i)).map_or(&[][..], |nodes| nodes);
    let neighbours = (0..canopies).map(|i| [i, (i + 1) % canopies]).take(if canopies == 2 { 1 } else { canopies });
    let pairs = neighbours.flat_map(|[a, b]| apex(a).iter().zip(apex(b)).map(|(&a, &b)| [a, b]));
    let pairs: Vec<[u32; 2]> = pairs.collect();
    let edges = all.edges.len() as u32..(all.edges.len() + pairs.len()) as u32;
    all.edges.extend(pairs);
    all.groups.insert("spacers".to_owned(), Group::of_edges(edges));
}

/// Adds a copy that is turned about the end of the riser, which all copies share as the first node of the mesh.
fn add_copy(all: &mut Mesh, one: &Mesh, end: u32, number: usize, turned: &dyn Fn(Vector3<f64>) -> Vector3<f64>) {
    let origin = one.point(end);
    if number == 0 {
        all.nodes.push(origin.into());
        all.displacement.extend(one.displacement.get(end as usize));
    }
    let first = all.nodes.len() as u32;
    let node = |i: u32| match i.cmp(&end) {
        std::cmp::Ordering::Less => first + i,
        std::cmp::Ordering::Equal => 0,
        std::cmp::Ordering::Greater => first + i - 1,
    };
    let others = || (0..one.nodes.len()).filter(|&i| i as u32 != end);
    all.nodes.extend(others().map(|i| <[f64; 3]>::from(origin + turned(one.point(i as u32) - origin))));
    let displacement = others().filter_map(|i| one.displacement.get(i));
    all.displacement.extend(displacement.map(|u| <[f64; 3]>::from(turned(Vector3::from(*u)))));
    let (edges, triangles) = (all.edges.len() as u32, all.triangles.len() as u32);
    all.edges.extend(one.edges.iter().map(|pair| pair.map(node)));
    all.triangles.extend(one.triangles.iter().map(|corners| corners.map(node)));
    all.rows.extend(one.rows.iter().map(|row| row.iter().map(|&i| node(i)).collect()));
    for (name, strands) in &one.strands {
        let copy: BTreeMap<u32, f64> = strands.iter().map(|(edge, count)| (edges + edge, *count)).collect();
        all.strands.entry(name.clone()).or_default().extend(&copy);
        all.strands.insert(format!("{name}-{}", number + 1), copy);
    }
    let mut copied = Groups::new();
    for (name, group) in &one.groups {
        let mut nodes: Vec<u32> = group.nodes.iter().map(|&i| node(i)).collect();
        nodes.sort_unstable();
        let copy = Group {
            nodes,
            edges: group.edges.iter().map(|e| edges + e).collect(),
            triangles: group.triangles.iter().map(|t| triangles + t).collect(),
        };
        let whole = all.groups.entry(name.clone()).or_default();
        whole.edges.extend(&copy.edges);
        whole.triangles.extend(&copy.triangles);
        whole.nodes.extend(copy.nodes.iter().filter(|i| number == 0 || **i != 0));
        if name != "payload" {
            copied.insert(format!("{name}-{}", number + 1), copy);
        }
    }
    all.groups.append(&mut copied);
}
