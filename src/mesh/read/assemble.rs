//! Makes a mesh of the points and cells of a file: places and joins the nodes, cuts the faces, lists the edges.

use super::Imported;
use super::cells::Cells;
use super::merge::joined;
use super::once::{EdgeList, edges, faces_once};
use super::polygon::{Cutter, Pieces};
use crate::check::flat;
use crate::file::{Diagonals, MeshFile};
use crate::format_number::first_few;
use crate::{Group, Groups, Mesh, MeshError, orient};
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// Name of the group of the second diagonals of quads.
const DIAGONALS: &str = "diagonals";

impl Cells {
    /// Makes the mesh of points that are placed.
    ///
    /// # Errors
    /// Why there is none, as the end of a sentence that begins with the file's name.
    pub(super) fn into_mesh(mut self, wanted: &MeshFile) -> Result<Imported, String> {
        let mut notes = Notes::default();
        let [unfilled, filled] = self.fill_outlines(wanted.edge, self.apart(wanted).unwrap_or(0.0))?;
        notes.found.extend(unfilled);
        notes.asked.extend(filled);
        if self.lines.is_empty() && self.faces().len() == 0 {
            return Err(["holds no lines and no triangles".to_owned()]
                .into_iter()
                .chain(self.notes)
                .collect::<Vec<_>>()
                .join("; "));
        }
        self.check_members()?;
        self.clean_names(&mut notes.found);
        if self.points.len() >= u32::MAX as usize || self.faces().len() >= u32::MAX as usize / 3 {
            return Err(format!("has {} nodes and {} faces, too many", self.points.len(), self.faces().len()));
        }
        let Renumbered { number, kept } = self.renumber(wanted, &mut notes)?;
        let nodes = match kept.len() == self.points.len() {
            true => std::mem::take(&mut self.points),
            false => kept.iter().map(|point| self.points[*point as usize]).collect(),
        };
        let mut pieces = self.cut(&nodes, &number, wanted, &mut notes)?;
        let faces = faces_once(&mut pieces, self.repeats_faces, &mut notes);
        let lines = self
            .lines
            .iter()
            .map(|l| l.map(|point| number[point as usize]))
            .chain(std::mem::take(&mut pieces.diagonals));
        let EdgeList { edges, of_line, seams } =
            edges(lines, &self.seam, &faces.triangles, self.repeats_faces, &mut notes);
        let mut groups = Groups::new();
        if of_line.len() > self.lines.len() {
            let diagonals = of_line[self.lines.len()..].iter().flatten().copied();
            groups.insert(DIAGONALS.to_owned(), Group::of_edges(diagonals));
        }
        let names = [&self.point_groups, &self.cell_groups];
        add_members(&mut groups, names[0], self.numbers.points.iter().copied(), |group, point| {
            group.nodes.extend(number.get(point as usize).filter(|node| **node != NONE));
        });
        for (name, points) in &self.named_points {
            let points = points.iter().filter_map(|point| number.get(*point as usize));
            groups.entry(name.clone()).or_default().nodes.extend(points.filter(|node| **node != NONE));
        }
        add_members(&mut groups, names[1], self.numbers.lines.iter().copied(), |group, line| {
            group.edges.extend(of_line.get(line as usize).copied().flatten());
        });
        let number_of = |face: &u32| self.numbers.faces.get(*face as usize).copied().unwrap_or(0);
        add_members(&mut groups, names[1], pieces.of_face.iter().map(number_of), |group, piece| {
            group.triangles.push(faces.of_piece(piece));
        });
        for group in groups.values_mut() {
            for list in [&mut group.nodes, &mut group.edges, &mut group.triangles] {
                list.sort_unstable();
                list.dedup();
            }
        }
        groups.retain(|_, group| *group != Group::default());
        let displacement = kept.iter().filter_map(|point| self.displacement.get(*point as usize).copied()).collect();
        notes.found.extend(self.remarks.iter().map(|(what, count)| format!("{count} {what}")));
        notes.found.append(&mut self.notes);
        let triangles = faces.triangles;
        let mut mesh = Mesh { nodes, edges, triangles, seams, groups, displacement, ..Mesh::default() };
        if mesh.edges.is_empty() {
            return Err("holds no lines and no faces with an area".into());
        }
        let dropped = drop_loose(&mut mesh);
        if dropped > 0 {
            notes
                .found
                .push(format!("{dropped} nodes that only such faces use were dropped; the others keep their order"));
        }
        if wanted.orient {
            let (turned, twisted) = orient::turn_alike(&mut mesh);
            notes.asked.extend(turned);
            notes.found.extend(twisted);
        }
        // Edges and triangles were listed once, and the shapes of triangles were looked at.
        mesh.check_numbers().map_err(|error| error.to_string())?;
        if pieces.overflow || !of_line.is_empty() {
            mesh.check_shapes().map_err(|error| error.to_string())?;
        }
        Ok(Imported { mesh, notes: notes.found, repairs: notes.asked })
    }

    /// [m] Distance within which points are one, if any are joined.
    fn apart(&self, wanted: &MeshFile) -> Option<f64> {
        let resolution = self.resolution.map(|share| share * extent(&self.points));
        wanted.merge.into_iter().chain(resolution).reduce(f64::max)
    }

    /// Joins points, drops the unused ones and renumbers the rest.
    fn renumber(&self, wanted: &MeshFile, notes: &mut Notes) -> Result<Renumbered, String> {
        let mut used = vec![false; self.points.len()];
        self.used_points().for_each(|point| used[point as usize] = true);
        let distance = self.apart(wanted);
        let mut number = vec![NONE; self.points.len()];
        let mut kept = Vec::new();
        let same = distance.map(|distance| joined(&self.points, distance));
        // A used point may be joined to an earlier one that is not used itself.
        let of = |point: usize| same.as_ref().map_or(point, |same| same[point] as usize);
        for point in (0..used.len()).filter(|point| used[*point]) {
            number[of(point)] = 0;
        }
        for (slot, point) in number.iter_mut().zip(0..).filter(|(slot, _)| **slot == 0) {
            *slot = kept.len() as u32;
            kept.push(point);
        }
        for point in (0..used.len()).filter(|point| used[*point]) {
            number[point] = number[of(point)];
        }
        let merged = (0..used.len()).filter(|point| used[*point] && of(*point) != *point).count();
        let unused = used.len() - kept.len() - merged;
        if unused > 0 {
            notes
                .found
                .push(format!("{unused} nodes that no line or face uses were dropped; the others keep their order"));
        }
        if let Some(distance) = distance.filter(|_| merged > 0) {
            let list = if wanted.merge.is_some() { &mut notes.asked } else { &mut notes.found };
            list.push(format!("{merged} nodes were joined to others at most {distance:e} m away"));
        }
        match kept.iter().position(|point| !self.points[*point as usize].iter().all(|x| x.is_finite())) {
            Some(node) => Err(MeshError::NotFinite { node }.to_string()),
            None => Ok(Renumbered { number, kept }),
        }
    }

    /// Cuts the faces into triangles of nodes.
    fn cut(
        &mut self,
        nodes: &[[f64; 3]],
        number: &[u32],
        wanted: &MeshFile,
        notes: &mut Notes,
    ) -> Result<FacePieces, String> {
        let diagonals = wanted.diagonals;
        let mut pieces = FacePieces::default();
        let (mut cutter, mut corners, mut places) = (Cutter::new(), Vec::new(), Vec::new());
        let (mut quads, mut polygons, mut collapsed, mut crossed) = (0, 0, Vec::new(), Vec::new());
        pieces.triangles.reserve(self.faces().len());
        pieces.of_face.reserve(self.faces().len());
        for (face, points) in self.faces().enumerate() {
            if let &[a, b, c] = points {
                let triangle = [a, b, c].map(|point| number[point as usize]);
                if triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0] {
                    let made = pieces.triangles.len();
                    pieces.triangles.push(triangle);
                    pieces.of_face.push(face as u32);
                    pieces.drop_flat(made, nodes, face, &mut collapsed);
                    pieces.of_face.truncate(pieces.triangles.len());
                    continue;
                }
            }
            corners.clear();
            corners.extend(points.iter().map(|point| number[*point as usize]));
            // Programs write a triangle as a quad with a corner twice.
            corners.dedup();
            if corners.len() > 1 && corners.first() == corners.last() {
                corners.pop();
            }
            if corners.len() < 3 {
                collapsed.push(face as u32);
                continue;
            }
            places.clear();
            places.extend(corners.iter().map(|node| Vector3::from(nodes[*node as usize])));
            let Ok(cut) = cutter.cut(&places) else {
                if wanted.strict || self.faces().len() == 1 {
                    let listed = first_few(points);
                    return Err(format!(
                        "face {face} crosses itself: its corners, nodes {listed}, are not in order around it"
                    ));
                }
                crossed.push(face as u32);
                continue;
            };
            let at = |t: [usize; 3]| t.map(|i| corners[i]);
            let made = pieces.triangles.len();
            match cut {
                Pieces::Whole => pieces.triangles.push(at([0, 1, 2])),
                Pieces::Quad { first, both } => {
                    quads += 1;
                    let halves = if first { [[0, 1, 2], [0, 2, 3]] } else { [[0, 1, 3], [1, 2, 3]] };
                    pieces.triangles.extend(halves.map(at));
                    if both && diagonals == Diagonals::Both {
                        pieces.diagonals.push([corners[1], corners[3]]);
                    }
                }
                Pieces::Polygon(triangles) => {
                    polygons += 1;
                    pieces.triangles.extend(triangles.into_iter().map(at));
                }
            }
            pieces.drop_flat(made, nodes, face, &mut collapsed);
            pieces.of_face.resize(pieces.triangles.len(), face as u32);
        }
        let second = pieces.diagonals.len();
        let along = match diagonals {
            Diagonals::One => "along one diagonal: that from the first corner, if it lies inside".to_owned(),
            Diagonals::Both => {
                format!("and {second} of them got the other diagonal as an edge too (group {DIAGONALS})")
            }
        };
        if quads > 0 {
            let list = if diagonals == Diagonals::Both { &mut notes.asked } else { &mut notes.found };
            list.push(format!("{quads} quads were cut into two triangles each, {along}"));
        }
        if polygons > 0 {
            notes.found.push(format!("{polygons} faces of more than four corners were cut into triangles"));
        }
        if !crossed.is_empty() {
            notes.found.push(format!(
                "{} faces that cross themselves were left out: {}; their corners are not in order around them \
                 (\"strict\" or --strict refuses them)",
                crossed.len(),
                first_few(&crossed)
            ));
        }
        if !collapsed.is_empty() {
            collapsed.dedup();
            let (count, listed) = (collapsed.len(), first_few(&collapsed));
            notes.found.push(format!("{count} faces without area, or parts of them, were dropped: {listed}"));
        }
        Ok(pieces)
    }
}

/// Drops the nodes without an edge; returns how many.
fn drop_loose(mesh: &mut Mesh) -> usize {
    let mut number = vec![NONE; mesh.nodes.len()];
    mesh.edges.as_flattened().iter().for_each(|node| number[*node as usize] = 0);
    let kept = number.iter_mut().filter(|number| **number == 0).zip(0..).map(|(slot, new)| *slot = new).count();
    let dropped = mesh.nodes.len() - kept;
    if dropped > 0 {
        let stays = |node: usize| number[node] != NONE;
        let keep = |list: &mut Vec<[f64; 3]>| {
            let mut node = 0..;
            list.retain(|_| node.next().is_some_and(stays));
        };
        keep(&mut mesh.nodes);
        keep(&mut mesh.displacement);
        let corners = mesh.edges.as_flattened_mut().iter_mut().chain(mesh.triangles.as_flattened_mut());
        corners.for_each(|node| *node = number[*node as usize]);
        for group in mesh.groups.values_mut() {
            group.nodes.retain(|node| stays(*node as usize));
            group.nodes.iter_mut().for_each(|node| *node = number[*node as usize]);
        }
        mesh.groups.retain(|_, group| *group != Group::default());
    }
    dropped
}

/// [m] Largest extent along an axis.
pub(crate) fn extent(points: &[[f64; 3]]) -> f64 {
    let along = |k: usize| {
        let range = points
            .iter()
            .map(|p| p[k])
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)]);
        range[1] - range[0]
    };
    (0..3).map(along).fold(0.0, f64::max)
}

/// Sentences about what became of the file.
#[derive(Default)]
pub(super) struct Notes {
    /// what was left out or changed
    pub found: Vec<String>,
    /// what was done because it was asked for
    pub asked: Vec<String>,
}

/// Number of a point that is no node.
pub(super) const NONE: u32 = u32::MAX;

/// How points become nodes.
struct Renumbered {
    /// the node of each point, or `NONE`
    number: Vec<u32>,
    /// the point of each node
    kept: Vec<u32>,
}

/// Faces cut into triangles.
#[derive(Default)]
pub(super) struct FacePieces {
    pub triangles: Vec<[u32; 3]>,
    /// the face of each triangle
    pub of_face: Vec<u32>,
    /// the second diagonals of quads
    diagonals: Vec<[u32; 2]>,
    /// whether the area of a triangle is not finite
    overflow: bool,
}

impl FacePieces {
    /// Drops what has no area of the triangles from `first` on.
    fn drop_flat(&mut self, first: usize, nodes: &[[f64; 3]], face: usize, collapsed: &mut Vec<u32>) {
        let mut kept = first;
        for at in first..self.triangles.len() {
            let corners = self.triangles[at];
            // One whose area overflows is refused later.
            let flat = flat(corners.map(|node| Vector3::from(nodes[node as usize])));
            if flat.is_some_and(|[area, _]| area.is_finite()) {
                collapsed.push(face as u32);
            } else {
                self.overflow |= flat.is_some();
                self.triangles[kept] = corners;
                kept += 1;
            }
        }
        self.triangles.truncate(kept);
    }
}

/// Calls `add` for each member, by its index, and each group that its number stands for.
fn add_members(
    groups: &mut Groups,
    names: &BTreeMap<i64, Vec<String>>,
    numbers: impl Iterator<Item = i64>,
    add: impl Fn(&mut Group, u32),
) {
    let mut members: BTreeMap<i64, Vec<u32>> = names.keys().map(|number| (*number, Vec::new())).collect();
    if members.is_empty() {
        return;
    }
    for (number, member) in numbers.zip(0..) {
        if let Some(list) = members.get_mut(&number) {
            list.push(member);
        }
    }
    for (number, members) in members.into_iter().filter(|(_, members)| !members.is_empty()) {
        for name in names.get(&number).into_iter().flatten() {
            let group = groups.entry(name.clone()).or_default();
            members.iter().for_each(|member| add(group, *member));
        }
    }
}
