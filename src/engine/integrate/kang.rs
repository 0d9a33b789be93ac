//! Kang's approximate implicit scheme (thesis Eq. 52-57, with k inside the sums; Kang, Choi, Cho & Park 2000). Order 1,
//! no matrix, O(n) a step. It is two Jacobi sweeps on backward Euler with scalar stiffness.
//!
//! With F_i = spring force + h sum_j k_ij (v_j - v_i) and D_i = m_i + h^2 sum_j k_ij:
//! ```text
//! dv_i = [ F_i h + h^2 sum_j k_ij (F_j h) / D_j ] / D_i
//! v_{n+1} = v_n + dv + h M^-1 g,      x_{n+1} = x_n + h v_{n+1}
//! ```
//! g are all other forces, outside the filter (gravity, air, loads, other dashpots). A relative dashpot with c = k h
//! *is* the viscous part of F and is not added a second time. A fixed node counts in its neighbours' D and contributes
//! nothing to their sums.
//!
//! The published filter also acts along slack springs and brakes free flight on them to v exp(-k h t/m). Here a spring
//! with a slack law is in the filter only if it is taut at x or at x + h v. One that is slack at x but not at x + h v
//! pulls with k (l - l0) as if it were taut at x ([`StepFilter`]). So free flight keeps its speed, and a rope catches a
//! mass as with backward Euler, without energy gain at any kappa. A mass thrown back keeps 1/(1 + kappa) of its speed
//! in the step in which the rope goes slack. Rows or nets with some slack springs are about as stable as with all in
//! the filter, but not for every step: the two sweeps reach no further than the neighbours of neighbours. Two hanging
//! nets that swing down slack were tried. A rope of 20 springs with rest lengths of 1.2 times the mesh's was stable up
//! to kappa = 11 (with all in the filter up to 22). A square of 12 by 12 cells with 1.05 times was stable up to 11
//! (with all in the filter up to 7). A slack spring with a relative `"step"` dashpot stays in the filter, as its
//! viscosity was asked for.
//!
//! Artefacts of the filter, with kappa = h^2 k/m: a spinning dumbbell keeps (1 + kappa^2)/(1 + kappa)^2 of its speed a
//! step, and momentum drifts if nodes have unequal numbers of springs. Forces outside the filter meet filtered springs
//! only: a weight on one spring comes to rest 1 + kappa times too far down.

use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::forces::Forces;
use crate::model::point::Point;
use crate::model::system::{SpringGraph, StepFilter, Viscosity};
use multiversion::multiversion;
use std::ops::Range;

/// Kang's scheme; carries nothing.
#[derive(Debug, Default)]
pub struct Kang {
    /// [N/m] sum of the stiffnesses at every node
    stiffness_sum: Vec<f64>,
    /// [s] the step that `inverse_d` is for
    h: f64,
    /// [1/kg] D^-1
    inverse_d: Vec<f64>,
    /// [N] gravity
    weight: Vec<f64>,
    /// which dashpots F already contains
    viscosity: Viscosity,
    /// F, the filtered forces
    filtered: Vec<f64>,
    /// h F_j / D_j
    sweep: Vec<f64>,
    /// [N] dissipative forces outside F, if some are inside `[n_dof]`
    outer_dissipative: Vec<f64>,
    /// the springs in the filter of a step, if some may be slack
    step_filter: Option<Box<dyn StepFilter>>,
}

impl Integrator<dyn SpringGraph> for Kang {
    fn start(&mut self, system: &dyn SpringGraph, at: &Point) -> Result<(), StepError> {
        let n = at.state.x.len();
        self.stiffness_sum = system.stiffness_sums();
        self.weight = system.weight();
        self.viscosity = system.viscosity();
        self.step_filter = system.step_filter();
        self.h = 0.0;
        for buffer in [&mut self.inverse_d, &mut self.filtered, &mut self.sweep] {
            *buffer = vec![0.0; n];
        }
        self.outer_dissipative = if self.viscosity == Viscosity::Some { vec![0.0; n] } else { Vec::new() };
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn SpringGraph>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        if let Some(filter) = &mut self.step_filter
            && filter.select(from.state.as_ref(), h)
        {
            filter.stiffness_sums(&mut self.stiffness_sum);
            self.h = 0.0;
        }
        self.invert(system, h);
        self.find_outer_dissipative(system, from);
        let Kang { filtered, sweep, inverse_d, weight, outer_dissipative: outer, viscosity, step_filter, .. } = self;
        let step_filter = step_filter.as_deref();
        let step = Step { system, from, h, inverse_d, viscosity: *viscosity, step_filter };
        let sweeps = [filtered.as_mut_slice(), sweep.as_mut_slice()];
        to.state.t = t_next;
        let state = [to.state.x.as_mut_slice(), to.state.v.as_mut_slice()];
        let Forces { external, dissipative, .. } = &from.forces;
        // Most scenes have only their weight outside the filter; the cases avoid passes over absent forces.
        match (*viscosity, external.as_slice(), dissipative.as_slice()) {
            (Viscosity::All { .. }, [], _) | (_, [], []) => step.make(sweeps, state, [[weight]; 2]),
            (Viscosity::All { .. }, one, _) | (_, one, []) | (Viscosity::None, [], one) => {
                step.make(sweeps, state, [[weight, one]; 2]);
            }
            (Viscosity::None, one, other) => step.make(sweeps, state, [[weight, one, other]; 2]),
            (Viscosity::Some, [], all) => step.make(sweeps, state, [[weight, all], [weight, outer]]),
            (Viscosity::Some, one, all) => step.make(sweeps, state, [[weight, one, all], [weight, one, outer]]),
        }
        counters.evaluate(system, to.state.as_ref(), &mut to.forces);
        Ok(StepReport { forces_at_end: true, ..Default::default() })
    }
}

impl Kang {
    /// D is m + h^2 K; with q = h^2 K / m its inverse is M^-1 / (1 + q), which is 0 at fixed degrees of freedom.
    fn invert(&mut self, system: &dyn SpringGraph, h: f64) {
        if self.h == h {
            return;
        }
        self.h = h;
        for (dof, (inverse, m)) in self.inverse_d.iter_mut().zip(system.inverse_mass()).enumerate() {
            *inverse = m / (1.0 + h * h * self.stiffness_sum[dof / 3] * m);
        }
    }

    /// All dissipative forces except those of dashpots in F, if both exist.
    fn find_outer_dissipative(&mut self, system: &dyn SpringGraph, from: &Point) {
        if self.viscosity == Viscosity::Some {
            system.workers().set(&mut self.outer_dissipative, |r, out| {
                system.step_dashpots(&from.state.v, r.clone(), out);
                out.iter_mut().zip(&from.forces.dissipative[r]).for_each(|(out, all)| *out = all - *out);
            });
        }
    }
}

/// State and parameters of a step.
struct Step<'a> {
    system: &'a dyn SpringGraph,
    from: &'a Point,
    /// [s]
    h: f64,
    /// [1/kg] D^-1
    inverse_d: &'a [f64],
    viscosity: Viscosity,
    step_filter: Option<&'a dyn StepFilter>,
}

/// The forces outside the filter: as they enter the total of all forces, and as they act beside F.
type OuterForces<'a, const N: usize> = [[&'a [f64]; N]; 2];

impl Step<'_> {
    /// Makes both sweeps; the second moves the nodes.
    fn make<const N: usize>(
        &self,
        [f, sweep]: [&mut [f64]; 2],
        [x, v]: [&mut [f64]; 2],
        [in_total, beside]: OuterForces<'_, N>,
    ) {
        let Step { system, from, h, inverse_d, .. } = *self;
        let workers = system.workers();
        workers.both(f, sweep, |r, f, sweep| {
            let share = self.viscous(r.clone(), f);
            let with = Filter { total: &from.forces.total[r.clone()], share, h, inverse_d: &inverse_d[r.clone()] };
            filter([f, sweep], with, in_total.map(|part| &part[r.clone()]));
        });
        let (f, sweep) = (&*f, &*sweep);
        workers.both(x, v, |r, x, v| {
            match self.step_filter {
                Some(filter) => filter.neighbour_sums(sweep, r.clone(), v),
                None => system.neighbour_sums(sweep, r.clone(), v),
            }
            let (f, inverse_d) = (&f[r.clone()], &inverse_d[r.clone()]);
            let with = SecondSweep { f, inverse_d, inverse_mass: &system.inverse_mass()[r.clone()], h };
            let outside = beside.map(|part| &part[r.clone()]);
            advance([x, v], [&from.state.x[r.clone()], &from.state.v[r]], with, outside);
        });
    }

    /// Writes the viscous part of F into `out`: forces of dashpots [N], or sums of k (v_j - v_i) [N/s], with the step
    /// filter's correction over h. Returns its factor in F beyond what the total of all forces contains, [-] or [s].
    fn viscous(&self, dofs: Range<usize>, out: &mut [f64]) -> f64 {
        match self.viscosity {
            // The scene's dashpots are those of F, for a step of `seconds`.
            Viscosity::All { seconds } => {
                out.copy_from_slice(&self.from.forces.dissipative[dofs]);
                self.h / seconds - 1.0
            }
            Viscosity::None | Viscosity::Some => {
                let v = &self.from.state.v;
                match self.step_filter {
                    Some(filter) => filter.neighbour_differences(v, dofs.clone(), out),
                    None => self.system.neighbour_differences(v, dofs.clone(), out),
                }
                if let Some(correction) = self.step_filter.and_then(StepFilter::correction) {
                    out.iter_mut().zip(&correction[dofs]).for_each(|(out, force)| *out += force / self.h);
                }
                self.h
            }
        }
    }
}

/// Inputs of the first sweep.
struct Filter<'a> {
    /// [N] all forces
    total: &'a [f64],
    /// [-] or [s] factor of the viscous part in F beyond `total`
    share: f64,
    /// [s]
    h: f64,
    /// [1/kg] D^-1
    inverse_d: &'a [f64],
}

/// F = total - g + share * viscous, where f is the viscous part on entry, and h F / D
#[multiversion(targets("x86_64+avx+avx2"))]
fn filter<const N: usize>([f, sweep]: [&mut [f64]; 2], with: Filter<'_>, outside: [&[f64]; N]) {
    let (Filter { total, share, h, inverse_d }, n) = (with, f.len());
    let (sweep, total, inverse_d) = (&mut sweep[..n], &total[..n], &inverse_d[..n]);
    let outside = outside.map(|part| &part[..n]);
    for i in 0..n {
        let g = outside.iter().fold(0.0, |sum, part| sum + part[i]);
        f[i] = total[i] - g + share * f[i];
        sweep[i] = h * f[i] * inverse_d[i];
    }
}

/// Inputs of the second sweep, in the letters of the module's equations.
struct SecondSweep<'a> {
    f: &'a [f64],
    inverse_d: &'a [f64],
    inverse_mass: &'a [f64],
    h: f64,
}

/// v = v_n + (h F + h^2 sum) / D + h M^-1 g, where v is the sum; then x = x_n + h v
#[multiversion(targets("x86_64+avx+avx2"))]
fn advance<const N: usize>(
    [x, v]: [&mut [f64]; 2],
    [x_n, v_n]: [&[f64]; 2],
    with: SecondSweep<'_>,
    outside: [&[f64]; N],
) {
    let (SecondSweep { f, inverse_d, inverse_mass, h }, n) = (with, x.len());
    let (v, x_n, v_n, f) = (&mut v[..n], &x_n[..n], &v_n[..n], &f[..n]);
    let (inverse_d, inverse_mass) = (&inverse_d[..n], &inverse_mass[..n]);
    let outside = outside.map(|part| &part[..n]);
    for i in 0..n {
        let g = outside.iter().fold(0.0, |sum, part| sum + part[i]);
        v[i] = v_n[i] + (f[i] * h + h * h * v[i]) * inverse_d[i] + h * inverse_mass[i] * g;
        x[i] = x_n[i] + h * v[i];
    }
}
