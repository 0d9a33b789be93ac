//! The network as a whole: supports, masses, and the sections put together.

use super::air::{self, Flow};
use super::events::{self, Plan, Sights};
use super::geometry::Geometry;
use super::glide;
use super::initial::{self, EarlierRun, initial};
use super::numbers::series;
use super::point::{Whole, point};
use super::springs::SpringSources;
use super::supports::{Supports, supports};
use super::{canopy, contact, digits, energy, gas, loads, mass, plausible, springs, surface};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{CutRule, Damping, Network, NetworkModel, Until, VectorTable, vectors};
use crate::drive::clock::Step;
use crate::format_number::first_few;
use crate::mesh::{Mesh, Topology};
use crate::model::spec::{ContactSide, ContactSpec, NetworkSpec, RayleighSpec, Series, support_velocity};
use crate::preflight;
use crate::warning::{Warning, WarningCode};
use std::collections::BTreeSet;
use std::path::Path;

/// Checks and builds a network, or a point in its place, and then the network that it stands for; files are found from
/// the folder `base`. Without a mesh the checks that need none still run.
pub(super) fn network(
    network: &Network,
    base: &Path,
    geometry: Option<&Geometry>,
    (step, until): (Option<Step>, Option<&Until>),
    faults: &mut Faults<'_>,
) -> Option<(NetworkSpec, Option<Whole>)> {
    let at = &Pointer::root().key("system").key("network");
    let before = faults.count();
    let plan = &Plan::of(at, network, until);
    let mut masses =
        geometry.map(|g| mass::mass(&at.key("mass"), network.mass.as_ref(), g, faults)).unwrap_or_default();
    let Supports { fixed, releases, motions } =
        supports(&at.key("supports"), &network.supports, geometry, plan, faults);
    let membranes = surface::membranes(&at.key("membranes"), &network.membranes, geometry, faults);
    let bending = surface::bending(&at.key("bending"), &network.bending, geometry, faults);
    let readable = |keys: &[&str], faults: &Faults<'_>| keys.iter().all(|key| faults.readable(&at.key(key)));
    let start_known = readable(&["supports", "springs"], faults);
    let earlier = geometry.zip(network.initial.as_ref()).filter(|_| start_known).and_then(|(geometry, section)| {
        initial::earlier(&at.key("initial"), section, (geometry, &fixed, base), faults)
    });
    let (earlier, prestress) = earlier.map(EarlierRun::split).unzip();
    let prestress = prestress.flatten();
    let sources = SpringSources { rules: &network.springs, membranes: &membranes, step, prestress, plan };
    let groups = springs::springs(&at.key("springs"), sources, geometry, &mut masses, faults);
    let masses_known = faults.count() == before && readable(&["mass", "supports", "springs", "membranes"], faults);
    let rayleigh = rayleigh(network.damping.as_ref());
    let Flow { air, surface_pressures, stream, mut canopies, line_drag, node_drag } =
        air::flow(&at.key("aero"), network.aero.as_ref(), (base, plan), geometry, faults);
    plan.put_into(&mut canopies);
    glide::refuse_nets(at, network, faults);
    let base_acceleration = base_acceleration(at, network, faults);
    let loads = loads::loads(&at.key("loads"), &network.loads, network.gravity, geometry, faults);
    let geometry = geometry?;
    let mut at_last = fixed.clone();
    releases.iter().for_each(|release| release.apply(&mut at_last));
    // A faulty mass, support or spring section would be reported a second time as massless nodes.
    if masses_known {
        check_masses(at, &masses, &at_last, &geometry.mesh, faults);
    }
    if motions.is_empty() && at_last.iter().flatten().all(|held| *held) {
        let hint = "free at least one direction of one node, from the start or with \"until\", or move a support";
        let value = "every node is held in x, y and z";
        faults.add_value(&at.key("supports"), value, "something that can move", Some(hint.to_owned()));
    }
    let gases = gas::gases(&at.key("gas"), network.gas.as_ref(), (geometry, &at_last, &motions), faults);
    let start = if start_known {
        let moved = &support_velocity(&motions, fixed.len());
        let against = initial::Network { geometry, fixed: &fixed, moved, springs: &groups };
        initial(&at.key("initial"), network.initial.as_ref(), earlier, &against, faults)
    } else {
        initial::InitialState::default()
    };
    let mut springs = vec![false; geometry.mesh.edges.len()];
    for edge in groups.iter().flat_map(|group| &group.edges) {
        springs.get_mut(*edge as usize).into_iter().for_each(|spring| *spring = true);
    }
    let has_spring = &|edge: u32| springs.get(edge as usize) == Some(&true);
    let contacts = {
        let moved: BTreeSet<u32> = motions.iter().flat_map(|motion| &motion.nodes).map(|(node, _)| *node).collect();
        let moves = &|node: u32| at_last.get(node as usize) != Some(&[true; 3]) || moved.contains(&node);
        let scene = contact::Scene { geometry, base, has_spring, displacement: &start.displacement, moves };
        contact::contacts(&at.key("contact"), &network.contact, &scene, faults)
    };
    if masses_known {
        let mesh = &geometry.mesh;
        let ends = mesh.edges.iter().zip(&springs).filter(|(_, spring)| **spring).flat_map(|(ends, _)| ends);
        let triangles = membranes.iter().flat_map(|m| &m.triangles).filter_map(|t| mesh.triangles.get(*t as usize));
        let held = ends.chain(triangles.flatten()).copied();
        warn_loose(held.chain(touching(&contacts, mesh)), &at_last, faults);
    }
    let sights = Sights { geometry, mass: &masses, has_spring, air: stream.is_some() };
    let events = events::events(plan, sights, faults);
    let mut spec = NetworkSpec {
        mesh: geometry.mesh.clone(),
        mass: masses,
        fixed,
        releases,
        events,
        motions,
        springs: groups,
        membranes,
        bending,
        gravity: network.gravity,
        base_acceleration,
        air,
        surface_pressures,
        stream,
        canopies,
        line_drag,
        node_drag,
        gases,
        contacts,
        pressures: loads.pressures,
        forces: loads.forces,
        rayleigh,
        mass_scaling: None,
        displacement: start.displacement,
        velocity: start.velocity,
    };
    if faults.count() == before {
        digits::network(at, &spec, geometry, step.and_then(Step::fixed), faults);
        energy::network(at, &spec, geometry, faults);
    }
    if faults.count() == before {
        canopy::at_start(&at.key("aero"), network.aero.as_ref(), &mut spec, faults);
    }
    plausible::network(at, &spec, geometry, faults);
    let law = network.aero.as_ref().and_then(|aero| aero.law.as_ref());
    if let Some(law) = law.filter(|_| faults.count() == before) {
        plausible::pressure(&at.key("aero").key("law"), law, &spec, faults);
    }
    if faults.count() > before {
        return Some((spec, None));
    }
    let step = step.and_then(Step::fixed);
    let warn = |spec: &NetworkSpec, topology: &Topology, faults: &mut Faults<'_>| {
        let told = |warning: &Warning| warning.code == WarningCode::LargeExtent && geometry.extent_is_told();
        let found = preflight::network(spec, topology, step).into_iter().filter(|warning| !told(warning));
        found.chain(geometry.y_is_up(spec.gravity)).for_each(|warning| faults.pass_on(warning));
    };
    let Some(NetworkModel::Point) = network.model else {
        warn(&spec, &geometry.topology, faults);
        return Some((spec, None));
    };
    let (spec, whole) = point(at, &spec, faults)?;
    let topology = Topology::new(&spec.mesh).ok()?;
    warn(&spec, &topology, faults);
    Some((spec, Some(whole)))
}

/// [m/s^2] The acceleration of the base.
fn base_acceleration(at: &Pointer, network: &Network, faults: &mut Faults<'_>) -> Option<Series<[f64; 3]>> {
    let VectorTable { table } = network.base_acceleration.as_ref()?;
    let at = at.key("base_acceleration");
    if network.aero.is_some() {
        let hint = "velocities are relative to the base, and the air does not move with it; give the supports a motion";
        faults.add_value(&at, "an accelerated base in air", "only without aero", Some(hint.to_owned()));
    }
    series(&at.key("table"), vectors(table), faults)
}

/// Warns of events that a run until `end` [s] does not reach.
pub(super) fn warn_of_events(at: &Pointer, network: &Network, end: f64, faults: &mut Faults<'_>) {
    let supports = network.supports.iter().enumerate();
    let supports = supports.map(|(i, support)| (at.key("supports").index(i).key("until"), support.until));
    let springs = network.springs.iter().enumerate();
    let springs =
        springs.map(|(i, rule)| (at.key("springs").index(i).key("cut"), rule.cut.as_ref().and_then(CutRule::last)));
    let named = Plan::of(at, network, None);
    for (at, t) in supports.chain(springs).chain(named.times()) {
        if t.is_some_and(|t| t.is_finite() && t >= end) {
            let text = format!("{at}: the run ends at {end} s, before this happens");
            faults.warn(WarningCode::EventBeyondEnd, text);
        }
    }
}

fn rayleigh(section: Option<&Damping>) -> Option<RayleighSpec> {
    section.map(|section| section.rayleigh).filter(|rayleigh| rayleigh.mass != 0.0 || rayleigh.stiffness != 0.0)
}

/// Every node that can move needs a mass with a finite inverse.
fn check_masses(at: &Pointer, mass: &[f64], fixed: &[[bool; 3]], mesh: &Mesh, faults: &mut Faults<'_>) {
    let free = |i: u32| fixed.get(i as usize).is_some_and(|f| f.contains(&false));
    let numbered = mass.iter().zip(0_u32..);
    let bad: Vec<u32> = numbered.filter(|(m, i)| free(*i) && !m.is_normal()).map(|(_, i)| i).collect();
    if let Some(first) = bad.first() {
        let value =
            format!("no usable mass on free nodes {} ({} kg on the first)", first_few(&bad), mass[*first as usize]);
        let of_bag = |node: &u32| mesh.groups.get("bag").is_some_and(|bag| bag.nodes.contains(node));
        let hint = if bad.iter().all(of_bag) {
            "the bag of a pack: add {\"on\": {\"group\": \"bag\"}, \"mass\": ...} to mass.points, or hold it by a support"
        } else {
            "give areal_density (for nodes of triangles), nodal, or linear_density of a spring rule, or hold them"
        };
        faults.add_value(&at.key("mass"), value, "a mass above 0 on every node that can move", Some(hint.to_owned()));
    }
}

/// The nodes of all parts that may touch.
fn touching<'a>(contacts: &'a [ContactSpec], mesh: &'a Mesh) -> impl Iterator<Item = u32> + 'a {
    let sides = contacts.iter().flat_map(|contact| {
        let other = if let ContactSide::Parts(other) = &contact.other { Some(other) } else { None };
        [&contact.parts].into_iter().chain(other)
    });
    sides.flat_map(move |parts| {
        let of_triangles = parts.triangles.iter().filter_map(|t| mesh.triangles.get(*t as usize)).flatten();
        let of_edges = parts.edges.iter().filter_map(|e| mesh.edges.get(*e as usize)).flatten();
        of_triangles.chain(of_edges).chain(&parts.nodes).copied()
    })
}

/// Free nodes without a spring, a membrane or a contact: seldom intended, except for a falling mass.
fn warn_loose(held: impl Iterator<Item = u32>, fixed: &[[bool; 3]], faults: &mut Faults<'_>) {
    let mut loose: Vec<bool> = fixed.iter().map(|f| f.contains(&false)).collect();
    for node in held {
        if let Some(flag) = loose.get_mut(node as usize) {
            *flag = false;
        }
    }
    let loose: Vec<u32> = loose.iter().zip(0_u32..).filter(|(loose, _)| **loose).map(|(_, i)| i).collect();
    if !loose.is_empty() {
        faults.warn(WarningCode::LooseNodes, format!("no spring holds the free nodes {}", first_few(&loose)));
    }
}
