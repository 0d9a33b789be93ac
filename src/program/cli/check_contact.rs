//! What `check` says of contact: what may touch what, what is near at the start, what it costs, and which contact
//! allows explicit methods the shortest step.

use crate::analysis::contact::{limiting, step_of_pair};
use crate::case::spec::SystemSpec;
use crate::format_number::{counted, figures};
use crate::integrate::registry::{Family, MethodChoice};
use crate::model::abilities::ContactSurvey;
use crate::model::spec::{ContactSide, ContactSpec, ObstacleShape, ObstacleSpec};
use crate::preflight::contact::counted_parts;
use crate::study::forecast::Candidate;
use crate::study::forecast::cost::ContactCost;
use serde::Serialize;
use serde_json::Value;
use std::fmt::Write;

/// The explicit method whose steps are told of a case with another one.
const EXPLICIT: &str = "velocity-verlet";

/// A contact in words, by the names of the case.
pub(super) struct NamedContact {
    /// "everything with itself"
    between: String,
    /// the rest of its line
    law: String,
    gap: f64,
    friction: f64,
}

/// What may touch what.
pub(super) fn contacts(system: &SystemSpec, case: &Value) -> Vec<NamedContact> {
    let SystemSpec::Network(spec) = system else { return Vec::new() };
    let named = |(i, spec): (usize, &ContactSpec)| {
        let ContactSpec { parts, other, gap, friction } = spec;
        let name = |side: usize| {
            let given = case.pointer(&format!("/system/network/contact/{i}/between/{side}")).and_then(Value::as_str);
            given.filter(|name| *name != "all").unwrap_or("everything").to_owned()
        };
        let (with, counts) = match other {
            ContactSide::Itself => ("itself".to_owned(), String::new()),
            ContactSide::Parts(other) => (name(1), format!(" with {}", counted_parts(other))),
            ContactSide::Obstacle(body) => (body_in_words(body), String::new()),
        };
        let rubs =
            if *friction == 0.0 { "no friction".to_owned() } else { format!("friction {}", figures(*friction, 4)) };
        let law = format!("gap {} m, {rubs}; {}{counts}", figures(*gap, 4), counted_parts(parts));
        NamedContact { between: format!("{} with {with}", name(0)), law, gap: *gap, friction: *friction }
    };
    spec.contacts.iter().enumerate().map(named).collect()
}

/// A rigid body in words.
fn body_in_words(body: &ObstacleSpec) -> String {
    let shape = match &body.shape {
        ObstacleShape::Plane { .. } => "a plane".to_owned(),
        ObstacleShape::Sphere { radius, .. } => format!("a sphere of radius {} m", figures(*radius, 4)),
        ObstacleShape::Cylinder { radius, .. } => format!("a cylinder of radius {} m", figures(*radius, 4)),
        ObstacleShape::Box { .. } => "a box".to_owned(),
        ObstacleShape::Surface { triangles, .. } => {
            format!("a body of {}", counted(triangles.len() as u64, "triangle", "triangles"))
        }
    };
    if body.motion.is_some() { format!("{shape} that moves") } else { shape }
}

/// A line for each contact, and one for what is near at the start, if that is known.
pub(super) fn describe_contacts(contacts: &[NamedContact], surveys: &[ContactSurvey]) -> String {
    let mut text = String::new();
    for (i, NamedContact { between, law, .. }) in contacts.iter().enumerate() {
        let _ = writeln!(text, "  contact         {between}: {law}");
        let Some(ContactSurvey { first, second, near, touching, .. }) = surveys.get(i) else { continue };
        let with = if second.iter().any(|n| *n > 0) { format!(" with {}", elements(second)) } else { String::new() };
        let near = counted(*near as u64, "pair near", "pairs near");
        let first = elements(first);
        let _ = writeln!(text, "                  {first}{with}; {near} at the start, {touching} of them touching");
    }
    text
}

/// "4 nodes, 5 edges, 2 triangles"
fn elements(counts: &[usize; 3]) -> String {
    let words = [("node", "nodes"), ("edge", "edges"), ("triangle", "triangles")];
    let some = counts.iter().zip(words).filter(|(count, _)| **count > 0);
    some.map(|(count, (one, many))| counted(*count as u64, one, many)).collect::<Vec<_>>().join(", ")
}

/// What contact costs, in a line.
pub(super) fn describe_cost(cost: Option<ContactCost>) -> String {
    let Some(ContactCost { seconds, share, search_seconds, .. }) = cost else { return String::new() };
    format!(
        "  contact cost    {} us a pass at the start, {} times the rest of it; {} us a search for pairs\n",
        figures(1e6 * seconds, 2),
        figures(share, 2),
        figures(1e6 * search_seconds, 2)
    )
}

/// Which contact allows an explicit method the shortest step.
#[derive(Serialize)]
pub(super) struct ContactLimit {
    /// its number, from 0
    pub contact: usize,
    /// the case's method, or `velocity-verlet` if that is not explicit
    pub method: &'static str,
    /// [s] what a pair allows of which 60 % or more of the gap is closed; over the root of their number for pairs that
    /// share a node
    pub step: f64,
    /// [s] what all else allows at the start; null without limit
    pub critical_step: Option<f64>,
    #[serde(skip)]
    own: bool,
}

/// The explicit method whose steps are told.
fn explicit<'a>(own: &'a MethodChoice, candidates: &'a [Candidate]) -> Option<&'a Candidate> {
    let name = if own.info.family == Family::Explicit { own.info.name } else { EXPLICIT };
    candidates.iter().find(|candidate| candidate.method.info.name == name)
}

/// The contact that limits explicit steps most; `None` without contact.
pub(super) fn contact_limit(
    own: &MethodChoice,
    candidates: &[Candidate],
    surveys: &[ContactSurvey],
) -> Option<ContactLimit> {
    let Candidate { method, limit } = explicit(own, candidates)?;
    let (contact, step) = limiting(method, surveys.iter().map(|contact| contact.rate))?;
    let critical_step = limit.map(|limit| limit.step).filter(|step| step.is_finite());
    Some(ContactLimit {
        contact,
        method: method.info.name,
        step,
        critical_step,
        own: own.info.family == Family::Explicit,
    })
}

/// The same in a line; `all` has that of cases with other methods too.
pub(super) fn describe_limit(limit: Option<&ContactLimit>, contacts: &[NamedContact], all: bool) -> String {
    let Some(ContactLimit { contact, method, step, critical_step, .. }) = limit.filter(|limit| limit.own || all) else {
        return String::new();
    };
    let between = contacts.get(*contact).map_or("", |contact| &contact.between);
    let rest = critical_step.map_or_else(
        || "nothing else limits it".to_owned(),
        |step| format!("all else allows {} s at the start", figures(step, 3)),
    );
    let step = figures(*step, 3);
    format!(
        "  contact step    contact {contact} ({between}) allows {method} h <= {step} s once 60 % of the gap of a pair is \
         closed, and half of that with four such pairs at a node; {rest}\n"
    )
}

/// All contacts for programs.
pub(super) fn in_json(
    contacts: &[NamedContact],
    surveys: &[ContactSurvey],
    (own, candidates): (&MethodChoice, &[Candidate]),
) -> Vec<Value> {
    let method = explicit(own, candidates).map(|candidate| &candidate.method);
    let of = |(NamedContact { between, gap, friction, .. }, survey): (&NamedContact, &ContactSurvey)| {
        let ContactSurvey { first, second, near, touching, at_one_node, rate } = *survey;
        let counts = |[nodes, edges, triangles]: [usize; 3]| serde_json::json!({"nodes": nodes, "edges": edges, "triangles": triangles});
        let step = method.map(|method| step_of_pair(method, rate)).filter(|step| step.is_finite());
        serde_json::json!({
            "between": between,
            "gap": gap,
            "friction": friction,
            "first": counts(first),
            "second": counts(second),
            "near": near,
            "touching": touching,
            "at_one_node": at_one_node,
            "explicit_step": step,
        })
    };
    contacts.iter().zip(surveys).map(of).collect()
}
