//! Force terms: one file a physical effect, each with its force, its exact tangents and its energy or power.
//!
//! Signs: `f` is the force on the nodes, `K = -df/dx`, `C = -df/dv` (see [the crate's first page](crate)).
//!
//! * [`law`]: the physics, one file a force.
//! * [`kernel`]: loops over elements of one shape. They find nodes in the local buffers of a block, and know no scene.
//! * [`schedule`]: blocks, threads, and several steps at once.
//!
//! There are three kinds of elements, and one kernel for each:
//!
//! | elements | kernel | what a law gives |
//! |---|---|---|
//! | two nodes | [`law::damped_springs`] | tension and damping: [`law::slack`], [`law::dashpot`] |
//! | triangles | [`kernel::faces`] | pressure: [`law::air`], [`law::follower_pressure`] |
//! | nodes | `kernel/nodes` | force: [`law::gravity`], [`law::nodal`] |
//!
//! Laws are pure functions, written once on [`crate::model::quad::Real`]: kernels ask for four elements side by side,
//! and tangents for one.
//!
//! # How to add a force
//! 1. Write `force/law/<name>.rs` with a struct of plain arrays, and `impl ForceTerm` for it. Its elements are
//!    * two nodes whose tension is k times a function of the elongation: no file, but a [`law::slack::TensionLaw`] with
//!      a kind in [`crate::model::spec::Slack`] and its arm in `law::slack::with_law`, the one place that knows which
//!      law a kind has. Dashpots, tangents and pictures follow;
//!    * two nodes with another elastic law: a [`kernel::batch::Kernel`], as [`law::bar_law`];
//!    * a triangle, pushed along its normal: a [`kernel::faces::FaceKernel`] with a `PressureLaw`, as
//!      [`law::follower_pressure`];
//!    * any other element: a [`kernel::batch::Kernel`], element by element, as the stiffness part of
//!      [`law::rayleigh`];
//!    * nodes: a `NodeLaw`, as [`law::nodal`].
//! 2. Say in the [`TermInfo`] of its [parts](ForceTerm::parts) what it is: schemes, the ledger and diagnoses go by
//!    that, and by no name; a law of springs has theirs. `velocity_dependent` and `follower` are what the step may be
//!    too long for (`drive/cause`); `on_triangles` lets a failure name one. A term with elastic energy also adds its
//!    stiffness at rest in [`ForceTerm::add_stiffness`], and one whose K can be indefinite has a convex
//!    [`TangentForm`].
//! 3. Give it a place in [`crate::model::spec`], refuse there what no scene has (`scene/check.rs`), and construct it
//!    where the scene is built (`scene/build.rs`, which also collects the times at which a table has a corner,
//!    and gives a load the factor that a program may set).
//! 4. If it is new to the case file, its section goes to `case/schema` and `case/lower`, and to `case/fingerprint`,
//!    which says what must be the same for a run to go on; the compiler asks for the last.
//! 5. Add it to the list in `tests/api/tangent/scenes.rs`: both tangents are compared with finite differences at random
//!    states, what its [`TermInfo`] says with its forces, copies of it in several blocks with one alone, and steps made
//!    several at once with steps one by one.
//!
//! A program that only uses the library adds a force by [`crate::simulation::NodalForce`], and an elastic law of bars
//! by [`crate::simulation::BarLaw`] (`examples/own_force.rs`, `examples/own_bar_law.rs`).
//!
//! A term must emit the same elements in the same order at every state (a slack spring emits a zero block): the
//! assembler relies on it to know every block's slot in advance.

pub mod kernel;
pub mod law;
pub mod schedule;

use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// A state by nodes: what a force term sees.
#[derive(Clone, Copy, Debug)]
pub struct NodeState<'a> {
    /// [s] time
    pub t: f64,
    /// [m] node positions
    pub x: &'a [Vector3<f64>],
    /// [m/s] node velocities
    pub v: &'a [Vector3<f64>],
}

/// Takes the blocks of cm M + cc C + ck K that a term emits (the weights are already applied by the term).
pub trait TangentSink {
    /// The block of row node `i` and column node `j` alone. A symmetric matrix takes those on its diagonal only.
    fn pair(&mut self, nodes: [u32; 2], block: Matrix3<f64>);

    /// A block on the diagonal of node `i`.
    fn node(&mut self, i: u32, block: Matrix3<f64>) {
        self.pair([i; 2], block);
    }

    /// The two-node element `[[B, -B], [-B, B]]`; `B` need not be symmetric.
    fn edge(&mut self, nodes: [u32; 2], block: Matrix3<f64>);

    /// A three-node element; `blocks[p][q]` is the block of row node `nodes[p]`, column node `nodes[q]`.
    fn triangle(&mut self, nodes: [u32; 3], blocks: &[[Matrix3<f64>; 3]; 3]);
}

/// What a tangent may leave out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TangentForm {
    /// whether what makes K indefinite in a compressed or buckled state is left out
    pub convex: bool,
    /// whether every element's block is symmetric: what a factor is made of that is kept over many steps
    pub symmetric: bool,
}

impl TangentForm {
    /// Nothing is left out.
    pub const EXACT: TangentForm = TangentForm { convex: false, symmetric: false };
}

/// One batch of like elements (all springs of a rule, all triangles in the air, …).
pub trait ForceTerm: kernel::batch::Summand {
    /// Of each of its parts: name in reports, role in the ledger, and what diagnoses ask of it; the same at every
    /// state. Most terms have one part; springs with dashpots have two ([`kernel::batch::PARTS`] at most).
    fn parts(&self) -> &[TermInfo];

    /// Whether both tangents are symmetric at every state.
    fn symmetric(&self) -> bool;

    /// Emits `w.c (-df/dv) + w.k (-df/dx)`, exact or as `form` says, element by element, always in the same order.
    /// `w.m` is the caller's.
    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink);

    /// Replaces the rest lengths [m] of its springs, `[n_springs]` in their order. Terms without springs do nothing.
    fn set_rest_lengths(&mut self, rest_length: &Arc<[f64]>) {
        let _ = rest_length;
    }

    /// Adds the stiffness [N/m] that this term's springs put on every node, whatever the state: for the rounding floor
    /// of a residual, and for diagnoses. Terms without elastic energy have none.
    fn add_stiffness(&self, nodes: &mut [f64]) {
        let _ = nodes;
    }
}

/// The matrix `a b^T`.
pub(crate) fn outer(a: Vector3<f64>, b: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[a * b.x, a * b.y, a * b.z])
}
