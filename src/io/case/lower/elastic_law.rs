//! How the tension of a rule's springs grows with their strain.

use super::numbers::rising;
use crate::case::diagnostics::Faults;
use crate::case::pointer::Pointer;
use crate::case::schema::{ElasticLawRule, Factor, SlackRule, SpringRule};
use crate::model::spec::ElasticLaw;

/// [-] Of the largest force: what may be left at the strain 0.
const ROUNDING: f64 = 1e-12;

/// The law of a rule, if it is valid.
pub(super) fn elastic_law(at: &Pointer, rule: &SpringRule, faults: &mut Faults<'_>) -> Option<ElasticLaw> {
    let at = at.key("law");
    let law = match &rule.law {
        None | Some(ElasticLawRule::Linear) => return Some(ElasticLaw::Linear),
        Some(ElasticLawRule::Green) => ElasticLaw::Green,
        Some(ElasticLawRule::Table(rows)) => table(&at.key("table"), rows, faults)?,
    };
    let reeled = matches!(rule.rest_scale, Some(Factor::Table(_)));
    if reeled && matches!(rule.slack, Some(SlackRule::CompressionLimit(_))) {
        let hint = "make the slack \"tension-only\", or take the linear law";
        faults.add_hint(&at, "a linear law with compression_limit and a rest_scale over time", hint);
        return None;
    }
    Some(law)
}

/// [N] The steepest slope of force over strain.
pub(super) fn steepest(rows: &[[f64; 2]]) -> f64 {
    rows.windows(2).map(|pair| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0])).fold(0.0, f64::max)
}

fn table(at: &Pointer, rows: &[[f64; 2]], faults: &mut Faults<'_>) -> Option<ElasticLaw> {
    rising(at, "strain", rows.iter().map(|[strain, force]| (*strain, *force)), faults)?;
    let falls = rows.windows(2).position(|pair| pair[1][1] < pair[0][1]);
    if let Some(i) = falls {
        faults.add_value(
            &at.index(i + 1),
            format!("force {} after {}", rows[i + 1][1], rows[i][1]),
            "forces that do not fall with growing strain",
            Some("a falling branch has no stable equilibrium; end the table before it".to_owned()),
        );
        return None;
    }
    let zero = at_zero(rows);
    let size = rows.iter().map(|row| row[1].abs()).fold(0.0, f64::max);
    if zero.is_none_or(|force| force.abs() > ROUNDING * size) {
        let value = zero.map_or("no strain 0 within the rows".to_owned(), |force| format!("{force} N at the strain 0"));
        let hint = "give a row [0, 0]; a spring that is tight as it is given has a shorter rest_length".to_owned();
        faults.add_value(at, value, "the force 0 at the strain 0", Some(hint));
        return None;
    }
    let slope = steepest(rows);
    if !slope.is_normal() {
        faults.add_value(at, format!("a steepest slope of {slope} N"), "a curve that rises", None);
        return None;
    }
    Some(ElasticLaw::Table(rows.to_vec()))
}

/// [N] The force at the strain 0; `None` if it is outside the rows.
fn at_zero(rows: &[[f64; 2]]) -> Option<f64> {
    let [from, to] =
        rows.windows(2).map(|pair| [pair[0], pair[1]]).find(|[from, to]| from[0] <= 0.0 && to[0] >= 0.0)?;
    Some(from[1] + (to[1] - from[1]) * (0.0 - from[0]) / (to[0] - from[0]))
}
