//! Lumped masses.

use super::geometry::{Geometry, TriangleUse, triangles};
use super::numbers::not_negative;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Mass, PerNode};

/// [kg] Mass of every node from the `mass` section: a third of each triangle's mass to each vertex, plus the nodal
/// masses.
pub(super) fn mass(at: &Pointer, section: Option<&Mass>, geometry: &Geometry, faults: &mut Faults<'_>) -> Vec<f64> {
    let mut mass = vec![0.0; geometry.nodes()];
    let Some(section) = section else { return mass };
    if let Some(density) = section.areal_density {
        let at = at.key("areal_density");
        if not_negative(&at, density, faults) && triangles(&at, "a mass per area", geometry, TriangleUse::Areas, faults)
        {
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
    mass
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
