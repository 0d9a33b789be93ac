//! Pieces that close no ring: each is moved and turned until it fits the piece before along their seams.

use super::Stitch;
use super::place::{Pieces, Placed};
use crate::Mesh;
use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};
use std::collections::{BTreeMap, HashSet};

/// [-] Weight of lying side by side, over that of nodes that meet. Pieces whose seams go around them, as front and back
/// of a pillow, lie on each other.
const SIDE_BY_SIDE: f64 = 3e-3;
/// [-] Distance over the length of an edge by which pieces on each other start apart, so that pressure finds a volume.
const LIFT: f64 = 0.02;

/// Places the pieces one by one; the first stays as it is drawn.
pub(super) fn fit(mesh: &Mesh, pieces: &Pieces, part: &[&Stitch], placed: &mut Placed) {
    let normals = normals(mesh, pieces);
    let normal = |piece: u32| normals.get(&piece).copied().unwrap_or(Vector3::z());
    let first = part.iter().flat_map(|stitch| &stitch.sides).map(|side| side.piece).min().unwrap_or_default();
    let mut moved = BTreeMap::from([(first, Isometry3::<f64>::identity())]);
    let mut lifted: BTreeMap<u32, Vector3<f64>> = BTreeMap::new();
    // Each round places at least one of the pieces, which hang together.
    while let Some((before, next)) = part.iter().find_map(|stitch| neighbours(stitch, &moved)) {
        let motion = moved[&before];
        let pairs: Vec<[Vector3<f64>; 2]> = part
            .iter()
            .flat_map(|stitch| {
                let order = [0, 1].map(|i| stitch.sides[i].piece);
                let pairs = stitch.pairs().filter_map(move |[a, b]| match order {
                    [x, y] if [x, y] == [before, next] => Some([a, b]),
                    [x, y] if [y, x] == [before, next] => Some([b, a]),
                    _ => None,
                });
                pairs.map(|[to, from]| [moved_by(motion, mesh.point(to)), mesh.point(from)])
            })
            .collect();
        let alike = part.iter().find(|stitch| neighbours(stitch, &moved) == Some((before, next)));
        let sign =
            if alike.is_some_and(|stitch| stitch.sides[0].forward == stitch.sides[1].forward) { -1.0 } else { 1.0 };
        let up = motion * normal(before);
        let motion = best(&pairs, [sign * up, normal(next)]);
        if (motion * normal(next)).dot(&up) * sign < 0.0 {
            lifted.entry(before).or_insert(up);
            lifted.insert(next, -up);
        }
        moved.insert(next, motion);
    }
    let on_seams: HashSet<u32> = part.iter().flat_map(|stitch| stitch.pairs()).flatten().collect();
    let edges = part.iter().map(|stitch| stitch.sides[0].nodes.len() - 1).sum::<usize>();
    let length: f64 = part.iter().map(|stitch| stitch.sides[0].length).sum();
    for (piece, motion) in moved {
        let up = lifted.get(&piece).map_or(Vector3::zeros(), |up| up * (LIFT * length / edges as f64));
        for &node in pieces.of_piece(piece) {
            let apart = if on_seams.contains(&node) { Vector3::zeros() } else { up };
            placed.at[node as usize] = moved_by(motion, mesh.point(node)) + apart;
        }
    }
}

fn moved_by(motion: Isometry3<f64>, place: Vector3<f64>) -> Vector3<f64> {
    motion.rotation * place + motion.translation.vector
}

/// The placed one of two pieces, and the other one.
fn neighbours(stitch: &Stitch, moved: &BTreeMap<u32, Isometry3<f64>>) -> Option<(u32, u32)> {
    let [a, b] = [0, 1].map(|i| stitch.sides[i].piece);
    match [a, b].map(|piece| moved.contains_key(&piece)) {
        [true, false] => Some((a, b)),
        [false, true] => Some((b, a)),
        _ => None,
    }
}

/// The unit normal of each piece as it is drawn.
fn normals(mesh: &Mesh, pieces: &Pieces) -> BTreeMap<u32, Vector3<f64>> {
    let mut of_node = vec![0; mesh.nodes.len()];
    for (piece, nodes) in &pieces.nodes {
        nodes.iter().for_each(|node| of_node[*node as usize] = *piece);
    }
    let mut sums: BTreeMap<u32, Vector3<f64>> = BTreeMap::new();
    for &[a, b, c] in &mesh.triangles {
        let area = (mesh.point(b) - mesh.point(a)).cross(&(mesh.point(c) - mesh.point(a)));
        *sums.entry(of_node[a as usize]).or_default() += area;
    }
    sums.into_iter().map(|(piece, sum)| (piece, sum.try_normalize(0.0).unwrap_or(Vector3::z()))).collect()
}

/// The motion that brings the second of all pairs nearest to the first ones (Kabsch 1976), and one normal to the other
/// where that is left open.
fn best(pairs: &[[Vector3<f64>; 2]], [up, normal]: [Vector3<f64>; 2]) -> Isometry3<f64> {
    let mean = |i: usize| pairs.iter().map(|pair| pair[i]).sum::<Vector3<f64>>() / pairs.len().max(1) as f64;
    let [to, from] = [0, 1].map(mean);
    let spread: f64 = pairs.iter().map(|pair| (pair[1] - from).norm_squared()).sum();
    let guide = SIDE_BY_SIDE * spread * normal * up.transpose();
    let sum = pairs.iter().map(|[p, q]| (q - from) * (p - to).transpose()).sum::<Matrix3<f64>>() + guide;
    let svd = sum.svd(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Isometry3::identity() };
    let turn = v_t.transpose() * u.transpose();
    let handed = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, turn.determinant().signum()));
    let turn = Rotation3::from_matrix_unchecked(v_t.transpose() * handed * u.transpose());
    Isometry3::from_parts(Translation3::from(to - turn * from), UnitQuaternion::from_rotation_matrix(&turn))
}
