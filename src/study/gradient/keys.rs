//! The numbers of a case by which derivatives are taken, and the case with values beside theirs.

use super::error::GradientError;
use crate::case::Case;
use crate::scene::Scene;
use crate::sensitivity::difference::{PLACES, RELATIVE};
use crate::simulation::build_scene;
use serde_json::Value;

/// Most numbers at once: each of them has four scenes.
const MOST: usize = 200;
/// Sections of a case that are no part of the scene.
const NOT_OF_THE_SCENE: [&str; 5] = ["name", "time", "solver", "output", "study"];

/// A number of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyValue {
    /// its key
    pub key: String,
    /// its value
    pub value: f64,
}

impl KeyValue {
    /// The step of differences at a state, in its unit.
    pub(super) fn h(&self) -> f64 {
        self.share(RELATIVE)
    }

    /// A share of the number, in its unit; of 0, that of 1.
    pub(super) fn share(&self, share: f64) -> f64 {
        if self.value == 0.0 { share } else { share * self.value.abs() }
    }
}

/// The case with four values beside that of a number.
pub(super) struct Variant(pub [Case; 4]);

impl Variant {
    /// Its values are `h` apart.
    pub(super) fn of(case: &Case, number: &KeyValue, h: f64) -> Result<Self, GradientError> {
        let beside = |place: f64| {
            let value = number.value + place * h;
            let source = |source| GradientError::Beside { key: number.key.clone(), value, source };
            case.with(&[(number.key.clone(), format!("{value:e}"))]).map_err(source)
        };
        let [a, b, c, d] = PLACES.map(beside);
        Ok(Variant([a?, b?, c?, d?]))
    }

    pub(super) fn scenes(&self, threads: usize) -> Result<[Box<dyn Scene>; 4], GradientError> {
        let [a, b, c, d] = self.0.each_ref().map(|case| build_scene(case.problem().clone().take_system(), threads));
        Ok([a?, b?, c?, d?])
    }
}

/// The numbers that keys name: a number, all numbers below a key, or the only key that ends so.
pub(super) fn resolve(case: &Case, keys: &[String]) -> Result<Vec<KeyValue>, GradientError> {
    let mut all = Vec::new();
    numbers_of(&case.problem().case_json, String::new(), &mut all);
    let mut found: Vec<KeyValue> = Vec::new();
    for key in keys {
        let fault = |why: String| GradientError::Key { key: key.clone(), why };
        let of = named(&all, key).map_err(fault)?;
        if let Some(outside) = of.iter().find(|one| NOT_OF_THE_SCENE.contains(&section(&one.key))) {
            return Err(fault(format!("{} is no part of the scene", outside.key)));
        }
        for one in of {
            if !found.contains(&one) {
                found.push(one);
            }
        }
    }
    if found.len() > MOST {
        let why = format!("{} numbers; derivatives are taken by at most {MOST} at once", found.len());
        return Err(GradientError::Key { key: keys.join(" "), why });
    }
    Ok(found)
}

fn section(key: &str) -> &str {
    key.split('.').next().unwrap_or_default()
}

fn numbers_of(value: &Value, key: String, to: &mut Vec<KeyValue>) {
    let below = |step: &str| if key.is_empty() { step.to_owned() } else { format!("{key}.{step}") };
    match value {
        Value::Object(map) => map.iter().for_each(|(step, value)| numbers_of(value, below(step), to)),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, value)| numbers_of(value, below(&i.to_string()), to))
        }
        Value::Number(number) => to.extend(number.as_f64().map(|value| KeyValue { key: key.clone(), value })),
        _ => {}
    }
}

/// Whether `key` is `name`, or below it.
fn is_at(key: &str, name: &str) -> bool {
    key.strip_prefix(name).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

fn named(all: &[KeyValue], key: &str) -> Result<Vec<KeyValue>, String> {
    let exact: Vec<KeyValue> = all.iter().filter(|one| is_at(&one.key, key)).cloned().collect();
    if !exact.is_empty() {
        return Ok(exact);
    }
    // Beginnings of keys whose last steps are those given.
    let mut begins: Vec<&str> = Vec::new();
    for one in all {
        for (at, _) in one.key.match_indices('.') {
            let rest = &one.key[at + 1..];
            if is_at(rest, key) && !begins.contains(&&one.key[..at]) {
                begins.push(&one.key[..at]);
            }
        }
    }
    match begins[..] {
        [] => Err("the case has no number there; write the number into the case, if it is a default".to_owned()),
        [begin] => {
            let whole = format!("{begin}.{key}");
            Ok(all.iter().filter(|one| is_at(&one.key, &whole)).cloned().collect())
        }
        _ => {
            let some: Vec<String> = begins.iter().take(6).map(|begin| format!("{begin}.{key}")).collect();
            let more = if begins.len() > some.len() { " …" } else { "" };
            Err(format!("{} keys end so: {}{more}", begins.len(), some.join(", ")))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn keys(key: &str) -> Result<Vec<String>, String> {
        let case = json!({"system": {"network": {"springs": [{"stiffness": 1}, {"stiffness": 2.5, "rest": 3}],
            "gravity": [0, 0, -9.81]}}});
        let mut all = Vec::new();
        numbers_of(&case, String::new(), &mut all);
        named(&all, key).map(|of| of.into_iter().map(|one| format!("{}={}", one.key, one.value)).collect())
    }

    #[test]
    fn keys_are_numbers_all_numbers_below_or_unique_ends() {
        let of = |key| keys(key).expect(key);
        assert_eq!(of("system.network.springs.1.rest"), ["system.network.springs.1.rest=3"]);
        assert_eq!(of("springs.0.stiffness"), ["system.network.springs.0.stiffness=1"]);
        assert_eq!(of("gravity").len(), 3);
        assert_eq!(of("system.network.springs").len(), 3);
        assert!(keys("stiffness").expect_err("two").contains("2 keys end so: system.network.springs.0.stiffness"));
        assert!(keys("rest.x").expect_err("none").contains("no number there"));
        assert!(keys("est").expect_err("no whole step").contains("no number there"));
    }
}
