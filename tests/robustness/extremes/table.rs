//! The hostile cases: a scene, what is changed in it, what must hold beyond what holds for all.

use super::membranes::{bars, bending, membranes};
use super::scenes::{chain, mote, net, patch, sail};
use super::states::{damping, denormals, geometry, loads, pendulums, slack};
use super::verdict::{End, Kind};
use canopy_fem::integrate::registry::{Family, MethodInfo};
use serde_json::Value;

/// What a case must come to, beyond the rules for all ends.
#[derive(Clone, Copy, Debug)]
pub enum Must {
    /// any documented end
    End,
    /// completed, with every method
    Complete,
    /// completed with implicit methods, which have no limit here
    CompleteImplicit,
    /// refused, with these words in the message
    Refuse(&'static str),
}

impl Must {
    pub fn hold(self, kind: Kind, method: &MethodInfo, end: &End) -> Result<(), String> {
        let expected = match self {
            Must::End => return Ok(()),
            Must::Complete => Kind::Completed,
            Must::CompleteImplicit if method.family == Family::Implicit => Kind::Completed,
            Must::CompleteImplicit => return Ok(()),
            Must::Refuse(_) => Kind::Refused,
        };
        let words = match end {
            End::Refused(words) => words.clone(),
            End::Ran(ran) => format!("{:?}", ran.outcome.failure),
            End::Panicked(_) | End::Hung => String::new(),
        };
        if kind != expected {
            // What a method does to velocities in steps far beyond a period is its own, and the user is told.
            if (kind, expected) == (Kind::Doubted, Kind::Completed) && method.family == Family::Implicit {
                return Ok(());
            }
            return Err(format!("{kind:?} where {expected:?} is expected: {words}"));
        }
        match self {
            Must::Refuse(part) if !words.contains(part) => Err(format!("no \"{part}\" in: {words}")),
            _ => Ok(()),
        }
    }
}

/// One case of the table.
pub struct Hostile {
    pub name: String,
    pub json: Value,
    sets: Vec<(String, String)>,
    pub must: Must,
}

impl Hostile {
    /// The changes, and the method.
    pub fn sets_for(&self, method: &str) -> Vec<(String, String)> {
        let mut sets = self.sets.clone();
        sets.push(("time.method".to_owned(), method.to_owned()));
        sets
    }
}

pub const K: &str = "system.network.springs.0.stiffness";
pub const NODAL: &str = "system.network.mass.nodal";
const DENSITY: &str = "system.network.mass.areal_density";
pub const GRAVITY: &str = "system.network.gravity";
pub const WIND: &str = "system.network.aero.wind";
const LAW: &str = "system.network.aero.law";
pub const STEP: &str = "time.step";
pub const END: &str = "time.end";

/// Twenty steps of a size.
pub fn steps(h: f64) -> [(&'static str, String); 2] {
    [(STEP, format!("{h:e}")), (END, format!("{:e}", 20.0 * h))]
}

pub fn hostile(name: &str, json: Value, must: Must, sets: &[(&str, &str)]) -> Hostile {
    let sets = sets.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    Hostile { name: name.to_owned(), json, sets, must }
}

/// Cases and methods known not to hold, and why; each is to be mended and then to leave this list.
pub const KNOWN: [(&str, &str, &str); 0] = [];

/// The table.
pub fn cases() -> Vec<Hostile> {
    let springs = [stiffness(), masses(), times(), wind(), geometry(), slack(), loads(), damping(), denormals()];
    springs.into_iter().chain([membranes(), bars(), bending(), pendulums()]).flatten().collect()
}

/// Stiffness, step and wind at the ends of their ranges together.
pub fn corners() -> Vec<Hostile> {
    let mut all = Vec::new();
    for k in ["1e-12", "1", "1e6", "1e15"] {
        for h in [1e-15, 1e-6, 1e-3, 1.0, 1e6] {
            for v in ["[0, 0, 0]", "[0, 0, 50]", "[1e12, 0, 1e12]"] {
                let [step, end] = steps(h);
                let sets = [(K, k), (WIND, v), (step.0, &step.1), (end.0, &end.1)];
                all.push(hostile(&format!("k {k} N/m, h {h:e} s, wind {v}"), sail(), Must::End, &sets));
            }
        }
    }
    all
}

fn stiffness() -> Vec<Hostile> {
    let soft = ["1e-12", "1e-6", "1"].map(|k| hostile(&format!("k {k} N/m"), net(), Must::Complete, &[(K, k)]));
    let stiff = ["1e6", "1e9", "1e12", "1e15"]
        .map(|k| hostile(&format!("k {k} N/m"), net(), Must::CompleteImplicit, &[(K, k)]));
    let beyond = ["1e100", "1e300"].map(|k| hostile(&format!("k {k} N/m"), net(), Must::End, &[(K, k)]));
    soft.into_iter().chain(stiff).chain(beyond).collect()
}

fn masses() -> Vec<Hostile> {
    let list = |light: &str| format!("[1, {light}, 1, {light}, 1]");
    let ratio = |light: &str| hostile(&format!("mass ratio 1 : {light}"), chain(), Must::End, &[(NODAL, &list(light))]);
    let mut all: Vec<_> = ["1e-6", "1e-12", "1e-200", "1e6", "1e12", "1e200"].map(ratio).into();
    all.push(hostile("areal density 1e-12 kg/m^2", sail(), Must::End, &[(DENSITY, "1e-12")]));
    all.push(hostile("areal density 1e12 kg/m^2", sail(), Must::Complete, &[(DENSITY, "1e12")]));
    all.push(hostile("no mass", chain(), Must::Refuse("mass"), &[(NODAL, "0")]));
    all
}

fn times() -> Vec<Hostile> {
    let at = |h: f64, scene: Value, must: Must| {
        let [step, end] = steps(h);
        hostile(&format!("{} in steps of {h:e} s", scene["name"]), scene, must, &[(step.0, &step.1), (end.0, &end.1)])
    };
    let mut all = Vec::new();
    for h in [1e-119, 1e-100, 1e-15, 1e-9] {
        all.push(at(h, net(), Must::Complete));
        all.push(at(h, sail(), Must::Complete));
        all.push(at(h, patch(0.0), Must::Complete));
    }
    for h in [1.0, 1e3, 1e6, 1e100] {
        all.extend([net(), sail(), patch(0.0), chain(), mote()].map(|scene| at(h, scene, Must::End)));
    }
    all.push(hostile("more steps than time has digits", net(), Must::Refuse("step"), &[(STEP, "1e-15"), (END, "1e6")]));
    all.push(hostile(
        "a step whose square is 0",
        net(),
        Must::Refuse("/time/step"),
        &[(STEP, "1e-121"), (END, "2e-120")],
    ));
    all.push(hostile(
        "an end whose square overflows",
        net(),
        Must::Refuse("/time/end"),
        &[(STEP, "1e199"), (END, "1e200")],
    ));
    all.push(hostile("a step of 0", net(), Must::Refuse("step"), &[(STEP, "0")]));
    all.push(hostile("a step back", net(), Must::Refuse("step"), &[(STEP, "-1e-3")]));
    all
}

fn wind() -> Vec<Hostile> {
    let mut all: Vec<_> = ["1e2", "1e4", "1e8", "1e12", "1e100", "1e200", "1e308"]
        .map(|v| hostile(&format!("wind {v} m/s"), sail(), Must::End, &[(WIND, &format!("[0, 0, {v}]"))]))
        .into();
    all.push(hostile(
        "wind along the cloth",
        sail(),
        Must::Complete,
        &[(WIND, "[1e12, 0, 0]"), (GRAVITY, "[0, 0, 0]")],
    ));
    all.push(hostile("no wind", sail(), Must::Complete, &[(WIND, "[0, 0, 0]")]));
    let cloth = |porosity: &str, pore: &str| {
        let law = format!(
            r#"{{"ergun": {{"porosity": {porosity}, "pore_diameter": {pore}, "thickness": 1e-4,
                "air_density": 1.225, "air_viscosity": 1.81e-5, "form": "corrected"}}}}"#
        );
        hostile(&format!("porosity {porosity}, pores of {pore} m"), sail(), Must::End, &[(LAW, &law)])
    };
    all.extend([cloth("1e-12", "1e-9"), cloth("0.999999999", "1"), cloth("1e-100", "1e-100")]);
    all
}
