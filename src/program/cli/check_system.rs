//! What `check` says of the system: sizes in a line, and the model part by part.

use crate::case::spec::SystemSpec;
use crate::format_number::{counted, figures};
use crate::mesh::group::describe_groups;
use crate::model::gauge::{CANOPY_QUANTITIES, PROJECTED_RATIO};
use crate::model::group_totals::GroupTotals;
use crate::model::spec::{BendingSpec, CanopySpec, MembraneSpec, NetworkSpec};
use crate::scene::Scene;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Counts and mass in a line.
pub(super) fn describe_size(system: &SystemSpec, mass: f64) -> String {
    let mass = figures(mass, 4);
    match system {
        SystemSpec::Pendulum(p) => {
            format!("  size            a pendulum of {} m and {mass} kg\n", figures(p.length, 7))
        }
        SystemSpec::Network(spec) => {
            let NetworkSpec { mesh, fixed, springs, membranes, .. } = &**spec;
            let held = fixed.as_flattened().iter().filter(|f| **f).count();
            let n_springs = springs.iter().map(|group| group.edges.len() as u64).sum();
            let n_membranes: u64 = membranes.iter().map(|membrane| membrane.triangles.len() as u64).sum();
            let triangles = counted(mesh.triangles.len() as u64, "triangle", "triangles");
            let counts = [
                Some(counted(mesh.nodes.len() as u64, "node", "nodes")),
                (n_springs > 0 || n_membranes == 0).then(|| counted(n_springs, "spring", "springs")),
                Some(match n_membranes {
                    0 => triangles,
                    n if n == mesh.triangles.len() as u64 => format!("{triangles} of membrane"),
                    n => format!("{triangles}, {n} of them membrane"),
                }),
                Some(counted((3 * fixed.len() - held) as u64, "unknown", "unknowns")),
            ];
            format!("  size            {}, {mass} kg\n", counts.into_iter().flatten().collect::<Vec<_>>().join(", "))
        }
    }
}

/// The events that a run must find, a line each, and how many springs may break.
pub(super) fn describe_events(system: &SystemSpec) -> String {
    let SystemSpec::Network(spec) = system else { return String::new() };
    let mut text = String::new();
    for event in spec.events.iter().filter(|event| event.acts()) {
        let (name, what) = (&event.name, &event.what);
        let _ = writeln!(text, "  event           {name} ({what}): {}", event.moment(&spec.events));
    }
    let breaking: u64 = spec.springs.iter().map(|group| group.breaks.len() as u64).sum();
    if breaking > 0 {
        let _ = writeln!(text, "  breaks          {} at their strength", counted(breaking, "spring", "springs"));
    }
    text
}

/// [m^2] Drag areas of the full canopies, where a schedule gives them, and S0.
pub(super) fn filled_canopies(system: &SystemSpec) -> Vec<(Option<f64>, f64)> {
    let SystemSpec::Network(spec) = system else { return Vec::new() };
    let filled = |canopy: &CanopySpec| (canopy.air.stages().last().map(|stage| stage.drag_area), canopy.nominal_area);
    spec.canopies.iter().map(filled).collect()
}

/// Drag coefficient and size of every canopy in a line.
pub(super) fn describe_canopies(scene: &dyn Scene, filled: &[(Option<f64>, f64)]) -> String {
    let start = scene.initial_state();
    let place = CANOPY_QUANTITIES.iter().position(|quantity| *quantity == PROJECTED_RATIO);
    let mut text = String::new();
    for (i, (drag_area, nominal_area)) in filled.iter().enumerate() {
        let Some(values) = scene.air().map(|air| air.canopy_values(i, start.as_ref())) else { continue };
        let ratio = place.map_or(f64::NAN, |at| values[at]);
        let name = if filled.len() == 1 { "canopy".to_owned() } else { format!("canopy {i}") };
        let nominal = figures(*nominal_area, 4);
        let drag = drag_area.map_or_else(String::new, |area| {
            format!(", full drag area {} m^2: CD0 {}", figures(area, 4), figures(area / nominal_area, 3))
        });
        // A point has no shape.
        let shape = if ratio.is_nan() { String::new() } else { format!("; Dp/D0 {} at the start", figures(ratio, 3)) };
        let _ = writeln!(text, "  {name:<16}S0 {nominal} m^2{drag}{shape}");
    }
    text
}

pub(super) fn describe_system(text: &mut String, system: &SystemSpec, groups: &BTreeMap<String, GroupTotals>) {
    match system {
        SystemSpec::Pendulum(p) => {
            let _ = writeln!(
                text,
                "  pendulum        L = {} m, m = {} kg, c = {} N m s",
                figures(p.length, 12),
                figures(p.mass, 12),
                figures(p.damping, 12)
            );
        }
        SystemSpec::Network(spec) => {
            let NetworkSpec { mesh, mass, fixed, springs, .. } = &**spec;
            let n_springs: usize = springs.iter().map(|g| g.edges.len()).sum();
            let dashpots: usize = springs.iter().filter(|g| g.dashpot.is_some()).map(|g| g.edges.len()).sum();
            let held = fixed.as_flattened().iter().filter(|f| **f).count();
            let _ = writeln!(
                text,
                "  network         {} nodes, {n_springs} springs, {dashpots} dashpots, {} triangles",
                mesh.nodes.len(),
                mesh.triangles.len()
            );
            spec.membranes.iter().for_each(|membrane| describe_membrane(text, membrane));
            spec.bending.iter().for_each(|bending| describe_bending(text, bending));
            let _ = writeln!(text, "  mass            {} kg", figures(mass.iter().sum::<f64>(), 7));
            for (group, totals) in describe_groups(mesh).iter().zip(groups.values()) {
                let rest = match totals.rest_length {
                    0.0 => String::new(),
                    length => format!(", springs of {} m", figures(length, 7)),
                };
                let _ = writeln!(text, "  group           {group}{rest}, {} kg", figures(totals.mass, 7));
            }
            let _ = writeln!(text, "  unknowns        {} ({held} degrees of freedom held)", 3 * fixed.len() - held);
        }
    }
}

fn describe_membrane(text: &mut String, membrane: &MembraneSpec) {
    let MembraneSpec { triangles, thickness, modulus: [first, second], poisson, shear, warp, .. } = membrane;
    let triangles = counted(triangles.len() as u64, "triangle", "triangles");
    let [first, second, shear, poisson] = [*first, *second, *shear, *poisson].map(|value| figures(value, 4));
    let stiffness = match warp.is_some() {
        true => format!("E {first} Pa along the warp and {second} Pa across, nu {poisson}, G {shear} Pa"),
        false => format!("E {first} Pa, nu {poisson}"),
    };
    let wrinkles = if membrane.wrinkling { ", wrinkles" } else { "" };
    let damped = match membrane.damping_time {
        0.0 => String::new(),
        time => format!(", damped by {} s", figures(time, 4)),
    };
    let thickness = figures(*thickness, 4);
    let _ = writeln!(text, "  membrane        {triangles} of {thickness} m: {stiffness}{wrinkles}{damped}");
}

fn describe_bending(text: &mut String, bending: &BendingSpec) {
    let BendingSpec { hinges, stiffness, chains, flexural_rigidity } = bending;
    if !hinges.is_empty() {
        let edges = counted(hinges.len() as u64, "edge", "edges");
        let _ = writeln!(text, "  bending         {edges} of cloth of {} N m", figures(*stiffness, 4));
    }
    if !chains.is_empty() {
        let nodes = counted(chains.len() as u64, "node", "nodes");
        let _ = writeln!(text, "  bending         {nodes} of lines of {} N m^2", figures(*flexural_rigidity, 4));
    }
}
