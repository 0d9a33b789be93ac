//! `mesh parachute` and `mesh inspect`: sizes and groups that are told, files that keep them, and refusals.

use crate::bench::Bench;

const C9: [&str; 14] = [
    "mesh",
    "parachute",
    "--type",
    "flat-circular",
    "--nominal-diameter",
    "8.534",
    "--gores",
    "28",
    "--radial-segments",
    "6",
    "--vent-diameter",
    "0.85",
    "--lines",
    "7.68",
];

/// The command tells the sizes of the pattern, writes the mesh, and a case finds its groups in the file.
#[test]
fn a_parachute_is_made_inspected_and_used() {
    let bench = Bench::new();
    let made = bench.run(&[&C9[..], &["--start", "inflated", "--riser", "1", "--output", "c9.vtu"]].concat());
    assert_eq!(made.code, Some(0), "{}", made.stderr);
    let words = [
        "D0 8.534000 m, S0 57.199",
        "28 of 7.680000 m (0.8999 D0)",
        "longest edge of the cloth",
        "vent-lines: 14 edges",
    ];
    for words in words {
        assert!(made.stdout.contains(words), "{words}: {}", made.stdout);
    }
    let inspected = bench.run(&["mesh", "inspect", "c9.vtu"]);
    assert!(inspected.stdout.contains("group        lines: 28 edges, 215.040000 m"), "{}", inspected.stdout);
    let case = serde_json::json!({
        "name": "held",
        "system": {"network": {
            "mesh": {"file": "c9.vtu"},
            "mass": {"areal_density": 0.05},
            "springs": [
                {"on": {"group": "cloth"}, "stiffness": 100, "slack": "tension-only"},
                {"on": {"group": "vent-lines"}, "stiffness": 100, "slack": "tension-only"},
                {"on": {"group": "lines"}, "axial_rigidity": 900, "linear_density": 0.01},
                {"on": {"group": "riser"}, "axial_rigidity": 900, "linear_density": 0.01}
            ],
            "supports": [{"on": {"group": "payload"}, "fix": "xyz"}]
        }},
        "time": {"end": 0.01, "method": "velocity-verlet", "step": 1e-4}
    });
    std::fs::write(bench.path("held.json"), case.to_string()).expect("a case");
    let checked = bench.run(&["check", "held.json", "--all"]);
    assert_eq!(checked.code, Some(0), "{}", checked.stderr);
    assert!(checked.stdout.contains("group           canopy: 336 triangles"), "{}", checked.stdout);
    let report = bench.run(&["check", "held.json", "--json"]);
    let report: serde_json::Value = serde_json::from_str(&report.stdout).expect("JSON");
    let skirt = &report["groups"]["skirt"];
    assert_eq!([&skirt["nodes"], &skirt["edges"], &skirt["triangles"]], [28, 28, 0]);
    // Sizes of a canopy from a file: those that the pattern was made with.
    let near = |value: &serde_json::Value, expected: f64| {
        let value = value.as_f64().expect("a number");
        assert!((value / expected - 1.0).abs() < 1e-12, "{value} instead of {expected}");
    };
    near(&report["canopies"]["canopy"]["nominal_diameter"], 8.534);
    near(&report["groups"]["lines"]["rest_length"], 28.0 * 7.68);
    near(&report["groups"]["riser"]["rest_length"], 1.0);
    let cloth = report["groups"]["canopy"]["area"].as_f64().expect("an area");
    near(&report["mass"], 0.05 * cloth + 0.01 * (28.0 * 7.68 + 1.0));
    assert!(checked.stdout.contains("canopy          S0 57.199"), "{}", checked.stdout);
    assert!(inspected.stdout.contains("canopy       S0 57.199"), "{}", inspected.stdout);
    for words in ["lines: 28 edges, 215.040000 m, springs of 215.04 m, ", "longest edge of the cloth", "mass "] {
        assert!(checked.stdout.contains(words), "{words}: {}", checked.stdout);
    }
}

/// A parachute in a case: `check` tells the sizes of its pattern.
#[test]
fn check_tells_the_sizes_of_a_parachute() {
    let bench = Bench::new();
    let case = serde_json::json!({
        "name": "ring",
        "system": {"network": {
            "mesh": {"parachute": {
                "type": "hemispherical", "nominal_diameter": 2.0, "gores": 8, "radial_segments": 4
            }},
            "mass": {"areal_density": 0.05},
            "springs": [{"on": "all", "stiffness": 100}],
            "supports": [{"on": {"group": "skirt"}, "fix": "xyz"}]
        }},
        "time": {"end": 0.01, "method": "velocity-verlet", "step": 1e-4}
    });
    std::fs::write(bench.path("ring.json"), case.to_string()).expect("a case");
    let checked = bench.run(&["check", "ring.json", "--all"]);
    assert!(checked.stdout.contains("  nominal         D0 2.000000 m, S0 3.141593 m^2"), "{}", checked.stdout);
}

/// Bad parameters end with status 2 and name the parameter.
#[test]
fn bad_parameters_are_named() {
    let bench = Bench::new();
    let rows: [(&[&str], &str); 4] = [
        (&["--vent-lines", "true", "--start", "upwards"], "unknown variant `upwards`"),
        (&["--arm-ratio", "0.3"], "mesh/parachute/arm_ratio"),
        (&["--reefing-diameter", "0"], "mesh/parachute/reefing/diameter"),
        (&["--payload-box", "1", "1", "1"], "--payload-below-riser"),
    ];
    for (more, words) in rows {
        let ended = bench.run(&[&C9[..], more].concat());
        assert_eq!(ended.code, Some(2), "{more:?}: {}", ended.stdout);
        assert!(ended.stderr.contains(words), "{more:?}: {}", ended.stderr);
    }
}
