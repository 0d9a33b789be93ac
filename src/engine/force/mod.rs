//! Force terms: one file per physical effect, each with its force, its exact tangents and its energy or power.
//!
//! Signs: `f` is the force on the nodes, `K = -df/dx`, `C = -df/dv` (see [the crate's first page](crate)).
//!
//! * [`law`]: the physics, one file per force.
//! * [`kernel`]: loops over elements of one shape. They read the local buffers of a block, and do not depend on the
//!   scene.
//! * [`schedule`]: blocks, threads, and several steps at once.
//!
//! There are three kinds of elements, with one kernel each:
//!
//! | elements | kernel | what a law gives |
//! |---|---|---|
//! | two nodes | [`law::damped_springs`] | tension and damping: [`law::slack`], [`law::dashpot`] |
//! | triangles | [`kernel::faces`] | pressure: [`law::air`], [`law::canopy`], [`law::follower_pressure`] |
//! | nodes | `kernel/nodes` | force: [`law::gravity`], [`law::nodal`] |
//!
//! Laws are pure functions, written once on [`crate::model::quad::Real`]: kernels evaluate four elements side by side,
//! and tangents one.
//!
//! # How to add a force
//! 1. Write `force/law/<name>.rs` with a struct of plain arrays, and `impl ForceTerm` for it. Its elements are
//!    * two nodes whose tension is k times a function of the elongation alone (such a law gets no rest length): no
//!      file, but a [`law::slack::TensionLaw`] with a kind in [`crate::model::spec::Slack`] and its arm in
//!      `law::slack::with_law`, the one place that knows which law a kind has. Dashpots, tangents and pictures follow;
//!    * two nodes with another elastic law: a [`kernel::batch::Kernel`], as [`law::bar_law`]. Only springs have
//!      tensions in results, dashpots, strains, rest lengths that a program scales, and a part in Kang's filter;
//!    * a triangle, pushed along its normal: a [`kernel::faces::FaceKernel`] with a `PressureLaw`, as
//!      [`law::follower_pressure`];
//!    * any other element: a [`kernel::batch::Kernel`], element by element, as the stiffness part of
//!      [`law::rayleigh`];
//!    * nodes: a `NodeLaw`, as [`law::nodal`].
//!
//!    Values that change in a run, such as a table over time or a factor that a program sets, are behind an `Arc`;
//!    [`ForceTerm::for_run`] replaces them by those of another run ([`Copies`]), and shares all else.
//! 2. Describe it in the [`TermInfo`] of its [parts](ForceTerm::parts): schemes, the ledger and diagnoses use that, and
//!    no names. A new law of springs needs none of its own. A step may be too long for forces with `velocity_dependent`
//!    or `follower` (`drive/cause`); with `on_triangles` a failure report names a triangle. A term with elastic energy
//!    also adds its stiffness at rest in [`ForceTerm::add_stiffness`], and one whose K can be indefinite has a convex
//!    [`TangentForm`].
//! 3. Add it to [`crate::model::spec`], refuse invalid values (`scene/check.rs`), and construct it where the scene is
//!    built, with elements in ascending order of their smallest node in the scene's numbering (`scene/build.rs`).
//!    What it brings is one value (`scene/acting.rs`, `Added`): the term, its tables over time, whose corners steps end
//!    at, and the load that a program can scale.
//! 4. If it is new to the case file, its section goes to `case/schema`, `case/lower` and `case/fingerprint`. The last
//!    says what must be equal for a run to be resumed; the compiler requires it. `case/schema/loads.rs` and
//!    `case/lower/loads.rs` are a short model: selections, ranges, and faults with their place.
//! 5. Add it to the list in `tests/api/tangent/scenes.rs`. The tests compare both tangents with finite differences at
//!    random states, its [`TermInfo`] with its forces, several blocks with one block, and blocks of steps with single
//!    steps. Elements in a list of their own are copied in `tests/api/tangent/tiles.rs` too. Run
//!    `cargo test --release --test api tangent`.
//!
//! A program that only uses the library adds a force by [`crate::simulation::NodalForce`], and an elastic law of bars
//! by [`crate::simulation::BarLaw`] (`examples/own_force.rs`, `examples/own_bar_law.rs`).
//!
//! A term must emit the same elements in the same order at every state (a slack spring emits a zero block). The
//! assembler needs this to know the slot of every block in advance.

mod copies;
pub mod kernel;
pub mod law;
mod mean;
pub mod schedule;

pub use copies::Copies;
pub use mean::{MeanForce, MeanStep};

use crate::model::spring_state::{SheetState, SpringState, SpringTangent};
use crate::model::system::{TermInfo, Weights};
use nalgebra::{Matrix3, Vector3};
use std::sync::Arc;

/// A state by nodes, as a force term reads it.
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

    /// A two-node element with any blocks; `blocks[p][q]` is the block of row node `nodes[p]`, column node `nodes[q]`.
    fn segment(&mut self, nodes: [u32; 2], blocks: &[[Matrix3<f64>; 2]; 2]);

    /// A three-node element; `blocks[p][q]` is the block of row node `nodes[p]`, column node `nodes[q]`.
    fn triangle(&mut self, nodes: [u32; 3], blocks: &[[Matrix3<f64>; 3]; 3]);

    /// An element of one to four nodes, likewise.
    fn few(&mut self, nodes: &[u32], blocks: &[[Matrix3<f64>; 4]; 4]);

    /// The same element with blocks of zeros.
    fn none(&mut self, nodes: &[u32]) {
        self.few(nodes, &[[Matrix3::zeros(); 4]; 4]);
    }
}

/// The parts that a tangent may leave out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TangentForm {
    /// whether to leave out the part that makes K indefinite in a compressed or buckled state
    pub convex: bool,
    /// whether the block of every element is symmetric, as for a factor that is kept over many steps
    pub symmetric: bool,
}

impl TangentForm {
    /// Nothing is left out.
    pub const EXACT: TangentForm = TangentForm { convex: false, symmetric: false };
}

/// The part u g^T of `w.c (-df/dv) + w.k (-df/dx)` that couples nodes of the whole scene, as two vectors `[n_nodes]`.
#[derive(Debug)]
pub struct RankOne<'a> {
    /// `-df/dp` of a force that depends on a [scene number](kernel::batch::SceneNumbers) p
    pub u: &'a mut [Vector3<f64>],
    /// `w.c dp/dv + w.k dp/dx`
    pub g: &'a mut [Vector3<f64>],
}

/// One batch of like elements (all springs of a rule, all triangles in the air, …).
pub trait ForceTerm: kernel::batch::BlockForces {
    /// Name, role in the ledger and properties of each of its parts; the same at every state. Most terms have one part;
    /// springs with dashpots have two ([`kernel::batch::PARTS`] at most).
    fn parts(&self) -> &[TermInfo];

    /// Whether both tangents are symmetric at every state.
    fn symmetric(&self) -> bool;

    /// Emits `w.c (-df/dv) + w.k (-df/dx)`, exact or as `form` says, element by element, always in the same order.
    /// `w.m` is the caller's.
    fn tangent(&self, at: NodeState<'_>, w: Weights, form: TangentForm, sink: &mut dyn TangentSink);

    /// Overwrites `part` with the part of the tangent that [`ForceTerm::tangent`] does not emit, because it couples
    /// nodes of the whole scene, by one of its [scene numbers](kernel::batch::BlockForces::scene_numbers).
    fn rank_one(&self, which: usize, at: NodeState<'_>, w: Weights, part: RankOne<'_>) {
        let _ = (which, at, w, part);
    }

    /// Whether its rank-one parts are also worth their solves in a tangent that is kept over many steps.
    fn couples_strongly(&self) -> bool {
        false
    }

    /// Emits blocks on the diagonal above the symmetric part of what [`ForceTerm::rank_one`] gives, for bounds on
    /// eigenvalues. Terms whose such parts follow from elements, or limit no step, emit none.
    fn coupling_bound(&self, at: NodeState<'_>, w: Weights, sink: &mut dyn TangentSink) {
        let _ = (at, w, sink);
    }

    /// Whether its force on each node is proportional to the mass of that node, and depends on no other mass.
    fn by_mass(&self) -> bool {
        false
    }

    /// Its elastic part as a mean over a step; `None` if that is the force in the middle, or if it has none.
    fn mean(&self) -> Option<&dyn MeanForce> {
        None
    }

    /// Its springs, if Newton's iteration can take their tensions as unknowns.
    fn springs(&self) -> Option<&dyn SpringTerm> {
        None
    }

    /// Its membranes, if Newton's iteration can take their stresses as unknowns.
    fn sheets(&self) -> Option<&dyn SheetTerm> {
        None
    }

    /// The same elements for another run, with the values that change in a run from `copies`. All other arrays are
    /// shared.
    fn for_run(&self, copies: &mut Copies) -> Box<dyn ForceTerm>;

    /// Replaces the rest lengths [m] of its springs, `[n_springs]` in their order. Terms without springs do nothing.
    fn set_rest_lengths(&mut self, rest_length: &Arc<[f64]>) {
        let _ = rest_length;
    }

    /// Adds the stiffness [N/m] of this term's springs, at rest, to each of their nodes in `nodes` `[n_nodes]`: for the
    /// rounding floor of a residual, and for diagnoses. Terms without elastic energy have none.
    fn add_stiffness(&self, nodes: &mut [f64]) {
        let _ = nodes;
    }
}

/// The springs of a term whose tensions can be unknowns of Newton's iteration (`solve/mixed`).
pub trait SpringTerm {
    /// Number of springs.
    fn count(&self) -> usize;

    /// Writes every spring in a state to `out` `[n_springs]`. `cv` [1/s] is dv/dx of the step.
    fn measure(&self, at: NodeState<'_>, cv: f64, out: &mut [SpringState]);

    /// As [`ForceTerm::tangent`], but with these tensions and stiffnesses `[n_springs]`; symmetric.
    fn mixed_tangent(&self, at: NodeState<'_>, w: Weights, tangents: &[SpringTangent], sink: &mut dyn TangentSink);
}

/// The membranes of a term whose stresses can be unknowns of Newton's iteration (`solve/mixed`).
pub trait SheetTerm {
    /// Number of triangles.
    fn count(&self) -> usize;

    /// Writes every triangle in a state to `out` `[n_triangles]`. `cv` [1/s] is dv/dx of the step.
    fn measure(&self, at: NodeState<'_>, cv: f64, out: &mut [SheetState]);

    /// As [`ForceTerm::tangent`], but with these stresses `[n_triangles]`; symmetric.
    fn mixed_tangent(&self, at: NodeState<'_>, w: Weights, stresses: &[Vector3<f64>], sink: &mut dyn TangentSink);
}

/// The matrix `a b^T`.
pub(crate) fn outer(a: Vector3<f64>, b: Vector3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[a * b.x, a * b.y, a * b.z])
}
