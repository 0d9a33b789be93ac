//! The data of a run, with all defaults filled in.

use crate::drive::at_rest::RestSpec;
use crate::drive::clock::{FixedSteps, Step};
use crate::drive::{Explain, RunSpec};
use crate::integrate::implicit::SolverSpec;
use crate::integrate::registry::MethodChoice;
use crate::model::gauge::{MembraneGauge, NodeGauge, SpringGauge};
use crate::model::group_totals::{GroupTotals, group_totals};
use crate::model::quantity::QuantityName;
use crate::model::spec::{NetworkSpec, PendulumSpec};
use crate::vtk::VtuFormat;
use crate::warning::{Warning, WarningCode};

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

use super::schema::Network;
pub use super::schema::{CrossingSearch, Field};

/// All data of a run.
#[derive(Clone, Debug)]
pub struct Problem {
    /// name of the case
    pub name: String,
    /// what moves
    pub system: SystemSpec,
    /// method with its parameters
    pub method: MethodChoice,
    /// end and steps
    pub time: TimeSpec,
    /// the solver of implicit steps
    pub solver: SolverSpec,
    /// what is written
    pub output: OutputSpec,
    /// warnings that are not acknowledged
    pub warnings: Vec<Warning>,
    /// warnings that are acknowledged
    pub acknowledged: Vec<Warning>,
    /// kinds of warnings that the case acknowledges
    pub acknowledge: Vec<WarningCode>,
    /// the case as it is run, `--set` and a file of materials included
    pub case_json: serde_json::Value,
    /// the network with its materials and defaults by type written out, if it has some
    pub expanded: Option<Arc<Network>>,
    /// what was taken for keys that the case leaves out, in words
    pub taken: Vec<String>,
}

impl Problem {
    /// By which method the case moves, and in which steps: on one thread.
    pub fn run_spec(&self) -> RunSpec {
        RunSpec {
            solver: self.solver,
            frames_every: self.output.frames_every,
            explain: Explain::All,
            ..RunSpec::of(self.method.clone(), self.time.step, self.time.end)
        }
    }

    /// Whether the case acknowledges warnings of a kind.
    pub fn acknowledges(&self, code: WarningCode) -> bool {
        self.acknowledge.contains(&code)
    }

    /// Separates the warnings that the case acknowledges from the others.
    pub fn sort_out(&self, warnings: impl IntoIterator<Item = Warning>) -> (Vec<Warning>, Vec<Warning>) {
        warnings.into_iter().partition(|warning| self.acknowledges(warning.code))
    }

    /// What the groups of the network have; empty for a pendulum and once the system is taken out.
    pub fn group_totals(&self) -> BTreeMap<String, GroupTotals> {
        match &self.system {
            SystemSpec::Network(spec) => group_totals(spec),
            SystemSpec::Pendulum(_) => BTreeMap::new(),
        }
    }

    /// The same without mass scaling.
    #[must_use]
    pub fn with_real_masses(mut self) -> Self {
        self.system = self.take_system().with_real_masses();
        self
    }

    /// Takes the system out, so that a large mesh is not kept twice; an empty network remains.
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

impl SystemSpec {
    /// The same without mass scaling.
    #[must_use]
    pub fn with_real_masses(mut self) -> Self {
        if let SystemSpec::Network(spec) = &mut self {
            spec.mass_scaling = None;
        }
        self
    }
}

/// End and steps of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeSpec {
    /// [s] end of the simulated time, above 0
    pub end: f64,
    /// the steps
    pub step: Step,
    /// when the run may end before its time
    pub until_rest: Option<RestSpec>,
    /// whether it ends before at an event that says so
    pub to_ground: bool,
}

impl TimeSpec {
    /// [-] Number of steps, if they are fixed; the last one is shortened to meet the end.
    pub fn steps(&self) -> Option<u64> {
        self.step.fixed().map(|step| FixedSteps::new(step, self.end).count())
    }
}

/// What is written.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputSpec {
    /// [s] a frame at every multiple of this; `None`: the first and the last state only
    pub frames_every: Option<f64>,
    /// fields beside displacement and velocity, each once, in the order of the case
    pub fields: Vec<Field>,
    /// whether edges that are sides of triangles are drawn
    pub edges: bool,
    /// where cloth is searched for triangles that pass through others
    pub crossings: CrossingSearch,
    /// probes, in the order of the case
    pub probes: Vec<ProbeSpec>,
    /// gauges of the case, in its order, then those of springs with a strength
    pub gauges: Vec<GaugeSpec>,
    /// quantities that are asked for; empty: those of the report
    pub quantities: Vec<QuantityName>,
    /// the stages of the run
    pub stages: StagesSpec,
    /// how often `history.csv` has a row
    pub history_every: RowEvery,
    /// whether it is the default, which follows from the length of the run
    pub history_derived: bool,
    /// [s] a checkpoint at every multiple of this; `None`: only when interrupted
    pub checkpoint_every: Option<f64>,
    /// how frames are written
    pub format: VtuFormat,
}

/// The stages of a run, as far as they are known before it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StagesSpec {
    /// where they begin, ascending; the first is the start of the run. Empty without events and canopies
    pub starts: Vec<StageStart>,
    /// whether events that wait for a state begin more of them
    pub events: bool,
    /// nodes of the payload, whose height is told; empty if it is not known
    pub payload: Vec<u32>,
    /// whether the run ends on the ground, so that it has a landing
    pub landing: bool,
}

/// The start of a stage of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageStart {
    /// [s] when
    pub t: f64,
    /// what begins there, such as `opening` or `disreef 1`
    pub name: String,
}

/// How often `history.csv` has a row, beside the first and the last state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum RowEvery {
    /// [-] every this many steps, at least 1
    Steps(u64),
    /// [s] at the end of the first step that reaches each multiple of this, above 0
    Time(f64),
}

impl Default for RowEvery {
    fn default() -> Self {
        RowEvery::Steps(1)
    }
}

/// Nodes whose motion is written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProbeSpec {
    /// name in `probes.csv`
    pub name: String,
    /// nodes, ascending
    pub nodes: Vec<u32>,
}

/// Something that is measured at every step.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GaugeSpec {
    /// name in `gauges.csv`
    pub name: String,
    /// what, and where
    pub of: GaugeOf,
    /// [-] steps per row, at least 1
    pub every: u64,
}

/// What a gauge measures, and where.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum GaugeOf {
    /// vectors of nodes
    Nodes {
        /// what
        of: NodeGauge,
        /// at least one, ascending
        nodes: Vec<u32>,
    },
    /// springs
    Springs {
        /// what
        of: SpringGauge,
        /// edges that carry them, ascending
        edges: Vec<u32>,
        /// only the springs of this rule, of those that have springs
        rule: Option<usize>,
        /// [N] their strength, if it is known
        strength: Option<f64>,
    },
    /// the tension of edges that carry all canopies of a point
    Pull {
        /// [kg] mass above each of them, at least one
        masses: Vec<f64>,
    },
    /// crossings of cloth
    Cloth {
        /// corners of the cloth, at least one, ascending
        nodes: Vec<u32>,
    },
    /// membranes
    Membranes {
        /// what
        of: MembraneGauge,
        /// triangles with a membrane, at least one, ascending
        triangles: Vec<u32>,
        /// [Pa] their strength over their thickness, for reports only, if it is known and the same for all
        #[serde(skip)]
        strength: Option<f64>,
    },
    /// the pressure and the volume of a gas
    Gas {
        /// its place in [`NetworkSpec::gases`]
        gas: usize,
    },
    /// the force of the first side of a contact on the second one
    Contact {
        /// its place in [`NetworkSpec::contacts`]
        contact: usize,
    },
}
