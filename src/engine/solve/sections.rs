//! Cuts the nodes of a matrix into sections, which threads eliminate at once, and separators between them, which are
//! eliminated after them:
//!
//! ```text
//! node:           0 1 2 ...   section   ... | separator | ...   section   ... | separator | ...   section   ... n-1
//! eliminated:     --->                          last        <---        --->        last                       <---
//! ```
//! Each section is eliminated towards the separators beside it. For two sections this is the twisted factorisation of
//! van der Vorst (Parallel Computing 5, 1987), and an incomplete one needs no more iterations: the elimination still
//! goes through the net from its rim. In a section between two separators it begins in the middle, at nodes without
//! eliminated neighbours: then solves take more iterations, on taut nets of eight sections an eighth to a fifth. With
//! nodes numbered along a mesh (Cuthill-McKee) a separator is as wide as the mesh. The cut depends on the matrix alone,
//! so results do not depend on the number of threads.

use crate::assembly::Pattern;
use std::ops::Range;

/// Numbers of sections, each with the number of nodes from which on a net is cut into so many. To share few nodes would
/// take more time than it saves.
const SECTIONS: [(usize, usize); 2] = [(8, 262_144), (2, 4096)];
/// [-] largest share of the nodes in separators.
const WIDEST: f64 = 0.125;

/// Nodes that are eliminated one after another: a section or a separator. Its local vectors hold its own nodes, in the
/// order of their elimination, then those of the separators beside it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Subdomain {
    /// its nodes, a range
    pub own: Range<usize>,
    /// of a section: the nodes of the separators before and behind it
    pub beside: [Range<usize>; 2],
    /// Elimination goes from this node to the last one, then from the one before it to the first.
    pub start: usize,
}

impl Subdomain {
    /// Length of its local vectors.
    pub(super) fn n_local(&self) -> usize {
        self.local_separators()[1].end
    }

    /// Where local vectors hold the separators before and behind it.
    pub(super) fn local_separators(&self) -> [Range<usize>; 2] {
        let (own, [before, behind]) = (self.own.len(), &self.beside);
        let middle = own + before.len();
        [own..middle, middle..middle + behind.len()]
    }

    /// Local index of a node, if it has one.
    pub(super) fn local_index(&self, node: usize) -> Option<usize> {
        if self.own.contains(&node) {
            return Some(if node >= self.start { node - self.start } else { self.own.end - 1 - node });
        }
        let mut separators = self.beside.iter().zip(self.local_separators());
        separators.find_map(|(nodes, here)| nodes.contains(&node).then(|| here.start + node - nodes.start))
    }

    /// The node of a local index.
    #[inline(always)]
    pub(super) fn node(&self, place: usize) -> usize {
        let [before, behind] = self.local_separators();
        if place < self.own.end - self.start {
            self.start + place
        } else if place < before.start {
            self.own.end - 1 - place
        } else if place < before.end {
            self.beside[0].start + place - before.start
        } else {
            self.beside[1].start + place - behind.start
        }
    }
}

/// Sections and the separators between them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Cut {
    pub sections: Vec<Subdomain>,
    /// one less
    pub separators: Vec<Subdomain>,
}

impl Cut {
    /// Into as many sections as pay; `node` is the node of every unknown.
    pub(super) fn new(pattern: &Pattern, node: &[u32]) -> Self {
        let reach = reach(pattern, node);
        let nodes = reach.len();
        let pays = |separators: &Vec<Range<usize>>| {
            let all: usize = separators.iter().map(ExactSizeIterator::len).sum();
            // Beyond a section that is thin, a separator may be coupled to the next one.
            let apart =
                separators.windows(2).all(|pair| pair[0].end < pair[1].start && reach[pair[0].end - 1] < pair[1].start);
            apart && all as f64 <= WIDEST * nodes as f64
        };
        let numbers = SECTIONS.into_iter().filter(|&(_, least)| nodes >= least);
        let mut cuts =
            numbers.map(|(count, _)| (1..count).map(|i| separator(&reach, i * nodes / count)).collect::<Vec<_>>());
        Self::at(nodes, &cuts.find(pays).unwrap_or_default())
    }

    /// At separators in ascending order.
    pub(super) fn at(nodes: usize, separators: &[Range<usize>]) -> Self {
        let none = [nodes..nodes, nodes..nodes];
        let section = |i: usize| {
            let before = i.checked_sub(1).and_then(|i| separators.get(i)).cloned();
            let behind = separators.get(i).cloned();
            let own = before.clone().map_or(0, |range| range.end)..behind.clone().map_or(nodes, |range| range.start);
            let start = match (&before, &behind) {
                (Some(_), Some(_)) => own.start.midpoint(own.end),
                (Some(_), None) => own.end,
                (None, _) => own.start,
            };
            Subdomain { own, beside: [before, behind].map(|range| range.unwrap_or(nodes..nodes)), start }
        };
        let separator = |own: &Range<usize>| Subdomain { own: own.clone(), beside: none.clone(), start: own.start };
        Cut {
            sections: (0..=separators.len()).map(section).collect(),
            separators: separators.iter().map(separator).collect(),
        }
    }
}

/// The last node that each node, or one before it, is coupled to.
fn reach(pattern: &Pattern, node: &[u32]) -> Vec<usize> {
    let unknowns = |g: &[u32]| g[0] as usize..g[1] as usize;
    let last = |g: &[u32]| unknowns(g).filter_map(|u| pattern.column(u).last()).map(|&row| node[row as usize]).max();
    let nodes = pattern.node_start.windows(2).scan(0, |most, g| {
        *most = last(g).map_or(*most, |last| last.max(*most));
        Some(*most as usize)
    });
    nodes.collect()
}

/// The smallest range of nodes about the middle such that no node before it is coupled to one behind it.
fn separator(reach: &[usize], middle: usize) -> Range<usize> {
    let before = |end: usize| reach.partition_point(|&last| last < end).min(end)..end;
    before((middle + before(middle).len() / 2).min(reach.len()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A net, `width` nodes across, each with its neighbours ahead.
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

    fn cut(pattern: &Pattern) -> Cut {
        Cut::new(pattern, &pattern.node_of_unknown())
    }

    /// Sections have about one size and are not coupled, every node is in one subdomain, and separators are as wide as
    /// the net.
    #[test]
    fn separators_part_sections() {
        for (nodes, width, sections) in [(5000, 70, 2), (262_200, 200, 8)] {
            let pattern = net(nodes, width);
            let cut = cut(&pattern);
            assert_eq!([cut.sections.len(), cut.separators.len() + 1], [sections; 2]);
            let mut next = 0;
            for (i, section) in cut.sections.iter().enumerate() {
                assert!((section.own.len() * sections).abs_diff(nodes) <= sections * 2 * width, "{section:?}");
                assert_eq!((section.own.start, section.beside[1].start), (next, section.own.end), "{i}");
                next = section.own.end;
                let reach = section.own.clone().flat_map(|g| pattern.column(g)).max().map(|&reach| reach as usize);
                let Some(separator) = cut.separators.get(i) else { continue };
                assert!(reach < Some(separator.own.end), "{reach:?}");
                assert_eq!((&separator.own, separator.own.len()), (&section.beside[1], width + 1));
                assert_eq!(separator.own, cut.sections[i + 1].beside[0]);
                next = separator.own.end;
            }
            assert_eq!(next, nodes);
            for subdomain in cut.sections.iter().chain(&cut.separators) {
                let places = 0..subdomain.n_local();
                assert!(places.clone().all(|place| subdomain.local_index(subdomain.node(place)) == Some(place)));
                let others = (0..nodes).filter(|&node| subdomain.local_index(node).is_some()).count();
                assert_eq!(others, places.len());
            }
        }
    }

    /// The last node of a section to be eliminated is beside a separator; a section between two begins in its middle.
    #[test]
    fn sections_are_eliminated_towards_their_separators() {
        let order = |subdomain: &Subdomain| (0..subdomain.own.len()).map(|place| subdomain.node(place)).collect();
        let cut = Cut::at(12, &[3..4, 8..9]);
        let found: Vec<Vec<usize>> = cut.sections.iter().chain(&cut.separators).map(order).collect();
        assert_eq!(found, [vec![0, 1, 2], vec![6, 7, 5, 4], vec![11, 10, 9], vec![3], vec![8]]);
        assert_eq!(cut.sections[1].local_separators(), [4..5, 5..6]);
    }

    /// Two unconnected nets need no separator.
    #[test]
    fn a_separator_may_be_empty() {
        let mut pattern = net(5000, 1);
        let [middle, last] = [2499, 2500].map(|g| pattern.col_ptr[g] as usize);
        pattern.row_idx[middle..last].fill(2499);
        let [before, middle] = [2498, 2499].map(|g| pattern.col_ptr[g] as usize);
        pattern.row_idx[before..middle].iter_mut().for_each(|r| *r = (*r).min(2499));
        assert_eq!(cut(&pattern), Cut::at(5000, std::slice::from_ref(&(2500..2500))));
    }

    /// Small nets and wide nets are not divided, or only in two.
    #[test]
    fn what_a_cut_does_not_serve_is_left_whole() {
        for (nodes, width) in [(4095, 10), (5000, 4000), (5000, 900)] {
            assert_eq!(cut(&net(nodes, width)), Cut::at(nodes, &[]), "{nodes}, {width}");
        }
        assert_eq!(cut(&net(270_000, 6000)).sections.len(), 2);
    }

    /// A net is not cut at separators that are coupled to each other.
    #[test]
    fn separators_are_not_coupled() {
        let mut pattern = net(262_200, 200);
        let separators = cut(&pattern).separators;
        let last = pattern.col_ptr[separators[0].own.start + 1] as usize - 1;
        pattern.row_idx[last] = separators[1].own.start.midpoint(separators[1].own.end) as u32;
        assert_eq!(cut(&pattern).sections.len(), 2);
    }
}
