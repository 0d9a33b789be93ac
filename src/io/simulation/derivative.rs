//! Compares the derivatives of a [`NodalForce`] with differences of the force.

use super::{ForceDerivative, NodalForce};

/// The largest error of the derivatives of a force, at one state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DerivativeError {
    /// [-] error over the largest derivative; 0 for a force that depends on nothing
    pub relative: f64,
    /// node of the force, and node that it depends on, where the error is; perhaps no declared pair
    pub pair: [usize; 2],
    /// whether the derivative is by the velocity, else by the position
    pub by_velocity: bool,
}

/// [-] Step of a central difference over the size of what is changed: its cube is the rounding of a number.
const STEP: f64 = 6e-6;

/// Finds the largest error of [`NodalForce::derivatives`] at time `t` [s], positions `x` [m] and velocities `v` [m/s]:
/// of every pair of nodes, so that one that [`NodalForce::pairs`] forgets shows as an error of 1. For tests: it takes
/// 12 passes a node. Right derivatives of a smooth force give about 1e-9.
pub fn derivative_error(force: &dyn NodalForce, t: f64, x: &[[f64; 3]], v: &[[f64; 3]]) -> DerivativeError {
    let (n, pairs) = (x.len(), force.pairs());
    let mut given = vec![ForceDerivative::default(); pairs.len()];
    force.derivatives(t, x, v, &mut given);
    let mut state = [x.to_vec(), v.to_vec()];
    let (mut largest, mut worst) = (0.0_f64, DerivativeError::default());
    for (which, node, axis) in (0..2).flat_map(|w| (0..n).flat_map(move |j| (0..3).map(move |c| (w, j, c)))) {
        let size = state[which].as_flattened().iter().fold(1.0, |most: f64, value| most.max(value.abs()));
        let (at, h) = (state[which][node][axis], STEP * size);
        let [ahead, behind] = [at + h, at - h].map(|moved| {
            state[which][node][axis] = moved;
            let mut f = vec![[0.0; 3]; n];
            force.add(t, &state[0], &state[1], &mut f);
            f
        });
        state[which][node][axis] = at;
        for i in 0..n {
            let of_pair = pairs.iter().zip(&given).filter(|(pair, _)| pair.map(|node| node as usize) == [i, node]);
            let blocks: Vec<_> = of_pair.map(|(_, d)| if which == 0 { d.position } else { d.velocity }).collect();
            for row in 0..3 {
                let difference = (ahead[i][row] - behind[i][row]) / (2.0 * h);
                let error = (blocks.iter().map(|block| block[row][axis]).sum::<f64>() - difference).abs();
                largest = largest.max(difference.abs());
                if error.is_nan() || error > worst.relative {
                    worst = DerivativeError { relative: error, pair: [i, node], by_velocity: which == 1 };
                }
            }
        }
    }
    let relative = if largest > 0.0 { worst.relative / largest } else { worst.relative };
    DerivativeError { relative, ..worst }
}
