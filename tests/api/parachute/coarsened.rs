//! Gores coarsened towards the apex: angles, areas, rows, tapes, and what a fall makes of them.

use super::*;
use canopy_fem::case::spec::SystemSpec;
use canopy_fem::mesh::Quality;
use std::collections::BTreeSet;

/// Types with gores, by the edges across a gore at which its cells are at most 2.2 times as wide as high.
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
    of((wide / (2.2 * high)).ceil() as usize)
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
    let sides: BTreeSet<[u32; 2]> = cloth.iter().map(|&edge| mesh.edges[edge as usize].into()).collect();
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
    Quality::new(&mesh, &topology)
}

fn strands(mesh: &Mesh, name: &str, edge: u32) -> f64 {
    mesh.strands.get(name).and_then(|of| of.get(&edge)).copied().unwrap_or(1.0)
}

/// At least 20 degrees for every type and every number of gores from 8 to 48, primes among them. Edges of the cloth are
/// at most 7 times as long as others; without coarsening it is up to 27 times.
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
            assert!(quality.min_angle >= 20.0 && ratio < 7.0, "{name}: {} degrees, {ratio}", quality.min_angle);
        }
    }
}
