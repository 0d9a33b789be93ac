//! Kang's approximate implicit scheme (thesis Eq. 52-57, with k inside the sums; Kang, Choi, Cho & Park 2000). Order 1, no
//! matrix, O(n) a step. It is two Jacobi sweeps on backward Euler with scalar stiffness.
//!
//! With F_i = spring force + h sum_j k_ij (v_j - v_i) and D_i = m_i + h^2 sum_j k_ij:
//! ```text
//! dv_i = [ F_i h + h^2 sum_j k_ij (F_j h) / D_j ] / D_i
//! v_{n+1} = v_n + dv + h M^-1 g,      x_{n+1} = x_n + h v_{n+1}
//! ```
//! g are all other forces, outside the filter (gravity, air, loads, other dashpots). A relative dashpot with c = k h *is* the
//! viscous part of F and is not added a second time. A fixed node counts in its neighbours' D and contributes nothing to
//! their sums. With kappa = h^2 k/m the filter's artefacts: a spinning dumbbell keeps (1 + kappa^2)/(1 + kappa)^2 of its speed a
//! step, momentum drifts where nodes have unequal numbers of springs, and what acts outside it is met by filtered springs only: a weight on one
//! spring comes to rest 1 + kappa times as far down as it should.

use super::updates::add_scaled;
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::system::{GraphEdge, SpringGraph};

/// Kang's scheme; carries nothing.
#[derive(Clone, Debug, Default)]
pub struct Kang {
    edges: Vec<GraphEdge>,
    /// [N/m] sum of the stiffnesses at every node
    stiffness_sum: Vec<f64>,
    /// F, the filtered forces
    filtered: Vec<f64>,
    /// h F_j / D_j
    sweep: Vec<f64>,
    /// sum_j k_ij (h F_j / D_j)
    neighbours: Vec<f64>,
    /// g, what acts outside the filter
    outside: Vec<f64>,
}

impl Integrator<dyn SpringGraph> for Kang {
    fn start(&mut self, system: &dyn SpringGraph, at: &Point) -> Result<(), StepError> {
        let n = at.state.x.len();
        self.edges = system.edges();
        self.stiffness_sum = vec![0.0; n / 3];
        for e in &self.edges {
            for i in e.nodes {
                self.stiffness_sum[i as usize] += e.stiffness;
            }
        }
        for buffer in [&mut self.filtered, &mut self.sweep, &mut self.neighbours, &mut self.outside] {
            *buffer = vec![0.0; n];
        }
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn SpringGraph>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let n = &from.state;
        self.split_forces(system, from, h);
        let inverse_mass = system.inverse_mass();
        // D is m + h^2 K; with q = h^2 K / m its inverse is M^-1 / (1 + q), which is 0 at fixed degrees of freedom.
        let inverse_d = |dof: usize| {
            let m = inverse_mass[dof];
            m / (1.0 + h * h * self.stiffness_sum[dof / 3] * m)
        };
        for (dof, (s, f)) in self.sweep.iter_mut().zip(&self.filtered).enumerate() {
            *s = h * f * inverse_d(dof);
        }
        self.neighbours.fill(0.0);
        for e in &self.edges {
            let [a, b] = e.nodes.map(|i| 3 * i as usize);
            for c in 0..3 {
                self.neighbours[a + c] += e.stiffness * self.sweep[b + c];
                self.neighbours[b + c] += e.stiffness * self.sweep[a + c];
            }
        }
        to.state.t = t_next;
        for (dof, v) in to.state.v.iter_mut().enumerate() {
            let dv = (self.filtered[dof] * h + h * h * self.neighbours[dof]) * inverse_d(dof);
            *v = n.v[dof] + dv + h * inverse_mass[dof] * self.outside[dof];
        }
        add_scaled(&mut to.state.x, &n.x, h, &to.state.v);
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }
}

impl Kang {
    /// Fills `filtered` (springs and their implicit viscosity) and `outside` (everything else).
    fn split_forces(&mut self, system: &dyn SpringGraph, from: &Point, h: f64) {
        system.spring_forces(&from.state.x, &mut self.filtered);
        for ((g, total), spring) in self.outside.iter_mut().zip(&from.forces.total).zip(&self.filtered) {
            *g = total - spring;
        }
        let v = &from.state.v;
        for e in &self.edges {
            let [a, b] = e.nodes.map(|i| 3 * i as usize);
            for c in 0..3 {
                let dv = v[b + c] - v[a + c];
                self.filtered[a + c] += h * e.stiffness * dv;
                self.filtered[b + c] -= h * e.stiffness * dv;
                self.outside[a + c] -= e.step_dashpot * dv;
                self.outside[b + c] += e.step_dashpot * dv;
            }
        }
    }
}
