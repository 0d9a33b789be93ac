//! The parts of a parachute beside its canopy, as they are asked for.

use serde::{Deserialize, Serialize};

/// Straight lines of equal segments.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct LineParameters {
    /// [m] length
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub length: f64,
    /// [-] number of edges of each line; 1 if absent
    #[serde(default = "super::one")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub segments: usize,
}

/// Lines of a parachute, each of equal segments.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RigLineParameters {
    /// [m] length; of `lines` that of the type if absent (`check` prints it), others need one
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub length: Option<f64>,
    /// [-] number of edges of each line; 1 if absent
    #[serde(default = "super::one")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub segments: usize,
    /// Name of the material: a line, tape or cable. A case then has springs on these edges without a rule for them, and
    /// drag of suspension lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

impl RigLineParameters {
    /// The line, if its length is known.
    pub(super) fn known(&self) -> Option<LineParameters> {
        let Self { length, segments, .. } = *self;
        length.map(|length| LineParameters { length, segments })
    }
}

/// Names of the materials of a parachute's tapes. Those that are absent have the material of `lines`: the lines of many
/// round canopies run over them, in the seams.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TapeMaterials {
    /// along the seams of the gores
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radials: Option<String>,
    /// around the skirt
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skirt: Option<String>,
    /// around the vent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vent: Option<String>,
    /// across the vent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vent_lines: Option<String>,
    /// along gaps and slots
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rims: Option<String>,
    /// across the ribbons of a ribbon canopy
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verticals: Option<String>,
}

/// Lines from the vent to the confluence.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct InnerLineParameters {
    /// [m] unstretched length; that of `lines` if absent. Then the pressure on a ring between vent and skirt points
    /// away from the confluence; shorter lines turn it inwards, so that the canopy closes, and longer ones let the
    /// vent rise. In a case whose mesh is a file the spring rule must give it
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub length: Option<f64>,
    /// [-] number of edges of each line; 1 if absent
    #[serde(default = "super::one")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub segments: usize,
    /// Name of the material, as of `lines`, which is also the default
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
}

/// A rigid payload: four particles of a quarter of its mass each, which have its centre and its moments of inertia.
///
/// Its size is given by exactly one of `box` and `radii_of_gyration`. The particles are at the corners (+++), (+--),
/// (-+-) and (--+) of a box around the centre, six edges (`payload-bars`) join them, and four edges (`slings`) lead
/// from the end of the riser to them. Their masses come from `mass.points` with the group `payload`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PayloadParameters {
    /// [m] edges of a box of even density along x, y and z
    #[serde(rename = "box", default, skip_serializing_if = "Option::is_none")]
    pub sides: Option<[f64; 3]>,
    /// [m] radii of gyration sqrt(I/m) about x, y and z through the centre; each square below the sum of the others
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radii_of_gyration: Option<[f64; 3]>,
    /// [m] distance from the end of the riser down to the centre, more than the half height of the particles
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub below_riser: f64,
}

/// Equal parachutes that share the end of their risers (or their confluence), leaning outwards so far that they do not
/// touch at the start. Each group holds the parts of all of them; those of the first alone are in `canopy-1`,
/// `skirt-1`, and so on. Canopies pass through each other unless `contact` names them, or springs on the edges of the
/// group `spacers`, from the apex of each to those of its neighbours, stand for what holds them apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ClusterParameters {
    /// [-] number of parachutes
    #[cfg_attr(feature = "schema", schemars(range(min = 2, max = 20)))]
    pub canopies: usize,
}

/// A reefing line: a ring of edges from line to line along the skirt. A spring rule for the group `reefing` gives it
/// stiffness; without one no line acts, and the diameter is that of the start `inflated` alone. The rest length of
/// each edge is pi times the diameter over the number of gores, unless the rule gives another. In a case whose mesh is
/// a file the rule must give it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ReefingParameters {
    /// [m] length of the reefing line over pi; with the start `inflated` the skirt starts at this size, with
    /// `stretched` no wider
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub diameter: f64,
}

/// The shape at the start, by its name or with its sizes. Masses and rest lengths are those of the pattern in any
/// shape.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum Start {
    /// by its name
    Shape(StartShape),
    /// with its sizes
    Sized(SizedStart),
}

impl Default for Start {
    fn default() -> Self {
        Start::Shape(StartShape::default())
    }
}

impl From<StartShape> for Start {
    fn from(shape: StartShape) -> Self {
        Start::Shape(shape)
    }
}

impl Start {
    /// The shape alone.
    pub fn shape(&self) -> StartShape {
        match self {
            Start::Shape(shape) => *shape,
            Start::Sized(SizedStart::Stretched(_)) => StartShape::Stretched,
            Start::Sized(SizedStart::Packed(_)) => StartShape::Packed,
        }
    }

    /// [m] The radius of a stretched start, if it is given here.
    pub(super) fn stretched_radius(&self) -> Option<f64> {
        match self {
            Start::Sized(SizedStart::Stretched(start)) => Some(start.radius),
            _ => None,
        }
    }

    /// The sizes of a packed start; `None` of another one.
    pub fn packed(&self) -> Option<PackedStart> {
        match self {
            Start::Shape(StartShape::Packed) => Some(PackedStart::default()),
            Start::Sized(SizedStart::Packed(start)) => Some(*start),
            _ => None,
        }
    }
}

/// A shape at the start by its name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum StartShape {
    /// The pattern as it is cut, above straight lines.
    #[default]
    Flat,
    /// The shape of Taylor (1919) under an even pressure: no stress across the gores, whose cloth is slack there. For
    /// patterns that are wide enough everywhere: flat ones, and the extended skirt.
    Inflated,
    /// The tube of line stretch: a narrow folded canopy along the axis, whose skirt has the radius `start_radius`, on
    /// straight lines. Arc lengths along the gores are those of the pattern, and nothing is stretched. For every
    /// pattern. Inner lines draw the vent down into the tube.
    Stretched,
    /// The pack: lines in bights above the confluence, then the canopy folded along the axis. Nothing is stretched, and
    /// no cloth passes through other cloth. For every pattern.
    Packed,
}

/// A shape at the start with its sizes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum SizedStart {
    /// The tube of line stretch.
    Stretched(StretchedStart),
    /// The pack.
    Packed(PackedStart),
}

/// The size of the tube of line stretch.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct StretchedStart {
    /// [m] radius of the skirt, in place of `start_radius`
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub radius: f64,
}

/// The size of a pack, which begins at the confluence. A riser below it hangs straight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PackedStart {
    /// [m] length along the axis, from the confluence to the apex or vent; at most half of what canopy and lines are
    /// long, and a twentieth of it if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub length: Option<f64>,
    /// [m] radius to which folds and bights reach outwards, at most that of the skirt as it is cut; inwards they reach
    /// to half of it. 0.03 D0 if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub radius: Option<f64>,
    /// Whether there is a bag: a node `bag` above the pack, edges `stows` from it to bights and folds, and edges
    /// `bridle` to the apex or vent. Without tension they are as long as at the start. The bag needs a mass
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub bag: bool,
}
