//! The case file as serde reads it: one struct per section, with the keys of the file; only types and keys are checked.
//!
//! Ranges are attributes for the JSON Schema; the walk of the schema checks them and makes their messages. Numbers are
//! SI; the doc of a number begins with its unit.

pub mod aero;
pub mod contact;
mod event;
pub mod gas;
pub mod glide;
pub mod loads;
pub mod material;
pub mod method;
pub mod network;
pub mod output;
pub mod per_node;
pub mod select;
pub mod solver;
pub mod springs;
mod surface;
pub mod table;
pub mod time;
pub mod wind;

use crate::model::spec::PendulumSpec;
use crate::warning::WarningCode;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

pub use aero::{
    Aero, Canopy, Cavity, ClothLaw, Drag, ErgunForm, ErgunLaw, Filling, FillingSchedule, OneOrSeveral, PermeableLaw,
    PorousLaw, PressureCoefficient, PressureCoefficientLaw, PressureTable, ZoneCoefficient,
};
pub use contact::{Bar, Between, Contact, Cuboid, EverythingWord, Obstacle, Plane, TouchingSide};
pub use event::{Until, When};
pub use gas::Gas;
pub use glide::Glide;
pub use loads::{Load, PressureKindKey};
pub use material::{ClothMaterial, LineMaterial, Material, MaterialMap, Materials};
pub use method::Method;
pub use network::{Damping, FrameFile, Initial, InitialFrom, Keep, Mass, Network, NetworkModel, PointMass, Support};
pub use output::{CrossingSearch, Every, EveryCheckpoint, EverySteps, Field, Gauge, Output, Probe};
pub use per_node::{PerEdge, PerNode, Vectors};
pub use select::{
    Ball, EdgeSelection, EdgesExcept, NodeOrEdgeSelection, NodeSelection, NodesExcept, NodesOrEdgesExcept,
};
pub use solver::{Newton, Solver};
pub use springs::{CutRule, CutTable, Dashpot, DashpotRule, ElasticLawRule, Membrane, SlackRule, SpringRule};
pub use surface::{BendingRule, MembraneRule, Modulus};
pub use table::{Factor, FactorTable, OverTime, ValueTable, VectorTable, vectors};
pub use time::{ClothModel, MassScaling, Study, Time, UntilRest};
pub use wind::{Atmosphere, ExponentialAtmosphere, Gust, Wind, WindPart, WindSum};

/// A simulation case for canopy-fem. Values are SI. Comments (`//` and `/* */`) and trailing commas are allowed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "canopy-fem case")]
pub struct CaseFile {
    /// Path of the JSON Schema of this file, for editors; the program does not use it.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// Name of the case; result files and the default output folder carry it. 1 to 200 characters.
    #[schemars(length(min = 1, max = 200))]
    pub name: String,
    /// Description for the reader; the program does not use it.
    pub description: Option<String>,
    /// Codes of the warnings to accept, as `check` and `solve` print them in brackets: these warnings are not printed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub acknowledge: Vec<WarningCode>,
    /// Materials that rules and parachutes can name, beside those of the program (`canopy-fem materials` prints these),
    /// which they replace if they have the same name: `"mine.json"`, a file in the folder of the case, or
    /// `{"name": {"cloth": {...}}, ...}` itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub materials: Option<Materials>,
    /// What moves.
    pub system: System,
    /// End, method and steps of the run.
    pub time: Time,
    /// How the equations of an implicit method are solved; explicit methods do not need it.
    pub solver: Option<Solver>,
    /// What is written.
    pub output: Option<Output>,
    /// What `canopy-fem tradeoff` and `canopy-fem stability` try; command-line flags take precedence.
    pub study: Option<Study>,
}

/// What moves: a network of masses and springs, or a simple pendulum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum System {
    /// Point masses joined by springs: cloth, canopies, chains.
    Network(Box<Network>),
    /// A simple pendulum: m L^2 theta'' = -m g L sin(theta) - c theta'.
    Pendulum(PendulumSpec),
}

/// The JSON Schema of a case, as `canopy-fem schema` prints it.
pub fn json_schema() -> serde_json::Value {
    schemars::schema_for!(CaseFile).to_value()
}
