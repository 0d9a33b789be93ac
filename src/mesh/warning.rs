//! Warnings about input that can run but is seldom intended. Each has a code, by which a case acknowledges it.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Kinds of warnings, by their codes in a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum WarningCode {
    /// Mass scaling that adds so much mass that the motion may be another.
    MassScaling,
    /// Air pressure above 1.5 times the dynamic pressure of the wind.
    AirPressure,
    /// Mass per area of the triangles outside the range of cloth.
    ArealDensity,
    /// An edge with more than two triangles under pressure.
    BranchingEdge,
    /// A body without supports, with damping that brakes its rotation.
    BrakedRotation,
    /// Cloth that passes through cloth, at the start or during a run.
    ClothCrossing,
    /// Cloth in the wind that nothing holds open.
    ClosingCanopy,
    /// Nodes at the same place that no spring joins.
    CoincidentNodes,
    /// Parts that may touch and are closer at the start than their contact lets them be.
    ContactAtStart,
    /// A step of an explicit method that is longer than a contact allows once its gap is 60 % closed.
    ContactStep,
    /// Frames that do not fit on the disk.
    DiskSpace,
    /// A canopy whose drag at the end is not that of its drag area.
    DragArea,
    /// A drag area that no canopy of this size has.
    DragCoefficient,
    /// Nearly all energy of a free body lost to damping that brakes its rotation.
    EnergyDissipated,
    /// Energy that the time-integration scheme itself has made.
    EnergyMade,
    /// An event whose condition holds at the start.
    EventAtStart,
    /// A support that would let go, or springs that would be cut, only after the end of the run.
    EventBeyondEnd,
    /// A model whose results are of the right size only in part.
    ExperimentalModel,
    /// A start from the results of a run that failed.
    FailedStart,
    /// A canopy that would be full only long after the end of the run.
    FillingBeyondEnd,
    /// Nodes on the edge of a triangle that they do not belong to.
    HangingNode,
    /// Springs that start far from their rest length.
    InitialStrain,
    /// Pressure coefficients on a surface whose outer faces look down or inwards.
    InsideOut,
    /// Coordinates so large that the canopy would be hundreds of metres across.
    LargeExtent,
    /// Gravity that no planet has.
    LargeGravity,
    /// A mass beyond that of any payload.
    LargeMass,
    /// A canopy that leaned further off its way through the air than the law of its air is for.
    LeaningCanopy,
    /// A step long compared with the motion of the scene.
    LongStep,
    /// Lines of a canopy that are not joined to it.
    LooseLines,
    /// Free nodes without a spring.
    LooseNodes,
    /// Steps so short that rounding removes part of the motion.
    LostMotion,
    /// What the reader of a mesh file left out or changed.
    MeshFile,
    /// A law of a free stream on a roof, where the wind has suctions that it has not.
    NoSuction,
    /// A part without supports, while other parts have supports.
    NoSupport,
    /// Pressure coefficients of the wind, and no wind.
    NoWind,
    /// Triangles that lie on other triangles of the same sheet.
    OverlappingTriangles,
    /// A reefing line that is not cut when the canopy begins its last stage, or whose cut no air slows.
    ReefingLine,
    /// Coordinates so far from the origin that their rounding changes the strains of the springs.
    RoundedCoordinates,
    /// Cloth that is open along a seam.
    SeamGap,
    /// A pulse of a table, or a gust, shorter than a few steps.
    ShortPulse,
    /// A canopy of cloth that falls with slack lines until an event opens it.
    SlackOpening,
    /// A step that is stable only as long as springs that are slack at the start stay so.
    SlackSprings,
    /// A mesh of a few centimetres or less in place of a canopy.
    SmallExtent,
    /// A small hole in cloth, like a face that was left out.
    SmallHole,
    /// A step above the critical one, at the start or later.
    StepAboveCritical,
    /// A step longer than the run.
    StepBeyondEnd,
    /// A dashpot whose coefficient follows the step.
    StepDashpot,
    /// Cloth that is strained more than cloth bears.
    StrainedCloth,
    /// A few triangles beside a large sheet that nothing connects to it.
    StrayTriangles,
    /// A speed above that of sound.
    SupersonicSpeed,
    /// Heights above those of the standard atmosphere.
    ThinAir,
    /// A schedule for cloth that is tight, or of which no permeability is given: measured loads are up to three times
    /// higher.
    TightCloth,
    /// A modulus, a thickness or an axial rigidity that no cloth and no line has.
    UnlikelyMaterial,
    /// Edges that no spring rule selects.
    UnselectedEdges,
    /// A spring rule without any edge.
    UnusedRule,
    /// A mesh file whose y axis points up.
    UpAxis,
    /// Wind in the plane of the triangles.
    WindInPlane,
}

impl fmt::Display for WarningCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // A unit variant is serialised as its name.
        self.serialize(f)
    }
}

/// A warning: the problem, its location, and a remedy.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Warning {
    /// its kind
    pub code: WarningCode,
    /// a sentence with its numbers
    pub text: String,
}

impl Warning {
    /// A warning of a kind.
    pub fn new(code: WarningCode, text: impl Into<String>) -> Self {
        Warning { code, text: text.into() }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} [{}]", self.text, self.code)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The printed code is the one a case may acknowledge.
    #[test]
    fn codes_are_printed_as_a_case_writes_them() {
        let warning = Warning::new(WarningCode::ArealDensity, "heavy cloth");
        assert_eq!(warning.to_string(), "heavy cloth [areal-density]");
        let read: WarningCode = serde_json::from_str("\"areal-density\"").expect("a code");
        assert_eq!(read, WarningCode::ArealDensity);
    }
}
