//! A bound on the largest root of M^-1 (c C + k K) from one pass over the elements, without an eigenproblem.
//!
//! A positive semidefinite element matrix of b x b blocks lies below b times its block diagonal, so the sum over all elements
//! lies below the largest root of any node's 3 x 3 block (in the spirit of Irons & Treharne 1971, by nodes). An end that is
//! held does not move and does not count in b. On a regular triangular net the bound is the root itself.

use super::network::{Network, by_node, node_state};
use crate::force::TangentSink;
use crate::model::state::StateRef;
use crate::model::system::Weights;
use glam::{DMat3, DVec3};

/// Room for one block a node, kept between passes.
#[derive(Clone, Debug, Default)]
pub struct BoundRoom(Vec<DMat3>);

impl Network {
    /// The bound [1/s^2 or 1/s, as the weights make it] and the degree of freedom whose node sets it; proved where K and C are
    /// symmetric (what compression takes from K is left out), else a measure that grows as the root does.
    pub(super) fn node_bound(&self, at: StateRef<'_>, w: Weights, room: &mut BoundRoom) -> (f64, usize) {
        let BoundRoom(blocks) = room;
        blocks.clear();
        blocks.resize(self.fixed.len(), DMat3::ZERO);
        let inverse = by_node(&self.inverse_mass);
        let mut sink = Diagonal { blocks, inverse };
        for term in &self.terms {
            term.convex_tangent(node_state(at), w, &mut sink);
        }
        let (mut most, mut dof) = (0.0, 0);
        for (i, (block, inverse)) in blocks.iter().zip(inverse).enumerate() {
            let root = DVec3::new(inverse.x.sqrt(), inverse.y.sqrt(), inverse.z.sqrt());
            let scaled = DMat3::from_diagonal(root) * *block * DMat3::from_diagonal(root);
            // The sum of squares is never below the largest root, and cheaper.
            let size = scaled.to_cols_array().iter().map(|x| x * x).sum::<f64>().sqrt();
            if size.is_nan() || size > most {
                let largest = largest_root(&scaled);
                if largest.is_nan() || largest > most {
                    (most, dof) = (largest, 3 * i + (0..3).max_by(|&a, &b| along(&scaled, a, b)).unwrap_or(0));
                }
            }
        }
        (most, dof)
    }
}

fn along(block: &DMat3, a: usize, b: usize) -> std::cmp::Ordering {
    block.col(a)[a].total_cmp(&block.col(b)[b])
}

/// Largest eigenvalue of the symmetric part of a 3 x 3 matrix (Smith 1961).
fn largest_root(a: &DMat3) -> f64 {
    let a = (*a + a.transpose()) * 0.5;
    let mean = (a.x_axis.x + a.y_axis.y + a.z_axis.z) / 3.0;
    let rest = a - DMat3::from_diagonal(DVec3::splat(mean));
    let p = (rest.to_cols_array().iter().map(|x| x * x).sum::<f64>() / 6.0).sqrt();
    if p == 0.0 {
        return mean;
    }
    let half = 0.5 * (rest * p.recip()).determinant();
    mean + 2.0 * p * (half.clamp(-1.0, 1.0).acos() / 3.0).cos()
}

/// Adds up element blocks on the diagonal, each as many times as its element has ends that move.
struct Diagonal<'a> {
    blocks: &'a mut [DMat3],
    inverse: &'a [DVec3],
}

impl Diagonal<'_> {
    fn moves(&self, i: u32) -> bool {
        self.inverse[i as usize].max_element() > 0.0
    }
}

impl TangentSink for Diagonal<'_> {
    fn node(&mut self, i: u32, block: DMat3) {
        self.blocks[i as usize] += block;
    }

    fn edge(&mut self, nodes: [u32; 2], block: DMat3) {
        let moving = nodes.iter().filter(|&&i| self.moves(i)).count() as f64;
        for i in nodes {
            self.blocks[i as usize] += block * moving;
        }
    }

    fn triangle(&mut self, nodes: [u32; 3], blocks: &[[DMat3; 3]; 3]) {
        let moving = nodes.iter().filter(|&&i| self.moves(i)).count() as f64;
        for (p, &i) in nodes.iter().enumerate() {
            self.blocks[i as usize] += blocks[p][p] * moving;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_root_of_known_matrices() {
        let rotation = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.7);
        for roots in [[3.0, 2.0, 1.0], [5.0, 5.0, -2.0], [0.0, 0.0, 0.0], [-1.0, -4.0, -4.0], [7.0, 7.0, 7.0]] {
            let a = rotation * DMat3::from_diagonal(DVec3::from_array(roots)) * rotation.transpose();
            assert!((largest_root(&a) - roots[0]).abs() < 1e-12, "{roots:?}: {}", largest_root(&a));
        }
    }
}
