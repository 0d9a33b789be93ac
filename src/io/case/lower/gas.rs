//! Gas in closed volumes: what fills it, and whether its triangles close it.

use super::geometry::{Geometry, TriangleUse, triangles};
use super::numbers::series;
use super::select;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Gas, OneOrSeveral, OverTime, ValueTable};
use crate::format_number::first_few;
use crate::model::spec::{GasFill, GasSpec, MotionSpec, Series};
use std::collections::{BTreeMap, BTreeSet};

/// Checks and resolves the section; `held` says which directions are held for ever, `[n_nodes][3]`.
pub(super) fn gases(
    at: &Pointer,
    given: Option<&OneOrSeveral<Gas>>,
    (geometry, held, motions): (&Geometry, &[[bool; 3]], &[MotionSpec]),
    faults: &mut Faults<'_>,
) -> Vec<GasSpec> {
    let list = given.map_or(&[][..], OneOrSeveral::all);
    let several = matches!(given, Some(OneOrSeveral::Several(_)));
    let mut found: Vec<GasSpec> = Vec::new();
    for (i, gas) in list.iter().enumerate() {
        let at = if several { at.index(i) } else { at.clone() };
        let fill = fill(&at, gas, faults);
        if !triangles(&at, "a gas", geometry, TriangleUse::Normals, faults) {
            continue;
        }
        let Some(around) = select::triangles(&at.key("on"), &gas.on, geometry, faults) else { continue };
        if let Some(same) = found.iter().position(|earlier| earlier.triangles == around) {
            let value = format!("the triangles of gas {same} again");
            let hint = "one volume holds one gas: give it the pressure or the amount of both";
            faults.add_value(&at.key("on"), value, "triangles of a volume of its own", Some(hint.to_owned()));
        }
        if let Some(fault) = unclosed(geometry, &around) {
            let hint = "\"orient\" of a mesh file turns triangles alike; select those around one volume only";
            faults.add_value(&at.key("on"), fault, "triangles that close one volume", Some(hint.to_owned()));
            continue;
        }
        let moved: BTreeSet<u32> = motions.iter().flat_map(|motion| &motion.nodes).map(|(node, _)| *node).collect();
        let free = |node: &u32| held.get(*node as usize) != Some(&[true; 3]) || moved.contains(node);
        let open: Vec<u32> = open_nodes(geometry, &around).into_iter().filter(free).collect();
        if !open.is_empty() {
            let value = format!("a surface that is open at the nodes {}, which can move", first_few(&open));
            let hint = "close the surface, or hold the whole rim in x, y and z as on the ground, without a motion";
            faults.add_value(&at.key("on"), value, "triangles that close a volume", Some(hint.to_owned()));
        }
        let Gas { gamma, ambient, volume, .. } = *gas;
        found.extend(fill.map(|fill| GasSpec { triangles: around, ambient, gamma, volume, fill }));
    }
    found
}

/// Why some triangles have no inside: an edge between two that turn opposite ways, or one with an odd number of them
/// beside it. Edges of one triangle are a rim.
fn unclosed(geometry: &Geometry, triangles: &[u32]) -> Option<String> {
    let mut beside: BTreeMap<[u32; 2], [Vec<u32>; 2]> = BTreeMap::new();
    for &triangle in triangles {
        let Some(&[a, b, c]) = geometry.mesh.triangles.get(triangle as usize) else { continue };
        for [from, to] in [[a, b], [b, c], [c, a]] {
            let ways = beside.entry([from.min(to), from.max(to)]).or_default();
            ways[usize::from(from > to)].push(triangle);
        }
    }
    beside.into_iter().find_map(|([a, b], ways)| {
        let [forward, backward] = ways.each_ref().map(Vec::len);
        let mut all = ways.concat();
        all.sort_unstable();
        let all = first_few(&all);
        match forward + backward {
            _ if forward == backward => None,
            1 => None,
            n if n % 2 == 0 => Some(format!("triangles {all} at the edge {a}-{b}, which turn opposite ways")),
            n => Some(format!("{n} triangles ({all}) at the edge {a}-{b}")),
        }
    })
}

/// The nodes of edges that only one of some triangles has, ascending.
fn open_nodes(geometry: &Geometry, triangles: &[u32]) -> BTreeSet<u32> {
    let corners = triangles.iter().filter_map(|t| geometry.mesh.triangles.get(*t as usize));
    let sides = corners.flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let all: BTreeSet<[u32; 2]> = sides.collect();
    all.iter().filter(|[a, b]| !all.contains(&[*b, *a])).flatten().copied().collect()
}

/// What fills a volume; amounts and absolute pressures are above 0.
fn fill(at: &Pointer, gas: &Gas, faults: &mut Faults<'_>) -> Option<GasFill> {
    match (&gas.pressure, &gas.amount) {
        (Some(pressure), None) => {
            let at = at.key("pressure");
            let least = format!("pressures above that of a vacuum, -{} Pa", gas.ambient);
            over_time(&at, pressure, (-gas.ambient, &least), faults).map(GasFill::Pressure)
        }
        (None, Some(amount)) => {
            over_time(&at.key("amount"), amount, (0.0, "amounts above 0"), faults).map(GasFill::Amount)
        }
        (pressure, _) => {
            let value = if pressure.is_some() { "a gas with pressure and amount" } else { "a gas that nothing fills" };
            faults.add_value(at, value, "exactly one of pressure and amount", None);
            None
        }
    }
}

/// A table of values above `least`, which `allowed` says in words.
fn over_time(
    at: &Pointer,
    given: &OverTime,
    (least, allowed): (f64, &str),
    faults: &mut Faults<'_>,
) -> Option<Series<f64>> {
    let table = match given {
        OverTime::Constant(value) if *value > least => return Some(Series { t: vec![0.0], value: vec![*value] }),
        OverTime::Constant(_) => {
            faults.add(at, allowed);
            return None;
        }
        OverTime::Table(ValueTable { table }) => table,
    };
    let at = at.key("table");
    let before = faults.count();
    table.iter().enumerate().filter(|(_, [_, value])| *value <= least).for_each(|(i, _)| {
        faults.add(&at.index(i), allowed);
    });
    let found = series(&at, table.iter().map(|[t, value]| (*t, *value)), faults);
    found.filter(|_| faults.count() == before)
}
