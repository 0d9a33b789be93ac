//! Canopies that the air fills: their skirt and apex by topology, their axis, and the pressure over the arc length.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::f64::consts::PI;

use nalgebra::Vector3;

use super::air::checked_coefficients;
use super::geometry::{Geometry, TriangleUse, triangles};
use super::numbers::{not_negative, positive, rising};
use super::{filling, select};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Aero, Canopy, Cavity, NodeSelection, OneOrSeveral, PressureCoefficient};
use crate::mesh::adjacency::row_starts;
use crate::mesh::topology::unique_edges;
use crate::mesh::{Mesh, Topology};
use crate::model::spec::{CanopySpec, CavitySpec, ClothSpec, NetworkSpec};

/// [-] Distance from the apex to the confluence, over the canopy's size, below which there is no axis.
const AXIS: f64 = 1e-3;
/// [-] Area that a canopy shows along its axis, over its whole area, below which the air has no direction to fill it.
const OPENING: f64 = 1e-3;

/// Checks and resolves a canopy.
pub(super) fn canopy(
    at: &Pointer,
    canopy: &Canopy,
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Option<CanopySpec> {
    let before = faults.count();
    let rows = pressure_rows(at, canopy, faults);
    let cavity = canopy.cavity.map(|given| cavity(&at.key("cavity"), given, faults));
    if let Some(factor) = canopy.apparent_mass {
        not_negative(&at.key("apparent_mass"), factor, faults);
    }
    let geometry = geometry?;
    if !triangles(at, "a canopy", geometry, TriangleUse::Areas, faults) {
        return None;
    }
    let triangles = select::triangles(&at.key("on"), &canopy.on, geometry, faults)?;
    let sheet = Sheet::new(at, geometry, &triangles, faults)?;
    let skirt = skirt(at, canopy, geometry, &sheet, faults)?;
    let confluence = confluence(at, canopy, geometry, &sheet, faults);
    if canopy.cavity.is_some() {
        sheet.check_mouth(at, &skirt, faults);
    }
    let profile = sheet.profile(at, &skirt, faults)?;
    let rows = rows?;
    let table = crate::model::spec::Series {
        t: rows.iter().map(|[s, _]| *s).collect(),
        value: rows.iter().map(|[_, c]| [*c]).collect(),
    };
    let place =
        |t: u32| geometry.mesh.triangles[t as usize].iter().map(|&n| profile.place[n as usize]).sum::<f64>() / 3.0;
    let pressure_coefficient = triangles.iter().map(|&t| table.at(place(t))[0]).collect();
    let diameter = || sheet.nominal_diameter(&skirt);
    let filling = canopy.schedule.as_ref().map_or_else(Vec::new, |stages| filling::stages(stages, diameter));
    (faults.count() == before).then_some(())?;
    let (apex, confluence) = (profile.apex, confluence?);
    let cavity = cavity.flatten();
    let apparent_mass = canopy.apparent_mass.filter(|factor| *factor > 0.0);
    Some(CanopySpec { triangles, pressure_coefficient, skirt, apex, confluence, filling, cavity, apparent_mass })
}

/// Rows of arc length and coefficient by the one way to give the pressure.
fn pressure_rows(at: &Pointer, canopy: &Canopy, faults: &mut Faults<'_>) -> Option<Vec<[f64; 2]>> {
    let given = [
        canopy.table.is_some().then_some("table"),
        canopy.schedule.is_some().then_some("schedule"),
        canopy.cavity.is_some().then_some("cavity"),
    ];
    let given: Vec<&str> = given.into_iter().flatten().collect();
    if given.len() != 1 {
        let value = match given.as_slice() {
            [] => "a canopy without pressure".to_owned(),
            several => format!("a canopy with {}", several.join(" and ")),
        };
        faults.add_value(at, value, "exactly one of table, schedule and cavity", None);
    }
    if let Some(schedule) = &canopy.schedule {
        filling::check(&at.key("schedule"), schedule, faults);
    }
    match canopy.table.as_ref().map(|table| &table.pressure_coefficient) {
        Some(PressureCoefficient::Constant(c)) => Some(vec![[0.0, *c]]),
        Some(PressureCoefficient::Rows(rows)) => {
            coefficient_rows(&at.key("table").key("pressure_coefficient"), rows, faults)
        }
        None => Some(vec![[0.0, 1.0]]),
    }
}

fn cavity(at: &Pointer, given: Cavity, faults: &mut Faults<'_>) -> Option<CavitySpec> {
    let Cavity { inflow, outer_pressure_coefficient, law } = given;
    positive(&at.key("inflow"), inflow, faults);
    if !(outer_pressure_coefficient.is_finite() && outer_pressure_coefficient < 1.0) {
        let hint = "it is that behind a full canopy, below the pressure inside: about -0.6";
        faults.add_hint(&at.key("outer_pressure_coefficient"), "a number below 1", hint);
    }
    let cloth = law.map(|law| {
        let found = checked_coefficients(&at.key("law"), &law.into(), faults)?;
        Some(ClothSpec { linear: found.linear, quadratic: found.quadratic })
    });
    // A faulty law is not cloth without one.
    let cloth = cloth.map_or(Some(None), |found| found.map(Some))?;
    Some(CavitySpec { inflow, outer_pressure_coefficient, cloth })
}

/// Rows of arc length, within 0 to 1, and coefficient.
fn coefficient_rows(at: &Pointer, rows: &[[f64; 2]], faults: &mut Faults<'_>) -> Option<Vec<[f64; 2]>> {
    rising(at, "arc length", rows.iter().map(|[s, c]| (*s, *c)), faults)?;
    for (i, [s, _]) in rows.iter().enumerate() {
        if !(0.0..=1.0).contains(s) {
            faults.add(&at.index(i), "arc lengths from 0 at the apex to 1 at the skirt");
            return None;
        }
    }
    Some(rows.to_vec())
}

/// The triangles of a canopy.
struct Sheet<'a> {
    geometry: &'a Geometry,
    mesh: Mesh,
    topology: Topology,
    /// whether a node is one of the canopy
    has: Vec<bool>,
}

/// The arc length over a canopy.
struct Profile {
    /// nodes around the apex
    apex: Vec<u32>,
    /// [-] by node: from 0 at the apex to 1 at the skirt
    place: Vec<f64>,
}

impl<'a> Sheet<'a> {
    fn new(at: &Pointer, geometry: &'a Geometry, triangles: &[u32], faults: &mut Faults<'_>) -> Option<Self> {
        let corners = triangles.iter().map(|&t| geometry.mesh.triangles[t as usize]).collect();
        let mesh = Mesh { nodes: geometry.mesh.nodes.clone(), triangles: corners, ..Mesh::default() };
        let checked = Topology::new(&mesh).and_then(|topology| {
            topology.check_manifold()?;
            topology.check_orientation(&mesh)?;
            Ok(topology)
        });
        let topology = match checked {
            Ok(topology) => topology,
            Err(error) => {
                let allowed = "a canopy whose triangles all turn the same way, with at most two at an edge";
                let hint = format!("{error} (triangles are counted within the canopy)");
                faults.add_value(&at.key("on"), "triangles that do not form a canopy", allowed, Some(hint));
                return None;
            }
        };
        let mut has = vec![false; mesh.nodes.len()];
        mesh.triangles.as_flattened().iter().for_each(|&node| has[node as usize] = true);
        Some(Sheet { geometry, mesh, topology, has })
    }

    fn point(&self, node: u32) -> Vector3<f64> {
        self.mesh.point(node)
    }

    /// [m] Lengths of the shortest paths along edges from some nodes, with a length of its own at each; infinite where
    /// no path leads. Edges of the mesh that join nodes of the canopy are paths too.
    fn distances(&self, from: &[(u32, f64)]) -> Vec<f64> {
        let within = |[a, b]: &[u32; 2]| self.has[*a as usize] && self.has[*b as usize];
        let mut edges: Vec<[u32; 2]> = self.geometry.mesh.edges.iter().copied().filter(within).collect();
        edges.extend(unique_edges(&self.mesh.triangles));
        let mut ways: Vec<[u32; 2]> = edges.iter().flat_map(|&[a, b]| [[a, b], [b, a]]).collect();
        ways.sort_unstable();
        ways.dedup();
        let start = row_starts(self.has.len(), ways.iter().map(|[a, _]| *a));
        let mut distance = vec![f64::INFINITY; self.has.len()];
        // Distances are positive, so their bits are in their order.
        let mut next = BinaryHeap::new();
        for &(node, d) in from {
            distance[node as usize] = d;
            next.push(Reverse((d.to_bits(), node)));
        }
        while let Some(Reverse((bits, node))) = next.pop() {
            let d = f64::from_bits(bits);
            if d > distance[node as usize] {
                continue;
            }
            for [_, other] in &ways[start[node as usize] as usize..start[node as usize + 1] as usize] {
                let to = d + (self.point(*other) - self.point(node)).norm();
                if to < distance[*other as usize] {
                    distance[*other as usize] = to;
                    next.push(Reverse((to.to_bits(), *other)));
                }
            }
        }
        distance
    }

    /// A mouth is one closed loop of the boundary: adds a fault unless the skirt has nodes on exactly one.
    fn check_mouth(&self, at: &Pointer, skirt: &[u32], faults: &mut Faults<'_>) {
        let loops = self.topology.loops().iter().filter(|l| l.nodes.iter().any(|node| skirt.contains(node)));
        let (closed, open): (Vec<_>, Vec<_>) = loops.partition(|l| l.closed);
        if closed.len() != 1 || !open.is_empty() {
            let value = format!("a skirt with nodes on {} loops of the boundary", closed.len() + open.len());
            let hint = "the mouth of a cavity is the loop of edges around the skirt".to_owned();
            faults.add_value(&at.key("cavity"), value, "a skirt on one closed loop", Some(hint));
        }
    }

    /// [m] The diameter of a circle with the area of the triangles and of the holes between them.
    fn nominal_diameter(&self, skirt: &[u32]) -> f64 {
        let corners = |t: &[u32; 3]| t.map(|node| self.point(node));
        let cloth: f64 = self.mesh.triangles.iter().map(|t| area(corners(t))).sum();
        let holes = self.topology.loops().iter().filter(|l| !l.outer && !l.nodes.iter().any(|n| skirt.contains(n)));
        let hole = |nodes: &[u32]| {
            let points: Vec<_> = nodes.iter().map(|&node| self.point(node)).collect();
            let middle = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
            let sides = points.iter().zip(points.iter().cycle().skip(1));
            sides.map(|(a, b)| area([middle, *a, *b])).sum::<f64>()
        };
        let holes: f64 = holes.map(|l| hole(&l.nodes)).sum();
        (4.0 * (cloth + holes) / PI).sqrt()
    }

    /// The arc length from the apex: the middle of the vent, or of the node that is furthest from the skirt.
    fn profile(&self, at: &Pointer, skirt: &[u32], faults: &mut Faults<'_>) -> Option<Profile> {
        let from_skirt = self.distances(&skirt.iter().map(|&node| (node, 0.0)).collect::<Vec<_>>());
        let nodes = || (0_u32..).zip(&self.has).filter(|(_, has)| **has).map(|(node, _)| node);
        let far = |node: &u32| from_skirt[*node as usize];
        if let Some(node) = nodes().find(|node| far(node).is_infinite()) {
            let value = format!("no edges lead from the skirt to node {node}");
            let hint = "the parts of a canopy are joined by edges, such as radial tapes; make a canopy of each part that is one of its own";
            faults.add_value(&at.key("on"), value, "a canopy in one piece", Some(hint.to_owned()));
            return None;
        }
        let furthest = nodes().max_by(|a, b| far(a).total_cmp(&far(b)).then(b.cmp(a)))?;
        let vent = self.topology.loops().iter().map(|l| &l.nodes).find(|nodes| nodes.contains(&furthest));
        let apex = vent.filter(|nodes| !nodes.iter().any(|node| skirt.contains(node))).cloned();
        let apex = apex.unwrap_or_else(|| vec![furthest]);
        let middle = apex.iter().map(|&node| self.point(node)).sum::<Vector3<f64>>() / apex.len() as f64;
        let from: Vec<(u32, f64)> = apex.iter().map(|&node| (node, (self.point(node) - middle).norm())).collect();
        let from_apex = self.distances(&from);
        let place = from_apex.iter().zip(&from_skirt).map(|(a, s)| if a + s > 0.0 { a / (a + s) } else { 0.0 });
        Some(Profile { place: place.collect(), apex })
    }
}

/// [m^2] of a triangle
fn area([a, b, c]: [Vector3<f64>; 3]) -> f64 {
    0.5 * (b - a).cross(&(c - a)).norm()
}

fn skirt(
    at: &Pointer,
    canopy: &Canopy,
    geometry: &Geometry,
    sheet: &Sheet<'_>,
    faults: &mut Faults<'_>,
) -> Option<Vec<u32>> {
    if let Some(selection) = &canopy.skirt {
        let at = at.key("skirt");
        let nodes = select::nodes(&at, selection, geometry, faults)?;
        if let Some(node) = nodes.iter().find(|&&node| !sheet.has[node as usize]) {
            faults.add_value(
                &at,
                format!("node {node}, which no triangle of the canopy has"),
                "nodes of the canopy",
                None,
            );
            return None;
        }
        return Some(nodes);
    }
    if let Some(group) = geometry.mesh.groups.get("skirt") {
        let nodes = group.select_nodes(&geometry.mesh).into_iter();
        let nodes: Vec<u32> = nodes.filter(|&node| sheet.has[node as usize]).collect();
        if !nodes.is_empty() {
            return Some(nodes);
        }
    }
    let outer: Vec<_> = sheet.topology.loops().iter().filter(|l| l.outer).collect();
    let (value, hint) = match outer.as_slice() {
        [one] if one.closed => return Some(one.nodes.clone()),
        [_] => ("a skirt that is no closed loop".to_owned(), "its boundary ends at an edge of three or more triangles"),
        [] => ("a closed surface, which has no skirt".to_owned(), "an open canopy has an outer boundary"),
        sheets => (format!("{} sheets", sheets.len()), "name the nodes of the lowest edge in \"skirt\""),
    };
    faults.add_value(&at.key("on"), value, "a canopy with one outer boundary, its skirt", Some(hint.to_owned()));
    None
}

fn confluence(
    at: &Pointer,
    canopy: &Canopy,
    geometry: &Geometry,
    sheet: &Sheet<'_>,
    faults: &mut Faults<'_>,
) -> Option<Vec<u32>> {
    let below = at.key("confluence");
    let group = || {
        let known = geometry.mesh.groups.contains_key("confluence");
        known.then(|| NodeSelection::Group("confluence".to_owned()))
    };
    let Some(selection) = canopy.confluence.clone().or_else(group) else {
        let hint = "name the node or nodes where the lines meet, e.g. \"confluence\": {\"ids\": [12]}".to_owned();
        faults.add_value(&below, "(missing)", "an axis: the nodes where the lines meet", Some(hint));
        return None;
    };
    let nodes = select::nodes(&below, &selection, geometry, faults)?;
    if let Some(node) = nodes.iter().find(|&&node| sheet.has[node as usize]) {
        let value = format!("node {node}, which is one of the canopy");
        faults.add_value(&below, value, "the nodes where the lines meet, below the canopy", None);
        return None;
    }
    Some(nodes)
}

/// Finds filling times by the speed at the start. Adds a fault for every canopy that has no axis there, no side towards
/// which the air can fill it, or no speed.
pub(super) fn at_start(at: &Pointer, aero: Option<&Aero>, spec: &mut NetworkSpec, faults: &mut Faults<'_>) {
    let given = aero.and_then(|aero| aero.canopy.as_ref());
    for i in 0..spec.canopies.len() {
        let at = match given {
            Some(OneOrSeveral::Several(_)) => at.key("canopy").index(i),
            _ => at.key("canopy"),
        };
        let start = CanopyStart::of(spec, i);
        let before = faults.count();
        start.check(&at, faults);
        let stages = given.and_then(|given| given.all().get(i)?.schedule.as_ref());
        if let Some(stages) = stages.filter(|_| faults.count() == before) {
            filling::at_speed(&at.key("schedule"), stages, &mut spec.canopies[i].filling, start.speed, faults);
        }
    }
}

/// A canopy at the start of a run.
struct CanopyStart {
    /// [m] from the apex to the confluence
    axis: Vector3<f64>,
    /// [m^2] sum of the area vectors of its triangles, and of their sizes
    area: (Vector3<f64>, f64),
    /// [m/s] axial air speed
    speed: f64,
}

impl CanopyStart {
    fn of(spec: &NetworkSpec, i: usize) -> Self {
        let canopy = &spec.canopies[i];
        let vector =
            |list: &[[f64; 3]], node: u32| list.get(node as usize).map_or(Vector3::zeros(), |v| Vector3::from(*v));
        let place = |node: u32| spec.mesh.point(node) + vector(&spec.displacement, node);
        let mean = |nodes: &[u32], of: &dyn Fn(u32) -> Vector3<f64>| {
            nodes.iter().map(|&node| of(node)).sum::<Vector3<f64>>() / nodes.len() as f64
        };
        let axis = mean(&canopy.confluence, &place) - mean(&canopy.apex, &place);
        let areas = canopy.triangles.iter().map(|&t| {
            let [a, b, c] = spec.mesh.triangles[t as usize].map(place);
            0.5 * (b - a).cross(&(c - a))
        });
        let area = areas.fold((Vector3::zeros(), 0.0), |(sum, size), s| (sum + s, size + s.norm()));
        let stream = spec.stream.as_ref();
        let wind = stream.map_or([0.0; 3], |stream| stream.wind_at(0.0, mean(&canopy.skirt, &place).z));
        let velocity = mean(&canopy.skirt, &|node| vector(&spec.velocity, node)) - Vector3::from(wind);
        CanopyStart { axis, area, speed: velocity.dot(&axis) / axis.norm() }
    }

    fn check(&self, at: &Pointer, faults: &mut Faults<'_>) {
        let (CanopyStart { axis, area: (sum, size), .. }, at) = (self, at.key("confluence"));
        if axis.norm() <= AXIS * size.sqrt() {
            let value = format!("the confluence lies {} m from the apex", axis.norm());
            let hint = "the axis leads from the apex to the nodes where the lines meet: start with the lines stretched";
            faults.add_value(&at, value, "a confluence below the canopy", Some(hint.to_owned()));
        } else if sum.dot(axis).abs() <= OPENING * size * axis.norm() {
            let value = "the canopy shows no area along its axis";
            let hint =
                "the air speed along the axis fills it: lead the axis from the apex through its opening".to_owned();
            faults.add_value(&at, value, "a canopy that is open towards the confluence", Some(hint));
        }
    }
}
