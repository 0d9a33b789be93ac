//! A ring of pieces around the z axis, as the gores of a canopy or the panels of a tube.
//!
//! At the part t of its seams a piece i has the width w_i between them, and the middle C_i. The seams stand at the
//! corners of a polygon with these sides, at the radius rho = (sum of w_i)/(sum of 2 sin(phi_i/2)), where the angle
//! phi_i of a piece is its share of all widths. The polygons lie above each other so that the middles are as far apart
//! as in the drawing, dz^2 = ds^2 - da^2 with the apothem a. Equal gores that mirror themselves are bent and not
//! stretched.

use super::place::{Pieces, Placed};
use super::{SewError, Stitch};
use crate::Mesh;
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// [-] Difference of two parts of a seam that are one.
const SAME: f64 = 1e-9;

/// [-] Slope below which a ring is level: less is the rounding of a drawing.
const LEVEL: f64 = 1e-4;

/// The ends of the seams of a ring.
pub(super) struct Ring {
    /// one node of the upper end of each seam, in their order around the axis
    pub top: Vec<u32>,
    /// the same of the lower end
    pub bottom: Vec<u32>,
}

/// A side of a piece from the top down.
#[derive(Clone)]
struct Edge {
    nodes: Vec<u32>,
    part: Vec<f64>,
    /// whether it goes with the triangles
    forward: bool,
}

impl Edge {
    fn turn(&mut self) {
        self.nodes.reverse();
        self.part.reverse();
        self.part.iter_mut().for_each(|t| *t = 1.0 - *t);
        self.forward = !self.forward;
    }

    /// [m] Its place in the drawing at a part of its length.
    fn at(&self, mesh: &Mesh, t: f64) -> Vector3<f64> {
        let i = self.part.partition_point(|part| *part <= t).clamp(1, self.part.len() - 1);
        let [a, b] = [i - 1, i].map(|i| mesh.point(self.nodes[i]));
        a + (t - self.part[i - 1]) / (self.part[i] - self.part[i - 1]) * (b - a)
    }
}

/// A piece with its two sides.
struct Panel {
    piece: u32,
    /// the one that comes first around the axis, and the other one
    sides: [Edge; 2],
}

/// Stands the pieces around the axis, the narrow end up, the lower end at z = 0 and the first seam above +x.
pub(super) fn stand(mesh: &Mesh, pieces: &Pieces, part: &[&Stitch], placed: &mut Placed) -> Result<(), SewError> {
    let mut panels = around(part)?;
    let width = |t: f64| -> f64 {
        panels.iter().map(|panel| (panel.sides[1].at(mesh, t) - panel.sides[0].at(mesh, t)).norm()).sum()
    };
    if width(0.0) > width(1.0) {
        panels.iter_mut().flat_map(|panel| &mut panel.sides).for_each(Edge::turn);
    }
    let shape = Shape::of(mesh, &panels);
    for (i, panel) in panels.iter().enumerate() {
        panel.place(mesh, pieces, (i, &shape), &mut placed.at)?;
    }
    let members: Vec<u32> = panels.iter().flat_map(|panel| pieces.of_piece(panel.piece)).copied().collect();
    let mut within = vec![false; mesh.nodes.len()];
    members.iter().for_each(|node| within[*node as usize] = true);
    if shape.faces_inwards(mesh, &within, &placed.at) {
        members.iter().for_each(|node| placed.turned[*node as usize] = true);
    }
    let end =
        |node: fn(&Edge) -> Option<&u32>| panels.iter().filter_map(|panel| node(&panel.sides[0])).copied().collect();
    placed.ring = Some(Ring { top: end(|side| side.nodes.first()), bottom: end(|side| side.nodes.last()) });
    Ok(())
}

/// The pieces in their order around the axis, their sides from one end to the other.
fn around(part: &[&Stitch]) -> Result<Vec<Panel>, SewError> {
    let none = || SewError::NoPlace { pieces: part.len(), links: part.len() };
    let edge = |stitch: &Stitch, i: usize| {
        let side = &stitch.sides[i];
        Edge { nodes: side.nodes.clone(), part: side.part.clone(), forward: side.forward }
    };
    let mut left: Vec<&Stitch> = part.to_vec();
    let (mut panels, first): (Vec<Panel>, &Stitch) = (Vec::new(), left.remove(0));
    // The first piece comes after the first seam, and is the one that has its second side.
    let (mut piece, mut begin) = (first.sides[1].piece, edge(first, 1));
    while let Some(at) = left.iter().position(|stitch| stitch.sides.iter().any(|side| side.piece == piece)) {
        let stitch = left.remove(at);
        let own = usize::from(stitch.sides[1].piece == piece);
        let (mut end, mut next) = (edge(stitch, own), edge(stitch, 1 - own));
        // Around a piece one of its sides goes up and the other one down.
        if end.forward == begin.forward {
            end.turn();
            next.turn();
        }
        panels.push(Panel { piece, sides: [begin, end] });
        (piece, begin) = (stitch.sides[1 - own].piece, next);
    }
    let mut end = edge(first, 0);
    let turned = end.forward == begin.forward;
    if turned {
        end.turn();
    }
    let closes = panels.first().is_some_and(|panel| panel.sides[0].nodes.first() == edge(first, 1).nodes.first());
    if !left.is_empty() || piece != first.sides[0].piece || !closes {
        return Err(none());
    }
    if turned {
        return Err(SewError::Twisted);
    }
    panels.push(Panel { piece, sides: [begin, end] });
    Ok(panels)
}

/// The polygons of a ring.
struct Shape {
    /// [-] parts of the seams at which they are
    parts: Vec<f64>,
    /// [m] radius of the corners
    radius: Vec<f64>,
    /// [m]
    height: Vec<f64>,
    /// [rad] azimuth of each seam, and of the first one again
    azimuth: Vec<f64>,
}

impl Shape {
    fn of(mesh: &Mesh, panels: &[Panel]) -> Self {
        let mut parts: Vec<f64> =
            panels.iter().flat_map(|panel| &panel.sides).flat_map(|side| &side.part).copied().collect();
        parts.sort_unstable_by(f64::total_cmp);
        parts.dedup_by(|a, b| *a - *b < SAME);
        let ends = |panel: &Panel, t: f64| [0, 1].map(|i| panel.sides[i].at(mesh, t));
        let width = |panel: &Panel, t: f64| {
            let [a, b] = ends(panel, t);
            (b - a).norm()
        };
        let widths: Vec<f64> = panels.iter().map(|panel| parts.iter().map(|t| width(panel, *t)).sum()).collect();
        let whole: f64 = widths.iter().sum();
        let angles: Vec<f64> = widths.iter().map(|w| TAU * w / whole).collect();
        let mut azimuth = vec![0.0];
        azimuth.extend(angles.iter().scan(0.0, |sum, angle| {
            *sum += angle;
            Some(*sum)
        }));
        let chords: f64 = angles.iter().map(|angle| 2.0 * (0.5 * angle).sin()).sum();
        let count = panels.len() as f64;
        let apothem = angles.iter().map(|angle| (0.5 * angle).cos()).sum::<f64>() / count;
        let radius: Vec<f64> =
            parts.iter().map(|t| panels.iter().map(|panel| width(panel, *t)).sum::<f64>() / chords).collect();
        let middle = |panel: &Panel, t: f64| {
            let [a, b] = ends(panel, t);
            0.5 * (a + b)
        };
        let mut height = vec![0.0];
        for i in 1..parts.len() {
            let step = |panel: &Panel| (middle(panel, parts[i]) - middle(panel, parts[i - 1])).norm();
            let along = panels.iter().map(step).sum::<f64>() / count;
            let outwards = apothem * (radius[i] - radius[i - 1]);
            let down = (along * along - outwards * outwards).max(0.0).sqrt();
            let down = if down < LEVEL * along { 0.0 } else { down };
            height.push(height[i - 1] - down);
        }
        let lowest = height[height.len() - 1];
        height.iter_mut().for_each(|z| *z -= lowest);
        Shape { parts, radius, height, azimuth }
    }

    /// [m] The place on a seam; outside of it on its continuation.
    fn on_seam(&self, seam: usize, t: f64) -> Vector3<f64> {
        let i = self.parts.partition_point(|part| *part <= t).clamp(1, self.parts.len() - 1);
        let share = (t - self.parts[i - 1]) / (self.parts[i] - self.parts[i - 1]);
        let of = |list: &[f64]| list[i - 1] + share * (list[i] - list[i - 1]);
        let (sin, cos) = self.azimuth[seam].sin_cos();
        let radius = of(&self.radius);
        // The last seam is the first one, to the last digit.
        if seam + 1 == self.azimuth.len() {
            return Vector3::new(radius, 0.0, of(&self.height));
        }
        Vector3::new(radius * cos, radius * sin, of(&self.height))
    }

    /// Whether the triangles face the inside more than the outside, seen from below.
    fn faces_inwards(&self, mesh: &Mesh, within: &[bool], at: &[Vector3<f64>]) -> bool {
        let below = Vector3::z() * -self.radius.iter().copied().fold(0.0, f64::max);
        let triangles = mesh.triangles.iter().filter(|t| within[t[0] as usize]);
        let outwards = triangles.map(|t| {
            let [a, b, c] = t.map(|node| at[node as usize] - below);
            a.cross(&b).dot(&c)
        });
        outwards.sum::<f64>() < 0.0
    }
}

impl Panel {
    /// Places its nodes: those of its sides on the seams, the others between them at the same height over its length.
    fn place(
        &self,
        mesh: &Mesh,
        pieces: &Pieces,
        (i, shape): (usize, &Shape),
        at: &mut [Vector3<f64>],
    ) -> Result<(), SewError> {
        let rows: Vec<[Vector3<f64>; 2]> =
            shape.parts.iter().map(|t| [0, 1].map(|side| self.sides[side].at(mesh, *t))).collect();
        let middle = |row: &[Vector3<f64>; 2]| 0.5 * (row[0] + row[1]);
        let (from, to) = (middle(&rows[0]), middle(&rows[rows.len() - 1]));
        let folded = SewError::Folded { piece: i + 1 };
        let along = (to - from).try_normalize(0.0).ok_or(folded.clone())?;
        let places: Vec<f64> = rows.iter().map(|row| along.dot(&(middle(row) - from))).collect();
        if places.windows(2).any(|pair| pair[0] >= pair[1]) {
            return Err(folded);
        }
        for &node in pieces.of_piece(self.piece) {
            let p = mesh.point(node);
            let u = along.dot(&(p - from));
            let k = places.partition_point(|place| *place <= u).clamp(1, places.len() - 1);
            let share = (u - places[k - 1]) / (places[k] - places[k - 1]);
            let t = shape.parts[k - 1] + share * (shape.parts[k] - shape.parts[k - 1]);
            let row = [0, 1].map(|side| rows[k - 1][side] + share * (rows[k][side] - rows[k - 1][side]));
            let across = row[1] - row[0];
            let q = (p - row[0]).dot(&across) / across.norm_squared();
            let q = if q.is_finite() { q } else { 0.5 };
            let ends = [i, i + 1].map(|seam| shape.on_seam(seam, t));
            at[node as usize] = ends[0] + q * (ends[1] - ends[0]);
        }
        for (side, edge) in self.sides.iter().enumerate() {
            for (&node, &t) in edge.nodes.iter().zip(&edge.part) {
                at[node as usize] = shape.on_seam(i + side, t);
            }
        }
        Ok(())
    }
}
