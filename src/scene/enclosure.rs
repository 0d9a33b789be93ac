//! A surface whose openings are closed by fans: the volume that a canopy encloses.

use crate::force::NodeState;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Triangles, right-handed outwards, and the rims around their openings.
#[derive(Debug)]
pub(super) struct Enclosure {
    faces: Arc<[[u32; 3]]>,
    rims: Vec<Vec<u32>>,
}

impl Enclosure {
    pub fn new(faces: Arc<[[u32; 3]]>) -> Self {
        Enclosure { rims: closed_loops(&faces), faces }
    }

    /// Nodes of each rim, which turns as the triangles beside it.
    pub fn rims(&self) -> &[Vec<u32>] {
        &self.rims
    }

    /// [m^3] volume, and [m^3/s] its rate, by the divergence theorem; each rim is closed by a fan about its middle.
    /// Seen from a point `origin` [m] near by, so that a far origin costs no digits.
    pub fn volume(&self, NodeState { x, v, .. }: NodeState<'_>, origin: Vector3<f64>) -> [f64; 2] {
        let (mut volume, mut rate) = (0.0, 0.0);
        let mut add = |[a, b, c]: [Vector3<f64>; 3], speed: Vector3<f64>| {
            let area = (b - a).cross(&(c - a));
            volume += area.dot(&(a - origin)) / 6.0;
            rate += area.dot(&speed) / 6.0;
        };
        for nodes in self.faces.iter() {
            let nodes = nodes.map(|node| node as usize);
            add(nodes.map(|node| x[node]), nodes.iter().map(|&node| v[node]).sum());
        }
        for rim in &self.rims {
            // Backwards: a fan looks out of the opening.
            let backwards = || rim[..1].iter().chain(rim[1..].iter().rev()).map(|&node| node as usize);
            let mean = |of: &[Vector3<f64>]| backwards().map(|node| of[node]).sum::<Vector3<f64>>() / rim.len() as f64;
            let (middle, speed) = (mean(x), mean(v));
            for (a, b) in backwards().zip(backwards().cycle().skip(1)) {
                add([middle, x[a], x[b]], speed + v[a] + v[b]);
            }
        }
        [volume, rate]
    }
}

/// The loops of edges that one triangle has alone, each turning as its triangles; chains that do not close are left
/// out.
fn closed_loops(triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let sides = || triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let all: BTreeSet<[u32; 2]> = sides().collect();
    let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    for [a, b] in sides().filter(|[a, b]| !all.contains(&[*b, *a])) {
        next.entry(a).or_default().push(b);
    }
    let mut loops = Vec::new();
    while let Some(&start) = next.keys().next() {
        let mut nodes = vec![start];
        let mut at = start;
        while let Some(list) = next.get_mut(&at) {
            let Some(to) = list.pop() else { break };
            if list.is_empty() {
                next.remove(&at);
            }
            at = to;
            if at == start {
                break;
            }
            nodes.push(at);
        }
        if at == start && nodes.len() > 2 {
            loops.push(nodes);
        }
    }
    loops
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cube without its lower side, and with a hole in the upper one, that grows like its edge.
    #[test]
    fn the_volume_of_a_box_is_closed_by_fans() {
        let corner = |i: u32| Vector3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * 2.0;
        let x: Vec<Vector3<f64>> = (0..8).map(|i| corner(i).add_scalar(1e3)).collect();
        let v: Vec<Vector3<f64>> = (0..8).map(|i| 0.5 * corner(i)).collect();
        let sides = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
        let faces: Vec<[u32; 3]> = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let enclosure = Enclosure::new(faces.into());
        assert_eq!(enclosure.rims().iter().map(Vec::len).collect::<Vec<_>>(), [4, 4]);
        let [volume, rate] = enclosure.volume(NodeState { t: 0.0, x: &x, v: &v }, x[0]);
        assert!((volume - 8.0).abs() < 1e-9 && (rate - 12.0).abs() < 1e-9, "{volume} {rate}");
    }

    /// A ring of triangles has two loops, which turn against each other; a single triangle has one.
    #[test]
    fn loops_of_a_ring() {
        assert_eq!(closed_loops(&[[4, 7, 5]]), [[4, 7, 5]]);
        let ring: Vec<[u32; 3]> = (0..3)
            .flat_map(|i| {
                let j = (i + 1) % 3;
                [[i, i + 3, j + 3], [i, j + 3, j]]
            })
            .collect();
        let loops = closed_loops(&ring);
        assert_eq!(loops, [vec![0, 2, 1], vec![3, 4, 5]]);
    }
}
