//! From the structs of the file to the plain data of a run. Each section is checked where it is built, so that a check
//! is next to the code that relies on it. Faults are collected, not returned.

mod air;
mod canopy;
mod coefficients;
mod contact;
mod cut;
mod digits;
mod elastic_law;
mod energy;
mod events;
mod expand;
mod filling;
mod gas;
pub(crate) mod geometry;
mod glide;
mod initial;
mod loads;
mod mass;
mod network;
mod numbers;
mod output;
mod plausible;
mod point;
mod prestress;
mod rings;
mod select;
mod springs;
mod stages;
mod stiffness;
mod supports;
mod surface;
mod tables;
mod time;
mod wind;
mod zones;

use std::path::Path;
use std::sync::Arc;

use super::diagnostics::Faults;
use super::materials::{self, MaterialTable};
use super::pointer::Pointer;
use super::schema::{CaseFile, System};
use super::spec::{GaugeOf, GaugeSpec, Problem, SystemSpec};
use crate::format_number::figures;
use crate::integrate::registry::Family;
use crate::model::gauge::SpringGauge;
use crate::model::spec::{NetworkSpec, PendulumSpec, SpringGroup, StrengthSpec};
use crate::preflight;
use geometry::Geometry;

/// The data of a run, and the geometry for the next case of a study.
pub(crate) type LoweredCase = (Problem, Option<Arc<Geometry>>);

/// Checks and builds a case. `None` means that there are faults; there may be faults without it.
pub(crate) fn build(
    file: &CaseFile,
    base: &Path,
    known: Option<Arc<Geometry>>,
    faults: &mut Faults<'_>,
) -> Option<LoweredCase> {
    let root = Pointer::root();
    name(&root.key("name"), &file.name, faults);
    let timing = time::time(&file.time, &file.system, faults);
    let solver = time::solver(file.solver.as_ref());
    let quantities = time::study(file.study.as_ref(), faults);
    let at = root.key("system");
    let (mut whole, mut expanded) = (None, None);
    let (system, geometry) = match &file.system {
        // A stand-in, because the intended system is not known.
        _ if faults.unread(&at) => (None, None),
        System::Pendulum(pendulum) => {
            check_pendulum(&at.key("pendulum"), pendulum, faults);
            let step = timing.as_ref().and_then(|t| t.spec.step.fixed());
            preflight::pendulum(pendulum, step).into_iter().for_each(|warning| faults.pass_on(warning));
            (Some(SystemSpec::Pendulum(*pendulum)), None)
        }
        System::Network(network) => {
            let at = at.key("network");
            let source = expand::source(&network.mesh);
            let geometry = geometry::geometry(&at.key("mesh"), &source, base, known, faults);
            let (table, before) = (MaterialTable::of(file.materials.as_ref()), faults.count());
            materials::check(file.materials.as_ref(), faults);
            expanded = expand::network(&at, network, &source, geometry.as_deref(), table, faults);
            // What follows from a material that is not known is no fault of the user's.
            let known = faults.count() == before;
            let network = expanded.as_ref().map_or(&**network, |expanded| &expanded.network);
            let step = timing.as_ref().map(|t| t.spec.step);
            if let Some(timing) = &timing {
                network::warn_of_events(&at, network, timing.spec.end, faults);
            }
            let run = (step, file.time.until.as_ref());
            let lowered = known.then(|| network::network(network, base, geometry.as_deref(), run, faults)).flatten();
            let (spec, of_point) = lowered.map_or((None, None), |(spec, whole)| (Some(spec), whole));
            whole = of_point;
            let fixed =
                timing.as_ref().and_then(|t| Some(tables::StepTimes { h: t.spec.step.fixed()?, end: t.spec.end }));
            if let (Some(spec), Some(times)) = (&spec, fixed) {
                tables::warn_of_short_pulses(&at, network, spec, times, faults);
            }
            if let (Some(spec), Some(timing)) = (&spec, &timing) {
                let long = preflight::canopies::filling(spec, timing.spec.end);
                long.into_iter().for_each(|warning| faults.pass_on(warning.into()));
                if timing.method.info.family == Family::Implicit {
                    let slack = preflight::events::slack_openings(spec);
                    slack.into_iter().for_each(|warning| faults.pass_on(warning.into()));
                }
            }
            let mass_scaling = timing.as_ref().and_then(|timing| timing.mass_scaling);
            (spec.map(|spec| SystemSpec::Network(Box::new(NetworkSpec { mass_scaling, ..spec }))), geometry)
        }
    };
    let nodes = match &system {
        Some(SystemSpec::Pendulum(_)) => select::NodeSet::Bob,
        _ => match (geometry.as_deref(), &whole) {
            (None, _) => select::NodeSet::Unknown,
            (Some(geometry), None) => select::NodeSet::Mesh(geometry),
            (Some(geometry), Some(whole)) => select::NodeSet::Point(geometry, whole),
        },
    };
    let (groups, strengths) = match &system {
        Some(SystemSpec::Network(spec)) => (Some(&spec.springs[..]), strengths(spec)),
        _ => (None, Vec::new()),
    };
    let (membranes, gases) = match &system {
        Some(SystemSpec::Network(spec)) => (Some(&spec.membranes[..]), Some(&spec.gases[..])),
        _ => (None, None),
    };
    // Those of the file: one with a fault has its number too.
    let contacts = if let System::Network(network) = &file.system { network.contact.len() } else { 0 };
    let scene = output::Measurable { nodes, springs: groups, membranes, gases, contacts };
    let output = output::output(file.output.as_ref(), scene, timing.as_ref().map(|t| t.spec), faults);
    let output = output.map(|mut output| {
        output.gauges.extend(strengths);
        output.quantities = quantities;
        if let (Some(SystemSpec::Network(spec)), System::Network(network), Some(timing)) =
            (&system, &file.system, &timing)
        {
            let geometry = geometry.as_deref().filter(|_| whole.is_none());
            output.stages = stages::stages(network, spec, geometry, timing.spec.end);
        }
        output
    });
    let timing = timing?;
    let (expanded, taken) = expanded.map_or((None, Vec::new()), |found| (Some(Arc::new(found.network)), found.taken));
    let problem = Problem {
        name: file.name.clone(),
        system: system?,
        method: timing.method,
        time: timing.spec,
        solver,
        output: output?,
        warnings: Vec::new(),
        acknowledged: Vec::new(),
        acknowledge: file.acknowledge.clone(),
        case_json: serde_json::Value::Null,
        expanded,
        taken,
    };
    Some((problem, geometry))
}

/// Gauges for the springs with a strength; those that stand for several strands have gauges of their own.
fn strengths(spec: &NetworkSpec) -> Vec<GaugeSpec> {
    let gauges = |(rule, group): (usize, &SpringGroup)| {
        let StrengthSpec { name, strength, strands } = group.strength.clone()?;
        let gauge = move |name: String, edges: Vec<u32>, strands: f64| {
            let strength = Some(strands * strength);
            let of = GaugeOf::Springs { of: SpringGauge::Tension, edges, rule: Some(rule), strength };
            GaugeSpec { name, of, every: 1 }
        };
        let Some(strands) = strands else { return Some(vec![gauge(name, group.edges.clone(), 1.0)]) };
        let mut counts = strands.clone();
        counts.sort_by(f64::total_cmp);
        counts.dedup();
        let of_count = |count: f64| {
            let members = group.edges.iter().zip(&strands).filter(|(_, strands)| **strands == count);
            let name = if count == 1.0 { name.clone() } else { format!("{name} ({} strands)", figures(count, 3)) };
            gauge(name, members.map(|(edge, _)| *edge).collect(), count)
        };
        Some(counts.into_iter().map(of_count).collect())
    };
    spec.springs.iter().enumerate().filter_map(gauges).flatten().collect()
}

/// A name that is usable in a file name, a table and a title.
fn name(at: &Pointer, name: &str, faults: &mut Faults<'_>) {
    let length = name.chars().count();
    if name.trim().is_empty() || length > 200 || name.chars().any(char::is_control) {
        faults.add(at, "1 to 200 characters, not only blanks, no control characters");
    }
}

/// Checks a pendulum.
fn check_pendulum(at: &Pointer, pendulum: &PendulumSpec, faults: &mut Faults<'_>) {
    let PendulumSpec { length, mass, .. } = *pendulum;
    let known = !faults.unread(&at.key("length")) && !faults.unread(&at.key("mass"));
    let inertia = mass * length * length;
    if known && !inertia.is_normal() {
        faults.add_value(at, format!("m L^2 = {inertia:e}"), "m L^2 within the range of a double", None);
    }
    if known {
        energy::pendulum(at, pendulum, faults);
    }
    plausible::pendulum(at, pendulum, faults);
}
