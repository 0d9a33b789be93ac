//! Extended position-based dynamics (Macklin, Müller & Chentanez 2016) in small steps (Macklin et al. 2019), as games
//! and animation use it. Order 1, no matrix.
//!
//! Every step is n substeps of h. In each, with the forces g of everything but springs and their dashpots at its start:
//! ```text
//! u = h (v_n + h w g),   w = M^-1,   lambda = 0 for every spring
//! as often as there are iterations, for every spring in the order of the scene, with x = x_n + u:
//!     C = |x_b - x_a| - l0,   grad C = n at b, -n at a
//!     dlambda = (-C - alpha lambda - gamma n . (u_b - u_a)) / ((1 + gamma) (w_a + w_b) + alpha)
//!     u += w grad C dlambda,   lambda += dlambda
//! x_{n+1} = x_n + u,   v_{n+1} = u/h                 alpha = 1/(k h^2),   gamma = alpha (c h^2)/h = c/(k h)
//! ```
//! (2016, Eq. 18 and 26). The tension is -lambda/h^2. A spring with a slack law keeps it within what it can carry, as
//! contacts do: lambda is bounded (2016, section 5). A relative dashpot is solved likewise, as a spring of rest length
//! 0 and stiffness c/h between the displacements, together with its spring. Here both sides of a fraction are times
//! k h^2, so that a spring that is cut does nothing.
//!
//! One spring along a line is backward Euler with steps of h after one iteration, and so are chains along a line once
//! iterations have converged. Elsewhere springs turn within a step, and the displacement is a sum along directions n
//! that they have had, where backward Euler has the last one: what iterations converge to depends on their order by the
//! turn in a step. Iterations that have not converged leave springs too soft, the more the larger h^2 k w is and the
//! more springs lie between a load and what holds it; every step keeps linear momentum all the same, and is always
//! made.
//!
//! Results show the tension that positions give, as with all methods, which is -lambda/h^2 only once converged.

use super::springs::{Parts, Springs, by_node, end_of_step, go_on};
use super::stepper::Unfit;
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::links::Link;
use crate::model::point::Point;
use crate::model::system::SpringGraph;
use nalgebra::Vector3;

/// The method; carries nothing.
#[derive(Debug)]
pub struct Xpbd {
    /// n
    substeps: u32,
    iterations: u32,
    springs: Springs,
    /// [m] u `[n_dof]`
    u: Vec<f64>,
    /// [N s^2] lambda of every spring
    lambda: Vec<f64>,
    /// [N s^2] the same of relative dashpots; empty without any
    drag: Vec<Vector3<f64>>,
    parts: Parts,
}

impl Xpbd {
    /// With n substeps in a step and so many sweeps over all springs in each.
    pub fn new(substeps: u32, iterations: u32) -> Self {
        let (u, lambda, drag) = (Vec::new(), Vec::new(), Vec::new());
        Xpbd { substeps, iterations, springs: Springs::default(), u, lambda, drag, parts: Parts::default() }
    }
}

impl Integrator<dyn SpringGraph> for Xpbd {
    fn fits(&self, system: &(dyn SpringGraph + 'static)) -> Result<(), Unfit> {
        Springs::fit(system)
    }

    fn start(&mut self, system: &(dyn SpringGraph + 'static), at: &Point) -> Result<(), StepError> {
        self.springs = Springs::of(system, at.state.t);
        let links = &self.springs.links;
        self.u = vec![0.0; at.state.x.len()];
        self.lambda = vec![0.0; links.len()];
        let relative = links.iter().any(|link| link.relative > 0.0);
        self.drag = vec![Vector3::zeros(); if relative { links.len() } else { 0 }];
        self.parts = Parts::new(at);
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn SpringGraph>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let Xpbd { substeps, iterations, springs, u, lambda, drag, parts } = self;
        let (n, w) = (f64::from(*substeps), system.inverse_mass());
        let h = h / n;
        let in_parts = *substeps > 1 && springs.needs_forces(&from.forces);
        if in_parts {
            parts.begin(from);
        }
        to.state.copy_from(from.state.as_ref());
        for substep in 1..=*substeps {
            let begun = to.state.t;
            springs.reel(system, begun);
            springs.find_others(&to.state, if in_parts { parts.forces() } else { &from.forces });
            to.state.t = from.state.t + (t_next - from.state.t) * (f64::from(substep) / n);
            springs.reel(system, to.state.t);
            for (((u, v), w), g) in u.iter_mut().zip(&to.state.v).zip(w).zip(springs.others()) {
                *u = h * (v + h * (w * g));
            }
            lambda.fill(0.0);
            drag.fill(Vector3::zeros());
            let solve = Substep { x_n: by_node(&to.state.x), w: by_node(w), h };
            for _ in 0..*iterations {
                go_on()?;
                solve.sweep(&springs.links, bytemuck::cast_slice_mut(u), lambda, drag);
            }
            counters.sweeps += u64::from(*iterations);
            end_of_step(u, h, w, &mut to.state);
            if in_parts {
                parts.end(system, &to.state, counters);
            }
        }
        to.state.t = t_next;
        if in_parts {
            let work = Some(parts.finish(&mut to.forces));
            return Ok(StepReport { work, forces_at_end: true, ..Default::default() });
        }
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }
}

/// A substep, in the letters of the module's equations.
struct Substep<'a> {
    x_n: &'a [Vector3<f64>],
    /// [1/kg] by degree of freedom
    w: &'a [Vector3<f64>],
    /// [s]
    h: f64,
}

impl Substep<'_> {
    /// One sweep over all springs.
    fn sweep(&self, links: &[Link], u: &mut [Vector3<f64>], lambda: &mut [f64], drag: &mut [Vector3<f64>]) {
        let (h, mut drag) = (self.h, drag.iter_mut());
        for (link, lambda) in links.iter().zip(lambda) {
            let [a, b] = link.nodes.map(|node| node as usize);
            let moved = u[b] - u[a];
            let d = (self.x_n[b] - self.x_n[a]) + moved;
            let (l, k, c) = (d.norm(), h * h * link.stiffness, h * link.axial);
            let (mut none, c_r) = (Vector3::zeros(), h * link.relative);
            let drag = drag.next().unwrap_or(&mut none);
            let w = self.w[a] + self.w[b];
            // What a relative dashpot leaves of w, and what it lacks.
            let (left, lacks) = (w.map(|w| w / (1.0 + c_r * w)), -c_r * moved - *drag);
            let mut way = Vector3::zeros();
            if l > 0.0 {
                let n = d / l;
                let asked = -(k * (l - link.rest) + c * n.dot(&moved)) - (k + c) * n.dot(&left.component_mul(&lacks));
                let next = *lambda + (asked - *lambda) / (1.0 + (k + c) * n.component_mul(&n).dot(&left));
                let next = next.max(-h * h * link.most).min(-h * h * link.least);
                way = n * (next - *lambda);
                *lambda = next;
            }
            if c_r > 0.0 {
                let more = (lacks - c_r * w.component_mul(&way)).component_div(&w.map(|w| 1.0 + c_r * w));
                *drag += more;
                way += more;
            }
            u[a] -= self.w[a].component_mul(&way);
            u[b] += self.w[b].component_mul(&way);
        }
    }
}
