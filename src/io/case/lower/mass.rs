//! Lumped masses.

use super::geometry::{Geometry, TriangleUse, triangles};
use super::numbers::not_negative;
use super::select;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Mass, PerNode, PointMass};

/// [kg] Mass of every node from the `mass` section: a third of each triangle's mass to each vertex, plus the nodal
/// and point masses.
pub(super) fn mass(at: &Pointer, section: Option<&Mass>, geometry: &Geometry, faults: &mut Faults<'_>) -> Vec<f64> {
    let mut mass = vec![0.0; geometry.nodes()];
    let Some(section) = section else { return mass };
    if let Some(density) = section.areal_density {
        let at = at.key("areal_density");
        if triangles(&at, "a mass per area", geometry, TriangleUse::Areas, faults) {
            for (corners, area) in geometry.mesh.triangles.iter().zip(&geometry.area) {
                for &node in corners {
                    add(&mut mass, node, density * area / 3.0);
                }
            }
        }
    }
    match &section.nodal {
        None => {}
        // A faulty mass is reported and not added.
        Some(PerNode::Same(m)) if !not_negative(&at.key("nodal"), *m, faults) => {}
        Some(PerNode::Same(m)) => mass.iter_mut().for_each(|sum| *sum += m),
        Some(PerNode::Each(list)) => each(&at.key("nodal"), list, &mut mass, faults),
    }
    for (i, point) in section.points.iter().enumerate() {
        add_points(&at.key("points").index(i), point, geometry, &mut mass, faults);
    }
    mass
}

fn add_points(at: &Pointer, point: &PointMass, geometry: &Geometry, mass: &mut [f64], faults: &mut Faults<'_>) {
    let (shared, value) = match (point.mass, point.total) {
        (Some(mass), None) => (false, mass),
        (None, Some(total)) => (true, total),
        (given, _) => {
            let value = if given.is_some() { "a point mass with mass and total" } else { "a point mass without value" };
            let hint = "mass is that of each node, total is shared by all of them".to_owned();
            return faults.add_value(at, value, "exactly one of mass and total", Some(hint));
        }
    };
    let Some(nodes) = select::nodes(&at.key("on"), &point.on, geometry, faults) else { return };
    let share = if shared { value / nodes.len() as f64 } else { value };
    nodes.into_iter().for_each(|node| add(mass, node, share));
}

fn each(at: &Pointer, list: &[f64], mass: &mut [f64], faults: &mut Faults<'_>) {
    if list.len() != mass.len() {
        let value = format!("{} numbers", list.len());
        faults.add_value(at, value, format!("one number, or a list of {} (one per node)", mass.len()), None);
        return;
    }
    for (i, (sum, m)) in mass.iter_mut().zip(list).enumerate() {
        if not_negative(&at.index(i), *m, faults) {
            *sum += m;
        }
    }
}

/// Adds to the mass of a node of the mesh; `mass` `[n_nodes]`.
pub(super) fn add(mass: &mut [f64], node: u32, amount: f64) {
    if let Some(sum) = mass.get_mut(node as usize) {
        *sum += amount;
    }
}
