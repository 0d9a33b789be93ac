//! Where a rig stands, and which way.

use crate::Mesh;
use nalgebra::{Rotation3, Vector3};
use std::f64::consts::PI;

/// Direction from the payload to the apex as the pattern is cut.
pub(super) const UPWARDS: [f64; 3] = [0.0, 0.0, 1.0];

/// Whether three numbers give a direction.
pub(super) fn is_direction(axis: [f64; 3]) -> bool {
    let size = Vector3::from(axis).norm();
    size.is_finite() && size > 0.0
}

/// Turns the mesh about its payload until the axis, from there to the apex, has a direction, and puts the payload at a
/// place [m], if one is given. Without a payload the middle of the pattern is in its place.
pub(super) fn place(mesh: &mut Mesh, axis: [f64; 3], at: Option<[f64; 3]>) {
    let payload = mesh.groups.get("payload").map(|group| group.nodes.as_slice()).unwrap_or_default();
    let sum: Vector3<f64> = payload.iter().map(|&node| mesh.point(node)).sum();
    let from = if payload.is_empty() { sum } else { sum / payload.len() as f64 };
    let to = at.map_or(from, Vector3::from);
    if axis == UPWARDS && to == from {
        return;
    }
    let up = Vector3::from(UPWARDS);
    // Upside down, every axis across is as good.
    let half = || Rotation3::from_axis_angle(&Vector3::x_axis(), PI);
    let turn = Rotation3::rotation_between(&up, &Vector3::from(axis)).unwrap_or_else(half);
    for node in &mut mesh.nodes {
        *node = (to + turn * (Vector3::from(*node) - from)).into();
    }
    for displacement in &mut mesh.displacement {
        *displacement = (turn * Vector3::from(*displacement)).into();
    }
}
