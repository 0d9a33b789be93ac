//! The contract between a mechanical system and the schemes that integrate it.
//!
//! ```text
//! M a = f(t, x, v)        K = -df/dx        C = -df/dv        W = cm M + cc C + ck K
//! ```

use super::abilities::Touches;
use super::at_dof::AtDof;
use super::forces::{Forces, Role, Tally};
use super::links::{NoLinks, SpringLinks};
use super::point::Point;
use super::state::{State, StateRef};
use super::step_block::{KickDriftScheme, StepStart, StepSummary};
use super::workers::{ALONE, Workers};
use std::ops::Range;

/// Properties of a force term: its name and role, as they appear in a failure report and the ledger, and the properties
/// that diagnoses use. So no other code depends on the name of a force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TermInfo {
    /// e.g. `springs`, `air`
    pub name: &'static str,
    /// its role in the ledger
    pub role: Role,
    /// whether the force depends on velocity
    pub velocity_dependent: bool,
    /// whether it depends on velocity by a matrix C that is the same at every state between two events
    pub constant_damping: bool,
    /// whether it is a follower load, which turns with its surface and so adds to the stiffness
    pub follower: bool,
    /// whether it acts on triangles, even if it is lumped to their nodes
    pub on_triangles: bool,
    /// whether these are springs of a constant stiffness, for which Kang's filter is made
    pub linear_springs: bool,
    /// whether these are the dashpots of springs, which methods that solve springs one by one solve with them
    pub spring_dashpots: bool,
}

impl TermInfo {
    /// A term that depends on positions and time only, is not a follower load or made of springs, and does not act on
    /// triangles.
    pub const fn of(name: &'static str, role: Role) -> Self {
        TermInfo {
            name,
            role,
            velocity_dependent: false,
            constant_damping: false,
            follower: false,
            on_triangles: false,
            linear_springs: false,
            spring_dashpots: false,
        }
    }
}

/// Steps of one size by a kick-drift scheme.
#[derive(Clone, Copy, Debug)]
pub struct KickDriftBlock<'a> {
    /// the scheme
    pub scheme: KickDriftScheme,
    /// the start of the first step
    pub from: &'a Point,
}

/// The interface for all schemes. Vectors have all degrees of freedom, fixed ones included, `[n_dof]`.
pub trait System: Send + Sync {
    /// Number of degrees of freedom, fixed ones included.
    fn n_dof(&self) -> usize;

    /// The state at t = 0.
    fn initial_state(&self) -> State;

    /// Force terms in the order of [`Forces::tallies`].
    fn terms(&self) -> &[TermInfo];

    /// A result of the right size for [`System::evaluate`].
    fn new_forces(&self) -> Forces;

    /// One force pass: overwrites `out` with f(t, x, v), its parts by role, and every term's energy or power.
    fn evaluate(&self, at: StateRef<'_>, out: &mut Forces);

    /// [1/kg] diagonal of M^-1 for every degree of freedom, 0 where it is fixed.
    fn inverse_mass(&self) -> &[f64];

    /// The fixed degrees of freedom that supports move, each with a constant velocity through a step.
    fn moved(&self) -> &[u32] {
        &[]
    }

    /// `out = M a` (lumped mass: one product per degree of freedom; zero at fixed ones).
    fn mass_times(&self, a: &[f64], out: &mut [f64]);

    /// [J] kinetic energy of the velocities `v`.
    fn kinetic_energy(&self, v: &[f64]) -> f64;

    /// [J] Work of forces [N] that change from `f_n` to `f_n1` while nodes move from `x_n` to `x_n1` [m]: 1/2 (f_n +
    /// f_n1) . (x_n1 - x_n); 0 for empty slices.
    fn work(&self, [f_n, f_n1]: [&[f64]; 2], [x_n, x_n1]: [&[f64]; 2]) -> f64 {
        let way = x_n.iter().zip(x_n1).map(|(x_n, x_n1)| x_n1 - x_n);
        f_n.iter().zip(f_n1).zip(way).map(|((f_n, f_n1), d)| 0.5 * (f_n + f_n1) * d).sum()
    }

    /// [W] Power of changes of rest lengths and of what fills volumes with gas, within a step between two times [s],
    /// with the tallies of a state in it: of factors s and amounts V_a that are linear within the step, sum of
    /// -T l0 ds/dt and of dU/dV_a dV_a/dt.
    fn reeling_power(&self, times: [f64; 2], tallies: &[Tally]) -> f64 {
        let _ = (times, tallies);
        0.0
    }

    /// The threads that loops over the degrees of freedom may use.
    fn workers(&self) -> &Workers {
        &ALONE
    }

    /// Blocks of steps; `None` if steps are made one by one.
    fn blocks(&self) -> Option<&dyn StepBlocks> {
        None
    }

    /// Springs that limit explicit steps, for schemes that make short steps of these; `None` if it has no springs.
    fn stiff(&self) -> Option<&dyn StiffSprings> {
        None
    }

    /// What may touch; `None` if nothing may.
    fn touches(&self) -> Option<&dyn Touches> {
        None
    }

    /// Whether any force depends on velocity (then some explicit schemes need a second evaluation).
    fn velocity_dependent(&self) -> bool;
}

/// Several kick-drift steps in one sweep through the nodes.
pub trait StepBlocks {
    /// Largest number of steps in a block; below two if steps are made one by one.
    fn longest_block(&self) -> usize;

    /// Makes a block of steps: moves `at` to the end of the last step and overwrites `out` with the forces there.
    /// `summaries` has one entry per step, with its time on entry, and its summary on return. It is empty for a single
    /// step without a summary. On entry `at` has the time at the end. The bits are those of steps made one by one.
    fn advance(&self, at: &mut State, out: &mut Forces, block: KickDriftBlock<'_>, summaries: &mut [StepSummary]);
}

/// The springs that limit explicit steps most: those at nodes whose springs allow steps of less than a ratio times the
/// shortest that any node allows.
pub trait StiffSprings {
    /// These springs as a system of their own; `None` if there are none.
    fn stiff_part(&self, ratio: f64) -> Option<StiffPart>;

    /// Bounds on all other forces at a state; `None` where no spring is stiff.
    fn beside_stiff(&self, ratio: f64, at: StateRef<'_>) -> Option<BesideStiff>;
}

/// Forces beside stiff springs, by bounds on their elements.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BesideStiff {
    /// [1/s^2] largest eigenvalue of M^-1 K
    pub stiffness: AtDof,
    /// [1/s] largest eigenvalue of M^-1 C
    pub damping: AtDof,
    /// whether elastic forces that are no springs act on the nodes that limit explicit steps most
    pub on_short_nodes: bool,
}

/// The stiff springs of a system, with their nodes, as a system of their own.
pub struct StiffPart {
    /// what its degrees of freedom are in the whole system
    pub dofs: Vec<u32>,
    /// these springs and their dashpots alone
    pub system: Box<dyn System>,
    /// [-] its elements over those of the whole system
    pub share: f64,
}

impl std::fmt::Debug for StiffPart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let StiffPart { dofs, share, .. } = self;
        f.debug_struct("StiffPart").field("dofs", dofs).field("share", share).finish_non_exhaustive()
    }
}

impl StiffPart {
    /// Takes its values from a vector of the whole system.
    pub fn gather(&self, all: &[f64], own: &mut [f64]) {
        own.iter_mut().zip(&self.dofs).for_each(|(own, &dof)| *own = all[dof as usize]);
    }
}

/// The largest number of steps that a system makes in a block; 0 if it makes them one by one.
pub fn longest_block<S: System + ?Sized>(system: &S) -> usize {
    system.blocks().map_or(0, |blocks| blocks.longest_block())
}

/// Makes a block of steps as [`StepBlocks::advance`], or a single step with complete force passes where the system
/// makes steps one by one; `summaries` is then empty.
pub fn advance<S: System + ?Sized>(
    system: &S,
    at: &mut State,
    out: &mut Forces,
    block: KickDriftBlock<'_>,
    summaries: &mut [StepSummary],
) {
    if let Some(blocks) = system.blocks() {
        return blocks.advance(at, out, block, summaries);
    }
    debug_assert!(summaries.is_empty(), "this system makes steps one by one");
    let KickDriftBlock { scheme, from } = block;
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

/// The step around a state x, v in its middle, over which elastic forces are averaged: it leads from x - h/2 v to
/// x + h/2 v.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepMean {
    /// [s] h/2
    pub half: f64,
    /// [-] chi in [0, 1] of the dissipation inside of elements; 0 for none
    pub dissipation: f64,
}

/// Which dissipative forces of a scene are the viscosity h sum_j k_ij (v_j - v_i) that Kang's filter already contains.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Viscosity {
    /// none of them
    #[default]
    None,
    /// all of them; every spring has a dashpot with c = k times this many seconds
    All {
        /// [s] c/k
        seconds: f64,
    },
    /// some
    Some,
}

/// Sums over the springs in Kang's filter of one step, for a filter that leaves out slack springs. [`SpringGraph`] has
/// the same sums over all springs.
pub trait StepFilter: std::fmt::Debug + Send + Sync {
    /// Finds the springs in the filter of a step of `h` [s] from a state: those that are taut there, or at x + h v.
    /// Returns whether they differ from those of the last step.
    fn select(&mut self, from: StateRef<'_>, h: f64) -> bool;

    /// [N/m] `out_i = sum_j k_ij`, for every node `[n_nodes]`.
    fn stiffness_sums(&self, out: &mut [f64]);

    /// `out_i = sum_j k_ij u_j`, as [`SpringGraph::neighbour_sums`].
    fn neighbour_sums(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]);

    /// `out_i = sum_j k_ij (u_j - u_i)`, as [`SpringGraph::neighbour_differences`].
    fn neighbour_differences(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]);

    /// [N] Difference of the forces of these springs from those of the force pass at the step's start; `None` if there
    /// is none.
    fn correction(&self) -> Option<&[f64]>;
}

/// The interface that methods along springs need besides forces: the spring graph, for Kang's scheme, and the springs
/// one by one, for those that solve each of them.
pub trait SpringGraph: System {
    /// [N/m] Sum of the stiffnesses at every node, slack or not `[n_nodes]`. Called once,
    /// before any other sum.
    fn stiffness_sums(&self) -> Vec<f64>;

    /// The springs one by one.
    ///
    /// # Errors
    /// Why some cannot be described so.
    fn links(&self) -> Result<&dyn SpringLinks, NoLinks>;

    /// [N] weight at every degree of freedom.
    fn weight(&self) -> Vec<f64>;

    /// The dissipative forces that the filter already contains: relative `"step"` dashpots.
    fn viscosity(&self) -> Viscosity;

    /// [N] `out =` the forces of the dashpots that the filter already contains, if they are some of the dissipative
    /// forces ([`Viscosity::Some`]; else 0), for some degrees of freedom: a range that [`System::workers`] gives. `v`
    /// is `[n_dof]`, `out` has the length of `dofs`.
    fn step_dashpots(&self, v: &[f64], dofs: Range<usize>, out: &mut [f64]);

    /// `out_i = sum_j k_ij u_j`, likewise, in N/m times the unit of `u`, which has all degrees of freedom.
    fn neighbour_sums(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]);

    /// `out_i = sum_j k_ij (u_j - u_i)`, likewise.
    fn neighbour_differences(&self, u: &[f64], dofs: Range<usize>, out: &mut [f64]);

    /// The sums of a filter that leaves out slack springs; `None` if no spring can be slack, or all have a dashpot that
    /// the filter contains.
    fn step_filter(&self) -> Option<Box<dyn StepFilter>>;
}
