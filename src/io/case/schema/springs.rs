//! Rules that put springs and dashpots on edges.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};

use super::event::When;
use super::per_node::PerEdge;
use super::select::EdgeSelection;
use super::table::Factor;

/// Springs on some edges. An edge that no rule selects has no spring. A rule for a group adds its springs to all edges
/// of the group, beside those of other rules: a tape along the edges of a cloth. Of the other rules an edge follows
/// the first that selects it. Exactly one of `stiffness`, `axial_rigidity`, `membrane`, `loads_only` and a `law` with a
/// table is given, or a `material`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SpringRule {
    /// Which edges.
    pub on: EdgeSelection,
    /// Name of a material, which gives what the rule leaves out: stiffness, `linear_density`, `strength`, no
    /// compression, and a dashpot by time. A cloth also gives `mass.areal_density`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// [N/m] Stiffness k of every spring.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness: Option<f64>,
    /// [N] Axial rigidity EA of a bar: k = EA/l0, l0 being the rest length.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub axial_rigidity: Option<f64>,
    /// Stiffness from a continuous sheet; for edges of triangles.
    pub membrane: Option<Membrane>,
    /// Whether the edges get no springs, as those of a cover that only passes loads on to a net of cables: areas,
    /// weights and pressures of its triangles act on their nodes. No later rule selects these edges but those for a
    /// group.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub loads_only: bool,
    /// How the tension grows with the strain; not given: T = k (l - l0).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<ElasticLawRule>,
    /// [m] Rest length l0 of the spring, which may be 0 with `stiffness` and `membrane`; or a list with one for every
    /// edge of the mesh, of which those of other edges are passed over. If not given, the length of the edge on the
    /// mesh as given, or what `initial.keep` says.
    #[schemars(extend("minimum" = 0))]
    pub rest_length: Option<PerEdge>,
    /// [-] The rest length as a factor of the edge's length on the mesh as given; not together with `rest_length`. Or
    /// `{"table": [[t, s], ...]}`: the rest length, from `rest_length` or the edge, times a factor s(t), for a winch
    /// or a reefing line. The stiffness stays what it is at s = 1. The work -T l0 ds of the change is `external_work`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rest_scale: Option<Factor>,
    /// [kg/m] Mass per metre of edge on the mesh as given, half of it to each end; adds to the `mass` section.
    #[schemars(range(min = 0))]
    pub linear_density: Option<f64>,
    /// [s] When the springs are cut, within the run: from then on they carry no force, and neither do their dashpots.
    /// The energy that they hold counts as dissipated. Their mass stays. Or `{"table": [[t, share], ...]}`, which cuts
    /// the springs one after another, in the order of the mesh.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cut: Option<CutRule>,
    /// When the springs are cut, by the state of the scene or after another event; not together with `cut`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub when: Option<When>,
    /// [N] Strength of each spring. A run then measures its largest tension, at every step, and reports how many times
    /// this is as much. It does not break, unless `breaks` says so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub strength: Option<f64>,
    /// Whether each spring breaks when its tension, with that of its dashpot, reaches its `strength`; no if not given.
    /// The energy that it holds counts as dissipated. Steps end at each break.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub breaks: bool,
    /// When the spring is slack; not given: it acts in tension and in compression.
    /// With explicit methods, springs that go slack and taut from step to step can gain energy in steps above some 0.6
    /// of the critical one.
    pub slack: Option<SlackRule>,
    /// A dashpot beside the spring.
    pub dashpot: Option<Dashpot>,
}

/// When springs are cut: all at a time, or one after another by a table.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum CutRule {
    /// [s] all at this time
    At(f64),
    /// one after another
    Table(CutTable),
}

impl JsonSchema for CutRule {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "CutRule".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let table = generator.subschema_for::<CutTable>().to_value();
        json_schema!({"oneOf": [{"type": "number"}, table]})
    }
}

/// Springs that are cut one after another, in the order of the mesh.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CutTable {
    /// [s, -] Rows `[t, share]` of a time and the share of the rule's springs that are cut by then, from 0 to 1; linear
    /// between rows. Neither falls from row to row; what the last row leaves holds to the end of the run.
    #[schemars(length(min = 1))]
    pub table: Vec<[f64; 2]>,
    /// [-] Number of springs that are cut together, as a ring of as many as there are gores: when the share covers them
    /// all. 1 if not given. Each such number is a force of its own and an end of a step, so hundreds of them take time.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    #[schemars(range(min = 1))]
    pub together: usize,
}

fn one() -> usize {
    1
}

fn is_one(count: &usize) -> bool {
    *count == 1
}

/// Stiffness from a continuous sheet: k = E t (sum of the adjacent triangles' areas)/l^2, areas and l on the mesh as
/// given (Van Gelder 1998). On a regular net it tends to k = (sqrt 3/2) E t and a Poisson ratio of 1/3.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Membrane {
    /// [Pa] Young's modulus E.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub modulus: f64,
    /// [m] Thickness t.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness: f64,
}

/// How the tension T of a spring grows with its strain r = (l - l0)/l0. All but the linear law need a rest length.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ElasticLawRule {
    /// T = k (l - l0).
    Linear,
    /// T = EA lambda (lambda^2 - 1)/2 with lambda = l/l0 and EA = k l0: the bar of finite strain (St. Venant-Kirchhoff)
    /// that finite-element codes have. It agrees with the linear law at small strains.
    Green,
    /// [-, N] Rows of strain and force as measured: linear between the rows, and beyond them with the first and last
    /// slopes. Strains increase and forces do not fall; the force is 0 at the strain 0. In place of a stiffness:
    /// dashpots by `time` and Kang's filter take the steepest slope over l0 for k.
    Table(#[schemars(length(min = 2, max = 100))] Vec<[f64; 2]>),
}

/// When a spring is slack; e = l - l0 is its elongation.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub enum SlackRule {
    /// T = k max(e, 0): no compression.
    #[serde(rename = "tension-only")]
    TensionOnly,
    /// [m] T = k max(e - eps, 0): tension only, where the spring is longer than l0 by more than this eps.
    #[serde(rename = "dead_zone")]
    DeadZone(#[schemars(range(min = 0))] f64),
    /// [m] T = k max(e, -eps): the compression is constant where the spring is shorter than l0 by more than this eps.
    #[serde(rename = "compression_limit")]
    CompressionLimit(#[schemars(range(min = 0))] f64),
    /// T = k min(e, 0): no tension, as of a strut that only rests on its nodes.
    #[serde(rename = "compression-only")]
    CompressionOnly,
}

/// A dashpot beside a spring.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Dashpot {
    /// c ldot along the spring. Beside a tension-only spring the sum of both is at least 0: a rope never pushes. It
    /// pulls while it is slack where its ends move apart faster than k/c times the slack.
    Axial(DashpotRule),
    /// c (vb - va), all three components, slack or not.
    Relative(DashpotRule),
}

/// How the coefficient c of a dashpot is found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum DashpotRule {
    /// [N s/m] The coefficient c itself.
    Coefficient(#[schemars(range(min = 0))] f64),
    /// [s] Retardation time tau: c = k tau.
    Time(#[schemars(range(min = 0))] f64),
    /// [N s] Coefficient of the strain rate: c = this/l0.
    PerStrain(#[schemars(range(min = 0))] f64),
    /// c = k h with the fixed step h, the linearised implicit term of the thesis' Eq. 53 and 68. The physics then
    /// changes with the step: use it only to reproduce the thesis.
    Step,
}
