//! The power of the outer and of the dissipative forces of [`crate::rich_net`], by hand from the numbers of the case:
//!
//! ```text
//! dissipated  sum c ldot^2 (axial) + sum c |vb - va|^2 (relative) + alpha sum m v^2 + beta sum k (n0 . (vb - va))^2
//! external    sum over triangles (dp + p) S . v_mean + F . v,     dp = e (a v_n + b v_n |v_n|),  v_n = N . (wind - v_mean)
//! ```
//! No force, role or power of the program is used, so that a term in the wrong column of its account is noticed.

use crate::rich_net::{
    ALPHA, AXIAL_DASHPOT, BETA, CLOTH, MASS, NODES, PRESSURE, PRESSURE_TABLE, PULL, PULL_TABLE, PULLED, RELATIVE_TIME,
    SPRINGS, TRIANGLES, WIND, rule,
};
use nalgebra::Vector3;

/// Where the nodes are and how they move, in the user's numbering.
pub struct Moving {
    /// [s]
    pub t: f64,
    /// [m]
    pub x: Vec<Vector3<f64>>,
    /// [m/s]
    pub v: Vec<Vector3<f64>>,
}

/// [W] of the wind and the loads.
pub fn external(at: &Moving) -> f64 {
    let wind = Vector3::from(interpolated(&WIND, at.t));
    let [load] = interpolated(&PULL_TABLE, at.t);
    let [factor] = interpolated(&PRESSURE_TABLE, at.t);
    let [a, b, thickness] = CLOTH;
    let surface = TRIANGLES.map(|[i, j, k]| {
        let s = 0.5 * (at.x[j] - at.x[i]).cross(&(at.x[k] - at.x[i]));
        let v = (at.v[i] + at.v[j] + at.v[k]) / 3.0;
        let through = s.normalize().dot(&(wind - v));
        (thickness * (a * through + b * through * through.abs()) + factor * PRESSURE) * s.dot(&v)
    });
    surface.iter().sum::<f64>() + load * Vector3::from(PULL).dot(&at.v[PULLED])
}

/// [W] taken by dashpots and Rayleigh damping.
pub fn dissipated(at: &Moving) -> f64 {
    let springs = SPRINGS.iter().enumerate().map(|(i, &[a, b])| {
        let dv = at.v[b] - at.v[a];
        let dashpot = if i.is_multiple_of(2) {
            AXIAL_DASHPOT * (at.x[b] - at.x[a]).normalize().dot(&dv).powi(2)
        } else {
            rule(i).stiffness * RELATIVE_TIME * dv.norm_squared()
        };
        let given = (Vector3::from(NODES[b]) - Vector3::from(NODES[a])).normalize();
        dashpot + BETA * rule(i).stiffness * given.dot(&dv).powi(2)
    });
    springs.sum::<f64>() + ALPHA * at.v.iter().zip(MASS).map(|(v, m)| m * v.norm_squared()).sum::<f64>()
}

/// Rows `[t, values…]`, linear between them and constant outside.
fn interpolated<const W: usize, const N: usize>(table: &[[f64; W]], t: f64) -> [f64; N] {
    let last = table.len() - 1;
    let t = t.clamp(table[0][0], table[last][0]);
    let i = table.iter().take(last).rposition(|row| row[0] <= t).unwrap_or(0);
    let share = (t - table[i][0]) / (table[i + 1][0] - table[i][0]);
    std::array::from_fn(|c| table[i][c + 1] + share * (table[i + 1][c + 1] - table[i][c + 1]))
}
