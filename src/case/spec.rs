//! A case as a run needs it: every default filled in, nothing left to look up.

use crate::integrate::registry::MethodChoice;
use crate::model::spec::{NetworkSpec, PendulumSpec};

pub use super::schema::Field;

/// Everything a run needs.
#[derive(Clone, Debug)]
pub struct Problem {
    /// name of the case
    pub name: String,
    /// what moves
    pub system: SystemSpec,
    /// method with its parameters
    pub method: MethodChoice,
    /// how long and in which steps
    pub time: TimeSpec,
    /// how an implicit step is solved
    pub solver: SolverSpec,
    /// what is written
    pub output: OutputSpec,
    /// what is doubtful but runs
    pub warnings: Vec<String>,
    /// the case as it is run, `--set` included
    pub case_json: serde_json::Value,
}

impl Problem {
    /// Takes the system out; an empty network stays. A large mesh is then not kept twice.
    pub fn take_system(&mut self) -> SystemSpec {
        std::mem::replace(&mut self.system, SystemSpec::Network(Box::default()))
    }
}

/// What moves.
#[derive(Clone, Debug, PartialEq)]
pub enum SystemSpec {
    /// masses and springs
    Network(Box<NetworkSpec>),
    /// a simple pendulum
    Pendulum(PendulumSpec),
}

/// How long and in which steps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSpec {
    /// [s] end of the simulated time, above 0
    pub end: f64,
    /// [s] fixed step, above 0
    pub step: f64,
}

impl TimeSpec {
    /// [-] Number of steps: the last one is shortened to meet the end. A remainder below a millionth of a step is
    /// rounding and makes no step of its own.
    pub fn steps(&self) -> u64 {
        (self.end / self.step - 1e-6).ceil().max(1.0) as u64
    }
}

/// How an implicit step is solved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverSpec {
    /// Newton's method
    pub newton: NewtonSpec,
    /// linear solver
    pub linear: LinearChoice,
}

/// Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonSpec {
    /// [-] residual at which a step counts as solved, relative to the step's forces
    pub relative: f64,
    /// [-] most iterations a step
    pub max_iterations: u32,
    /// when the tangent is made anew
    pub strategy: NewtonStrategy,
}

impl Default for NewtonSpec {
    /// 1e-8, 20 iterations, `auto`.
    fn default() -> Self {
        Self { relative: 1e-8, max_iterations: 20, strategy: NewtonStrategy::Auto }
    }
}

/// When the tangent is made anew.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum NewtonStrategy {
    /// the program chooses; the same as `Full` in this version
    #[default]
    Auto,
    /// in every iteration
    Full,
}

/// Linear solver.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinearChoice {
    /// Cholesky for a symmetric tangent, LU for another
    #[default]
    Auto,
    /// sparse Cholesky
    Cholesky,
    /// sparse LU
    Lu,
}

/// What is written.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputSpec {
    /// [s] a frame at every multiple of this; `None`: the first and the last state only
    pub frames_every: Option<f64>,
    /// fields beside displacement and velocity, each once, in the order of the case
    pub fields: Vec<Field>,
    /// probes, in the order of the case
    pub probes: Vec<ProbeSpec>,
    /// [-] steps a row of `history.csv`, at least 1
    pub history_every: u64,
}

/// Nodes whose motion is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProbeSpec {
    /// name in `probes.csv`
    pub name: String,
    /// nodes, ascending
    pub nodes: Vec<u32>,
}
