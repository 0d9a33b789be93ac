//! Cuts the nodes of a matrix into two halves that two threads eliminate at once, each from its end towards the
//! separator between them, which is eliminated last:
//!
//! ```text
//! node:           0 1 2 ...  first half  ... | separator | ...  second half  ... n-1
//! eliminated:     --->                         last                        <---
//! ```
//! This is the twisted factorisation of van der Vorst (Parallel Computing 5, 1987). An incomplete one needs no more
//! iterations, as each node still meets only eliminated neighbours. At a million nodes, a second half eliminated away
//! from the separator took 1.6 times the iterations. With nodes numbered along a mesh (Cuthill-McKee) the separator is
//! as wide as the mesh. The cut depends on the matrix alone, so results do not depend on the number of threads.

use crate::assembly::Pattern;
use std::ops::Range;

/// Nodes below which there is no cut: two threads would cost more than they save.
const LEAST: usize = 4096;
/// [-] largest share of the nodes in the separator.
const WIDEST: f64 = 0.125;

/// Nodes that are eliminated one after another: a half or the separator. Its local vectors hold its own nodes, then
/// those of the separator beside it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Subdomain {
    /// its nodes, a range
    pub own: Range<usize>,
    /// of a half: the nodes of the separator
    pub separator: Range<usize>,
    /// whether elimination starts at the last node
    pub backwards: bool,
}

impl Subdomain {
    /// Length of its local vectors.
    pub(super) fn n_local(&self) -> usize {
        self.own.len() + self.separator.len()
    }

    /// Local index of a node, if it has one.
    pub(super) fn local_index(&self, node: usize) -> Option<usize> {
        if self.own.contains(&node) {
            Some(if self.backwards { self.own.end - 1 - node } else { node - self.own.start })
        } else {
            self.separator.contains(&node).then(|| self.own.len() + node - self.separator.start)
        }
    }

    /// The node of a local index.
    #[inline(always)]
    pub(super) fn node(&self, place: usize) -> usize {
        if place >= self.own.len() {
            self.separator.start + place - self.own.len()
        } else if self.backwards {
            self.own.end - 1 - place
        } else {
            self.own.start + place
        }
    }
}

/// Both halves and the separator. All nodes are in the first half if a cut does not pay.
pub(super) fn cut(pattern: &Pattern, node: &[u32]) -> [Subdomain; 3] {
    let nodes = pattern.node_start.len() - 1;
    let whole = nodes..nodes;
    let separator = if nodes < LEAST { whole.clone() } else { separator(pattern, node, nodes / 2) };
    subdomains(nodes, if separator.len() as f64 <= WIDEST * nodes as f64 { separator } else { whole })
}

/// Both halves beside a separator, and the separator.
pub(super) fn subdomains(nodes: usize, separator: Range<usize>) -> [Subdomain; 3] {
    let subdomain = |own, separator, backwards| Subdomain { own, separator, backwards };
    [
        subdomain(0..separator.start, separator.clone(), false),
        subdomain(separator.end..nodes, separator.clone(), true),
        subdomain(separator, nodes..nodes, false),
    ]
}

/// The smallest range of nodes about the middle such that no node before it is coupled to one behind it.
fn separator(pattern: &Pattern, node: &[u32], middle: usize) -> Range<usize> {
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

    /// A subdomain of a net, `width` nodes across, each with its neighbours ahead.
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

    /// Two equal halves are not coupled, every node is in one subdomain, and the separator is as wide as the net.
    #[test]
    fn a_seam_parts_two_halves() {
        let (nodes, width) = (5000, 70);
        let pattern = net(nodes, width);
        let [first, second, separator] = cut(&pattern, &pattern.node_of_unknown());
        assert_eq!(separator.own.len(), width + 1);
        assert_eq!(first.separator, separator.own);
        assert_eq!([first.own.end, second.own.end], [separator.own.start, nodes]);
        assert!(first.own.len().abs_diff(second.own.len()) <= 1, "{first:?} {second:?}");
        let reach = first.own.clone().flat_map(|g| pattern.column(g)).max();
        assert!(reach.is_some_and(|&reach| (reach as usize) < second.own.start), "{reach:?}");
        for subdomain in [&first, &second, &separator] {
            assert!((0..subdomain.n_local()).all(|place| subdomain.local_index(subdomain.node(place)) == Some(place)));
            let ascending = subdomain.node(0) < subdomain.node(1);
            assert_eq!(ascending, !subdomain.backwards, "halves go towards the separator");
        }
        assert_eq!((first.local_index(nodes - 1), second.local_index(nodes - 1)), (None, Some(0)));
    }

    /// Two unconnected nets need no separator.
    #[test]
    fn a_seam_may_be_empty() {
        let mut pattern = net(5000, 1);
        let [middle, last] = [2499, 2500].map(|g| pattern.col_ptr[g] as usize);
        pattern.row_idx[middle..last].fill(2499);
        let [before, middle] = [2498, 2499].map(|g| pattern.col_ptr[g] as usize);
        pattern.row_idx[before..middle].iter_mut().for_each(|r| *r = (*r).min(2499));
        assert_eq!(cut(&pattern, &pattern.node_of_unknown()), subdomains(5000, 2500..2500));
    }

    /// Small nets and wide nets are not divided.
    #[test]
    fn what_a_cut_does_not_serve_is_left_whole() {
        for (nodes, width) in [(LEAST - 1, 10), (5000, 4000), (5000, 900)] {
            let pattern = net(nodes, width);
            assert_eq!(cut(&pattern, &pattern.node_of_unknown()), subdomains(nodes, nodes..nodes), "{nodes}, {width}");
        }
    }
}
