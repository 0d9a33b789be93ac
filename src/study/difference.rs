//! Where a case differs from the one that a study was planned for, key by key.

use crate::case::diagnostics::excerpt;
use serde_json::Value;

/// How many keys are named.
const TOLD: usize = 4;

/// The keys in which two cases differ: "time.end was 2 and is 1 now"; empty if they do not.
pub fn differences(planned: &Value, now: &Value) -> String {
    let mut found = Vec::new();
    compare("", planned, now, &mut found);
    let more = found.len().saturating_sub(TOLD);
    found.truncate(TOLD);
    let told = found.join("; ");
    if more > 0 { format!("{told}; and {more} more") } else { told }
}

fn compare(key: &str, planned: &Value, now: &Value, found: &mut Vec<String>) {
    let below = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
    match (planned, now) {
        (Value::Object(a), Value::Object(b)) => {
            for (name, planned) in a {
                match b.get(name) {
                    Some(now) => compare(&below(name), planned, now, found),
                    None => found.push(format!("{} was {} and is not there now", below(name), excerpt(planned))),
                }
            }
            let new = b.iter().filter(|(name, _)| !a.contains_key(*name));
            found.extend(new.map(|(name, now)| format!("{} was not there and is {} now", below(name), excerpt(now))));
        }
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            a.iter().zip(b).enumerate().for_each(|(i, (a, b))| compare(&below(&i.to_string()), a, b, found));
        }
        (a, b) if a == b => {}
        (a, b) => found.push(format!("{key} was {} and is {} now", excerpt(a), excerpt(b))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn keys_that_differ_are_told() {
        let planned =
            json!({"name": "a", "time": {"end": 2, "step": 0.1}, "springs": [{"k": 1}, {"k": 2}], "ids": [1, 2]});
        let now =
            json!({"time": {"end": 1, "step": 0.1}, "name": "a", "springs": [{"k": 1}, {"k": 3, "l": 4}], "ids": [1]});
        let told = differences(&planned, &now);
        let mut told: Vec<&str> = told.split("; ").collect();
        told.sort_unstable();
        let expected = [
            "ids was [1,2] and is [1] now",
            "springs.1.k was 2 and is 3 now",
            "springs.1.l was not there and is 4 now",
            "time.end was 2 and is 1 now",
        ];
        assert_eq!(told, expected);
        assert_eq!(differences(&json!({"end": 2}), &json!({})), "end was 2 and is not there now");
        assert_eq!(differences(&planned, &planned), "");
        let (zeros, ones) = (json!([0, 0, 0, 0, 0, 0]), json!([1, 1, 1, 1, 1, 1]));
        assert!(differences(&zeros, &ones).ends_with("3 was 0 and is 1 now; and 2 more"));
    }
}
