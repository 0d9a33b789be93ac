//! Meshes: generators meet their counts, topology finds the loops, bad input is refused with its numbers.

use canopy_fem::mesh::annulus::{AnnulusParameters, DiscParameters};
use canopy_fem::mesh::{EdgeKind, Mesh, MeshError, MeshSource, Quality, Topology};
use std::collections::BTreeSet;
use std::path::Path;

fn thesis(seams: Option<usize>, seed: u64) -> AnnulusParameters {
    AnnulusParameters {
        inner_radius: 0.1,
        outer_radius: 1.0,
        nodes: 703,
        boundary_nodes: Some(126),
        seams,
        seed,
        grading: None,
    }
}

fn source(json: &str) -> MeshSource {
    serde_json::from_str(json).expect("a mesh source")
}

fn faults(source: &MeshSource) -> Vec<String> {
    let mut found = Vec::new();
    source.check(&mut |pointer, _, _, _| found.push(pointer.to_owned()));
    found
}

/// What every flat generated mesh must be: consistent, manifold, turned to +z, one component.
fn assert_sound(mesh: &Mesh, euler: i64) {
    let topology = Topology::new(mesh).expect("a valid mesh");
    topology.check_manifold().expect("manifold");
    topology.check_orientation(mesh).expect("consistent");
    assert_eq!((topology.components(), topology.euler_characteristic()), (1, euler));
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|n| mesh.nodes[n as usize]);
        let twice_area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert!(twice_area > 0.0, "triangle {t:?} looks down");
    }
}

fn assert_on_circle(mesh: &Mesh, nodes: &[u32], radius: f64) {
    for &n in nodes {
        let [x, y, z] = mesh.nodes[n as usize];
        assert!((x.hypot(y) - radius).abs() < 4e-16 && z == 0.0, "node {n} is off the circle");
    }
}

/// The thesis' counts hold exactly and its angles for many seeds; boundary nodes lie on the circles to rounding.
#[test]
fn thesis_annulus_has_its_counts_and_angles_for_every_seed() {
    for seed in 0..30 {
        let mesh = thesis(None, seed).build().expect("the thesis' mesh");
        assert_eq!((mesh.nodes.len(), mesh.triangles.len(), mesh.edges.len()), (703, 1280, 1983));
        assert_sound(&mesh, 0);
        let topology = Topology::new(&mesh).expect("valid");
        assert_eq!(topology.boundary_nodes().len(), 126);
        assert_on_circle(&mesh, topology.inner_nodes(), 0.1);
        assert_on_circle(&mesh, topology.outer_nodes(), 1.0);
        let angle = Quality::new(&mesh).expect("valid").min_angle;
        assert!(angle > 30.0, "seed {seed}: smallest angle {angle}");
    }
}

/// The same seed gives the same bits, another seed another mesh.
#[test]
fn seed_decides_the_mesh() {
    let build = |seed| thesis(None, seed).build().expect("a mesh");
    assert_eq!(build(7), build(7));
    assert_ne!(build(7), build(8));
}

/// Twelve seams: counts stay exact, each seam is an unbroken straight radial line from loop to loop.
#[test]
fn seams_are_straight_lines_from_loop_to_loop() {
    let mesh = thesis(Some(12), 1).build().expect("a mesh with seams");
    assert_eq!((mesh.nodes.len(), mesh.triangles.len(), mesh.edges.len()), (703, 1280, 1983));
    assert_sound(&mesh, 0);
    let mut reach = [[f64::INFINITY, 0.0_f64]; 12];
    let mut length = [0.0; 12];
    for &seam in &mesh.seams {
        let ends = mesh.edges[seam as usize].map(|n| mesh.nodes[n as usize]);
        let radii = ends.map(|p| p[0].hypot(p[1]));
        let lines = ends.map(|p| p[1].atan2(p[0]) * 12.0 / std::f64::consts::TAU);
        let line = lines[0].round();
        assert!((lines[0] - line).abs() < 1e-12, "seam edge {seam} leaves its ray");
        let apart = (lines[1] - lines[0]).rem_euclid(12.0);
        assert!(apart.min(12.0 - apart) < 1e-12, "seam edge {seam} joins two rays");
        let line = line.rem_euclid(12.0) as usize % 12;
        length[line] += (radii[0] - radii[1]).abs();
        reach[line] = [reach[line][0].min(radii[0].min(radii[1])), reach[line][1].max(radii[0].max(radii[1]))];
    }
    for (length, [low, high]) in length.into_iter().zip(reach) {
        assert!((length - 0.9).abs() < 1e-12 && (low - 0.1).abs() < 1e-12 && (high - 1.0).abs() < 1e-12);
    }
}

/// Annuli of other sizes, with derived boundary counts and with seams, meet Euler's counts and fair angles.
#[test]
fn other_annuli_are_fair() {
    for (nodes, seams) in [(50, None), (200, None), (200, Some(6)), (2000, Some(24)), (5000, None)] {
        let p = AnnulusParameters { nodes, boundary_nodes: None, ..thesis(seams, 3) };
        let mesh = p.build().expect("an annulus");
        assert_sound(&mesh, 0);
        let boundary = Topology::new(&mesh).expect("valid").boundary_nodes().len();
        assert_eq!((mesh.nodes.len(), mesh.triangles.len()), (nodes, 2 * nodes - boundary));
        let angle = Quality::new(&mesh).expect("valid").min_angle;
        assert!(angle > 25.0, "{nodes} nodes, {seams:?} seams: {angle}");
    }
}

/// Discs, with seams that meet in the centre, meet Euler's counts and fair angles.
#[test]
fn discs_are_fair() {
    for (nodes, seams) in [(20, None), (500, Some(6)), (1000, Some(12)), (1000, Some(3)), (3000, None)] {
        let p = DiscParameters { radius: 2.0, nodes, boundary_nodes: None, seams, seed: 1, grading: Some(2.0) };
        let mesh = p.build().expect("a disc");
        assert_sound(&mesh, 1);
        let boundary = Topology::new(&mesh).expect("valid").boundary_nodes().len();
        assert_eq!((mesh.nodes.len(), mesh.triangles.len()), (nodes, 2 * nodes - boundary - 2));
        let angle = Quality::new(&mesh).expect("valid").min_angle;
        assert!(angle > 25.0, "{nodes} nodes, {seams:?} seams: {angle}");
    }
}

/// Large meshes, which start from coarser ones, are as sound as small ones and their triangles are on average as good:
/// by one level and by two, with seams, and where a thin ring starts from the spiral. Most edges join nodes that are
/// near each other in memory.
#[test]
fn large_meshes_are_fair() {
    let annulus = |inner_radius, nodes, seams| {
        let p = AnnulusParameters { inner_radius, nodes, boundary_nodes: None, ..thesis(seams, 1) };
        p.build().expect("an annulus")
    };
    let disc = DiscParameters {
        radius: 2.0,
        nodes: 25_000,
        boundary_nodes: None,
        seams: Some(6),
        seed: 1,
        grading: Some(3.0),
    };
    let meshes = [
        (100_001, 0, 54.0, annulus(0.1, 100_001, None)),
        (50_000, 0, 54.0, annulus(0.1, 50_000, None)),
        (30_000, 0, 53.0, annulus(0.01, 30_000, Some(12))),
        (40_000, 0, 50.0, annulus(0.97, 40_000, None)),
        (25_000, 1, 53.0, disc.build().expect("a disc")),
    ];
    for (nodes, euler, least, mesh) in meshes {
        assert_eq!(mesh.nodes.len(), nodes);
        assert_sound(&mesh, euler);
        let quality = Quality::new(&mesh).expect("valid");
        println!("{nodes}: {} degrees at least, {} on average", quality.min_angle, quality.mean_min_angle);
        assert!(quality.min_angle > 25.0 && quality.mean_min_angle > least, "{nodes}: {quality:?}");
        let mut apart: Vec<u32> = mesh.edges.iter().map(|&[a, b]| a.abs_diff(b)).collect();
        apart.sort_unstable();
        // On the spiral the interior starts from, half of the edges join nodes that are hundreds apart.
        assert!(apart[apart.len() / 2] < 40, "{nodes}: {}", apart[apart.len() / 2]);
    }
}

/// A larger `grading` makes longer edges in the middle than at the edges.
#[test]
fn grading_lengthens_the_middle() {
    let spread = |grading| {
        let p = AnnulusParameters { boundary_nodes: None, grading: Some(grading), ..thesis(None, 1) };
        let q = Quality::new(&p.build().expect("a mesh")).expect("valid");
        q.max_edge / q.min_edge
    };
    assert!(spread(3.0) > 1.5 * spread(1.0));
}

/// Impossible counts are refused with the numbers that would work, not turned into a bad mesh.
#[test]
fn impossible_counts_are_refused() {
    let few = AnnulusParameters { nodes: 100_000, boundary_nodes: Some(20), ..thesis(None, 1) }.build();
    let Err(MeshError::NodeCounts { least, most, .. }) = few else { panic!("{few:?}") };
    let inside = AnnulusParameters { nodes: (least + most) / 2, boundary_nodes: Some(20), ..thesis(None, 1) };
    assert!(!matches!(inside.build(), Err(MeshError::NodeCounts { .. })));
    let full = AnnulusParameters { nodes: 126, ..thesis(None, 1) }.build();
    assert!(matches!(full, Err(MeshError::NodeCounts { .. })), "{full:?}");
    let seams = AnnulusParameters { nodes: 150, boundary_nodes: None, ..thesis(Some(60), 1) }.build();
    assert!(matches!(seams, Err(MeshError::NoInterior { .. })), "{seams:?}");
}

/// Every fault is reported with its pointer, and nothing is built.
#[test]
fn parameter_faults_are_all_reported() {
    let bad = source(r#"{"annulus": {"inner_radius": -1, "outer_radius": 0, "nodes": 2, "grading": 99}}"#);
    let found = faults(&bad);
    for key in ["inner_radius", "outer_radius", "nodes", "grading"] {
        assert!(found.contains(&format!("/annulus/{key}")), "{key} missing in {found:?}");
    }
    assert!(matches!(bad.build(Path::new("")), Err(MeshError::Parameter { .. })));
    let bad = source(r#"{"explicit": {"nodes": [[0,0,0],[1,0,0]], "springs": [[0,2],[1,1]]}}"#);
    assert_eq!(faults(&bad), ["/explicit/springs/0", "/explicit/springs/1"]);
    let huge = source(r#"{"rectangle": {"width": 1, "height": 1, "columns": 4000000000, "rows": 4000000000}}"#);
    assert!(matches!(huge.build(Path::new("")), Err(MeshError::Parameter { .. })));
    assert!(serde_json::from_str::<MeshSource>(r#"{"disc": {"radius": 1, "nodes": 10, "noddes": 3}}"#).is_err());
}

/// Rectangles: counts, area and corners; the boundary is the rim.
#[test]
fn rectangles_have_their_counts() {
    for (pattern, nodes, triangles) in [("regular", 20, 24), ("crossed", 32, 48)] {
        let json = format!(
            r#"{{"rectangle": {{"width": 3.0, "height": 2.0, "columns": 3, "rows": 4, "pattern": "{pattern}"}}}}"#
        );
        let mesh = source(&json).build(Path::new("")).expect("a rectangle");
        assert_eq!((mesh.nodes.len(), mesh.triangles.len()), (nodes, triangles));
        assert_sound(&mesh, 1);
        assert_eq!(mesh.nodes[19], [3.0, 2.0, 0.0]);
        assert!((Quality::new(&mesh).expect("valid").total_area - 6.0).abs() < 1e-13);
        assert_eq!(Topology::new(&mesh).expect("valid").outer_nodes().len(), 14);
    }
}

/// A chain meets both ends to the last bit and has only line edges.
#[test]
fn chain_meets_its_ends() {
    let mesh = source(r#"{"chain": {"from": [0.1, 0.2, 0.3], "to": [0.7, -0.9, 1.1], "segments": 7}}"#);
    let mesh = mesh.build(Path::new("")).expect("a chain");
    assert_eq!((mesh.nodes[0], mesh.nodes[7], mesh.edges.len()), ([0.1, 0.2, 0.3], [0.7, -0.9, 1.1], 7));
    let topology = Topology::new(&mesh).expect("valid");
    assert!((0..7).all(|e| topology.edge_kind(e) == EdgeKind::Line));
    assert!(topology.boundary_nodes().is_empty());
}

/// Explicit springs keep their order; without them the triangles' edges serve; edge kinds follow from the triangles.
#[test]
fn explicit_lists_are_kept() {
    let nodes = r#""nodes": [[0,0,0],[1,0,0],[1,1,0],[0,1,0],[2,2,2]], "triangles": [[0,1,2],[0,2,3]]"#;
    let with = source(&format!(r#"{{"explicit": {{{nodes}, "springs": [[2,4],[2,0],[3,0]]}}}}"#));
    let mesh = with.build(Path::new("")).expect("a mesh");
    assert_eq!(mesh.edges, [[2, 4], [2, 0], [3, 0]]);
    let topology = Topology::new(&mesh).expect("valid");
    let kinds: Vec<EdgeKind> = (0..3).map(|e| topology.edge_kind(e)).collect();
    assert_eq!(kinds, [EdgeKind::Line, EdgeKind::Interior, EdgeKind::Boundary]);
    assert_eq!(topology.edge_triangles(1), [0, 1]);
    let without = source(&format!(r#"{{"explicit": {{{nodes}}}}}"#)).build(Path::new("")).expect("a mesh");
    assert_eq!(without.edges.len(), 5);
}

/// The checks name the first pair of neighbours that turn opposite ways, duplicates and degenerate triangles.
#[test]
fn bad_triangles_are_named() {
    let mesh = |triangles: Vec<[u32; 3]>| Mesh {
        nodes: vec![
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
            [2.0, 0.0, 0.0],
            [0.5, 0.5, 1.0],
        ],
        triangles,
        ..Mesh::default()
    };
    let turned = mesh(vec![[0, 1, 2], [0, 3, 2]]);
    let found = Topology::new(&turned).expect("valid").check_orientation(&turned);
    assert_eq!(found, Err(MeshError::Orientation { first: 0, second: 1, a: 0, b: 2 }));
    let fin = mesh(vec![[0, 1, 2], [0, 2, 3], [0, 2, 5]]);
    let three = Topology::new(&fin).expect("valid").check_manifold();
    assert_eq!(three, Err(MeshError::NonManifold { triangles: 3, a: 0, b: 2 }));
    assert!(matches!(mesh(vec![[0, 1, 4]]).check(), Err(MeshError::DegenerateTriangle { triangle: 0, .. })));
    let twice = mesh(vec![[0, 1, 2], [1, 2, 0]]).check();
    assert_eq!(twice, Err(MeshError::DuplicateTriangle { first: 0, second: 1 }));
    assert!(matches!(mesh(vec![[0, 1, 9]]).check(), Err(MeshError::NodeOutOfRange { node: 9, .. })));
}

/// Two triangles that touch in one node are a loop each, not a figure of eight; the larger one is the outer loop.
#[test]
fn loops_that_touch_in_a_node_stay_apart() {
    let nodes = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-3.0, 0.0, 0.0], [0.0, -3.0, 0.0]];
    let mesh = Mesh { nodes, triangles: vec![[0, 1, 2], [0, 3, 4]], ..Mesh::default() };
    let topology = Topology::new(&mesh).expect("valid");
    let loops: BTreeSet<BTreeSet<u32>> = topology.loops().iter().map(|l| l.nodes.iter().copied().collect()).collect();
    assert_eq!(loops, BTreeSet::from([BTreeSet::from([0, 1, 2]), BTreeSet::from([0, 3, 4])]));
    assert!(topology.loops().iter().all(|l| l.closed));
    assert_eq!(topology.outer_nodes(), [0, 3, 4]);
    assert_eq!(topology.inner_nodes(), [0, 1, 2]);
}
