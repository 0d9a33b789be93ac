//! Sewing: gores of a drawing become the canopy of their pattern, pieces with seam allowances the same as without, and
//! what does not fit is refused with names and lengths.

use crate::common::gores::{Polyline, dxf, gore, moved, side_by_side};
use canopy_fem::mesh::parachute::ParachuteParameters;
use canopy_fem::mesh::read::{Imported, file_from_bytes};
use canopy_fem::mesh::{Group, Mesh, MeshError, MeshFile, Topology, canopy::Canopy};
use serde_json::{Value, json};
use std::path::Path;

/// A canopy without lines, one edge across each gore.
fn pattern(kind: &str, more: Value) -> Mesh {
    let mut json = json!({"type": kind, "nominal_diameter": 8.0, "gores": 12, "radial_segments": 12});
    for (key, value) in more.as_object().expect("an object") {
        json[key] = value.clone();
    }
    let p: ParachuteParameters = serde_json::from_value(json).expect("parameters");
    p.build().expect("a canopy")
}

fn sew(drawing: &[Polyline], edge: f64, seams: Value) -> Result<Imported, MeshError> {
    let sew = serde_json::from_value(seams).expect("seams");
    let wanted = MeshFile { scale: Some(1e-3), edge: Some(edge), sew, ..MeshFile::plain("") };
    file_from_bytes(&wanted, Path::new("pieces.dxf"), dxf(drawing).as_bytes())
}

fn sewn(drawing: &[Polyline], edge: f64, seams: Value) -> Mesh {
    let Imported { mesh, notes, .. } = sew(drawing, edge, seams).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(notes, Vec::<String>::new());
    mesh
}

fn refusal(drawing: &[Polyline], seams: Value) -> String {
    sew(drawing, 0.1, seams).expect_err("refused").to_string()
}

fn near(found: f64, expected: f64, tolerance: f64, what: &str) {
    assert!((found / expected - 1.0).abs() < tolerance, "{what}: {found} for {expected}");
}

fn group<'a>(mesh: &'a Mesh, name: &str) -> &'a Group {
    mesh.groups.get(name).unwrap_or_else(|| panic!("no {name} in {:?}", mesh.groups.keys()))
}

/// [-] Largest difference of an edge from its flat length.
fn strain(mesh: &Mesh) -> f64 {
    let placed = |[a, b]: [u32; 2]| (mesh.point(a) - mesh.point(b)).norm();
    let flat = (0..).map(|edge| mesh.cut_length(edge).unwrap_or(f64::NAN));
    mesh.edges.iter().zip(flat).map(|(edge, flat)| (placed(*edge) / flat - 1.0).abs()).fold(0.0, f64::max)
}

/// [-] Largest stretch of an edge over its flat length.
fn stretch(mesh: &Mesh) -> f64 {
    let placed = |[a, b]: [u32; 2]| (mesh.point(a) - mesh.point(b)).norm();
    let flat = (0..).map(|edge| mesh.cut_length(edge).unwrap_or(f64::NAN));
    mesh.edges.iter().zip(flat).map(|(edge, flat)| placed(*edge) / flat - 1.0).fold(0.0, f64::max)
}

/// Area, seams and skirt are those of the pattern, whichever rows its mesh has; the start is bent and not stretched.
#[test]
fn gores_become_the_canopy_of_their_pattern() {
    let cases = [
        ("flat-circular", json!({}), 1e-9),
        ("flat-circular", json!({"vent_diameter": 0.8}), 1e-9),
        ("conical", json!({"cone_angle": 0.4, "vent_diameter": 0.8}), 1e-9),
        ("biconical", json!({"cone_angles": [0.3, 0.9], "cone_breaks": [0.5], "gores": 24}), 0.05),
        ("hemispherical", json!({"vent_diameter": 0.6}), 0.02),
        ("hemispherical", json!({"gores": 28, "radial_segments": 20}), 0.02),
        ("extended-skirt", json!({}), 0.3),
    ];
    for (kind, more, shortened) in cases {
        // Curved sides become chords.
        let tolerance = if shortened < 1e-6 { 1e-9 } else { 2e-3 };
        let cut = pattern(kind, more);
        let gores = cut.rows[1].len();
        let layers: Vec<String> = (1..=gores).map(|i| format!("gore-{i}")).collect();
        let mesh = sewn(&side_by_side(&gore(&cut), gores), 0.3, json!([{"gores": layers}]));
        near(group(&mesh, "canopy").area(&mesh), group(&cut, "canopy").area(&cut), tolerance, "area");
        for name in ["radials", "skirt"] {
            near(group(&mesh, name).length(&mesh), group(&cut, name).length(&cut), tolerance, name);
        }
        assert_eq!(mesh.groups.contains_key("vent"), cut.groups.contains_key("vent"), "{kind}");
        let topology = Topology::new(&mesh).expect("a topology");
        topology.check_manifold().and_then(|()| topology.check_orientation(&mesh)).expect("a sheet");
        let holes = usize::from(cut.groups.contains_key("vent"));
        assert_eq!([topology.components(), topology.loops().len()], [1, 1 + holes], "{kind}");
        // Edges across a fold are chords, shorter than the cloth.
        assert!(strain(&mesh) < shortened, "{kind}: {}", strain(&mesh));
        assert!(stretch(&mesh) < 1e-6, "{kind}: {}", stretch(&mesh));
        // As a generated one it stands on z = 0 with its apex up, and its normals point outwards.
        let [low, high] = [f64::min, f64::max].map(|pick| mesh.nodes.iter().map(|p| p[2]).fold(0.0, pick));
        let height = cut.nodes.iter().map(|p| p[2]).fold(0.0, f64::max);
        assert!(low > -1e-3 && (high - height).abs() < 0.01 * height.max(0.1), "{kind}: {low} {high} for {height}");
        let found = Canopy::of_groups(&mesh).remove("canopy").expect("a canopy").expect("a sound one");
        let wanted = Canopy::of_groups(&cut).remove("canopy").expect("a canopy").expect("a sound one");
        near(found.nominal_area, wanted.nominal_area, tolerance, "S0");
        let volume = |mesh: &Mesh| -> f64 {
            mesh.triangles.iter().map(|t| t.map(|node| mesh.point(node))).map(|[a, b, c]| a.cross(&b).dot(&c)).sum()
        };
        assert!((volume(&mesh) - volume(&cut)).abs() <= 0.01 * volume(&cut) + 1e-9, "{kind}");
    }
}

/// One gore used many times is the same canopy as all of them, and lines lead from its seams to the confluence.
#[test]
fn one_gore_is_used_for_all() {
    let cut = pattern("hemispherical", json!({"vent_diameter": 0.6}));
    let outline = gore(&cut);
    let all = sewn(
        &side_by_side(&outline, 12),
        0.4,
        json!([{"gores": (1..=12).map(|i| format!("gore-{i}")).collect::<Vec<_>>()}]),
    );
    let rule = json!([{"gores": ["gore-1"], "copies": 12, "lines": {"length": 7.0, "segments": 3}}]);
    let copied = sewn(&side_by_side(&outline, 1), 0.4, rule);
    let lines = group(&copied, "lines");
    assert_eq!(lines.edges.len(), 36);
    near(lines.length(&copied), 84.0, 1e-12, "lines");
    assert_eq!(group(&copied, "confluence").nodes, group(&copied, "payload").nodes);
    near(group(&copied, "canopy").area(&copied), group(&all, "canopy").area(&all), 1e-9, "area");
    near(group(&copied, "radials").length(&copied), group(&all, "radials").length(&all), 1e-9, "radials");
    assert_eq!(group(&copied, "radials").edges, copied.seams);
}

/// A window in a gore is a hole in every copy.
#[test]
fn holes_are_copied_with_their_gore() {
    let mut drawing = side_by_side(&gore(&pattern("flat-circular", json!({}))), 1);
    let window = vec![[-0.1, 0.5], [0.1, 0.5], [0.1, 0.7], [-0.1, 0.7]];
    drawing.push(Polyline { layer: "window".to_owned(), points: window, closed: true });
    let whole = sewn(&drawing[..1], 0.3, json!([{"gores": ["gore-1"], "copies": 12}]));
    let mesh = sewn(&drawing, 0.3, json!([{"gores": ["gore-1"], "copies": 12}]));
    let area = |mesh: &Mesh| group(mesh, "canopy").area(mesh);
    near(area(&whole) - area(&mesh), 12.0 * 0.04, 1e-9, "windows");
    assert_eq!(Topology::new(&mesh).expect("a topology").loops().len(), 13);
}

/// A flat gore drawn with its seam allowance at both seams and a hem at the skirt, by closed forms.
#[test]
fn allowances_are_cut_off() {
    let (half, height, seam, hem) = (0.8_f64, 3.0_f64, 0.015, 0.03);
    let beta = (half / height).atan();
    let plain = vec![[half, 0.0], [0.0, height], [-half, 0.0]];
    // Seams move outwards by the allowance, the skirt down by the hem.
    let wide = half + seam / beta.cos() + hem * beta.tan();
    let drawn = vec![[wide, -hem], [0.0, height + seam / beta.sin()], [-wide, -hem]];
    let rule = |seam: f64, hem: f64| json!([{"gores": ["gore-1"], "copies": 12, "allowance": seam, "hem": hem}]);
    let without = sewn(&side_by_side(&plain, 1), 0.3, rule(0.0, 0.0));
    let with = sewn(&side_by_side(&drawn, 1), 0.3, rule(seam, hem));
    near(group(&without, "canopy").area(&without), 12.0 * half * height, 1e-9, "area without");
    near(group(&with, "canopy").area(&with), 12.0 * half * height, 1e-9, "area");
    near(group(&with, "radials").length(&with), 12.0 * half.hypot(height), 1e-9, "radials");
    near(group(&with, "skirt").length(&with), 24.0 * half, 1e-9, "skirt");
}

/// Sides by names of lines that are drawn along the outlines, in any order of the two.
#[test]
fn lines_along_outlines_name_their_sides() {
    let outline = gore(&pattern("hemispherical", json!({"vent_diameter": 0.6})));
    let (count, each) = (12, outline.len() / 2);
    let mut drawing = side_by_side(&outline, count);
    let width = drawing[1].points[0][0] - drawing[0].points[0][0];
    for i in 0..count {
        let points = moved(&outline, width * i as f64);
        let line = |side: &str, points: &[[f64; 2]]| Polyline {
            layer: format!("gore-{}-{side}", i + 1),
            points: points.to_vec(),
            closed: false,
        };
        drawing.push(line("right", &points[..each]));
        drawing.push(line("left", &points[each..]));
        drawing.push(Polyline {
            layer: "hem".to_owned(),
            points: vec![points[0], points[points.len() - 1]],
            closed: false,
        });
    }
    let seam = |i: usize| json!({"edges": [format!("gore-{}-right", i + 1), format!("gore-{}-left", (i + 1) % count + 1)], "name": "tapes"});
    let turned = |i: usize| json!({"edges": [format!("gore-{}-left", (i + 1) % count + 1), format!("gore-{}-right", i + 1)], "name": "tapes"});
    let seams: Vec<Value> = (0..count).map(|i| if i % 3 == 1 { turned(i) } else { seam(i) }).collect();
    let named = sewn(&drawing, 0.4, json!(seams));
    let found = sewn(&side_by_side(&outline, 1), 0.4, json!([{"gores": ["gore-1"], "copies": count}]));
    near(group(&named, "tapes").length(&named), group(&found, "radials").length(&found), 1e-9, "tapes");
    near(group(&named, "hem").length(&named), group(&found, "skirt").length(&found), 1e-9, "hem");
    assert_eq!(group(&named, "tapes").edges, named.seams);
    assert_eq!(group(&named, "gore-1-right").edges, group(&named, "gore-2-left").edges);
    assert!(strain(&named) < 0.02, "{}", strain(&named));
    let area: f64 = (1..=count).map(|i| group(&named, &format!("gore-{i}")).area(&named)).sum();
    near(area, group(&found, "canopy").area(&found), 1e-9, "area");
}

fn rectangle(layer: &str, [x, y]: [f64; 2], [width, height]: [f64; 2]) -> Polyline {
    let points = vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]];
    Polyline { layer: layer.to_owned(), points, closed: true }
}

/// Front and back, sewn all around by the numbers of their sides, lie on each other with their normals outwards.
#[test]
fn a_pillow_of_two_pieces() {
    let drawing = [rectangle("front", [0.0, 0.0], [0.6, 0.4]), rectangle("back", [1.0, 0.0], [0.6, 0.4])];
    let seams: Vec<Value> = [(1, 1), (2, 4), (3, 3), (4, 2)]
        .map(|(a, b)| json!({"edges": [format!("front.{a}"), format!("back.{b}")], "name": "piping"}))
        .to_vec();
    let mesh = sewn(&drawing, 0.05, json!(seams));
    let topology = Topology::new(&mesh).expect("a topology");
    topology.check_manifold().and_then(|()| topology.check_orientation(&mesh)).expect("a closed sheet");
    assert_eq!([topology.loops().len(), topology.euler_characteristic() as usize], [0, 2]);
    near(group(&mesh, "piping").length(&mesh), 2.0, 1e-12, "piping");
    let height = |name: &str| {
        let nodes = group(&mesh, name).select_nodes(&mesh);
        nodes.iter().map(|node| mesh.point(*node).z).sum::<f64>() / nodes.len() as f64
    };
    assert!(height("front") > 0.0 && height("back") < 0.0, "{} {}", height("front"), height("back"));
    assert!(strain(&mesh) < 1e-3, "{}", strain(&mesh));
}

/// Sewn by `reverse`, side to the same side, they lie on each other a little apart too.
#[test]
fn a_pillow_sewn_in_reverse_starts_open() {
    let drawing = [rectangle("front", [0.0, 0.0], [0.6, 0.4]), rectangle("back", [1.0, 0.0], [0.6, 0.4])];
    let seams = |reverse: bool| -> Value {
        let seam = |k: usize| json!({"edges": [format!("front.{k}"), format!("back.{k}")], "reverse": reverse});
        json!([1, 2, 3, 4].map(seam))
    };
    let mesh = sewn(&drawing, 0.05, seams(true));
    let height = |name: &str| {
        let nodes = group(&mesh, name).select_nodes(&mesh);
        nodes.iter().map(|node| mesh.point(*node).z).sum::<f64>() / nodes.len() as f64
    };
    assert!(height("front") > 5e-4 && height("back") < -5e-4, "{} {}", height("front"), height("back"));
    let error = refusal(&drawing, seams(false));
    assert!(error.contains("is sewn to itself by the seams around it"), "{error}");
}

/// Outlines that are no gores are left out with a note; a seam line inside a cut line is no hole.
#[test]
fn what_is_no_gore_is_left_out() {
    let one = gore(&pattern("hemispherical", json!({"vent_diameter": 0.6})));
    let all = side_by_side(&one, 3);
    let chosen = json!([{"gores": ["gore-2"], "copies": 12}]);
    let alone = sewn(&all[1..2], 0.3, chosen.clone());
    let left = sew(&all, 0.3, chosen.clone()).expect("sewn");
    assert_eq!(group(&left.mesh, "radials").edges.len(), group(&alone, "radials").edges.len());
    let area = |mesh: &Mesh| group(mesh, "canopy").area(mesh);
    near(area(&left.mesh), area(&alone), 1e-9, "area");
    let notes = left.notes.join("; ");
    assert!(notes.contains("2 outlines that are no gores were left out, on layers: gore-1, gore-3"), "{notes}");
    let middle = |axis: usize| {
        let points = &all[1].points;
        points.iter().map(|point| point[axis]).sum::<f64>() / points.len() as f64
    };
    let centre = [middle(0), middle(1)];
    let shrunk = all[1].points.iter().map(|point| [0, 1].map(|c| centre[c] + 0.95 * (point[c] - centre[c]))).collect();
    let inner = Polyline { points: shrunk, ..all[1].clone() };
    let error = refusal(&[all[1].clone(), inner], chosen);
    assert!(error.contains("would be a hole"), "{error}");
}

/// Panels of a tube, and pieces that close no ring.
#[test]
fn tubes_and_rows_of_panels() {
    let panels: Vec<Polyline> = (0..4).map(|i| rectangle(&format!("p{i}"), [f64::from(i), 0.0], [0.5, 2.0])).collect();
    let seam = |i: usize| json!({"edges": [format!("p{i}.2"), format!("p{}.4", (i + 1) % 4)]});
    let tube = sewn(&panels, 0.25, json!([seam(0), seam(1), seam(2), seam(3)]));
    assert!(strain(&tube) < 1e-12, "{}", strain(&tube));
    near(tube.nodes.iter().map(|p| p[0].hypot(p[1])).fold(0.0, f64::max), 0.5 / 2.0_f64.sqrt(), 1e-12, "radius");
    assert_eq!(Topology::new(&tube).expect("a topology").loops().len(), 2);
    let row = sewn(&panels, 0.25, json!([seam(0), seam(1), seam(2)]));
    assert!(strain(&row) < 1e-9, "{}", strain(&row));
    let width = [f64::min, f64::max].map(|pick| row.nodes.iter().map(|p| p[0]).reduce(pick).expect("nodes"));
    near(width[1] - width[0], 2.0, 1e-9, "width");
    assert!(row.nodes.iter().all(|p| p[2].abs() < 1e-9), "flat");
}

/// The longer side is gathered: both keep their own lengths, and the seam has the mean.
#[test]
fn unequal_sides_are_eased_when_asked_for() {
    let drawing = [rectangle("a", [0.0, 0.0], [1.0, 1.0]), rectangle("b", [2.0, 0.0], [1.0, 1.1])];
    let refused = refusal(&drawing, json!([{"edges": ["a.2", "b.4"]}]));
    assert!(refused.contains("\"a.2\" and \"b.4\" have 1.000000 and 1.100000 m, a difference of 10.0 %"), "{refused}");
    let Imported { mesh, repairs, .. } =
        sew(&drawing, 0.1, json!([{"edges": ["a.2", "b.4"], "ease": true, "name": "seam"}])).expect("sewn");
    assert!(repairs.iter().any(|told| told.contains("10.0 % more")), "{repairs:?}");
    near(group(&mesh, "seam").length(&mesh), 1.05, 1e-12, "seam");
    assert_eq!(group(&mesh, "seam").edges.len(), 11);
    near(group(&mesh, "a").area(&mesh), 1.0, 1e-12, "a");
    near(group(&mesh, "b").area(&mesh), 1.1, 1e-12, "b");
}

/// Meshes of other formats are sewn by groups of edges.
#[test]
fn groups_of_edges_are_sewn() {
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 3 0 0\nv 4 0 0\nv 4 1 0\nv 3 1 0\n\
               g a\nf 1 2 3\nf 1 3 4\ng b\nf 5 6 7\nf 5 7 8\ng right\nl 2 3\ng left\nl 5 8\ng inner\nl 1 3\n";
    let read = |seams: Value| {
        let sew = serde_json::from_value(seams).expect("seams");
        let wanted = MeshFile { sew, translate: [0.0, 0.0, 5.0], ..MeshFile::plain("") };
        file_from_bytes(&wanted, Path::new("a.obj"), obj.as_bytes())
    };
    let mesh = read(json!([{"edges": ["right", "left"]}])).expect("sewn").mesh;
    assert_eq!([mesh.nodes.len(), mesh.edges.len(), mesh.seams.len()], [6, 9, 1]);
    assert!(mesh.nodes.iter().all(|p| (p[2] - 5.0).abs() < 1e-12 && p[0] < 2.0 + 1e-12), "{:?}", mesh.nodes);
    for (sides, told) in [
        (["right", "none"], "there is no side \"none\"; there are inner, left, right"),
        (["right", "inner"], "side \"inner\" has the edge 0-2 of 2 triangles"),
        (["right", "right"], "side \"right\" is 1 chain, but 2 chains of edges are wanted"),
    ] {
        let error = read(json!([{"edges": sides}])).expect_err("refused").to_string();
        assert!(error.contains(told), "{error}");
    }
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let gores = side_by_side(&gore(&pattern("hemispherical", json!({"vent_diameter": 0.6}))), 3);
    let square = [rectangle("a", [0.0, 0.0], [1.0, 1.0]), rectangle("b", [2.0, 0.0], [1.0, 1.0])];
    let told = [
        (
            &gores[..],
            json!([{"gores": ["gore"]}]),
            "layer \"gore\" has no closed outline; there are gore-1, gore-2, gore-3",
        ),
        (&gores, json!([{"gores": ["gore-1", "gore-2"]}]), "2 gores do not go around an axis"),
        (
            &gores,
            json!([{"gores": ["gore-1"], "copies": 12, "allowance": 0.2}]),
            "an allowance of 0.2 m cannot be cut off",
        ),
        (&gores, json!([{"gores": ["gore-1"], "copies": 12, "lines": {"length": 1.0}}]), "do not reach the axis"),
        (&square, json!([{"gores": ["a"], "copies": 12}]), "no gore with 3 or 4 corners and two equal sides"),
        (&square, json!([{"edges": ["a.2", "b.5"]}]), "\"a.1\" of 1.0000 m"),
        (&square, json!([{"edges": ["a.2", "a.4"]}]), "on the same piece"),
        (&square, json!([{"edges": ["a.2", "b.4"]}, {"edges": ["a.2", "b.3"]}]), "sides \"a.2\" and \"a.2\" overlap"),
    ];
    for (drawing, seams, words) in told {
        let error = refusal(drawing, seams);
        assert!(error.contains(words), "{error}");
    }
    let off = Polyline { layer: "seam".to_owned(), points: vec![[1.5, 0.0], [1.5, 1.0]], closed: false };
    let drawing = [square[0].clone(), square[1].clone(), off];
    let error = refusal(&drawing, json!([{"edges": ["seam", "b.4"]}]));
    assert!(error.contains("seam: its lines do not run along an outline"), "{error}");
    // Three squares around a corner close no ring of gores.
    let sew = serde_json::from_value(json!([{"edges": ["a.2", "b.4"]}])).expect("seams");
    let lines = MeshFile { sew, ..MeshFile::plain("") };
    let error = file_from_bytes(&lines, Path::new("a.dxf"), dxf(&square).as_bytes()).expect_err("refused").to_string();
    assert!(error.contains("give \"edge\""), "{error}");
}

/// Faults of the rules themselves have their place in the case.
#[test]
fn rules_are_checked() {
    for (rule, at) in [
        (json!([{}]), "/sew/0"),
        (json!([{"edges": ["a", "b"], "gores": ["c"]}]), "/sew/0"),
        (json!([{"edges": ["a", "b"], "allowance": -1.0}]), "/sew/0/allowance"),
        (json!([{"edges": ["a", "b"], "copies": 3}]), "/sew/0/copies"),
        (json!([{"gores": ["a"], "copies": 0}]), "/sew/0/copies"),
        (json!([{"gores": ["a", "b", "a"]}]), "/sew/0/gores/2"),
        (json!([{"gores": ["a"], "reverse": true}]), "/sew/0/reverse"),
        (json!([{"gores": ["a"]}, {"edges": ["a", "b"]}]), "/sew/0/gores"),
    ] {
        let source = serde_json::from_value(json!({"file": "a.dxf", "sew": rule})).expect("a source");
        let source: canopy_fem::mesh::MeshSource = source;
        let mut found = Vec::new();
        source.check(&mut |at, _, _, _| found.push(at.to_owned()));
        assert_eq!(found.first().map(String::as_str), Some(at), "{rule}");
    }
}
