//! Closed forms of the patterns that are not cones: ellipsoids, rings, parts of spheres, ribbons, polygons.

use super::*;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::mesh::parachute::StartShape;

fn sizes(kind: &str, more: Value) -> ParachuteSizes {
    parameters(kind, more).sizes().expect("sizes")
}

/// Half an oblate spheroid of half axes a and b: pi a^2 (1 + (1 - e^2)/e atanh(e)), e^2 = 1 - b^2/a^2. The upper half
/// of a torus: 2 pi^2 times both radii, beside the vent. With two heights, each quarter of an ellipse is a part of its
/// own.
#[test]
fn ellipsoids_and_rings_have_their_areas() {
    let fine = |mut more: Value| {
        (more["gores"], more["radial_segments"], more["gore_segments"]) = (json!(300), json!(300), json!(1));
        more
    };
    let nominal = 0.25 * PI * 8.534_f64.powi(2);
    for ratio in [0.4_f64, 0.7] {
        let found = sizes("elliptical", fine(json!({"height_ratio": ratio, "vent_diameter": null})));
        let (a, e) = (0.5 * found.constructed_diameter, (1.0 - ratio * ratio).sqrt());
        close(PI * a * a * (1.0 + (1.0 - e * e) / e * e.atanh()), nominal, 2e-4, "spheroid");
    }
    let lines = json!({"segments": 1});
    let (vent, inner) = (2.0, |more: Value| {
        let mut all = fine(more);
        (all["vent_diameter"], all["inner_lines"]) = (json!(2.0), lines.clone());
        all
    });
    let ring = sizes("toroidal", inner(json!({})));
    let [r, v] = [0.5 * ring.constructed_diameter, 0.5 * vent];
    close(2.0 * PI * PI * 0.5 * (r + v) * 0.5 * (r - v) + PI * v * v, nominal, 2e-4, "torus");
    close(ring.gore_length, v + PI * 0.5 * (r - v), 2e-4, "half a circle");
    // The vent is level with the skirt, or below it by the depth that is asked for.
    for (pull_down, below) in [(1.0, 0.0), (1.4, 0.4)] {
        let p =
            parameters("toroidal", inner(json!({"height_ratio": 0.5, "pull_down": pull_down, "radial_segments": 8})));
        let mesh = built(&ParachuteParameters { radial_segments: 8, gores: 28, ..p.clone() });
        let height = |name: &str| point(&mesh, group(&mesh, name).nodes[0]).z;
        let crest = mesh.nodes.iter().map(|x| x[2]).fold(0.0, f64::max);
        assert!((height("vent") + below * crest).abs() < 1e-12, "{pull_down}: {} of {crest}", height("vent"));
        let radius = 0.5
            * ParachuteParameters { radial_segments: 8, gores: 28, ..p }.sizes().expect("sizes").constructed_diameter;
        close(crest, 0.5 * radius, 1e-12, "crest");
    }
}

/// A quarter of a sphere has the constructed diameter D0 cos(pi/6); slots have their part of the area exactly.
#[test]
fn rings_and_ribbons_have_their_porosity() {
    let sail = json!({"rings": 8, "sails": 5, "slot_porosity": 0.07, "fullness": 0.1, "vent_diameter": null,
        "gores": 200, "radial_segments": 200});
    let found = sizes("ringsail", sail);
    close(found.constructed_diameter / 8.534, (PI / 6.0).cos(), 1e-4, "quarter sphere");
    close(found.cloth_area, 0.93 * found.nominal_area, 1e-12, "ringsail");
    let coarse = sizes(
        "ringsail",
        json!({"rings": 6, "sails": 6, "slot_porosity": 0.12, "fullness": 0.1,
        "vent_diameter": null, "gores": 9, "radial_segments": 6, "cap_angle": 1.3}),
    );
    close(coarse.cloth_area, 0.88 * coarse.nominal_area, 1e-12, "all sails");
    let (n, corner) = (28.0, 0.425_f64);
    for angle in [0.0, 0.35_f64] {
        let more = json!({"rings": 7, "slot_porosity": 0.2, "cone_angle": angle});
        let found = sizes("ribbon", more);
        let apothem = corner * (PI / n).cos();
        let vent = n * (PI / n).tan() * apothem * apothem / angle.cos();
        close(found.cloth_area + vent, 0.8 * found.nominal_area, 1e-12, "ribbon");
        close(n * (PI / n).tan() * found.gore_length.powi(2) * angle.cos(), found.nominal_area, 1e-12, "cone");
    }
}

/// a^2 (1 - 2 c^2) and sqrt(3)/4 a^2 (1 - 3 c^2), in the sizes and on the mesh; every line hangs on the skirt.
#[test]
fn polygons_have_their_areas() {
    let nominal = 0.25 * PI * 8.534_f64.powi(2);
    for cut in [None, Some(0.12)] {
        let c: f64 = cut.unwrap_or(0.0);
        for (kind, gores) in [("square", 24), ("triangular", 24), ("square", 8), ("triangular", 6)] {
            let p = parameters(kind, json!({"gores": gores, "vent_diameter": 0.9, "corner_cut": cut}));
            let found = p.sizes().expect("sizes");
            // Of the circle inside the sides.
            let side = found.constructed_diameter * if kind == "square" { 1.0 } else { 3.0_f64.sqrt() };
            let area = if kind == "square" { 1.0 - 2.0 * c * c } else { 0.25 * 3.0_f64.sqrt() * (1.0 - 3.0 * c * c) };
            close(side * side * area, nominal, 1e-12, kind);
            let mesh = built(&p);
            let rim: Vec<f64> = group(&mesh, "skirt").edges.iter().map(|&edge| length(&mesh, edge)).collect();
            let (k, cuts) = if kind == "square" { (4.0, 2.0_f64.sqrt()) } else { (3.0, 1.0) };
            close(rim.iter().sum(), k * side * (1.0 - 2.0 * c + cuts * c), 1e-12, "perimeter");
            let vent =
                group(&mesh, "vent").nodes.iter().map(|&node| point(&mesh, node).xy().norm()).fold(0.0, f64::max);
            close(vent, 0.45, 1e-12, "circle through the vent's corners");
            assert!(!mesh.groups.contains_key("vent-lines"));
            // Lines are told to be equally long.
            let told = p.line_lengths(&mesh);
            assert_eq!(told.iter().map(|(edge, _)| *edge).collect::<Vec<_>>(), group(&mesh, "lines").edges);
            told.iter().for_each(|(_, rest)| close(*rest, 7.68 / 6.0, 1e-14, "line"));
        }
    }
}

/// Tapes cross every ribbon and slot from the vent to the skirt, evenly spaced in each gore.
#[test]
fn verticals_cross_ribbons_and_slots() {
    let more = json!({"rings": 6, "slot_porosity": 0.2, "verticals": 3, "gore_segments": 4});
    let mesh = built(&parameters("ribbon", more));
    let edges = &group(&mesh, "verticals").edges;
    let (rows, n) = (12 + 5, 28);
    assert_eq!(edges.len(), 3 * n * rows);
    let ends = |name: &str| {
        let nodes = edges.iter().flat_map(|&edge| mesh.edges[edge as usize]);
        nodes.filter(|node| group(&mesh, name).nodes.contains(node)).count()
    };
    assert_eq!((ends("vent"), ends("skirt")), (3 * n, 3 * n));
    let radials = &group(&mesh, "radials").edges;
    assert!(edges.iter().all(|edge| !radials.contains(edge)));
    let across = edges.iter().filter(|&edge| group(&mesh, "cloth").edges.binary_search(edge).is_err()).count();
    assert_eq!(across, 3 * n * 5, "tapes across the slots");
}

/// The lower edge of each sail but the skirt's is longer than the gore by the fullness, its upper edge is not, and the
/// flat piece between them has the edges that are told.
#[test]
fn sails_are_wider_than_their_gores() {
    let p = parameters(
        "ringsail",
        json!({"rings": 5, "sails": 3, "slot_porosity": 0.08, "fullness": 0.1, "radial_segments": 10, "gore_segments": 3}),
    );
    let mesh = built(&p);
    let told: std::collections::BTreeMap<u32, f64> = p.line_lengths(&mesh).into_iter().collect();
    let number: std::collections::HashMap<[u32; 2], u32> =
        (0..).zip(&mesh.edges).map(|(i, &[a, b])| ([a.min(b), a.max(b)], i)).collect();
    let edge = |a: u32, b: u32| number[&[a.min(b), a.max(b)]];
    let ratio = |row: &[u32]| {
        let around = row.iter().zip(row.iter().cycle().skip(1)).map(|(&a, &b)| edge(a, b));
        let [full, flat] = around.fold([0.0; 2], |[full, flat], e| {
            [full + told.get(&e).copied().unwrap_or_else(|| length(&mesh, e)), flat + length(&mesh, e)]
        });
        full / flat
    };
    // Three rows a ring: its upper edge, its middle, its lower edge.
    let ratios: Vec<f64> = mesh.rows.iter().map(|row| ratio(row)).collect();
    let expected = [1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.05, 1.1, 1.0, 1.05, 1.1, 1.0, 1.0, 1.0];
    assert_eq!(ratios.len(), expected.len());
    for (found, expected) in ratios.iter().zip(expected) {
        close(*found, expected, 1e-12, "width of a row");
    }
    // No edge of the cloth is shorter than on the gore, and the triangles are those of a flat piece.
    for (&edge, &rest) in &told {
        assert!(rest > length(&mesh, edge) * 0.98, "edge {edge}: {rest}");
    }
    let radials = &group(&mesh, "radials").edges;
    assert!(radials.iter().all(|edge| !told.contains_key(edge)));
    // A case takes them as lengths without tension.
    let time = json!({"end": 0.1, "method": "newmark", "step": 0.01});
    let law = json!({"table": {"pressure_coefficient": 1.7}});
    let case = crate::common::run::case_of(&stretched::drop_of(&p, &mesh, &law, 6.0, &time), &[]);
    let SystemSpec::Network(spec) = &case.problem().system else { panic!("a network") };
    for (edge, rest) in spec.springs[0].edges.iter().zip(&spec.springs[0].rest_length) {
        close(*rest, told.get(edge).copied().unwrap_or_else(|| length(&mesh, *edge)), 1e-14, "rest length");
    }
    let plain = json!({"rings": 5, "sails": 3, "slot_porosity": 0.08, "fullness": 1e-12, "radial_segments": 10, "gore_segments": 3});
    let plain = parameters("ringsail", plain);
    assert_eq!(built(&plain), mesh, "the mesh shows the gore");
    for (edge, rest) in plain.line_lengths(&mesh) {
        close(rest, length(&mesh, edge), 1e-11, "no fullness");
    }
}

/// A centre line joins apex and confluence, has its own length, and pulls the apex down at line stretch.
#[test]
fn a_centre_line_holds_the_apex() {
    let more = |length: f64| {
        json!({"height_ratio": 0.7, "vent_diameter": null, "start": "stretched",
        "centre_line": {"length": length, "segments": 2}})
    };
    let at = |mesh: &Mesh, node: u32| point(mesh, node) + Vector::from(mesh.displacement[node as usize]);
    for (long, taut) in [(7.0, true), (40.0, false)] {
        let p = parameters("elliptical", more(long));
        let mesh = built(&p);
        let edges = &group(&mesh, "centre-line").edges;
        assert_eq!(edges.len(), 2);
        let told: Vec<(u32, f64)> = p.line_lengths(&mesh);
        assert_eq!(told, edges.iter().map(|&edge| (edge, 0.5 * long)).collect::<Vec<_>>());
        let [apex, confluence] = ["apex", "confluence"].map(|name| at(&mesh, group(&mesh, name).nodes[0]));
        assert_eq!(((apex - confluence).norm() / long - 1.0).abs() < 1e-9, taut, "{}", (apex - confluence).norm());
    }
    let refused = ["inflated", "square"].map(|of| match of {
        "square" => parameters("square", json!({"start": "inflated"})).build(),
        _ => parameters(
            "flat-circular",
            json!({"start": "inflated", "vent_diameter": null, "centre_line": {"length": 7.0}}),
        )
        .build(),
    });
    let [held, square] = refused.map(|result| result.expect_err("no such shape").to_string());
    assert!(held.contains("without a centre line") && square.contains("a round canopy"), "{held} {square}");
}

/// What such canopies cannot be is refused at its place.
#[test]
fn bad_forms_are_refused() {
    let ring = json!({"rings": 6, "sails": 4, "slot_porosity": 0.08, "fullness": 0.1});
    let rows: [(&str, Value, &str, &str); 21] = [
        ("elliptical", json!({}), "/height_ratio", "needs it"),
        ("elliptical", json!({"height_ratio": 2.0}), "/height_ratio", "below 2"),
        ("elliptical", json!({"height_ratio": 0.7, "pull_down": 1.0}), "/pull_down", "only with type \"toroidal\""),
        (
            "elliptical",
            json!({"height_ratio": 0.7, "centre_line": {"length": 7}}),
            "/centre_line",
            "only from the apex",
        ),
        (
            "cruciform",
            json!({"vent_diameter": null, "centre_line": {"length": 7}}),
            "/centre_line",
            "only from the apex",
        ),
        (
            "elliptical",
            json!({"height_ratio": 0.7, "vent_diameter": null, "centre_line": {"length": 0}}),
            "/centre_line/length",
            "above 0",
        ),
        ("toroidal", json!({"vent_diameter": null, "inner_lines": {}}), "/vent_diameter", "needs it"),
        ("toroidal", json!({}), "/inner_lines", "needs it"),
        ("toroidal", json!({"inner_lines": {}, "pull_down": 0}), "/pull_down", "above 0"),
        ("square", json!({"gores": 30}), "/gores", "a multiple of 4"),
        ("square", json!({"gores": 4, "corner_cut": 0.1}), "/gores", "at least 8"),
        ("triangular", json!({}), "/gores", "a multiple of 3"),
        ("triangular", json!({"gores": 30, "corner_cut": 0.5}), "/corner_cut", "below 0.5"),
        ("ribbon", json!({"rings": 6, "slot_porosity": 0.2, "verticals": 2}), "/gore_segments", "a multiple of 3"),
        ("ribbon", json!({"rings": 1, "slot_porosity": 0.2}), "/rings", "2 to 1000"),
        ("ribbon", json!({"rings": 6}), "/slot_porosity", "needs it"),
        (
            "ringslot",
            json!({"rings": 6, "slot_porosity": 0.2, "verticals": 1}),
            "/verticals",
            "only with type \"ribbon\"",
        ),
        ("ringsail", json!({"rings": 6, "slot_porosity": 0.1, "fullness": 0.1}), "/sails", "needs it"),
        ("ringsail", json!({"rings": 6, "slot_porosity": 0.1, "fullness": 0.1, "sails": 7}), "/sails", "2 to 6"),
        ("ringsail", json!({"rings": 6, "slot_porosity": 0.1, "sails": 3}), "/fullness", "needs it"),
        (
            "ringsail",
            {
                let mut one = ring;
                one["gore_segments"] = json!(1);
                one
            },
            "/gore_segments",
            "at least 2 with fullness",
        ),
    ];
    for (kind, more, at, words) in rows {
        let mut faults = Vec::new();
        parameters(kind, more.clone()).check("", &mut |place, value, allowed, hint| {
            faults.push((place.to_owned(), format!("{value}; {allowed}; {hint}")));
        });
        let hit = faults.iter().find(|(place, text)| place == at && text.contains(words));
        assert!(hit.is_some(), "{kind} {more}: no \"{words}\" at {at} in {faults:?}");
    }
    let steep = json!({"nominal_diameter": 8.0, "height_ratio": 1.9, "vent_diameter": 4.6});
    let steep = parameters("elliptical", steep).build();
    assert!(steep.is_err_and(|error| error.to_string().contains("/parachute/vent_diameter")));
    let wide = parameters("toroidal", json!({"vent_diameter": 5.9, "height_ratio": 1.9, "inner_lines": {}})).build();
    assert!(wide.is_err_and(|error| error.to_string().contains("/parachute/vent_diameter")));
    let open = json!({"rings": 30, "sails": 2, "slot_porosity": 0.49, "fullness": 0.1, "vent_diameter": 5.5, "radial_segments": 30});
    assert!(parameters("ringsail", open).build().is_err_and(|error| error.to_string().contains("/slot_porosity")));
}

/// Each form opens from line stretch by the balance of the air at its rings: 15 steps, finite, falling as a whole.
#[test]
fn forms_fill_ring_by_ring() {
    let forms = ["Ribbon", "Ringsail", "Elliptical", "Toroidal", "Square", "Triangular"];
    let all = types().into_iter().filter(|p| forms.contains(&format!("{:?}", p.kind).as_str()));
    for mut p in
        all.map(|p| ParachuteParameters { gores: 12, radial_segments: 6, start: StartShape::Stretched.into(), ..p })
    {
        // Shorter ones draw the apex below the skirt, where there is no tube of air.
        p.inner_lines.iter_mut().for_each(|inner| inner.length = Some(9.0));
        p.centre_line.iter_mut().for_each(|line| line.length = Some(9.0));
        let mesh = built(&p);
        assert_eq!(mesh.rows.len(), 7 + p.rings.map_or(0, |rings| rings - 1), "{:?}", p.kind);
        let time = json!({"end": 0.015, "method": "backward-euler", "step": 0.001});
        let case = stretched::drop_of(&p, &mesh, &json!({"filling": {}}), 45.0, &time);
        let case = crate::common::run::case_of(&case, &[]);
        let mut simulation = Simulation::from_case(case.problem(), 1).expect("a scene");
        simulation.run_until(0.015).unwrap_or_else(|error| panic!("{p:?}: {error}"));
        assert!(simulation.positions().iter().all(|x| x.iter().all(|c| c.is_finite())), "{p:?}");
        let payload = group(&mesh, "payload").nodes[0];
        let fallen = simulation.positions()[payload as usize][2] - mesh.nodes[payload as usize][2];
        assert!((fallen + 0.675).abs() < 0.04, "{p:?}: it fell {fallen} m in 0.015 s at 45 m/s");
    }
}

/// Flat rings of ribbons have Taylor's shape; cones, domes, rings and pulled-down apexes have none.
#[test]
fn only_flat_round_forms_start_inflated() {
    let ribbon = |more: Value| {
        let mut all = json!({"rings": 6, "slot_porosity": 0.2, "start": "inflated"});
        more.as_object().expect("an object").iter().for_each(|(key, value)| all[key] = value.clone());
        parameters("ribbon", all)
    };
    assert!(!built(&ribbon(json!({}))).displacement.is_empty());
    let sail = json!({"rings": 6, "sails": 4, "slot_porosity": 0.08, "fullness": 0.1, "start": "inflated"});
    for (p, words) in [
        (ribbon(json!({"cone_angle": 0.35})), "stretches the gores"),
        (parameters("ringsail", sail), "stretches the gores"),
        (parameters("elliptical", json!({"height_ratio": 0.7, "start": "inflated"})), "stretches the gores"),
        (parameters("toroidal", json!({"inner_lines": {}, "start": "inflated"})), "closed at its apex"),
        (parameters("triangular", json!({"gores": 27, "start": "inflated"})), "a round canopy"),
    ] {
        let refused = p.build().map(|_| ()).expect_err("no such shape").to_string();
        assert!(refused.contains("/parachute/start") && refused.contains(words), "{:?}: {refused}", p.kind);
    }
}
