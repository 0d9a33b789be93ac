//! The engine shared by Newmark, HHT, generalised alpha and backward Euler: one stage map, one Newton, one linear solver.
//!
//! The unknown is the displacement z of the step, over the free degrees of freedom, so that digits do not depend
//! on where the origin is. Per iteration: one force pass, W = cm M + cc C + ck K assembled into its slots, one
//! factorisation, one solve.

use super::kept::Kept;
use super::stage::StageMap;
use super::tangents::{Tangents, Which};
use super::{Carried, Counters, Integrator, StepError, StepInput, StepReport};
use crate::model::point::Point;
use crate::model::system::{TangentSystem, Weights};
use crate::solve::newton::{Curvature, Newton, NewtonFailure, NewtonSpec, NonlinearProblem, Scales, norm};
use crate::solve::{Inertia, LinearChoice, LinearError, LinearStats};

/// A scheme of the family: nothing but its stage map.
pub trait ImplicitScheme: Send {
    /// The map for a step of size `h` [s].
    fn map(&self, h: f64) -> StageMap;
}

/// How implicit steps are solved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SolverSpec {
    /// Newton's iteration
    pub newton: NewtonSpec,
    /// linear solver
    pub linear: LinearChoice,
}

/// A scheme with its solver; carries the algorithmic acceleration.
pub struct Implicit<M> {
    scheme: M,
    spec: SolverSpec,
    /// a_n, what the scheme carries
    a: Vec<f64>,
    /// [s] the step that a_n was made with; 0 before the first
    made_with: f64,
    /// [s] the step attempted last
    attempted: f64,
    solver: Option<Solver>,
}

/// What a step works with, made once.
struct Solver {
    tangents: Tangents,
    newton: Newton,
    kept: Kept,
    z: Vec<f64>,
    /// a_n as a step of another size would have left it
    a: Vec<f64>,
    a_next: Vec<f64>,
    inertia: Vec<f64>,
    weighted: Vec<f64>,
    /// [N/m] by degree of freedom
    stiffness: Vec<f64>,
    /// half way to a first guess
    halfway: Point,
    /// [1/s^2] weight of the mass in the W that is factorised, if the last attempt made one
    mass_weight: Option<f64>,
}

/// F(z) = 0 of one step.
struct Stage<'a> {
    system: &'a dyn TangentSystem,
    map: StageMap,
    from: &'a Point,
    a: &'a [f64],
    to: &'a mut Point,
    counters: &'a mut Counters,
    tangents: &'a mut Tangents,
    kept: &'a mut Kept,
    a_next: &'a mut [f64],
    /// (1 - am) a_{n+1} + am a_n
    weighted: &'a mut [f64],
    /// M times that
    inertia: &'a mut [f64],
    /// [N/m] by degree of freedom
    stiffness: &'a [f64],
    /// [s]
    h: f64,
    /// [m] largest coordinate, which sets the rounding of positions
    largest: f64,
    /// [N] size of the forces at the step's start
    force_scale: f64,
    guess: Guess,
    halfway: &'a mut Point,
    mass_weight: &'a mut Option<f64>,
}

/// First guesses for the step's displacement, from the best to the most cautious.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Guess {
    /// h v + h^2/2 a: of second order, saves an iteration in small steps
    ConstantAcceleration,
    /// h v
    ConstantVelocity,
    /// 0: the tangent of the state the step starts from decides where to go
    Rest,
}

/// A guess that changes the forces by more than this share of their size has left the neighbourhood in which it means
/// anything: it may have carried a spring past its anchor, from where Newton finds the mirrored solution.
const FORCE_CHANGE: f64 = 0.5;

/// [-] (w h)^2, with the stiffness and mass of a single unknown, above which a step is long for a spring: a guess may then
/// lie near the mirror image of its end, where the forces look right again. Half way there they do not.
const LONG_STEP: f64 = 4.0;

impl Stage<'_> {
    fn fill(&self, z: &mut [f64]) {
        let (h, v) = (self.h, &self.from.state.v);
        for (&dof, z) in self.tangents.dof.iter().zip(z) {
            let i = dof as usize;
            *z = match self.guess {
                Guess::ConstantAcceleration => h * (v[i] + 0.5 * h * self.a[i]),
                Guess::ConstantVelocity => h * v[i],
                Guess::Rest => 0.0,
            };
        }
    }

    /// Whether forces differ from those at the step's start by more than a share of their size.
    fn is_far(&self, forces: &[f64]) -> bool {
        let change: f64 = forces.iter().zip(&self.from.forces.total).map(|(a, b)| (a - b).powi(2)).sum();
        change.is_nan() || change.sqrt() > FORCE_CHANGE * self.force_scale
    }

    /// Of W = dF/dz.
    fn weights(&self) -> Weights {
        let new = 1.0 - self.map.af;
        Weights { m: (1.0 - self.map.am) * self.map.ca, c: new * self.map.cv, k: new }
    }

    fn is_long(&self) -> bool {
        let rates = self.stiffness.iter().zip(self.system.inverse_mass()).map(|(k, m)| k * m);
        self.h * self.h * rates.fold(0.0, f64::max) > LONG_STEP
    }

    /// Makes the kept factor again where another has taken its place since the last accepted step.
    fn recall(&mut self) -> Result<(), LinearError> {
        let Some((at, w, convex)) = self.kept.to_be_made() else { return Ok(()) };
        self.tangents.freeze(self.system, at, w, convex)?;
        if self.kept.recalled() {
            self.counters.tangent_assemblies += 1;
            self.counters.factorizations += 1;
        }
        Ok(())
    }

    fn evaluate_halfway(&mut self) {
        let (n, to, half) = (&self.from.state, &self.to.state, &mut self.halfway.state);
        half.t = to.t;
        for (half, (a, b)) in half.x.iter_mut().zip(n.x.iter().zip(&to.x)) {
            *half = 0.5 * (a + b);
        }
        half.v.copy_from_slice(&to.v);
        self.counters.evaluate(self.system, self.halfway.state.as_ref(), &mut self.halfway.forces);
    }
}

impl<M: ImplicitScheme> Implicit<M> {
    /// A scheme with its solver settings.
    pub fn new(scheme: M, spec: SolverSpec) -> Self {
        Implicit { scheme, spec, a: Vec::new(), made_with: 0.0, attempted: 0.0, solver: None }
    }
}

impl NonlinearProblem for Stage<'_> {
    fn residual(&mut self, z: &[f64], r: &mut [f64], floor: &mut [f64]) {
        let (n, map) = (&self.from.state, self.map);
        for (&dof, z) in self.tangents.dof.iter().zip(z) {
            let i = dof as usize;
            self.to.state.x[i] = n.x[i] + z;
            self.to.state.v[i] = map.cv * z + map.vv * n.v[i] + map.va * self.a[i];
            self.a_next[i] = map.ca * z + map.av * n.v[i] + map.aa * self.a[i];
            self.weighted[i] = (1.0 - map.am) * self.a_next[i] + map.am * self.a[i];
        }
        self.counters.evaluate(self.system, self.to.state.as_ref(), &mut self.to.forces);
        self.system.mass_times(self.weighted, self.inertia);
        let (f, f_n) = (&self.to.forces.total, &self.from.forces.total);
        // Positions are rounded to eps |x|, which springs turn into force; inertia is a difference of terms as large as
        // M v/(beta h).
        let moved = map.av.abs();
        for ((&dof, r), floor) in self.tangents.dof.iter().zip(r).zip(floor) {
            let i = dof as usize;
            let force = (1.0 - map.af) * f[i] + map.af * f_n[i];
            *r = self.inertia[i] - force;
            let mass = if self.weighted[i] != 0.0 { (self.inertia[i] / self.weighted[i]).abs() } else { 0.0 };
            let inertia = self.inertia[i].abs() + mass * moved * n.v[i].abs();
            *floor = 4.0 * f64::EPSILON * (self.stiffness[i] * self.largest + force.abs() + inertia);
        }
    }

    fn retreat(&mut self, z: &mut [f64]) -> bool {
        if self.guess == Guess::Rest {
            return false;
        }
        let mut too_far = self.is_far(&self.to.forces.total);
        if !too_far && self.is_long() {
            self.evaluate_halfway();
            too_far = self.is_far(&self.halfway.forces.total);
        }
        self.guess = match self.guess {
            Guess::ConstantAcceleration if too_far => Guess::ConstantVelocity,
            Guess::ConstantVelocity if too_far => Guess::Rest,
            _ => return false,
        };
        self.fill(z);
        true
    }

    fn conservative(&self) -> bool {
        self.tangents.symmetric()
    }

    fn linearise(&mut self, curvature: Curvature) -> Result<Inertia, LinearError> {
        let w = self.weights();
        self.counters.tangent_assemblies += 1;
        self.counters.factorizations += 1;
        *self.mass_weight = Some(w.m);
        // Where W is symmetric the two share their room.
        self.kept.is_lost(self.tangents.symmetric());
        self.tangents.factor(self.system, self.to.state.as_ref(), w, curvature)
    }

    fn freeze(&mut self) -> Result<bool, LinearError> {
        let w = self.weights();
        for convex in [false, true] {
            self.counters.tangent_assemblies += 1;
            self.counters.factorizations += 1;
            match self.tangents.freeze(self.system, self.to.state.as_ref(), w, convex)? {
                None => return Ok(false),
                Some(Inertia::Indefinite) => {}
                Some(_) => {
                    self.kept.take(self.to.state.as_ref(), w, convex);
                    return Ok(true);
                }
            }
        }
        Ok(false)
    }

    fn take_frozen(&mut self) {
        *self.mass_weight = Some(self.kept.weights().m);
        self.tangents.take(Which::Frozen);
    }

    fn factor_cost(&self) -> f64 {
        self.tangents.factor_cost()
    }

    fn solve(&mut self, b: &mut [f64]) -> Result<(), LinearError> {
        self.counters.linear_solves += 1;
        self.tangents.solve(b)
    }
}

impl<M: ImplicitScheme> Integrator<dyn TangentSystem> for Implicit<M> {
    fn start(&mut self, system: &dyn TangentSystem, at: &Point) -> Result<(), StepError> {
        let tangents = Tangents::new(system, self.spec.newton.strategy, self.spec.linear)?;
        let (n, unknowns) = (system.n_dof(), tangents.dof.len());
        let newton = Newton::new(self.spec.newton, unknowns);
        self.a = at.forces.total.iter().zip(system.inverse_mass()).map(|(f, m)| m * f).collect();
        let zero = || vec![0.0; n];
        let z = vec![0.0; unknowns];
        self.solver = Some(Solver {
            tangents,
            newton,
            kept: Kept::new(n),
            z,
            a: zero(),
            a_next: zero(),
            inertia: zero(),
            weighted: zero(),
            stiffness: system.nodal_stiffness(),
            halfway: at.clone(),
            mass_weight: None,
        });
        (self.made_with, self.attempted) = (0.0, 0.0);
        Ok(())
    }

    fn attempt(
        &mut self,
        StepInput { system, from, h, t_next }: StepInput<'_, dyn TangentSystem>,
        to: &mut Point,
        counters: &mut Counters,
    ) -> Result<StepReport, StepError> {
        let Some(s) = &mut self.solver else {
            return Err(StepError::Newton(NewtonFailure::NotFinite { worst: 0 }));
        };
        let map = self.scheme.map(h);
        to.state.copy_from(from.state.as_ref());
        to.state.t = t_next;
        let lag = Lag { h, made_with: self.made_with, a: &self.a };
        lag.carry_over(map, from, system.inverse_mass(), &mut s.a);
        self.attempted = h;
        s.mass_weight = None;
        let scales = scales(system, from, &s.a, map, &mut s.inertia);
        let largest = from.state.x.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        let mut stage = Stage {
            system,
            map,
            from,
            a: &s.a,
            to,
            counters,
            tangents: &mut s.tangents,
            kept: &mut s.kept,
            a_next: &mut s.a_next,
            weighted: &mut s.weighted,
            inertia: &mut s.inertia,
            stiffness: &s.stiffness,
            h,
            largest,
            force_scale: scales.residual,
            guess: Guess::ConstantAcceleration,
            halfway: &mut s.halfway,
            mass_weight: &mut s.mass_weight,
        };
        stage.recall()?;
        stage.fill(&mut s.z);
        let mut frozen = stage.kept.usable(stage.weights());
        let solved = s.newton.solve(&mut stage, &mut s.z, scales, &mut frozen);
        s.kept.learn(frozen);
        let iterations = solved.as_ref().map_or_else(NewtonFailure::iterations, |report| report.iterations);
        counters.newton_iterations += u64::from(iterations);
        let report = solved?;
        Ok(StepReport {
            newton_iterations: report.iterations,
            residual: report.residual,
            work: None,
            forces_at_end: true,
        })
    }

    fn accept(&mut self) {
        if let Some(s) = &mut self.solver {
            std::mem::swap(&mut self.a, &mut s.a_next);
            s.kept.accept();
            self.made_with = self.attempted;
        }
    }

    fn save(&self) -> Carried {
        let mut vectors = vec![self.a.clone()];
        let factor = self.solver.as_ref().and_then(|s| s.kept.save(&mut vectors));
        Carried { vectors, made_with: self.made_with, factor }
    }

    fn restore(&mut self, carried: &Carried) -> Result<(), StepError> {
        self.made_with = carried.made_with;
        match (&mut self.solver, &carried.factor) {
            (Some(s), Some(factor)) => {
                let [x, v] = s.kept.room();
                carried.take_into(&mut [&mut self.a, x, v])?;
                s.kept.restore(*factor);
                Ok(())
            }
            _ => carried.take_into(&mut [&mut self.a]),
        }
    }

    fn filter_error(
        &mut self,
        e: &mut [f64],
        system: &dyn TangentSystem,
        counters: &mut Counters,
    ) -> Result<(), StepError> {
        let Some(s) = &mut self.solver else { return Ok(()) };
        let Some(weight) = s.mass_weight else { return Ok(()) };
        if !e.iter().all(|e| e.is_finite()) {
            return Ok(());
        }
        system.mass_times(e, &mut s.inertia);
        for (&dof, b) in s.tangents.dof.iter().zip(&mut s.z) {
            *b = weight * s.inertia[dof as usize];
        }
        counters.linear_solves += 1;
        s.tangents.solve(&mut s.z)?;
        for (&dof, b) in s.tangents.dof.iter().zip(&s.z) {
            e[dof as usize] = *b;
        }
        Ok(())
    }

    fn dof_of_unknown(&self, unknown: usize) -> usize {
        let dof = self.solver.as_ref().and_then(|s| s.tangents.dof.get(unknown));
        dof.map_or(0, |&dof| dof as usize)
    }

    fn linear_stats(&self) -> Option<LinearStats> {
        self.solver.as_ref().and_then(|s| s.tangents.stats())
    }
}

/// The acceleration a scheme carries, on its way into a step of `h` [s].
struct Lag<'a> {
    h: f64,
    made_with: f64,
    a: &'a [f64],
}

impl Lag<'_> {
    /// HHT and generalised alpha carry an acceleration that stands for another time than the state, by a share of the step:
    /// a - M^-1 f is proportional to the step that made it, and is scaled to the next one's size. Left as it is, every change of the step would
    /// make an error of order h in a.
    fn carry_over(&self, map: StageMap, from: &Point, inverse_mass: &[f64], out: &mut [f64]) {
        let &Lag { h, made_with, a } = self;
        if made_with == 0.0 || made_with == h || map.am == 0.0 && map.af == 0.0 {
            out.copy_from_slice(a);
            return;
        }
        let ratio = h / made_with;
        for (((out, a), f), m) in out.iter_mut().zip(a).zip(&from.forces.total).zip(inverse_mass) {
            let now = m * f;
            *out = now + ratio * (a - now);
        }
    }
}

/// The sizes at the step's start that residuals and increments are compared with.
fn scales(system: &dyn TangentSystem, from: &Point, a: &[f64], map: StageMap, product: &mut [f64]) -> Scales {
    system.mass_times(a, product);
    let mut residual = system.force_scale(&from.forces).max(norm(product));
    if residual == 0.0 {
        // A start without any force: what moves is compared with the force that would stop it within the step.
        system.mass_times(&from.state.v, product);
        residual = norm(product) * (map.ca / map.cv).abs();
    }
    let increment = norm(&from.state.v) / map.cv.abs().max(f64::MIN_POSITIVE);
    Scales { residual, increment, increment_floor: 4.0 * f64::EPSILON * norm(&from.state.x) }
}
