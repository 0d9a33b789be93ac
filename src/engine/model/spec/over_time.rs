//! Tables over time, and supports that move by them.

use serde::Serialize;

/// A factor or vector over time, linear between its rows, held constant outside them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Series<T> {
    /// [s] strictly increasing times; at least one
    pub t: Vec<f64>,
    /// one value per time
    pub value: Vec<T>,
}

impl<T: PartialEq> Series<T> {
    /// [s] Beginnings and ends of the parts between two rows that are not constant.
    pub fn changing(&self) -> impl Iterator<Item = [f64; 2]> {
        let rows = self.t.windows(2).zip(self.value.windows(2));
        rows.filter(|(_, value)| value[0] != value[1]).filter_map(|(t, _)| <[f64; 2]>::try_from(t).ok())
    }
}

impl Series<f64> {
    /// The same with rows of one value.
    pub fn rows(&self) -> Series<[f64; 1]> {
        Series { t: self.t.clone(), value: self.value.iter().map(|value| [*value]).collect() }
    }
}

impl<const N: usize> Series<[f64; N]> {
    /// The value at time `t` [s] of a table with at least one row and increasing times.
    pub fn at(&self, t: f64) -> [f64; N] {
        let after = self.t.partition_point(|&s| s <= t);
        match after {
            0 => self.value[0],
            n if n == self.t.len() => self.value[n - 1],
            n => {
                let (t0, t1) = (self.t[n - 1], self.t[n]);
                let s = (t - t0) / (t1 - t0);
                std::array::from_fn(|i| self.value[n - 1][i] * (1.0 - s) + self.value[n][i] * s)
            }
        }
    }

    /// The slope after the time `t` [s]; 0 before the first row and from the last one on.
    pub fn slope_after(&self, t: f64) -> [f64; N] {
        match self.t.partition_point(|&s| s <= t) {
            0 => [0.0; N],
            n if n == self.t.len() => [0.0; N],
            n => std::array::from_fn(|i| (self.value[n][i] - self.value[n - 1][i]) / (self.t[n] - self.t[n - 1])),
        }
    }

    /// [s] Times after 0 at which the slope changes, ascending.
    pub fn bends(&self) -> impl Iterator<Item = f64> {
        let before = |row: usize| row.checked_sub(1).map_or([0.0; N], |row| self.slope_after(self.t[row]));
        let bent = move |(row, t): &(usize, &f64)| **t > 0.0 && before(*row) != self.slope_after(**t);
        self.t.iter().enumerate().filter(bent).map(|(_, t)| *t)
    }
}

/// Directions of held nodes that a support moves.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MotionSpec {
    /// the nodes, with those of x, y, z that are moved; they are held at t = 0
    pub nodes: Vec<(u32, [bool; 3])>,
    /// [m] displacement from where the nodes are at t = 0; it is 0 there
    pub displacement: Series<[f64; 3]>,
    /// [m] displacement that the support has from the start, beside that
    #[serde(skip_serializing_if = "is_zero")]
    pub settlement: [f64; 3],
}

fn is_zero(settlement: &[f64; 3]) -> bool {
    *settlement == [0.0; 3]
}

/// [m/s] Velocity at t = 0 of what supports move, `[n_nodes][3]`; 0 elsewhere. Empty if nothing moves.
pub fn support_velocity(motions: &[MotionSpec], nodes: usize) -> Vec<[f64; 3]> {
    let mut velocity = if motions.is_empty() { Vec::new() } else { vec![[0.0; 3]; nodes] };
    for MotionSpec { nodes, displacement, .. } in motions {
        let of_support = displacement.slope_after(0.0);
        for &(node, moved) in nodes {
            let own = velocity.get_mut(node as usize).into_iter().flatten().zip(of_support).zip(moved);
            own.filter(|(_, moved)| *moved).for_each(|((v, of_support), _)| *v = of_support);
        }
    }
    velocity
}
