use super::*;
use crate::topology::unique_edges;
use std::f64::consts::TAU;

type Parts = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// A sheet of two triangles a cell, its corners placed by their shares along both sides.
fn sheet([columns, rows]: [u32; 2], place: impl Fn(f64, f64) -> [f64; 3]) -> Parts {
    let at = |i: u32, j: u32| i * (rows + 1) + j;
    let share = |i: u32, n: u32| f64::from(i) / f64::from(n);
    let nodes = (0..=columns).flat_map(|i| (0..=rows).map(move |j| (i, j)));
    let nodes = nodes.map(|(i, j)| place(share(i, columns), share(j, rows))).collect();
    let cells = (0..columns).flat_map(|i| (0..rows).map(move |j| (i, j)));
    let halves = |(i, j)| [[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]];
    (nodes, cells.flat_map(halves).collect())
}

fn together(parts: impl IntoIterator<Item = Parts>) -> Mesh {
    let (mut nodes, mut triangles) = (Vec::new(), Vec::new());
    for (more, further) in parts {
        let first: u32 = nodes.len() as u32;
        nodes.extend(more);
        triangles.extend(further.into_iter().map(|t: [u32; 3]| t.map(|node| node + first)));
    }
    Mesh { edges: unique_edges(&triangles), nodes, triangles, ..Mesh::default() }
}

fn topology(mesh: &Mesh) -> Topology {
    let found = mesh.check();
    assert!(found.is_ok(), "{found:?}");
    Topology::of_checked(mesh)
}

fn of(mesh: &Mesh) -> Look {
    look(mesh, &topology(mesh), &[])
}

/// All that is told, by code.
fn codes(mesh: &Mesh) -> Vec<String> {
    let Look { gaps, others } = of(mesh);
    gaps.warning().into_iter().chain(others).map(|warning| warning.code.to_string()).collect()
}

fn flat(u: f64, v: f64) -> [f64; 3] {
    [u, v, 0.0]
}

/// Twelve gores of a canopy 2 m across, each moved outwards by a distance [m]; every second one has its own rows.
fn gores(away: f64, rows: [u32; 2]) -> Mesh {
    together((0..12).map(|gore| {
        let middle = TAU * (f64::from(gore) + 0.5) / 12.0;
        sheet([rows[gore as usize % 2], 2], move |u, v| {
            let (r, angle) = (0.15 + 0.85 * u, middle + TAU * (v - 0.5) / 12.0);
            let [x, y] = [r * angle.cos() + away * middle.cos(), r * angle.sin() + away * middle.sin()];
            [x, y, -0.35 * r * r]
        })
    }))
}

/// Gores apart by 5e-6 to 3e-3 of the extent have a gap of 84 nodes, and the distance that is told joins them all.
#[test]
fn gores_that_are_apart_are_joined_as_told() {
    for share in [5e-6, 1e-4, 1e-3, 3e-3] {
        let mesh = gores(4.0 * share, [6, 6]);
        let gaps = of(&mesh).gaps;
        assert_eq!(gaps.nodes, 84, "{share}");
        let (_, away) = gaps.widest.unwrap_or_default();
        assert!((away / (8.0 * share * (TAU / 24.0).sin()) - 1.0).abs() < 1e-6, "{away}");
        let (distance, closed) = gaps.merge.unwrap_or_default();
        let kept = crate::read::joined(&mesh.nodes, distance);
        let joined = (0_u32..).zip(&kept).filter(|(node, kept)| node != *kept).count();
        assert_eq!((joined, closed), (84, 0), "{share}: {distance}");
    }
    assert_eq!(codes(&gores(4e-2, [6, 6])), [""; 0]);
}

/// Neither a short edge elsewhere, nor one in the seam, hides a gap.
#[test]
fn a_short_edge_hides_no_gap() {
    let right = |v: f64| if v == 0.1 { 0.01 } else { v };
    let mesh = together([
        sheet([10, 10], |u, v| [u, right(v), 0.0]),
        sheet([10, 10], |u, v| [1.002 + u, right(v), 0.0]),
        sheet([1, 1], |u, v| [5.0 + 1e-5 * u, 1e-5 * v, 0.0]),
    ]);
    let gaps = of(&mesh).gaps;
    assert_eq!(gaps.nodes, 11);
    assert!(gaps.text().unwrap_or_default().contains("--merge 2.1e-3"), "{:?}", gaps.text());
}

/// Seams whose sides have nodes of their own are told as such, curved or straight, however narrow.
#[test]
fn sides_with_other_nodes_are_open() {
    for away in [1e-5, 1e-3, 4e-3] {
        let curve = |u: f64| 0.3 * (3.0 * u).sin();
        let upper = sheet([17, 6], |u, v| [u, curve(u) + away + v, 0.0]);
        let curved = together([sheet([12, 6], |u, v| [u, curve(u) - 1.0 + v, 0.0]), upper]);
        for mesh in [curved, gores(away, [6, 9])] {
            let text = of(&mesh).gaps.text().unwrap_or_default();
            assert!(
                text.contains("the cloth is open along a seam") && text.contains("merge\" joins nodes only"),
                "{text}"
            );
        }
    }
}

/// A cut inside a sheet, whose ends hold.
#[test]
fn a_tear_is_seen() {
    let (mut nodes, mut triangles) = sheet([20, 20], flat);
    let at = |j: usize| (10 * 21 + j) as u32;
    for j in 5..16 {
        let new = nodes.len() as u32;
        nodes.push([0.502, j as f64 / 20.0, 0.0]);
        for t in triangles.iter_mut().filter(|t| t.iter().any(|n| *n / 21 == 11 && *n < 441)) {
            t.iter_mut().filter(|n| **n == at(j)).for_each(|n| *n = new);
        }
    }
    let mesh = together([(nodes, triangles)]);
    assert_eq!((of(&mesh).gaps.nodes, codes(&mesh)), (11, vec!["seam-gap".to_owned()]));
}

/// What only looks like a gap: layers, also shifted and curved; slots and a notch in fine cloth; ribbons; a chamfer;
/// sheets that meet at a right angle; graded cloth.
#[test]
fn layers_slots_and_notches_are_no_gaps() {
    let dome = |u: f64, v: f64| 0.8 * u * (1.0 - u) * v * (1.0 - v);
    let ring = |r: [f64; 2], n: [u32; 2]| {
        sheet(n, move |u, v| {
            let (r, angle) = (r[0] + (r[1] - r[0]) * u, 0.9 * TAU * v);
            [r * angle.cos(), r * angle.sin(), 0.0]
        })
    };
    let mut clean = vec![
        ("slot of coarse cloth", together([ring([0.2, 0.49], [3, 24]), ring([0.51, 1.0], [3, 24])])),
        ("slot of fine cloth", together([ring([0.4, 0.498], [20, 900]), ring([0.5035, 0.6], [20, 900])])),
        ("ribbons", together((0..9).map(|k| sheet([40, 1], move |u, v| [u, 0.03 * f64::from(k) + 0.02 * v, 0.0])))),
        ("narrow ribbon", together([sheet([40, 1], |u, v| [u, 0.002 * v, 0.0])])),
        ("right angle", together([sheet([9, 9], flat), sheet([9, 9], |u, v| [u, 0.0, -0.05 - v])])),
        ("two parts", together([sheet([9, 9], flat), sheet([2, 2], |u, v| [3.0 + u, v, 0.0])])),
        ("graded", together([sheet([30, 30], |u, v| [u.powi(4), v.powi(4), 0.0])])),
    ];
    for away in [1e-4, 1e-3, 3e-3, 1e-2] {
        clean.push(("layers", together([sheet([20, 20], flat), sheet([20, 20], |u, v| [u, v, away])])));
        clean.push(("other layers", together([sheet([20, 20], flat), sheet([17, 23], |u, v| [u, v, away])])));
        let curved = |up: f64| sheet([20, 20], move |u, v| [u, v, dome(u, v) + up]);
        clean.push(("curved layers", together([curved(0.0), curved(away)])));
    }
    for degrees in [3.0_f64, 5.0, 30.0] {
        let open = degrees.to_radians();
        let (nodes, triangles) = sheet([80, 180], |u, v| {
            let angle = open / 2.0 + (TAU - open) * v;
            [u * angle.cos(), u * angle.sin(), 0.0]
        });
        // The nodes of the first column are the middle.
        let number = |node: u32| node.saturating_sub(180);
        let triangles =
            triangles.into_iter().map(|t| t.map(number)).filter(|t| t[0] != t[1] && t[1] != t[2] && t[0] != t[2]);
        clean.push(("notch", together([(nodes[180..].to_vec(), triangles.collect())])));
    }
    for (what, mesh) in &clean {
        assert_eq!(codes(mesh), [""; 0], "{what}: {:?} {:?}", of(mesh).gaps.text(), of(mesh).others);
    }
}

/// Triangles on triangles: sheets that overlap, one triangle of new or of old nodes over a sheet, and a fold.
#[test]
fn double_cloth_is_seen() {
    let square = || sheet([6, 6], flat);
    let shifted = sheet([6, 6], |u, v| [0.7 + u, 0.13 + v, 0.0]);
    let single = (vec![[0.31, 0.32, 0.0], [0.72, 0.33, 0.0], [0.5, 0.8, 0.0]], vec![[0, 1, 2]]);
    let (nodes, mut triangles) = square();
    triangles.push([0, 17, 30]);
    let own = together([(nodes, triangles)]);
    let (mut nodes, triangles) = square();
    nodes[24] = [0.9, 0.5, 0.0];
    let folded = together([(nodes, triangles)]);
    for mesh in [together([square(), shifted]), together([square(), single]), own, folded] {
        let found = codes(&mesh);
        assert!(found.contains(&"overlapping-triangles".to_owned()), "{found:?}");
    }
}

/// A triangle beside a large sheet; a missing face, two, and a missing node; a vent of as many nodes as its skirt.
#[test]
fn strays_and_small_holes_are_seen() {
    let large = || sheet([20, 20], flat);
    let lost = (vec![[2.0, 2.0, 0.0], [2.05, 2.0, 0.0], [2.0, 2.05, 0.0]], vec![[0, 1, 2]]);
    assert_eq!(codes(&together([large(), lost])), ["stray-triangles"]);
    let without = |gone: &dyn Fn(usize, &[u32; 3]) -> bool| {
        let (nodes, triangles) = large();
        let kept = triangles.into_iter().enumerate().filter(|(i, t)| !gone(*i, t)).map(|(_, t)| t);
        together([(nodes, kept.collect())])
    };
    assert_eq!(codes(&without(&|i, _| i == 417)), ["small-hole"]);
    assert_eq!(codes(&without(&|i, _| i == 416 || i == 417)), ["small-hole"]);
    assert_eq!(codes(&without(&|_, t| t.contains(&220))), ["small-hole"]);
    let (nodes, triangles) = sheet([4, 6], |u, v| {
        let (r, angle) = (0.1 + u, TAU * v);
        [r * angle.cos(), r * angle.sin(), 0.0]
    });
    let around = |node: u32| if node % 7 == 6 { node - 6 } else { node };
    let mut mesh = together([(nodes, triangles.into_iter().map(|t| t.map(around)).collect())]);
    mesh.edges = unique_edges(&mesh.triangles);
    assert_eq!(codes(&mesh), [""; 0]);
}

/// A line that ends in a face, on an edge, near a node, at a node, and in the air.
#[test]
fn ends_of_lines_beside_nodes_are_seen() {
    for (x, y, z, code) in [
        (0.30, 0.47, 0.0, Some("hanging-node")),
        (0.25, 0.5, 0.0, Some("hanging-node")),
        (0.25, 0.0, 0.0, Some("hanging-node")),
        (0.5005, 0.5, 0.0, Some("seam-gap")),
        (0.5, 0.5, -0.1, None),
    ] {
        let mut mesh = together([sheet([6, 6], flat)]);
        let end = mesh.nodes.len() as u32;
        mesh.nodes.extend([[x, y, z], [0.5, 0.5, -1.0]]);
        mesh.edges.push([end, end + 1]);
        assert_eq!(codes(&mesh), code.into_iter().collect::<Vec<_>>(), "{x}, {y}, {z}");
    }
}

/// Thousands of triangles with corners at one place are looked at within the bound.
#[test]
fn a_heap_at_one_place_ends() {
    let fan = (0..10_000).map(|i| {
        let angle = |k: u32| TAU * f64::from(k) / 10_000.0;
        let at = |k: u32| [angle(k).cos(), angle(k).sin(), 0.0];
        (vec![[0.0; 3], at(i), at(i + 1)], vec![[0, 1, 2]])
    });
    let began = crate::process::thread_seconds();
    assert!(of(&together(fan)).gaps.nodes > 0);
    let spent = crate::process::thread_seconds().zip(began).map_or(0.0, |(now, then)| now - then);
    assert!(spent < 20.0, "{spent} s");
}

/// A canopy of 8 m in other units, and canopies that open along an axis.
#[test]
fn units_and_axes_are_guessed() {
    for (extent, scales) in [
        (8.0, &[][..]),
        (26.2, &[]),
        (0.5, &[]),
        (315.0, &["--scale 0.0254", "inches, 8 m across"]),
        (800.0, &["--scale 0.01", "centimetres, 8 m across"]),
        (8000.0, &["--scale 0.001", "millimetres, 8 m across"]),
        (262.0, &["--scale 0.3048", "feet, 79.9 m across"]),
        (0.008, &["--scale 1000", "kilometres, 8 m across"]),
    ] {
        let text = units(extent).unwrap_or_default();
        assert_eq!(text.is_empty(), scales.is_empty(), "{text}");
        assert!(scales.iter().all(|scale| text.contains(scale)), "{text}");
    }
    let dome = |turn: &dyn Fn([f64; 3]) -> [f64; 3]| {
        let mut mesh = gores(0.0, [6, 6]);
        mesh.nodes.iter_mut().for_each(|x| *x = turn(*x));
        // One sheet of them, as a file has it.
        let kept = crate::read::joined(&mesh.nodes, 1e-9);
        let triangles: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.map(|n| kept[n as usize])).collect();
        Mesh { edges: unique_edges(&triangles), triangles, ..mesh }
    };
    let mut rigged = dome(&|[x, y, z]| [x, z, -y]);
    rigged.nodes.push([0.0, -3.0, 0.0]);
    let confluence = rigged.nodes.len() as u32 - 1;
    let ends = [23, 119, 215].map(|triangle| rigged.triangles[triangle][0]);
    rigged.edges.extend(ends.map(|node| [node, confluence]));
    let along_y = |mesh: &Mesh| canopy_along_y(mesh, &topology(mesh));
    assert!(!along_y(&dome(&|x| x)));
    assert!(along_y(&dome(&|[x, y, z]| [x, z, -y])));
    assert!(along_y(&rigged));
    assert!(!along_y(&dome(&|[x, y, z]| [z, x, y])));
    assert!(!along_y(&together([sheet([6, 6], |u, v| [u, 0.0, v])])));
    assert!(!along_y(&together([sheet([6, 6], flat)])));
}
