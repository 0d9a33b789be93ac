//! Springs of a parachute's parts by their materials.

use super::super::geometry::Geometry;
use super::{Cloths, fill_cloth, fill_line, rule_of};
use crate::case::diagnostics::Faults;
use crate::case::materials::MaterialTable;
use crate::case::pointer::Pointer;
use crate::case::schema::{EdgeSelection, Network, NodeSelection};
use crate::format_number::figures;
use crate::mesh::EdgeKind;
use crate::mesh::parachute::{ParachuteParameters, TapeMaterials};
use crate::mesh::source::MeshSource;
use std::collections::BTreeMap;

/// Groups of edges that are no cloth.
const LINES: [&str; 5] = ["lines", "inner-lines", "centre-line", "riser", "vent-lines"];

/// A parachute with its mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Parts<'a> {
    pub parachute: &'a ParachuteParameters,
    pub geometry: &'a Geometry,
    pub table: MaterialTable<'a>,
}

/// A part of a parachute that has a material.
#[derive(Debug)]
pub(super) struct Part<'a> {
    pub group: &'static str,
    /// name of the material
    pub material: &'a str,
    /// where the case names it
    pub at: Pointer,
}

impl<'a> Parts<'a> {
    /// The parts with a line, tape or cable as material. Tapes, inner lines and the centre line that name none have
    /// that of the lines.
    pub(super) fn lines(&self, at: &Pointer) -> Vec<Part<'a>> {
        let p = self.parachute;
        let of_lines = p.lines.as_ref().and_then(|lines| lines.material.as_deref());
        let of = |part: &'a Option<_>| part.as_ref().and_then(material);
        let inner = p.inner_lines.as_ref().and_then(|lines| lines.material.as_deref());
        let tape =
            |name: fn(&TapeMaterials) -> &Option<String>| p.tapes.as_ref().and_then(|tapes| name(tapes).as_deref());
        let all: [(&'static str, &[&str], Option<&'a str>); 10] = [
            ("radials", &["tapes", "radials"], tape(|tapes| &tapes.radials)),
            ("skirt", &["tapes", "skirt"], tape(|tapes| &tapes.skirt)),
            ("vent", &["tapes", "vent"], tape(|tapes| &tapes.vent)),
            ("rims", &["tapes", "rims"], tape(|tapes| &tapes.rims)),
            ("verticals", &["tapes", "verticals"], tape(|tapes| &tapes.verticals)),
            ("vent-lines", &["tapes", "vent_lines"], tape(|tapes| &tapes.vent_lines)),
            ("lines", &["lines", "material"], of_lines),
            ("inner-lines", &["inner_lines", "material"], inner),
            ("centre-line", &["centre_line", "material"], of(&p.centre_line)),
            ("riser", &["riser", "material"], of(&p.riser)),
        ];
        let below = |keys: &[&str]| keys.iter().fold(at.key("mesh").key("parachute"), |at, key| at.key(key));
        let named = |(group, keys, own): (&'static str, &[&str], Option<&'a str>)| match own {
            Some(material) => Some(Part { group, material, at: below(keys) }),
            None if group == "riser" => None,
            None => of_lines.map(|material| Part { group, material, at: below(&["lines", "material"]) }),
        };
        all.into_iter().filter_map(named).collect()
    }

    /// The groups of a part that are in the mesh and are not in `written`: the part, or its copies in a cluster if the
    /// case writes some of these.
    pub(super) fn groups_left(&self, part: &str, written: &[&str]) -> Vec<String> {
        let groups = &self.geometry.mesh.groups;
        let has_edges = |name: &str| groups.get(name).is_some_and(|g| !g.edges.is_empty() || !g.triangles.is_empty());
        if written.contains(&part) || !has_edges(part) {
            return Vec::new();
        }
        let copy_of = |name: &str| {
            let number = name.strip_prefix(part).and_then(|rest| rest.strip_prefix('-'));
            number.is_some_and(|number| number.parse::<usize>().is_ok())
        };
        if !written.iter().any(|name| copy_of(name)) {
            return vec![part.to_owned()];
        }
        let copies = groups.keys().filter(|name| copy_of(name) && !written.contains(&name.as_str()));
        copies.cloned().collect()
    }
}

fn material(line: &crate::mesh::parachute::RigLineParameters) -> Option<&str> {
    line.material.as_deref()
}

/// Tells of sizes that the case leaves to the type.
pub(super) fn resolved(written: &ParachuteParameters, source: &MeshSource, taken: &mut Vec<String>) {
    let MeshSource::Parachute(whole) = source else { return };
    let d0 = whole.nominal_diameter.unwrap_or(f64::NAN);
    if let Some(constructed) = written.constructed_diameter {
        taken.push(format!(
            "mesh.parachute.nominal_diameter {} m: the pattern of a constructed diameter of {} m",
            figures(d0, 6),
            figures(constructed, 6)
        ));
    }
    if let (Some(lines), Some(length)) = (&written.lines, whole.lines.as_ref().and_then(|lines| lines.length))
        && lines.length.is_none()
    {
        taken.push(format!(
            "mesh.parachute.lines.length {} m: {} D0, of type {}",
            figures(length, 6),
            figures(length / d0, 4),
            written.kind
        ));
    }
}

/// Adds springs on the parts that have a material and no rule of the case.
pub(super) fn add(
    at: &Pointer,
    parts: &Parts<'_>,
    whole: &mut Network,
    cloths: &mut Cloths,
    taken: &mut Vec<String>,
    faults: &mut Faults<'_>,
) {
    let lines = parts.lines(at);
    let cloth = parts.parachute.cloth.as_deref();
    if lines.is_empty() && cloth.is_none() {
        return;
    }
    let Some(written) = written(at, parts, whole, faults) else { return };
    let written: Vec<&str> = written.iter().map(String::as_str).collect();
    let mut by_material: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    if let Some(name) = cloth
        && let Some(material) = parts.table.cloth(&at.key("mesh").key("parachute").key("cloth"), name, faults)
    {
        let left = parts.groups_left("cloth", &written);
        // Membranes of another cloth have its mass.
        if cloths.is_empty() || !left.is_empty() {
            cloths.add(name, material);
        }
        for group in left {
            by_material.entry(name).or_default().push(group.clone());
            let mut rule = rule_of(group);
            fill_cloth(&mut rule, material);
            whole.springs.push(rule);
        }
    }
    // Tapes have the material of the lines, whose fault is told once.
    let mut unknown: Vec<&str> = Vec::new();
    for Part { group, material: name, at } in &lines {
        if unknown.contains(&at.as_str()) {
            continue;
        }
        let Some(material) = parts.table.line(at, name, faults) else {
            unknown.push(at.as_str());
            continue;
        };
        for group in parts.groups_left(group, &written) {
            by_material.entry(name).or_default().push(group.clone());
            let mut rule = rule_of(group);
            fill_line(&mut rule, material);
            whole.springs.push(rule);
        }
    }
    taken.extend(by_material.iter().map(|(name, groups)| format!("springs of {}: {name}", groups.join(", "))));
}

/// The parts for which the case has springs or membranes; `None` with a fault if it cannot be said which edges these
/// are on.
fn written(at: &Pointer, parts: &Parts<'_>, network: &Network, faults: &mut Faults<'_>) -> Option<Vec<String>> {
    let mut written: Vec<String> = Vec::new();
    let all = || parts.geometry.mesh.groups.keys().cloned();
    for (i, rule) in network.springs.iter().enumerate() {
        match &rule.on {
            EdgeSelection::Group(name) if name == "canopy" => written.push("cloth".to_owned()),
            EdgeSelection::Group(name) => written.push(name.clone()),
            EdgeSelection::All => written.extend(all()),
            EdgeSelection::Lines if !has_gaps(parts) => written.extend(LINES.map(str::to_owned)),
            _ => {
                let hint = "springs of the materials would be on these edges too: name the part by its group, or leave \
                            the materials out";
                let allowed = "{\"group\": ...} or \"all\" beside a parachute with materials";
                faults.add_hint(&at.key("springs").index(i).key("on"), allowed, hint);
                return None;
            }
        }
    }
    for rule in &network.membranes {
        match &rule.on {
            NodeSelection::Group(name) => match name.strip_prefix("canopy") {
                Some(number) => written.push(format!("cloth{number}")),
                None => written.push(name.clone()),
            },
            _ => written.push("cloth".to_owned()),
        }
    }
    Some(written)
}

/// Whether tapes cross gaps, so that some of their edges belong to no triangle.
fn has_gaps(parts: &Parts<'_>) -> bool {
    let Geometry { mesh, topology, .. } = parts.geometry;
    let tapes = mesh.groups.get("radials").map_or(&[][..], |group| &group.edges);
    tapes.iter().any(|&edge| topology.edge_kind(edge as usize) == EdgeKind::Line)
}
