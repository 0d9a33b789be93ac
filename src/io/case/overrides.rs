//! `--set time.step=1e-3`: values of the command line that replace values of the file.

use serde_json::{Map, Value};

use super::diagnostics::did_you_mean;
use super::error::CaseError;
use super::hints::{listed, paths_in, places_of, renamed, typed_number};
use super::schema::json_schema;

/// Puts one value into a case. `key` is a dotted path, list entries are numbers (`system.network.springs.0.stiffness`);
/// missing objects on the path are made. `value` is read as JSON, or as plain text if it is not JSON, but for numbers
/// such as `.001`; `null` removes the key.
pub(crate) fn apply(case: &mut Value, key: &str, value: &str) -> Result<(), CaseError> {
    let fail = |reason: String| CaseError::Override { key: key.to_owned(), value: value.to_owned(), reason };
    if key.contains(['/', '[', ']']) {
        let dotted = key.replace(['/', '[', ']'], ".");
        let steps: Vec<&str> = dotted.split('.').filter(|step| !step.is_empty()).collect();
        return Err(fail(format!(
            "the path must be keys and numbers of list entries joined by dots: did you mean {}?",
            steps.join(".")
        )));
    }
    let steps: Vec<&str> = key.split('.').collect();
    if steps.iter().any(|step| step.is_empty()) {
        return Err(fail("the path must be keys joined by dots, such as time.step".to_owned()));
    }
    if let Some(first) = steps.first().filter(|first| case.is_object() && case.get(**first).is_none()) {
        known_section(case, first, &steps).map_err(fail)?;
    }
    let (last, parents) = steps.split_last().ok_or_else(|| fail("the path is empty".to_owned()))?;
    let mut place = case;
    for (depth, step) in parents.iter().enumerate() {
        place = descend(place, step, &steps[..depth]).map_err(fail)?;
    }
    // As strict as the file: duplicate keys inside the value are refused too.
    let new = super::jsonc::parse(value)
        .or_else(|_| typed_number(value.trim()).map(Value::from).ok_or(()))
        .unwrap_or_else(|()| Value::String(value.to_owned()));
    assign(place, last, new, parents).map_err(fail)
}

/// Refuses a path that begins with no section of a case, with the paths that end as it does.
fn known_section(case: &Value, first: &str, steps: &[&str]) -> Result<(), String> {
    let schema = json_schema();
    let sections = schema.get("properties").and_then(Value::as_object).into_iter().flat_map(Map::keys);
    let sections: Vec<&str> = sections.map(String::as_str).collect();
    if sections.contains(&first) {
        return Ok(());
    }
    let none = format!("a case has no \"{first}\"");
    let mut paths = paths_in(case, steps);
    if let (true, &[name]) = (paths.is_empty(), steps) {
        let name = renamed(name).unwrap_or(name);
        paths = paths_in(case, &[name]);
        if paths.is_empty() {
            paths = places_of(&schema, name);
        }
    }
    Err(match (paths.is_empty(), did_you_mean(first, sections.iter().copied())) {
        (false, _) => listed(&format!("{none} at its top; paths that end so"), &paths),
        (true, Some(hint)) => format!("{none}: {hint}"),
        (true, None) => {
            listed(&format!("{none}; paths begin with"), &sections.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>())
        }
    })
}

fn descend<'a>(place: &'a mut Value, step: &str, above: &[&str]) -> Result<&'a mut Value, String> {
    match place {
        Value::Object(map) => Ok(map.entry(step).or_insert_with(|| Value::Object(Map::new()))),
        Value::Array(list) => {
            let index = index_in(list, step, above)?;
            list.get_mut(index).ok_or_else(|| not_in_list(step, above))
        }
        _ => Err(no_place(step, above)),
    }
}

fn assign(place: &mut Value, step: &str, new: Value, above: &[&str]) -> Result<(), String> {
    match place {
        Value::Object(map) => {
            if new.is_null() {
                map.remove(step);
            } else {
                map.insert(step.to_owned(), new);
            }
            Ok(())
        }
        Value::Array(list) => {
            let index = index_in(list, step, above)?;
            *list.get_mut(index).ok_or_else(|| not_in_list(step, above))? = new;
            Ok(())
        }
        _ => Err(no_place(step, above)),
    }
}

fn index_in(list: &[Value], step: &str, above: &[&str]) -> Result<usize, String> {
    let index: usize = step.parse().map_err(|_| not_in_list(step, above))?;
    if index < list.len() {
        return Ok(index);
    }
    Err(format!("{} has {} entries, counted from 0; there is no entry {index}", name(above), list.len()))
}

fn not_in_list(step: &str, above: &[&str]) -> String {
    format!("{} is a list: \"{step}\" should be the number of an entry", name(above))
}

fn no_place(step: &str, above: &[&str]) -> String {
    format!("{} is neither an object nor a list, so it has no \"{step}\"; set {} as a whole", name(above), name(above))
}

fn name(above: &[&str]) -> String {
    if above.is_empty() { "the case".to_owned() } else { above.join(".") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn set(key: &str, value: &str) -> Result<Value, String> {
        let mut case = json!({"time": {"step": 1, "method": "rk4"}, "list": [{"k": 1}, {"k": 2}]});
        apply(&mut case, key, value).map(|()| case).map_err(|error| error.to_string())
    }

    /// Numbers, texts, objects, list entries, new sections and removals are applied at the right place.
    #[test]
    fn replaces_what_the_path_names() {
        assert_eq!(set("time.step", "1e-3").expect("ok")["time"]["step"], json!(1e-3));
        for (text, number) in [(".001", 1e-3), ("+2.5", 2.5), ("-.5", -0.5), ("5.", 5.0)] {
            assert_eq!(set("time.step", text).expect("ok")["time"]["step"], json!(number), "{text}");
        }
        assert_eq!(set("time.method", "hht").expect("ok")["time"]["method"], json!("hht"));
        assert_eq!(set("list.1.k", "[1]").expect("ok")["list"][1]["k"], json!([1]));
        assert_eq!(set("output.frames.every", "2").expect("ok")["output"], json!({"frames": {"every": 2}}));
        assert!(set("time.method", "null").expect("ok")["time"].get("method").is_none());
    }

    /// The message for a wrong path names its wrong part.
    #[test]
    fn refuses_paths_that_lead_nowhere() {
        for (key, words) in [
            ("time.step.x", "time.step is neither an object nor a list"),
            ("list.2.k", "list has 2 entries"),
            ("list.x.k", "list is a list"),
            ("time..step", "keys joined by dots"),
            ("", "keys joined by dots"),
            ("/time/step", "did you mean time.step?"),
            ("list[1].k", "did you mean list.1.k?"),
            ("k", "paths that end so: list.0.k, list.1.k"),
            ("step", "paths that end so: time.step"),
            ("until_rest", "paths that end so: time.until_rest"),
            ("tim.step", "did you mean \"time\"?"),
            ("colour", "paths begin with: "),
        ] {
            let message = set(key, "1").expect_err("refused");
            assert!(message.contains(words), "{key}: {message}");
        }
    }
}
