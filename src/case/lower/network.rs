//! The network as a whole: supports, masses, and the sections put together.

use super::geometry::Geometry;
use super::initial::{self, initial};
use super::numbers::not_negative;
use super::{air, digits, energy, loads, mass, plausible, select, springs};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Damping, Network, Support};
use crate::drive::clock::Step;
use crate::format_number::first_few;
use crate::model::spec::{NetworkSpec, RayleighSpec};
use crate::preflight;
use crate::warning::WarningCode;

/// Checks and builds a network. Without a mesh the checks that need none still run.
pub(super) fn network(
    at: &Pointer,
    network: &Network,
    geometry: Option<&Geometry>,
    step: Option<Step>,
    faults: &mut Faults<'_>,
) -> Option<NetworkSpec> {
    let before = faults.count();
    let mut masses =
        geometry.map(|g| mass::mass(&at.key("mass"), network.mass.as_ref(), g, faults)).unwrap_or_default();
    let fixed = supports(&at.key("supports"), &network.supports, geometry, faults);
    let groups = springs::springs(&at.key("springs"), &network.springs, geometry, step, &mut masses, faults);
    let readable = |keys: &[&str], faults: &Faults<'_>| keys.iter().all(|key| faults.readable(&at.key(key)));
    let masses_known = faults.count() == before && readable(&["mass", "supports", "springs"], faults);
    let rayleigh = rayleigh(&at.key("damping"), network.damping.as_ref(), faults);
    let air = air::air(&at.key("aero"), network.aero.as_ref(), geometry, faults);
    let loads = loads::loads(&at.key("loads"), &network.loads, geometry, faults);
    let geometry = geometry?;
    // A faulty mass, support or spring section would be reported a second time as massless nodes.
    if masses_known {
        check_masses(at, &masses, &fixed, faults);
        warn_loose(&groups.iter().flat_map(|g| g.edges.iter().copied()).collect::<Vec<_>>(), &fixed, geometry, faults);
    }
    if fixed.iter().flatten().all(|held| *held) {
        let hint = "free at least one direction of one node".to_owned();
        faults.add_value(
            &at.key("supports"),
            "every node is held in x, y and z",
            "something that can move",
            Some(hint),
        );
    }
    let start = if readable(&["supports", "springs"], faults) {
        let against = initial::Network { geometry, fixed: &fixed, springs: &groups };
        initial(&at.key("initial"), network.initial.as_ref(), &against, faults)
    } else {
        initial::InitialState::default()
    };
    let spec = NetworkSpec {
        mesh: geometry.mesh.clone(),
        mass: masses,
        fixed,
        springs: groups,
        gravity: network.gravity,
        air,
        pressures: loads.pressures,
        forces: loads.forces,
        rayleigh,
        displacement: start.displacement,
        velocity: start.velocity,
    };
    if faults.count() == before {
        digits::network(at, &spec, geometry, step.and_then(Step::fixed), faults);
        energy::network(at, &spec, geometry, faults);
    }
    plausible::network(at, &spec, geometry, faults);
    if let Some(aero) = network.aero.as_ref().filter(|_| faults.count() == before) {
        plausible::pressure(&at.key("aero").key("law"), &aero.law, &spec, faults);
    }
    if faults.count() == before {
        let step = step.and_then(Step::fixed);
        preflight::network(&spec, &geometry.topology, step).into_iter().for_each(|warning| faults.pass_on(warning));
    }
    Some(spec)
}

/// Which of x, y, z is held, `[n_nodes][3]`. Several supports of a node add up.
fn supports(at: &Pointer, list: &[Support], geometry: Option<&Geometry>, faults: &mut Faults<'_>) -> Vec<[bool; 3]> {
    let mut fixed = vec![[false; 3]; geometry.map_or(0, Geometry::nodes)];
    for (i, support) in list.iter().enumerate() {
        let at = at.index(i);
        let directions = directions(&support.fix);
        if directions.is_none() {
            faults.add(&at.key("fix"), "one or more of the letters x, y and z, each once, such as \"xyz\" or \"z\"");
        }
        let nodes = geometry.and_then(|g| select::nodes(&at.key("on"), &support.on, g, faults));
        if let (Some(directions), Some(nodes)) = (directions, nodes) {
            for node in nodes {
                if let Some(held) = fixed.get_mut(node as usize) {
                    held.iter_mut().zip(directions).for_each(|(held, more)| *held |= more);
                }
            }
        }
    }
    fixed
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

fn rayleigh(at: &Pointer, section: Option<&Damping>, faults: &mut Faults<'_>) -> Option<RayleighSpec> {
    let rayleigh = section?.rayleigh;
    let at = at.key("rayleigh");
    let mass = not_negative(&at.key("mass"), rayleigh.mass, faults);
    let stiffness = not_negative(&at.key("stiffness"), rayleigh.stiffness, faults);
    let none = rayleigh.mass == 0.0 && rayleigh.stiffness == 0.0;
    (mass && stiffness && !none).then_some(rayleigh)
}

/// Every node that can move needs a mass with a finite inverse.
fn check_masses(at: &Pointer, mass: &[f64], fixed: &[[bool; 3]], faults: &mut Faults<'_>) {
    let free = |i: u32| fixed.get(i as usize).is_some_and(|f| f.contains(&false));
    let numbered = mass.iter().zip(0_u32..);
    let bad: Vec<u32> = numbered.filter(|(m, i)| free(*i) && !m.is_normal()).map(|(_, i)| i).collect();
    if let Some(first) = bad.first() {
        let value =
            format!("no usable mass on free nodes {} ({} kg on the first)", first_few(&bad), mass[*first as usize]);
        let hint =
            "give areal_density (for nodes of triangles), nodal, or linear_density of a spring rule, or hold them";
        faults.add_value(&at.key("mass"), value, "a mass above 0 on every node that can move", Some(hint.to_owned()));
    }
}

/// Free nodes without a spring: seldom intended, except for a falling mass.
fn warn_loose(edges: &[u32], fixed: &[[bool; 3]], geometry: &Geometry, faults: &mut Faults<'_>) {
    let mut loose: Vec<bool> = fixed.iter().map(|f| f.contains(&false)).collect();
    for node in edges.iter().filter_map(|e| geometry.mesh.edges.get(*e as usize)).flatten() {
        if let Some(flag) = loose.get_mut(*node as usize) {
            *flag = false;
        }
    }
    let loose: Vec<u32> = loose.iter().zip(0_u32..).filter(|(loose, _)| **loose).map(|(_, i)| i).collect();
    if !loose.is_empty() {
        faults.warn(WarningCode::LooseNodes, format!("no spring holds the free nodes {}", first_few(&loose)));
    }
}
