//! The equations of one solve: F(z) = mu M z - f(t, x + z, 0).

use super::unknowns::{Dofs, largest};
use crate::assembly::MixedForm;
use crate::integrate::Counters;
use crate::integrate::tangents::Tangents;
use crate::model::point::Point;
use crate::model::spring_state::{SheetState, SpringState};
use crate::model::stop::Stop;
use crate::model::system::{System, Weights};
use crate::scene::Scene;
use crate::solve::newton::{Curvature, MixedSprings, NonlinearProblem};
use crate::solve::{Inertia, LinearError};

/// F(z) = 0; z is the displacement of the unknowns [m].
pub(super) struct Proximal<'a> {
    pub scene: &'a dyn Scene,
    pub dofs: &'a Dofs,
    pub tangents: &'a mut Tangents,
    pub counters: &'a mut Counters,
    /// where z counts from
    pub from: &'a Point,
    /// the state of the last z
    pub to: &'a mut Point,
    /// [1/s^2] weight of the mass
    pub mu: f64,
    /// [N] residuals of all degrees of freedom `[n_dof]`
    pub all: &'a mut [f64],
    pub stop: Stop<'a>,
    /// whether the tensions of springs are unknowns, if there are springs
    pub mixed: bool,
}

impl NonlinearProblem for Proximal<'_> {
    fn residual(&mut self, z: &[f64], r: &mut [f64], floor: &mut [f64]) {
        self.to.state.x.copy_from_slice(&self.from.state.x);
        self.all.fill(0.0);
        for (&dof, z) in self.tangents.dof.iter().zip(z) {
            let dof = dof as usize;
            self.to.state.x[dof] += z;
            self.all[dof] = self.mu * self.dofs.mass[dof] * z;
        }
        self.counters.evaluate(self.scene, self.to.state.as_ref(), &mut self.to.forces);
        self.all.iter_mut().zip(&self.to.forces.total).for_each(|(r, f)| *r -= f);
        self.scene.with_apparent_mass(self.to.state.as_ref(), self.all);
        let most = largest(&self.from.state.x);
        for ((&dof, z), (r, floor)) in self.tangents.dof.iter().zip(z).zip(r.iter_mut().zip(floor)) {
            let dof = dof as usize;
            *r = self.all[dof];
            let inertia = self.mu * self.dofs.mass[dof] * z;
            *floor = self.dofs.floor(dof, most, self.to.forces.total[dof].abs() + inertia.abs());
        }
    }

    fn keep_apart(&mut self, z: &[f64], dz: &mut [f64]) -> Option<f64> {
        let touches = self.scene.touches()?;
        let (mut x, mut way) = (self.from.state.x.clone(), vec![0.0; self.from.state.x.len()]);
        for (&dof, (z, dz)) in self.tangents.dof.iter().zip(z.iter().zip(&*dz)) {
            x[dof as usize] += z;
            way[dof as usize] = *dz;
        }
        let least = touches.keep_apart(&x, [self.to.state.t; 2], &mut way);
        dz.iter_mut().zip(&*self.tangents.dof).for_each(|(dz, &dof)| *dz = way[dof as usize]);
        Some(least)
    }

    fn conservative(&self) -> bool {
        self.tangents.symmetric()
    }

    fn linearise(&mut self, curvature: Curvature) -> Result<Inertia, LinearError> {
        // The search around this iteration sees the request, too.
        if self.stop.asked() {
            return Err(LinearError::Singular { unknown: None });
        }
        let w = self.weights();
        let made = self.tangents.factor(self.scene, self.to.state.as_ref(), w, curvature, self.counters)?;
        // So small a weight that rounding hides it: there is no direction to follow.
        if made == Inertia::Indefinite && curvature == Curvature::Convex && self.conservative() {
            return Err(LinearError::Singular { unknown: None });
        }
        Ok(made)
    }

    fn mixed(&mut self) -> Option<&mut dyn MixedSprings> {
        if self.mixed && self.counts()[0] > 0 { Some(self) } else { None }
    }

    fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        self.tangents.solve(b, self.counters)
    }
}

impl MixedSprings for Proximal<'_> {
    /// Membranes keep the stresses of their strains.
    fn counts(&self) -> [usize; 2] {
        self.scene.mixed().map_or([0; 2], |mixed| [mixed.springs(), 0])
    }

    fn measure_start(&mut self, springs: &mut [SpringState], _: &mut [SheetState]) {
        if let Some(mixed) = self.scene.mixed() {
            mixed.measure(self.from.state.as_ref(), 0.0, springs);
        }
    }

    fn measure(&mut self, springs: &mut [SpringState], _: &mut [SheetState]) {
        if let Some(mixed) = self.scene.mixed() {
            mixed.measure(self.to.state.as_ref(), 0.0, springs);
        }
    }

    fn linearise(&mut self, form: MixedForm<'_>) -> Result<Inertia, LinearError> {
        let scene = self.scene;
        let Some(mixed) = scene.mixed().filter(|_| !self.stop.asked()) else {
            return Err(LinearError::Singular { unknown: None });
        };
        let at = (self.to.state.as_ref(), self.weights());
        self.tangents.factor_mixed((scene, mixed), at, form, self.counters)
    }

    fn dofs(&self) -> (&[u32], usize) {
        (&self.tangents.dof, self.all.len())
    }

    fn weight(&self) -> f64 {
        1.0
    }
}

impl Proximal<'_> {
    fn weights(&self) -> Weights {
        Weights { m: self.mu, c: 0.0, k: 1.0 }
    }
}

/// [1/s^2] The weight with which no node moves farther in the first solve than a share of the scene, whatever its
/// stiffness.
pub(super) fn cautious_weight(scene: &dyn System, at: &Point, longest: f64) -> f64 {
    let accelerations = at.forces.total.iter().zip(scene.inverse_mass()).map(|(f, inverse)| (f * inverse).abs());
    accelerations.filter(|a| a.is_finite()).fold(0.0, f64::max) / longest
}
