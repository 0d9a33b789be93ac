//! Explicit Runge-Kutta methods (Kutta 1901), each of which is a tableau in a file of its own: `rk4.rs`,
//! `dormand_prince.rs` and so on.
//!
//! With y = (x, v) and the slopes k_i = (v_i, M^-1 f(t_i, x_i, v_i)):
//! ```text
//! y_i     = y_n + h sum_{j<i} a_ij k_j,     t_i = t_n + c_i h
//! y_{n+1} = y_n + h sum_i b_i k_i
//! e       = h sum_i e_i k_i                  e_i = b_i - b^_i, the weights minus those of a less accurate solution
//! ```
//! Stages of a pair also give a second, less accurate solution, and so an error estimate e (Fehlberg 1969; Hairer,
//! Norsett & Wanner 1993, section II.4). The last slope of `e` may be that of the new point itself, whose forces the
//! next step needs in any case ("first same as last"). So a step costs as many force passes as the method has stages,
//! and the estimate none.
//!
//! Where stages need no slope but the one before them and there is no estimate, one slope is held, and y_{n+1} is
//! summed as the stages come. Other methods hold all slopes; their sums are formed before they are added to y_n, so
//! that they lose no digits to a far origin.

use super::form::{StepForm, of_tableau};
use super::stepper::Scheme;
use super::updates::{Slopes, acceleration, accumulate, accumulate_slopes, follow, follow_on, power};
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

/// The estimate of a pair.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pair {
    /// weights of the error of the result
    pub estimate: Estimate,
    /// how the estimate compares with the error
    pub info: PairInfo,
}

/// A Butcher tableau. The first stage is y_n.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tableau {
    /// stages from the second on
    pub stages: &'static [Stage],
    /// [-] weights of the result, one for each stage
    pub b: &'static [f64],
    /// its estimate, if it has one
    pub pair: Option<Pair>,
}

impl Tableau {
    /// The method, which carries no state between steps.
    pub(super) fn scheme(&'static self) -> Scheme {
        let (slopes, x, v) = (Vec::new(), Vec::new(), Vec::new());
        Scheme::Explicit(Box::new(RungeKutta { tableau: self, slopes, x, v, forces: Forces::default() }))
    }

    /// Whether nothing needs a slope but the stage after it and the result.
    fn holds_one_slope(&self) -> bool {
        self.pair.is_none() && self.stages.iter().all(|stage| stage.a.iter().rev().skip(1).all(|a| *a == 0.0))
    }
}

/// The slope of a stage.
#[derive(Clone, Debug)]
pub(super) struct Slope {
    /// [m/s] v_i
    pub x: Vec<f64>,
    /// [m/s^2] M^-1 f_i
    pub v: Vec<f64>,
}

/// A method and what it holds within a step.
#[derive(Clone, Debug)]
struct RungeKutta {
    tableau: &'static Tableau,
    /// of all stages, and one more at the new point for the estimate; none where one slope is held
    slopes: Vec<Slope>,
    /// [m] positions of a stage
    x: Vec<f64>,
    /// [m/s] its velocities, where they are not in a slope
    v: Vec<f64>,
    forces: Forces,
}

impl RungeKutta {
    /// A step that holds one slope; its work [J].
    fn attempt_with_one_slope(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> StageWork {
        let (n, Tableau { stages, b, .. }) = (&from.state, self.tableau);
        let (y_n, times) = ([n.x.as_slice(), n.v.as_slice()], [n.t, t_next]);
        let (mut work, mut begun) = (StageWork::default(), false);
        let mut add = |i: usize, u: &[f64], forces: &Forces| {
            let weight = h * b.get(i).copied().unwrap_or(0.0);
            if weight != 0.0 {
                let (y, slopes) = ([&mut to.state.x[..], &mut to.state.v[..]], Slopes { u, f: &forces.total });
                match std::mem::replace(&mut begun, true) {
                    false => follow(system, y, y_n, weight, slopes),
                    true => accumulate_slopes(system, y, weight, slopes),
                }
                work.add(weight, power(system, times, forces));
            }
        };
        add(0, &n.v, &from.forces);
        for (i, Stage { c, a }) in (1..).zip(*stages) {
            let (y, h_a) = ([&mut self.x[..], &mut self.v[..]], h * a.last().copied().unwrap_or(0.0));
            match i {
                1 => follow(system, y, y_n, h_a, Slopes { u: &n.v, f: &from.forces.total }),
                _ => follow_on(system, y, y_n, h_a, &self.forces.total),
            }
            let t = if *c == 1.0 { t_next } else { n.t + c * h };
            counters.evaluate(system, StateRef { t, x: &self.x, v: &self.v }, &mut self.forces);
            add(i, &self.v, &self.forces);
        }
        work
    }

    /// A step that holds all slopes; its work [J].
    fn attempt_with_all_slopes(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> StageWork {
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
        advance(&mut to.state.x, &n.x, h, b, &self.slopes, |k| &k.x);
        advance(&mut to.state.v, &n.v, h, b, &self.slopes, |k| &k.v);
        work
    }
}

impl Integrator<dyn System> for RungeKutta {
    fn start(&mut self, system: &dyn System, at: &Point) -> Result<(), StepError> {
        let Tableau { stages, .. } = self.tableau;
        if stages.is_empty() {
            return Ok(());
        }
        self.x = at.state.x.clone();
        if self.tableau.holds_one_slope() {
            self.v = at.state.v.clone();
        } else {
            let zero = vec![0.0; at.state.x.len()];
            self.slopes = vec![Slope { x: zero.clone(), v: zero }; stages.len() + 2];
        }
        self.forces = system.new_forces();
        Ok(())
    }

    fn attempt(
        &mut self,
        step: StepInput<'_, dyn System>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let system = step.system;
        to.state.t = step.t_next;
        let work = match self.slopes.is_empty() {
            true => self.attempt_with_one_slope(step, to, counters),
            false => self.attempt_with_all_slopes(step, to, counters),
        };
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        // The ledger's mean of both ends is more accurate than the work of the first slope alone.
        let work = (!self.tableau.stages.is_empty()).then_some(work);
        Ok(StepReport { work, forces_at_end: true, ..Default::default() })
    }

    fn form(&self, h: f64, _: bool) -> Option<StepForm> {
        let later = self.tableau.stages.iter().map(|stage| (stage.c, stage.a.to_vec()));
        let stages: Vec<_> = std::iter::once((0.0, Vec::new())).chain(later).collect();
        Some(of_tableau(h, &stages, self.tableau.b))
    }

    fn pair(&self) -> Option<PairInfo> {
        self.tableau.pair.map(|pair| pair.info)
    }

    fn embedded_error(
        &mut self,
        StepInput { system, h, .. }: StepInput<'_, dyn System>,
        to: &Point,
        out: ErrorEstimate<'_>,
    ) {
        let Some(Pair { estimate, .. }) = self.tableau.pair else { return };
        if let Some(last) = self.slopes.last_mut() {
            last.x.copy_from_slice(&to.state.v);
            acceleration(system, &mut last.v, &to.forces.total);
        }
        let (slopes, buffer) = (&self.slopes, &mut self.x);
        match estimate {
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
    use super::super::{dop853, dormand_prince, euler_richardson, explicit_euler, improved_euler, rk4};
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

    fn estimate(tableau: &Tableau) -> Estimate {
        tableau.pair.expect("a pair").estimate
    }

    #[test]
    fn there_are_as_many_trees_as_there_are() {
        let counts: Vec<usize> = trees(&rows(&dop853::TABLEAU), 8).iter().map(Vec::len).collect();
        assert_eq!(counts, [0, 1, 1, 2, 4, 9, 20, 48, 115]);
    }

    #[test]
    fn rows_sum_to_their_times() {
        let classical = [&explicit_euler::TABLEAU, &improved_euler::TABLEAU, &euler_richardson::TABLEAU, &rk4::TABLEAU];
        for tableau in classical.into_iter().chain([&dormand_prince::TABLEAU, &dop853::TABLEAU]) {
            assert_eq!(tableau.b.len(), tableau.stages.len() + 1);
            for (i, stage) in (1..).zip(tableau.stages) {
                assert_eq!(stage.a.len(), i);
                assert!((stage.a.iter().sum::<f64>() - stage.c).abs() < 1e-14, "stage {i}");
            }
        }
    }

    #[test]
    fn classical_methods_meet_the_order_conditions() {
        let of_order = [
            (&explicit_euler::TABLEAU, 1),
            (&improved_euler::TABLEAU, 2),
            (&euler_richardson::TABLEAU, 2),
            (&rk4::TABLEAU, 4),
        ];
        for (tableau, order) in of_order {
            has_order(&rows(tableau), tableau.b, order);
        }
    }

    #[test]
    fn dormand_prince_meets_the_order_conditions() {
        let tableau = &dormand_prince::TABLEAU;
        let rows = rows(tableau);
        has_order(&rows, tableau.b, 5);
        let Estimate::One(e) = estimate(tableau) else { panic!("one estimate") };
        has_order(&rows, &less(tableau.b, e), 4);
        let leading = (tall(&rows, tableau.b, 6) - 1.0 / 720.0) / tall(&rows, e, 5);
        assert!((dormand_prince::LINEAR - leading.abs()).abs() < 1e-12, "{leading}");
    }

    #[test]
    fn dop853_meets_the_order_conditions() {
        let tableau = &dop853::TABLEAU;
        let rows = rows(tableau);
        has_order(&rows, tableau.b, 8);
        let Estimate::Two { fine, coarse } = estimate(tableau) else { panic!("two estimates") };
        has_order(&rows, &less(tableau.b, fine), 5);
        has_order(&rows, &less(tableau.b, coarse), 3);
        let estimate = tall(&rows, fine, 6).powi(2) / (0.1 * tall(&rows, coarse, 4));
        let leading = (tall(&rows, tableau.b, 9) - 1.0 / 362_880.0) / estimate;
        assert!((dop853::LINEAR / leading.abs() - 1.0).abs() < 1e-3, "{leading}");
    }
}
