//! Masses, stiffnesses and the residual of a scene at rest.

use super::Residual;
use crate::model::point::Point;
use crate::scene::Scene;

/// Data of the degrees of freedom.
pub(super) struct Dofs {
    /// [kg] `[n_dof]`, 0 at fixed ones
    pub mass: Vec<f64>,
    /// [N/m] `[n_dof]`
    pub stiffness: Vec<f64>,
    /// [m] size of the scene; 1 for one without
    pub size: f64,
    /// whether a node, in the user's numbering, can move `[n_nodes]`
    free: Vec<bool>,
}

impl Dofs {
    pub(super) fn of(scene: &dyn Scene) -> Self {
        let mut mass = vec![0.0; scene.n_dof()];
        scene.mass_times(&vec![1.0; scene.n_dof()], &mut mass);
        mass.iter_mut().zip(scene.inverse_mass()).filter(|(_, inverse)| **inverse == 0.0).for_each(|(m, _)| *m = 0.0);
        let size = if scene.size() > 0.0 { scene.size() } else { 1.0 };
        let mut free = vec![false; scene.reference().len()];
        for (dof, _) in scene.inverse_mass().iter().enumerate().filter(|(_, inverse)| **inverse > 0.0) {
            free.get_mut(scene.name_of(dof).0 as usize).into_iter().for_each(|free| *free = true);
        }
        Dofs { mass, stiffness: scene.nodal_stiffness(), size, free }
    }

    /// [N] Rounding error of every sum of forces: positions are rounded, which springs turn into force.
    pub(super) fn floor(&self, dof: usize, largest: f64, force: f64) -> f64 {
        4.0 * f64::EPSILON * (self.stiffness[dof] * largest + force.abs())
    }

    /// The forces left at a state. What they are compared with has the springs in it that balance each other, whose sum
    /// is 0.
    pub(super) fn residual(&self, scene: &dyn Scene, at: &Point) -> Residual {
        let total = &at.forces.total;
        let free = self.free.iter().map(|free| f64::from(u8::from(*free)));
        let tensions = scene.tension_sums(at.state.as_ref());
        let tensions: Vec<f64> = tensions.iter().zip(free).map(|(sum, free)| sum * free).collect();
        let largest = largest(&at.state.x);
        let floor: Vec<f64> = total.iter().enumerate().map(|(dof, f)| self.floor(dof, largest, *f)).collect();
        let size = |dof: usize| if total[dof].is_finite() { total[dof].abs() } else { f64::INFINITY };
        let workers = scene.workers();
        let reactions = workers.norm(&at.forces.reactions);
        Residual {
            force: workers.norm(total),
            scale: scene.force_scale(&at.forces).max(reactions).max(workers.norm(&tensions)),
            excess: workers.excess(total, &floor),
            worst: (0..total.len()).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(0),
        }
    }
}

/// [m] Largest coordinate, which sets the rounding of positions.
pub(super) fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}
