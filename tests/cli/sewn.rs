//! Sewn gores in a case: their canopy rests as the generated one of the same pattern.

use crate::bench::Bench;
use crate::common::gores::{dxf, gore, side_by_side};
use canopy_fem::mesh::parachute::ParachuteParameters;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// A canopy of membranes with tapes on lines of 4 m that are held at the confluence, under an even pressure, with much
/// damping.
fn case(mesh: Value) -> Value {
    let gauge = |name: &str, of: &str| json!({"name": name, "on": {"group": name}, "of": of});
    let tape = |name: &str| {
        json!({"on": {"group": name}, "axial_rigidity": 1e4, "linear_density": 0.005, "slack": "tension-only",
               "dashpot": {"axial": {"time": 1e-3}}})
    };
    json!({
        "name": "canopy",
        "system": {"network": {
            "mesh": mesh,
            "mass": {"areal_density": 0.05},
            "membranes": [{"on": {"group": "canopy"}, "thickness": 1e-4, "modulus": 2e8, "poisson": 0.2,
                           "wrinkling": true, "damping_time": 1e-3}],
            "springs": [tape("radials"), tape("lines")],
            "supports": [{"on": {"group": "confluence"}, "fix": "xyz"}],
            "loads": [{"on": {"group": "canopy"}, "pressure": 40.0, "kind": "follower"}],
            "damping": {"rayleigh": {"mass": 20.0}}
        }},
        "time": {"end": 0.3, "method": "backward-euler", "step": 0.01},
        "output": {"gauges": [gauge("lines", "tension"), gauge("skirt", "position"), gauge("vent", "position")]}
    })
}

#[test]
fn sewn_gores_rest_as_their_pattern_does() {
    let pattern = json!({
        "type": "hemispherical", "nominal_diameter": 4.0, "gores": 12, "vent_diameter": 0.4, "radial_segments": 12,
        "gore_segments": 1, "vent_lines": false, "lines": {"length": 4.0}
    });
    let drawn: ParachuteParameters = serde_json::from_value(pattern.clone()).expect("parameters");
    let layers: Vec<String> = (1..=12).map(|i| format!("gore-{i}")).collect();
    let drawing = dxf(&side_by_side(&gore(&drawn.build().expect("a canopy")), 12));
    let seams = json!([{"gores": layers, "lines": {"length": 4.0}}]);
    let mut fine = pattern;
    fine["gore_segments"] = json!(4);
    let meshes = [json!({"parachute": fine}), json!({"file": "gores.dxf", "scale": 0.001, "edge": 0.18, "sew": seams})];
    let [generated, sewn] = meshes.map(|mesh| {
        let bench = Bench::new();
        std::fs::write(bench.path("gores.dxf"), &drawing).expect("written");
        std::fs::write(bench.path("case.json"), case(mesh).to_string()).expect("written");
        let ended = bench.run(&["solve", "case.json", "--out", "out"]);
        assert_eq!(ended.code, Some(0), "{}", ended.stderr);
        bench.results().text("gauges.csv")
    });
    // The last value of each column.
    let values = |text: &str| -> BTreeMap<String, f64> {
        let rows = text.lines().skip(1).map(|row| row.split(',').collect::<Vec<&str>>());
        rows.map(|cells| (cells[1..3].join(" "), cells[3].parse().expect("a number"))).collect()
    };
    let (generated, sewn) = (values(&generated), values(&sewn));
    assert_eq!(generated.keys().collect::<Vec<_>>(), sewn.keys().collect::<Vec<_>>());
    for (name, expected) in generated {
        // Heights of a canopy of 1.4 m, and pulls, on unlike triangles.
        let most = if name.contains("position") { 0.015 } else { 0.03 * expected };
        assert!((sewn[&name] - expected).abs() < most, "{name}: {} for {expected}", sewn[&name]);
    }
}

/// The mesh of the program's own commands, and a fault of a rule at its place in the case.
#[test]
fn seams_are_given_to_commands_and_refused_in_their_place() {
    let bench = Bench::new();
    let drawn: ParachuteParameters = serde_json::from_value(json!({
        "type": "flat-circular", "nominal_diameter": 4.0, "gores": 12, "radial_segments": 4
    }))
    .expect("parameters");
    let drawing = dxf(&side_by_side(&gore(&drawn.build().expect("a canopy")), 1));
    std::fs::write(bench.path("gores.dxf"), drawing).expect("written");
    let flags = ["mesh", "inspect", "gores.dxf", "--scale", "0.001", "--edge", "0.3", "--sew"];
    let ended = bench.run(&[&flags[..], &[r#"[{"gores": ["gore-1"], "copies": 12}]"#]].concat());
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    for told in ["12 pieces were sewn along 12 seams", "radials: "] {
        assert!(ended.stdout.contains(told) || ended.stderr.contains(told), "{} {}", ended.stdout, ended.stderr);
    }
    let ended = bench.run(&[&flags[..], &["[{\"gores\": 3}]"]].concat());
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    let sew = json!([{"gores": ["gore"]}]);
    let faulty = case(json!({"file": "gores.dxf", "scale": 0.001, "edge": 0.3, "sew": sew}));
    std::fs::write(bench.path("case.json"), faulty.to_string()).expect("written");
    let ended = bench.run(&["solve", "case.json", "--out", "out"]);
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(ended.stderr.contains("/system/network/mesh/sew"), "{}", ended.stderr);
    assert!(ended.stderr.contains("there are gore-1"), "{}", ended.stderr);
}
