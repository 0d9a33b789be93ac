//! Canopies that fill ring by ring in the case file: what is refused, and how runs of them behave.

use crate::common::run::{Run, apart, case_of, changed, follow, network, run, run_with};
use canopy_fem::case::Case;
use canopy_fem::drive::Status;
use canopy_fem::force::schedule::threads::Threads;
use canopy_fem::model::spec::{CanopyAir, ClothSpec, NetworkSpec, RingsSpec};
use canopy_fem::model::state::StateRef;
use canopy_fem::model::system::{System, Weights};
use canopy_fem::scene::{BuildError, Scene, build_network};
use serde_json::{Value, json};

const FILLING: &str = "system.network.aero.canopy.filling";

/// A small parachute at line stretch, at 30 m/s.
fn small() -> Value {
    let spring = |group: &str, extra: Value| {
        let mut spring = json!({
            "on": {"group": group}, "axial_rigidity": 4e3, "linear_density": 0.004, "slack": "tension-only",
            "dashpot": {"axial": {"time": 1e-3}}
        });
        if let (Some(spring), Some(extra)) = (spring.as_object_mut(), extra.as_object()) {
            spring.extend(extra.clone());
        }
        spring
    };
    let groups = ["radials", "skirt", "vent", "vent-lines", "lines", "riser"];
    let mut springs: Vec<Value> = groups.iter().map(|group| spring(group, json!({}))).collect();
    springs.push(json!({
        "on": {"group": "cloth"}, "membrane": {"modulus": 1e8, "thickness": 1e-4}, "slack": "tension-only",
        "dashpot": {"axial": {"time": 1e-3}}
    }));
    json!({
        "name": "small",
        "system": {"network": {
            "mesh": {"parachute": {
                "type": "flat-circular", "nominal_diameter": 3.0, "gores": 8, "vent_diameter": 0.2,
                "radial_segments": 5, "lines": {"length": 2.5}, "riser": {"length": 0.5}, "start": "stretched"
            }},
            "mass": {"areal_density": 0.05, "points": [{"on": {"group": "payload"}, "mass": 12.0}]},
            "springs": springs,
            "gravity": [0, 0, -9.81],
            "aero": {
                "canopy": {"on": {"group": "canopy"}, "filling": {
                    "law": {"permeable": {"a": 1.6e6, "b": 4.8e5, "thickness": 1e-4}}
                }},
                "drag": [{"on": {"group": "payload"}, "drag_area": 0.1}]
            },
            "initial": {"velocity": [0, 0, -30.0]}
        }},
        "time": {"end": 0.3, "method": "newmark", "step": 1e-3}
    })
}

/// [-] Cb of the first canopy.
fn outer(case: &Case) -> f64 {
    match &network(case).canopies[0].air {
        CanopyAir::Rings(rings) => rings.outer_pressure_coefficient,
        other => panic!("{other:?} does not fill ring by ring"),
    }
}

/// A hemisphere of tight cloth falls as its least CD0 says, 0.62, where none is told; a flat canopy keeps -0.7, and
/// what is told stays.
#[test]
fn the_outer_pressure_is_by_type() {
    let mut case = small();
    assert_eq!(outer(&case_of(&case, &[])), -0.7);
    let parachute = &mut case["system"]["network"]["mesh"]["parachute"];
    parachute["type"] = json!("hemispherical");
    parachute["start"] = json!("flat");
    parachute["gores"] = json!(12);
    let told = format!("{FILLING}.outer_pressure_coefficient");
    assert_eq!(outer(&case_of(&case, &[(&told, "-0.5")])), -0.5);
    case["system"]["network"]["aero"]["canopy"]["filling"] = json!({});
    case["system"]["network"]["initial"]["velocity"] = json!([0, 0, -7.0]);
    case["time"] = json!({"end": 3.0, "method": "backward-euler", "step": 4e-3});
    let case = case_of(&case, &[]);
    assert_eq!(outer(&case), 1.0 - 0.62 / 0.43);
    assert!(case.problem().taken.iter().any(|told| told.starts_with("aero.canopy.filling.drag_coefficient 0.62")));
    let spec = network(&case);
    let fallen = run(&case);
    assert_eq!(fallen.outcome.status, Status::Completed);
    let payload = spec.mesh.groups["payload"].nodes[0] as usize;
    let speed = -fallen.velocities[payload][2];
    let weight = 9.81 * spec.mass.iter().sum::<f64>();
    let area = 2.0 * weight / (1.225 * speed * speed) - 0.1;
    let coefficient = area / spec.canopies[0].nominal_area;
    assert!((coefficient - 0.62).abs() < 0.02, "CD0 {coefficient}, {speed} m/s");
}

#[test]
fn a_filling_without_a_meaning_is_refused() {
    let key = |key: &str| format!("{FILLING}.{key}");
    let mesh = |key: &str| format!("system.network.mesh.parachute.{key}");
    let canopy = "system.network.aero.canopy";
    let rows = [
        (vec![(key("outer_pressure_coefficient"), "1")], "filling/outer_pressure_coefficient", "below 1"),
        (
            vec![(key("outer_pressure_coefficient"), "-0.7"), (key("drag_coefficient"), "0.75")],
            "canopy/filling",
            "at most one of",
        ),
        (vec![(key("drag_coefficient"), "0")], "filling/drag_coefficient", "above 0"),
        (vec![(key("geometric_porosity"), "1.2")], "filling/geometric_porosity", "to 1"),
        (vec![(key("damping"), "-1")], "filling/damping", "0 or more"),
        (vec![(key("law.permeable.a"), "-1")], "filling/law/permeable/a", "0 or more"),
        (
            vec![(key("law"), "{\"permeable\": {\"a\": 0, \"b\": 0, \"thickness\": 1e-4}}")],
            "filling/law/permeable",
            "a or b above 0",
        ),
        (vec![(key("dampin"), "1")], "filling/dampin", "did you mean \"damping\""),
        (
            vec![(format!("{canopy}.table"), "{\"pressure_coefficient\": 1.7}")],
            "aero/canopy",
            "a canopy with table and filling",
        ),
        (
            vec![
                (mesh("type"), "cruciform"),
                (mesh("vent_diameter"), "null"),
                (mesh("start"), "flat"),
                ("system.network.springs".to_owned(), "[]"),
            ],
            "canopy/filling",
            "rows of cloth are not known",
        ),
    ];
    for (sets, place, words) in rows {
        let sets: Vec<(String, String)> = sets.into_iter().map(|(key, value)| (key, value.to_owned())).collect();
        let refused = Case::from_text(small().to_string(), "test.json", std::path::PathBuf::new(), &sets);
        let text = refused.err().map(|error| error.to_string()).unwrap_or_default();
        assert!(text.contains(place) && text.contains(words), "{sets:?}: {text}");
    }
}

/// A library user's specifications without a meaning.
#[test]
fn what_cannot_fill_is_not_built() {
    let refused = |change: &dyn Fn(&mut NetworkSpec, &mut RingsSpec)| {
        let mut spec = network(&case_of(&small(), &[]));
        let CanopyAir::Rings(mut rings) = spec.canopies[0].air.clone() else { panic!("rings") };
        change(&mut spec, &mut rings);
        spec.canopies[0].air = CanopyAir::Rings(rings);
        build_network(spec, Threads::one()).err().expect("it has no meaning")
    };
    let reasons = [
        (refused(&|_, rings| rings.rows.clear()), "needs rows"),
        (refused(&|_, rings| rings.rows.truncate(1)), "at least two rows"),
        (refused(&|_, rings| drop(rings.rows.pop())), "triangles beside its rows"),
        (refused(&|_, rings| drop(rings.rows.remove(2))), "triangles beside its rows"),
        (refused(&|_, rings| rings.rows.swap(1, 3)), "two neighbouring rows"),
        (refused(&|_, rings| rings.outer_pressure_coefficient = 1.0), "below 1 outside"),
        (refused(&|_, rings| rings.damping = [-0.1, 0.0]), "damping"),
        (refused(&|_, rings| rings.cloth = Some(ClothSpec { linear: -1.0, quadratic: 2.0 })), "not negative"),
        // The confluence above the apex.
        (
            refused(&|spec, _| {
                let node = spec.canopies[0].confluence[0] as usize;
                spec.displacement[node] = [0.0, 0.0, 50.0];
            }),
            "a skirt between its apex and its confluence",
        ),
    ];
    for (error, words) in reasons {
        assert!(matches!(error, BuildError::Rings { .. }) && error.to_string().contains(words), "{words}: {error}");
    }
    let closed = refused(&|spec, rings| {
        let top = spec.mesh.nodes[rings.rows[0][0] as usize][2];
        for &node in rings.rows.last().into_iter().flatten() {
            let from = spec.mesh.nodes[node as usize];
            spec.displacement[node as usize] = [-from[0], -from[1], top - 1.0 - from[2]];
        }
    });
    assert!(matches!(closed, BuildError::Rings { row: Some(5), .. }), "{closed}");
    assert!(closed.to_string().contains("a mouth of no area at the start"), "{closed}");
}

/// Explicit, implicit and adaptive methods agree; the ledger closes.
#[test]
fn every_kind_of_method_takes_a_filling() {
    let case = case_of(&small(), &[("time.end", "0.06")]);
    let accurate = run(&changed(&case, &[("time.method", "rk4"), ("time.step", "1e-5")]));
    assert!(accurate.outcome.status == Status::Completed, "{:?}", accurate.outcome);
    for (method, step, tolerance) in [
        ("velocity-verlet", "1e-5", 1e-3),
        ("newmark", "2e-4", 3e-3),
        ("hht", "2e-4", 3e-3),
        ("generalized-alpha", "2e-4", 3e-3),
        ("backward-euler", "2e-4", 3e-2),
        ("energy-momentum", "2e-4", 3e-3),
    ] {
        let ran = run(&changed(&case, &[("time.method", method), ("time.step", step)]));
        assert!(ran.outcome.status == Status::Completed, "{method}: {:?}", ran.outcome);
        let off = apart(&ran, &accurate);
        println!("{method}: {off}, energy error {}, {} iterations", ran.outcome.energy_error, ran.most_iterations);
        assert!(off < tolerance, "{method}: {off}");
        assert!(ran.outcome.energy_error < 1e-2, "{method}: {}", ran.outcome.energy_error);
    }
    for method in ["newmark", "dormand-prince"] {
        let tolerance = "{\"relative\": 1e-5, \"absolute\": 1e-7}";
        let sets = [("time.method", method), ("time.step", "null"), ("time.tolerance", tolerance)];
        let off = apart(&run(&changed(&case, &sets)), &accurate);
        assert!(off < 3e-3, "{method} with adaptive steps: {off}");
    }
}

/// Steps of 1 and 4 ms converge, from the tube to the open canopy, and nearly agree.
#[test]
fn long_steps_converge() {
    let case = case_of(&small(), &[("time.end", "0.8")]);
    let ran: Vec<Run> = ["1e-3", "4e-3"].map(|step| run(&changed(&case, &[("time.step", step)]))).into();
    for one in &ran {
        assert!(one.outcome.status == Status::Completed, "{:?}", one.outcome);
        assert!(one.outcome.energy_error < 1e-2, "{}", one.outcome.energy_error);
    }
    let off = apart(&ran[1], &ran[0]);
    assert!(off < 2e-2, "{off}");
}

/// The same on one thread and on two.
#[test]
fn threads_change_no_bit() {
    let sets = [("time.end", "0.05"), ("system.network.mesh.parachute.radial_segments", "24")];
    let case = case_of(&small(), &sets);
    let [one, two] = [1, 2].map(|threads| run_with(&case, threads));
    assert!(one.outcome.status == Status::Completed);
    assert_eq!(one.state.x, two.state.x);
    assert_eq!(one.state.v, two.state.v);
}

/// The forces [N] at a state [m, m/s] of a case.
fn forces(case: &Case, x: &[f64], v: &[f64]) -> Vec<f64> {
    let scene = build_network(network(case), Threads::one()).expect("a sound scene");
    let mut out = scene.new_forces();
    scene.evaluate(StateRef { t: 0.0, x, v }, &mut out);
    out.total
}

/// The tangent with its rank-one parts against differences of the forces, by positions and by velocities, of canopies
/// of tight, porous and slotted cloth and with a gap, in air that changes with the height.
#[test]
fn the_tangent_is_a_slope() {
    let law = format!("{FILLING}.law");
    let porous = "{\"permeable\": {\"a\": 1.6e6, \"b\": 4.8e5, \"thickness\": 1e-4}}";
    let kind = "system.network.mesh.parachute.type";
    let porosity = format!("{FILLING}.geometric_porosity");
    let rows = [
        vec![(law.as_str(), "null")],
        vec![(law.as_str(), porous)],
        vec![(law.as_str(), "null"), (porosity.as_str(), "0.2")],
        vec![(law.as_str(), porous), (kind, "disk-gap-band")],
    ];
    let mut compared = 0;
    for mut sets in rows {
        sets.extend([
            ("system.network.aero.atmosphere", "{\"exponential\": {\"density\": 1.3, \"scale_height\": 30}}"),
            ("system.network.aero.wind", "{\"profile\": [[-90, -4, 1, 2], [60, 3, -2, -5]]}"),
        ]);
        let scene = build_network(network(&case_of(&small(), &sets)), Threads::one()).expect("a sound scene");
        let state = scene.initial_state();
        let forces = |x: &[f64], v: &[f64]| {
            let mut out = scene.new_forces();
            scene.evaluate(StateRef { t: 0.0, x, v }, &mut out);
            out.total
        };
        for seed in 0..10_usize {
            let wave = |i: usize| ((37 * i + 911 * seed) as f64).sin();
            // From the tube to three times its width.
            let wide = 1.0 + 0.2 * seed as f64;
            let widened = |i: usize, x: &f64| if i % 3 < 2 { wide * x } else { *x };
            let x: Vec<f64> = state.x.iter().enumerate().map(|(i, x)| widened(i, x) + 5e-3 * wave(i)).collect();
            let v: Vec<f64> = state.v.iter().enumerate().map(|(i, v)| v + 1.5 * wave(7 * i)).collect();
            let along: Vec<f64> = (0..x.len()).map(|i| wave(5 * i + 3)).collect();
            for of_velocity in [false, true] {
                let h = if of_velocity { 1e-5 } else { 1e-8 };
                let moved =
                    |list: &[f64], by: f64| -> Vec<f64> { list.iter().zip(&along).map(|(a, p)| a + by * p).collect() };
                let at = |by: f64| if of_velocity { forces(&x, &moved(&v, by)) } else { forces(&moved(&x, by), &v) };
                let slope: Vec<f64> = at(-h).iter().zip(at(h)).map(|(a, b)| (a - b) / (2.0 * h)).collect();
                let w = Weights { m: 0.0, c: f64::from(of_velocity), k: f64::from(!of_velocity) };
                let mut found = vec![0.0; x.len()];
                scene.tangent_times(StateRef { t: 0.0, x: &x, v: &v }, w, &along, &mut found);
                let size = |list: &[f64]| list.iter().map(|f| f * f).sum::<f64>().sqrt();
                let off: Vec<f64> = slope.iter().zip(&found).map(|(a, b)| a - b).collect();
                let share = size(&off) / size(&slope);
                assert!(share < 1e-5, "{sets:?}, state {seed}, by velocity {of_velocity}: {share}");
                compared += 1;
            }
        }
    }
    assert_eq!(compared, 80);
}

/// Without drag on bodies and gravity, everything that moves along with a wind sees what it sees at rest.
#[test]
fn a_moving_frame_changes_nothing() {
    let calm = case_of(&small(), &[("system.network.aero.drag", "[]")]);
    let moving = changed(&calm, &[("system.network.aero.wind", "[7, -11, 13]")]);
    let scene = build_network(network(&calm), Threads::one()).expect("a sound scene");
    let state = scene.initial_state();
    let wave = |i: usize| ((37 * i) as f64).sin();
    let x: Vec<f64> = state.x.iter().enumerate().map(|(i, x)| x + 0.01 * wave(i)).collect();
    let v: Vec<f64> = state.v.iter().enumerate().map(|(i, v)| v + 2.0 * wave(7 * i)).collect();
    let along: Vec<f64> = v.iter().enumerate().map(|(i, v)| v + [7.0, -11.0, 13.0][i % 3]).collect();
    let (at_rest, moved) = (forces(&calm, &x, &v), forces(&moving, &x, &along));
    let size = at_rest.iter().fold(0.0, |most: f64, f| most.max(f.abs()));
    let off = at_rest.iter().zip(&moved).fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
    assert!(off < 1e-9 * size, "{off} of {size}");
}

/// A payload that is thrown upwards, so that the air comes from behind, and a canopy without speed: the pressure stays
/// finite, and the run goes on.
#[test]
fn air_from_behind_gives_no_pressure() {
    for velocity in ["[0, 0, 25]", "[0, 0, 0]"] {
        let sets = [("system.network.initial.velocity", velocity), ("time.end", "0.1")];
        let ran = run(&case_of(&small(), &sets));
        assert!(ran.outcome.status == Status::Completed, "{velocity}: {:?}", ran.outcome);
        assert!(ran.positions.as_flattened().iter().all(|x| x.is_finite()));
    }
}

/// A canopy of tight cloth without a vent fills, too.
#[test]
fn a_closed_vent_and_tight_cloth_fill() {
    let law = format!("{FILLING}.law");
    let sets = [
        (law.as_str(), "null"),
        ("system.network.mesh.parachute.vent_diameter", "null"),
        ("time.step", "2e-3"),
        ("time.end", "0.4"),
    ];
    let mut value = small();
    if let Some(springs) = value["system"]["network"]["springs"].as_array_mut() {
        springs.retain(|spring| !["vent", "vent-lines"].map(Value::from).contains(&spring["on"]["group"]));
    }
    let ran = run(&case_of(&value, &sets));
    assert!(ran.outcome.status == Status::Completed, "{:?}", ran.outcome);
    assert!(ran.outcome.energy_error < 1e-2, "{}", ran.outcome.energy_error);
}

/// [m] Mean distance of the skirt from the axis.
fn skirt_radius(case: &Case, positions: &[[f64; 3]]) -> f64 {
    let skirt = &network(case).canopies[0].skirt;
    let sum: f64 = skirt.iter().map(|&i| positions[i as usize][0].hypot(positions[i as usize][1])).sum();
    sum / skirt.len() as f64
}

/// A reefing line holds the mouth. When it is cut the mouth grows with the air that it takes, not at once.
#[test]
fn a_cut_reefing_line_lets_the_mouth_grow() {
    let cut = 0.6;
    let mut value = small();
    value["system"]["network"]["mesh"]["parachute"]["reefing"] = json!({"diameter": 0.3});
    let reefing = json!({
        "on": {"group": "reefing"}, "axial_rigidity": 4e3, "linear_density": 0.004, "slack": "tension-only",
        "dashpot": {"axial": {"time": 1e-3}}, "rest_scale": {"table": [[0, 1], [cut, 1], [cut + 1e-3, 8]]}
    });
    if let Some(springs) = value["system"]["network"]["springs"].as_array_mut() {
        springs.push(reefing);
    }
    let case = case_of(&value, &[("time.end", "1.2"), ("time.step", "2e-3")]);
    let mut radii = Vec::new();
    let outcome = follow(&case, |state| radii.push((state.t, skirt_radius(&case, state.positions))));
    assert!(outcome.status == Status::Completed, "{outcome:?}");
    let at = |t: f64| radii.iter().find(|(time, _)| *time >= t - 1e-9).map_or(f64::NAN, |(_, r)| *r);
    let (reefed, soon, later, open) = (at(cut), at(cut + 0.02), at(cut + 0.05), at(1.2));
    println!("{reefed} {soon} {later} {open}");
    assert!((0.14..0.17).contains(&reefed) && open > 6.0 * reefed, "{reefed} {open}");
    assert!(soon < 1.5 * reefed && later < 2.2 * reefed, "{reefed} {soon} {later}");
}
