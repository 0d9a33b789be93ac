//! The case of a study in words.

use serde_json::Value;

use crate::format_number::figures;
use crate::study::plan::Plan;

/// What is simulated, for how long, and how often it is compared.
pub(super) fn words(plan: &Plan) -> Vec<String> {
    let mut told = vec![system(&plan.case)];
    if let Some(variant) = plan.variants.first() {
        let frames = variant.reference.motion.frames;
        told.push(format!(
            "From 0 to {} s; compared in {frames} frames, one every {} s.",
            figures(variant.end, 6),
            figures(variant.every, 6)
        ));
    }
    if plan.variants.len() > 1 {
        let factors: Vec<String> = plan.variants.iter().map(|v| figures(v.stiffness_factor, 4)).collect();
        told.push(format!("Studied with the stiffness of all springs multiplied by {}.", factors.join(", ")));
    }
    told.extend(own(&plan.case));
    told
}

fn system(case: &Value) -> String {
    if let Some(pendulum) = case.pointer("/system/pendulum") {
        let length = pendulum.get("length").and_then(Value::as_f64);
        return format!("A pendulum{}.", length.map(|l| format!(" of {} m", figures(l, 4))).unwrap_or_default());
    }
    let Some(network) = case.pointer("/system/network") else { return "A case of its own kind.".to_owned() };
    let has = |key: &str| network.get(key).is_some_and(|v| !v.is_null());
    let mut parts = Vec::new();
    let rules = network.get("springs").and_then(Value::as_array);
    let any = |key: &str| rules.is_some_and(|rules| rules.iter().any(|r| r.get(key).is_some_and(|v| !v.is_null())));
    let terms = [
        (any("slack"), "springs that go slack"),
        (any("dashpot"), "dashpots"),
        (has("damping"), "Rayleigh damping"),
        (has("gravity"), "gravity"),
        (has("aero"), "air"),
        (has("loads"), "loads"),
        (has("supports"), "supports"),
    ];
    parts.extend(terms.into_iter().filter(|(there, _)| *there).map(|(_, name)| name));
    let with = if parts.is_empty() { String::new() } else { format!(", with {}", listed(&parts)) };
    format!("A network of springs and masses {}{with}.", mesh(network))
}

fn mesh(network: &Value) -> String {
    let kind = network.get("mesh").and_then(Value::as_object).and_then(|mesh| mesh.iter().next());
    let Some((kind, of)) = kind else { return "on a mesh".to_owned() };
    let nodes = match of.get("nodes") {
        Some(Value::Array(list)) => Some(list.len() as u64),
        other => other.and_then(Value::as_u64),
    };
    let count = nodes.map(|n| format!(" of {n} nodes")).unwrap_or_default();
    match kind.as_str() {
        "file" => format!("on the mesh of the file {}", of.as_str().unwrap_or("named in the case")),
        "explicit" => format!("on a mesh{count} listed in the case"),
        kind => {
            let article = if kind.starts_with(['a', 'e', 'i', 'o', 'u']) { "an" } else { "a" };
            format!("on {article} {kind}{count}")
        }
    }
}

/// What the case itself would run.
fn own(case: &Value) -> Option<String> {
    let time = case.get("time")?;
    let method = match time.get("method")? {
        Value::String(name) => name.clone(),
        other => other.to_string(),
    };
    let pace = match (time.get("step").and_then(Value::as_f64), time.pointer("/tolerance/relative")) {
        (Some(h), _) => format!(" at step {} s", figures(h, 4)),
        (None, Some(tolerance)) => format!(" with tolerance {tolerance}"),
        (None, None) => String::new(),
    };
    Some(format!("The case itself asks for {method}{pace}."))
}

/// `a, b and c`.
fn listed(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
