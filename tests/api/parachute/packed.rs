//! The start `packed`: lines in bights and the canopy folded along the axis, of every type of canopy.

use super::stretched::{Start, stretched_types};
use super::*;
use canopy_fem::mesh::crossing::CrossingFinder;
use canopy_fem::mesh::least_distance::least_distance;
use canopy_fem::mesh::parachute::StartShape;
use std::collections::BTreeSet;

/// [-] largest strain at the start
const STRAIN: f64 = 1e-9;

/// Every type and what may be added to it, in a pack of its own size and in given ones.
fn packed_types() -> Vec<ParachuteParameters> {
    let coarsened = parameters("flat-circular", json!({"coarsen": true, "radial_segments": 20}));
    let all = stretched_types().into_iter().chain([coarsened]);
    let starts = [json!("packed"), json!({"packed": {"length": 0.4, "radius": 0.25, "bag": true}})];
    let start = |p: ParachuteParameters| {
        starts
            .clone()
            .map(|start| ParachuteParameters { start: serde_json::from_value(start).expect("a start"), ..p.clone() })
    };
    all.flat_map(start).collect()
}

/// Edges of the groups that are parts of canopy and lines, without those of triangles.
fn lines_of(mesh: &Mesh, names: &[&str]) -> Vec<[u32; 2]> {
    let cloth: BTreeSet<u32> = group(mesh, "cloth").edges.iter().copied().collect();
    let edges = names.iter().filter_map(|name| mesh.groups.get(*name)).flat_map(|group| group.edges.clone());
    edges.filter(|edge| !cloth.contains(edge)).map(|edge| mesh.edges[edge as usize]).collect()
}

/// Nothing is stretched, nothing passes through anything else, and the pack has its size above the confluence, which
/// stays where it is.
#[test]
fn a_pack_is_slack_within_its_size_and_free_of_crossings() {
    for p in packed_types() {
        let start = Start::of(&p);
        let flat = built(&ParachuteParameters { start: StartShape::Flat.into(), ..p.clone() });
        for name in
            ["cloth", "radials", "verticals", "vent-lines", "lines", "inner-lines", "centre-line", "riser", "reefing"]
        {
            let rest_of_ring = p.reefing_length().filter(|_| name == "reefing");
            for [rest, now] in start.lengths(&p, name) {
                let rest = rest_of_ring.unwrap_or(rest);
                assert!(now < rest * (1.0 + STRAIN), "{name} is stretched, {now} of {rest} m: {p:?}");
                assert!(now > 0.0, "{name}: {p:?}");
            }
        }
        let places: Vec<[f64; 3]> = start.at.iter().map(|x| (*x).into()).collect();
        let mut finder = CrossingFinder::new(&start.mesh.triangles).expect("cloth");
        assert!(finder.find(&places).is_empty() && finder.is_complete(), "cloth crosses cloth: {p:?}");
        let lines = lines_of(&start.mesh, &["radials", "verticals", "lines", "inner-lines", "centre-line"]);
        let apart = least_distance(&places, &start.mesh.triangles, &lines).expect("a distance");
        assert!(apart > 1e-4, "parts are {apart} m apart: {p:?}");
        if p.cluster.is_some() {
            continue;
        }
        for name in ["confluence", "payload"] {
            for &node in &group(&flat, name).nodes {
                assert_eq!(start.at(node), point(&flat, node), "{name} has moved: {p:?}");
            }
        }
        let [length, radius] = size(&p, &start);
        let packed = p.start.packed().expect("a pack");
        packed.length.into_iter().for_each(|wanted| close(length, wanted, 1e-12, "length"));
        let most = packed.radius.unwrap_or(0.03 * p.nominal_diameter.expect("D0"));
        assert!(radius <= most * (1.0 + 1e-12) && radius > 0.5 * most, "radius {radius} of {most}: {p:?}");
        if packed.bag {
            continue;
        }
        let told = p.describe_sizes(&start.mesh).expect("sizes");
        let told = told.iter().find(|(what, _)| *what == "pack").map(|(_, text)| text.clone()).expect("a line");
        assert!(told.contains("parts that share no node are at least "), "{told}");
        assert!(told.starts_with(&format!("{length:.6} m long, radius {radius:.6} m")), "{told}: {length} {radius}");
    }
}

/// [m] Height of the highest node above the confluence, and the largest distance from the axis; nothing is below.
fn size(p: &ParachuteParameters, start: &Start) -> [f64; 2] {
    let nodes: BTreeSet<u32> = ["canopy", "lines", "inner-lines", "centre-line"]
        .iter()
        .filter_map(|name| start.mesh.groups.get(*name))
        .flat_map(|group| group.select_nodes(&start.mesh))
        .collect();
    let bottom = start.at(group(&start.mesh, "confluence").nodes[0]).z;
    let heights = nodes.iter().map(|&node| start.at(node).z - bottom);
    assert!(heights.clone().all(|height| height >= 0.0), "below the confluence: {p:?}");
    [heights.fold(0.0, f64::max), nodes.iter().map(|&node| start.radius(node)).fold(0.0, f64::max)]
}

/// Rows are rings of one height and radius, and heights fall strictly from the apex to the confluence: no two sheets
/// between rows share a height.
#[test]
fn heights_fall_from_row_to_row() {
    for p in packed_types().into_iter().filter(|p| p.cluster.is_none()) {
        let start = Start::of(&p);
        let mut last = f64::INFINITY;
        for row in &start.mesh.rows {
            let height = start.at(row[0]).z;
            assert!(row.iter().all(|&node| (start.at(node).z - height).abs() < 1e-12), "{p:?}");
            assert!(height < last, "{p:?}");
            last = height;
        }
        for pair in lines_of(&start.mesh, &["lines"]) {
            let [from, to] = pair.map(|node| start.at(node).z);
            assert!(to < from, "a line does not fall: {p:?}");
        }
    }
}

/// Folds do not depend on the mesh: with rows shorter than a fold is wide, several make one fold, and both fill the
/// width between the radius and half of it.
#[test]
fn folds_are_as_wide_as_the_pack_on_fine_meshes() {
    for rows in [12, 60] {
        let start = json!({"packed": {"length": 0.6, "radius": 0.24}});
        let more = json!({"radial_segments": rows, "gore_segments": 1, "start": start});
        let p = parameters("flat-circular", more);
        let start = Start::of(&p);
        let radii: Vec<f64> = start.mesh.rows.iter().map(|row| start.radius(row[0])).collect();
        let turns = radii.windows(3).filter(|r| (r[1] - r[0]) * (r[2] - r[1]) < 0.0).map(|r| r[1]);
        let turns: Vec<f64> = turns.collect();
        assert!(
            turns.len() > 6 && turns.iter().all(|r| (r - 0.24).abs() < 1e-12 || (r - 0.12).abs() < 1e-12),
            "{radii:?}"
        );
    }
}

/// The bag is above the pack on the axis; its ties are slack at the start by nothing, from the confluence to the
/// apex, one to every seam and bight.
#[test]
fn a_bag_is_tied_to_bights_and_seams() {
    let start = json!({"packed": {"length": 0.6, "radius": 0.2, "bag": true}});
    for vent in [json!(0.85), Value::Null] {
        let p = parameters("flat-circular", json!({"vent_diameter": vent, "start": start}));
        let start = Start::of(&p);
        let mesh = &start.mesh;
        let bag = group(mesh, "bag").nodes[0];
        let top = start.at(mesh.rows[0][0]).z;
        assert!(start.radius(bag) == 0.0 && (start.at(bag).z - top - 0.1).abs() < 1e-12);
        let rows = 5 + 12 + usize::from(p.vent_diameter.is_some()) - 1 + usize::from(p.vent_diameter.is_none());
        let stows = &group(mesh, "stows").edges;
        assert_eq!(stows.len(), 28 * rows);
        let heights: Vec<f64> = stows.iter().map(|&edge| start.at(mesh.edges[edge as usize][1]).z).collect();
        assert!(stows.iter().all(|&edge| mesh.edges[edge as usize][0] == bag));
        assert!(heights.windows(2).all(|pair| pair[0] <= pair[1] + 1e-12), "not from the confluence to the apex");
        let bridle = &group(mesh, "bridle").edges;
        assert_eq!(bridle.len(), if p.vent_diameter.is_some() { 28 } else { 1 });
        for name in ["stows", "bridle"] {
            start.lengths(&p, name).iter().for_each(|[rest, now]| close(*rest, *now, 1e-14, name));
        }
    }
    let without = built(&parameters("flat-circular", json!({"start": "packed"})));
    assert!(["bag", "stows", "bridle"].iter().all(|name| !without.groups.contains_key(*name)));
}

/// Packs that cannot be are refused at their place with words that help.
#[test]
fn bad_packs_are_refused() {
    let rows = [
        (json!({"start": {"packed": {"length": 0.0}}}), "/start/packed/length", "above 0"),
        (json!({"start": {"packed": {"radius": -1.0}}}), "/start/packed/radius", "above 0"),
        (json!({"start": {"packed": {"length": 9.0}}}), "/start/packed/length", "half of canopy and lines"),
        (json!({"start": {"packed": {"radius": 5.0}}}), "/start/packed/radius", "the radius of the skirt as it is cut"),
        (json!({"start": "packed", "lines": null, "riser": null}), "/start", "a packed start needs lines"),
        (json!({"start": "packed", "start_radius": 0.02}), "/start_radius", "only with the start \"stretched\""),
        (
            json!({"start": {"packed": {"length": 3.0}}, "inner_lines": {"length": 2.0}, "vent_diameter": 3.0}),
            "/start",
            "inner lines of 2.000000 m lead to its end",
        ),
        (json!({"start": {"stretched": {"radius": 5.0}}}), "/start/stretched/radius", "the radius of the skirt"),
        (
            json!({"start": {"stretched": {"radius": 0.2}}, "start_radius": 0.02}),
            "/start_radius",
            "not together with start.stretched.radius",
        ),
    ];
    for (more, at, words) in rows {
        let p = parameters("flat-circular", more.clone());
        let mut faults = Vec::new();
        p.check("", &mut |at, value, allowed, hint| faults.push(format!("{at}: {value}; {allowed}; {hint}")));
        if faults.is_empty() {
            faults.extend(p.build().err().map(|error| error.to_string()));
        }
        let text = faults.join("\n");
        assert!(text.contains(at) && text.contains(words), "{more}: {text}");
    }
    let stretched = |start: Value| built(&parameters("flat-circular", start));
    let [named, sized] =
        [json!({"start": "stretched", "start_radius": 0.2 / 8.534}), json!({"start": {"stretched": {"radius": 0.2}}})]
            .map(stretched);
    let difference = named.displacement.iter().flatten().zip(sized.displacement.iter().flatten());
    assert!(difference.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-14);
}
