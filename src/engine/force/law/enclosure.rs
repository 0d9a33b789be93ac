//! A surface whose openings are closed by fans: the volume that a canopy encloses, and its openings.
//!
//! ```text
//! Vol = sum S . x/3,     Vol' = sum S . (v_0 + v_1 + v_2)/3,     over the triangles and the fans
//! dVol'/dv_j = S/3,      dVol'/dx_j = (dS/dx_j)^T (v_0 + v_1 + v_2)/3
//! opening of a rim:  s = sum x_i x x_i+1/2,     d(n . s)/dx_i = (x_i+1 - x_i-1) x n/2
//! ```
//! The middle of a rim is the mean of its nodes, so each of them has an equal share of what a fan does there.

use crate::force::kernel::element_block::NodeVectors;
use crate::force::law::triangle::AreaVector;
use nalgebra::Vector3;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Triangles, right-handed outwards, and the rims around their openings.
#[derive(Debug)]
pub struct Enclosure {
    faces: Arc<[[u32; 3]]>,
    rims: Vec<Vec<u32>>,
}

impl Enclosure {
    /// The surface of some triangles.
    pub fn new(faces: Arc<[[u32; 3]]>) -> Self {
        Enclosure { rims: closed_loops(&faces), faces }
    }

    /// Nodes of each rim, which turns as the triangles beside it.
    pub fn rims(&self) -> &[Vec<u32>] {
        &self.rims
    }

    /// [m^3] volume, and [m^3/s] its rate, by the divergence theorem; each rim is closed by a fan about its middle.
    /// Seen from a point `origin` [m] near by, so that a far origin costs no digits.
    pub fn volume(&self, x: NodeVectors<'_>, v: NodeVectors<'_>, origin: Vector3<f64>) -> [f64; 2] {
        let (mut volume, mut rate) = (0.0, 0.0);
        let mut add = |[a, b, c]: [Vector3<f64>; 3], speed: Vector3<f64>| {
            let area = (b - a).cross(&(c - a));
            volume += area.dot(&(a - origin)) / 6.0;
            rate += area.dot(&speed) / 6.0;
        };
        for &nodes in self.faces.iter() {
            add(nodes.map(|node| x.at(node)), nodes.into_iter().map(|node| v.at(node)).sum());
        }
        for rim in &self.rims {
            let (middle, speed) = (x.mean(rim), v.mean(rim));
            for [a, b] in outwards(rim) {
                add([middle, x.at(a), x.at(b)], speed + v.at(a) + v.at(b));
            }
        }
        [volume, rate]
    }

    /// \[m^3\] The same volume with each node at a place of its own.
    pub fn volume_of(&self, place: impl Fn(u32) -> Vector3<f64>, origin: Vector3<f64>) -> f64 {
        let part = |[a, b, c]: [Vector3<f64>; 3]| (b - a).cross(&(c - a)).dot(&(a - origin)) / 6.0;
        let faces: f64 = self.faces.iter().map(|nodes| part(nodes.map(&place))).sum();
        let fan = |rim: &Vec<u32>| {
            let middle = rim.iter().map(|&node| place(node)).sum::<Vector3<f64>>() / rim.len() as f64;
            outwards(rim).map(|[a, b]| part([middle, place(a), place(b)])).sum::<f64>()
        };
        faces + self.rims.iter().map(fan).sum::<f64>()
    }

    /// Adds `by_v` dVol'/dv + `by_x` dVol'/dx to `g`.
    pub fn add_rate_gradient(&self, [x, v]: [&[Vector3<f64>]; 2], [by_v, by_x]: [f64; 2], g: &mut [Vector3<f64>]) {
        let [positions, velocities] = [x, v].map(NodeVectors::Nodes);
        let parts = |corners: [Vector3<f64>; 3], speed: Vector3<f64>| {
            let area = AreaVector::of(corners);
            let slope = |j: usize| by_v / 3.0 * area.s + by_x / 3.0 * area.derivative(j).transpose() * speed;
            [slope(0), slope(1), slope(2)]
        };
        for &nodes in self.faces.iter() {
            let speed = nodes.into_iter().map(|node| velocities.at(node)).sum();
            let parts = parts(nodes.map(|node| positions.at(node)), speed);
            nodes.into_iter().zip(parts).for_each(|(node, part)| g[node as usize] += part);
        }
        for rim in &self.rims {
            let (middle, speed) = (positions.mean(rim), velocities.mean(rim));
            let mut shared = Vector3::zeros();
            for [a, b] in outwards(rim) {
                let corners = [middle, positions.at(a), positions.at(b)];
                let [of_middle, of_a, of_b] = parts(corners, speed + velocities.at(a) + velocities.at(b));
                shared += of_middle;
                g[a as usize] += of_a;
                g[b as usize] += of_b;
            }
            shared /= rim.len() as f64;
            rim.iter().for_each(|&node| g[node as usize] += shared);
        }
    }

    /// [m^2] Area vector of the opening that a rim goes around.
    pub fn opening(&self, rim: usize, x: NodeVectors<'_>) -> Vector3<f64> {
        let Some(nodes) = self.rims.get(rim) else { return Vector3::zeros() };
        let from = x.at(nodes[0]);
        let sides = nodes.iter().zip(nodes.iter().skip(1));
        sides.map(|(&a, &b)| 0.5 * (x.at(a) - from).cross(&(x.at(b) - from))).sum()
    }

    /// Adds the gradient of `along` . [`Enclosure::opening`] to `g`.
    pub fn add_opening_gradient(&self, rim: usize, x: &[Vector3<f64>], along: Vector3<f64>, g: &mut [Vector3<f64>]) {
        let Some(nodes) = self.rims.get(rim) else { return };
        for (i, &node) in nodes.iter().enumerate() {
            let [next, last] = [i + 1, i + nodes.len() - 1].map(|i| x[nodes[i % nodes.len()] as usize]);
            g[node as usize] += 0.5 * (next - last).cross(&along);
        }
    }
}

/// The sides of a rim backwards, as its fan has them, which looks out of the opening.
fn outwards(rim: &[u32]) -> impl Iterator<Item = [u32; 2]> {
    (0..rim.len()).rev().map(|i| [rim[(i + 1) % rim.len()], rim[i]])
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
        let [volume, rate] = enclosure.volume(NodeVectors::Nodes(&x), NodeVectors::Nodes(&v), x[0]);
        assert!((volume - 8.0).abs() < 1e-9 && (rate - 12.0).abs() < 1e-9, "{volume} {rate}");
        let later = enclosure.volume_of(|node| x[node as usize] + v[node as usize], x[0]);
        assert!((later - 27.0).abs() < 1e-9, "{later}");
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
