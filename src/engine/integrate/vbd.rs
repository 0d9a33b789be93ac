//! Vertex block descent (Chen, Liu, Yang & Yuksel 2024): backward Euler, solved node by node. Order 1, no large matrix.
//!
//! With the forces g of everything but springs and their dashpots at the step's start, x_{n+1} = x_n + u makes the sum
//! of |u - y|^2 m/(2 h^2) and the energy of springs least, where y = h v_n + h^2 w g, w = M^-1. From u = h v_n on, as
//! often as there are iterations, for every node i in the order of the scene:
//! ```text
//! f = -m/h^2 (u_i - y_i) + sum_j (T n + c_r (u_j - u_i)/h)          n, l: from i to j at x_n + u
//! H =  m/h^2 I + sum_j (T' n n^T + max(T, 0)/l (I - n n^T) + c_r/h I)
//! u_i += H^-1 f
//! x_{n+1} = x_n + u,   v_{n+1} = u/h
//! ```
//! T = k (l - l0) + c n . (u_j - u_i)/h within what the spring can carry, T' = k + c/h, or 0 beyond that. c are
//! dashpots along springs and c_r relative ones; the paper has Rayleigh damping in their place. A spring that pushes
//! would make H indefinite, so the part across it is left out there: H is positive definite, and only its f decides
//! where the iterations end. Converged, the step is that of backward Euler. Short of it, a load has come no further
//! through the net than by a node an iteration against their order. There is no search along the step of a node, as in
//! the paper; every step is made, and momentum is kept once converged only.
//!
//! The paper's order is by colours, for thousands of threads; here nodes follow one another as they lie in the scene,
//! on one thread. It begins from u = h v_n, without the paper's guess at how much of a weight is carried, and has no
//! Chebyshev acceleration.

use super::springs::{Springs, by_node, end_of_step, go_on};
use super::stepper::Unfit;
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::mesh::adjacency::Adjacency;
use crate::model::links::Link;
use crate::model::point::Point;
use crate::model::system::SpringGraph;
use nalgebra::{Matrix3, Vector3};

/// The method; carries nothing.
#[derive(Debug)]
pub struct Vbd {
    iterations: u32,
    springs: Springs,
    /// the springs at every node
    at_node: Adjacency,
    /// [m] y and u `[n_dof]`
    y: Vec<f64>,
    u: Vec<f64>,
}

impl Vbd {
    /// With so many sweeps over all nodes in a step.
    pub fn new(iterations: u32) -> Self {
        let at_node = Adjacency::new(0, std::iter::empty());
        Vbd { iterations, springs: Springs::default(), at_node, y: Vec::new(), u: Vec::new() }
    }
}

impl Integrator<dyn SpringGraph> for Vbd {
    fn fits(&self, system: &(dyn SpringGraph + 'static)) -> Result<(), Unfit> {
        Springs::fit(system)
    }

    fn start(&mut self, system: &(dyn SpringGraph + 'static), at: &Point) -> Result<(), StepError> {
        self.springs = Springs::of(system, at.state.t);
        self.y = vec![0.0; at.state.x.len()];
        self.u = self.y.clone();
        let ends = (0..).zip(&self.springs.links).flat_map(|(number, link)| link.nodes.map(|node| (node, number)));
        self.at_node = Adjacency::new(self.u.len() / 3, ends);
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn SpringGraph>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let Vbd { iterations, springs, at_node, y, u } = self;
        let w = system.inverse_mass();
        springs.reel(system, from.state.t);
        springs.find_others(&from.state, &from.forces);
        springs.reel(system, t_next);
        to.state.copy_from(from.state.as_ref());
        to.state.t = t_next;
        for ((((u, y), v), w), g) in u.iter_mut().zip(&mut *y).zip(&from.state.v).zip(w).zip(springs.others()) {
            *u = h * v;
            *y = *u + h * h * (w * g);
        }
        let step = Step { x_n: by_node(&from.state.x), y: by_node(y), w: by_node(w), h, links: &springs.links };
        for _ in 0..*iterations {
            go_on()?;
            step.sweep(at_node, bytemuck::cast_slice_mut(u));
        }
        counters.sweeps += u64::from(*iterations);
        end_of_step(u, h, w, &mut to.state);
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }
}

/// A step, in the letters of the module's equations.
struct Step<'a> {
    x_n: &'a [Vector3<f64>],
    y: &'a [Vector3<f64>],
    /// [1/kg] by degree of freedom
    w: &'a [Vector3<f64>],
    /// [s]
    h: f64,
    links: &'a [Link],
}

impl Step<'_> {
    /// One sweep over all nodes.
    fn sweep(&self, at_node: &Adjacency, u: &mut [Vector3<f64>]) {
        for (i, w) in self.w.iter().enumerate() {
            if *w != Vector3::zeros() {
                let correction = self.correction(i, at_node.row(i as u32), u);
                u[i] += correction;
            }
        }
    }

    /// [m] H^-1 f of node `i`.
    fn correction(&self, i: usize, springs: &[u32], u: &[Vector3<f64>]) -> Vector3<f64> {
        let (h, w) = (self.h, self.w[i]);
        // A held axis gets no force below, so that any number serves there.
        let inertia = w.map(|w| if w > 0.0 { 1.0 / (w * h * h) } else { 1.0 });
        let mut f = inertia.component_mul(&(self.y[i] - u[i]));
        let mut matrix = Matrix3::from_diagonal(&inertia);
        for &number in springs {
            let link = &self.links[number as usize];
            let [a, b] = link.nodes.map(|node| node as usize);
            let j = if a == i { b } else { a };
            let moved = u[j] - u[i];
            let d = (self.x_n[j] - self.x_n[i]) + moved;
            let l = d.norm();
            if l > 0.0 {
                let n = d / l;
                let taut = link.stiffness * (l - link.rest) + link.axial / h * n.dot(&moved);
                let tension = link.within(taut);
                let slope = if tension == taut { link.stiffness + link.axial / h } else { 0.0 };
                let across = tension.max(0.0) / l;
                f += tension * n;
                matrix += n * n.transpose() * (slope - across) + Matrix3::from_diagonal_element(across);
            }
            f += link.relative / h * moved;
            matrix += Matrix3::from_diagonal_element(link.relative / h);
        }
        for axis in (0..3).filter(|axis| w[*axis] == 0.0) {
            f[axis] = 0.0;
            matrix.row_mut(axis).fill(0.0);
            matrix.column_mut(axis).fill(0.0);
            matrix[(axis, axis)] = 1.0;
        }
        // Only numbers that overflow have no factor; what is left of them is no state, which the run notices.
        matrix.cholesky().map_or(Vector3::from_element(f64::NAN), |factor| factor.solve(&f))
    }
}
