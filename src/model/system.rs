//! The contract between a mechanical system and the schemes that integrate it.
//!
//! ```text
//! M a = f(t, x, v)        K = -df/dx        C = -df/dv        W = cm M + cc C + ck K
//! ```

use super::forces::{Forces, Role};
use super::point::Point;
use super::state::{State, StateRef};
use super::step_block::{KickDriftScheme, StepStart, StepSummary};
use super::workers::{ALONE, Workers};
use std::ops::Range;

/// What is known of a force term before it is evaluated: its name and role, as they appear in a failure report and the
/// ledger, and what a diagnosis asks of it. All is asked here, so that nothing need know a force by its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TermInfo {
    /// e.g. `springs`, `air`
    pub name: &'static str,
    /// its place in the ledger
    pub role: Role,
    /// whether the force depends on velocity
    pub velocity_dependent: bool,
    /// whether it is a follower load: one that turns with the surface it acts on, and so adds to the stiffness
    pub follower: bool,
    /// whether it acts on triangles, also where it is lumped to their nodes
    pub on_triangles: bool,
}

impl TermInfo {
    /// A term that depends on positions and time alone, is no follower load, and does not act on triangles.
    pub const fn of(name: &'static str, role: Role) -> Self {
        TermInfo { name, role, velocity_dependent: false, follower: false, on_triangles: false }
    }
}

/// Steps of one size by a scheme that kicks and drifts.
#[derive(Clone, Copy, Debug)]
pub struct KickDriftBlock<'a> {
    /// what a step is made of
    pub scheme: KickDriftScheme,
    /// where the first begins
    pub from: &'a Point,
}

/// What every scheme may use. Vectors run over all degrees of freedom, fixed ones included.
pub trait System: Send + Sync {
    /// Number of degrees of freedom, fixed ones included.
    fn n_dof(&self) -> usize;

    /// The state at t = 0.
    fn initial_state(&self) -> State;

    /// Force terms in the order of [`Forces::tallies`].
    fn terms(&self) -> &[TermInfo];

    /// A result of the right size for [`System::evaluate`].
    fn new_forces(&self) -> Forces;

    /// One force pass: overwrites `out` with f(t, x, v), its split and every term's energy or power.
    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces);

    /// Steps of a block at most; fewer than two where steps are made one by one.
    fn longest_block(&self) -> usize {
        0
    }

    /// Makes a block of steps from a point on: moves `at` to the end of the last and overwrites `out` with the forces
    /// there. `summaries` has an entry a step, of which it tells time and summary; it is empty for a single step, of
    /// which nothing but `out` is told. The time at the end is in `at` before. Bits are those of steps made one by one.
    ///
    /// Systems whose [`System::longest_block`] is below two make the single step alone.
    fn advance(&self, at: &mut State, out: &mut Forces, block: KickDriftBlock<'_>, summaries: &mut [StepSummary]) {
        debug_assert!(summaries.is_empty(), "this system makes steps one by one");
        single_step(self, at, out, block);
    }

    /// [1/kg] diagonal of M^-1 for every degree of freedom, 0 where it is fixed.
    fn inverse_mass(&self) -> &[f64];

    /// `out = M a` (a lumped mass: one product a degree of freedom; zero at fixed ones).
    fn mass_times(&self, a: &[f64], out: &mut [f64]);

    /// [J] kinetic energy of the velocities `v`.
    fn kinetic_energy(&self, v: &[f64]) -> f64;

    /// [s] Times at which a force has a corner or a jump in time, ascending: rows of load and wind tables.
    fn corners(&self) -> Vec<f64> {
        Vec::new()
    }

    /// Makes load and wind tables ready for a run in fixed steps of `h` [s] from t = 0, whose samples would miss what
    /// lies between them, or for any other run. What is evaluated from here on is of that run, so runs of one scene go
    /// one after the other.
    fn sample_tables(&self, h: Option<f64>) {
        let _ = h;
    }

    /// [J] Work of forces [N] that change from `f_n` to `f_n1` while nodes go from `x_n` to `x_n1` [m]: 1/2 (f_n +
    /// f_n1) . (x_n1 - x_n); 0 of no forces.
    fn work(&self, [f_n, f_n1]: [&[f64]; 2], [x_n, x_n1]: [&[f64]; 2]) -> f64 {
        let way = x_n.iter().zip(x_n1).map(|(x_n, x_n1)| x_n1 - x_n);
        f_n.iter().zip(f_n1).zip(way).map(|((f_n, f_n1), d)| 0.5 * (f_n + f_n1) * d).sum()
    }

    /// The threads that loops over the degrees of freedom may use.
    fn workers(&self) -> &Workers {
        &ALONE
    }

    /// Whether any force depends on velocity (then some explicit schemes need a second evaluation).
    fn velocity_dependent(&self) -> bool;
}

/// Makes the single step of [`System::advance`] by whole force passes.
pub(crate) fn single_step<S: System + ?Sized>(
    system: &S,
    at: &mut State,
    out: &mut Forces,
    KickDriftBlock { scheme, from }: KickDriftBlock<'_>,
) {
    let start = StepStart::of(from, system.inverse_mass(), 0..at.x.len());
    scheme.begin(start, &mut at.x, &mut at.v);
    system.evaluate(at.as_ref(), out);
    scheme.kick_again(start, &mut at.v, &out.total);
    if scheme.predicts {
        system.evaluate(at.as_ref(), out);
    }
}

/// Weights of W = m M + c C + k K.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Weights {
    /// [1/s^2 or 1] weight of the mass M
    pub m: f64,
    /// [1/s or 1] weight of the damping C = -df/dv
    pub c: f64,
    /// [1] weight of the stiffness K = -df/dx
    pub k: f64,
}

/// Which of a scene's dissipative forces are the viscosity h sum_j k_ij (v_j - v_i) that Kang's filter has of its own.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Viscosity {
    /// none of them
    #[default]
    None,
    /// all, and every spring has its dashpot c = k times this many seconds
    All {
        /// [s] c/k
        seconds: f64,
    },
    /// some
    Some,
}

/// Sums along the springs that are in Kang's filter of one step, where the filter leaves out springs that are slack.
/// [`SpringGraph`] has the same of all springs.
pub trait StepFilter: std::fmt::Debug + Send + Sync {
    /// Finds the springs in the filter of a step of `h` [s] from a state: those that are taut there, or where nodes
    /// move on as they do. Returns whether they are others than those of the last step.
    fn select(&mut self, from: StateRef<'_>, h: f64) -> bool;

    /// [N/m] `out_i = sum_j k_ij`, of every node.
    fn stiffness_sums(&self, out: &mut [f64]);

    /// `out_i = sum_j k_ij u_j`, as [`SpringGraph::neighbour_sums`].
    fn neighbour_sums(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]);

    /// `out_i = sum_j k_ij (u_j - u_i)`, as [`SpringGraph::neighbour_differences`].
    fn neighbour_differences(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]);

    /// [N] What the pull of these springs differs from that of the force pass at the step's start; `None` where it is
    /// the same.
    fn correction(&self) -> Option<&[f64]>;
}

/// What Kang's scheme needs besides forces: the spring graph.
pub trait SpringGraph: System {
    /// [N/m] sum of the stiffnesses at every node, slack or not. Asked for once, before a range of any other sum.
    fn stiffness_sums(&self) -> Vec<f64>;

    /// [N] weight at every degree of freedom.
    fn weight(&self) -> Vec<f64>;

    /// Which of the dissipative forces the filter already contains: relative `"step"` dashpots.
    fn viscosity(&self) -> Viscosity;

    /// [N] `out =` the forces of the dashpots that the filter already contains, where they are some of the dissipative
    /// forces ([`Viscosity::Some`]; else 0), for some degrees of freedom: a range that [`System::workers`] gives.
    fn step_dashpots(&self, v: &[f64], dofs: Range<usize>, out: &mut [f64]);

    /// `out_i = sum_j k_ij u_j`, likewise, in N/m times the unit of `u`, which has all degrees of freedom.
    fn neighbour_sums(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]);

    /// `out_i = sum_j k_ij (u_j - u_i)`, likewise.
    fn neighbour_differences(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]);

    /// The sums of a filter that leaves out slack springs; `None` where no spring can be slack, or all have a dashpot
    /// that the filter contains.
    fn step_filter(&self) -> Option<Box<dyn StepFilter>>;
}
