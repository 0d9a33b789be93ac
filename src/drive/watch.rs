//! The watch: finds divergence from the energy account, by the first law of thermodynamics.
//!
//! ```text
//! supplied = kinetic + elastic at t = 0, and the most that gravity and external work have put in since
//! made     = how far `numerical` has fallen below its highest value, and work of the wrong sign
//! push     = 1/2 h^2 sum f^2/m of the loads at the start, or of later ones on resting masses: what one step gives
//! diverged: made > 10 (supplied + push)      or       elastic > 10 supplied
//! ```
//! What is supplied bounds all motion, so a gain is measured against it, and not against the energy that is exchanged:
//! energy made by the scheme turns into kinetic, elastic and dissipated energy, so that against those a gain could
//! never reach a factor of ten. The bound needs no length, speed or strain of anyone's choice: a node that is faster,
//! or a spring that is strained more, than with all the energy there ever was, times ten, cannot be right.
//!
//! Schemes of first order move masses a step late, so that a gain as large as `push` belongs to the first step of any
//! load; it cannot strain a spring by more than the same share of what is supplied, so the second test does without it.
//! Kang's filter holds dashpots that the account evaluates outside it, far too large in long steps: there only energy
//! that is present counts as made, and dissipated energy as lost. The trapezoid of the ledger is blind to one fault:
//! where a step overshoots in a viscous force, explicit Euler and velocity Verlet get from
//! 1/2 (f_n + f_{n+1}).(x_{n+1} - x_n) exactly the energy they make. Dashpots that give energy, and work of the air
//! beyond twice what its power at either end of the step comes to, are therefore counted as made.

use super::observer::LedgerRow;
use crate::integrate::registry::{Family, MethodInfo};
use crate::model::forces::{Role, Tally};
use crate::model::point::Point;
use crate::model::state::StateRef;
use crate::model::system::TermInfo;
use crate::scene::Scene;

/// [-] A gain, or elastic energy, beyond this many times the energy supplied is a divergence.
const DIVERGED: f64 = 10.0;
/// [-] A gain beyond this share of the energy supplied is worth a warning.
pub const DOUBTFUL: f64 = 0.1;
/// [-] The warning waits until the gain is this many times `push`, which a scheme of first order makes in the first
/// step of a load.
const BEYOND_PUSH: f64 = 10.0;
/// [-] A state is not credible where springs hold more than this many times the energy supplied: as much again may be
/// the scheme's.
const CREDIBLE: f64 = 2.0;
/// [-] Roundings of a position or a force in a step.
const ROUNDINGS: f64 = 8.0;
/// [-] Share of the energies in the account that sums of many numbers lose.
const SUMS: f64 = 1e-12;
/// Number of gains that are kept to find how fast they grow.
const KEPT: usize = 5;

/// The watch's memory, as far as it cannot be found again from the scene: part of a snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Account {
    /// [J] kinetic, elastic and gravity energy at the start
    base: f64,
    /// [J] energy there at the start, or put in by gravity, loads and air since
    supplied: f64,
    /// [J] work of the wrong sign so far
    contrary: f64,
    /// [J] work of the air by its power beyond that of the account so far
    missed: f64,
    /// [J] lowest of all energy made so far
    least: f64,
    /// [J] the last gains, the newest last
    gains: [f64; KEPT],
    /// [J] largest gain so far
    largest: f64,
    /// [s] longest step so far
    longest: f64,
    /// [J] what loads that came on later give in one step
    late_push: f64,
    /// whether the warning was given
    doubted: bool,
}

impl Account {
    /// The same, but no warning is given (finding its words may cost more than many steps).
    #[must_use]
    pub fn silent(self) -> Self {
        Account { doubted: true, ..self }
    }
}

/// Follows a run's account; a few sums a step, and a pass over the nodes where these look wrong.
#[derive(Clone, Copy, Debug)]
pub struct Watch {
    account: Account,
    /// [J/s^2] 1/2 sum f^2/m of the loads at the start
    push: f64,
    /// [N/m] all stiffness
    stiffness: f64,
    /// [kg] mass of all free degrees of freedom
    mass: f64,
    /// [m] largest coordinate at the start
    reach: f64,
    /// whether a step's work can have the wrong sign by overshooting
    overshoots: bool,
    /// whether what the account calls dissipated counts
    dissipates: bool,
}

/// One step, for the watch.
#[derive(Clone, Copy)]
pub struct Watched<'a> {
    /// the scene
    pub scene: &'a dyn Scene,
    /// where the step starts
    pub from: &'a Point,
    /// where it ends
    pub to: &'a Point,
    /// account at its start
    pub before: &'a LedgerRow,
    /// account at its end, finite
    pub after: &'a LedgerRow,
    /// whether that account has the works that the scheme integrated itself
    pub by_stages: bool,
    /// [W] power of external forces at its start and at its end
    pub power: [f64; 2],
    /// its number
    pub step: u64,
    /// [s] its size
    pub h: f64,
}

/// What the watch says of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WatchReport {
    /// nothing to say
    Calm,
    /// the scheme has made energy; said once
    Doubt(Gain),
    /// the state is impossible
    Trouble(Trouble),
}

/// Energy that a scheme has made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// [J] energy made
    pub made: f64,
    /// [J] energy there at the start or put in since
    pub supplied: f64,
    /// [-] growth of the energy made, a step, over the last steps
    pub growth: Option<f64>,
}

/// [J]
#[derive(Clone, Copy)]
struct Bounds {
    doubtful: f64,
    credible: f64,
    impossible: f64,
}

/// Why a state cannot be right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trouble {
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
    /// more energy was made than can be explained
    Gain(Gain),
    /// the springs hold more energy than ever came in
    Strain {
        /// [J] what they hold
        elastic: f64,
        /// the account
        gain: Gain,
    },
}

impl Watch {
    /// Starts to watch a run from its first state.
    pub fn open(scene: &dyn Scene, method: &MethodInfo, first: &LedgerRow) -> Self {
        let supplied = first.kinetic + first.elastic;
        Watch::restore(scene, method, Account { base: supplied + first.gravity, supplied, ..Account::default() })
    }

    /// Goes on from a snapshot's account.
    pub fn restore(scene: &dyn Scene, method: &MethodInfo, account: Account) -> Self {
        let stiffness = scene.nodal_stiffness().iter().sum::<f64>();
        let start = scene.initial_state();
        let mass = scene.inverse_mass().iter().filter(|m| **m > 0.0).map(|m| 1.0 / m).sum();
        let (push, reach) = (push(scene, start.as_ref(), 1.0), farthest(&start.x));
        let (overshoots, dissipates) = (method.family == Family::Explicit, method.family != Family::MatrixFree);
        Watch { account, push, stiffness, mass, reach, overshoots, dissipates }
    }

    /// After a program has changed loads: one step of those before may have made as much as it could.
    pub fn loads_changed(&mut self, scene: &dyn Scene) {
        let a = &mut self.account;
        a.late_push = a.late_push.max(self.push * a.longest.powi(2));
        self.push = push(scene, scene.initial_state().as_ref(), 1.0);
    }

    /// What a snapshot keeps.
    pub fn account(&self) -> &Account {
        &self.account
    }

    /// Accounts for a step whose account is finite.
    pub fn step(&mut self, step: Watched<'_>) -> WatchReport {
        let calm = self.enter(step);
        self.judge(step, calm)
    }

    /// The same where the states at the step's ends are not there (those given are others): `false` if it takes them to
    /// judge it.
    pub fn unseen_step(&mut self, step: Watched<'_>) -> bool {
        self.enter(step);
        self.is_calm(step.after)
    }

    /// Whether the gain could be explained before.
    fn enter(&mut self, step: Watched<'_>) -> bool {
        let Watched { after, .. } = step;
        let (contrary, missed) = (self.contrary(step), self.missed(step));
        let a = &mut self.account;
        a.contrary += contrary;
        a.missed += missed;
        a.longest = a.longest.max(step.h);
        a.supplied = a.supplied.max(a.base - after.gravity + after.external_work + a.missed - a.contrary);
        let lost = if self.dissipates { after.numerical } else { after.numerical + after.dissipated };
        let made = a.contrary - lost;
        a.least = a.least.min(made);
        let calm = a.gains[KEPT - 1] <= a.supplied;
        a.gains.rotate_left(1);
        a.gains[KEPT - 1] = made - a.least;
        a.largest = a.largest.max(made - a.least);
        calm
    }

    /// [-] Largest gain over the energy supplied, rounding apart; 0 where nothing was supplied.
    pub fn share(&self, at: &Point, row: &LedgerRow, steps: u64) -> f64 {
        let Account { largest, supplied, .. } = self.account;
        if largest <= DOUBTFUL * supplied {
            return if supplied > 0.0 { largest / supplied } else { 0.0 };
        }
        let beyond = (largest - self.rounding(at, row, steps)).max(0.0);
        // Where nothing else was supplied, what a load gives in the step in which it comes on.
        let pushed = self.push * self.account.longest.powi(2) + self.account.late_push;
        let supplied = if supplied > 0.0 { supplied } else { pushed.max(f64::MIN_POSITIVE) };
        if beyond > 0.0 { beyond / supplied } else { 0.0 }
    }

    /// The gain now.
    pub fn gain(&self) -> Gain {
        let Account { gains, supplied, .. } = self.account;
        let made = gains[KEPT - 1];
        let first = gains.iter().position(|&g| g > 0.0).filter(|&i| i + 1 < KEPT);
        let growth = first.map(|i| (made / gains[i]).powf(1.0 / (KEPT - 1 - i) as f64));
        Gain { made, supplied, growth: growth.filter(|g| g.is_finite()) }
    }

    /// Gains that are beyond doubt and belief, rounding apart, where so much energy [J] was supplied.
    fn bounds(&self, supplied: f64) -> Bounds {
        let push = self.push * self.account.longest.powi(2) + self.account.late_push;
        let doubtful = DOUBTFUL * supplied + BEYOND_PUSH * push;
        let credible = doubtful.max(supplied + push);
        Bounds { doubtful, credible, impossible: DIVERGED * (supplied + push) }
    }

    /// Whether there is nothing to say even if nothing is rounded.
    fn is_calm(&self, after: &LedgerRow) -> bool {
        let Gain { made, supplied, .. } = self.gain();
        let Bounds { doubtful, credible, .. } = self.bounds(supplied);
        made <= (if self.account.doubted { credible } else { doubtful }) && after.elastic <= CREDIBLE * supplied
    }

    /// Whether a state that was entered can be right: the scheme has made no more energy than there was or was put in,
    /// rounding apart.
    pub fn credible(&self, at: &Point, row: &LedgerRow, steps: u64) -> bool {
        if self.is_calm(row) {
            return true;
        }
        let (gain, rounding) = (self.gain(), self.rounding(at, row, steps));
        gain.made <= self.bounds(gain.supplied).credible + rounding
            && row.elastic <= CREDIBLE * gain.supplied + rounding
    }

    fn judge(&mut self, step: Watched<'_>, calm: bool) -> WatchReport {
        if self.is_calm(step.after) {
            return WatchReport::Calm;
        }
        let (gain, elastic) = (self.gain(), step.after.elastic);
        let Bounds { doubtful, impossible, .. } = self.bounds(gain.supplied);
        let rounding = self.rounding(step.to, step.after, step.step);
        // A scheme whose account lags behind a load that has just come on has not booked its work yet.
        if elastic > DIVERGED * (gain.supplied + self.account.late_push) + rounding {
            return WatchReport::Trouble(Trouble::Strain { elastic, gain });
        }
        if gain.made > impossible + rounding {
            let explained = calm && self.pushed(step, gain, rounding);
            return if explained { WatchReport::Calm } else { WatchReport::Trouble(Trouble::Gain(gain)) };
        }
        if gain.made > doubtful + rounding && !self.account.doubted {
            self.account.doubted = true;
            return WatchReport::Doubt(gain);
        }
        WatchReport::Calm
    }

    /// Whether a load that has just come on explains a gain, as the loads at the start do.
    fn pushed(&mut self, step: Watched<'_>, gain: Gain, rounding: f64) -> bool {
        // On resting masses: on moving ones the air resists what the scheme itself may have made.
        let rest = vec![0.0; step.from.state.v.len()];
        let at = |t: f64| push(step.scene, StateRef { t, x: &step.from.state.x, v: &rest }, 1.0);
        let most = at(step.from.state.t).max(at(step.to.state.t));
        self.account.late_push = self.account.late_push.max(most * step.h * step.h);
        gain.made <= DIVERGED * (gain.supplied + self.account.late_push) + rounding
    }

    /// [J] Work in a step that the forces at both of its ends would not do.
    fn contrary(&self, step: Watched<'_>) -> f64 {
        let Watched { before, after, .. } = step;
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

    /// [J] Work that the air does by its power at the ends of a step, and not in the account: stages that overshoot in
    /// a stiff force say that it takes energy where it gives some. Bounded, because the power is below zero where all
    /// moves faster than the air.
    fn missed(&self, step: Watched<'_>) -> f64 {
        if !self.overshoots || !step.scene.velocity_dependent() {
            return 0.0;
        }
        let external = step.after.external_work - step.before.external_work;
        let ends = step.power[0].max(0.0) + step.power[1].max(0.0);
        (0.5 * step.h * ends - external).max(0.0)
    }

    /// [J] What rounded positions, forces and sums may leave in the account after a number of steps.
    fn rounding(&self, at: &Point, row: &LedgerRow, steps: u64) -> f64 {
        let reach = self.reach.max(farthest(&at.state.x));
        let forces = [&at.forces.total, &at.forces.external, &at.forces.dissipative];
        let force: f64 = forces.into_iter().flatten().map(|f| f.abs()).sum();
        // Cauchy and Schwarz: sum |f| is at most the root of sum f^2/m times all mass; likewise for the springs'
        // forces.
        let load = (2.0 * self.push).sqrt() * self.mass.sqrt();
        let moved = f64::EPSILON * reach;
        let springs =
            (2.0 * row.elastic.max(0.0)).sqrt() * self.stiffness.sqrt() * moved + self.stiffness * moved * moved;
        let energies = [row.kinetic, row.elastic, row.gravity, row.external_work, row.dissipated];
        let sums: f64 = energies.iter().map(|e| e.abs()).sum();
        ROUNDINGS * (steps + 1) as f64 * ((force + load) * moved + springs) + SUMS * sums
    }
}

/// [W] Power of the external forces.
pub(super) fn power_of(scene: &dyn Scene, tallies: &[Tally]) -> f64 {
    let external = |(term, _): &(&TermInfo, _)| term.role == Role::External;
    scene.terms().iter().zip(tallies).filter(external).map(|(_, tally)| tally.power).sum()
}

/// [J] 1/2 h^2 sum f^2/m of the loads in a state: the kinetic energy they give to resting masses in a step h [s].
pub(crate) fn push(scene: &dyn Scene, at: StateRef<'_>, h: f64) -> f64 {
    let mut f = vec![0.0; scene.n_dof()];
    scene.load(at, &mut f);
    let push: f64 = f.iter().zip(scene.inverse_mass()).map(|(f, inverse)| 0.5 * h * h * f * f * inverse).sum();
    if push.is_finite() { push } else { 0.0 }
}

/// [m] largest coordinate
fn farthest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |m, x| m.max(x.abs()))
}
