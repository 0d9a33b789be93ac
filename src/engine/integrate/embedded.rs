//! Explicit Runge-Kutta methods whose stages also give a second, less accurate solution, and so an error estimate
//! (Fehlberg 1969; Hairer, Norsett & Wanner 1993, section II.4).
//!
//! With y = (x, v) and the slopes k_i = (v_i, M^-1 f(t_i, x_i, v_i)):
//! ```text
//! y_i     = y_n + h sum_{j<i} a_ij k_j,     t_i = t_n + c_i h
//! y_{n+1} = y_n + h sum_i b_i k_i
//! e       = h sum_i e_i k_i                  e_i = b_i - b^_i, the weights minus those of the less accurate solution
//! ```
//! The last slope of `e` may be that of the new point itself, whose forces the next step needs in any case ("first same
//! as last"). So a step costs as many force passes as the method has stages, and the estimate none. Sums are formed
//! before they are added to y_n, so that they lose no digits to a far origin.

use super::updates::{acceleration, accumulate, power};
use super::{Counters, ErrorEstimate, Integrator, PairInfo, StageWork, StepError, StepInput, StepReport};
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::state::StateRef;
use crate::model::system::System;

/// A row of a Butcher tableau.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stage {
    /// [-] its time within the step
    pub c: f64,
    /// [-] weights of the slopes before it
    pub a: &'static [f64],
}

/// Weights of the estimate, one for each stage and, where it is used, one for the new point.
#[derive(Clone, Copy, Debug)]
pub(super) enum Estimate {
    /// the difference from the coarser solution
    One(&'static [f64]),
    /// `|e|^2 / sqrt(|e|^2 + 0.01 |e'|^2)` of a fine e and a coarse e' (Hairer, Norsett & Wanner 1993, section II.10)
    Two {
        /// e
        fine: &'static [f64],
        /// e'
        coarse: &'static [f64],
    },
}

/// A Butcher tableau with its estimate. The first stage is y_n.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tableau {
    /// stages from the second on
    pub stages: &'static [Stage],
    /// [-] weights of the result
    pub b: &'static [f64],
    /// weights of its error
    pub estimate: Estimate,
    /// how the estimate compares with the error
    pub info: PairInfo,
}

/// The slope of a stage.
#[derive(Clone, Debug)]
pub(super) struct Slope {
    /// [m/s] v_i
    pub x: Vec<f64>,
    /// [m/s^2] M^-1 f_i
    pub v: Vec<f64>,
}

/// The method of a tableau; it carries no state between steps.
#[derive(Clone, Debug)]
pub(super) struct Embedded {
    tableau: &'static Tableau,
    slopes: Vec<Slope>,
    /// [m] positions of a stage; its velocities are its slope
    x: Vec<f64>,
    forces: Forces,
}

impl Embedded {
    /// The method of `tableau`.
    pub fn new(tableau: &'static Tableau) -> Self {
        Embedded { tableau, slopes: Vec::new(), x: Vec::new(), forces: Forces::default() }
    }
}

impl Integrator<dyn System> for Embedded {
    fn start(&mut self, system: &dyn System, at: &Point) -> Result<(), StepError> {
        let zero = vec![0.0; at.state.x.len()];
        // One more than the stages: the slope at the new point, for the estimate.
        let count = self.tableau.stages.len() + 2;
        self.slopes = vec![Slope { x: zero.clone(), v: zero.clone() }; count];
        self.x = zero;
        self.forces = system.new_forces();
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let (n, Tableau { stages, b, .. }) = (&from.state, self.tableau);
        let (mut work, times) = (StageWork::default(), [n.t, t_next]);
        if let Some(first) = self.slopes.first_mut() {
            first.x.copy_from_slice(&n.v);
            acceleration(system, &mut first.v, &from.forces.total);
            work.add(h * b.first().copied().unwrap_or(0.0), power(system, times, &from.forces));
        }
        for (i, Stage { c, a }) in (1..).zip(*stages) {
            let (before, rest) = self.slopes.split_at_mut(i);
            let Some(slope) = rest.first_mut() else { break };
            advance(&mut self.x, &n.x, h, a, before, |k| &k.x);
            advance(&mut slope.x, &n.v, h, a, before, |k| &k.v);
            let t = if *c == 1.0 { t_next } else { n.t + c * h };
            counters.evaluate(system, StateRef { t, x: &self.x, v: &slope.x }, &mut self.forces);
            acceleration(system, &mut slope.v, &self.forces.total);
            work.add(h * b.get(i).copied().unwrap_or(0.0), power(system, times, &self.forces));
        }
        to.state.t = t_next;
        advance(&mut to.state.x, &n.x, h, b, &self.slopes, |k| &k.x);
        advance(&mut to.state.v, &n.v, h, b, &self.slopes, |k| &k.v);
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        Ok(StepReport { work: Some(work), forces_at_end: true, ..Default::default() })
    }

    fn pair(&self) -> Option<PairInfo> {
        Some(self.tableau.info)
    }

    fn embedded_error(
        &mut self,
        StepInput { system, h, .. }: StepInput<'_, dyn System>,
        to: &Point,
        out: ErrorEstimate<'_>,
    ) {
        if let Some(last) = self.slopes.last_mut() {
            last.x.copy_from_slice(&to.state.v);
            acceleration(system, &mut last.v, &to.forces.total);
        }
        let (slopes, buffer) = (&self.slopes, &mut self.x);
        match self.tableau.estimate {
            Estimate::One(e) => {
                weighted(out.x, h, e, slopes, |k| &k.x);
                weighted(out.v, h, e, slopes, |k| &k.v);
            }
            Estimate::Two { fine, coarse } => {
                combined(out.x, buffer, (h, [fine, coarse]), slopes, |k| &k.x);
                combined(out.v, buffer, (h, [fine, coarse]), slopes, |k| &k.v);
            }
        }
    }
}

pub(super) type Part = fn(&Slope) -> &[f64];

/// Degrees of freedom summed at once: few enough for the sums to stay in the first cache while the slopes pass by.
const BLOCK: usize = 256;

/// out = base + h sum of weight * slope
pub(super) fn advance(out: &mut [f64], base: &[f64], h: f64, weights: &[f64], slopes: &[Slope], part: Part) {
    weighted(out, h, weights, slopes, part);
    accumulate(out, 1.0, base);
}

/// out = h sum of weight * slope
pub(super) fn weighted(out: &mut [f64], h: f64, weights: &[f64], slopes: &[Slope], part: Part) {
    for (block, out) in out.chunks_mut(BLOCK).enumerate() {
        out.fill(0.0);
        for (w, slope) in weights.iter().zip(slopes).filter(|(w, _)| **w != 0.0) {
            if let Some(k) = part(slope).get(block * BLOCK..) {
                accumulate(out, h * w, k);
            }
        }
    }
}

/// out = e |e| / sqrt(|e|^2 + 0.01 |e'|^2), whose norm is that of [`Estimate::Two`]; `buffer` holds e'.
fn combined(out: &mut [f64], buffer: &mut [f64], (h, two): (f64, [&[f64]; 2]), slopes: &[Slope], part: Part) {
    let square = |e: &[f64]| e.iter().map(|e| e * e).sum::<f64>();
    let [fine, coarse] = two;
    weighted(out, h, fine, slopes, part);
    weighted(buffer, h, coarse, slopes, part);
    let (fine, coarse) = (square(out), square(buffer));
    let share = (fine / (fine + 0.01 * coarse)).sqrt();
    if fine > 0.0 {
        out.iter_mut().for_each(|e| *e *= share);
    }
}

#[cfg(test)]
mod tests {
    use super::super::order_conditions::{has_order, tall, trees};
    use super::super::{dop853, dormand_prince};
    use super::*;

    /// a_ij with a row for the new point.
    fn rows(tableau: &Tableau) -> Vec<&'static [f64]> {
        let stages = tableau.stages.iter().map(|stage| stage.a);
        std::iter::once(&[] as &[f64]).chain(stages).chain([tableau.b]).collect()
    }

    /// b less the weights of an estimate; the new point's slope counts as one more stage.
    fn less(b: &[f64], e: &[f64]) -> Vec<f64> {
        (0..b.len() + 1).map(|i| b.get(i).copied().unwrap_or(0.0) - e.get(i).copied().unwrap_or(0.0)).collect()
    }

    #[test]
    fn there_are_as_many_trees_as_there_are() {
        let counts: Vec<usize> = trees(&rows(&dop853::TABLEAU), 8).iter().map(Vec::len).collect();
        assert_eq!(counts, [0, 1, 1, 2, 4, 9, 20, 48, 115]);
    }

    #[test]
    fn rows_sum_to_their_times() {
        for tableau in [&dormand_prince::TABLEAU, &dop853::TABLEAU] {
            assert_eq!(tableau.b.len(), tableau.stages.len() + 1);
            for (i, stage) in (1..).zip(tableau.stages) {
                assert_eq!(stage.a.len(), i);
                assert!((stage.a.iter().sum::<f64>() - stage.c).abs() < 1e-14, "stage {i}");
            }
        }
    }

    #[test]
    fn dormand_prince_meets_the_order_conditions() {
        let tableau = &dormand_prince::TABLEAU;
        let rows = rows(tableau);
        has_order(&rows, tableau.b, 5);
        let Estimate::One(e) = tableau.estimate else { panic!("one estimate") };
        has_order(&rows, &less(tableau.b, e), 4);
        let leading = (tall(&rows, tableau.b, 6) - 1.0 / 720.0) / tall(&rows, e, 5);
        assert!((dormand_prince::LINEAR - leading.abs()).abs() < 1e-12, "{leading}");
    }

    #[test]
    fn dop853_meets_the_order_conditions() {
        let tableau = &dop853::TABLEAU;
        let rows = rows(tableau);
        has_order(&rows, tableau.b, 8);
        let Estimate::Two { fine, coarse } = tableau.estimate else { panic!("two estimates") };
        has_order(&rows, &less(tableau.b, fine), 5);
        has_order(&rows, &less(tableau.b, coarse), 3);
        let estimate = tall(&rows, fine, 6).powi(2) / (0.1 * tall(&rows, coarse, 4));
        let leading = (tall(&rows, tableau.b, 9) - 1.0 / 362_880.0) / estimate;
        assert!((dop853::LINEAR / leading.abs() - 1.0).abs() < 1e-3, "{leading}");
    }
}
