//! Materials by name, and what a parachute has by its type: every value has a source and a plausible size, what a case
//! gives itself wins, and what is taken is a case that says the same in numbers.

use canopy_fem::case::materials::shipped;
use canopy_fem::case::schema::{Dashpot, DashpotRule, EdgeSelection, Material, Network, SlackRule, SpringRule};
use canopy_fem::case::{Case, CaseError, Fault};
use canopy_fem::mesh::parachute::{CanopyType, ParachuteParameters};
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::PathBuf;

fn read(case: &Value) -> Result<Case, CaseError> {
    Case::from_text(case.to_string(), "case.json", PathBuf::new(), &[])
}

fn faults(case: &Value) -> Vec<Fault> {
    match read(case) {
        Ok(_) => panic!("accepted: {case}"),
        Err(error) => error.faults().to_vec(),
    }
}

/// The only fault of a case, at `pointer`, with these words.
fn refused(case: &Value, pointer: &str, words: &str) {
    let list = faults(case);
    assert_eq!(list.len(), 1, "{list:#?}");
    assert_eq!(list[0].pointer, pointer, "{list:#?}");
    assert!(list[0].to_string().contains(words), "\"{words}\" is not in {}", list[0]);
}

/// A small parachute with materials.
fn parachute() -> Value {
    json!({
        "name": "small",
        "system": {"network": {
            "mesh": {"parachute": {
                "type": "flat-circular", "nominal_diameter": 8.534, "gores": 8, "vent_diameter": 0.457,
                "radial_segments": 3, "cloth": "mil-c-7020-type-i",
                "lines": {"material": "mil-c-5040-type-iii", "length": 7.21},
                "riser": {"material": "mil-w-4088-type-xiii", "length": 1.0},
                "reefing": {"diameter": 1.2}, "start": "inflated"
            }},
            "mass": {"points": [{"on": {"group": "payload"}, "mass": 90.7}]},
            "gravity": [0, 0, -9.81],
            "aero": {"canopy": {"on": {"group": "canopy"}, "schedule": {}}},
            "initial": {"velocity": [0, 0, -45]}
        }},
        "time": {"end": 1, "step": 0.002, "method": "newmark"}
    })
}

fn set(case: &Value, pointer: &str, value: Value) -> Value {
    let mut case = case.clone();
    let (above, key) = pointer.rsplit_once('/').expect("a pointer");
    case.pointer_mut(above).expect("an object")[key] = value;
    case
}

const NET: &str = "/system/network";
const CHUTE: &str = "/system/network/mesh/parachute";

/// The network as it is written out.
fn expanded(case: &Value) -> Network {
    let case = read(case).unwrap_or_else(|error| panic!("{error}"));
    let whole = case.problem().expanded.clone().expect("materials");
    // What is printed is what is run.
    let printed = case.expanded().expect("JSON");
    assert!(printed.get("materials").is_none());
    let again: Network = serde_json::from_value(printed.pointer(NET).expect("a network").clone()).expect("a network");
    assert_eq!(again, *whole);
    let text = printed.to_string();
    let reread = Case::from_text(text, "again.json", PathBuf::new(), &[]).unwrap_or_else(|error| panic!("{error}"));
    assert!(reread.problem().expanded.is_none() && reread.problem().taken.is_empty());
    assert_eq!(reread.problem().system, case.problem().system);
    (*whole).clone()
}

/// The rules for a group.
fn rules<'a>(network: &'a Network, group: &str) -> Vec<&'a SpringRule> {
    let is = |rule: &&SpringRule| rule.on == EdgeSelection::Group(group.to_owned());
    network.springs.iter().filter(is).collect()
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found}, not {expected}");
}

/// Each group of numbers has a source; what is assumed says so, and no value is off by its unit.
#[test]
fn every_value_has_a_source_and_a_plausible_size() {
    let all = shipped();
    assert!(all.len() > 40, "{}", all.len());
    let within = |name: &str, what: &str, value: f64, [low, high]: [f64; 2]| {
        assert!((low..=high).contains(&value), "{name}: {what} {value:e}, not {low:e} to {high:e}");
    };
    for (name, material) in all {
        let (sources, about, groups): (_, _, Vec<&str>) = match material {
            Material::Cloth(cloth) => {
                let stiffness = cloth.modulus * cloth.thickness;
                within(name, "E t", stiffness, [2e4, 5e6]);
                within(name, "mass", cloth.areal_density, [0.02, 2.0]);
                let strength = cloth.strength.expect("a strength");
                within(name, "strength", strength, [3e3, 3e5]);
                within(name, "strain at break of a straight curve", strength / stiffness, [0.02, 0.5]);
                if let Some(law) = cloth.permeability {
                    // At 124.5 Pa, half an inch of water: 0.5 to 200 cfm/ft2.
                    let (a, b) = (law.a * law.thickness, law.b * law.thickness);
                    let speed = if b > 0.0 { (-a + (a * a + 4.0 * b * 124.5).sqrt()) / (2.0 * b) } else { 124.5 / a };
                    within(name, "air", speed, [0.0025, 1.0]);
                }
                let air = cloth.permeability.map(|_| "permeability");
                let groups = ["stiffness", "mass", "strength", "damping"].into_iter().chain(air).collect();
                (&cloth.sources, &cloth.about, groups)
            }
            Material::Line(line) => {
                let rigidity = line.axial_rigidity.expect("EA");
                let (strength, diameter) = (line.strength.expect("a strength"), line.diameter.expect("a diameter"));
                within(name, "strain at break of a straight curve", strength / rigidity, [0.01, 0.4]);
                // 0.1 to 3 N/tex.
                within(name, "specific strength", strength / line.linear_density, [1e5, 3e6]);
                let density = line.linear_density / (0.25 * PI * diameter * diameter);
                within(name, "density on the circle", density, [200.0, 8000.0]);
                let drag = line.drag_coefficient.map(|_| "drag");
                let groups = ["stiffness", "mass", "strength", "diameter", "damping"].into_iter().chain(drag).collect();
                (&line.sources, &line.about, groups)
            }
        };
        assert!(about.as_ref().is_some_and(|about| !about.is_empty()), "{name} says not what it is");
        let told: Vec<&str> = sources.keys().map(String::as_str).collect();
        let mut groups = groups;
        groups.sort_unstable();
        assert_eq!(told, groups, "{name}");
        for (group, source) in sources {
            assert!(source.len() > 7 && source != "assumed:", "{name}: {group} has no source: {source}");
        }
    }
    for name in ["mil-c-7020-type-ii", "mil-c-5040-type-i", "f-111", "dyneema-3mm", "steel-cable-7x19-6mm"] {
        assert!(all.contains_key(name), "{name}");
    }
}

/// A parachute's materials bring springs with slack and dashpots, masses, strengths, the air through its cloth and the
/// drag of its lines; the numbers of its type fill its schedule.
#[test]
fn a_parachute_has_its_rules_by_its_materials() {
    let network = expanded(&parachute());
    let [cloth] = rules(&network, "cloth")[..] else { panic!("{:?}", network.springs) };
    let Some(sheet) = cloth.membrane else { panic!("{cloth:?}") };
    assert_eq!((sheet.modulus, sheet.thickness), (4.309e8, 1e-4));
    for group in ["radials", "skirt", "vent", "vent-lines", "lines"] {
        let [rule] = rules(&network, group)[..] else { panic!("{group}: {:?}", network.springs) };
        let (ea, density, strength) = (rule.axial_rigidity, rule.linear_density, rule.strength);
        assert_eq!((ea, density, strength), (Some(8155.0), Some(0.006614), Some(2447.0)), "{group}");
        assert_eq!(rule.slack, Some(SlackRule::TensionOnly));
        assert_eq!(rule.dashpot, Some(Dashpot::Axial(DashpotRule::Time(0.001))));
    }
    assert!(rules(&network, "riser")[0].axial_rigidity.expect("EA") > 1e5);
    assert!(rules(&network, "reefing").is_empty(), "a reefing line acts only with a rule");
    assert_eq!(network.mass.expect("masses").areal_density, Some(0.0373));
    let aero = serde_json::to_value(network.aero.expect("air")).expect("JSON");
    let schedule = &aero["canopy"]["schedule"];
    assert_eq!((&schedule["drag_coefficient"], &schedule["filling_constant"]), (&json!(0.75), &json!(8.0)));
    assert_eq!(schedule["exponent"], json!(2.0));
    assert_eq!(aero["canopy"]["law"]["permeable"]["a"], json!(1.599e6));
    assert_eq!(aero["drag"], json!([{"on": {"group": "lines"}, "diameter": 0.004, "coefficient": 1.1}]));
    let case = read(&parachute()).expect("a case");
    let taken = case.problem().taken.join("\n");
    for words in ["drag_coefficient 0.75: flat-circular, 0.75 to 0.8 by Knacke 1991", "lines: mil-c-5040-type-iii"] {
        assert!(taken.contains(words), "{taken}");
    }
}

/// A rule for a group replaces that of the material, and no other; so do a law, drag, masses and numbers of a stage.
#[test]
fn what_the_case_gives_wins() {
    let own = json!([{"on": {"group": "lines"}, "axial_rigidity": 5.0e3, "linear_density": 0.01}]);
    let network = expanded(&set(&parachute(), "/system/network/springs", own));
    let [lines] = rules(&network, "lines")[..] else { panic!("{:?}", network.springs) };
    assert_eq!((lines.axial_rigidity, lines.strength, lines.slack), (Some(5.0e3), None, None));
    assert_eq!((rules(&network, "cloth").len(), rules(&network, "radials").len()), (1, 1));
    // A rule with a material keeps what it gives itself.
    let own = json!([{"on": {"group": "lines"}, "material": "dyneema-3mm", "strength": 1.0e4}]);
    let network = expanded(&set(&parachute(), "/system/network/springs", own));
    let [lines] = rules(&network, "lines")[..] else { panic!("{:?}", network.springs) };
    assert_eq!((lines.strength, lines.linear_density), (Some(1.0e4), Some(0.005029)));
    // A membrane in place of the cloth's springs.
    let own = json!([{"on": {"group": "canopy"}, "material": "f-111", "wrinkling": true, "poisson": 0.2}]);
    let network = expanded(&set(
        &set(&parachute(), "/system/network/membranes", own),
        "/system/network/mass/areal_density",
        json!(0.05),
    ));
    assert!(rules(&network, "cloth").is_empty());
    assert_eq!((network.membranes[0].poisson, network.membranes[0].thickness), (Some(0.2), Some(1e-4)));
    assert_eq!(network.mass.expect("masses").areal_density, Some(0.05));
    // All springs at once, lines at once.
    let all = json!([{"on": "all", "stiffness": 1e3, "linear_density": 0.01}]);
    assert_eq!(expanded(&set(&parachute(), "/system/network/springs", all)).springs.len(), 1);
    let lines = json!([{"on": "lines", "stiffness": 1e3, "linear_density": 0.01}]);
    let network = expanded(&set(&parachute(), "/system/network/springs", lines));
    assert!(rules(&network, "riser").is_empty() && rules(&network, "skirt").len() == 1);
    // The air.
    let aero = json!({
        "canopy": {"on": {"group": "canopy"}, "schedule": {"drag_area": 40.0, "filling_time": 1.5},
                   "law": {"permeable": {"a": 1.0, "b": 2.0, "thickness": 3.0}}},
        "drag": [{"on": "lines", "diameter": 0.01, "coefficient": 1.0}]
    });
    let network = expanded(&set(&parachute(), "/system/network/aero", aero.clone()));
    assert_eq!(network.aero, Some(serde_json::from_value(aero).expect("air")));
}

/// A cluster has the rules of its parts once, and those of the copies that the case leaves.
#[test]
fn copies_of_a_part_are_told_apart() {
    let mut case = set(&parachute(), "/system/network/mesh/parachute/cluster", json!({"canopies": 2}));
    case = set(&case, "/system/network/mesh/parachute/riser/length", json!(12.0));
    let canopy = |i: usize| {
        json!({"on": {"group": format!("canopy-{i}")}, "skirt": {"group": format!("skirt-{i}")},
               "confluence": {"group": format!("confluence-{i}")}, "table": {"pressure_coefficient": 1.8}})
    };
    case = set(&case, "/system/network/aero/canopy", json!([canopy(1), canopy(2)]));
    assert_eq!(rules(&expanded(&case), "lines").len(), 1);
    let own = json!([{"on": {"group": "lines-1"}, "material": "mil-c-5040-type-iv"}]);
    let network = expanded(&set(&case, "/system/network/springs", own));
    let of = |group| rules(&network, group).len();
    assert_eq!((of("lines"), of("lines-1"), of("lines-2"), of("riser")), (0, 1, 1, 1));
}

#[test]
fn names_that_are_not_known_are_refused() {
    let near = set(&parachute(), "/system/network/mesh/parachute/cloth", json!("mil-c-7020-typ-i"));
    refused(&near, &format!("{CHUTE}/cloth"), "did you mean \"mil-c-7020-type-i\"?");
    let far = set(&parachute(), "/system/network/mesh/parachute/lines/material", json!("wool"));
    refused(&far, &format!("{CHUTE}/lines/material"), "`canopy-fem materials`");
    let line = set(&parachute(), "/system/network/mesh/parachute/cloth", json!("dyneema-3mm"));
    refused(&line, &format!("{CHUTE}/cloth"), "the name of a cloth");
    let cloth = set(&parachute(), "/system/network/mesh/parachute/riser/material", json!("f-111"));
    refused(&cloth, &format!("{CHUTE}/riser/material"), "the name of a line, tape or cable");
    let rule = json!([{"on": {"group": "lines"}, "material": "steel-cable-7x19-6m"}]);
    let rule = set(&parachute(), "/system/network/springs", rule);
    refused(&rule, "/system/network/springs/0/material", "did you mean \"steel-cable-7x19-6mm\"?");
    let single = json!([{"on": {"ids": [0]}, "stiffness": 1.0}]);
    refused(&set(&parachute(), "/system/network/springs", single), "/system/network/springs/0/on", "name the part");
}

/// Materials of the case itself, and of a file beside it, replace those of the program and add to them.
#[test]
fn a_case_brings_its_own_materials() {
    let cord = json!({"line": {"modulus": 1e9, "diameter": 0.002, "linear_density": 0.003}});
    let cloth = json!({"cloth": {"modulus": 1e8, "thickness": 1e-4, "areal_density": 0.1}});
    let own = json!({"mil-c-5040-type-iii": cord, "my-cloth": cloth});
    let mut case = set(&parachute(), "/materials", own.clone());
    case = set(&case, "/system/network/mesh/parachute/cloth", json!("my-cloth"));
    let network = expanded(&case);
    close(rules(&network, "lines")[0].axial_rigidity.expect("EA"), 1e9 * PI * 1e-6, 1e-14, "EA");
    assert_eq!(rules(&network, "lines")[0].strength, None);
    assert_eq!(network.mass.as_ref().expect("masses").areal_density, Some(0.1));
    let aero = network.aero.clone().expect("air");
    assert!(aero.drag.is_empty(), "a cord without a drag coefficient has no drag: {:?}", aero.drag);
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("mine.json"), format!("// ours\n{own}")).expect("written");
    let by_file = set(&case, "/materials", json!("mine.json"));
    let read = |case: &Value| Case::from_text(case.to_string(), "case.json", folder.path().to_owned(), &[]);
    let found = read(&by_file).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(*found.problem().expanded.clone().expect("materials"), network);
    for (text, words) in [("{", "no JSON"), ("[]", "an object whose keys")] {
        std::fs::write(folder.path().join("mine.json"), text).expect("written");
        let error = read(&by_file).expect_err(text);
        assert!(error.to_string().contains(words), "{error}");
    }
    std::fs::remove_file(folder.path().join("mine.json")).expect("removed");
    let error = read(&by_file).expect_err("no file");
    assert_eq!(error.faults()[0].pointer, "/materials");
    // A line with two stiffnesses, and a number out of its range.
    let two = json!({"line": {"modulus": 1e9, "axial_rigidity": 1e3, "diameter": 0.002, "linear_density": 0.003}});
    refused(&set(&case, "/materials/x", two), "/materials/x/line", "either axial_rigidity, or modulus and diameter");
    let negative = set(&case, "/materials/my-cloth/cloth/modulus", json!(-1.0));
    refused(&negative, "/materials/my-cloth/cloth/modulus", "above 0");
}

/// Nets and roofs name their materials in rules.
#[test]
fn rules_take_materials_anywhere() {
    let case = json!({
        "name": "net",
        "system": {"network": {
            "mesh": {"explicit": {"nodes": [[0,0,0],[1,0,0],[1,1,0],[0,1,0],[2,1,0]],
                "springs": [[0,1],[1,2],[2,0],[2,3],[3,0],[2,4]], "triangles": [[0,1,2],[0,2,3]]}},
            "springs": [{"on": "lines", "material": "steel-cable-7x19-6mm", "rest_scale": 0.99},
                        {"on": "all", "material": "pvc-polyester-type-iii"}],
            "supports": [{"on": {"ids": [0, 4]}, "fix": "xyz"}]
        }},
        "time": {"end": 1.0, "method": "newmark", "step": 0.01}
    });
    let network = expanded(&case);
    let cable = &network.springs[0];
    close(cable.axial_rigidity.expect("EA"), 47.5e9 * PI * 9e-6, 1e-3, "EA");
    assert!(cable.strength.is_some() && cable.linear_density.is_some() && cable.rest_scale.is_some());
    assert!(network.springs[1].membrane.is_some() && network.springs[1].strength.is_none());
    assert_eq!(network.mass.as_ref().expect("masses").areal_density, Some(1.05));
    let other = json!([{"on": {"ids": [0]}, "material": "pvc-polyester-type-i", "wrinkling": true}]);
    let two = set(&case, "/system/network/membranes", other);
    refused(&two, "/system/network/mass/areal_density", "cloths of one mass per area");
    let bare = json!([{"on": "all", "thickness": 1e-3}]);
    let list = faults(&set(&case, "/system/network/membranes", bare));
    let missing: Vec<&str> = list.iter().map(|fault| fault.pointer.as_str()).collect();
    assert_eq!(missing, ["/system/network/membranes/0/modulus", "/system/network/membranes/0/poisson"]);
}

fn pattern(kind: &str, more: Value) -> ParachuteParameters {
    let mut keys = json!({"type": kind, "gores": 24, "radial_segments": 60, "constructed_diameter": 2.4});
    more.as_object().into_iter().flatten().for_each(|(key, value)| keys[key] = value.clone());
    serde_json::from_value(keys).expect("parameters")
}

/// D0 of a constructed diameter by hand: areas of n trapezoids, and by the generator's own sizes for every type.
#[test]
fn shop_sizes_give_the_nominal_diameter() {
    let d0 = |p: &ParachuteParameters| p.resolved().expect("a pattern").nominal_diameter.expect("D0");
    let n: f64 = 24.0;
    let polygon = (n * (PI / n).tan() / PI).sqrt();
    close(d0(&pattern("flat-circular", json!({}))), 2.4 * polygon, 1e-12, "flat");
    let cone = pattern("conical", json!({"cone_angle": 0.4, "vent_diameter": 0.2}));
    close(d0(&cone), 2.4 * polygon / 0.4_f64.cos().sqrt(), 1e-12, "cone");
    // A sphere of n flat gores: S0 = 2 n tan(pi/n) R^2 for many rows, the chords of 60 rows are shorter by 3e-5.
    close(d0(&pattern("hemispherical", json!({}))), 2.4 * polygon * 2.0_f64.sqrt(), 1e-4, "hemisphere");
    let cross = pattern("cruciform", json!({"arm_ratio": 0.25}));
    close(d0(&cross), (4.0 * 2.4 * 2.4 * 0.25 * 1.75 / PI).sqrt(), 1e-12, "cross");
    let kinds = [
        ("biconical", json!({"cone_angles": [0.2, 0.5]})),
        ("extended-skirt", json!({"vent_diameter": 0.2})),
        ("annular", json!({"vent_diameter": 0.8})),
        ("ringslot", json!({"rings": 4, "slot_porosity": 0.15, "vent_diameter": 0.2})),
        ("ribbon", json!({"rings": 8, "slot_porosity": 0.2, "cone_angle": 0.3, "vent_diameter": 0.2})),
        ("ringsail", json!({"rings": 6, "sails": 4, "slot_porosity": 0.07, "fullness": 0.1, "gore_segments": 2})),
        ("disk-gap-band", json!({"vent_diameter": 0.2})),
        ("elliptical", json!({"height_ratio": 0.7})),
        ("toroidal", json!({"vent_diameter": 0.4})),
        ("square", json!({"corner_cut": 0.1})),
        ("triangular", json!({})),
    ];
    for (kind, more) in kinds {
        let p = pattern(kind, more);
        let whole = p.resolved().expect("a pattern").into_owned();
        assert_eq!(whole.constructed_diameter, None);
        close(whole.sizes().expect("sizes").constructed_diameter, 2.4, 1e-12, kind);
        close(p.sizes().expect("sizes").nominal_area, 0.25 * PI * d0(&p).powi(2), 1e-12, kind);
        assert_eq!(p.build().expect("a mesh"), whole.build().expect("a mesh"), "{kind}");
    }
    let both = set(&parachute(), "/system/network/mesh/parachute/constructed_diameter", json!(8.0));
    refused(&both, &format!("{CHUTE}/constructed_diameter"), "exactly one of");
    let neither = set(&parachute(), "/system/network/mesh/parachute/nominal_diameter", Value::Null);
    refused(&neither, &format!("{CHUTE}/nominal_diameter"), "required");
    let vent = set(&neither, "/system/network/mesh/parachute/constructed_diameter", json!(0.5));
    refused(&vent, &format!("{CHUTE}/vent_diameter"), "vent");
}

/// Defaults of a type are the lower ends of the field's ranges and are told; a type without a number refuses.
#[test]
fn types_have_defaults_or_say_that_they_have_none() {
    let of = |kind: &str, more: Value| {
        let mut case = set(&parachute(), "/system/network/mesh/parachute/type", json!(kind));
        case = set(&case, "/system/network/mesh/parachute/start", json!("flat"));
        more.as_object().into_iter().flatten().for_each(|(key, value)| {
            case = set(&case, &format!("{CHUTE}/{key}"), value.clone());
        });
        case
    };
    let slots = json!({"rings": 3, "slot_porosity": 0.15});
    let network = expanded(&of("ringslot", slots.clone()));
    let aero = serde_json::to_value(network.aero.expect("air")).expect("JSON");
    let schedule = &aero["canopy"]["schedule"];
    assert_eq!((&schedule["drag_coefficient"], &schedule["filling_constant"]), (&json!(0.56), &json!(14.0)));
    assert_eq!(schedule["exponent"], json!(1.0), "it belongs to the filling constant");
    // With a filling constant of its own the exponent stays 2.
    let own = set(&of("ringslot", slots), "/system/network/aero/canopy/schedule", json!({"filling_constant": 9}));
    let aero = serde_json::to_value(expanded(&own).aero.expect("air")).expect("JSON");
    assert!(aero["canopy"]["schedule"]["exponent"].is_null(), "{aero}");
    let at = "/system/network/aero/canopy/schedule";
    let hemisphere = of("hemispherical", json!({}));
    refused(&hemisphere, at, "no measured filling constant of type \"hemispherical\"");
    let square = set(&of("square", json!({})), at, json!({"filling_time": 1.0}));
    refused(&square, at, "no measured CD0 of type \"square\"");
    // Only the last stage is the open canopy.
    let stages = json!([{"filling_time": 1.0}, {"start": 2.0, "speed": 20.0}]);
    refused(&set(&parachute(), at, stages), &format!("{at}/0"), "a stage without a drag area");
    // Lines as long as the type has them.
    let band = of("disk-gap-band", json!({"lines": {"material": "mil-c-5040-type-iii"}}));
    let band = set(&set(&band, "/system/network/aero", json!(null)), &format!("{CHUTE}/radial_segments"), json!(4));
    let case = read(&band).unwrap_or_else(|error| panic!("{error}"));
    let printed = case.expanded().expect("JSON");
    close(
        printed["system"]["network"]["mesh"]["parachute"]["lines"]["length"].as_f64().expect("a length"),
        1.7 * 8.534,
        1e-12,
        "lines",
    );
    assert!(case.problem().taken.iter().any(|what| what.contains("1.7 D0")), "{:?}", case.problem().taken);
    let riser = set(&parachute(), "/system/network/mesh/parachute/riser", json!({"segments": 1}));
    refused(&riser, &format!("{CHUTE}/riser/length"), "required");
    for kind in CanopyType::ALL {
        let numbers = kind.numbers();
        assert!(numbers.line_length.is_some() && numbers.drag_coefficient.is_none_or(|[low, high]| low <= high));
    }
}
