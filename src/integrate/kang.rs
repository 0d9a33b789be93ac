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

use super::updates::accumulate;
use super::{Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::system::{SpringGraph, Viscosity};
use multiversion::multiversion;

/// Kang's scheme; carries nothing.
#[derive(Clone, Debug)]
pub struct Kang {
    /// [N/m] sum of the stiffnesses at every node
    stiffness_sum: Vec<f64>,
    /// [s] the step that `inverse_d` is for
    h: f64,
    /// [1/kg] D^-1
    inverse_d: Vec<f64>,
    /// [N] gravity
    weight: Vec<f64>,
    /// which dashpots are part of F already
    viscosity: Viscosity,
    /// F, the filtered forces
    filtered: Vec<f64>,
    /// h F_j / D_j
    sweep: Vec<f64>,
    /// sum_j k_ij (h F_j / D_j)
    neighbours: Vec<f64>,
    /// g, what acts outside the filter
    outside: Vec<f64>,
    /// dashpots of the scene that are part of F already, where they are not all of its dashpots
    inside: Vec<f64>,
}

impl Default for Kang {
    fn default() -> Self {
        let empty = Vec::new;
        Kang {
            stiffness_sum: empty(),
            h: 0.0,
            inverse_d: empty(),
            weight: empty(),
            viscosity: Viscosity::None,
            filtered: empty(),
            sweep: empty(),
            neighbours: empty(),
            outside: empty(),
            inside: empty(),
        }
    }
}

impl Integrator<dyn SpringGraph> for Kang {
    fn start(&mut self, system: &dyn SpringGraph, at: &Point) -> Result<(), StepError> {
        let n = at.state.x.len();
        self.stiffness_sum = system.stiffness_sums();
        self.weight = system.weight();
        self.viscosity = system.viscosity();
        self.h = 0.0;
        for buffer in
            [&mut self.inverse_d, &mut self.filtered, &mut self.sweep, &mut self.neighbours, &mut self.outside]
        {
            *buffer = vec![0.0; n];
        }
        self.inside = if self.viscosity == Viscosity::Some { vec![0.0; n] } else { Vec::new() };
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn SpringGraph>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        self.invert(system, h);
        self.split_forces(system, from, h);
        system.neighbour_sums(&self.sweep, &mut self.neighbours);
        to.state.t = t_next;
        let Kang { filtered: f, neighbours: sum, inverse_d, outside: g, .. } = &*self;
        let with = Advance { f, sum, inverse_d, g, inverse_mass: system.inverse_mass(), h };
        advance((&mut to.state.x, &mut to.state.v), (&from.state.x, &from.state.v), with);
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

    /// Fills `filtered` (springs and their implicit viscosity) and `outside` (everything else) from a force pass that is there already, and
    /// `sweep`.
    fn split_forces(&mut self, system: &dyn SpringGraph, from: &Point, h: f64) {
        let Kang { filtered: f, sweep, outside: g, weight, inside, neighbours, inverse_d, viscosity, .. } = self;
        let forces = &from.forces;
        let (viscous, share, dampers): (_, _, &[f64]) = match viscosity {
            // The scene's dashpots are F's, made for a step of so many seconds.
            Viscosity::All { seconds } => (&forces.dissipative, h / *seconds - 1.0, &[]),
            Viscosity::None | Viscosity::Some => {
                system.neighbour_differences(&from.state.v, neighbours);
                (&*neighbours, h, &forces.dissipative)
            }
        };
        let with = Filter { total: &forces.total, viscous, share, h, inverse_d };
        let out = (f.as_mut_slice(), sweep.as_mut_slice(), g.as_mut_slice());
        match (forces.external.as_slice(), dampers) {
            ([], []) => filter(out, with, [weight]),
            (one, []) | ([], one) => filter(out, with, [weight, one]),
            (one, other) => filter(out, with, [weight, one, other]),
        }
        if *viscosity == Viscosity::Some {
            system.step_dashpots(&from.state.v, inside);
            accumulate(g, -1.0, inside);
        }
    }
}

/// What F is made of.
struct Filter<'a> {
    /// [N] all forces
    total: &'a [f64],
    /// what is viscous: dashpots' forces [N], or sums of k (v_j - v_i) [N/s]
    viscous: &'a [f64],
    /// [-] or [s] what F has of it besides what is in `total`
    share: f64,
    /// [s]
    h: f64,
    /// [1/kg] D^-1
    inverse_d: &'a [f64],
}

/// g = the sum of what acts outside the filter, F = total - g + share * viscous, and h F / D
#[multiversion(targets("x86_64+avx+avx2"))]
fn filter<const N: usize>((f, sweep, g): (&mut [f64], &mut [f64], &mut [f64]), with: Filter<'_>, outside: [&[f64]; N]) {
    let (Filter { total, viscous, share, h, inverse_d }, n) = (with, f.len());
    let (sweep, g, total, viscous, inverse_d) =
        (&mut sweep[..n], &mut g[..n], &total[..n], &viscous[..n], &inverse_d[..n]);
    let outside = outside.map(|part| &part[..n]);
    for i in 0..n {
        g[i] = outside.iter().fold(0.0, |sum, part| sum + part[i]);
        f[i] = total[i] - g[i] + share * viscous[i];
        sweep[i] = h * f[i] * inverse_d[i];
    }
}

/// What a step is made of, in the letters of the module's equations.
struct Advance<'a> {
    f: &'a [f64],
    sum: &'a [f64],
    inverse_d: &'a [f64],
    g: &'a [f64],
    inverse_mass: &'a [f64],
    h: f64,
}

/// v = v_n + (h F + h^2 sum) / D + h M^-1 g, then x = x_n + h v
#[multiversion(targets("x86_64+avx+avx2"))]
fn advance((x, v): (&mut [f64], &mut [f64]), (x_n, v_n): (&[f64], &[f64]), with: Advance<'_>) {
    let (Advance { f, sum, inverse_d, g, inverse_mass, h }, n) = (with, x.len());
    let (v, x_n, v_n, f, sum) = (&mut v[..n], &x_n[..n], &v_n[..n], &f[..n], &sum[..n]);
    let (inverse_d, g, inverse_mass) = (&inverse_d[..n], &g[..n], &inverse_mass[..n]);
    for i in 0..n {
        v[i] = v_n[i] + (f[i] * h + h * h * sum[i]) * inverse_d[i] + h * inverse_mass[i] * g[i];
        x[i] = x_n[i] + h * v[i];
    }
}
