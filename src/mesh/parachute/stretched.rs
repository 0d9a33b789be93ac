//! The tube of line stretch: a canopy pulled out of its bag, before air has entered.
//!
//! ```text
//! radius at arc length s from the apex:    r = min(a, r0 (0.3 + 0.7 s/S))
//! height between two rows:                 dz = sqrt(ds^2 - dr^2),   so that the arc lengths are those of the pattern
//! ```
//! S is the whole arc, r0 the radius of the skirt, a the pattern's own radius, which is s for a flat canopy. The map is
//! a contraction: radii shrink and arcs stay, so that nothing is longer than at rest (but cloth in the middle of gores,
//! by at most (pi/n)^2/8, where a single row of a cylinder is higher than its radius), and cloth hangs in folds around
//! the axis. Inner lines that are shorter hold the vent down: the tube is turned inwards at the height where it just
//! reaches the vent's place.

use super::assembly::Assembly;
use super::{CanopyType, LineParameters, ParachuteParameters, outline, reefed_radius};
use crate::{MeshError, topology};
use nalgebra::Vector3;

/// [-] radius of the skirt over D0 at line stretch, if not given
const START_RADIUS: f64 = 0.025;
/// [-] radius of the tube at the apex over that at the skirt
const AT_APEX: f64 = 0.3;

/// A canopy as a tube.
#[derive(Clone, Debug)]
struct Tube {
    /// [m] place across the axis, and depth below the apex along the folded cloth, by node of the canopy
    places: Vec<Vector3<f64>>,
}

impl Tube {
    /// Distance from the axis and depth of a node [m].
    fn at(&self, node: u32) -> [f64; 2] {
        let place = self.places[node as usize];
        [place.xy().norm(), place.z]
    }
}

/// [m] Radius of the tube at an arc length `s` of `whole`, below that of the pattern there.
fn radius(pattern: f64, r0: f64, s: f64, whole: f64) -> f64 {
    pattern.min(r0 * (AT_APEX + (1.0 - AT_APEX) * s / whole))
}

/// [m] Height that is left of a length between two nodes which are `across` apart; 0 where there is none.
pub(super) fn rise(length: f64, across: f64) -> f64 {
    (length * length - across * across).max(0.0).sqrt()
}

impl Assembly {
    /// Displaces canopy and lines to the tube of line stretch; the confluence stays where it is.
    ///
    /// # Errors
    /// A start radius above the pattern's own.
    pub(super) fn stretch(&mut self, p: &ParachuteParameters) -> Result<(), MeshError> {
        let Some(lines) = p.lines() else { return Ok(()) };
        let own = self.own_radius(p);
        if let Some(radius) = p.start.stretched_radius().filter(|radius| *radius > own) {
            return Err(MeshError::Parameter {
                pointer: "/parachute/start/stretched/radius".to_owned(),
                value: radius.to_string(),
                allowed: format!("at most {own:.6}, the radius of the skirt as it is cut"),
                hint: format!("take a smaller one; at line stretch it is about {:.3}", START_RADIUS * p.d0()),
            });
        }
        let given = p.start.stretched_radius().map(|radius| radius / p.d0());
        let wanted = given.or(p.start_radius).unwrap_or(START_RADIUS);
        if given.is_none() && wanted * p.d0() > own {
            return Err(MeshError::Parameter {
                pointer: "/parachute/start_radius".to_owned(),
                value: wanted.to_string(),
                allowed: format!("at most {:.6}, the radius of the skirt as it is cut", own / p.d0()),
                hint: "take a smaller one; at line stretch it is about 0.025".to_owned(),
            });
        }
        let ring = p.reefing.map_or(f64::INFINITY, |reefing| reefed_radius(reefing, p.gores));
        let r0 = (wanted * p.d0()).min(ring);
        let tube = match p.kind {
            CanopyType::Cruciform => self.tube_of_squares(own, r0),
            _ => self.tube_of_rows(r0, outline::sides(p.kind).is_none()),
        };
        let heights = self.heights(p, lines, &tube);
        let mut moved = self.nodes.clone();
        for (node, place) in moved.iter_mut().zip(&tube.places) {
            *node = Vector3::new(place.x, place.y, heights(place.z));
        }
        self.displace(moved);
        Ok(())
    }

    /// [m] Largest distance of the skirt from the axis without stretching the cloth there.
    pub(super) fn own_radius(&self, p: &ParachuteParameters) -> f64 {
        match p.kind {
            // The ends of the arms are the mouth of a cross.
            CanopyType::Cruciform => self.mouth / std::f64::consts::TAU,
            // On a circle inside its sides no edge of the skirt is longer.
            _ if outline::sides(p.kind).is_some() => self.distances_of(&self.corners).fold(f64::INFINITY, f64::min),
            _ => self.distances_of(&self.corners).fold(0.0, f64::max),
        }
    }

    /// [m] Distances of nodes from the axis.
    pub(super) fn distances_of(&self, nodes: &[u32]) -> impl Iterator<Item = f64> {
        nodes.iter().map(|&node| self.at(node).xy().norm())
    }

    /// The tube of a canopy of gores. Each column of nodes keeps its own arc lengths, so that the middle of a gore,
    /// which is nearer to the apex than its seams, is higher than these. Rows that are not round become circles inside
    /// their sides, and the middle of a side is higher than its ends.
    fn tube_of_rows(&self, r0: f64, round: bool) -> Tube {
        let arcs = self.arcs();
        let whole = arcs.last().copied().unwrap_or_default();
        let mut places = vec![Vector3::zeros(); self.rows.iter().map(Vec::len).sum()];
        for (i, (row, &arc)) in self.rows.iter().zip(&arcs).enumerate() {
            let nearest = || self.distances_of(row).fold(f64::INFINITY, f64::min);
            let pattern = if round { self.at(row[0]).xy().norm() } else { nearest() };
            let r = radius(pattern, r0, arc, whole);
            let scale = if pattern > 0.0 { r / pattern } else { 0.0 };
            for (&node, &column) in row.iter().zip(&self.columns[i]) {
                let place = self.at(node).xy();
                let across = if round || pattern == 0.0 { scale * place } else { r * place.normalize() };
                let ends = i.checked_sub(1).map(|above| self.column_of(above, column)).unwrap_or_default();
                let mean = |at: &dyn Fn(u32) -> Vector3<f64>| -> Vector3<f64> {
                    ends.iter().map(|&(node, part)| part * at(node)).sum()
                };
                let (from, length) = match ends.len() {
                    0 => (Vector3::zeros(), (self.at(node) - self.apex).norm()),
                    _ => (mean(&|node| places[node as usize]), (self.at(node) - mean(&|node| self.at(node))).norm()),
                };
                if ends.len() > 1 && self.columns[i - 1].len() < self.corners.len() {
                    // A radial that ends here is as long as the others.
                    places[node as usize] = Vector3::new(across.x, across.y, places[row[0] as usize].z);
                    continue;
                }
                let depth = from.z + rise(length, (across - from.xy()).norm());
                places[node as usize] = Vector3::new(across.x, across.y, depth);
            }
        }
        Tube { places }
    }

    /// The nodes of a row in a column, or beside it, each with its share.
    fn column_of(&self, row: usize, column: usize) -> Vec<(u32, f64)> {
        let (nodes, columns) = (&self.rows[row], &self.columns[row]);
        let last = columns.partition_point(|at| *at <= column) - 1;
        if columns[last] == column || columns.len() == 1 {
            return vec![(nodes[last], 1.0)];
        }
        let all = self.columns.last().map_or(0, Vec::len);
        let end = columns.get(last + 1).copied().unwrap_or(all);
        let part = (column - columns[last]) as f64 / (end - columns[last]) as f64;
        vec![(nodes[last], 1.0 - part), (nodes[(last + 1) % nodes.len()], part)]
    }

    /// The tube of a cross: squares around its centre, then the rows of its arms, are the rings. Each ring has one
    /// height, as large as the edges to the ring before allow, so that all lines are equally long.
    fn tube_of_squares(&self, own: f64, r0: f64) -> Tube {
        let whole = self.squares.last().map_or(0.0, |ring| ring.arc);
        let nodes = self.squares.iter().map(|ring| ring.nodes.len()).sum();
        let mut places = vec![Vector3::zeros(); nodes];
        let mut ring_of = vec![0; nodes];
        for (i, ring) in self.squares.iter().enumerate() {
            let r = radius(ring.own_radius.min(own), r0, ring.arc, whole);
            for &(node, azimuth) in &ring.nodes {
                ring_of[node as usize] = i;
                places[node as usize] = r * Vector3::new(azimuth.cos(), azimuth.sin(), 0.0);
            }
        }
        let mut rises = vec![f64::INFINITY; self.squares.len()];
        for &[a, b] in &topology::unique_edges(&self.triangles) {
            let [from, to] = [a, b].map(|node| ring_of[node as usize]);
            let left = rise((self.at(a) - self.at(b)).norm(), (places[a as usize] - places[b as usize]).norm());
            if from != to {
                rises[from.max(to)] = left.min(rises[from.max(to)]);
            }
        }
        let mut depth = 0.0;
        for (ring, rise) in self.squares.iter().zip(rises) {
            // No edge leads to the innermost ring from one before.
            depth += if rise.is_finite() { rise } else { 0.0 };
            ring.nodes.iter().for_each(|&(node, _)| places[node as usize].z = depth);
        }
        Tube { places }
    }

    /// The height [m] of a node by its depth [m] in the tube: lines are taut, and inner lines too where they are short
    /// enough to draw the vent down.
    fn heights(&self, p: &ParachuteParameters, lines: LineParameters, tube: &Tube) -> impl Fn(f64) -> f64 + use<> {
        let mut corners = self.corners.iter().map(|&corner| tube.at(corner));
        let taut = match outline::sides(p.kind) {
            // The lines at the highest corners are taut first.
            Some(_) => corners.min_by(|a, b| a[1].total_cmp(&b[1])),
            None => corners.next(),
        };
        let [skirt, whole] = taut.unwrap_or_default();
        let confluence = self.lines.first().and_then(|line| line.last()).map_or(0.0, |&node| self.at(node).z);
        let mut above = rise(lines.length, skirt);
        let mut turn = f64::INFINITY;
        if let (Some(length), Some(&vent)) = (p.inner_length(), self.vent_corners.first()) {
            let [radius, depth] = tube.at(vent);
            let (cloth, held) = (whole - depth, rise(length, radius));
            above = above.min(held + cloth);
            let half = 0.5 * (held - above + cloth);
            if half < cloth {
                turn = half;
            }
        }
        move |depth| {
            let up = whole - depth;
            confluence + above + up.min(2.0 * turn - up)
        }
    }
}
