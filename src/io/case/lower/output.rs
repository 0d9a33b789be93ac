//! The output section.

use std::collections::BTreeSet;

use super::geometry::Geometry;
use super::select::{self, NodeSet};
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Every, Field, Gauge, NodeOrEdgeSelection, NodeSelection, Output, Probe};
use crate::case::spec::{GaugeOf, GaugeSpec, OutputSpec, ProbeSpec, RowEvery, StagesSpec, TimeSpec};
use crate::format_number::first_few;
use crate::model::gauge::NodeQuantity;
use crate::model::gauge::{GaugeKind, NodeGauge, SpringGauge};
use crate::model::spec::{GasSpec, MembraneSpec, SpringGroup};
use crate::vtk::{Compression, FrameFormat, VtuFormat};

/// [-] Largest number of rows of `history.csv` with the default interval, including the first and the last state.
const HISTORY_ROWS: u64 = 10_000;

/// [-] Largest number of frames: their file names have six digits.
const MOST_FRAMES: f64 = 999_999.0;

/// Where a scene can be measured.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measurable<'a> {
    pub nodes: NodeSet<'a>,
    /// `None` if they are not known
    pub springs: Option<&'a [SpringGroup]>,
    /// `None` if they are not known
    pub membranes: Option<&'a [MembraneSpec]>,
    /// `None` if they are not known
    pub gases: Option<&'a [GasSpec]>,
    /// number of entries of the contact section
    pub contacts: usize,
}

/// Checks the `output` section and fills in its defaults; `None` if the times are unknown.
pub(super) fn output(
    output: Option<&Output>,
    scene: Measurable<'_>,
    time: Option<TimeSpec>,
    faults: &mut Faults<'_>,
) -> Option<OutputSpec> {
    let at = Pointer::root().key("output");
    let section = output.cloned().unwrap_or_default();
    frames(&at.key("frames").key("every"), section.frames, time, faults);
    let history = section.history.map(|h| h.every);
    let probes = probes(&at.key("probes"), &section.probes, scene.nodes, faults);
    let gauges = gauges(&at.key("gauges"), &section.gauges, scene, faults);
    let rows = HISTORY_ROWS - 2;
    Some(OutputSpec {
        frames_every: section.frames.map(|f| f.every),
        fields: unique(&section.fields),
        edges: section.edges,
        crossings: section.crossings,
        probes,
        gauges,
        quantities: Vec::new(),
        stages: StagesSpec::default(),
        checkpoint_every: section.checkpoint.map(|c| c.every),
        format: VtuFormat {
            file: section.format,
            compression: section.compression.unwrap_or(match section.format {
                FrameFormat::Vtu => Compression::None,
                FrameFormat::Vtkhdf => Compression::Zlib,
            }),
            precision: section.precision,
            ..VtuFormat::default()
        },
        history_derived: history.is_none(),
        history_every: match (history, time?.steps()) {
            (Some(every), _) => RowEvery::Steps(every),
            (None, Some(steps)) => RowEvery::Steps(steps.div_ceil(rows).max(1)),
            (None, None) => RowEvery::Time(time?.end / rows as f64),
        },
    })
}

fn frames(at: &Pointer, frames: Option<Every>, time: Option<TimeSpec>, faults: &mut Faults<'_>) {
    let Some(frames) = frames else { return };
    if let Some(time) = time
        && time.end / frames.every > MOST_FRAMES
    {
        let least = format!("at least {:e}, which makes {MOST_FRAMES} frames until the end", time.end / MOST_FRAMES);
        faults.add(at, least);
    }
}

fn unique(fields: &[Field]) -> Vec<Field> {
    let mut once = Vec::new();
    for field in fields {
        if !once.contains(field) {
            once.push(*field);
        }
    }
    once
}

fn probes(at: &Pointer, list: &[Probe], nodes: NodeSet<'_>, faults: &mut Faults<'_>) -> Vec<ProbeSpec> {
    let mut names = BTreeSet::new();
    let mut probes = Vec::new();
    for (i, probe) in list.iter().enumerate() {
        let at = at.index(i);
        super::name(&at.key("name"), &probe.name, faults);
        if faults.readable(&at.key("name")) && !names.insert(probe.name.as_str()) {
            faults.add(&at.key("name"), "a name that no other probe has");
        }
        if let Some(nodes) = nodes.select(&at.key("on"), &probe.on, faults) {
            probes.push(ProbeSpec { name: probe.name.clone(), nodes });
        }
    }
    probes
}

/// Checks and resolves gauges.
fn gauges(at: &Pointer, list: &[Gauge], scene: Measurable<'_>, faults: &mut Faults<'_>) -> Vec<GaugeSpec> {
    let mut names = BTreeSet::new();
    let mut gauges = Vec::new();
    for (i, gauge) in list.iter().enumerate() {
        let at = at.index(i);
        super::name(&at.key("name"), &gauge.name, faults);
        if faults.readable(&at.key("name")) && !names.insert(gauge.name.as_str()) {
            faults.add(&at.key("name"), "a name that no other gauge has");
        }
        if let Some(of) = gauge_of(&at, gauge, scene, faults) {
            gauges.push(GaugeSpec { name: gauge.name.clone(), of, every: gauge.every.unwrap_or(1) });
        }
    }
    gauges
}

/// What a gauge measures, and where.
fn gauge_of(at: &Pointer, gauge: &Gauge, scene: Measurable<'_>, faults: &mut Faults<'_>) -> Option<GaugeOf> {
    let (kind, nodes) = (gauge.of.kind(), scene.nodes);
    if matches!(nodes, NodeSet::Bob) && !has_bob(kind) {
        let known = "\"position\", \"displacement\", \"velocity\", \"speed\" or \"force\" for a pendulum";
        faults.add(&at.key("of"), known);
        return None;
    }
    let on = at.key("on");
    let mut nodes_of = || match gauge.on.nodes() {
        Some(selection) => nodes.select(&on, &selection, faults),
        None => {
            let allowed = match gauge.on {
                NodeOrEdgeSelection::Contact(_) => "a selection of nodes; a contact is for gauges of \"contact\"",
                _ => "a selection of nodes; edges are for gauges of springs",
            };
            faults.add(&on, allowed);
            None
        }
    };
    Some(match kind {
        GaugeKind::Nodes(of) => GaugeOf::Nodes { of, nodes: nodes_of()? },
        GaugeKind::Contact => GaugeOf::Contact { contact: contact_of(&on, gauge, scene, faults)? },
        GaugeKind::Cloth | GaugeKind::Membranes(_) | GaugeKind::Gas if matches!(nodes, NodeSet::Point(..)) => {
            faults.add_hint(&at.key("of"), "another quantity", "a point has no cloth");
            return None;
        }
        GaugeKind::Cloth => GaugeOf::Cloth { nodes: nodes_of()? },
        GaugeKind::Membranes(of) => {
            let triangles = membranes_of(&on, gauge, scene, faults)?;
            let strength = strength_of(&triangles, scene.membranes.unwrap_or_default());
            GaugeOf::Membranes { of, triangles, strength }
        }
        GaugeKind::Gas => GaugeOf::Gas { gas: gas_of(&on, gauge, scene, faults)? },
        GaugeKind::Springs(SpringGauge::Tension) if matches!(nodes, NodeSet::Point(..)) => {
            GaugeOf::Pull { masses: masses_above(&on, gauge, nodes, faults)? }
        }
        GaugeKind::Springs(of) => {
            let edges = springs_of(&on, gauge, scene, faults)?;
            GaugeOf::Springs { of, edges, rule: None, strength: None }
        }
    })
}

/// Whether the bob of a pendulum can be measured so: it has no springs, no cloth, and no support of its own.
fn has_bob(kind: GaugeKind) -> bool {
    match kind {
        GaugeKind::Springs(_) | GaugeKind::Cloth | GaugeKind::Membranes(_) | GaugeKind::Gas | GaugeKind::Contact => {
            false
        }
        GaugeKind::Nodes(NodeGauge { vector, .. }) => match vector {
            NodeQuantity::Position | NodeQuantity::Displacement | NodeQuantity::Velocity | NodeQuantity::Force => true,
            NodeQuantity::Acceleration | NodeQuantity::Reaction => false,
        },
    }
}

/// The edges that a gauge of tension selects.
fn edges_of(at: &Pointer, gauge: &Gauge, geometry: &Geometry, faults: &mut Faults<'_>) -> Option<Vec<bool>> {
    let Some(selection) = gauge.on.edges() else {
        faults.add(at, "a selection of edges: the tension is measured on springs");
        return None;
    };
    select::edges(at, &selection, geometry, faults)
}

/// [kg] What hangs above the edges of a gauge of tension of a point.
fn masses_above(at: &Pointer, gauge: &Gauge, nodes: NodeSet<'_>, faults: &mut Faults<'_>) -> Option<Vec<f64>> {
    let NodeSet::Point(geometry, whole) = nodes else { return None };
    let flags = edges_of(at, gauge, geometry, faults)?;
    let masses = whole.above((0_u32..).zip(flags).filter(|(_, selected)| *selected).map(|(edge, _)| edge));
    if masses.is_none() {
        let hint = "a point knows the pull of all canopies, and not how lines and cloth share it";
        faults.add_hint(at, "edges of which each carries all canopies, as those of a riser", hint);
    }
    masses
}

/// The edges of a gauge of tension that have springs.
fn springs_of(at: &Pointer, gauge: &Gauge, scene: Measurable<'_>, faults: &mut Faults<'_>) -> Option<Vec<u32>> {
    let NodeSet::Mesh(geometry) = scene.nodes else { return None };
    let flags = edges_of(at, gauge, geometry, faults)?;
    let springs = scene.springs?;
    let mut has_spring = vec![false; flags.len()];
    for &edge in springs.iter().flat_map(|group| &group.edges) {
        has_spring[edge as usize] = true;
    }
    let chosen = flags.iter().zip(&has_spring).zip(0_u32..).filter(|((flag, spring), _)| **flag && **spring);
    let edges: Vec<u32> = chosen.map(|(_, edge)| edge).collect();
    if edges.is_empty() {
        faults.add_hint(at, "edges with springs", "no rule of the springs section puts a spring on them");
        return None;
    }
    Some(edges)
}

/// [Pa] The strength of the membranes on some triangles over their thickness, if it is the same for all.
fn strength_of(triangles: &[u32], membranes: &[MembraneSpec]) -> Option<f64> {
    let rules = membranes.iter().filter(|rule| triangles.iter().any(|t| rule.triangles.binary_search(t).is_ok()));
    let mut strengths = rules.map(|rule| rule.strength.map(|strength| strength / rule.thickness));
    let first = strengths.next()??;
    strengths.all(|other| other == Some(first)).then_some(first)
}

/// The triangles that a gauge selects; `why` says what they are for.
fn triangles_of(
    at: &Pointer,
    gauge: &Gauge,
    why: &str,
    geometry: &Geometry,
    faults: &mut Faults<'_>,
) -> Option<Vec<u32>> {
    use NodeSelection::{All, Except, Group, Ids};
    match gauge.on.nodes() {
        Some(on @ (All | Ids(_) | Group(_) | Except(_))) => select::triangles(at, &on, geometry, faults),
        _ => {
            faults.add(at, format!("\"all\", {{\"ids\": [...]}} or {{\"group\": ...}} of triangles: {why}"));
            None
        }
    }
}

/// The gas that a gauge is for: that which the triangles are around.
fn gas_of(at: &Pointer, gauge: &Gauge, scene: Measurable<'_>, faults: &mut Faults<'_>) -> Option<usize> {
    let NodeSet::Mesh(geometry) = scene.nodes else { return None };
    let triangles = triangles_of(at, gauge, "it is measured on those around a gas", geometry, faults)?;
    let around = |gas: &GasSpec| triangles.iter().any(|triangle| gas.triangles.contains(triangle));
    let found: Vec<usize> = (0..).zip(scene.gases?).filter(|(_, gas)| around(gas)).map(|(i, _)| i).collect();
    match found[..] {
        [gas] => return Some(gas),
        [] => faults.add_hint(at, "triangles around a gas", "the gas section has none with these triangles"),
        _ => {
            let value = format!("triangles around the gases {}", first_few(&found));
            faults.add_value(at, value, "triangles around one gas only", None);
        }
    }
    None
}

/// The contact that a gauge selects.
fn contact_of(at: &Pointer, gauge: &Gauge, scene: Measurable<'_>, faults: &mut Faults<'_>) -> Option<usize> {
    let NodeOrEdgeSelection::Contact(number) = gauge.on else {
        faults.add(at, "{\"contact\": ...}, the number of a contact in the section contact, counted from 0");
        return None;
    };
    let (at, number) = (at.key("contact"), number as usize);
    match scene.contacts {
        count if number < count => return Some(number),
        0 => faults.add_hint(&at, "a contact that the case has", "the case has no section contact"),
        count => faults.add(&at, format!("a number below {count}, that of the contacts, which count from 0")),
    }
    None
}

/// The triangles of a gauge of membranes that have one.
fn membranes_of(at: &Pointer, gauge: &Gauge, scene: Measurable<'_>, faults: &mut Faults<'_>) -> Option<Vec<u32>> {
    let NodeSet::Mesh(geometry) = scene.nodes else { return None };
    let mut triangles = triangles_of(at, gauge, "it is measured on membranes", geometry, faults)?;
    let mut covered = vec![false; geometry.mesh.triangles.len()];
    scene.membranes?.iter().flat_map(|rule| &rule.triangles).for_each(|&t| covered[t as usize] = true);
    triangles.retain(|&t| covered[t as usize]);
    if triangles.is_empty() {
        faults.add_hint(at, "triangles with a membrane", "no rule of the membranes section selects them");
        return None;
    }
    Some(triangles)
}
