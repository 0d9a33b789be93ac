//! Points, lines and faces, which all formats have, and the mesh made of them.

use super::Imported;
use crate::mesh::{Mesh, topology};
use std::collections::HashMap;

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
        let triangles: Vec<[u32; 3]> =
            self.faces.iter().map(|f| [number(&f[0]), number(&f[1]), number(&f[2])]).collect();
        let lines = self.lines.iter().map(|l| [number(&l[0]), number(&l[1])]);
        let (edges, seams, repeated) = edges(lines, &self.seam, &triangles);
        for (count, what) in [
            (dropped, "nodes that no line or triangle uses were dropped; the others keep their order"),
            (repeated, "repeated lines were dropped"),
            (self.quads, "quads were cut into two triangles each, along the diagonal from their first corner"),
            (self.ignored, "cells that are neither lines nor faces were ignored"),
        ] {
            if count > 0 {
                notes.push(format!("{count} {what}"));
            }
        }
        Ok(Imported { mesh: Mesh { nodes, edges, triangles, seams }, notes })
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

/// Lines in file order, each once, then the triangles' other edges; the seams among them; how many lines were repeated.
fn edges(
    lines: impl Iterator<Item = [u32; 2]>,
    seam: &[bool],
    triangles: &[[u32; 3]],
) -> (Vec<[u32; 2]>, Vec<u32>, usize) {
    let key = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let mut edges: Vec<[u32; 2]> = Vec::new();
    let mut known: HashMap<[u32; 2], u32> = HashMap::new();
    let mut seams = Vec::new();
    let mut repeated = 0;
    for (line, &seam) in lines.zip(seam) {
        let new = edges.len() as u32;
        let edge = *known.entry(key(line)).or_insert(new);
        if edge == new {
            edges.push(line);
        } else {
            repeated += 1;
        }
        if seam {
            seams.push(edge);
        }
    }
    edges.extend(topology::unique_edges(triangles).into_iter().filter(|edge| !known.contains_key(edge)));
    seams.sort_unstable();
    seams.dedup();
    (edges, seams, repeated)
}
