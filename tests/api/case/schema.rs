//! The JSON Schema: units everywhere, ranges that the checks agree with, and the methods of the registry.

use canopy_fem::case::json_schema;
use canopy_fem::case::schema::CaseFile;
use canopy_fem::integrate::registry::methods;
use serde_json::Value;

use super::common::{assets, base_with};

/// Whether a schema allows a number (or a list of whole numbers, which are node, edge and triangle numbers).
fn is_number(schema: &Value) -> bool {
    let named = |name: &str| match schema.get("type") {
        Some(Value::String(kind)) => kind == name,
        Some(Value::Array(kinds)) => kinds.iter().any(|k| k == name),
        _ => false,
    };
    named("number") || named("integer")
}

/// Walks a schema; `doc` is the nearest description above, `names` where we are.
fn walk(schema: &Value, doc: &str, names: &mut Vec<String>, wrong: &mut Vec<String>, seen: &mut usize) {
    let own = schema.get("description").and_then(Value::as_str).unwrap_or(doc);
    if is_number(schema) {
        *seen += 1;
        let list_of_numbers = names.last().is_some_and(|n| n == "items") && schema["type"] == "integer";
        if !own.starts_with('[') && !list_of_numbers {
            wrong.push(format!("{}: {own}", names.join("/")));
        }
    }
    let Some(map) = schema.as_object() else { return };
    for (key, value) in map {
        names.push(key.clone());
        match (key.as_str(), value) {
            // Below a property a new description is due: an object's own is not its members'.
            ("properties" | "$defs", Value::Object(members)) => {
                for (name, member) in members {
                    names.push(name.clone());
                    // A choice with a value, {"time": 5e-4}, is described as a choice, and its one key is its name.
                    let choice = key == "properties"
                        && members.len() == 1
                        && names.iter().rev().nth(2).is_some_and(|n| n == "oneOf");
                    let above = if key == "properties" && !choice { "" } else { own };
                    walk(member, above, names, wrong, seen);
                    names.pop();
                }
            }
            ("items" | "additionalProperties" | "schema", Value::Object(_)) => walk(value, own, names, wrong, seen),
            ("oneOf" | "anyOf" | "allOf" | "prefixItems", Value::Array(list)) => {
                list.iter().for_each(|item| walk(item, own, names, wrong, seen));
            }
            _ => {}
        }
        names.pop();
    }
}

/// Every number of the format says its unit first.
#[test]
fn every_number_has_a_unit() {
    let (mut wrong, mut seen) = (Vec::new(), 0);
    walk(&json_schema(), "", &mut Vec::new(), &mut wrong, &mut seen);
    assert!(wrong.is_empty(), "numbers without a unit:\n{}", wrong.join("\n"));
    assert!(seen > 60, "the walk saw only {seen} numbers: it does not reach the whole schema");
}

/// The schema's lower bounds are the checks' bounds: the bound itself is refused where it is exclusive, accepted where
/// not.
#[test]
fn ranges_agree_with_the_checks() {
    let schema = json_schema();
    for (definition, name, key, extra) in [
        ("Time", "step", "time.step", ""),
        ("Time", "end", "time.end", ""),
        ("SpringRule", "stiffness", "system.network.springs.0.stiffness", ""),
        ("SpringRule", "rest_scale", "system.network.springs.0.rest_scale", ""),
        ("SpringRule", "rest_length", "system.network.springs.0.rest_length", ""),
        ("SpringRule", "linear_density", "system.network.springs.0.linear_density", ""),
        ("SpringRule", "strength", "system.network.springs.0.strength", ""),
        ("SpringRule", "cut", "system.network.springs.0.cut", ""),
        ("Support", "until", "system.network.supports.0.until", ""),
        ("Mass", "areal_density", "system.network.mass.areal_density", ""),
        ("Rayleigh", "mass", "system.network.damping.rayleigh.mass", ""),
        ("Rayleigh", "stiffness", "system.network.damping.rayleigh.stiffness", ""),
        ("Every", "every", "output.frames.every", ""),
        ("EverySteps", "every", "output.history.every", ""),
        ("Newton", "relative", "solver.newton.relative", ""),
        ("Newton", "max_iterations", "solver.newton.max_iterations", ""),
        ("Study", "repeat", "study.repeat", ""),
        ("Study", "budget_seconds", "study.budget_seconds", ""),
        ("Tolerance", "relative", "time.tolerance.relative", "time.tolerance.absolute"),
    ] {
        let property = &schema["$defs"][definition]["properties"][name];
        let (bound, allowed) = match (property.get("exclusiveMinimum"), property.get("minimum")) {
            (Some(bound), _) => (bound, false),
            (None, Some(bound)) => (bound, true),
            _ => panic!("{definition}.{name} has no lower bound in the schema: {property}"),
        };
        let mut sets = vec![(key, bound.to_string())];
        if !extra.is_empty() {
            sets.extend([(extra, "1".to_owned()), ("time.step", "null".to_owned())]);
        }
        let sets: Vec<(&str, &str)> = sets.iter().map(|(k, v)| (*k, v.as_str())).collect();
        assert_eq!(base_with(&sets).is_ok(), allowed, "{key} = {bound}");
    }
}

/// The method names and parameters of the schema are those of the registry.
#[test]
fn methods_come_from_the_registry() {
    let schema = json_schema();
    let choices = schema["$defs"]["Method"]["oneOf"].as_array().expect("choices");
    assert!(methods().len() >= 12);
    assert_eq!(choices.len(), 2 * methods().len());
    for method in methods() {
        assert!(choices.iter().any(|c| c["const"] == method.name), "{}", method.name);
        for p in method.parameters {
            let found = choices.iter().map(|c| &c["properties"][method.name]["properties"][p.name]);
            assert!(found.clone().any(|s| s["maximum"] == p.max), "{}.{}", method.name, p.name);
        }
    }
}

/// What is read can be written and read again to the same case: no key is lost between file and structs.
#[test]
fn assets_survive_a_round_trip() {
    for path in assets() {
        let text = std::fs::read_to_string(&path).expect("asset");
        let file: CaseFile = serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let again: CaseFile = serde_json::from_value(serde_json::to_value(&file).expect("JSON")).expect("read again");
        assert_eq!(file, again, "{}", path.display());
    }
}
