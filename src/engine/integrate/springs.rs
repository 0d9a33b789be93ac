//! What methods share that solve the springs of a scene one by one ([`crate::model::links`]), and take all other forces
//! from the start of their step.

use super::stepper::Unfit;
use super::{Counters, StageWork, StepError};
use crate::model::forces::Forces;
use crate::model::links::Link;
use crate::model::point::Point;
use crate::model::state::State;
use crate::model::system::SpringGraph;
use nalgebra::Vector3;

/// A vector `[n_dof]`, node by node.
pub(super) fn by_node(dofs: &[f64]) -> &[Vector3<f64>] {
    bytemuck::cast_slice(dofs)
}

/// The springs of a scene, and room for the forces of everything else.
#[derive(Debug, Default)]
pub(super) struct Springs {
    /// all of them, as they are in the present step
    pub links: Vec<Link>,
    /// whether their rest lengths change over time
    reeled: bool,
    /// [N] forces of everything else, if they are the same everywhere
    constant: Option<Vec<f64>>,
    /// [N] forces of everything else in the present step, where they are not `[n_dof]`
    others: Vec<f64>,
}

impl Springs {
    /// Whether a scene has springs that can be solved one by one.
    pub(super) fn fit(system: &dyn SpringGraph) -> Result<(), Unfit> {
        system.links().map(|_| ()).map_err(Unfit::Links)
    }

    /// Those of a scene at time `t` [s].
    pub(super) fn of(system: &dyn SpringGraph, t: f64) -> Self {
        // A scene without such springs is refused before it comes here.
        let Ok(found) = system.links() else { return Springs::default() };
        let mut links = vec![Link::NONE; found.count()];
        found.at(t, &mut links);
        let constant = found.rest_forces();
        let others = vec![0.0; if constant.is_some() { 0 } else { system.n_dof() }];
        Springs { links, reeled: found.reeled(), constant, others }
    }

    /// Takes the rest lengths at time `t` [s].
    pub(super) fn reel(&mut self, system: &dyn SpringGraph, t: f64) {
        if self.reeled
            && let Ok(found) = system.links()
        {
            found.at(t, &mut self.links);
        }
    }

    /// Whether a step needs the forces at its ends: for those of everything else, or for their works.
    pub(super) fn needs_forces(&self, at: &Forces) -> bool {
        self.constant.is_none() || self.reeled || !at.external.is_empty() || !at.dissipative.is_empty()
    }

    /// [N] The forces of all but springs and their dashpots at a state, where those of a pass are `forces`. Those at
    /// held degrees of freedom mean nothing. Springs must be those at its time.
    pub(super) fn find_others(&mut self, at: &State, forces: &Forces) {
        if self.constant.is_some() {
            return;
        }
        self.others.copy_from_slice(&forces.total);
        let (x, v) = (by_node(&at.x), by_node(&at.v));
        let others: &mut [Vector3<f64>] = bytemuck::cast_slice_mut(&mut self.others);
        for link in &self.links {
            let [a, b] = link.nodes.map(|node| node as usize);
            let (d, dv) = (x[b] - x[a], v[b] - v[a]);
            let l = d.norm();
            let mut force = link.relative * dv;
            if l > 0.0 {
                let n = d / l;
                force += link.within(link.stiffness * (l - link.rest) + link.axial * n.dot(&dv)) * n;
            }
            others[a] -= force;
            others[b] += force;
        }
    }

    /// [N] What [`Springs::find_others`] has found.
    pub(super) fn others(&self) -> &[f64] {
        self.constant.as_deref().unwrap_or(&self.others)
    }
}

/// Writes a state that is displacements `u` [m] after the start of a step of `h` [s]: x = x_n + u, v = u/h. What is
/// held keeps its velocity.
pub(super) fn end_of_step(u: &[f64], h: f64, inverse_mass: &[f64], state: &mut State) {
    for (((u, m), x), v) in u.iter().zip(inverse_mass).zip(&mut state.x).zip(&mut state.v) {
        *x += u;
        if *m > 0.0 {
            *v = u / h;
        }
    }
}

/// Both ends of a part of a step, with the works in all parts so far.
#[derive(Debug, Default)]
pub(super) struct Parts {
    /// the end of the last part
    at: Point,
    /// room for the next one
    next: Forces,
    work: StageWork,
}

impl Parts {
    /// Room for a scene.
    pub(super) fn new(at: &Point) -> Self {
        Parts { at: at.clone(), next: at.forces.clone(), work: StageWork::default() }
    }

    /// Begins a step.
    pub(super) fn begin(&mut self, from: &Point) {
        self.at.copy_from(from);
        self.work = StageWork::default();
    }

    /// The forces at the start of the present part.
    pub(super) fn forces(&self) -> &Forces {
        &self.at.forces
    }

    /// Ends a part at a state, where forces are found.
    pub(super) fn end(&mut self, system: &dyn SpringGraph, to: &State, counters: &mut Counters) {
        counters.evaluate(system, to.as_ref(), &mut self.next);
        let times = [self.at.state.t, to.t];
        let at = &mut self.at;
        let ends = [&at.forces, &self.next];
        self.work.add(1.0, StageWork::by_ends(system, ends, [&at.state.x, &to.x], times));
        at.state.copy_from(to.as_ref());
        std::mem::swap(&mut at.forces, &mut self.next);
    }

    /// The works of all parts, with the forces at the end of the last one.
    pub(super) fn finish(&self, to: &mut Forces) -> StageWork {
        to.copy_from(&self.at.forces);
        self.work
    }
}

/// Ends a sweep that a program has asked to stop.
pub(super) fn go_on() -> Result<(), StepError> {
    crate::interrupt::check().map_err(|asked| StepError::Linear(asked.into()))
}
