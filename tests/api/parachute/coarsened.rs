//! Gores coarsened towards the apex: angles, areas, rows, tapes, and what a fall makes of them.

use super::*;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::mesh::Quality;
use std::collections::BTreeSet;

/// A canopy with so many edges across a gore that cells at the skirt are at most 1.8 times as wide as rows are high on
/// average.
fn coarsened(kind: &str, gores: usize, more: &Value) -> ParachuteParameters {
    let of = |across: usize| {
        let given = json!({"gores": gores, "gore_segments": across, "coarsen": true, "lines": {"length": 14.5}});
        let mut p = serde_json::to_value(parameters(kind, given)).expect("parameters");
        more.as_object().expect("an object").iter().for_each(|(key, value)| p[key] = value.clone());
        if !gores.is_multiple_of(2) {
            p["vent_lines"] = json!(false);
        }
        p.as_object_mut().expect("an object").retain(|_, value| !value.is_null());
        if p.get("vent_diameter").is_none() {
            p.as_object_mut().expect("an object").remove("vent_lines");
        }
        serde_json::from_value::<ParachuteParameters>(p).expect("parameters")
    };
    let sizes = of(1).sizes().expect("sizes");
    let wide = sizes.constructed_diameter * (PI / gores as f64).tan();
    let high = (sizes.gore_length - 0.5 * of(1).vent_diameter.unwrap_or(0.0)) / 12.0;
    of((wide / (1.8 * high)).ceil() as usize)
}

fn kinds() -> Vec<(&'static str, Value)> {
    let own = [
        ("flat-circular", json!({})),
        ("conical", json!({"cone_angle": 0.4})),
        ("biconical", json!({"cone_angles": [0.3, 0.7], "cone_breaks": [0.6]})),
        ("triconical", json!({"cone_angles": [0.2, 0.5, 0.9]})),
        ("hemispherical", json!({})),
        ("extended-skirt", json!({})),
        ("extended-skirt", json!({"skirt_angle": 2.9})),
        ("disk-gap-band", json!({})),
    ];
    let mut all = Vec::new();
    for (kind, more) in own {
        for vent in [json!(null), json!(0.457), json!(0.85)] {
            let mut more = more.clone();
            more["vent_diameter"] = vent;
            all.push((kind, more));
        }
    }
    all.push(("ringslot", json!({"rings": 4, "slot_porosity": 0.12})));
    all.push(("annular", json!({"vent_diameter": 4.0, "inner_lines": {}})));
    all.push(("annular", json!({"vent_diameter": 2.0})));
    all
}

/// What holds for every canopy: cut areas, one sound surface with its normals outwards, rows that are loops, all tapes.
fn check(p: &ParachuteParameters) -> Quality {
    let (mesh, sizes) = (built(p), p.sizes().expect("sizes"));
    let name = format!("{:?} {} {} {:?}", p.kind, p.gores, p.gore_segments, p.vent_diameter);
    close(cloth_area(&mesh), sizes.cloth_area, 1e-12, &name);
    let topology = Topology::new(&mesh).expect("sound");
    assert!(topology.check_manifold().is_ok() && topology.check_orientation(&mesh).is_ok(), "{name}");
    assert!(topology.components() == 1 && topology.loops().iter().all(|l| l.closed), "{name}");
    let canopy = sole_canopy(&mesh).unwrap_or_else(|e| panic!("{name}: {e}"));
    let slope = ["Conical", "Biconical", "Triconical", "Hemispherical"].contains(&format!("{:?}", p.kind).as_str());
    close(canopy.nominal_area, sizes.nominal_area, if slope { 1e-3 } else { 1e-12 }, &name);

    let loops = topology.loops().len();
    let bands = 1 + mesh.groups.get("rims").map_or(0, |_| (loops - usize::from(p.vent_diameter.is_some()) - 1) / 2);
    let cloth = &group(&mesh, "cloth").edges;
    let alone = |name: &str| {
        let edges = mesh.groups.get(name).map(|group| group.edges.as_slice()).unwrap_or_default();
        edges.iter().filter(|edge| cloth.binary_search(edge).is_err()).count()
    };
    let between = ["lines", "vent-lines", "radials", "inner-lines"].map(alone).iter().sum::<usize>();
    assert_eq!(topology.euler_characteristic(), (2 * bands - loops) as i64 + 1 - between as i64, "{name}");

    let drawn_in = p.skirt_angle.is_some_and(|angle| angle > 0.5 * PI);
    let top = mesh.nodes.iter().map(|x| x[2]).fold(0.0, f64::max);
    let centre = Vector::new(0.0, 0.0, if drawn_in { 0.5 * top } else { -1.0 });
    for t in &mesh.triangles {
        let corners = t.map(|node| point(&mesh, node));
        assert!(area_vector(corners).dot(&(corners.iter().sum::<Vector>() / 3.0 - centre)) > 0.0, "{name}");
    }

    let key = |a: u32, b: u32| [a.min(b), a.max(b)];
    let sides: BTreeSet<[u32; 2]> = cloth.iter().map(|&edge| mesh.edges[edge as usize]).collect();
    let sides: BTreeSet<[u32; 2]> = sides.iter().map(|&[a, b]| key(a, b)).collect();
    let lengths: Vec<usize> = mesh.rows.iter().map(Vec::len).collect();
    assert!(lengths.is_sorted(), "{name}: {lengths:?}");
    for row in mesh.rows.iter().filter(|row| row.len() > 1) {
        let turn = |i: usize| point(&mesh, row[i]).xy().perp(&point(&mesh, row[(i + 1) % row.len()]).xy());
        assert!(
            (0..row.len()).all(|i| sides.contains(&key(row[i], row[(i + 1) % row.len()])) && turn(i) > 0.0),
            "{name}"
        );
    }
    for pair in mesh.rows.windows(2) {
        let crosses = |&&edge: &&u32| {
            let [a, b] = mesh.edges[edge as usize];
            pair.iter().all(|row| row.contains(&a) || row.contains(&b))
        };
        let between = group(&mesh, "radials").edges.iter().filter(crosses).map(|edge| strands(&mesh, "radials", *edge));
        close(between.sum(), p.gores as f64, 1e-12, &name);
    }
    if let Some(lines) = mesh.groups.get("vent-lines") {
        close(lines.edges.iter().map(|e| strands(&mesh, "vent-lines", *e)).sum(), 0.5 * p.gores as f64, 1e-12, &name);
    }
    Quality::new(&mesh).expect("measures")
}

fn strands(mesh: &Mesh, name: &str, edge: u32) -> f64 {
    mesh.strands.get(name).and_then(|of| of.get(&edge)).copied().unwrap_or(1.0)
}

/// At least 20 degrees for every type and every number of gores from 8 to 48, primes among them. Edges of the cloth are
/// at most 5 times as long as others; without coarsening it is up to 27 times.
#[test]
fn angles_are_at_least_twenty_degrees() {
    for (kind, more) in kinds() {
        for gores in 8..=48 {
            let p = coarsened(kind, gores, &more);
            let quality = check(&p);
            let mesh = built(&p);
            let lengths = || group(&mesh, "cloth").edges.iter().map(|edge| length(&mesh, *edge));
            let ratio = lengths().fold(0.0, f64::max) / lengths().fold(f64::INFINITY, f64::min);
            let name = format!("{kind} {gores} {} {:?}", p.gore_segments, p.vent_diameter);
            assert!(quality.min_angle >= 20.0 && ratio < 5.0, "{name}: {} degrees, {ratio}", quality.min_angle);
        }
    }
}

/// Gores whose number has no divisors merge too, and an option that is off leaves all as it is.
#[test]
fn coarsening_is_an_option() {
    let with = |coarsen: bool, gores: usize| {
        let given = json!({"gores": gores, "coarsen": coarsen, "vent_lines": false, "gore_segments": 1});
        built(&parameters("flat-circular", given))
    };
    for gores in [28, 29] {
        let counts = |coarsen| with(coarsen, gores).rows.iter().map(Vec::len).collect::<Vec<_>>();
        assert!(counts(false).iter().all(|count| *count == gores) && with(false, gores).strands.is_empty());
        assert!(counts(true)[0] <= 8 && counts(true)[12] == gores, "{:?}", counts(true));
    }
    let mut faults = Vec::new();
    let cross = parameters("cruciform", json!({"vent_diameter": null, "coarsen": true}));
    cross.check("/parachute", &mut |at, _, _, _| faults.push(at.to_owned()));
    assert_eq!(faults, ["/parachute/coarsen"]);
}

/// Every start keeps the cloth as it is cut, but for folds, and lines as long as they are.
#[test]
fn starts_stretch_nothing() {
    for (kind, more) in [
        ("flat-circular", json!({})),
        ("extended-skirt", json!({"gores": 30})),
        ("conical", json!({"cone_angle": 0.3, "gores": 27})),
        ("hemispherical", json!({"gore_segments": 3})),
        ("ringslot", json!({"rings": 4, "slot_porosity": 0.12})),
        ("disk-gap-band", json!({"lines": {"length": 14.5}})),
    ] {
        let starts: &[&str] = if ["flat-circular", "extended-skirt"].contains(&kind) {
            &["inflated", "stretched"]
        } else {
            &["stretched"]
        };
        for start in starts {
            let mut given = json!({"coarsen": true, "gore_segments": 1, "start": start, "vent_lines": false});
            more.as_object().expect("an object").iter().for_each(|(key, value)| given[key] = value.clone());
            let mesh = built(&parameters(kind, given));
            let at = |node: u32| point(&mesh, node) + Vector::from(mesh.displacement[node as usize]);
            let stretch = |edge: &u32| {
                let [a, b] = mesh.edges[*edge as usize];
                (at(a) - at(b)).norm() / length(&mesh, *edge)
            };
            let largest = |name: &str| group(&mesh, name).edges.iter().map(stretch).fold(0.0, f64::max);
            for (name, most) in [("cloth", 1.01), ("radials", 1.001), ("lines", 1.0 + 1e-9)] {
                assert!(largest(name) < most, "{kind} {start}: {name} {}", largest(name));
            }
        }
    }
}

/// A drop of 90.7 kg below a canopy of 24 gores, coarsened or not, with other keys replaced.
fn fall(coarsen: bool, sets: &[(&str, &str)]) -> Case {
    let tape = |name: &str| {
        json!({"on": {"group": name}, "axial_rigidity": 8000, "linear_density": 0.006, "slack": "tension-only",
            "dashpot": {"axial": {"per_strain": 8}}, "strength": 2450})
    };
    let mut springs = vec![json!({"on": {"group": "cloth"}, "slack": "tension-only",
        "membrane": {"modulus": 4.309e8, "thickness": 1e-4}, "dashpot": {"axial": {"time": 1e-3}}})];
    springs.extend(["radials", "vent-lines", "skirt", "vent", "lines", "riser"].map(tape));
    let case = json!({
        "name": "fall",
        "system": {"network": {
            "mesh": {"parachute": {"type": "flat-circular", "nominal_diameter": 8.534, "gores": 24, "vent_diameter": 0.457,
                "radial_segments": 10, "coarsen": coarsen, "lines": {"length": 7.21}, "riser": {"length": 1.0},
                "start": "inflated"}},
            "mass": {"areal_density": 0.0534, "points": [{"on": {"group": "payload"}, "mass": 90.7}]},
            "springs": springs,
            "gravity": [0, 0, -9.81],
            "aero": {"canopy": {"on": {"group": "canopy"}, "table": {"pressure_coefficient": 1.7}},
                "drag": [{"on": {"group": "vent-lines"}, "diameter": 0.003, "coefficient": 1.1}]},
            "initial": {"velocity": [0, 0, -6.0]}
        }},
        "time": {"end": 3.0, "method": "newmark", "step": 0.005}
    });
    crate::common::run::case_of(&case, sets)
}

/// A spring, a dashpot, a mass, a drag and a strength of an edge are those of all its strands.
#[test]
fn an_edge_stands_for_its_strands() {
    let [fine, coarse] = [false, true].map(|coarsen| {
        let case = fall(coarsen, &[]);
        let SystemSpec::Network(spec) = &case.problem().system else { panic!("a network") };
        (spec.clone(), case.problem().output.gauges.clone())
    });
    let (spec, gauges) = &coarse;
    for (rule, name) in [(1, "radials"), (2, "vent-lines")] {
        let springs = &spec.springs[rule];
        let damper = springs.dashpot.as_ref().expect("a dashpot");
        let mut most: f64 = 1.0;
        for (i, &edge) in springs.edges.iter().enumerate() {
            let (strands, rest) = (strands(&spec.mesh, name, edge), springs.rest_length[i]);
            most = most.max(strands);
            close(springs.stiffness.get(i).expect("k"), 8000.0 * strands / rest, 1e-14, name);
            close(damper.coefficient.get(i).expect("c"), 8.0 * strands / rest, 1e-14, name);
        }
        assert!(most >= 2.0, "{name}: {most}");
    }
    let total = |mass: &[f64]| mass.iter().sum::<f64>() - 90.7;
    close(total(&spec.mass), total(&fine.0.mass), 0.01, "mass of cloth, tapes and lines");
    let area = |spec: &canopy_fem::model::spec::NetworkSpec| {
        let of = |edges: &[u32]| edges.iter().map(|&edge| length(&spec.mesh, edge)).sum::<f64>();
        spec.line_drag.iter().map(|drag| drag.diameter * of(&drag.edges)).sum::<f64>()
    };
    assert!(spec.line_drag.iter().all(|drag| drag.diameter > 0.003));
    close(area(spec), area(&fine.0), 0.2, "vent lines");
    let names: Vec<&str> = gauges.iter().map(|gauge| gauge.name.as_str()).collect();
    assert!(names.contains(&"springs[1] radials") && names.contains(&"springs[1] radials (2 strands)"), "{names:?}");
    assert!(fine.1.iter().all(|gauge| !gauge.name.contains("strands")));
}

/// The steady fall and the width of the skirt stay within 1 %, and every law of the air runs.
#[test]
fn a_steady_fall_stays_the_same() {
    let end = |coarsen: bool| {
        let case = fall(coarsen, &[]);
        let SystemSpec::Network(spec) = &case.problem().system else { panic!("a network") };
        let payload = group(&spec.mesh, "payload").nodes[0] as usize;
        let skirt = group(&spec.mesh, "skirt").nodes.clone();
        let mut simulation = Simulation::from_case(case.problem(), 1).expect("a scene");
        simulation.run_until(3.0).expect("it runs");
        let wide = skirt.iter().map(|&node| Vector::from(simulation.positions()[node as usize]).xy().norm());
        [simulation.velocities()[payload][2], wide.sum::<f64>() / skirt.len() as f64]
    };
    let [fine, coarse] = [end(false), end(true)];
    for (fine, coarse) in fine.into_iter().zip(coarse) {
        close(coarse, fine, 0.01, "speed or radius");
    }
    let law = |law: &str| {
        let sets = [("system.network.aero.canopy", law), ("system.network.mesh.parachute.start", "stretched")];
        let case = fall(true, &[sets[0], sets[1], ("time.end", "0.05")]);
        let mut simulation = Simulation::from_case(case.problem(), 1).expect("a scene");
        simulation.run_until(0.05).unwrap_or_else(|error| panic!("{law}: {error}"));
        assert!(simulation.positions().iter().flatten().all(|c| c.is_finite()), "{law}");
    };
    for of in [
        r#"{"on": {"group": "canopy"}, "filling": {"outer_pressure_coefficient": -0.7}}"#,
        r#"{"on": {"group": "canopy"}, "schedule": {"drag_coefficient": 0.75, "filling_constant": 8, "exponent": 2}}"#,
        r#"{"on": {"group": "canopy"}, "cavity": {"inflow": 0.5, "outer_pressure_coefficient": -0.6}}"#,
    ] {
        law(of);
    }
}
