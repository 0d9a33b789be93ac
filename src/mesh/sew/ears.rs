//! Edges across a piece that would meet an edge of another piece: both join the same two nodes of seams, as where two
//! corners with one triangle each are sewn to each other.

use super::Stitch;
use crate::Mesh;
use crate::components::components;
use crate::sides::Sides;
use nalgebra::Vector3;
use std::collections::HashSet;

/// Turns such edges, all but one, to the other diagonal of their two triangles.
pub(super) fn turn_edges(mesh: &mut Mesh, stitches: &[Stitch]) {
    let same = components(mesh.nodes.len(), stitches.iter().flat_map(Stitch::pairs));
    let key = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let chains = stitches.iter().flat_map(|stitch| &stitch.sides);
    let on_seams: HashSet<[u32; 2]> =
        chains.flat_map(|chain| chain.nodes.windows(2)).map(|pair| key([pair[0], pair[1]])).collect();
    let joined = |pair: &[u32; 2]| key(pair.map(|node| same[node as usize]));
    let mut seen: HashSet<[u32; 2]> = on_seams.iter().map(joined).collect();
    let sides = Sides::new(&mesh.triangles);
    for edge in 0..mesh.edges.len() {
        let pair = mesh.edges[edge];
        if on_seams.contains(&key(pair)) || seen.insert(joined(&pair)) {
            continue;
        }
        if let Some(&[first, second]) = sides.find(pair).map(|side| sides.at(side))
            && let Some((across, triangles)) = turned(mesh, pair, [first, second])
        {
            mesh.edges[edge] = across;
            [mesh.triangles[first as usize], mesh.triangles[second as usize]] = triangles;
            seen.insert(joined(&across));
        }
    }
}

/// The other diagonal of two triangles with a common side, and the triangles at it, if they are as one with a convex
/// outline.
fn turned(mesh: &Mesh, [a, b]: [u32; 2], pair: [u32; 2]) -> Option<([u32; 2], [[u32; 3]; 2])> {
    let [one, two] = pair.map(|triangle| mesh.triangles[triangle as usize]);
    let tip = |t: [u32; 3]| t.into_iter().find(|node| *node != a && *node != b);
    let holds = |t: [u32; 3]| t.contains(&a) && t.contains(&b);
    let (c, d) = (tip(one)?, tip(two)?);
    if !holds(one) || !holds(two) {
        return None;
    }
    let along = [[one[0], one[1]], [one[1], one[2]], [one[2], one[0]]].contains(&[a, b]);
    let (a, b) = if along { (a, b) } else { (b, a) };
    let normal = |[a, b, c]: [u32; 3]| -> Vector3<f64> {
        (mesh.point(b) - mesh.point(a)).cross(&(mesh.point(c) - mesh.point(a)))
    };
    let (up, made) = (normal(one), [[a, d, c], [d, b, c]]);
    let sound = made.iter().all(|t| normal(*t).dot(&up) > 1e-6 * up.norm_squared());
    sound.then_some(([c, d], made))
}
