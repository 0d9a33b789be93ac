//! The air that a canopy takes along: it has momentum, but no weight.
//!
//! ```text
//! V = sum b_i v_i - wind,   b_i = share of a node in the area of the cloth,   m = k rho Vol
//! force on node i: -b_i d(m V)/dt = -b_i (m A + m' V),    A = dV/dt in a steady wind
//! ```
//! Vol is the volume of the canopy, each of its rims closed by a fan about its middle, found by the divergence theorem.
//! The masses of the nodes stay what they are: with f, the forces of everything else,
//! ```text
//! A = sum b_i (f_i - b_i (m A + m' V))/m_i,     so     A = (a - m' V s)/(1 + m s),  a = sum b_i f_i/m_i,  s = sum b_i^2/m_i
//! ```
//! Its work is that of an external force: -d(m V^2/2) - m' V^2/2, what growing takes included. Implicit schemes solve
//! (M + m b b^T) a = f - b m' V instead, with the same solution.

use super::network::{Network, by_node};
use crate::force::NodeState;
use crate::force::law::stream::Stream;
use crate::model::forces::Tally;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The air that a canopy takes along.
pub(super) struct ApparentMass {
    /// [-] nodes of the canopy, and the share of each in its motion; they sum to 1
    pub nodes: Vec<(u32, f64)>,
    /// vertices, right-handed outwards
    pub faces: Vec<[u32; 3]>,
    /// edges of each rim, right-handed outwards about its middle
    pub rims: Vec<Vec<[u32; 2]>>,
    /// [-] k
    pub factor: f64,
    /// the air around it
    pub stream: Arc<Stream>,
    /// which of the terms the air in this canopy is
    pub term: usize,
}

/// That air in a state.
struct Entrained {
    /// [kg] m
    mass: f64,
    /// [kg/s] m'
    growth: f64,
    /// [m/s] V
    velocity: Vector3<f64>,
    /// [m/s] V and the wind
    absolute: Vector3<f64>,
}

/// The rims of a surface: edges of one triangle, the other way round, by the rim they are in.
pub(super) fn rims(faces: &[[u32; 3]]) -> Vec<Vec<[u32; 2]>> {
    let sides = faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let all: std::collections::BTreeSet<[u32; 2]> = sides.collect();
    let mut next: BTreeMap<u32, u32> =
        all.iter().filter(|&&[a, b]| !all.contains(&[b, a])).map(|&[a, b]| (b, a)).collect();
    let mut rims = Vec::new();
    while let Some((&first, _)) = next.first_key_value() {
        let (mut rim, mut at) = (Vec::new(), first);
        while let Some(to) = next.remove(&at) {
            rim.push([at, to]);
            at = to;
        }
        rims.push(rim);
    }
    rims
}

impl ApparentMass {
    /// [m^3] volume, and [m^3/s] its rate.
    fn volume(&self, NodeState { x, v, .. }: NodeState<'_>) -> [f64; 2] {
        let (mut volume, mut rate) = (0.0, 0.0);
        // Seen from a node of its own, so that a far origin costs no digits.
        let origin = self.nodes.first().map_or(Vector3::zeros(), |&(node, _)| x[node as usize]);
        let mut add = |[a, b, c]: [Vector3<f64>; 3], speed: Vector3<f64>| {
            let area = (b - a).cross(&(c - a));
            volume += area.dot(&(a - origin)) / 6.0;
            rate += area.dot(&speed) / 6.0;
        };
        for nodes in &self.faces {
            let nodes = nodes.map(|node| node as usize);
            add(nodes.map(|node| x[node]), nodes.iter().map(|&node| v[node]).sum());
        }
        for rim in &self.rims {
            let mean = |of: &[Vector3<f64>]| {
                rim.iter().map(|&[node, _]| of[node as usize]).sum::<Vector3<f64>>() / rim.len() as f64
            };
            let (middle, speed) = (mean(x), mean(v));
            for ends in rim {
                let [a, b] = ends.map(|node| node as usize);
                add([middle, x[a], x[b]], speed + v[a] + v[b]);
            }
        }
        [volume, rate]
    }

    fn mean(&self, of: &[Vector3<f64>]) -> Vector3<f64> {
        self.nodes.iter().map(|&(node, share)| share * of[node as usize]).sum()
    }

    fn entrained(&self, at: NodeState<'_>) -> Entrained {
        let ([volume, rate], absolute) = (self.volume(at), self.mean(at.v));
        let air = self.stream.at(at.t, self.mean(at.x).z);
        let [density, slope] = air.density;
        // Turned inside out, a canopy encloses no air.
        let factor = if volume > 0.0 { self.factor } else { 0.0 };
        let growth = factor * (density * rate + slope * absolute.z * volume);
        Entrained { mass: factor * density * volume, growth, velocity: absolute - air.wind[0], absolute }
    }

    /// sum b_i^2/m_i [1/kg], along each axis.
    fn mobility(&self, inverse_mass: &[Vector3<f64>]) -> Vector3<f64> {
        self.nodes.iter().map(|&(node, share)| share * share * inverse_mass[node as usize]).sum()
    }

    /// sum b_i f_i/m_i, along each axis.
    fn acceleration(&self, f: &[Vector3<f64>], inverse_mass: &[Vector3<f64>]) -> Vector3<f64> {
        let parts = self.nodes.iter().map(|&(node, share)| {
            let i = node as usize;
            share * f[i].component_mul(&inverse_mass[i])
        });
        parts.sum()
    }
}

impl Network {
    /// Adds what the air that canopies take along does to them: to all forces and the external ones [N] `[n_nodes]`,
    /// and to the powers of the terms.
    pub(super) fn add_apparent(&self, at: NodeState<'_>, sums: [&mut [Vector3<f64>]; 2], tallies: &mut [Tally]) {
        let [total, external] = sums;
        let inverse_mass = by_node(&self.phase().inverse_mass);
        for canopy in &self.apparent {
            let Entrained { mass, growth, velocity, absolute } = canopy.entrained(at);
            let (a, s) = (canopy.acceleration(total, inverse_mass), canopy.mobility(inverse_mass));
            let lost = growth * velocity;
            let accelerated = (a - lost.component_mul(&s)).component_div(&(mass * s).add_scalar(1.0));
            let force = -(mass * accelerated + lost);
            for &(node, share) in &canopy.nodes {
                total[node as usize] += share * force;
                external[node as usize] += share * force;
            }
            if let Some(tally) = self.tally_of(canopy.term).and_then(|tally| tallies.get_mut(tally)) {
                tally.power += force.dot(&absolute);
            }
        }
    }

    /// Replaces a residual M a - f of forces that have the apparent masses in them by (M + m b b^T) a - f, with the
    /// forces of everything else and b m' V.
    pub(super) fn with_apparent(&self, at: NodeState<'_>, residual: &mut [Vector3<f64>]) {
        let inverse_mass = by_node(&self.phase().inverse_mass);
        for canopy in &self.apparent {
            let added = canopy.entrained(at).mass * canopy.acceleration(residual, inverse_mass);
            canopy.nodes.iter().for_each(|&(node, share)| residual[node as usize] += share * added);
        }
    }

    /// A part m b b^T of the mass, along one axis: overwrites u with m b, and g with b.
    pub(super) fn apparent_part(&self, which: usize, at: NodeState<'_>, [u, g]: [&mut [f64]; 2]) {
        u.fill(0.0);
        g.fill(0.0);
        let Some(canopy) = self.apparent.get(which / 3) else { return };
        let mass = canopy.entrained(at).mass;
        for &(node, share) in &canopy.nodes {
            let dof = 3 * node as usize + which % 3;
            (u[dof], g[dof]) = (mass * share, share);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::spec::{Series, StreamSpec};

    /// A cube without its lower side, and with a hole in the upper one, that grows like its edge.
    #[test]
    fn the_volume_of_a_box_is_closed_by_fans() {
        let corner = |i: u32| Vector3::new(f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2 & 1)) * 2.0;
        let x: Vec<Vector3<f64>> = (0..8).map(|i| corner(i).add_scalar(1e3)).collect();
        let v: Vec<Vector3<f64>> = (0..8).map(|i| 0.5 * corner(i)).collect();
        let sides = [[0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
        let faces: Vec<[u32; 3]> = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let found = rims(&faces);
        assert_eq!(found.iter().map(Vec::len).collect::<Vec<_>>(), [4, 4]);
        let stream = Stream::new(StreamSpec::of_wind(Series { t: vec![0.0], value: vec![[0.0; 3]] }));
        let nodes = (0..8).map(|node| (node, 0.125)).collect();
        let canopy = ApparentMass { nodes, faces, rims: found, factor: 1.0, stream, term: 0 };
        let [volume, rate] = canopy.volume(NodeState { t: 0.0, x: &x, v: &v });
        assert!((volume - 8.0).abs() < 1e-9 && (rate - 12.0).abs() < 1e-9, "{volume} {rate}");
    }
}
