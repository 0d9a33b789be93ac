//! The force of a pair as a mean over a step: the discrete gradient of its energy (Gonzalez 1996).
//!
//! ```text
//! x_0 = x - h/2 v,   x_1 = x + h/2 v,   D = x_1 - x_0,   E_j = D_j - mean of D over the nodes of the pair
//! -f = G + c E,   G = dphi/dx in the middle,   c = (phi_1 - phi_0 - G . D)/|E|^2
//! -df/dx = K + E (2 dphi_1/dx - K D - 2 G - 4 c E)^T/|E|^2 + 2 c P,      P: less the mean
//! ```
//! So -f . D = phi_1 - phi_0 and forces of a pair add up to 0. The derivative is that of a middle which moves while x_0
//! stays.

use super::near::{Candidate, Form, NO_NODE, Places};
use super::touch::{Blocks, Touch};
use crate::force::outer;
use nalgebra::{Matrix3, Vector3};

/// A pair at the start, in the middle and at the end of a step.
pub struct MeanTouch {
    /// at each of them, if it touches there
    touches: [Option<Touch>; 3],
    /// [m] D of every node
    way: [Vector3<f64>; 4],
    /// [m] E, 0 beyond the nodes
    turn: [Vector3<f64>; 4],
    /// [m^2] |E|^2
    square: f64,
    /// how many nodes it has
    count: usize,
}

/// Where nodes and obstacles are at the start, in the middle and at the end of a step.
pub type Step<'a> = [Places<'a>; 3];

impl MeanTouch {
    /// A candidate over a step; `None` if it touches neither at its ends nor in its middle.
    pub fn of(candidate: &Candidate, step: &Step<'_>) -> Option<Self> {
        let touches = [0, 1, 2].map(|i| Touch::of(candidate, step[i], false));
        touches.iter().any(Option::is_some).then(|| {
            let mut way = [Vector3::zeros(); 4];
            let nodes = || candidate.nodes.into_iter().filter(|node| *node != NO_NODE);
            way.iter_mut().zip(nodes()).for_each(|(way, node)| *way = step[2].at(node) - step[0].at(node));
            let count = nodes().count();
            // Beside a plane there is one node alone, which moves against it.
            let mean = match candidate.form {
                Form::Plane => {
                    let at = |i: usize| step[i].shifts[usize::from(candidate.contact)][0];
                    at(2) - at(0)
                }
                Form::Pair(_) => way.iter().sum::<Vector3<f64>>() / count as f64,
            };
            let mut turn = way;
            turn[..count].iter_mut().for_each(|turn| *turn -= mean);
            let square = turn.iter().map(Vector3::norm_squared).sum();
            MeanTouch { touches, way, turn, square, count }
        })
    }

    fn middle_gradient(&self) -> [Vector3<f64>; 4] {
        self.touches[1].as_ref().map_or([Vector3::zeros(); 4], Touch::gradient)
    }

    /// [N/m] c; 0 where nothing moves.
    fn correction(&self) -> f64 {
        let [begun, _, ended] = [0, 1, 2].map(|i| self.touches[i].as_ref().map_or(0.0, Touch::energy));
        let linear: f64 = self.middle_gradient().iter().zip(&self.way).map(|(g, d)| g.dot(d)).sum();
        if self.square > 0.0 { (ended - begun - linear) / self.square } else { 0.0 }
    }

    /// [N] Minus the mean forces on the nodes.
    pub fn gradient(&self) -> [Vector3<f64>; 4] {
        let (middle, c) = (self.middle_gradient(), self.correction());
        std::array::from_fn(|j| middle[j] + self.turn[j] * c)
    }

    /// [N/m] -df/dx; symmetric and without negative eigenvalues if it is `convex`.
    pub fn tangent(&self, convex: bool) -> Blocks {
        let mut k = self.touches[1].as_ref().map_or(Blocks::default(), |touch| touch.tangent(convex));
        if convex || self.square == 0.0 {
            return k;
        }
        let (middle, c) = (self.middle_gradient(), self.correction());
        let end = self.touches[2].as_ref().map_or([Vector3::zeros(); 4], Touch::gradient);
        let slope: [Vector3<f64>; 4] = std::array::from_fn(|j| {
            let of_way: Vector3<f64> = (0..4).map(|i| k[j][i] * self.way[i]).sum();
            (end[j] * 2.0 - of_way - middle[j] * 2.0 - self.turn[j] * (4.0 * c)) / self.square
        });
        for (i, row) in k.iter_mut().enumerate().take(self.count) {
            for (j, block) in row.iter_mut().enumerate().take(self.count) {
                let own = if i == j { 1.0 } else { 0.0 };
                let mean = if self.count > 1 { 1.0 / self.count as f64 } else { 0.0 };
                let part = 2.0 * c * (own - mean);
                *block += outer(self.turn[i], slope[j]) + Matrix3::from_diagonal_element(part);
            }
        }
        k
    }
}
