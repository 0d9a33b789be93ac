//! The pack: a parachute before its deployment, lines in bights and the canopy folded along the axis.
//!
//! ```text
//! height between two rings:    dz = c l,   c = H/W     H length of the pack, W that of all steps l, lines included
//! radius of a ring:            r' = R or R/2 in turns, but no further from r than every edge between the rings allows:
//!                              |r' b - r a|^2 + dz^2 <= l^2,   a and b the places of its ends at the radius 1
//! ```
//! The rings are rows of the canopy from the apex, then the nodes of the lines. A ring has one height, and heights fall
//! strictly from ring to ring, so that the cloth between two rings stays between their planes and passes through no
//! other. Edges along a ring are shorter than at rest, as the radius is below that of the pattern. What is left of the
//! lengths is slack: folds below the size of the mesh.
//! Inner lines and a centre line run straight up the middle.

use super::assembly::{Assembly, straighten};
use super::stretched::rise;
use super::{CanopyType, LineParameters, PackedStart, ParachuteParameters, outline, reefed_radius};
use crate::format_number::figures;
use crate::least_distance::least_distance;
use crate::{Mesh, MeshError, topology};
use nalgebra::{Vector2, Vector3};
use std::collections::BTreeSet;

/// [-] length of the pack over that of canopy and lines, if not given
const LENGTH: f64 = 0.05;
/// [-] largest such length
const MOST_LENGTH: f64 = 0.5;
/// [-] radius of the pack over D0, if not given
const RADIUS: f64 = 0.03;
/// [-] radius to which folds reach inwards over that to which they reach outwards
const INNER: f64 = 0.5;

/// [-] radius of the vent over that to which folds reach inwards: the canopy shows an area along its axis
const VENT: f64 = 0.5;

/// Nodes at one height.
#[derive(Clone, Debug)]
struct Ring {
    /// nodes with their places at the radius 1
    nodes: Vec<(u32, Vector2<f64>)>,
    /// [m] largest radius without stretching it
    widest: f64,
}

/// An edge to the next ring: the places of its ends at the radius 1, and its length [m].
#[derive(Clone, Copy, Debug)]
struct Tie {
    from: Vector2<f64>,
    to: Vector2<f64>,
    length: f64,
}

/// From a ring to the next one.
#[derive(Clone, Debug)]
struct Step {
    ties: Vec<Tie>,
    /// [m] the shortest of their lengths
    length: f64,
}

impl Step {
    fn new(ties: Vec<Tie>) -> Self {
        let length = ties.iter().map(|tie| tie.length).fold(f64::INFINITY, f64::min);
        Step { ties, length }
    }

    /// [m] The radii of the next ring, `height` lower than a ring of this radius, at which no edge is stretched: from
    /// the first to the second; none if the first is larger.
    fn reach(&self, radius: f64, height: f64) -> [f64; 2] {
        self.ties.iter().fold([0.0, f64::INFINITY], |[low, high], tie| {
            let across = rise(tie.length, height);
            let (along, square) = (radius * tie.from.dot(&tie.to), tie.to.norm_squared());
            let left = across * across - radius * radius * tie.from.norm_squared();
            if square == 0.0 {
                return if left >= 0.0 { [low, high] } else { [f64::INFINITY, 0.0] };
            }
            let root = (along * along + square * left).sqrt();
            if root.is_nan() {
                return [f64::INFINITY, 0.0];
            }
            [low.max((along - root) / square), high.min((along + root) / square)]
        })
    }
}

/// [m] Radii of the rings, from the first one on; `None` where an edge would be stretched. `share` is the height of a
/// step over its length; rings turn at the radii `inner` and `outer`.
fn radii(rings: &[Ring], steps: &[Step], share: f64, [inner, outer]: [f64; 2]) -> Option<Vec<f64>> {
    let mut radius = rings.first()?.widest.min(VENT * inner);
    let mut outwards = true;
    let mut all = vec![radius];
    for (ring, step) in rings.iter().skip(1).zip(steps) {
        let [low, high] = step.reach(radius, share * step.length);
        let high = high.min(ring.widest);
        // Not a number is no radius either.
        if low.is_nan() || high.is_nan() || low > high {
            return None;
        }
        let wanted = if outwards { outer } else { inner }.min(ring.widest);
        radius = wanted.clamp(low, high);
        outwards ^= radius == wanted;
        all.push(radius);
    }
    Some(all)
}

impl Assembly {
    /// Displaces canopy and lines to the pack; the confluence stays where it is.
    ///
    /// # Errors
    /// A pack that is too long or too wide.
    pub(super) fn pack(&mut self, p: &ParachuteParameters) -> Result<(), MeshError> {
        let (Some(lines), Some(packed)) = (p.lines(), p.start.packed()) else { return Ok(()) };
        let Some(confluence) = self.lines.first().and_then(|line| line.last()).map(|&node| self.at(node)) else {
            return Ok(());
        };
        let mut rings = self.rings_of_canopy(p);
        let mut steps = self.steps_of_canopy(&rings);
        let canopy: f64 = steps.iter().map(|step| step.length).sum();
        let whole = canopy + lines.length;
        let (length, [inner, outer]) = self.sizes_of_pack(p, packed, whole)?;
        let share = length / whole;
        self.add_rings_of_lines(lines, share, &mut rings, &mut steps);
        let radii = radii(&rings, &steps, share, [inner, outer]).ok_or_else(|| MeshError::Parameter {
            pointer: "/parachute/start".to_owned(),
            value: format!("a pack {length:.6} m long, folded between the radii {inner:.6} and {outer:.6} m"),
            allowed: "a pack in which neither cloth nor lines are stretched".to_owned(),
            hint: "make it shorter or narrower".to_owned(),
        })?;
        let top = confluence.z + length;
        self.check_inner_lines_of_pack(p, [radii.first().copied().unwrap_or_default(), length])?;
        let mut moved = self.nodes.clone();
        let mut height = top;
        // The last ring is the confluence, which stays.
        for (i, (ring, radius)) in rings.iter().zip(&radii).enumerate().take(rings.len() - 1) {
            for &(node, place) in &ring.nodes {
                moved[node as usize] = Vector3::new(radius * place.x, radius * place.y, height);
            }
            height -= share * steps[i].length;
        }
        self.inner_lines.iter().for_each(|line| straighten(line, &mut moved));
        if packed.bag {
            self.add_bag(&rings);
            moved.push(Vector3::new(0.0, 0.0, top + inner));
        }
        self.take(&moved);
        Ok(())
    }

    /// [m] Length of the pack, and the radii between which it is folded; `whole` is the length of canopy and lines.
    fn sizes_of_pack(
        &self,
        p: &ParachuteParameters,
        packed: PackedStart,
        whole: f64,
    ) -> Result<(f64, [f64; 2]), MeshError> {
        let refuse = |key: &str, value: f64, most: f64, why: &str, hint: &str| MeshError::Parameter {
            pointer: format!("/parachute/start/packed/{key}"),
            value: value.to_string(),
            allowed: format!("at most {most:.6}, {why}"),
            hint: hint.to_owned(),
        };
        let length = packed.length.unwrap_or(LENGTH * whole);
        if length > MOST_LENGTH * whole {
            let hint = "fold it more; the start \"stretched\" is the whole length";
            return Err(refuse("length", length, MOST_LENGTH * whole, "half of canopy and lines", hint));
        }
        let own = self.own_radius(p);
        let radius = packed.radius.unwrap_or((RADIUS * p.d0()).min(own));
        if radius > own {
            return Err(refuse("radius", radius, own, "the radius of the skirt as it is cut", "take a smaller one"));
        }
        Ok((length, [INNER * radius, radius]))
    }

    /// # Errors
    /// Inner lines or a centre line that do not reach the vent or apex of the pack, at this radius and height [m].
    fn check_inner_lines_of_pack(&self, p: &ParachuteParameters, [radius, height]: [f64; 2]) -> Result<(), MeshError> {
        let Some(inner) = p.inner_length().filter(|inner| *inner < radius.hypot(height)) else { return Ok(()) };
        Err(MeshError::Parameter {
            pointer: "/parachute/start".to_owned(),
            value: format!("a pack {height:.6} m long"),
            allowed: format!("at most {:.6} m: inner lines of {inner:.6} m lead to its end", rise(inner, radius)),
            hint: "give start.packed.length".to_owned(),
        })
    }

    /// The rings of the canopy, from its apex or vent to the skirt.
    fn rings_of_canopy(&self, p: &ParachuteParameters) -> Vec<Ring> {
        let own = self.own_radius(p);
        let round = outline::sides(p.kind).is_none();
        let of_row = |row: &Vec<u32>| {
            let nearest = self.distances_of(row).fold(f64::INFINITY, f64::min);
            let widest = if round { self.at(row[0]).xy().norm() } else { nearest };
            let place = |&node: &u32| {
                let place = self.at(node).xy();
                let from_axis = if round { widest } else { place.norm() };
                (node, if from_axis > 0.0 { place / from_axis } else { Vector2::zeros() })
            };
            Ring { nodes: row.iter().map(place).collect(), widest }
        };
        let mut rings: Vec<Ring> = match p.kind {
            CanopyType::Cruciform => {
                let place = |&(node, azimuth): &(u32, f64)| (node, Vector2::new(azimuth.cos(), azimuth.sin()));
                let nodes = |nodes: &[(u32, f64)]| nodes.iter().map(place).collect();
                let of_square = |s: &super::assembly::Square| (nodes(&s.nodes), s.own_radius.min(own));
                self.squares.iter().map(of_square).map(|(nodes, widest)| Ring { nodes, widest }).collect()
            }
            _ => self.rows.iter().map(of_row).collect(),
        };
        if let (Some(skirt), Some(reefing)) = (rings.last_mut(), p.reefing) {
            skirt.widest = skirt.widest.min(reefed_radius(reefing, p.gores));
        }
        rings
    }

    /// The edges between these rings.
    fn steps_of_canopy(&self, rings: &[Ring]) -> Vec<Step> {
        let mut of_node = vec![None; self.nodes.len()];
        for (i, ring) in rings.iter().enumerate() {
            ring.nodes.iter().for_each(|&(node, place)| of_node[node as usize] = Some((i, place)));
        }
        let mut ties = vec![Vec::new(); rings.len().saturating_sub(1)];
        let edges = topology::unique_edges(&self.triangles);
        for &[a, b] in edges.iter().chain(self.edges.iter().map(|(_, pair)| pair)) {
            let (Some((i, from)), Some((j, to))) = (of_node[a as usize], of_node[b as usize]) else { continue };
            let length = (self.at(a) - self.at(b)).norm();
            match (i + 1 == j, j + 1 == i) {
                (true, _) => ties[i].push(Tie { from, to, length }),
                (_, true) => ties[j].push(Tie { from: to, to: from, length }),
                _ => {}
            }
        }
        ties.into_iter().map(Step::new).collect()
    }

    /// Adds the nodes of the lines, from the skirt to the confluence: none so far out that the rest does not reach it.
    fn add_rings_of_lines(&self, lines: LineParameters, share: f64, rings: &mut Vec<Ring>, steps: &mut Vec<Step>) {
        let skirt = rings.last().map(|ring| ring.nodes.clone()).unwrap_or_default();
        let of_corner = |corner: u32| skirt.iter().find(|(node, _)| *node == corner).map(|(_, place)| *place);
        let corners: Vec<Vector2<f64>> = self.corners.iter().filter_map(|&corner| of_corner(corner)).collect();
        let length = lines.length / lines.segments as f64;
        let reach = rise(length, share * length);
        for i in 1..=lines.segments {
            let left = lines.segments - i;
            // They meet in the confluence.
            let place = |corner: Vector2<f64>| if left == 0 { Vector2::zeros() } else { corner };
            let nodes = self.lines.iter().zip(&corners).map(|(line, &corner)| (line[i], place(corner))).collect();
            steps.push(Step::new(corners.iter().map(|&from| Tie { from, to: place(from), length }).collect()));
            rings.push(Ring { nodes, widest: left as f64 * reach });
        }
    }

    /// Adds the bag, what ties lines and canopy to it, from the confluence to the apex, and its bridle.
    fn add_bag(&mut self, rings: &[Ring]) {
        let bag = self.add_node(self.apex + Vector3::z());
        self.node_groups.insert("bag", vec![bag]);
        let radials = self.edges.iter().filter(|(name, _)| *name == "radials").flat_map(|(_, pair)| *pair);
        let seams: BTreeSet<u32> = radials.chain(self.lines.iter().flatten().copied()).collect();
        for (i, ring) in rings.iter().enumerate().rev().skip(1) {
            let mut nodes: Vec<u32> = ring.nodes.iter().map(|(node, _)| *node).filter(|n| seams.contains(n)).collect();
            if nodes.is_empty() {
                nodes.extend(ring.nodes.iter().map(|(node, _)| *node));
            }
            let name = if i == 0 { "bridle" } else { "stows" };
            self.edges.extend(nodes.into_iter().map(|node| (name, [bag, node])));
        }
    }
}

/// [m] The place of a node at the start.
fn place(mesh: &Mesh, node: u32) -> Vector3<f64> {
    mesh.point(node) + mesh.displacement.get(node as usize).map_or(Vector3::zeros(), |u| Vector3::from(*u))
}

/// [m] Lengths of what ties a pack to its bag, which are those at the start.
pub(super) fn lengths_of_bag(mesh: &Mesh) -> Vec<(u32, f64)> {
    let edges = ["stows", "bridle"].into_iter().filter_map(|name| mesh.groups.get(name)).flat_map(|group| &group.edges);
    let ends = edges.filter_map(|&edge| Some((edge, *mesh.edges.get(edge as usize)?)));
    ends.map(|(edge, [a, b])| (edge, (place(mesh, a) - place(mesh, b)).norm())).collect()
}

/// The size of a pack, of the first one in a cluster, and how near its parts are to each other.
pub(super) fn describe(mesh: &Mesh) -> Option<String> {
    let group = |name: &str| mesh.groups.get(&format!("{name}-1")).or_else(|| mesh.groups.get(name));
    let middle = |name: &str| -> Option<Vector3<f64>> {
        let nodes = group(name).map(|group| &group.nodes).filter(|nodes| !nodes.is_empty())?;
        Some(nodes.iter().map(|&node| place(mesh, node)).sum::<Vector3<f64>>() / nodes.len() as f64)
    };
    let (bottom, top) = (middle("confluence")?, middle("apex").or_else(|| middle("vent"))?);
    let (length, axis) = ((top - bottom).norm(), (top - bottom).normalize());
    let nodes = ["canopy", "lines"].into_iter().filter_map(group).flat_map(|group| group.select_nodes(mesh));
    let from_axis = nodes.map(|node| (place(mesh, node) - bottom).cross(&axis).norm());
    let radius = from_axis.fold(0.0, f64::max);
    let apart = match least_distance_of_parts(mesh) {
        Some(apart) => format!("; parts that share no node are at least {} m apart", figures(apart, 3)),
        None => String::new(),
    };
    Some(format!("{length:.6} m long, radius {radius:.6} m{apart}"))
}

/// [m] The least distance of cloth and lines that share no node. Vent lines meet in the middle of the vent, and a
/// reefing line lies on the skirt.
fn least_distance_of_parts(mesh: &Mesh) -> Option<f64> {
    let group = |name: &str| mesh.groups.get(name).map(|group| group.edges.as_slice()).unwrap_or_default();
    let of_cloth: BTreeSet<u32> = group("cloth").iter().copied().collect();
    let lines = ["radials", "verticals", "lines", "inner-lines", "centre-line"].into_iter().flat_map(group);
    let edges: BTreeSet<u32> = lines.copied().filter(|edge| !of_cloth.contains(edge)).collect();
    let edges: Vec<[u32; 2]> = edges.into_iter().map(|edge| mesh.edges[edge as usize]).collect();
    let places: Vec<[f64; 3]> = (0..mesh.nodes.len() as u32).map(|node| place(mesh, node).into()).collect();
    least_distance(&places, &mesh.triangles, &edges)
}
