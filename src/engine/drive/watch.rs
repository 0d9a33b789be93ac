//! The watch: finds divergence from the energy account, by the first law of thermodynamics.
//!
//! ```text
//! supplied    = kinetic + elastic at t = 0, and the largest energy supplied since by gravity and external work
//! made        = how far `numerical` has fallen below its highest value, and work of the wrong sign
//! load_energy = 1/2 h^2 sum f^2/m of the loads at the start, or of later ones on resting masses: what one step gives
//! held        = load_energy, or where steps are long against the mean frequency w^2 = sum k/sum m, 4/(w h)^2 of it
//! diverged:     made > 10 (supplied + load_energy)      or       elastic > 10 (supplied + held)
//! ```
//! The supplied energy bounds all motion, so the energy made by the scheme is compared with it. It is not compared with
//! the exchanged energy: what the scheme makes becomes kinetic, elastic and dissipated energy, so their ratio could
//! never reach ten. The bound needs no chosen length, speed or strain: a speed or a strain that needs more than ten
//! times all energy ever supplied is impossible.
//!
//! Schemes of first order move masses one step late, so they make up to `load_energy` in the first step of any load.
//! The work that the account has of a load that changes in its first step is as wrong for any scheme: it is 0 where the
//! load begins at 0, and below 0 where it changes its sign, although it has moved masses. The work f v h in a later
//! step is at most the kinetic energy and `load_energy`. Loads that begin or grow later count as long as those before
//! them, and what was supplied, explain what was made.
//!
//! Kang's filter contains dashpots, whose work the account evaluates outside it, far too large in long steps. For it,
//! only energy that is present counts as made, and dissipated energy as lost. The trapezoidal rule of the ledger misses
//! one fault. Where a step overshoots in a viscous force, explicit Euler and velocity Verlet get from
//! 1/2 (f_n + f_{n+1}).(x_{n+1} - x_n) exactly the energy they make. Therefore energy from dashpots counts as made by
//! the scheme. So does work of the air above twice its power at either end of the step times h.

use super::observer::Energies;
use crate::integrate::registry::{Family, MethodInfo};
use crate::model::forces::{Role, Tally};
use crate::model::point::Point;
use crate::model::state::StateRef;
use crate::model::system::TermInfo;
use crate::scene::Scene;

/// [-] Energy made, or elastic energy, above this many times the supplied energy is a divergence.
const DIVERGED: f64 = 10.0;
/// [-] Energy made above this share of the supplied energy leads to a warning.
pub const DOUBTFUL: f64 = 0.1;
/// [-] There is no warning while the energy made is below this many times `load_energy`, which a scheme of first order
/// makes in the first step of a load.
const BEYOND_LOAD_ENERGY: f64 = 10.0;
/// [-] A state is not credible where springs hold more than this many times the supplied energy: the scheme may have
/// made as much again.
const CREDIBLE: f64 = 2.0;
/// [-] Rounding errors of a position or a force in a step.
const ROUNDINGS: f64 = 8.0;
/// [-] Share of the energies in the account that is lost to rounding in long sums.
const SUMS: f64 = 1e-12;
/// Number of past gains kept to compute their growth.
const KEPT: usize = 5;

/// What the watch keeps and cannot compute again from the scene: part of a snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct EnergyAccount {
    /// [J] kinetic, elastic and gravity energy at the start
    base: f64,
    /// [J] energy present at the start, or supplied by gravity, loads and air since
    supplied: f64,
    /// [J] work of the wrong sign so far
    contrary: f64,
    /// [J] work of the air by its power, above that of the account, so far
    missed: f64,
    /// [J] lowest of all energy made so far
    least: f64,
    /// [J] the last gains, the newest last
    gains: [f64; KEPT],
    /// [J] largest gain so far
    largest: f64,
    /// [s] longest step so far
    longest: f64,
    /// [J] largest energy that loads which begin or grow later give in one step
    late_load_energy: f64,
    /// whether the warning was given
    doubted: bool,
}

impl EnergyAccount {
    /// The same, but without a warning, whose text may cost more than many steps.
    #[must_use]
    pub fn without_warning(self) -> Self {
        EnergyAccount { doubted: true, ..self }
    }
}

/// Checks the energy account of a run: a few sums per step, and a pass over the nodes where these look wrong.
#[derive(Clone, Copy, Debug)]
pub struct Watch {
    account: EnergyAccount,
    /// [J/s^2] 1/2 sum f^2/m of the loads at the start
    load_energy: f64,
    /// [N/m] sum of all stiffnesses
    stiffness: f64,
    /// [kg] mass of all free degrees of freedom
    mass: f64,
    /// [m] largest coordinate at the start
    reach: f64,
    /// whether overshooting can give the work of a step the wrong sign
    overshoots: bool,
    /// whether the dissipated energy of the account counts
    dissipates: bool,
}

/// One step, for the watch.
#[derive(Clone, Copy)]
pub struct WatchedStep<'a> {
    /// the scene
    pub scene: &'a dyn Scene,
    /// start of the step
    pub from: &'a Point,
    /// its end
    pub to: &'a Point,
    /// account at its start
    pub before: &'a Energies,
    /// account at its end, finite
    pub after: &'a Energies,
    /// whether that account uses the works that the scheme integrated itself
    pub by_stages: bool,
    /// [W] power of external forces at its start and at its end
    pub power: [f64; 2],
    /// its number
    pub step: u64,
    /// [s] its size
    pub h: f64,
}

/// The watch's report on a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WatchReport {
    /// nothing to say
    Calm,
    /// the scheme has made energy; reported once
    Doubt(EnergyGain),
    /// the state is impossible
    Diverged(DivergenceKind),
}

/// Energy that a scheme has made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyGain {
    /// [J] energy made
    pub made: f64,
    /// [J] energy present at the start or supplied since
    pub supplied: f64,
    /// [-] growth per step of the energy made, over the last steps
    pub growth: Option<f64>,
}

/// [J]
#[derive(Clone, Copy)]
struct EnergyBounds {
    doubtful: f64,
    credible: f64,
    impossible: f64,
    /// what springs can hold
    held: f64,
}

/// Why a state counts as diverged.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DivergenceKind {
    /// a value is not finite
    NotFinite,
    /// the nodes have left the scene
    Spread {
        /// [-] how many times its size the scene may spread
        times: f64,
        /// [-] energy made over energy supplied
        share: f64,
        /// [-] largest numerical energy over the energy exchanged
        error: f64,
    },
    /// the scheme made more energy than the limit
    Energy(EnergyGain),
    /// the springs hold more energy than was ever supplied
    Strain {
        /// [J] what they hold
        elastic: f64,
        /// the account
        gain: EnergyGain,
    },
}

fn mass_that_moves(scene: &dyn Scene) -> f64 {
    scene.inverse_mass().iter().filter(|m| **m > 0.0).map(|m| 1.0 / m).sum()
}

impl Watch {
    /// A watch of a run from its first state.
    pub fn open(scene: &dyn Scene, method: &MethodInfo, first: &Energies) -> Self {
        let supplied = first.kinetic + first.elastic;
        Watch::restore(
            scene,
            method,
            EnergyAccount { base: supplied + first.gravity, supplied, ..EnergyAccount::default() },
        )
    }

    /// A watch that continues with the account of a snapshot.
    pub fn restore(scene: &dyn Scene, method: &MethodInfo, account: EnergyAccount) -> Self {
        let stiffness = scene.nodal_stiffness().iter().sum::<f64>();
        let start = scene.initial_state();
        let mass = mass_that_moves(scene);
        let (load_energy, reach) = (load_energy(scene, start.as_ref(), 1.0), farthest(&start.x));
        let (overshoots, dissipates) = (method.family == Family::Explicit, method.family != Family::MatrixFree);
        Watch { account, load_energy, stiffness, mass, reach, overshoots, dissipates }
    }

    /// After a program has changed loads: one step of those before may have made as much as it could.
    pub fn loads_changed(&mut self, scene: &dyn Scene) {
        let a = &mut self.account;
        a.late_load_energy = a.late_load_energy.max(self.load_energy * a.longest.powi(2));
        self.load_energy = load_energy(scene, scene.initial_state().as_ref(), 1.0);
    }

    /// After supports are released or springs are cut.
    pub fn scene_changed(&mut self, scene: &dyn Scene) {
        self.loads_changed(scene);
        self.stiffness = scene.nodal_stiffness().iter().sum::<f64>();
        self.mass = mass_that_moves(scene);
    }

    /// What a snapshot keeps.
    pub fn account(&self) -> &EnergyAccount {
        &self.account
    }

    /// Checks a step whose account is finite.
    pub fn step(&mut self, step: WatchedStep<'_>) -> WatchReport {
        let calm = self.record(step);
        self.judge(step, calm)
    }

    /// The same where the states at the ends of the step are not known (those given are others): `false` if they are
    /// needed for the decision.
    pub fn unseen_step(&mut self, step: WatchedStep<'_>) -> bool {
        self.record(step);
        self.is_calm(step.after)
    }

    /// Adds the step to the account. Returns whether what was supplied, or loads, explained the gain before it.
    fn record(&mut self, step: WatchedStep<'_>) -> bool {
        let WatchedStep { after, .. } = step;
        let (contrary, missed) = (self.contrary(step), self.air_work_missing(step));
        let given = self.by_loads();
        let a = &mut self.account;
        a.contrary += contrary;
        a.missed += missed;
        a.longest = a.longest.max(step.h);
        a.supplied = a.supplied.max(a.base - after.gravity + after.external_work + a.missed - a.contrary);
        let lost = if self.dissipates { after.numerical } else { after.numerical + after.dissipated };
        let made = a.contrary - lost;
        a.least = a.least.min(made);
        let calm = a.gains[KEPT - 1] <= a.supplied + given;
        a.gains.rotate_left(1);
        a.gains[KEPT - 1] = made - a.least;
        a.largest = a.largest.max(made - a.least);
        calm
    }

    /// [-] Largest gain over what was supplied or loads give in a step, without rounding; 0 where nothing was. At most
    /// [`DOUBTFUL`] where nothing is to be said of it.
    pub fn gain_share(&self, at: &Point, row: &Energies, steps: u64) -> f64 {
        let EnergyAccount { largest, supplied, .. } = self.account;
        if largest <= DOUBTFUL * supplied {
            return if supplied > 0.0 { largest / supplied } else { 0.0 };
        }
        let beyond = (largest - self.rounding(at, row, steps)).max(0.0);
        // A load that gives far more in one step than the run ever had is not one that the steps resolve.
        let by_loads = self.held_by_loads().min(if supplied > 0.0 { DIVERGED * supplied } else { f64::INFINITY });
        let doubtful = DOUBTFUL * supplied + BEYOND_LOAD_ENERGY * by_loads;
        let all = if beyond > doubtful { supplied + by_loads } else { doubtful / DOUBTFUL };
        if beyond > 0.0 { beyond / all.max(f64::MIN_POSITIVE) } else { 0.0 }
    }

    /// [J] What loads give in one step, so far.
    fn by_loads(&self) -> f64 {
        (self.load_energy * self.account.longest.powi(2)).max(self.account.late_load_energy)
    }

    /// [J] The same where springs stop what loads push in a long step: they hold no more than at rest under four times
    /// the loads.
    fn held_by_loads(&self) -> f64 {
        let resolved = 4.0 * self.mass / (self.stiffness * self.account.longest.powi(2));
        self.by_loads() * resolved.min(1.0)
    }

    /// The present gain.
    pub fn gain(&self) -> EnergyGain {
        let EnergyAccount { gains, supplied, .. } = self.account;
        let made = gains[KEPT - 1];
        let first = gains.iter().position(|&g| g > 0.0).filter(|&i| i + 1 < KEPT);
        let growth = first.map(|i| (made / gains[i]).powf(1.0 / (KEPT - 1 - i) as f64));
        EnergyGain { made, supplied, growth: growth.filter(|g| g.is_finite()) }
    }

    /// Limits of the gain, without rounding, for this supplied energy [J].
    fn bounds(&self, supplied: f64) -> EnergyBounds {
        let by_loads = self.by_loads();
        let (all, doubtful) = (supplied + by_loads, DOUBTFUL * supplied + BEYOND_LOAD_ENERGY * by_loads);
        let held = supplied + self.held_by_loads();
        EnergyBounds { doubtful, credible: doubtful.max(all), impossible: DIVERGED * all, held }
    }

    /// Whether there is nothing to report even without allowing for rounding.
    fn is_calm(&self, after: &Energies) -> bool {
        let EnergyGain { made, supplied, .. } = self.gain();
        let EnergyBounds { doubtful, credible, held, .. } = self.bounds(supplied);
        made <= (if self.account.doubted { credible } else { doubtful }) && after.elastic <= CREDIBLE * held
    }

    /// Whether a recorded state is credible: apart from rounding, the scheme has made no more energy than was present
    /// or supplied.
    pub fn credible(&self, at: &Point, row: &Energies, steps: u64) -> bool {
        if self.is_calm(row) {
            return true;
        }
        let (gain, rounding) = (self.gain(), self.rounding(at, row, steps));
        let EnergyBounds { credible, held, .. } = self.bounds(gain.supplied);
        gain.made <= credible + rounding && row.elastic <= CREDIBLE * held + rounding
    }

    fn judge(&mut self, step: WatchedStep<'_>, calm: bool) -> WatchReport {
        if self.is_calm(step.after) {
            return WatchReport::Calm;
        }
        let (gain, elastic) = (self.gain(), step.after.elastic);
        let rounding = self.rounding(step.to, step.after, step.step);
        if calm && gain.made.max(elastic) > rounding {
            self.note_loads(step);
        }
        let EnergyBounds { doubtful, impossible, held, .. } = self.bounds(gain.supplied);
        if elastic > DIVERGED * held + rounding {
            return WatchReport::Diverged(DivergenceKind::Strain { elastic, gain });
        }
        if gain.made > impossible + rounding {
            return WatchReport::Diverged(DivergenceKind::Energy(gain));
        }
        if gain.made > doubtful + rounding && !self.account.doubted {
            self.account.doubted = true;
            return WatchReport::Doubt(gain);
        }
        WatchReport::Calm
    }

    /// Counts the loads of a step as those at the start are.
    fn note_loads(&mut self, step: WatchedStep<'_>) {
        // For resting masses: on moving ones the air would act against motion that the scheme itself may have made.
        let rest = vec![0.0; step.from.state.v.len()];
        let at = |t: f64| load_energy(step.scene, StateRef { t, x: &step.from.state.x, v: &rest }, step.h);
        let most = at(step.from.state.t).max(at(step.to.state.t));
        self.account.late_load_energy = self.account.late_load_energy.max(most);
    }

    /// [J] Work in a step whose sign contradicts the forces at both of its ends.
    fn contrary(&self, step: WatchedStep<'_>) -> f64 {
        let WatchedStep { before, after, .. } = step;
        if !self.overshoots || step.by_stages {
            return 0.0;
        }
        let given = (before.dissipated - after.dissipated).max(0.0);
        let external = after.external_work - before.external_work;
        if external <= 0.0 || !step.scene.velocity_dependent() {
            return given;
        }
        let most = step.power[0].max(step.power[1]).max(0.0);
        given + (external - 2.0 * step.h * most).max(0.0)
    }

    /// [J] Work of the air by its power at the ends of a step, above that in the account. Stages that overshoot in a
    /// stiff force count energy as taken that the air supplies. It is bounded, because the power is negative where
    /// everything moves faster than the air.
    fn air_work_missing(&self, step: WatchedStep<'_>) -> f64 {
        if !self.overshoots || !step.scene.velocity_dependent() {
            return 0.0;
        }
        let external = step.after.external_work - step.before.external_work;
        let ends = step.power[0].max(0.0) + step.power[1].max(0.0);
        (0.5 * step.h * ends - external).max(0.0)
    }

    /// [J] Rounding error of the account after a number of steps, from positions, forces and sums.
    fn rounding(&self, at: &Point, row: &Energies, steps: u64) -> f64 {
        let reach = self.reach.max(farthest(&at.state.x));
        let forces = [&at.forces.total, &at.forces.external, &at.forces.dissipative];
        let force: f64 = forces.into_iter().flatten().map(|f| f.abs()).sum();
        // Cauchy and Schwarz: sum |f| is at most the root of sum f^2/m times all mass; likewise for the springs'
        // forces.
        let load = (2.0 * self.load_energy).sqrt() * self.mass.sqrt();
        let moved = f64::EPSILON * reach;
        let springs =
            (2.0 * row.elastic.max(0.0)).sqrt() * self.stiffness.sqrt() * moved + self.stiffness * moved * moved;
        let energies = [row.kinetic, row.elastic, row.gravity, row.external_work, row.dissipated];
        let sums: f64 = energies.iter().map(|e| e.abs()).sum();
        ROUNDINGS * (steps + 1) as f64 * ((force + load) * moved + springs) + SUMS * sums
    }
}

/// [W] Power of the external forces, and of changes of rest lengths, at an end of a step between two times [s].
pub(super) fn power_of(scene: &dyn Scene, times: [f64; 2], tallies: &[Tally]) -> f64 {
    let external = |(term, _): &(&TermInfo, _)| term.role == Role::External;
    let forces: f64 = scene.terms().iter().zip(tallies).filter(external).map(|(_, tally)| tally.power).sum();
    forces + scene.reeling_power(times, tallies)
}

/// [J] 1/2 h^2 sum f^2/m of the loads in a state: the kinetic energy they give to resting masses in a step h [s].
pub fn load_energy(scene: &dyn Scene, at: StateRef<'_>, h: f64) -> f64 {
    let mut f = vec![0.0; scene.n_dof()];
    scene.load(at, &mut f);
    let load_energy: f64 = f.iter().zip(scene.inverse_mass()).map(|(f, inverse)| 0.5 * h * h * f * f * inverse).sum();
    if load_energy.is_finite() { load_energy } else { 0.0 }
}

/// [m] Largest coordinate in `x` `[n_dof]`.
fn farthest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}
