//! `canopy-fem methods`: the registry as a table.

use crate::integrate::registry::{Family, MethodInfo, methods};
use std::fmt::Write;

/// The table.
pub fn run() -> String {
    let mut text = String::from("method               order  needs      evaluations  stability\n");
    for m in methods() {
        let needs = match m.family {
            Family::Explicit => "forces",
            Family::MatrixFree => "springs",
            Family::Implicit => "tangent",
        };
        let _ = writeln!(text, "{:<20} {:>5}  {:<9}  {:<11}  {}", m.name, m.order, needs, evaluations(m), m.stability);
        for p in m.parameters {
            let _ = writeln!(text, "{:<20}   {} in {}, default {}: {}", "", p.name, p.range(), p.default, p.doc);
        }
        let _ = writeln!(text, "{:<20}   {}", "", m.source);
    }
    text.push_str("\nevaluations: force passes a step (without / with velocity-dependent forces)\n");
    text
}

fn evaluations(m: &MethodInfo) -> String {
    match m.evaluations {
        [0, 0] => "Newton's".to_owned(),
        [a, b] if a == b => a.to_string(),
        [a, b] => format!("{a} / {b}"),
    }
}
