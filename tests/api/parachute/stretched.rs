//! The start `stretched`: the tube of line stretch, of every type of canopy, and what flies from it.

use super::*;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::mesh::parachute::StartShape;

/// [-] largest strain at the start
const STRAIN: f64 = 1e-12;

/// Every type, and what may be added to them: a reefing line, vent lines, inner lines, a cluster, finer cloth.
pub(super) fn stretched_types() -> Vec<ParachuteParameters> {
    let more = [
        parameters("flat-circular", json!({"reefing": {"diameter": 0.9}})),
        parameters("flat-circular", json!({"gores": 8, "gore_segments": 6, "radial_segments": 40})),
        parameters("annular", json!({"vent_diameter": 4.0, "vent_lines": true, "inner_lines": {"length": 9.0}})),
        parameters("annular", json!({"vent_diameter": 4.0, "inner_lines": {"length": 30.0, "segments": 2}})),
        parameters("annular", json!({"vent_diameter": 4.0, "inner_lines": {"length": 3.0, "segments": 2}})),
        parameters("annular", json!({"vent_diameter": 4.0})),
        parameters("cruciform", json!({"vent_diameter": null, "gores": 8, "radial_segments": 5})),
        parameters(
            "cruciform",
            json!({"vent_diameter": null, "gores": 20, "radial_segments": 30, "gore_segments": 12}),
        ),
        parameters("cruciform", json!({"vent_diameter": null, "arm_ratio": 0.9, "reefing": {"diameter": 2.0}})),
        parameters("flat-circular", json!({"riser": {"length": 20.0}, "cluster": {"canopies": 3}})),
    ];
    let stretched = |p| ParachuteParameters { start: StartShape::Stretched.into(), ..p };
    types().into_iter().chain(more).map(stretched).collect()
}

/// A mesh at its start.
pub(super) struct Start {
    pub(super) mesh: Mesh,
    pub(super) at: Vec<Vector>,
}

impl Start {
    pub(super) fn of(p: &ParachuteParameters) -> Self {
        let mesh = built(p);
        let displaced = mesh.nodes.iter().zip(&mesh.displacement).map(|(x, u)| Vector::from(*x) + Vector::from(*u));
        let at = displaced.collect();
        Self { mesh, at }
    }

    pub(super) fn at(&self, node: u32) -> Vector {
        self.at[node as usize]
    }

    pub(super) fn radius(&self, node: u32) -> f64 {
        self.at(node).xy().norm()
    }

    pub(super) fn length(&self, edge: u32) -> f64 {
        let [a, b] = self.mesh.edges[edge as usize];
        (self.at(a) - self.at(b)).norm()
    }

    /// Unstretched and present length of the edges of a group.
    pub(super) fn lengths(&self, p: &ParachuteParameters, name: &str) -> Vec<[f64; 2]> {
        let told: std::collections::BTreeMap<u32, f64> = p.line_lengths(&self.mesh).into_iter().collect();
        let edges = self.mesh.groups.get(name).map(|group| group.edges.clone()).unwrap_or_default();
        let rest = |edge| told.get(&edge).copied().unwrap_or_else(|| length(&self.mesh, edge));
        edges.iter().map(|&edge| [rest(edge), self.length(edge)]).collect()
    }
}

/// Nothing is stretched, nothing is degenerate, and the masses and lengths of the pattern stay.
#[test]
fn nothing_is_stretched_or_degenerate() {
    for p in stretched_types() {
        let start = Start::of(&p);
        let flat = built(&ParachuteParameters { start: StartShape::Flat.into(), ..p.clone() });
        assert!(start.mesh.edges == flat.edges && start.mesh.groups == flat.groups, "{p:?}");
        if p.cluster.is_none() {
            assert_eq!(start.mesh.nodes, flat.nodes, "{p:?}");
        }
        for name in ["cloth", "radials", "verticals", "vent-lines", "lines", "inner-lines", "centre-line", "riser"] {
            for [rest, now] in start.lengths(&p, name) {
                assert!(now < rest * (1.0 + STRAIN), "{name} of {:?}: {now} of {rest} m", p.kind);
                assert!(now > 1e-3 * rest, "{name} of {:?}: {now} of {rest} m", p.kind);
            }
        }
        for t in &start.mesh.triangles {
            let (now, rest) = (t.map(|node| start.at(node)), t.map(|node| point(&start.mesh, node)));
            let part = area_vector(now).norm() / area_vector(rest).norm();
            assert!(part > 1e-4 && part < 1.0, "{part:e} of a triangle's area: {p:?}");
        }
    }
}

/// The radii of the rows are those of the formula, arcs along the seams those of the pattern, lines taut.
#[test]
fn gores_hang_as_a_tube() {
    for p in stretched_types().into_iter().filter(|p| p.cluster.is_none()) {
        let start = Start::of(&p);
        let lines = start.lengths(&p, "lines");
        let drawn_down = p.inner_lines.as_ref().and_then(|inner| inner.length) == Some(3.0);
        let tautest = lines.iter().map(|[rest, now]| now / rest).fold(0.0, f64::max);
        assert!(drawn_down || p.centre_line.is_some() || (tautest - 1.0).abs() < 1e-12, "{tautest} of {p:?}");
        for [rest, now] in lines.iter().filter(|_| !drawn_down && is_round(&p)) {
            assert!(p.centre_line.is_some() || (now / rest - 1.0).abs() < 1e-12, "line of {now} for {rest} m: {p:?}");
            let lines = p.lines.as_ref().expect("lines");
            close(*rest, lines.length.expect("a length") / lines.segments as f64, 1e-12, "line");
        }
        if format!("{:?}", p.kind) == "Cruciform" || !is_round(&p) {
            continue;
        }
        let n = p.gores;
        let pattern = |node: u32| point(&start.mesh, node).xy().norm();
        let path = first_radial(&start.mesh);
        let step = |pair: &[u32]| (point(&start.mesh, pair[0]) - point(&start.mesh, pair[1])).norm();
        let cloth = path.windows(2).map(step).sum::<f64>();
        let mut arc = if p.vent_diameter.is_some() { tip(&p, pattern(path[0])) } else { 0.0 };
        let whole = arc + cloth;
        let ring = p.reefing.map_or(f64::INFINITY, |r| 0.5 * PI * r.diameter / (n as f64 * (PI / n as f64).sin()));
        let r0 = (0.025 * p.nominal_diameter.expect("D0")).min(ring);
        let formula = |node, arc| f64::min(pattern(node), r0 * (0.3 + 0.7 * arc / whole));
        assert!((start.radius(path[0]) - formula(path[0], arc)).abs() < 1e-10, "{p:?}");
        let held = p.centre_line.is_some();
        let folded = held || p.inner_lines.as_ref().is_some_and(|inner| inner.length != Some(30.0));
        let mut shorter = 0;
        for pair in path.windows(2) {
            arc += step(pair);
            close(start.radius(pair[1]), formula(pair[1], arc), 1e-9, "radius of a row");
            let [inner, outer] = [0, 1].map(|i| start.at(pair[i]));
            let kept = ((inner - outer).norm() / step(pair) - 1.0).abs() < 1e-12;
            shorter += usize::from(!kept);
            assert!(folded || (kept && inner.z > outer.z), "{p:?}");
        }
        assert!(shorter <= usize::from(folded), "one step has the fold: {shorter} of {p:?}");
        for [rest, now] in start.lengths(&p, "inner-lines") {
            let slack = p.inner_lines.as_ref().and_then(|inner| inner.length) == Some(30.0);
            assert!(slack == ((now / rest - 1.0).abs() > 1e-12), "inner line {now} of {rest}");
        }
    }
}

/// The nodes along a radial, from the apex or the vent to a line.
fn first_radial(mesh: &Mesh) -> Vec<u32> {
    let radials: Vec<[u32; 2]> = group(mesh, "radials").edges.iter().map(|&edge| mesh.edges[edge as usize]).collect();
    let skirt = &group(mesh, "skirt").nodes;
    let mut path = vec![*skirt.iter().find(|node| radials.iter().any(|pair| pair.contains(node))).expect("a corner")];
    let apex = mesh.groups.get("apex").map(|group| group.nodes[0]);
    while path.last().copied() != apex {
        let here = path[path.len() - 1];
        let ends = radials.iter().filter(|pair| pair.contains(&here)).flatten();
        let Some(&next) = ends.into_iter().find(|node| !path.contains(node)) else { break };
        path.push(next);
    }
    path.reverse();
    path
}

/// [m] Arc length from the apex to the corner of a vent: a flat or sloping triangle.
fn tip(p: &ParachuteParameters, corner: f64) -> f64 {
    let centre = corner * (PI / p.gores as f64).cos();
    let depth = match format!("{:?}", p.kind).as_str() {
        "Conical" => centre * p.cone_angle.expect("an angle").tan(),
        "Biconical" | "Triconical" => centre * p.cone_angles.as_ref().expect("angles")[0].tan(),
        "Ribbon" => centre * p.cone_angle.unwrap_or(0.0).tan(),
        "Hemispherical" | "Ringsail" | "Elliptical" => {
            let skirt = 0.5 * p.sizes().expect("sizes").constructed_diameter;
            let radius = if format!("{:?}", p.kind) == "Ringsail" { skirt / (PI / 3.0).sin() } else { skirt };
            p.height_ratio.unwrap_or(1.0) * (radius - (radius * radius - centre * centre).sqrt())
        }
        _ => 0.0,
    };
    corner.hypot(depth)
}

/// The skirt has the radius that is asked for; a shorter reefing line is taut around it.
#[test]
fn the_skirt_has_its_start_radius() {
    for (kind, vent) in [("flat-circular", json!(0.85)), ("cruciform", json!(null)), ("conical", json!(0.85))] {
        let skirt = |more: Value| {
            let mut all = json!({"vent_diameter": vent, "start": "stretched"});
            if kind == "conical" {
                all["cone_angle"] = json!(0.4);
            }
            more.as_object().expect("an object").iter().for_each(|(key, value)| all[key] = value.clone());
            let start = Start::of(&parameters(kind, all));
            let ring =
                start.mesh.groups.get("reefing").map(|ring| ring.edges.iter().map(|&edge| start.length(edge)).sum());
            let corner = start.mesh.edges[group(&start.mesh, "lines").edges[0] as usize][0];
            (start.radius(corner), ring)
        };
        close(skirt(json!({})).0, 0.025 * 8.534, 1e-12, kind);
        close(skirt(json!({"start_radius": 0.1})).0, 0.8534, 1e-12, kind);
        let wide = skirt(json!({"reefing": {"diameter": 2.0}}));
        close(wide.0, 0.025 * 8.534, 1e-12, kind);
        assert!(wide.1.is_some_and(|ring: f64| ring < 2.0 * PI), "{kind}");
        let reefed = skirt(json!({"start_radius": 0.2, "reefing": {"diameter": 1.0}}));
        close(reefed.1.expect("a ring"), PI, 1e-12, kind);
    }
}

/// All lines of a cross are as long as they are told, in springs and in masses; so are inner lines of their own length.
#[test]
fn lines_are_as_long_as_told() {
    let parachute = "system.network.mesh.parachute";
    let cross = json!({"type": "cruciform", "nominal_diameter": 6.4, "gores": 16, "radial_segments": 8,
        "arm_ratio": 0.33, "lines": {"length": 5.6, "segments": 2}, "riser": {"length": 1.0}});
    let ring = json!({"type": "annular", "nominal_diameter": 8.534, "gores": 28, "radial_segments": 6,
        "vent_diameter": 4.0, "lines": {"length": 7.68}, "inner_lines": {"length": 6.6, "segments": 3}});
    for (of, name, count, told) in [(&cross, "lines", 32, 2.8), (&ring, "inner-lines", 84, 2.2)] {
        for start in ["flat", "stretched"] {
            let mut mesh = of.clone();
            mesh["start"] = json!(start);
            let rule = json!([{"on": {"group": name}, "axial_rigidity": 9000, "linear_density": 0.5},
                {"on": {"group": "cloth"}, "membrane": {"modulus": 4e8, "thickness": 1e-4}, "slack": "tension-only"}]);
            let sets = [
                (parachute, mesh.to_string()),
                ("system.network.springs", rule.to_string()),
                ("system.network.mass.areal_density", "0".to_owned()),
                ("system.network.mass.nodal", "1".to_owned()),
            ];
            let sets: Vec<(&str, &str)> = sets.iter().map(|(key, value)| (*key, value.as_str())).collect();
            let case = case_with(&sets).unwrap_or_else(|e| panic!("{e}"));
            let SystemSpec::Network(spec) = &case.problem().system else { panic!("a network") };
            assert_eq!(spec.springs[0].rest_length.len(), count);
            spec.springs[0].rest_length.iter().for_each(|&rest| close(rest, told, 1e-14, name));
            let nodes = spec.mesh.nodes.len() as f64;
            let expected = nodes + 90.7 + 0.5 * told * count as f64;
            close(spec.mass.iter().sum(), expected, 1e-12, "mass");
        }
    }
}

/// A drop of 90.7 kg at a speed [m/s] with such a canopy and a law of its air.
pub(super) fn drop_of(p: &ParachuteParameters, mesh: &Mesh, law: &Value, speed: f64, time: &Value) -> Value {
    let tape = |name: &str| {
        json!({"on": {"group": name}, "axial_rigidity": 8000, "linear_density": 0.006, "slack": "tension-only",
            "dashpot": {"axial": {"time": 1e-3}}})
    };
    let mut springs = vec![json!({"on": {"group": "cloth"}, "slack": "tension-only",
        "membrane": {"modulus": 4.309e8, "thickness": 1e-4}, "dashpot": {"axial": {"time": 1e-3}}})];
    let tapes = [
        "radials",
        "skirt",
        "vent",
        "verticals",
        "vent-lines",
        "lines",
        "inner-lines",
        "centre-line",
        "riser",
        "reefing",
    ];
    springs.extend(tapes.into_iter().filter(|name| mesh.groups.contains_key(*name)).map(tape));
    let mut canopy = json!({"on": {"group": "canopy"}});
    law.as_object().expect("an object").iter().for_each(|(key, value)| canopy[key] = value.clone());
    json!({
        "name": "stretch",
        "system": {"network": {
            "mesh": {"parachute": p},
            "mass": {"areal_density": 0.0534, "points": [{"on": {"group": "payload"}, "mass": 90.7}]},
            "springs": springs,
            "gravity": [0, 0, -9.81],
            "aero": {"canopy": canopy},
            "initial": {"velocity": [0, 0, -speed]}
        }},
        "time": time
    })
}

/// An annular canopy stays open on inner lines as long as its lines: both ends of its meridian are as far from the
/// confluence, so the pressure between them points away from it. Shorter inner lines turn this force to the axis.
#[test]
fn an_annular_canopy_stays_open() {
    let more = json!({"vent_diameter": 3.4, "gores": 12, "radial_segments": 6, "gore_segments": 1, "inner_lines": {},
        "lines": {"length": 8.534}});
    let p = parameters("annular", more);
    let mesh = built(&p);
    let time = json!({"end": 2.0, "method": "newmark", "step": 0.002});
    let law = json!({"table": {"pressure_coefficient": 1.7}});
    let case = crate::common::run::case_of(&drop_of(&p, &mesh, &law, 6.0, &time), &[]);
    let mut simulation = Simulation::from_case(case.problem(), 1).expect("a scene");
    simulation.run_until(2.0).expect("it runs");
    let at = |node: u32| Vector::from(simulation.positions()[node as usize]);
    let diameter = |name: &str| {
        let nodes = group(&mesh, name).select_nodes(&mesh);
        let middle = nodes.iter().map(|&node| at(node)).sum::<Vector>() / nodes.len() as f64;
        nodes.iter().map(|&node| 2.0 * (at(node) - middle).norm()).sum::<f64>() / nodes.len() as f64
    };
    let (skirt, vent) = (diameter("skirt") / 8.534, diameter("vent") / 8.534);
    assert!((0.7..0.9).contains(&skirt) && (0.3..0.45).contains(&vent), "{skirt} and {vent} of D0");
}

/// Starts that cannot be are refused at their place with words that help.
#[test]
fn bad_stretched_starts_are_refused() {
    let rows = [
        ("start_radius", "0", "/start_radius", "above 0"),
        ("start_radius", "-0.1", "/start_radius", "above 0"),
        ("start_radius", "0.6", "/start_radius", "the radius of the skirt as it is cut"),
        ("start", "flat", "/start_radius", "only with the start \"stretched\""),
        ("lines", "null", "/start", "a stretched start needs lines"),
        ("inner_lines", r#"{"length": 0}"#, "/inner_lines/length", "above 0"),
    ];
    let key = |name: &str| format!("system.network.mesh.parachute.{name}");
    for (name, value, at, words) in rows {
        let (start, radius, of) = (key("start"), key("start_radius"), key(name));
        let sets = [(start.as_str(), "stretched"), (radius.as_str(), "0.025"), (of.as_str(), value)];
        let error = case_with(&sets).err().unwrap_or_else(|| panic!("{name} = {value} passes"));
        let hit = error.faults().iter().find(|f| f.pointer.ends_with(at));
        let hit = hit.unwrap_or_else(|| panic!("{name} = {value}: no fault at {at}, but {error}"));
        assert!(hit.to_string().contains(words), "{name} = {value}: \"{words}\" is not in\n{hit}");
    }
    let long = case_with(&[(&key("inner_lines"), r#"{"length": 6600}"#)]).unwrap_or_else(|e| panic!("{e}"));
    assert!(long.warnings().iter().any(|warning| warning.to_string().contains("6600 mm are 6.6 m")));
    // A cross is as wide as the ends of its four arms: 4 W around.
    let cross = |radius: f64| {
        parameters("cruciform", json!({"vent_diameter": null, "start": "stretched", "start_radius": radius})).build()
    };
    let ratio = 1.0 / 3.0;
    let width = ratio * (0.25 * PI / (ratio * (2.0 - ratio))).sqrt();
    assert!(cross(2.0 * width / PI - 1e-6).is_ok() && cross(2.0 * width / PI + 1e-6).is_err());
}

/// Every type opens from line stretch by each law of the air, by backward Euler: 20 steps, finite and under tension.
#[test]
fn every_type_flies_from_line_stretch() {
    let laws = [
        json!({"schedule": {"drag_coefficient": 0.75, "filling_constant": 8, "exponent": 2}}),
        json!({"cavity": {"inflow": 0.5, "outer_pressure_coefficient": -0.6}}),
    ];
    let all = stretched_types();
    for (p, law) in all.iter().flat_map(|p| laws.iter().map(move |law| (p, law))) {
        if p.cluster.is_some() {
            continue;
        }
        // Coarser, for the time of the test.
        let p =
            ParachuteParameters { gores: 12, radial_segments: 6, gore_segments: p.gore_segments.min(2), ..p.clone() };
        let mesh = built(&p);
        let time = json!({"end": 0.02, "method": "backward-euler", "step": 0.001});
        let case = crate::common::run::case_of(&drop_of(&p, &mesh, law, 45.0, &time), &[]);
        let mut simulation = Simulation::from_case(case.problem(), 1).expect("a scene");
        simulation.run_until(0.02).unwrap_or_else(|error| panic!("{law} {p:?}: {error}"));
        assert!(simulation.positions().iter().all(|x| x.iter().all(|c| c.is_finite())), "{law} {p:?}");
        let [payload] = group(&mesh, "payload").nodes[..] else { panic!("a point") };
        let fallen = simulation.positions()[payload as usize][2] - mesh.nodes[payload as usize][2];
        assert!((fallen + 0.9).abs() < 0.05, "{law} {p:?}: it fell {fallen} m in 0.02 s at 45 m/s");
    }
}
