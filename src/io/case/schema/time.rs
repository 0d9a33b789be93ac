//! End, method and steps of a run, and what a study of the case tries.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::event::Until;
use super::method::Method;
use crate::drive::clock::Tolerance;

/// End, method and steps of the run. Exactly one of `step` and `tolerance` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Time {
    /// [s] End of the simulated time, which starts at 0.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub end: f64,
    /// Method of integration.
    pub method: Method,
    /// [s] Fixed step; only the last one is shortened to meet the end.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step: Option<f64>,
    /// Error that the run may make; the size of the steps follows from it, with any method.
    pub tolerance: Option<Tolerance>,
    /// Nodes whose elements would not allow a wanted step get more mass, as explicit codes do. Only inertia is added:
    /// weight and Rayleigh damping are those of the real masses. Only with explicit methods.
    pub mass_scaling: Option<MassScaling>,
    /// The run ends before its time once the scene is at rest and nothing changes any more before `end`, such as a
    /// load, the wind or a support; the summary says so in `at_rest`.
    pub until_rest: Option<UntilRest>,
    /// The run ends before its time where the payload reaches the ground; the report and the summary tell the landing.
    /// Runs of `tradeoff` and `stability` go on to `end`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until: Option<Until>,
}

/// For how long a step nodes get more mass.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MassScaling {
    /// [s] Step that the elements are to allow, by their bound for central differences: what DT2MS is in LS-DYNA. The
    /// step of the run may differ; `check` finds the critical one.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub step: f64,
}

/// When a scene is at rest: no degree of freedom is faster than `speed`, and the forces would not make one faster
/// within the time `every`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UntilRest {
    /// [m/s] Largest speed along an axis; of a pendulum, rad/s.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub speed: f64,
    /// [s] Time between two looks; by default a hundredth of `end`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub every: Option<f64>,
}

/// What `canopy-fem tradeoff` and `canopy-fem stability` try; a list that is not given is chosen by the command.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Study {
    /// Methods to compare; at least one.
    #[schemars(length(min = 1))]
    pub methods: Option<Vec<Method>>,
    /// [s] Fixed steps to try, each above 0; at least one.
    #[schemars(length(min = 1), extend("items" = {"type": "number", "exclusiveMinimum": 0}))]
    pub steps: Option<Vec<f64>>,
    /// [-] Relative tolerances to try, each above 0 and below 1; at least one.
    #[schemars(length(min = 1), extend("items" = {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1}))]
    pub tolerances: Option<Vec<f64>>,
    /// Models of the cloth to compare in a tradeoff study, at least one; not given: the cloth as the case has it.
    #[schemars(length(min = 1))]
    pub models: Option<Vec<ClothModel>>,
    /// Numbers whose accuracy is asked for, at least one: `GAUGE.COLUMN.STATISTIC` with `peak`, `peak_time`, `min`,
    /// `last`, `mean` or `steady` (mean of the last tenth), as `riser.tension.peak`; `GAUGE.COLUMN@TIME`;
    /// `opening_load`, `displacement_end`, `max_displacement`, `max_speed`, `max_strain`, `max_stress`; columns of
    /// `energy`; `motion`, that of all nodes. Not given: the numbers that `solve` prints of gauges and canopies, else
    /// `motion`.
    #[schemars(length(min = 1))]
    pub quantities: Option<Vec<String>>,
    /// [-] Number of times each run is made to measure its cost; the cost is their median.
    #[schemars(range(min = 1, max = 1000))]
    pub repeat: Option<u32>,
    /// [s] Wall-clock time the study may take.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub budget_seconds: Option<f64>,
}

/// A model of cloth: one of `membranes`, or of springs with a `membrane` stiffness, can be both. Errors are distances
/// from the solution with membranes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum ClothModel {
    /// Springs on the edges of the triangles, k = E t (sum of the adjacent triangles' areas)/l^2 (Van Gelder 1998):
    /// Poisson's ratio is about 1/3. Where the membrane wrinkles, they act in tension only.
    Net,
    /// Membrane triangles. Springs with a `membrane` stiffness become membranes with a Poisson's ratio of 1/3, which
    /// wrinkle if the springs act in tension only.
    Membrane,
}

impl ClothModel {
    /// The word in files.
    pub fn word(self) -> &'static str {
        match self {
            ClothModel::Net => "net",
            ClothModel::Membrane => "membrane",
        }
    }
}
