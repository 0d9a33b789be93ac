//! What cloth and lines are: net or membrane, wrinkling, bending, slack, damping, weight, stiffness.

use serde_json::{Map, Value, json};

use super::{LINES, NETWORK, Search, group, scaled};
use crate::case::schema::ClothModel;
use crate::require::change::{Change, Variant};

/// [-] Poisson's ratio of a net, as that of the membranes that stand for it.
const OF_NETS: f64 = 1.0 / 3.0;
/// [-] How many times as stiff lines become that are to be stiff.
const STIFF: f64 = 10.0;

/// The selections that mean the cloth of a generated parachute, as edges and as triangles.
const CLOTH: [&str; 2] = ["cloth", "canopy"];

/// The `on` of the cloth in the other model; none where it is not known.
fn other_selection(on: &Value, [from, to]: [&str; 2]) -> Option<Value> {
    match on {
        Value::String(word) if word == "all" => Some(on.clone()),
        _ if on.get("group")?.as_str()? == from => Some(json!({"group": to})),
        _ => None,
    }
}

impl Search<'_> {
    /// The model of the cloth, and what membranes can do.
    pub(super) fn cloth(&mut self) {
        let nets: Vec<_> = self.entries("springs").filter(|(_, rule)| rule.get("membrane").is_some()).collect();
        let membranes: Vec<_> = self.entries("membranes").collect();
        let to_membranes = Variant::of(Change::Cloth(ClothModel::Membrane));
        let to_net = Variant::of(Change::Cloth(ClothModel::Net));
        let made = [
            nets.iter().try_fold(to_membranes, |variant, (at, rule)| {
                Some(variant.without(at.clone()).set(format!("{NETWORK}/membranes/-"), membrane_of(rule)?))
            }),
            membranes.iter().try_fold(to_net, |variant, (at, rule)| {
                Some(variant.without(at.clone()).set(format!("{NETWORK}/springs/-"), springs_of(rule)?))
            }),
        ];
        let models = [("membranes", "springs of the cloth"), ("a net", "membranes")];
        for (variant, (model, what)) in made.into_iter().zip(models) {
            match variant {
                Some(variant) => self.add(variant),
                None => {
                    let why = format!("cloth: {what} of this kind or on these parts are not tried as {model}");
                    self.found.kept.push(why);
                }
            }
        }
        let wrinkling = membranes.iter().filter(|(_, rule)| rule.get("wrinkling") == Some(&Value::Bool(true)));
        self.off("wrinkling", wrinkling.map(|(at, _)| format!("{at}/wrinkling")));
        let bending = self.get("bending").map(|_| format!("{NETWORK}/bending"));
        self.off("bending", bending);
    }

    /// Laws of springs, their dashpots, weight and stiffness.
    pub(super) fn springs(&mut self) {
        let rules: Vec<_> = self.entries("springs").collect();
        let with = |key: &str, of: &dyn Fn(&Value) -> bool| -> Vec<String> {
            let having =
                rules.iter().filter(|(_, rule)| rule.get(key).is_some_and(|value| !value.is_null()) && of(rule));
            having.map(|(at, _)| format!("{at}/{key}")).collect()
        };
        let is_cloth = |rule: &Value| rule.get("membrane").is_some();
        let is_line = |rule: &Value| group(rule).is_some_and(|group| LINES.contains(&group));
        let damping = self.entries("membranes").filter(|(_, rule)| rule.get("damping_time").is_some());
        let damping: Vec<String> = damping.map(|(at, _)| format!("{at}/damping_time")).collect();
        let dashpots = with("dashpot", &|_| true).into_iter().chain(damping).collect();
        let parts: [(&str, Vec<String>); 6] = [
            ("weight of lines", with("linear_density", &is_line)),
            ("weight of tapes", with("linear_density", &|rule| !is_line(rule))),
            ("Rayleigh damping", self.get("damping").map(|_| format!("{NETWORK}/damping")).into_iter().collect()),
            ("dashpots", dashpots),
            ("slack of cloth", with("slack", &is_cloth)),
            ("slack of lines and tapes", with("slack", &|rule| !is_cloth(rule))),
        ];
        for (what, at) in parts {
            self.off(what, at);
        }
        for of in ["riser", "lines"] {
            let mut stiff = Variant::of(Change::Stiffer { of: of.to_owned(), times: STIFF });
            for (at, rule) in rules.iter().filter(|(_, rule)| group(rule) == Some(of)) {
                for key in ["axial_rigidity", "stiffness"] {
                    if let Some(value) = rule.get(key).filter(|value| value.is_number()) {
                        stiff = stiff.set(format!("{at}/{key}"), scaled(value, STIFF));
                    }
                }
            }
            self.add(stiff);
        }
    }
}

/// Whether an object has no keys beside these.
fn only(rule: &Value, keys: &[&str]) -> bool {
    rule.as_object().is_some_and(|map| map.keys().all(|key| keys.contains(&key.as_str())))
}

/// Membranes in place of springs that stand for a sheet, as `tradeoff` has them.
fn membrane_of(rule: &Value) -> Option<Value> {
    let known = ["on", "membrane", "slack", "dashpot", "linear_density"];
    let slack = rule.get("slack").is_none_or(|slack| slack == "tension-only");
    if !only(rule, &known) || !slack || rule.get("linear_density").is_some() {
        return None;
    }
    let sheet = rule.get("membrane")?;
    let on = other_selection(rule.get("on")?, CLOTH)?;
    let mut made = Map::new();
    made.insert("on".to_owned(), on);
    for key in ["modulus", "thickness"] {
        made.insert(key.to_owned(), sheet.get(key)?.clone());
    }
    made.insert("poisson".to_owned(), OF_NETS.into());
    made.insert("wrinkling".to_owned(), rule.get("slack").is_some().into());
    if let Some(dashpot) = rule.get("dashpot") {
        made.insert("damping_time".to_owned(), dashpot.pointer("/axial/time")?.clone());
    }
    Some(made.into())
}

/// Springs in place of membranes of one modulus.
fn springs_of(rule: &Value) -> Option<Value> {
    let known = ["on", "thickness", "modulus", "poisson", "wrinkling", "damping_time"];
    let modulus = rule.get("modulus").filter(|modulus| modulus.is_number())?;
    if !only(rule, &known) {
        return None;
    }
    let [edges, triangles] = CLOTH;
    let mut made = Map::new();
    made.insert("on".to_owned(), other_selection(rule.get("on")?, [triangles, edges])?);
    made.insert("membrane".to_owned(), json!({"modulus": modulus, "thickness": rule.get("thickness")?}));
    if rule.get("wrinkling") == Some(&Value::Bool(true)) {
        made.insert("slack".to_owned(), "tension-only".into());
    }
    if let Some(time) = rule.get("damping_time") {
        made.insert("dashpot".to_owned(), json!({"axial": {"time": time}}));
    }
    Some(made.into())
}
