//! What a wrong key or value of a case was probably meant to be.

use serde_json::{Map, Value};

use super::diagnostics::{nearest, one_of};
use super::schema_parts::{kind, meant};
use crate::format_number::figures;

/// Names of other programs and textbooks, in small letters, and the keys of a case that mean the same.
const OTHER_NAMES: &[(&str, &str)] = &[
    ("dt", "step"),
    ("timestep", "step"),
    ("duration", "end"),
    ("tend", "end"),
    ("tmax", "end"),
    ("k", "stiffness"),
    ("ea", "axial_rigidity"),
    ("e", "modulus"),
    ("young", "modulus"),
    ("c", "coefficient"),
    ("cd", "coefficient"),
    ("cds", "drag_area"),
    ("d0", "nominal_diameter"),
    ("diameter", "nominal_diameter"),
    ("dc", "constructed_diameter"),
    ("integrator", "method"),
    ("scheme", "method"),
    ("damper", "dashpot"),
    ("fixed", "supports"),
    ("constraints", "supports"),
    ("bcs", "supports"),
];

/// Units that people write behind numbers: the factor to the unit of a case, and that unit.
const UNITS: &[(&str, f64, &str)] = &[
    ("um", 1e-6, "m"),
    ("mm", 1e-3, "m"),
    ("cm", 1e-2, "m"),
    ("m", 1.0, "m"),
    ("km", 1e3, "m"),
    ("in", 0.0254, "m"),
    ("ft", 0.3048, "m"),
    ("us", 1e-6, "s"),
    ("ms", 1e-3, "s"),
    ("s", 1.0, "s"),
    ("sec", 1.0, "s"),
    ("min", 60.0, "s"),
    ("h", 3600.0, "s"),
    ("g", 1e-3, "kg"),
    ("kg", 1.0, "kg"),
    ("t", 1e3, "kg"),
    ("lb", 0.453_592_37, "kg"),
    ("N", 1.0, "N"),
    ("kN", 1e3, "N"),
    ("lbf", 4.448_221_615_260_5, "N"),
    ("Pa", 1.0, "Pa"),
    ("kPa", 1e3, "Pa"),
    ("MPa", 1e6, "Pa"),
    ("GPa", 1e9, "Pa"),
    ("N/m", 1.0, "N/m"),
    ("kN/m", 1e3, "N/m"),
    ("N/mm", 1e3, "N/m"),
    ("m/s", 1.0, "m/s"),
    ("km/h", 1.0 / 3.6, "m/s"),
    ("m/s^2", 1.0, "m/s^2"),
    ("kg/m", 1.0, "kg/m"),
    ("g/m", 1e-3, "kg/m"),
    ("kg/m^2", 1.0, "kg/m^2"),
    ("g/m^2", 1e-3, "kg/m^2"),
    ("m^2", 1.0, "m^2"),
    ("deg", std::f64::consts::PI / 180.0, "rad"),
    ("°", std::f64::consts::PI / 180.0, "rad"),
    ("rad", 1.0, "rad"),
    ("%", 1e-2, "-"),
];

/// A finite number as people type it: also `.5`, `5.` and `+5`, which are not JSON.
pub(crate) fn typed_number(text: &str) -> Option<f64> {
    let plain = text.chars().all(|c| c.is_ascii_digit() || matches!(c, '.' | '+' | '-' | 'e' | 'E'));
    text.parse().ok().filter(|number: &f64| plain && number.is_finite())
}

/// How to write a text where a case needs a number; `unit` is that of the number, if it is known.
pub(crate) fn of_text(text: &str, unit: Option<&str>) -> Option<String> {
    let text = text.trim();
    if let Some(number) = typed_number(text) {
        return Some(format!("write the number without quotes: {number}"));
    }
    if let Some(number) = text.split_once(',').and_then(|(whole, part)| typed_number(&format!("{whole}.{part}"))) {
        return Some(format!("write a decimal point: {number}"));
    }
    let mut ends = text.char_indices().map(|(i, _)| i).rev();
    let parts = |end| Some((typed_number(text.get(..end)?.trim_end())?, text.get(end..)?.trim()));
    let (number, written) = ends.find_map(parts)?;
    let found = UNITS.iter().find(|(name, ..)| *name == written)?;
    let &(_, factor, si) = found;
    Some(match unit {
        Some(unit) if unit != si => format!("numbers have no unit; this one is in {unit}"),
        _ if si == "-" => format!("numbers have no unit: write {}", figures(factor * number, 12)),
        _ => format!("numbers have no unit; in {si} this is {}", figures(factor * number, 12)),
    })
}

/// How to write what stands at `offset` of a text that is no JSON: a decimal comma, a unit, a word without quotes.
pub(crate) fn of_broken(text: &str, offset: usize) -> Option<String> {
    let parts = |c: char| c.is_alphanumeric() || "+-.,/^°%_".contains(c);
    let (before, after) = text.split_at_checked(offset)?;
    // The reader stops within a word, behind a number or before a unit.
    let start = before.trim_end_matches(' ').trim_end_matches(parts).len();
    let behind = after.trim_start_matches(' ').trim_start_matches(parts).len();
    let written = text.get(start..text.len() - behind)?.trim().trim_end_matches(',');
    let word = written.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-'));
    if word && written.starts_with(char::is_alphabetic) {
        return Some(format!("write a text in double quotes: \"{written}\""));
    }
    of_text(written, None).filter(|_| typed_number(written).is_none())
}

/// The unit that the description of a number begins with: `m` of "[m] length".
pub(crate) fn unit(schema: &Value) -> Option<&str> {
    let text = schema.get("description")?.as_str()?;
    text.strip_prefix('[')?.split_once(']').map(|(unit, _)| unit)
}

/// Advice for a value out of its range, by the end of its pointer.
const OF_RANGES: &[(&str, &str)] = &[
    ("/outer_pressure_coefficient", "it is that behind a full canopy, below the pressure inside: about -0.6"),
    ("/law/table", "a measured curve needs few rows: they are joined by straight lines"),
    ("/poisson", "with one modulus it is below 1 too, with two moduli poisson^2 E2 is below E1"),
    ("/study/methods", CHOICE),
    ("/study/steps", CHOICE),
    ("/study/tolerances", CHOICE),
    ("/study/models", CHOICE),
];

const CHOICE: &str = "leave the key out to let the study choose";

/// Advice for the value at this pointer, if it is out of its range.
pub(crate) fn of_range(pointer: &str) -> Option<String> {
    OF_RANGES.iter().find(|(end, _)| pointer.ends_with(end)).map(|(_, advice)| (*advice).to_owned())
}

/// Levels of objects in an example.
const DEEP: usize = 4;

/// How an object is written that a number was given for: `{"every": 0.05}`.
pub(crate) fn example(root: &Value, schema: &Value, number: &Value) -> Option<String> {
    with_number(root, schema, number, DEEP)
}

fn with_number(root: &Value, schema: &Value, number: &Value, depth: usize) -> Option<String> {
    let schema = meant(root, schema);
    if matches!(kind(schema), "number" | "integer") {
        return Some(number.to_string());
    }
    let depth = depth.checked_sub(1)?;
    if let Some(branches) = schema.get("oneOf").and_then(Value::as_array) {
        // A vector is meant more often than what else may stand there.
        if branches.iter().any(|branch| kind(meant(root, branch)) == "array") {
            return None;
        }
        return branches.iter().find_map(|branch| with_number(root, branch, number, depth));
    }
    let properties = schema.get("properties")?.as_object()?;
    let required: Vec<&str> = match schema.get("required").and_then(Value::as_array) {
        Some(keys) => keys.iter().filter_map(Value::as_str).collect(),
        None => only_number(root, properties).into_iter().collect(),
    };
    let holds = |key| Some((key, with_number(root, properties.get(key)?, number, depth)?));
    let (key, value) = required.iter().copied().find_map(holds)?;
    let part = |other: &&str| if *other == key { format!("\"{other}\": {value}") } else { format!("\"{other}\": ...") };
    Some(format!("{{{}}}", required.iter().map(part).collect::<Vec<_>>().join(", ")))
}

/// The key of the only number among properties none of which is required, such as the length of a line.
fn only_number<'a>(root: &Value, properties: &'a Map<String, Value>) -> Option<&'a str> {
    let is_number = |schema: &Value| {
        let schema = meant(root, schema);
        kind(schema) == "number"
    };
    let mut numbers = properties.iter().filter(|(_, schema)| is_number(schema)).map(|(key, _)| key.as_str());
    let only = numbers.next();
    only.filter(|_| numbers.next().is_none())
}

/// The words of a key, in small letters: `nominal_diameter`, `nominalDiameter` and `Nominal diameter` have the same.
fn words(key: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut lower = false;
    for c in key.chars() {
        if !c.is_alphanumeric() || c.is_uppercase() && lower {
            words.push(String::new());
        }
        if c.is_alphanumeric() {
            words.last_mut().into_iter().for_each(|word| word.extend(c.to_lowercase()));
        }
        lower = c.is_lowercase();
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The key of a case that means the same as a name of other programs.
pub(crate) fn renamed(key: &str) -> Option<&'static str> {
    let joined = words(key).concat();
    OTHER_NAMES.iter().find(|(other, _)| *other == joined).map(|(_, name)| *name)
}

/// The known keys that an unknown `key` may stand for, the likely ones: that of another name, those that are written
/// with more or fewer words, or the one that is spelt alike. Of several, those that `missing` says are needed.
pub(crate) fn keys_like<'a>(key: &str, known: &[&'a str], missing: impl Fn(&str) -> bool) -> Vec<&'a str> {
    if let Some(name) = renamed(key).and_then(|name| known.iter().find(|known| **known == name)) {
        return vec![name];
    }
    let own = words(key);
    let within = |few: &[String], many: &[String]| !few.is_empty() && few.iter().all(|word| many.contains(word));
    let alike = |known: &&&str| {
        let other = words(known);
        within(&own, &other) || within(&other, &own)
    };
    let found: Vec<&str> = known.iter().filter(alike).copied().collect();
    let needed: Vec<&str> = found.iter().filter(|name| missing(name)).copied().collect();
    match (needed.is_empty(), found.is_empty()) {
        (false, _) => needed,
        (true, false) => found,
        (true, true) => nearest(key, known.iter().copied()).into_iter().collect(),
    }
}

/// "did you mean", for the keys of [`keys_like`].
pub(crate) fn did_you_mean_keys(keys: &[&str]) -> Option<String> {
    let quoted: Vec<String> = keys.iter().take(4).map(|key| format!("\"{key}\"")).collect();
    (!quoted.is_empty()).then(|| format!("did you mean {}?", quoted.join(" or ")))
}

/// Places to name in a message.
const PLACES: usize = 5;

/// Paths of the case, with dots, that end with these steps.
pub(crate) fn paths_in(case: &Value, steps: &[&str]) -> Vec<String> {
    let mut found = Vec::new();
    search(case, &mut Vec::new(), &mut |path: &[String]| {
        if path.len() > steps.len() && path.iter().rev().zip(steps.iter().rev()).all(|(a, b)| a == b) {
            found.push(path.join("."));
        }
    });
    found
}

fn search(value: &Value, path: &mut Vec<String>, visit: &mut impl FnMut(&[String])) {
    let mut below = |step: String, value: &Value| {
        path.push(step);
        visit(path);
        search(value, path, visit);
        path.pop();
    };
    match value {
        Value::Object(map) => map.iter().for_each(|(key, value)| below(key.clone(), value)),
        // The coordinates of a mesh have no keys.
        Value::Array(list) if list.iter().any(Value::is_object) => {
            list.iter().enumerate().for_each(|(i, value)| below(i.to_string(), value));
        }
        _ => {}
    }
}

/// Levels below the top of a case at which a key is searched for.
const LEVELS: usize = 6;

/// Paths of the schema, with dots, at which an object has this key; entries of lists are `0`. The shortest ones first.
pub(crate) fn places_of(root: &Value, key: &str) -> Vec<String> {
    let (mut found, mut level) = (Vec::new(), vec![(String::new(), root)]);
    for _ in 0..LEVELS {
        let mut next = Vec::new();
        for (path, schema) in level {
            for (name, schema) in members(root, schema) {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                if name == key && !found.contains(&path) {
                    found.push(path.clone());
                }
                next.push((path, schema));
            }
        }
        level = next;
    }
    found
}

/// The keys of an object in all its forms, with their schemas; `0` for the entries of a list.
fn members<'a>(root: &'a Value, schema: &'a Value) -> Vec<(String, &'a Value)> {
    let schema = meant(root, schema);
    // A selection without another holds the same keys again.
    let again = |branch: &&Value| meant(root, branch).pointer("/properties/except").is_some();
    let branches = schema.get("oneOf").and_then(Value::as_array).into_iter().flatten().filter(|one| !again(one));
    let own = schema.get("properties").and_then(Value::as_object).into_iter().flat_map(Map::iter);
    let items = schema.get("items").map(|items| ("0".to_owned(), items));
    let own = own.map(|(key, schema)| (key.clone(), schema)).chain(items);
    own.chain(branches.flat_map(|branch| members(root, branch))).collect()
}

/// "known at a, b": the first few places.
pub(crate) fn listed(what: &str, places: &[String]) -> String {
    let more = places.len().saturating_sub(PLACES);
    let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{rest}", one_of(what, &places[..places.len().min(PLACES)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_as_numbers_of_the_unit() {
        for (text, unit, words) in [
            ("0.5", None, "without quotes: 0.5"),
            ("0,5", None, "decimal point: 0.5"),
            ("5 mm", Some("m"), "in m this is 0.005"),
            ("0.002s", Some("s"), "in s this is 0.002"),
            ("1e-3 s", Some("s"), "in s this is 0.001"),
            ("25°", Some("rad"), "in rad this is 0.436332312999"),
            ("2 kN", Some("N"), "in N this is 2000"),
            ("5 mm", Some("s"), "this one is in s"),
            ("3 %", Some("-"), "write 0.03"),
        ] {
            let found = of_text(text, unit).unwrap_or_default();
            assert!(found.contains(words), "{text}: {found}");
        }
        for text in ["", "five", "5 parsec", "NaN", "inf", "1,2,3", "mm"] {
            assert_eq!(of_text(text, Some("m")), None, "{text}");
        }
    }

    #[test]
    fn texts_that_are_no_json_are_read() {
        for (text, word, words) in [
            (r#"{"step": 0,01}"#, "01", "decimal point: 0.01"),
            (r#"{"step": 5 ms}"#, "ms", "in s this is 0.005"),
            (r#"{"step": 0.002s, "end": 1}"#, "s,", "in s this is 0.002"),
            (r#"{"method": newmark}"#, "ewmark", "in double quotes: \"newmark\""),
        ] {
            let found = of_broken(text, text.find(word).expect("it is there")).unwrap_or_default();
            assert!(found.contains(words), "{text}: {found}");
        }
        assert_eq!(of_broken(r#"{"a": 1 "b": 2}"#, 8), None);
        assert_eq!(of_broken("é", 1), None);
    }

    #[test]
    fn keys_are_found_by_their_words() {
        let known = ["nominal_diameter", "vent_diameter", "gores", "step"];
        let missing = |key: &str| key == "nominal_diameter";
        for (key, expected) in [
            ("diameter", &["nominal_diameter"][..]),
            ("nominalDiameter", &["nominal_diameter"]),
            ("Nominal-Diameter", &["nominal_diameter"]),
            ("time_step", &["step"]),
            ("dt", &["step"]),
            ("gore", &["gores"]),
            ("colour", &[]),
        ] {
            assert_eq!(keys_like(key, &known, missing), expected, "{key}");
        }
        let several = ["skirt_diameter", "vent_diameter"];
        assert_eq!(keys_like("diameter", &several, |_| false), several);
    }
}
