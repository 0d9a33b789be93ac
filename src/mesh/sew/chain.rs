//! Sides of pieces as chains of boundary edges, and which nodes of two sides meet.

use super::{Seam, SewError, Sewing};
use crate::Mesh;
use crate::components::components;
use crate::format_number::first_few;
use std::collections::{BTreeMap, HashMap};

/// [-] Difference of two lengths up to which sides are sewn without being eased.
const ALIKE: f64 = 0.01;
/// [-] Share of its shortest edge by which the nodes of a side may be off those of the other one.
const NEAR: f64 = 0.25;

/// A side of a piece.
#[derive(Clone, Debug)]
pub(crate) struct Chain {
    /// name of its group
    pub name: String,
    /// nodes in their order
    pub nodes: Vec<u32>,
    /// [-] arc length of each node over the whole, from 0 to 1
    pub part: Vec<f64>,
    /// [m]
    pub length: f64,
    /// the piece by its smallest node
    pub piece: u32,
    /// whether the order is that of the triangles, with the piece on the left
    pub forward: bool,
}

impl Chain {
    fn new(mesh: &Mesh, name: &str, nodes: Vec<u32>, piece: u32) -> Self {
        let mut at = 0.0;
        let steps = nodes.windows(2).map(|pair| (mesh.point(pair[0]) - mesh.point(pair[1])).norm());
        let mut part: Vec<f64> = std::iter::once(0.0)
            .chain(steps.map(|step| {
                at += step;
                at
            }))
            .collect();
        part.iter_mut().for_each(|s| *s /= at);
        Chain { name: name.to_owned(), nodes, part, length: at, piece, forward: true }
    }

    /// The same in the other order.
    pub(super) fn turn(&mut self) {
        self.nodes.reverse();
        self.part.reverse();
        self.part.iter_mut().for_each(|s| *s = 1.0 - *s);
        self.forward = !self.forward;
    }

    /// [-] The shortest edge over the whole length.
    fn shortest(&self) -> f64 {
        self.part.windows(2).map(|pair| pair[1] - pair[0]).fold(1.0, f64::min)
    }
}

/// Two sides that are sewn; their nodes meet in this order.
#[derive(Clone, Debug)]
pub(crate) struct Stitch {
    pub sides: [Chain; 2],
    /// the rule that asks for it
    pub rule: usize,
}

impl Stitch {
    fn new(mut sides: [Chain; 2], rule: usize, seam: &Seam) -> Result<Self, SewError> {
        // Seen from above, neighbours go along their common side in opposite directions.
        if !seam.reverse {
            sides[1].turn();
        }
        let [first, second] = [0, 1].map(|i| sides[i].name.clone());
        if sides[0].piece == sides[1].piece {
            return Err(SewError::OntoItself { first, second });
        }
        let stitch = Stitch { sides, rule };
        let lengths = [0, 1].map(|i| stitch.sides[i].length);
        let excess = stitch.excess();
        if excess > ALIKE && !seam.ease {
            return Err(SewError::Lengths { first, second, lengths, excess });
        }
        let [a, b] = &stitch.sides;
        let off = a.part.iter().zip(&b.part).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        if a.nodes.len() != b.nodes.len() || off > NEAR * a.shortest().min(b.shortest()) {
            return Err(SewError::Nodes { first, second, nodes: [a.nodes.len(), b.nodes.len()] });
        }
        Ok(stitch)
    }

    /// [-] The longer side over the shorter one, less 1.
    fn excess(&self) -> f64 {
        let [a, b] = &self.sides;
        a.length.max(b.length) / a.length.min(b.length) - 1.0
    }

    /// A sentence about a seam whose sides are not alike.
    pub(super) fn eased(&self) -> Option<String> {
        let [a, b] = &self.sides;
        let excess = self.excess();
        (excess > ALIKE).then(|| {
            format!(
                "sides \"{}\" and \"{}\" of {:.6} and {:.6} m were eased: the longer one has {:.1} % more",
                a.name,
                b.name,
                a.length,
                b.length,
                100.0 * excess
            )
        })
    }

    /// The pairs of nodes that meet.
    pub(super) fn pairs(&self) -> impl Iterator<Item = [u32; 2]> {
        let [a, b] = &self.sides;
        a.nodes.iter().zip(&b.nodes).map(|(a, b)| [*a, *b])
    }
}

/// The seams of a mesh.
pub(super) fn stitches(mesh: &Mesh, seams: &[Seam], sewing: &Sewing) -> Result<Vec<Stitch>, SewError> {
    let sides = Sides::of(mesh);
    let mut stitches = Vec::with_capacity(sewing.sides.len());
    for ([first, second], rule) in &sewing.sides {
        let pair = if first == second {
            sides.chains(first)?.try_into().map_err(|found: Vec<Chain>| no_chain(first, &found, 2))?
        } else {
            [sides.chain(first)?, sides.chain(second)?]
        };
        stitches.push(Stitch::new(pair, *rule, &seams[*rule])?);
    }
    let mut seen: HashMap<[u32; 2], &str> = HashMap::new();
    for chain in stitches.iter().flat_map(|stitch| &stitch.sides) {
        for pair in chain.nodes.windows(2) {
            if let Some(first) = seen.insert([pair[0].min(pair[1]), pair[0].max(pair[1])], &chain.name) {
                return Err(SewError::Overlap { first: first.to_owned(), second: chain.name.clone() });
            }
        }
    }
    Ok(stitches)
}

fn no_chain(name: &str, found: &[Chain], wanted: usize) -> SewError {
    let found = format!("{} chain{}", found.len(), if found.len() == 1 { "" } else { "s" });
    SewError::NoChain { name: name.to_owned(), found, wanted }
}

/// What chains are found by.
struct Sides<'a> {
    mesh: &'a Mesh,
    /// triangles at every side in the direction in which they go along it
    triangles: HashMap<[u32; 2], usize>,
    /// by node, the smallest one of its piece
    piece: Vec<u32>,
}

impl<'a> Sides<'a> {
    fn of(mesh: &'a Mesh) -> Self {
        let mut triangles = HashMap::new();
        for &[a, b, c] in &mesh.triangles {
            for side in [[a, b], [b, c], [c, a]] {
                *triangles.entry(side).or_insert(0) += 1;
            }
        }
        let across = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [a, c]]);
        Sides { mesh, triangles, piece: components(mesh.nodes.len(), across) }
    }

    fn at(&self, side: [u32; 2]) -> usize {
        self.triangles.get(&side).copied().unwrap_or(0)
    }

    /// The one chain of a group.
    fn chain(&self, name: &str) -> Result<Chain, SewError> {
        let mut chains = self.chains(name)?;
        match (chains.pop(), chains.is_empty()) {
            (Some(chain), true) => Ok(chain),
            (last, _) => Err(no_chain(name, &chains.into_iter().chain(last).collect::<Vec<_>>(), 1)),
        }
    }

    /// The chains of a group, in the direction of the triangles.
    fn chains(&self, name: &str) -> Result<Vec<Chain>, SewError> {
        let with_edges = || self.mesh.groups.iter().filter(|(_, group)| !group.edges.is_empty());
        let group = self.mesh.groups.get(name).filter(|group| !group.edges.is_empty()).ok_or_else(|| {
            let known: Vec<&str> = with_edges().map(|(name, _)| name.as_str()).collect();
            let known = if known.is_empty() { "no groups of edges".to_owned() } else { first_few(&known) };
            SewError::NoSide { name: name.to_owned(), known }
        })?;
        let mut next = BTreeMap::new();
        let mut into = HashMap::new();
        for &[a, b] in group.edges.iter().filter_map(|&edge| self.mesh.edges.get(edge as usize)) {
            let (from, to) = match [self.at([a, b]), self.at([b, a])] {
                [1, 0] => (a, b),
                [0, 1] => (b, a),
                [one, other] => {
                    return Err(SewError::NoBoundary { name: name.to_owned(), a, b, triangles: one + other });
                }
            };
            if next.insert(from, to).is_some() || into.insert(to, from).is_some() {
                let found = format!("a net that branches at a node of the edge {a}-{b}");
                return Err(SewError::NoChain { name: name.to_owned(), found, wanted: 1 });
            }
        }
        let mut chains = Vec::new();
        let starts: Vec<u32> = next.keys().filter(|node| !into.contains_key(node)).copied().collect();
        for start in starts {
            let mut nodes = vec![start];
            while let Some(to) = nodes.last().and_then(|node| next.remove(node)) {
                nodes.push(to);
            }
            chains.push(Chain::new(self.mesh, name, nodes, self.piece[start as usize]));
        }
        match next.is_empty() {
            true => Ok(chains),
            false => Err(SewError::NoChain { name: name.to_owned(), found: "a closed loop".to_owned(), wanted: 1 }),
        }
    }
}
