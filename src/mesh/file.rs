//! A mesh file, and how its mesh is placed and repaired.

use super::look::{Look, Y_IS_UP, canopy_along_y, look, near_nodes, units};
use super::read::{self, Imported, extent};
use super::sew::{Seam, check_seams};
use super::source::{FaultSink, check_length, first_fault};
use super::{Mesh, MeshError, Topology};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A mesh file, and how its mesh is placed and repaired: in the order axes, scale, edge, merge, orient, sew, translate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct MeshFile {
    /// Name of the file; a relative path counts from the case file's folder. `canopy-fem mesh convert --help`
    /// lists the formats.
    pub file: String,
    /// Names of further files of the same mesh, such as one with the lines of a canopy. `merge` joins their nodes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub with: Vec<String>,
    /// [-] Factor on all coordinates: 0.001 for a file in millimetres. 1 if not given, but a .dxf file whose header
    /// tells a unit is scaled to metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Which axis of the file points up. `auto` if not given: y for .gltf and .glb, z for others. With y up, (x, y, z)
    /// of the file becomes (x, -z, y).
    #[serde(default, skip_serializing_if = "Axes::is_default")]
    pub axes: Axes,
    /// [m] Added to all coordinates, after `scale`; no move if not given.
    #[serde(default, skip_serializing_if = "is_origin")]
    pub translate: [f64; 3],
    /// [m] Closed polylines of a .dxf file are filled with triangles whose edges are about this long. A polyline inside
    /// another is a hole. Their own points stay, and long sides are divided. Without it polylines stay lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub edge: Option<f64>,
    /// [m] Nodes at most this far apart are joined, and the ends of lines with them; 0 joins those at the same place.
    /// Corners of .stl, .dxf, .gltf and .glb files are always joined, within 1e-5 of the extent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub merge: Option<f64>,
    /// Whether triangles are turned so that all normals of a part are on one side; the majority stays as it is.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub orient: bool,
    /// Which diagonals of quads become edges. `one` if not given.
    #[serde(default, skip_serializing_if = "Diagonals::is_default")]
    pub diagonals: Diagonals,
    /// Whether a file with a face that crosses itself is refused. Without it, such faces are left out with a warning.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub strict: bool,
    /// Seams along which flat pieces are sewn, as the gores of a drawing. Masses and rest lengths stay those of the
    /// flat pieces, which start where their seams meet. The mesh then has the edges of all seams as `seams`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sew: Vec<Seam>,
}

/// Which axis of a file points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Axes {
    /// As the format says: y for .gltf and .glb, z for others
    #[default]
    Auto,
    /// z, as here
    ZUp,
    /// y, as in many drawing programs
    YUp,
}

/// Which diagonals of a quad become edges.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "clap", derive(clap::ValueEnum))]
#[serde(rename_all = "kebab-case")]
pub enum Diagonals {
    /// The one that cuts it into two triangles. It makes the cloth stiffer along it than across it.
    #[default]
    One,
    /// Both where the quad is convex. The second is a line on the cloth, in the group `diagonals`.
    Both,
}

impl Axes {
    fn is_default(&self) -> bool {
        *self == Axes::Auto
    }
}

impl Diagonals {
    fn is_default(&self) -> bool {
        *self == Diagonals::One
    }
}

fn is_origin(translate: &[f64; 3]) -> bool {
    *translate == [0.0; 3]
}

impl MeshFile {
    /// Names of its keys in a case.
    pub(super) const KEYS: [&'static str; 11] =
        ["file", "with", "scale", "axes", "translate", "edge", "merge", "orient", "diagonals", "strict", "sew"];

    /// A file whose mesh is taken as it is.
    pub fn plain(file: impl Into<String>) -> Self {
        let (axes, diagonals) = (Axes::default(), Diagonals::default());
        let (file, with) = (file.into(), Vec::new());
        let (scale, translate, edge, merge) = (None, [0.0; 3], None, None);
        let sew = Vec::new();
        Self { file, with, scale, axes, translate, edge, merge, orient: false, diagonals, strict: false, sew }
    }

    /// Reports every value out of range, without opening the file.
    pub(super) fn check(&self, faults: FaultSink<'_>) {
        let with = self.with.iter().enumerate().map(|(i, name)| (format!("/with/{i}"), name));
        for (at, _) in with.chain([("/file".to_owned(), &self.file)]).filter(|(_, name)| name.is_empty()) {
            faults(&at, "\"\"".into(), "a file name".into(), "name a mesh file".into());
        }
        if let Some(scale) = self.scale {
            check_length("", "scale", scale, faults);
        }
        if !self.translate.iter().all(|x| x.is_finite()) {
            let value = format!("{:?}", self.translate);
            faults("/translate", value, "three finite numbers".into(), "give lengths in metres".into());
        }
        if let Some(edge) = self.edge {
            check_length("", "edge", edge, faults);
        }
        if let Some(distance) = self.merge.filter(|distance| !(distance.is_finite() && *distance >= 0.0)) {
            let hint = "give a length in metres, far below that of the shortest edge";
            faults("/merge", distance.to_string(), "finite and 0 or more".into(), hint.into());
        }
        check_seams(&self.sew, faults);
    }

    /// Reads the file and makes its mesh; `base` is the folder that a relative path counts from.
    ///
    /// # Errors
    /// The first value out of range, or [`MeshError::File`] with the file's name and the reason.
    pub fn read(&self, base: &Path) -> Result<Imported, MeshError> {
        first_fault(|faults| self.check(faults))?;
        let paths: Vec<_> = [&self.file].into_iter().chain(&self.with).map(|name| base.join(name)).collect();
        read::read_file(self, &paths.iter().map(|path| path.as_path()).collect::<Vec<_>>())
    }

    /// Turns, scales and moves points [m], and turns and scales displacements [m]. What is sewn is moved afterwards.
    pub(super) fn place(&self, points: &mut [[f64; 3]], displacements: &mut [[f64; 3]]) {
        let turned = |[x, y, z]: [f64; 3]| match self.axes {
            Axes::Auto | Axes::ZUp => [x, y, z],
            Axes::YUp => y_up(x, y, z),
        };
        let scale = self.scale.unwrap_or(1.0);
        if scale != 1.0 || self.axes == Axes::YUp {
            points.iter_mut().chain(displacements).for_each(|p| *p = turned(*p).map(|x| scale * x));
        }
        if self.sew.is_empty() {
            self.translate(points);
        }
    }

    /// Moves points [m].
    pub(super) fn translate(&self, points: &mut [[f64; 3]]) {
        if !is_origin(&self.translate) {
            points.iter_mut().for_each(|p| *p = std::array::from_fn(|k| p[k] + self.translate[k]));
        }
    }
}

/// The place of a point of a file whose y axis points up.
pub(super) fn y_up(x: f64, y: f64, z: f64) -> [f64; 3] {
    [x, -z, y]
}

/// What may be wrong with a mesh, and the option that mends it.
pub fn repairs(mesh: &Mesh, topology: &Topology) -> Vec<String> {
    let Look { gaps, others } = look(mesh, topology, &near_nodes(mesh, topology));
    let mut advice: Vec<String> = gaps.text().into_iter().collect();
    if let Err(error) = topology.check_orientation(mesh) {
        advice.push(format!("{error}, or turn all alike: --orient, or \"orient\" in a case"));
    }
    advice.extend(units(extent(&mesh.nodes)));
    advice.extend(canopy_along_y(mesh, topology).then(|| Y_IS_UP.to_owned()));
    advice.extend(others.into_iter().map(|warning| warning.text));
    advice
}
