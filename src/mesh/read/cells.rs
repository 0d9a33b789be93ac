//! Points, lines and faces, which all formats have, and the mesh made of them.

use super::Imported;
use crate::mesh::{Group, Groups, Mesh, topology};
use std::collections::{BTreeMap, HashMap};

/// Points and cells of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Cells {
    pub points: Vec<[f64; 3]>,
    lines: Vec<[u64; 2]>,
    /// for each line, whether it is on a seam
    seam: Vec<bool>,
    faces: Vec<[u64; 3]>,
    quads: usize,
    /// cells without meaning here, such as single points
    pub ignored: usize,
    /// number of the groups of each point, line and face; a list may end early: 0 = in no group
    numbers: Numbers,
    /// for each such number, the names of its groups; of lines and faces, and of points
    pub cell_groups: BTreeMap<i64, Vec<String>>,
    /// number of each set of groups that [`Cells::name_cells`] was given
    numbers_of: HashMap<Vec<String>, i64>,
    pub point_groups: BTreeMap<i64, Vec<String>>,
    /// points in groups by the name of the group, beside those with numbers
    pub named_points: BTreeMap<String, Vec<u64>>,
    /// whether a face that is listed again means that it is in several groups
    pub repeats_faces: bool,
    /// [m] displacement of each point at the start; empty = none
    pub displacement: Vec<[f64; 3]>,
}

/// Numbers of groups.
#[derive(Clone, Debug, Default)]
struct Numbers {
    points: Vec<i64>,
    lines: Vec<i64>,
    faces: Vec<i64>,
}

impl Cells {
    /// Adds a line through two or more nodes.
    pub fn add_line(&mut self, nodes: &[u64], seam: bool) {
        for pair in nodes.windows(2) {
            self.lines.push([pair[0], pair[1]]);
            self.seam.push(seam);
        }
    }

    /// Adds a triangle or a quad, which is cut in two.
    pub fn add_face(&mut self, nodes: &[u64]) -> Result<(), String> {
        match *nodes {
            [a, b, c] => self.faces.push([a, b, c]),
            [a, b, c, d] => {
                self.faces.extend([[a, b, c], [a, c, d]]);
                self.quads += 1;
            }
            _ => {
                let face = self.faces.len();
                return Err(format!("face {face} has {} corners; split it into triangles or quads", nodes.len()));
            }
        }
        Ok(())
    }

    /// Gives the lines and faces that were added since the last call a number of groups.
    pub fn number_cells(&mut self, number: i64) {
        self.numbers.lines.resize(self.lines.len(), number);
        self.numbers.faces.resize(self.faces.len(), number);
    }

    /// Puts the lines and faces that were added since the last call into groups.
    pub fn name_cells(&mut self, names: &[String]) {
        if names.is_empty() {
            return self.number_cells(0);
        }
        let next = self.numbers_of.len() as i64 + 1;
        let number = *self.numbers_of.entry(names.to_vec()).or_insert(next);
        if number == next {
            self.cell_groups.insert(number, names.to_vec());
        }
        self.number_cells(number);
    }

    /// Puts a point into groups.
    pub fn name_point(&mut self, names: &[String], point: u64) {
        names.iter().for_each(|name| self.named_points.entry(name.clone()).or_default().push(point));
    }

    /// Gives the points that were added since the last call their numbers of groups; missing ones are 0.
    pub fn number_points(&mut self, numbers: impl IntoIterator<Item = i64>) {
        self.numbers.points.extend(numbers);
        self.numbers.points.resize(self.points.len(), 0);
    }

    /// Names the groups of lines and faces by their numbers, where the file has no names.
    pub fn name_cell_groups(&mut self) {
        let numbers = self.numbers.lines.iter().chain(&self.numbers.faces);
        self.cell_groups = numbers.filter(|n| **n != 0).map(|n| (*n, vec![n.to_string()])).collect();
    }

    /// Renumbers the nodes, drops unused ones and lists the edges.
    pub fn into_mesh(self) -> Result<Imported, String> {
        let mut notes = Vec::new();
        if self.lines.is_empty() && self.faces.is_empty() {
            return Err("holds no lines and no triangles".into());
        }
        if self.points.len() >= u32::MAX as usize || self.faces.len() >= u32::MAX as usize / 3 {
            return Err(format!("has {} nodes and {} triangles, too many", self.points.len(), self.faces.len()));
        }
        let renumbered = self.renumber()?;
        let number = |node: &u64| renumbered[*node as usize];
        let kept = |point: (usize, &[f64; 3])| (renumbered[point.0] != u32::MAX).then_some(*point.1);
        let nodes: Vec<[f64; 3]> = self.points.iter().enumerate().filter_map(kept).collect();
        let dropped = self.points.len() - nodes.len();
        let faces = self.faces.iter().map(|f| [number(&f[0]), number(&f[1]), number(&f[2])]);
        let FaceList { triangles, of_face } = faces_once(faces, self.repeats_faces);
        let lines = self.lines.iter().map(|l| [number(&l[0]), number(&l[1])]);
        let EdgeList { edges, of_line, seams, repeated } = edges(lines, &self.seam, &triangles);
        let mut groups = Groups::new();
        add_members(&mut groups, &self.point_groups, &self.numbers.points, |group, point| {
            group.nodes.extend(renumbered.get(point).filter(|node| **node != u32::MAX));
        });
        for (name, points) in &self.named_points {
            let points = points.iter().filter_map(|point| renumbered.get(*point as usize));
            groups.entry(name.clone()).or_default().nodes.extend(points.filter(|node| **node != u32::MAX));
        }
        add_members(&mut groups, &self.cell_groups, &self.numbers.lines, |group, line| {
            group.edges.extend(of_line.get(line));
        });
        add_members(&mut groups, &self.cell_groups, &self.numbers.faces, |group, face| {
            group.triangles.extend(of_face.get(face));
        });
        for group in groups.values_mut() {
            for list in [&mut group.nodes, &mut group.edges, &mut group.triangles] {
                list.sort_unstable();
                list.dedup();
            }
        }
        groups.retain(|_, group| *group != Group::default());
        let moved = self
            .displacement
            .iter()
            .enumerate()
            .filter_map(|(i, u)| renumbered.get(i).filter(|node| **node != u32::MAX).map(|_| *u));
        let displacement: Vec<[f64; 3]> = moved.collect();
        for (count, what) in [
            (dropped, "nodes that no line or triangle uses were dropped; the others keep their order"),
            (if self.repeats_faces { 0 } else { repeated }, "repeated lines were dropped"),
            (self.quads, "quads were cut into two triangles each, along the diagonal from their first corner"),
            (self.ignored, "cells that are neither lines nor faces were ignored"),
        ] {
            if count > 0 {
                notes.push(format!("{count} {what}"));
            }
        }
        Ok(Imported { mesh: Mesh { nodes, edges, triangles, seams, groups, displacement }, notes })
    }

    /// New number of every used node, `u32::MAX` for the unused.
    fn renumber(&self) -> Result<Vec<u32>, String> {
        let mut renumbered = vec![u32::MAX; self.points.len()];
        for &node in self.lines.iter().flatten().chain(self.faces.iter().flatten()) {
            let known = usize::try_from(node).ok().and_then(|n| renumbered.get_mut(n));
            *known.ok_or_else(|| format!("a cell names node {node}, but there are {} nodes", self.points.len()))? = 0;
        }
        let used = renumbered.iter_mut().filter(|n| **n == 0);
        used.zip(0..).for_each(|(slot, new)| *slot = new);
        Ok(renumbered)
    }
}

/// Calls `add` for each member, by its index, and each group that its number stands for.
fn add_members(
    groups: &mut Groups,
    names: &BTreeMap<i64, Vec<String>>,
    numbers: &[i64],
    add: impl Fn(&mut Group, usize),
) {
    for (member, number) in numbers.iter().enumerate() {
        for name in names.get(number).into_iter().flatten() {
            add(groups.entry(name.clone()).or_default(), member);
        }
    }
}

/// The triangles of a mesh.
struct FaceList {
    triangles: Vec<[u32; 3]>,
    /// the triangle of each face
    of_face: Vec<u32>,
}

/// The triangles in file order; those that are listed again are the same one, if they may be.
fn faces_once(faces: impl Iterator<Item = [u32; 3]>, may_repeat: bool) -> FaceList {
    if !may_repeat {
        let triangles: Vec<_> = faces.collect();
        let of_face = (0..triangles.len() as u32).collect();
        return FaceList { triangles, of_face };
    }
    let mut list = FaceList { triangles: Vec::new(), of_face: Vec::new() };
    let mut known: HashMap<[u32; 3], u32> = HashMap::new();
    for face in faces {
        let mut key = face;
        key.sort_unstable();
        let new = list.triangles.len() as u32;
        let triangle = *known.entry(key).or_insert(new);
        list.of_face.push(triangle);
        if triangle == new {
            list.triangles.push(face);
        }
    }
    list
}

/// The edges of a mesh.
struct EdgeList {
    /// lines in file order, each once, then the triangles' other edges
    edges: Vec<[u32; 2]>,
    /// the edge of each line
    of_line: Vec<u32>,
    /// edges on seams, ascending
    seams: Vec<u32>,
    /// how many lines were repeated
    repeated: usize,
}

fn edges(lines: impl Iterator<Item = [u32; 2]>, seam: &[bool], triangles: &[[u32; 3]]) -> EdgeList {
    let key = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut list = EdgeList { edges: Vec::new(), of_line: Vec::new(), seams: Vec::new(), repeated: 0 };
    let mut known: HashMap<[u32; 2], u32> = HashMap::new();
    for (line, &seam) in lines.zip(seam) {
        let new = list.edges.len() as u32;
        let edge = *known.entry(key(line)).or_insert(new);
        list.of_line.push(edge);
        if edge == new {
            list.edges.push(line);
        } else {
            list.repeated += 1;
        }
        if seam {
            list.seams.push(edge);
        }
    }
    list.edges.extend(topology::unique_edges(triangles).into_iter().filter(|edge| !known.contains_key(edge)));
    list.seams.sort_unstable();
    list.seams.dedup();
    list
}
