//! Rest length, stiffness and dashpot coefficient of single edges.

use super::elastic_law::steepest;
use super::geometry::{Geometry, TriangleUse, triangles};
use super::plausible;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{Dashpot, DashpotRule, EdgeSelection, ElasticLawRule, Factor, PerEdge, SpringRule};
use crate::drive::clock::Step;
use crate::format_number::{counted, first_few};
use crate::model::spec::{DashpotKind, DashpotSpec, SpringValues};
use crate::warning::WarningCode;

/// Checked values of a rule, resolved for its edges one by one.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stiffness {
    /// [N/m] k
    Uniform(f64),
    /// [N] EA
    Axial(f64),
    /// [N/m] E t
    Membrane(f64),
}

const ONE_STIFFNESS: &str = "exactly one of stiffness, axial_rigidity, membrane, law with a table";

/// Exactly one of the three stiffness rules, in range.
pub(super) fn stiffness(at: &Pointer, rule: &SpringRule, faults: &mut Faults<'_>) -> Option<Stiffness> {
    let table = match &rule.law {
        Some(ElasticLawRule::Table(rows)) => Some(rows),
        _ => None,
    };
    match (rule.stiffness, rule.axial_rigidity, rule.membrane) {
        (None, None, None) if table.is_some() => table.map(|rows| Stiffness::Axial(steepest(rows))),
        _ if table.is_some() => {
            let hint = Some("the table is the stiffness; leave the other out".to_owned());
            faults.add_value(at, "a spring rule with a stiffness and a table", "one of the two", hint);
            None
        }
        (Some(k), None, None) => Some(Stiffness::Uniform(k)),
        (None, Some(ea), None) => {
            plausible::material(&at.key("axial_rigidity"), "axial_rigidity", ea, faults);
            Some(Stiffness::Axial(ea))
        }
        (None, None, Some(m)) => {
            let at = at.key("membrane");
            plausible::material(&at.key("modulus"), "modulus", m.modulus, faults);
            plausible::material(&at.key("thickness"), "thickness", m.thickness, faults);
            Some(Stiffness::Membrane(m.modulus * m.thickness))
        }
        (None, None, None) => {
            faults.add_value(at, "a spring rule without stiffness", ONE_STIFFNESS, None);
            None
        }
        _ => {
            let hint = Some("keep the one that is meant".to_owned());
            let value = "a spring rule with several stiffnesses";
            faults.add_value(at, value, ONE_STIFFNESS, hint);
            None
        }
    }
}

/// [m] Rest lengths of the edges, by the rule's `rest_length` or `rest_scale`; those at the factor 1 where this is a
/// table. `kept` are those of an earlier run, in place of the lengths of edges.
pub(super) fn rest_lengths(
    at: &Pointer,
    rule: &SpringRule,
    edges: &[u32],
    kept: Option<Vec<f64>>,
    geometry: &Geometry,
    faults: &mut Faults<'_>,
) -> Option<Vec<f64>> {
    let initial = edges.iter().filter_map(|&e| geometry.unstretched.get(e as usize).copied());
    match (&rule.rest_length, &rule.rest_scale) {
        (Some(_), Some(Factor::Constant(_))) => {
            let hint = "rest_length is absolute, rest_scale a factor of the initial length; keep one";
            faults.add_hint(&at.key("rest_scale"), "not together with rest_length", hint);
            None
        }
        (Some(given), None | Some(Factor::Table(_))) => {
            let at = at.key("rest_length");
            let lengths = match given {
                PerEdge::Same(length) => vec![*length; edges.len()],
                PerEdge::Each(list) if list.len() == geometry.mesh.edges.len() => {
                    edges.iter().filter_map(|&edge| list.get(edge as usize).copied()).collect()
                }
                PerEdge::Each(list) => {
                    let value = counted(list.len() as u64, "length", "lengths");
                    let edges = geometry.mesh.edges.len();
                    faults.add_value(&at, value, format!("one length, or a list of {edges} (one per edge)"), None);
                    return None;
                }
            };
            if lengths.contains(&0.0)
                && let Some(needs) = needs_rest_length(rule)
            {
                let hint = match needs {
                    "law" => "this law needs a rest length; the linear law does not".to_owned(),
                    _ => format!("{needs} divides by the rest length; give stiffness in its place"),
                };
                faults.add_hint(&at, "a number above 0", hint);
                return None;
            }
            Some(lengths)
        }
        (None, Some(Factor::Constant(scale))) => Some(initial.map(|l| scale * l).collect()),
        (None, None | Some(Factor::Table(_))) => {
            if kept.is_some() {
                return kept;
            }
            let of_reefing = geometry.reefing_length().filter(|_| is_reefing(&rule.on));
            Some(of_reefing.map_or_else(|| initial.collect(), |length| vec![length; edges.len()]))
        }
    }
}

/// Whether a rule is for the reefing line of a parachute, or of one of a cluster.
fn is_reefing(on: &EdgeSelection) -> bool {
    on.group().is_some_and(|group| group == "reefing" || group.starts_with("reefing-"))
}

/// The key of a rule that has no value at a rest length of 0.
fn needs_rest_length(rule: &SpringRule) -> Option<&'static str> {
    match rule.dashpot {
        _ if !matches!(rule.law, None | Some(ElasticLawRule::Linear)) => Some("law"),
        _ if rule.axial_rigidity.is_some() => Some("axial_rigidity"),
        Some(Dashpot::Axial(DashpotRule::PerStrain(_)) | Dashpot::Relative(DashpotRule::PerStrain(_))) => {
            Some("per_strain")
        }
        _ => None,
    }
}

impl Stiffness {
    /// [N/m] Stiffness of the edges, from rest lengths [m] `[n_edges]`; a value that is not usable is a fault that
    /// names the edges.
    pub(super) fn of_edges(
        self,
        at: &Pointer,
        edges: &[u32],
        rest: &[f64],
        geometry: &Geometry,
        faults: &mut Faults<'_>,
    ) -> Option<SpringValues> {
        if let Self::Membrane(_) = self {
            let at = at.key("membrane");
            let bare: Vec<u32> =
                edges.iter().copied().filter(|&e| geometry.topology.edge_triangles(e as usize).is_empty()).collect();
            if !bare.is_empty() {
                let value = format!("edges without triangles: {}", first_few(&bare));
                let hint = "put a rule {\"on\": \"lines\", \"stiffness\": ...} before this one".to_owned();
                faults.add_value(&at, value, "edges of triangles", Some(hint));
                return None;
            }
            if !triangles(&at, "a membrane stiffness", geometry, TriangleUse::Areas, faults) {
                return None;
            }
        }
        let k = match self {
            Self::Uniform(k) => SpringValues::Uniform(k),
            Self::Axial(ea) => rest.iter().map(|rest| ea / rest).collect(),
            Self::Membrane(et) => edges.iter().map(|&e| geometry.net_stiffness(et, e as usize, |_| true)).collect(),
        };
        let usable = |k: f64, rest: f64| k.is_normal() && (rest.is_normal() || rest == 0.0);
        let numbered = edges.iter().zip(k.of(edges.len()).zip(rest));
        let bad: Vec<u32> = numbered.filter(|(_, (k, rest))| !usable(*k, **rest)).map(|(e, _)| *e).collect();
        if !bad.is_empty() {
            let value = format!("no usable stiffness or rest length on edges {}", first_few(&bad));
            faults.add_value(at, value, "lengths and stiffnesses within the range of a double", None);
            return None;
        }
        Some(k)
    }
}

/// Dashpots of a rule, with the coefficients of its edges.
pub(super) fn dashpot(
    at: &Pointer,
    dashpot: Dashpot,
    springs: &Springs<'_>,
    faults: &mut Faults<'_>,
) -> Option<DashpotSpec> {
    let (kind, key, rule) = match dashpot {
        Dashpot::Axial(rule) => (DashpotKind::Axial, "axial", rule),
        Dashpot::Relative(rule) => (DashpotKind::Relative, "relative", rule),
    };
    let at = at.key(key);
    let Springs { stiffness, rest, strands, step } = springs;
    let of_strands = |one: SpringValues| strands.map_or(one.clone(), |strands| one.times(strands));
    let coefficient = match rule {
        DashpotRule::Coefficient(c) => of_strands(SpringValues::Uniform(c)),
        DashpotRule::Time(tau) => stiffness.map(|k| k * tau),
        DashpotRule::PerStrain(c) => of_strands(rest.iter().map(|l0| c / l0).collect()),
        DashpotRule::Step => {
            // If the times are missing, there is a fault at /time already.
            let Step::Fixed(h) = (*step)? else {
                let hint = "it has c = k h; give \"step\" in place of time.tolerance, or the dashpot's own time: {\"time\": 1e-3}";
                faults.add_hint(&at, "not a \"step\" dashpot with adaptive steps", hint);
                return None;
            };
            let text = format!(
                "{at}: a \"step\" dashpot has c = k h, so the physics changes with the step; use it only to reproduce the thesis. Instead, {{\"time\": {h:e}}} gives the same coefficient at this step and at all others"
            );
            faults.warn(WarningCode::StepDashpot, text);
            stiffness.map(|k| k * h)
        }
    };
    if coefficient.given().iter().any(|c| !c.is_finite()) {
        faults.add(&at, "a coefficient that stays a finite number on every edge");
        return None;
    }
    Some(DashpotSpec { kind, coefficient, from_step: rule == DashpotRule::Step })
}

/// The data for the coefficients of dashpots.
#[derive(Debug)]
pub(super) struct Springs<'a> {
    /// [N/m] of the edges
    pub stiffness: &'a SpringValues,
    /// [m] one per edge
    pub rest: &'a [f64],
    /// [-] tapes or lines that each edge stands for, which the stiffness has already; `None` where it is one
    pub strands: Option<&'a [f64]>,
    /// the steps of the run, if known and valid
    pub step: Option<Step>,
}
