//! The JSON Schema: units everywhere, ranges that the checks agree with, and the methods of the registry.

use canopy_fem::case::json_schema;
use canopy_fem::case::schema::CaseFile;
use canopy_fem::integrate::registry::methods;
use serde_json::{Value, json};

use super::common::{assets, base_with, faults, text_with};

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

/// What a schema stands for: the target of a reference, or what is not null.
fn meant<'a>(root: &'a Value, schema: &'a Value) -> &'a Value {
    if let Some(name) = schema["$ref"].as_str() {
        return meant(root, root.pointer(&name[1..]).expect("a definition"));
    }
    let branches = schema["anyOf"].as_array();
    branches.map_or(schema, |list| meant(root, list.iter().find(|b| b["type"] != "null").expect("a branch")))
}

/// A value of the right types with nothing that can be left out.
fn sample(root: &Value, schema: &Value) -> Value {
    let schema = meant(root, schema);
    if let Some(branches) = schema["oneOf"].as_array() {
        return sample(root, &branches[0]);
    }
    let required = || schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str);
    match &schema["type"] {
        _ if schema.get("const").is_some() => schema["const"].clone(),
        _ if is_number(schema) => json!(1),
        kind if kind == "object" => {
            required().map(|key| (key.to_owned(), sample(root, &schema["properties"][key]))).collect()
        }
        Value::Array(_) | Value::String(_) if schema.get("items").is_some() => {
            let least = schema["minItems"].as_u64().unwrap_or(1);
            (0..least).map(|_| sample(root, &schema["items"])).collect()
        }
        kind if kind == "boolean" => json!(false),
        _ => json!("x"),
    }
}

/// Values of a schema with one number or one list out of its range each, and where this is.
fn outside(root: &Value, schema: &Value) -> Vec<(String, Value)> {
    let (outer, schema) = (schema, meant(root, schema));
    let mut found = Vec::new();
    for schema in if std::ptr::eq(outer, schema) { vec![schema] } else { vec![outer, schema] } {
        let bounds = [("exclusiveMinimum", 0.0), ("minimum", -1.0), ("exclusiveMaximum", 0.0), ("maximum", 1.0)];
        for (bound, step) in bounds.map(|(key, step)| (schema[key].as_f64(), step)) {
            let Some(number) = bound.map(|bound| bound + step) else { continue };
            let whole = schema["type"] == "integer" || schema["format"].as_str().is_some_and(|f| f.starts_with("uint"));
            match whole {
                // A type has no whole number there.
                true if number < 0.0 => {}
                true => found.push((String::new(), json!(number as u64))),
                false => found.push((String::new(), json!(number))),
            }
        }
    }
    // A selection without another holds selections, without end.
    let endless = |branch: &&Value| branch["$ref"].as_str().is_some_and(|name| name.ends_with("Except"));
    for branch in schema["oneOf"].as_array().into_iter().flatten().filter(|branch| !endless(branch)) {
        found.extend(outside(root, branch));
    }
    for (key, property) in schema["properties"].as_object().into_iter().flatten() {
        for (at, value) in outside(root, property) {
            let mut object = sample(root, schema);
            object[key] = value;
            found.push((format!("/{key}{at}"), object));
        }
    }
    if let Some(items) = schema.get("items") {
        if schema["minItems"].as_u64().is_some_and(|n| n > 0) && schema["minItems"] != schema["maxItems"] {
            found.push((String::new(), json!([])));
        }
        for (at, value) in outside(root, items) {
            let mut list = sample(root, schema);
            list[0] = value;
            found.push((format!("/0{at}"), list));
        }
    }
    found
}

/// Whatever number or list the schema gives a range is refused at its place if it is outside, though serde reads it.
#[test]
fn every_range_of_the_schema_is_checked() {
    let schema = json_schema();
    let cases = outside(&schema, &schema);
    for (pointer, case) in &cases {
        let typed = serde_json::from_value::<CaseFile>(case.clone());
        assert!(typed.is_ok(), "{pointer}: {} in {case}", typed.expect_err("no case"));
        let told = faults(text_with(&case.to_string(), &[]));
        assert!(told.iter().any(|fault| fault.pointer == *pointer), "{pointer} is not told: {told:#?}");
    }
    assert!(cases.len() > 130, "only {} ranges", cases.len());
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
