//! What a good case becomes.

use canopy_fem::case::Case;
use canopy_fem::case::spec::{GaugeOf, Problem, RowEvery, SystemSpec};
use canopy_fem::model::spec::{DashpotKind, NetworkSpec, PressureKind, Slack, SpringValues};

use super::common::{assets, base_with};

fn network(problem: &Problem) -> &NetworkSpec {
    match &problem.system {
        SystemSpec::Network(network) => network,
        SystemSpec::Pendulum(_) => panic!("a network is expected"),
    }
}

fn close(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-12 * b.abs(), "{a} instead of {b}");
}

/// Every case that comes with the program parses and builds; the thesis' cloths are heavier than
/// cloth, the wind of its first canopy is faster than light, and its spring pendulum's springs are stretched far.
#[test]
fn assets_build() {
    let names: Vec<String> = assets()
        .iter()
        .map(|path| {
            let case = Case::from_file(path, &[]).unwrap_or_else(|error| panic!("{error}"));
            let stem = path.file_stem().and_then(|s| s.to_str()).expect("a name");
            assert_eq!(stem, case.problem().name);
            assert!(case.warnings().is_empty(), "{stem}: {:?}", case.warnings());
            case.into_problem().name
        })
        .collect();
    let expected = [
        "cloth-k100",
        "cloth-k1000",
        "cloth-k10000",
        "cloth-k100000",
        "oscillator",
        "oscillator-damped",
        "parachute-50ms",
        "parachute-original",
        "pendulum",
        "saddle-net",
        "spring-pendulum",
    ];
    assert_eq!(names, expected);
}

/// The thesis' canopy has its counts, its dashpots, and 2 kg/m^2 on the area between its two polygons.
#[test]
fn cloth_is_the_thesis_canopy() {
    let path = assets().into_iter().find(|p| p.ends_with("cloth-k1000.json")).expect("asset");
    let problem = Case::from_file(&path, &[]).expect("good").into_problem();
    let spec = network(&problem);
    assert_eq!((spec.mesh.nodes.len(), spec.mesh.edges.len(), spec.mesh.triangles.len()), (703, 1983, 1280));
    let mass: f64 = spec.mass.iter().sum();
    let polygon = |radius: f64| {
        let n = spec.mesh.nodes.iter().filter(|p| (p[0].hypot(p[1]) - radius).abs() < 1e-9).count() as f64;
        0.5 * n * radius * radius * (std::f64::consts::TAU / n).sin()
    };
    let expected = 2.0 * (polygon(1.0) - polygon(0.1));
    assert!((mass - expected).abs() < 1e-9 * expected, "{mass} kg instead of {expected} kg");
    let dashpot = spec.springs[0].dashpot.as_ref().expect("dashpot");
    assert_eq!((dashpot.kind, dashpot.from_step), (DashpotKind::Relative, false));
    assert!(dashpot.coefficient.given().iter().all(|c| (*c - 0.5).abs() < 1e-12), "c = k tau = 1000 * 5e-4");
    assert!(spec.fixed.iter().filter(|f| **f == [true; 3]).count() > 60, "the outer edge is held");
    assert_eq!(problem.output.frames_every, Some(0.02));
    assert_eq!(problem.method.info.name, "velocity-verlet");
}

/// A third of each triangle's mass to each vertex, the nodal mass, and half of an edge's mass to each end add up.
#[test]
fn masses_add_up() {
    let case = base_with(&[("system.network.springs.0.linear_density", "0.2")]).expect("good");
    let mass = &network(case.problem()).mass;
    // Each triangle: 0.5 m^2 * 3 kg/m^2 / 3 = 0.5 kg a corner; edges of 1 m give 0.1 kg an end, the diagonal 0.1 sqrt
    // 2.
    let diagonal = 0.1 * 2.0_f64.sqrt();
    let expected =
        [0.5 + 1.0 + 0.2 + diagonal, 0.5 + 0.5 + 0.2, 0.5 + 1.0 + 0.3 + diagonal, 0.5 + 0.5 + 0.2, 0.5 + 0.1];
    for (m, e) in mass.iter().zip(expected) {
        close(*m, e);
    }
}

/// The first matching rule wins, and each stiffness rule and dashpot rule gives its formula.
#[test]
fn spring_rules() {
    let rules = r#"[
        {"on": "lines", "axial_rigidity": 50, "rest_length": 0.5, "slack": "tension-only",
         "dashpot": {"axial": {"per_strain": 3}}},
        {"on": "interior", "membrane": {"modulus": 1000, "thickness": 0.1}, "slack": {"dead_zone": 0.01},
         "dashpot": {"relative": {"coefficient": 7}}},
        {"on": "all", "stiffness": 10, "rest_scale": 0.9, "slack": {"compression_limit": 0.02},
         "dashpot": {"relative": "step"}}
    ]"#;
    let case = base_with(&[("system.network.springs", rules)]).expect("good");
    let groups = &network(case.problem()).springs;
    assert_eq!(groups.iter().map(|g| g.edges.clone()).collect::<Vec<_>>(), [vec![5], vec![2], vec![0, 1, 3, 4]]);
    close(groups[0].stiffness.given()[0], 50.0 / 0.5);
    close(groups[0].dashpot.as_ref().expect("dashpot").coefficient.given()[0], 3.0 / 0.5);
    // E t (sum of areas)/l^2 = 100 * 1 m^2 / 2 m^2
    close(groups[1].stiffness.given()[0], 50.0);
    close(groups[1].rest_length[0], 2.0_f64.sqrt());
    close(groups[2].rest_length[3], 0.9);
    let step = groups[2].dashpot.as_ref().expect("dashpot");
    assert!(step.from_step);
    // What is one number in the case stays one.
    assert_eq!(groups[2].stiffness, SpringValues::Uniform(10.0));
    assert_eq!(step.coefficient, SpringValues::Uniform(10.0 * 0.01));
    assert_eq!(
        groups.iter().map(|g| g.slack).collect::<Vec<_>>(),
        [Slack::TensionOnly, Slack::DeadZone { eps: 0.01 }, Slack::CompressionLimit { eps: 0.02 }]
    );
    assert!(case.warnings().iter().any(|w| w.text.contains("\"step\" dashpot")), "{:?}", case.warnings());
}

/// Selections by place and topology, and supports that add up.
#[test]
fn selections_and_supports() {
    let supports = r#"[{"on": "outer", "fix": "z"}, {"on": {"box": [[1, 1, 0], [2, 1, 0]]}, "fix": "y"},
                       {"on": {"sphere": {"center": [0, 0, 0], "radius": 1}}, "fix": "x"}]"#;
    let case = base_with(&[("system.network.supports", supports)]).expect("good");
    let expected =
        [[true, false, true], [true, false, true], [false, true, true], [true, false, true], [false, true, false]];
    assert_eq!(network(case.problem()).fixed, expected);
}

/// A uniform vector leaves supports alone; a list moves them.
#[test]
fn initial_state() {
    let uniform = base_with(&[
        ("system.network.initial.displacement", "[0, 0, 1]"),
        ("system.network.initial.velocity", "[1, 2, 3]"),
    ])
    .expect("good");
    let spec = network(uniform.problem());
    assert_eq!((spec.displacement[0], spec.displacement[1]), ([0.0; 3], [0.0, 0.0, 1.0]));
    assert_eq!((spec.velocity[0], spec.velocity[4]), ([0.0; 3], [1.0, 2.0, 3.0]));
    let list = base_with(&[("system.network.initial.displacement", "[[0,0,5],[0,0,0],[0,0,0],[0,0,0],[0,0,0]]")]);
    assert_eq!(network(list.expect("good").problem()).displacement[0], [0.0, 0.0, 5.0]);
}

/// Loads keep their triangles, direction (as a unit vector) and factor; the air its wind over time.
#[test]
fn loads_and_air() {
    let case = base_with(&[
        (
            "system.network.loads",
            r#"[{"on": "all", "pressure": 200, "kind": "dead", "direction": [0, 0, 2]},
                {"on": {"ids": [1]}, "pressure": -5},
                {"on": {"ids": [4, 1]}, "force": [0, 0, -1], "table": [[0, 0], [1, 1]]}]"#,
        ),
        (
            "system.network.aero",
            r#"{"wind": {"table": [[0, 0, 0, 1], [2, 0, 0, 3]]},
                "law": {"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}}}"#,
        ),
    ])
    .expect("good");
    let spec = network(case.problem());
    assert_eq!(spec.pressures[0].kind, PressureKind::Dead(Some([0.0, 0.0, 1.0])));
    assert_eq!((spec.pressures[1].kind, &spec.pressures[1].triangles), (PressureKind::Follower, &vec![1]));
    assert_eq!(spec.forces[0].nodes, [1, 4]);
    assert_eq!(spec.forces[0].factor.as_ref().map(|f| f.t.clone()), Some(vec![0.0, 1.0]));
    let air = spec.air.as_ref().expect("air");
    close(air.linear, 160.0);
    close(air.quadratic, 48.0);
    assert_eq!(air.wind.value, [[0.0, 0.0, 1.0], [0.0, 0.0, 3.0]]);
}

/// Defaults: Newton 1e-8 and 20 iterations, no frames but the ends, and a history within 10,000 rows.
#[test]
fn defaults() {
    let case = base_with(&[("time.end", "1000"), ("time.step", "0.001")]).expect("good");
    let problem = case.problem();
    assert_eq!((problem.solver.newton.relative, problem.solver.newton.max_iterations), (1e-8, 100));
    assert_eq!(problem.output.frames_every, None);
    assert_eq!(problem.time.steps(), Some(1_000_000));
    let RowEvery::Steps(every) = problem.output.history_every else { panic!("steps") };
    let rows = 1_000_000 / every + 2;
    assert!(rows <= 10_000 && rows > 9_000, "{rows}");
    assert_eq!(base_with(&[]).expect("good").problem().output.history_every, RowEvery::Steps(1));
}

/// Doubtful input runs, and says so.
#[test]
fn warnings() {
    for (key, value, words) in [
        ("system.network.springs.0.on", "boundary", "edges 2, 5: they carry no spring"),
        ("system.network.springs.0.on", "boundary", "free nodes 4"),
        (
            "system.network.springs",
            r#"[{"on": "all", "stiffness": 1}, {"on": "lines", "stiffness": 2}]"#,
            "/system/network/springs/1: earlier rules take all",
        ),
        ("time.step", "2", "longer than the run"),
        ("system.network.initial.velocity", "[0, 400, 300]", "node 4 has 500 m/s, 1.47 times the speed of sound"),
        ("system.network.springs.0.rest_scale", "0.5", "starts with a strain of 1 (length"),
        (
            "system.network.springs.0.rest_length",
            "3",
            "edge 5 starts with a strain of -0.667 (length 1 m, rest length 3 m)",
        ),
        (
            "system.network.initial.displacement",
            "[0, 0, 4]",
            "starts with a strain of 3.12 (length 4.123 m, rest length 1 m)",
        ),
        ("system.network.mass.areal_density", "3", "5 kg on 1 m^2 of triangles are 5 kg/m^2"),
        ("system.network.mass", "{\"nodal\": 0.005}", "0.02 kg on 1 m^2 of triangles are 0.02 kg/m^2"),
    ] {
        let case = base_with(&[(key, value)]).expect("good");
        assert!(case.warnings().iter().any(|w| w.text.contains(words)), "{words}: {:?}", case.warnings());
    }
}

/// A study changes values without reading the file again; the case as run carries them.
#[test]
fn a_case_with_other_values() {
    let case = base_with(&[]).expect("good");
    let changed = [("time.step".to_owned(), "0.02".to_owned()), ("time.method".to_owned(), "hht".to_owned())];
    let other = case.with(&changed).expect("good");
    assert_eq!((other.problem().time.step.fixed(), other.problem().method.info.name), (Some(0.02), "hht"));
    assert_eq!(other.problem().case_json["time"]["method"], "hht");
    assert_eq!(other.problem().system, case.problem().system);
    assert!(case.with(&[("time.step".to_owned(), "0".to_owned())]).is_err());
}

/// A selection without another: nodes, edges, triangles, and one within another.
#[test]
fn a_selection_may_leave_a_part_out() {
    let case = base_with(&[
        ("system.network.supports", r#"[{"on": {"of": "outer", "except": {"ids": [1, 3]}}, "fix": "xyz"}]"#),
        ("system.network.springs", r#"[{"on": {"of": "all", "except": "lines"}, "stiffness": 100.0}]"#),
        (
            "system.network.loads",
            r#"[{"on": {"of": "all", "except": {"ids": [1]}}, "pressure": 1.0},
                {"on": {"of": "all", "except": {"of": "boundary", "except": {"ids": [2]}}}, "force": [0, 0, 1]}]"#,
        ),
        ("output.gauges", r#"[{"name": "g", "on": {"of": "boundary", "except": {"ids": [0]}}, "of": "tension"}]"#),
    ])
    .unwrap_or_else(|e| panic!("{e}"));
    let network = network(case.problem());
    let held: Vec<usize> = (0..5).filter(|node| network.fixed[*node] == [true; 3]).collect();
    assert_eq!(held, [0, 2]);
    assert_eq!(network.springs[0].edges, [0, 1, 2, 3, 4]);
    assert_eq!(network.pressures[0].triangles, [0]);
    assert_eq!(network.forces[0].nodes, [2, 4]);
    let of = &case.problem().output.gauges[0].of;
    assert!(matches!(of, GaugeOf::Springs { edges, .. } if *edges == [1, 3, 4]), "{of:?}");
}
