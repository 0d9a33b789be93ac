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

/// A start at line stretch has its radius from the command line; one wider than the pattern is refused.
#[test]
fn a_parachute_is_stretched() {
    let bench = Bench::new();
    let made = |radius| {
        bench.run(&[&C9[..], &["--start", "stretched", "--start-radius", radius, "--output", "tube.vtu"]].concat())
    };
    assert_eq!(made("0.05").code, Some(0));
    assert!(std::fs::read_to_string(bench.path("tube.vtu")).expect("a file").contains("start_displacement"));
    let wide = made("0.7");
    assert!(wide.code != Some(0) && wide.stderr.contains("start_radius"), "{}", wide.stderr);
}

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

/// Twelve gores of a flat canopy as solids of an .stl, and lines, riser and payload as an .obj, both in millimetres;
/// every third gore is turned over.
fn gores_and_lines() -> [String; 2] {
    let radius = |ring: u32| 200.0 + 300.0 * f64::from(ring);
    let place = |gore: u32, ring: u32| {
        let angle = f64::from(gore) * std::f64::consts::TAU / 12.0;
        [radius(ring) * angle.cos(), radius(ring) * angle.sin()]
    };
    let mut stl = String::new();
    for gore in 0..12 {
        stl += &format!("solid gore {}\n", gore + 1);
        for ring in 0..6 {
            let [a, b] = [place(gore, ring), place(gore, ring + 1)];
            let [c, d] = [place(gore + 1, ring + 1), place(gore + 1, ring)];
            for mut corners in [[a, b, c], [a, c, d]] {
                if gore % 3 == 1 {
                    corners.reverse();
                }
                let vertices = corners.map(|[x, y]| format!("vertex {x:.6} {y:.6} 0\n")).concat();
                stl += &format!("facet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\n");
            }
        }
        stl += &format!("endsolid gore {}\n", gore + 1);
    }
    let rim: String = (0..12).map(|gore| place(gore, 6)).map(|[x, y]| format!("v {x:.4} {y:.4} 0\n")).collect();
    let lines: String = (3..15).map(|end| format!("l {end} 1\n")).collect();
    let ends = "v 0 0 -4000\nv 0 0 -5000\n";
    let parts = "g riser\nl 1 2\ng payload\np 2\ng confluence\np 1\n";
    [stl, format!("{ends}{rim}g lines\n{lines}{parts}")]
}

/// A canopy from CAD falls: pieces in millimetres are joined and turned alike, lines come from a second file. In steady
/// flight the riser carries the payload, the drag is the weight, and the canopy is two thirds as wide as it is flat, as
/// Taylor's shape is.
#[test]
fn a_canopy_in_pieces_becomes_a_falling_parachute() {
    let bench = Bench::new();
    let [stl, obj] = gores_and_lines();
    std::fs::write(bench.path("gores.stl"), stl).expect("a file");
    std::fs::write(bench.path("lines.obj"), obj).expect("a file");
    let rule = |on: serde_json::Value, stiffness: f64, linear_density: f64| {
        let dashpot = serde_json::json!({"axial": {"time": 0.01}});
        serde_json::json!({
            "on": on, "stiffness": stiffness, "linear_density": linear_density, "slack": "tension-only", "dashpot": dashpot
        })
    };
    let group = |name: &str| serde_json::json!({"group": name});
    let case = serde_json::json!({
        "name": "own",
        "system": {"network": {
            "mesh": {"file": "gores.stl", "with": ["lines.obj"], "scale": 1e-3, "merge": 1e-6, "orient": true},
            "mass": {"areal_density": 0.05, "points": [{"on": {"group": "payload"}, "mass": 20.0}]},
            "springs": [
                rule(group("lines"), 5e3, 0.01), rule(group("riser"), 1e5, 0.01),
                rule("boundary".into(), 2e3, 0.0), rule("interior".into(), 2e3, 0.0)
            ],
            "gravity": [0, 0, -9.81],
            "aero": {"atmosphere": {"density": 1.225}, "canopy": {
                "on": "all", "confluence": {"group": "confluence"}, "apparent_mass": 1.0,
                "table": {"pressure_coefficient": 1.2}
            }},
            "initial": {"velocity": [0, 0, -6]}
        }},
        "time": {"end": 6, "method": "newmark", "step": 0.005},
        "output": {"gauges": [{"name": "riser", "on": {"group": "riser"}, "of": "tension"}]}
    });
    std::fs::write(bench.path("own.json"), case.to_string()).expect("a case");
    // Lines that end 1 mm below the cloth are told, whatever the payload is called.
    let low = std::fs::read_to_string(bench.path("lines.obj")).expect("the file").replace(" 0\n", " -1\n");
    std::fs::write(bench.path("low.obj"), low.replace("payload", "load")).expect("a file");
    let gap = ["system.network.mesh.with=[\"low.obj\"]", "system.network.mass.points.0.on.group=load"];
    let checked = bench.run(&["check", "own.json", "--set", gap[0], "--set", gap[1]]);
    assert!(checked.stdout.contains("[loose-lines]"), "{}", checked.stdout);
    let ended = bench.run(&["solve", "own.json", "--out", "out"]);
    assert!(!ended.stderr.contains("[loose-lines]"), "{}", ended.stderr);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(!ended.stderr.contains("[mesh-file]"), "repairs that were asked for are no warnings: {}", ended.stderr);
    let gauges = bench.results().text("gauges.csv");
    let last = |name: &str| -> f64 {
        let row = gauges.lines().rfind(|row| row.contains(name)).unwrap_or_else(|| panic!("no {name}"));
        row.rsplit(',').next().expect("a value").parse().expect("a number")
    };
    let weight = 9.81 * (20.0 + 0.05 * 11.88 + 0.01 * (1.0 + 12.0 * 20.0_f64.sqrt()));
    assert!((last("riser,tension_max") / (9.81 * 20.0) - 1.0).abs() < 5e-3, "{}", last("riser,tension_max"));
    assert!((last("canopy,drag,") / weight - 1.0).abs() < 5e-3, "{} N, not {weight} N", last("canopy,drag,"));
    let width = last("projected_diameter") / 4.0;
    assert!((width - 0.667).abs() < 0.05, "{width} of its flat diameter");
}
