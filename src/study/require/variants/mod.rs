//! The variants of a case that are simpler or finer by one thing: found in the case as the user wrote it.
//!
//! A finder adds the variants that apply to a case. What cannot be changed is said.

mod air;
mod cloth;
mod mesh;
mod point;
mod step;

use serde_json::Value;

use super::change::{Change, Variant};
use crate::case::{Case, Problem};

/// JSON pointer of the network.
const NETWORK: &str = "/system/network";
/// Groups of a generated parachute whose edges are lines, which no cloth carries.
const LINES: [&str; 4] = ["lines", "inner-lines", "riser", "slings"];
/// Group of the payload's nodes.
const PAYLOAD: &str = "payload";

/// The variants of a case.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Variants {
    /// those that apply
    pub all: Vec<Variant>,
    /// what cannot be changed, and why
    pub kept: Vec<String>,
}

/// A case and the variants found in it so far.
struct Search<'c> {
    json: &'c Value,
    problem: &'c Problem,
    found: Variants,
}

impl Variants {
    /// All variants of a case.
    pub fn of(case: &Case) -> Self {
        let problem = case.problem();
        let mut search = Search { json: &problem.case_json, problem, found: Variants::default() };
        search.point(case);
        // Laws that implicit steps find hard come last: a spent budget leaves them out first.
        search.mesh();
        search.step();
        search.air();
        search.springs();
        search.cloth();
        search.found
    }

    /// The case from another initial speed and with another payload, as far as it has them.
    pub fn elsewhere(case: &Value, times: f64) -> Vec<Variant> {
        let mut all = Vec::new();
        let at = format!("{NETWORK}/initial/velocity");
        if let Some(velocity) = case.pointer(&at).filter(|value| !value.is_null()) {
            all.push(Variant::of(Change::Speed(times)).set(at, scaled(velocity, times)));
        }
        let points = entries(case, &format!("{NETWORK}/mass/points"));
        let mut payload = Variant::of(Change::PayloadMass(times));
        for (at, point) in points.filter(|(_, point)| group(point) == Some(PAYLOAD)) {
            for key in ["mass", "total"] {
                if let Some(mass) = point.get(key).filter(|value| value.is_number()) {
                    payload = payload.set(format!("{at}/{key}"), scaled(mass, times));
                }
            }
        }
        all.extend(Some(payload).filter(|variant| !variant.edits.is_empty()));
        all
    }
}

impl<'c> Search<'c> {
    fn get(&self, key: &str) -> Option<&'c Value> {
        self.json.pointer(&format!("{NETWORK}/{key}")).filter(|value| !value.is_null())
    }

    /// The entries of a list of the network, with their JSON pointers.
    fn entries(&self, key: &str) -> impl Iterator<Item = (String, &'c Value)> + use<'c> {
        entries(self.json, &format!("{NETWORK}/{key}"))
    }

    /// Adds a variant that sets something.
    fn add(&mut self, variant: Variant) {
        if !variant.edits.is_empty() {
            self.found.all.push(variant);
        }
    }

    /// Adds one that leaves out what is at some JSON pointers.
    fn off(&mut self, what: &str, at: impl IntoIterator<Item = String>) {
        let off = Variant::of(Change::Off(what.to_owned()));
        self.add(at.into_iter().fold(off, Variant::without));
    }
}

fn entries<'c>(case: &'c Value, at: &str) -> impl Iterator<Item = (String, &'c Value)> + use<'c> {
    let at = at.to_owned();
    let list = case.pointer(&at).and_then(Value::as_array).map_or(&[][..], Vec::as_slice);
    list.iter().enumerate().map(move |(i, entry)| (format!("{at}/{i}"), entry))
}

/// The group that the `on` of an entry selects.
fn group(entry: &Value) -> Option<&str> {
    entry.pointer("/on/group")?.as_str()
}

/// The `on` of an entry in words.
fn selected(entry: &Value) -> String {
    match (group(entry), entry.get("on")) {
        (Some(group), _) => group.to_owned(),
        (None, Some(Value::String(word))) => word.clone(),
        (None, Some(Value::Object(map))) => map.keys().next().cloned().unwrap_or_default(),
        _ => String::new(),
    }
}

/// Numbers times a factor.
fn scaled(value: &Value, times: f64) -> Value {
    match value {
        Value::Array(list) => list.iter().map(|value| scaled(value, times)).collect(),
        other => other.as_f64().map_or_else(|| other.clone(), |x| (x * times).into()),
    }
}
