//! Parachutes: areas and lengths of the pattern, groups, Taylor's shape as a start, and what is refused.

mod coarsened;
mod forms;
mod packed;
mod refused;
mod stretched;
mod strip_out;

use canopy_fem::case::Case;
use canopy_fem::mesh::canopy::{Canopy, CanopyError};
use canopy_fem::mesh::parachute::{ParachuteParameters, ParachuteSizes};
use canopy_fem::mesh::read::mesh_from_bytes;
use canopy_fem::mesh::write::vtu_text;
use canopy_fem::mesh::{Group, Mesh, Topology};
use canopy_fem::simulation::Simulation;
use serde_json::{Value, json};
use std::f64::consts::PI;
use std::path::{Path, PathBuf};

type Vector = nalgebra::Vector3<f64>;

/// A small canopy of some type with lines, riser and vent, with other keys replaced.
fn parameters(kind: &str, more: Value) -> ParachuteParameters {
    let mut json = json!({
        "type": kind, "nominal_diameter": 8.534, "gores": 28, "vent_diameter": 0.85,
        "radial_segments": 12, "gore_segments": 2,
        "lines": {"length": 7.68, "segments": 6}, "riser": {"length": 1.0}
    });
    for (key, value) in more.as_object().expect("an object") {
        json[key] = value.clone();
    }
    json.as_object_mut().expect("an object").retain(|_, value| !value.is_null());
    serde_json::from_value(json).expect("parameters")
}

/// Every type, with what it needs.
fn types() -> Vec<ParachuteParameters> {
    vec![
        parameters("flat-circular", json!({})),
        parameters("flat-circular", json!({"vent_diameter": null, "gores": 7, "gore_segments": 3})),
        parameters("conical", json!({"cone_angle": 0.4})),
        parameters("biconical", json!({"cone_angles": [0.3, 0.7], "cone_breaks": [0.6]})),
        parameters("triconical", json!({"cone_angles": [0.2, 0.5, 0.9]})),
        parameters("hemispherical", json!({})),
        parameters("extended-skirt", json!({})),
        parameters("extended-skirt", json!({"skirt_extension": 0.143, "skirt_angle": 1.4})),
        parameters("extended-skirt", json!({"skirt_angle": 2.9})),
        parameters("annular", json!({"vent_diameter": 4.0, "gores": 27, "inner_lines": {"segments": 3}})),
        parameters("cruciform", json!({"vent_diameter": null, "gore_segments": 3})),
        parameters("ringslot", json!({"rings": 4, "slot_porosity": 0.15})),
        parameters("disk-gap-band", json!({"lines": {"length": 14.5, "segments": 3}})),
        parameters("ribbon", json!({"rings": 6, "slot_porosity": 0.2, "verticals": 1})),
        parameters("ribbon", json!({"rings": 5, "slot_porosity": 0.2, "cone_angle": 0.35})),
        parameters("ringsail", json!({"rings": 6, "sails": 4, "slot_porosity": 0.08, "fullness": 0.1})),
        parameters("elliptical", json!({"height_ratio": 0.7})),
        parameters(
            "elliptical",
            json!({"height_ratio": 0.7, "vent_diameter": null, "centre_line": {"length": 7.0, "segments": 2}}),
        ),
        parameters("toroidal", json!({"vent_diameter": 1.2, "inner_lines": {"segments": 3}})),
        parameters(
            "toroidal",
            json!({"vent_diameter": 1.2, "height_ratio": 0.5, "pull_down": 1.3, "inner_lines": {"length": 9.0}}),
        ),
        parameters("square", json!({"inner_lines": {"length": 7.0}, "corner_cut": 0.1})),
        parameters("square", json!({"vent_diameter": null, "centre_line": {"length": 7.0}})),
        parameters("triangular", json!({"gores": 27, "vent_diameter": null, "corner_cut": 0.15})),
    ]
}

/// Whether a canopy's skirt is a circle.
fn is_round(p: &ParachuteParameters) -> bool {
    !["Square", "Triangular"].contains(&format!("{:?}", p.kind).as_str())
}

fn built(p: &ParachuteParameters) -> Mesh {
    let mut faults = Vec::new();
    p.check("", &mut |at, value, allowed, hint| faults.push(format!("{at}: {value}; {allowed}; {hint}")));
    assert!(faults.is_empty(), "{faults:?}");
    let mesh = p.build().unwrap_or_else(|error| panic!("{:?}: {error}", p.kind));
    mesh.check().unwrap_or_else(|error| panic!("{:?}: {error}", p.kind));
    mesh
}

/// The canopy of a mesh with one.
fn sole_canopy(mesh: &Mesh) -> Result<Canopy, CanopyError> {
    let mut found = Canopy::of_groups(mesh);
    assert_eq!(found.len(), 1);
    found.pop_first().expect("one").1
}

fn point(mesh: &Mesh, node: u32) -> Vector {
    Vector::from(mesh.nodes[node as usize])
}

fn length(mesh: &Mesh, edge: u32) -> f64 {
    let [a, b] = mesh.edges[edge as usize];
    (point(mesh, a) - point(mesh, b)).norm()
}

fn group<'a>(mesh: &'a Mesh, name: &str) -> &'a Group {
    mesh.groups.get(name).unwrap_or_else(|| panic!("no group {name} among {:?}", mesh.groups.keys()))
}

/// Half the cross product of two sides: the normal times the area.
fn area_vector(points: [Vector; 3]) -> Vector {
    0.5 * (points[1] - points[0]).cross(&(points[2] - points[0]))
}

fn cloth_area(mesh: &Mesh) -> f64 {
    mesh.triangles.iter().map(|t| area_vector(t.map(|node| point(mesh, node))).norm()).sum()
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found} instead of {expected}");
}

/// Cloth, gaps and vent make the area of the nominal diameter, and the triangles have the area of the cloth.
#[test]
fn every_pattern_has_its_nominal_area() {
    for p in types() {
        let (mesh, sizes) = (built(&p), p.sizes().expect("sizes"));
        let nominal = 0.25 * PI * p.nominal_diameter.expect("D0").powi(2);
        close(sizes.nominal_area, nominal, 1e-12, "S0");
        close(cloth_area(&mesh), sizes.cloth_area, 1e-12, "cloth");
        close((4.0 * sizes.nominal_area / PI).sqrt(), p.nominal_diameter.expect("D0"), 1e-12, "D0");
    }
}

/// The closed forms: n h^2 tan(pi/n) and its relatives, and the ratios of constructed and nominal diameter.
#[test]
fn patterns_have_the_closed_forms() {
    let (n, d0) = (28.0, 8.534);
    let tangent = (PI / n).tan();
    let sizes = |kind, more| -> ParachuteSizes { parameters(kind, more).sizes().expect("sizes") };
    let flat = sizes("flat-circular", json!({}));
    close(n * flat.gore_length.powi(2) * tangent, 0.25 * PI * d0 * d0, 1e-12, "flat circular");
    let cone = sizes("conical", json!({"cone_angle": 0.4}));
    close(n * cone.gore_length.powi(2) * 0.4_f64.cos() * tangent, 0.25 * PI * d0 * d0, 1e-12, "conical");
    // The disc and 40 % of its area, for a cylinder of a tenth of its diameter.
    let extended = sizes("extended-skirt", json!({}));
    let radius = 0.5 * extended.constructed_diameter;
    close(n * tangent * radius * radius * 1.4, 0.25 * PI * d0 * d0, 1e-12, "extended skirt");
    // Disc and cone: r^2 + 2 r e (r + r'), with r' = r (1 + 2 e cos(angle)) at the skirt. Knacke (1991, table 5-1) has
    // constructed diameters of 0.81 to 0.85 D0 for a full one of 14.3 %.
    for (e, angle) in [(0.143, 1.4_f64), (0.1, 2.9)] {
        let skirt = sizes("extended-skirt", json!({"skirt_extension": e, "skirt_angle": angle}));
        let grown = 1.0 + 2.0 * e * angle.cos();
        let radius = 0.5 * skirt.constructed_diameter / grown.max(1.0);
        close(n * tangent * radius * radius * (1.0 + 2.0 * e * (1.0 + grown)), 0.25 * PI * d0 * d0, 1e-12, "cone");
        close(skirt.gore_length, radius * (1.0 + 2.0 * e), 1e-12, "gore");
        assert!((0.81..0.87).contains(&(skirt.constructed_diameter / d0)), "{}", skirt.constructed_diameter / d0);
    }
    let many = json!({"radial_segments": 200, "gores": 200, "gore_segments": 1});
    close(sizes("hemispherical", many).constructed_diameter / d0, 0.5_f64.sqrt(), 1e-4, "hemispherical");
    let slots = parameters("ringslot", json!({"rings": 4, "slot_porosity": 0.15}));
    let ring = slots.sizes().expect("sizes");
    let vent = 0.5 * n * 0.425_f64.powi(2) * (2.0 * PI / n).sin();
    close(ring.cloth_area + vent, 0.85 * ring.nominal_area, 1e-12, "ringslot");
    let cross = parameters("cruciform", json!({"vent_diameter": null, "arm_ratio": 0.264}));
    let l = cross.sizes().expect("sizes").constructed_diameter;
    close(l * l * 0.264 * (2.0 - 0.264), 0.25 * PI * d0 * d0, 1e-12, "cruciform");
    close(l / d0, (0.25 * PI / (0.264 * (2.0 - 0.264))).sqrt(), 1e-12, "cruciform length");
}

/// Vent lines are as long as the vent is wide; lines are straight, as long as asked for, and meet.
#[test]
fn lines_have_their_lengths() {
    for p in types() {
        let mesh = built(&p);
        let lines = p.lines.as_ref().expect("lines");
        let of = group(&mesh, "lines").edges.iter().map(|&edge| length(&mesh, edge)).collect::<Vec<_>>();
        assert_eq!(of.len(), p.gores * lines.segments, "{:?}", p.kind);
        let longest = of.iter().copied().fold(0.0, f64::max) * lines.segments as f64;
        let told = lines.length.expect("a length");
        close(longest, told, 1e-12, "lines");
        // The flat mesh shows lines from the middle of sides shorter.
        close(of.iter().sum(), told * p.gores as f64, if is_round(&p) { 0.05 } else { 0.25 }, "all lines");
        if mesh.groups.contains_key("vent-lines") {
            let vent = &group(&mesh, "vent-lines").edges;
            assert_eq!(vent.len(), p.gores / 2);
            vent.iter()
                .for_each(|&edge| close(length(&mesh, edge), p.vent_diameter.expect("a vent"), 1e-14, "vent line"));
        }
        let confluence = group(&mesh, "confluence").nodes[0];
        let ends = group(&mesh, "lines").edges.iter().filter(|&&edge| mesh.edges[edge as usize].contains(&confluence));
        assert_eq!(ends.count(), p.gores, "{:?}", p.kind);
        let payload = point(&mesh, group(&mesh, "payload").nodes[0]);
        close((point(&mesh, confluence) - payload).norm(), 1.0, 1e-12, "riser");
    }
}

/// Inner lines lead straight from the vent's corners to the confluence, and change nothing else.
#[test]
fn inner_lines_join_vent_and_confluence() {
    let given = |more| built(&parameters("annular", more));
    let mesh = given(json!({"vent_diameter": 4.0, "inner_lines": {"segments": 3}}));
    let edges = &group(&mesh, "inner-lines").edges;
    let depth = (7.68_f64.powi(2) - point(&mesh, group(&mesh, "skirt").nodes[0]).xy().norm_squared()).sqrt();
    assert_eq!(edges.len(), 3 * 28);
    let total: f64 = edges.iter().map(|&edge| length(&mesh, edge)).sum();
    close(total / 28.0, depth.hypot(2.0), 1e-12, "inner line");
    let ends = |name: &str| {
        group(&mesh, "inner-lines")
            .edges
            .iter()
            .flat_map(|&e| mesh.edges[e as usize])
            .filter(|n| group(&mesh, name).nodes.contains(n))
            .count()
    };
    assert_eq!((ends("vent"), ends("confluence")), (28, 28));
    let without = given(json!({"vent_diameter": 4.0}));
    assert_eq!((mesh.triangles.len(), group(&mesh, "cloth")), (without.triangles.len(), group(&without, "cloth")));
    assert_eq!(mesh.nodes.len(), without.nodes.len() + 2 * 28);
    assert!(sole_canopy(&mesh).is_ok());
}

/// What the mesh shows is what the pattern says: cloth, gaps and flat vents are S0. The pattern of a sloping canopy
/// counts the cloth that the vent cuts away, which is a little more than the vent.
#[test]
fn a_mesh_shows_the_nominal_area() {
    for p in types() {
        let (mesh, sizes) = (built(&p), p.sizes().expect("sizes"));
        let canopy = sole_canopy(&mesh).unwrap_or_else(|e| panic!("{:?}: {e}", p.kind));
        close(canopy.cloth_area, sizes.cloth_area, 1e-12, "cloth");
        let kind = format!("{:?}", p.kind);
        let sloping = ["Conical", "Biconical", "Triconical", "Hemispherical", "Ribbon", "Ringsail", "Elliptical"];
        let slope = sloping.contains(&kind.as_str());
        close(canopy.nominal_area, sizes.nominal_area, if slope { 1e-3 } else { 1e-12 }, &kind);
    }
    let cluster = built(&parameters(
        "ringslot",
        json!({"rings": 3, "slot_porosity": 0.1, "cluster": {"canopies": 3}, "lines": {"length": 12}, "riser": {"length": 8}}),
    ));
    let found = Canopy::of_groups(&cluster);
    assert_eq!(found.keys().collect::<Vec<_>>(), ["canopy-1", "canopy-2", "canopy-3"]);
    for canopy in found.values() {
        close(canopy.as_ref().expect("sound").nominal_diameter(), 8.534, 1e-12, "D0");
    }
}

/// Groups have the members that the counts of gores, rows and segments give.
#[test]
fn groups_are_complete() {
    let mesh = built(&parameters("flat-circular", json!({"reefing": {"diameter": 2.0}})));
    let (n, rows, across) = (28, 12, 2);
    let expected = [
        ("canopy", 2 * n * rows * across),
        ("cloth", n * across * (3 * rows + 1)),
        ("radials", n * rows),
        ("skirt", n * across),
        ("vent", n * across),
        ("vent-lines", n / 2),
        ("lines", 6 * n),
        ("riser", 1),
        ("reefing", n),
    ];
    for (name, count) in expected {
        let Group { edges, triangles, .. } = group(&mesh, name);
        assert_eq!(edges.len() + triangles.len(), count, "{name}");
    }
    for (name, count) in [("skirt", n * across), ("vent", n * across), ("confluence", 1), ("payload", 1)] {
        assert_eq!(group(&mesh, name).nodes.len(), count, "{name}");
    }
    let cloth = &group(&mesh, "cloth").edges;
    for name in ["radials", "skirt", "vent"] {
        assert!(group(&mesh, name).edges.iter().all(|edge| cloth.binary_search(edge).is_ok()), "{name}");
    }
    // One across a gore: the reefing line is on the edges of the skirt.
    let coarse = built(&parameters("flat-circular", json!({"reefing": {"diameter": 2.0}, "gore_segments": 1})));
    assert_eq!(group(&coarse, "reefing").edges, group(&coarse, "skirt").edges);
}

/// The canopy is one sheet with its loops closed, turned the same way, its normals outwards; the rig hangs on it.
#[test]
fn canopies_are_sound_surfaces() {
    for p in types() {
        let (mesh, kind) = (built(&p), p.kind);
        let topology = Topology::new(&mesh).expect("sound");
        assert_eq!(topology.components(), 1, "{kind:?}");
        assert!(topology.check_manifold().is_ok() && topology.check_orientation(&mesh).is_ok(), "{kind:?}");
        assert!(topology.loops().iter().all(|l| l.closed), "{kind:?}");
        let canopy = sole_canopy(&mesh).unwrap_or_else(|e| panic!("{kind:?}: {e}"));
        let axis = canopy.axis(&|node| point(&mesh, node)).expect("an axis").normalize();
        assert!((axis + Vector::z()).norm() < if is_round(&p) { 1e-15 } else { 1e-13 }, "{kind:?}: {axis:?}");
        let bands = 1 + mesh.groups.get("rims").map_or(0, |_| topology.loops().len() / 2 - 1);
        let loops = topology.loops().len();
        assert_eq!(loops, bands + bands - usize::from(p.vent_diameter.is_none()), "{kind:?}");
        // Nodes, edges and triangles of the canopy alone: 2 for a sphere less one for each loop, per band; then each
        // line joins two parts by one edge.
        let vent_lines = mesh.groups.get("vent-lines").map_or(0, |g| g.edges.len());
        let over_gaps = (bands - 1) * p.gores * (1 + p.verticals.unwrap_or(0));
        let canopy_only = 2 * bands as i64 - loops as i64;
        let inner_lines = p.inner_lines.as_ref().map_or(0, |_| p.gores);
        let centre_line = usize::from(p.centre_line.is_some());
        let rig = 1 - (p.gores + vent_lines + over_gaps + inner_lines + centre_line) as i64;
        assert_eq!(topology.euler_characteristic(), canopy_only + rig, "{kind:?}");
        if format!("{kind:?}") == "Toroidal" {
            // The inside is a ring.
            continue;
        }
        // Inside the canopy; one whose skirt is drawn in is a flat bag.
        let bag = p.skirt_angle.is_some_and(|angle| angle > 0.5 * PI);
        let top = mesh.nodes.iter().map(|x| x[2]).fold(0.0, f64::max);
        let centre = Vector::new(0.0, 0.0, if bag { 0.5 * top } else { -1.0 });
        for t in &mesh.triangles {
            let corners = t.map(|node| point(&mesh, node));
            let outwards = corners.iter().sum::<Vector>() / 3.0 - centre;
            assert!(area_vector(corners).dot(&outwards) > 0.0, "{kind:?}");
        }
    }
}

/// Lines of these lengths over D0, where D0 is twice the radials' length; then Dp, Ds, depth over Dp, half cone angle
/// and volume over R^3 (G. I. Taylor 1919, evaluated with elliptic integrals).
const TAYLOR: [[f64; 6]; 6] = [
    [0.8, 0.659242, 0.631880, 0.399632, 23.2613, 1.984887],
    [0.9, 0.668202, 0.645591, 0.390212, 21.0180, 1.930066],
    [1.0, 0.675720, 0.656719, 0.382394, 19.1692, 1.883940],
    [1.2, 0.687634, 0.673670, 0.370184, 16.3017, 1.810874],
    [1.5, 0.700401, 0.690923, 0.357372, 13.3152, 1.733054],
    [2.0, 0.714136, 0.708468, 0.343931, 10.2019, 1.650388],
];

/// An inflated start has Taylor's shape, without stretching anything.
#[test]
fn an_inflated_start_has_taylors_shape() {
    let n = 32.0;
    for [ratio, largest, skirt, depth, cone, volume] in TAYLOR {
        let more = json!({"gores": 32, "vent_diameter": null, "radial_segments": 120, "gore_segments": 1, "start": "inflated"});
        let mut p = parameters("flat-circular", more);
        let radial = p.sizes().expect("sizes").gore_length / (PI / n).cos();
        let lines = p.lines.as_mut().expect("lines");
        lines.length = Some(ratio * 2.0 * radial);
        let mesh = built(&p);
        let at = |node: u32| point(&mesh, node) + Vector::from(mesh.displacement[node as usize]);
        let radius = |node: u32| at(node).xy().norm() / (2.0 * radial);
        let canopy = group(&mesh, "canopy").select_nodes(&mesh);
        let skirt_node = group(&mesh, "skirt").nodes[0];
        let apex = group(&mesh, "apex").nodes[0];
        close(radius(skirt_node), 0.5 * skirt, 2e-6, "Ds/D0");
        let widest = canopy.iter().map(|node| radius(*node)).fold(0.0, f64::max);
        close(widest, 0.5 * largest, 1e-4, "Dp/D0");
        close((at(apex).z - at(skirt_node).z) / (2.0 * radial), depth * largest, 5e-6, "depth");
        let confluence = at(group(&mesh, "confluence").nodes[0]);
        let line = at(skirt_node) - confluence;
        close((line.xy().norm() / line.z).atan().to_degrees(), cone, 5e-6, "half cone angle");
        close(line.norm(), ratio * 2.0 * radial, 1e-12, "lines");
        // Volume under the mouth's plane, of a body of n flat gores.
        let base = Vector::new(0.0, 0.0, at(skirt_node).z);
        let parts = mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.map(|node| at(node) - base);
            a.dot(&b.cross(&c)) / 6.0
        });
        let gores = n / (2.0 * PI) * (2.0 * PI / n).sin();
        close(parts.sum::<f64>() / (largest * radial).powi(3), gores * volume, 3e-4, "volume");
        for (edge, &[a, b]) in (0..).zip(&mesh.edges) {
            assert!((at(a) - at(b)).norm() < length(&mesh, edge) * (1.0 + 1e-12), "{ratio}: edge {edge} is stretched");
        }
    }
}

/// The skirt of a reefed start is as wide as its reefing line lets it be; an extended skirt and slots inflate too;
/// other patterns are refused with the stretch.
#[test]
fn inflated_starts_of_other_canopies() {
    let reefed = json!({"start": "inflated", "reefing": {"diameter": 2.0}});
    let mesh = built(&parameters("flat-circular", reefed));
    let at = |node: u32| point(&mesh, node) + Vector::from(mesh.displacement[node as usize]);
    let ring = group(&mesh, "reefing").edges.iter().map(|&edge| mesh.edges[edge as usize]);
    close(ring.map(|[a, b]| (at(a) - at(b)).norm()).sum(), 2.0 * PI, 1e-10, "reefing line");
    for p in
        [parameters("extended-skirt", json!({})), parameters("ringslot", json!({"rings": 3, "slot_porosity": 0.1}))]
    {
        let inflated = ParachuteParameters { start: canopy_fem::mesh::parachute::StartShape::Inflated.into(), ..p };
        assert!(!built(&inflated).displacement.is_empty());
    }
    let cone = parameters("conical", json!({"cone_angle": 0.4, "start": "inflated"})).build();
    let ring = parameters("annular", json!({"vent_diameter": 4.0, "start": "inflated"})).build();
    assert!(ring.expect_err("open").to_string().contains("closed at its apex"));
    let words = cone.expect_err("too narrow").to_string();
    assert!(words.contains("/parachute/start") && words.contains("stretches the gores by"), "{words}");
}

/// A turned and placed rig has the same lengths, its payload at its place and its apex in the given direction.
#[test]
fn a_rig_is_turned_and_placed() {
    let place = Vector::new(5.0, -3.0, 200.0);
    for (more, axis) in [
        (json!({"start": "inflated"}), [0.0, 0.0, 1.0]),
        (json!({"start": "inflated"}), [-3.0, 4.0, 0.0]),
        (json!({"payload": {"box": [1.2, 0.8, 2.0], "below_riser": 2.5}}), [1.0, 2.0, -0.5]),
        (json!({"cluster": {"canopies": 3}}), [0.0, 0.0, -2.0]),
    ] {
        let p = parameters("flat-circular", more);
        let (plain, turned) =
            (built(&p), built(&ParachuteParameters { axis: Some(axis), at: Some(place.into()), ..p }));
        let at = |mesh: &Mesh, node: u32| {
            let moved = mesh.displacement.get(node as usize).map_or(Vector::zeros(), |u| Vector::from(*u));
            point(mesh, node) + moved
        };
        for pair in &plain.edges {
            let [before, after] = [&plain, &turned].map(|mesh| (at(mesh, pair[0]) - at(mesh, pair[1])).norm());
            close(after, before, 1e-10, "edge");
        }
        let payload = &group(&turned, "payload").nodes;
        let middle = payload.iter().map(|&node| point(&turned, node)).sum::<Vector>() / payload.len() as f64;
        assert!((middle - place).norm() < 1e-9, "{middle:?}");
        let canopy = &group(&turned, "vent").nodes;
        let apex = canopy.iter().map(|&node| at(&turned, node)).sum::<Vector>() / canopy.len() as f64;
        close((apex - place).normalize().dot(&Vector::from(axis).normalize()), 1.0, 1e-10, "axis");
    }
    let unplaced = parameters("flat-circular", json!({"axis": [1, 0, 0]}));
    let (plain, turned) = (built(&parameters("flat-circular", json!({}))), built(&unplaced));
    let payload = group(&plain, "payload").nodes[0];
    assert_eq!(plain.nodes[payload as usize], turned.nodes[payload as usize], "it turns about its payload");
}

/// Four particles have the moments of inertia of the box they stand for.
#[test]
fn a_rigid_payload_is_equimomental() {
    let payload = json!({"box": [1.2, 0.8, 2.0], "below_riser": 2.5});
    let mesh = built(&parameters("flat-circular", json!({"payload": payload})));
    let particles: Vec<Vector> = group(&mesh, "payload").nodes.iter().map(|node| point(&mesh, *node)).collect();
    assert_eq!(
        (particles.len(), group(&mesh, "payload-bars").edges.len(), group(&mesh, "slings").edges.len()),
        (4, 6, 4)
    );
    let centre = particles.iter().sum::<Vector>() / 4.0;
    let second =
        particles.iter().map(|p| 0.25 * (p - centre) * (p - centre).transpose()).sum::<nalgebra::Matrix3<f64>>();
    for (i, side) in [1.2, 0.8, 2.0].into_iter().enumerate() {
        close(second[(i, i)], side * side / 12.0, 1e-12, "second moment");
        (0..i).for_each(|j| assert!(second[(i, j)].abs() < 1e-15));
    }
    let k = [0.6_f64, 0.7, 0.5];
    let mesh = built(&parameters("flat-circular", json!({"payload": {"radii_of_gyration": k, "below_riser": 2.5}})));
    let particles: Vec<Vector> = group(&mesh, "payload").nodes.iter().map(|node| point(&mesh, *node)).collect();
    let centre = particles.iter().sum::<Vector>() / 4.0;
    for (axis, k) in k.iter().enumerate() {
        let square = |p: &Vector| (p - centre).norm_squared() - (p - centre)[axis].powi(2);
        close(particles.iter().map(square).sum::<f64>() / 4.0, k * k, 1e-12, "radius of gyration");
    }
}

/// Parachutes of a cluster share the end of their risers and lean apart; each has groups of its own beside those of
/// all.
#[test]
fn clusters_share_their_payload() {
    for start in ["flat", "inflated"] {
        let cluster = json!({"start": start, "riser": {"length": 20.0, "segments": 2}, "cluster": {"canopies": 3}});
        let mesh = built(&parameters("flat-circular", cluster));
        assert_eq!(Topology::new(&mesh).expect("sound").components(), 1);
        assert_eq!(group(&mesh, "payload").nodes, [0]);
        let size = |name: &str| {
            [&group(&mesh, name).nodes, &group(&mesh, name).edges, &group(&mesh, name).triangles].map(Vec::len)
        };
        for name in ["canopy", "skirt", "lines", "riser", "confluence"] {
            let parts: [usize; 3] = (1..=3)
                .map(|i| size(&format!("{name}-{i}")))
                .fold([0; 3], |sum, part| std::array::from_fn(|k| sum[k] + part[k]));
            assert_eq!(size(name), parts, "{name}");
        }
        // From each node around the vent of a canopy to that of both others.
        assert_eq!(size("spacers"), [0, 3 * size("vent-1")[0], 0]);
        // Each stays within its third of the turn around the vertical.
        for number in 1..=3 {
            let lean = std::f64::consts::TAU * f64::from(number - 1) / 3.0;
            for node in group(&mesh, &format!("cloth-{number}")).select_nodes(&mesh) {
                let moved = mesh.displacement.get(node as usize).map_or(Vector::zeros(), |u| Vector::from(*u));
                let at = point(&mesh, node) + moved;
                let angle = (at.y.atan2(at.x) - lean + PI).rem_euclid(2.0 * PI) - PI;
                assert!(angle.abs() < PI / 3.0, "{start}: node {node} of {number} at {at:?}");
            }
        }
        let radials = group(&mesh, "radials-2").edges.iter().map(|&edge| length(&mesh, edge)).sum::<f64>();
        close(radials, group(&mesh, "radials-1").edges.iter().map(|&edge| length(&mesh, edge)).sum(), 1e-12, "radials");
    }
    let tight = parameters("flat-circular", json!({"cluster": {"canopies": 6}})).build();
    let words = tight.expect_err("no room").to_string();
    assert!(words.contains("/parachute/cluster/canopies") && words.contains("lengthen the riser"), "{words}");
}

/// Groups, seams and the start's displacement come back from a .vtu file.
#[test]
fn parachutes_come_back_from_files() {
    let inflated = parameters("flat-circular", json!({"start": "inflated", "reefing": {"diameter": 2.0}}));
    let cluster = parameters("flat-circular", json!({"riser": {"length": 20.0}, "cluster": {"canopies": 2}}));
    for mesh in types().iter().chain([&inflated, &cluster]).map(built) {
        let text = vtu_text(&mesh).expect("written");
        let back = mesh_from_bytes(Path::new("a.vtu"), text.as_bytes()).expect("read").mesh;
        // Files do not know the rows.
        assert!(back == Mesh { rows: Vec::new(), ..mesh }, "another mesh comes back");
    }
}

const CASE: &str = r#"{
  "name": "drop",
  "system": {"network": {
    "mesh": {"parachute": {
      "type": "flat-circular", "nominal_diameter": 8.534, "gores": 28, "vent_diameter": 0.85,
      "radial_segments": 4, "gore_segments": 2, "lines": {"length": 7.68, "segments": 2}, "riser": {"length": 1.0}
    }},
    "mass": {"areal_density": 0.0534, "points": [{"on": {"group": "payload"}, "mass": 90.7}]},
    "springs": [
      {"on": {"group": "cloth"}, "membrane": {"modulus": 4.309e8, "thickness": 1e-4}, "slack": "tension-only"},
      {"on": {"group": "radials"}, "axial_rigidity": 9000, "linear_density": 0.01},
      {"on": {"group": "skirt"}, "axial_rigidity": 9000, "linear_density": 0.01},
      {"on": {"group": "vent"}, "axial_rigidity": 9000, "linear_density": 0.01},
      {"on": {"group": "vent-lines"}, "axial_rigidity": 9000, "linear_density": 0.01, "slack": "tension-only"},
      {"on": {"group": "lines"}, "axial_rigidity": 9000, "linear_density": 0.01},
      {"on": {"group": "riser"}, "axial_rigidity": 40000, "linear_density": 0.1}
    ],
    "supports": [{"on": {"group": "payload"}, "fix": "xyz"}],
    "gravity": [0, 0, -9.81],
    "loads": [{"on": {"group": "canopy"}, "pressure": 20}]
  }},
  "time": {"end": 0.001, "method": "velocity-verlet", "step": 1e-5},
  "output": {"probes": [{"name": "skirt", "on": {"group": "skirt"}}]}
}"#;

fn case_with(sets: &[(&str, &str)]) -> Result<Case, canopy_fem::case::CaseError> {
    let sets: Vec<(String, String)> = sets.iter().map(|(k, v)| ((*k).to_owned(), (*v).to_owned())).collect();
    Case::from_text(CASE.to_owned(), "drop.json", PathBuf::new(), &sets)
}

/// Groups select in every place; rules for groups act together on the same edges, and so do their masses.
#[test]
fn groups_select_everywhere() {
    let case = case_with(&[]).unwrap_or_else(|e| panic!("{e}"));
    assert!(case.warnings().is_empty(), "{:?}", case.warnings());
    let canopy_fem::case::spec::SystemSpec::Network(spec) = &case.problem().system else { panic!("a network") };
    let mesh = &spec.mesh;
    for (i, name) in ["cloth", "radials", "skirt", "vent", "vent-lines", "lines", "riser"].into_iter().enumerate() {
        assert_eq!(spec.springs[i].edges, group(mesh, name).edges, "{name}");
    }
    assert_eq!(spec.pressures[0].triangles.len(), mesh.triangles.len());
    assert_eq!(case.problem().output.probes[0].nodes, group(mesh, "skirt").nodes);
    let payload = group(mesh, "payload").nodes[0] as usize;
    assert_eq!(spec.fixed.iter().position(|f| *f == [true; 3]), Some(payload));
    let tapes = ["radials", "skirt", "vent", "vent-lines", "lines", "riser"];
    let density = |name: &str| if name == "riser" { 0.1 } else { 0.01 };
    let of_tapes = |name: &&str| group(mesh, name).edges.iter().map(|&e| length(mesh, e)).sum::<f64>() * density(name);
    let total = 90.7 + 0.0534 * cloth_area(mesh) + tapes.iter().map(of_tapes).sum::<f64>();
    close(spec.mass.iter().sum(), total, 1e-12, "mass");
    // A rest length of 0 pulls with k l; a shared mass is divided.
    let pull = [
        (
            "system.network.springs.6",
            r#"{"on": {"group": "riser"}, "stiffness": 100, "rest_length": 0, "linear_density": 1}"#,
        ),
        ("system.network.mass.points.0", r#"{"on": {"group": "lines"}, "total": 12}"#),
    ];
    let case = case_with(&pull).unwrap_or_else(|e| panic!("{e}"));
    let canopy_fem::case::spec::SystemSpec::Network(spec) = &case.problem().system else { panic!("a network") };
    assert_eq!(spec.springs[6].rest_length, [0.0]);
    close(spec.mass.iter().sum(), total - 90.7 + 12.0 + 0.9, 1e-12, "mass");
}

/// Cloth that starts folded in a reefed shape is no doubtful strain; where it would carry compression, it is.
#[test]
fn folded_cloth_is_not_doubted() {
    let mesh = "system.network.mesh.parachute";
    let reefed = [
        (format!("{mesh}.start"), "inflated"),
        (format!("{mesh}.reefing"), r#"{"diameter": 1}"#),
        ("system.network.springs.2.slack".to_owned(), "tension-only"),
    ];
    let doubts = |count: usize| {
        let sets: Vec<(&str, &str)> = reefed.iter().take(count).map(|(key, value)| (key.as_str(), *value)).collect();
        let case = case_with(&sets).unwrap_or_else(|e| panic!("{e}"));
        case.warnings().iter().any(|warning| warning.to_string().contains("starts with a strain of"))
    };
    assert!(doubts(2) && !doubts(3));
}

/// Two rules for groups put two springs on one edge: their tensions add up, in every scheme's motion too. A mass of 3
/// kg on springs of 100 and 200 N/m, one without rest length, rests where 100 l + 200 (l - 1) is its weight.
#[test]
fn springs_of_several_groups_act_together() {
    let case = |method: &str| {
        json!({
            "name": "pair",
            "system": {"network": {
                "mesh": {"explicit": {
                    "nodes": [[0, 0, 0], [0, 0, -1]], "springs": [[0, 1]],
                    "groups": {"rope": {"edges": [0]}, "band": {"edges": [0]}, "top": {"nodes": [0]}}
                }},
                "mass": {"points": [{"on": {"ids": [1]}, "mass": 3}]},
                "springs": [
                    {"on": {"group": "rope"}, "stiffness": 200, "dashpot": {"axial": {"coefficient": 40}}},
                    {"on": {"group": "band"}, "stiffness": 100, "rest_length": 0}
                ],
                "supports": [{"on": {"group": "top"}, "fix": "xyz"}],
                "gravity": [0, 0, -9.81]
            }},
            "time": {"end": 6.0, "method": method, "step": 0.002}
        })
    };
    let rest = (3.0 * 9.81 + 200.0) / 300.0;
    for method in ["velocity-verlet", "newmark", "kang", "rk4"] {
        let case = crate::common::run::case_of(&case(method), &[]);
        let mut simulation = Simulation::from_case(case.problem(), 1).expect("a scene");
        simulation.run_until(6.0).expect("it runs");
        // Kang's scheme rests beside the equilibrium, with one spring of 300 N/m in their place as well.
        let kang = if method == "kang" { 100.0 } else { 1.0 };
        assert!((simulation.positions()[1][2] + rest).abs() < 1e-6 * kang, "{method}: {:?}", simulation.positions());
        assert!((simulation.tensions()[0] - 3.0 * 9.81).abs() < 3e-4 * kang, "{method}: {:?}", simulation.tensions());
    }
}
