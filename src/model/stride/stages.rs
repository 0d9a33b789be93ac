//! Steps of Runge-Kutta methods each of whose stages goes on from the slopes of the one before, and what happens to
//! nodes between their force passes.
//!
//! ```text
//! k_1 = (v_n, M^-1 f_n),   y_i = y_n + c_i h k_{i-1},   k_i = (v_i, M^-1 f(y_i))         y = (x, v)
//! y_{n+1} = y_n + h (b_1 k_1 + ... + b_s k_s)
//! ```
//! The same operations as in single steps, and in the same order: the same bits.

use multiversion::multiversion;

/// What a step is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stages<'a> {
    /// [s] b_1 h, if the slopes at the step's start count
    pub first: Option<f64>,
    /// the stages from the second on, at least one
    pub others: &'a [Stage],
}

/// One stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stage {
    /// [s] c_i h
    pub reach: f64,
    /// [s] b_i h
    pub weight: f64,
}

impl Stages<'_> {
    /// Force passes a step, with that at its end.
    pub fn passes(&self) -> usize {
        self.others.len() + 1
    }
}

/// Nodes between two passes: numbers side by side, as many of each.
#[derive(Debug)]
pub struct Staged<'a> {
    /// [1/kg]
    pub inverse_mass: &'a [f64],
    /// [m] and [m/s] where passes find them
    pub at: [&'a mut [f64]; 2],
    /// [m] and [m/s] where the step began
    pub from: [&'a mut [f64]; 2],
    /// [m] and [m/s] where it ends, as far as its stages are known
    pub sum: [&'a mut [f64]; 2],
    /// [N] what a pass has found; 0 afterwards, since the next one adds to it
    pub f: &'a mut [f64],
}

impl Stages<'_> {
    /// Begins a step with the forces at its start: nodes are then in its second stage.
    pub fn begin(&self, nodes: &mut Staged<'_>) {
        let reach = self.others.first().map_or(0.0, |stage| stage.reach);
        begin(nodes, self.first, reach);
    }

    /// Goes on with the forces of a stage, by its number among the others; after the last nodes are where the step
    /// ends.
    pub fn go_on(&self, nodes: &mut Staged<'_>, stage: usize) {
        let weight = self.others[stage].weight;
        match self.others.get(stage + 1) {
            Some(next) => go_on(nodes, weight, next.reach),
            None => arrive(nodes, weight),
        }
    }
}

/// Goes over all numbers of nodes, with their accelerations M^-1 f; forces are 0 afterwards.
macro_rules! over {
    ($nodes:expr, |$a:ident, $at:pat_param, $from:pat_param, $sum:pat_param| $body:block) => {
        let Staged { inverse_mass, at: [x, v], from: [x_n, v_n], sum: [x_s, v_s], f } = $nodes;
        let at = x.iter_mut().zip(v.iter_mut());
        let from = x_n.iter_mut().zip(v_n.iter_mut());
        let sum = x_s.iter_mut().zip(v_s.iter_mut());
        for (((($at, $from), $sum), f), m) in at.zip(from).zip(sum).zip(f.iter_mut()).zip(inverse_mass.iter()) {
            let $a = m * std::mem::take(f);
            $body
        }
    };
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn begin(nodes: &mut Staged<'_>, weight: Option<f64>, reach: f64) {
    over!(nodes, |a, (x, v), (x_n, v_n), (x_s, v_s)| {
        (*x_n, *v_n) = (*x, *v);
        (*x_s, *v_s) = match weight {
            Some(b) => (*x_n + b * *v_n, *v_n + b * a),
            None => (*x_n, *v_n),
        };
        (*x, *v) = (*x_n + reach * *v_n, *v_n + reach * a);
    });
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn go_on(nodes: &mut Staged<'_>, weight: f64, reach: f64) {
    over!(nodes, |a, (x, v), (x_n, v_n), (x_s, v_s)| {
        (*x_s, *v_s) = (*x_s + weight * *v, *v_s + weight * a);
        (*x, *v) = (*x_n + reach * *v, *v_n + reach * a);
    });
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn arrive(nodes: &mut Staged<'_>, weight: f64) {
    over!(nodes, |a, (x, v), _, (x_s, v_s)| {
        (*x, *v) = (*x_s + weight * *v, *v_s + weight * a);
    });
}
