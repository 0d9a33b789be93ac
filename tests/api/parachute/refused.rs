//! What cannot be a parachute, a group or a canopy is refused.

use super::*;
use canopy_fem::mesh::canopy::CanopyParts;

/// What cannot be a parachute, or no group, is refused at its place with words that help.
#[test]
fn bad_parachutes_are_refused() {
    const AT: &str = "/system/network/mesh/parachute";
    let key = |name: &str| format!("system.network.mesh.parachute.{name}");
    let rows: [(&str, &str, &str, &str); 31] = [
        ("lines.length", "4.2", "/lines/length", "the skirt's corners are"),
        ("lines.length", "-1", "/lines/length", "above 0"),
        ("vent_diameter", "7", "/vent_diameter", "more vent than cloth"),
        ("gores", "27", "/gores", "an even number with vent lines"),
        ("gores", "2", "/gores", "3 to 10000"),
        ("lines", "null", "/riser", "only below suspension lines"),
        ("radial_segments", "0", "/radial_segments", "1 to"),
        ("nominal_diameter", "0", "/nominal_diameter", "above 0"),
        ("type", "flat", "/type", "flat-circular"),
        ("type", "conical", "/cone_angle", "needs it"),
        ("cone_angle", "0.3", "/cone_angle", "only with type"),
        ("type", "biconical", "/cone_angles", "2 angles"),
        ("type", "ringslot", "/rings", "needs it"),
        ("type", "cruciform", "/vent_diameter", "no vent"),
        ("start", "inflate", "/start", "did you mean"),
        ("payload", r#"{"below_riser": 1}"#, "/payload", "exactly one of"),
        ("payload", r#"{"box": [1, 0, 1], "below_riser": 1}"#, "/payload/box", "above 0"),
        ("payload", r#"{"box": [1, 1, 9], "below_riser": 1}"#, "/payload/below_riser", "half height"),
        (
            "payload",
            r#"{"radii_of_gyration": [1, 1, 9], "below_riser": 1}"#,
            "/payload/radii_of_gyration",
            "square of each",
        ),
        ("reefing", r#"{"diameter": 0}"#, "/reefing/diameter", "above 0"),
        ("reefing", r#"{"diameter": 0.2}"#, "/reefing/diameter", "more than the vent's"),
        ("gore_segments", "0", "/gore_segments", "1 to"),
        ("riser.length", "0", "/riser/length", "above 0"),
        ("vent_diameter", "-1", "/vent_diameter", "above 0"),
        ("arm_ratio", "0.3", "/arm_ratio", "only with type \"cruciform\""),
        ("gores", "10000000", "/gores", "3 to 10000"),
        ("skirt_angle", "1.5", "/skirt_angle", "only with type \"extended-skirt\""),
        ("inner_lines", r#"{"segments": 0}"#, "/inner_lines/segments", "1 to"),
        ("vent_diameter", "null", "/inner_lines", "only from a vent"),
        ("lines", "null", "/inner_lines", "only from a vent"),
        ("start", "inflated", "/start", "a canopy without inner lines"),
    ];
    for (name, value, at, words) in rows {
        // The last rows are about inner lines.
        let inner = at == "/inner_lines" || words.contains("inner lines");
        let more = [(key("inner_lines"), r#"{"segments": 2}"#)];
        let mut sets: Vec<(&str, &str)> = more.iter().filter(|_| inner).map(|(k, v)| (k.as_str(), *v)).collect();
        let named = key(name);
        sets.push((&named, value));
        let error = case_with(&sets).expect_err(name);
        let hit = error.faults().iter().find(|f| f.pointer == format!("{AT}{at}"));
        let hit = hit.unwrap_or_else(|| panic!("{name} = {value}: no fault at {at}, but {error}"));
        assert!(hit.to_string().contains(words), "{name} = {value}: \"{words}\" is not in\n{hit}");
    }
    for (path, at, words) in [
        ("springs.5.on", "/springs/5/on/group", "did you mean \"lines\"?"),
        ("loads.0.on", "/loads/0/on/group", "groups of this mesh: canopy, cloth"),
    ] {
        let error = case_with(&[(&format!("system.network.{path}"), r#"{"group": "line"}"#)]).expect_err(path);
        let hit = error.faults().iter().find(|f| f.pointer.ends_with(at)).unwrap_or_else(|| panic!("{error}"));
        assert!(hit.to_string().contains(words), "{hit}");
    }
    let kinds = [("springs.5.on", "payload", "edges or triangles"), ("loads.0.on", "lines", "triangles")];
    for (path, name, words) in kinds {
        let error = case_with(&[(&format!("system.network.{path}.group"), name)]).expect_err(path);
        assert!(error.to_string().contains(&format!("a group with {words}")), "{error}");
    }
}

/// Parts that are no canopy are refused one by one.
#[test]
fn parts_that_are_no_canopy_are_named() {
    let mesh = built(&parameters("flat-circular", json!({})));
    let (canopy, skirt) = (group(&mesh, "canopy").triangles.clone(), group(&mesh, "skirt").edges.clone());
    let (vent, confluence) = (group(&mesh, "vent").nodes.clone(), group(&mesh, "confluence").nodes.clone());
    let parts = CanopyParts { triangles: &canopy, skirt_edges: &skirt, skirt_nodes: &[], confluence: &confluence };
    assert_eq!(Canopy::of(&mesh, parts).expect("sound").skirt.len(), 56);
    let open = Canopy::of(&mesh, CanopyParts { skirt_edges: &skirt[1..], ..parts });
    assert!(matches!(open, Err(CanopyError::OpenSkirt { edges: 1, .. })), "{open:?}");
    let both = [skirt.clone(), group(&mesh, "vent").edges.clone()].concat();
    let two = Canopy::of(&mesh, CanopyParts { skirt_edges: &both, ..parts });
    assert!(matches!(two, Err(CanopyError::SeveralLoops { edges: 112, .. })), "{two:?}");
    let inside = Canopy::of(&mesh, CanopyParts { skirt_edges: &group(&mesh, "radials").edges, ..parts });
    assert!(matches!(inside, Err(CanopyError::NoBoundary { triangles: 2, .. })), "{inside:?}");
    let nodes = |nodes: &[u32]| Canopy::of(&mesh, CanopyParts { skirt_edges: &[], skirt_nodes: nodes, ..parts });
    let corners = &group(&mesh, "skirt").nodes[..3];
    assert_eq!(nodes(corners).expect("on one loop").skirt, corners);
    let mixed = nodes(&[corners[0], vent[0]]);
    assert_eq!(mixed, Err(CanopyError::OffSkirt { node: vent[0] }));
    let whole = CanopyParts { skirt_edges: &[], ..parts };
    assert_eq!(Canopy::of(&mesh, whole).expect("sound").skirt.len(), 56);
    // With the vent as the skirt, the true skirt is a vent as large as the canopy.
    let upside_down = nodes(&vent);
    assert!(matches!(upside_down, Err(CanopyError::MoreVent { .. })), "{upside_down:?}");
    let in_cloth = Canopy::of(&mesh, CanopyParts { confluence: &vent, ..parts });
    assert_eq!(in_cloth, Err(CanopyError::ConfluenceInCanopy { node: vent[0] }));
    let flat = Canopy::of(&mesh, parts)
        .expect("sound")
        .axis(&|node| if node == confluence[0] { Vector::zeros() } else { point(&mesh, node) });
    assert!(matches!(flat, Err(CanopyError::NoAxis { .. })), "{flat:?}");
    let mut loose = mesh.clone();
    let fallen = loose.nodes.len() as u32;
    loose.nodes.push([0.0, 0.0, -20.0]);
    loose.groups.insert("payload".to_owned(), Group::of_nodes([fallen]));
    assert_eq!(sole_canopy(&loose), Err(CanopyError::LoosePayload { node: fallen }));
    let mut turned = mesh.clone();
    turned.triangles[3].swap(0, 1);
    let turned = Canopy::of(&turned, parts);
    assert!(matches!(turned, Err(CanopyError::Orientation { .. })), "{turned:?}");
}
