//! Rigged parachutes: a canopy cut to the pattern of its gores, with lines, riser and payload, as named groups.
//!
//! Unless it is turned and placed, the axis is z and the payload hangs below, along -z; the skirt is at z = 0.
//! Triangles turn so that their normals point outwards and upwards, the side to which the pressure inside pushes. Nodes
//! come in this order: apex, if there is no vent; rows from the vent to the skirt, each counter-clockwise from the +x
//! axis; confluence; inner nodes of the lines, line by line; end of the riser and its inner nodes; bag; particles of a
//! rigid payload. In a cluster the end of the risers is first, then the others parachute by parachute.

mod assembly;
mod check;
mod cruciform;
mod field;
mod kind;
mod outline;
mod packed;
mod parts;
mod payload;
mod place;
mod profile;
mod resolved;
mod rings;
mod sails;
mod slots;
mod stretched;
mod taylor;

use super::format_number::figures;
use super::{Mesh, MeshError};
use assembly::Assembly;
pub use field::FieldNumbers;
pub use kind::CanopyType;
pub use parts::{
    ClusterParameters, InnerLineParameters, LineParameters, PackedStart, PayloadParameters, ReefingParameters,
    RigLineParameters, SizedStart, Start, StartShape, StretchedStart, TapeMaterials,
};
use profile::Profile;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// [-] largest number of gores and of segments of any part
const MOST: usize = 10_000;
/// [-] largest part of the nominal area that the vent may take
const MOST_VENT: f64 = 0.5;
/// [-] least height of the confluence below the skirt over the length of the lines: flatter lines define no axis
const LEAST_HEIGHT: f64 = 1e-3;

/// A parachute. The pattern is cut so that cloth, slots and vent together have the area pi D0^2/4.
///
/// Groups: `canopy` (triangles), `cloth` (all their edges), `radials`, `skirt` and `vent` (edges among those of the
/// cloth, and the radials also across gaps; skirt and vent also select the nodes of their rows), `rims` (edges along
/// gaps), `verticals` (edges, also across gaps), `vent-lines`, `lines`, `inner-lines`, `centre-line`, `riser`,
/// `reefing`, `slings`, `payload-bars`, `stows` and `bridle` (edges), `apex`, `confluence`, `payload` and `bag`
/// (nodes).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ParachuteParameters {
    /// How the canopy is cut.
    #[serde(rename = "type")]
    pub kind: CanopyType,
    /// [m] nominal diameter D0, the diameter of a circle with the area of cloth, slots and vent; exactly one of it and
    /// `constructed_diameter` is given
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub nominal_diameter: Option<f64>,
    /// [m] constructed diameter, that of the circle inside the widest row of the pattern as it is cut, which is mostly
    /// the skirt: what shops call the size. Of a cruciform canopy the length of a strip. D0 follows from it
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub constructed_diameter: Option<f64>,
    /// Name of the material of the cloth. A case then has its springs, its mass and the air through it without a rule
    /// for the group `cloth`, `mass.areal_density` and a law
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cloth: Option<String>,
    /// Names of the materials of its tapes; that of `lines` if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tapes: Option<TapeMaterials>,
    /// [-] number of gores, which is that of the lines; even with vent lines, a multiple of 4 for a cruciform canopy
    /// and a square, of 3 for a triangle
    #[cfg_attr(feature = "schema", schemars(range(min = 3)))]
    pub gores: usize,
    /// [m] diameter of the circle through the vent's corners; no vent if absent. The vent takes at most half of the
    /// nominal area
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub vent_diameter: Option<f64>,
    /// [-] rows of cloth from the vent to the skirt, shared over rings and bands by their width; along an arm of a
    /// cruciform canopy
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub radial_segments: usize,
    /// [-] edges across a gore in every row; 1 if absent
    #[serde(default = "one")]
    #[cfg_attr(feature = "schema", schemars(range(min = 1)))]
    pub gore_segments: usize,
    /// Whether rows have fewer edges towards the apex, where gores are narrow: first columns of a gore become one, then
    /// gores. `gore_segments` counts at the skirt. Areas stay exact; an edge of `radials` and `vent-lines` may stand
    /// for several tapes or lines, whose stiffness, mass and strength a spring rule of the group multiplies. Of round
    /// canopies of gores without sails and verticals. In a case whose mesh is a file the spring rules must give it
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub coarsen: bool,
    /// [rad] angle of a cone's surface below the horizontal; also of a ribbon canopy, which is flat without it
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cone_angle: Option<f64>,
    /// [rad] angles of two or three cones, from the apex outwards
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cone_angles: Option<Vec<f64>>,
    /// [-] where the cone angle changes, as rising parts of the gore's length; equal parts if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cone_breaks: Option<Vec<f64>>,
    /// [-] length of an extended skirt over the diameter of the flat part; 0.1 if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skirt_extension: Option<f64>,
    /// [rad] angle of an extended skirt's surface below the horizontal, above 0 and below pi: at pi/2 it is a cylinder,
    /// below that its width keeps growing as that of a cone, above it is drawn in; pi/2 if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub skirt_angle: Option<f64>,
    /// [-] width over length of the strips of a cruciform canopy; 1/3 if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arm_ratio: Option<f64>,
    /// [-] number of rings of a ringslot canopy or a ringsail with its sails, of ribbons of a ribbon canopy
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rings: Option<usize>,
    /// [-] area of the slots between these over the nominal area
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slot_porosity: Option<f64>,
    /// [-] number of tapes across the ribbons in each gore, beside the radials; `gore_segments` is a multiple of one
    /// more. They meet at the apex as the gores do, where real ones are parallel. None if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub verticals: Option<usize>,
    /// [-] number of the rings of a ringsail, from the skirt, that are sails: 2 or more. Slots are above them, and gaps
    /// of a tenth of a slot's width between them
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sails: Option<usize>,
    /// [-] length of a sail's lower edge over the width of the gore there, less 1, above 0 and below 1. It falls to 0
    /// at the sail's upper edge and the skirt's sail has none. The mesh shows the gore: edges have the longer lengths
    /// without tension, which a case whose mesh is a file must give in its spring rules, and membranes of triangles
    /// ignore
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fullness: Option<f64>,
    /// [rad] part of the sphere on which a ringsail is cut, from its apex to the skirt as seen from its centre; pi/3 if
    /// absent, which is a quarter of the sphere's area
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cap_angle: Option<f64>,
    /// [-] height of the crest above the skirt over the radius of the skirt, of an elliptical or toroidal canopy, above
    /// 0 and below 2; if absent, the cross section of a toroidal one is half a circle
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height_ratio: Option<f64>,
    /// [-] depth of a toroidal canopy's vent below the crest over that of the skirt, above 0 and below 2: 1 is level
    /// with the skirt, more below it; 1 if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pull_down: Option<f64>,
    /// [-] part of a side at which a square's or triangle's corners are cut off, above 0 and below 0.5; not cut if
    /// absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub corner_cut: Option<f64>,
    /// [-] diameter of the disc over D0; `disk`, `gap` and `band` are scaled together to give the nominal area; 0.72 if
    /// absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disk: Option<f64>,
    /// [-] height of the gap over D0; 0.042 if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// [-] height of the band over D0; 0.121 if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub band: Option<f64>,
    /// Whether n/2 lines cross the vent, each from corner to corner without a node between; if absent, with a vent
    /// except that of types `annular`, `toroidal`, `square` and `triangular`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vent_lines: Option<bool>,
    /// Suspension lines from the skirt to the confluence; without them there is only the canopy. All have this length
    /// without tension; the flat pattern of a cruciform canopy shows those inside its ends shorter, and in a case whose
    /// mesh is a file the spring rule must give it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lines: Option<RigLineParameters>,
    /// Lines from the vent's corners to the confluence, as annular canopies have them; none if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inner_lines: Option<InnerLineParameters>,
    /// A line from the confluence up to the apex of a canopy of gores without a vent, which pulls it down; none if
    /// absent. Its length is that without tension; in a case whose mesh is a file the spring rule must give it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub centre_line: Option<RigLineParameters>,
    /// A line from the confluence down to the payload; the payload is at the confluence if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub riser: Option<RigLineParameters>,
    /// A rigid payload; a point if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub payload: Option<PayloadParameters>,
    /// Several such parachutes on one payload; one if absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cluster: Option<ClusterParameters>,
    /// A reefing line around the skirt.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reefing: Option<ReefingParameters>,
    /// The shape at the start: a name, `{"stretched": {"radius": ...}}` or `{"packed": {"length": ..., ...}}`.
    #[serde(default)]
    pub start: Start,
    /// [-] radius of the skirt over D0 at the start `stretched`; 0.025 if absent, and never more than that of a reefing
    /// line. It was measured through the filling constant alone: 0.025 fills a C-9 at 60 m/s in 8 diameters. It sets
    /// the time of filling more than the load
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[cfg_attr(feature = "schema", schemars(extend("exclusiveMinimum" = 0)))]
    pub start_radius: Option<f64>,
    /// [-] direction from the payload to the apex, of any length; of a cluster that from the payload to its middle. The
    /// whole rig turns about the payload. `[0, 0, 1]` if absent
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// [m] place of the payload: of the point, or of the centre of a rigid one; of the middle of the skirt's pattern
    /// for a canopy without lines. If absent, the payload stays where it is below a skirt at z = 0
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[f64; 3]>,
}

fn one() -> usize {
    1
}

/// Sizes of a parachute's pattern.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParachuteSizes {
    /// [m^2] nominal area S0 of cloth, gaps and vent
    pub nominal_area: f64,
    /// [m^2] area of the cloth
    pub cloth_area: f64,
    /// [m] constructed diameter: of the circle inside the skirt, as constructed
    pub constructed_diameter: f64,
    /// [m] length of the gore's centre line from the apex to the skirt; of a strip of a cruciform canopy; from the
    /// centre to a side of a square or triangle
    pub gore_length: f64,
}

impl ParachuteParameters {
    fn has_vent_lines(&self) -> bool {
        use CanopyType::{Annular, Square, Toroidal, Triangular};
        let without = matches!(self.kind, Annular | Toroidal | Square | Triangular);
        self.vent_diameter.is_some() && self.vent_lines.unwrap_or(!without)
    }

    /// The sizes of the pattern; the parameters must have passed [`ParachuteParameters::check`].
    ///
    /// # Errors
    /// A vent that leaves no cloth, and too few rows.
    pub fn sizes(&self) -> Result<ParachuteSizes, MeshError> {
        self.resolved()?.sizes_of_pattern()
    }

    /// The same once D0 is known.
    fn sizes_of_pattern(&self) -> Result<ParachuteSizes, MeshError> {
        if self.kind == CanopyType::Cruciform {
            return Ok(cruciform::Cross::of(self).sizes());
        }
        let profile = Profile::of(self)?;
        let Profile { nominal_area, cloth_area, gore_length, .. } = profile;
        let constructed_diameter = 2.0 * profile.rows.iter().map(|row| row.apothem).fold(0.0, f64::max);
        Ok(ParachuteSizes { nominal_area, cloth_area, constructed_diameter, gore_length })
    }

    /// The sizes of the pattern and of its mesh in words, each with what it is about.
    ///
    /// # Errors
    /// As [`ParachuteParameters::sizes`].
    pub fn describe_sizes(&self, mesh: &Mesh) -> Result<Vec<(&'static str, String)>, MeshError> {
        let whole = &*self.resolved()?;
        let d0 = whole.d0();
        let ParachuteSizes { nominal_area, cloth_area, constructed_diameter, gore_length } =
            whole.sizes_of_pattern()?;
        let open = 100.0 * (nominal_area - cloth_area).max(0.0) / nominal_area;
        let mut lines = vec![
            ("nominal", format!("D0 {d0:.6} m, S0 {nominal_area:.6} m^2")),
            ("cloth", format!("{cloth_area:.6} m^2, {open:.2} % of S0 open")),
            (
                "constructed",
                format!(
                    "diameter {constructed_diameter:.6} m ({:.4} D0), gore {gore_length:.6} m long",
                    constructed_diameter / d0
                ),
            ),
        ];
        if let Some(LineParameters { length, .. }) = whole.lines() {
            lines.push(("lines", format!("{} of {length:.6} m ({:.4} D0)", self.gores, length / d0)));
        }
        if let Some(LineParameters { length, .. }) = whole.centre() {
            lines.push(("centre line", format!("{length:.6} m ({:.4} D0)", length / d0)));
        }
        if let Some(length) = whole.inner_length().filter(|_| self.inner_lines.is_some()) {
            lines.push(("inner lines", format!("{} of {length:.6} m ({:.4} D0)", self.gores, length / d0)));
        }
        if let Some(ReefingParameters { diameter }) = self.reefing {
            let rest = self.reefing_length().unwrap_or_default();
            lines.push((
                "reefing",
                format!("diameter {diameter:.6} m; rest length of each edge in \"reefing\" {rest:.9} m"),
            ));
        }
        let cloth = mesh.groups.get("cloth").map(|group| group.edges.as_slice()).unwrap_or_default();
        let ends = cloth.iter().filter_map(|&edge| mesh.edges.get(edge as usize));
        let longest = ends.map(|&[a, b]| (mesh.point(a) - mesh.point(b)).norm()).fold(0.0, f64::max);
        if let Some(most) = mesh.strands.values().flat_map(BTreeMap::values).copied().reduce(f64::max) {
            let text = format!("an edge of radials or vent lines stands for up to {}", figures(most, 3));
            lines.push(("strands", text));
        }
        lines.extend(self.start.packed().and_then(|_| packed::describe(mesh)).map(|text| ("pack", text)));
        if let Some(text) = self.kind.numbers().describe() {
            lines.push(("of this type", text));
        }
        lines.push(("fineness", format!("longest edge of the cloth {longest:.6} m ({:.4} D0)", longest / d0)));
        Ok(lines)
    }

    /// Makes the mesh; the parameters must have passed [`ParachuteParameters::check`].
    ///
    /// # Errors
    /// A vent that leaves no cloth, too few rows, lines that are too short, and a start shape that does not exist.
    pub fn build(&self) -> Result<Mesh, MeshError> {
        self.resolved()?.build_resolved()
    }

    fn build_resolved(&self) -> Result<Mesh, MeshError> {
        let mut parts = Assembly::default();
        match self.kind {
            CanopyType::Cruciform => cruciform::Cross::of(self).add_to(&mut parts),
            _ => parts.add_gores(self, &Profile::of(self)?),
        }
        parts.add_verticals(self);
        if let Some(lines) = self.lines() {
            parts.add_rig(self, lines)?;
        }
        if self.reefing.is_some() {
            parts.add_reefing();
        }
        match self.start.shape() {
            StartShape::Flat => {}
            StartShape::Inflated => parts.inflate(self)?,
            StartShape::Stretched => parts.stretch(self)?,
            StartShape::Packed => parts.pack(self)?,
        }
        let mut mesh = parts.into_mesh();
        if let Some(cluster) = self.cluster {
            mesh = payload::cluster(self, &mesh, cluster)?;
        }
        if let Some(payload) = &self.payload {
            payload::hang(&mut mesh, payload);
        }
        place::place(&mut mesh, self.axis.unwrap_or(place::UPWARDS), self.at);
        Ok(mesh)
    }
}

impl ParachuteParameters {
    /// [m] Unstretched length of the inner lines or the centre line; `None` without any.
    fn inner_length(&self) -> Option<f64> {
        let inner = self.inner_lines.as_ref().zip(self.lines());
        let inner = inner.map(|(inner, lines)| inner.length.unwrap_or(lines.length));
        inner.or(self.centre().map(|line| line.length))
    }

    /// [m] Unstretched lengths of edges that the flat mesh shows longer or shorter: lines of a cruciform canopy, a
    /// square and a triangle, whose corners are not equally far from the confluence, inner lines, a centre line, sails,
    /// and what ties a pack to its bag.
    pub fn line_lengths(&self, mesh: &Mesh) -> Vec<(u32, f64)> {
        let Ok(whole) = self.resolved() else { return Vec::new() };
        let uneven = self.kind == CanopyType::Cruciform || outline::sides(self.kind).is_some();
        let lines = whole.lines().filter(|_| uneven);
        let lines = lines.map(|lines| ("lines", lines.length, lines.segments));
        let inner = self.inner_lines.as_ref().zip(whole.inner_length());
        let inner = inner.map(|(inner, length)| ("inner-lines", length, inner.segments));
        let centre = self.centre().map(|line| ("centre-line", line.length, line.segments));
        let of = |(name, length, segments): (&str, f64, usize)| {
            let edges = mesh.groups.get(name).map(|group| group.edges.clone()).unwrap_or_default();
            edges.into_iter().map(move |edge| (edge, length / segments as f64)).collect::<Vec<_>>()
        };
        let of_lines = lines.into_iter().chain(inner).chain(centre).flat_map(of);
        of_lines.chain(sails::full_lengths(self, mesh)).chain(packed::lengths_of_bag(mesh)).collect()
    }

    /// [m] Rest length of each edge of the reefing line.
    pub fn reefing_length(&self) -> Option<f64> {
        self.reefing.map(|reefing| PI * reefing.diameter / self.gores as f64)
    }
}

/// [m] Distance of the skirt's corners from the axis at which a reefing line of this diameter is taut.
fn reefed_radius(reefing: ReefingParameters, gores: usize) -> f64 {
    let n = gores as f64;
    0.5 * PI * reefing.diameter / (n * (PI / n).sin())
}
