//! Supports: what they hold, until when, and how they move it.

use super::events::{Plan, Waits};
use super::geometry::Geometry;
use super::numbers::series;
use super::select;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Support, VectorTable, vectors};
use crate::format_number::{figures, first_few};
use crate::model::spec::{MotionSpec, ReleaseSpec, Series};

/// What supports hold.
pub(super) struct Supports {
    /// which of x, y, z is held at the start, `[n_nodes][3]`
    pub fixed: Vec<[bool; 3]>,
    /// what becomes free later, in the order of time
    pub releases: Vec<ReleaseSpec>,
    /// what is moved
    pub motions: Vec<MotionSpec>,
}

/// What holds a direction of a node.
#[derive(Clone, Copy, Debug, Default)]
struct Hold {
    /// [s] until when; 0 where it is free
    until: f64,
    /// number of the first support that holds it
    first: Option<u32>,
}

/// Which directions are held, and until when. Several supports of a node add up: the last to let go counts. One that
/// moves a direction is alone.
pub(super) fn supports(
    at: &Pointer,
    list: &[Support],
    geometry: Option<&Geometry>,
    plan: &Plan<'_>,
    faults: &mut Faults<'_>,
) -> Supports {
    let mut holds = vec![[Hold::default(); 3]; geometry.map_or(0, Geometry::nodes)];
    let (mut motions, mut by_event) = (Vec::new(), Vec::new());
    // Why each support must be alone, if it must.
    let mut alone = Vec::with_capacity(list.len());
    for (i, support) in list.iter().enumerate() {
        let at = at.index(i);
        let directions = directions(&support.fix);
        if directions.is_none() {
            faults.add(&at.key("fix"), "one or more of the letters x, y and z, each once, such as \"xyz\" or \"z\"");
        }
        if support.until.is_some() && support.when.is_some() {
            faults.add_hint(&at.key("when"), "not together with until", "a time is \"when\": {\"time\": ...} too");
        }
        let displacement =
            support.motion.as_ref().and_then(|table| motion(&at.key("motion"), table, directions, faults));
        let settlement = settlement(&at.key("settlement"), support.settlement, directions, faults);
        let nodes = geometry.and_then(|g| select::nodes(&at.key("on"), &support.on, g, faults));
        let moves = support.motion.is_some() || support.settlement.is_some();
        // A direction that moves, or that an event frees, has one support.
        alone.push(match &support.when {
            _ if moves => Some("where it moves"),
            Some(_) => Some("that an event releases"),
            None => None,
        });
        if let (Some(directions), Some(nodes)) = (directions, nodes) {
            // A stand-in may be for any nodes and directions.
            let known = faults.readable(&at.key("on")) && faults.readable(&at.key("fix"));
            let by = Hold { until: support.until.unwrap_or(f64::INFINITY), first: known.then_some(i as u32) };
            hold(&at, &mut holds, Held { nodes: &nodes, directions, by, alone: &alone }, faults);
            if let Some(event) = plan.event(Waits::Support(i)) {
                let nodes = nodes.iter().map(|&node| (node, directions)).collect();
                by_event.push(ReleaseSpec { t: f64::INFINITY, event: Some(event), nodes });
            }
            let still = || Series { t: vec![0.0], value: vec![[0.0; 3]] };
            let displacement = displacement.or_else(|| support.motion.is_none().then(still)).filter(|_| moves);
            motions.extend(displacement.map(|displacement| {
                let nodes = nodes.into_iter().map(|node| (node, directions)).collect();
                MotionSpec { nodes, displacement, settlement }
            }));
        }
    }
    let fixed = holds.iter().map(|node| node.map(|hold| hold.until > 0.0)).collect();
    let mut releases = releases(&holds);
    releases.extend(by_event);
    Supports { fixed, releases, motions }
}

/// What a support holds.
#[derive(Clone, Copy, Debug)]
struct Held<'a> {
    nodes: &'a [u32],
    directions: [bool; 3],
    by: Hold,
    /// why each support so far must be alone, if it must
    alone: &'a [Option<&'static str>],
}

/// Adds a support to what holds these nodes.
fn hold(at: &Pointer, holds: &mut [[Hold; 3]], support: Held<'_>, faults: &mut Faults<'_>) {
    let Held { nodes, directions, by, alone } = support;
    let why = |number: u32| alone.get(number as usize).copied().flatten();
    let mut shared: Vec<u32> = Vec::new();
    let mut other = None;
    for &node in nodes {
        let held = holds.get_mut(node as usize).into_iter().flatten();
        for (held, _) in held.zip(directions).filter(|(_, more)| *more) {
            if let (Some(number), Some(now)) = (held.first, by.first)
                && let Some(why) = why(number).or_else(|| why(now))
            {
                shared.push(node);
                other.get_or_insert((number, why));
            }
            *held = Hold { until: held.until.max(by.until), first: held.first.or(by.first) };
        }
    }
    shared.dedup();
    if let Some((other, why)) = other {
        let value = format!("nodes {} are held by supports[{other}] too", first_few(&shared));
        let allowed = format!("one support for each direction of a node {why}");
        faults.add_value(at, value, allowed, Some("leave them out of one of the two".to_owned()));
    }
}

/// [m] The settlement, 0 without any.
fn settlement(
    at: &Pointer,
    given: Option<[f64; 3]>,
    directions: Option<[bool; 3]>,
    faults: &mut Faults<'_>,
) -> [f64; 3] {
    let given = given.unwrap_or_default();
    for (axis, held) in directions.unwrap_or([true; 3]).iter().enumerate() {
        if !held && given[axis] != 0.0 {
            not_held(&at.index(axis), axis, faults);
        }
    }
    given
}

fn not_held(at: &Pointer, axis: usize, faults: &mut Faults<'_>) {
    let allowed = format!("0 in {}, a direction that this support does not hold", ["x", "y", "z"][axis]);
    faults.add_hint(at, allowed, "name the direction in \"fix\"");
}

/// [m] The displacement over time.
fn motion(
    at: &Pointer,
    VectorTable { table }: &VectorTable,
    directions: Option<[bool; 3]>,
    faults: &mut Faults<'_>,
) -> Option<Series<[f64; 3]>> {
    let at = at.key("table");
    let before = faults.count();
    for (i, row) in table.iter().enumerate() {
        for (axis, held) in directions.unwrap_or([true; 3]).iter().enumerate() {
            if !held && row[axis + 1] != 0.0 {
                not_held(&at.index(i).index(axis + 1), axis, faults);
            }
        }
    }
    let displacement = series(&at, vectors(table), faults)?;
    let start = displacement.at(0.0);
    if start != [0.0; 3] {
        let [x, y, z] = start.map(|d| figures(d, 4));
        let value = format!("a displacement of ({x}, {y}, {z}) m at t = 0");
        let hint = "displacements count from t = 0; where a node begins is said by initial.displacement".to_owned();
        faults.add_value(&at, value, "no displacement at t = 0", Some(hint));
    }
    (faults.count() == before).then_some(displacement)
}

fn releases(holds: &[[Hold; 3]]) -> Vec<ReleaseSpec> {
    let ends = || holds.as_flattened().iter().map(|hold| hold.until);
    let mut times: Vec<f64> = ends().filter(|t| *t > 0.0 && t.is_finite()).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let release = |t: f64| {
        let free = (0_u32..).zip(holds).map(|(node, holds)| (node, holds.map(|hold| hold.until == t)));
        ReleaseSpec { t, event: None, nodes: free.filter(|(_, free)| free.contains(&true)).collect() }
    };
    times.into_iter().map(release).collect()
}

fn directions(fix: &str) -> Option<[bool; 3]> {
    let mut held = [false; 3];
    for letter in fix.chars() {
        let flag = &mut held["xyz".find(letter)?];
        if *flag {
            return None;
        }
        *flag = true;
    }
    held.contains(&true).then_some(held)
}
