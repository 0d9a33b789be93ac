//! A step as a general linear method (Butcher 2016, chapter 5): all that a step is made of besides the forces.
//!
//! With the vectors y_j that a step begins with, x and v before all others, and the accelerations g_i = M^-1 f of its
//! stages, each stage and each vector at the end is a row of numbers times them:
//! ```text
//! x_i = sum_j X_ij y_j + sum_{j<=i} X_i,j g_j,     v_i likewise,     g_i = M^-1 f(t_n + c_i h, x_i, v_i)
//! ```
//! A stage is implicit where its rows have a share of its own g_i. Exact derivatives of a step
//! ([`crate::sensitivity`]) need no more of a scheme than this.

use super::stage::StageMap;

/// [-, s or s^2] The shares of the vectors that a step begins with, then of the accelerations of its stages. Shares
/// that are left out at the end are 0.
pub type Row = Vec<f64>;

/// A stage of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StageForm {
    /// [-] its time within the step
    pub c: f64,
    /// its positions
    pub x: Row,
    /// its velocities
    pub v: Row,
}

/// A step of one size.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepForm {
    /// of each vector that a scheme carries besides x and v: its shares of x, v and M^-1 f(t, x, v) where a run starts,
    /// or starts again
    pub start: Vec<[f64; 3]>,
    /// stages, in the order in which they are found
    pub stages: Vec<StageForm>,
    /// all vectors at the end of the step, x and v first
    pub next: Vec<Row>,
}

impl StepForm {
    /// What makes all vectors of a first step of x and v, with M^-1 f there as its only stage.
    pub fn beginning(&self) -> StepForm {
        let stages = match self.start.is_empty() {
            true => Vec::new(),
            false => vec![StageForm { c: 0.0, x: unit(0), v: unit(1) }],
        };
        let next = [unit(0), unit(1)].into_iter().chain(self.start.iter().map(|row| row.to_vec()));
        StepForm { start: Vec::new(), stages, next: next.collect() }
    }

    /// Vectors that a step begins with.
    pub fn carried(&self) -> usize {
        2 + self.start.len()
    }

    /// [s^2] and [s] The shares of a stage's own acceleration in its positions and velocities; 0 for an explicit stage.
    pub fn own(&self, stage: usize) -> [f64; 2] {
        let at = self.carried() + stage;
        let share = |row: &Row| row.get(at).copied().unwrap_or(0.0);
        self.stages.get(stage).map_or([0.0; 2], |of| [share(&of.x), share(&of.v)])
    }
}

/// The row of a single vector.
pub(super) fn unit(at: usize) -> Row {
    let mut row = vec![0.0; at + 1];
    row[at] = 1.0;
    row
}

/// A sum of rows with weights.
pub(super) fn sum(terms: &[(f64, &Row)]) -> Row {
    let mut made = vec![0.0; terms.iter().map(|(_, row)| row.len()).max().unwrap_or(0)];
    for (weight, row) in terms {
        made.iter_mut().zip(*row).for_each(|(made, share)| *made += weight * share);
    }
    made
}

/// How a scheme of a [`StageMap`] takes its acceleration into a step, and out of it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Carry {
    /// [-] share of the lag a - M^-1 f in it
    pub ratio: f64,
    /// [-] lag of the acceleration at the end, where another scheme makes the step
    pub lag: Option<f64>,
}

/// The step of a [`StageMap`]: it begins with x, v, a and M^-1 f, and has one stage, its end.
pub(super) fn of_map(map: StageMap, carry: Carry) -> StepForm {
    let [x_n, v_n, a_n, g_n, g] = [0, 1, 2, 3, 4].map(unit);
    let a = sum(&[(carry.ratio, &a_n), (1.0 - carry.ratio, &g_n)]);
    let new = 1.0 / (1.0 - map.am);
    let a_next = sum(&[((1.0 - map.af) * new, &g), (map.af * new, &g_n), (-map.am * new, &a)]);
    let z = sum(&[(1.0 / map.ca, &a_next), (-map.av / map.ca, &v_n), (-map.aa / map.ca, &a)]);
    let x = sum(&[(1.0, &x_n), (1.0, &z)]);
    let v = sum(&[(map.cv, &z), (map.vv, &v_n), (map.va, &a)]);
    let carried = match carry.lag {
        None => a_next,
        Some(lag) => sum(&[(1.0 - lag, &g), (lag, &a)]),
    };
    let end = StageForm { c: 1.0, x: x.clone(), v: v.clone() };
    StepForm { start: vec![[0.0, 0.0, 1.0]; 2], stages: vec![end], next: vec![x, v, carried, g] }
}

/// A Runge-Kutta step of `h` [s], explicit or diagonally implicit: rows a_ij of its stages with their own shares, their
/// times, and the weights of the result.
pub(super) fn of_tableau(h: f64, stages: &[(f64, Vec<f64>)], b: &[f64]) -> StepForm {
    let (x_n, v_n) = (unit(0), unit(1));
    let mut made: Vec<StageForm> = Vec::with_capacity(stages.len());
    let follow = |weights: &[f64], before: &[StageForm], own: Option<&Row>| {
        let velocities = before.iter().map(|stage| &stage.v).chain(own);
        let x: Vec<(f64, &Row)> = weights.iter().map(|a| h * a).zip(velocities).collect();
        sum(&[&[(1.0, &x_n)], &x[..]].concat())
    };
    let kick = |weights: &[f64]| {
        let slopes: Vec<Row> = (0..weights.len()).map(|stage| unit(2 + stage)).collect();
        let v: Vec<(f64, &Row)> = weights.iter().map(|a| h * a).zip(&slopes).collect();
        sum(&[&[(1.0, &v_n)], &v[..]].concat())
    };
    for (c, a) in stages {
        let v = kick(a);
        let x = follow(a, &made, Some(&v));
        made.push(StageForm { c: *c, x, v });
    }
    let next = vec![follow(b, &made, None), kick(b)];
    StepForm { start: Vec::new(), stages: made, next }
}
