//! What must hold of the report of a failed run.

use canopy_fem::drive::{Failure, Outcome};

/// A report names time, step and node; its sentences are there, and no number in them is nonsense.
///
/// # Errors
/// What does not hold.
pub fn is_true(failure: &Failure, outcome: &Outcome, nodes: usize) -> Result<(), String> {
    let complain = |what: &str| Err(format!("{what}: {failure:?}"));
    if !(failure.time.is_finite() && failure.time > outcome.t_end && failure.step == outcome.steps + 1) {
        return complain("the time or step is not that of the failed step");
    }
    if failure.node.is_none_or(|node| node as usize >= nodes) {
        return complain("no such node");
    }
    for sentence in [&failure.cause, &failure.advice] {
        if sentence.split_whitespace().count() < 4 {
            return complain("no sentence");
        }
        let words = sentence.split(|c: char| !(c.is_ascii_alphanumeric() || ".-+".contains(c)));
        for word in words {
            if ["NaN", "inf", "-inf"].contains(&word) || word == "0.0e0" || word == "0.000e0" {
                return complain(&format!("\"{word}\" tells nothing"));
            }
        }
    }
    Ok(())
}
