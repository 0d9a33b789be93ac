//! What a sweep varies and measures, in words and with units, for its charts.

use crate::case::json_schema;
use crate::model::gauge::Quantity as Column;
use crate::model::quantity::{Named, OfLanding, OfScene, QuantityName, Statistic};
use crate::output::gauges::names::without_rule;
use serde_json::Value;

/// The gauge of the energy account.
const ENERGY: &str = "energy";

/// A key of the case with its unit, as its description in the JSON Schema has it; the key alone where that has none.
pub(super) fn with_unit(key: &str) -> String {
    let schema = json_schema();
    let path: Vec<&str> = key.split('.').collect();
    match unit(&schema, &schema, &path) {
        Some(unit) => format!("{key} [{}]", shown(unit)),
        None => key.to_owned(),
    }
}

/// The unit of a key of the case, as axes show it; empty where it has none.
pub fn unit_of(key: &str) -> String {
    let schema = json_schema();
    let path: Vec<&str> = key.split('.').collect();
    unit(&schema, &schema, &path).unwrap_or_default().to_owned()
}

/// A unit as people write it.
pub(super) fn shown(unit: &str) -> String {
    unit.replace("^2", "²").replace("^3", "³")
}

/// The unit of what is at a path below a node of the schema: its own, else that of what it refers to.
fn unit<'s>(schema: &'s Value, node: &'s Value, path: &[&str]) -> Option<&'s str> {
    let description = node.get("description").and_then(Value::as_str).unwrap_or_default();
    let own = description.strip_prefix('[').and_then(|rest| rest.split_once(']')).map(|(unit, _)| unit);
    let reference = node.get("$ref").and_then(Value::as_str).and_then(|name| schema.pointer(name.strip_prefix('#')?));
    let choices = ["oneOf", "anyOf"].into_iter().filter_map(|kind| node.get(kind)?.as_array()).flatten();
    let within = || reference.into_iter().chain(choices).find_map(|node| unit(schema, node, path));
    let Some((first, rest)) = path.split_first() else { return own.or_else(within) };
    let entry = || first.parse::<usize>().ok().and_then(|_| node.get("items"));
    if let Some(next) = node.get("properties").and_then(|of| of.get(first)).or_else(entry) {
        return unit(schema, next, rest).or(own.filter(|_| rest.is_empty()));
    }
    // An entry of a list that may also be a single number.
    within().or(own.filter(|_| rest.is_empty() && first.parse::<usize>().is_ok()))
}

/// A column of a gauge and what is made of it: "largest tension (riser), peak".
pub(super) fn of_gauge(gauge: &str, column: &str, end: &str) -> String {
    let words = Column::named(column).map_or_else(|| column.replace('_', " "), |known| known.words());
    match without_rule(gauge) {
        ENERGY => format!("{words} energy, {end}"),
        gauge => format!("{words} ({gauge}), {end}"),
    }
}

/// A quantity in words; its name where it has no others.
pub(super) fn of_quantity(name: &str) -> String {
    let Ok(QuantityName { names, .. }) = name.parse() else { return name.to_owned() };
    match names {
        Named::Series { gauge, column, statistic } => {
            let end = match statistic {
                Statistic::Peak => "peak".to_owned(),
                Statistic::PeakTime => "time of the peak".to_owned(),
                Statistic::Min => "smallest value".to_owned(),
                Statistic::Last => "at the end".to_owned(),
                Statistic::Mean => "mean over the run".to_owned(),
                Statistic::Steady => "mean over the last tenth".to_owned(),
                Statistic::At(t) => format!("at {t} s"),
            };
            of_gauge(&gauge, &column, &end)
        }
        Named::OpeningLoad => "opening load".to_owned(),
        Named::DisplacementEnd => "largest displacement at the end".to_owned(),
        Named::Motion => "motion".to_owned(),
        Named::Landing(of) => match of {
            OfLanding::Time => "time of the landing",
            OfLanding::Speed => "speed at the landing",
            OfLanding::Drift => "drift to the landing",
            OfLanding::Heading => "heading of the drift",
            OfLanding::X => "x of the landing",
            OfLanding::Y => "y of the landing",
        }
        .to_owned(),
        Named::Largest(OfScene::Displacement) => "largest displacement".to_owned(),
        Named::Largest(OfScene::Speed) => "largest speed of a node".to_owned(),
        Named::Largest(OfScene::Strain) => "largest strain".to_owned(),
        Named::Largest(OfScene::Stress) => "largest stress".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_have_the_units_of_the_schema() {
        for (key, expected) in [
            ("time.step", "time.step [s]"),
            ("system.network.springs.0.stiffness", "system.network.springs.0.stiffness [N/m]"),
            ("system.network.gravity.2", "system.network.gravity.2 [m/s²]"),
            ("system.pendulum.length", "system.pendulum.length [m]"),
            ("time.method", "time.method"),
            ("nothing.there", "nothing.there"),
        ] {
            assert_eq!(with_unit(key), expected);
        }
    }

    #[test]
    fn quantities_have_words() {
        assert_eq!(of_quantity("riser.tension_max.peak"), "largest tension (riser), peak");
        assert_eq!(of_quantity("springs[5] lines.tension_max.peak_time"), "largest tension (lines), time of the peak");
        assert_eq!(of_quantity("tip.z@0.5"), "z (tip), at 0.5 s");
        assert_eq!(of_quantity("opening_load"), "opening load");
        assert_eq!(of_quantity("energy.kinetic.mean"), "kinetic energy, mean over the run");
        assert_eq!(of_quantity("landing.speed"), "speed at the landing");
        assert_eq!(of_quantity("steps"), "steps");
    }
}
