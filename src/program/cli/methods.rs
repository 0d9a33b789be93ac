//! `canopy-fem methods`: the registry as a table.

use crate::integrate::registry::{Family, MethodInfo, ParameterInfo, methods};
use serde_json::{Value, json};
use std::fmt::Write;

/// `methods`.
#[derive(Clone, Debug, clap::Args)]
pub struct MethodsArgs {
    /// Print the table as JSON
    #[arg(long)]
    pub json: bool,
}

/// The table.
pub(super) fn run(args: &MethodsArgs) -> String {
    if args.json {
        let all = Value::Array(methods().iter().map(entry).collect());
        // Printing a value cannot fail.
        return serde_json::to_string_pretty(&all).unwrap_or_else(|_| all.to_string()) + "\n";
    }
    let mut text = String::from("method               order  needs      evaluations  stability\n");
    for m in methods() {
        let needs = match m.family {
            Family::Explicit => "forces",
            Family::MatrixFree => "springs",
            Family::Implicit => "tangent",
        };
        let _ = writeln!(text, "{:<20} {:>5}  {:<9}  {:<11}  {}", m.name, m.order, needs, evaluations(m), m.stability);
        for p in m.parameters {
            let _ = writeln!(text, "{:<20}   {}: {}, default {}: {}", "", p.name, p.allowed(), p.default, p.doc);
        }
        let _ = writeln!(text, "{:<20}   {}", "", m.source);
    }
    text.push_str("\nevaluations: force passes a step (without / with velocity-dependent forces)\n");
    text
}

/// A method for programs. `evaluations` are force passes a step, without and with velocity-dependent forces; null where
/// Newton's iterations decide.
fn entry(m: &MethodInfo) -> Value {
    let parameter = |p: &ParameterInfo| {
        json!({"name": p.name, "default": p.default, "min": p.min, "min_included": p.min_included, "max": p.max,
               "whole": p.whole, "description": p.doc})
    };
    json!({
        "name": m.name,
        "order": m.order,
        "family": m.family,
        "evaluations": (m.evaluations != [0, 0]).then_some(m.evaluations),
        "stability": m.stability,
        "parameters": m.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "source": m.source,
    })
}

fn evaluations(m: &MethodInfo) -> String {
    match m.evaluations {
        [0, 0] => "Newton's".to_owned(),
        [a, b] if a == b => a.to_string(),
        [a, b] => format!("{a} / {b}"),
    }
}
