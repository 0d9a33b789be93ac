//! Generated meshes with half and twice as many cells, segments or nodes. The variant is the same scene only where the
//! case says nothing of single nodes and edges; where it does, that is said.

use serde_json::Value;

use super::{NETWORK, PAYLOAD, Search, group, selected};
use crate::case::spec::SystemSpec;
use crate::require::change::{Change, Variant};

/// Selections of several nodes whose number follows from the mesh.
const COUNTED: [&str; 4] = ["all", "boundary", "outer", "inner"];
/// Groups of a rigid payload, which a point has not.
const RIGID: [&str; 2] = ["slings", "payload-bars"];
/// Selections of edges whose springs stand for a sheet.
const SHEET: [&str; 3] = ["all", "interior", "cloth"];

/// Meshes of repeated sectors.
const SYMMETRIC: [&str; 3] = ["parachute", "annulus", "disc"];

/// A count of a parachute: its key, its words, its unit, and the groups whose edges it divides.
type Count = (&'static str, &'static str, &'static str, &'static [&'static str]);
const COUNTS: [Count; 5] = [
    ("radial_segments", "mesh", "radial_segments", &["cloth", "all", "interior", "radials"]),
    ("gore_segments", "mesh", "gore_segments", &["cloth", "all", "interior", "skirt", "vent", "rims"]),
    ("lines/segments", "lines", "segments", &["all", "lines"]),
    ("inner_lines/segments", "inner lines", "segments", &["all", "lines", "inner-lines"]),
    ("riser/segments", "riser", "segments", &["all", "lines", "riser"]),
];

/// Where a node goes on another mesh; none if it has no place there.
type Renumbering<'a> = &'a dyn Fn(u64) -> Option<u64>;

impl Search<'_> {
    /// Coarser and finer meshes.
    pub(super) fn mesh(&mut self) {
        let Some((kind, mesh)) = self.get("mesh").and_then(Value::as_object).and_then(|mesh| mesh.iter().next()) else {
            return;
        };
        if SYMMETRIC.contains(&kind.as_str()) {
            let why = "it needs equations that tie the edges of the part by a rotation, which no solver here has";
            self.found.kept.push(format!("a part of a symmetric scene: not tried: {why}"));
        }
        match kind.as_str() {
            "parachute" => self.parachute(mesh),
            "chain" => self.chain(mesh),
            "rectangle" => self.rectangle(mesh),
            "disc" | "annulus" => self.ring(kind, mesh),
            "explicit" => self.keep("it is listed in the case: there is none that is coarser or finer"),
            _ => self.keep("it is a file: there is none that is coarser or finer"),
        }
    }

    fn keep(&mut self, why: &str) {
        self.found.kept.push(format!("mesh: {why}"));
    }

    fn parachute(&mut self, mesh: &Value) {
        for (key, of, unit, groups) in COUNTS {
            let above = key.rsplit_once('/').map(|(above, _)| above);
            if above.is_some_and(|above| mesh.get(above).is_none_or(Value::is_null)) {
                continue;
            }
            let at = format!("/{key}");
            let from = mesh.pointer(&at).and_then(Value::as_u64).unwrap_or(1);
            if let Some(why) = self.numbered(None).err().or_else(|| self.of_one(groups)) {
                self.keep(&format!("{key} stays: {why}"));
                continue;
            }
            let least = if above.is_some() { 1 } else { from / 2 };
            let mut counts = vec![least, from / 2, 2 * from];
            counts.retain(|to| *to > 0 && *to != from);
            counts.dedup();
            for to in counts {
                let change = mesh_change(of, from, to, unit);
                self.add(change.set(format!("{NETWORK}/mesh/parachute{at}"), to));
            }
        }
        if mesh.get("payload").is_some_and(|payload| !payload.is_null()) {
            let rigid = self.entries("springs").filter(|(_, rule)| group(rule).is_some_and(|of| RIGID.contains(&of)));
            let point = Variant::of(Change::PointPayload).without(format!("{NETWORK}/mesh/parachute/{PAYLOAD}"));
            self.add(rigid.fold(point, |point, (at, _)| point.without(at)));
        }
    }

    fn chain(&mut self, mesh: &Value) {
        let Some(from) = mesh.get("segments").and_then(Value::as_u64) else { return };
        if let Some(why) = self.of_one(&["all", "lines"]) {
            return self.keep(&why);
        }
        for to in [1, from / 2, 2 * from].into_iter().filter(|to| *to > 0 && *to != from) {
            let place = |node: u64| (node * to).is_multiple_of(from).then(|| node * to / from);
            let change = mesh_change("chain", from, to, "segments");
            self.renumbered(change.set(format!("{NETWORK}/mesh/chain/segments"), to), &place);
        }
    }

    fn rectangle(&mut self, mesh: &Value) {
        let count = |key: &str| mesh.get(key).and_then(Value::as_u64);
        let (Some(columns), Some(rows)) = (count("columns"), count("rows")) else { return };
        if let Some(why) = self.of_one(&[]).or_else(|| self.of_sheet()) {
            return self.keep(&why);
        }
        let grid = (columns + 1) * (rows + 1);
        for scale in [|n: u64| (n / 2).max(1), |n: u64| 2 * n] {
            let [to_columns, to_rows] = [scale(columns), scale(rows)];
            let place = |node: u64| {
                let [row, column] = [node / (columns + 1) * to_rows, node % (columns + 1) * to_columns];
                let whole = node < grid && row.is_multiple_of(rows) && column.is_multiple_of(columns);
                whole.then(|| row / rows * (to_columns + 1) + column / columns)
            };
            let change = Change::Mesh {
                of: "mesh".to_owned(),
                from: format!("{columns} x {rows}"),
                to: format!("{to_columns} x {to_rows}"),
                unit: "cells".to_owned(),
                finer: to_columns > columns,
            };
            if [to_columns, to_rows] != [columns, rows] {
                let at = |key: &str| format!("{NETWORK}/mesh/rectangle/{key}");
                let variant = Variant::of(change).set(at("columns"), to_columns).set(at("rows"), to_rows);
                self.renumbered(variant, &place);
            }
        }
    }

    /// Discs and rings: the number of nodes, and that on the edges with its square root.
    fn ring(&mut self, kind: &str, mesh: &Value) {
        let count = |key: &str| mesh.get(key).and_then(Value::as_u64);
        let Some(from) = count("nodes") else { return };
        if let Some(why) = self.numbered(None).err().or_else(|| self.of_one(&[])).or_else(|| self.of_sheet()) {
            return self.keep(&why);
        }
        for to in [from / 2, 2 * from] {
            let at = |key: &str| format!("{NETWORK}/mesh/{kind}/{key}");
            let mut variant = mesh_change("mesh", from, to, "nodes").set(at("nodes"), to);
            if let Some(edge) = count("boundary_nodes") {
                let edge = edge as f64 * (to as f64 / from as f64).sqrt();
                variant = variant.set(at("boundary_nodes"), edge.round() as u64);
            }
            self.add(variant);
        }
    }

    /// Adds a variant whose nodes have other numbers.
    fn renumbered(&mut self, variant: Variant, place: Renumbering<'_>) {
        match self.numbered(Some(place)) {
            Ok(edits) => self.add(edits.into_iter().fold(variant, |variant, (at, ids)| variant.set(at, ids))),
            Err(why) => self.found.kept.push(format!("{}: {why}", variant.change)),
        }
    }

    /// The lists of node numbers of the case on another mesh.
    ///
    /// # Errors
    /// What has no place there.
    fn numbered(&self, place: Option<Renumbering<'_>>) -> Result<Vec<(String, Value)>, String> {
        for key in ["mass/nodal", "initial/displacement", "initial/velocity"] {
            let listed = self.get(key).and_then(Value::as_array);
            if listed.is_some_and(|list| key == "mass/nodal" || list.first().is_some_and(Value::is_array)) {
                return Err(format!("{key} is a list of a value for each node"));
            }
        }
        if self.get("initial/from").is_some() {
            return Err("it starts from a state of this mesh".to_owned());
        }
        let mut lists = Vec::new();
        for section in ["/system/network", "/output"] {
            numbers_in(self.json, section, &mut lists);
        }
        let renumber = |(at, ids): (String, Vec<u64>)| {
            let known = place.filter(|_| self.selects_nodes(&at));
            let ids: Option<Vec<u64>> = known.and_then(|place| ids.into_iter().map(place).collect());
            let ids = ids.ok_or_else(|| format!("{at} selects by numbers of this mesh"))?;
            Ok((at, Value::from(ids)))
        };
        lists.into_iter().map(renumber).collect()
    }

    /// Whether a selection is one of nodes.
    fn selects_nodes(&self, at: &str) -> bool {
        let entry = at.strip_suffix("/on/ids").and_then(|entry| self.json.pointer(entry));
        let Some(entry) = entry else { return false };
        let below = |place: &str| at.starts_with(place);
        below("/system/network/supports/")
            || below("/system/network/mass/points/")
            || below("/output/probes/")
            || below("/output/gauges/") && entry.get("of").is_none_or(|of| of != "tension")
            || below("/system/network/loads/") && entry.get("force").is_some()
            || below("/system/network/aero/drag/") && entry.get("drag_area").is_some()
    }

    /// What the case says of single nodes, or of single edges of some selections, which change with the mesh.
    fn of_one(&self, edges: &[&str]) -> Option<String> {
        if self.get("mass/nodal").is_some() {
            return Some(
                "mass.nodal is that of a node of this mesh; areal_density, linear_density and total are not".into(),
            );
        }
        let many = |entry: &Value| COUNTED.contains(&selected(entry).as_str());
        let each = |(at, _): (String, &Value), key: &str| format!("{at}/{key} is that of each node of this mesh");
        let point = self.entries("mass/points").find(|(_, entry)| entry.get("mass").is_some() && many(entry));
        let force = self.entries("loads").find(|(_, entry)| entry.get("force").is_some() && many(entry));
        let nodes = point.map(|of| each(of, "mass")).or_else(|| force.map(|of| each(of, "force")));
        nodes.or_else(|| {
            let divided = self.entries("springs").filter(|(_, rule)| {
                let of = selected(rule);
                edges.contains(&of.as_str()) && !(SHEET.contains(&of.as_str()) && self.has_triangles())
            });
            divided
                .flat_map(|(at, rule)| {
                    let has = |key: &str| rule.pointer(key).is_some_and(|value| !value.is_null());
                    let keys =
                        ["/stiffness", "/rest_length", "/dashpot/axial/coefficient", "/dashpot/relative/coefficient"];
                    keys.into_iter()
                        .filter(|key| has(key))
                        .map(|key| format!("{at}{key} is that of an edge of this mesh"))
                        .collect::<Vec<_>>()
                })
                .next()
        })
    }

    /// Springs of a sheet that do not follow the size of its triangles.
    fn of_sheet(&self) -> Option<String> {
        let bars = |rule: &Value| SHEET.contains(&selected(rule).as_str()) && rule.get("axial_rigidity").is_some();
        let (at, _) = self.entries("springs").find(|(_, rule)| bars(rule))?;
        Some(format!("the bars of {at} are a stiffer sheet on a finer mesh; springs with a membrane modulus are not"))
    }

    fn has_triangles(&self) -> bool {
        matches!(&self.problem.system, SystemSpec::Network(spec) if !spec.mesh.triangles.is_empty())
    }
}

fn mesh_change(of: &str, from: u64, to: u64, unit: &str) -> Variant {
    let [of, unit] = [of, unit].map(str::to_owned);
    Variant::of(Change::Mesh { of, from: from.to_string(), to: to.to_string(), unit, finer: to > from })
}

/// All lists of numbers of nodes, edges or triangles below a JSON pointer, but those of the mesh itself.
fn numbers_in(case: &Value, at: &str, lists: &mut Vec<(String, Vec<u64>)>) {
    match case.pointer(at) {
        Some(Value::Object(map)) => {
            for (key, value) in map.iter().filter(|(key, _)| *key != "mesh") {
                let at = format!("{at}/{key}");
                match value.as_array().filter(|_| key == "ids") {
                    Some(ids) => lists.push((at, ids.iter().filter_map(Value::as_u64).collect())),
                    None => numbers_in(case, &at, lists),
                }
            }
        }
        Some(Value::Array(list)) if list.first().is_some_and(Value::is_object) => {
            (0..list.len()).for_each(|i| numbers_in(case, &format!("{at}/{i}"), lists));
        }
        _ => {}
    }
}
