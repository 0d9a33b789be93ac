//! The parts of a parachute put together: nodes, triangles, named edges.

use super::outline;
use super::profile::Profile;
use super::rings::{End, Gores, Tape};
use super::taylor::{Meridian, SkirtHold};
use super::{CanopyType, LEAST_HEIGHT, LineParameters, ParachuteParameters, reefed_radius};
use crate::{Group, Groups, Mesh, MeshError, Strands, topology};
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashMap};

/// [-] part by which a row of the inflated shape may be wider than the pattern, for patterns of many small steps
const WIDER: f64 = 1e-3;

/// A parachute in the making.
#[derive(Clone, Debug, Default)]
pub(super) struct Assembly {
    pub nodes: Vec<Vector3<f64>>,
    pub triangles: Vec<[u32; 3]>,
    /// edges by the name of their group; those of triangles too
    pub edges: Vec<(&'static str, [u32; 2])>,
    /// [-] how many tapes or lines an edge of a group stands for, if not one
    strands: Vec<(&'static str, [u32; 2], f64)>,
    pub node_groups: BTreeMap<&'static str, Vec<u32>>,
    /// nodes at which lines begin, counter-clockwise
    pub corners: Vec<u32>,
    /// nodes at which inner lines begin, counter-clockwise; the apex of a centre line; empty if there is neither
    pub vent_corners: Vec<u32>,
    /// rows of gores, from the vent or apex to the skirt
    pub rows: Vec<Vec<u32>>,
    /// columns of the nodes of each row, counted from the first radial
    pub columns: Vec<Vec<usize>>,
    /// rings of a cross, from its centre to the ends of its arms
    pub squares: Vec<Square>,
    /// [m] width of the four ends of a cross
    pub mouth: f64,
    /// [m] apex of the pattern, where there may be a vent
    pub apex: Vector3<f64>,
    /// [m] distance along a radial from the apex of the pattern to the first row
    tip: f64,
    /// nodes of each line from the corner to the confluence, ends included
    pub lines: Vec<Vec<u32>>,
    /// the same of the inner lines and the centre line
    pub inner_lines: Vec<Vec<u32>>,
    displacement: Vec<[f64; 3]>,
}

/// A ring of nodes of a cross: a square around its centre, or a row of all four arms.
#[derive(Clone, Debug)]
pub(super) struct Square {
    /// [m] distance from the centre along an arm
    pub arc: f64,
    /// [m] largest radius of a ring of these nodes without stretching the cloth
    pub own_radius: f64,
    /// nodes, each with its azimuth in such a ring [rad]
    pub nodes: Vec<(u32, f64)>,
}

impl Assembly {
    pub(super) fn add_node(&mut self, place: Vector3<f64>) -> u32 {
        self.nodes.push(place);
        self.nodes.len() as u32 - 1
    }

    pub(super) fn at(&self, node: u32) -> Vector3<f64> {
        self.nodes[node as usize]
    }

    /// Adds a canopy of gores.
    pub(super) fn add_gores(&mut self, p: &ParachuteParameters, profile: &Profile) {
        self.apex = Vector3::z() * profile.apex_height;
        let gores = Gores::of(p, profile);
        let rings = gores.rings();
        for ring in &rings {
            let nodes = ring.columns.iter().map(|column| self.add_node(gores.place(ring, *column))).collect();
            self.rows.push(nodes);
        }
        let (tapes, at_vent) = gores.tapes(&rings);
        for (i, tapes) in tapes.iter().enumerate() {
            for &Tape { ends: [inner, outer], strands } in tapes {
                self.add_strands("radials", [self.rows[i][inner], self.rows[i + 1][outer]], strands);
            }
            if !profile.rows[i + 1].after_gap {
                let node = |(outer, at): End| self.rows[i + usize::from(outer)][at];
                let triangles = gores.triangles(i, &rings[i], &rings[i + 1]);
                self.triangles.extend(triangles.into_iter().map(|corners| corners.map(node)));
            }
        }
        let [first, last] = [0, self.rows.len() - 1];
        let outer = self.rows[last].clone();
        self.add_ring("skirt", last);
        self.corners = outer.iter().copied().step_by(p.gore_segments).collect();
        self.node_groups.insert("skirt", outer);
        let inner = self.rows[first].clone();
        if inner.len() == 1 {
            self.vent_corners = p.centre_line.iter().flat_map(|_| inner.clone()).collect();
            self.node_groups.insert("apex", inner);
        } else {
            self.tip = self.at(inner[0]).xy().norm().hypot(profile.apex_height - rings[first].height);
            self.add_ring("vent", first);
            let corners: Vec<(u32, f64)> = inner.iter().copied().zip(at_vent).filter(|(_, n)| *n > 0.0).collect();
            self.vent_corners = corners.iter().map(|(node, _)| *node).collect();
            if p.has_vent_lines() {
                let opposite = corners.iter().zip(corners.iter().skip(corners.len() / 2));
                opposite.for_each(|(&(a, strands), &(b, _))| self.add_strands("vent-lines", [a, b], strands));
            }
            self.node_groups.insert("vent", inner);
        }
        for i in (1..profile.rows.len()).filter(|&i| profile.rows[i].after_gap) {
            self.add_ring("rims", i - 1);
            self.add_ring("rims", i);
        }
        self.columns = rings.into_iter().map(|ring| ring.columns).collect();
    }

    /// Adds an edge that stands for so many tapes or lines.
    fn add_strands(&mut self, name: &'static str, ends: [u32; 2], strands: f64) {
        self.edges.push((name, ends));
        if strands != 1.0 {
            self.strands.push((name, ends, strands));
        }
    }

    /// Names the edges along a row.
    fn add_ring(&mut self, name: &'static str, row: usize) {
        let row = &self.rows[row];
        let next = row.iter().skip(1).chain(row.first());
        self.edges.extend(row.iter().zip(next).map(|(&a, &b)| (name, [a, b])));
    }

    /// Adds a straight line between two nodes; returns all its nodes.
    fn add_line(&mut self, name: &'static str, [from, to]: [u32; 2], segments: usize) -> Vec<u32> {
        let (start, end) = (self.at(from), self.at(to));
        let part = |i: usize| i as f64 / segments as f64;
        let inner: Vec<u32> = (1..segments).map(|i| self.add_node(start.lerp(&end, part(i)))).collect();
        let nodes = [&[from], &inner[..], &[to]].concat();
        self.edges.extend(nodes.windows(2).map(|pair| (name, [pair[0], pair[1]])));
        nodes
    }

    /// Adds lines, confluence and riser; the payload is a point at the end.
    ///
    /// # Errors
    /// Lines that do not reach the axis.
    pub(super) fn add_rig(&mut self, p: &ParachuteParameters, lines: LineParameters) -> Result<(), MeshError> {
        let from_axis = |node: &u32| self.at(*node).xy().norm();
        let radius = self.corners.iter().map(from_axis).fold(0.0, f64::max);
        let height = (lines.length * lines.length - radius * radius).sqrt();
        // The root of a negative number is not a number.
        if height.is_nan() || height < LEAST_HEIGHT * lines.length {
            return Err(MeshError::Parameter {
                pointer: "/parachute/lines/length".to_owned(),
                value: lines.length.to_string(),
                allowed: format!(
                    "above {:.6}: the skirt's corners are {radius:.6} m from the axis, where the lines meet",
                    radius / (1.0 - LEAST_HEIGHT * LEAST_HEIGHT).sqrt()
                ),
                hint: "take longer lines; usual ones have 0.8 to 1.0 nominal diameters".to_owned(),
            });
        }
        let confluence = self.add_node(Vector3::new(0.0, 0.0, -height));
        for corner in self.corners.clone() {
            let nodes = self.add_line("lines", [corner, confluence], lines.segments);
            self.lines.push(nodes);
        }
        let inner = p.inner_lines.as_ref().map(|inner| ("inner-lines", inner.segments));
        if let Some((name, segments)) = inner.or(p.centre().map(|line| ("centre-line", line.segments))) {
            for corner in self.vent_corners.clone() {
                let nodes = self.add_line(name, [corner, confluence], segments);
                self.inner_lines.push(nodes);
            }
        }
        let mut end = confluence;
        if let Some(riser) = p.riser() {
            end = self.add_node(self.at(confluence) - Vector3::z() * riser.length);
            self.add_line("riser", [confluence, end], riser.segments);
        }
        self.node_groups.insert("confluence", vec![confluence]);
        self.node_groups.insert("payload", vec![end]);
        Ok(())
    }

    /// Adds the reefing line from corner to corner.
    pub(super) fn add_reefing(&mut self) {
        let next = self.corners.iter().skip(1).chain(self.corners.first());
        let ring: Vec<_> = self.corners.iter().zip(next).map(|(&a, &b)| ("reefing", [a, b])).collect();
        self.edges.extend(ring);
    }

    /// Displaces canopy and lines to Taylor's shape; the confluence stays where it is.
    ///
    /// # Errors
    /// A pattern that is too narrow for the shape.
    pub(super) fn inflate(&mut self, p: &ParachuteParameters) -> Result<(), MeshError> {
        let Some(lines) = p.lines() else { return Ok(()) };
        let refuse = |allowed: String| MeshError::Parameter {
            pointer: "/parachute/start".to_owned(),
            value: "inflated".to_owned(),
            allowed,
            hint: "start \"flat\": the constructed shape of such a canopy is near its inflated one".to_owned(),
        };
        if matches!(p.kind, CanopyType::Annular | CanopyType::Toroidal) {
            return Err(refuse("a canopy that is closed at its apex or by vent lines".to_owned()));
        }
        if outline::sides(p.kind).is_some() {
            return Err(refuse("a round canopy".to_owned()));
        }
        if p.inner_lines.is_some() {
            return Err(refuse("a canopy without inner lines, which hold its vent down".to_owned()));
        }
        if p.centre_line.is_some() {
            return Err(refuse("a canopy without a centre line, which holds its apex down".to_owned()));
        }
        let arcs = self.arcs();
        let Some(&at) = arcs.last() else {
            return Err(refuse("a canopy of gores".to_owned()));
        };
        let none = || refuse("a canopy and lines that have this shape".to_owned());
        let mut meridian = Meridian::of(at, SkirtHold::Lines(lines.length)).ok_or_else(none)?;
        if let Some(ring) = p.reefing.map(|reefing| reefed_radius(reefing, p.gores))
            && ring < meridian.at(at)[0]
        {
            meridian = Meridian::of(at, SkirtHold::Ring(ring)).ok_or_else(none)?;
        }
        let Some(confluence) = self.lines.first().and_then(|line| line.last()).map(|node| self.at(*node)) else {
            return Ok(());
        };
        let skirt = meridian.at(at)[0];
        let skirt_height = confluence.z + (lines.length * lines.length - skirt * skirt).sqrt();
        let mut moved = self.nodes.clone();
        for (row, arc) in self.rows.iter().zip(arcs) {
            let [radius, height] = meridian.at(arc);
            let pattern = self.at(row[0]).xy().norm();
            if radius > pattern * (1.0 + WIDER) {
                let excess = 100.0 * (radius / pattern - 1.0);
                return Err(refuse(format!(
                    "a pattern that is wide enough: Taylor's shape stretches the gores by {excess:.1} % at {arc:.3} m from the apex"
                )));
            }
            let scale = if pattern > 0.0 { radius / pattern } else { 0.0 };
            for &node in row {
                let place = self.at(node);
                moved[node as usize] = Vector3::new(scale * place.x, scale * place.y, skirt_height + height);
            }
        }
        self.displace(moved);
        Ok(())
    }

    /// [m] Arc lengths of the rows along the first radial, from the apex of the pattern.
    pub(super) fn arcs(&self) -> Vec<f64> {
        let corners: Vec<Vector3<f64>> = self.rows.iter().map(|row| self.at(row[0])).collect();
        let before = corners.first().into_iter().chain(&corners);
        let mut at = self.tip;
        let steps = corners.iter().zip(before).map(|(corner, before)| (corner - before).norm());
        steps
            .map(|step| {
                at += step;
                at
            })
            .collect()
    }

    /// Takes the places of the nodes at the start; lines are straight between their ends.
    pub(super) fn displace(&mut self, mut moved: Vec<Vector3<f64>>) {
        self.lines.iter().chain(&self.inner_lines).for_each(|line| straighten(line, &mut moved));
        self.take(&moved);
    }

    /// Takes the places of the nodes at the start.
    pub(super) fn take(&mut self, moved: &[Vector3<f64>]) {
        self.displacement = moved.iter().zip(&self.nodes).map(|(to, from)| (to - from).into()).collect();
    }

    /// The mesh: edges of the cloth first, sorted by their nodes, then the others.
    pub(super) fn into_mesh(self) -> Mesh {
        let mut edges = topology::unique_edges(&self.triangles);
        let cloth = edges.len() as u32;
        let key = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
        let mut known: HashMap<[u32; 2], u32> = edges.iter().copied().zip(0..).collect();
        let mut members: BTreeMap<&str, Vec<u32>> = BTreeMap::new();
        for (name, pair) in self.edges {
            let edge = *known.entry(key(pair)).or_insert_with(|| {
                edges.push(pair);
                edges.len() as u32 - 1
            });
            members.entry(name).or_default().push(edge);
        }
        let mut strands = Strands::new();
        for (name, pair, count) in self.strands {
            let edge = known.get(&key(pair)).copied();
            strands.entry(name.to_owned()).or_default().extend(edge.map(|edge| (edge, count)));
        }
        let mut groups: Groups =
            members.into_iter().map(|(name, edges)| (name.to_owned(), Group::of_edges(edges))).collect();
        for (name, nodes) in self.node_groups {
            groups.entry(name.to_owned()).or_default().nodes = Group::of_nodes(nodes).nodes;
        }
        groups.insert("cloth".to_owned(), Group::of_edges(0..cloth));
        let triangles = (0..self.triangles.len() as u32).collect();
        groups.insert("canopy".to_owned(), Group { triangles, ..Group::default() });
        let nodes = self.nodes.into_iter().map(Into::into).collect();
        let Assembly { triangles, displacement, rows, .. } = self;
        Mesh { nodes, edges, triangles, groups, displacement, rows, strands, ..Mesh::default() }
    }
}

/// Places the nodes of a line evenly between its ends.
pub(super) fn straighten(line: &[u32], moved: &mut [Vector3<f64>]) {
    let [Some(&from), Some(&to)] = [line.first(), line.last()] else { return };
    let (start, end) = (moved[from as usize], moved[to as usize]);
    for (i, &node) in line.iter().enumerate() {
        moved[node as usize] = start.lerp(&end, i as f64 / (line.len() - 1) as f64);
    }
}
