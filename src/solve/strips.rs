//! How a matrix's nodes are cut into two halves that two threads eliminate at once, each from its end towards the seam
//! between them, which comes last:
//!
//! ```text
//! node:           0 1 2 ...  first half  ... | seam | ...  second half  ... n-1
//! eliminated:     --->                         last                        <---
//! ```
//! This is the twisted factorisation of van der Vorst (Parallel Computing 5, 1987). An incomplete one loses nothing by
//! it, as each node still meets what has been eliminated beside it only: at a million nodes, a second half that went
//! away from the seam took 1.6 times the iterations. Nodes numbered along a mesh (Cuthill-McKee) have seams as wide as
//! the mesh. The cut depends on the matrix alone, and so results do not depend on the number of threads.

use crate::assembly::Pattern;
use std::ops::Range;

/// [nodes] below which there is no cut: so few do not outweigh a hand-over.
const LEAST: usize = 4096;
/// [-] of all nodes that a seam may have.
const WIDEST: f64 = 0.125;

/// Nodes that are eliminated one after another, a half or the seam; vectors hold their own, and then those of the seam
/// beside them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Strip {
    /// its nodes
    pub own: Range<usize>,
    /// of a half: the nodes of the seam
    pub seam: Range<usize>,
    /// whether it begins with its last node
    pub backwards: bool,
}

impl Strip {
    /// Number of places in its vectors.
    pub fn places(&self) -> usize {
        self.own.len() + self.seam.len()
    }

    /// Where a node stands in its vectors.
    pub fn place(&self, node: usize) -> Option<usize> {
        if self.own.contains(&node) {
            Some(if self.backwards { self.own.end - 1 - node } else { node - self.own.start })
        } else {
            self.seam.contains(&node).then(|| self.own.len() + node - self.seam.start)
        }
    }

    /// The node at a place.
    #[inline(always)]
    pub fn node(&self, place: usize) -> usize {
        if place >= self.own.len() {
            self.seam.start + place - self.own.len()
        } else if self.backwards {
            self.own.end - 1 - place
        } else {
            self.own.start + place
        }
    }
}

/// Both halves and the seam between them; all in the first half where a cut would not serve.
pub(super) fn cut(pattern: &Pattern, node: &[u32]) -> [Strip; 3] {
    let nodes = pattern.node_start.len() - 1;
    let whole = nodes..nodes;
    let seam = if nodes < LEAST { whole.clone() } else { seam(pattern, node, nodes / 2) };
    strips(nodes, if seam.len() as f64 <= WIDEST * nodes as f64 { seam } else { whole })
}

/// The halves beside a seam, and it.
pub(super) fn strips(nodes: usize, seam: Range<usize>) -> [Strip; 3] {
    let strip = |own, seam, backwards| Strip { own, seam, backwards };
    [
        strip(0..seam.start, seam.clone(), false),
        strip(seam.end..nodes, seam.clone(), true),
        strip(seam, nodes..nodes, false),
    ]
}

/// Nodes about a middle one with which none before them has to do with any behind.
fn seam(pattern: &Pattern, node: &[u32], middle: usize) -> Range<usize> {
    let last = |g: usize| {
        let unknowns = pattern.node_start[g] as usize..pattern.node_start[g + 1] as usize;
        unknowns.filter_map(|u| pattern.column(u).last()).map(|&row| node[row as usize] as usize).max()
    };
    let before = |end: usize| (0..end).find(|&g| last(g) >= Some(end)).unwrap_or(end)..end;
    before(middle + before(middle).len() / 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A strip of a net, `width` nodes across, each with its neighbours ahead.
    fn net(nodes: usize, width: usize) -> Pattern {
        let ahead = |g: usize| [0, 1, width, width + 1].map(|d| g + d).into_iter().filter(move |&r| r < nodes);
        let rows = |g| ahead(g).map(|r| r as u32);
        let starts = (0..nodes).scan(0, |end, g| {
            *end += rows(g).count() as u32;
            Some(*end)
        });
        Pattern {
            col_ptr: std::iter::once(0).chain(starts).collect(),
            row_idx: (0..nodes).flat_map(rows).collect(),
            symmetric: true,
            dof: (0..nodes as u32).map(|g| 3 * g).collect(),
            node_start: (0..=nodes as u32).collect(),
            position: vec![[0.0; 3]; nodes],
        }
    }

    /// Halves of a size have nothing to do with each other, every node has its place, and the seam is as wide as the
    /// net.
    #[test]
    fn a_seam_parts_two_halves() {
        let (nodes, width) = (5000, 70);
        let pattern = net(nodes, width);
        let [first, second, seam] = cut(&pattern, &pattern.node_of_unknown());
        assert_eq!(seam.own.len(), width + 1);
        assert_eq!(first.seam, seam.own);
        assert_eq!([first.own.end, second.own.end], [seam.own.start, nodes]);
        assert!(first.own.len().abs_diff(second.own.len()) <= 1, "{first:?} {second:?}");
        let reach = first.own.clone().flat_map(|g| pattern.column(g)).max();
        assert!(reach.is_some_and(|&reach| (reach as usize) < second.own.start), "{reach:?}");
        for strip in [&first, &second, &seam] {
            assert!((0..strip.places()).all(|place| strip.place(strip.node(place)) == Some(place)));
            let ascending = strip.node(0) < strip.node(1);
            assert_eq!(ascending, !strip.backwards, "halves go towards the seam");
        }
        assert_eq!((first.place(nodes - 1), second.place(nodes - 1)), (None, Some(0)));
    }

    /// Nets that do not meet need no seam between them.
    #[test]
    fn a_seam_may_be_empty() {
        let mut pattern = net(5000, 1);
        let [middle, last] = [2499, 2500].map(|g| pattern.col_ptr[g] as usize);
        pattern.row_idx[middle..last].fill(2499);
        let [before, middle] = [2498, 2499].map(|g| pattern.col_ptr[g] as usize);
        pattern.row_idx[before..middle].iter_mut().for_each(|r| *r = (*r).min(2499));
        assert_eq!(cut(&pattern, &pattern.node_of_unknown()), strips(5000, 2500..2500));
    }

    /// Few nodes, and wide nets, are left in one piece.
    #[test]
    fn what_a_cut_does_not_serve_is_left_whole() {
        for (nodes, width) in [(LEAST - 1, 10), (5000, 4000), (5000, 900)] {
            let pattern = net(nodes, width);
            assert_eq!(cut(&pattern, &pattern.node_of_unknown()), strips(nodes, nodes..nodes), "{nodes}, {width}");
        }
    }
}
