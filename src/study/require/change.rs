//! A change of a case by one thing: its words, and the keys that it sets.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::case::schema::ClothModel;
use crate::case::{Case, CaseError};
use crate::format_number::figures;

/// What is changed in a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Change {
    /// a number of cells, segments or nodes of a generated mesh
    Mesh {
        /// what is counted: `lines`
        of: String,
        /// the number as it was
        from: String,
        /// the number as it is
        to: String,
        /// what it counts, in the plural
        unit: String,
        /// whether there are more of them
        finer: bool,
    },
    /// [s] the step
    Step {
        /// as it was
        from: f64,
        /// as it is
        to: f64,
    },
    /// [-] the relative tolerance, and the absolute one with it
    Tolerance {
        /// as it was
        from: f64,
        /// as it is
        to: f64,
    },
    /// the model of the cloth
    Cloth(ClothModel),
    /// the whole parachute becomes one mass with a drag area
    Point,
    /// a rigid payload becomes a point
    PointPayload,
    /// a part of the model is left out: `drag of lines`
    Off(String),
    /// [m/s] a wind over height becomes the same at all heights
    UniformWind([f64; 3]),
    /// [kg/m^3] a density over height becomes the same at all heights
    ConstantDensity(f64),
    /// [-] springs become so many times as stiff
    Stiffer {
        /// which: `riser`
        of: String,
        /// how many times
        times: f64,
    },
    /// [-] the initial velocity is multiplied
    Speed(f64),
    /// [-] the mass of the payload is multiplied
    PayloadMass(f64),
}

/// Which of the errors of a model a change shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ErrorOf {
    /// of the steps
    Step,
    /// of the mesh
    Mesh,
    /// of what the model leaves out
    Model,
}

impl ErrorOf {
    /// All of them, with their words.
    pub const ALL: [(ErrorOf, &'static str); 3] =
        [(ErrorOf::Step, "step"), (ErrorOf::Mesh, "mesh"), (ErrorOf::Model, "model")];
}

/// A change in words.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Words {
    /// what is changed
    pub change: String,
    /// from what
    pub from: String,
    /// to what
    pub to: String,
    /// the unit of both; empty for words
    pub unit: String,
}

impl Change {
    /// In words.
    pub fn words(&self) -> Words {
        let words = |change: &str, from: String, to: String, unit: &str| {
            let [change, unit] = [change, unit].map(str::to_owned);
            Words { change, from, to, unit }
        };
        let number = |x: f64| figures(x, 4);
        match self {
            Change::Mesh { of, from, to, unit, .. } => words(of, from.clone(), to.clone(), unit),
            Change::Step { from, to } => words("step", number(*from), number(*to), "s"),
            Change::Tolerance { from, to } => words("tolerance", format!("{from:e}"), format!("{to:e}"), ""),
            Change::Cloth(model) => {
                let other = if *model == ClothModel::Net { ClothModel::Membrane } else { ClothModel::Net };
                words("cloth", other.word().to_owned(), model.word().to_owned(), "")
            }
            Change::Point => words("parachute", "network".to_owned(), "point".to_owned(), ""),
            Change::PointPayload => words("payload", "rigid".to_owned(), "point".to_owned(), ""),
            Change::Off(what) => words(what, "on".to_owned(), "off".to_owned(), ""),
            Change::UniformWind(wind) => {
                let wind = wind.map(number).join(", ");
                words("wind", "over height".to_owned(), format!("({wind}) m/s at all heights"), "")
            }
            Change::ConstantDensity(density) => {
                let to = format!("{} kg/m^3 at all heights", number(*density));
                words("density of the air", "over height".to_owned(), to, "")
            }
            Change::Stiffer { of, times } => {
                words(&format!("stiffness of {of}"), "1".to_owned(), number(*times), "times")
            }
            Change::Speed(times) => words("initial velocity", "1".to_owned(), number(*times), "times"),
            Change::PayloadMass(times) => words("mass of payload", "1".to_owned(), number(*times), "times"),
        }
    }

    /// The error that it shows.
    pub fn shows(&self) -> ErrorOf {
        match self {
            Change::Step { .. } | Change::Tolerance { .. } => ErrorOf::Step,
            Change::Mesh { .. } => ErrorOf::Mesh,
            _ => ErrorOf::Model,
        }
    }

    /// Whether it makes the discretisation finer, and so shows the error of the case itself.
    pub fn finer(&self) -> bool {
        match self {
            Change::Mesh { finer, .. } => *finer,
            Change::Step { from, to } | Change::Tolerance { from, to } => to < from,
            _ => false,
        }
    }
}

impl std::fmt::Display for Change {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Words { change, from, to, unit } = self.words();
        match self {
            Change::Off(_) => write!(f, "{change}: {to}"),
            Change::Stiffer { .. } | Change::Speed(_) | Change::PayloadMass(_) => write!(f, "{change}: {to} {unit}"),
            _ if unit.is_empty() => write!(f, "{change}: {from} -> {to}"),
            _ => write!(f, "{change}: {from} -> {to} {unit}"),
        }
    }
}

/// A value that is put into a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Edit {
    /// JSON pointer in the case as it was written; one that ends in `/-` adds an entry to a list
    pub at: String,
    /// the value; null takes the key or the entry away
    pub value: Value,
}

/// A change and what it sets.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Variant {
    /// the change
    pub change: Change,
    /// what it sets
    pub edits: Vec<Edit>,
}

impl Variant {
    /// Of a change without edits.
    pub fn of(change: Change) -> Self {
        Variant { change, edits: Vec::new() }
    }

    /// With a value at a JSON pointer.
    #[must_use]
    pub fn set(mut self, at: impl Into<String>, value: impl Into<Value>) -> Self {
        self.edits.push(Edit { at: at.into(), value: value.into() });
        self
    }

    /// Without what is at a JSON pointer.
    #[must_use]
    pub fn without(self, at: impl Into<String>) -> Self {
        self.set(at, Value::Null)
    }

    /// Whether both set the same key, so that only one of them can be made.
    pub fn excludes(&self, other: &Variant) -> bool {
        let within = |a: &str, b: &str| a.strip_prefix(b).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'));
        let meet = |a: &Edit, b: &Edit| !a.at.ends_with("/-") && (within(&a.at, &b.at) || within(&b.at, &a.at));
        self.edits.iter().any(|a| other.edits.iter().any(|b| meet(a, b)))
    }
}

/// A case with all edits of some variants. Pointers are those of the case as it was written, so that the order does not
/// matter; what is taken away leaves its list only then.
pub fn edited<'v>(case: &Value, variants: impl IntoIterator<Item = &'v Variant>) -> Value {
    let mut changed = case.clone();
    for edit in variants.into_iter().flat_map(|variant| &variant.edits) {
        put(&mut changed, &edit.at, edit.value.clone());
    }
    renumber(&mut changed);
    purge(&mut changed);
    tidy(&mut changed);
    changed
}

fn put(case: &mut Value, at: &str, value: Value) {
    let Some((parent, key)) = at.rsplit_once('/') else { return };
    if case.pointer(parent).is_none_or(Value::is_null) {
        put(case, parent, if key == "-" { Value::Array(Vec::new()) } else { Value::Object(Map::new()) });
    }
    match case.pointer_mut(parent) {
        Some(Value::Object(map)) => {
            map.insert(key.to_owned(), value);
        }
        Some(Value::Array(list)) if key == "-" => list.push(value),
        Some(Value::Array(list)) => {
            if let Some(entry) = key.parse::<usize>().ok().and_then(|number| list.get_mut(number)) {
                *entry = value;
            }
        }
        _ => {}
    }
}

/// A case with all edits of some variants, read anew.
///
/// # Errors
/// The faults of the changed case.
pub(super) fn changed<'v>(base: &Case, variants: impl IntoIterator<Item = &'v Variant>) -> Result<Case, CaseError> {
    let full = &base.problem().case_json;
    let changed = edited(full, variants);
    // Sections as a whole, so that a mesh that stays is not made again.
    let sections = changed.as_object().into_iter().flatten().filter(|(key, value)| full.get(key) != Some(value));
    let overrides: Vec<(String, String)> = sections.map(|(key, value)| (key.clone(), value.to_string())).collect();
    base.with(&overrides)
}

/// Quantities of springs are named by the number of their rule, which is another one once an earlier rule is away.
fn renumber(case: &mut Value) {
    let Some(rules) = case.pointer("/system/network/springs").and_then(Value::as_array) else { return };
    let here: Vec<bool> = rules.iter().map(|rule| !rule.is_null()).collect();
    let quantities = case.pointer_mut("/study/quantities").and_then(Value::as_array_mut).into_iter().flatten();
    for quantity in quantities {
        let number = quantity.as_str().and_then(|name| {
            let (number, rest) = name.strip_prefix("springs[")?.split_once(']')?;
            Some((number.parse::<usize>().ok().filter(|number| here.get(*number) == Some(&true))?, rest.to_owned()))
        });
        if let Some((number, rest)) = number {
            let now = here[..number].iter().filter(|here| **here).count();
            *quantity = format!("springs[{now}]{rest}").into();
        }
    }
}

/// Takes away what is null.
fn purge(value: &mut Value) {
    match value {
        Value::Object(map) => {
            map.retain(|_, value| !value.is_null());
            map.values_mut().for_each(purge);
        }
        // Numbers are no edits, and there may be millions of them.
        Value::Array(list) if !list.first().is_some_and(Value::is_number) => {
            list.retain(|value| !value.is_null());
            list.iter_mut().for_each(purge);
        }
        _ => {}
    }
}

/// Takes away what may not be empty: a sum of no winds, air that acts on nothing.
fn tidy(case: &mut Value) {
    let Some(network) = case.pointer_mut("/system/network").and_then(Value::as_object_mut) else { return };
    let Some(aero) = network.get_mut("aero").and_then(Value::as_object_mut) else { return };
    let empty = |value: Option<&Value>| value.and_then(Value::as_array).is_none_or(Vec::is_empty);
    if aero.get("wind").is_some_and(|wind| wind.is_object() && wind.get("sum").is_some() && empty(wind.get("sum"))) {
        aero.remove("wind");
    }
    if !aero.contains_key("law") && !aero.contains_key("canopy") && empty(aero.get("drag")) {
        network.remove("aero");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn edits_of_several_variants_do_not_move_each_other() {
        let case = json!({"system": {"network": {"aero": {"drag": [1, 2, 3], "wind": [0, 0, 5]}, "springs": []}}});
        let drag = |number: usize| {
            let off = Variant::of(Change::Off(number.to_string()));
            off.without(format!("/system/network/aero/drag/{number}"))
        };
        let case_with_objects = {
            let mut case = case;
            case["system"]["network"]["aero"]["drag"] = json!([{"a": 1}, {"b": 2}, {"c": 3}]);
            case
        };
        let of = |variants: &[Variant]| edited(&case_with_objects, variants)["system"]["network"]["aero"].clone();
        assert_eq!(of(&[drag(0), drag(2)])["drag"], json!([{"b": 2}]));
        assert_eq!(of(&[drag(2), drag(0)])["drag"], json!([{"b": 2}]));
        assert_eq!(of(&[drag(2), drag(0), drag(1)]), Value::Null);
        let added = Variant::of(Change::Off("x".into())).set("/system/network/membranes/-", json!({"on": "all"}));
        let case = edited(&case_with_objects, [&added, &added]);
        assert_eq!(case["system"]["network"]["membranes"], json!([{"on": "all"}, {"on": "all"}]));
        assert!(drag(1).excludes(&drag(1)) && !drag(1).excludes(&drag(2)));
        assert!(drag(1).excludes(&Variant::of(Change::PointPayload).without("/system/network/aero/drag")));
        assert!(!drag(1).excludes(&Variant::of(Change::PointPayload).without("/system/network/aero/drag/10")));
    }

    #[test]
    fn quantities_follow_the_rules_of_their_springs() {
        let case = json!({
            "system": {"network": {"springs": [{"a": 1}, {"b": 2}, {"c": 3}]}},
            "study": {"quantities": ["springs[2] lines.tension.peak", "springs[0] a.tension.peak", "opening_load"]}
        });
        let away = Variant::of(Change::PointPayload).without("/system/network/springs/1");
        let expected = json!(["springs[1] lines.tension.peak", "springs[0] a.tension.peak", "opening_load"]);
        assert_eq!(edited(&case, [&away])["study"]["quantities"], expected);
        // What has no rule any more keeps its name, which no gauge has.
        let away = Variant::of(Change::PointPayload).without("/system/network/springs/2");
        assert_eq!(edited(&case, [&away])["study"], case["study"]);
    }

    #[test]
    fn changes_in_words() {
        let mesh = Change::Mesh {
            of: "lines".into(),
            from: "6".into(),
            to: "1".into(),
            unit: "segments".into(),
            finer: false,
        };
        assert_eq!(mesh.to_string(), "lines: 6 -> 1 segments");
        assert_eq!(Change::Off("drag of payload".into()).to_string(), "drag of payload: off");
        assert_eq!(Change::Cloth(ClothModel::Membrane).to_string(), "cloth: net -> membrane");
        assert_eq!(Change::Step { from: 0.002, to: 0.004 }.to_string(), "step: 0.002 -> 0.004 s");
        assert_eq!(Change::Stiffer { of: "riser".into(), times: 10.0 }.to_string(), "stiffness of riser: 10 times");
    }
}
