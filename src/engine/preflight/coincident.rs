//! Nodes at the same place that no spring joins: probably a seam that was not merged.

use std::collections::BTreeSet;
use std::fmt;

use nalgebra::Vector3;

use super::parts::joined;
use crate::format_number::figures;
use crate::model::spec::NetworkSpec;
use crate::warning::{Warning, WarningCode};

/// [-] Distance over the extent of the mesh within which two nodes coincide.
const WITHIN: f64 = 1e-6;

/// [-] Number of following nodes in sorted order that a node is compared with. In a mesh of a million nodes about one
/// follows within the distance.
const LOOKS: usize = 64;

/// Direction of the search, along which neither regular nets nor flat sheets have many nodes at the same place.
const LINE: Vector3<f64> = Vector3::new(0.571_896_1, 0.656_281_9, 0.492_167_3);

/// Coincident nodes that are not joined.
#[derive(Clone, Debug, PartialEq)]
pub struct Coincident {
    /// the pair with the smallest numbers
    pub first: [u32; 2],
    /// [-] number of pairs of neighbours
    pub pairs: usize,
    /// [m] distance within which nodes coincide
    pub within: f64,
}

/// Finds nodes within 1e-6 of the extent of each other that no spring joins. Pairs that supports hold completely do not
/// count, such as the ends of a loop, except on cloth: the edges of a seam that is not joined are "outer" ones.
///
/// Nodes are sorted along a fixed direction, and each is compared with those that follow: O(n log n).
pub fn coincident(spec: &NetworkSpec) -> Option<Coincident> {
    let nodes: Vec<Vector3<f64>> = spec.mesh.nodes.iter().map(|x| Vector3::from(*x)).collect();
    let low = nodes.iter().copied().reduce(|low, x| low.inf(&x))?;
    let high = nodes.iter().copied().reduce(|high, x| high.sup(&x))?;
    let within = WITHIN * (high - low).max();
    let mut order: Vec<(f64, u32)> = nodes.iter().map(|x| (*x - low).dot(&LINE)).zip(0..).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let held = |node: u32| spec.fixed.get(node as usize) == Some(&[true; 3]);
    let mut cloth = vec![false; nodes.len()];
    spec.mesh.triangles.as_flattened().iter().for_each(|node| cloth[*node as usize] = true);
    let sound = |node: u32| held(node) && !cloth[node as usize];
    let mut pairs = BTreeSet::new();
    for (i, &(along, a)) in order.iter().enumerate() {
        // The component along a unit vector is no longer than the distance.
        let close = order.iter().skip(i + 1).take(LOOKS).take_while(|(other, _)| other - along <= within);
        for &(_, b) in close {
            let apart = (nodes[a as usize] - nodes[b as usize]).norm();
            if apart <= within && !(sound(a) && sound(b)) {
                pairs.insert([a.min(b), a.max(b)]);
            }
        }
    }
    if !pairs.is_empty() {
        joined(spec).for_each(|[a, b]| {
            pairs.remove(&[a.min(b), a.max(b)]);
        });
    }
    let first = pairs.first().copied()?;
    Some(Coincident { first, pairs: pairs.len(), within })
}

impl fmt::Display for Coincident {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.first;
        let more = if self.pairs > 1 { format!(", as do {} pairs in all,", self.pairs) } else { String::new() };
        write!(
            f,
            "nodes {a} and {b} coincide{more} (within {} m), and no spring joins them: give the parts they belong to one node \
             there (\"merge\" does for a mesh file), or a spring between the two",
            figures(self.within, 2)
        )
    }
}

impl From<Coincident> for Warning {
    fn from(found: Coincident) -> Self {
        Warning::new(WarningCode::CoincidentNodes, found.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_is_a_unit_vector() {
        assert!((LINE.norm() - 1.0).abs() < 1e-6 && LINE.norm() <= 1.0, "{}", LINE.norm());
    }
}
