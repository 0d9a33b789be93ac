//! Membranes and bending: which triangle and which edge follows which rule.

use super::geometry::{Geometry, TriangleUse, triangles};
use super::plausible;
use super::select;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{BendingRule, MembraneRule, Modulus};
use crate::format_number::first_few;
use crate::mesh::EdgeKind;
use crate::model::spec::{BendingSpec, MembraneSpec};
use crate::warning::WarningCode;
use nalgebra::Vector3;
use std::collections::BTreeMap;

/// [-] Sine of the angle between a warp direction and the normal of a triangle, below which there is no projection.
const UPRIGHT: f64 = 1e-6;

/// The membranes of a case, in the order of the rules.
pub(super) fn membranes(
    at: &Pointer,
    rules: &[MembraneRule],
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Vec<MembraneSpec> {
    let mut taken = vec![false; geometry.map_or(0, |geometry| geometry.mesh.triangles.len())];
    let mut found = Vec::new();
    for (i, rule) in rules.iter().enumerate() {
        let at = at.index(i);
        let material = material(&at, rule, faults);
        let Some(geometry) = geometry.filter(|_| faults.readable(&at.key("on"))) else { continue };
        if !triangles(&at, "a membrane", geometry, TriangleUse::Areas, faults) {
            continue;
        }
        let Some(mut list) = select::triangles(&at.key("on"), &rule.on, geometry, faults) else { continue };
        list.retain(|&t| !std::mem::replace(&mut taken[t as usize], true));
        if list.is_empty() {
            let text =
                "earlier rules take all the triangles it selects, so it has no effect; order the special rules first";
            faults.warn(WarningCode::UnusedRule, format!("{at}: {text}"));
            continue;
        }
        let Some(material) = material else { continue };
        if upright(&at, &material, &list, geometry, faults) {
            continue;
        }
        found.push(MembraneSpec { triangles: list, ..material });
    }
    found
}

/// A rule's material, without its triangles.
fn material(at: &Pointer, rule: &MembraneRule, faults: &mut Faults<'_>) -> Option<MembraneSpec> {
    let before = faults.count();
    let (Some(thickness), Some(modulus), Some(poisson)) = (rule.thickness, rule.modulus, rule.poisson) else {
        let given = [rule.thickness.is_some(), rule.modulus.is_some(), rule.poisson.is_some()];
        let keys = ["thickness", "modulus", "poisson"].into_iter().zip(given);
        for (key, _) in keys.filter(|(_, given)| !given) {
            faults.add_value(&at.key(key), "(missing)", format!("the key \"{key}\" is required here"), None);
        }
        return None;
    };
    plausible::material(&at.key("thickness"), "thickness", thickness, faults);
    let at_modulus = at.key("modulus");
    let orthotropic = matches!(modulus, Modulus::Orthotropic(_));
    let modulus = match modulus {
        Modulus::Isotropic(modulus) => {
            plausible::material(&at_modulus, "modulus", modulus, faults);
            [modulus; 2]
        }
        Modulus::Orthotropic(two) => {
            two.iter().enumerate().for_each(|(i, modulus)| {
                plausible::material(&at_modulus.index(i), "modulus", *modulus, faults);
            });
            two
        }
    };
    let damping_time = rule.damping_time.unwrap_or(0.0);
    let shear = match (orthotropic, rule.shear) {
        (false, None) => modulus[0] / (2.0 * (1.0 + poisson)),
        (true, Some(shear)) => shear,
        (false, Some(shear)) => {
            let hint = "one modulus has G = E/(2 (1 + nu)); for another, give two moduli and a warp";
            faults.add_value(&at.key("shear"), shear.to_string(), "only with two moduli", Some(hint.to_owned()));
            return None;
        }
        (true, None) => {
            let hint = Some("give the shear modulus [Pa] of the cloth".to_owned());
            faults.add_value(at, "two moduli without shear", "modulus, poisson, shear and warp", hint);
            return None;
        }
    };
    if orthotropic && rule.warp.is_none() {
        let hint = Some("give the direction of the warp, e.g. \"warp\": [1, 0, 0]".to_owned());
        faults.add_value(at, "two moduli without a warp", "modulus, poisson, shear and warp", hint);
    }
    let warp = rule.warp.map(|warp| warp.map(|w| w / Vector3::from(warp).amax()));
    if warp.is_some_and(|warp| !warp.iter().all(|w| w.is_finite())) {
        faults.add(&at.key("warp"), "a vector that is not zero; its length does not matter");
    }
    let known = faults.readable(&at_modulus) && !(0..2).any(|i| faults.unread(&at_modulus.index(i)));
    if known && poisson * poisson * modulus[1] >= modulus[0] {
        let allowed = if orthotropic { "poisson^2 E2 below E1" } else { "above -1 and below 1" };
        faults.add_value(&at.key("poisson"), poisson.to_string(), allowed, None);
    }
    let spec = MembraneSpec {
        triangles: Vec::new(),
        thickness,
        modulus,
        poisson,
        shear,
        warp,
        wrinkling: rule.wrinkling,
        damping_time,
        strength: rule.strength,
    };
    (faults.count() == before).then_some(spec)
}

/// Refuses a warp direction at right angles to some triangle.
fn upright(at: &Pointer, spec: &MembraneSpec, list: &[u32], geometry: &Geometry, faults: &mut Faults<'_>) -> bool {
    let Some(warp) = spec.warp.map(Vector3::from) else { return false };
    let upright = |&t: &u32| {
        let [a, b, c] = geometry.mesh.triangles[t as usize].map(|i| Vector3::from(geometry.mesh.nodes[i as usize]));
        let normal = (b - a).cross(&(c - a));
        normal.cross(&warp).norm() <= UPRIGHT * normal.norm() * warp.norm()
    };
    let bad: Vec<u32> = list.iter().copied().filter(upright).collect();
    if bad.is_empty() {
        return false;
    }
    let value = format!("at right angles to triangles {}", first_few(&bad));
    let hint = "take a direction along the cloth, or a rule of its own for these triangles".to_owned();
    faults.add_value(&at.key("warp"), value, "a direction with a part in every triangle", Some(hint));
    true
}

/// The bending of a case, in the order of the rules.
pub(super) fn bending(
    at: &Pointer,
    rules: &[BendingRule],
    geometry: Option<&Geometry>,
    faults: &mut Faults<'_>,
) -> Vec<BendingSpec> {
    let mut found = Vec::new();
    for (i, rule) in rules.iter().enumerate() {
        let at = at.index(i);
        let value = match (rule.stiffness, rule.flexural_rigidity) {
            (Some(b), None) => Some(Ok(b)),
            (None, Some(ei)) => Some(Err(ei)),
            (None, None) => {
                faults.add_value(&at, "a bending rule without stiffness", EITHER, None);
                None
            }
            (Some(_), Some(_)) => {
                let hint = Some("write two rules".to_owned());
                faults.add_value(&at, "a bending rule with both stiffnesses", EITHER, hint);
                None
            }
        };
        let Some(geometry) = geometry.filter(|_| faults.readable(&at.key("on"))) else { continue };
        let Some(selected) = select::edges(&at.key("on"), &rule.on, geometry, faults) else { continue };
        let spec = match value {
            Some(Ok(stiffness)) => {
                if !triangles(&at, "bending", geometry, TriangleUse::Areas, faults) {
                    continue;
                }
                BendingSpec { hinges: hinges(&selected, geometry), stiffness, ..BendingSpec::default() }
            }
            Some(Err(ei)) => {
                BendingSpec { chains: chains(&selected, geometry), flexural_rigidity: ei, ..BendingSpec::default() }
            }
            None => continue,
        };
        if spec.hinges.is_empty() && spec.chains.is_empty() {
            let hint =
                "stiffness is for edges between two triangles, flexural_rigidity for nodes with two edges of a line";
            faults.add_hint(&at.key("on"), "edges that can bend", hint);
            continue;
        }
        found.push(spec);
    }
    found
}

const EITHER: &str = "exactly one of stiffness (cloth, N m) and flexural_rigidity (lines, N m^2)";

/// The selected edges between exactly two triangles, with the third corners of these.
fn hinges(selected: &[bool], geometry: &Geometry) -> Vec<[u32; 4]> {
    let mesh = &geometry.mesh;
    let hinge = |edge: usize| {
        let &[one, two] = geometry.topology.edge_triangles(edge) else { return None };
        let [a, b] = mesh.edges[edge];
        let wing = |t: u32| mesh.triangles[t as usize].into_iter().find(|node| ![a, b].contains(node));
        Some([a, b, wing(one)?, wing(two)?])
    };
    (0..mesh.edges.len()).filter(|&edge| selected[edge]).filter_map(hinge).collect()
}

/// The nodes with exactly two of the selected edges of lines, between the other ends of these.
fn chains(selected: &[bool], geometry: &Geometry) -> Vec<[u32; 3]> {
    let mut neighbours: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    let of_line = |edge: &usize| selected[*edge] && geometry.topology.edge_kind(*edge) == EdgeKind::Line;
    for [a, b] in (0..geometry.mesh.edges.len()).filter(of_line).map(|edge| geometry.mesh.edges[edge]) {
        neighbours.entry(a).or_default().push(b);
        neighbours.entry(b).or_default().push(a);
    }
    let between = neighbours.into_iter().filter_map(|(node, ends)| match ends[..] {
        [before, after] => Some([before, node, after]),
        _ => None,
    });
    between.collect()
}
