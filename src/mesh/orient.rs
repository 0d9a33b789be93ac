//! Turns triangles so that the normals of a sheet are all on one side.

use super::Mesh;
use super::sides::Sides;
use crate::format_number::first_few;

/// Turns triangles so that neighbours turn the same way, part by part. Of a part the larger number of triangles stay as
/// they are, and of equal numbers those with the first triangle. Edges of more than two triangles divide parts. Returns
/// a sentence for what was turned, and one for what cannot be.
pub(super) fn turn_alike(mesh: &mut Mesh) -> (Option<String>, Option<String>) {
    let sides = Sides::new(&mesh.triangles);
    let forward = |triangle: u32, [a, b]: [u32; 2]| {
        let t = mesh.triangles[triangle as usize];
        [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].contains(&[a, b])
    };
    // Whether each triangle is to be turned, once it is known.
    let mut turned: Vec<Option<bool>> = vec![None; mesh.triangles.len()];
    let mut twisted = Vec::new();
    let mut part = Vec::new();
    for first in 0..mesh.triangles.len() as u32 {
        if turned[first as usize].is_some() {
            continue;
        }
        turned[first as usize] = Some(false);
        part.clear();
        part.push(first);
        let mut at = 0;
        while let Some(&triangle) = part.get(at) {
            at += 1;
            for side in sides.of_triangle[triangle as usize] {
                let &[one, two] = sides.at(side as usize) else { continue };
                let (other, pair) = (if one == triangle { two } else { one }, sides.nodes[side as usize]);
                let alike = forward(one, pair) != forward(two, pair);
                // Alike neighbours are both turned or both not.
                let wanted = turned[triangle as usize] == Some(alike);
                match turned[other as usize] {
                    None => {
                        turned[other as usize] = Some(wanted);
                        part.push(other);
                    }
                    Some(known) if known != wanted && triangle < other => twisted.push(pair),
                    Some(_) => {}
                }
            }
        }
        let count = part.iter().filter(|t| turned[**t as usize] == Some(true)).count();
        if 2 * count > part.len() {
            part.iter().for_each(|t| turned[*t as usize] = turned[*t as usize].map(|turn| !turn));
        }
    }
    let listed: Vec<u32> = (0_u32..).zip(&turned).filter(|(_, turn)| **turn == Some(true)).map(|(t, _)| t).collect();
    listed.iter().for_each(|t| mesh.triangles[*t as usize].swap(1, 2));
    let turned = (!listed.is_empty()).then(|| {
        let count = listed.len();
        format!("{count} triangles were turned, so that normals are on one side: {}", first_few(&listed))
    });
    let told = twisted.first().map(|[a, b]| {
        let count = twisted.len();
        format!(
            "{count} edges lie between triangles that cannot be turned alike, as on a Moebius strip; the first is {a}-{b}"
        )
    });
    (turned, told)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Topology;

    fn strip(triangles: Vec<[u32; 3]>) -> Mesh {
        let nodes = (0..8).map(|i| [f64::from(i / 2), f64::from(i % 2), 0.1 * f64::from(i * i)]).collect();
        let edges = crate::topology::unique_edges(&triangles);
        Mesh { nodes, edges, triangles, ..Mesh::default() }
    }

    /// Each mixture of a strip becomes the strip; the majority decides the side.
    #[test]
    fn every_mixture_is_turned_alike() {
        let sound = vec![[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5], [4, 6, 5]];
        for mixture in 0_u32..32 {
            let mut mesh = strip(sound.clone());
            (0..5).filter(|t| mixture >> t & 1 == 1).for_each(|t| mesh.triangles[t].swap(1, 2));
            let (turned, twisted) = turn_alike(&mut mesh);
            let topology = Topology::new(&mesh).expect("a mesh");
            assert_eq!(topology.check_orientation(&mesh), Ok(()), "{mixture:05b}: {twisted:?}");
            assert_eq!(mesh.triangles == sound, mixture.count_ones() <= 2, "{mixture:05b}");
            let few = mixture.count_ones().min(5 - mixture.count_ones());
            assert_eq!(turned.map(|note| note.starts_with(&format!("{few} "))), (few > 0).then_some(true));
        }
    }

    /// A strip that is closed with half a turn has one edge that cannot be mended, and is told.
    #[test]
    fn a_moebius_strip_is_told() {
        let mut mesh = strip(vec![[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5], [4, 1, 5], [5, 1, 0]]);
        let (_, twisted) = turn_alike(&mut mesh);
        assert!(twisted.is_some_and(|note| note.contains("cannot be turned alike")));
    }
}
