//! The mesh with the data that the other sections need: lengths, areas, selections, valid triangles.

use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector3;

use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::EdgeSelection;
use crate::format_number::figures;
use crate::mesh::box_tree::Bounds;
use crate::mesh::file::Axes;
use crate::mesh::look::{Look, Y_IS_UP, canopy_along_y, look, units};
use crate::mesh::read::Imported;
use crate::mesh::source::MeshSource;
use crate::mesh::{Mesh, MeshError, Topology};
use crate::startup::{Phase, timed};
use crate::warning::{Warning, WarningCode};

/// A mesh and its topology.
#[derive(Debug)]
pub(crate) struct Geometry {
    /// its source, to compare it with that of another case
    source: MeshSource,
    /// what the reader of a mesh file changed
    notes: Vec<String>,
    /// what its mesh shows, if it was not generated
    doubts: Vec<Warning>,
    /// whether the y axis of its file seems to point up
    y_is_up: bool,
    /// the mesh as given
    pub mesh: Mesh,
    /// boundary loops and the triangles at every edge
    pub topology: Topology,
    /// [m] length of every edge on the mesh as given
    pub length: Vec<f64>,
    /// [m] length of every edge without tension: that on the mesh, but for sewn pieces, which are cut flat, and lines
    /// of a parachute that are told
    pub unstretched: Vec<f64>,
    /// [m^2] area of every triangle on the mesh as given, or as cut flat
    pub area: Vec<f64>,
}

impl Geometry {
    /// Of a mesh that has passed [`Mesh::check`].
    fn new(source: &MeshSource, imported: Imported) -> Self {
        let Imported { mesh, notes, .. } = imported;
        let topology = Topology::of_checked(&mesh);
        let at = |node: u32| mesh.nodes.get(node as usize).map_or(Vector3::repeat(f64::NAN), |p| Vector3::from(*p));
        let length: Vec<f64> = mesh.edges.iter().map(|&[a, b]| (at(a) - at(b)).norm()).collect();
        let mut unstretched: Vec<f64> = match &mesh.cut {
            Some(cut) => cut.lengths.clone(),
            None => length.clone(),
        };
        if let MeshSource::Parachute(parachute) = source {
            for (edge, told) in parachute.line_lengths(&mesh) {
                unstretched[edge as usize] = told;
            }
        }
        let area = |t| mesh.cut_corners(t).map_or(f64::NAN, |[a, b, c]| 0.5 * (b - a).cross(&(c - a)).norm());
        let area = (0..mesh.triangles.len() as u32).map(area).collect();
        let doubts = doubts(source, &mesh, &topology);
        let y_is_up =
            matches!(source, MeshSource::File(file) if file.axes == Axes::Auto) && canopy_along_y(&mesh, &topology);
        Self { source: source.clone(), notes, doubts, y_is_up, mesh, topology, length, unstretched, area }
    }

    /// Warnings about the mesh for a scene with this gravity [m/s^2].
    pub(crate) fn y_is_up(&self, gravity: Option<[f64; 3]>) -> Option<Warning> {
        let along_z = gravity.is_some_and(|[x, y, z]| z.abs() > x.hypot(y));
        (self.y_is_up && along_z).then(|| Warning::new(WarningCode::UpAxis, Y_IS_UP))
    }

    /// Whether the extent of the mesh has a warning.
    pub(crate) fn extent_is_told(&self) -> bool {
        self.doubts.iter().any(|doubt| doubt.code == WarningCode::LargeExtent)
    }

    /// [m] Rest length of the edges of a generated parachute's reefing line.
    pub(crate) fn reefing_length(&self) -> Option<f64> {
        match &self.source {
            MeshSource::Parachute(parachute) => parachute.reefing_length(),
            _ => None,
        }
    }

    /// [N/m] Stiffness of an edge of a net that stands for a sheet of stiffness `et` = E t [N/m], from its triangles
    /// that belong to the sheet: k = E t (sum of their areas)/l^2 (Van Gelder 1998).
    pub(crate) fn net_stiffness(&self, et: f64, edge: usize, of_sheet: impl Fn(u32) -> bool) -> f64 {
        let triangles = self.topology.edge_triangles(edge).iter().filter(|&&t| of_sheet(t));
        let area: f64 = triangles.filter_map(|&t| self.area.get(t as usize)).sum();
        let length = self.unstretched.get(edge).copied().unwrap_or(f64::NAN);
        et * area / (length * length)
    }

    /// [-] How many tapes or lines each of these edges of a group stands for; `None` where each is one.
    pub(super) fn strands(&self, on: &EdgeSelection, edges: &[u32]) -> Option<Vec<f64>> {
        let strands = self.mesh.strands.get(on.group()?)?;
        Some(edges.iter().map(|edge| strands.get(edge).copied().unwrap_or(1.0)).collect())
    }

    /// Number of nodes.
    pub(crate) fn nodes(&self) -> usize {
        self.mesh.nodes.len()
    }

    /// [m] Length of an edge at the start; `displacement` [m] is `[n_nodes][3]`, or empty if no node is displaced.
    pub(crate) fn start_length(&self, edge: u32, displacement: &[[f64; 3]]) -> Option<f64> {
        if displacement.is_empty() {
            return self.length.get(edge as usize).copied();
        }
        let place = |node: u32| {
            let x = self.mesh.nodes.get(node as usize)?;
            let u = displacement.get(node as usize)?;
            Some(Vector3::from(*x) + Vector3::from(*u))
        };
        let &[a, b] = self.mesh.edges.get(edge as usize)?;
        Some((place(a)? - place(b)?).norm())
    }
}

/// What a mesh shows that was not generated here.
fn doubts(source: &MeshSource, mesh: &Mesh, topology: &Topology) -> Vec<Warning> {
    if !matches!(source, MeshSource::File(_) | MeshSource::Explicit(_)) || mesh.triangles.is_empty() {
        return Vec::new();
    }
    let Look { gaps, others } = look(mesh, topology, &[]);
    let extent = Bounds::of(&mesh.nodes).extent();
    let code = if extent > 1.0 { WarningCode::LargeExtent } else { WarningCode::SmallExtent };
    // Lists of a case have no "scale".
    let size = units(extent).filter(|_| matches!(source, MeshSource::File(_))).map(|text| Warning::new(code, text));
    gaps.warning().into_iter().chain(others).chain(size).collect()
}

/// Checks the mesh section and makes or reads the mesh, unless `known` came from the same section.
pub(super) fn geometry(
    at: &Pointer,
    source: &MeshSource,
    base: &Path,
    known: Option<Arc<Geometry>>,
    faults: &mut Faults<'_>,
) -> Option<Arc<Geometry>> {
    if let Some(known) = known.filter(|known| known.source == *source) {
        tell_notes(at, &known, faults);
        return Some(known);
    }
    let before = faults.count();
    let listed = at.key("explicit").key("nodes");
    // Without the nodes, springs and triangles cannot be checked.
    if matches!(source, MeshSource::Explicit(_)) && !faults.readable(&listed) {
        return None;
    }
    source.check(&mut |below, value, allowed, hint| {
        faults.add_value(&at.below(below), value, allowed, Some(with_unit(source, hint)));
    });
    if faults.count() > before || !faults.readable(at) {
        return None;
    }
    match timed(Phase::Mesh, || source.build_with_notes(base)) {
        Ok(imported) => {
            let geometry = timed(Phase::Topology, || Geometry::new(source, imported));
            tell_notes(at, &geometry, faults);
            // Lines whose length no node shows make no mesh large.
            let unseen = |(key, _): &(&str, f64)| [REEFING, INNER].contains(key);
            if let Some((key, length)) = in_millimetres(source).filter(unseen) {
                faults.warn(WarningCode::LargeExtent, format!("{}: {}", at.key("parachute"), question(key, length)));
            }
            Some(Arc::new(geometry))
        }
        Err(error) => {
            refuse(at, source, error, faults);
            None
        }
    }
}

fn tell_notes(at: &Pointer, geometry: &Geometry, faults: &mut Faults<'_>) {
    for note in &geometry.notes {
        faults.warn(WarningCode::MeshFile, format!("{}: {note}", at.key("file")));
    }
    geometry.doubts.iter().for_each(|doubt| faults.warn(doubt.code, format!("{at}: {}", doubt.text)));
}

/// Adds the fault of a mesh that cannot be made, at the key that requests it.
fn refuse(at: &Pointer, source: &MeshSource, error: MeshError, faults: &mut Faults<'_>) {
    let key = match source {
        MeshSource::Annulus(_) => "annulus",
        MeshSource::Disc(_) => "disc",
        MeshSource::Rectangle(_) => "rectangle",
        MeshSource::Chain(_) => "chain",
        MeshSource::Parachute(_) => "parachute",
        MeshSource::File(_) => "file",
        MeshSource::Explicit(_) => "explicit",
    };
    match error {
        MeshError::Parameter { pointer, value, allowed, hint } => {
            faults.add_value(&at.below(&pointer), value, allowed, Some(with_unit(source, hint)));
        }
        MeshError::Sew(error) => faults.add_hint(&at.key("sew"), "pieces that can be sewn", error.to_string()),
        error @ MeshError::File { .. } => {
            faults.add_hint(&at.key(key), "a mesh file that can be read", error.to_string());
        }
        error => faults.add_hint(&at.key(key), "a mesh that can be made and used", error.to_string()),
    }
}

/// [m] Length of a part of a parachute above which millimetres are likely.
const LONG: f64 = 300.0;

/// The first length of a parachute that is probably in millimetres.
fn in_millimetres(source: &MeshSource) -> Option<(&'static str, f64)> {
    let MeshSource::Parachute(p) = source else { return None };
    let d0 = p.nominal_diameter.or(p.constructed_diameter)?;
    let lengths = [
        ("nominal_diameter", p.nominal_diameter, LONG),
        ("constructed_diameter", p.constructed_diameter, LONG),
        ("vent_diameter", p.vent_diameter, d0),
        (REEFING, p.reefing.map(|r| r.diameter), 2.0 * d0),
        ("lines.length", p.lines.as_ref().and_then(|l| l.length), LONG),
        (INNER, p.inner_lines.as_ref().and_then(|lines| lines.length), LONG),
        ("riser.length", p.riser.as_ref().and_then(|r| r.length), LONG),
    ];
    lengths.into_iter().find_map(|(key, length, most)| Some((key, length.filter(|l| *l > most)?)))
}

const REEFING: &str = "reefing.diameter";
const INNER: &str = "inner_lines.length";

fn question(key: &str, length: f64) -> String {
    format!("is {key} in millimetres? {} mm are {} m", figures(length, 6), figures(length / 1e3, 6))
}

/// Advice about the mesh, or about the unit of a parachute's lengths where one is probably in millimetres.
fn with_unit(source: &MeshSource, hint: String) -> String {
    in_millimetres(source).map_or(hint, |(key, length)| question(key, length))
}

/// The properties of triangles that a section needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum TriangleUse {
    /// their areas
    Areas,
    /// their normals too: neighbours must turn the same way
    Normals,
}

/// Adds a fault unless there are triangles as `user` (a section, in words) needs them. Degenerate triangles were
/// refused with the mesh; orientation matters only where normals are used.
pub(super) fn triangles(
    at: &Pointer,
    user: &str,
    geometry: &Geometry,
    needs: TriangleUse,
    faults: &mut Faults<'_>,
) -> bool {
    if geometry.mesh.triangles.is_empty() {
        faults.add_value(
            at,
            "a mesh without triangles",
            format!("{user} needs triangles"),
            Some("give the mesh triangles, or leave this out".to_owned()),
        );
        return false;
    }
    if needs == TriangleUse::Areas {
        return true;
    }
    match geometry.topology.check_orientation(&geometry.mesh) {
        Ok(()) => true,
        Err(error) => {
            faults.add_value(
                at,
                "triangles that turn opposite ways",
                format!("{user} needs triangles that all turn the same way, with at most two at an edge"),
                Some(error.to_string()),
            );
            false
        }
    }
}
