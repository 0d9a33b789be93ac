//! The air: what blows through and against the cloth, what fills canopies, and the drag of lines and bodies.

use super::event::When;
use super::glide::Glide;
use super::select::{NodeOrEdgeSelection, NodeSelection};
use super::wind::{Atmosphere, Wind, numbers};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The air. At least one of `law`, `canopy` and `drag` is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Aero {
    /// [m/s] Wind velocity: a vector, `{"table": [[t, x, y, z], ...]}` over time [s], `{"file": "wind.csv"}` with such
    /// rows (numbers separated by commas, semicolons or tabs; a first row of words is a heading, `#` begins a comment),
    /// `{"profile": [[height, x, y, z], ...]}` over the height above sea level [m], `{"gust": {...}}`, or
    /// `{"sum": [...]}` of several. Beside a table, file or gust, `when` says from which event its times count. Calm
    /// air if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wind: Option<Wind>,
    /// Pressure jump over every triangle, driven by the wind's velocity along the triangle's normal relative to the
    /// cloth, v_n; it acts along the relative wind. For cloth that is held in a free stream. Or, with
    /// `surface_pressure`, pressures by zone for roofs and other surfaces that the wind flows around. Not together with
    /// `canopy`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<PorousLaw>,
    /// The air in a canopy that hangs over its lines, or in each of a list of canopies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub canopy: Option<OneOrSeveral<Canopy>>,
    /// Drag of lines and payloads.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub drag: Vec<Drag>,
    /// Density of the air for `canopy`, `drag` and `surface_pressure`; 1.225 kg/m^3 if not given (sea level, standard
    /// atmosphere).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub atmosphere: Option<Atmosphere>,
    /// [m] Height of z = 0 above sea level, for `atmosphere` and wind profiles; 0 if not given. Heights grow with z.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub altitude: Option<f64>,
}

/// One of something, or a list of several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum OneOrSeveral<T> {
    // First: an empty list could be read as one of which everything is left out.
    /// several
    Several(Vec<T>),
    /// one
    One(Box<T>),
}

impl<T> OneOrSeveral<T> {
    /// All of them.
    pub fn all(&self) -> &[T] {
        match self {
            OneOrSeveral::One(one) => std::slice::from_ref(one),
            OneOrSeveral::Several(list) => list,
        }
    }

    /// All of them, to be changed.
    pub(crate) fn all_mut(&mut self) -> &mut [T] {
        match self {
            OneOrSeveral::One(one) => std::slice::from_mut(one),
            OneOrSeveral::Several(list) => list,
        }
    }
}

impl<T: JsonSchema> JsonSchema for OneOrSeveral<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        format!("OneOrSeveral_{}", T::schema_name()).into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let one = generator.subschema_for::<T>().to_value();
        json_schema!({"oneOf": [one, {"type": "array", "items": one}]})
    }
}

/// The air in a canopy: a pressure from inside to outside along the normals of its triangles, dp = q dCp with
/// q = rho V |V|/2, or that of a balance of the air inside. V is the axial air speed: the mean velocity of the skirt
/// minus the wind there (with `cavity` and `filling` that of the confluence), along the axis from the apex to the
/// confluence of the lines. Cloth that moves outwards at the normal speed w in the air that goes with the canopy meets
/// less of it, by rho/2 (V |V| - (V - w) |V - w|) dCp: this damps the breathing of the canopy, its turning and its
/// motion across the axis, and is nothing in steady flight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Canopy {
    /// Which triangles: `"all"`, `{"ids": [...]}` or `{"group": ...}`.
    pub on: NodeSelection,
    /// The pressure from a coefficient, constant or over the arc length from the apex to the skirt. Exactly one of
    /// `table`, `schedule`, `cavity` and `filling` is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub table: Option<PressureTable>,
    /// The pressure from a drag area that grows while the canopy fills, for opening loads: one stage, or a list of
    /// stages that follow each other, as with a reefing line.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub schedule: Option<OneOrSeveral<FillingSchedule>>,
    /// Only beside `schedule`, whose pressure does not depend on it: the measured air through the cloth. Measured loads
    /// of tight cloth are up to three times those of a schedule. The program warns of it where the cloth is tight, or
    /// nothing is told of it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<ClothLaw>,
    /// Experimental: the pressure from a balance of the air that flows through the mouth and the cloth. Shape, filling
    /// time and speed of fall come out at the right size, opening loads several times too large: take `filling` or
    /// `schedule` for those.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cavity: Option<Cavity>,
    /// The canopy fills by itself: the pressure from a balance of the air ring by ring, for opening loads without a
    /// filling time. Of generated canopies of gores.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub filling: Option<Filling>,
    /// [-] Apparent mass: the canopy takes along k times the mass of the air in its volume, which has momentum, but no
    /// weight. About 1 for a hemisphere. None if not given. Beside `cavity` it does not count the air twice: that
    /// balance is one of the volume of the air, without inertia. Only while a canopy fills, its growth takes the
    /// momentum of the inflow from the whole speed V, part of which the pressure in the mouth has taken already.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub apparent_mass: Option<f64>,
    /// [-] Loss coefficient k of the air that enters. Only beside `table` and `schedule`, which without it let a canopy
    /// take a new shape within hundredths of a second, as when a reefing line is cut. A canopy whose volume grows at
    /// dVol/dt has k rho u |u|/2 less pressure, times the coefficient of a `table`, with u = dVol/dt/A_m and the area
    /// of its mouth A_m; one that closes has more. 1 is the head of the air in the mouth. Nothing in steady flight. No
    /// loss if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 0))]
    pub inflow_loss: Option<f64>,
    /// Lift of a canopy that glides, such as a Rogallo wing. Only with the network's `model` `"point"`: the pressure
    /// of a net is even about its axis, and has no lift.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub glide: Option<Glide>,
    /// The nodes where the lines meet; if not given, those of the mesh's group `confluence`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confluence: Option<NodeSelection>,
    /// The nodes of the skirt, all or some of one closed loop of the canopy's boundary; if not given, those of the
    /// canopy in the mesh's group `skirt`, whose edges are such a loop, or, without such a group, the outer boundary of
    /// the triangles.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skirt: Option<NodeSelection>,
}

/// The pressure in a canopy over the dynamic pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureTable {
    /// [-] dCp, the pressure difference over the dynamic pressure: a number, or rows `[s, dCp]` over the arc length s
    /// from the apex (0) to the skirt (1) on the mesh as given.
    pub pressure_coefficient: PressureCoefficient,
}

/// The drag area of a canopy while it fills: from what it was at `start` (0 for the first stage) to `drag_area` by
/// ((t - start)/t_f)^exponent, until the filling time t_f = n D0/v_s (Knacke 1991). The same pressure acts on all
/// triangles; it is scaled so that its force along the axis is q times the drag area where the cloth does not breathe.
/// At most one of `drag_area` and `drag_coefficient`, and at most one of `filling_constant` and `filling_time` is
/// given. A generated parachute has defaults by its type, which `check` prints; else exactly one of them is given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FillingSchedule {
    /// [m^2] Drag area CdS at the end of the stage.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub drag_area: Option<f64>,
    /// [-] Drag coefficient at the end of the stage on the nominal area S0 = pi D0^2/4: the drag area over S0. With a
    /// reefing line that of the reefed canopy. In the last stage the CD0 of the parachute's type if no drag area is
    /// given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub drag_coefficient: Option<f64>,
    /// [-] Filling constant n; that of the parachute's type if no filling time is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub filling_constant: Option<f64>,
    /// [s] Filling time t_f.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub filling_time: Option<f64>,
    /// [-] Exponent of the growth; 2 if not given, that of the parachute's type if its filling constant is taken.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub exponent: Option<f64>,
    /// [s] When the stage begins: line stretch, or the cut of a reefing line; 0 if not given. Later in each stage.
    #[serde(default)]
    pub start: f64,
    /// When the stage begins, by the state of the scene or after another event; not together with `start`. A
    /// `filling_constant` without `speed` then takes the speed against the air at the event, of what the event looks
    /// at.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub when: Option<When>,
    /// [m/s] Speed v_s at the start of the stage, for `filling_constant`. Of the first stage it may be left out: then
    /// it is the speed of the skirt against the air at the start of the run, in whatever direction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub speed: Option<f64>,
    /// [m] Nominal diameter D0; if not given, that of a circle with the area of the triangles and the vent on the mesh
    /// as given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub nominal_diameter: Option<f64>,
}

/// A canopy with a mouth (experimental; the balance is this program's own). One pressure acts on the whole canopy, dp =
/// p_i - Cp q, with p_i inside such that as much air flows in through the mouth as the volume grows and the cloth lets
/// through: eta V A_m x = dVol/dt + A w(dp), p_i = q (1 - x |x|). A_m is the size of the area vector of the skirt's
/// loop, Vol the volume between the cloth and flat covers of its openings, A the area of the cloth. What leaves through
/// vents and slots is not counted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cavity {
    /// [-] Inflow eta: speed in the mouth over V at which the pressure inside falls to that of the still air. Smaller
    /// values fill more slowly: 0.3 to 0.6 gives filling constants of the right size.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub inflow: f64,
    /// [-] Pressure coefficient Cp on the outside of the canopy, mostly negative (about -0.6): the full canopy has
    /// dp = (1 - Cp) q if its cloth lets no air through.
    #[schemars(extend("exclusiveMaximum" = 1))]
    pub outer_pressure_coefficient: f64,
    /// The air through the cloth at a pressure difference, by its speed w; the cloth lets none through if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<ClothLaw>,
}

/// A canopy that fills by a balance of the air at each of its rings, the rows of its cloth (this program's own law,
/// held against measured openings of rescue parachutes). What passes the disc of a ring is the growth of the volume
/// above it and what leaks there: x = (dVol/dt + leaks)/(A |V|). The pressure inside is q - q (x |x| + max(0, X^2 - 1))
/// with the largest x from the ring to the skirt, X; outside it is Cb q above the widest ring, and rises below it as
/// the mouth takes the stream. V is the axial air speed of the confluence. All constants have defaults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Filling {
    /// [-] Pressure coefficient Cb on the outside of the canopy; -0.7 if neither it nor `drag_coefficient` is given
    /// (flat canopies; ringslot about -0.45, ribbon about -0.3).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMaximum" = 1))]
    pub outer_pressure_coefficient: Option<f64>,
    /// [-] Measured CD0 of the open canopy; 0.62 for the type `hemispherical` if neither is given. From it Cb = 1 -
    /// CD0/0.43: the skirt of an open canopy over lines of one nominal diameter has 0.43 S0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub drag_coefficient: Option<f64>,
    /// The air through the cloth at a pressure difference, by its speed w; the cloth lets none through if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub law: Option<ClothLaw>,
    /// [-] Geometric porosity: the share of the cloth that is open as slots which the mesh does not have; 0 if not
    /// given.
    #[serde(default)]
    #[schemars(range(min = 0, max = 1))]
    pub geometric_porosity: f64,
    /// [-] kd: cloth that moves outwards at w meets kd rho |V| w less pressure; 1 if not given (order one by the
    /// breathing of full canopies; 0.7 gives 26 % higher, 1.4 22 % lower peaks).
    #[serde(default = "unity")]
    #[schemars(range(min = 0))]
    pub damping: f64,
    /// [-] kv: and kv rho w |w| less; 0.5 if not given (0 gives 4 % higher peaks).
    #[serde(default = "half")]
    #[schemars(range(min = 0))]
    pub quadratic_damping: f64,
    /// [-] Discharge coefficient of slots and of gaps in the mesh: w = Cd sqrt(2 dp/rho); 0.65 if not given.
    #[serde(default = "slot_discharge")]
    #[schemars(range(min = 0))]
    pub slot_discharge: f64,
    /// [-] Discharge coefficient of the vent; 0.6 if not given, 0 for a vent that is covered.
    #[serde(default = "vent_discharge")]
    #[schemars(range(min = 0))]
    pub vent_discharge: f64,
}

/// Pressure difference over a cloth as a function of the speed of the air through it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ClothLaw {
    /// Ergun's equation for a porous layer.
    Ergun(ErgunLaw),
    /// Measured permeability of a cloth: dp = e (a w + b w |w|).
    Permeable(PermeableLaw),
}

impl From<ClothLaw> for PorousLaw {
    fn from(law: ClothLaw) -> Self {
        match law {
            ClothLaw::Ergun(law) => PorousLaw::Ergun(law),
            ClothLaw::Permeable(law) => PorousLaw::Permeable(law),
        }
    }
}

fn unity() -> f64 {
    1.0
}

fn half() -> f64 {
    0.5
}

fn slot_discharge() -> f64 {
    0.65
}

fn vent_discharge() -> f64 {
    0.6
}

/// dCp, constant or over the arc length.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum PressureCoefficient {
    /// [-] the same everywhere
    Constant(f64),
    /// [-, -] rows of arc length, from 0 to 1, and dCp
    Rows(Vec<[f64; 2]>),
}

impl JsonSchema for PressureCoefficient {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "PressureCoefficient".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"oneOf": [{"type": "number"}, {"type": "array", "items": numbers(2), "minItems": 1}]})
    }
}

/// Drag in the air around lines or bodies: of lines with `diameter` and `coefficient`, of bodies with `drag_area`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Drag {
    /// Which edges, for lines; which nodes, for bodies.
    pub on: NodeOrEdgeSelection,
    /// [m] Diameter d of a line. The drag of a segment of length L is rho Cd d L |V_n| V_n/2, with the part V_n of the
    /// relative wind across it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub diameter: Option<f64>,
    /// [-] Drag coefficient Cd of a line, on the wind across it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub coefficient: Option<f64>,
    /// [m^2] Drag area of a body: drag coefficient times area; the selected nodes share it equally.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub drag_area: Option<f64>,
    /// Lift of a body that glides; only beside `drag_area`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub glide: Option<Glide>,
}

/// Pressure jump as a function of v_n, or pressure coefficients by zone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum PorousLaw {
    /// Ergun's equation for a porous layer.
    Ergun(ErgunLaw),
    /// Measured permeability of a cloth: dp = e (a v_n + b v_n |v_n|).
    Permeable(PermeableLaw),
    /// A plain pressure coefficient: dp = cp rho/2 v_n |v_n|.
    PressureCoefficient(PressureCoefficientLaw),
    /// [-] Pressure coefficients by zone, as building codes give them: `{group: cp}`, the groups being triangles; `all`
    /// stands for all of them. cp q acts along the normal of each triangle, with the dynamic pressure of the wind at
    /// its height, q = rho |V|^2/2. The outer face is the one that the triangles' right-hand normals look out of: a
    /// positive cp pushes onto it, a negative one is suction. cp is a number, or rows `[angle, cp]` over the angle, in
    /// radians, between the outer normal and the direction that the wind comes from: 0 where the wind meets the outer
    /// face, pi/2 along it, pi on the lee side; linear between the rows, constant outside them. Triangles in no zone
    /// have no pressure. The velocity of the surface does not count.
    SurfacePressure(BTreeMap<String, ZoneCoefficient>),
}

/// \[-\] Pressure coefficient cp of a zone, constant or over the angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ZoneCoefficient {
    /// [-] at all angles
    Constant(f64),
    /// \[rad, -\] rows of the angle and cp
    Rows(Vec<[f64; 2]>),
}

impl JsonSchema for ZoneCoefficient {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ZoneCoefficient".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"oneOf": [{"type": "number"}, {"type": "array", "items": numbers(2), "minItems": 1}]})
    }
}

/// Ergun's equation (Ergun 1952) for a layer of thickness e: dp = e (A v_s + B v_s |v_s|).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ErgunLaw {
    /// [-] Porosity: the part of the volume that is air.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub porosity: f64,
    /// [m] Pore diameter D.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub pore_diameter: f64,
    /// [m] Thickness e of the cloth.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness: f64,
    /// [kg/m^3] Density of the air; 1.225 if not given (sea level, standard atmosphere).
    #[serde(default = "standard_density")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub air_density: f64,
    /// [Pa s] Dynamic viscosity of the air; 1.81e-5 if not given (15 to 20 degrees Celsius).
    #[serde(default = "standard_viscosity")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub air_viscosity: f64,
    /// Which reading of the equation.
    #[serde(default)]
    pub form: ErgunForm,
}

/// Which reading of Ergun's equation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ErgunForm {
    /// As Ergun wrote it: eps^3 in the denominators, v_s = v_n.
    #[default]
    Corrected,
    /// As the thesis prints it, Eq. 7 to 9: eps^2 twice and v_s = eps v_n. Only to reproduce the thesis.
    Paper,
}

/// Measured permeability of a cloth: dp = e (a v_n + b v_n |v_n|). At least one of a and b is above 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PermeableLaw {
    /// [Pa s/m^2] Viscous coefficient a.
    #[schemars(range(min = 0))]
    pub a: f64,
    /// [Pa s^2/m^3] Inertial coefficient b.
    #[schemars(range(min = 0))]
    pub b: f64,
    /// [m] Thickness e of the cloth.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thickness: f64,
}

/// A plain pressure coefficient: dp = cp rho/2 v_n |v_n|.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PressureCoefficientLaw {
    /// [-] Pressure coefficient cp.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cp: f64,
    /// [kg/m^3] Density of the air; 1.225 if not given (sea level, standard atmosphere).
    #[serde(default = "standard_density")]
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub air_density: f64,
}

fn standard_density() -> f64 {
    1.225
}

fn standard_viscosity() -> f64 {
    1.81e-5
}
