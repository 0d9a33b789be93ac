//! The work space of force passes, and the parts of it, and of the sums over nodes, that one thread writes to for its
//! strips.

use crate::force::kernel::local_buffer::Padded;
use crate::force::schedule::partition::Tiling;
use crate::force::schedule::threads::SUMS;
use crate::force::schedule::wavefront::Fronts;
use crate::model::forces::Tally;
use crate::model::stride::NodeSums;
use glam::DVec3;
use std::ops::Range;

/// Kept from pass to pass.
#[derive(Debug, Default)]
pub(in crate::force) struct Room {
    /// what each sum gets beyond the strips' ends
    beyond: [Vec<Padded>; SUMS],
    /// of the pass
    terms: usize,
    levels: usize,
    /// tile after tile, level after level, term after term
    tallies: Vec<Tally>,
    /// [-] largest l^2/l0^2 of springs, tile after tile, level after level
    stretches: Vec<f64>,
    /// strip after strip, level after level
    nodes: Vec<NodeSums>,
    /// forces of the still terms, tile after tile, where they are kept
    kept: Vec<Padded>,
    /// by node, where they are kept
    aside: [Vec<DVec3>; ASIDE],
    pub fronts: Fronts,
}

/// What passes need.
#[derive(Clone, Copy, Debug)]
pub(in crate::force) struct Needs {
    pub terms: usize,
    pub levels: usize,
    /// that may go over several levels side by side
    pub threads: usize,
    /// whether forces of still terms are kept
    pub keeps: bool,
    /// which nodal vectors are kept
    pub aside: [bool; ASIDE],
}

impl Needs {
    /// Of a single pass.
    pub fn of_a_pass(terms: usize) -> Self {
        Needs { terms, levels: 1, threads: 1, keeps: false, aside: [false; ASIDE] }
    }
}

/// Nodal vectors that are kept within a step: positions [m] at its start, kicked velocities [m/s].
pub(in crate::force) const ASIDE: usize = 2;

/// Some strips and where their sums go, those of all levels.
pub(in crate::force) struct Part<'a> {
    pub strips: Range<usize>,
    pub out: [&'a mut [DVec3]; SUMS],
    pub beyond: [&'a mut [Padded]; SUMS],
    pub tallies: &'a mut [Tally],
    pub stretches: &'a mut [f64],
    pub nodes: &'a mut [NodeSums],
    /// empty where nothing is kept
    pub kept: &'a mut [Padded],
    pub aside: [&'a mut [DVec3]; ASIDE],
    pub levels: usize,
}

impl Room {
    /// Makes room for passes into sums of these sizes, with fronts at their beginning.
    pub fn fit(&mut self, tiling: &Tiling, needs: Needs, out: &[&mut [DVec3]; SUMS]) {
        let Needs { terms, levels, threads, keeps, aside } = needs;
        for (beyond, _) in self.beyond.iter_mut().zip(out).filter(|(_, out)| !out.is_empty()) {
            beyond.resize(tiling.beyond().len(), Padded::default());
        }
        let tiles = tiling.tiles().len();
        (self.terms, self.levels) = (terms, levels);
        self.tallies.resize(tiles * levels * terms, Tally::default());
        self.stretches.resize(tiles * levels, f64::NEG_INFINITY);
        self.nodes.resize(tiling.strips().len() * levels, NodeSums::default());
        self.fronts.plan(tiling, levels, threads);
        if keeps {
            self.kept.resize(tiling.records_of(0..tiles).len(), Padded::default());
        }
        for (vector, _) in self.aside.iter_mut().zip(aside).filter(|(_, kept)| *kept) {
            vector.resize(tiling.nodes_of(tiling.strips()).len(), DVec3::ZERO);
        }
    }

    /// All strips, and the fronts.
    pub fn parts<'a>(&'a mut self, tiling: &Tiling, out: [&'a mut [DVec3]; SUMS]) -> (Part<'a>, &'a mut Fronts) {
        let Room { beyond, tallies, stretches, nodes, kept, aside, fronts, levels, .. } = self;
        let (beyond, strips) = (beyond.each_mut().map(Vec::as_mut_slice), tiling.strips());
        let aside = aside.each_mut().map(Vec::as_mut_slice);
        (Part { strips, out, beyond, tallies, stretches, nodes, kept, aside, levels: *levels }, fronts)
    }

    /// Adds up energies and powers of every term, tile after tile, in one of the levels.
    pub fn add_up(&self, level: usize, tallies: &mut [Tally]) {
        tallies.fill(Tally::default());
        let terms = self.terms.max(1);
        for by_tile in self.tallies.chunks(terms).skip(level).step_by(self.levels) {
            tallies.iter_mut().zip(by_tile).for_each(|(total, tally)| *total += *tally);
        }
    }

    /// What the nodes are like in one of the levels, strip after strip.
    pub fn node_sums(&self, level: usize) -> NodeSums {
        let of_level = self.nodes.iter().skip(level).step_by(self.levels);
        of_level.fold(NodeSums::default(), |sums, next| sums.and(*next))
    }

    /// [-] The largest stretch in one of the levels.
    pub fn largest_stretch(&self, level: usize) -> f64 {
        self.stretches.iter().skip(level).step_by(self.levels).copied().fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Part<'_> {
    /// Some of the strips.
    pub fn within(&mut self, tiling: &Tiling, strips: Range<usize>) -> Part<'_> {
        let all = Part {
            strips: self.strips.clone(),
            out: self.out.each_mut().map(|out| &mut **out),
            beyond: self.beyond.each_mut().map(|beyond| &mut **beyond),
            tallies: self.tallies,
            stretches: self.stretches,
            nodes: self.nodes,
            kept: self.kept,
            aside: self.aside.each_mut().map(|vector| &mut **vector),
            levels: self.levels,
        };
        let [_, from] = all.split(tiling, strips.start);
        let [within, _] = from.split(tiling, strips.end);
        within
    }

    /// The strips before one, and the others.
    pub fn split(self, tiling: &Tiling, at: usize) -> [Self; 2] {
        let Part { strips, out, beyond, tallies, stretches, nodes, kept, aside, levels } = self;
        let (before, after) = (strips.start..at, at..strips.end);
        let (tiles, terms) = (tiling.tiles_of(before.clone()), tallies.len() / stretches.len().max(1));
        let (out, out_after) = halves(out, tiling.nodes_of(before.clone()).len());
        let (beyond, beyond_after) = halves(beyond, tiling.beyond_of(tiles.clone()).len());
        let (tallies, tallies_after) = tallies.split_at_mut(tiles.len() * levels * terms);
        let (stretches, stretches_after) = stretches.split_at_mut(tiles.len() * levels);
        let (nodes, nodes_after) = nodes.split_at_mut(before.len() * levels);
        let (aside, aside_after) = halves(aside, tiling.nodes_of(before.clone()).len());
        let (kept, kept_after) = kept.split_at_mut(tiling.records_of(tiles.clone()).len().min(kept.len()));
        [
            Part { strips: before, out, beyond, tallies, stretches, nodes, kept, aside, levels },
            Part {
                strips: after,
                out: out_after,
                beyond: beyond_after,
                tallies: tallies_after,
                stretches: stretches_after,
                nodes: nodes_after,
                kept: kept_after,
                aside: aside_after,
                levels,
            },
        ]
    }
}

/// What comes before a place and what comes after; nothing of what is empty.
fn halves<T, const N: usize>(slices: [&mut [T]; N], at: usize) -> ([&mut [T]; N], [&mut [T]; N]) {
    let mut halves = slices.map(|slice| slice.split_at_mut(at.min(slice.len())));
    (halves.each_mut().map(|(before, _)| std::mem::take(before)), halves.map(|(_, after)| after))
}
