//! What joins a gap: the pairs of its nodes, and the distance that joins all of them.

use super::COINCIDENT;
use super::gaps::Beside;
use crate::Mesh;
use crate::components::components;
use crate::format_number::{counted, figures};
use crate::read::{extent, joined};
use crate::warning::{Warning, WarningCode};

/// Places where cloth is open along a seam.
#[derive(Clone, Debug, Default)]
pub struct Gaps {
    /// number of nodes that would be joined to others
    pub nodes: usize,
    /// the pair that is farthest apart, and its distance [m]
    pub widest: Option<([u32; 2], f64)>,
    /// [m] smallest distance found that joins all of them, and the number of edges that it would close too
    pub merge: Option<(f64, usize)>,
    /// [m] distance within which nodes coincide
    coincident: f64,
    /// nodes beside the middle of an edge
    beside: Vec<Beside>,
    /// [m] where the first of them is, or the widest pair
    place: [f64; 3],
}

impl Gaps {
    pub(super) fn new(mesh: &Mesh, pairs: &[[u32; 2]], beside: &[Beside]) -> Self {
        let coincident = COINCIDENT * extent(&mesh.nodes);
        let mut gaps = Gaps { coincident, beside: beside.to_vec(), ..Gaps::default() };
        let widest = beside.iter().copied().reduce(|most, one| if one.away > most.away { one } else { most });
        gaps.place = widest.map_or([0.0; 3], |beside| mesh.nodes[beside.node as usize]);
        if pairs.is_empty() {
            return gaps;
        }
        let away = |[a, b]: [u32; 2]| (mesh.point(a) - mesh.point(b)).norm();
        let of_cluster = components(mesh.nodes.len(), pairs.iter().copied());
        let members = || (0_u32..).zip(&of_cluster).filter(|(node, first)| node != *first);
        gaps.nodes = members().count();
        let widest = pairs.iter().map(|pair| (*pair, away(*pair)));
        gaps.widest = widest.reduce(|most, one| if one.1 > most.1 { one } else { most });
        gaps.place = gaps.widest.map_or(gaps.place, |([a, _], _)| mesh.nodes[a as usize]);
        let reach = members().map(|(node, first)| away([node, *first])).fold(0.0, f64::max);
        let mut distance = if reach > 0.0 { two_digits_up(1.02 * reach) } else { 0.0 };
        // A node on the way may be joined to another one first.
        for _ in 0..6 {
            let kept = joined(&mesh.nodes, distance);
            if members().all(|(node, first)| kept[node as usize] == kept[*first as usize]) {
                let closed = |[a, b]: &&[u32; 2]| kept[*a as usize] == kept[*b as usize];
                gaps.merge = Some((distance, mesh.edges.iter().filter(closed).count()));
                break;
            }
            distance = two_digits_up(1.3 * distance);
        }
        gaps
    }

    /// A warning, unless all its nodes are at the same place; those have a warning of their own.
    pub fn warning(&self) -> Option<Warning> {
        let wide = self.widest.is_some_and(|(_, away)| away > self.coincident);
        let text = self.text().filter(|_| wide || !self.beside.is_empty())?;
        Some(Warning::new(WarningCode::SeamGap, text))
    }

    /// What to do about all of them.
    pub fn text(&self) -> Option<String> {
        let parts: Vec<String> = self.of_pairs().into_iter().chain(self.of_edges()).collect();
        (!parts.is_empty()).then(|| parts.join("; "))
    }

    fn of_pairs(&self) -> Option<String> {
        let ([a, b], away) = self.widest?;
        let [x, y, z] = self.place.map(|x| figures(x, 5));
        let place = match away > 0.0 {
            true => {
                let widest = two_digits_up(away);
                format!(
                    "at most {widest:.1e} from another without being joined, such as node {a} at ({x}, {y}, {z}) and node {b}"
                )
            }
            false => "at the place of another without being joined".to_owned(),
        };
        let advice = match self.merge {
            Some((distance, closed)) => {
                let distance = if distance > 0.0 { format!("{distance:.1e}") } else { "0".to_owned() };
                let all = if away > 0.0 { ", joins all of them" } else { "" };
                let more = match closed {
                    0 => String::new(),
                    1 => ", and the ends of one edge that is as short".to_owned(),
                    n => format!(", and the ends of {n} edges that are as short"),
                };
                format!("--merge {distance} (after --scale), or \"merge\" in a case{all}{more}")
            }
            None => "give both sides the same nodes".to_owned(),
        };
        let nodes = counted(self.nodes as u64, "node lies", "nodes lie");
        Some(format!("{nodes} {place}: {advice}"))
    }

    fn of_edges(&self) -> Option<String> {
        let widest = self.beside.iter().copied().reduce(|most, one| if one.away > most.away { one } else { most })?;
        let Beside { node, edge: [a, b], away } = widest;
        let place = match self.widest {
            Some(_) => String::new(),
            None => {
                let [x, y, z] = self.place.map(|x| figures(x, 5));
                format!(" at ({x}, {y}, {z})")
            }
        };
        Some(format!(
            "the cloth is open along a seam: {} at most {:.1e} beside an edge without being joined to it, such as node \
             {node}{place} beside the edge {a}-{b}: give both sides the same nodes, since \"merge\" joins nodes only",
            counted(self.beside.len() as u64, "node lies", "nodes lie"),
            two_digits_up(away)
        ))
    }
}

/// A positive number rounded up to two digits.
fn two_digits_up(x: f64) -> f64 {
    let unit = 10_f64.powf(x.log10().floor() - 1.0);
    let rounded = (x / unit * (1.0 - 1e-12)).ceil() * unit;
    // By way of text, so that it is exactly the number that is printed.
    format!("{rounded:.1e}").parse().unwrap_or(x)
}
