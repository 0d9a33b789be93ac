//! The work space of force passes, and the parts of it, and of the sums over nodes, that one thread writes to for its strips.

use super::stride::Level;
use super::threads::SUMS;
use super::tiling::Tiling;
use super::window::Padded;
use crate::model::forces::Tally;
use crate::model::stride::NodeSums;
use glam::DVec3;
use std::ops::Range;

/// Kept from pass to pass.
#[derive(Debug, Default)]
pub(super) struct Room {
    /// what each sum gets beyond the strips' ends
    pub beyond: [Vec<Padded>; SUMS],
    /// of the pass
    terms: usize,
    tiles: usize,
    /// level after level, tile after tile, term after term
    tallies: Vec<Tally>,
    /// [-] largest l^2/l0^2 of springs, level after level, tile after tile
    stretches: Vec<f64>,
    /// level after level, strip after strip
    pub nodes: Vec<NodeSums>,
    pub levels: Vec<Level>,
    /// forces of the still terms, tile after tile, where they are kept
    kept: Vec<Padded>,
}

/// What passes need.
#[derive(Clone, Copy, Debug)]
pub(super) struct Needs {
    pub terms: usize,
    pub levels: usize,
    /// whether forces of still terms are kept
    pub keeps: bool,
}

/// Some strips and where their sums go.
pub(super) struct Part<'a> {
    pub strips: Range<usize>,
    pub out: [&'a mut [DVec3]; SUMS],
    pub beyond: [&'a mut [Padded]; SUMS],
    pub tallies: &'a mut [Tally],
    pub stretches: &'a mut [f64],
    /// empty where nothing is kept
    pub kept: &'a mut [Padded],
}

impl Room {
    /// Makes room for passes into sums of these sizes. All levels are at their beginning.
    pub fn fit(&mut self, tiling: &Tiling, Needs { terms, levels, keeps }: Needs, out: &[&mut [DVec3]; SUMS]) {
        for (beyond, _) in self.beyond.iter_mut().zip(out).filter(|(_, out)| !out.is_empty()) {
            beyond.resize(tiling.beyond().len(), Padded::default());
        }
        (self.terms, self.tiles) = (terms, tiling.tiles().len());
        self.tallies.resize(levels * self.tiles * terms, Tally::default());
        self.stretches.resize(levels * self.tiles, f64::NEG_INFINITY);
        self.nodes.resize(levels * tiling.strips().len(), NodeSums::default());
        self.levels.clear();
        self.levels.resize(levels, Level::default());
        if keeps {
            self.kept.resize(tiling.records_of(0..self.tiles).len(), Padded::default());
        }
    }

    /// The places of some strips, in one of the levels.
    pub fn part<'a>(
        &'a mut self,
        tiling: &Tiling,
        (level, strips): (usize, Range<usize>),
        out: &'a mut [&mut [DVec3]; SUMS],
    ) -> Part<'a> {
        let (nodes, tiles) = (tiling.nodes_of(strips.clone()), tiling.tiles_of(strips.clone()));
        let beyond = tiling.beyond_of(tiles.clone());
        let of_level = level * self.tiles * self.terms;
        Part {
            out: out.each_mut().map(|out| if out.is_empty() { &mut **out } else { &mut out[nodes.clone()] }),
            beyond: self.beyond.each_mut().map(|sums| sums.get_mut(beyond.clone()).unwrap_or_default()),
            tallies: &mut self.tallies[of_level..][tiles.start * self.terms..tiles.end * self.terms],
            kept: self.kept.get_mut(tiling.records_of(tiles.clone())).unwrap_or_default(),
            stretches: &mut self.stretches[level * self.tiles..][tiles],
            strips,
        }
    }

    /// Adds up energies and powers of every term, tile after tile, in one of the levels.
    pub fn add_up(&self, level: usize, tallies: &mut [Tally]) {
        tallies.fill(Tally::default());
        let size = self.tiles * self.terms;
        for by_tile in self.tallies[level * size..][..size].chunks(self.terms.max(1)) {
            tallies.iter_mut().zip(by_tile).for_each(|(total, tally)| *total += *tally);
        }
    }

    /// What the nodes are like in one of the levels, strip after strip.
    pub fn node_sums(&self, level: usize) -> NodeSums {
        let strips = self.nodes.len() / self.levels.len().max(1);
        self.nodes[level * strips..][..strips].iter().fold(NodeSums::default(), |sums, next| sums.and(*next))
    }

    /// [-] The largest stretch in one of the levels.
    pub fn largest_stretch(&self, level: usize) -> f64 {
        self.stretches[level * self.tiles..][..self.tiles].iter().copied().fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Part<'_> {
    /// The strips before one, and the others.
    pub fn split(self, tiling: &Tiling, at: usize) -> [Self; 2] {
        let Part { strips, out, beyond, tallies, stretches, kept } = self;
        let (before, after) = (strips.start..at, at..strips.end);
        let (tiles, terms) = (tiling.tiles_of(before.clone()), tallies.len() / stretches.len().max(1));
        let (out, out_after) = halves(out, tiling.nodes_of(before.clone()).len());
        let (beyond, beyond_after) = halves(beyond, tiling.beyond_of(tiles.clone()).len());
        let (tallies, tallies_after) = tallies.split_at_mut(terms * tiles.len());
        let (stretches, stretches_after) = stretches.split_at_mut(tiles.len());
        let (kept, kept_after) = kept.split_at_mut(tiling.records_of(tiles.clone()).len().min(kept.len()));
        [
            Part { strips: before, out, beyond, tallies, stretches, kept },
            Part {
                strips: after,
                out: out_after,
                beyond: beyond_after,
                tallies: tallies_after,
                stretches: stretches_after,
                kept: kept_after,
            },
        ]
    }
}

/// What comes before a place and what comes after; nothing of what is empty.
fn halves<T>(slices: [&mut [T]; SUMS], at: usize) -> ([&mut [T]; SUMS], [&mut [T]; SUMS]) {
    let [a, b, c] = slices.map(|slice| slice.split_at_mut(at.min(slice.len())));
    ([a.0, b.0, c.0], [a.1, b.1, c.1])
}
