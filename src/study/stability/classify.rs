//! Whether a run was stable.
//!
//! ```text
//! supplied  = kinetic + elastic at t = 0, and the most that gravity and external work have put in since
//! share     = (kinetic + elastic) / supplied
//! unstable: a value is not finite, a step cannot be solved, share > 1e8 at any time,
//!           share > stays in nine of ten steps of the last quarter of the run,
//!           mean energy of motion in the last quarter > 30 times that of the next shorter stable step, and
//!               > supplied/1000,
//!           the mean energy made by the scheme grew by 30 supplied from the second last eighth to the last,
//!           or (small motion, schemes that swing no energy) all energy but that of loads rose by 2 % of the
//!               motion's from eighth to eighth
//! motion    = the larger of the kinetic energies of v and of (x_{n+1} - x_n)/h; v alone misses a motion that turns at
//!             every step
//! ```
//! By the first law the share is at most 1; `stays` is 3, and 30 for a scheme that swings the energy of a stable
//! oscillation, as one step of it on an oscillator shows. Just below its limit a symplectic scheme swings it up to
//! `1/(1 - (h/h_c)^2)`, 25 times at 0.98 h_c and 100 times at 0.995 h_c, and down again within some ten steps; growth
//! does not come down. An instability that a nonlinear scene holds at some level, such as a pendulum that whirls or a
//! dashpot that overshoots in one spring of a cloth, keeps up a motion that dies out in shorter steps, or makes energy
//! all the time, which what is stable does only while its fast motions die out. Methods without limit on linear scenes
//! do not swing: there the run's own watch decides, as it does in `solve`.

use super::measure::MethodRuns;
use super::perturbation::{Start, displacement};
use crate::analysis::critical::step_by_bounds;
use crate::drive::observer::{AcceptedStep, Energies, Point};
use crate::drive::watch::load_energy;
use crate::integrate::registry::Family;
use crate::model::state::{State, StateRef};
use crate::scene::{BoundBuffer, Scene};
use serde::{Deserialize, Serialize};

/// A share of the energy supplied that is beyond all swinging.
const BLOWN: f64 = 1e8;
/// A share that a stable run comes back below, again and again: of a scheme that never raises the energy of a linear
/// scene, and of others.
pub(super) const STAYS: [f64; 2] = [3.0, 30.0];
/// [-] part of the last quarter of a run in which a share stays.
const MOST: f64 = 0.9;

/// A rise of the energy of small motion from an eighth of the run to the next that is growth: share of the motion's,
/// and of all supplied.
const RISE: [f64; 2] = [0.02, 1e-3];

/// States of a run whose critical step is measured.
const MEASURED: u64 = 64;
/// [-] Critical steps that differ by no more than this share are the same. Of states with the same one the last is
/// kept: the start is known already, and a later state may show what the measure cannot see, such as a motion across
/// springs that have come under tension.
const ROUNDING: f64 = 1e-7;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// it held
    Stable,
    /// a value was not finite
    NotFinite,
    /// far more energy than was ever supplied
    BlownUp,
    /// energy made by the scheme stayed, or grew without end
    EnergyStays,
    /// the energy of a small motion rose all the time
    Grows,
    /// a motion went on and on that dies out in shorter steps
    MotionStays,
    /// the watch of the run found more energy than can be
    Diverged,
    /// an implicit step could not be solved
    NotConverged,
}

impl Verdict {
    /// Whether the run held.
    pub fn is_stable(self) -> bool {
        self == Verdict::Stable
    }
}

/// Follows a run's energy.
pub(super) struct EnergyClassifier<'a> {
    pub evidence: Evidence<'a>,
    scene: &'a dyn Scene,
    steps: u64,
    /// [-] share that must not stay
    stays: f64,
    /// whether what the account calls dissipated counts
    dissipates: bool,
    /// [J] what a run is displaced by at its start, and what a scheme of first order makes in the first step of a load
    floor: f64,
    /// [J] kinetic, elastic and gravity energy at the start
    base: f64,
    supplied: f64,
    /// [-] largest share
    pub peak: f64,
    blown: bool,
    /// whether the last step's share was one of a stable run
    calm: bool,
    /// steps of the last quarter, and those of them with a share that is too large
    late: [u64; 2],
    /// [J] sum of the energy of motion over the last quarter
    motion: f64,
    /// [m/s] room for (x_{n+1} - x_n)/h
    secant: Vec<f64>,
    /// whether the energy of a motion that is stable cannot rise
    sinks: bool,
    /// [J] sums over the last four eighths: of all energy but that of loads, of the kinetic energy, and their steps
    eighths: [(f64, f64, u64); 4],
    /// [J] sums of the made energy over the last two eighths, and their steps
    made: [(f64, u64); 2],
}

impl<'a> EnergyClassifier<'a> {
    pub(super) fn new(runs: &MethodRuns<'a>, steps: u64) -> Self {
        let (scene, method) = (runs.spec.scene, runs.method);
        let moved = displacement(scene);
        EnergyClassifier {
            evidence: Evidence::new(scene, steps),
            scene,
            steps,
            stays: runs.stays,
            dissipates: method.info.family != Family::MatrixFree,
            floor: scene.nodal_stiffness().iter().sum::<f64>() * moved * moved,
            base: 0.0,
            supplied: 0.0,
            peak: 0.0,
            blown: false,
            calm: true,
            late: [0; 2],
            motion: 0.0,
            secant: vec![0.0; scene.n_dof()],
            sinks: runs.from.start == Start::SmallMotion
                && runs.stays == STAYS[0]
                && scene.events().is_none_or(|events| events.corners().is_empty()),
            eighths: [(0.0, 0.0, 0); 4],
            made: [(0.0, 0); 2],
        }
    }

    /// [-] Mean energy of motion over the last quarter of the run, over all energy supplied.
    pub(super) fn lively(&self) -> f64 {
        let [all, _] = self.late;
        let supplied = self.supplied + self.floor;
        if all > 0 && supplied > 0.0 { self.motion / all as f64 / supplied } else { 0.0 }
    }

    fn share(&self, there: f64) -> f64 {
        if there > 0.0 { there / (self.supplied + self.floor) } else { 0.0 }
    }

    /// [J] Kinetic energy of (x_{n+1} - x_n)/h.
    fn secant(&mut self, [start, end]: [&Point; 2]) -> f64 {
        let (from, to) = (&start.state, &end.state);
        let h = to.t - from.t;
        self.secant.iter_mut().zip(&to.x).zip(&from.x).for_each(|((v, to), from)| *v = (to - from) / h);
        self.scene.kinetic_energy(&self.secant)
    }

    /// The verdict from the energy, for a run that made all its steps or was stopped here.
    pub(super) fn energy(&self) -> Verdict {
        if self.blown {
            return Verdict::BlownUp;
        }
        let [all, over] = self.late.map(|n| n as f64);
        let mean = |(sum, n): (f64, u64)| sum / n.max(1) as f64;
        let [before, last] = self.made.map(mean);
        let grown = last - before > STAYS[1] * (self.supplied + self.floor);
        if (all > 0.0 && over >= MOST * all) || grown {
            return Verdict::EnergyStays;
        }
        if self.sinks && self.rises() { Verdict::Grows } else { Verdict::Stable }
    }

    /// Whether the energy of the motion rose from eighth to eighth.
    fn rises(&self) -> bool {
        let means = self.eighths.map(|(energy, kinetic, n)| (energy / n.max(1) as f64, kinetic / n.max(1) as f64));
        means.windows(2).all(|pair| match pair {
            [(before, _), (last, kinetic)] => last - before > (2.0 * RISE[0] * kinetic).max(RISE[1] * self.supplied),
            _ => false,
        })
    }

    pub(super) fn started(&mut self, at: &Point, ledger: Energies) {
        self.supplied = ledger.kinetic + ledger.elastic;
        self.base = self.supplied + ledger.gravity;
        self.evidence.measure(at.state.as_ref());
    }

    /// Books a step; returns whether the run is certainly unstable.
    pub(super) fn stepped(&mut self, step: &AcceptedStep<'_>, [start, end]: [&Point; 2]) -> bool {
        let Energies { kinetic, elastic, gravity, external_work, dissipated, numerical } = step.ledger;
        self.supplied = self.supplied.max(self.base - gravity + external_work);
        let there = kinetic + elastic;
        let mut share = self.share(there);
        if share > BLOWN && self.calm {
            // Before a load has done work, the energy that the first step makes of it counts as supplied. An
            // instability grows; it does not appear in a single step.
            let (h, times) = (step.h(), [step.from, step.t]);
            // With masses at rest: on moving ones the air would resist a motion that the scheme itself has made.
            let rest = vec![0.0; start.state.v.len()];
            let at = |t: f64| StateRef { t, x: &start.state.x, v: &rest };
            self.floor = times.into_iter().map(|t| load_energy(self.scene, at(t), h)).fold(self.floor, f64::max);
            share = self.share(there);
        }
        self.calm = share <= self.stays;
        self.peak = self.peak.max(share).min(f64::MAX);
        let eighth = (8 * step.step).saturating_sub(1) / self.steps.max(1);
        let late = eighth.checked_sub(4).and_then(|late| self.eighths.get_mut(late as usize));
        if let Some((energy, motion, n)) = late {
            *energy -= numerical + dissipated;
            *motion += kinetic;
            *n += 1;
        }
        if 4 * step.step > 3 * self.steps {
            self.late[0] += 1;
            self.motion += kinetic.max(self.secant([start, end]));
            self.late[1] += u64::from(share > self.stays);
            let eighth = usize::from(8 * step.step > 7 * self.steps);
            if let Some((sum, n)) = self.made.get_mut(eighth) {
                *sum -= numerical + if self.dissipates { 0.0 } else { dissipated };
                *n += 1;
            }
        }
        self.blown |= share > BLOWN;
        self.evidence.stepped(step);
        self.blown
    }
}

/// The states of a run at which the scene was stiffest and softest, by a bound on the critical step from one pass over
/// the elements.
pub(super) struct Evidence<'a> {
    scene: &'a dyn Scene,
    every: u64,
    buffer: BoundBuffer,
    /// [s] least and largest bound, and the states with them
    seen: [(f64, State); 2],
}

impl<'a> Evidence<'a> {
    pub(super) fn new(scene: &'a dyn Scene, steps: u64) -> Self {
        let start = scene.initial_state();
        let seen = [(f64::INFINITY, start.clone()), (f64::NEG_INFINITY, start)];
        // Odd, so that both sides of an alternating motion are sampled.
        Evidence { scene, every: steps.div_ceil(MEASURED) | 1, buffer: BoundBuffer::default(), seen }
    }

    pub(super) fn measure(&mut self, at: StateRef<'_>) {
        let now = step_by_bounds(self.scene, at, &mut self.buffer);
        let [(least, stiffest), (largest, softest)] = &mut self.seen;
        if now < (1.0 + ROUNDING) * *least {
            *least = least.min(now);
            stiffest.copy_from(at);
        }
        if now > (1.0 - ROUNDING) * *largest {
            *largest = largest.max(now);
            softest.copy_from(at);
        }
    }

    pub(super) fn stepped(&mut self, step: &AcceptedStep<'_>) {
        if let Some(end) = step.end.filter(|_| step.step.is_multiple_of(self.every)) {
            self.measure(end.state.as_ref());
        }
    }

    pub(super) fn extremes(self) -> [State; 2] {
        self.seen.map(|(_, state)| state)
    }
}
