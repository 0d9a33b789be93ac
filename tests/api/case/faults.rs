//! The second pass: all faults of a file at once, each at its place, and none that only follows from another.

use canopy_fem::case::schema::CaseFile;
use canopy_fem::case::{Fault, Location};
use serde_json::{Value, json};

use super::common::{BASE, base_with, faults, text_with};

/// A case with every section; nothing is wrong with it.
const ALL: &str = r#"{
  "name": "all",
  "description": "every section",
  "system": {"network": {
    "mesh": {"explicit": {
      "nodes": [[0,0,0],[1,0,0],[1,1,0],[0,1,0],[2,1,0]],
      "springs": [[0,1],[1,2],[2,0],[2,3],[3,0],[2,4]],
      "triangles": [[0,1,2],[0,2,3]]
    }},
    "mass": {"areal_density": 3.0, "nodal": [0.5, 0.5, 0.5, 0.5, 0.5]},
    "springs": [
      {"on": "lines", "stiffness": 5.0, "rest_length": 0.9, "slack": {"dead_zone": 0.1},
       "rest_scale": {"table": [[0, 1], [1, 0.9]]}},
      {"on": {"ids": [2]}, "axial_rigidity": 100.0, "rest_scale": 1.1, "dashpot": {"axial": {"time": 0.001}}},
      {"on": "all", "membrane": {"modulus": 1e6, "thickness": 1e-4}, "linear_density": 0.1, "slack": "tension-only",
       "dashpot": {"relative": "step"}}
    ],
    "supports": [{"on": {"ids": [0]}, "fix": "xyz", "motion": {"table": [[0, 0, 0, 0], [1, 2, 0, 0]]}},
                 {"on": {"sphere": {"center": [1, 0, 0], "radius": 0.1}}, "fix": "z"}],
    "gravity": [0, 0, -9.81],
    "aero": {"wind": {"table": [[0, 0, 0, 5], [1, 0, 0, 6]]},
             "law": {"permeable": {"a": 400.0, "b": 100.0, "thickness": 1e-3}}},
    "loads": [{"on": "all", "pressure": 2.0, "kind": "dead", "direction": [0, 0, 1]},
              {"on": {"box": [[0, 0, 0], [1, 1, 1]]}, "force": [0, 0, -1], "table": [[0, 0], [1, 1]]}],
    "damping": {"rayleigh": {"mass": 0.1, "stiffness": 0.001}},
    "initial": {"displacement": [0, 0, 0.01],
                "velocity": [[2, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0], [1, 0, 0]]}
  }},
  "time": {"end": 1.0, "method": {"hht": {"alpha": -0.1}}, "step": 0.01},
  "solver": {"newton": {"relative": 1e-8, "max_iterations": 20, "strategy": "full"}, "linear": "auto"},
  "output": {"frames": {"every": 0.1}, "fields": ["force", "strain"], "history": {"every": 2},
             "probes": [{"name": "a", "on": {"ids": [1]}}, {"name": "b", "on": "all"}]},
  "study": {"methods": ["rk4", {"newmark": {"beta": 0.25}}], "steps": [0.1, 0.01], "tolerances": [1e-3], "repeat": 3}
}"#;

/// The faults of a case that is a value.
fn faults_of(json: &Value) -> Vec<Fault> {
    match text_with(&json.to_string(), &[]) {
        Ok(_) => Vec::new(),
        Err(error) => error.faults().to_vec(),
    }
}

/// The pointers of all values of a case.
fn pointers(json: &Value, at: &str, all: &mut Vec<String>) {
    all.push(at.to_owned());
    match json {
        Value::Object(map) => map.iter().for_each(|(key, value)| pointers(value, &format!("{at}/{key}"), all)),
        Value::Array(list) => list.iter().enumerate().for_each(|(i, v)| pointers(v, &format!("{at}/{i}"), all)),
        _ => {}
    }
}

/// Every value of a case made wrong in every way that types allow: whatever serde refuses is told, at the value or
/// below it, nothing is told that only follows from it, and a fault of another section is told as well.
#[test]
fn every_wrong_type_and_key_is_told_and_hides_nothing() {
    let good: Value = serde_json::from_str(ALL).expect("JSON");
    assert!(faults_of(&good).is_empty(), "{:#?}", faults_of(&good));
    let mut all = Vec::new();
    pointers(&good, "", &mut all);
    let wrong = [
        json!(null),
        json!(true),
        json!(3),
        json!(-1.5),
        json!("zzz"),
        json!([]),
        json!({}),
        json!([1]),
        json!([[1]]),
        json!({"zzz": 1}),
        json!({"zzz": 1, "zzzz": 1}),
        json!([{}, "zzz", null]),
    ];
    let mut refused = 0;
    for pointer in all.iter().filter(|p| !p.is_empty()) {
        // A section that every case has, and that is not the one that is made wrong.
        let (other, key) = if pointer.starts_with("/time") { ("/name", "name") } else { ("/time/end", "end") };
        for value in &wrong {
            let mut bad = good.clone();
            *bad.pointer_mut(pointer).expect("there") = value.clone();
            if serde_json::from_value::<CaseFile>(bad.clone()).is_ok() {
                continue;
            }
            refused += 1;
            let list = faults_of(&bad);
            assert!(!list.is_empty(), "{pointer} = {value} is refused by serde, and nothing is told");
            for fault in &list {
                let below = fault.pointer == *pointer || fault.pointer.starts_with(&format!("{pointer}/"));
                assert!(below, "{pointer} = {value}: {fault}");
                assert!(!fault.allowed.contains("expected"), "serde's own words: {fault}");
            }
            let place = bad.pointer_mut(other).expect("there");
            *place = if key == "name" { json!("") } else { json!(-1) };
            let both = faults_of(&bad);
            assert!(both.iter().any(|f| f.pointer == other), "{pointer} = {value} hides {other}: {both:#?}");
        }
    }
    assert!(refused > 900, "only {refused} cases were refused");
}

/// Every key misspelt: the nearest known one is named, the value is read as if it were spelt right, and no other fault
/// comes of it.
#[test]
fn every_misspelt_key_is_told_once() {
    let good: Value = serde_json::from_str(ALL).expect("JSON");
    let mut all = Vec::new();
    pointers(&good, "", &mut all);
    let mut seen = 0;
    for pointer in &all {
        let (parent, key) = pointer.rsplit_once('/').unwrap_or_default();
        let long = key.len() > 3 && key.parse::<usize>().is_err();
        let mut bad = good.clone();
        let Some(Value::Object(map)) = bad.pointer_mut(parent).filter(|_| long) else { continue };
        let value = map.remove(key).expect("there");
        let misspelt = format!("{}q{}", &key[..2], &key[3..]);
        map.insert(misspelt.clone(), value);
        let list = faults_of(&bad);
        assert_eq!(list.len(), 1, "{pointer}: {list:#?}");
        assert_eq!(list[0].pointer, format!("{parent}/{misspelt}"));
        assert_eq!(list[0].hint, Some(format!("did you mean \"{key}\"?")), "{pointer}");
        seen += 1;
    }
    assert!(seen > 50, "only {seen} keys");
}

/// Whatever key is missing is told at its parent; what can be left out is no fault.
#[test]
fn every_missing_key_is_told() {
    let good: Value = serde_json::from_str(ALL).expect("JSON");
    let mut all = Vec::new();
    pointers(&good, "", &mut all);
    let mut missed = 0;
    for pointer in &all {
        let (parent, key) = pointer.rsplit_once('/').unwrap_or_default();
        let mut bad = good.clone();
        let Some(Value::Object(map)) = bad.pointer_mut(parent) else { continue };
        map.remove(key);
        if serde_json::from_value::<CaseFile>(bad.clone()).is_err() {
            let list = faults_of(&bad);
            assert_eq!(list.len(), 1, "{pointer}: {list:#?}");
            // An object with one key that lost it is told as a whole.
            assert!([pointer.as_str(), parent].contains(&list[0].pointer.as_str()), "{pointer}: {}", list[0]);
            missed += 1;
        }
    }
    assert!(missed > 20, "only {missed} keys are required");
}

/// Every number made negative: at most one fault comes of it, mostly at the number.
#[test]
fn a_number_out_of_range_is_told_once() {
    let good: Value = serde_json::from_str(ALL).expect("JSON");
    let mut all = Vec::new();
    pointers(&good, "", &mut all);
    let mut there = 0;
    // A support that jumps at its start has two faults.
    for pointer in all.iter().filter(|p| good.pointer(p).is_some_and(Value::is_number) && !p.contains("/motion/")) {
        let mut bad = good.clone();
        *bad.pointer_mut(pointer).expect("there") = json!(-1);
        let list = faults_of(&bad);
        assert!(list.len() <= 1, "{pointer}: {list:#?}");
        there += list.iter().filter(|fault| fault.pointer == *pointer).count();
    }
    assert!(there > 50, "only {there} are told at the number");
}

/// One unknown key and three bad numbers are four faults, in the order of the text, drawn at their places.
#[test]
fn a_message_shows_all_faults_at_their_places() {
    let text = r#"{
  "name": "base", // a comment
  "system": {"pendulum": {"length": -1, "mass": 1, "gravity": 9.81 "angel": 0.1, }},
	"time": {"end": 0, "method": "newmrk", "step": "fast"}
}"#;
    let shown = text_with(text, &[("output.frames.every", "0")]).expect_err("refused").to_string();
    let expected = r#"base.json: 7 faults in the case

/system/pendulum/length: -1
  --> base.json:3:37
  |
3 |   "system": {"pendulum": {"length": -1, "mass": 1, "gravity": 9.81 "angel": 0.1, }},
  |                                     ^^
  allowed: a number above 0

/system/pendulum: a missing comma
  --> base.json:3:67
  |
3 |   "system": {"pendulum": {"length": -1, "mass": 1, "gravity": 9.81 "angel": 0.1, }},
  |                                                                   ^
  allowed: a comma between two entries

/system/pendulum/angel: 0.1
  --> base.json:3:68
  |
3 |   "system": {"pendulum": {"length": -1, "mass": 1, "gravity": 9.81 "angel": 0.1, }},
  |                                                                    ^^^^^^^
  wrong: there is no key "angel" here
  allowed: known keys here: angle, damping, gravity, length, mass, rate
  hint: did you mean "angle"?

/time/end: 0
  --> base.json:4:18
  |
4 |     "time": {"end": 0, "method": "newmrk", "step": "fast"}
  |                     ^
  allowed: a number above 0

/time/method: "newmrk"
  --> base.json:4:31
  |
4 |     "time": {"end": 0, "method": "newmrk", "step": "fast"}
  |                                  ^^^^^^^^
  allowed: known names here: explicit-euler, euler-cromer, euler-richardson, improved-euler, improved-euler-pec, velocity-verlet, beeman, rk4, dormand-prince, dop853, newmark, hht, kang, backward-euler, generalized-alpha, esdirk4, central-difference, multirate, energy-momentum, xpbd, vbd
  hint: did you mean "newmark"?

/time/step: "fast"
  --> base.json:4:49
  |
4 |     "time": {"end": 0, "method": "newmrk", "step": "fast"}
  |                                                    ^^^^^^
  wrong: expected a number, found a text
  allowed: a number

/output/frames/every: 0
  --> --set output.frames.every=0
  allowed: a number above 0"#;
    assert_eq!(shown, expected);
}

/// A missing key points to the brace of its parent; a value of the command line to its assignment, a study's too.
#[test]
fn places_of_what_is_not_in_the_text() {
    let text = BASE.replace("\"end\": 1.0, ", "");
    let place = |list: &[Fault]| list[0].place.as_ref().map(ToString::to_string);
    let missing = faults(text_with(&text, &[]));
    assert_eq!((missing[0].pointer.as_str(), place(&missing).as_deref()), ("/time/end", Some("13:11")));
    let set = faults(base_with(&[("time.end", "null")]));
    assert_eq!((set[0].pointer.as_str(), place(&set).as_deref()), ("/time/end", Some("--set time.end=null")));
    // The fault is in what the assignment made on its way.
    let made = faults(base_with(&[("time.step", "0.02"), ("output.foo.bar", "1")]));
    assert_eq!((made[0].pointer.as_str(), place(&made).as_deref()), ("/output/foo", Some("--set output.foo.bar=1")));
    let case = base_with(&[("time.step", "0.02")]).expect("good");
    let sets = |list: &[(&str, &str)]| list.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect::<Vec<_>>();
    let case = case.with(&sets(&[("time.end", "3")])).expect("good");
    let later = faults(case.with(&sets(&[("study.repeat", "0"), ("time.step", "-1")])));
    let places: Vec<String> = later.iter().filter_map(|f| Some(f.place.as_ref()?.to_string())).collect();
    assert_eq!(places, ["--set study.repeat=0", "--set time.step=-1"], "in the order of the command line");
}

/// A text where a text or an object may stand has the right type, whatever is wrong elsewhere.
#[test]
fn a_text_beside_objects_is_no_fault() {
    let wrong = faults(base_with(&[("system.network.initial.from", "nowhere"), ("time.end", "-1")]));
    let told: Vec<&str> = wrong.iter().map(|f| f.allowed.as_str()).collect();
    assert_eq!(told, ["a folder with the results of a run, its frames among them", "a number above 0"], "{wrong:#?}");
}

/// Syntax that can be read over hides nothing behind it; syntax that cannot is told with the first slip before it.
#[test]
fn slips_hide_nothing() {
    let text = BASE.replace("\"fix\": \"xyz\"}]", "\"fix\": 'xyw',}]").replace("\"end\": 1.0", "\"end\": -1.0");
    let list = faults(text_with(&text, &[]));
    let told: Vec<&str> = list.iter().map(|f| f.pointer.as_str()).collect();
    let at = "/system/network/supports";
    assert_eq!(told, [format!("{at}/0/fix"), format!("{at}/0/fix"), "/time/end".to_owned()]);
    let text = text.replace("\"step\": 0.01", "\"step\" 0.01");
    let list = faults(text_with(&text, &[]));
    let lines: Vec<usize> = list
        .iter()
        .filter_map(|f| match f.place {
            Some(Location::Text { line, .. }) => Some(line),
            _ => None,
        })
        .collect();
    assert_eq!((list.len(), lines), (2, vec![11, 13]), "{list:#?}");
}

/// A list of which every entry is wrong makes a message of bounded length with the true number of faults.
#[test]
fn many_faults_are_counted() {
    let bad = ["\"x\""; 1000].join(",");
    let text = BASE.replace("\"nodal\": 0.5", &format!("\"nodal\": [{bad}]"));
    let error = text_with(&text, &[]).expect_err("refused");
    assert_eq!(error.faults().len(), 50);
    let shown = error.to_string();
    assert!(
        shown.starts_with("base.json: 1000 faults") && shown.ends_with("and 950 more; correct these and check again")
    );
    assert!(shown.len() < 30_000, "{} bytes", shown.len());
}

/// What follows from a part that cannot be read is not told; what does not is.
#[test]
fn nothing_follows_from_a_stand_in() {
    for (text, told) in [
        // The end is not known, so neither is how small the step is beside it.
        (BASE.replace("\"end\": 1.0", "\"end\": true").replace("0.01", "1e-30"), vec!["/time/end"]),
        // The mesh is not known, so neither are its ids.
        (BASE.replace("\"nodes\": [[0,0,0],", "\"nodes\": [7,").replace("[0]}, \"fix\"", "[99]}, \"fix\""),
         vec!["/system/network/mesh/explicit/nodes/0"]),
        // Which edges the first rule takes is not known, so neither what the second lacks.
        (BASE.replace("\"springs\": [{\"on\": \"all\", \"stiffness\": 100.0}]",
            "\"springs\": [{\"on\": \"line\", \"stiffness\": 1}, {\"on\": \"all\", \"membrane\": {\"modulus\": 1, \"thickness\": -1}}]"),
         vec!["/system/network/springs/0/on", "/system/network/springs/1/membrane/thickness"]),
        // An unknown key may have been meant as the stiffness.
        (BASE.replace("\"stiffness\": 100.0", "\"k\": 100.0, \"rest_scale\": 0"),
         vec!["/system/network/springs/0/k", "/system/network/springs/0/rest_scale"]),
        // Nor is a mass missing where the section cannot be read.
        (BASE.replace("\"nodal\": 0.5", "\"each\": 0.5"), vec!["/system/network/mass/each"]),
    ] {
        assert_ne!(text, BASE);
        let list = faults(text_with(&text, &[]));
        assert_eq!(list.iter().map(|f| f.pointer.as_str()).collect::<Vec<_>>(), told, "{text}");
    }
}
